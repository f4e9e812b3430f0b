"""Renders what src/bench/peer_scene.rs wrote with LuxCoreRender and times it. Arguments: FOLDER WIDTH HEIGHT SAMPLES SEED THREADS OUT.exr
Prints "seconds WALL CPU" of building the scene with its tree and of rendering, reading and writing left out. Needs Python with pyluxcore and
numpy (pip install pyluxcore numpy) and OpenEXR to write the picture (pip install OpenEXR).

PATHCPU, Sobol sampler without its adaptive part, Russian roulette from depth 5, no filter, no clamp, no denoiser.
"""

import json
import os
import resource
import sys
import time

import numpy as np
import OpenEXR

folder, out = sys.argv[1], sys.argv[7]
width, height, samples, seed, threads = map(int, sys.argv[2:7])
os.sched_setaffinity(0, sorted(os.sched_getaffinity(0))[:threads])

import pyluxcore


def properties(pairs):
    p = pyluxcore.Properties()
    for name, value in pairs:
        p.Set(pyluxcore.Property(name, value))
    return p


def material(name, b):
    """Properties of a material."""
    at = f"scene.materials.{name}"
    if b["type"] == "diffuse":
        return [(f"{at}.type", "matte"), (f"{at}.kd", b["color"])]
    if b["type"] == "metal":
        # Metal by its reflectance; widths are the roughness squared in both programs.
        return [(f"{at}.type", "metal2"), (f"{at}.fresnel", name), (f"{at}.uroughness", b["alpha"]), (f"{at}.vroughness", b["alpha"]),
                (f"scene.textures.{name}.type", "fresnelcolor"), (f"scene.textures.{name}.kr", b["color"])]
    if b["type"] == "glass":
        kind = "glass" if b["alpha"] < 1e-4 else "roughglass"
        rough = [] if kind == "glass" else [(f"{at}.uroughness", b["alpha"]), (f"{at}.vroughness", b["alpha"])]
        return [(f"{at}.type", kind), (f"{at}.kr", b["color"]), (f"{at}.kt", b["color"]), (f"{at}.interiorior", b["ior"])] + rough
    raise SystemExit(f"LuxCore has no closure like '{b['type']}'")


def shining(name, radiance):
    """Properties that make a material shine with so much, the same in all directions."""
    at = f"scene.materials.{name}.emission"
    return [(at, radiance), (f"{at}.gain", [1.0, 1.0, 1.0]), (f"{at}.normalizebycolor", False)] if any(radiance) else []


def define(scene, name, points, normals=None):
    tuples = lambda rows: [tuple(r) for r in rows.tolist()]
    faces = np.arange(len(points)).reshape(-1, 3)
    scene.DefineMesh(name, tuples(points), tuples(faces), None if normals is None else tuples(normals), None, None, None)


with open(os.path.join(folder, "scene.json")) as f:
    text = json.load(f)
files = [np.fromfile(os.path.join(folder, s["file"]), "<f4").astype(float).reshape(-1, 3) for s in text["shapes"]]
pyluxcore.Init(lambda *_: None)


def build():
    scene = pyluxcore.Scene()
    c = text["camera"]
    # Its pixels stand one row too low (2.11, measured): the window moves with them.
    ratio, row = height / width, 2 / width
    pairs = [
        ("scene.camera.type", "perspective"), ("scene.camera.lookat.orig", c["origin"]), ("scene.camera.lookat.target", c["target"]),
        ("scene.camera.up", c["up"]), ("scene.camera.fieldofview", c["fov_x"]), ("scene.camera.screenwindow", [-1.0, 1.0, -ratio - row, ratio - row]),
        ("scene.camera.autofocus.enable", False), ("scene.camera.cliphither", 1e-3), ("scene.camera.clipyon", 1e5),
    ]
    if any(text["sky"]):
        pairs += [("scene.lights.sky.type", "constantinfinite"), ("scene.lights.sky.color", text["sky"])]
    for k, (s, numbers) in enumerate(zip(text["shapes"], files)):
        n = len(numbers) // 2 if s["smooth"] else len(numbers)
        define(scene, f"mesh{k}", numbers[:n], numbers[n:] if s["smooth"] else None)
        pairs += material(f"m{k}", s["bsdf"]) + shining(f"m{k}", s["radiance"])
        pairs += [(f"scene.objects.o{k}.shape", f"mesh{k}"), (f"scene.objects.o{k}.material", f"m{k}")]
    for k, e in enumerate(text["emitters"]):
        if e["kind"] == "point":
            # A point's gain is its power over 4 pi.
            pairs += [(f"scene.lights.l{k}.type", "point"), (f"scene.lights.l{k}.position", e["position"]),
                      (f"scene.lights.l{k}.color", e["intensity"]), (f"scene.lights.l{k}.normalizebycolor", False)]
            continue
        # A lamp shines along its -z, a mesh along its normal; no ray of the camera sees it.
        to_world, (x, y) = np.array(e["to_world"]), np.array(e["size"]) / 2
        square = np.array([[-x, -y, 0], [x, y, 0], [x, -y, 0], [-x, -y, 0], [-x, y, 0], [x, y, 0]])
        define(scene, f"lamp{k}", square @ to_world[:, :3].T + to_world[:, 3])
        pairs += material(f"l{k}", {"type": "diffuse", "color": [0.0, 0.0, 0.0]}) + shining(f"l{k}", e["radiance"])
        pairs += [(f"scene.objects.l{k}.shape", f"lamp{k}"), (f"scene.objects.l{k}.material", f"l{k}"),
                  (f"scene.objects.l{k}.camerainvisible", True)]
    scene.Parse(properties(pairs))
    return scene


def render():
    depth = text["max_depth"]
    config = pyluxcore.RenderConfig(
        properties([
            ("renderengine.type", "PATHCPU"), ("sampler.type", "SOBOL"), ("sampler.sobol.adaptive.strength", 0.0), ("renderengine.seed", seed + 1),
            ("film.width", width), ("film.height", height), ("film.filter.type", "NONE"), ("film.imagepipeline.0.type", "NOP"),
            ("path.pathdepth.total", depth), ("path.pathdepth.diffuse", depth), ("path.pathdepth.glossy", depth), ("path.pathdepth.specular", depth),
            ("path.russianroulette.depth", 5), ("path.clamping.variance.maxvalue", 0.0), ("batch.haltspp", samples),
            ("native.threads.count", threads), ("film.outputs.0.type", "RGB"), ("film.outputs.0.filename", "rgb.exr"),
        ]),
        build(),
    )
    session = pyluxcore.RenderSession(config)
    session.Start()
    while not session.HasDone():
        time.sleep(0.002)
        session.UpdateStats()
    session.Stop()
    film = session.GetFilm()
    pixels = np.zeros((height, width, 3), np.float32)
    film.GetOutputFloat(pyluxcore.FilmOutputType.RGB, pixels, 0, True)
    return pixels[::-1]


used = lambda: sum(resource.getrusage(resource.RUSAGE_SELF)[:2])
wall, cpu = time.perf_counter(), used()
pixels = render()
wall, cpu = time.perf_counter() - wall, used() - cpu
OpenEXR.File({}, {"RGB": np.ascontiguousarray(pixels)}).write(out)
print(f"seconds {wall:.6f} {cpu:.6f}", flush=True)
os._exit(0)
