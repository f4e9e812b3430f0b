//! Hair: ribbons along curves that face the ray.

use super::{HitSink, LocalRay, Part};
use crate::compile::shape::hair::{HairSegment, HairShape};
use crate::math::{DVec3, Ray};

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

/// Nearest crossing of a segment's ribbon: depth, place along, offset across.
fn meet(s: &HairSegment, ray: &LocalRay, (x, y): (DVec3, DVec3), far: f64) -> Option<(f64, f64, f64)> {
    let seen = |p: DVec3| {
        let p = p - ray.origin;
        (p.dot(x), p.dot(y), p.dot(ray.dir))
    };
    let mut best: Option<(f64, f64, f64)> = None;
    // Pieces overlap where they join: the one whose middle is nearest to the ray.
    let mut least = f64::INFINITY;
    let mut a = seen(s.points[0]);
    for k in 0..PIECES {
        let (u0, u1) = (k as f64 / PIECES as f64, (k + 1) as f64 / PIECES as f64);
        let b = seen(s.at(u1));
        let (dx, dy) = (b.0 - a.0, b.1 - a.1);
        let len_sq = dx * dx + dy * dy;
        let w = if len_sq > 0.0 { (-(a.0 * dx + a.1 * dy) / len_sq).clamp(0.0, 1.0) } else { 0.0 };
        let u = u0 + (u1 - u0) * w;
        let r = s.radius(u);
        let (cx, cy) = (a.0 + w * dx, a.1 + w * dy);
        let distance_sq = cx * cx + cy * cy;
        if distance_sq <= r * r && r > 0.0 {
            let t = a.2 + w * (b.2 - a.2);
            // A ray that leaves a hair does not meet it again.
            if t > 2.0 * r && t < far && distance_sq < least {
                // From the curve to the ray, across: the ray is at the origin of (x, y, dir), which is right-handed.
                let len = len_sq.sqrt();
                let across = if len > 0.0 { (-cx * dy + cy * dx) / len } else { distance_sq.sqrt() };
                least = distance_sq;
                best = Some((t, u, (across / r).clamp(-1.0, 1.0)));
            }
        }
        a = b;
    }
    best
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
}
