//! Where the library may be: what the user says, beside the program, the system's folders.

use super::DenoiseError;
use std::path::{Path, PathBuf};

/// Environment variable that names the library, or the folder that it is in.
pub const ENVIRONMENT: &str = "RAYLOOM_OIDN";

/// What a user can do about a missing library.
pub const HOW_TO_GET: &str = "put libOpenImageDenoise (version 2) beside the program, install it (openimagedenoise.org; `pip install pyoidn` has it; so has \
    every Blender, in its folder `lib`), or name it by --denoise-library FILE or the environment variable RAYLOOM_OIDN; --no-denoise leaves the \
    picture noisy";

/// Its names, by system. Only version 2 has the functions that are called.
const NAMES: &[&str] = if cfg!(target_os = "windows") {
    &["OpenImageDenoise.dll"]
} else if cfg!(target_os = "macos") {
    &["libOpenImageDenoise.2.dylib", "libOpenImageDenoise.dylib"]
} else {
    &["libOpenImageDenoise.so.2", "libOpenImageDenoise.so"]
};

/// Files to try in this order; a name without folder is looked up by the system.
///
/// # Errors
/// What the user named is not there.
pub(super) fn candidates(chosen: Option<&Path>) -> Result<Vec<PathBuf>, DenoiseError> {
    let named = chosen.map(Path::to_owned).or_else(|| std::env::var_os(ENVIRONMENT).filter(|v| !v.is_empty()).map(PathBuf::from));
    if let Some(path) = named {
        return Ok(vec![named_file(&path)?]);
    }
    let program = std::env::current_exe().ok().and_then(|p| p.canonicalize().ok());
    let beside = program.as_deref().and_then(Path::parent).map(folders_beside).unwrap_or_default();
    let files = beside.iter().filter_map(|folder| in_folder(folder));
    Ok(files.chain(NAMES.iter().map(PathBuf::from)).collect())
}

/// The folder of the program, and where installers put libraries.
fn folders_beside(folder: &Path) -> Vec<PathBuf> {
    let mut out = vec![folder.to_owned(), folder.join("lib")];
    out.extend(folder.parent().map(|p| p.join("lib")));
    out
}

/// The file that a user's word means: itself, or the library in that folder.
fn named_file(path: &Path) -> Result<PathBuf, DenoiseError> {
    let found = if path.is_dir() { in_folder(path) } else { path.is_file().then(|| path.to_owned()) };
    found.ok_or_else(|| DenoiseError::Missing { looked: format!(" at '{}'", path.display()) })
}

/// The library in a folder, under its own name or that of one version.
fn in_folder(folder: &Path) -> Option<PathBuf> {
    let plain = NAMES.iter().map(|name| folder.join(name)).find(|p| p.is_file());
    plain.or_else(|| {
        let mut files: Vec<PathBuf> = std::fs::read_dir(folder).ok()?.flatten().map(|e| e.path()).collect();
        files.sort();
        let is_it = |p: &PathBuf| p.file_name().is_some_and(|n| n.to_string_lossy().starts_with(&format!("{}.", NAMES[0])));
        files.into_iter().rev().find(is_it)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_or_a_file_is_taken_and_a_missing_one_is_an_error_that_says_what_to_do() {
        let folder = tempfile::tempdir().expect("a folder");
        let missing = candidates(Some(folder.path())).expect_err("nothing is in it").to_string();
        assert!(missing.contains("install") && missing.contains(&folder.path().display().to_string()), "{missing}");
        let file = folder.path().join(format!("{}.3.9", NAMES[0]));
        std::fs::write(&file, b"x").expect("writable");
        assert_eq!(candidates(Some(folder.path())).expect("it is there"), std::slice::from_ref(&file));
        let plain = folder.path().join(NAMES[0]);
        std::fs::write(&plain, b"x").expect("writable");
        assert_eq!(candidates(Some(folder.path())).expect("it is there"), [plain]);
        assert_eq!(candidates(Some(&file)).expect("it is there"), [file]);
    }
}
