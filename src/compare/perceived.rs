//! FLIP: how much a difference shows when one flips between two pictures.
//! Source: Andersson et al. 2020, DOI 10.1145/3406183 (LDR); 2021, DOI 10.1145/3450623.3464662 (HDR).

use super::Picture;
use flip_rs::{DEFAULT_PPD, ErrorMap, HdrOptions, RgbImage, hdr_flip, ldr_flip};
use rayon::prelude::*;

/// Of pictures as they are shown.
pub(super) fn ldr(a: Picture, b: Picture) -> Option<ErrorMap> {
    let (a, b) = rayon::join(|| planes(&a.into_display()), || planes(&b.into_display()));
    ldr_flip(&b?, &a?, DEFAULT_PPD).ok()
}

/// Of linear light; `b` is the reference, from which the exposures come.
pub(super) fn hdr(a: &Picture, b: &Picture) -> Option<ErrorMap> {
    let mut options = HdrOptions::default();
    options.return_exposure_map = false;
    Some(hdr_flip(&planes(b)?, &planes(a)?, options).ok()?.error_map)
}

/// Mean of a map over the pixels that count.
pub(super) fn mean(map: &ErrorMap, mask: Option<&[bool]>) -> f64 {
    let counts = |i: usize| mask.is_none_or(|m| m[i]);
    let (sum, n) =
        map.pixels().iter().enumerate().filter(|(i, _)| counts(*i)).fold((0.0, 0u64), |(s, n), (_, v)| (s + f64::from(*v), n + 1));
    sum / n.max(1) as f64
}

fn planes(p: &Picture) -> Option<RgbImage<f32>> {
    let mut values = vec![0.0f32; 3 * p.pixels.len()];
    values.par_chunks_exact_mut(3).zip(&p.pixels).for_each(|(out, p)| out.copy_from_slice(&p[..3]));
    RgbImage::new(p.width as usize, p.height as usize, values).ok()
}
