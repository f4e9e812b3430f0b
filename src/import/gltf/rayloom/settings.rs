//! Render settings.

use super::super::super::ImportError;
use super::motion::Shutter;
use super::record::Record;
use crate::diag::Sink;
use crate::scene::curves::CurveStyle;
use crate::scene::denoise::{DenoiseQuality, DenoiseSettings, Guides, Prefilter};
use crate::scene::path_settings::{Mist, PixelFilter};
use crate::scene::{Pass, Scene};

/// The record `denoiser`, or its defaults.
fn denoiser(r: &Record) -> Result<DenoiseSettings, ImportError> {
    let mut out = DenoiseSettings::default();
    if let Some(d) = r.record("denoiser")? {
        out.guides = d.choice("guides", out.guides, &GUIDES)?;
        out.prefilter = d.choice("prefilter", out.prefilter, &PREFILTERS)?;
        out.quality = d.choice("quality", out.quality, &QUALITIES)?;
        d.finish()?;
    }
    Ok(out)
}

const GUIDES: [(&str, Guides); 3] = [("none", Guides::None), ("albedo", Guides::Albedo), ("albedoNormal", Guides::AlbedoNormal)];
const PREFILTERS: [(&str, Prefilter); 3] = [("none", Prefilter::None), ("fast", Prefilter::Fast), ("accurate", Prefilter::Accurate)];
const QUALITIES: [(&str, DenoiseQuality); 3] =
    [("high", DenoiseQuality::High), ("balanced", DenoiseQuality::Balanced), ("fast", DenoiseQuality::Fast)];

/// Fills the scene's settings from the record `render`; the style of hair and the shutter besides.
pub(super) fn settings(r: &Record, scene: &mut Scene, sink: &mut Sink) -> Result<(CurveStyle, Shutter), ImportError> {
    let p = &mut scene.settings.path;
    p.samples = r.count_or("samples", 4096)?;
    p.seed = r.number_or("seed", 0.0)? as i64 as u32;
    if let Some(a) = r.record("adaptive")? {
        p.adaptive_threshold = a.positive_or("threshold", 0.01)? as f32;
        p.adaptive_min_samples = a.count_or("minSamples", 0)?;
        a.finish()?;
    }
    if let Some(b) = r.record("bounces")? {
        p.max_bounces = b.count_or("total", 12)?;
        p.diffuse_bounces = b.count_or("diffuse", 4)?;
        p.glossy_bounces = b.count_or("glossy", 4)?;
        p.transmission_bounces = b.count_or("transmission", 12)?;
        p.volume_bounces = b.count_or("volume", 0)?;
        p.transparent_bounces = b.count_or("transparent", 8)?;
        b.finish()?;
    }
    p.min_light_bounces = r.count_or("minLightBounces", 0)?;
    p.min_transparent_bounces = r.count_or("minTransparentBounces", 0)?;
    p.clamp_direct = r.positive_or("clampDirect", 0.0)? as f32;
    p.clamp_indirect = r.positive_or("clampIndirect", 10.0)? as f32;
    p.filter_glossy = r.positive_or("filterGlossy", 1.0)? as f32;
    p.caustics_reflective = r.flag("causticsReflective", true)?;
    p.caustics_refractive = r.flag("causticsRefractive", true)?;
    if let Some(f) = r.record("filter")? {
        let width = f.positive_or("width", 1.5)? as f32;
        let blackman = PixelFilter::BlackmanHarris { width };
        let kinds = [("blackmanHarris", blackman), ("gaussian", PixelFilter::Gaussian { width }), ("box", PixelFilter::Box)];
        p.filter = f.choice("type", blackman, &kinds)?;
        f.finish()?;
    }
    p.exposure = r.positive_or("exposure", 1.0)? as f32;
    p.film_transparent = r.flag("transparent", false)?;
    if r.flag("transparentGlass", false)? {
        sink.note_once("rayloom: transparent glass", None, "transparent glass of the film is left out: glass is opaque in alpha");
    }
    r.positive_or("transparentRoughness", 0.1)?;
    if r.flag("denoise", false)? {
        p.denoise = Some(denoiser(r)?);
    } else {
        denoiser(r)?;
    }
    p.time_limit = r.positive_or("timeLimit", 0.0)? as f32;
    for name in r.words("passes")? {
        match Pass::named(name) {
            Some(pass) => p.passes = p.passes.with(pass),
            None => {
                sink.note_once(&format!("rayloom: pass {name}"), None, format!("the pass '{name}' is left out: it is not rendered yet"))
            }
        }
    }
    if let Some(m) = r.record("mist")? {
        let curves = [("quadratic", 2.0), ("linear", 1.0), ("inverseQuadratic", 0.5)];
        let (start, depth) = (m.positive_or("start", 5.0)? as f32, m.positive_or("depth", 25.0)? as f32);
        p.mist = Mist { start, depth, exponent: m.choice("falloff", 2.0, &curves)? as f32 };
        m.finish()?;
    }
    p.occlusion_distance = r.positive_or("occlusionDistance", 10.0)? as f32;
    let mut shutter = Shutter::default();
    if let Some(m) = r.record("motionBlur")? {
        let length = m.positive_or("shutter", 0.5)?;
        let start = m.choice("position", -0.5, &[("start", 0.0), ("center", -0.5), ("end", -1.0)])? * length;
        shutter = Shutter { open: start, close: start + length };
        if m.number("rolling")?.is_some() {
            sink.note_once("rayloom: rolling shutter", None, "the rolling shutter is left out");
        }
        m.finish()?;
    } else if p.passes.has(Pass::Vector) {
        p.still = true;
        shutter = Shutter { open: -1.0, close: 1.0 };
    }
    let mut style = CurveStyle::Ribbon;
    if let Some(h) = r.record("hair")? {
        style = h.choice("shape", style, &[("ribbon", CurveStyle::Ribbon), ("thick", CurveStyle::Tube)])?;
        h.count("subdivisions")?;
        h.finish()?;
    }
    // What the command line says, or what changes no picture.
    for key in ["resolution", "pixelAspect", "border", "threads", "lightThreshold", "lightTree", "volume", "background"] {
        r.get(key);
    }
    r.finish()?;
    Ok((style, shutter))
}
