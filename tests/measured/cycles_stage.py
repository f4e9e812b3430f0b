"""What the scripts that measure a closure of Cycles along single directions share: an empty scene without tricks, a closure, a sun, a
camera, the picture. Needs Blender's Python (bpy 4.5) and OpenEXR."""
import os
import tempfile

import bpy
import numpy as np
import OpenEXR

OUT = os.path.join(tempfile.gettempdir(), "cycles_stage.exr")


def stage(size, samples):
    """An empty scene of `size` times `size` pixels, rendered without denoising, clamps or filters of caustics."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    s = bpy.context.scene
    s.render.engine = "CYCLES"
    s.render.resolution_x = s.render.resolution_y = size
    s.render.image_settings.file_format, s.render.image_settings.color_depth = "OPEN_EXR", "32"
    s.render.filepath = OUT
    s.cycles.use_adaptive_sampling = s.cycles.use_denoising = False
    s.cycles.sample_clamp_indirect = s.cycles.blur_glossy = 0
    s.cycles.samples = samples
    return s


def closure(kind):
    """A material of one closure, and its node."""
    m = bpy.data.materials.new("M")
    m.use_nodes = True
    m.node_tree.nodes.clear()
    out, b = m.node_tree.nodes.new("ShaderNodeOutputMaterial"), m.node_tree.nodes.new(kind)
    m.node_tree.links.new(b.outputs[0], out.inputs[0])
    return m, b


def sun(s, irradiance, turn):
    """A sun without size, turned by Euler's angles."""
    light = bpy.data.lights.new("S", "SUN")
    light.energy, light.angle = irradiance, 0
    o = bpy.data.objects.new("S", light)
    o.rotation_euler = turn
    s.collection.objects.link(o)


def narrow_camera(s, at, turn=(0, 0, 0)):
    """An orthographic camera that sees a hundredth of a unit."""
    camera = bpy.data.cameras.new("C")
    camera.type, camera.ortho_scale = "ORTHO", 0.01
    s.camera = bpy.data.objects.new("C", camera)
    s.camera.location, s.camera.rotation_euler = at, turn
    s.collection.objects.link(s.camera)


def red():
    """The picture's first channel."""
    bpy.ops.render.render(write_still=True)
    with OpenEXR.File(OUT) as f:
        return np.array(next(c for n, c in f.channels().items() if n.startswith("RGB")).pixels)[..., 0]
