//! Real roots of polynomials, with POV-Ray's rules for what counts as a root: they decide silhouettes. Source: spec/objects.md, section 1.
//!
//! Coefficients stand from the highest power down. NaN coefficients give no roots.

/// Highest order that is solved.
pub const MAX_ORDER: usize = 35;

/// Roots found, not sorted.
#[derive(Clone, Copy, Debug)]
pub struct Roots {
    items: [f64; MAX_ORDER],
    len: usize,
}

impl Default for Roots {
    fn default() -> Self {
        Self { items: [0.0; MAX_ORDER], len: 0 }
    }
}

impl Roots {
    /// Adds a root; what is beyond [`MAX_ORDER`] is dropped.
    pub(super) fn add(&mut self, r: f64) {
        if self.len < MAX_ORDER {
            self.items[self.len] = r;
            self.len += 1;
        }
    }

    fn of(list: &[f64]) -> Self {
        let mut r = Self::default();
        list.iter().for_each(|v| r.add(*v));
        r
    }
}

impl std::ops::Deref for Roots {
    type Target = [f64];
    fn deref(&self) -> &[f64] {
        &self.items[..self.len]
    }
}

/// Coefficients below this leave the front of the polynomial.
const LEADING_EPSILON: f64 = 1e-10;
/// Quartics whose coefficients span more than this go to the Sturm solver.
const DIFFICULT_RATIO: f64 = 1e12;
/// Sturm chains look for roots from 0 to this.
const STURM_FAR: f64 = 1e7;

/// Roots of the polynomial `c`; `sturm` asks for Sturm chains, a `tolerance` above 0 lets a root near 0 be divided out.
pub fn solve_polynomial(c: &[f64], sturm: bool, tolerance: f64) -> Roots {
    solve_polynomial_to(c, sturm, tolerance, STURM_FAR)
}

/// As [`solve_polynomial`]; Sturm chains look for roots from 0 to `far` only.
pub fn solve_polynomial_to(c: &[f64], sturm: bool, tolerance: f64, far: f64) -> Roots {
    let lead = c.iter().take(c.len().saturating_sub(1)).take_while(|v| v.abs() < LEADING_EPSILON).count();
    let c = &c[lead..];
    // A last coefficient that is small beside the one before it is a root near 0.
    let near_zero = |c: &[f64]| {
        let (last, before) = (c[c.len() - 1], c[c.len() - 2]);
        tolerance > 0.0 && before.abs() > LEADING_EPSILON && (last / before).abs() < tolerance
    };
    match c.len() {
        0 | 1 => Roots::default(),
        2 => Roots::of(&[-c[1] / c[0]]),
        3 => solve_quadratic(c[0], c[1], c[2]),
        4 if near_zero(c) => solve_quadratic(c[0], c[1], c[2]),
        4 if sturm => solve_sturm(c, far),
        4 => solve_cubic(c[0], c[1], c[2], c[3]),
        5 if near_zero(c) => {
            if sturm {
                solve_sturm(&c[..4], far)
            } else {
                solve_cubic(c[0], c[1], c[2], c[3])
            }
        }
        5 if sturm || is_difficult(c) => solve_sturm(c, far),
        5 => solve_quartic(c[0], c[1], c[2], c[3], c[4]),
        _ if near_zero(c) => solve_sturm(&c[..c.len() - 1], far),
        _ => solve_sturm(c, far),
    }
}

fn is_difficult(c: &[f64]) -> bool {
    let largest = c.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    c.iter().any(|v| *v != 0.0 && largest / v.abs() > DIFFICULT_RATIO)
}

/// Both roots of a x² + b x + c; one when the discriminant is nearly 0.
pub fn solve_quadratic(a: f64, b: f64, c: f64) -> Roots {
    if a == 0.0 {
        return if b == 0.0 { Roots::default() } else { Roots::of(&[-c / b]) };
    }
    let (b, c) = (-b / a, c / a);
    let d = b * b - 4.0 * c;
    if d > -LEADING_EPSILON && d < LEADING_EPSILON {
        Roots::of(&[0.5 * b])
    } else if d < 0.0 || d.is_nan() {
        Roots::default()
    } else {
        let d = d.sqrt();
        Roots::of(&[0.5 * (b + d), 0.5 * (b - d)])
    }
}

/// Roots of a x³ + b x² + c x + d: one, or three (repeated ones counted again).
pub fn solve_cubic(a: f64, b: f64, c: f64, d: f64) -> Roots {
    if a == 0.0 {
        return solve_quadratic(b, c, d);
    }
    let (a1, a2, a3) = if a == 1.0 { (b, c, d) } else { (b / a, c / a, d / a) };
    let a_sq = a1 * a1;
    let q = (a_sq - 3.0 * a2) / 9.0;
    let r = (a1 * (a_sq - 4.5 * a2) + 13.5 * a3) / 27.0;
    let q_cubed = q * q * q;
    let d = q_cubed - r * r;
    let third = a1 / 3.0;
    if d >= 0.0 {
        let theta = (r / q_cubed.sqrt()).clamp(-1.0, 1.0).acos() / 3.0;
        if theta.is_nan() {
            // q = 0: a threefold root.
            return Roots::of(&[-third]);
        }
        let s = -2.0 * q.sqrt();
        let turn = std::f64::consts::TAU / 3.0;
        Roots::of(&[s * theta.cos() - third, s * (theta + turn).cos() - third, s * (theta + 2.0 * turn).cos() - third])
    } else if d < 0.0 {
        let s = cube_root((-d).sqrt() + r.abs());
        Roots::of(&[if r < 0.0 { s + q / s } else { -(s + q / s) } - third])
    } else {
        Roots::default()
    }
}

/// Cube root of a number that is not negative, within a few roundings: the library's takes pains for the last one (three Halley steps from
/// an exponent divided by three; each triples the number of right bits, 5 at first).
fn cube_root(x: f64) -> f64 {
    if !(x > f64::MIN_POSITIVE && x < f64::MAX) {
        return x.cbrt();
    }
    let mut y = f64::from_bits(x.to_bits() / 3 + 0x2A9F_7893_0000_0000);
    for _ in 0..3 {
        let cube = y * y * y;
        y *= (cube + 2.0 * x) / (2.0 * cube + x);
    }
    y
}

/// Roots of a x⁴ + b x³ + c x² + d x + e.
pub fn solve_quartic(a: f64, b: f64, c: f64, d: f64, e: f64) -> Roots {
    let (c1, c2, c3, c4) = if a == 1.0 { (b, c, d, e) } else { (b / a, c / a, d / a, e / a) };
    // Depressed quartic y⁴ + p y² + q y + r with x = y - c1/4.
    let c12 = c1 * c1;
    let p = -0.375 * c12 + c2;
    let q = 0.125 * c12 * c1 - 0.5 * c1 * c2 + c3;
    let r = -0.01171875 * c12 * c12 + 0.0625 * c12 * c2 - 0.25 * c1 * c3 + c4;
    // Any root z of the resolvent cubic splits it in two quadratics.
    let resolvent = solve_cubic(1.0, -0.5 * p, -r, 0.5 * r * p - 0.125 * q * q);
    let Some(&z) = resolvent.first() else { return Roots::default() };
    let mut d1 = 2.0 * z - p;
    let d2;
    if d1 < 0.0 {
        if d1 < -LEADING_EPSILON {
            return Roots::default();
        }
        d1 = 0.0;
    }
    if d1 < LEADING_EPSILON {
        let s = z * z - r;
        if s.is_nan() || s < 0.0 {
            return Roots::default();
        }
        d2 = s.sqrt();
    } else {
        d1 = d1.sqrt();
        d2 = 0.5 * q / d1;
    }
    let q1 = d1 * d1;
    let shift = -0.25 * c1;
    let mut out = Roots::default();
    let mut half = |p: f64, side: f64| {
        if p == 0.0 {
            // POV-Ray's sign slip for exact double roots is kept: it moves specks that pictures show.
            out.add(0.5 * side * d1 - shift);
        } else if p > 0.0 {
            let p = p.sqrt();
            out.add(0.5 * (side * d1 + p) + shift);
            out.add(0.5 * (side * d1 - p) + shift);
        }
    };
    half(q1 - 4.0 * (z - d2), -1.0);
    half(q1 - 4.0 * (z + d2), 1.0);
    out
}

/// A polynomial of the Sturm chain, from the highest power down.
#[derive(Clone, Copy)]
struct Term<const N: usize> {
    c: [f64; N],
    order: usize,
}

impl<const N: usize> Term<N> {
    const ZERO: Self = Self { c: [0.0; N], order: 0 };

    fn eval(&self, x: f64) -> f64 {
        self.c[..=self.order].iter().fold(0.0, |v, c| v * x + c)
    }

    /// The one root in `low..=high` after steps of Newton's method, as long as they bring the value nearer to 0.
    fn polished(&self, mut x: f64, low: f64, high: f64) -> f64 {
        for _ in 0..3 {
            let (mut value, mut slope) = (0.0, 0.0);
            for c in &self.c[..=self.order] {
                slope = slope * x + value;
                value = value * x + c;
            }
            let next = x - value / slope;
            if !((low..=high).contains(&next) && self.eval(next).abs() < value.abs()) {
                break;
            }
            x = next;
        }
        x
    }
}

/// Roots between 0 and `far`, each once, by counting sign changes of a Sturm chain and closing in on every root.
pub fn solve_sturm(c: &[f64], far: f64) -> Roots {
    let order = c.len().saturating_sub(1).min(MAX_ORDER);
    if order == 0 || !c.iter().all(|v| v.is_finite()) || c[0] == 0.0 {
        return Roots::default();
    }
    if order < 8 {
        sturm::<8>(c, order, far)
    } else if order < 12 {
        sturm::<12>(c, order, far)
    } else {
        sturm::<{ MAX_ORDER + 1 }>(c, order, far)
    }
}

fn sturm<const N: usize>(c: &[f64], order: usize, far: f64) -> Roots {
    let mut out = Roots::default();
    let mut chain = [Term::<N>::ZERO; N];
    chain[0].order = order;
    chain[0].c.iter_mut().zip(c).for_each(|(a, b)| *a = b / c[0]);
    chain[1].order = order - 1;
    // The derivative, scaled to a leading 1; positive factors leave signs alone.
    for k in 0..order {
        chain[1].c[k] = chain[0].c[k] * (order - k) as f64 / order as f64;
    }
    let mut n = 2;
    while chain[n - 1].order > 0 && n < N {
        match negative_remainder(&chain[n - 2], &chain[n - 1]) {
            Some(r) => chain[n] = r,
            None => break,
        }
        n += 1;
    }
    let chain = &chain[..n];
    let changes = |x: f64| {
        let (mut n, mut last) = (0usize, 0.0);
        for t in chain {
            let v = t.eval(x);
            if v != 0.0 {
                if last * v < 0.0 {
                    n += 1;
                }
                last = v.signum();
            }
        }
        n
    };
    let (at_low, at_high) = (changes(0.0), changes(far));
    if at_low > at_high {
        isolate(&chain[0], &changes, 0.0, far, at_low, at_high, &mut out, 0);
    }
    out
}

/// -(u mod v), scaled so that its leading coefficient is ±1; `None` when nothing is left.
fn negative_remainder<const N: usize>(u: &Term<N>, v: &Term<N>) -> Option<Term<N>> {
    let mut w = *u;
    let mut at = 0;
    // v leads with ±1.
    while u.order - at >= v.order {
        let f = w.c[at] / v.c[0];
        for k in 0..=v.order {
            w.c[at + k] -= f * v.c[k];
        }
        at += 1;
        if at > u.order {
            return None;
        }
    }
    while at <= u.order && w.c[at].abs() < 1e-12 {
        at += 1;
    }
    if at > u.order {
        return None;
    }
    let mut r = Term { c: [0.0; N], order: u.order - at };
    let scale = -1.0 / w.c[at].abs();
    for k in 0..=r.order {
        r.c[k] = w.c[at + k] * scale;
    }
    Some(r)
}

/// Bisects until every interval holds one root.
fn isolate<const N: usize>(
    p: &Term<N>,
    changes: &impl Fn(f64) -> usize,
    low: f64,
    high: f64,
    n_low: usize,
    n_high: usize,
    out: &mut Roots,
    depth: u32,
) {
    let n = n_low.saturating_sub(n_high);
    if n == 0 {
        return;
    }
    let mid = 0.5 * (low + high);
    if n == 1 {
        match regula_falsi(p, low, high) {
            Some(x) => out.add(p.polished(x, low, high)),
            None => {
                // No sign change (a double root): close in by counting.
                let (mut low, mut high) = (low, high);
                for _ in 0..65 {
                    let mid = 0.5 * (low + high);
                    let n_mid = changes(mid);
                    if (high - low) <= 1e-12 * mid.abs().max(1e-12) {
                        break;
                    }
                    if n_low.saturating_sub(n_mid) == 0 { low = mid } else { high = mid }
                }
                out.add(0.5 * (low + high));
            }
        }
        return;
    }
    if depth > 64 || (high - low) < 1e-12 * mid.abs().max(1e-12) {
        out.add(mid);
        return;
    }
    let n_mid = changes(mid);
    isolate(p, changes, low, mid, n_low, n_mid, out, depth + 1);
    isolate(p, changes, mid, high, n_mid, n_high, out, depth + 1);
}

/// The root between `a` and `b`, where the signs differ.
fn regula_falsi<const N: usize>(p: &Term<N>, mut a: f64, mut b: f64) -> Option<f64> {
    let (mut fa, mut fb) = (p.eval(a), p.eval(b));
    if fa == 0.0 {
        return Some(a);
    }
    if fb == 0.0 {
        return Some(b);
    }
    if fa * fb > 0.0 {
        return None;
    }
    let mut last = fa;
    // Wide intervals make the chord useless: halve them first.
    for k in 0..200 {
        let x = if k % 4 == 3 || (b - a) > 1.0 { 0.5 * (a + b) } else { (fb * a - fa * b) / (fb - fa) };
        let fx = p.eval(x);
        if fx == 0.0 || (b - a).abs() < 1e-12 * x.abs().max(1e-3) {
            return Some(x);
        }
        if fa * fx < 0.0 {
            b = x;
            fb = fx;
            if last * fx > 0.0 {
                fa *= 0.5;
            }
        } else {
            a = x;
            fa = fx;
            if last * fx > 0.0 {
                fb *= 0.5;
            }
        }
        last = fx;
    }
    Some(0.5 * (a + b))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sorted(r: &Roots) -> Vec<f64> {
        let mut v = r.to_vec();
        v.sort_by(f64::total_cmp);
        v
    }

    fn poly(roots: &[f64]) -> Vec<f64> {
        roots.iter().fold(vec![1.0], |c, r| {
            let mut n = c.clone();
            n.push(0.0);
            c.iter().enumerate().for_each(|(k, v)| n[k + 1] -= v * r);
            n
        })
    }

    #[test]
    fn every_order_finds_its_roots() {
        for n in 1..=7usize {
            let want: Vec<f64> = (0..n).map(|k| 0.5 + 1.25 * k as f64).collect();
            for sturm in [false, true] {
                let got = sorted(&solve_polynomial(&poly(&want), sturm, 0.0));
                assert_eq!(got.len(), n, "order {n}, sturm {sturm}: {got:?}");
                got.iter().zip(&want).for_each(|(g, w)| assert!((g - w).abs() < 1e-7, "{g} is not {w} (order {n}, sturm {sturm})"));
            }
        }
    }

    #[test]
    fn quadratic_with_tiny_discriminant_has_one_root() {
        assert_eq!(solve_quadratic(1.0, -2.0, 1.0 - 1e-12).len(), 1);
        assert_eq!(solve_quadratic(1.0, -2.0, 1.1).len(), 0);
    }

    #[test]
    fn quartic_without_real_roots_has_none() {
        assert!(solve_quartic(1.0, 0.0, 2.0, 0.0, 1.5).is_empty());
        assert!(solve_sturm(&[1.0, 0.0, 2.0, 0.0, 1.5], 1e7).is_empty());
    }

    #[test]
    fn root_near_zero_is_divided_out_only_with_a_tolerance() {
        let c = poly(&[1e-6, 2.0, 3.0]);
        assert_eq!(solve_polynomial(&c, false, 1e-4).len(), 2);
        assert_eq!(solve_polynomial(&c, false, 0.0).len(), 3);
    }

    #[test]
    fn cube_roots_are_exact_to_a_few_roundings() {
        for k in -300..300 {
            let x = 1.37 * 10f64.powi(k);
            assert!((cube_root(x) / x.cbrt() - 1.0).abs() < 1e-15, "{x:e}");
        }
        assert_eq!(cube_root(0.0), 0.0);
    }

    #[test]
    fn degenerate_input_gives_no_roots() {
        assert!(solve_polynomial(&[f64::NAN; 5], false, 0.0).is_empty());
        assert!(solve_polynomial(&[0.0; 5], false, 0.0).is_empty());
        assert!(solve_polynomial(&[], false, 0.0).is_empty());
    }
}
