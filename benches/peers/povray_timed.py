"""Renders a scene with POV-Ray and times it. Arguments: SCENE WIDTH HEIGHT ANTIALIASING SEED THREADS OUT.exr
ANTIALIASING is "off" or METHOD:THRESHOLD:DEPTH. Prints "seconds WALL CPU" as POV-Ray itself tells them of bounding, photons, radiosity and
tracing; parsing and writing are left out. Needs POV-Ray 3.7 with OpenEXR (Debian: apt install povray povray-includes).

SEED does nothing: POV-Ray has none.
"""

import os
import re
import subprocess
import sys

scene, antialiasing, out = os.path.abspath(sys.argv[1]), sys.argv[4], os.path.abspath(sys.argv[7])
width, height, threads = int(sys.argv[2]), int(sys.argv[3]), int(sys.argv[6])
if antialiasing == "off":
    how = ["-A"]
else:
    method, threshold, depth = antialiasing.split(":")
    # "+A0" is refused.
    how = ["Antialias=On", f"Antialias_Threshold={threshold}", f"Sampling_Method={method}", f"Antialias_Depth={depth}"]
command = ["povray", f"+I{scene}", f"+O{out}", "+FE", f"+W{width}", f"+H{height}", f"+WT{threads}", "-D", "-P", *how]
ended = subprocess.run(command, cwd=os.path.dirname(scene), stdin=subprocess.DEVNULL, capture_output=True, text=True, errors="replace")
if ended.returncode != 0 or not os.path.exists(out):
    sys.exit("POV-Ray: " + next((l for l in reversed(ended.stderr.splitlines()) if "rror" in l), "no picture"))
wall = cpu = 0.0
for stage in ("Bounding", "Photon", "Radiosity", "Trace"):
    told = re.search(stage + r" Time:.*\(([\d.]+) seconds\)\s+using \d+ thread\(s\) with ([\d.]+) CPU-seconds", ended.stderr)
    if told:
        wall += float(told[1])
        cpu += float(told[2])
print(f"seconds {wall:.6f} {cpu:.6f}", flush=True)
