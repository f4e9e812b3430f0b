//! Imported materials in the classic integrator: a plausible likeness, not a simulation. Lamps light a Lambert base and a GGX highlight,
//! shining surfaces light through a few points of each, the sky stands in for ambient light, smooth metals and glass mirror and refract.
//! What is missing (light between surfaces, soft reflections) is the path integrator's.
//!
//! Source of the terms: glTF 2.0, appendix B; Walter et al. 2007 (GGX); Schlick 1994.

use super::emitters::EmitterPoint;
use super::lights::is_dark;
use super::ray::{Seen, TraceRay};
use super::refract::Through;
use super::shade::HitContext;
use super::shafts::Known;
use super::trace::Tracer;
use crate::compile::CompiledLight;
use crate::compile::geometry::prim_flags;
use crate::kernel::SurfaceHit;
use crate::kernel::finish::reflect;
use crate::kernel::light::{attenuation, light_ray};
use crate::kernel::material::{Material, Normals, material_at, normals_at};
use crate::math::{DVec3, Ray, Rgb, Vec3};
use std::f64::consts::PI;

/// Up to this roughness mirrors are sharp; their sharp part is gone at the second one. Picked by feel.
pub const SHARP_MIRROR: (f32, f32) = (0.1, 0.35);

/// A material as light sees it at a hit.
struct Lit<'l> {
    m: &'l Material,
    n: Normals,
    /// Unit, to the viewer.
    to_eye: DVec3,
    /// Diffuse albedo.
    diffuse: Rgb,
    /// GGX width.
    alpha: f64,
    /// Share of the mirror that is sharp: it sees shining surfaces themselves.
    gloss: f32,
}

impl Lit<'_> {
    /// Reflected radiance for unit irradiance at right angles from `to_light`; zero from behind. `shine` weighs the highlight.
    fn answer(&self, to_light: DVec3, shine: f32) -> Rgb {
        let nl = self.n.shading.dot(to_light);
        if nl <= 0.0 || self.n.flat.dot(to_light) <= 0.0 {
            return Vec3::ZERO;
        }
        let (highlight, fresnel) = ggx(self.n.shading, to_light, self.to_eye, self.alpha, self.m.f0);
        self.diffuse * (Vec3::ONE - fresnel) * (nl / PI) as f32 + shine * highlight
    }
}

/// GGX with Smith's height-correlated shadowing, times the cosine of the light, and the Fresnel term.
fn ggx(normal: DVec3, to_light: DVec3, to_eye: DVec3, alpha: f64, f0: Rgb) -> (Rgb, Rgb) {
    let (nl, nv) = (normal.dot(to_light), normal.dot(to_eye).max(1e-4));
    let Some(half) = (to_light + to_eye).try_normalize() else { return (Vec3::ZERO, f0) };
    let (nh, vh) = (normal.dot(half), to_eye.dot(half).max(0.0));
    let a_sq = alpha * alpha;
    let d = a_sq / (PI * (nh * nh * (a_sq - 1.0) + 1.0).powi(2));
    let smith = |x: f64, y: f64| x * (a_sq + (1.0 - a_sq) * y * y).sqrt();
    let visibility = 0.5 / (smith(nl, nv) + smith(nv, nl));
    let fresnel = schlick(f0, vh);
    (fresnel * (d * visibility * nl) as f32, fresnel)
}

fn schlick(f0: Rgb, cos: f64) -> Rgb {
    f0 + (Vec3::ONE - f0) * (1.0 - cos.clamp(0.0, 1.0)).powi(5) as f32
}

impl Tracer<'_> {
    /// Colour and transmit of an imported material.
    pub(super) fn shade_principled(&mut self, ctx: &HitContext, ix: u32, weight: f64) -> (Rgb, f32) {
        let scene = self.scene;
        let record = &scene.textures.principled[ix as usize];
        let m = material_at(scene, record, ctx.hit);
        if m.alpha <= 0.0 {
            let seen = self.straight_on(ctx, weight);
            return (seen.rgb, seen.transmit);
        }
        let mut rgb = self.surface_light(ctx, &m, normals_at(scene, record, ctx.hit, ctx.ray.ray.dir), weight);
        if m.alpha >= 1.0 {
            return (rgb, 0.0);
        }
        rgb *= m.alpha;
        let seen = self.straight_on(ctx, weight * f64::from(1.0 - m.alpha));
        (rgb + (1.0 - m.alpha) * seen.rgb, (1.0 - m.alpha) * seen.transmit)
    }

    /// Light that leaves the surface itself to the viewer.
    fn surface_light(&mut self, ctx: &HitContext, m: &Material, n: Normals, weight: f64) -> Rgb {
        let dir = ctx.ray.ray.dir;
        let solid = (1.0 - m.metallic) * (1.0 - m.transmission);
        let gloss = ((SHARP_MIRROR.1 - m.roughness) / (SHARP_MIRROR.1 - SHARP_MIRROR.0)).clamp(0.0, 1.0);
        let alpha = f64::from(m.roughness * m.roughness).max(1e-3);
        let lit = Lit { m, n, to_eye: -dir, diffuse: m.base * solid, alpha, gloss };
        let mut rgb = m.emission;
        let inside = ctx.ray.interiors.position(ctx.prim.interior_ix).is_some() && m.transmission > 0.0;
        if !inside {
            rgb += self.lamps_on_material(ctx, &lit);
            rgb += self.emitters_on_material(ctx, &lit);
        }
        let mirror = schlick(m.f0, -dir.dot(n.shading));
        if !inside && lit.diffuse != Vec3::ZERO {
            // Light from everywhere: what the sky shows along the normal.
            rgb += lit.diffuse * (Vec3::ONE - mirror) * self.sky_along(ctx.hit.point, n.shading);
        }
        let clear = m.transmission * (1.0 - m.metallic);
        let mut turned_back = false;
        if clear > 0.0 {
            // Light passes two surfaces of a body: each takes half of the tint.
            let factor = m.base.max(Vec3::ZERO).map(f32::sqrt) * (Vec3::ONE - mirror) * clear;
            match self.through(ctx, (n.shading, crate::compile::NONE), weight * f64::from(factor.max_element())) {
                Through::Transmitted(seen) => rgb += factor * seen.rgb,
                Through::TotallyReflected(seen) => {
                    turned_back = true;
                    rgb += clear * seen.rgb;
                }
            }
        }
        if !turned_back {
            rgb += self.mirrored_light(ctx, &lit, mirror, inside, weight);
        }
        rgb * self.interior_attenuation(ctx)
    }

    /// What a smooth surface mirrors, and the sky in a rough one.
    fn mirrored_light(&mut self, ctx: &HitContext, lit: &Lit, mirror: Rgb, inside: bool, weight: f64) -> Rgb {
        let out = reflect(ctx.ray.ray.dir, lit.n.shading, lit.n.flat);
        let gloss = lit.gloss;
        let mut rgb = Vec3::ZERO;
        if gloss > 0.0 {
            let factor = mirror * gloss;
            rgb += factor * self.reflected_ray(ctx, out, weight * f64::from(factor.max_element())).rgb;
        }
        if gloss < 1.0 && !inside {
            rgb += mirror * (1.0 - gloss) * self.sky_along(ctx.hit.point, out);
        }
        rgb
    }

    /// The sky, as mirrors see it.
    fn sky_along(&self, from: DVec3, dir: DVec3) -> Rgb {
        let mut ray = TraceRay::primary(Ray::new(from, dir), Default::default());
        ray.reflected = true;
        self.sky(&ray).rgb
    }

    fn lamps_on_material(&mut self, ctx: &HitContext, lit: &Lit) -> Rgb {
        let plan = self.plan;
        let mut sum = Vec3::ZERO;
        if ctx.prim.flags & prim_flags::NO_GLOBAL_LIGHTS == 0 {
            for (k, light_ix) in plan.global_lights.iter().enumerate() {
                sum += self.lamp_on_material(ctx, lit, *light_ix, Some(ctx.lit_base + k));
            }
        }
        for light_ix in plan.group_lights.get(ctx.prim.group_ix as usize).into_iter().flatten() {
            sum += self.lamp_on_material(ctx, lit, *light_ix, None);
        }
        sum
    }

    /// One lamp. `memo` is the place of its filtered colour in `Tracer::lit`.
    fn lamp_on_material(&mut self, ctx: &HitContext, lit: &Lit, light_ix: u32, memo: Option<usize>) -> Rgb {
        let CompiledLight { light, beam, .. } = &self.scene.lights[light_ix as usize];
        let point = ctx.hit.point;
        let way = light_ray(light, point, DVec3::ZERO);
        let answer = lit.answer(way.dir, 1.0);
        let color = light.color * attenuation(light, beam, point, &way) as f32;
        if is_dark(answer) || is_dark(color) {
            return Vec3::ZERO;
        }
        let filtered = match memo.and_then(|k| self.lit[k]) {
            Some(known) => known,
            None => {
                let c = match &light.area {
                    Some(a) => self.through_area(light_ix, a, &ctx.ray.interiors, point, &way, color),
                    None => self.unshadowed(light_ix, &ctx.ray.interiors, point, &way, color, Known::Nothing),
                };
                if let Some(k) = memo {
                    self.lit[k] = Some(c);
                }
                c
            }
        };
        answer * filtered
    }

    /// Light of shining surfaces, through the points that stand for them.
    fn emitters_on_material(&mut self, ctx: &HitContext, lit: &Lit) -> Rgb {
        let plan = self.plan;
        let mut sum = Vec3::ZERO;
        for e in plan.emitters.iter().filter(|e| e.prim_ix != ctx.hit.prim_ix) {
            sum += self.emitter_on_material(ctx, lit, e);
        }
        sum
    }

    fn emitter_on_material(&mut self, ctx: &HitContext, lit: &Lit, e: &EmitterPoint) -> Rgb {
        let to = e.point - ctx.hit.point;
        let distance = to.length();
        let Some(dir) = to.try_normalize() else { return Vec3::ZERO };
        let irradiance = e.irradiance(dir, distance);
        let answer = lit.answer(dir, 1.0 - lit.gloss) * irradiance;
        if is_dark(answer) {
            return Vec3::ZERO;
        }
        answer * self.clear_way(&ctx.ray.interiors, Ray::new(ctx.hit.point, dir), e.free_way(distance))
    }

    fn straight_on(&mut self, ctx: &HitContext, weight: f64) -> Seen {
        let mut ray = ctx.ray.clone();
        ray.ray.origin = ctx.hit.point;
        ray.max_depth -= ctx.hit.t;
        self.trace(&ray, weight, true)
    }

    /// What a shadow ray keeps of its light at an imported surface.
    pub(super) fn principled_filter(&self, ix: u32, hit: &SurfaceHit) -> Rgb {
        let m = material_at(self.scene, &self.scene.textures.principled[ix as usize], hit);
        let through = m.base.max(Vec3::ZERO).map(f32::sqrt) * m.transmission * (1.0 - m.metallic);
        through * m.alpha + Vec3::splat(1.0 - m.alpha)
    }
}
