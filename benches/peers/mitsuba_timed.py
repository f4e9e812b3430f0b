"""Renders what src/bench/peer_scene.rs wrote with Mitsuba 3 and times it. Arguments: FOLDER WIDTH HEIGHT SAMPLES SEED THREADS OUT.exr
Prints "seconds WALL CPU" of building the scene with its tree and of rendering, reading and writing left out; kernels are compiled before.
Needs Python with mitsuba (pip install mitsuba) and for its llvm_ad_rgb variant an LLVM of 17 or later (apt install libllvm19); without one,
or with MITSUBA_VARIANT=scalar_rgb, it runs the scalar variant.

`path` integrator, independent sampler, Russian roulette from depth 5, box filter, no denoiser, no clamp.
"""

import glob
import json
import os
import re
import resource
import sys
import time

import numpy as np

folder, out = sys.argv[1], sys.argv[7]
width, height, samples, seed, threads = map(int, sys.argv[2:7])
if "DRJIT_LIBLLVM_PATH" not in os.environ:
    number = lambda path: int((re.findall(r"(\d+)", os.path.basename(path)) or ["0"])[0])
    found = [p for p in glob.glob("/usr/lib/*/libLLVM*.so*") + glob.glob("/usr/lib/llvm-*/lib/libLLVM-*.so*") if number(p) >= 17]
    if found:
        os.environ["DRJIT_LIBLLVM_PATH"] = max(found, key=number)
    else:
        os.environ.setdefault("MITSUBA_VARIANT", "scalar_rgb")

os.sched_setaffinity(0, sorted(os.sched_getaffinity(0))[:threads])

import drjit as dr
import mitsuba as mi

variant = os.environ.get("MITSUBA_VARIANT", "llvm_ad_rgb")
mi.set_variant(variant)
# Dr.Jit with one thread waits for ever (1.4): the cores are what limits it.
dr.set_thread_count(max(threads, 2))
T = mi.ScalarTransform4f


def color(v):
    return {"type": "rgb", "value": v}


def bsdf(b):
    kind = b["type"]
    if kind == "diffuse":
        return {"type": "twosided", "inner": {"type": "diffuse", "reflectance": color(b["color"])}}
    if kind == "metal":
        inner = {"type": "roughconductor", "distribution": "ggx", "material": "none", "alpha": max(b["alpha"], 1e-4), "specular_reflectance": color(b["color"])}
        return {"type": "twosided", "inner": inner}
    if kind == "glass":
        tints = {"specular_reflectance": color(b["color"]), "specular_transmittance": color(b["color"]), "int_ior": b["ior"], "ext_ior": 1.0}
        if b["alpha"] < 1e-6:
            return {"type": "dielectric", **tints}
        return {"type": "roughdielectric", "distribution": "ggx", "alpha": b["alpha"], **tints}
    eta = (1 + b["f0"] ** 0.5) / (1 - b["f0"] ** 0.5)
    inner = {"type": "principled", "base_color": color(b["color"]), "metallic": b["metallic"], "roughness": b["roughness"], "eta": max(eta, 1.001)}
    if b["transmission"] > 0:
        return {**inner, "spec_trans": b["transmission"]}
    return {"type": "twosided", "inner": inner}


def mesh(record, numbers):
    n = len(numbers) // (6 if record["smooth"] else 3)
    props = mi.Properties()
    props["bsdf"] = mi.load_dict(bsdf(record["bsdf"]))
    if any(record["radiance"]):
        props["emitter"] = mi.load_dict({"type": "area", "radiance": color(record["radiance"])})
    m = mi.Mesh(record["file"], n, n // 3, has_vertex_normals=record["smooth"], props=props)
    p = mi.traverse(m)
    p["vertex_positions"] = numbers[: 3 * n]
    p["faces"] = np.arange(n, dtype=np.uint32)
    if record["smooth"]:
        p["vertex_normals"] = numbers[3 * n :]
    p.update()
    return m


def emitter(e):
    if e["kind"] == "point":
        return {"type": "point", "position": e["position"], "intensity": color(e["intensity"])}
    # A lamp shines along its -z, a rectangle of -1..1 along its z.
    world = T(np.array(e["to_world"] + [[0, 0, 0, 1]])) @ T().rotate([1, 0, 0], 180) @ T().scale([e["size"][0] / 2, e["size"][1] / 2, 1])
    return {"type": "rectangle", "to_world": world, "bsdf": {"type": "diffuse", "reflectance": 0.0}, "emitter": {"type": "area", "radiance": color(e["radiance"])}}


with open(os.path.join(folder, "scene.json")) as f:
    text = json.load(f)
files = [np.fromfile(os.path.join(folder, s["file"]), "<f4") for s in text["shapes"]]


def build():
    c = text["camera"]
    scene = {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": text["max_depth"], "rr_depth": 5},
        "sensor": {
            "type": "perspective", "fov": c["fov_x"], "fov_axis": "x", "near_clip": 1e-3, "far_clip": 1e5,
            "to_world": T().look_at(origin=c["origin"], target=c["target"], up=c["up"]),
            "film": {"type": "hdrfilm", "width": width, "height": height, "rfilter": {"type": "box"}, "pixel_format": "rgb", "component_format": "float32"},
            "sampler": {"type": "independent"},
        },
    }
    if any(text["sky"]):
        scene["sky"] = {"type": "constant", "radiance": color(text["sky"])}
    for k, (s, numbers) in enumerate(zip(text["shapes"], files)):
        scene[f"shape{k}"] = mesh(s, numbers)
    for k, e in enumerate(text["emitters"]):
        scene[f"emitter{k}"] = emitter(e)
    return mi.load_dict(scene)


def render(scene, seed):
    image = mi.render(scene, spp=samples, seed=seed)
    # Kernels run when their result is asked for.
    return np.array(image)


if variant.startswith("llvm"):
    # The same counts make the same kernels.
    render(build(), seed + 1_000_003)
used = lambda: sum(resource.getrusage(resource.RUSAGE_SELF)[:2])
wall, cpu = time.perf_counter(), used()
image = render(build(), seed)
wall, cpu = time.perf_counter() - wall, used() - cpu
mi.Bitmap(image).write(out)
print(f"seconds {wall:.6f} {cpu:.6f}", flush=True)
os._exit(0)
