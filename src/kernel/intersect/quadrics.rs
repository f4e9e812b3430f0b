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

#[inline]
fn push_caps(low: f64, low_radius: f64, ray: &LocalRay, sink: &mut impl HitSink) {
    if ray.dir.z.abs() <= EPSILON {
        return;
    }
    for (z, r, face) in [(1.0, 1.0, 2), (low, low_radius, 1)] {
        let t = (z - ray.origin.z) / ray.dir.z;
        let (x, y) = (ray.origin.x + t * ray.dir.x, ray.origin.y + t * ray.dir.y);
        if x * x + y * y <= r * r {
            push(t, face, sink);
        }
    }
}

/// Side and, unless open, end discs.
#[inline]
pub fn intersect_cylinder(s: &CylinderShape, ray: &LocalRay, sink: &mut impl HitSink) {
    let (o, d) = (ray.origin, ray.dir);
    let a = d.x * d.x + d.y * d.y;
    if a > EPSILON {
        let b = o.x * d.x + o.y * d.y;
        let c = o.x * o.x + o.y * o.y - 1.0;
        let disc = b * b - a * c;
        if disc >= 0.0 {
            let root = disc.sqrt();
            for t in [(-b - root) / a, (-b + root) / a] {
                let z = o.z + t * d.z;
                if (0.0..=1.0).contains(&z) {
                    push(t, 0, sink);
                }
            }
        }
    }
    if !s.open {
        push_caps(0.0, 1.0, ray, sink);
    }
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
    let mut side = |t: f64| {
        let z = o.z + t * d.z;
        if (s.low..=1.0).contains(&z) {
            push(t, 0, sink);
        }
    };
    if a.abs() < EPSILON {
        // One crossing: the ray runs along the cone's slope.
        if b.abs() > EPSILON {
            side(-0.5 * c / b);
        }
    } else {
        let disc = b * b - a * c;
        if disc >= 0.0 {
            let root = disc.sqrt();
            side((-b - root) / a);
            side((-b + root) / a);
        }
    }
    if !s.open {
        push_caps(s.low, s.low, ray, sink);
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
