#!/usr/bin/env python3
"""What rough glass keeps of light by Cycles' table: a plane with a Glass BSDF before one sun, of one bounce (GGX) over all (Multiscatter GGX).

  python cycles_glass.py > cycles_glass.txt        (a Python with bpy 4.5 and OpenEXR)
"""
import math
import os
import tempfile

import bpy
import numpy as np
import OpenEXR
from mathutils import Vector

OUT = os.path.join(tempfile.gettempdir(), "cycles_glass.exr")


def value(distribution, roughness, ior, cos):
    """Radiance towards a viewer at a cosine, of a sun behind the plane."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    s = bpy.context.scene
    s.render.engine = "CYCLES"
    s.render.resolution_x = s.render.resolution_y = 4
    s.render.image_settings.file_format, s.render.image_settings.color_depth = "OPEN_EXR", "32"
    s.cycles.use_adaptive_sampling = s.cycles.use_denoising = False
    s.cycles.sample_clamp_indirect = s.cycles.blur_glossy = 0
    s.cycles.samples = 1
    m = bpy.data.materials.new("M")
    m.use_nodes = True
    m.node_tree.nodes.clear()
    out, b = m.node_tree.nodes.new("ShaderNodeOutputMaterial"), m.node_tree.nodes.new("ShaderNodeBsdfGlass")
    b.distribution = distribution
    b.inputs["Color"].default_value, b.inputs["Roughness"].default_value, b.inputs["IOR"].default_value = (1, 1, 1, 1), roughness, ior
    m.node_tree.links.new(b.outputs[0], out.inputs[0])
    bpy.ops.mesh.primitive_plane_add(size=40)
    bpy.context.object.data.materials.append(m)
    sun = bpy.data.lights.new("S", "SUN")
    sun.energy, sun.angle = 10, 0
    o = bpy.data.objects.new("S", sun)
    s.collection.objects.link(o)
    o.rotation_euler = Vector((-math.sin(0.9), 0, -math.cos(0.9))).to_track_quat("Z", "Y").to_euler()
    camera = bpy.data.cameras.new("C")
    camera.type, camera.ortho_scale = "ORTHO", 0.01
    c = bpy.data.objects.new("C", camera)
    s.collection.objects.link(c)
    d = Vector((math.sqrt(1 - cos * cos), 0, cos))
    c.location, c.rotation_euler = d * 5, (-d).to_track_quat("-Z", "Y").to_euler()
    s.camera = c
    s.render.filepath = OUT
    bpy.ops.render.render(write_still=True)
    with OpenEXR.File(OUT) as f:
        return float(np.array(next(c for n, c in f.channels().items() if n.startswith("RGB")).pixels)[..., 0].mean())


def main():
    print("# Cycles 4.5 (bpy): roughness, index (below 1: from within), cosine of the viewer, what is kept; by cycles_glass.py")
    for roughness, ior in ((0.4, 1 / 1.5), (0.8, 1 / 1.5), (0.8, 0.5), (1.0, 1 / 1.33), (0.8, 1.5), (1.0, 1.33)):
        for k in (1, 2, 3, 5, 7, 9, 12):
            cos = k / 15
            print(roughness, round(ior, 5), round(cos, 5), f"{value('GGX', roughness, ior, cos) / value('MULTI_GGX', roughness, ior, cos):.5f}", flush=True)


main()
