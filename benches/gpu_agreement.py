#!/usr/bin/env python3
"""How well the GPU's pictures agree with the CPU's, scene by scene, as docs/parity.md shows it.

  benches/gpu_agreement.py LIST --ours target/debug/rayloom [--size 80x60] [--jobs 2] [--limit 120] [--only TEXT] [--least 99.5]
                           [--keep FOLDER] [--reuse cpu|all] [--out TABLE.md] [--all] [--seconds S]

LIST names scenes relative to POV-Ray's example folder, one a line. `rayloom povray` renders each twice in the scene's own folder of a copy
of the examples, with `Backend=cpu` and `Backend=gpu` and otherwise the same options (+W +H -A -J -D -P +FN and the standard includes);
`rayloom diff` compares the two pictures. A scene agrees when --least percent of its pixels are within 2/255 in every channel. The table has a
line for each scene that does not, that the CPU rendered in the GPU's place, that draws random numbers, or that took more than --limit CPU
seconds; --all gives one to every scene. Seconds are CPU seconds of whole runs, compiling shaders included. --reuse takes pictures that are in
--keep already: the CPU's, or all that were finished. Compiled shaders stay in --keep, too. No scene is begun after --seconds.
"""
import argparse
import json
import os
import shlex
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor

from povray_speed import INCLUDES, cpu_seconds, private_copy

FALLBACK = "rendered on the CPU: "
RANDOM = "the GPU draws other random numbers"


def told(log, what):
    """The rest of the line that says `what`; None where none does."""
    for line in open(log, errors="replace"):
        if what in line:
            return line.split(what, 1)[1].strip()
    return None


def within(ours, a, b):
    """Percent of the pixels within 2/255."""
    done = subprocess.run([ours, "diff", a, b, "--fail", "0.0079", "--percent", "100", "--json"], capture_output=True, text=True)
    return 100.0 - json.loads(done.stdout)["metrics"]["percent_beyond_fail"]


def main():
    ap = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    ap.add_argument("list")
    ap.add_argument("--ours", required=True)
    ap.add_argument("--size", default="80x60")
    ap.add_argument("--jobs", type=int, default=2)
    ap.add_argument("--limit", type=int, default=120, help="CPU seconds after which a run is given up")
    ap.add_argument("--only", default="")
    ap.add_argument("--least", type=float, default=99.5, help="percent of the pixels that must agree")
    ap.add_argument("--keep", default="/tmp/gpu-agreement", help="folder for pictures, logs and compiled shaders")
    ap.add_argument("--reuse", choices=["cpu", "all"], default="")
    ap.add_argument("--out")
    ap.add_argument("--all", action="store_true", help="a line for every scene")
    ap.add_argument("--seconds", type=float, default=float("inf"), help="wall-clock time after which no scene is begun")
    a = ap.parse_args()
    end = time.monotonic() + a.seconds
    os.makedirs(a.keep, exist_ok=True)
    tree = private_copy(a.keep)
    ours = os.path.abspath(shlex.split(a.ours)[0])
    os.environ.setdefault("RAYLOOM_PIPELINES", os.path.join(a.keep, "pipelines"))
    width, height = a.size.split("x")
    scenes = [s.split()[0] for s in open(a.list) if s.strip() and not s.startswith("#") and a.only in s]

    def run(backend, scene):
        """Picture, log and CPU seconds; None for those where there is no picture."""
        out = os.path.join(a.keep, f"{backend}-{a.size}", scene[:-4] + ".png")
        log, kept = out + ".log", out + ".json"
        if a.reuse in (backend, "all") and os.path.exists(kept):
            return out, log, json.load(open(kept))["seconds"]
        os.makedirs(os.path.dirname(out), exist_ok=True)
        for old in (out, kept):
            if os.path.exists(old):
                os.remove(old)
        options = [f"+I{os.path.basename(scene)}", f"+O{out}", f"+W{width}", f"+H{height}", "-A", "-J", "-D", "-P", "+FN", f"+L{INCLUDES}"]
        folder = os.path.join(tree, os.path.dirname(scene))
        seconds, _, wall = cpu_seconds([ours, "povray", *options, f"Backend={backend}"], folder, log, a.limit)
        if seconds is not None:
            json.dump({"seconds": seconds, "wall": wall}, open(kept, "w"))
        return out, log, seconds

    def judge(scene):
        row = {"scene": scene[:-4], "within": None, "note": "", "cpu": None}
        if time.monotonic() > end:
            return {**row, "state": "not run"}
        cpu, log, row["cpu"] = run("cpu", scene)
        if row["cpu"] is None:
            return {**row, "state": "failed", "note": "CPU: " + (told(log, "error: ") or f"more than {a.limit} s")}
        gpu, log, row["gpu"] = run("gpu", scene)
        if row["gpu"] is None:
            error = told(log, "error: ")
            return {**row, "state": "failed" if error else "not finished", "note": error or f"more than {a.limit} CPU seconds"}
        reason = told(log, FALLBACK)
        if reason:
            return {**row, "state": "on the CPU", "note": reason.removeprefix("the GPU back end does not do ").removesuffix(" yet")}
        row["within"] = within(ours, cpu, gpu)
        if told(log, RANDOM) is not None:
            return {**row, "state": "random", "note": "draws random numbers of its own"}
        return {**row, "state": "agrees" if row["within"] >= a.least else "differs"}

    rows = []
    with ThreadPoolExecutor(a.jobs) as pool:
        for row in pool.map(judge, scenes):
            rows.append(row)
            print(f"{len(rows)}/{len(scenes)} {row['scene']}: {row['state']} {row['within'] or ''} {row['note']}", file=sys.stderr, flush=True)
    order = ["failed", "differs", "not finished", "not run", "random", "on the CPU", "agrees"]
    rows.sort(key=lambda r: (order.index(r["state"]), r["within"] or 0.0, r["scene"]))
    number = lambda v: "" if v is None else f"{v:.2f}"
    counts = ", ".join(f"{sum(r['state'] == s for r in rows)} {s}" for s in reversed(order) if any(r["state"] == s for r in rows))
    lines = [f"{len(rows)} scenes at {a.size}: {counts}.", "", "| scene | within 2/255, % | | CPU s | GPU s | |", "|---|---|---|---|---|---|"]
    for r in rows:
        if a.all or r["state"] != "agrees":
            lines.append(f"| {r['scene']} | {number(r['within'])} | {r['state']} | {number(r['cpu'])} | {number(r.get('gpu'))} | {r['note']} |")
    text = "\n".join(lines) + "\n"
    print(text, end="")
    if a.out:
        open(a.out, "w").write(text)


if __name__ == "__main__":
    main()
