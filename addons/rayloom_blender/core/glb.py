# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes glTF 2.0: JSON and numpy arrays to one binary file, or to a .gltf whose buffers are kept from frame to frame."""

import hashlib
import json
import os
import struct

import numpy as np

COMPONENT = {np.dtype(np.float32): 5126, np.dtype(np.uint32): 5125, np.dtype(np.uint16): 5123, np.dtype(np.uint8): 5121}
KIND = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4", 16: "MAT4"}
ARRAY_BUFFER, ELEMENT_ARRAY_BUFFER = 34962, 34963
# Smaller buffers are not worth a file of their own.
SHARED_BELOW = 1 << 16


def _json(document):
    return json.dumps(document, ensure_ascii=False, separators=(",", ":"), allow_nan=False).encode("utf-8")


def _replace(path, write):
    """Writes beside, then renames: a reader never sees half a file."""
    beside = f"{path}.{os.getpid()}.part"
    try:
        with open(beside, "wb") as file:
            write(file)
        os.replace(beside, path)
    except BaseException:
        if os.path.exists(beside):
            os.unlink(beside)
        raise


class Gltf:
    """A glTF document under construction.

    `keep`: a folder for buffers that outlive the frame. Buffers from 64 KiB on are then files named after their content, written only if
    they are not there yet; what is left goes into one more.
    """

    def __init__(self, generator, keep=None):
        self.document = {"asset": {"version": "2.0", "generator": generator}}
        self.keep = keep
        self.written_bytes = 0
        self.kept_bytes = 0
        self.kept_files = set()
        self._views = []  # (bytes-like, target)

    def append(self, table, record):
        """Adds a record to a table of the document; its index."""
        rows = self.document.setdefault(table, [])
        rows.append(record)
        return len(rows) - 1

    def view(self, data, target=None):
        """A buffer view of bytes or of a contiguous array; its index."""
        self._views.append((memoryview(data).cast("B") if len(data) else b"", target))
        return len(self._views) - 1

    def accessor(self, array, target=None, bounds=False, normalized=False):
        """An accessor over a contiguous array of shape (n,) or (n, k); its index. Positions need `bounds`."""
        array = np.ascontiguousarray(array)
        count = array.shape[0]
        width = 1 if array.ndim == 1 else array.shape[1]
        record = {"componentType": COMPONENT[array.dtype], "count": count, "type": KIND[width]}
        if count:
            record["bufferView"] = self.view(array.reshape(-1), target)
        if normalized:
            record["normalized"] = True
        if bounds and count:
            # float() of a float32 prints all its digits, which readers compare to.
            record["min"] = [float(v) for v in np.atleast_1d(array.min(axis=0))]
            record["max"] = [float(v) for v in np.atleast_1d(array.max(axis=0))]
        return self.append("accessors", record)

    def image(self, data, mime, name):
        """A picture that lies in the buffer as it is; its index."""
        return self.append("images", {"bufferView": self.view(data), "mimeType": mime, "name": name})

    def use_extension(self, name):
        """Notes that the document uses an extension."""
        used = self.document.setdefault("extensionsUsed", [])
        if name not in used:
            used.append(name)

    def write(self, path):
        """Writes a .glb, or with `keep` a .gltf beside the kept buffers."""
        if self.keep:
            self._write_kept(path)
        else:
            self._write_binary(path)

    def _write_binary(self, path):
        views, offset, pieces = [], 0, []
        for data, target in self._views:
            views.append(_view_record(0, offset, len(data), target))
            pieces.append(data)
            pad = -len(data) % 4
            if pad:
                pieces.append(b"\0" * pad)
            offset += len(data) + pad
        if views:
            self.document["bufferViews"] = views
            self.document["buffers"] = [{"byteLength": offset}]
        text = _json(self.document)
        text += b" " * (-len(text) % 4)
        length = 12 + 8 + len(text) + (8 + offset if views else 0)
        if length >= 1 << 32:
            raise ValueError("the scene needs more than the 4 GiB that a .glb can hold")

        def write(file):
            file.write(struct.pack("<4sII", b"glTF", 2, length))
            file.write(struct.pack("<I4s", len(text), b"JSON") + text)
            if views:
                file.write(struct.pack("<I4s", offset, b"BIN\0"))
                file.writelines(pieces)

        _replace(path, write)
        self.written_bytes = length

    def _write_kept(self, path):
        os.makedirs(self.keep, exist_ok=True)
        buffers, views, rest, rest_length = [], [], [], 0
        by_name = {}
        for data, target in self._views:
            if len(data) < SHARED_BELOW:
                views.append(("rest", rest_length, len(data), target))
                rest.append(bytes(data) + b"\0" * (-len(data) % 4))
                rest_length += len(rest[-1])
                continue
            name = hashlib.blake2b(data, digest_size=16).hexdigest() + ".bin"
            if name not in by_name:
                by_name[name] = len(buffers)
                buffers.append({"uri": self._uri(path, name), "byteLength": len(data)})
                self._keep(name, data)
            views.append((by_name[name], 0, len(data), target))
        if rest:
            blob = b"".join(rest)
            name = hashlib.blake2b(blob, digest_size=16).hexdigest() + ".bin"
            self._keep(name, blob)
            buffers.append({"uri": self._uri(path, name), "byteLength": len(blob)})
        if views:
            self.document["buffers"] = buffers
            last = len(buffers) - 1
            self.document["bufferViews"] = [_view_record(last if b == "rest" else b, o, n, t) for b, o, n, t in views]
        text = _json(self.document)
        _replace(path, lambda file: file.write(text))
        self.written_bytes += len(text)

    def _uri(self, path, name):
        relative = os.path.relpath(os.path.join(self.keep, name), os.path.dirname(os.path.abspath(path)))
        return relative.replace(os.sep, "/").replace("%", "%25").replace(" ", "%20")

    def _keep(self, name, data):
        self.kept_files.add(name)
        where = os.path.join(self.keep, name)
        if os.path.exists(where) and os.path.getsize(where) == len(data):
            self.kept_bytes += len(data)
            return
        _replace(where, lambda file: file.write(data))
        self.written_bytes += len(data)


def _view_record(buffer, offset, length, target):
    record = {"buffer": buffer, "byteOffset": offset, "byteLength": length}
    if target:
        record["target"] = target
    return record
