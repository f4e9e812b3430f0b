//! The tree of nodes → objects, lamps and the camera in world space. Source: glTF 2.0, section 3.5.

use super::super::{ImportError, ImportOptions, Imported};
use super::Document;
use super::animation;
use super::camera::camera;
use super::instancing::instances;
use super::light::{Units, light};
use super::material::{Cover, covers, wanted_images};
use super::mesh::{Budget, Form, MAX_VERTICES, Wanted, triangles};
use super::pose::{Pose, Tree};
use super::rayloom::{self, Extension, NodeTraits};
use super::skin::joints;
use crate::diag::Sink;
use crate::math::{DAffine3, Transform};
use crate::scene::object::PathTraits;
use crate::scene::{Mesh, Object, Scene, Shape};
use ::gltf::json;
use std::collections::HashMap;
use std::sync::Arc;

/// Steps of an animation over the shutter: what turns between two of them is followed along the chord.
const SHUTTER_STEPS: usize = 5;
/// Most placed primitives: few nodes and few meshes of many primitives multiply.
pub(super) const MAX_INSTANCES: usize = 1 << 24;

/// A primitive ready to be placed: its triangles, shared by all nodes that show it.
struct Part {
    mesh: Arc<Mesh>,
    material: usize,
}

/// Meshes made so far, by index, skin, and morph weights of all steps of the node that showed them.
type Parts = HashMap<(usize, Option<usize>, Vec<u32>), Arc<[Part]>>;

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
    /// Where nodes are.
    pose: Pose,
    /// The same at evenly spaced times over the shutter, if something is animated meanwhile.
    steps: Vec<Pose>,
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
    let wanted = wanted_images(doc, !all_replaced, options.savings);
    scene.unread.pictures = [wanted.iter().filter(|w| !**w).count(), wanted.len()];
    let mut covers = covers(doc, &wanted, sink)?;
    if let Some(e) = &mut extension {
        rayloom::shaders(e, &mut covers, sink)?;
    }
    let budget = Budget { left: MAX_VERTICES };
    if doc.root.scenes.len() > 1 {
        sink.note_once("gltf: scenes", None, format!("the file has {} scenes; one is shown", doc.root.scenes.len()));
    }
    let tree = Tree::new(doc)?;
    let clip = animation::chosen(doc, options, sink)?;
    scene.animations = animation::list(doc);
    // The root that turns Blender's axes to glTF's is left out: the scene stays in Blender's.
    let still = extension.as_ref().map(|e| e.root);
    let now = options.time.unwrap_or(0.0);
    let pose = |seconds: f64| Pose::new(doc, &tree, clip.as_ref().map(|c| (c, seconds)), still);
    let times = extension.as_ref().filter(|_| clip.is_some()).map_or_else(Vec::new, |e| e.shutter.times(SHUTTER_STEPS));
    let steps = times.into_iter().map(|t| pose(now + t / options.fps)).collect::<Result<Vec<_>, _>>()?;
    let pose = pose(now)?;
    let mut b =
        Builder { doc, options, units, covers, parts: Parts::new(), budget, scene, has_camera: false, extension, pose, steps, sink };
    for (ix, _) in &tree.order {
        b.node(*ix, &doc.root.nodes[*ix])?;
    }
    Ok(Imported { scene: b.scene, has_camera: b.has_camera })
}

impl Builder<'_> {
    fn node(&mut self, ix: usize, node: &json::Node) -> Result<(), ImportError> {
        let world = &self.pose.world(ix).expect("the tree's nodes have places");
        let others = node.extensions.as_ref().map(|e| &e.others);
        let instances = instances(self.doc, ix, node, self.options.memory, self.sink)?;
        let n_places = instances.as_ref().map_or(1, Vec::len);
        let traits = match (&self.extension, rayloom::part(others)) {
            (Some(e), Some(value)) => e.node(ix, value, n_places, self.sink)?,
            _ => NodeTraits::default(),
        };
        let animated = self.animated(ix);
        // Of the node itself; that of instances is theirs alone.
        let motion: &[DAffine3] = if instances.is_none() && !traits.motion.is_empty() { &traits.motion } else { &animated };
        if let Some(mesh) = node.mesh {
            let parts = self.parts(ix, mesh.value(), node)?;
            let covered: Vec<_> = parts.iter().map(|p| (Shape::Mesh(p.mesh.clone()), self.covers[p.material].clone())).collect();
            match &instances {
                // A skin takes vertices to the world, wherever its node is.
                _ if node.skin.is_some() => self.place(ix, node, &[DAffine3::IDENTITY], &traits, &[], &covered)?,
                None => self.place(ix, node, &[*world], &traits, motion, &covered)?,
                Some(own) => {
                    let places: Vec<DAffine3> = own.iter().map(|m| *world * *m).collect();
                    let moved: Vec<DAffine3> = own.iter().flat_map(|m| animated.iter().map(move |w| *w * *m)).collect();
                    let motion = if traits.motion.is_empty() { &moved } else { &traits.motion };
                    self.place(ix, node, &places, &traits, motion, &covered)?;
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

    /// The world matrices of a node over the shutter; empty where it stands still.
    fn animated(&self, ix: usize) -> Vec<DAffine3> {
        let all: Vec<DAffine3> = self.steps.iter().filter_map(|p| p.world(ix)).collect();
        if all.windows(2).all(|w| w[0] == w[1]) { Vec::new() } else { all }
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

    /// The primitives of a mesh as a node shows it, made once for each skin and set of morph weights.
    fn parts(&mut self, node_ix: usize, mesh_ix: usize, node: &json::Node) -> Result<Arc<[Part]>, ImportError> {
        let doc = self.doc;
        let mesh = doc.get(&doc.root.meshes, mesh_ix, "mesh", || "a node".into())?;
        let own = node.weights.as_deref().or(mesh.weights.as_deref()).unwrap_or(&[]);
        let poses: Vec<&Pose> = std::iter::once(&self.pose).chain(&self.steps).collect();
        let weights: Vec<&[f32]> = poses.iter().map(|p| p.weights(node_ix).unwrap_or(own)).collect();
        let skin = node.skin.map(|s| s.value());
        let key = (mesh_ix, skin, weights.iter().flat_map(|w| w.iter().map(|w| w.to_bits())).collect());
        if let Some(parts) = self.parts.get(&key) {
            return Ok(parts.clone());
        }
        let here = || format!("node {node_ix}");
        let joints = match skin {
            Some(skin) => poses.iter().map(|p| joints(doc, skin, p, &here).map(Some)).collect::<Result<Vec<_>, _>>()?,
            None => vec![None; poses.len()],
        };
        let forms: Vec<Form> = weights.iter().zip(&joints).map(|(weights, j)| Form { weights, joints: j.as_deref() }).collect();
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
            let (uv_set, all_uvs) = (cover.uv_set, cover.all_uvs);
            let wanted = Wanted { uv_set, all_uvs, form: forms[0], steps: &forms[1..], extension: self.extension.as_ref() };
            if let Some(mesh) = triangles(doc, primitive, &place, &wanted, &mut self.budget, self.sink)? {
                list.push(Part { mesh: Arc::new(mesh), material });
            }
        }
        let parts: Arc<[Part]> = list.into();
        self.parts.insert(key, parts.clone());
        Ok(parts)
    }
}
