//! Blobs: along a ray the field is a sum of quartics, one for each element in reach. Source: spec/objects.md, section 4.

use super::{HitSink, LocalRay, Part};
use crate::compile::shape::blob::{BlobElement, BlobElementKind, BlobShape, GROUP};
use crate::math::roots::solve_polynomial;
use crate::math::{Bounds, DVec3, EPSILON, MAX_DISTANCE, Ray};
use std::cell::RefCell;

/// Hits nearer than this are not seen: large, as in POV-Ray.
const TOLERANCE: f64 = 1e-2;
/// A root this near 0 is divided out.
const ROOT_TOLERANCE: f64 = 1e-11;
/// Points count as inside a little before the field reaches the threshold.
const INSIDE_TOLERANCE: f64 = 1e-6;

/// Where the ray enters or leaves an element's reach, with the quartic that the element adds there.
#[derive(Clone, Copy)]
struct Event {
    t: f64,
    enters: bool,
    quartic: [f64; 5],
}

thread_local! {
    /// Kept between rays, so that no ray allocates once it has grown.
    static EVENTS: RefCell<Vec<Event>> = const { RefCell::new(Vec::new()) };
}

/// All crossings; without `all`, those of the first interval that has any.
pub fn intersect_blob(s: &BlobShape, ray: &LocalRay, all: bool, sink: &mut impl HitSink) {
    // Start near the blob: quartics far from their zero lose digits.
    let Some((start, end)) = box_interval(&s.bounds, ray) else { return };
    let moved = LocalRay { origin: ray.at(start), ..*ray };
    EVENTS.with_borrow_mut(|events| {
        events.clear();
        s.tree.any(&Ray::new(moved.origin, moved.dir), 0.0, end - start, |k| {
            if let Some((t0, t1, quartic)) = element_interval(s, &s.elements[k as usize], &moved) {
                let t0 = t0.max(0.0);
                if t1 > t0 && t0 <= end - start {
                    events.push(Event { t: t0, enters: true, quartic });
                    events.push(Event { t: t1, enters: false, quartic });
                }
            }
            false
        });
        events.sort_unstable_by(|a, b| a.t.total_cmp(&b.t));
        let mut sum = [0.0; 5];
        let (mut n_active, mut k) = (0u32, 0);
        while k < events.len() {
            let t = events[k].t;
            while k < events.len() && events[k].t == t {
                let e = &events[k];
                let sign = if e.enters { 1.0 } else { -1.0 };
                sum.iter_mut().zip(e.quartic).for_each(|(a, b)| *a += sign * b);
                n_active = if e.enters { n_active + 1 } else { n_active - 1 };
                k += 1;
            }
            if n_active == 0 {
                sum = [0.0; 5];
                continue;
            }
            let until = events.get(k).map_or(t, |e| e.t);
            let mut poly = sum;
            poly[4] -= s.threshold;
            if hits_between(&poly, t, until, s.sturm, start, sink) && !all {
                return;
            }
        }
    });
}

/// Solves within an interval; whether there was a hit.
fn hits_between(poly: &[f64; 5], from: f64, to: f64, sturm: bool, start: f64, sink: &mut impl HitSink) -> bool {
    if !may_vanish(poly, from, to) {
        return false;
    }
    let mut roots = [0.0; 8];
    let mut n = 0;
    let nearest = if sink.is_below_surface() { 0.0 } else { TOLERANCE };
    for t in solve_polynomial(poly, sturm, ROOT_TOLERANCE).iter() {
        if (from..=to).contains(t) && start + t > nearest && start + t < MAX_DISTANCE && n < 8 {
            roots[n] = start + t;
            n += 1;
        }
    }
    roots[..n].iter().for_each(|t| sink.push(*t, Part::default()));
    n > 0
}

/// Whether the Bézier control values over an interval have both signs: if not, there is no root.
fn may_vanish(p: &[f64; 5], a: f64, b: f64) -> bool {
    let d = b - a;
    // Taylor at a, in s = (t - a) / d.
    let c0 = (((p[0] * a + p[1]) * a + p[2]) * a + p[3]) * a + p[4];
    let c1 = (((4.0 * p[0] * a + 3.0 * p[1]) * a + 2.0 * p[2]) * a + p[3]) * d;
    let c2 = ((6.0 * p[0] * a + 3.0 * p[1]) * a + p[2]) * d * d;
    let c3 = (4.0 * p[0] * a + p[1]) * d * d * d;
    let c4 = p[0] * d * d * d * d;
    let b1 = c0 + c1 / 4.0;
    let b2 = c0 + c1 / 2.0 + c2 / 6.0;
    let b3 = c0 + 0.75 * c1 + 0.5 * c2 + c3 / 4.0;
    let b4 = c0 + c1 + c2 + c3 + c4;
    let all = [c0, b1, b2, b3, b4];
    let slack = 1e-12 * all.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    all.iter().any(|v| *v <= slack) && all.iter().any(|v| *v >= -slack)
}

fn box_interval(b: &Bounds, ray: &LocalRay) -> Option<(f64, f64)> {
    let (mut t0, mut t1) = (0.0f64, MAX_DISTANCE);
    for k in 0..3 {
        let (o, d) = (ray.origin[k], ray.dir[k]);
        if d.abs() < EPSILON {
            if o < b.min[k] || o > b.max[k] {
                return None;
            }
            continue;
        }
        let (a, c) = ((b.min[k] - o) / d, (b.max[k] - o) / d);
        t0 = t0.max(a.min(c));
        t1 = t1.min(a.max(c));
    }
    (t0 <= t1).then_some((t0, t1))
}

/// Interval of the ray within the element's reach, and the element's field along it.
#[inline]
fn element_interval(s: &BlobShape, e: &BlobElement, ray: &LocalRay) -> Option<(f64, f64, [f64; 5])> {
    let (mut o, mut d) = (ray.origin, ray.dir);
    if let Some(t) = s.transforms.get(e.transform_ix as usize) {
        (o, d) = (t.inverse_point(o), t.inverse_vector(d));
    }
    o -= e.center;
    // Distance² along the ray is a t² + 2 b t + c.
    let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
    let (along_o, along_d) = (o.dot(e.axis), d.dot(e.axis));
    let mut clip = |v: f64, slope: f64| {
        // Keeps v + slope t <= 0.
        if slope.abs() < 1e-12 {
            if v > 0.0 {
                high = f64::NEG_INFINITY;
            }
        } else if slope > 0.0 {
            high = high.min(-v / slope);
        } else {
            low = low.max(-v / slope);
        }
    };
    match e.kind {
        BlobElementKind::Sphere => {}
        BlobElementKind::HemisphereBelow => clip(along_o, along_d),
        BlobElementKind::Cylinder { length } => {
            clip(-along_o, -along_d);
            clip(along_o - length, along_d);
            o -= along_o * e.axis;
            d -= along_d * e.axis;
        }
    }
    let (a, b, c) = (d.length_squared(), o.dot(d), o.length_squared());
    let apart = c - e.radius_sq;
    if a < 1e-20 {
        if apart >= 0.0 {
            return None;
        }
    } else {
        let disc = b * b - a * apart;
        if disc <= EPSILON * EPSILON {
            return None;
        }
        let root = disc.sqrt();
        low = low.max((-b - root) / a);
        high = high.min((-b + root) / a);
    }
    if low >= high || high <= 0.0 {
        return None;
    }
    let (f4, f2, f0) = (e.f4, e.f2, e.f0);
    let b2 = 2.0 * b;
    Some((
        low,
        high,
        [f4 * a * a, 2.0 * f4 * a * b2, f4 * (b2 * b2 + 2.0 * a * c) + f2 * a, 2.0 * f4 * b2 * c + f2 * b2, f4 * c * c + f2 * c + f0],
    ))
}

/// Vector from the element's skeleton to a point of blob space, in element space; `None` out of reach.
#[inline]
fn offset(s: &BlobShape, e: &BlobElement, p: DVec3) -> Option<DVec3> {
    let local = s.transforms.get(e.transform_ix as usize).map_or(p, |t| t.inverse_point(p));
    let mut d = local - e.center;
    let along = d.dot(e.axis);
    match e.kind {
        BlobElementKind::Sphere => {}
        BlobElementKind::HemisphereBelow => {
            if along > 0.0 {
                return None;
            }
        }
        BlobElementKind::Cylinder { length } => {
            if along < 0.0 || along > length {
                return None;
            }
            d -= along * e.axis;
        }
    }
    (d.length_squared() <= e.radius_sq).then_some(d)
}

#[inline]
fn field_at(e: &BlobElement, d_sq: f64) -> f64 {
    (e.f4 * d_sq + e.f2) * d_sq + e.f0
}

/// Calls `f` with the elements whose boxes hold a point of blob space, in order.
#[inline]
fn near_elements<'s>(s: &'s BlobShape, p: DVec3, mut f: impl FnMut(&'s BlobElement)) {
    for (group, b) in s.elements.chunks(GROUP).zip(&s.groups) {
        if b.contains(p) {
            group.iter().filter(|e| e.bounds.contains(p)).for_each(&mut f);
        }
    }
}

/// Field at a point of blob space.
pub fn blob_field(s: &BlobShape, p: DVec3) -> f64 {
    let mut sum = 0.0;
    near_elements(s, p, |e| sum += offset(s, e, p).map_or(0.0, |d| field_at(e, d.length_squared())));
    sum
}

/// Where the field is above the threshold, or barely below.
pub fn inside_blob(s: &BlobShape, p: DVec3) -> bool {
    blob_field(s, p) > s.threshold - INSIDE_TOLERANCE
}

/// Against the field's gradient; x where it vanishes.
pub fn blob_normal(s: &BlobShape, p: DVec3) -> DVec3 {
    let mut n = DVec3::ZERO;
    near_elements(s, p, |e| {
        if let Some(d) = offset(s, e, p) {
            let g = (-2.0 * e.f2 - 4.0 * e.f4 * d.length_squared()) * d;
            n += s.transforms.get(e.transform_ix as usize).map_or(g, |t| t.normal(g));
        }
    });
    if n == DVec3::ZERO { DVec3::X } else { n }
}

/// Calls `f` with every component that has field at `p` and the field's absolute value.
pub fn blob_weights(s: &BlobShape, p: DVec3, mut f: impl FnMut(u32, f64)) {
    // Elements of one component are neighbours.
    let mut current: Option<(u32, f64)> = None;
    near_elements(s, p, |e| {
        let Some(d) = offset(s, e, p) else { return };
        let v = field_at(e, d.length_squared()).abs();
        match &mut current {
            Some((c, sum)) if *c == e.component => *sum += v,
            _ => {
                if let Some((c, sum)) = current.replace((e.component, v)) {
                    f(c, sum);
                }
            }
        }
    });
    if let Some((c, sum)) = current {
        f(c, sum);
    }
}
