//! Two pictures of the same thing: how far apart they are, in numbers and as a heat map. Knows files and pixels, no scenes.

mod heatmap;
mod metrics;
mod picture;
mod verdict;

pub use heatmap::{difference_map, flip_map};
pub use metrics::{Largest, Metrics, compare};
pub use picture::{DEFAULT_MAX_PIXELS, Picture, PictureError};
pub use verdict::{Tolerance, Verdict};
