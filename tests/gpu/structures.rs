//! Every structure on the device gives brute force's hits: degenerate rays among them. Trees broken on purpose do not.

use crate::found;
use rayloom::accel::{Accel, AccelKind, STRUCTURES};
use rayloom::backend::gpu::ray_bench::{BenchRay, RayBench};
use rayloom::backend::gpu::{Gpu, GpuOptions};
use rayloom::bench::stability::meshes::{Triangles, ball, flat, needles, nested_boxes, soup, teapot_in_stadium, terrain, tetrahedron};
use rayloom::bench::stability::ray_source::RaySource;
use rayloom::compile::{CompileOptions, CompiledScene, compile_scene};
use rayloom::math::random::SplitMix64;
use rayloom::math::{Bounds, DVec3, Ray, Transform};
use rayloom::scene::{Csg, Mesh, Object, Scene, Shape};
use std::sync::Arc;

/// Rays a scene, unless `RAYLOOM_RAYS` says how many: software devices trace some 100,000 a second of each kind.
const N_RAYS: usize = 100_000;
/// Of these, so many may differ: a face met edge on has no certain depth, and what its tree skips need not be what it is compared with.
const MAY_DIFFER: usize = 4;

fn n_rays() -> usize {
    std::env::var("RAYLOOM_RAYS").ok().and_then(|v| v.parse().ok()).unwrap_or(N_RAYS)
}

fn gpu() -> Option<Gpu> {
    found(Gpu::new(&GpuOptions { accept_software: true, ..GpuOptions::default() }))
}

fn compiled(objects: Vec<Object>, accel: AccelKind) -> CompiledScene {
    let scene = Scene { objects, ..Scene::default() };
    compile_scene(&scene, &CompileOptions { accel, ..CompileOptions::default() }).expect("a scene that compiles")
}

fn mesh_object(mesh: &Triangles) -> Object {
    Object::new(Shape::Mesh(Arc::new(Mesh { vertices: mesh.vertices.clone(), faces: mesh.faces.clone(), ..Mesh::default() })))
}

fn rounded(ray: &Ray, t_max: f32) -> BenchRay {
    BenchRay { origin: ray.origin.as_vec3().to_array(), t_max, dir: ray.dir.as_vec3().to_array(), padding: 0.0 }
}

/// Rays whose nearest hits, and whose any-hits, are not those of brute force.
fn differing(gpu: &Gpu, scene: &CompiledScene, kind: AccelKind, rays: &[BenchRay], truth: &[Vec<f32>; 2]) -> [usize; 2] {
    let bench = RayBench::new(gpu, scene, kind).expect("a scene that the device takes");
    [false, true].map(|any_hit| {
        let got = bench.trace_once(rays, any_hit).expect("traces");
        got.iter().zip(&truth[usize::from(any_hit)]).filter(|(a, b)| a != b).count()
    })
}

fn truth(gpu: &Gpu, scene: &CompiledScene, rays: &[BenchRay]) -> [Vec<f32>; 2] {
    let bench = RayBench::new(gpu, scene, AccelKind::Brute).expect("a scene that the device takes");
    let truth = [false, true].map(|any| bench.trace_once(rays, any).expect("traces"));
    let n_hits = truth[0].iter().filter(|t| t.is_finite()).count();
    assert!(n_hits > rays.len() / 20, "rays that hit nothing prove nothing: {n_hits} hits");
    truth
}

/// All structures over `objects`, for rays that aim at `aims`.
fn agree_on(name: &str, objects: &[Object], aims: &Triangles) {
    let Some(gpu) = gpu() else { return };
    let size = Bounds::from_points(aims.vertices.iter().map(|v| v.as_dvec3())).size().max_element();
    let limits = [3e38, 0.4 * size as f32];
    let rays: Vec<BenchRay> = RaySource::new(aims, 3).take(n_rays()).enumerate().map(|(k, r)| rounded(&r, limits[k % 7 / 6])).collect();
    let truth = truth(&gpu, &compiled(objects.to_vec(), AccelKind::Brute), &rays);
    for s in STRUCTURES.iter().filter(|s| s.kind != AccelKind::Brute) {
        let apart = differing(&gpu, &compiled(objects.to_vec(), s.kind), s.kind, &rays, &truth);
        println!("{name}, {}: {apart:?} of {} rays differ", s.name, rays.len());
        assert!(apart.iter().all(|n| *n <= MAY_DIFFER), "{name}, {}: {apart:?} rays differ", s.name);
    }
}

fn meshes_agree(name: &str, mesh: &Triangles) {
    agree_on(name, &[mesh_object(mesh)], mesh);
}

#[test]
fn structures_give_brute_forces_hits_on_meshes() {
    meshes_agree("soup", &soup(150, 0.5, 1));
    meshes_agree("ball", &ball(1, true, 1.0));
    meshes_agree("flat grid", &flat(8));
    meshes_agree("needles", &needles(120));
    meshes_agree("far away", &ball(1, true, 2.0).mapped(|p| p + DVec3::new(1483.0, 12.0, -2234.0)));
    meshes_agree("teapot in a stadium", &teapot_in_stadium());
    meshes_agree("terrain", &terrain(9));
    meshes_agree("boxes that share faces", &nested_boxes(10));
    meshes_agree("tetrahedron", &tetrahedron());
}

/// Primitives of many kinds, on a lattice and off it.
fn mixed() -> Vec<Object> {
    let mut r = SplitMix64(41);
    let part = soup(20, 0.3, 43);
    (0..60)
        .map(|k| {
            let size = 0.1 + 0.3 * r.unit();
            let cube = |r: f64| Object::new(Shape::Box { min: DVec3::splat(-r), max: DVec3::splat(r) });
            let sphere = |center, radius| Object::new(Shape::Sphere { center, radius });
            let mut o = match k % 6 {
                0 => cube(size),
                1 => sphere(DVec3::ZERO, size),
                2 => Object::new(Shape::Torus { major: size, minor: 0.3 * size }),
                3 => Object::new(Shape::Cylinder { a: DVec3::ZERO, b: DVec3::Y * size, radius: 0.4 * size, open: k % 4 == 0 }),
                4 => Object::new(Shape::Csg { op: Csg::Difference, children: vec![cube(size), sphere(DVec3::splat(0.7 * size), size)] }),
                _ => mesh_object(&part),
            };
            if k % 3 > 0 {
                o.apply_transform(&Transform::rotation_deg(r.cube() * 180.0));
            }
            let place = r.cube() * 3.0;
            o.apply_transform(&Transform::translation(if k % 6 == 0 { place.round() } else { place }));
            o
        })
        .collect()
}

#[test]
fn structures_give_brute_forces_hits_on_mixed_primitives() {
    let objects = mixed();
    let mut aims = Triangles::default();
    for Bounds { min, max } in &compiled(objects.clone(), AccelKind::Brute).geometry.bounds {
        aims.add_box(*min, *max);
    }
    agree_on("mixed primitives", &objects, &aims);
}

/// Differences after `damage` more than before.
fn faults(gpu: &Gpu, kind: AccelKind, damage: impl FnOnce(&mut Accel)) -> usize {
    let mesh = soup(400, 0.3, 4);
    let rays: Vec<BenchRay> = RaySource::new(&mesh, 21).take(20_000).map(|r| rounded(&r, 3e38)).collect();
    let truth = truth(gpu, &compiled(vec![mesh_object(&mesh)], AccelKind::Brute), &rays);
    let mut scene = compiled(vec![mesh_object(&mesh)], kind);
    let before = differing(gpu, &scene, kind, &rays, &truth);
    assert!(before.iter().all(|n| *n <= MAY_DIFFER), "{kind:?} before the damage: {before:?}");
    damage(scene.geometry.shapes.meshes[0].tree_mut().expect("nobody shares it"));
    differing(gpu, &scene, kind, &rays, &truth)[0].saturating_sub(MAY_DIFFER)
}

#[test]
fn broken_trees_are_caught_on_the_device() {
    let Some(gpu) = gpu() else { return };
    for kind in [AccelKind::Kd, AccelKind::KdShort, AccelKind::KdRestart] {
        let n = faults(&gpu, kind, |t| {
            let Accel::Kd(t) = t else { panic!("a kd-tree was asked for") };
            let n = t.nodes[0];
            t.nodes[0] = rayloom::accel::KdNode::inner(n.axis(), n.split() + 0.05, n.above_or_count());
        });
        assert!(n > 0, "{kind:?}: a shifted plane");
    }
    let n = faults(&gpu, AccelKind::Bvh, |t| {
        let Accel::Bvh(t) = t else { panic!("a BVH was asked for") };
        t.nodes[0].planes[1][1][0] -= 0.05;
    });
    assert!(n > 0, "a smaller box");
    let n = faults(&gpu, AccelKind::BvhSkip, |t| {
        let Accel::BvhSkip(t) = t else { panic!("a BVH with skip links was asked for") };
        t.nodes[0].hi[1] -= 0.1;
    });
    assert!(n > 0, "a smaller box without a stack");
    let n = faults(&gpu, AccelKind::Wide, |t| {
        let Accel::Wide(t) = t else { panic!("a wide BVH was asked for") };
        t.nodes[0].exponents_inner[2] -= 1;
    });
    assert!(n > 0, "a smaller lattice");
    for kind in [AccelKind::Grid, AccelKind::HierarchicalGrid] {
        let n = faults(&gpu, kind, |t| {
            let Accel::Grid(t) = t else { panic!("a grid was asked for") };
            t.entries.iter_mut().step_by(3).for_each(|e| (e.lo, e.hi) = (0, u32::MAX >> 2));
        });
        assert!(n > 0, "{kind:?}: primitives that seem seen");
    }
}
