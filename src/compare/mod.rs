//! Two pictures of the same thing: how far apart they are, in numbers and as a heat map. Knows files and pixels, no scenes.

mod heatmap;
mod layers;
mod metrics;
mod noise;
mod perceived;
mod picture;
mod ssim;
mod verdict;

pub use heatmap::{difference_map, flip_map};
pub use layers::read_layers;
pub use metrics::{CompareOptions, Flip, Largest, Metrics, Space, compare};
pub use noise::{Estimate, ZTest, normal_quantile, z_test};
pub use picture::{DEFAULT_MAX_PIXELS, Picture, PictureError};
pub use verdict::{Tolerance, Verdict};
