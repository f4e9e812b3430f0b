#!/usr/bin/env python3
"""Embree for `rayloom bench accel --against embree`: builds embree.c beside this file against the library of `pip install embreex`, and runs it.

    embree.py FOLDER [robust]     needs cc (or the compiler that CC names); what it answers stands in embree.c
"""
import glob
import importlib.util
import os
import subprocess
import sys


def library():
    found = importlib.util.find_spec("embreex")
    if found is None:
        sys.exit("the Python package embreex is not installed (pip install embreex)")
    folder = os.path.dirname(os.path.dirname(found.origin))
    names = glob.glob(os.path.join(folder, "embreex.libs", "libembree4*"))
    if not names:
        sys.exit(f"no libembree4 stands in {folder}/embreex.libs")
    return names[0]


def main():
    folder, program, lib = sys.argv[1], os.path.join(sys.argv[1], f"embree-{os.getpid()}"), library()
    source = os.path.join(os.path.dirname(os.path.abspath(__file__)), "embree.c")
    where = os.path.dirname(lib)
    command = [os.environ.get("CC", "cc"), "-O3", "-march=native", "-o", program, source, lib, "-Wl,-rpath," + where, "-lm"]
    made = subprocess.run(command, capture_output=True, text=True)
    if made.returncode != 0:
        sys.exit("embree.c cannot be compiled: " + (made.stderr.strip().splitlines() or ["no word why"])[-1])
    os.environ["LD_LIBRARY_PATH"] = where + os.pathsep + os.environ.get("LD_LIBRARY_PATH", "")
    os.execv(program, [program, folder, *sys.argv[2:]])


if __name__ == "__main__":
    main()
