#!/usr/bin/env python3
"""The table of Cycles' microfibre sheen: writes src/kernel/bsdf/sheen.txt. Needs Blender's Python (bpy 4.5) and OpenEXR.

  python tests/measured/cycles_sheen.py src/kernel/bsdf/sheen.txt

A plane of the Sheen closure is lit by a sun without size from three directions in turn; a sample a pixel is exact. The lobe is a linearly
transformed cosine (Zeltner, Burley and Chiang 2022), so that three values give its three numbers. Between the cosines and roughnesses of the
grid Cycles mixes them linearly (checked at 64 places: values agree within 4e-5)."""
import math, os, sys
import bpy, numpy as np, OpenEXR

N = 32
SLANT = math.radians(50)

def solve(up, near, far):
    """The lobe's numbers from its values towards the normal and 50 degrees off it on the viewer's side and the other."""
    s, c = math.sin(SLANT), math.cos(SLANT)
    # The root of a value is sqrt(albedo) a / (quadratic form of the direction): three values give the form.
    z, plus, minus = 1 / math.sqrt(up), math.sqrt(c / near), math.sqrt(c / far)
    aa = ((plus + minus) / 2 - c * c * z) / (s * s)
    ab = (plus - minus) / (4 * s * c)
    scale = z - ab * ab / aa
    a = math.sqrt(aa / scale)
    return a, ab / aa * a, 1 / (scale * a) ** 2

def main():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.use_adaptive_sampling, scene.cycles.use_denoising = 1, False, False
    scene.render.resolution_x = scene.render.resolution_y = 1
    scene.render.image_settings.file_format, scene.render.image_settings.color_depth = "OPEN_EXR", "32"
    scene.world = bpy.data.worlds.new("World")
    scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs[0].default_value = (0, 0, 0, 1)
    # Small: on a plane of a kilometre a few rays in a hundred meet the face that they leave.
    bpy.ops.mesh.primitive_plane_add(size=4)
    material = bpy.data.materials.new("Material")
    material.use_nodes = True
    tree = material.node_tree
    sheen = tree.nodes.new("ShaderNodeBsdfSheen")
    sheen.inputs["Color"].default_value = (1, 1, 1, 1)
    tree.links.new(sheen.outputs[0], tree.nodes["Material Output"].inputs[0])
    bpy.context.object.data.materials.append(material)
    camera = bpy.data.cameras.new("Camera")
    camera.type, camera.ortho_scale = "ORTHO", 0.01
    scene.camera = bpy.data.objects.new("Camera", camera)
    sun = bpy.data.lights.new("Sun", "SUN")
    sun.energy, sun.angle = math.pi, 0
    light = bpy.data.objects.new("Sun", sun)
    for o in (scene.camera, light):
        scene.collection.objects.link(o)
    scene.render.filepath = f"/tmp/cycles_sheen_{os.getpid()}.exr"

    def seen(cos, roughness):
        angle = math.acos(cos)
        # Off the diagonal between the plane's two faces.
        scene.camera.location = (0.7 + 10 * math.sin(angle), -0.3, 10 * math.cos(angle))
        scene.camera.rotation_euler = (0, angle, 0)
        sheen.inputs["Roughness"].default_value = roughness
        out = []
        for elevation in (0, SLANT, -SLANT):
            light.rotation_euler = (0, elevation, 0)
            bpy.ops.render.render(write_still=True)
            channels = OpenEXR.File(scene.render.filepath).channels()
            out.append(float((channels.get("RGB") or channels.get("RGBA")).pixels[0, 0, 0]))
        return out

    # Nothing is seen from exactly beside: the first row is a little above it, and drawn on to it.
    cosines = [0.004] + [i / (N - 1) for i in range(1, N)]
    table = np.zeros((N, N, 3))
    for i, cos in enumerate(cosines):
        for j in reversed(range(N)):
            lit = seen(cos, j / (N - 1))
            table[i, j] = solve(*lit) if min(lit) > 1e-7 else (table[i, min(j + 1, N - 1), 0], 0, 0)
    above = cosines[0] * (N - 1)
    table[0] = (table[0] - above * table[1]) / (1 - above)
    table[..., 0] = table[..., 0].clip(1e-3, 1)
    table[..., 2] = table[..., 2].clip(0, 1)
    table[table[..., 2] < 3e-6, 1:] = 0
    version = bpy.app.version_string.split()[0]
    with open(sys.argv[1], "w") as out:
        out.write(f"# Sheen of microfibres by Zeltner, Burley and Chiang 2022, measured of Cycles {version} by tests/measured/cycles_sheen.py: a, b and the albedo\n")
        out.write(f"# of the linear transform, for {N} even cosines of the viewer from 0 to 1 (outer) and {N} even roughnesses from 0 to 1 (inner).\n")
        for entry in table.reshape(-1, 3):
            out.write("%.5f %.5f %.5f\n" % tuple(entry))

main()
sys.stdout.flush()
os._exit(0)
