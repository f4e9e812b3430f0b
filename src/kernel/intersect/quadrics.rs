//! Cylinder and cone about z in their canonical frames. Source: spec/objects.md, section 2.
//!
//! Faces: 0 side, 1 the disc at low z, 2 the disc at z = 1.

use super::{HitSink, LocalRay, Part};
use crate::compile::shape::{ConeShape, CylinderShape};
use crate::math::{DVec3, EPSILON, MAX_DISTANCE};

/// Hits nearer than this are not seen.
const TOLERANCE: f64 = 1e-9;

#[inline]
fn push(t: f64, face: u32, sink: &mut impl HitSink) {
    if t > TOLERANCE && t < MAX_DISTANCE {
        sink.push(t, Part::side(face));
    }
}

/// A stretch of a ray, and the faces that it begins and ends on.
#[derive(Clone, Copy)]
struct Stretch {
    from: (f64, u32),
    to: (f64, u32),
}

impl Stretch {
    /// Between the discs at z = `low` and z = 1; the whole ray or nothing where it runs along them.
    fn between_discs(low: f64, ray: &LocalRay) -> Option<Self> {
        let (o, d) = (ray.origin.z, ray.dir.z);
        if d.abs() <= EPSILON {
            let all = Self { from: (f64::NEG_INFINITY, 1), to: (f64::INFINITY, 2) };
            return (low..=1.0).contains(&o).then_some(all);
        }
        let (a, b) = (((low - o) / d, 1), ((1.0 - o) / d, 2));
        Some(if d > 0.0 { Self { from: a, to: b } } else { Self { from: b, to: a } })
    }

    /// Pushes where the part of this stretch within `from..=to` of the side begins and ends. A solid is left as often as it is entered:
    /// side and discs are not asked one by one, or at the rim both or neither might say yes.
    fn push_within(&self, from: f64, to: f64, open: bool, sink: &mut impl HitSink) {
        let enter = if from >= self.from.0 { (from, 0) } else { self.from };
        let leave = if to <= self.to.0 { (to, 0) } else { self.to };
        if enter.0 <= leave.0 {
            for (t, face) in [enter, leave] {
                // The ends of an open one are no faces.
                if face == 0 || !open {
                    push(t, face, sink);
                }
            }
        }
    }
}

/// Side and, unless open, end discs.
#[inline]
pub fn intersect_cylinder(s: &CylinderShape, ray: &LocalRay, sink: &mut impl HitSink) {
    let Some(stretch) = Stretch::between_discs(0.0, ray) else { return };
    let (o, d) = (ray.origin, ray.dir);
    let a = d.x * d.x + d.y * d.y;
    let c = o.x * o.x + o.y * o.y - 1.0;
    if a > EPSILON {
        let b = o.x * d.x + o.y * d.y;
        let disc = b * b - a * c;
        if disc >= 0.0 {
            let root = disc.sqrt();
            stretch.push_within((-b - root) / a, (-b + root) / a, s.open, sink);
        }
    } else if c <= 0.0 {
        stretch.push_within(f64::NEG_INFINITY, f64::INFINITY, s.open, sink);
    }
}

/// Whether a ray of any length misses the side of a cylinder or a cone, and so its ends, beyond any rounding: most that meet their boxes do, and need no
/// root and no quotients.
#[inline(always)]
pub fn surely_missed(is_cone: bool, o: DVec3, d: DVec3) -> bool {
    let z = if is_cone { DVec3::new(d.z * d.z, o.z * d.z, o.z * o.z) } else { DVec3::new(0.0, 0.0, 1.0) };
    let a = d.x * d.x + d.y * d.y - z.x;
    let b = o.x * d.x + o.y * d.y - z.y;
    let c = o.x * o.x + o.y * o.y - z.z;
    let (b_sq, ac) = (b * b, a * c);
    // Steep rays are left to the test: they may run inside the side, or along the cone's slope.
    a > 1e-3 * d.length_squared() && b_sq - ac < -1e-9 * (b_sq + ac.abs())
}

/// Closed: points on the surface are outside. Open: they are inside.
#[inline]
pub fn inside_cylinder(s: &CylinderShape, p: DVec3) -> bool {
    let slack = if s.open { EPSILON } else { -EPSILON };
    p.x * p.x + p.y * p.y < 1.0 + slack && p.z > -slack && p.z < 1.0 + slack
}

/// Not unit.
#[inline]
pub fn cylinder_normal(p: DVec3, face: u32) -> DVec3 {
    match face {
        0 => DVec3::new(p.x, p.y, 0.0),
        1 => -DVec3::Z,
        _ => DVec3::Z,
    }
}

/// Side and, unless open, end discs.
#[inline]
pub fn intersect_cone(s: &ConeShape, ray: &LocalRay, sink: &mut impl HitSink) {
    let (o, d) = (ray.origin, ray.dir);
    let a = d.x * d.x + d.y * d.y - d.z * d.z;
    let b = d.x * o.x + d.y * o.y - d.z * o.z;
    let c = o.x * o.x + o.y * o.y - o.z * o.z;
    let Some(stretch) = Stretch::between_discs(s.low, ray) else { return };
    let mut within = |from: f64, to: f64| stretch.push_within(from, to, s.open, sink);
    if a.abs() < EPSILON {
        // One crossing: the ray runs along the cone's slope, inside on one side of it.
        if b.abs() > EPSILON {
            let t = -0.5 * c / b;
            if b > 0.0 { within(f64::NEG_INFINITY, t) } else { within(t, f64::INFINITY) }
        } else if c <= 0.0 {
            within(f64::NEG_INFINITY, f64::INFINITY);
        }
        return;
    }
    let disc = b * b - a * c;
    if disc >= 0.0 {
        let root = disc.sqrt();
        let (t0, t1) = ((-b - root) / a, (-b + root) / a);
        if a > 0.0 {
            within(t0, t1);
        } else {
            // Steeper than the slope: inside the cone below the one root, inside its mirror image above the other, or the reverse.
            within(f64::NEG_INFINITY, t1);
            within(t0, f64::INFINITY);
        }
    } else if a < 0.0 {
        within(f64::NEG_INFINITY, f64::INFINITY);
    }
}

/// Closed: points on the surface are outside. Open: they are inside.
#[inline]
pub fn inside_cone(s: &ConeShape, p: DVec3) -> bool {
    let slack = if s.open { EPSILON } else { -EPSILON };
    let (w_sq, z_sq) = (p.x * p.x + p.y * p.y, p.z * p.z);
    w_sq < z_sq + slack && p.z > s.low - slack && p.z < 1.0 + slack
}

/// Not unit.
#[inline]
pub fn cone_normal(p: DVec3, face: u32) -> DVec3 {
    match face {
        0 => DVec3::new(p.x, p.y, -p.z),
        1 => -DVec3::Z,
        _ => DVec3::Z,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::SplitMix64;

    struct Any(bool);

    impl HitSink for Any {
        fn push(&mut self, _: f64, _: Part) {
            self.0 = true;
        }
        fn far(&self) -> f64 {
            f64::INFINITY
        }
    }

    #[test]
    fn what_is_surely_missed_has_no_hits_and_most_misses_are_sure() {
        let mut numbers = SplitMix64(4);
        for is_cone in [false, true] {
            let (mut n_sure, mut n_missed) = (0, 0);
            for k in 0..40_000 {
                let far = if k % 4 == 0 { 1e4 } else { 3.0 };
                let (o, d) = (numbers.cube() * far, numbers.direction() * (0.1 + 5.0 * numbers.unit()));
                // Towards the shape, half of them near its outline.
                let d = if k % 2 == 0 { d } else { (DVec3::new(1.0, 0.0, 0.5) + 0.2 * numbers.cube() - o) * 0.3 };
                let len = d.length();
                let (ray, mut any) = (LocalRay { origin: o, dir: d / len, scale: len }, Any(false));
                if is_cone {
                    intersect_cone(&ConeShape { low: 0.2, open: k % 3 == 0 }, &ray, &mut any);
                } else {
                    intersect_cylinder(&CylinderShape { open: k % 3 == 0 }, &ray, &mut any);
                }
                let sure = surely_missed(is_cone, o, d);
                assert!(!(sure && any.0), "cone {is_cone}: {o} along {d}");
                (n_sure, n_missed) = (n_sure + u32::from(sure), n_missed + u32::from(!any.0));
            }
            assert!(n_sure > n_missed / 4, "cone {is_cone}: {n_sure} of {n_missed}");
        }
    }
}
