//! What a scene asks of the path integrator. The defaults are an unbiased picture; a scene from Blender brings Blender's.

use super::PassSet;
use super::denoise::DenoiseSettings;

/// Settings of the path integrator. Names and counts as Cycles'.
#[derive(Clone, Debug, PartialEq)]
pub struct PathSettings {
    /// Samples a pixel when the command line says none; 0 when the scene says none either.
    pub samples: u32,
    /// Seed when the command line says none.
    pub seed: u32,
    /// Error a pixel may keep (adaptive sampling); 0 for none.
    pub adaptive_threshold: f32,
    /// Fewest samples before a pixel may stop; 0: by the threshold.
    pub adaptive_min_samples: u32,
    /// Seconds of rendering at most; 0 for no limit.
    pub time_limit: f32,
    /// Most bounces of all kinds; 0 is direct light alone.
    pub max_bounces: u32,
    /// Most diffuse bounces.
    pub diffuse_bounces: u32,
    /// Most glossy bounces.
    pub glossy_bounces: u32,
    /// Most refractions.
    pub transmission_bounces: u32,
    /// Most scatterings in volumes.
    pub volume_bounces: u32,
    /// Most transparent surfaces in a row, counted apart from the bounces.
    pub transparent_bounces: u32,
    /// Bounces before Russian roulette begins.
    pub min_light_bounces: u32,
    /// Transparent surfaces before Russian roulette begins.
    pub min_transparent_bounces: u32,
    /// Largest contribution of direct light, as Cycles' UI has it (a sum of channels may be three times that); 0 for none.
    pub clamp_direct: f32,
    /// The same of indirect light.
    pub clamp_indirect: f32,
    /// Cycles' "filter glossy": blurs glossy lobes after blurred bounces; 0 for none.
    pub filter_glossy: f32,
    /// Mirrors and glossy surfaces make caustics.
    pub caustics_reflective: bool,
    /// Glass makes caustics.
    pub caustics_refractive: bool,
    /// Pixel filter.
    pub filter: PixelFilter,
    /// Multiplies the film.
    pub exposure: f32,
    /// Film is transparent where the world is seen.
    pub film_transparent: bool,
    /// Passes that the scene asks for.
    pub passes: PassSet,
    /// The mist pass.
    pub mist: Mist,
    /// How far the pass of ambient occlusion looks.
    pub occlusion_distance: f32,
    /// The motion's keys are the frame before, this and the next: they are for the vector pass, and the picture is of the middle.
    pub still: bool,
    /// Denoising that the scene wants.
    pub denoise: Option<DenoiseSettings>,
}

impl Default for PathSettings {
    fn default() -> Self {
        Self {
            samples: 0,
            seed: 0,
            adaptive_threshold: 0.0,
            adaptive_min_samples: 0,
            time_limit: 0.0,
            max_bounces: 12,
            diffuse_bounces: 4,
            glossy_bounces: 4,
            transmission_bounces: 12,
            volume_bounces: 0,
            transparent_bounces: 8,
            min_light_bounces: 0,
            min_transparent_bounces: 0,
            clamp_direct: 0.0,
            clamp_indirect: 0.0,
            filter_glossy: 0.0,
            caustics_reflective: true,
            caustics_refractive: true,
            filter: PixelFilter::BlackmanHarris { width: 1.5 },
            exposure: 1.0,
            film_transparent: false,
            passes: PassSet::NONE,
            mist: Mist::default(),
            occlusion_distance: 10.0,
            still: false,
            denoise: None,
        }
    }
}

/// What the mist pass shows: distance from the camera, between two, along a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mist {
    /// Where it begins.
    pub start: f32,
    /// From there to where it is all.
    pub depth: f32,
    /// Of the share of the way: 2 (Blender's default, "quadratic"), 1, 0.5.
    pub exponent: f32,
}

impl Default for Mist {
    fn default() -> Self {
        Self { start: 5.0, depth: 25.0, exponent: 2.0 }
    }
}

/// Pixel filter, importance sampled: every sample has weight 1 in its own pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PixelFilter {
    /// The pixel itself.
    Box,
    /// Cycles' default. `width` is the radius in pixels: the window spans twice that.
    BlackmanHarris {
        /// Pixels.
        width: f32,
    },
    /// Cycles' Gaussian over `width` pixels to either side.
    Gaussian {
        /// Pixels.
        width: f32,
    },
}
