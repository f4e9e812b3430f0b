//! PNG.

use super::encoding::Channels;
use super::{Encoding, FileGamma, Film, FilmError, Metadata};
use png::{BitDepth, ColorType, Compression, Encoder, SrgbRenderingIntent};

/// The bytes of a PNG file.
pub(super) fn encode(film: &Film, bits: u8, grayscale: bool, encoding: &Encoding, metadata: &Metadata) -> Result<Vec<u8>, FilmError> {
    let unfit = |e: png::EncodingError| FilmError::Unfit { format: "PNG", reason: e.to_string() };
    let bits = if grayscale { 16 } else { bits.clamp(5, 16) };
    let deep = bits > 8;
    let channels = Channels { grey: grayscale, alpha: encoding.alpha };
    let mut out = Vec::new();
    let mut encoder = Encoder::new(&mut out, film.width, film.height);
    encoder.set_depth(if deep { BitDepth::Sixteen } else { BitDepth::Eight });
    // Three times the time for a twentieth fewer bytes is no good bargain.
    encoder.set_compression(Compression::Fast);
    encoder.set_color(match (grayscale, encoding.alpha) {
        (true, true) => ColorType::GrayscaleAlpha,
        (true, false) => ColorType::Grayscale,
        (false, true) => ColorType::Rgba,
        (false, false) => ColorType::Rgb,
    });
    let gamma = match encoding.written_gamma() {
        FileGamma::Srgb => {
            encoder.set_source_srgb(SrgbRenderingIntent::Perceptual);
            1.0 / 2.2
        }
        FileGamma::Power(g) => 1.0 / g,
    };
    for (keyword, text) in metadata.texts() {
        let latin1 = text.chars().all(|c| u32::from(c) < 256);
        let added = if latin1 { encoder.add_text_chunk(keyword, text) } else { encoder.add_itxt_chunk(keyword, text) };
        added.map_err(unfit)?;
    }
    let mut writer = encoder.write_header().map_err(unfit)?;
    // The encoder leaves gAMA out of files that say sRGB; older readers know that one alone.
    writer.write_chunk(png::chunk::gAMA, &((gamma * 100_000.0).round() as u32).to_be_bytes()).map_err(unfit)?;
    writer.write_chunk(png::chunk::sBIT, &vec![bits; channels.count()]).map_err(unfit)?;
    let values = encoding.quantize(film, channels, ((1u32 << bits) - 1) as u16);
    let data: Vec<u8> = if deep {
        values.iter().flat_map(|v| widen(*v, bits, 16).to_be_bytes()).collect()
    } else {
        values.iter().map(|v| widen(*v, bits, 8) as u8).collect()
    };
    writer.write_image_data(&data).map_err(unfit)?;
    writer.finish().map_err(unfit)?;
    Ok(out)
}

/// A value of `from` bits as one of `to` bits, at most twice as many: its leading bits are repeated.
fn widen(v: u16, from: u8, to: u8) -> u16 {
    let v = u32::from(v) << (to - from);
    (v | v >> from) as u16
}

#[cfg(test)]
mod tests {
    use super::widen;

    #[test]
    fn few_bits_reach_black_and_white() {
        assert_eq!((widen(31, 5, 8), widen(0, 5, 8), widen(4, 5, 8)), (255, 0, 33));
        assert_eq!((widen(511, 9, 16), widen(68, 9, 16)), (65535, 8721));
        assert_eq!((widen(200, 8, 8), widen(60_000, 16, 16)), (200, 60_000));
    }
}
