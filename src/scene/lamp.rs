//! Lamps for the path integrator, in Cycles' units. A [`super::Light`] carries one when the front end knows it; the light's own fields are
//! the likeness that the classic integrator draws. Source of the units: measured (docs/path.md).

use super::visibility::Visibility;
use crate::math::{Rgb, Transform};

/// Form of a lamp about the origin of its own space; it looks along -z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LampShape {
    /// A ball, or with `soft_falloff` a disc that always faces the lit point (Blender's default). Radius 0 is a point.
    Point {
        /// Scene units; the transform does not scale it.
        radius: f64,
        /// See above.
        soft_falloff: bool,
    },
    /// A point lamp whose light is cut to a cone.
    Spot {
        /// As a point lamp's.
        radius: f64,
        /// As a point lamp's.
        soft_falloff: bool,
        /// Full angle of the cone.
        angle_rad: f64,
        /// 0..=1, share of the cone over which it fades, in cosines: smoothstep((cos - cos_half) / ((1 - cos_half) blend)).
        blend: f64,
    },
    /// Parallel light from a disc at infinity.
    Sun {
        /// Full angle of the disc.
        angle_rad: f64,
    },
    /// One-sided area.
    Area {
        /// Ellipse in place of a rectangle.
        ellipse: bool,
        /// Along x and y of its own space, whole; diameters of an ellipse. The transform's x and y axes scale them.
        size: [f64; 2],
        /// Full angle of the cone in which it shines; π for all directions.
        spread_rad: f64,
    },
}

/// A lamp.
#[derive(Clone, Debug, PartialEq)]
pub struct Lamp {
    /// Form.
    pub shape: LampShape,
    /// Colour times strength, exposure and temperature included: watts by channel (point, spot: I = W/4π; area: L = W/πA), or W/m² at right
    /// angles (sun).
    pub power: Rgb,
    /// Parent (the scene, once loaded) from lamp.
    pub transform: Transform,
    /// Ray kinds that hit it or are lit by it. `SHADOW` means nothing here. Cycles' lamps are never seen by camera rays: its exporter says so.
    pub visibility: Visibility,
    /// Things between block it.
    pub cast_shadow: bool,
    /// Rays that hit it by chance count, weighed against sampling it (multiple importance sampling). False: sampling alone.
    pub multiple_importance: bool,
    /// Deepest bounce that it lights, as Cycles' max bounces.
    pub max_bounces: u32,
}

impl Lamp {
    /// A lamp with Blender's defaults besides.
    pub fn new(shape: LampShape, power: Rgb, transform: Transform) -> Self {
        Self {
            shape,
            power,
            transform,
            visibility: Visibility::ALL.without(Visibility::CAMERA),
            cast_shadow: true,
            multiple_importance: true,
            max_bounces: 1024,
        }
    }
}
