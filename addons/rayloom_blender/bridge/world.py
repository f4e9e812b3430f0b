# SPDX-License-Identifier: GPL-3.0-or-later
"""The world: background colour, picture or sky; the fog that fills everything."""

from ..core.bake import Baker
from ..core.evaluate import Unknown
from ..core.lower import Lowering
from .links import output_node
from .nodes import Graph


class _Nowhere:
    """What a world has to bake over: nothing yet."""

    def uv_box(self, uv_set):
        return None

    def body(self):
        return None

    def surface(self):
        return None

    def points(self, source, p):
        raise Unknown(f"coordinates of source {source}")

    def image(self, ix):
        raise Unknown("image")


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
    for key, name in (("surface", "Surface"), ("volume", "Volume")):
        k = graph.closure(end.inputs[name]) if end else None
        if k is not None:
            record[key] = lowering.closure(k)
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
