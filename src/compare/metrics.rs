//! Distances between two pictures.

use super::Picture;
use flip_rs::{DEFAULT_PPD, ErrorMap, RgbImage, ldr_flip};
use rayon::prelude::*;

/// Where two pictures differ most.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Largest {
    /// Absolute difference of one channel.
    pub value: f64,
    /// Column, row.
    pub at: [u32; 2],
    /// 0 red, 1 green, 2 blue, 3 alpha.
    pub channel: usize,
}

/// How far two pictures of one size are apart. Values are sRGB in 0..=1, or linear light where both files hold that.
#[derive(Clone, Debug)]
pub struct Metrics {
    /// Pixels in each picture.
    pub n_pixels: u64,
    /// Values are linear light.
    pub linear: bool,
    /// Alpha was compared as a fourth channel.
    pub alpha: bool,
    /// Pixels with a value that is NaN or infinite, in the first and the second picture; they count in nothing else.
    pub non_finite: [u64; 2],
    /// Root of the mean squared difference, over all channels.
    pub rmse: f64,
    /// The same for red, green, blue, and alpha where it is compared.
    pub rmse_of_channel: Vec<f64>,
    /// Mean absolute difference, over all channels.
    pub mean_absolute: f64,
    /// Pixels that differ at all.
    pub n_different: u64,
    /// The largest difference; of several the first.
    pub largest: Largest,
    /// The largest difference of each pixel's channels, `[height][width]`; NaN for pixels that are no numbers.
    pub difference: Vec<f32>,
    /// FLIP of each pixel, at the reference tool's viewing distance, and its mean; `None` when not asked for or not defined.
    pub flip: Option<(ErrorMap, f64)>,
}

impl Metrics {
    /// Peak signal-to-noise ratio in dB for a peak of 1: infinite for equal pictures.
    pub fn psnr(&self) -> f64 {
        -20.0 * self.rmse.log10()
    }

    /// Pixels whose largest difference is above `threshold`. Rounding of 8-bit values to floats does not count.
    pub fn n_beyond(&self, threshold: f64) -> u64 {
        let threshold = (threshold * (1.0 + 1e-6)) as f32;
        self.difference.par_iter().filter(|d| **d > threshold).count() as u64
    }
}

/// Sums over a part of the pixels.
#[derive(Clone, Copy)]
struct Sums {
    squares: [f64; 4],
    absolute: f64,
    n: u64,
    n_different: u64,
    non_finite: [u64; 2],
    largest: Largest,
}

impl Sums {
    const NONE: Self = Self {
        squares: [0.0; 4],
        absolute: 0.0,
        n: 0,
        n_different: 0,
        non_finite: [0; 2],
        largest: Largest { value: 0.0, at: [0; 2], channel: 0 },
    };

    fn and(mut self, other: Self) -> Self {
        for c in 0..4 {
            self.squares[c] += other.squares[c];
        }
        self.absolute += other.absolute;
        self.n += other.n;
        self.n_different += other.n_different;
        self.non_finite = [self.non_finite[0] + other.non_finite[0], self.non_finite[1] + other.non_finite[1]];
        let (a, b) = (self.largest, other.largest);
        if b.value > a.value || (b.value == a.value && [b.at[1], b.at[0]] < [a.at[1], a.at[0]]) {
            self.largest = b;
        }
        self
    }
}

/// Compares two pictures of one size; `None` when their sizes differ. `flip` asks for FLIP, which takes most of the time.
///
/// Two pictures of linear light are compared in it, all others as they are shown. Alpha is compared when both have it.
pub fn compare(a: Picture, b: Picture, flip: bool) -> Option<Metrics> {
    if (a.width, a.height) != (b.width, b.height) {
        return None;
    }
    let linear = a.linear && b.linear;
    let (a, b) = if linear { (a, b) } else { (a.into_display(), b.into_display()) };
    let alpha = a.has_alpha && b.has_alpha;
    let n_channels = if alpha { 4 } else { 3 };
    let width = a.width as usize;
    let mut difference = vec![0.0f32; a.pixels.len()];
    let sums = difference
        .par_chunks_mut(width)
        .zip(a.pixels.par_chunks(width).zip(b.pixels.par_chunks(width)))
        .enumerate()
        .map(|(y, (out, (a, b)))| sum_row(y as u32, out, a, b, n_channels))
        // In order: the sums do not depend on the number of threads.
        .collect::<Vec<_>>()
        .into_iter()
        .fold(Sums::NONE, Sums::and);
    let n_values = (sums.n * n_channels as u64).max(1) as f64;
    let flip = if flip && sums.non_finite == [0; 2] { flip_of(a, b) } else { None };
    Some(Metrics {
        n_pixels: difference.len() as u64,
        linear,
        alpha,
        non_finite: sums.non_finite,
        rmse: (sums.squares.iter().sum::<f64>() / n_values).sqrt(),
        rmse_of_channel: sums.squares[..n_channels].iter().map(|s| (s / sums.n.max(1) as f64).sqrt()).collect(),
        mean_absolute: sums.absolute / n_values,
        n_different: sums.n_different,
        largest: sums.largest,
        difference,
        flip,
    })
}

fn sum_row(y: u32, out: &mut [f32], a: &[[f32; 4]], b: &[[f32; 4]], n_channels: usize) -> Sums {
    let mut sums = Sums::NONE;
    for (x, (out, (p, q))) in out.iter_mut().zip(a.iter().zip(b)).enumerate() {
        let (p, q) = (&p[..n_channels], &q[..n_channels]);
        let bad = [p, q].map(|v| u64::from(v.iter().any(|v| !v.is_finite())));
        if bad != [0; 2] {
            sums.non_finite = [sums.non_finite[0] + bad[0], sums.non_finite[1] + bad[1]];
            *out = f32::NAN;
            continue;
        }
        let mut worst = 0.0f32;
        for c in 0..n_channels {
            let d = (p[c] - q[c]).abs();
            sums.squares[c] += f64::from(d) * f64::from(d);
            sums.absolute += f64::from(d);
            worst = worst.max(d);
            if f64::from(d) > sums.largest.value {
                sums.largest = Largest { value: d.into(), at: [x as u32, y], channel: c };
            }
        }
        sums.n += 1;
        sums.n_different += u64::from(worst > 0.0);
        *out = worst;
    }
    sums
}

/// FLIP as the reference tool gives it for pictures on a screen. Source: Andersson et al. 2020, DOI 10.1145/3406183.
fn flip_of(a: Picture, b: Picture) -> Option<(ErrorMap, f64)> {
    let plain = |p: Picture| {
        let p = p.into_display();
        let values = p.pixels.iter().flat_map(|p| [p[0], p[1], p[2]]).collect();
        RgbImage::new(p.width as usize, p.height as usize, values).ok()
    };
    let map = ldr_flip(&plain(a)?, &plain(b)?, DEFAULT_PPD).ok()?;
    let mean = map.pixels().iter().map(|v| f64::from(*v)).sum::<f64>() / map.pixels().len() as f64;
    Some((map, mean))
}
