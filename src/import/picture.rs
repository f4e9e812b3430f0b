//! Image files → pictures of materials: PNG, JPEG, OpenEXR and what else the `image` crate is built with.

use crate::scene::material::{MaterialImage, Texels};
use image::DynamicImage;
use std::io::Cursor;

/// Largest side that is accepted, in pixels.
const MAX_SIDE: u32 = 1 << 15;
/// Most memory that one picture may take while it is decoded, in bytes.
const MAX_BYTES: u64 = 2 << 30;

/// How OpenEXR files begin.
const EXR_MAGIC: &[u8] = &[0x76, 0x2f, 0x31, 0x01];

/// Linear value of an sRGB-encoded one, 0..=1. Source: IEC 61966-2-1.
pub(super) fn linear_from_srgb(v: f32) -> f32 {
    if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
}

/// Decodes a picture; the reason in words when it cannot.
pub(super) fn decode(bytes: &[u8]) -> Result<MaterialImage, String> {
    if bytes.starts_with(EXR_MAGIC) {
        return decode_exr(bytes);
    }
    let mut reader = image::ImageReader::new(Cursor::new(bytes)).with_guessed_format().map_err(|e| e.to_string())?;
    let mut limits = image::Limits::default();
    limits.max_image_width = Some(MAX_SIDE);
    limits.max_image_height = Some(MAX_SIDE);
    limits.max_alloc = Some(MAX_BYTES);
    reader.limits(limits);
    let decoded = reader.decode().map_err(|e| e.to_string())?;
    let (width, height) = (decoded.width(), decoded.height());
    if width == 0 || height == 0 {
        return Err("it has no pixels".into());
    }
    use DynamicImage::{ImageLuma16, ImageLumaA16, ImageRgb16, ImageRgb32F, ImageRgba16, ImageRgba32F};
    let texels = match decoded {
        ImageRgb32F(_) | ImageRgba32F(_) => Texels::RgbaF32(decoded.into_rgba32f().pixels().map(|p| p.0).collect()),
        ImageLuma16(_) | ImageLumaA16(_) | ImageRgb16(_) | ImageRgba16(_) => {
            Texels::Rgba16(decoded.into_rgba16().pixels().map(|p| p.0).collect())
        }
        _ => Texels::Rgba8(decoded.into_rgba8().pixels().map(|p| p.0).collect()),
    };
    Ok(MaterialImage { width, height, texels })
}

/// The first layer of an OpenEXR with colours, or with grey alone. Numbers that are not finite become 0.
fn decode_exr(bytes: &[u8]) -> Result<MaterialImage, String> {
    use exr::prelude::*;
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))
        .map_err(|e| e.to_string())?;
    let layer = &image.layer_data;
    let (width, height) = (layer.size.width(), layer.size.height());
    if width == 0 || height == 0 || width > MAX_SIDE as usize || height > MAX_SIDE as usize {
        return Err(format!("it has {width} by {height} pixels"));
    }
    let channel = |name: &str| {
        let of = |c: &AnyChannel<FlatSamples>| c.name.to_string().eq_ignore_ascii_case(name) && c.sampling == Vec2(1, 1);
        layer.channel_data.list.iter().find(|c| of(c)).map(|c| &c.sample_data)
    };
    let gray = channel("Y");
    let colors = ["R", "G", "B"].map(|name| channel(name).or(gray));
    let [Some(r), Some(g), Some(b)] = colors else { return Err("it has no channels R, G, B or Y".into()) };
    let alpha = channel("A");
    let finite = |v: f32| if v.is_finite() { v } else { 0.0 };
    let texel = |k: usize| {
        let at = |c: &FlatSamples| finite(c.value_by_flat_index(k).to_f32());
        [at(r), at(g), at(b), alpha.map_or(1.0, at)]
    };
    let texels = Texels::RgbaF32((0..width * height).map(texel).collect());
    Ok(MaterialImage { width: width as u32, height: height as u32, texels })
}

#[cfg(test)]
pub(super) fn png_of(width: u32, height: u32, pixel: impl Fn(u32, u32) -> [u8; 4]) -> Vec<u8> {
    let mut out = Vec::new();
    let image = image::RgbaImage::from_fn(width, height, |x, y| image::Rgba(pixel(x, y)));
    image.write_to(&mut Cursor::new(&mut out), image::ImageFormat::Png).expect("a PNG in memory");
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn png_keeps_its_rows_and_its_alpha() {
        let p = decode(&png_of(2, 2, |x, y| [x as u8, y as u8, 7, 100])).expect("a PNG");
        assert_eq!(p.texels, Texels::Rgba8(vec![[0, 0, 7, 100], [1, 0, 7, 100], [0, 1, 7, 100], [1, 1, 7, 100]]));
    }

    #[test]
    fn broken_pictures_say_why() {
        assert!(decode(b"not a picture").is_err());
        let whole = png_of(16, 16, |x, y| [x as u8, y as u8, 0, 255]);
        assert!(decode(&whole[..whole.len() / 2]).is_err());
    }
}
