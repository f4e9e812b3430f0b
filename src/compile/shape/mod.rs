//! What each kind of shape needs to be hit: one plain struct a kind, made once from the scene's numbers.
//! Nothing here traces a ray; `kernel/intersect` does.

pub mod simple;

pub use simple::{BoxShape, ConeShape, CylinderShape, DiscShape, PlaneShape, SphereShape, TorusShape, TriangleShape};

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
}
