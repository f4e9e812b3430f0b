"""Volumes: a block of fog on the stage."""

import bpy

from .stage import ball, box, camera, case, closure, floor, lamp, material, node, principled, stage, world


def fog(name, about, kind, spp=32, bounces=0, properties=None, **sockets):
    """A case of one volume closure in a box."""

    def build():
        stage()
        bpy.context.scene.cycles.volume_bounces = bounces
        box(closure(name, kind, properties, to="Volume", **sockets), place=(0, 0, 0.9), size=(1.8, 1.2, 1.6))

    case("volume/" + name, about, spp=spp)(build)


fog("absorption", "A volume that absorbs.", "ShaderNodeVolumeAbsorption", Color=(0.2, 0.6, 0.9), Density=1.2)
fog("scatter", "A volume that scatters once.", "ShaderNodeVolumeScatter", Color=(0.8, 0.7, 0.6), Density=1.0)
fog("scatter_bounces", "A volume that scatters many times.", "ShaderNodeVolumeScatter", bounces=8, Color=(0.9, 0.9, 0.9), Density=3.0)
fog("scatter_forward", "A volume that scatters forward.", "ShaderNodeVolumeScatter", Color=(0.8, 0.8, 0.8), Density=1.0, Anisotropy=0.7)
fog("scatter_back", "A volume that scatters back.", "ShaderNodeVolumeScatter", Color=(0.8, 0.8, 0.8), Density=1.0, Anisotropy=-0.6)
fog("principled", "The Principled Volume.", "ShaderNodeVolumePrincipled", bounces=2, Color=(0.5, 0.6, 0.7), Density=1.5, Anisotropy=0.2)
fog("principled_emission", "A Principled Volume that shines.", "ShaderNodeVolumePrincipled", Density=0.5, Emission_Strength=0.6, Emission_Color=(1.0, 0.4, 0.1))


@case("volume/in_glass", "Coloured glass: an absorbing volume inside.", spp=32)
def in_glass():
    stage()
    m, tree, out = material("in_glass")
    glass = node(tree, "ShaderNodeBsdfGlass", Roughness=0.0, IOR=1.45, Color=(1.0, 1.0, 1.0))
    inside = node(tree, "ShaderNodeVolumeAbsorption", Color=(0.9, 0.3, 0.2), Density=1.5)
    tree.links.new(glass.outputs[0], out.inputs["Surface"])
    tree.links.new(inside.outputs[0], out.inputs["Volume"])
    ball(m, place=(0, 0, 1.05))


@case("volume/noise", "A cloud of noise, its density baked by the exporter.", spp=32)
def noise():
    stage()
    m, tree, out = material("noise")
    place = node(tree, "ShaderNodeTexCoord").outputs["Object"]
    clouds = node(tree, "ShaderNodeTexNoise", Vector=place, Scale=1.5, Detail=0.0)
    dense = node(tree, "ShaderNodeMapRange", Value=clouds.outputs[0])
    for key, value in (("From Min", 0.45), ("From Max", 0.65), ("To Max", 6.0)):
        dense.inputs[key].default_value = value
    inside = node(tree, "ShaderNodeVolumePrincipled", Density=dense.outputs[0], Color=(0.7, 0.7, 0.7))
    tree.links.new(inside.outputs[0], out.inputs["Volume"])
    box(m, place=(0, 0, 0.95), size=(1.8, 1.4, 1.6), turn=0.0)


@case("volume/beam", "A spot's beam in thin fog around everything that the camera sees.", spp=32)
def beam():
    world((0, 0, 0))
    floor()
    camera()
    box(closure("Fog", "ShaderNodeVolumeScatter", to="Volume", Color=(0.9, 0.9, 0.9), Density=0.15), place=(0, 0, 2.02), size=(7, 9, 4), turn=0.0)
    lamp("SPOT", (-2.0, 0.5, 3.2), (0.6, 0, 0.4), 900.0, spot_size=0.5, spot_blend=0.1, shadow_soft_size=0.05)
    ball(principled(Base_Color=(0.3, 0.5, 0.7)), place=(0.4, 0, 0.8), radius=0.5, segments=24)


@case("volume/overlapping", "Two fogs that share a part.", spp=32)
def overlapping():
    stage()
    absorbs = closure("Absorbs", "ShaderNodeVolumeAbsorption", to="Volume", Color=(0.2, 0.8, 0.3), Density=1.0)
    scatters = closure("Scatters", "ShaderNodeVolumeScatter", to="Volume", Color=(0.8, 0.5, 0.3), Density=1.0)
    box(absorbs, place=(-0.4, 0, 0.8), size=(1.4, 1.2, 1.3), turn=0.2, name="A")
    box(scatters, place=(0.4, 0.1, 0.95), size=(1.4, 1.0, 1.4), turn=0.0, name="B")
