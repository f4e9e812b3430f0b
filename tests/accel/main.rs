//! The trees against brute force, with broken trees that must be caught, garbage, and closed meshes that must not leak.
//!
//! Scenes are small enough for every ray to be held against every primitive; the larger ones sample their rays.

mod broken;
mod garbage;
mod geometry;
mod oracle;
mod rays;
mod scene;
mod trees;
mod watertight;
