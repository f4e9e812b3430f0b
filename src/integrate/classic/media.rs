//! Media along rays: three ways to sample what a piece of ray gathers and loses. Source: spec/light.md, section 7.

use super::inline_vec::InlineVec;
use super::lights::is_dark;
use super::ray::{InteriorList, Seen, TraceRay};
use super::shafts::Known;
use super::texturing;
use super::trace::Tracer;
use crate::compile::CompiledLight;
use crate::compile::geometry::prim_flags;
use crate::kernel::light::{attenuation, light_ray};
use crate::kernel::media::{MAX_INTERVAL_SAMPLES, SampleInterval, add_missing_end, beam_piece, extinction, phase_value, sample_intervals};
use crate::kernel::{PatternPoint, SurfaceHit};
use crate::math::color::grey;
use crate::math::{DVec2, DVec3, Ray, Rgb, Vec3};
use crate::scene::Light;

/// Media of one call, into `CompiledScene::media`.
pub(super) type MediaList = InlineVec<u32, 8>;

/// Scratch memory of [`Tracer::media_over`].
#[derive(Default)]
pub(super) struct MediaScratch {
    lights: Vec<LitPiece>,
    starts: Vec<f64>,
    ends: Vec<f64>,
    pieces: Vec<SampleInterval>,
    intervals: Vec<SampleInterval>,
    /// By interval: sums of its first samples and of the squares of their light.
    sums: Vec<(Gathered, Rgb)>,
}

/// The piece of a ray that a light reaches.
#[derive(Clone, Copy)]
struct LitPiece {
    light_ix: u32,
    start: f64,
    end: f64,
}

/// What a sample or an interval adds: light, and depth of extinction.
#[derive(Clone, Copy, Default)]
struct Gathered {
    light: Rgb,
    depth: Rgb,
}

impl Gathered {
    fn scaled(self, k: f32) -> Self {
        Self { light: self.light * k, depth: self.depth * k }
    }

    fn plus(self, o: Self) -> Self {
        Self { light: self.light + o.light, depth: self.depth + o.depth }
    }
}

/// What a depth of extinction lets through. Most media are grey, and many only shine.
#[inline]
fn transmittance(depth: Rgb) -> Rgb {
    if depth.x == depth.y && depth.y == depth.z {
        return if depth.x == 0.0 { Vec3::ONE } else { Vec3::splat((-depth.x).exp()) };
    }
    (-depth).exp()
}

/// One call: a piece of ray and the media in it.
struct MediaRay<'m> {
    ray: &'m Ray,
    around: &'m InteriorList,
    media: &'m MediaList,
    lights: &'m [LitPiece],
    aa_threshold: f32,
    jitter: f64,
    method: u8,
    /// Only extinction counts: samples have no light.
    is_shadow: bool,
}

impl Tracer<'_> {
    /// What the media of the interiors around a ray make of what it sees.
    pub(super) fn inside_media(&mut self, r: &TraceRay, hit: &SurfaceHit, rgb: Rgb, transmit: f32) -> (Rgb, f32) {
        let list = self.media_of(&r.interiors);
        if list.is_empty() {
            return (rgb, transmit);
        }
        let g = self.media_over(&r.ray, hit.t, &list, &r.interiors, Some(hit), false);
        let through = transmittance(g.depth);
        (rgb * through + g.light, transmit * grey(through))
    }

    /// What the atmosphere's media make of what a ray sees over `0..depth`.
    pub(super) fn atmosphere(&mut self, r: &TraceRay, depth: f64, hit: Option<&SurfaceHit>, seen: &mut Seen) {
        let mut list = MediaList::default();
        self.scene.atmosphere.iter().for_each(|m| list.push(*m));
        let g = self.media_over(&r.ray, depth, &list, &r.interiors, hit, false);
        let through = transmittance(g.depth);
        seen.rgb = seen.rgb * through + g.light;
        seen.transmit *= grey(through);
    }

    /// What media on `0..depth` of a shadow ray leave of `color`. The last piece, which ends at the light, meets no object's media.
    pub(super) fn shadow_media(
        &mut self,
        light: &Light,
        ray: &Ray,
        depth: f64,
        around: &InteriorList,
        color: Rgb,
        ends_at_surface: bool,
    ) -> Rgb {
        let mut depths = if ends_at_surface { self.depth_inside(ray, depth, around) } else { Vec3::ZERO };
        let air = light.media_attenuation && light.media_interaction && (ends_at_surface || around.is_hollow());
        if air && !self.scene.atmosphere.is_empty() {
            let mut list = MediaList::default();
            self.scene.atmosphere.iter().for_each(|m| list.push(*m));
            depths += self.media_over(ray, depth, &list, around, None, true).depth;
        }
        color * transmittance(depths)
    }

    /// Depth of extinction of the media of interiors on `0..depth`.
    fn depth_inside(&mut self, ray: &Ray, depth: f64, around: &InteriorList) -> Rgb {
        let list = if around.is_hollow() { self.media_of(around) } else { MediaList::default() };
        if list.is_empty() { Vec3::ZERO } else { self.media_over(ray, depth, &list, around, None, true).depth }
    }

    /// What the media of interiors on `0..depth` of a photon's way leave of its power.
    pub(super) fn through_media(&mut self, ray: &Ray, depth: f64, around: &InteriorList, power: Rgb) -> Rgb {
        power * transmittance(self.depth_inside(ray, depth, around))
    }

    pub(super) fn media_of(&self, around: &InteriorList) -> MediaList {
        let mut list = MediaList::default();
        for ix in around.iter() {
            self.scene.interiors[ix as usize].media.iter().for_each(|m| list.push(*m));
        }
        list
    }

    /// Light and depth of extinction over `0..depth` of `ray`.
    fn media_over(
        &mut self,
        ray: &Ray,
        depth: f64,
        media: &MediaList,
        around: &InteriorList,
        hit: Option<&SurfaceHit>,
        is_shadow: bool,
    ) -> Gathered {
        let scene = self.scene;
        let table = &scene.media;
        // Shadow rays through light alone are not even sampled (measured: they draw no random numbers).
        if is_shadow && media.iter().all(|m| is_dark(extinction(&table[m as usize].params))) {
            return Gathered::default();
        }
        let constant = media.iter().all(|m| self.plan.constant_media[m as usize]);
        if is_shadow && constant {
            // One interval, whose one sample is the same wherever it lies; only its random number is drawn.
            if !(depth > 0.0) {
                return Gathered::default();
            }
            self.media_random.draw();
            let ext =
                media.iter().map(|m| extinction(&table[m as usize].params)).filter(|e| !is_dark(*e)).fold(Vec3::ZERO, |sum, e| sum + e);
            return Gathered { light: Vec3::ZERO, depth: ext * depth as f32 };
        }
        let mut s = self.media_scratch[usize::from(is_shadow)].take().unwrap_or_default();
        s.lights.clear();
        if !is_shadow {
            self.lit_pieces(ray, depth, hit, &mut s.lights);
        }
        let rule_ix = self.cut_up(depth, media, &mut s);
        let rule = &table[rule_ix as usize].params;
        let call = MediaRay {
            ray,
            around,
            media,
            lights: &s.lights,
            aa_threshold: media.iter().map(|m| table[m as usize].params.aa_threshold).fold(f64::INFINITY, f64::min) as f32,
            jitter: rule.jitter,
            method: rule.method,
            is_shadow,
        };
        let mut total = Gathered::default();
        let is_random = call.method != 3;
        s.sums.clear();
        if is_random {
            // All intervals get their fewest samples before any gets more: random numbers are drawn in that order.
            s.sums.extend(s.intervals.iter().map(|i| self.fewest_samples(&call, i, rule.samples.0)));
        }
        for (k, interval) in s.intervals.iter().enumerate() {
            let part = if is_random {
                self.more_samples(&call, interval, s.sums[k], rule.samples.0, &self.plan.media_thresholds[rule_ix as usize])
            } else {
                self.adaptive_interval(&call, interval, rule.samples.0, rule.aa_level)
            };
            total.light += part.light * transmittance(total.depth);
            total.depth += part.depth;
        }
        self.media_scratch[usize::from(is_shadow)] = Some(s);
        total
    }

    /// The intervals in which media are looked at on `0..depth` of a ray that ends at a hit.
    pub(super) fn media_intervals(&mut self, ray: &Ray, depth: f64, media: &MediaList, hit: &SurfaceHit) -> Vec<SampleInterval> {
        let mut s = self.media_scratch[0].take().unwrap_or_default();
        s.lights.clear();
        self.lit_pieces(ray, depth, Some(hit), &mut s.lights);
        self.cut_up(depth, media, &mut s);
        let intervals = s.intervals.clone();
        self.media_scratch[0] = Some(s);
        intervals
    }

    /// Cuts `0..depth` into intervals by the lights' pieces. Gives the medium whose settings count.
    fn cut_up(&self, depth: f64, media: &MediaList, s: &mut MediaScratch) -> u32 {
        let table = &self.scene.media;
        // Of equal ones the first; max_by would give the last.
        let rule_ix = media.iter().fold(media.get(0), |best, m| {
            if table[m as usize].params.intervals > table[best as usize].params.intervals { m } else { best }
        });
        let rule = &table[rule_ix as usize];
        s.starts.clear();
        s.starts.extend(s.lights.iter().map(|l| l.start));
        s.ends.clear();
        s.ends.extend(s.lights.iter().map(|l| l.end));
        sample_intervals(&rule.params, !rule.densities.is_empty(), depth, &mut s.starts, &mut s.ends, &mut s.pieces, &mut s.intervals);
        add_missing_end(depth, &mut s.intervals);
        rule_ix
    }

    /// The pieces of a ray that lights reach which light media.
    fn lit_pieces(&self, ray: &Ray, depth: f64, hit: Option<&SurfaceHit>, out: &mut Vec<LitPiece>) {
        let scene = self.scene;
        let prim = hit.map(|h| &scene.geometry.prims[h.prim_ix as usize]);
        let lights = match prim {
            Some(p) if p.flags & prim_flags::NO_GLOBAL_LIGHTS != 0 => match self.plan.group_lights.get(p.group_ix as usize) {
                Some(group) => group,
                None => return,
            },
            _ => &self.plan.global_lights,
        };
        for ix in lights {
            let CompiledLight { light, beam, .. } = &scene.lights[*ix as usize];
            if light.media_interaction
                && !light.shadowless
                && let Some((start, end)) = beam_piece(light, beam, ray, depth)
            {
                out.push(LitPiece { light_ix: *ix, start, end });
            }
        }
    }

    /// Methods 1 and 2: random or stratified places. Gives the sums of the samples and of the squares of their light.
    fn fewest_samples(&mut self, call: &MediaRay, i: &SampleInterval, samples: u32) -> (Gathered, Rgb) {
        let min = samples.clamp(1, MAX_INTERVAL_SAMPLES);
        let (mut sum, mut sum_sq) = (Gathered::default(), Vec3::ZERO);
        for j in 0..min {
            let g = if call.method == 1 {
                self.random_sample(call, i)
            } else {
                let q = (f64::from(j) + 0.5) / f64::from(min) + self.media_random.draw() * call.jitter / f64::from(min);
                self.media_sample(call, i, q)
            };
            sum = sum.plus(g);
            sum_sq += g.light * g.light;
        }
        (sum, sum_sq)
    }

    /// Methods 1 and 2: the mean, after more random samples while the variance is high. Shadow rays take the fewest samples.
    fn more_samples(
        &mut self,
        call: &MediaRay,
        i: &SampleInterval,
        (mut sum, mut sum_sq): (Gathered, Rgb),
        samples: u32,
        thresholds: &[f64],
    ) -> Gathered {
        let mut n = samples.clamp(1, MAX_INTERVAL_SAMPLES);
        let thresholds = if call.is_shadow { &[] } else { thresholds };
        while let Some(threshold) = thresholds.get(n as usize - 1) {
            let k = n as f32;
            let mean = sum.light / k;
            let variance = (sum_sq / k - mean * mean) / k;
            if variance.to_array().iter().all(|v| f64::from(*v) < *threshold) {
                break;
            }
            let g = self.random_sample(call, i);
            sum = sum.plus(g);
            sum_sq += g.light * g.light;
            n += 1;
        }
        sum.scaled(1.0 / n as f32)
    }

    fn random_sample(&mut self, call: &MediaRay, i: &SampleInterval) -> Gathered {
        let q = self.media_random.draw();
        self.media_sample(call, i, q)
    }

    /// Method 3: regular places, refined where neighbours differ. The last part of the interval is never looked at.
    fn adaptive_interval(&mut self, call: &MediaRay, i: &SampleInterval, samples: u32, aa_level: u32) -> Gathered {
        let m = (samples.min(MAX_INTERVAL_SAMPLES) / 2 + 1).max(2);
        let step = 1.0 / f64::from(m + 1);
        let mut sum = Gathered::default();
        let (mut q_last, mut last) = (0.0, Gathered::default());
        for j in 0..=m {
            // Places stay regular for what follows; only the sample itself is jittered (measured).
            let q = f64::from(j) * step;
            let jittered = q + step * call.jitter * (self.media_random.draw() - 0.5);
            let here = self.media_sample(call, i, jittered);
            if j > 0 {
                let r = self.refined(call, i, (q_last, last), (q, here), aa_level.min(20) as i32 - 1);
                sum.light += r.light * transmittance(sum.depth / m as f32);
                sum.depth += r.depth;
            }
            (q_last, last) = (q, here);
        }
        sum.scaled(1.0 / m as f32)
    }

    /// The mean between two samples.
    fn refined(&mut self, call: &MediaRay, i: &SampleInterval, a: (f64, Gathered), c: (f64, Gathered), level: i32) -> Gathered {
        let q = 0.5 * (a.0 + c.0);
        let jittered = q + call.jitter * (c.0 - a.0) * (self.media_random.draw() - 0.5);
        let b = (q, self.media_sample(call, i, jittered));
        if level <= 0 {
            return a.1.plus(b.1).plus(c.1).scaled(1.0 / 3.0);
        }
        let differ = |x: &Gathered, y: &Gathered| (x.light - y.light).abs().element_sum() > call.aa_threshold;
        let left = if differ(&a.1, &b.1) {
            self.refined(call, i, a, b, level - 1).scaled(0.5)
        } else {
            a.1.scaled(1.0 / 3.0).plus(b.1.scaled(1.0 / 6.0))
        };
        let right = if differ(&b.1, &c.1) {
            self.refined(call, i, b, c, level - 1).scaled(0.5)
        } else {
            b.1.scaled(1.0 / 6.0).plus(c.1.scaled(1.0 / 3.0))
        };
        left.plus(right)
    }

    /// One sample at share `q` of an interval, as if the whole interval were so.
    fn media_sample(&mut self, call: &MediaRay, i: &SampleInterval, q: f64) -> Gathered {
        if self.is_stopped() {
            return Gathered::default();
        }
        let scene = self.scene;
        let at = i.start + q * i.length;
        let point = call.ray.at(at);
        let (mut ext, mut light, mut scattering) = (Vec3::ZERO, Vec3::ZERO, Vec3::ZERO);
        for ix in call.media.iter() {
            let medium = &scene.media[ix as usize];
            if call.is_shadow && is_dark(extinction(&medium.params)) {
                continue;
            }
            let density = self.density(ix, point, call.ray.dir);
            ext += density * extinction(&medium.params);
            if !call.is_shadow {
                light += density * medium.params.emission;
            }
            scattering += density * medium.params.scattering;
        }
        if !call.is_shadow && self.plan.photons.is_some() {
            self.photons_replace = call.media.iter().any(|ix| scene.media[ix as usize].params.collect);
            if self.photons_replace && !is_dark(scattering) {
                light += scattering * self.photons_in_media(call, point);
            }
        }
        if i.lit && !is_dark(scattering) {
            for l in call.lights.iter().filter(|l| (l.start..=l.end).contains(&at)) {
                let (arriving, dir) = self.light_at(l.light_ix, call.around, point);
                if !is_dark(arriving) {
                    light += self.mean_phase(call, dir) as f32 * scattering * arriving;
                }
            }
        }
        let h = i.length as f32;
        let weaken = if call.method == 3 { Vec3::ONE } else { transmittance(ext * h * q as f32) };
        Gathered { light: light * h * weaken, depth: ext * h }
    }

    /// Light of the photons around a point, weighed by phase.
    fn photons_in_media(&mut self, call: &MediaRay, point: DVec3) -> Rgb {
        let Some(maps) = self.plan.photons.as_deref() else { return Vec3::ZERO };
        let mut found = std::mem::take(&mut self.near_photons);
        let sum = maps.in_media(point, &mut found, |from| self.mean_phase(call, from));
        self.near_photons = found;
        sum
    }

    /// The mean of the media's phase values for light from direction `to_light`.
    fn mean_phase(&self, call: &MediaRay, to_light: DVec3) -> f64 {
        let cos = call.ray.dir.dot(to_light);
        call.media.iter().map(|ix| self.phase(ix, cos)).sum::<f64>() / call.media.len() as f64
    }

    /// A medium's phase value; those that do not scatter count as isotropic.
    fn phase(&self, ix: u32, cos: f64) -> f64 {
        let m = &self.scene.media[ix as usize].params;
        if is_dark(m.scattering) { 1.0 } else { phase_value(m.scattering_type, m.eccentricity, cos) }
    }

    fn light_at(&mut self, light_ix: u32, around: &InteriorList, point: DVec3) -> (Rgb, DVec3) {
        let CompiledLight { light, beam, .. } = &self.scene.lights[light_ix as usize];
        let way = light_ray(light, point, DVec3::ZERO);
        let color = light.color * attenuation(light, beam, point, &way) as f32;
        if is_dark(color) {
            return (color, way.dir);
        }
        // Shadow rays may cross media too, but they have scratch memory of their own.
        let color = match &light.area {
            Some(a) => self.through_area(light_ix, a, around, point, &way, color),
            None => self.unshadowed(light_ix, around, point, &way, color, Known::Nothing),
        };
        (color, way.dir)
    }

    fn density(&self, ix: u32, point: DVec3, ray_dir: DVec3) -> Rgb {
        let medium = &self.scene.media[ix as usize];
        if medium.densities.is_empty() {
            return Vec3::ONE;
        }
        let t = &self.scene.geometry.transforms[medium.transform_ix as usize];
        let p = PatternPoint { point: t.inverse_point(point), uv: DVec2::ZERO, world: point, normal: DVec3::ZERO, ray_dir };
        let mut product = Vec3::ONE;
        for d in &self.plan.media_densities[ix as usize] {
            product *= texturing::pigment(self.scene, *d, &p).map_or(Vec3::ONE, |c| c.rgb);
            if product == Vec3::ZERO {
                break;
            }
        }
        product
    }
}
