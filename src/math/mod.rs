//! Numbers without meaning: vectors, transforms, bounds, rays, colours, noise, random streams, polynomial roots.
//! Nothing here knows of scenes, files or devices.

pub mod bernstein;
pub mod bounds;
pub mod color;
pub mod complex;
mod lattice;
pub mod noise;
pub mod random;
pub mod ray;
pub mod roots;
pub mod simd;
pub mod sobol;
pub mod statistics;
pub mod transform;

pub use bounds::Bounds;
pub use color::{Rgb, Rgbft};
pub use glam::{DAffine3, DMat3, DVec2, DVec3, DVec4, Vec3, Vec3A};
pub use ray::Ray;
pub use transform::Transform;

/// POV-Ray's "equal" for geometry and comparisons. Source: spec/objects.md, section 0.
pub const EPSILON: f64 = 1e-10;
/// POV-Ray's far limit: most shapes drop hits at or beyond it. Source: spec/objects.md, section 0.
pub const MAX_DISTANCE: f64 = 1e7;
/// The half size of POV-Ray's unbounded boxes. Source: spec/objects.md, section 0.
pub const BOUND_HUGE: f64 = 2e10;

/// `b^e`, by multiplications where `e` is a small whole number.
#[inline]
pub fn to_power(b: f64, e: f64) -> f64 {
    if e.trunc() == e && e.abs() <= 64.0 { b.powi(e as i32) } else { b.powf(e) }
}
