//! Measurements that a user can repeat on their own machine: `rayloom bench`.

pub mod accel;
mod chart;
mod rays;
pub mod stability;

pub use chart::bar_chart;
pub use rays::{RAY_KINDS, RaySets};
