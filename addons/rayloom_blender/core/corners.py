# SPDX-License-Identifier: GPL-3.0-or-later
"""Per-corner data of polygon meshes → vertices as glTF has them, without sorting."""

import numpy as np


def split_corners(corner_vertex, n_vertices, corner_attributes):
    """Vertices and the vertex of each corner, so that every attribute is one value a vertex.

    `corner_vertex`: the mesh vertex of each corner. `corner_attributes`: arrays `(corners, k)`. A corner whose attributes are those of the
    last corner of its vertex shares it; the others, those at seams and sharp edges, get vertices of their own.

    Returns `(source_vertex, source_corner, corner_index)`: for every output vertex the mesh vertex and a corner to take from, and for every corner
    its output vertex. Vertices that no corner uses keep their place with corner 0.
    """
    n_corners = len(corner_vertex)
    representative = np.zeros(n_vertices, np.int64)
    representative[corner_vertex] = np.arange(n_corners)
    differs = np.zeros(n_corners, bool)
    of_vertex = representative[corner_vertex]
    for attribute in corner_attributes:
        flat = attribute.reshape(n_corners, -1)
        differs |= (flat != flat[of_vertex]).any(axis=1)
    own = np.flatnonzero(differs)
    corner_index = corner_vertex.astype(np.uint32)
    corner_index[own] = n_vertices + np.arange(len(own), dtype=np.uint32)
    source_vertex = np.concatenate([np.arange(n_vertices), corner_vertex[own]])
    source_corner = np.concatenate([representative, own])
    return source_vertex, source_corner, corner_index
