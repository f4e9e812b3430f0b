//! Tilings and pavements of the x, z plane. Source: spec/textures.md, section 2.

use crate::math::DVec3;

/// The value of tiling 1..=27.
pub fn tiling(p: DVec3, n: u8) -> f64 {
    let _ = (p, n);
    0.0
}

/// The value of a pavement.
pub fn pavement(p: DVec3, sides: u8, tiles: u8, pattern: u8, interior: u8, exterior: u8, form: u8) -> f64 {
    let _ = (p, sides, tiles, pattern, interior, exterior, form);
    0.0
}
