//! `EXT_mesh_gpu_instancing`: one node that shows its mesh many times. Source: the extension's page in the glTF registry.

use super::super::ImportError;
use super::Document;
use super::accessor::Accessor;
use super::nodes::MAX_INSTANCES;
use crate::diag::Sink;
use crate::math::{DAffine3, DVec3};
use crate::memory::MemoryLimit;
use ::gltf::json;
use glam::DQuat;
use serde_json::Value;

/// Its name.
pub(super) const NAME: &str = "EXT_mesh_gpu_instancing";

/// The transforms of node `ix`'s instances, in its own space; `None` when it has not the extension.
pub(super) fn instances(
    doc: &Document,
    ix: usize,
    node: &json::Node,
    memory: MemoryLimit,
    sink: &mut Sink,
) -> Result<Option<Vec<DAffine3>>, ImportError> {
    let Some(value) = node.extensions.as_ref().and_then(|e| e.others.get(NAME)) else { return Ok(None) };
    let place = || format!("node {ix}, {NAME}");
    let Some(attributes) = value.get("attributes").and_then(Value::as_object) else {
        return Err(doc.invalid(place(), "it has no attributes"));
    };
    let attribute = |name: &str, width: usize| -> Result<Option<Accessor>, ImportError> {
        let Some(v) = attributes.get(name) else { return Ok(None) };
        let accessor = Value::as_u64(v).ok_or_else(|| doc.invalid(place(), format!("its {name} is no index")))?;
        let accessor = usize::try_from(accessor).unwrap_or(usize::MAX);
        Accessor::new(doc, accessor, &[width], || format!("{}: {name}", place())).map(Some)
    };
    let (translation, rotation, scale) = (attribute("TRANSLATION", 3)?, attribute("ROTATION", 4)?, attribute("SCALE", 3)?);
    // `_RANDOM` is what RAYLOOM_scene's `random` is for a node alone, and nothing reads that yet.
    for name in attributes.keys().filter(|n| !matches!(n.as_str(), "TRANSLATION" | "ROTATION" | "SCALE" | "_RANDOM")) {
        sink.note_once(&format!("gltf: instances {name}"), None, format!("the attribute {name} of {NAME} is left out"));
    }
    let counts: Vec<usize> = [&translation, &rotation, &scale].into_iter().flatten().map(|a| a.count).collect();
    let Some(n) = counts.first().copied() else { return Err(doc.invalid(place(), "it has neither TRANSLATION, ROTATION nor SCALE")) };
    if counts.iter().any(|c| *c != n) {
        return Err(doc.invalid(place(), format!("its attributes have {counts:?} elements")));
    }
    if n > MAX_INSTANCES {
        return Err(ImportError::TooMany { path: doc.path.to_owned(), what: "placed primitives", limit: MAX_INSTANCES });
    }
    // Here and in the world.
    memory.allows((2 * n * size_of::<DAffine3>()) as u64)?;
    let wide =
        |a: &Option<Accessor>, k: usize, rest: DVec3| a.as_ref().map_or(rest, |a| DVec3::from_array(a.floats::<3>(k, 0.0).map(f64::from)));
    let instance = |k: usize| {
        let q = rotation.as_ref().map_or(DQuat::IDENTITY, |a| DQuat::from_array(a.floats::<4>(k, 0.0).map(f64::from)));
        // Quaternions of bytes are unit to 1/100 only. No direction at all is no turn, one that is not finite stays so.
        let q = if q.length_squared() == 0.0 { DQuat::IDENTITY } else { q.normalize() };
        DAffine3::from_scale_rotation_translation(wide(&scale, k, DVec3::ONE), q, wide(&translation, k, DVec3::ZERO))
    };
    let out: Vec<DAffine3> = (0..n).map(instance).collect();
    match out.iter().position(|m| !m.is_finite()) {
        Some(k) => Err(doc.invalid(place(), format!("the transform of instance {k} is not finite"))),
        None => Ok(Some(out)),
    }
}
