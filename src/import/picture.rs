//! Image files → pictures of materials: PNG, JPEG and what else the `image` crate is built with.

use crate::scene::material::{MaterialImage, Texels};
use image::DynamicImage;
use std::io::Cursor;

/// Largest side that is accepted, in pixels.
const MAX_SIDE: u32 = 1 << 15;
/// Most memory that one picture may take while it is decoded, in bytes.
const MAX_BYTES: u64 = 2 << 30;

/// Decodes a picture; the reason in words when it cannot.
pub(super) fn decode(bytes: &[u8]) -> Result<MaterialImage, String> {
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
        ImageLuma16(_) | ImageLumaA16(_) | ImageRgb16(_) | ImageRgba16(_) | ImageRgb32F(_) | ImageRgba32F(_) => {
            Texels::Rgba16(decoded.into_rgba16().pixels().map(|p| p.0).collect())
        }
        _ => Texels::Rgba8(decoded.into_rgba8().pixels().map(|p| p.0).collect()),
    };
    Ok(MaterialImage { width, height, texels })
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
