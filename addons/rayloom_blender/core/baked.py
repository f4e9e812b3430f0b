# SPDX-License-Identifier: GPL-3.0-or-later
"""Baked pictures from one export to the next: frames of an animation bake again only what changed."""

import hashlib
import threading
from collections import OrderedDict

import numpy as np

# Bytes of pictures that are kept. Picked by feel.
MOST = 256 << 20

_lock = threading.Lock()
_kept = OrderedDict()


def key_of(*parts):
    """A digest of arrays and of what `repr` tells."""
    digest = hashlib.blake2b(digest_size=16)
    for part in parts:
        if isinstance(part, np.ndarray):
            digest.update(repr((part.shape, part.dtype.str)).encode())
            digest.update(np.ascontiguousarray(part).view(np.uint8).ravel())
        else:
            digest.update(repr(part).encode())
    return digest.digest()


def find(key):
    """The picture's file that was kept by a key, or `None`."""
    with _lock:
        if key not in _kept:
            return None
        _kept.move_to_end(key)
        return _kept[key]


def keep(key, data):
    """Keeps a file; those that were used longest ago go."""
    with _lock:
        _kept[key] = data
        total = sum(len(d) for d, *_ in _kept.values())
        while total > MOST and len(_kept) > 1:
            total -= len(_kept.popitem(last=False)[1][0])


def forget():
    """Forgets all."""
    with _lock:
        _kept.clear()
