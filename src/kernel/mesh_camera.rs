//! The mesh camera: rays start on the faces of meshes, one pixel a face. Source: spec/textures.md, section 8, last row of its table.

use crate::math::{DVec2, DVec3, Ray, Transform};
use crate::scene::{Mesh, Object, Shape};
use std::sync::Arc;

/// The meshes of a mesh camera and how pixels choose their faces.
pub struct MeshCamera {
    n_rays: u32,
    distribution: u8,
    max_distance: f64,
    smooth: bool,
    /// Shift along the normal.
    offset: f64,
    /// Rays run against the normal.
    reversed: bool,
    meshes: Vec<(Arc<Mesh>, Transform)>,
}

impl MeshCamera {
    /// From the scene's numbers; `location.z` is the distance of origins from their faces,
    /// a negative `direction.z` turns rays round. Objects that are no meshes are ignored.
    pub fn new(
        n_rays: u32,
        distribution: u8,
        max_distance: f64,
        meshes: &[Object],
        smooth: bool,
        location: DVec3,
        direction: DVec3,
    ) -> Self {
        let mut found = Vec::new();
        for o in meshes {
            let (mut object, mut to_world) = (o, o.transform);
            while let Shape::Group { child } = &object.shape {
                object = child;
                to_world = object.transform.then(&to_world);
            }
            if let Shape::Mesh(m) = &object.shape {
                found.push((m.clone(), to_world));
            }
        }
        Self {
            n_rays: n_rays.clamp(1, 1 << 16),
            distribution,
            max_distance,
            smooth,
            offset: location.z,
            reversed: direction.z < -crate::math::EPSILON,
            meshes: found,
        }
    }

    /// Rays of a pixel.
    pub fn n_rays(&self) -> u32 {
        self.n_rays
    }

    /// Depth beyond which rays see nothing.
    pub fn max_depth(&self) -> f64 {
        if self.max_distance >= crate::math::EPSILON { self.max_distance } else { f64::INFINITY }
    }

    /// Ray `m` of the pixel at (x, y) of a picture of the given size; `None` where there is no face for it.
    pub fn ray(&self, m: u32, x: f64, y: f64, resolution: DVec2) -> Option<Ray> {
        // The program's rows run one behind: the first two rows are the same.
        let (column, row) = ((x + 0.5).min(resolution.x - 1.0).max(0.0), (y - 0.5).max(0.0));
        let width = resolution.x as usize;
        let k = row as usize * width + column as usize;
        match self.distribution {
            0 => self.face_ray(m as usize, k),
            1 => {
                let total: usize = self.meshes.iter().map(|(mesh, _)| mesh.faces.len()).sum();
                let mut k = k + m as usize * total;
                for (i, (mesh, _)) in self.meshes.iter().enumerate() {
                    if k < mesh.faces.len() {
                        return self.face_ray(i, k);
                    }
                    k -= mesh.faces.len();
                }
                None
            }
            2 => {
                let part = resolution.x / self.meshes.len().max(1) as f64;
                self.face_ray((column / part) as usize, row as usize * part as usize + column as usize)
            }
            _ => self.uv_ray(DVec2::new((column - 0.5) / resolution.x, 1.0 - (row + 0.5) / resolution.y)),
        }
    }

    fn face_ray(&self, mesh_ix: usize, face: usize) -> Option<Ray> {
        let (mesh, t) = self.meshes.get(mesh_ix)?;
        let [a, b, c] = mesh.faces.get(face)?.map(|v| mesh.vertices[v as usize].as_dvec3());
        self.start((a + b + c) / 3.0, (c - a).cross(b - a).try_normalize()?, t)
    }

    fn uv_ray(&self, at: DVec2) -> Option<Ray> {
        let (mesh, t) = self.meshes.first()?;
        for (k, face) in mesh.faces.iter().enumerate() {
            let uvs = mesh.uv_indices.get(k)?.map(|i| mesh.uvs.get(i as usize).copied().unwrap_or_default());
            let [p, q, r] = uvs.map(|uv| DVec2::new(f64::from(uv[0]), f64::from(uv[1])));
            let (e, f, d) = (q - p, r - p, at - p);
            let area = e.perp_dot(f);
            let (wb, wc) = (d.perp_dot(f) / area, e.perp_dot(d) / area);
            let wa = 1.0 - wb - wc;
            if !(wa >= 0.0 && wb >= 0.0 && wc >= 0.0) {
                continue;
            }
            let [a, b, c] = face.map(|v| mesh.vertices[v as usize].as_dvec3());
            let mut n = (c - a).cross(b - a).try_normalize()?;
            if let (true, Some(ix)) = (self.smooth, mesh.normal_indices.get(k)) {
                let [na, nb, nc] = ix.map(|i| mesh.normals.get(i as usize).copied().unwrap_or_default().as_dvec3());
                n = (wa * na + wb * nb + wc * nc).try_normalize().unwrap_or(n);
            }
            return self.start(wa * a + wb * b + wc * c, n, t);
        }
        None
    }

    fn start(&self, point: DVec3, normal: DVec3, t: &Transform) -> Option<Ray> {
        let origin = point + self.offset * normal;
        let dir = if self.reversed { -normal } else { normal };
        let (origin, dir) = (t.point(origin), t.vector(dir));
        Some(Ray::new(origin, dir.try_normalize()?))
    }
}
