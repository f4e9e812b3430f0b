//! What the command line left to the scene: passes, and the noise that pixels may keep.

use super::{Job, JobError};
use crate::diag::Sink;
use crate::film::FileFormat;
use crate::integrate::{IntegratorKind, NoiseLimit};
use crate::savings::Saving;
use crate::scene::{PassSet, Scene};

/// Whether the job's picture can have passes: why not, if not.
fn no_passes(job: &Job) -> Option<&'static str> {
    if job.render.integrator != IntegratorKind::Path {
        return Some("they need the path integrator (--integrator path)");
    }
    let is_exr = job.target.as_ref().is_none_or(|t| t.format == FileFormat::Exr);
    (!is_exr).then_some("only .exr pictures hold them")
}

/// Refuses what the command line asks for in vain.
pub(super) fn check(job: &Job) -> Result<(), JobError> {
    if let (Some(why), true) = (no_passes(job), job.passes.is_some_and(|p| !p.is_empty())) {
        return Err(JobError::Options(format!("passes cannot be written: {why}")));
    }
    if job.time_limit.is_some_and(|t| t > 0.0) && job.render.integrator != IntegratorKind::Path {
        return Err(JobError::Options("a time limit needs the path integrator (--integrator path)".into()));
    }
    if job.noise.is_some_and(|n| n.is_some()) && job.render.integrator != IntegratorKind::Path {
        return Err(JobError::Options("a noise threshold needs the path integrator (--integrator path)".into()));
    }
    Ok(())
}

/// The job with its last settings.
pub(super) fn settled(job: &Job, scene: &Scene, sink: &mut Sink) -> Job {
    let asked = &scene.settings.path;
    let mut job = job.clone();
    let is_path = job.render.integrator == IntegratorKind::Path;
    job.render.passes = job.passes.unwrap_or(asked.passes);
    if let (Some(why), false) = (no_passes(&job), job.render.passes.is_empty()) {
        sink.note_once("passes", None, format!("the passes that the scene asks for are left out: {why}"));
        job.render.passes = PassSet::NONE;
    }
    job.passes = Some(job.render.passes);
    job.denoise = Some(job.denoise.unwrap_or(asked.denoise).filter(|_| is_path));
    let seconds = job.time_limit.unwrap_or(f64::from(asked.time_limit));
    job.render.time_limit = std::time::Duration::try_from_secs_f64(seconds).ok().filter(|t| is_path && !t.is_zero());
    let threshold = asked.adaptive_threshold;
    let own = (threshold > 0.0).then_some(NoiseLimit { threshold, min_samples: asked.adaptive_min_samples });
    job.render.noise = job.noise.unwrap_or(own).filter(|_| is_path);
    if !job.compile.savings.has(Saving::Antialias) {
        // Every pixel differs by nothing at least.
        job.render.antialias.iter_mut().for_each(|a| a.threshold = 0.0);
        job.render.noise = None;
    }
    job
}
