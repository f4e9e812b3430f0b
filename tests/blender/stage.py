# SPDX-License-Identifier: GPL-3.0-or-later
"""What cases share: scenes of Rayloom's, walls that shine, rendering by F12's own operator, reading what was written."""

import importlib
import os

import bpy
import numpy as np

# Where a case writes; set by cases/__main__.py.
FOLDER = ""
ADDON = "bl_ext.user_default.rayloom_blender"


def module(name):
    """A module of the installed extension."""
    return importlib.import_module(f"{ADDON}.{name}")


def install(zip_path):
    """As a user does: from the file, enabled at once."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.extensions.package_install_files(filepath=zip_path, repo="user_default", enable_on_install=True)
    assert ADDON in bpy.context.preferences.addons, "the extension is not enabled"


def new_scene(size=(64, 48), samples=1):
    """An empty scene of ours, with a camera at (0, -5, 0) that looks along +y."""
    scene = bpy.context.scene
    scene.render.engine = "RAYLOOM"
    scene.render.resolution_x, scene.render.resolution_y = size
    scene.render.resolution_percentage = 100
    scene.rayloom.device = "CPU"
    scene.rayloom.follow_cycles = False
    scene.rayloom.samples = samples
    scene.view_settings.view_transform = "Standard"
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location, camera.rotation_euler = (0, -5, 0), (np.pi / 2, 0, 0)
    scene.collection.objects.link(camera)
    scene.camera = camera
    return scene


def emission(name, color, strength=1.0):
    """A material that shines; its radiance is what the picture shows."""
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    shine, end = tree.nodes.new("ShaderNodeEmission"), tree.nodes.new("ShaderNodeOutputMaterial")
    shine.inputs["Color"].default_value = (*color, 1)
    shine.inputs["Strength"].default_value = strength
    tree.links.new(shine.outputs[0], end.inputs["Surface"])
    return material


def wall(name, x0, x1, z0, z1, y=0.0, material=None):
    """A rectangle that faces the camera."""
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata([(x0, y, z0), (x1, y, z0), (x1, y, z1), (x0, y, z1)], [], [(0, 1, 2, 3)])
    layer = mesh.uv_layers.new(name="UVMap")
    layer.data.foreach_set("uv", np.array([(0, 0), (1, 0), (1, 1), (0, 1)], np.float32).ravel())
    if material:
        mesh.materials.append(material)
    obj = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(obj)
    return obj


def render(name="picture", layers=False):
    """Renders by the operator and reads what was saved: (height, width, 4), top row first."""
    render_settings = bpy.context.scene.render
    kind = render_settings.image_settings
    if hasattr(kind, "media_type"):
        kind.media_type = "MULTI_LAYER_IMAGE" if layers else "IMAGE"
    kind.file_format = "OPEN_EXR_MULTILAYER" if layers else "OPEN_EXR"
    kind.color_depth, kind.color_mode = "32", "RGBA"
    path = os.path.join(FOLDER, name + ".exr")
    if os.path.exists(path):
        os.unlink(path)
    render_settings.filepath = path
    bpy.ops.render.render(write_still=True)
    return None if layers else load(path)


def load(path):
    """The pixels of a file, top row first."""
    assert os.path.exists(path), f"no picture was written at {path}"
    image = bpy.data.images.load(path, check_existing=False)
    flat = np.empty(len(image.pixels), np.float32)
    image.pixels.foreach_get(flat)
    out = flat.reshape(image.size[1], image.size[0], image.channels)[::-1].copy()
    bpy.data.images.remove(image)
    return out


def render_error(part):
    """Rendering must fail with a text that holds `part`, and leave no picture that looks like one."""
    try:
        render("error")
    except RuntimeError as e:
        assert part in str(e), f"'{e}' does not say '{part}'"
        assert not os.path.exists(os.path.join(FOLDER, "error.exr")), "a picture was saved all the same"
        return
    raise AssertionError("the operator did not fail")


def log_texts():
    """What the log panel shows."""
    return [f"{owner}: {text}" for _, owner, text in module("core.log").entries()]


def say(text):
    """A figure for the report."""
    print(f"CASE SAYS {text}", flush=True)


def pass_name(name):
    """A pass's name in this Blender."""
    return module("core.passes").NAMES_5.get(name, name) if bpy.app.version >= (5, 0, 0) else name


def layers_of(path):
    """Planes by their whole names, top row first, and the texts of the header of a multilayer file that Blender wrote: one part or several."""
    import OpenEXR

    planes, head = {}, {}
    with OpenEXR.File(path, separate_channels=True) as file:
        for part in file.parts:
            head.update({k: v for k, v in part.header.items() if isinstance(v, str)})
            for name, channel in part.channels.items():
                planes[name if name.count(".") >= 2 else f"{part.name()}.{name}"] = np.asarray(channel.pixels, np.float32)
    return planes, head


def compositor_tree(scene):
    """An empty tree of the compositor and the socket that the picture goes into."""
    if hasattr(scene, "compositing_node_group"):
        tree = scene.compositing_node_group = bpy.data.node_groups.new("Compositor", "CompositorNodeTree")
        tree.interface.new_socket("Image", in_out="OUTPUT", socket_type="NodeSocketColor")
        return tree, tree.nodes.new("NodeGroupOutput").inputs[0]
    scene.use_nodes = True
    tree = scene.node_tree
    tree.nodes.clear()
    return tree, tree.nodes.new("CompositorNodeComposite").inputs["Image"]


def lit_room(samples, size=(96, 64)):
    """A matt ball, a mirror and a glass before walls under a lamp: noisy with few samples."""
    scene = new_scene(size, samples)
    scene.rayloom.use_adaptive_sampling = False
    for k, (name, values) in enumerate((("Matt", {}), ("Mirror", {"Metallic": 1, "Roughness": 0}), ("Glass", {"Transmission Weight": 1, "Roughness": 0}))):
        bpy.ops.mesh.primitive_uv_sphere_add(radius=0.7, location=(1.7 * (k - 1), 0, -0.3))
        material = bpy.data.materials.new(name)
        material.use_nodes = True
        for key, value in values.items():
            material.node_tree.nodes["Principled BSDF"].inputs[key].default_value = value
        bpy.context.object.data.materials.append(material)
        bpy.ops.object.shade_smooth()
    for name, place, turn in (("Floor", (0, 0, -1), (0, 0, 0)), ("Back", (0, 4, 0), (np.pi / 2, 0, 0))):
        bpy.ops.mesh.primitive_plane_add(size=14, location=place, rotation=turn)
        bpy.context.object.name = name
    lamp = bpy.data.objects.new("Lamp", bpy.data.lights.new("Lamp", "AREA"))
    lamp.data.energy, lamp.data.size, lamp.location = 150, 1.0, (0, -1, 3)
    scene.collection.objects.link(lamp)
    return scene


def alive(pid):
    """Whether a process is there."""
    try:
        os.kill(pid, 0)
        return True
    except ProcessLookupError:
        return False


def beside_cycles(name, size, samples):
    """The scene by Rayloom and by Cycles."""
    scene = bpy.context.scene
    scene.cycles.samples, scene.cycles.use_denoising, scene.cycles.device, scene.cycles.use_adaptive_sampling = samples, False, "CPU", False
    scene.rayloom.samples, scene.rayloom.use_adaptive_sampling = samples, False
    out = []
    for engine in ("RAYLOOM", "CYCLES"):
        scene.render.engine = engine
        out.append(render(f"{name} {engine}")[:, :, :3])
    return out
