# SPDX-License-Identifier: GPL-3.0-or-later
"""Registers everything, and takes it away again."""

import bpy

from . import engine, operators, preferences, properties, ui, viewport

_CLASSES = (
    preferences.RAYLOOM_OT_list_devices,
    preferences.RayloomPreferences,
    operators.RAYLOOM_OT_export,
    engine.RayloomRenderEngine,
    *ui.CLASSES,
)


def register():
    """On enabling."""
    properties.register()
    for cls in _CLASSES:
        if cls is engine.RayloomRenderEngine:
            viewport.switch(cls, preferences.preferences().viewport)
        bpy.utils.register_class(cls)
    bpy.types.TOPBAR_MT_file_export.append(operators.menu)
    ui.join_panels()


def unregister():
    """On disabling."""
    ui.leave_panels()
    bpy.types.TOPBAR_MT_file_export.remove(operators.menu)
    for cls in reversed(_CLASSES):
        bpy.utils.unregister_class(cls)
    properties.unregister()
    engine.forget_folder()
