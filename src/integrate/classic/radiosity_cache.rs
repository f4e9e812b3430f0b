//! Where radiosity keeps its samples: cells of power-of-two size, each sample in the cell that fits its reach.
//!
//! The filing is POV-Ray's, because it decides which far samples are missed after the first bounce. Source: spec/light.md, section 8.

use crate::math::{DVec3, Rgb, Vec3};
use std::collections::HashMap;

/// Indirect light gathered at a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct RadiositySample {
    pub point: DVec3,
    pub normal: DVec3,
    pub value: Rgb,
    /// Harmonic mean of the distances that its rays saw.
    pub reach: f64,
    pub nearest: f64,
    /// Unit, to the nearest surface.
    pub to_nearest: DVec3,
    pub quality: f32,
    /// Diffuse bounces before it.
    pub bounce: u32,
}

/// A lookup.
#[derive(Clone, Copy, Debug)]
pub(super) struct Query {
    pub point: DVec3,
    pub normal: DVec3,
    pub bounce: u32,
    /// Error bound of this bounce, weights included.
    pub error: f64,
    /// Smooth weights of the final pass's first bounce.
    pub smooth: bool,
}

/// Size of a cell as a power of two, and its place.
type CellKey = (i32, [i64; 3]);

/// All samples of a picture.
#[derive(Default)]
pub(super) struct RadiosityCache {
    samples: Vec<RadiositySample>,
    cells: HashMap<CellKey, Vec<u32>>,
    /// Cells by size, so that lookups skip sizes that do not occur.
    n_by_size: std::collections::BTreeMap<i32, u32>,
}

/// Shift of the raster, so that the whole of a scene lies on one side.
const ORIGIN: f64 = 1e7;
/// Most samples kept; later ones are used and forgotten.
const MAX_SAMPLES: usize = 1 << 24;

impl RadiosityCache {
    /// Files a sample for lookups within `radius`.
    pub fn insert(&mut self, sample: RadiositySample, radius: f64) {
        if !(radius > 0.0 && radius.is_finite()) || self.samples.len() >= MAX_SAMPLES {
            return;
        }
        let key = fitting_cell(sample.point, radius);
        self.cells.entry(key).or_insert_with(|| {
            *self.n_by_size.entry(key.0).or_default() += 1;
            Vec::new()
        });
        let ix = self.samples.len() as u32;
        self.samples.push(sample);
        if let Some(cell) = self.cells.get_mut(&key) {
            cell.push(ix);
        }
    }

    /// Sum of the weights of samples that may be reused, and their weighted sum.
    pub fn lookup(&self, q: &Query) -> (f64, Vec3) {
        let (mut sum, mut value) = (0.0, Vec3::ZERO);
        for size in self.n_by_size.keys() {
            let side = 2f64.powi(*size);
            // Cells grown by half a side that hold the point: two along each axis.
            let low = ((q.point + DVec3::splat(ORIGIN)) / side - DVec3::splat(0.5)).floor();
            for corner in 0..8u8 {
                let place = |k: u8| low[k as usize] as i64 + i64::from(corner >> k & 1);
                let Some(cell) = self.cells.get(&(*size, [place(0), place(1), place(2)])) else { continue };
                for ix in cell {
                    let s = &self.samples[*ix as usize];
                    let w = reuse_weight(s, q);
                    sum += w;
                    value += w as f32 * s.value;
                }
            }
        }
        (sum, value)
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.samples.len()
    }
}

fn fitting_cell(p: DVec3, radius: f64) -> CellKey {
    let mut size = (2.0 * radius).log2().floor().clamp(-60.0, 40.0) as i32;
    loop {
        let side = 2f64.powi(size);
        let cell = ((p + DVec3::splat(ORIGIN)) / side).floor();
        let (low, high) =
            ((cell - DVec3::splat(0.5)) * side - DVec3::splat(ORIGIN), (cell + DVec3::splat(1.5)) * side - DVec3::splat(ORIGIN));
        let r = DVec3::splat(radius);
        if (p - r).cmpge(low).all() && (p + r).cmple(high).all() || size >= 60 {
            return (size, [cell.x as i64, cell.y as i64, cell.z as i64]);
        }
        size += 1;
    }
}

/// How much a sample counts at a point; 0 when it must not be used.
fn reuse_weight(s: &RadiositySample, q: &Query) -> f64 {
    if s.bounce != q.bounce {
        return 0.0;
    }
    let v = q.point - s.point;
    let d = v.length();
    if d >= s.reach * q.error {
        return 0.0;
    }
    let far = d > 1e-6;
    let mut reach = s.reach;
    if far {
        let c = v.dot(s.to_nearest) / d;
        if c > 0.0 {
            reach = c * s.nearest + (1.0 - c) * s.reach;
        }
    }
    if d >= reach * q.error {
        return 0.0;
    }
    let e = d / reach + 2.0 * (1.0 - q.normal.dot(s.normal)).abs().sqrt();
    if e >= q.error {
        return 0.0;
    }
    let mean = q.normal + s.normal;
    let front = if far { v.dot(mean) / (d * mean.length().max(1e-30)) } else { 1.0 };
    if front <= -0.05 {
        return 0.0;
    }
    let x = e / q.error;
    let mut w = if q.smooth { if x < 0.5 { 1.0 - 2.0 * x * x } else { 2.0 * (1.0 - x) * (1.0 - x) } } else { 1.0 - x };
    if front <= 0.0 {
        w *= 1.0 + 20.0 * front;
    }
    if w > 0.001 { w * f64::from(s.quality) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(point: DVec3) -> RadiositySample {
        RadiositySample {
            point,
            normal: DVec3::Y,
            value: Vec3::ONE,
            reach: 1.0,
            nearest: 0.5,
            to_nearest: DVec3::Y,
            quality: 1.0,
            bounce: 0,
        }
    }

    fn query(point: DVec3) -> Query {
        Query { point, normal: DVec3::Y, bounce: 0, error: 1.0, smooth: false }
    }

    #[test]
    fn weights_fall_linearly_with_distance_and_miss_other_bounces() {
        let mut cache = RadiosityCache::default();
        cache.insert(sample(DVec3::ZERO), 1.0);
        let (w, v) = cache.lookup(&query(DVec3::X * 0.25));
        assert!((w - 0.75).abs() < 1e-12 && (v.x - 0.75).abs() < 1e-6);
        assert_eq!(cache.lookup(&query(DVec3::X * 1.1)).0, 0.0);
        assert_eq!(cache.lookup(&Query { bounce: 1, ..query(DVec3::ZERO) }).0, 0.0);
    }

    #[test]
    fn no_sample_within_its_reach_is_lost_by_the_cells() {
        let mut cache = RadiosityCache::default();
        let place = |k: u32| DVec3::new(f64::from(k % 10) * 0.37 - 3.0, 0.0, f64::from(k / 10) * 0.41 - 2.0);
        (0..100).for_each(|k| cache.insert(sample(place(k)), 1.0));
        for k in 0..200 {
            let q = query(DVec3::new(f64::from(k % 20) * 0.21 - 3.0, 0.0, f64::from(k / 20) * 0.4 - 2.0));
            let all: f64 = (0..100).map(|k| reuse_weight(&sample(place(k)), &q)).sum();
            assert!((cache.lookup(&q).0 - all).abs() < 1e-9);
        }
    }
}
