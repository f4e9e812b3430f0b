//! Faces → one mesh a material, with the vertices that it uses.

use super::super::ImportError;
use super::super::picture::linear_from_srgb;
use super::geometry::{Corner, Geometry, NONE, Run};
use super::polygon::Cutter;
use crate::math::Vec3;
use crate::scene::Mesh;
use std::collections::HashMap;
use std::path::Path;

/// One table of the file (vertices, normals, coordinates) as one mesh uses it.
struct Subset {
    /// By index of the file; `NONE` when not used yet.
    own: Vec<u32>,
    used: Vec<u32>,
}

impl Subset {
    fn new(n: usize) -> Self {
        Self { own: vec![NONE; n], used: Vec::new() }
    }

    /// The mesh's index of the file's.
    fn take(&mut self, ix: u32) -> u32 {
        let own = &mut self.own[ix as usize];
        if *own == NONE {
            *own = self.used.len() as u32;
            self.used.push(ix);
        }
        *own
    }

    /// The indices used, and a fresh start.
    fn finish(&mut self) -> Vec<u32> {
        for ix in &self.used {
            self.own[*ix as usize] = NONE;
        }
        std::mem::take(&mut self.used)
    }
}

/// Meshes with the names of their materials: that without a material first, then in the order of first use; empty ones are left out.
pub(super) fn by_material<'g>(path: &Path, g: &'g Geometry) -> Result<Vec<(&'g str, Mesh)>, ImportError> {
    let smooth = SmoothNormals::of(g);
    let mut subsets = [g.vertices.len(), g.uvs.len(), g.normals.len() + smooth.normals.len()].map(Subset::new);
    if g.normals.len() + smooth.normals.len() >= NONE as usize {
        return Err(ImportError::TooMany { path: path.to_owned(), what: "normals", limit: NONE as usize });
    }
    let mut cutter = Cutter::new();
    let mut out = Vec::new();
    for (material, name) in g.materials.iter().enumerate() {
        let mesh = mesh_of(g, material as u32, &smooth, &mut subsets, &mut cutter);
        if !mesh.faces.is_empty() {
            out.push((name.as_str(), mesh));
        }
    }
    Ok(out)
}

/// The faces of each run: (run, first face, one past the last).
fn runs(g: &Geometry) -> impl Iterator<Item = (&Run, std::ops::Range<usize>)> {
    let ends = g.runs.iter().skip(1).map(|r| r.first).chain(std::iter::once(g.face_ends.len()));
    g.runs.iter().zip(ends).map(|(r, end)| (r, r.first..end))
}

fn mesh_of(g: &Geometry, material: u32, smooth: &SmoothNormals, [vertices, uvs, normals]: &mut [Subset; 3], cutter: &mut Cutter) -> Mesh {
    let mut mesh = Mesh::default();
    let mut positions: Vec<Vec3> = Vec::new();
    let (mut any_normal, mut any_uv) = (false, false);
    for (run, faces) in runs(g).filter(|(r, _)| r.material == material) {
        for face in faces {
            let corners = g.face(face);
            positions.clear();
            positions.extend(corners.iter().map(|c| g.vertices[c.vertex as usize]));
            cutter.cut(&positions, |t| {
                let t = t.map(|k| corners[k]);
                mesh.faces.push(t.map(|c| vertices.take(c.vertex)));
                let has_normals = t.iter().all(|c| c.normal != NONE);
                let of = |c: Corner| if has_normals { Some(c.normal) } else { smooth.index(run.smoothing, c.vertex) };
                let n = t.map(of);
                let flat = n.iter().any(Option::is_none);
                any_normal |= !flat;
                mesh.normal_indices.push(if flat { [NONE; 3] } else { n.map(|ix| normals.take(ix.expect("none is missing"))) });
                // A corner without coordinates takes the first ones: (0, 0) where nothing says otherwise.
                let has_uvs = t.iter().all(|c| c.uv != NONE);
                any_uv |= has_uvs;
                mesh.uv_indices.push(if has_uvs { t.map(|c| uvs.take(c.uv)) } else { [NONE; 3] });
            });
        }
    }
    let used = vertices.finish();
    mesh.vertices = used.iter().map(|k| g.vertices[*k as usize]).collect();
    if !g.colors.is_empty() {
        let linear = |c: [f32; 3]| [decoded(c[0]), decoded(c[1]), decoded(c[2]), 1.0];
        mesh.colors = used.iter().map(|k| g.colors.get(*k as usize).map_or([1.0; 4], |c| linear(*c))).collect();
    }
    mesh.normals = normals.finish().iter().map(|k| smooth.normal(g, *k)).collect();
    mesh.uvs = uvs.finish().iter().map(|k| g.uvs[*k as usize]).collect();
    if !any_normal {
        mesh.normal_indices = Vec::new();
    }
    if !any_uv {
        mesh.uv_indices = Vec::new();
    } else if mesh.uv_indices.contains(&[NONE; 3]) {
        let zero = mesh.uvs.len() as u32;
        mesh.uvs.push([0.0; 2]);
        mesh.uv_indices.iter_mut().filter(|u| u[0] == NONE).for_each(|u| *u = [zero; 3]);
    }
    mesh
}

/// Vertex colours are written sRGB-encoded.
fn decoded(v: f32) -> f32 {
    linear_from_srgb(v.max(0.0))
}

/// Normals of faces that have none but a smoothing group: the mean over the group's faces around a vertex, by area.
struct SmoothNormals {
    /// Behind the file's own normals, by (group, vertex).
    index_of: HashMap<(u32, u32), u32>,
    normals: Vec<Vec3>,
    n_own: u32,
}

impl SmoothNormals {
    fn of(g: &Geometry) -> Self {
        let mut s = Self { index_of: HashMap::new(), normals: Vec::new(), n_own: g.normals.len() as u32 };
        for (run, faces) in runs(g).filter(|(r, _)| r.smoothing != 0) {
            for face in faces {
                let corners = g.face(face);
                if corners.iter().all(|c| c.normal != NONE) {
                    continue;
                }
                let p = |k: usize| g.vertices[corners[k % corners.len()].vertex as usize] - g.vertices[corners[0].vertex as usize];
                let area = (0..corners.len()).fold(Vec3::ZERO, |sum, k| sum + p(k).cross(p(k + 1)));
                for c in corners {
                    let next = s.normals.len() as u32;
                    let ix = *s.index_of.entry((run.smoothing, c.vertex)).or_insert(next);
                    if ix == next {
                        s.normals.push(Vec3::ZERO);
                    }
                    s.normals[ix as usize] += area;
                }
            }
        }
        s.normals.iter_mut().for_each(|n| *n = n.try_normalize().unwrap_or(Vec3::ZERO));
        s
    }

    fn index(&self, group: u32, vertex: u32) -> Option<u32> {
        if group == 0 { None } else { self.index_of.get(&(group, vertex)).map(|k| self.n_own + k) }
    }

    fn normal(&self, g: &Geometry, ix: u32) -> Vec3 {
        g.normals.get(ix as usize).copied().unwrap_or_else(|| self.normals[(ix - self.n_own) as usize])
    }
}
