//! Image files and images made of functions; height fields; density grids. Source: spec/language.md, section 8.1; spec/textures.md, section 7.

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

/// Images larger than this, in pixels, are refused.
const MAX_PIXELS: u64 = 1 << 28;

/// Images that were decoded, by file and gamma; and what a bump map said of its size.
#[derive(Default)]
pub(super) struct ImageCache {
    known: HashMap<(PathBuf, Option<u64>, bool), Arc<Image>>,
    bump_size: Option<f32>,
}

impl ImageCache {
    /// The `bump_size` inside the last bump_map, once.
    pub(super) fn take_bump_size(&mut self) -> Option<f32> {
        self.bump_size.take()
    }
}

/// Extensions tried for names without one, and the words for them.
const EXTENSIONS: &[&str] = &[
    ".png", ".PNG", ".jpg", ".JPG", ".jpeg", ".JPEG", ".tif", ".TIF", ".tiff", ".TIFF", ".tga", ".TGA", ".ppm", ".PPM", ".pgm", ".PGM",
    ".gif", ".GIF", ".iff", ".IFF", ".bmp", ".BMP", ".exr", ".EXR", ".hdr", ".HDR",
];

/// How the file's numbers become the working space's.
#[derive(Clone, Copy, PartialEq)]
enum Decode {
    /// As they are.
    Raw,
    /// By the file's own rule, then into the working space.
    File,
    /// By a power, then into the working space.
    Power(f64),
}

impl Parser<'_> {
    /// `{ image modifiers }` after `image_map`, `bump_map`, `image_pattern`.
    pub(super) fn parse_image_map(&mut self, what: &str, word: Kw) -> PResult<Arc<ImageMap>> {
        self.block(what, |p| p.image_map_contents(word))
    }

    pub(super) fn image_map_contents(&mut self, word: Kw) -> PResult<Arc<ImageMap>> {
        let colored = word == Kw::ImageMap;
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
        // An old orientation vector is read and ignored.
        if self.at_punct(Punct::Lt)? {
            self.parse_vector3()?;
        }
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
            self.next()?;
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
                decode = if self.accept_kw(Kw::Srgb)? { Decode::File } else { Decode::Power(self.parse_float()?) };
            } else if self.accept_kw(Kw::Premultiplied)? {
                _premultiplied = self.parse_switch()?;
            } else {
                break;
            }
        }
        self.load_image(&name, decode)
    }

    fn load_image(&mut self, name: &str, decode: Decode) -> PResult<Arc<Image>> {
        let Some(path) = self.world.find(name, EXTENSIONS) else {
            self.warn(format!("Possible Parse Error: Cannot find file '{name}'."));
            return Err(self.error(format!("Cannot open image file '{name}'.")));
        };
        let key = match decode {
            Decode::Raw => (path.clone(), None, false),
            Decode::File => (path.clone(), None, true),
            Decode::Power(g) => (path.clone(), Some(g.to_bits()), false),
        };
        if let Some(image) = self.images.known.get(&key) {
            return Ok(image.clone());
        }
        let bytes = self.world.read(&path).map_err(|e| self.error(e.to_string()))?;
        // Before 3.7 without assumed_gamma nothing is corrected.
        let decode =
            if self.scene.settings.gamma == WorkingGamma::None || (self.version < 370 && !self.gamma_set) { Decode::Raw } else { decode };
        let image = decode_image(&bytes, decode, self.scene.settings.gamma, self.version < 370)
            .map_err(|e| self.error(format!("Cannot read image '{name}': {e}.")))?;
        let image = Arc::new(image);
        self.images.known.insert(key, image.clone());
        Ok(image)
    }

    fn function_image(&mut self) -> PResult<Arc<Image>> {
        let w = self.parse_int()?;
        self.comma()?;
        let h = self.parse_int()?;
        self.comma()?;
        if w < 1 || h < 1 || (w as u64).saturating_mul(h as u64) > MAX_PIXELS {
            return Err(self.error("Illegal size of a function image."));
        }
        let f = if let Some(Value::Function(f)) = self.peek_value()? {
            let f = f.clone();
            self.next()?;
            f
        } else {
            self.parse_function()?
        };
        let mut pixels = Vec::with_capacity((w * h) as usize);
        let step = |i: i64, n: i64| if n > 1 { i as f64 / (n - 1) as f64 } else { 0.0 };
        for j in 0..h {
            for i in 0..w {
                let (v, _) = self.query.call(&f, &[step(i, w), step(j, h), 0.0]);
                pixels.push((v[0].clamp(0.0, 1.0) * 65_535.0) as u16);
            }
        }
        Ok(Arc::new(Image {
            width: w as u32,
            height: h as u32,
            pixels: Pixels::Gray16(pixels),
            has_alpha: false,
            deep: true,
            raw_rg: Vec::new(),
        }))
    }

    /// The heights of a height field. Source: spec/objects.md, section 7.
    pub(super) fn parse_heights(&mut self) -> PResult<Arc<HeightGrid>> {
        let image = self.parse_image(false)?;
        let (w, h) = (image.width as usize, image.height as usize);
        if w < 2 || h < 2 {
            return Err(self.error("A height field needs at least 2 by 2 pixels."));
        }
        let height = |i: usize| -> u16 {
            match &image.pixels {
                Pixels::Indexed { indices, .. } => u16::from(indices[i]) << 8,
                Pixels::Gray16(g) if image.deep => g[i],
                // POV-Ray's float arithmetic loses one step in some 8-bit greys.
                Pixels::Gray16(g) => ((f32::from(g[i] / 257) / 255.0) * 65_535.0) as u16,
                Pixels::Color(_) if !image.raw_rg.is_empty() => u16::from_be_bytes(image.raw_rg[i]),
                Pixels::Color(c) => (65_535.0 * crate::math::color::grey(c[i].rgb)) as u16,
            }
        };
        let heights = (0..h).rev().flat_map(|row| (0..w).map(move |col| row * w + col)).map(height).collect();
        Ok(Arc::new(HeightGrid { width: image.width, height: image.height, heights }))
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

fn srgb_to_linear(x: f64) -> f64 {
    if x <= 0.04045 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
}

/// A function from file numbers to working-space numbers.
fn decoder(decode: Decode, working: WorkingGamma, old: bool, file_gamma: Option<f64>) -> impl Fn(f64) -> f32 {
    move |x: f64| {
        let linear = match decode {
            Decode::Raw => return x as f32,
            Decode::Power(g) => x.powf(g),
            // Before 3.7 a file without its own gamma is taken as being in the working space already.
            Decode::File if old && file_gamma.is_none() => return x as f32,
            Decode::File => match file_gamma {
                Some(g) => x.powf(1.0 / g),
                None => srgb_to_linear(x),
            },
        };
        (match working {
            WorkingGamma::Linear | WorkingGamma::None => linear,
            WorkingGamma::Power(g) => linear.powf(1.0 / g),
            WorkingGamma::Srgb => x,
        }) as f32
    }
}

fn decode_image(bytes: &[u8], decode: Decode, working: WorkingGamma, old: bool) -> Result<Image, String> {
    if bytes.starts_with(b"\x89PNG") {
        return decode_png(bytes, decode, working, old);
    }
    let mut reader = image::ImageReader::new(std::io::Cursor::new(bytes)).with_guessed_format().map_err(|e| e.to_string())?;
    if reader.format().is_none() {
        // TGA has no signature.
        reader.set_format(image::ImageFormat::Tga);
    }
    let format = reader.format();
    let hdr = format == Some(image::ImageFormat::Hdr);
    let mut limits = image::Limits::default();
    limits.max_alloc = Some(MAX_PIXELS * 8);
    reader.limits(limits);
    let img = reader.decode().map_err(|e| e.to_string())?;
    if format == Some(image::ImageFormat::Gif) {
        return Ok(palette_of(&img.to_rgba8(), &decoder(decode, working, old, None)));
    }
    let decode = if hdr { Decode::Raw } else { decode };
    Ok(from_dynamic(&img, &decoder(decode, working, old, None)))
}

/// A GIF's colours as a palette again, in the order of first use: indices are the file's own only when it was written so.
fn palette_of(img: &image::RgbaImage, f: &impl Fn(f64) -> f32) -> Image {
    let (mut palette, mut ix) = (Vec::new(), HashMap::new());
    let mut indices = Vec::with_capacity((img.width() * img.height()) as usize);
    for p in img.pixels() {
        let n = ix.len();
        let i = *ix.entry(p.0).or_insert_with(|| {
            palette.push(color_of(p.0.map(|c| f64::from(c) / 255.0), f));
            n.min(255)
        });
        indices.push(i as u8);
    }
    Image {
        width: img.width(),
        height: img.height(),
        pixels: Pixels::Indexed { indices, palette },
        has_alpha: false,
        deep: false,
        raw_rg: Vec::new(),
    }
}

fn color_of(c: [f64; 4], f: &impl Fn(f64) -> f32) -> Rgbft {
    Rgbft { rgb: Vec3::new(f(c[0]), f(c[1]), f(c[2])), filter: 0.0, transmit: (1.0 - c[3]) as f32 }
}

fn from_dynamic(img: &image::DynamicImage, f: &impl Fn(f64) -> f32) -> Image {
    use image::DynamicImage as D;
    let (width, height) = (img.width(), img.height());
    let has_alpha = img.color().has_alpha();
    let deep = !matches!(img, D::ImageLuma8(_) | D::ImageLumaA8(_) | D::ImageRgb8(_) | D::ImageRgba8(_));
    let mut raw_rg = Vec::new();
    let pixels = match img {
        D::ImageLuma8(g) => {
            Pixels::Gray16(g.pixels().map(|p| (f(f64::from(p.0[0]) / 255.0).clamp(0.0, 1.0) * 65_535.0 + 0.5) as u16).collect())
        }
        D::ImageLuma16(g) => {
            Pixels::Gray16(g.pixels().map(|p| (f(f64::from(p.0[0]) / 65_535.0).clamp(0.0, 1.0) * 65_535.0 + 0.5) as u16).collect())
        }
        D::ImageRgb32F(_) | D::ImageRgba32F(_) => {
            Pixels::Color(img.to_rgba32f().pixels().map(|p| color_of(p.0.map(f64::from), f)).collect())
        }
        _ if deep => Pixels::Color(img.to_rgba16().pixels().map(|p| color_of(p.0.map(|c| f64::from(c) / 65_535.0), f)).collect()),
        _ => {
            let rgba = img.to_rgba8();
            raw_rg = rgba.pixels().map(|p| [p.0[0], p.0[1]]).collect();
            let table: Vec<f32> = (0..256).map(|i| f(f64::from(i) / 255.0)).collect();
            Pixels::Color(
                rgba.pixels()
                    .map(|p| {
                        let [r, g, b, a] = p.0;
                        let rgb = Vec3::new(table[r as usize], table[g as usize], table[b as usize]);
                        Rgbft { rgb, filter: 0.0, transmit: 1.0 - f32::from(a) / 255.0 }
                    })
                    .collect(),
            )
        }
    };
    Image { width, height, pixels, has_alpha, deep, raw_rg }
}

/// PNG by its own crate, for palettes and the file's gamma.
fn decode_png(bytes: &[u8], decode: Decode, working: WorkingGamma, old: bool) -> Result<Image, String> {
    let mut decoder_ = png::Decoder::new(std::io::Cursor::new(bytes));
    decoder_.set_transformations(png::Transformations::IDENTITY);
    let mut reader = decoder_.read_info().map_err(|e| e.to_string())?;
    let info = reader.info();
    let (width, height) = (info.width, info.height);
    if u64::from(width) * u64::from(height) > MAX_PIXELS {
        return Err("it is too large".into());
    }
    let file_gamma = if info.srgb.is_some() { None } else { info.gama_chunk.map(|g| f64::from(g.into_value())) };
    // sRGB's own number in a gAMA chunk means sRGB.
    let file_gamma = file_gamma.filter(|g| (g - 0.45455).abs() > 1e-3);
    let f = decoder(decode, working, old && info.srgb.is_none() && info.gama_chunk.is_none(), file_gamma);
    if info.color_type != png::ColorType::Indexed {
        let img = image::load_from_memory_with_format(bytes, image::ImageFormat::Png).map_err(|e| e.to_string())?;
        return Ok(from_dynamic(&img, &f));
    }
    let palette_bytes = info.palette.as_ref().ok_or("it has no palette")?.to_vec();
    let alpha = info.trns.as_ref().map(|t| t.to_vec()).unwrap_or_default();
    let bits = info.bit_depth as usize;
    let palette: Vec<Rgbft> = palette_bytes
        .chunks_exact(3)
        .enumerate()
        .map(|(i, c)| {
            let a = alpha.get(i).copied().unwrap_or(255);
            color_of([c[0], c[1], c[2], a].map(|x| f64::from(x) / 255.0), &f)
        })
        .collect();
    let mut buffer = vec![0; reader.output_buffer_size().ok_or("it is too large")?];
    let frame = reader.next_frame(&mut buffer).map_err(|e| e.to_string())?;
    let mut indices = Vec::with_capacity((width * height) as usize);
    for row in buffer.chunks_exact(frame.line_size).take(height as usize) {
        for x in 0..width as usize {
            let byte = row[x * bits / 8];
            let shift = 8 - bits - (x * bits) % 8;
            let i = (byte >> shift) & ((1u16 << bits) - 1) as u8;
            indices.push(i.min(palette.len().saturating_sub(1) as u8));
        }
    }
    Ok(Image { width, height, pixels: Pixels::Indexed { indices, palette }, has_alpha: !alpha.is_empty(), deep: false, raw_rg: Vec::new() })
}
