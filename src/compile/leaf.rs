//! One shape into its table: folds transforms in where POV-Ray does, and finds the box around its surface.

use super::geometry::PrimKind;
use super::shape::simple::frame_along;
use super::shape::{BoxShape, ConeShape, CylinderShape, DiscShape, PlaneShape, Shapes, SphereShape, TorusShape, TriangleShape};
use super::tables::TransformTable;
use crate::math::{BOUND_HUGE, Bounds, DMat3, DVec3, EPSILON, Transform};
use crate::scene::{Object, Shape};

/// A shape that stands in its table.
pub(super) struct Leaf {
    pub kind: PrimKind,
    pub shape_ix: u32,
    /// World from shape space.
    pub transform: Transform,
    /// World box of the surface.
    pub surface_bounds: Bounds,
    /// World box of the inside; unbounded for half spaces.
    pub inside_bounds: Bounds,
    /// Has an inside.
    pub solid: bool,
}

/// Why a shape gives no primitive.
pub(super) enum NoLeaf {
    /// Not rendered yet; the name of the shape.
    Unsupported(&'static str),
    /// Nothing there (degenerate).
    Nothing,
}

/// Adds an element to a table and gives its index.
pub(super) fn push<T>(table: &mut Vec<T>, item: T) -> u32 {
    table.push(item);
    table.len() as u32 - 1
}

/// Puts the shape of `object` (a leaf) into its table; `to_world` maps shape space to the world.
pub(super) fn add_leaf(
    object: &Object,
    to_world: &Transform,
    shapes: &mut Shapes,
    transforms: &mut TransformTable,
) -> Result<Leaf, NoLeaf> {
    let finite = |kind, shape_ix, transform: Transform, bounds: Bounds| {
        let bounds = padded(bounds);
        Ok(Leaf { kind, shape_ix, transform, surface_bounds: bounds, inside_bounds: bounds, solid: true })
    };
    match &object.shape {
        Shape::Sphere { center, radius } => {
            let (c, r) = (to_world.point(*center), radius.abs());
            let uv_transform_ix = transforms.add(to_world);
            if let Some(scale) = uniform_scale(to_world) {
                let r = r * scale;
                let shape = SphereShape { center: c, radius: radius * scale, uv_transform_ix, uv_center: *center };
                let bounds = Bounds { min: c - DVec3::splat(r), max: c + DVec3::splat(r) };
                return finite(PrimKind::Sphere, push(&mut shapes.spheres, shape), Transform::IDENTITY, bounds);
            }
            let shape = SphereShape { center: *center, radius: *radius, uv_transform_ix, uv_center: *center };
            let extent = row_lengths(to_world) * r;
            finite(PrimKind::Sphere, push(&mut shapes.spheres, shape), *to_world, Bounds { min: c - extent, max: c + extent })
        }
        Shape::Box { min, max } => {
            let b = Bounds::from_corners(*min, *max);
            if is_diagonal(to_world) {
                let b = Bounds::from_corners(to_world.point(b.min), to_world.point(b.max));
                return finite(PrimKind::Box, push(&mut shapes.boxes, BoxShape { min: b.min, max: b.max }), Transform::IDENTITY, b);
            }
            let world = b.transformed(to_world);
            finite(PrimKind::Box, push(&mut shapes.boxes, BoxShape { min: b.min, max: b.max }), *to_world, world)
        }
        Shape::Cylinder { a, b, radius, open } => {
            let (axis, len) = axis_of(*a, *b)?;
            let frame = frame_along(*a, axis, radius.abs(), len).ok_or(NoLeaf::Nothing)?;
            let bounds = disc_bounds(*a, axis, *radius, to_world).union(disc_bounds(*b, axis, *radius, to_world));
            finite(PrimKind::Cylinder, push(&mut shapes.cylinders, CylinderShape { open: *open }), frame.then(to_world), bounds)
        }
        Shape::Cone { a, radius_a, b, radius_b, open } => {
            let (mut big, mut small) = ((*a, *radius_a), (*b, *radius_b));
            let (axis, _) = axis_of(*a, *b)?;
            let bounds = disc_bounds(*a, axis, *radius_a, to_world).union(disc_bounds(*b, axis, *radius_b, to_world));
            if (radius_a - radius_b).abs() < EPSILON {
                let (axis, len) = axis_of(*a, *b)?;
                let frame = frame_along(*a, axis, radius_a.abs(), len).ok_or(NoLeaf::Nothing)?;
                return finite(
                    PrimKind::Cylinder,
                    push(&mut shapes.cylinders, CylinderShape { open: *open }),
                    frame.then(to_world),
                    bounds,
                );
            }
            if big.1 < small.1 {
                std::mem::swap(&mut big, &mut small);
            }
            // From the apex (radius 0) to the big end the cone is x² + y² = z² with the big end at z = 1.
            let (axis, len) = axis_of(small.0, big.0)?;
            let to_apex = small.1 * len / (big.1 - small.1);
            let whole = to_apex + len;
            let frame = frame_along(small.0 - to_apex * axis, axis, big.1, whole).ok_or(NoLeaf::Nothing)?;
            let shape = ConeShape { low: to_apex / whole, open: *open };
            finite(PrimKind::Cone, push(&mut shapes.cones, shape), frame.then(to_world), bounds)
        }
        Shape::Plane { normal, distance } => {
            let n = to_world.normal(*normal);
            let len = n.length();
            if len.is_nan() || len == 0.0 {
                return Err(NoLeaf::Nothing);
            }
            let n = n / len;
            let d = n.dot(to_world.point(*normal * *distance));
            let shape_ix = push(&mut shapes.planes, PlaneShape { normal: n, distance: d });
            let (surface_bounds, inside_bounds) = plane_bounds(n, d);
            Ok(Leaf { kind: PrimKind::Plane, shape_ix, transform: Transform::IDENTITY, surface_bounds, inside_bounds, solid: true })
        }
        Shape::Disc { center, normal, radius, hole } => {
            let axis = normal.try_normalize().ok_or(NoLeaf::Nothing)?;
            let frame = frame_along(*center, axis, 1.0, 1.0).ok_or(NoLeaf::Nothing)?;
            let shape_ix = push(&mut shapes.discs, DiscShape { radius_sq: radius * radius, hole_sq: hole * hole });
            let surface_bounds = padded(disc_bounds(*center, axis, *radius, to_world));
            let transform = frame.then(to_world);
            Ok(Leaf { kind: PrimKind::Disc, shape_ix, transform, surface_bounds, inside_bounds: Bounds::UNBOUNDED, solid: true })
        }
        Shape::Torus { major, minor } => {
            let shape = TorusShape { major: *major, minor: *minor, sturm: object.flags.sturm };
            let ring = disc_bounds(DVec3::ZERO, DVec3::Y, *major, to_world);
            let tube = row_lengths(to_world) * minor.abs();
            let bounds = Bounds { min: ring.min - tube, max: ring.max + tube };
            finite(PrimKind::Torus, push(&mut shapes.tori, shape), *to_world, bounds)
        }
        Shape::Triangle { vertices, normals } => {
            let world = vertices.map(|v| to_world.point(v));
            let shape = TriangleShape::new(world, normals.map(|ns| ns.map(|n| to_world.normal(n).normalize()))).ok_or(NoLeaf::Nothing)?;
            let bounds = padded(Bounds::from_points(world));
            let shape_ix = push(&mut shapes.triangles, shape);
            let (kind, transform) = (PrimKind::Triangle, Transform::IDENTITY);
            Ok(Leaf { kind, shape_ix, transform, surface_bounds: bounds, inside_bounds: Bounds::EMPTY, solid: false })
        }
        Shape::Csg { .. } | Shape::Group { .. } | Shape::LightGroup { .. } | Shape::Light(_) => Err(NoLeaf::Nothing),
        other => Err(NoLeaf::Unsupported(shape_name(other))),
    }
}

/// The shape's keyword.
pub(super) fn shape_name(shape: &Shape) -> &'static str {
    match shape {
        Shape::Sphere { .. } => "sphere",
        Shape::Box { .. } => "box",
        Shape::Cylinder { .. } => "cylinder",
        Shape::Cone { .. } => "cone",
        Shape::Plane { .. } => "plane",
        Shape::Disc { .. } => "disc",
        Shape::Torus { .. } => "torus",
        Shape::Triangle { .. } => "triangle",
        Shape::Mesh(_) => "mesh",
        Shape::Polygon { .. } => "polygon",
        Shape::BicubicPatch { .. } => "bicubic_patch",
        Shape::Quadric { .. } => "quadric",
        Shape::Poly { .. } => "poly",
        Shape::Blob { .. } => "blob",
        Shape::Lathe { .. } => "lathe",
        Shape::Sor { .. } => "sor",
        Shape::Prism { .. } => "prism",
        Shape::SphereSweep { .. } => "sphere_sweep",
        Shape::Superellipsoid { .. } => "superellipsoid",
        Shape::Ovus { .. } => "ovus",
        Shape::JuliaFractal { .. } => "julia_fractal",
        Shape::HeightField { .. } => "height_field",
        Shape::Isosurface { .. } => "isosurface",
        Shape::Parametric { .. } => "parametric",
        Shape::Text { .. } => "text",
        Shape::Csg { .. } => "csg",
        Shape::Group { .. } => "object",
        Shape::LightGroup { .. } => "light_group",
        Shape::Light(_) => "light_source",
    }
}

/// A box grown by what roundings of its making may have lost; unbounded and empty boxes stay.
pub(super) fn padded(b: Bounds) -> Bounds {
    if b.is_empty() || b.is_unbounded() {
        return b;
    }
    let pad = 1e-7 * (1.0 + b.min.abs().max(b.max.abs()).max_element());
    Bounds { min: b.min - DVec3::splat(pad), max: b.max + DVec3::splat(pad) }
}

/// Lengths of the matrix's rows: how far the unit sphere reaches along each axis.
fn row_lengths(t: &Transform) -> DVec3 {
    let m = t.forward.matrix3.transpose();
    DVec3::new(m.x_axis.length(), m.y_axis.length(), m.z_axis.length())
}

/// World box of the disc of `radius` around `center` with unit `normal`, both in shape space.
pub(super) fn disc_bounds(center: DVec3, normal: DVec3, radius: f64, t: &Transform) -> Bounds {
    let rows: DMat3 = t.forward.matrix3.transpose();
    let reach = |row: DVec3| radius.abs() * (row.length_squared() - row.dot(normal).powi(2)).max(0.0).sqrt();
    let e = DVec3::new(reach(rows.x_axis), reach(rows.y_axis), reach(rows.z_axis));
    let c = t.point(center);
    Bounds { min: c - e, max: c + e }
}

/// Unit direction and distance from `a` to `b`.
fn axis_of(a: DVec3, b: DVec3) -> Result<(DVec3, f64), NoLeaf> {
    let len = (b - a).length();
    if len.is_nan() || len == 0.0 { Err(NoLeaf::Nothing) } else { Ok(((b - a) / len, len)) }
}

/// The factor by which the transform scales all lengths, if there is one.
fn uniform_scale(t: &Transform) -> Option<f64> {
    let m = t.forward.matrix3;
    let (x, y, z) = (m.x_axis, m.y_axis, m.z_axis);
    let s = x.length_squared();
    let same = |v: f64| (v - s).abs() <= 1e-13 * s;
    let right = |v: f64| v.abs() <= 1e-13 * s;
    (same(y.length_squared()) && same(z.length_squared()) && right(x.dot(y)) && right(y.dot(z)) && right(z.dot(x))).then(|| s.sqrt())
}

/// Whether axes stay axes, exactly.
fn is_diagonal(t: &Transform) -> bool {
    let m = t.forward.matrix3;
    m.x_axis.y == 0.0 && m.x_axis.z == 0.0 && m.y_axis.x == 0.0 && m.y_axis.z == 0.0 && m.z_axis.x == 0.0 && m.z_axis.y == 0.0
}

/// Boxes of a plane's surface and of its half space: tight along an axis when the plane is square to it.
fn plane_bounds(n: DVec3, d: f64) -> (Bounds, Bounds) {
    let (mut surface, mut inside) = (Bounds::UNBOUNDED, Bounds::UNBOUNDED);
    for k in 0..3 {
        if (n[k].abs() - 1.0).abs() < EPSILON {
            let at = d * n[k].signum();
            let pad = 1e-7 * (1.0 + at.abs());
            surface.min[k] = at - pad;
            surface.max[k] = at + pad;
            if n[k] > 0.0 {
                inside.max[k] = at + pad;
            } else {
                inside.min[k] = at - pad;
            }
        }
    }
    debug_assert!(surface.max.max_element() <= BOUND_HUGE);
    (surface, inside)
}
