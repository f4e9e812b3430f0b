//! Radiosity's passes before the picture: coarse mosaics of camera rays that fill the cache. Source: spec/light.md, section 8.

use super::trace::Tracer;
use crate::integrate::antialias::Block;
use crate::math::random::Mt19937;
use crate::scene::settings::Radiosity;

/// Entries of the jitter table.
const JITTER_LEN: usize = 2047;

/// One block of the pretrace.
struct PretraceBlock {
    block: Block,
    serial: usize,
    finished: bool,
}

impl Tracer<'_> {
    /// Runs all passes over `blocks` of a picture whose longer side has `longest` pixels. Stops when `go_on` says no.
    pub fn pretrace(&mut self, settings: &Radiosity, blocks: &[Block], longest: u32, go_on: &dyn Fn() -> bool) {
        let mut mt = Mt19937::new(5489);
        let jitter: Vec<f64> = (0..JITTER_LEN).map(|_| 2.0 * (f64::from(mt.next_u32()) / 4_294_967_296.0) - 1.0).collect();
        let (start, end) = (f64::from(longest) * settings.pretrace.0, (f64::from(longest) * settings.pretrace.1).max(1.0));
        let n_passes = ((start / end).log2() + 1.0 - 1e-10).floor().max(0.0) as u32 + 1;
        let mut list: Vec<PretraceBlock> =
            blocks.iter().enumerate().map(|(serial, block)| PretraceBlock { block: *block, serial, finished: false }).collect();
        for pass in 0..n_passes.min(32) {
            let step = (start / 2f64.powi(pass as i32)).max(end);
            for b in list.iter_mut().filter(|b| !b.finished) {
                if !go_on() {
                    return;
                }
                let n = self.pretrace_block(b, step, pass as usize + 1, &jitter);
                let (lookups, weights) = self.take_lookups();
                let enough = f64::from(settings.nearest_count.1);
                b.finished = n >= 9 && lookups == 0 || enough > 0.0 && lookups > 0 && weights / f64::from(lookups) >= enough;
            }
        }
    }

    fn pretrace_block(&mut self, b: &PretraceBlock, step: f64, pass: usize, jitter: &[f64]) -> u32 {
        let mut at = (17 * pass + 13 * b.serial) % JITTER_LEN;
        let mut draw = || {
            at = (at + 1) % JITTER_LEN;
            jitter[at]
        };
        let amount = (0.5 * step).min(1.0);
        let [x0, y0, x1, y1] = b.block.map(f64::from);
        let first = |low: f64| ((low - 0.5) / step).ceil() * step;
        let (mut n, mut y) = (0, first(y0));
        while y < y1 - 0.5 {
            let mut x = first(x0);
            while x < x1 - 0.5 {
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
