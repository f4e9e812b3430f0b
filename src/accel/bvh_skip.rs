//! The BVH without a stack: nodes in the order of a walk, each with a link to what follows when its box is missed.
//!
//! Every ray walks in the same order, whatever its direction: no state but an index, at the price of not going near first.
//! Source: Smits 1998, "Efficiency issues for ray tracing".

use super::slabs::SlabRay;
use super::{AccelOptions, AccelStats, BVH_LEAF, BoxF, Bvh, PrimSet, can_meet, seconds_since};
use crate::math::Ray;
use std::time::Instant;

/// A node, as the GPU reads it: two vectors of four.
#[derive(Clone, Copy, Debug, PartialEq, Default, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C, align(16))]
pub struct SkipNode {
    /// Lower corner.
    pub lo: [f32; 3],
    /// The node that follows when the box is missed, or after a leaf; the number of nodes at the end.
    pub skip: u32,
    /// Upper corner.
    pub hi: [f32; 3],
    /// Leaf: first reference, and its count in the upper [`SKIP_COUNT_BITS`] bits. Inner: 0.
    pub leaf: u32,
}

/// Bits of [`SkipNode::leaf`] that count.
pub const SKIP_COUNT_BITS: u32 = 4;
const COUNT_SHIFT: u32 = 32 - SKIP_COUNT_BITS;

/// A bounding volume hierarchy in one order.
#[derive(Clone, Debug)]
pub struct BvhSkip {
    /// Nodes in the order of the walk.
    pub nodes: Vec<SkipNode>,
    /// Primitives of the leaves, each once.
    pub refs: Vec<u32>,
    /// Box of all primitives.
    pub bounds: BoxF,
    /// What came of the build.
    pub stats: AccelStats,
}

impl BvhSkip {
    /// Builds over all primitives with usable bounds.
    pub fn build(prims: &impl PrimSet, options: &AccelOptions) -> Self {
        let start = Instant::now();
        let bvh = Bvh::build(prims, &AccelOptions { max_leaf: options.max_leaf.min(8), ..*options });
        let mut nodes = Vec::with_capacity(2 * bvh.nodes.len());
        if !bvh.nodes.is_empty() {
            add_children(&bvh, 0, &mut nodes);
        }
        let n_bytes = nodes.len() * size_of::<SkipNode>() + bvh.refs.len() * 4;
        let stats = AccelStats { n_nodes: nodes.len(), n_bytes, build_seconds: seconds_since(start), ..bvh.stats };
        Self { nodes, refs: bvh.refs, bounds: bvh.bounds, stats }
    }

    /// Visits leaves along the ray; `visit(first, count, t_max)` gives the depth that still matters, or `None` to stop. Tells whether
    /// it stopped.
    #[inline]
    pub(super) fn walk(&self, ray: &Ray, t_min: f64, t_max: f64, mut visit: impl FnMut(u32, u32, f64) -> Option<f64>) -> bool {
        if self.nodes.is_empty() || !can_meet(ray, t_min, t_max) {
            return false;
        }
        let ray = SlabRay::new(ray, self.bounds.max_abs());
        let (t_min, mut best, mut at) = (t_min.max(0.0), t_max, 0);
        while let Some(node) = self.nodes.get(at) {
            let (near, far) = ray.clip(&BoxF { lo: node.lo, hi: node.hi }, t_min, best);
            if !(near <= far) {
                at = node.skip as usize;
                continue;
            }
            at += 1;
            if node.leaf != 0 {
                match visit(node.leaf & ((1 << COUNT_SHIFT) - 1), node.leaf >> COUNT_SHIFT, best) {
                    Some(t) => best = t,
                    None => return true,
                }
            }
        }
        false
    }
}

/// Appends the children of a node with all that is below them.
fn add_children(bvh: &Bvh, node: usize, out: &mut Vec<SkipNode>) {
    let n = bvh.nodes[node];
    for c in 0..2 {
        let at = out.len();
        let b = n.child_box(c);
        out.push(SkipNode { lo: b.lo, skip: 0, hi: b.hi, leaf: 0 });
        if n.child[c] & BVH_LEAF == 0 {
            add_children(bvh, n.child[c] as usize, out);
        } else if n.count[c] == 0 {
            // The empty sibling of a tree that is one leaf.
            out.pop();
            continue;
        } else {
            out[at].leaf = (n.child[c] ^ BVH_LEAF) | n.count[c] << COUNT_SHIFT;
        }
        out[at].skip = out.len() as u32;
    }
}
