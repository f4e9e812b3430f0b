//! `rayloom bench`: measurements on this machine.

mod accel;
mod embree;
mod error_time;
mod path;
mod skip;
mod stability;
mod stages;

use super::console::print_error;
use clap::{Args, Subcommand};
use rayloom::job::JobError;
use std::process::ExitCode;

/// Arguments of `rayloom bench`.
#[derive(Debug, Args)]
pub struct BenchArgs {
    #[command(subcommand)]
    what: What,
}

#[derive(Debug, Subcommand)]
enum What {
    /// Every acceleration structure on every device: build time, memory, work a ray, rays a second (docs/gpu.md)
    Accel(accel::AccelArgs),
    /// Path tracing on the GPU: samples a second of whole pictures, without loading, building and compiling (docs/path.md)
    Path(path::PathArgs),
    /// Error against time over sample counts, in turn with another renderer (docs/benchmarks.md)
    ErrorTime(error_time::ErrorTimeArgs),
    /// What is left out where a scene does not need it: each saving off and on in turn, pixels compared (docs/benchmarks.md)
    Skip(Box<skip::SkipArgs>),
    /// Where a GPU's time goes in POV-Ray's light transport: each kernel's dispatches, threads and seconds (docs/gpu.md)
    Stages(Box<stages::StagesArgs>),
    /// Where renderers break: 24 cases, each a figure against its bar, on the CPU and every GPU (docs/stability.md)
    Stability(stability::StabilityArgs),
}

/// Runs it.
pub fn run(args: &BenchArgs) -> ExitCode {
    let result = match &args.what {
        What::Accel(args) => accel::run(args),
        What::Path(args) => path::run(args),
        What::ErrorTime(args) => error_time::run(args),
        What::Skip(args) => skip::run(args),
        What::Stages(args) => stages::run(args),
        What::Stability(args) => stability::run(args),
    };
    match result {
        Ok(code) => code,
        Err(e) => {
            if !matches!(e, JobError::Scene) {
                print_error(&e.to_string());
            }
            ExitCode::from(e.exit_code())
        }
    }
}
