//! The GPU against the CPU: whole pictures, and shader functions element by element.
//! Skipped with a line where no adapter exists, unless `RAYLOOM_REQUIRE_GPU=1`.
#![cfg(feature = "gpu")]

mod lost;
mod paths;
mod paths_bodies;
mod pictures;
mod pipelines;
mod probes;
mod probes_texture;
mod structures;

/// What stands on a device: missing is a failure only where one is required.
fn found<T, E: std::fmt::Display>(device: Result<T, E>) -> Option<T> {
    match device {
        Ok(device) => Some(device),
        Err(e) if std::env::var_os("RAYLOOM_REQUIRE_GPU").is_some_and(|v| v == "1") => panic!("RAYLOOM_REQUIRE_GPU is set: {e}"),
        Err(e) => {
            println!("skipped: {e}");
            None
        }
    }
}
