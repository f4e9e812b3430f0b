//! Directional albedos of GGX lobes, computed at first use from their definition: an average over the visible normals.
//!
//! Rows are roughnesses, columns cosines of the viewer (evenly spaced in their square roots), both mixed linearly. Index-dependent tables
//! are kept by index, in steps of 1/1024 of its logarithm. A row costs about 1 ms, once a process, and only what a scene asks for is made.
//! Source: Kulla and Conty 2017; Turquin 2019.

use super::fresnel::{dielectric_average, f0_of};
use std::f64::consts::PI;
use std::sync::{LazyLock, OnceLock};

const N_ROUGHNESS: usize = 64;
const N_COS: usize = 64;
/// Points of an average. Measured: the largest error of an entry is 3e-4, of glass seen from within 6e-4.
const N_POINTS: usize = 4096;
/// Points that are averaged side by side.
const LANES: usize = 8;
/// Indices from e^-4 to e^4.
const N_ETA: usize = 8192;

/// Which average.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Quantity {
    /// All light reflected by facets that reflect all of it.
    Mirror,
    /// Where on the way from F0 to 1 the reflectance of a dielectric stands on average, weighed as reflected.
    DielectricMix,
    /// All light that a dielectric reflects and refracts.
    Glass,
}

/// One table.
struct Table {
    quantity: Quantity,
    eta: f32,
    rows: [OnceLock<[f32; N_COS + 1]>; N_ROUGHNESS + 1],
}

impl Table {
    fn new(quantity: Quantity, eta: f32) -> Self {
        Self { quantity, eta, rows: [const { OnceLock::new() }; N_ROUGHNESS + 1] }
    }

    fn row(&self, k: usize) -> &[f32; N_COS + 1] {
        self.rows[k].get_or_init(|| {
            let width = (k as f32 / N_ROUGHNESS as f32).powi(2).max(1e-6);
            std::array::from_fn(|c| average(self.quantity, width, (c as f32 / N_COS as f32).powi(2).max(1e-5), self.eta))
        })
    }

    fn at(&self, roughness: f32, cos: f32) -> f32 {
        let r = roughness.clamp(0.0, 1.0) * N_ROUGHNESS as f32;
        let c = cos.clamp(0.0, 1.0).sqrt() * N_COS as f32;
        let (i, j) = ((r as usize).min(N_ROUGHNESS - 1), (c as usize).min(N_COS - 1));
        let (fr, fc) = (r - i as f32, c - j as f32);
        let along = |row: &[f32; N_COS + 1]| row[j] + (row[j + 1] - row[j]) * fc;
        let low = along(self.row(i));
        if fr == 0.0 { low } else { low + (along(self.row(i + 1)) - low) * fr }
    }
}

/// Points over the normals that a viewer sees, a half turn of them since the other half is its mirror image: cosine and sine of the turn, height.
struct Points([[[f32; LANES]; 3]; N_POINTS / LANES]);

static POINTS: LazyLock<Box<Points>> = LazyLock::new(|| {
    let mut points = Box::new(Points([[[0.0; LANES]; 3]; N_POINTS / LANES]));
    for k in 0..N_POINTS {
        // A golden-ratio lattice.
        let turn = PI * (0.5 + k as f64 * 0.618_033_988_749_894_9).fract();
        let height = (k as f64 + 0.5) / N_POINTS as f64;
        let [cos, sin, w] = &mut points.0[k / LANES];
        (cos[k % LANES], sin[k % LANES], w[k % LANES]) = (turn.cos() as f32, turn.sin() as f32, height as f32);
    }
    points
});

/// Sums over the normals that a viewer at cosine `cos` sees of what `value` has of one: its z and its cosine with the viewer.
fn sums(width: f32, cos: f32, value: impl Fn(f32, f32) -> [f32; 2]) -> [f64; 2] {
    // As `Ggx::sample_visible`, several at once.
    let sin = (1.0 - cos * cos).max(0.0).sqrt();
    let stretched = (sin * width).hypot(cos);
    let (x, z) = (sin * width / stretched, cos / stretched);
    let mut sums = [[0.0f32; LANES]; 2];
    for [turn_cos, turn_sin, w] in &POINTS.0 {
        for k in 0..LANES {
            let up = (1.0 - w[k]) * (1.0 + z) - z;
            let around = (1.0 - up * up).max(0.0).sqrt();
            let h = [(around * turn_cos[k] + x) * width, around * turn_sin[k] * width, (up + z).max(0.0)];
            let scale = 1.0 / (h[0] * h[0] + h[1] * h[1] + h[2] * h[2]).max(1e-30).sqrt();
            let [a, b] = value(h[2] * scale, (sin * h[0] + cos * h[2]) * scale);
            sums[0][k] += a;
            sums[1][k] += b;
        }
    }
    sums.map(|s| s.into_iter().map(f64::from).sum())
}

/// The average over the normals that a viewer at cosine `cos` sees.
fn average(quantity: Quantity, width: f32, cos: f32, eta: f32) -> f32 {
    let lambda = |z: f32| {
        let z_sq = (z * z).max(1e-12);
        let t = width * width * (1.0 - z * z).max(0.0) / z_sq;
        0.5 * t / (1.0 + (1.0 + t).sqrt())
    };
    let seen = 1.0 + lambda(cos);
    // Light that leaves at that height, over light that a lone facet would send there.
    let unmasked = |z: f32| seen / (seen + lambda(z));
    let reflected = |h: f32, vh: f32| {
        let z = 2.0 * vh * h - cos;
        if z > 0.0 { unmasked(z) } else { 0.0 }
    };
    // As `fresnel::dielectric`: it gives 1 and 0 in total reflection.
    let split = |vh: f32| {
        let vh = vh.max(1e-12);
        let t = (1.0 - (1.0 - vh * vh) / (eta * eta)).max(0.0).sqrt();
        let (s, p) = ((vh - eta * t) / (vh + eta * t), (t - eta * vh) / (t + eta * vh));
        (0.5 * (s * s + p * p), t)
    };
    match quantity {
        Quantity::Mirror => (sums(width, cos, |h, vh| [reflected(h, vh), 0.0])[0] / N_POINTS as f64) as f32,
        Quantity::DielectricMix => {
            let real = f0_of(eta);
            let [sum, weight] = sums(width, cos, |h, vh| {
                let up = reflected(h, vh);
                [up * ((split(vh).0 - real) / (1.0 - real)), up]
            });
            if weight > 0.0 { (sum / weight) as f32 } else { 1.0 }
        }
        Quantity::Glass => {
            let [sum, _] = sums(width, cos, |h, vh| {
                let (f, t) = split(vh);
                let z = h * (vh / eta - t) - cos / eta;
                let through = if t > 0.0 && z < 0.0 { (1.0 - f) * unmasked(z) } else { 0.0 };
                [f * reflected(h, vh) + through, 0.0]
            });
            (sum / N_POINTS as f64) as f32
        }
    }
}

type ByEta = Vec<OnceLock<Box<Table>>>;

static MIRROR: LazyLock<Table> = LazyLock::new(|| Table::new(Quantity::Mirror, 1.0));
static MIX: LazyLock<ByEta> = LazyLock::new(|| (0..=N_ETA).map(|_| OnceLock::new()).collect());
static GLASS: LazyLock<ByEta> = LazyLock::new(|| (0..=N_ETA).map(|_| OnceLock::new()).collect());
static MEANS: LazyLock<Vec<OnceLock<f32>>> = LazyLock::new(|| (0..=N_ETA).map(|_| OnceLock::new()).collect());
static MIRROR_MEAN: [OnceLock<f32>; N_ROUGHNESS + 1] = [const { OnceLock::new() }; N_ROUGHNESS + 1];

fn by_eta(tables: &'static ByEta, quantity: Quantity, eta: f32) -> &'static Table {
    let k = ((eta.ln() + 4.0) * 1024.0).round().clamp(0.0, N_ETA as f32) as usize;
    tables[k].get_or_init(|| Box::new(Table::new(quantity, (k as f32 / 1024.0 - 4.0).exp())))
}

/// Rows of a table of [`mirror`], [`dielectric_mix`] and [`glass`], and columns of a row, for other machines: roughness and the square root
/// of the cosine in steps of 1/64.
pub const TABLE_SIDE: usize = N_ROUGHNESS + 1;

/// Row `k` of [`mirror`].
pub fn mirror_row(k: usize) -> &'static [f32; TABLE_SIDE] {
    MIRROR.row(k)
}

/// Row `k` of [`dielectric_mix`] for index `eta`.
pub fn dielectric_mix_row(eta: f32, k: usize) -> &'static [f32; TABLE_SIDE] {
    by_eta(&MIX, Quantity::DielectricMix, eta).row(k)
}

/// Row `k` of [`glass`] for index `eta`.
pub fn glass_row(eta: f32, k: usize) -> &'static [f32; TABLE_SIDE] {
    by_eta(&GLASS, Quantity::Glass, eta).row(k)
}

/// What a lobe of perfect facets reflects of light from one side, to a viewer at that cosine.
pub fn mirror(roughness: f32, cos: f32) -> f32 {
    MIRROR.at(roughness, cos)
}

/// The mean of [`mirror`] over cosines, weighed by them.
pub fn mirror_mean(roughness: f32) -> f32 {
    let mean = |k: usize| {
        *MIRROR_MEAN[k].get_or_init(|| {
            // d(cos²) with cos = x²: 4 x³ dx; Simpson over the row's nodes.
            let row = MIRROR.row(k);
            let f = |j: usize| f64::from(row[j]) * 4.0 * (j as f64 / N_COS as f64).powi(3);
            let inner: f64 = (1..N_COS).map(|j| f(j) * if j % 2 == 1 { 4.0 } else { 2.0 }).sum();
            ((f(0) + f(N_COS) + inner) / (3.0 * N_COS as f64)) as f32
        })
    };
    let r = roughness.clamp(0.0, 1.0) * N_ROUGHNESS as f32;
    let i = (r as usize).min(N_ROUGHNESS - 1);
    mean(i) + (mean(i + 1) - mean(i)) * (r - i as f32)
}

/// What a dielectric reflects of light from everywhere, and where that stands between F0 (0) and 1 (1).
pub fn dielectric_mean(eta: f32) -> f32 {
    let k = ((eta.ln() + 4.0) * 1024.0).round().clamp(0.0, N_ETA as f32) as usize;
    *MEANS[k].get_or_init(|| {
        let eta = (k as f32 / 1024.0 - 4.0).exp();
        let real = f0_of(eta);
        (dielectric_average(eta) - real) / (1.0 - real)
    })
}

/// Where between F0 (0) and 1 (1) the reflectance of a rough dielectric of index `eta` stands.
pub fn dielectric_mix(eta: f32, roughness: f32, cos: f32) -> f32 {
    by_eta(&MIX, Quantity::DielectricMix, eta).at(roughness, cos)
}

/// What rough glass of index `eta` reflects and refracts together.
pub fn glass(eta: f32, roughness: f32, cos: f32) -> f32 {
    by_eta(&GLASS, Quantity::Glass, eta).at(roughness, cos)
}

#[cfg(test)]
mod tests {
    use super::super::fresnel::dielectric;
    use super::super::ggx::Ggx;
    use super::*;
    use crate::math::Vec3;

    /// The same from the definition, one normal at a time.
    fn plain_average(quantity: Quantity, width: f32, cos: f32, eta: f32) -> f32 {
        const N: u32 = 1 << 17;
        let ggx = Ggx::isotropic(width);
        let v = Vec3::new((1.0 - cos * cos).max(0.0).sqrt(), 0.0, cos);
        let unmasked = |l: Vec3| (1.0 + ggx.lambda(v)) / (1.0 + ggx.lambda(v) + ggx.lambda(Vec3::new(l.x, l.y, l.z.abs())));
        let (mut sum, mut weight) = (0.0f64, 0.0f64);
        for k in 0..N {
            let [u, w, ..] = crate::math::sobol::sobol4(1, k, 0);
            let h = ggx.sample_visible(v, u, w);
            let vh = v.dot(h);
            let l = h * (2.0 * vh) - v;
            let up = if l.z > 0.0 { f64::from(unmasked(l)) } else { 0.0 };
            let (f, t) = dielectric(vh, eta);
            let through = h * (vh / eta + t) - v / eta;
            weight += if quantity == Quantity::DielectricMix { up } else { 1.0 };
            sum += match quantity {
                Quantity::Mirror => up,
                Quantity::DielectricMix => up * f64::from((f - f0_of(eta)) / (1.0 - f0_of(eta))),
                Quantity::Glass if t < 0.0 && through.z < 0.0 => f64::from(f) * up + f64::from((1.0 - f) * unmasked(through)),
                Quantity::Glass => f64::from(f) * up,
            };
        }
        (sum / weight) as f32
    }

    #[test]
    fn averages_are_those_of_the_definition() {
        for (quantity, eta, limit) in [
            (Quantity::Mirror, 1.0, 6e-4),
            (Quantity::DielectricMix, 1.5, 6e-4),
            (Quantity::DielectricMix, 2.4, 6e-4),
            (Quantity::Glass, 1.5, 6e-4),
            (Quantity::Glass, 1.0 / 1.5, 8e-4),
            (Quantity::Glass, 0.4, 8e-4),
        ] {
            for roughness in [0.1f32, 0.35, 0.7, 1.0] {
                for cos in [1e-5, 0.01, 0.05, 0.2, 0.5, 0.8, 1.0] {
                    let (got, want) =
                        (average(quantity, roughness * roughness, cos, eta), plain_average(quantity, roughness * roughness, cos, eta));
                    assert!((got - want).abs() < limit, "{quantity:?} {eta} {roughness} {cos}: {got}, not {want}");
                }
            }
        }
    }

    #[test]
    fn smooth_lobes_lose_nothing_and_rough_ones_what_is_known() {
        for cos in [0.1, 0.5, 1.0] {
            assert!((mirror(0.0, cos) - 1.0).abs() < 1e-3);
            assert!((glass(1.5, 0.0, cos) - 1.0).abs() < 1e-3);
            assert!((dielectric_mix(1.5, 0.0, cos) - (dielectric(cos, 1.5).0 - 0.04) / 0.96).abs() < 2e-3);
        }
        // Source: Kulla and Conty 2017: a single bounce loses up to 60 %.
        assert!((0.39..0.43).contains(&mirror_mean(1.0)), "{}", mirror_mean(1.0));
    }
}
