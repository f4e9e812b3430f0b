//! stub
/// s
#[derive(Debug, clap::Args)]
pub struct DiffArgs {}
/// s
pub fn run(_a: DiffArgs) -> std::process::ExitCode {
    std::process::ExitCode::SUCCESS
}
