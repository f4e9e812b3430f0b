//! GGX microfacets, anisotropic: distribution, masking, sampling of the visible normals. Directions in the frame of the surface, z up.
//! Source: Walter et al. 2007; Heitz 2014; Dupuy and Benyoub 2023 (sampling by spherical caps).

use crate::math::Vec3;
use std::f32::consts::{PI, TAU};

/// Widths along x and y: roughness squared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ggx {
    /// Along x, above 0.
    pub ax: f32,
    /// Along y, above 0.
    pub ay: f32,
}

/// Below this product of widths a surface is a perfect mirror.
pub const SINGULAR: f32 = 5e-7;

impl Ggx {
    /// The same both ways.
    pub fn isotropic(a: f32) -> Self {
        Self { ax: a, ay: a }
    }

    /// Whether it is a mirror: no density to evaluate.
    #[inline]
    pub fn is_singular(&self) -> bool {
        self.ax * self.ay <= SINGULAR
    }

    /// Density of normals, per solid angle of the normal and area of the surface.
    #[inline]
    pub fn d(&self, h: Vec3) -> f32 {
        let (x, y) = (h.x / self.ax, h.y / self.ay);
        let k = x * x + y * y + h.z * h.z;
        1.0 / (PI * self.ax * self.ay * k * k)
    }

    /// Smith's Lambda.
    #[inline]
    pub fn lambda(&self, v: Vec3) -> f32 {
        let z_sq = v.z * v.z;
        if z_sq <= 0.0 {
            return f32::INFINITY;
        }
        let (x, y) = (v.x * self.ax, v.y * self.ay);
        let t = (x * x + y * y) / z_sq;
        // sqrt(1 + t) - 1 without losing digits.
        0.5 * t / (1.0 + (1.0 + t).sqrt())
    }

    /// Share of facets that `v` (z above 0) sees.
    #[inline]
    pub fn g1(&self, v: Vec3) -> f32 {
        1.0 / (1.0 + self.lambda(v))
    }

    /// Density of the normal `h` among those that `v` sees.
    #[inline]
    pub fn visible_density(&self, v: Vec3, h: Vec3) -> f32 {
        self.g1(v) * v.dot(h).max(0.0) * self.d(h) / v.z
    }

    /// A normal with that density; `v.z` is above 0.
    #[inline]
    pub fn sample_visible(&self, v: Vec3, u: f32, w: f32) -> Vec3 {
        let vs = Vec3::new(v.x * self.ax, v.y * self.ay, v.z).normalize();
        let (s, c) = (TAU * u).sin_cos();
        let z = (1.0 - w) * (1.0 + vs.z) - vs.z;
        let r = (1.0 - z * z).max(0.0).sqrt();
        let cap = Vec3::new(r * c, r * s, z) + vs;
        let h = Vec3::new(cap.x * self.ax, cap.y * self.ay, cap.z.max(0.0));
        h.try_normalize().unwrap_or(Vec3::Z)
    }
}
