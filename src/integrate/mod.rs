//! Light transport: `classic` is POV-Ray's, `path` is unbiased. Neither knows which machine the rest of the picture runs on.

pub mod antialias;
pub mod block_memo;
pub mod classic;
pub mod path;
pub mod samples;

use crate::scene::PassSet;

/// POV-Ray's antialiasing. Source: spec/light.md, section 12.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Antialias {
    /// 1 or 2.
    pub method: u8,
    /// Difference that asks for more samples.
    pub threshold: f32,
    /// 1..=9.
    pub depth: u8,
    /// 0..=1; 0 for none.
    pub jitter: f64,
    /// Encoding of the compared colours.
    pub gamma: f32,
}

/// Which light transport.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum IntegratorKind {
    /// POV-Ray's.
    Classic,
    /// Unbiased path tracing.
    Path,
}

/// When the samples of a pixel are enough (path integrator).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoiseLimit {
    /// Error that a pixel may keep: of the sum of its channels, over the root of that sum. Above 0.
    pub threshold: f32,
    /// Fewest samples; 0: by the threshold.
    pub min_samples: u32,
}

/// What to render of a compiled scene, and how.
#[derive(Clone, Debug)]
pub struct RenderSettings {
    /// Columns of the whole picture.
    pub width: u32,
    /// Rows of the whole picture.
    pub height: u32,
    /// Left, top, right, bottom of the part to render; right and bottom exclusive.
    pub crop: [u32; 4],
    /// POV-Ray's antialiasing (classic), if any.
    pub antialias: Option<Antialias>,
    /// Samples a pixel (path, and classic for imports), first and one past the last: ranges add up.
    pub samples: std::ops::Range<u32>,
    /// Light transport.
    pub integrator: IntegratorKind,
    /// Threads; the picture does not depend on it.
    pub threads: usize,
    /// Where a picture depends on the order of rays, they run as POV-Ray's do with one thread, on one core. Otherwise blocks of the
    /// picture have random streams of their own, and run side by side.
    pub in_order: bool,
    /// Seed of random streams.
    pub seed: u32,
    /// Background is transparent.
    pub output_alpha: bool,
    /// Side of the blocks that pixels are rendered in (POV-Ray's `+BS`, 32): decides antialiasing at block borders.
    pub block_size: u32,
    /// Passes besides the colours (path); the film has a layer for each.
    pub passes: PassSet,
    /// Pixels below this noise get no more samples (path); none: all get all.
    pub noise: Option<NoiseLimit>,
    /// All pixels get few samples, then more (path), so that the picture so far is one at any time.
    pub in_rounds: bool,
    /// Rendering ends after so long (path), but not before every pixel has a sample.
    pub time_limit: Option<std::time::Duration>,
    /// Only what guides a denoiser (path): samples end where that is known, and have no colour.
    pub features_only: bool,
}

impl RenderSettings {
    /// The whole of a picture, one sample in the middle of each pixel, one thread, POV-Ray's light transport.
    pub fn plain(width: u32, height: u32) -> Self {
        Self {
            width,
            height,
            crop: [0, 0, width, height],
            antialias: None,
            samples: 0..1,
            integrator: IntegratorKind::Classic,
            threads: 1,
            in_order: true,
            seed: 0,
            output_alpha: false,
            block_size: 32,
            passes: PassSet::NONE,
            noise: None,
            in_rounds: false,
            time_limit: None,
            features_only: false,
        }
    }
}
