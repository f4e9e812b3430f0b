//! What fills objects and the air: interiors, media, fog, rainbows, the sky.

use super::{BlendMap, Pigment};
use crate::math::{DVec3, Rgb, Rgbft, Transform, Vec3};
use std::sync::Arc;

/// `interior{}`. Source: spec/textures.md, section 10.
#[derive(Clone, Debug)]
pub struct Interior {
    /// Index of refraction, 1 when not given.
    pub ior: f64,
    /// Ratio of the indices of violet and red, 1 for none.
    pub dispersion: f64,
    /// Bands of a dispersed ray, at least 2.
    pub dispersion_samples: u32,
    /// The caustics trick, 0 for none.
    pub caustics: f64,
    /// Colour at infinite depth.
    pub fade_color: Rgb,
    /// Depth of half attenuation, 0 for none.
    pub fade_distance: f64,
    /// 1000 and more is exponential.
    pub fade_power: f64,
    /// Old `refraction` value: multiplies what is seen through.
    pub old_refraction: f64,
    /// Media inside.
    pub media: Vec<Media>,
}

impl Default for Interior {
    fn default() -> Self {
        Self {
            ior: 1.0,
            dispersion: 1.0,
            dispersion_samples: 7,
            caustics: 0.0,
            fade_color: Vec3::ZERO,
            fade_distance: 0.0,
            fade_power: 0.0,
            old_refraction: 1.0,
            media: Vec::new(),
        }
    }
}

impl Interior {
    /// Moves the densities.
    pub fn transform(&mut self, t: &Transform) {
        for m in &mut self.media {
            m.transform(t);
        }
    }
}

/// `media{}`. Source: spec/light.md, section 7.
#[derive(Clone, Debug)]
pub struct Media {
    /// Intervals a ray segment.
    pub intervals: u32,
    /// Fewest and most samples an interval.
    pub samples: (u32, u32),
    /// 1, 2 or 3.
    pub method: u8,
    /// Of sample places.
    pub jitter: f64,
    /// Method 3: difference that subdivides.
    pub aa_threshold: f64,
    /// Method 3: deepest subdivision.
    pub aa_level: u32,
    /// Share of intervals for lit pieces.
    pub ratio: f64,
    /// 0..1.
    pub confidence: f64,
    /// Of samples.
    pub variance: f64,
    /// Per scene unit.
    pub absorption: Rgb,
    /// Per scene unit.
    pub emission: Rgb,
    /// Per scene unit.
    pub scattering: Rgb,
    /// Phase function 1..=5.
    pub scattering_type: u8,
    /// Henyey–Greenstein's g.
    pub eccentricity: f64,
    /// Multiplies scattering in the extinction.
    pub extinction: f64,
    /// Photons are collected.
    pub collect: bool,
    /// Densities; they multiply.
    pub densities: Vec<Arc<Pigment>>,
}

impl Default for Media {
    fn default() -> Self {
        Self {
            intervals: 1,
            samples: (10, 10),
            method: 3,
            jitter: 0.0,
            aa_threshold: 0.1,
            aa_level: 3,
            ratio: 0.9,
            confidence: 0.9,
            variance: 1.0 / 128.0,
            absorption: Vec3::ZERO,
            emission: Vec3::ZERO,
            scattering: Vec3::ZERO,
            scattering_type: 1,
            eccentricity: 0.0,
            extinction: 1.0,
            collect: true,
            densities: Vec::new(),
        }
    }
}

impl Media {
    /// Moves the densities.
    pub fn transform(&mut self, t: &Transform) {
        for d in &mut self.densities {
            Arc::make_mut(d).transform(t);
        }
    }
}

/// `fog{}`. Source: spec/light.md, section 5.
#[derive(Clone, Debug)]
pub struct Fog {
    /// Colour; filter tints what is behind, transmit is the least transparency.
    pub color: Rgbft,
    /// Depth of 1/e, not 0.
    pub distance: f64,
    /// `Some((offset, alt))` for ground fog.
    pub ground: Option<(f64, f64)>,
    /// Unit height direction.
    pub up: DVec3,
    /// Turbulence with its vector and `turb_depth`.
    pub turbulence: Option<(super::pattern::Turbulence, f64)>,
}

/// `rainbow{}`, vectors made orthonormal. Source: spec/light.md, section 5.
#[derive(Clone, Debug)]
pub struct Rainbow {
    /// Antisolar direction, unit.
    pub direction: DVec3,
    /// Unit, perpendicular to `direction`.
    pub up: DVec3,
    /// Middle of the bow, radians.
    pub angle_rad: f64,
    /// Width of the bow, radians, not 0.
    pub width_rad: f64,
    /// Whole arc, radians; `None` for no limit.
    pub arc_rad: Option<f64>,
    /// Arc without fading, radians.
    pub falloff_rad: f64,
    /// Like a fog's.
    pub distance: f64,
    /// Random shift of the index.
    pub jitter: f64,
    /// Colours from the inner edge to the outer.
    pub color_map: Arc<BlendMap<Rgbft>>,
}

/// `sky_sphere{}`: pigments seen by direction, first written at the bottom.
#[derive(Clone, Debug)]
pub struct SkySphere {
    /// Bottom first.
    pub pigments: Vec<Arc<Pigment>>,
    /// Colour factor.
    pub emission: Rgb,
    /// Sky from its own space to the world; directions are mapped back as points.
    pub transform: Transform,
}
