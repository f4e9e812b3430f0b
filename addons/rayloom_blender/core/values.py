# SPDX-License-Identifier: GPL-3.0-or-later
"""What arrays of values are: (n,) for numbers and (n, 3) for colours and vectors; constants are numbers and arrays of three."""

import numpy as np

LUMINANCE = np.array([0.2126729, 0.7151522, 0.0721750], np.float32)


class Unknown(Exception):
    """A node that has no value here: its type, or what it needs."""


def as_color(value):
    """A number becomes grey."""
    value = np.asarray(value, np.float32)
    return value if value.ndim and value.shape[-1] == 3 else np.repeat(value[..., None], 3, axis=-1)


def as_number(value):
    """A colour becomes its luminance."""
    value = np.asarray(value, np.float32)
    return value @ LUMINANCE if value.ndim and value.shape[-1] == 3 else value


def srgb_to_linear(v):
    """Decodes sRGB."""
    v = np.asarray(v, np.float32)
    return np.where(v <= 0.04045, v / 12.92, ((np.maximum(v, 0.0) + 0.055) / 1.055) ** 2.4).astype(np.float32)


def affine(rows, p):
    """A map of 12 numbers, row by row, on points (n, 3)."""
    m = np.asarray(rows, np.float64).reshape(3, 4)
    return p @ m[:, :3].T + m[:, 3]


def column(value):
    """Numbers so that they multiply colours."""
    value = np.asarray(value)
    return value[..., None] if value.ndim else value


def lerp(a, b, t):
    """From colours `a` to `b` by numbers `t`."""
    return a + (b - a) * column(t)
