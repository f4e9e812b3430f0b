//! Which machine renders, and what is told when it is not the one asked for.

use super::{Job, Listener, Pixels, Stage};
use crate::backend::cpu::CpuBackend;
use crate::backend::{Backend, BackendError};
use crate::compile::CompiledScene;
use crate::diag::Sink;
use crate::film::Film;
use std::sync::atomic::AtomicBool;

/// Which machine the user wants.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum BackendChoice {
    /// A real GPU that can render the scene, else the CPU.
    #[default]
    Auto,
    /// The CPU.
    Cpu,
    /// A GPU, real or in software; without one an error, and scenes that it cannot render go to the CPU with a note.
    Gpu,
}

/// Renders on the machine that the job asks for; `device` gets its name.
pub(super) fn render(
    job: &Job,
    scene: &CompiledScene,
    film: &mut Film,
    device: &mut String,
    sink: &mut Sink,
    listener: &dyn Listener,
    cancel: &AtomicBool,
) -> Result<(), BackendError> {
    let mut on = |machine: &dyn Backend, film: &mut Film| {
        *device = machine.name();
        let resumed_pixels = film.samples.iter().filter(|n| **n > 0).count() as u64;
        listener.stage(&Stage::Rendering { device: machine.name(), resumed_pixels });
        machine.render(scene, &job.render, film, &Pixels(listener), cancel)
    };
    if job.backend != BackendChoice::Cpu {
        match gpu(job.backend) {
            Ok(machine) => match on(machine.as_ref(), film) {
                Err(BackendError::Unsupported(what)) => {
                    sink.note_once("fallback", None, format!("rendered on the CPU: the GPU back end does not do {what} yet"))
                }
                result => return result,
            },
            Err(error) if job.backend == BackendChoice::Gpu => return Err(error),
            Err(_) => {}
        }
    }
    for d in sink.drain() {
        listener.diagnostic(&d, &crate::diag::SourceMap::default());
    }
    on(&CpuBackend::new(job.render.threads), film)
}

/// A GPU: for `auto` a real one only, since software drivers are slower than the CPU back end.
fn gpu(_choice: BackendChoice) -> Result<Box<dyn Backend>, BackendError> {
    Err(BackendError::NoDevice("this build has no GPU back end".into()))
}
