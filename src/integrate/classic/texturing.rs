//! The classic integrator's questions to the texture kernel: covers of a hit, colours, bumps, blends of textures, noise of the air.

use super::inline_vec::InlineVec;
use crate::compile::CompiledScene;
use crate::compile::geometry::Prim;
use crate::compile::texture::{PigmentCode, TextureNode};
use crate::kernel::cover::{for_covers, sole_cover};
use crate::kernel::normal::{normal_into_pattern, normal_out_of_pattern, perturb_normal};
use crate::kernel::pigment::{color_at, eval_pigment, eval_quick_pigment};
use crate::kernel::texture::{choosing_pattern, for_texture_parts};
use crate::kernel::{PatternPoint, SurfaceHit};
use crate::math::noise::turbulence;
use crate::math::{DVec3, Rgbft};
use crate::scene::{BlendMap, Finish, Fog};
use std::cell::Cell;

/// A texture of a hit and the space it stands in.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Cover {
    pub texture: u32,
    pub transform_ix: u32,
}

/// The one texture that a hit shows, where that is told at once.
#[inline]
pub(super) fn sole_cover_at(scene: &CompiledScene, hit: &SurfaceHit, from_inside: bool, adc_bailout: f64) -> Option<Cover> {
    let found = if 1.0 >= adc_bailout { sole_cover(scene, hit, from_inside) } else { None };
    found.map(|c| Cover { texture: c.texture, transform_ix: c.transform_ix })
}

/// The textures that a hit shows with their shares; shares below the bailout are skipped.
pub(super) fn covers_at(scene: &CompiledScene, hit: &SurfaceHit, from_inside: bool, adc_bailout: f64) -> InlineVec<(Cover, f32), 4> {
    let mut out = InlineVec::default();
    for_covers(scene, hit, from_inside, |c| {
        if f64::from(c.weight) >= adc_bailout {
            out.push((Cover { texture: c.texture, transform_ix: c.transform_ix }, c.weight));
        }
    });
    out
}

/// Where a cover's patterns are looked up.
pub(super) fn pattern_point(
    scene: &CompiledScene,
    hit: &SurfaceHit,
    prim: &Prim,
    cover: &Cover,
    normal: DVec3,
    ray_dir: DVec3,
) -> PatternPoint {
    crate::kernel::cover::pattern_point(scene, hit, prim, cover.transform_ix, normal, ray_dir)
}

/// The way from the world to a texture's own space, through the patterned textures around it.
pub(super) struct Space<'s> {
    pub parent: Option<&'s Space<'s>>,
    pub step: SpaceStep,
    /// The normal that slope and aoi look at, shared by all textures of a hit.
    pub seen: &'s Cell<DVec3>,
}

/// One step of it.
#[derive(Clone, Copy)]
pub(super) enum SpaceStep {
    /// World from the cover's space.
    Transform(u32),
    /// Into the space of a pattern.
    Pattern(u32),
}

impl<'s> Space<'s> {
    pub fn of_cover(cover: &Cover, seen: &'s Cell<DVec3>) -> Self {
        Space { parent: None, step: SpaceStep::Transform(cover.transform_ix), seen }
    }
}

/// Textures that a patterned texture mixes at a point.
pub(super) struct Parts {
    pub entries: InlineVec<(u32, f32), 8>,
    pub point: PatternPoint,
    pub step: SpaceStep,
}

/// The parts of a patterned texture at a point.
pub(super) fn blend(scene: &CompiledScene, node: &TextureNode, p: &PatternPoint, space: &Space) -> Parts {
    let mut entries = InlineVec::default();
    let point =
        for_texture_parts(scene, node, &PatternPoint { normal: space.seen.get(), ..*p }, |texture, share| entries.push((texture, share)));
    let pattern = choosing_pattern(node).expect("plain textures are shaded, not blended");
    Parts { entries, point: PatternPoint { normal: p.normal, ..point }, step: SpaceStep::Pattern(pattern) }
}

/// A layer's normal (world space), taken through the spaces around the layer and back. The patterns slope and aoi see it as it is
/// inside the patterned textures around it (measured).
pub(super) fn perturb(scene: &CompiledScene, normal_ix: u32, normal: DVec3, p: &PatternPoint, space: &Space) -> DVec3 {
    let inner = perturb_normal(scene, normal_ix, into_space(scene, space, normal), p);
    let outer = out_of_space(scene, space, inner);
    let outer = outer.try_normalize().unwrap_or(normal);
    space.seen.set(if space.parent.is_some() { inner.try_normalize().unwrap_or(normal) } else { outer });
    outer
}

fn into_space(scene: &CompiledScene, space: &Space, n: DVec3) -> DVec3 {
    let n = space.parent.map_or(n, |s| into_space(scene, s, n));
    match space.step {
        SpaceStep::Transform(0) => n,
        SpaceStep::Transform(ix) => scene.geometry.transforms[ix as usize].inverse_normal(n).normalize_or_zero(),
        SpaceStep::Pattern(ix) => normal_into_pattern(scene, ix, n).normalize_or_zero(),
    }
}

fn out_of_space(scene: &CompiledScene, space: &Space, n: DVec3) -> DVec3 {
    let n = match space.step {
        SpaceStep::Transform(0) => n,
        SpaceStep::Transform(ix) => scene.geometry.transforms[ix as usize].normal(n).normalize_or_zero(),
        SpaceStep::Pattern(ix) => normal_out_of_pattern(scene, ix, n).normalize_or_zero(),
    };
    space.parent.map_or(n, |s| out_of_space(scene, s, n))
}

/// A normal applied to a direction, patterns in world space.
pub(super) fn perturb_in_world(scene: &CompiledScene, normal_ix: u32, dir: DVec3, p: &PatternPoint) -> DVec3 {
    perturb_normal(scene, normal_ix, dir, p)
}

/// Colour of a layer's pigment, for patterns that see normal `seen`; `None` outside a picture that is shown once.
#[inline]
pub(super) fn layer_color(scene: &CompiledScene, pigment: u32, p: &PatternPoint, seen: DVec3, quick: bool) -> Option<Rgbft> {
    // Plain colours look at no point: none is made ready for them.
    match scene.textures.pigments[pigment as usize].code {
        PigmentCode::Solid(color) if !quick => Some(color),
        _ => patterned_color(scene, pigment, &PatternPoint { normal: seen, ..*p }, quick),
    }
}

#[inline(never)]
fn patterned_color(scene: &CompiledScene, pigment: u32, p: &PatternPoint, quick: bool) -> Option<Rgbft> {
    if quick { eval_quick_pigment(scene, pigment, p) } else { eval_pigment(scene, pigment, p) }
}

/// Colour of a pigment.
pub(super) fn pigment(scene: &CompiledScene, pigment: u32, p: &PatternPoint) -> Option<Rgbft> {
    eval_pigment(scene, pigment, p)
}

/// Colour of a map at a value.
pub(super) fn color_map(map: &BlendMap<Rgbft>, value: f64) -> Rgbft {
    color_at(&map.entries, value)
}

/// Turbulence of a fog at a point.
pub(super) fn fog_turbulence(scene: &CompiledScene, fog: &Fog, p: DVec3) -> f64 {
    fog.turbulence.as_ref().map_or(0.0, |(t, _)| turbulence(p, t.octaves, t.omega, t.lambda, scene.settings.noise_generator))
}

/// Turbulence of a thin film at a point.
pub(super) fn irid_noise(scene: &CompiledScene, _finish: &Finish, p: DVec3) -> f64 {
    turbulence(p, 5, 0.5, 2.0, scene.settings.noise_generator)
}
