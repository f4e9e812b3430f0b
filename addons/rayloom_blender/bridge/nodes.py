# SPDX-License-Identifier: GPL-3.0-or-later
"""Shader trees → lists of nodes as docs/RAYLOOM_scene.md has them, each node before those that use it."""

from ..core.lower import as_constant
from ..core.schema import is_link
from . import coordinates as coords
from .links import find_source, output_node, plain_value, socket_of
from .node_tables import CLOSURES, VALUES, word
from .value_nodes import SPECIAL


class Graph:
    """The nodes of one material, world or lamp.

    `images` turns pictures into indices (bridge/image.py), `uv_names` and `color_names` are the layers of the mesh that wears the material,
    `log(what)` hears what cannot be carried.
    """

    def __init__(self, images, log, uv_names=(), color_names=()):
        self.images = images
        self.log = log
        self.uv_names = list(uv_names)
        self.color_names = list(color_names)
        self.names_layers = False
        self.nodes = []
        self._done = {}

    def add(self, record):
        """Appends a record; its index. Equal records share."""
        key = repr(record)
        if key not in self._done:
            self.nodes.append(record)
            self._done[key] = len(self.nodes) - 1
        return self._done[key]

    def closure(self, socket, path=()):
        """Index of the closure that a shader socket shows; `None` for none."""
        node, _, path = find_source(socket, path)
        if node is None:
            return None
        key = ("closure", node.as_pointer(), tuple(n.as_pointer() for n in path))
        if key not in self._done:
            self._done[key] = None  # a loop ends here
            self._done[key] = self._closure(node, path)
        return self._done[key]

    def _closure(self, node, path):
        if node.type == "ADD_SHADER":
            a, b = (self.closure(node.inputs[k], path) for k in (0, 1))
            if a is None or b is None:
                return a if b is None else b
            return self.add({"type": "add", "a": a, "b": b})
        if node.type == "MIX_SHADER":
            factor = self.value(node.inputs[0], path)
            record = {"type": "mix", "factor": factor}
            for key, k in (("a", 1), ("b", 2)):
                side = self.closure(node.inputs[k], path)
                if side is not None:
                    record[key] = side
            return self.add(record)
        if node.type not in CLOSURES:
            self.log(f"the shader node '{node.name}' ({node.bl_label}) is left out")
            return None
        kind, inputs, choices = CLOSURES[node.type]
        record = {"type": kind}
        for key, prop in choices.items():
            if hasattr(node, prop):
                record[key] = word(getattr(node, prop))
        for key, name in inputs.items():
            socket = socket_of(node, name)
            if socket is None:
                continue
            if "normal" in key.lower() or key == "tangent":
                value = self.value(socket, path) if find_source(socket, path)[0] else None
                if is_link(value):
                    record[key] = value
            else:
                record[key] = self.value(socket, path)
        return self.add(record)

    def value(self, socket, path=()):
        """What an input socket gives: a number, three, or the output of a node."""
        node, out, path = find_source(socket, path)
        if node is None:
            return plain_value(out)
        key = ("value", node.as_pointer(), out.identifier, tuple(n.as_pointer() for n in path))
        if key not in self._done:
            self._done[key] = plain_value(socket)
            self._done[key] = self._value(node, out, path, socket)
        value = self._done[key]
        if out.type == "VECTOR" and socket.type in {"VALUE", "INT"} and is_link(value):
            # A vector becomes the mean of its parts; a colour, its luminance.
            return {"node": self.add({"type": "vectorMath", "operation": "dot_product", "a": value, "b": [1 / 3] * 3}), "output": "value"}
        return value

    def _value(self, node, out, path, socket):
        if node.type in SPECIAL:
            value = SPECIAL[node.type](self, node, out, path)
            if value is not None:
                return value
        elif node.type in VALUES:
            kind, inputs, choices, outputs = VALUES[node.type]
            if out.name in outputs or out.identifier in outputs:
                record = {"type": kind}
                for key, prop in choices.items():
                    record[key] = word(getattr(node, prop))
                for key, name in inputs.items():
                    s = socket_of(node, name)
                    if s is None or (key == "normal" and find_source(s, path)[0] is None):
                        continue
                    record[key] = self.value(s, path)
                name = outputs.get(out.name) or outputs[out.identifier]
                return {"node": self.add(record), "output": name}
        self.log(f"the shader node '{node.name}' ({node.bl_label}, output {out.name}) is left out")
        return plain_value(socket)

    def coordinates(self, node, path, default):
        """Where a texture node looks."""
        return coords.coordinates(self, socket_of(node, "Vector"), path, default)


def constant_emission(tree, owner, log):
    """Colour and strength of a lamp's own nodes, as far as they are constant; `None` where they change nothing."""
    end = output_node(tree, "OUTPUT_LIGHT")
    graph = Graph(None, lambda what: log(owner, what))
    k = graph.closure(end.inputs["Surface"]) if end else None
    if k is None or graph.nodes[k]["type"] != "emission":
        if k is not None:
            log(owner, "the lamp's nodes are left out: they are more than an Emission node")
        return None
    record = graph.nodes[k]
    color, strength = (as_constant(graph.nodes, record.get(key, 1.0)) for key in ("color", "strength"))
    if color is None or strength is None:
        log(owner, "textures of the lamp's nodes are left out")
        return None
    color = [float(c) for c in (color if hasattr(color, "__len__") else [color] * 3)]
    if color == [1.0, 1.0, 1.0] and strength == 1.0:
        return None
    return {"color": color, "strength": float(strength)}
