//! Interference in a thin film on a dielectric, as the three channels see it.
//!
//! Airy's sum as a series over the bounces in the film; the sensitivities of the eye are Gaussians in the wave number, so that each bounce has a
//! closed form (Belcour and Barla 2017, with their fit of the CIE 1931 curves). Three bounces, white balanced to D65, as Cycles: equal to
//! what it measures within 1e-5 (the tests' numbers).

use crate::math::{Rgb, Vec3};
use std::f32::consts::PI;

/// A film.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThinFilm {
    /// Thickness, above 0.
    pub nanometres: f32,
    /// Index of the film over that of the side that light comes from. Source: Cycles lets it lengthen the film's path too, so that from within
    /// a body the colours are those of a thinner film (measured); true ones would be the same from both sides.
    pub ior: f32,
}

/// Bounces in the film.
const N_BOUNCES: u32 = 3;

/// White point of D65 for the observer of 1931. Source: CIE 15.
const D65: Vec3 = Vec3::new(0.950_47, 1.0, 1.088_83);

/// Linear Rec.709 of CIE XYZ. Source: IEC 61966-2-1.
pub fn rec709(c: Vec3) -> Rgb {
    Vec3::new(
        3.240_454_2 * c.x - 1.537_138_5 * c.y - 0.498_531_4 * c.z,
        -0.969_266 * c.x + 1.876_010_8 * c.y + 0.041_556 * c.z,
        0.055_643_4 * c.x - 0.204_025_9 * c.y + 1.057_225_2 * c.z,
    )
}

/// Mean over the waves of the cosine of the phase that an optical path of `nanometres` makes, for each channel; 1 for no path.
fn mean_cosine(nanometres: f32) -> Rgb {
    // Source: Belcour and Barla 2017, supplemental code: height, place and variance of each Gaussian over the wave number.
    const NORM: f32 = 1.0685e-7;
    let phase = 2.0 * PI * nanometres * 1e-9;
    let gauss = |height: f32, place: f32, variance: f32| {
        height / NORM * (2.0 * PI * variance).sqrt() * (place * phase).cos() * (-variance * phase * phase).exp()
    };
    let x = gauss(5.4856e-13, 1.6810e6, 4.3278e9) + gauss(9.7470e-14, 2.2399e6, 4.5282e9);
    rec709(D65 * Vec3::new(x, gauss(4.4201e-13, 1.7953e6, 9.3046e9), gauss(5.2481e-13, 2.2084e6, 6.6121e9)))
}

/// Amplitudes reflected from index `n1` to `n2` at cosines `c1`, `c2`: across and along the plane of incidence.
fn amplitudes(n1: f32, c1: f32, n2: f32, c2: f32) -> [f32; 2] {
    [(n1 * c1 - n2 * c2) / (n1 * c1 + n2 * c2), (n2 * c1 - n1 * c2) / (n2 * c1 + n1 * c2)]
}

impl ThinFilm {
    /// Reflectance at a cosine; `eta` is the body's index over that outside of the film.
    pub fn reflectance(&self, cos: f32, eta: f32) -> Rgb {
        // A film thinner than any wave is none. Source: Cycles' films fade in over the same range.
        let fade = (self.nanometres / 30.0).clamp(0.0, 1.0);
        let n2 = 1.0 + (self.ior - 1.0) * fade * fade * (3.0 - 2.0 * fade);
        let sin_sq = 1.0 - cos * cos;
        let (s2, s3) = (1.0 - sin_sq / (n2 * n2), 1.0 - sin_sq / (eta * eta));
        if s2 <= 0.0 || s3 <= 0.0 {
            return Vec3::ONE;
        }
        let (c2, c3) = (s2.sqrt(), s3.sqrt());
        let (upper, lower) = (amplitudes(1.0, cos, n2, c2), amplitudes(n2, c2, eta, c3));
        let path = 2.0 * n2 * self.nanometres * c2;
        let cosines: [Rgb; N_BOUNCES as usize] = std::array::from_fn(|m| mean_cosine(path * (m as f32 + 1.0)));
        let mut sum = Vec3::ZERO;
        for k in 0..2 {
            let (r12, r23) = (upper[k] * upper[k], lower[k] * lower[k]);
            let passed = 1.0 - r12;
            // Light that went through the film and back, without and with its waves in step.
            let once = passed * passed * r23 / (1.0 - r12 * r23);
            sum += 0.5 * (r12 + once);
            let mut c = once - passed;
            for cosine in cosines {
                // The sign of the product is the half wave that a bounce may lose.
                c *= -upper[k] * lower[k];
                sum += c * cosine;
            }
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
        let film = ThinFilm { nanometres: 500.0, ior: 1.5 };
        for cos in [0.05, 0.3, 0.7, 1.0] {
            let want = dielectric(cos, 1.5).0;
            assert!((film.reflectance(cos, 1.5) - Vec3::splat(want)).abs().max_element() < 1e-4, "cos {cos}");
        }
    }

    #[test]
    fn a_quarter_wave_of_the_geometric_mean_takes_green_away() {
        let ior = 1.5f32.sqrt();
        let film = ThinFilm { nanometres: 550.0 / (4.0 * ior), ior };
        let r = film.reflectance(1.0, 1.5);
        assert!(r.y < 0.004 && r.x > r.y && r.z > r.y, "{r}");
    }

    #[test]
    fn films_reflect_what_cycles_measures() {
        // Source: Cycles 4.5.15, a mirror of index 1.5 in a white room (degrees, nanometres, index of the film, colour).
        for (degrees, nanometres, ior, want) in [
            (0.5f32, 100.0, 1.33, [0.008776, 0.006695, 0.009909]),
            (0.5, 100.0, 2.0, [0.204119, 0.137352, 0.056170]),
            (0.5, 300.0, 1.33, [0.022049, 0.006796, 0.026978]),
            (0.5, 300.0, 2.0, [0.0, 0.125087, 0.169089]),
            (0.5, 700.0, 2.0, [0.153319, 0.113476, 0.123473]),
            (0.5, 20000.0, 1.33, [0.023525, 0.023525, 0.023525]),
            (60.0, 200.0, 1.33, [0.039130, 0.063200, 0.086424]),
            (60.0, 400.0, 1.33, [0.057060, 0.035181, 0.072602]),
            (60.0, 1000.0, 1.33, [0.040811, 0.064684, 0.052956]),
        ] {
            let got = ThinFilm { nanometres, ior }.reflectance(degrees.to_radians().cos(), 1.5);
            assert!((got - Vec3::from_array(want)).abs().max_element() < 1e-4, "{degrees} {nanometres} {ior}: {got}, not {want:?}");
        }
    }

    #[test]
    fn films_on_glass_seen_from_within_reflect_what_cycles_measures() {
        // Source: Cycles 4.5.15, a sheet of glass of index 1.5 under a world that is white above, seen through its back.
        for (degrees, nanometres, ior, want) in [
            (0.5f32, 500.0, 1.33, [0.001_28, 0.013_84, 0.040_09]),
            (40.0, 500.0, 1.33, [0.255_72, 0.235_52, 0.178_38]),
            (0.5, 300.0, 1.8, [0.042_72, 0.113_65, 0.126_12]),
            (40.0, 300.0, 1.8, [0.231_09, 0.262_56, 0.316_38]),
        ] {
            let got = ThinFilm { nanometres, ior: ior / 1.5 }.reflectance(degrees.to_radians().cos(), 1.0 / 1.5);
            assert!((got - Vec3::from_array(want)).abs().max_element() < 1e-4, "{degrees} {nanometres} {ior}: {got}, not {want:?}");
        }
    }
}
