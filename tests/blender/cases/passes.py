# SPDX-License-Identifier: GPL-3.0-or-later
"""Passes, Cryptomatte, denoising."""

import os

import bpy
import numpy as np
import stage
from stage import compositor_tree, emission, layers_of, lit_room, log_texts, module, new_scene, pass_name, render, render_error, say, wall


def case_passes():
    """Passes that the renderer has arrive; those that it has not are told."""
    new_scene()
    wall("W", -9, 9, -9, 9, material=emission("E", (1, 0.5, 0.25)))
    bpy.context.view_layer.use_pass_z = bpy.context.view_layer.use_pass_normal = True
    render("layers", layers=True)
    with open(os.path.join(stage.FOLDER, "layers.exr"), "rb") as file:
        head = file.read(20_000)
    # In parts of their own from 5.0 on, in one before: their names stand in the head of the file either way.
    assert all(name in head for name in (b"Combined", b"Depth", b"Normal")), head[:2000]
    told = " ".join(log_texts())
    say("passes not rendered yet: " + (told if "is not rendered" in told else "none"))


def case_passes_are_called_as_cycles_calls_them():
    """With every pass switched on, the channels of the file are Cycles', but for those that are known to be missing."""
    scene = new_scene((8, 8))
    wall("W", -1, 1, -1, 1)
    layer, names = bpy.context.view_layer, []
    for owner in (layer, layer.cycles):
        for prop in owner.bl_rna.properties:
            if prop.identifier.startswith("use_pass_") and not prop.identifier.startswith("use_pass_debug"):
                setattr(owner, prop.identifier, True)
    scene.cycles.samples, scene.cycles.use_denoising = 1, False
    for engine in ("CYCLES", "RAYLOOM"):
        scene.render.engine = engine
        render(engine, layers=True)
        names.append({k.split(".", 1)[1] for k in layers_of(os.path.join(stage.FOLDER, f"{engine}.exr"))[0]})
    theirs, ours = names
    missing, own = sorted({n.rsplit(".", 1)[0] for n in theirs - ours}), sorted({n.rsplit(".", 1)[0] for n in ours - theirs})
    say(f"{len(theirs & ours)} channels alike; Cycles alone has {missing}, ours alone {own}")
    # Parts of Cycles' volumes that came with 5.0.
    assert set(missing) <= {"Volume Scatter", "Volume Transmit", "Volume Majorant"} and len(theirs & ours) > 80, (missing, own)


def case_all_passes_and_cryptomatte():
    """Values of passes in Blender's own file, by their layers' names; the manifest of Cryptomatte in its header."""
    scene = new_scene(samples=4)
    bpy.context.view_layer.name = "Main Layer"
    scene.rayloom.use_adaptive_sampling = False
    near = wall("Near", -9, 0, -9, 9, y=1.0, material=emission("Shine", (1, 0.5, 0.25)))
    near.pass_index = 7
    matt = bpy.data.materials.new("Matt")
    matt.use_nodes = True
    wall("Far", 0, 9, -9, 9, y=3.0, material=matt)
    lamp = bpy.data.objects.new("Sun", bpy.data.lights.new("Sun", "SUN"))
    lamp.rotation_euler = (np.pi / 2, 0, 0)
    scene.collection.objects.link(lamp)
    layer = bpy.context.view_layer
    for name in ("z", "position", "normal", "uv", "object_index", "diffuse_direct", "diffuse_color", "emit", "cryptomatte_object"):
        setattr(layer, f"use_pass_{name}", True)
    layer.pass_cryptomatte_depth = 4
    render("layers", layers=True)
    planes, head = layers_of(os.path.join(stage.FOLDER, "layers.exr"))
    say(f"channels: {', '.join(sorted(planes))}")

    def at(name, x):
        return np.array([planes[f"Main Layer.{pass_name(name)}.{c}"][24, x] for c in {"IndexOB": "X", "Depth": "Z"}.get(name, "XYZ" if name in "NormalPosition" else "RGB")])

    assert np.allclose(at("Depth", 8), 6.0, atol=0.02) and np.allclose(at("Depth", 56), 8.0, atol=0.02), (at("Depth", 8), at("Depth", 56))
    assert at("IndexOB", 8) == 7 and at("IndexOB", 56) == 0
    assert np.allclose(at("Normal", 8), (0, -1, 0), atol=1e-3) and np.allclose(at("Position", 56)[1], 3.0, atol=0.01)
    assert np.allclose(at("Emit", 8), (1, 0.5, 0.25), atol=1e-3) and np.allclose(at("Emit", 56), 0.0)
    assert np.allclose(at("DiffCol", 56), 0.8, atol=0.05) and np.all(at("DiffDir", 56) > 0.05) and np.allclose(at("DiffCol", 8), 0.0)
    assert "Main Layer.CryptoObject01.a" in planes and "Main Layer.CryptoObject02.a" not in planes, "four ranks are two layers"
    manifests = [v for k, v in head.items() if k.startswith("cryptomatte/") and k.endswith("/manifest")]
    names = [v for k, v in head.items() if k.startswith("cryptomatte/") and k.endswith("/name")]
    assert names == ["Main Layer.CryptoObject"] and len(manifests) == 1, head.keys()
    import json

    manifest = json.loads(manifests[0])
    rank = planes["Main Layer.CryptoObject00.r"]
    for name, x in (("Near", 8), ("Far", 56)):
        assert np.float32(rank[24, x]).view(np.uint32) == int(manifest[name], 16), (name, manifest)


def case_denoise():
    """Denoised pictures: what the compositor's Denoise node makes of our noisy passes, to the last bit; the passes stay noisy; errors are told."""
    scene = lit_room(samples=8)
    layer = bpy.context.view_layer
    layer.cycles.denoising_store_passes = True
    scene.rayloom.use_denoising = True
    said, say_stage = [], module("engine").RayloomRenderEngine._say
    module("engine").RayloomRenderEngine._say = lambda self, stage, share: (said.append(stage), say_stage(self, stage, share))[1]
    render("layers", layers=True)
    module("engine").RayloomRenderEngine._say = say_stage
    assert "Denoising" in said, said
    planes, _ = layers_of(os.path.join(stage.FOLDER, "layers.exr"))

    def of(name, channels="RGB"):
        return np.stack([planes[f"ViewLayer.{name}.{c}"] for c in channels], axis=-1)

    clean, noisy = of("Combined"), of("Noisy Image")
    assert np.isfinite(of("Denoising Normal", "XYZ")).all() and abs(np.median(of("Denoising Albedo")) - 0.8) < 0.01 and of("Denoising Depth", "Z").max() > 4
    tree, end = compositor_tree(scene)
    source, node = tree.nodes.new("CompositorNodeRLayers"), tree.nodes.new("CompositorNodeDenoise")
    for inner, outer in (("Image", "Noisy Image"), ("Normal", "Denoising Normal"), ("Albedo", "Denoising Albedo")):
        tree.links.new(source.outputs[outer], node.inputs[inner])
    tree.links.new(node.outputs[0], end)
    theirs = render("node")[:, :, :3]
    difference = np.abs(theirs - clean)
    say(f"to Blender's Denoise node: at most {difference.max():.2e}; noise taken away: {np.sqrt(((clean - noisy) ** 2).mean()):.4f} of a mean of {clean.mean():.3f}")
    # Reference: 64 times the samples, not denoised.
    if hasattr(scene, "compositing_node_group"):
        scene.compositing_node_group = None
    else:
        scene.use_nodes = False
    scene.rayloom.use_denoising, scene.rayloom.samples = False, 512
    truth = render("truth")[:, :, :3]
    errors = [float(np.sqrt(((np.clip(p, 0, 1) - np.clip(truth, 0, 1)) ** 2).mean())) for p in (noisy, clean)]
    say(f"error at 8 samples: noisy {errors[0]:.4f}, denoised {errors[1]:.4f}")
    assert difference.max() < 1e-5, difference.max()
    assert errors[1] < 0.5 * errors[0], errors
    # Colours alone, and without the library.
    scene.rayloom.use_denoising, scene.rayloom.samples = True, 8
    scene.rayloom.denoising_input_passes = "RGB"
    layer.cycles.denoising_store_passes = False
    alone = render("alone")[:, :, :3]
    assert 1e-4 < np.abs(alone - clean).mean() < 0.1 and np.sqrt(((np.clip(alone, 0, 1) - np.clip(truth, 0, 1)) ** 2).mean()) < errors[0]
    denoiser = module("core.denoiser")
    find, denoiser.find = denoiser.find, lambda *a: None
    os.environ["RAYLOOM_OIDN"] = "/nowhere"
    render_error("Open Image Denoise was not found")
    denoiser.find = find
    del os.environ["RAYLOOM_OIDN"]


def case_mist_motion_occlusion_and_catchers_are_cycles():
    """Passes and shadow catchers in Blender's file beside Cycles' own of the same scene."""
    scene = lit_room(samples=64, size=(64, 48))
    scene.cycles.use_denoising, scene.cycles.use_adaptive_sampling, scene.cycles.device = False, False, "CPU"
    scene.cycles.samples = scene.rayloom.samples
    scene.rayloom.follow_cycles = True
    scene.world = bpy.data.worlds.new("World")
    scene.world.mist_settings.start, scene.world.mist_settings.depth, scene.world.light_settings.distance = 3, 8, 1.5
    for name in ("Mirror", "Glass"):
        inputs = bpy.data.materials[name].node_tree.nodes["Principled BSDF"].inputs
        inputs["Metallic"].default_value = inputs["Transmission Weight"].default_value = 0
        inputs["Roughness"].default_value = 0.5
    ball, layer = bpy.data.objects["Sphere"], bpy.context.view_layer
    for frame, x in ((1, -2.0), (2, -1.7), (3, -1.2)):
        ball.location.x = x
        ball.keyframe_insert("location", frame=frame)
    scene.frame_set(2)
    for name in ("mist", "vector", "ambient_occlusion"):
        setattr(layer, f"use_pass_{name}", True)

    def both(names):
        out = []
        for engine in ("CYCLES", "RAYLOOM"):
            scene.render.engine = engine
            render(engine, layers=True)
            planes, _ = layers_of(os.path.join(stage.FOLDER, f"{engine}.exr"))
            out.append({n: np.stack([planes[f"ViewLayer.{pass_name(n)}.{c}"] for c in channels], axis=-1) for n, channels in names})
        return out

    def held(name, theirs, ours, typical, mean):
        middle, off = float(np.median(np.abs(theirs - ours))), float(np.abs(theirs.mean((0, 1)) - ours.mean((0, 1))).max())
        say(f"{name}: Cycles {np.round(theirs.mean((0, 1)), 4).tolist()}, ours {np.round(ours.mean((0, 1)), 4).tolist()}, median difference {middle:.5f}")
        assert np.abs(theirs).max() > 0 and middle < typical and off < mean, (name, middle, off)

    theirs, ours = both((("Mist", "Z"), ("Vector", "XYZW"), ("AO", "RGB")))
    held("Mist", theirs["Mist"], ours["Mist"], 0.001, 0.002)
    held("AO", theirs["AO"], ours["AO"], 0.02, 0.005)
    held("Vector", theirs["Vector"], ours["Vector"], 0.001, 0.02)
    told = " ".join(log_texts())
    assert "is not rendered" not in told, told
    bpy.data.objects["Floor"].is_shadow_catcher = True
    scene.render.film_transparent = True
    theirs, ours = both((("Combined", "RGBA"),))
    held("Combined over a catcher", theirs["Combined"], ours["Combined"], 0.01, 0.01)
    layer.cycles.use_pass_shadow_catcher = True
    theirs, ours = both((("Combined", "RGBA"), ("Shadow Catcher", "RGB")))
    held("Combined beside the catcher's pass", theirs["Combined"], ours["Combined"], 0.01, 0.01)
    held("Shadow Catcher", theirs["Shadow Catcher"], ours["Shadow Catcher"], 0.03, 0.01)
