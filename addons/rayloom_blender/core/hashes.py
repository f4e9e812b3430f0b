# SPDX-License-Identifier: GPL-3.0-or-later
"""Hashes of cells and points, over arrays, as Blender's textures have them. Checked against Blender's own in tests/blender.

Source: Jenkins' lookup3 (public domain, 2006); Jarzynski and Olano, "Hash Functions for GPU Rendering", JCGT 9(3), 2020 (PCG).
"""

import numpy as np


def _rot(x, k):
    return (x << np.uint32(k)) | (x >> np.uint32(32 - k))


def _final(a, b, c):
    for x, y, k in (("c", "b", 14), ("a", "c", 11), ("b", "a", 25), ("c", "b", 16), ("a", "c", 4), ("b", "a", 14), ("c", "b", 24)):
        v = {"a": a, "b": b, "c": c}
        r = (v[x] ^ v[y]) - _rot(v[y], k)
        a, b, c = (r if n == x else v[n] for n in "abc")
    return c


def _mix(a, b, c):
    a = (a - c) ^ _rot(c, 4)
    c = c + b
    b = (b - a) ^ _rot(a, 6)
    a = a + c
    c = (c - b) ^ _rot(b, 8)
    b = b + a
    a = (a - c) ^ _rot(c, 16)
    c = c + b
    b = (b - a) ^ _rot(a, 19)
    a = a + c
    c = (c - b) ^ _rot(b, 4)
    b = b + a
    return a, b, c


def jenkins(*words):
    """The hash of one to four arrays of 32-bit words."""
    with np.errstate(over="ignore"):
        seed = np.uint32((0xDEADBEEF + (len(words) << 2) + 13) & 0xFFFFFFFF)
        a, b, c = (w + seed for w in (*words[:3], *(np.uint32(0),) * (3 - len(words[:3]))))
        if len(words) == 4:
            a, b, c = _mix(a, b, c)
            a = a + words[3]
        return _final(a, b, c)


def of_integers(columns):
    """The Jenkins hash of whole numbers, one array a dimension."""
    return jenkins(*(c.astype(np.int64).astype(np.uint32) for c in columns))


def of_floats(*columns):
    """0..1 of the bits of one to four arrays of 32-bit floats."""
    words = np.broadcast_arrays(*(np.asarray(c, np.float32) for c in columns))
    return (jenkins(*(np.ascontiguousarray(w).view(np.uint32) for w in words)) / np.float32(0xFFFFFFFF)).astype(np.float32)


def color_of_floats(*columns):
    """Three numbers of 0..1 of one to four arrays of floats, (n, 3)."""
    k = columns
    if len(k) == 4:
        orders = (k, (k[2], k[0], k[3], k[1]), (k[3], k[2], k[1], k[0]))
    else:
        orders = (k, (*k, 1.0), (*k, 2.0))
    return np.stack([of_floats(*o) for o in orders], axis=-1)


def pcg(columns):
    """PCG of two to four arrays of whole numbers: as many arrays of 0..1."""
    with np.errstate(over="ignore"):
        v = [c.astype(np.int64).astype(np.uint32) * np.uint32(1664525) + np.uint32(1013904223) for c in columns]
        n = len(v)
        # Which two parts are multiplied and added to which.
        steps = {3: ((0, 1, 2), (1, 2, 0), (2, 0, 1)), 4: ((0, 1, 3), (1, 2, 0), (2, 0, 1), (3, 1, 2))}.get(n)

        def stir():
            if steps is None:
                v[0] = v[0] + v[1] * np.uint32(1664525)
                v[1] = v[1] + v[0] * np.uint32(1664525)
                return
            for to, a, b in steps:
                v[to] = v[to] + v[a] * v[b]

        stir()
        # Signed numbers: the shift fills with their sign (measured, 5.0).
        v = [x ^ (x.view(np.int32) >> np.int32(16)).view(np.uint32) for x in v]
        stir()
    return [((x & np.uint32(0x7FFFFFFF)) * np.float32(1.0 / 0x7FFFFFFF)).astype(np.float32) for x in v]
