# SPDX-License-Identifier: GPL-3.0-or-later
"""Passes: their names in the file, in the renderer's OpenEXR and in Blender."""

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
    "diffuseDirect": ("DiffDir", "RGB", "COLOR"),
    "diffuseIndirect": ("DiffInd", "RGB", "COLOR"),
    "diffuseColor": ("DiffCol", "RGB", "COLOR"),
    "glossyDirect": ("GlossDir", "RGB", "COLOR"),
    "glossyIndirect": ("GlossInd", "RGB", "COLOR"),
    "glossyColor": ("GlossCol", "RGB", "COLOR"),
    "transmissionDirect": ("TransDir", "RGB", "COLOR"),
    "transmissionIndirect": ("TransInd", "RGB", "COLOR"),
    "transmissionColor": ("TransCol", "RGB", "COLOR"),
    "emission": ("Emit", "RGB", "COLOR"),
    "environment": ("Env", "RGB", "COLOR"),
    "ambientOcclusion": ("AO", "RGB", "COLOR"),
}


def find(picture, blender_name, channels):
    """The planes of a pass in the renderer's file, one for each channel; `None` where it has none.

    Blender's multilayer names (`ViewLayer.Depth.Z`), short ones (`Depth.Z`), and the picture itself for Combined are known.
    """
    if blender_name == "Combined":
        known = picture.channels
        if not all(c in known for c in "RGB"):
            return None
        alpha = known.get("A")
        rgb = [known[c] for c in "RGB"]
        return [*rgb, alpha if alpha is not None else rgb[0] * 0.0 + 1.0]
    for layer, planes in picture.layers().items():
        if layer.rpartition(".")[2].lower() != blender_name.lower():
            continue
        if all(c in planes for c in channels):
            return [planes[c] for c in channels]
        if len(channels) == len(planes):
            return [planes[c] for c in sorted(planes)]
    return None
