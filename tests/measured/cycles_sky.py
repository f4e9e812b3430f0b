#!/usr/bin/env python3
"""Radiance of Cycles' Nishita sky along a few directions: writes cycles_sky.txt. Needs Blender's Python (bpy 4.5) and OpenEXR.

Each line: elevation of the sun, its rotation, densities of air, dust and ozone, altitude, elevation and azimuth of the direction (degrees; azimuth
from +x to +y), red, green, blue; strength 1, no disc. The camera is orthographic, so that all its rays have one direction."""
import math, os, sys
import bpy, numpy as np, OpenEXR

def pixels(path):
    c = OpenEXR.File(path).channels()
    return np.asarray((c.get("RGB") or c.get("RGBA")).pixels, float)[..., :3].mean((0, 1))

def main():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.use_adaptive_sampling, scene.cycles.use_denoising = 16, False, False
    scene.render.resolution_x = scene.render.resolution_y = 4
    scene.render.image_settings.file_format, scene.render.image_settings.color_depth = "OPEN_EXR", "32"
    scene.world = bpy.data.worlds.new("World")
    scene.world.use_nodes = True
    tree = scene.world.node_tree
    sky = tree.nodes.new("ShaderNodeTexSky")
    sky.sky_type = "NISHITA"
    tree.links.new(sky.outputs[0], tree.nodes["Background"].inputs["Color"])
    data = bpy.data.cameras.new("Camera")
    data.type = "ORTHO"
    scene.camera = bpy.data.objects.new("Camera", data)
    scene.collection.objects.link(scene.camera)
    path = f"/tmp/cycles_sky_{os.getpid()}.exr"
    scene.render.filepath = path
    print(f"# Cycles {bpy.app.version_string}, tests/measured/cycles_sky.py: sun's elevation and rotation, air, dust, ozone, altitude, elevation and azimuth, red green blue")
    skies = ((25, 120, 1, 1, 1, 0), (60, 0, 1, 1, 1, 0), (5, 0, 1, 1, 1, 0), (60, 137.5, 1, 1, 4, 3000), (3, 137.5, 1.5, 3, 1, 0), (5, 0, 0, 10, 0, 0))
    for values in skies:
        sun, turn = values[:2]
        sky.sun_disc = False
        sky.sun_elevation, sky.sun_rotation = math.radians(sun), math.radians(turn)
        sky.air_density, sky.dust_density, sky.ozone_density, sky.altitude = values[2:]
        for elevation in (89, 30, 10, 3, 0.5, -5):
            for azimuth in (0, 90, 180):
                e, a = math.radians(elevation), math.radians(azimuth)
                # The camera looks along -z of its own space.
                scene.camera.rotation_euler = (math.pi / 2 + e, 0, a - math.pi / 2)
                bpy.ops.render.render(write_still=True)
                words = " ".join(str(v) for v in (*values, elevation, azimuth))
                print(f"sky {words} " + " ".join(f"{v:.6f}" for v in pixels(path)), flush=True)

main()
sys.stdout.flush()
os._exit(0)
