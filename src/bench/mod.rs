//! Measurements that a user can repeat on their own machine: `rayloom bench`.

pub mod accel;
mod chart;
pub mod embree;
pub mod error_time;
pub mod peer_scene;
mod rays;
pub mod skip;
pub mod stability;

pub use chart::{Line, bar_chart, log_chart};
pub use rays::{RAY_KINDS, RaySets};

/// The one in the middle; NaN for none.
fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut list: Vec<f64> = values.collect();
    list.sort_by(f64::total_cmp);
    let n = list.len();
    if n == 0 { f64::NAN } else { 0.5 * (list[(n - 1) / 2] + list[n / 2]) }
}
