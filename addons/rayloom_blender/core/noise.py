# SPDX-License-Identifier: GPL-3.0-or-later
"""Gradient noise as Blender's Noise Texture has it, over arrays of points. Checked against Blender's own in tests/blender.

Source: Perlin, "Improving Noise" (2002); Jenkins' lookup3 hash (public domain, 2006).
"""

import numpy as np

# So that values fill -1..1, in three dimensions. measured against Blender 4.5.
_SCALE_3D = np.float32(0.9820)


def _rot(x, k):
    return (x << np.uint32(k)) | (x >> np.uint32(32 - k))


def hash3(kx, ky, kz):
    """Jenkins' final mix of three 32-bit words, as arrays."""
    with np.errstate(over="ignore"):
        seed = np.uint32((0xDEADBEEF + (3 << 2) + 13) & 0xFFFFFFFF)
        a, b, c = kx + seed, ky + seed, kz + seed
        for x, y, k in (("c", "b", 14), ("a", "c", 11), ("b", "a", 25), ("c", "b", 16), ("a", "c", 4), ("b", "a", 14), ("c", "b", 24)):
            v = {"a": a, "b": b, "c": c}
            r = (v[x] ^ v[y]) - _rot(v[y], k)
            a, b, c = (r if n == x else v[n] for n in "abc")
    return c


def _gradient(h, x, y, z):
    h = h & np.uint32(15)
    u = np.where(h < 8, x, y)
    v = np.where(h < 4, y, np.where((h == 12) | (h == 14), x, z))
    return np.where(h & 1, -u, u) + np.where(h & 2, -v, v)


def perlin3(p):
    """Signed noise at points (n, 3), about -1..1."""
    cell = np.floor(p)
    f = (p - cell).astype(np.float32)
    i = cell.astype(np.int64).astype(np.uint32)
    u = f * f * f * (f * (f * 6.0 - 15.0) + 10.0)
    one = np.uint32(1)
    with np.errstate(over="ignore"):
        corner = {
            (x, y, z): _gradient(hash3(i[:, 0] + one * x, i[:, 1] + one * y, i[:, 2] + one * z), f[:, 0] - x, f[:, 1] - y, f[:, 2] - z)
            for x in (0, 1)
            for y in (0, 1)
            for z in (0, 1)
        }
    along_x = {(y, z): corner[0, y, z] + u[:, 0] * (corner[1, y, z] - corner[0, y, z]) for y in (0, 1) for z in (0, 1)}
    along_y = [along_x[0, z] + u[:, 1] * (along_x[1, z] - along_x[0, z]) for z in (0, 1)]
    return _SCALE_3D * (along_y[0] + u[:, 2] * (along_y[1] - along_y[0]))


def fbm(p, detail, roughness, lacunarity, normalize):
    """Octaves of noise: 0..1 with `normalize`, else signed. A fraction of `detail` mixes in one more octave."""
    detail = min(max(float(detail), 0.0), 15.0)
    roughness = max(float(roughness), 0.0)
    amplitude, scale, most = 1.0, 1.0, 0.0
    total = np.zeros(len(p), np.float32)
    for _ in range(int(detail) + 1):
        total += amplitude * perlin3(p * scale)
        most += amplitude
        amplitude *= roughness
        scale *= float(lacunarity)
    rest = detail - int(detail)

    def finished(value, peak):
        return 0.5 * value / peak + 0.5 if normalize else value

    if rest == 0.0:
        return finished(total, most)
    more = total + amplitude * perlin3(p * scale)
    return (1.0 - rest) * finished(total, most) + rest * finished(more, most + amplitude)
