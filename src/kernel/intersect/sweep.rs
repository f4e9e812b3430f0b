//! Sphere sweeps and ovus. Source: spec/objects.md, sections 2 and 12.
//!
//! A sweep is the union of its spheres. Along a ray the depths covered by one piece of curve are a few intervals, whose ends lie where
//! the sphere's entry or exit depth is extreme in the curve's parameter: at the ends of the piece or on the envelope.

use super::{HitSink, LocalRay, Part, sphere_uv};
use crate::compile::shape::sweep::{OvusShape, SphereSweepShape, SweepSegment};
use crate::math::bernstein::roots_in_unit;
use crate::math::roots::solve_polynomial;
use crate::math::{DVec2, DVec3, MAX_DISTANCE};
use std::cell::RefCell;

/// Hits of sweeps nearer than this are not seen.
const SWEEP_TOLERANCE: f64 = 1e-6;

/// Depths covered, and the place on the curve (piece + parameter) whose sphere makes each end.
#[derive(Clone, Copy)]
struct Covered {
    from: f64,
    to: f64,
    from_at: f64,
    to_at: f64,
}

thread_local! {
    /// Kept between rays, so that no ray allocates once it has grown.
    static COVERED: RefCell<Vec<Covered>> = const { RefCell::new(Vec::new()) };
}

/// A polynomial in u, lowest power first.
#[derive(Clone, Copy)]
struct Poly<const N: usize>([f64; N]);

impl<const N: usize> Poly<N> {
    fn of(c: &[f64]) -> Self {
        let mut p = [0.0; N];
        p.iter_mut().zip(c).for_each(|(a, b)| *a = *b);
        Self(p)
    }

    fn add_product<const A: usize, const B: usize>(&mut self, a: &Poly<A>, b: &Poly<B>, factor: f64) {
        for (i, x) in a.0.iter().enumerate() {
            if *x != 0.0 {
                for (j, y) in b.0.iter().enumerate() {
                    if i + j < N {
                        self.0[i + j] += factor * x * y;
                    }
                }
            }
        }
    }
}

/// All crossings of the sweep's outer surface. `Part`: piece, parameter.
pub fn intersect_sphere_sweep(s: &SphereSweepShape, ray: &LocalRay, sink: &mut impl HitSink) {
    COVERED.with_borrow_mut(|list| {
        list.clear();
        for (k, seg) in s.segments.iter().enumerate() {
            if super::meets_box(&seg.bounds, ray) {
                cover(seg, k as f64, ray, list);
            }
        }
        list.sort_unstable_by(|a, b| a.from.total_cmp(&b.from));
        let mut push = |t: f64, at: f64| {
            if t > SWEEP_TOLERANCE && t < MAX_DISTANCE {
                let face = at.floor().min((s.segments.len() - 1) as f64);
                sink.push(t, Part { face: face as u32, a: at - face, b: 0.0 });
            }
        };
        let mut rest = list.iter();
        let Some(mut run) = rest.next().copied() else { return };
        for c in rest {
            if c.from <= run.to {
                if c.to > run.to {
                    (run.to, run.to_at) = (c.to, c.to_at);
                }
            } else {
                push(run.from, run.from_at);
                push(run.to, run.to_at);
                run = *c;
            }
        }
        push(run.from, run.from_at);
        push(run.to, run.to_at);
    });
}

/// Adds the depths that one piece of curve covers.
fn cover(seg: &SweepSegment, piece: f64, ray: &LocalRay, out: &mut Vec<Covered>) {
    let n = usize::from(seg.degree);
    // Near the piece depths are small, which keeps the polynomials well-conditioned.
    let shift = (seg.bounds.center() - ray.origin).dot(ray.dir);
    let origin = ray.at(shift);
    // Along the curve: offset w = center - origin, b = w·d, and their derivatives.
    let center = |k: usize| seg.center[3 - k] - if k == 0 { origin } else { DVec3::ZERO };
    let b = Poly::<4>::of(&std::array::from_fn::<f64, 4, _>(|k| center(k).dot(ray.dir)));
    let r = Poly::<4>::of(&std::array::from_fn::<f64, 4, _>(|k| seg.radius[3 - k]));
    let mut w_sq = Poly::<7>([0.0; 7]);
    for i in 0..=n {
        for j in 0..=n {
            w_sq.0[i + j] += center(i).dot(center(j));
        }
    }
    // c = |w|² - r²: entry and exit are b ∓ sqrt(b² - c).
    let mut c = w_sq;
    c.add_product(&r, &r, -1.0);
    let mut disc = Poly::<7>::of(&c.0.map(|v| -v));
    disc.add_product(&b, &b, 1.0);
    // t² - 2 b t + c = 0 and its derivative in u, -2 b' t + c' = 0: c'² / 4 - b b' c' + c b'² = 0.
    let b1 = Poly::<3>(std::array::from_fn(|k| (k + 1) as f64 * b.0[k + 1]));
    let c1 = Poly::<6>(std::array::from_fn(|k| (k + 1) as f64 * c.0[k + 1]));
    let mut bb1 = Poly::<6>([0.0; 6]);
    bb1.add_product(&b, &b1, 1.0);
    let mut b1_sq = Poly::<5>([0.0; 5]);
    b1_sq.add_product(&b1, &b1, 1.0);
    let mut envelope = Poly::<11>([0.0; 11]);
    envelope.add_product(&c1, &c1, 0.25);
    envelope.add_product(&bb1, &c1, -1.0);
    envelope.add_product(&c, &b1_sq, 1.0);
    // Parameters of interest: the ends, the extremes, and where the ray begins or ends to meet the spheres.
    let mut at = [0.0; 32];
    at[1] = 1.0;
    let mut n_at = 2;
    let mut add = |poly: &[f64]| {
        let mut falling = [0.0; 11];
        let m = poly.len();
        falling.iter_mut().zip(poly.iter().rev()).for_each(|(a, b)| *a = *b);
        let scale = falling[..m].iter().fold(0.0f64, |s, v| s.max(v.abs()));
        if scale == 0.0 {
            return;
        }
        falling.iter_mut().for_each(|v| *v /= scale);
        for u in roots_in_unit(&falling[..m]).iter() {
            if n_at < at.len() {
                at[n_at] = *u;
                n_at += 1;
            }
        }
    };
    add(&envelope.0[..if n == 1 { 3 } else { 11 }]);
    add(&disc.0[..=2 * n]);
    // A ray square to the curve makes the envelope a perfect square, whose roots rounding may hide: look for those of its root.
    let reach = center(1).length().max(center(2).length()).max(center(3).length());
    if b1.0.iter().all(|v| v.abs() < 1e-6 * reach) {
        add(&c1.0[..2 * n]);
    }
    let at = &mut at[..n_at];
    at.sort_unstable_by(f64::total_cmp);
    let mut run: Option<Covered> = None;
    for (k, u) in at.iter().enumerate() {
        let (w, radius) = (seg.center_at(*u) - origin, seg.radius_at(*u));
        let b = w.dot(ray.dir);
        let d = b * b - w.length_squared() + radius * radius;
        let slack = 1e-9 * radius * radius;
        if d >= -slack {
            let root = d.max(0.0).sqrt();
            let (t0, t1, place) = (shift + b - root, shift + b + root, piece + u);
            let here = Covered { from: t0, to: t1, from_at: place, to_at: place };
            let joined = run.get_or_insert(here);
            if t0 < joined.from {
                (joined.from, joined.from_at) = (t0, place);
            }
            if t1 > joined.to {
                (joined.to, joined.to_at) = (t1, place);
            }
        }
        // Whether the spheres up to the next place are met too.
        let on = at.get(k + 1).is_some_and(|next| {
            let m = 0.5 * (u + next);
            let (w, radius) = (seg.center_at(m) - origin, seg.radius_at(m));
            let b = w.dot(ray.dir);
            b * b - w.length_squared() + radius * radius >= 0.0
        });
        if !on {
            out.extend(run.take());
        }
    }
    out.extend(run);
}

/// As POV-Ray: where some sphere passes through the point; deep inside none does.
pub fn inside_sphere_sweep(s: &SphereSweepShape, p: DVec3) -> bool {
    if p.cmplt(s.bounds.min).any() || p.cmpgt(s.bounds.max).any() {
        return false;
    }
    s.segments.iter().any(|seg| {
        let n = usize::from(seg.degree);
        let center = |k: usize| seg.center[3 - k] - if k == 0 { p } else { DVec3::ZERO };
        let mut poly = [0.0; 7];
        for i in 0..=n {
            for j in 0..=n {
                poly[2 * n - i - j] += center(i).dot(center(j)) - seg.radius[3 - i] * seg.radius[3 - j];
            }
        }
        !roots_in_unit(&poly[..=2 * n]).is_empty()
    })
}

/// From the centre of the sphere that makes the hit.
pub fn sphere_sweep_normal(s: &SphereSweepShape, p: DVec3, part: &Part) -> DVec3 {
    p - s.segments[part.face as usize].center_at(part.a)
}

/// Faces of an ovus.
const BOTTOM: u32 = 0;
const TOP: u32 = 1;
const ARC: u32 = 2;

/// Both spheres and the spindle between.
pub fn intersect_ovus(s: &OvusShape, ray: &LocalRay, sink: &mut impl HitSink) {
    let mut push = |t: f64, face: u32| {
        if t > crate::math::EPSILON && t < MAX_DISTANCE {
            sink.push(t, Part::side(face));
        }
    };
    for (y, r, face) in [(0.0, s.bottom, BOTTOM), (s.bottom, s.top, TOP)] {
        let to = DVec3::Y * y - ray.origin;
        let b = to.dot(ray.dir);
        let d = b * b - to.length_squared() + r * r;
        if d > 0.0 {
            for t in [b - d.sqrt(), b + d.sqrt()] {
                let h = ray.origin.y + t * ray.dir.y;
                if (face == BOTTOM && h < s.low_cut) || (face == TOP && h > s.high_cut) {
                    push(t, face);
                }
            }
        }
    }
    // The spindle torus of radii `offset` and `arc`; only its inner part is the egg's.
    let shift = -ray.origin.dot(ray.dir);
    let o = ray.at(shift) - DVec3::Y * s.height;
    let (r1, r2) = (s.offset * s.offset, s.arc * s.arc);
    let k1 = o.length_squared() - r1 - r2;
    let k2 = o.dot(ray.dir);
    let c = [
        1.0,
        4.0 * k2,
        2.0 * (k1 + 2.0 * (k2 * k2 + r1 * ray.dir.y * ray.dir.y)),
        4.0 * (k2 * k1 + 2.0 * r1 * o.y * ray.dir.y),
        k1 * k1 + 4.0 * r1 * (o.y * o.y - r2),
    ];
    for t in solve_polynomial(&c, false, 1e-4).iter() {
        let t = t + shift;
        let p = ray.at(t);
        let r = (p.x * p.x + p.z * p.z).sqrt();
        let on_arc = ((r + s.offset).powi(2) + (p.y - s.height).powi(2) - r2).abs() < 1e-4;
        if on_arc && p.y >= s.low_cut && p.y <= s.high_cut {
            push(t, ARC);
        }
    }
}

/// In either sphere or the spindle between the cuts.
pub fn inside_ovus(s: &OvusShape, p: DVec3) -> bool {
    let r_sq = p.x * p.x + p.z * p.z;
    r_sq + p.y * p.y < s.bottom * s.bottom
        || r_sq + (p.y - s.bottom).powi(2) < s.top * s.top
        || (p.y > s.low_cut && p.y < s.high_cut && (r_sq.sqrt() + s.offset).powi(2) + (p.y - s.height).powi(2) < s.arc * s.arc)
}

/// Not unit.
pub fn ovus_normal(s: &OvusShape, p: DVec3, part: &Part) -> DVec3 {
    match part.face {
        BOTTOM => p,
        TOP => p - DVec3::Y * s.bottom,
        _ => {
            let r = (p.x * p.x + p.z * p.z).sqrt();
            if r < 1e-12 {
                return DVec3::Y * (p.y - s.height);
            }
            let k = (r + s.offset) / r;
            DVec3::new(p.x * k, p.y - s.height, p.z * k)
        }
    }
}

/// As a sphere about (0, top / 2, 0).
pub fn ovus_uv(s: &OvusShape, p: DVec3) -> DVec2 {
    sphere_uv(p - DVec3::Y * (0.5 * s.top))
}
