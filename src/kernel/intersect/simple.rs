//! Sphere, box, plane and disc. Source: spec/objects.md, section 2.

use super::{HitSink, LocalRay, Part};
use crate::compile::shape::{BoxShape, DiscShape, PlaneShape, SphereShape};
use crate::math::{DVec2, DVec3, EPSILON, MAX_DISTANCE};

/// Hits nearer than this are not seen.
const TOLERANCE: f64 = 1e-6;

/// Square of the distance, in radii, from which on a sphere is far away.
const FAR_SQ: f64 = 1024.0;

/// Both crossings of a sphere; grazing rays miss.
#[inline]
pub fn intersect_sphere(s: &SphereShape, ray: &LocalRay, sink: &mut impl HitSink) {
    let to_center = s.center - ray.origin;
    let oc_sq = to_center.length_squared();
    let closest = to_center.dot(ray.dir);
    let r_sq = s.radius * s.radius;
    if oc_sq >= r_sq && closest < EPSILON {
        return;
    }
    let half_sq = if oc_sq > FAR_SQ * r_sq {
        // From the way that the ray passes by: the difference of squared distances loses what matters. Source: Haines, Günther and
        // Akenine-Möller 2019.
        r_sq - (to_center - closest * ray.dir).length_squared()
    } else {
        // POV-Ray's sum, rounding and all: media and streams of random numbers depend on it.
        r_sq - oc_sq + closest * closest
    };
    if half_sq > EPSILON {
        let half = half_sq.sqrt();
        for t in [closest - half, closest + half] {
            if t > TOLERANCE && t < MAX_DISTANCE {
                sink.push(t, Part::default());
            }
        }
    }
}

/// Points on the surface are outside, of an inverted sphere too.
#[inline]
pub fn inside_sphere(s: &SphereShape, p: DVec3, inverted: bool) -> bool {
    let (d, r) = ((p - s.center).length_squared(), s.radius * s.radius);
    if inverted { d > r } else { d < r }
}

/// Slabs; faces are numbered -x +x -y +y -z +z. Where two slabs meet, the one that the ray is steeper to wins.
#[inline]
pub fn intersect_box(b: &BoxShape, ray: &LocalRay, sink: &mut impl HitSink) {
    let (low, high) = ((b.min - ray.origin) / ray.dir, (b.max - ray.origin) / ray.dir);
    if ray.dir.abs().min_element() >= EPSILON {
        // Most misses need no sides: the tolerances below move each end by one of them at most.
        let (enter, leave) = (low.min(high).max_element().max(0.0), low.max(high).min_element());
        if enter > leave + 3.0 * TOLERANCE {
            return;
        }
    }
    let (mut near, mut far) = (0.0f64, f64::MAX);
    let (mut near_side, mut far_side) = (u32::MAX, u32::MAX);
    for axis in 0..3 {
        let (o, d) = (ray.origin[axis], ray.dir[axis]);
        if d.abs() < EPSILON {
            if o < b.min[axis] || o > b.max[axis] {
                return;
            }
            continue;
        }
        let (t_low, t_high) = (low[axis], high[axis]);
        let low_side = 2 * axis as u32;
        let (t0, s0, t1, s1) = if d > 0.0 { (t_low, low_side, t_high, low_side + 1) } else { (t_high, low_side + 1, t_low, low_side) };
        // Of two entries closer than the tolerance, a steeper axis replaces the earlier one.
        let steeper = |other: u32| other == u32::MAX || d.abs() > ray.dir[other as usize / 2].abs();
        if t1 < far - TOLERANCE || (t1 < far + TOLERANCE && steeper(far_side)) {
            if t1 < TOLERANCE {
                return;
            }
            far = t1;
            far_side = s1;
        }
        if t0 > near + TOLERANCE || (t0 > near - TOLERANCE && near_side != u32::MAX && steeper(near_side)) {
            near = t0;
            near_side = s0;
        }
        if near > far {
            return;
        }
    }
    if far > MAX_DISTANCE && near > MAX_DISTANCE {
        return;
    }
    if near > TOLERANCE && near_side != u32::MAX {
        sink.push(near, Part::side(near_side));
    }
    if far > TOLERANCE && far < MAX_DISTANCE && far_side != u32::MAX {
        sink.push(far, Part::side(far_side));
    }
}

/// All faces belong to the box.
#[inline]
pub fn inside_box(b: &BoxShape, p: DVec3) -> bool {
    p.cmpge(b.min).all() && p.cmple(b.max).all()
}

/// Outward normal of a face.
#[inline]
pub fn box_normal(face: u32) -> DVec3 {
    let sign = if face & 1 == 0 { -1.0 } else { 1.0 };
    let mut n = DVec3::ZERO;
    n[(face / 2).min(2) as usize] = sign;
    n
}

/// The unfolded cross, 4 x 3 squares.
pub fn box_uv(b: &BoxShape, p: DVec3, face: u32) -> DVec2 {
    let q = (p - b.min) / (b.max - b.min);
    const T: f64 = 1.0 / 3.0;
    match face {
        0 => DVec2::new(0.25 * q.z, T + T * q.y),
        1 => DVec2::new(0.75 - 0.25 * q.z, T + T * q.y),
        2 => DVec2::new(0.25 + 0.25 * q.x, T * q.z),
        3 => DVec2::new(0.25 + 0.25 * q.x, 1.0 - T * q.z),
        4 => DVec2::new(1.0 - 0.25 * q.x, T + T * q.y),
        _ => DVec2::new(0.25 + 0.25 * q.x, T + T * q.y),
    }
}

/// The one crossing of a plane.
#[inline]
pub fn intersect_plane(s: &PlaneShape, ray: &LocalRay, sink: &mut impl HitSink) {
    let slope = s.normal.dot(ray.dir);
    if slope.abs() < EPSILON {
        return;
    }
    let t = (s.distance - s.normal.dot(ray.origin)) / slope;
    if (TOLERANCE..=MAX_DISTANCE).contains(&t) {
        sink.push(t, Part::default());
    }
}

/// The plane itself belongs to the side that its normal points away from, and when inverted to the other.
#[inline]
pub fn inside_plane(s: &PlaneShape, p: DVec3, inverted: bool) -> bool {
    let d = s.normal.dot(p) - s.distance;
    (if inverted { -d } else { d }) < EPSILON
}

/// The one crossing of a disc in z = 0.
#[inline]
pub fn intersect_disc(s: &DiscShape, ray: &LocalRay, sink: &mut impl HitSink) {
    if ray.dir.z.abs() < EPSILON {
        return;
    }
    let t = -ray.origin.z / ray.dir.z;
    if t > TOLERANCE && t < MAX_DISTANCE {
        let r_sq = (ray.origin.x + t * ray.dir.x).powi(2) + (ray.origin.y + t * ray.dir.y).powi(2);
        if r_sq >= s.hole_sq && r_sq <= s.radius_sq {
            sink.push(t, Part::default());
        }
    }
}
