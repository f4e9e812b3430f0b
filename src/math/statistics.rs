//! The one piece of statistics that rendering asks for: points of the chi-square distribution, for POV-Ray's stop rules.

/// The value that a chi-square variable with `df` degrees of freedom exceeds with probability `upper_tail`.
///
/// `upper_tail` is clamped to 1e-9..=1-1e-9, `df` to at least 1. Source: spec/light.md, sections 7 and 11 (there X(df)).
pub fn chi_square_point(upper_tail: f64, df: u32) -> f64 {
    let (p, a) = (1.0 - upper_tail.clamp(1e-9, 1.0 - 1e-9), 0.5 * f64::from(df.max(1)));
    let (mut low, mut high) = (0.0, 2.0 * a + 10.0);
    while lower_gamma(a, high) < p {
        high *= 2.0;
    }
    // Bisection: called once a render, sure for every df.
    for _ in 0..100 {
        let mid = 0.5 * (low + high);
        if lower_gamma(a, mid) < p { low = mid } else { high = mid }
    }
    low + high
}

/// Regularised lower incomplete gamma function P(a, x).
fn lower_gamma(a: f64, x: f64) -> f64 {
    if x <= 0.0 {
        return 0.0;
    }
    let front = (a * x.ln() - x - ln_gamma(a)).exp();
    if x < a + 1.0 {
        let (mut term, mut sum) = (1.0 / a, 1.0 / a);
        for n in 1..10_000 {
            term *= x / (a + f64::from(n));
            sum += term;
            if term < sum * 1e-16 {
                break;
            }
        }
        return front * sum;
    }
    // Lentz's continued fraction of the upper function.
    let (mut b, mut c) = (x + 1.0 - a, 1e300);
    let mut d = 1.0 / b;
    let mut h = d;
    for n in 1..10_000 {
        let an = -f64::from(n) * (f64::from(n) - a);
        b += 2.0;
        d = 1.0 / (an * d + b);
        c = b + an / c;
        h *= d * c;
        if (d * c - 1.0).abs() < 1e-15 {
            break;
        }
    }
    1.0 - front * h
}

/// Logarithm of the gamma function of an integer or half-integer.
fn ln_gamma(a: f64) -> f64 {
    let mut sum = if a.fract() == 0.0 { 0.0 } else { 0.5 * std::f64::consts::PI.ln() };
    let mut k = a;
    while k > 1.0 {
        k -= 1.0;
        sum += k.ln();
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chi_square_points_agree_with_tables() {
        // Abramowitz and Stegun, table 26.8.
        for (df, tail, want) in [(1, 0.9, 0.015_790_8), (2, 0.9, 0.210_721), (9, 0.9, 4.168_16), (10, 0.05, 18.3070), (100, 0.9, 82.3581)] {
            let got = chi_square_point(tail, df);
            assert!((got / want - 1.0).abs() < 1e-4, "{df} {tail}: {got}");
        }
    }
}
