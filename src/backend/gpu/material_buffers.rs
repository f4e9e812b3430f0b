//! Imported materials and their pictures as words. Twin: `shaders/shared/material.wesl`.

use super::buffers::append;
use crate::scene::Principled;
use crate::scene::material::{AlphaMode, MaterialImage, MaterialTexture, Texels, Wrap};
use std::collections::HashMap;
use std::sync::Arc;

/// Words of a material: name and length.
const MATERIAL: &[(&str, u32)] = &[
    ("BASE", 3),
    ("ALPHA", 1),
    ("ALPHA_MODE", 1),
    ("CUTOFF", 1),
    ("METALLIC", 1),
    ("ROUGHNESS", 1),
    ("IOR", 1),
    ("SPECULAR", 1),
    ("SPECULAR_COLOR", 3),
    ("TRANSMISSION", 1),
    ("EMISSION", 3),
    ("NORMAL_SCALE", 1),
    ("BASE_PICTURE", 1),
    ("ALPHA_PICTURE", 1),
    ("ROUGHNESS_PICTURE", 1),
    ("TRANSMISSION_PICTURE", 1),
    ("EMISSION_PICTURE", 1),
    ("NORMAL_PICTURE", 1),
];
/// Words of a picture as a material uses it.
const PICTURE: &[(&str, u32)] = &[
    ("PIXELS_AT", 1),
    ("WIDTH", 1),
    ("HEIGHT", 1),
    ("IS_WIDE", 1),
    ("SRGB", 1),
    ("LINEAR", 1),
    ("WRAP_U", 1),
    ("WRAP_V", 1),
    ("UV_TRANSFORM", 6),
];
const ALPHA_MODES: [&str; 3] = ["OPAQUE", "MASK", "BLEND"];
const WRAPS: [&str; 3] = ["REPEAT", "MIRROR", "CLAMP"];

/// Names and places for the shaders.
pub(super) fn material_constants() -> Vec<(String, u32)> {
    let places = |prefix: &str, fields: &[(&str, u32)]| {
        let mut at = 0;
        let place = |(name, len): &(&str, u32)| {
            at += len;
            (format!("{prefix}_{name}"), at - len)
        };
        fields.iter().map(place).collect::<Vec<_>>()
    };
    let numbered = |prefix: &str, names: &[&str]| (0..).zip(names).map(|(k, n)| (format!("{prefix}_{n}"), k)).collect::<Vec<_>>();
    [places("MATERIAL", MATERIAL), places("PICTURE", PICTURE), numbered("ALPHA_MODE", &ALPHA_MODES), numbered("WRAP", &WRAPS)].concat()
}

/// Pictures already encoded, by address, with their first word.
type Known = HashMap<*const MaterialImage, u32>;

/// Encodes all materials; gives the place of the list of their places.
pub(super) fn encode_materials(list: &[Principled], words: &mut Vec<u32>, image_words: &mut Vec<u32>) -> u32 {
    let mut known = Known::new();
    let places: Vec<u32> = list.iter().map(|m| encode_material(m, words, image_words, &mut known)).collect();
    append(words, places)
}

fn encode_material(m: &Principled, words: &mut Vec<u32>, image_words: &mut Vec<u32>, known: &mut Known) -> u32 {
    let textures = [
        &m.base_color_texture,
        &m.alpha_texture,
        &m.metallic_roughness_texture,
        &m.transmission_texture,
        &m.emission_texture,
        &m.normal_texture,
    ];
    let pictures = textures.map(|t| t.as_ref().map_or(0, |t| encode_picture(t, words, image_words, known)));
    let n = f32::to_bits;
    let (mode, cutoff) = match m.alpha_mode {
        AlphaMode::Opaque => (0, 0.0),
        AlphaMode::Mask(cutoff) => (1, cutoff),
        AlphaMode::Blend => (2, 0.0),
    };
    let mut w = m.base_color.to_array().map(n).to_vec();
    w.extend([n(m.alpha), mode, n(cutoff), n(m.metallic), n(m.roughness), n(m.ior), n(m.specular)]);
    w.extend(m.specular_color.to_array().map(n));
    w.push(n(m.transmission));
    w.extend(m.emission.to_array().map(n));
    w.push(n(m.normal_scale));
    w.extend(pictures);
    debug_assert_eq!(w.len() as u32, MATERIAL.iter().map(|f| f.1).sum::<u32>(), "as the shader reads it");
    append(words, w)
}

fn encode_picture(t: &MaterialTexture, words: &mut Vec<u32>, image_words: &mut Vec<u32>, known: &mut Known) -> u32 {
    let image = &*t.image;
    let pixels_at = *known.entry(Arc::as_ptr(&t.image)).or_insert_with(|| {
        let at = image_words.len() as u32;
        match &image.texels {
            Texels::Rgba8(list) => image_words.extend(list.iter().map(|c| u32::from_le_bytes(*c))),
            Texels::Rgba16(list) => {
                let pair = |a: u16, b: u16| u32::from(a) | u32::from(b) << 16;
                image_words.extend(list.iter().flat_map(|c| [pair(c[0], c[1]), pair(c[2], c[3])]));
            }
            // The likeness goes without what is above 1.
            Texels::RgbaF32(list) => {
                let code = |v: f32| (v.clamp(0.0, 1.0) * 65535.0).round() as u32;
                image_words.extend(list.iter().flat_map(|c| [code(c[0]) | code(c[1]) << 16, code(c[2]) | code(c[3]) << 16]));
            }
        }
        at
    });
    let wrap = |w: Wrap| match w {
        Wrap::Repeat => 0,
        Wrap::Mirror => 1,
        Wrap::Clamp | Wrap::Clip => 2,
    };
    let is_wide = u32::from(!matches!(image.texels, Texels::Rgba8(_)));
    let mut w = vec![
        pixels_at,
        image.width,
        image.height,
        is_wide,
        u32::from(t.srgb && !matches!(image.texels, Texels::RgbaF32(_))),
        u32::from(t.linear),
    ];
    w.extend(t.wrap.map(wrap));
    w.extend(t.uv_transform.as_flattened().iter().map(|v| v.to_bits()));
    append(words, w)
}
