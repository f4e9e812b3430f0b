# SPDX-License-Identifier: GPL-3.0-or-later
"""Cellular noise as Blender's Voronoi Texture has it, over arrays of points (n, d) with d from 1 to 4. Checked against Blender's own in tests/blender.

Source: Worley, "A Cellular Texture Basis Function" (1996); Quilez, "Voronoi edges" and "Smooth voronoi" (articles, 2012 and 2014).
"""

import numpy as np

from . import hashes


# Cells away that are looked at.
MOST_REACH = 2


def _feature_points(cell, is_pcg):
    """Where in its cell the point stands, 0..1 along each axis: (n, d). `is_pcg`: by the hash of Blender 5.0 and newer."""
    if is_pcg and len(cell) > 1:
        return np.stack(hashes.pcg(list(cell)), axis=-1)
    k = [c.astype(np.float32) for c in cell]
    if len(k) == 4:
        orders = [tuple(k), (k[3], *k[:3]), (*k[2:], *k[:2]), (*k[1:], k[0])]
    else:
        orders = [tuple(k), *((*k, float(n)) for n in range(1, len(k)))]
    return np.stack([hashes.of_floats(*o) for o in orders], axis=-1)


def _colors(cell, is_pcg):
    if is_pcg and len(cell) > 1:
        # Two dimensions are three of which the last is 0 (measured, 5.0).
        return np.stack(hashes.pcg([*cell, np.zeros_like(cell[0])] if len(cell) == 2 else list(cell))[:3], axis=-1)
    return hashes.color_of_floats(*(c.astype(np.float32) for c in cell))


def _distance(v, metric, exponent):
    """Length of vectors (n, d)."""
    if metric == "manhattan":
        return np.abs(v).sum(axis=-1)
    if metric == "chebychev":
        return np.abs(v).max(axis=-1)
    if metric == "minkowski" and v.shape[-1] > 1:
        e = np.asarray(exponent, np.float32)
        inner = np.abs(v) ** (e if e.ndim == 0 else e[:, None])
        return inner.sum(axis=-1) ** (1.0 / e)
    return np.sqrt((v * v).sum(axis=-1)) if v.shape[-1] > 1 else np.abs(v[:, 0])


class _Cells:
    """The cells around points: the way to each cell, the cell itself, the way to its feature point."""

    def __init__(self, p, randomness, is_pcg):
        self.is_pcg = is_pcg
        self.p = np.asarray(p, np.float32)
        self.cell = np.floor(self.p)
        self.local = self.p - self.cell
        self.randomness = np.reshape(np.asarray(randomness, np.float32), (-1, 1))
        self._tables = {}
        self._box()

    def _box(self):
        """Where the points share cells, all cells of their box are hashed once, then looked up."""
        d = self.p.shape[1]
        low, high = self.cell.min(axis=0) - MOST_REACH, self.cell.max(axis=0) + MOST_REACH
        self.index = None
        with np.errstate(over="ignore"):
            n_cells = float(np.prod((high - low + 1.0).astype(np.float64)))
        if not np.isfinite(n_cells) or n_cells > 2 * len(self.p):
            return
        shape = (high - low + 1.0).astype(np.int64)
        self.strides = np.array([int(np.prod(shape[k + 1 :])) for k in range(d)])
        self.index = ((self.cell - low).astype(np.int64) * self.strides).sum(axis=1)
        self.all = np.stack([a.ravel() for a in np.indices(tuple(shape))], axis=0).astype(np.float32) + low[:, None]

    def _looked_up(self, name, function, where, step):
        if self.index is None:
            return function(where.T, self.is_pcg)
        if name not in self._tables:
            self._tables[name] = function(self.all, self.is_pcg)
        return self._tables[name][self.index + int((step * self.strides).sum())]

    def color(self, where, step):
        """Colours of the cells that are `step` away."""
        return self._looked_up("color", _colors, where, step)

    def around(self, reach):
        """`(step, cell, way to its feature point)` of all cells up to `reach` away."""
        d = self.p.shape[1]
        # The order counts where two are equally near: the first axis runs fastest.
        for offset in np.ndindex(*(2 * reach + 1,) * d):
            step = np.array(offset[::-1], np.float32) - reach
            where = self.cell + step
            yield step, where, step + self._looked_up("point", _feature_points, where, step) * self.randomness


def f1(p, randomness, metric, exponent, smoothness, is_pcg=False):
    """Nearest point: (distance, colour, place)."""
    cells = _Cells(p, randomness, is_pcg)
    least = np.full(len(p), np.inf, np.float32)
    where, place = np.zeros_like(cells.p), np.zeros_like(cells.p)
    for _, cell, point in cells.around(1):
        distance = _distance(point - cells.local, metric, exponent)
        nearer = distance < least
        least = np.where(nearer, distance, least)
        where, place = np.where(nearer[:, None], cell, where), np.where(nearer[:, None], point, place)
    return least, _colors(where.T, is_pcg), place + cells.cell


def f2(p, randomness, metric, exponent, smoothness, is_pcg=False):
    """The point that is nearest but one."""
    cells = _Cells(p, randomness, is_pcg)
    best = np.full((2, len(p)), np.inf, np.float32)
    where, place = (np.zeros((2, *cells.p.shape), np.float32) for _ in range(2))
    for _, cell, point in cells.around(1):
        distance = _distance(point - cells.local, metric, exponent)
        first, second = distance < best[0], (distance >= best[0]) & (distance < best[1])
        moved = first | second
        for held, new in ((best, distance), (where, cell), (place, point)):
            wide = (lambda m: m) if held.ndim == 2 else (lambda m: m[:, None])
            held[1] = np.where(wide(moved), np.where(wide(first), held[0], new), held[1])
            held[0] = np.where(wide(first), new, held[0])
    return best[1], _colors(where[1].T, is_pcg), place[1] + cells.cell


def smooth_f1(p, randomness, metric, exponent, smoothness, is_pcg=False):
    """Nearest point, neighbours mixed."""
    cells = _Cells(p, randomness, is_pcg)
    smoothness = np.broadcast_to(np.clip(np.asarray(smoothness, np.float32) / 2.0, 0.0, 0.5), (len(p),))
    if (smoothness <= 0.0).all():
        return f1(p, randomness, metric, exponent, smoothness, is_pcg)
    safe = np.maximum(smoothness, 1e-9)
    least = None
    color, place = np.zeros((len(p), 3), np.float32), np.zeros_like(cells.p)
    for step, cell, point in cells.around(2):
        distance = _distance(point - cells.local, metric, exponent)
        if least is None:
            h, least = np.ones(len(p), np.float32), np.zeros(len(p), np.float32)
        else:
            h = np.clip(0.5 + 0.5 * (least - distance) / safe, 0.0, 1.0)
            h = h * h * (3.0 - 2.0 * h)
        give = smoothness * h * (1.0 - h)
        least = least + (distance - least) * h - give
        give = (give / (1.0 + 3.0 * smoothness))[:, None]
        color = color + (cells.color(cell, step) - color) * h[:, None] - give
        place = place + (point - place) * h[:, None] - give
    return least, color, cells.cell + place


def distance_to_edge(p, randomness, is_pcg=False):
    """How far the border between the nearest point's cell and its neighbours is."""
    cells = _Cells(p, randomness, is_pcg)
    least = np.full(len(p), np.inf, np.float32)
    nearest = np.zeros_like(cells.p)
    for _, _, point in cells.around(1):
        way = point - cells.local
        square = (way * way).sum(axis=-1)
        nearer = square < least
        least, nearest = np.where(nearer, square, least), np.where(nearer[:, None], way, nearest)
    edge = np.full(len(p), np.inf, np.float32)
    for _, _, point in cells.around(1):
        way = point - cells.local
        across = way - nearest
        square = (across * across).sum(axis=-1)
        other = square > 1e-4
        along = (0.5 * (nearest + way) * across).sum(axis=-1) / np.sqrt(np.where(other, square, 1.0))
        edge = np.where(other, np.minimum(edge, along), edge)
    return edge


def sphere_radius(p, randomness, is_pcg=False):
    """Half the way from the nearest point to the point that is nearest to it."""
    cells = _Cells(p, randomness, is_pcg)
    least = np.full(len(p), np.inf, np.float32)
    where, nearest = np.zeros_like(cells.p), np.zeros_like(cells.p)
    for _, cell, point in cells.around(1):
        distance = np.linalg.norm(point - cells.local, axis=-1)
        nearer = distance < least
        least = np.where(nearer, distance, least)
        where, nearest = np.where(nearer[:, None], cell, where), np.where(nearer[:, None], point + cells.cell, nearest)
    around = _Cells(where, randomness, is_pcg)
    least = np.full(len(p), np.inf, np.float32)
    for step, _, point in around.around(1):
        if step.any():
            least = np.minimum(least, np.linalg.norm(point + around.cell - nearest, axis=-1))
    return least / 2.0


FEATURES = {"f1": f1, "f2": f2, "smoothF1": smooth_f1}


def _farthest(dimensions, randomness, metric, exponent):
    """Of the nearest point: the length of a cell's diagonal, less where the points stand still; normalized distances are shares of it."""
    half = 0.5 + 0.5 * np.atleast_1d(np.asarray(randomness, np.float32))
    return _distance(np.repeat(half[:, None], dimensions, axis=1), metric, exponent)


def texture(p, feature, metric, detail, roughness, lacunarity, smoothness, exponent, randomness, normalize, is_pcg=False):
    """Blender's Voronoi Texture at points (n, d), already scaled: `{"distance", "color", "position"}`, its octaves added."""
    p = np.asarray(p, np.float32)
    n, d = p.shape
    randomness = np.clip(np.asarray(randomness, np.float32), 0.0, 1.0)
    if feature == "nSphereRadius":
        return {"radius": sphere_radius(p, randomness, is_pcg)}
    at_points = lambda v: np.broadcast_to(np.asarray(v, np.float32), (n,))  # noqa: E731
    detail, roughness, lacunarity = np.clip(at_points(detail), 0.0, 15.0), np.clip(at_points(roughness), 0.0, 1.0), at_points(lacunarity)
    single = (detail == 0.0) | (roughness == 0.0)
    last = np.where(single, 0.0, np.ceil(detail))
    to_edge = feature == "distanceToEdge"
    farthest = 0.5 + 0.5 * randomness if to_edge else _farthest(d, randomness, metric, exponent) * (2.0 if feature == "f2" else 1.0)
    amplitude, scale, most = np.ones(n, np.float32), np.ones(n, np.float32), np.zeros(n, np.float32)
    distance, color, place = np.full(n, 8.0 if to_edge else 0.0, np.float32), np.zeros((n, 3), np.float32), np.zeros_like(p)
    if to_edge:
        most = at_points(farthest)
    for k in range(int(last.max()) + 1):
        # 1 in whole octaves, the fraction of `detail` in the last.
        share = np.where(single, float(k == 0), np.where(k <= detail, 1.0, np.clip(detail - (k - 1), 0.0, 1.0))).astype(np.float32)
        at = p * scale[:, None]
        if to_edge:
            edge = distance_to_edge(at, randomness, is_pcg)
            nearer = distance + (np.minimum(distance, edge / scale) - distance) * amplitude * share
            distance = np.where(single & (k == 0), edge, nearer)
            most = np.where(single, most, most + (farthest / scale - most) * amplitude * share)
        else:
            octave = FEATURES[feature](at, randomness, metric, exponent, smoothness, is_pcg)
            most = most + amplitude * share
            distance = distance + octave[0] * amplitude * share
            color = color + octave[1] * (amplitude * share)[:, None]
            here = place + (octave[2] / scale[:, None] - place) * amplitude[:, None]
            place = np.where(single[:, None] & (k == 0), octave[2], place + (here - place) * share[:, None])
        scale, amplitude = scale * lacunarity, amplitude * roughness
    if to_edge:
        return {"distance": distance / most if normalize else distance}
    if normalize:
        distance, color = distance / (most * farthest), color / np.where(single, 1.0, most)[:, None]
    return {"distance": distance, "color": color, "position": place}
