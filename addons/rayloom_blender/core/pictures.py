# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures in memory → PNG (8 or 16 bits) and OpenEXR (32-bit floats, uncompressed), and telling files by their first bytes."""

import struct
import zlib

import numpy as np

_MAGIC = (
    (b"\x89PNG\r\n\x1a\n", "image/png"),
    (b"\xff\xd8\xff", "image/jpeg"),
    (b"\x76\x2f\x31\x01", "image/x-exr"),
    (b"#?RADIANCE", "image/vnd.radiance"),
    (b"#?RGBE", "image/vnd.radiance"),
)
IN_GLTF = {"image/png", "image/jpeg"}


def mime_of(data):
    """Mime type of a picture that is carried as it is; `None` for all others."""
    return next((mime for magic, mime in _MAGIC if bytes(data[: len(magic)]) == magic), None)


def png(pixels, bits=8):
    """A PNG: `pixels` (height, width, 3 or 4) in 0..1 as they are to be stored, top row first."""
    height, width, channels = pixels.shape
    most, kind = (255.0, np.uint8) if bits == 8 else (65535.0, ">u2")
    rows = np.round(np.clip(pixels, 0.0, 1.0) * most).astype(kind).reshape(height, -1).view(np.uint8)
    raw = np.concatenate([np.zeros((height, 1), np.uint8), rows], axis=1).tobytes()

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", width, height, bits, 2 if channels == 3 else 6, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(raw, 1)) + chunk(b"IEND", b"")


def exr(pixels):
    """An OpenEXR of 32-bit floats: `pixels` (height, width, 1, 3 or 4), top row first. Source: the OpenEXR file layout."""
    height, width, channels = pixels.shape
    order = {1: [("Y", 0)], 3: [("B", 2), ("G", 1), ("R", 0)], 4: [("A", 3), ("B", 2), ("G", 1), ("R", 0)]}[channels]

    def attribute(name, kind, data):
        return name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<I", len(data)) + data

    channel_list = b"".join(n.encode() + b"\0" + struct.pack("<IB3xII", 2, 0, 1, 1) for n, _ in order) + b"\0"
    box = struct.pack("<4i", 0, 0, width - 1, height - 1)
    head = struct.pack("<II", 20000630, 2) + b"".join(
        (
            attribute("channels", "chlist", channel_list),
            attribute("compression", "compression", b"\0"),
            attribute("dataWindow", "box2i", box),
            attribute("displayWindow", "box2i", box),
            attribute("lineOrder", "lineOrder", b"\0"),
            attribute("pixelAspectRatio", "float", struct.pack("<f", 1.0)),
            attribute("screenWindowCenter", "v2f", struct.pack("<2f", 0.0, 0.0)),
            attribute("screenWindowWidth", "float", struct.pack("<f", 1.0)),
            b"\0",
        )
    )
    row_bytes = 4 * width * channels
    first = len(head) + 8 * height
    offsets = np.arange(height, dtype=np.uint64) * np.uint64(8 + row_bytes) + np.uint64(first)
    planar = np.ascontiguousarray(np.stack([pixels[:, :, k] for _, k in order], axis=1), np.float32)  # height, channel, width
    lines = np.empty((height, 8 + row_bytes), np.uint8)
    lines[:, :4] = np.arange(height, dtype=np.int32)[:, None].view(np.uint8)
    lines[:, 4:8] = np.frombuffer(struct.pack("<I", row_bytes), np.uint8)
    lines[:, 8:] = planar.reshape(height, -1).view(np.uint8)
    return head + offsets.tobytes() + lines.tobytes()
