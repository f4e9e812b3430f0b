//! Where radiosity keeps its samples: cells of power-of-two size, each sample in the cell that fits its reach.
//!
//! The filing is POV-Ray's, because it decides which far samples are missed after the first bounce. Source: spec/light.md, section 8.

use crate::math::{DVec3, Rgb, Vec3};
use std::collections::HashMap;
use std::hash::BuildHasherDefault;

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

/// Bounces and size of a cell as a power of two, and its place.
#[derive(Clone, Copy, PartialEq, Eq)]
struct CellKey {
    bounce: u32,
    size: i32,
    place: [i64; 3],
}

impl std::hash::Hash for CellKey {
    fn hash<H: std::hash::Hasher>(&self, state: &mut H) {
        // One number is enough to tell cells apart in a table that is never attacked.
        let mix = |h: u64, v: u64| (h ^ v).wrapping_mul(0x9E37_79B9_7F4A_7C15).rotate_left(29);
        let [x, y, z] = self.place.map(|v| v as u64);
        state.write_u64(mix(mix(mix(u64::from(self.bounce) << 32 ^ u64::from(self.size as u32), x), y), z));
    }
}

/// Takes the number that [`CellKey`] made as it is.
#[derive(Default)]
struct CellHasher(u64);

impl std::hash::Hasher for CellHasher {
    fn finish(&self) -> u64 {
        self.0
    }

    fn write(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|b| self.0 = self.0.wrapping_mul(31).wrapping_add(u64::from(*b)));
    }

    fn write_u64(&mut self, v: u64) {
        self.0 = v.wrapping_mul(0x9E37_79B9_7F4A_7C15);
    }
}

/// A sample as lookups meet it first.
#[derive(Clone, Copy)]
struct Filed {
    point: DVec3,
    reach: f64,
    ix: u32,
}

/// All samples of a picture.
#[derive(Clone, Default)]
pub(super) struct RadiosityCache {
    samples: Vec<RadiositySample>,
    /// By place in a raster shifted by half a cell: the samples of the two cells along each axis that may hold some within reach.
    cells: HashMap<CellKey, Vec<Filed>, BuildHasherDefault<CellHasher>>,
    /// By bounces: the sizes of cells that occur, ascending.
    sizes: Vec<Vec<i32>>,
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
        let (size, place) = fitting_cell(sample.point, radius);
        let bounce = sample.bounce;
        if self.sizes.len() <= bounce as usize {
            self.sizes.resize(bounce as usize + 1, Vec::new());
        }
        let sizes = &mut self.sizes[bounce as usize];
        if let Err(at) = sizes.binary_search(&size) {
            sizes.insert(at, size);
        }
        let filed = Filed { point: sample.point, reach: sample.reach, ix: self.samples.len() as u32 };
        self.samples.push(sample);
        for corner in 0..8u8 {
            let place = std::array::from_fn(|k| place[k] - i64::from(corner >> k & 1));
            self.cells.entry(CellKey { bounce, size, place }).or_default().push(filed);
        }
    }

    /// Sum of the weights of samples that may be reused, and their weighted sum.
    pub fn lookup(&self, q: &Query) -> (f64, Vec3) {
        let (mut sum, mut value) = (0.0, Vec3::ZERO);
        for size in self.sizes.get(q.bounce as usize).into_iter().flatten() {
            // Cells grown by half a side that hold the point: two along each axis, which are filed under the lower one.
            let low = ((q.point + DVec3::splat(ORIGIN)) / 2f64.powi(*size) - DVec3::splat(0.5)).floor();
            let key = CellKey { bounce: q.bounce, size: *size, place: low.to_array().map(|v| v as i64) };
            for f in self.cells.get(&key).into_iter().flatten() {
                let near = f.reach * q.error;
                if q.point.distance_squared(f.point) > near * near * (1.0 + 1e-9) {
                    continue;
                }
                let s = &self.samples[f.ix as usize];
                let w = reuse_weight(s, q);
                sum += w;
                value += w as f32 * s.value;
            }
        }
        (sum, value)
    }

    /// All samples, in the order in which they came.
    pub fn into_samples(self) -> Vec<RadiositySample> {
        self.samples
    }
}

/// Size and place of the smallest cell that holds the ball, grown by half its side.
fn fitting_cell(p: DVec3, radius: f64) -> (i32, [i64; 3]) {
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
    // A sample that met no surface at all has no near side; rounding must not make one.
    if far && s.nearest.is_finite() {
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
