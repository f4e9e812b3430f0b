//! PNG.

use super::{Encoding, FileGamma, Film, FilmError, Metadata};
use png::{BitDepth, ColorType, Encoder, ScaledFloat, SrgbRenderingIntent};

/// The bytes of a PNG file.
pub(super) fn encode(film: &Film, bits: u8, grayscale: bool, encoding: &Encoding, metadata: &Metadata) -> Result<Vec<u8>, FilmError> {
    let unfit = |e: png::EncodingError| FilmError::Unfit { format: "PNG", reason: e.to_string() };
    let deep = bits > 8 || grayscale;
    let mut out = Vec::new();
    let mut encoder = Encoder::new(&mut out, film.width, film.height);
    encoder.set_depth(if deep { BitDepth::Sixteen } else { BitDepth::Eight });
    encoder.set_color(if grayscale { ColorType::Grayscale } else { ColorType::Rgb });
    match encoding.file_gamma {
        FileGamma::Srgb => encoder.set_source_srgb(SrgbRenderingIntent::Perceptual),
        FileGamma::Power(g) => encoder.set_source_gamma(ScaledFloat::new((1.0 / g) as f32)),
    }
    encoder.add_text_chunk("Software".into(), metadata.software.clone()).map_err(unfit)?;
    let mut writer = encoder.write_header().map_err(unfit)?;
    let mut data = Vec::new();
    for p in &film.pixels {
        let encoded = [0, 1, 2].map(|c| encoding.encode(f64::from(p[c])).clamp(0.0, 1.0));
        let grey = 0.297 * encoded[0] + 0.589 * encoded[1] + 0.114 * encoded[2];
        let values = if grayscale { &[grey][..] } else { &encoded[..] };
        for v in values {
            if deep {
                data.extend(((v * 65535.0 + 0.5) as u16).to_be_bytes());
            } else {
                data.push((v * 255.0 + 0.5) as u8);
            }
        }
    }
    writer.write_image_data(&data).map_err(unfit)?;
    writer.finish().map_err(unfit)?;
    Ok(out)
}
