#!/usr/bin/env python3
"""Random walks of Cycles below a surface: half spaces and slabs of a Subsurface Scattering closure, radius 1, seen and lit along the normal.

  python cycles_subsurface.py > cycles_subsurface.txt        (a Python with bpy 4.5 and OpenEXR; 15 minutes on two cores)
"""
import math
import os
import tempfile

import bpy
import numpy as np
import OpenEXR

OUT = os.path.join(tempfile.gettempdir(), "cycles_subsurface.exr")


def scene(albedo, g, depth, behind):
    """Light that comes back of a sun of irradiance π, or through (`behind`): what the body reflects or lets through, and the standard error."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    s = bpy.context.scene
    s.render.engine = "CYCLES"
    s.render.resolution_x = s.render.resolution_y = 16
    s.render.image_settings.file_format, s.render.image_settings.color_depth = "OPEN_EXR", "32"
    s.cycles.use_adaptive_sampling = s.cycles.use_denoising = False
    s.cycles.sample_clamp_indirect = s.cycles.blur_glossy = 0
    s.cycles.samples = 1024
    s.cycles.max_bounces, s.cycles.diffuse_bounces = 64, 0
    m = bpy.data.materials.new("M")
    m.use_nodes = True
    m.node_tree.nodes.clear()
    out, b = m.node_tree.nodes.new("ShaderNodeOutputMaterial"), m.node_tree.nodes.new("ShaderNodeSubsurfaceScattering")
    b.falloff = "RANDOM_WALK"
    b.inputs["Color"].default_value, b.inputs["Radius"].default_value, b.inputs["Scale"].default_value = (albedo,) * 3 + (1,), (1, 1, 1), 1.0
    b.inputs["IOR"].default_value, b.inputs["Roughness"].default_value, b.inputs["Anisotropy"].default_value = 1.01, 0.0, g
    m.node_tree.links.new(b.outputs[0], out.inputs[0])
    bpy.ops.mesh.primitive_cube_add(size=1)
    body = bpy.context.object
    # Off the middle: rays along the diagonal of a face slip between its triangles.
    body.scale, body.location = (800, 800, depth), (71.3, -123.7, -depth / 2)
    body.data.materials.append(m)
    sun = bpy.data.lights.new("S", "SUN")
    sun.energy, sun.angle = math.pi, 0
    o = bpy.data.objects.new("S", sun)
    o.rotation_euler = (math.pi if behind else 0, 0, 0)
    s.collection.objects.link(o)
    camera = bpy.data.cameras.new("C")
    camera.type, camera.ortho_scale = "ORTHO", 0.01
    c = bpy.data.objects.new("C", camera)
    c.location = (0, 0, 50)
    s.collection.objects.link(c)
    s.camera = c
    s.render.filepath = OUT
    bpy.ops.render.render(write_still=True)
    with OpenEXR.File(OUT) as f:
        a = np.array(next(c for n, c in f.channels().items() if n.startswith("RGB")).pixels)[..., 0]
    return f"{a.mean():.5f} {a.std() / 16:.5f}"


def main():
    print("# Cycles 4.5 (bpy): reflected or through, albedo, mean cosine, depth, value, standard error; by cycles_subsurface.py")
    for g in (0, 0.08, 0.15, 0.3, 0.4, 0.5, 0.6, 0.65, 0.7, 0.75, 0.8, 0.85, 0.9):
        for albedo in (0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.65, 0.7, 0.75, 0.8, 0.85, 0.9):
            print("reflected", albedo, g, 400, scene(albedo, g, 400, False), flush=True)
    for g in (0, 0.6, 0.8, 0.9):
        for depth in (0.03, 0.1, 0.3, 1):
            print("reflected", 1, g, depth, scene(1.0, g, depth, False), flush=True)
            print("through", 1, g, depth, scene(1.0, g, depth, True), flush=True)


main()
