"""Lamps of every kind, light of the world, and what sees what. A box and a ball on matt ground throw the shadows."""

import bpy
import numpy as np

from .stage import ball, box, camera, case, closure, degrees, floor, lamp, node, picture, principled, quad, world


def matt(name, *color):
    """A matt material."""
    return closure(name, "ShaderNodeBsdfDiffuse", Color=color)


def things():
    """What is lit."""
    floor(matt("Floor", 0.6, 0.58, 0.55))
    box(matt("Box", 0.7, 0.3, 0.2), place=(-0.9, 0.2, 0.5), size=(0.9, 0.9, 1.0))
    ball(principled("Ball", Base_Color=(0.3, 0.5, 0.7), Roughness=0.35), place=(0.7, -0.2, 0.6), radius=0.6, segments=24)
    camera(place=(0, -6, 3.6), target=(0, 0, 0.5))


def lit(name, about, kind, place, target=None, energy=100.0, spp=16, scale=None, turn=None, **settings):
    """A case of one lamp over the things, in the dark."""

    def build():
        world((0, 0, 0))
        things()
        o = lamp(kind, place, target, energy, **settings)
        if scale is not None:
            o.scale = scale
        if turn is not None:
            o.rotation_euler.rotate_axis("Z", turn)

    case("lamp/" + name, about, spp=spp)(build)


HIGH, LOW = (-1.5, -1.8, 3.2), (1.8, -1.2, 1.6)
lit("point", "A point without size.", "POINT", HIGH, energy=300.0, shadow_soft_size=0.0)
lit("point_disc", "A point with soft falloff: a disc that turns.", "POINT", LOW, energy=200.0, shadow_soft_size=0.4, use_soft_falloff=True)
lit("point_ball", "A point with a radius: a ball.", "POINT", LOW, energy=200.0, shadow_soft_size=0.4, use_soft_falloff=False)
lit("point_color", "Colour, exposure and temperature of a lamp.", "POINT", HIGH, energy=100.0, color=(0.9, 1.0, 0.6), exposure=1.5, use_temperature=True, temperature=3500.0)
lit("sun", "A sun without size.", "SUN", (3, -3, 5), (0, 0, 0), energy=3.0, angle=0.0)
lit("sun_wide", "A sun as wide as 20 degrees.", "SUN", (3, -3, 3), (0, 0, 0), energy=3.0, angle=degrees(20))
lit("spot", "A spot with a sharp rim.", "SPOT", (-1, -2, 4), (0, 0, 0.3), energy=700.0, spot_size=degrees(40), spot_blend=0.0, shadow_soft_size=0.0)
lit("spot_blend", "A spot with a soft rim.", "SPOT", (-1, -2, 4), (0, 0, 0.3), energy=900.0, spot_size=degrees(50), spot_blend=0.8, shadow_soft_size=0.0)
lit("spot_soft", "A spot with a radius.", "SPOT", (-1, -2, 4), (0, 0, 0.3), energy=700.0, spot_size=degrees(45), spot_blend=0.2, shadow_soft_size=0.5)
lit("spot_scaled", "A spot of an elliptic cone.", "SPOT", (-1, -2, 4), (0, 0, 0.3), energy=700.0, spot_size=degrees(60), spot_blend=0.3, shadow_soft_size=0.1, scale=(0.4, 1.0, 1.0))
lit("area_square", "A square.", "AREA", HIGH, (0, 0, 0.4), energy=200.0, size=1.5)
lit("area_rectangle", "A long rectangle, turned.", "AREA", HIGH, (0, 0, 0.4), energy=200.0, shape="RECTANGLE", size=3.0, size_y=0.3, turn=0.7)
lit("area_disc", "A disc.", "AREA", LOW, (0, 0, 0.4), energy=100.0, shape="DISK", size=1.0)
lit("area_ellipse", "An ellipse.", "AREA", HIGH, (0, 0, 0.4), energy=200.0, shape="ELLIPSE", size=2.5, size_y=0.5)
lit("area_spread", "A square that shines into a narrow cone.", "AREA", HIGH, (0, 0, 0.4), energy=100.0, size=1.0, spread=degrees(50))
lit("area_spread_disc", "A disc that shines into a cone.", "AREA", HIGH, (0, 0, 0.4), energy=100.0, shape="DISK", size=1.4, spread=degrees(90))
lit("area_scaled", "A square scaled by its object.", "AREA", HIGH, (0, 0, 0.4), energy=200.0, size=1.0, scale=(2.0, 0.5, 1.0))
lit("no_shadow", "A lamp that throws no shadows.", "AREA", HIGH, (0, 0, 0.4), energy=150.0, size=1.0, use_shadow=False)


@case("lamp/unnormalized", "A square whose power is by area.")
def unnormalized():
    world((0, 0, 0))
    things()
    lamp("AREA", HIGH, (0, 0, 0.4), 60.0, size=2.0, normalize=False)


@case("lamp/many", "Sixty lamps of all colours: the light tree.", spp=32)
def many():
    world((0, 0, 0))
    things()
    rng = np.random.default_rng(3)
    for _ in range(60):
        place = rng.uniform((-3, -2.5, 0.3), (3, 2.5, 2.0))
        lamp("POINT", place, None, rng.uniform(1, 9), color=rng.uniform(0.1, 1, 3), shadow_soft_size=0.05)


@case("lamp/shining_meshes", "Shining faces of different size.", spp=32)
def shining_meshes():
    world((0, 0, 0))
    things()
    for k, (x, z, half) in enumerate([(-2.0, 2.0, 0.5), (0.0, 2.6, 0.2), (2.2, 1.2, 0.1)]):
        shine = closure(f"Shine{k}", "ShaderNodeEmission", Color=(1.0, 0.8 - 0.2 * k, 0.3 + 0.3 * k), Strength=4.0 / half)
        quad(f"Lamp{k}", [(x - half, -1 - half, z), (x - half, -1 + half, z), (x + half, -1 + half, z), (x + half, -1 - half, z)], shine)


@case("lamp/mirrored", "Lamps seen in a mirror, unseen by the camera.")
def mirrored():
    things()
    quad("Mirror", [(-2.5, 1.5, 0), (2.5, 1.5, 0), (2.5, 2.2, 2.6), (-2.5, 2.2, 2.6)], closure("M", "ShaderNodeBsdfAnisotropic", Roughness=0.0))
    lamp("AREA", (0.8, -1.8, 2.2), (0, 1.5, 1), 60.0, size=0.8)
    lamp("POINT", (-1.5, -1.0, 1.8), None, 60.0, shadow_soft_size=0.25, use_soft_falloff=False)
    bpy.context.scene.cycles.caustics_reflective = False


@case("world/constant", "Light from everywhere.")
def constant():
    world((0.5, 0.7, 1.0), 1.2)
    things()


def _sky(kind="ShaderNodeTexEnvironment", properties=None, rotation=None, strength=1.0):
    w = world((0, 0, 0), strength)
    tree = w.node_tree
    back = next(n for n in tree.nodes if n.type == "BACKGROUND")
    texture = node(tree, kind, properties)
    if rotation is not None:
        generated = node(tree, "ShaderNodeTexCoord").outputs["Generated"]
        turn = node(tree, "ShaderNodeMapping", Vector=generated, Rotation=rotation)
        tree.links.new(turn.outputs[0], texture.inputs["Vector"])
    tree.links.new(texture.outputs[0], back.inputs["Color"])


def _panorama(width=64):
    """A sky with a bright spot and coloured walls, linear light."""
    height = width // 2
    v, u = np.mgrid[0:height, 0:width]
    phi, theta = 2 * np.pi * (u + 0.5) / width, np.pi * ((v + 0.5) / height - 0.5)
    up = np.sin(theta)
    out = np.stack([0.4 + 0.4 * np.cos(phi), 0.4 + 0.4 * np.sin(phi), 0.5 + 0.4 * up], -1)
    spot = np.exp(-40 * ((theta - 0.7) ** 2 + (phi - 4.2) ** 2))
    return (out + 12.0 * spot[..., None]).astype(np.float32)


@case("world/hdri", "Light of a picture around everything.")
def hdri():
    _sky(properties={"image": picture("around", _panorama(), linear=True)})
    things()


@case("world/hdri_turned", "The same, turned about two axes.")
def hdri_turned():
    _sky(properties={"image": picture("around", _panorama(), linear=True)}, rotation=(0.4, 0.0, 1.9))
    things()


@case("world/hdri_mirror_ball", "Light of a picture of a mirror ball.")
def hdri_ball():
    _sky(properties={"image": picture("around", _panorama(), linear=True), "projection": "MIRROR_BALL"})
    things()


def _nishita(name, about, strength=0.1, **settings):
    own = {"sky_type": "NISHITA", "sun_rotation": 2.4, **settings}
    case("world/" + name, about)(lambda: (_sky("ShaderNodeTexSky", own, strength=strength), things()))


_nishita("sky", "A sky without its sun.", sun_disc=False, sun_elevation=degrees(35))
_nishita("sky_sun", "A sky with its sun.", strength=0.05, sun_disc=True, sun_elevation=degrees(35), sun_size=degrees(2))
_nishita("sky_low", "A low sun: dust and red light.", sun_disc=False, sun_elevation=degrees(3), dust_density=3.0, air_density=1.5)
_nishita("sky_high", "The sky of a mountain, much ozone.", sun_disc=False, sun_elevation=degrees(60), altitude=3000.0, ozone_density=4.0)


@case("visibility/rays", "Things that some kinds of rays do not see.")
def rays():
    things()
    lamp("AREA", HIGH, (0, 0, 0.4), 200.0, size=1.0)
    quad("Mirror", [(-2.5, 1.5, 0), (2.5, 1.5, 0), (2.5, 2.2, 2.6), (-2.5, 2.2, 2.6)], closure("M", "ShaderNodeBsdfAnisotropic", Roughness=0.0))
    bpy.data.objects["Box"].visible_camera = False
    bpy.data.objects["Ball"].visible_shadow = False
    extra = ball(matt("Extra", 0.9, 0.8, 0.1), place=(0.0, 0.8, 0.4), radius=0.4, segments=16, name="Extra")
    extra.visible_glossy = False


@case("visibility/diffuse", "A wall that matt surfaces do not see.")
def diffuse_rays():
    things()
    lamp("AREA", (0, -3, 3), (0, 0, 0.4), 150.0, size=1.0)
    wall = quad("Wall", [(-2.5, 1.2, 0), (2.5, 1.2, 0), (2.5, 1.2, 2.6), (-2.5, 1.2, 2.6)], matt("Red", 0.9, 0.05, 0.05))
    wall.visible_diffuse = False


@case("visibility/holdout", "A hole in the picture.")
def holdout():
    things()
    lamp("AREA", HIGH, (0, 0, 0.4), 200.0, size=1.0)
    bpy.data.objects["Ball"].is_holdout = True


@case("transport/no_bounces", "Direct light alone.")
def no_bounces():
    things()
    lamp("AREA", HIGH, (0, 0, 0.4), 200.0, size=1.0)
    bpy.context.scene.cycles.max_bounces = 0


@case("transport/one_diffuse_bounce", "One bounce between matt surfaces.")
def one_bounce():
    world((0, 0, 0))
    things()
    lamp("AREA", HIGH, (0, 0, 0.4), 200.0, size=1.0)
    bpy.context.scene.cycles.diffuse_bounces = 1


def _glass_ball():
    world((0.1, 0.1, 0.1))
    floor()
    ball(closure("Glass", "ShaderNodeBsdfGlass", Roughness=0.0, IOR=1.45), radius=0.8, place=(0, 0, 0.9))
    lamp("AREA", (-2, -1, 3), (0, 0, 0.8), 150.0, size=2.0)
    camera()


@case("transport/caustics", "Light gathered by a glass ball.", spp=64)
def caustics():
    _glass_ball()


@case("transport/no_caustics", "The same without caustics.", spp=32)
def no_caustics():
    _glass_ball()
    c = bpy.context.scene.cycles
    c.caustics_reflective = c.caustics_refractive = False


@case("transport/filter_glossy", "Mirrors behind diffuse bounces, blurred as Blender does from the start.", spp=64)
def filter_glossy():
    world((0.1, 0.1, 0.1))
    floor()
    ball(closure("Mirror", "ShaderNodeBsdfAnisotropic", Color=(0.9, 0.7, 0.5), Roughness=0.0), radius=0.6, place=(-0.7, 0, 0.6))
    ball(closure("Dull", "ShaderNodeBsdfAnisotropic", Color=(0.5, 0.7, 0.9), Roughness=0.3), radius=0.6, place=(0.7, 0, 0.6))
    lamp("AREA", (-2, -1, 3), (0, 0, 0.8), 150.0, size=2.0)
    camera()
    bpy.context.scene.cycles.blur_glossy = 1.0


@case("transport/transparent_limit", "More sheets than transparent bounces.")
def transparent_limit():
    things()
    lamp("AREA", HIGH, (0, 0, 0.4), 200.0, size=1.0)
    clear = closure("Clear", "ShaderNodeBsdfTransparent", Color=(0.85, 0.9, 0.95))
    for k in range(6):
        y = -1.2 - 0.25 * k
        quad(f"Sheet{k}", [(-2, y, 0.2 * k), (0.3 * k, y, 0.2 * k), (0.3 * k, y, 2), (-2, y, 2)], clear)
    bpy.context.scene.cycles.transparent_max_bounces = 4
