//! The classic integrator's questions to the texture kernel: covers of a hit, colours, bumps, blends of textures, noise of the air.

use super::inline_vec::InlineVec;
use crate::compile::CompiledScene;
use crate::compile::geometry::{Prim, prim_flags};
use crate::compile::texture::TextureNode;
use crate::kernel::cover::for_covers;
use crate::kernel::{PatternPoint, SurfaceHit};
use crate::math::{DVec3, Rgbft};
use crate::scene::{BlendMap, Finish, Fog};

/// A texture of a hit and the space it stands in.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Cover {
    pub texture: u32,
    pub transform_ix: u32,
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
    let point = if prim.flags & prim_flags::UV_MAPPING != 0 {
        DVec3::new(hit.uv.x, hit.uv.y, 0.0)
    } else if cover.transform_ix == 0 {
        hit.point
    } else {
        scene.geometry.transforms[cover.transform_ix as usize].inverse_point(hit.point)
    };
    PatternPoint { point, uv: hit.uv, world: hit.point, normal, ray_dir }
}

/// The way from the world to a texture's own space, through the patterned textures around it.
pub(super) struct Space<'s> {
    pub parent: Option<&'s Space<'s>>,
    pub step: SpaceStep,
}

/// One step of it.
#[derive(Clone, Copy)]
pub(super) enum SpaceStep {
    /// World from the cover's space.
    Transform(u32),
    /// Into the space of a pattern.
    Pattern(u32),
}

impl Space<'_> {
    pub fn of_cover(cover: &Cover) -> Self {
        Space { parent: None, step: SpaceStep::Transform(cover.transform_ix) }
    }
}

/// Textures that a patterned texture mixes at a point.
pub(super) struct Parts {
    pub entries: InlineVec<(u32, f32), 8>,
    pub point: PatternPoint,
    pub step: SpaceStep,
}

/// The parts of a patterned texture at a point.
pub(super) fn blend(scene: &CompiledScene, node: &TextureNode, p: &PatternPoint) -> Parts {
    let mut entries = InlineVec::default();
    let (pattern, start) = match *node {
        TextureNode::Map { pattern, start, .. }
        | TextureNode::Average { pattern, start, .. }
        | TextureNode::MaterialMap { pattern, start, .. } => (pattern, start),
        _ => unreachable!("plain textures are shaded, not blended"),
    };
    entries.push((scene.textures.texture_entries[start as usize].1, 1.0));
    Parts { entries, point: *p, step: SpaceStep::Pattern(pattern) }
}

/// A layer's normal (world space).
pub(super) fn perturb(scene: &CompiledScene, normal_ix: u32, normal: DVec3, p: &PatternPoint, space: &Space) -> DVec3 {
    let _ = (scene, normal_ix, p, space.parent.is_some());
    normal
}

/// A normal applied to a direction, patterns in world space.
pub(super) fn perturb_in_world(scene: &CompiledScene, normal_ix: u32, dir: DVec3, p: &PatternPoint) -> DVec3 {
    let _ = (scene, normal_ix, p);
    dir
}

/// Colour of a layer's pigment; `None` outside a picture that is shown once.
pub(super) fn layer_color(scene: &CompiledScene, pigment: u32, p: &PatternPoint, quick: bool) -> Option<Rgbft> {
    let _ = quick;
    self::pigment(scene, pigment, p)
}

/// Colour of a pigment.
pub(super) fn pigment(scene: &CompiledScene, pigment: u32, p: &PatternPoint) -> Option<Rgbft> {
    let _ = (scene, pigment, p);
    Some(Rgbft::rgb(1.0, 1.0, 1.0))
}

/// Colour of a map at a value.
pub(super) fn color_map(map: &BlendMap<Rgbft>, value: f64) -> Rgbft {
    let value = value as f32;
    let entries = &map.entries;
    match entries.iter().position(|(pos, _)| value <= *pos) {
        None => entries.last().map_or(Rgbft::BLACK, |e| e.1),
        Some(0) => entries[0].1,
        Some(k) => {
            let (a, b) = (&entries[k - 1], &entries[k]);
            Rgbft::lerp(a.1, b.1, (value - a.0) / (b.0 - a.0))
        }
    }
}

/// Turbulence of a fog at a point.
pub(super) fn fog_turbulence(scene: &CompiledScene, fog: &Fog, p: DVec3) -> f64 {
    let _ = (scene, fog, p);
    0.0
}

/// Turbulence of a thin film at a point.
pub(super) fn irid_noise(scene: &CompiledScene, finish: &Finish, p: DVec3) -> f64 {
    let _ = (scene, finish, p);
    0.5
}
