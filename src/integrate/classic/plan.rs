//! What every tracer of a scene shares, worked out once before the first ray.

use super::area_packet::area_orders;
use super::emitters::{EmitterPoint, emitter_points};
use super::photons::PhotonMaps;
use super::ray::InteriorList;
use super::subsurface::{AlbedoTable, albedo_tables};
use crate::compile::texture::{PatternCode, PigmentCode, WarpNode};
use crate::compile::{CompiledScene, NONE};
use crate::kernel::camera::CameraModel;
use crate::kernel::inside::containing_interiors;
use crate::kernel::media::stop_thresholds;
use crate::math::Bounds;
use crate::savings::Saving;

/// What POV-Ray's quality levels switch. Source: spec/light.md, section 13.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Quality {
    pub lights: bool,
    pub shadows: bool,
    pub area_lights: bool,
    pub refraction: bool,
    pub quick_colors: bool,
    pub reflection: bool,
    pub normals: bool,
    pub volumes: bool,
}

impl Quality {
    fn new(level: u8) -> Self {
        Self {
            lights: level >= 2,
            shadows: level >= 4,
            area_lights: level >= 5,
            refraction: level >= 6,
            quick_colors: level <= 5,
            reflection: level >= 8,
            normals: level >= 8,
            volumes: level >= 9,
        }
    }
}

/// A scene ready to be traced at one size.
pub struct ScenePlan {
    /// Camera rays.
    pub camera: CameraModel,
    /// Interiors around a camera that stays in place.
    pub camera_interiors: Option<InteriorList>,
    /// What the quality level allows.
    pub quality: Quality,
    /// Lights outside light groups, in the order of the file.
    pub global_lights: Vec<u32>,
    /// By light group: its lights and those of the groups around it.
    pub group_lights: Vec<Vec<u32>>,
    /// Points that stand for shining imported surfaces.
    pub emitters: Vec<EmitterPoint>,
    /// Language 3.7 rules for layers and skies.
    pub modern: bool,
    /// Background is transparent to camera rays.
    pub output_alpha: bool,
    /// Any interior or the air has media.
    pub has_media: bool,
    /// By light: grid points that are traced together, in the order in which they are asked.
    pub area_orders: Vec<Option<Vec<[u32; 2]>>>,
    /// By medium: the same everywhere.
    pub constant_media: Vec<bool>,
    /// By medium: its densities, those first that are found quickly: where one is 0 the others are not asked.
    pub media_densities: Vec<Vec<u32>>,
    /// By medium: its stop thresholds.
    pub media_thresholds: Vec<Vec<f64>>,
    /// Shadow rays draw random numbers.
    pub shadows_draw: bool,
    /// Tables for subsurface light, and by interior the place of its own.
    pub(super) albedos: (Vec<AlbedoTable>, Vec<u32>),
    /// Photons at rest, once they have been shot.
    pub photons: Option<Box<PhotonMaps>>,
}

impl ScenePlan {
    /// Prepares a scene for a picture of `width` x `height` pixels.
    pub fn new(scene: &CompiledScene, width: u32, height: u32, output_alpha: bool) -> Self {
        let camera = CameraModel::new(scene, width, height);
        let camera_interiors = if camera.has_fixed_origin() {
            Some(interiors_at(scene, camera.location()))
        } else {
            // Where no solid comes near the places that rays start from, they all start in the open.
            let is_far = |b: &Bounds| scene.geometry.solids.iter().all(|(solid, _)| solid.intersection(*b).is_empty());
            camera.origins().is_some_and(|b| scene.options.savings.has(Saving::Interiors) && is_far(&b)).then(InteriorList::default)
        };
        let global_lights = (0..scene.lights.len() as u32).filter(|k| scene.lights[*k as usize].group_ix == NONE).collect();
        let group_lights = (0..scene.light_groups.len() as u32).map(|g| lights_of_group(scene, g)).collect();
        Self {
            camera,
            camera_interiors,
            quality: Quality::new(scene.options.quality),
            global_lights,
            group_lights,
            emitters: emitter_points(scene),
            modern: scene.settings.version >= 370,
            output_alpha,
            has_media: !scene.media.is_empty(),
            area_orders: area_orders(scene),
            constant_media: scene.media.iter().map(|m| m.densities.is_empty()).collect(),
            media_densities: scene.media.iter().map(|m| quick_first(scene, &m.densities)).collect(),
            media_thresholds: scene.media.iter().map(|m| stop_thresholds(&m.params)).collect(),
            shadows_draw: has_jitter(scene) || !scene.media.is_empty(),
            albedos: albedo_tables(scene),
            photons: None,
        }
    }

    /// Whether the picture depends on the order of rays: then blocks are rendered one after another, with streams that run on,
    /// which is also how POV-Ray does it with one thread.
    pub fn needs_ordered_rays(scene: &CompiledScene) -> bool {
        let jittered_bow = scene.rainbows.iter().any(|r| r.jitter != 0.0);
        let random_media = scene.media.iter().any(|m| m.params.method != 3 || m.params.jitter != 0.0);
        let f = &scene.features;
        scene.options.quality >= 5 && has_jitter(scene) || jittered_bow || random_media || f.crand || f.radiosity || f.subsurface
    }
}

/// Whether any area light is jittered.
fn has_jitter(scene: &CompiledScene) -> bool {
    scene.lights.iter().any(|l| l.light.area.as_ref().is_some_and(|a| a.jitter))
}

/// Pigments by what they cost: a few operations, a formula, noise.
fn quick_first(scene: &CompiledScene, pigments: &[u32]) -> Vec<u32> {
    let cost = |pigment: &u32| {
        let t = &scene.textures;
        let node = &t.pigments[*pigment as usize];
        let pattern = match node.code {
            PigmentCode::Solid(_) => return 0,
            PigmentCode::Colors(_) => &t.patterns[node.pattern as usize],
            _ => return 3,
        };
        let is_noisy = pattern.warps.of(&t.warps).iter().any(|w| matches!(w, WarpNode::Turbulence { .. }));
        match pattern.code {
            _ if is_noisy => 3,
            PatternCode::Spherical | PatternCode::Boxed | PatternCode::Planar | PatternCode::Cylindrical | PatternCode::Gradient(_) => 1,
            _ => 2,
        }
    };
    let mut list = pigments.to_vec();
    list.sort_by_key(cost);
    list
}

fn lights_of_group(scene: &CompiledScene, group: u32) -> Vec<u32> {
    let (mut lights, mut g) = (Vec::new(), group);
    // A parent stands before its children, so this ends.
    while let Some(record) = scene.light_groups.get(g as usize) {
        lights.extend_from_slice(&record.lights);
        g = record.parent;
    }
    lights
}

/// The interiors of all objects that contain a point.
pub fn interiors_at(scene: &CompiledScene, p: crate::math::DVec3) -> InteriorList {
    let mut list = InteriorList::default();
    containing_interiors(scene, p, |i| list.push(scene, i));
    list
}
