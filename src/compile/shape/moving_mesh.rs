//! Meshes whose vertices move while the shutter is open: linear between evenly spaced steps, a tree for each time between two of them.

use crate::accel::{Accel, AccelKind, AccelOptions, PrimSet};
use crate::math::{Bounds, DVec3, Vec3};
use crate::scene::Mesh;
use crate::scene::shape::MeshStep;

/// The motion of a mesh, made ready.
#[derive(Clone, Debug)]
pub struct MovingMesh {
    /// Box of all places, in mesh space.
    pub bounds: Bounds,
    /// Over the faces between step k and step k + 1: boxes hold every place that a face has meanwhile.
    trees: Vec<Accel>,
}

/// Faces between two steps. What moves along a line stays in the box of its ends.
struct Between<'a> {
    faces: &'a [[u32; 3]],
    ends: [&'a [Vec3]; 2],
}

impl PrimSet for Between<'_> {
    fn len(&self) -> usize {
        self.faces.len()
    }

    fn bounds(&self, prim_ix: usize) -> Bounds {
        let face = self.faces[prim_ix];
        let points = self.ends.iter().flat_map(|list| face.map(|v| list[v as usize]));
        if !points.clone().all(Vec3::is_finite) {
            return Bounds::EMPTY;
        }
        Bounds::from_points(points.map(|p| p.as_dvec3()))
    }
}

impl MovingMesh {
    /// Of a mesh whose faces are within its vertices; `None` when it stands still or its steps do not fit it.
    pub fn new(mesh: &Mesh, accel: AccelKind) -> Option<Self> {
        let fits =
            |s: &MeshStep| s.vertices.len() == mesh.vertices.len() && (s.normals.is_empty() || s.normals.len() == mesh.normals.len());
        if mesh.motion.len() < 2 || !mesh.motion.iter().all(fits) {
            return None;
        }
        let tree = |w: &[MeshStep]| {
            let prims = Between { faces: &mesh.faces, ends: [&w[0].vertices, &w[1].vertices] };
            Accel::build(accel, &prims, &AccelOptions::default())
        };
        let all = mesh.motion.iter().flat_map(|s| mesh.faces.iter().flatten().map(|v| s.vertices[*v as usize].as_dvec3()));
        Some(Self { bounds: Bounds::from_points(all), trees: mesh.motion.windows(2).map(tree).collect() })
    }

    /// The tree for `time`, 0..=1 over the shutter, and the moment in the mesh's steps.
    pub fn at(&self, time: f64) -> (&Accel, Moment) {
        let m = Moment::new(self.trees.len(), time);
        (&self.trees[m.step], m)
    }
}

/// A time between two steps of a mesh.
#[derive(Clone, Copy, Debug)]
pub struct Moment {
    /// The step before.
    step: usize,
    /// 0..=1 from it to the next.
    share: f64,
}

impl Moment {
    /// Of `time` in `n` spans.
    fn new(n: usize, time: f64) -> Self {
        let x = time.clamp(0.0, 1.0) * n as f64;
        let step = (x as usize).min(n - 1);
        Self { step, share: x - step as f64 }
    }

    /// Of `time` in a mesh that moves.
    pub fn of(mesh: &Mesh, time: f64) -> Self {
        Self::new(mesh.motion.len() - 1, time)
    }

    /// A vertex, in 32 bits: faces that share it see the same point.
    #[inline]
    pub fn vertex(&self, mesh: &Mesh, ix: u32) -> Vec3 {
        let [a, b] = [0, 1].map(|k| mesh.motion[self.step + k].vertices[ix as usize].as_dvec3());
        (a + (b - a) * self.share).as_vec3()
    }

    /// A unit normal; `None` where the steps have none.
    pub fn normal(&self, mesh: &Mesh, ix: u32) -> Option<DVec3> {
        let [a, b] = [0, 1].map(|k| mesh.motion[self.step + k].normals.get(ix as usize));
        Some(a?.as_dvec3().lerp(b?.as_dvec3(), self.share).normalize_or_zero())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vertices_move_along_lines_and_boxes_hold_all_their_places() {
        let faces = vec![[0, 1, 2]];
        let step =
            |y: f32| MeshStep { vertices: vec![Vec3::new(0.0, y, 0.0), Vec3::new(1.0, y, 0.0), Vec3::new(0.0, y, 1.0)], normals: vec![] };
        let mesh = Mesh { vertices: step(0.0).vertices, faces, motion: vec![step(0.0), step(1.0), step(-3.0)], ..Mesh::default() };
        let moving = MovingMesh::new(&mesh, AccelKind::Auto).expect("it moves");
        for (time, y) in [(0.0, 0.0), (0.25, 0.5), (0.5, 1.0), (0.75, -1.0), (1.0, -3.0)] {
            assert_eq!(moving.at(time).1.vertex(&mesh, 1), Vec3::new(1.0, y, 0.0), "time {time}");
        }
        assert_eq!((moving.bounds.min.y, moving.bounds.max.y), (-3.0, 1.0));
        let short = Mesh { motion: vec![step(0.0), MeshStep::default()], ..mesh };
        assert!(MovingMesh::new(&short, AccelKind::Auto).is_none(), "steps of other vertices");
    }
}
