//! Pixel filters, importance sampled: an offset from the pixel's centre per sample, every sample of weight 1 in its own pixel.

use crate::scene::path_settings::PixelFilter;

/// Entries of the inverted distribution.
const N: usize = 1024;

/// A filter made ready, the same along x and y.
pub struct FilterTable {
    /// Offset in pixels at evenly spaced shares of the filter's mass, ascending.
    inverse: Vec<f32>,
}

impl FilterTable {
    /// For `filter`.
    pub fn new(filter: PixelFilter) -> Self {
        let (radius, weight): (f32, Box<dyn Fn(f32) -> f32>) = match filter {
            PixelFilter::Box => (0.5, Box::new(|_| 1.0)),
            PixelFilter::BlackmanHarris { width } => (width.max(1e-3), Box::new(blackman_harris)),
            // Source: Cycles' manual; the window reaches 3 standard deviations at its rim.
            PixelFilter::Gaussian { width } => (width.max(1e-3), Box::new(|x| (-4.5 * x * x).exp())),
        };
        Self { inverse: inverted(radius, weight) }
    }

    /// The offsets, for other machines: 1,025 of them.
    pub fn offsets(&self) -> &[f32] {
        &self.inverse
    }

    /// Offset for a number in 0..1.
    pub fn offset(&self, u: f32) -> f64 {
        let x = u * N as f32;
        let i = (x as usize).min(N - 1);
        let f = x - i as f32;
        f64::from(self.inverse[i] + (self.inverse[i + 1] - self.inverse[i]) * f)
    }
}

/// `x` runs over -1..=1 across the window. Source: Harris 1978, the minimum four-term window.
fn blackman_harris(x: f32) -> f32 {
    let a = std::f32::consts::PI * (x + 1.0);
    0.35875 - 0.48829 * a.cos() + 0.14128 * (2.0 * a).cos() - 0.01168 * (3.0 * a).cos()
}

fn inverted(radius: f32, weight: impl Fn(f32) -> f32) -> Vec<f32> {
    const FINE: usize = 8 * N;
    let at = |k: usize| 2.0 * k as f32 / FINE as f32 - 1.0;
    let mut sums = vec![0.0f64; FINE + 1];
    for k in 0..FINE {
        sums[k + 1] = sums[k] + 0.5 * f64::from(weight(at(k)).max(0.0) + weight(at(k + 1)).max(0.0));
    }
    let total = sums[FINE];
    let mut k = 0;
    (0..=N)
        .map(|i| {
            let target = total * i as f64 / N as f64;
            while k + 1 < FINE && sums[k + 1] < target {
                k += 1;
            }
            let step = sums[k + 1] - sums[k];
            let f = if step > 0.0 { ((target - sums[k]) / step).clamp(0.0, 1.0) } else { 0.5 };
            radius * (2.0 * (k as f64 + f) / FINE as f64 - 1.0) as f32
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn offsets_are_symmetric_and_spread_as_the_window_says() {
        let t = FilterTable::new(PixelFilter::BlackmanHarris { width: 1.5 });
        assert!(t.offset(0.5).abs() < 1e-3 && (t.offset(0.2) + t.offset(0.8)).abs() < 1e-3);
        let n = 10_000;
        let var = (0..n).map(|k| t.offset((k as f32 + 0.5) / n as f32).powi(2)).sum::<f64>() / f64::from(n);
        let mut want = (0.0, 0.0);
        for k in 0..100_000 {
            let x = (k as f32 + 0.5) / 50_000.0 - 1.0;
            let w = f64::from(blackman_harris(x));
            want = (want.0 + w * f64::from(1.5 * x).powi(2), want.1 + w);
        }
        assert!((var - want.0 / want.1).abs() < 1e-3, "{var} {}", want.0 / want.1);
        let b = FilterTable::new(PixelFilter::Box);
        assert!((b.offset(0.25) + 0.25).abs() < 1e-4 && b.offset(0.999) <= 0.5);
    }
}
