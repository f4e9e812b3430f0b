//! Walking the kd-tree with a short stack, or none: a bit a level says which halves are done, so that the walk can start at the root again.
//!
//! The bits do not look at depths, so nothing is lost or walked twice where planes are nearer than rounding tells apart, as it would be
//! when restarting at the depth where the last leaf ended. Sources: Laine 2010, "Restart trail for stackless BVH traversal"; Foley,
//! Sugerman 2005; Horn et al. 2007 (short stack).

use super::can_meet;
use super::kd::KdTree;
use super::slabs::SlabRay;
use crate::math::Ray;

/// Entries of the short stack.
pub const SHORT_STACK: usize = 8;

/// Bit of the root's level; the one above it ends the walk.
const TOP: u64 = 1 << 62;

#[derive(Clone, Copy, Default)]
struct Entry {
    node: u32,
    level: u64,
    t_enter: f64,
    t_exit: f64,
}

impl KdTree {
    /// As `walk`, with a stack of `N` entries (a power of two, or 0); the oldest are forgotten and found again from the root.
    #[inline]
    pub(super) fn walk_trail<const N: usize>(
        &self,
        ray: &Ray,
        t_min: f64,
        t_max: f64,
        mut visit: impl FnMut(&[u32], f64) -> Option<f64>,
    ) -> bool {
        if self.nodes.is_empty() || !can_meet(ray, t_min, t_max) {
            return false;
        }
        let slab_ray = SlabRay::new(ray, self.bounds.max_abs());
        let (enter, exit) = slab_ray.clip(&self.bounds, t_min.max(0.0), t_max);
        if !(enter <= exit) {
            return false;
        }
        let mut best = t_max;
        let mut stack = [Entry::default(); N];
        let (mut n_pushed, mut n_kept) = (0usize, 0usize);
        let root = Entry { node: 0, level: TOP, t_enter: enter, t_exit: exit };
        let (mut at, mut trail) = (root, 0u64);
        loop {
            let mut node = self.nodes[at.node as usize];
            // What lies beyond the nearest hit is gone past, but by the same way as before: depths decide as they did at first.
            while !node.is_leaf() && at.t_enter <= best {
                let axis = node.axis();
                let (s, inv) = (f64::from(node.split()), slab_ray.inv[axis]);
                let t_reach = (s - slab_ray.enter[axis]) * inv;
                let t_leave = (s - slab_ray.exit[axis]) * inv;
                let (below, above) = (at.node + 1, node.above_or_count());
                let (near, far) = if inv > 0.0 { (below, above) } else { (above, below) };
                if t_leave < at.t_enter {
                    trail |= at.level;
                    at.node = far;
                } else if t_reach > at.t_exit {
                    trail |= at.level;
                    at.node = near;
                } else if trail & at.level != 0 {
                    at.t_enter = at.t_enter.max(t_reach);
                    at.node = far;
                } else {
                    if N > 0 {
                        let far = Entry { node: far, level: at.level >> 1, t_enter: at.t_enter.max(t_reach), t_exit: at.t_exit };
                        stack[n_pushed % N.max(1)] = far;
                        n_pushed += 1;
                        n_kept = (n_kept + 1).min(N);
                    }
                    at.t_exit = at.t_exit.min(t_leave);
                    at.node = near;
                }
                at.level >>= 1;
                node = self.nodes[at.node as usize];
            }
            let count = node.above_or_count() as usize;
            if node.is_leaf() && count > 0 && at.t_enter <= best {
                let first = node.split_or_first as usize;
                match visit(&self.refs[first..first + count], best) {
                    Some(t) => best = t,
                    None => return true,
                }
            }
            // The lowest level above with its far half to come; all below it begin anew.
            let parent = at.level << 1;
            trail = (trail & !(parent - 1)) + parent;
            if trail >= TOP << 1 {
                return false;
            }
            if n_kept > 0 {
                n_pushed -= 1;
                n_kept -= 1;
                at = stack[n_pushed % N.max(1)];
            } else {
                at = root;
            }
        }
    }
}
