//! Cases 15 and 16: roots of quartics, from afar and in their worst constellations.

use super::figures::{Report, largest, scene, total, worst_of};
use super::peers::PovHit;
use crate::kernel::traverse::intersect;
use crate::math::random::SplitMix64;
use crate::math::roots::{solve_polynomial, solve_quartic};
use crate::math::{DVec3, Ray};

const FAR: f64 = 1e12;
const MAJOR: f64 = 1.0;
const MINOR: f64 = 0.25;

/// Distance of `p` from the torus, to first order exact: the tube's circle in the plane of the axis.
fn torus_distance(p: DVec3) -> f64 {
    (p.x.hypot(p.z) - MAJOR).hypot(p.y) - MINOR
}

/// A point of the torus and its normal.
fn torus_point(r: &mut SplitMix64) -> (DVec3, DVec3) {
    let (u, v) = (std::f64::consts::TAU * r.unit(), std::f64::consts::TAU * r.unit());
    let n = DVec3::new(v.cos() * u.cos(), v.sin(), v.cos() * u.sin());
    (DVec3::new(MAJOR * u.cos(), 0.0, MAJOR * u.sin()) + MINOR * n, n)
}

pub(super) fn far_torus(report: &mut Report) {
    const TORUS: &str = "torus { 1, 0.25 }";
    let scene = scene(&format!("object {{ {TORUS} pigment {{ rgb 1 }} }}"));
    let n = report.rays(60);
    for exponent in 0..=6 {
        let distance = 3.0 * 10f64.powi(exponent);
        // With how far away the point that it passes through is.
        let aim = |r: &mut SplitMix64| {
            let (p, normal) = torus_point(r);
            // Every third ray grazes: it runs along the tangent plane, a thousandth of the tube's radius below.
            let grazing = r.below(3) == 0;
            let toward = if grazing { normal.cross(r.direction()).normalize() } else { r.direction() };
            let to = if grazing { p - 1e-3 * MINOR * normal } else { p };
            let eye = to + distance * toward;
            (Ray::new(eye, (to - eye).normalize()), (to - eye).length())
        };
        let residual = |point: Option<DVec3>| point.map_or(0.0, |p| torus_distance(p).abs());
        // The ray passes through a point on or in the tube: something is met no later than there.
        let is_lost = |depth: Option<f64>, to: f64| !depth.is_some_and(|t| t <= to + 1e-6);
        let cast = |ray: &Ray| intersect(&scene, ray, 0.0, FAR, 0);
        let far_off = format!("largest distance of a hit from the torus, from {distance:.0}");
        let lost = format!("roots lost, from {distance:.0}");
        report.cpu(&far_off, largest(n, 16, |r| residual(cast(&aim(r).0).map(|h| h.point))), 1e-6 * MAJOR, n);
        let n_lost = total(n, 17, |r| {
            let (ray, to) = aim(r);
            u64::from(is_lost(cast(&ray).map(|h| h.t), to))
        });
        report.cpu(&lost, n_lost as f64, 0.0, n);
        for (kind, text) in [("", TORUS), (", sturm", "torus { 1, 0.25 sturm }")] {
            let Some(traced) = report.povray(text, n, 17, aim) else { continue };
            let of = traced.len() as u64;
            report.povray_figure(format!("{far_off}{kind}"), worst_of(traced.iter().map(|(_, _, hit)| residual(hit.map(|h| h.point)))), of);
            let depth = |ray: &Ray, hit: &Option<PovHit>| hit.map(|h| (h.point - ray.origin).length());
            let n_lost = traced.iter().filter(|(ray, to, hit)| is_lost(depth(ray, hit), *to)).count();
            report.povray_figure(format!("{lost}{kind}"), n_lost as f64, of);
        }
    }
}

/// Coefficients, from the highest power down, of the polynomial with these roots.
fn expanded(roots: [f64; 4]) -> [f64; 5] {
    let mut c = [1.0, 0.0, 0.0, 0.0, 0.0];
    for (k, root) in roots.into_iter().enumerate() {
        for j in (1..=k + 1).rev() {
            c[j] -= root * c[j - 1];
        }
    }
    c
}

/// What of the coefficients would have to change for `x` to be a root, as a share of them.
fn backward_error(c: &[f64; 5], x: f64) -> f64 {
    // Twice the precision: each product's error is kept beside it (Ogita, Rump, Oishi 2005, compensated Horner).
    let (mut value, mut error, mut size) = (c[0], 0.0, c[0].abs());
    for a in &c[1..] {
        let product = value * x;
        let product_error = value.mul_add(x, -product);
        let sum = product + a;
        let back = sum - product;
        let sum_error = (product - (sum - back)) + (a - back);
        error = error * x + (product_error + sum_error);
        (value, size) = (sum, size * x.abs() + a.abs());
    }
    ((value + error) / size).abs()
}

pub(super) fn corpus(report: &mut Report) {
    let spread = |r: &mut SplitMix64, decades: f64| 10f64.powf(decades * (r.unit() - 0.5)) * if r.below(2) == 0 { 1.0 } else { -1.0 };
    type Roots = fn(&mut SplitMix64) -> [f64; 4];
    let kinds: [(&str, Roots); 4] = [
        ("simple roots", |r| [r.unit() + 0.1, -r.unit() - 0.1, r.unit() + 2.0, -r.unit() - 2.0]),
        ("a double root", |r| {
            let a = r.unit() * 4.0 - 2.0;
            [a, a, r.unit() + 3.0, -r.unit() - 3.0]
        }),
        ("a triple root", |r| {
            let a = r.unit() * 4.0 - 2.0;
            [a, a, a, r.unit() + 3.0]
        }),
        ("two double roots", |r| {
            let (a, b) = (r.unit(), -r.unit());
            [a, a, b, b]
        }),
    ];
    let n = report.rays(100);
    type Solver = fn(&[f64; 5]) -> Vec<f64>;
    let solvers: [(&str, Solver); 2] =
        [("closed form", |c| solve_quartic(c[0], c[1], c[2], c[3], c[4]).to_vec()), ("Sturm", |c| solve_polynomial(c, true, 0.0).to_vec())];
    for (solver, solve) in solvers {
        for (name, roots) in kinds {
            let worst = largest(n, 18, |r| {
                let c = expanded(roots(r));
                solve(&c).iter().map(|x| backward_error(&c, *x)).fold(0.0, f64::max)
            });
            report.cpu(format!("backward error, {name}, {solver}"), worst, 1e-14, n);
        }
        let worst = largest(n, 19, |r| {
            let c = expanded([spread(r, 12.0), spread(r, 12.0), spread(r, 12.0), spread(r, 12.0)]);
            solve(&c).iter().map(|x| backward_error(&c, *x)).fold(0.0, f64::max)
        });
        report.cpu(format!("backward error, roots spread over 1e12, {solver}"), worst, 1e-14, n);
        // Sturm chains look at positive roots alone, which is what rays want.
        let lost = total(n, 20, |r| {
            let want = [r.unit() + 0.1, r.unit() + 2.0, -r.unit() - 0.1, -r.unit() - 2.0];
            let got = solve(&expanded(want));
            let missing = |w: &&f64| !got.iter().any(|g| (g - **w).abs() < 1e-6 * w.abs());
            want.iter().filter(|w| **w > 0.0).filter(missing).count() as u64
        });
        report.cpu(format!("positive simple roots lost, {solver}"), lost as f64, 0.0, 2 * n);
    }
}
