//! Building the wide BVH: a binary one, its nodes opened until each holds eight children.

use super::bvh::BVH_LEAF;
use super::bvh8::{BVH8_LEAF, Bvh8, Bvh8Node, NO_PRIM, PACK, WIDTH};
use super::{AccelOptions, AccelStats, BoxF, Bvh, PrimSet, seconds_since};
use std::time::Instant;

/// A child of a binary node: box, and `child` and `count` as there.
type Binary = (BoxF, u32, u32);

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
        // A pack is tested at once: a full leaf costs little more than one primitive.
        let options = AccelOptions { max_leaf: options.max_leaf.min(PACK), ..*options };
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
        Self { nodes, slots, bounds: binary.bounds, stats }
    }
}

impl Collapse<'_> {
    fn children(&self, node_ix: u32) -> [Binary; 2] {
        let n = &self.binary.nodes[node_ix as usize];
        [0, 1].map(|c| (n.child_box(c), n.child[c], n.count[c]))
    }

    /// Appends the wide node in place of a binary one; gives its index.
    fn node(&mut self, node_ix: u32, depth: usize) -> u32 {
        self.depth = self.depth.max(depth);
        let mut open = [(BoxF::EMPTY, BVH_LEAF, 0); WIDTH];
        let mut n = 2;
        open[..2].copy_from_slice(&self.children(node_ix));
        // The largest inner child is the one that rays most likely go into.
        while n < WIDTH {
            let inner = (0..n).filter(|c| open[*c].1 & BVH_LEAF == 0);
            let Some(c) = inner.max_by(|a, b| open[*a].0.half_area().total_cmp(&open[*b].0.half_area())) else { break };
            let [a, b] = self.children(open[c].1);
            open[c] = a;
            open[n] = b;
            n += 1;
        }
        let at = self.nodes.len();
        self.nodes.push(Bvh8Node::EMPTY);
        for (c, (bounds, child, count)) in open[..n].iter().enumerate() {
            if child & BVH_LEAF == 0 {
                let inner = self.node(*child, depth + 1);
                self.nodes[at].set(c, bounds, inner, 0);
            } else if *count > 0 {
                let first = (child ^ BVH_LEAF) as usize;
                let slot = self.slots.len();
                self.slots.extend_from_slice(&self.binary.refs[first..first + *count as usize]);
                self.slots.resize(slot + PACK, NO_PRIM);
                self.nodes[at].set(c, bounds, BVH8_LEAF | slot as u32, *count);
            }
        }
        at as u32
    }
}
