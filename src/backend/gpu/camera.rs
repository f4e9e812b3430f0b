//! Camera rays of a batch, made here in double precision for every projection; the shaders take them from there.
//!
//! A ray's direction in 32 bits is off by 6e-8 of the way to what it meets. Where nothing lies between the camera and the scene's box,
//! rays start at the box, so that what is left of the way is short.

use super::layout::Start;
use crate::compile::CompiledScene;
use crate::integrate::classic::{ScenePlan, single_ray};
use crate::integrate::samples::hash;
use crate::math::{Bounds, Ray};
use rayon::prelude::*;

/// Makes camera rays.
pub(super) struct CameraRays<'s> {
    scene: &'s CompiledScene,
    plan: &'s ScenePlan,
    /// Box of everything that can be met, if rays may start at it.
    start_box: Option<Bounds>,
}

impl<'s> CameraRays<'s> {
    /// For `scene`. The air must be empty for rays to start late: no fog, no interior around the camera.
    pub fn new(scene: &'s CompiledScene, plan: &'s ScenePlan) -> Self {
        let g = &scene.geometry;
        let is_empty = scene.fogs.is_empty() && plan.camera_interiors.as_ref().is_some_and(|list| list.is_empty());
        let all = g.bounded.iter().map(|p| g.bounds[*p as usize]).reduce(Bounds::union);
        let start_box = all.filter(|b| is_empty && g.unbounded.is_empty() && b.min.is_finite() && b.max.is_finite());
        Self { scene, plan, start_box }
    }

    /// The ray of each picture position; integers are pixel centres.
    pub fn starts(&self, positions: &[(f64, f64)]) -> Vec<Start> {
        let start = |(x, y): &(f64, f64)| {
            let ray = single_ray(self.scene, self.plan, *x, *y)?;
            Some(Start { key: position_key(*x, *y), ..self.start(&ray) })
        };
        positions.par_iter().map(|p| start(p).unwrap_or_default()).collect()
    }

    fn start(&self, ray: &Ray) -> Start {
        let t = self.start_box.map_or(0.0, |b| entry(ray, &b));
        Start { origin: ray.at(t).as_vec3().to_array(), shown: 1, dir: ray.dir.as_vec3().to_array(), key: 0 }
    }
}

/// Key of the random numbers of a picture position.
fn position_key(x: f64, y: f64) -> u32 {
    [x, y].iter().fold(0, |key, v| {
        let bits = v.to_bits();
        hash(hash(key ^ bits as u32) ^ (bits >> 32) as u32)
    })
}

/// Depth shortly before the ray enters the box; 0 inside and where it passes by.
fn entry(ray: &Ray, b: &Bounds) -> f64 {
    let inverse = ray.dir.recip();
    let (a, c) = ((b.min - ray.origin) * inverse, (b.max - ray.origin) * inverse);
    let near = a.min(c).max_element();
    let far = a.max(c).min_element();
    let margin = 0.01 * (b.max - b.min).max_element();
    if near <= far && near.is_finite() { (near - margin).max(0.0) } else { 0.0 }
}
