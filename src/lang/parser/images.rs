//! Image files and images made of functions; height fields; density grids. Source: spec/language.md, section 8.1; spec/textures.md, section 7.

use super::decode::{Decode, Rules, decode_image};
use super::{PResult, Parser};
use crate::lang::keyword::Kw;
use crate::lang::token::{Punct, TokenKind};
use crate::lang::value::Value;
use crate::math::{Rgbft, Vec3};
use crate::scene::image::{Interpolation, MapType, Pixels};
use crate::scene::pattern::DensityGrid;
use crate::scene::settings::WorkingGamma;
use crate::scene::shape::HeightGrid;
use crate::scene::{Image, ImageMap};
use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;

/// Images that were decoded, by file and gamma; and what a bump map said of its size.
#[derive(Default)]
pub(super) struct ImageCache {
    known: HashMap<(PathBuf, u64, bool, bool), Arc<Image>>,
    bump_size: Option<f32>,
}

impl ImageCache {
    /// The `bump_size` inside the last bump_map, once.
    pub(super) fn take_bump_size(&mut self) -> Option<f32> {
        self.bump_size.take()
    }
}

/// Most pixels of an image that a function makes: each is a call.
const MAX_FUNCTION_PIXELS: u64 = 1 << 26;

/// Extensions tried for names without one, and the words for them.
const EXTENSIONS: &[&str] = &[
    ".png", ".PNG", ".jpg", ".JPG", ".jpeg", ".JPEG", ".tif", ".TIF", ".tiff", ".TIFF", ".tga", ".TGA", ".ppm", ".PPM", ".pgm", ".PGM",
    ".gif", ".GIF", ".iff", ".IFF", ".bmp", ".BMP", ".exr", ".EXR", ".hdr", ".HDR",
];

impl Parser<'_> {
    /// `{ image modifiers }` after `image_map`, `bump_map`, `image_pattern`.
    pub(super) fn parse_image_map(&mut self, what: &str, word: Kw) -> PResult<Arc<ImageMap>> {
        self.block(what, |p| p.image_map_contents(word))
    }

    pub(super) fn image_map_contents(&mut self, word: Kw) -> PResult<Arc<ImageMap>> {
        let colored = word == Kw::ImageMap;
        if self.at_punct(Punct::Lt)? {
            self.parse_vector3()?;
            self.warn("Old style orientation vector or map type not supported. Ignoring value.");
        }
        let image = self.parse_image(colored)?;
        let mut map = ImageMap {
            image,
            map_type: MapType::Planar,
            interpolation: Interpolation::None,
            once: false,
            repeat: (1.0, 1.0),
            offset: (0.0, 0.0),
            use_index: word == Kw::MaterialMap,
            use_alpha: false,
            filter_all: 0.0,
            transmit_all: 0.0,
            premultiplied: false,
        };
        self.image_modifiers(&mut map, word)?;
        Ok(Arc::new(map))
    }

    fn image_modifiers(&mut self, map: &mut ImageMap, word: Kw) -> PResult<()> {
        loop {
            self.comma()?;
            let Some(k) = self.peek_kw()? else { return Ok(()) };
            match k {
                Kw::Once => {
                    self.next()?;
                    map.once = true;
                }
                Kw::Interpolate => {
                    self.next()?;
                    map.interpolation = match self.parse_int()? {
                        2 => Interpolation::Bilinear,
                        3 => Interpolation::Bicubic,
                        4 => Interpolation::NormalizedDistance,
                        _ if word == Kw::ImageMap => return Err(self.error("Invalid interpolate value.")),
                        _ => Interpolation::None,
                    };
                }
                Kw::MapType => {
                    self.next()?;
                    map.map_type = match self.parse_int()? {
                        0 => MapType::Planar,
                        1 => MapType::Spherical,
                        2 => MapType::Cylindrical,
                        5 => MapType::Torus,
                        _ if word == Kw::ImageMap => return Err(self.error("Invalid map_type value.")),
                        _ => MapType::Planar,
                    };
                }
                Kw::UseColor => {
                    self.next()?;
                    map.use_index = false;
                }
                Kw::UseIndex => {
                    self.next()?;
                    map.use_index = word != Kw::ImagePattern;
                }
                Kw::UseAlpha => {
                    self.next()?;
                    map.use_alpha = true;
                }
                Kw::BumpSize => {
                    self.next()?;
                    self.images.bump_size = Some(self.parse_float()? as f32);
                }
                Kw::Repeat => {
                    self.next()?;
                    let v = self.parse_vector2()?;
                    if !(v.x > 0.0 && v.y > 0.0) {
                        return Err(self.error("Image repeat values must be positive."));
                    }
                    map.repeat = (v.x, v.y);
                }
                Kw::Offset => {
                    self.next()?;
                    let v = self.parse_vector2()?;
                    map.offset = (v.x, v.y);
                }
                Kw::Filter | Kw::Transmit => {
                    self.next()?;
                    self.image_transparency(map, k)?;
                }
                _ => return Ok(()),
            }
        }
    }

    fn image_transparency(&mut self, map: &mut ImageMap, k: Kw) -> PResult<()> {
        let all = self.accept_kw(Kw::All)?;
        let index = if all { 0 } else { self.parse_int()? };
        self.comma()?;
        let x = self.parse_float()? as f32;
        let mut image = (*map.image).clone();
        let Pixels::Indexed { palette, .. } = &mut image.pixels else {
            if !all {
                return Err(self.error(format!("{} of a single index is possible only for images with a palette.", k.text())));
            }
            if k == Kw::Filter {
                map.filter_all = x
            } else {
                map.transmit_all = x
            }
            return Ok(());
        };
        if !all && (index < 0 || index as usize >= palette.len()) {
            return Err(self.error(format!("{} index value exceeds the image's colors.", k.text())));
        }
        let chosen: &mut [Rgbft] = if all { palette } else { &mut palette[index as usize..=index as usize] };
        for c in chosen {
            if k == Kw::Filter { c.filter = x } else { c.transmit = x }
        }
        map.image = Arc::new(image);
        Ok(())
    }

    /// An image's source: a file (with its format's word or not) or a function.
    fn parse_image(&mut self, colored: bool) -> PResult<Arc<Image>> {
        if self.accept_kw(Kw::Function)? {
            return self.function_image();
        }
        let mut pot = false;
        if let Some(
            Kw::Gif
            | Kw::Tga
            | Kw::Png
            | Kw::Ppm
            | Kw::Pgm
            | Kw::Jpeg
            | Kw::Tiff
            | Kw::Bmp
            | Kw::Exr
            | Kw::Hdr
            | Kw::Iff
            | Kw::Pot
            | Kw::Sys,
        ) = self.peek_kw()?
        {
            pot = self.next()?.kind == TokenKind::Kw(Kw::Pot);
        } else if !matches!(
            self.peek()?.kind,
            TokenKind::Str(_) | TokenKind::Kw(Kw::Concat | Kw::Str | Kw::Substr | Kw::Strlwr | Kw::Strupr | Kw::Chr)
        ) {
            return self.expected("map file spec");
        }
        let name = self.parse_file_name()?;
        let mut decode = if colored { Decode::File } else { Decode::Raw };
        let mut _premultiplied = false;
        loop {
            if self.accept_kw(Kw::Gamma)? {
                decode = if self.accept_kw(Kw::Srgb)? { Decode::Srgb } else { Decode::Power(self.parse_float()?) };
            } else if self.accept_kw(Kw::Premultiplied)? {
                _premultiplied = self.parse_switch()?;
            } else {
                break;
            }
        }
        self.load_image(&name, decode, colored, pot)
    }

    fn load_image(&mut self, name: &str, decode: Decode, colored: bool, pot: bool) -> PResult<Arc<Image>> {
        let Some(path) = self.world.find(name, EXTENSIONS) else {
            self.warn(format!("Possible Parse Error: Cannot find file '{name}', even after trying to append file type extension."));
            return Err(self.error(format!("Cannot open image file '{name}'.")));
        };
        let pot = pot || path.extension().is_some_and(|e| e.eq_ignore_ascii_case("pot"));
        let old = !self.version_set || self.version < 370;
        // Before 3.7 without assumed_gamma nothing is corrected that does not say so.
        let decode = if decode == Decode::File && old && !self.gamma_set { Decode::Raw } else { decode };
        let how = match decode {
            Decode::Raw => 0,
            Decode::File => 1,
            Decode::Srgb => 2,
            Decode::Power(g) => g.to_bits(),
        };
        let key = (path.clone(), how, colored, pot);
        if let Some(image) = self.images.known.get(&key) {
            return Ok(image.clone());
        }
        let bytes = self.world.read(&path).map_err(|e| self.error(e.to_string()))?;
        // Heights and values stay as a `gamma` decodes them, whatever space the scene works in (measured).
        let working = if colored { self.scene.settings.gamma } else { WorkingGamma::Linear };
        let rules = Rules { decode, working, old, colored, pot, memory: self.options.memory };
        let image = decode_image(&bytes, rules).map_err(|e| self.error(format!("Cannot read image '{name}': {e}.")))?;
        let image = Arc::new(image);
        self.images.known.insert(key, image.clone());
        Ok(image)
    }

    fn function_image(&mut self) -> PResult<Arc<Image>> {
        let w = self.parse_int()?;
        self.comma()?;
        let h = self.parse_int()?;
        self.comma()?;
        if w < 1 || h < 1 || (w as u64).saturating_mul(h as u64) > MAX_FUNCTION_PIXELS {
            return Err(self.error(format!("Illegal size of a function image (1 to {MAX_FUNCTION_PIXELS} pixels are possible).")));
        }
        let f = if let Some(Value::Function(f)) = self.peek_value()? {
            let f = f.clone();
            self.next()?;
            f
        } else {
            self.parse_function_block(3)?
        };
        // Colours take most.
        self.charge((w * h) as usize * size_of::<Rgbft>())?;
        let step = |i: i64, n: i64| if n > 1 { i as f64 / (n - 1) as f64 } else { 0.0 };
        let quantised = |v: f64| (v.clamp(0.0, 1.0) * 65_535.0) as u16;
        let (mut greys, mut colors) = (Vec::new(), Vec::new());
        for j in 0..h {
            for i in 0..w {
                let (v, n) = self.query.call(&f, &[step(i, w), step(j, h), 0.0]);
                if n < 5 {
                    greys.push(quantised(v[0]));
                } else {
                    // A pigment gives colour and transmit; its filter is lost.
                    let [r, g, b, t] = [v[0], v[1], v[2], v[4]].map(|v| f32::from(quantised(v)) / 65_535.0);
                    colors.push(Rgbft { rgb: Vec3::new(r, g, b), filter: 0.0, transmit: t });
                }
            }
        }
        let has_alpha = colors.iter().any(|c| c.transmit > 0.0);
        Ok(Arc::new(Image {
            width: w as u32,
            height: h as u32,
            pixels: if greys.is_empty() { Pixels::Color(colors) } else { Pixels::Gray16(greys) },
            has_alpha,
            deep: true,
            raw_rg: Vec::new(),
        }))
    }

    /// The heights of a height field. Source: spec/objects.md, section 7.
    pub(super) fn parse_heights(&mut self) -> PResult<Arc<HeightGrid>> {
        let image = self.parse_image(false)?;
        let (w, h) = (image.width as usize, image.height as usize);
        if w < 1 || h < 1 {
            return Err(self.error("A height field needs at least one pixel."));
        }
        let height = |i: usize| -> u16 {
            match &image.pixels {
                Pixels::Indexed { indices, .. } => u16::from(indices[i]) << 8,
                Pixels::Gray16(g) => g[i],
                Pixels::Color(_) if !image.raw_rg.is_empty() => u16::from_be_bytes(image.raw_rg[i]),
                Pixels::Color(c) => (65_535.0 * crate::math::color::grey(c[i].rgb)) as u16,
            }
        };
        // A single row or column is there twice, so that there are cells.
        let (w2, h2) = (w.max(2), h.max(2));
        let pixel = |row: usize, col: usize| row.min(h - 1) * w + col.min(w - 1);
        let heights = (0..h2).rev().flat_map(|row| (0..w2).map(move |col| pixel(row, col))).map(height).collect();
        Ok(Arc::new(HeightGrid { width: w2 as u32, height: h2 as u32, heights }))
    }

    /// A df3 file: three big-endian sizes, then 8, 16 or 32 bits a cell.
    pub(super) fn density_grid(&mut self, name: &str) -> PResult<Arc<DensityGrid>> {
        let Some(path) = self.world.find(name, &[".df3", ".DF3"]) else {
            return Err(self.error(format!("Cannot open density file '{name}'.")));
        };
        let b = self.world.read(&path).map_err(|e| self.error(e.to_string()))?;
        if b.len() < 6 {
            return Err(self.error(format!("Density file '{name}' is too short.")));
        }
        let size = [0, 2, 4].map(|i| u32::from(u16::from_be_bytes([b[i], b[i + 1]])));
        let n = size.iter().map(|&s| s as usize).product::<usize>();
        let data = &b[6..];
        let depth = data.len().checked_div(n).unwrap_or(0);
        let values: Vec<f32> = match depth {
            0 => return Err(self.error(format!("Density file '{name}' is too short."))),
            1 => data[..n].iter().map(|&x| f32::from(x) / 255.0).collect(),
            2 | 3 => data[..2 * n].chunks_exact(2).map(|c| f32::from(u16::from_be_bytes([c[0], c[1]])) / 65_535.0).collect(),
            _ => {
                let u = |c: &[u8]| u32::from_be_bytes([c[0], c[1], c[2], c[3]]);
                data[..4 * n].chunks_exact(4).map(|c| (f64::from(u(c)) / f64::from(u32::MAX)) as f32).collect()
            }
        };
        Ok(Arc::new(DensityGrid { size, values }))
    }
}
