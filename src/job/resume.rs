//! Going on from an interrupted run: which saved pixels still count.

use super::Job;
use crate::backend::unfinished_blocks;
use crate::diag::{Sink, SourceMap};
use crate::film::{Film, state};
use std::fmt::Write;
use std::path::PathBuf;

/// Where the job's state is kept, if it has a file to be kept beside.
pub(super) fn state_path(job: &Job) -> Option<PathBuf> {
    job.target.as_ref()?.path.as_deref().map(state::path_for)
}

/// What decides the job's pixels: every file of its scene, the settings. Threads and machine do not.
pub(super) fn fingerprint(job: &Job, map: &SourceMap) -> String {
    let r = &job.render;
    let mut text = format!(
        "{} {}x{} {:?} {:?} {:?} {:?} seed {} alpha {} blocks {} passes {:?} noise {:?} limit {:?} quality {} clock {} {:?} {:?}",
        job.source.path.display(),
        r.width,
        r.height,
        r.crop,
        r.antialias,
        r.samples,
        r.integrator,
        r.seed,
        r.output_alpha,
        r.block_size,
        r.passes,
        r.noise,
        r.time_limit,
        job.compile.quality,
        job.source.lang.clock,
        job.source.lang.declares,
        job.source.moment,
    );
    for file in map.files() {
        let _ = write!(text, " {}:{:016x}", file.name, state::checksum(&file.bytes));
    }
    // Models are read outside the map: their size and time stand for them.
    if let (0, Ok(m)) = (map.files().len(), std::fs::metadata(&job.source.path)) {
        let _ = write!(text, " {} {:?}", m.len(), m.modified().ok());
    }
    text
}

/// The film to start from: an earlier run's finished blocks when the job wants them and they are there, else an empty one.
pub(super) fn film(job: &Job, fingerprint: &str, sink: &mut Sink) -> Film {
    let empty = Film::with_passes(job.render.width, job.render.height, job.render.passes);
    let Some(path) = state_path(job).filter(|p| job.resume && p.exists()) else { return empty };
    match state::load(&path, fingerprint) {
        Ok(mut film) => {
            // What stands in blocks that were not finished does not count.
            unfinished_blocks(&mut film, &job.render);
            film
        }
        Err(e) => {
            sink.note_once("resume", None, format!("rendered from the start: {e}"));
            empty
        }
    }
}
