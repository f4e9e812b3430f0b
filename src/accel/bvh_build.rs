//! Building the BVH: SAH over centroids in bins, top down, O(n log n), subtrees in parallel.
//!
//! Source: Wald 2007, "On fast construction of SAH-based bounding volume hierarchies".

use super::bvh::{BVH_LEAF, MAX_DEPTH};
use super::bvh_bins::{BinMap, Bins, Box4, CHUNK, N_BINS, Ref, Scratch, box_of, center, centers_of, partition};
use super::bvh_runs::Runs;
use super::{AccelOptions, AccelStats, BoxF, Bvh, BvhNode, PrimRef, PrimSet, seconds_since};
use rayon::prelude::*;
use std::time::Instant;

/// Nodes with more references build their halves in parallel.
const PARALLEL_LIMIT: usize = 1 << 14;
/// A child: its node or first reference, and its count, as [`BvhNode`] has them.
pub(super) type Child = (u32, u32);

/// A subtree; node indices are relative to its own array, reference indices are final.
#[derive(Default)]
pub(super) struct Subtree {
    pub(super) nodes: Vec<BvhNode>,
    pub(super) n_leaves: usize,
    pub(super) depth: usize,
    pub(super) cost: f64,
}

pub(super) struct Builder {
    pub(super) intersect_cost: f64,
    pub(super) max_leaf: usize,
    pub(super) pack: usize,
    /// Trees over boxes of many primitives: so many bins are not worth it.
    pub(super) few_bins: bool,
    /// Added to side lengths, so that flat and thin boxes have an area.
    pub(super) thin: f64,
    /// 1 / area of the root.
    pub(super) per_root_area: f64,
}

impl Bvh {
    /// Builds over all primitives with usable bounds.
    pub fn build(prims: &impl PrimSet, options: &AccelOptions) -> Self {
        let start = Instant::now();
        let mut runs = if options.in_runs { Runs::new(prims) } else { None };
        let mut all = if runs.is_none() { usable_refs(prims) } else { Vec::new() };
        let refs = runs.as_ref().map_or(&all, |r| &r.refs);
        let n = refs.len();
        let bounds = box_of(refs).to_boxf();
        let mut tree = Subtree::default();
        if n > 0 {
            let thin = 1e-6 * (0..3).map(|k| f64::from(bounds.hi[k]) - f64::from(bounds.lo[k])).fold(1e-100, f64::max);
            let mut b = Builder {
                intersect_cost: options.intersect_cost,
                max_leaf: options.max_leaf.max(1),
                pack: options.pack.max(1),
                few_bins: false,
                thin,
                per_root_area: 1.0,
            };
            b.per_root_area = 1.0 / b.area(&bounds);
            let (child, count) = match &mut runs {
                Some(runs) => b.in_runs(runs, &bounds, &mut tree),
                None => b.node(&mut all, 0, &bounds, 0, &mut tree, &mut Scratch::new()),
            };
            if tree.nodes.is_empty() {
                // All in one leaf: its sibling is a point without primitives.
                let point = BoxF { lo: bounds.lo, hi: bounds.lo };
                tree.nodes.push(BvhNode::new([(bounds, child, count), (point, BVH_LEAF, 0)]));
                tree.depth = 1;
            }
        }
        let stats = AccelStats {
            n_prims: prims.len(),
            n_skipped: prims.len() - n,
            n_nodes: tree.nodes.len(),
            n_leaves: tree.n_leaves,
            n_refs: n,
            depth: tree.depth,
            sah_cost: tree.cost,
            build_seconds: seconds_since(start),
            n_bytes: tree.nodes.len() * size_of::<BvhNode>() + n * 4,
        };
        let refs = runs.map_or(all, |r| r.refs);
        Self { nodes: tree.nodes, refs: refs.iter().map(Ref::prim).collect(), bounds, stats }
    }
}

/// The primitives that can be built over, their boxes rounded outward.
fn usable_refs(prims: &impl PrimSet) -> Vec<Ref> {
    let of = |k: usize| Ref::new(&PrimRef { bounds: prims.boxed(k).unwrap_or(BoxF::EMPTY), prim: k as u32 });
    // Written where they stay; few sets have primitives that are left out.
    let mut all = Vec::new();
    if prims.len() > CHUNK {
        (0..prims.len()).into_par_iter().map(of).collect_into_vec(&mut all);
    } else {
        all.extend((0..prims.len()).map(of));
    }
    all.retain(|r| !r.bounds().is_empty());
    all
}

impl Builder {
    #[inline]
    pub(super) fn area(&self, b: &BoxF) -> f64 {
        let s: [f64; 3] = std::array::from_fn(|k| f64::from(b.hi[k]) - f64::from(b.lo[k]) + self.thin);
        s[0] * s[1] + s[1] * s[2] + s[2] * s[0]
    }

    /// Cost of a leaf: packs are tested at once.
    #[inline]
    pub(super) fn leaf_cost(&self, n: usize) -> f64 {
        self.intersect_cost * n.div_ceil(self.pack) as f64
    }

    /// Bins of an axis for a node of `n`. Where packs end the tree early, few do as well for small nodes, and most nodes are small.
    #[inline]
    fn n_bins(&self, n: usize) -> usize {
        let n_bins = if self.few_bins {
            3 + n
        } else if self.pack > 1 {
            4 + n / 4
        } else {
            4 + 2 * n
        };
        n_bins.min(N_BINS)
    }

    /// Appends the subtree of `refs`, whose first stands at `first` in the whole list and whose box is `bounds`.
    pub(super) fn node(
        &self,
        refs: &mut [Ref],
        first: usize,
        bounds: &BoxF,
        depth: usize,
        out: &mut Subtree,
        scratch: &mut Scratch,
    ) -> Child {
        let n = refs.len();
        let share = self.area(bounds) * self.per_root_area;
        let Some(split) = self.divide(refs, bounds, depth, scratch) else {
            out.n_leaves += 1;
            out.depth = out.depth.max(depth);
            out.cost += share * self.leaf_cost(n);
            return (BVH_LEAF | first as u32, n as u32);
        };
        out.cost += share;
        let at = out.nodes.len();
        out.nodes.push(BvhNode::default());
        let (left, right) = refs.split_at_mut(split.n_left);
        let (box_left, box_right) = (split.left, split.right);
        let first_right = first + split.n_left;
        let (a, b) = if n > PARALLEL_LIMIT {
            let (a, b) =
                rayon::join(|| self.subtree(left, first, &box_left, depth + 1), || self.subtree(right, first_right, &box_right, depth + 1));
            (out.append(a), out.append(b))
        } else {
            (self.node(left, first, &box_left, depth + 1, out, scratch), self.node(right, first_right, &box_right, depth + 1, out, scratch))
        };
        out.nodes[at] = BvhNode::new([(box_left, a.0, a.1), (box_right, b.0, b.1)]);
        (at as u32, 0)
    }

    fn subtree(&self, refs: &mut [Ref], first: usize, bounds: &BoxF, depth: usize) -> (Subtree, Child) {
        let mut t = Subtree { nodes: Vec::with_capacity(refs.len() / 2), ..Subtree::default() };
        let child = self.node(refs, first, bounds, depth, &mut t, &mut Scratch::new());
        (t, child)
    }

    /// Puts the references of the two children in order; `None` makes a leaf.
    fn divide(&self, refs: &mut [Ref], bounds: &BoxF, depth: usize, scratch: &mut Scratch) -> Option<Division> {
        let n = refs.len();
        if n == 1 {
            return None;
        }
        let centers = centers_of(refs);
        // From here on halves are needed to stay within the deepest level.
        let must_halve = depth + (usize::BITS - (n - 1).leading_zeros()) as usize >= MAX_DEPTH;
        if !must_halve && let Some(bins) = BinMap::new(&centers, self.n_bins(n)) {
            let best = self.cheapest(&bins, refs, bounds, scratch);
            if n <= self.max_leaf && best.cost >= self.leaf_cost(n) {
                return None;
            }
            let n_left = partition(refs, |r| bins.bins(r)[best.axis] < best.bin as i32);
            if (1..n).contains(&n_left) {
                return Some(Division { n_left, left: best.left, right: best.right });
            }
        }
        if n <= self.max_leaf {
            return None;
        }
        // All in one place, or too deep: halves along the longest side.
        let axis = (0..3).max_by(|a, b| (centers.hi[*a] - centers.lo[*a]).total_cmp(&(centers.hi[*b] - centers.lo[*b]))).unwrap_or(0);
        refs.select_nth_unstable_by(n / 2, |a, b| center(a, axis).total_cmp(&center(b, axis)).then(a.prim().cmp(&b.prim())));
        Some(Division::new(refs, n / 2))
    }

    fn cheapest(&self, map: &BinMap, refs: &[Ref], bounds: &BoxF, scratch: &mut Scratch) -> Boundary {
        let Scratch { bins, above } = scratch;
        if refs.len() > CHUNK {
            let count = |c: &[Ref]| {
                let mut bins = Box::new(Bins::empty());
                bins.count(map, c);
                bins
            };
            **bins = *refs.par_chunks(CHUNK).map(count).reduce(|| Box::new(Bins::empty()), Bins::merged);
        } else {
            bins.count(map, refs);
        }
        let scale = self.intersect_cost / self.area(bounds);
        let n_tests = |n: u32| f64::from(n.div_ceil(self.pack as u32));
        let mut best = Boundary { cost: f64::INFINITY, axis: 0, bin: 0, left: BoxF::EMPTY, right: BoxF::EMPTY };
        for axis in 0..3 {
            let (boxes, counts) = (&bins.boxes[axis][..map.n_bins], &bins.counts[axis][..map.n_bins]);
            let (mut right, mut n) = (Box4::EMPTY, 0);
            for i in (1..map.n_bins).rev() {
                right.grow(&boxes[i]);
                n += counts[i];
                let cost = if n > 0 { self.area4(&right) * n_tests(n) } else { f64::INFINITY };
                above[i] = (right, cost);
            }
            let (mut left, mut n) = (Box4::EMPTY, 0);
            for i in 1..map.n_bins {
                left.grow(&boxes[i - 1]);
                n += counts[i - 1];
                if n > 0 {
                    let cost = 1.0 + scale * (self.area4(&left) * n_tests(n) + above[i].1);
                    if cost < best.cost {
                        best = Boundary { cost, axis, bin: i, left: left.to_boxf(), right: above[i].0.to_boxf() };
                    }
                }
            }
        }
        best
    }

    #[inline]
    fn area4(&self, b: &Box4) -> f64 {
        self.area(&b.to_boxf())
    }
}

/// Where a node's references part: those in lower bins go left.
struct Boundary {
    cost: f64,
    axis: usize,
    bin: usize,
    left: BoxF,
    right: BoxF,
}

/// A node's references in two parts.
struct Division {
    n_left: usize,
    left: BoxF,
    right: BoxF,
}

impl Division {
    fn new(refs: &[Ref], n_left: usize) -> Self {
        Self { n_left, left: box_of(&refs[..n_left]).to_boxf(), right: box_of(&refs[n_left..]).to_boxf() }
    }
}

impl Subtree {
    /// Takes in another subtree; gives its root as seen from here.
    fn append(&mut self, (other, root): (Subtree, Child)) -> Child {
        let base = self.nodes.len() as u32;
        let shift = |child: u32| if child & BVH_LEAF == 0 { child + base } else { child };
        self.nodes.extend(other.nodes.iter().map(|n| BvhNode { child: n.child.map(shift), ..*n }));
        self.n_leaves += other.n_leaves;
        self.depth = self.depth.max(other.depth);
        self.cost += other.cost;
        (shift(root.0), root.1)
    }
}
