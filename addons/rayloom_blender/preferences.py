# SPDX-License-Identifier: GPL-3.0-or-later
"""The add-on's preferences: which renderer, which machines there are."""

import bpy

from .core import program

PACKAGE = __package__


class RAYLOOM_OT_list_devices(bpy.types.Operator):
    """Ask the renderer for the machines that it can render on"""

    bl_idname = "rayloom.list_devices"
    bl_label = "List Devices"

    def execute(self, context):
        """Fills the list of the preferences."""
        prefs = preferences()
        try:
            found = program.devices(program.checked(prefs.program_path), again=True)
        except program.ProgramError as e:
            self.report({"ERROR"}, str(e))
            return {"CANCELLED"}
        prefs.devices = "\n".join(f"{kind.upper()}: {name}" for kind, name in found)
        return {"FINISHED"}


def _switch_viewport(on):
    from . import engine, viewport

    viewport.again(engine.RayloomRenderEngine, on)


class RayloomPreferences(bpy.types.AddonPreferences):
    """Of the add-on."""

    bl_idname = PACKAGE

    program_path: bpy.props.StringProperty(
        name="Renderer",
        description="The program 'rayloom'; empty: the one that comes with the add-on, else the one on the search path",
        subtype="FILE_PATH",
    )
    viewport: bpy.props.BoolProperty(
        name="Render in the Viewport (experimental)",
        description="Rendered mode of the viewport shows the engine's own pictures. Nobody has seen this in a window yet; without it the mode stays empty",
        default=False,
        update=lambda self, context: _switch_viewport(self.viewport),
    )
    devices: bpy.props.StringProperty(options={"HIDDEN", "SKIP_SAVE"})

    def draw(self, context):
        """The panel."""
        layout = self.layout
        layout.prop(self, "program_path")
        try:
            layout.label(text=f"Uses {program.find(self.program_path)}", icon="CHECKMARK")
        except program.ProgramError as e:
            layout.label(text=str(e), icon="ERROR")
        layout.prop(self, "viewport")
        layout.operator(RAYLOOM_OT_list_devices.bl_idname)
        for line in filter(None, self.devices.split("\n")):
            layout.label(text=line)


class _Defaults:
    """Preferences of an add-on that is not installed as one (tests)."""

    program_path = ""
    viewport = False


def preferences():
    """The preferences that count."""
    addon = bpy.context.preferences.addons.get(PACKAGE) if bpy.context.preferences else None
    return addon.preferences if addon and addon.preferences else _Defaults
