# SPDX-License-Identifier: GPL-3.0-or-later
"""Shader nodes → the nearest glTF material, for programs that do not know the extension."""

from .schema import is_link


def gltf_material(extension, images, gltf):
    """A glTF material like the surface of `extension`; textures and extensions that it uses are added to the document."""
    nodes, surface = extension["nodes"], extension.get("surface")
    if surface is None:
        # A body that is only volume: glTF would show its hull.
        gray = {"baseColorFactor": [1.0, 1.0, 1.0, 0.05 if "volume" in extension else 1.0], "metallicFactor": 0.0, "roughnessFactor": 1.0}
        return {"pbrMetallicRoughness": gray, "alphaMode": "BLEND" if "volume" in extension else "OPAQUE", "doubleSided": True}
    node = _main(nodes, surface)
    kind = node["type"]
    color = _constant(node.get("baseColor", node.get("color", 0.8)))
    pbr = {"baseColorFactor": [*_unit(color), 1.0], "metallicFactor": 0.0, "roughnessFactor": _number(node.get("roughness", 0.5))}
    record = {"pbrMetallicRoughness": pbr, "doubleSided": True}
    if kind == "principled":
        _principled(record, node, nodes, images, gltf)
    elif kind == "emission":
        pbr["baseColorFactor"] = [0.0, 0.0, 0.0, 1.0]
        _emission(record, color, _number(node.get("strength", 1.0)), gltf)
    elif kind in {"glossy", "metallicBsdf"}:
        pbr["metallicFactor"] = 1.0
    elif kind in {"glass", "refraction"}:
        _extension(record, "KHR_materials_transmission", {"transmissionFactor": 1.0}, gltf)
        _extension(record, "KHR_materials_ior", {"ior": max(1.0, _number(node.get("ior", 1.5)))}, gltf)
    elif kind == "transparent":
        pbr["baseColorFactor"][3], record["alphaMode"] = 0.0, "BLEND"
    return record


def _main(nodes, ix):
    """The closure that shows most: the second of a mix of more than half, else the first."""
    node = nodes[ix]
    for _ in range(len(nodes)):
        if node["type"] not in {"mix", "add"}:
            return node
        second = node["type"] == "mix" and _number(node.get("factor", 0.5)) > 0.5
        ix = node.get("b" if second else "a", node.get("a", node.get("b")))
        if ix is None:
            return {"type": "transparent"}
        node = nodes[ix]
    return node


def _constant(value):
    if is_link(value):
        return [0.8, 0.8, 0.8]
    return list(value) if isinstance(value, (list, tuple)) else [float(value)] * 3


def _number(value):
    if is_link(value):
        return 0.5
    return sum(value) / len(value) if isinstance(value, (list, tuple)) else float(value)


def _unit(color):
    return [min(max(float(c), 0.0), 1.0) for c in color]


def _extension(record, name, value, gltf):
    record.setdefault("extensions", {})[name] = value
    gltf.use_extension(name)


def _emission(record, color, strength, gltf):
    peak = max(max(color), 1e-9)
    if strength <= 0.0 or peak <= 1e-9:
        return
    record["emissiveFactor"] = _unit([c / peak for c in color])
    if strength * peak != 1.0:
        _extension(record, "KHR_materials_emissive_strength", {"emissiveStrength": strength * peak}, gltf)


def _principled(record, node, nodes, images, gltf):
    pbr = record["pbrMetallicRoughness"]
    pbr["metallicFactor"] = _number(node.get("metallic", 0.0))
    base = _texture(node.get("baseColor"), nodes, images, gltf)
    if base:
        pbr["baseColorTexture"] = base
        pbr["baseColorFactor"] = [1.0] * 4
    alpha = node.get("alpha", 1.0)
    if is_link(alpha) or _number(alpha) < 1.0:
        record["alphaMode"] = "BLEND"
        pbr["baseColorFactor"][3] = 1.0 if is_link(alpha) else _number(alpha)
    packed = {k: _texture(node.get(k), nodes, images, gltf, c) for k, c in (("roughness", "y"), ("metallic", "z"))}
    if packed["roughness"] or packed["metallic"]:
        pbr["metallicRoughnessTexture"] = packed["roughness"] or packed["metallic"]
        for key, factor in (("roughness", "roughnessFactor"), ("metallic", "metallicFactor")):
            if packed[key]:
                pbr[factor] = 1.0
    normal = node.get("normal")
    if is_link(normal) and nodes[normal["node"]]["type"] == "normalMap":
        picture = _texture(nodes[normal["node"]]["color"], nodes, images, gltf)
        if picture:
            record["normalTexture"] = picture
    _emission(record, _constant(node.get("emissionColor", 1.0)), _number(node.get("emissionStrength", 0.0)), gltf)
    ior, transmission = _number(node.get("ior", 1.5)), _number(node.get("transmissionWeight", 0.0))
    if ior != 1.5:
        _extension(record, "KHR_materials_ior", {"ior": max(1.0, ior)}, gltf)
    if transmission > 0.0:
        _extension(record, "KHR_materials_transmission", {"transmissionFactor": min(transmission, 1.0)}, gltf)
    level = _number(node.get("specularIorLevel", 0.5))
    if level != 0.5:
        _extension(record, "KHR_materials_specular", {"specularFactor": min(2.0 * level, 1.0)}, gltf)
    coat = _number(node.get("coatWeight", 0.0))
    if coat > 0.0:
        value = {"clearcoatFactor": min(coat, 1.0), "clearcoatRoughnessFactor": _number(node.get("coatRoughness", 0.03))}
        _extension(record, "KHR_materials_clearcoat", value, gltf)
    sheen = _number(node.get("sheenWeight", 0.0))
    if sheen > 0.0:
        tint = _unit([c * sheen for c in _constant(node.get("sheenTint", 1.0))])
        value = {"sheenColorFactor": tint, "sheenRoughnessFactor": _number(node.get("sheenRoughness", 0.5))}
        _extension(record, "KHR_materials_sheen", value, gltf)


def _texture(value, nodes, images, gltf, channel=None):
    """glTF's reference to a picture; `channel`: the channel that it must stand in. `None` where there is no such."""
    if not is_link(value):
        return None
    node = nodes[value["node"]]
    if channel:
        if node["type"] != "separate" or value.get("output") != channel or not is_link(node["color"]):
            return None
        node = nodes[node["color"]["node"]]
    if node["type"] != "image" or "source" not in images[node["image"]]:
        return None
    wrap = {"extend": 33071, "clip": 33071, "mirror": 33648}.get(node.get("extension"), 10497)
    filter_code = 9728 if node.get("interpolation") == "closest" else 9729
    sampler = {"magFilter": filter_code, "wrapS": wrap, "wrapT": wrap}
    texture = {"source": images[node["image"]]["source"], "sampler": _shared(gltf, "samplers", sampler)}
    info = {"index": _shared(gltf, "textures", texture)}
    where = node.get("coordinates", {})
    if where.get("uvSet"):
        info["texCoord"] = where["uvSet"]
    if "affine" in where:
        a = where["affine"]
        # v runs up there and down here; turned maps are left to the extension.
        if a[1] == 0.0 and a[4] == 0.0:
            transform = {"offset": [a[3], 1.0 - a[5] - a[7]], "scale": [a[0], a[5]]}
            info["extensions"] = {"KHR_texture_transform": transform}
            gltf.use_extension("KHR_texture_transform")
    return info


def _shared(gltf, table, record):
    rows = gltf.document.setdefault(table, [])
    if record not in rows:
        rows.append(record)
    return rows.index(record)
