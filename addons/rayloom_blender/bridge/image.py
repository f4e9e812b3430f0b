# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures: their files as they are where that is possible, else as PNG or OpenEXR."""

import os

import bpy
import numpy as np

from ..core import pictures
from ..core.values import srgb_to_linear

_SPACES = {"sRGB": "srgb", "Non-Color": "nonColor", "Linear Rec.709": "linear", "Linear": "linear", "Raw": "nonColor"}


class Images:
    """The pictures of one export, each written once."""

    def __init__(self, gltf):
        self.gltf = gltf
        self.records = []
        self.sources = {}  # index → bpy image, for baking
        self._known = {}

    def add(self, name, data, mime, color_space, alpha):
        """A picture's bytes as a record of the file; its index."""
        record = {"name": name, "colorSpace": color_space, "alpha": alpha}
        if mime in pictures.IN_GLTF:
            record["source"] = self.gltf.image(data, mime, name)
        else:
            record["bufferView"] = self.gltf.view(data)
            record["mimeType"] = mime
        self.records.append(record)
        return len(self.records) - 1


def _frame_path(image, user):
    """The file that shows at the user's frame."""
    path = image.filepath_from_user(image_user=user) if user and image.source in {"SEQUENCE", "MOVIE"} else image.filepath_from_user()
    return bpy.path.abspath(path, library=image.library)


def _file_bytes(image, user):
    """The picture's file, packed or on disk; `None` where there is none."""
    if image.packed_file is not None and not image.is_dirty:
        return bytes(image.packed_file.data)
    if image.source in {"FILE", "SEQUENCE"} and not image.is_dirty:
        path = _frame_path(image, user)
        if os.path.isfile(path):
            with open(path, "rb") as file:
                return file.read()
    return None


def pixels_of(image):
    """Pixels as Blender holds them, (height, width, 4), top row first; `None` where it has none."""
    width, height = image.size
    if not (width and height) or len(image.pixels) != width * height * image.channels:
        return None
    flat = np.empty(len(image.pixels), np.float32)
    image.pixels.foreach_get(flat)
    own = flat.reshape(height, width, image.channels)[::-1]
    if image.channels == 4:
        return own
    out = np.ones((height, width, 4), np.float32)
    out[..., :3] = own[..., :3] if image.channels == 3 else own[..., :1]
    return out


def linear_pixels(images, ix):
    """Linear pixels of a picture of the file, for baking; `None` where it has none."""
    source = images.sources.get(ix)
    pixels = pixels_of(source) if source is not None else None
    if pixels is None or source.is_float or images.records[ix]["colorSpace"] != "srgb":
        return pixels
    return np.concatenate([srgb_to_linear(pixels[..., :3]), pixels[..., 3:]], axis=-1)


def pick_image(images, image, user, log):
    """Index of a picture in the file; `None` where it is missing, which is told."""
    if images is None:
        return None
    original = image.original if image.is_evaluated else image
    frame = user.frame_current if user and image.source in {"SEQUENCE", "MOVIE"} else 0
    key = (original.as_pointer(), frame)
    if key in images._known:
        return images._known[key]
    images._known[key] = None
    if image.source == "TILED":
        log(f"only the first tile of the picture '{image.name}' is used")
    data = _file_bytes(image, user)
    mime = pictures.mime_of(data) if data else None
    is_float = image.is_float
    if mime is None:
        pixels = pixels_of(original)
        if pixels is None:
            log(f"the picture '{image.name}' is missing ({_frame_path(image, user) or 'no file'}); it shows pink")
            return None
        mime = "image/x-exr" if is_float else "image/png"
        data = pictures.exr(pixels) if is_float else pictures.png(pixels)
    space = _SPACES.get(image.colorspace_settings.name, image.colorspace_settings.name)
    alpha = {"STRAIGHT": "straight", "PREMUL": "premultiplied", "CHANNEL_PACKED": "channelPacked", "NONE": "none"}[image.alpha_mode]
    ix = images.add(image.name, data, mime, space, alpha)
    images._known[key] = ix
    images.sources[ix] = original
    return ix
