//! Distances between two pictures.

use super::{Picture, perceived, ssim};
use flip_rs::ErrorMap;
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

/// In what values are compared.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Space {
    /// In linear light when both pictures hold it, else as shown.
    #[default]
    Auto,
    /// In linear light, without an upper end.
    Linear,
    /// As shown on a screen: sRGB in 0..=1.
    Display,
}

/// Which FLIP is computed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Flip {
    /// None; it takes most of the time.
    None,
    /// Of the pictures as shown.
    #[default]
    Ldr,
    /// Of linear light, over all exposures at which something shows.
    Hdr,
}

/// How two pictures are compared.
#[derive(Clone, Copy, Debug, Default)]
pub struct CompareOptions<'m> {
    /// In what values.
    pub space: Space,
    /// Stops that light is brightened by before it is shown or compared.
    pub exposure: f32,
    /// Which FLIP.
    pub flip: Flip,
    /// With SSIM.
    pub ssim: bool,
    /// Pixels that count, `[height][width]`; `None` is all of them.
    pub mask: Option<&'m [bool]>,
}

/// How far two pictures of one size are apart. Values are sRGB in 0..=1, or linear light.
#[derive(Clone, Debug)]
pub struct Metrics {
    /// Pixels that were compared in each picture.
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
    /// Mean of the squared differences over the second picture's squared values plus 0.01, over all channels.
    /// Source: Rousselle, Knaus, Zwicker 2011.
    pub rel_mse: f64,
    /// Mean absolute difference, over all channels.
    pub mean_absolute: f64,
    /// Mean of each channel, of the first and the second picture.
    pub means: [Vec<f64>; 2],
    /// Pixels that differ at all.
    pub n_different: u64,
    /// The largest difference; of several the first.
    pub largest: Largest,
    /// The largest difference of each pixel's channels, `[height][width]`; NaN for pixels that are no numbers, 0 outside the mask.
    pub difference: Vec<f32>,
    /// Structural similarity of the colours, 1 for equal pictures; `None` when not asked for or not defined.
    pub ssim: Option<f64>,
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

    /// The largest distance from 1 of the ratio of the two means, over colour channels; both black is 0.
    pub fn mean_ratio(&self) -> f64 {
        let ratio = |(a, b): (&f64, &f64)| if a == b { 0.0 } else { (a / b - 1.0).abs() };
        self.means[0].iter().zip(&self.means[1]).take(3).map(ratio).fold(0.0, f64::max)
    }
}

/// Sums over a part of the pixels.
#[derive(Clone, Copy)]
struct Sums {
    squares: [f64; 4],
    relative: f64,
    absolute: f64,
    values: [[f64; 4]; 2],
    n: u64,
    n_different: u64,
    non_finite: [u64; 2],
    largest: Largest,
}

impl Sums {
    const NONE: Self = Self {
        squares: [0.0; 4],
        relative: 0.0,
        absolute: 0.0,
        values: [[0.0; 4]; 2],
        n: 0,
        n_different: 0,
        non_finite: [0; 2],
        largest: Largest { value: 0.0, at: [0; 2], channel: 0 },
    };

    fn and(mut self, other: Self) -> Self {
        for c in 0..4 {
            self.squares[c] += other.squares[c];
            for k in 0..2 {
                self.values[k][c] += other.values[k][c];
            }
        }
        self.relative += other.relative;
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

/// Compares two pictures of one size; `None` when their sizes differ. Alpha is compared when both have it.
pub fn compare(a: Picture, b: Picture, options: &CompareOptions) -> Option<Metrics> {
    if (a.width, a.height) != (b.width, b.height) {
        return None;
    }
    let linear = match options.space {
        Space::Auto => a.linear && b.linear,
        Space::Linear => true,
        Space::Display => false,
    };
    let in_light = options.flip == Flip::Hdr;
    // What HDR-FLIP looks at is not brightened: it tries all exposures itself.
    let light = in_light.then(|| (a.clone().into_linear(), b.clone().into_linear()));
    let (a, b) = rayon::join(|| a.into_space(linear, options.exposure), || b.into_space(linear, options.exposure));
    let alpha = a.has_alpha && b.has_alpha;
    let n_channels = if alpha { 4 } else { 3 };
    let width = a.width as usize;
    let mut difference = vec![0.0f32; a.pixels.len()];
    let sums = difference
        .par_chunks_mut(width)
        .zip(a.pixels.par_chunks(width).zip(b.pixels.par_chunks(width)))
        .enumerate()
        .map(|(y, (out, (a, b)))| {
            let mask = options.mask.map(|m| &m[y * width..(y + 1) * width]);
            if alpha { sum_row::<4>(y as u32, out, a, b, mask) } else { sum_row::<3>(y as u32, out, a, b, mask) }
        })
        // In order: the sums do not depend on the number of threads.
        .collect::<Vec<_>>()
        .into_iter()
        .fold(Sums::NONE, Sums::and);
    let n = sums.n.max(1) as f64;
    let n_values = n * n_channels as f64;
    let finite = sums.non_finite == [0; 2];
    let ssim = (options.ssim && finite).then(|| ssim::mean(&a, &b, options.mask)).flatten();
    let flip = match (options.flip, light) {
        (Flip::Hdr, Some((a, b))) if finite => perceived::hdr(&a, &b),
        (Flip::Ldr, _) if finite => perceived::ldr(a, b),
        _ => None,
    };
    Some(Metrics {
        n_pixels: sums.n + sums.non_finite[0].max(sums.non_finite[1]),
        linear,
        alpha,
        non_finite: sums.non_finite,
        rmse: (sums.squares.iter().sum::<f64>() / n_values).sqrt(),
        rmse_of_channel: sums.squares[..n_channels].iter().map(|s| (s / n).sqrt()).collect(),
        rel_mse: sums.relative / n_values,
        mean_absolute: sums.absolute / n_values,
        means: sums.values.map(|v| v[..n_channels].iter().map(|s| s / n).collect()),
        n_different: sums.n_different,
        largest: sums.largest,
        difference,
        ssim,
        flip: flip.map(|map| {
            let mean = perceived::mean(&map, options.mask);
            (map, mean)
        }),
    })
}

fn sum_row<const N: usize>(y: u32, out: &mut [f32], a: &[[f32; 4]], b: &[[f32; 4]], mask: Option<&[bool]>) -> Sums {
    let mut sums = Sums::NONE;
    for (x, (out, (p, q))) in out.iter_mut().zip(a.iter().zip(b)).enumerate() {
        if mask.is_some_and(|m| !m[x]) {
            continue;
        }
        let bad = [p, q].map(|v| u64::from(v[..N].iter().any(|v| !v.is_finite())));
        if bad != [0; 2] {
            sums.non_finite = [sums.non_finite[0] + bad[0], sums.non_finite[1] + bad[1]];
            *out = f32::NAN;
            continue;
        }
        let mut worst = 0.0f32;
        for c in 0..N {
            let d = (p[c] - q[c]).abs();
            let (square, reference) = (f64::from(d) * f64::from(d), f64::from(q[c]));
            sums.squares[c] += square;
            sums.relative += square / (reference * reference + 0.01);
            sums.absolute += f64::from(d);
            sums.values[0][c] += f64::from(p[c]);
            sums.values[1][c] += reference;
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
