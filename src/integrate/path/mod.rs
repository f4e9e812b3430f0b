//! Unbiased path tracing with Cycles' light transport, materials, lamps and conventions (docs/path.md).
//!
//! [`PathPlan`] holds what all threads share; [`PathTracer`] traces samples. A sample depends on the pixel, its number and the seed alone.
//! The way of a sample: `camera` → `trace` (one loop over bounces) with `surface` and `closure` at hits, `lights` and `shadow` for direct
//! light, `volume` and `subsurface` between.

mod adaptive;
mod bounce;
pub mod camera;
mod catcher;
mod closure;
pub mod filter;
mod first_hit;
#[cfg(test)]
mod furnace_tests;
pub mod lights;
#[cfg(test)]
mod pass_tests;
mod passes;
mod plan;
mod pov;
mod principled;
mod sampler;
mod shader;
mod shadow;
mod subsurface;
mod surface;
#[cfg(test)]
mod tests;
mod trace;
mod volume;

pub use adaptive::{NoiseMap, STEP};
pub use catcher::{has_catchers, makes_holes};
pub use closure::plain_emission;
pub use passes::manifests;
pub use plan::PathPlan;
pub use pov::left_out;
pub use shadow::NEAR;
pub use trace::{PathTracer, PixelResult};
pub use volume::{MAX_BODIES, WORLD as WORLD_BODY, grid_summary};
