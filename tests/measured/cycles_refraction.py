#!/usr/bin/env python3
"""Rough refraction of Cycles towards suns: a plane with a Refraction BSDF, seen from above, lit from below along single directions.

  python cycles_refraction.py > cycles_refraction.txt        (a Python with bpy 4.5 and OpenEXR)
"""
import math
import os
import sys
import tempfile

import bpy
import numpy as np
import OpenEXR
from mathutils import Vector

OUT = os.path.join(tempfile.gettempdir(), "cycles_refraction.exr")


def scene(view, light, roughness, ior):
    """View and light in degrees from the normal's two ends, away from each other; the sun's irradiance is 10."""
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
    out, b = m.node_tree.nodes.new("ShaderNodeOutputMaterial"), m.node_tree.nodes.new("ShaderNodeBsdfRefraction")
    b.distribution = "GGX"
    b.inputs["Color"].default_value, b.inputs["Roughness"].default_value, b.inputs["IOR"].default_value = (1, 1, 1, 1), roughness, ior
    m.node_tree.links.new(b.outputs[0], out.inputs[0])
    bpy.ops.mesh.primitive_plane_add(size=40)
    bpy.context.object.data.materials.append(m)
    sun = bpy.data.lights.new("S", "SUN")
    sun.energy, sun.angle = 10, 0
    o = bpy.data.objects.new("S", sun)
    s.collection.objects.link(o)
    to = Vector((-math.sin(math.radians(light)), 0, -math.cos(math.radians(light))))
    o.rotation_euler = to.to_track_quat("Z", "Y").to_euler()
    camera = bpy.data.cameras.new("C")
    camera.type, camera.ortho_scale = "ORTHO", 0.01
    c = bpy.data.objects.new("C", camera)
    s.collection.objects.link(c)
    d = Vector((math.sin(math.radians(view)), 0, math.cos(math.radians(view))))
    c.location, c.rotation_euler = d * 5, (-d).to_track_quat("-Z", "Y").to_euler()
    s.camera = c
    s.render.filepath = OUT


def main():
    print("# Cycles 4.5 (bpy): roughness, index, view, light (degrees), value times cosine of the light; by cycles_refraction.py")
    for roughness, ior in ((0.64, 1.45), (0.4, 1.8)):
        for view in (10, 30, 63, 80):
            for light in (-70, -50, -30, -10, 0, 10, 30, 50, 70):
                scene(view, light, roughness, ior)
                bpy.ops.render.render(write_still=True)
                with OpenEXR.File(OUT) as f:
                    value = float(np.array(next(c for n, c in f.channels().items() if n.startswith("RGB")).pixels)[..., 0].mean()) / 10
                print(roughness, ior, view, light, f"{value:.6g}", flush=True)


main()
