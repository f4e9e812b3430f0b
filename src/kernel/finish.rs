//! How a POV-Ray finish answers light: diffuse, highlights, thin film, reflectivity, fresnel. Plain formulas over numbers;
//! who asks for them, and with which rays, is `integrate/classic`'s business. Source: FACTS.md section 2; spec/light.md sections 3 and 4.
//! Twin: `shaders/shared/finish`.

use crate::math::{DVec3, EPSILON, Rgb, Vec3};
use crate::scene::Finish;
use crate::scene::texture::Reflection;
use std::f64::consts::FRAC_PI_2;

/// `b^e` for the exponents of finishes; exactly `b` when the exponent is 1.
#[inline]
pub fn power(b: f64, e: f64) -> f64 {
    if e == 1.0 { b } else { b.powf(e) }
}

/// Whether `b^e` is below 1e-8 for certain: what a highlight adds there cannot be seen, and most points of a surface lie there.
#[inline]
fn vanishes(b: f64, e: f64) -> bool {
    // ln b < b - 1.
    e * (1.0 - b) > 18.5
}

/// How far a metallic tint fades at grazing angles: 0 along the normal, 1 along the surface.
#[inline]
fn metallic_fade(cos: f64) -> f64 {
    let x = cos.clamp(-1.0, 1.0).acos().abs() / FRAC_PI_2;
    (0.014_567_225 / ((x - 1.12) * (x - 1.12)) - 0.011_612_903).clamp(0.0, 1.0)
}

/// The factor that a metallic finish puts on a highlight or a reflection seen at cosine `cos` from the normal.
#[inline]
pub fn metallic_tint(metallic: f32, cos: f64, pigment: Rgb) -> Rgb {
    if metallic == 0.0 {
        return Vec3::ONE;
    }
    let k = f64::from(metallic) * (1.0 - metallic_fade(cos));
    Vec3::ONE + k as f32 * (pigment - Vec3::ONE)
}

/// Highlights of light from unit direction `to_light` seen along `ray_dir`, as a colour to multiply with the light's.
pub fn highlights(f: &Finish, ray_dir: DVec3, normal: DVec3, to_light: DVec3, pigment: Rgb) -> Rgb {
    let mut sum = Vec3::ZERO;
    if f.phong > 0.0 {
        let reflected = ray_dir - 2.0 * ray_dir.dot(normal) * normal;
        let cos = reflected.dot(to_light);
        if cos > 0.0 && (f.phong_size < 60.0 || cos > 0.0008) && !vanishes(cos, f64::from(f.phong_size)) {
            let k = f64::from(f.phong) * power(cos, f64::from(f.phong_size));
            sum += k as f32 * metallic_tint(f.metallic, normal.dot(to_light), pigment);
        }
    }
    if f.specular > 0.0 {
        let half = 0.5 * (to_light - ray_dir);
        let len = half.length();
        if len > EPSILON {
            let (cos, sharpness) = (half.dot(normal) / len, 1.0 / f64::from(f.roughness));
            if cos > 0.0 && !vanishes(cos, sharpness) {
                let k = f64::from(f.specular) * power(cos, sharpness);
                sum += k as f32 * metallic_tint(f.metallic, normal.dot(to_light), pigment);
            }
        }
    }
    sum
}

/// The thin film's factor on light from `to_light`; `noise` is the film's turbulence value at the point, 0.5 without turbulence.
pub fn thin_film(f: &Finish, wavelength: Rgb, ray_dir: DVec3, normal: DVec3, to_light: DVec3, noise: f64) -> Rgb {
    let [amount, thickness, turb] = f.irid.map(f64::from);
    let thickness = thickness * (1.0 + turb * (2.0 * noise - 1.0));
    let path = std::f64::consts::TAU * thickness * (normal.dot(to_light).abs() + normal.dot(ray_dir).abs());
    wavelength.to_array().map(|wl| (1.0 + amount * (path / f64::from(wl)).cos()) as f32).into()
}

/// Share of unpolarised light that a dielectric of relative index `n` reflects at cosine `cos` (exact); `None` for total reflection.
pub fn fresnel(n: f64, cos: f64) -> Option<f64> {
    let g_sq = n * n + cos * cos - 1.0;
    if g_sq <= 0.0 {
        return None;
    }
    let g = g_sq.sqrt();
    let a = (g - cos) / (g + cos);
    let b = (cos * (g + cos) - 1.0) / (cos * (g - cos) + 1.0);
    let f = 0.5 * a * a * (1.0 + b * b);
    // 0/0 at grazing incidence on an equal medium.
    Some(if f.is_nan() { 1.0 } else { f.clamp(0.0, 1.0) })
}

/// Colour factor of the reflected ray. `cos` is -ray·normal (may be outside 0..1), `relative_ior` far side over near side.
pub fn reflectivity(r: &Reflection, cos: f64, relative_ior: f64, pigment: Rgb) -> Rgb {
    let plain = if r.fresnel {
        match fresnel(relative_ior, cos) {
            None => r.max,
            Some(f) => f as f32 * r.max + (1.0 - f) as f32 * r.min,
        }
    } else if r.min == r.max {
        r.max
    } else {
        let x = 1.0 - cos;
        let f = if (f64::from(r.falloff) - 1.0).abs() < EPSILON { x } else { x.powf(f64::from(r.falloff)) };
        if f.abs() < EPSILON {
            r.min
        } else if (f - 1.0).abs() < EPSILON {
            r.max
        } else {
            f as f32 * r.max + (1.0 - f) as f32 * r.min
        }
    };
    plain * metallic_tint(r.metallic, cos, pigment)
}

/// `c^(1/exponent)` by channel, negative channels kept at 0.
pub fn reflected_power(c: Rgb, exponent: f32) -> Rgb {
    if exponent == 1.0 { c } else { c.max(Vec3::ZERO).powf(1.0 / exponent) }
}

/// The direction of a mirror ray. `n` is the layer's normal, `g` the geometric one, both facing against `dir`.
///
/// Rays that would enter the surface are turned back: at `g` alone when they lie below the layer's plane too, else once more at `g`.
pub fn reflect(dir: DVec3, n: DVec3, g: DVec3) -> DVec3 {
    let mirror = |d: DVec3, n: DVec3| d - 2.0 * d.dot(n) * n;
    let mut out = mirror(dir, n);
    if out.dot(g) < 0.0 {
        out = if out.dot(n) < 0.0 { mirror(dir, g) } else { mirror(out, g) };
    }
    out.normalize_or_zero()
}

/// Snell's law for `n` = near index / far index; `None` for total reflection. `normal` may face either way; the result is not normalised.
pub fn refract(dir: DVec3, normal: DVec3, n: f64) -> Option<DVec3> {
    let (mut cos, mut facing) = (dir.dot(normal), normal);
    if cos <= 0.0 {
        cos = -cos;
    } else {
        facing = -normal;
    }
    let t = 1.0 + n * n * (cos * cos - 1.0);
    (t >= 0.0).then(|| n * dir + (n * cos - t.sqrt()) * facing)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fresnel_at_normal_incidence_is_the_squared_ratio() {
        for n in [1.33f64, 1.5, 1.0 / 1.5, 2.4] {
            let want = ((n - 1.0) / (n + 1.0)).powi(2);
            assert!((fresnel(n, 1.0).expect("no total reflection") - want).abs() < 1e-15);
        }
        assert!((fresnel(1.5, 0.0).expect("entering") - 1.0).abs() < 1e-12);
        assert!(fresnel(1.0 / 1.5, 0.3).is_none());
    }

    #[test]
    fn refraction_obeys_snell() {
        for deg in [0.0f64, 20.0, 45.0, 80.0] {
            let (s, c) = deg.to_radians().sin_cos();
            let out = refract(DVec3::new(s, -c, 0.0), DVec3::Y, 1.0 / 1.5).expect("entering");
            assert!((out.x - s / 1.5).abs() < 1e-15 && (out.length() - 1.0).abs() < 1e-14);
        }
        let (s, c) = 50f64.to_radians().sin_cos();
        assert!(refract(DVec3::new(s, -c, 0.0), DVec3::Y, 1.5).is_none(), "beyond the critical angle of 41.8 degrees");
    }

    #[test]
    fn reflection_never_enters_the_surface() {
        for k in 0..100 {
            let a = f64::from(k) * 0.03 - 1.5;
            let n = DVec3::new(a.sin(), a.cos(), 0.0);
            let dir = DVec3::new(0.9, -0.2, 0.1).normalize();
            assert!(reflect(dir, n, DVec3::Y).y >= -1e-12, "bump angle {a}");
        }
    }

    #[test]
    fn metallic_tint_is_the_pigment_along_the_normal_and_white_along_the_surface() {
        let c = Vec3::new(0.2, 0.5, 0.8);
        assert!((metallic_tint(1.0, 1.0, c) - c).length() < 1e-5);
        assert!((metallic_tint(1.0, 0.0, c) - Vec3::ONE).length() < 1e-3);
    }

    #[test]
    fn specular_peaks_where_the_half_vector_is_the_normal() {
        let f = Finish { specular: 0.7, roughness: 0.01, ..Finish::default() };
        let (s, c) = 30f64.to_radians().sin_cos();
        let peak = highlights(&f, DVec3::new(s, -c, 0.0), DVec3::Y, DVec3::new(s, c, 0.0), Vec3::ONE);
        assert!((peak.x - 0.7).abs() < 1e-6);
    }
}
