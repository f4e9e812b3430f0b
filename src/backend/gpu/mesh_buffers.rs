//! Meshes for the GPU: corners of faces side by side, what hangs on corners, and all trees in one array of nodes.
//! Twin: `shaders/shared/intersect_mesh.wesl`.

use super::buffers::{append, bits, outward};
use super::texture_buffers::TextureWords;
use super::tree_words::{structure_of, words_per_element};
use crate::accel::{AccelKind, PrimSet, TrianglePrims};
use crate::backend::BackendError;
use crate::compile::shape::MeshShape;
use crate::compile::{CompiledScene, NONE};
use crate::math::{Bounds, DVec3, Vec3};
use crate::savings::Saving;

/// All meshes of a scene.
#[derive(Default)]
pub(super) struct MeshWords {
    /// Three corners a face, the fourth number nothing; faces in the order of their mesh's tree.
    pub corners: Vec<[f32; 4]>,
    /// Normals, coordinates and covers of corners, in the same order.
    pub face_words: Vec<u32>,
    /// Words of all trees; those of the scene come first.
    pub nodes: Vec<u32>,
    /// References of all trees, likewise.
    pub refs: Vec<u32>,
    /// By mesh: its words in the scene's words.
    pub places: Vec<u32>,
    /// Deepest stack that a mesh's tree needs.
    pub depth: u32,
    /// By mesh: first element, first reference, before those of the scene were known.
    trees: Vec<[u32; 2]>,
    /// Words of an element.
    per_element: u32,
}

/// Primitives known by their boxes alone.
pub(super) struct Boxes<'b>(pub &'b [Bounds], pub &'b [u32]);

impl PrimSet for Boxes<'_> {
    fn len(&self) -> usize {
        self.1.len()
    }

    fn bounds(&self, prim_ix: usize) -> Bounds {
        self.0[self.1[prim_ix] as usize]
    }
}

/// Corners and trees (of kind `kind`) of all meshes; their words go to `words`.
pub(super) fn encode_meshes(
    scene: &CompiledScene,
    kind: AccelKind,
    textures: &TextureWords,
    words: &mut Vec<u32>,
) -> Result<MeshWords, BackendError> {
    let g = &scene.geometry;
    let mut out = MeshWords { per_element: words_per_element(kind), ..MeshWords::default() };
    let with_uv = scene.features.uv || !scene.options.savings.has(Saving::Attributes);
    for shape in &g.shapes.meshes {
        let m = &shape.mesh;
        let mut tree = structure_of(kind, &shape.index().tree, &TrianglePrims { vertices: &m.vertices, faces: &m.faces });
        let order = &tree.order;
        out.depth = out.depth.max(tree.depth);
        out.trees.push([out.nodes.len() as u32 / out.per_element, out.refs.len() as u32]);
        let first_face = (out.corners.len() / 3) as u32;
        let corners = order.iter().flat_map(|f| m.faces[*f as usize]);
        out.corners.extend(corners.map(|v| m.vertices[v as usize].extend(0.0).to_array()));
        out.nodes.append(&mut tree.nodes);
        out.refs.append(&mut tree.refs);
        let normals_at = encode_normals(shape, order, &mut out.face_words);
        let uvs_at = if with_uv { encode_uvs(shape, order, &mut out.face_words) } else { 0 };
        let covers_at = encode_covers(shape, order, textures, &mut out.face_words);
        let (low, high) = outward(&shape.bounds);
        let inside = shape.mesh.inside_vector.and_then(DVec3::try_normalize);
        let mut w = vec![0, 0, 0, first_face, order.len() as u32];
        w.extend(bits(low));
        w.extend(bits(high));
        let colors_at = encode_colors(shape, order, &mut out.face_words);
        w.extend([normals_at, uvs_at, covers_at, colors_at, u32::from(inside.is_some())]);
        w.extend(bits(inside.unwrap_or(DVec3::X).as_vec3().to_array()));
        out.places.push(append(words, w));
    }
    Ok(out)
}

impl MeshWords {
    /// Puts the meshes' trees behind the scene's, and their places into the meshes' words.
    pub fn behind(mut self, nodes: &mut Vec<u32>, refs: &mut Vec<u32>, words: &mut [u32]) -> Self {
        let (first_node, first_ref) = (nodes.len() as u32 / self.per_element, refs.len() as u32);
        for (place, [node, r]) in self.places.iter().zip(&self.trees) {
            words[*place as usize..][..3].copy_from_slice(&[first_node + node, 0, first_ref + r]);
        }
        nodes.append(&mut self.nodes);
        refs.append(&mut self.refs);
        self
    }
}

/// Three normals a face; zeros for flat ones.
fn encode_normals(shape: &MeshShape, order: &[u32], words: &mut Vec<u32>) -> u32 {
    let m = &shape.mesh;
    if m.normal_indices.is_empty() {
        return 0;
    }
    let of = |k: u32| m.normals.get(k as usize).copied().unwrap_or(Vec3::ZERO);
    let list = order.iter().flat_map(|face| {
        let ix = m.normal_indices.get(*face as usize).filter(|n| n[0] != u32::MAX);
        ix.map_or([Vec3::ZERO; 3], |ix| ix.map(of)).into_iter().flat_map(|n| bits(n.to_array()))
    });
    append(words, list)
}

fn encode_uvs(shape: &MeshShape, order: &[u32], words: &mut Vec<u32>) -> u32 {
    let m = &shape.mesh;
    if m.uv_indices.is_empty() {
        return 0;
    }
    let of = |k: u32| m.uvs.get(k as usize).copied().unwrap_or([0.0; 2]);
    let list = order.iter().flat_map(|face| {
        let ix = m.uv_indices.get(*face as usize).map_or([[0.0; 2]; 3], |ix| ix.map(of));
        ix.into_iter().flat_map(bits)
    });
    append(words, list)
}

/// Three covers a face, 0 for the object's own.
fn encode_covers(shape: &MeshShape, order: &[u32], textures: &TextureWords, words: &mut Vec<u32>) -> u32 {
    let m = &shape.mesh;
    if m.face_textures.is_empty() {
        return 0;
    }
    let record = |k: u32| match shape.textures.get(k as usize) {
        Some(t) if *t != NONE => textures.textures[*t as usize],
        _ => 0,
    };
    let list = order.iter().flat_map(|face| m.face_textures.get(*face as usize).map_or([0; 3], |c| c.map(record)));
    append(words, list)
}

/// Three colours a face, with alpha.
fn encode_colors(shape: &MeshShape, order: &[u32], words: &mut Vec<u32>) -> u32 {
    let m = &shape.mesh;
    if m.colors.is_empty() {
        return 0;
    }
    append(words, order.iter().flat_map(|f| m.faces[*f as usize]).flat_map(|v| bits(m.colors.get(v as usize).copied().unwrap_or([1.0; 4]))))
}
