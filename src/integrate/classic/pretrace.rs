//! Radiosity's passes before the picture: coarse mosaics of camera rays that fill the cache. Source: spec/light.md, section 8.

use super::radiosity::RadiosityState;
use super::trace::Tracer;
use crate::integrate::antialias::Block;
use crate::math::random::Mt19937;
use crate::scene::settings::Radiosity;
use rayon::prelude::*;

/// Entries of the jitter table.
const JITTER_LEN: usize = 2047;

/// One block of the pretrace.
struct PretraceBlock {
    block: Block,
    serial: usize,
    finished: bool,
}

/// The passes: for each its distance between rays, in pixels.
struct Passes {
    steps: Vec<f64>,
    blocks: Vec<PretraceBlock>,
    jitter: Vec<f64>,
}

impl Passes {
    /// Over `blocks` of a picture whose longer side has `longest` pixels.
    fn new(settings: &Radiosity, blocks: &[Block], longest: u32) -> Self {
        let mut mt = Mt19937::new(5489);
        let jitter = (0..JITTER_LEN).map(|_| 2.0 * (f64::from(mt.next_u32()) / 4_294_967_296.0) - 1.0).collect();
        let (start, end) = (f64::from(longest) * settings.pretrace.0, (f64::from(longest) * settings.pretrace.1).max(1.0));
        let n_passes = ((start / end).log2() + 1.0 - 1e-10).floor().max(0.0) as u32 + 1;
        let blocks = blocks.iter().enumerate().map(|(serial, block)| PretraceBlock { block: *block, serial, finished: false }).collect();
        Self { steps: (0..n_passes.min(32)).map(|pass| (start / 2f64.powi(pass as i32)).max(end)).collect(), blocks, jitter }
    }
}

/// Runs all passes over `blocks` side by side. A block finds the samples of the batches before its own, whatever the number of threads.
///
/// Deep bounces are gathered all over the scene, and every block of a batch gathers those that it misses for itself: batches begin
/// with one block and grow with what is there to be found. Blocks that touch come in different quarters of a pass.
/// `tracer` makes tracers; `block_size` is a whole block's side. Stops when `go_on` says no.
pub fn pretrace_side_by_side<'a>(
    settings: &Radiosity,
    (blocks, block_size): (&[Block], u32),
    longest: u32,
    tracer: &(dyn Fn() -> Tracer<'a> + Sync),
    go_on: &(dyn Fn() -> bool + Sync),
) -> RadiosityState {
    let mut state = RadiosityState::new(settings);
    state.start_pass(true);
    let Passes { steps, mut blocks, jitter } = Passes::new(settings, blocks, longest);
    blocks.sort_by_key(|b| [b.block[0], b.block[1]].map(|v| v / block_size.max(4) % 2));
    let (quarter, mut n_done) = (blocks.len().div_ceil(4), 0);
    for (pass, step) in steps.into_iter().enumerate() {
        let mut unfinished: Vec<_> = blocks.iter_mut().filter(|b| !b.finished).collect();
        let mut rest = &mut unfinished[..];
        while !rest.is_empty() && go_on() {
            let n = (n_done / 2).clamp(1, quarter).min(rest.len());
            let (batch, later) = rest.split_at_mut(n);
            let states: Vec<_> = batch
                .par_iter_mut()
                .with_max_len(1)
                .map(|b| {
                    let mut own = tracer().in_block(b.block, pass as u32 + 1, Some(&state));
                    b.finished = own.pretrace_block(settings, b, step, pass + 1, &jitter);
                    own.radiosity
                })
                .collect();
            states.into_iter().flatten().for_each(|s| state.absorb(s));
            (rest, n_done) = (later, n_done + n);
        }
    }
    state.start_pass(false);
    state
}

/// Runs all passes over `blocks` with one tracer, block after block. Stops when `go_on` says no.
pub fn pretrace_in_order(
    settings: &Radiosity,
    blocks: &[Block],
    longest: u32,
    mut tracer: Tracer,
    go_on: &dyn Fn() -> bool,
) -> Option<RadiosityState> {
    let state = tracer.radiosity.insert(RadiosityState::new(settings));
    state.start_pass(true);
    let Passes { steps, mut blocks, jitter } = Passes::new(settings, blocks, longest);
    for (pass, step) in steps.into_iter().enumerate() {
        for b in blocks.iter_mut().filter(|b| !b.finished && go_on()) {
            b.finished = tracer.pretrace_block(settings, b, step, pass + 1, &jitter);
        }
    }
    let mut state = tracer.radiosity?;
    state.start_pass(false);
    Some(state)
}

impl Tracer<'_> {
    /// One pass over a block; gives whether it needs no more.
    fn pretrace_block(&mut self, settings: &Radiosity, b: &PretraceBlock, step: f64, pass: usize, jitter: &[f64]) -> bool {
        let n = self.pretrace_rays(b, step, pass, jitter);
        let (lookups, weights) = self.take_lookups();
        let enough = f64::from(settings.nearest_count.1);
        n >= 9 && lookups == 0 || enough > 0.0 && lookups > 0 && weights / f64::from(lookups) >= enough
    }

    /// Gives the number of rays.
    fn pretrace_rays(&mut self, b: &PretraceBlock, step: f64, pass: usize, jitter: &[f64]) -> u32 {
        let mut at = (17 * pass + 13 * b.serial) % JITTER_LEN;
        let mut draw = || {
            at = (at + 1) % JITTER_LEN;
            jitter[at]
        };
        let amount = (0.5 * step).min(1.0);
        let [x0, y0, x1, y1] = b.block.map(f64::from);
        // Multiples of the step within the block, each by adding to the one before: where a step divides the block, rounding decides, as in
        // POV-Ray (measured: numbers of samples).
        let first = |low: f64| (low / step).ceil() * step;
        let (mut n, mut y) = (0, first(y0));
        while y < y1 {
            let mut x = first(x0);
            while x < x1 {
                let dy = draw() * amount;
                let dx = draw() * amount;
                let centre = 0.5 * (step - 1.0);
                self.pixel(x + centre + dx, y + centre + dy);
                n += 1;
                x += step;
            }
            y += step;
        }
        n
    }
}
