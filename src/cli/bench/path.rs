//! `rayloom bench path`: samples a second of path tracing on a GPU.

use clap::Args;
use rayloom::accel::AccelKind;
use rayloom::job::JobError;
use std::path::PathBuf;
use std::process::ExitCode;

/// Arguments of `rayloom bench path`.
#[derive(Debug, Args)]
pub(super) struct PathArgs {
    /// Model (.glb, .gltf, .obj)
    scene: PathBuf,
    /// Picture
    #[arg(long, value_name = "WxH", default_value = "1024x1024", value_parser = crate::cli::render::parse_size)]
    size: (u32, u32),
    /// Samples a pixel
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    spp: u32,
    /// Pictures after the warm-up
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u32).range(1..=1000))]
    repeats: u32,
    /// Structure over the geometry (docs/gpu.md)
    #[arg(long, default_value = "auto", value_parser = clap::builder::PossibleValuesParser::new(AccelKind::names()))]
    accel: String,
    /// Renderers in software too
    #[arg(long)]
    software: bool,
}

/// Runs it.
#[cfg(feature = "gpu")]
pub(super) fn run(args: &PathArgs) -> Result<ExitCode, JobError> {
    use rayloom::backend::gpu::{GpuBackend, GpuOptions};
    use rayloom::backend::{Backend, BackendError};
    use rayloom::compile::{CompileOptions, compile_scene};
    use rayloom::diag::Sink;
    use rayloom::import::ImportOptions;
    use rayloom::integrate::{IntegratorKind, RenderSettings};
    let (width, height) = args.size;
    let mut sink = Sink::default();
    let options = ImportOptions { aspect: f64::from(width) / f64::from(height), ..ImportOptions::default() };
    let scene = rayloom::import::load(&args.scene, &options, &mut sink)?;
    let accel = AccelKind::named(&args.accel).unwrap_or(AccelKind::Auto);
    let compiled = compile_scene(&scene, &CompileOptions { accel, ..CompileOptions::default() })?;
    let settings = RenderSettings { integrator: IntegratorKind::Path, samples: 0..args.spp, ..RenderSettings::plain(width, height) };
    let failed = |error: BackendError| JobError::Device { error, saved: None };
    let gpu = GpuBackend::new(&GpuOptions { accept_software: args.software, ..GpuOptions::default() }).map_err(failed)?;
    let t = gpu.measure_paths(&compiled, &settings, args.repeats).map_err(failed)?;
    let median = t.seconds[(t.seconds.len() - 1) / 2];
    let rate = f64::from(width) * f64::from(height) * f64::from(args.spp) / median * 1e-6;
    let name = args.scene.file_stem().unwrap_or_default().to_string_lossy();
    println!(
        "{name}: {width}x{height} {} spp median {median:.4} s = {rate:.1} Msamples/s (of {}: {:.4}..{:.4} s) mean {:.6}, prepared in {:.2} s, {}",
        args.spp,
        args.repeats,
        t.seconds[0],
        t.seconds[t.seconds.len() - 1],
        t.mean,
        t.prepare_seconds,
        gpu.name()
    );
    Ok(ExitCode::SUCCESS)
}

/// Says why not.
#[cfg(not(feature = "gpu"))]
pub(super) fn run(_: &PathArgs) -> Result<ExitCode, JobError> {
    crate::cli::console::print_error("this program was built without the GPU back end");
    Ok(ExitCode::from(5))
}
