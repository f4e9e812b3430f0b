#!/usr/bin/env python3
"""CPU time of `rayloom povray` against POV-Ray, scene by scene, as docs/speed.md shows it.

  benches/povray_speed.py LIST --ours 'target/release/rayloom povray' [--size 640x480] [--runs 1] [--least 1.0] [--only TEXT]
                          [--limit 900] [--probe 160x120] [--keep FOLDER] [--reuse] [--json OUT] [--threads 1]

LIST names scenes relative to POV-Ray's example folder, one a line; a size after the name (`advanced/optics.pov 320x240`) goes before
--size. Both programs run in the scene's own folder of a copy of the examples, with the same options (+W +H -A -J -D -P +FN +WT1), one
after the other, so that a busy machine slows both alike. Time is user and system CPU seconds of the whole process, the median of --runs.
POV-Ray's times and pictures stay in --keep; --reuse takes them from there. Scenes that take POV-Ray less than --least are left out;
--probe renders small first and leaves out what cannot reach --least. A run that takes more than --limit CPU seconds failed.
--threads is ours alone (+WT); wall-clock seconds stand in the JSON for it. "agrees" is the share of pixels within 2/255 in every channel.
Needs numpy and pillow; prints a Markdown table.
"""
import argparse
import gzip
import json
import math
import os
import resource
import shlex
import shutil
import statistics
import subprocess
import sys
import time

EXAMPLES = "/usr/share/doc/povray/examples"
INCLUDES = "/usr/share/povray-3.7/include"


def private_copy(folder):
    """A writable copy of the examples with what Debian packed unpacked; made once."""
    to = os.path.join(folder, "examples")
    if os.path.isdir(to):
        return to
    part = to + ".part"
    shutil.rmtree(part, ignore_errors=True)
    shutil.copytree(EXAMPLES, part)
    for base, _, files in os.walk(part):
        for name in files:
            if name.endswith(".gz"):
                path = os.path.join(base, name)
                with gzip.open(path) as packed, open(path[:-3], "wb") as plain:
                    shutil.copyfileobj(packed, plain)
    os.rename(part, to)
    return to


def cpu_seconds(command, folder, log, limit):
    """CPU seconds of a command, or None when it fails; its peak memory in MB; wall-clock seconds."""
    start = time.monotonic()
    limits = lambda: resource.setrlimit(resource.RLIMIT_CPU, (limit, limit))
    with open(log, "wb") as out:
        child = subprocess.Popen(command, cwd=folder, stdin=subprocess.DEVNULL, stdout=out, stderr=out, preexec_fn=limits)
        _, status, used = os.wait4(child.pid, 0)
        child.returncode = os.waitstatus_to_exitcode(status)
    return (used.ru_utime + used.ru_stime if child.returncode == 0 else None), used.ru_maxrss // 1024, time.monotonic() - start


def agreement(a, b):
    """Share of pixels within 2/255."""
    import numpy as np
    from PIL import Image

    a, b = (np.asarray(Image.open(p).convert("RGB"), dtype=np.int16) for p in (a, b))
    return float((np.abs(a - b).max(axis=2) <= 2).mean()) if a.shape == b.shape else 0.0


def main():
    ap = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    ap.add_argument("list")
    ap.add_argument("--ours", required=True)
    ap.add_argument("--size", default="640x480")
    ap.add_argument("--probe", default="", help="size of the picture that tells which scenes are worth timing")
    ap.add_argument("--runs", type=int, default=1)
    ap.add_argument("--least", type=float, default=1.0, help="CPU seconds that a scene must take POV-Ray")
    ap.add_argument("--only", default="")
    ap.add_argument("--limit", type=int, default=900, help="CPU seconds after which a run is given up")
    ap.add_argument("--keep", default="/tmp/povray-speed", help="folder for pictures, logs and POV-Ray's times")
    ap.add_argument("--reuse", action="store_true", help="take POV-Ray's times and pictures from --keep where they are")
    ap.add_argument("--threads", type=int, default=1)
    ap.add_argument("--json")
    a = ap.parse_args()
    os.makedirs(a.keep, exist_ok=True)
    tree = private_copy(a.keep)
    ours = shlex.split(a.ours)
    ours[0] = os.path.abspath(ours[0])
    lines = [s.split() for s in open(a.list) if s.strip() and not s.startswith("#") and a.only in s]
    scenes = [(line[0], (line[1:] or [a.size])[0]) for line in lines]

    def run(who, scene, size):
        w, h = size.split("x")
        out = os.path.join(a.keep, f"{'povray' if who == 'povray' else 'ours'}-{size}", scene[:-4] + ".png")
        os.makedirs(os.path.dirname(out), exist_ok=True)
        options = [f"+I{os.path.basename(scene)}", f"+O{out}", f"+W{w}", f"+H{h}", "-A", "-J", "-D", "-P", "+FN", f"+L{INCLUDES}"]
        command = ["povray", *options, "+WT1", "-V", "-C"] if who == "povray" else [*ours, *options, f"+WT{a.threads}"]
        if who == "povray" and a.reuse and os.path.exists(out + ".json"):
            return json.load(open(out + ".json"))["cpu"], 0, 0, out
        cpu, memory, wall = cpu_seconds(command, os.path.join(tree, os.path.dirname(scene)), out + ".log", a.limit)
        return cpu, memory, wall, out

    rows = []
    print("| scene | size | POV-Ray s | ours s | ratio | agrees | ours, peak MB |\n|---|---|---|---|---|---|---|")
    for scene, size in scenes:
        if a.probe:
            (w, h), (pw, ph) = ([int(v) for v in s.split("x")] for s in (size, a.probe))
            small = run("povray", scene, a.probe)[0]
            if small is None or small * (w * h) / (pw * ph) < a.least * 0.8:
                continue
        theirs, mine, walls = [], [], []
        for _ in range(a.runs):
            t, _, _, reference = run("povray", scene, size)
            theirs.append(t)
            if t is None or t < a.least:
                break
            t, memory, wall, picture = run("ours", scene, size)
            mine.append(t)
            walls.append(wall)
        if theirs[-1] is not None:
            json.dump({"cpu": statistics.median(theirs)}, open(reference + ".json", "w"))
        if not mine:
            continue
        if None in mine:
            print(f"| {scene} | {size} | {statistics.median(theirs):.2f} | failed | | | |", flush=True)
            continue
        t, m = statistics.median(theirs), statistics.median(mine)
        rows.append({"scene": scene, "size": size, "povray": t, "ours": m, "wall": statistics.median(walls)})
        rows[-1].update(agrees=agreement(reference, picture), memory=memory)
        print(f"| {scene} | {size} | {t:.2f} | {m:.2f} | {t / max(m, 0.01):.2f} | {rows[-1]['agrees']:.3f} | {memory} |", flush=True)
    if rows:
        for name, part in (("all", rows), ("95 % agree", [r for r in rows if r["agrees"] >= 0.95])):
            ratios = [r["povray"] / max(r["ours"], 0.01) for r in part]
            mean = math.exp(sum(map(math.log, ratios)) / max(len(ratios), 1))
            slower = [r["scene"] for r, q in zip(part, ratios) if q < 1]
            print(f"\n{name}: {len(part)} scenes, geometric mean {mean:.2f}x, slower: {len(slower)} {' '.join(slower)}", file=sys.stderr)
    if a.json:
        json.dump(rows, open(a.json, "w"), indent=1)


if __name__ == "__main__":
    main()
