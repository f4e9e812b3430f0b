//! The BVH: 64-byte nodes of two boxes and how a ray walks them. The build stands in `accel/bvh_build.rs`.

use super::slabs::SlabRay;
use super::{AccelStats, BoxF, can_meet, nearest_of};
use crate::math::Ray;
use arrayvec::ArrayVec;

/// Marks a leaf in [`BvhNode::child`].
pub const BVH_LEAF: u32 = 1 << 31;

/// A node, as the GPU reads it: four vectors of four. It holds the boxes of its children, not its own.
#[derive(Clone, Copy, Debug, PartialEq, Default, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C, align(64))]
pub struct BvhNode {
    /// `[axis][lower, upper side][child]`: one load and one subtraction serve both children.
    pub planes: [[[f32; 2]; 2]; 3],
    /// Inner child: its node. Leaf: first reference with [`BVH_LEAF`] set.
    pub child: [u32; 2],
    /// References of a leaf, 0 for an inner child.
    pub count: [u32; 2],
}

impl BvhNode {
    /// A node over two children, each a box, a `child` and a `count`.
    pub(super) fn new(children: [(BoxF, u32, u32); 2]) -> Self {
        let [a, b] = children;
        Self { planes: std::array::from_fn(|k| [[a.0.lo[k], b.0.lo[k]], [a.0.hi[k], b.0.hi[k]]]), child: [a.1, b.1], count: [a.2, b.2] }
    }

    /// Box of a child.
    pub fn child_box(&self, which: usize) -> BoxF {
        BoxF { lo: self.planes.map(|p| p[0][which]), hi: self.planes.map(|p| p[1][which]) }
    }
}

/// A child of a node, its box beside it; an inner child when `count` is 0.
#[derive(Clone, Copy, Debug)]
pub(super) struct BvhChild {
    pub bounds: BoxF,
    pub child: u32,
    pub count: u32,
}

impl BvhChild {
    pub fn is_inner(&self) -> bool {
        self.child & BVH_LEAF == 0
    }
}

/// A bounding volume hierarchy over primitives.
#[derive(Clone, Debug)]
pub struct Bvh {
    /// Nodes; the root is the first. Empty for no primitives.
    pub nodes: Vec<BvhNode>,
    /// Primitives of the leaves, each once.
    pub refs: Vec<u32>,
    /// Box of all primitives.
    pub bounds: BoxF,
    /// What came of the build.
    pub stats: AccelStats,
}

/// Deepest tree that the build makes; the stack holds one entry a level.
pub(super) const MAX_DEPTH: usize = 60;

/// A child to visit later.
#[derive(Clone, Copy)]
struct Entry {
    child: u32,
    count: u32,
    t_enter: f64,
}

/// Where two boxes are met: `near[c] <= far[c]` when box `c` is.
#[inline(always)]
fn meet(node: &BvhNode, ray: &SlabRay, t_min: f64, t_max: f64) -> ([f64; 2], [f64; 2]) {
    let (mut near, mut far) = ([t_min; 2], [t_max; 2]);
    for k in 0..3 {
        let side = ray.near[k] & 1;
        let (first, last) = (node.planes[k][side], node.planes[k][side ^ 1]);
        for c in 0..2 {
            let a = (f64::from(first[c]) - ray.enter[k]) * ray.inv[k];
            let b = (f64::from(last[c]) - ray.exit[k]) * ray.inv[k];
            // Not f64::max: nothing is NaN here, and this is one instruction for both lanes.
            near[c] = if a > near[c] { a } else { near[c] };
            far[c] = if b < far[c] { b } else { far[c] };
        }
    }
    (near, far)
}

impl Bvh {
    /// As [`super::Accel::closest_slots`].
    #[inline]
    pub fn closest_slots(&self, ray: &Ray, t_min: f64, t_max: f64, mut hit: impl FnMut(u32, f64) -> Option<f64>) {
        self.walk(ray, t_min, t_max, |first, count, best| Some(nearest_of(first, count, best, &mut hit)));
    }

    /// As [`super::Accel::any_slot`].
    #[inline]
    pub fn any_slot(&self, ray: &Ray, t_min: f64, t_max: f64, mut hit: impl FnMut(u32) -> bool) -> bool {
        self.walk(ray, t_min, t_max, |first, count, best| if (first..first + count).any(&mut hit) { None } else { Some(best) })
    }

    /// Visits leaves along the ray, near ones first; `visit(first, count, t_max)` gives the depth that still matters, or `None` to stop.
    /// Tells whether it stopped.
    #[inline]
    fn walk(&self, ray: &Ray, t_min: f64, t_max: f64, visit: impl FnMut(u32, u32, f64) -> Option<f64>) -> bool {
        if self.nodes.is_empty() || !can_meet(ray, t_min, t_max) {
            return false;
        }
        // A short stack is cheaper to clear; entries never outnumber the levels.
        if self.stats.depth <= 32 {
            self.walk_with::<32>(ray, t_min.max(0.0), t_max, visit)
        } else {
            self.walk_with::<MAX_DEPTH>(ray, t_min.max(0.0), t_max, visit)
        }
    }

    #[inline]
    fn walk_with<const N: usize>(&self, ray: &Ray, t_min: f64, t_max: f64, mut visit: impl FnMut(u32, u32, f64) -> Option<f64>) -> bool {
        let ray = SlabRay::new(ray, self.bounds.max_abs());
        let mut best = t_max;
        let mut stack = [Entry { child: 0, count: 0, t_enter: 0.0 }; N];
        let mut n_stack = 0;
        let mut at = Entry { child: 0, count: 0, t_enter: 0.0 };
        loop {
            if at.child & BVH_LEAF == 0 {
                let node = &self.nodes[at.child as usize];
                let (near, far) = meet(node, &ray, t_min, best);
                let (a, b) = (near[0] <= far[0], near[1] <= far[1]);
                if a || b {
                    let first = if a && b { usize::from(near[1] < near[0]) } else { usize::from(b) };
                    if a && b {
                        let last = first ^ 1;
                        stack[n_stack] = Entry { child: node.child[last], count: node.count[last], t_enter: near[last] };
                        n_stack += 1;
                    }
                    at = Entry { child: node.child[first], count: node.count[first], t_enter: near[first] };
                    continue;
                }
            } else {
                match visit(at.child ^ BVH_LEAF, at.count, best) {
                    Some(t) => best = t,
                    None => return true,
                }
            }
            loop {
                if n_stack == 0 {
                    return false;
                }
                n_stack -= 1;
                if stack[n_stack].t_enter <= best {
                    at = stack[n_stack];
                    break;
                }
            }
        }
    }

    /// The children of a node; a tree that is one leaf has an empty sibling, which is left out.
    fn children(&self, node_ix: u32) -> impl Iterator<Item = BvhChild> {
        let n = &self.nodes[node_ix as usize];
        let all = (0..2).map(|c| BvhChild { bounds: n.child_box(c), child: n.child[c], count: n.count[c] });
        all.filter(|c| c.is_inner() || c.count > 0)
    }

    /// What stands below a node when its children are opened until there are `WIDTH`: the largest first, which rays most likely go into.
    pub(super) fn opened<const WIDTH: usize>(&self, node_ix: u32) -> ArrayVec<BvhChild, WIDTH> {
        let mut open = ArrayVec::new();
        open.extend(self.children(node_ix));
        while open.len() < WIDTH {
            let inner = (0..open.len()).filter(|k| open[*k].is_inner());
            let Some(k) = inner.max_by(|a, b| open[*a].bounds.half_area().total_cmp(&open[*b].bounds.half_area())) else { break };
            let parent = open.swap_remove(k);
            open.extend(self.children(parent.child));
        }
        open
    }

    /// Whether every number in the tree makes sense: children after their parent, each primitive of a leaf below `n_prims`, none twice.
    pub fn is_sound(&self, n_prims: usize) -> bool {
        let mut seen = vec![false; n_prims];
        let refs_once = self.refs.iter().all(|r| seen.get_mut(*r as usize).is_some_and(|s| !std::mem::replace(s, true)));
        refs_once
            && self.nodes.iter().enumerate().all(|(i, n)| {
                (0..2).all(|c| {
                    let (child, count) = (n.child[c], n.count[c]);
                    if child & BVH_LEAF != 0 {
                        (child ^ BVH_LEAF) as usize + count as usize <= self.refs.len()
                    } else {
                        count == 0 && child as usize > i && (child as usize) < self.nodes.len()
                    }
                })
            })
    }
}
