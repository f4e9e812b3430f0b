//! A photon's way through the scene: to its target, through it and off it, until it is too weak. It leaves a trace wherever it meets a
//! surface after its target. Nothing is left to chance: where light splits, both ways are followed. Source: spec/light.md, section 9.

use super::super::lights::is_dark;
use super::super::ray::{InteriorList, TraceRay};
use super::super::refract::{Bent, Onward, bent, fade_factor, mirrored, straight};
use super::super::shade::{HitContext, LayerRange, Layered};
use super::super::texturing::{Cover, Space, blend, covers_at, pattern_point};
use super::super::trace::{MAX_RECURSION, Tracer};
use super::emission::{Emission, Shot, allows};
use super::map::Photon;
use crate::compile::geometry::prim_flags;
use crate::compile::texture::TextureNode;
use crate::kernel::finish::reflect;
use crate::kernel::light::fade;
use crate::kernel::traverse::{MIN_DEPTH, intersect};
use crate::kernel::{PatternPoint, SurfaceHit};
use crate::math::{Rgb, Vec3};
use crate::scene::settings::Photons;
use std::cell::Cell;

/// What photons left.
#[derive(Clone, Debug, Default)]
pub struct Deposits {
    pub surface: Vec<Photon>,
    pub media: Vec<Photon>,
    /// Some photon met its target.
    pub met_target: bool,
}

/// A photon between two surfaces.
struct Flight {
    ray: TraceRay,
    power: Rgb,
    weight: f64,
    /// Length of the way so far.
    path: f64,
    /// It has met its target.
    aimed: bool,
}

/// The photons of one pair that a tracer follows.
pub struct PhotonTracer<'t, 'a> {
    pub tracer: &'t mut Tracer<'a>,
    pub emission: &'t Emission<'t>,
    pub settings: &'t Photons,
    pub out: Deposits,
}

impl PhotonTracer<'_, '_> {
    /// Follows a photon from its light, which stands in `around`.
    pub fn follow(&mut self, shot: &Shot, around: &InteriorList) {
        let ray = TraceRay::primary(shot.ray, around.clone());
        self.fly(&Flight { ray, power: shot.power, weight: 1.0, path: shot.path, aimed: false });
    }

    /// Every surface counts a level, also one that does not bend light (measured).
    fn fly(&mut self, f: &Flight) {
        let t = &mut *self.tracer;
        if t.level >= t.max_level || f.weight < t.adc_bailout || t.recursion >= MAX_RECURSION || t.is_stopped() {
            return;
        }
        t.level += 1;
        t.recursion += 1;
        // As other rays, and what casts no shadow is no hindrance.
        let unseen = if f.ray.reflected { prim_flags::NO_REFLECTION } else { prim_flags::NO_IMAGE };
        if let Some(hit) = intersect(t.scene, &f.ray.ray, MIN_DEPTH, f64::INFINITY, unseen | prim_flags::NO_SHADOW) {
            self.land(f, &hit);
        }
        self.tracer.level -= 1;
        self.tracer.recursion -= 1;
    }

    fn land(&mut self, f: &Flight, hit: &SurfaceHit) {
        let scene = self.tracer.scene;
        let prim = &scene.geometry.prims[hit.prim_ix as usize];
        let passes = !f.aimed && !self.emission.pair.target.prims.contains(&hit.prim_ix);
        if passes && prim.flags & prim_flags::PHOTON_PASS_THROUGH == 0 {
            return;
        }
        self.out.met_target |= !passes;
        let path = f.path + hit.t;
        let mut power = f.power;
        if self.tracer.plan.has_media {
            power = self.through_media(f, hit);
        }
        let interior = &scene.interiors[prim.interior_ix as usize];
        if interior.fade_power > 0.0 && f.ray.interiors.position(prim.interior_ix).is_some() {
            power *= fade_factor(interior, hit.t);
        }
        let from_inside = hit.normal.dot(f.ray.ray.dir) > 0.0;
        let normal = if from_inside { -hit.normal } else { hit.normal };
        let ctx = HitContext { ray: &f.ray, hit, prim, normal, lit_base: 0, weight: f.weight, seen: Cell::new(normal) };
        let leaves = (f.aimed && prim.flags & prim_flags::PHOTON_NO_COLLECT == 0).then(|| self.share_at(path) as f32);
        let next = Landed { power, weight: f.weight, path, passes, leaves };
        let covers = covers_at(scene, hit, from_inside, self.tracer.adc_bailout);
        for k in 0..covers.len() {
            let (c, share) = covers.get(k);
            self.on_cover(&ctx, &c, &Landed { power: power * share, ..next });
        }
    }

    /// Leaves traces in the media on the way to the next surface, and gives the power that is left there. On one way all traces are
    /// alike: it weakens between ways (measured).
    fn through_media(&mut self, f: &Flight, hit: &SurfaceHit) -> Rgb {
        let t = &mut *self.tracer;
        let list = t.media_of(&f.ray.interiors);
        if list.is_empty() || !f.ray.interiors.is_hollow() {
            return f.power;
        }
        let (steps, factor) = self.settings.media;
        let collects = |m: u32| {
            let m = &t.scene.media[m as usize].params;
            m.collect && !is_dark(m.scattering)
        };
        if f.aimed && steps > 0 && list.iter().any(collects) {
            let e = self.emission;
            let path = |at: f64| if e.parallel { 1.0 } else { f.path + at };
            let first = e.spread * path(0.0);
            // Where the way leaves or enters a light's beam it is cut, as for rays (measured: behind a mirror in a spotlight).
            for i in self.tracer.media_intervals(&f.ray.ray, hit.t, &list, hit) {
                let wanted = i.length / (first * factor);
                let n = f64::from(steps).min(wanted).max(0.0) as u32;
                let each = if wanted > f64::from(steps) { i.length / (f64::from(n) * first) } else { factor };
                for k in 0..n {
                    let place = f64::from(k) + 0.5 + (self.tracer.media_random.draw() - 0.5) * self.settings.jitter;
                    let at = i.start + i.length * place / f64::from(n);
                    // The piece of the way that a trace stands for grows with the way, like the area (measured).
                    let share = self.share_at(f.path + at) * each * e.spread * path(at);
                    self.out.media.push(Photon::new(f.ray.ray.at(at), f.power * share as f32, -f.ray.ray.dir));
                }
            }
        }
        self.tracer.through_media(&f.ray.ray, hit.t, &f.ray.interiors, f.power)
    }

    /// What a photon's power is multiplied by where it is kept: the piece of the wave front that it stands for, and fading.
    fn share_at(&self, path: f64) -> f64 {
        let e = self.emission;
        let area = e.spread * e.spread * if e.parallel { 1.0 } else { path * path };
        area * fade(e.pair.light.light.fade, path)
    }

    fn on_cover(&mut self, ctx: &HitContext, c: &Cover, l: &Landed) {
        let p = pattern_point(self.tracer.scene, ctx.hit, ctx.prim, c, ctx.normal, ctx.ray.ray.dir);
        self.on_texture(ctx, c.texture, &p, &Space::of_cover(c, &ctx.seen), l);
    }

    fn on_texture(&mut self, ctx: &HitContext, texture: u32, p: &PatternPoint, space: &Space, l: &Landed) {
        let scene = self.tracer.scene;
        match &scene.textures.textures[texture as usize] {
            TextureNode::Layers { start, len } => self.on_layers(ctx, (*start, *len), p, space, l),
            // Imported materials stand in no scene that asks for photons.
            TextureNode::Principled(_) => {}
            node => {
                let parts = blend(scene, node, p, space);
                let inner = Space { parent: Some(space), step: parts.step, seen: space.seen };
                for k in 0..parts.entries.len() {
                    let (texture, share) = parts.entries.get(k);
                    self.on_texture(ctx, texture, &parts.point, &inner, &Landed { power: l.power * share, ..*l });
                }
            }
        }
    }

    fn on_layers(&mut self, ctx: &HitContext, range: LayerRange, p: &PatternPoint, space: &Space, l: &Landed) {
        if let Some(share) = l.leaves {
            self.out.surface.push(Photon::new(ctx.hit.point, l.power * share, -ctx.ray.ray.dir));
        }
        let layers = self.tracer.over_layers(ctx, range, p, space, l.weight, &mut |_, _, _| Vec3::ZERO);
        if l.passes {
            let passage = self.tracer.passage(&ctx.ray.interiors, ctx.prim.interior_ix);
            self.go_on(l, straight(ctx, &passage), layers.filter(), l.weight);
            return;
        }
        let (reflects, refracts) = allows(ctx.prim.flags, self.emission.pair.light);
        let total_reflection = refracts && layers.trans > self.tracer.adc_bailout && self.refract(ctx, &layers, l);
        if !reflects {
            return;
        }
        for k in 0..layers.mirrors.len() {
            let m = layers.mirrors.get(k);
            if !(total_reflection && layers.is_outdone(&m)) {
                let ray = mirrored(ctx, reflect(ctx.ray.ray.dir, m.normal, ctx.normal));
                // Mirrors weaken the weight twice (measured: `adc_bailout` is compared with the square).
                self.go_on(l, ray, m.factor, m.weight * f64::from(m.factor.max_element()));
            }
        }
    }

    /// Sends a photon through a surface; gives whether it was totally reflected.
    fn refract(&mut self, ctx: &HitContext, layers: &Layered, l: &Landed) -> bool {
        let (top, factor) = (layers.top_normal, layers.filter());
        let weight = l.weight * f64::from(layers.factor.abs().max_element());
        let passage = self.tracer.passage(&ctx.ray.interiors, ctx.prim.interior_ix);
        match passage.onward(ctx.ray.wavelength) {
            Onward::Straight => self.go_on(l, straight(ctx, &passage), factor, weight),
            Onward::Bent(n) => match bent(ctx, &passage, top, n, ctx.ray.wavelength) {
                Bent::Through(ray) => self.go_on(l, ray, factor, weight),
                Bent::Back(ray) => {
                    self.go_on(l, ray, Vec3::ONE, weight);
                    return true;
                }
            },
            Onward::Split => {
                for band in passage.bands() {
                    let (Bent::Through(ray) | Bent::Back(ray)) = bent(ctx, &passage, top, band.n, band.wavelength);
                    self.go_on(l, ray, factor * band.hue, weight);
                }
            }
        }
        false
    }

    fn go_on(&mut self, l: &Landed, ray: TraceRay, factor: Rgb, weight: f64) {
        self.fly(&Flight { ray, power: l.power * factor, weight, path: l.path, aimed: !l.passes });
    }
}

/// A photon that has met a surface.
#[derive(Clone, Copy)]
struct Landed {
    power: Rgb,
    weight: f64,
    path: f64,
    /// The surface only stands before the target.
    passes: bool,
    /// What its power is multiplied by where it is kept, if it is kept here: once for each texture of a blend.
    leaves: Option<f32>,
}
