//! Building the wide BVH: a BVH of two children is opened, largest box first, until a node has eight.

use super::bvh::BvhChild;
use super::wide::{WIDE_LEAF, WideBvh, WideNode};
use super::{AccelOptions, AccelStats, BVH_LEAF, BoxF, Bvh, PrimSet, seconds_since};
use std::time::Instant;

struct Builder<'a> {
    bvh: &'a Bvh,
    nodes: Vec<WideNode>,
    refs: Vec<u32>,
    n_leaves: usize,
    depth: usize,
}

impl WideBvh {
    /// Builds over all primitives with usable bounds.
    pub fn build(prims: &impl PrimSet, options: &AccelOptions) -> Self {
        let start = Instant::now();
        let bvh = Bvh::build(prims, &AccelOptions { max_leaf: options.max_leaf.min(WIDE_LEAF), ..*options });
        let mut b = Builder { bvh: &bvh, nodes: Vec::new(), refs: Vec::with_capacity(bvh.refs.len()), n_leaves: 0, depth: 0 };
        if !bvh.nodes.is_empty() {
            b.nodes.push(WideNode::default());
            b.node(0, 0, 1);
        }
        let Builder { nodes, refs, n_leaves, depth, .. } = b;
        let n_bytes = nodes.len() * size_of::<WideNode>() + refs.len() * 4;
        let stats = AccelStats { n_nodes: nodes.len(), n_leaves, depth, n_bytes, build_seconds: seconds_since(start), ..bvh.stats };
        Self { nodes, refs, bounds: bvh.bounds, stats }
    }
}

impl Builder<'_> {
    /// Fills node `at` with what comes of opening a binary node.
    fn node(&mut self, at: usize, node_ix: u32, depth: usize) {
        self.depth = self.depth.max(depth);
        let children = self.bvh.opened::<8>(node_ix);
        let all = children.iter().fold(BoxF::EMPTY, |b, c| b.merged(c.bounds));
        let mut node = WideNode { origin: all.lo.map(f32::to_bits), first_ref: self.refs.len() as u32, ..WideNode::default() };
        for k in 0..3 {
            node.exponents_inner[k] = exponent(all.lo[k], all.hi[k]);
        }
        let slots = in_octants(&children, &all);
        let mut inner = Vec::new();
        for (slot, child) in slots.iter().enumerate() {
            let Some(c) = child.map(|k| children[k]) else { continue };
            for k in 0..3 {
                let (lo, step) = (f64::from(all.lo[k]), f64::from(node.step(k)));
                node.lo[k][slot] = ((f64::from(c.bounds.lo[k]) - lo) / step).floor().clamp(0.0, 255.0) as u8;
                node.hi[k][slot] = ((f64::from(c.bounds.hi[k]) - lo) / step).ceil().clamp(0.0, 255.0) as u8;
            }
            if c.is_inner() {
                node.exponents_inner[3] |= 1 << slot;
                node.meta[slot] = 0b0011_1000 | slot as u8;
                inner.push(c.child);
            } else {
                let place = self.refs.len() as u32 - node.first_ref;
                node.meta[slot] = ((1 << c.count) - 1) << 5 | place as u8;
                let first = (c.child ^ BVH_LEAF) as usize;
                self.refs.extend_from_slice(&self.bvh.refs[first..first + c.count as usize]);
                self.n_leaves += 1;
            }
        }
        node.first_child = self.nodes.len() as u32;
        self.nodes[at] = node;
        let first = self.nodes.len();
        self.nodes.resize(first + inner.len(), WideNode::default());
        for (k, child) in inner.into_iter().enumerate() {
            self.node(first + k, child, depth + 1);
        }
    }
}

/// Smallest biased exponent whose 255 steps from `lo` reach `hi`.
fn exponent(lo: f32, hi: f32) -> u8 {
    let reach = |e: u8| 255.0 * f64::from(f32::from_bits(u32::from(e) << 23)) >= f64::from(hi) - f64::from(lo);
    let guess = (((f64::from(hi) - f64::from(lo)) / 255.0).log2().ceil() + 127.0).clamp(1.0, 254.0) as u8;
    let mut e = guess.saturating_sub(1).max(1);
    while !reach(e) && e < 254 {
        e += 1;
    }
    e
}

/// Slot by slot, the child in it: children that lie most decidedly in an octant are placed first.
fn in_octants(children: &[BvhChild], all: &BoxF) -> [Option<usize>; 8] {
    let middle = |b: &BoxF, k: usize| f64::from(b.lo[k]) + f64::from(b.hi[k]);
    let gain = |child: usize, slot: usize| -> f64 {
        let toward = |k: usize| if slot >> k & 1 == 1 { 1.0 } else { -1.0 };
        (0..3).map(|k| toward(k) * (middle(&children[child].bounds, k) - middle(all, k))).sum()
    };
    let mut pairs: Vec<(f64, usize, usize)> =
        (0..children.len()).flat_map(|c| (0..8).map(move |s| (c, s))).map(|(c, s)| (gain(c, s), c, s)).collect();
    pairs.sort_by(|a, b| b.0.total_cmp(&a.0).then((a.1, a.2).cmp(&(b.1, b.2))));
    let mut slots = [None; 8];
    let mut placed = [false; 8];
    for (_, c, s) in pairs {
        if !placed[c] && slots[s].is_none() {
            (placed[c], slots[s]) = (true, Some(c));
        }
    }
    slots
}
