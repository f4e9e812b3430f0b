#!/usr/bin/env python3
"""Radiance of Cycles' skies along a few directions, and of their sun's disc: prints lines of cycles_sky.txt. Needs Blender's Python and OpenEXR.

bpy 4.5 measures its one sky by scattered sunlight (`nishita`), bpy 5.0 both of its own (`single`, `multiple`); the file has the output of both.
A line of a sky: elevation of the sun, its rotation, densities of air, dust and ozone, altitude, elevation and azimuth of the direction (degrees;
azimuth from +x to +y), red, green, blue; strength 1, no disc. A line of a disc: model, elevation of the sun, its full angle, height above the
sun's middle, red, green, blue of the disc alone, in the air of 100 m."""
import math, os, sys
import bpy, numpy as np, OpenEXR

SKIES = (
    (25, 120, 1, 1, 1, 0), (60, 0, 1, 1, 1, 0), (5, 0, 1, 1, 1, 0), (60, 137.5, 1, 1, 4, 3000), (3, 137.5, 1.5, 3, 1, 0), (5, 0, 0, 10, 0, 0),
    (100, 30, 1, 1, 1, 100),
)
MORE_SKIES = SKIES + (
    (15, 0, 1, 1, 1, 100), (-3, 200, 1, 1, 1, 100), (-10, 0, 1, 1, 1, 1000), (90, 0, 10, 1, 1, 100), (20, 0, 1, 1, 10, 100), (30, 0, 0.2, 0, 0, 500),
    (30, 0, 1, 1, 1, 50000), (2, 0, 0.5, 2, 0.5, 8000),
)
COLUMNS, ROWS = 8, 60

def picture(path):
    bpy.ops.render.render(write_still=True)
    c = OpenEXR.File(path).channels()
    return np.asarray((c.get("RGB") or c.get("RGBA")).pixels, float)[..., :3]

def setup(path):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.use_adaptive_sampling, scene.cycles.use_denoising = 1, False, False
    # All samples of a pixel go through its middle.
    scene.cycles.pixel_filter_type, scene.cycles.filter_width = "BOX", 0.01
    scene.render.image_settings.file_format, scene.render.image_settings.color_depth = "OPEN_EXR", "32"
    scene.render.filepath = path
    scene.world = bpy.data.worlds.new("World")
    scene.world.use_nodes = True
    tree = scene.world.node_tree
    sky = tree.nodes.new("ShaderNodeTexSky")
    tree.links.new(sky.outputs[0], tree.nodes["Background"].inputs["Color"])
    camera = bpy.data.cameras.new("Camera")
    camera.type = "PANO"
    scene.camera = bpy.data.objects.new("Camera", camera)
    scene.collection.objects.link(scene.camera)
    return scene, sky, camera

def panorama(camera, low, high, left, right):
    """Rows from elevation `high` down to `low`, columns from longitude `left` to `right`, degrees."""
    own = camera if hasattr(camera, "panorama_type") else camera.cycles
    own.panorama_type = "EQUIRECTANGULAR"
    own.latitude_min, own.latitude_max = math.radians(low), math.radians(high)
    own.longitude_min, own.longitude_max = math.radians(left), math.radians(right)

def set_sky(sky, values):
    sky.sun_elevation, sky.sun_rotation = (math.radians(v) for v in values[:2])
    dust = "aerosol_density" if hasattr(sky, "aerosol_density") else "dust_density"
    for name, value in zip(("air_density", dust, "ozone_density", "altitude"), values[2:]):
        setattr(sky, name, value)

def main():
    path = f"/tmp/cycles_sky_{os.getpid()}.exr"
    scene, sky, camera = setup(path)
    # The middle of the picture looks to +y: azimuth 90.
    scene.camera.rotation_euler = (math.pi / 2, 0, 0)
    models = {"NISHITA": "nishita", "SINGLE_SCATTERING": "single", "MULTIPLE_SCATTERING": "multiple"}
    print(f"# Cycles {bpy.app.version_string}, tests/measured/cycles_sky.py: sun's elevation and rotation, air, dust, ozone, altitude, elevation and azimuth, red green blue")
    for kind in sky.bl_rna.properties["sky_type"].enum_items.keys():
        if kind not in models:
            continue
        sky.sky_type, word = kind, models[kind]
        multiple = word == "multiple"
        sky.sun_disc = False
        panorama(camera, -90, 90, -180, 180)
        scene.render.resolution_x, scene.render.resolution_y = COLUMNS, ROWS
        for values in MORE_SKIES if multiple else SKIES:
            set_sky(sky, values)
            seen = picture(path)
            for row in (0, 8, 20, 26, 28, 29, *((30, 33, 45, 59) if multiple else (31,))):
                for column in range(0, COLUMNS, 3):
                    azimuth = 90 - ((column + 0.5) / COLUMNS - 0.5) * 360
                    words = " ".join(str(v) for v in (*values, 90 - (row + 0.5) * 180 / ROWS, azimuth))
                    print(f"{word} {words} " + " ".join(f"{v:.6g}" for v in seen[row, column]), flush=True)
        scene.render.resolution_x, scene.render.resolution_y = 2, 41
        for elevation, size in ((60, 4), (20, 0.545), (3, 4), (0, 4), (-1, 4)):
            set_sky(sky, (elevation, 0, 1, 1, 1, 100))
            sky.sun_size = math.radians(size)
            half = 0.5 * size
            panorama(camera, elevation - half, elevation + half, -0.0001, 0.0001)
            both = []
            for sky.sun_disc in (True, False):
                both.append(picture(path)[:, 0])
            for row in (1, 8, 20, 26, 32, 39):
                up = half - (row + 0.5) * size / 41
                print(f"disc {word} {elevation} {size} {up:.6f} " + " ".join(f"{v:.6g}" for v in both[0][row] - both[1][row]), flush=True)

main()
sys.stdout.flush()
os._exit(0)
