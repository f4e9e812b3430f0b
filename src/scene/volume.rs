//! What fills a body or the world, for the path integrator: absorption, scattering and emission, the same everywhere or by a grid.
//! POV-Ray's `media` are in `interior.rs`.

use crate::math::{Rgb, Transform, Vec3};
use std::sync::Arc;

/// A participating medium. Coefficients are per scene unit, where the grid gives 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Volume {
    /// Absorption coefficient.
    pub absorption: Rgb,
    /// Scattering coefficient.
    pub scattering: Rgb,
    /// Emitted radiance per scene unit.
    pub emission: Rgb,
    /// Henyey-Greenstein's g, -1..1, above 0 forward.
    pub anisotropy: f32,
    /// Multiplies all coefficients by place; `None`: 1 everywhere.
    pub density: Option<Density>,
}

/// Densities in a box of the object's own space.
#[derive(Clone, Debug, PartialEq)]
pub struct Density {
    /// Cells, shared by all that use them.
    pub grid: Arc<Grid>,
    /// The unit cube of the grid to the space of the object (before `Object::transform`); for the world's volume to world space.
    pub transform: Transform,
}

/// Numbers at cell centres, mixed linearly between them and clamped to the outer ones; outside the unit cube 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    /// Cells along x, y, z; each at least 1.
    pub size: [u32; 3],
    /// `size` numbers, 0 and more, x running fastest, then y.
    pub cells: Vec<f32>,
}

impl Volume {
    /// Blender's Principled Volume without blackbody: `density` times colour scatters; what colour leaves, times what the absorption
    /// colour lets be taken, absorbs. Source: measured against Cycles (docs/path.md).
    pub fn principled(color: Rgb, absorption_color: Rgb, density: f32, anisotropy: f32, emission: Rgb) -> Self {
        let absorbed = (Vec3::ONE - color).max(Vec3::ZERO) * (Vec3::ONE - absorption_color.max(Vec3::ZERO).map(f32::sqrt)).max(Vec3::ZERO);
        Self { absorption: absorbed * density, scattering: color * density, emission, anisotropy, density: None }
    }
}
