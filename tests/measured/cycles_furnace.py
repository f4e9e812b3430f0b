#!/usr/bin/env python3
"""What Cycles' Principled closure gives back of white light from everywhere. Needs Blender's Python (bpy 4.5) and OpenEXR.

  python tests/measured/cycles_furnace.py > tests/measured/cycles_furnace.txt
  python tests/measured/cycles_furnace.py --bent > tests/measured/cycles_bent.txt

A plane without end stands in a white world; a narrow camera looks at it at an angle; all light comes from the world after one bounce, or
after none but refraction. Each line: lobe, roughness, angle from the normal in degrees, red, green, blue (1,024 samples of 256 pixels).
With --bent the plane has a normal map of one colour: lobe, roughness, angle, tilt of the normal and its azimuth (0: to the viewer), value."""
import math, os, sys
import bpy, numpy as np, OpenEXR

WHITE, BLACK = (1, 1, 1, 1), (0, 0, 0, 1)
LOBES = {
    "plain": {"Base Color": WHITE},
    "specular": {"Base Color": BLACK},
    "specular_tinted": {"Base Color": BLACK, "Specular Tint": (1, 0.5, 0.1, 1), "Specular IOR Level": 0.8},
    "metal": {"Base Color": WHITE, "Metallic": 1},
    "metal_f82": {"Base Color": (0.9, 0.6, 0.3, 1), "Metallic": 1, "Specular Tint": (0.4, 0.8, 1, 1)},
    "coat": {"Base Color": WHITE, "Coat Weight": 1},
    "coat_black": {"Base Color": BLACK, "Coat Weight": 1, "Specular IOR Level": 0},
    "sheen": {"Base Color": BLACK, "Sheen Weight": 1, "Specular IOR Level": 0},
    "sheen_white": {"Base Color": WHITE, "Sheen Weight": 1},
    "glass": {"Base Color": WHITE, "Transmission Weight": 1},
    "film": {"Base Color": BLACK, "Thin Film Thickness": 400},
    "film_white": {"Base Color": WHITE, "Thin Film Thickness": 400},
    "rough_diffuse": {"Base Color": WHITE, "Specular IOR Level": 0},
    "rough_diffuse_grey": {"Base Color": (0.5, 0.2, 0.8, 1), "Specular IOR Level": 0},
    "aniso": {"Base Color": WHITE, "Metallic": 1, "Anisotropic": 0.8},
}
# Which roughness a lobe varies; the others' is 0.5.
VARIES = {"coat": "Coat Roughness", "coat_black": "Coat Roughness", "sheen": "Sheen Roughness", "sheen_white": "Sheen Roughness",
          "rough_diffuse": "Diffuse Roughness", "rough_diffuse_grey": "Diffuse Roughness"}

def main():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.use_adaptive_sampling, scene.cycles.use_denoising = 1024, False, False
    scene.render.resolution_x = scene.render.resolution_y = 16
    scene.render.image_settings.file_format, scene.render.image_settings.color_depth = "OPEN_EXR", "32"
    scene.world = bpy.data.worlds.new("World")
    scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs[0].default_value = WHITE
    bpy.ops.mesh.primitive_plane_add(size=1000)
    material = bpy.data.materials.new("Material")
    material.use_nodes = True
    bpy.context.object.data.materials.append(material)
    inputs = material.node_tree.nodes["Principled BSDF"].inputs
    defaults = {i.name: tuple(i.default_value) if i.type == "RGBA" else i.default_value for i in inputs if i.type in ("VALUE", "RGBA")}
    data = bpy.data.cameras.new("Camera")
    scene.camera = bpy.data.objects.new("Camera", data)
    scene.collection.objects.link(scene.camera)
    data.lens = 5000
    path = f"/tmp/cycles_furnace_{os.getpid()}.exr"
    def value(degrees, sockets):
        angle = math.radians(degrees)
        scene.camera.location = (10 * math.sin(angle), 0, 10 * math.cos(angle))
        scene.camera.rotation_euler = (0, angle, 0)
        for key, v in {**defaults, "Roughness": 0.5, **sockets}.items():
            inputs[key].default_value = v
        scene.render.filepath = path
        bpy.ops.render.render(write_still=True)
        channels = OpenEXR.File(path).channels()
        pixels = np.asarray((channels.get("RGB") or channels.get("RGBA")).pixels, float)
        return pixels[..., :3].mean((0, 1))

    lines = []
    if "--bent" in sys.argv:
        tree = material.node_tree
        bend = tree.nodes.new("ShaderNodeNormalMap")
        tree.links.new(bend.outputs[0], inputs["Normal"])
        kinds = {"metal": {"Base Color": WHITE, "Metallic": 1}, "diffuse": {"Base Color": WHITE, "Specular IOR Level": 0}, "plain": {"Base Color": WHITE}}
        for name, sockets in kinds.items():
            for tilt, azimuth in ((0, 0), (20, 0), (45, 0), (45, 180), (45, 90)):
                t, a = math.radians(tilt), math.radians(azimuth)
                n = (math.sin(t) * math.cos(a), math.sin(t) * math.sin(a), math.cos(t))
                bend.inputs["Color"].default_value = (*(0.5 + 0.5 * c for c in n), 1)
                for roughness in (1.0,) if name == "diffuse" else (0.0, 0.3, 0.6, 1.0):
                    for degrees in (10, 60):
                        v = value(degrees, {**sockets, "Roughness": roughness})[0]
                        lines.append(f"{name} {roughness} {degrees} {tilt} {azimuth} {v:.5f}")
        print(f"# Cycles {bpy.app.version_string}, tests/measured/cycles_furnace.py --bent: lobe roughness degrees tilt azimuth value")
        print("\n".join(lines))
        return
    for name, sockets in LOBES.items():
        for roughness in (0.0, 0.3, 0.6, 1.0):
            for degrees in (5, 60, 80):
                mean = value(degrees, {**sockets, VARIES.get(name, "Roughness"): roughness})
                lines.append(f"{name} {roughness} {degrees} " + " ".join(f"{v:.5f}" for v in mean))
    os.remove(path)
    print(f"# Cycles {bpy.app.version_string}, tests/measured/cycles_furnace.py: lobe roughness degrees red green blue")
    print("\n".join(lines))

main()
sys.stdout.flush()
os._exit(0)
