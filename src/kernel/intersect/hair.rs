//! Hair: ribbons along curves that face the ray.

use super::{HitSink, LocalRay, Part};
use crate::compile::shape::hair::{HairSegment, HairShape};
use crate::math::{DVec2, DVec3, Ray};

/// Straight pieces of a segment. Source: Cycles' default of 2 subdivisions, 4 pieces.
const PIECES: usize = 4;

/// All crossings up to the depth that the sink still wants. `Part`: segment, place along it, offset across it in radii (-1..=1), positive
/// along tangent x direction of the ray.
pub fn intersect_hair(s: &HairShape, ray: &LocalRay, sink: &mut impl HitSink) {
    let (x, y) = ray.dir.any_orthonormal_pair();
    s.tree.closest(&Ray::new(ray.origin, ray.dir), 0.0, sink.far(), |k, far| {
        let (t, u, offset) = meet(&s.segments[k as usize], ray, (x, y), far)?;
        sink.push(t, Part { face: k, a: u, b: offset });
        let now = sink.far();
        (now < far).then_some(now)
    });
}

/// Nearest crossing of a segment's ribbon: depth, place along, offset across. The ribbon is a strip of quadrilaterals that faces the ray: each
/// joint stretches by the radius to both sides, square to the curve as the ray sees it, and neighbours share their joints.
fn meet(s: &HairSegment, ray: &LocalRay, (x, y): (DVec3, DVec3), far: f64) -> Option<(f64, f64, f64)> {
    let joint = |k: usize| {
        let u = k as f64 / PIECES as f64;
        let (p, t) = (s.at(u) - ray.origin, s.tangent(u));
        // Tangent x direction of the ray, in (x, y); x, y and the ray's direction are right-handed.
        let across = DVec2::new(t.dot(y), -t.dot(x)).normalize_or(DVec2::X);
        (DVec2::new(p.dot(x), p.dot(y)), p.dot(ray.dir), across * s.radius(u))
    };
    let mut best: Option<(f64, f64, f64)> = None;
    let mut a = joint(0);
    for k in 0..PIECES {
        let b = joint(k + 1);
        // Places w along the piece where the ray, at the origin, lies on the line across: (p + w dp) x (n + w dn) = 0.
        let (p, dp, n, dn) = (a.0, b.0 - a.0, a.2, b.2 - a.2);
        let [w0, w1] = quadratic(dp.perp_dot(dn), p.perp_dot(dn) + dp.perp_dot(n), p.perp_dot(n));
        for w in [w0, w1] {
            if !(0.0..=1.0).contains(&w) {
                continue;
            }
            let (at, half) = (p + dp * w, n + dn * w);
            let offset = -at.dot(half) / half.length_squared();
            let u = (k as f64 + w) / PIECES as f64;
            let t = a.1 + (b.1 - a.1) * w;
            // A ray that leaves a hair does not meet it again.
            if offset.abs() <= 1.0 && t > 2.0 * s.radius(u) && t < best.map_or(far, |b| b.0) {
                best = Some((t, u, offset));
            }
        }
        a = b;
    }
    best
}

/// Roots of `a w^2 + b w + c`, NaN where there are fewer.
fn quadratic(a: f64, b: f64, c: f64) -> [f64; 2] {
    let d = b * b - 4.0 * a * c;
    if d < 0.0 {
        return [f64::NAN; 2];
    }
    // The form without cancellation; a straight piece has a of about 0.
    let q = -0.5 * (b + d.sqrt().copysign(b));
    [c / q, if a == 0.0 { f64::NAN } else { q / a }]
}

/// Any normal; what faces a viewer is the integrators' matter.
pub fn hair_normal(s: &HairShape, part: &Part) -> DVec3 {
    s.segments[part.face as usize].tangent(part.a).any_orthogonal_vector()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::AccelKind;
    use crate::math::Vec3;
    use crate::scene::Curves;
    use std::sync::Arc;

    struct Nearest(Option<(f64, Part)>);

    impl HitSink for Nearest {
        fn push(&mut self, t: f64, part: Part) {
            self.0 = Some((t, part));
        }
        fn far(&self) -> f64 {
            self.0.map_or(f64::INFINITY, |h| h.0)
        }
    }

    #[test]
    fn a_straight_hair_is_as_wide_as_its_radius_and_offsets_run_along_tangent_cross_ray() {
        let points = (0..5).map(|k| Vec3::new(k as f32, 0.0, 0.0)).collect();
        let curves = Curves { points, radii: vec![0.1; 5], starts: vec![0, 5], ..Curves::default() };
        let s = HairShape::new(&Arc::new(curves), AccelKind::Auto).expect("segments");
        assert_eq!(s.segments.len(), 4);
        for (y, want) in [(0.0, Some(0.0)), (0.05, Some(0.5)), (-0.05, Some(-0.5)), (0.11, None)] {
            let mut n = Nearest(None);
            let ray = LocalRay { origin: DVec3::new(1.3, y, 5.0), dir: DVec3::NEG_Z, scale: 1.0 };
            intersect_hair(&s, &ray, &mut n);
            // x cross -z is +y.
            assert_eq!(n.0.is_some(), want.is_some(), "y {y}");
            if let (Some((t, part)), Some(want)) = (n.0, want) {
                assert!((t - 5.0).abs() < 1e-6 && (part.b - want).abs() < 1e-6, "{t} {part:?}");
                assert!((s.segments[part.face as usize].at(part.a).x - 1.3).abs() < 0.05);
            }
        }
    }

    #[test]
    fn a_ray_that_leaves_a_hair_along_it_does_not_meet_the_next_piece() {
        let points = (0..5).map(|k| Vec3::new(k as f32, 0.0, 0.0)).collect();
        let curves = Curves { points, radii: vec![0.1; 5], starts: vec![0, 5], ..Curves::default() };
        let s = HairShape::new(&Arc::new(curves), AccelKind::Auto).expect("segments");
        for dir in [DVec3::new(1.0, 0.3, 0.2), DVec3::new(1.0, 0.0, 0.1), DVec3::new(-1.0, 0.05, 0.01), DVec3::new(0.2, 1.0, 1.0)] {
            let mut n = Nearest(None);
            intersect_hair(&s, &LocalRay { origin: DVec3::new(1.1, 0.03, 0.0), dir: dir.normalize(), scale: 1.0 }, &mut n);
            assert!(n.0.is_none(), "{dir}: {:?}", n.0);
        }
    }

    #[test]
    fn bent_hair_has_no_gaps_at_its_joints() {
        let points = (0..7).map(|k| (f64::from(k) * 0.5).sin_cos()).map(|(y, x)| Vec3::new(x as f32, y as f32, 0.0)).collect();
        let curves = Curves { points, radii: vec![0.1; 7], starts: vec![0, 7], ..Curves::default() };
        let s = HairShape::new(&Arc::new(curves), AccelKind::Auto).expect("segments");
        for k in 0..3000 {
            let (sin, cos) = (0.55 + f64::from(k) * 1e-3 * 1.9 / 3.0).sin_cos();
            for r in [0.92, 1.0, 1.08] {
                let mut n = Nearest(None);
                intersect_hair(&s, &LocalRay { origin: DVec3::new(r * cos, r * sin, 5.0), dir: DVec3::NEG_Z, scale: 1.0 }, &mut n);
                let (t, part) = n.0.unwrap_or_else(|| panic!("missed at {k}, {r}"));
                // The curve runs counterclockwise seen from +z: along x -z is inward.
                assert!((t - 5.0).abs() < 1e-9 && (part.b * 0.1 - (1.0 - r)).abs() < 0.005, "{k} {r} {part:?}");
            }
        }
    }
}
