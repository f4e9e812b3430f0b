//! Light sources and shining faces as the shaders read them. Twins: `shaders/shared/light.wesl`, `area.wesl`.

use super::buffers::{append, bits, bits3, v3};
use super::layout::Light;
use crate::compile::{CompiledLight, CompiledScene, NONE};
use crate::integrate::classic::{EmitterPoint, Piece};
use crate::math::DVec3;
use crate::scene::light::{AreaLight, Fade, LightKind};

const LIGHT_POINT: u32 = 0;
const LIGHT_SPOT: u32 = 1;
const LIGHT_CYLINDER: u32 = 2;
const LIGHT_SUN: u32 = 3;
const LIGHT_PARALLEL: u32 = 1;
const LIGHT_SHADOWLESS: u32 = 2;
const LIGHT_IN_AIR: u32 = 4;
const LIGHT_HAS_RADIUS: u32 = 8;
const LIGHT_SPREAD: u32 = 16;
const LIGHT_IN_MEDIA: u32 = 32;
const AREA_JITTER: u32 = 1;
const AREA_CIRCULAR: u32 = 2;
const AREA_ORIENT: u32 = 4;
const FADE_POV: u32 = 1;
const FADE_INVERSE_SQUARE: u32 = 2;
/// All of these by name.
pub(super) const LIGHT_CONSTANTS: &[(&str, u32)] = &[
    ("LIGHT_POINT", LIGHT_POINT),
    ("LIGHT_SPOT", LIGHT_SPOT),
    ("LIGHT_CYLINDER", LIGHT_CYLINDER),
    ("LIGHT_SUN", LIGHT_SUN),
    ("LIGHT_PARALLEL", LIGHT_PARALLEL),
    ("LIGHT_SHADOWLESS", LIGHT_SHADOWLESS),
    ("LIGHT_IN_AIR", LIGHT_IN_AIR),
    ("LIGHT_HAS_RADIUS", LIGHT_HAS_RADIUS),
    ("LIGHT_SPREAD", LIGHT_SPREAD),
    ("LIGHT_IN_MEDIA", LIGHT_IN_MEDIA),
    ("AREA_JITTER", AREA_JITTER),
    ("AREA_CIRCULAR", AREA_CIRCULAR),
    ("AREA_ORIENT", AREA_ORIENT),
    ("FADE_POV", FADE_POV),
    ("FADE_INVERSE_SQUARE", FADE_INVERSE_SQUARE),
];

/// Balls have their radius in place of the area, negative.
pub(super) fn emitter(e: &EmitterPoint) -> Vec<u32> {
    let (normal, size) = match e.shape {
        Piece::Flat { normal, area } => (normal, area),
        Piece::Ball { radius } => (DVec3::ZERO, -radius),
    };
    [&bits3(e.point)[..], &bits3(normal), &[(size as f32).to_bits()], &bits(e.radiance.to_array()), &[e.prim_ix]].concat()
}

/// Words of an area light, as `area.wesl` reads them.
fn area(a: &AreaLight) -> Vec<u32> {
    let flag = |holds: bool, bit: u32| if holds { bit } else { 0 };
    let flags = flag(a.jitter, AREA_JITTER) | flag(a.circular, AREA_CIRCULAR) | flag(a.orient, AREA_ORIENT);
    [&[a.n1.max(1), a.n2.max(1), a.adaptive, flags][..], &bits3(a.axis1), &bits3(a.axis2)].concat()
}

/// A light source; what differs in length goes to `words`.
pub(super) fn light(scene: &CompiledScene, compiled: &CompiledLight, words: &mut Vec<u32>) -> Light {
    let CompiledLight { light: l, beam, .. } = compiled;
    let mut out =
        Light { location: v3(l.location), point_at: v3(l.point_at), color: l.color.to_array(), axis: v3(beam.axis), ..Light::default() };
    let mut flags = 0;
    match l.kind {
        LightKind::Point => out.kind = LIGHT_POINT,
        LightKind::Sun { .. } => out.kind = LIGHT_SUN,
        LightKind::Spot { radius_rad, falloff_rad, tightness } => {
            out.kind = LIGHT_SPOT;
            (out.radius, out.falloff, out.tightness) = (radius_rad.cos() as f32, falloff_rad.cos() as f32, tightness as f32);
            flags |= if radius_rad.cos() > 0.0 { LIGHT_HAS_RADIUS } else { 0 };
        }
        LightKind::Cylinder { radius, falloff, tightness } => {
            out.kind = LIGHT_CYLINDER;
            (out.radius, out.falloff, out.tightness) = (radius as f32, falloff as f32, tightness as f32);
        }
    }
    match l.fade {
        Fade::Pov { distance, power } if power > 0.0 && distance != 0.0 => {
            (out.fade_kind, out.fade_distance, out.fade_power) = (FADE_POV, distance as f32, power as f32);
        }
        Fade::InverseSquare => out.fade_kind = FADE_INVERSE_SQUARE,
        _ => {}
    }
    flags |= if l.parallel { LIGHT_PARALLEL } else { 0 };
    if compiled.projected_through != NONE {
        let prims = &scene.geometry.objects[compiled.projected_through as usize].prims;
        out.projected_at = append(words, [prims.start, prims.end]);
    }
    if let Some(a) = &l.area {
        out.area_at = append(words, area(a));
        flags |= if a.area_illumination { LIGHT_SPREAD } else { 0 };
    }
    flags |= if l.shadowless { LIGHT_SHADOWLESS } else { 0 };
    flags |= if l.media_interaction { LIGHT_IN_MEDIA } else { 0 };
    flags |= if l.media_attenuation && l.media_interaction { LIGHT_IN_AIR } else { 0 };
    out.flags = flags;
    out
}
