//! A film into its file: beside it first, then renamed, so that the old file survives whatever goes wrong.

use super::{Encoding, FileFormat, Film, FilmError, exr_file, hdr_file, png_file, simple_files};
use std::io::Write;
use std::path::Path;

/// The entry of [`Metadata`] that says how the colours were denoised.
pub const DENOISED: &str = "denoised";

/// What a file says about its picture.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Metadata {
    /// "rayloom 0.1.0".
    pub software: String,
    /// The scene's file.
    pub scene: String,
    /// Name and value: camera, time, samples, settings. EXR attributes and PNG text.
    pub entries: Vec<(String, String)>,
    /// The same with names of other programs' making: Cryptomatte's manifests. EXR alone holds them.
    pub attributes: Vec<(String, String)>,
}

impl Metadata {
    /// Keyword and text for formats whose keywords are words of Latin-1 of at most 79 characters.
    pub(super) fn texts(&self) -> impl Iterator<Item = (String, String)> {
        let entries = self.entries.iter().map(|(k, v)| (k.chars().filter(|c| c.is_ascii_graphic() || *c == ' ').take(79).collect(), v));
        [("Software".to_owned(), &self.software), ("Source".to_owned(), &self.scene)]
            .into_iter()
            .chain(entries)
            .filter(|(k, v): &(String, &String)| !k.trim().is_empty() && !v.is_empty())
            .map(|(k, v)| (k.trim().to_owned(), v.replace('\0', " ")))
            .collect::<Vec<_>>()
            .into_iter()
    }
}

/// The bytes of a picture file.
pub fn encode_picture(film: &Film, format: &FileFormat, encoding: &Encoding, metadata: &Metadata) -> Result<Vec<u8>, FilmError> {
    if film.width == 0 || film.height == 0 {
        return Err(FilmError::Unfit { format: format.name(), reason: "it has no pixels".into() });
    }
    let shown = film.shown();
    let film = if *format == FileFormat::Exr { film } else { &*shown };
    match *format {
        FileFormat::Png { bits, grayscale } => png_file::encode(film, bits, grayscale, encoding, metadata),
        FileFormat::Exr => exr_file::encode(film, encoding, metadata),
        FileFormat::Targa { rle } => simple_files::targa(film, rle, encoding, metadata),
        FileFormat::Ppm { bits, grayscale } => Ok(simple_files::ppm(film, bits, grayscale, encoding, metadata)),
        FileFormat::Bmp => simple_files::bmp(film, encoding),
        FileFormat::Jpeg { quality } => simple_files::jpeg(film, quality, encoding),
        FileFormat::Hdr => Ok(hdr_file::encode(film, encoding, metadata)),
    }
}

/// Writes a picture file: into a new file beside it that then takes its name. After any failure the old file is as it was.
pub fn write_picture(path: &Path, film: &Film, format: &FileFormat, encoding: &Encoding, metadata: &Metadata) -> Result<(), FilmError> {
    replace_file(path, &encode_picture(film, format, encoding, metadata)?)
}

/// Puts `bytes` into a new file beside `path`, then gives it that name.
pub(crate) fn replace_file(path: &Path, bytes: &[u8]) -> Result<(), FilmError> {
    let failed = |source| FilmError::io("write", path, source);
    // Devices and pipes (/dev/null, /dev/stdout) cannot be replaced.
    if path.metadata().is_ok_and(|m| !m.is_file() && !m.is_dir()) {
        return std::fs::write(path, bytes).map_err(failed);
    }
    // A link stays one: what it points to is replaced.
    let target = path.canonicalize();
    let path = target.as_deref().unwrap_or(path);
    let mut file = beside(path).map_err(failed)?;
    file.as_file_mut().write_all(bytes).map_err(failed)?;
    file.as_file().sync_all().map_err(failed)?;
    file.persist(path).map_err(|e| failed(e.error))?;
    Ok(())
}

/// An empty file with a name of its own in the folder of `path`, gone unless it is kept.
fn beside(path: &Path) -> std::io::Result<tempfile::NamedTempFile> {
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut builder = tempfile::Builder::new();
    builder.prefix(".rayloom-").suffix(".part");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // What any program gives a new file, less the umask; what the old file has, when there is one.
        let mode = path.metadata().map_or(0o666, |m| m.permissions().mode() & 0o777);
        builder.permissions(std::fs::Permissions::from_mode(mode));
    }
    // The name of the passing file would say nothing to anyone.
    let without_name = |e: std::io::Error| {
        let text = e.to_string();
        std::io::Error::new(e.kind(), text.split(" at path ").next().unwrap_or_default().to_owned())
    };
    builder.tempfile_in(folder).map_err(without_name)
}

/// Finds out before the first ray whether `path` can be written: its folder is there and takes files, it is no folder itself.
pub fn check_writable(path: &Path) -> Result<(), FilmError> {
    let failed = |source| FilmError::io("write", path, source);
    match path.metadata() {
        Ok(m) if m.is_dir() => {
            return Err(failed(std::io::Error::new(std::io::ErrorKind::IsADirectory, "it is a folder")));
        }
        Ok(m) if m.is_file() && m.permissions().readonly() => {
            return Err(failed(std::io::Error::new(std::io::ErrorKind::PermissionDenied, "the file is read-only")));
        }
        Ok(m) if !m.is_file() => return Ok(()),
        _ => {}
    }
    beside(path).map(drop).map_err(failed)
}
