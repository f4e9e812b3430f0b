//! Sheen of microfibres: a linearly transformed cosine per viewing angle and roughness. In the frame of the surface, values with the cosine.
//!
//! Source: Zeltner, Burley and Chiang 2022; rational fits of its coefficients as published with MaterialX 1.39.

use super::frame::cosine_hemisphere;
use crate::math::Vec3;
use std::f32::consts::PI;

/// A lobe for one viewer.
#[derive(Clone, Copy, Debug)]
pub struct Sheen {
    /// Inverse of the transform: [a 0 b; 0 a 0; 0 0 1].
    a: f32,
    b: f32,
    /// Directional albedo.
    pub albedo: f32,
    /// Unit, in the tangent plane, towards the viewer.
    x: (f32, f32),
}

impl Sheen {
    /// `v` is the viewer, above the surface.
    pub fn new(roughness: f32, v: Vec3) -> Self {
        let (c, r) = (v.z.clamp(0.0, 1.0), roughness.clamp(0.01, 1.0));
        let a = (2.58126 * c + 0.813703 * r) * r / (1.0 + 0.310327 * c * c + 2.60994 * c * r);
        let b = (1.0 - c).sqrt() * (r - 1.0) * r * r * r / (0.0000254053 + 1.71228 * c - 1.71506 * c * r + 1.34174 * r * r);
        let s = r * (0.0206607 + 1.58491 * r) / (0.0379424 + r * (1.32227 + r));
        let m = r * (-0.193854 + r * (-1.14885 + r * (1.7932 - 0.95943 * r * r))) / (0.046391 + r);
        let o = r * (0.000654023 + (-0.0207818 + 0.119681 * r) * r) / (1.26264 + r * (-1.92021 + r));
        let k = (c - m) / s;
        let albedo = ((-0.5 * k * k).exp() / (s * (2.0 * PI).sqrt()) + o).clamp(0.0, 1.0);
        let len = v.x.hypot(v.y);
        Self { a, b, albedo, x: if len > 0.0 { (v.x / len, v.y / len) } else { (1.0, 0.0) } }
    }

    /// Density of a direction; the value is albedo times this.
    pub fn pdf(&self, l: Vec3) -> f32 {
        if l.z <= 0.0 {
            return 0.0;
        }
        let along = l.x * self.x.0 + l.y * self.x.1;
        let across = l.y * self.x.0 - l.x * self.x.1;
        let w = Vec3::new(self.a * along + self.b * l.z, self.a * across, l.z);
        let k = self.a / w.length_squared();
        w.z / PI * k * k
    }

    /// A direction with that density.
    pub fn sample(&self, u: f32, v: f32) -> Vec3 {
        let w = cosine_hemisphere(u, v);
        let (along, across) = ((w.x - self.b * w.z) / self.a, w.y / self.a);
        Vec3::new(along * self.x.0 - across * self.x.1, along * self.x.1 + across * self.x.0, w.z).normalize_or(Vec3::Z)
    }
}
