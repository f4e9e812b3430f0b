//! The picture's way to its file: format, encoding, what is written about it.

use super::{Job, JobError, Outcome};
use crate::compile::CompiledScene;
use crate::film::{DitherMethod, Encoding, FileFormat, FileGamma, Film, Metadata};
use std::io::Write;
use std::path::PathBuf;

/// Where a picture goes, and as what.
#[derive(Clone, Debug)]
pub struct Target {
    /// The file; `None` is standard output.
    pub path: Option<PathBuf>,
    /// Kind of file.
    pub format: FileFormat,
    /// Encoding of the file's values.
    pub file_gamma: FileGamma,
    /// With an alpha channel.
    pub alpha: bool,
    /// Spread rounding errors.
    pub dither: Option<DitherMethod>,
}

impl Target {
    /// Whether the file can be written, asked before the first ray.
    pub(super) fn check(&self) -> Result<(), JobError> {
        match &self.path {
            Some(path) => Ok(crate::film::check_writable(path)?),
            None => Ok(()),
        }
    }

    /// Writes the finished picture; gives its path.
    pub(super) fn write(&self, job: &Job, scene: &CompiledScene, film: &Film, outcome: &Outcome) -> Result<Option<PathBuf>, JobError> {
        let encoding = self.encoding(scene);
        let metadata = metadata(job, scene, film, Some(outcome));
        match &self.path {
            Some(path) => {
                crate::film::write_picture(path, film, &self.format, &encoding, &metadata)?;
                Ok(Some(path.clone()))
            }
            None => {
                let bytes = crate::film::encode_picture(film, &self.format, &encoding, &metadata)?;
                std::io::stdout().lock().write_all(&bytes).map_err(|source| crate::film::FilmError::Io {
                    verb: "write",
                    path: PathBuf::from("standard output"),
                    source,
                })?;
                Ok(None)
            }
        }
    }

    /// Writes what was rendered so far in the picture's place; gives its path.
    pub(super) fn save_unfinished(&self, job: &Job, scene: &CompiledScene, film: &Film) -> Result<Option<PathBuf>, JobError> {
        let Some(path) = &self.path else { return Ok(None) };
        let metadata = metadata(job, scene, film, None);
        crate::film::write_picture(path, film, &self.format, &self.encoding(scene), &metadata)?;
        Ok(Some(path.clone()))
    }

    fn encoding(&self, scene: &CompiledScene) -> Encoding {
        Encoding { working: scene.settings.gamma, file_gamma: self.file_gamma, alpha: self.alpha, dither: self.dither }
    }
}

/// What a file says about its picture.
fn metadata(job: &Job, scene: &CompiledScene, film: &Film, outcome: Option<&Outcome>) -> Metadata {
    let camera = &scene.camera;
    let vector = |v: crate::math::DVec3| format!("{} {} {}", v.x, v.y, v.z);
    let r = &job.render;
    let mut entries = vec![
        ("camera.location", vector(camera.location)),
        ("camera.direction", vector(camera.direction)),
        ("camera.right", vector(camera.right)),
        ("camera.up", vector(camera.up)),
        ("integrator", format!("{:?}", r.integrator).to_lowercase()),
        ("samples", format!("{}..{}", r.samples.start, r.samples.end)),
        ("seed", r.seed.to_string()),
        ("most samples in a pixel", film.samples.iter().max().copied().unwrap_or(0).to_string()),
    ];
    if let Some(aa) = &r.antialias {
        entries
            .push(("antialiasing", format!("method {}, threshold {}, depth {}, jitter {}", aa.method, aa.threshold, aa.depth, aa.jitter)));
    }
    if let Some((how, _)) = outcome.and_then(|o| o.denoised.as_ref()) {
        entries.push((crate::film::DENOISED, how.clone()));
    }
    if let Some(n) = &r.noise {
        entries.push(("noise threshold", n.threshold.to_string()));
    }
    // Equal pictures make equal files, except where the format is for keeping records.
    if let (Some(o), Some(FileFormat::Exr)) = (outcome, job.target.as_ref().map(|t| &t.format)) {
        entries.push(("device", o.device.clone()));
        entries.push(("render seconds", format!("{:.3}", o.seconds[2])));
    }
    Metadata {
        software: concat!("rayloom ", env!("CARGO_PKG_VERSION")).into(),
        scene: job.source.path.display().to_string(),
        entries: entries.into_iter().map(|(k, v)| (k.to_owned(), v)).collect(),
        attributes: crate::integrate::path::manifests(scene, job.passes.unwrap_or(r.passes), crate::film::exr_layers::VIEW_LAYER),
    }
}
