//! Whether a picture is worth a GPU: opening one and compiling the scene's shaders takes seconds, in which the CPU is done with many a picture.

use super::Job;
use crate::backend::Backend;
use crate::backend::cpu::CpuBackend;
use crate::compile::CompiledScene;
use crate::cpu_time;
use crate::film::Film;
use crate::integrate::classic::ScenePlan;
use crate::integrate::{IntegratorKind, RenderSettings};
use crate::scene::PassSet;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// Seconds of the CPU that a picture must take. An H100 is opened in 0.4 s and has compiled a scene's shaders in 1 to 5
/// (benches/results/accel_h100.md).
const WORTH_A_GPU: f64 = 4.0;
/// The picture that is timed has one pixel of so many, along each side.
const SHRINK: u32 = 16;

/// Samples that path tracing must take: a core needs about a microsecond each, and trying some would build trees that a GPU doesn't need.
const WORTH_SAMPLES: u64 = 1 << 22;

/// Whether `auto` shall ask for a GPU that can render the scene. Not where the job asks for random numbers in POV-Ray's own order.
pub(super) fn worth_a_gpu(job: &Job, scene: &CompiledScene, film: &Film, cancel: &AtomicBool) -> bool {
    match job.render.integrator {
        IntegratorKind::Path => n_lacking(&job.render, film) * job.render.samples.len() as u64 >= WORTH_SAMPLES,
        IntegratorKind::Classic if job.render.in_order && ScenePlan::needs_ordered_rays(scene) => false,
        IntegratorKind::Classic => cpu_seconds(&job.render, scene, film, cancel) > WORTH_A_GPU,
    }
}

/// Pixels that have not all their samples.
fn n_lacking(settings: &RenderSettings, film: &Film) -> u64 {
    let [x0, y0, x1, y1] = settings.crop;
    let wanted = settings.samples.len().max(1) as u32;
    (y0..y1).flat_map(|y| (x0..x1).map(move |x| (x, y))).filter(|(x, y)| film.samples[film.index(*x, *y)] < wanted).count() as u64
}

/// About how long the CPU needs for what the film lacks: a picture of a 256th of the pixels is rendered and thrown away.
fn cpu_seconds(settings: &RenderSettings, scene: &CompiledScene, film: &Film, cancel: &AtomicBool) -> f64 {
    let (width, height) = (settings.width.div_ceil(SHRINK), settings.height.div_ceil(SHRINK));
    let small = RenderSettings {
        width,
        height,
        crop: [0, 0, width, height],
        samples: 0..1,
        // Enough blocks for all cores.
        block_size: 8,
        passes: PassSet::NONE,
        noise: None,
        in_rounds: false,
        time_limit: None,
        ..settings.clone()
    };
    let n_samples = settings.samples.len().max(1);
    let (clock, work) = (Instant::now(), cpu_time::process_seconds());
    // What goes wrong goes wrong again, and is told then.
    let _ = CpuBackend::new(settings.threads).render(scene, &small, &mut Film::new(width, height), &(), cancel);
    let work = (cpu_time::process_seconds() - work) / settings.threads.max(1) as f64;
    let seconds = if work.is_nan() { clock.elapsed().as_secs_f64() } else { work };
    seconds * n_lacking(settings, film) as f64 * n_samples as f64 / (f64::from(width) * f64::from(height))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compile::{CompileOptions, compile_scene};
    use crate::scene::Scene;

    #[test]
    fn what_is_there_already_costs_nothing() {
        let scene = compile_scene(&Scene::default(), &CompileOptions::default()).expect("nothing to go wrong");
        let (settings, cancel) = (RenderSettings::plain(320, 240), AtomicBool::new(false));
        let mut film = Film::new(320, 240);
        assert!(cpu_seconds(&settings, &scene, &film, &cancel) > 0.0);
        film.samples.fill(1);
        assert_eq!(cpu_seconds(&settings, &scene, &film, &cancel), 0.0);
    }
}
