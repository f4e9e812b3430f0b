//! Sheen of microfibres: a linearly transformed cosine per viewing angle and roughness. In the frame of the surface, values with the cosine.
//!
//! Source: Zeltner, Burley and Chiang 2022; its coefficients from a table (`sheen.txt`, measured), mixed linearly. Twin: `shaders/path/sheen.wesl`.

use super::frame::cosine_hemisphere;
use crate::math::Vec3;
use std::f32::consts::PI;
use std::sync::LazyLock;

/// Cosines of the table, and roughnesses: even, from 0 to 1.
const SIDE: usize = 32;

static TABLE: LazyLock<Vec<Vec3>> = LazyLock::new(|| {
    let lines = include_str!("sheen.txt").lines().filter(|l| !l.starts_with('#'));
    let number = |w: Option<&str>| w.and_then(|w| w.parse().ok()).expect("three numbers a line");
    let table: Vec<Vec3> = lines
        .map(|l| {
            let mut words = l.split(' ');
            Vec3::new(number(words.next()), number(words.next()), number(words.next()))
        })
        .collect();
    assert_eq!(table.len(), SIDE * SIDE, "sheen.txt has a line an entry");
    table
});

/// The transform's a and b and the albedo by cosine of the viewer, then roughness, for other machines.
pub fn table() -> &'static [Vec3] {
    &TABLE
}

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
        let steps = (SIDE - 1) as f32;
        let (c, r) = (v.z.clamp(0.0, 1.0) * steps, roughness.clamp(0.0, 1.0) * steps);
        let (i, j) = ((c as usize).min(SIDE - 2), (r as usize).min(SIDE - 2));
        let along = |k: usize| TABLE[k * SIDE + j].lerp(TABLE[k * SIDE + j + 1], r - j as f32);
        let [a, b, albedo] = along(i).lerp(along(i + 1), c - i as f32).to_array();
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
