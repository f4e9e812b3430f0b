//! Directional albedos of GGX lobes, computed at first use from their definition: an average over the visible normals.
//!
//! Rows are roughnesses, columns cosines of the viewer (evenly spaced in their square roots), both mixed linearly. Index-dependent tables
//! are kept by index, in steps of 1/1024 of its logarithm. A row costs about 8 ms, once a process, and only what a scene asks for is made.
//! Source: Kulla and Conty 2017; Turquin 2019.

use super::fresnel::{dielectric, dielectric_average, f0_of};
use super::ggx::Ggx;
use crate::math::Vec3;
use std::sync::{LazyLock, OnceLock};

const N_ROUGHNESS: usize = 64;
const N_COS: usize = 64;
/// Points of an average. Measured: the largest error of an entry is 4e-4.
const N_POINTS: u32 = 4096;
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
            let ggx = Ggx::isotropic((k as f32 / N_ROUGHNESS as f32).powi(2).max(1e-6));
            std::array::from_fn(|c| average(self.quantity, ggx, (c as f32 / N_COS as f32).powi(2).max(1e-5), self.eta))
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

/// The average over the normals that a viewer at cosine `cos` sees.
fn average(quantity: Quantity, ggx: Ggx, cos: f32, eta: f32) -> f32 {
    let v = Vec3::new((1.0 - cos * cos).max(0.0).sqrt(), 0.0, cos);
    let lambda_v = ggx.lambda(v);
    // Light that leaves along l, over light that a lone facet would send there.
    let unmasked = |l: Vec3| (1.0 + lambda_v) / (1.0 + lambda_v + ggx.lambda(Vec3::new(l.x, l.y, l.z.abs())));
    let (mut sum, mut weight) = (0.0f64, 0.0f64);
    for k in 0..N_POINTS {
        // Source: Roberts 2018, the R2 sequence.
        let (u, w) = ((0.5 + f64::from(k) * 0.754_877_666_246_692_7).fract(), (f64::from(k) + 0.5) / f64::from(N_POINTS));
        let h = ggx.sample_visible(v, u as f32, w as f32);
        let vh = v.dot(h);
        let reflected = h * (2.0 * vh) - v;
        let up = if reflected.z > 0.0 { f64::from(unmasked(reflected)) } else { 0.0 };
        match quantity {
            Quantity::Mirror => sum += up,
            Quantity::DielectricMix => {
                let real = f0_of(eta);
                sum += up * f64::from((dielectric(vh, eta).0 - real) / (1.0 - real));
                weight += up;
            }
            Quantity::Glass => {
                let (f, t) = dielectric(vh, eta);
                sum += f64::from(f) * up;
                if t < 0.0 {
                    let refracted = h * (vh / eta + t) - v / eta;
                    if refracted.z < 0.0 {
                        sum += f64::from((1.0 - f) * unmasked(refracted));
                    }
                }
            }
        }
    }
    match quantity {
        Quantity::DielectricMix if weight > 0.0 => (sum / weight) as f32,
        Quantity::DielectricMix => 1.0,
        _ => (sum / f64::from(N_POINTS)) as f32,
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
    use super::*;

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
