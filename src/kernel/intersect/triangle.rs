//! Triangles of their own (not of meshes). Source: spec/objects.md, section 6.

use super::{HitSink, LocalRay, Part};
use crate::compile::shape::TriangleShape;
use crate::math::{DVec3, EPSILON, MAX_DISTANCE};

/// Hits nearer than this are not seen.
const TOLERANCE: f64 = 1e-6;

/// The one crossing; edges belong to the triangle. `Part` holds the weights of corners 2 and 3.
#[inline]
pub fn intersect_triangle(s: &TriangleShape, ray: &LocalRay, sink: &mut impl HitSink) {
    let slope = s.normal.dot(ray.dir);
    if slope.abs() < EPSILON {
        return;
    }
    let t = (s.distance - s.normal.dot(ray.origin)) / slope;
    if !(t > TOLERANCE && t < MAX_DISTANCE) {
        return;
    }
    // In the plane of the two axes that the normal is least along.
    let (i, k) = match s.axis {
        0 => (1, 2),
        1 => (0, 2),
        _ => (0, 1),
    };
    let p = ray.at(t);
    let [v1, v2, v3] = s.vertices.map(|v| (v[i], v[k]));
    let (px, py) = (p[i], p[k]);
    let edge = |a: (f64, f64), b: (f64, f64)| (b.0 - a.0) * (py - a.1) - (b.1 - a.1) * (px - a.0);
    let (w3, w1, w2) = (edge(v1, v2), edge(v2, v3), edge(v3, v1));
    if (w1 >= 0.0 && w2 >= 0.0 && w3 >= 0.0) || (w1 <= 0.0 && w2 <= 0.0 && w3 <= 0.0) {
        let sum = w1 + w2 + w3;
        sink.push(t, Part { face: 0, a: w2 / sum, b: w3 / sum });
    }
}

/// Flat, or between the corners' normals.
#[inline]
pub fn triangle_normal(s: &TriangleShape, part: &Part) -> DVec3 {
    if !s.smooth {
        return s.normal;
    }
    let [n1, n2, n3] = s.normals;
    (1.0 - part.a - part.b) * n1 + part.a * n2 + part.b * n3
}
