//! A block of pixels whose samples are traced many at once: it is rendered with what is known, and asks for what it missed, until it misses nothing.
//! The picture is the one that [`Antialias::render_block`] makes.

use super::Antialias;
use super::antialias::{Asked, Block, Sample, Shade};
use crate::math::random::SplitMix64;
use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

/// A block, and what it knows.
pub struct BlockMemo {
    aa: Antialias,
    block: Block,
    known: Known,
    pixels: Vec<Sample>,
    /// Of method 2: pixels that are not finished.
    open: Vec<u32>,
    is_done: bool,
}

/// What is known of a block's places, and what was asked in vain.
#[derive(Default)]
struct Known {
    /// `[height + 1][width + 1]`; empty until it is known.
    grid: Vec<Shade>,
    /// Means of pixels of method 1.
    wide: HashMap<u32, Option<Shade>, Plain>,
    /// Places inside pixels of method 2, by the bits of their coordinates.
    inside: HashMap<(u64, u64), Option<Shade>, Plain>,
    missing: Vec<(f64, f64)>,
    /// What the missing places are for, in their order.
    questions: Vec<Question>,
    /// Something was asked that is not known yet.
    waits: bool,
}

#[derive(Clone, Copy)]
enum Question {
    /// A place of the grid.
    Grid(u32),
    /// All places around the middle of a pixel but the middle itself.
    Wide(u32),
    Inside((u64, u64)),
}

impl Asked for Known {
    fn grid(&mut self, at: usize, x: f64, y: f64) -> Option<Shade> {
        let found = self.grid.get(at).copied();
        if found.is_none() {
            self.waits = true;
            self.missing.push((x, y));
            self.questions.push(Question::Grid(at as u32));
        }
        found
    }

    fn wide(&mut self, aa: &Antialias, pixel: usize, middle: (f64, f64), _centre: &Shade) -> Option<Shade> {
        let pixel = pixel as u32;
        let found = *self.wide.entry(pixel).or_insert_with(|| {
            self.missing.extend(aa.places_around(middle.0, middle.1).filter(|p| *p != middle));
            self.questions.push(Question::Wide(pixel));
            None
        });
        self.waits |= found.is_none();
        found
    }

    fn inside(&mut self, x: f64, y: f64) -> Option<Shade> {
        let place = (x.to_bits(), y.to_bits());
        let found = *self.inside.entry(place).or_insert_with(|| {
            self.missing.push((x, y));
            self.questions.push(Question::Inside(place));
            None
        });
        self.waits |= found.is_none();
        found
    }
}

impl BlockMemo {
    /// Knows nothing.
    pub fn new(aa: &Antialias, block: Block) -> Self {
        let [x0, y0, x1, y1] = block;
        let n = (x1 - x0) * (y1 - y0);
        let open = if aa.method == 2 { (0..n).collect() } else { Vec::new() };
        Self { aa: *aa, block, known: Known::default(), pixels: vec![[0.0; 4]; n as usize], open, is_done: false }
    }

    /// Renders as far as possible; gives the places that were missing, each once. None: the block is finished.
    pub fn advance(&mut self) -> &[(f64, f64)] {
        let known = &mut self.known;
        known.missing.clear();
        known.questions.clear();
        if self.is_done {
            return &[];
        }
        known.waits = false;
        if self.aa.method == 2 && !known.grid.is_empty() {
            // Each pixel for itself.
            let grid = std::mem::take(&mut known.grid);
            self.open.retain(|pixel| {
                known.waits = false;
                self.pixels[*pixel as usize] = self.aa.quartered(self.block, *pixel as usize, &grid, known);
                known.waits
            });
            known.grid = grid;
            known.waits = !self.open.is_empty();
        } else if self.aa.method == 2 {
            self.aa.corner_grid(self.block, known, &|| true);
        } else {
            self.aa.neighbours(self.block, known, &|| true, &mut self.pixels);
        }
        self.is_done = !known.waits;
        &known.missing
    }

    /// Takes in what is seen at the places that [`Self::advance`] gave.
    pub fn learn(&mut self, samples: &[Sample]) {
        let [x0, y0, x1, y1] = self.block;
        let (w, h) = ((x1 - x0) as usize, (y1 - y0) as usize);
        let (aa, known) = (&self.aa, &mut self.known);
        // The grid first: means have the middles of their pixels from it.
        if known.grid.is_empty() {
            known.grid = vec![Shade::default(); (w + 1) * (h + 1)];
        }
        let mut wide = Vec::new();
        let mut rest = samples.iter().copied();
        let all = "as many samples as places were missing";
        for question in &known.questions {
            match *question {
                Question::Grid(at) => known.grid[at as usize] = aa.shade(rest.next().expect(all)),
                Question::Inside(place) => _ = known.inside.insert(place, Some(aa.shade(rest.next().expect(all)))),
                Question::Wide(pixel) => {
                    let (i, j) = (pixel as usize % w, pixel as usize / w);
                    let middle = (f64::from(x0) + i as f64, f64::from(y0) + j as f64);
                    let own = rest.clone();
                    let n = aa.places_around(middle.0, middle.1).filter(|p| *p != middle).count();
                    rest.by_ref().take(n).for_each(drop);
                    wide.push((pixel, middle, (j + 1) * (w + 1) + i + 1, own));
                }
            }
        }
        for (pixel, middle, at, mut own) in wide {
            let centre = known.grid[at].color;
            let mut sum = centre;
            for place in aa.places_around(middle.0, middle.1) {
                let c = if place == middle { centre } else { own.next().expect(all) };
                (0..4).for_each(|k| sum[k] += c[k]);
            }
            known.wide.insert(pixel, Some(aa.mean_around(sum)));
        }
    }

    /// The block's pixels, `[row][column]`.
    pub fn pixels(&self) -> &[Sample] {
        &self.pixels
    }
}

/// Hashes numbers that nobody chooses to collide.
#[derive(Default)]
struct PlainHasher(u64);

type Plain = BuildHasherDefault<PlainHasher>;

impl Hasher for PlainHasher {
    fn finish(&self) -> u64 {
        self.0
    }

    fn write(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|b| self.write_u64(u64::from(*b)));
    }

    fn write_u32(&mut self, v: u32) {
        self.write_u64(u64::from(v));
    }

    fn write_u64(&mut self, v: u64) {
        self.0 = SplitMix64(self.0 ^ v).bits();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Renders a block in rounds; gives the number of them and the places that were asked for.
    fn in_rounds(aa: &Antialias, block: Block, scene: impl Fn(f64, f64) -> Sample) -> (BlockMemo, usize, Vec<(u64, u64)>) {
        let (mut memo, mut n_rounds, mut seen) = (BlockMemo::new(aa, block), 0, Vec::new());
        loop {
            let missing = memo.advance().to_vec();
            if missing.is_empty() {
                return (memo, n_rounds, seen);
            }
            seen.extend(missing.iter().map(|(x, y)| (x.to_bits(), y.to_bits())));
            memo.learn(&missing.iter().map(|(x, y)| scene(*x, *y)).collect::<Vec<Sample>>());
            n_rounds += 1;
        }
    }

    #[test]
    fn blocks_that_learn_their_samples_in_batches_come_out_the_same() {
        let scene =
            |x: f64, y: f64| [((x * 0.7).sin() * (y * 0.9).cos()) as f32, (x * y * 0.05).sin() as f32, (x - y).abs() as f32 * 0.1, 0.0];
        let block = [3, 5, 19, 17];
        for method in [1, 2] {
            for jitter in [0.0, 0.7] {
                for threshold in [0.0, 0.12, 9.0] {
                    let aa = Antialias { method, threshold, depth: 3, jitter, gamma: 2.2 };
                    let mut whole = vec![[0.0; 4]; 16 * 12];
                    aa.render_block(block, scene, &|| true, &mut whole);
                    let (memo, n_rounds, mut seen) = in_rounds(&aa, block, scene);
                    assert_eq!(memo.pixels(), whole, "method {method}, jitter {jitter}, threshold {threshold}");
                    assert!((1..100).contains(&n_rounds), "{n_rounds} rounds");
                    let n = seen.len();
                    seen.sort_unstable();
                    seen.dedup();
                    assert_eq!(seen.len(), n, "no place is asked for twice");
                }
            }
        }
    }

    #[test]
    fn flat_blocks_are_done_after_their_grid() {
        for (method, n) in [(1, 4 * 4 + 8), (2, 25)] {
            let aa = Antialias { method, threshold: 0.3, depth: 3, jitter: 0.0, gamma: 2.2 };
            let (memo, n_rounds, seen) = in_rounds(&aa, [8, 4, 12, 8], |_, _| [0.25; 4]);
            assert_eq!((n_rounds, seen.len(), memo.pixels()), (1, n, &[[0.25; 4]; 16][..]));
        }
    }
}
