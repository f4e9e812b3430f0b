//! The command line: one file a subcommand, each with its arguments and its `run`.

mod bench;
mod console;
mod denoise;
mod denoise_args;
mod diff;
mod diff_outcome;
mod info;
mod interrupt;
mod live;
mod merge;
mod povray;
mod progress;
mod render;
mod render_listener;
mod suite;

use clap::{Parser, Subcommand};
use std::process::ExitCode;

/// Stack of the thread that does the work: scenes nest, and so does their parser. Only touched pages cost memory.
const STACK_BYTES: usize = 1 << 30;

/// An offline renderer for POV-Ray scenes and Blender exports, on the CPU and the GPU.
#[derive(Debug, Parser)]
#[command(name = "rayloom", version, arg_required_else_help = true, after_help = EXIT_CODES)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

const EXIT_CODES: &str = "Exit codes: 0 done, 1 internal fault, 2 usage, 3 scene error, 4 file error, 5 device error, 130 interrupted.\n\
    `rayloom povray` keeps POV-Ray's own: 0 done, 1 error, 2 interrupted. `rayloom diff`, `rayloom suite`: 0 same, 1 warn, 2 different, 4 unreadable.";

#[derive(Debug, Subcommand)]
enum Command {
    /// Renders a scene: .pov, .ini, .glb, .gltf or .obj
    Render(Box<render::RenderArgs>),
    /// Renders with POV-Ray's own options: +Iscene.pov +Oout.png +W640 +H480 +A0.3
    #[command(disable_help_flag = true)]
    Povray(povray::PovrayArgs),
    /// Compares two pictures, or two folders of them
    Diff(diff::DiffArgs),
    /// Denoises a picture that was rendered before
    Denoise(denoise::DenoiseArgs),
    /// Joins parts of a picture that were rendered apart
    Merge(merge::MergeArgs),
    /// Renders the scenes of a suite and holds them against their reference pictures
    Suite(suite::SuiteArgs),
    /// Measures this machine
    Bench(bench::BenchArgs),
    /// Says what this machine offers, or what a scene uses
    Info(info::InfoArgs),
}

/// Reads the arguments and does what they ask for.
pub fn run() -> ExitCode {
    let command = match Cli::try_parse() {
        Ok(cli) => cli.command,
        Err(e) => {
            let _ = e.print();
            return ExitCode::from(if e.use_stderr() { 2 } else { 0 });
        }
    };
    let work = move || match command {
        Command::Render(args) => render::run(&args),
        Command::Povray(args) => povray::run(&args),
        Command::Diff(args) => diff::run(args),
        Command::Denoise(args) => denoise::run(&args),
        Command::Merge(args) => merge::run(args),
        Command::Suite(args) => suite::run(&args),
        Command::Bench(args) => bench::run(&args),
        Command::Info(args) => info::run(&args),
    };
    // A panic is our fault: exit code 1 with its message, never a signal.
    match std::thread::Builder::new().name("rayloom".into()).stack_size(STACK_BYTES).spawn(work) {
        Ok(worker) => worker.join().unwrap_or(ExitCode::from(1)),
        Err(e) => {
            eprintln!("rayloom: no thread could be started: {e}");
            ExitCode::from(1)
        }
    }
}
