#!/usr/bin/env python3
"""Where a render's CPU time goes, scene by scene, as docs/speed.md and docs/path.md show it.

  benches/profile.py --binary target/debug/rayloom [--rate 997] [--largest N] -- render SCENE --threads 1 ...
  benches/profile.py --binary target/debug/rayloom --list FILE [--at 320x240] [--more "--integrator path --spp 16"]

Runs the program under `perf record`, looks the samples up with `llvm-addr2line -i` (builds carry lines), and gives each to the room of the code that
the innermost function of ours belongs to; vector arithmetic, generic iterators and the like count for whoever called them. --list has a scene a line.
--largest tells the N largest functions as well. Prints a Markdown row a scene: per cent of the samples. Needs Linux, perf and llvm-addr2line.
"""
import argparse
import collections
import os
import re
import shlex
import subprocess
import sys
import tempfile

# Where a source file belongs; the first that fits.
ROOMS = [
    (r"src/(accel/|kernel/(merged|traverse|any_hit|shadow_blocker)|kernel/intersect/(mesh|triangle|mod)|math/(simd|ray|bounds))", "trees, faces"),
    (r"src/kernel/(intersect/|csg|inside|hits?\b)|src/math/(roots|bernstein|complex)", "primitives, CSG"),
    (r"src/kernel/function|src/kernel/program", "functions"),
    (r"src/kernel/(pattern|texture|normal|image|pigment|noise)|src/math/(noise|lattice)|src/integrate/classic/texturing", "textures, noise"),
    (r"src/integrate/path/lights|src/integrate/(classic|path)/(lights|shadow|area_packet|shafts|emitters)", "lights"),
    (r"src/kernel/bsdf|src/integrate/path/(closure|principled|shader|surface|pov|subsurface)|src/integrate/classic/(shade|refract|principled)", "materials"),
    (r"src/math/(random|sobol)|src/integrate/(path/sampler|samples)", "random numbers"),
    (r"src/integrate/(path/volume|classic/media)", "media"),
    (r"src/kernel/camera|src/integrate/(path/(camera|filter|adaptive)|antialias|classic/pixel)|src/film", "camera, film"),
    (r"src/integrate/", "paths, rays"),
    (r"src/(import|lang|compile|scene)/|src/accel/\w+_build|/gltf|/image|/png|/zune|/jpeg|/exr|/flate2|/miniz|/serde", "reading, building"),
    (r"src/", "rest"),
]
# Not rooms: they count for their callers.
THROUGH = re.compile(r"src/math/(mod|transform|color|statistics)\.rs|/glam|/core/src|/alloc/src|/std/src|stdarch|/rayon|/arrayvec|/bytemuck")
COLUMNS = ["trees, faces", "primitives, CSG", "functions", "textures, noise", "lights", "materials", "random numbers", "media", "camera, film",
           "paths, rays", "reading, building", "libraries", "rest"]


def samples(binary, command, rate):
    """How often each address of the binary was seen, and how often another file's."""
    with tempfile.TemporaryDirectory() as folder:
        data = os.path.join(folder, "perf.data")
        # Without address randomisation the program begins where /proc says it does, the same every time.
        run = ["setarch", "-R", "perf", "record", "-q", "-e", "cpu-clock:u", "-F", str(rate), "-o", data, "--", binary, *command]
        ended = subprocess.run(run, capture_output=True, text=True)
        if ended.returncode != 0:
            sys.exit(f"{shlex.join(run)}: {(ended.stderr or ended.stdout).strip().splitlines()[-1:]}")
        told = subprocess.run(["perf", "script", "-i", data, "-F", "ip,dso", "--show-mmap-events"], capture_output=True, text=True).stdout
    base, own, others = None, collections.Counter(), 0
    name = os.path.basename(binary)
    for line in told.splitlines():
        mapped = re.search(r"PERF_RECORD_MMAP2? .*\[(0x[0-9a-f]+)\(\S+\) @ (0x[0-9a-f]+|0) .*r-xp (\S+)", line)
        if mapped:
            if mapped[3].endswith("/" + name):
                base = int(mapped[1], 16) - int(mapped[2], 16)
            continue
        sample = re.match(r"\s*([0-9a-f]+)\s+\((.*)\)", line)
        if sample and os.path.basename(sample[2]) == name:
            own[int(sample[1], 16)] += 1
        elif sample:
            others += 1
    if base is None:
        sys.exit("perf told no place of the program")
    return {ip - base: n for ip, n in own.items()}, others


def segment_shift(binary):
    """Virtual address less file offset of the code."""
    for line in subprocess.run(["readelf", "-lW", binary], capture_output=True, text=True).stdout.splitlines():
        # LOAD offset virtual physical file-size memory-size flags... alignment
        words = line.split()
        if words[:1] == ["LOAD"] and "E" in words[6:-1]:
            return int(words[2], 16) - int(words[1], 16)
    return 0


def frames(binary, addresses):
    """By address the functions at it with their files, the innermost first."""
    shift = segment_shift(binary)
    asked = "".join(f"{a + shift:#x}\n" for a in addresses)
    told = subprocess.run(["llvm-addr2line", "-a", "-i", "-f", "-C", "-e", binary], input=asked, capture_output=True, text=True).stdout
    by, current, function = {}, None, None
    for line in told.splitlines():
        if re.fullmatch(r"0x[0-9a-f]+", line):
            current, function = by.setdefault(int(line, 16) - shift, []), None
        elif function is None:
            function = line
        else:
            current.append((function, line))
            function = None
    return by


def room(stack):
    """Room and function of the innermost frame that belongs to one."""
    for function, place in stack:
        if THROUGH.search(place):
            continue
        for pattern, name in ROOMS:
            if re.search(pattern, place):
                return name, function
    return "libraries", stack[0][0] if stack else "?"


def profile(binary, command, rate):
    own, others = samples(binary, command, rate)
    stacks = frames(binary, own)
    rooms, functions = collections.Counter({"libraries": others}), collections.Counter()
    for address, n in own.items():
        name, function = room(stacks.get(address, []))
        rooms[name] += n
        functions[(name, function)] += n
    return rooms, functions


def main():
    ap = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    ap.add_argument("--binary", default="target/debug/rayloom")
    ap.add_argument("--rate", type=int, default=997)
    ap.add_argument("--largest", type=int, default=0)
    ap.add_argument("--list")
    ap.add_argument("--at", default="320x240")
    ap.add_argument("--more", default="")
    ap.add_argument("command", nargs="*")
    a = ap.parse_args()
    binary = os.path.abspath(a.binary)
    if a.list:
        runs = [["render", s, "--threads", "1", "--size", a.at, *shlex.split(a.more)] for s in open(a.list).read().split()]
    else:
        runs = [a.command]
    print("| scene | " + " | ".join(COLUMNS) + " |\n|" + "---|" * (len(COLUMNS) + 1))
    for command in runs:
        name = next((os.path.splitext(os.path.basename(w))[0] for w in command if re.search(r"\.(pov|glb|gltf|obj)$", w)), "?")
        with tempfile.TemporaryDirectory() as folder:
            rooms, functions = profile(binary, [*command, "--output", os.path.join(folder, "out.exr")], a.rate)
        total = sum(rooms.values())
        share = lambda n: f"{100 * n / total:.0f}" if n / total >= 0.005 else ""
        print(f"| {name} | " + " | ".join(share(rooms[c]) for c in COLUMNS) + " |", flush=True)
        for (where, function), n in functions.most_common(a.largest):
            print(f"    {100 * n / total:5.1f} %  {where:18} {function[:120]}", flush=True)


main()
