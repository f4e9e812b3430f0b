//! Hair: many curves with radii.

use crate::math::Vec3;

/// How a hair's cross-section is met.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum CurveStyle {
    /// A flat ribbon that faces the ray and is shaded as if round (Cycles' default).
    #[default]
    Ribbon,
    /// A round tube.
    Tube,
}

/// Curves through points (Catmull-Rom splines that end in their end points, as Cycles has them), shared by instances.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Curves {
    /// All points, curve by curve.
    pub points: Vec<Vec3>,
    /// Radius at each point, scene units, 0 and more.
    pub radii: Vec<f32>,
    /// First point of each curve, ascending, then `points.len()`: curve `k` has the points `starts[k]..starts[k + 1]`, at least 2.
    pub starts: Vec<u32>,
    /// Cross-section.
    pub style: CurveStyle,
    /// Points at evenly spaced times over the shutter, each like `points`; empty: they stand still.
    pub motion: Vec<Vec<Vec3>>,
}
