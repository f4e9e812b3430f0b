//! Trees over primitives: SAH kd-tree, SAH BVH and brute force behind one shape. Build, statistics and traversal; what a
//! primitive is, and how a ray hits it, is the caller's business.
//!
//! Promises:
//! - Boxes and planes are 32-bit, rounded outward from 64-bit bounds. Rays are 64-bit. Traversal is conservative: a primitive whose
//!   test, computed in double precision, finds a hit is offered, also far from the origin and for rays that run in planes of the tree
//!   (slack: [`RAY_SLACK`] of the largest coordinate in play, moved into the ray so that it costs nothing).
//! - A primitive is skipped only where its box or cell lies beyond `t_max`. A test whose depth is off (edge on) may name a smaller
//!   depth than that of the box; which of two such hits wins is then up to the tree.
//! - A primitive may be offered more than once for a ray (kd-trees keep it in several cells).
//! - Primitives with empty or NaN bounds are left out; infinite bounds are cut at ±[`HUGE`].
//! - Depth and memory are bounded whatever the geometry; the tree does not depend on the number of threads.

mod boxf;
mod bvh;
mod bvh8;
mod bvh8_build;
mod bvh_bins;
mod bvh_build;
mod bvh_runs;
mod bvh_skip;
mod grid;
mod grid_build;
mod kd;
mod kd_build;
mod kd_trail;
mod packet;
mod shaft;
mod slabs;
mod stack;
mod table;
mod triangles;
mod wide;
mod wide_build;

pub use boxf::{BoxF, round_up};
pub use bvh::{BVH_LEAF, Bvh, BvhNode};
pub use bvh_skip::{BvhSkip, SKIP_COUNT_BITS, SkipNode};
pub use bvh8::{BVH8_LEAF, Bvh8, Bvh8Node, LeafVisitor, NO_PRIM, PACK, leaf_slots};
pub use grid::{GRID_INNER, GRID_LEVELS, Grid, GridBox, GridCell, GridEntry, pack_cell};
pub use kd::{KdNode, KdTree, KdWalk};
pub use kd_trail::SHORT_STACK;
pub use packet::{Fars, GROUPS, LANES, PACKET, Packet, PacketVisitor, PerRay};
pub use shaft::{Candidates, Shaft};
pub use table::{AccelKind, STRUCTURES, Structure};
pub use triangles::TrianglePrims;
pub use wide::{WIDE_LEAF, WideBvh, WideNode};

use crate::math::simd::is_wide;
use crate::math::{Bounds, Ray};
use std::time::Instant;

/// Spatial slack of every box and plane test, as a share of the largest coordinate of ray origin and tree: 32 units in the last place.
pub const RAY_SLACK: f64 = 1.0 / (1u64 << 47) as f64;
/// Coordinates of bounds are cut here.
pub const HUGE: f64 = 1e30;
/// Sets of this size and smaller are tested one by one. Measured: a triangle's test costs about what a node does, 13 ns, and a
/// BVH over 2 triangles takes 21 ns a ray, over 4 triangles 25 ns (brute force 42).
pub const BRUTE_LIMIT: usize = 1;

/// What a tree is built over.
pub trait PrimSet: Sync {
    /// Number of primitives.
    fn len(&self) -> usize;
    /// Whether there is none.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }
    /// Box of a primitive.
    fn bounds(&self, prim_ix: usize) -> Bounds;
    /// The same, rounded outward to 32 bits; `None` where it is of no use.
    fn boxed(&self, prim_ix: usize) -> Option<BoxF> {
        BoxF::around(&self.bounds(prim_ix))
    }
    /// Box of the part of a primitive that lies in `cell`; may be larger, never smaller; empty where nothing lies in it.
    fn clipped_bounds(&self, prim_ix: usize, cell: &Bounds) -> Bounds {
        self.bounds(prim_ix).intersection(*cell)
    }
}

/// How to build.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AccelOptions {
    /// Cost of one primitive's test, in steps of the tree: about 1.5 for triangles, more for what needs roots.
    pub intersect_cost: f64,
    /// Most primitives of a BVH leaf.
    pub max_leaf: usize,
    /// Primitives of a BVH leaf that are tested at once, for the price of one.
    pub pack: usize,
    /// The kd-tree holds at most this many references for each primitive, plus a few hundred. With 12, surfaces that cross each other
    /// everywhere end it early: shells of 311 k faces take 1.3 to 1.6 times as long on an H100 (benches/results/accel_h100.md).
    pub max_refs_per_prim: f64,
    /// BVHs of many primitives are built in less than half the time, a little worse for rays (`accel/bvh_runs.rs`).
    pub in_runs: bool,
}

impl Default for AccelOptions {
    fn default() -> Self {
        Self { intersect_cost: 1.5, max_leaf: 4, pack: 1, max_refs_per_prim: 40.0, in_runs: false }
    }
}

/// What came of a build.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct AccelStats {
    /// Primitives asked for.
    pub n_prims: usize,
    /// Of these, without usable bounds.
    pub n_skipped: usize,
    /// Inner and leaf nodes (kd), two-box nodes (BVH).
    pub n_nodes: usize,
    /// Leaves.
    pub n_leaves: usize,
    /// References in leaves.
    pub n_refs: usize,
    /// Steps from the root to the deepest leaf.
    pub depth: usize,
    /// Expected cost of a ray that meets the root's box, in steps.
    pub sah_cost: f64,
    /// Wall clock seconds.
    pub build_seconds: f64,
    /// Bytes of nodes and references.
    pub n_bytes: usize,
}

/// A structure over primitives `0..n`.
#[derive(Clone, Debug)]
pub enum Accel {
    /// kd-tree.
    Kd(KdTree),
    /// Bounding volume hierarchy.
    Bvh(Bvh),
    /// The same in one order.
    BvhSkip(BvhSkip),
    /// The same with eight children a node and boxes in bytes.
    Wide(WideBvh),
    /// The same with eight children a node, for the CPU's wide instructions.
    Bvh8(Bvh8),
    /// Uniform or hierarchical grid.
    Grid(Grid),
    /// Primitives `0..n`, one by one.
    Brute(u32),
}

impl Default for Accel {
    fn default() -> Self {
        Self::Brute(0)
    }
}

impl Accel {
    /// Builds over all primitives of `prims`, with the threads of the current rayon pool.
    pub fn build(kind: AccelKind, prims: &impl PrimSet, options: &AccelOptions) -> Self {
        let n = prims.len();
        assert!(n < (1 << 30), "a tree indexes fewer than 2^30 primitives; the compile step refuses more");
        // The wide BVH alone tests packs.
        let single = &AccelOptions { pack: 1, ..*options };
        match kind {
            // How threads share the work matters on GPUs alone.
            AccelKind::Brute | AccelKind::BruteTiled | AccelKind::BruteGroup => Self::Brute(n as u32),
            AccelKind::Grid => Self::Grid(Grid::build(prims, options, 1)),
            AccelKind::HierarchicalGrid => Self::Grid(Grid::build(prims, options, GRID_LEVELS)),
            AccelKind::BvhSkip => Self::BvhSkip(BvhSkip::build(prims, single)),
            AccelKind::Wide => Self::Wide(WideBvh::build(prims, single)),
            AccelKind::Auto if n <= BRUTE_LIMIT => Self::Brute(n as u32),
            // A leaf takes four slots even for one primitive.
            AccelKind::Auto if n < 1 << 28 && is_wide() => Self::Bvh8(Bvh8::build(prims, options)),
            AccelKind::Bvh8 if n < 1 << 28 => Self::Bvh8(Bvh8::build(prims, options)),
            AccelKind::Auto | AccelKind::Bvh8 | AccelKind::Bvh => Self::Bvh(Bvh::build(prims, single)),
            AccelKind::Kd => Self::Kd(KdTree::build(prims, options)),
            AccelKind::KdShort => Self::Kd(KdTree { walk: KdWalk::ShortStack, ..KdTree::build(prims, options) }),
            AccelKind::KdRestart => Self::Kd(KdTree { walk: KdWalk::Restart, ..KdTree::build(prims, options) }),
        }
    }

    /// Whether a ray is offered each primitive at most once, and only when it meets a box that is the primitive's own (rounded outward).
    #[inline]
    pub fn tests_own_boxes(&self) -> bool {
        matches!(self, Self::Bvh8(t) if t.is_single)
    }

    /// Which structure it is.
    pub fn kind(&self) -> AccelKind {
        match self {
            Self::Kd(t) => match t.walk {
                KdWalk::Stack => AccelKind::Kd,
                KdWalk::ShortStack => AccelKind::KdShort,
                KdWalk::Restart => AccelKind::KdRestart,
            },
            Self::Bvh(_) => AccelKind::Bvh,
            Self::BvhSkip(_) => AccelKind::BvhSkip,
            Self::Wide(_) => AccelKind::Wide,
            Self::Bvh8(_) => AccelKind::Bvh8,
            Self::Grid(g) if g.n_levels > 1 => AccelKind::HierarchicalGrid,
            Self::Grid(_) => AccelKind::Grid,
            Self::Brute(_) => AccelKind::Brute,
        }
    }

    /// What came of the build.
    pub fn stats(&self) -> AccelStats {
        match self {
            Self::Kd(t) => t.stats,
            Self::Bvh(t) => t.stats,
            Self::BvhSkip(t) => t.stats,
            Self::Wide(t) => t.stats,
            Self::Bvh8(t) => t.stats,
            Self::Grid(t) => t.stats,
            Self::Brute(n) => {
                let n = *n as usize;
                AccelStats { n_prims: n, n_refs: n, n_leaves: 1, ..AccelStats::default() }
            }
        }
    }

    /// Primitive in a slot. Slots number primitives in the order in which they lie in the tree; data kept in that order is near
    /// in memory when it is near in space. A BVH has an order of its own; elsewhere slot and primitive are the same.
    #[inline]
    pub fn prim_at(&self, slot: u32) -> u32 {
        self.order().map_or(slot, |refs| refs[slot as usize])
    }

    /// The primitives in the order of their slots, if it is the structure's own.
    #[inline]
    fn order(&self) -> Option<&[u32]> {
        match self {
            Self::Bvh(t) => Some(&t.refs),
            Self::BvhSkip(t) => Some(&t.refs),
            Self::Wide(t) => Some(&t.refs),
            Self::Bvh8(t) => Some(&t.slots),
            Self::Kd(_) | Self::Grid(_) | Self::Brute(_) => None,
        }
    }

    /// Primitives slot by slot, [`NO_PRIM`] in slots without one; primitives without usable bounds may be missing.
    pub fn slots(&self) -> Vec<u32> {
        self.order().map_or_else(|| (0..self.stats().n_prims as u32).collect(), <[u32]>::to_vec)
    }

    /// Offers `hit` the primitives that `ray` may meet in `t_min..=t_max`, near ones first where the structure knows.
    ///
    /// `hit(prim, t_max)` gives the new `t_max` when it found something nearer, else `None`; what lies beyond is skipped.
    /// Depths are in units of `ray.dir`; `t_min` below 0 counts as 0. A ray with a number that is not finite, or no direction, meets nothing.
    #[inline]
    pub fn closest(&self, ray: &Ray, t_min: f64, t_max: f64, mut hit: impl FnMut(u32, f64) -> Option<f64>) {
        match self {
            Self::Bvh8(t) => t.closest_slots(ray, t_min, t_max, |slot, best| hit(t.slots[slot as usize], best)),
            _ => self.closest_elsewhere(ray, t_min, t_max, &mut hit),
        }
    }

    /// The structures that are not the CPU's first choice: inlined, their stacks would stand in the frame of every ray.
    #[inline(never)]
    fn closest_elsewhere(&self, ray: &Ray, t_min: f64, t_max: f64, mut hit: impl FnMut(u32, f64) -> Option<f64>) {
        match self {
            Self::Bvh(t) => t.closest_slots(ray, t_min, t_max, |slot, best| hit(t.refs[slot as usize], best)),
            _ => self.closest_slots(ray, t_min, t_max, |slot, best| hit(self.prim_at(slot), best)),
        }
    }

    /// Whether `hit` says yes to any primitive that `ray` may meet in `t_min..=t_max`; stops there.
    #[inline]
    pub fn any(&self, ray: &Ray, t_min: f64, t_max: f64, mut hit: impl FnMut(u32) -> bool) -> bool {
        match self {
            Self::Bvh8(t) => t.any_slot(ray, t_min, t_max, |slot| hit(t.slots[slot as usize])),
            _ => self.any_elsewhere(ray, t_min, t_max, &mut hit),
        }
    }

    /// As [`Accel::closest_elsewhere`].
    #[inline(never)]
    fn any_elsewhere(&self, ray: &Ray, t_min: f64, t_max: f64, mut hit: impl FnMut(u32) -> bool) -> bool {
        match self {
            Self::Bvh(t) => t.any_slot(ray, t_min, t_max, |slot| hit(t.refs[slot as usize])),
            _ => self.any_slot(ray, t_min, t_max, |slot| hit(self.prim_at(slot))),
        }
    }

    /// As [`Accel::closest`], but offers slots.
    #[inline]
    pub fn closest_slots(&self, ray: &Ray, t_min: f64, t_max: f64, mut hit: impl FnMut(u32, f64) -> Option<f64>) {
        match self {
            Self::Kd(t) => t.closest(ray, t_min, t_max, hit),
            Self::Bvh(t) => t.closest_slots(ray, t_min, t_max, hit),
            Self::Bvh8(t) => t.closest_slots(ray, t_min, t_max, hit),
            Self::BvhSkip(t) => {
                t.walk(ray, t_min, t_max, |first, count, best| Some(nearest_of(first, count, best, &mut hit)));
            }
            Self::Wide(t) => {
                t.walk(ray, t_min, t_max, |first, count, best| Some(nearest_of(first, count, best, &mut hit)));
            }
            Self::Grid(t) => {
                t.walk(ray, t_min, t_max, |prim, best| Some(hit(prim, best).unwrap_or(best)));
            }
            Self::Brute(n) => {
                if !can_meet(ray, t_min, t_max) {
                    return;
                }
                nearest_of(0, *n, t_max, &mut hit);
            }
        }
    }

    /// As [`Accel::any`], but offers slots.
    #[inline]
    pub fn any_slot(&self, ray: &Ray, t_min: f64, t_max: f64, mut hit: impl FnMut(u32) -> bool) -> bool {
        match self {
            Self::Kd(t) => t.any(ray, t_min, t_max, hit),
            Self::Bvh(t) => t.any_slot(ray, t_min, t_max, hit),
            Self::Bvh8(t) => t.any_slot(ray, t_min, t_max, hit),
            Self::BvhSkip(t) => t.walk(ray, t_min, t_max, |first, n, best| (!(first..first + n).any(&mut hit)).then_some(best)),
            Self::Wide(t) => t.walk(ray, t_min, t_max, |first, n, best| (!(first..first + n).any(&mut hit)).then_some(best)),
            Self::Grid(t) => t.walk(ray, t_min, t_max, |prim, best| (!hit(prim)).then_some(best)),
            Self::Brute(n) => can_meet(ray, t_min, t_max) && (0..*n).any(&mut hit),
        }
    }
}

/// Offers slots one by one; gives the depth that still matters.
#[inline(always)]
fn nearest_of(first: u32, count: u32, mut best: f64, hit: &mut impl FnMut(u32, f64) -> Option<f64>) -> f64 {
    for slot in first..first + count {
        if let Some(t) = hit(slot, best) {
            best = t;
        }
    }
    best
}

/// Whether there is anything to look for: finite numbers, a direction, depths in the interval.
#[inline]
pub fn can_meet(ray: &Ray, t_min: f64, t_max: f64) -> bool {
    // 0 times what is not finite is NaN.
    let none = ray.origin * 0.0 + ray.dir * 0.0;
    none.x + none.y + none.z == 0.0 && ray.dir != crate::math::DVec3::ZERO && t_min <= t_max && t_max >= 0.0
}

/// A primitive, or its part in a cell.
#[derive(Clone, Copy)]
struct PrimRef {
    bounds: BoxF,
    prim: u32,
}

/// The primitives that can be built over, their boxes rounded outward.
fn usable_prims(prims: &impl PrimSet) -> Vec<PrimRef> {
    use rayon::prelude::*;
    let boxed = |i: usize| prims.boxed(i).map(|bounds| PrimRef { bounds, prim: i as u32 });
    // The order is kept, so the tree does not depend on the threads.
    if prims.len() < 4096 {
        (0..prims.len()).filter_map(boxed).collect()
    } else {
        (0..prims.len()).into_par_iter().filter_map(boxed).collect()
    }
}

/// The box of them all.
fn box_of(refs: &[PrimRef]) -> BoxF {
    refs.iter().fold(BoxF::EMPTY, |b, r| b.merged(r.bounds))
}

/// A clock for build statistics.
fn seconds_since(start: Instant) -> f64 {
    start.elapsed().as_secs_f64()
}
