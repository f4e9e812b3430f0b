# SPDX-License-Identifier: GPL-3.0-or-later
"""Render settings. Cycles' own are taken where the scene follows them, else the add-on's, which have the same names."""

_FILTER = {"BLACKMAN_HARRIS": "blackmanHarris", "GAUSSIAN": "gaussian", "BOX": "box"}

# Switches of a view layer → passes of the file.
_PASSES = {
    "use_pass_z": "depth",
    "use_pass_mist": "mist",
    "use_pass_position": "position",
    "use_pass_normal": "normal",
    "use_pass_vector": "vector",
    "use_pass_uv": "uv",
    "use_pass_object_index": "objectId",
    "use_pass_material_index": "materialId",
    "use_pass_diffuse_direct": "diffuseDirect",
    "use_pass_diffuse_indirect": "diffuseIndirect",
    "use_pass_diffuse_color": "diffuseColor",
    "use_pass_glossy_direct": "glossyDirect",
    "use_pass_glossy_indirect": "glossyIndirect",
    "use_pass_glossy_color": "glossyColor",
    "use_pass_transmission_direct": "transmissionDirect",
    "use_pass_transmission_indirect": "transmissionIndirect",
    "use_pass_transmission_color": "transmissionColor",
    "use_pass_emit": "emission",
    "use_pass_environment": "environment",
    "use_pass_ambient_occlusion": "ambientOcclusion",
    "use_pass_cryptomatte_object": "cryptoObject",
    "use_pass_cryptomatte_material": "cryptoMaterial",
    "use_pass_cryptomatte_asset": "cryptoAsset",
}
# The same of the group that Cycles keeps at it.
_CYCLES_PASSES = {
    "use_pass_volume_direct": ("volumeDirect",),
    "use_pass_volume_indirect": ("volumeIndirect",),
    "use_pass_shadow_catcher": ("shadowCatcher",),
    "pass_debug_sample_count": ("sampleCount",),
    "denoising_store_passes": ("albedo", "denoisingNormal", "depth"),
}


def settings_of(scene):
    """The group of settings that counts: Cycles' or the add-on's."""
    own = getattr(scene, "rayloom", None)
    cycles = getattr(scene, "cycles", None)
    if cycles is not None and (own is None or own.follow_cycles):
        return cycles
    return own


def picture_size(render):
    """Width and height in pixels, percentage applied as Blender does (rounded down)."""
    percent = render.resolution_percentage
    return max(1, render.resolution_x * percent // 100), max(1, render.resolution_y * percent // 100)


def border_of(render):
    """`[left, top, right, bottom]` in pixels, right and bottom exclusive; `None` for the whole picture."""
    if not render.use_border:
        return None
    width, height = picture_size(render)
    left, right = int(width * render.border_min_x), int(width * render.border_max_x)
    bottom, top = int(height * render.border_min_y), int(height * render.border_max_y)
    if right <= left or top <= bottom:
        return None
    return [left, height - top, right, height - bottom]


def wanted_passes(view_layer, scene=None):
    """The passes that a view layer asks for, by their names in the file."""
    out = [name for switch, name in _PASSES.items() if getattr(view_layer, switch, False)]
    if scene is not None and scene.render.use_motion_blur and "vector" in out:
        # As in Cycles: a blurred picture has none.
        out.remove("vector")
    cycles = getattr(view_layer, "cycles", None)
    for switch, names in _CYCLES_PASSES.items():
        if getattr(cycles, switch, False):
            out += [name for name in names if name not in out]
    return out


def denoises(scene, view_layer):
    """Whether the picture of a view layer is to be denoised."""
    return bool(settings_of(scene).use_denoising and getattr(getattr(view_layer, "cycles", None), "use_denoising", True))


_GUIDES = {"RGB": "none", "RGB_ALBEDO": "albedo", "RGB_ALBEDO_NORMAL": "albedoNormal"}


def denoiser_record(settings):
    """The record `denoiser`."""
    return {
        "guides": _GUIDES.get(settings.denoising_input_passes, "albedoNormal"),
        "prefilter": settings.denoising_prefilter.lower(),
        "quality": getattr(settings, "denoising_quality", "HIGH").lower(),
    }


def render_record(scene, view_layer):
    """The record `render`."""
    r, c = scene.render, settings_of(scene)
    width, height = picture_size(r)
    out = {"resolution": [width, height], "exposure": 1.0, "transparent": r.film_transparent}
    if (r.pixel_aspect_x, r.pixel_aspect_y) != (1.0, 1.0):
        out["pixelAspect"] = [r.pixel_aspect_x, r.pixel_aspect_y]
    border = border_of(r)
    if border:
        out["border"] = border
    if r.use_motion_blur:
        position = getattr(r, "motion_blur_position", None) or getattr(c, "motion_blur_position", "CENTER")
        out["motionBlur"] = {"shutter": r.motion_blur_shutter, "position": position.lower()}
        if getattr(c, "rolling_shutter_type", "NONE") == "TOP":
            out["motionBlur"]["rolling"] = c.rolling_shutter_duration
    passes = wanted_passes(view_layer, scene)
    if passes:
        out["passes"] = passes
    world = scene.world
    if world is not None:
        mist = world.mist_settings
        falloff = {"QUADRATIC": "quadratic", "LINEAR": "linear", "INVERSE_QUADRATIC": "inverseQuadratic"}[mist.falloff]
        out["mist"] = {"start": mist.start, "depth": mist.depth, "falloff": falloff}
        out["occlusionDistance"] = world.light_settings.distance
    if c is None:
        return out
    samples = view_layer.samples if getattr(view_layer, "samples", 0) > 0 else c.samples
    out.update(
        samples=samples,
        seed=c.seed + (scene.frame_current if getattr(c, "use_animated_seed", False) else 0),
        bounces={
            "total": c.max_bounces,
            "diffuse": c.diffuse_bounces,
            "glossy": c.glossy_bounces,
            "transmission": c.transmission_bounces,
            "volume": c.volume_bounces,
            "transparent": c.transparent_max_bounces,
        },
        minLightBounces=c.min_light_bounces,
        minTransparentBounces=c.min_transparent_bounces,
        clampDirect=c.sample_clamp_direct,
        clampIndirect=c.sample_clamp_indirect,
        filterGlossy=c.blur_glossy,
        causticsReflective=c.caustics_reflective,
        causticsRefractive=c.caustics_refractive,
        lightThreshold=c.light_sampling_threshold,
        filter={"type": _FILTER[c.pixel_filter_type], "width": c.filter_width},
        exposure=c.film_exposure,
        denoise=denoises(scene, view_layer),
        denoiser=denoiser_record(c),
        volume={"stepRate": getattr(c, "volume_step_rate", 1.0), "maxSteps": getattr(c, "volume_max_steps", 1024)},
    )
    if c.use_adaptive_sampling:
        out["adaptive"] = {"threshold": c.adaptive_threshold, "minSamples": c.adaptive_min_samples}
    if c.time_limit > 0.0:
        out["timeLimit"] = c.time_limit
    if r.film_transparent and c.film_transparent_glass:
        out["transparentGlass"], out["transparentRoughness"] = True, c.film_transparent_roughness
    hair = getattr(scene, "cycles_curves", None)
    if hair is not None:
        out["hair"] = {"shape": "ribbon" if hair.shape == "RIBBONS" else "thick", "subdivisions": hair.subdivisions}
    if r.threads_mode == "FIXED":
        out["threads"] = r.threads
    return out
