//! One tree over the faces of all meshes that stand still, in world space, and one over the primitives that are left: a ray walks one
//! tree where it would walk one of objects and, below it, one of each mesh.
//!
//! Corners are rounded to 32 bits after they were moved to the world, as Embree's and Cycles' are; a corner that faces share stays shared, so
//! no ray slips between them. What must be hit to the last bit (POV-Ray's pictures) asks `Geometry::tree`.

use super::CompiledScene;
use super::geometry::{Geometry, PrimKind, prim_flags};
use super::shape::triangle_pack::TrianglePack;
use crate::accel::{Accel, AccelKind, AccelOptions, Bvh8, NO_PRIM, PACK, PrimSet, TrianglePrims};
use crate::math::simd::is_wide;
use crate::math::{Bounds, Vec3};

/// Copies of shared meshes may have so many faces, or this share of all.
const COPIED_FACES: usize = 1 << 16;
const COPIED_SHARE: usize = 4;

/// A primitive whose faces stand in the tree.
#[derive(Clone, Copy, Debug)]
pub struct Member {
    /// Into [`Geometry::prims`].
    pub prim_ix: u32,
    /// Top-level object.
    pub object_ix: u32,
    /// Number of its first face among those of all members.
    pub first_face: u32,
    /// `prim_flags`.
    pub flags: u32,
}

/// The faces of a scene in one tree.
#[derive(Debug)]
pub struct MergedMeshes {
    /// Over the faces of all members.
    pub tree: Bvh8,
    /// Corners, in the tree's order.
    pub packs: Vec<TrianglePack>,
    /// By slot of the tree, into [`MergedMeshes::members`].
    pub member_of_slot: Vec<u32>,
    /// In the order of their primitives.
    pub members: Vec<Member>,
    /// Bounded primitives that are no members.
    pub rest: Vec<u32>,
    /// Over `rest`.
    pub rest_tree: Accel,
}

/// The boxes of the primitives that are left.
struct Rest<'a>(&'a Geometry, &'a [u32]);

impl PrimSet for Rest<'_> {
    fn len(&self) -> usize {
        self.1.len()
    }

    fn bounds(&self, k: usize) -> Bounds {
        self.0.bounds[self.1[k] as usize]
    }
}

impl MergedMeshes {
    /// Of a scene; `None` where one tree would not be another than those that are there, or where the scene asks for other trees.
    pub fn new(scene: &CompiledScene) -> Option<Self> {
        let is_usual = match scene.options.accel {
            AccelKind::Auto => is_wide(),
            kind => kind == AccelKind::Bvh8,
        };
        // Frames of an animation keep the trees of their meshes.
        if !is_usual || scene.options.trees.is_some() {
            return None;
        }
        let g = &scene.geometry;
        let chosen = chosen(g);
        if chosen.len() < 2 {
            return None;
        }
        Some(Self::of(g, &chosen))
    }

    fn of(g: &Geometry, chosen: &[u32]) -> Self {
        let (mut vertices, mut faces, mut members) = (Vec::new(), Vec::new(), Vec::with_capacity(chosen.len()));
        for prim_ix in chosen {
            let prim = &g.prims[*prim_ix as usize];
            members.push(Member { prim_ix: *prim_ix, object_ix: prim.object_ix, first_face: faces.len() as u32, flags: prim.flags });
            let (mesh, base) = (&g.shapes.meshes[prim.shape_ix as usize].mesh, vertices.len() as u32);
            vertices.extend(mesh.vertices.iter().map(|v| world_corner(g, *prim_ix, *v)));
            faces.extend(mesh.faces.iter().map(|f| f.map(|v| base + v)));
        }
        let prims = TrianglePrims { vertices: &vertices, faces: &faces };
        let tree = Bvh8::build(&prims, &AccelOptions { pack: PACK, in_runs: true, ..AccelOptions::default() });
        let corners = |face: &u32| match *face {
            NO_PRIM => [Vec3::ZERO; 3],
            face => faces[face as usize].map(|v| vertices[v as usize]),
        };
        let packs = tree.slots.chunks(PACK).map(|pack| TrianglePack::new(pack.iter().map(corners))).collect();
        let member = |face: &u32| members.partition_point(|m| m.first_face <= *face).saturating_sub(1) as u32;
        let member_of_slot = tree.slots.iter().map(member).collect();
        let mut is_member = vec![false; g.prims.len()];
        chosen.iter().for_each(|p| is_member[*p as usize] = true);
        let rest: Vec<u32> = g.bounded.iter().copied().filter(|p| !is_member[*p as usize]).collect();
        let rest_tree = Accel::build(AccelKind::Auto, &Rest(g, &rest), &super::flatten::SCENE_TREE);
        Self { tree, packs, member_of_slot, members, rest, rest_tree }
    }

    /// The member that a primitive is.
    pub fn member(&self, prim_ix: u32) -> Option<&Member> {
        self.members.binary_search_by_key(&prim_ix, |m| m.prim_ix).ok().map(|k| &self.members[k])
    }
}

/// A corner of a member in the world, as the tree has it.
pub fn world_corner(g: &Geometry, prim_ix: u32, corner: Vec3) -> Vec3 {
    match g.prims[prim_ix as usize].transform_ix {
        0 => corner,
        ix => g.transforms[ix as usize].point(corner.as_dvec3()).as_vec3(),
    }
}

/// The primitives whose faces one tree may hold: meshes that stand still and are whole; of meshes that several share those whose copies take little.
fn chosen(g: &Geometry) -> Vec<u32> {
    let is_able = |p: &&u32| {
        let prim = &g.prims[**p as usize];
        matches!(prim.kind, PrimKind::Mesh | PrimKind::BicubicPatch)
            && prim.clip_len == 0
            && prim.flags & (prim_flags::MOVING | prim_flags::BOUNDED) == 0
            && g.shapes.meshes[prim.shape_ix as usize].moving.is_none()
    };
    let able: Vec<u32> = g.bounded.iter().filter(is_able).copied().collect();
    let mut uses = vec![0usize; g.shapes.meshes.len()];
    able.iter().for_each(|p| uses[g.prims[*p as usize].shape_ix as usize] += 1);
    let n_faces = |shape: usize| g.shapes.meshes[shape].mesh.faces.len();
    let copied = |shape: usize| (uses[shape] - 1) * n_faces(shape);
    let unique: usize = (0..uses.len()).filter(|s| uses[*s] > 0).map(n_faces).sum();
    let mut shapes: Vec<usize> = (0..uses.len()).filter(|s| uses[*s] > 0).collect();
    shapes.sort_by_key(|s| copied(*s));
    let mut left = COPIED_FACES.max(unique / COPIED_SHARE);
    let mut is_taken = vec![false; uses.len()];
    // A tree numbers fewer than 2^28 slots, four a leaf.
    let mut total = 0usize;
    for s in shapes {
        total += uses[s] * n_faces(s);
        if copied(s) > left || total > 1 << 26 {
            break;
        }
        left -= copied(s);
        is_taken[s] = true;
    }
    able.into_iter().filter(|p| is_taken[g.prims[*p as usize].shape_ix as usize]).collect()
}
