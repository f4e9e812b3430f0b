//! What a front end may ask about parts of a scene while it is still reading: `trace`, `inside`, extents, function values.
//!
//! Things are asked about by `Arc`: whoever answers may keep what it compiled for as long as it keeps the `Arc`, so that a scene that
//! asks a hundred thousand times about one object pays once.
//!
//! The answers need the kernel, which ranks above; so the kernel implements this trait and the job hands it down.

use super::{Function, Object, Pigment, Spline};
use crate::math::{Bounds, DVec3, Ray, Rgbft};
use std::sync::Arc;

/// Answers about objects, functions and pigments that are not part of a compiled scene yet.
pub trait SceneQuery {
    /// Says which noise generator and how many wave sources hold from here on; both may change while a scene is read.
    fn use_noise(&self, _generator: u8, _number_of_waves: u32) {}
    /// Nearest hit of a ray (unit direction) with an object: point and unit normal, inversion applied, not turned to the viewer.
    fn trace(&self, object: &Arc<Object>, ray: &Ray) -> Option<(DVec3, DVec3)>;
    /// Whether a point is inside; `None` when the object has no inside (patches, meshes without inside_vector).
    fn inside(&self, object: &Arc<Object>, point: DVec3) -> Option<bool>;
    /// The box that `min_extent` and `max_extent` give.
    fn extent(&self, object: &Arc<Object>) -> Bounds;
    /// Components of a function's value; unused ones are 0. The count is 1, 3, 5 or the spline's.
    fn call(&self, function: &Arc<Function>, args: &[f64]) -> ([f64; 5], usize);
    /// Colour of a pigment at a point.
    fn pigment(&self, pigment: &Arc<Pigment>, point: DVec3) -> Rgbft;
    /// A spline's value; `kind` overrides its own.
    fn spline(&self, spline: &Spline, t: f64, kind: Option<super::spline::SplineKind>) -> [f64; 5];
}
