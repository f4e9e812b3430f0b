# SPDX-License-Identifier: GPL-3.0-or-later
"""The displacement of a material: as a bump map, Blender's default, or by moving the vertices that the mesh has, as Cycles does."""

import numpy as np

from ..core.evaluate import Evaluator
from ..core.values import Unknown, as_number
from .links import find_source
from .mesh import positions_of
from .values import input_value

# Closures whose normal a bump map turns.
_TURNED = {"principled", "diffuse", "glossy", "glass", "refraction", "translucent", "subsurface", "sheen", "metallicBsdf"}


def method_of(material):
    """`BUMP`, `DISPLACEMENT` or `BOTH`."""
    own = getattr(material, "displacement_method", None)
    return own or getattr(getattr(material, "cycles", None), "displacement_method", "BUMP")


def height_of(graph, socket):
    """`(height above the surface as an input of the graph, whether it is in world space)`; `None` where there is none, which is told."""
    node, _, path = find_source(socket, ())
    if node is None:
        return None
    if node.type != "DISPLACEMENT":
        graph.log(f"displacement by the node '{node.name}' is left out")
        return None
    if find_source(node.inputs["Normal"], path)[0] is not None:
        graph.log("the direction of displacement is the surface's normal")
    height, middle, scale = (input_value(graph, node, name, path) for name in ("Height", "Midlevel", "Scale"))
    above = {"node": graph.add({"type": "math", "operation": "subtract", "a": height, "b": middle})}
    return {"node": graph.add({"type": "math", "operation": "multiply", "a": above, "b": scale})}, node.space == "WORLD"


def bump(graph, height):
    """Gives closures without a normal of their own that of a bump map."""
    bumped = {"node": graph.add({"type": "bump", "height": height, "strength": 1.0, "distance": 1.0, "invert": False})}
    for record in graph.nodes:
        if record["type"] == "bump" and record is not graph.nodes[bumped["node"]]:
            # What has no normal below it stands on the displaced surface.
            record.setdefault("normal", bumped)
        elif record["type"] in _TURNED:
            if "normal" in record and graph.nodes[record["normal"]["node"]]["type"] == "normalMap":
                graph.log("displacement does not count where a normal map is")
            record.setdefault("normal", bumped)


class Displacement:
    """How a material moves the vertices of a mesh. `keeps_normals`: a bump map says how it is lit."""

    def __init__(self, nodes, height, in_world, keeps_normals, around, log):
        self.nodes, self.height, self.in_world, self.keeps_normals = nodes, height, in_world, keeps_normals
        self.around, self.log = around, log

    def offsets(self, layout, normals):
        """By how much each vertex of a layout (bridge/mesh.py) moves, (n, 3), in the object's space; `None` where it cannot be told."""
        around = self.around
        at = positions_of(around.mesh)[layout["source_vertex"]]

        def points(source, uv_set):
            if source == "uv":
                uv = layout["uvs"][uv_set][1] if uv_set < len(layout["uvs"]) else np.zeros((len(at), 2))
                return np.pad(uv, ((0, 0), (0, 1)))
            return normals if source == "normal" else around.points(source, at)

        try:
            height = as_number(Evaluator(self.nodes, points, around.image, around.about).value(self.height))
        except Unknown as e:
            self.log(f"displacement is left out: '{e}' is not evaluated")
            return None
        height = np.broadcast_to(height, (len(at),))[:, None]
        if not self.in_world:
            return (normals * height).astype(np.float32)
        around.placed = True
        back = np.linalg.pinv(np.array(around.shown.matrix)[:3, :3].astype(np.float64))
        world = normals @ back
        world /= np.maximum(np.linalg.norm(world, axis=1, keepdims=True), 1e-12)
        return ((world * height) @ back.T).astype(np.float32)


def displaced(layout, mesh, by_slot):
    """Positions of a layout's vertices where materials move them, the layout with its new normals, and the offsets; `by_slot`: a [`Displacement`] or
    `None` for each material slot; triangles' slots stand in `layout["slot"]`."""
    positions = positions_of(mesh)[layout["source_vertex"]]
    smooth = smooth_normals(positions_of(mesh), layout)
    own = layout["normals"] if layout["normals"] is not None else smooth
    offsets, turned = np.zeros_like(positions), np.zeros(len(positions), bool)
    for slot, displacement in enumerate(by_slot):
        if displacement is None:
            continue
        moved = displacement.offsets(layout, own)
        if moved is None:
            continue
        corners = layout["indices"][layout["slot"] == slot].ravel()
        offsets[corners] = moved[corners]
        turned[corners] = not displacement.keeps_normals
    if layout["normals"] is not None and turned.any():
        normals = smooth_normals(positions + offsets, layout, own_vertices=True)
        layout = {**layout, "normals": np.where(turned[:, None], normals, layout["normals"])}
    return positions + offsets, layout, offsets


def smooth_normals(positions, layout, own_vertices=False):
    """Normals of a layout's vertices, those of its triangles weighted by their angles. `positions` are the mesh's, or, `own_vertices`, the layout's."""
    vertex = layout["source_vertex"]
    corners = layout["indices"]
    p = (positions if own_vertices else positions[vertex])[corners].astype(np.float64)
    edges = np.roll(p, -1, axis=1) - p
    face = np.cross(edges[:, 0], -edges[:, 2])
    face /= np.maximum(np.linalg.norm(face, axis=1, keepdims=True), 1e-30)
    unit = edges / np.maximum(np.linalg.norm(edges, axis=2, keepdims=True), 1e-30)
    angle = np.arccos(np.clip(-(unit * np.roll(unit, 1, axis=1)).sum(axis=2), -1.0, 1.0))
    out = np.zeros((int(vertex.max()) + 1, 3))
    for k in range(3):
        for axis in range(3):
            out[:, axis] += np.bincount(vertex[corners[:, k]], face[:, axis] * angle[:, k], len(out))
    out /= np.maximum(np.linalg.norm(out, axis=1, keepdims=True), 1e-30)
    return out[vertex].astype(np.float32)
