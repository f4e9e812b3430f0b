//! Radiosity: indirect diffuse light, gathered at some points and reused at their neighbours. Source: spec/light.md, section 8,
//! verified there to the pixel for one thread; the order of rays is the order here.

use super::radiosity_cache::{Query, RadiosityCache, RadiositySample};
use super::ray::{Seen, TraceRay};
use super::shade::HitContext;
use super::subsurface::SubsurfaceState;
use super::trace::Tracer;
use crate::compile::geometry::prim_flags;
use crate::kernel::traverse::{MIN_DEPTH, intersect};
use crate::math::color::grey;
use crate::math::random::{GrainStream, SplitMix64, UniformStream, halton};
use crate::math::{DVec3, Ray, Rgb, Vec3};
use crate::scene::settings::Radiosity;
use std::sync::Arc;

/// Most diffuse bounces. Source: spec/light.md, section 8.
const MAX_BOUNCES: usize = 20;

/// What radiosity remembers from ray to ray.
pub struct RadiosityState {
    settings: Radiosity,
    /// What was gathered before a block that has a state of its own.
    before: Arc<RadiosityCache>,
    cache: RadiosityCache,
    /// The pretrace is running.
    pretrace: bool,
    /// Diffuse bounces behind the current ray.
    bounces: u32,
    /// Running position in the directions, by bounce.
    positions: [u32; MAX_BOUNCES + 1],
    /// Least quality that the current gather ray met.
    quality: f32,
    directions: Arc<[DVec3]>,
    /// Streams of the gather rays' tracer.
    streams: (UniformStream, UniformStream, GrainStream, SubsurfaceState),
    /// Lookups of camera rays since the last [`Tracer::take_lookups`], and the sum of 4S.
    lookups: (u32, f64),
}

impl RadiosityState {
    /// Nothing gathered yet.
    pub fn new(settings: &Radiosity) -> Self {
        let pool = settings.pool.max(settings.count.max(1.0) as u32).clamp(1, 1 << 20);
        Self {
            settings: settings.clone(),
            before: Arc::default(),
            cache: RadiosityCache::default(),
            pretrace: false,
            bounces: 0,
            positions: [0; MAX_BOUNCES + 1],
            quality: 1.0,
            directions: (0..pool).map(cosine_direction).collect(),
            streams: Default::default(),
            lookups: (0, 0.0),
        }
    }

    /// Starts the pretrace or the final pass: directions and streams begin anew, samples stay.
    pub(super) fn start_pass(&mut self, pretrace: bool) {
        self.pretrace = pretrace;
        self.positions = [0; MAX_BOUNCES + 1];
        self.streams = Default::default();
    }

    /// A state for one block of a pass: it finds the samples of the passes before and its own.
    pub fn in_block(&self, seeds: &mut SplitMix64) -> Self {
        Self {
            settings: self.settings.clone(),
            before: Arc::clone(&self.before),
            cache: RadiosityCache::default(),
            pretrace: self.pretrace,
            bounces: 0,
            positions: std::array::from_fn(|_| seeds.below(self.directions.len()) as u32),
            quality: 1.0,
            directions: Arc::clone(&self.directions),
            streams: (
                UniformStream::seeded(seeds),
                UniformStream::seeded(seeds),
                GrainStream::seeded(seeds),
                SubsurfaceState::seeded(seeds),
            ),
            lookups: (0, 0.0),
        }
    }

    /// Keeps what a block gathered for the blocks that are begun from now on.
    pub fn absorb(&mut self, block: RadiosityState) {
        // A state that others still read from is copied; between groups of blocks nobody does.
        let before = Arc::make_mut(&mut self.before);
        for sample in block.cache.into_samples() {
            before.insert(sample, filing_radius(&self.settings, &sample));
        }
    }

    /// Whether gather rays see light from below surfaces.
    pub(super) fn sees_subsurface(&self) -> bool {
        self.settings.subsurface
    }

    fn needed(&self, bounce: u32) -> f64 {
        let n = self.settings.nearest_count.0.clamp(1, 20);
        f64::from(match bounce {
            0 => n,
            1 => n.min(2),
            _ => 1,
        })
    }
}

/// How far from its point a sample may be found.
fn filing_radius(settings: &Radiosity, sample: &RadiositySample) -> f64 {
    sample.reach * settings.error_bound * 2f64.powi(sample.bounce as i32) / if sample.bounce == 0 { 1.0 } else { 8.0 }
}

/// Element `i` of the cosine-weighted directions about y.
fn cosine_direction(i: u32) -> DVec3 {
    let (b2, angle) = (halton(i, 2), std::f64::consts::TAU * halton(i, 3));
    let r = b2.sqrt();
    DVec3::new(r * angle.cos(), (1.0 - b2).sqrt(), r * angle.sin())
}

/// `d` given about y, turned to lie about unit `n`.
fn about(n: DVec3, d: DVec3) -> DVec3 {
    if n.y > 0.999 {
        return d;
    }
    if n.y < -0.999 {
        return -d;
    }
    let e = if n.z.abs() > 0.9 { DVec3::Y } else { DVec3::Z };
    let x = n.cross(e).normalize();
    let z = x.cross(n).normalize();
    d.x * x + d.y * n + d.z * z
}

impl Tracer<'_> {
    /// Whether indirect light is gathered for the current ray.
    pub(super) fn radiosity_acts(&self) -> bool {
        self.radiosity.as_ref().is_some_and(|s| s.bounces < s.settings.recursion_limit.min(MAX_BOUNCES as u32))
    }

    /// Camera-ray lookups since the last call: their number, and the sum of four times their weights.
    pub fn take_lookups(&mut self) -> (u32, f64) {
        self.radiosity.as_mut().map_or((0, 0.0), |s| std::mem::take(&mut s.lookups))
    }

    /// Indirect light at a hit. `normal` is the layer's, `geometric` the surface's, both on the side to be lit.
    pub(super) fn indirect_light(&mut self, ctx: &HitContext, normal: DVec3, geometric: DVec3, weight: f64) -> Rgb {
        let point = ctx.hit.point;
        let Some(s) = self.radiosity.as_mut() else { return Vec3::ZERO };
        let k = s.bounces;
        let scale = 2f64.powi(k as i32);
        let normal = if s.settings.normal { normal } else { geometric };
        let low = if s.pretrace { s.settings.low_error_factor } else { 1.0 };
        let error = (s.settings.error_bound * low + (0.25 - weight).max(0.0)) * scale;
        let query = Query { point, normal, bounce: k, error, smooth: !s.pretrace && k == 0 };
        let ((before, there), (own, here)) = (s.before.lookup(&query), s.cache.lookup(&query));
        let (mut sum, mut value) = (before + own, there + here);
        if k == 0 {
            s.lookups.0 += 1;
            s.lookups.1 += 4.0 * sum;
        }
        let needed = s.needed(k);
        let enough = 4.0 * sum >= needed || (!s.pretrace && !s.settings.always_sample && sum > 0.0);
        if enough {
            value /= sum as f32;
        } else {
            let (gathered, quality) = self.gather(ctx, normal, geometric);
            let q = f64::from(quality);
            value = if sum > 0.0 { (value + gathered * quality) / (sum + q) as f32 } else { gathered };
            sum += q;
        }
        let Some(s) = self.radiosity.as_mut() else { return Vec3::ZERO };
        s.quality = s.quality.min((4.0 * sum / needed).min(1.0) as f32);
        let gray = s.settings.gray_threshold as f32;
        value = value * (1.0 - gray) + Vec3::splat(gray * grey(value));
        value * s.settings.brightness as f32
    }

    /// Traces the rays of a new sample, stores it, and gives its value and quality.
    fn gather(&mut self, ctx: &HitContext, normal: DVec3, geometric: DVec3) -> (Rgb, f32) {
        let point = ctx.hit.point;
        let Some(s) = self.radiosity.as_mut() else { return (Vec3::ZERO, 0.0) };
        let k = s.bounces;
        let scale = 2f64.powi(k as i32);
        let n_rays = ((s.settings.count / scale).floor() as u32).max(5);
        let weight = s.settings.adc_bailout.max((0.5 * s.settings.brightness).powi(k as i32 + 1));
        let (max_sample, adc) = (s.settings.max_sample as f32, s.settings.adc_bailout);
        let outer_quality = s.quality;
        s.bounces += 1;
        // The gather rays belong to a tracer of their own: its level, its bailout, its streams.
        let start = (1.5 * f64::from(k + 1)).floor() as u32;
        let own = (self.level, self.max_level, self.adc_bailout);
        (self.level, self.adc_bailout) = (start, adc);
        self.max_level = self.scene.settings.max_trace_level.max(start + 1);
        if k == 0 {
            self.swap_streams();
        }
        let (mut sum, mut sum_quality, mut inverse_distances) = (Vec3::ZERO, 0.0f32, 0.0);
        let (mut nearest, mut to_nearest) = (f64::INFINITY, normal);
        let (mut n, mut tries, mut about_normal) = (0, 0, normal);
        while n < n_rays {
            let Some(s) = self.radiosity.as_mut() else { break };
            let position = &mut s.positions[k as usize];
            let local = s.directions[*position as usize % s.directions.len()];
            *position = (*position + 1) % s.directions.len() as u32;
            s.quality = 1.0;
            let dir = about(about_normal, local);
            tries += 1;
            if dir.dot(geometric) <= 0.0 && about_normal != geometric {
                if tries >= 5 * n_rays {
                    about_normal = geometric;
                }
                continue;
            }
            let ray = TraceRay {
                ray: Ray::new(point, dir),
                max_depth: f64::INFINITY,
                interiors: ctx.ray.interiors.clone(),
                reflected: ctx.ray.reflected,
                gathers: true,
                wavelength: ctx.ray.wavelength,
            };
            n += 1;
            let kept = self.share_kept(&ray, n - 1, n_rays);
            let (share, seen) = match kept {
                Ok(share) => (share, self.trace(&ray, weight, false)),
                Err(depth) => (0.0, Seen { depth, ..Seen::BLACK }),
            };
            let brightest = seen.rgb.max_element();
            let color = if max_sample > 0.0 && brightest > max_sample { seen.rgb * (max_sample / brightest) } else { seen.rgb };
            let q = share * self.radiosity.as_ref().map_or(1.0, |s| s.quality);
            sum += q * color;
            sum_quality += q;
            inverse_distances += 1.0 / seen.depth;
            if seen.depth < nearest {
                (nearest, to_nearest) = (seen.depth, dir);
            }
        }
        if k == 0 {
            self.swap_streams();
        }
        (self.level, self.max_level, self.adc_bailout) = own;
        let camera = self.plan.camera.location();
        let value = if sum_quality > 0.0 { sum / sum_quality } else { Vec3::ZERO };
        let quality = sum_quality / n_rays as f32;
        let Some(s) = self.radiosity.as_mut() else { return (value, quality) };
        s.bounces -= 1;
        s.quality = outer_quality;
        let z = (point - camera).length();
        let longest = z * s.settings.maximum_reuse * scale;
        let reach = (f64::from(n_rays) / inverse_distances).clamp((z * s.settings.minimum_reuse * scale).min(longest), longest);
        if nearest > 1e-4 * longest {
            let sample = RadiositySample { point, normal, value, reach, nearest, to_nearest, quality, bounce: k };
            s.cache.insert(sample, filing_radius(&s.settings, &sample));
        }
        (value, quality)
    }

    /// How much ray number `k` of `n` counts, or the depth at which it meets what is not important enough for it.
    fn share_kept(&self, ray: &TraceRay, k: u32, n: u32) -> Result<f32, f64> {
        let usual = self.radiosity.as_ref().map_or(1.0, |s| s.settings.importance);
        let importances = &self.scene.geometry.importances;
        if usual == 1.0 && importances.is_empty() {
            return Ok(1.0);
        }
        let skip = prim_flags::NO_RADIOSITY | if ray.reflected { prim_flags::NO_REFLECTION } else { prim_flags::NO_IMAGE };
        let hit = intersect(self.scene, &ray.ray, MIN_DEPTH, ray.max_depth, skip);
        let own = hit.as_ref().and_then(|h| importances.get(h.prim_ix as usize)).filter(|i| !i.is_nan());
        let (importance, most) = (*own.unwrap_or(&usual), f64::from(n - 1));
        if importance < f64::from(k) / most {
            return Err(hit.map_or(f64::INFINITY, |h| h.t));
        }
        Ok((f64::from(n) / ((importance * most).floor() + 1.0)) as f32)
    }

    fn swap_streams(&mut self) {
        if let Some(s) = self.radiosity.as_mut() {
            std::mem::swap(&mut s.streams.0, &mut self.random);
            std::mem::swap(&mut s.streams.1, &mut self.media_random);
            std::mem::swap(&mut s.streams.2, &mut self.grain);
            std::mem::swap(&mut s.streams.3, &mut self.subsurface);
        }
    }

    /// Whether fog, media and rainbows act on this ray.
    pub(super) fn sees_volumes(&self, r: &TraceRay) -> bool {
        self.plan.quality.volumes && r.interiors.is_hollow() && (!r.gathers || self.radiosity.as_ref().is_none_or(|s| s.settings.media))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_are_unit_cosine_weighted_and_turn_with_the_normal() {
        let n = DVec3::new(0.3, -0.5, 0.81).normalize();
        let dirs: Vec<DVec3> = (0..1600).map(|i| about(n, cosine_direction(i))).collect();
        assert!(dirs.iter().all(|d| (d.length() - 1.0).abs() < 1e-12 && d.dot(n) >= 0.0));
        let mean: f64 = dirs.iter().map(|d| d.dot(n)).sum::<f64>() / 1600.0;
        assert!((mean - 2.0 / 3.0).abs() < 1e-3, "mean cosine of the cosine lobe: {mean}");
    }
}
