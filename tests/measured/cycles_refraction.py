#!/usr/bin/env python3
"""Rough refraction of Cycles towards suns: a plane with a Refraction BSDF, seen from above, lit from below along single directions.

  python cycles_refraction.py > cycles_refraction.txt        (a Python with bpy 4.5 and OpenEXR)
"""
import math

import bpy
from cycles_stage import closure, narrow_camera, red, stage, sun
from mathutils import Vector


def value(view, light, roughness, ior):
    """The closure's value times the cosine of the light: view and light in degrees from the normal's two ends, away from each other."""
    s = stage(4, 1)
    m, b = closure("ShaderNodeBsdfRefraction")
    b.distribution = "GGX"
    b.inputs["Color"].default_value, b.inputs["Roughness"].default_value, b.inputs["IOR"].default_value = (1, 1, 1, 1), roughness, ior
    bpy.ops.mesh.primitive_plane_add(size=40)
    bpy.context.object.data.materials.append(m)
    to = Vector((-math.sin(math.radians(light)), 0, -math.cos(math.radians(light))))
    sun(s, 10, to.to_track_quat("Z", "Y").to_euler())
    d = Vector((math.sin(math.radians(view)), 0, math.cos(math.radians(view))))
    narrow_camera(s, d * 5, (-d).to_track_quat("-Z", "Y").to_euler())
    return float(red().mean()) / 10


def main():
    print("# Cycles 4.5 (bpy): roughness, index, view, light (degrees), value times cosine of the light; by cycles_refraction.py")
    for roughness, ior in ((0.64, 1.45), (0.4, 1.8)):
        for view in (10, 30, 63, 80):
            for light in (-70, -50, -30, -10, 0, 10, 30, 50, 70):
                print(roughness, ior, view, light, f"{value(view, light, roughness, ior):.6g}", flush=True)


main()
