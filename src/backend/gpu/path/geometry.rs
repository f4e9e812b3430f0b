//! All faces of a scene in world space under one tree, for the path integrator: instances are written out.
//! Twins: `shaders/path/surface.wesl`, `shaders/path/scene.wesl`.

use super::super::buffers::inverse_rows;
use super::super::tree_words::{TreeWords, structure_of};
use super::motion::Keys;
use crate::accel::{Accel, AccelKind, PrimSet, TrianglePrims};
use crate::backend::BackendError;
use crate::compile::geometry::{Prim, PrimKind, prim_flags};
use crate::compile::shape::hair::HairSegment;
use crate::compile::texture::TextureNode;
use crate::compile::{CompiledScene, NONE};
use crate::integrate::path::PathPlan;
use crate::math::{Bounds, DVec3, Transform, Vec3};
use std::collections::HashMap;

/// Bits of a face's first word, beside its material.
pub(super) mod face_bits {
    pub const MATERIAL: u32 = (1 << 19) - 1;
    pub const SMOOTH: u32 = 1 << 19;
    pub const UV: u32 = 1 << 20;
    pub const COLORS: u32 = 1 << 21;
    pub const FRONT_ONLY: u32 = 1 << 22;
    /// Times the bits of visibility of camera, diffuse, glossy, transmitted and scattered rays.
    pub const UNSEEN: u32 = 1 << 23;
    pub const NO_SHADOW: u32 = 1 << 28;
    /// Shadow rays go on behind it.
    pub const CLEAR: u32 = 1 << 29;
    /// The camera sees a hole in the film.
    pub const HOLDOUT: u32 = 1 << 30;
    /// A segment of hair.
    pub const HAIR: u32 = 1 << 31;
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
    /// Faces of the emitters: the first, and of a rectangle the second.
    pub emitters: Vec<[u32; 2]>,
    pub low: Vec3,
    pub high: Vec3,
    /// Bits of any face.
    pub bits: u32,
    /// Some face moves.
    pub has_motion: bool,
    /// Place of the last points of hair among the corners.
    pub hair_at: u32,
}

/// One face before it is put in order.
struct Face {
    prim_ix: u32,
    face_ix: u32,
    material: u32,
}

/// Faces of which some move: boxes hold every place of them; then hair.
struct PlacedFaces<'a> {
    still: TrianglePrims<'a>,
    hair: Vec<HairSegment>,
    /// By face; empty for one that stands still.
    moving: HashMap<u32, Bounds>,
}

impl PrimSet for PlacedFaces<'_> {
    fn len(&self) -> usize {
        self.still.len() + self.hair.len()
    }

    fn bounds(&self, k: usize) -> Bounds {
        if let Some(h) = k.checked_sub(self.still.len()) {
            return self.hair[h].bounds();
        }
        self.moving.get(&(k as u32)).copied().unwrap_or_else(|| self.still.bounds(k))
    }

    fn clipped_bounds(&self, k: usize, cell: &Bounds) -> Bounds {
        match self.moving.get(&(k as u32)) {
            _ if k >= self.still.len() => self.bounds(k).intersection(*cell),
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
    let (mut hair, mut of_hair) = (Vec::new(), Vec::new());
    for (prim_ix, prim) in g.prims.iter().enumerate().filter(|(_, p)| p.flags & prim_flags::HIDDEN == 0) {
        debug_assert!(matches!(prim.kind, PrimKind::Mesh | PrimKind::BicubicPatch | PrimKind::Hair), "the others were refused");
        if prim.kind == PrimKind::Hair {
            let material = cover_of(scene, g.surfaces[prim.surface_ix as usize].texture)?;
            let segments = &g.shapes.hairs[prim.shape_ix as usize].segments;
            hair.extend(segments.iter().map(|s| placed_hair(&g.transforms[prim.transform_ix as usize], s)));
            of_hair.extend((0..segments.len() as u32).map(|k| Face { prim_ix: prim_ix as u32, face_ix: k, material }));
            continue;
        }
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
    list.extend(of_hair);
    let n = list.len() as u32;
    let prims = PlacedFaces { still: TrianglePrims { vertices: &vertices, faces: &faces }, hair, moving };
    let tree = structure_of(kind, &Accel::Brute(n), &prims);
    let mut out = FaceTables { low: Vec3::splat(f32::MAX), high: Vec3::splat(f32::MIN), ..FaceTables::default() };
    let boxes = prims.moving.values().copied().chain(prims.hair.iter().map(HairSegment::bounds));
    let places = boxes.flat_map(|b| [b.min.as_vec3(), b.max.as_vec3()]);
    for v in faces.iter().flatten().map(|k| vertices[*k as usize]).chain(places) {
        (out.low, out.high) = (out.low.min(v), out.high.max(v));
    }
    out.has_motion = !keys.is_empty();
    let (mut of_keys, mut hair_ends): (Vec<[f32; 4]>, Vec<[f32; 4]>) = (Vec::new(), Vec::new());
    let emitter_of: HashMap<(u32, u32), u32> =
        plan.lights.emitters.list.iter().zip(0..).flat_map(|(e, k)| e.faces().map(move |face| ((e.prim_ix, face), k))).collect();
    out.emitters = vec![[0; 2]; plan.lights.emitters.list.len()];
    for ix in &tree.order {
        let Face { prim_ix, face_ix, material } = list[*ix as usize];
        let prim = &g.prims[prim_ix as usize];
        if let Some(s) = (*ix as usize).checked_sub(faces.len()).map(|k| &prims.hair[k]) {
            let bits = flag_bits(prim.flags) | object_bits(scene, prim) | if clear[material as usize] { face_bits::CLEAR } else { 0 };
            let [a, b, c, d] = s.points.map(|p| p.as_vec3());
            let fourth = [-1.0 - hair_ends.len() as f32, s.radii[0] as f32, s.radii[1] as f32];
            out.corners.extend([a, b, c].iter().zip(fourth).map(|(p, w)| p.extend(w).to_array()));
            hair_ends.push(d.extend(0.0).to_array());
            out.faces.push([material | bits | face_bits::HAIR, 0, objects.get(&prim_ix).copied().unwrap_or(0), 0]);
            out.bits |= bits | face_bits::HAIR;
            continue;
        }
        let (hung_at, mut bits) = hang(scene, prim, face_ix, more_uvs as usize, &mut out.hung);
        bits |= flag_bits(prim.flags) | if clear[material as usize] { face_bits::CLEAR } else { 0 };
        let emitter = emitter_of.get(&(prim_ix, face_ix)).copied();
        if let Some(k) = emitter {
            let own = &plan.lights.emitters.list[k as usize];
            out.emitters[k as usize][(face_ix - own.face_ix) as usize] = out.faces.len() as u32;
            bits |= if own.front_only { face_bits::FRONT_ONLY } else { 0 };
        }
        bits |= object_bits(scene, prim);
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
    out.hair_at = out.corners.len() as u32;
    out.corners.extend(hair_ends);
    out.tree = tree;
    Ok(out)
}

/// Corners so that the front is where the object's own goes: a mirror turns them round.
fn turned<T: Copy>(t: &Transform, [a, b, c]: [T; 3]) -> [T; 3] {
    if t.forward.matrix3.determinant() < 0.0 { [a, c, b] } else { [a, b, c] }
}

fn object_bits(scene: &CompiledScene, prim: &Prim) -> u32 {
    let holdout = scene.geometry.objects.get(prim.object_ix as usize).is_some_and(|o| o.traits.holdout);
    if holdout { face_bits::HOLDOUT } else { 0 }
}

/// A segment in world space; a ribbon that is as wide along all directions.
fn placed_hair(t: &Transform, s: &HairSegment) -> HairSegment {
    let scale = t.forward.matrix3.determinant().abs().cbrt();
    HairSegment { points: s.points.map(|p| t.point(p)), radii: s.radii.map(|r| r * scale), curve: s.curve }
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
    cover_of(scene, texture)
}

fn cover_of(scene: &CompiledScene, texture: u32) -> Result<u32, BackendError> {
    match scene.textures.textures.get(texture as usize) {
        Some(TextureNode::Principled(ix)) if *ix <= face_bits::MATERIAL => Ok(*ix),
        _ => Err(BackendError::Unsupported("path tracing of objects without a material".into())),
    }
}

fn flag_bits(flags: u32) -> u32 {
    let has = |f: u32| u32::from(flags & f != 0);
    let unseen = has(prim_flags::NO_IMAGE)
        | has(prim_flags::NO_DIFFUSE | prim_flags::NO_RADIOSITY) << 1
        | has(prim_flags::NO_GLOSSY | prim_flags::NO_REFLECTION) << 2
        | has(prim_flags::NO_TRANSMISSION) << 3
        | has(prim_flags::NO_VOLUME) << 4;
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

/// Words of an object: its number, rows of the map into its space, then what tangents look at.
pub(super) const OBJECT_INVERSE: u32 = 1;
pub(super) const OBJECT_TANGENTS: u32 = 13;
/// Words of an object in one place, for tangents.
pub(super) const OBJECT_WORDS: u32 = 14;

/// Words of an object, the last as tangents look at it: two rows of the map to its box (-0.5..0.5), two columns of the map of normals; of one that
/// moves so many for each key.
pub(super) fn object_words(scene: &CompiledScene, prim_ix: u32) -> Vec<u32> {
    let prim = &scene.geometry.prims[prim_ix as usize];
    let g = &scene.geometry;
    // A body's grid stands in the space of its first primitive, at rest.
    let first = g.objects.get(prim.object_ix as usize).map_or(prim_ix, |o| o.prims.start);
    let body = g.prims.get(first as usize).map_or(Transform::IDENTITY, |p| g.transforms[p.transform_ix as usize]);
    let head: Vec<u32> = std::iter::once(prim.object_ix).chain(inverse_rows(&body)).collect();
    if prim.kind == PrimKind::Hair {
        return [head, words_of_place(&scene.geometry.bounds[prim_ix as usize], &Transform::IDENTITY)].concat();
    }
    let places = match Keys::of(scene, prim) {
        Some(keys) => keys.places,
        None => vec![scene.geometry.transforms[prim.transform_ix as usize]],
    };
    let b = &scene.geometry.shapes.meshes[prim.shape_ix as usize].bounds;
    head.into_iter().chain(places.iter().flat_map(|t| words_of_place(b, t))).collect()
}

fn words_of_place(b: &Bounds, t: &Transform) -> Vec<u32> {
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
