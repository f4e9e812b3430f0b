#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs every case of cases/ in a Blender of its own, with a fresh profile and a time limit. Fails when one fails, and when none ran."""

import argparse
import glob
import os
import subprocess
import sys
import tempfile
import time

HERE = os.path.dirname(os.path.abspath(__file__))
# Seconds that one case may take: bpy at times hangs at its end, and a renderer may.
LIMIT = 240


def rooms():
    """The cases by name, each with the file of cases/ that it stands in."""
    found = {}
    for path in sorted(glob.glob(os.path.join(HERE, "cases", "[a-z]*.py"))):
        with open(path, encoding="utf-8") as file:
            for line in file:
                if line.startswith("def case_"):
                    found[line.split("(")[0][len("def case_") :]] = os.path.splitext(os.path.basename(path))[0]
    return found


def run(room, name, zip_path, more, limit):
    """One case; its output if it failed."""
    with tempfile.TemporaryDirectory(prefix="rayloom-test-") as folder:
        env = {**os.environ, "BLENDER_USER_RESOURCES": os.path.join(folder, "profile"), **more}
        env.pop("RAYLOOM", None)
        command = [sys.executable, os.path.join(HERE, "cases"), room, name, os.path.abspath(zip_path), folder]
        try:
            done = subprocess.run(command, capture_output=True, text=True, errors="replace", timeout=limit, env=env, check=False)
        except subprocess.TimeoutExpired as e:
            return f"no end after {limit} s\n{(e.stdout or b'').decode('utf-8', 'replace')[-2000:]}"
        # Return codes of Blender mean nothing: the case says itself that it came to its end.
        if f"CASE {name} PASSED" in done.stdout:
            for line in done.stdout.splitlines():
                if line.startswith("CASE SAYS"):
                    print(f"    {line[10:]}")
            return None
        return f"code {done.returncode}\n{done.stdout[-3000:]}\n{done.stderr[-3000:]}"


def main():
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--zip", required=True, help="the extension, as addons/build.py makes it")
    parser.add_argument("--scenes", help="folder of .blend files to render as well")
    parser.add_argument("--references", help="folder of Cycles' pictures of them, NAME.exr and NAME_mid.exr: prints a table")
    parser.add_argument("--samples", type=int, default=1, help="samples a pixel of these scenes")
    parser.add_argument("--limit", type=int, default=LIMIT, help="seconds that a case may take")
    parser.add_argument("cases", nargs="*", help="which ones [default: all]")
    args = parser.parse_args()
    known = rooms()
    unknown = [name for name in args.cases if name not in known]
    if unknown:
        parser.error(f"no such case: {', '.join(unknown)}; there are {', '.join(known)}")
    chosen = args.cases or list(known)
    more = {"RAYLOOM_SCENES": args.scenes or "", "RAYLOOM_REFERENCES": args.references or "", "RAYLOOM_SAMPLES": str(args.samples)}
    failed = []
    for name in chosen:
        start = time.monotonic()
        why = run(known[name], name, args.zip, more, args.limit)
        print(f"{'FAILED' if why else 'ok    '} {name} ({time.monotonic() - start:.1f} s)", flush=True)
        if why:
            failed.append(name)
            print(why, flush=True)
    print(f"{len(chosen) - len(failed)} of {len(chosen)} cases passed")
    return 1 if failed or not chosen else 0


if __name__ == "__main__":
    sys.exit(main())
