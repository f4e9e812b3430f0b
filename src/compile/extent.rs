//! The boxes that `min_extent` and `max_extent` print: POV-Ray's own, looser than the boxes that rays are tested with.
//! Source: spec/objects.md, sections 13 and 15.

use super::leaf::{LeafTables, add_glyph, add_leaf, disc_bounds, pad_of, uniform_scale};
use super::tables::TransformTable;
use super::texture::TextureBuilder;
use crate::accel::AccelKind;
use crate::math::{Bounds, DVec3, EPSILON, Transform};
use crate::scene::shape::SweepKind;
use crate::scene::{Csg, Object, Shape};

/// POV-Ray's box of `object`, rounded to 32 bits as POV-Ray keeps it.
pub fn pov_extent(object: &Object) -> Bounds {
    let b = extent(object, &Transform::IDENTITY, &mut LeafTables::new(AccelKind::Brute));
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

fn extent(object: &Object, outer: &Transform, tables: &mut LeafTables) -> Bounds {
    let t = object.transform.then(outer);
    let mut own = match &object.shape {
        Shape::Csg { op, children } => csg_extent(*op, children, &t, tables),
        Shape::LightGroup { children, .. } => csg_extent(Csg::Union, children, &t, tables),
        Shape::Group { child } => extent(child, &t, tables),
        Shape::Light(_) => Bounds::EMPTY,
        Shape::Text { glyphs, depth } => {
            let letters = glyphs.iter().filter_map(|g| add_glyph(g, *depth, &t, tables));
            letters.fold(Bounds::EMPTY, |b, l| b.union(unpadded(l.surface_bounds)))
        }
        _ => leaf_extent(object, &t, tables),
    };
    for list in [&object.clipped_by, &object.bounded_by] {
        let cut = list.iter().map(|c| extent(c, outer, tables)).fold(Bounds::UNBOUNDED, Bounds::intersection);
        if volume(&cut) < volume(&own) {
            own = cut;
        }
    }
    own
}

fn csg_extent(op: Csg, children: &[Object], t: &Transform, tables: &mut LeafTables) -> Bounds {
    match op {
        Csg::Union | Csg::Merge => {
            let boxes = children.iter().filter(|c| !matches!(c.shape, Shape::Light(_)));
            boxes.map(|c| extent(c, t, tables)).fold(Bounds::EMPTY, Bounds::union)
        }
        Csg::Difference => children.first().map_or(Bounds::EMPTY, |c| extent(c, t, tables)),
        Csg::Intersection => {
            let counts = |c: &&Object| match c.shape {
                Shape::HeightField { .. } | Shape::Light(_) => false,
                // An inverted plane is the plane the other way round.
                Shape::Plane { .. } => true,
                _ => !c.flags.inverse,
            };
            let solid = children.iter().filter(counts);
            solid.map(|c| cut_extent(c, t, tables)).fold(Bounds::UNBOUNDED, Bounds::intersection)
        }
    }
}

/// The box of a part of an intersection: planes that are square to an axis and quadrics cut it tightly.
fn cut_extent(object: &Object, outer: &Transform, tables: &mut LeafTables) -> Bounds {
    match &object.shape {
        Shape::Plane { normal, distance } => {
            let t = object.transform.then(outer);
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
        _ => extent(object, outer, tables),
    }
}

fn leaf_extent(object: &Object, t: &Transform, tables: &mut LeafTables) -> Bounds {
    let around = |b: Bounds| b.transformed(t);
    match &object.shape {
        Shape::Sphere { center, radius } => match uniform_scale(t) {
            Some(s) => {
                let (c, r) = (t.point(*center), DVec3::splat(radius.abs() * s));
                Bounds { min: c - r, max: c + r }
            }
            None => around(Bounds { min: *center - DVec3::splat(radius.abs()), max: *center + DVec3::splat(radius.abs()) }),
        },
        Shape::Box { min, max } => around(Bounds::from_corners(*min, *max)),
        Shape::Plane { .. } | Shape::Poly { .. } => Bounds::UNBOUNDED,
        Shape::Quadric { coefficients } => around(super::shape::QuadricShape { c: *coefficients }.bounds()),
        Shape::Torus { major, minor } => {
            let r = DVec3::new(major + minor, *minor, major + minor);
            around(Bounds { min: -r, max: r })
        }
        Shape::Disc { center, normal, radius, .. } => {
            let n = normal.normalize_or_zero();
            around(disc_bounds(*center, n, *radius, &Transform::IDENTITY))
        }
        Shape::SphereSweep { kind, spheres, .. } => {
            let reach = if *kind == SweepKind::Cubic { 2.0 } else { 1.0 };
            let boxes = spheres.iter().map(|(c, r)| Bounds { min: *c - DVec3::splat(reach * r), max: *c + DVec3::splat(reach * r) });
            around(boxes.fold(Bounds::EMPTY, Bounds::union))
        }
        Shape::Triangle { vertices, .. } => Bounds::from_points(vertices.map(|v| t.point(v))),
        _ => around(native(object, tables)),
    }
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
