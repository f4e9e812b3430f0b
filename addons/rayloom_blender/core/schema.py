# SPDX-License-Identifier: GPL-3.0-or-later
"""Names and constants of the RAYLOOM_scene extension (docs/RAYLOOM_scene.md)."""

NAME = "RAYLOOM_scene"
VERSION = 1

# Value nodes that the renderer evaluates at every hit; others are folded, baked or listed as ignored.
EVALUATED = {"image", "environment", "sky", "attribute", "normalMap", "bump", "separate", "grid"}

# Closures by their type: inputs that name other closures are plain indices.
CLOSURE_INPUTS = {"add": ("a", "b"), "mix": ("a", "b")}
CLOSURES = {
    "principled", "diffuse", "glossy", "glass", "refraction", "translucent", "transparent", "subsurface", "sheen", "metallicBsdf",
    "emission", "background", "holdout", "hair", "principledHair", "principledVolume", "volumeAbsorption", "volumeScatter", "add", "mix",
}

# Sorts of rays, keys of `lightPath` nodes.
RAYS = ("camera", "diffuse", "glossy", "transmission", "sharpGlossy", "sharpTransmission", "volumeScatter", "shadow", "light")

# Keys of nodes that are no inputs: choices, indices and lists.
CHOICES = {
    "type", "coordinates", "interpolation", "extension", "projection", "image", "grid", "space", "uvSet", "operation", "blend", "mode",
    "stops", "kind", "distribution", "subsurfaceMethod", "method", "model", "parametrization", "component", "fresnel", "phase", "name",
    "hash", "ray", "range", "table", "extrapolate", "isNumber", "isVector", "dimensions", "feature", "metric", "direction", "profile", "depth",
    "offsetFrequency", "squash", "squashFrequency", "clamp", "clampFactor", "clampResult", "invert", "normalize", "sunDisc", "source", "affine", "features",
}  # fmt: skip


def is_link(value):
    """Whether an input is the value of another node."""
    return isinstance(value, dict) and "node" in value


def inputs_of(node):
    """The inputs of a node as (key, value), those of closures by index left out; its coordinates too where a node gives them."""
    closures = CLOSURE_INPUTS.get(node["type"], ())
    for key, value in node.items():
        if key == "coordinates" and is_link(value):
            yield key, value
        elif key not in CHOICES and key not in closures:
            yield key, value
