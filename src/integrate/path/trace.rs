//! One sample of a pixel: a path from the camera, light gathered at every hit.

use super::bounce::{Bounces, RayKind};
use super::catcher::{Part, mean};
use super::closure::{Shading, View, shade};
use super::passes::{From, Gather, Shares};
use super::plan::PathPlan;
use super::sampler::{Sampler, Set};
use super::shadow::{NEAR, ShadowRay};
use super::surface::Surface;
use super::volume::VolumeStack;
use crate::kernel::SurfaceHit;
use crate::kernel::bsdf::{Event, LobeSet};
use crate::math::{DVec3, Ray, Rgb, Vec3};

/// Events of one path at most, transparent surfaces included: a guard against scenes that never end.
const MAX_STEPS: u32 = 4096;

/// Traces samples; one a thread.
pub struct PathTracer<'p> {
    pub(super) plan: &'p PathPlan<'p>,
    /// What blocked a shadow ray last.
    pub(super) blocker: u32,
    /// Passes of the pixel under way, if any are asked for.
    pub(super) gather: Option<Box<Gather>>,
}

/// The samples of a pixel.
#[derive(Clone, Debug, Default)]
pub struct PixelResult {
    /// Mean of red, green, blue, transmit.
    pub color: [f32; 4],
    /// Mean colour of the samples of odd number.
    pub odd: [f32; 3],
    /// Values of the passes, in the order of the film's layers.
    pub layers: Vec<f32>,
}

/// Where the last scattering was: what lights met by chance are weighed against.
#[derive(Clone, Copy, Debug)]
pub(super) struct Origin {
    pub point: DVec3,
    /// Place for which lights were chosen: the same, but for volumes.
    pub select: DVec3,
    /// Normal that lights were drawn for, none where light comes from all sides.
    pub normal: Option<DVec3>,
    /// Density of the direction; infinite after mirrors and from the camera.
    pub pdf: f32,
    /// Way since then, through transparent surfaces.
    pub travelled: f64,
}

/// A path under way.
#[derive(Clone)]
pub(super) struct Path {
    pub ray: Ray,
    pub time: f64,
    pub throughput: Rgb,
    pub bounces: Bounces,
    pub origin: Origin,
    /// Smallest density of a bounce so far, for "filter glossy".
    pub min_pdf: f32,
    pub volumes: VolumeStack,
    pub sampler: Sampler,
    pub step: u32,
    /// What the camera sees so far.
    pub radiance: Rgb,
    /// Share of the background in the film.
    pub transmit: f32,
    /// What the first bounce was.
    pub first: Shares,
    /// For shadow catchers.
    pub part: Part,
}

/// Power heuristic.
pub(super) fn balance(a: f32, b: f32) -> f32 {
    if a.is_infinite() {
        return 1.0;
    }
    let (a, b) = (a * a, b * b);
    if a + b > 0.0 { a / (a + b) } else { 0.0 }
}

impl<'p> PathTracer<'p> {
    /// A tracer.
    pub fn new(plan: &'p PathPlan<'p>) -> Self {
        let gather = (!plan.passes.is_empty()).then(|| Box::new(Gather::new(plan.passes)));
        Self { plan, blocker: u32::MAX, gather }
    }

    /// Samples `range` of the pixel at (x, y).
    pub fn pixel(&mut self, x: u32, y: u32, range: std::ops::Range<u32>) -> PixelResult {
        if let Some(g) = &mut self.gather {
            g.start_pixel();
        }
        let (mut sum, mut odd, mut n_odd) = ([0.0f64; 4], [0.0f64; 3], 0u32);
        let n = f64::from(range.end - range.start);
        for k in range {
            let c = self.sample(x, y, k);
            (0..4).for_each(|i| sum[i] += f64::from(c[i]));
            if k % 2 == 1 {
                (0..3).for_each(|i| odd[i] += f64::from(c[i]));
                n_odd += 1;
            }
        }
        PixelResult {
            color: sum.map(|v| (v / n) as f32),
            odd: odd.map(|v| (v / f64::from(n_odd.max(1))) as f32),
            layers: self.gather.as_mut().map_or_else(Vec::new, |g| g.pixel()),
        }
    }

    /// Colour and transmit of sample `index` of the pixel at (x, y).
    pub fn sample(&mut self, x: u32, y: u32, index: u32) -> [f32; 4] {
        let plan = self.plan;
        let sampler = Sampler::new(x, y, plan.seed, index);
        let u = sampler.camera();
        let time = match (plan.has_motion, plan.settings.still) {
            (false, _) => -1.0,
            (true, true) => 0.5,
            (true, false) => f64::from(sampler.time()[0]),
        };
        let (px, py) = (f64::from(x) + plan.filter.offset(u[0]), f64::from(y) + plan.filter.offset(u[1]));
        if let Some(g) = &mut self.gather {
            g.start_sample();
        }
        let Some(ray) = plan.camera.ray(px, py, [u[2], u[3]], time.max(0.0)) else {
            let nothing = [0.0, 0.0, 0.0, 1.0];
            if let Some(g) = &mut self.gather {
                g.end_sample(nothing, true);
            }
            return nothing;
        };
        let mut path = Path {
            ray,
            time,
            throughput: Vec3::ONE,
            bounces: Bounces::camera(),
            origin: Origin { point: ray.origin, select: ray.origin, normal: None, pdf: f32::INFINITY, travelled: 0.0 },
            min_pdf: f32::MAX,
            volumes: plan.camera_volumes,
            sampler,
            step: 0,
            radiance: Vec3::ZERO,
            transmit: 0.0,
            first: Shares::DIFFUSE,
            part: Part::Before,
        };
        self.trace(&mut path);
        let c = path.radiance * plan.settings.exposure;
        let is_finite = c.is_finite();
        let c = if is_finite { [c.x, c.y, c.z, path.transmit] } else { [0.0, 0.0, 0.0, path.transmit] };
        if let Some(g) = &mut self.gather {
            g.end_sample(c, is_finite);
        }
        c
    }

    pub(super) fn trace(&mut self, path: &mut Path) {
        while path.step < MAX_STEPS {
            let survival = path.bounces.survival(path.throughput, &self.plan.settings);
            let skip = path.bounces.kind.skip_flags() | path.part.skip_flags();
            let hit = self.plan.intersect(&path.ray, path.time, NEAR, f64::INFINITY, skip);
            let t = hit.as_ref().map_or(f64::INFINITY, |h| h.t);
            // Lamps stand in the volumes: light of one comes through what lies before it alone.
            self.add_lamps(path, t);
            if !path.volumes.is_empty() && self.cross_volumes(path, t) {
                if !(path.throughput.max_element() > 0.0) {
                    return;
                }
                path.step += 1;
                continue;
            }
            let Some(hit) = hit else { return self.add_environment(path) };
            if !self.meet_surface(path, hit, survival) {
                return;
            }
            path.step += 1;
        }
    }

    /// Adds light to the picture, clamped as Cycles clamps: indirect is what bounced more than once.
    pub(super) fn add(&mut self, path: &mut Path, light: Rgb, from: From) {
        let s = &self.plan.settings;
        let bounces = path.bounces.total;
        let is_direct = matches!(from, From::Drawn(_)) && bounces == 0 || !matches!(from, From::Drawn(_)) && bounces <= 1;
        let limit = 3.0 * if is_direct { s.clamp_direct } else { s.clamp_indirect };
        let sum = light.abs().element_sum();
        let light = if limit > 0.0 && sum > limit { light * (limit / sum) } else { light };
        path.radiance += light;
        if let Some(g) = &mut self.gather {
            g.catcher_light(light * s.exposure, path.part);
            if path.part == Part::Alone {
                return;
            }
            g.light(light * s.exposure, from, bounces, path.first);
        }
    }

    /// Lamps that the ray meets before `t`.
    fn add_lamps(&mut self, path: &mut Path, t: f64) {
        let o = path.origin;
        let (kind, bounce) = (path.bounces.kind.visibility(), path.bounces.total);
        let mut sum = Vec3::ZERO;
        let plan = self.plan;
        let reach = if t.is_finite() { t + o.travelled } else { t };
        self.plan.lights.for_lamps_met(
            self.plan.scene,
            (o.point, o.select, o.normal),
            path.ray.dir,
            reach,
            (kind, bounce),
            |radiance, pdf, t| {
                if t > o.travelled {
                    let left = if path.volumes.is_empty() {
                        Vec3::ONE
                    } else {
                        plan.volume_transmittance(&path.volumes, &path.ray, t - o.travelled, path.sampler.stream(path.step) ^ 3)
                    };
                    sum += radiance * left * balance(o.pdf, pdf);
                }
            },
        );
        if sum != Vec3::ZERO {
            self.add(path, path.throughput * sum, From::Met);
        }
    }

    fn add_environment(&mut self, path: &mut Path) {
        let plan = self.plan;
        let env = &plan.lights.environment;
        let kind = path.bounces.kind;
        let (o, dir) = (path.origin, path.ray.dir);
        if kind == RayKind::Camera && plan.output_alpha {
            path.transmit += mean(path.throughput);
            if let Some(g) = &mut self.gather {
                g.left_open(mean(path.throughput), path.part);
            }
            if plan.settings.film_transparent {
                return;
            }
        }
        if env.sees(kind.visibility()) {
            let seen = env.for_camera.as_deref().filter(|_| kind == RayKind::Camera);
            let light = seen.unwrap_or(env).radiance(plan.scene, dir);
            let pdf = if o.pdf.is_finite() { plan.lights.environment_density(plan.scene, o.select, o.normal, dir) } else { 0.0 };
            self.add(path, path.throughput * light * balance(o.pdf, pdf), From::World);
            if seen.is_some() {
                return;
            }
            if let Some((radiance, pdf)) = plan.lights.sky_sun(plan.scene, o.select, o.normal, dir) {
                self.add(path, path.throughput * radiance * balance(o.pdf, pdf), From::World);
            }
        }
    }

    /// Light at a hit, and the way on; false at the end of the path.
    pub(super) fn meet_surface(&mut self, path: &mut Path, hit: SurfaceHit, survival: f32) -> bool {
        let plan = self.plan;
        let surface = Surface::new(plan.scene, hit, path.ray.dir, path.time).seen_by(path.bounces.kind.sort(path.origin.pdf.is_infinite()));
        let (shader, cover) = plan.material(&surface);
        let s = &plan.settings;
        // Caustics are what follows a diffuse bounce.
        let caustics = path.bounces.kind != RayKind::Diffuse;
        let view = View {
            reflective: s.caustics_reflective || caustics,
            refractive: s.caustics_refractive || caustics,
            // Light that goes below a surface would not be seen behind a diffuse one. Source: Cycles (measured).
            below: !path.bounces.has_been_diffuse(),
        };
        let mut shading = Shading::new(&surface);
        match shader {
            Some(shader) => shade(shader.surface.as_ref(), &surface, view, &mut shading),
            None => plan.pov_shading(&surface, cover, view, &mut shading),
        }
        shading.lobes.widen(least_width(s.filter_glossy, path.min_pdf));
        if path.bounces.total == 0 {
            self.split_at_catcher(path, &surface, hit, survival);
            self.make_hole(path, &surface, &mut shading);
            self.first_hit(path, &surface, &shading, shader);
        }
        if shading.emission.max_element() > 0.0 {
            let o = path.origin;
            let along = o.travelled + surface.hit.t;
            let pdf = if o.pdf.is_finite() {
                let from_last = SurfaceHit { t: along, ..surface.hit };
                plan.lights.triangle_density(plan.scene, &from_last, (o.point, o.select, o.normal), path.ray.dir, path.time)
            } else {
                0.0
            };
            self.add(path, path.throughput * shading.emission * balance(o.pdf, pdf), From::Met);
        }
        if let (Some(g), true) = (&mut self.gather, path.part != Part::Alone) {
            g.guide(plan, path, &surface, &shading);
            if plan.features_only && !g.wants_guides() {
                return false;
            }
        }
        if survival <= 0.0 {
            return false;
        }
        let light = path.sampler.at(path.step, Set::Light);
        if survival < 1.0 {
            if light[3] >= survival {
                return false;
            }
            path.throughput /= survival;
        }
        self.go_on(path, &surface, &shading, shader, light)
    }

    /// Draws what happens at a surface; `light` is its [`Set::Light`].
    fn go_on(
        &mut self,
        path: &mut Path,
        surface: &Surface,
        shading: &Shading,
        shader: Option<&crate::scene::Shader>,
        light: [f32; 4],
    ) -> bool {
        let plan = self.plan;
        let straight = shading.transparent.element_sum() / 3.0;
        let below = shading.subsurface.as_ref().map_or(0.0, |s| s.weight.element_sum() / 3.0);
        let lobes = shading.lobes.total_chance();
        let total = straight + below + lobes;
        if path.bounces.is_last && straight <= 0.0 {
            return false;
        }
        if !(total > 0.0) {
            return false;
        }
        if !path.bounces.is_last && shading.lobes.is_smooth() {
            self.add_direct(path, surface, &shading.lobes, light);
        }
        let choice = if straight > 0.0 || below > 0.0 { path.sampler.at(path.step, Set::Choice)[0] * total } else { f32::MAX };
        if choice < straight {
            path.throughput *= shading.transparent * (total / straight);
            path.bounces.passed(&plan.settings);
            path.origin.travelled += surface.hit.t;
            path.ray.origin = surface.hit.point;
            if plan.has_volumes {
                path.volumes.cross(plan, surface, shader);
            }
            return true;
        }
        if path.bounces.is_last {
            return false;
        }
        if let (Some(sub), true) = (&shading.subsurface, choice < straight + below) {
            path.throughput *= total / below;
            return self.walk_below(path, surface, sub);
        }
        path.throughput *= if straight > 0.0 || below > 0.0 { total / lobes } else { 1.0 };
        let Some(b) = shading.lobes.sample(surface.v, path.sampler.at(path.step, Set::Bsdf)) else { return false };
        path.throughput *= b.value / b.pdf;
        if !(path.throughput.max_element() > 0.0) {
            return false;
        }
        if plan.has_volumes && b.l.dot(surface.flat.as_vec3()) < 0.0 {
            path.volumes.cross(plan, surface, shader);
        }
        if self.gather.is_some() && path.bounces.total == 0 {
            path.first = match (b.singular, b.event) {
                (true, Event::Glossy) => Shares::Surface([Vec3::ZERO, Vec3::ONE]),
                (true, _) => Shares::Surface([Vec3::ZERO; 2]),
                _ => Shares::Surface(shading.lobes.shares(surface.v, b.l)),
            };
        }
        self.leave(path, surface, &light_normal(&shading.lobes), b.l, b.pdf, b.singular, b.event);
        true
    }

    /// Sets the path on its way from a surface.
    pub(super) fn leave(
        &self,
        path: &mut Path,
        surface: &Surface,
        normal: &Option<DVec3>,
        l: Vec3,
        pdf: f32,
        singular: bool,
        event: Event,
    ) {
        path.bounces.scattered(event, &self.plan.settings);
        let dir = l.as_dvec3().normalize();
        path.ray = Ray::new(surface.hit.point, dir);
        path.origin = Origin {
            point: surface.hit.point,
            select: surface.hit.point,
            normal: *normal,
            pdf: if singular { f32::INFINITY } else { pdf },
            travelled: 0.0,
        };
        if !singular {
            path.min_pdf = path.min_pdf.min(pdf);
        }
    }

    /// Light that comes straight from a lamp, a shining face or the sky.
    pub(super) fn add_direct(&mut self, path: &mut Path, surface: &Surface, lobes: &LobeSet, [u, v, pick, _]: [f32; 4]) {
        let plan = self.plan;
        if plan.lights.is_empty() || plan.features_only {
            return;
        }
        let normal = light_normal(lobes);
        let point = surface.hit.point;
        let Some(light) = plan.lights.sample(plan.scene, &plan.shaders, point, normal, path.time, [u, v, pick]) else { return };
        let shines = plan.shines_on(light.source, path.part);
        if !shines || !(light.radiance.max_element() > 0.0) || path.bounces.total > plan.lights.max_bounces(light.source) {
            return;
        }
        let l = light.dir.as_vec3();
        let (value, bsdf_pdf) = lobes.eval_for(surface.v, l, light.visibility);
        if !(value.max_element() > 0.0) {
            return;
        }
        let weight = if light.is_delta { 1.0 } else { balance(light.pdf, bsdf_pdf) };
        let contribution = path.throughput * value * light.radiance * (weight / light.pdf);
        let mut seen = Vec3::ONE;
        if light.cast_shadow {
            let from = shadow_start(surface, light.dir);
            // A lamp near by is seen from where the ray really starts.
            let (dir, distance) = if light.distance.is_finite() && from != point {
                let to = point + light.dir * light.distance - from;
                (to.normalize(), to.length())
            } else {
                (light.dir, light.distance)
            };
            let mut volumes = path.volumes;
            if plan.has_volumes && l.dot(surface.flat.as_vec3()) < 0.0 {
                volumes.cross(plan, surface, plan.material(surface).0);
            }
            let stream = path.sampler.stream(path.step);
            let ray = ShadowRay {
                from,
                dir,
                distance,
                time: path.time,
                volumes: &volumes,
                passed: path.bounces.transparent,
                stream,
                part: path.part,
            };
            seen = plan.transmittance(&ray, &mut self.blocker);
        }
        if seen != Vec3::ZERO {
            let shares = if self.gather.is_some() && path.bounces.total == 0 { lobes.shares(surface.v, l) } else { [Vec3::ZERO; 2] };
            self.add(path, contribution * seen, From::Drawn(Shares::Surface(shares)));
        }
    }
}

/// Where a shadow ray starts: a little above smooth faces that the light grazes, as Cycles' "shadow terminator geometry offset" of 0.1.
pub(super) fn shadow_start(surface: &Surface, dir: DVec3) -> DVec3 {
    const CUTOFF: f64 = 0.1;
    if !surface.is_smooth() {
        return surface.hit.point;
    }
    let transmits = surface.normal.dot(dir) < 0.0;
    let outward = if transmits { -surface.flat } else { surface.flat };
    let cos = outward.dot(dir);
    let amount = if cos < CUTOFF { (2.0 - cos.max(0.0) / CUTOFF * 2.0).clamp(0.0, 1.0) } else { 0.0 };
    if amount <= 0.0 {
        return surface.hit.point;
    }
    surface.hit.point.lerp(surface.raised_point(outward), amount)
}

/// Least width of lobes after a bounce of density `pdf`. Source: Cycles' "filter glossy".
fn least_width(filter_glossy: f32, pdf: f32) -> f32 {
    if filter_glossy <= 0.0 {
        return 0.0;
    }
    let sharp = pdf / filter_glossy;
    if sharp < 1.0 { (1.0 - sharp).sqrt() * 0.5 } else { 0.0 }
}

/// Normal that lights are drawn for: none where they may shine through.
fn light_normal(lobes: &LobeSet) -> Option<DVec3> {
    (!lobes.transmits()).then_some(lobes.normal.as_dvec3())
}
