//! Spheres, boxes, cylinders, cones, planes, discs, tori and triangles.
//!
//! Source of frames and tolerances: spec/objects.md, section 2. Where POV-Ray folds a transform into the shape's own numbers, so
//! does the compile step: spheres (unless stretched), boxes (unless turned), planes and triangles stand in world space.

use crate::math::{DAffine3, DMat3, DVec3, EPSILON, Transform};

/// A sphere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SphereShape {
    /// Centre.
    pub center: DVec3,
    /// Negative turns the normal inward.
    pub radius: f64,
    /// World from the space that (u, v) is measured in, into `Geometry::transforms`.
    pub uv_transform_ix: u32,
    /// Centre in that space.
    pub uv_center: DVec3,
}

/// A box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoxShape {
    /// Lower corner.
    pub min: DVec3,
    /// Upper corner.
    pub max: DVec3,
}

/// Radius 1 about z, from z = 0 to 1; the primitive's transform does the rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CylinderShape {
    /// Without end discs.
    pub open: bool,
}

/// x² + y² = z² from z = `low` to 1; the primitive's transform does the rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConeShape {
    /// Small end, 0..1.
    pub low: f64,
    /// Without end discs.
    pub open: bool,
}

/// Points with normal·p = distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlaneShape {
    /// Unit.
    pub normal: DVec3,
    /// From the origin.
    pub distance: f64,
}

/// About z at z = 0; the primitive's transform places it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiscShape {
    /// Squared.
    pub radius_sq: f64,
    /// Squared; 0 for none.
    pub hole_sq: f64,
}

/// About y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TorusShape {
    /// Radius of the ring.
    pub major: f64,
    /// Radius of the tube.
    pub minor: f64,
    /// Roots by Sturm chains.
    pub sturm: bool,
}

/// A triangle of its own (those of meshes stand in the mesh).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleShape {
    /// Corners.
    pub vertices: [DVec3; 3],
    /// Unit: (P1-P2)x(P3-P2).
    pub normal: DVec3,
    /// normal·p on the plane.
    pub distance: f64,
    /// Axis along which the normal is longest.
    pub axis: u8,
    /// Unit normals at the corners; equal to `normal` when flat.
    pub normals: [DVec3; 3],
    /// Normals are interpolated.
    pub smooth: bool,
}

impl TriangleShape {
    /// `None` when the corners lie on a line, or a smooth triangle's normals on both sides of it.
    pub fn new(vertices: [DVec3; 3], normals: Option<[DVec3; 3]>) -> Option<Self> {
        let [p1, p2, p3] = vertices;
        let n = (p1 - p2).cross(p3 - p2);
        let len = n.length();
        if len.is_nan() || len == 0.0 {
            return None;
        }
        let normal = n / len;
        if let Some(ns) = normals {
            let signs = ns.map(|v| v.dot(normal));
            if signs.iter().any(|s| *s > 0.0) && signs.iter().any(|s| *s < 0.0) {
                return None;
            }
        }
        let axis = longest(normal);
        Some(Self {
            vertices,
            normal,
            distance: normal.dot(p1),
            axis: axis as u8,
            normals: normals.map_or([normal; 3], |ns| ns.map(DVec3::normalize)),
            smooth: normals.is_some(),
        })
    }
}

impl TriangleShape {
    /// The order that POV-Ray brings corners into when a flat triangle is made. The normal is then still that of the order given, but every
    /// transform makes it anew: a triangle that was moved faces -x, +y or -z, whichever it is closest to. Measured.
    pub fn reordered(v: [DVec3; 3]) -> [DVec3; 3] {
        let n = (v[0] - v[1]).cross(v[2] - v[1]);
        let axis = longest(n);
        if (n[axis] > 0.0) == (axis == 1) { v } else { [v[1], v[0], v[2]] }
    }
}

fn longest(v: DVec3) -> usize {
    let a = v.abs();
    if a.x > a.y && a.x > a.z {
        0
    } else if a.y > a.z {
        1
    } else {
        2
    }
}

/// The frame that takes +z to the unit `axis`, x scaled and y scaled by `radius`, z by `length`, and the origin to `origin`.
pub fn frame_along(origin: DVec3, axis: DVec3, radius: f64, length: f64) -> Option<Transform> {
    // The turn about (-axis.y, axis.x, 0) by the angle between z and the axis.
    let (x, y) = if axis.x.hypot(axis.y) < EPSILON {
        (DVec3::X, if axis.z > 0.0 { DVec3::Y } else { -DVec3::Y })
    } else {
        let h2 = axis.x * axis.x + axis.y * axis.y;
        let k = (1.0 - axis.z) / h2;
        (
            DVec3::new(axis.z + k * axis.y * axis.y, -k * axis.x * axis.y, -axis.x),
            DVec3::new(-k * axis.x * axis.y, axis.z + k * axis.x * axis.x, -axis.y),
        )
    };
    Transform::from_affine(DAffine3 { matrix3: DMat3::from_cols(x * radius, y * radius, axis * length), translation: origin })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frame_along_is_a_turn_that_takes_z_to_the_axis() {
        for axis in [DVec3::new(0.3, -0.5, 0.2), DVec3::Z, -DVec3::Z, DVec3::new(1e-11, 0.0, -1.0), DVec3::X].map(DVec3::normalize) {
            let t = frame_along(DVec3::ONE, axis, 1.0, 1.0).expect("a frame");
            assert!((t.vector(DVec3::Z) - axis).length() < 1e-9);
            assert!((t.forward.matrix3.determinant() - 1.0).abs() < 1e-9);
            assert!((t.vector(DVec3::X).dot(t.vector(DVec3::Y))).abs() < 1e-9);
        }
    }

    #[test]
    fn smooth_triangle_with_normals_on_both_sides_is_dropped() {
        let v = [DVec3::ZERO, DVec3::X, DVec3::Y];
        assert!(TriangleShape::new(v, Some([DVec3::Z, DVec3::Z, -DVec3::Z])).is_none());
        let t = TriangleShape::new(v, None).expect("a triangle");
        assert_eq!(t.normal, -DVec3::Z);
    }
}
