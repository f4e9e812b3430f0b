# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings of a scene. They have Cycles' names and defaults, so that one can stand for the other."""

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, StringProperty

from .core import program
from .preferences import preferences


def gpu_names():
    """The GPUs that the renderer finds, without what is in brackets behind their names; none while there is no renderer."""
    try:
        found = program.devices(program.checked(preferences().program_path))
    except program.ProgramError:
        return []
    return [name.partition(" (")[0] for kind, name in found if kind == "gpu"]


class RayloomSettings(bpy.types.PropertyGroup):
    """`scene.rayloom`."""

    follow_cycles: BoolProperty(
        name="Use Cycles' Settings",
        description="Samples, bounces, clamps and film as the scene has them for Cycles, so that switching the engine changes nothing else",
        default=True,
    )
    device: EnumProperty(
        name="Device",
        items=[
            ("AUTO", "Automatic", "The GPU when there is one that can render the scene, else the CPU"),
            ("CPU", "CPU", "All cores, or as many threads as the scene says"),
            ("GPU", "GPU", "The GPU below, else the first one"),
        ],
        default="AUTO",
    )
    gpu: StringProperty(
        name="GPU",
        description="A GPU by a part of its name; empty: the first one",
        search=lambda self, context, text: [name for name in gpu_names() if text.lower() in name.lower()],
        search_options={"SUGGESTION"},
    )
    integrator: EnumProperty(
        name="Integrator",
        items=[
            ("PATH", "Path Tracing", "Light as in Cycles"),
            ("CLASSIC", "Classic", "POV-Ray's light transport: direct light, mirrors and glass; fast and rough"),
        ],
        default="PATH",
    )
    accelerator: EnumProperty(
        name="Accelerator",
        items=[("AUTO", "Automatic", "What is fastest on the device"), ("BVH", "BVH", ""), ("KD", "kd-Tree", "")],
        default="AUTO",
    )
    samples: IntProperty(name="Max Samples", default=1024, min=1, max=1 << 20)
    seed: IntProperty(name="Seed", default=0, min=0)
    use_animated_seed: BoolProperty(name="Animate Seed", default=False)
    use_adaptive_sampling: BoolProperty(name="Noise Threshold", default=True)
    adaptive_threshold: FloatProperty(name="Noise Threshold", default=0.01, min=0.0, max=1.0, precision=4)
    adaptive_min_samples: IntProperty(name="Min Samples", default=0, min=0)
    time_limit: FloatProperty(name="Time Limit", default=0.0, min=0.0, unit="TIME_ABSOLUTE")
    use_denoising: BoolProperty(name="Denoise", description="Denoise the finished picture with Intel Open Image Denoise, which Blender brings", default=False)
    denoising_input_passes: EnumProperty(
        name="Passes",
        description="What guides the denoiser besides the colours",
        items=[("RGB", "None", "Colours alone"), ("RGB_ALBEDO", "Albedo", ""), ("RGB_ALBEDO_NORMAL", "Albedo and Normal", "")],
        default="RGB_ALBEDO_NORMAL",
    )
    denoising_prefilter: EnumProperty(
        name="Prefilter",
        description="What is done about noise in the guides",
        items=[
            ("NONE", "None", "They are taken for clean"),
            ("FAST", "Fast", "They are denoised with the colours"),
            ("ACCURATE", "Accurate", "They are denoised first"),
        ],
        default="ACCURATE",
    )
    denoising_quality: EnumProperty(
        name="Quality",
        items=[("HIGH", "High", ""), ("BALANCED", "Balanced", ""), ("FAST", "Fast", "")],
        default="HIGH",
    )
    max_bounces: IntProperty(name="Total", default=12, min=0, max=1024)
    diffuse_bounces: IntProperty(name="Diffuse", default=4, min=0, max=1024)
    glossy_bounces: IntProperty(name="Glossy", default=4, min=0, max=1024)
    transmission_bounces: IntProperty(name="Transmission", default=12, min=0, max=1024)
    volume_bounces: IntProperty(name="Volume", default=0, min=0, max=1024)
    transparent_max_bounces: IntProperty(name="Transparent", default=8, min=0, max=1024)
    min_light_bounces: IntProperty(name="Min Light Bounces", default=0, min=0, max=1024)
    min_transparent_bounces: IntProperty(name="Min Transparent Bounces", default=0, min=0, max=1024)
    sample_clamp_direct: FloatProperty(name="Direct Light", default=0.0, min=0.0)
    sample_clamp_indirect: FloatProperty(name="Indirect Light", default=10.0, min=0.0)
    blur_glossy: FloatProperty(name="Filter Glossy", default=1.0, min=0.0, max=10.0)
    caustics_reflective: BoolProperty(name="Reflective", default=True)
    caustics_refractive: BoolProperty(name="Refractive", default=True)
    light_sampling_threshold: FloatProperty(name="Light Threshold", default=0.01, min=0.0, max=1.0)
    pixel_filter_type: EnumProperty(
        name="Pixel Filter",
        items=[("BLACKMAN_HARRIS", "Blackman-Harris", ""), ("GAUSSIAN", "Gaussian", ""), ("BOX", "Box", "")],
        default="BLACKMAN_HARRIS",
    )
    filter_width: FloatProperty(name="Width", default=1.5, min=0.01, max=10.0, subtype="PIXEL")
    film_exposure: FloatProperty(name="Exposure", default=1.0, min=0.0, max=10.0)
    film_transparent_glass: BoolProperty(name="Transparent Glass", default=False)
    film_transparent_roughness: FloatProperty(name="Roughness Threshold", default=0.1, min=0.0, max=1.0)
    volume_step_rate: FloatProperty(name="Step Rate", default=1.0, min=0.01, max=100.0)
    volume_max_steps: IntProperty(name="Max Steps", default=1024, min=2, max=65536)
    motion_blur_position: EnumProperty(
        name="Position",
        items=[("START", "Start on Frame", ""), ("CENTER", "Center on Frame", ""), ("END", "End on Frame", "")],
        default="CENTER",
    )
    rolling_shutter_type: EnumProperty(name="Rolling Shutter", items=[("NONE", "None", ""), ("TOP", "Top-Bottom", "")], default="NONE")
    rolling_shutter_duration: FloatProperty(name="Duration", default=0.1, min=0.0, max=1.0)


def register():
    """Puts the settings on scenes."""
    bpy.utils.register_class(RayloomSettings)
    bpy.types.Scene.rayloom = bpy.props.PointerProperty(type=RayloomSettings)


def unregister():
    """Takes them away."""
    del bpy.types.Scene.rayloom
    bpy.utils.unregister_class(RayloomSettings)
