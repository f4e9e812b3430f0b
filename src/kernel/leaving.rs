//! Primitives that a ray leaves behind: where a surface is convex and the ray runs outwards, or where it is flat, no test of it is needed.

use super::SurfaceHit;
use crate::compile::geometry::{Geometry, PrimKind, prim_flags};
use crate::math::{Bounds, DVec3};

/// The primitive of a hit, where a ray that leaves the hit along unit `dir` cannot meet it again: a convex one that the ray leaves outwards, a flat
/// one that it leaves at all. `u32::MAX` where it may. Grazing rays and places far from the origin are left to the test: roundings decide there.
#[inline]
pub fn left_behind(g: &Geometry, hit: &SurfaceHit, dir: DVec3) -> u32 {
    let cos = hit.normal.dot(dir);
    left_at(g, hit, cos, cos)
}

/// As [`left_behind`], for all rays from the hit to points of a box.
#[inline]
pub fn left_behind_toward(g: &Geometry, hit: &SurfaceHit, ends: &Bounds) -> u32 {
    let (to, half) = (ends.center() - hit.point, 0.5 * ends.size());
    let (height, spread, reach) = (hit.normal.dot(to), hit.normal.abs().dot(half), to.length() + half.length());
    left_at(g, hit, (height - spread) / reach, (height + spread) / reach)
}

/// The primitive of a hit that rays leave whose cosines from its normal lie between two.
#[inline]
fn left_at(g: &Geometry, hit: &SurfaceHit, least: f64, most: f64) -> u32 {
    /// A depth that is wrong by as much as roundings over this is still far below any tolerance.
    const LEAST_COS: f64 = 0.01;
    const FAR: f64 = 1e6;
    let prim = &g.prims[hit.prim_ix as usize];
    let outward = if prim.flags & prim_flags::INVERTED != 0 { -most } else { least };
    let is_across = least > LEAST_COS || most < -LEAST_COS;
    let leaves = match prim.kind {
        PrimKind::Sphere => outward > LEAST_COS && g.shapes.spheres[prim.shape_ix as usize].radius > 0.0,
        PrimKind::Box | PrimKind::Cylinder | PrimKind::Cone => outward > LEAST_COS,
        PrimKind::Plane | PrimKind::Disc | PrimKind::Polygon => is_across,
        PrimKind::Triangle => is_across && !g.shapes.triangles[prim.shape_ix as usize].smooth,
        _ => false,
    };
    let is_near = hit.t < FAR && hit.point.abs().max_element() < FAR;
    if leaves && is_near && prim.flags & prim_flags::MOVING == 0 { hit.prim_ix } else { u32::MAX }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::geometry_tests::{assorted, compiled, scattered};
    use crate::kernel::traverse::{MIN_DEPTH, Nearest, intersect};
    use crate::math::Ray;

    #[test]
    fn what_is_left_behind_is_not_met_again() {
        let scene = compiled(assorted());
        let (mut n_left, mut n_toward) = (0, 0);
        for (k, d) in scattered(4000).enumerate() {
            let Some(hit) = intersect(&scene, &Ray::new(d * 9.0, (d * 0.3 - d * 9.0 + 2.0 * scatter(k)).normalize()), MIN_DEPTH, 1e7, 0)
            else {
                continue;
            };
            let meets = |dir: DVec3| {
                let ray = Ray::new(hit.point, dir);
                let mut any = Nearest::any(&scene, &ray, MIN_DEPTH, 1e7, (u32::MAX, true));
                any.test(hit.prim_ix);
                any.found()
            };
            let dir = scatter(k + 7).normalize();
            if left_behind(&scene.geometry, &hit, dir) == hit.prim_ix {
                assert!(!meets(dir), "{hit:?} along {dir}");
                n_left += 1;
            }
            let middle = hit.point + 3.0 * scatter(k + 3);
            let ends = Bounds { min: middle - 0.2, max: middle + 0.3 };
            if left_behind_toward(&scene.geometry, &hit, &ends) == hit.prim_ix {
                assert!(ends.corners().iter().all(|c| !meets((*c - hit.point).normalize())));
                n_toward += 1;
            }
        }
        assert!(n_left > 500 && n_toward > 500, "{n_left} {n_toward}");
    }

    /// A direction that has nothing to do with [`scattered`]'s.
    fn scatter(k: usize) -> DVec3 {
        let k = k as f64;
        DVec3::new((k * 1.37).sin(), (k * 2.11).cos(), (k * 0.53).sin())
    }

    #[test]
    fn rays_into_a_solid_and_grazing_ones_leave_nothing() {
        let scene = compiled(vec![crate::kernel::geometry_tests::sphere(DVec3::ZERO, 1.0)]);
        let hit = intersect(&scene, &Ray::new(DVec3::Z * 5.0, DVec3::NEG_Z), MIN_DEPTH, 1e7, 0).expect("a hit");
        let left = |dir: DVec3| left_behind(&scene.geometry, &hit, dir.normalize());
        assert_eq!((left(DVec3::Z), left(DVec3::NEG_Z), left(DVec3::new(1.0, 0.0, 0.001))), (0, u32::MAX, u32::MAX));
    }
}
