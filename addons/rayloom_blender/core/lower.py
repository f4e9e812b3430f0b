# SPDX-License-Identifier: GPL-3.0-or-later
"""Shader nodes → those that the renderer evaluates: constants are folded, the rest is baked or told.

What the renderer takes (docs/RAYLOOM_scene.md): pictures over UV, colour attributes, a channel of a picture through a line (factor and offset), a colour
times a constant, normal and bump maps, density grids; in worlds one environment picture or sky.
"""

from . import rays
from .evaluate import Evaluator
from .schema import CLOSURE_INPUTS, inputs_of, is_link
from .values import Unknown

_VOLUMES = {"principledVolume", "volumeAbsorption", "volumeScatter"}


def as_constant(nodes, value):
    """The value of an input that is the same everywhere: a number or a list of three; else `None`."""
    if not is_link(value):
        return value
    try:
        out = Evaluator(nodes).value(value)
    except Unknown:
        return None
    return float(out) if out.ndim == 0 else [float(v) for v in out]


def reachable(nodes, value):
    """Indices of all nodes that an input depends on."""
    found, waiting = set(), [value]
    while waiting:
        v = waiting.pop()
        if is_link(v) and v["node"] not in found:
            found.add(v["node"])
            waiting.extend(i for _, i in inputs_of(nodes[v["node"]]))
    return found


def wants_color(key):
    """Whether an input of a closure wants a colour; all others but normals want a number."""
    return key in {"subsurfaceRadius", "radius", "absorption", "edgeTint"} or "color" in key.lower() or key.endswith("Tint") or key == "tint"


class Lowering:
    """Makes a new list of nodes. `baker` bakes (core/bake.py), `log(what)` hears what was approximated."""

    def __init__(self, nodes, baker, log, is_world=False):
        self.nodes = nodes
        self.baker = baker
        self.log = log
        self.is_world = is_world
        self.out = []
        self._done = {}

    def add(self, record):
        """Index of a record; equal ones share."""
        return self._add(record)

    def _add(self, record):
        key = repr(record)
        if key not in self._done:
            self.out.append(record)
            self._done[key] = len(self.out) - 1
        return self._done[key]

    def surface(self, ix):
        """The new index of a material's closure, for all sorts of rays."""
        asked = rays.outputs_asked(self.nodes)
        if not asked:
            return self.closure(ix)
        if asked - rays.EXACT:
            self.log("lengths and depths of light paths are taken as those of the first bounce")

        def lowered(nodes):
            part = Lowering(nodes, self.baker, self.log, self.is_world)
            part.out, part._done = self.out, self._done
            return part.closure(ix)

        return rays.by_ray(self.nodes, lowered, self._add)

    def closure(self, ix):
        """The new index of a closure."""
        node = self.nodes[ix]
        record = {"type": node["type"]}
        for key, value in node.items():
            if key == "type":
                continue
            if key in CLOSURE_INPUTS.get(node["type"], ()):
                record[key] = self.closure(value)
            elif is_link(value):
                lowered = self._input(value, key, node["type"])
                if lowered is not None:
                    record[key] = lowered
            else:
                record[key] = value
        return self._add(record)

    def _input(self, value, key, closure_type):
        constant = as_constant(self.nodes, value)
        if constant is not None:
            return constant
        if "normal" in key.lower() or key == "tangent":
            return self._normal(value)
        if closure_type in _VOLUMES:
            return self._volume(value, key)
        if self.is_world and self._is_sky(value):
            return self._copy(value)
        if key == "factor" and self._is_angle(value):
            return self._copy(value)
        is_color = wants_color(key)
        if self._is_color(value) if is_color else self._is_number(value):
            return self._copy(value)
        return self.baker.bake_surface(self.nodes, value, self.log, self._add, is_color)

    def _is_angle(self, value):
        """What the renderer mixes closures by: Fresnel, facing, the back of faces."""
        node = self.nodes[value["node"]]
        output = value.get("output")
        known = node["type"] == "fresnel" or (node["type"], output) in {("layerWeight", "facing"), ("geometry", "backfacing")}
        return known and "normal" not in node and self._constants(node, [k for k in ("ior", "blend") if k in node])

    def _copy(self, value):
        """A node and what it depends on, constants folded."""
        if not is_link(value):
            return value
        constant = as_constant(self.nodes, value)
        if constant is not None:
            return constant
        record = dict(self.nodes[value["node"]])
        for key, inner in inputs_of(self.nodes[value["node"]]):
            if is_link(inner):
                record[key] = self._copy(inner)
        return {**value, "node": self._add(record)}

    def _constants(self, node, keys):
        return all(as_constant(self.nodes, node.get(k, 0.0)) is not None for k in keys)

    def _is_sky(self, value):
        node = self.nodes[value["node"]]
        return node["type"] in {"environment", "sky"} and not is_link(node.get("coordinates"))

    def is_background(self, ix):
        """Whether the renderer has a world's closure as it is: one colour, picture or sky."""
        node = self.nodes[ix]
        if node["type"] not in {"background", "emission"} or as_constant(self.nodes, node.get("strength", 1.0)) is None:
            return False
        color = node.get("color", 0.8)
        return as_constant(self.nodes, color) is not None or self._is_sky(color)

    def _is_picture(self, value):
        if not is_link(value):
            return False
        node = self.nodes[value["node"]]
        where = node.get("coordinates", {"source": "uv"})
        return node["type"] == "image" and where.get("source") == "uv" and node.get("projection", "flat") == "flat"

    def _is_color(self, value):
        """A picture or an attribute, times a constant."""
        if self._is_picture(value):
            return True
        if not is_link(value):
            return False
        node = self.nodes[value["node"]]
        if node["type"] == "attribute":
            return value.get("output", "color") == "color"
        if node["type"] != "mixColor" or node.get("blend") != "multiply" or node.get("clampResult"):
            return False
        if as_constant(self.nodes, node.get("factor", 1.0)) != 1.0:
            return False
        for one, other in (("a", "b"), ("b", "a")):
            if as_constant(self.nodes, node[one]) is not None:
                return self._is_color(node[other])
        return False

    def _is_number(self, value):
        """A channel of a picture through lines."""
        if self._is_picture(value):
            return True
        if not is_link(value):
            return False
        node = self.nodes[value["node"]]
        if node["type"] == "separate":
            return node.get("mode", "rgb") in {"rgb", "xyz"} and self._is_picture(node["color"])
        if node["type"] != "math" or node.get("clamp"):
            return False
        terms = {"add": "ab", "subtract": "ab", "multiply": "ab", "multiply_add": "abc", "divide": "ab"}.get(node["operation"])
        if terms is None:
            return False
        varying = [k for k in terms if as_constant(self.nodes, node[k]) is None]
        if len(varying) != 1 or (node["operation"] == "divide" and varying != ["a"]):
            return False
        return self._is_number(node[varying[0]])

    def _normal(self, value):
        node = self.nodes[value["node"]]
        if node["type"] == "normalMap":
            if self._is_picture(node["color"]) and self._constants(node, ["strength"]) and node.get("space", "tangent") == "tangent":
                return self._copy(value)
            self.log("a normal map that is more than a picture in tangent space is left out")
            return None
        if node["type"] == "bump":
            below = self._normal(node["normal"]) if "normal" in node else None
            if as_constant(self.nodes, node["height"]) is not None:
                return below
            record = {k: v for k, v in node.items() if k != "normal"}
            for key in ("strength", "distance"):
                constant = as_constant(self.nodes, node[key])
                record[key] = 1.0 if constant is None else constant
            height = node["height"]
            lowered = self._copy(height) if self._is_number(height) else self.baker.bake_surface(self.nodes, height, self.log, self._add, False)
            if not is_link(lowered):
                return below
            record["height"] = lowered
            if below is not None:
                record["normal"] = below
            return {"node": self._add(record)}
        self.log(f"a normal made by '{node['type']}' is left out")
        return None

    def _volume(self, value, key):
        if key != "density":
            self.log(f"the {key} of a volume varies; its mean is taken")
        return self.baker.bake_volume(self.nodes, value, key == "density", self.log, self._add)
