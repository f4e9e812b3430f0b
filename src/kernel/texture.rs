//! Which textures a patterned texture shows at a point. Source: spec/textures.md, section 5.

use super::PatternPoint;
use super::image::image_index;
use super::pattern::value_at_warped;
use super::pigment::neighbours;
use super::warp::warp_by;
use crate::compile::CompiledScene;
use crate::compile::texture::{PatternIx, TextureIx, TextureNode};
use crate::math::DVec3;

/// Calls `f` with every texture that a patterned node shows at a point and its share (they add up to 1), and gives what the
/// children look at. Plain nodes show nothing.
pub fn for_texture_parts(scene: &CompiledScene, node: &TextureNode, at: &PatternPoint, mut f: impl FnMut(TextureIx, f32)) -> PatternPoint {
    let t = &scene.textures;
    let warped = |pattern: PatternIx, uv_mapping: bool| {
        let point = if uv_mapping { DVec3::new(at.uv.x, at.uv.y, 0.0) } else { warp_by(scene, &t.patterns[pattern as usize], at.point) };
        PatternPoint { point, ..*at }
    };
    match *node {
        TextureNode::Map { pattern, start, len, uv_mapping } => {
            let inner = warped(pattern, uv_mapping);
            let value = value_at_warped(scene, &t.patterns[pattern as usize], inner.point, &inner);
            match neighbours(&t.texture_entries[start as usize..][..len as usize], value) {
                (a, None) => f(a, 1.0),
                (a, Some((b, share))) => {
                    // The upper one first (measured: what it draws and leaves behind shows in the lower one).
                    f(b, share as f32);
                    f(a, 1.0 - share as f32);
                }
            }
            inner
        }
        TextureNode::Average { pattern, start, len, uv_mapping } => {
            let entries = &t.texture_entries[start as usize..][..len as usize];
            let sum: f32 = entries.iter().map(|e| e.0).sum();
            entries.iter().for_each(|(w, t)| f(*t, w / sum));
            warped(pattern, uv_mapping)
        }
        TextureNode::MaterialMap { pattern, image, start, len } => {
            let inner = warped(pattern, false);
            let n = len as usize;
            let index = image_index(&t.images[image as usize], inner.point).unwrap_or(0);
            // The number itself and what modulo leaves beyond the last give the last (measured).
            let k = if index > n { index % n } else { index }.min(n.saturating_sub(1));
            f(t.texture_entries[start as usize + k].1, 1.0);
            inner
        }
        TextureNode::Layers { .. } | TextureNode::Principled(_) => *at,
    }
}

/// The pattern of a patterned node.
pub fn choosing_pattern(node: &TextureNode) -> Option<PatternIx> {
    match *node {
        TextureNode::Map { pattern, .. } | TextureNode::Average { pattern, .. } | TextureNode::MaterialMap { pattern, .. } => Some(pattern),
        TextureNode::Layers { .. } | TextureNode::Principled(_) => None,
    }
}
