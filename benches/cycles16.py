#!/usr/bin/env python3
"""rayloom's path integrator against Cycles' own pictures: the table of docs/path.md.

  benches/cycles16.py --scenes DIR --references DIR [--spp 256] [--out DIR] [--program target/release/rayloom] [--rendered] [NAME ...]

DIR of scenes holds NAME.glb with the extension RAYLOOM_scene, DIR of references NAME.exr (Cycles, 2,048 samples) and NAME_mid.exr (256).
For each scene: RMSE of values clamped to 1 against NAME.exr, its ratio to Cycles' own (NAME_mid.exr against NAME.exr), the ratio of the means
of the clamped pictures, the same of the linear ones, seconds of CPU. With --rendered the pictures DIR/NAME_SPP.exr of --out are taken as they are
(made on another machine, say) and no time is shown. Needs numpy and OpenEXR (`pip install numpy OpenEXR`)."""
import argparse, os, resource, subprocess, sys
import numpy as np, OpenEXR

def load(path):
    channels = OpenEXR.File(path).channels()
    c = channels.get("RGB") or channels.get("RGBA")
    a = np.asarray(c.pixels, float) if c else np.dstack([np.asarray(channels[k].pixels, float) for k in "RGB"])
    return a[..., :3]

def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--scenes", required=True); p.add_argument("--references", required=True)
    p.add_argument("--spp", type=int, default=256); p.add_argument("--out", default="/tmp/cycles16")
    p.add_argument("--program", default="target/debug/rayloom"); p.add_argument("--threads", default="2")
    p.add_argument("--timeout", type=int, default=3600, help="seconds a scene"); p.add_argument("--extra", default="", help="more arguments of the program")
    p.add_argument("--rendered", action="store_true", help="take the pictures that lie in --out"); p.add_argument("names", nargs="*")
    a = p.parse_args()
    os.makedirs(a.out, exist_ok=True)
    names = a.names or sorted(n[:-4] for n in os.listdir(a.scenes) if n.endswith(".glb"))
    clamp = lambda x: np.clip(x, 0, 1)
    rmse = lambda x, y: float(np.sqrt(((x - y) ** 2).mean()))
    print("scene\tspp\trmse clamped\tCycles' own\tratio\tmean clamped\tmean linear\tcpu s")
    for n in names:
        out = os.path.join(a.out, f"{n}_{a.spp}.exr")
        cpu = "-"
        if not a.rendered:
            cpu = rendered(a, n, out)
            if cpu is None:
                continue
        x, r, m = load(out), load(os.path.join(a.references, n + ".exr")), load(os.path.join(a.references, n + "_mid.exr"))
        own, err = rmse(clamp(m), clamp(r)), rmse(clamp(x), clamp(r))
        print(f"{n}\t{a.spp}\t{err:.4f}\t{own:.4f}\t{err / own:.2f}\t{clamp(x).mean() / clamp(r).mean():.4f}\t{x.mean() / r.mean():.4f}\t{cpu}", flush=True)

def rendered(a, n, out):
    """Seconds of CPU; None, after a line, where it failed."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    cmd = [a.program, "render", os.path.join(a.scenes, n + ".glb"), "-o", out, "--integrator", "path", "--backend", "cpu", "--size", "320x240",
           "--spp", str(a.spp), "--threads", a.threads, "--progress", "none", *a.extra.split()]
    done = subprocess.run(["timeout", str(a.timeout), *cmd], capture_output=True, text=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode:
        print(f"{n}\tfailed: {done.stderr.strip().splitlines()[-1:]}"); return None
    if done.stderr.strip():
        print(done.stderr.strip(), file=sys.stderr)
    return f"{after.ru_utime - before.ru_utime:.1f}"

main()
