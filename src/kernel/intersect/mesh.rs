//! Triangles of meshes: watertight tests in double precision on 32-bit vertices. Source: spec/objects.md, section 6;
//! Woop, Benthin, Wald 2013.

use super::{HitSink, LocalRay, Part};
use crate::compile::shape::MeshShape;
use crate::math::{DVec2, DVec3, MAX_DISTANCE, Ray};
use std::cell::RefCell;

/// Hits nearer than this are not seen.
const TOLERANCE: f64 = 1e-6;

/// A ray made ready for triangle tests: turned so that it runs along +z.
pub struct ShearedRay {
    origin: DVec3,
    axes: [usize; 3],
    shear: DVec3,
}

impl ShearedRay {
    /// For `ray`.
    #[inline]
    pub fn new(ray: &LocalRay) -> Self {
        let a = ray.dir.abs();
        let kz = if a.x > a.y && a.x > a.z {
            0
        } else if a.y > a.z {
            1
        } else {
            2
        };
        let (mut kx, mut ky) = ((kz + 1) % 3, (kz + 2) % 3);
        if ray.dir[kz] < 0.0 {
            std::mem::swap(&mut kx, &mut ky);
        }
        let inv = 1.0 / ray.dir[kz];
        Self { origin: ray.origin, axes: [kx, ky, kz], shear: DVec3::new(ray.dir[kx] * inv, ray.dir[ky] * inv, inv) }
    }

    /// Depth and the weights of corners 2 and 3; edges belong to both neighbours, so no ray slips between.
    #[inline]
    pub fn hit(&self, corners: &[DVec3; 3]) -> Option<(f64, f64, f64)> {
        let [kx, ky, kz] = self.axes;
        let q = corners.map(|v| {
            let v = v - self.origin;
            DVec3::new(v[kx] - self.shear.x * v[kz], v[ky] - self.shear.y * v[kz], v[kz])
        });
        let w1 = q[2].x * q[1].y - q[2].y * q[1].x;
        let w2 = q[0].x * q[2].y - q[0].y * q[2].x;
        let w3 = q[1].x * q[0].y - q[1].y * q[0].x;
        if (w1 < 0.0 || w2 < 0.0 || w3 < 0.0) && (w1 > 0.0 || w2 > 0.0 || w3 > 0.0) {
            return None;
        }
        let det = w1 + w2 + w3;
        if det == 0.0 {
            return None;
        }
        let t = self.shear.z * (w1 * q[0].z + w2 * q[1].z + w3 * q[2].z) / det;
        Some((t, w2 / det, w3 / det))
    }
}

/// All crossings of a mesh up to the depth that the sink still wants; one may come twice.
pub fn intersect_mesh(s: &MeshShape, ray: &LocalRay, sink: &mut impl HitSink) {
    let sheared = ShearedRay::new(ray);
    s.tree.closest(&Ray::new(ray.origin, ray.dir), 0.0, sink.far().min(MAX_DISTANCE), |face, far| {
        let (t, a, b) = sheared.hit(&s.corners(face))?;
        if !(t > TOLERANCE && t <= far && t < MAX_DISTANCE) {
            return None;
        }
        sink.push(t, Part { face, a, b });
        let now = sink.far();
        (now < far).then_some(now)
    });
}

thread_local! {
    /// Faces crossed by the ray of an inside test: trees may offer a face more than once.
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
        s.tree.closest(&Ray::new(p, dir), 0.0, MAX_DISTANCE, |face, _| {
            if sheared.hit(&s.corners(face)).is_some_and(|(t, ..)| t > TOLERANCE) && !crossed.contains(&face) {
                crossed.push(face);
            }
            None
        });
        crossed.len() % 2 == 1
    })
}

/// Interpolated where the face has normals, else the face's.
pub fn mesh_normal(s: &MeshShape, part: &Part) -> DVec3 {
    let normals = s.mesh.normal_indices.get(part.face as usize).filter(|n| n[0] != u32::MAX);
    if let Some(ix) = normals {
        let n = ix.map(|k| s.mesh.normals.get(k as usize).map_or(DVec3::ZERO, |n| n.as_dvec3()));
        let blend = (1.0 - part.a - part.b) * n[0] + part.a * n[1] + part.b * n[2];
        if blend != DVec3::ZERO {
            return blend;
        }
    }
    flat_normal(s, part.face)
}

/// (P3-P1) x (P2-P1).
pub fn flat_normal(s: &MeshShape, face: u32) -> DVec3 {
    let [p1, p2, p3] = s.corners(face);
    (p3 - p1).cross(p2 - p1)
}

/// Interpolated coordinates; 0 without any.
pub fn mesh_uv(s: &MeshShape, part: &Part) -> DVec2 {
    let Some(ix) = s.mesh.uv_indices.get(part.face as usize) else { return DVec2::ZERO };
    let c = ix.map(|k| s.mesh.uvs.get(k as usize).map_or(DVec2::ZERO, |c| DVec2::new(c[0].into(), c[1].into())));
    (1.0 - part.a - part.b) * c[0] + part.a * c[1] + part.b * c[2]
}
