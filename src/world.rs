//! The outside as a scene sees it: files found along search paths, files written, the clock. A trait, so that tests run in memory.

use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Why a file could not be had.
#[derive(Debug, thiserror::Error)]
pub enum WorldError {
    /// No file of that name in the current folder or along the library paths.
    #[error("cannot find file '{0}'")]
    NotFound(String),
    /// The operating system said no.
    #[error("cannot {verb} '{}': {source}", path.display())]
    Io {
        /// "read", "write", "create".
        verb: &'static str,
        /// Which file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// Larger than a front end accepts.
    #[error("'{}' has {size} bytes, more than the limit of {limit}", path.display())]
    TooLarge {
        /// Which file.
        path: PathBuf,
        /// Its size in bytes.
        size: u64,
        /// The limit in bytes.
        limit: u64,
    },
    /// Outside the folders that a scene may write to.
    #[error("'{}' is outside the folders that a scene may {verb} (more are allowed by --allow-io DIR, or Allow_IO=DIR)", path.display())]
    Forbidden {
        /// "read" or "write".
        verb: &'static str,
        /// Which file.
        path: PathBuf,
    },
}

/// Where a front end gets its files and the time.
pub trait World {
    /// The path of `name`: absolute, or in the current folder, or along the library paths, in that order.
    /// Each of `extensions` is tried appended when the bare name is not found (or before it, for names without one).
    fn find(&self, name: &str, extensions: &[&str]) -> Option<PathBuf>;
    /// A whole file.
    fn read(&self, path: &Path) -> Result<Arc<[u8]>, WorldError>;
    /// A whole file that a scene opens by `#fopen`, which is not free to read everywhere.
    fn read_user_file(&self, path: &Path) -> Result<Arc<[u8]>, WorldError> {
        self.read(path)
    }
    /// Replaces or appends to a file that a scene writes (`#fopen ... write`).
    fn write(&self, path: &Path, bytes: &[u8], append: bool) -> Result<(), WorldError>;
    /// Seconds since 2000-01-01 00:00:00 UTC.
    fn now_seconds(&self) -> f64;
}

/// Files larger than this are refused: spans hold 32-bit offsets.
pub const MAX_FILE_SIZE: u64 = u32::MAX as u64 - 1;

/// The real file system.
#[derive(Debug, Default)]
pub struct DiskWorld {
    /// The folder that relative names start from.
    pub current_dir: PathBuf,
    /// Searched in order after the current folder.
    pub library_paths: Vec<PathBuf>,
    /// Folders that `#fopen` may write to, and read from besides the library paths; empty: everywhere.
    pub io_folders: Vec<PathBuf>,
}

impl DiskWorld {
    /// Whether `path` lies in one of `folders`, links followed. A file that does not exist lies where its folder is.
    fn lies_in<'f>(path: &Path, mut folders: impl Iterator<Item = &'f PathBuf>) -> bool {
        let parent = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let place = path.canonicalize().or_else(|_| parent.canonicalize());
        let real = |f: &PathBuf| if f.as_os_str().is_empty() { Path::new(".").canonicalize() } else { f.canonicalize() };
        place.is_ok_and(|p| folders.any(|f| real(f).is_ok_and(|f| p.starts_with(f))))
    }
}

impl World for DiskWorld {
    fn find(&self, name: &str, extensions: &[&str]) -> Option<PathBuf> {
        let lower = name.to_ascii_lowercase();
        let has_known = extensions.iter().any(|e| lower.ends_with(&e.to_ascii_lowercase()));
        let mut names: Vec<String> = extensions.iter().map(|e| format!("{name}{e}")).collect();
        if has_known {
            names.insert(0, name.to_owned());
        } else {
            names.push(name.to_owned());
        }
        let dirs = std::iter::once(&self.current_dir).chain(&self.library_paths);
        for dir in dirs {
            for n in &names {
                let p = dir.join(n);
                if p.is_file() {
                    return Some(p);
                }
            }
        }
        None
    }

    fn read(&self, path: &Path) -> Result<Arc<[u8]>, WorldError> {
        let io = |source| WorldError::Io { verb: "read", path: path.to_owned(), source };
        let size = std::fs::metadata(path).map_err(io)?.len();
        if size > MAX_FILE_SIZE {
            return Err(WorldError::TooLarge { path: path.to_owned(), size, limit: MAX_FILE_SIZE });
        }
        Ok(std::fs::read(path).map_err(io)?.into())
    }

    fn read_user_file(&self, path: &Path) -> Result<Arc<[u8]>, WorldError> {
        if !self.io_folders.is_empty() && !Self::lies_in(path, self.io_folders.iter().chain(&self.library_paths)) {
            return Err(WorldError::Forbidden { verb: "read", path: path.to_owned() });
        }
        self.read(path)
    }

    fn write(&self, path: &Path, bytes: &[u8], append: bool) -> Result<(), WorldError> {
        use std::io::Write;
        if !self.io_folders.is_empty() && !Self::lies_in(path, self.io_folders.iter()) {
            return Err(WorldError::Forbidden { verb: "write", path: path.to_owned() });
        }
        let io = |source| WorldError::Io { verb: "write", path: path.to_owned(), source };
        let mut f = std::fs::OpenOptions::new().create(true).append(append).truncate(!append).write(true).open(path).map_err(io)?;
        f.write_all(bytes).map_err(io)
    }

    fn now_seconds(&self) -> f64 {
        // 946,684,800 s lie between 1970-01-01 and 2000-01-01.
        std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).map_or(0.0, |d| d.as_secs_f64() - 946_684_800.0)
    }
}
