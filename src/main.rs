//! The `rayloom` program: arguments, printing, exit codes. What it does stands in the library.

mod cli;

fn main() -> std::process::ExitCode {
    cli::run()
}
