//! Shadow rays together: which of them an opaque thing stops, which may cross clear things. For rays that start in one point or end in one,
//! such as those to the points of an area light, the scene's tree is walked once (`accel/packet`).

use super::traverse::{Nearest, is_blocker, meets_plain};
use crate::accel::{Accel, Bvh8, Fars, GROUPS, LANES, PACKET, Packet, PacketVisitor, round_up};
use crate::compile::CompiledScene;
use crate::compile::geometry::prim_flags;
use crate::math::Ray;
use crate::math::simd::{self, Kernel, Simd};

/// What stands in the way of the rays of a packet, a bit a ray.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ShadowMasks {
    /// Stopped by something opaque.
    pub blocked: u64,
    /// Not stopped, but something clear is met: only [`super::traverse::intersect_shadow`] tells what, and how far.
    pub clear: u64,
    /// What stopped one of them; `u32::MAX` for nothing.
    pub blocker: u32,
}

/// As [`super::traverse::intersect_shadow`] for ray `k` up to `far(k)`, told for all rays at once: the same rays are stopped, the same meet
/// nothing. `last` (a primitive or `u32::MAX`) is tried first. `None` where the scene's tree is of a kind that packets do not go through.
pub fn intersect_shadows(scene: &CompiledScene, packet: &Packet, t_min: f64, far: &[f64; PACKET], last: u32) -> Option<ShadowMasks> {
    let g = &scene.geometry;
    let tree = match &g.tree {
        Accel::Bvh8(tree) if tree.is_single => Some(tree),
        Accel::Brute(0) => None,
        _ => return None,
    };
    let masks = ShadowMasks { blocker: u32::MAX, ..ShadowMasks::default() };
    let mut shadows = Shadows { scene, packet, t_min, t_max: far, last, masks, bounds_asked: [(u32::MAX, true); PACKET] };
    let all = u64::MAX >> (PACKET - packet.len().clamp(1, PACKET));
    if g.prims.get(last as usize).is_some_and(is_blocker) {
        shadows.test(last, all);
    }
    if let Some(tree) = tree
        && shadows.masks.blocked != all
    {
        let mut fars = [[f32::NEG_INFINITY; LANES]; GROUPS];
        for k in (0..packet.len()).filter(|k| shadows.masks.blocked >> k & 1 == 0) {
            fars[k / LANES % GROUPS][k % LANES] = round_up(far[k]);
        }
        simd::run_widest(Walk { tree, t_min, fars, shadows: &mut shadows });
    }
    for prim_ix in &g.unbounded {
        shadows.offer(*prim_ix, all);
    }
    shadows.masks.clear &= !shadows.masks.blocked;
    Some(shadows.masks)
}

struct Walk<'w, 'a> {
    tree: &'a Bvh8,
    t_min: f64,
    fars: Fars,
    shadows: &'w mut Shadows<'a>,
}

impl Kernel for Walk<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(mut self, simd: S) {
        self.tree.visit_packet(
            simd,
            self.shadows.packet,
            self.t_min,
            &mut self.fars,
            &mut Leaves { tree: self.tree, shadows: self.shadows },
        );
    }
}

struct Leaves<'w, 'a> {
    tree: &'a Bvh8,
    shadows: &'w mut Shadows<'a>,
}

impl PacketVisitor for Leaves<'_, '_> {
    #[inline(always)]
    fn leaf<S: Simd>(&mut self, _: S, first: u32, _: u32, rays: u64, far: &mut Fars) -> bool {
        let prim_ix = self.shadows.scene.geometry.bounded[self.tree.slots[first as usize] as usize];
        let mut stopped = self.shadows.offer(prim_ix, rays);
        let any = stopped != 0;
        while stopped != 0 {
            let k = stopped.trailing_zeros() as usize;
            stopped &= stopped - 1;
            far[k / LANES % GROUPS][k % LANES] = f32::NEG_INFINITY;
        }
        any
    }
}

struct Shadows<'a> {
    scene: &'a CompiledScene,
    packet: &'a Packet,
    t_min: f64,
    t_max: &'a [f64; PACKET],
    last: u32,
    masks: ShadowMasks,
    /// By ray: the object whose bounds were asked last, and the answer.
    bounds_asked: [(u32, bool); PACKET],
}

impl Shadows<'_> {
    /// Tests a primitive that throws shadows for those of `rays` to which it may matter; gives those that it stops.
    fn offer(&mut self, prim_ix: u32, rays: u64) -> u64 {
        let flags = self.scene.geometry.prims[prim_ix as usize].flags;
        if flags & prim_flags::NO_SHADOW != 0 || prim_ix == self.last {
            return 0;
        }
        self.test(prim_ix, rays)
    }

    fn test(&mut self, prim_ix: u32, rays: u64) -> u64 {
        let prim = &self.scene.geometry.prims[prim_ix as usize];
        let is_clear = prim.flags & prim_flags::TRANSPARENT != 0;
        // That a ray meets something clear need not be found twice.
        let mut todo = rays & !self.masks.blocked & if is_clear { !self.masks.clear } else { u64::MAX };
        let mut met = 0;
        while todo != 0 {
            let k = todo.trailing_zeros() as usize % PACKET;
            todo &= todo - 1;
            let ray: Ray = self.packet.ray(k);
            let is_met = meets_plain(&self.scene.geometry, prim, &ray, self.t_min, self.t_max[k]).unwrap_or_else(|| {
                let mut any = Nearest::any(self.scene, &ray, self.t_min, self.t_max[k], self.bounds_asked[k]);
                any.test(prim_ix);
                self.bounds_asked[k] = any.bounds_asked();
                any.found()
            });
            met |= u64::from(is_met) << k;
        }
        if is_clear {
            self.masks.clear |= met;
            return 0;
        }
        if met != 0 {
            self.masks.blocked |= met;
            self.masks.blocker = prim_ix;
        }
        met
    }
}
