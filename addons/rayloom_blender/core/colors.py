# SPDX-License-Identifier: GPL-3.0-or-later
"""Ramps, curves, mixes and the other colour nodes over arrays."""

import numpy as np

from .values import Unknown, as_color, column, lerp


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
    out = lerp(colors[a], colors[b], f).astype(np.float32)
    return out[..., 3] if output == "alpha" else out[..., :3]


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


def _dodge(a, b, t):
    rest = 1.0 - t * b
    return np.where(a != 0.0, np.where(rest > 0.0, np.minimum(a / np.where(rest > 0.0, rest, 1.0), 1.0), 1.0), 0.0)


def _burn(a, b, t):
    rest = 1.0 - t + t * b
    return np.where(rest > 0.0, np.clip(1.0 - (1.0 - a) / np.where(rest > 0.0, rest, 1.0), 0.0, 1.0), 0.0)


def _parts_of(names):
    """Takes hue, saturation or value (`hsv`) of the second colour: as a whole, where it has a hue, or mixed."""

    def blend(a, b, t):
        one, two = _to_hsv(a), _to_hsv(b)
        share = t[..., 0] if np.ndim(t) else t
        mixed = one.copy()
        for name in names:
            k = "hsv".index(name)
            mixed[..., k] = two[..., k] if "h" in names else one[..., k] + (two[..., k] - one[..., k]) * share
        out = _from_hsv(mixed)
        if "h" in names:
            return np.where(two[..., 1:2] != 0.0, a + (out - a) * t, a)
        return np.where(one[..., 1:2] != 0.0, out, a) if names == "s" else out

    return blend


_BLEND = {
    "dodge": _dodge,
    "burn": _burn,
    "hue": _parts_of("h"),
    "saturation": _parts_of("s"),
    "value": _parts_of("v"),
    "color": _parts_of("hs"),
    "mix": lambda a, b, t: a + (b - a) * t,
    "add": lambda a, b, t: a + b * t,
    "subtract": lambda a, b, t: a - b * t,
    "multiply": lambda a, b, t: a * (1 - t + b * t),
    "screen": lambda a, b, t: 1 - (1 - t + t * (1 - b)) * (1 - a),
    "divide": lambda a, b, t: np.where(b != 0, (1 - t) * a + t * a / np.where(b != 0, b, 1.0), a),
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
    kind = node.get("kind", "color")
    t = e.color(node, "factor", 0.5) if kind == "parts" else e.number(node, "factor", 0.5)
    if node.get("clampFactor", True):
        t = np.clip(t, 0.0, 1.0)
    if kind == "number":
        return function(e.number(node, "a", 0.5), e.number(node, "b", 0.5), t)
    a, b, t = e.color(node, "a", 0.5), e.color(node, "b", 0.5), t if kind == "parts" else column(t)
    out = function(a, b, t)
    return np.clip(out, 0.0, 1.0) if node.get("clampResult") else out


def _to_hsl(c):
    hsv = _to_hsv(c)
    lightness = hsv[..., 2] * (1.0 - 0.5 * hsv[..., 1])
    least = np.minimum(lightness, 1.0 - lightness)
    saturation = np.where(least > 0.0, (hsv[..., 2] - lightness) / np.where(least > 0.0, least, 1.0), 0.0)
    return np.stack([hsv[..., 0], saturation, lightness], axis=-1)


def _from_hsl(hsl):
    h, s, lightness = hsl[..., 0], hsl[..., 1], hsl[..., 2]
    value = lightness + s * np.minimum(lightness, 1.0 - lightness)
    saturation = np.where(value > 0.0, 2.0 * (1.0 - lightness / np.where(value > 0.0, value, 1.0)), 0.0)
    return _from_hsv(np.stack([h, saturation, value], axis=-1))


_TO = {"rgb": lambda c: c, "xyz": lambda c: c, "hsv": _to_hsv, "hsl": _to_hsl}
_FROM = {"rgb": lambda c: c, "hsv": _from_hsv, "hsl": _from_hsl}


def _separate(e, node, output):
    return _TO[node.get("mode", "rgb")](e.color(node, "color"))[..., "xyz".index(output)]


def _combine(e, node, output):
    return _FROM[node.get("mode", "rgb")](np.stack(np.broadcast_arrays(*(e.number(node, k) for k in "xyz")), axis=-1))


def _hue_saturation(e, node, output):
    color, t = e.color(node, "color"), e.number(node, "fac", 1.0)
    hsv = _to_hsv(color)
    hue = (hsv[..., 0] + e.number(node, "hue", 0.5) + 0.5) % 1.0
    saturation = np.clip(hsv[..., 1] * e.number(node, "saturation", 1.0), 0.0, 1.0)
    out = _from_hsv(np.stack([hue, saturation, hsv[..., 2] * e.number(node, "value", 1.0)], axis=-1))
    return np.maximum(lerp(color, out, t), 0.0)


def _invert(e, node, output):
    return lerp(e.color(node, "color"), 1.0 - e.color(node, "color"), e.number(node, "fac", 1.0))


def _gamma(e, node, output):
    color = e.color(node, "color")
    return np.where(color > 0.0, np.power(np.maximum(color, 1e-30), column(e.number(node, "gamma", 1.0))), color)


def _bright_contrast(e, node, output):
    bright, contrast = column(e.number(node, "bright")), column(e.number(node, "contrast"))
    return np.maximum((1.0 + contrast) * e.color(node, "color") + bright - contrast * 0.5, 0.0)


def _curves(e, node, output):
    """Tables over a range, one for all three parts or one for each; beyond the range their ends, or lines on."""
    low, high = node["range"]
    tables = [np.asarray(t, np.float32) for t in node["table"]]
    value = e.number(node, "value") if node.get("isNumber") else e.color(node, "value")
    n = len(tables[0]) - 1
    t = (value - low) / (high - low) * n

    def read(table, t):
        k = np.clip(np.floor(t), 0, n - 1).astype(int)
        share = t - k if node.get("extrapolate") else np.clip(t - k, 0.0, 1.0)
        return table[k] + (table[k + 1] - table[k]) * share

    if node.get("isNumber"):
        return value + (read(tables[0], t) - value) * e.number(node, "fac", 1.0)
    out = np.stack([read(tables[k % len(tables)], t[..., k]) for k in range(3)], axis=-1)
    return lerp(value, out, e.number(node, "fac", 1.0))


# Temperature in kelvin and the light of a black body of luminance 1, linear. measured: Blender's Blackbody node, 4.5.
_BLACK_BODY = np.array([
    (800, 5.4138, 0.0000, 0.0000),
    (850, 5.1923, 0.0000, 0.0000),
    (900, 4.9839, 0.0000, 0.0000),
    (1000, 4.6013, 0.0390, 0.0000),
    (1100, 4.2638, 0.1394, 0.0000),
    (1200, 3.9655, 0.2279, 0.0000),
    (1400, 3.4704, 0.3738, 0.0000),
    (1600, 3.0809, 0.4873, 0.0000),
    (1800, 2.7711, 0.5761, 0.0000),
    (2000, 2.5201, 0.6469, 0.0204),
    (2300, 2.2242, 0.7278, 0.0893),
    (2600, 1.9987, 0.7872, 0.1654),
    (3000, 1.7708, 0.8443, 0.2722),
    (3500, 1.5638, 0.8925, 0.4056),
    (4000, 1.4141, 0.9236, 0.5337),
    (5000, 1.2131, 0.9608, 0.7622),
    (6000, 1.0887, 0.9783, 0.9531),
    (7000, 1.0056, 0.9873, 1.1090),
    (8000, 0.9473, 0.9916, 1.2371),
    (9000, 0.9041, 0.9940, 1.3430),
    (10000, 0.8714, 0.9949, 1.4305),
    (12000, 0.8263, 0.9945, 1.5663),
])


def _blackbody(e, node, output):
    # Nearly straight over one by the temperature.
    t = 1.0 / np.clip(np.maximum(e.number(node, "temperature", 1500.0), 1.0), _BLACK_BODY[0, 0], _BLACK_BODY[-1, 0])
    at = 1.0 / _BLACK_BODY[::-1, 0]
    return np.stack([np.interp(t, at, _BLACK_BODY[::-1, k]) for k in (1, 2, 3)], axis=-1)


FUNCTIONS = {
    "blackbody": _blackbody,
    "brightContrast": _bright_contrast,
    "colorRamp": _ramp,
    "combine": _combine,
    "curves": _curves,
    "gamma": _gamma,
    "hueSaturation": _hue_saturation,
    "invert": _invert,
    "mixColor": _mix_color,
    "rgbToBw": lambda e, n, o: e.number(n, "color"),
    "separate": _separate,
}
