//! Distances as pictures, in the magma palette: black is equal, white as different as can be.

use super::Metrics;
use flip_rs::MAGMA;
use image::{Rgb, RgbImage};

/// What stands for pixels that are NaN or infinite: no colour of the palette.
const NOT_A_NUMBER: Rgb<u8> = Rgb([0, 255, 0]);

/// Each pixel's largest difference on a logarithmic scale, so that 1/255 is seen: an eighth of the way up, 255/255 at the top.
pub fn difference_map(m: &Metrics, width: u32, height: u32) -> RgbImage {
    paint(&m.difference, width, height, |d| (1.0 + 255.0 * d).log2() / 8.0)
}

/// Each pixel's FLIP, as the reference tool paints it; `None` when there is no FLIP.
pub fn flip_map(m: &Metrics) -> Option<RgbImage> {
    let (map, _) = m.flip.as_ref()?;
    Some(paint(map.pixels(), map.width() as u32, map.height() as u32, |v| v))
}

fn paint(values: &[f32], width: u32, height: u32, scale: impl Fn(f32) -> f32) -> RgbImage {
    RgbImage::from_fn(width, height, |x, y| {
        let v = values[y as usize * width as usize + x as usize];
        if v.is_nan() {
            return NOT_A_NUMBER;
        }
        let index = (scale(v).clamp(0.0, 1.0) * 255.0 + 0.5) as usize;
        Rgb(MAGMA[index].map(|c| (c * 255.0 + 0.5) as u8))
    })
}
