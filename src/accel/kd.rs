//! The kd-tree: 8-byte nodes and how a ray walks them. The build stands in `accel/kd_build.rs`.

use super::kd_trail::SHORT_STACK;
use super::slabs::SlabRay;
use super::{AccelStats, BoxF, can_meet};
use crate::math::Ray;

/// A node, as the GPU reads it. The child below the plane is the next node.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct KdNode {
    /// Inner node: bits of the plane's `f32`. Leaf: first reference.
    pub split_or_first: u32,
    /// Low two bits: axis of the plane, 3 for a leaf. The rest: index of the child above the plane, or the leaf's number of references.
    pub meta: u32,
}

impl KdNode {
    /// An inner node.
    pub fn inner(axis: usize, split: f32, above: u32) -> Self {
        Self { split_or_first: split.to_bits(), meta: above << 2 | axis as u32 }
    }

    /// A leaf of `count` references from `first` on.
    pub fn leaf(first: u32, count: u32) -> Self {
        Self { split_or_first: first, meta: count << 2 | 3 }
    }

    /// Whether it is a leaf.
    #[inline]
    pub fn is_leaf(self) -> bool {
        self.meta & 3 == 3
    }

    /// Axis of an inner node.
    #[inline]
    pub fn axis(self) -> usize {
        (self.meta & 3) as usize
    }

    /// Plane of an inner node.
    #[inline]
    pub fn split(self) -> f32 {
        f32::from_bits(self.split_or_first)
    }

    /// Child above the plane of an inner node, or the number of references of a leaf.
    #[inline]
    pub fn above_or_count(self) -> u32 {
        self.meta >> 2
    }
}

/// How rays come back to what they put off.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum KdWalk {
    /// A stack as deep as the tree.
    #[default]
    Stack,
    /// A stack of [`super::SHORT_STACK`] entries, from the root again when it runs dry.
    ShortStack,
    /// From the root again after each leaf.
    Restart,
}

/// A kd-tree over primitives.
#[derive(Clone, Debug)]
pub struct KdTree {
    /// How rays walk it.
    pub walk: KdWalk,
    /// Nodes; the root is the first. Empty for no primitives.
    pub nodes: Vec<KdNode>,
    /// Primitives of the leaves.
    pub refs: Vec<u32>,
    /// Box of all primitives.
    pub bounds: BoxF,
    /// What came of the build.
    pub stats: AccelStats,
}

/// Deepest tree that the build makes; the stack holds one entry a level.
pub(super) const MAX_DEPTH: usize = 60;

/// A cell to visit later.
#[derive(Clone, Copy)]
struct Entry {
    node: u32,
    t_enter: f64,
    t_exit: f64,
}

impl KdTree {
    /// See [`super::Accel::closest`].
    #[inline]
    pub fn closest(&self, ray: &Ray, t_min: f64, t_max: f64, mut hit: impl FnMut(u32, f64) -> Option<f64>) {
        let visit = |refs: &[u32], mut best: f64| {
            for prim in refs {
                if let Some(t) = hit(*prim, best) {
                    best = t;
                }
            }
            Some(best)
        };
        self.walk(ray, t_min, t_max, visit);
    }

    /// See [`super::Accel::any`].
    #[inline]
    pub fn any(&self, ray: &Ray, t_min: f64, t_max: f64, mut hit: impl FnMut(u32) -> bool) -> bool {
        self.walk(ray, t_min, t_max, |refs, best| if refs.iter().any(|prim| hit(*prim)) { None } else { Some(best) })
    }

    /// Visits leaves along the ray in order; `visit(refs, t_max)` gives the depth that still matters, or `None` to stop. Tells whether it stopped.
    #[inline]
    fn walk(&self, ray: &Ray, t_min: f64, t_max: f64, visit: impl FnMut(&[u32], f64) -> Option<f64>) -> bool {
        match self.walk {
            KdWalk::Stack => {}
            KdWalk::ShortStack => return self.walk_trail::<SHORT_STACK>(ray, t_min, t_max, visit),
            KdWalk::Restart => return self.walk_trail::<0>(ray, t_min, t_max, visit),
        }
        if self.nodes.is_empty() || !can_meet(ray, t_min, t_max) {
            return false;
        }
        // A short stack is cheaper to clear; entries never outnumber the levels.
        if self.stats.depth <= 24 {
            self.walk_with::<24>(ray, t_min, t_max, visit)
        } else {
            self.walk_with::<MAX_DEPTH>(ray, t_min, t_max, visit)
        }
    }

    #[inline]
    fn walk_with<const N: usize>(&self, ray: &Ray, t_min: f64, t_max: f64, mut visit: impl FnMut(&[u32], f64) -> Option<f64>) -> bool {
        let slab_ray = SlabRay::new(ray, self.bounds.max_abs());
        let mut best = t_max;
        let (mut t_enter, mut t_exit) = slab_ray.clip(&self.bounds, t_min.max(0.0), t_max);
        if !(t_enter <= t_exit) {
            return false;
        }
        let mut stack = [Entry { node: 0, t_enter: 0.0, t_exit: 0.0 }; N];
        let mut n_stack = 0;
        let mut node_ix = 0u32;
        loop {
            let mut node = self.nodes[node_ix as usize];
            while !node.is_leaf() {
                let axis = node.axis();
                let (s, inv) = (f64::from(node.split()), slab_ray.inv[axis]);
                let t_reach = (s - slab_ray.enter[axis]) * inv;
                let t_leave = (s - slab_ray.exit[axis]) * inv;
                let (below, above) = (node_ix + 1, node.above_or_count());
                let (near, far) = if inv > 0.0 { (below, above) } else { (above, below) };
                // The near cell holds what lies before `t_leave`, the far one what lies after `t_reach`; within the slack both do.
                if t_leave < t_enter {
                    node_ix = far;
                } else if t_reach > t_exit {
                    node_ix = near;
                } else {
                    stack[n_stack] = Entry { node: far, t_enter: t_enter.max(t_reach), t_exit };
                    n_stack += 1;
                    t_exit = t_exit.min(t_leave);
                    node_ix = near;
                }
                node = self.nodes[node_ix as usize];
            }
            let first = node.split_or_first as usize;
            let count = node.above_or_count() as usize;
            if count > 0 {
                match visit(&self.refs[first..first + count], best) {
                    Some(t) => best = t,
                    None => return true,
                }
            }
            // Within the slack both cells of a plane are visited, so entries are not quite in order of depth: look at each.
            loop {
                if n_stack == 0 {
                    return false;
                }
                n_stack -= 1;
                if stack[n_stack].t_enter <= best {
                    Entry { node: node_ix, t_enter, t_exit } = stack[n_stack];
                    break;
                }
            }
        }
    }

    /// Whether every number in the tree makes sense: children after their parent, references in range. For tests of uploads.
    pub fn is_sound(&self, n_prims: usize) -> bool {
        self.refs.iter().all(|r| (*r as usize) < n_prims)
            && self.nodes.iter().enumerate().all(|(i, n)| {
                if n.is_leaf() {
                    n.split_or_first as usize + n.above_or_count() as usize <= self.refs.len()
                } else {
                    n.split().is_finite() && (n.above_or_count() as usize) > i && (n.above_or_count() as usize) < self.nodes.len()
                }
            })
    }
}
