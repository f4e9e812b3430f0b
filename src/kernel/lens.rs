//! Focal blur: where each lens sample of a pixel goes, and when a pixel has enough of them.
//! Source: spec/light.md, section 11 (verified there to the pixel); spec/textures.md, "Focal blur".

use crate::math::random::{UniformStream, halton, hash_table, pixel_jitter};
use crate::math::statistics::chi_square_point;
use crate::math::{DVec2, DVec3};
use crate::scene::camera::Blur;

/// A lens with its sample places and its stop rule.
pub struct Lens {
    /// Multiplies the unnormalised direction so that it ends on the plane in focus.
    pub focal_factor: f64,
    /// Places on the lens, in apertures, in order.
    grid: Vec<[f64; 2]>,
    /// Shift of the places, in apertures.
    jitter: f64,
    half_aperture: f64,
    /// By two numbers of 0..16 that the hash table gives: the place inside the pixel, as a cell of 16 x 16 and a shift in it.
    cells: Box<[[(f64, f64); 2]; 256]>,
    /// Directions of the lens plane.
    axes: [DVec3; 2],
    /// Fewest samples.
    pub min_samples: u32,
    /// By number of samples less 1: variance below which a pixel is done.
    thresholds: Vec<f64>,
    /// Samples after which the pixel is looked at again.
    groups: Vec<u32>,
}

/// Most lens samples a pixel: bounds memory.
const MAX_SAMPLES: u32 = 1 << 16;

impl Lens {
    /// The lens of a camera with the given direction and up vectors; `bokeh` weighs the places of the unit square.
    pub fn new(blur: &Blur, direction: DVec3, up: DVec3, bokeh: Option<&dyn Fn(DVec2) -> f64>) -> Self {
        let n = blur.max_samples.clamp(1, MAX_SAMPLES);
        let x = up.cross(direction).try_normalize().unwrap_or(DVec3::X);
        let y = direction.cross(x).try_normalize().unwrap_or(DVec3::Y);
        let (grid, groups) = bokeh.map_or_else(|| places(n), |weight| (weighed_points(n, weight), vec![4]));
        let last = chi_square_point(blur.confidence, n.saturating_sub(1).max(1));
        Self {
            focal_factor: blur.focal_distance / direction.length().max(1e-30),
            grid,
            jitter: match n {
                7 => 0.144_338,
                19 => 0.096_225,
                37 => 0.072_168_8,
                _ => 0.5 / f64::from(n).sqrt(),
            },
            half_aperture: 0.5 * blur.aperture,
            cells: cells(),
            axes: [x, y],
            min_samples: blur.min_samples,
            thresholds: (1..=n).map(|i| blur.variance * chi_square_point(blur.confidence, i) / last).collect(),
            groups,
        }
    }

    /// Places of the samples in apertures, what they are shifted by, half the aperture, and the directions of the lens plane.
    pub fn geometry(&self) -> (&[[f64; 2]], f64, f64, [DVec3; 2]) {
        (&self.grid, self.jitter, self.half_aperture, self.axes)
    }

    /// By number of samples less 1: the variance below which a pixel is done.
    pub fn thresholds(&self) -> &[f64] {
        &self.thresholds
    }

    /// Most samples.
    pub fn max_samples(&self) -> u32 {
        self.grid.len() as u32
    }

    /// Samples to take in group `k` before the next look.
    pub fn group(&self, k: usize) -> u32 {
        self.groups.get(k).copied().unwrap_or(4)
    }

    /// Whether `n` samples with these sums of values and of squares (red, green, blue, transmit) are enough.
    pub fn is_settled(&self, n: u32, sum: [f32; 4], sum_sq: [f32; 4]) -> bool {
        let threshold = self.thresholds[n as usize - 1];
        n >= self.min_samples
            && (0..4).all(|k| {
                let (s, sq, n) = (f64::from(sum[k]), f64::from(sum_sq[k]), f64::from(n));
                (sq / n - (s / n) * (s / n)) / n < threshold
            })
    }

    /// How far [`Lens::offset`] may reach along each axis.
    pub fn reach(&self) -> DVec3 {
        let r = self.half_aperture.abs() * (0.5 + 2.0 * self.jitter.abs()) * 1.001;
        r * (self.axes[0].abs() + self.axes[1].abs())
    }

    /// The place inside the pixel at (x, y) that sample `sample` looks through.
    pub fn pixel_position(&self, x: f64, y: f64, sample: u32) -> (f64, f64) {
        let seed = (313.0 * x + 11.0) as i64 + (311.0 * y + 17.0) as i64;
        let number = |k: i64| usize::from(hash_table()[((seed + k) & 4095) as usize]) % 16;
        let [(dx, dy), (shift_x, shift_y)] = self.cells[16 * number(i64::from(sample)) + number(i64::from(sample) + 1)];
        (x + dx + shift_x, y + dy + shift_y)
    }

    /// Shift of the ray's origin for sample `sample` at picture position (x, y) (what [`Lens::pixel_position`] gave).
    pub fn offset(&self, x: f64, y: f64, sample: u32) -> DVec3 {
        let (jx, jy) = pixel_jitter(x + 0.5, y - 0.5);
        let [gx, gy] = self.grid[sample as usize];
        let (lx, ly) = (self.half_aperture * (gx + 2.0 * self.jitter * jx), self.half_aperture * (gy + 2.0 * self.jitter * jy));
        lx * self.axes[0] - ly * self.axes[1]
    }
}

fn cells() -> Box<[[(f64, f64); 2]; 256]> {
    let along = |k: usize| f64::from(2 * k as u32 + 1) / 32.0 - 0.5;
    Box::new(std::array::from_fn(|k| {
        let (dx, dy) = (along(k / 16), along(k % 16));
        let (jx, jy) = pixel_jitter(dx, dy);
        [(dx, dy), ((jx - 0.5) / 16.0, (jy - 0.5) / 16.0)]
    }))
}

const HEX_7: [(i8, i8); 7] = [(-2, 0), (0, 0), (2, 0), (-1, 1), (-1, -1), (1, 1), (1, -1)];
const HEX_19: [(i8, i8); 19] = [
    (-2, 2),
    (-2, -2),
    (2, 2),
    (2, -2),
    (4, 0),
    (-4, 0),
    (0, 0),
    (0, 2),
    (0, -2),
    (-3, 1),
    (-3, -1),
    (3, 1),
    (3, -1),
    (-1, 1),
    (-1, -1),
    (1, 1),
    (1, -1),
    (-2, 0),
    (2, 0),
];
#[rustfmt::skip]
const HEX_37: [(i8, i8); 37] = [
    (0, 0), (-3, 3), (3, -3), (-3, -3), (3, 3), (-6, 0), (6, 0),
    (-2, 2), (2, -2), (-2, -2), (2, 2), (-4, 0), (4, 0),
    (-1, 1), (1, -1), (-1, -1), (1, 1), (-2, 0), (2, 0),
    (-5, 1), (-5, -1), (5, 1), (5, -1), (-4, 2), (-4, -2), (4, 2), (4, -2), (-1, 3), (-1, -3), (1, 3), (1, -3),
    (-3, 1), (-3, -1), (3, 1), (3, -1), (0, 2), (0, -2),
];

/// Sample places and the sizes of the first groups for at most `n` samples.
fn places(n: u32) -> (Vec<[f64; 2]>, Vec<u32>) {
    // The program's own list has 6 decimals, which shows.
    let lattice = |points: &[(i8, i8)], s: f64, t: f64| -> Vec<[f64; 2]> {
        let round = |v: f64| (v * 1e6).round() / 1e6;
        points.iter().map(|(i, j)| [round(f64::from(*i) * s), round(f64::from(*j) * t)]).collect()
    };
    let sqrt3 = 3f64.sqrt();
    let (base, groups) = match n {
        0..7 => (vec![[-0.25, 0.25], [0.25, 0.25], [-0.25, -0.25], [0.25, -0.25]], vec![4]),
        7..19 => (lattice(&HEX_7, 0.25 / sqrt3, 0.25), vec![7]),
        19..37 => (lattice(&HEX_19, 1.0 / (6.0 * sqrt3), 1.0 / 6.0), vec![7, 6, 6]),
        _ => (lattice(&HEX_37, 0.125 / sqrt3, 0.125), vec![7, 6, 6, 4, 4, 4, 4, 2]),
    };
    (disc_points(n, &base), groups)
}

/// `base`, filled up to `n` with Halton points of the disc that keep to free cells of a grid.
fn disc_points(n: u32, base: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let n_us = n as usize;
    let mut out: Vec<[f64; 2]> = base.iter().copied().take(n_us).collect();
    let g = 2 * (f64::from(n) / std::f64::consts::PI).sqrt().ceil() as usize + 1;
    let mut taken = vec![false; g * g];
    let cell = |p: [f64; 2]| {
        let at = |v: f64| (((v + 0.5) * g as f64) as usize).min(g - 1);
        at(p[0]) * g + at(p[1])
    };
    for p in &out {
        taken[cell(*p)] = true;
    }
    let (mut element, mut left) = (0, 10 * n_us);
    while out.len() < n_us {
        let (r, angle) = ((0.25 * halton(element, 2)).sqrt(), std::f64::consts::TAU * halton(element, 3));
        element += 1;
        left = left.saturating_sub(1);
        let p = [r * angle.cos(), r * angle.sin()];
        if taken[cell(p)] && left > n_us - out.len() {
            continue;
        }
        taken[cell(p)] = true;
        out.push(p);
    }
    out
}

/// `n` Halton points of the square, taken with the probability that `weight` gives; it grows with every try, so that this ends.
fn weighed_points(n: u32, weight: &dyn Fn(DVec2) -> f64) -> Vec<[f64; 2]> {
    let n_sq = f64::from(n) * f64::from(n);
    let mut random = UniformStream::default();
    let places = (0..).map(|k| (k, DVec2::new(halton(k, 2), halton(k, 3))));
    let taken = places.filter(|(k, p)| random.draw() <= weight(*p) + f64::from(*k) / n_sq);
    taken.map(|(_, p)| [p.x - 0.5, p.y - 0.5]).take(n as usize).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hexagon_of_seven_is_the_published_one() {
        let (grid, groups) = places(7);
        assert_eq!(grid[0], [-0.288_675, 0.0]);
        assert_eq!(grid[5], [0.144_338, 0.25]);
        assert_eq!(groups, [7]);
    }

    #[test]
    fn every_number_of_samples_gets_that_many_places_within_the_aperture() {
        for n in [1, 4, 6, 12, 19, 25, 50, 200] {
            let (grid, _) = places(n);
            assert_eq!(grid.len(), n as usize);
            assert!(grid.iter().all(|p| p[0].abs() <= 0.5 && p[1].abs() <= 0.5));
        }
    }

    #[test]
    fn equal_samples_settle_and_scattered_ones_do_not() {
        let blur =
            Blur { aperture: 1.0, focal_distance: 1.0, min_samples: 0, max_samples: 20, confidence: 0.9, variance: 1e-4, bokeh: None };
        let lens = Lens::new(&blur, DVec3::Z, DVec3::Y, None);
        assert!(lens.is_settled(7, [3.5; 4], [1.75; 4]));
        assert!(!lens.is_settled(7, [3.0; 4], [3.0; 4]));
    }
}
