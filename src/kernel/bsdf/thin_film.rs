//! Interference in a thin film on a dielectric: Airy's exact sum, averaged over both polarisations and seen by the three channels.
//!
//! Source: Born and Wolf, section 7.6; Belcour and Barla 2017 (as a renderer's term); sensitivities by Wyman, Sloan and Shirley 2013.

use crate::math::{Rgb, Vec3};
use std::sync::LazyLock;

/// A film.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThinFilm {
    /// Thickness, above 0.
    pub nanometres: f32,
    /// Index of the film.
    pub ior: f32,
    /// Index of what lies outside of the film, 1, or that of the body when seen from within.
    pub outside: f32,
}

const N_WAVES: usize = 40;

/// Wavelength (nm) and what it adds to red, green, blue; the weights of a channel sum to 1, so that white stays white.
static WAVES: LazyLock<[(f32, Vec3); N_WAVES]> = LazyLock::new(|| {
    let mut list = std::array::from_fn(|k| {
        let nm = 390.0 + (k as f32 + 0.5) * (720.0 - 390.0) / N_WAVES as f32;
        (nm, rec709(xyz_of(nm)))
    });
    let sum = list.iter().fold(Vec3::ZERO, |s, (_, w)| s + *w);
    list.iter_mut().for_each(|(_, w)| *w /= sum);
    list
});

/// Wavelengths (nm) with what each adds to red, green and blue, for other machines.
pub fn waves() -> &'static [(f32, Vec3)] {
    &*WAVES
}

/// CIE 1931 colour matching by sums of lopsided Gaussians.
fn xyz_of(nm: f32) -> Vec3 {
    let g = |mid: f32, left: f32, right: f32| {
        let t = (nm - mid) / if nm < mid { left } else { right };
        (-0.5 * t * t).exp()
    };
    Vec3::new(
        1.056 * g(599.8, 37.9, 31.0) + 0.362 * g(442.0, 16.0, 26.7) - 0.065 * g(501.1, 20.4, 26.2),
        0.821 * g(568.8, 46.9, 40.5) + 0.286 * g(530.9, 16.3, 31.1),
        1.217 * g(437.0, 11.8, 36.0) + 0.681 * g(459.0, 26.0, 13.8),
    )
}

/// Linear Rec.709 of CIE XYZ. Source: IEC 61966-2-1.
pub fn rec709(c: Vec3) -> Rgb {
    Vec3::new(
        3.240_454_2 * c.x - 1.537_138_5 * c.y - 0.498_531_4 * c.z,
        -0.969_266 * c.x + 1.876_010_8 * c.y + 0.041_556 * c.z,
        0.055_643_4 * c.x - 0.204_025_9 * c.y + 1.057_225_2 * c.z,
    )
}

/// Amplitudes reflected from index `n1` to `n2` at cosines `c1`, `c2`: across and along the plane of incidence.
fn amplitudes(n1: f32, c1: f32, n2: f32, c2: f32) -> [f32; 2] {
    [(n1 * c1 - n2 * c2) / (n1 * c1 + n2 * c2), (n2 * c1 - n1 * c2) / (n2 * c1 + n1 * c2)]
}

impl ThinFilm {
    /// Reflectance at a cosine; `eta` is the body's index over that outside of the film.
    pub fn reflectance(&self, cos: f32, eta: f32) -> Rgb {
        // A film thinner than any wave is none. Source: Cycles' films fade in over the same range.
        let (n1, n3) = (self.outside, self.outside * eta);
        let fade = (self.nanometres / 30.0).clamp(0.0, 1.0);
        let n2 = n1 + (self.ior - n1) * fade * fade * (3.0 - 2.0 * fade);
        let sin_sq = n1 * n1 * (1.0 - cos * cos);
        let (s2, s3) = (1.0 - sin_sq / (n2 * n2), 1.0 - sin_sq / (n3 * n3));
        if s2 <= 0.0 || s3 <= 0.0 {
            return Vec3::ONE;
        }
        let (c2, c3) = (s2.sqrt(), s3.sqrt());
        let (upper, lower) = (amplitudes(n1, cos, n2, c2), amplitudes(n2, c2, n3, c3));
        let path = 4.0 * std::f32::consts::PI * n2 * self.nanometres * c2;
        let mut sum = Vec3::ZERO;
        for (nm, weight) in WAVES.iter() {
            let wave = (path / nm).cos();
            let mut r = 0.0;
            for k in 0..2 {
                let (a, b) = (upper[k], lower[k]);
                let cross = 2.0 * a * b * wave;
                r += 0.5 * (a * a + b * b + cross) / (1.0 + a * a * b * b + cross);
            }
            sum += *weight * r;
        }
        sum.clamp(Vec3::ZERO, Vec3::ONE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::bsdf::fresnel::dielectric;

    #[test]
    fn a_film_of_the_bodys_own_index_is_no_film() {
        let film = ThinFilm { nanometres: 500.0, ior: 1.5, outside: 1.0 };
        for cos in [0.05, 0.3, 0.7, 1.0] {
            let want = dielectric(cos, 1.5).0;
            assert!((film.reflectance(cos, 1.5) - Vec3::splat(want)).abs().max_element() < 1e-4, "cos {cos}");
        }
    }

    #[test]
    fn a_quarter_wave_of_the_geometric_mean_takes_green_away() {
        let ior = 1.5f32.sqrt();
        let film = ThinFilm { nanometres: 550.0 / (4.0 * ior), ior, outside: 1.0 };
        let r = film.reflectance(1.0, 1.5);
        assert!(r.y < 0.004 && r.x > r.y && r.z > r.y, "{r}");
    }
}
