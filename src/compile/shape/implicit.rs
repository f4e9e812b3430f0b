//! Isosurfaces, parametric surfaces and julia fractals. Source: spec/objects.md, sections 9 to 11.

use crate::math::{Bounds, DVec2, DVec3, DVec4};
use crate::scene::shape::{Container, JuliaFunction};

/// A surface where a function equals a threshold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IsosurfaceShape {
    /// Into the function table.
    pub function: u32,
    /// Where it is looked for.
    pub container: Container,
    /// Value on the surface.
    pub threshold: f64,
    /// Longest interval that counts as a root; step of normals.
    pub accuracy: f64,
    /// Bound on the slope.
    pub max_gradient: f64,
    /// Numbers of `evaluate`.
    pub evaluate: Option<[f64; 3]>,
    /// The container does not show.
    pub open: bool,
    /// Most hits.
    pub max_trace: u32,
}

/// A surface of points (x, y, z)(u, v).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParametricShape {
    /// Into the function table.
    pub functions: [u32; 3],
    /// Least u and v.
    pub min: DVec2,
    /// Greatest u and v.
    pub max: DVec2,
    /// Where it is looked for.
    pub container: Container,
    /// Size of the last rectangle; step of normals.
    pub accuracy: f64,
    /// Bound on the slope.
    pub max_gradient: f64,
}

/// Box of a container.
pub fn container_bounds(c: &Container) -> Bounds {
    match c {
        Container::Box { min, max } => Bounds::from_corners(*min, *max),
        Container::Sphere { center, radius } => {
            let r = DVec3::splat(radius.abs());
            Bounds { min: *center - r, max: *center + r }
        }
    }
}

/// A slice of a four-dimensional Julia set.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JuliaShape {
    /// Added in every step.
    pub c: DVec4,
    /// Two complex numbers in place of a quaternion.
    pub hypercomplex: bool,
    /// Iterated.
    pub function: JuliaFunction,
    /// Steps without escape that count as inside.
    pub max_iteration: u32,
    /// 1 / least step along a ray.
    pub precision: f64,
    /// w = w0 + slope·(x, y, z) in the slice.
    pub w0: f64,
    /// See `w0`.
    pub w_slope: DVec3,
    /// Squared length beyond which a point has escaped.
    pub escape_sq: f64,
    /// Radius of the sphere around it.
    pub radius: f64,
}

impl JuliaShape {
    /// `None` for a slice without w.
    pub fn new(
        c: DVec4,
        hypercomplex: bool,
        function: JuliaFunction,
        max_iteration: u32,
        precision: f64,
        slice: DVec4,
        dist: f64,
    ) -> Option<Self> {
        if slice.w.abs() < 1e-10 {
            return None;
        }
        // POV-Ray has no hypercomplex cube: it squares.
        let function = if hypercomplex && function == JuliaFunction::Cube { JuliaFunction::Sqr } else { function };
        let (escape_sq, radius) = if hypercomplex {
            (16.0, 4.0)
        } else {
            let r = (1.0 + c.length() + 1e-7).min(2.0);
            (r * r + 1e-7, r)
        };
        // The slice is unit as far as its distance goes.
        let w_slope = -slice.truncate() / slice.w;
        let precision = precision.max(1e-6);
        Some(Self { c, hypercomplex, function, max_iteration, precision, w0: dist * slice.length() / slice.w, w_slope, escape_sq, radius })
    }
}
