//! One shape into its table: folds transforms in where POV-Ray does, and finds the box around its surface.

use super::NONE;
use super::geometry::PrimKind;
use super::shape::implicit::container_bounds;
use super::shape::mesh::patch_mesh;
use super::shape::simple::frame_along;
use super::shape::{
    BlobShape, BoxShape, ConeShape, CylinderShape, DiscShape, GlyphShape, HairShape, HeightFieldShape, IsosurfaceShape, JuliaShape,
    LatheShape, MeshShape, OvusShape, ParametricShape, PlaneShape, PolyShape, PolygonShape, PrismShape, QuadricShape, Shapes, SorShape,
    SphereShape, SphereSweepShape, SuperellipsoidShape, TorusShape, TreeStore, TriangleShape,
};
use super::tables::TransformTable;
use super::texture::TextureBuilder;
use crate::accel::AccelKind;
use crate::math::{BOUND_HUGE, Bounds, DMat3, DVec3, EPSILON, Transform};
use crate::scene::shape::Glyph;
use crate::scene::{Mesh, Object, Shape};
use std::collections::HashMap;
use std::sync::Arc;

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

/// Why a shape gives no primitive: nothing is there, it is degenerate.
pub(super) struct Degenerate;

/// Adds an element to a table and gives its index.
pub(super) fn push<T>(table: &mut Vec<T>, item: T) -> u32 {
    table.push(item);
    table.len() as u32 - 1
}

/// Everything that leaves share.
pub(super) struct LeafTables {
    pub shapes: Shapes,
    /// Meshes by address: instances share one. The mesh keeps the address taken.
    meshes: HashMap<*const Mesh, u32>,
    accel: AccelKind,
    trees: Option<Arc<TreeStore>>,
}

impl LeafTables {
    /// Empty; meshes get trees of kind `accel`, from `trees` where they are.
    pub fn new(accel: AccelKind, trees: Option<Arc<TreeStore>>) -> Self {
        Self { shapes: Shapes::default(), meshes: HashMap::new(), accel, trees }
    }

    /// The table entry of a mesh; `None` when it has no faces.
    fn mesh(&mut self, mesh: &Arc<Mesh>, textures: &mut TextureBuilder) -> Option<u32> {
        if let Some(ix) = self.meshes.get(&Arc::as_ptr(mesh)) {
            return Some(*ix);
        }
        let covers = mesh.textures.iter().map(|t| textures.texture(t)).collect();
        let shape = MeshShape::new(mesh.clone(), covers, self.accel)?;
        let shape = match &self.trees {
            Some(store) => store.adopt(shape),
            None => shape,
        };
        let ix = push(&mut self.shapes.meshes, shape);
        self.meshes.insert(Arc::as_ptr(mesh), ix);
        Some(ix)
    }
}

/// One letter of a text.
pub(super) fn add_glyph(glyph: &Glyph, depth: f64, to_world: &Transform, tables: &mut LeafTables) -> Option<Leaf> {
    let shape = GlyphShape::new(glyph, depth)?;
    let transform = Transform::translation(glyph.offset).then(to_world);
    let bounds = padded(shape.bounds().transformed(&transform));
    let shape_ix = push(&mut tables.shapes.glyphs, shape);
    Some(Leaf { kind: PrimKind::Glyph, shape_ix, transform, surface_bounds: bounds, inside_bounds: bounds, solid: true })
}

/// Puts the shape of `object` (a leaf) into its table; `to_world` maps shape space to the world.
pub(super) fn add_leaf(
    object: &Object,
    to_world: &Transform,
    tables: &mut LeafTables,
    transforms: &mut TransformTable,
    textures: &mut TextureBuilder,
) -> Result<Leaf, Degenerate> {
    let finite = |kind, shape_ix, transform: Transform, bounds: Bounds| {
        let bounds = padded(bounds);
        Ok(Leaf { kind, shape_ix, transform, surface_bounds: bounds, inside_bounds: bounds, solid: true })
    };
    // Shapes that stay in their own space, with a box there.
    let placed = |kind, shape_ix, bounds: Bounds| finite(kind, shape_ix, *to_world, bounds.transformed(to_world));
    let sturm = object.flags.sturm;
    let found = |o: Option<u32>| o.ok_or(Degenerate);
    if let Shape::Mesh(mesh) = &object.shape {
        let ix = found(tables.mesh(mesh, textures))?;
        let bounds = padded(tables.shapes.meshes[ix as usize].world_bounds(to_world));
        let solid = mesh.inside_vector.is_some();
        let inside_bounds = if solid { bounds } else { Bounds::EMPTY };
        return Ok(Leaf { kind: PrimKind::Mesh, shape_ix: ix, transform: *to_world, surface_bounds: bounds, inside_bounds, solid });
    }
    let accel = tables.accel;
    if let Shape::Curves(curves) = &object.shape {
        let hair = HairShape::new(curves, accel).ok_or(Degenerate)?;
        let bounds = padded(hair.bounds.transformed(to_world));
        let shape_ix = push(&mut tables.shapes.hairs, hair);
        let (surface_bounds, inside_bounds) = (bounds, Bounds::EMPTY);
        return Ok(Leaf { kind: PrimKind::Hair, shape_ix, transform: *to_world, surface_bounds, inside_bounds, solid: false });
    }
    let shapes = &mut tables.shapes;
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
            let frame = frame_along(*a, axis, radius.abs(), len).ok_or(Degenerate)?;
            let bounds = disc_bounds(*a, axis, *radius, to_world).union(disc_bounds(*b, axis, *radius, to_world));
            finite(PrimKind::Cylinder, push(&mut shapes.cylinders, CylinderShape { open: *open }), frame.then(to_world), bounds)
        }
        Shape::Cone { a, radius_a, b, radius_b, open } => {
            let (mut big, mut small) = ((*a, *radius_a), (*b, *radius_b));
            let (axis, _) = axis_of(*a, *b)?;
            let bounds = disc_bounds(*a, axis, *radius_a, to_world).union(disc_bounds(*b, axis, *radius_b, to_world));
            if (radius_a - radius_b).abs() < EPSILON {
                let (axis, len) = axis_of(*a, *b)?;
                let frame = frame_along(*a, axis, radius_a.abs(), len).ok_or(Degenerate)?;
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
            let frame = frame_along(small.0 - to_apex * axis, axis, big.1, whole).ok_or(Degenerate)?;
            let shape = ConeShape { low: to_apex / whole, open: *open };
            finite(PrimKind::Cone, push(&mut shapes.cones, shape), frame.then(to_world), bounds)
        }
        Shape::Plane { normal, distance } => {
            let n = to_world.normal(*normal);
            let len = n.length();
            if len.is_nan() || len == 0.0 {
                return Err(Degenerate);
            }
            let n = n / len;
            let d = n.dot(to_world.point(*normal * *distance));
            let shape_ix = push(&mut shapes.planes, PlaneShape { normal: n, distance: d });
            let (surface_bounds, inside_bounds) = plane_bounds(n, d);
            Ok(Leaf { kind: PrimKind::Plane, shape_ix, transform: Transform::IDENTITY, surface_bounds, inside_bounds, solid: true })
        }
        Shape::Disc { center, normal, radius, hole } => {
            let axis = normal.try_normalize().ok_or(Degenerate)?;
            let frame = frame_along(*center, axis, 1.0, 1.0).ok_or(Degenerate)?;
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
            let mut world = vertices.map(|v| to_world.point(v));
            if normals.is_none() && !to_world.is_identity() {
                world = TriangleShape::reordered(world);
            }
            let shape = TriangleShape::new(world, normals.map(|ns| ns.map(|n| to_world.normal(n).normalize()))).ok_or(Degenerate)?;
            let bounds = padded(Bounds::from_points(world));
            let shape_ix = push(&mut shapes.triangles, shape);
            let (kind, transform) = (PrimKind::Triangle, Transform::IDENTITY);
            Ok(Leaf { kind, shape_ix, transform, surface_bounds: bounds, inside_bounds: Bounds::EMPTY, solid: false })
        }
        Shape::Polygon { points } => {
            let shape = PolygonShape::new(points).ok_or(Degenerate)?;
            let bounds = padded(Bounds::from_points(points.iter().map(|p| to_world.point(*p))));
            let shape_ix = push(&mut shapes.polygons, shape);
            let (kind, transform) = (PrimKind::Polygon, *to_world);
            Ok(Leaf { kind, shape_ix, transform, surface_bounds: bounds, inside_bounds: Bounds::EMPTY, solid: false })
        }
        Shape::BicubicPatch { points, uvs, flatness, u_steps, v_steps, .. } => {
            // Flatness is measured in the world.
            let points = points.map(|row| row.map(|p| to_world.point(p)));
            let mesh = patch_mesh(&points, uvs, *flatness, *u_steps, *v_steps);
            let shape = MeshShape::new(Arc::new(mesh), Vec::new(), accel).ok_or(Degenerate)?;
            let bounds = padded(shape.bounds);
            let shape_ix = push(&mut shapes.meshes, shape);
            let (kind, transform) = (PrimKind::BicubicPatch, Transform::IDENTITY);
            Ok(Leaf { kind, shape_ix, transform, surface_bounds: bounds, inside_bounds: Bounds::EMPTY, solid: false })
        }
        Shape::Quadric { coefficients } => {
            let shape = QuadricShape { c: *coefficients };
            let bounds = shape.bounds();
            let bounds = padded(bounds.transformed(to_world));
            let shape_ix = push(&mut shapes.quadrics, shape);
            let (kind, transform) = (PrimKind::Quadric, *to_world);
            Ok(Leaf { kind, shape_ix, transform, surface_bounds: bounds, inside_bounds: bounds, solid: true })
        }
        Shape::Poly { order, coefficients } => {
            let shape = PolyShape::new(*order, coefficients, sturm).ok_or(Degenerate)?;
            let bounds = shape.bounds();
            placed(PrimKind::Poly, push(&mut shapes.polys, shape), bounds)
        }
        Shape::Blob { threshold, components } => {
            let covers = components.iter().map(|c| c.texture.as_ref().map_or(NONE, |t| textures.texture(t))).collect();
            let shape = BlobShape::new(*threshold, components, covers, sturm).ok_or(Degenerate)?;
            let bounds = shape.bounds;
            placed(PrimKind::Blob, push(&mut shapes.blobs, shape), bounds)
        }
        Shape::Lathe { kind, points } => {
            let shape = LatheShape::new(*kind, points, sturm).ok_or(Degenerate)?;
            let bounds = revolved(shape.radius, shape.low, shape.high, to_world);
            finite(PrimKind::Lathe, push(&mut shapes.lathes, shape), *to_world, bounds)
        }
        Shape::Sor { points, open } => {
            let shape = SorShape::new(points, *open, sturm).ok_or(Degenerate)?;
            let (low, high) = shape.heights();
            let bounds = revolved(shape.radius, low, high, to_world);
            finite(PrimKind::Sor, push(&mut shapes.sors, shape), *to_world, bounds)
        }
        Shape::Prism { .. } => {
            let shape = PrismShape::new(&object.shape).ok_or(Degenerate)?;
            let bounds = shape.bounds();
            placed(PrimKind::Prism, push(&mut shapes.prisms, shape), bounds)
        }
        Shape::Superellipsoid { e, n } => {
            let shape = SuperellipsoidShape { xy_power: 2.0 / e, z_power: 2.0 / n };
            let reach = DVec3::splat(1.0001);
            placed(PrimKind::Superellipsoid, push(&mut shapes.superellipsoids, shape), Bounds { min: -reach, max: reach })
        }
        Shape::HeightField { heights, water_level, smooth } => {
            let shape = HeightFieldShape::new(heights.clone(), *water_level, *smooth).ok_or(Degenerate)?;
            let transform = shape.frame().then(to_world);
            let surface_bounds = padded(shape.bounds().transformed(&transform));
            // Inside goes down without limit.
            let down = -transform.vector(DVec3::Y).normalize_or_zero() * BOUND_HUGE;
            let below = Bounds { min: surface_bounds.min + down, max: surface_bounds.max + down };
            let inside_bounds = surface_bounds.union(below);
            let shape_ix = push(&mut shapes.height_fields, shape);
            Ok(Leaf { kind: PrimKind::HeightField, shape_ix, transform, surface_bounds, inside_bounds, solid: true })
        }
        Shape::Ovus { bottom, top } => {
            let shape = OvusShape::new(*bottom, *top).ok_or(Degenerate)?;
            placed(PrimKind::Ovus, push(&mut shapes.ovi, shape), shape.bounds())
        }
        Shape::SphereSweep { kind, spheres, .. } => {
            let shape = SphereSweepShape::new(*kind, spheres).ok_or(Degenerate)?;
            let bounds = shape.bounds;
            placed(PrimKind::SphereSweep, push(&mut shapes.sphere_sweeps, shape), bounds)
        }
        Shape::JuliaFractal { c, hypercomplex, function, max_iteration, precision, slice, slice_distance } => {
            let shape = JuliaShape::new(*c, *hypercomplex, *function, *max_iteration, *precision, *slice, *slice_distance);
            let shape = shape.ok_or(Degenerate)?;
            let r = DVec3::splat(shape.radius);
            placed(PrimKind::JuliaFractal, push(&mut shapes.julias, shape), Bounds { min: -r, max: r })
        }
        Shape::Isosurface { function, container, threshold, accuracy, max_gradient, evaluate, open, max_trace } => {
            let function = textures.function(function);
            let shape = IsosurfaceShape {
                function,
                container: *container,
                threshold: *threshold,
                accuracy: *accuracy,
                max_gradient: *max_gradient,
                evaluate: *evaluate,
                open: *open,
                max_trace: *max_trace,
            };
            placed(PrimKind::Isosurface, push(&mut shapes.isosurfaces, shape), container_bounds(container))
        }
        Shape::Parametric { functions, min, max, container, accuracy, max_gradient, .. } => {
            let (functions, container) = (functions.each_ref().map(|f| textures.function(f)), *container);
            let shape = ParametricShape { functions, min: *min, max: *max, container, accuracy: *accuracy, max_gradient: *max_gradient };
            let leaf = placed(PrimKind::Parametric, push(&mut shapes.parametrics, shape), container_bounds(&container))?;
            Ok(Leaf { inside_bounds: Bounds::EMPTY, solid: false, ..leaf })
        }
        // No primitive of its own, or one that was made above.
        Shape::Csg { .. }
        | Shape::Group { .. }
        | Shape::LightGroup { .. }
        | Shape::Light(_)
        | Shape::Text { .. }
        | Shape::Mesh(_)
        | Shape::Curves(_) => Err(Degenerate),
    }
}

/// A box grown by what roundings of its making may have lost, axis by axis; empty boxes stay.
pub(super) fn padded(b: Bounds) -> Bounds {
    if b.is_empty() {
        return b;
    }
    let pad = pad_of(&b);
    Bounds { min: b.min - pad, max: b.max + pad }.intersection(Bounds::UNBOUNDED)
}

pub(super) fn pad_of(b: &Bounds) -> DVec3 {
    let reach = b.min.abs().max(b.max.abs());
    // Axes without end say nothing about the roundings along the others.
    let finite = (0..3).map(|k| reach[k]).filter(|r| *r < 1e9).fold(0.0, f64::max);
    (reach.max(DVec3::splat(finite)) + DVec3::ONE) * 1e-7
}

/// World box of a cylinder about y.
fn revolved(radius: f64, low: f64, high: f64, t: &Transform) -> Bounds {
    let disc = |y| disc_bounds(DVec3::Y * y, DVec3::Y, radius, t);
    disc(low).union(disc(high))
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
fn axis_of(a: DVec3, b: DVec3) -> Result<(DVec3, f64), Degenerate> {
    let len = (b - a).length();
    if len.is_nan() || len == 0.0 { Err(Degenerate) } else { Ok(((b - a) / len, len)) }
}

/// The factor by which the transform scales all lengths, if there is one.
pub(super) fn uniform_scale(t: &Transform) -> Option<f64> {
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
            // Beyond all bounds, or nowhere at all.
            if !(at.abs() + pad < BOUND_HUGE) {
                continue;
            }
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
