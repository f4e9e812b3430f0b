# SPDX-License-Identifier: GPL-3.0-or-later
"""Many instances of one mesh: one node with EXT_mesh_gpu_instancing in place of a node each."""

import numpy as np

from ..core.decompose import trs_of

NAME = "EXT_mesh_gpu_instancing"
# Fewer instances stand as nodes: each keeps its matrix to the last digit and every tool can pick it. Picked by feel.
FROM = 16


class Crowd:
    """Instances of one object that show one mesh and differ in nothing but place."""

    def __init__(self, mesh, name, switches):
        self.mesh, self.name, self.switches = mesh, name, switches
        self.keys, self.matrices, self.randoms = [], [], []

    def add(self, shown):
        """One more instance."""
        self.keys.append(shown.key)
        self.matrices.append(shown.matrix)
        self.randoms.append(shown.random)


def arrays_of(matrices):
    """(n, 4, 4) numbers of Blender's matrices."""
    flat = [value for matrix in matrices for row in matrix for value in row]
    return np.array(flat, np.float64).reshape(-1, 4, 4)


def split(crowd):
    """What one node can show of a crowd: `(indices, attributes)` with arrays by the extension's names, and the indices of the others."""
    if len(crowd.keys) < FROM:
        return [], {}, range(len(crowd.keys))
    translation, rotation, scale, fits = trs_of(arrays_of(crowd.matrices))
    kept, others = np.flatnonzero(fits), np.flatnonzero(~fits)
    if len(kept) < FROM:
        return [], {}, range(len(crowd.keys))
    attributes = {"TRANSLATION": translation[kept]}
    if (np.abs(rotation[kept, 3]) < 1.0).any():
        attributes["ROTATION"] = rotation[kept]
    if (scale[kept] != 1.0).any():
        attributes["SCALE"] = scale[kept]
    attributes["_RANDOM"] = np.array(crowd.randoms, np.float32)[kept]
    return kept.tolist(), attributes, others.tolist()
