//! Shapes: what a ray can hit, in the numbers that the scene gives. Source: spec/objects.md.

use super::{Curves, Function, Light, Object, Texture};
use crate::math::{DVec2, DVec3, DVec4, Transform, Vec3};
use std::sync::Arc;

/// Set operations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Csg {
    /// All surfaces of all children.
    Union,
    /// Surfaces inside every other child.
    Intersection,
    /// Surfaces of the first outside the others, and of the others inside the first.
    Difference,
    /// Surfaces outside every other child.
    Merge,
}

/// A triangle mesh, shared by its instances. Vertices and normals are 32-bit, as in POV-Ray and glTF.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// Corner points.
    pub vertices: Vec<Vec3>,
    /// Unit normals; faces index them by `normal_indices`.
    pub normals: Vec<Vec3>,
    /// Texture coordinates; faces index them by `uv_indices`.
    pub uvs: Vec<[f32; 2]>,
    /// Corners of every face, all below `vertices.len()`; degenerate faces are gone.
    pub faces: Vec<[u32; 3]>,
    /// Per face; `u32::MAX` in the first place marks a flat face. Empty: all faces are flat.
    pub normal_indices: Vec<[u32; 3]>,
    /// Per face; empty: no coordinates.
    pub uv_indices: Vec<[u32; 3]>,
    /// Covers of faces, in the mesh's own space.
    pub textures: Vec<Arc<Texture>>,
    /// Per face, into `textures`, by corner; `u32::MAX` takes the object's. Empty: all take the object's.
    pub face_textures: Vec<[u32; 3]>,
    /// Makes the mesh solid: parity of hits along it.
    pub inside_vector: Option<DVec3>,
    /// Corner colours (imports), linear RGBA, by vertex; empty for none.
    pub colors: Vec<[f32; 4]>,
    /// More texture coordinates, for pictures that ask for them by number (imports).
    pub more_uvs: Vec<UvSet>,
    /// Places at evenly spaced times over the shutter, at least 2; empty: it stands still. Path integrator alone.
    pub motion: Vec<MeshStep>,
}

/// Where a mesh is at one time of the shutter.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshStep {
    /// Like `Mesh::vertices`.
    pub vertices: Vec<Vec3>,
    /// Like `Mesh::normals`, unit; empty: those at rest.
    pub normals: Vec<Vec3>,
}

/// Texture coordinates of a mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct UvSet {
    /// Coordinates; (0, 0) is glTF's: the upper left corner of a picture.
    pub uvs: Vec<[f32; 2]>,
    /// Per face.
    pub indices: Vec<[u32; 3]>,
}

/// One part of a blob.
#[derive(Clone, Debug)]
pub struct BlobComponent {
    /// Form of the field.
    pub kind: BlobKind,
    /// Field at the centre.
    pub strength: f64,
    /// Component space to blob space.
    pub transform: Transform,
    /// Own cover, in blob space.
    pub texture: Option<Arc<Texture>>,
}

/// Form of a blob component's field.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(missing_docs, reason = "the names say it")]
pub enum BlobKind {
    Sphere { center: DVec3, radius: f64 },
    Cylinder { a: DVec3, b: DVec3, radius: f64 },
}

/// Curves through control points, for lathes and prisms.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "the names are POV-Ray's")]
pub enum CurveKind {
    Linear,
    Quadratic,
    Cubic,
    Bezier,
}

/// Curves of sphere sweeps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "the names are POV-Ray's")]
pub enum SweepKind {
    Linear,
    Cubic,
    BSpline,
}

/// Where an implicit surface lives.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(missing_docs, reason = "the names say it")]
pub enum Container {
    Box { min: DVec3, max: DVec3 },
    Sphere { center: DVec3, radius: f64 },
}

/// The iterated function of a julia_fractal.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(missing_docs, reason = "the names are POV-Ray's")]
pub enum JuliaFunction {
    Sqr,
    Cube,
    Exp,
    Reciprocal,
    Sin,
    Asin,
    Sinh,
    Asinh,
    Cos,
    Acos,
    Cosh,
    Acosh,
    Tan,
    Atan,
    Tanh,
    Atanh,
    Ln,
    Pwr(f64, f64),
}

/// A shape in its own space.
#[derive(Clone, Debug)]
#[expect(missing_docs, reason = "the names are POV-Ray's; spec/objects.md defines each")]
pub enum Shape {
    Sphere {
        center: DVec3,
        radius: f64,
    },
    Box {
        min: DVec3,
        max: DVec3,
    },
    Cylinder {
        a: DVec3,
        b: DVec3,
        radius: f64,
        open: bool,
    },
    Cone {
        a: DVec3,
        radius_a: f64,
        b: DVec3,
        radius_b: f64,
        open: bool,
    },
    /// `normal` is unit: points with normal·p = distance.
    Plane {
        normal: DVec3,
        distance: f64,
    },
    /// `normal` is unit.
    Disc {
        center: DVec3,
        normal: DVec3,
        radius: f64,
        hole: f64,
    },
    Torus {
        major: f64,
        minor: f64,
    },
    /// Normals when smooth (unit).
    Triangle {
        vertices: [DVec3; 3],
        normals: Option<[DVec3; 3]>,
    },
    Mesh(Arc<Mesh>),
    Polygon {
        points: Vec<DVec3>,
    },
    BicubicPatch {
        points: Box<[[DVec3; 4]; 4]>,
        uvs: [DVec2; 4],
        flatness: f64,
        u_steps: u32,
        v_steps: u32,
        accuracy: f64,
    },
    /// x², y², z², xy, xz, yz, x, y, z, 1.
    Quadric {
        coefficients: [f64; 10],
    },
    /// Coefficients in POV-Ray's order.
    Poly {
        order: u32,
        coefficients: Vec<f64>,
    },
    Blob {
        threshold: f64,
        components: Vec<BlobComponent>,
    },
    Lathe {
        kind: CurveKind,
        points: Vec<DVec2>,
    },
    Sor {
        points: Vec<DVec2>,
        open: bool,
    },
    Prism {
        kind: CurveKind,
        conic: bool,
        low: f64,
        high: f64,
        points: Vec<DVec2>,
        open: bool,
    },
    SphereSweep {
        kind: SweepKind,
        spheres: Vec<(DVec3, f64)>,
        tolerance: f64,
    },
    Superellipsoid {
        e: f64,
        n: f64,
    },
    Ovus {
        bottom: f64,
        top: f64,
    },
    /// `slice` is the plane's normal in 4-space.
    JuliaFractal {
        c: DVec4,
        hypercomplex: bool,
        function: JuliaFunction,
        max_iteration: u32,
        precision: f64,
        slice: DVec4,
        slice_distance: f64,
    },
    HeightField {
        heights: Arc<HeightGrid>,
        water_level: f64,
        smooth: bool,
    },
    Isosurface {
        function: Arc<Function>,
        container: Container,
        threshold: f64,
        accuracy: f64,
        max_gradient: f64,
        evaluate: Option<[f64; 3]>,
        open: bool,
        max_trace: u32,
    },
    Parametric {
        functions: [Arc<Function>; 3],
        min: DVec2,
        max: DVec2,
        container: Container,
        accuracy: f64,
        max_gradient: f64,
        precompute: Option<(u32, [bool; 3])>,
    },
    /// Outlines are resolved: `glyphs` are extruded, each at its offset.
    Text {
        glyphs: Vec<Glyph>,
        depth: f64,
    },
    Csg {
        op: Csg,
        children: Vec<Object>,
    },
    /// Hair.
    Curves(Arc<Curves>),
    /// Another object, with a transform and modifiers of its own around it.
    Group {
        child: Arc<Object>,
    },
    /// `global_lights`: the scene's lights shine on the members too.
    LightGroup {
        children: Vec<Object>,
        lights: Vec<Light>,
        global_lights: Option<bool>,
    },
    /// A light inside a union.
    Light(Box<Light>),
}

/// Heights of a height field, 0..=65535, `[height][width]`, bottom row (z = 0) first.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightGrid {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Heights.
    pub heights: Vec<u16>,
}

/// A letter's outline: closed contours of line and quadratic segments in units of the em.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Glyph {
    /// Place of the glyph's origin.
    pub offset: DVec3,
    /// Each contour's segments: start, control (equal to the start for a line), end.
    pub contours: Vec<Vec<[DVec2; 3]>>,
}
