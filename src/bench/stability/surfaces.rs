//! Cases 10, 11, 13 and 14: rays that start on surfaces, gaps, distance and size. World units; depths as the integrators accept them.

use super::figures::{Report, largest, scene, total, worst_of};
use super::peers::PovHit;
use crate::compile::CompiledScene;
use crate::integrate::path::NEAR;
use crate::kernel::SurfaceHit;
use crate::kernel::traverse::{MIN_DEPTH, SHADOW_TOLERANCE, ShadowHit, intersect, intersect_shadow};
use crate::math::random::SplitMix64;
use crate::math::{DVec3, Ray};

/// The integrators, and the least depths that their rays accept.
const INTEGRATORS: [(&str, f64); 2] = [("classic", MIN_DEPTH), ("path", NEAR)];
const FAR: f64 = 1e12;

/// The first thing that a ray from `4 radius` away, aimed into the ball of `radius`, meets.
fn from_outside(scene: &CompiledScene, radius: f64, r: &mut SplitMix64) -> Option<SurfaceHit> {
    let from = 4.0 * radius * r.direction();
    let to = 0.9 * radius * r.unit() * r.direction();
    intersect(scene, &Ray::new(from, (to - from).normalize()), 0.0, FAR, 0)
}

/// A direction by Lambert's law around `n`.
fn cosine(n: DVec3, r: &mut SplitMix64) -> DVec3 {
    (n + r.direction()).try_normalize().unwrap_or(n)
}

pub(super) fn self_intersection(report: &mut Report) {
    // Convex, or hit on the convex side alone: what leaves them does not come back.
    let shapes = [
        ("sphere", "sphere { 0, R }"),
        ("box", "box { -0.5*R, 0.5*R }"),
        ("cylinder", "cylinder { <0,-0.5*R,0>, <0,0.5*R,0>, 0.5*R }"),
        ("cone", "cone { <0,-0.5*R,0>, 0.5*R, <0,0.5*R,0>, 0.1*R }"),
        ("superellipsoid", "superellipsoid { <0.6, 0.6> scale 0.5*R }"),
        ("outside of a torus", "torus { 0.6*R, 0.3*R }"),
    ];
    let n = report.rays(100);
    for (name, text) in shapes {
        for (integrator, t_min) in INTEGRATORS {
            let mut again = 0;
            for exponent in -8..=8 {
                let radius = 10f64.powi(exponent);
                let scene = scene(&format!("#declare R = {radius:e}; object {{ {text} pigment {{ rgb 1 }} }}"));
                again += total(n, 11, |r| {
                    let Some(hit) = from_outside(&scene, radius, r) else { return 0 };
                    // The inner half of a torus sees itself.
                    if name.ends_with("torus") && hit.point.x.hypot(hit.point.z) < 0.6 * radius {
                        return 0;
                    }
                    let out = cosine(hit.normal, r);
                    u64::from(intersect(&scene, &Ray::new(hit.point, out), t_min, FAR, 0).is_some())
                });
            }
            report.cpu(format!("{name} met again, {integrator}"), again as f64, 0.0, 17 * n);
        }
    }
}

pub(super) fn gap(report: &mut Report) {
    let n = report.rays(100);
    // POV-Ray's own rule ignores what is nearer than a thousandth of a unit: only scenes above ten units can show this gap.
    for (integrator, t_min, sizes) in [("classic", SHADOW_TOLERANCE, 2..=5), ("path", NEAR, -1..=5)] {
        for size in sizes {
            let s = 10f64.powi(size);
            let scene =
                scene(&format!("plane {{ y, 0 pigment {{ rgb 1 }} }} disc {{ <0,{:e},0>, y, {s:e} pigment {{ rgb 1 }} }}", 1e-4 * s));
            let light = DVec3::new(0.3, 2.0, 0.2) * s;
            let lost = total(n, 12, |r| {
                let (radius, angle) = (0.9 * s * r.unit(), std::f64::consts::TAU * r.unit());
                let under = radius * DVec3::new(angle.cos(), 0.0, angle.sin());
                let eye = under + 5e-5 * s * DVec3::new(0.5, 1.0, 0.2);
                let Some(hit) = intersect(&scene, &Ray::new(eye, (under - eye).normalize()), 0.0, FAR, 0) else { return 1 };
                let to_light = light - hit.point;
                let t_max = to_light.length() - t_min;
                let met = intersect_shadow(&scene, &Ray::new(hit.point, to_light.normalize()), t_min, t_max, u32::MAX);
                u64::from(matches!(met, ShadowHit::None))
            });
            report.cpu(format!("share of contact shadow lost, size 1e{size}, {integrator}"), lost as f64 / n as f64, 1e-4, n);
        }
    }
}

pub(super) fn far_sphere(report: &mut Report) {
    const SPHERE: &str = "sphere { 0, 1 }";
    let scene = scene(&format!("object {{ {SPHERE} pigment {{ rgb 1 }} }}"));
    let n = report.rays(10);
    for exponent in 2..=7 {
        let distance = 10f64.powi(exponent);
        // A point that faces the eye within 60 degrees: beyond, the direction's own rounding moves the depth by more.
        let aim = |r: &mut SplitMix64| {
            let toward = r.direction();
            let point = toward + 0.5 * r.direction();
            let point = point.normalize();
            let eye = distance * toward;
            let want = (eye - point).length();
            (Ray::new(eye, (point - eye) / want), want)
        };
        let error = |want: f64, got: Option<f64>| (got.unwrap_or(f64::NAN) - want).abs() / want / f64::EPSILON;
        let worst = largest(n, 13, |r| {
            let (ray, want) = aim(r);
            error(want, intersect(&scene, &ray, 0.0, FAR, 0).map(|h| h.t))
        });
        let what = format!("largest error of depth in units in the last place, from 1e{exponent}");
        report.cpu(&what, worst, 8.0, n);
        if let Some(traced) = report.povray(SPHERE, n, 13, aim) {
            let errors = traced.iter().map(|(ray, want, hit)| error(*want, hit.map(|h| (h.point - ray.origin).length())));
            report.povray_figure(what, worst_of(errors), traced.len() as u64);
        }
    }
}

pub(super) fn giant_sphere(report: &mut Report) {
    let scene = scene("sphere { <0,-1e6,0>, 1e6 pigment { rgb 1 } }");
    let center = DVec3::new(0.0, -1e6, 0.0);
    let n = report.rays(10);
    let view = |r: &mut SplitMix64| {
        let d = r.direction();
        let d = DVec3::new(d.x, -(0.01 + d.y.abs()), d.z).normalize();
        (d, intersect(&scene, &Ray::new(DVec3::Y, d), MIN_DEPTH, FAR, 0))
    };
    let error = largest(n, 14, |r| view(r).1.map_or(f64::NAN, |h| (h.normal - (h.point - center).normalize()).length()));
    report.cpu("largest error of the normal", error, 1e-4, n);
    let from_above = |r: &mut SplitMix64| (Ray::new(DVec3::Y, view(r).0), ());
    if let Some(traced) = report.povray("sphere { <0,-1e6,0>, 1e6 }", n, 14, from_above) {
        let of = |h: &PovHit| (h.normal - (h.point - center).normalize()).length();
        let errors = traced.iter().map(|(_, (), hit)| hit.as_ref().map_or(f64::NAN, of));
        report.povray_figure("largest error of the normal", worst_of(errors), traced.len() as u64);
    }
    for (integrator, t_min) in [("classic", SHADOW_TOLERANCE), ("path", NEAR)] {
        let dark = total(n, 15, |r| {
            let Some(hit) = view(r).1 else { return 1 };
            let light = cosine(hit.normal, r);
            // What grazes the ground is met again rightly.
            let clear = hit.normal.dot(light) > 1e-6;
            u64::from(clear && !matches!(intersect_shadow(&scene, &Ray::new(hit.point, light), t_min, FAR, u32::MAX), ShadowHit::None))
        });
        report.cpu(format!("lit points in shadow of themselves, {integrator}"), dark as f64, 0.0, n);
    }
}
