//! The light of lamps on one layer of a surface. Source: spec/light.md, section 6.

use super::shade::HitContext;
use super::shafts::Known;
use super::trace::Tracer;
use crate::compile::geometry::prim_flags;
use crate::kernel::finish::{highlights, power, thin_film};
use crate::kernel::light::{area_axes, area_offset, attenuation, light_ray};
use crate::math::random::UniformStream;
use crate::math::{DVec3, EPSILON, Rgb, Vec3};
use crate::savings::Saving;
use crate::scene::light::LightKind;
use crate::scene::{Finish, Light};

/// A layer as lamps see it.
pub(super) struct LitLayer<'l> {
    pub finish: &'l Finish,
    pub normal: DVec3,
    pub color: Rgb,
    /// How much of the layer is opaque.
    pub att: f64,
    pub irid_noise: f64,
}

impl LitLayer<'_> {
    /// Whether nothing of the light on one side is scattered: no share, a black or clear layer.
    #[inline]
    fn is_idle(&self, behind: bool) -> bool {
        let f = self.finish;
        let diffuse = if behind { f.diffuse_back } else { f.diffuse };
        diffuse == 0.0 || f.crand == 0.0 && (self.att == 0.0 || self.color == Vec3::ZERO)
    }
}

/// Whether a lamp lies behind a surface beyond any rounding, told without a root and a quotient.
#[inline]
fn is_well_behind(light: &Light, point: DVec3, normal: DVec3) -> bool {
    if light.parallel || !matches!(light.kind, LightKind::Point | LightKind::Spot { .. }) {
        return false;
    }
    let to = light.location - point;
    to.dot(normal) < -1e-9 * (to.x.abs() + to.y.abs() + to.z.abs())
}

/// Whether a light's colour is too dark to matter.
#[inline]
pub(super) fn is_dark(c: Rgb) -> bool {
    c.abs().max_element() < EPSILON as f32
}

/// Grid index of an area light, moved by up to half a cell when jittered.
#[inline]
pub(super) fn area_place(random: &mut UniformStream, index: u32, jitter: bool) -> f64 {
    let place = f64::from(index);
    if jitter { place + random.draw() - 0.5 } else { place }
}

impl Tracer<'_> {
    /// All lamps that shine on the hit's object, on one layer.
    pub(super) fn lamps_on_layer(&mut self, ctx: &HitContext, layer: &LitLayer) -> Rgb {
        let plan = self.plan;
        self.photons_replace = self.sees_photons(ctx);
        let mut sum = Vec3::ZERO;
        let f = layer.finish;
        let is_dull = f.phong == 0.0 && f.specular == 0.0 && layer.is_idle(false) && layer.is_idle(true);
        if is_dull && !plan.shadows_draw && self.scene.options.savings.has(Saving::Lights) {
            return sum;
        }
        if ctx.prim.flags & prim_flags::NO_GLOBAL_LIGHTS == 0 {
            for (k, light_ix) in plan.global_lights.iter().enumerate() {
                sum += self.lamp(ctx, layer, *light_ix, Some(ctx.lit_base + k));
            }
        }
        if let Some(lights) = plan.group_lights.get(ctx.prim.group_ix as usize) {
            for light_ix in lights {
                sum += self.lamp(ctx, layer, *light_ix, None);
            }
        }
        sum
    }

    /// One lamp on one layer. `memo` is the place of its filtered colour in `Tracer::lit`.
    fn lamp(&mut self, ctx: &HitContext, layer: &LitLayer, light_ix: u32, memo: Option<usize>) -> Rgb {
        let scene = self.scene;
        let compiled = &scene.lights[light_ix as usize];
        let light = &compiled.light;
        let point = ctx.hit.point;
        let area = light.area.as_ref().filter(|_| self.plan.quality.area_lights && !ctx.ray.gathers);
        let spread = area.filter(|a| a.area_illumination);
        let is_seen_behind = layer.finish.diffuse_back != 0.0 || spread.is_some() || Self::double_illuminated(ctx);
        if !is_seen_behind && scene.options.savings.has(Saving::Lights) && is_well_behind(light, point, layer.normal) {
            return Vec3::ZERO;
        }
        let way = light_ray(light, point, DVec3::ZERO);
        let arriving = if spread.is_some() { light.color } else { light.color * attenuation(light, &compiled.beam, point, &way) as f32 };
        if is_dark(arriving) {
            return Vec3::ZERO;
        }
        let mut behind = false;
        if spread.is_none() && !Self::double_illuminated(ctx) && way.dir.dot(layer.normal) < EPSILON {
            if layer.finish.diffuse_back == 0.0 {
                // Media draw random numbers on the way, which would show elsewhere.
                if !scene.options.savings.has(Saving::Lights) && self.plan.quality.shadows && !self.plan.has_media {
                    self.unshadowed(light_ix, &ctx.ray.interiors, point, &way, arriving, Known::Nothing);
                }
                return Vec3::ZERO;
            }
            behind = true;
        }
        if spread.is_none() && !self.draws_on_the_way(light) && self.gives_nothing_back(ctx, layer, way.dir, behind, !light.shadowless) {
            return Vec3::ZERO;
        }
        let tested = self.plan.quality.shadows && (!light.shadowless || compiled.projected_through != crate::compile::NONE);
        let filtered = match memo.and_then(|k| self.lit[k]) {
            _ if !tested => arriving,
            Some(known) => known,
            None => {
                let c = match area {
                    Some(a) => self.through_area(light_ix, a, &ctx.ray.interiors, point, &way, arriving),
                    None => self.unshadowed(light_ix, &ctx.ray.interiors, point, &way, arriving, Known::Nothing),
                };
                if let Some(k) = memo {
                    self.lit[k] = Some(c);
                }
                c
            }
        };
        if is_dark(filtered) {
            return Vec3::ZERO;
        }
        let Some(a) = spread else { return self.answer(ctx, layer, way.dir, filtered, behind, !light.shadowless) };
        let mut sum = Vec3::ZERO;
        let share = filtered / (a.n1 * a.n2) as f32;
        let axes = area_axes(a, way.dir);
        for v in 0..a.n2 {
            for u in 0..a.n1 {
                let offset = area_offset(a, axes, area_place(&mut self.random, u, a.jitter), area_place(&mut self.random, v, a.jitter));
                let way = light_ray(light, point, offset);
                let color = share * attenuation(light, &compiled.beam, point, &way) as f32;
                let mut behind = false;
                if !Self::double_illuminated(ctx) && way.dir.dot(layer.normal) < EPSILON {
                    if layer.finish.diffuse_back == 0.0 {
                        continue;
                    }
                    behind = true;
                }
                sum += self.answer(ctx, layer, way.dir, color, behind, !light.shadowless);
            }
        }
        sum
    }

    /// Whether a shadow ray to a lamp draws random numbers: leaving it out would show elsewhere.
    fn draws_on_the_way(&self, light: &Light) -> bool {
        self.plan.has_media || light.area.as_ref().is_some_and(|a| a.jitter) || !self.scene.options.savings.has(Saving::Lights)
    }

    /// Whether [`Self::answer`] is 0 whatever the light's colour is: black and clear layers, off their highlights.
    fn gives_nothing_back(&self, ctx: &HitContext, layer: &LitLayer, dir: DVec3, behind: bool, glints: bool) -> bool {
        let f = layer.finish;
        layer.is_idle(behind)
            && !(self.glints_at(ctx, f, behind, glints) && highlights(f, ctx.ray.ray.dir, layer.normal, dir, layer.color) != Vec3::ZERO)
    }

    /// Whether light makes highlights.
    #[inline]
    fn glints_at(&self, ctx: &HitContext, f: &Finish, behind: bool, glints: bool) -> bool {
        !behind && glints && !ctx.ray.gathers && (f.phong != 0.0 || f.specular != 0.0)
    }

    /// What a layer gives back of light of a colour from direction `dir`; only light that `glints` makes highlights.
    pub(super) fn answer(&mut self, ctx: &HitContext, layer: &LitLayer, dir: DVec3, color: Rgb, behind: bool, glints: bool) -> Rgb {
        let f = layer.finish;
        let mut sum = Vec3::ZERO;
        let diffuse = f64::from(if behind { f.diffuse_back } else { f.diffuse });
        if diffuse != 0.0 {
            let cos = layer.normal.dot(dir).abs();
            let mut intensity = diffuse * layer.att * power(cos, f64::from(f.brilliance));
            if f.crand != 0.0 {
                intensity -= self.grain.draw() * f64::from(f.crand);
            }
            sum += intensity as f32 * layer.color * color;
        }
        if self.glints_at(ctx, f, behind, glints) {
            sum += highlights(f, ctx.ray.ray.dir, layer.normal, dir, layer.color) * color;
        }
        if f.irid[0] != 0.0 {
            sum *= thin_film(f, self.scene.settings.irid_wavelength, ctx.ray.ray.dir, layer.normal, dir, layer.irid_noise);
        }
        sum
    }
}
