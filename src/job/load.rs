//! Scene files of any kind → [`Scene`].

use super::{Job, JobError, Listener};
use crate::diag::{Sink, SourceMap};
use crate::import::ImportOptions;
use crate::kernel::query::KernelQuery;
use crate::lang::{LangOptions, Stream, parse_scene};
use crate::scene::Scene;
use crate::world::{DiskWorld, World, WorldError};
use std::path::{Path, PathBuf};

/// Where a scene comes from.
#[derive(Clone, Debug)]
pub struct Source {
    /// The file, as the user named it.
    pub path: PathBuf,
    /// What it is.
    pub format: SceneFormat,
    /// Clock, constants and limits of the scene language.
    pub lang: LangOptions,
    /// Searched for scenes, includes, images and fonts after the current folder.
    pub library_paths: Vec<PathBuf>,
    /// Folders that the scene may open files of its own in; empty: everywhere.
    pub io_folders: Vec<PathBuf>,
    /// Which moment of a model's animation.
    pub moment: Moment,
}

/// A moment of a model's animation.
#[derive(Clone, Debug, PartialEq)]
pub struct Moment {
    /// Seconds; `None`: nodes stand as the file places them.
    pub time: Option<f64>,
    /// Frames in a second.
    pub fps: f64,
    /// Which animation, by name or number; `None`: the first.
    pub animation: Option<String>,
}

impl Default for Moment {
    fn default() -> Self {
        Self { time: None, fps: 24.0, animation: None }
    }
}

/// Kind of scene file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SceneFormat {
    /// POV-Ray's scene language.
    Pov,
    /// glTF or OBJ.
    Model,
}

impl SceneFormat {
    /// By extension: models are .glb, .gltf and .obj, all else is the scene language.
    pub fn of(path: &Path) -> Self {
        let extension = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
        if matches!(extension.as_deref(), Some("glb" | "gltf" | "obj")) { Self::Model } else { Self::Pov }
    }
}

/// Reads the job's scene; findings are in the sink, also after an error.
pub fn load(job: &Job, map: &mut SourceMap, sink: &mut Sink, listener: &dyn Listener) -> Result<Scene, JobError> {
    let source = &job.source;
    match source.format {
        SceneFormat::Model => {
            let aspect = f64::from(job.render.width) / f64::from(job.render.height);
            let Moment { time, fps, animation } = source.moment.clone();
            let options = ImportOptions {
                aspect,
                time,
                fps,
                animation,
                memory: source.lang.memory,
                savings: job.compile.savings,
                ..ImportOptions::default()
            };
            Ok(crate::import::load(&source.path, &options, sink)?)
        }
        SceneFormat::Pov => parse(source, map, sink, &mut |stream, t| listener.text(stream, t)),
    }
}

/// Reads a scene by itself, as for a picture of POV-Ray's default size.
pub fn load_scene(path: &Path, library_paths: &[PathBuf], map: &mut SourceMap, sink: &mut Sink) -> Result<Scene, JobError> {
    if SceneFormat::of(path) == SceneFormat::Model {
        return Ok(crate::import::load(path, &ImportOptions::default(), sink)?);
    }
    let source = Source {
        path: path.to_owned(),
        format: SceneFormat::Pov,
        lang: LangOptions::default(),
        library_paths: library_paths.iter().cloned().chain(include_folders()).collect(),
        io_folders: vec![PathBuf::new(), path.parent().map_or_else(PathBuf::new, Path::to_path_buf), std::env::temp_dir()],
        moment: Moment::default(),
    };
    parse(&source, map, sink, &mut |_, _| {})
}

/// Folders where POV-Ray's includes are usually installed, those that exist.
pub fn include_folders() -> impl Iterator<Item = PathBuf> {
    ["/usr/share/povray-3.7/include", "/usr/local/share/povray-3.7/include", "/opt/homebrew/share/povray-3.7/include"]
        .into_iter()
        .map(PathBuf::from)
        .filter(|p| p.is_dir())
}

/// Reads a scene in POV-Ray's language; `text` hears what it writes.
fn parse(source: &Source, map: &mut SourceMap, sink: &mut Sink, text: &mut dyn FnMut(Stream, &str)) -> Result<Scene, JobError> {
    let world =
        DiskWorld { current_dir: PathBuf::new(), library_paths: source.library_paths.clone(), io_folders: source.io_folders.clone() };
    let name = source.path.to_string_lossy();
    let path = world.find(&name, &[".pov"]).ok_or_else(|| missing(&source.path))?;
    let bytes = world.read(&path)?;
    let parsed = parse_scene(&name, &bytes, &world, &KernelQuery::new(), &source.lang, map, sink);
    for (stream, t) in &parsed.output {
        text(*stream, t);
    }
    parsed.scene.ok_or(JobError::Scene)
}

/// Why a scene file is not there, as precisely as can be told.
fn missing(path: &Path) -> JobError {
    if path.is_dir() {
        let source = std::io::Error::new(std::io::ErrorKind::IsADirectory, "it is a folder");
        return WorldError::Io { verb: "read", path: path.to_owned(), source }.into();
    }
    WorldError::NotFound(path.display().to_string()).into()
}
