//! How far photons are gathered, where the scene does not say: far enough for the most that are wanted, at the density that photons have.
//! Source: spec/light.md, section 9.

use super::map::{NearestPhotons, PhotonMap};
use rayon::prelude::*;
use std::f64::consts::PI;

/// Most photons looked at, evenly over the map.
const MOST_SAMPLES: usize = 4000;
/// Densities about a photon, over the mean, that say that the radius is too small there: thinner ones lie astray.
const THIN: std::ops::Range<f64> = 0.05..0.7;

/// The radius for a map whose gatherings want `most` photons; `volume`: photons lie in space, not on surfaces.
///
/// POV-Ray looks at 100 to 1,000 photons that it draws with the C library's `rand()`, and finds the share of thin places within some per
/// cent, which are multiplied by 20; here it is the share over the whole map.
pub fn automatic_radius(map: &PhotonMap, most: u32, volume: bool) -> f64 {
    let photons = map.photons();
    let n_samples = photons.len().min(MOST_SAMPLES);
    let densities = |radius: f64| -> Vec<f64> {
        let about = |k: usize, found: &mut NearestPhotons| {
            map.nearest(photons[k * photons.len() / n_samples].position(), None, radius, found);
            let (n, r_sq) = (found.len() as f64, found.radius_sq());
            // All photons in one place, or fewer than wanted anywhere: no density.
            let has_density = r_sq > 0.0 && r_sq.is_finite();
            let density = if volume { 3.0 * n / (4.0 * PI * r_sq * r_sq.sqrt()) } else { n / (PI * r_sq) };
            if has_density { density } else { 0.0 }
        };
        (0..n_samples).into_par_iter().map_init(|| NearestPhotons::new(most), |found, k| about(k, found)).collect()
    };
    let mean = densities(f64::INFINITY).iter().sum::<f64>() / n_samples.max(1) as f64;
    if mean <= 0.0 {
        return 0.0;
    }
    let wanted = f64::from(most) / mean;
    let radius = if volume { (3.0 * wanted / (4.0 * PI)).cbrt() } else { (wanted / PI).sqrt() };
    let n_thin = densities(radius).iter().filter(|d| THIN.contains(&(**d / mean))).count();
    radius * (1.0 + 20.0 * n_thin as f64 / n_samples as f64)
}
