# SPDX-License-Identifier: GPL-3.0-or-later
"""Texture nodes over arrays of points: what the nodes say, then the formulas of noise.py, voronoi.py and patterns.py."""

import os
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from . import hashes, noise, patterns, voronoi
from .values import Unknown, as_color, column, lerp

# Points at once: what is between fits a processor's cache.
_BLOCK = 1 << 15


def _in_blocks(function, p, *settings):
    """`function(points, settings…)` over blocks of points, on all cores; settings are numbers or arrays over the points."""

    def block(first):
        rows = slice(first, first + _BLOCK)
        return function(p[rows], *(s[rows] if np.ndim(s) else s for s in settings))

    firsts = range(0, len(p), _BLOCK)
    if len(firsts) == 1:
        return block(0)
    # numpy lets other threads run while it computes.
    with ThreadPoolExecutor(max_workers=os.cpu_count() or 1) as pool:
        return np.concatenate(list(pool.map(block, firsts)))


def _scaled(e, node, default_scale=5.0):
    """Where a texture of one to four dimensions looks, (n, d), times its scale."""
    d = node.get("dimensions", 3)
    columns = list(np.asarray(e.coordinates(node), np.float32).T[: min(d, 3)]) if d > 1 else []
    if d in {1, 4}:
        columns.append(np.atleast_1d(e.number(node, "w")))
    p = np.stack(np.broadcast_arrays(*columns), axis=-1).astype(np.float32)
    scale = np.asarray(e.number(node, "scale", default_scale), np.float32)
    return p * (scale[:, None] if scale.ndim else scale)


def _checker(e, node, output):
    p = (e.coordinates(node) * column(e.number(node, "scale", 5.0)) + 1e-6) * 0.999999
    odd = np.floor(p).astype(np.int64) & 1
    first = (odd[:, 0] == odd[:, 1]) == (odd[:, 2] == 1)
    if output == "fac":
        return first.astype(np.float32)
    return np.where(first[:, None], e.color(node, "color1"), e.color(node, "color2"))


def _noise(e, node, output):
    kind = node.get("kind", "fbm")
    if kind != "fbm" and kind not in noise.KINDS:
        raise Unknown(f"noise of kind {kind}")
    names = (("detail", 2.0), ("roughness", 0.5), ("lacunarity", 2.0), ("offset", 0.0), ("gain", 1.0), ("distortion", 0.0))
    settings = [e.number(node, k, d) for k, d in names]
    return _in_blocks(lambda p, *s: noise.texture(p, kind, *s, node.get("normalize", True), output == "color"), _scaled(e, node), *settings)


def _voronoi(e, node, output):
    feature, metric = node.get("feature", "f1"), node.get("metric", "euclidean")
    names = (("detail", 0.0), ("roughness", 0.5), ("lacunarity", 2.0), ("smoothness", 1.0), ("exponent", 0.5), ("randomness", 1.0))
    settings = [e.number(node, k, d) for k, d in names]

    def block(p, *s):
        out = voronoi.texture(p, feature, metric, *s, node.get("normalize", False), node.get("hash") == "pcg")
        return out[output if output in out else "position"]

    out = _in_blocks(block, _scaled(e, node), *settings)
    if output not in {"position", "w"}:
        return out
    scale = e.number(node, "scale", 5.0)
    out = out / np.asarray(column(np.where(scale != 0.0, scale, 1.0)), np.float32)
    if output == "w":
        return out[:, -1]
    return np.pad(out[:, :3], ((0, 0), (0, max(0, 3 - out.shape[1]))))


def _white_noise(e, node, output):
    p = _scaled(e, {**node, "scale": 1.0})
    return hashes.color_of_floats(*p.T) if output == "color" else hashes.of_floats(*p.T)


def _wave(e, node, output):
    names = (("distortion", 0.0), ("detail", 2.0), ("detailScale", 1.0), ("detailRoughness", 0.5), ("phaseOffset", 0.0))
    settings = [e.number(node, k, d) for k, d in names]
    out = _in_blocks(lambda p, *s: patterns.wave(p, node["kind"], node["direction"], node["profile"], *s), _scaled(e, node), *settings)
    return out.astype(np.float32) if output == "fac" else as_color(out)


def _magic(e, node, output):
    out = _in_blocks(lambda p, d: patterns.magic(p, node["depth"], d), _scaled(e, node), e.number(node, "distortion", 1.0))
    return out.mean(axis=-1) if output == "fac" else out.astype(np.float32)


def _brick(e, node, output):
    names = (("mortarSize", 0.02), ("mortarSmooth", 0.1), ("bias", 0.0), ("brickWidth", 0.5), ("rowHeight", 0.25))
    settings = [e.number(node, k, d) for k, d in names]
    tint, mortar = patterns.brick(_scaled(e, node), *settings, node["offset"], node["offsetFrequency"], node["squash"], node["squashFrequency"])
    if output == "fac":
        return mortar
    return lerp(lerp(e.color(node, "color1"), e.color(node, "color2"), tint), e.color(node, "mortar"), mortar)


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


def _image(e, node, output):
    if e._image is None:
        raise Unknown("image")
    pixels = e._image(node["image"])
    p = e.coordinates(node)
    look = lambda u, v: sample(pixels, u, v, node.get("extension", "repeat"), node.get("interpolation", "linear") == "closest")  # noqa: E731
    projection = node.get("projection", "flat")
    if projection == "flat":
        out = look(p[:, 0], p[:, 1])
    elif projection == "box":
        n = e._points("normal", 0)
        weights, side = box_weights(n, node.get("blend", 0.0)), n < 0.0
        x, y, z = p.T
        faces = (look(np.where(side[:, 0], 1.0 - y, y), z), look(np.where(side[:, 1], x, 1.0 - x), z), look(np.where(side[:, 2], y, 1.0 - y), x))
        out = sum(w[:, None] * f for w, f in zip(weights.T, faces))
    else:
        x, y, z = (2.0 * p - 1.0).T
        v = np.arcsin(np.clip(z / np.maximum(np.linalg.norm([x, y, z], axis=0), 1e-12), -1.0, 1.0)) / np.pi + 0.5 if projection == "sphere" else (z + 1.0) * 0.5
        out = look(0.5 - np.arctan2(x, y) / (2.0 * np.pi), v)
    return out[:, 3] if output == "alpha" else out[:, :3]


def box_weights(normals, blend):
    """How much each of three pairs of a box's sides shows at normals (n, 3): one, near edges two mixed over `blend`, at corners three."""
    n = np.abs(normals)
    n = n / np.maximum(n.sum(axis=1, keepdims=True), 1e-12)
    limit = 0.5 * (1.0 + blend)
    out = np.zeros_like(n)
    left = np.ones(len(n), bool)
    for k in range(3):
        a, b = (k + 1) % 3, (k + 2) % 3
        alone = left & (n[:, k] > limit * (n[:, k] + n[:, a])) & (n[:, k] > limit * (n[:, k] + n[:, b]))
        out[alone, k] = 1.0
        left &= ~alone
    if blend <= 0.0:
        out[left, n[left].argmax(axis=1)] = 1.0
        return out
    # The side that is farthest away last: z, x, y.
    for k in (2, 0, 1):
        a, b = (k + 1) % 3, (k + 2) % 3
        two = left & (n[:, k] < (1.0 - limit) * (n[:, a] + n[:, b]))
        share = np.clip((n[two, a] / np.maximum(n[two, a] + n[two, b], 1e-12) - 0.5 * (1.0 - blend)) / blend, 0.0, 1.0)
        out[two, a], out[two, b] = share, 1.0 - share
        left &= ~two
    out[left] = ((2.0 - limit) * n[left] + (limit - 1.0)) / (2.0 * limit - 1.0)
    return out


def _environment(e, node, output):
    if e._image is None or node.get("projection", "equirectangular") != "equirectangular":
        raise Unknown("environment")
    pixels = e._image(node["image"])
    d = e.coordinates(node)
    d = d / np.maximum(np.linalg.norm(d, axis=1, keepdims=True), 1e-12)
    u, v = 0.5 - np.arctan2(d[:, 1], d[:, 0]) / (2.0 * np.pi), np.arcsin(np.clip(d[:, 2], -1.0, 1.0)) / np.pi + 0.5
    return sample(pixels, u, v, "repeat", node.get("interpolation", "linear") == "closest")[:, :3]


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
    "brick": _brick,
    "checker": _checker,
    "environment": _environment,
    "gradient": _gradient,
    "image": _image,
    "magic": _magic,
    "noise": _noise,
    "voronoi": _voronoi,
    "wave": _wave,
    "whiteNoise": _white_noise,
}
