//! glTF 2.0 and OBJ + MTL files → [`Scene`]. Nothing here knows how a scene is rendered.

use crate::diag::Sink;
use crate::scene::Scene;
use std::path::{Path, PathBuf};

/// What the reader must know besides the file.
#[derive(Clone, Debug)]
pub struct ImportOptions {
    /// Width / height of the picture.
    pub aspect: f64,
}

impl Default for ImportOptions {
    fn default() -> Self {
        Self { aspect: 4.0 / 3.0 }
    }
}

/// Why a file could not become a scene.
#[derive(Debug, thiserror::Error)]
pub enum ImportError {
    /// Neither the name nor the content says what kind of file it is.
    #[error("'{}' is neither glTF nor OBJ", .0.display())]
    UnknownFormat(PathBuf),
}

/// Reads a .glb, .gltf or .obj (by extension, then by content).
pub fn load(path: &Path, _options: &ImportOptions, _sink: &mut Sink) -> Result<Scene, ImportError> {
    Err(ImportError::UnknownFormat(path.to_owned()))
}
