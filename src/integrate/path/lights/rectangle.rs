//! Rectangles as seen from a point, drawn by solid angle; and pairs of triangles that are one.
//!
//! Source: Ureña, Fajardo and King 2013, "An Area-Preserving Parametrization for Spherical Rectangles".

use super::triangle::{LEAST_SOLID_ANGLE, MOST_SOLID_ANGLE, density_by_area};
use crate::math::DVec3;
use std::f64::consts::PI;

/// Sides of a rectangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sides {
    /// Unit, along the sides, and across both.
    axes: [DVec3; 3],
    /// Half lengths.
    half: [f64; 2],
}

impl Sides {
    /// Of half axes; `None` for skewed ones.
    pub fn new([a, b]: [DVec3; 2]) -> Option<Self> {
        let half = [a.length(), b.length()];
        let (x, y) = (a / half[0], b / half[1]);
        (x.dot(y).abs() <= 1e-6).then(|| Self { axes: [x, y, x.cross(y)], half })
    }
}

/// A rectangle as seen from the origin.
pub(super) struct SeenRectangle<'s> {
    sides: &'s Sides,
    /// Place of its plane across the sides, signed; and how far that is.
    height: f64,
    z: f64,
    x: [f64; 2],
    y: [f64; 2],
    /// 1 / length from the origin's foot in the plane's axes to the sides of least and greatest y.
    far: [f64; 2],
    /// A number whose angle is that of the two corners of least x together, and its length.
    turn: [f64; 2],
    turn_length: f64,
    /// sr.
    pub solid_angle: f64,
}

impl<'s> SeenRectangle<'s> {
    /// Centre `to` relative to the viewer; `None` for those seen so small (`least`, sr) that area sampling is as good.
    ///
    /// The angles at the corners of the sphere's rectangle are those of complex numbers that ask for no more than a root each; their product has the
    /// sum of all four.
    #[inline]
    pub fn new(to: DVec3, sides: &'s Sides, least: f64) -> Option<Self> {
        let [ax, ay, az] = sides.axes;
        let (mx, my, height) = (to.dot(ax), to.dot(ay), to.dot(az));
        let (x, y) = ([mx - sides.half[0], mx + sides.half[0]], [my - sides.half[1], my + sides.half[1]]);
        let z = height.abs();
        let zz = z * z;
        let corner = |i: usize, k: usize| z * (x[i] * x[i] + y[k] * y[k] + zz).sqrt();
        let product = |a: [f64; 2], b: [f64; 2]| [a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]];
        let turn = product([x[0] * y[1], corner(0, 1)], [-x[0] * y[0], corner(0, 0)]);
        let all = product(turn, product([x[1] * y[0], corner(1, 0)], [-x[1] * y[1], corner(1, 1)]));
        let sum = all[1].atan2(all[0]);
        let solid_angle = if sum < 0.0 { sum + 2.0 * PI } else { sum };
        // In its plane it is a line.
        if !(z > 0.0 && solid_angle > least) {
            return None;
        }
        let far = y.map(|y| 1.0 / (y * y + zz).sqrt());
        Some(Self { sides, height, z, x, y, far, turn, turn_length: (turn[0] * turn[0] + turn[1] * turn[1]).sqrt(), solid_angle })
    }

    /// A point, even over the solid angle.
    #[inline]
    pub fn sample(&self, u: f64, v: f64) -> DVec3 {
        let (sine, cos) = (u * self.solid_angle).sin_cos();
        let [re, im] = self.turn;
        let (b0, b1) = (-self.y[0] * self.far[0], self.y[1] * self.far[1]);
        // Turned back by the corners of least x.
        let f = ((cos * re + sine * im) * b0 - self.turn_length * b1) / (sine * re - cos * im);
        let q = f * f + b0 * b0;
        let x = (self.z.copysign(f) / (q - 1.0).max(1e-18 * q).sqrt()).clamp(self.x[0], self.x[1]);
        let d_sq = x * x + self.z * self.z;
        let [h0, h1] = self.y.map(|y| y / (d_sq + y * y).sqrt());
        let h = h0 + v * (h1 - h0);
        let y = if h * h < 1.0 - 1e-12 { h * (d_sq / (1.0 - h * h)).sqrt() } else { self.y[1] };
        let [ax, ay, az] = self.sides.axes;
        ax * x + ay * y.clamp(self.y[0], self.y[1]) + az * self.height
    }
}

/// Two triangles that are one rectangle.
#[derive(Clone, Copy, Debug)]
pub struct Rectangle {
    /// Its middle.
    pub center: DVec3,
    /// At right angles; the first triangle lies where the sum of the places along both, -1..=1, is below 0.
    pub half: [DVec3; 2],
    /// Whole area.
    pub area: f64,
    sides: Sides,
}

/// Corners may be off by this share of the sides: 32 bits of the world's places, and what a transform makes of right angles.
const TOLERANCE: f64 = 1e-5;

impl Rectangle {
    /// Of two triangles that turn the same way round and meet at their longest sides.
    pub fn of(first: &[DVec3; 3], second: &[DVec3; 3]) -> Option<Self> {
        let normal = |c: &[DVec3; 3]| (c[1] - c[0]).cross(c[2] - c[0]);
        if !(normal(first).dot(normal(second)) > 0.0) {
            return None;
        }
        (0..3).find_map(|k| {
            let [p, q, r] = [first[k], first[(k + 1) % 3], first[(k + 2) % 3]];
            let (along, across) = (q - p, r - p);
            let size = along.length() + across.length();
            if !(along.dot(across).abs() <= TOLERANCE * along.length() * across.length()) {
                return None;
            }
            let has = |want: DVec3| second.iter().any(|c| (*c - want).length() <= TOLERANCE * size);
            if !(has(q) && has(r) && has(q + across)) {
                return None;
            }
            let half = [0.5 * along, 0.5 * (across - along * (along.dot(across) / along.length_squared()))];
            Some(Self { center: 0.5 * (q + r), half, area: along.cross(across).length(), sides: Sides::new(half)? })
        })
    }

    #[inline]
    fn seen(&self, from: DVec3) -> Option<SeenRectangle<'_>> {
        SeenRectangle::new(self.center - from, &self.sides, LEAST_SOLID_ANGLE).filter(|s| s.solid_angle < MOST_SOLID_ANGLE)
    }

    /// A point of it for `from`, from where it is looked at; and the density (1/sr), `None` where it was drawn evenly over the area.
    #[inline]
    pub fn sample(&self, from: DVec3, [u, v]: [f64; 2]) -> (DVec3, Option<f64>) {
        match self.seen(from) {
            Some(s) => (s.sample(u, v), Some(1.0 / s.solid_angle)),
            None => (self.center - from + self.half[0] * (2.0 * u - 1.0) + self.half[1] * (2.0 * v - 1.0), None),
        }
    }

    /// Density (1/sr) with which [`Self::sample`] draws the point met from `from` at distance squared `d_sq`, under `cos` to the normal.
    #[inline]
    pub fn density(&self, from: DVec3, d_sq: f64, cos: f64) -> f64 {
        self.seen(from).map_or_else(|| density_by_area(self.area, d_sq, cos), |s| 1.0 / s.solid_angle)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::sobol::Pcg;

    fn corners() -> [DVec3; 4] {
        let (p, x, y) = (DVec3::new(3.0, -2.0, 1.0), DVec3::new(0.6, 0.8, 0.0), DVec3::new(-0.8, 0.6, 0.0));
        [p, p + 2.0 * x, p + 2.0 * x + 1.5 * y, p + 1.5 * y]
    }

    #[test]
    fn two_triangles_are_a_rectangle_whatever_corner_comes_first() {
        let [a, b, c, d] = corners();
        let turned = |t: [DVec3; 3], k: usize| [t[k % 3], t[(k + 1) % 3], t[(k + 2) % 3]];
        for k in 0..9 {
            let r = Rectangle::of(&turned([a, b, c], k % 3), &turned([a, c, d], k / 3)).expect("a rectangle");
            assert!((r.area - 3.0).abs() < 1e-12 && (r.center - 0.25 * (a + b + c + d)).length() < 1e-12);
            // The first triangle's middle.
            let at = (a + b + c) / 3.0 - r.center;
            assert!(r.half.iter().map(|h| at.dot(*h) / h.length_squared()).sum::<f64>() < 0.0);
        }
        let skewed = [a, b, c + 0.1 * (b - a), d + 0.1 * (b - a)];
        assert!(Rectangle::of(&[a, b, skewed[2]], &[a, skewed[2], skewed[3]]).is_none(), "a parallelogram");
        assert!(Rectangle::of(&[a, b, c], &[a, d, c]).is_none(), "the second turned round");
        assert!(Rectangle::of(&[a, b, c], &[a, c, 2.0 * d - a]).is_none(), "another triangle");
    }

    /// The mean of a function over the directions drawn is its integral by area.
    #[test]
    fn points_are_drawn_with_their_density() {
        let [a, b, c, d] = corners();
        let r = Rectangle::of(&[a, b, c], &[a, c, d]).expect("a rectangle");
        let normal = (b - a).cross(c - a).normalize();
        let f = |d: DVec3| d.x * d.x + 0.3 * d.z + 1.0;
        for from in [DVec3::ZERO, DVec3::new(3.2, -1.5, 0.8), DVec3::new(3.2, -1.5, 1.4), DVec3::new(30.0, 10.0, 25.0)] {
            let (mut rng, n) = (Pcg::new(5), 200_000);
            let (mut drawn, mut by_area) = (0.0, 0.0);
            for _ in 0..n {
                let u = [f64::from(rng.draw()), f64::from(rng.draw())];
                let (to, density) = r.sample(from, u);
                let told = r.density(from, to.length_squared(), to.normalize().dot(normal));
                assert!(density.is_none_or(|p| p == told));
                drawn += f(to.normalize()) / told;
                let to = a + u[0] * (b - a) + u[1] * (d - a) - from;
                by_area += f(to.normalize()) * to.normalize().dot(normal).abs() * r.area / to.length_squared();
            }
            assert!((drawn / by_area - 1.0).abs() < 0.01, "{from}: {}", drawn / by_area);
        }
    }
}
