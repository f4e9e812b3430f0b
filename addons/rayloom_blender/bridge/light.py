# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamps of all four kinds, and their fallback in KHR_lights_punctual."""

import math

from .nodes import constant_emission

_SHAPE = {"SQUARE": "square", "RECTANGLE": "rectangle", "DISK": "disk", "ELLIPSE": "ellipse"}


def _color(light):
    color = list(light.color)
    if getattr(light, "use_temperature", False):
        color = [c * t for c, t in zip(color, light.temperature_color)]
    return color


def light_record(light, log):
    """The extension's record of a lamp."""
    cycles = getattr(light, "cycles", None)
    record = {
        "type": light.type.lower(),
        "name": light.name,
        "color": _color(light),
        "energy": light.energy * 2.0 ** getattr(light, "exposure", 0.0),
    }
    if not getattr(light, "normalize", True):
        record["normalize"] = False
    if getattr(light, "use_temperature", False):
        record["temperature"] = light.temperature
    if light.type in {"POINT", "SPOT"}:
        record["radius"] = light.shadow_soft_size
        record["softFalloff"] = bool(getattr(light, "use_soft_falloff", True))
    if light.type == "SPOT":
        record["spotSize"] = light.spot_size
        record["spotBlend"] = light.spot_blend
    elif light.type == "SUN":
        record["angle"] = light.angle
    elif light.type == "AREA":
        record["shape"] = _SHAPE[light.shape]
        record["size"] = light.size
        if light.shape in {"RECTANGLE", "ELLIPSE"}:
            record["sizeY"] = light.size_y
        record["spread"] = light.spread
        if getattr(cycles, "is_portal", False):
            record["portal"] = True
    if cycles:
        if not getattr(cycles, "use_multiple_importance_sampling", True):
            record["importance"] = False
        if getattr(cycles, "max_bounces", 1024) != 1024:
            record["maxBounces"] = cycles.max_bounces
    if not light.use_shadow:
        record["castShadow"] = False
    if light.use_nodes and light.node_tree:
        emission = constant_emission(light.node_tree, light.name, log)
        if emission:
            record["emission"] = emission
    return record


def punctual_record(record):
    """The same lamp as KHR_lights_punctual has it, in physical units (683 lm/W); `None` for area lamps."""
    kind = record["type"]
    energy = record["energy"]
    color = list(record["color"])
    peak = max(color)
    if peak > 1.0:
        color, energy = [c / peak for c in color], energy * peak
    if kind == "sun":
        return {"type": "directional", "name": record["name"], "color": color, "intensity": energy * 683.0}
    if kind == "area":
        return None
    out = {"type": kind, "name": record["name"], "color": color, "intensity": energy * 683.0 / (4.0 * math.pi)}
    if kind == "spot":
        outer = min(record["spotSize"] / 2.0, math.pi / 2.0)
        out["spot"] = {"innerConeAngle": outer * (1.0 - record["spotBlend"]) * 0.999, "outerConeAngle": outer}
    return out
