"""Every lobe of the Principled BSDF and every closure: a ball on the stage."""


from .stage import ball, box, camera, case, closure, lamp, material, node, principled, quad, show, stage, world


def lobe(name, about, size=(72, 54), spp=16, properties=None, **sockets):
    """A case of a Principled BSDF."""
    case("material/" + name, about, size, spp)(lambda: show(principled(name, properties, **sockets)))


def single(name, about, kind, properties=None, spp=16, **sockets):
    """A case of one closure."""
    case("material/" + name, about, spp=spp)(lambda: show(closure(name, kind, properties, **sockets)))


RUST, GOLD, SKY = (0.7, 0.25, 0.1), (0.95, 0.64, 0.3), (0.3, 0.55, 0.9)

lobe("principled", "A Principled BSDF as Blender makes it.")
lobe("diffuse", "Diffuse alone: no specular.", Base_Color=RUST, Specular_IOR_Level=0.0)
lobe("diffuse_rough", "Rough diffuse: flat like clay.", Base_Color=RUST, Specular_IOR_Level=0.0, Diffuse_Roughness=1.0)
lobe("specular", "A dielectric's highlight over a dark base.", Base_Color=(0.05, 0.05, 0.06), Roughness=0.3)
lobe("specular_ior", "A dielectric of a high index.", Base_Color=(0.05, 0.05, 0.06), Roughness=0.15, IOR=2.4)
lobe("specular_level", "The level of the specular below and above its half.", Base_Color=(0.1, 0.1, 0.3), Roughness=0.2, Specular_IOR_Level=0.9)
lobe("specular_tint", "A tinted specular.", Base_Color=(0.1, 0.1, 0.1), Roughness=0.25, Specular_Tint=(1.0, 0.3, 0.1), IOR=2.0)
lobe("metal_smooth", "Polished metal.", Base_Color=GOLD, Metallic=1.0, Roughness=0.05)
lobe("metal_rough", "Rough metal, with the energy of many bounces.", Base_Color=GOLD, Metallic=1.0, Roughness=0.8)
lobe("metal_ggx", "Rough metal of one bounce in its facets.", properties={"distribution": "GGX"}, Base_Color=GOLD, Metallic=1.0, Roughness=0.8)
lobe("metal_tint", "Metal whose rim has a tint (F82).", Base_Color=GOLD, Metallic=1.0, Roughness=0.3, Specular_Tint=(0.2, 0.5, 1.0))
lobe("metal_anisotropic", "Brushed metal.", Base_Color=(0.8, 0.8, 0.8), Metallic=1.0, Roughness=0.35, Anisotropic=0.8)
lobe("metal_anisotropic_rotated", "Brushed metal, its grain turned.", Base_Color=(0.8, 0.8, 0.8), Metallic=1.0, Roughness=0.35, Anisotropic=0.8, Anisotropic_Rotation=0.15)
lobe("metal_half", "Half metal.", Base_Color=SKY, Metallic=0.5, Roughness=0.3)
lobe("coat", "A clear coat.", Base_Color=RUST, Roughness=0.7, Coat_Weight=1.0, Coat_Roughness=0.03)
lobe("coat_rough", "A rough coat of a high index.", Base_Color=RUST, Roughness=0.7, Coat_Weight=1.0, Coat_Roughness=0.4, Coat_IOR=2.0)
lobe("coat_tint", "A tinted coat over white.", Base_Color=(0.8, 0.8, 0.8), Coat_Weight=1.0, Coat_Tint=(0.3, 0.6, 0.9))
lobe("coat_metal", "A coat over metal.", Base_Color=GOLD, Metallic=1.0, Roughness=0.5, Coat_Weight=0.7, Coat_Tint=(0.9, 0.4, 0.3))
lobe("sheen", "Sheen over a dark cloth.", Base_Color=(0.05, 0.05, 0.1), Specular_IOR_Level=0.0, Sheen_Weight=1.0, Sheen_Roughness=0.4)
lobe("sheen_rough", "A rough, tinted sheen.", Base_Color=(0.1, 0.05, 0.02), Roughness=0.9, Sheen_Weight=0.8, Sheen_Roughness=0.8, Sheen_Tint=(1.0, 0.4, 0.2))
lobe("transmission", "Clear glass.", Base_Color=(1.0, 1.0, 1.0), Roughness=0.0, Transmission_Weight=1.0, spp=32)
lobe("transmission_rough", "Frosted glass.", Base_Color=(0.9, 0.95, 1.0), Roughness=0.4, Transmission_Weight=1.0, spp=32)
lobe("transmission_tint", "Coloured glass.", Base_Color=(0.3, 0.8, 0.4), Roughness=0.1, Transmission_Weight=1.0, spp=32)
lobe("transmission_half", "Half glass, half matt.", Base_Color=SKY, Roughness=0.2, Transmission_Weight=0.5, spp=32)
lobe("thin_film", "A film on a dielectric.", Base_Color=(0.02, 0.02, 0.02), Roughness=0.1, IOR=2.0, Thin_Film_Thickness=400.0, Thin_Film_IOR=1.33)
lobe("thin_film_metal", "A film on metal.", Base_Color=(0.6, 0.6, 0.6), Metallic=1.0, Roughness=0.2, Thin_Film_Thickness=550.0, Thin_Film_IOR=1.5)
lobe("thin_film_glass", "A soap bubble's film on glass.", Base_Color=(1.0, 1.0, 1.0), Roughness=0.0, Transmission_Weight=1.0, Thin_Film_Thickness=500.0, spp=32)
lobe("subsurface", "Skin: light walks in it, red the furthest.", Base_Color=(0.8, 0.5, 0.4), Subsurface_Weight=1.0, Subsurface_Radius=(1.0, 0.2, 0.1), Subsurface_Scale=0.3, properties={"subsurface_method": "RANDOM_WALK"}, spp=32)
lobe("subsurface_short", "Subsurface so short that it looks like diffuse.", Base_Color=(0.8, 0.5, 0.4), Subsurface_Weight=1.0, Subsurface_Scale=0.01, properties={"subsurface_method": "RANDOM_WALK"}, spp=32)
lobe("subsurface_half", "Half subsurface, half diffuse.", Base_Color=(0.4, 0.7, 0.4), Subsurface_Weight=0.5, Subsurface_Radius=(0.5, 0.5, 0.5), Subsurface_Scale=0.4, properties={"subsurface_method": "RANDOM_WALK"}, spp=32)
lobe("subsurface_skin", "Subsurface after the method for skin.", Base_Color=(0.8, 0.5, 0.4), Subsurface_Weight=1.0, Subsurface_Scale=0.2, properties={"subsurface_method": "RANDOM_WALK_SKIN"}, spp=32)
lobe("subsurface_forward", "Light that scatters forward in a body: evenly after ten steps.", Base_Color=(0.8, 0.6, 0.3), Subsurface_Weight=1.0, Subsurface_Radius=(0.6, 0.3, 0.2), Subsurface_Scale=1.0, Subsurface_Anisotropy=0.8, Specular_IOR_Level=0.0, properties={"subsurface_method": "RANDOM_WALK"}, spp=32)
lobe("emission", "A ball that shines.", Base_Color=(0.1, 0.1, 0.1), Emission_Color=(1.0, 0.5, 0.2), Emission_Strength=2.0)
lobe("emission_coat", "A coat over a ball that shines.", Base_Color=(0.0, 0.0, 0.0), Emission_Color=(1.0, 1.0, 1.0), Emission_Strength=1.0, Coat_Weight=1.0, Coat_Tint=(0.2, 0.7, 0.3))
lobe("alpha", "Two fifths of the light go through.", Base_Color=RUST, Alpha=0.6)

single("diffuse_bsdf", "The Diffuse closure.", "ShaderNodeBsdfDiffuse", Color=SKY)
single("diffuse_bsdf_rough", "The Diffuse closure, rough.", "ShaderNodeBsdfDiffuse", Color=SKY, Roughness=0.8)
single("glossy", "The Glossy closure.", "ShaderNodeBsdfAnisotropic", Color=GOLD, Roughness=0.3)
single("glossy_mirror", "The Glossy closure as a mirror.", "ShaderNodeBsdfAnisotropic", Color=(0.9, 0.9, 0.9), Roughness=0.0)
single("glossy_anisotropic", "The Glossy closure, brushed.", "ShaderNodeBsdfAnisotropic", Color=GOLD, Roughness=0.4, Anisotropy=0.7, Rotation=0.1)
single("glossy_ggx", "The Glossy closure of one bounce.", "ShaderNodeBsdfAnisotropic", {"distribution": "GGX"}, Color=GOLD, Roughness=0.7)
single("glass", "The Glass closure.", "ShaderNodeBsdfGlass", spp=32, Color=(0.95, 1.0, 0.98), Roughness=0.0, IOR=1.5)
single("glass_rough", "The Glass closure, frosted.", "ShaderNodeBsdfGlass", spp=32, Color=(0.95, 1.0, 0.98), Roughness=0.5, IOR=1.5)
single("glass_light", "Glass lighter than what surrounds it.", "ShaderNodeBsdfGlass", spp=32, Color=(1.0, 1.0, 1.0), Roughness=0.0, IOR=0.8)
single("refraction", "The Refraction closure.", "ShaderNodeBsdfRefraction", spp=32, Color=(1.0, 0.9, 0.8), Roughness=0.2, IOR=1.3)
single("translucent", "The Translucent closure: lit from behind.", "ShaderNodeBsdfTranslucent", Color=(0.5, 0.8, 0.3))
single("transparent", "The Transparent closure, coloured.", "ShaderNodeBsdfTransparent", Color=(0.9, 0.5, 0.4))
single("sheen_bsdf", "The Sheen closure.", "ShaderNodeBsdfSheen", Color=(0.9, 0.8, 1.0), Roughness=0.5)
single("subsurface_bsdf", "The Subsurface Scattering closure.", "ShaderNodeSubsurfaceScattering", {"falloff": "RANDOM_WALK"}, spp=32, Color=(0.7, 0.8, 0.9), Scale=0.3, Radius=(1.0, 0.7, 0.4))
single("emission_bsdf", "The Emission closure.", "ShaderNodeEmission", Color=(0.4, 0.7, 1.0), Strength=1.5)
single("metallic_f82", "The Metallic closure with an edge tint.", "ShaderNodeBsdfMetallic", {"fresnel_type": "F82"}, Base_Color=GOLD, Edge_Tint=(0.3, 0.6, 0.9), Roughness=0.3)
single("metallic_conductor", "The Metallic closure of an index and an extinction.", "ShaderNodeBsdfMetallic", {"fresnel_type": "PHYSICAL_CONDUCTOR"}, IOR=(0.27, 0.68, 1.32), Extinction=(3.6, 2.6, 2.3), Roughness=0.3)


def _two(name, combine):
    m, tree, out = material(name)
    matt = node(tree, "ShaderNodeBsdfDiffuse", Color=RUST)
    mirror = node(tree, "ShaderNodeBsdfAnisotropic", Color=(0.7, 0.7, 0.7), Roughness=0.1)
    tree.links.new(combine(tree, matt.outputs[0], mirror.outputs[0]).outputs[0], out.inputs["Surface"])
    return show(m)


def _mixed(tree, a, b, factor):
    mix = node(tree, "ShaderNodeMixShader", Fac=factor)
    tree.links.new(a, mix.inputs[1])
    tree.links.new(b, mix.inputs[2])
    return mix


@case("material/mix", "Two closures, mixed.")
def mix():
    _two("mix", lambda tree, a, b: _mixed(tree, a, b, 0.35))


@case("material/add", "Two closures, added.")
def add_closures():
    def combine(tree, a, b):
        both = node(tree, "ShaderNodeAddShader")
        tree.links.new(a, both.inputs[0])
        tree.links.new(b, both.inputs[1])
        return both

    _two("add", combine)


@case("material/mix_deep", "A mix of a mix, one of them transparent.")
def mix_deep():
    def combine(tree, a, b):
        clear = node(tree, "ShaderNodeBsdfTransparent", Color=(1.0, 1.0, 1.0))
        return _mixed(tree, _mixed(tree, a, b, 0.5).outputs[0], clear.outputs[0], 0.3)

    _two("mix_deep", combine)


@case("material/mix_fresnel", "A mix by Fresnel's factor.")
def mix_fresnel():
    def combine(tree, a, b):
        return _mixed(tree, a, b, node(tree, "ShaderNodeFresnel", IOR=1.8).outputs[0])

    _two("mix_fresnel", combine)


@case("material/thin_sheet", "A sheet of glass closure without a body: bent once.")
def thin_sheet():
    stage()
    quad("Sheet", [(-1, -0.4, 0.1), (1, -0.4, 0.1), (1, 0.4, 1.8), (-1, 0.4, 1.8)], principled(Transmission_Weight=1.0, Roughness=0.1))


@case("material/edges", "Flat faces beside smooth ones: the normals of corners.")
def edges():
    stage()
    box(principled(Base_Color=SKY, Roughness=0.25), place=(-0.8, 0, 0.6), size=(1.2, 1.2, 1.2))
    ball(principled(Base_Color=SKY, Roughness=0.25), place=(0.9, 0, 0.8), radius=0.8, segments=12)


@case("material/back_faces", "Two sheets seen from their backs, one of glass.")
def back_faces():
    stage()
    corners = [(-1.6, 0, 0.1), (-0.1, 0, 0.1), (-0.1, 0, 1.6), (-1.6, 0, 1.6)]
    quad("Matt", corners[::-1], principled(Base_Color=RUST, Roughness=0.4))
    quad("Clear", [(x + 1.7, y, z) for x, y, z in corners][::-1], principled(Transmission_Weight=1.0, Roughness=0.2))
    lamp("POINT", (0, 2, 1.5), None, 80.0)


@case("material/refraction_lamps", "Frosted panes seen at a slant, lamps behind: they answer lamps in directions that they never send light from.", spp=64)
def refraction_lamps():
    world((0, 0, 0))
    m, tree, out = material("Half")
    frosted = node(tree, "ShaderNodeBsdfRefraction", {"distribution": "GGX"}, Roughness=0.9, IOR=1.45)
    matt = node(tree, "ShaderNodeBsdfTranslucent", Color=(0.8, 0.8, 0.8))
    tree.links.new(_mixed(tree, frosted.outputs[0], matt.outputs[0], 0.3).outputs[0], out.inputs["Surface"])
    quad("Left", [(-4, -4, 0), (0, -4, 0), (0, 4, 0), (-4, 4, 0)], closure("Frosted", "ShaderNodeBsdfRefraction", {"distribution": "GGX"}, Roughness=0.9, IOR=1.45))
    quad("Right", [(0, -4, 0), (4, -4, 0), (4, 4, 0), (0, 4, 0)], m)
    lamp("AREA", (0, 0, -1.5), (0, 0, 0), 150.0, size=2.0)
    lamp("POINT", (1.5, -2, -0.5), None, 10.0, color=(1.0, 0.5, 0.2), shadow_soft_size=0.1)
    camera((0.0, -5.0, 1.8), (0.0, 0.0, 0.0))
