//! glTF 2.0 and OBJ + MTL files → [`Scene`]. Nothing here knows how a scene is rendered.
//!
//! `gltf/` and `obj/` read the files; `picture.rs` decodes images for both; `framing.rs` adds the camera and the light that a file
//! lacks. What is left out is said through the sink, once a kind; docs/import.md is the users' page.

mod error;
mod files;
mod framing;
mod gltf;
mod obj;
mod picture;

pub use error::ImportError;

use crate::diag::Sink;
use crate::math::Vec3;
use crate::memory::MemoryLimit;
use crate::savings::Savings;
use crate::scene::{Principled, Scene};
use std::path::Path;

/// What the reader must know besides the file.
#[derive(Clone, Debug)]
pub struct ImportOptions {
    /// Width / height of the picture.
    pub aspect: f64,
    /// Luminous units in a radiant one: lamps are divided by it. `None`: 683 lm/W for files that Blender wrote (its exporter
    /// multiplies lamps, and lamps alone, by that), 1 for all others (their lamps and emission have one unit).
    pub lumens_per_watt: Option<f64>,
    /// Moment of the animation, in seconds; `None`: nodes stand as the file places them.
    pub time: Option<f64>,
    /// Frames in a second: the shutter's length counts in frames.
    pub fps: f64,
    /// Which animation, by name or number; `None`: the first.
    pub animation: Option<String>,
    /// What the scene's objects may take.
    pub memory: MemoryLimit,
    /// What to leave out.
    pub savings: Savings,
}

impl Default for ImportOptions {
    fn default() -> Self {
        Self {
            aspect: 4.0 / 3.0,
            lumens_per_watt: None,
            time: None,
            fps: 24.0,
            animation: None,
            memory: MemoryLimit::of_machine(),
            savings: Savings::ALL,
        }
    }
}

/// Most levels of mirrors and glass in a picture of an import; Cycles' default.
const MAX_TRACE_LEVEL: u32 = 12;

/// What kind of file it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    Gltf,
    Obj,
}

/// By extension, then by content.
fn format_of(path: &Path, bytes: &[u8]) -> Option<Format> {
    let extension = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
    match extension.as_deref() {
        Some("glb" | "gltf") => return Some(Format::Gltf),
        Some("obj") => return Some(Format::Obj),
        _ => {}
    }
    let head = &bytes[..bytes.len().min(4096)];
    if head.starts_with(b"glTF") || head.trim_ascii_start().starts_with(b"{") {
        return Some(Format::Gltf);
    }
    let says_obj = |line: &[u8]| [&b"v "[..], b"vn ", b"vt ", b"f ", b"o ", b"g ", b"mtllib "].iter().any(|k| line.starts_with(k));
    (!head.contains(&0) && head.split(|b| *b == b'\n').any(says_obj)).then_some(Format::Obj)
}

/// Reads a .glb, .gltf or .obj (by extension, then by content). Lengths keep the file's unit; axes are the file's: right-handed, y up.
pub fn load(path: &Path, options: &ImportOptions, sink: &mut Sink) -> Result<Scene, ImportError> {
    let bytes = files::read(path)?;
    let mut scene = match format_of(path, &bytes) {
        Some(Format::Gltf) => gltf::load(path, &bytes, options, sink)?,
        Some(Format::Obj) => obj::load(path, &bytes, sink)?,
        None => return Err(ImportError::UnknownFormat(path.to_owned())),
    };
    scene.scene.settings.max_trace_level = MAX_TRACE_LEVEL;
    framing::complete(&mut scene, options, sink);
    Ok(scene.scene)
}

/// What covers surfaces without a material: Blender's plain grey.
fn plain_material() -> Principled {
    Principled { base_color: Vec3::splat(0.8), roughness: 0.5, ..Principled::default() }
}

/// A scene as a file gives it.
struct Imported {
    scene: Scene,
    /// The file has a camera; else the scene's is a stand-in.
    has_camera: bool,
}
