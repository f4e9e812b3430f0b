#!/usr/bin/env python3
"""Makes a scene of the kitchen's bare geometry: white Lambert, one shining panel below the ceiling, a camera, so that every renderer of
`rayloom bench error-time` can draw it.

  benches/peers/kitchen_scene.py bitterli_kitchen.glb OUT.glb
"""
import json
import math
import struct
import sys

CAMERA, TARGET = (1.2, 1.6, 3.4), (-0.6, 1.1, -1.0)
# Middle and half sides of the panel, watts a steradian a square metre.
PANEL, HALF, RADIANCE = (0.2, 2.55, 1.0), (0.7, 0.7), 6.0
DIFFUSE = {"type": "diffuse", "color": [0.7, 0.7, 0.7], "roughness": 0}
EMISSION = {"type": "emission", "color": [1, 1, 1], "strength": RADIANCE}


def matrix(eye, target):
    """Of a camera that looks along -z, column by column."""
    unit = lambda v: [c / math.sqrt(sum(c * c for c in v)) for c in v]
    cross = lambda a, b: [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    z = unit([e - t for e, t in zip(eye, target)])
    x = unit(cross((0, 1, 0), z))
    return [*x, 0, *cross(z, x), 0, *z, 0, *eye, 1]


def main(source, out):
    data = open(source, "rb").read()
    n = struct.unpack("<I", data[12:16])[0]
    scene, binary = json.loads(data[20 : 20 + n]), bytearray(data[28 + n :])
    scene["materials"] = [
        {"doubleSided": True, "pbrMetallicRoughness": {"baseColorFactor": [0.7, 0.7, 0.7, 1], "metallicFactor": 0, "roughnessFactor": 1},
         "extensions": {"KHR_materials_specular": {"specularFactor": 0}, "RAYLOOM_scene": {"nodes": [DIFFUSE], "surface": 0}}},
        {"doubleSided": True, "pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, 1], "metallicFactor": 0, "roughnessFactor": 1},
         "emissiveFactor": [1, 1, 1],
         "extensions": {"KHR_materials_specular": {"specularFactor": 0}, "KHR_materials_emissive_strength": {"emissiveStrength": RADIANCE},
                        "RAYLOOM_scene": {"nodes": [EMISSION], "surface": 0}}},
    ]
    scene["extensionsUsed"] = sorted({*scene.get("extensionsUsed", []), "KHR_materials_specular", "KHR_materials_emissive_strength", "RAYLOOM_scene"})
    for mesh in scene["meshes"]:
        for p in mesh["primitives"]:
            p["material"] = 0
    (x, y, z), (a, b) = PANEL, HALF
    corners = [(x - a, y, z - b), (x + a, y, z - b), (x + a, y, z + b), (x - a, y, z + b)]
    binary += b"\0" * (-len(binary) % 4)
    start = len(binary)
    binary += b"".join(struct.pack("<3f", *c) for c in corners) + struct.pack("<6H", 0, 1, 2, 0, 2, 3)
    views, accessors = scene["bufferViews"], scene["accessors"]
    views += [{"buffer": 0, "byteOffset": start, "byteLength": 48}, {"buffer": 0, "byteOffset": start + 48, "byteLength": 12}]
    low, high = ([f(c[k] for c in corners) for k in range(3)] for f in (min, max))
    accessors += [{"bufferView": len(views) - 2, "componentType": 5126, "count": 4, "type": "VEC3", "min": low, "max": high},
                  {"bufferView": len(views) - 1, "componentType": 5123, "count": 6, "type": "SCALAR"}]
    panel = {"attributes": {"POSITION": len(accessors) - 2}, "indices": len(accessors) - 1, "material": 1}
    scene["meshes"].append({"name": "Panel", "primitives": [panel]})
    scene["cameras"] = [{"type": "perspective", "perspective": {"yfov": 0.9, "aspectRatio": 4 / 3, "znear": 0.01}}]
    nodes = scene["nodes"]
    nodes += [{"name": "Panel", "mesh": len(scene["meshes"]) - 1}, {"name": "Camera", "camera": 0, "matrix": matrix(CAMERA, TARGET)}]
    # The extension wants Blender's axes, though nothing hangs on them.
    nodes.append({"name": "Blender", "rotation": [-(0.5**0.5), 0, 0, 0.5**0.5]})
    scene["scenes"][scene.get("scene", 0)]["nodes"] += [len(nodes) - 3, len(nodes) - 2, len(nodes) - 1]
    scene["buffers"][0]["byteLength"] = len(binary)
    bounces = {"total": 12, "diffuse": 4, "glossy": 4, "transmission": 12, "volume": 0, "transparent": 8}
    render = {"resolution": [192, 144], "bounces": bounces, "clampDirect": 0, "clampIndirect": 0, "filterGlossy": 0}
    scene["extensions"] = {"RAYLOOM_scene": {"version": 1, "generator": "kitchen_scene.py", "root": len(nodes) - 1, "camera": len(nodes) - 2, "render": render}}
    text = json.dumps(scene).encode()
    text += b" " * (-len(text) % 4)
    binary += b"\0" * (-len(binary) % 4)
    head = struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(binary))
    open(out, "wb").write(head + struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(binary), b"BIN\0") + binary)


main(*sys.argv[1:3])
