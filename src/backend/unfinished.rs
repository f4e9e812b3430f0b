//! What of a picture is still to be rendered, and how samples get into it: the same for every machine.

use crate::film::{Film, PixelSamples};
use crate::integrate::RenderSettings;
use crate::integrate::antialias::{Block, Sample, blocks};
#[cfg(feature = "gpu")]
use crate::integrate::block_memo::BlockMemo;
#[cfg(feature = "gpu")]
use rayon::prelude::*;

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

/// A colour; one that is no number counts as black, or it would spread.
fn finite(color: Sample) -> Sample {
    let [.., alpha] = color;
    if color.iter().all(|v| v.is_finite()) { color } else { [0.0, 0.0, 0.0, if alpha.is_finite() { alpha } else { 1.0 }] }
}

/// Joins the mean of `n` samples to those that a pixel of a film without passes has. A colour that is no number counts as black.
pub(super) fn add_samples(film: &mut Film, at: usize, color: Sample, n: u32) {
    film.join(at, PixelSamples { color: finite(color), layers: &[], n, earlier: false });
}

/// The one sample of each pixel of rows that were empty, on all cores: so many columns from `left`, downwards from `top`.
#[cfg(feature = "gpu")]
pub(super) fn add_rows(film: &mut Film, [left, top, columns]: [u32; 3], samples: &[Sample]) {
    let (width, part) = (film.width as usize, left as usize..(left + columns) as usize);
    let rows = film.pixels.par_chunks_mut(width).zip(film.samples.par_chunks_mut(width)).skip(top as usize);
    rows.zip(samples.par_chunks(columns as usize)).for_each(|((pixels, counts), new)| {
        counts[part.clone()].fill(1);
        pixels[part.clone()].iter_mut().zip(new).for_each(|(p, s)| *p = finite(*s));
    });
}

/// The one sample of each pixel of blocks that were empty, on all cores; `size` is the side of the blocks' raster.
#[cfg(feature = "gpu")]
pub(super) fn add_blocks(film: &mut Film, size: u32, list: &[Block], memos: &[BlockMemo]) {
    let (width, size) = (film.width as usize, size.max(4) as usize);
    let bands = film.pixels.par_chunks_mut(width * size).zip(film.samples.par_chunks_mut(width * size)).enumerate();
    bands.for_each(|(band, (pixels, counts))| {
        for ([x0, y0, x1, _], memo) in list.iter().zip(memos).filter(|([_, y0, ..], _)| *y0 as usize / size == band) {
            for (k, new) in memo.pixels().chunks((x1 - x0) as usize).enumerate() {
                let at = (*y0 as usize - band * size + k) * width;
                let part = at + *x0 as usize..at + *x1 as usize;
                counts[part.clone()].fill(1);
                pixels[part].iter_mut().zip(new).for_each(|(p, s)| *p = finite(*s));
            }
        }
    });
}
