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
            Self::Mirror | Self::F82 { .. } => 1.0,
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
}
