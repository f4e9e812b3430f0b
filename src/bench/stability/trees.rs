//! Cases 4 to 9, 20 and 22: trees keep what is there, whatever the rays and the geometry.

use super::figures::{Report, mesh_scene, total};
use super::meshes::{
    FAR_AWAY, Triangles, ball, flat as flat_mesh, needles as needle_mesh, nested_boxes, soup, teapot_in_stadium, terrain, tetrahedron,
};
use super::oracle::{Faults, Oracle, build};
use super::ray_source::{AXIS_RAYS, PLANE_RAYS, RaySource};
use crate::accel::{AccelKind, STRUCTURES};
use crate::math::{DVec3, Ray};
use rayon::prelude::*;
use std::time::Instant;

/// All structures that are not brute force.
fn trees() -> Vec<AccelKind> {
    let is_brute = |k: &AccelKind| matches!(k, AccelKind::Brute | AccelKind::BruteTiled | AccelKind::BruteGroup);
    STRUCTURES.iter().map(|s| s.kind).filter(|k| !is_brute(k)).collect()
}

/// Faults of every structure, `n` rays of the given kinds in parts that run side by side.
fn faults(mesh: &Triangles, n: u64, kinds: Option<&[usize]>) -> Vec<(AccelKind, Faults)> {
    const PARTS: u64 = 16;
    let oracle = Oracle::new(mesh);
    let built: Vec<_> = trees().into_iter().map(|k| (k, build(k, mesh))).collect();
    let parts: Vec<Vec<Faults>> = (0..PARTS)
        .into_par_iter()
        .map(|seed| {
            let source = RaySource::new(mesh, 100 + seed);
            let source = if let Some(k) = kinds { source.only(k) } else { source };
            let mut all = vec![Faults::default(); built.len()];
            for ray in source.take(n.div_ceil(PARTS) as usize) {
                let truth = oracle.brute(&ray);
                built.iter().zip(&mut all).for_each(|((_, tree), faults)| oracle.check(tree, &ray, truth, faults));
            }
            all
        })
        .collect();
    let sum = |k: usize| parts.iter().map(|p| p[k]).fold(Faults::default(), Faults::plus);
    built.iter().enumerate().map(|(k, (kind, _))| (*kind, sum(k))).collect()
}

/// One figure a structure: faults over all `meshes`.
fn count_faults(report: &mut Report, what: &str, meshes: &[Triangles], n: u64, kinds: Option<&[usize]>) {
    let mut sums: Vec<(AccelKind, u64)> = trees().into_iter().map(|k| (k, 0)).collect();
    for mesh in meshes {
        for (sum, (_, f)) in sums.iter_mut().zip(faults(mesh, n, kinds)) {
            sum.1 += f.count() as u64;
        }
    }
    for (kind, n_faults) in sums {
        report.cpu(format!("{what}, {}", kind.name()), n_faults as f64, 0.0, n * meshes.len() as u64);
    }
}

pub(super) fn against_brute_force(report: &mut Report) {
    let small = [
        soup(300, 0.3, 1),
        soup(300, 2.0, 2),
        soup(60, 8.0, 3),
        ball(2, true, 1.0),
        ball(2, false, 1.0),
        terrain(12),
        flat_mesh(12),
        needle_mesh(200),
        nested_boxes(12),
        tetrahedron(),
    ];
    let far = |m: &Triangles| m.clone().mapped(|p| p + FAR_AWAY);
    let scaled = |m: &Triangles, s: f64| m.clone().mapped(|p| s * p);
    let mut meshes: Vec<Triangles> = small[..6].iter().map(far).collect();
    meshes.extend([scaled(&small[0], 1e-6), scaled(&small[3], 1e6), teapot_in_stadium()]);
    meshes.push(small[3].clone().mapped(|p| p * DVec3::new(1.0, 1e-5, 1e3)));
    meshes.extend(small);
    let n = report.rays(1000);
    count_faults(report, "hits lost, farther, unblocked or invented", &meshes, n, None);
}

pub(super) fn along_axes(report: &mut Report) {
    let n = report.rays(1000);
    let meshes = [soup(300, 0.3, 4), terrain(12), flat_mesh(12), nested_boxes(12), ball(2, false, 1.0)];
    count_faults(report, "faults", &meshes, n, Some(&AXIS_RAYS));
}

pub(super) fn flat(report: &mut Report) {
    let n = report.rays(1000);
    count_faults(report, "faults", &[flat_mesh(12), flat_mesh(3)], n, Some(&PLANE_RAYS));
}

pub(super) fn needles(report: &mut Report) {
    let n = report.rays(1000);
    // Aspect ratios to 1e7; areas below 1e-20.
    let slivers = needle_mesh(300).mapped(|p| p * DVec3::new(1.0, 1e-8, 1e-8));
    count_faults(report, "faults", &[needle_mesh(300), slivers], n, None);
}

/// Numbers that rays are spoilt with.
const SPOILT: [f64; 3] = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY];

pub(super) fn no_rays(report: &mut Report) {
    let mesh = ball(3, true, 1.0);
    let oracle = Oracle::new(&mesh);
    for kind in trees() {
        let tree = build(kind, &mesh);
        let mut offered = 0u64;
        let mut n = 0;
        let mut cast = |ray: Ray, t_min: f64, t_max: f64| {
            n += 1;
            tree.closest(&ray, t_min, t_max, |_, _| {
                offered += 1;
                None
            });
            offered += u64::from(tree.any(&ray, t_min, t_max, |_| true));
        };
        for k in 0..6 {
            for bad in SPOILT {
                let mut numbers = [0.1, 0.2, -5.0, 0.0, 0.0, 1.0];
                numbers[k] = bad;
                let [a, b, c, d, e, f] = numbers;
                cast(Ray::new(DVec3::new(a, b, c), DVec3::new(d, e, f)), 0.0, f64::INFINITY);
            }
        }
        let good = Ray::new(DVec3::new(0.1, 0.2, -5.0), DVec3::Z);
        cast(Ray::new(good.origin, DVec3::ZERO), 0.0, f64::INFINITY);
        for (t_min, t_max) in [(2.0, 1.0), (f64::NAN, 1.0), (0.0, f64::NAN), (0.0, -1.0)] {
            cast(good, t_min, t_max);
        }
        report.cpu(format!("primitives offered, {}", kind.name()), offered as f64, 0.0, n);
        let found = oracle.closest(&tree, &good).is_finite() && tree.any(&good, -0.0, f64::INFINITY, |_| true);
        report.cpu(format!("good rays that meet nothing afterwards, {}", kind.name()), f64::from(u8::from(!found)), 0.0, 1);
    }
}

fn garbage_mesh(n: usize) -> Triangles {
    let mut mesh = soup(n, 0.1, 7);
    for (k, bad) in SPOILT.into_iter().chain([1e30, -1e30, 3e38]).enumerate() {
        let v = mesh.vertices.len() / 7 * k;
        mesh.vertices[v].x = bad as f32;
    }
    // No area at all, and one face n/4 times.
    (0..n / 20).for_each(|k| mesh.faces[k * 3] = [(k * 3) as u32; 3]);
    let same = mesh.faces[1];
    mesh.faces.extend(std::iter::repeat_n(same, n / 4));
    mesh
}

pub(super) fn garbage(report: &mut Report) {
    /// Deepest tree that walks have room for.
    const DEPTH: f64 = 64.0;
    let (small, large) = (garbage_mesh(10_000), garbage_mesh(80_000));
    for kind in trees() {
        let time = |mesh: &Triangles| {
            let start = Instant::now();
            let depth = build(kind, mesh).stats().depth;
            (start.elapsed().as_secs_f64(), depth)
        };
        // The least of three: other programs run as well.
        let least = |mesh: &Triangles| (0..3).map(|_| time(mesh).0).fold(f64::INFINITY, f64::min);
        let exponent = (least(&large) / least(&small)).ln() / 8f64.ln();
        report.cpu(format!("growth of build time with size (1: linear), {}", kind.name()), exponent, 1.5, 2);
        report.cpu(format!("depth of the tree, {}", kind.name()), time(&large).1 as f64, DEPTH, 1);
    }
}

pub(super) fn denormal(report: &mut Report) {
    let normal = ball(5, true, 1.0);
    let tiny = normal.clone().mapped(|p| p * 1e-38);
    for kind in [AccelKind::Kd, AccelKind::Bvh, AccelKind::Bvh8] {
        let n = report.rays(100);
        let time = |mesh: &Triangles, scale: f64| {
            let (tree, oracle) = (build(kind, mesh), Oracle::new(mesh));
            let once = || {
                let start = Instant::now();
                let lost = total(n, 3, |r| {
                    let (from, dir) = (0.5 * scale * r.cube(), r.direction());
                    u64::from(oracle.closest_above(&tree, &Ray::new(from, dir), 0.0) == f64::INFINITY)
                });
                (lost, start.elapsed().as_secs_f64())
            };
            (0..3).map(|_| once()).min_by(|a, b| a.1.total_cmp(&b.1)).expect("three rounds")
        };
        let ((_, normal_time), (lost, tiny_time)) = (time(&normal, 1.0), time(&tiny, 1e-38));
        report.cpu(format!("leaks, {}", kind.name()), lost as f64, 0.0, n);
        report.cpu(format!("time of the scene of 1, {}", kind.name()), tiny_time / normal_time, 2.0, n);
    }
}

/// Depths that differ by more than 8 units in the last place of 32-bit numbers at the scene's size, over the cosine to the face: what
/// a place that is off by so much along the face does to a depth.
pub(super) fn against_gpu(report: &mut Report) {
    #[cfg(feature = "gpu")]
    on_gpus(report);
    #[cfg(not(feature = "gpu"))]
    let _ = (report, mesh_scene);
}

#[cfg(feature = "gpu")]
fn on_gpus(report: &mut Report) {
    use crate::backend::gpu::ray_bench::{BenchRay, RayBench};
    use crate::kernel::traverse::{MIN_DEPTH, intersect};
    let meshes = [("terrain", terrain(100)), ("ball", ball(5, true, 1.0)), ("soup", soup(5000, 0.2, 9))];
    for gpu in std::mem::take(&mut report.gpus) {
        let most = if gpu.info.device_type == wgpu::DeviceType::Cpu { 1 << 17 } else { 1 << 22 };
        for (name, mesh) in &meshes {
            let n = report.rays(10).min(most);
            let as_f32 = |r: Ray| Ray::new(r.origin.as_vec3().as_dvec3(), r.dir.as_vec3().as_dvec3());
            let rays: Vec<Ray> = RaySource::new(mesh, 5).only(&[0, 1, 3]).take(n as usize).map(as_f32).collect();
            for kind in [AccelKind::Kd, AccelKind::Bvh, AccelKind::Wide] {
                let scene = mesh_scene(mesh, kind);
                let of = |r: &Ray| BenchRay {
                    origin: r.origin.as_vec3().to_array(),
                    t_max: 1e30,
                    dir: r.dir.as_vec3().to_array(),
                    padding: 0.0,
                };
                let list: Vec<BenchRay> = rays.iter().map(of).collect();
                let depths = RayBench::new(&gpu, &scene, kind).and_then(|b| b.trace_once(&list, false));
                let apart = depths.map_or(f64::NAN, |depths| {
                    let differs = |(ray, t): (&Ray, &f32)| {
                        let Some(hit) = intersect(&scene, ray, MIN_DEPTH, 1e30, 0) else { return u64::from(t.is_finite()) };
                        let slant = hit.normal.dot(ray.dir).abs();
                        let slack = 8.0 * f64::from(f32::EPSILON) * (hit.t + ray.origin.length()) / slant;
                        u64::from((hit.t - f64::from(*t)).abs() > slack)
                    };
                    rays.par_iter().zip(&depths).map(differs).sum::<u64>() as f64
                });
                report.add(gpu.name(), format!("share of rays that differ, {name}, {}", kind.name()), apart / n as f64, 1e-6, n);
            }
        }
        report.gpus.push(gpu);
    }
}
