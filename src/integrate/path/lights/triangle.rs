//! Points of a triangle as seen from one: by solid angle where it fills some of the view, else by area.
//!
//! Source: Arvo 1995, "Stratified Sampling of Spherical Triangles"; Heitz 2019, "A Low-Distortion Map Between Triangle and Square".

use crate::math::DVec3;

/// Triangles that fill less are drawn by area: both ways are the same there, and the GPU's 32 bits hold no solid angle of so few digits (sr).
pub const LEAST_SOLID_ANGLE: f64 = 0.01;
/// Triangles that fill more are drawn by area: their sphere's side has no inside any more (sr).
pub const MOST_SOLID_ANGLE: f64 = 6.2;

/// A triangle on the unit sphere.
#[derive(Clone, Copy, Debug)]
struct Spherical {
    /// Unit, to the corners.
    corners: [DVec3; 3],
    /// sr.
    solid_angle: f64,
}

impl Spherical {
    /// As seen from `from`; `None` where it is to be drawn by area.
    fn new(corners: [DVec3; 3], from: DVec3) -> Option<Self> {
        let c = corners.map(|c| (c - from).normalize_or_zero());
        // Source: Van Oosterom and Strackee 1983.
        let volume = c[0].dot(c[1].cross(c[2])).abs();
        let solid_angle = 2.0 * volume.atan2(1.0 + c[0].dot(c[1]) + c[1].dot(c[2]) + c[2].dot(c[0]));
        (solid_angle > LEAST_SOLID_ANGLE && solid_angle < MOST_SOLID_ANGLE).then_some(Self { corners: c, solid_angle })
    }

    /// A direction, even over the solid angle; `None` where the triangle is seen along its plane.
    fn direction(&self, u: f64, v: f64) -> Option<DVec3> {
        let [a, b, c] = self.corners;
        // The angle at `a`, between the great circles to the other corners.
        let (ab, ac) = (a.cross(b).try_normalize()?, a.cross(c).try_normalize()?);
        let (cos_a, sin_a) = (ab.dot(ac), ab.cross(ac).length());
        // The part of it whose excess is `u` of the whole: its corner on the side from `a` to `c`.
        let (sin_e, cos_e) = (u * self.solid_angle).sin_cos();
        let (sin_phi, cos_phi) = (sin_a * cos_e - cos_a * sin_e, -(cos_a * cos_e + sin_a * sin_e));
        let (k1, k2) = (cos_phi + cos_a, sin_phi - sin_a * a.dot(b));
        let cos_b = (k2 + (k2 * cos_phi - k1 * sin_phi) * cos_a) / ((k2 * sin_phi + k1 * cos_phi) * sin_a);
        let cos_b = if cos_b.is_nan() { 1.0 } else { cos_b.clamp(-1.0, 1.0) };
        let beside = |p: DVec3, axis: DVec3| (p - axis * axis.dot(p)).normalize_or_zero();
        let corner = a * cos_b + beside(c, a) * (1.0 - cos_b * cos_b).max(0.0).sqrt();
        let z = 1.0 - v * (1.0 - corner.dot(b));
        (b * z + beside(corner, b) * (1.0 - z * z).max(0.0).sqrt()).try_normalize()
    }
}

/// A point of a triangle drawn for another.
#[derive(Clone, Copy, Debug)]
pub struct TrianglePoint {
    /// Weights of the second and the third corner.
    pub weights: [f64; 2],
    /// 1/sr; `None` where it was drawn evenly over the area.
    pub density: Option<f64>,
}

/// Draws a point of the triangle for `from`.
pub fn sample([c0, c1, c2]: [DVec3; 3], from: DVec3, [u, v]: [f64; 2]) -> TrianglePoint {
    let by_angle = || {
        let s = Spherical::new([c0, c1, c2], from)?;
        let dir = s.direction(u, v)?;
        let (e1, e2, to) = (c1 - c0, c2 - c0, from - c0);
        let p = dir.cross(e2);
        let inv = 1.0 / e1.dot(p);
        // Rounding leaves the triangle by a little.
        let (b1, b2) = ((to.dot(p) * inv).clamp(0.0, 1.0), (dir.dot(to.cross(e1)) * inv).clamp(0.0, 1.0));
        let share = 1.0 / (b1 + b2).max(1.0);
        inv.is_finite().then_some(TrianglePoint { weights: [b1 * share, b2 * share], density: Some(1.0 / s.solid_angle) })
    };
    by_angle().unwrap_or_else(|| {
        let weights = if v > u { [0.5 * u, v - 0.5 * u] } else { [u - 0.5 * v, 0.5 * v] };
        TrianglePoint { weights, density: None }
    })
}

/// Density (1/sr) of [`sample`] where it draws by area: at distance squared `d_sq`, under `cos` to the normal.
pub fn density_by_area(area: f64, d_sq: f64, cos: f64) -> f64 {
    d_sq / (cos.abs() * area)
}

/// Density (1/sr) with which [`sample`] draws the point met from `from` at distance squared `d_sq`, under `cos` to the normal.
pub fn density(corners: [DVec3; 3], from: DVec3, area: f64, d_sq: f64, cos: f64) -> f64 {
    Spherical::new(corners, from).map_or_else(|| density_by_area(area, d_sq, cos), |s| 1.0 / s.solid_angle)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::sobol::Pcg;

    /// An octant fills an eighth of the sphere.
    #[test]
    fn solid_angles_are_those_of_the_sphere() {
        let s = Spherical::new([DVec3::X, DVec3::Y, DVec3::Z], DVec3::ZERO).expect("large");
        assert!((s.solid_angle - std::f64::consts::FRAC_PI_2).abs() < 1e-14);
        assert!(Spherical::new([DVec3::X, DVec3::Y, DVec3::Z], DVec3::splat(-50.0)).is_none());
    }

    /// The mean of a function over the directions drawn is its integral by area.
    #[test]
    fn directions_are_even_over_the_solid_angle() {
        let corners = [DVec3::new(-1.0, -0.5, 0.4), DVec3::new(2.0, -0.3, 0.5), DVec3::new(0.2, 1.5, 0.9)];
        let area = 0.5 * (corners[1] - corners[0]).cross(corners[2] - corners[0]).length();
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize();
        let f = |d: DVec3| d.z * d.z + 0.3 * d.x;
        for from in [DVec3::ZERO, DVec3::new(0.4, 0.1, 0.2), DVec3::new(0.0, 0.0, -1.0)] {
            let mut rng = Pcg::new(5);
            let n = 200_000;
            let (mut drawn, mut by_area) = (0.0, 0.0);
            for _ in 0..n {
                let u = [f64::from(rng.draw()), f64::from(rng.draw())];
                let at = |[b1, b2]: [f64; 2]| corners[0] + b1 * (corners[1] - corners[0]) + b2 * (corners[2] - corners[0]) - from;
                let to = at(sample(corners, from, u).weights);
                drawn += f(to.normalize()) / density(corners, from, area, to.length_squared(), to.normalize().dot(normal));
                let root = u[0].sqrt();
                let to = at([1.0 - root, u[1] * root]);
                by_area += f(to.normalize()) * to.normalize().dot(normal).abs() * area / to.length_squared();
            }
            let (drawn, by_area) = (drawn / f64::from(n), by_area / f64::from(n));
            assert!((drawn / by_area - 1.0).abs() < 0.01, "{from}: {drawn} {by_area}");
        }
    }
}
