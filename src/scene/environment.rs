//! What rays of the path integrator see that hit nothing: Blender's world. POV-Ray's background and sky sphere stand in the scene beside it.

use super::visibility::Visibility;
use super::volume::Volume;
use crate::math::{DMat3, Rgb, Vec3};
use std::sync::Arc;

/// Radiance by direction.
#[derive(Clone, Debug, PartialEq)]
pub struct Environment {
    /// Colours.
    pub source: EnvironmentSource,
    /// Multiplies them (strength included).
    pub strength: Rgb,
    /// World direction to the source's: columns are the images of x, y, z. Orthonormal (a mirror may be in it).
    pub rotation: DMat3,
    /// Ray kinds that see it. `SHADOW` means nothing here.
    pub visibility: Visibility,
    /// Sampled as a lamp; false: met by chance only.
    pub sampled: bool,
    /// What the camera sees in its place.
    pub for_camera: Option<Box<Environment>>,
    /// What fills the world.
    pub volume: Option<Volume>,
}

impl Environment {
    /// One colour everywhere.
    pub fn constant(radiance: Rgb) -> Self {
        Self {
            source: EnvironmentSource::Constant,
            strength: radiance,
            rotation: DMat3::IDENTITY,
            visibility: Visibility::ALL,
            sampled: true,
            for_camera: None,
            volume: None,
        }
    }
}

/// Where the colours come from. Directions are in the source's space, +z up, as Blender has it.
#[derive(Clone, Debug, PartialEq)]
pub enum EnvironmentSource {
    /// White.
    Constant,
    /// Equirectangular: the column is 0.5 - atan2(y, x) / 2π of the width from the left, so that the picture's middle looks along +x and
    /// its left quarter along +y; the top row looks up.
    Equirect {
        /// The picture.
        image: Arc<FloatImage>,
        /// Mix of the four nearest texels; false: the nearest.
        linear: bool,
    },
    /// A mirror ball seen along +y, as Blender has it.
    MirrorBall {
        /// The picture.
        image: Arc<FloatImage>,
        /// As above.
        linear: bool,
    },
    /// Clear sky.
    Sky(Sky),
}

/// Linear Rec.709 colours, `[height][width]`, row-major, top row first.
#[derive(Clone, Debug, PartialEq)]
pub struct FloatImage {
    /// Columns, at least 1.
    pub width: u32,
    /// Rows, at least 1.
    pub height: u32,
    /// `width * height` colours.
    pub texels: Vec<Vec3>,
}

/// How a clear sky scatters light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SkyModel {
    /// Once, as Blender 4's NISHITA shows it.
    Nishita,
    /// Once, as Blender 5's SINGLE_SCATTERING shows it: the same light, its table laid out better.
    Single,
    /// Many times: Blender 5's MULTIPLE_SCATTERING.
    Multiple,
}

/// A clear sky by scattering of sunlight, with the sun's disc. Parameters as Blender's Sky Texture node.
#[derive(Clone, Debug, PartialEq)]
pub struct Sky {
    /// What is simulated.
    pub model: SkyModel,
    /// The disc is drawn (and sampled).
    pub sun_disc: bool,
    /// Full angle of the disc.
    pub sun_size_rad: f32,
    /// Multiplies the disc.
    pub sun_intensity: f32,
    /// Above the horizon.
    pub sun_elevation_rad: f32,
    /// About +z, from +y clockwise seen from above, as Blender.
    pub sun_rotation_rad: f32,
    /// Metres above the sea.
    pub altitude_m: f32,
    /// Density of air molecules, 1 is Earth's.
    pub air_density: f32,
    /// Density of dust and water, 1 is a clear day.
    pub dust_density: f32,
    /// Density of ozone, 1 is Earth's.
    pub ozone_density: f32,
}

impl Default for Sky {
    /// Blender 4.5's defaults.
    fn default() -> Self {
        Self {
            model: SkyModel::Nishita,
            sun_disc: true,
            sun_size_rad: 0.545f32.to_radians(),
            sun_intensity: 1.0,
            sun_elevation_rad: 15.0f32.to_radians(),
            sun_rotation_rad: 0.0,
            altitude_m: 0.0,
            air_density: 1.0,
            dust_density: 1.0,
            ozone_density: 1.0,
        }
    }
}
