//! Rays against shapes in their own space: one file a family. Each shape pushes its hits; what becomes of them (nearest, any,
//! clip programs) is the sink's business (`kernel/traverse`). Twins: `shaders/shared/intersect_*.wesl`.
//! Source: spec/objects.md; tolerances are POV-Ray's and decide pixels.

pub mod algebraic;
pub mod blob;
pub mod curves;
pub mod hair;
pub mod height_field;
pub mod implicit;
pub mod julia;
pub mod mesh;
pub mod mesh_packet;
pub mod quadrics;
pub mod simple;
pub mod sweep;
pub mod torus;
pub mod triangle;

use super::function::call_function;
use crate::compile::CompiledScene;
use crate::compile::geometry::{Geometry, Prim, PrimKind};
use crate::math::{Bounds, DVec2, DVec3, EPSILON, Transform};

/// Where on a shape a hit lies, kept until the normal is wanted. What the numbers mean is the shape's business.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Part {
    /// Face, side or segment.
    pub face: u32,
    /// Place on it.
    pub a: f64,
    /// Place on it.
    pub b: f64,
}

impl Part {
    /// A numbered side.
    pub fn side(face: u32) -> Self {
        Self { face, a: 0.0, b: 0.0 }
    }
}

/// Takes the hits of a shape.
pub trait HitSink {
    /// A hit at depth `t` of the local ray.
    fn push(&mut self, t: f64, part: Part);
    /// Local depth beyond which hits are of no use; may shrink with every push.
    fn far(&self) -> f64;
    /// Local depths between which hits may stand: those of the primitive's box, where there is one.
    fn within(&self) -> Option<(f64, f64)> {
        None
    }

    /// The ray runs below a surface that light scatters under: shapes offer hits however near its start they are.
    fn is_below_surface(&self) -> bool {
        false
    }

    /// When the ray runs, 0..=1 over the shutter; below 0 for shapes at rest.
    fn time(&self) -> f64 {
        -1.0
    }
}

/// A ray in a shape's space; `dir` is unit but for boxes.
#[derive(Clone, Copy, Debug)]
pub struct LocalRay {
    /// Start.
    pub origin: DVec3,
    /// Unit, but for boxes.
    pub dir: DVec3,
    /// Local length of a world unit along the ray.
    pub scale: f64,
}

impl LocalRay {
    /// The point at depth `t`.
    #[inline]
    pub fn at(&self, t: f64) -> DVec3 {
        self.origin + t * self.dir
    }
}

/// A function of space.
fn field(scene: &CompiledScene, function: u32) -> impl Fn(DVec3) -> f64 {
    move |p| call_function(scene, function, &p.to_array())
}

/// Three functions of (u, v).
fn chart(scene: &CompiledScene, functions: [u32; 3]) -> impl Fn(DVec2) -> DVec3 {
    move |uv| DVec3::from_array(functions.map(|f| call_function(scene, f, &uv.to_array())))
}

/// Pushes all hits of the shape of `prim` that it reports.
#[inline]
pub fn intersect_shape(scene: &CompiledScene, prim: &Prim, ray: &LocalRay, sink: &mut impl HitSink) {
    let ix = prim.shape_ix as usize;
    let s = &scene.geometry.shapes;
    match prim.kind {
        PrimKind::Sphere => simple::intersect_sphere(&s.spheres[ix], ray, sink),
        PrimKind::Box => simple::intersect_box(&s.boxes[ix], ray, sink),
        PrimKind::Plane => simple::intersect_plane(&s.planes[ix], ray, sink),
        PrimKind::Cylinder => quadrics::intersect_cylinder(&s.cylinders[ix], ray, sink),
        PrimKind::Cone => quadrics::intersect_cone(&s.cones[ix], ray, sink),
        PrimKind::Triangle => triangle::intersect_triangle(&s.triangles[ix], ray, sink),
        PrimKind::Mesh => mesh::intersect_mesh(&s.meshes[ix], ray, sink),
        _ => intersect_rarer(scene, prim, ray, sink),
    }
}

/// The shapes whose tests cost more than a call. Inlined they would give all tests their stack frame, of over 4 kB.
#[inline(never)]
fn intersect_rarer(scene: &CompiledScene, prim: &Prim, ray: &LocalRay, sink: &mut impl HitSink) {
    let ix = prim.shape_ix as usize;
    let s = &scene.geometry.shapes;
    let all = || prim.wants_all_hits();
    match prim.kind {
        PrimKind::Sphere => simple::intersect_sphere(&s.spheres[ix], ray, sink),
        PrimKind::Box => simple::intersect_box(&s.boxes[ix], ray, sink),
        PrimKind::Plane => simple::intersect_plane(&s.planes[ix], ray, sink),
        PrimKind::Disc => simple::intersect_disc(&s.discs[ix], ray, sink),
        PrimKind::Cylinder => quadrics::intersect_cylinder(&s.cylinders[ix], ray, sink),
        PrimKind::Cone => quadrics::intersect_cone(&s.cones[ix], ray, sink),
        PrimKind::Torus => torus::intersect_torus(&s.tori[ix], ray, sink),
        PrimKind::Triangle => triangle::intersect_triangle(&s.triangles[ix], ray, sink),
        PrimKind::Mesh | PrimKind::BicubicPatch => mesh::intersect_mesh(&s.meshes[ix], ray, sink),
        PrimKind::Polygon => curves::intersect_polygon(&s.polygons[ix], ray, sink),
        PrimKind::Quadric => algebraic::intersect_quadric(&s.quadrics[ix], ray, sink),
        PrimKind::Poly => algebraic::intersect_poly(&s.polys[ix], ray, sink),
        PrimKind::Blob => blob::intersect_blob(&s.blobs[ix], ray, all(), sink),
        PrimKind::Lathe => curves::intersect_lathe(&s.lathes[ix], ray, sink),
        PrimKind::Sor => curves::intersect_sor(&s.sors[ix], ray, sink),
        PrimKind::Prism => curves::intersect_prism(&s.prisms[ix], ray, sink),
        PrimKind::Superellipsoid => algebraic::intersect_superellipsoid(&s.superellipsoids[ix], ray, all(), sink),
        PrimKind::HeightField => height_field::intersect_height_field(&s.height_fields[ix], ray, all(), sink),
        PrimKind::Glyph => curves::intersect_glyph(&s.glyphs[ix], ray, sink),
        PrimKind::Hair => hair::intersect_hair(&s.hairs[ix], ray, sink),
        PrimKind::Ovus => sweep::intersect_ovus(&s.ovi[ix], ray, sink),
        PrimKind::SphereSweep => sweep::intersect_sphere_sweep(&s.sphere_sweeps[ix], ray, sink),
        PrimKind::JuliaFractal => julia::intersect_julia(&s.julias[ix], ray, all(), sink),
        PrimKind::Isosurface => {
            let shape = &s.isosurfaces[ix];
            implicit::intersect_isosurface(shape, ray, &field(scene, shape.function), sink);
        }
        PrimKind::Parametric => {
            let shape = &s.parametrics[ix];
            implicit::intersect_parametric(shape, ray, &chart(scene, shape.functions), sink);
        }
    }
}

/// Whether a point of shape space is inside; `inverted` chooses POV-Ray's rule for points on the surface.
#[inline]
pub fn inside_shape(scene: &CompiledScene, prim: &Prim, p: DVec3, inverted: bool) -> bool {
    let ix = prim.shape_ix as usize;
    let s = &scene.geometry.shapes;
    match prim.kind {
        PrimKind::Sphere => return simple::inside_sphere(&s.spheres[ix], p, inverted),
        PrimKind::Plane => return simple::inside_plane(&s.planes[ix], p, inverted),
        _ => {}
    }
    inverted
        != match prim.kind {
            PrimKind::Box => simple::inside_box(&s.boxes[ix], p),
            PrimKind::Disc => p.z < 0.0,
            PrimKind::Cylinder => quadrics::inside_cylinder(&s.cylinders[ix], p),
            PrimKind::Cone => quadrics::inside_cone(&s.cones[ix], p),
            PrimKind::Torus => torus::inside_torus(&s.tori[ix], p),
            PrimKind::Mesh => mesh::inside_mesh(&s.meshes[ix], p),
            PrimKind::Quadric => algebraic::quadric_value(&s.quadrics[ix], p) <= 0.0,
            PrimKind::Poly => algebraic::poly_value(&s.polys[ix], p) < 1e-4,
            PrimKind::Blob => blob::inside_blob(&s.blobs[ix], p),
            PrimKind::Lathe => curves::inside_lathe(&s.lathes[ix], p),
            PrimKind::Sor => curves::inside_sor(&s.sors[ix], p),
            PrimKind::Prism => curves::inside_prism(&s.prisms[ix], p),
            PrimKind::Superellipsoid => algebraic::superellipsoid_value(&s.superellipsoids[ix], p) < EPSILON,
            PrimKind::HeightField => height_field::inside_height_field(&s.height_fields[ix], p),
            PrimKind::Glyph => curves::inside_glyph(&s.glyphs[ix], p),
            PrimKind::Ovus => sweep::inside_ovus(&s.ovi[ix], p),
            PrimKind::SphereSweep => sweep::inside_sphere_sweep(&s.sphere_sweeps[ix], p),
            PrimKind::JuliaFractal => julia::inside_julia(&s.julias[ix], p),
            PrimKind::Isosurface => implicit::inside_isosurface(&s.isosurfaces[ix], p, &field(scene, s.isosurfaces[ix].function)),
            // Surfaces without an inside; spheres and planes went before.
            PrimKind::Triangle
            | PrimKind::Polygon
            | PrimKind::BicubicPatch
            | PrimKind::Parametric
            | PrimKind::Sphere
            | PrimKind::Plane
            | PrimKind::Hair => false,
        }
}

/// The normal of a hit in shape space, not unit, not inverted, for the shapes that tell it at once.
#[inline(always)]
pub fn plain_normal(g: &Geometry, prim: &Prim, p: DVec3, part: &Part) -> Option<DVec3> {
    let ix = prim.shape_ix as usize;
    let s = &g.shapes;
    Some(match prim.kind {
        PrimKind::Sphere => (p - s.spheres[ix].center) / s.spheres[ix].radius,
        PrimKind::Box => simple::box_normal(part.face),
        PrimKind::Plane => s.planes[ix].normal,
        PrimKind::Disc => DVec3::Z,
        PrimKind::Cylinder => quadrics::cylinder_normal(p, part.face),
        PrimKind::Cone => quadrics::cone_normal(p, part.face),
        PrimKind::Triangle => triangle::triangle_normal(&s.triangles[ix], part),
        _ => return None,
    })
}

/// The normal of a hit, in the world unless `transform` is `None`; not unit, not inverted. `p` is in shape space.
pub fn world_normal(scene: &CompiledScene, prim: &Prim, transform: Option<&Transform>, p: DVec3, part: &Part, time: f64) -> DVec3 {
    if prim.kind == PrimKind::HeightField {
        let shape = &scene.geometry.shapes.height_fields[prim.shape_ix as usize];
        return height_field::height_field_normal(shape, transform.unwrap_or(&Transform::IDENTITY), part);
    }
    let n = shape_normal(scene, prim, p, part, time);
    transform.map_or(n, |t| t.normal(n))
}

/// The normal of a hit in shape space, not unit, not inverted.
fn shape_normal(scene: &CompiledScene, prim: &Prim, p: DVec3, part: &Part, time: f64) -> DVec3 {
    if let Some(n) = plain_normal(&scene.geometry, prim, p, part) {
        return n;
    }
    let ix = prim.shape_ix as usize;
    let s = &scene.geometry.shapes;
    match prim.kind {
        PrimKind::Torus => torus::torus_normal(&s.tori[ix], p),
        PrimKind::Mesh | PrimKind::BicubicPatch => mesh::mesh_normal(&s.meshes[ix], part, time),
        PrimKind::Polygon => s.polygons[ix].normal,
        PrimKind::Quadric => algebraic::quadric_normal(&s.quadrics[ix], p),
        PrimKind::Poly => algebraic::poly_normal(&s.polys[ix], p),
        PrimKind::Blob => blob::blob_normal(&s.blobs[ix], p),
        PrimKind::Lathe => curves::lathe_normal(&s.lathes[ix], p, part),
        PrimKind::Sor => curves::sor_normal(&s.sors[ix], p, part),
        PrimKind::Prism => curves::prism_normal(&s.prisms[ix], part),
        PrimKind::Superellipsoid => algebraic::superellipsoid_normal(&s.superellipsoids[ix], p),
        PrimKind::Glyph => curves::glyph_normal(&s.glyphs[ix], part),
        PrimKind::Hair => hair::hair_normal(&s.hairs[ix], part),
        PrimKind::Ovus => sweep::ovus_normal(&s.ovi[ix], p, part),
        PrimKind::SphereSweep => sweep::sphere_sweep_normal(&s.sphere_sweeps[ix], p, part),
        PrimKind::JuliaFractal => julia::julia_normal(&s.julias[ix], p),
        PrimKind::Isosurface => implicit::isosurface_normal(&s.isosurfaces[ix], p, part, &field(scene, s.isosurfaces[ix].function)),
        PrimKind::Parametric => implicit::parametric_normal(&s.parametrics[ix], part, &chart(scene, s.parametrics[ix].functions)),
        // `world_normal` has it; the others went before.
        PrimKind::HeightField
        | PrimKind::Sphere
        | PrimKind::Box
        | PrimKind::Plane
        | PrimKind::Disc
        | PrimKind::Cylinder
        | PrimKind::Cone
        | PrimKind::Triangle => DVec3::Y,
    }
}

/// Texture coordinates of a hit; shapes without their own give the world point's x and y.
pub fn shape_uv(g: &Geometry, prim: &Prim, p: DVec3, world: DVec3, part: &Part) -> DVec2 {
    let ix = prim.shape_ix as usize;
    let s = &g.shapes;
    match prim.kind {
        PrimKind::Sphere => {
            let sphere = &s.spheres[ix];
            let t = &g.transforms[sphere.uv_transform_ix as usize];
            sphere_uv(t.inverse_point(world) - sphere.uv_center)
        }
        PrimKind::Box => simple::box_uv(&s.boxes[ix], p, part.face),
        PrimKind::Torus => torus::torus_uv(&s.tori[ix], p),
        PrimKind::Mesh | PrimKind::BicubicPatch => mesh::mesh_uv(&s.meshes[ix], part),
        PrimKind::Lathe => curves::lathe_uv(&s.lathes[ix], p, part),
        PrimKind::Sor => curves::sor_uv(&s.sors[ix], p, part),
        PrimKind::Ovus => sweep::ovus_uv(&s.ovi[ix], p),
        PrimKind::Parametric => DVec2::new(part.a, part.b),
        _ => DVec2::new(world.x, world.y),
    }
}

/// Whether a ray meets a box ahead of its start.
#[inline]
pub(crate) fn meets_box(b: &Bounds, ray: &LocalRay) -> bool {
    let (mut t0, mut t1) = (0.0f64, f64::INFINITY);
    for k in 0..3 {
        let (o, d) = (ray.origin[k], ray.dir[k]);
        if d.abs() < EPSILON {
            if o < b.min[k] || o > b.max[k] {
                return false;
            }
            continue;
        }
        let (x, y) = ((b.min[k] - o) / d, (b.max[k] - o) / d);
        t0 = t0.max(x.min(y));
        t1 = t1.min(x.max(y));
    }
    t0 <= t1
}

/// u: turns from +x towards +z; v: 0 at the south pole, 1 at the north pole. `d` need not be unit.
pub fn sphere_uv(d: DVec3) -> DVec2 {
    let d = d.normalize_or_zero();
    DVec2::new(turns_about_y(d.x, d.z), 0.5 + d.y.clamp(-1.0, 1.0).asin() / std::f64::consts::PI)
}

/// 0..1 from +x towards +z; 0 on the axis.
pub fn turns_about_y(x: f64, z: f64) -> f64 {
    let len = (x * x + z * z).sqrt();
    if len <= crate::math::EPSILON {
        return 0.0;
    }
    let angle = (x / len).clamp(-1.0, 1.0).acos();
    (if z < 0.0 { std::f64::consts::TAU - angle } else { angle }) / std::f64::consts::TAU
}
