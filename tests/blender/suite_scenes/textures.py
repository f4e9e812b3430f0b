"""What steers a material from point to point: pictures, attributes, normal and bump maps, procedural textures that the exporter bakes; and hair."""

import bpy
import numpy as np

from .stage import add, ball, camera, case, closure, degrees, floor, lamp, material, node, picture, principled, quad, show, stage


def _tiles(n=8, size=64):
    """Coloured tiles with a dark joint, [size][size][3]."""
    rng = np.random.default_rng(4)
    colors = rng.uniform(0.1, 0.95, (n, n, 3))
    at = np.arange(size) * n // size
    out = colors[at][:, at]
    joint = (np.arange(size) % (size // n)) == 0
    out[joint, :] = out[:, joint] = 0.05
    return out


def _bumps(size=64):
    """Heights of round bumps, [size][size]."""
    v, u = np.mgrid[0:size, 0:size] / size
    return 0.5 + 0.25 * (np.cos(2 * np.pi * 4 * u) + np.cos(2 * np.pi * 4 * v)) * 1.0


def _normals(size=64):
    """The same as a normal map."""
    height = _bumps(size) * 0.06
    dv, du = np.gradient(height, 1.0 / size)
    n = np.stack([-du, -dv, np.ones_like(du)], -1)
    return 0.5 + 0.5 * n / np.linalg.norm(n, axis=-1, keepdims=True)


def _textured(name, pixels, build, data=False, interpolation="Linear", extension="REPEAT"):
    """A Principled material with `build(tree, bsdf, image node)` to link them."""
    m, tree, out = material(name)
    bsdf = node(tree, "ShaderNodeBsdfPrincipled", Roughness=0.5)
    image = picture(name, pixels)
    if data:
        image.colorspace_settings.name = "Non-Color"
    texture = node(tree, "ShaderNodeTexImage", {"image": image, "interpolation": interpolation, "extension": extension})
    tree.links.new(bsdf.outputs[0], out.inputs["Surface"])
    build(tree, bsdf, texture)
    return m


def _color(tree, bsdf, texture):
    tree.links.new(texture.outputs["Color"], bsdf.inputs["Base Color"])


@case("texture/picture", "A picture as colour, smoothed.")
def picture_smooth():
    show(_textured("picture", _tiles(), _color))


@case("texture/picture_closest", "A picture of few pixels, not smoothed.")
def picture_closest():
    show(_textured("closest", _tiles(8, 16), _color, interpolation="Closest"))


@case("texture/picture_mapping", "A picture moved, turned and scaled by a mapping, cut off outside.")
def picture_mapping():
    def build(tree, bsdf, texture):
        _color(tree, bsdf, texture)
        uv = node(tree, "ShaderNodeTexCoord").outputs["UV"]
        turn = node(tree, "ShaderNodeMapping", Vector=uv, Location=(0.1, 0.2, 0), Rotation=(0, 0, degrees(30)), Scale=(2.0, 1.5, 1))
        tree.links.new(turn.outputs[0], texture.inputs["Vector"])

    stage()
    quad("Board", [(-1.6, 0, 0.1), (1.6, 0, 0.1), (1.6, 0.4, 1.9), (-1.6, 0.4, 1.9)], _textured("mapping", _tiles(), build, extension="CLIP"))


@case("texture/roughness", "A channel of a picture as roughness.")
def roughness():
    def build(tree, bsdf, texture):
        parts = node(tree, "ShaderNodeSeparateColor", Color=texture.outputs["Color"])
        tree.links.new(parts.outputs[1], bsdf.inputs["Roughness"])
        bsdf.inputs["Metallic"].default_value = 1.0

    show(_textured("roughness", _tiles(4), build, data=True))


@case("texture/alpha", "Holes: a picture as alpha.")
def alpha():
    def build(tree, bsdf, texture):
        parts = node(tree, "ShaderNodeSeparateColor", Color=texture.outputs["Color"])
        tree.links.new(parts.outputs[0], bsdf.inputs["Alpha"])
        bsdf.inputs["Base Color"].default_value = (0.2, 0.6, 0.3, 1.0)

    holes = np.repeat((_bumps() > 0.5).astype(np.float32)[..., None], 3, -1)
    show(_textured("alpha", holes, build, data=True))


@case("texture/normal_map", "A normal map on a ball.")
def normal_map():
    def build(tree, bsdf, texture):
        bent = node(tree, "ShaderNodeNormalMap", Strength=1.0, Color=texture.outputs["Color"])
        tree.links.new(bent.outputs[0], bsdf.inputs["Normal"])
        bsdf.inputs["Base Color"].default_value = (0.6, 0.3, 0.2, 1.0)

    show(_textured("normal_map", _normals(), build, data=True))


@case("texture/normal_map_metal", "A normal map under metal.")
def normal_map_metal():
    def build(tree, bsdf, texture):
        bent = node(tree, "ShaderNodeNormalMap", Strength=0.7, Color=texture.outputs["Color"])
        tree.links.new(bent.outputs[0], bsdf.inputs["Normal"])
        bsdf.inputs["Metallic"].default_value = 1.0
        bsdf.inputs["Roughness"].default_value = 0.25

    stage()
    made = _textured("normal_map_metal", _normals(), build, data=True)
    quad("Board", [(-1.6, -0.6, 0.1), (1.6, -0.6, 0.1), (1.6, 0.8, 1.7), (-1.6, 0.8, 1.7)], made)


@case("texture/bump", "A bump map.")
def bump():
    def build(tree, bsdf, texture):
        bent = node(tree, "ShaderNodeBump", Strength=0.8, Distance=0.15, Height=texture.outputs["Color"])
        tree.links.new(bent.outputs[0], bsdf.inputs["Normal"])
        bsdf.inputs["Base Color"].default_value = (0.5, 0.5, 0.6, 1.0)

    stage()
    made = _textured("bump", np.repeat(_bumps()[..., None], 3, -1), build, data=True)
    quad("Board", [(-1.6, -0.6, 0.1), (1.6, -0.6, 0.1), (1.6, 0.8, 1.7), (-1.6, 0.8, 1.7)], made)


@case("texture/color_attribute", "Colours at the corners of a mesh.")
def color_attribute():
    m, tree, out = material("attribute")
    bsdf = node(tree, "ShaderNodeBsdfPrincipled", Base_Color=node(tree, "ShaderNodeVertexColor", {"layer_name": "Col"}).outputs[0])
    tree.links.new(bsdf.outputs[0], out.inputs["Surface"])
    o = show(m)
    layer = o.data.color_attributes.new("Col", "FLOAT_COLOR", "POINT")
    for k, v in enumerate(o.data.vertices):
        layer.data[k].color = (0.5 + 0.5 * v.co.x, 0.5 + 0.5 * v.co.y, 0.5 + 0.5 * v.co.z, 1.0)


@case("texture/checker", "A checker over texture coordinates, baked by the exporter.")
def checker():
    m, tree, out = material("checker")
    uv = node(tree, "ShaderNodeTexCoord").outputs["UV"]
    pattern = node(tree, "ShaderNodeTexChecker", Vector=uv, Color1=(0.9, 0.8, 0.2), Color2=(0.1, 0.2, 0.5), Scale=8.0)
    bsdf = node(tree, "ShaderNodeBsdfPrincipled", Base_Color=pattern.outputs["Color"])
    tree.links.new(bsdf.outputs[0], out.inputs["Surface"])
    stage()
    quad("Board", [(-1.6, -0.6, 0.1), (1.6, -0.6, 0.1), (1.6, 0.8, 1.7), (-1.6, 0.8, 1.7)], m)


@case("texture/ramp", "A gradient through a colour ramp, baked by the exporter.")
def ramp():
    m, tree, out = material("ramp")
    uv = node(tree, "ShaderNodeTexCoord").outputs["UV"]
    fade = node(tree, "ShaderNodeTexGradient", Vector=uv)
    colors = node(tree, "ShaderNodeValToRGB", Fac=fade.outputs["Fac"])
    colors.color_ramp.elements[0].color = (0.8, 0.1, 0.05, 1)
    colors.color_ramp.elements[1].color = (0.1, 0.3, 0.9, 1)
    colors.color_ramp.elements.new(0.5).color = (0.9, 0.9, 0.3, 1)
    bsdf = node(tree, "ShaderNodeBsdfPrincipled", Base_Color=colors.outputs[0], Roughness=0.3)
    tree.links.new(bsdf.outputs[0], out.inputs["Surface"])
    stage()
    quad("Board", [(-1.6, -0.6, 0.1), (1.6, -0.6, 0.1), (1.6, 0.8, 1.7), (-1.6, 0.8, 1.7)], m)


@case("texture/emission_picture", "A picture that shines and lights the floor.")
def emission_picture():
    floor()
    camera()
    m, tree, out = material("screen")
    texture = node(tree, "ShaderNodeTexImage", {"image": picture("screen", _tiles(4, 32))})
    shine = node(tree, "ShaderNodeEmission", Strength=3.0, Color=texture.outputs["Color"])
    tree.links.new(shine.outputs[0], out.inputs["Surface"])
    quad("Screen", [(-1.5, 0.5, 0.3), (1.5, 0.5, 0.3), (1.5, 0.5, 2.0), (-1.5, 0.5, 2.0)], m)


def _strands(made, n=180):
    """Curved hairs on a stage, thick enough for few pixels."""
    stage()
    rng = np.random.default_rng(8)
    data = bpy.data.hair_curves.new("Hair")
    data.add_curves([6] * n)
    points = []
    for _ in range(n):
        root = np.array([*rng.uniform((-1.3, -0.5), (1.3, 0.5)), 0.0])
        lean = rng.normal(0.0, 0.25, 2)
        t = np.linspace(0.0, 1.0, 6)
        points.append(root + np.stack([lean[0] * t * t, lean[1] * t * t, 1.7 * t], -1))
    data.attributes["position"].data.foreach_set("vector", np.concatenate(points).astype(np.float32).ravel())
    radius = data.attributes.new("radius", "FLOAT", "POINT")
    radius.data.foreach_set("value", np.tile(np.linspace(0.03, 0.012, 6), n).astype(np.float32))
    data.materials.append(made)
    add("Hair", data)


@case("hair/principled_color", "Hair of a colour.", spp=32)
def hair_color():
    _strands(closure("hair", "ShaderNodeBsdfHairPrincipled", {"model": "CHIANG"}, Color=(0.4, 0.15, 0.05), Roughness=0.3))


@case("hair/principled_melanin", "Hair of melanin.", spp=32)
def hair_melanin():
    own = {"model": "CHIANG", "parametrization": "MELANIN"}
    _strands(closure("hair", "ShaderNodeBsdfHairPrincipled", own, Melanin=0.5, Melanin_Redness=0.8, Roughness=0.25))


@case("hair/principled_rough", "Pale hair, rough around and along.", spp=32)
def hair_rough():
    own = {"model": "CHIANG"}
    _strands(closure("hair", "ShaderNodeBsdfHairPrincipled", own, Color=(0.8, 0.6, 0.3), Roughness=0.6, Radial_Roughness=0.7, Coat=0.3))


@case("hair/filter_glossy", "Hair of a colour, blurred from the second bounce on.", spp=32)
def hair_filter_glossy():
    _strands(closure("hair", "ShaderNodeBsdfHairPrincipled", {"model": "CHIANG"}, Color=(0.8, 0.6, 0.4), Roughness=0.15))
    bpy.context.scene.cycles.blur_glossy = 1.0


@case("hair/diffuse", "Hair of a matt closure.")
def hair_diffuse():
    _strands(closure("hair", "ShaderNodeBsdfDiffuse", Color=(0.3, 0.5, 0.2)))


@case("hair/thick", "Hair as tubes, of a Principled BSDF.")
def hair_thick():
    bpy.context.scene.cycles_curves.shape = "THICK"
    _strands(principled(Base_Color=(0.7, 0.5, 0.2), Roughness=0.4), n=90)


@case("texture/many_balls", "Balls of one mesh with colours of their own: instances.")
def many_balls():
    stage()
    first = ball(None, radius=0.35, segments=12, place=(-1.5, 0, 0.35))
    first.data.materials.append(None)
    for k in range(8):
        o = first if k == 0 else add(f"Ball{k}", first.data)
        o.location = (-1.5 + k % 4, 0.9 * (k // 4) - 0.4, 0.35)
        o.material_slots[0].link = "OBJECT"
        o.material_slots[0].material = principled(f"B{k}", Base_Color=(0.1 + 0.1 * k, 0.5, 0.9 - 0.1 * k), Roughness=0.1 * k, Metallic=float(k % 2))
    lamp("POINT", (0, -2, 3), None, 40.0)
