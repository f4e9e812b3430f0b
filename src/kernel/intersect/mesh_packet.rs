//! Many rays against a mesh at once: the hits of `kernel/intersect/mesh`, to the last bit. The rays go through the tree as a packet
//! (`accel/packet`); a face is tested for eight of them side by side, with the operations of the single test.

use super::mesh::{ORDERS, ShearedRay, TOLERANCE, intersect_mesh, offer_pack};
use super::{HitSink, LocalRay, Part};
use crate::accel::{Accel, Bvh8, Fars, GROUPS, LANES, NO_PRIM, PACK, Packet, PacketVisitor, PerRay, round_up};
use crate::compile::shape::MeshShape;
use crate::compile::shape::mesh::Corners;
use crate::compile::shape::triangle_pack::TrianglePack;
use crate::math::MAX_DISTANCE;
use crate::math::simd::{self, Kernel, Simd};

/// As few rays of a group are tested one by one, each against all faces of a leaf.
const FEW_LANES: u32 = 1;

/// What the rays of a packet meet.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub struct PacketHits {
    /// How far each ray looks; where it met something, the depth of that, or below all if any hit was asked for.
    pub far: PerRay<f64>,
    /// Face that is met; [`NO_PRIM`] for none.
    pub face: PerRay<u32>,
    /// Weights of its corners 2 and 3.
    pub a: PerRay<f64>,
    /// See `a`.
    pub b: PerRay<f64>,
    /// Scratch memory: as in [`ShearedRay`], each ray by its own longest axis.
    shear: [PerRay<f64>; 3],
}

impl Default for PacketHits {
    fn default() -> Self {
        let zero = [[0.0; LANES]; GROUPS];
        Self { far: [[f64::NEG_INFINITY; LANES]; GROUPS], face: [[NO_PRIM; LANES]; GROUPS], a: zero, b: zero, shear: [zero; 3] }
    }
}

impl PacketHits {
    /// Nothing met yet by rays that look as far as `far` says for `0..n`.
    #[inline]
    pub fn set(&mut self, n: usize, far: impl Fn(usize) -> f64) {
        self.face = [[NO_PRIM; LANES]; GROUPS];
        for (g, group) in self.far.iter_mut().enumerate().take(n.div_ceil(LANES)) {
            for (l, lane) in group.iter_mut().enumerate() {
                let k = g * LANES + l;
                *lane = if k < n { far(k) } else { f64::NEG_INFINITY };
            }
        }
    }

    /// Depth of what ray `k` met, below all if any hit was asked for; `None` for nothing.
    #[inline]
    pub fn hit(&self, k: usize) -> Option<f64> {
        let (g, l) = (k / LANES % GROUPS, k % LANES);
        (self.face[g][l] != NO_PRIM).then_some(self.far[g][l])
    }

    /// Where ray `k` met the mesh.
    pub fn part(&self, k: usize) -> Part {
        let (g, l) = (k / LANES % GROUPS, k % LANES);
        Part { face: self.face[g][l], a: self.a[g][l], b: self.b[g][l] }
    }
}

/// The nearest hit of each ray of a packet, or (`ANY`) whether it meets anything: what [`intersect_mesh`] finds for it alone.
pub fn intersect_mesh_packet<const ANY: bool>(s: &MeshShape, packet: &Packet, hits: &mut PacketHits) {
    let index = s.index();
    match (&index.tree, &index.corners) {
        (Accel::Bvh8(tree), Corners::Packs(packs)) if s.moving.is_none() => simd::run_widest(Together::<ANY> { tree, packs, packet, hits }),
        _ => (0..packet.len()).for_each(|k| alone::<ANY>(s, packet, hits, k)),
    }
}

/// One ray's place in the hits.
struct Kept<'h, const ANY: bool> {
    far: &'h mut f64,
    face: &'h mut u32,
    a: &'h mut f64,
    b: &'h mut f64,
}

impl<const ANY: bool> HitSink for Kept<'_, ANY> {
    #[inline(always)]
    fn push(&mut self, t: f64, part: Part) {
        (*self.far, *self.face, *self.a, *self.b) = (if ANY { f64::NEG_INFINITY } else { t }, part.face, part.a, part.b);
    }

    #[inline(always)]
    fn far(&self) -> f64 {
        *self.far
    }
}

impl PacketHits {
    #[inline(always)]
    fn sink<const ANY: bool>(&mut self, g: usize, l: usize) -> Kept<'_, ANY> {
        Kept { far: &mut self.far[g][l], face: &mut self.face[g][l], a: &mut self.a[g][l], b: &mut self.b[g][l] }
    }
}

/// A mesh without packs of faces.
fn alone<const ANY: bool>(s: &MeshShape, packet: &Packet, hits: &mut PacketHits, k: usize) {
    let ray = packet.ray(k);
    intersect_mesh(s, &LocalRay { origin: ray.origin, dir: ray.dir, scale: 1.0 }, &mut hits.sink::<ANY>(k / LANES % GROUPS, k % LANES));
}

struct Together<'a, const ANY: bool> {
    tree: &'a Bvh8,
    packs: &'a [TrianglePack],
    packet: &'a Packet,
    hits: &'a mut PacketHits,
}

impl<const ANY: bool> Kernel for Together<'_, ANY> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        let (packet, n_groups) = (self.packet, self.packet.n_groups().min(GROUPS));
        let mut far = [[f32::NEG_INFINITY; LANES]; GROUPS];
        let mut found = Crossings::<ANY> { packs: self.packs, faces: &self.tree.slots, packet, longest: [[0; 3]; GROUPS], hits: self.hits };
        for g in 0..n_groups {
            for l in 0..LANES {
                let t = found.hits.far[g][l].min(MAX_DISTANCE);
                (found.hits.far[g][l], far[g][l]) = (t, round_up(t));
            }
            found.longest[g] = longest_axes(s, packet, g);
            for axis in 0..3 {
                let lanes = found.longest[g][axis];
                if lanes != 0 {
                    found.shear_along(s, axis, g, lanes);
                }
            }
        }
        self.tree.visit_packet(s, packet, 0.0, &mut far, &mut found);
    }
}

/// A bit for each ray of a group that is longest along x, y and z: the rule of `axes_along`.
#[inline(always)]
fn longest_axes<S: Simd>(s: S, packet: &Packet, g: usize) -> [u32; 3] {
    let zero = s.splat_x8(0.0);
    let (x, y, z) = (s.load_x8(&packet.dir[0][g]), s.load_x8(&packet.dir[1][g]), s.load_x8(&packet.dir[2][g]));
    let (x, y, z) = (s.max_x8(x, s.sub_x8(zero, x)), s.max_x8(y, s.sub_x8(zero, y)), s.max_x8(z, s.sub_x8(zero, z)));
    let along_x = s.lt_x8(y, x) & s.lt_x8(z, x);
    let along_y = s.lt_x8(z, y) & !along_x;
    [along_x, along_y, 0xff & !along_x & !along_y]
}

/// What the rays of a packet found of a mesh so far.
struct Crossings<'a, const ANY: bool> {
    packs: &'a [TrianglePack],
    /// Slot by slot.
    faces: &'a [u32],
    packet: &'a Packet,
    /// By group: the rays that are longest along each axis.
    longest: [[u32; 3]; GROUPS],
    hits: &'a mut PacketHits,
}

impl<const ANY: bool> PacketVisitor for Crossings<'_, ANY> {
    #[inline(always)]
    fn leaf<S: Simd>(&mut self, simd: S, first: u32, count: u32, rays: u64, far: &mut Fars) -> bool {
        let pack = &self.packs[first as usize / PACK];
        let faces = &self.faces[first as usize..(first + count) as usize];
        let mut met = false;
        for g in 0..self.packet.n_groups().min(GROUPS) {
            let here = (rays >> (g * LANES)) as u32 & 0xff;
            if here == 0 {
                continue;
            }
            for axis in 0..3 {
                let lanes = here & self.longest[g][axis];
                if lanes == 0 {
                    continue;
                }
                met |= if lanes.count_ones() <= FEW_LANES {
                    self.one_by_one(simd, pack, faces, axis, g, lanes, far)
                } else {
                    self.side_by_side(simd, pack, faces, axis, g, lanes, far)
                };
            }
        }
        met
    }
}

impl<const ANY: bool> Crossings<'_, ANY> {
    /// Makes rays of a group ready that are longest along `axis`.
    #[inline(always)]
    fn shear_along<S: Simd>(&mut self, s: S, axis: usize, g: usize, lanes: u32) {
        let [x, y, z] = ORDERS[axis];
        let inv = s.div_x8(s.splat_x8(1.0), s.load_x8(&self.packet.dir[z][g]));
        let shear = [
            s.array_x8(s.mul_x8(s.load_x8(&self.packet.dir[x][g]), inv)),
            s.array_x8(s.mul_x8(s.load_x8(&self.packet.dir[y][g]), inv)),
            s.array_x8(inv),
        ];
        for (all, new) in self.hits.shear.iter_mut().zip(&shear) {
            if lanes == 0xff {
                all[g] = *new;
                continue;
            }
            for l in 0..LANES {
                all[g][l] = if lanes >> l & 1 == 1 { new[l] } else { all[g][l] };
            }
        }
    }

    #[inline(always)]
    fn one_by_one<S: Simd>(
        &mut self,
        simd: S,
        pack: &TrianglePack,
        faces: &[u32],
        last_axis: usize,
        g: usize,
        mut lanes: u32,
        far: &mut Fars,
    ) -> bool {
        let [x, y, z] = ORDERS[last_axis];
        let (mut met, origin) = (false, &self.packet.origin);
        while lanes != 0 {
            let l = lanes.trailing_zeros() as usize % LANES;
            lanes &= lanes - 1;
            let ray = ShearedRay {
                origin: [origin[x][g][l], origin[y][g][l], origin[z][g][l]],
                shear: [self.hits.shear[0][g][l], self.hits.shear[1][g][l], self.hits.shear[2][g][l]],
                axes: [x, y, z],
            };
            let (before, last) = self.last(g, l);
            let t = offer_pack(simd, &ray, pack, faces, &mut self.hits.sink::<ANY>(g, l), &mut (before, last), before);
            if t < before {
                far[g][l] = round_up(t);
                met = true;
            }
        }
        met
    }

    /// Depth and face of a ray's last hit; how far it looks, and no face.
    #[inline(always)]
    fn last(&self, g: usize, l: usize) -> (f64, u32) {
        (self.hits.far[g][l], self.hits.face[g][l])
    }

    /// The numbers of [`ShearedRay::hit`], to the last bit, for eight rays.
    #[inline(always)]
    fn side_by_side<S: Simd>(
        &mut self,
        s: S,
        pack: &TrianglePack,
        faces: &[u32],
        axis: usize,
        g: usize,
        lanes: u32,
        far: &mut Fars,
    ) -> bool {
        let zero = s.splat_x8(0.0);
        let [x, y, z] = ORDERS[axis];
        let origin = &self.packet.origin;
        let origin = [s.load_x8(&origin[x][g]), s.load_x8(&origin[y][g]), s.load_x8(&origin[z][g])];
        let shear = [s.load_x8(&self.hits.shear[0][g]), s.load_x8(&self.hits.shear[1][g])];
        let mut any = false;
        for (k, face) in faces.iter().enumerate() {
            let of = |corner: usize| {
                [pack.0[corner][x][k % PACK].into(), pack.0[corner][y][k % PACK].into(), pack.0[corner][z][k % PACK].into()]
            };
            let (a, b, c) = (moved(s, of(0), origin, shear), moved(s, of(1), origin, shear), moved(s, of(2), origin, shear));
            let (w1, w2, w3) = (edge(s, c, b), edge(s, a, c), edge(s, b, a));
            let (least, most) = (s.min_x8(w1, s.min_x8(w2, w3)), s.max_x8(w1, s.max_x8(w2, w3)));
            let met = lanes & !(s.lt_x8(least, zero) & s.lt_x8(zero, most));
            if met == 0 {
                continue;
            }
            let det = s.add_x8(s.add_x8(w1, w2), w3);
            let sum = s.add_x8(s.add_x8(s.mul_x8(w1, a[2]), s.mul_x8(w2, b[2])), s.mul_x8(w3, c[2]));
            let t = s.div_x8(s.mul_x8(s.load_x8(&self.hits.shear[2][g]), sum), det);
            let before = s.load_x8(&self.hits.far[g]);
            let (beyond, nearer) = (s.lt_x8(before, t), s.lt_x8(t, before));
            let mut met = met & !beyond & s.lt_x8(s.splat_x8(TOLERANCE), t) & s.lt_x8(t, s.splat_x8(MAX_DISTANCE));
            // On an edge the face that comes first in the mesh wins, whatever the order of the tree.
            let mut ties = met & !nearer;
            while ties != 0 {
                let l = ties.trailing_zeros() as usize % LANES;
                ties &= ties - 1;
                met &= if *face < self.hits.face[g][l] { u32::MAX } else { !(1 << l) };
            }
            if met == 0 {
                continue;
            }
            any = true;
            let hits = &mut *self.hits;
            let now = if ANY { s.splat_x8(f64::NEG_INFINITY) } else { t };
            hits.far[g] = s.array_x8(s.select_x8(met, now, before));
            hits.a[g] = s.array_x8(s.select_x8(met, s.div_x8(w2, det), s.load_x8(&hits.a[g])));
            hits.b[g] = s.array_x8(s.select_x8(met, s.div_x8(w3, det), s.load_x8(&hits.b[g])));
            // Upward: more than the rounding.
            let up = s.mul_f32(s.narrow_x8(now), s.splat_f32(1.0 + f32::EPSILON));
            far[g] = s.array_f32(s.select_f32(met, up, s.load_f32(&far[g])));
            for l in 0..LANES {
                hits.face[g][l] = if met >> l & 1 == 1 { *face } else { hits.face[g][l] };
            }
        }
        any
    }
}

/// A corner, moved and sheared for each ray.
#[inline(always)]
fn moved<S: Simd>(s: S, corner: [f64; 3], origin: [S::F64x8; 3], shear: [S::F64x8; 2]) -> [S::F64x8; 3] {
    let x = s.sub_x8(s.splat_x8(corner[0]), origin[0]);
    let y = s.sub_x8(s.splat_x8(corner[1]), origin[1]);
    let z = s.sub_x8(s.splat_x8(corner[2]), origin[2]);
    [s.sub_x8(x, s.mul_x8(shear[0], z)), s.sub_x8(y, s.mul_x8(shear[1], z)), z]
}

/// Edge function of two corners.
#[inline(always)]
fn edge<S: Simd>(s: S, a: [S::F64x8; 3], b: [S::F64x8; 3]) -> S::F64x8 {
    s.sub_x8(s.mul_x8(a[0], b[1]), s.mul_x8(a[1], b[0]))
}
