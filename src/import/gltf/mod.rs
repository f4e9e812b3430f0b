//! glTF 2.0 → scene. The `gltf` crate turns JSON into records; every reference, count and offset is checked here, because the
//! crate's own checks index before they look.

mod accessor;
mod animation;
mod bake;
mod camera;
mod container;
mod instancing;
mod khr;
mod light;
mod material;
mod mesh;
mod nodes;
mod pose;
mod rayloom;
mod skin;

use super::files::{self, Target};
use super::{ImportError, ImportOptions, Imported};
use crate::diag::Sink;
use ::gltf::json::Root;
use std::borrow::Cow;
use std::path::Path;

/// Extensions that a file may require.
const SUPPORTED: &[&str] = &[
    instancing::NAME,
    "KHR_lights_punctual",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_dispersion",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_iridescence",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
    rayloom::NAME,
];

/// A file with everything that its records point to.
struct Document<'a> {
    path: &'a Path,
    root: &'a Root,
    buffers: Vec<Cow<'a, [u8]>>,
}

impl Document<'_> {
    /// A broken rule at a place.
    fn invalid(&self, place: impl Into<String>, what: impl Into<String>) -> ImportError {
        ImportError::Invalid { path: self.path.to_owned(), place: place.into(), what: what.into() }
    }

    /// Record `ix` of a table, or an error at `place`.
    fn get<'t, T>(&self, table: &'t [T], ix: usize, what: &str, place: impl Fn() -> String) -> Result<&'t T, ImportError> {
        table.get(ix).ok_or_else(|| self.invalid(place(), format!("it names {what} {ix}, but the file has {}", table.len())))
    }

    /// Bytes of a buffer view.
    fn view(&self, ix: usize, place: impl Fn() -> String) -> Result<&[u8], ImportError> {
        let view = self.get(&self.root.buffer_views, ix, "buffer view", &place)?;
        let buffer = self.get(&self.buffers, view.buffer.value(), "buffer", || format!("buffer view {ix}"))?;
        let (offset, length) = (view.byte_offset.map_or(0, |o| o.0), view.byte_length.0);
        let range = offset.checked_add(length).filter(|end| *end <= buffer.len() as u64);
        let end = range.ok_or_else(|| {
            let what = format!("its bytes {offset} to {offset} + {length} lie outside buffer {} of {}", view.buffer.value(), buffer.len());
            self.invalid(format!("buffer view {ix}"), what)
        })?;
        Ok(&buffer[offset as usize..end as usize])
    }
}

/// Reads a .glb or .gltf.
pub(super) fn load(path: &Path, bytes: &[u8], options: &ImportOptions, sink: &mut Sink) -> Result<Imported, ImportError> {
    let (json, bin) = container::split(path, bytes)?;
    let root = Root::from_slice(json).map_err(|e| ImportError::Damaged { path: path.to_owned(), what: format!("its JSON: {e}") })?;
    if !root.asset.version.starts_with("2.") {
        let what = format!("it is glTF {}; version 2 is read", root.asset.version);
        return Err(ImportError::Damaged { path: path.to_owned(), what });
    }
    if let Some(name) = root.extensions_required.iter().find(|e| !SUPPORTED.contains(&e.as_str())) {
        return Err(ImportError::RequiredExtension { path: path.to_owned(), name: name.clone() });
    }
    // Beside the extension, glTF's own materials and lamps are the fallback that nobody sees.
    let is_fallback = |e: &str| e.starts_with("KHR_materials_") && root.extensions_used.iter().any(|u| u == rayloom::NAME);
    for name in root.extensions_used.iter().filter(|e| !SUPPORTED.contains(&e.as_str()) && !is_fallback(e)) {
        sink.note_once(&format!("gltf: {name}"), None, format!("the glTF extension {name} is left out"));
    }
    if root.extensions_used.iter().any(|e| e == "KHR_materials_variants") {
        sink.note_once("gltf: variants", None, "the file has variants of its materials; the default ones are shown");
    }
    let buffers = buffers(path, &root, bin)?;
    nodes::scene(&Document { path, root: &root, buffers }, options, sink)
}

/// The bytes of every buffer, as many as each claims.
fn buffers<'a>(path: &Path, root: &Root, bin: Option<&'a [u8]>) -> Result<Vec<Cow<'a, [u8]>>, ImportError> {
    let mut out = Vec::with_capacity(root.buffers.len());
    for (ix, buffer) in root.buffers.iter().enumerate() {
        let invalid = |what: String| ImportError::Invalid { path: path.to_owned(), place: format!("buffer {ix}"), what };
        let bytes: Cow<[u8]> = match (&buffer.uri, bin) {
            (Some(uri), _) => match files::resolve(path, uri).map_err(invalid)? {
                Target::Data(data) => data.into(),
                Target::File(file) => files::read(&file)?.into(),
            },
            (None, Some(bin)) if ix == 0 => bin.into(),
            (None, _) => return Err(invalid("it has neither an address nor a binary chunk".into())),
        };
        if (bytes.len() as u64) < buffer.byte_length.0 {
            return Err(invalid(format!("it claims {} bytes, but there are {}", buffer.byte_length.0, bytes.len())));
        }
        out.push(bytes);
    }
    Ok(out)
}
