# SPDX-License-Identifier: GPL-3.0-or-later
"""Exports without rendering. Only a render engine gets what renders (render visibility, render levels of modifiers), so for the moment of the
export one stands in."""

import traceback

import bpy

from .bridge.scene import Exporter
from .core.schema import VERSION


def generator():
    """How files name their writer."""
    return f"rayloom_blender, RAYLOOM_scene {VERSION}, Blender {bpy.app.version_string}"


class _Request:
    """What the stand-in is asked for, and what came of it."""

    path = None
    exporter = None
    error = None


class RAYLOOM_OT_stand_in(bpy.types.RenderEngine):
    """Exports in place of rendering."""

    bl_idname = "RAYLOOM_EXPORT"
    bl_label = "Rayloom Export"

    def render(self, depsgraph):
        """Writes the file of the first view layer."""
        if _Request.exporter is not None or _Request.error is not None:
            return
        try:
            exporter = Exporter(depsgraph, generator())
            exporter.export(_Request.path, lambda frame, sub: self.frame_set(frame, subframe=sub))
            _Request.exporter = exporter
        except Exception as e:  # told by the caller: what leaves here is swallowed by Blender
            traceback.print_exc()
            _Request.error = e


def export_scene(path, scene=None):
    """Writes the scene as it would render at its frame; the exporter, with its log. Raises what went wrong."""
    scene = scene or bpy.context.scene
    render = scene.render
    kept = {k: getattr(render, k) for k in ("engine", "use_compositing", "use_sequencer", "use_lock_interface")}
    _Request.path, _Request.exporter, _Request.error = path, None, None
    bpy.utils.register_class(RAYLOOM_OT_stand_in)
    try:
        render.engine = "RAYLOOM_EXPORT"
        render.use_compositing = render.use_sequencer = False
        bpy.ops.render.render(scene=scene.name)
    finally:
        # Older engines may be gone from the list: the file keeps its word for them.
        for key, value in kept.items():
            setattr(render, key, value)
        bpy.utils.unregister_class(RAYLOOM_OT_stand_in)
    if _Request.error is not None:
        raise _Request.error
    if _Request.exporter is None:
        raise RuntimeError("Blender did not render the scene; is a view layer enabled for rendering?")
    return _Request.exporter
