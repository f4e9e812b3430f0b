//! Affine transforms with their inverse, composed in the order a scene writes them.

use super::{DAffine3, DMat3, DVec3, EPSILON};

/// An invertible affine map. The inverse is kept, never recomputed, so that a chain of `n` steps loses no more than `n` roundings.
///
/// POV-Ray writes row vectors (`P' = P*M`); its `matrix <m00,m01,m02, m10, ...>` rows are the column axes here.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transform {
    /// Maps points of the inner space to the outer one.
    pub forward: DAffine3,
    /// Maps points of the outer space to the inner one.
    pub inverse: DAffine3,
}

impl Default for Transform {
    fn default() -> Self {
        Self::IDENTITY
    }
}

impl Transform {
    /// Changes nothing.
    pub const IDENTITY: Transform = Transform { forward: DAffine3::IDENTITY, inverse: DAffine3::IDENTITY };

    /// A shift.
    pub fn translation(v: DVec3) -> Self {
        Self { forward: DAffine3::from_translation(v), inverse: DAffine3::from_translation(-v) }
    }

    /// A scale by axis; no component may be zero (the parser turns zeros into ones, with a warning).
    pub fn scaling(v: DVec3) -> Self {
        Self { forward: DAffine3::from_scale(v), inverse: DAffine3::from_scale(v.recip()) }
    }

    /// POV-Ray's `rotate <x,y,z>` in degrees: about x, then y, then z, left-handed. Source: spec/objects.md, section 14.
    pub fn rotation_deg(v: DVec3) -> Self {
        let (r, mut t) = (v * (std::f64::consts::PI / 180.0), DMat3::IDENTITY);
        let (sx, cx) = r.x.sin_cos();
        t = DMat3::from_cols(DVec3::X, DVec3::new(0.0, cx, sx), DVec3::new(0.0, -sx, cx)) * t;
        let (sy, cy) = r.y.sin_cos();
        t = DMat3::from_cols(DVec3::new(cy, 0.0, -sy), DVec3::Y, DVec3::new(sy, 0.0, cy)) * t;
        let (sz, cz) = r.z.sin_cos();
        t = DMat3::from_cols(DVec3::new(cz, sz, 0.0), DVec3::new(-sz, cz, 0.0), DVec3::Z) * t;
        Self { forward: DAffine3::from_mat3(t), inverse: DAffine3::from_mat3(t.transpose()) }
    }

    /// POV-Ray's `matrix` of 12 numbers; `None` when it cannot be inverted.
    pub fn from_rows(m: [f64; 12]) -> Option<Self> {
        let axes = DMat3::from_cols(DVec3::new(m[0], m[1], m[2]), DVec3::new(m[3], m[4], m[5]), DVec3::new(m[6], m[7], m[8]));
        Self::from_affine(DAffine3 { matrix3: axes, translation: DVec3::new(m[9], m[10], m[11]) })
    }

    /// From an affine map; `None` when it cannot be inverted.
    pub fn from_affine(forward: DAffine3) -> Option<Self> {
        let inverse = forward.inverse();
        (inverse.is_finite() && forward.is_finite()).then_some(Self { forward, inverse })
    }

    /// First this, then `next`.
    #[must_use]
    pub fn then(&self, next: &Transform) -> Self {
        Self { forward: next.forward * self.forward, inverse: self.inverse * next.inverse }
    }

    /// The opposite map.
    #[must_use]
    pub fn inverted(&self) -> Self {
        Self { forward: self.inverse, inverse: self.forward }
    }

    /// Whether it changes nothing, exactly.
    pub fn is_identity(&self) -> bool {
        self.forward == DAffine3::IDENTITY
    }

    /// A point, inner to outer.
    #[inline]
    pub fn point(&self, p: DVec3) -> DVec3 {
        self.forward.transform_point3(p)
    }

    /// A direction with its length, inner to outer.
    #[inline]
    pub fn vector(&self, v: DVec3) -> DVec3 {
        self.forward.transform_vector3(v)
    }

    /// A point, outer to inner.
    #[inline]
    pub fn inverse_point(&self, p: DVec3) -> DVec3 {
        self.inverse.transform_point3(p)
    }

    /// A direction with its length, outer to inner.
    #[inline]
    pub fn inverse_vector(&self, v: DVec3) -> DVec3 {
        self.inverse.transform_vector3(v)
    }

    /// A surface normal, inner to outer (inverse transpose); not normalised.
    #[inline]
    pub fn normal(&self, n: DVec3) -> DVec3 {
        self.inverse.matrix3.transpose() * n
    }

    /// A surface normal, outer to inner; not normalised.
    #[inline]
    pub fn inverse_normal(&self, n: DVec3) -> DVec3 {
        self.forward.matrix3.transpose() * n
    }

    /// Whether two transforms agree to [`EPSILON`] in every number.
    pub fn approx_eq(&self, other: &Transform) -> bool {
        self.forward.abs_diff_eq(other.forward, EPSILON)
    }
}
