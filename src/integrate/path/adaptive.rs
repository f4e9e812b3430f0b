//! Adaptive sampling: which pixels are done, by an estimate of their error from their own samples.
//!
//! The estimate is the distance between the mean of all samples and that of every second one: of two halves alike it has the spread that the
//! mean itself has around the truth. Of one pixel it is a single draw, now and then far too small; so its square is averaged over the pixels
//! around, and a pixel is done when all its neighbours are. Halves of a low-discrepancy set are noisier than the whole: the estimate errs on the
//! safe side. What no sample has met, a firefly say, no estimate knows.
//! Source: Cycles' measure (|I - A| over the root of I, summed over channels; Dammertz et al. 2010); the average over neighbours is ours.

use crate::integrate::NoiseLimit;

/// Samples of a pixel between two looks at its error. Even, so that both halves are alike.
pub const STEP: u32 = 16;
/// Keeps dark pixels from counting without end. Source: Cycles.
const FLOOR: f32 = 1e-4;

impl NoiseLimit {
    /// Fewest samples of a pixel, even: as asked for, else by the threshold. Source: Cycles' automatic setting, 64 at 0.01.
    pub fn first_samples(&self) -> u32 {
        let n = if self.min_samples > 0 { self.min_samples } else { (16.0 / self.threshold.powf(0.3)).ceil().max(4.0) as u32 };
        n.next_multiple_of(2)
    }
}

/// What is known of every pixel of a part of the picture, `[height][width]`.
pub struct NoiseMap {
    width: usize,
    /// Squared error, relative to the root of the brightness.
    errors: Vec<f32>,
    active: Vec<bool>,
}

impl NoiseMap {
    /// All pixels want samples.
    pub fn new(width: usize, height: usize) -> Self {
        Self { width, errors: vec![0.0; width * height], active: vec![true; width * height] }
    }

    /// Whether the pixel wants more samples.
    pub fn is_active(&self, at: usize) -> bool {
        self.active[at]
    }

    /// Pixels that want more.
    pub fn n_active(&self) -> usize {
        self.active.iter().filter(|a| **a).count()
    }

    /// Takes what pixel `at` has: the mean of all its samples, and of those of odd number.
    pub fn set(&mut self, at: usize, mean: [f32; 3], odd: [f32; 3]) {
        let apart: f32 = (0..3).map(|c| (mean[c] - odd[c]).abs()).sum();
        let brightness: f32 = mean.iter().sum::<f32>().max(0.0);
        let e = apart / (FLOOR + brightness.sqrt());
        self.errors[at] = if e.is_finite() { e * e } else { 0.0 };
    }

    /// Takes pixels out that are done. What is out stays out.
    pub fn settle(&mut self, threshold: f32) {
        let (w, h) = (self.width, self.active.len() / self.width.max(1));
        let around = |at: usize| {
            let (x, y) = (at % w, at / w);
            (y.saturating_sub(1)..(y + 2).min(h)).flat_map(move |j| (x.saturating_sub(1)..(x + 2).min(w)).map(move |i| j * w + i))
        };
        let noisy: Vec<bool> = (0..self.active.len())
            .map(|at| {
                let (sum, n) = around(at).fold((0.0, 0), |(s, n), k| (s + self.errors[k], n + 1));
                self.active[at] && sum / n as f32 >= threshold * threshold
            })
            .collect();
        self.active = (0..self.active.len()).map(|at| self.active[at] && around(at).any(|k| noisy[k])).collect();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::sobol::Pcg;

    /// Draws pixels of a known mean and variance until they are done; gives the error that they really have and the mean number of samples.
    fn real_error(threshold: f32, mut draw: impl FnMut(&mut Pcg) -> f32, mean: f32) -> (f64, f64) {
        const SIDE: usize = 100;
        let limit = NoiseLimit { threshold, min_samples: 0 };
        let mut rng = Pcg::new(9);
        let mut map = NoiseMap::new(SIDE, SIDE);
        let mut sums = vec![[0.0f64; 2]; SIDE * SIDE];
        let mut counts = vec![0u32; SIDE * SIDE];
        let mut step = limit.first_samples();
        while map.n_active() > 0 {
            for at in (0..SIDE * SIDE).filter(|at| map.active[*at]) {
                for k in 0..step {
                    sums[at][k as usize % 2] += f64::from(draw(&mut rng));
                }
                counts[at] += step;
            }
            for at in 0..SIDE * SIDE {
                let n = f64::from(counts[at]);
                map.set(at, [((sums[at][0] + sums[at][1]) / n) as f32; 3], [(sums[at][1] * 2.0 / n) as f32; 3]);
            }
            map.settle(threshold);
            step = STEP;
        }
        let error =
            |at: usize| 3.0 * ((sums[at][0] + sums[at][1]) / f64::from(counts[at]) - f64::from(mean)) / (3.0 * f64::from(mean)).sqrt();
        let squares: f64 = (0..SIDE * SIDE).map(|at| error(at).powi(2)).sum();
        let n = (SIDE * SIDE) as f64;
        ((squares / n).sqrt(), counts.iter().map(|c| f64::from(*c)).sum::<f64>() / n)
    }

    #[test]
    fn pixels_of_known_variance_end_with_the_error_asked_for() {
        // Light that falls with chance p, or exponentially: variance known, so is the number of samples that the threshold takes.
        for (threshold, mean) in [(0.05f32, 0.5f32), (0.1, 2.0)] {
            let exponential = |r: &mut Pcg| -(1.0 - r.draw()).ln() * mean;
            let (error, n) = real_error(threshold, exponential, mean);
            let want = f64::from(3.0 * mean / (threshold * threshold));
            let relative = error / f64::from(threshold);
            assert!((0.75..1.02).contains(&relative), "threshold {threshold}: error {error}");
            assert!((0.95..1.9).contains(&(n / want)), "threshold {threshold}: {n} samples, {want} would do");
        }
        let (error, _) = real_error(0.05, |r| f32::from(r.draw() < 0.1) * 5.0, 0.5);
        assert!((0.75..1.02).contains(&(error / 0.05)), "rare light: error {error}");
    }

    #[test]
    fn a_noisy_pixel_keeps_its_neighbours_and_theirs() {
        let mut map = NoiseMap::new(7, 1);
        for at in 0..7 {
            map.set(at, [1.0; 3], [1.0; 3]);
        }
        map.set(3, [1.0; 3], [1.5; 3]);
        map.settle(0.1);
        let active: Vec<bool> = (0..7).map(|at| map.is_active(at)).collect();
        assert_eq!(active, [false, true, true, true, true, true, false]);
    }

    #[test]
    fn fewest_samples_are_those_of_cycles() {
        let first = |threshold| NoiseLimit { threshold, min_samples: 0 }.first_samples();
        assert_eq!([first(0.01), first(0.1), first(1.0)], [64, 32, 16]);
        assert_eq!(NoiseLimit { threshold: 0.01, min_samples: 7 }.first_samples(), 8);
    }
}
