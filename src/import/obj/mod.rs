//! OBJ + MTL → scene.

use super::{ImportError, Imported};
use crate::diag::Sink;
use std::path::Path;

/// Reads an .obj.
pub(super) fn load(path: &Path, _bytes: &[u8], _sink: &mut Sink) -> Result<Imported, ImportError> {
    Err(ImportError::UnknownFormat(path.to_owned()))
}
