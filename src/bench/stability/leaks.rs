//! Cases 1 to 3: closed meshes do not leak. Every ray from inside meets a face.

use super::figures::{Report, mesh_scene, total};
use super::meshes::{FAR_AWAY, Triangles, ball, tetrahedron};
use crate::accel::AccelKind;
use crate::compile::shape::MeshShape;
use crate::kernel::intersect::mesh::intersect_mesh;
use crate::kernel::intersect::{HitSink, LocalRay, Part};
use crate::math::DVec3;
use crate::math::random::SplitMix64;

/// Where rays in a mesh start: around `middle`, up to `near` from it on each axis.
struct Closed {
    name: &'static str,
    mesh: Triangles,
    middle: DVec3,
    near: f64,
}

fn closed() -> [Closed; 3] {
    // Dents that stay clear of the middle.
    let lumpy = |p: DVec3| p * (1.0 + 0.3 * (5.0 * p.x).sin() * (4.0 * p.y).cos() * (6.0 * p.z).sin());
    [
        Closed { name: "ball of 81,920 faces", mesh: ball(6, true, 2.0), middle: DVec3::ZERO, near: 0.9 },
        Closed { name: "dented ball of 20,480 faces", mesh: ball(5, true, 1.0).mapped(lumpy), middle: DVec3::ZERO, near: 0.3 },
        Closed { name: "tetrahedron", mesh: tetrahedron(), middle: DVec3::ZERO, near: 0.3 },
    ]
}

/// What rays are sent at.
#[derive(Clone, Copy, PartialEq)]
enum Aim {
    Anywhere,
    Vertex,
    Edge,
}

struct Nearest(f64);

impl HitSink for Nearest {
    fn push(&mut self, t: f64, _: Part) {
        self.0 = self.0.min(t);
    }

    fn far(&self) -> f64 {
        self.0
    }
}

/// Whether a ray (`dir` unit, in the mesh's space) meets a face, as the kernel tests them.
pub fn meets_face(shape: &MeshShape, origin: DVec3, dir: DVec3) -> bool {
    let mut sink = Nearest(f64::INFINITY);
    intersect_mesh(shape, &LocalRay { origin, dir, scale: 1.0 }, &mut sink);
    sink.0 < f64::INFINITY
}

impl Closed {
    /// Start and direction.
    fn ray(&self, r: &mut SplitMix64, aim: Aim) -> (DVec3, DVec3) {
        let from = self.middle + self.near * r.cube();
        let [a, b, _] = self.mesh.corners(r.below(self.mesh.faces.len()));
        let dir = match aim {
            Aim::Anywhere => r.direction(),
            Aim::Vertex => a - from,
            Aim::Edge => a + r.unit() * (b - a) - from,
        };
        (from, dir.normalize())
    }

    fn count(&self, report: &mut Report, share: u64, aim: Aim) {
        if !self.name.contains(&report.effort.meshes) {
            return;
        }
        let at = match aim {
            Aim::Anywhere => "random",
            Aim::Vertex => "at vertices",
            Aim::Edge => "at edges",
        };
        let what = |kind: AccelKind| format!("leaks of {at} rays, {}, {}", self.name, kind.name());
        let n = report.rays(share);
        for kind in [AccelKind::Kd, AccelKind::Bvh, AccelKind::Bvh8] {
            let scene = mesh_scene(&self.mesh, kind);
            let shape: &MeshShape = &scene.geometry.shapes.meshes[0];
            let lost = total(n, 1, |r| {
                let (origin, dir) = self.ray(r, aim);
                u64::from(!meets_face(shape, origin, dir))
            });
            report.cpu(what(kind), lost as f64, 0.0, n);
            #[cfg(feature = "gpu")]
            if kind != AccelKind::Bvh8 {
                self.count_on_gpus(report, &scene, kind, &what(kind), n, aim);
            }
        }
        report.embree_leaks(&format!("leaks of {at} rays, {}", self.name), &self.mesh, n, |r| self.ray(r, aim));
    }

    #[cfg(feature = "gpu")]
    fn count_on_gpus(&self, report: &mut Report, scene: &crate::compile::CompiledScene, kind: AccelKind, what: &str, n: u64, aim: Aim) {
        use crate::backend::gpu::ray_bench::{BenchRay, RayBench};
        /// Rays of one dispatch: 128 MiB with their hits.
        const BATCH: u64 = 1 << 21;
        for gpu in std::mem::take(&mut report.gpus) {
            let most = if gpu.info.device_type == wgpu::DeviceType::Cpu { 1 << 18 } else { 1 << 26 };
            let n = n.min(most);
            let lost = RayBench::new(&gpu, scene, kind).and_then(|bench| {
                let mut lost = 0;
                let mut r = SplitMix64(2);
                for first in (0..n).step_by(BATCH as usize) {
                    let ray = |_| {
                        let (origin, dir) = self.ray(&mut r, aim);
                        BenchRay { origin: origin.as_vec3().to_array(), t_max: 1e30, dir: dir.as_vec3().to_array(), padding: 0.0 }
                    };
                    let rays: Vec<BenchRay> = (0..BATCH.min(n - first)).map(ray).collect();
                    lost += bench.trace_once(&rays, false)?.iter().filter(|t| t.is_infinite()).count();
                }
                Ok(lost)
            });
            report.add(gpu.name(), what.to_owned(), lost.map_or(f64::NAN, |n| n as f64), 0.0, n);
            report.gpus.push(gpu);
        }
    }
}

pub(super) fn random(report: &mut Report) {
    for c in closed() {
        c.count(report, 1, Aim::Anywhere);
    }
}

pub(super) fn aimed(report: &mut Report) {
    for c in closed() {
        c.count(report, 10, Aim::Vertex);
        c.count(report, 10, Aim::Edge);
    }
}

pub(super) fn moved(report: &mut Report) {
    let [ball, _, tetrahedron] = closed();
    let far = |c: &Closed, name| Closed { name, mesh: c.mesh.clone().mapped(|p| p + FAR_AWAY), middle: FAR_AWAY, near: c.near };
    // Not nearer to a face than 1e-6, POV-Ray's least depth, in the tiny one.
    let scaled = |s: f64, name| Closed { name, mesh: ball.mesh.clone().mapped(|p| s * p), middle: DVec3::ZERO, near: s * 0.3 };
    let list = [
        (far(&ball, "ball at (148376, 1234, -223423)"), 1),
        (far(&tetrahedron, "tetrahedron at (148376, 1234, -223423)"), 1),
        (scaled(1e-6, "ball of 2e-6"), 10),
        (scaled(1e6, "ball of 2e6"), 10),
    ];
    for (c, share) in list {
        c.count(report, share, Aim::Anywhere);
        c.count(report, 10, Aim::Vertex);
        c.count(report, 10, Aim::Edge);
    }
}
