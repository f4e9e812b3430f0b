//! Leaves of an object's tree: the primitives with their covers.

use super::super::geometry::{Prim, PrimKind, Surface, prim_flags};
use super::super::leaf::{Degenerate, Leaf, add_glyph, add_leaf};
use super::super::programs::{Node, NodeKind};
use super::super::{CompileError, NONE};
use super::{Flattener, Inherited};
use crate::math::{Bounds, Transform};
use crate::scene::{Object, Shape};
use std::sync::Arc;

/// Most primitives of a scene (triangles of meshes are not counted).
const MAX_PRIMS: usize = 1 << 26;
/// Bytes of a primitive with its bounds, shape and place.
const PRIM_COST: usize = 512;

impl Flattener {
    /// A text: a plain union of its letters.
    pub(super) fn text(&mut self, object: &Object, inside: &Inherited, inverted: bool) -> Result<Option<Node>, CompileError> {
        let Shape::Text { glyphs, depth } = &object.shape else { return Ok(None) };
        let mut list = Vec::with_capacity(glyphs.len());
        for g in glyphs {
            if let Some(leaf) = add_glyph(g, *depth, &inside.to_world, &mut self.leaves) {
                let first = self.geometry.prims.len() as u32;
                let mut node = self.add_prim(&leaf, inside, inverted, true)?;
                node.prims = first..first + 1;
                self.nodes.push(node);
                list.push(self.nodes.len() - 1);
            }
        }
        Ok(self.join(list, inverted, inverted))
    }

    pub(super) fn leaf(&mut self, object: &Object, inside: &Inherited, inverted: bool, in_csg: bool) -> Result<Option<Node>, CompileError> {
        match add_leaf(object, &inside.to_world, &mut self.leaves, &mut self.transforms, &mut self.textures) {
            Ok(leaf) => self.add_prim(&leaf, inside, inverted, in_csg).map(Some),
            Err(Degenerate) => Ok(None),
        }
    }

    fn add_prim(&mut self, leaf: &Leaf, inside: &Inherited, inverted: bool, in_csg: bool) -> Result<Node, CompileError> {
        self.charge(PRIM_COST)?;
        if self.geometry.prims.len() >= MAX_PRIMS {
            return Err(CompileError::TooMany { what: "primitives", count: MAX_PRIMS as u64 + 1, limit: MAX_PRIMS as u64 });
        }
        // POV-Ray's patches have no inside, turned round neither: a difference that takes one off is empty but for the patch (measured).
        let inverted = inverted && leaf.solid;
        let mut flags = inside.flags;
        flags |= if inverted { prim_flags::INVERTED } else { 0 };
        flags |= if in_csg { prim_flags::CSG_CHILD } else { 0 };
        let surface_ix = self.surface(leaf, inside, &mut flags);
        if let Some(i) = self.interiors.get_mut(inside.interior_ix as usize) {
            i.hollow = inside.hollow == Some(true);
        }
        let prim_ix = self.geometry.prims.len() as u32;
        if let Some(importance) = inside.importance {
            self.geometry.importances.resize(prim_ix as usize, f64::NAN);
            self.geometry.importances.push(importance);
        }
        self.geometry.prims.push(Prim {
            kind: leaf.kind,
            shape_ix: leaf.shape_ix,
            transform_ix: self.transforms.add(&leaf.transform),
            surface_ix,
            interior_ix: inside.interior_ix,
            object_ix: self.geometry.objects.len() as u32,
            clip_start: 0,
            clip_len: 0,
            flags,
            group_ix: inside.group_ix,
        });
        self.geometry.bounds.push(leaf.surface_bounds);
        let (bounds, cobounds) = if inverted { (Bounds::UNBOUNDED, leaf.inside_bounds) } else { (leaf.inside_bounds, Bounds::UNBOUNDED) };
        Ok(Node::new(NodeKind::Leaf(prim_ix), [bounds, cobounds], leaf.surface_bounds, leaf.solid))
    }

    /// The cover that a leaf gets; sets `TRANSPARENT` and `NEEDS_UV`.
    fn surface(&mut self, leaf: &Leaf, inside: &Inherited, flags: &mut u32) -> u32 {
        if *flags & prim_flags::HIDDEN != 0 {
            return self.surfaces.add(Surface { texture: NONE, interior_texture: NONE, transform_ix: 0 });
        }
        let cutaway = *flags & prim_flags::CUTAWAY != 0;
        let (texture, space) = match &inside.texture {
            Some((t, space)) => (self.textures.texture(t), *space),
            None if cutaway => (NONE, Transform::IDENTITY),
            None => (self.textures.texture(&self.default_texture.clone()), Transform::IDENTITY),
        };
        let interior_texture = match &inside.interior_texture {
            Some((t, own)) if own.forward == space.forward => self.textures.texture(t),
            Some((t, own)) => {
                let mut moved = t.clone();
                Arc::make_mut(&mut moved).transform(&own.then(&space.inverted()));
                self.textures.texture(&moved)
            }
            None => NONE,
        };
        let parts: &[u32] = match leaf.kind {
            PrimKind::Mesh => &self.leaves.shapes.meshes[leaf.shape_ix as usize].textures,
            PrimKind::Blob => &self.leaves.shapes.blobs[leaf.shape_ix as usize].textures,
            _ => &[],
        };
        let unknown = cutaway && texture == NONE;
        let covers = || [texture, interior_texture].into_iter().chain(parts.iter().copied()).filter(|t| *t != NONE);
        if unknown || covers().any(|t| self.textures.is_transparent(t)) {
            *flags |= prim_flags::TRANSPARENT;
        }
        if unknown || covers().any(|t| self.textures.needs_uv(t)) {
            *flags |= prim_flags::NEEDS_UV;
        }
        // A cover on (u, v) does not move with its object.
        let transform_ix = if *flags & prim_flags::UV_MAPPING != 0 { 0 } else { self.transforms.add(&space) };
        self.surfaces.add(Surface { texture, interior_texture, transform_ix })
    }
}
