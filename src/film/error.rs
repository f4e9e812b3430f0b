//! What can go wrong between a film and its file.

use std::path::{Path, PathBuf};

/// Why a picture or a state could not be written or read.
#[derive(Debug, thiserror::Error)]
pub enum FilmError {
    /// The disk or the folder said no.
    #[error("cannot {verb} {}: {source}", path.display())]
    Io {
        /// "write", "read", "create".
        verb: &'static str,
        /// Which file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// The picture does not fit the format: too many columns, a size of 0.
    #[error("the picture cannot be written as {format}: {reason}")]
    Unfit {
        /// "PNG".
        format: &'static str,
        /// What does not fit.
        reason: String,
    },
    /// A file that was to be read is no such file, is cut off, or belongs to another job.
    #[error("{}: {reason}", path.display())]
    Foreign {
        /// Which file.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
}

impl FilmError {
    /// An error of the system about a file.
    pub fn io(verb: &'static str, path: &Path, source: std::io::Error) -> Self {
        Self::Io { verb, path: path.to_owned(), source }
    }
}
