//! The wide BVH: 80-byte nodes of eight children whose boxes are bytes on a lattice of the node's own.
//!
//! Children stand in slots by the octant that they lie in, so that a ray's direction gives their order without sorting. Source: Ylitie,
//! Karras, Laine 2017, "Efficient incoherent ray traversal on GPUs through compressed wide BVHs". The build stands in `accel/wide_build.rs`.

use super::bvh::MAX_DEPTH;
use super::slabs::SlabRay;
use super::{AccelStats, BoxF, can_meet};
use crate::math::Ray;

/// Most primitives of a leaf: they are counted in unary in three bits.
pub const WIDE_LEAF: usize = 3;

/// A node, as the GPU reads it: five vectors of four words.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C, align(16))]
pub struct WideNode {
    /// Bits of the lattice's lowest corner.
    pub origin: [u32; 3],
    /// Exponents of the lattice's steps (biased, as in an `f32`), and which slots hold nodes.
    pub exponents_inner: [u8; 4],
    /// First of the child nodes, which stand in the order of their slots.
    pub first_child: u32,
    /// First reference of all leaves of the node.
    pub first_ref: u32,
    /// By slot: 0 for nothing; a node: `0b001_11sss`; a leaf: its count in unary above its first reference's place (5 bits).
    pub meta: [u8; 8],
    /// `[axis][slot]`: lower sides.
    pub lo: [[u8; 8]; 3],
    /// Upper sides.
    pub hi: [[u8; 8]; 3],
}

/// A bounding volume hierarchy of eight children.
#[derive(Clone, Debug)]
pub struct WideBvh {
    /// Nodes; the root is the first. Empty for no primitives.
    pub nodes: Vec<WideNode>,
    /// Primitives of the leaves, each once.
    pub refs: Vec<u32>,
    /// Box of all primitives.
    pub bounds: BoxF,
    /// What came of the build.
    pub stats: AccelStats,
}

/// What a slot holds.
pub(super) enum WideChild {
    Nothing,
    Node(u32),
    Leaf { first: u32, count: u32 },
}

impl WideNode {
    /// Step of the lattice.
    #[inline]
    pub(super) fn step(&self, axis: usize) -> f32 {
        f32::from_bits(u32::from(self.exponents_inner[axis]) << 23)
    }

    /// Box of a slot, exact in double precision.
    pub(super) fn slot_box(&self, slot: usize) -> ([f64; 3], [f64; 3]) {
        let side = |k: usize, q: u8| f64::from(f32::from_bits(self.origin[k])) + f64::from(q) * f64::from(self.step(k));
        (std::array::from_fn(|k| side(k, self.lo[k][slot])), std::array::from_fn(|k| side(k, self.hi[k][slot])))
    }

    #[inline]
    pub(super) fn child(&self, slot: usize) -> WideChild {
        let (meta, inner) = (self.meta[slot], self.exponents_inner[3]);
        if inner >> slot & 1 == 1 {
            return WideChild::Node(self.first_child + (inner & ((1 << slot) - 1)).count_ones());
        }
        match meta >> 5 {
            0 => WideChild::Nothing,
            unary => WideChild::Leaf { first: self.first_ref + u32::from(meta & 31), count: unary.count_ones() },
        }
    }
}

/// A child to visit later.
#[derive(Clone, Copy, Default)]
struct Entry {
    node: u32,
    t_enter: f64,
}

impl WideBvh {
    /// Visits leaves along the ray, near ones first as far as octants tell; `visit(first, count, t_max)` gives the depth that still matters,
    /// or `None` to stop. Tells whether it stopped.
    #[inline]
    pub(super) fn walk(&self, ray: &Ray, t_min: f64, t_max: f64, visit: impl FnMut(u32, u32, f64) -> Option<f64>) -> bool {
        if self.nodes.is_empty() || !can_meet(ray, t_min, t_max) {
            return false;
        }
        // A short stack is cheaper to clear; a level leaves seven entries at most.
        if self.stats.depth <= 9 {
            self.walk_with::<64>(ray, t_min, t_max, visit)
        } else {
            self.walk_with::<{ 7 * MAX_DEPTH + 1 }>(ray, t_min, t_max, visit)
        }
    }

    #[inline]
    fn walk_with<const N: usize>(&self, ray: &Ray, t_min: f64, t_max: f64, mut visit: impl FnMut(u32, u32, f64) -> Option<f64>) -> bool {
        let slabs = SlabRay::new(ray, self.bounds.max_abs());
        let (t_min, mut best) = (t_min.max(0.0), t_max);
        // Slots are visited in this order: those behind the ray's direction first.
        let toward = (0..3).fold(0, |m, k| m | usize::from(slabs.inv[k] < 0.0) << k);
        let mut stack = [Entry { node: 0, t_enter: t_min }; N];
        let mut n_stack = 1;
        while n_stack > 0 {
            n_stack -= 1;
            let at = stack[n_stack];
            if at.t_enter > best {
                continue;
            }
            let node = &self.nodes[at.node as usize];
            let base = n_stack;
            for k in 0..8 {
                let slot = k ^ toward;
                if node.meta[slot] == 0 {
                    continue;
                }
                let (near, far) = slabs.meet(node.slot_box(slot), t_min, best);
                if !(near <= far) {
                    continue;
                }
                match node.child(slot) {
                    WideChild::Nothing => {}
                    WideChild::Node(node) => {
                        stack[n_stack] = Entry { node, t_enter: near };
                        n_stack += 1;
                    }
                    WideChild::Leaf { first, count } => match visit(first, count, best) {
                        Some(t) => best = t,
                        None => return true,
                    },
                }
            }
            stack[base..n_stack].reverse();
        }
        false
    }

    /// Whether every number makes sense: children after their parent, references in range and each once.
    pub fn is_sound(&self, n_prims: usize) -> bool {
        let mut seen = vec![false; n_prims];
        let refs_once = self.refs.iter().all(|r| seen.get_mut(*r as usize).is_some_and(|s| !std::mem::replace(s, true)));
        refs_once
            && self.nodes.iter().enumerate().all(|(i, n)| {
                (0..8).all(|slot| match n.child(slot) {
                    WideChild::Nothing => true,
                    WideChild::Node(c) => c as usize > i && (c as usize) < self.nodes.len(),
                    WideChild::Leaf { first, count } => (first + count) as usize <= self.refs.len(),
                })
            })
    }
}
