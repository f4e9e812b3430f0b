//! Meshes ready to be hit, and bicubic patches cut into triangles. Source: spec/objects.md, section 6.

use super::moving_mesh::{Moment, MovingMesh};
use super::triangle_pack::TrianglePack;
use crate::accel::{Accel, AccelKind, AccelOptions, NO_PRIM, PACK, TrianglePrims};
use crate::math::{Bounds, DVec2, DVec3, Transform, Vec3};
use crate::scene::Mesh;
use std::sync::{Arc, OnceLock};

/// Most faces over which every kind of tree is built by one thread.
const SERIAL_BUILD: usize = 4096;

/// A mesh; instances share it.
#[derive(Clone, Debug)]
pub struct MeshShape {
    /// Vertices, faces, normals and coordinates.
    pub mesh: Arc<Mesh>,
    /// `mesh.textures` as indices of `TextureTables::textures`.
    pub textures: Vec<u32>,
    /// Box in mesh space, of the mesh at rest.
    pub bounds: Bounds,
    /// Kind of tree.
    pub(super) accel: AccelKind,
    pub(super) index: Arc<OnceLock<MeshIndex>>,
    /// How the vertices move while the shutter is open; `None`: they stand still.
    pub moving: Option<MovingMesh>,
}

/// The faces of a mesh in the order of their tree.
#[derive(Debug)]
pub struct MeshIndex {
    /// Over the faces.
    pub tree: Accel,
    /// Corners of the faces slot by slot.
    pub corners: Corners,
}

/// Corners of the face in each slot of a mesh's tree: one place in memory a test in place of four, and neighbours side by side.
#[derive(Clone, Debug)]
pub enum Corners {
    /// One by one.
    Slots(Vec<[Vec3; 3]>),
    /// In the packs of a wide tree.
    Packs(Vec<TrianglePack>),
}

impl Corners {
    fn new(tree: &Accel, mesh: &Mesh) -> Self {
        let slots = tree.slots();
        // The corners of no face are one point.
        let corners = |face: &u32| match *face {
            NO_PRIM => [Vec3::ZERO; 3],
            face => mesh.faces[face as usize].map(|v| mesh.vertices[v as usize]),
        };
        match tree {
            Accel::Bvh8(_) => Self::Packs(slots.chunks(PACK).map(|pack| TrianglePack::new(pack.iter().map(corners))).collect()),
            _ => Self::Slots(slots.iter().map(corners).collect()),
        }
    }
}

impl MeshIndex {
    /// Bytes of the tree and of the corners.
    pub fn n_bytes(&self) -> usize {
        let corners = match &self.corners {
            Corners::Slots(list) => size_of_val(&list[..]),
            Corners::Packs(list) => size_of_val(&list[..]),
        };
        self.tree.stats().n_bytes + corners
    }

    /// Corners of the face in a slot of the tree.
    #[inline]
    pub fn slot_corners(&self, slot: u32) -> [Vec3; 3] {
        match &self.corners {
            Corners::Slots(list) => list[slot as usize],
            Corners::Packs(list) => list[slot as usize / PACK].corners(slot as usize % PACK),
        }
    }
}

impl MeshShape {
    /// Takes the mesh; `None` without faces or with a face outside the vertices.
    pub fn new(mesh: Arc<Mesh>, textures: Vec<u32>, accel: AccelKind) -> Option<Self> {
        if mesh.faces.is_empty() || !mesh.faces.iter().flatten().all(|v| (*v as usize) < mesh.vertices.len()) {
            return None;
        }
        let used = mesh.faces.iter().flatten().map(|v| mesh.vertices[*v as usize].as_dvec3());
        let bounds = Bounds::from_points(used);
        let moving = MovingMesh::new(&mesh, accel);
        Some(Self { mesh, textures, bounds, accel, index: Arc::default(), moving })
    }

    /// The tree, built when it is first asked for.
    #[inline]
    pub fn index(&self) -> &MeshIndex {
        self.index.get_or_init(|| self.build())
    }

    /// Builds with as many threads as the caller's pool has, but never with the pool's own: a thread that waits for others takes up their
    /// work, here rays, and those may want this very tree.
    #[cold]
    fn build(&self) -> MeshIndex {
        let n_threads = rayon::current_num_threads();
        if rayon::current_thread_index().is_none() || self.mesh.faces.len() <= SERIAL_BUILD {
            return self.build_here();
        }
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n_threads).build();
        let built = pool.ok().and_then(|pool| std::thread::scope(|s| s.spawn(|| pool.install(|| self.build_here())).join().ok()));
        built.unwrap_or_else(|| self.build_here())
    }

    fn build_here(&self) -> MeshIndex {
        let mesh = &self.mesh;
        let tree = Accel::build(
            self.accel,
            &TrianglePrims { vertices: &mesh.vertices, faces: &mesh.faces },
            &AccelOptions { pack: PACK, ..AccelOptions::default() },
        );
        let corners = Corners::new(&tree, mesh);
        MeshIndex { tree, corners }
    }

    /// The tree, to be changed; `None` where several hold it.
    pub fn tree_mut(&mut self) -> Option<&mut Accel> {
        self.index();
        Arc::get_mut(&mut self.index)?.get_mut().map(|i| &mut i.tree)
    }

    /// Whether the tree stands already.
    pub fn is_built(&self) -> bool {
        self.index.get().is_some()
    }

    /// Whether a face has normals of its corners.
    #[inline]
    pub fn is_smooth(&self, face: u32) -> bool {
        self.mesh.normal_indices.get(face as usize).is_some_and(|n| n[0] != u32::MAX)
    }

    /// Corners of a face at rest.
    pub fn corners(&self, face: u32) -> [DVec3; 3] {
        self.mesh.faces[face as usize].map(|v| self.mesh.vertices[v as usize].as_dvec3())
    }

    /// Corners of a face at `time`; below 0 at rest.
    pub fn corners_at(&self, face: u32, time: f64) -> [DVec3; 3] {
        match self.moment(time) {
            Some(m) => self.mesh.faces[face as usize].map(|v| m.vertex(&self.mesh, v).as_dvec3()),
            None => self.corners(face),
        }
    }

    /// Normal `ix` at `time`; below 0 at rest.
    pub fn normal_at(&self, ix: u32, time: f64) -> DVec3 {
        let moved = self.moment(time).and_then(|m| m.normal(&self.mesh, ix));
        moved.unwrap_or_else(|| self.mesh.normals.get(ix as usize).map_or(DVec3::ZERO, |n| n.as_dvec3()))
    }

    fn moment(&self, time: f64) -> Option<Moment> {
        (self.moving.is_some() && time >= 0.0).then(|| Moment::of(&self.mesh, time))
    }

    /// World box of the vertices, wherever they are while the shutter is open.
    pub fn world_bounds(&self, t: &Transform) -> Bounds {
        if let Some(moving) = &self.moving {
            return self.bounds.union(moving.bounds).transformed(t);
        }
        if self.mesh.vertices.len() > 10_000 {
            return self.bounds.transformed(t);
        }
        Bounds::from_points(self.mesh.faces.iter().flatten().map(|v| t.point(self.mesh.vertices[*v as usize].as_dvec3())))
    }
}

/// Most triangles of one patch.
const MAX_PATCH_FACES: usize = 1 << 20;

/// A bicubic patch as a smooth mesh: halved until flat enough or deep enough, two triangles a leaf.
pub fn patch_mesh(points: &[[DVec3; 4]; 4], uvs: &[DVec2; 4], flatness: f64, u_steps: u32, v_steps: u32) -> Mesh {
    let mut cutter = PatchCutter { points, uvs, flatness, u_steps, v_steps, mesh: Mesh::default() };
    cutter.cut(points, [0.0, 1.0], [0.0, 1.0], 0);
    cutter.mesh
}

struct PatchCutter<'a> {
    points: &'a [[DVec3; 4]; 4],
    uvs: &'a [DVec2; 4],
    flatness: f64,
    u_steps: u32,
    v_steps: u32,
    mesh: Mesh,
}

type Net = [[DVec3; 4]; 4];

impl PatchCutter<'_> {
    fn cut(&mut self, net: &Net, u: [f64; 2], v: [f64; 2], depth: u32) {
        let full = self.mesh.faces.len() + 2 > MAX_PATCH_FACES;
        if full || is_flat(net, self.flatness) || (depth >= self.u_steps && depth >= self.v_steps) {
            return self.leaf(net, u, v);
        }
        let (um, vm) = (0.5 * (u[0] + u[1]), 0.5 * (v[0] + v[1]));
        let halves_u = if depth < self.u_steps { Some(split_rows(net)) } else { None };
        let parts: Vec<(Net, [f64; 2])> = match halves_u {
            Some((a, b)) => vec![(a, [u[0], um]), (b, [um, u[1]])],
            None => vec![(*net, u)],
        };
        for (part, u) in parts {
            if depth < self.v_steps {
                let (a, b) = split_columns(&part);
                self.cut(&a, u, [v[0], vm], depth + 1);
                self.cut(&b, u, [vm, v[1]], depth + 1);
            } else {
                self.cut(&part, u, v, depth + 1);
            }
        }
    }

    fn leaf(&mut self, net: &Net, u: [f64; 2], v: [f64; 2]) {
        // Corners (u0,v0) (u0,v1) (u1,v1) (u1,v0): rows run with u, columns with v.
        let corners = [(net[0][0], u[0], v[0]), (net[0][3], u[0], v[1]), (net[3][3], u[1], v[1]), (net[3][0], u[1], v[0])];
        let base = self.mesh.vertices.len() as u32;
        for (p, u, v) in corners {
            self.mesh.vertices.push(p.as_vec3());
            self.mesh.normals.push(self.normal(u, v).as_vec3());
            // `a` runs along v, `b` along u.
            let s = self.uvs;
            let (a, b) = (v, u);
            let uv = (s[0] + a * (s[1] - s[0])) * (1.0 - b) + (s[3] + a * (s[2] - s[3])) * b;
            self.mesh.uvs.push([uv.x as f32, uv.y as f32]);
        }
        for f in [[0, 1, 2], [0, 2, 3]] {
            let f = f.map(|k| base + k);
            let [a, b, c] = f.map(|k| self.mesh.vertices[k as usize]);
            if (b - a).cross(c - a) != Vec3::ZERO {
                self.mesh.faces.push(f);
                self.mesh.normal_indices.push(f);
                self.mesh.uv_indices.push(f);
            }
        }
    }

    /// Unit surface normal at (u, v); x where there is none.
    fn normal(&self, u: f64, v: f64) -> DVec3 {
        let (bu, du) = bernstein(u);
        let (bv, dv) = bernstein(v);
        let sum = |r: [f64; 4], c: [f64; 4]| {
            (0..4).flat_map(|i| (0..4).map(move |j| (i, j))).fold(DVec3::ZERO, |s, (i, j)| s + self.points[i][j] * (r[i] * c[j]))
        };
        sum(du, bv).cross(sum(bu, dv)).try_normalize().unwrap_or(DVec3::X)
    }
}

fn bernstein(t: f64) -> ([f64; 4], [f64; 4]) {
    let s = 1.0 - t;
    (
        [s * s * s, 3.0 * t * s * s, 3.0 * t * t * s, t * t * t],
        [-3.0 * s * s, 3.0 * s * (s - 2.0 * t), 3.0 * t * (2.0 * s - t), 3.0 * t * t],
    )
}

fn split(p: [DVec3; 4]) -> ([DVec3; 4], [DVec3; 4]) {
    let mid = |a: DVec3, b: DVec3| 0.5 * (a + b);
    let (a, b, c) = (mid(p[0], p[1]), mid(p[1], p[2]), mid(p[2], p[3]));
    let (d, e) = (mid(a, b), mid(b, c));
    let m = mid(d, e);
    ([p[0], a, d, m], [m, e, c, p[3]])
}

fn split_columns(net: &Net) -> (Net, Net) {
    let (mut a, mut b) = (*net, *net);
    for i in 0..4 {
        (a[i], b[i]) = split(net[i]);
    }
    (a, b)
}

fn split_rows(net: &Net) -> (Net, Net) {
    let (mut a, mut b) = (*net, *net);
    for j in 0..4 {
        let (p, q) = split(std::array::from_fn(|i| net[i][j]));
        for i in 0..4 {
            (a[i][j], b[i][j]) = (p[i], q[i]);
        }
    }
    (a, b)
}

/// All control points within `flatness` of the plane of three corners; a degenerate plane is not flat.
fn is_flat(net: &Net, flatness: f64) -> bool {
    let Some(n) = (net[0][3] - net[0][0]).cross(net[3][0] - net[0][0]).try_normalize() else { return false };
    net.iter().flatten().all(|p| n.dot(*p - net[0][0]).abs() < flatness)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flat_patch_is_two_triangles_and_a_deep_one_is_cut_by_both_steps() {
        let points: Net = std::array::from_fn(|i| std::array::from_fn(|j| DVec3::new(i as f64, j as f64, 0.0)));
        let uvs = [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y];
        assert_eq!(patch_mesh(&points, &uvs, 0.01, 3, 3).faces.len(), 2);
        assert_eq!(patch_mesh(&points, &uvs, 0.0, 2, 3).faces.len(), 2 * 4 * 8);
        let m = patch_mesh(&points, &uvs, 0.0, 1, 1);
        assert!(m.normals.iter().all(|n| (*n - Vec3::Z).length() < 1e-6));
        // u of the coordinates runs with the second index.
        let corner = m.vertices.iter().position(|p| *p == Vec3::new(0.0, 3.0, 0.0)).expect("a corner");
        assert_eq!(m.uvs[corner], [1.0, 0.0]);
    }
}
