#!/usr/bin/env python3
"""Measures again what values.txt, plane.txt and surfaces.txt hold: asks the installed povray and rewrites the numbers below each entry.

Entries are lines `kind: source`; add one and run this. Needs povray and povray-includes (Debian) and netpbm (pngtopnm).
"""
import os, re, shutil, subprocess, tempfile

HERE = os.path.dirname(os.path.abspath(__file__))


def read(name):
    lines = [l.rstrip("\n") for l in open(os.path.join(HERE, name))]
    head = [l for l in lines if l.startswith("#")]
    return head, [tuple(l.split(": ", 1)) for l in lines if ": " in l and not l.startswith("#")]


def povray(folder, scene, *options):
    with open(os.path.join(folder, "t.pov"), "w") as f:
        f.write(scene)
    subprocess.run(["povray", "+It.pov", "+GDout.txt", "-D", "-A", "-P", *options], cwd=folder, check=True, capture_output=True)


def values(folder):
    head, entries = read("values.txt")
    points = [s.split() for k, s in entries if k == "at"]
    scene = ["#version 3.7;", "global_settings { assumed_gamma 1 }", "camera { location -z }"]
    scene += [s for k, s in entries if k == "declare"]
    for n, (k, s) in enumerate(entries):
        if k in ("pattern", "pigment"):
            scene.append(f"#declare F{n} = function {{ {k} {{ {s} }} }}")
        elif k == "function":
            scene.append(f"#declare F{n} = function {{ {s} }}")
        elif k != "value":
            continue
        for p in points:
            call = re.sub(r"\b[XYZ]\b", lambda m: f"({p['XYZ'.index(m.group())]})", s) if k == "value" else f"F{n}({','.join(p)})"
            if k == "pigment":
                parts = ',"/",'.join(f"str(C.{c},0,6)" for c in ("red", "green", "blue", "filter", "transmit"))
                scene.append(f'#declare C = {call}; #debug concat("{n} ",{parts},"\\n")')
            else:
                scene.append(f'#debug concat("{n} ",str({call},0,12),"\\n")')
    povray(folder, "\n".join(scene) + "\n", "+W4", "+H4")
    found = {}
    for l in open(os.path.join(folder, "out.txt")):
        w = l.split()
        if w:
            found.setdefault(int(w[0]), []).append(" ".join(w[1:]))
    with open(os.path.join(HERE, "values.txt"), "w") as f:
        f.write("\n".join(head) + "\n")
        for n, (k, s) in enumerate(entries):
            f.write(f"{k}: {s}\n")
            if n in found:
                f.write("  " + " ".join(found[n]) + "\n")


def plane(folder):
    head, entries = read("plane.txt")
    numbers = [l.strip() for l in open(os.path.join(HERE, "plane.txt")) if l.startswith("  ")]
    points = [[p.split()[:2] for p in l.split("; ")] for l in numbers]
    scene = ["#version 3.7;", "global_settings { assumed_gamma 1 }", "camera { location -z }"]
    for n, (_, s) in enumerate(entries):
        scene.append(f"#declare F{n} = function {{ pigment {{ {s} color_map {{ [0 rgb 0] [1 rgb 1] }} }} }}")
        scene += [f'#debug concat("{n} ",str(F{n}({x},0,{z}).red,0,7),"\\n")' for x, z in points[n]]
    povray(folder, "\n".join(scene) + "\n", "+W4", "+H4")
    found = {}
    for l in open(os.path.join(folder, "out.txt")):
        w = l.split()
        if w:
            found.setdefault(int(w[0]), []).append(w[1])
    with open(os.path.join(HERE, "plane.txt"), "w") as f:
        f.write("\n".join(head) + "\n")
        for n, (k, s) in enumerate(entries):
            f.write(f"{k}: {s}\n  " + "; ".join(f"{x} {z} {v}" for (x, z), v in zip(points[n], found[n])) + "\n")


def surfaces(folder):
    head, entries = read("surfaces.txt")
    pixels = [tuple(map(int, s.split())) for k, s in entries if k == "pixel"]
    out = ["\n".join(head)] + [f"pixel: {x} {y}" for x, y in pixels]
    for k, s in entries:
        if k == "pixel":
            continue
        cover = f"pigment {{ rgb 1 }} normal {{ {s} }} finish {{ F }}" if k == "normal" else s
        scene = f'#include "scene.inc"\n#macro Cover() {cover} #end\nSubjects()\n'
        povray(folder, scene, "+W40", "+H30", "+Oo.png", "+FN16", "File_Gamma=1")
        data = subprocess.run(["pngtopnm", os.path.join(folder, "o.png")], check=True, capture_output=True).stdout
        body = data.split(b"\n", 3)[3]
        at = lambda x, y, c: int.from_bytes(body[((y * 40 + x) * 3 + c) * 2 :][:2], "big")
        out += [f"{k}: {s}", "  " + "; ".join(" ".join(str(at(x, y, c)) for c in range(3)) for x, y in pixels)]
    with open(os.path.join(HERE, "surfaces.txt"), "w") as f:
        f.write("\n".join(out) + "\n")


with tempfile.TemporaryDirectory() as folder:
    for name in os.listdir(HERE):
        if not name.endswith((".txt", ".py")):
            shutil.copy(os.path.join(HERE, name), folder)
    values(folder)
    plane(folder)
    surfaces(folder)
