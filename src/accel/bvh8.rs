//! The CPU's wide BVH: nodes of eight boxes, tested at once. The build stands in `accel/bvh8_build.rs`, eight boxes are
//! tested by `math/simd.rs`.
//!
//! Boxes are tested in single precision. The ray is rounded so that a box is never entered too late nor left too early, so what the
//! double-precision tests of primitives would find is offered all the same; a few more boxes are met. Source: Ize 2013.

use super::boxf::{round_down, round_up};
use super::bvh::MAX_DEPTH;
use super::stack::Room;
use super::{AccelStats, BoxF, can_meet, nearest_of};
use crate::math::simd::{self, Kernel, Simd};
use crate::math::{Ray, Vec3A};

/// Marks a leaf in [`Bvh8Node::child`].
pub const BVH8_LEAF: u32 = 1 << 31;
/// Children of a node.
pub const WIDTH: usize = 8;
/// Leaves begin at multiples of this many slots, and hold at most as many primitives: data kept in slot order can be laid out in packs.
pub const PACK: usize = 4;
/// A slot without a primitive.
pub const NO_PRIM: u32 = u32::MAX;

/// A node: the boxes of its children, not its own. A child that is missing has a box that no ray meets.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(32))]
pub struct Bvh8Node {
    /// `[axis][lower, upper side][child]`.
    pub planes: [[[f32; WIDTH]; 2]; 3],
    /// Inner child: its node. Leaf: see [`leaf_slots`].
    pub child: [u32; WIDTH],
}

/// First slot and number of primitives of a leaf: [`BVH8_LEAF`] is set, the slot is a multiple of [`PACK`], its lowest bits hold the number less one.
#[inline(always)]
pub fn leaf_slots(child: u32) -> (u32, u32) {
    (child & !(BVH8_LEAF | (PACK as u32 - 1)), (child & (PACK as u32 - 1)) + 1)
}

impl Bvh8Node {
    /// No children.
    pub(super) const EMPTY: Self = Self { planes: [[[f32::INFINITY; WIDTH], [f32::NEG_INFINITY; WIDTH]]; 3], child: [BVH8_LEAF; WIDTH] };

    /// Sets child `c`.
    pub(super) fn set(&mut self, c: usize, bounds: &BoxF, child: u32) {
        for k in 0..3 {
            self.planes[k][0][c] = bounds.lo[k];
            self.planes[k][1][c] = bounds.hi[k];
        }
        self.child[c] = child;
    }

    /// Box of a child.
    pub fn child_box(&self, c: usize) -> BoxF {
        BoxF { lo: self.planes.map(|p| p[0][c]), hi: self.planes.map(|p| p[1][c]) }
    }
}

/// A bounding volume hierarchy with eight children a node.
#[derive(Clone, Debug)]
pub struct Bvh8 {
    /// Nodes; the root is the first. Empty for no primitives.
    pub nodes: Vec<Bvh8Node>,
    /// Primitive in each slot; [`NO_PRIM`] where a leaf is not full.
    pub slots: Vec<u32>,
    /// Box of all primitives.
    pub bounds: BoxF,
    /// Its largest absolute coordinate.
    pub max_abs: f32,
    /// Every leaf has one primitive at most: its box is the primitive's.
    pub is_single: bool,
    /// What came of the build.
    pub stats: AccelStats,
}

/// A ray made ready for eight boxes at once, never too late at a near side nor too early at a far side.
pub(super) struct Bvh8Ray {
    /// A plane at `s` is reached at `(s - enter) * inv_enter` at the earliest ...
    pub enter: [f32; 3],
    pub inv_enter: [f32; 3],
    /// ... and left behind at `(s - exit) * inv_exit` at the latest.
    pub exit: [f32; 3],
    pub inv_exit: [f32; 3],
    /// 1 where the ray runs down the axis: the index of a box's near side.
    pub near: [usize; 3],
}

/// Rounding of a difference, an inverse and a product, twice over.
pub(super) const SCALE_SLACK: f32 = 4.0 * f32::EPSILON;
/// Largest slope: what lies ahead at the smallest distance is then beyond any scene.
pub(super) const STEEPEST: f32 = 1e37;

impl Bvh8Ray {
    /// For a usable ray in a tree whose largest absolute coordinate is `max_abs`.
    #[inline(always)]
    pub fn new(ray: &Ray, max_abs: f32) -> Self {
        // The three axes side by side.
        let (o, d) = (ray.origin.as_vec3a(), ray.dir.as_vec3a());
        // Twice the rounding of the origin, and of the sum with it.
        let slack = Vec3A::splat(f32::EPSILON * (o.abs().max_element() + max_abs));
        let inv = d.recip().max(Vec3A::splat(-STEEPEST)).min(Vec3A::splat(STEEPEST));
        let toward = slack.copysign(inv);
        let down = inv.cmplt(Vec3A::ZERO).bitmask() as usize;
        Self {
            enter: (o + toward).to_array(),
            inv_enter: (inv * (1.0 - SCALE_SLACK)).to_array(),
            exit: (o - toward).to_array(),
            inv_exit: (inv * (1.0 + SCALE_SLACK)).to_array(),
            near: [down & 1, down >> 1 & 1, down >> 2 & 1],
        }
    }

    /// A bit for each child whose box is met in `t_min..=t_max`, and where each is entered. 0 times infinity counts as met.
    #[inline(always)]
    pub fn meet<S: Simd>(&self, s: S, node: &Bvh8Node, t_min: f32, t_max: f32) -> (u32, S::F32x8) {
        let slabs = [self.slab(s, node, 0), self.slab(s, node, 1), self.slab(s, node, 2)];
        overlap(s, slabs, s.splat_f32(t_min), s.splat_f32(t_max))
    }

    /// Where the eight slabs across an axis are entered and left.
    #[inline(always)]
    fn slab<S: Simd>(&self, s: S, node: &Bvh8Node, k: usize) -> (S::F32x8, S::F32x8) {
        let side = self.near[k] & 1;
        let (first, last) = (s.load_f32(&node.planes[k][side]), s.load_f32(&node.planes[k][side ^ 1]));
        (
            s.mul_f32(s.sub_f32(first, s.splat_f32(self.enter[k])), s.splat_f32(self.inv_enter[k])),
            s.mul_f32(s.sub_f32(last, s.splat_f32(self.exit[k])), s.splat_f32(self.inv_exit[k])),
        )
    }
}

/// A bit for each lane whose three slabs, entered and left at these depths, overlap between `t_min` and `t_max`; where they do so first.
#[inline(always)]
pub(super) fn overlap<S: Simd>(s: S, slabs: [(S::F32x8, S::F32x8); 3], t_min: S::F32x8, t_max: S::F32x8) -> (u32, S::F32x8) {
    let [(ax, bx), (ay, by), (az, bz)] = slabs;
    let near = s.max_f32(ax, s.max_f32(ay, s.max_f32(az, t_min)));
    let far = s.min_f32(bx, s.min_f32(by, s.min_f32(bz, t_max)));
    (s.le_f32(near, far), near)
}

/// Entries that a walk may leave behind: seven a level.
pub(super) const MAX_STACK: usize = (WIDTH - 1) * MAX_DEPTH + 1;

impl Bvh8 {
    /// As [`super::Accel::closest_slots`].
    #[inline]
    pub fn closest_slots(&self, ray: &Ray, t_min: f64, t_max: f64, hit: impl FnMut(u32, f64) -> Option<f64>) {
        self.visit_leaves(ray, t_min, t_max, &mut Closest(hit));
    }

    /// As [`super::Accel::any_slot`].
    #[inline]
    pub fn any_slot(&self, ray: &Ray, t_min: f64, t_max: f64, hit: impl FnMut(u32) -> bool) -> bool {
        self.visit_leaves(ray, t_min, t_max, &mut Any(hit))
    }

    /// Visits leaves along the ray, near ones first. Tells whether the visitor stopped it.
    #[inline]
    pub fn visit_leaves(&self, ray: &Ray, t_min: f64, t_max: f64, visitor: &mut impl LeafVisitor) -> bool {
        if self.nodes.is_empty() || !can_meet(ray, t_min, t_max) {
            return false;
        }
        simd::run(Visit { tree: self, ray, t_min: t_min.max(0.0), t_max, visitor })
    }

    /// Whether every number in the tree makes sense: children after their parent, slots in range, each primitive below `n_prims`, none twice.
    pub fn is_sound(&self, n_prims: usize) -> bool {
        let mut seen = vec![false; n_prims];
        let once =
            self.slots.iter().filter(|s| **s != NO_PRIM).all(|r| seen.get_mut(*r as usize).is_some_and(|s| !std::mem::replace(s, true)));
        once && self.nodes.iter().enumerate().all(|(i, n)| {
            (0..WIDTH).all(|c| {
                let child = n.child[c];
                let (first, count) = leaf_slots(child);
                if child & BVH8_LEAF != 0 {
                    child == BVH8_LEAF || (first + count) as usize <= self.slots.len()
                } else {
                    child as usize > i && (child as usize) < self.nodes.len()
                }
            })
        })
    }
}

/// What is done at leaves.
pub trait LeafVisitor {
    /// Tests the primitives in slots `first..first + count` (`first` is a multiple of [`PACK`]); gives the depth that still matters,
    /// or `None` to stop. `#[inline(always)]`, so that it is compiled for `simd`.
    fn leaf<S: Simd>(&mut self, simd: S, first: u32, count: u32, t_max: f64) -> Option<f64>;
}

struct Closest<F>(F);

impl<F: FnMut(u32, f64) -> Option<f64>> LeafVisitor for Closest<F> {
    #[inline(always)]
    fn leaf<S: Simd>(&mut self, _: S, first: u32, count: u32, t_max: f64) -> Option<f64> {
        Some(nearest_of(first, count, t_max, &mut self.0))
    }
}

struct Any<F>(F);

impl<F: FnMut(u32) -> bool> LeafVisitor for Any<F> {
    #[inline(always)]
    fn leaf<S: Simd>(&mut self, _: S, first: u32, count: u32, t_max: f64) -> Option<f64> {
        if (first..first + count).any(&mut self.0) { None } else { Some(t_max) }
    }
}

/// A walk through a whole tree. What it needs is made in the kernel, where it stays in registers: a kernel with all of it would be copied.
struct Visit<'t, V> {
    tree: &'t Bvh8,
    ray: &'t Ray,
    t_min: f64,
    t_max: f64,
    visitor: &'t mut V,
}

impl<V: LeafVisitor> Kernel for Visit<'_, V> {
    type Output = bool;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> bool {
        let ray = &Bvh8Ray::new(self.ray, self.tree.max_abs);
        walk(simd, self.tree, 0, ray, round_down(self.t_min), self.t_max, self.visitor)
    }
}

/// Walks a tree from node `root` on. Tells whether the visitor stopped it.
#[inline(always)]
pub(super) fn walk<S: Simd>(
    simd: S,
    tree: &Bvh8,
    root: u32,
    ray: &Bvh8Ray,
    t_min: f32,
    mut t_max: f64,
    visitor: &mut impl LeafVisitor,
) -> bool {
    let mut far = round_up(t_max);
    let mut room = Room::<u64, MAX_STACK>::new();
    let mut stack = room.stack();
    let mut at = root;
    loop {
        if at & BVH8_LEAF == 0 {
            let node = &tree.nodes[at as usize];
            let (mut met, t_enter) = ray.meet(simd, node, t_min, far);
            if met != 0 {
                let t_enter = simd.array_f32(t_enter);
                // As a number, where a child is entered and the child: nearer is less, for depths are not negative.
                let mut next = || {
                    let c = met.trailing_zeros() as usize & 7;
                    met &= met - 1;
                    (u64::from(t_enter[c].to_bits()) << 32 | u64::from(node.child[c]), met)
                };
                let (mut best, left) = next();
                if left == 0 {
                    at = best as u32;
                    continue;
                }
                let bottom = stack.len();
                loop {
                    let (new, left) = next();
                    let other = if new < best { best } else { new };
                    best = if new < best { new } else { best };
                    stack.push(other);
                    // Nearest on top.
                    let new = &mut stack.items()[bottom..];
                    let mut k = new.len() - 1;
                    while k > 0 && new[k - 1] < other {
                        new[k] = new[k - 1];
                        k -= 1;
                    }
                    new[k] = other;
                    if left == 0 {
                        break;
                    }
                }
                at = best as u32;
                continue;
            }
        } else {
            let (first, count) = leaf_slots(at);
            match visitor.leaf(simd, first, count, t_max) {
                Some(t) if t < t_max => {
                    t_max = t;
                    far = round_up(t);
                }
                Some(_) => {}
                None => return true,
            }
        }
        at = loop {
            match stack.pop() {
                // Depths are not negative, so their bits are in their order; below all is below all.
                Some(e) if (e >> 32) as i32 <= far.to_bits() as i32 => break e as u32,
                Some(_) => {}
                None => return false,
            }
        };
    }
}
