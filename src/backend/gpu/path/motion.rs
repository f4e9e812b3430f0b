//! Where the corners of moving faces are while the shutter is open: keys at even times, between which corners run along lines.
//! Twin: `shaders/path/corners.wesl`.

use crate::compile::CompiledScene;
use crate::compile::geometry::{Prim, prim_flags};
use crate::kernel::traverse::motion_at;
use crate::math::{DVec3, Transform, Vec3};

/// How far a point of a turning box may be from where it should be, in diagonals of the box.
const LEAST_BEND: f64 = 1e-4;
/// Most spans between keys.
const MAX_SPANS: usize = 512;

/// A primitive that moves.
pub(super) struct Keys {
    /// World from the shape's space at the time of each key.
    pub places: Vec<Transform>,
}

impl Keys {
    /// Of a primitive; `None` when it stands still.
    pub fn of(scene: &CompiledScene, prim: &Prim) -> Option<Self> {
        let g = &scene.geometry;
        let shape = &g.shapes.meshes[prim.shape_ix as usize];
        let deforms = shape.moving.is_some().then(|| shape.mesh.motion.len() - 1);
        let moves = prim.flags & prim_flags::MOVING != 0;
        if deforms.is_none() && !moves {
            return None;
        }
        let rest = &g.transforms[prim.transform_ix as usize];
        let at = |time: f64| rest.then(&motion_at(g, prim, time));
        let turns = g.objects.get(prim.object_ix as usize).and_then(|o| o.motion.as_ref()).filter(|_| moves).map_or(1, |m| m.n_spans());
        // The steps of vertices and of places are keys all.
        let mut n = lcm(deforms.unwrap_or(1), turns).min(MAX_SPANS);
        let mut b = shape.bounds;
        if let Some(m) = &shape.moving {
            b = b.union(m.bounds);
        }
        let size = rest.vector(b.max - b.min).length();
        while moves && 2 * n <= MAX_SPANS && bend(&at, n, [b.min, b.max]) > LEAST_BEND * size {
            n *= 2;
        }
        Some(Self { places: (0..=n).map(|k| at(k as f64 / n as f64)).collect() })
    }

    /// Time of key `k`, 0..=1.
    pub fn time(&self, k: usize) -> f64 {
        k as f64 / (self.places.len() - 1) as f64
    }

    /// World corners of a face at key `k`.
    pub fn corners(&self, scene: &CompiledScene, prim: &Prim, face: u32, k: usize) -> [Vec3; 3] {
        let shape = &scene.geometry.shapes.meshes[prim.shape_ix as usize];
        shape.corners_at(face, self.time(k)).map(|p| self.places[k].point(p).as_vec3())
    }

    /// World normals of a face's corners at key `k`, as long as they come.
    pub fn normals(&self, scene: &CompiledScene, prim: &Prim, normals: [u32; 3], k: usize) -> [Vec3; 3] {
        let shape = &scene.geometry.shapes.meshes[prim.shape_ix as usize];
        normals.map(|ix| self.places[k].normal(shape.normal_at(ix, self.time(k))).as_vec3())
    }
}

/// Farthest that a corner of a box is from the line between its places at two keys, half way.
fn bend(at: &impl Fn(f64) -> Transform, n: usize, [min, max]: [DVec3; 2]) -> f64 {
    let pick = |k: usize, axis: usize| if k >> axis & 1 == 0 { min[axis] } else { max[axis] };
    let corners: Vec<DVec3> = (0..8).map(|k| DVec3::new(pick(k, 0), pick(k, 1), pick(k, 2))).collect();
    let time = |k: f64| at(k / n as f64);
    (0..n)
        .flat_map(|k| {
            let [a, half, b] = [0.0, 0.5, 1.0].map(|f| time(k as f64 + f));
            corners.iter().map(move |p| (half.point(*p) - 0.5 * (a.point(*p) + b.point(*p))).length())
        })
        .fold(0.0, f64::max)
}

fn lcm(a: usize, b: usize) -> usize {
    let (mut x, mut y) = (a, b);
    while y > 0 {
        (x, y) = (y, x % y);
    }
    a / x.max(1) * b
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quarter_turn_needs_spans_and_a_shift_none() {
        let turn = |time: f64| Transform::rotation_deg(DVec3::new(0.0, 0.0, 90.0 * time));
        let shift = |time: f64| Transform::translation(DVec3::X * time);
        let cube = [DVec3::splat(-1.0), DVec3::ONE];
        assert!(bend(&shift, 1, cube) < 1e-12);
        // The sagitta of a corner's quarter circle.
        let want = 2f64.sqrt() * (1.0 - (45f64.to_radians()).cos());
        assert!((bend(&turn, 1, cube) - want).abs() < 1e-9);
        assert!(bend(&turn, 64, cube) < 1.1e-4);
        assert_eq!((lcm(2, 3), lcm(1, 4), lcm(4, 6)), (6, 4, 12));
    }
}
