//! Rays against a scene whose still meshes stand in one tree: what `kernel/traverse` answers, sooner.
//!
//! Same hits but for the rounding of corners in the world; at equal depth the first object wins, and of a mesh the first face.

use super::SurfaceHit;
use super::intersect::mesh::{ShearedRay, TOLERANCE};
use super::intersect::{LocalRay, Part};
use super::traverse::{Nearest, ShadowHit};
use crate::accel::{LeafVisitor, PACK};
use crate::compile::CompiledScene;
use crate::compile::geometry::prim_flags;
use crate::compile::merged::{Member, MergedMeshes};
use crate::math::simd::Simd;
use crate::math::{MAX_DISTANCE, Ray};

/// Offers the hits of a ray with faces to `found`, which gives the depth that still matters, or `None` to stop.
struct Faces<'a, F> {
    merged: &'a MergedMeshes,
    ray: &'a ShearedRay,
    found: F,
}

impl<F: FnMut(&Member, f64, Part, f64) -> Option<f64>> LeafVisitor for Faces<'_, F> {
    #[inline(always)]
    fn leaf<S: Simd>(&mut self, simd: S, first: u32, count: u32, mut far: f64) -> Option<f64> {
        let hits = self.ray.pack_hits(simd, &self.merged.packs[first as usize / PACK], count, far);
        let mut met = hits.met;
        while met != 0 {
            let k = met.trailing_zeros() as usize % PACK;
            met &= met - 1;
            let (slot, t) = (first as usize + k, hits.t[k]);
            if t > TOLERANCE && t <= far && t < MAX_DISTANCE {
                let member = &self.merged.members[self.merged.member_of_slot[slot] as usize];
                let face = self.merged.tree.slots[slot] - member.first_face;
                let (a, b) = hits.weights(k);
                far = (self.found)(member, t, Part { face, a, b }, far)?;
            }
        }
        Some(far)
    }
}

/// Walks the faces along a ray. Tells whether `found` stopped it.
#[inline]
fn visit(merged: &MergedMeshes, ray: &Ray, far: f64, found: impl FnMut(&Member, f64, Part, f64) -> Option<f64>) -> bool {
    let sheared = ShearedRay::new(&LocalRay { origin: ray.origin, dir: ray.dir, scale: 1.0 });
    merged.tree.visit_leaves(ray, 0.0, far.min(MAX_DISTANCE), &mut Faces { merged, ray: &sheared, found })
}

/// As [`super::traverse::intersect_at`].
pub fn intersect_merged(
    scene: &CompiledScene,
    merged: &MergedMeshes,
    ray: &Ray,
    time: f64,
    t_min: f64,
    t_max: f64,
    skip_flags: u32,
) -> Option<SurfaceHit> {
    let mut nearest = Nearest::at_time(scene, ray, time, t_min, t_max);
    visit(merged, ray, t_max, |member, t, part, far| {
        if member.flags & skip_flags != 0 {
            return Some(far);
        }
        nearest.push_face(member.prim_ix, t, part);
        Some(nearest.limit())
    });
    let g = &scene.geometry;
    let is_seen = |prim_ix: u32| g.prims[prim_ix as usize].flags & skip_flags == 0;
    g.unbounded.iter().copied().filter(|p| is_seen(*p)).for_each(|p| nearest.test(p));
    if !merged.rest.is_empty() {
        let far = nearest.limit();
        merged.rest_tree.closest(ray, t_min, far, |k, far| {
            let prim_ix = merged.rest[k as usize];
            if !is_seen(prim_ix) {
                return None;
            }
            nearest.test(prim_ix);
            (nearest.limit() < far).then_some(nearest.limit())
        });
    }
    nearest.finish()
}

/// As [`super::traverse::intersect_object_at`].
pub fn intersect_merged_object(
    scene: &CompiledScene,
    merged: &MergedMeshes,
    object_ix: u32,
    ray: &Ray,
    time: f64,
    t_min: f64,
    t_max: f64,
) -> Option<SurfaceHit> {
    let g = &scene.geometry;
    let mut nearest = Nearest::at_time(scene, ray, time, t_min, t_max);
    let mut has_members = false;
    for prim_ix in g.objects[object_ix as usize].prims.clone() {
        if merged.member(prim_ix).is_some() {
            has_members = true;
        } else if g.prims[prim_ix as usize].flags & prim_flags::INSIDE_ONLY == 0 {
            nearest.test(prim_ix);
        }
    }
    if has_members {
        let far = nearest.limit();
        visit(merged, ray, far, |member, t, part, far| {
            if member.object_ix != object_ix {
                return Some(far);
            }
            nearest.push_face(member.prim_ix, t, part);
            Some(nearest.limit())
        });
    }
    nearest.finish()
}

/// As [`super::traverse::intersect_shadow_at`].
pub fn intersect_merged_shadow(scene: &CompiledScene, merged: &MergedMeshes, ray: &Ray, time: f64, t_min: f64, t_max: f64) -> ShadowHit {
    let g = &scene.geometry;
    let mut blocker = u32::MAX;
    let mut clear = Nearest::at_time(scene, ray, time, t_min.next_up(), t_max);
    let blocked = visit(merged, ray, t_max, |member, t, part, far| {
        if member.flags & prim_flags::NO_SHADOW != 0 || !(t > t_min && t < t_max) {
            return Some(far);
        }
        if member.flags & prim_flags::TRANSPARENT == 0 {
            blocker = member.prim_ix;
            return None;
        }
        // Opaque things end the ray wherever they are, so a clear hit must not shorten it.
        clear.push_face(member.prim_ix, t, part);
        Some(far)
    });
    if blocked {
        return ShadowHit::Opaque { prim_ix: blocker };
    }
    if !g.unbounded.is_empty() || !merged.rest.is_empty() {
        let mut opaque = Nearest::at_time(scene, ray, time, t_min.next_up(), t_max).first();
        let mut test = |prim_ix: u32| {
            let flags = g.prims[prim_ix as usize].flags;
            if flags & prim_flags::NO_SHADOW == 0 {
                if flags & prim_flags::TRANSPARENT != 0 { clear.test(prim_ix) } else { opaque.test(prim_ix) }
            }
            opaque.found()
        };
        let blocked = merged.rest_tree.any(ray, t_min, t_max, |k| test(merged.rest[k as usize])) || g.unbounded.iter().any(|p| test(*p));
        if blocked {
            return ShadowHit::Opaque { prim_ix: opaque.prim_ix() };
        }
    }
    clear.finish().map_or(ShadowHit::None, ShadowHit::Transparent)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compile::{CompileOptions, compile_scene};
    use crate::kernel::traverse::{intersect_at, intersect_object_at, intersect_shadow_at};
    use crate::math::sobol::Pcg;
    use crate::math::{DVec3, Transform, Vec3};
    use crate::scene::{Mesh, Object, Scene, Shape};
    use std::sync::Arc;

    /// A closed ball of faces about the origin.
    fn ball(rng: &mut Pcg) -> Arc<Mesh> {
        let n = 3 + (rng.draw() * 9.0) as u32;
        let at = |ring: u32, k: u32| {
            let (a, b) = (std::f32::consts::PI * ring as f32 / n as f32, std::f32::consts::TAU * (k % (2 * n)) as f32 / (2 * n) as f32);
            Vec3::new(a.sin() * b.cos(), a.cos(), a.sin() * b.sin())
        };
        let vertices = (0..=n).flat_map(|r| (0..2 * n).map(move |k| at(r, k))).collect();
        let ix = |r: u32, k: u32| r * 2 * n + k % (2 * n);
        let quads = (0..n).flat_map(|r| (0..2 * n).map(move |k| (r, k)));
        let faces =
            quads.flat_map(|(r, k)| [[ix(r, k), ix(r + 1, k), ix(r + 1, k + 1)], [ix(r, k), ix(r + 1, k + 1), ix(r, k + 1)]]).collect();
        Arc::new(Mesh { vertices, faces, ..Mesh::default() })
    }

    /// Balls of faces, some shared, some unseen, some clear, and a few spheres; at rest.
    fn scene(rng: &mut Pcg) -> CompiledScene {
        let mut objects = Vec::new();
        let mut shared = ball(rng);
        for k in 0..40 {
            let mut d = || f64::from(rng.draw());
            let place = Transform::scaling(DVec3::splat(0.2 + 0.5 * d()))
                .then(&Transform::rotation_deg(DVec3::new(d(), d(), d()) * 360.0))
                .then(&Transform::translation(DVec3::new(d(), d(), d()) * 8.0 - 4.0));
            if k % 3 != 0 {
                shared = ball(rng);
            }
            let shape = if k % 8 == 7 { Shape::Sphere { center: DVec3::ZERO, radius: 1.0 } } else { Shape::Mesh(shared.clone()) };
            let mut object = Object { transform: place, ..Object::new(shape) };
            object.flags.no_shadow = (k % 5 == 0).then_some(true);
            object.flags.no_image = (k % 6 == 0).then_some(true);
            objects.push(object);
        }
        let scene = Scene { objects, ..Scene::default() };
        compile_scene(&scene, &CompileOptions::default()).expect("a scene that compiles")
    }

    #[test]
    fn one_tree_meets_what_the_trees_of_the_objects_meet() {
        let mut rng = Pcg::new(3);
        let (mut n_met, mut n_blocked) = (0, 0);
        for _ in 0..6 {
            let mut scene = scene(&mut rng);
            for (k, p) in scene.geometry.prims.iter_mut().enumerate() {
                p.flags |= if k % 4 == 1 { prim_flags::TRANSPARENT } else { 0 };
            }
            let Some(merged) = MergedMeshes::new(&scene) else { return };
            assert!(merged.members.len() == 35 && merged.rest.len() == 5);
            assert!(merged.tree.is_sound(merged.member_of_slot.len()));
            for _ in 0..4000 {
                let mut point = || DVec3::new(rng.draw().into(), rng.draw().into(), rng.draw().into()) * 12.0 - 6.0;
                let (from, to) = (point(), point());
                let (ray, far) = (Ray::new(from, (to - from).normalize()), (to - from).length());
                for skip in [0, prim_flags::NO_IMAGE] {
                    let a = intersect_at(&scene, &ray, -1.0, 1e-6, f64::INFINITY, skip);
                    let b = intersect_merged(&scene, &merged, &ray, -1.0, 1e-6, f64::INFINITY, skip);
                    assert_eq!(a.map(|h| h.prim_ix), b.map(|h| h.prim_ix));
                    if let (Some(a), Some(b)) = (a, b) {
                        n_met += 1;
                        assert!(
                            (a.t - b.t).abs() < 1e-4 && a.point.distance(b.point) < 1e-4 && a.normal.distance(b.normal) < 1e-3,
                            "{a:?} {b:?}"
                        );
                        assert!(a.face_ix == b.face_ix || a.normal.dot(b.normal) > 0.9, "another face: {a:?} {b:?}");
                    }
                }
                match (
                    intersect_shadow_at(&scene, &ray, -1.0, 1e-6, far, u32::MAX),
                    intersect_merged_shadow(&scene, &merged, &ray, -1.0, 1e-6, far),
                ) {
                    (ShadowHit::Opaque { .. }, ShadowHit::Opaque { prim_ix }) => {
                        n_blocked += 1;
                        assert!(scene.geometry.prims[prim_ix as usize].flags & (prim_flags::NO_SHADOW | prim_flags::TRANSPARENT) == 0);
                    }
                    (ShadowHit::Transparent(a), ShadowHit::Transparent(b)) => assert!((a.t - b.t).abs() < 1e-4 && a.prim_ix == b.prim_ix),
                    (ShadowHit::None, ShadowHit::None) => {}
                    (a, b) => panic!("{a:?} {b:?}"),
                }
                let object = (rng.draw() * 40.0) as u32;
                let a = intersect_object_at(&scene, object, &ray, -1.0, 1e-6, far).map(|h| h.t);
                let b = intersect_merged_object(&scene, &merged, object, &ray, -1.0, 1e-6, far).map(|h| h.t);
                assert!(a.is_some() == b.is_some() && a.zip(b).is_none_or(|(a, b)| (a - b).abs() < 1e-4));
            }
        }
        assert!(n_met > 5_000 && n_blocked > 1_000, "{n_met} {n_blocked}");
    }

    /// Rays from within a closed mesh that stands far from the origin find it, whatever edge they run through.
    #[test]
    fn a_closed_mesh_far_away_has_no_gaps() {
        let mut rng = Pcg::new(9);
        let place = |at: DVec3| Transform::rotation_deg(DVec3::new(10.0, 20.0, 30.0)).then(&Transform::translation(at));
        let far = DVec3::new(148_376.0, 1234.0, -223_423.0);
        let mesh = ball(&mut rng);
        let object = |at| Object { transform: place(at), ..Object::new(Shape::Mesh(mesh.clone())) };
        let scene = Scene { objects: vec![object(far), object(-far)], ..Scene::default() };
        let scene = compile_scene(&scene, &CompileOptions::default()).expect("a scene that compiles");
        let Some(merged) = MergedMeshes::new(&scene) else { return };
        let corners: Vec<DVec3> = mesh.vertices.iter().map(|v| place(far).point(v.as_dvec3()).as_vec3().as_dvec3()).collect();
        for k in 0..20_000usize {
            let from = far + DVec3::new(rng.draw().into(), rng.draw().into(), rng.draw().into()) * 0.2 - 0.1;
            let f = mesh.faces[k % mesh.faces.len()].map(|v| corners[v as usize]);
            // At a corner, or along an edge.
            let to = if k % 2 == 0 { f[0] } else { f[0].lerp(f[1], f64::from(rng.draw())) };
            let ray = Ray::new(from, (to - from).normalize());
            assert!(intersect_merged(&scene, &merged, &ray, -1.0, 1e-6, f64::INFINITY, 0).is_some(), "{ray:?}");
        }
    }
}
