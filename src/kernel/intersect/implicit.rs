//! Isosurfaces and parametric surfaces over any functions: interval searches with a bound on the slope.
//! Source: spec/objects.md, sections 9 and 10. The functions themselves are `kernel/function`'s business.

use super::{HitSink, LocalRay, Part};
use crate::compile::shape::implicit::{IsosurfaceShape, ParametricShape};
use crate::math::{DVec2, DVec3, EPSILON, MAX_DISTANCE};
use crate::scene::shape::Container;

/// `Part::face` of a hit on the function's surface; 1 to 6 are the faces of a box container, 7 is a sphere container.
const SURFACE: u32 = 0;
const SPHERE: u32 = 7;
/// Most evaluations a search: what a scene may ask for is bounded.
const MAX_EVALUATIONS: u32 = 4_000_000;

/// Depths between which the ray is in the container, and the faces there.
fn container_interval(c: &Container, ray: &LocalRay) -> Option<(f64, u32, f64, u32)> {
    match c {
        Container::Sphere { center, radius } => {
            let to = *center - ray.origin;
            let b = to.dot(ray.dir);
            let d = b * b - to.length_squared() + radius * radius;
            if d <= 0.0 {
                return None;
            }
            let root = d.sqrt();
            (b + root > 0.0).then_some((b - root, SPHERE, b + root, SPHERE))
        }
        Container::Box { min, max } => {
            let (mut near, mut far) = (f64::NEG_INFINITY, f64::INFINITY);
            let (mut near_face, mut far_face) = (SURFACE, SURFACE);
            for k in 0..3 {
                let (o, d) = (ray.origin[k], ray.dir[k]);
                if d.abs() < EPSILON {
                    if o < min[k] || o > max[k] {
                        return None;
                    }
                    continue;
                }
                let (a, b) = ((min[k] - o) / d, (max[k] - o) / d);
                let (low, high) = (2 * k as u32 + 1, 2 * k as u32 + 2);
                let (t0, f0, t1, f1) = if a < b { (a, low, b, high) } else { (b, high, a, low) };
                if t0 > near {
                    (near, near_face) = (t0, f0);
                }
                if t1 < far {
                    (far, far_face) = (t1, f1);
                }
            }
            (near <= far && far > 0.0).then_some((near, near_face, far, far_face))
        }
    }
}

fn in_container(c: &Container, p: DVec3) -> bool {
    match c {
        Container::Sphere { center, radius } => (p - *center).length_squared() <= radius * radius,
        Container::Box { min, max } => p.cmpge(*min).all() && p.cmple(*max).all(),
    }
}

/// Hits of an isosurface; `f` gives the function's value at a point of shape space.
pub fn intersect_isosurface(s: &IsosurfaceShape, ray: &LocalRay, f: &impl Fn(DVec3) -> f64, sink: &mut impl HitSink) {
    let Some((near, near_face, far, far_face)) = container_interval(&s.container, ray) else { return };
    // Depths are compared in world units, slopes in units of shape space.
    let a = s.accuracy * ray.scale;
    let (mut t_min, t_max) = (near.max(0.0), far.min(MAX_DISTANCE));
    let value = |t: f64| f(ray.at(t)) - s.threshold;
    let mut g = s.max_gradient;
    if let Some([p0, _, p2]) = s.evaluate
        && g > p0
    {
        g *= p2;
    }
    let (mut sign, mut n_found) = (1.0, 0);
    // Evaluations are what this costs: the ends' values are kept.
    let (mut at_min, mut at_max) = (None, None);
    if near > a {
        if !s.open && *at_min.insert(value(t_min)) < 0.0 {
            sink.push(near, Part::side(near_face));
            n_found += 1;
            sign = -1.0;
        }
    } else {
        // A ray that starts at the surface must not meet it again.
        let f = *at_min.insert(value(t_min));
        if (if s.open { f.abs() } else { f }) < 4.0 * g * s.accuracy {
            t_min += 5.0 * a;
            if *at_min.insert(value(t_min)) < 0.0 {
                sign = -1.0;
            }
        }
        if !s.open && *at_max.insert(value(t_max)) < 0.0 {
            sink.push(t_max, Part::side(far_face));
        }
    }
    let mut budget = MAX_EVALUATIONS;
    while n_found < s.max_trace && t_max - t_min >= a {
        let f_min = at_min.take().unwrap_or_else(|| value(t_min));
        let f_max = *at_max.get_or_insert_with(|| value(t_max));
        if s.open && f_min * sign < 0.0 {
            sign = -sign;
        }
        let (start, end) = ((t_min, f_min * sign), (t_max, f_max * sign));
        let Some(t) = first_root(s, a, &value, start, end, sink.far(), sign, &mut g, &mut budget) else { return };
        if t > EPSILON {
            sink.push(t, Part::side(SURFACE));
        }
        n_found += 1;
        t_min = t + 5.0 * a;
        sign = -sign;
        if t > sink.far() {
            return;
        }
    }
}

/// Bisection, near half first: an interval whose ends are too high for the slope to reach zero is left out. The root is the far
/// end of the last interval. Beyond `far` nothing is wanted.
fn first_root(
    s: &IsosurfaceShape,
    accuracy: f64,
    value: &impl Fn(f64) -> f64,
    start: (f64, f64),
    end: (f64, f64),
    far: f64,
    sign: f64,
    g: &mut f64,
    budget: &mut u32,
) -> Option<f64> {
    // Far ends still to be looked at, nearest on top.
    let mut ends = [(0.0, 0.0); 64];
    let mut n = 1;
    ends[0] = end;
    let (mut t1, mut f1) = start;
    while n > 0 {
        if t1 > far {
            return None;
        }
        let (t2, f2) = ends[n - 1];
        let len = t2 - t1;
        if let Some([_, p1, _]) = s.evaluate {
            let slope = (f1 - f2).abs() / len;
            if slope * p1 > *g && slope.is_finite() {
                *g = slope * p1 * p1;
            }
        }
        if len < accuracy || n == ends.len() {
            if f2 < 0.0 {
                return Some(t2);
            }
        } else if f1 + f2 < *g * len {
            if *budget == 0 {
                return None;
            }
            *budget -= 1;
            let mid = 0.5 * (t1 + t2);
            ends[n] = (mid, value(mid) * sign);
            n += 1;
            continue;
        }
        (t1, f1) = (t2, f2);
        n -= 1;
    }
    None
}

/// In the container and not above the threshold.
pub fn inside_isosurface(s: &IsosurfaceShape, p: DVec3, f: &impl Fn(DVec3) -> f64) -> bool {
    in_container(&s.container, p) && f(p) - s.threshold <= 0.0
}

/// The container's, or forward differences.
pub fn isosurface_normal(s: &IsosurfaceShape, p: DVec3, part: &Part, f: &impl Fn(DVec3) -> f64) -> DVec3 {
    match (part.face, &s.container) {
        (1..=6, _) => super::simple::box_normal(part.face - 1),
        (SPHERE, Container::Sphere { center, .. }) => p - *center,
        _ => {
            let (a, f0) = (s.accuracy, f(p));
            let n = DVec3::new(f(p + DVec3::X * a) - f0, f(p + DVec3::Y * a) - f0, f(p + DVec3::Z * a) - f0);
            if n == DVec3::ZERO || n.is_nan() { DVec3::X } else { n }
        }
    }
}

/// A rectangle of (u, v) with the depths at which the ray may meet its patch.
#[derive(Clone, Copy)]
struct Patch {
    low: DVec2,
    high: DVec2,
    from: f64,
}

/// The nearest hit of a parametric surface; `f` gives the point of shape space at (u, v). `Part`: u, v.
pub fn intersect_parametric(s: &ParametricShape, ray: &LocalRay, f: &impl Fn(DVec2) -> DVec3, sink: &mut impl HitSink) {
    let Some((near, _, far, _)) = container_interval(&s.container, ray) else { return };
    let (t_low, t_high) = (near.max(0.0), far.min(MAX_DISTANCE));
    let mut best = f64::INFINITY;
    let mut found = DVec2::ZERO;
    let mut stack = [Patch { low: s.min, high: s.max, from: t_low }; 96];
    let mut n = 1;
    let mut budget = MAX_EVALUATIONS / 4;
    while n > 0 && budget > 0 {
        n -= 1;
        let p = stack[n];
        if p.from >= best {
            continue;
        }
        // Halve the longer side.
        let size = p.high - p.low;
        let (mut a, mut b) = (p, p);
        let mid = 0.5 * (p.low + p.high);
        if size.x > size.y {
            (a.high.x, b.low.x) = (mid.x, mid.x);
        } else {
            (a.high.y, b.low.y) = (mid.y, mid.y);
        }
        let mut next = [None, None];
        for (slot, mut half) in next.iter_mut().zip([a, b]) {
            budget -= 1;
            let Some((from, entry)) = depths(s, ray, f, &half, t_low, t_high.min(best)) else { continue };
            if (half.high - half.low).max_element() < s.accuracy {
                if entry > 0.0 && entry < best {
                    best = entry;
                    found = half.low;
                }
            } else {
                half.from = from;
                *slot = Some(half);
            }
        }
        // The lower half comes off the stack first, be it nearer or not: where depths tie, it decides the cell (measured).
        next.swap(0, 1);
        for half in next.into_iter().flatten() {
            if n < stack.len() {
                stack[n] = half;
                n += 1;
            }
        }
    }
    if best < MAX_DISTANCE {
        sink.push(best, Part { face: 0, a: found.x, b: found.y });
    }
}

/// Depth at which the ray enters the patch's box, and that of its last coordinate alone.
fn depths(s: &ParametricShape, ray: &LocalRay, f: &impl Fn(DVec2) -> DVec3, p: &Patch, t_low: f64, t_high: f64) -> Option<(f64, f64)> {
    let a = DVec3::splat(s.accuracy);
    let corner = [p.low, DVec2::new(p.low.x, p.high.y), DVec2::new(p.high.x, p.low.y), p.high].map(|c| f(c) - a);
    let size = p.high - p.low;
    let grow = |len: f64, x: f64, y: f64| (0.5 * (s.max_gradient * len - (x - y).abs())).max(0.0);
    let (mut from, mut to, mut entry) = (t_low, t_high, t_low);
    for k in 0..3 {
        let c = corner.map(|v| v[k]);
        let span = |x: f64, y: f64| {
            let g = grow(size.y, x, y);
            (x.min(y) - g, x.max(y) + g)
        };
        let ((l0, h0), (l1, h1)) = (span(c[0], c[1]), span(c[2], c[3]));
        let low = l0.min(l1) - grow(size.x, l0, l1);
        let high = h0.max(h1) + grow(size.x, h0, h1);
        let (o, d) = (ray.origin[k], ray.dir[k]);
        if d.abs() < EPSILON {
            if o < low || o > high {
                return None;
            }
            continue;
        }
        let (x, y) = ((low - o) / d, (high - o) / d);
        let (t0, t1) = (x.min(y), x.max(y));
        entry = t0.max(t_low);
        from = from.max(t0);
        to = to.min(t1);
        if from > to {
            return None;
        }
    }
    Some((from, entry))
}

/// Cross product of forward differences.
pub fn parametric_normal(s: &ParametricShape, part: &Part, f: &impl Fn(DVec2) -> DVec3) -> DVec3 {
    let at = DVec2::new(part.a, part.b);
    let p = f(at);
    let (du, dv) = (f(at + DVec2::X * s.accuracy) - p, f(at + DVec2::Y * s.accuracy) - p);
    du.cross(dv)
}
