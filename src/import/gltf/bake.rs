//! Pictures made of pictures, where a material's texture means something else than the closure's input.

use crate::scene::material::{MaterialImage, MaterialTexture, Texels};
use std::sync::Arc;

/// The texture with each texel's numbers (0..=1, as they stand in the file) turned into others from 0 to 1, 16 bits each.
pub(super) fn texels(t: &MaterialTexture, f: impl Fn([f32; 4]) -> [f32; 4]) -> MaterialTexture {
    let coded = |c: [f32; 4]| f(c).map(|v| (v.clamp(0.0, 1.0) * 65535.0).round() as u16);
    let texels = match &t.image.texels {
        Texels::Rgba8(list) => list.iter().map(|c| coded(c.map(|v| f32::from(v) / 255.0))).collect(),
        Texels::Rgba16(list) => list.iter().map(|c| coded(c.map(|v| f32::from(v) / 65535.0))).collect(),
        Texels::RgbaF32(list) => list.iter().map(|c| coded(*c)).collect(),
    };
    let image = MaterialImage { width: t.image.width, height: t.image.height, texels: Texels::Rgba16(texels) };
    MaterialTexture { image: Arc::new(image), srgb: false, ..t.clone() }
}
