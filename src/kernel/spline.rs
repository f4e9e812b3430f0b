//! Values of splines. Source: spec/objects.md, section 17 (all measured).

use crate::compile::spline::natural;
use crate::compile::texture::{Knot, SplineNode, TextureTables};
use crate::scene::Spline;
use crate::scene::spline::SplineKind;

/// A compiled spline's value.
pub fn eval_spline_node(tables: &TextureTables, s: &SplineNode, t: f64) -> [f64; 5] {
    let knots = s.knots.of(&tables.knots);
    eval(knots.len(), |k| knots[k], s.kind, t)
}

/// A scene spline's value; `kind` overrides its own.
pub fn eval_spline(s: &Spline, t: f64, kind: Option<SplineKind>) -> [f64; 5] {
    let kind = kind.unwrap_or(s.kind);
    // Natural splines solve for the whole curve; inside its range only.
    let inside = s.knots.first().zip(s.knots.last()).is_some_and(|(a, b)| t > a.0 && t < b.0);
    let second = if kind == SplineKind::Natural && inside { natural(&s.knots) } else { Vec::new() };
    let knot = |k: usize| Knot { t: s.knots[k].0, value: s.knots[k].1, second: second.get(k).copied().unwrap_or([0.0; 5]) };
    eval(s.knots.len(), knot, kind, t)
}

fn eval(n: usize, knot: impl Fn(usize) -> Knot, kind: SplineKind, t: f64) -> [f64; 5] {
    if n == 0 {
        return [0.0; 5];
    }
    let (first, last) = (knot(0), knot(n - 1));
    if n == 1 || t.is_nan() {
        return first.value;
    }
    if kind == SplineKind::Cubic {
        return cubic(n, knot, t);
    }
    if t <= first.t {
        return first.value;
    }
    if t >= last.t {
        return last.value;
    }
    let i = interval(n, &knot, t);
    let (a, b) = (knot(i), knot(i + 1));
    let u = (t - a.t) / (b.t - a.t);
    let linear = |c: usize| a.value[c] * (1.0 - u) + b.value[c] * u;
    match kind {
        SplineKind::Quadratic if n > 2 => {
            let k = [knot(i.max(1) - 1), knot(i.max(1)), knot(i.max(1) + 1)];
            let w = [0, 1, 2].map(|j: usize| {
                let (l, r) = ((j + 1) % 3, (j + 2) % 3);
                (t - k[l].t) * (t - k[r].t) / ((k[j].t - k[l].t) * (k[j].t - k[r].t))
            });
            std::array::from_fn(|c| w[0] * k[0].value[c] + w[1] * k[1].value[c] + w[2] * k[2].value[c])
        }
        SplineKind::Natural => {
            let h = b.t - a.t;
            let (v, u2) = (1.0 - u, u);
            std::array::from_fn(|c| linear(c) + h * h / 6.0 * ((v * v * v - v) * a.second[c] + (u2 * u2 * u2 - u2) * b.second[c]))
        }
        _ => std::array::from_fn(linear),
    }
}

/// The interval `i..i + 1` that `t` lies in; `t` is inside the range.
fn interval(n: usize, knot: &impl Fn(usize) -> Knot, t: f64) -> usize {
    let (mut lo, mut hi) = (0, n - 1);
    while hi - lo > 1 {
        let mid = (lo + hi) / 2;
        if knot(mid).t <= t { lo = mid } else { hi = mid }
    }
    lo
}

/// Hermite with mean secants as slopes, between the second and the last but one knot.
fn cubic(n: usize, knot: impl Fn(usize) -> Knot, t: f64) -> [f64; 5] {
    let (second, last) = (knot(1), knot(n - 2));
    if n == 2 {
        return std::array::from_fn(|c| (knot(0).value[c] + knot(1).value[c]) / 2.0);
    }
    if t <= second.t {
        return second.value;
    }
    if t >= last.t {
        return last.value;
    }
    let i = interval(n, &knot, t);
    let (z, a, b, e) = (knot(i - 1), knot(i), knot(i + 1), knot(i + 2));
    let h = b.t - a.t;
    let u = (t - a.t) / h;
    std::array::from_fn(|c| {
        let secant = |p: &Knot, q: &Knot| (q.value[c] - p.value[c]) / (q.t - p.t);
        let (da, db) = (h * (secant(&z, &a) + secant(&a, &b)) / 2.0, h * (secant(&a, &b) + secant(&b, &e)) / 2.0);
        let (u2, u3) = (u * u, u * u * u);
        a.value[c] * (2.0 * u3 - 3.0 * u2 + 1.0) + b.value[c] * (3.0 * u2 - 2.0 * u3) + da * (u3 - 2.0 * u2 + u) + db * (u3 - u2)
    })
}
