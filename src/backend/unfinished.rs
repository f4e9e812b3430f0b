//! What of a picture is still to be rendered, and how samples get into it: the same for every machine.

use crate::film::{Film, PixelSamples};
use crate::integrate::RenderSettings;
use crate::integrate::antialias::{Block, Sample, blocks};

/// The blocks that do not hold all their samples, emptied, and the number of pixels in the others.
///
/// Blocks are rendered whole, so that antialiasing sees the neighbours that it saw before.
pub fn unfinished_blocks(film: &mut Film, settings: &RenderSettings) -> (Vec<Block>, u64) {
    let wanted = settings.samples.len().max(1) as u32;
    let (mut unfinished, mut n_finished) = (Vec::new(), 0);
    for block in blocks(settings.crop, settings.block_size) {
        let [x0, y0, x1, y1] = block;
        if (y0..y1).all(|y| (x0..x1).all(|x| film.samples[film.index(x, y)] >= wanted)) {
            n_finished += u64::from(x1 - x0) * u64::from(y1 - y0);
        } else {
            clear(film, block);
            unfinished.push(block);
        }
    }
    (unfinished, n_finished)
}

/// Takes all samples out of a block.
pub(super) fn clear(film: &mut Film, [x0, y0, x1, y1]: Block) {
    for y in y0..y1 {
        film.clear(film.index(x0, y)..film.index(x1 - 1, y) + 1);
    }
}

/// Joins the mean of `n` samples to those that a pixel of a film without passes has. A colour that is no number counts as black, or it
/// would spread.
pub(super) fn add_samples(film: &mut Film, at: usize, color: Sample, n: u32) {
    let [.., alpha] = color;
    let color = if color.iter().all(|v| v.is_finite()) { color } else { [0.0, 0.0, 0.0, if alpha.is_finite() { alpha } else { 1.0 }] };
    film.join(at, PixelSamples { color, layers: &[], n, earlier: false });
}
