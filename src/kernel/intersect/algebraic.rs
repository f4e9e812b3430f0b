//! Quadric, polynomial surface, superellipsoid. Source: spec/objects.md, sections 2 and 3.

use super::{HitSink, LocalRay, Part};
use crate::compile::shape::algebraic::{PolyShape, QuadricShape, SuperellipsoidShape};
use crate::math::bernstein::roots_in_unit;
use crate::math::roots::{MAX_ORDER, solve_polynomial};
use crate::math::{DVec3, EPSILON, MAX_DISTANCE, to_power};

/// Both crossings of a quadric.
#[inline]
pub fn intersect_quadric(s: &QuadricShape, ray: &LocalRay, sink: &mut impl HitSink) {
    let [a, b, c, d, e, f, g, h, i, _] = s.c;
    let (o, v) = (ray.origin, ray.dir);
    let qa = a * v.x * v.x + b * v.y * v.y + c * v.z * v.z + d * v.x * v.y + e * v.x * v.z + f * v.y * v.z;
    let qb = a * o.x * v.x
        + b * o.y * v.y
        + c * o.z * v.z
        + 0.5 * (d * (o.x * v.y + o.y * v.x) + e * (o.x * v.z + o.z * v.x) + f * (o.y * v.z + o.z * v.y) + g * v.x + h * v.y + i * v.z);
    let qc = quadric_value(s, o);
    let mut push = |t: f64| {
        if t > 1e-6 && t < MAX_DISTANCE {
            sink.push(t, Part::default());
        }
    };
    if qa != 0.0 {
        let disc = qb * qb - qa * qc;
        if disc > 0.0 {
            let root = disc.sqrt();
            push((-qb + root) / qa);
            push((-qb - root) / qa);
        }
    } else if qb != 0.0 {
        push(-0.5 * qc / qb);
    }
}

/// The polynomial at a point; at most 0 is inside.
#[inline]
pub fn quadric_value(s: &QuadricShape, p: DVec3) -> f64 {
    let [a, b, c, d, e, f, g, h, i, j] = s.c;
    p.x * (a * p.x + d * p.y + e * p.z + g) + p.y * (b * p.y + f * p.z + h) + p.z * (c * p.z + i) + j
}

/// Gradient; x where it vanishes.
pub fn quadric_normal(s: &QuadricShape, p: DVec3) -> DVec3 {
    let [a, b, c, d, e, f, g, h, i, _] = s.c;
    let n = DVec3::new(2.0 * a * p.x + d * p.y + e * p.z + g, d * p.x + 2.0 * b * p.y + f * p.z + h, e * p.x + f * p.y + 2.0 * c * p.z + i);
    if n == DVec3::ZERO { DVec3::X } else { n }
}

/// Powers of a coordinate along a ray, (o + d t)^k as coefficients of t from the lowest up.
type Powers = [[f64; MAX_ORDER + 1]; MAX_ORDER + 1];

/// All crossings of a polynomial surface.
pub fn intersect_poly(s: &PolyShape, ray: &LocalRay, sink: &mut impl HitSink) {
    let n = s.order as usize;
    let mut along = [0.0; MAX_ORDER + 1];
    if n <= 4 {
        along[..5].copy_from_slice(&substitute_low(s, ray));
    } else {
        substitute_high(s, ray, &mut along)
    }
    along[..=n].reverse();
    let c = &along[..=n];
    if n == 2 {
        let [qa, qb, qc] = [c[0], c[1], c[2]].map(|v| if v.abs() < 1e-20 { 0.0 } else { v });
        if qa == 0.0 {
            return;
        }
        let disc = qb * qb - 4.0 * qa * qc;
        if disc >= 0.0 {
            let root = disc.sqrt();
            sink_at((-qb + root) / (2.0 * qa), sink);
            sink_at((-qb - root) / (2.0 * qa), sink);
        }
        return;
    }
    let lead = c.iter().take_while(|v| v.abs() < EPSILON).count();
    if n.saturating_sub(lead) <= 1 {
        return;
    }
    // Without a change of sign there is no root ahead of the ray (Descartes).
    if c.iter().all(|v| *v >= 0.0) || c.iter().all(|v| *v <= 0.0) {
        return;
    }
    // What POV-Ray gives to Sturm chains has all its roots exactly: so have Bernstein coefficients over the box, in a fraction of the time.
    if (s.sturm || n > 4)
        && n < MAX_BERNSTEIN
        && let Some((near, far)) = sink.within()
    {
        let slack = 1e-9 * (far.abs() + near.abs());
        let (low, high) = ((near - slack).max(1e-4), (far + slack).min(sink.far()).min(MAX_DISTANCE));
        if low < high {
            let mut moved = [0.0; MAX_BERNSTEIN];
            let moved = moved_to_unit(c, low, high, &mut moved);
            roots_in_unit(moved).iter().for_each(|t| {
                sink_at(low + t * (high - low), sink);
            });
        }
        return;
    }
    let roots = solve_polynomial(c, s.sturm, 1e-4);
    for (k, t) in roots.iter().enumerate() {
        if !roots[..k].contains(t) {
            sink_at(*t, sink);
        }
    }
}

/// Most coefficients of a polynomial that is solved over an interval.
const MAX_BERNSTEIN: usize = 12;

/// The polynomial `c`, highest power first, as one of the place between `low` (0) and `high` (1).
fn moved_to_unit<'m>(c: &[f64], low: f64, high: f64, out: &'m mut [f64; MAX_BERNSTEIN]) -> &'m [f64] {
    let n = c.len();
    out[..n].copy_from_slice(c);
    // Horner's scheme again and again: each pass leaves one coefficient at `low` behind.
    for end in (1..n).rev() {
        for k in 1..=end {
            out[k] += out[k - 1] * low;
        }
    }
    let mut scale = 1.0;
    for v in out[..n].iter_mut().rev() {
        *v *= scale;
        scale *= high - low;
    }
    &out[..n]
}

/// Coefficients along the ray for orders up to 4, from the lowest up: Horner's scheme in x over polynomials in y over polynomials in z,
/// each a polynomial in t.
fn substitute_low(s: &PolyShape, ray: &LocalRay) -> [f64; 5] {
    type Along = [f64; 5];
    // Multiplies by o + d t; what would be the fifth power is 0.
    let times = |p: &mut Along, o: f64, d: f64| {
        for m in (1..5).rev() {
            p[m] = p[m] * o + p[m - 1] * d;
        }
        p[0] *= o;
    };
    let (o, d) = (ray.origin, ray.dir);
    let n = s.order as usize;
    let mut coefficients = s.coefficients.iter();
    let (mut in_x, mut any_x) = ([0.0; 5], false);
    for x in (0..=n).rev() {
        let (mut in_y, mut any_y) = ([0.0; 5], false);
        for y in (0..=n - x).rev() {
            let (mut in_z, mut any_z) = ([0.0; 5], false);
            for factor in coefficients.by_ref().take(n - x - y + 1) {
                if any_z {
                    times(&mut in_z, o.z, d.z);
                }
                in_z[0] += factor;
                any_z |= *factor != 0.0;
            }
            if any_y {
                times(&mut in_y, o.y, d.y);
            }
            if any_z {
                in_y.iter_mut().zip(in_z).for_each(|(a, b)| *a += b);
                any_y = true;
            }
        }
        if any_x {
            times(&mut in_x, o.x, d.x);
        }
        if any_y {
            in_x.iter_mut().zip(in_y).for_each(|(a, b)| *a += b);
            any_x = true;
        }
    }
    in_x
}

/// Coefficients along the ray for orders below `N`, from the lowest up.
fn substitute<const N: usize>(s: &PolyShape, ray: &LocalRay, out: &mut [f64; MAX_ORDER + 1]) {
    let mut powers = [[[0.0; N]; N]; 3];
    let n = s.order as usize;
    for (axis, p) in powers.iter_mut().enumerate() {
        let (o, d) = (ray.origin[axis], ray.dir[axis]);
        p[0][0] = 1.0;
        for k in 1..=n {
            for i in 0..k {
                let below = p[k - 1][i];
                p[k][i] += below * o;
                p[k][i + 1] += below * d;
            }
        }
    }
    for term in &s.terms {
        let [i, j, k] = term.powers.map(usize::from);
        let mut xy = [0.0; N];
        for a in 0..=i {
            for b in 0..=j {
                xy[a + b] += powers[0][i][a] * powers[1][j][b];
            }
        }
        for (a, v) in xy[..=i + j].iter().enumerate() {
            let v = v * term.factor;
            for c in 0..=k {
                out[a + c] += v * powers[2][k][c];
            }
        }
    }
}

/// The same for any order.
#[inline(never)]
fn substitute_high(s: &PolyShape, ray: &LocalRay, out: &mut [f64; MAX_ORDER + 1]) {
    const _: () = assert!(std::mem::size_of::<Powers>() < 1 << 14);
    substitute::<{ MAX_ORDER + 1 }>(s, ray, out);
}

/// Powers of the coordinates up to the order of the surface, which is below `N`.
#[inline]
fn powers_of<const N: usize>(s: &PolyShape, p: DVec3) -> [[f64; N]; 3] {
    p.to_array().map(|v| {
        let mut powers = [1.0; N];
        for k in 1..=(s.order as usize).min(N - 1) {
            powers[k] = powers[k - 1] * v;
        }
        powers
    })
}

/// The polynomial at a point; below 1e-4 is inside.
pub fn poly_value(s: &PolyShape, p: DVec3) -> f64 {
    if s.order < 5 { poly_value_of::<5>(s, p) } else { poly_value_of::<{ MAX_ORDER + 1 }>(s, p) }
}

fn poly_value_of<const N: usize>(s: &PolyShape, p: DVec3) -> f64 {
    let powers = powers_of::<N>(s, p);
    let at = |axis: usize, t: &[u8; 3]| powers[axis][usize::from(t[axis])];
    s.terms.iter().map(|t| t.factor * at(0, &t.powers) * at(1, &t.powers) * at(2, &t.powers)).sum()
}

/// Gradient; x where it vanishes.
pub fn poly_normal(s: &PolyShape, p: DVec3) -> DVec3 {
    let powers = powers_of::<{ MAX_ORDER + 1 }>(s, p);
    let mut n = DVec3::ZERO;
    for t in &s.terms {
        let [i, j, k] = t.powers.map(usize::from);
        let (x, y, z) = (powers[0][i], powers[1][j], powers[2][k]);
        let slope = |axis: usize, e: usize| if e == 0 { 0.0 } else { e as f64 * powers[axis][e - 1] };
        n += t.factor * DVec3::new(slope(0, i) * y * z, x * slope(1, j) * z, x * y * slope(2, k));
    }
    if n == DVec3::ZERO { DVec3::X } else { n }
}

/// Half size of the box that a superellipsoid is looked for in.
const SUPERELLIPSOID_REACH: f64 = 1.01;

/// How far along a piece a ray that starts on the surface is asked whether it goes in.
const START_STEP: f64 = 1e-3;

/// (a^p + b^p)^(1/p), safe for large powers.
#[inline]
fn norm(a: f64, b: f64, p: f64) -> f64 {
    let (small, large) = if a < b { (a, b) } else { (b, a) };
    if large == 0.0 {
        return 0.0;
    }
    large * root_above_one(to_power(small / large, p), 1.0 / p)
}

/// `(1 + x)^k` for `x` in 0..=1 and `k` in 0..=2: a power series where six terms are exact.
#[inline]
fn root_above_one(x: f64, k: f64) -> f64 {
    if x > 1e-3 {
        return (1.0 + x).powf(k);
    }
    let term = |n: f64, rest: f64| 1.0 + (k - n + 1.0) / n * x * rest;
    term(1.0, term(2.0, term(3.0, term(4.0, term(5.0, 1.0)))))
}

/// The norm less 1: negative inside.
#[inline]
pub fn superellipsoid_value(s: &SuperellipsoidShape, p: DVec3) -> f64 {
    norm(norm(p.x.abs(), p.y.abs(), s.xy_power), p.z.abs(), s.z_power) - 1.0
}

/// Piecewise search between the planes where the surface may bend; only the first hit unless `all`.
pub fn intersect_superellipsoid(s: &SuperellipsoidShape, ray: &LocalRay, all: bool, sink: &mut impl HitSink) {
    let (o, d) = (ray.origin, ray.dir);
    let (mut t0, mut t1) = (0.0f64, MAX_DISTANCE);
    for k in 0..3 {
        if d[k].abs() < EPSILON {
            if o[k].abs() > SUPERELLIPSOID_REACH {
                return;
            }
            continue;
        }
        let (a, b) = ((-SUPERELLIPSOID_REACH - o[k]) / d[k], (SUPERELLIPSOID_REACH - o[k]) / d[k]);
        t0 = t0.max(a.min(b));
        t1 = t1.min(a.max(b));
    }
    if t0 >= t1 {
        return;
    }
    let planes = [
        (o.x + o.y, d.x + d.y),
        (o.x - o.y, d.x - d.y),
        (o.x + o.z, d.x + d.z),
        (o.x - o.z, d.x - d.z),
        (o.y + o.z, d.y + d.z),
        (o.y - o.z, d.y - d.z),
        (o.x, d.x),
        (o.y, d.y),
        (o.z, d.z),
    ];
    let mut cuts = [f64::INFINITY; 11];
    cuts[0] = t0;
    let mut n = 1;
    for (p, q) in planes {
        if q.abs() > EPSILON {
            let t = -p / q;
            if t > t0 && t < t1 {
                cuts[n] = t;
                n += 1;
            }
        }
    }
    cuts[n] = t1;
    n += 1;
    cuts[..n].sort_unstable_by(f64::total_cmp);
    let value = |t: f64| superellipsoid_value(s, ray.at(t));
    let mut va = value(cuts[0]);
    // A start on the surface counts as inside or outside by the next piece only.
    if va.abs() < EPSILON {
        sink_at(cuts[0], sink);
        if !all && cuts[0] > 1e-4 {
            return;
        }
    }
    // A norm is convex along the ray (powers below 1 make none): where it rises it has no dip any more, and where it falls beyond a piece
    // the dip is further on.
    let is_convex = s.xy_power >= 1.0 && s.z_power >= 1.0;
    let mut ahead = None;
    for k in 1..n {
        let (a, b) = (cuts[k - 1], cuts[k]);
        let vb = ahead.take().unwrap_or_else(|| value(b));
        if vb.abs() < EPSILON {
            if sink_at(b, sink) && !all {
                return;
            }
        } else if va * vb < 0.0 && va.abs() >= EPSILON {
            if sink_at(refine(&value, a, va, b, vb), sink) && !all {
                return;
            }
        } else if va.abs() < EPSILON && vb > 0.0 && value(a + START_STEP * (b - a)) < 0.0 {
            // From the surface through a corner and out again within one piece.
            let t = a + START_STEP * (b - a);
            if sink_at(refine(&value, t, value(t), b, vb), sink) && !all {
                return;
            }
        } else if va > 0.0 && vb > 0.0 {
            if is_convex && vb < va && k + 1 < n {
                ahead = Some(value(cuts[k + 1]));
            }
            let falls_on = ahead.is_some_and(|v| v < vb);
            if !falls_on && let Some(inner) = dip(&value, a, va, b, vb) {
                let vi = value(inner);
                if vi < 0.0 {
                    let first = sink_at(refine(&value, a, va, inner, vi), sink);
                    if first && !all {
                        return;
                    }
                    if sink_at(refine(&value, inner, vi, b, vb), sink) && !all {
                        return;
                    }
                } else if sink_at(inner, sink) && !all {
                    return;
                }
            }
            if is_convex && vb > va {
                return;
            }
        }
        va = vb;
    }
}

fn sink_at(t: f64, sink: &mut impl HitSink) -> bool {
    let seen = t > 1e-4 && t < MAX_DISTANCE;
    if seen {
        sink.push(t, Part::default());
    }
    seen
}

/// Closes in on a sign change by chords and halvings.
fn refine(f: &impl Fn(f64) -> f64, mut a: f64, mut fa: f64, mut b: f64, mut fb: f64) -> f64 {
    let mut t = a;
    for k in 0..60 {
        t = if k % 3 == 2 { 0.5 * (a + b) } else { a - fa * (b - a) / (fb - fa) };
        let v = f(t);
        if v.abs() < EPSILON || (b - a).abs() < 1e-14 {
            break;
        }
        if (v < 0.0) == (fa < 0.0) { (a, fa) = (t, v) } else { (b, fb) = (t, v) }
    }
    t
}

/// A place where the function dips to the surface or below between two positive ends. It is convex there: within a piece the norm is one.
fn dip(f: &impl Fn(f64) -> f64, a: f64, fa: f64, b: f64, fb: f64) -> Option<f64> {
    // Tangents at both ends of a convex function bound it from below.
    let h = 1e-6 * (b - a);
    let (sa, sb) = ((f(a + h) - fa) / h, (fb - f(b - h)) / h);
    if sa >= 0.0 || sb <= 0.0 {
        return None;
    }
    let (mut lo, mut hi) = (a, b);
    for _ in 0..40 {
        let mid = 0.5 * (lo + hi);
        let v = f(mid);
        if v < EPSILON {
            return Some(mid);
        }
        let step = 1e-6 * (hi - lo);
        let slope = (f(mid + step) - v) / step;
        // Newton from here would have to reach the surface before the other end.
        if slope < 0.0 {
            if v + slope * (hi - mid) > 0.0 {
                return None;
            }
            lo = mid;
        } else {
            if v - slope * (mid - lo) > 0.0 {
                return None;
            }
            hi = mid;
        }
    }
    None
}

/// Gradient of the norm; x where it vanishes.
pub fn superellipsoid_normal(s: &SuperellipsoidShape, p: DVec3) -> DVec3 {
    let q = p.abs();
    let xy = norm(q.x, q.y, s.xy_power);
    let all = norm(xy, q.z, s.z_power);
    if all == 0.0 {
        return DVec3::X;
    }
    let along = |part: f64, whole: f64, power: f64| if whole == 0.0 { 0.0 } else { (part / whole).powf(power - 1.0) };
    let outer = along(xy, all, s.z_power);
    let n = DVec3::new(outer * along(q.x, xy, s.xy_power), outer * along(q.y, xy, s.xy_power), along(q.z, all, s.z_power));
    let n = DVec3::new(n.x * p.x.signum(), n.y * p.y.signum(), n.z * p.z.signum());
    if n == DVec3::ZERO || n.is_nan() { DVec3::X } else { n }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn norms_agree_with_the_library() {
        for p in [0.5, 1.0, 2.0, 2.5, 8.0, 40.0, 40.5, 4000.0] {
            for k in 0..=1000 {
                let (a, b) = (1.3, 1.3 * f64::from(k) / 1000.0);
                let want = a * (1.0 + (b / a).powf(p)).powf(1.0 / p);
                let got = norm(b, a, p);
                assert!((got - want).abs() < 4e-15 * want, "({a}, {b}) to {p}: {got}, not {want}");
            }
        }
    }

    /// All hits along a ray, by a search of a thousand steps and bisection.
    fn sampled(s: &SuperellipsoidShape, ray: &LocalRay) -> Vec<f64> {
        let f = |t: f64| superellipsoid_value(s, ray.at(t));
        let step = 8.0 / 4000.0;
        let mut out = Vec::new();
        for k in 0..4000 {
            let (mut a, mut b) = (f64::from(k) * step, f64::from(k + 1) * step);
            if (f(a) < 0.0) != (f(b) < 0.0) {
                while b - a > 1e-12 {
                    let mid = 0.5 * (a + b);
                    if (f(mid) < 0.0) == (f(a) < 0.0) { a = mid } else { b = mid }
                }
                out.push(a);
            }
        }
        out
    }

    struct All(Vec<f64>);

    impl HitSink for All {
        fn push(&mut self, t: f64, _: Part) {
            self.0.push(t);
        }
        fn far(&self) -> f64 {
            f64::INFINITY
        }
    }

    #[test]
    fn superellipsoids_are_hit_where_a_fine_search_finds_them() {
        for (xy_power, z_power) in [(40.0, 40.0), (2.0, 2.0), (8.0, 1.0), (0.8, 2.5), (4.0, 0.9)] {
            let s = SuperellipsoidShape { xy_power, z_power };
            for k in 0..300 {
                let k = f64::from(k);
                let origin = DVec3::new((k * 0.7).sin(), (k * 1.3).cos(), (k * 0.31).sin()).normalize() * 3.0;
                let target = DVec3::new((k * 2.1).cos(), (k * 0.9).sin(), (k * 1.7).cos()) * 0.9;
                let ray = LocalRay { origin, dir: (target - origin).normalize(), scale: 1.0 };
                let mut all = All(Vec::new());
                intersect_superellipsoid(&s, &ray, true, &mut all);
                all.0.sort_by(f64::total_cmp);
                let want = sampled(&s, &ray);
                for t in &want {
                    assert!(all.0.iter().any(|h| (h - t).abs() < 1e-6), "({xy_power}, {z_power}), ray {k}: {:?}, not {want:?}", all.0);
                }
            }
        }
    }
}
