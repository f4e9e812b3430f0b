//! What each kind of shape needs to be hit: one plain struct a kind, made once from the scene's numbers.
//! Nothing here traces a ray; `kernel/intersect` does.

pub mod algebraic;
pub mod blob;
pub mod curve;
pub mod hair;
pub mod height;
pub mod implicit;
pub mod mesh;
pub mod moving_mesh;
pub mod simple;
pub mod sweep;
pub mod swept;
mod tree_store;
pub mod triangle_pack;

pub use algebraic::{PolyShape, QuadricShape, SuperellipsoidShape};
pub use blob::BlobShape;
pub use hair::HairShape;
pub use height::HeightFieldShape;
pub use implicit::{IsosurfaceShape, JuliaShape, ParametricShape};
pub use mesh::{MeshIndex, MeshShape};
pub use simple::{BoxShape, ConeShape, CylinderShape, DiscShape, PlaneShape, SphereShape, TorusShape, TriangleShape};
pub use sweep::{OvusShape, SphereSweepShape};
pub use swept::{GlyphShape, LatheShape, PolygonShape, PrismShape, SorShape};
pub use tree_store::TreeStore;

/// Tables of shapes, one a kind of primitive.
#[derive(Debug, Default)]
#[expect(missing_docs, reason = "named as `PrimKind`")]
pub struct Shapes {
    pub spheres: Vec<SphereShape>,
    pub boxes: Vec<BoxShape>,
    pub cylinders: Vec<CylinderShape>,
    pub cones: Vec<ConeShape>,
    pub planes: Vec<PlaneShape>,
    pub discs: Vec<DiscShape>,
    pub tori: Vec<TorusShape>,
    pub triangles: Vec<TriangleShape>,
    pub meshes: Vec<MeshShape>,
    pub polygons: Vec<PolygonShape>,
    pub quadrics: Vec<QuadricShape>,
    pub polys: Vec<PolyShape>,
    pub blobs: Vec<BlobShape>,
    pub lathes: Vec<LatheShape>,
    pub sors: Vec<SorShape>,
    pub prisms: Vec<PrismShape>,
    pub superellipsoids: Vec<SuperellipsoidShape>,
    pub height_fields: Vec<HeightFieldShape>,
    pub glyphs: Vec<GlyphShape>,
    pub ovi: Vec<OvusShape>,
    pub sphere_sweeps: Vec<SphereSweepShape>,
    pub julias: Vec<JuliaShape>,
    pub isosurfaces: Vec<IsosurfaceShape>,
    pub parametrics: Vec<ParametricShape>,
    pub hairs: Vec<HairShape>,
}
