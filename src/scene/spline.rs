//! Splines of the scene language: values at knots. Source: spec/objects.md, section 17.

/// How values between knots are found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SplineKind {
    /// Straight.
    Linear,
    /// Parabola through three knots.
    Quadratic,
    /// Hermite with mean secants as slopes; defined between the second and the last but one knot.
    Cubic,
    /// Twice differentiable, no curvature at the ends.
    Natural,
}

/// A spline of 2 to 5 components.
#[derive(Clone, Debug, PartialEq)]
pub struct Spline {
    /// Default kind.
    pub kind: SplineKind,
    /// Number of components, 2..=5.
    pub n_components: usize,
    /// `(t, value)` sorted by `t`, no two equal, at least one; unused components are 0.
    pub knots: Vec<(f64, [f64; 5])>,
}
