//! A time limit for machines that have none of their own (GPUs): rounds of samples, each of a size that the rate so far fits into what is left.

use crate::backend::{Backend, BackendError, Progress};
use crate::compile::CompiledScene;
use crate::film::{Film, PixelSamples};
use crate::integrate::RenderSettings;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// The share of the next round's size that is taken, so that it ends in time.
const CARE: f64 = 0.9;

/// Renders until all samples are there or the time is over; one sample a pixel at least. A noise threshold is left out.
pub(super) fn render(
    machine: &dyn Backend,
    scene: &CompiledScene,
    settings: &RenderSettings,
    limit: Duration,
    film: &mut Film,
    progress: &dyn Progress,
    cancel: &AtomicBool,
) -> Result<(), BackendError> {
    let [x0, y0, x1, y1] = settings.crop;
    let total = u64::from(x1 - x0) * u64::from(y1 - y0);
    (y0..y1).for_each(|y| film.clear(film.index(x0, y)..film.index(x1 - 1, y) + 1));
    let start = Instant::now();
    let mut range = settings.samples.start..(settings.samples.start + 1).min(settings.samples.end);
    while !range.is_empty() && !cancel.load(Ordering::Relaxed) {
        let round = RenderSettings { samples: range.clone(), noise: None, time_limit: None, ..settings.clone() };
        let mut more = Film::new(film.width, film.height);
        machine.render(scene, &round, &mut more, &(), cancel)?;
        for (at, n) in more.samples.iter().enumerate().filter(|(_, n)| **n > 0) {
            film.join(at, PixelSamples { color: more.pixels[at], layers: &[], n: *n, earlier: false });
        }
        progress.picture(film);
        let (spent, n_done) = (start.elapsed(), range.end - settings.samples.start);
        let share = (f64::from(n_done) / settings.samples.len() as f64).max(spent.as_secs_f64() / limit.as_secs_f64());
        progress.pixels((share.min(1.0) * total as f64) as u64, total);
        if spent >= limit {
            break;
        }
        range = range.end..range.end.saturating_add(next_round(spent, limit, n_done)).min(settings.samples.end);
    }
    Ok(())
}

/// Samples of the next round after `n_done` in `spent`: at most twice as many, none where not one more fits.
fn next_round(spent: Duration, limit: Duration, n_done: u32) -> u32 {
    let left = limit.saturating_sub(spent).as_secs_f64();
    let fits = left / spent.as_secs_f64().max(1e-6) * f64::from(n_done) * CARE;
    (fits as u32).min(2 * n_done)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounds_grow_and_fit_into_what_is_left() {
        let s = Duration::from_secs_f64;
        assert_eq!(next_round(s(1.0), s(100.0), 4), 8);
        assert_eq!(next_round(s(60.0), s(100.0), 60), 36);
        assert_eq!(next_round(s(99.0), s(100.0), 3), 0);
    }
}
