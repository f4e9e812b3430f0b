//! Up to 64 rays together through the wide BVH. Where they run alike, one test of a node's eight boxes against all of them at once (interval
//! arithmetic over origins and slopes) says which children to visit; at the children each ray asks for itself, eight side by side. Where few
//! rays are left, they go on one by one.
//!
//! Conservative as [`super::bvh8`]: what a single ray would be offered, it is offered here. Sources: Wald, Boulos, Shirley 2007 (ranges of rays
//! in packets); Wald, Woop, Benthin, Johnson, Ernst 2014 (Embree's coherent packets).

use super::boxf::round_down;
use super::bvh8::{BVH8_LEAF, Bvh8, Bvh8Node, Bvh8Ray, LeafVisitor, MAX_STACK, SCALE_SLACK, STEEPEST, WIDTH, leaf_slots, overlap, walk};
use super::stack::Room;
use crate::math::simd::{Kernel, Simd};
use crate::math::{DVec3, Ray};

/// Rays side by side.
pub const LANES: usize = 8;
/// Groups of lanes in a packet.
pub const GROUPS: usize = 8;
/// Most rays of a packet.
pub const PACKET: usize = LANES * GROUPS;
/// As few rays leave a packet and walk on alone.
const FEW: u32 = 3;

/// A number for each ray of a packet, `[group][lane]`.
pub type PerRay<T> = [[T; LANES]; GROUPS];
/// Depths beyond which nothing matters, rounded up; below any depth for a ray that wants nothing more.
pub type Fars = PerRay<f32>;

/// Rays side by side; a ray is bit `8 group + lane` of a mask. Lanes without a ray repeat one.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub struct Packet {
    /// Starts, by axis.
    pub origin: [PerRay<f64>; 3],
    /// Directions, by axis.
    pub dir: [PerRay<f64>; 3],
    /// Number of rays, the first of all lanes.
    n: usize,
}

impl Default for Packet {
    fn default() -> Self {
        Self { origin: [[[0.0; LANES]; GROUPS]; 3], dir: [[[1.0; LANES]; GROUPS]; 3], n: 0 }
    }
}

impl Packet {
    /// Takes the rays that `ray` gives for `0..n`, at most [`PACKET`], in place of those it had.
    #[inline]
    pub fn set(&mut self, n: usize, mut ray: impl FnMut(usize) -> Ray) {
        self.n = n.min(PACKET);
        for g in 0..self.n_groups().min(GROUPS) {
            for l in 0..LANES {
                let r = ray((g * LANES + l).min(self.n - 1));
                for axis in 0..3 {
                    self.origin[axis][g][l] = r.origin[axis];
                    self.dir[axis][g][l] = r.dir[axis];
                }
            }
        }
    }

    /// Takes `n` rays, at most [`PACKET`], that start in one point. `fill` gets the directions by axis, of which it writes the first `n`.
    #[inline]
    pub fn set_from(&mut self, origin: DVec3, n: usize, fill: impl FnOnce(&mut [[f64; PACKET]; 3])) {
        self.n = n.min(PACKET);
        fill(bytemuck::cast_mut(&mut self.dir));
        let lanes = self.n_groups().min(GROUPS) * LANES;
        for axis in 0..3 {
            self.origin[axis][..lanes / LANES].fill([origin[axis]; LANES]);
            let dir: &mut [f64; PACKET] = bytemuck::cast_mut(&mut self.dir[axis]);
            if self.n > 0 {
                let last = dir[self.n - 1];
                dir[self.n..lanes].fill(last);
            }
        }
    }

    /// Number of rays.
    #[inline]
    pub fn len(&self) -> usize {
        self.n
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.n == 0
    }

    /// Groups with rays.
    #[inline]
    pub fn n_groups(&self) -> usize {
        self.n.div_ceil(LANES)
    }

    /// A bit for each lane of a group whose ray can meet anything: finite, with a direction.
    #[inline(always)]
    fn usable<S: Simd>(&self, s: S, group: usize) -> u32 {
        let zero = s.splat_x8(0.0);
        // 0 times what is not finite is NaN.
        let (mut none, mut along) = (zero, zero);
        for k in 0..3 {
            let (o, d) = (s.load_x8(&self.origin[k][group]), s.load_x8(&self.dir[k][group]));
            none = s.add_x8(none, s.add_x8(s.mul_x8(o, zero), s.mul_x8(d, zero)));
            along = s.max_x8(along, s.max_x8(d, s.sub_x8(zero, d)));
        }
        s.lt_x8(zero, along) & s.lt_x8(none, s.splat_x8(1.0))
    }

    /// One of the rays.
    #[inline]
    pub fn ray(&self, k: usize) -> Ray {
        let of = |v: &[PerRay<f64>; 3]| {
            let (g, l) = (k / LANES % GROUPS, k % LANES);
            DVec3::new(v[0][g][l], v[1][g][l], v[2][g][l])
        };
        Ray::new(of(&self.origin), of(&self.dir))
    }
}

/// What is done at leaves.
pub trait PacketVisitor {
    /// Tests the primitives in slots `first..first + count` (`first` is a multiple of [`super::PACK`]) for some of the rays; shortens the
    /// `far` of those that met something, and tells whether it did. `#[inline(always)]`.
    fn leaf<S: Simd>(&mut self, simd: S, first: u32, count: u32, rays: u64, far: &mut Fars) -> bool;
}

impl Bvh8 {
    /// Visits leaves along the rays of a packet, near ones first, in a kernel that [`crate::math::simd::run_widest`] runs. `far` holds how far each ray
    /// looks, rounded up; below all where there is no ray.
    #[inline(always)]
    pub fn visit_packet<S: Simd>(&self, simd: S, packet: &Packet, t_min: f64, far: &mut Fars, visitor: &mut impl PacketVisitor) {
        if !self.nodes.is_empty() && packet.n > 0 {
            Together { tree: self, packet, t_min: round_down(t_min.max(0.0)), far, visitor }.run(simd);
        }
    }
}

/// The slabs of eight rays: as [`Bvh8Ray`], `[axis][lane]`.
#[derive(Clone, Copy)]
struct Slabs8 {
    enter: [[f32; LANES]; 3],
    inv_enter: [[f32; LANES]; 3],
    exit: [[f32; LANES]; 3],
    inv_exit: [[f32; LANES]; 3],
}

impl Slabs8 {
    const NONE: Self =
        Self { enter: [[0.0; LANES]; 3], inv_enter: [[0.0; LANES]; 3], exit: [[0.0; LANES]; 3], inv_exit: [[0.0; LANES]; 3] };

    /// A group of a packet, in a tree whose largest absolute coordinate is `max_abs`: the numbers of [`Bvh8Ray::new`].
    #[inline(always)]
    fn new<S: Simd>(s: S, packet: &Packet, group: usize, max_abs: f32) -> Self {
        let o = [
            s.narrow_x8(s.load_x8(&packet.origin[0][group])),
            s.narrow_x8(s.load_x8(&packet.origin[1][group])),
            s.narrow_x8(s.load_x8(&packet.origin[2][group])),
        ];
        let zero = s.splat_f32(0.0);
        let size = |v| s.copysign_f32(v, zero);
        let largest = s.max_f32(size(o[0]), s.max_f32(size(o[1]), size(o[2])));
        let slack = s.mul_f32(s.splat_f32(f32::EPSILON), s.add_f32(largest, s.splat_f32(max_abs)));
        let mut out = Self::NONE;
        for k in 0..3 {
            let d = s.narrow_x8(s.load_x8(&packet.dir[k][group]));
            let inv = s.div_f32(s.splat_f32(1.0), d);
            let inv = s.min_f32(s.max_f32(inv, s.splat_f32(-STEEPEST)), s.splat_f32(STEEPEST));
            let toward = s.copysign_f32(slack, inv);
            out.enter[k] = s.array_f32(s.add_f32(o[k], toward));
            out.inv_enter[k] = s.array_f32(s.mul_f32(inv, s.splat_f32(1.0 - SCALE_SLACK)));
            out.exit[k] = s.array_f32(s.sub_f32(o[k], toward));
            out.inv_exit[k] = s.array_f32(s.mul_f32(inv, s.splat_f32(1.0 + SCALE_SLACK)));
        }
        out
    }

    /// A bit for each ray that runs down an axis, or not at all along it.
    #[inline(always)]
    fn down<S: Simd>(&self, s: S, axis: usize) -> u32 {
        s.le_f32(s.load_f32(&self.inv_enter[axis]), s.splat_f32(0.0))
    }

    /// The rays that meet a child's box up to their `far`.
    #[inline(always)]
    fn meet<S: Simd>(&self, s: S, node: &Bvh8Node, child: usize, near: [usize; 3], t_min: f32, far: &[f32; LANES]) -> u32 {
        let slabs = [self.slab(s, node, child, near, 0), self.slab(s, node, child, near, 1), self.slab(s, node, child, near, 2)];
        overlap(s, slabs, s.splat_f32(t_min), s.load_f32(far)).0
    }

    #[inline(always)]
    fn slab<S: Simd>(&self, s: S, node: &Bvh8Node, child: usize, near: [usize; 3], k: usize) -> (S::F32x8, S::F32x8) {
        let side = near[k] & 1;
        let (first, last) = (s.splat_f32(node.planes[k][side][child]), s.splat_f32(node.planes[k][side ^ 1][child]));
        (
            s.mul_f32(s.sub_f32(first, s.load_f32(&self.enter[k])), s.load_f32(&self.inv_enter[k])),
            s.mul_f32(s.sub_f32(last, s.load_f32(&self.exit[k])), s.load_f32(&self.inv_exit[k])),
        )
    }

    /// One of the rays.
    #[inline(always)]
    fn ray(&self, lane: usize, near: [usize; 3]) -> Bvh8Ray {
        let of = |v: &[[f32; LANES]; 3]| [v[0][lane], v[1][lane], v[2][lane]];
        Bvh8Ray { enter: of(&self.enter), inv_enter: of(&self.inv_enter), exit: of(&self.exit), inv_exit: of(&self.inv_exit), near }
    }
}

/// All rays of a packet as one: no ray enters a box before this says, or leaves it after.
struct Beam {
    /// Per axis: the start that enters first, the start that leaves last.
    enter: [f32; 3],
    exit: [f32; 3],
    /// Least and greatest slope on the way in, and on the way out.
    inv_enter: [[f32; 2]; 3],
    inv_exit: [[f32; 2]; 3],
    near: [usize; 3],
}

impl Beam {
    /// Of some rays of one octant, at least one.
    #[inline(always)]
    fn new<S: Simd>(s: S, groups: &[Slabs8], rays: u64) -> Self {
        let mut b = Self { enter: [0.0; 3], exit: [0.0; 3], inv_enter: [[0.0; 2]; 3], inv_exit: [[0.0; 2]; 3], near: [0; 3] };
        let first = rays.trailing_zeros() as usize;
        for k in 0..3 {
            b.near[k] = (groups[first / LANES].down(s, k) >> (first % LANES) & 1) as usize;
            let (enter, exit) = (range(s, groups, rays, |g| &g.enter[k]), range(s, groups, rays, |g| &g.exit[k]));
            // Up the axis, the start farthest up is nearest to what lies ahead.
            (b.enter[k], b.exit[k]) = if b.near[k] == 1 { (enter[0], exit[1]) } else { (enter[1], exit[0]) };
            b.inv_enter[k] = range(s, groups, rays, |g| &g.inv_enter[k]);
            b.inv_exit[k] = range(s, groups, rays, |g| &g.inv_exit[k]);
        }
        b
    }

    /// A bit for each child whose box any ray may meet in `t_min..=t_max`, and where the first may enter.
    #[inline(always)]
    fn meet<S: Simd>(&self, s: S, node: &Bvh8Node, t_min: f32, t_max: f32) -> (u32, [f32; WIDTH]) {
        let slabs = [self.slab(s, node, 0), self.slab(s, node, 1), self.slab(s, node, 2)];
        let (met, near) = overlap(s, slabs, s.splat_f32(t_min), s.splat_f32(t_max));
        (met, s.array_f32(near))
    }

    #[inline(always)]
    fn slab<S: Simd>(&self, s: S, node: &Bvh8Node, k: usize) -> (S::F32x8, S::F32x8) {
        let side = self.near[k] & 1;
        let first = s.sub_f32(s.load_f32(&node.planes[k][side]), s.splat_f32(self.enter[k]));
        let last = s.sub_f32(s.load_f32(&node.planes[k][side ^ 1]), s.splat_f32(self.exit[k]));
        let [a, b] = self.inv_enter[k];
        let [c, d] = self.inv_exit[k];
        (
            s.min_f32(s.mul_f32(first, s.splat_f32(a)), s.mul_f32(first, s.splat_f32(b))),
            s.max_f32(s.mul_f32(last, s.splat_f32(c)), s.mul_f32(last, s.splat_f32(d))),
        )
    }
}

/// Least and greatest of some rays' numbers.
#[inline(always)]
fn range<S: Simd>(s: S, groups: &[Slabs8], rays: u64, of: impl Fn(&Slabs8) -> &[f32; LANES]) -> [f32; 2] {
    let (mut low, mut high) = (s.splat_f32(f32::INFINITY), s.splat_f32(f32::NEG_INFINITY));
    for (g, group) in groups.iter().enumerate() {
        let among = (rays >> (g * LANES)) as u32 & 0xff;
        if among == 0xff {
            let v = s.load_f32(of(group));
            (low, high) = (s.min_f32(v, low), s.max_f32(v, high));
        } else if among != 0 {
            let some = of(group)[among.trailing_zeros() as usize % LANES];
            let mut v = *of(group);
            for (l, v) in v.iter_mut().enumerate() {
                *v = if among >> l & 1 == 1 { *v } else { some };
            }
            let v = s.load_f32(&v);
            (low, high) = (s.min_f32(v, low), s.max_f32(v, high));
        }
    }
    let (low, high) = (s.array_f32(low), s.array_f32(high));
    let least = |a: f32, b: f32| if a < b { a } else { b };
    let a = least(least(low[0], low[1]), least(low[2], low[3]));
    [least(a, least(least(low[4], low[5]), least(low[6], low[7]))), greatest(&high)]
}

#[inline(always)]
fn greatest(v: &[f32; LANES]) -> f32 {
    let more = |a: f32, b: f32| if a > b { a } else { b };
    more(more(more(v[0], v[1]), more(v[2], v[3])), more(more(v[4], v[5]), more(v[6], v[7])))
}

/// A child to visit later: where the first ray enters it in the upper half, its place (node times eight and child) in the lower; and the
/// rays that may meet it.
#[derive(Clone, Copy)]
struct Entry {
    key: u64,
    rays: u64,
}

/// A walk of all rays.
struct Together<'t, V> {
    tree: &'t Bvh8,
    packet: &'t Packet,
    t_min: f32,
    far: &'t mut Fars,
    visitor: &'t mut V,
}

impl<V: PacketVisitor> Kernel for Together<'_, V> {
    type Output = ();

    /// Each octant by itself.
    #[inline(always)]
    fn run<S: Simd>(mut self, simd: S) {
        let n_groups = self.packet.n_groups().min(GROUPS);
        let mut room = Room::<Slabs8, GROUPS>::new();
        let mut groups = room.stack();
        let max_abs = self.tree.max_abs;
        let (mut down, mut todo) = ([0u64; 3], 0u64);
        for g in 0..n_groups {
            todo |= u64::from(self.packet.usable(simd, g)) << (g * LANES);
            let group = Slabs8::new(simd, self.packet, g, max_abs);
            for k in 0..3 {
                down[k] |= u64::from(group.down(simd, k)) << (g * LANES);
            }
            groups.push(group);
        }
        let groups = &*groups.into_items();
        todo &= u64::MAX >> (PACKET - self.packet.n.clamp(1, PACKET));
        while todo != 0 {
            let first = todo.trailing_zeros();
            let rays = down.iter().fold(todo, |rays, down| rays & if down >> first & 1 == 1 { *down } else { !down });
            todo &= !rays;
            self.walk_octant(simd, groups, rays);
        }
    }
}

impl<V: PacketVisitor> Together<'_, V> {
    #[inline(always)]
    fn walk_octant<S: Simd>(&mut self, simd: S, groups: &[Slabs8], mut rays: u64) {
        let tree = self.tree;
        let beam = Beam::new(simd, groups, rays);
        let mut far = farthest(self.far);
        let mut room = Room::<Entry, MAX_STACK>::new();
        let mut stack = room.stack();
        let mut at = 0u32;
        loop {
            // An inner node that is to be entered.
            let node = &tree.nodes[at as usize];
            let (mut met, t_enter) = beam.meet(simd, node, self.t_min, far);
            let bottom = stack.len();
            while met != 0 {
                let c = met.trailing_zeros() as usize & 7;
                met &= met - 1;
                let new = Entry { key: u64::from(t_enter[c].to_bits()) << 32 | u64::from(at) << 3 | c as u64, rays };
                stack.push(new);
                // Nearest on top.
                let list = &mut stack.items()[bottom..];
                let mut k = list.len() - 1;
                while k > 0 && list[k - 1].key < new.key {
                    list[k] = list[k - 1];
                    k -= 1;
                }
                list[k] = new;
            }
            // The next inner node that some ray meets; leaves on the way.
            loop {
                let Some(next) = stack.pop() else { return };
                if f32::from_bits((next.key >> 32) as u32) > far {
                    continue;
                }
                let place = next.key as u32;
                let (parent, c) = (&tree.nodes[place as usize >> 3], place as usize & 7);
                let child = parent.child[c];
                let mut left = 0;
                for (g, group) in groups.iter().enumerate() {
                    let among = (next.rays >> (g * LANES)) as u32 & 0xff;
                    if among != 0 {
                        let met = group.meet(simd, parent, c, beam.near, self.t_min, &self.far[g]) & among;
                        left |= u64::from(met) << (g * LANES);
                    }
                }
                if left == 0 {
                    continue;
                }
                if child & BVH8_LEAF != 0 {
                    let (first, count) = leaf_slots(child);
                    if self.visitor.leaf(simd, first, count, left, self.far) {
                        far = farthest(self.far);
                    }
                    continue;
                }
                if left.count_ones() > FEW {
                    (at, rays) = (child, left);
                    break;
                }
                while left != 0 {
                    let k = left.trailing_zeros() as usize;
                    left &= left - 1;
                    let (g, lane) = (k / LANES % GROUPS, k % LANES);
                    let ray = groups[g].ray(lane, beam.near);
                    let t_max = f64::from(self.far[g][lane]);
                    let alone = &mut Alone { visitor: self.visitor, ray: k, far: self.far };
                    walk(simd, tree, child, &ray, self.t_min, t_max, alone);
                }
                far = farthest(self.far);
            }
        }
    }
}

/// The depth that still matters to any ray.
#[inline(always)]
fn farthest(far: &Fars) -> f32 {
    let mut most = far[0];
    for group in &far[1..] {
        for l in 0..LANES {
            most[l] = if group[l] > most[l] { group[l] } else { most[l] };
        }
    }
    greatest(&most)
}

/// One ray of a packet on a walk of its own.
struct Alone<'v, V> {
    visitor: &'v mut V,
    ray: usize,
    far: &'v mut Fars,
}

impl<V: PacketVisitor> LeafVisitor for Alone<'_, V> {
    #[inline(always)]
    fn leaf<S: Simd>(&mut self, simd: S, first: u32, count: u32, _: f64) -> Option<f64> {
        self.visitor.leaf(simd, first, count, 1 << self.ray, self.far);
        Some(self.far[self.ray / LANES % GROUPS][self.ray % LANES].into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::{AccelOptions, TrianglePrims};
    use crate::math::random::SplitMix64;
    use crate::math::simd::{self, Portable};
    use crate::math::{DVec3, Vec3};

    /// Notes what it is offered; a ray may look no farther than a depth of its own after its first leaf.
    struct Notes<'n> {
        offers: &'n mut Vec<(u32, u32, u64)>,
        shorten: bool,
    }

    impl PacketVisitor for Notes<'_> {
        #[inline(always)]
        fn leaf<S: Simd>(&mut self, _: S, first: u32, count: u32, rays: u64, far: &mut Fars) -> bool {
            self.offers.push((first, count, rays));
            for k in 0..PACKET {
                if self.shorten && rays >> k & 1 == 1 {
                    let far = &mut far[k / LANES][k % LANES];
                    *far = far.min(2.0 + 0.01 * k as f32);
                }
            }
            self.shorten
        }
    }

    enum Lanes {
        Plain,
        Avx2,
        Widest,
    }

    #[test]
    fn all_kinds_of_lanes_offer_the_same_and_single_rays_are_offered_no_more() {
        let mut numbers = SplitMix64(8);
        let vertices: Vec<Vec3> = (0..3000)
            .map(|_| numbers.direction())
            .flat_map(|p| [p, p + DVec3::splat(0.02), p - DVec3::new(0.03, 0.0, 0.01)].map(|p| p.as_vec3()))
            .collect();
        let faces: Vec<[u32; 3]> = (0..3000).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
        let tree = Bvh8::build(&TrianglePrims { vertices: &vertices, faces: &faces }, &AccelOptions { pack: 4, ..AccelOptions::default() });
        let mut n_offers = 0;
        for _ in 0..200 {
            let (from, to) = (2.0 * numbers.direction(), 0.5 * numbers.direction());
            let n = 1 + numbers.below(PACKET);
            let rays: Vec<Ray> = (0..n).map(|_| Ray::new(from, to + 0.1 * numbers.direction() - from)).collect();
            let mut packet = Packet::default();
            packet.set(n, |k| rays[k]);
            let walk = |shorten, lanes| {
                let (mut offers, mut far) = (Vec::new(), [[5.0; LANES]; GROUPS]);
                let visitor = &mut Notes { offers: &mut offers, shorten };
                let walk = Together { tree: &tree, packet: &packet, t_min: 0.0, far: &mut far, visitor };
                match lanes {
                    Lanes::Plain => walk.run(Portable),
                    Lanes::Avx2 => simd::run(walk),
                    Lanes::Widest => simd::run_widest(walk),
                }
                offers
            };
            let a = walk(true, Lanes::Plain);
            assert!(a == walk(true, Lanes::Avx2) && a == walk(true, Lanes::Widest));
            let all = walk(false, Lanes::Widest);
            assert!(a.len() <= all.len());
            n_offers += a.len();
            for (k, ray) in rays.iter().enumerate() {
                tree.closest_slots(ray, 0.0, 5.0, |slot, _| {
                    let offered = |(first, _, rays): &(u32, u32, u64)| *first == slot & !3 && rays >> k & 1 == 1;
                    assert!(all.iter().any(offered), "ray {k} alone is offered {slot}");
                    None
                });
            }
        }
        assert!(n_offers > 1000, "{n_offers}");
    }
}
