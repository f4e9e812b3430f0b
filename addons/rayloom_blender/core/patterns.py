# SPDX-License-Identifier: GPL-3.0-or-later
"""Regular patterns as Blender's Wave, Magic and Brick Textures have them, over arrays of points (n, 3). Checked against Blender's own in tests/blender."""

import numpy as np

from . import noise

_AXES = {"x": 0, "y": 1, "z": 2}


def wave(p, kind, direction, profile, distortion, detail, detail_scale, detail_roughness, phase):
    """Bands or rings, 0..1."""
    # So that faces on a whole number do not flicker.
    p = (p + 1e-6) * 0.999999
    if kind == "bands":
        n = p.sum(axis=1) * 10.0 if direction == "diagonal" else p[:, _AXES[direction]] * 20.0
    else:
        across = [k for k in range(3) if k != _AXES.get(direction)]
        n = np.linalg.norm(p[:, across], axis=1) * 20.0
    n = n + phase
    if np.any(distortion != 0.0):
        at = p * np.reshape(np.asarray(detail_scale), (-1, 1))
        n = n + distortion * (2.0 * noise.fbm(at, detail, detail_roughness, 2.0, True) - 1.0)
    if profile == "sin":
        return 0.5 + 0.5 * np.sin(n - 0.5 * np.pi)
    n = n / (2.0 * np.pi)
    return n - np.floor(n) if profile == "saw" else 2.0 * np.abs(n - np.floor(n + 0.5))


# One step a depth, from 1: the axis that is written, the function, its sign and the signs of x, y, z within.
_MAGIC = (
    (1, np.cos, -1, (1, -1, 1)),
    (0, np.cos, 1, (1, -1, -1)),
    (2, np.sin, 1, (-1, -1, -1)),
    (0, np.cos, -1, (-1, 1, -1)),
    (1, np.sin, -1, (-1, 1, 1)),
    (1, np.cos, -1, (-1, 1, 1)),
    (0, np.cos, 1, (1, 1, 1)),
    (2, np.sin, 1, (1, 1, -1)),
    (0, np.cos, -1, (-1, -1, 1)),
    (1, np.sin, -1, (1, -1, 1)),
)


def magic(p, depth, distortion):
    """Psychedelic colours, (n, 3)."""
    p = np.fmod(p, 2.0 * np.pi)
    x, y, z = p.T
    v = [np.sin((x + y + z) * 5.0), np.cos((-x + y - z) * 5.0), -np.cos((-x - y + z) * 5.0)]
    if depth > 0:
        v = [c * distortion for c in v]
    for axis, function, sign, signs in _MAGIC[:depth]:
        v[axis] = sign * function(sum(s * c for s, c in zip(signs, v))) * distortion
    d = np.asarray(distortion) * 2.0
    out = np.stack(v, axis=-1)
    safe = np.where(d != 0.0, d, 1.0)
    return 0.5 - np.where((d != 0.0) if d.ndim == 0 else (d != 0.0)[:, None], out / (safe if d.ndim == 0 else safe[:, None]), out)


def _brick_tint(n):
    """0..1 of the number of a brick."""
    with np.errstate(over="ignore"):
        n = (n.astype(np.int64) + 1013).astype(np.uint32) & np.uint32(0x7FFFFFFF)
        n = (n >> np.uint32(13)) ^ n
        n = n * (n * n * np.uint32(60493) + np.uint32(19990303)) + np.uint32(1376312589)
    return 0.5 * ((n & np.uint32(0x7FFFFFFF)) / 1073741824.0)


def brick(p, mortar_size, mortar_smooth, bias, width, height, offset, offset_frequency, squash, squash_frequency):
    """`(tint, mortar)`: how much of the second colour a brick has, and how much a point is mortar."""
    row = np.floor(p[:, 1] / height)
    width = np.broadcast_to(np.asarray(width, float), row.shape)
    shift = np.zeros_like(row)
    if offset_frequency and squash_frequency:
        width = np.where(np.mod(row, squash_frequency) != 0, width, width * squash)
        shift = np.where(np.mod(row, offset_frequency) != 0, 0.0, width * offset)
    across = p[:, 0] + shift
    column = np.floor(across / width)
    x, y = across - width * column, p[:, 1] - height * row
    number = (row.astype(np.int64) << 16) + (column.astype(np.int64) & 0xFFFF)
    tint = np.clip(_brick_tint(number) + bias, 0.0, 1.0)
    edge = np.minimum(np.minimum(x, y), np.minimum(width - x, height - y))
    size = np.broadcast_to(np.asarray(mortar_size, float), row.shape)
    smooth = np.broadcast_to(np.asarray(mortar_smooth, float), row.shape)
    inside = np.clip((1.0 - edge / np.where(size > 0.0, size, 1.0)) / np.where(smooth > 0.0, smooth, 1.0), 0.0, 1.0)
    mortar = np.where(smooth > 0.0, inside * inside * (3.0 - 2.0 * inside), 1.0)
    return tint, np.where(edge >= size, 0.0, mortar)
