//! POV-Ray's two antialiasing methods over one block of pixels, whoever traces the samples. Source: spec/light.md, section 12.
//!
//! Blocks decide pixels: method 1 traces the row above and the column left of a block again, and never supersamples those.

use super::Antialias;
use crate::math::random::pixel_jitter;
use std::collections::HashMap;

/// Red, green, blue, transmit at a picture position; integers are pixel centres.
pub type Sample = [f32; 4];

/// A part of the picture: left, top, right, bottom; right and bottom exclusive.
pub type Block = [u32; 4];

/// All blocks of side `size` that cover `crop`, row by row; blocks lie on a raster of the whole picture.
pub fn blocks(crop: Block, size: u32) -> Vec<Block> {
    let size = size.max(4);
    let [x0, y0, x1, y1] = crop;
    let mut out = Vec::new();
    let mut y = y0 / size * size;
    while y < y1 {
        let mut x = x0 / size * size;
        while x < x1 {
            out.push([x.max(x0), y.max(y0), (x + size).min(x1), (y + size).min(y1)]);
            x += size;
        }
        y += size;
    }
    out
}

impl Antialias {
    fn differ(&self, a: &Sample, b: &Sample) -> bool {
        let encode = |v: f32| if self.gamma == 1.0 { v } else { v.max(0.0).powf(1.0 / self.gamma) };
        let distance: f32 = (0..4).map(|k| (encode(a[k]) - encode(b[k])).abs()).sum();
        distance >= self.threshold
    }

    /// Renders `block` row by row into `out` (`[row][column]`) with `trace(x, y)`. Stops early when `go_on` says no, after whole rows;
    /// gives the rows finished.
    ///
    /// `trace` gives `None` for what it does not know yet: the picture is then one as if no more had been wanted there ([`BlockMemo`]).
    pub fn render_block(
        &self,
        block: Block,
        trace: &mut impl FnMut(f64, f64) -> Option<Sample>,
        go_on: &dyn Fn() -> bool,
        out: &mut [Sample],
    ) -> u32 {
        if self.method == 2 { self.corners(block, trace, go_on, out) } else { self.neighbours(block, trace, go_on, out) }
    }

    /// Method 1: a pixel that differs from its left or upper neighbour is supersampled, and so is that neighbour.
    fn neighbours(
        &self,
        [x0, y0, x1, y1]: Block,
        trace: &mut impl FnMut(f64, f64) -> Option<Sample>,
        go_on: &dyn Fn() -> bool,
        out: &mut [Sample],
    ) -> u32 {
        let w = (x1 - x0) as usize;
        // Index 0 of a row is the pixel left of the block; row 0 is the row above it.
        let border = (x0..x1).map(|x| (trace(f64::from(x), f64::from(y0) - 1.0).unwrap_or_default(), true));
        let mut above: Vec<(Sample, bool)> = std::iter::once(([0.0; 4], true)).chain(border).collect();
        let mut row = above.clone();
        for y in y0..y1 {
            if !go_on() {
                return y - y0;
            }
            let fy = f64::from(y);
            row[0] = (trace(f64::from(x0) - 1.0, fy).unwrap_or_default(), true);
            for k in 1..=w {
                let fx = f64::from(x0) + k as f64 - 1.0;
                row[k] = (trace(fx, fy).unwrap_or_default(), false);
                let differs_left = self.differ(&row[k].0, &row[k - 1].0);
                let differs_up = self.differ(&row[k].0, &above[k].0);
                if differs_left && !row[k - 1].1 {
                    row[k - 1] = (self.supersample(fx - 1.0, fy, row[k - 1].0, trace), true);
                }
                if differs_up && !above[k].1 {
                    above[k] = (self.supersample(fx, fy - 1.0, above[k].0, trace), true);
                }
                if differs_left || differs_up {
                    row[k] = (self.supersample(fx, fy, row[k].0, trace), true);
                }
            }
            let r = (y - y0) as usize;
            // The row above may have changed until now.
            for k in 0..w {
                if r > 0 {
                    out[(r - 1) * w + k] = above[k + 1].0;
                }
                out[r * w + k] = row[k + 1].0;
            }
            std::mem::swap(&mut above, &mut row);
        }
        y1 - y0
    }

    fn supersample(&self, x: f64, y: f64, centre: Sample, trace: &mut impl FnMut(f64, f64) -> Option<Sample>) -> Sample {
        let n = u32::from(self.depth.clamp(1, 9));
        let step = 1.0 / f64::from(n);
        let (mut sum, mut known) = (centre, true);
        for j in 0..n {
            for i in 0..n {
                let place = |k: u32| -0.5 + 0.5 * step + f64::from(k) * step;
                let (px, py) = self.jittered(x + place(i), y + place(j), step);
                match trace(px, py) {
                    Some(c) => (0..4).for_each(|k| sum[k] += c[k]),
                    None => known = false,
                }
            }
        }
        if known { sum.map(|v| v / (n * n + 1) as f32) } else { centre }
    }

    fn jittered(&self, x: f64, y: f64, scale: f64) -> (f64, f64) {
        if self.jitter == 0.0 {
            return (x, y);
        }
        let (jx, jy) = pixel_jitter(x, y);
        (x + jx * self.jitter * scale, y + jy * self.jitter * scale)
    }

    /// Method 2: a pixel whose corners differ is cut into quarters, again and again.
    fn corners(
        &self,
        [x0, y0, x1, y1]: Block,
        trace: &mut impl FnMut(f64, f64) -> Option<Sample>,
        go_on: &dyn Fn() -> bool,
        out: &mut [Sample],
    ) -> u32 {
        let (w, h) = ((x1 - x0) as usize, (y1 - y0) as usize);
        let mut corner = vec![[0.0f32; 4]; (w + 1) * (h + 1)];
        for j in 0..=h {
            if !go_on() {
                return 0;
            }
            for i in 0..=w {
                corner[j * (w + 1) + i] = trace(f64::from(x0) + i as f64 - 0.5, f64::from(y0) + j as f64 - 0.5).unwrap_or_default();
            }
        }
        let depth = self.depth.clamp(1, 9) - 1;
        let scale = 1.0 / f64::from((1u32 << self.depth.clamp(1, 9)) + 1);
        for j in 0..h {
            if !go_on() {
                return j as u32;
            }
            for i in 0..w {
                let k = j * (w + 1) + i;
                let corners = [corner[k], corner[k + 1], corner[k + w + 1], corner[k + w + 2]];
                let centre = (f64::from(x0) + i as f64, f64::from(y0) + j as f64);
                out[j * w + i] = self.cell(centre, 0.5, depth, corners, scale, trace, &mut Shared::default());
            }
        }
        h as u32
    }

    /// The mean of a square cell of half side `half`; `corners` are top left, top right, bottom left, bottom right.
    fn cell(
        &self,
        (x, y): (f64, f64),
        half: f64,
        depth: u8,
        corners: [Sample; 4],
        jitter_scale: f64,
        trace: &mut impl FnMut(f64, f64) -> Option<Sample>,
        shared: &mut Shared,
    ) -> Sample {
        let [a, b, c, d] = corners;
        let mean = |s: [Sample; 4]| std::array::from_fn(|k| (s[0][k] + s[1][k] + s[2][k] + s[3][k]) * 0.25);
        let pairs = [(&a, &b), (&a, &c), (&a, &d), (&b, &c), (&b, &d), (&c, &d)];
        if depth == 0 || !pairs.iter().any(|(p, q)| self.differ(p, q)) {
            return mean(corners);
        }
        let mut point = |dx: f64, dy: f64| {
            let (px, py) = (x + dx * half, y + dy * half);
            shared.get(px, py).or_else(|| {
                let (jx, jy) = self.jittered(px, py, jitter_scale);
                let s = trace(jx, jy)?;
                shared.points.push(((px, py), s));
                Some(s)
            })
        };
        let points = (point(-1.0, 0.0), point(0.0, -1.0), point(1.0, 0.0), point(0.0, 1.0), point(0.0, 0.0));
        let (Some(left), Some(top), Some(right), Some(bottom), Some(centre)) = points else { return mean(corners) };
        let q = 0.5 * half;
        let parts = [
            ((x - q, y - q), [a, top, left, centre]),
            ((x - q, y + q), [left, centre, c, bottom]),
            ((x + q, y - q), [top, b, centre, right]),
            ((x + q, y + q), [centre, right, bottom, d]),
        ];
        mean(parts.map(|(at, corners)| self.cell(at, q, depth - 1, corners, jitter_scale, trace, shared)))
    }
}

/// A block whose samples are traced many at once: it is rendered again and again with what is known, and asks for what it missed, until
/// it misses nothing. The picture is the one that [`Antialias::render_block`] makes.
pub struct BlockMemo {
    block: Block,
    known: HashMap<(u64, u64), Option<Sample>>,
    pixels: Vec<Sample>,
    is_done: bool,
}

impl BlockMemo {
    /// Knows nothing.
    pub fn new(block: Block) -> Self {
        let [x0, y0, x1, y1] = block;
        Self { block, known: HashMap::new(), pixels: vec![[0.0; 4]; ((x1 - x0) * (y1 - y0)) as usize], is_done: false }
    }

    /// Renders as far as possible; gives the positions that were missing, each once. None: the block is finished.
    pub fn advance(&mut self, aa: &Antialias) -> Vec<(f64, f64)> {
        let (mut missing, known) = (Vec::new(), &mut self.known);
        if self.is_done {
            return missing;
        }
        let mut look = |x: f64, y: f64| {
            *known.entry((x.to_bits(), y.to_bits())).or_insert_with(|| {
                missing.push((x, y));
                None
            })
        };
        aa.render_block(self.block, &mut look, &|| true, &mut self.pixels);
        self.is_done = missing.is_empty();
        missing
    }

    /// Takes in the samples at positions that [`Self::advance`] gave.
    pub fn learn(&mut self, positions: &[(f64, f64)], samples: &[Sample]) {
        for ((x, y), s) in positions.iter().zip(samples) {
            self.known.insert((x.to_bits(), y.to_bits()), Some(*s));
        }
    }

    /// The block's pixels, `[row][column]`.
    pub fn pixels(&self) -> &[Sample] {
        &self.pixels
    }
}

/// Points inside one pixel that several cells share.
#[derive(Default)]
struct Shared {
    points: Vec<((f64, f64), Sample)>,
}

impl Shared {
    fn get(&self, x: f64, y: f64) -> Option<Sample> {
        // Places are sums of powers of two: equal ones are equal to the bit.
        self.points.iter().find(|(p, _)| *p == (x, y)).map(|(_, s)| *s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn aa(method: u8, depth: u8) -> Antialias {
        Antialias { method, threshold: 0.3, depth, jitter: 0.0, gamma: 1.0 }
    }

    fn edge(at: f64) -> impl FnMut(f64, f64) -> Option<Sample> {
        move |x, _| Some(if x < at { [0.0; 4] } else { [1.0, 1.0, 1.0, 0.0] })
    }

    #[test]
    fn blocks_cover_the_crop_once_and_keep_to_the_raster() {
        let b = blocks([10, 40, 70, 65], 32);
        assert_eq!(b, [[10, 40, 32, 64], [32, 40, 64, 64], [64, 40, 70, 64], [10, 64, 32, 65], [32, 64, 64, 65], [64, 64, 70, 65]]);
    }

    #[test]
    fn flat_pictures_take_one_sample_a_pixel_and_the_borders() {
        let mut n = 0;
        let mut out = [[0.0; 4]; 16];
        aa(1, 3).render_block(
            [0, 0, 4, 4],
            &mut |_, _| {
                n += 1;
                Some([0.5; 4])
            },
            &|| true,
            &mut out,
        );
        assert_eq!((n, out), (16 + 8, [[0.5; 4]; 16]));
    }

    #[test]
    fn method_1_counts_the_centre_again() {
        // The edge crosses pixel 2 at 3/4: of 3 columns at -1/3, 0, 1/3 one is white.
        let mut out = [[0.0; 4]; 4];
        aa(1, 3).render_block([0, 0, 4, 1], &mut edge(2.25), &|| true, &mut out);
        assert!((out[2][0] - 3.0 / 10.0).abs() < 1e-6, "{out:?}");
        assert_eq!((out[1][0], out[3][0]), (0.0, 1.0));
    }

    #[test]
    fn method_2_halves_towards_the_edge() {
        let mut out = [[0.0; 4]; 4];
        aa(2, 3).render_block([0, 0, 4, 1], &mut edge(2.01), &|| true, &mut out);
        // Corner columns at 1.5 1.75 2 2.25 2.5: 0 0 0 1 1; cells 0 | 0 | 1/2 | 1, mean of halves.
        assert!((out[2][0] - 0.375).abs() < 1e-6, "{out:?}");
        assert_eq!((out[1][0], out[3][0]), (0.0, 1.0));
    }

    #[test]
    fn samples_are_shared_inside_a_pixel() {
        let mut seen = Vec::new();
        let mut out = [[0.0; 4]; 1];
        aa(2, 3).render_block(
            [0, 0, 1, 1],
            &mut |x, y| {
                seen.push((x.to_bits(), y.to_bits()));
                Some([if (x + y) as i64 % 2 == 0 { x as f32 } else { 1.0 }; 4])
            },
            &|| true,
            &mut out,
        );
        let n = seen.len();
        seen.sort_unstable();
        seen.dedup();
        assert_eq!(seen.len(), n, "no place twice");
    }

    #[test]
    fn blocks_that_learn_their_samples_in_batches_come_out_the_same() {
        let scene =
            |x: f64, y: f64| [((x * 0.7).sin() * (y * 0.9).cos()) as f32, (x * y * 0.05).sin() as f32, (x - y).abs() as f32 * 0.1, 0.0];
        let block = [3, 5, 19, 17];
        for method in [1, 2] {
            for jitter in [0.0, 0.7] {
                let aa = Antialias { threshold: 0.12, jitter, gamma: 2.2, ..aa(method, 3) };
                let mut whole = vec![[0.0; 4]; 16 * 12];
                aa.render_block(block, &mut |x, y| Some(scene(x, y)), &|| true, &mut whole);
                let (mut memo, mut n_rounds) = (BlockMemo::new(block), 0);
                loop {
                    let missing = memo.advance(&aa);
                    if missing.is_empty() {
                        break;
                    }
                    let samples: Vec<Sample> = missing.iter().map(|(x, y)| scene(*x, *y)).collect();
                    memo.learn(&missing, &samples);
                    n_rounds += 1;
                }
                assert_eq!(memo.pixels(), whole, "method {method}, jitter {jitter}");
                assert!((2..100).contains(&n_rounds), "{n_rounds} rounds");
            }
        }
    }
}
