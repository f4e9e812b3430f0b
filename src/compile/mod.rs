//! Scene → CompiledScene: flat arrays that both machines read, and the set of features that the scene needs.
//!
//! Data holds indices only, named on the GPU as here. Nothing here traces a ray.

pub mod extent;
mod features;
mod flatten;
pub mod function;
pub mod geometry;
mod half_spaces;
mod leaf;
pub mod merged;
pub mod motion;
mod programs;
pub mod shape;
pub mod spline;
mod tables;
pub mod texture;
mod validate;

use crate::accel::AccelKind;
use crate::math::{DVec3, Rgb, Rgbft, Transform};
use crate::memory::{MemoryLimit, OutOfMemory};
use crate::savings::{Saving, Savings};
use crate::scene::light::LightKind;
use crate::scene::{Camera, Fog, Light, Rainbow, Scene, Settings};
use flatten::Flattener;
use geometry::Geometry;
use shape::TreeStore;
use std::sync::Arc;
use texture::{FunctionIx, NormalIx, PigmentIx, TextureBuilder, TextureTables};

/// "No index" in every table.
pub const NONE: u32 = u32::MAX;

/// What decides the shape of the compiled scene besides the scene.
#[derive(Clone, Debug)]
pub struct CompileOptions {
    /// POV-Ray's quality, 0..=9.
    pub quality: u8,
    /// What to leave out.
    pub savings: Savings,
    /// Kind of tree over primitives and triangles.
    pub accel: AccelKind,
    /// Memory that the process may use.
    pub memory: MemoryLimit,
    /// Trees of the frame before, where the scene is one of several.
    pub trees: Option<Arc<TreeStore>>,
}

impl Default for CompileOptions {
    fn default() -> Self {
        Self { quality: 9, savings: Savings::ALL, accel: AccelKind::Auto, memory: MemoryLimit::default(), trees: None }
    }
}

/// A scene as flat arrays.
#[derive(Debug)]
pub struct CompiledScene {
    /// Primitives, their shapes, places and clip programs.
    pub geometry: Geometry,
    /// Pigments, normals, finishes, patterns, maps, images, functions.
    pub textures: TextureTables,
    /// Fillings, one for each object that has its own (identity matters: spec/light.md, section 1.5).
    pub interiors: Vec<Interior>,
    /// Media of interiors and of the atmosphere.
    pub media: Vec<Media>,
    /// All lights in world space: the scene's, those inside unions, those of light groups.
    pub lights: Vec<CompiledLight>,
    /// Light groups; `Prim::group_ix` points here.
    pub light_groups: Vec<LightGroup>,
    /// The camera in world space.
    pub camera: Camera,
    /// Bends the camera's rays, or [`NONE`].
    pub camera_normal: NormalIx,
    /// Weighs the lens of focal blur, or [`NONE`].
    pub camera_bokeh: PigmentIx,
    /// Global settings.
    pub settings: Settings,
    /// Background colour.
    pub background: Rgbft,
    /// The sky, if any.
    pub sky: Option<CompiledSky>,
    /// What the path integrator sees in place of background and sky.
    pub environment: Option<crate::scene::Environment>,
    /// Fogs with a distance, in the order of the file.
    pub fogs: Vec<Fog>,
    /// Rainbows.
    pub rainbows: Vec<Rainbow>,
    /// Media of the atmosphere, into `media`.
    pub atmosphere: Vec<u32>,
    /// What the scene needs.
    pub features: FeatureSet,
    /// What was asked for.
    pub options: CompileOptions,
}

/// A filling. Source: spec/textures.md, section 10.
#[derive(Clone, Debug)]
#[expect(missing_docs, reason = "as scene::Interior")]
pub struct Interior {
    pub ior: f64,
    pub dispersion: f64,
    pub dispersion_samples: u32,
    pub caustics: f64,
    pub fade_color: Rgb,
    pub fade_distance: f64,
    pub fade_power: f64,
    pub old_refraction: f64,
    /// Into `CompiledScene::media`.
    pub media: Vec<u32>,
    /// Atmosphere goes on inside.
    pub hollow: bool,
}

/// A medium with compiled densities.
#[derive(Clone, Debug)]
pub struct Media {
    /// Its numbers; `densities` is empty here.
    pub params: crate::scene::Media,
    /// Pigments whose product is the density.
    pub densities: Vec<PigmentIx>,
    /// World from the densities' space, into `Geometry::transforms`.
    pub transform_ix: u32,
}

/// A light in world space.
#[derive(Clone, Debug)]
pub struct CompiledLight {
    /// Everything about it; `projected_through` and `looks_like` are compiled away.
    pub light: Light,
    /// Its direction and the cosines of its cone.
    pub beam: LightBeam,
    /// Light group it belongs to, or [`NONE`].
    pub group_ix: u32,
    /// Primitives that the light must pass, into `Geometry::objects`, or [`NONE`].
    pub projected_through: u32,
}

/// What every question about a light's direction asks for, worked out once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightBeam {
    /// Unit direction in which the light points.
    pub axis: DVec3,
    /// Cosines of a spot light's radius and falloff; 1 for others.
    pub cos_radius: f64,
    /// See `cos_radius`.
    pub cos_falloff: f64,
}

impl LightBeam {
    /// Of `light`.
    pub fn new(light: &Light) -> Self {
        let axis = match light.kind {
            LightKind::Sun { direction, .. } => direction,
            _ => (light.point_at - light.location).try_normalize().unwrap_or(DVec3::Z),
        };
        let (cos_radius, cos_falloff) = match light.kind {
            LightKind::Spot { radius_rad, falloff_rad, .. } => (radius_rad.cos(), falloff_rad.cos()),
            _ => (1.0, 1.0),
        };
        Self { axis, cos_radius, cos_falloff }
    }
}

/// Objects with lights of their own.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LightGroup {
    /// Group around this one, whose lights shine here too, or [`NONE`].
    pub parent: u32,
    /// Its own lights, into `CompiledScene::lights`.
    pub lights: Vec<u32>,
}

/// The sky's pigments.
#[derive(Clone, Debug)]
pub struct CompiledSky {
    /// Bottom first.
    pub pigments: Vec<PigmentIx>,
    /// Colour factor.
    pub emission: Rgb,
    /// Sky space to world, into `Geometry::transforms`.
    pub transform_ix: u32,
}

/// What the scene needs; everything downstream is chosen by it.
#[derive(Clone, Debug, Default, PartialEq)]
#[expect(missing_docs, reason = "the names say it")]
pub struct FeatureSet {
    /// Kinds of primitives present, as bits of `geometry::PrimKind`.
    pub prim_kinds: u64,
    /// Kinds of patterns present, by name, sorted.
    pub patterns: Vec<&'static str>,
    pub clip_programs: bool,
    pub transparency: bool,
    pub refraction: bool,
    pub reflection: bool,
    pub normals: bool,
    pub turbulence: bool,
    pub images: bool,
    pub functions: bool,
    pub highlights: bool,
    pub irid: bool,
    pub crand: bool,
    pub area_lights: bool,
    pub media: bool,
    pub fog: bool,
    pub rainbow: bool,
    pub sky: bool,
    pub radiosity: bool,
    pub photons: bool,
    pub subsurface: bool,
    pub dispersion: bool,
    pub principled: bool,
    pub uv: bool,
}

/// Why a scene cannot be compiled.
#[derive(Debug, thiserror::Error)]
pub enum CompileError {
    /// More of something than 32-bit indices or the memory limit allow.
    #[error("the scene has too many {what}: {count} (limit {limit})")]
    TooMany {
        /// "primitives", "texture nodes".
        what: &'static str,
        /// How many.
        count: u64,
        /// The limit.
        limit: u64,
    },
    /// More memory than the process may use.
    #[error("the compiled scene does not fit: {0}")]
    Memory(#[from] OutOfMemory),
    /// Objects inside objects deeper than the compile step or the clip programs can hold.
    #[error("objects are nested {depth} deep; at most {limit} is possible")]
    TooDeep {
        /// How deep.
        depth: usize,
        /// The limit.
        limit: usize,
    },
}

/// Compiles one object that is asked about before its scene is complete: a scene of that object alone, hidden and without covers,
/// as object 0.
pub fn compile_object(object: &crate::scene::Object, settings: &Settings) -> Result<CompiledScene, CompileError> {
    let mut flattener = Flattener::new(TextureBuilder::new(settings), usize::MAX, &CompileOptions::default());
    flattener.add_hidden(object)?;
    finish(flattener, &Scene::default(), &CompileOptions::default())
}

/// Compiles one user function that is called before its scene is complete: a scene of that function alone.
pub fn compile_function(
    function: &std::sync::Arc<crate::scene::Function>,
    settings: &Settings,
) -> Result<(CompiledScene, FunctionIx), CompileError> {
    let mut flattener = Flattener::new(TextureBuilder::new(settings), usize::MAX, &CompileOptions::default());
    let ix = flattener.textures.function(function);
    let scene = Scene { settings: settings.clone(), ..Scene::default() };
    Ok((finish(flattener, &scene, &CompileOptions::default())?, ix))
}

/// Compiles one pigment that is asked about before its scene is complete.
pub fn compile_pigment(
    pigment: &std::sync::Arc<crate::scene::Pigment>,
    settings: &Settings,
) -> Result<(CompiledScene, PigmentIx), CompileError> {
    let mut flattener = Flattener::new(TextureBuilder::new(settings), usize::MAX, &CompileOptions::default());
    let ix = flattener.textures.pigment(pigment);
    let scene = Scene { settings: settings.clone(), ..Scene::default() };
    Ok((finish(flattener, &scene, &CompileOptions::default())?, ix))
}

/// Compiles a scene.
pub fn compile_scene(scene: &Scene, options: &CompileOptions) -> Result<CompiledScene, CompileError> {
    let mut flattener = Flattener::new(TextureBuilder::new(&scene.settings), flatten::n_top_level(scene), options);
    for light in &scene.lights {
        flattener.add_light(light)?;
    }
    for object in &scene.objects {
        flattener.add_visible(object)?;
    }
    let mut compiled = finish(flattener, scene, options)?;
    if let Some(store) = &options.trees {
        store.end_frame();
    }
    if !options.savings.has(Saving::Trees) {
        compiled.geometry.shapes.meshes.iter().for_each(|m| _ = m.index());
    }
    if !options.savings.has(Saving::Bailout) {
        compiled.settings.adc_bailout = 0.0;
    }
    Ok(compiled)
}

/// Everything of a scene besides objects and lights, and the finished tables.
fn finish(mut flattener: Flattener, scene: &Scene, options: &CompileOptions) -> Result<CompiledScene, CompileError> {
    let atmosphere = scene.atmosphere.iter().map(|m| flattener.medium(m, &Transform::IDENTITY)).collect();
    let sky = scene.sky_sphere.as_ref().map(|sky| CompiledSky {
        pigments: sky.pigments.iter().map(|p| flattener.textures.pigment(p)).collect(),
        emission: sky.emission,
        transform_ix: flattener.transforms.add(&sky.transform),
    });
    let camera_normal = scene.camera.normal.as_ref().map_or(NONE, |n| flattener.textures.normal(n));
    let bokeh = scene.camera.blur.as_ref().and_then(|b| b.bokeh.as_ref());
    let camera_bokeh = bokeh.map_or(NONE, |p| flattener.textures.pigment(p));
    // Objects that patterns ask about; their own patterns may bring more.
    loop {
        let objects = flattener.textures.take_objects();
        if objects.is_empty() {
            break;
        }
        for o in objects {
            let object_ix = flattener.add_hidden(&o)?;
            flattener.textures.set_pattern_object(object_ix);
        }
    }
    let (geometry, rest) = flattener.finish(scene);
    let mut compiled = CompiledScene {
        geometry,
        textures: rest.textures.finish(),
        interiors: rest.interiors,
        media: rest.media,
        lights: rest.lights,
        light_groups: rest.light_groups,
        camera: scene.camera.clone(),
        camera_normal,
        camera_bokeh,
        settings: scene.settings.clone(),
        background: scene.background,
        sky,
        environment: scene.environment.clone(),
        fogs: scene.fogs.iter().filter(|f| f.distance != 0.0).cloned().collect(),
        rainbows: scene.rainbows.clone(),
        atmosphere,
        features: FeatureSet::default(),
        options: options.clone(),
    };
    debug_assert_eq!(compiled.geometry.validate(compiled.interiors.len()), Ok(()));
    compiled.features = features::find(&compiled);
    Ok(compiled)
}
