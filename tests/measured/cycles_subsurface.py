#!/usr/bin/env python3
"""Random walks of Cycles below a surface: half spaces and slabs of a Subsurface Scattering closure, radius 1, seen and lit along the normal.

  python cycles_subsurface.py > cycles_subsurface.txt        (a Python with bpy 4.5 and OpenEXR; 15 minutes on two cores)
"""
import math

import bpy
from cycles_stage import closure, narrow_camera, red, stage, sun


def scene(albedo, g, depth, behind):
    """Light that comes back of a sun of irradiance π, or through (`behind`): what the body reflects or lets through, and the standard error."""
    s = stage(16, 1024)
    s.cycles.max_bounces, s.cycles.diffuse_bounces = 64, 0
    m, b = closure("ShaderNodeSubsurfaceScattering")
    b.falloff = "RANDOM_WALK"
    b.inputs["Color"].default_value, b.inputs["Radius"].default_value, b.inputs["Scale"].default_value = (albedo,) * 3 + (1,), (1, 1, 1), 1.0
    b.inputs["IOR"].default_value, b.inputs["Roughness"].default_value, b.inputs["Anisotropy"].default_value = 1.01, 0.0, g
    bpy.ops.mesh.primitive_cube_add(size=1)
    body = bpy.context.object
    # Off the middle: rays along the diagonal of a face slip between its triangles.
    body.scale, body.location = (800, 800, depth), (71.3, -123.7, -depth / 2)
    body.data.materials.append(m)
    sun(s, math.pi, (math.pi if behind else 0, 0, 0))
    narrow_camera(s, (0, 0, 50))
    a = red()
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
