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
    // The curve as the ray sees it, at the origin and along z; x, y and its direction are right-handed.
    let seen = s.points.map(|p| {
        let p = p - ray.origin;
        DVec3::new(p.dot(x), p.dot(y), p.dot(ray.dir))
    });
    // It stays among its Bézier points: most rays pass outside.
    let (low, high) = seen.iter().fold((seen[0], seen[0]), |(l, h), p| (l.min(*p), h.max(*p)));
    let most = s.radii[0].max(s.radii[1]);
    if low.x > most || low.y > most || high.x < -most || high.y < -most || high.z <= 0.0 || low.z >= far {
        return None;
    }
    let seen = HairSegment { points: seen, ..*s };
    let place = |k: usize| k as f64 / PIECES as f64;
    // Half the joint: tangent x direction of the ray, as long as the radius.
    let across = |k: usize| {
        let t = seen.tangent(place(k));
        DVec2::new(t.y, -t.x).normalize_or(DVec2::X) * s.radius(place(k))
    };
    let mut best: Option<(f64, f64, f64)> = None;
    let mut a = seen.at(0.0);
    for k in 0..PIECES {
        let (from, to) = (a, seen.at(place(k + 1)));
        a = to;
        if from.x.min(to.x) > most || from.y.min(to.y) > most || from.x.max(to.x) < -most || from.y.max(to.y) < -most {
            continue;
        }
        // Places w along the piece where the ray, at the origin, lies on the line across: (p + w dp) x (n + w dn) = 0.
        let (p, n) = (from.truncate(), across(k));
        let (dp, dn) = (to.truncate() - p, across(k + 1) - n);
        for w in quadratic(dp.perp_dot(dn), p.perp_dot(dn) + dp.perp_dot(n), p.perp_dot(n)) {
            if !(0.0..=1.0).contains(&w) {
                continue;
            }
            let (at, half) = (p + dp * w, n + dn * w);
            let offset = -at.dot(half) / half.length_squared();
            let u = (k as f64 + w) / PIECES as f64;
            let t = from.z + (to.z - from.z) * w;
            // A ray that leaves a hair does not meet it again.
            if offset.abs() <= 1.0 && t > 2.0 * s.radius(u) && t < best.map_or(far, |b| b.0) {
                best = Some((t, u, offset));
            }
        }
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
