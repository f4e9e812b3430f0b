//! Pictures into words: their mapping beside the textures, their pixels in a buffer of their own, as small as they allow.

use super::texture_encoder::{TextureEncoder, bits};
use super::texture_layout::{ALPHA_USES, IMAGE, IMAGE_FORMATS, INTERPOLATIONS, MAP_TYPES, kind};
use crate::compile::texture::ImageIx;
use crate::kernel::image::gives_alpha;
use crate::math::Rgbft;
use crate::scene::image::{Image, Interpolation, MapType, Pixels};
use std::collections::HashMap;
use std::sync::Arc;

/// Pixels and grids, each picture once.
#[derive(Default)]
pub(super) struct ImageWords {
    pub words: Vec<u32>,
    /// By address; the tables keep the pictures alive.
    known: HashMap<*const Image, PixelsPlaced>,
    /// Places of the pictures' records.
    records: HashMap<ImageIx, u32>,
}

/// Where pixels stand, and how they are written.
#[derive(Clone, Copy)]
struct PixelsPlaced {
    format: &'static str,
    pixels_at: u32,
    palette_at: u32,
}

impl ImageWords {
    /// Appends words; gives their place.
    pub fn put(&mut self, words: impl IntoIterator<Item = u32>) -> u32 {
        let at = self.words.len() as u32;
        self.words.extend(words);
        at
    }

    fn pixels(&mut self, image: &Arc<Image>) -> PixelsPlaced {
        if let Some(known) = self.known.get(&Arc::as_ptr(image)) {
            return *known;
        }
        let (format, pixels_at, palette_at) = match &image.pixels {
            Pixels::Indexed { indices, palette } => {
                let pixels = self.put(indices.chunks(4).map(|c| c.iter().rev().fold(0, |w, i| w << 8 | u32::from(*i))));
                // Indices beyond the palette are black.
                let colors = (0..256).flat_map(|k| palette.get(k).copied().unwrap_or(Rgbft::BLACK).to_array());
                ("indexed", pixels, self.put(colors.map(f32::to_bits)))
            }
            Pixels::Gray16(values) => {
                let pixels = self.put(values.chunks(2).map(|c| c.iter().rev().fold(0, |w, v| w << 16 | u32::from(*v))));
                ("gray16", pixels, 0)
            }
            Pixels::Color(values) => match as_bytes(values) {
                Some((pixels, tables)) => ("bytes", self.put(pixels), self.put(tables)),
                None => ("floats", self.put(values.iter().flat_map(|c| c.to_array().map(f32::to_bits))), 0),
            },
        };
        let placed = PixelsPlaced { format, pixels_at, palette_at };
        self.known.insert(Arc::as_ptr(image), placed);
        placed
    }
}

/// Pixels as four bytes each and the numbers that the bytes stand for: 256 for colours, then 256 for transmit. `None` for pictures that
/// have more different numbers, as those of more than 8 bits do.
fn as_bytes(values: &[Rgbft]) -> Option<(Vec<u32>, Vec<u32>)> {
    let (mut colors, mut transmits) = (Numbers::default(), Numbers::default());
    let mut pixels = Vec::with_capacity(values.len());
    for c in values {
        if c.filter != 0.0 {
            return None;
        }
        let [r, g, b] = [colors.place(c.rgb.x)?, colors.place(c.rgb.y)?, colors.place(c.rgb.z)?];
        pixels.push(r | g << 8 | b << 16 | transmits.place(c.transmit)? << 24);
    }
    Some((pixels, [colors.list, transmits.list].map(padded).concat()))
}

fn padded(mut list: Vec<u32>) -> Vec<u32> {
    list.resize(256, 0);
    list
}

/// At most 256 different numbers, with their places.
#[derive(Default)]
struct Numbers {
    list: Vec<u32>,
    known: HashMap<u32, u32>,
    last: Option<(u32, u32)>,
}

impl Numbers {
    fn place(&mut self, v: f32) -> Option<u32> {
        let bits = v.to_bits();
        if let Some((_, place)) = self.last.filter(|l| l.0 == bits) {
            return Some(place);
        }
        let next = self.list.len() as u32;
        let place = *self.known.entry(bits).or_insert(next);
        if place == next {
            if next == 256 {
                return None;
            }
            self.list.push(bits);
        }
        self.last = Some((bits, place));
        Some(place)
    }
}

impl TextureEncoder<'_> {
    /// The record of a picture with its mapping.
    pub fn image(&mut self, ix: ImageIx) -> u32 {
        if let Some(at) = self.images.records.get(&ix) {
            return *at;
        }
        let map = self.tables.images[ix as usize].clone();
        let p = self.images.pixels(&map.image);
        self.feature("image_words");
        self.feature(format!("image_{}", p.format));
        let map_type = match map.map_type {
            MapType::Planar => "planar",
            MapType::Spherical => "spherical",
            MapType::Cylindrical => "cylindrical",
            MapType::Torus => "torus",
        };
        let interpolation = match map.interpolation {
            Interpolation::None => "none",
            Interpolation::Bilinear => "bilinear",
            Interpolation::Bicubic => "bicubic",
            Interpolation::NormalizedDistance => "normalized",
        };
        let alpha_use = match (map.use_alpha, gives_alpha(&map)) {
            (false, _) => "none",
            (true, true) => "transmit",
            (true, false) => "red",
        };
        let colored = matches!(map.image.pixels, Pixels::Color(_));
        let indexed = matches!(map.image.pixels, Pixels::Indexed { .. });
        let premultiplied = map.premultiplied && map.image.has_alpha && colored && map.interpolation != Interpolation::None;
        // Palettes have their own.
        let all = |v: f32| if indexed { 0 } else { v.to_bits() };
        let words = IMAGE.words(&[
            ("WIDTH", map.image.width),
            ("HEIGHT", map.image.height),
            ("MAP_TYPE", kind(MAP_TYPES, map_type)),
            ("INTERPOLATION", kind(INTERPOLATIONS, interpolation)),
            ("ONCE", u32::from(map.once)),
            ("REPEAT_U", bits(map.repeat.0)),
            ("REPEAT_V", bits(map.repeat.1)),
            ("OFFSET_U", bits(map.offset.0)),
            ("OFFSET_V", bits(map.offset.1)),
            ("USE_INDEX", u32::from(map.use_index && indexed)),
            ("ALPHA_USE", kind(ALPHA_USES, alpha_use)),
            ("FILTER_ALL", all(map.filter_all)),
            ("TRANSMIT_ALL", all(map.transmit_all)),
            ("PREMULTIPLIED", u32::from(premultiplied)),
            ("FORMAT", kind(IMAGE_FORMATS, p.format)),
            ("PIXELS_AT", p.pixels_at),
            ("PALETTE_AT", p.palette_at),
        ]);
        let at = self.put(words);
        self.images.records.insert(ix, at);
        at
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_of_few_different_numbers_become_bytes_and_others_do_not() {
        let of = |n: u32| (0..n).map(|k| Rgbft::rgb(k as f32 / n as f32, 0.0, 0.0)).collect::<Vec<_>>();
        let values = of(256);
        let (pixels, tables) = as_bytes(&values).expect("256 different numbers");
        let red = |k: usize| f32::from_bits(tables[(pixels[k] & 255) as usize]);
        assert!((0..256).all(|k| red(k) == values[k].rgb.x));
        assert!(as_bytes(&of(257)).is_none());
        assert!(as_bytes(&[Rgbft { filter: 0.5, ..Rgbft::BLACK }]).is_none());
    }
}
