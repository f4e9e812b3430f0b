//! What the textures of a scene need, read off their tables.

use super::{NormalCode, PatternCode, PigmentCode, TextureNode, TextureTables, WarpNode};
use crate::compile::FeatureSet;
use crate::compile::function::FunctionNode;

/// Adds what `t` needs to `f`.
pub fn texture_features(t: &TextureTables, f: &mut FeatureSet) {
    f.patterns = t.patterns.iter().map(|p| pattern_name(&p.code)).collect();
    f.patterns.sort_unstable();
    f.patterns.dedup();
    f.normals = !t.normals.is_empty();
    f.turbulence = t.warps.iter().any(|w| matches!(w, WarpNode::Turbulence { .. }))
        || t.patterns.iter().any(|p| p.turb_amount != crate::math::DVec3::ZERO || matches!(p.code, PatternCode::Agate { .. }));
    f.images = !t.images.is_empty();
    f.functions = t.functions.iter().any(|f| !matches!(f, FunctionNode::Transform(_)));
    f.uv |= t.pigments.iter().any(|p| p.uv_mapping)
        || t.normals.iter().any(|n| n.uv_mapping)
        || t.textures.iter().any(|n| {
            matches!(
                n,
                TextureNode::Map { uv_mapping: true, .. } | TextureNode::Average { uv_mapping: true, .. } | TextureNode::Principled(_)
            )
        });
    debug_assert!(t.pigments.iter().all(|p| !matches!(p.code, PigmentCode::Colors(r) if r.len == 0)), "colour maps have entries");
    debug_assert!(t.normals.iter().all(|n| !matches!(n.code, NormalCode::Map(r) if r.len == 0)), "normal maps have entries");
}

/// Tilings that a lattice repeats: 1 up to this; Penrose's follow.
pub const N_TILINGS: u8 = 24;

/// The keyword of a pattern.
pub fn pattern_name(code: &PatternCode) -> &'static str {
    match code {
        PatternCode::Plain => "plain",
        PatternCode::Agate { .. } => "agate",
        PatternCode::Aoi => "aoi",
        PatternCode::Boxed => "boxed",
        PatternCode::Noise => "bozo",
        PatternCode::Bumps => "bumps",
        PatternCode::Brick { .. } => "brick",
        PatternCode::Cells => "cells",
        PatternCode::Checker => "checker",
        PatternCode::Crackle { .. } => "crackle",
        PatternCode::Cubic => "cubic",
        PatternCode::Cylindrical => "cylindrical",
        PatternCode::Density { .. } => "density_file",
        PatternCode::Dents => "dents",
        PatternCode::Facets { .. } => "facets",
        PatternCode::Fractal(_) => "mandel",
        PatternCode::Function(_) => "function",
        PatternCode::Gradient(_) => "gradient",
        PatternCode::Granite => "granite",
        PatternCode::Hexagon => "hexagon",
        PatternCode::Image(_) => "image_pattern",
        PatternCode::Leopard => "leopard",
        PatternCode::Marble => "marble",
        PatternCode::Object(_) => "object",
        PatternCode::Onion => "onion",
        PatternCode::Pavement(_) => "pavement",
        PatternCode::Pigment(_) => "pigment_pattern",
        PatternCode::Planar => "planar",
        PatternCode::Quilted { .. } => "quilted",
        PatternCode::Radial => "radial",
        PatternCode::Ripples => "ripples",
        PatternCode::Slope(_) => "slope",
        PatternCode::Spherical => "spherical",
        PatternCode::Spiral1 { .. } => "spiral1",
        PatternCode::Spiral2 { .. } => "spiral2",
        PatternCode::Square => "square",
        PatternCode::Tiling(n) if *n > N_TILINGS => "penrose",
        PatternCode::Tiling(_) => "tiling",
        PatternCode::Triangular => "triangular",
        PatternCode::Waves => "waves",
        PatternCode::Wood => "wood",
        PatternCode::Wrinkles => "wrinkles",
    }
}
