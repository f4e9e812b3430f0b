# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes values that the renderer does not evaluate: over UV to a picture, over the surface to a picture with a place for every triangle, inside a
body to a grid, else to their mean."""

import numpy as np

from . import baked, pictures
from .evaluate import Evaluator
from .lower import reachable
from .schema import is_link
from .values import Unknown, affine, as_color, as_number

# Texels along the longer side of a baked picture, and of one that holds finer pictures at most; cells along a grid's longest side, the fewest that do. Picked by feel.
PICTURE_SIZE = 1024
MOST_PICTURE_SIZE = 4096
GRID_SIZES = (20, 40, 80, 160)
# A grid does when it is off by this share of the largest density, root mean square at places drawn at random.
GRID_ERROR = 0.01
# Values that stand on the faces, whatever coordinates there are.
ON_FACES = {"attribute", "meshAttribute", "geometry"}
# Most checker cells that become texels one by one.
MAX_CELLS = 4096


def linear_to_srgb(v):
    """Encodes sRGB."""
    v = np.clip(v, 0.0, 1.0)
    return np.where(v <= 0.0031308, 12.92 * v, 1.055 * np.maximum(v, 1e-9) ** (1.0 / 2.4) - 0.055)


def encoded(pixels, is_color):
    """A baked picture as `(file, mime type, colour space)`: a 16-bit PNG of values in 0..1, else floats."""
    if pixels.min() < 0.0 or pixels.max() > 1.0:
        return pictures.exr(pixels), "image/x-exr", "linear"
    return pictures.png(linear_to_srgb(pixels) if is_color else pixels, 16), "image/png", "srgb" if is_color else "nonColor"


class Baker:
    """Bakes for one object.

    `surroundings` has `log(what)`, `about(node, output)` (core/evaluate.py), `uv_box(set)` → ((u0, v0), (u1, v1)) or `None`; `body()` → (low, high) corners in object space or `None`;
    `points(source, p)` → coordinates of a source at object space points (n, 3); `image(index)` → linear RGBA; `shape(nodes)` → arrays that say all that these nodes ask of the
    mesh, or `None` where they ask for more; `add_file(data, mime, space)` and `add_grid(values, resolution, body)` → indices; `surface()` → an [`Atlas`](atlas.py) with `points(source, set)` and `about` at its samples and the
    `uv_set` that shows it, or `None`.
    """

    def __init__(self, surroundings):
        self.at = surroundings

    def bake_surface(self, nodes, value, log, add, is_color):
        """A picture node over UV or over the surface, or the mean where there is no surface. `is_color`: what the input wants."""
        used = [nodes[k] for k in reachable(nodes, value)]
        where = [n["coordinates"] for n in used if isinstance(n.get("coordinates"), dict) and "source" in n["coordinates"]]
        sets = {w.get("uvSet", 0) for w in where if w["source"] == "uv"}
        names = ", ".join(sorted({n["type"] for n in used if n["type"] not in {"vector", "separate", "combine", "math"}}))
        on_faces = any(n["type"] in ON_FACES or n.get("projection") == "box" for n in used)
        box = self.at.uv_box(min(sets)) if len(sets) == 1 and all(w["source"] == "uv" for w in where) and not on_faces else None
        try:
            if not where and not on_faces:
                return self._same_everywhere(nodes, value, is_color)
            if box is not None:
                return self._picture(nodes, value, used, min(sets), box, add, log, names, is_color)
            surface = self.at.surface()
            if surface is not None:
                return self._over_surface(nodes, value, used, surface, add, log, names, is_color)
            return self._mean(nodes, value, log, names)
        except Unknown as e:
            log(f"'{e}' is not evaluated; a mid grey is taken for it ({names})")
            return 0.5

    def _same_everywhere(self, nodes, value, is_color):
        """The value of what asks nothing of the place; the mean over hairs."""
        out = Evaluator(nodes, None, self.at.image, self.at.about).value(value)
        if out.ndim > 1 or (out.ndim == 1 and len(out) != 3):
            self.at.log("varies along hairs; its mean is taken")
            out = (as_color(out) if is_color else as_number(out)).mean(axis=0)
        return [float(v) for v in as_color(out)] if is_color else float(as_number(out))

    def _picture(self, nodes, value, used, uv_set, box, add, log, names, is_color):
        (u0, v0), (u1, v1) = box
        grid = _checker_lattice(used, box)
        repeats = not grid and _repeats(used)
        if grid:
            (u0, v0), (u1, v1), (width, height) = grid
        else:
            if repeats:
                (u0, v0), (u1, v1) = (0.0, 0.0), (1.0, 1.0)
            span = max(u1 - u0, v1 - v0, 1e-6)
            size = max([PICTURE_SIZE, *(self._texels(n) * span for n in used if n["type"] == "image")])
            width, height = (max(2, round(min(size, MOST_PICTURE_SIZE) * s / span)) for s in (u1 - u0, v1 - v0))
        u = u0 + (np.arange(width) + 0.5) / width * (u1 - u0)
        v = v1 - (np.arange(height) + 0.5) / height * (v1 - v0)

        def part(rows):
            p = np.stack([*(a.ravel() for a in np.meshgrid(u, v[rows])), np.zeros(width * len(v[rows]))], axis=-1)

            def points(source, _):
                if source != "uv":
                    raise Unknown(f"coordinates of source {source}")
                return p

            out = np.asarray(Evaluator(nodes, points, self.at.image, self.at.about).value(value), np.float32)
            out = (as_color(out) if is_color else as_color(as_number(out))).reshape(-1, 3)
            return np.broadcast_to(out, (len(p), 3)).reshape(-1, width, 3)

        def pixels():
            # In strips, so that what is between takes little memory.
            step = max(1, (1 << 20) // width)
            return np.concatenate([part(slice(first, first + step)) for first in range(0, height, step)])

        image = self._kept_picture(nodes, value, used, is_color, (width, height, u0, v0, u1, v1), pixels)
        if not grid:
            log(f"baked to a picture of {width} x {height} over UV: {names}")
        record = {
            "type": "image",
            "image": image,
            "coordinates": {"source": "uv"},
            "interpolation": "closest" if grid else "linear",
            "extension": "repeat" if repeats else "extend",
        }
        if uv_set:
            record["coordinates"]["uvSet"] = uv_set
        if (u0, v0, u1, v1) != (0.0, 0.0, 1.0, 1.0):
            su, sv = 1.0 / (u1 - u0), 1.0 / (v1 - v0)
            record["coordinates"]["affine"] = [su, 0, 0, -u0 * su, 0, sv, 0, -v0 * sv, 0, 0, 1, 0]
        return _linked(record, add, is_color)

    def _texels(self, node):
        """Texels of a picture along a unit of u or v."""
        height, width = self.at.image(node["image"]).shape[:2]
        rows = np.abs(np.asarray(node["coordinates"].get("affine", np.eye(3, 4).ravel())).reshape(3, 4))
        return max(width * rows[0, :2].max(), height * rows[1, :2].max())

    def _kept_picture(self, nodes, value, used, is_color, where, pixels):
        """Index of a picture: that of an earlier export where nothing changed, else of `pixels()`."""
        shape = self.at.shape(used)
        key = shape and baked.key_of(used, nodes[value["node"]], value, is_color, where, *shape)
        kept = key and baked.find(key)
        if kept:
            return self.at.add_file(*kept)
        made = encoded(pixels(), is_color)
        if key:
            baked.keep(key, made)
        return self.at.add_file(*made)

    def _over_surface(self, nodes, value, used, surface, add, log, names, is_color):
        """A picture with a place for every triangle."""
        atlas = surface.atlas

        def pixels():
            out = np.asarray(Evaluator(nodes, surface.points, self.at.image, surface.about).value(value), np.float32)
            out = as_color(out) if is_color else as_color(as_number(out))
            _, _, rows, columns = surface.samples
            picture = np.zeros((atlas.side, atlas.side, 3), np.float32)
            picture[rows, columns] = out
            return picture

        image = self._kept_picture(nodes, value, used, is_color, "faces", pixels)
        log(f"baked to a picture of {atlas.side} x {atlas.side} over its faces: {names}")
        record = {
            "type": "image",
            "image": image,
            "coordinates": {"source": "uv", "uvSet": surface.uv_set},
            "interpolation": "linear",
            "extension": "extend",
        }
        return _linked(record, add, is_color)

    def _mean(self, nodes, value, log, names):
        """The mean over the body's box."""
        body = self.at.body()
        if body is None:
            raise Unknown(names)
        out = self._inside(nodes, value, body, (16, 16, 16))
        log(f"varies with the place, not with UV; its mean is taken: {names}")
        mean = out.reshape(-1, out.shape[-1]).mean(axis=0) if out.ndim == 2 else out.mean()
        return float(mean) if np.ndim(mean) == 0 else [float(v) for v in mean]

    def _inside(self, nodes, value, body, resolution):
        low, high = body
        axes = [low[k] + (np.arange(n) + 0.5) / n * (high[k] - low[k]) for k, n in enumerate(resolution)]
        z, y, x = np.meshgrid(axes[2], axes[1], axes[0], indexing="ij")
        p = np.stack([x.ravel(), y.ravel(), z.ravel()], axis=-1)
        return np.asarray(Evaluator(nodes, lambda source, _: self.at.points(source, p), self.at.image, self.at.about).value(value), np.float32)

    def _grid(self, nodes, value, body):
        """Densities in the coarsest grid that is close enough, z slowest, and its resolution."""
        low, size = np.asarray(body[0]), np.maximum(np.asarray(body[1]) - body[0], 1e-6)
        places = np.random.default_rng(1).random((4096, 3))
        evaluator = Evaluator(nodes, lambda source, _: self.at.points(source, low + places * size), self.at.image, self.at.about)
        there = np.broadcast_to(as_number(np.asarray(evaluator.value(value), np.float32)), (len(places),))
        for cells in GRID_SIZES:
            resolution = np.maximum(1, np.round(cells * size / size.max())).astype(int)
            inside = as_number(self._inside(nodes, value, body, resolution))
            values = np.broadcast_to(inside, (int(np.prod(resolution)),)).reshape(resolution[::-1])
            error = np.sqrt(np.mean((trilinear(values, places) - there) ** 2))
            if error <= GRID_ERROR * np.abs(values).max():
                break
        return values.ravel(), resolution

    def bake_volume(self, nodes, value, as_grid, log, add):
        """A grid of densities inside the body, or the mean."""
        names = ", ".join(sorted({nodes[k]["type"] for k in reachable(nodes, value)}))
        body = self.at.body()
        try:
            if body is None:
                raise Unknown(names)
            if not as_grid:
                out = self._inside(nodes, value, body, (32, 32, 32))
                mean = out.mean(axis=0)
                return float(mean) if np.ndim(mean) == 0 else [float(v) for v in mean]
            values, resolution = self._grid(nodes, value, body)
        except Unknown as e:
            log(f"'{e}' is not evaluated inside a volume; a density of 1 is taken ({names})")
            return 1.0
        log(f"baked to a grid of {' x '.join(map(str, resolution))}: {names}")
        grid = self.at.add_grid(np.ascontiguousarray(values, np.float32), resolution, body)
        return {"node": add({"type": "grid", "grid": grid})}


def trilinear(values, places):
    """Values of a grid [z][y][x] at `places` (n, 3: x, y, z in 0..1), between the centres of its cells."""
    size = np.array(values.shape[::-1])
    at = np.clip(places * size - 0.5, 0.0, size - 1.0)
    first = np.minimum(at.astype(int), np.maximum(size - 2, 0))
    share, last = at - first, np.minimum(first + 1, size - 1)
    out = 0.0
    for corner in np.ndindex(2, 2, 2):
        x, y, z = (last[:, k] if corner[k] else first[:, k] for k in range(3))
        weight = np.prod(np.where(corner, share, 1.0 - share), axis=1)
        out = out + weight * values[z, y, x]
    return out


def _linked(record, add, is_color):
    """A picture's colour, or its red channel as a number."""
    link = {"node": add(record), "output": "color"}
    return link if is_color else {"node": add({"type": "separate", "color": link}), "output": "x"}


def _repeats(used):
    """Whether a value is that of pictures alone that come again with every unit of u and v."""
    textures = [n for n in used if "coordinates" in n]
    for n in textures:
        if n["type"] != "image" or n.get("extension", "repeat") != "repeat" or is_link(n["coordinates"]):
            return False
        turn = np.asarray(n["coordinates"].get("affine", np.eye(3, 4).ravel())).reshape(3, 4)[:2, :2]
        if np.abs(turn - np.round(turn)).max() > 1e-6:
            return False
    return bool(textures)


def _checker_lattice(used, box):
    """Box and size of a picture whose texels are the checker's cells; `None` where the value is more than checkers along u and v."""
    textures = [n for n in used if "coordinates" in n]
    if not textures or any(n["type"] != "checker" or not isinstance(n["scale"], float) for n in textures):
        return None
    wheres = {repr((n["coordinates"], n["scale"])) for n in textures}
    if len(wheres) != 1:
        return None
    scale, where = textures[0]["scale"], textures[0]["coordinates"]
    ends = np.array([[*box[0], 0.0], [*box[1], 0.0]])
    if "affine" in where:
        rows = np.asarray(where["affine"]).reshape(3, 4)
        if rows[0, 1] or rows[1, 0] or rows[2, 0] or rows[2, 1]:
            return None
        moved = affine(where["affine"], ends)
        slope, shift = rows[[0, 1], [0, 1]], rows[[0, 1], 3]
    else:
        moved, slope, shift = ends, np.ones(2), np.zeros(2)
    if scale <= 0.0 or (slope <= 0.0).any():
        return None
    cells = moved[:, :2] * scale
    first, last = np.floor(cells[0] + 1e-4), np.ceil(cells[1] - 1e-4)
    size = (last - first).astype(int)
    if (size < 1).any() or (size > MAX_CELLS).any():
        return None
    low, high = ((edge / scale - shift) / slope for edge in (first, last))
    return tuple(map(float, low)), tuple(map(float, high)), tuple(map(int, size))
