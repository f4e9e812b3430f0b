//! Imported materials in the classic integrator: a sensible likeness, not a simulation. Lamps light a Lambert base and a GGX highlight,
//! the sky stands in for ambient light, smooth metals and glass mirror and refract. The path integrator does it right.
//!
//! Source of the terms: glTF 2.0, appendix B; Walter et al. 2007 (GGX); Schlick 1994.

use super::lights::is_dark;
use super::refract::Through;
use super::shade::HitContext;
use super::trace::Tracer;
use crate::compile::geometry::prim_flags;
use crate::kernel::PatternPoint;
use crate::kernel::finish::reflect;
use crate::kernel::light::{attenuation, light_ray};
use crate::math::{DVec3, Rgb, Vec3};
use std::f64::consts::PI;

/// A material with its textures looked up at a point.
pub(super) struct Material {
    pub base: Rgb,
    pub alpha: f32,
    pub metallic: f32,
    pub roughness: f32,
    pub emission: Rgb,
    pub transmission: f32,
    /// Reflectance along the normal.
    pub f0: Rgb,
}

/// GGX with Smith's height-correlated shadowing, times the cosine of the light; `None` below the surface.
fn ggx(normal: DVec3, to_light: DVec3, to_eye: DVec3, alpha: f64, f0: Rgb) -> Option<(Rgb, Rgb)> {
    let (nl, nv) = (normal.dot(to_light), normal.dot(to_eye).max(1e-4));
    if nl <= 0.0 {
        return None;
    }
    let half = (to_light + to_eye).try_normalize()?;
    let (nh, vh) = (normal.dot(half), to_eye.dot(half).max(0.0));
    let a_sq = alpha * alpha;
    let d = a_sq / (PI * (nh * nh * (a_sq - 1.0) + 1.0).powi(2));
    let smith = |x: f64, y: f64| x * (a_sq + (1.0 - a_sq) * y * y).sqrt();
    let visibility = 0.5 / (smith(nl, nv) + smith(nv, nl));
    let fresnel = schlick(f0, vh);
    Some((fresnel * (d * visibility * nl) as f32, fresnel))
}

fn schlick(f0: Rgb, cos: f64) -> Rgb {
    f0 + (Vec3::ONE - f0) * (1.0 - cos.clamp(0.0, 1.0)).powi(5) as f32
}

impl Tracer<'_> {
    /// Colour and transmit of an imported material.
    pub(super) fn shade_principled(&mut self, ctx: &HitContext, ix: u32, p: &PatternPoint, weight: f64) -> (Rgb, f32) {
        let m = self.material(ix, p);
        let dir = ctx.ray.ray.dir;
        let normal = ctx.normal;
        let alpha = f64::from(m.roughness * m.roughness).max(1e-3);
        let diffuse = m.base * (1.0 - m.metallic) * (1.0 - m.transmission);
        let mut rgb = m.emission;
        for k in 0..self.plan.global_lights.len() {
            rgb += self.lamp_on_material(ctx, k, diffuse, alpha, m.f0);
        }
        // Light from everywhere: what the sky shows along the normal.
        let around = super::ray::TraceRay::primary(crate::math::Ray::new(ctx.hit.point, normal), Default::default());
        rgb += diffuse * self.sky(&around).rgb;
        let mirror = schlick(m.f0, -dir.dot(normal));
        let gloss = (1.0 - m.roughness / 0.3).max(0.0);
        if gloss > 0.0 {
            let factor = mirror * gloss;
            let out = reflect(dir, normal, normal);
            rgb += factor * self.reflected_ray(ctx, out, weight * f64::from(factor.max_element())).rgb;
        }
        if gloss < 1.0 {
            let mut blurred =
                super::ray::TraceRay::primary(crate::math::Ray::new(ctx.hit.point, reflect(dir, normal, normal)), Default::default());
            blurred.reflected = true;
            rgb += mirror * (1.0 - gloss) * self.sky(&blurred).rgb;
        }
        let mut transmit = 0.0;
        if m.transmission > 0.0 {
            let factor = m.base * (Vec3::ONE - mirror) * m.transmission * (1.0 - m.metallic);
            let (Through::Transmitted(seen) | Through::TotallyReflected(seen)) =
                self.through(ctx, normal, weight * f64::from(factor.max_element()));
            rgb += factor * seen.rgb;
        }
        if m.alpha < 1.0 {
            rgb *= m.alpha;
            let seen = self.straight_on(ctx, weight * f64::from(1.0 - m.alpha));
            rgb += (1.0 - m.alpha) * seen.rgb;
            transmit = (1.0 - m.alpha) * seen.transmit;
        }
        (rgb, transmit)
    }

    fn lamp_on_material(&mut self, ctx: &HitContext, nth: usize, diffuse: Rgb, alpha: f64, f0: Rgb) -> Rgb {
        let light_ix = self.plan.global_lights[nth];
        let light = &self.scene.lights[light_ix as usize].light;
        let point = ctx.hit.point;
        let way = light_ray(light, point, DVec3::ZERO);
        let color = light.color * attenuation(light, point, &way) as f32;
        let Some((highlight, fresnel)) = ggx(ctx.normal, way.dir, -ctx.ray.ray.dir, alpha, f0) else { return Vec3::ZERO };
        if is_dark(color) || ctx.prim.flags & prim_flags::NO_GLOBAL_LIGHTS != 0 {
            return Vec3::ZERO;
        }
        let k = ctx.lit_base + nth;
        let lit = match self.lit[k] {
            Some(known) => known,
            None => {
                let c = match &light.area {
                    Some(a) => self.through_area(light_ix, a, &ctx.ray.interiors, point, &way, color),
                    None => self.unshadowed(light_ix, &ctx.ray.interiors, point, &way, color),
                };
                self.lit[k] = Some(c);
                c
            }
        };
        let lambert = diffuse * (Vec3::ONE - fresnel) * (ctx.normal.dot(way.dir) / PI) as f32;
        (lambert + highlight) * lit
    }

    fn straight_on(&mut self, ctx: &HitContext, weight: f64) -> super::ray::Seen {
        let mut ray = ctx.ray.clone();
        ray.ray.origin = ctx.hit.point;
        self.trace(&ray, weight, true)
    }

    /// What a shadow ray keeps of its light at an imported surface.
    pub(super) fn principled_filter(&self, ix: u32, p: &PatternPoint) -> Rgb {
        let m = self.material(ix, p);
        let through = m.base * m.transmission * (1.0 - m.metallic);
        through * m.alpha + Vec3::splat(1.0 - m.alpha)
    }

    fn material(&self, ix: u32, _p: &PatternPoint) -> Material {
        let m = &self.scene.textures.principled[ix as usize];
        let f = ((m.ior - 1.0) / (m.ior + 1.0)).powi(2) * m.specular;
        let alpha = match m.alpha_cutoff {
            Some(cutoff) => f32::from(m.alpha >= cutoff),
            None => m.alpha,
        };
        Material {
            base: m.base_color,
            alpha,
            metallic: m.metallic,
            roughness: m.roughness,
            emission: m.emission,
            transmission: m.transmission,
            f0: Vec3::splat(f) * (1.0 - m.metallic) + m.base_color * m.metallic,
        }
    }
}
