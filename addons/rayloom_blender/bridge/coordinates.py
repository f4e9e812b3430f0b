# SPDX-License-Identifier: GPL-3.0-or-later
"""Texture coordinates: Texture Coordinate, UV Map and Mapping nodes → a source and an affine map."""

from mathutils import Euler, Matrix, Vector

from ..core.lower import as_constant
from .links import find_source, socket_of

_SOURCES = {
    "Generated": "generated",
    "Normal": "normal",
    "UV": "uv",
    "Object": "object",
    "Camera": "camera",
    "Window": "window",
    "Reflection": "reflection",
}


def coordinates(graph, socket, path, default):
    """`{"source", "uvSet", "affine"}`, or `{"node"}` where they are computed. `default`: the source of an unlinked socket."""
    matrix = Matrix.Identity(4)
    if socket is None:
        return {"source": default}
    mapped = False
    while True:
        node, out, inner = find_source(socket, path)
        if node is None:
            if mapped and out is not None:  # a Mapping node without input moves the point (0, 0, 0)
                value = [float(v) for v in out.default_value] if hasattr(out, "default_value") else [0.0] * 3
                matrix = Matrix.Translation(matrix @ Vector(value[:3])) @ Matrix.Scale(0.0, 4)
            return _record(default, matrix)
        path = inner
        if node.type == "MAPPING":
            own = _mapping(graph, node, path)
            if own is not None:
                matrix, mapped, socket = matrix @ own, True, socket_of(node, "Vector")
                continue
        if node.type == "TEX_COORD" and out.name in _SOURCES:
            source = _SOURCES[out.name]
            if source == "object" and node.object is not None:
                return _record("position", matrix @ node.object.matrix_world.inverted_safe())
            return _record(source, matrix)
        if node.type == "UVMAP":
            return _record("uv", matrix, uv_set(graph, node.uv_map))
        if node.type == "NEW_GEOMETRY" and out.name in {"Position", "Normal"}:
            return _record(out.name.lower(), matrix)
        link = graph.value(socket, path)
        if matrix == Matrix.Identity(4) or not isinstance(link, dict):
            return link if isinstance(link, dict) else {"source": default}
        return {"node": graph.add({"type": "affineMap", "vector": link, "affine": _rows(matrix)}), "output": "color"}


def uv_set(graph, name):
    """Index of a UV layer; the first is the one that renders."""
    if not name:
        return 0
    graph.names_layers = True
    if name in graph.uv_names:
        return graph.uv_names.index(name)
    graph.log(f"there is no UV map '{name}'")
    return 0


def _rows(matrix):
    return [float(matrix[r][c]) for r in range(3) for c in range(4)]


def _record(source, matrix, uv=0):
    out = {"source": source}
    if uv:
        out["uvSet"] = uv
    if matrix != Matrix.Identity(4):
        out["affine"] = _rows(matrix)
    return out


def _mapping(graph, node, path):
    """The map of a Mapping node; `None` when its sockets are computed."""
    kind = node.vector_type
    parts = []
    for name, rest in (("Location", (0.0,) * 3), ("Rotation", (0.0,) * 3), ("Scale", (1.0,) * 3)):
        socket = socket_of(node, name)
        value = rest if socket is None or not socket.enabled else as_constant(graph.nodes, graph.value(socket, path))
        if value is None:
            return None
        parts.append([float(v) for v in (value if hasattr(value, "__len__") else [value] * 3)])
    location, rotation, scale = parts
    turn = Euler(rotation).to_matrix().to_4x4()
    size = Matrix.Diagonal((*scale, 1.0))
    if kind == "TEXTURE":
        return (Matrix.Translation(location) @ turn @ size).inverted_safe()
    if kind == "POINT":
        return Matrix.Translation(location) @ turn @ size
    if kind == "VECTOR":
        return turn @ size
    return None
