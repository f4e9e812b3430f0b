//! Noisy pictures: two estimates of the same light, each with its variance, are different only where chance does not explain it.
//! Source: the per-pixel z-test of Mitsuba 3's render tests (Subr and Arvo 2007 for the idea), with the significance corrected after Sidak.
//! Variances of a few seeds are themselves uncertain: they are pooled over 3 by 3 pixels, and z is that of Student's t with the degrees
//! of freedom after Welch and Satterthwaite.

use rayon::prelude::*;

/// An estimate of each pixel and its uncertainty.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimate {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Mean of linear light, `[height][width]`, row-major, top row first.
    pub mean: Vec<[f32; 3]>,
    /// Variance of that mean, in the same order, each from its own pixel alone.
    pub variance: Vec<[f32; 3]>,
    /// Pictures that it comes from; 0 where the mean is taken as exact.
    pub n_seeds: u32,
}

/// What a z-test says.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct ZTest {
    /// Values (pixels times channels) that were tested.
    pub n_values: u64,
    /// The corrected significance of one value.
    pub corrected: f64,
    /// Values that chance does not explain at that significance.
    pub n_beyond: u64,
    /// The largest |z| and its place.
    pub largest: f64,
    /// Column, row.
    pub at: [u32; 2],
    /// Root of the mean of z^2: 1 when the variances are right and nothing else differs.
    pub rms: f64,
    /// |z| of the mean over the whole picture, the largest of the channels.
    pub mean_z: f64,
    /// Values that are NaN or infinite in either.
    pub n_non_finite: u64,
}

/// Below this a variance is not believed: rounding of 32-bit sums.
const LEAST_RELATIVE_DEVIATION: f64 = 1e-5;

impl Estimate {
    /// From pictures of one size made with different seeds, each `[height][width]` of linear light.
    ///
    /// `None` for fewer than two pictures.
    pub fn from_seeds(width: u32, height: u32, pictures: &[Vec<[f32; 3]>]) -> Option<Self> {
        let n = pictures.len();
        if n < 2 || pictures.iter().any(|p| p.len() != width as usize * height as usize) {
            return None;
        }
        let moments = |i: usize| -> ([f32; 3], [f32; 3]) {
            let (mut mean, mut variance) = ([0.0f32; 3], [0.0f32; 3]);
            for c in 0..3 {
                let m = pictures.iter().map(|p| f64::from(p[i][c])).sum::<f64>() / n as f64;
                let squares = pictures.iter().map(|p| (f64::from(p[i][c]) - m).powi(2)).sum::<f64>();
                mean[c] = m as f32;
                variance[c] = (squares / ((n - 1) * n) as f64) as f32;
            }
            (mean, variance)
        };
        let (mean, variance): (Vec<_>, Vec<_>) = (0..pictures[0].len()).into_par_iter().map(moments).unzip();
        Some(Self { width, height, mean, variance, n_seeds: n as u32 })
    }

    /// Variance of channel `c` pooled over the neighbours of a pixel, and its degrees of freedom.
    fn pooled(&self, i: usize, c: usize) -> (f64, f64) {
        let (w, h) = (self.width as usize, self.height as usize);
        let (x, y) = (i % w, i / w);
        let (mut sum, mut squares, mut n) = (0.0f64, 0.0f64, 0.0f64);
        for yy in y.saturating_sub(1)..=(y + 1).min(h - 1) {
            for xx in x.saturating_sub(1)..=(x + 1).min(w - 1) {
                let v = f64::from(self.variance[yy * w + xx][c]);
                (sum, squares, n) = (sum + v, squares + v * v, n + 1.0);
            }
        }
        if !(squares > 0.0) {
            return (0.0, f64::INFINITY);
        }
        // Of neighbours with unlike variances the few large ones count.
        (sum / n, f64::from(self.n_seeds.saturating_sub(1).max(1)) * sum * sum / squares)
    }
}

/// The value of a standard normal as unlikely as `t` is of Student's distribution with `freedom` degrees. Source: Wallace 1959.
fn normal_of_student(t: f64, freedom: f64) -> f64 {
    if !freedom.is_finite() {
        return t;
    }
    (8.0 * freedom + 1.0) / (8.0 * freedom + 3.0) * (freedom * (t * t / freedom).ln_1p()).sqrt()
}

/// Tests whether two estimates can be of the same picture; `None` when their sizes differ.
///
/// `significance` is that of the whole picture: how often equal light may be called different. It is corrected for the number of values
/// that are tested: `1 - (1 - s)^(1/n)`.
pub fn z_test(a: &Estimate, b: &Estimate, significance: f64) -> Option<ZTest> {
    if (a.width, a.height) != (b.width, b.height) {
        return None;
    }
    let n = 3 * a.mean.len() as u64;
    let corrected = -((-significance).ln_1p() / n as f64).exp_m1();
    let limit = normal_quantile(1.0 - corrected / 2.0);
    let mut t = ZTest { n_values: n, corrected, n_beyond: 0, largest: 0.0, at: [0; 2], rms: 0.0, mean_z: 0.0, n_non_finite: 0 };
    let (mut sums, mut variances, mut squares) = ([0.0f64; 3], [0.0f64; 3], 0.0);
    for i in 0..a.mean.len() {
        for c in 0..3 {
            let [p, q] = [a.mean[i][c], b.mean[i][c]].map(f64::from);
            let ((vp, fp), (vq, fq)) = (a.pooled(i, c), b.pooled(i, c));
            let difference = p - q;
            let floor = LEAST_RELATIVE_DEVIATION * p.abs().max(q.abs()) + 1e-6;
            let variance = vp + vq + floor * floor;
            let freedom = variance * variance / (vp * vp / fp + vq * vq / fq);
            let z = normal_of_student(difference.abs() / variance.sqrt(), freedom);
            if !z.is_finite() {
                t.n_non_finite += 1;
                continue;
            }
            sums[c] += difference;
            variances[c] += variance;
            squares += z * z;
            t.n_beyond += u64::from(z > limit);
            if z > t.largest {
                (t.largest, t.at) = (z, [i as u32 % a.width, i as u32 / a.width]);
            }
        }
    }
    t.rms = (squares / (n - t.n_non_finite).max(1) as f64).sqrt();
    t.mean_z = (0..3).map(|c| sums[c].abs() / variances[c].max(f64::MIN_POSITIVE).sqrt()).fold(0.0, f64::max);
    Some(t)
}

/// The value below which the share `p` of a standard normal lies. Relative error below 1.2e-9. Source: Acklam 2003.
pub fn normal_quantile(p: f64) -> f64 {
    const A: [f64; 6] =
        [-39.69683028665376, 220.9460984245205, -275.9285104469687, 138.357751867269, -30.66479806614716, 2.506628277459239];
    const B: [f64; 5] = [-54.47609879822406, 161.5858368580409, -155.6989798598866, 66.80131188771972, -13.28068155288572];
    const C: [f64; 6] =
        [-0.007784894002430293, -0.3223964580411365, -2.400758277161838, -2.549732539343734, 4.374664141464968, 2.938163982698783];
    const D: [f64; 4] = [0.007784695709041462, 0.3224671290700398, 2.445134137142996, 3.754408661907416];
    let horner = |coefficients: &[f64], x: f64| coefficients.iter().fold(0.0, |sum, c| sum * x + c);
    let tail = |q: f64| horner(&C, q) / (horner(&D, q) * q + 1.0);
    if p < 0.02425 {
        tail((-2.0 * p.ln()).sqrt())
    } else if p > 1.0 - 0.02425 {
        -tail((-2.0 * (-p).ln_1p()).sqrt())
    } else {
        let q = p - 0.5;
        horner(&A, q * q) * q / (horner(&B, q * q) * q * q + 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::Mt19937;

    /// Pictures of `mean` light with noise, one a seed.
    fn seeds(range: std::ops::Range<u32>, mean: impl Fn(usize) -> f32) -> Estimate {
        let noisy = |seed: u32| {
            let mut rng = Mt19937::new(seed);
            (0..64 * 48).map(|i| std::array::from_fn(|_| mean(i) + 0.2 * (rng.next_u32() as f32 / 4_294_967_296.0 - 0.5))).collect()
        };
        Estimate::from_seeds(64, 48, &range.map(noisy).collect::<Vec<_>>()).expect("several seeds")
    }

    #[test]
    fn the_quantile_is_that_of_the_normal_distribution() {
        // Source: tables, e.g. Abramowitz and Stegun 26.2.
        for (p, z) in [(0.5, 0.0), (0.975, 1.959964), (0.995, 2.575829), (0.999999, 4.753424), (0.01, -2.326348)] {
            assert!((normal_quantile(p) - z).abs() < 1e-6, "{p}: {}", normal_quantile(p));
        }
    }

    #[test]
    fn student_becomes_normal() {
        // Source: tables: two-sided 5 % and 0.1 % of t with 10, of t with 30 degrees.
        for (t, freedom, z) in [(2.228, 10.0, 1.95996), (4.587, 10.0, 3.29053), (2.042, 30.0, 1.95996), (5.0, f64::INFINITY, 5.0)] {
            assert!((normal_of_student(t, freedom) - z).abs() < 0.01, "{t} of {freedom}: {}", normal_of_student(t, freedom));
        }
    }

    #[test]
    fn the_same_light_with_other_seeds_passes_and_other_light_does_not() {
        let a = seeds(0..8, |_| 0.5);
        let same = z_test(&a, &seeds(8..16, |_| 0.5), 0.01).expect("one size");
        assert_eq!((same.n_beyond, same.n_non_finite), (0, 0), "{same:?}");
        assert!((same.rms - 1.0).abs() < 0.05 && same.mean_z < 4.0, "{same:?}");
        // One pixel in 3072 that is far off, and 1 % of light that no pixel shows alone: z = 0.005 / (0.0204 sqrt(2 / 3072)) = 9.6.
        let spot = z_test(&a, &seeds(8..16, |i| if i == 1000 { 0.9 } else { 0.5 }), 0.01).expect("one size");
        assert!(spot.n_beyond > 0 && spot.at == [1000 % 64, 1000 / 64], "{spot:?}");
        let brighter = z_test(&a, &seeds(8..16, |_| 0.505), 0.01).expect("one size");
        assert!(brighter.mean_z > 7.0, "{brighter:?}");
    }

    #[test]
    fn what_is_no_number_is_counted() {
        let a = seeds(0..4, |_| 0.5);
        let mut b = a.clone();
        b.mean[7][1] = f32::NAN;
        assert_eq!(z_test(&a, &b, 0.01).expect("one size").n_non_finite, 1);
        assert!(z_test(&a, &Estimate { width: 48, height: 64, ..a.clone() }, 0.01).is_none());
    }
}
