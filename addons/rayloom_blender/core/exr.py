# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads the OpenEXR files that the renderer writes: one part, scan lines or tiles of one level, uncompressed or ZIP, halves, floats and unsigned integers.

Source: the OpenEXR file layout (openexr.com, "OpenEXR File Layout").
"""

import struct
import zlib

import numpy as np

_TYPES = {0: np.dtype("<u4"), 1: np.dtype("<f2"), 2: np.dtype("<f4")}
_LINES = {0: 1, 2: 1, 3: 16}


class Unreadable(ValueError):
    """The file is damaged, or of a kind that the renderer does not write."""


class Picture:
    """Channels by name over the display window, `(height, width)` each, top row first; outside of the data window they are 0."""

    def __init__(self, width, height, channels, attributes):
        self.width, self.height, self.channels, self.attributes = width, height, channels, attributes

    def layers(self):
        """Passes: `{"": {"R": …}, "Depth": {"Z": …}}`, by what stands before the last dot of a channel's name."""
        out = {}
        for name, values in self.channels.items():
            layer, _, channel = name.rpartition(".")
            out.setdefault(layer, {})[channel] = values
        return out


def _text(data, at):
    end = data.index(b"\0", at)
    return data[at:end].decode("latin-1"), end + 1


def _header(data):
    attributes, at = {}, 8
    while data[at]:
        name, at = _text(data, at)
        kind, at = _text(data, at)
        size = struct.unpack_from("<I", data, at)[0]
        attributes[name] = (kind, data[at + 4 : at + 4 + size])
        at += 4 + size
    return attributes, at + 1


def _channels(data):
    out, at = [], 0
    while data[at]:
        name, at = _text(data, at)
        kind, _, x, y = struct.unpack_from("<IB3xII", data, at)
        if kind not in _TYPES or (x, y) != (1, 1):
            raise Unreadable(f"channel {name} is subsampled or of an unknown type")
        out.append((name, _TYPES[kind]))
        at += 16
    return out


def _unzip(packed, size):
    """Undoes ZIP: inflate, add up the differences, weave the halves together."""
    if len(packed) == size:
        return np.frombuffer(packed, np.uint8)
    raw = np.frombuffer(zlib.decompress(packed), np.uint8).astype(np.int64)
    if len(raw) != size:
        raise Unreadable("a block is of the wrong length")
    raw[1:] -= 128
    raw = np.cumsum(raw).astype(np.uint8)
    out = np.empty(size, np.uint8)
    half = (size + 1) // 2
    out[0::2], out[1::2] = raw[:half], raw[half:]
    return out


def read(path):
    """The [`Picture`] of a file; raises [`Unreadable`] and OSError."""
    with open(path, "rb") as file:
        data = file.read()
    try:
        return _read(data)
    except Unreadable:
        raise
    except (struct.error, IndexError, KeyError, ValueError, zlib.error) as e:
        raise Unreadable(f"{path}: {e}") from e


def _blocks(attributes, tiled, box, lines):
    """How many blocks there are, the length of a block's own header, and where such a block lies: `(row, column, rows, columns)`."""
    x0, y0, x1, y1 = box
    width, height = x1 - x0 + 1, y1 - y0 + 1
    if not tiled:

        def scan_lines(words):
            row = words[0] - y0
            return row, 0, min(lines, height - row), width

        return -(-height // lines), "<i", scan_lines
    tile_width, tile_height, mode = struct.unpack("<IIB", attributes["tiles"][1])
    if mode & 0xF:
        raise Unreadable("files of several levels are not read")

    def tile(words):
        row, column = words[1] * tile_height, words[0] * tile_width
        return row, column, min(tile_height, height - row), min(tile_width, width - column)

    return -(-width // tile_width) * -(-height // tile_height), "<4i", tile


def _read(data):
    magic, version = struct.unpack_from("<II", data, 0)
    if magic != 20000630 or version & 0xFF != 2 or version & 0x1800:
        raise Unreadable("it is no OpenEXR of one flat part")
    attributes, at = _header(data)
    channels = _channels(attributes["channels"][1])
    compression = attributes["compression"][1][0]
    if compression not in _LINES:
        raise Unreadable(f"compression {compression} is not read")
    box = x0, y0, x1, y1 = struct.unpack("<4i", attributes["dataWindow"][1])
    dx0, dy0, dx1, dy1 = struct.unpack("<4i", attributes["displayWindow"][1])
    n_blocks, words, place = _blocks(attributes, bool(version & 0x200), box, _LINES[compression])
    planes = {name: np.zeros((y1 - y0 + 1, x1 - x0 + 1), kind) for name, kind in channels}
    pixel = sum(kind.itemsize for _, kind in channels)
    for offset in struct.unpack_from(f"<{n_blocks}Q", data, at):
        row, column, rows, columns = place(struct.unpack_from(words, data, offset))
        start = offset + struct.calcsize(words)
        size = struct.unpack_from("<i", data, start)[0]
        block = data[start + 4 : start + 4 + size]
        raw = np.frombuffer(block, np.uint8) if compression == 0 else _unzip(block, rows * columns * pixel)
        raw = raw.reshape(rows, -1)
        start = 0
        for name, kind in channels:
            end = start + columns * kind.itemsize
            planes[name][row : row + rows, column : column + columns] = np.ascontiguousarray(raw[:, start:end]).view(kind)
            start = end
    size = (dy1 - dy0 + 1, dx1 - dx0 + 1)
    out = {}
    for name, plane in planes.items():
        values = plane.astype(np.float32)
        if box != (dx0, dy0, dx1, dy1):
            whole = np.zeros(size, np.float32)
            whole[y0 - dy0 : y1 - dy0 + 1, x0 - dx0 : x1 - dx0 + 1] = values
            values = whole
        out[name] = values
    return Picture(size[1], size[0], out, {name: value for name, (_, value) in attributes.items()})
