"""What the scenes share: a case's registry, things to put on the stage, lamps, cameras, materials. Imports bpy."""

import math

import bmesh
import bpy
import numpy as np
from mathutils import Vector

CASES = {}


def case(name, about, size=(72, 54), spp=16):
    """Registers a scene: `name` is its folder below tests/scenes/path."""

    def register(build):
        assert name not in CASES, name
        CASES[name] = (build, about, size, spp)
        return build

    return register


def fresh(size):
    """An empty scene in which Cycles only traces paths: no clamps, no adaptive sampling, no denoiser."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y = size
    scene.render.resolution_percentage = 100
    c = scene.cycles
    c.device = "CPU"
    c.samples = 64
    c.use_adaptive_sampling = c.use_denoising = False
    c.sample_clamp_direct = c.sample_clamp_indirect = c.blur_glossy = 0.0
    world((0.22, 0.25, 0.32))
    return scene


def world(color, strength=1.0):
    """A world of one colour."""
    w = bpy.data.worlds.new("World")
    bpy.context.scene.world = w
    w.use_nodes = True
    back = next(n for n in w.node_tree.nodes if n.type == "BACKGROUND")
    back.inputs["Color"].default_value = (*color, 1.0)
    back.inputs["Strength"].default_value = strength
    return w


def add(name, data):
    """An object in the scene."""
    o = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(o)
    return o


def look_at(o, target):
    """Turns -z towards a place."""
    o.rotation_euler = (Vector(target) - o.location).to_track_quat("-Z", "Y").to_euler()


def camera(place=(0.0, -5.0, 2.2), target=(0.0, 0.0, 0.85), lens=50.0, **settings):
    """The camera; `settings` are those of its data."""
    data = bpy.data.cameras.new("Camera")
    data.lens = lens
    for key, value in settings.items():
        setattr(data, key, value)
    o = add("Camera", data)
    o.location = place
    look_at(o, target)
    bpy.context.scene.camera = o
    return o


def lamp(kind, place, target=None, energy=100.0, **settings):
    """A lamp; `settings` are those of its data."""
    data = bpy.data.lights.new(kind.capitalize(), kind)
    data.energy = energy
    for key, value in settings.items():
        setattr(data, key, value)
    o = add(kind.capitalize(), data)
    o.location = place
    if target is not None:
        look_at(o, target)
    return o


def mesh(name, vertices, faces, material=None, uv=None, smooth=False):
    """An object of faces; `uv` has a pair a corner."""
    data = bpy.data.meshes.new(name)
    data.from_pydata(vertices, [], faces)
    data.update()
    if uv is not None:
        data.uv_layers.new(name="UVMap").data.foreach_set("uv", np.asarray(uv, np.float32).ravel())
    data.polygons.foreach_set("use_smooth", [smooth] * len(data.polygons))
    if material is not None:
        data.materials.append(material)
    return add(name, data)


def quad(name, corners, material=None):
    """A face with four corners, its picture upright."""
    return mesh(name, corners, [(0, 1, 2, 3)], material, [(0, 0), (1, 0), (1, 1), (0, 1)])


def floor(material=None, half=6.0):
    """The ground, of a matt grey unless told otherwise."""
    material = material or closure("Floor", "ShaderNodeBsdfDiffuse", Color=(0.4, 0.38, 0.35))
    return quad("Floor", [(-half, -half, 0), (half, -half, 0), (half, half, 0), (-half, half, 0)], material)


def _of_bmesh(name, fill, material, smooth):
    bm = bmesh.new()
    fill(bm)
    data = bpy.data.meshes.new(name)
    bm.to_mesh(data)
    bm.free()
    data.polygons.foreach_set("use_smooth", [smooth] * len(data.polygons))
    if material is not None:
        data.materials.append(material)
    return add(name, data)


def ball(material=None, place=(0.0, 0.0, 1.0), radius=1.0, segments=32, name="Ball"):
    """A smooth ball with texture coordinates."""

    def fill(bm):
        bm.loops.layers.uv.new("UVMap")
        bmesh.ops.create_uvsphere(bm, u_segments=segments, v_segments=segments // 2, radius=radius, calc_uvs=True)

    o = _of_bmesh(name, fill, material, True)
    o.location = place
    return o


def box(material=None, place=(0.0, 0.0, 0.7), size=(1.4, 1.4, 1.4), turn=0.5, name="Box"):
    """A box, turned about the vertical."""

    def fill(bm):
        bm.loops.layers.uv.new("UVMap")
        bmesh.ops.create_cube(bm, size=1.0, calc_uvs=True)

    o = _of_bmesh(name, fill, material, False)
    o.location, o.scale, o.rotation_euler = place, size, (0.0, 0.0, turn)
    return o


def _set(node, sockets):
    for key, value in sockets.items():
        socket = node.inputs[key.replace("_", " ")]
        if isinstance(value, bpy.types.NodeSocket):
            node.id_data.links.new(value, socket)
            continue
        if isinstance(value, tuple) and socket.type == "RGBA":
            value = (*value, 1.0)
        socket.default_value = value


def material(name):
    """A material without nodes but for its output: its tree and the output."""
    m = bpy.data.materials.new(name)
    m.use_nodes = True
    m.node_tree.nodes.clear()
    return m, m.node_tree, m.node_tree.nodes.new("ShaderNodeOutputMaterial")


def node(tree, kind, properties=None, **sockets):
    """A node: `sockets` by their names with _ for blanks, values or other nodes' outputs."""
    n = tree.nodes.new(kind)
    for key, value in (properties or {}).items():
        setattr(n, key, value)
    _set(n, sockets)
    return n


def closure(name, kind, properties=None, to="Surface", **sockets):
    """A material of one closure."""
    m, tree, out = material(name)
    tree.links.new(node(tree, kind, properties, **sockets).outputs[0], out.inputs[to])
    return m


def principled(name="Principled", properties=None, **sockets):
    """A material of a Principled BSDF."""
    return closure(name, "ShaderNodeBsdfPrincipled", properties, **sockets)


def picture(name, pixels, linear=False):
    """A packed picture of `pixels`, [height][width][3], bottom row first; floats of linear light, or 8 bits."""
    height, width = pixels.shape[:2]
    image = bpy.data.images.new(name, width, height, float_buffer=linear, is_data=False)
    whole = np.ones((height, width, 4), np.float32)
    whole[..., : pixels.shape[2]] = pixels
    image.pixels.foreach_set(whole.ravel())
    image.pack()
    return image


def stage():
    """Floor, a lamp with soft shadows, a small warm one, a camera: where a ball shows its material."""
    floor()
    lamp("AREA", (-2.5, -2.5, 4.0), (0, 0, 0.8), 180.0, size=1.2)
    lamp("POINT", (2.8, -1.6, 1.4), None, 60.0, color=(1.0, 0.75, 0.5), shadow_soft_size=0.3)
    camera()


def show(made):
    """The stage with a ball of a material."""
    stage()
    return ball(made)


def degrees(a):
    """Radians."""
    return math.radians(a)
