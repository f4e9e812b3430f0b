# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials: Blender's shader tree as the file has it, and the glTF material that other programs show."""

from ..core.bake import Baker
from ..core.fallback import gltf_material
from ..core.lower import Lowering
from ..core.schema import NAME
from .displacement import Displacement, bump, height_of, method_of
from .links import output_node
from .nodes import Graph


def plain_record(version):
    """The material of surfaces that have none: diffuse, from Blender 5.0 on Principled's defaults. Source: measured, 4.2, 4.5 and 5.0."""
    node = {"type": "principled"} if version >= (5, 0, 0) else {"type": "diffuse", "color": [0.8, 0.8, 0.8]}
    plain = {"baseColorFactor": [0.8, 0.8, 0.8, 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.5 if version >= (5, 0, 0) else 1.0}
    return {"name": "Default", "pbrMetallicRoughness": plain, "extensions": {NAME: {"nodes": [node], "surface": 0}}}


def material_record(material, surroundings, images, uv_names, color_names):
    """glTF's record of a material, whether it names layers of its mesh, and how it moves the vertices (bridge/displacement.py) or `None`."""
    tell = surroundings.log
    graph = Graph(images, tell, uv_names, color_names)
    displacement = None
    lowering = Lowering(graph.nodes, Baker(surroundings), tell)
    extension = {"nodes": lowering.out}
    tree = material.node_tree if getattr(material, "use_nodes", True) else None
    if tree is None:
        extension["nodes"].append({"type": "principled", "baseColor": list(material.diffuse_color)[:3], "roughness": material.roughness})
        extension["nodes"][0]["metallic"] = material.metallic
        extension["surface"] = 0
    else:
        end = output_node(tree, "OUTPUT_MATERIAL")
        for key, name in (("surface", "Surface"), ("volume", "Volume")):
            k = graph.closure(end.inputs[name]) if end else None
            if key == "surface" and k is not None:
                displacement = _displacement(material, graph, end, surroundings, tell)
            if k is not None:
                extension[key] = lowering.surface(k) if key == "surface" else lowering.closure(k)
    cycles = getattr(material, "cycles", None)
    if cycles is not None:
        sides = {"NONE": "none", "FRONT": "front", "BACK": "back", "FRONT_BACK": "frontBack"}
        sampling = sides.get(getattr(cycles, "emission_sampling", "AUTO"))
        if sampling:
            extension["emissionSampling"] = sampling
        # Gone in 5.0.
        if getattr(cycles, "homogeneous_volume", False):
            extension["homogeneousVolume"] = True
        if getattr(cycles, "volume_step_rate", 1.0) != 1.0:
            extension["volumeStepRate"] = cycles.volume_step_rate
    if not getattr(material, "use_transparent_shadow", True):
        extension["transparentShadow"] = False
    if material.pass_index:
        extension["passIndex"] = material.pass_index
    record = gltf_material(extension, images.records, surroundings.gltf)
    record["name"] = material.name
    record["extensions"] = {**record.get("extensions", {}), NAME: extension}
    return record, graph.names_layers, displacement


def _displacement(material, graph, end, surroundings, tell):
    """Bump maps for what is not moved; what moves vertices, or `None`."""
    found, method = height_of(graph, end.inputs["Displacement"]), method_of(material)
    if found is None:
        return None
    height, in_world = found
    if method != "DISPLACEMENT":
        bump(graph, height)
    return None if method == "BUMP" else Displacement(graph.nodes, height, in_world, method == "BOTH", surroundings, tell)
