//! An orthonormal frame about a normal, and directions in it: z is the normal.

use crate::math::Vec3;

/// Tangent, bitangent, normal: orthonormal, right-handed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// x.
    pub t: Vec3,
    /// y.
    pub b: Vec3,
    /// z.
    pub n: Vec3,
}

impl Frame {
    /// Where [`Frame::about`] changes from one pole's frame to the other's.
    pub const TURNS_AT: f32 = -1e-5;

    /// Any frame about unit `n`. Source: Duff et al. 2017. It turns where z is a little below 0, not at 0: the normals of upright walls have a z of
    /// ±1e-9, whose sign is rounding's, and two machines would draw other directions for the same random numbers.
    #[inline]
    pub fn about(n: Vec3) -> Self {
        let sign = if n.z >= Self::TURNS_AT { 1.0 } else { -1.0f32 };
        let a = -1.0 / (sign + n.z);
        let b = n.x * n.y * a;
        Self { t: Vec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x), b: Vec3::new(b, sign + n.y * n.y * a, -n.y), n }
    }

    /// About unit `n`, x as near to `tangent` as can be.
    pub fn with_tangent(n: Vec3, tangent: Vec3) -> Self {
        match (tangent - n * n.dot(tangent)).try_normalize() {
            Some(t) => Self { t, b: n.cross(t), n },
            None => Self::about(n),
        }
    }

    /// World to frame.
    #[inline]
    pub fn to_local(&self, v: Vec3) -> Vec3 {
        Vec3::new(v.dot(self.t), v.dot(self.b), v.dot(self.n))
    }

    /// Frame to world.
    #[inline]
    pub fn to_world(&self, v: Vec3) -> Vec3 {
        self.t * v.x + self.b * v.y + self.n * v.z
    }
}

/// Point of the unit disc, area preserving. Source: Shirley and Chiu 1997.
#[inline]
pub fn disc(u: f32, v: f32) -> (f32, f32) {
    let (a, b) = (2.0 * u - 1.0, 2.0 * v - 1.0);
    if a == 0.0 && b == 0.0 {
        return (0.0, 0.0);
    }
    let quarter = std::f32::consts::FRAC_PI_4;
    let (r, phi) = if a * a > b * b { (a, quarter * (b / a)) } else { (b, 2.0 * quarter - quarter * (a / b)) };
    let (s, c) = phi.sin_cos();
    (r * c, r * s)
}

/// Direction about +z with density cos / π.
#[inline]
pub fn cosine_hemisphere(u: f32, v: f32) -> Vec3 {
    let (x, y) = disc(u, v);
    Vec3::new(x, y, (1.0 - x * x - y * y).max(0.0).sqrt())
}

/// Direction with density 1 / 4π.
#[inline]
pub fn uniform_sphere(u: f32, v: f32) -> Vec3 {
    let z = 1.0 - 2.0 * u;
    let r = (1.0 - z * z).max(0.0).sqrt();
    let (s, c) = (std::f32::consts::TAU * v).sin_cos();
    Vec3::new(r * c, r * s, z)
}
