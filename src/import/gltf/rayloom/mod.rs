//! `RAYLOOM_scene`: what Blender has and glTF has not (docs/RAYLOOM_scene.md). The scene comes out in Blender's axes, z up.

mod camera;
mod closure;
mod curves;
mod grid;
mod input;
mod lamp;
mod likeness;
mod material;
mod motion;
mod pictures;
mod record;
mod settings;
mod world;

pub(super) use camera::{camera, camera_motion};
pub(super) use input::place_of_set;
pub(super) use material::shaders;
pub(super) use motion::{object_motion, vertex_motion};
pub(super) use record::Record;

use super::super::ImportError;
use super::Document;
use crate::diag::Sink;
use crate::math::DAffine3;
use crate::scene::curves::CurveStyle;
use crate::scene::{Curves, Light, Scene, Visibility};
use pictures::Pictures;
use serde_json::{Map, Value};
use std::sync::Arc;

/// Its name.
pub(super) const NAME: &str = "RAYLOOM_scene";

/// The extension's record among others.
pub(super) fn part(others: Option<&Map<String, Value>>) -> Option<&Value> {
    others?.get(NAME)
}

/// What the file says as a whole. Lamps, curves and shaders are made when nodes name them.
pub(super) struct Extension<'a> {
    doc: &'a Document<'a>,
    /// The node that turns Blender's axes to glTF's.
    pub root: usize,
    /// The node of the active camera.
    pub camera: Option<usize>,
    lights: Vec<Record<'a>>,
    curves: Vec<Record<'a>>,
    made_curves: Vec<Option<(Arc<Curves>, Option<usize>)>>,
    grids: Vec<Record<'a>>,
    pictures: Pictures<'a>,
    style: CurveStyle,
    /// When the shutter is open.
    pub shutter: motion::Shutter,
    /// Width of a pixel over its height.
    pub pixel_aspect: f64,
}

/// Reads the record of the file; `None` when it has none. Settings and world go into `scene` at once.
pub(super) fn extension<'a>(doc: &'a Document<'a>, scene: &mut Scene, sink: &mut Sink) -> Result<Option<Extension<'a>>, ImportError> {
    let Some(value) = part(doc.root.extensions.as_ref().map(|e| &e.others)) else { return Ok(None) };
    let r = Record::new(doc, value, format!("extensions.{NAME}"))?;
    let version = r.needed("version", r.count("version")?)?;
    if version != 1 {
        return Err(r.wrong("version", format!("it is {version}; version 1 is read")));
    }
    let n_nodes = doc.root.nodes.len();
    let root = r.needed("root", r.index("root", n_nodes, "node")?)?;
    let camera = r.index("camera", n_nodes, "node")?;
    r.text("generator")?;
    for ignored in r.records("ignored")? {
        let (object, what) = (ignored.text("object")?.unwrap_or_default(), ignored.text("what")?.unwrap_or_default());
        sink.note_once(&format!("rayloom: {object}: {what}"), None, format!("{object}: {what}"));
    }
    let curves = r.records("curves")?;
    let mut e = Extension {
        doc,
        root,
        camera,
        lights: r.records("lights")?,
        made_curves: vec![None; curves.len()],
        curves,
        grids: r.records("grids")?,
        pictures: Pictures::new(doc, r.records("images")?)?,
        style: CurveStyle::Ribbon,
        shutter: motion::Shutter::default(),
        pixel_aspect: 1.0,
    };
    if let Some(render) = r.record("render")? {
        let [x, y] = render.numbers::<2>("pixelAspect")?.unwrap_or([1.0; 2]);
        if !(x > 0.0 && y > 0.0) {
            return Err(render.wrong("pixelAspect", "both numbers must be above 0"));
        }
        e.pixel_aspect = x / y;
        (e.style, e.shutter) = settings::settings(&render, scene, sink)?;
    }
    scene.environment = Some(match r.record("world")? {
        Some(world) => world::environment(&mut e, &world, sink)?,
        None => crate::scene::Environment::constant(crate::math::Vec3::ZERO),
    });
    scene.background = world::background(scene.environment.as_ref());
    r.finish()?;
    Ok(Some(e))
}

/// What a node says.
#[derive(Default)]
pub(super) struct NodeTraits {
    pub light: Option<usize>,
    pub curves: Option<usize>,
    pub visibility: Visibility,
    pub holdout: bool,
    pub shadow_catcher: bool,
    pub pass_index: u32,
    /// Names for Cryptomatte; without them the node's name stands for both.
    pub object_name: Option<String>,
    pub asset_name: Option<String>,
    /// World matrices at evenly spaced times over the shutter, those of a node's first instance first; empty: it stands still.
    pub motion: Vec<DAffine3>,
}

impl<'a> Extension<'a> {
    /// The record of node `ix`, which stands in `n_places` places.
    pub fn node(&self, ix: usize, value: &Value, n_places: usize, sink: &mut Sink) -> Result<NodeTraits, ImportError> {
        let r = Record::new(self.doc, value, format!("nodes[{ix}].extensions.{NAME}"))?;
        let motion = match r.record("motion")? {
            Some(m) => motion::matrices(&m, &self.shutter, n_places, sink)?,
            None => Vec::new(),
        };
        let traits = NodeTraits {
            light: r.index("light", self.lights.len(), "light")?,
            curves: r.index("curves", self.curves.len(), "curves")?,
            visibility: visibility(&r)?,
            holdout: r.flag("holdout", false)?,
            shadow_catcher: r.flag("shadowCatcher", false)?,
            pass_index: r.count_or("passIndex", 0)?,
            object_name: r.text("objectName")?.map(str::to_owned),
            asset_name: r.text("assetName")?.map(str::to_owned),
            motion,
        };
        // What nothing reads yet.
        for key in ["random", "color", "materials", "lightLinking", "shadowLinking"] {
            r.get(key);
        }
        r.finish()?;
        Ok(traits)
    }

    /// Lamp `ix` at a place.
    pub fn light(&self, ix: usize, world: &DAffine3, visibility: Visibility, sink: &mut Sink) -> Result<Option<Light>, ImportError> {
        lamp::light(&self.lights[ix], world, visibility, sink)
    }

    /// Hair `ix` with its material, made once.
    pub fn curves(&mut self, ix: usize, sink: &mut Sink) -> Result<(Arc<Curves>, Option<usize>), ImportError> {
        if let Some(made) = &self.made_curves[ix] {
            return Ok(made.clone());
        }
        let made = curves::curves(&self.curves[ix], self.style, &self.shutter, sink)?;
        self.made_curves[ix] = Some(made.clone());
        Ok(made)
    }
}

/// The ray kinds that see a node or the world.
fn visibility(r: &Record) -> Result<Visibility, ImportError> {
    let Some(v) = r.record("visibility")? else { return Ok(Visibility::ALL) };
    let kinds = [
        ("camera", Visibility::CAMERA),
        ("diffuse", Visibility::DIFFUSE),
        ("glossy", Visibility::GLOSSY),
        ("transmission", Visibility::TRANSMISSION),
        ("volumeScatter", Visibility::VOLUME),
        ("shadow", Visibility::SHADOW),
    ];
    let mut out = Visibility::ALL;
    for (key, kind) in kinds {
        if !v.flag(key, true)? {
            out = out.without(kind);
        }
    }
    v.finish()?;
    Ok(out)
}
