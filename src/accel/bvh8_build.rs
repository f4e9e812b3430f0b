//! Building the wide BVH: a binary one, its nodes opened until each holds eight children.

use super::bvh::BVH_LEAF;
use super::bvh8::{BVH8_LEAF, Bvh8, Bvh8Node, NO_PRIM, PACK, WIDTH, leaf_slots};
use super::{AccelOptions, AccelStats, Bvh, PrimSet, seconds_since};
use std::time::Instant;

struct Collapse<'b> {
    binary: &'b Bvh,
    nodes: Vec<Bvh8Node>,
    slots: Vec<u32>,
    depth: usize,
}

impl Bvh8 {
    /// Builds over all primitives with usable bounds.
    pub fn build(prims: &impl PrimSet, options: &AccelOptions) -> Self {
        let start = Instant::now();
        let max_leaf = options.max_leaf.min(PACK);
        let options = AccelOptions { max_leaf, pack: options.pack.min(max_leaf), ..*options };
        let binary = Bvh::build(prims, &options);
        let n_inner = binary.nodes.len();
        let mut c = Collapse {
            binary: &binary,
            nodes: Vec::with_capacity(n_inner / 3),
            slots: Vec::with_capacity(2 * binary.refs.len()),
            depth: 0,
        };
        if n_inner > 0 {
            c.node(0, 1);
        }
        let Collapse { nodes, slots, depth, .. } = c;
        let n_bytes = nodes.len() * size_of::<Bvh8Node>() + slots.len() * 4;
        let stats = AccelStats { n_nodes: nodes.len(), depth, n_bytes, build_seconds: seconds_since(start), ..binary.stats };
        let is_single = nodes.iter().all(|n| n.child.iter().all(|c| *c & BVH8_LEAF == 0 || leaf_slots(*c).1 == 1));
        let max_abs = binary.bounds.max_abs() as f32;
        Self { nodes, slots, bounds: binary.bounds, max_abs, is_single, stats }
    }
}

impl Collapse<'_> {
    /// Appends the wide node in place of a binary one; gives its index.
    fn node(&mut self, node_ix: u32, depth: usize) -> u32 {
        self.depth = self.depth.max(depth);
        let open = self.binary.opened::<WIDTH>(node_ix);
        let at = self.nodes.len();
        self.nodes.push(Bvh8Node::EMPTY);
        for (c, o) in open.iter().enumerate() {
            if o.is_inner() {
                let inner = self.node(o.child, depth + 1);
                self.nodes[at].set(c, &o.bounds, inner);
            } else {
                let first = (o.child ^ BVH_LEAF) as usize;
                let slot = self.slots.len();
                self.slots.extend_from_slice(&self.binary.refs[first..first + o.count as usize]);
                self.slots.resize(slot + PACK, NO_PRIM);
                self.nodes[at].set(c, &o.bounds, BVH8_LEAF | slot as u32 | (o.count - 1));
            }
        }
        at as u32
    }
}
