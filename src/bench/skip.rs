//! What each saving saves: the same picture with and without it in turn, its pixels compared.

use super::{compiled, median};
use crate::backend::device_names;
use crate::compile::CompiledScene;
use crate::compile::shape::TreeStore;
use crate::diag::{Diagnostic, SourceMap};
use crate::film::Film;
use crate::integrate::classic::takes_shafts;
use crate::integrate::{IntegratorKind, RenderSettings};
use crate::job::{BackendChoice, Job, JobError, Listener, Outcome, SceneFormat, Stage};
use crate::lang::Stream;
use crate::savings::{Pixels, SAVINGS, Saving, Savings};
use crate::scene::Unread;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::{Duration, Instant};

/// Largest difference of colours that is rounding.
const ROUNDING: f32 = 2e-6;

/// Pictures without a saving are given up after so many times the usual time.
const MOST_TIMES: f64 = 20.0;

/// What a saving did for a picture.
#[derive(Clone, Debug)]
pub struct Row {
    /// Which.
    pub saving: Saving,
    /// Why it can do nothing for this scene; then nothing was measured.
    pub why_not: Option<String>,
    /// Seconds of reading, compiling and rendering without it and with it: of all cores, where the system tells, else by the clock.
    /// Medians over the rounds.
    pub seconds: [[f64; 3]; 2],
    /// Median over the rounds of the ratio of the sums.
    pub ratio: f64,
    /// Least and largest of these ratios.
    pub spread: [f64; 2],
    /// Values of the picture that differ, and by how much at most.
    pub differing: (usize, f32),
    /// The machine that rendered.
    pub device: String,
}

impl Row {
    /// Whether the picture is what it must be.
    pub fn holds(&self) -> bool {
        let (n, most) = self.differing;
        self.why_not.is_some()
            || match self.saving.info().pixels {
                Pixels::Same => n == 0,
                Pixels::Rounded => most <= ROUNDING,
                Pixels::Different => true,
            }
    }
}

/// Whether a saving is one of the GPU's shaders and buffers.
fn is_of_gpu(saving: Saving) -> bool {
    matches!(saving, Saving::Shaders | Saving::Attributes)
}

/// Why a saving can do nothing for a scene as it is rendered; `None` where it can.
pub fn why_not(saving: Saving, scene: &CompiledScene, unread: &Unread, format: SceneFormat, render: &RenderSettings) -> Option<String> {
    let g = &scene.geometry;
    let is_path = render.integrator == IntegratorKind::Path;
    let pov = format == SceneFormat::Pov;
    let reason: Option<&str> = match saving {
        s if is_of_gpu(s) && device_names().is_empty() => Some("there is no GPU"),
        s if is_of_gpu(s) && is_path => Some("the path integrator's shaders hold what the scene uses, always"),
        Saving::Attributes if g.shapes.meshes.iter().all(|m| m.mesh.uvs.is_empty()) => Some("no mesh has texture coordinates"),
        Saving::Attributes if scene.features.uv => Some("the texture coordinates are used"),
        Saving::Textures if pov => Some("the scene language reads a picture where it is named"),
        Saving::Textures if unread.pictures[1] == 0 => Some("the file has no pictures"),
        Saving::Textures if unread.pictures[0] == 0 => Some("all pictures are used"),
        Saving::Trees | Saving::Frames if g.shapes.meshes.is_empty() => Some("there are no meshes"),
        Saving::Frames if !pov => Some("models have one frame"),
        Saving::Lights | Saving::Blockers | Saving::Interiors | Saving::Shafts | Saving::Bailout if is_path => {
            Some("the path integrator chooses its rays itself")
        }
        Saving::Lights | Saving::Blockers if scene.lights.iter().all(|l| l.light.shadowless) => Some("no light casts shadows"),
        Saving::Lights if !scene.media.is_empty() => Some("media draw random numbers on the way to lights"),
        Saving::Interiors if g.solids.is_empty() => Some("no solid has an interior"),
        Saving::Shafts if !scene.lights.iter().any(|l| l.light.area.as_ref().is_some_and(takes_shafts)) => {
            Some("no area light has points enough")
        }
        Saving::Bailout if !scene.features.reflection && !scene.features.transparency => Some("nothing reflects or lets light through"),
        Saving::Antialias if render.antialias.is_none() && render.noise.is_none() => {
            Some("no antialiasing and no noise threshold is asked for")
        }
        _ => None,
    };
    reason.map(str::to_owned)
}

/// Measures `only` (or all) over so many rounds; `told` hears of each row as soon as it is there.
///
/// # Errors
/// The scene cannot be read, compiled or rendered.
pub fn run(job: &Job, only: &[Saving], rounds: usize, listener: &dyn Listener, told: &mut dyn FnMut(&Row)) -> Result<Vec<Row>, JobError> {
    let job = &Job { target: None, ..job.clone() };
    // The machine warms up, and the scene tells what it is.
    let (scene, unread) = compiled(job, listener)?;
    let start = Instant::now();
    let first = render(job, Savings::ALL, f64::from(u32::MAX))?;
    let most_seconds = 5.0 + MOST_TIMES * start.elapsed().as_secs_f64();
    let mut rows = Vec::new();
    for info in SAVINGS.iter().filter(|s| only.is_empty() || only.contains(&s.saving)) {
        let why = (is_of_gpu(info.saving) && job.backend == BackendChoice::Cpu)
            .then(|| "it is the GPU's, and the CPU was asked for".to_owned())
            .or_else(|| why_not(info.saving, &scene, &unread, job.source.format, &job.render));
        let row = match why {
            Some(_) => Row { why_not: why, ..empty(info.saving) },
            None => match measured(job, info.saving, rounds, &first, most_seconds) {
                Err(JobError::Interrupted { .. }) => {
                    let why = format!("without it the picture takes more than {MOST_TIMES} times as long, and was given up");
                    Row { why_not: Some(why), ..empty(info.saving) }
                }
                row => row?,
            },
        };
        told(&row);
        rows.push(row);
    }
    Ok(rows)
}

fn empty(saving: Saving) -> Row {
    Row {
        saving,
        why_not: None,
        seconds: [[0.0; 3]; 2],
        ratio: f64::NAN,
        spread: [f64::NAN; 2],
        differing: (0, 0.0),
        device: String::new(),
    }
}

fn render(job: &Job, savings: Savings, most_seconds: f64) -> Result<Outcome, JobError> {
    let mut job = job.clone();
    job.compile.savings = savings;
    let (cancel, (done, is_done)) = (AtomicBool::new(false), mpsc::channel::<()>());
    std::thread::scope(|s| {
        let cancel = &cancel;
        s.spawn(move || {
            if is_done.recv_timeout(Duration::from_secs_f64(most_seconds)) == Err(RecvTimeoutError::Timeout) {
                cancel.store(true, Ordering::Relaxed);
            }
        });
        let outcome = crate::job::run(&job, &Quiet, cancel);
        drop(done);
        outcome
    })
}

/// One saving, off and on in turn.
fn measured(job: &Job, saving: Saving, rounds: usize, first: &Outcome, most_seconds: f64) -> Result<Row, JobError> {
    let mut job = job.clone();
    if is_of_gpu(saving) {
        job.backend = BackendChoice::Gpu;
    }
    let mut seconds: [Vec<[f64; 3]>; 2] = Default::default();
    let mut films: [Option<Film>; 2] = [None, None];
    let mut device = String::new();
    for round in 0..rounds.max(1) {
        // Whoever comes first finds cold caches: each does every other time.
        for k in [round % 2, 1 - round % 2] {
            let on = k == 1;
            let savings = if on { Savings::ALL } else { Savings::ALL.without(saving) };
            let outcome = if saving == Saving::Frames {
                // The second of two frames counts.
                let mut frames = job.clone();
                frames.compile.trees = on.then(Arc::<TreeStore>::default);
                render(&frames, savings, most_seconds)?;
                render(&frames, savings, most_seconds)?
            } else {
                render(&job, savings, most_seconds)?
            };
            let by_cpu = outcome.cpu_seconds.iter().all(|s| s.is_finite());
            let all = if by_cpu { outcome.cpu_seconds } else { outcome.seconds };
            seconds[k].push([all[0], all[1], all[2]]);
            device = outcome.device;
            films[k].get_or_insert(outcome.film);
        }
    }
    let why_not = (is_of_gpu(saving) && device == first.device).then(|| "the GPU does not render this scene".to_owned());
    let sum = |s: &[f64; 3]| s.iter().sum::<f64>();
    let mut ratios: Vec<f64> = seconds[0].iter().zip(&seconds[1]).map(|(off, on)| sum(off) / sum(on).max(1e-9)).collect();
    ratios.sort_by(f64::total_cmp);
    let [Some(off), Some(on)] = &films else { return Ok(empty(saving)) };
    Ok(Row {
        saving,
        why_not,
        seconds: seconds.each_ref().map(|list| std::array::from_fn(|k| median(list.iter().map(|s| s[k])))),
        ratio: median(ratios.iter().copied()),
        spread: [ratios[0], ratios[ratios.len() - 1]],
        differing: differing(off, on),
        device,
    })
}

/// Values that are not the same to the last bit, and the largest difference.
fn differing(a: &Film, b: &Film) -> (usize, f32) {
    let pairs = a.pixels.iter().flatten().zip(b.pixels.iter().flatten());
    pairs.filter(|(a, b)| a.to_bits() != b.to_bits()).fold((0, 0.0), |(n, most), (a, b)| (n + 1, f32::max(most, (a - b).abs())))
}

/// Hears nothing.
struct Quiet;

impl Listener for Quiet {
    fn stage(&self, _: &Stage) {}
    fn diagnostic(&self, _: &Diagnostic, _: &SourceMap) {}
    fn text(&self, _: Stream, _: &str) {}
    fn pixels(&self, _: u64, _: u64) {}
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_saving_that_changes_the_picture_is_found() {
        let mut a = Film::new(2, 1);
        let b = a.clone();
        assert_eq!(differing(&a, &b), (0, 0.0));
        a.pixels[1][2] = 0.25;
        assert_eq!(differing(&a, &b), (1, 0.25));
        let row = |saving| Row { differing: differing(&a, &b), ..empty(saving) };
        assert!(!row(Saving::Lights).holds() && row(Saving::Antialias).holds());
        assert!(Row { why_not: Some("it is not there".into()), ..row(Saving::Lights) }.holds());
    }
}
