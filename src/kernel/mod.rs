//! What both machines must do, on the CPU: intersect, traverse, pattern, texture, finish, media, light. Twins stand in `shaders/shared/`.
//! The kernel reads a `CompiledScene` and never allocates per ray.

pub mod atmosphere;
pub mod bsdf;
pub mod camera;
pub mod cover;
pub mod finish;
pub mod function;
#[cfg(test)]
mod geometry_tests;
pub mod image;
pub mod inside;
pub mod intersect;
pub mod lens;
pub mod light;
pub mod material;
pub mod media;
pub mod merged;
pub mod mesh_camera;
pub mod normal;
mod offers;
pub mod panorama;
pub mod pattern;
pub mod pigment;
pub mod query;
#[cfg(test)]
mod reference_tests;
pub mod shadow_packet;
pub mod spline;
pub mod texture;
pub mod traverse;
pub mod warp;

use crate::math::{DVec2, DVec3};

/// A point where a ray meets a surface.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceHit {
    /// Ray parameter, in units of the ray's direction.
    pub t: f64,
    /// Primitive hit.
    pub prim_ix: u32,
    /// Part of the primitive (mesh face), else 0.
    pub face_ix: u32,
    /// World point.
    pub point: DVec3,
    /// Unit normal with the primitive's inversion applied, not turned to the viewer.
    pub normal: DVec3,
    /// Texture coordinates; only meaningful when the primitive's texture wants them.
    pub uv: DVec2,
    /// Barycentric weights of a face's corners 1 and 2.
    pub barycentric: DVec2,
}

/// What a pattern may look at.
#[derive(Clone, Copy, Debug)]
pub struct PatternPoint {
    /// The point in the space of the texture (before its warps).
    pub point: DVec3,
    /// Texture coordinates.
    pub uv: DVec2,
    /// World point (slope's `point_at`).
    pub world: DVec3,
    /// Perturbed unit normal facing the viewer, world space; zero when there is no surface.
    pub normal: DVec3,
    /// Unit ray direction, world space; zero when there is no ray.
    pub ray_dir: DVec3,
}
