//! The kd-tree: 8-byte nodes and how a ray walks them. The build stands in `accel/kd_build.rs`.

use super::{AccelStats, BoxF, RAY_SLACK, is_usable};
use crate::math::{DVec3, Ray};

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

/// A kd-tree over primitives.
#[derive(Clone, Debug)]
pub struct KdTree {
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

/// A ray made ready: the slack is moved into its origin, once for the near side of each plane and once for the far side.
struct KdRay {
    inv: [f64; 3],
    /// A plane at `s` is reached at `(s - enter) * inv` at the earliest ...
    enter: [f64; 3],
    /// ... and left behind at `(s - exit) * inv` at the latest.
    exit: [f64; 3],
}

impl KdRay {
    fn new(ray: &Ray, max_abs: f64) -> Self {
        let slack = (RAY_SLACK * (ray.origin.abs().max_element() + max_abs)).max(1e-300);
        let d: [f64; 3] = ray.dir.into();
        let o: [f64; 3] = ray.origin.into();
        // A component of zero (or nearly) gets a huge slope of its sign: every plane is then far ahead or far behind, never NaN.
        let inv = d.map(|d| if d.abs() < 1e-280 { 1e280_f64.copysign(d) } else { 1.0 / d });
        Self {
            inv,
            enter: std::array::from_fn(|k| if inv[k] > 0.0 { o[k] + slack } else { o[k] - slack }),
            exit: std::array::from_fn(|k| if inv[k] > 0.0 { o[k] - slack } else { o[k] + slack }),
        }
    }

    /// Part of `t_min..=t_max` in the box.
    fn clip(&self, b: &BoxF, t_min: f64, t_max: f64) -> (f64, f64) {
        let (mut t0, mut t1) = (t_min, t_max);
        for k in 0..3 {
            let (near, far) = if self.inv[k] > 0.0 { (b.lo[k], b.hi[k]) } else { (b.hi[k], b.lo[k]) };
            t0 = t0.max((f64::from(near) - self.enter[k]) * self.inv[k]);
            t1 = t1.min((f64::from(far) - self.exit[k]) * self.inv[k]);
        }
        (t0, t1)
    }
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
        if self.nodes.is_empty() || !is_usable(ray) {
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
        let kd_ray = KdRay::new(ray, self.bounds.max_abs());
        let mut best = t_max;
        let (mut t_enter, mut t_exit) = kd_ray.clip(&self.bounds, t_min.max(0.0), t_max);
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
                let (s, inv) = (f64::from(node.split()), kd_ray.inv[axis]);
                let t_reach = (s - kd_ray.enter[axis]) * inv;
                let t_leave = (s - kd_ray.exit[axis]) * inv;
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
            // Entries lie in order of depth: the first one beyond the best hit ends the ray.
            if n_stack == 0 || stack[n_stack - 1].t_enter > best {
                return false;
            }
            n_stack -= 1;
            Entry { node: node_ix, t_enter, t_exit } = stack[n_stack];
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

    /// The middle of the tree's box.
    pub fn center(&self) -> DVec3 {
        self.bounds.to_bounds().center()
    }
}
