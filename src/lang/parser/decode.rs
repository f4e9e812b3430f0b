//! Image files as pixels of the working colour space. What each format's numbers mean was measured with the installed POV-Ray
//! (functions of image maps written out, every format, language versions 3.6 and 3.7).

use crate::math::color::grey;
use crate::math::{Rgbft, Vec3};
use crate::memory::MemoryLimit;
use crate::scene::Image;
use crate::scene::image::Pixels;
use crate::scene::settings::WorkingGamma;
use std::io::Cursor;

/// Images larger than this, in pixels, are refused.
const MAX_PIXELS: u64 = 1 << 28;
/// Bytes of a pixel while its image is decoded.
const PIXEL_COST: u64 = 32;

/// How the file's numbers become the working space's.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Decode {
    /// As they are.
    Raw,
    /// By the file's own rule, then into the working space.
    File,
    /// By sRGB's curve, whatever the file says, then into the working space.
    Srgb,
    /// By a power, then into the working space.
    Power(f64),
}

/// What decoding needs to know.
#[derive(Clone, Copy)]
pub(super) struct Rules {
    /// How to decode.
    pub decode: Decode,
    /// The scene's working space.
    pub working: WorkingGamma,
    /// Before 3.7: a file that does not name its gamma is taken as being in the working space.
    pub old: bool,
    /// Colours are wanted (an image_map), not heights or values.
    pub colored: bool,
    /// A Fractint potential file: 16 bits in two halves.
    pub pot: bool,
    /// Memory that the process may use.
    pub memory: MemoryLimit,
}

/// Refuses sizes that are too large, before anything is decoded.
fn fits(width: u32, height: u32, rules: Rules) -> Result<(), String> {
    let n = u64::from(width) * u64::from(height);
    if n > MAX_PIXELS {
        return Err(format!("it has {width} by {height} pixels, more than the limit of {MAX_PIXELS}"));
    }
    rules.memory.allows(n * PIXEL_COST).map_err(|e| e.to_string())
}

/// What a file's numbers are by themselves.
#[derive(Clone, Copy)]
enum FileSpace {
    /// The file does not say: sRGB from 3.7 on.
    Unknown,
    /// sRGB.
    Srgb,
    /// Encoded with this exponent, as PNG's gAMA chunk gives it.
    Gamma(f64),
    /// Taken as they are by every version (PPM, PGM, TIFF).
    Working,
    /// Linear light (Radiance, EXR).
    Linear,
}

fn srgb_to_linear(x: f64) -> f64 {
    if x <= 0.04045 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
}

fn linear_to_srgb(x: f64) -> f64 {
    if x <= 0.003_130_8 { x * 12.92 } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 }
}

/// From a file's number to the working space's.
fn curve(rules: Rules, space: FileSpace) -> impl Fn(f64) -> f32 {
    move |x: f64| {
        let linear = match (rules.decode, space) {
            (Decode::Raw, _) | (Decode::File, FileSpace::Working) => return x as f32,
            (Decode::File, FileSpace::Unknown) if rules.old => return x as f32,
            (Decode::Power(g), _) => x.powf(g),
            (Decode::Srgb, _) | (Decode::File, FileSpace::Unknown | FileSpace::Srgb) => {
                if rules.working == WorkingGamma::Srgb {
                    return x as f32;
                }
                srgb_to_linear(x)
            }
            (Decode::File, FileSpace::Gamma(g)) => x.powf(1.0 / g),
            (Decode::File, FileSpace::Linear) => x,
        };
        (match rules.working {
            WorkingGamma::Linear | WorkingGamma::None => linear,
            WorkingGamma::Power(g) => linear.powf(1.0 / g),
            WorkingGamma::Srgb => linear_to_srgb(linear),
        }) as f32
    }
}

/// Decodes a file of any known format; the error says why not.
pub(super) fn decode_image(bytes: &[u8], rules: Rules) -> Result<Image, String> {
    use image::ImageFormat as F;
    if bytes.starts_with(b"\x89PNG") {
        return decode_png(bytes, rules);
    }
    if bytes.starts_with(b"GIF8") {
        return decode_gif(bytes, rules);
    }
    if bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01]) {
        return decode_exr(bytes, rules);
    }
    if bytes.starts_with(b"FORM") {
        return Err("IFF files are not supported; convert it to PNG".into());
    }
    let mut reader = image::ImageReader::new(Cursor::new(bytes)).with_guessed_format().map_err(|e| e.to_string())?;
    if reader.format().is_none() {
        // TGA has no signature.
        if let Some(indexed) = indexed_tga(bytes, rules) {
            return indexed;
        }
        reader.set_format(F::Tga);
    }
    let format = reader.format();
    if format == Some(F::Bmp)
        && let Some(indexed) = indexed_bmp(bytes, rules)
    {
        return indexed;
    }
    let mut sizes = image::ImageReader::new(Cursor::new(bytes));
    format.into_iter().for_each(|f| sizes.set_format(f));
    let (width, height) = sizes.into_dimensions().map_err(|e| e.to_string())?;
    fits(width, height, rules)?;
    let mut limits = image::Limits::default();
    limits.max_alloc = Some(MAX_PIXELS * 8);
    reader.limits(limits);
    let img = reader.decode().map_err(|e| e.to_string())?;
    match format {
        Some(F::Tiff) => {
            // Of 16 bits the upper 8 count.
            let rgba = match &img {
                image::DynamicImage::ImageLuma16(_)
                | image::DynamicImage::ImageLumaA16(_)
                | image::DynamicImage::ImageRgb16(_)
                | image::DynamicImage::ImageRgba16(_) => {
                    let deep = img.to_rgba16();
                    let bytes = deep.iter().map(|&c| (c >> 8) as u8).collect();
                    image::RgbaImage::from_raw(deep.width(), deep.height(), bytes).ok_or("it is cut short")?
                }
                _ => img.to_rgba8(),
            };
            Ok(from_tiff(rgba, rules, img.color().has_alpha()))
        }
        Some(F::Pnm) => Ok(from_dynamic(&img, &curve(rules, FileSpace::Working), rules.decode)),
        Some(F::Hdr) => Ok(from_dynamic(&img, &curve(rules, FileSpace::Linear), rules.decode)),
        _ => Ok(from_dynamic(&img, &curve(rules, FileSpace::Unknown), rules.decode)),
    }
}

fn color_of(c: [f64; 4], f: &impl Fn(f64) -> f32) -> Rgbft {
    Rgbft { rgb: Vec3::new(f(c[0]), f(c[1]), f(c[2])), filter: 0.0, transmit: (1.0 - c[3]) as f32 }
}

/// A grey value as POV-Ray stores it after its own weighted sum in single precision, which loses a step here and there.
fn stored_grey(v: f32, most: f32) -> u16 {
    (grey(Vec3::splat(v)) * most) as u16
}

/// A height of a height field from red and green: 256 r + g in steps of 8 bits.
fn height_bytes(rgb: Vec3) -> [u8; 2] {
    ((f64::from(rgb.x) * 255.0 * 256.0 + f64::from(rgb.y) * 255.0).clamp(0.0, 65_535.0) as u16).to_be_bytes()
}

/// Four channels of 8 bits with the tables that they need.
fn from_rgba8(img: &image::RgbaImage, f: &impl Fn(f64) -> f32, decode: Decode, has_alpha: bool) -> Image {
    let table: Vec<f32> = (0..256).map(|i| f(f64::from(i) / 255.0)).collect();
    let colors: Vec<Rgbft> = img
        .pixels()
        .map(|p| {
            let [r, g, b, a] = p.0;
            let rgb = Vec3::new(table[r as usize], table[g as usize], table[b as usize]);
            Rgbft { rgb, filter: 0.0, transmit: 1.0 - f32::from(a) / 255.0 }
        })
        .collect();
    let raw_rg = if decode == Decode::Raw {
        img.pixels().map(|p| [p.0[0], p.0[1]]).collect()
    } else {
        colors.iter().map(|c| height_bytes(c.rgb)).collect()
    };
    Image { width: img.width(), height: img.height(), pixels: Pixels::Color(colors), has_alpha, deep: false, raw_rg }
}

fn from_dynamic(img: &image::DynamicImage, f: &impl Fn(f64) -> f32, decode: Decode) -> Image {
    use image::DynamicImage as D;
    let (width, height) = (img.width(), img.height());
    let has_alpha = img.color().has_alpha();
    // Exact as they are, cut after decoding.
    let to_16 = |v: u16| if decode == Decode::Raw { v } else { (f(f64::from(v) / 65_535.0).clamp(0.0, 1.0) * 65_535.0) as u16 };
    let (pixels, deep) = match img {
        D::ImageLuma8(g) => (Pixels::Gray16(g.pixels().map(|p| to_16(u16::from(p.0[0]) * 257)).collect()), false),
        D::ImageLuma16(g) => (Pixels::Gray16(g.pixels().map(|p| to_16(p.0[0])).collect()), true),
        D::ImageRgb32F(_) | D::ImageRgba32F(_) => {
            (Pixels::Color(img.to_rgba32f().pixels().map(|p| color_of(p.0.map(f64::from), f)).collect()), true)
        }
        D::ImageLumaA8(_) | D::ImageRgb8(_) | D::ImageRgba8(_) => return from_rgba8(&img.to_rgba8(), f, decode, has_alpha),
        _ => (Pixels::Color(img.to_rgba16().pixels().map(|p| color_of(p.0.map(|c| f64::from(c) / 65_535.0), f)).collect()), true),
    };
    Image { width, height, pixels, has_alpha, deep, raw_rg: Vec::new() }
}

/// TIFF is read with 8 bits and with colours multiplied by alpha; image maps divide again.
fn from_tiff(mut img: image::RgbaImage, rules: Rules, has_alpha: bool) -> Image {
    let f = curve(rules, FileSpace::Working);
    if has_alpha {
        for p in img.pixels_mut() {
            let a = u32::from(p.0[3]);
            for c in &mut p.0[..3] {
                *c = ((u32::from(*c) * a + 127) / 255) as u8;
            }
        }
    }
    let mut image = from_rgba8(&img, &f, rules.decode, has_alpha);
    if has_alpha
        && rules.colored
        && let Pixels::Color(colors) = &mut image.pixels
    {
        for c in colors.iter_mut().filter(|c| c.transmit < 1.0) {
            c.rgb /= 1.0 - c.transmit;
        }
    }
    image
}

fn indexed(width: u32, height: u32, indices: Vec<u8>, palette: Vec<Rgbft>) -> Image {
    let has_alpha = palette.iter().any(|c| c.transmit > 0.0);
    let most = palette.len().saturating_sub(1) as u8;
    let indices = indices.into_iter().map(|i| i.min(most)).collect();
    Image { width, height, pixels: Pixels::Indexed { indices, palette }, has_alpha, deep: false, raw_rg: Vec::new() }
}

/// PNG by its own crate: palettes, the file's gamma, and bits as they are.
fn decode_png(bytes: &[u8], rules: Rules) -> Result<Image, String> {
    let mut decoder = png::Decoder::new(Cursor::new(bytes));
    decoder.set_transformations(png::Transformations::IDENTITY);
    let mut reader = decoder.read_info().map_err(|e| e.to_string())?;
    let info = reader.info();
    let (width, height, kind, bits) = (info.width, info.height, info.color_type, info.bit_depth as usize);
    fits(width, height, rules)?;
    let space = match (info.srgb, info.gama_chunk) {
        (Some(_), _) => FileSpace::Srgb,
        (None, Some(g)) if g.into_value() > 0.0 => FileSpace::Gamma(f64::from(g.into_value())),
        _ => FileSpace::Unknown,
    };
    let f = curve(rules, space);
    let palette_bytes = info.palette.as_ref().map(|p| p.to_vec());
    let alpha = info.trns.as_ref().map(|t| t.to_vec()).unwrap_or_default();
    let mut buffer = vec![0; reader.output_buffer_size().ok_or("it is too large")?];
    let frame = reader.next_frame(&mut buffer).map_err(|e| e.to_string())?;
    let rows = buffer.chunks_exact(frame.line_size.max(1)).take(height as usize);
    let n_channels = kind.samples();
    // Every sample in order.
    let mut samples: Vec<u16> = Vec::with_capacity(width as usize * height as usize * n_channels);
    for row in rows {
        match bits {
            16 => samples.extend(row.chunks_exact(2).map(|c| u16::from_be_bytes([c[0], c[1]]))),
            8 => samples.extend(row.iter().map(|&b| u16::from(b))),
            _ => samples.extend((0..width as usize).map(|x| {
                let byte = row[x * bits / 8];
                u16::from((byte >> (8 - bits - (x * bits) % 8)) & ((1u16 << bits) - 1) as u8)
            })),
        }
    }
    let most = f64::from((1u32 << bits) - 1);
    let deep = bits == 16;
    let pixels = match kind {
        png::ColorType::Indexed => {
            let p = palette_bytes.ok_or("it has no palette")?;
            let palette = p.chunks_exact(3).enumerate().map(|(i, c)| {
                let a = alpha.get(i).copied().unwrap_or(255);
                color_of([c[0], c[1], c[2], a].map(|x| f64::from(x) / 255.0), &f)
            });
            return Ok(indexed(width, height, samples.into_iter().map(|s| s as u8).collect(), palette.collect()));
        }
        png::ColorType::Grayscale if rules.decode == Decode::Raw && deep => Pixels::Gray16(samples),
        png::ColorType::Grayscale if deep => {
            Pixels::Gray16(samples.iter().map(|&s| stored_grey(f(f64::from(s) / most), 65_535.0)).collect())
        }
        png::ColorType::Grayscale => Pixels::Gray16(samples.iter().map(|&s| stored_grey(f(f64::from(s) / most), 255.0) * 257).collect()),
        _ if deep => Pixels::Color(
            samples
                .chunks_exact(n_channels)
                .map(|c| {
                    let c = widen(c, 65_535);
                    color_of(c.map(|x| f64::from(x) / most), &f)
                })
                .collect(),
        ),
        _ => {
            let rgba = samples.chunks_exact(n_channels).flat_map(|c| widen(c, 255).map(|x| x as u8)).collect();
            let img = image::RgbaImage::from_raw(width, height, rgba).ok_or("it is cut short")?;
            return Ok(from_rgba8(&img, &f, rules.decode, matches!(n_channels, 2 | 4)));
        }
    };
    Ok(Image { width, height, pixels, has_alpha: matches!(n_channels, 2 | 4), deep, raw_rg: Vec::new() })
}

/// Grey or colour, with or without alpha, as four channels.
fn widen(c: &[u16], most: u16) -> [u16; 4] {
    match *c {
        [g, a] => [g, g, g, a],
        [r, g, b] => [r, g, b, most],
        [r, g, b, a] => [r, g, b, a],
        _ => [c[0], c[0], c[0], most],
    }
}

/// GIF with its own palette; of an animation the first picture.
fn decode_gif(bytes: &[u8], rules: Rules) -> Result<Image, String> {
    let mut options = gif::DecodeOptions::new();
    options.set_color_output(gif::ColorOutput::Indexed);
    options.set_memory_limit(gif::MemoryLimit::Bytes(std::num::NonZeroU64::new(MAX_PIXELS).expect("a constant")));
    let mut decoder = options.read_info(bytes).map_err(|e| e.to_string())?;
    let global = decoder.global_palette().map(<[u8]>::to_vec);
    let frame = decoder.next_frame_info().map_err(|e| e.to_string())?.ok_or("it has no picture")?.clone();
    let (width, height) = (u32::from(frame.width), u32::from(frame.height));
    fits(width, height, rules)?;
    // Rows as they stand in the file: POV-Ray does not put those of interlaced pictures in place (measured).
    let mut indices = vec![0; width as usize * height as usize];
    if !decoder.fill_buffer(&mut indices).map_err(|e| e.to_string())? {
        return Err("it ends too early".into());
    }
    if rules.pot {
        let half = width as usize / 2;
        let rows = indices.chunks_exact((width as usize).max(1));
        let pixels = rows.flat_map(|r| (0..half).map(move |i| u16::from_be_bytes([r[i], r[i + half]]))).collect();
        return Ok(Image { width: half as u32, height, pixels: Pixels::Gray16(pixels), has_alpha: false, deep: true, raw_rg: Vec::new() });
    }
    let p = frame.palette.as_ref().or(global.as_ref()).ok_or("it has no palette")?;
    let f = curve(rules, FileSpace::Unknown);
    let palette = p.chunks_exact(3).enumerate().map(|(i, c)| {
        let a = if frame.transparent == Some(i as u8) { 0.0 } else { 1.0 };
        let [r, g, b] = [c[0], c[1], c[2]].map(|x| f64::from(x) / 255.0);
        color_of([r, g, b, a], &f)
    });
    Ok(indexed(width, height, indices, palette.collect()))
}

/// BMP with at most 8 bits a pixel; `None` for others.
fn indexed_bmp(bytes: &[u8], rules: Rules) -> Option<Result<Image, String>> {
    use image::ImageDecoder;
    let mut decoder = image::codecs::bmp::BmpDecoder::new(Cursor::new(bytes)).ok()?;
    let palette: Vec<[u8; 3]> = decoder.get_palette().filter(|p| !p.is_empty())?.to_vec();
    decoder.set_indexed_color(true);
    let (width, height) = decoder.dimensions();
    if let Err(e) = fits(width, height, rules) {
        return Some(Err(e));
    }
    let mut indices = vec![0; usize::try_from(decoder.total_bytes()).ok()?];
    if let Err(e) = decoder.read_image(&mut indices) {
        return Some(Err(e.to_string()));
    }
    let f = curve(rules, FileSpace::Unknown);
    let palette = palette.iter().map(|c| {
        let [r, g, b] = c.map(|x| f64::from(x) / 255.0);
        color_of([r, g, b, 1.0], &f)
    });
    Some(Ok(indexed(width, height, indices, palette.collect())))
}

/// TGA with a colour map of 24 or 32 bits and indices of 8; `None` for others.
fn indexed_tga(bytes: &[u8], rules: Rules) -> Option<Result<Image, String>> {
    let h: &[u8; 18] = bytes.first_chunk()?;
    let word = |i: usize| usize::from(u16::from_le_bytes([h[i], h[i + 1]]));
    let (first, n_colors, color_bits) = (word(3), word(5), h[7]);
    let (width, height, upwards) = (word(12), word(14), h[17] & 0x20 == 0);
    if h[1] != 1 || !matches!(h[2], 1 | 9) || h[16] != 8 || !matches!(color_bits, 24 | 32) || width * height == 0 {
        return None;
    }
    if let Err(e) = fits(width as u32, height as u32, rules) {
        return Some(Err(e));
    }
    let n_bytes = usize::from(color_bits / 8);
    let map_at = 18 + usize::from(h[0]);
    let map = bytes.get(map_at..map_at + n_colors * n_bytes)?;
    let f = curve(rules, FileSpace::Unknown);
    let mut palette = vec![Rgbft::BLACK; first];
    palette.extend(map.chunks_exact(n_bytes).map(|c| {
        let [r, g, b] = [c[2], c[1], c[0]].map(|x| f64::from(x) / 255.0);
        color_of([r, g, b, 1.0], &f)
    }));
    palette.truncate(256);
    let mut data = bytes[map_at + map.len()..].iter().copied();
    let mut indices = Vec::new();
    while indices.len() < width * height {
        let mut run = || -> Option<(usize, Option<u8>)> {
            if h[2] == 1 {
                return Some((width * height, None));
            }
            let head = data.next()?;
            let n = usize::from(head & 0x7f) + 1;
            Some((n, if head & 0x80 != 0 { Some(data.next()?) } else { None }))
        };
        let Some((n, repeated)) = run() else { return Some(Err("it is cut short".into())) };
        let n = n.min(width * height - indices.len());
        match repeated {
            Some(v) => indices.extend(std::iter::repeat_n(v, n)),
            None => {
                let before = indices.len();
                indices.extend(data.by_ref().take(n));
                if indices.len() < before + n {
                    return Some(Err("it is cut short".into()));
                }
            }
        }
    }
    if upwards {
        indices = indices.chunks_exact(width).rev().flatten().copied().collect();
    }
    Some(Ok(indexed(width as u32, height as u32, indices, palette)))
}

/// The first layer of an EXR file.
fn decode_exr(bytes: &[u8], rules: Rules) -> Result<Image, String> {
    use exr::prelude::{MetaData, ReadChannels, ReadLayers, read};
    let side = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(|e| e.to_string())?;
    meta.headers.iter().try_for_each(|h| fits(side(h.layer_size.width()), side(h.layer_size.height()), rules))?;
    let f = curve(rules, FileSpace::Linear);
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .rgba_channels(
            |size, _| (size.width(), vec![Rgbft::BLACK; size.area()]),
            move |(width, pixels): &mut (usize, Vec<Rgbft>), at, (r, g, b, a): (f32, f32, f32, f32)| {
                pixels[at.y() * *width + at.x()] = color_of([r, g, b, a].map(f64::from), &f);
            },
        )
        .first_valid_layer()
        .all_attributes()
        .from_buffered(Cursor::new(bytes))
        .map_err(|e| e.to_string())?;
    let layer = image.layer_data;
    Ok(Image {
        width: layer.size.width() as u32,
        height: layer.size.height() as u32,
        has_alpha: layer.channel_data.channels.3.is_some(),
        pixels: Pixels::Color(layer.channel_data.pixels.1),
        deep: true,
        raw_rg: Vec::new(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eight_bit_greys_lose_the_steps_that_povray_loses() {
        // Source: spec/objects.md, section 7: 84 of 256 values are one lower.
        let lower: Vec<u16> =
            (0..256).filter(|&g| stored_grey((f64::from(g) / 255.0) as f32, 255.0) < g as u16).map(|g| g as u16).collect();
        assert_eq!(lower.len(), 84);
        assert_eq!(lower[..10], [3, 5, 6, 10, 12, 20, 23, 24, 25, 29]);
        assert_eq!(lower[80..], [244, 247, 248, 254]);
    }

    #[test]
    fn a_tga_with_a_palette_keeps_its_indices() {
        let mut b = vec![0, 1, 9, 0, 0, 3, 0, 24, 0, 0, 0, 0, 3, 0, 1, 0, 8, 0];
        b.extend([0, 0, 255, 0, 255, 0, 255, 0, 0]); // red, green, blue as BGR
        b.extend([0x81, 2, 0, 1]); // twice 2, then 1 as it is
        let rules = Rules {
            decode: Decode::Raw,
            working: WorkingGamma::Linear,
            old: false,
            colored: true,
            pot: false,
            memory: MemoryLimit::default(),
        };
        let image = decode_image(&b, rules).expect("a whole file");
        let Pixels::Indexed { indices, palette } = image.pixels else { panic!("a palette") };
        assert_eq!(indices, [2, 2, 1]);
        assert_eq!(palette[2].rgb, Vec3::Z);
    }

    #[test]
    fn cut_files_are_refused() {
        let rules = Rules {
            decode: Decode::File,
            working: WorkingGamma::Linear,
            old: false,
            colored: true,
            pot: false,
            memory: MemoryLimit::default(),
        };
        for bytes in [&b""[..], b"\x89PNG\r\n\x1a\n", b"GIF89a", b"BM", b"P6\n4 4\n255\nx", &[0x76, 0x2f, 0x31, 0x01, 0, 0]] {
            assert!(decode_image(bytes, rules).is_err());
        }
    }
}
