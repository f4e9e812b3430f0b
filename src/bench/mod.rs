//! Measurements that a user can repeat on their own machine: `rayloom bench`.

pub mod accel;
mod chart;
pub mod embree;
pub mod error_time;
pub mod peer_scene;
mod rays;
pub mod skip;
pub mod stability;

use crate::compile::{CompiledScene, compile_scene};
use crate::diag::{Sink, SourceMap};
use crate::job::{Job, JobError, Listener};
use crate::scene::Unread;

pub use chart::{Line, bar_chart, log_chart};
pub use rays::{RAY_KINDS, RaySets};

/// A job's scene as compiled, and what its reader left out; findings go to `listener`.
///
/// # Errors
/// The scene cannot be read or compiled.
pub fn compiled(job: &Job, listener: &dyn Listener) -> Result<(CompiledScene, Unread), JobError> {
    let (mut map, mut sink) = (SourceMap::default(), Sink::default());
    let loaded = crate::job::load_job(job, &mut map, &mut sink, listener);
    sink.drain().iter().for_each(|d| listener.diagnostic(d, &map));
    let scene = loaded?;
    Ok((compile_scene(&scene, &job.compile)?, scene.unread))
}

/// The one in the middle; NaN for none.
fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut list: Vec<f64> = values.collect();
    list.sort_by(f64::total_cmp);
    let n = list.len();
    if n == 0 { f64::NAN } else { 0.5 * (list[(n - 1) / 2] + list[n / 2]) }
}
