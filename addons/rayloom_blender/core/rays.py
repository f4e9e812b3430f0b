# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's Light Path node: a shader that asks for the kind of ray is made anew for each kind, and mixed where the results differ."""

from .schema import RAYS, inputs_of, is_link

_THROUGH = {"transmission", "sharpTransmission"}
_MIRRORED = {"glossy", "sharpGlossy"}
# For which rays an output is 1. Source: measured, Cycles 4.5: what comes through glass is glossy too.
_ONE = {
    "isCameraRay": {"camera"},
    "isShadowRay": {"shadow"},
    "isDiffuseRay": {"diffuse"},
    "isGlossyRay": _MIRRORED | _THROUGH,
    "isSingularRay": {"sharpGlossy", "sharpTransmission"},
    "isReflectionRay": {"diffuse"} | _MIRRORED,
    "isTransmissionRay": _THROUGH,
    "isVolumeScatterRay": {"volumeScatter"},
    # Of the first bounce.
    "rayDepth": set(RAYS) - {"camera"},
}
EXACT = set(_ONE) - {"rayDepth"}


def value(node, output):
    """What a Light Path node gives to the ray that it was fixed for."""
    return 1.0 if node["ray"] in _ONE.get(output, ()) else 0.0


def outputs_asked(nodes):
    """Outputs of Light Path nodes that other nodes use."""
    links = [v for n in nodes for _, v in inputs_of(n) if is_link(v)]
    return {v.get("output") for v in links if nodes[v["node"]]["type"] == "lightPath"}


def fixed(nodes, ray):
    """The nodes as one sort of ray meets them."""
    return [{"type": "fixedPath", "ray": ray} if n["type"] == "lightPath" else n for n in nodes]


def by_ray(nodes, lowered, add, rays=RAYS):
    """Index of a closure that is `lowered(nodes)` for every sort of ray."""
    roots = {}
    for ray in rays:
        roots.setdefault(lowered(fixed(nodes, ray)), []).append(ray)
    first, *others = sorted(roots, key=lambda k: -len(roots[k]))
    for k in others:
        factor = {"node": add({"type": "lightPath", **dict.fromkeys(roots[k], 1.0)})}
        first = add({"type": "mix", "factor": factor, "a": first, "b": k})
    return first
