# SPDX-License-Identifier: GPL-3.0-or-later
"""Panels, where Cycles' sit, and the panels of Blender and of Cycles that apply."""

import os

import bpy

from .bridge.settings import settings_of
from .core import denoiser, log

ENGINE = "RAYLOOM"

# Panels that every engine shares but that mean something else here.
_EXCLUDED = {
    "VIEWLAYER_PT_filter",
    "VIEWLAYER_PT_layer_passes",
    "RENDER_PT_freestyle",
    "RENDER_PT_gpencil",
    "RENDER_PT_simplify",
}
# Cycles' panels that show what is exported as it is: materials, lamps, world, visibility.
_OF_CYCLES = ("CYCLES_MATERIAL_PT", "CYCLES_LIGHT_PT", "CYCLES_WORLD_PT", "CYCLES_OBJECT_PT_visibility", "CYCLES_CAMERA_PT", "CYCLES_VIEW_LAYER_PT_passes")

_changed = []


class _Panel:
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "render"
    COMPAT_ENGINES = {ENGINE}

    @classmethod
    def poll(cls, context):
        return context.engine in cls.COMPAT_ENGINES

    def props(self, context, *names):
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        settings = settings_of(context.scene)
        column = layout.column()
        for name in names:
            column.prop(settings, name)
        return column


class RAYLOOM_RENDER_PT_device(_Panel, bpy.types.Panel):
    """Device."""

    bl_label = "Rayloom"
    bl_options = {"HIDE_HEADER"}
    bl_order = -10

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        own = context.scene.rayloom
        layout.prop(own, "device")
        if own.device == "GPU":
            layout.prop(own, "gpu")
        layout.prop(own, "integrator")
        layout.prop(own, "accelerator")
        if hasattr(context.scene, "cycles"):
            layout.prop(own, "follow_cycles")


class RAYLOOM_RENDER_PT_sampling(_Panel, bpy.types.Panel):
    """Sampling."""

    bl_label = "Sampling"

    def draw(self, context):
        settings = settings_of(context.scene)
        column = self.props(context, "samples", "time_limit", "seed", "use_animated_seed", "use_adaptive_sampling")
        if settings.use_adaptive_sampling:
            column.prop(settings, "adaptive_threshold")
            column.prop(settings, "adaptive_min_samples")


class RAYLOOM_RENDER_PT_denoise(_Panel, bpy.types.Panel):
    """Denoise."""

    bl_label = "Denoise"
    bl_parent_id = "RAYLOOM_RENDER_PT_sampling"
    bl_options = {"DEFAULT_CLOSED"}

    def draw_header(self, context):
        self.layout.prop(settings_of(context.scene), "use_denoising", text="")

    def draw(self, context):
        settings = settings_of(context.scene)
        column = self.props(context, "denoising_input_passes")
        column.active = settings.use_denoising
        if settings.denoising_input_passes != "RGB":
            column.prop(settings, "denoising_prefilter")
        if hasattr(settings, "denoising_quality"):
            column.prop(settings, "denoising_quality")
        if denoiser.find(os.path.dirname(bpy.utils.resource_path("LOCAL")), bpy.app.binary_path) is None:
            column.label(text="This Blender has no Open Image Denoise", icon="ERROR")


class RAYLOOM_RENDER_PT_light_paths(_Panel, bpy.types.Panel):
    """Light paths."""

    bl_label = "Light Paths"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        bounces = ("max_bounces", "diffuse_bounces", "glossy_bounces", "transmission_bounces", "volume_bounces", "transparent_max_bounces")
        self.props(context, *bounces)


class RAYLOOM_RENDER_PT_clamping(_Panel, bpy.types.Panel):
    """Clamping."""

    bl_label = "Clamping"
    bl_parent_id = "RAYLOOM_RENDER_PT_light_paths"

    def draw(self, context):
        self.props(context, "sample_clamp_direct", "sample_clamp_indirect")


class RAYLOOM_RENDER_PT_caustics(_Panel, bpy.types.Panel):
    """Caustics."""

    bl_label = "Caustics"
    bl_parent_id = "RAYLOOM_RENDER_PT_light_paths"

    def draw(self, context):
        self.props(context, "blur_glossy", "caustics_reflective", "caustics_refractive")


class RAYLOOM_RENDER_PT_film(_Panel, bpy.types.Panel):
    """Film."""

    bl_label = "Film"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        column = self.props(context, "film_exposure", "pixel_filter_type")
        settings = settings_of(context.scene)
        if settings.pixel_filter_type != "BOX":
            column.prop(settings, "filter_width")
        column.prop(context.scene.render, "film_transparent")


class RAYLOOM_RENDER_PT_motion_blur(_Panel, bpy.types.Panel):
    """Motion blur."""

    bl_label = "Motion Blur"
    bl_options = {"DEFAULT_CLOSED"}

    def draw_header(self, context):
        self.layout.prop(context.scene.render, "use_motion_blur", text="")

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        render = context.scene.render
        layout.active = render.use_motion_blur
        layout.prop(render if hasattr(render, "motion_blur_position") else settings_of(context.scene), "motion_blur_position")
        layout.prop(render, "motion_blur_shutter")


class RAYLOOM_RENDER_PT_performance(_Panel, bpy.types.Panel):
    """Performance."""

    bl_label = "Performance"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        layout.prop(context.scene.render, "threads_mode")
        if context.scene.render.threads_mode == "FIXED":
            layout.prop(context.scene.render, "threads")


class RAYLOOM_RENDER_PT_log(_Panel, bpy.types.Panel):
    """What the last render ignored or approximated."""

    bl_label = "Log"

    def draw(self, context):
        column = self.layout.column(align=True)
        entries = log.entries()
        if not entries:
            column.label(text="Nothing was ignored")
        icons = {"error": "CANCEL", "warning": "ERROR", "note": "INFO"}
        for level, owner, text in entries[-60:]:
            column.label(text=f"{owner}: {text}" if owner else text, icon=icons[level])
        if entries:
            self.layout.operator("rayloom.copy_log")


class RAYLOOM_OT_copy_log(bpy.types.Operator):
    """Copy the whole log to the clipboard"""

    bl_idname = "rayloom.copy_log"
    bl_label = "Copy Log"

    def execute(self, context):
        """Does it."""
        context.window_manager.clipboard = "\n".join(f"{level}: {owner}{': ' if owner else ''}{text}" for level, owner, text in log.entries())
        return {"FINISHED"}


CLASSES = (
    RAYLOOM_OT_copy_log,
    RAYLOOM_RENDER_PT_device,
    RAYLOOM_RENDER_PT_sampling,
    RAYLOOM_RENDER_PT_denoise,
    RAYLOOM_RENDER_PT_light_paths,
    RAYLOOM_RENDER_PT_clamping,
    RAYLOOM_RENDER_PT_caustics,
    RAYLOOM_RENDER_PT_film,
    RAYLOOM_RENDER_PT_motion_blur,
    RAYLOOM_RENDER_PT_performance,
    RAYLOOM_RENDER_PT_log,
)


def _all_panels(cls=bpy.types.Panel):
    for panel in cls.__subclasses__():
        yield panel
        yield from _all_panels(panel)


def join_panels():
    """Adds the engine to the panels that apply. Sets that classes share are not touched: each class gets its own."""
    for panel in set(_all_panels()):
        engines = getattr(panel, "COMPAT_ENGINES", None)
        name = panel.__name__
        if not isinstance(engines, (set, frozenset)) or ENGINE in engines or name in _EXCLUDED:
            continue
        if "BLENDER_RENDER" in engines or (engines == {"CYCLES"} and name.startswith(_OF_CYCLES)):
            _changed.append((panel, "COMPAT_ENGINES" in panel.__dict__, engines))
            panel.COMPAT_ENGINES = set(engines) | {ENGINE}


def leave_panels():
    """Gives them back as they were."""
    for panel, own, engines in _changed:
        if own:
            panel.COMPAT_ENGINES = engines
        elif "COMPAT_ENGINES" in panel.__dict__:
            del panel.COMPAT_ENGINES
    _changed.clear()
