//! Measurements that a user can repeat on their own machine: `rayloom bench`.

pub mod accel;
mod chart;
pub mod error_time;
mod rays;
pub mod stability;

pub use chart::{Line, bar_chart, log_chart};
pub use rays::{RAY_KINDS, RaySets};
