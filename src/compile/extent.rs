//! The boxes that `min_extent` and `max_extent` print: POV-Ray's own, looser than the boxes that rays are tested with.
//! Source: spec/objects.md, sections 13 and 15.

use super::leaf::{LeafTables, add_glyph, add_leaf, pad_of, uniform_scale};
use super::shape::implicit::container_bounds;
use super::tables::TransformTable;
use super::texture::TextureBuilder;
use crate::accel::AccelKind;
use crate::math::{Bounds, DVec2, DVec3, EPSILON, Transform};
use crate::scene::shape::{BlobKind, CurveKind, SweepKind};
use crate::scene::{Csg, Object, Shape};
use std::f64::consts::SQRT_2;

/// Half the thickness of boxes around flat shapes.
const FLAT: f64 = 1e-3;

/// POV-Ray's box of `object`, rounded to 32 bits as POV-Ray keeps it.
pub fn pov_extent(object: &Object) -> Bounds {
    pov_extent_in(object, &Transform::IDENTITY)
}

/// The same in an outer space.
pub(super) fn pov_extent_in(object: &Object, outer: &Transform) -> Bounds {
    let b = extent(object, &mut LeafTables::new(AccelKind::Brute, None)).transformed(outer);
    if b.is_empty() {
        return Bounds { min: DVec3::ZERO, max: DVec3::ZERO };
    }
    // A corner and the lengths are kept.
    let min = b.min.as_vec3();
    let size = (b.max - b.min).as_vec3();
    Bounds { min: min.as_dvec3(), max: (min + size).as_dvec3() }
}

fn volume(b: &Bounds) -> f64 {
    if b.is_empty() { 0.0 } else { b.size().element_product() }
}

/// POV-Ray's boxes have an end along all axes or along none.
fn all_or_none(b: Bounds) -> Bounds {
    if b.is_unbounded() { Bounds::UNBOUNDED } else { b }
}

/// The box in the parent's space: of the own space's box, so that turned CSG is bounded loosely.
fn extent(object: &Object, tables: &mut LeafTables) -> Bounds {
    let mut own = match &object.shape {
        Shape::Csg { op, children } => csg_extent(*op, children, tables).transformed(&object.transform),
        Shape::LightGroup { children, .. } => csg_extent(Csg::Union, children, tables).transformed(&object.transform),
        Shape::Group { child } => extent(child, tables).transformed(&object.transform),
        Shape::Light(_) => Bounds::EMPTY,
        Shape::Text { glyphs, depth } => {
            let letters = glyphs.iter().filter_map(|g| add_glyph(g, *depth, &object.transform, tables));
            letters.fold(Bounds::EMPTY, |b, l| b.union(unpadded(l.surface_bounds)))
        }
        _ => all_or_none(leaf_extent(object, tables)),
    };
    for list in [&object.clipped_by, &object.bounded_by] {
        let cut = list.iter().map(|c| extent(c, tables)).fold(Bounds::UNBOUNDED, Bounds::intersection);
        if volume(&cut) < volume(&own) {
            own = cut;
        }
    }
    own
}

fn csg_extent(op: Csg, children: &[Object], tables: &mut LeafTables) -> Bounds {
    match op {
        Csg::Union | Csg::Merge => {
            let boxes = children.iter().filter(|c| !matches!(c.shape, Shape::Light(_)));
            boxes.map(|c| extent(c, tables)).fold(Bounds::EMPTY, Bounds::union)
        }
        Csg::Difference => children.first().map_or(Bounds::EMPTY, |c| extent(c, tables)),
        Csg::Intersection => {
            let counts = |c: &&Object| match c.shape {
                Shape::HeightField { .. } | Shape::Light(_) => false,
                // An inverted plane is the plane the other way round.
                Shape::Plane { .. } => true,
                _ => !c.flags.inverse,
            };
            let solid = children.iter().filter(counts);
            all_or_none(solid.map(|c| cut_extent(c, tables)).fold(Bounds::UNBOUNDED, Bounds::intersection))
        }
    }
}

/// The box of a part of an intersection: planes that are square to an axis and quadrics cut it tightly.
fn cut_extent(object: &Object, tables: &mut LeafTables) -> Bounds {
    let t = &object.transform;
    match &object.shape {
        Shape::Plane { normal, distance } => {
            let n = t.normal(*normal).normalize_or_zero() * if object.flags.inverse { -1.0 } else { 1.0 };
            let d = n.dot(t.point(*normal * *distance));
            let mut b = Bounds::UNBOUNDED;
            for k in 0..3 {
                if (n[k].abs() - 1.0).abs() < EPSILON {
                    if n[k] > 0.0 { b.max[k] = d } else { b.min[k] = -d }
                }
            }
            b
        }
        Shape::Quadric { coefficients } if is_square(coefficients) => {
            super::shape::QuadricShape { c: *coefficients }.bounds().transformed(t)
        }
        _ => extent(object, tables),
    }
}

/// No mixed terms: the only quadrics that POV-Ray bounds.
fn is_square(c: &[f64; 10]) -> bool {
    c[3] == 0.0 && c[4] == 0.0 && c[5] == 0.0
}

fn leaf_extent(object: &Object, tables: &mut LeafTables) -> Bounds {
    let t = &object.transform;
    let around = |b: Bounds| b.transformed(t);
    let ball = |c: DVec3, r: f64| Bounds { min: c - DVec3::splat(r), max: c + DVec3::splat(r) };
    let hull = |points: &[DVec2]| {
        let x = points.iter().fold(0.0f64, |m, p| m.max(p.x.abs()));
        let (low, high) = points.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |m, p| (m.0.min(p.y), m.1.max(p.y)));
        Bounds { min: DVec3::new(-x, low, -x), max: DVec3::new(x, high, x) }
    };
    match &object.shape {
        Shape::Sphere { center, radius } => match uniform_scale(t) {
            Some(s) => ball(t.point(*center), radius.abs() * s),
            None => around(ball(*center, radius.abs())),
        },
        Shape::Box { min, max } => around(Bounds::from_corners(*min, *max)),
        Shape::Plane { .. } | Shape::Poly { .. } => Bounds::UNBOUNDED,
        Shape::Quadric { coefficients } if is_square(coefficients) => around(super::shape::QuadricShape { c: *coefficients }.bounds()),
        Shape::Quadric { .. } => Bounds::UNBOUNDED,
        Shape::Torus { major, minor } => {
            let r = DVec3::new(major + minor, *minor, major + minor);
            around(Bounds { min: -r, max: r })
        }
        // The box of the canonical shape, turned: looser than the shape.
        Shape::Disc { radius, .. } => canonical(object, *radius, -FLAT, FLAT, tables),
        Shape::Cylinder { .. } => canonical(object, 1.0, 0.0, 1.0, tables),
        Shape::Cone { radius_a, radius_b, .. } => {
            let same = (radius_a - radius_b).abs() < EPSILON;
            let low = if same { 0.0 } else { radius_a.min(*radius_b) / radius_a.max(*radius_b) };
            canonical(object, 1.0, low, 1.0, tables)
        }
        Shape::Curves(c) => {
            let most = c.radii.iter().fold(0.0f32, |a, b| a.max(*b));
            let b = Bounds::from_points(c.points.iter().map(|p| p.as_dvec3()));
            around(Bounds { min: b.min - f64::from(most), max: b.max + f64::from(most) })
        }
        Shape::Mesh(mesh) => around(Bounds::from_points(mesh.vertices.iter().map(|v| v.as_dvec3()))),
        Shape::BicubicPatch { points, .. } => Bounds::from_points(points.iter().flatten().map(|p| t.point(*p))),
        Shape::Isosurface { container, .. } | Shape::Parametric { container, .. } => around(container_bounds(container)),
        Shape::SphereSweep { kind, spheres, .. } => {
            let reach = if *kind == SweepKind::Cubic { 2.0 } else { 1.0 };
            around(spheres.iter().map(|(c, r)| ball(*c, reach * r)).fold(Bounds::EMPTY, Bounds::union))
        }
        Shape::Blob { components, .. } => {
            let boxes = components.iter().map(|c| {
                let scale = uniform_scale(&c.transform);
                let ball = |p: DVec3, r: f64| match scale {
                    Some(s) => ball(c.transform.point(p), r * s),
                    None => ball(p, r).transformed(&c.transform),
                };
                match c.kind {
                    BlobKind::Sphere { center, radius } => ball(center, radius.abs()),
                    // Balls around the half balls at the ends and around the body, all larger than need be.
                    BlobKind::Cylinder { a, b, radius } => {
                        let ends = ball(a, radius.abs() * SQRT_2).union(ball(b, radius.abs() * SQRT_2));
                        ends.union(ball(0.5 * (a + b), (2.0 * radius * radius + 0.5 * (b - a).length_squared()).sqrt()))
                    }
                }
            });
            around(boxes.fold(Bounds::EMPTY, Bounds::union))
        }
        Shape::Lathe { kind: CurveKind::Bezier, points } => around(hull(points)),
        Shape::Prism { kind: CurveKind::Bezier, conic, low, high, points, .. } => {
            let flat = Bounds::from_points(points.iter().map(|p| DVec3::new(p.x, 0.0, p.y)));
            let at = |y: f64| {
                let s = if *conic { y } else { 1.0 };
                Bounds::from_corners(s * flat.min + DVec3::Y * y, s * flat.max + DVec3::Y * y)
            };
            around(at(*low).union(at(*high)))
        }
        Shape::Triangle { vertices, .. } => Bounds::from_points(vertices.map(|v| t.point(v))),
        Shape::Polygon { points } => {
            let b = Bounds::from_points(points.iter().map(|p| t.point(*p)));
            let n = polygon_normal(points).map_or(DVec3::ZERO, |n| t.normal(n).normalize_or_zero().abs() * FLAT);
            Bounds { min: b.min - n, max: b.max + n }
        }
        _ => around(native(object, tables)),
    }
}

fn polygon_normal(points: &[DVec3]) -> Option<DVec3> {
    super::shape::PolygonShape::new(points).map(|p| p.normal)
}

/// The box of a shape about z of its own frame.
fn canonical(object: &Object, radius: f64, low: f64, high: f64, tables: &mut LeafTables) -> Bounds {
    let (mut transforms, mut textures) = (TransformTable::new(), TextureBuilder::default());
    let Ok(leaf) = add_leaf(object, &object.transform, tables, &mut transforms, &mut textures) else { return Bounds::EMPTY };
    Bounds { min: DVec3::new(-radius, -radius, low), max: DVec3::new(radius, radius, high) }.transformed(&leaf.transform)
}

/// The box in the shape's own space.
fn native(object: &Object, tables: &mut LeafTables) -> Bounds {
    let (mut transforms, mut textures) = (TransformTable::new(), TextureBuilder::default());
    add_leaf(object, &Transform::IDENTITY, tables, &mut transforms, &mut textures).map_or(Bounds::EMPTY, |l| unpadded(l.surface_bounds))
}

/// Takes off what `leaf::padded` added, to within rounding.
fn unpadded(b: Bounds) -> Bounds {
    if b.is_empty() || b.is_unbounded() {
        return b;
    }
    let pad = pad_of(&b) / (1.0 + 1e-7);
    Bounds { min: b.min + pad, max: b.max - pad }
}
