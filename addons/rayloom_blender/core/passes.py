# SPDX-License-Identifier: GPL-3.0-or-later
"""Passes: their names in the scene's file, in the renderer's OpenEXR (docs/passes.md) and in Blender; Cryptomatte's manifest."""

import hashlib

# The file's name → (Blender's name, channels, kind as RenderEngine.register_pass wants it).
PASSES = {
    "depth": ("Depth", "Z", "VALUE"),
    "mist": ("Mist", "Z", "VALUE"),
    "position": ("Position", "XYZ", "VECTOR"),
    "normal": ("Normal", "XYZ", "VECTOR"),
    "vector": ("Vector", "XYZW", "VECTOR"),
    "uv": ("UV", "UVA", "VECTOR"),
    "objectId": ("IndexOB", "X", "VALUE"),
    "materialId": ("IndexMA", "X", "VALUE"),
    "albedo": ("Denoising Albedo", "RGB", "COLOR"),
    "denoisingNormal": ("Denoising Normal", "XYZ", "VECTOR"),
    "diffuseDirect": ("DiffDir", "RGB", "COLOR"),
    "diffuseIndirect": ("DiffInd", "RGB", "COLOR"),
    "diffuseColor": ("DiffCol", "RGB", "COLOR"),
    "glossyDirect": ("GlossDir", "RGB", "COLOR"),
    "glossyIndirect": ("GlossInd", "RGB", "COLOR"),
    "glossyColor": ("GlossCol", "RGB", "COLOR"),
    "transmissionDirect": ("TransDir", "RGB", "COLOR"),
    "transmissionIndirect": ("TransInd", "RGB", "COLOR"),
    "transmissionColor": ("TransCol", "RGB", "COLOR"),
    "volumeDirect": ("VolumeDir", "RGB", "COLOR"),
    "volumeIndirect": ("VolumeInd", "RGB", "COLOR"),
    "emission": ("Emit", "RGB", "COLOR"),
    "environment": ("Env", "RGB", "COLOR"),
    "ambientOcclusion": ("AO", "RGB", "COLOR"),
    "shadowCatcher": ("Shadow Catcher", "RGB", "COLOR"),
    "sampleCount": ("Debug Sample Count", "X", "VALUE"),
}
# The file's name → Blender's, before the number of the two ranks that a layer holds. Their channels are small letters in Cycles' files (measured, 4.5).
CRYPTOMATTE = {"cryptoObject": "CryptoObject", "cryptoMaterial": "CryptoMaterial", "cryptoAsset": "CryptoAsset"}
# Names from Blender 5.0 on (measured).
NAMES_5 = {
    "IndexOB": "Object Index",
    "IndexMA": "Material Index",
    "AO": "Ambient Occlusion",
    "Emit": "Emission",
    "Env": "Environment",
    **{
        f"{short}{part}": f"{long} {word}"
        for short, long in (("Diff", "Diffuse"), ("Gloss", "Glossy"), ("Trans", "Transmission"), ("Volume", "Volume"))
        for part, word in (("Dir", "Direct"), ("Ind", "Indirect"), ("Col", "Color"))
    },
}
# Names that Blender's passes have besides in the renderer's file.
_SAME = {"denoising depth": "depth", **{new.lower(): old.lower() for old, new in NAMES_5.items()}}
# What Cycles adds to a layer that keeps its denoising data, besides albedo and normal.
DENOISING_DATA = (("Noisy Image", "RGBA", "COLOR"), ("Denoising Depth", "Z", "VALUE"))


def registered(wanted, cryptomatte_ranks=6, more=(), version=(4, 5, 0)):
    """What to register for the wanted passes (the file's names), Combined first, then `more`: `(name in that version of Blender, channels, kind)` each."""
    out = [("Combined", "RGBA", "COLOR"), *more]
    for name in wanted:
        if name in PASSES:
            short, channels, kind = PASSES[name]
            out.append((NAMES_5.get(short, short) if version >= (5, 0, 0) else short, channels, kind))
        elif name in CRYPTOMATTE:
            out += [(f"{CRYPTOMATTE[name]}{k:02}", "rgba", "COLOR") for k in range((cryptomatte_ranks + 1) // 2)]
    return out


def find(picture, blender_name, channels):
    """The planes of a pass in the renderer's file, one for each channel; `None` where it has none.

    Blender's multilayer names (`ViewLayer.Depth.Z`), short ones (`Depth.Z`), and for Combined the picture of a file without layers are known.
    """
    wanted = blender_name.lower()
    wanted = _SAME.get(wanted, wanted)
    for layer, planes in picture.layers().items():
        if layer.rpartition(".")[2].lower() != wanted:
            continue
        by_name = {name.upper(): plane for name, plane in planes.items()}
        if all(c in by_name for c in channels.upper()):
            return [by_name[c] for c in channels.upper()]
    if blender_name != "Combined":
        return None
    known = picture.channels
    if not all(c in known for c in "RGB"):
        return None
    alpha = known.get("A")
    rgb = [known[c] for c in "RGB"]
    return [*rgb, alpha if alpha is not None else rgb[0] * 0.0 + 1.0]


def cryptomatte_fields(attributes, view_layer):
    """Cryptomatte's fields for the header of Blender's file, from that of the renderer's: `{"cryptomatte/1a2b3c4/name": …}`.

    The renderer calls its layer `ViewLayer`; the fields get the view layer's own name, and a key of it.
    """
    out = {}
    for key, value in attributes.items():
        parts = key.split("/")
        if len(parts) != 3 or parts[0] != "cryptomatte" or parts[2] != "name":
            continue
        kind = _string(value).rpartition(".")[2]
        name = f"{view_layer}.{kind}"
        own = hashlib.md5(name.encode(), usedforsecurity=False).hexdigest()[:7]
        out[f"cryptomatte/{own}/name"] = name
        for field in ("hash", "conversion", "manifest"):
            found = attributes.get(f"cryptomatte/{parts[1]}/{field}")
            if found is not None:
                out[f"cryptomatte/{own}/{field}"] = _string(found)
    return out


def _string(value):
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)
