//! `rayloom bench stages`: where a card's time goes in POV-Ray's light transport.

use super::skip::Errors;
use crate::cli::render::{RenderArgs, jobs};
use clap::Args;
use rayloom::job::JobError;
use std::process::ExitCode;

/// Arguments of `rayloom bench stages`.
#[derive(Debug, Args)]
pub(super) struct StagesArgs {
    /// Renderers in software too
    #[arg(long)]
    software: bool,
    #[command(flatten)]
    render: RenderArgs,
}

/// Runs it.
#[cfg(feature = "gpu")]
pub(super) fn run(args: &StagesArgs) -> Result<ExitCode, JobError> {
    use rayloom::backend::gpu::{GpuBackend, GpuOptions};
    use rayloom::backend::{Backend, BackendError};
    let job = jobs(&args.render)?.into_iter().next().ok_or_else(|| JobError::Options("there is no frame to render".into()))?;
    let (scene, _) = rayloom::bench::compiled(&job, &Errors)?;
    let failed = |error: BackendError| JobError::Device { error, saved: None };
    let gpu = GpuBackend::new(&GpuOptions { accept_software: args.software, name_contains: job.gpu.clone() }).map_err(failed)?;
    let times = gpu.measure_stages(&scene, &job.render).map_err(failed)?;
    let on_device: f64 = times.stages.iter().map(|s| s.seconds).sum();
    println!(
        "{:<16} {:>10} {:>10} {:>14} {:>10} {:>8} {:>8}",
        "stage", "compiled s", "dispatches", "threads", "seconds", "percent", "ns each"
    );
    for s in &times.stages {
        let (share, each) = (100.0 * s.seconds / times.render_seconds, 1e9 * s.seconds / s.threads.max(1) as f64);
        println!(
            "{:<16} {:>10.2} {:>10} {:>14} {:>10.4} {:>8.1} {:>8.2}",
            s.name, s.compile_seconds, s.dispatches, s.threads, s.seconds, share, each
        );
    }
    let rest = (times.render_seconds - on_device).max(0.0);
    println!("{:<16} {:>10} {:>10} {:>14} {:>10.4} {:>8.1}", "host and waiting", "", "", "", rest, 100.0 * rest / times.render_seconds);
    println!("{:.4} s rendering, {:.4} s preparing before it, {}", times.render_seconds, times.prepare_seconds, gpu.name());
    Ok(ExitCode::SUCCESS)
}

/// Says why not.
#[cfg(not(feature = "gpu"))]
pub(super) fn run(args: &StagesArgs) -> Result<ExitCode, JobError> {
    let _ = (args.software, jobs(&args.render)?, Errors);
    crate::cli::console::print_error("this program was built without the GPU back end");
    Ok(ExitCode::from(5))
}
