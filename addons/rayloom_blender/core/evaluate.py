# SPDX-License-Identifier: GPL-3.0-or-later
"""Evaluates value nodes of the file over arrays of points: folds constants, bakes what the renderer does not evaluate.

An array is (n,) for numbers and (n, 3) for colours and vectors; constants are numbers and arrays of three.
"""

import numpy as np

from . import arithmetic, colors, rays, textures
from .schema import is_link
from .values import Unknown, affine, as_color, as_number


class Evaluator:
    """Values of a list of nodes at points.

    `points(source, uv_set)` gives the coordinates (n, 3) of a source; `image(index)` linear RGBA pixels (height, width, 4), top row first;
    `about(node, output)` what a node tells of the object, its surface or the ray. Each raises [`Unknown`] for what it does not have.
    """

    def __init__(self, nodes, points=None, image=None, about=None):
        self.nodes = nodes
        self._points = points
        self._image = image
        self._about = about
        self._done = {}

    def value(self, given):
        """The value of an input."""
        if not is_link(given):
            return np.asarray(given, np.float32)
        key = (given["node"], given.get("output"))
        if key not in self._done:
            node = self.nodes[given["node"]]
            function = FUNCTIONS.get(node["type"])
            if function is not None:
                out = np.asarray(function(self, node, given.get("output")))
                # What looks at one place alone is the same everywhere.
                self._done[key] = out[0] if out.ndim and out.shape[0] == 1 else out
            elif self._about is not None:
                self._done[key] = np.asarray(self._about(node, given.get("output")), np.float32)
            else:
                raise Unknown(node["type"])
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


FUNCTIONS = {
    **arithmetic.FUNCTIONS,
    **colors.FUNCTIONS,
    **textures.FUNCTIONS,
    "fixedPath": lambda e, n, o: rays.value(n, o),
    "affineMap": lambda e, n, o: affine(n["affine"], e.color(n, "vector")),
    "vector": lambda e, n, o: e.coordinates(n),
}
