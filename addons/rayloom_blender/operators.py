# SPDX-License-Identifier: GPL-3.0-or-later
"""File > Export > Rayloom Scene."""

import bpy
from bpy_extras.io_utils import ExportHelper

from .core import log
from .exporting import export_scene


class RAYLOOM_OT_export(bpy.types.Operator, ExportHelper):
    """Write the scene as it would render to a glTF file with RAYLOOM_scene"""

    bl_idname = "export_scene.rayloom"
    bl_label = "Export Rayloom Scene"
    filename_ext = ".glb"
    filter_glob: bpy.props.StringProperty(default="*.glb", options={"HIDDEN"})

    def execute(self, context):
        """Does it; what was left out is in the log panel."""
        log.clear()
        try:
            exporter = export_scene(self.filepath, context.scene)
        except Exception as e:
            self.report({"ERROR"}, f"Nothing was written: {e}")
            return {"CANCELLED"}
        for owner, what in exporter.log.entries:
            log.add("warning", owner, what)
            self.report({"WARNING"}, f"{owner}: {what}")
        return {"FINISHED"}


def menu(self, context):
    """Entry of the export menu."""
    self.layout.operator(RAYLOOM_OT_export.bl_idname, text="Rayloom Scene (.glb)")
