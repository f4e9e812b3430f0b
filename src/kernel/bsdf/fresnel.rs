//! Fresnel terms: dielectrics, dielectrics remapped to a given F0 (Cycles' Principled), F82 metals, thin films.
//!
//! Indices are eta = n_inside / n_outside as seen from the side that light comes from; cosines are with the microfacet's normal, 0..=1.

use super::thin_film::ThinFilm;
use crate::math::{Rgb, Vec3};

/// Reflectance of a dielectric and the cosine of the refracted ray, negative (it goes to the other side); (1, 0) in total reflection.
#[inline]
pub fn dielectric(cos: f32, eta: f32) -> (f32, f32) {
    let t_sq = 1.0 - (1.0 - cos * cos) / (eta * eta);
    if t_sq <= 0.0 {
        return (1.0, 0.0);
    }
    let t = t_sq.sqrt();
    let s = (cos - eta * t) / (cos + eta * t);
    let p = (t - eta * cos) / (t + eta * cos);
    (0.5 * (s * s + p * p), -t)
}

/// Reflectance along the normal.
#[inline]
pub fn f0_of(eta: f32) -> f32 {
    let f = (eta - 1.0) / (eta + 1.0);
    f * f
}

/// The index above 1 with that reflectance along the normal.
#[inline]
pub fn eta_of(f0: f32) -> f32 {
    let s = f0.clamp(0.0, 0.99).sqrt();
    (1.0 + s) / (1.0 - s)
}

/// Reflectance of a metal of index `n` and extinction `k`, by channel: the usual approximation for n² + k² well above 1, which is Cycles' too
/// (measured; exact values are up to 0.005 lower). Source: Lazányi and Szirmay-Kalos 2005, equations 3 and 4.
pub fn conductor(cos: f32, n: Rgb, k: Rgb) -> Rgb {
    let (both, twice, cos_sq) = (n * n + k * k, 2.0 * cos * n, cos * cos);
    let s = (both + cos_sq - twice) / (both + cos_sq + twice);
    let p = (both * cos_sq + 1.0 - twice) / (both * cos_sq + 1.0 + twice);
    0.5 * (s + p)
}

/// 2 times the integral of a metal's reflectance times the cosine: that of the F82 curve with the same ends and the same dip, as in Cycles
/// (measured by what energy it puts back at roughness 1).
pub fn conductor_mean(n: Rgb, k: Rgb) -> Rgb {
    let f0 = conductor(1.0, n, k);
    let c = 1.0f32 / 7.0;
    let schlick = f0 + (Vec3::ONE - f0) * (1.0 - c).powi(5);
    f82_mean(f0, (schlick - conductor(c, n, k)) / (c * (1.0 - c).powi(6)))
}

/// 2 times the integral of the F82 curve times the cosine: 2 ∫ (1-c)^5 c = 1/21, 2 ∫ c (1-c)^6 c = 1/126.
pub fn f82_mean(f0: Rgb, dip: Rgb) -> Rgb {
    (f0 + (Vec3::ONE - f0) / 21.0 - dip / 126.0).clamp(Vec3::ZERO, Vec3::ONE)
}

/// Index and reflectance along the normal of a Principled highlight: its index, with the reflectance times twice `level` (Cycles' "IOR level").
pub fn highlight_of(ior: f32, level: f32) -> (f32, f32) {
    if level == 0.5 {
        return (ior, f0_of(ior));
    }
    let f0 = f0_of(ior) * (2.0 * level);
    let eta = eta_of(f0);
    (if ior < 1.0 { 1.0 / eta } else { eta }, f0)
}

/// 2 times the integral of F(cos) cos over 0..1: what a dielectric reflects of light from everywhere.
pub fn dielectric_average(eta: f32) -> f32 {
    const N: usize = 64;
    let mut sum = 0.0;
    for k in 0..N {
        // Midpoints in the root of the cosine: most happens near the rim.
        let x = (k as f32 + 0.5) / N as f32;
        sum += dielectric(x * x, eta).0 * 4.0 * x * x * x;
    }
    sum / N as f32
}

/// What a microfacet reflects and lets through.
#[derive(Clone, Copy, Debug)]
pub enum Fresnel {
    /// All is reflected.
    Mirror,
    /// All is refracted that can be.
    Clear {
        /// Index.
        eta: f32,
    },
    /// A dielectric whose curve is stretched from F0..1 to `f0`..1. Source: Cycles' Principled, measured.
    Dielectric {
        /// Index.
        eta: f32,
        /// Reflectance along the normal.
        f0: Rgb,
        /// Multiplies what is reflected, and what goes through.
        tint: [Rgb; 2],
    },
    /// A metal. Source: Kutz, Hasan and Edmondson 2021 (F82-tint).
    F82 {
        /// Reflectance along the normal.
        f0: Rgb,
        /// Factor of the dip, see [`f82_dip`].
        dip: Rgb,
    },
    /// A metal by the Fresnel equations, see [`conductor`].
    Conductor {
        /// Index.
        n: Rgb,
        /// Extinction.
        k: Rgb,
    },
    /// A film on a dielectric.
    Film {
        /// Film.
        film: ThinFilm,
        /// Index below the film.
        eta: f32,
        /// As above; stretches the reflectance.
        f0: Rgb,
        /// As above.
        tint: [Rgb; 2],
    },
}

/// Factor of the dip such that reflectance at 82 degrees (cos 1/7) is Schlick's times `tint`.
pub fn f82_dip(f0: Rgb, tint: Rgb) -> Rgb {
    let c = 1.0f32 / 7.0;
    let p5 = (1.0 - c).powi(5);
    let schlick = f0 + (Vec3::ONE - f0) * p5;
    schlick * (Vec3::ONE - tint) / (c * (1.0 - c).powi(6))
}

impl Fresnel {
    /// Reflected and let through, and the (negative) cosine of the refracted ray.
    #[inline]
    pub fn eval(&self, cos: f32) -> (Rgb, Rgb, f32) {
        match self {
            Self::Mirror => (Vec3::ONE, Vec3::ZERO, 0.0),
            Self::Clear { eta } => {
                let (f, t) = dielectric(cos, *eta);
                if t == 0.0 {
                    (Vec3::ZERO, Vec3::ZERO, 0.0)
                } else {
                    let _ = f;
                    (Vec3::ZERO, Vec3::ONE, t)
                }
            }
            Self::Dielectric { eta, f0, tint } => {
                let (f, t) = dielectric(cos, *eta);
                if t == 0.0 {
                    return (tint[0], Vec3::ZERO, 0.0);
                }
                let real = f0_of(*eta);
                let s = ((f - real) / (1.0 - real)).clamp(0.0, 1.0);
                let r = *f0 + (Vec3::ONE - *f0) * s;
                (r * tint[0], (Vec3::ONE - r) * tint[1], t)
            }
            Self::F82 { f0, dip } => {
                let m = 1.0 - cos;
                let p5 = m.powi(5);
                let r = *f0 + (Vec3::ONE - *f0) * p5 - *dip * (cos * p5 * m);
                (r.clamp(Vec3::ZERO, Vec3::ONE), Vec3::ZERO, 0.0)
            }
            Self::Conductor { n, k } => (conductor(cos, *n, *k), Vec3::ZERO, 0.0),
            Self::Film { film, eta, f0, tint } => {
                let (_, t) = dielectric(cos, *eta);
                if t == 0.0 {
                    return (tint[0], Vec3::ZERO, 0.0);
                }
                let real = f0_of(*eta);
                let scale = if real > 0.0 { *f0 / real } else { Vec3::ONE };
                let r = (film.reflectance(cos, *eta) * scale).clamp(Vec3::ZERO, Vec3::ONE);
                (r * tint[0], (Vec3::ONE - r) * tint[1], t)
            }
        }
    }

    /// Index for refraction, 1 for what does not refract.
    #[inline]
    pub fn eta(&self) -> f32 {
        match self {
            Self::Mirror | Self::F82 { .. } | Self::Conductor { .. } => 1.0,
            Self::Clear { eta } | Self::Dielectric { eta, .. } | Self::Film { eta, .. } => *eta,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dielectric_is_known_at_both_ends_and_reversible() {
        assert!((dielectric(1.0, 1.5).0 - 0.04).abs() < 1e-6);
        assert!((dielectric(0.0, 1.5).0 - 1.0).abs() < 1e-6);
        assert_eq!(dielectric(0.3, 1.0 / 1.5), (1.0, 0.0), "beyond the critical angle");
        let (f, t) = dielectric(0.6, 1.5);
        assert!((dielectric(-t, 1.0 / 1.5).0 - f).abs() < 1e-6, "light runs both ways");
        assert!((eta_of(0.04) - 1.5).abs() < 1e-5);
        // Source: Egan and Hilgeman 1979, diffuse reflectance of an index of 1.5 from outside.
        assert!((dielectric_average(1.5) - 0.0918).abs() < 3e-4, "{}", dielectric_average(1.5));
    }

    #[test]
    fn f82_metal_has_its_tint_at_82_degrees() {
        let (f0, tint) = (Vec3::new(0.9, 0.6, 0.3), Vec3::new(0.5, 1.0, 0.2));
        let f = Fresnel::F82 { f0, dip: f82_dip(f0, tint) };
        assert!((f.eval(1.0).0 - f0).length() < 1e-6);
        let schlick = f0 + (Vec3::ONE - f0) * (6.0f32 / 7.0).powi(5);
        assert!((f.eval(1.0 / 7.0).0 - schlick * tint).length() < 1e-5);
    }

    #[test]
    fn metals_are_known_at_both_ends() {
        // Source: ((n - 1)² + k²) / ((n + 1)² + k²) along the normal; all is reflected at the rim.
        let (n, k) = (Vec3::new(0.143, 0.374, 1.442), Vec3::new(3.983, 2.385, 1.603));
        let along = ((n - 1.0) * (n - 1.0) + k * k) / ((n + 1.0) * (n + 1.0) + k * k);
        assert!((conductor(1.0, n, k) - along).length() < 1e-5);
        assert!((conductor(0.0, n, k) - Vec3::ONE).length() < 1e-5);
    }

    #[test]
    fn metals_reflect_what_cycles_measures() {
        // Source: Cycles 4.5.15, a mirror of the Metallic closure in a white room.
        let (n, k) = (Vec3::new(0.27, 0.68, 1.32), Vec3::new(3.6, 2.6, 2.3));
        for (degrees, want) in
            [(5.0f32, [0.925_90, 0.716_15, 0.505_27]), (60.0, [0.920_45, 0.721_50, 0.522_87]), (80.0, [0.929_81, 0.806_03, 0.664_61])]
        {
            let got = conductor(degrees.to_radians().cos(), n, k);
            assert!((got - Vec3::from_array(want)).abs().max_element() < 1e-4, "{degrees} degrees: {got}");
        }
        // The same at roughness 1 with and without the light of many bounces gives this mean.
        assert!((conductor_mean(n, k) - Vec3::new(0.926, 0.727, 0.524)).abs().max_element() < 2e-3, "{}", conductor_mean(n, k));
    }
}
