//! The rays of a measurement: what the camera sends out, and what shadow, mirror and diffuse reflection send on from where those end.

use crate::compile::CompiledScene;
use crate::kernel::camera::CameraModel;
use crate::kernel::traverse::{MIN_DEPTH, intersect};
use crate::math::random::SplitMix64;
use crate::math::{Bounds, DVec3, Ray};
use rayon::prelude::*;

/// Names of the sets, in the order of [`RaySets::sets`].
pub const RAY_KINDS: [&str; 4] = ["primary", "shadow", "reflected", "diffuse"];

/// A ray and how far it looks.
#[derive(Clone, Copy, Debug)]
pub struct TestRay {
    /// Start and unit direction, rounded to 32 bits.
    pub ray: Ray,
    /// Hits beyond do not count.
    pub t_max: f64,
}

/// Rays of four kinds.
pub struct RaySets {
    /// As [`RAY_KINDS`]; shadow rays ask for any hit, the others for the nearest.
    pub sets: [Vec<TestRay>; 4],
}

/// Pixels are visited in tiles of this side: neighbours in a workgroup are neighbours in the picture.
const TILE: u32 = 8;
/// "No limit" for 32-bit depths.
const FAR: f64 = 1e30;

fn rounded(origin: DVec3, dir: DVec3, t_max: f64) -> TestRay {
    TestRay { ray: Ray::new(origin.as_vec3().as_dvec3(), dir.as_vec3().as_dvec3()), t_max: f64::from(t_max as f32) }
}

/// Level, 90 degrees wide.
fn from_middle(eye: DVec3, x: u32, y: u32, width: u32, height: u32) -> Ray {
    let ahead = DVec3::new(0.8, -0.1, 0.6).normalize();
    let right = DVec3::Y.cross(ahead).normalize();
    let up = ahead.cross(right);
    let (a, b) = ((2.0 * f64::from(x) + 1.0) / f64::from(width) - 1.0, (f64::from(height) - 2.0 * f64::from(y) - 1.0) / f64::from(width));
    Ray::new(eye, (ahead + a * right + b * up).normalize())
}

/// Ten bits, two zeros after each.
fn spread(v: u64) -> u64 {
    (0..10).fold(0, |s, k| s | (v >> k & 1) << (3 * k))
}

impl RaySets {
    /// Rays of the scene's camera, `width` x `height`, and what follows from their hits. The lamp of shadow rays is a square above the
    /// middle, a fifth of the scene wide. `inside` looks from the middle of the scene instead: for rooms without a camera.
    pub fn new(scene: &CompiledScene, width: u32, height: u32, inside: bool) -> Self {
        let g = &scene.geometry;
        let all = g.bounded.iter().map(|p| g.bounds[*p as usize]).fold(Bounds::EMPTY, Bounds::union);
        let (center, size) = (all.center(), all.size());
        let camera = CameraModel::new(scene, width, height);
        let ray_at =
            |x: u32, y: u32| if inside { Some(from_middle(center, x, y, width, height)) } else { Some(camera.ray(x.into(), y.into())?.0) };
        let tiles_x = width.div_ceil(TILE);
        let n_tiles = tiles_x * height.div_ceil(TILE);
        let of_tile = |tile: u32| {
            (0..TILE * TILE).filter_map(move |k| {
                let (x, y) = (tile % tiles_x * TILE + k % TILE, tile / tiles_x * TILE + k / TILE);
                (x < width && y < height).then_some((x, y))
            })
        };
        let primary: Vec<TestRay> = (0..n_tiles)
            .into_par_iter()
            .flat_map_iter(|tile| of_tile(tile).filter_map(|(x, y)| ray_at(x, y)).map(|r| rounded(r.origin, r.dir, FAR)))
            .collect();
        let followers: Vec<Option<[TestRay; 3]>> = primary
            .par_iter()
            .enumerate()
            .map(|(k, r)| {
                let hit = intersect(scene, &r.ray, MIN_DEPTH, r.t_max, 0)?;
                let n = if hit.normal.dot(r.ray.dir) > 0.0 { -hit.normal } else { hit.normal };
                let p = hit.point + 1e-5 * size.length().min(1e6) * n;
                let mut numbers = SplitMix64(k as u64 * 5 + 7);
                let lamp = center + size * DVec3::new(0.2 * numbers.unit() - 0.1, 0.45, 0.2 * numbers.unit() - 0.1);
                let to_lamp = lamp - p;
                let mirror = r.ray.dir - 2.0 * r.ray.dir.dot(n) * n;
                let diffuse = (n + numbers.direction()).try_normalize().unwrap_or(n);
                let shadow = rounded(p, to_lamp.try_normalize()?, to_lamp.length());
                Some([shadow, rounded(p, mirror.try_normalize()?, FAR), rounded(p, diffuse, FAR)])
            })
            .collect();
        let of = |which: usize| followers.iter().flatten().map(|f| f[which]).collect();
        Self { sets: [primary, of(0), of(1), of(2)] }
    }

    /// The same rays in the order of their octants, and in each along a Morton curve through where they start: neighbours go much the same way.
    pub fn sorted(mut self) -> Self {
        for set in &mut self.sets {
            let all = set.iter().fold(Bounds::EMPTY, |b, r| b.union(Bounds { min: r.ray.origin, max: r.ray.origin }));
            let cells = 1023.0 / all.size().max(DVec3::splat(1e-300));
            let key = |r: &TestRay| {
                let octant = (0..3).fold(0, |o, k| 2 * o + u64::from(r.ray.dir[k] < 0.0));
                let place = ((r.ray.origin - all.min) * cells).to_array().map(|v| spread(v as u64));
                octant << 30 | place[0] << 2 | place[1] << 1 | place[2]
            };
            set.par_sort_by_cached_key(key);
        }
        self
    }
}
