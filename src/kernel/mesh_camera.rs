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
    /// Faces of the first mesh by their place in (u, v), for distribution 3.
    raster: UvRaster,
}

/// Slack of barycentric weights at the edges of faces.
const EDGE_SLACK: f64 = 1e-6;

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
        let raster = match found.first() {
            Some((mesh, _)) if distribution > 2 => UvRaster::new(mesh),
            _ => UvRaster::default(),
        };
        Self {
            n_rays: n_rays.clamp(1, 1 << 16),
            distribution,
            max_distance,
            smooth,
            offset: location.z,
            reversed: direction.z < -crate::math::EPSILON,
            meshes: found,
            raster,
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
        for k in self.raster.faces_at(at) {
            let k = *k as usize;
            let face = mesh.faces[k];
            let [p, q, r] = uv_corners(mesh, k)?;
            let (e, f, d) = (q - p, r - p, at - p);
            let area = e.perp_dot(f);
            let (wb, wc) = (d.perp_dot(f) / area, e.perp_dot(d) / area);
            let wa = 1.0 - wb - wc;
            // Coordinates are single precision: without slack, points on shared edges would fall between both faces.
            if !(wa >= -EDGE_SLACK && wb >= -EDGE_SLACK && wc >= -EDGE_SLACK) {
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

/// Corners of a face in (u, v); `None` for a face without.
fn uv_corners(mesh: &Mesh, face: usize) -> Option<[DVec2; 3]> {
    let uvs = mesh.uv_indices.get(face)?.map(|i| mesh.uvs.get(i as usize).copied().unwrap_or_default());
    Some(uvs.map(|uv| DVec2::new(f64::from(uv[0]), f64::from(uv[1]))))
}

/// A raster over (u, v): in each cell the faces that touch it, in the order of the mesh. A picture asks once a pixel, and meshes have
/// as many faces as pictures have pixels.
#[derive(Default)]
struct UvRaster {
    low: DVec2,
    cells_per_unit: DVec2,
    n: usize,
    /// `cells[k]..cells[k + 1]` of `faces` is cell k, row by row.
    cells: Vec<u32>,
    faces: Vec<u32>,
}

/// Most cells along an axis.
const MAX_RASTER: usize = 1024;

impl UvRaster {
    fn new(mesh: &Mesh) -> Self {
        let boxes: Vec<(DVec2, DVec2)> =
            (0..mesh.faces.len()).map_while(|k| uv_corners(mesh, k)).map(|[p, q, r]| (p.min(q).min(r), p.max(q).max(r))).collect();
        let (low, high) = boxes.iter().fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(a, b), (p, q)| (a.min(*p), b.max(*q)));
        if !(low.is_finite() && high.is_finite()) {
            return Self::default();
        }
        let mut n = ((boxes.len() as f64).sqrt() as usize).clamp(1, MAX_RASTER);
        let with = |n: usize| Self { low, cells_per_unit: n as f64 / (high - low).max(DVec2::splat(1e-30)), n, ..Self::default() };
        // Faces that lie over each other want larger cells.
        while n > 1 && boxes.iter().map(|b| with(n).n_touched(b)).sum::<usize>() > 16 * boxes.len() {
            n /= 2;
        }
        let mut raster = Self { cells: vec![0; n * n + 1], ..with(n) };
        // Count, sum up, fill: each cell keeps the mesh's order.
        for b in &boxes {
            raster.touched(b).for_each(|c| raster.cells[c + 1] += 1);
        }
        for c in 0..n * n {
            raster.cells[c + 1] += raster.cells[c];
        }
        let mut next = raster.cells.clone();
        raster.faces = vec![0; next[n * n] as usize];
        for (k, b) in boxes.iter().enumerate() {
            for c in raster.touched(b) {
                raster.faces[next[c] as usize] = k as u32;
                next[c] += 1;
            }
        }
        raster
    }

    /// Cell of a place along one axis; the outermost cells take what lies outside.
    fn cell(&self, at: DVec2, slack: f64) -> [usize; 2] {
        let c = ((at - self.low) * self.cells_per_unit + DVec2::splat(slack)).floor();
        [c.x, c.y].map(|v| (v.max(0.0) as usize).min(self.n - 1))
    }

    /// First and last column and row that a box touches; a face's own test may round outwards.
    fn corners(&self, (low, high): &(DVec2, DVec2)) -> [[usize; 2]; 2] {
        [self.cell(*low, -1e-6), self.cell(*high, 1e-6)]
    }

    fn n_touched(&self, b: &(DVec2, DVec2)) -> usize {
        let [a, b] = self.corners(b);
        (b[0] - a[0] + 1) * (b[1] - a[1] + 1)
    }

    fn touched(&self, b: &(DVec2, DVec2)) -> impl Iterator<Item = usize> + use<> {
        let ([a, b], n) = (self.corners(b), self.n);
        (a[1]..=b[1]).flat_map(move |y| (a[0]..=b[0]).map(move |x| y * n + x))
    }

    fn faces_at(&self, at: DVec2) -> &[u32] {
        if self.n == 0 || !at.is_finite() {
            return &[];
        }
        let [x, y] = self.cell(at, 0.0);
        let c = y * self.n + x;
        &self.faces[self.cells[c] as usize..self.cells[c + 1] as usize]
    }
}
