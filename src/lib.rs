//! rayloom: an offline renderer for POV-Ray scenes and Blender exports.
//!
//! The modules are rooms with ranks: a module imports lower ranks only (ARCHITECTURE.md follows a scene through them,
//! `tests/tidy.rs` checks the ranks).

pub mod cpu_time;
pub mod math;
pub mod memory;
pub mod savings;
pub mod user_folders; // rank 0

pub mod accel;
pub mod diag; // rank 1

pub mod world; // rank 2

pub mod scene; // rank 3

pub mod import;
pub mod lang; // rank 4

pub mod compile; // rank 6

pub mod film;
pub mod kernel; // rank 7

pub mod denoise;
pub mod integrate; // rank 8

pub mod backend; // rank 9

pub mod bench;
pub mod compare; // rank 10

pub mod job;
pub mod suite; // rank 11
