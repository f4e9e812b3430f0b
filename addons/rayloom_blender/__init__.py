# SPDX-License-Identifier: GPL-3.0-or-later
"""Rayloom for Blender: a render engine that starts the `rayloom` program. How it is built: README.md in the folder above."""


def register():
    """Called by Blender."""
    from . import addon

    addon.register()


def unregister():
    """Called by Blender."""
    from . import addon

    addon.unregister()
