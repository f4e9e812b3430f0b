//! A hit becomes a colour: covers, layers, finish, then what is seen through and in the mirror.
//! Source: spec/light.md, section 3; spec/textures.md, section 5.

use super::inline_vec::InlineVec;
use super::lights::LitLayer;
use super::ray::{Seen, TraceRay};
use super::refract::{Through, mirrored};
use super::texturing::{self as cover, Cover, Space};
use super::trace::Tracer;
use crate::compile::geometry::{Prim, prim_flags};
use crate::compile::texture::TextureNode;
use crate::kernel::finish::{reflect, reflected_power, reflectivity, thin_film};
use crate::kernel::{PatternPoint, SurfaceHit};
use crate::math::color::grey;
use crate::math::{DVec3, EPSILON, Rgb, Rgbft, Vec3};
use crate::scene::Finish;
use std::cell::Cell;

/// Everything about a hit that its layers share.
pub(super) struct HitContext<'h> {
    pub ray: &'h TraceRay,
    pub hit: &'h SurfaceHit,
    pub prim: &'h Prim,
    /// Geometric normal turned to the viewer.
    pub normal: DVec3,
    /// First of the hit's entries in `Tracer::lit`.
    pub lit_base: usize,
    pub weight: f64,
    /// The normal that slope and aoi look at: the last bent one, wherever in the hit's textures that was (measured).
    pub seen: Cell<DVec3>,
}

/// A mirror of a layer, traced after the layers.
#[derive(Clone, Copy, Default)]
pub(super) struct Mirror {
    pub factor: Rgb,
    pub normal: DVec3,
    pub weight: f64,
    finish: u32,
}

/// Layers of a plain texture: the first, and how many.
pub(super) type LayerRange = (u32, u32);

/// What the layers of a texture leave to be traced.
pub(super) struct Layered {
    rgb: Rgb,
    /// What the layers do to light behind them.
    pub factor: Rgb,
    /// Brightness of `factor`, 0..=1.
    pub trans: f64,
    /// Some layer had a colour.
    colored: bool,
    pub top_normal: DVec3,
    /// Of the top layer.
    pub top_finish: u32,
    pub mirrors: InlineVec<Mirror, 2>,
}

impl Layered {
    /// What the layers do to light that passes them.
    pub fn filter(&self) -> Rgb {
        if self.colored { self.factor } else { Vec3::ONE }
    }

    /// Whether total reflection at the top layer takes the place of a mirror.
    pub fn is_outdone(&self, m: &Mirror) -> bool {
        (m.normal - self.top_normal).abs().max_element() <= EPSILON
    }
}

impl Tracer<'_> {
    /// Colour and transmit of a hit, media of the way to it included.
    pub(super) fn shade(&mut self, r: &TraceRay, hit: &SurfaceHit, weight: f64) -> (Rgb, f32) {
        let g = &self.scene.geometry;
        let prim = &g.prims[hit.prim_ix as usize];
        let from_inside = hit.normal.dot(r.ray.dir) > 0.0;
        let normal = if from_inside { -hit.normal } else { hit.normal };
        let lit_base = self.lit.len();
        self.lit.resize(lit_base + self.plan.global_lights.len(), None);
        let ctx = HitContext { ray: r, hit, prim, normal, lit_base, weight, seen: Cell::new(normal) };
        let (mut rgb, mut transmit) = match cover::sole_cover_at(self.scene, hit, from_inside, self.adc_bailout) {
            Some(cover) => self.shade_cover(&ctx, cover),
            None => self.shade_covers(&ctx, from_inside),
        };
        self.lit.truncate(lit_base);
        if self.plan.has_media && self.sees_volumes(r) {
            (rgb, transmit) = self.inside_media(r, hit, rgb, transmit);
        }
        (rgb, transmit)
    }

    /// The mean of a hit's textures.
    #[inline(never)]
    fn shade_covers(&mut self, ctx: &HitContext, from_inside: bool) -> (Rgb, f32) {
        let (mut rgb, mut transmit) = (Vec3::ZERO, 0.0);
        for (cover, weight) in cover::covers_at(self.scene, ctx.hit, from_inside, self.adc_bailout).iter() {
            let (color, t) = self.shade_cover(ctx, cover);
            rgb += weight * color;
            transmit += weight * t;
        }
        (rgb, transmit)
    }

    fn shade_cover(&mut self, ctx: &HitContext, cover: Cover) -> (Rgb, f32) {
        let p = cover::pattern_point(self.scene, ctx.hit, ctx.prim, &cover, ctx.normal, ctx.ray.ray.dir);
        self.shade_texture(ctx, cover.texture, &p, &Space::of_cover(&cover, &ctx.seen), ctx.weight)
    }

    fn shade_texture(&mut self, ctx: &HitContext, texture: u32, p: &PatternPoint, space: &Space, weight: f64) -> (Rgb, f32) {
        let scene = self.scene;
        match &scene.textures.textures[texture as usize] {
            TextureNode::Layers { start, len } => {
                let layers = self.shade_layers(ctx, (*start, *len), p, space, weight);
                self.finish_layers(ctx, &layers, weight)
            }
            TextureNode::Principled(ix) => self.shade_principled(ctx, *ix, weight),
            node => {
                let parts = cover::blend(scene, node, p, space);
                let inner = Space { parent: Some(space), step: parts.step, seen: space.seen };
                let (mut rgb, mut transmit) = (Vec3::ZERO, 0.0);
                for k in 0..parts.entries.len() {
                    let (texture, share) = parts.entries.get(k);
                    let (color, t) = self.shade_texture(ctx, texture, &parts.point, &inner, weight);
                    rgb += share * color;
                    transmit += share * t;
                }
                (rgb, transmit)
            }
        }
    }

    /// Layers from the top (written last) to the bottom, their own light only.
    fn shade_layers(&mut self, ctx: &HitContext, layers: LayerRange, p: &PatternPoint, space: &Space, weight: f64) -> Layered {
        let (mut indirect, mut photons_gathered) = ([None; 2], None);
        let sees_photons = self.sees_photons(ctx);
        self.over_layers(ctx, layers, p, space, weight, &mut |tracer, layer, factor| {
            let mut own = Vec3::ZERO;
            let below = tracer.is_lit_from_below(layer);
            let plain = below.then(|| Finish { diffuse: 0.0, diffuse_back: 0.0, ..layer.finish.clone() });
            if below {
                own += tracer.subsurface_on_layer(ctx, layer, weight);
            }
            let layer = &LitLayer { finish: plain.as_ref().unwrap_or(layer.finish), ..*layer };
            if below && tracer.plan.shadows_draw && layer.finish.phong == 0.0 && layer.finish.specular == 0.0 {
                // POV-Ray asks the lamps although nothing of theirs is left, and what it draws for them shows elsewhere.
                tracer.lamps_on_layer(ctx, layer);
            }
            own += tracer.own_light(ctx, layer);
            if sees_photons {
                own += tracer.photons_on_layer(ctx, layer, &mut photons_gathered);
            }
            if tracer.radiosity_acts() {
                let weight = weight * f64::from(grey(factor * layer.color));
                if !(below && tracer.scene.settings.subsurface.is_some_and(|(.., indirect)| indirect)) {
                    own += tracer.indirect_on_layer(ctx, layer, &mut indirect, weight);
                }
            }
            own
        })
    }

    /// Goes through layers from the top to the bottom. `light` gives a layer's own light, and hears what the layers above it do to it.
    pub(super) fn over_layers(
        &mut self,
        ctx: &HitContext,
        (start, len): LayerRange,
        p: &PatternPoint,
        space: &Space,
        weight: f64,
        light: &mut impl FnMut(&mut Self, &LitLayer, Rgb) -> Rgb,
    ) -> Layered {
        let scene = self.scene;
        let quality = self.plan.quality;
        let mut out = Layered {
            rgb: Vec3::ZERO,
            factor: Vec3::ONE,
            trans: 1.0,
            colored: false,
            top_normal: ctx.normal,
            top_finish: crate::compile::NONE,
            mirrors: InlineVec::default(),
        };
        for (nth, k) in (start..start + len).rev().enumerate() {
            let layer = scene.textures.layers[k as usize];
            let mut normal = ctx.normal;
            if quality.normals && layer.normal != crate::compile::NONE {
                normal = cover::perturb(scene, layer.normal, normal, p, space);
            }
            if nth == 0 {
                (out.top_normal, out.top_finish) = (normal, layer.finish);
            }
            let found = cover::layer_color(scene, layer.pigment, p, space.seen.get(), quality.quick_colors);
            let color = found.unwrap_or(Rgbft::CLEAR);
            if !quality.lights {
                out.rgb += out.factor * color.rgb;
                out.trans = 0.0;
                return out;
            }
            let finish = &scene.textures.finishes[layer.finish as usize];
            let mirror = self.mirror_factor(ctx, finish, normal, color.rgb);
            if let (Some(factor), true) = (mirror, quality.reflection) {
                let strength = if finish.reflection.fresnel { factor } else { finish.reflection.max.max(finish.reflection.min) };
                let weight = weight * out.trans * f64::from(strength.max_element());
                out.mirrors.push(Mirror { factor, normal, weight, finish: layer.finish });
            }
            let att = if self.plan.modern {
                f64::from(color.opacity())
            } else {
                1.0 - f64::from(color.filter * color.rgb.max_element() + color.transmit)
            };
            let irid_noise = if finish.irid[0] != 0.0 { cover::irid_noise(scene, finish, ctx.hit.point) } else { 0.5 };
            let own = light(self, &LitLayer { finish, normal, color: color.rgb, att, irid_noise }, out.factor);
            out.rgb += out.factor * own;
            if found.is_some() {
                out.colored = true;
                out.factor *= color.transmittance();
                if let (Some(r), true) = (mirror, finish.conserve_energy) {
                    out.factor *= (Vec3::ONE - r).min(Vec3::ONE);
                }
            }
            out.trans = f64::from(grey(out.factor).abs()).min(1.0);
            if out.trans <= self.adc_bailout {
                break;
            }
        }
        out
    }

    /// Reflectivity of a finish, if it has any.
    fn mirror_factor(&self, ctx: &HitContext, finish: &Finish, normal: DVec3, color: Rgb) -> Option<Rgb> {
        let refl = &finish.reflection;
        if refl.min == Vec3::ZERO && refl.max == Vec3::ZERO {
            return None;
        }
        let ior = if refl.fresnel { self.relative_ior(&ctx.ray.interiors, ctx.prim.interior_ix) } else { 1.0 };
        Some(reflectivity(refl, -ctx.ray.ray.dir.dot(normal), ior, color))
    }

    /// Ambient, emission and the light of lamps on one layer.
    fn own_light(&mut self, ctx: &HitContext, layer: &LitLayer) -> Rgb {
        let settings = &self.scene.settings;
        let LitLayer { finish, color, att, .. } = *layer;
        let mut sum = Vec3::ZERO;
        let gathered = self.plan.quality.volumes && settings.radiosity.is_some();
        if !(gathered && self.plan.modern) {
            sum += color * finish.ambient * settings.ambient_light * att as f32;
        }
        sum += color * finish.emission * att as f32;
        if finish.diffuse != 0.0 || finish.diffuse_back != 0.0 || finish.specular != 0.0 || finish.phong != 0.0 {
            sum += self.lamps_on_layer(ctx, layer);
        }
        sum
    }

    /// Indirect light on a layer, in front and from behind; looked up for the first layer that asks and kept for those below.
    fn indirect_on_layer(
        &mut self,
        ctx: &HitContext,
        &LitLayer { finish, normal, color, att, .. }: &LitLayer,
        known: &mut [Option<Rgb>; 2],
        weight: f64,
    ) -> Rgb {
        let mut sum = Vec3::ZERO;
        for (side, sign) in [(0, 1.0), (1, -1.0)] {
            let share = att * f64::from(finish.diffuse_raw[side]);
            let weight = weight * share;
            if known[side].is_none() && finish.diffuse_raw[side] != 0.0 && weight > self.adc_bailout * ctx.weight {
                known[side] = Some(self.indirect_light(ctx, sign * normal, sign * ctx.normal, weight));
            }
            sum += known[side].unwrap_or(Vec3::ZERO) * color * share as f32;
        }
        sum
    }

    /// Adds what is seen through the layers and in their mirrors.
    fn finish_layers(&mut self, ctx: &HitContext, layers: &Layered, weight: f64) -> (Rgb, f32) {
        let (mut rgb, mut transmit, mut total_reflection) = (layers.rgb, 0.0, false);
        if self.plan.quality.refraction && layers.trans > self.adc_bailout {
            let weight = weight * f64::from(layers.factor.abs().max_element());
            let attenuation = self.interior_attenuation(ctx);
            match self.through(ctx, (layers.top_normal, layers.top_finish), weight) {
                Through::Transmitted(seen) => {
                    rgb += attenuation * layers.filter() * seen.rgb;
                    transmit = layers.trans as f32 * seen.transmit;
                }
                Through::TotallyReflected(seen) => {
                    total_reflection = true;
                    rgb += attenuation * seen.rgb;
                }
            }
        }
        for k in 0..layers.mirrors.len() {
            let m = layers.mirrors.get(k);
            if !(total_reflection && layers.is_outdone(&m)) {
                rgb += m.factor * self.in_mirror(ctx, &m);
            }
        }
        (rgb, transmit)
    }

    fn in_mirror(&mut self, ctx: &HitContext, m: &Mirror) -> Rgb {
        let finish = &self.scene.textures.finishes[m.finish as usize];
        let dir = reflect(ctx.ray.ray.dir, m.normal, ctx.normal);
        let seen = self.reflected_ray(ctx, dir, m.weight);
        reflected_power(seen.rgb * self.film(ctx, m.finish, m.normal, dir), finish.reflection.exponent)
    }

    /// What the thin film of a finish (or `NONE`) makes of light that leaves along `dir`.
    pub(super) fn film(&self, ctx: &HitContext, finish: u32, normal: DVec3, dir: DVec3) -> Rgb {
        let Some(finish) = self.scene.textures.finishes.get(finish as usize).filter(|f| f.irid[0] != 0.0) else { return Vec3::ONE };
        let noise = cover::irid_noise(self.scene, finish, ctx.hit.point);
        thin_film(finish, self.scene.settings.irid_wavelength, ctx.ray.ray.dir, normal, dir, noise)
    }

    /// Traces a ray that leaves the hit on the side it came from.
    pub(super) fn reflected_ray(&mut self, ctx: &HitContext, dir: DVec3, weight: f64) -> Seen {
        self.trace(&mirrored(ctx, dir), weight, false)
    }

    /// Whether both sides of the hit are lit.
    pub(super) fn double_illuminated(ctx: &HitContext) -> bool {
        ctx.prim.flags & prim_flags::DOUBLE_ILLUMINATE != 0
    }
}
