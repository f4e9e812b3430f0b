# SPDX-License-Identifier: GPL-3.0-or-later
"""The files that the extension writes: speed, Blender's own importer, the schema."""

import os
import time

import bpy
import numpy as np
import stage
from stage import emission, load, module, new_scene, say, wall


def case_export_of_a_million_triangles_is_fast():
    """1 M triangles with smooth normals and UVs, within 1.5 s of CPU time."""
    scene = new_scene()
    n = 708
    x, y = np.meshgrid(np.linspace(-1, 1, n), np.linspace(-1, 1, n))
    mesh = bpy.data.meshes.new("Big")
    points = np.stack([x, y, 0.1 * np.sin(9 * x) * np.cos(7 * y)], axis=-1).reshape(-1, 3)
    corner = np.arange(n * n).reshape(n, n)
    faces = np.stack([corner[:-1, :-1], corner[:-1, 1:], corner[1:, 1:], corner[1:, :-1]], axis=-1).reshape(-1, 4)
    mesh.from_pydata(points, [], faces)
    mesh.polygons.foreach_set("use_smooth", np.ones(len(faces), bool))
    uv = (points[:, :2] * 0.5 + 0.5)[faces.ravel()]
    mesh.uv_layers.new(name="UVMap").data.foreach_set("uv", uv.astype(np.float32).ravel())
    scene.collection.objects.link(bpy.data.objects.new("Big", mesh))
    seconds = []
    for _ in range(3):
        start = time.process_time()
        exporter = module("exporting").export_scene(os.path.join(stage.FOLDER, "big.glb"), scene)
        seconds.append(time.process_time() - start)
    triangles = exporter.gltf.document["accessors"][-1]["count"] // 3
    say(f"{2 * len(faces)} triangles: {min(seconds):.2f} s of CPU time (of {seconds}), {exporter.gltf.written_bytes} bytes, {triangles}")
    assert min(seconds) < 1.5, seconds


def case_blenders_importer_opens_the_export():
    """Round trip: objects, meshes, UVs, materials, camera and lamp come back where they were."""
    scene = new_scene()
    obj = wall("Wall", -1, 1, -2, 2, material=emission("E", (1, 0, 0)))
    obj.location, obj.rotation_euler = (1, 2, 3), (0.1, 0.2, 0.3)
    lamp = bpy.data.objects.new("Spot", bpy.data.lights.new("Spot", "SPOT"))
    lamp.data.energy, lamp.location = 500, (3, -1, 4)
    scene.collection.objects.link(lamp)
    bpy.context.view_layer.update()
    places = sorted(tuple(np.round(obj.matrix_world @ v.co, 4)) for v in obj.data.vertices)
    path = os.path.join(stage.FOLDER, "trip.glb")
    assert bpy.ops.export_scene.rayloom(filepath=path) == {"FINISHED"}
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    assert bpy.ops.import_scene.gltf(filepath=path, export_import_convert_lighting_mode="SPEC") == {"FINISHED"}
    objects = bpy.data.objects
    back = objects["Wall"]
    assert np.allclose(sorted(tuple(np.round(back.matrix_world @ v.co, 4)) for v in back.data.vertices), places, atol=1e-3)
    assert back.data.materials[0].name == "E" and len(back.data.uv_layers) == 1
    assert abs(objects["Spot"].data.energy - 500) < 1, objects["Spot"].data.energy
    assert np.allclose(objects["Camera"].matrix_world.translation, (0, -5, 0), atol=1e-4)


def case_every_file_keeps_to_the_schema():
    """A scene with much in it against docs/schema; runs where jsonschema is installed."""
    try:
        import jsonschema
    except ImportError:
        say("jsonschema is not installed: not checked")
        return
    import json

    scene = new_scene()
    scene.rayloom.use_adaptive_sampling = True
    scene.camera.data.dof.use_dof = True
    material = bpy.data.materials.new("P")
    material.use_nodes = True
    wall("W", -1, 1, -1, 1, material=material)
    for kind in ("POINT", "SUN", "SPOT", "AREA"):
        scene.collection.objects.link(bpy.data.objects.new(kind, bpy.data.lights.new(kind, kind)))
    scene.world = bpy.data.worlds.new("World")
    exporter = module("exporting").export_scene(os.path.join(stage.FOLDER, "all.glb"), scene)
    assert not exporter.log.entries, exporter.log.entries
    document = exporter.gltf.document
    with open(os.path.join(os.path.dirname(__file__), "..", "..", "..", "docs", "schema", "RAYLOOM_scene.schema.json"), encoding="utf-8") as file:
        validator = jsonschema.Draft202012Validator(json.load(file))
    wrong = [f"{list(e.absolute_path)}: {e.message[:200]}" for e in validator.iter_errors(document)]
    assert not wrong, wrong
    document["extensions"]["RAYLOOM_scene"]["lights"][0]["watts"] = 3
    assert list(validator.iter_errors(document)), "a wrong key is found"
