# SPDX-License-Identifier: GPL-3.0-or-later
"""Evaluates value nodes of the file over arrays of points: folds constants, bakes what the renderer does not evaluate.

An array is (n,) for numbers and (n, 3) for colours and vectors; constants are numbers and arrays of three.
"""

import numpy as np

from . import noise
from .schema import is_link

LUMINANCE = np.array([0.2126729, 0.7151522, 0.0721750], np.float32)


class Unknown(Exception):
    """A node that has no value here: its type, or what it needs."""


def as_color(value):
    """A number becomes grey."""
    value = np.asarray(value, np.float32)
    return value if value.ndim and value.shape[-1] == 3 else np.repeat(value[..., None], 3, axis=-1)


def as_number(value):
    """A colour becomes its luminance."""
    value = np.asarray(value, np.float32)
    return value @ LUMINANCE if value.ndim and value.shape[-1] == 3 else value


def srgb_to_linear(v):
    """Decodes sRGB."""
    v = np.asarray(v, np.float32)
    return np.where(v <= 0.04045, v / 12.92, ((np.maximum(v, 0.0) + 0.055) / 1.055) ** 2.4).astype(np.float32)


class Evaluator:
    """Values of a list of nodes at points.

    `points(source, uv_set)` gives the coordinates (n, 3) of a source; `image(index)` linear RGBA pixels (height, width, 4), top row first. Either
    raises [`Unknown`] for what it does not have.
    """

    def __init__(self, nodes, points=None, image=None):
        self.nodes = nodes
        self._points = points
        self._image = image
        self._done = {}

    def value(self, given):
        """The value of an input."""
        if not is_link(given):
            return np.asarray(given, np.float32)
        key = (given["node"], given.get("output"))
        if key not in self._done:
            node = self.nodes[given["node"]]
            function = FUNCTIONS.get(node["type"])
            if function is None:
                raise Unknown(node["type"])
            self._done[key] = function(self, node, given.get("output"))
        return self._done[key]

    def number(self, node, key, default=0.0):
        """An input as numbers."""
        return as_number(self.value(node.get(key, default)))

    def color(self, node, key, default=0.0):
        """An input as colours."""
        return as_color(self.value(node.get(key, default)))

    def coordinates(self, node):
        """Where a texture looks."""
        where = node.get("coordinates", {"source": "uv"})
        if is_link(where):
            return np.atleast_2d(as_color(self.value(where)))
        if self._points is None:
            raise Unknown("coordinates")
        p = self._points(where["source"], where.get("uvSet", 0))
        if "affine" in where:
            p = affine(where["affine"], p)
        return p


def affine(rows, p):
    """A map of 12 numbers, row by row, on points (n, 3)."""
    m = np.asarray(rows, np.float64).reshape(3, 4)
    return p @ m[:, :3].T + m[:, 3]


def _column(value):
    value = np.asarray(value)
    return value[..., None] if value.ndim else value


def _lerp(a, b, t):
    return a + (b - a) * _column(t)


def _checker(e, node, output):
    p = (e.coordinates(node) * _column(e.number(node, "scale", 5.0)) + 1e-6) * 0.999999
    odd = np.floor(p).astype(np.int64) & 1
    first = (odd[:, 0] == odd[:, 1]) == (odd[:, 2] == 1)
    if output == "fac":
        return first.astype(np.float32)
    return np.where(first[:, None], e.color(node, "color1"), e.color(node, "color2"))


def _noise(e, node, output):
    if node.get("kind", "fbm") != "fbm" or node.get("dimensions", 3) not in (2, 3):
        raise Unknown(f"noise of kind {node.get('kind')} in {node.get('dimensions')} dimensions")
    p = e.coordinates(node) * _column(e.number(node, "scale", 5.0))
    if node.get("dimensions", 3) == 2:
        raise Unknown("noise in 2 dimensions")
    if np.any(e.number(node, "distortion", 0.0) != 0.0):
        raise Unknown("distorted noise")
    if output == "color":
        raise Unknown("the colour of noise")
    settings = [e.number(node, k, d) for k, d in (("detail", 2.0), ("roughness", 0.5), ("lacunarity", 2.0))]
    if any(np.ndim(s) for s in settings):
        raise Unknown("noise whose octaves vary")
    return noise.fbm(p, *settings, node.get("normalize", True))


def _gradient(e, node, output):
    p = e.coordinates(node)
    x, y = p[:, 0], p[:, 1]
    r = np.maximum(0.999999 - np.linalg.norm(p, axis=1), 0.0)
    kind = node.get("kind", "linear")
    value = {
        "linear": lambda: x,
        "quadratic": lambda: np.maximum(x, 0.0) ** 2,
        "easing": lambda: (lambda t: t * t * (3.0 - 2.0 * t))(np.clip(x, 0.0, 1.0)),
        "diagonal": lambda: (x + y) * 0.5,
        "radial": lambda: np.arctan2(y, x) / (2.0 * np.pi) + 0.5,
        "spherical": lambda: r,
        "quadraticSphere": lambda: r * r,
    }.get(kind)
    if value is None:
        raise Unknown(f"gradient {kind}")
    value = np.clip(value(), 0.0, 1.0).astype(np.float32)
    return value if output == "fac" else as_color(value)


def _ramp(e, node, output):
    stops = sorted(node["stops"], key=lambda s: s[0])
    at = np.array([s[0] for s in stops])
    colors = np.array([s[1:] for s in stops], np.float32)
    t = np.clip(e.number(node, "fac", 0.5), 0.0, 1.0)
    upper = np.searchsorted(at, t, side="right")
    a, b = np.clip(upper - 1, 0, len(at) - 1), np.clip(upper, 0, len(at) - 1)
    span = at[b] - at[a]
    f = np.where(span > 0.0, (t - at[a]) / np.where(span > 0.0, span, 1.0), 0.0)
    f = np.where(upper == 0, 0.0, f)
    kind = node.get("interpolation", "linear")
    if kind == "constant":
        f = np.zeros_like(f)
    elif kind == "ease":
        f = f * f * (3.0 - 2.0 * f)
    out = _lerp(colors[a], colors[b], f).astype(np.float32)
    return out[..., 3] if output == "alpha" else out[..., :3]


def _map_range(e, node, output):
    v, a, b, c, d = (e.number(node, k, r) for k, r in (("value", 1.0), ("fromMin", 0), ("fromMax", 1), ("toMin", 0), ("toMax", 1)))
    width = b - a
    t = np.where(width != 0.0, (v - a) / np.where(width != 0.0, width, 1.0), 0.0)
    out = c + t * (d - c)
    return np.clip(out, np.minimum(c, d), np.maximum(c, d)) if node.get("clamp", True) else out


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
}


def _math(e, node, output):
    function = _MATH.get(node["operation"])
    if function is None:
        raise Unknown(f"math {node['operation']}")
    out = function(*(e.number(node, k, 0.5) for k in "abc"))
    return np.clip(out, 0.0, 1.0) if node.get("clamp") else out


def _dot(a, b):
    return (a * b).sum(axis=-1)


_VECTOR_MATH = {
    "add": lambda a, b: a + b,
    "subtract": lambda a, b: a - b,
    "multiply": lambda a, b: a * b,
    "divide": _safe_divide,
    "minimum": np.minimum,
    "maximum": np.maximum,
    "cross_product": np.cross,
    "dot_product": _dot,
    "distance": lambda a, b: np.linalg.norm(a - b, axis=-1),
    "length": lambda a, b: np.linalg.norm(a, axis=-1),
    "normalize": lambda a, b: _safe_divide(a, _column(np.linalg.norm(a, axis=-1))),
    "absolute": lambda a, b: np.abs(a),
    "floor": lambda a, b: np.floor(a),
    "ceil": lambda a, b: np.ceil(a),
    "fraction": lambda a, b: a - np.floor(a),
    "modulo": lambda a, b: np.where(b != 0.0, np.fmod(a, np.where(b != 0.0, b, 1.0)), 0.0),
    "sine": lambda a, b: np.sin(a),
    "cosine": lambda a, b: np.cos(a),
    "tangent": lambda a, b: np.tan(a),
}


def _vector_math(e, node, output):
    a, b = e.color(node, "a"), e.color(node, "b")
    if node["operation"] == "scale":
        return a * _column(e.number(node, "scale", 1.0))
    function = _VECTOR_MATH.get(node["operation"])
    if function is None:
        raise Unknown(f"vector math {node['operation']}")
    return function(a, b)


def _to_hsv(c):
    c = np.asarray(c, np.float32)
    high, low = c.max(axis=-1), c.min(axis=-1)
    d = high - low
    safe = np.where(d > 0, d, 1.0)
    r, g, b = c[..., 0], c[..., 1], c[..., 2]
    hue = np.where(high == r, (g - b) / safe, np.where(high == g, 2.0 + (b - r) / safe, 4.0 + (r - g) / safe)) / 6.0
    hue = np.where(d > 0, hue % 1.0, 0.0)
    return np.stack([hue, np.where(high > 0, d / np.where(high > 0, high, 1.0), 0.0), high], axis=-1)


def _from_hsv(hsv):
    h, s, v = hsv[..., 0] * 6.0, hsv[..., 1], hsv[..., 2]
    ramp = np.stack([np.abs(h - 3.0) - 1.0, 2.0 - np.abs(h - 2.0), 2.0 - np.abs(h - 4.0)], axis=-1)
    return v[..., None] * (1.0 + s[..., None] * (np.clip(ramp, 0.0, 1.0) - 1.0))


def _overlay(a, b, t):
    return np.where(a < 0.5, a * (1 - t + 2 * t * b), 1 - (1 - t + 2 * t * (1 - b)) * (1 - a))


_BLEND = {
    "mix": lambda a, b, t: a + (b - a) * t,
    "add": lambda a, b, t: a + b * t,
    "subtract": lambda a, b, t: a - b * t,
    "multiply": lambda a, b, t: a * (1 - t + b * t),
    "screen": lambda a, b, t: 1 - (1 - t + t * (1 - b)) * (1 - a),
    "divide": lambda a, b, t: np.where(b != 0, (1 - t) * a + t * _safe_divide(a, b), a),
    "difference": lambda a, b, t: a + (np.abs(a - b) - a) * t,
    "exclusion": lambda a, b, t: np.maximum(a + (a + b - 2 * a * b - a) * t, 0.0),
    "darken": lambda a, b, t: a + (np.minimum(a, b) - a) * t,
    "lighten": lambda a, b, t: a + (np.maximum(a, b) - a) * t,
    "overlay": _overlay,
    "linear_light": lambda a, b, t: a + t * (2.0 * b - 1.0),
    "soft_light": lambda a, b, t: (1 - t) * a + t * ((1 - a) * b * a + a * (1 - (1 - b) * (1 - a))),
}


def _mix_color(e, node, output):
    function = _BLEND.get(node.get("blend", "mix"))
    if function is None:
        raise Unknown(f"mix {node['blend']}")
    t = e.number(node, "factor", 0.5)
    if node.get("clampFactor", True):
        t = np.clip(t, 0.0, 1.0)
    a, b = e.value(node.get("a", 0.5)), e.value(node.get("b", 0.5))
    if a.ndim and a.shape[-1] == 3 or b.ndim and b.shape[-1] == 3:
        a, b, t = as_color(a), as_color(b), _column(t)
    out = function(a, b, t)
    return np.clip(out, 0.0, 1.0) if node.get("clampResult") else out


def _separate(e, node, output):
    color = e.color(node, "color")
    mode = node.get("mode", "rgb")
    if mode == "hsv":
        color = _to_hsv(color)
    elif mode not in {"rgb", "xyz"}:
        raise Unknown(f"separate {mode}")
    return color[..., "xyz".index(output)]


def _combine(e, node, output):
    parts = np.broadcast_arrays(*(e.number(node, k) for k in "xyz"))
    color = np.stack(parts, axis=-1)
    mode = node.get("mode", "rgb")
    if mode == "hsv":
        return _from_hsv(color)
    if mode != "rgb":
        raise Unknown(f"combine {mode}")
    return color


def _hue_saturation(e, node, output):
    color, t = e.color(node, "color"), e.number(node, "fac", 1.0)
    hsv = _to_hsv(color)
    hue = (hsv[..., 0] + e.number(node, "hue", 0.5) + 0.5) % 1.0
    saturation = np.clip(hsv[..., 1] * e.number(node, "saturation", 1.0), 0.0, 1.0)
    out = _from_hsv(np.stack([hue, saturation, hsv[..., 2] * e.number(node, "value", 1.0)], axis=-1))
    return np.maximum(_lerp(color, out, t), 0.0)


def _invert(e, node, output):
    return _lerp(e.color(node, "color"), 1.0 - e.color(node, "color"), e.number(node, "fac", 1.0))


def _gamma(e, node, output):
    color = e.color(node, "color")
    return np.where(color > 0.0, np.power(np.maximum(color, 1e-30), _column(e.number(node, "gamma", 1.0))), color)


def _bright_contrast(e, node, output):
    bright, contrast = _column(e.number(node, "bright")), _column(e.number(node, "contrast"))
    return np.maximum((1.0 + contrast) * e.color(node, "color") + bright - contrast * 0.5, 0.0)


def _image(e, node, output):
    if e._image is None or node.get("projection", "flat") != "flat":
        raise Unknown("image")
    pixels = e._image(node["image"])
    p = e.coordinates(node)
    out = sample(pixels, p[:, 0], p[:, 1], node.get("extension", "repeat"), node.get("interpolation", "linear") == "closest")
    return out[:, 3] if output == "alpha" else out[:, :3]


def sample(pixels, u, v, extension, closest):
    """Texels at (u, v), v up, mixed from the nearest four or taken from the nearest."""
    height, width = pixels.shape[:2]
    x, y = u * width - 0.5, (1.0 - v) * height - 0.5

    def wrapped(k, n):
        if extension == "repeat":
            return k % n
        if extension == "mirror":
            k = k % (2 * n)
            return np.where(k < n, k, 2 * n - 1 - k)
        return np.clip(k, 0, n - 1)

    def texel(i, j):
        out = pixels[wrapped(j, height), wrapped(i, width)]
        if extension == "clip":
            out = np.where(((i >= 0) & (i < width) & (j >= 0) & (j < height))[:, None], out, 0.0)
        return out

    if closest:
        return texel(np.floor(x + 0.5).astype(np.int64), np.floor(y + 0.5).astype(np.int64))
    i, j = np.floor(x).astype(np.int64), np.floor(y).astype(np.int64)
    s, t = (x - i)[:, None].astype(np.float32), (y - j)[:, None].astype(np.float32)
    return (texel(i, j) * (1 - s) + texel(i + 1, j) * s) * (1 - t) + (texel(i, j + 1) * (1 - s) + texel(i + 1, j + 1) * s) * t


FUNCTIONS = {
    "affineMap": lambda e, n, o: affine(n["affine"], e.color(n, "vector")),
    "brightContrast": _bright_contrast,
    "checker": _checker,
    "clampRange": lambda e, n, o: np.minimum(np.maximum(e.number(n, "value"), e.number(n, "min")), e.number(n, "max")),
    "colorRamp": _ramp,
    "combine": _combine,
    "gamma": _gamma,
    "gradient": _gradient,
    "hueSaturation": _hue_saturation,
    "image": _image,
    "invert": _invert,
    "mapRange": _map_range,
    "math": _math,
    "mixColor": _mix_color,
    "noise": _noise,
    "rgbToBw": lambda e, n, o: e.number(n, "color"),
    "separate": _separate,
    "vector": lambda e, n, o: e.coordinates(n),
    "vectorMath": _vector_math,
}
