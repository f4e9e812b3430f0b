//! Subsurface light: what enters a surface elsewhere, scatters below it and leaves at a hit. It takes the place of a layer's diffuse light.
//!
//! Three parts: light that scattered often (`diffuse_part`, a dipole sampled from a point below the hit), light that scattered once along
//! the refracted ray (`single_part`), and what lies behind, seen through without scattering (`straight_part`). The directions are Halton
//! points, the ways drawn from a stream of their own, both running on from hit to hit: POV-Ray's numbers, with one thread.
//! Source: spec/light.md, section 10, measured to the last digit of 16 bits on planes and slabs.

mod medium;

pub use medium::AlbedoTable;

use super::lights::{LitLayer, is_dark};
use super::shade::HitContext;
use super::shafts::Known;
use super::trace::Tracer;
use crate::compile::{CompiledScene, NONE};
use crate::kernel::SurfaceHit;
use crate::kernel::light::{LightRay, attenuation, light_ray};
use crate::kernel::traverse::intersect_below;
use crate::math::random::{SplitMix64, halton, uniform_table};
use crate::math::{DVec3, Ray, Rgb, Vec3};
use medium::{Medium, passing, refracted_cos};
use std::cell::Cell;
use std::f64::consts::{PI, TAU};
use std::sync::LazyLock;

/// Surfaces seen through surfaces that are still lit from below: deeper ones stay black.
const MAX_DEPTH: usize = 2;

/// Numbers of a sequence before it begins anew: directions, and random numbers, whose last of the table never comes (measured).
const PERIOD: u32 = 32_767;

/// Halton points on the sphere, all that there are before they begin anew.
static DIRECTIONS: LazyLock<Vec<DVec3>> = LazyLock::new(|| {
    let direction = |k: u32| {
        let (x, angle) = (2.0 * halton(k, 2) - 1.0, TAU * halton(k, 3));
        let r = (1.0 - x * x).max(0.0).sqrt();
        DVec3::new(x, r * angle.cos(), r * angle.sin())
    };
    (0..PERIOD).map(direction).collect()
});

/// A ray that starts on a surface does not meet it again within this depth.
const OFF_SURFACE: f64 = 1e-6;

/// What subsurface light remembers from hit to hit.
#[derive(Clone, Debug, Default)]
pub(super) struct SubsurfaceState {
    /// Subsurface light being worked out.
    depth: usize,
    /// Running position in the directions, by depth.
    directions: [u32; MAX_DEPTH],
    /// Running position in the random numbers for ways before the first scattering, by depth.
    ways: [u32; MAX_DEPTH],
}

impl SubsurfaceState {
    /// A state whose sequences start anywhere.
    pub fn seeded(seeds: &mut SplitMix64) -> Self {
        let mut places = || std::array::from_fn(|_| seeds.below(PERIOD as usize) as u32);
        Self { depth: 0, directions: places(), ways: places() }
    }

    /// The next direction, unit, all alike.
    fn direction(&mut self) -> DVec3 {
        let position = &mut self.directions[self.depth - 1];
        let direction = DIRECTIONS[*position as usize];
        *position = (*position + 1) % PERIOD;
        direction
    }

    /// The next number, 0..1.
    fn draw(&mut self) -> f64 {
        let position = &mut self.ways[self.depth - 1];
        *position = (*position + 1) % PERIOD;
        uniform_table()[*position as usize]
    }
}

/// Tables for the indices of refraction of a scene, and by interior the place of its own; nothing for scenes without subsurface light.
pub(super) fn albedo_tables(scene: &CompiledScene) -> (Vec<AlbedoTable>, Vec<u32>) {
    let mut tables: Vec<AlbedoTable> = Vec::new();
    if !scene.features.subsurface {
        return (tables, Vec::new());
    }
    let places = scene.interiors.iter().map(|interior| {
        let known = tables.iter().position(|t| t.ior == interior.ior);
        known.unwrap_or_else(|| {
            tables.push(AlbedoTable::new(interior.ior));
            tables.len() - 1
        }) as u32
    });
    let places = places.collect();
    (tables, places)
}

/// A hit whose light from below is asked for.
struct Exit<'e, 'h> {
    ctx: &'e HitContext<'h>,
    medium: Medium,
    /// Index of the medium over that of the ray's side.
    ior: f64,
    mm_per_unit: f64,
    /// Share of light that passes the surface towards the viewer.
    passing: f64,
    /// Radiosity's light enters too.
    indirect: bool,
    /// Weight of the ray.
    weight: f64,
}

impl Exit<'_, '_> {
    fn is_own(&self, scene: &CompiledScene, hit: &SurfaceHit) -> bool {
        scene.geometry.prims[hit.prim_ix as usize].interior_ix == self.ctx.prim.interior_ix
    }
}

impl Tracer<'_> {
    /// Whether light from below takes the place of a layer's diffuse light.
    pub(super) fn is_lit_from_below(&self, layer: &LitLayer) -> bool {
        layer.finish.subsurface.is_some() && self.plan.quality.volumes && self.scene.settings.subsurface.is_some()
    }

    /// The light that leaves a layer from below.
    pub(super) fn subsurface_on_layer(&mut self, ctx: &HitContext, layer: &LitLayer, weight: f64) -> Rgb {
        let (Some(translucency), Some((n_diffuse, n_single, indirect))) = (layer.finish.subsurface, self.scene.settings.subsurface) else {
            return Vec3::ZERO;
        };
        let depth = self.subsurface.depth;
        // Gather rays find such surfaces dark unless radiosity asks for more (measured).
        if depth >= MAX_DEPTH || ctx.ray.gathers && !self.radiosity.as_ref().is_some_and(|s| s.sees_subsurface()) {
            return Vec3::ZERO;
        }
        self.photons_replace = self.sees_photons(ctx);
        let plan = self.plan;
        let table = &plan.albedos.0[plan.albedos.1[ctx.prim.interior_ix as usize] as usize];
        let ior = self.relative_ior(&ctx.ray.interiors, ctx.prim.interior_ix);
        let exit = Exit {
            ctx,
            medium: Medium::new(table, ior, layer.color * layer.finish.diffuse_raw[0], translucency),
            ior,
            mm_per_unit: self.scene.settings.mm_per_unit,
            passing: passing(ior, -ctx.ray.ray.dir.dot(ctx.normal)),
            indirect,
            weight,
        };
        let (n_diffuse, n_single) = if depth == 0 { (n_diffuse, n_single) } else { (1, 1) };
        self.subsurface.depth += 1;
        let mut sum = self.diffuse_part(&exit, n_diffuse);
        let passage = self.passage(&ctx.ray.interiors, ctx.prim.interior_ix);
        if let Some(dir) = passage.bend(ctx.ray.ray.dir, ctx.normal) {
            let ray = Ray::new(ctx.hit.point, dir);
            let far = intersect_below(self.scene, &ray, OFF_SURFACE, f64::INFINITY);
            sum += self.single_part(&exit, n_single, &ray, far.as_ref().map_or(f64::INFINITY, |h| h.t));
            if let Some(far) = far.filter(|h| exit.is_own(self.scene, h)) {
                sum += self.straight_part(&exit, &ray, &far);
            }
        }
        self.subsurface.depth -= 1;
        sum
    }

    /// Light that scattered many times: points on the surface around the hit, found from one below it, give what they receive.
    fn diffuse_part(&mut self, exit: &Exit, n: u32) -> Rgb {
        let (scene, hit, mm) = (self.scene, exit.ctx.hit, exit.mm_per_unit);
        let inward = -exit.ctx.normal;
        let mut depth = exit.medium.mean_free_path() / mm;
        // Thin walls: half way to the other side; nothing else is entered (measured).
        if let Some(back) = intersect_below(scene, &Ray::new(hit.point, inward), OFF_SURFACE, 2.0 * depth) {
            depth = depth.min(if exit.is_own(scene, &back) { 0.5 * back.t } else { back.t });
        }
        let base = hit.point + depth * inward;
        let (mut sum, mut n_valid) = (Vec3::ZERO, 0u32);
        for _ in 0..n {
            let ray = Ray::new(base, self.subsurface.direction());
            let Some(entry) = intersect_below(scene, &ray, 0.0, f64::INFINITY) else { continue };
            // Whatever is met counts, but only the medium's own surface gives light (measured).
            n_valid += 1;
            if !exit.is_own(scene, &entry) {
                continue;
            }
            let way = entry.t * mm;
            let area = 4.0 * PI * way * way / ray.dir.dot(entry.normal).abs().max(0.01);
            let share = exit.medium.dipole((entry.point - hit.point).length() * mm) * (area * exit.passing) as f32;
            if share != Vec3::ZERO {
                sum += share * self.entering(exit, &entry, ray.dir);
            }
        }
        if n_valid == 0 { Vec3::ZERO } else { sum / n_valid as f32 }
    }

    /// Light of lamps that passes the surface at a point, by area.
    fn entering(&mut self, exit: &Exit, entry: &SurfaceHit, to_entry: DVec3) -> Rgb {
        let mut sum = Vec3::ZERO;
        self.for_lamps(exit.ctx, |tracer, light_ix| {
            let way = light_ray(&tracer.scene.lights[light_ix as usize].light, entry.point, DVec3::ZERO);
            // From either side (measured).
            let cos = way.dir.dot(entry.normal).abs();
            let share = cos * passing(exit.ior, cos);
            if share > 0.0 {
                sum += tracer.arriving(exit, light_ix, entry.point, &way) * share as f32;
            }
        });
        if exit.indirect && self.radiosity_acts() {
            let prim = &self.scene.geometry.prims[entry.prim_ix as usize];
            let outward = entry.normal * (entry.normal.dot(to_entry)).signum();
            let ctx = HitContext { hit: entry, prim, normal: outward, seen: Cell::new(outward), ..*exit.ctx };
            // As light that comes along the normal (measured).
            sum += self.indirect_light(&ctx, outward, outward, exit.weight) * passing(exit.ior, 1.0) as f32;
        }
        sum
    }

    /// Light that scattered once on the refracted ray, before anything stands in the way at depth `far`.
    fn single_part(&mut self, exit: &Exit, n: u32, ray: &Ray, far: f64) -> Rgb {
        let ctx = exit.ctx;
        let out_cos = ray.dir.dot(ctx.normal).abs();
        let mut sum = Vec3::ZERO;
        for _ in 0..n {
            for k in 0..3 {
                let channel = exit.medium.channels[k];
                let way_out = -self.subsurface.draw().ln() / channel.extinction;
                let depth = way_out / exit.mm_per_unit;
                // Also where these are no numbers.
                if !(depth > 0.0 && depth < far) {
                    continue;
                }
                let place = ray.at(depth);
                self.for_lamps(ctx, |tracer, light_ix| {
                    let scene = tracer.scene;
                    // Straight to the light, as if the surface did not bend it.
                    let to_light = Ray::new(place, light_ray(&scene.lights[light_ix as usize].light, place, DVec3::ZERO).dir);
                    let Some(entry) = intersect_below(scene, &to_light, 0.0, f64::INFINITY).filter(|h| exit.is_own(scene, h)) else {
                        return;
                    };
                    let way = light_ray(&scene.lights[light_ix as usize].light, entry.point, DVec3::ZERO);
                    let cos = way.dir.dot(entry.normal).abs();
                    let in_cos = refracted_cos(exit.ior, cos);
                    let way_in = entry.t * exit.mm_per_unit * cos / in_cos;
                    let slant = out_cos / in_cos;
                    let lost = channel.extinction * (way_in + way_out);
                    let share = channel.scattering * passing(exit.ior, cos) * exit.passing / 4.0 / (channel.extinction * (1.0 + slant))
                        * (-lost).exp()
                        * cos;
                    if share > 0.0 {
                        sum[k] += tracer.arriving(exit, light_ix, entry.point, &way)[k] * share as f32;
                    }
                });
            }
        }
        if n == 0 { Vec3::ZERO } else { sum / n as f32 }
    }

    /// What is seen through the medium, beyond the surface at `far`.
    fn straight_part(&mut self, exit: &Exit, ray: &Ray, far: &SurfaceHit) -> Rgb {
        let ctx = exit.ctx;
        let left = exit.medium.by_channel(|c| (-c.extinction * far.t * exit.mm_per_unit).exp());
        let inside = self.passage(&ctx.ray.interiors, ctx.prim.interior_ix).beyond().clone();
        let passage = self.passage(&inside, ctx.prim.interior_ix);
        let Some(dir) = passage.bend(ray.dir, far.normal) else { return Vec3::ZERO };
        let onward = ctx.ray.onward(far.point, dir, passage.beyond());
        left * self.trace(&onward, exit.weight * f64::from(left.max_element()), false).rgb
    }

    /// Calls `f` with the lamps that shine on the hit's object.
    fn for_lamps(&mut self, ctx: &HitContext, mut f: impl FnMut(&mut Self, u32)) {
        let plan = self.plan;
        if ctx.prim.flags & crate::compile::geometry::prim_flags::NO_GLOBAL_LIGHTS == 0 {
            plan.global_lights.iter().for_each(|k| f(self, *k));
        }
        if let Some(lights) = plan.group_lights.get(ctx.prim.group_ix as usize) {
            lights.iter().for_each(|k| f(self, *k));
        }
    }

    /// What arrives of a lamp at a point of the surface.
    fn arriving(&mut self, exit: &Exit, light_ix: u32, point: DVec3, way: &LightRay) -> Rgb {
        let compiled = &self.scene.lights[light_ix as usize];
        let light = &compiled.light;
        let color = light.color * attenuation(light, &compiled.beam, point, way) as f32;
        if is_dark(color) || light.shadowless && compiled.projected_through == NONE {
            return color;
        }
        let around = &exit.ctx.ray.interiors;
        match light.area.as_ref().filter(|_| !exit.ctx.ray.gathers) {
            Some(area) => self.through_area(light_ix, area, around, point, way, color),
            None => self.unshadowed(light_ix, around, point, way, color, Known::Nothing),
        }
    }
}
