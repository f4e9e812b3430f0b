# SPDX-License-Identifier: GPL-3.0-or-later
"""Gradient noise and its sums of octaves as Blender's Noise Texture has them, over arrays of points (n, d) with d from 1 to 4. Checked against
Blender's own in tests/blender.

Source: Perlin, "Improving Noise" (2002); Musgrave in "Texturing and Modeling" (3rd ed., 2003, chapter 16).
"""

import numpy as np

from . import hashes

# So that values fill -1..1. measured against Blender 4.5.
_SCALE = {1: np.float32(0.25), 2: np.float32(0.6616), 3: np.float32(0.9820), 4: np.float32(0.8344)}
# Blender repeats noise beyond, where 32-bit numbers have no fraction left.
_PERIOD = np.float32(100000.0)


def _signed(value, h, bit):
    return np.where(h & np.uint32(bit), -value, value)


def _gradient(h, f):
    """The slope that belongs to a hash, times the offset from its lattice point."""
    if len(f) == 1:
        h = h & np.uint32(15)
        return _signed(1.0 + (h & np.uint32(7)).astype(np.float32), h, 8) * f[0]
    if len(f) == 2:
        h = h & np.uint32(7)
        x, y = f
        return _signed(np.where(h < 4, x, y), h, 1) + _signed(2.0 * np.where(h < 4, y, x), h, 2)
    if len(f) == 3:
        h = h & np.uint32(15)
        x, y, z = f
        v = np.where(h < 4, y, np.where((h == 12) | (h == 14), x, z))
        return _signed(np.where(h < 8, x, y), h, 1) + _signed(v, h, 2)
    h = h & np.uint32(31)
    x, y, z, w = f
    return _signed(np.where(h < 24, x, y), h, 1) + _signed(np.where(h < 16, y, z), h, 2) + _signed(np.where(h < 8, z, w), h, 4)


def perlin(p):
    """Signed noise at points (n, d), about -1..1."""
    p = np.asarray(p, np.float32)
    far = np.abs(p) >= 1e6
    p = np.fmod(p, _PERIOD) + np.where(far, np.float32(0.5), np.float32(0.0))
    columns = p.T
    cell = [np.floor(c) for c in columns]
    f = [c - i for c, i in zip(columns, cell)]
    i = [c.astype(np.int64).astype(np.uint32) for c in cell]
    corners = {}
    with np.errstate(over="ignore"):
        for corner in np.ndindex(*(2,) * len(f)):
            h = hashes.jenkins(*(k + np.uint32(c) for k, c in zip(i, corner)))
            corners[corner] = _gradient(h, [x - np.float32(c) for x, c in zip(f, corner)])
    for x in f:
        u = x * x * x * (x * (x * 6.0 - 15.0) + 10.0)
        rest = {key[1:] for key in corners}
        corners = {key: corners[0, *key] + u * (corners[1, *key] - corners[0, *key]) for key in rest}
    return _SCALE[len(f)] * corners[()]


class _Octaves:
    """Settings of a sum of octaves, each a number or an array over the points."""

    def __init__(self, p, detail, roughness, lacunarity):
        n = len(p)
        self.p = np.asarray(p, np.float32)
        self.detail = np.clip(np.broadcast_to(np.asarray(detail, np.float32), (n,)), 0.0, 15.0)
        self.roughness = np.maximum(np.broadcast_to(np.asarray(roughness, np.float32), (n,)), 0.0)
        self.lacunarity = np.asarray(lacunarity, np.float32)
        self.whole = np.floor(self.detail)
        self.rest = self.detail - self.whole

    def __iter__(self):
        """`(k, signed noise, share)`: the share of octave `k` at each point is 1, or a fraction in the last, or 0 beyond it."""
        scale = np.float32(1.0)
        for k in range(int(np.ceil(self.detail.max())) + 1):
            yield k, perlin(self.p * (scale if np.ndim(scale) == 0 else scale[:, None])), np.where(k <= self.whole, 1.0, np.where(k - 1 < self.detail, self.rest, 0.0))
            scale = scale * self.lacunarity


def fbm(p, detail, roughness, lacunarity, normalize):
    """Octaves added: 0..1 with `normalize`, else signed. A fraction of `detail` mixes in one more octave."""
    octaves = _Octaves(p, detail, roughness, lacunarity)
    amplitude, most, total = np.ones(len(p)), np.zeros(len(p)), np.zeros(len(p))
    out = np.zeros(len(p))
    for _, noise, share in octaves:
        total_more, most_more = total + amplitude * noise, most + amplitude
        here = 0.5 * total_more / most_more + 0.5 if normalize else total_more
        out = np.where(share > 0.0, out + share * (here - out), out)
        total, most, amplitude = total_more, most_more, amplitude * octaves.roughness
    return out.astype(np.float32)


def multifractal(p, detail, roughness, lacunarity, offset, gain):
    """Octaves multiplied."""
    octaves = _Octaves(p, detail, roughness, lacunarity)
    value, power = np.ones(len(p)), np.ones(len(p))
    for _, noise, share in octaves:
        value = np.where(share > 0.0, value * (share * power * noise + 1.0), value)
        power = power * octaves.roughness
    return value.astype(np.float32)


def hetero_terrain(p, detail, roughness, lacunarity, offset, gain):
    """Octaves that are scaled by the height so far."""
    octaves = _Octaves(p, detail, roughness, lacunarity)
    value, power = np.zeros(len(p)), octaves.roughness
    for k, noise, share in octaves:
        if k == 0:
            value = offset + noise
            continue
        value = value + share * (noise + offset) * power * value
        power = power * octaves.roughness
    return np.asarray(value, np.float32)


def hybrid_multifractal(p, detail, roughness, lacunarity, offset, gain):
    """Octaves that are weighted by those before."""
    octaves = _Octaves(p, detail, roughness, lacunarity)
    value, power, weight = np.zeros(len(p)), np.ones(len(p)), np.ones(len(p))
    for _, noise, share in octaves:
        share = np.where(weight > 0.001, share, 0.0)
        weight = np.minimum(weight, 1.0)
        signal = (noise + offset) * power
        value = value + share * weight * signal
        weight = np.where(share > 0.0, weight * gain * signal, weight)
        power = power * octaves.roughness
    return value.astype(np.float32)


def ridged_multifractal(p, detail, roughness, lacunarity, offset, gain):
    """Ridges where the noise crosses zero; a fraction of `detail` counts for nothing."""
    octaves = _Octaves(p, detail, roughness, lacunarity)
    value, power, signal = np.zeros(len(p)), octaves.roughness, np.zeros(len(p))
    for k, noise, share in octaves:
        ridge = (offset - np.abs(noise)) ** 2
        if k == 0:
            value = signal = ridge
            continue
        signal = np.clip(signal * gain, 0.0, 1.0) * ridge
        value = value + np.where(share >= 1.0, signal * power, 0.0)
        power = power * octaves.roughness
    return np.asarray(value, np.float32)


KINDS = {
    "multifractal": multifractal,
    "heteroTerrain": hetero_terrain,
    "hybridMultifractal": hybrid_multifractal,
    "ridgedMultifractal": ridged_multifractal,
}


def _offset(seed, dimensions):
    """Where another, unlike noise is taken: 100..200 along each axis."""
    words = [(seed,)] if dimensions == 1 else [(seed, k) for k in range(dimensions)]
    return np.concatenate([100.0 + 100.0 * hashes.of_floats(*w) for w in words]).astype(np.float32)


def texture(p, kind, detail, roughness, lacunarity, offset, gain, distortion, normalize, wants_color):
    """Blender's Noise Texture at points (n, d), already scaled: (n,), or (n, 3) where its colour is wanted."""
    p = np.asarray(p, np.float32)
    d = p.shape[1]
    if np.any(distortion != 0.0):
        moved = [perlin(p + _offset(k, d)) for k in range(d)]
        p = p + np.stack(moved, axis=-1) * np.reshape(np.asarray(distortion, np.float32), (-1, 1))

    def value(at):
        if kind == "fbm":
            return fbm(at, detail, roughness, lacunarity, normalize)
        return KINDS[kind](at, detail, roughness, lacunarity, offset, gain)

    first = value(p)
    if not wants_color:
        return first
    return np.stack([first, value(p + _offset(d, d)), value(p + _offset(d + 1, d))], axis=-1)
