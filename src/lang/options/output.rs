//! Names and places of pictures. Source: spec/language.md, section 11.1.

use super::{Frame, OutputType, PovOptions};
use std::path::{Path, PathBuf};

impl OutputType {
    /// File name extension with its dot.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Png => ".png",
            Self::Targa | Self::TargaRle => ".tga",
            Self::Ppm => ".ppm",
            Self::Bmp => ".bmp",
            Self::Jpeg => ".jpg",
            Self::Hdr => ".hdr",
            Self::Exr => ".exr",
        }
    }
}

/// Where a picture goes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum OutputName {
    /// A file.
    File(PathBuf),
    /// Standard output.
    Stdout,
    /// Standard error.
    Stderr,
}

impl PovOptions {
    /// Where the picture of `frame` goes; `input` is the scene file.
    pub fn output_for(&self, input: &Path, frame: &Frame) -> OutputName {
        let extension = self.output_type.extension();
        let base = input.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let with_number = |stem: &str| {
            if frame.digits == 0 { stem.to_owned() } else { format!("{stem}{:0width$}", frame.number, width = frame.digits) }
        };
        let Some(name) = &self.output_name else {
            let stem = with_number(&base);
            return OutputName::File(input.with_file_name(format!("{stem}{extension}")));
        };
        match name.as_str() {
            "-" | "stdout" => return OutputName::Stdout,
            "stderr" => return OutputName::Stderr,
            _ => {}
        }
        if name.ends_with('/') {
            return OutputName::File(Path::new(name).join(format!("{}{extension}", with_number(&base))));
        }
        let stem = name.strip_suffix(extension).unwrap_or(name);
        let stem = stem.strip_suffix('.').unwrap_or(stem);
        OutputName::File(PathBuf::from(format!("{}{extension}", with_number(stem))))
    }

    /// Folder of the picture, where text files go too.
    pub fn output_folder(&self, input: &Path) -> PathBuf {
        match &self.output_name {
            None => input.parent().map_or_else(PathBuf::new, Path::to_path_buf),
            Some(n) if n.ends_with('/') => PathBuf::from(n),
            Some(n) => Path::new(n).parent().map_or_else(PathBuf::new, Path::to_path_buf),
        }
    }
}
