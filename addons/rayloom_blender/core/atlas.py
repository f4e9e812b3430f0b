# SPDX-License-Identifier: GPL-3.0-or-later
"""A place in a picture for every triangle of a mesh, to bake what depends on the place on the surface.

Two triangles share a square cell of `m + 6` texels: one has its corners at the texels (1, 1), (m + 1, 1), (1, m + 1), the other at the same texels counted
from the opposite corner. The texels just beyond all sides belong to the nearer triangle's plane, so that mixing neighbours meets no foreign texel, and the
slopes that bump maps take over a texel are right up to the edges. Where cells are too small for that, only the long sides have such texels (`m + 3`, from (0, 0)).
"""

import numpy as np

# Sides of a picture in texels: the first in which a cell has enough.
SIDES = (1024, 2048)
# Texels along a cell, wanted and least.
WANTED, LEAST = 12, 5
# From this on there is room beyond all sides.
ROOMY = 8


class Atlas:
    """Of `n` triangles; `fits` is false when they are too many."""

    def __init__(self, n):
        self.n = n
        self.cells = max(1, int(np.ceil(np.sqrt((n + 1) // 2))))
        self.side = next((s for s in SIDES if s // self.cells >= WANTED), SIDES[-1])
        self.cell = self.side // self.cells
        self.fits = n > 0 and self.cell >= LEAST
        self.border = 1 if self.cell >= ROOMY else 0
        self.inner = self.cell - 3 - 3 * self.border

    def _origins(self):
        """Texel of each triangle's own (0, 0), and the step from it: 1 or -1."""
        triangle = np.arange(self.n)
        square = triangle // 2
        low = np.stack([square % self.cells, square // self.cells], axis=-1) * self.cell
        second = (triangle % 2 == 1)[:, None]
        border = self.border
        return np.where(second, low + self.cell - 1 - border, low + border), np.where(second, -1, 1)

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
        line = np.arange(-self.border, m + 2 + self.border)
        i, j = (a.ravel() for a in np.meshgrid(line, line))
        used = i + j <= m + 1 + self.border
        i, j = i[used], j[used]
        weights = np.stack([1.0 - (i + j) / m, i / m, j / m], axis=-1)
        origin, step = self._origins()
        columns = origin[:, :1] + step * i[None]
        rows = origin[:, 1:] + step * j[None]
        triangle = np.repeat(np.arange(self.n), len(i))
        return triangle, np.tile(weights, (self.n, 1)), rows.ravel(), columns.ravel()
