//! Geometry as flat arrays: primitives, the shapes of each kind, transforms, clip programs.
//!
//! CSG is flattened: every leaf is a primitive of its own, whose bounds are already cut by its CSG parents, and whose
//! clip program says whether a hit on it stands (ARCHITECTURE.md, "CSG without recursion").

use crate::math::{Bounds, Transform};

/// Kinds of primitives; the number is the tag on the GPU.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
#[expect(missing_docs, reason = "the names are POV-Ray's")]
pub enum PrimKind {
    Sphere = 0,
    Box,
    Cylinder,
    Cone,
    Plane,
    Disc,
    Torus,
    Triangle,
    Mesh,
    Polygon,
    BicubicPatch,
    Quadric,
    Poly,
    Blob,
    Lathe,
    Sor,
    Prism,
    SphereSweep,
    Superellipsoid,
    Ovus,
    JuliaFractal,
    HeightField,
    Isosurface,
    Parametric,
    Glyph,
}

/// Bits of [`Prim::flags`].
#[expect(missing_docs, reason = "as scene::ObjectFlags")]
pub mod prim_flags {
    pub const NO_SHADOW: u32 = 1 << 0;
    pub const NO_IMAGE: u32 = 1 << 1;
    pub const NO_REFLECTION: u32 = 1 << 2;
    pub const NO_RADIOSITY: u32 = 1 << 3;
    pub const DOUBLE_ILLUMINATE: u32 = 1 << 4;
    /// Normal and inside are swapped (an odd number of inversions above it).
    pub const INVERTED: u32 = 1 << 5;
    /// Texture is evaluated at (u, v, 0).
    pub const UV_MAPPING: u32 = 1 << 6;
    /// Child of an intersection, difference or merge: all its hits matter, not the nearest alone.
    pub const CSG_CHILD: u32 = 1 << 7;
    /// Some texture of it may let light through: shadow rays go on.
    pub const TRANSPARENT: u32 = 1 << 8;
    /// Takes the textures of what it cuts.
    pub const CUTAWAY: u32 = 1 << 9;
    /// Not lit by the scene's lights (member of a light group without `global_lights`).
    pub const NO_GLOBAL_LIGHTS: u32 = 1 << 10;
}

/// One leaf of the scene.
#[derive(Clone, Copy, Debug)]
pub struct Prim {
    /// Which table `shape_ix` points into.
    pub kind: PrimKind,
    /// Shape in its kind's table.
    pub shape_ix: u32,
    /// World from shape space, into [`Geometry::transforms`]; 0 is the identity.
    pub transform_ix: u32,
    /// Cover, into [`Geometry::surfaces`].
    pub surface_ix: u32,
    /// Filling, into `CompiledScene::interiors`.
    pub interior_ix: u32,
    /// Top-level object, into [`Geometry::objects`].
    pub object_ix: u32,
    /// First step of the clip program in [`Geometry::clip_steps`].
    pub clip_start: u32,
    /// Steps of the clip program, 0 when every hit stands.
    pub clip_len: u32,
    /// [`prim_flags`].
    pub flags: u32,
    /// Light group, or `NONE`.
    pub group_ix: u32,
}

/// What covers a primitive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Surface {
    /// Into `TextureTables::textures`, or `NONE`.
    pub texture: u32,
    /// For hits from inside, or `NONE`.
    pub interior_texture: u32,
    /// World from the texture's space, into [`Geometry::transforms`].
    pub transform_ix: u32,
}

/// A step of an inside program, in postfix order; the result of a program is the value left on the stack.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InsideStep {
    /// Whether the point is inside primitive `prim_ix` (its own inversion applied, its clip program not).
    Prim(u32),
    /// Both of the two topmost values.
    And,
    /// Either of the two topmost values.
    Or,
    /// The opposite of the topmost value.
    Not,
}

/// A range of steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct InsideProgram {
    /// First step in [`Geometry::clip_steps`].
    pub start: u32,
    /// Number of steps; 0 is "never inside".
    pub len: u32,
}

impl InsideProgram {
    /// Deepest stack that a program may need: one bit each of a `u64`.
    pub const MAX_DEPTH: usize = 64;
}

/// A top-level object.
#[derive(Clone, Debug)]
pub struct ObjectRecord {
    /// Its primitives, consecutive.
    pub prims: std::ops::Range<u32>,
    /// Whether a point is inside the whole object.
    pub inside: InsideProgram,
    /// World box.
    pub bounds: Bounds,
}

/// All geometry of a scene. Shape tables (one per kind) are added here by kind.
#[derive(Debug, Default)]
pub struct Geometry {
    /// Leaves, grouped by top-level object.
    pub prims: Vec<Prim>,
    /// World boxes of the leaves, same order, already cut by CSG parents.
    pub bounds: Vec<Bounds>,
    /// Distinct transforms; entry 0 is the identity.
    pub transforms: Vec<Transform>,
    /// Distinct covers.
    pub surfaces: Vec<Surface>,
    /// Steps of clip and inside programs.
    pub clip_steps: Vec<InsideStep>,
    /// Top-level objects.
    pub objects: Vec<ObjectRecord>,
}
