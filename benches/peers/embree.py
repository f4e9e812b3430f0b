#!/usr/bin/env python3
"""Embree's single-ray speed on the rays that `cargo bench --bench traverse -- --dump=FOLDER` wrote. Needs `pip install embreex numpy`.

    embree.py FOLDER NAME...     one thread; CPU seconds of the best of three rounds; hits and mean depth beside, to compare
"""
import resource
import sys

import numpy as np
from embreex import rtcore_scene
from embreex.mesh_construction import TriangleMesh


def cpu():
    used = resource.getrusage(resource.RUSAGE_SELF)
    return used.ru_utime + used.ru_stime


def main():
    folder, names = sys.argv[1], sys.argv[2:]
    print("mesh                 faces build cpu s | Mrays/s primary shadow diffuse | hits, mean depth")
    for name in names:
        read = lambda kind, n: np.fromfile(f"{folder}/{name}.{kind}", "<f4").reshape(-1, n)
        faces = read("faces", 9).reshape(-1, 3, 3)
        before = cpu()
        scene = rtcore_scene.EmbreeScene()
        TriangleMesh(scene, faces)
        # The first ray commits the scene.
        scene.run(np.zeros((1, 3), "f4"), np.ones((1, 3), "f4"))
        built = cpu() - before
        speeds, found = [], []
        for kind in ("primary", "shadow", "diffuse"):
            rays = read(kind, 7)
            origins, dirs, far = (np.ascontiguousarray(a) for a in (rays[:, :3], rays[:, 3:6], rays[:, 6]))
            shadow = kind == "shadow"
            ask = (lambda: scene.run(origins, dirs, dists=far, query="OCCLUDED")) if shadow else (lambda: scene.run(origins, dirs, query="DISTANCE"))
            best = 0.0
            for _ in range(3):
                before, n = cpu(), 0
                while cpu() - before < 0.25:
                    got = np.asarray(ask())
                    n += len(rays)
                best = max(best, n / (cpu() - before) / 1e6)
            speeds.append(best)
            hit = got >= 0 if shadow else got < 1e30
            found.append(f"{int(hit.sum())}" if shadow else f"{int(hit.sum())} {float(got[hit].mean()):.6f}")
        print(f"{name:16} {len(faces):9} {built:11.2f} |         {speeds[0]:7.2f} {speeds[1]:6.2f} {speeds[2]:7.2f} | {', '.join(found)}")


if __name__ == "__main__":
    main()
