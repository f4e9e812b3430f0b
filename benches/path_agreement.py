#!/usr/bin/env python3
"""The path integrator on the GPU against the CPU's, scene by scene.

  benches/path_agreement.py render --out DIR [--backend cpu|gpu] [--size 96x72] [--spp 16] [--seeds 8] [--program target/debug/rayloom] SCENE...
  benches/path_agreement.py compare --out DIR [--seeds 8]

`render` writes DIR/NAME.BACKEND.SEED.exr: seeds 0..n on the CPU and the GPU. It needs nothing but the program, so that pictures can be made on
another machine. `compare` needs numpy and OpenEXR and prints for each scene: the share of values that are the same to 0.2 % in pictures of the same seed;
z of the difference of the means; and by Welch's test between independent seeds (even ones of the CPU, odd ones of the GPU) the largest |t| of
a pixel and the share of pixels beyond the 1 % level, which is 1 % where both have the same mean. Scenes that the GPU hands to the CPU are named with why."""
import argparse, glob, os, subprocess, sys

def name_of(scene):
    parts = scene.split(os.sep)
    return os.path.splitext(parts[-1])[0] if not parts[-1].startswith("scene.") else "-".join(parts[-3:-1])

def render(a):
    os.makedirs(a.out, exist_ok=True)
    for scene in a.scenes:
        for backend in a.backend.split(","):
            for seed in range(a.seeds):
                base = os.path.join(a.out, f"{name_of(scene)}.{backend}.{seed}")
                done = subprocess.run([a.program, "render", scene, "-o", base + ".exr", "--integrator", "path", "--backend", backend, "--size", a.size, "--spp",
                                       str(a.spp), "--seed", str(seed), "--progress", "none"], capture_output=True, text=True, timeout=a.timeout)
                told = [l for l in done.stderr.splitlines() if "rendered on the CPU" in l or l.startswith("error:")]
                if told and backend == "gpu":
                    open(base + ".txt", "w").write(told[0]); print(name_of(scene), told[0], flush=True); break
            else:
                print(name_of(scene), backend, "done", flush=True)

def load(path):
    import numpy as np, OpenEXR
    ch = OpenEXR.File(path).channels(); c = ch.get("RGB") or ch.get("RGBA")
    return (np.asarray(c.pixels, float) if c else np.dstack([np.asarray(ch[k].pixels, float) for k in "RGB"]))[..., :3]

def compare(a):
    import numpy as np, math
    print("scene\tsame %\tmean gpu/cpu\tz of means\tlargest |t|\tbeyond 1 % level, %")
    for first in sorted(glob.glob(os.path.join(a.out, "*.cpu.0.exr"))):
        n = os.path.basename(first)[:-len(".cpu.0.exr")]
        get = lambda b: [load(os.path.join(a.out, f"{n}.{b}.{s}.exr")) for s in range(a.seeds)]
        why = os.path.join(a.out, n + ".gpu.0.txt")
        if os.path.exists(why):
            print(f"{n}\t{open(why).read().split('does not do')[-1].strip()}"); continue
        try: cpu, gpu = np.array(get("cpu")), np.array(get("gpu"))
        except Exception as e: print(f"{n}\tmissing: {e}"); continue
        same = (np.abs(cpu - gpu) <= 2e-3 * np.maximum(np.abs(cpu), np.abs(gpu)) + 1e-4).mean()
        # Clamped, so that fireflies do not decide; blocks of 4 x 4 pixels are nearer to normal than pixels.
        clip = lambda x: np.clip(x, 0, 1).mean(-1)
        c, g = clip(cpu), clip(gpu)
        d = (g - c).mean((1, 2)); z = d.mean() / (d.std(ddof=1) / math.sqrt(len(d)) + 1e-12)
        h, w = (c.shape[1] // 4) * 4, (c.shape[2] // 4) * 4
        block = lambda x: x[:, :h, :w].reshape(len(x), h // 4, 4, w // 4, 4).mean((2, 4))
        p, q = block(c[0::2]), block(g[1::2]); k = len(p)
        va, vb = p.var(0, ddof=1) / k, q.var(0, ddof=1) / k
        # Variances of few seeds are pooled over 3 x 3 blocks.
        pool = lambda v: sum(np.roll(np.roll(np.pad(v, 1, mode="edge"), i, 0), j, 1)[1:-1, 1:-1] for i in (-1, 0, 1) for j in (-1, 0, 1)) / 9
        t = (q.mean(0) - p.mean(0)) / np.sqrt(pool(va + vb) + 1e-14)
        t = np.where(np.abs(q.mean(0) - p.mean(0)) < 1e-6, 0, t)
        limit = 2.66 if k >= 4 else 2.9
        print(f"{n}\t{100 * same:.2f}\t{gpu.mean() / max(cpu.mean(), 1e-12):.5f}\t{z:+.2f}\t{np.abs(t).max():.2f}\t{100 * (np.abs(t) > limit).mean():.2f}", flush=True)

if __name__ == "__main__":
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("what", choices=["render", "compare"]); p.add_argument("--out", required=True); p.add_argument("--backend", default="cpu,gpu")
    p.add_argument("--size", default="96x72"); p.add_argument("--spp", type=int, default=16); p.add_argument("--seeds", type=int, default=8)
    p.add_argument("--program", default="target/debug/rayloom"); p.add_argument("--timeout", type=int, default=900); p.add_argument("scenes", nargs="*")
    a = p.parse_intermixed_args()
    render(a) if a.what == "render" else compare(a)
