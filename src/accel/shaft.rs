//! Shafts: convex volumes that hold many rays at once, and the few primitives whose boxes such a volume meets. The rays of one shaft (an
//! area light's grid seen from a point, a pixel's lens samples) then test that short list, or nothing at all, in place of walking the tree.
//!
//! Conservative: a box that a ray of the shaft meets is in the list. Source: Haines and Wallace 1994, "Shaft culling".

use super::boxf::{round_down, round_up};
use super::bvh8::{BVH8_LEAF, Bvh8, Bvh8Node, Bvh8Ray, WIDTH, leaf_slots};
use super::{Accel, BoxF, can_meet};
use crate::math::simd::{self, Kernel, Simd};
use crate::math::{DVec3, Ray};

/// Most directions, besides the axes, across which a shaft is told from a box.
const MAX_SLABS: usize = 12;
/// Slack of a sum of three products of a tree's numbers, as a share of the largest coordinate.
const SLACK: f32 = 8.0 * f32::EPSILON;

/// The volume between two planes.
#[derive(Clone, Copy, Debug, Default)]
struct Slab {
    /// At most 1 in each component.
    normal: [f32; 3],
    lo: f32,
    hi: f32,
}

/// A convex volume: what lies between two planes across each of some directions.
#[derive(Clone, Debug)]
pub struct Shaft {
    lo: [f32; 3],
    hi: [f32; 3],
    slabs: [Slab; MAX_SLABS],
    n: usize,
}

impl Shaft {
    /// The hull of `points`, as far as it is seen across the axes and across `normals` (any length; of more than twelve the first), for
    /// trees within `bounds`.
    pub fn around(points: &[DVec3], normals: &[DVec3], bounds: &BoxF) -> Self {
        let slack = SLACK * bounds.max_abs() as f32;
        let mut s = Self { lo: [0.0; 3], hi: [0.0; 3], slabs: [Slab::default(); MAX_SLABS], n: 0 };
        for k in 0..3 {
            let (lo, hi) = span(points.iter().map(|p| p[k]));
            (s.lo[k], s.hi[k]) = (round_down(lo), round_up(hi));
        }
        for n in normals {
            let largest = n.abs().max_element();
            if !(largest > 0.0 && largest.is_finite()) || s.n == MAX_SLABS {
                continue;
            }
            // Both sides measure along the rounded direction, so that its rounding does not matter.
            let rounded = (*n * largest.recip()).as_vec3();
            let wide = rounded.as_dvec3();
            let (lo, hi) = span(points.iter().map(|p| p.dot(wide)));
            s.slabs[s.n] = Slab { normal: rounded.to_array(), lo: round_down(lo) - slack, hi: round_up(hi) + slack };
            s.n += 1;
        }
        s
    }

    /// A bit for each child whose box may meet the shaft; a NaN in the shaft meets nothing.
    #[inline(always)]
    fn meet<S: Simd>(&self, s: S, node: &Bvh8Node) -> u32 {
        let mut met = u32::MAX;
        for k in 0..3 {
            let (lo, hi) = (s.load_f32(&node.planes[k][0]), s.load_f32(&node.planes[k][1]));
            met &= s.le_f32(lo, s.splat_f32(self.hi[k])) & s.le_f32(s.splat_f32(self.lo[k]), hi);
        }
        for slab in &self.slabs[..self.n.min(MAX_SLABS)] {
            if met == 0 {
                return 0;
            }
            let ((ax, bx), (ay, by), (az, bz)) = (along(s, node, slab, 0), along(s, node, slab, 1), along(s, node, slab, 2));
            let least = s.add_f32(ax, s.add_f32(ay, az));
            let most = s.add_f32(bx, s.add_f32(by, bz));
            met &= s.le_f32(least, s.splat_f32(slab.hi)) & s.le_f32(s.splat_f32(slab.lo), most);
        }
        met
    }
}

/// Least and most of some numbers; those that are none do not count.
#[inline]
fn span(numbers: impl Iterator<Item = f64>) -> (f64, f64) {
    // Not f64::min: that is one instruction less in three.
    let (mut lo, mut hi) = (f64::INFINITY, f64::NEG_INFINITY);
    for v in numbers {
        lo = if v < lo { v } else { lo };
        hi = if v > hi { v } else { hi };
    }
    (lo, hi)
}

/// Least and most of an axis' share in the distance of eight boxes along a slab's normal.
#[inline(always)]
fn along<S: Simd>(s: S, node: &Bvh8Node, slab: &Slab, k: usize) -> (S::F32x8, S::F32x8) {
    let (n, side) = (slab.normal[k], usize::from(slab.normal[k] < 0.0));
    (s.mul_f32(s.load_f32(&node.planes[k][side]), s.splat_f32(n)), s.mul_f32(s.load_f32(&node.planes[k][side ^ 1]), s.splat_f32(n)))
}

/// The primitives that a shaft may meet, in packs of eight boxes.
#[derive(Clone, Debug, Default)]
pub struct Candidates {
    /// `child` is a primitive.
    packs: Vec<Bvh8Node>,
    n: usize,
    max_abs: f32,
}

impl Candidates {
    /// Number of primitives.
    pub fn len(&self) -> usize {
        self.n
    }

    /// Whether rays of the shaft meet nothing.
    pub fn is_empty(&self) -> bool {
        self.n == 0
    }

    fn push(&mut self, bounds: &BoxF, prim: u32) {
        let place = self.n % WIDTH;
        if place == 0 {
            self.packs.push(Bvh8Node::EMPTY);
        }
        if let Some(pack) = self.packs.last_mut() {
            pack.set(place, bounds, prim);
        }
        self.n += 1;
    }

    /// As [`Accel::any`], for a ray of the shaft.
    #[inline]
    pub fn any(&self, ray: &Ray, t_min: f64, t_max: f64, hit: impl FnMut(u32) -> bool) -> bool {
        if self.packs.is_empty() || !can_meet(ray, t_min, t_max) {
            return false;
        }
        let ray = Bvh8Ray::new(ray, self.max_abs);
        simd::run(List { packs: &self.packs, ray, t_min: round_down(t_min.max(0.0)), t_max: round_up(t_max), hit })
    }
}

/// All packs against one ray.
struct List<'c, F> {
    packs: &'c [Bvh8Node],
    ray: Bvh8Ray,
    t_min: f32,
    t_max: f32,
    hit: F,
}

impl<F: FnMut(u32) -> bool> Kernel for List<'_, F> {
    type Output = bool;

    #[inline(always)]
    fn run<S: Simd>(mut self, simd: S) -> bool {
        for pack in self.packs {
            let (mut met, _) = self.ray.meet(simd, pack, self.t_min, self.t_max);
            while met != 0 {
                let place = met.trailing_zeros() as usize & (WIDTH - 1);
                met &= met - 1;
                if (self.hit)(pack.child[place]) {
                    return true;
                }
            }
        }
        false
    }
}

/// A walk through a tree that keeps what a shaft meets.
struct Gather<'t> {
    tree: &'t Bvh8,
    shaft: &'t Shaft,
    most: usize,
    out: &'t mut Candidates,
}

impl Kernel for Gather<'_> {
    type Output = bool;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> bool {
        // Deeper than any list that is short enough to be of use.
        let (mut stack, mut n) = ([0u32; 96], 1);
        while n > 0 {
            n -= 1;
            let node = &self.tree.nodes[stack[n] as usize];
            let mut met = self.shaft.meet(simd, node);
            while met != 0 {
                let place = met.trailing_zeros() as usize & (WIDTH - 1);
                met &= met - 1;
                let child = node.child[place];
                if child & BVH8_LEAF == 0 {
                    if n == stack.len() {
                        return false;
                    }
                    stack[n] = child;
                    n += 1;
                    continue;
                }
                let (first, count) = leaf_slots(child);
                for slot in first..first + count {
                    let prim = self.tree.slots[slot as usize];
                    if self.out.n == self.most {
                        return false;
                    }
                    self.out.push(&node.child_box(place), prim);
                }
            }
        }
        true
    }
}

impl Accel {
    /// The box of all primitives, where [`Accel::gather`] can look for those in a shaft.
    #[inline]
    pub fn shaft_bounds(&self) -> Option<&BoxF> {
        match self {
            Self::Bvh8(t) if !t.nodes.is_empty() => Some(&t.bounds),
            _ => None,
        }
    }

    /// Puts the primitives that `shaft` may meet in place of what `out` holds. False, with half a list, when there are more than `most` or
    /// the structure cannot tell.
    pub fn gather(&self, shaft: &Shaft, most: usize, out: &mut Candidates) -> bool {
        out.packs.clear();
        out.n = 0;
        let Self::Bvh8(tree) = self else { return false };
        out.max_abs = tree.bounds.max_abs() as f32;
        tree.nodes.is_empty() || simd::run(Gather { tree, shaft, most, out })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::{AccelOptions, PrimSet};
    use crate::math::Bounds;
    use crate::math::random::UniformStream;

    struct Boxes(Vec<Bounds>);

    impl PrimSet for Boxes {
        fn len(&self) -> usize {
            self.0.len()
        }
        fn bounds(&self, prim_ix: usize) -> Bounds {
            self.0[prim_ix]
        }
    }

    fn meets(b: &Bounds, ray: &Ray, end: f64) -> bool {
        let (x, y) = ((b.min - ray.origin) / ray.dir, (b.max - ray.origin) / ray.dir);
        x.min(y).max_element().max(0.0) <= x.max(y).min_element().min(end)
    }

    #[test]
    fn what_rays_of_a_shaft_meet_is_in_its_list_and_little_else() {
        let mut random = UniformStream::default();
        let mut draw = |scale: f64| scale * DVec3::new(random.draw() - 0.5, random.draw() - 0.5, random.draw() - 0.5);
        let boxes: Vec<Bounds> = (0..400)
            .map(|_| {
                let (p, r) = (draw(20.0) + DVec3::splat(1000.0), draw(1.0).abs());
                Bounds { min: p - r, max: p + r }
            })
            .collect();
        let tree = Accel::Bvh8(Bvh8::build(&Boxes(boxes.clone()), &AccelOptions { max_leaf: 1, ..AccelOptions::default() }));
        let bounds = *tree.shaft_bounds().expect("a tree of eight children");
        let (mut n_met, mut n_listed) = (0, 0);
        for _ in 0..300 {
            let (from, to, a, b) = (draw(20.0) + DVec3::splat(1000.0), draw(30.0) + DVec3::splat(1000.0), draw(2.0), draw(2.0));
            let corners = [to - a - b, to + a - b, to + a + b, to - a + b];
            let sides: [DVec3; 4] = std::array::from_fn(|k| (corners[k] - from).cross(corners[(k + 1) % 4] - from));
            let shaft = Shaft::around(&[from, corners[0], corners[1], corners[2], corners[3]], &sides, &bounds);
            let mut list = Candidates::default();
            assert!(tree.gather(&shaft, 400, &mut list));
            let mut met_any = vec![false; boxes.len()];
            for _ in 0..20 {
                let d = draw(2.0);
                let way = to + d.x * a + d.y * b - from;
                let ray = Ray::new(from, way.normalize());
                let mut offered = vec![false; boxes.len()];
                list.any(&ray, 0.0, way.length(), |prim| {
                    offered[prim as usize] = true;
                    false
                });
                for (k, b) in boxes.iter().enumerate().filter(|(_, b)| meets(b, &ray, way.length())) {
                    assert!(offered[k], "{b:?} is met by {ray:?}");
                    met_any[k] = true;
                }
            }
            n_met += met_any.iter().filter(|m| **m).count();
            n_listed += list.len();
        }
        assert!(n_met > 200 && n_listed < 4 * n_met, "{n_met} met, {n_listed} listed");
        let all = Shaft::around(&[DVec3::splat(900.0), DVec3::splat(1100.0)], &[], &bounds);
        assert!(!tree.gather(&all, 399, &mut Candidates::default()), "a list that is too long is refused");
    }
}
