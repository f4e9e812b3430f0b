//! Geometry as a whole: scenes of a few objects, compiled and hit, with answers known beforehand.

use super::inside::{containing_interiors, inside_object};
use super::traverse::{
    ClearPrims, MIN_DEPTH, Nearest, ShadowHints, ShadowHit, intersect, intersect_clear, intersect_shadow, intersect_shadow_noting,
    meets_plain,
};
use crate::accel::AccelKind;
use crate::compile::{CompileOptions, CompiledScene, compile_scene};
use crate::math::{DVec3, Ray, Rgbft, Transform};
use crate::scene::{Csg, Mesh, Object, Scene, Shape, Texture};
use glam::Vec3Swizzles as _;
use std::sync::Arc;

pub(super) fn compiled(objects: Vec<Object>) -> CompiledScene {
    let scene = Scene { objects, ..Scene::default() };
    compile_scene(&scene, &CompileOptions::default()).expect("a scene that compiles")
}

pub(super) fn sphere(center: DVec3, radius: f64) -> Object {
    Object::new(Shape::Sphere { center, radius })
}

fn cube(min: f64, max: f64) -> Object {
    Object::new(Shape::Box { min: DVec3::splat(min), max: DVec3::splat(max) })
}

fn csg(op: Csg, children: Vec<Object>) -> Object {
    Object::new(Shape::Csg { op, children })
}

/// All depths along a ray, by starting again behind each hit.
pub(super) fn depths(scene: &CompiledScene, origin: DVec3, dir: DVec3) -> Vec<f64> {
    let ray = Ray::new(origin, dir.normalize());
    let (mut out, mut from) = (Vec::new(), MIN_DEPTH);
    while let Some(h) = intersect(scene, &ray, from, f64::INFINITY, 0) {
        out.push((h.t * 1e9).round() / 1e9);
        from = h.t + 1e-4;
    }
    out
}

const FROM: DVec3 = DVec3::new(0.0, 0.0, -10.0);

#[test]
fn difference_shows_the_carved_surface_with_its_normal_turned() {
    let scene = compiled(vec![csg(Csg::Difference, vec![cube(-2.0, 2.0), sphere(DVec3::new(0.0, 0.0, -2.0), 1.0)])]);
    assert_eq!(depths(&scene, FROM, DVec3::Z), [9.0, 12.0]);
    let h = intersect(&scene, &Ray::new(FROM, DVec3::Z), MIN_DEPTH, 1e7, 0).expect("a hit");
    assert!((h.normal - -DVec3::Z).length() < 1e-12, "the sphere's far side, turned: {}", h.normal);
    assert!(!inside_object(&scene, 0, DVec3::new(0.0, 0.0, -1.5)));
    assert!(inside_object(&scene, 0, DVec3::ZERO));
}

#[test]
fn inverse_csg_follows_de_morgan() {
    let pair = || vec![sphere(DVec3::ZERO, 1.0), sphere(DVec3::X, 1.0)];
    for op in [Csg::Union, Csg::Intersection, Csg::Difference, Csg::Merge] {
        let mut inverse = csg(op, pair());
        inverse.flags.inverse = true;
        let mut plain = csg(op, pair());
        plain.flags.split_union = Some(false);
        let scene = compiled(vec![plain, inverse]);
        for k in 0..200 {
            let p = DVec3::new((k % 7) as f64 * 0.6 - 1.5, (k % 5) as f64 * 0.5 - 1.1, (k % 11) as f64 * 0.2 - 1.0);
            assert_ne!(inside_object(&scene, 0, p), inside_object(&scene, 1, p), "{op:?} at {p}");
        }
    }
}

#[test]
fn inverse_intersection_subtracted_leaves_no_inner_surfaces() {
    let tool = csg(Csg::Intersection, vec![sphere(DVec3::ZERO, 1.0), sphere(DVec3::new(0.0, 0.0, 1.0), 1.0)]);
    let scene = compiled(vec![csg(Csg::Difference, vec![cube(-3.0, 3.0), tool])]);
    assert_eq!(depths(&scene, FROM, DVec3::Z), [7.0, 10.0, 11.0, 13.0]);
}

#[test]
fn merge_keeps_outer_surfaces_only_and_union_keeps_all() {
    let pair = || vec![sphere(DVec3::ZERO, 1.0), sphere(DVec3::new(0.0, 0.0, 1.0), 1.0)];
    assert_eq!(depths(&compiled(vec![csg(Csg::Merge, pair())]), FROM, DVec3::Z), [9.0, 12.0]);
    assert_eq!(depths(&compiled(vec![csg(Csg::Union, pair())]), FROM, DVec3::Z), [9.0, 10.0, 11.0, 12.0]);
}

#[test]
fn unions_of_many_shells_are_as_each_shell_by_itself() {
    let shells: Vec<(DVec3, f64)> =
        scattered(150).enumerate().map(|(k, d)| (4.0 * d * ((k % 10) as f64 / 10.0), 0.2 + 0.01 * (k % 40) as f64)).collect();
    let all = || {
        let mut all: Vec<Object> = shells.iter().map(|(c, r)| csg(Csg::Difference, vec![sphere(*c, *r), sphere(*c, 0.8 * r)])).collect();
        // Without bounds.
        all.insert(70, Object::new(Shape::Plane { normal: DVec3::Y, distance: -2.5 }));
        csg(Csg::Union, all)
    };
    let part = csg(Csg::Intersection, vec![all(), cube(-3.0, 3.0)]);
    let rest = csg(Csg::Difference, vec![cube(-3.0, 3.0), all()]);
    let scene = compiled(vec![part, rest]);
    let holds = |p: DVec3| p.y < -2.5 || shells.iter().any(|(c, r)| (0.8 * r..*r).contains(&p.distance(*c)));
    let mut n_inside = 0;
    for (k, d) in scattered(5000).enumerate() {
        let p = 2.9137 * d * (0.2 + 0.1 * (k % 9) as f64);
        assert_eq!([inside_object(&scene, 0, p), inside_object(&scene, 1, p)], [holds(p), !holds(p)], "{p}");
        n_inside += u32::from(holds(p));
    }
    assert!((300..4700).contains(&n_inside), "{n_inside}");
}

#[test]
fn merges_of_many_show_no_surface_inside_any() {
    let balls: Vec<(DVec3, f64)> =
        scattered(60).enumerate().map(|(k, d)| (0.3 * d * (k % 10) as f64, 0.4 + 0.01 * (k % 20) as f64)).collect();
    let scene = compiled(vec![csg(Csg::Merge, balls.iter().map(|(c, r)| sphere(*c, *r)).collect())]);
    let is_inside = |p: DVec3| balls.iter().any(|(c, r)| p.distance(*c) < *r);
    for d in scattered(500) {
        let h = intersect(&scene, &Ray::new(0.1 * d, d), MIN_DEPTH, 1e7, 0).expect("a way out");
        let [before, behind] = [-1e-6, 1e-6].map(|e| is_inside(h.point + e * d));
        assert!(before && !behind, "{h:?}");
    }
}

#[test]
fn clipped_by_makes_holes_without_caps() {
    let mut o = sphere(DVec3::ZERO, 1.0);
    o.clipped_by.push(Object::new(Shape::Plane { normal: -DVec3::Z, distance: 0.0 }));
    let scene = compiled(vec![o]);
    assert_eq!(depths(&scene, FROM, DVec3::Z), [11.0]);
    assert!(!inside_object(&scene, 0, DVec3::new(0.0, 0.0, -0.5)) && inside_object(&scene, 0, DVec3::new(0.0, 0.0, 0.5)));
}

#[test]
fn nested_transforms_reach_leaves_clips_and_bounds() {
    let mut ball = sphere(DVec3::ZERO, 1.0);
    ball.apply_transform(&Transform::scaling(DVec3::new(1.0, 1.0, 2.0)));
    let mut group = Object::new(Shape::Group { child: Arc::new(csg(Csg::Difference, vec![cube(-4.0, 4.0), ball])) });
    group.apply_transform(&Transform::rotation_deg(DVec3::new(0.0, 90.0, 0.0)));
    group.apply_transform(&Transform::translation(DVec3::new(0.0, 0.0, 20.0)));
    let scene = compiled(vec![group]);
    // The ellipsoid's long axis has turned to x.
    assert_eq!(depths(&scene, FROM, DVec3::Z), [26.0, 29.0, 31.0, 34.0]);
    assert_eq!(depths(&scene, DVec3::new(-10.0, 0.0, 20.0), DVec3::X), [6.0, 8.0, 12.0, 14.0]);
}

#[test]
fn shadow_rays_stop_at_opaque_things_and_report_the_nearest_clear_one() {
    let mut glass = sphere(DVec3::ZERO, 1.0);
    glass.texture = Some(Arc::new(Texture::solid(Rgbft { filter: 0.5, ..Rgbft::rgb(1.0, 1.0, 1.0) })));
    let ray = Ray::new(FROM, DVec3::Z);
    let scene = compiled(vec![glass.clone(), sphere(DVec3::new(0.0, 0.0, 5.0), 1.0)]);
    assert!(matches!(intersect_shadow(&scene, &ray, 1e-3, 100.0, u32::MAX), ShadowHit::Opaque { prim_ix: 1 }));
    match intersect_shadow(&scene, &ray, 1e-3, 13.0, 1) {
        ShadowHit::Transparent(h) => assert!((h.t - 9.0).abs() < 1e-12),
        other => panic!("{other:?}"),
    }
    let mut unseen = sphere(DVec3::new(0.0, 0.0, 5.0), 1.0);
    unseen.flags.no_shadow = Some(true);
    assert!(matches!(intersect_shadow(&compiled(vec![unseen]), &ray, 1e-3, 100.0, 0), ShadowHit::None));
}

/// Shapes of the common kinds, turned and stretched, side by side.
pub(super) fn assorted() -> Vec<Object> {
    let shapes = [
        Shape::Sphere { center: DVec3::ZERO, radius: 1.0 },
        Shape::Box { min: DVec3::NEG_ONE, max: DVec3::new(1.0, 0.5, 1.0) },
        Shape::Cylinder { a: DVec3::NEG_Y, b: DVec3::new(0.2, 1.0, 0.0), radius: 0.7, open: false },
        Shape::Cone { a: DVec3::NEG_Y, radius_a: 1.0, b: DVec3::Y, radius_b: 0.3, open: true },
        Shape::Disc { center: DVec3::ZERO, normal: DVec3::new(0.1, 0.9, 0.2).normalize(), radius: 1.0, hole: 0.2 },
    ];
    let placed = (0..40).map(|k| {
        let mut o = Object::new(shapes[k % shapes.len()].clone());
        let k = k as f64;
        o.apply_transform(&Transform::scaling(DVec3::new(0.5 + (k * 0.37).fract(), 0.5 + (k * 0.61).fract(), 0.8)));
        o.apply_transform(&Transform::rotation_deg(DVec3::new(31.0 * k, 17.0 * k, 7.0 * k)));
        o.apply_transform(&Transform::translation(DVec3::new((k * 0.73).fract(), (k * 0.41).fract(), (k * 0.29).fract()) * 8.0 - 4.0));
        o
    });
    placed.chain([Object::new(Shape::Plane { normal: DVec3::Y, distance: -5.0 }), sphere(DVec3::ZERO, 0.6)]).collect()
}

#[test]
fn what_a_shadow_ray_is_told_of_plain_shapes_is_what_the_nearest_hit_says() {
    let scene = compiled(assorted());
    let (mut n_told, mut n_met) = (0, 0);
    for (k, d) in scattered(3000).enumerate() {
        let (from, far) = (d * 9.0, 4.0 + (k % 13) as f64);
        let ray = Ray::new(from, (d.yzx() * 4.0 - from).normalize());
        for (ix, prim) in scene.geometry.prims.iter().enumerate() {
            let mut any = Nearest::any(&scene, &ray, 1e-3, far, (u32::MAX, true));
            any.test(ix as u32);
            if let Some(is_met) = meets_plain(&scene.geometry, prim, &ray, 1e-3, far) {
                assert_eq!(is_met, any.found(), "primitive {ix}, {:?}, {ray:?}", prim.kind);
                (n_told, n_met) = (n_told + 1, n_met + u32::from(is_met));
            }
        }
    }
    assert!(n_told == 3000 * 42 && n_met > 1000, "{n_told} {n_met}");
}

#[test]
fn the_rest_of_a_shadow_ray_meets_what_a_walk_of_its_own_would() {
    let clear = |mut o: Object| {
        o.texture = Some(Arc::new(Texture::solid(Rgbft { filter: 0.5, ..Rgbft::rgb(1.0, 1.0, 1.0) })));
        o
    };
    let mut objects: Vec<Object> = assorted().into_iter().map(clear).collect();
    objects.push(sphere(DVec3::new(30.0, 0.0, 0.0), 1.0));
    let scene = Scene { objects, ..Scene::default() };
    let (mut n_pieces, mut n_full) = (0, 0);
    for accel in [AccelKind::Auto, AccelKind::Kd] {
        let options = CompileOptions { accel, ..CompileOptions::default() };
        let scene = compile_scene(&scene, &options).expect("a scene that compiles");
        for d in scattered(1500) {
            let mut ray = Ray::new(d * 9.0, (d.yzx() * 2.0 - d * 9.0).normalize());
            let (mut left, mut noted) = (20.0, ClearPrims::default());
            let mut met = intersect_shadow_noting(&scene, &ray, 1e-3, left, &ShadowHints::NONE, &mut noted);
            let Some(prims) = noted.all() else {
                n_full += 1;
                continue;
            };
            while let ShadowHit::Transparent(h) = met {
                (ray.origin, left, n_pieces) = (h.point, left - h.t, n_pieces + 1);
                let walked = intersect_shadow(&scene, &ray, 1e-3, left, u32::MAX);
                let known = intersect_clear(&scene, &ray, 1e-3, left, prims);
                let both = match (&walked, &known) {
                    (ShadowHit::Transparent(a), Some(b)) => (a.t, a.prim_ix, a.normal) == (b.t, b.prim_ix, b.normal),
                    (ShadowHit::None, None) => true,
                    _ => false,
                };
                assert!(both, "{accel:?}: {walked:?}, {known:?}");
                met = walked;
            }
        }
    }
    assert!(n_pieces > 2000 && n_full < 300, "{n_pieces} {n_full}");
}

#[test]
fn interiors_of_containing_objects_are_listed_in_order_of_the_hierarchy() {
    let scene = compiled(vec![sphere(DVec3::ZERO, 3.0), cube(4.0, 5.0), Object::new(Shape::Plane { normal: DVec3::Y, distance: 1.0 })]);
    let mut list = Vec::new();
    containing_interiors(&scene, DVec3::ZERO, |i| list.push(i));
    assert_eq!(list, [2, 0].map(|k| scene.geometry.objects[k].interior_ix), "the plane has no end");
}

#[test]
fn torus_cylinder_and_cone_are_hit_where_formulas_say() {
    let torus = compiled(vec![Object::new(Shape::Torus { major: 2.0, minor: 0.5 })]);
    assert_eq!(depths(&torus, DVec3::new(-10.0, 0.0, 0.0), DVec3::X), [7.5, 8.5, 11.5, 12.5]);
    let cylinder = compiled(vec![Object::new(Shape::Cylinder { a: DVec3::ZERO, b: DVec3::new(0.0, 0.0, 4.0), radius: 0.5, open: false })]);
    assert_eq!(depths(&cylinder, FROM, DVec3::Z), [10.0, 14.0]);
    assert_eq!(depths(&cylinder, DVec3::new(0.0, -3.0, 1.0), DVec3::Y), [2.5, 3.5]);
    let cone = Object::new(Shape::Cone { a: DVec3::ZERO, radius_a: 1.0, b: DVec3::new(0.0, 2.0, 0.0), radius_b: 0.0, open: true });
    let cone = compiled(vec![cone]);
    assert_eq!(depths(&cone, DVec3::new(0.0, 1.0, -10.0), DVec3::Z), [9.5, 10.5]);
}

#[test]
fn cut_surfaces_show_the_texture_of_what_they_cut() {
    let mut block = cube(-2.0, 2.0);
    block.texture = Some(Arc::new(Texture::solid(Rgbft::rgb(1.0, 0.0, 0.0))));
    let mut d = csg(Csg::Difference, vec![block, sphere(DVec3::new(0.0, 0.0, -2.0), 1.0)]);
    d.flags.cutaway_textures = Some(true);
    let scene = compiled(vec![d]);
    let h = intersect(&scene, &Ray::new(FROM, DVec3::Z), MIN_DEPTH, 1e7, 0).expect("a hit");
    let mut covers = Vec::new();
    super::cover::for_covers(&scene, &h, false, |c| covers.push(c));
    let block_texture = scene.geometry.surfaces[scene.geometry.prims[0].surface_ix as usize].texture;
    assert_eq!((h.prim_ix, covers.len(), covers[0].texture, covers[0].weight), (1, 1, block_texture, 1.0));
}

#[test]
fn many_subtracted_parts_leave_the_same_holes_as_a_few() {
    // A row of holes: groups of steps are skipped by boxes, the picture must not show it.
    let holes = (0..100).map(|k| sphere(DVec3::new(f64::from(k), 0.0, 0.0), 0.3));
    let block = Object::new(Shape::Box { min: DVec3::new(-1.0, -1.0, 0.0), max: DVec3::new(100.0, 1.0, 1.0) });
    let scene = compiled(vec![csg(Csg::Difference, std::iter::once(block).chain(holes).collect())]);
    for k in 0..390 {
        let x = f64::from(k) * 0.25;
        let from = (x - x.round()).abs();
        let want = if from < 0.3 { 10.0 + (0.09 - from * from).sqrt() } else { 10.0 };
        let got = depths(&scene, DVec3::new(x, 0.0, -10.0), DVec3::Z);
        assert!((got[0] - want).abs() < 1e-9 && (got[1] - 11.0).abs() < 1e-9 && got.len() == 2, "at {x}: {got:?}");
    }
    // One program serves all leaves.
    assert!(scene.geometry.clip_steps.len() < 1000, "{} steps", scene.geometry.clip_steps.len());
}

/// Directions and places all around, the same every time.
pub(super) fn scattered(n: usize) -> impl Iterator<Item = DVec3> {
    (0..n).map(|k| {
        let (a, b) = (k as f64 * 2.399963, k as f64 * 0.754877);
        let z = 1.0 - 2.0 * b.fract();
        let r = (1.0 - z * z).max(0.0).sqrt();
        DVec3::new(r * a.cos(), r * a.sin(), z)
    })
}

#[test]
fn trees_find_what_testing_everything_finds() {
    let objects: Vec<Object> = scattered(300).enumerate().map(|(k, d)| sphere(d * (2.0 + (k % 7) as f64), 0.3)).collect();
    let scene = Scene { objects, ..Scene::default() };
    let with = |accel| {
        let options = CompileOptions { accel, ..CompileOptions::default() };
        compile_scene(&scene, &options).expect("a scene that compiles")
    };
    let brute = with(AccelKind::Brute);
    for kind in [AccelKind::Kd, AccelKind::Bvh] {
        let tree = with(kind);
        for (k, d) in scattered(2000).enumerate() {
            let ray = Ray::new(
                if k % 3 == 0 { DVec3::ZERO } else { d * 12.0 },
                if k % 3 == 0 { d } else { (d.yzx() * 3.0 - d * 12.0).normalize() },
            );
            let found = |s: &CompiledScene| intersect(s, &ray, MIN_DEPTH, f64::INFINITY, 0).map(|h| (h.prim_ix, h.t));
            assert_eq!(found(&tree), found(&brute), "{kind:?}, ray {k}");
            let blocked = |s: &CompiledScene| matches!(intersect_shadow(s, &ray, 1e-3, 9.0, u32::MAX), ShadowHit::Opaque { .. });
            assert_eq!(blocked(&tree), blocked(&brute));
        }
    }
}

#[test]
fn solid_mesh_is_hit_twice_and_knows_its_inside() {
    // A ball of triangles.
    let (n, m) = (64u32, 32u32);
    let at = |i: u32, j: u32| {
        let (a, b) = (f64::from(i % n) / f64::from(n) * std::f64::consts::TAU, f64::from(j) / f64::from(m) * std::f64::consts::PI);
        DVec3::new(b.sin() * a.cos(), b.cos(), b.sin() * a.sin()).as_vec3()
    };
    let mut mesh = Mesh { inside_vector: Some(DVec3::new(0.3, 0.5, 0.2)), ..Mesh::default() };
    mesh.vertices = (0..=m).flat_map(|j| (0..n).map(move |i| at(i, j))).collect();
    for j in 0..m {
        for i in 0..n {
            let [a, b, c, d] = [(i, j), (i + 1, j), (i, j + 1), (i + 1, j + 1)].map(|(i, j)| j * n + i % n);
            mesh.faces.extend([[a, b, c], [b, d, c]]);
        }
    }
    mesh.faces.retain(|f| {
        let [a, b, c] = f.map(|v| mesh.vertices[v as usize]);
        (b - a).cross(c - a).length() > 1e-9
    });
    let mesh = Arc::new(mesh);
    let place = |x: f64| {
        let mut o = Object::new(Shape::Mesh(mesh.clone()));
        o.apply_transform(&Transform::translation(DVec3::X * x));
        o
    };
    let scene = compiled(vec![place(0.0), place(5.0), csg(Csg::Difference, vec![place(10.0), sphere(DVec3::new(10.0, 0.0, -1.0), 0.5)])]);
    assert_eq!(scene.geometry.shapes.meshes.len(), 1, "instances share the mesh");
    for d in scattered(500) {
        assert!(inside_object(&scene, 1, DVec3::X * 5.0 + d * 0.97));
        assert!(!inside_object(&scene, 1, DVec3::X * 5.0 + d * 1.01));
        let t = depths(&scene, DVec3::X * 5.0, d);
        assert!(t.len() % 2 == 1 && t[0] > 0.98 && t[0] <= 1.0 + 1e-6, "{t:?}");
    }
    let dent = depths(&scene, DVec3::new(10.01, 0.013, -10.0), DVec3::Z);
    assert!((dent[0] - 9.5).abs() < 1e-2 && dent.len() == 2, "{dent:?}");
}
