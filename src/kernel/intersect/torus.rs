//! Torus about y. Source: spec/objects.md, sections 1 and 2; the ray is re-centred before the quartic is set up, which keeps its
//! coefficients small (Hassing).

use super::{HitSink, LocalRay, Part};
use crate::compile::shape::TorusShape;
use crate::math::roots::solve_polynomial;
use crate::math::{DVec2, DVec3, EPSILON, MAX_DISTANCE};
use std::f64::consts::{PI, TAU};

/// Hits nearer than this are not seen.
const TOLERANCE: f64 = 1e-6;
/// Roots nearer to 0 than this are divided out.
const ROOT_TOLERANCE: f64 = 1e-4;

/// Up to four crossings.
pub fn intersect_torus(s: &TorusShape, ray: &LocalRay, sink: &mut impl HitSink) {
    let (r1, r2) = (s.major * s.major, s.minor * s.minor);
    // Start at the sphere around the torus when it lies ahead.
    let reach = s.major + 2.0 * s.minor;
    let (mut origin, mut skipped) = (ray.origin, 0.0);
    let along = origin.dot(ray.dir);
    let apart_sq = origin.length_squared() - along * along;
    if origin.length_squared() > reach * reach {
        let half_sq = reach * reach - apart_sq;
        if half_sq < 0.0 {
            return;
        }
        skipped = -along - half_sq.sqrt();
        if skipped < 0.0 {
            return;
        }
        origin += skipped * ray.dir;
    }
    let d = ray.dir;
    // From nearby: far away the differences of squares in it would turn rays off that graze.
    if misses_thick_cylinder(s, origin, d) {
        return;
    }
    let py2 = origin.y * origin.y;
    let dy2 = d.y * d.y;
    let pdy2 = origin.y * d.y;
    let k1 = origin.length_squared() - r1 - r2;
    let k2 = origin.dot(d);
    let c = [1.0, 4.0 * k2, 2.0 * (k1 + 2.0 * (k2 * k2 + r1 * dy2)), 4.0 * (k2 * k1 + 2.0 * r1 * pdy2), k1 * k1 + 4.0 * r1 * (py2 - r2)];
    for t in solve_polynomial(&c, s.sturm, ROOT_TOLERANCE).iter() {
        let t = polished(&c, *t) + skipped;
        if t > TOLERANCE && t < MAX_DISTANCE {
            sink.push(t, Part::default());
        }
    }
}

/// A root after a step of Newton's method, if that brings the quartic nearer to 0: closed forms lose digits where roots are close.
fn polished(c: &[f64; 5], t: f64) -> f64 {
    let value = |t: f64| c.iter().fold((0.0, 0.0), |(v, slope), a| (v * t + a, slope * t + v));
    let (v, slope) = value(t);
    let next = t - v / slope;
    if value(next).0.abs() < v.abs() { next } else { t }
}

/// Whether a ray misses the ring of height ±minor between the torus' inner and outer radius.
fn misses_thick_cylinder(s: &TorusShape, o: DVec3, d: DVec3) -> bool {
    let outer_sq = (s.major + s.minor).powi(2);
    let inner = (s.major - s.minor).max(0.0);
    let inner_sq = inner * inner;
    let at = |t: f64| {
        let (x, z) = (o.x + t * d.x, o.z + t * d.z);
        x * x + z * z
    };
    if d.y.abs() < EPSILON {
        if o.y.abs() > s.minor {
            return true;
        }
    } else {
        for y in [s.minor, -s.minor] {
            let t = (y - o.y) / d.y;
            if t > 0.0 && (inner_sq..=outer_sq).contains(&at(t)) {
                return false;
            }
        }
    }
    let a = d.x * d.x + d.z * d.z;
    if a <= EPSILON {
        return true;
    }
    let b = o.x * d.x + o.z * d.z;
    let crosses = |r_sq: f64| {
        let c = o.x * o.x + o.z * o.z - r_sq;
        let disc = b * b - a * c;
        disc >= 0.0 && {
            let root = disc.sqrt();
            [(-b + root) / a, (-b - root) / a].iter().any(|t| *t > 0.0 && (o.y + t * d.y).abs() <= s.minor)
        }
    };
    !(crosses(outer_sq) || inner_sq > 0.0 && crosses(inner_sq))
}

/// The surface belongs to the torus.
pub fn inside_torus(s: &TorusShape, p: DVec3) -> bool {
    let r = (p.x * p.x + p.z * p.z).sqrt() - s.major;
    p.y * p.y + r * r <= s.minor * s.minor
}

/// Not unit.
pub fn torus_normal(s: &TorusShape, p: DVec3) -> DVec3 {
    let dist = (p.x * p.x + p.z * p.z).sqrt();
    let ring = if dist > EPSILON { DVec3::new(s.major * p.x / dist, 0.0, s.major * p.z / dist) } else { DVec3::ZERO };
    p - ring
}

/// u around the axis, v around the tube.
pub fn torus_uv(s: &TorusShape, p: DVec3) -> DVec2 {
    let r = (p.x * p.x + p.z * p.z).sqrt();
    DVec2::new(1.0 - (p.z.atan2(p.x) + PI) / TAU, (p.y.atan2(r - s.major) + PI) / TAU)
}
