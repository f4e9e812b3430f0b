//! What `global_settings` and the language version decide.

use super::PathSettings;
use crate::math::Rgb;
use crate::math::Vec3;

/// How the working colour space relates to light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum WorkingGamma {
    /// Colours are linear (`assumed_gamma 1.0`, and 3.7 scenes without one).
    Linear,
    /// Colours are encoded by a power.
    Power(f64),
    /// Colours are sRGB-encoded.
    Srgb,
    /// Before 3.7 with no `assumed_gamma`: what the scene computes is written as it is.
    None,
}

/// Global settings. Source: spec/language.md, section 6.1.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Language version in force when the file ended, times 100 (370). Decides layer attenuation, sky layers, radiosity's ambient.
    pub version: u32,
    /// Rays of lower weight are black.
    pub adc_bailout: f64,
    /// Multiplies every ambient.
    pub ambient_light: Rgb,
    /// Working space of every colour.
    pub gamma: WorkingGamma,
    /// Wavelengths of irid, red green blue.
    pub irid_wavelength: Rgb,
    /// Most counted rays in a chain, 1..=256.
    pub max_trace_level: u32,
    /// POV-Ray's noise: 1 original, 2 range-corrected, 3 Perlin.
    pub noise_generator: u8,
    /// Sources of waves and ripples.
    pub number_of_waves: u32,
    /// Millimetres a scene unit (subsurface).
    pub mm_per_unit: f64,
    /// Present when the scene asks for radiosity.
    pub radiosity: Option<Radiosity>,
    /// Present when the scene asks for photons.
    pub photons: Option<Photons>,
    /// Present when the scene asks for subsurface: diffuse samples, single samples, with radiosity.
    pub subsurface: Option<(u32, u32, bool)>,
    /// What the scene asks of the path integrator.
    pub path: PathSettings,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            version: 370,
            adc_bailout: 1.0 / 255.0,
            ambient_light: Vec3::ONE,
            gamma: WorkingGamma::Linear,
            irid_wavelength: Vec3::new(0.70, 0.52, 0.48),
            max_trace_level: 5,
            noise_generator: 2,
            number_of_waves: 10,
            mm_per_unit: 10.0,
            radiosity: None,
            photons: None,
            subsurface: None,
            path: PathSettings::default(),
        }
    }
}

/// `radiosity{}`. Source: spec/light.md, section 8.
#[derive(Clone, Debug)]
pub struct Radiosity {
    /// Rays a sample.
    pub count: f64,
    /// Directions in the pool.
    pub pool: u32,
    /// Reuse error bound.
    pub error_bound: f64,
    /// 0..1, how far colours go grey.
    pub gray_threshold: f64,
    /// Multiplies the error bound in the pretrace.
    pub low_error_factor: f64,
    /// Share of the camera distance.
    pub minimum_reuse: f64,
    /// Share of the camera distance.
    pub maximum_reuse: f64,
    /// Samples to reuse; second value for adaptive pretrace.
    pub nearest_count: (u32, u32),
    /// Diffuse bounces.
    pub recursion_limit: u32,
    /// Cap of a sample's brightest channel, below 0 for none.
    pub max_sample: f64,
    /// Weight below which gather rays end.
    pub adc_bailout: f64,
    /// Multiplies the result.
    pub brightness: f64,
    /// Gather in the final pass too.
    pub always_sample: bool,
    /// Use perturbed normals.
    pub normal: bool,
    /// Media along gather rays.
    pub media: bool,
    /// Subsurface in gather rays.
    pub subsurface: bool,
    /// Mosaic sizes, shares of the picture.
    pub pretrace: (f64, f64),
    /// Default importance of objects.
    pub importance: f64,
}

impl Default for Radiosity {
    fn default() -> Self {
        Self {
            count: 35.0,
            pool: 1600,
            error_bound: 1.8,
            gray_threshold: 0.0,
            low_error_factor: 0.5,
            minimum_reuse: 0.015,
            maximum_reuse: 0.2,
            nearest_count: (5, 0),
            recursion_limit: 2,
            max_sample: -1.0,
            adc_bailout: 0.01,
            brightness: 1.0,
            always_sample: false,
            normal: false,
            media: false,
            subsurface: false,
            pretrace: (0.08, 0.04),
            importance: 1.0,
        }
    }
}

/// `photons{}`. Source: spec/light.md, section 9.
#[derive(Clone, Debug)]
pub struct Photons {
    /// Distance between photons, in scene units at distance 1.
    pub spacing: f64,
    /// Wanted number, 0 when `spacing` rules.
    pub count: u32,
    /// Fewest and most photons gathered.
    pub gather: (u32, u32),
    /// Gather radius and its multipliers as written: radius, multiplier, media radius, media multiplier; below 0 is automatic.
    pub radius: [f64; 4],
    /// Of directions, 0..1.
    pub jitter: f64,
    /// Share of the angle after which an empty ring ends a pair.
    pub autostop: f64,
    /// Expansion of the gather radius: tolerance, fewest photons.
    pub expand: (f64, u32),
    /// Of photon rays.
    pub adc_bailout: f64,
    /// Of photon rays.
    pub max_trace_level: u32,
    /// Media photons: most steps, factor.
    pub media: (u32, f64),
}

impl Default for Photons {
    fn default() -> Self {
        Self {
            spacing: 1.0,
            count: 0,
            gather: (20, 100),
            radius: [-1.0, 1.0, -1.0, 1.0],
            jitter: 0.4,
            autostop: 0.5,
            expand: (0.2, 35),
            adc_bailout: 1.0 / 255.0,
            max_trace_level: 5,
            media: (0, 1.0),
        }
    }
}
