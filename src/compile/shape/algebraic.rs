//! Quadrics, polynomial surfaces, superellipsoids. Source: spec/objects.md, sections 2 and 3.

use crate::math::{Bounds, DMat3, DVec3};

/// A x² + B y² + C z² + D xy + E xz + F yz + G x + H y + I z + J = 0, in this order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QuadricShape {
    /// A to J.
    pub c: [f64; 10],
}

impl QuadricShape {
    /// Box around the surface and its inside in shape space; unbounded where there is none.
    pub fn bounds(&self) -> Bounds {
        let [a, b, c, d, e, f, g, h, i, j] = self.c;
        let q = DMat3::from_cols(DVec3::new(a, d / 2.0, e / 2.0), DVec3::new(d / 2.0, b, f / 2.0), DVec3::new(e / 2.0, f / 2.0, c));
        let minor = a * b - d * d / 4.0;
        let mut out = Bounds::UNBOUNDED;
        if a > 0.0 && minor > 0.0 && q.determinant() > 1e-12 {
            // An ellipsoid: p = center + y with yᵀ Q y = k.
            let inverse = q.inverse();
            let lin = DVec3::new(g, h, i) / 2.0;
            let center = -(inverse * lin);
            let k = lin.dot(inverse * lin) - j;
            if k < 0.0 {
                return Bounds::EMPTY;
            }
            let r = DVec3::new(inverse.x_axis.x, inverse.y_axis.y, inverse.z_axis.z).max(DVec3::ZERO) * k;
            let r = DVec3::new(r.x.sqrt(), r.y.sqrt(), r.z.sqrt());
            out = Bounds { min: center - r, max: center + r };
        } else if a >= 0.0 && b >= 0.0 && c >= 0.0 && d == 0.0 && e == 0.0 && f == 0.0 {
            // Cylinders and the like: bounded along the axes that have a square, if the others are not there at all.
            let (sq, lin) = ([a, b, c], [g, h, i]);
            if (0..3).all(|k| sq[k] > 0.0 || lin[k] == 0.0) {
                let room: f64 = (0..3).filter(|k| sq[*k] > 0.0).map(|k| lin[k] * lin[k] / (4.0 * sq[k])).sum::<f64>() - j;
                if room < 0.0 {
                    return Bounds::EMPTY;
                }
                for k in 0..3 {
                    if sq[k] > 0.0 {
                        let (m, r) = (-lin[k] / (2.0 * sq[k]), (room / sq[k]).sqrt());
                        (out.min[k], out.max[k]) = (m - r, m + r);
                    }
                }
            }
        }
        out
    }
}

/// One term of a polynomial.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PolyTerm {
    /// Not 0.
    pub factor: f64,
    /// Powers of x, y, z.
    pub powers: [u8; 3],
}

/// A polynomial surface.
#[derive(Clone, Debug, PartialEq)]
pub struct PolyShape {
    /// 2..=35.
    pub order: u32,
    /// Terms with a factor, in POV-Ray's order (x, then y, then z falling).
    pub terms: Vec<PolyTerm>,
    /// All coefficients in the same order, zeros among them, for Horner's scheme.
    pub coefficients: Vec<f64>,
    /// Roots by Sturm chains.
    pub sturm: bool,
}

impl PolyShape {
    /// From all coefficients in POV-Ray's order; `None` when their number does not fit the order.
    pub fn new(order: u32, coefficients: &[f64], sturm: bool) -> Option<Self> {
        if !(1..=crate::math::roots::MAX_ORDER as u32).contains(&order) {
            return None;
        }
        let n = order as u8;
        let mut terms = Vec::new();
        let mut list = coefficients.iter();
        for x in (0..=n).rev() {
            for y in (0..=n - x).rev() {
                for z in (0..=n - x - y).rev() {
                    let factor = *list.next()?;
                    if factor != 0.0 {
                        terms.push(PolyTerm { factor, powers: [x, y, z] });
                    }
                }
            }
        }
        list.next().is_none().then_some(Self { order, terms, coefficients: coefficients.to_vec(), sturm })
    }
}

/// (|x|^(2/e) + |y|^(2/e))^(e/n) + |z|^(2/n) = 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SuperellipsoidShape {
    /// 2 / e.
    pub xy_power: f64,
    /// 2 / n.
    pub z_power: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quadric_boxes_are_tight() {
        // (x-1)² + 4 y² + z² = 4
        let q = QuadricShape { c: [1.0, 4.0, 1.0, 0.0, 0.0, 0.0, -2.0, 0.0, 0.0, 1.0 - 4.0] };
        let b = q.bounds();
        assert!((b.min - DVec3::new(-1.0, -1.0, -2.0)).length() < 1e-12 && (b.max - DVec3::new(3.0, 1.0, 2.0)).length() < 1e-12);
        let cylinder = QuadricShape { c: [1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -4.0] };
        let b = cylinder.bounds();
        assert!((b.max.x - 2.0).abs() < 1e-12 && b.max.y > 1e9);
        let cone = QuadricShape { c: [1.0, -1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0] };
        assert!(cone.bounds().is_unbounded());
    }

    #[test]
    fn poly_terms_follow_pov_rays_order() {
        let mut c = vec![0.0; 20];
        c[4] = 7.0;
        let p = PolyShape::new(3, &c, false).expect("twenty coefficients");
        assert_eq!(p.terms, [PolyTerm { factor: 7.0, powers: [1, 2, 0] }]);
        assert!(PolyShape::new(3, &c[1..], false).is_none());
    }
}
