//! Brute force, and how a tree is held against it.

use super::meshes::Triangles;
use crate::accel::{Accel, AccelKind, AccelOptions, TrianglePrims};
use crate::kernel::intersect::LocalRay;
use crate::kernel::intersect::mesh::ShearedRay;
use crate::math::{Ray, Vec3};

/// Nearer hits do not count: a ray that starts on a face would be decided by the last bit.
const T_MIN: f64 = 1e-9;

/// Corners ready for the kernel's own triangle test, so that only the tree can make a difference.
pub struct Oracle {
    corners: Vec<[Vec3; 3]>,
    scale: f64,
}

/// A depth (infinite for a miss) and how far it may be off.
#[derive(Clone, Copy)]
pub struct Truth {
    /// Depth.
    pub t: f64,
    /// Of the depth.
    pub error: f64,
}

/// What a tree got wrong.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Faults {
    /// Rays with a hit that the tree does not have.
    pub missed: usize,
    /// Rays with a nearer hit than the tree has.
    pub farther: usize,
    /// Rays that `any` lets pass.
    pub unblocked: usize,
    /// Rays where the tree has a hit that brute force does not.
    pub invented: usize,
}

impl Faults {
    /// Nothing is wrong.
    pub fn none(&self) -> bool {
        *self == Faults::default()
    }

    /// Faults of all kinds.
    pub fn count(&self) -> usize {
        self.missed + self.farther + self.unblocked + self.invented
    }

    /// Of both.
    pub fn plus(self, other: Self) -> Self {
        Self {
            missed: self.missed + other.missed,
            farther: self.farther + other.farther,
            unblocked: self.unblocked + other.unblocked,
            invented: self.invented + other.invented,
        }
    }

    /// Whether hits are lost.
    pub fn lost(&self) -> bool {
        self.missed + self.farther > 0
    }
}

/// A tree over a mesh.
pub fn build(kind: AccelKind, mesh: &Triangles) -> Accel {
    Accel::build(kind, &TrianglePrims { vertices: &mesh.vertices, faces: &mesh.faces }, &AccelOptions::default())
}

impl Oracle {
    /// For a mesh.
    pub fn new(mesh: &Triangles) -> Self {
        let corners: Vec<[Vec3; 3]> = mesh.faces.iter().map(|f| f.map(|v| mesh.vertices[v as usize])).collect();
        let scale = corners.iter().flatten().fold(0.0, |m: f64, p| m.max(p.abs().max_element().into()));
        Self { corners, scale }
    }

    /// The nearest depth of all.
    pub fn brute(&self, ray: &Ray) -> Truth {
        let sheared = sheared(ray);
        let mut truth = Truth { t: f64::INFINITY, error: 0.0 };
        let mut nearest = None;
        for c in &self.corners {
            if let Some((t, ..)) = sheared.hit(c)
                && t > T_MIN
                && t < truth.t
            {
                (truth.t, nearest) = (t, Some(c));
            }
        }
        truth.error = nearest.map_or(0.0, |c| self.depth_error(ray, c));
        truth
    }

    /// Largest error of a hit's depth: the test weighs the corners' depths by areas seen along the ray, which vanish edge on.
    fn depth_error(&self, ray: &Ray, c: &[Vec3; 3]) -> f64 {
        let c = c.map(|p| p.as_dvec3());
        let edges = [c[1] - c[0], c[2] - c[1], c[0] - c[2]];
        let longest = edges.iter().fold(0.0f64, |m, e| m.max(e.length_squared()));
        let position = 16.0 * f64::EPSILON * (self.scale + ray.origin.abs().max_element());
        let seen = edges[0].cross(edges[1]).dot(ray.dir).abs();
        position * (1.0 + longest / seen)
    }

    /// The nearest depth that `tree` finds.
    pub fn closest(&self, tree: &Accel, ray: &Ray) -> f64 {
        self.closest_above(tree, ray, T_MIN)
    }

    /// The nearest depth above `t_min` that `tree` finds.
    pub fn closest_above(&self, tree: &Accel, ray: &Ray, t_min: f64) -> f64 {
        let sheared = sheared(ray);
        let mut best = f64::INFINITY;
        tree.closest(ray, 0.0, f64::INFINITY, |prim, far| {
            let (t, ..) = sheared.hit(&self.corners[prim as usize])?;
            (t > t_min && t < far).then(|| {
                best = best.min(t);
                t
            })
        });
        best
    }

    /// Whether `tree` finds anything up to `t_max`.
    pub fn any(&self, tree: &Accel, ray: &Ray, t_max: f64) -> bool {
        let sheared = sheared(ray);
        tree.any(ray, 0.0, t_max, |prim| sheared.hit(&self.corners[prim as usize]).is_some_and(|h| h.0 > T_MIN && h.0 <= t_max))
    }

    /// Adds what `tree` gets wrong for a ray.
    pub fn check(&self, tree: &Accel, ray: &Ray, truth: Truth, faults: &mut Faults) {
        let got = self.closest(tree, ray);
        faults.missed += usize::from(got == f64::INFINITY && truth.t < got);
        // A face whose depth comes out too small may lie behind the hit that ended the search.
        faults.farther += usize::from(got < f64::INFINITY && got > truth.t + truth.error);
        faults.invented += usize::from(got < truth.t);
        faults.unblocked += usize::from(truth.t < f64::INFINITY && !self.any(tree, ray, truth.t + truth.error));
    }
}

fn sheared(ray: &Ray) -> ShearedRay {
    ShearedRay::new(&LocalRay { origin: ray.origin, dir: ray.dir, scale: 1.0 })
}
