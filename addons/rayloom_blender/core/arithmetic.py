# SPDX-License-Identifier: GPL-3.0-or-later
"""Math, Vector Math, Map Range, Clamp and Vector Rotate nodes over arrays."""

import numpy as np

from .values import Unknown, column


def _safe_divide(a, b):
    return np.where(b != 0.0, a / np.where(b != 0.0, b, 1.0), 0.0)


def _power(a, b):
    """0 where a number below 0 is raised to a fraction."""
    with np.errstate(divide="ignore", over="ignore"):
        out = np.power(np.abs(a), b)
    whole = b == np.floor(b)
    return np.where(a < 0.0, np.where(whole, np.where(b % 2.0 == 1.0, -out, out), 0.0), out)


_MATH = {
    "add": lambda a, b, c: a + b,
    "subtract": lambda a, b, c: a - b,
    "multiply": lambda a, b, c: a * b,
    "divide": lambda a, b, c: _safe_divide(a, b),
    "multiply_add": lambda a, b, c: a * b + c,
    "power": lambda a, b, c: _power(a, b),
    "logarithm": lambda a, b, c: np.where((a > 0) & (b > 0) & (b != 1), np.log(np.maximum(a, 1e-30)) / np.log(np.maximum(b, 1e-30)), 0.0),
    "sqrt": lambda a, b, c: np.sqrt(np.maximum(a, 0.0)),
    "inverse_sqrt": lambda a, b, c: np.where(a > 0, 1.0 / np.sqrt(np.maximum(a, 1e-30)), 0.0),
    "absolute": lambda a, b, c: np.abs(a),
    "exponent": lambda a, b, c: np.exp(a),
    "minimum": lambda a, b, c: np.minimum(a, b),
    "maximum": lambda a, b, c: np.maximum(a, b),
    "less_than": lambda a, b, c: (a < b) * 1.0,
    "greater_than": lambda a, b, c: (a > b) * 1.0,
    "sign": lambda a, b, c: np.sign(a),
    "compare": lambda a, b, c: (np.abs(a - b) <= np.maximum(c, 1e-5)) * 1.0,
    "round": lambda a, b, c: np.floor(a + 0.5),
    "floor": lambda a, b, c: np.floor(a),
    "ceil": lambda a, b, c: np.ceil(a),
    "trunc": lambda a, b, c: np.trunc(a),
    "fract": lambda a, b, c: a - np.floor(a),
    "modulo": lambda a, b, c: np.where(b != 0.0, np.fmod(a, np.where(b != 0.0, b, 1.0)), 0.0),
    "floored_modulo": lambda a, b, c: np.where(b != 0.0, np.mod(a, np.where(b != 0.0, b, 1.0)), 0.0),
    "wrap": lambda a, b, c: np.where(b != c, a - (b - c) * np.floor(_safe_divide(a - c, b - c)), c),
    "snap": lambda a, b, c: np.floor(_safe_divide(a, b)) * b,
    "pingpong": lambda a, b, c: np.where(b != 0.0, np.abs(((_safe_divide(a - b, b * 2.0)) % 1.0) * b * 2.0 - b), 0.0),
    "sine": lambda a, b, c: np.sin(a),
    "cosine": lambda a, b, c: np.cos(a),
    "tangent": lambda a, b, c: np.tan(a),
    "arcsine": lambda a, b, c: np.arcsin(np.clip(a, -1, 1)),
    "arccosine": lambda a, b, c: np.arccos(np.clip(a, -1, 1)),
    "arctangent": lambda a, b, c: np.arctan(a),
    "arctan2": lambda a, b, c: np.arctan2(a, b),
    "radians": lambda a, b, c: np.radians(a),
    "degrees": lambda a, b, c: np.degrees(a),
    "sinh": lambda a, b, c: np.sinh(a),
    "cosh": lambda a, b, c: np.cosh(a),
    "tanh": lambda a, b, c: np.tanh(a),
    "smooth_min": lambda a, b, c: _smooth_min(a, b, c),
    "smooth_max": lambda a, b, c: -_smooth_min(-a, -b, c),
}


def _smooth_min(a, b, c):
    """The smaller, rounded where they are nearer than `c`."""
    h = np.where(c != 0.0, np.maximum(c - np.abs(a - b), 0.0) / np.where(c != 0.0, c, 1.0), 0.0)
    return np.minimum(a, b) - h * h * h * c / 6.0


def _math(e, node, output):
    function = _MATH.get(node["operation"])
    if function is None:
        raise Unknown(f"math {node['operation']}")
    out = function(*(e.number(node, k, 0.5) for k in "abc"))
    return np.clip(out, 0.0, 1.0) if node.get("clamp") else out


def _dot(a, b):
    return (a * b).sum(axis=-1)


def _normalized(a):
    return _safe_divide(a, column(np.linalg.norm(a, axis=-1)))


def _refract(a, b, eta):
    b = _normalized(b)
    cosine = column(_dot(a, b))
    k = 1.0 - eta * eta * (1.0 - cosine * cosine)
    return np.where(k < 0.0, 0.0, eta * a - (eta * cosine + np.sqrt(np.maximum(k, 0.0))) * b)


# Of three vectors; `scale` is the number socket.
_VECTOR_MATH = {
    "add": lambda a, b, c, s: a + b,
    "subtract": lambda a, b, c, s: a - b,
    "multiply": lambda a, b, c, s: a * b,
    "divide": lambda a, b, c, s: _safe_divide(a, b),
    "multiply_add": lambda a, b, c, s: a * b + c,
    "minimum": lambda a, b, c, s: np.minimum(a, b),
    "maximum": lambda a, b, c, s: np.maximum(a, b),
    "cross_product": lambda a, b, c, s: np.cross(a, b),
    "project": lambda a, b, c, s: b * column(_safe_divide(_dot(a, b), _dot(b, b))),
    "reflect": lambda a, b, c, s: a - 2.0 * column(_dot(a, _normalized(b))) * _normalized(b),
    "refract": lambda a, b, c, s: _refract(a, b, s),
    "faceforward": lambda a, b, c, s: np.where(column(_dot(c, b)) < 0.0, a, -a),
    "dot_product": lambda a, b, c, s: _dot(a, b),
    "distance": lambda a, b, c, s: np.linalg.norm(a - b, axis=-1),
    "length": lambda a, b, c, s: np.linalg.norm(a, axis=-1),
    "scale": lambda a, b, c, s: a * s,
    "normalize": lambda a, b, c, s: _normalized(a),
    "absolute": lambda a, b, c, s: np.abs(a),
    "power": lambda a, b, c, s: _power(a, b),
    "sign": lambda a, b, c, s: np.sign(a),
    "floor": lambda a, b, c, s: np.floor(a),
    "ceil": lambda a, b, c, s: np.ceil(a),
    "fraction": lambda a, b, c, s: a - np.floor(a),
    "modulo": lambda a, b, c, s: _MATH["modulo"](a, b, c),
    "wrap": lambda a, b, c, s: _MATH["wrap"](a, b, c),
    "snap": lambda a, b, c, s: _MATH["snap"](a, b, c),
    "sine": lambda a, b, c, s: np.sin(a),
    "cosine": lambda a, b, c, s: np.cos(a),
    "tangent": lambda a, b, c, s: np.tan(a),
}


def _vector_math(e, node, output):
    function = _VECTOR_MATH.get(node["operation"])
    if function is None:
        raise Unknown(f"vector math {node['operation']}")
    return function(*(e.color(node, k) for k in "abc"), column(e.number(node, "scale", 1.0)))


def _smoothed(t, kind):
    t = np.clip(t, 0.0, 1.0)
    return t * t * (3.0 - 2.0 * t) if kind == "smoothstep" else t * t * t * (t * (6.0 * t - 15.0) + 10.0)


def _map_range(e, node, output):
    is_vector = node.get("isVector", False)
    read = (lambda k, r: e.color(node, k, r)) if is_vector else (lambda k, r: e.number(node, k, r))
    v, a, b, c, d = (read(k, r) for k, r in (("value", 1.0), ("fromMin", 0.0), ("fromMax", 1.0), ("toMin", 0.0), ("toMax", 1.0)))
    t = _safe_divide(v - a, b - a)
    kind = node.get("interpolation", "linear")
    if kind == "stepped":
        steps = read("steps", 4.0)
        t = np.where(steps > 0.0, np.floor(t * (steps + 1.0)) / np.where(steps > 0.0, steps, 1.0), 0.0)
    elif kind != "linear":
        t = _smoothed(t, kind)
    out = c + t * (d - c)
    return np.clip(out, np.minimum(c, d), np.maximum(c, d)) if node.get("clamp", True) and kind in {"linear", "stepped"} else out


def _clamp(e, node, output):
    v, low, high = (e.number(node, k) for k in ("value", "min", "max"))
    if node.get("kind") == "range":
        low, high = np.minimum(low, high), np.maximum(low, high)
    return np.minimum(np.maximum(v, low), high)


def _turned(v, axis, angle):
    """Vectors turned about a unit axis (Rodrigues)."""
    axis = np.broadcast_to(axis, np.shape(v))
    cosine, sine = column(np.cos(angle)), column(np.sin(angle))
    return v * cosine + np.cross(axis, v) * sine + axis * column(_dot(v, axis)) * (1.0 - cosine)


def _vector_rotate(e, node, output):
    center, v = e.color(node, "center"), e.color(node, "vector")
    kind, sign = node["kind"], -1.0 if node.get("invert") else 1.0
    v = v - center
    unit = np.eye(3)
    if kind == "eulerXyz":
        turns = e.color(node, "rotation")
        for k in (0, 1, 2) if sign > 0.0 else (2, 1, 0):
            v = _turned(v, unit[k], sign * turns[..., k])
        return v + center
    axis = _normalized(e.color(node, "axis")) if kind == "axisAngle" else unit["xyz".index(kind[0])]
    if kind == "axisAngle" and not np.any(axis):
        return v + center
    return _turned(v, axis, sign * e.number(node, "angle")) + center


def _mapping(e, node, output):
    v, location, turns, scale = (e.color(node, k, r) for k, r in (("vector", 0.0), ("location", 0.0), ("rotation", 0.0), ("scale", 1.0)))
    kind, unit = node["kind"], np.eye(3)
    if kind == "texture":
        v = v - location
        for k in (2, 1, 0):
            v = _turned(v, unit[k], -turns[..., k])
        return _safe_divide(v, scale)
    v = _safe_divide(v, scale) if kind == "normal" else v * scale
    for k in (0, 1, 2):
        v = _turned(v, unit[k], turns[..., k])
    return _normalized(v) if kind == "normal" else v + location if kind == "point" else v


FUNCTIONS = {
    "clampRange": _clamp,
    "mapRange": _map_range,
    "mapping": _mapping,
    "math": _math,
    "vectorMath": _vector_math,
    "vectorRotate": _vector_rotate,
}
