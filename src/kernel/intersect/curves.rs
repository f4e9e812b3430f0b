//! Lathe, sor, prism, polygon and glyph. Source: spec/objects.md, sections 5, 6 and 8.

use super::{HitSink, LocalRay, Part, turns_about_y};
use crate::compile::shape::curve::{CurveSegment, inside_loops};
use crate::compile::shape::swept::{GlyphShape, LatheShape, PolygonShape, PrismShape, SorShape};
use crate::math::bernstein::roots_in_unit;
use crate::math::roots::solve_polynomial;
use crate::math::{DVec2, DVec3, EPSILON, MAX_DISTANCE};

/// Hits of lathes, sors and prisms nearer than this are not seen.
const ROOT_DEPTH: f64 = 1e-4;
/// `Part::face` of the face at the lower end (prism base, sor base, glyph front).
const BASE: u32 = u32::MAX - 1;
/// `Part::face` of the face at the upper end.
const CAP: u32 = u32::MAX;

/// Interval of a ray inside a slab of y; empty when it misses.
#[inline]
fn slab(o: f64, d: f64, low: f64, high: f64) -> (f64, f64) {
    if d.abs() < EPSILON {
        return if o < low || o > high { (1.0, 0.0) } else { (0.0, f64::INFINITY) };
    }
    let (a, b) = ((low - o) / d, (high - o) / d);
    (a.min(b).max(0.0), a.max(b))
}

/// Whether a ray meets the cylinder of `radius` about y between two heights.
#[inline]
fn meets_cylinder(ray: &LocalRay, radius: f64, low: f64, high: f64) -> bool {
    let (o, d) = (ray.origin, ray.dir);
    let (t0, t1) = slab(o.y, d.y, low, high);
    if t0 > t1 {
        return false;
    }
    let a = d.x * d.x + d.z * d.z;
    let c = o.x * o.x + o.z * o.z - radius * radius;
    if a < EPSILON * EPSILON {
        return c <= 0.0;
    }
    let b = o.x * d.x + o.z * d.z;
    let disc = b * b - a * c;
    disc >= 0.0 && {
        let root = disc.sqrt();
        (-b - root) / a <= t1 && (-b + root) / a >= t0
    }
}

/// Solves for the curve parameter, where the ray is on the turned curve. `Part`: segment, parameter.
pub fn intersect_lathe(s: &LatheShape, ray: &LocalRay, sink: &mut impl HitSink) {
    let slack = 1e-7 * (1.0 + s.radius);
    if !meets_cylinder(ray, s.radius + slack, s.low - slack, s.high + slack) {
        return;
    }
    let (o, d) = (ray.origin, ray.dir);
    for (k, seg) in s.segments.iter().enumerate() {
        let reach = seg.max.x.max(-seg.min.x) + slack;
        if s.segments.len() > 1 && !meets_cylinder(ray, reach, seg.min.y - slack, seg.max.y + slack) {
            continue;
        }
        let mut push = |t: f64, w: f64| {
            if t > ROOT_DEPTH && t < MAX_DISTANCE {
                sink.push(t, Part { face: k as u32, a: w, b: 0.0 });
            }
        };
        if d.y.abs() > EPSILON {
            // With t = (y(w) - o.y) / d.y: r(w)² d.y² = |(o d.y + (y(w) - o.y) d).xz|².
            let (kx, kz) = (o.x * d.y - o.y * d.x, o.z * d.y - o.y * d.z);
            let dd = d.x * d.x + d.z * d.z;
            let (k1, k0) = (2.0 * (kx * d.x + kz * d.z), kx * kx + kz * kz);
            let n = seg.degree as usize;
            let c = &seg.c[3 - n..];
            let mut poly = [0.0; 7];
            for (i, a) in c.iter().enumerate() {
                for (j, b) in c.iter().enumerate() {
                    poly[i + j] += a.x * b.x * d.y * d.y - a.y * b.y * dd;
                }
                poly[n + i] -= k1 * a.y;
            }
            poly[2 * n] -= k0;
            for w in roots_in_unit(&poly[..=2 * n]).iter() {
                push((seg.at(*w).y - o.y) / d.y, *w);
            }
        } else {
            let a = d.x * d.x + d.z * d.z;
            let b = o.x * d.x + o.z * d.z;
            seg.for_roots(DVec2::Y, -o.y, |w| {
                let r = seg.at(w).x;
                let disc = b * b - a * (o.x * o.x + o.z * o.z - r * r);
                if disc > 0.0 {
                    let root = disc.sqrt();
                    push((-b - root) / a, w);
                    push((-b + root) / a, w);
                }
            });
        }
    }
}

/// Parity of the curve's crossings beyond the point's radius; nearer to the axis than the whole curve is outside (POV-Ray's slip).
pub fn inside_lathe(s: &LatheShape, p: DVec3) -> bool {
    if p.y < s.low || p.y > s.high {
        return false;
    }
    let r = (p.x * p.x + p.z * p.z).sqrt();
    if r > s.radius || r < s.inner_radius {
        return false;
    }
    let mut inside = false;
    for seg in &s.segments {
        if p.y >= seg.min.y && p.y <= seg.max.y {
            seg.for_roots(DVec2::Y, -p.y, |w| inside ^= seg.at(w).x >= r);
        }
    }
    inside
}

/// Outward when the curve runs upward.
pub fn lathe_normal(s: &LatheShape, p: DVec3, part: &Part) -> DVec3 {
    let slope = s.segments[part.face as usize].slope(part.a);
    let r = (p.x * p.x + p.z * p.z).sqrt();
    DVec3::new(slope.y * p.x, -slope.x * r, slope.y * p.z)
}

/// u around the axis, v along the curve.
pub fn lathe_uv(s: &LatheShape, p: DVec3, part: &Part) -> DVec2 {
    DVec2::new(turns_about_y(p.x, p.z), ((part.a + f64::from(part.face)) / s.segments.len() as f64).min(1.0))
}

/// Cubics in t, one a segment, and end discs.
pub fn intersect_sor(s: &SorShape, ray: &LocalRay, sink: &mut impl HitSink) {
    let (o, d) = (ray.origin, ray.dir);
    let (low, high) = s.heights();
    let slack = 1e-7 * (1.0 + s.radius);
    if !meets_cylinder(ray, s.radius + slack, low - slack, high + slack) {
        return;
    }
    let push = |t: f64, face: u32, sink: &mut dyn FnMut(f64, Part)| {
        if t > ROOT_DEPTH && t < MAX_DISTANCE {
            sink(t, Part::side(face));
        }
    };
    let sink = &mut |t, part| sink.push(t, part);
    if d.y.abs() > EPSILON {
        for (y, r_sq, face) in [(high, s.cap_sq, CAP), (low, s.base_sq, BASE)] {
            if r_sq > 0.0 {
                let t = (y - o.y) / d.y;
                if (o.x + t * d.x).powi(2) + (o.z + t * d.z).powi(2) <= r_sq {
                    push(t, face, sink);
                }
            }
        }
    }
    let (y_near, y_far) = if d.y.abs() < EPSILON { (o.y, o.y) } else { (f64::NEG_INFINITY, f64::INFINITY) };
    for (k, seg) in s.segments.iter().enumerate() {
        if y_near > seg.high || y_far < seg.low {
            continue;
        }
        let [a, b, c, e] = seg.c;
        let (y, m) = (o.y, d.y);
        let poly = [
            -a * m * m * m,
            d.x * d.x + d.z * d.z - m * m * (3.0 * a * y + b),
            2.0 * (o.x * d.x + o.z * d.z) - m * (y * (3.0 * a * y + 2.0 * b) + c),
            o.x * o.x + o.z * o.z - (((a * y + b) * y + c) * y + e),
        ];
        for t in solve_polynomial(&poly, s.sturm, 0.0).iter() {
            let h = o.y + t * d.y;
            if h >= seg.low && h <= seg.high {
                push(*t, k as u32, sink);
            }
        }
    }
}

/// The surface belongs to it.
pub fn inside_sor(s: &SorShape, p: DVec3) -> bool {
    let seg = s.segments.iter().find(|seg| (seg.low..=seg.high).contains(&p.y));
    seg.is_some_and(|seg| p.x * p.x + p.z * p.z <= seg.radius_sq(p.y))
}

/// Not unit.
pub fn sor_normal(s: &SorShape, p: DVec3, part: &Part) -> DVec3 {
    match part.face {
        BASE => -DVec3::Y,
        CAP => DVec3::Y,
        k => {
            let c = s.segments[k as usize].c;
            DVec3::new(p.x, -0.5 * ((3.0 * c[0] * p.y + 2.0 * c[1]) * p.y + c[2]), p.z)
        }
    }
}

/// u around the axis, v along the height.
pub fn sor_uv(s: &SorShape, p: DVec3, part: &Part) -> DVec2 {
    let rho = (p.x * p.x + p.z * p.z).sqrt();
    let v = match part.face {
        BASE => rho / s.base_sq.sqrt() - 1.0,
        CAP => 2.0 - rho / s.cap_sq.sqrt(),
        k => {
            let seg = s.segments[k as usize];
            (f64::from(k) + (p.y - seg.low) / (seg.high - seg.low)) / s.segments.len() as f64
        }
    };
    DVec2::new(turns_about_y(p.x, p.z), v)
}

/// The ray is on a side where it is in the plane through the ray that the curve crosses. `Part`: segment, parameter.
pub fn intersect_prism(s: &PrismShape, ray: &LocalRay, sink: &mut impl HitSink) {
    let (o, d) = (ray.origin, ray.dir);
    if !s.open && d.y.abs() > EPSILON {
        for (y, face) in [(s.high, CAP), (s.low, BASE)] {
            let t = (y - o.y) / d.y;
            let scale = if s.conic { y } else { 1.0 };
            let p = DVec2::new(o.x + t * d.x, o.z + t * d.z);
            if t > ROOT_DEPTH && t < MAX_DISTANCE && scale != 0.0 && inside_loops(&s.segments, p / scale) {
                sink.push(t, Part::side(face));
            }
        }
    }
    let (t0, t1) = slab(o.y, d.y, s.low, s.high);
    if t0 > t1 {
        return;
    }
    // The plane through the ray (and, for cones, the apex) cuts the section's plane in a line: a·(u, v) + b = 0.
    let (a, b) = if s.conic {
        (DVec2::new(o.z * d.y - o.y * d.z, o.y * d.x - o.x * d.y), o.x * d.z - o.z * d.x)
    } else {
        (DVec2::new(d.z, -d.x), o.z * d.x - o.x * d.z)
    };
    // Rays along y miss all sides, those of cones too (POV-Ray's rule).
    if a.abs().max_element() < EPSILON || (d.x.abs() < EPSILON && d.z.abs() < EPSILON) {
        return;
    }
    for (k, seg) in s.segments.iter().enumerate() {
        let (low, high) = (a * seg.min, a * seg.max);
        if low.min(high).element_sum() + b > EPSILON || low.max(high).element_sum() + b < -EPSILON {
            continue;
        }
        seg.for_roots(a, b, |w| {
            let c = seg.at(w);
            let (nx, nz) = if s.conic { (d.x - c.x * d.y, d.z - c.y * d.y) } else { (d.x, d.z) };
            let (px, pz) = if s.conic { (c.x * o.y - o.x, c.y * o.y - o.z) } else { (c.x - o.x, c.y - o.z) };
            let t = if nx.abs() > nz.abs() { px / nx } else { pz / nz };
            let y = o.y + t * d.y;
            if t > ROOT_DEPTH && t < MAX_DISTANCE && y >= s.low && y <= s.high {
                sink.push(t, Part { face: k as u32, a: w, b: 0.0 });
            }
        });
    }
}

/// The lower face belongs to it, the upper does not.
pub fn inside_prism(s: &PrismShape, p: DVec3) -> bool {
    if !(p.y >= s.low && p.y < s.high) {
        return false;
    }
    let q = DVec2::new(p.x, p.z);
    if s.conic { p.y.abs() > EPSILON && inside_loops(&s.segments, q / p.y) } else { inside_loops(&s.segments, q) }
}

/// Both faces give +y; sides depend on the way the curve winds.
pub fn prism_normal(s: &PrismShape, part: &Part) -> DVec3 {
    if part.face >= BASE {
        return DVec3::Y;
    }
    let seg = &s.segments[part.face as usize];
    let (c, m) = (seg.at(part.a), seg.slope(part.a));
    DVec3::new(m.y, if s.conic { c.y * m.x - c.x * m.y } else { 0.0 }, -m.x)
}

/// The one crossing of a polygon.
pub fn intersect_polygon(s: &PolygonShape, ray: &LocalRay, sink: &mut impl HitSink) {
    let slope = s.normal.dot(ray.dir);
    if slope.abs() < EPSILON {
        return;
    }
    let t = s.normal.dot(s.origin - ray.origin) / slope;
    if t > 1e-8 && t < MAX_DISTANCE {
        let p = ray.at(t) - s.origin;
        if inside_loops(&s.segments, DVec2::new(p.dot(s.u), p.dot(s.v))) {
            sink.push(t, Part::default());
        }
    }
}

/// Front, back and the walls along the outline.
pub fn intersect_glyph(s: &GlyphShape, ray: &LocalRay, sink: &mut impl HitSink) {
    let (o, d) = (ray.origin, ray.dir);
    let (t0, t1) = slab(o.z, d.z, 0.0, s.depth);
    if t0 > t1 {
        return;
    }
    let mut push = |t: f64, part: Part| {
        if t > 1e-6 && t < MAX_DISTANCE {
            sink.push(t, part);
        }
    };
    if d.z.abs() > EPSILON {
        for (z, face) in [(0.0, BASE), (s.depth, CAP)] {
            let t = (z - o.z) / d.z;
            let p = DVec2::new(o.x + t * d.x, o.y + t * d.y);
            if p.cmpge(s.min).all() && p.cmple(s.max).all() && inside_loops(&s.segments, p) {
                push(t, Part::side(face));
            }
        }
    }
    let flat_sq = d.x * d.x + d.y * d.y;
    if flat_sq < EPSILON * EPSILON {
        return;
    }
    let (a, b) = (DVec2::new(d.y, -d.x), o.y * d.x - o.x * d.y);
    for (k, seg) in s.segments.iter().enumerate() {
        let (low, high) = (a * seg.min, a * seg.max);
        if low.min(high).element_sum() + b > EPSILON || low.max(high).element_sum() + b < -EPSILON {
            continue;
        }
        seg.for_roots(a, b, |w| {
            let c = seg.at(w);
            let t = if d.x.abs() > d.y.abs() { (c.x - o.x) / d.x } else { (c.y - o.y) / d.y };
            let z = o.z + t * d.z;
            if z >= 0.0 && z <= s.depth {
                push(t, Part { face: k as u32, a: w, b: 0.0 });
            }
        });
    }
}

/// Front and back belong to it.
pub fn inside_glyph(s: &GlyphShape, p: DVec3) -> bool {
    p.z >= 0.0 && p.z <= s.depth && inside_loops(&s.segments, DVec2::new(p.x, p.y))
}

/// Walls point to the right of the outline's direction: into the letter for outlines that run clockwise (POV-Ray's sign).
pub fn glyph_normal(s: &GlyphShape, part: &Part) -> DVec3 {
    match part.face {
        BASE => -DVec3::Z,
        CAP => DVec3::Z,
        k => {
            let m = CurveSegment::slope(&s.segments[k as usize], part.a);
            DVec3::new(m.y, -m.x, 0.0)
        }
    }
}
