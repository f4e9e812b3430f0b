# SPDX-License-Identifier: GPL-3.0-or-later
"""A place in a picture for every triangle of a mesh, to bake what depends on the place on the surface.

Two triangles share a square cell of `m + 3` texels: one has its corners at the texels (0, 0), (m, 0), (0, m), the other at the same texels counted from the
opposite corner. The texels just beyond the long sides belong to the nearer triangle's plane, so that mixing neighbours meets no foreign texel.
"""

import numpy as np

# Sides of a picture in texels: the first in which a cell has enough.
SIDES = (1024, 2048)
# Texels along a cell, wanted and least.
WANTED, LEAST = 10, 5


class Atlas:
    """Of `n` triangles; `fits` is false when they are too many."""

    def __init__(self, n):
        self.n = n
        self.cells = max(1, int(np.ceil(np.sqrt((n + 1) // 2))))
        self.side = next((s for s in SIDES if s // self.cells >= WANTED), SIDES[-1])
        self.cell = self.side // self.cells
        self.fits = n > 0 and self.cell >= LEAST
        self.inner = self.cell - 3

    def _origins(self):
        """Texel of each triangle's own (0, 0), and the step from it: 1 or -1."""
        triangle = np.arange(self.n)
        square = triangle // 2
        low = np.stack([square % self.cells, square // self.cells], axis=-1) * self.cell
        second = (triangle % 2 == 1)[:, None]
        return np.where(second, low + self.cell - 1, low), np.where(second, -1, 1)

    def corner_uv(self):
        """Coordinates of all corners, (triangles, 3, 2), v up."""
        origin, step = self._origins()
        m = self.inner
        corners = np.array([[0, 0], [m, 0], [0, m]])
        texel = origin[:, None, :] + step[:, None, :] * corners[None]
        uv = (texel + 0.5) / self.side
        uv[..., 1] = 1.0 - uv[..., 1]
        return uv.astype(np.float32)

    def samples(self):
        """All texels that are used: `(triangle, weights of its corners (n, 3), row, column)`."""
        m = self.inner
        i, j = (a.ravel() for a in np.meshgrid(np.arange(m + 2), np.arange(m + 2)))
        used = i + j <= m + 1
        i, j = i[used], j[used]
        weights = np.stack([1.0 - (i + j) / m, i / m, j / m], axis=-1)
        origin, step = self._origins()
        columns = origin[:, :1] + step * i[None]
        rows = origin[:, 1:] + step * j[None]
        triangle = np.repeat(np.arange(self.n), len(i))
        return triangle, np.tile(weights, (self.n, 1)), rows.ravel(), columns.ravel()
