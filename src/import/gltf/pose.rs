//! The tree of nodes at a moment: which nodes are shown, in which order, and where each is. Source: glTF 2.0, section 3.5.

use super::super::ImportError;
use super::Document;
use super::animation::{Clip, NodeKeys};
use crate::math::{DAffine3, DMat3, DVec3};
use ::gltf::json;
use glam::DQuat;
use std::collections::BTreeMap;

/// Deepest nesting of nodes. Rigs reach some tens; Blender's own limit of parents is lower.
const MAX_DEPTH: usize = 1000;

/// The nodes that are shown, parents before children, each with its parent.
pub(super) struct Tree {
    pub order: Vec<(usize, Option<usize>)>,
}

impl Tree {
    /// The default scene's nodes, else the first's, else all.
    pub fn new(doc: &Document) -> Result<Self, ImportError> {
        let path = || doc.path.to_owned();
        let mut reached = vec![false; doc.root.nodes.len()];
        let mut order = Vec::new();
        let mut waiting: Vec<(usize, Option<usize>, usize)> = roots(doc)?.into_iter().rev().map(|n| (n, None, 1)).collect();
        while let Some((ix, parent, depth)) = waiting.pop() {
            let node = doc.get(&doc.root.nodes, ix, "node", || "the tree of nodes".into())?;
            if std::mem::replace(&mut reached[ix], true) {
                return Err(ImportError::NodeReachedTwice { path: path(), node: ix });
            }
            if depth > MAX_DEPTH {
                return Err(ImportError::TooDeep { path: path(), node: ix, limit: MAX_DEPTH });
            }
            order.push((ix, parent));
            waiting.extend(node.children.iter().flatten().rev().map(|c| (c.value(), Some(ix), depth + 1)));
        }
        Ok(Self { order })
    }
}

fn roots(doc: &Document) -> Result<Vec<usize>, ImportError> {
    let root = doc.root;
    if let Some(ix) = root.scene.map(|s| s.value()).or((!root.scenes.is_empty()).then_some(0)) {
        let scene = doc.get(&root.scenes, ix, "scene", || "the default scene".into())?;
        return Ok(scene.nodes.iter().map(|n| n.value()).collect());
    }
    let mut has_parent = vec![false; root.nodes.len()];
    for child in root.nodes.iter().flat_map(|n| n.children.iter().flatten()) {
        if let Some(h) = has_parent.get_mut(child.value()) {
            *h = true;
        }
    }
    Ok((0..has_parent.len()).filter(|k| !has_parent[*k]).collect())
}

/// Where nodes are.
pub(super) struct Pose {
    /// World from node, by index; `None` for nodes that are not shown.
    worlds: Vec<Option<DAffine3>>,
    keys: BTreeMap<usize, NodeKeys>,
}

impl Pose {
    /// At a moment of an animation, or as the file has it. `still`: a node whose own transform is left out.
    pub fn new(doc: &Document, tree: &Tree, moment: Option<(&Clip, f64)>, still: Option<usize>) -> Result<Self, ImportError> {
        let keys = moment.map_or_else(BTreeMap::new, |(clip, seconds)| clip.at(seconds));
        let mut worlds: Vec<Option<DAffine3>> = vec![None; doc.root.nodes.len()];
        for (ix, parent) in &tree.order {
            let above = parent.and_then(|p| worlds[p]).unwrap_or(DAffine3::IDENTITY);
            let world = if still == Some(*ix) { above } else { above * local(&doc.root.nodes[*ix], keys.get(ix)) };
            if !world.is_finite() {
                return Err(doc.invalid(format!("node {ix}"), "its transform is not finite"));
            }
            worlds[*ix] = Some(world);
        }
        Ok(Self { worlds, keys })
    }

    /// World from node; `None` for nodes that are not shown.
    pub fn world(&self, ix: usize) -> Option<DAffine3> {
        self.worlds[ix]
    }

    /// Morph weights that keys give a node.
    pub fn weights(&self, ix: usize) -> Option<&[f32]> {
        self.keys.get(&ix)?.weights.as_deref()
    }
}

/// The node's own transform.
fn local(node: &json::Node, keys: Option<&NodeKeys>) -> DAffine3 {
    let wide = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
    if let Some(m) = &node.matrix {
        let column = |k: usize| wide([m[4 * k], m[4 * k + 1], m[4 * k + 2]]);
        return DAffine3 { matrix3: DMat3::from_cols(column(0), column(1), column(2)), translation: column(3) };
    }
    let q = DQuat::from_array(node.rotation.unwrap_or_default().0.map(f64::from));
    let own = if q.length_squared() > 0.0 { q.normalize() } else { DQuat::IDENTITY };
    let (t, r, s) = keys.map_or((None, None, None), |k| (k.translation, k.rotation, k.scale));
    DAffine3::from_scale_rotation_translation(
        s.unwrap_or_else(|| node.scale.map_or(DVec3::ONE, wide)),
        r.unwrap_or(own),
        t.unwrap_or_else(|| node.translation.map_or(DVec3::ZERO, wide)),
    )
}
