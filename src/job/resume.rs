//! Going on from an interrupted run: which saved pixels still count.

use super::{Job, JobError};
use crate::diag::{Sink, SourceMap};
use crate::film::{Film, state};
use crate::integrate::antialias::blocks;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Where the job's state is kept, if it has a file to be kept beside.
pub(super) fn state_path(job: &Job) -> Option<PathBuf> {
    job.target.as_ref()?.path.as_deref().map(state::path_for)
}

/// What decides the job's pixels: every file of its scene, the settings. Threads and machine do not.
pub(super) fn fingerprint(job: &Job, map: &SourceMap) -> String {
    let r = &job.render;
    let mut text = format!(
        "{} {}x{} {:?} {:?} {:?} {:?} seed {} alpha {} blocks {} quality {} clock {} {:?}",
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
        job.compile.quality,
        job.source.lang.clock,
        job.source.lang.declares,
    );
    for file in map.files() {
        let _ = write!(text, " {}:{:016x}", file.name, fnv1a(&file.bytes));
    }
    // Models are read outside the map: their size and time stand for them.
    if let (0, Ok(m)) = (map.files().len(), std::fs::metadata(&job.source.path)) {
        let _ = write!(text, " {} {:?}", m.len(), m.modified().ok());
    }
    text
}

fn fnv1a(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |h, b| (h ^ u64::from(*b)).wrapping_mul(0x0000_0100_0000_01b3))
}

/// The film to start from: an earlier run's finished blocks when the job wants them and they are there, else an empty one.
pub(super) fn film(job: &Job, fingerprint: &str, sink: &mut Sink) -> Result<Film, JobError> {
    let empty = Film::new(job.render.width, job.render.height);
    let Some(path) = state_path(job).filter(|p| job.resume && p.exists()) else { return Ok(empty) };
    match load(&path, job, fingerprint) {
        Ok(film) => Ok(film),
        Err(e) => {
            sink.note_once("resume", None, format!("rendered from the start: {e}"));
            Ok(empty)
        }
    }
}

fn load(path: &Path, job: &Job, fingerprint: &str) -> Result<Film, crate::film::FilmError> {
    let mut film = state::load(path, fingerprint)?;
    // Blocks are rendered whole, so that antialiasing sees the neighbours it saw before.
    let wanted = job.render.samples.len().max(1) as u32;
    for [x0, y0, x1, y1] in blocks(job.render.crop, job.render.block_size) {
        let places = || (y0..y1).flat_map(move |y| (x0..x1).map(move |x| (x, y)));
        let is_finished = |film: &Film| places().all(|(x, y)| film.samples[film.index(x, y)] >= wanted);
        if !is_finished(&film) {
            for (x, y) in places() {
                let at = film.index(x, y);
                film.samples[at] = 0;
                film.pixels[at] = [0.0; 4];
            }
        }
    }
    Ok(film)
}
