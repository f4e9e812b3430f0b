# SPDX-License-Identifier: GPL-3.0-or-later
"""Where everything is while the shutter is open: matrices of nodes, vertices and normals of meshes that deform."""

import numpy as np

from ..core.schema import NAME
from . import instance, mesh

# Cycles allows 2^7 + 1 times; each is a whole evaluation of the scene.
_MOST_STEPS = 5


def deforms(obj):
    """Whether an object's vertices may move in time."""
    original = obj.original
    keys = original.data.shape_keys if hasattr(original.data, "shape_keys") else None
    return bool(keys) or any(m.show_render for m in original.modifiers)


def _switches(objects):
    """Names of objects that are not blurred, names of those whose vertices are not, and the most steps that one asks for."""
    still, rigid, most = set(), set(), 1
    for obj in objects:
        own = getattr(obj, "cycles", None)
        if own is None:
            continue
        if not getattr(own, "use_motion_blur", True):
            still.add(obj.name_full)
        elif not getattr(own, "use_deform_motion", True):
            rigid.add(obj.name_full)
        else:
            most = max(most, getattr(own, "motion_steps", 1))
    return still, rigid, most


def times_of(scene, steps):
    """Evenly spaced times over the shutter, in frames from the frame: 2^steps + 1 of them."""
    shutter = scene.render.motion_blur_shutter
    position = getattr(scene.render, "motion_blur_position", "CENTER")
    start = {"START": 0.0, "CENTER": -shutter / 2.0, "END": -shutter}[position]
    n = 2**steps
    return [start + shutter * k / n for k in range(n + 1)]


def write_motion(exporter, frame_set, blurred):
    """Adds to an exporter's nodes and primitives where they are over the shutter, or, not `blurred`, at the frame before, this and the next for
    the vector pass. `frame_set(frame, subframe)` moves time."""
    scene, gltf = exporter.scene, exporter.gltf
    still, rigid, steps = _switches(scene.objects) if blurred else (set(), set(), 1)
    if steps > _MOST_STEPS:
        exporter.log("Motion blur", f"{2**_MOST_STEPS + 1} times over the shutter are taken in place of {2**steps + 1}")
    times = times_of(scene, min(steps, _MOST_STEPS)) if blurred else [-1.0, 0.0, 1.0]
    deforming = {name: made for name, made in exporter.deforming.items() if name not in still | rigid}
    frame, subframe = scene.frame_current, scene.frame_subframe
    moments, shapes = [], []
    for t in times:
        at = frame + subframe + t
        frame_set(int(np.floor(at)), float(at - np.floor(at)))
        moments.append(_places(exporter))
        shapes.append(_shapes(exporter, deforming))
    frame_set(frame, subframe)
    for ix, keys in exporter.nodes:
        if not keys or any(key[1] in still for key in keys if key != "camera"):
            continue
        matrices = [[m.get(key) for m in moments] for key in keys]
        # What is not there at each of the times has no place to move to.
        if any(m is None for steps in matrices for m in steps):
            continue
        if all(m == steps[0] for steps in matrices for m in steps):
            continue
        array = np.array([instance.column_major(m) for steps in matrices for m in steps], np.float32)
        motion = {"times": times, "matrices": gltf.accessor(array)}
        gltf.document["nodes"][ix].setdefault("extensions", {}).setdefault(NAME, {})["motion"] = motion
    for name, (ix, layout, _) in deforming.items():
        steps = [s.get(name) for s in shapes]
        if any(s is None for s in steps):
            exporter.log(f"Object '{name}'", "its vertices change in number: it is not blurred")
        elif any((s[0] != steps[0][0]).any() for s in steps):
            mesh.write_motion(gltf, ix, layout, times, steps)


def _places(exporter):
    places = {shown.key: shown.matrix for shown in instance.walk(exporter.depsgraph)}
    camera = exporter.scene.camera
    if camera is not None:
        places["camera"] = camera.evaluated_get(exporter.depsgraph).matrix_world.copy()
    return places


def _shapes(exporter, deforming):
    """Vertices and normals of all deforming meshes, by object."""
    out = {}
    for shown in instance.walk(exporter.depsgraph):
        name = shown.obj.original.name_full
        if name in deforming and name not in out and shown.obj.type == "MESH":
            data = shown.obj.data
            if (len(data.vertices), len(data.loops)) == deforming[name][2]:
                out[name] = (mesh.positions_of(data), mesh.normals_of(data, deforming[name][1]["domain"]))
    return out
