//! The tree of nodes → objects, lamps and the camera in world space. Source: glTF 2.0, section 3.5.

use super::super::{ImportError, ImportOptions, Imported};
use super::Document;
use super::camera::camera;
use super::instancing::instances;
use super::light::{Units, light};
use super::material::{Cover, covers};
use super::mesh::{Budget, MAX_VERTICES, Wanted, triangles};
use super::rayloom::{self, Extension, NodeTraits};
use crate::diag::Sink;
use crate::math::{DAffine3, DMat3, DVec3, Transform};
use crate::scene::object::PathTraits;
use crate::scene::{Mesh, Object, Scene, Shape};
use ::gltf::json;
use glam::DQuat;
use std::collections::HashMap;
use std::sync::Arc;

/// Deepest nesting of nodes. Rigs reach some tens; Blender's own limit of parents is lower.
const MAX_DEPTH: usize = 1000;
/// Most placed primitives: few nodes and few meshes of many primitives multiply.
pub(super) const MAX_INSTANCES: usize = 1 << 24;

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
    /// What Blender's exporter says besides.
    extension: Option<Extension<'a>>,
    sink: &'a mut Sink,
}

/// The file's scene: its default one, else its first, else all nodes without a parent.
pub(super) fn scene(doc: &Document, options: &ImportOptions, sink: &mut Sink) -> Result<Imported, ImportError> {
    let mut scene = Scene::default();
    let mut extension = rayloom::extension(doc, &mut scene, sink)?;
    // With the extension lamps say their watts; glTF's own are not asked.
    let generator = doc.root.asset.generator.as_deref().filter(|_| extension.is_none());
    let units = Units::of(generator, options.lumens_per_watt, sink);
    let covered = |m: &json::Material| rayloom::part(m.extensions.as_ref().map(|e| &e.others)).is_some();
    let all_replaced = extension.is_some() && doc.root.materials.iter().all(covered);
    let mut covers = covers(doc, !all_replaced, sink)?;
    if let Some(e) = &mut extension {
        rayloom::shaders(e, &mut covers, sink)?;
    }
    let budget = Budget { left: MAX_VERTICES };
    if doc.root.scenes.len() > 1 {
        sink.note_once("gltf: scenes", None, format!("the file has {} scenes; one is shown", doc.root.scenes.len()));
    }
    let mut b = Builder { doc, options, units, covers, parts: Parts::new(), budget, scene, has_camera: false, extension, sink };
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
            // The root that turns Blender's axes to glTF's is left out: the scene stays in Blender's.
            let turns_axes = self.extension.as_ref().is_some_and(|e| e.root == ix);
            let world = if turns_axes { parent } else { parent * local(node) };
            if !world.is_finite() {
                return Err(doc.invalid(format!("node {ix}"), "its transform is not finite"));
            }
            self.node(ix, node, &world)?;
            waiting.extend(node.children.iter().flatten().rev().map(|c| (c.value(), world, depth + 1)));
        }
        Ok(())
    }

    fn node(&mut self, ix: usize, node: &json::Node, world: &DAffine3) -> Result<(), ImportError> {
        let others = node.extensions.as_ref().map(|e| &e.others);
        let instances = instances(self.doc, ix, node, self.sink)?;
        let n_places = instances.as_ref().map_or(1, Vec::len);
        let traits = match (&self.extension, rayloom::part(others)) {
            (Some(e), Some(value)) => e.node(ix, value, n_places, self.sink)?,
            _ => NodeTraits::default(),
        };
        // Of the node itself; that of instances is theirs alone.
        let motion: &[DAffine3] = if instances.is_none() { &traits.motion } else { &[] };
        if let Some(mesh) = node.mesh {
            if node.skin.is_some() {
                self.sink.note_once("gltf: skins", None, "skins are left out; meshes stand in their bind pose");
            }
            let parts = self.parts(mesh.value(), node.weights.as_deref())?;
            let covered: Vec<_> = parts.iter().map(|p| (Shape::Mesh(p.mesh.clone()), self.covers[p.material].clone())).collect();
            match &instances {
                None => self.place(ix, node, &[*world], &traits, motion, &covered)?,
                Some(own) => {
                    let places: Vec<DAffine3> = own.iter().map(|m| *world * *m).collect();
                    self.place(ix, node, &places, &traits, &traits.motion, &covered)?;
                }
            }
        }
        if let (Some(e), Some(k)) = (&mut self.extension, traits.curves) {
            let (curves, material) = e.curves(k, self.sink)?;
            let cover = &self.covers[material.unwrap_or(self.covers.len() - 1)];
            self.place(ix, node, &[*world], &traits, motion, &[(Shape::Curves(curves), cover.clone())])?;
        }
        if let (Some(e), Some(k)) = (&self.extension, traits.light) {
            self.scene.lights.extend(e.light(k, world, traits.visibility, self.sink)?);
        } else if let Some(l) = node.extensions.as_ref().and_then(|e| e.khr_lights_punctual.as_ref()) {
            self.scene.lights.push(light(self.doc, l.light.value(), world, self.units)?);
        }
        if let Some(c) = node.camera {
            self.camera(ix, c.value(), world, motion)?;
        }
        Ok(())
    }

    fn camera(&mut self, node: usize, ix: usize, world: &DAffine3, motion: &[DAffine3]) -> Result<(), ImportError> {
        let active = self.extension.as_ref().and_then(|e| e.camera);
        if self.has_camera || active.is_some_and(|a| a != node) {
            if active.is_none() {
                self.sink.note_once("gltf: cameras", None, "the file has several cameras; the first one is used");
            }
            return Ok(());
        }
        let own = match &self.extension {
            Some(e) => rayloom::camera(self.doc, ix, world, self.options.aspect * e.pixel_aspect, self.sink)?,
            None => None,
        };
        self.scene.camera = match own {
            Some(camera) => camera,
            None => camera(self.doc, ix, world, self.options.aspect)?,
        };
        self.scene.camera.motion = rayloom::camera_motion(&self.scene.camera, world, motion);
        self.has_camera = true;
        Ok(())
    }

    /// Puts shapes where a node is, or its instances are; `motion` has as many matrices for each of the places, or none.
    fn place(
        &mut self,
        node_ix: usize,
        node: &json::Node,
        places: &[DAffine3],
        traits: &NodeTraits,
        motion: &[DAffine3],
        shapes: &[(Shape, Cover)],
    ) -> Result<(), ImportError> {
        let n = places.len().saturating_mul(shapes.len());
        if n > MAX_INSTANCES - self.scene.objects.len().min(MAX_INSTANCES) {
            return Err(ImportError::TooMany { path: self.doc.path.to_owned(), what: "placed primitives", limit: MAX_INSTANCES });
        }
        if n > 1 {
            // Few bytes of a file may place many.
            self.options.memory.allows((n * size_of::<Object>()) as u64)?;
        }
        let path_traits = PathTraits {
            visibility: traits.visibility,
            holdout: traits.holdout,
            shadow_catcher: traits.shadow_catcher,
            object_id: traits.pass_index,
            name: traits.object_name.as_deref().or(node.name.as_deref()).unwrap_or_default().into(),
            asset: traits.asset_name.as_deref().unwrap_or_default().into(),
            ..PathTraits::default()
        };
        let n_steps = motion.len() / places.len().max(1);
        for (k, world) in places.iter().enumerate() {
            let Some(transform) = Transform::from_affine(*world).filter(|_| world.matrix3.determinant() != 0.0) else {
                let name = node.name.as_deref().unwrap_or("without a name");
                let message = format!("node {node_ix} ({name}) is squeezed flat by its scale and left out");
                self.sink.note_once("gltf: flat nodes", None, message);
                continue;
            };
            let motion = rayloom::object_motion(&motion[k * n_steps..(k + 1) * n_steps]);
            let traits = PathTraits { motion, ..path_traits.clone() };
            self.scene.objects.extend(shapes.iter().map(|(shape, cover)| Object {
                transform,
                texture: Some(cover.texture.clone()),
                interior: cover.interior.clone(),
                traits: traits.clone(),
                ..Object::new(shape.clone())
            }));
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
            let cover = &self.covers[material];
            let wanted = Wanted { uv_set: cover.uv_set, all_uvs: cover.all_uvs, weights, extension: self.extension.as_ref() };
            if let Some(mesh) = triangles(doc, primitive, &place, &wanted, &mut self.budget, self.sink)? {
                list.push(Part { mesh: Arc::new(mesh), material });
            }
        }
        let parts: Arc<[Part]> = list.into();
        self.parts.insert(key, parts.clone());
        Ok(parts)
    }
}
