//! Colours at points. Source: spec/textures.md, sections 1 and 6.

use super::PatternPoint;
use super::image::image_color;
use super::pattern::value_at_warped;
use super::warp::warp_by;
use crate::compile::CompiledScene;
use crate::compile::texture::{PigmentCode, PigmentIx};
use crate::math::{DVec3, Rgbft};

/// Colour of a pigment; `None` outside a picture that is shown once.
pub fn eval_pigment(scene: &CompiledScene, pigment: PigmentIx, at: &PatternPoint) -> Option<Rgbft> {
    let t = &scene.textures;
    let node = &t.pigments[pigment as usize];
    if let PigmentCode::Solid(c) = node.code {
        return Some(c);
    }
    let pattern = &t.patterns[node.pattern as usize];
    let start = if node.uv_mapping { DVec3::new(at.uv.x, at.uv.y, 0.0) } else { at.point };
    let p = warp_by(scene, pattern, start);
    match node.code {
        PigmentCode::Solid(c) => Some(c),
        PigmentCode::Colors(range) => {
            let inner = PatternPoint { point: start, ..*at };
            Some(color_at(range.of(&t.color_entries), value_at_warped(scene, pattern, p, &inner)))
        }
        PigmentCode::Map(range) => {
            let inner = PatternPoint { point: p, ..*at };
            let value = value_at_warped(scene, pattern, p, &inner);
            match neighbours(range.of(&t.pigment_entries), value) {
                (a, None) => eval_pigment(scene, a, &inner),
                (a, Some((b, share))) => {
                    let (a, b) = (eval_pigment(scene, a, &inner), eval_pigment(scene, b, &inner));
                    Some(Rgbft::lerp(a.unwrap_or(Rgbft::CLEAR), b.unwrap_or(Rgbft::CLEAR), share as f32))
                }
            }
        }
        PigmentCode::Average(range) => {
            let inner = PatternPoint { point: p, ..*at };
            let (mut sum, mut weight) = ([0.0f32; 5], 0.0f32);
            for (w, child) in range.of(&t.pigment_entries) {
                let c = eval_pigment(scene, *child, &inner).unwrap_or(Rgbft::CLEAR).to_array();
                sum = std::array::from_fn(|k| sum[k] + w * c[k]);
                weight += w;
            }
            Some(Rgbft::from_array(sum.map(|v| v / weight)))
        }
        PigmentCode::Image(ix) => image_color(&t.images[ix as usize], p),
    }
}

/// Colour of a pigment at low quality: its quick colour if it has one.
pub fn eval_quick_pigment(scene: &CompiledScene, pigment: PigmentIx, at: &PatternPoint) -> Option<Rgbft> {
    scene.textures.pigments[pigment as usize].quick_color.or_else(|| eval_pigment(scene, pigment, at))
}

/// Which entries of a map a value falls between: one, or two with the share of the second.
///
/// Positions are 32-bit numbers. The first entry at or above the value decides; equal takes it alone.
#[inline]
pub fn neighbours<T: Copy>(entries: &[(f32, T)], value: f64) -> (T, Option<(T, f64)>) {
    let last = entries[entries.len() - 1];
    if value >= f64::from(last.0) {
        return (last.1, None);
    }
    let mut before = entries[0];
    for (k, e) in entries.iter().enumerate() {
        let at = f64::from(e.0);
        if at >= value {
            if k == 0 || at == value {
                return (e.1, None);
            }
            let from = f64::from(before.0);
            return (before.1, Some((e.1, (value - from) / (at - from))));
        }
        before = *e;
    }
    // Only a NaN gets here.
    (last.1, None)
}

/// Colour of a map at a value.
pub fn color_at(entries: &[(f32, Rgbft)], value: f64) -> Rgbft {
    match neighbours(entries, value) {
        (a, None) => a,
        (a, Some((b, share))) => Rgbft::lerp(a, b, share as f32),
    }
}
