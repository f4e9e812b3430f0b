//! Places in source files.

use std::path::PathBuf;
use std::sync::Arc;

/// A file of a [`SourceMap`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct FileId(pub u32);

/// A range of bytes in one file, `lo..hi`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Span {
    /// Which file.
    pub file: FileId,
    /// First byte.
    pub lo: u32,
    /// One past the last byte.
    pub hi: u32,
}

impl Span {
    /// From the start of `self` to the end of `other`; `self` when they are in different files.
    #[must_use]
    pub fn to(self, other: Span) -> Span {
        if self.file == other.file { Span { hi: other.hi.max(self.hi), ..self } } else { self }
    }
}

/// A file that was read, with its line starts.
#[derive(Debug)]
pub struct SourceFile {
    /// The name as the scene or the command line gave it, for messages.
    pub name: String,
    /// Where it was found.
    pub path: PathBuf,
    /// Its bytes.
    pub bytes: Arc<[u8]>,
    line_starts: Vec<u32>,
}

impl SourceFile {
    /// Line and column of a byte, both from 1; columns count bytes. LF, CR LF and a lone CR end a line.
    pub fn line_col(&self, at: u32) -> (u32, u32) {
        let line = self.line_starts.partition_point(|&s| s <= at).max(1);
        (line as u32, at - self.line_starts[line - 1] + 1)
    }

    /// A line (from 1) without its ending.
    pub fn line_bytes(&self, line: u32) -> &[u8] {
        let Some(&lo) = self.line_starts.get(line as usize - 1) else { return &[] };
        let hi = self.line_starts.get(line as usize).map_or(self.bytes.len(), |&s| s as usize);
        self.bytes[lo as usize..hi].trim_ascii_end()
    }
}

/// All files of one job; spans point into it.
#[derive(Debug, Default)]
pub struct SourceMap {
    files: Vec<SourceFile>,
}

impl SourceMap {
    /// Adds a file. Its spans hold 32-bit offsets: the caller refuses files of 4 GiB and more.
    pub fn add(&mut self, name: impl Into<String>, path: PathBuf, bytes: Arc<[u8]>) -> FileId {
        let mut line_starts = vec![0u32];
        let mut i = 0;
        while i < bytes.len() {
            match bytes[i] {
                b'\r' if bytes.get(i + 1) == Some(&b'\n') => {
                    i += 1;
                    line_starts.push(i as u32 + 1);
                }
                b'\n' | b'\r' => line_starts.push(i as u32 + 1),
                _ => {}
            }
            i += 1;
        }
        self.files.push(SourceFile { name: name.into(), path, bytes, line_starts });
        FileId(self.files.len() as u32 - 1)
    }

    /// All files in the order they were read.
    pub fn files(&self) -> &[SourceFile] {
        &self.files
    }

    /// The file of an id that this map gave out.
    pub fn file(&self, id: FileId) -> &SourceFile {
        &self.files[id.0 as usize]
    }

    /// File name, line and column of a span's start.
    pub fn position(&self, span: Span) -> (&str, u32, u32) {
        let f = self.file(span.file);
        let (l, c) = f.line_col(span.lo);
        (&f.name, l, c)
    }
}
