//! What all threads of a rendering share: camera, filter, shaders, lights, limits.

use super::camera::PathCamera;
use super::filter::FilterTable;
use super::lights::LightSet;
use super::passes::NameTable;
use super::shader::shader_of;
use super::volume::{VolumeStack, grid_summary};
use crate::compile::CompiledScene;
use crate::compile::geometry::prim_flags;
use crate::compile::merged::MergedMeshes;
use crate::kernel::SurfaceHit;
use crate::kernel::merged::{intersect_merged, intersect_merged_object, intersect_merged_shadow};
use crate::kernel::traverse::{ShadowHit, intersect_at, intersect_object_at, intersect_shadow_at};
use crate::math::Ray;
use crate::scene::{PassSet, PathSettings, Shader};
use std::sync::Arc;

/// A scene made ready for path tracing.
pub struct PathPlan<'s> {
    pub(super) scene: &'s CompiledScene,
    /// The faces of still meshes in one tree, where rays are traced here.
    merged: Option<MergedMeshes>,
    /// Limits, filter, clamps.
    pub settings: PathSettings,
    /// Rays of the camera.
    pub camera: PathCamera,
    /// Pixel filter.
    pub filter: FilterTable,
    /// By index of `TextureTables::principled`.
    pub shaders: Vec<Arc<Shader>>,
    /// All lights.
    pub lights: LightSet,
    /// Of the numbers of all samples.
    pub seed: u32,
    /// The shutter is open for a while.
    pub has_motion: bool,
    /// Some body is filled.
    pub has_volumes: bool,
    /// The film shows where nothing is.
    pub output_alpha: bool,
    /// Greatest and mean number of the grid of each shader's volume.
    pub(super) grid_summaries: Vec<(f32, f32)>,
    /// Bodies around the camera.
    pub(super) camera_volumes: VolumeStack,
    /// What is gathered besides the colours.
    pub(super) passes: PassSet,
    pub(super) names: NameTable,
    /// Some object is a shadow catcher.
    pub(super) has_catchers: bool,
    /// Paths end where the denoiser's guides are known.
    pub(super) features_only: bool,
}

impl<'s> PathPlan<'s> {
    /// For a picture of `width` x `height` pixels, made by [`super::PathTracer`]s.
    pub fn new(scene: &'s CompiledScene, width: u32, height: u32, seed: u32, output_alpha: bool) -> Self {
        Self::with_tree(scene, width, height, seed, output_alpha, MergedMeshes::new(scene))
    }

    /// For a picture whose rays are traced elsewhere: nothing is built for them.
    pub fn without_tree(scene: &'s CompiledScene, width: u32, height: u32, seed: u32, output_alpha: bool) -> Self {
        Self::with_tree(scene, width, height, seed, output_alpha, None)
    }

    fn with_tree(scene: &'s CompiledScene, width: u32, height: u32, seed: u32, output_alpha: bool, merged: Option<MergedMeshes>) -> Self {
        let settings = scene.settings.path.clone();
        let shaders: Vec<Arc<Shader>> = scene.textures.principled.iter().map(shader_of).collect();
        let lights = LightSet::new(scene, &shaders, merged.as_ref());
        let moves = scene.geometry.prims.iter().any(|p| p.flags & prim_flags::MOVING != 0);
        let deforms = scene.geometry.shapes.meshes.iter().any(|m| m.moving.is_some());
        let has_volumes = shaders.iter().any(|s| s.volume.is_some()) || scene.environment.as_ref().is_some_and(|e| e.volume.is_some());
        let mut plan = Self {
            scene,
            merged,
            camera_volumes: VolumeStack::default(),
            camera: PathCamera::new(scene, width, height),
            filter: FilterTable::new(settings.filter),
            lights,
            grid_summaries: shaders.iter().map(|s| s.volume.as_ref().map_or((0.0, 0.0), grid_summary)).collect(),
            shaders,
            seed: seed ^ settings.seed,
            has_motion: moves || deforms || scene.camera.motion.len() > 1,
            has_volumes,
            output_alpha: output_alpha || settings.film_transparent,
            settings,
            passes: PassSet::NONE,
            names: NameTable::default(),
            features_only: false,
            has_catchers: super::catcher::has_catchers(scene),
        };
        if has_volumes {
            plan.camera_volumes = plan.volumes_at(scene.camera.location);
        }
        plan
    }

    /// Nearest hit; see [`intersect_at`].
    #[inline]
    pub(super) fn intersect(&self, ray: &Ray, time: f64, t_min: f64, t_max: f64, skip_flags: u32) -> Option<SurfaceHit> {
        match &self.merged {
            Some(m) => intersect_merged(self.scene, m, ray, time, t_min, t_max, skip_flags),
            None => intersect_at(self.scene, ray, time, t_min, t_max, skip_flags),
        }
    }

    /// Nearest hit with one object; see [`intersect_object_at`].
    #[inline]
    pub(super) fn intersect_object(&self, object_ix: u32, ray: &Ray, time: f64, t_min: f64, t_max: f64) -> Option<SurfaceHit> {
        match &self.merged {
            Some(m) => intersect_merged_object(self.scene, m, object_ix, ray, time, t_min, t_max),
            None => intersect_object_at(self.scene, object_ix, ray, time, t_min, t_max),
        }
    }

    /// What stands in the way; see [`intersect_shadow_at`].
    #[inline]
    pub(super) fn intersect_shadow(&self, ray: &Ray, time: f64, t_min: f64, t_max: f64, last: u32) -> ShadowHit {
        match &self.merged {
            Some(m) => intersect_merged_shadow(self.scene, m, ray, time, t_min, t_max),
            None => intersect_shadow_at(self.scene, ray, time, t_min, t_max, last),
        }
    }

    /// Object and material of the bodies around the camera.
    pub fn camera_bodies(&self) -> &[(u32, u32)] {
        self.camera_volumes.bodies()
    }

    /// Gathers these passes too.
    #[must_use]
    pub fn with_passes(self, passes: PassSet) -> Self {
        Self { names: NameTable::new(self.scene, passes), passes, ..self }
    }

    /// With paths that end where the denoiser's guides are known.
    #[must_use]
    pub fn features_only(self, yes: bool) -> Self {
        Self { features_only: yes && !self.passes.is_empty(), ..self }
    }
}
