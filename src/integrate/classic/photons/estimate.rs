//! Light of photons on a layer: those near the hit are gathered once, and every layer answers them. Source: spec/light.md, section 9.

use super::super::lights::LitLayer;
use super::super::shade::HitContext;
use super::super::trace::Tracer;
use super::PhotonMaps;
use super::map::NearestPhotons;
use crate::compile::geometry::prim_flags;
use crate::math::{DVec3, EPSILON, Rgb, Vec3};
use std::f64::consts::PI;

impl PhotonMaps {
    /// Gathers photons of the surface map near `p`; where there are few, once more farther out.
    pub(super) fn gather_surface(&self, p: DVec3, normal: DVec3, found: &mut NearestPhotons) {
        self.gather(&self.surface, self.radius, p, Some(normal), found);
    }

    /// Light that photons bring to a point of a medium; `phase` weighs a photon by the direction that it came from.
    pub(in super::super) fn in_media(&self, p: DVec3, found: &mut NearestPhotons, phase: impl Fn(DVec3) -> f64) -> Rgb {
        if self.media.is_empty() {
            return Vec3::ZERO;
        }
        self.gather(&self.media, self.media_radius, p, None, found);
        let sum = found.places().fold(Vec3::ZERO, |sum, k| {
            let photon = &self.media.photons()[k];
            sum + phase(photon.from()) as f32 * photon.power()
        });
        let volume = 4.0 / 3.0 * PI * found.radius_sq() * found.radius_sq().sqrt();
        sum / volume as f32
    }

    /// See [`Self::gather_surface`].
    fn gather(&self, map: &super::map::PhotonMap, radius: f64, p: DVec3, flat: Option<DVec3>, found: &mut NearestPhotons) {
        map.nearest(p, flat, radius, found);
        let n = found.len();
        if n as u32 >= self.least {
            return;
        }
        let density = |f: &NearestPhotons| f.len() as f64 / f.radius_sq();
        let old = density(found);
        map.nearest(p, flat, 3.0 * radius, found);
        let n_new = found.len() as u32;
        let keeps = (density(found) - old) / old < self.expand.0 || (1..self.expand.1).contains(&n_new);
        if !keeps {
            map.nearest(p, flat, radius, found);
        }
    }
}

impl Tracer<'_> {
    /// Whether photons light a hit.
    pub(in super::super) fn sees_photons(&self, ctx: &HitContext) -> bool {
        self.plan.photons.is_some() && ctx.prim.flags & prim_flags::PHOTON_NO_COLLECT == 0
    }

    /// Light of the photons near a hit on one layer. `gathered` is the normal with which they were gathered, once that is done.
    pub(in super::super) fn photons_on_layer(&mut self, ctx: &HitContext, layer: &LitLayer, gathered: &mut Option<DVec3>) -> Rgb {
        let plan = self.plan;
        let Some(maps) = plan.photons.as_deref().filter(|m| !m.surface.is_empty()) else { return Vec3::ZERO };
        let f = layer.finish;
        if f.diffuse == 0.0 && f.diffuse_back == 0.0 && f.phong == 0.0 && f.specular == 0.0 {
            return Vec3::ZERO;
        }
        let mut found = std::mem::take(&mut self.near_photons);
        if gathered.is_none() {
            *gathered = Some(layer.normal);
            maps.gather_surface(ctx.hit.point, layer.normal, &mut found);
        }
        let mut sum = Vec3::ZERO;
        for k in found.places() {
            let photon = &maps.surface.photons()[k];
            let from = photon.from();
            let mut behind = false;
            if !Self::double_illuminated(ctx) && from.dot(layer.normal) < EPSILON {
                if f.diffuse_back == 0.0 {
                    continue;
                }
                behind = true;
            }
            // A photon lights its piece of the wave front, which lies slanted on the surface: the cosine is in the density already.
            let slant = from.dot(ctx.normal).clamp(0.1, 1.0);
            let color = photon.power() / slant as f32;
            sum += self.answer(ctx, layer, from, color, behind, true);
        }
        let area = PI * found.radius_sq();
        self.near_photons = found;
        sum / area as f32
    }
}
