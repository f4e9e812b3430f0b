//! Geometry as flat arrays: primitives, the shapes of each kind, transforms, clip programs.
//!
//! CSG is flattened: every leaf is a primitive of its own, whose bounds are already cut by its CSG parents, and whose
//! clip program says whether a hit on it stands (ARCHITECTURE.md, "CSG without recursion").

use super::motion::Motion;
use super::shape::Shapes;
use crate::accel::Accel;
use crate::math::{Bounds, Transform};
use crate::scene::object::PathTraits;

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
    /// Imports only.
    Hair,
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
    /// Not part of the picture (projected_through, object patterns): neither in the tree nor in the unbounded list.
    pub const HIDDEN: u32 = 1 << 11;
    /// Only asked whether points are inside (clip objects); no ray hits it. Always `HIDDEN` too.
    pub const INSIDE_ONLY: u32 = 1 << 12;
    /// Some texture of it looks at (u, v) although the object does not map all of it.
    pub const NEEDS_UV: u32 = 1 << 13;
    /// Its object has `bounded_by` or `cull_box`, which must be asked.
    pub const BOUNDED: u32 = 1 << 14;
    /// Flags that a ray may skip by.
    pub const SKIPPABLE: u32 = NO_SHADOW | NO_IMAGE | NO_REFLECTION | NO_RADIOSITY;
    /// Unseen by rays of the path integrator after a bounce of that kind. Those of the camera and shadow rays are `NO_IMAGE`, `NO_SHADOW`.
    pub const NO_DIFFUSE: u32 = 1 << 15;
    pub const NO_GLOSSY: u32 = 1 << 16;
    pub const NO_TRANSMISSION: u32 = 1 << 17;
    pub const NO_VOLUME: u32 = 1 << 18;
    /// Its object moves while the shutter is open: `ObjectRecord::motion`.
    pub const MOVING: u32 = 1 << 19;
    /// No shadow catcher.
    pub const NO_CATCHER: u32 = 1 << 20;
    /// Photons: said to reflect or refract them, said not to (both may stand: then it does not).
    pub const PHOTON_REFLECTION: u32 = 1 << 21;
    pub const PHOTON_NO_REFLECTION: u32 = 1 << 22;
    pub const PHOTON_REFRACTION: u32 = 1 << 23;
    pub const PHOTON_NO_REFRACTION: u32 = 1 << 24;
    /// Keeps no photons and shows none.
    pub const PHOTON_NO_COLLECT: u32 = 1 << 25;
    /// Photons go straight on to their target.
    pub const PHOTON_PASS_THROUGH: u32 = 1 << 26;
    /// Part of a photon target.
    pub const PHOTON_TARGET: u32 = 1 << 27;
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

impl Prim {
    /// Whether a ray's hits beyond the first are wanted too, as CSG or clip objects may take the first away.
    #[inline]
    pub fn wants_all_hits(&self) -> bool {
        self.flags & prim_flags::CSG_CHILD != 0 || self.clip_len != 0
    }
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

/// A step of an inside program. Programs run from first to last on a stack of bits; a program whose `Require` steps all
/// hold gives the bit left on the stack, or true when none is left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "the names of the fields say it")]
pub enum InsideStep {
    /// Pushes whether the point is inside primitive `prim_ix` (its own inversion applied, its clip program not).
    Prim(u32),
    /// Both of the two topmost values.
    And,
    /// Either of the two topmost values.
    Or,
    /// The opposite of the topmost value.
    Not,
    /// Pops the topmost value; the whole program is false unless it is true.
    Require,
    /// The whole program is false unless the point is inside the primitive.
    RequireIn(u32),
    /// The whole program is false when the point is inside the primitive.
    RequireOut(u32),
    /// Skips the next `skip` steps when the program runs for a hit on one of the primitives `first..first + count`:
    /// one program serves all children of a CSG, and each leaves out its own part.
    SkipOwn { first: u32, count: u32, skip: u32 },
    /// May skip the next `skip` steps when the point is outside box `box_ix` of [`Geometry::clip_boxes`]:
    /// they could not make the program false there. A hint, right to ignore.
    SkipOutside { box_ix: u32, skip: u32 },
    /// May push false and skip the next `skip` steps when the point is outside box `box_ix` of [`Geometry::clip_boxes`]:
    /// they would push false there. A hint, right to ignore.
    FalseOutside { box_ix: u32, skip: u32 },
}

/// A range of steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct InsideProgram {
    /// First step in [`Geometry::clip_steps`].
    pub start: u32,
    /// Number of steps; 0 is "never inside" for an object, "every hit stands" for a primitive.
    pub len: u32,
}

impl InsideProgram {
    /// Deepest stack that a program may need: one bit each of a `u64`.
    pub const MAX_DEPTH: usize = 64;
}

/// A top-level object, or a hidden one (projected_through, object patterns).
#[derive(Clone, Debug)]
pub struct ObjectRecord {
    /// Its primitives, consecutive; those of its clip objects stand among them (`INSIDE_ONLY`).
    pub prims: std::ops::Range<u32>,
    /// Whether a point is inside the whole object.
    pub inside: InsideProgram,
    /// World box.
    pub bounds: Bounds,
    /// World box of all points that are inside; unbounded for what is inverted.
    pub inside_bounds: Bounds,
    /// Filling of the object as a whole, into `CompiledScene::interiors`; `NONE` for hidden objects.
    pub interior_ix: u32,
    /// Part of the picture.
    pub visible: bool,
    /// Made of shapes that have an inside.
    pub solid: bool,
    /// Objects that a ray must meet, or start in, to meet this one, into [`Geometry::bounding_objects`].
    pub bounded_by: std::ops::Range<u32>,
    /// A box that a ray must meet although the object's surface may lie outside: POV-Ray's own box is too small for some CSG
    /// (discs in intersections, inverted parts), and its pictures show that.
    pub cull_box: Option<Bounds>,
    /// What cut surfaces without a texture show, into [`Geometry::cutaway_parts`].
    pub cutaway: std::ops::Range<u32>,
    /// What the path integrator asks besides.
    pub traits: PathTraits,
    /// How it moves while the shutter is open, in world space; `None`: it stands still.
    pub motion: Option<Motion>,
}

/// What photons are shot at.
#[derive(Clone, Debug)]
pub struct PhotonTarget {
    /// Its primitives, clip objects among them.
    pub prims: std::ops::Range<u32>,
    /// World box as POV-Ray has it.
    pub bounds: Bounds,
    /// Multiplies the distance between photons.
    pub spacing: f64,
    /// Its own [`prim_flags`]; those of its parts may say more.
    pub flags: u32,
}

/// How much there is to intersect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GeometrySize {
    /// Faces of meshes, each mesh once.
    pub faces: usize,
    /// Primitives that are no meshes.
    pub others: usize,
}

impl GeometrySize {
    /// Mostly faces of meshes.
    pub fn is_triangles(self) -> bool {
        self.faces > self.others
    }

    /// Faces and primitives.
    pub fn total(self) -> u64 {
        (self.faces + self.others) as u64
    }
}

/// All geometry of a scene.
#[derive(Debug, Default)]
pub struct Geometry {
    /// Leaves, grouped by top-level object.
    pub prims: Vec<Prim>,
    /// World boxes of the leaves, same order, already cut by CSG parents.
    pub bounds: Vec<Bounds>,
    /// Shape tables.
    pub shapes: Shapes,
    /// Distinct transforms; entry 0 is the identity.
    pub transforms: Vec<Transform>,
    /// Distinct covers.
    pub surfaces: Vec<Surface>,
    /// Steps of clip and inside programs.
    pub clip_steps: Vec<InsideStep>,
    /// By primitive: share of radiosity's rays that look at it; NaN, or missing at the end, where nothing is said.
    pub importances: Vec<f64>,
    /// Hidden objects of `bounded_by`, into [`Geometry::objects`].
    pub bounding_objects: Vec<u32>,
    /// Parts of objects with `cutaway_textures`: where it shows, and its cover.
    pub cutaway_parts: Vec<(InsideProgram, u32)>,
    /// Boxes that programs look at.
    pub clip_boxes: Vec<Bounds>,
    /// Top-level objects in the order of the file (unions dissolved), hidden ones among them.
    pub objects: Vec<ObjectRecord>,
    /// What photons are shot at, in the order of the file.
    pub photon_targets: Vec<PhotonTarget>,
    /// Visible objects made of shapes that have an inside, with the world box of the places where a ray may start in it, in the order of POV-Ray's
    /// bounding hierarchy where it can show, else in that of the file.
    pub solids: Vec<(Bounds, u32)>,
    /// Tree over the boxes of `solids`, for points that may be in any of them.
    pub solids_tree: Accel,
    /// Primitives without finite bounds that rays can hit.
    pub unbounded: Vec<u32>,
    /// Primitives with finite bounds that rays can hit.
    pub bounded: Vec<u32>,
    /// Tree over `bounded` (its primitive k is `bounded[k]`).
    pub tree: Accel,
}

impl Geometry {
    /// Faces and primitives.
    pub fn size(&self) -> GeometrySize {
        let is_mesh = |p: &&Prim| matches!(p.kind, PrimKind::Mesh | PrimKind::BicubicPatch);
        let faces = self.shapes.meshes.iter().map(|m| m.mesh.faces.len()).sum();
        GeometrySize { faces, others: self.prims.iter().filter(|p| !is_mesh(p)).count() }
    }
}
