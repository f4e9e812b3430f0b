//! Roots of polynomials between 0 and 1, by the sign changes of Bernstein coefficients (Lane and Riesenfeld 1981).
//! Several times as fast as Sturm chains where the interval is known.

use super::roots::Roots;

/// Most coefficients.
const N: usize = 12;
/// Halvings after which a piece that may still hold two roots counts as one double root.
const MAX_DEPTH: u32 = 40;

/// All roots in 0..=1 of the polynomial with coefficients `c`, highest power first, order at most 11. Double roots come once, twice or
/// (where rounding lifts them off zero) not at all.
pub fn roots_in_unit(c: &[f64]) -> Roots {
    let mut out = Roots::default();
    let n = c.len();
    if !(2..=N).contains(&n) || !c.iter().all(|v| v.is_finite()) {
        return out;
    }
    let mut b = [0.0; N];
    // Power basis to Bernstein: b_k = sum over j <= k of C(k, j) / C(order, j) a_j, built by repeated sums.
    let order = n - 1;
    let mut choose = 1.0;
    for j in 0..n {
        b[j] = c[order - j] / choose;
        choose = choose * (order - j) as f64 / (j + 1) as f64;
    }
    for j in 1..n {
        for k in (j..n).rev() {
            b[k] += b[k - 1];
        }
    }
    search(c, &b, 0.0, 1.0, 0, &mut out);
    // A root at the end of the interval changes no sign.
    if b[order] == 0.0 && b[..order].iter().any(|v| *v != 0.0) {
        out.add(1.0);
    }
    out
}

/// Roots of `c` between `low` and `high`, where its Bernstein coefficients are `b`.
fn search(c: &[f64], b: &[f64; N], low: f64, high: f64, depth: u32, out: &mut Roots) {
    let n = c.len();
    let mut changes = 0;
    let mut last = 0.0;
    for v in &b[..n] {
        if *v != 0.0 {
            if last * v < 0.0 {
                changes += 1;
            }
            last = v.signum();
        }
    }
    if b[0] == 0.0 && changes == 0 {
        if last != 0.0 {
            out.add(low);
        }
        return;
    }
    if changes == 0 {
        return;
    }
    if changes == 1 && b[0] * b[n - 1] < 0.0 {
        out.add(bracketed(c, low, b[0], high, b[n - 1]));
        return;
    }
    if depth >= MAX_DEPTH {
        out.add(0.5 * (low + high));
        return;
    }
    // de Casteljau at the middle.
    let (mut left, mut right) = ([0.0; N], *b);
    for k in 0..n {
        left[k] = right[0];
        for j in 0..n - 1 - k {
            right[j] = 0.5 * (right[j] + right[j + 1]);
        }
    }
    // What is left in `right`, first to last, is the right half's coefficients.
    let mid = 0.5 * (low + high);
    search(c, &left, low, mid, depth + 1, out);
    search(c, &right, mid, high, depth + 1, out);
}

/// The one root between ends of different sign (Illinois, with halvings).
fn bracketed(c: &[f64], mut x0: f64, mut f0: f64, mut x1: f64, mut f1: f64) -> f64 {
    let mut side = 0;
    let mut x = x0;
    for k in 0..100 {
        x = if k % 4 == 3 { 0.5 * (x0 + x1) } else { (f0 * x1 - f1 * x0) / (f0 - f1) };
        let f = c.iter().fold(0.0, |v, a| v * x + a);
        if f == 0.0 || x1 - x0 < 1e-15 {
            return x;
        }
        let before = x1 - x0;
        if f * f0 < 0.0 {
            (x1, f1) = (x, f);
            if side == 1 {
                f0 *= 0.5;
            }
            side = 1;
        } else {
            (x0, f0) = (x, f);
            if side == 2 {
                f1 *= 0.5;
            }
            side = 2;
        }
        // A half of the last bit: nothing is left to gain. (Other steps may be short at first, from an end that is nearly a root.)
        if k % 4 == 3 && x1 - x0 == before {
            break;
        }
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    fn poly(roots: &[f64]) -> Vec<f64> {
        roots.iter().fold(vec![1.0], |c, r| {
            let mut n = c.clone();
            n.push(0.0);
            c.iter().enumerate().for_each(|(k, v)| n[k + 1] -= v * r);
            n
        })
    }

    #[test]
    fn roots_inside_the_interval_are_found_and_others_are_not() {
        let c = poly(&[-0.3, 0.1, 0.2500001, 0.5, 0.75, 0.99, 1.2, 3.0]);
        let mut got = roots_in_unit(&c).to_vec();
        got.sort_by(f64::total_cmp);
        let want = [0.1, 0.2500001, 0.5, 0.75, 0.99];
        assert_eq!(got.len(), want.len(), "{got:?}");
        got.iter().zip(want).for_each(|(g, w)| assert!((g - w).abs() < 1e-9, "{got:?}"));
    }

    #[test]
    fn ends_and_double_roots_count_once() {
        assert_eq!(roots_in_unit(&poly(&[0.0, 1.0])).to_vec().len(), 2);
        // Exactly representable; in general rounding decides whether a double root is none or two.
        let double = roots_in_unit(&poly(&[0.25, 0.25]));
        assert!(double.len() == 1 && (double[0] - 0.25).abs() < 1e-6, "{:?}", &*double);
        assert!(roots_in_unit(&[1.0, 0.0, 1.0]).is_empty() && roots_in_unit(&[0.0, 0.0]).is_empty());
    }

    /// Rays that start on a surface: the value there is rounding, and the first steps from it are too short to be seen in the bracket's length.
    #[test]
    fn roots_behind_a_start_that_is_nearly_one_are_found() {
        for nearly in [-1e-17, -3e-16, 1e-17] {
            let c = [33.999_662_323, 22.738_283_317, -10.301_665_137, nearly];
            let got = roots_in_unit(&c).to_vec();
            let want = (-22.738_283_317 + f64::sqrt(22.738_283_317 * 22.738_283_317 + 4.0 * 33.999_662_323 * 10.301_665_137))
                / (2.0 * 33.999_662_323);
            assert!(got.iter().any(|g| (g - want).abs() < 1e-9), "{nearly}: {got:?}, not {want}");
        }
    }

    #[test]
    fn zero_leading_coefficients_do_no_harm() {
        let got = roots_in_unit(&[0.0, 0.0, 2.0, -1.0]);
        assert!(got.len() == 1 && (got[0] - 0.5).abs() < 1e-15);
    }
}
