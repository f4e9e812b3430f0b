# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's own Open Image Denoise: the renderer loads it, so that a picture is denoised by what denoises Cycles' pictures."""

import os
import sys

_NAMES = {
    "win32": ("OpenImageDenoise.dll",),
    "darwin": ("libOpenImageDenoise.2.dylib", "libOpenImageDenoise.dylib"),
}
_OTHERS = ("libOpenImageDenoise.so.2", "libOpenImageDenoise.so")


def folders(root, binary_path=""):
    """Where Blender keeps its libraries. `root` is the folder that its own resources lie in: that of the program on Linux and Windows, `Resources`
    of the bundle on macOS, the package of the `bpy` module."""
    out = []
    for folder in (root, os.path.dirname(os.path.realpath(binary_path)) if binary_path else ""):
        if folder:
            out += [os.path.join(folder, "lib"), os.path.join(folder, "blender.shared"), folder]
    return out


def find(root, binary_path=""):
    """The path of the library; `None` where Blender has none (Linux distributions build it without)."""
    names = _NAMES.get(sys.platform, _OTHERS)
    for folder in folders(root, binary_path):
        for name in names:
            path = os.path.join(folder, name)
            if os.path.isfile(path):
                return path
    return None
