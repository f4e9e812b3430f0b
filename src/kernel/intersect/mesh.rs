//! Triangles of meshes: watertight tests in double precision on 32-bit vertices. Source: spec/objects.md, section 6;
//! Woop, Benthin, Wald 2013.

use super::{HitSink, LocalRay, Part};
use crate::accel::{Accel, LeafVisitor, PACK, can_meet};
use crate::compile::shape::MeshShape;
use crate::compile::shape::mesh::Corners;
use crate::compile::shape::triangle_pack::TrianglePack;
use crate::math::simd::{self, Kernel, Simd};
use crate::math::{DVec2, DVec3, MAX_DISTANCE, Ray, Vec3};
use std::cell::RefCell;

/// Meshes of so many packs are tested face by face, without their tree.
const FEW_PACKS: usize = 2;
/// Hits nearer than this are not seen.
pub(crate) const TOLERANCE: f64 = 1e-6;

/// A ray made ready for triangle tests: sheared so that it runs along its longest axis, which comes last.
pub struct ShearedRay {
    /// Axes in their new order.
    pub(super) origin: [f64; 3],
    /// What is taken off x and y per z; 1 / direction along z.
    pub(super) shear: [f64; 3],
    /// The axes in their new order.
    pub(super) axes: [usize; 3],
}

/// The axes in order, by the one that comes last.
pub(super) const ORDERS: [[usize; 3]; 3] = [[1, 2, 0], [2, 0, 1], [0, 1, 2]];

/// The axes, the one that a direction is longest along last. No branches: neighbouring rays go their own ways.
#[inline(always)]
fn axes_along(dir: DVec3) -> [usize; 3] {
    let a = dir.abs();
    let (x, y) = ((a.x > a.y) & (a.x > a.z), a.y > a.z);
    ORDERS[if x { 0 } else { 2 - usize::from(y) }]
}

impl ShearedRay {
    /// For `ray`.
    #[inline]
    pub fn new(ray: &LocalRay) -> Self {
        let axes = axes_along(ray.dir);
        let (o, d) = (ray.origin.to_array(), ray.dir.to_array());
        let inv = 1.0 / d[axes[2]];
        Self { origin: axes.map(|k| o[k]), shear: [d[axes[0]] * inv, d[axes[1]] * inv, inv], axes }
    }

    /// Depth and the weights of corners 2 and 3; edges belong to both neighbours, so no ray slips between.
    ///
    /// Each corner is moved and sheared by itself, so faces that share it see the same point, and the sign of an edge is that of the
    /// exact numbers or 0. Edge on, weights and depth lose digits: the depth is then somewhere within the face's.
    #[inline]
    pub fn hit(&self, corners: &[Vec3; 3]) -> Option<(f64, f64, f64)> {
        let q = corners.map(|v| {
            let v = self.axes.map(|k| v[k]);
            let z = f64::from(v[2]) - self.origin[2];
            [f64::from(v[0]) - self.origin[0] - self.shear[0] * z, f64::from(v[1]) - self.origin[1] - self.shear[1] * z, z]
        });
        let w1 = q[2][0] * q[1][1] - q[2][1] * q[1][0];
        let w2 = q[0][0] * q[2][1] - q[0][1] * q[2][0];
        let w3 = q[1][0] * q[0][1] - q[1][1] * q[0][0];
        if (w1 < 0.0 || w2 < 0.0 || w3 < 0.0) && (w1 > 0.0 || w2 > 0.0 || w3 > 0.0) {
            return None;
        }
        let det = w1 + w2 + w3;
        if det == 0.0 {
            return None;
        }
        let t = self.shear[2] * (w1 * q[0][2] + w2 * q[1][2] + w3 * q[2][2]) / det;
        Some((t, w2 / det, w3 / det))
    }
}

/// What a pack of triangles has in common with a ray: the edge functions and depths of all of them.
struct PackTest<S: Simd> {
    /// Edge functions, `[corner][triangle]`.
    w: [S::F64x4; 3],
    /// Depths of the corners, not yet scaled.
    z: [S::F64x4; 3],
    /// A bit for each triangle that the ray may meet.
    met: u32,
}

/// Hits of a pack.
pub(crate) struct PackHits {
    /// Depths.
    pub t: [f64; PACK],
    /// Edge functions across from corners 2 and 3, and the sum of all three.
    w2: [f64; PACK],
    w3: [f64; PACK],
    det: [f64; PACK],
    /// A bit for each triangle that is met nearer than what was asked for, and not behind.
    pub met: u32,
}

impl PackHits {
    const NONE: Self = Self { t: [0.0; PACK], w2: [0.0; PACK], w3: [0.0; PACK], det: [0.0; PACK], met: 0 };

    /// Weights of corners 2 and 3 where triangle `k` is met: worked out for what is taken alone.
    #[inline(always)]
    pub fn weights(&self, k: usize) -> (f64, f64) {
        (self.w2[k] / self.det[k], self.w3[k] / self.det[k])
    }
}

impl<S: Simd> PackTest<S> {
    /// The numbers of [`ShearedRay::hit`], to the last bit, for all triangles. What has no area gives NaN, which is not met.
    #[inline(always)]
    fn hits(&self, s: S, ray: &ShearedRay, far: f64) -> PackHits {
        let ([w1, w2, w3], [z1, z2, z3]) = (self.w, self.z);
        let det = s.add(s.add(w1, w2), w3);
        let sum = s.add(s.add(s.mul(w1, z1), s.mul(w2, z2)), s.mul(w3, z3));
        let t = s.div(s.mul(s.splat(ray.shear[2]), sum), det);
        let in_reach = !s.lt(s.splat(far), t) & s.lt(s.splat(TOLERANCE), t);
        PackHits { t: s.array(t), w2: s.array(w2), w3: s.array(w3), det: s.array(det), met: self.met & in_reach }
    }
}

impl ShearedRay {
    /// As [`ShearedRay::hit`], four triangles side by side.
    #[inline(always)]
    fn test_pack<S: Simd>(&self, s: S, pack: &TrianglePack) -> PackTest<S> {
        // No loops, no closures: what stays one is compiled apart, without the wide instructions.
        let (a, b, c) = (self.corners(s, &pack.0[0]), self.corners(s, &pack.0[1]), self.corners(s, &pack.0[2]));
        let (w1, w2, w3) = (edge(s, c, b), edge(s, a, c), edge(s, b, a));
        let (least, most) = (s.min(w1, s.min(w2, w3)), s.max(w1, s.max(w2, w3)));
        let zero = s.splat(0.0);
        let mixed = s.lt(least, zero) & s.lt(zero, most);
        PackTest { w: [w1, w2, w3], z: [a[2], b[2], c[2]], met: !mixed & ((1 << PACK) - 1) }
    }

    /// Hits before `far` with the first `count` triangles of a pack.
    #[inline(always)]
    pub(crate) fn pack_hits<S: Simd>(&self, s: S, pack: &TrianglePack, count: u32, far: f64) -> PackHits {
        let test = self.test_pack(s, pack);
        let wanted = (1 << count) - 1;
        if test.met & wanted == 0 {
            return PackHits::NONE;
        }
        let hits = test.hits(s, self, far);
        PackHits { met: hits.met & wanted, ..hits }
    }

    /// The same corner of four triangles, moved and sheared.
    #[inline(always)]
    fn corners<S: Simd>(&self, s: S, of: &[[f32; PACK]; 3]) -> [S::F64x4; 3] {
        let axes = self.axes;
        let x = s.sub(s.widen(&of[axes[0]]), s.splat(self.origin[0]));
        let y = s.sub(s.widen(&of[axes[1]]), s.splat(self.origin[1]));
        let z = s.sub(s.widen(&of[axes[2]]), s.splat(self.origin[2]));
        [s.sub(x, s.mul(s.splat(self.shear[0]), z)), s.sub(y, s.mul(s.splat(self.shear[1]), z)), z]
    }
}

/// Edge function of two corners.
#[inline(always)]
fn edge<S: Simd>(s: S, a: [S::F64x4; 3], b: [S::F64x4; 3]) -> S::F64x4 {
    s.sub(s.mul(a[0], b[1]), s.mul(a[1], b[0]))
}

/// What a ray found of a mesh so far, on its way to a sink.
struct Crossings<'a, S> {
    packs: &'a [TrianglePack],
    /// Slot by slot.
    faces: &'a [u32],
    ray: &'a ShearedRay,
    sink: &'a mut S,
    /// Depth and face of the last.
    last: (f64, u32),
}

/// Takes up a hit at `t`; gives the depth that still matters if it is a nearer one. `last` is what was taken up last.
#[inline(always)]
pub(super) fn offer(
    sink: &mut impl HitSink,
    last: &mut (f64, u32),
    t: f64,
    weights: impl FnOnce() -> (f64, f64),
    face: u32,
    far: f64,
) -> Option<f64> {
    if !(t > TOLERANCE && t <= far && t < MAX_DISTANCE) {
        return None;
    }
    // On an edge the face that comes first in the mesh wins, whatever the order of the tree.
    if t == last.0 && face >= last.1 {
        return None;
    }
    *last = (t, face);
    let (a, b) = weights();
    sink.push(t, Part { face, a, b });
    let now = sink.far();
    (now < far).then_some(now)
}

impl<S: HitSink> Crossings<'_, S> {
    #[inline(always)]
    fn offer(&mut self, (t, a, b): (f64, f64, f64), face: u32, far: f64) -> Option<f64> {
        offer(self.sink, &mut self.last, t, || (a, b), face, far)
    }
}

/// Offers the hits of a ray with the first `count` triangles of a pack, whose faces are `faces`, to a sink; gives the depth that still matters.
#[inline(always)]
pub(super) fn offer_pack<Lanes: Simd>(
    simd: Lanes,
    ray: &ShearedRay,
    pack: &TrianglePack,
    faces: &[u32],
    sink: &mut impl HitSink,
    last: &mut (f64, u32),
    mut far: f64,
) -> f64 {
    let hits = ray.pack_hits(simd, pack, faces.len() as u32, far);
    let mut met = hits.met;
    while met != 0 {
        let k = met.trailing_zeros() as usize % PACK;
        met &= met - 1;
        far = offer(sink, last, hits.t[k], || hits.weights(k), faces[k], far).unwrap_or(far);
    }
    far
}

impl<S: HitSink> LeafVisitor for Crossings<'_, S> {
    #[inline(always)]
    fn leaf<Lanes: Simd>(&mut self, simd: Lanes, first: u32, count: u32, far: f64) -> Option<f64> {
        let faces = &self.faces[first as usize..(first + count) as usize];
        Some(offer_pack(simd, self.ray, &self.packs[first as usize / PACK], faces, self.sink, &mut self.last, far))
    }
}

/// Every face of a small mesh.
struct AllPacks<'a, S> {
    found: Crossings<'a, S>,
    far: f64,
}

impl<S: HitSink> Kernel for AllPacks<'_, S> {
    type Output = ();

    #[inline(always)]
    fn run<Lanes: Simd>(mut self, simd: Lanes) {
        for k in 0..self.found.packs.len() {
            // Slots without a face are met by no ray.
            match self.found.leaf(simd, (k * PACK) as u32, PACK as u32, self.far) {
                Some(far) => self.far = far,
                None => return,
            }
        }
    }
}

/// All crossings of a mesh up to the depth that the sink still wants; one may come twice.
#[inline]
pub fn intersect_mesh(s: &MeshShape, ray: &LocalRay, sink: &mut impl HitSink) {
    let sheared = ShearedRay::new(ray);
    let (walked, far) = (Ray::new(ray.origin, ray.dir), sink.far().min(MAX_DISTANCE));
    let index = s.index();
    let mut found = Crossings { packs: &[], faces: &[], ray: &sheared, sink, last: (f64::INFINITY, u32::MAX) };
    if let Some(moving) = &s.moving
        && found.sink.time() >= 0.0
    {
        let (tree, moment) = moving.at(found.sink.time());
        let hit = |face: u32| sheared.hit(&s.mesh.faces[face as usize].map(|v| moment.vertex(&s.mesh, v)));
        return tree.closest(&walked, 0.0, far, |face, far| found.offer(hit(face)?, face, far));
    }
    match (&index.tree, &index.corners) {
        (Accel::Bvh8(tree), Corners::Packs(packs)) => {
            let found = Crossings { packs, faces: &tree.slots, ..found };
            // A few faces are tested sooner than their boxes.
            if packs.len() <= FEW_PACKS {
                if can_meet(&walked, 0.0, far) {
                    simd::run(AllPacks { found, far });
                }
            } else {
                tree.visit_leaves(&walked, 0.0, far, &mut { found });
            }
        }
        (tree, _) => tree.closest_slots(&walked, 0.0, far, |slot, far| {
            let hit = sheared.hit(&index.slot_corners(slot))?;
            found.offer(hit, index.tree.prim_at(slot), far)
        }),
    }
}

thread_local! {
    /// Slots of faces crossed by the ray of an inside test: trees may offer one more than once.
    static CROSSED: RefCell<Vec<u32>> = const { RefCell::new(Vec::new()) };
}

/// Parity of the hits along the inside vector; never without one.
pub fn inside_mesh(s: &MeshShape, p: DVec3) -> bool {
    let Some(dir) = s.mesh.inside_vector.and_then(DVec3::try_normalize) else { return false };
    if p.cmplt(s.bounds.min).any() || p.cmpgt(s.bounds.max).any() {
        return false;
    }
    let ray = LocalRay { origin: p, dir, scale: 1.0 };
    let sheared = ShearedRay::new(&ray);
    CROSSED.with_borrow_mut(|crossed| {
        crossed.clear();
        let index = s.index();
        index.tree.closest_slots(&Ray::new(p, dir), 0.0, MAX_DISTANCE, |slot, _| {
            if sheared.hit(&index.slot_corners(slot)).is_some_and(|(t, ..)| t > TOLERANCE) && !crossed.contains(&slot) {
                crossed.push(slot);
            }
            None
        });
        crossed.len() % 2 == 1
    })
}

/// Interpolated where the face has normals, else the face's; at `time`, below 0 at rest.
pub fn mesh_normal(s: &MeshShape, part: &Part, time: f64) -> DVec3 {
    let normals = s.mesh.normal_indices.get(part.face as usize).filter(|n| n[0] != u32::MAX);
    if let Some(ix) = normals {
        let n = ix.map(|k| s.normal_at(k, time));
        let blend = (1.0 - part.a - part.b) * n[0] + part.a * n[1] + part.b * n[2];
        if blend != DVec3::ZERO {
            return blend;
        }
    }
    flat_normal(s, part.face, time)
}

/// (P3-P1) x (P2-P1) at `time`, below 0 at rest.
pub fn flat_normal(s: &MeshShape, face: u32, time: f64) -> DVec3 {
    let [p1, p2, p3] = s.corners_at(face, time);
    (p3 - p1).cross(p2 - p1)
}

/// Interpolated coordinates; 0 without any.
pub fn mesh_uv(s: &MeshShape, part: &Part) -> DVec2 {
    let Some(ix) = s.mesh.uv_indices.get(part.face as usize) else { return DVec2::ZERO };
    let c = ix.map(|k| s.mesh.uvs.get(k as usize).map_or(DVec2::ZERO, |c| DVec2::new(c[0].into(), c[1].into())));
    (1.0 - part.a - part.b) * c[0] + part.a * c[1] + part.b * c[2]
}
