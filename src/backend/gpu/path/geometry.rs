//! All faces of a scene in world space under one tree, for the path integrator: instances are written out.
//! Twins: `shaders/path/surface.wesl`, `shaders/path/scene.wesl`.

use super::super::tree_words::{TreeWords, structure_of};
use super::motion::Keys;
use crate::accel::{Accel, AccelKind, PrimSet, TrianglePrims};
use crate::backend::BackendError;
use crate::compile::geometry::{Prim, PrimKind, prim_flags};
use crate::compile::texture::TextureNode;
use crate::compile::{CompiledScene, NONE};
use crate::integrate::path::PathPlan;
use crate::math::{Bounds, DVec3, Transform, Vec3};
use std::collections::HashMap;

/// Bits of a face's first word, beside its material.
pub(super) mod face_bits {
    pub const MATERIAL: u32 = (1 << 20) - 1;
    pub const SMOOTH: u32 = 1 << 20;
    pub const UV: u32 = 1 << 21;
    pub const COLORS: u32 = 1 << 22;
    pub const FRONT_ONLY: u32 = 1 << 23;
    /// Times the bits of visibility of camera, diffuse, glossy and transmitted rays.
    pub const UNSEEN: u32 = 1 << 24;
    pub const NO_SHADOW: u32 = 1 << 28;
    /// Shadow rays go on behind it.
    pub const CLEAR: u32 = 1 << 29;
    /// The camera sees a hole in the film.
    pub const HOLDOUT: u32 = 1 << 30;
}

/// Faces and their tree, in the tree's order.
#[derive(Default)]
pub(super) struct FaceTables {
    pub tree: TreeWords,
    /// Three corners a face, then the keys of those that move (`shaders/path/corners.wesl`).
    pub corners: Vec<[f32; 4]>,
    /// What hangs on corners: normals, coordinates, colours.
    pub hung: Vec<u32>,
    /// Material and bits, place of what hangs on the corners, place of the object, emitter + 1.
    pub faces: Vec<[u32; 4]>,
    /// Faces of the emitters.
    pub emitters: Vec<u32>,
    pub low: Vec3,
    pub high: Vec3,
    /// Bits of any face.
    pub bits: u32,
    /// Some face moves.
    pub has_motion: bool,
}

/// One face before it is put in order.
struct Face {
    prim_ix: u32,
    face_ix: u32,
    material: u32,
}

/// Faces of which some move: boxes hold every place of them.
struct PlacedFaces<'a> {
    still: TrianglePrims<'a>,
    /// By face; empty for one that stands still.
    moving: HashMap<u32, Bounds>,
}

impl PrimSet for PlacedFaces<'_> {
    fn len(&self) -> usize {
        self.still.len()
    }

    fn bounds(&self, k: usize) -> Bounds {
        self.moving.get(&(k as u32)).copied().unwrap_or_else(|| self.still.bounds(k))
    }

    fn clipped_bounds(&self, k: usize, cell: &Bounds) -> Bounds {
        match self.moving.get(&(k as u32)) {
            Some(b) => b.intersection(*cell),
            None => self.still.clipped_bounds(k, cell),
        }
    }
}

/// Writes out all faces. `clear`: by material, whether shadow rays go on behind it. `objects`: place of each primitive's words.
pub(super) fn encode_faces(
    scene: &CompiledScene,
    plan: &PathPlan,
    kind: AccelKind,
    clear: &[bool],
    objects: &HashMap<u32, u32>,
    more_uvs: u32,
) -> Result<FaceTables, BackendError> {
    let g = &scene.geometry;
    let (mut vertices, mut faces, mut list) = (Vec::new(), Vec::new(), Vec::new());
    let (mut keys, mut moving) = (HashMap::new(), HashMap::new());
    for (prim_ix, prim) in g.prims.iter().enumerate().filter(|(_, p)| p.flags & prim_flags::HIDDEN == 0) {
        debug_assert!(matches!(prim.kind, PrimKind::Mesh | PrimKind::BicubicPatch), "the others were refused");
        let shape = &g.shapes.meshes[prim.shape_ix as usize];
        let t = &g.transforms[prim.transform_ix as usize];
        let first = vertices.len() as u32;
        let own = Keys::of(scene, prim);
        vertices.extend(shape.mesh.vertices.iter().map(|v| t.point(v.as_dvec3()).as_vec3()));
        for (face_ix, corners) in shape.mesh.faces.iter().enumerate() {
            let material = material_of(scene, prim, face_ix)?;
            if let Some(own) = &own {
                let all = (0..own.places.len()).flat_map(|k| own.corners(scene, prim, face_ix as u32, k));
                moving.insert(faces.len() as u32, Bounds::from_points(all.map(|p| p.as_dvec3())));
            }
            faces.push(turned(t, corners.map(|v| first + v)));
            list.push(Face { prim_ix: prim_ix as u32, face_ix: face_ix as u32, material });
        }
        keys.extend(own.map(|own| (prim_ix as u32, own)));
    }
    let n = faces.len() as u32;
    let prims = PlacedFaces { still: TrianglePrims { vertices: &vertices, faces: &faces }, moving };
    let tree = structure_of(kind, &Accel::Brute(n), &prims);
    let mut out = FaceTables { low: Vec3::splat(f32::MAX), high: Vec3::splat(f32::MIN), ..FaceTables::default() };
    let places = prims.moving.values().flat_map(|b| [b.min.as_vec3(), b.max.as_vec3()]);
    for v in faces.iter().flatten().map(|k| vertices[*k as usize]).chain(places) {
        (out.low, out.high) = (out.low.min(v), out.high.max(v));
    }
    out.has_motion = !keys.is_empty();
    let mut of_keys: Vec<[f32; 4]> = Vec::new();
    let emitter_of: HashMap<(u32, u32), u32> =
        plan.lights.emitters.list.iter().enumerate().map(|(k, e)| ((e.prim_ix, e.face_ix), k as u32)).collect();
    out.emitters = vec![0; plan.lights.emitters.list.len()];
    for ix in &tree.order {
        let Face { prim_ix, face_ix, material } = list[*ix as usize];
        let prim = &g.prims[prim_ix as usize];
        let (hung_at, mut bits) = hang(scene, prim, face_ix, more_uvs as usize, &mut out.hung);
        bits |= flag_bits(prim.flags) | if clear[material as usize] { face_bits::CLEAR } else { 0 };
        let emitter = emitter_of.get(&(prim_ix, face_ix)).copied();
        if let Some(k) = emitter {
            out.emitters[k as usize] = out.faces.len() as u32;
            bits |= if plan.lights.emitters.list[k as usize].front_only { face_bits::FRONT_ONLY } else { 0 };
        }
        let holdout = g.objects.get(prim.object_ix as usize).is_some_and(|o| o.traits.holdout);
        bits |= if holdout { face_bits::HOLDOUT } else { 0 };
        let mut fourth = [0.0; 3];
        if let Some(own) = keys.get(&prim_ix) {
            let normals = normals_of(scene, prim, face_ix);
            fourth = [n as f32 + (of_keys.len() / 3) as f32, (own.places.len() - 1) as f32, if normals.is_some() { 2.0 } else { 1.0 }];
            for (k, t) in own.places.iter().enumerate() {
                let corners = Some(own.corners(scene, prim, face_ix, k)).into_iter();
                let all = corners.chain(normals.map(|ix| own.normals(scene, prim, ix, k)));
                of_keys.extend(all.flat_map(|v| turned(t, v)).map(|v| v.extend(0.0).to_array()));
            }
        }
        let corners = faces[*ix as usize].map(|v| vertices[v as usize]);
        out.corners.extend(corners.iter().zip(fourth).map(|(v, w)| v.extend(w).to_array()));
        let object_at = objects.get(&prim_ix).copied().unwrap_or(0);
        out.faces.push([material | bits, hung_at, object_at, emitter.map_or(0, |k| k + 1)]);
        out.bits |= bits;
    }
    out.corners.extend(of_keys);
    out.tree = tree;
    Ok(out)
}

/// Corners so that the front is where the object's own goes: a mirror turns them round.
fn turned<T: Copy>(t: &Transform, [a, b, c]: [T; 3]) -> [T; 3] {
    if t.forward.matrix3.determinant() < 0.0 { [a, c, b] } else { [a, b, c] }
}

/// Normals of a smooth face's corners, into the mesh's.
fn normals_of(scene: &CompiledScene, prim: &Prim, face_ix: u32) -> Option<[u32; 3]> {
    let mesh = &scene.geometry.shapes.meshes[prim.shape_ix as usize].mesh;
    mesh.normal_indices.get(face_ix as usize).filter(|n| n[0] != u32::MAX).copied()
}

/// Into `TextureTables::principled`.
fn material_of(scene: &CompiledScene, prim: &Prim, face_ix: usize) -> Result<u32, BackendError> {
    let g = &scene.geometry;
    let shape = &g.shapes.meshes[prim.shape_ix as usize];
    let refused = |what: &str| Err(BackendError::Unsupported(format!("path tracing of {what}")));
    let texture = match shape.mesh.face_textures.get(face_ix) {
        Some([a, b, c]) if a != b || a != c => return refused("faces with several textures"),
        Some([k, ..]) if *k != u32::MAX => shape.textures.get(*k as usize).copied().unwrap_or(NONE),
        _ => g.surfaces[prim.surface_ix as usize].texture,
    };
    match scene.textures.textures.get(texture as usize) {
        Some(TextureNode::Principled(ix)) if *ix <= face_bits::MATERIAL => Ok(*ix),
        _ => refused("objects without a material"),
    }
}

fn flag_bits(flags: u32) -> u32 {
    let has = |f: u32| u32::from(flags & f != 0);
    let unseen = has(prim_flags::NO_IMAGE)
        | has(prim_flags::NO_DIFFUSE | prim_flags::NO_RADIOSITY) << 1
        | has(prim_flags::NO_GLOSSY | prim_flags::NO_REFLECTION) << 2
        | has(prim_flags::NO_TRANSMISSION) << 3;
    (face_bits::UNSEEN * unseen) | (face_bits::NO_SHADOW * has(prim_flags::NO_SHADOW))
}

/// Coordinates of a mesh, and which of them a face's corners have.
type UvSet<'m> = (&'m [[f32; 2]], [u32; 3]);

/// What hangs on the corners of a face: its place, and the bits that say what there is.
fn hang(scene: &CompiledScene, prim: &Prim, face_ix: u32, more_uvs: usize, words: &mut Vec<u32>) -> (u32, u32) {
    let g = &scene.geometry;
    let mesh = &g.shapes.meshes[prim.shape_ix as usize].mesh;
    let t = &g.transforms[prim.transform_ix as usize];
    let (at, mut bits, face) = (words.len() as u32, 0, face_ix as usize);
    if let Some(ix) = normals_of(scene, prim, face_ix) {
        bits |= face_bits::SMOOTH;
        let normal = |k: u32| t.normal(mesh.normals.get(k as usize).map_or(DVec3::ZERO, |n| n.as_dvec3())).as_vec3();
        words.extend(turned(t, ix.map(normal)).iter().flat_map(|n| n.to_array()).map(f32::to_bits));
    }
    let sets: Vec<Option<UvSet>> = std::iter::once(mesh.uv_indices.get(face).map(|ix| (&mesh.uvs[..], *ix)))
        .chain((0..more_uvs).map(|k| mesh.more_uvs.get(k).and_then(|m| Some((&m.uvs[..], *m.indices.get(face)?)))))
        .collect();
    if sets.iter().any(Option::is_some) {
        bits |= face_bits::UV;
        for set in sets {
            // A set that is not there is a point.
            let uv = set.map_or([[0.0; 2]; 3], |(uvs, ix)| ix.map(|k| uvs.get(k as usize).copied().unwrap_or([0.0; 2])));
            words.extend(turned(t, uv).iter().flatten().map(|v| v.to_bits()));
        }
    }
    if !mesh.colors.is_empty() {
        bits |= face_bits::COLORS;
        let colors = mesh.faces[face].map(|k| mesh.colors.get(k as usize).copied().unwrap_or([1.0; 4]));
        words.extend(turned(t, colors).iter().flat_map(|c| [c[0], c[1], c[2]]).map(f32::to_bits));
    }
    (at, bits)
}

/// Words of an object in one place.
pub(super) const OBJECT_WORDS: u32 = 14;

/// Words of an object as tangents look at it: two rows of the map to its box (-0.5..0.5), two columns of the map of normals; of one that
/// moves so many for each key.
pub(super) fn object_words(scene: &CompiledScene, prim: &Prim) -> Vec<u32> {
    let places = match Keys::of(scene, prim) {
        Some(keys) => keys.places,
        None => vec![scene.geometry.transforms[prim.transform_ix as usize]],
    };
    places.iter().flat_map(|t| words_of_place(scene, prim, t)).collect()
}

fn words_of_place(scene: &CompiledScene, prim: &Prim, t: &Transform) -> Vec<u32> {
    let g = &scene.geometry;
    let b = &g.shapes.meshes[prim.shape_ix as usize].bounds;
    let (center, size) = (0.5 * (b.min + b.max), (b.max - b.min).max(DVec3::splat(1e-12)));
    let m = t.inverse.matrix3;
    let rows = (0..2).flat_map(|k| {
        let row = DVec3::new(m.x_axis[k], m.y_axis[k], m.z_axis[k]) / size[k];
        [row.x, row.y, row.z, (t.inverse.translation[k] - center[k]) / size[k]]
    });
    let columns = [DVec3::X, DVec3::Y].into_iter().flat_map(|n| t.normal(n).to_array());
    let words: Vec<u32> = rows.chain(columns).map(|v| (v as f32).to_bits()).collect();
    debug_assert_eq!(words.len() as u32, OBJECT_WORDS);
    words
}
