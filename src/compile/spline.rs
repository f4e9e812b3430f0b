//! Natural splines: the second derivatives at the knots. Evaluation stands in `kernel/spline.rs`.

use crate::scene::Spline;
use crate::scene::spline::SplineKind;

/// Second derivatives by the parameter at every knot of a natural spline (zeros for other kinds).
///
/// Solves the usual tridiagonal system with nothing at both ends. Source: spec/objects.md, section 17 (measured: plain C2 cubic).
pub fn second_derivatives(s: &Spline) -> Vec<[f64; 5]> {
    if s.kind == SplineKind::Natural { natural(&s.knots) } else { vec![[0.0; 5]; s.knots.len()] }
}

/// The same whatever the spline's own kind is.
pub fn natural(knots: &[(f64, [f64; 5])]) -> Vec<[f64; 5]> {
    let n = knots.len();
    let mut second = vec![[0.0; 5]; n];
    if n < 3 {
        return second;
    }
    // Thomas algorithm: `upper` is the eliminated superdiagonal.
    let mut upper = vec![0.0; n];
    for k in 1..n - 1 {
        let (h0, h1) = (knots[k].0 - knots[k - 1].0, knots[k + 1].0 - knots[k].0);
        let pivot = 2.0 * (h0 + h1) - h0 * upper[k - 1];
        upper[k] = h1 / pivot;
        for c in 0..5 {
            let (a, b, d) = (knots[k - 1].1[c], knots[k].1[c], knots[k + 1].1[c]);
            let right = 6.0 * ((d - b) / h1 - (b - a) / h0);
            second[k][c] = (right - h0 * second[k - 1][c]) / pivot;
        }
    }
    for k in (1..n - 1).rev() {
        for c in 0..5 {
            second[k][c] -= upper[k] * second[k + 1][c];
        }
    }
    second
}
