//! Radiance RGBE: linear light, three mantissas and a shared exponent. Source: Ward, Graphics Gems II, 1991; rounding measured.

use super::{Encoding, Film, Metadata};

/// The bytes of a Radiance file.
pub(super) fn encode(film: &Film, encoding: &Encoding, metadata: &Metadata) -> Vec<u8> {
    let mut out = b"#?RADIANCE\n".to_vec();
    for (keyword, text) in metadata.texts() {
        out.extend(format!("# {keyword}: {}\n", text.replace(['\n', '\r'], " ")).bytes());
    }
    out.extend(format!("FORMAT=32-bit_rle_rgbe\n\n-Y {} +X {}\n", film.height, film.width).bytes());
    let width = film.width as usize;
    let packed = (8..=0x7fff).contains(&width);
    for row in film.pixels.chunks(width) {
        let row: Vec<[u8; 4]> = row.iter().map(|p| rgbe([0, 1, 2].map(|c| encoding.linear(p[c])))).collect();
        if packed {
            out.extend([2, 2, (width >> 8) as u8, width as u8]);
            for channel in 0..4 {
                let plane: Vec<u8> = row.iter().map(|p| p[channel]).collect();
                run_lengths(&plane, &mut out);
            }
        } else {
            out.extend(row.iter().flatten());
        }
    }
    out
}

/// Mantissas are cut off, not rounded; what is below 0 or no number is 0.
fn rgbe(light: [f32; 3]) -> [u8; 4] {
    let light = light.map(|v| if v.is_nan() { 0.0 } else { v.clamp(0.0, 1e38) });
    let largest = light.iter().fold(0.0, |a: f32, b| a.max(*b));
    if largest < 1e-32 {
        return [0; 4];
    }
    let exponent = largest.log2().floor() as i32 + 1;
    // The logarithm may round up to the next power.
    let exponent = if f64::from(largest) < 2f64.powi(exponent - 1) { exponent - 1 } else { exponent };
    let scale = 2f64.powi(8 - exponent);
    let [r, g, b] = light.map(|v| (f64::from(v) * scale) as u8);
    [r, g, b, (exponent + 128) as u8]
}

/// Runs of 4 and more as (128 + length, value), the rest as (length, values).
fn run_lengths(plane: &[u8], out: &mut Vec<u8>) {
    let run_at = |i: usize| plane[i..].iter().take(127).take_while(|v| **v == plane[i]).count();
    let mut i = 0;
    while i < plane.len() {
        let run = run_at(i);
        if run >= 4 {
            out.extend([128 + run as u8, plane[i]]);
            i += run;
            continue;
        }
        let mut end = i + run;
        while end < plane.len() && end - i < 128 && run_at(end) < 4 {
            end += 1;
        }
        let end = end.min(i + 128);
        out.push((end - i) as u8);
        out.extend(&plane[i..end]);
        i = end;
    }
}
