//! Adaptive sampling on the GPU: rounds over the pixels that are not done. Twin: `until_quiet` in `backend/paths.rs`; what is done, and when,
//! is `NoiseMap`'s matter on both machines.

use super::{MAX_SLOTS, PathScene, tiles_of};
use crate::backend::unfinished::clear;
use crate::backend::{BackendError, Progress};
use crate::film::{Film, PixelSamples};
use crate::integrate::antialias::blocks;
use crate::integrate::path::{NoiseMap, STEP};
use crate::integrate::{NoiseLimit, RenderSettings};
use std::sync::atomic::{AtomicBool, Ordering};

/// Pixels get samples until their error is below the threshold, or they have all.
pub(super) fn until_quiet(
    on_device: &PathScene,
    settings: &RenderSettings,
    limit: &NoiseLimit,
    film: &mut Film,
    progress: &dyn Progress,
    cancel: &AtomicBool,
) -> Result<(), BackendError> {
    // What an earlier run left does not say how its halves were.
    clear(film, settings.crop);
    let [x0, y0, x1, y1] = settings.crop;
    let (w, h) = ((x1 - x0) as usize, (y1 - y0) as usize);
    let at = |(x, y): (u32, u32)| (y - y0) as usize * w + (x - x0) as usize;
    let all: Vec<(u32, u32)> = blocks(settings.crop, settings.block_size).iter().flat_map(|b| tiles_of(*b)).collect();
    let mut map = NoiseMap::new(w, h);
    // Sums of the samples of odd number, and how many those are.
    let mut odd = vec![([0.0f32; 3], 0u32); w * h];
    let mut pace = on_device.first_pace();
    let go_on = || !cancel.load(Ordering::Relaxed);
    let mut range = settings.samples.start..settings.samples.start.saturating_add(limit.first_samples()).min(settings.samples.end);
    while !range.is_empty() && map.n_active() > 0 && go_on() {
        let n = range.len() as u32;
        let n_odd = range.end / 2 - range.start / 2;
        let active: Vec<(u32, u32)> = all.iter().copied().filter(|p| map.is_active(at(*p))).collect();
        for part in active.chunks(MAX_SLOTS) {
            let slots = on_device.slots(part)?;
            if on_device.run_all(&slots, range.clone(), &mut pace, &mut |_| go_on())? < n {
                return Ok(());
            }
            for ((pixel, sum), of_odd) in part.iter().zip(on_device.sums(&slots.film, slots.n)?).zip(on_device.sums(&slots.odd, slots.n)?) {
                let place = film.index(pixel.0, pixel.1);
                film.join(place, PixelSamples { color: sum.map(|v| v / n as f32), layers: &[], n, earlier: false });
                let (odd_sum, count) = &mut odd[at(*pixel)];
                (0..3).for_each(|c| odd_sum[c] += of_odd[c]);
                *count += n_odd;
                let [r, g, b, _] = film.pixels[place];
                map.set(at(*pixel), [r, g, b], odd_sum.map(|v| v / (*count).max(1) as f32));
            }
        }
        map.settle(limit.threshold);
        let total = (w * h) as u64;
        let left = f64::from(settings.samples.end - range.end) / settings.samples.len() as f64 * map.n_active() as f64;
        progress.pixels(total - left.ceil() as u64, total);
        range = range.end..range.end.saturating_add(STEP).min(settings.samples.end);
    }
    Ok(())
}
