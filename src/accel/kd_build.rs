//! Building the kd-tree: SAH over the edges of clipped boxes, O(n log n), subtrees in parallel.
//!
//! Small nodes try every edge; large ones count edges in bins and try every edge of the two bins around the best boundary, which
//! finds the plane that a full sweep finds in all but contrived cases. Source: Wald, Havran 2006; Pharr, Jakob, Humphreys 2016, 4.4.

use super::kd::MAX_DEPTH;
use super::{AccelOptions, AccelStats, BoxF, KdNode, KdTree, KdWalk, PrimRef, PrimSet, box_of, seconds_since, usable_prims};
use std::time::Instant;

/// Bins of an axis in large nodes.
const N_BINS: usize = 64;
/// Nodes with more references are binned first.
const SWEEP_LIMIT: usize = 128;
/// Nodes with more references build their halves in parallel.
const PARALLEL_LIMIT: usize = 4096;
/// A split that cuts off empty space costs this share. Source: Wald, Havran 2006.
const EMPTY_BONUS: f64 = 0.8;
/// Steps that may make things worse in a row, in hope of better ones below.
const MAX_BAD_SPLITS: u32 = 3;

/// A plane with its cost.
#[derive(Clone, Copy)]
struct Split {
    axis: usize,
    at: f32,
    cost: f64,
    /// Flat things in the plane go below.
    flat_below: bool,
}

/// A subtree; indices are relative to its own arrays.
#[derive(Default)]
struct Subtree {
    nodes: Vec<KdNode>,
    refs: Vec<u32>,
    n_leaves: usize,
    depth: usize,
    cost: f64,
}

struct Builder<'a, P> {
    prims: &'a P,
    intersect_cost: f64,
    max_depth: usize,
    /// Added to side lengths, so that flat and thin cells have an area.
    thin: f64,
    /// 1 / area of the root.
    per_root_area: f64,
}

impl KdTree {
    /// Builds over all primitives with usable bounds.
    pub fn build(prims: &impl PrimSet, options: &AccelOptions) -> Self {
        let start = Instant::now();
        let refs = usable_prims(prims);
        let bounds = box_of(&refs);
        let n = refs.len();
        let mut tree = Subtree::default();
        if n > 0 {
            let thin = 1e-6 * (0..3).map(|k| f64::from(bounds.hi[k]) - f64::from(bounds.lo[k])).fold(1e-100, f64::max);
            let mut b = Builder {
                prims,
                intersect_cost: options.intersect_cost,
                max_depth: (12.0 + 1.6 * (n as f64).log2()).min(MAX_DEPTH as f64) as usize,
                thin,
                per_root_area: 1.0,
            };
            b.per_root_area = 1.0 / b.area(&bounds);
            let spare = (n as f64 * (options.max_refs_per_prim - 1.0)).clamp(0.0, 1e9) as usize + 256;
            b.node(refs, bounds, 0, 0, spare, &mut tree);
        }
        let stats = AccelStats {
            n_prims: prims.len(),
            n_skipped: prims.len() - n,
            n_nodes: tree.nodes.len(),
            n_leaves: tree.n_leaves,
            n_refs: tree.refs.len(),
            depth: tree.depth,
            sah_cost: tree.cost,
            build_seconds: seconds_since(start),
            n_bytes: tree.nodes.len() * size_of::<KdNode>() + tree.refs.len() * 4,
        };
        Self { walk: KdWalk::default(), nodes: tree.nodes, refs: tree.refs, bounds, stats }
    }
}

impl<P: PrimSet> Builder<'_, P> {
    fn area(&self, b: &BoxF) -> f64 {
        let s: [f64; 3] = std::array::from_fn(|k| f64::from(b.hi[k]) - f64::from(b.lo[k]) + self.thin);
        s[0] * s[1] + s[1] * s[2] + s[2] * s[0]
    }

    /// Appends the subtree of `refs` in `cell`; `spare` is how many references more than these it may hold.
    fn node(&self, refs: Vec<PrimRef>, cell: BoxF, depth: usize, bad_splits: u32, spare: usize, out: &mut Subtree) {
        let n = refs.len();
        let leaf_cost = self.intersect_cost * n as f64;
        let area = self.area(&cell);
        let share = area * self.per_root_area;
        let split = if n > 1 && depth < self.max_depth { self.find_split(&refs, &cell) } else { None };
        let split = split.filter(|s| {
            let bad = bad_splits + u32::from(s.cost >= leaf_cost);
            bad < MAX_BAD_SPLITS && !(s.cost > 4.0 * leaf_cost && n < 16) && !(s.cost >= leaf_cost && n < 4)
        });
        let halves = split.and_then(|s| {
            let (below, above) = self.divide(&refs, &cell, &s);
            let extra = (below.len() + above.len()).saturating_sub(n);
            let stuck = below.len() == n && above.len() == n;
            (extra <= spare && !stuck).then(|| (s, below, above, spare - extra))
        });
        let Some((s, below, above, spare)) = halves else {
            out.nodes.push(KdNode::leaf(out.refs.len() as u32, n as u32));
            out.refs.extend(refs.iter().map(|r| r.prim));
            out.n_leaves += 1;
            out.depth = out.depth.max(depth);
            out.cost += share * leaf_cost;
            return;
        };
        drop(refs);
        out.cost += share;
        let bad = bad_splits + u32::from(s.cost >= leaf_cost);
        let (mut cell_below, mut cell_above) = (cell, cell);
        cell_below.hi[s.axis] = s.at;
        cell_above.lo[s.axis] = s.at;
        let total = (below.len() + above.len()).max(1);
        let spare_below = (spare as u64 * below.len() as u64 / total as u64) as usize;
        let at = out.nodes.len();
        out.nodes.push(KdNode::default());
        if n > PARALLEL_LIMIT {
            let (a, b) = rayon::join(
                || self.subtree(below, cell_below, depth + 1, bad, spare_below),
                || self.subtree(above, cell_above, depth + 1, bad, spare - spare_below),
            );
            out.append(a);
            out.nodes[at] = KdNode::inner(s.axis, s.at, out.nodes.len() as u32);
            out.append(b);
        } else {
            self.node(below, cell_below, depth + 1, bad, spare_below, out);
            out.nodes[at] = KdNode::inner(s.axis, s.at, out.nodes.len() as u32);
            self.node(above, cell_above, depth + 1, bad, spare - spare_below, out);
        }
    }

    fn subtree(&self, refs: Vec<PrimRef>, cell: BoxF, depth: usize, bad_splits: u32, spare: usize) -> Subtree {
        let mut t = Subtree::default();
        self.node(refs, cell, depth, bad_splits, spare, &mut t);
        t
    }

    /// The references of both sides; those across the plane are clipped to each.
    fn divide(&self, refs: &[PrimRef], cell: &BoxF, s: &Split) -> (Vec<PrimRef>, Vec<PrimRef>) {
        let (mut below, mut above) = (Vec::with_capacity(refs.len() / 2 + 8), Vec::with_capacity(refs.len() / 2 + 8));
        let (mut cell_below, mut cell_above) = (*cell, *cell);
        cell_below.hi[s.axis] = s.at;
        cell_above.lo[s.axis] = s.at;
        let (bounds_below, bounds_above) = (cell_below.to_bounds(), cell_above.to_bounds());
        for r in refs {
            let (lo, hi) = (r.bounds.lo[s.axis], r.bounds.hi[s.axis]);
            if lo == s.at && hi == s.at {
                if s.flat_below { &mut below } else { &mut above }.push(*r);
            } else if hi <= s.at {
                below.push(*r);
            } else if lo >= s.at {
                above.push(*r);
            } else {
                for (side, cell, bounds) in [(&mut below, &cell_below, &bounds_below), (&mut above, &cell_above, &bounds_above)] {
                    let clipped = BoxF::around(&self.prims.clipped_bounds(r.prim as usize, bounds));
                    if let Some(b) = clipped.and_then(|b| b.intersection(&r.bounds)).and_then(|b| b.intersection(cell)) {
                        side.push(PrimRef { bounds: b, prim: r.prim });
                    }
                }
            }
        }
        (below, above)
    }

    fn find_split(&self, refs: &[PrimRef], cell: &BoxF) -> Option<Split> {
        let sweep = Sweep::new(self, cell, refs.len());
        let mut best = None;
        let (mut starts, mut ends) = (Vec::with_capacity(refs.len()), Vec::with_capacity(refs.len()));
        if refs.len() <= SWEEP_LIMIT {
            for axis in 0..3 {
                starts.clear();
                ends.clear();
                starts.extend(refs.iter().map(|r| r.bounds.lo[axis]));
                ends.extend(refs.iter().map(|r| r.bounds.hi[axis]));
                sweep.edges(axis, &mut starts, &mut ends, 0, 0, &mut best);
            }
            return best;
        }
        let bins = Bins::count(refs, cell);
        let mut rough: Option<(usize, usize, f64)> = None;
        for axis in 0..3 {
            let (mut n_started, mut n_ended) = (0, 0);
            for b in 1..N_BINS {
                n_started += bins.starts[axis][b - 1];
                n_ended += bins.ends[axis][b - 1];
                let Some(at) = bins.boundary(axis, b) else { continue };
                let cost = sweep.cost(axis, at, n_started, refs.len() - n_ended);
                if rough.is_none_or(|r| cost < r.2) {
                    rough = Some((axis, b, cost));
                }
            }
        }
        let (axis, b, _) = rough?;
        let before = |counts: &[usize; N_BINS]| counts[..b - 1].iter().sum::<usize>();
        let (n_started, n_ended) = (before(&bins.starts[axis]), before(&bins.ends[axis]));
        let around = |v: f32| (b - 1..=b).contains(&bins.bin(axis, v));
        starts.extend(refs.iter().map(|r| r.bounds.lo[axis]).filter(|v| around(*v)));
        ends.extend(refs.iter().map(|r| r.bounds.hi[axis]).filter(|v| around(*v)));
        sweep.edges(axis, &mut starts, &mut ends, n_started, n_ended, &mut best);
        // The boundary itself, counted exactly.
        if let Some(at) = bins.boundary(axis, b) {
            let n_below = refs.iter().filter(|r| r.bounds.lo[axis] < at).count();
            let n_above = refs.iter().filter(|r| r.bounds.hi[axis] > at).count();
            sweep.offer(axis, at, n_below, n_above, &mut best);
        }
        best
    }
}

/// Costs of planes through one cell.
struct Sweep {
    cell: BoxF,
    n: usize,
    sides: [f64; 3],
    per_area: f64,
    intersect_cost: f64,
}

impl Sweep {
    fn new<P: PrimSet>(b: &Builder<'_, P>, cell: &BoxF, n: usize) -> Self {
        let sides = std::array::from_fn(|k| f64::from(cell.hi[k]) - f64::from(cell.lo[k]) + b.thin);
        Self { cell: *cell, n, sides, per_area: 1.0 / b.area(cell), intersect_cost: b.intersect_cost }
    }

    #[inline]
    fn cost(&self, axis: usize, at: f32, n_below: usize, n_above: usize) -> f64 {
        let (u, v) = (self.sides[(axis + 1) % 3], self.sides[(axis + 2) % 3]);
        let below = f64::from(at) - f64::from(self.cell.lo[axis]);
        let above = f64::from(self.cell.hi[axis]) - f64::from(at);
        let (cap, rim) = (u * v, u + v);
        let bonus = if n_below == 0 || n_above == 0 { EMPTY_BONUS } else { 1.0 };
        let hits = (cap + rim * below) * n_below as f64 + (cap + rim * above) * n_above as f64;
        1.0 + self.intersect_cost * bonus * hits * self.per_area
    }

    /// Keeps the plane if it is the best; flat things in it are those that neither side counts.
    #[inline]
    fn offer(&self, axis: usize, at: f32, n_below: usize, n_above: usize, best: &mut Option<Split>) {
        if !(at > self.cell.lo[axis] && at < self.cell.hi[axis]) {
            return;
        }
        let n_flat = self.n.saturating_sub(n_below + n_above);
        let (mut cost, mut flat_below) = (self.cost(axis, at, n_below + n_flat, n_above), true);
        if n_flat > 0 {
            let other = self.cost(axis, at, n_below, n_above + n_flat);
            if other < cost {
                (cost, flat_below) = (other, false);
            }
        }
        if best.is_none_or(|b| cost < b.cost) {
            *best = Some(Split { axis, at, cost, flat_below });
        }
    }

    /// Tries every edge; `n_started` and `n_ended` lie before all of them.
    fn edges(&self, axis: usize, starts: &mut [f32], ends: &mut [f32], n_started: usize, n_ended: usize, best: &mut Option<Split>) {
        starts.sort_unstable_by(f32::total_cmp);
        ends.sort_unstable_by(f32::total_cmp);
        let (mut i, mut j) = (0, 0);
        while i < starts.len() || j < ends.len() {
            let at = match (starts.get(i), ends.get(j)) {
                (Some(a), Some(b)) => a.min(*b),
                (Some(a), None) => *a,
                (None, Some(b)) => *b,
                (None, None) => break,
            };
            let n_below = n_started + i;
            // `<=` on values, so that -0 and 0 are one edge.
            while starts.get(i).is_some_and(|v| *v <= at) {
                i += 1;
            }
            while ends.get(j).is_some_and(|v| *v <= at) {
                j += 1;
            }
            // Started before, not ended up to here: everything whose end lies beyond.
            let n_above = self.n - (n_ended + j);
            self.offer(axis, at, n_below, n_above, best);
        }
    }
}

/// Counts of edges in bins over a cell.
struct Bins {
    lo: [f32; 3],
    /// Bins a unit; in double precision, or it would overflow in tiny cells.
    scale: [f64; 3],
    hi: [f32; 3],
    starts: [[usize; N_BINS]; 3],
    ends: [[usize; N_BINS]; 3],
}

impl Bins {
    fn count(refs: &[PrimRef], cell: &BoxF) -> Self {
        let scale = std::array::from_fn(|k| {
            let s = N_BINS as f64 / (f64::from(cell.hi[k]) - f64::from(cell.lo[k]));
            if s.is_finite() { s } else { 0.0 }
        });
        let mut b = Self { lo: cell.lo, hi: cell.hi, scale, starts: [[0; N_BINS]; 3], ends: [[0; N_BINS]; 3] };
        for r in refs {
            for k in 0..3 {
                let (s, e) = (b.bin(k, r.bounds.lo[k]), b.bin(k, r.bounds.hi[k]));
                b.starts[k][s] += 1;
                b.ends[k][e] += 1;
            }
        }
        b
    }

    #[inline]
    fn bin(&self, axis: usize, v: f32) -> usize {
        (((f64::from(v) - f64::from(self.lo[axis])) * self.scale[axis]) as usize).min(N_BINS - 1)
    }

    /// Lower end of bin `b`, when it lies inside the cell.
    fn boundary(&self, axis: usize, b: usize) -> Option<f32> {
        let t = b as f32 / N_BINS as f32;
        let at = self.lo[axis] * (1.0 - t) + self.hi[axis] * t;
        (self.scale[axis] > 0.0 && at > self.lo[axis] && at < self.hi[axis]).then_some(at)
    }
}

impl Subtree {
    fn append(&mut self, other: Subtree) {
        let (node_base, ref_base) = (self.nodes.len() as u32, self.refs.len() as u32);
        self.nodes.extend(other.nodes.iter().map(|n| {
            if n.is_leaf() {
                KdNode::leaf(n.split_or_first + ref_base, n.above_or_count())
            } else {
                KdNode::inner(n.axis(), n.split(), n.above_or_count() + node_base)
            }
        }));
        self.refs.extend(other.refs);
        self.n_leaves += other.n_leaves;
        self.depth = self.depth.max(other.depth);
        self.cost += other.cost;
    }
}
