//! Why a suite cannot be run.

use std::path::{Path, PathBuf};

/// Why a suite cannot be run.
#[derive(Debug, thiserror::Error)]
pub enum SuiteError {
    /// A file or folder cannot be read or written.
    #[error("cannot {verb} '{}': {source}", path.display())]
    Io {
        /// "read", "write".
        verb: &'static str,
        /// Which.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// A `suite.toml` or `test.toml` is wrong.
    #[error("{}: {message}", path.display())]
    Spec {
        /// Which.
        path: PathBuf,
        /// What is wrong, with its line where one is known.
        message: String,
    },
    /// The request does not fit the suite.
    #[error("{0}")]
    Request(String),
}

impl SuiteError {
    pub(super) fn io(verb: &'static str, path: &Path) -> impl FnOnce(std::io::Error) -> Self + use<> {
        let path = path.to_owned();
        move |source| Self::Io { verb, path, source }
    }

    pub(super) fn spec(path: &Path, message: impl Into<String>) -> Self {
        Self::Spec { path: path.to_owned(), message: message.into() }
    }
}
