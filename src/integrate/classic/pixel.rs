//! One picture position: camera rays, the lens of focal blur, the rays of a mesh camera. Source: spec/light.md, sections 1 and 11.

use super::plan::{ScenePlan, interiors_at};
use super::ray::{Seen, TraceRay};
use super::texturing as cover;
use super::trace::Tracer;
use crate::compile::CompiledScene;
use crate::kernel::PatternPoint;
use crate::kernel::lens::Lens;
use crate::math::{DVec2, DVec3, Ray, Vec3};

/// Lens rays that are made together.
const RAYS_AT_ONCE: usize = 8;

impl Tracer<'_> {
    /// Colour and transmit seen at picture position (x, y): integers are pixel centres, y runs down.
    pub fn pixel(&mut self, x: f64, y: f64) -> [f32; 4] {
        let plan = self.plan;
        if let Some(mesh) = &plan.camera.mesh {
            let (mut sum, mut n) = ([0.0f32; 4], 0u32);
            for m in 0..mesh.n_rays() {
                if let Some(ray) = mesh.ray(m, x, y, plan.camera.resolution()) {
                    let c = self.camera_ray(ray, mesh.max_depth());
                    (0..4).for_each(|k| sum[k] += c[k]);
                    n += 1;
                }
            }
            return if n == 0 { self.nothing() } else { sum.map(|v| v / n as f32) };
        }
        if let Some(lens) = &plan.camera.lens {
            return self.blurred(lens, x, y);
        }
        match single_ray(self.scene, plan, x, y) {
            Some(ray) => self.camera_ray(ray, f64::INFINITY),
            None => self.nothing(),
        }
    }

    /// What a projection shows beyond its rim.
    fn nothing(&self) -> [f32; 4] {
        [0.0, 0.0, 0.0, if self.plan.output_alpha { 1.0 } else { 0.0 }]
    }

    fn blurred(&mut self, lens: &Lens, x: f64, y: f64) -> [f32; 4] {
        let (mut sum, mut sum_sq) = ([0.0f32; 4], [0.0f32; 4]);
        let (mut n, mut group) = (0u32, 0usize);
        let mut rays = [None; RAYS_AT_ONCE];
        while n < lens.max_samples() {
            let end = n + lens.group(group).min(lens.max_samples() - n);
            while n < end {
                // Made one after another: each waits for a root and a quotient, and their waits overlap.
                let n_rays = (end - n).min(rays.len() as u32);
                for k in 0..n_rays {
                    rays[k as usize] = self.plan.camera.lens_ray(lens, x, y, n + k);
                }
                for ray in &rays[..n_rays as usize] {
                    let c = match *ray {
                        Some((ray, at)) => self.camera_ray(bent(self.scene, self.plan, ray, at), f64::INFINITY),
                        None => self.nothing(),
                    };
                    for k in 0..4 {
                        sum[k] += c[k];
                        sum_sq[k] += c[k] * c[k];
                    }
                }
                n += n_rays;
            }
            group += 1;
            if lens.is_settled(n, sum, sum_sq) {
                break;
            }
        }
        sum.map(|v| v / n as f32)
    }

    fn camera_ray(&mut self, ray: Ray, max_depth: f64) -> [f32; 4] {
        let interiors = match &self.plan.camera_interiors {
            Some(list) => list.clone(),
            None => interiors_at(self.scene, ray.origin),
        };
        let r = TraceRay { max_depth, ..TraceRay::primary(ray, interiors) };
        let Seen { rgb, transmit, .. } = self.trace(&r, 1.0, false);
        let rgb = if rgb.is_finite() { rgb } else { Vec3::ZERO };
        [rgb.x, rgb.y, rgb.z, transmit]
    }
}

/// The one ray of a position of a camera without lens and mesh; `None` where the projection shows nothing.
pub fn single_ray(scene: &CompiledScene, plan: &ScenePlan, x: f64, y: f64) -> Option<Ray> {
    plan.camera.ray(x, y).map(|(ray, at)| bent(scene, plan, ray, at))
}

/// The ray with the camera's normal applied to its direction.
pub fn bent(scene: &CompiledScene, plan: &ScenePlan, ray: Ray, at: DVec3) -> Ray {
    let Some(normal_ix) = plan.camera.normal_ix else { return ray };
    let p = PatternPoint { point: at, uv: DVec2::ZERO, world: at, normal: DVec3::ZERO, ray_dir: DVec3::ZERO };
    let dir = cover::perturb_in_world(scene, normal_ix, ray.dir, &p);
    Ray::new(ray.origin, dir.try_normalize().unwrap_or(ray.dir))
}
