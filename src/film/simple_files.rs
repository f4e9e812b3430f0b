//! Formats that are a header and rows of numbers: PPM and PGM, BMP, Targa, and JPEG through its encoder.

use super::encoding::Channels;
use super::{Encoding, Film, FilmError, Metadata};

/// Binary PPM; PGM with `grayscale`. Values above 8 bits are two bytes, high byte first.
///
/// POV-Ray's own PGM holds two bytes a value without gamma under any header, which no reader takes; ours is a PGM.
pub(super) fn ppm(film: &Film, bits: u8, grayscale: bool, encoding: &Encoding, metadata: &Metadata) -> Vec<u8> {
    let max = ((1u32 << bits.clamp(5, 16)) - 1) as u16;
    let mut out = format!("P{}\n", if grayscale { 5 } else { 6 }).into_bytes();
    for (keyword, text) in metadata.texts() {
        out.extend(format!("# {keyword}: {}\n", text.replace(['\n', '\r'], " ")).bytes());
    }
    out.extend(format!("{} {}\n{max}\n", film.width, film.height).bytes());
    let values = encoding.quantize(film, Channels { grey: grayscale, alpha: false }, max);
    if max > 255 {
        out.extend(values.iter().flat_map(|v| v.to_be_bytes()));
    } else {
        out.extend(values.iter().map(|v| *v as u8));
    }
    out
}

/// Blue, green, red (and alpha) of every pixel, `[height][width][3 or 4]`.
fn bgr(film: &Film, encoding: &Encoding) -> (Vec<u8>, usize) {
    let channels = Channels { grey: false, alpha: encoding.alpha };
    let mut bytes: Vec<u8> = encoding.quantize(film, channels, 255).iter().map(|v| *v as u8).collect();
    for pixel in bytes.chunks_mut(channels.count()) {
        pixel.swap(0, 2);
    }
    (bytes, channels.count())
}

/// Windows bitmap of 24 bits a pixel, 32 with alpha; bottom row first.
pub(super) fn bmp(film: &Film, encoding: &Encoding) -> Result<Vec<u8>, FilmError> {
    let (bytes, n) = bgr(film, encoding);
    let row = film.width as usize * n;
    let padding = row.next_multiple_of(4) - row;
    let size = (row + padding) * film.height as usize;
    let unfit = |_| FilmError::Unfit { format: "BMP", reason: "a BMP holds at most 2 GiB".into() };
    let total = i32::try_from(size + 54).map_err(unfit)?;
    let mut out = Vec::with_capacity(size + 54);
    out.extend(b"BM");
    for v in [total, 0, 54, 40, film.width as i32, film.height as i32] {
        out.extend(v.to_le_bytes());
    }
    out.extend([1, 0, 8 * n as u8, 0]);
    for v in [0, size as i32, 0, 0, 0, 0] {
        out.extend(v.to_le_bytes());
    }
    for row in bytes.chunks(row).rev() {
        out.extend(row);
        out.extend(&[0; 3][..padding]);
    }
    Ok(out)
}

/// Targa of 24 bits a pixel, 32 with alpha; top row first, with the footer that says that alpha is alpha.
pub(super) fn targa(film: &Film, rle: bool, encoding: &Encoding, metadata: &Metadata) -> Result<Vec<u8>, FilmError> {
    let unfit = |_| FilmError::Unfit { format: "Targa", reason: "a Targa file has at most 65535 columns and rows".into() };
    let (width, height) = (u16::try_from(film.width).map_err(unfit)?, u16::try_from(film.height).map_err(unfit)?);
    let (bytes, n) = bgr(film, encoding);
    let mut out = vec![0, 0, if rle { 10 } else { 2 }, 0, 0, 0, 0, 0, 0, 0, 0, 0];
    out.extend(width.to_le_bytes());
    out.extend(height.to_le_bytes());
    // Top-left origin; 8 bits of attribute are alpha.
    out.extend([8 * n as u8, 0x20 | if encoding.alpha { 8 } else { 0 }]);
    if rle {
        for row in bytes.chunks(usize::from(width) * n) {
            run_lengths(row, n, &mut out);
        }
    } else {
        out.extend(bytes);
    }
    let extension_at = out.len() as u32;
    out.extend(extension_area(encoding, metadata));
    out.extend(extension_at.to_le_bytes());
    out.extend(0u32.to_le_bytes());
    out.extend(b"TRUEVISION-XFILE.\0");
    Ok(out)
}

/// Targa 2.0's extension area: the software's name and what the fourth channel is.
fn extension_area(encoding: &Encoding, metadata: &Metadata) -> [u8; 495] {
    let mut area = [0; 495];
    area[..2].copy_from_slice(&495u16.to_le_bytes());
    for (to, from) in area[426..466].iter_mut().zip(metadata.software.bytes().filter(u8::is_ascii)) {
        *to = from;
    }
    area[494] = if encoding.alpha { 3 } else { 0 };
    area
}

/// Packets of at most 128 pixels of `n` bytes: a run of one pixel, or pixels as they are.
fn run_lengths(row: &[u8], n: usize, out: &mut Vec<u8>) {
    let pixels: Vec<&[u8]> = row.chunks(n).collect();
    let mut i = 0;
    while i < pixels.len() {
        let rest = &pixels[i..pixels.len().min(i + 128)];
        let run = rest.iter().take_while(|p| **p == rest[0]).count();
        if run > 1 {
            out.push(0x80 | (run - 1) as u8);
            out.extend(rest[0]);
            i += run;
        } else {
            let raw = rest.windows(2).position(|w| w[0] == w[1]).unwrap_or(rest.len());
            out.push((raw - 1) as u8);
            out.extend(rest[..raw].iter().flat_map(|p| p.iter()));
            i += raw;
        }
    }
}

/// JPEG without subsampling.
pub(super) fn jpeg(film: &Film, quality: u8, encoding: &Encoding) -> Result<Vec<u8>, FilmError> {
    let bytes: Vec<u8> = encoding.quantize(film, Channels { grey: false, alpha: false }, 255).iter().map(|v| *v as u8).collect();
    let mut out = Vec::new();
    image::codecs::jpeg::JpegEncoder::new_with_quality(&mut out, quality.clamp(1, 100))
        .encode(&bytes, film.width, film.height, image::ExtendedColorType::Rgb8)
        .map_err(|e| FilmError::Unfit { format: "JPEG", reason: e.to_string() })?;
    Ok(out)
}
