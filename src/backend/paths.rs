//! The path integrator on the CPU: blocks of pixels on all cores, every sample by itself; with a noise threshold in rounds over the pixels
//! that are not done. The picture does not depend on the number of threads.

use super::unfinished::{clear, unfinished_blocks};
use super::{BackendError, Progress};
use crate::compile::CompiledScene;
use crate::film::{Film, PixelSamples};
use crate::integrate::antialias::{Block, blocks};
use crate::integrate::path::{NoiseMap, PathPlan, PathTracer, PixelResult, STEP};
use crate::integrate::{NoiseLimit, RenderSettings};
use rayon::prelude::*;
use std::ops::Range;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Renders on the threads of `pool`.
pub(super) fn render_paths(
    scene: &CompiledScene,
    settings: &RenderSettings,
    pool: &rayon::ThreadPool,
    film: &mut Film,
    progress: &dyn Progress,
    cancel: &AtomicBool,
) -> Result<(), BackendError> {
    let plan = pool.install(|| {
        PathPlan::new(scene, settings.width, settings.height, settings.seed, settings.output_alpha)
            .with_passes(settings.passes)
            .features_only(settings.features_only)
    });
    let end = settings.time_limit.map(|limit| (Instant::now(), limit));
    let run = Run { plan: &plan, progress, cancel, end, may_end: AtomicBool::new(false) };
    pool.install(|| match &settings.noise {
        Some(limit) => run.until_quiet(settings, limit, film),
        None if settings.in_rounds || end.is_some() => run.in_rounds(settings, film),
        None => run.all_samples(settings, film),
    });
    Ok(())
}

struct Run<'r> {
    plan: &'r PathPlan<'r>,
    progress: &'r dyn Progress,
    cancel: &'r AtomicBool,
    /// Beginning, and the time that rendering may take.
    end: Option<(Instant, Duration)>,
    /// All pixels have a sample: the time limit counts.
    may_end: AtomicBool,
}

impl Run<'_> {
    /// Share of the time that is over, 0 without a limit.
    fn spent(&self) -> f64 {
        self.end.map_or(0.0, |(start, limit)| start.elapsed().as_secs_f64() / limit.as_secs_f64().max(1e-9))
    }

    fn stops(&self) -> bool {
        self.cancel.load(Ordering::Relaxed) || self.may_end.load(Ordering::Relaxed) && self.spent() >= 1.0
    }

    /// `done` of `total` pixels, or so many as the time stands for.
    fn tell(&self, done: u64, total: u64) {
        self.progress.pixels(done.max((self.spent() * total as f64) as u64).min(total), total);
    }

    /// All pixels get one sample, then twice as many each time, up to a whole step.
    fn in_rounds(&self, settings: &RenderSettings, film: &mut Film) {
        clear(film, settings.crop);
        let all = blocks(settings.crop, settings.block_size);
        let total = area(settings.crop);
        let n_all = settings.samples.len().max(1) as f64;
        let shared = Mutex::new((film, 0u64));
        let mut range = settings.samples.start..(settings.samples.start + 1).min(settings.samples.end);
        while !range.is_empty() && !self.stops() {
            all.par_iter().with_max_len(1).for_each(|block| {
                let results = self.block(*block, &range, |_, _| true);
                let mut guard = shared.lock().expect("no thread panics while it holds the film");
                let (film, done) = &mut *guard;
                for ((x, y), r) in &results {
                    join(film, *x, *y, r, range.len() as u32);
                }
                *done += (results.len() * range.len()) as u64;
                let done = (*done as f64 / n_all) as u64;
                self.progress.picture(film);
                drop(guard);
                self.tell(done, total);
            });
            self.may_end.store(true, Ordering::Relaxed);
            let n = (range.end - settings.samples.start).clamp(1, STEP);
            range = range.end..range.end.saturating_add(n).min(settings.samples.end);
        }
    }

    /// Every pixel gets all its samples.
    fn all_samples(&self, settings: &RenderSettings, film: &mut Film) {
        let (todo, n_finished) = unfinished_blocks(film, settings);
        let total = area(settings.crop);
        let shared = Mutex::new((film, n_finished));
        todo.par_iter().with_max_len(1).for_each(|block| {
            let results = self.block(*block, &settings.samples, |_, _| true);
            let mut guard = shared.lock().expect("no thread panics while it holds the film");
            let (film, done) = &mut *guard;
            for ((x, y), r) in &results {
                join(film, *x, *y, r, settings.samples.len() as u32);
            }
            *done += results.len() as u64;
            let done = *done;
            self.progress.picture(film);
            drop(guard);
            self.progress.pixels(done, total);
        });
    }

    /// Pixels get samples until their error is below the threshold, or they have all.
    fn until_quiet(&self, settings: &RenderSettings, limit: &NoiseLimit, film: &mut Film) {
        // What an earlier run left does not say how its halves were.
        clear(film, settings.crop);
        let [x0, y0, x1, y1] = settings.crop;
        let (w, h) = ((x1 - x0) as usize, (y1 - y0) as usize);
        let at = |x: u32, y: u32| (y - y0) as usize * w + (x - x0) as usize;
        let mut map = NoiseMap::new(w, h);
        // Means of the samples of odd number, and how many those are.
        let odd = vec![([0.0f32; 3], 0u32); w * h];
        let shared = Mutex::new((film, odd));
        let all = blocks(settings.crop, settings.block_size);
        let total = area(settings.crop);
        let first = settings.samples.start.saturating_add(limit.first_samples()).min(settings.samples.end);
        let in_rounds = settings.in_rounds || self.end.is_some();
        let mut range = settings.samples.start..if in_rounds { (settings.samples.start + 1).min(first) } else { first };
        while !range.is_empty() && map.n_active() > 0 && !self.stops() {
            let n = range.len() as u32;
            let n_odd = range.end / 2 - range.start / 2;
            all.par_iter().with_max_len(1).for_each(|block| {
                let results = self.block(*block, &range, |x, y| map.is_active(at(x, y)));
                let mut guard = shared.lock().expect("no thread panics while it holds the film");
                let (film, odd) = &mut *guard;
                for ((x, y), r) in &results {
                    join(film, *x, *y, r, n);
                    let (mean, count) = &mut odd[at(*x, *y)];
                    let whole = (*count + n_odd).max(1) as f32;
                    (0..3).for_each(|c| mean[c] += (r.odd[c] - mean[c]) * n_odd as f32 / whole);
                    *count += n_odd;
                }
            });
            let guard = shared.lock().expect("no thread panics while it holds the film");
            for y in y0..y1 {
                for x in (x0..x1).filter(|x| map.is_active(at(*x, y))).collect::<Vec<_>>() {
                    let [r, g, b, _] = guard.0.pixels[guard.0.index(x, y)];
                    map.set(at(x, y), [r, g, b], guard.1[at(x, y)].0);
                }
            }
            self.progress.picture(guard.0);
            drop(guard);
            self.may_end.store(true, Ordering::Relaxed);
            if range.end < first {
                self.tell(u64::from(range.end - settings.samples.start) * total / settings.samples.len().max(1) as u64, total);
                let n = (range.end - settings.samples.start).clamp(1, STEP);
                range = range.end..range.end.saturating_add(n).min(first);
                continue;
            }
            map.settle(limit.threshold);
            let left = f64::from(settings.samples.end - range.end) / settings.samples.len() as f64 * map.n_active() as f64;
            self.tell(total - left.ceil() as u64, total);
            range = range.end..range.end.saturating_add(STEP).min(settings.samples.end);
        }
    }

    /// Samples `range` of the pixels of a block that are `wanted`; whole rows only when cancelled.
    fn block(&self, block: Block, range: &Range<u32>, wanted: impl Fn(u32, u32) -> bool) -> Vec<((u32, u32), PixelResult)> {
        let [x0, y0, x1, y1] = block;
        let mut tracer = PathTracer::new(self.plan);
        let mut out = Vec::new();
        for y in y0..y1 {
            if self.stops() {
                break;
            }
            out.extend((x0..x1).filter(|x| wanted(*x, y)).map(|x| ((x, y), tracer.pixel(x, y, range.clone()))));
        }
        out
    }
}

fn join(film: &mut Film, x: u32, y: u32, r: &PixelResult, n: u32) {
    let at = film.index(x, y);
    film.join(at, PixelSamples { color: r.color, layers: &r.layers, n, earlier: false });
}

fn area([x0, y0, x1, y1]: Block) -> u64 {
    u64::from(x1 - x0) * u64::from(y1 - y0)
}
