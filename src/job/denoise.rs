//! The denoiser of a job: found before the first ray, used when all samples are there.

use super::{Job, JobError, Listener, Stage};
use crate::denoise::{DenoiseError, Denoiser, guide_passes};
use crate::diag::{Diagnostic, Severity, Sink};
use crate::film::{FileFormat, Film};
use crate::integrate::{IntegratorKind, RenderSettings};
use crate::scene::PassSet;
use std::sync::atomic::AtomicBool;

/// Samples a pixel of guides that are rendered apart (of pictures that a GPU makes).
const GUIDE_SAMPLES: u32 = 32;

/// The denoiser that the command line asks for; loaded before anything else is done.
pub(super) fn asked(job: &Job) -> Result<Option<Denoiser>, JobError> {
    if job.denoise.flatten().is_none() {
        return Ok(None);
    }
    if job.render.integrator != IntegratorKind::Path {
        return Err(JobError::Options("denoising needs the path integrator (--integrator path)".into()));
    }
    Ok(Some(Denoiser::load(job.denoise_library.as_deref())?))
}

/// That which the scene asks for, where the command line says nothing; without the library the picture stays noisy, which is told.
pub(super) fn of_scene(job: &mut Job, sink: &mut Sink) -> Option<Denoiser> {
    job.denoise.flatten()?;
    match Denoiser::load(job.denoise_library.as_deref()) {
        Ok(denoiser) => Some(denoiser),
        Err(e) => {
            let message = format!("the scene asks for denoising, but the picture stays noisy: {e}");
            sink.push_once("denoise", Diagnostic::new(Severity::Warning, None, message));
            job.denoise = Some(None);
            None
        }
    }
}

/// Passes to render: those to be written, and the guides.
pub(super) fn with_guides(job: &Job, asked: PassSet) -> PassSet {
    let guides = job.denoise.flatten().map_or(PassSet::NONE, |d| guide_passes(&d));
    asked.iter().chain(guides.iter()).collect()
}

/// Renders the guides alone on the CPU into the film's layers.
pub(super) fn render_guides(
    job: &Job,
    film: &mut Film,
    render: impl FnOnce(&RenderSettings, &mut Film) -> Result<(), crate::backend::BackendError>,
) -> Result<(), crate::backend::BackendError> {
    let samples = 0..(job.render.samples.len() as u32).min(GUIDE_SAMPLES);
    let settings = RenderSettings { samples, noise: None, time_limit: None, features_only: true, ..job.render.clone() };
    let mut guides = Film::with_passes(film.width, film.height, settings.passes);
    render(&settings, &mut guides)?;
    film.layers = guides.layers;
    Ok(())
}

/// Denoises the film; gives what the file says about it.
pub(super) fn run(
    job: &Job,
    denoiser: &Denoiser,
    film: &mut Film,
    listener: &dyn Listener,
    cancel: &AtomicBool,
) -> Result<String, DenoiseError> {
    let settings = job.denoise.flatten().unwrap_or_default();
    listener.stage(&Stage::Denoising);
    denoiser.film(film, job.render.crop, &settings, job.render.threads, &|share| listener.denoised(share), cancel)?;
    Ok(format!("Open Image Denoise {}, {settings:?}", denoiser.name().split(' ').next().unwrap_or_default()))
}

/// Leaves the layers that are to be written.
pub(super) fn drop_guides(job: &Job, film: &mut Film) {
    let is_exr = job.target.as_ref().is_none_or(|t| t.format == FileFormat::Exr);
    film.layers.retain(|l| is_exr && job.passes.is_some_and(|p| p.has(l.pass)));
}
