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

    /// Box around the surface and its inside in shape space; unbounded where none is found.
    pub fn bounds(&self) -> Bounds {
        if self.terms.len() > MOST_TERMS_BOUNDED {
            return Bounds::UNBOUNDED;
        }
        let Some(reach) = self.reach() else { return Bounds::UNBOUNDED };
        let mut b = Bounds { min: DVec3::splat(-reach), max: DVec3::splat(reach) };
        // Slices that hold nothing come off, side by side: those where interval arithmetic finds no value near 0. What the first round
        // takes off makes the slices of the second smaller.
        for axis in [0, 1, 2, 0, 1, 2] {
            for side in [false, true] {
                let step = (b.max[axis] - b.min[axis]) / f64::from(SLICES);
                for _ in 0..SLICES {
                    let mut slice = b;
                    if side {
                        slice.min[axis] = b.max[axis] - step
                    } else {
                        slice.max[axis] = b.min[axis] + step
                    }
                    if self.may_touch(&slice, axis, DEEPEST_CUT) {
                        break;
                    }
                    if side { b.max[axis] -= step } else { b.min[axis] += step }
                }
            }
        }
        b
    }

    /// A radius outside which the polynomial is positive: its highest terms outweigh the others there.
    fn reach(&self) -> Option<f64> {
        let n = self.order;
        if n % 2 == 1 {
            return None;
        }
        let pure = |k: usize| self.terms.iter().find(|t| u32::from(t.powers[k]) == n).map_or(0.0, |t| t.factor);
        let least = pure(0).min(pure(1)).min(pure(2));
        // On the unit sphere the sum of n-th powers is least where all are equal.
        let mut lead = least * 3f64.powf(1.0 - 0.5 * f64::from(n));
        let mut below = [0.0; crate::math::roots::MAX_ORDER + 1];
        for t in &self.terms {
            if t.factor > 0.0 && t.powers.iter().all(|p| p.is_multiple_of(2)) {
                continue;
            }
            let degree: u8 = t.powers.iter().sum();
            // The largest value of the monomial on the unit sphere.
            let power = |p: u8| if p == 0 { 1.0 } else { (f64::from(p) / f64::from(degree)).powf(0.5 * f64::from(p)) };
            let most = t.factor.abs() * t.powers.iter().map(|p| power(*p)).product::<f64>();
            if u32::from(degree) == n { lead -= most } else { below[usize::from(degree)] += most }
        }
        if !(lead > 1e-12) {
            return None;
        }
        // One change of sign, so once positive it stays so.
        let at = |r: f64| lead * r.powi(n as i32) - below.iter().rev().fold(0.0, |v, c| v * r + c);
        let mut r = 1e-3;
        while !(at(r) > INSIDE_MARGIN) {
            r *= 1.25;
            if r > 1e6 {
                return None;
            }
        }
        Some(r)
    }

    /// Whether the polynomial may be at or below 0 somewhere in a slice across `axis`, which is cut in quarters up to `depth` times.
    fn may_touch(&self, slice: &Bounds, axis: usize, depth: u32) -> bool {
        if self.least_in(slice) > INSIDE_MARGIN {
            return false;
        }
        if depth == 0 {
            return true;
        }
        let (u, v, middle) = ((axis + 1) % 3, (axis + 2) % 3, slice.center());
        (0..4).any(|k| {
            let mut part = *slice;
            if k & 1 == 0 {
                part.max[u] = middle[u]
            } else {
                part.min[u] = middle[u]
            }
            if k & 2 == 0 {
                part.max[v] = middle[v]
            } else {
                part.min[v] = middle[v]
            }
            self.may_touch(&part, axis, depth - 1)
        })
    }

    /// A number that no value in a box is below.
    fn least_in(&self, b: &Bounds) -> f64 {
        self.terms
            .iter()
            .map(|t| {
                let (mut low, mut high) = (t.factor, t.factor);
                for k in 0..3 {
                    let (l, h) = power_range(b.min[k], b.max[k], t.powers[k]);
                    let ends = [low * l, low * h, high * l, high * h];
                    (low, high) = ends.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, z), v| (a.min(*v), z.max(*v)));
                }
                low
            })
            .sum()
    }
}

/// Polynomials with more terms are not bounded: it would take too long.
const MOST_TERMS_BOUNDED: usize = 40;
/// Slices that a box is cut from, for each side.
const SLICES: u32 = 48;
/// Halvings of a slice across its axis: what a piece of this size leaves open is taken as touched.
const DEEPEST_CUT: u32 = 6;
/// Above the 1e-4 below which points count as inside, with room for rounding.
const INSIDE_MARGIN: f64 = 1e-3;

/// Least and largest power of the numbers in an interval.
fn power_range(low: f64, high: f64, power: u8) -> (f64, f64) {
    let (a, b) = (low.powi(i32::from(power)), high.powi(i32::from(power)));
    if power == 0 {
        (1.0, 1.0)
    } else if power.is_multiple_of(2) && low < 0.0 && high > 0.0 {
        (0.0, a.max(b))
    } else {
        (a.min(b), a.max(b))
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
    fn polynomials_that_end_are_bounded_and_others_are_not() {
        // A torus about y with radii 9 and 2: (x²+y²+z² + 81 - 4)² = 324 (x²+z²), moved to no place.
        let mut c = [0.0; 35];
        for (k, v) in [(0, 1.0), (4, 2.0), (7, 2.0), (20, 1.0), (23, 2.0), (30, 1.0)] {
            c[k] = v;
        }
        for (k, v) in [(9, 2.0 * 77.0 - 324.0), (25, 2.0 * 77.0), (32, 2.0 * 77.0 - 324.0), (34, 77.0 * 77.0)] {
            c[k] = v;
        }
        let b = PolyShape::new(4, &c, true).expect("a quartic").bounds();
        assert!(b.max.x >= 11.0 && b.max.x < 13.5 && b.min.z <= -11.0 && b.min.z > -13.5, "{b:?}");
        assert!(b.max.y >= 2.0 && b.max.y < 5.0, "{b:?}");
        // Without y⁴ it has no end.
        c[20] = 0.0;
        assert!(PolyShape::new(4, &c, true).expect("a quartic").bounds().is_unbounded());
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
