# SPDX-License-Identifier: GPL-3.0-or-later
"""Matrices → translation, rotation, scale, many at once."""

import numpy as np

# Largest difference of a matrix from what its parts multiply to, as a share of its largest scale: 32-bit numbers lose some 1e-7.
_SHEAR = 1e-5


def trs_of(matrices):
    """The parts of (n, 4, 4) matrices, as glTF multiplies them: translation (n, 3), quaternion x y z w (n, 4), scale (n, 3), float32; and which
    of the matrices they make again: (n,) bool. Mirrored ones have three negative scales; sheared and flat ones are not made again."""
    m = np.asarray(matrices, np.float64)
    linear = m[:, :3, :3]
    scale = np.linalg.norm(linear, axis=1)
    scale = np.where(np.linalg.det(linear)[:, None] < 0.0, -scale, scale)
    rotation = linear / np.where(scale == 0.0, 1.0, scale)[:, None, :]
    quaternion = _quaternions(rotation)
    again = _rotations(quaternion) * scale[:, None, :]
    error = np.abs(again - linear).max(axis=(1, 2))
    fits = np.isfinite(m).all(axis=(1, 2)) & (scale != 0.0).all(axis=1) & (error <= _SHEAR * np.abs(scale).max(axis=1))
    return m[:, :3, 3].astype(np.float32), quaternion.astype(np.float32), scale.astype(np.float32), fits


def _quaternions(r):
    """Quaternions x y z w of rotation matrices; what is none gives some unit quaternion. Source: Shepperd 1978."""
    trace = np.trace(r, axis1=1, axis2=2)
    diagonal = r[:, [0, 1, 2], [0, 1, 2]]
    # Four times the square of each part; the largest is divided by.
    squares = np.column_stack([1.0 - trace[:, None] + 2.0 * diagonal, 1.0 + trace])
    a, b, c = r[:, 2, 1] - r[:, 1, 2], r[:, 0, 2] - r[:, 2, 0], r[:, 1, 0] - r[:, 0, 1]
    d, e, f = r[:, 1, 0] + r[:, 0, 1], r[:, 0, 2] + r[:, 2, 0], r[:, 2, 1] + r[:, 1, 2]
    products = np.stack([
        np.column_stack([squares[:, 0], d, e, a]),
        np.column_stack([d, squares[:, 1], f, b]),
        np.column_stack([e, f, squares[:, 2], c]),
        np.column_stack([a, b, c, squares[:, 3]]),
    ], axis=1)
    q = products[np.arange(len(r)), squares.argmax(axis=1)]
    return q / np.maximum(np.linalg.norm(q, axis=1, keepdims=True), 1e-30)


def _rotations(q):
    """Rotation matrices of unit quaternions."""
    x, y, z, w = q.T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), 2, 0)
