//! Primitives of many kinds in a compiled scene: hits and shadows do not depend on the tree.

use crate::TREES;
use rayloom::accel::AccelKind;
use rayloom::bench::stability::meshes::Triangles;
use rayloom::bench::stability::ray_source::RaySource;
use rayloom::compile::{CompileOptions, CompiledScene, compile_scene};
use rayloom::kernel::traverse::{MIN_DEPTH, ShadowHit, intersect, intersect_shadow};
use rayloom::math::random::SplitMix64;
use rayloom::math::{Bounds, DVec3, Transform};
use rayloom::scene::{Csg, Mesh, Object, Scene, Shape};
use std::sync::Arc;

const N_RAYS: usize = 1_000_000;

fn objects() -> Vec<Object> {
    let mut r = SplitMix64(41);
    let soup = rayloom::bench::stability::meshes::soup(30, 0.3, 43);
    let mesh = Arc::new(Mesh { vertices: soup.vertices, faces: soup.faces, ..Mesh::default() });
    (0..120)
        .map(|k| {
            let size = 0.1 + 0.3 * r.unit();
            let ball = |center, radius| Object::new(Shape::Sphere { center, radius });
            let cube = |r: f64| Object::new(Shape::Box { min: DVec3::splat(-r), max: DVec3::splat(r) });
            let mut o = match k % 8 {
                0 => ball(DVec3::ZERO, size),
                1 => cube(size),
                2 => Object::new(Shape::Torus { major: size, minor: 0.3 * size }),
                3 => Object::new(Shape::Cylinder { a: DVec3::ZERO, b: DVec3::Y * size, radius: 0.4 * size, open: k % 3 == 0 }),
                4 => Object::new(Shape::Cone { a: DVec3::ZERO, radius_a: size, b: DVec3::Y, radius_b: 0.1, open: k % 3 == 0 }),
                5 => {
                    let children = vec![cube(size), ball(DVec3::splat(0.7 * size), size)];
                    Object::new(Shape::Csg { op: if k % 3 == 0 { Csg::Intersection } else { Csg::Difference }, children })
                }
                6 => Object::new(Shape::Mesh(mesh.clone())),
                _ => ball(r.cube() * 0.1, size),
            };
            if k % 3 > 0 {
                o.apply_transform(&Transform::rotation_deg(r.cube() * 180.0));
            }
            // Boxes on a lattice share faces.
            let place = r.cube() * 4.0;
            o.apply_transform(&Transform::translation(if k % 8 == 1 { place.round() } else { place }));
            o
        })
        .collect()
}

fn compiled(accel: AccelKind) -> CompiledScene {
    let scene = Scene { objects: objects(), ..Scene::default() };
    compile_scene(&scene, &CompileOptions { accel, ..CompileOptions::default() }).expect("a scene that compiles")
}

#[test]
fn mixed_primitives_are_hit_alike_through_every_tree() {
    let brute = compiled(AccelKind::Brute);
    let trees = TREES.map(compiled);
    assert_eq!(trees.each_ref().map(|t| t.geometry.tree.kind()), TREES);
    // Rays find the planes and corners of the primitives' boxes.
    let mut aims = Triangles::default();
    for Bounds { min, max } in &brute.geometry.bounds {
        aims.add_box(*min, *max);
    }
    let (mut n_hits, mut n_dark) = (0, 0);
    for (k, ray) in RaySource::new(&aims, 47).take(N_RAYS).enumerate() {
        let found = |s| intersect(s, &ray, MIN_DEPTH, f64::INFINITY, 0).map(|h| (h.prim_ix, h.face_ix, h.t));
        let dark = |s| matches!(intersect_shadow(s, &ray, 1e-3, 3.0, u32::MAX), ShadowHit::Opaque { .. });
        let (hit, is_dark) = (found(&brute), dark(&brute));
        n_hits += usize::from(hit.is_some());
        n_dark += usize::from(is_dark);
        for t in &trees {
            assert_eq!((found(t), dark(t)), (hit, is_dark), "ray {k} {ray:?} through {:?}", t.geometry.tree.kind());
        }
    }
    assert!(n_hits > N_RAYS / 10 && n_hits < N_RAYS && n_dark > N_RAYS / 20, "{n_hits} hits, {n_dark} in the dark");
}
