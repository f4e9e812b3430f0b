//! Structural similarity. Source: Wang, Bovik, Sheikh, Simoncelli 2004, with its Gaussian window (11 pixels, sigma 1.5), on each colour
//! channel for values of 0..=1; the mean is over all windows that lie wholly in the picture.

use super::Picture;
use rayon::prelude::*;

/// Pixels on each side of the window's centre.
const RADIUS: usize = 5;
const SIGMA: f64 = 1.5;
/// (0.01 L)^2 and (0.03 L)^2 for L = 1.
const C1: f64 = 1e-4;
const C2: f64 = 9e-4;

/// The mean over all windows (with a mask: those whose centre counts) and colours; `None` where no window fits.
pub(super) fn mean(a: &Picture, b: &Picture, mask: Option<&[bool]>) -> Option<f64> {
    let (w, h) = (a.width as usize, a.height as usize);
    if w <= 2 * RADIUS || h <= 2 * RADIUS {
        return None;
    }
    let weights = window();
    let (sum, n) = (RADIUS..h - RADIUS)
        .into_par_iter()
        .map(|y| {
            let mut sum = 0.0;
            let counted: Vec<usize> = (RADIUS..w - RADIUS).filter(|x| mask.is_none_or(|m| m[y * w + x])).collect();
            for c in 0..3 {
                let columns = vertical(a, b, c, y, &weights);
                sum += counted.iter().map(|&x| similarity(&columns[x - RADIUS..=x + RADIUS], &weights)).sum::<f64>();
            }
            (sum, 3 * counted.len())
        })
        .collect::<Vec<_>>()
        .into_iter()
        .fold((0.0, 0), |(s, n), (t, m)| (s + t, n + m));
    (n > 0).then(|| sum / n as f64)
}

fn window() -> [f64; 2 * RADIUS + 1] {
    let raw: [f64; 2 * RADIUS + 1] = std::array::from_fn(|i| {
        let d = i as f64 - RADIUS as f64;
        (-d * d / (2.0 * SIGMA * SIGMA)).exp()
    });
    raw.map(|v| v / raw.iter().sum::<f64>())
}

/// For each column of row `y`, the weighted means of a, b, a^2, b^2, ab along the column.
fn vertical(a: &Picture, b: &Picture, c: usize, y: usize, weights: &[f64]) -> Vec<[f64; 5]> {
    let w = a.width as usize;
    let mut out = vec![[0.0; 5]; w];
    for (k, weight) in weights.iter().enumerate() {
        let row = (y + k - RADIUS) * w;
        for (x, out) in out.iter_mut().enumerate() {
            let (p, q) = (f64::from(a.pixels[row + x][c]), f64::from(b.pixels[row + x][c]));
            for (out, v) in out.iter_mut().zip([p, q, p * p, q * q, p * q]) {
                *out += weight * v;
            }
        }
    }
    out
}

fn similarity(columns: &[[f64; 5]], weights: &[f64]) -> f64 {
    let mut m = [0.0; 5];
    for (column, weight) in columns.iter().zip(weights) {
        for (m, v) in m.iter_mut().zip(column) {
            *m += weight * v;
        }
    }
    let [a, b, aa, bb, ab] = m;
    (2.0 * a * b + C1) * (2.0 * (ab - a * b) + C2) / ((a * a + b * b + C1) * (aa - a * a + bb - b * b + C2))
}
