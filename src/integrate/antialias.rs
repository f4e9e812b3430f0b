//! POV-Ray's two antialiasing methods over one block of pixels, whoever traces the samples. Source: spec/light.md, section 12.
//!
//! Blocks decide pixels: method 1 traces the row above and the column left of a block again, and never supersamples those.

use super::Antialias;
use crate::math::random::pixel_jitter;

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

/// A sample, and as it is compared.
#[derive(Clone, Copy, Default)]
pub(super) struct Shade {
    pub color: Sample,
    encoded: Sample,
}

/// Who answers what a block asks. `None` is what nobody knows yet: the picture is then one as if no more had been wanted there.
pub(super) trait Asked {
    /// What is seen at place `at` of the block's grid, `[height + 1][width + 1]`, which begins a step above it and left of it: method 1 has the neighbours
    /// there and its pixels' middles, method 2 the pixels' corners.
    fn grid(&mut self, at: usize, x: f64, y: f64) -> Option<Shade>;
    /// The mean of what is seen in and around the middle of pixel `pixel`, `centre`, of method 1.
    fn wide(&mut self, aa: &Antialias, pixel: usize, middle: (f64, f64), centre: &Shade) -> Option<Shade>;
    /// What is seen at a place inside a pixel of method 2.
    fn inside(&mut self, x: f64, y: f64) -> Option<Shade>;
}

/// Traces what is asked.
struct Tracing<'a, T> {
    aa: &'a Antialias,
    trace: T,
}

impl<T: FnMut(f64, f64) -> Sample> Asked for Tracing<'_, T> {
    fn grid(&mut self, _at: usize, x: f64, y: f64) -> Option<Shade> {
        Some(self.aa.shade((self.trace)(x, y)))
    }

    fn wide(&mut self, aa: &Antialias, _pixel: usize, (x, y): (f64, f64), centre: &Shade) -> Option<Shade> {
        let mut sum = centre.color;
        for (px, py) in aa.places_around(x, y) {
            let c = (self.trace)(px, py);
            (0..4).for_each(|k| sum[k] += c[k]);
        }
        Some(aa.mean_around(sum))
    }

    fn inside(&mut self, x: f64, y: f64) -> Option<Shade> {
        Some(self.aa.shade((self.trace)(x, y)))
    }
}

impl Antialias {
    /// A sample as it is compared.
    pub(super) fn shade(&self, color: Sample) -> Shade {
        let encode = |v: f32| if self.gamma == 1.0 { v } else { v.max(0.0).powf(1.0 / self.gamma) };
        Shade { color, encoded: color.map(encode) }
    }

    fn differ(&self, a: &Shade, b: &Shade) -> bool {
        let distance: f32 = (0..4).map(|k| (a.encoded[k] - b.encoded[k]).abs()).sum();
        distance >= self.threshold
    }

    /// Renders `block` row by row into `out` (`[row][column]`) with `trace(x, y)`. Stops early when `go_on` says no, after whole rows;
    /// gives the rows finished.
    pub fn render_block(&self, block: Block, trace: impl FnMut(f64, f64) -> Sample, go_on: &dyn Fn() -> bool, out: &mut [Sample]) -> u32 {
        let mut asked = Tracing { aa: self, trace };
        if self.method == 2 { self.corners(block, &mut asked, go_on, out) } else { self.neighbours(block, &mut asked, go_on, out) }
    }

    /// Method 1: a pixel that differs from its left or upper neighbour is supersampled, and so is that neighbour.
    pub(super) fn neighbours(&self, [x0, y0, x1, y1]: Block, asked: &mut impl Asked, go_on: &dyn Fn() -> bool, out: &mut [Sample]) -> u32 {
        let w = (x1 - x0) as usize;
        // Index 0 of a row is the pixel left of the block; row 0 is the row above it.
        let border = (0..w).map(|k| (asked.grid(k + 1, f64::from(x0) + k as f64, f64::from(y0) - 1.0).unwrap_or_default(), true));
        let mut above: Vec<(Shade, bool)> = std::iter::once((Shade::default(), true)).chain(border).collect();
        let mut row = above.clone();
        for y in y0..y1 {
            if !go_on() {
                return y - y0;
            }
            let fy = f64::from(y);
            let r = (y - y0) as usize;
            let (grid_at, pixel_at) = ((r + 1) * (w + 1), r * w);
            row[0] = (asked.grid(grid_at, f64::from(x0) - 1.0, fy).unwrap_or_default(), true);
            for k in 1..=w {
                let fx = f64::from(x0) + k as f64 - 1.0;
                row[k] = (asked.grid(grid_at + k, fx, fy).unwrap_or_default(), false);
                let differs_left = self.differ(&row[k].0, &row[k - 1].0);
                let differs_up = self.differ(&row[k].0, &above[k].0);
                let mut widen = |of: &mut (Shade, bool), pixel: usize, middle: (f64, f64)| {
                    *of = (asked.wide(self, pixel, middle, &of.0).unwrap_or(of.0), true);
                };
                if differs_left && !row[k - 1].1 {
                    widen(&mut row[k - 1], pixel_at + k - 2, (fx - 1.0, fy));
                }
                if differs_up && !above[k].1 {
                    widen(&mut above[k], pixel_at + k - 1 - w, (fx, fy - 1.0));
                }
                if differs_left || differs_up {
                    widen(&mut row[k], pixel_at + k - 1, (fx, fy));
                }
            }
            // The row above may have changed until now.
            for k in 0..w {
                if r > 0 {
                    out[(r - 1) * w + k] = above[k + 1].0.color;
                }
                out[r * w + k] = row[k + 1].0.color;
            }
            std::mem::swap(&mut above, &mut row);
        }
        y1 - y0
    }

    /// Where a pixel with its middle at (x, y) is supersampled, besides the middle.
    pub(super) fn places_around(&self, x: f64, y: f64) -> impl Iterator<Item = (f64, f64)> {
        let n = u32::from(self.depth.clamp(1, 9));
        let step = 1.0 / f64::from(n);
        let place = move |k: u32| -0.5 + 0.5 * step + f64::from(k) * step;
        (0..n * n).map(move |k| self.jittered(x + place(k % n), y + place(k / n), step))
    }

    /// The mean of the sum over a pixel's middle and the places around it.
    pub(super) fn mean_around(&self, sum: Sample) -> Shade {
        let n = u32::from(self.depth.clamp(1, 9));
        self.shade(sum.map(|v| v / (n * n + 1) as f32))
    }

    fn jittered(&self, x: f64, y: f64, scale: f64) -> (f64, f64) {
        if self.jitter == 0.0 {
            return (x, y);
        }
        let (jx, jy) = pixel_jitter(x, y);
        (x + jx * self.jitter * scale, y + jy * self.jitter * scale)
    }

    /// Method 2: a pixel whose corners differ is cut into quarters, again and again.
    fn corners(&self, block: Block, asked: &mut impl Asked, go_on: &dyn Fn() -> bool, out: &mut [Sample]) -> u32 {
        let [x0, y0, x1, y1] = block;
        let (w, h) = ((x1 - x0) as usize, (y1 - y0) as usize);
        let Some(grid) = self.corner_grid(block, asked, go_on) else { return 0 };
        for j in 0..h {
            if !go_on() {
                return j as u32;
            }
            for i in 0..w {
                out[j * w + i] = self.quartered(block, j * w + i, &grid, asked);
            }
        }
        h as u32
    }

    /// All corners of a block's pixels, of what is known; `None` where `go_on` said no.
    pub(super) fn corner_grid(&self, [x0, y0, x1, y1]: Block, asked: &mut impl Asked, go_on: &dyn Fn() -> bool) -> Option<Vec<Shade>> {
        let (w, h) = ((x1 - x0) as usize, (y1 - y0) as usize);
        let mut grid = vec![Shade::default(); (w + 1) * (h + 1)];
        for j in 0..=h {
            if !go_on() {
                return None;
            }
            for i in 0..=w {
                let at = j * (w + 1) + i;
                grid[at] = asked.grid(at, f64::from(x0) + i as f64 - 0.5, f64::from(y0) + j as f64 - 0.5).unwrap_or_default();
            }
        }
        Some(grid)
    }

    /// Pixel number `pixel` of a block whose corners are known, by method 2.
    pub(super) fn quartered(&self, [x0, y0, x1, _]: Block, pixel: usize, grid: &[Shade], asked: &mut impl Asked) -> Sample {
        let w = (x1 - x0) as usize;
        let (i, j) = (pixel % w, pixel / w);
        let k = j * (w + 1) + i;
        let corners = [grid[k], grid[k + 1], grid[k + w + 1], grid[k + w + 2]];
        let centre = (f64::from(x0) + i as f64, f64::from(y0) + j as f64);
        let depth = self.depth.clamp(1, 9);
        let scale = 1.0 / f64::from((1u32 << depth) + 1);
        self.cell(centre, 0.5, depth - 1, corners, scale, asked, &mut Shared::default())
    }

    /// The mean of a square cell of half side `half`; `corners` are top left, top right, bottom left, bottom right.
    fn cell(
        &self,
        (x, y): (f64, f64),
        half: f64,
        depth: u8,
        corners: [Shade; 4],
        jitter_scale: f64,
        asked: &mut impl Asked,
        shared: &mut Shared,
    ) -> Sample {
        let [a, b, c, d] = corners;
        let mean = |s: [Sample; 4]| std::array::from_fn(|k| (s[0][k] + s[1][k] + s[2][k] + s[3][k]) * 0.25);
        let plain = corners.map(|s| s.color);
        let pairs = [(&a, &b), (&a, &c), (&a, &d), (&b, &c), (&b, &d), (&c, &d)];
        if depth == 0 || !pairs.iter().any(|(p, q)| self.differ(p, q)) {
            return mean(plain);
        }
        let mut point = |dx: f64, dy: f64| {
            let (px, py) = (x + dx * half, y + dy * half);
            shared.get(px, py).or_else(|| {
                let (jx, jy) = self.jittered(px, py, jitter_scale);
                let s = asked.inside(jx, jy)?;
                shared.points.push(((px, py), s));
                Some(s)
            })
        };
        let points = (point(-1.0, 0.0), point(0.0, -1.0), point(1.0, 0.0), point(0.0, 1.0), point(0.0, 0.0));
        let (Some(left), Some(top), Some(right), Some(bottom), Some(centre)) = points else { return mean(plain) };
        let q = 0.5 * half;
        let parts = [
            ((x - q, y - q), [a, top, left, centre]),
            ((x - q, y + q), [left, centre, c, bottom]),
            ((x + q, y - q), [top, b, centre, right]),
            ((x + q, y + q), [centre, right, bottom, d]),
        ];
        mean(parts.map(|(at, corners)| self.cell(at, q, depth - 1, corners, jitter_scale, asked, shared)))
    }
}

/// Points inside one pixel that several cells share.
#[derive(Default)]
struct Shared {
    points: Vec<((f64, f64), Shade)>,
}

impl Shared {
    fn get(&self, x: f64, y: f64) -> Option<Shade> {
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

    fn edge(at: f64) -> impl FnMut(f64, f64) -> Sample {
        move |x, _| if x < at { [0.0; 4] } else { [1.0, 1.0, 1.0, 0.0] }
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
            |_, _| {
                n += 1;
                [0.5; 4]
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
        aa(1, 3).render_block([0, 0, 4, 1], edge(2.25), &|| true, &mut out);
        assert!((out[2][0] - 3.0 / 10.0).abs() < 1e-6, "{out:?}");
        assert_eq!((out[1][0], out[3][0]), (0.0, 1.0));
    }

    #[test]
    fn method_2_halves_towards_the_edge() {
        let mut out = [[0.0; 4]; 4];
        aa(2, 3).render_block([0, 0, 4, 1], edge(2.01), &|| true, &mut out);
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
            |x, y| {
                seen.push((x.to_bits(), y.to_bits()));
                [if (x + y) as i64 % 2 == 0 { x as f32 } else { 1.0 }; 4]
            },
            &|| true,
            &mut out,
        );
        let n = seen.len();
        seen.sort_unstable();
        seen.dedup();
        assert_eq!(seen.len(), n, "no place twice");
    }
}
