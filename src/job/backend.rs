//! Which machine renders, and what is told when it is not the one asked for.

use super::{Job, Listener, Outcome, Pixels, Stage, tell};
use crate::backend::cpu::CpuBackend;
use crate::backend::{Backend, BackendError};
use crate::compile::CompiledScene;
use crate::diag::{Sink, SourceMap};
use crate::film::Film;
use crate::integrate::IntegratorKind;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// Which machine the user wants.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum BackendChoice {
    /// A real GPU that can render the scene, where the CPU would take seconds (`estimate`); else the CPU.
    #[default]
    Auto,
    /// The CPU.
    Cpu,
    /// A GPU, real or in software; without one an error, and scenes that it cannot render go to the CPU with a note.
    Gpu,
}

/// Renders on the machine that the job asks for; `outcome` gets its name and what it counted.
pub(super) fn render(
    job: &Job,
    scene: &CompiledScene,
    film: &mut Film,
    outcome: &mut Outcome,
    sink: &mut Sink,
    map: &SourceMap,
    listener: &dyn Listener,
    cancel: &AtomicBool,
) -> Result<(), BackendError> {
    // The limit is that of machines that have none of their own.
    let pixels = Pixels::new(listener);
    let device = &mut outcome.device;
    let mut on = |machine: &dyn Backend, film: &mut Film, limit: Option<Duration>| {
        *device = machine.name();
        let resumed_pixels = film.samples.iter().filter(|n| **n > 0).count() as u64;
        listener.stage(&Stage::Rendering { device: machine.name(), resumed_pixels });
        match limit {
            None => machine.render(scene, &job.render, film, &pixels, cancel),
            Some(limit) => super::timed::render(machine, scene, &job.render, limit, film, &pixels, cancel),
        }
    };
    if job.render.integrator == IntegratorKind::Path {
        for (key, what) in crate::integrate::path::left_out(scene) {
            sink.note_once(key, None, what);
        }
    }
    // Guides of the denoiser alone are made on the CPU afterwards.
    let cpu_only = job.passes.is_some_and(|p| !p.is_empty()).then_some("passes");
    if let (Some(what), true) = (cpu_only, job.backend == BackendChoice::Gpu) {
        tell_fallback(what, sink);
    }
    let wanted = cpu_only.is_none()
        && match job.backend {
            BackendChoice::Cpu => false,
            BackendChoice::Gpu => true,
            BackendChoice::Auto => {
                may_have_hardware() && gpu_takes(job, scene, sink) && {
                    *job.worth_a_gpu.get_or_init(|| super::estimate::worth_a_gpu(job, scene, film, cancel))
                }
            }
        };
    if wanted {
        let layers = std::mem::take(&mut film.layers);
        let result = gpu(job.backend, &job.gpu)
            .and_then(|machine| {
                on(machine.as_ref(), film, job.render.time_limit)?;
                Ok(machine.differs(scene, &job.render))
            })
            .and_then(|differs| match layers.is_empty() {
                true => Ok(differs),
                false => {
                    let cpu = CpuBackend::new(job.render.threads);
                    super::denoise::render_guides(job, film, |settings, guides| cpu.render(scene, settings, guides, &(), cancel))?;
                    Ok(differs)
                }
            });
        match (result, job.backend) {
            (Ok(differs), _) => {
                if let Some(what) = differs {
                    sink.note_once("gpu differs", None, what);
                }
                return Ok(());
            }
            (Err(BackendError::Unsupported(what)), _) => tell_fallback(&what, sink),
            (Err(error @ BackendError::TooLarge { .. }), BackendChoice::Auto) => {
                sink.note_once("fallback", None, format!("rendered on the CPU: {error}"));
            }
            (Err(BackendError::NoDevice(_)), BackendChoice::Auto) => {}
            (Err(error), _) => return Err(error),
        }
    }
    if film.layer_width() == 0 && !job.render.passes.is_empty() {
        film.layers = Film::with_passes(film.width, film.height, job.render.passes).layers;
    }
    tell(sink, map, listener);
    on(&CpuBackend::new(job.render.threads), film, None)?;
    outcome.photons = pixels.photons();
    Ok(())
}

/// A GPU: for `auto` a real one only, since software drivers are slower than the CPU back end.
#[cfg(feature = "gpu")]
fn gpu(choice: BackendChoice, name: &str) -> Result<Box<dyn Backend>, BackendError> {
    use crate::backend::gpu::{GpuBackend, GpuOptions};
    let accept_software = choice == BackendChoice::Gpu;
    Ok(Box::new(GpuBackend::new(&GpuOptions { accept_software, name_contains: name.to_owned() })?))
}

/// Whether a graphics card can be there at all: asking the drivers takes longer than many pictures (measured: 70 to 280 ms), and on
/// Linux every card has a device file.
#[cfg(feature = "gpu")]
fn may_have_hardware() -> bool {
    let exists = |p: &str| std::path::Path::new(p).exists();
    let has_render_node =
        || std::fs::read_dir("/dev/dri").is_ok_and(|d| d.flatten().any(|e| e.file_name().to_string_lossy().starts_with("render")));
    !cfg!(target_os = "linux") || exists("/dev/nvidia0") || exists("/dev/dxg") || has_render_node()
}

/// Whether the GPU back end does all that the scene uses; told if not. Of path tracing that is found out when it begins.
#[cfg(feature = "gpu")]
fn gpu_takes(job: &Job, scene: &CompiledScene, sink: &mut Sink) -> bool {
    if job.render.integrator == IntegratorKind::Path {
        return true;
    }
    let obstacle = crate::backend::gpu::check(scene).err();
    if let Some(BackendError::Unsupported(what)) = &obstacle {
        tell_fallback(what, sink);
    }
    obstacle.is_none()
}

fn tell_fallback(what: &str, sink: &mut Sink) {
    sink.note_once("fallback", None, format!("rendered on the CPU: the GPU back end does not do {what} yet"));
}

#[cfg(not(feature = "gpu"))]
fn may_have_hardware() -> bool {
    false
}

#[cfg(not(feature = "gpu"))]
fn gpu_takes(_job: &Job, _scene: &CompiledScene, _sink: &mut Sink) -> bool {
    false
}

#[cfg(not(feature = "gpu"))]
fn gpu(_choice: BackendChoice, _name: &str) -> Result<Box<dyn Backend>, BackendError> {
    Err(BackendError::NoDevice("this program was built without the GPU back end".into()))
}
