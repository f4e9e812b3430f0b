//! One picture from its scene file to its own file: load → compile → render → write, with progress, cancel and resume.
//!
//! The command line decides what a [`Job`] is and prints what a [`Listener`] hears; nothing here prints or reads arguments.

mod backend;
mod denoise;
mod estimate;
mod load;
mod pov;
mod resume;
mod settle;
mod timed;
mod write;

pub use backend::BackendChoice;
pub use load::{Moment, SceneFormat, Source, include_folders, load as load_job, load_scene};
pub use pov::{all_cores, check_size, job_for_frame};
pub use write::Target;

use crate::backend::{BackendError, Progress};
use crate::compile::{CompileError, CompileOptions};
use crate::cpu_time;
use crate::denoise::DenoiseError;
use crate::diag::{Diagnostic, Sink, SourceMap};
use crate::film::{CatcherView, Film, FilmError};
use crate::import::ImportError;
use crate::integrate::classic::PhotonStats;
use crate::integrate::{NoiseLimit, RenderSettings};
use crate::lang::Stream;
use crate::scene::denoise::DenoiseSettings;
use crate::scene::{Pass, PassSet};
use crate::world::WorldError;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, OnceLock};
use std::time::Instant;

/// A picture to be made.
#[derive(Clone, Debug)]
pub struct Job {
    /// The scene.
    pub source: Source,
    /// Where the picture goes; `None` renders and throws away.
    pub target: Option<Target>,
    /// Size, samples, antialiasing, threads.
    pub render: RenderSettings,
    /// Quality, tree, skipping.
    pub compile: CompileOptions,
    /// Which machine.
    pub backend: BackendChoice,
    /// What `BackendChoice::Auto` found of the first picture; shared, so that all frames of an animation come from one machine.
    pub worth_a_gpu: Arc<OnceLock<bool>>,
    /// Part of the GPU's name, in any case; empty takes the first.
    pub gpu: String,
    /// Go on from what an interrupted run of the same job left beside the target.
    pub resume: bool,
    /// Passes to render besides the colours; none said: those that the scene asks for. Path integrator and EXR only.
    pub passes: Option<PassSet>,
    /// The noise that pixels may keep; none said: what the scene asks for. Path integrator only.
    pub noise: Option<Option<NoiseLimit>>,
    /// Seconds of rendering at most, 0 for no limit; none said: what the scene asks for. Path integrator only.
    pub time_limit: Option<f64>,
    /// Denoising of the finished picture; none said: what the scene asks for. Path integrator only.
    pub denoise: Option<Option<DenoiseSettings>>,
    /// The denoiser's library, or the folder that it is in; none: where it is looked for (`denoise`).
    pub denoise_library: Option<PathBuf>,
}

/// Where a job is.
#[derive(Clone, Debug, PartialEq)]
pub enum Stage {
    /// The scene is being read.
    Loading,
    /// The scene is being compiled.
    Compiling,
    /// Rays are traced by the named machine; so many pixels were there from an earlier run.
    Rendering {
        /// "CPU, 2 threads".
        device: String,
        /// Taken over from an interrupted run.
        resumed_pixels: u64,
    },
    /// The picture is being denoised.
    Denoising,
    /// The picture is being written.
    Writing,
}

/// Hears about a job while it runs. Pixels are told from any thread.
pub trait Listener: Sync {
    /// A stage begins.
    fn stage(&self, stage: &Stage);
    /// Findings, in order.
    fn diagnostic(&self, d: &Diagnostic, map: &SourceMap);
    /// What the scene writes.
    fn text(&self, stream: Stream, text: &str);
    /// `done` of `total` pixels are finished.
    fn pixels(&self, done: u64, total: u64);
    /// `done` of about `total` photons are shot, before the first pixel.
    fn photons(&self, _done: u64, _total: u64) {}
    /// So much of the denoising is done, 0..1.
    fn denoised(&self, _share: f64) {}
    /// The finished picture, before it is written.
    fn finished(&self, _film: &Film) {}
    /// The picture so far, often; most calls must return at once.
    fn picture(&self, _film: &Film) {}
}

/// What came of a job.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// The machine that rendered.
    pub device: String,
    /// Wall clock seconds of loading, compiling, rendering, writing.
    pub seconds: [f64; 4],
    /// The same of all processor cores together; NaN where they cannot be told.
    pub cpu_seconds: [f64; 4],
    /// What was rendered.
    pub film: Film,
    /// Where the picture is.
    pub written: Option<PathBuf>,
    /// Objects, primitives and lights of the scene.
    pub counts: [usize; 3],
    /// Samples of a pixel: fewest, mean, most.
    pub samples: (u32, f64, u32),
    /// The photons of the scene, if it has any.
    pub photons: Option<PhotonStats>,
    /// A time limit ended the rendering.
    pub limited: bool,
    /// How the picture was denoised, if it was, and the seconds that it took.
    pub denoised: Option<(String, f64)>,
}

/// Why there is no picture, or not all of one.
#[derive(Debug, thiserror::Error)]
pub enum JobError {
    /// The scene is wrong; the listener heard why.
    #[error("the scene cannot be rendered")]
    Scene,
    /// The options do not fit together.
    #[error("{0}")]
    Options(String),
    /// A file cannot be read.
    #[error(transparent)]
    World(#[from] WorldError),
    /// A model file is wrong.
    #[error(transparent)]
    Import(#[from] ImportError),
    /// The scene is too large to compile.
    #[error(transparent)]
    Compile(#[from] CompileError),
    /// The picture cannot be written.
    #[error(transparent)]
    Film(#[from] FilmError),
    /// The picture cannot be denoised.
    #[error(transparent)]
    Denoise(#[from] DenoiseError),
    /// The machine failed; what was rendered is at the path, if anything could be saved.
    #[error("{error}{}", saved_note(saved.as_ref()))]
    Device {
        /// What happened.
        error: BackendError,
        /// Where the unfinished picture is.
        saved: Option<PathBuf>,
    },
    /// Stopped by the user; what was rendered is at the path, if there is one.
    #[error("interrupted{}", saved_note(saved.as_ref()))]
    Interrupted {
        /// Where the unfinished picture is.
        saved: Option<PathBuf>,
    },
}

fn saved_note(saved: Option<&PathBuf>) -> String {
    saved.map_or(String::new(), |p| format!("; what was rendered is in '{}'", p.display()))
}

impl JobError {
    /// Exit code of `rayloom render`: 2 usage, 3 scene, 4 file, 5 device, 130 interrupted.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Options(_) => 2,
            Self::Scene | Self::Compile(_) | Self::Import(_) => 3,
            Self::World(_) | Self::Film(_) => 4,
            Self::Device { .. } | Self::Denoise(_) => 5,
            Self::Interrupted { .. } => 130,
        }
    }
}

/// Bytes of a pixel in the film and while its file is made.
const PIXEL_COST: u64 = 32;

/// Tells the findings gathered since the last call.
fn tell(sink: &mut Sink, map: &SourceMap, listener: &dyn Listener) {
    for d in sink.drain() {
        listener.diagnostic(&d, map);
    }
}

/// Runs a job. After an interrupt the unfinished picture and a state to resume from are written.
pub fn run(job: &Job, listener: &dyn Listener, cancel: &AtomicBool) -> Result<Outcome, JobError> {
    let (mut map, mut sink) = (SourceMap::default(), Sink::default());
    let mut outcome = Outcome::default();
    let mut clock = (Instant::now(), cpu_time::process_seconds());
    let mut lap = |outcome: &mut Outcome, stage: usize| {
        let now = (Instant::now(), cpu_time::process_seconds());
        outcome.seconds[stage] = (now.0 - clock.0).as_secs_f64();
        outcome.cpu_seconds[stage] = now.1 - clock.1;
        clock = now;
    };
    if let Some(target) = &job.target {
        target.check()?;
    }
    let pixels = u64::from(job.render.width) * u64::from(job.render.height);
    job.compile
        .memory
        .allows(pixels * PIXEL_COST)
        .map_err(|e| JobError::Options(format!("a picture of {} by {} pixels does not fit: {e}", job.render.width, job.render.height)))?;
    settle::check(job)?;
    let mut denoiser = denoise::asked(job)?;
    listener.stage(&Stage::Loading);
    let loaded = load::load(job, &mut map, &mut sink, listener);
    tell(&mut sink, &map, listener);
    let scene = loaded?;
    lap(&mut outcome, 0);

    listener.stage(&Stage::Compiling);
    let compiled = crate::compile::compile_scene(&scene, &job.compile);
    tell(&mut sink, &map, listener);
    let compiled = compiled?;
    let mut job = settle::settled(job, &scene, &mut sink);
    if denoiser.is_none() {
        denoiser = denoise::of_scene(&mut job, &mut sink);
    }
    job.render.passes = denoise::with_guides(&job, job.render.passes);
    // Catchers are shown by sums of their own.
    let is_path = job.render.integrator == crate::integrate::IntegratorKind::Path;
    if is_path && crate::integrate::path::has_catchers(&compiled) {
        job.render.passes = job.render.passes.with(Pass::ShadowCatcher);
    }
    if let (Some(target), true) = (&mut job.target, is_path && crate::integrate::path::makes_holes(&compiled)) {
        target.alpha = true;
    }
    let job = &job;
    outcome.counts = [scene.objects.len(), compiled.geometry.prims.len(), compiled.lights.len()];
    drop(scene);
    lap(&mut outcome, 1);

    let fingerprint = resume::fingerprint(job, &map);
    let mut film = resume::film(job, &fingerprint, &mut sink);
    let start = Instant::now();
    let result = backend::render(job, &compiled, &mut film, &mut outcome, &mut sink, &map, listener, cancel);
    let spent = start.elapsed();
    tell(&mut sink, &map, listener);
    lap(&mut outcome, 2);
    let stopped = cancel.load(Ordering::Relaxed);
    if stopped || result.is_err() {
        let saved = match &job.target {
            Some(target) if film.samples.iter().any(|n| *n > 0) => {
                if let Some(path) = resume::state_path(job) {
                    crate::film::state::save(&path, &film, &fingerprint)?;
                }
                target.save_unfinished(job, &compiled, &film)?
            }
            _ => None,
        };
        return Err(match result {
            Err(error) => JobError::Device { error, saved },
            Ok(()) => JobError::Interrupted { saved },
        });
    }
    outcome.samples = samples_of(&film, job.render.crop);
    outcome.limited =
        job.render.time_limit.is_some_and(|limit| spent >= limit.mul_f64(0.85)) && outcome.samples.0 < job.render.samples.len() as u32;
    let apart = job.passes.is_some_and(|p| p.has(Pass::ShadowCatcher));
    film.resolve_catchers(CatcherView { apart, transparent: compiled.settings.path.film_transparent || job.render.output_alpha });
    if let Some(denoiser) = &denoiser {
        let start = Instant::now();
        match denoise::run(job, denoiser, &mut film, listener, cancel) {
            Ok(how) => outcome.denoised = Some((how, start.elapsed().as_secs_f64())),
            Err(error) => {
                // The samples are not lost.
                if let Some(target) = &job.target {
                    denoise::drop_guides(job, &mut film);
                    target.save_unfinished(job, &compiled, &film)?;
                }
                return Err(error.into());
            }
        }
        lap(&mut outcome, 3);
    }
    listener.finished(&film);
    denoise::drop_guides(job, &mut film);
    if let Some(target) = &job.target {
        listener.stage(&Stage::Writing);
        outcome.written = target.write(job, &compiled, &film, &outcome)?;
        if let Some(path) = resume::state_path(job) {
            // None there is the usual case.
            let _ = std::fs::remove_file(path);
        }
    }
    lap(&mut outcome, 3);
    outcome.film = film;
    Ok(outcome)
}

/// Fewest, mean and most samples of the pixels of a part.
fn samples_of(film: &Film, [x0, y0, x1, y1]: [u32; 4]) -> (u32, f64, u32) {
    let all = || (y0..y1).flat_map(|y| (x0..x1).map(move |x| film.samples[film.index(x, y)]));
    let sum: u64 = all().map(u64::from).sum();
    (all().min().unwrap_or(0), sum as f64 / all().count().max(1) as f64, all().max().unwrap_or(0))
}

/// Passes pixels on to a listener.
struct Pixels<'l> {
    listener: &'l dyn Listener,
    photons: Mutex<Option<PhotonStats>>,
}

impl<'l> Pixels<'l> {
    fn new(listener: &'l dyn Listener) -> Self {
        Self { listener, photons: Mutex::new(None) }
    }

    /// The photons that were told of.
    fn photons(&self) -> Option<PhotonStats> {
        *self.photons.lock().expect("no thread panics while it holds a few numbers")
    }
}

impl Progress for Pixels<'_> {
    fn pixels(&self, done: u64, total: u64) {
        self.listener.pixels(done, total);
    }

    fn photons(&self, done: u64, total: u64) {
        self.listener.photons(done, total);
    }

    fn photons_at_rest(&self, stats: &PhotonStats) {
        *self.photons.lock().expect("no thread panics while it holds a few numbers") = Some(*stats);
    }

    fn picture(&self, film: &Film) {
        self.listener.picture(film);
    }
}
