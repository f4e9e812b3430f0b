//! Rays that find faults: random ones, and those along axes, in planes, through vertices and edges, from the tree's own planes.

use super::meshes::Triangles;
use crate::accel::{Accel, AccelKind, AccelOptions, TrianglePrims};
use crate::math::random::SplitMix64;
use crate::math::{Bounds, DVec3, Ray};

/// Endless rays of ten kinds in turn, around triangles and planes.
pub struct RaySource<'a> {
    mesh: &'a Triangles,
    bounds: Bounds,
    /// `(axis, place)` of planes of a kd-tree over the mesh.
    planes: Vec<(usize, f64)>,
    numbers: SplitMix64,
    count: usize,
    kinds: Vec<usize>,
}

/// Kinds of rays that run along axes, or in planes that trees divide space by.
pub const AXIS_RAYS: [usize; 5] = [4, 5, 8, 9, 10];
/// Kinds of rays that run in the planes of faces, or along edges.
pub const PLANE_RAYS: [usize; 3] = [4, 6, 7];

impl<'a> RaySource<'a> {
    /// Rays for a mesh.
    pub fn new(mesh: &'a Triangles, seed: u64) -> Self {
        let prims = TrianglePrims { vertices: &mesh.vertices, faces: &mesh.faces };
        let planes = match Accel::build(AccelKind::Kd, &prims, &AccelOptions::default()) {
            Accel::Kd(t) => t.nodes.iter().filter(|n| !n.is_leaf()).map(|n| (n.axis(), f64::from(n.split()))).collect(),
            _ => Vec::new(),
        };
        let bounds = Bounds::from_points(mesh.vertices.iter().map(|v| v.as_dvec3()));
        Self { mesh, bounds, planes, numbers: SplitMix64(seed), count: 0, kinds: (0..10).collect() }
    }

    /// Only rays of these kinds: 0 to 9 as they come in turn, 10 for rays in a plane of a vertex.
    pub fn only(mut self, kinds: &[usize]) -> Self {
        self.kinds = kinds.to_vec();
        self
    }

    /// In the box, somewhat grown.
    fn place(&mut self) -> DVec3 {
        let r = 0.5 * self.bounds.size() + 0.1 * self.bounds.size().max_element();
        self.bounds.center() + self.numbers.cube() * r
    }

    fn vertex(&mut self) -> DVec3 {
        self.mesh.vertices[self.numbers.below(self.mesh.vertices.len())].as_dvec3()
    }

    /// On an edge or inside of a face.
    fn on_face(&mut self, on_edge: bool) -> DVec3 {
        let [a, b, c] = self.mesh.corners(self.numbers.below(self.mesh.faces.len()));
        let (u, v) = (self.numbers.unit(), if on_edge { 0.0 } else { self.numbers.unit() });
        a + u * (b - a) + v * (1.0 - u) * (c - a)
    }

    fn axis(&mut self) -> DVec3 {
        let k = self.numbers.below(3);
        let zero = if self.numbers.below(2) == 0 { 0.0 } else { -0.0 };
        let mut d = DVec3::splat(zero);
        d[k] = if self.numbers.below(2) == 0 { 1.0 } else { -1.0 };
        d
    }

    /// A component of zero, of either sign, or too small to matter.
    fn flattened(&mut self, mut d: DVec3, axis: usize) -> DVec3 {
        d[axis] = [0.0, -0.0, 1e-45, -1e-300][self.numbers.below(4)];
        d.try_normalize().unwrap_or(DVec3::X)
    }

    fn ray(&mut self) -> Ray {
        self.count += 1;
        let size = self.bounds.size().max_element();
        let direction = self.numbers.direction();
        let kind = self.kinds[self.count % self.kinds.len()];
        match kind {
            // From outside to somewhere in the box; from inside anywhere.
            0 => {
                let from = self.bounds.center() + direction * size * 3.0;
                Ray::new(from, self.place() - from)
            }
            1 => Ray::new(self.place(), direction),
            // At a vertex, an edge, a face.
            2 => {
                let from = self.place();
                Ray::new(from, self.vertex() - from)
            }
            3 => {
                let from = self.place();
                let on_edge = self.numbers.below(2) == 0;
                Ray::new(from, self.on_face(on_edge) - from)
            }
            // Along an axis: anywhere, and through coordinates that vertices have.
            4 => Ray::new(self.place(), self.axis()),
            5 => {
                let d = self.axis();
                let (mut from, back) = (self.vertex(), self.numbers.unit() * 2.0 * size);
                let other = self.vertex();
                // Two vertices mixed: a corner of the lattice of all box sides.
                from.y = if self.numbers.below(2) == 0 { from.y } else { other.y };
                from.z = if self.numbers.below(2) == 0 { from.z } else { other.z };
                let back = if self.numbers.below(4) == 0 { 0.0 } else { back };
                Ray::new(from - d * back, d)
            }
            // From vertex to vertex: starts on a corner, often runs in a face or along an edge.
            6 => {
                let (a, b) = (self.vertex(), self.vertex());
                let back = if self.numbers.below(2) == 0 { 0.0 } else { 0.5 };
                Ray::new(a - back * (b - a), b - a)
            }
            // In a plane of a face: between two points of it.
            7 => {
                let [a, b, c] = self.mesh.corners(self.numbers.below(self.mesh.faces.len()));
                let (u, v) = (self.numbers.unit(), self.numbers.unit());
                let (p, q) = (a + 2.0 * u * (b - a) - 0.5 * (c - a), b + v * (c - b));
                Ray::new(p, q - p)
            }
            // In a plane of the kd-tree, and from a point on it.
            8 | 9 if !self.planes.is_empty() => {
                let (axis, at) = self.planes[self.numbers.below(self.planes.len())];
                let mut from = self.place();
                from[axis] = at;
                let d = if kind == 8 { self.flattened(direction, axis) } else { direction };
                Ray::new(from, d)
            }
            // Parallel to an axis plane, in the plane of a vertex.
            _ => {
                let axis = self.numbers.below(3);
                let mut from = self.place();
                from[axis] = self.vertex()[axis];
                let d = self.flattened(direction, axis);
                Ray::new(from, d)
            }
        }
    }
}

impl Iterator for RaySource<'_> {
    type Item = Ray;

    /// The next ray, its direction unit.
    fn next(&mut self) -> Option<Ray> {
        loop {
            let r = self.ray();
            if let Some(dir) = r.dir.try_normalize() {
                return Some(Ray::new(r.origin, dir));
            }
        }
    }
}
