//! stub
/// s
#[derive(Debug, clap::Args)]
pub struct MergeArgs {}
/// s
pub fn run(_a: MergeArgs) -> std::process::ExitCode {
    std::process::ExitCode::SUCCESS
}
