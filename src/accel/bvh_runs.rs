//! Building the BVH of many primitives in half the time or less: those that follow each other along a space-filling curve are put into runs, the
//! upper tree is built over runs by SAH, and runs are parted where their order is.
//!
//! The upper levels decide what a ray costs, the lower ones what a build costs. Source: Lauterbach et al. 2009 ("Fast BVH Construction on GPUs", the
//! curve); Pantaleoni and Luebke 2010 (HLBVH, SAH above it).

use super::bvh::MAX_DEPTH;
use super::bvh_bins::{Box4, CHUNK, Ref, Scratch, box_of};
use super::bvh_build::{Builder, Child, Subtree};
use super::{BVH_LEAF, BoxF, BvhNode, PrimRef, PrimSet};
use glam::Vec4;
use rayon::prelude::*;
use std::ops::Range;

/// Fewer primitives are built over by SAH alone.
const LEAST: usize = 1 << 13;
/// Most primitives of a run, but for those whose place on the curve is one.
const LONGEST: usize = 32;
/// Longer runs stand for primitives that the curve cannot tell apart: SAH does.
const TOO_LONG: usize = 1 << 20;
/// Bits of the curve for each axis.
const BITS: u32 = 10;
/// Levels that are kept for what is below the runs.
const LEVELS_BELOW: usize = 24;
/// Of what is no place.
const NO_PLACE: u64 = u64::MAX;
/// Runs that a thread takes up at once.
const GROUP: usize = 1 << 11;

/// Spreads ten bits so that two are free after each.
#[inline(always)]
fn spread(v: u32) -> u32 {
    let v = (v | v << 16) & 0x0300_00ff;
    let v = (v | v << 8) & 0x0300_f00f;
    let v = (v | v << 4) & 0x030c_30c3;
    (v | v << 2) & 0x0924_9249
}

/// Places along the curve, above the number of each primitive; those of no use are left out.
fn places(prims: &impl PrimSet) -> Vec<u64> {
    let center = |k: usize| prims.boxed(k).map(|b| Vec4::new(b.lo[0] + b.hi[0], b.lo[1] + b.hi[1], b.lo[2] + b.hi[2], 0.0));
    let all = (0..prims.len()).into_par_iter().with_min_len(CHUNK);
    let grown = |(lo, hi): (Vec4, Vec4), (a, b): (Vec4, Vec4)| (lo.min(a), hi.max(b));
    let none = || (Vec4::INFINITY, Vec4::NEG_INFINITY);
    let (lo, hi) = all.clone().fold(none, |b, k| center(k).map_or(b, |c| grown(b, (c, c)))).reduce(none, grown);
    // Cells are cubes. Just below, so that the last one is the last cell.
    let scale = ((1 << BITS) as f32 * 0.999_99 / (hi - lo).truncate().max_element()).min(f32::MAX);
    let place = |k: usize| {
        let Some(c) = center(k) else { return NO_PLACE };
        let cell = ((c - lo) * scale).to_array().map(|v| (v as i32 as u32).min((1 << BITS) - 1));
        u64::from(spread(cell[0]) | spread(cell[1]) << 1 | spread(cell[2]) << 2) << 32 | k as u64
    };
    let mut places = Vec::new();
    all.map(place).collect_into_vec(&mut places);
    places.retain(|p| *p != NO_PLACE);
    places
}

/// Sorts by the upper half; what is equal stays in order.
fn sort_by_place(mut from: Vec<u64>) -> Vec<u64> {
    let mut to = vec![0u64; from.len()];
    for pass in 0..3 {
        let digit = |v: u64| (v >> (32 + pass * BITS)) as usize & ((1 << BITS) - 1);
        let mut next = [0u32; 1 << BITS];
        from.iter().for_each(|v| next[digit(*v)] += 1);
        let mut sum = 0;
        for n in &mut next {
            (*n, sum) = (sum, sum + *n);
        }
        for v in &from {
            let at = &mut next[digit(*v)];
            to[*at as usize] = *v;
            *at += 1;
        }
        std::mem::swap(&mut from, &mut to);
    }
    from
}

/// Cuts sorted places into runs, at the highest bit in which the ends of a run differ.
fn cut(places: &[u64], first: usize, out: &mut Vec<Range<usize>>) {
    let n = places.len();
    let differ = (places[0] ^ places[n - 1]) >> 32;
    if n <= LONGEST || differ == 0 {
        out.push(first..first + n);
        return;
    }
    let bit = 1 << (63 - (differ << 32).leading_zeros());
    let middle = places.partition_point(|p| p & bit == 0);
    cut(&places[..middle], first, out);
    cut(&places[middle..], first + middle, out);
}

/// Parts a run whose box is large for the sake of a few: those stand behind the others, as a run of their own.
fn part_large(refs: &mut [Ref], run: Range<usize>, thin: f32, out: &mut Vec<(Range<usize>, BoxF)>) {
    let own = &mut refs[run.clone()];
    let bounds = box_of(own);
    let area = |b: &Box4| {
        let s = b.hi - b.lo + thin;
        s.x * s.y + s.y * s.z + s.z * s.x
    };
    let most = 0.5 * area(&bounds);
    let n_large = own.iter().filter(|r| area(r.bounds()) > most).count();
    if n_large == 0 || 2 * n_large >= own.len() {
        out.push((run, bounds.to_boxf()));
        return;
    }
    own.sort_by_key(|r| area(r.bounds()) > most);
    let middle = run.end - n_large;
    for part in [run.start..middle, middle..run.end] {
        let bounds = box_of(&refs[part.clone()]).to_boxf();
        out.push((part, bounds));
    }
}

/// Primitives in the order of the curve, and its runs.
pub(super) struct Runs {
    pub refs: Vec<Ref>,
    cuts: Vec<Range<usize>>,
}

impl Runs {
    /// `None` where there are few, or where the curve cannot tell them apart.
    pub fn new(prims: &impl PrimSet) -> Option<Self> {
        if prims.len() < LEAST {
            return None;
        }
        let sorted = sort_by_place(places(prims));
        let mut cuts = Vec::with_capacity(sorted.len() / 8);
        if !sorted.is_empty() {
            cut(&sorted, 0, &mut cuts);
        }
        if cuts.len() < 2 || cuts.iter().any(|r| r.len() > TOO_LONG) {
            return None;
        }
        let placed = |p: &u64| {
            let prim = *p as u32;
            Ref::new(&PrimRef { bounds: prims.boxed(prim as usize).expect("it has a place"), prim })
        };
        let mut refs = Vec::new();
        sorted.par_iter().with_min_len(CHUNK).map(placed).collect_into_vec(&mut refs);
        Some(Self { refs, cuts })
    }
}

impl Builder {
    /// As [`Builder::node`] of all references; they are left in the order of the leaves.
    pub(super) fn in_runs(&self, Runs { refs, cuts }: &mut Runs, bounds: &BoxF, out: &mut Subtree) -> Child {
        let mut runs = Vec::with_capacity(cuts.len() + cuts.len() / 8);
        cuts.drain(..).for_each(|r| part_large(refs, r, self.thin as f32, &mut runs));
        // What is below the runs first: it knows nothing of what is above.
        let below = self.below(refs, &runs);
        let mut tops: Vec<Ref> = runs.iter().zip(0..).map(|((_, bounds), prim)| Ref::new(&PrimRef { bounds: *bounds, prim })).collect();
        let upper = Builder { max_leaf: 1, pack: 1, few_bins: true, ..*self };
        let mut tree = Subtree::default();
        let root = upper.node(&mut tops, 0, bounds, LEVELS_BELOW, &mut tree, &mut Scratch::new());
        // Each leaf of the upper tree becomes what is below its run.
        let mut bases = Vec::with_capacity(below.len());
        let mut n_nodes = tree.nodes.len();
        for group in &below {
            bases.push(n_nodes as u32);
            n_nodes += group.tree.nodes.len();
            tree.cost += group.tree.cost;
        }
        let (mut depth, mut n_leaves) = (0, 0);
        let rooted = |child: u32| {
            let run = tops[(child ^ BVH_LEAF) as usize].prim() as usize;
            let (group, base) = (&below[run / GROUP], bases[run / GROUP]);
            let (child, count) = group.roots[run % GROUP];
            (if child & BVH_LEAF == 0 { child + base } else { child }, count)
        };
        let one = self.intersect_cost * self.per_root_area;
        for node in &mut tree.nodes {
            for c in 0..2 {
                if node.child[c] & BVH_LEAF != 0 {
                    tree.cost -= one * self.area(&node.child_box(c));
                    (node.child[c], node.count[c]) = rooted(node.child[c]);
                }
            }
        }
        let root = if root.0 & BVH_LEAF == 0 { root } else { rooted(root.0) };
        tree.nodes.reserve(n_nodes - tree.nodes.len());
        for (group, base) in below.iter().zip(&bases) {
            let shift = |child: u32| if child & BVH_LEAF == 0 { child + base } else { child };
            tree.nodes.extend(group.tree.nodes.iter().map(|n| BvhNode { child: n.child.map(shift), ..*n }));
            n_leaves += group.tree.n_leaves;
            depth = depth.max(group.tree.depth);
        }
        tree.n_leaves = n_leaves;
        // The deepest of both: no leaf is deeper.
        tree.depth = tree.depth - LEVELS_BELOW + depth;
        *out = tree;
        root
    }

    /// Trees of the runs, many runs a group.
    fn below(&self, refs: &mut [Ref], runs: &[(Range<usize>, BoxF)]) -> Vec<Group> {
        let mut jobs = Vec::with_capacity(runs.len() / GROUP + 1);
        let mut left = refs;
        for runs in runs.chunks(GROUP) {
            let (first, end) = (runs[0].0.start, runs[runs.len() - 1].0.end);
            let (own, rest) = left.split_at_mut(end - first);
            jobs.push((runs, first, own));
            left = rest;
        }
        let group = |(runs, first, own): Job| {
            let mut group = Group { tree: Subtree::default(), roots: Vec::with_capacity(runs.len()) };
            let mut scratch = None;
            for (run, bounds) in runs {
                let refs = &mut own[run.start - first..run.end - first];
                let depth = MAX_DEPTH - LEVELS_BELOW;
                group.roots.push(if refs.len() <= LONGEST {
                    self.run_node(refs, run.start, bounds, depth, &mut group.tree)
                } else {
                    self.node(refs, run.start, bounds, depth, &mut group.tree, scratch.get_or_insert_with(Scratch::new))
                });
            }
            group.tree.depth = group.tree.depth.saturating_sub(MAX_DEPTH - LEVELS_BELOW);
            group
        };
        jobs.into_par_iter().map(group).collect()
    }

    /// Appends the subtree of a run, parted where its order is.
    fn run_node(&self, refs: &[Ref], first: usize, bounds: &BoxF, depth: usize, out: &mut Subtree) -> Child {
        let n = refs.len();
        let share = self.area(bounds) * self.per_root_area;
        let leaf = |out: &mut Subtree| {
            out.n_leaves += 1;
            out.depth = out.depth.max(depth);
            out.cost += share * self.leaf_cost(n);
            (BVH_LEAF | first as u32, n as u32)
        };
        let thin = self.thin as f32;
        let area = |b: &Box4| {
            let s = b.hi - b.lo + thin;
            s.x * s.y + s.y * s.z + s.z * s.x
        };
        // Where parting costs too much whatever the cut: both parts together are no smaller than any of them.
        let least = (self.leaf_cost(n) - 1.0) / self.intersect_cost * self.area(bounds);
        if n == 1 || n <= self.max_leaf && refs.iter().any(|r| f64::from(area(r.bounds())) >= least) {
            return leaf(out);
        }
        let n_tests = |n: usize| n.div_ceil(self.pack) as f32;
        // By first reference: the box of all from it on.
        let mut above = [Box4::EMPTY; LONGEST];
        let mut right = Box4::EMPTY;
        for i in (1..n).rev() {
            right.grow(refs[i].bounds());
            above[i] = right;
        }
        let (mut left, mut best) = (Box4::EMPTY, (f32::INFINITY, 0, Box4::EMPTY));
        for i in 1..n {
            left.grow(refs[i - 1].bounds());
            let cost = area(&left) * n_tests(i) + area(&above[i]) * n_tests(n - i);
            if cost < best.0 {
                best = (cost, i, left);
            }
        }
        let (cost, mut at, mut box_left) = best;
        let cost = 1.0 + self.intersect_cost * f64::from(cost) / self.area(bounds);
        if n <= self.max_leaf && cost >= self.leaf_cost(n) {
            return leaf(out);
        }
        let must_halve = depth + (usize::BITS - (n - 1).leading_zeros()) as usize >= MAX_DEPTH;
        if must_halve || at == 0 {
            at = n / 2;
            box_left = box_of(&refs[..at]);
        }
        out.cost += share;
        let node = out.nodes.len();
        out.nodes.push(BvhNode::default());
        let (box_left, box_right) = (box_left.to_boxf(), above[at].to_boxf());
        let a = self.run_node(&refs[..at], first, &box_left, depth + 1, out);
        let b = self.run_node(&refs[at..], first + at, &box_right, depth + 1, out);
        out.nodes[node] = BvhNode::new([(box_left, a.0, a.1), (box_right, b.0, b.1)]);
        (node as u32, 0)
    }
}

/// Neighbouring runs, the first of their references, and those.
type Job<'r> = (&'r [(Range<usize>, BoxF)], usize, &'r mut [Ref]);

/// What is below neighbouring runs.
struct Group {
    tree: Subtree,
    /// By run; nodes are relative to the group's.
    roots: Vec<Child>,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::{AccelOptions, Bvh, TrianglePrims};
    use crate::math::Vec3;
    use crate::math::sobol::Pcg;

    #[test]
    fn the_curve_takes_a_bit_of_each_axis_in_turn() {
        for k in 0..BITS {
            assert_eq!(spread(1 << k), 1 << (3 * k));
        }
    }

    #[test]
    fn places_are_sorted_and_cut_into_runs_that_hold_each_once() {
        let mut rng = Pcg::new(7);
        let all: Vec<u64> = (0..50_000u64).map(|k| ((rng.draw().powi(3) * (1 << 30) as f32) as u64) << 32 | k).collect();
        let mut want = all.clone();
        want.sort_by_key(|v| v >> 32);
        let sorted = sort_by_place(all);
        assert_eq!(sorted, want);
        let mut runs = Vec::new();
        cut(&sorted, 0, &mut runs);
        assert_eq!(runs.iter().map(|r| r.len()).sum::<usize>(), sorted.len());
        assert!(runs.windows(2).all(|w| w[0].end == w[1].start));
        assert!(runs.iter().all(|r| !r.is_empty() && (r.len() <= LONGEST || sorted[r.start] >> 32 == sorted[r.end - 1] >> 32)));
    }

    /// Triangles of all sizes, clumps of them in one place, some without a place.
    fn triangles(rng: &mut Pcg) -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let mut vertices = Vec::new();
        let clump = Vec3::new(0.1, 0.2, 0.3);
        for k in 0..20_000u32 {
            let mut at = || Vec3::new(rng.draw(), rng.draw(), rng.draw());
            let size = if k % 50 == 0 { 1.0 } else { 0.01 };
            let middle = if k % 4 == 0 { clump } else { at() * Vec3::new(10.0, 3.0, 1.0) };
            let middle = if k % 1000 == 7 { Vec3::NAN } else { middle };
            vertices.extend([middle + at() * size, middle + at() * size, middle + at() * size]);
        }
        let faces = (0..vertices.len() as u32 / 3).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
        (vertices, faces)
    }

    #[test]
    fn trees_in_runs_hold_each_primitive_once_and_cost_little_more() {
        let (vertices, faces) = triangles(&mut Pcg::new(11));
        let prims = TrianglePrims { vertices: &vertices, faces: &faces };
        let build = |in_runs| Bvh::build(&prims, &AccelOptions { pack: 4, in_runs, ..AccelOptions::default() });
        let (tree, usual) = (build(true), build(false));
        assert!(tree.is_sound(faces.len()));
        assert!(tree.refs.len() == usual.refs.len() && tree.refs.len() == faces.len() - 20);
        assert!(tree.refs != usual.refs, "another build");
        let holds = |b: &BoxF, c: &BoxF| b.merged(*c) == *b;
        let mut n_leaves = 0;
        for n in &tree.nodes {
            for c in 0..2 {
                let (bounds, child) = (n.child_box(c), n.child[c]);
                if child & BVH_LEAF == 0 {
                    let below = &tree.nodes[child as usize];
                    assert!((0..2).all(|c| holds(&bounds, &below.child_box(c))));
                    continue;
                }
                n_leaves += 1;
                assert!((1..=4).contains(&n.count[c]));
                let first = (child ^ BVH_LEAF) as usize;
                let own = &tree.refs[first..first + n.count[c] as usize];
                assert!(own.iter().all(|k| holds(&bounds, &prims.boxed(*k as usize).expect("it has a place"))));
            }
        }
        assert!(n_leaves == tree.stats.n_leaves && tree.stats.depth <= MAX_DEPTH);
        let ratio = tree.stats.sah_cost / usual.stats.sah_cost;
        assert!(ratio < 1.15, "{ratio}");
    }
}
