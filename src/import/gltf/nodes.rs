//! The tree of nodes → objects, lamps and the camera in world space. Source: glTF 2.0, section 3.5.

use super::super::{ImportError, ImportOptions, Imported};
use super::Document;
use super::camera::camera;
use super::light::{Units, light};
use super::material::{Cover, covers};
use super::mesh::{Budget, MAX_VERTICES, triangles};
use crate::diag::Sink;
use crate::math::{DAffine3, DMat3, DVec3, Transform};
use crate::scene::{Mesh, Object, Scene, Shape};
use ::gltf::json;
use glam::DQuat;
use std::collections::HashMap;
use std::sync::Arc;

/// Deepest nesting of nodes. Rigs reach some tens; Blender's own limit of parents is lower.
const MAX_DEPTH: usize = 1000;
/// Most placed primitives: few nodes and few meshes of many primitives multiply.
const MAX_INSTANCES: usize = 1 << 24;

/// A primitive ready to be placed: its triangles, shared by all nodes that show it.
struct Part {
    mesh: Arc<Mesh>,
    material: usize,
}

/// Meshes made so far, by index and morph weights of the node that showed them.
type Parts = HashMap<(usize, Vec<u32>), Arc<[Part]>>;

struct Builder<'a> {
    doc: &'a Document<'a>,
    options: &'a ImportOptions,
    units: Units,
    covers: Vec<Cover>,
    parts: Parts,
    budget: Budget,
    scene: Scene,
    has_camera: bool,
    sink: &'a mut Sink,
}

/// The file's scene: its default one, else its first, else all nodes without a parent.
pub(super) fn scene(doc: &Document, options: &ImportOptions, sink: &mut Sink) -> Result<Imported, ImportError> {
    let units = Units::of(doc.root.asset.generator.as_deref(), options.lumens_per_watt, sink);
    let covers = covers(doc, sink)?;
    let budget = Budget { left: MAX_VERTICES };
    if doc.root.scenes.len() > 1 {
        sink.note_once("gltf: scenes", None, format!("the file has {} scenes; one is shown", doc.root.scenes.len()));
    }
    let mut b = Builder { doc, options, units, covers, parts: Parts::new(), budget, scene: Scene::default(), has_camera: false, sink };
    b.walk(roots(doc)?)?;
    Ok(Imported { scene: b.scene, has_camera: b.has_camera })
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

/// The node's own transform.
fn local(node: &json::Node) -> DAffine3 {
    let wide = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
    if let Some(m) = &node.matrix {
        let column = |k: usize| wide([m[4 * k], m[4 * k + 1], m[4 * k + 2]]);
        return DAffine3 { matrix3: DMat3::from_cols(column(0), column(1), column(2)), translation: column(3) };
    }
    let q = DQuat::from_array(node.rotation.unwrap_or_default().0.map(f64::from));
    let rotation = if q.length_squared() > 0.0 { q.normalize() } else { DQuat::IDENTITY };
    DAffine3::from_scale_rotation_translation(node.scale.map_or(DVec3::ONE, wide), rotation, node.translation.map_or(DVec3::ZERO, wide))
}

impl Builder<'_> {
    fn walk(&mut self, roots: Vec<usize>) -> Result<(), ImportError> {
        let doc = self.doc;
        let path = || doc.path.to_owned();
        let mut reached = vec![false; doc.root.nodes.len()];
        let mut waiting: Vec<(usize, DAffine3, usize)> = roots.into_iter().rev().map(|n| (n, DAffine3::IDENTITY, 1)).collect();
        while let Some((ix, parent, depth)) = waiting.pop() {
            let node = doc.get(&doc.root.nodes, ix, "node", || "the tree of nodes".into())?;
            if std::mem::replace(&mut reached[ix], true) {
                return Err(ImportError::NodeReachedTwice { path: path(), node: ix });
            }
            if depth > MAX_DEPTH {
                return Err(ImportError::TooDeep { path: path(), node: ix, limit: MAX_DEPTH });
            }
            let world = parent * local(node);
            if !world.is_finite() {
                return Err(doc.invalid(format!("node {ix}"), "its transform is not finite"));
            }
            self.node(ix, node, &world)?;
            waiting.extend(node.children.iter().flatten().rev().map(|c| (c.value(), world, depth + 1)));
        }
        Ok(())
    }

    fn node(&mut self, ix: usize, node: &json::Node, world: &DAffine3) -> Result<(), ImportError> {
        if let Some(mesh) = node.mesh {
            if node.skin.is_some() {
                self.sink.note_once("gltf: skins", None, "skins are left out; meshes stand in their bind pose");
            }
            self.instance(ix, mesh.value(), node, world)?;
        }
        if let Some(l) = node.extensions.as_ref().and_then(|e| e.khr_lights_punctual.as_ref()) {
            self.scene.lights.push(light(self.doc, l.light.value(), world, self.units)?);
        }
        if let Some(c) = node.camera {
            if self.has_camera {
                self.sink.note_once("gltf: cameras", None, "the file has several cameras; the first one is used");
            } else {
                self.scene.camera = camera(self.doc, c.value(), world, self.options.aspect)?;
                self.has_camera = true;
            }
        }
        Ok(())
    }

    fn instance(&mut self, node_ix: usize, mesh_ix: usize, node: &json::Node, world: &DAffine3) -> Result<(), ImportError> {
        let Some(transform) = Transform::from_affine(*world).filter(|_| world.matrix3.determinant() != 0.0) else {
            let name = node.name.as_deref().unwrap_or("without a name");
            let message = format!("node {node_ix} ({name}) is squeezed flat by its scale and left out");
            self.sink.note_once("gltf: flat nodes", None, message);
            return Ok(());
        };
        let parts = self.parts(mesh_ix, node.weights.as_deref())?;
        if self.scene.objects.len() + parts.len() > MAX_INSTANCES {
            return Err(ImportError::TooMany { path: self.doc.path.to_owned(), what: "placed primitives", limit: MAX_INSTANCES });
        }
        for part in &*parts {
            let cover = &self.covers[part.material];
            self.scene.objects.push(Object {
                transform,
                texture: Some(cover.texture.clone()),
                interior: cover.interior.clone(),
                ..Object::new(Shape::Mesh(part.mesh.clone()))
            });
        }
        Ok(())
    }

    /// The primitives of a mesh, made once for each set of morph weights.
    fn parts(&mut self, mesh_ix: usize, weights: Option<&[f32]>) -> Result<Arc<[Part]>, ImportError> {
        let doc = self.doc;
        let mesh = doc.get(&doc.root.meshes, mesh_ix, "mesh", || "a node".into())?;
        let weights = weights.or(mesh.weights.as_deref()).unwrap_or(&[]);
        let key = (mesh_ix, weights.iter().map(|w| w.to_bits()).collect());
        if let Some(parts) = self.parts.get(&key) {
            return Ok(parts.clone());
        }
        let mut list = Vec::with_capacity(mesh.primitives.len());
        for (k, primitive) in mesh.primitives.iter().enumerate() {
            let place = || match &mesh.name {
                Some(name) => format!("mesh '{name}', primitive {k}"),
                None => format!("mesh {mesh_ix}, primitive {k}"),
            };
            let n_materials = doc.root.materials.len();
            let material = primitive.material.map_or(n_materials, |m| m.value());
            if material > n_materials || (material == n_materials && primitive.material.is_some()) {
                return Err(doc.invalid(place(), format!("it names material {material}, but the file has {n_materials}")));
            }
            if primitive.material.is_none() {
                self.sink.note_once("gltf: no material", None, "surfaces without a material are plain grey");
            }
            let uv_set = self.covers[material].uv_set;
            if let Some(mesh) = triangles(doc, primitive, &place, uv_set, weights, &mut self.budget, self.sink)? {
                list.push(Part { mesh: Arc::new(mesh), material });
            }
        }
        let parts: Arc<[Part]> = list.into();
        self.parts.insert(key, parts.clone());
        Ok(parts)
    }
}
