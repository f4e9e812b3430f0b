# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's shader nodes whose sockets are carried as they stand: by node type, the record's type and the socket of each input."""

_PRINCIPLED = {
    "baseColor": "Base Color",
    "metallic": "Metallic",
    "roughness": "Roughness",
    "ior": "IOR",
    "alpha": "Alpha",
    "normal": "Normal",
    "diffuseRoughness": "Diffuse Roughness",
    "subsurfaceWeight": "Subsurface Weight",
    "subsurfaceRadius": "Subsurface Radius",
    "subsurfaceScale": "Subsurface Scale",
    "subsurfaceIor": "Subsurface IOR",
    "subsurfaceAnisotropy": "Subsurface Anisotropy",
    "specularIorLevel": "Specular IOR Level",
    "specularTint": "Specular Tint",
    "anisotropic": "Anisotropic",
    "anisotropicRotation": "Anisotropic Rotation",
    "tangent": "Tangent",
    "transmissionWeight": "Transmission Weight",
    "coatWeight": "Coat Weight",
    "coatRoughness": "Coat Roughness",
    "coatIor": "Coat IOR",
    "coatTint": "Coat Tint",
    "coatNormal": "Coat Normal",
    "sheenWeight": "Sheen Weight",
    "sheenRoughness": "Sheen Roughness",
    "sheenTint": "Sheen Tint",
    "emissionColor": "Emission Color",
    "emissionStrength": "Emission Strength",
    "thinFilmThickness": "Thin Film Thickness",
    "thinFilmIor": "Thin Film IOR",
}
_VOLUME = {"color": "Color", "density": "Density"}
_BSDF = {"color": "Color", "roughness": "Roughness", "normal": "Normal"}

# Node type → (record type, {input: socket}, {choice: property of the node}).
CLOSURES = {
    "BSDF_PRINCIPLED": ("principled", _PRINCIPLED, {"distribution": "distribution", "subsurfaceMethod": "subsurface_method"}),
    "BSDF_DIFFUSE": ("diffuse", _BSDF, {}),
    "BSDF_GLOSSY": (
        "glossy",
        {**_BSDF, "anisotropy": "Anisotropy", "rotation": "Rotation", "tangent": "Tangent"},
        {"distribution": "distribution"},
    ),
    "BSDF_GLASS": (
        "glass",
        {**_BSDF, "ior": "IOR", "thinFilmThickness": "Thin Film Thickness", "thinFilmIor": "Thin Film IOR"},
        {"distribution": "distribution"},
    ),
    "BSDF_REFRACTION": ("refraction", {**_BSDF, "ior": "IOR"}, {"distribution": "distribution"}),
    "BSDF_TRANSLUCENT": ("translucent", {"color": "Color", "normal": "Normal"}, {}),
    "BSDF_TRANSPARENT": ("transparent", {"color": "Color"}, {}),
    "SUBSURFACE_SCATTERING": (
        "subsurface",
        {**_BSDF, "scale": "Scale", "radius": "Radius", "ior": "IOR", "anisotropy": "Anisotropy"},
        {"method": "falloff"},
    ),
    "BSDF_SHEEN": ("sheen", _BSDF, {"distribution": "distribution"}),
    "BSDF_METALLIC": (
        "metallicBsdf",
        {
            "baseColor": "Base Color",
            "edgeTint": "Edge Tint",
            "ior": "IOR",
            "extinction": "Extinction",
            "roughness": "Roughness",
            "anisotropy": "Anisotropy",
            "rotation": "Rotation",
            "normal": "Normal",
            "tangent": "Tangent",
        },
        {"fresnel": "fresnel_type", "distribution": "distribution"},
    ),
    "EMISSION": ("emission", {"color": "Color", "strength": "Strength"}, {}),
    "BACKGROUND": ("background", {"color": "Color", "strength": "Strength"}, {}),
    "HOLDOUT": ("holdout", {}, {}),
    "BSDF_HAIR": (
        "hair",
        {"color": "Color", "offset": "Offset", "roughnessU": "RoughnessU", "roughnessV": "RoughnessV"},
        {"component": "component"},
    ),
    "BSDF_HAIR_PRINCIPLED": (
        "principledHair",
        {
            "color": "Color",
            "melanin": "Melanin",
            "melaninRedness": "Melanin Redness",
            "tint": "Tint",
            "absorption": "Absorption Coefficient",
            "roughness": "Roughness",
            "radialRoughness": "Radial Roughness",
            "coat": "Coat",
            "ior": "IOR",
            "offset": "Offset",
            "randomColor": "Random Color",
            "randomRoughness": "Random Roughness",
            "random": "Random",
            "aspectRatio": "Aspect Ratio",
            "reflection": "Reflection",
            "transmission": "Transmission",
            "secondaryReflection": "Secondary Reflection",
        },
        {"model": "model", "parametrization": "parametrization"},
    ),
    "PRINCIPLED_VOLUME": (
        "principledVolume",
        {
            **_VOLUME,
            "anisotropy": "Anisotropy",
            "absorptionColor": "Absorption Color",
            "emissionStrength": "Emission Strength",
            "emissionColor": "Emission Color",
            "blackbodyIntensity": "Blackbody Intensity",
            "blackbodyTint": "Blackbody Tint",
            "temperature": "Temperature",
        },
        {},
    ),
    "VOLUME_ABSORPTION": ("volumeAbsorption", _VOLUME, {}),
    "VOLUME_SCATTER": (
        "volumeScatter",
        {**_VOLUME, "anisotropy": "Anisotropy", "ior": "IOR", "backscatter": "Backscatter", "alpha": "Alpha", "diameter": "Diameter"},
        {"phase": "phase"},
    ),
}

# Values with sockets only: node type → (record type, {input: socket}, {choice: property}, {socket: output}).
VALUES = {
    "GAMMA": ("gamma", {"color": "Color", "gamma": "Gamma"}, {}, {"Color": "color"}),
    "BLACKBODY": ("blackbody", {"temperature": "Temperature"}, {}, {"Color": "color"}),
    "INVERT": ("invert", {"color": "Color", "fac": "Fac"}, {}, {"Color": "color"}),
    "BRIGHTCONTRAST": ("brightContrast", {"color": "Color", "bright": "Bright", "contrast": "Contrast"}, {}, {"Color": "color"}),
    "HUE_SAT": (
        "hueSaturation",
        {"color": "Color", "hue": "Hue", "saturation": "Saturation", "value": "Value", "fac": "Fac"},
        {},
        {"Color": "color"},
    ),
    "SEPXYZ": ("separate", {"color": "Vector"}, {}, {"X": "x", "Y": "y", "Z": "z"}),
    "COMBXYZ": ("combine", {"x": "X", "y": "Y", "z": "Z"}, {}, {"Vector": "color"}),
    "RGBTOBW": ("rgbToBw", {"color": "Color"}, {}, {"Val": "value"}),
    "FRESNEL": ("fresnel", {"ior": "IOR", "normal": "Normal"}, {}, {"Fac": "value"}),
    "LAYER_WEIGHT": ("layerWeight", {"blend": "Blend", "normal": "Normal"}, {}, {"Fresnel": "fresnel", "Facing": "facing"}),
    "NEW_GEOMETRY": (
        "geometry",
        {},
        {},
        {"Position": "position", "Normal": "normal", "Backfacing": "backfacing", "Random Per Island": "random"},
    ),
    "OBJECT_INFO": (
        "objectInfo",
        {},
        {},
        {"Color": "color", "Random": "random", "Object Index": "objectIndex", "Material Index": "materialIndex", "Location": "location", "Alpha": "alpha"},
    ),
    "HAIR_INFO": ("curvesInfo", {}, {}, {"Intercept": "intercept", "Is Strand": "isStrand", "Random": "random", "Length": "length"}),
    "LIGHT_PATH": (
        "lightPath",
        {},
        {},
        {
            "Is Camera Ray": "isCameraRay",
            "Is Shadow Ray": "isShadowRay",
            "Is Diffuse Ray": "isDiffuseRay",
            "Is Glossy Ray": "isGlossyRay",
            "Is Singular Ray": "isSingularRay",
            "Is Reflection Ray": "isReflectionRay",
            "Is Transmission Ray": "isTransmissionRay",
            "Is Volume Scatter Ray": "isVolumeScatterRay",
            "Ray Length": "rayLength",
            "Ray Depth": "rayDepth",
        },
    ),
}

# Blender's names of choices → the file's, where lower camel case is not enough.
WORDS = {
    "MULTI_GGX": "multiGgx",
    "GGX": "ggx",
    "BECKMANN": "beckmann",
    "ASHIKHMIN_SHIRLEY": "ashikhminShirley",
    "RANDOM_WALK": "randomWalk",
    "RANDOM_WALK_SKIN": "randomWalkSkin",
    "COLOR": "color",
    "COMBRGB": "rgb",
    "PHYSICAL_CONDUCTOR": "conductor",
    "F82": "f82",
    "NISHITA": "nishita",
    "SINGLE_SCATTERING": "singleScattering",
    "MULTIPLE_SCATTERING": "multipleScattering",
    "HOSEK_WILKIE": "hosekWilkie",
    "MIRROR_BALL": "mirrorBall",
    "RANGE": "range",
}


def word(name):
    """A choice of Blender's (`MULTI_GGX`) as the file writes it (`multiGgx`)."""
    if name in WORDS:
        return WORDS[name]
    first, *rest = name.lower().split("_")
    return first + "".join(r.capitalize() for r in rest)
