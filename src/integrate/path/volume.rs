//! Volumes along a ray: which bodies it is inside, what they take away, where light scatters.
//!
//! Direct light is gathered at one point of every segment, drawn either towards a light ("equiangular") or as light is scattered; both are
//! weighed against each other. The path itself goes on where delta tracking says. Source: Kulla and Fajardo 2012; Woodcock et al. 1965;
//! Novák, Selle and Jarosz 2014 (ratio tracking).

use super::passes::{From, Shares};
use super::plan::PathPlan;
use super::sampler::Set;
use super::shadow::{NEAR, ShadowRay};
use super::surface::Surface;
use super::trace::{Origin, Path, PathTracer, balance};
use crate::math::sobol::Pcg;
use crate::math::{DVec3, Ray, Rgb, Transform, Vec3};
use crate::scene::volume::Grid;
use crate::scene::{Shader, Volume};
use std::f32::consts::PI;

/// Bodies that a ray may be inside at once; what is beyond is left out.
pub const MAX_BODIES: usize = 8;
/// The world's volume.
pub const WORLD: u32 = u32::MAX - 1;
const NOBODY: u32 = u32::MAX;

/// Bodies that a ray is inside: object and material.
#[derive(Clone, Copy, Debug)]
pub struct VolumeStack {
    bodies: [(u32, u32); MAX_BODIES],
    n: usize,
}

impl Default for VolumeStack {
    fn default() -> Self {
        Self { bodies: [(NOBODY, NOBODY); MAX_BODIES], n: 0 }
    }
}

impl VolumeStack {
    /// Whether there is nothing.
    pub fn is_empty(&self) -> bool {
        self.n == 0
    }

    /// Object and material of each; the object of the world's is [`WORLD`].
    pub fn bodies(&self) -> &[(u32, u32)] {
        &self.bodies[..self.n]
    }

    fn enter(&mut self, object: u32, material: u32) {
        if self.n < MAX_BODIES && !self.bodies[..self.n].iter().any(|b| b.0 == object) {
            self.bodies[self.n] = (object, material);
            self.n += 1;
        }
    }

    /// Enters or leaves the body of a surface.
    pub fn cross(&mut self, plan: &PathPlan, surface: &Surface, shader: Option<&Shader>) {
        if shader.is_none_or(|s| s.volume.is_none()) {
            return;
        }
        let object = surface.prim.object_ix;
        if surface.backfacing {
            if let Some(k) = self.bodies[..self.n].iter().position(|b| b.0 == object) {
                self.n -= 1;
                self.bodies[k] = self.bodies[self.n];
            }
        } else if let Some(material) = plan.material_ix(surface) {
            self.enter(object, material);
        }
    }
}

/// A grid of a body in world space.
struct PlacedGrid<'p> {
    grid: &'p Grid,
    /// World from the unit cube.
    place: Transform,
    volume: &'p Volume,
    /// Greatest number of the grid.
    most: f32,
}

/// What fills a segment.
struct Medium<'p> {
    /// Everywhere the same: extinction, scattering, emission.
    extinction: Rgb,
    scattering: Rgb,
    emission: Rgb,
    /// Scattering of the even part times its anisotropy.
    forward: f32,
    grids: Vec<PlacedGrid<'p>>,
    /// No less than any extinction.
    majorant: f32,
    /// About the mean extinction.
    typical: f32,
}

/// Coefficients at a point.
struct Coefficients {
    extinction: Rgb,
    scattering: Rgb,
    emission: Rgb,
    anisotropy: f32,
}

fn mean(c: Rgb) -> f32 {
    c.element_sum() / 3.0
}

/// Greatest and mean number of a volume's grid.
pub fn grid_summary(v: &Volume) -> (f32, f32) {
    let Some(d) = &v.density else { return (1.0, 1.0) };
    let (most, sum) = d.grid.cells.iter().fold((0.0f32, 0.0f64), |(m, s), v| (m.max(*v), s + f64::from(*v)));
    (most, (sum / d.grid.cells.len().max(1) as f64) as f32)
}

/// A grid's number at a point of the unit cube; 0 outside.
fn density(grid: &Grid, p: DVec3) -> f32 {
    if !(p.cmpge(DVec3::ZERO).all() && p.cmple(DVec3::ONE).all()) {
        return 0.0;
    }
    let axis = |v: f64, n: u32| {
        let x = (v * f64::from(n) - 0.5).clamp(0.0, f64::from(n - 1));
        let i = (x as u32).min(n.saturating_sub(2));
        (i as usize, (i as usize + 1).min(n as usize - 1), (x - f64::from(i)) as f32)
    };
    let [nx, ny, nz] = grid.size;
    let ((x0, x1, fx), (y0, y1, fy), (z0, z1, fz)) = (axis(p.x, nx), axis(p.y, ny), axis(p.z, nz));
    let at = |x: usize, y: usize, z: usize| grid.cells[(z * ny as usize + y) * nx as usize + x];
    let mix = |a: f32, b: f32, f: f32| a + (b - a) * f;
    let row = |y: usize, z: usize| mix(at(x0, y, z), at(x1, y, z), fx);
    mix(mix(row(y0, z0), row(y1, z0), fy), mix(row(y0, z1), row(y1, z1), fy), fz)
}

impl<'p> Medium<'p> {
    fn new(plan: &'p PathPlan, stack: &VolumeStack) -> Self {
        let mut m = Medium {
            extinction: Vec3::ZERO,
            scattering: Vec3::ZERO,
            emission: Vec3::ZERO,
            forward: 0.0,
            grids: Vec::new(),
            majorant: 0.0,
            typical: 0.0,
        };
        for (object, material) in &stack.bodies[..stack.n] {
            let volume = if *object == WORLD {
                plan.scene.environment.as_ref().and_then(|e| e.volume.as_ref())
            } else {
                plan.shaders[*material as usize].volume.as_ref()
            };
            let Some(volume) = volume else { continue };
            let whole = volume.absorption + volume.scattering;
            match &volume.density {
                None => {
                    m.extinction += whole;
                    m.scattering += volume.scattering;
                    m.emission += volume.emission;
                    m.forward += mean(volume.scattering) * volume.anisotropy;
                    m.typical += mean(whole);
                }
                Some(d) => {
                    let body = plan.body_transform(*object);
                    let (most, average) = if *object == WORLD { grid_summary(volume) } else { plan.grid_summaries[*material as usize] };
                    m.majorant += whole.max_element() * most;
                    m.typical += mean(whole) * average;
                    m.grids.push(PlacedGrid { grid: &d.grid, place: d.transform.then(&body), volume, most });
                }
            }
        }
        m.majorant += m.extinction.max_element();
        m
    }

    fn at(&self, p: DVec3) -> Coefficients {
        let mut c = Coefficients { extinction: self.extinction, scattering: self.scattering, emission: self.emission, anisotropy: 0.0 };
        let mut forward = self.forward;
        for g in self.grids.iter().filter(|g| g.most > 0.0) {
            let d = density(g.grid, g.place.inverse_point(p));
            if d > 0.0 {
                let v = g.volume;
                c.extinction += (v.absorption + v.scattering) * d;
                c.scattering += v.scattering * d;
                c.emission += v.emission * d;
                forward += mean(v.scattering) * d * v.anisotropy;
            }
        }
        let s = mean(c.scattering);
        c.anisotropy = if s > 0.0 { forward / s } else { 0.0 };
        c
    }

    /// What is left of light over `t`.
    fn transmittance(&self, ray: &Ray, t: f64, rng: &mut Pcg) -> Rgb {
        let mut left = (-self.extinction * t as f32).map(f32::exp);
        let rest = self.majorant - self.extinction.max_element();
        if self.grids.is_empty() || rest <= 0.0 {
            return left;
        }
        let mut at = 0.0;
        for _ in 0..100_000 {
            at += f64::from(-(1.0 - rng.draw()).ln() / rest);
            if at >= t {
                break;
            }
            let extra = self.at(ray.at(at)).extinction - self.extinction;
            left *= Vec3::ONE - extra / rest;
            // Unbiased end of what is hardly left.
            let most = left.max_element();
            if most < 0.05 {
                if rng.draw() >= 0.5 {
                    return Vec3::ZERO;
                }
                left *= 2.0;
            }
        }
        left
    }
}

/// Henyey-Greenstein: density of a cosine between the old and the new direction.
pub(super) fn phase(g: f32, cos: f32) -> f32 {
    let d = 1.0 + g * g - 2.0 * g * cos;
    (1.0 - g * g) / (4.0 * PI * d.max(1e-8) * d.max(1e-8).sqrt())
}

pub(super) fn sample_phase(g: f32, dir: DVec3, u: f32, v: f32) -> (DVec3, f32) {
    let cos = if g.abs() < 1e-3 {
        1.0 - 2.0 * u
    } else {
        let k = (1.0 - g * g) / (1.0 - g + 2.0 * g * u);
        ((1.0 + g * g - k * k) / (2.0 * g)).clamp(-1.0, 1.0)
    };
    let sin = f64::from((1.0 - cos * cos).max(0.0).sqrt());
    let (t, b) = dir.any_orthonormal_pair();
    let (s, c) = (std::f64::consts::TAU * f64::from(v)).sin_cos();
    ((dir * f64::from(cos) + (t * c + b * s) * sin).normalize(), phase(g, cos))
}

impl PathPlan<'_> {
    /// World from the space of an object.
    fn body_transform(&self, object: u32) -> Transform {
        let g = &self.scene.geometry;
        let prim = g.objects.get(object as usize).and_then(|o| g.prims.get(o.prims.start as usize));
        prim.map_or(Transform::IDENTITY, |p| g.transforms[p.transform_ix as usize])
    }

    /// Bodies around the camera.
    pub(super) fn volumes_at(&self, point: DVec3) -> VolumeStack {
        let mut stack = VolumeStack::default();
        if self.scene.environment.as_ref().is_some_and(|e| e.volume.is_some()) {
            stack.enter(WORLD, 0);
        }
        // A ray out of the scene: what it leaves without having entered is around the point.
        let dir = DVec3::new(0.123_9, 0.421_7, 0.898_1).normalize();
        let mut ray = Ray::new(point, dir);
        let mut entered: Vec<u32> = Vec::new();
        for _ in 0..1024 {
            let Some(hit) = self.intersect(&ray, -1.0, NEAR, f64::INFINITY, 0) else { break };
            let surface = Surface::new(self.scene, hit, dir, -1.0);
            if self.material(&surface).0.is_some_and(|s| s.volume.is_some()) {
                let object = surface.prim.object_ix;
                if !surface.backfacing {
                    entered.push(object);
                } else if let Some(k) = entered.iter().position(|o| *o == object) {
                    entered.swap_remove(k);
                } else if let Some(material) = self.material_ix(&surface) {
                    stack.enter(object, material);
                }
            }
            ray.origin = surface.hit.point;
        }
        stack
    }

    /// What volumes leave of light over `t`.
    pub(super) fn volume_transmittance(&self, volumes: &VolumeStack, ray: &Ray, t: f64, stream: u32) -> Rgb {
        if volumes.is_empty() {
            return Vec3::ONE;
        }
        let t = if t >= 1e30 { f64::INFINITY } else { t };
        let m = Medium::new(self, volumes);
        if t.is_infinite() && m.grids.is_empty() && m.extinction == Vec3::ZERO {
            return Vec3::ONE;
        }
        m.transmittance(ray, t, &mut Pcg::new(stream))
    }
}

impl PathTracer<'_> {
    /// Takes the path through its volumes over `t`. True when it scattered: the path has a new ray.
    pub(super) fn cross_volumes(&mut self, path: &mut Path, t: f64) -> bool {
        let plan = self.plan;
        let volumes = path.volumes;
        let m = Medium::new(plan, &volumes);
        if m.majorant <= 0.0 && m.emission == Vec3::ZERO {
            return false;
        }
        let mut rng = Pcg::new(path.sampler.stream(path.step) ^ 0x7f4a_7c15);
        let scatters = (m.scattering.max_element() > 0.0 || !m.grids.is_empty()) && !path.bounces.is_last;
        if m.majorant <= 0.0 {
            // Light without matter.
            if t.is_finite() {
                self.add(path, path.throughput * m.emission * t as f32, From::Met);
            }
            return false;
        }
        let ray = path.ray;
        let choice = if scatters { self.choose_light(path, &ray, t) } else { None };
        if let Some(c) = &choice {
            self.equiangular_light(path, &m, &ray, t, c, &mut rng);
        }
        let mut at = 0.0f64;
        let u = path.sampler.at(path.step, Set::Volume);
        let mut first = Some(u[0]);
        for _ in 0..100_000 {
            let x = first.take().unwrap_or_else(|| rng.draw());
            at += f64::from(-(1.0 - x).max(1e-12).ln() / m.majorant);
            if at >= t {
                return false;
            }
            let p = ray.at(at);
            let c = m.at(p);
            if c.emission != Vec3::ZERO {
                self.add(path, path.throughput * c.emission / m.majorant, From::Met);
            }
            let real = mean(c.extinction) / m.majorant;
            if rng.draw() >= real {
                let null = 1.0 - real;
                path.throughput *= (Vec3::splat(m.majorant) - c.extinction) / (m.majorant * null);
                continue;
            }
            if !scatters || c.scattering == Vec3::ZERO {
                path.throughput = Vec3::ZERO;
                return true;
            }
            path.throughput *= c.scattering / (m.majorant * real);
            if let Some(choice) = &choice {
                let weight = 1.0 - choice.share(&m, at, t);
                self.light_at(path, p, &c, choice, weight, path.throughput, path.sampler.stream(path.step) ^ 1);
            }
            let (dir, pdf) = sample_phase(c.anisotropy, ray.dir, u[2], u[3]);
            if path.bounces.total == 0 {
                path.first = Shares::Volume;
            }
            if let Some(g) = &mut self.gather {
                g.guide_volume(c.scattering / (m.majorant * real));
                if plan.features_only && !g.wants_guides() {
                    path.throughput = Vec3::ZERO;
                    return true;
                }
            }
            path.bounces.scattered_in_volume(&plan.settings);
            path.ray = Ray::new(p, dir);
            path.origin = Origin { point: p, select: choice.as_ref().map_or(p, |c| c.select), normal: None, pdf, travelled: 0.0 };
            path.min_pdf = path.min_pdf.min(pdf);
            return true;
        }
        false
    }

    /// The light of a segment.
    fn choose_light(&self, path: &Path, ray: &Ray, t: f64) -> Option<SegmentLight> {
        if self.plan.lights.is_empty() {
            return None;
        }
        // Lights are chosen for a place on the segment alone, so that their chances do not depend on where light is gathered.
        let select = ray.at(self.plan.lights.nearest_on(ray, t));
        let pick = path.sampler.at(path.step, Set::Light)[2];
        let chosen = self.plan.lights.choose(self.plan.scene, select, None, pick)?;
        let center = self.plan.lights.center(&chosen);
        let pivot = center.map(|c| {
            let along = (c - ray.origin).dot(ray.dir);
            let height = (c - ray.at(along)).length().max(1e-6);
            let end = if t.is_finite() { t } else { along.max(0.0) + 1e3 * height };
            (along, height, ((0.0 - along) / height).atan(), ((end - along) / height).atan())
        });
        Some(SegmentLight { select, chosen, pivot })
    }

    /// Direct light at a point drawn towards the light.
    fn equiangular_light(&mut self, path: &mut Path, m: &Medium, ray: &Ray, t: f64, choice: &SegmentLight, rng: &mut Pcg) {
        let Some((along, height, from, to)) = choice.pivot else { return };
        let u = path.sampler.at(path.step, Set::Volume)[1];
        let at = along + height * (from + (to - from) * f64::from(u)).tan();
        if !(at > 0.0 && at < t) {
            return;
        }
        let pdf = choice.equiangular(at);
        let p = ray.at(at);
        let c = m.at(p);
        let weight = choice.share(m, at, t);
        if c.scattering == Vec3::ZERO || weight <= 0.0 || pdf <= 0.0 {
            return;
        }
        let throughput = path.throughput * m.transmittance(ray, at, rng) * c.scattering / pdf as f32;
        self.light_at(path, p, &c, choice, weight, throughput, path.sampler.stream(path.step) ^ 2);
    }

    /// Adds the chosen light at a point of the volume.
    fn light_at(&mut self, path: &mut Path, p: DVec3, c: &Coefficients, choice: &SegmentLight, weight: f32, throughput: Rgb, stream: u32) {
        let plan = self.plan;
        let [u, v, ..] = path.sampler.at(path.step, Set::Light);
        let Some(light) = plan.lights.sample_chosen(plan.scene, &plan.shaders, &choice.chosen, p, path.time, [u, v]) else { return };
        if !light.visibility.has(crate::scene::Visibility::VOLUME) || path.bounces.total > plan.lights.max_bounces(light.source) {
            return;
        }
        let f = phase(c.anisotropy, light.dir.dot(path.ray.dir) as f32);
        let mis = if light.is_delta { 1.0 } else { balance(light.pdf, f) };
        let contribution = throughput * light.radiance * (f * mis * weight / light.pdf);
        if !(contribution.max_element() > 0.0) {
            return;
        }
        let seen = if light.cast_shadow {
            let (time, passed) = (path.time, path.bounces.transparent);
            let ray = ShadowRay {
                from: p,
                dir: light.dir,
                distance: light.distance,
                time,
                volumes: &path.volumes,
                passed,
                stream,
                part: path.part,
            };
            plan.transmittance(&ray, &mut self.blocker)
        } else {
            Vec3::ONE
        };
        if seen != Vec3::ZERO {
            self.add(path, contribution * seen, From::Drawn(Shares::Volume));
        }
    }
}

/// The light chosen for a segment.
struct SegmentLight {
    /// For which place it was chosen.
    select: DVec3,
    chosen: super::lights::Chosen,
    /// Foot of the light's centre on the ray, its height above it, angles of both ends; none for lights far away.
    pivot: Option<(f64, f64, f64, f64)>,
}

impl SegmentLight {
    fn equiangular(&self, t: f64) -> f64 {
        let Some((along, height, from, to)) = self.pivot else { return 0.0 };
        if !(to > from) {
            return 0.0;
        }
        let x = t - along;
        height / ((to - from) * (x * x + height * height))
    }

    /// Share of the equiangular strategy at depth `t`; the rest is that of tracking.
    fn share(&self, m: &Medium, t: f64, _end: f64) -> f32 {
        let e = self.equiangular(t) as f32;
        let d = m.typical * (-m.typical * t as f32).exp();
        if e <= 0.0 { 0.0 } else { e * e / (e * e + d * d) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn phase_function_is_normalised_and_drawn_as_it_says() {
        for g in [-0.5f32, 0.0, 0.3, 0.8] {
            let (mut sum, mut cos_mean) = (0.0, 0.0);
            let n = 100_000;
            for k in 0..n {
                let cos = -1.0 + 2.0 * (k as f32 + 0.5) / n as f32;
                sum += phase(g, cos) * 2.0 * PI * 2.0 / n as f32;
                let (d, pdf) = sample_phase(g, DVec3::Z, (k as f32 + 0.5) / n as f32, 0.3);
                cos_mean += d.z as f32 / n as f32;
                assert!((pdf / phase(g, d.z as f32) - 1.0).abs() < 1e-2);
            }
            assert!((sum - 1.0).abs() < 1e-3 && (cos_mean - g).abs() < 2e-3, "g {g}: {sum} {cos_mean}");
        }
    }

    #[test]
    fn grid_is_linear_between_cell_centres_and_nothing_outside() {
        let grid = Grid { size: [2, 1, 1], cells: vec![1.0, 3.0] };
        for (x, want) in [(0.25, 1.0), (0.5, 2.0), (0.75, 3.0), (0.1, 1.0), (1.0, 3.0), (1.1, 0.0)] {
            assert!((density(&grid, DVec3::new(x, 0.5, 0.5)) - want).abs() < 1e-6, "x {x}");
        }
    }
}
