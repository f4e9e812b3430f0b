//! Why a file could not become a scene.

use std::path::PathBuf;

/// Why a file could not become a scene. Each message names the file, and the place in it where there is one.
#[derive(Debug, thiserror::Error)]
pub enum ImportError {
    /// The file, or a buffer that it names, is missing or may not be read.
    #[error("cannot read '{}': {source}", path.display())]
    Read {
        /// Which file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The name leads to a directory or a device.
    #[error("'{}' is not a file", .0.display())]
    NotAFile(PathBuf),
    /// The file has no bytes.
    #[error("'{}' is empty", .0.display())]
    Empty(PathBuf),
    /// The file is larger than the reader accepts.
    #[error("'{}' has {size} bytes, more than the limit of {limit}", path.display())]
    TooLarge {
        /// Which file.
        path: PathBuf,
        /// Its size in bytes.
        size: u64,
        /// The limit in bytes.
        limit: u64,
    },
    /// Neither the name nor the content says what kind of file it is.
    #[error("'{}' is neither glTF 2.0 nor OBJ", .0.display())]
    UnknownFormat(PathBuf),
    /// The container or its JSON is cut off, damaged, or of another version.
    #[error("'{}' is damaged: {what}", path.display())]
    Damaged {
        /// Which file.
        path: PathBuf,
        /// In one sentence.
        what: String,
    },
    /// A file that cannot be shown without an extension of glTF that is not supported.
    #[error("'{}' requires the glTF extension {name}, which is not supported", path.display())]
    RequiredExtension {
        /// Which file.
        path: PathBuf,
        /// As the file spells it.
        name: String,
    },
    /// Something inside breaks the rules of its format: counts, offsets, kinds, references.
    #[error("'{}', {place}: {what}", path.display())]
    Invalid {
        /// Which file.
        path: PathBuf,
        /// "accessor 3", "mesh 'Cube', primitive 0", "line 12".
        place: String,
        /// In one sentence.
        what: String,
    },
    /// A vertex is NaN or infinite.
    #[error("'{}', {place}: vertex {vertex} is not finite: ({x}, {y}, {z})", path.display())]
    NotFinite {
        /// Which file.
        path: PathBuf,
        /// The mesh.
        place: String,
        /// Its vertex, from 0 in glTF, from 1 in OBJ, as their indices count.
        vertex: usize,
        /// First coordinate.
        x: f32,
        /// Second coordinate.
        y: f32,
        /// Third coordinate.
        z: f32,
    },
    /// A face names a vertex that is not there.
    #[error("'{}', {place}: index {index} is outside its {count} {what}", path.display())]
    IndexOutOfRange {
        /// Which file.
        path: PathBuf,
        /// The mesh, or the line.
        place: String,
        /// As the file has it.
        index: i64,
        /// How many there are.
        count: usize,
        /// "vertices", "normals", "texture coordinates".
        what: &'static str,
    },
    /// A node is its own ancestor, or has two parents.
    #[error("'{}': node {node} is reached twice (a cycle, or two parents)", path.display())]
    NodeReachedTwice {
        /// Which file.
        path: PathBuf,
        /// Its index.
        node: usize,
    },
    /// Nodes stand inside nodes too deep.
    #[error("'{}': node {node} lies deeper than {limit} nodes", path.display())]
    TooDeep {
        /// Which file.
        path: PathBuf,
        /// Its index.
        node: usize,
        /// The limit.
        limit: usize,
    },
    /// The animation that was asked for is not there.
    #[error("'{}' has no animation '{name}'; it has {}", path.display(), if list.is_empty() { "none" } else { list })]
    NoAnimation {
        /// Which file.
        path: PathBuf,
        /// As asked for.
        name: String,
        /// Those that are there, with commas between.
        list: String,
    },
    /// Few bytes of the file ask for more memory than there is.
    #[error(transparent)]
    Memory(#[from] crate::memory::OutOfMemory),
    /// More of something than the reader accepts.
    #[error("'{}' has more than {limit} {what}", path.display())]
    TooMany {
        /// Which file.
        path: PathBuf,
        /// "vertices", "nodes".
        what: &'static str,
        /// The limit.
        limit: usize,
    },
}
