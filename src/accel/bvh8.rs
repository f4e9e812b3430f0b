//! The CPU's wide BVH: nodes of eight boxes, tested at once. The build stands in `accel/bvh8_build.rs`, eight boxes are
//! tested by `math/simd.rs`.
//!
//! Boxes are tested in single precision. The ray is rounded so that a box is never entered too late nor left too early, so what the
//! double-precision tests of primitives would find is offered all the same; a few more boxes are met. Source: Ize 2013.

use super::boxf::{round_down, round_up};
use super::bvh::MAX_DEPTH;
use super::stack::Stack;
use super::{AccelStats, BoxF, can_meet, nearest_of};
use crate::math::Ray;
use crate::math::simd::{self, Kernel, Simd};

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
        let (o, d) = (ray.origin.as_vec3(), ray.dir);
        // Twice the rounding of the origin, and of the sum with it.
        let slack = f32::EPSILON * (o.abs().max_element() + max_abs);
        let x = Axis::new(o.x, d.x, slack);
        let y = Axis::new(o.y, d.y, slack);
        let z = Axis::new(o.z, d.z, slack);
        Self {
            enter: [x.enter, y.enter, z.enter],
            inv_enter: [x.inv_enter, y.inv_enter, z.inv_enter],
            exit: [x.exit, y.exit, z.exit],
            inv_exit: [x.inv_exit, y.inv_exit, z.inv_exit],
            near: [x.near, y.near, z.near],
        }
    }

    /// A bit for each child whose box is met in `t_min..=t_max`, and where each is entered. 0 times infinity counts as met.
    #[inline(always)]
    pub fn meet<S: Simd>(&self, s: S, node: &Bvh8Node, t_min: f32, t_max: f32) -> (u32, [f32; WIDTH]) {
        let slabs = [self.slab(s, node, 0), self.slab(s, node, 1), self.slab(s, node, 2)];
        let (met, near) = overlap(s, slabs, s.splat_f32(t_min), s.splat_f32(t_max));
        (met, s.array_f32(near))
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

/// One axis of a [`Bvh8Ray`].
struct Axis {
    enter: f32,
    inv_enter: f32,
    exit: f32,
    inv_exit: f32,
    near: usize,
}

impl Axis {
    #[inline(always)]
    fn new(o: f32, d: f64, slack: f32) -> Self {
        let inv = (1.0 / d as f32).clamp(-STEEPEST, STEEPEST);
        let toward = slack.copysign(inv);
        Self {
            enter: o + toward,
            inv_enter: inv * (1.0 - SCALE_SLACK),
            exit: o - toward,
            inv_exit: inv * (1.0 + SCALE_SLACK),
            near: usize::from(inv < 0.0),
        }
    }
}

/// Entries that a walk may leave behind: seven a level.
pub(super) const MAX_STACK: usize = (WIDTH - 1) * MAX_DEPTH + 1;

/// A child to visit later: where it is entered in the upper half, as bits, so that nearer is less; the child in the lower half.
#[derive(Clone, Copy, PartialEq, PartialOrd)]
struct Entry(u64);

impl Entry {
    /// `t_enter` is not negative.
    #[inline(always)]
    fn new(t_enter: f32, child: u32) -> Self {
        Self(u64::from(t_enter.to_bits()) << 32 | u64::from(child))
    }

    #[inline(always)]
    fn t_enter(self) -> f32 {
        f32::from_bits((self.0 >> 32) as u32)
    }

    #[inline(always)]
    fn child(self) -> u32 {
        self.0 as u32
    }
}

impl Bvh8 {
    /// As [`super::Accel::closest_slots`].
    #[inline]
    pub fn closest_slots(&self, ray: &Ray, t_min: f64, t_max: f64, hit: impl FnMut(u32, f64) -> Option<f64>) {
        self.visit_leaves(ray, t_min, t_max, Closest(hit));
    }

    /// As [`super::Accel::any_slot`].
    #[inline]
    pub fn any_slot(&self, ray: &Ray, t_min: f64, t_max: f64, hit: impl FnMut(u32) -> bool) -> bool {
        self.visit_leaves(ray, t_min, t_max, Any(hit))
    }

    /// Visits leaves along the ray, near ones first. Tells whether the visitor stopped it.
    #[inline]
    pub fn visit_leaves(&self, ray: &Ray, t_min: f64, t_max: f64, visitor: impl LeafVisitor) -> bool {
        if self.nodes.is_empty() || !can_meet(ray, t_min, t_max) {
            return false;
        }
        let ray = Bvh8Ray::new(ray, self.bounds.max_abs() as f32);
        simd::run(Walk { tree: self, root: 0, ray, t_min: round_down(t_min.max(0.0)), t_max, visitor })
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

/// A walk through a tree, from a node on.
pub(super) struct Walk<'t, V> {
    pub tree: &'t Bvh8,
    pub root: u32,
    pub ray: Bvh8Ray,
    pub t_min: f32,
    pub t_max: f64,
    pub visitor: V,
}

impl<V: LeafVisitor> Kernel for Walk<'_, V> {
    type Output = bool;

    #[inline(always)]
    fn run<S: Simd>(mut self, simd: S) -> bool {
        let mut far = round_up(self.t_max);
        let mut stack = Stack::<Entry, MAX_STACK>::new();
        let mut at = Entry::new(0.0, self.root);
        loop {
            if at.child() & BVH8_LEAF == 0 {
                let node = &self.tree.nodes[at.child() as usize];
                let (mut met, t_enter) = self.ray.meet(simd, node, self.t_min, far);
                if met != 0 {
                    let c = met.trailing_zeros() as usize & 7;
                    met &= met - 1;
                    if met == 0 {
                        at = Entry::new(t_enter[c], node.child[c]);
                        continue;
                    }
                    at = Entry::new(t_enter[c], node.child[c]);
                    let c = met.trailing_zeros() as usize & 7;
                    met &= met - 1;
                    let other = Entry::new(t_enter[c], node.child[c]);
                    let bottom = stack.len();
                    stack.push(if at < other { other } else { at });
                    at = if at < other { at } else { other };
                    while met != 0 {
                        let c = met.trailing_zeros() as usize & 7;
                        met &= met - 1;
                        let entry = Entry::new(t_enter[c], node.child[c]);
                        let other = if entry < at { at } else { entry };
                        at = if entry < at { entry } else { at };
                        stack.push(other);
                        // Nearest on top.
                        let new = &mut stack.items()[bottom..];
                        let mut k = new.len() - 1;
                        while k > 0 && new[k - 1] < other {
                            new[k] = new[k - 1];
                            k -= 1;
                        }
                        new[k] = other;
                    }
                    continue;
                }
            } else {
                let (first, count) = leaf_slots(at.child());
                match self.visitor.leaf(simd, first, count, self.t_max) {
                    Some(t) if t < self.t_max => {
                        self.t_max = t;
                        far = round_up(t);
                    }
                    Some(_) => {}
                    None => return true,
                }
            }
            at = loop {
                match stack.pop() {
                    Some(e) if e.t_enter() <= far => break e,
                    Some(_) => {}
                    None => return false,
                }
            };
        }
    }
}
