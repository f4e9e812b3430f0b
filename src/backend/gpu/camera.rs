//! Camera rays that the host makes, in double precision, for every projection, lens and mesh: those that `camera_buffers.rs` does not hand to the
//! device, and all where it has no numbers of 64 bits.
//!
//! A ray's direction in 32 bits is off by 6e-8 of the way to what it meets. Where nothing lies between the camera and the scene's box,
//! rays start at the box, so that what is left of the way is short.

use super::buffers::{low_part, low_part3, v3};
use super::layout::{MAX_INTERIORS, Start};
use super::wavefront::Places;
use crate::backend::BackendError;
use crate::compile::CompiledScene;
use crate::compile::geometry::prim_flags;
use crate::integrate::classic::{InteriorList, ScenePlan, bent, interiors_at, single_ray};
use crate::integrate::samples::hash;
use crate::kernel::lens::Lens;
use crate::kernel::mesh_camera::MeshCamera;
use crate::math::{Bounds, Ray};
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};

/// Makes camera rays.
pub(super) struct CameraRays<'s> {
    scene: &'s CompiledScene,
    plan: &'s ScenePlan,
    /// Box of everything that can be met, if rays may start at it.
    start_box: Option<Bounds>,
    /// What rays start in, unless each is asked.
    around: InteriorList,
    is_watched: bool,
    /// One started in more than a ray can be in.
    is_crowded: AtomicBool,
}

impl<'s> CameraRays<'s> {
    /// For `scene`. The air must be empty for rays to start late: no fog, no interior around the camera.
    pub fn new(scene: &'s CompiledScene, plan: &'s ScenePlan) -> Self {
        let g = &scene.geometry;
        let is_empty =
            scene.fogs.is_empty() && scene.atmosphere.is_empty() && plan.camera_interiors.as_ref().is_some_and(|list| list.is_empty());
        let all = g.bounded.iter().map(|p| g.bounds[*p as usize]).reduce(Bounds::union);
        let start_box = all.filter(|b| is_empty && g.unbounded.is_empty() && b.min.is_finite() && b.max.is_finite());
        let is_seen = !scene.fogs.is_empty() || scene.features.media || g.prims.iter().any(|p| p.flags & prim_flags::TRANSPARENT != 0);
        let is_watched = plan.camera_interiors.is_none() && is_seen;
        Self { scene, plan, start_box, around: start_interiors(scene, plan), is_watched, is_crowded: AtomicBool::new(false) }
    }

    /// Refuses a camera some of whose rays started inside more than shaders keep.
    pub fn check(&self) -> Result<(), BackendError> {
        if self.is_crowded.load(Ordering::Relaxed) { Err(crowded()) } else { Ok(()) }
    }

    /// Whether all rays start inside the same things for certain, so that the device may make them.
    pub fn is_unwatched(&self) -> bool {
        !self.is_watched
    }

    /// Where rays may start: the box of everything that can be met.
    pub fn start_box(&self) -> Option<Bounds> {
        self.start_box
    }

    /// Rays of a mesh camera, those of a place together; and the number of each place's.
    pub fn mesh_starts(&self, mesh: &MeshCamera, places: &Places) -> (Vec<Start>, Vec<u32>) {
        let size = self.plan.camera.resolution();
        let of = |k: usize| -> Vec<Start> {
            let (x, y) = places.at(k);
            let key = position_key(x, y);
            let rays = (0..mesh.n_rays()).filter_map(|m| mesh.ray(m, x, y, size).map(|r| (m, r)));
            rays.map(|(m, r)| Start { key: hash(key ^ m), ..self.start(&r) }).collect()
        };
        let all: Vec<Vec<Start>> = (0..places.len()).into_par_iter().map(of).collect();
        let counts = all.iter().map(|l| l.len() as u32).collect();
        (all.concat(), counts)
    }

    /// Sample `n` of the lens at a position.
    pub fn lens_start(&self, lens: &Lens, (x, y): (f64, f64), n: u32) -> Start {
        let start = || {
            let (ray, at) = self.plan.camera.lens_ray(lens, x, y, n)?;
            let ray = bent(self.scene, self.plan, ray, at);
            Some(Start { key: hash(position_key(x, y) ^ n), ..self.start(&ray) })
        };
        start().unwrap_or_default()
    }

    /// The ray of a picture position; integers are pixel centres.
    pub fn single_start(&self, (x, y): (f64, f64)) -> Start {
        let ray = single_ray(self.scene, self.plan, x, y);
        ray.map_or_else(Start::default, |ray| Start { key: position_key(x, y), ..self.start(&ray) })
    }

    fn start(&self, ray: &Ray) -> Start {
        let own = self.is_watched.then(|| interiors_at(self.scene, ray.origin));
        let around = own.as_ref().unwrap_or(&self.around);
        if around.len() > MAX_INTERIORS {
            self.is_crowded.store(true, Ordering::Relaxed);
        }
        let mut interiors = [0; MAX_INTERIORS];
        interiors.iter_mut().zip(around.iter()).for_each(|(to, from)| *to = from);
        let n_interiors = around.len().min(MAX_INTERIORS) as u32;
        let t = self.start_box.map_or(0.0, |b| entry(ray, &b));
        let origin = ray.at(t);
        let (origin_low, dir_low) = (low_part3(origin), low_part3(ray.dir));
        Start { origin: v3(origin), shown: 1, dir: v3(ray.dir), origin_low, dir_low, n_interiors, interiors, ..Start::default() }
    }
}

/// Why a scene is refused whose camera is inside so many things.
pub(super) fn crowded() -> BackendError {
    BackendError::Unsupported("a camera inside more than eight objects".into())
}

/// The interiors that camera rays start in: those of the camera's place, or of a ray of its mesh.
pub(super) fn start_interiors(scene: &CompiledScene, plan: &ScenePlan) -> InteriorList {
    if let Some(list) = &plan.camera_interiors {
        return list.clone();
    }
    let size = plan.camera.resolution();
    let of_mesh = plan.camera.mesh.as_ref().and_then(|mesh| (0..mesh.n_rays()).find_map(|m| mesh.ray(m, 0.0, 0.0, size)));
    interiors_at(scene, of_mesh.map_or(scene.camera.location, |r| r.origin))
}

/// Key of the random numbers of a picture position. Twin: `key_of_place` in `shaders/shared/camera.wesl`.
fn position_key(x: f64, y: f64) -> u32 {
    [x, y].iter().fold(0, |key, v| hash(hash(key ^ (*v as f32).to_bits()) ^ low_part(*v).to_bits()))
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
