# SPDX-License-Identifier: GPL-3.0-or-later
"""The world: background colour, picture or sky; the fog that fills everything."""

import numpy as np

from ..core import pictures, rays
from ..core.bake import Baker
from ..core.evaluate import Evaluator
from ..core.lower import Lowering
from ..core.values import Unknown, column
from .image import linear_pixels
from .links import output_node
from .nodes import Graph


# Of baked worlds, and of those that hold pictures, in pixels: half as high. Picked by feel.
WIDTH, WIDTH_OF_PICTURES = 1024, 2048


class _Nowhere:
    """What a world's volume has to bake over: nothing."""

    def __getattr__(self, name):
        if name in {"uv_box", "body", "surface", "shape"}:
            return lambda *_: None

        def unknown(*given):
            raise Unknown(name)

        return unknown


class _Sky:
    """The light of a world's closures over all directions."""

    def __init__(self, nodes, images, log):
        self.nodes, self.images, self.log = nodes, images, log
        width = WIDTH_OF_PICTURES if any(n["type"] == "environment" for n in nodes) else WIDTH
        self.size = (width // 2, width)
        turn = (0.5 - (np.arange(width) + 0.5) / width) * 2.0 * np.pi
        rise = (0.5 - (np.arange(width // 2) + 0.5) / (width // 2)) * np.pi
        turn, rise = (a.ravel() for a in np.meshgrid(turn, rise))
        self.directions = np.stack([np.cos(rise) * np.cos(turn), np.cos(rise) * np.sin(turn), np.sin(rise)], axis=-1)
        self.evaluator = Evaluator(nodes, self._points, self._image)

    def _points(self, source, uv_set):
        if source in {"generated", "normal", "object", "position"}:
            return self.directions
        raise Unknown(f"coordinates of source {source}")

    def _image(self, ix):
        pixels = linear_pixels(self.images, ix)
        if pixels is None:
            raise Unknown("a picture without pixels")
        return pixels

    def light(self, ix):
        """Radiance of a closure: (3,) or (n, 3)."""
        if ix is None:
            return np.zeros(3)
        node = self.nodes[ix]
        if node["type"] in {"background", "emission"}:
            strength = np.maximum(self.evaluator.number(node, "strength", 1.0), 0.0)
            return self.evaluator.color(node, "color", 0.8) * column(strength)
        if node["type"] == "add":
            return self.light(node["a"]) + self.light(node["b"])
        if node["type"] == "mix":
            share = column(np.clip(self.evaluator.number(node, "factor", 0.5), 0.0, 1.0))
            return self.light(node.get("a")) * (1.0 - share) + self.light(node.get("b")) * share
        self.log(f"'{node['type']}' in a world is black")
        return np.zeros(3)


def _surface(lowering, nodes, ix, images, tell):
    """Index of a background for a world's closure as one sort of ray meets it: as it is where the renderer has it, else baked."""
    part = Lowering(nodes, lowering.baker, tell, is_world=True)
    part.out, part._done = lowering.out, lowering._done
    if part.is_background(ix):
        return part.closure(ix)
    sky = _Sky(nodes, images, tell)
    try:
        light = np.asarray(sky.light(ix), np.float32)
    except Unknown as e:
        tell(f"the world's background is left out: '{e}' is not evaluated; it is grey")
        light = np.full(3, 0.5, np.float32)
    if light.ndim == 1:
        return lowering.add({"type": "background", "color": [float(v) for v in light], "strength": 1.0})
    tell(f"the background is baked to a picture of {sky.size[1]} x {sky.size[0]}")
    image = images.add("World (baked)", pictures.exr(light.reshape(*sky.size, 3)), "image/x-exr", "linear", "none")
    shown = {"node": lowering.add({"type": "environment", "image": image, "coordinates": {"source": "position"}, "interpolation": "linear"}), "output": "color"}
    return lowering.add({"type": "background", "color": shown, "strength": 1.0})


def world_record(world, images, log):
    """The record `world`; black without one."""
    if world is None:
        return _plain([0.0, 0.0, 0.0])
    if not getattr(world, "use_nodes", True) or world.node_tree is None:
        return _plain(list(world.color))

    def tell(what):
        log(f"World '{world.name}'", what)

    graph = Graph(images, tell)
    end = output_node(world.node_tree, "OUTPUT_WORLD")
    lowering = Lowering(graph.nodes, Baker(_Nowhere()), tell, is_world=True)
    record = {}
    k = graph.closure(end.inputs["Surface"]) if end else None
    if k is not None:
        record["surface"] = _surface(lowering, rays.fixed(graph.nodes, "diffuse"), k, images, tell)
        asked = rays.outputs_asked(graph.nodes)
        if asked:
            seen = _surface(lowering, rays.fixed(graph.nodes, "camera"), k, images, tell)
            if seen != record["surface"]:
                record["cameraSurface"] = seen
            if asked - {"isCameraRay"}:
                tell("the world is as the camera and as matt surfaces see it, for other rays as for these")
    k = graph.closure(end.inputs["Volume"]) if end else None
    if k is not None:
        record["volume"] = lowering.closure(k)
    record["nodes"] = lowering.out
    cycles = getattr(world, "cycles", None)
    if cycles is not None:
        method = getattr(cycles, "sampling_method", "AUTOMATIC")
        if method == "NONE":
            record["sampling"] = "none"
        elif method == "MANUAL":
            record["sampling"] = {"resolution": cycles.sample_map_resolution}
        if getattr(cycles, "max_bounces", 1024) != 1024:
            record["maxBounces"] = cycles.max_bounces
    visibility = getattr(world, "cycles_visibility", None)
    if visibility is not None:
        keys = {"camera": "camera", "diffuse": "diffuse", "glossy": "glossy", "transmission": "transmission", "volumeScatter": "scatter"}
        hidden = {k: False for k, own in keys.items() if not getattr(visibility, own)}
        if hidden:
            record["visibility"] = hidden
    return record


def _plain(color):
    return {"nodes": [{"type": "background", "color": color, "strength": 1.0}], "surface": 0}
