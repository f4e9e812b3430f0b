//! A microfacet lobe: reflection, refraction or both at GGX facets, with any Fresnel term. In the frame of the surface; the viewer is above.
//!
//! Values hold the cosine of the light and no factor for the change of radiance between media (as Cycles): glass in a white room is white.
//! Source: Walter et al. 2007; energy of many bounces by Turquin 2019.

use super::fresnel::Fresnel;
use super::ggx::Ggx;
use super::{LocalSample, SINGULAR_DENSITY};
use crate::math::{Rgb, Vec3};

/// A lobe. What the facets lose by one bounce only is put back through the lobe's weight.
#[derive(Clone, Copy, Debug)]
pub struct Microfacet {
    /// Facets.
    pub ggx: Ggx,
    /// What they do.
    pub fresnel: Fresnel,
    /// Refracts too.
    pub refracts: bool,
}

impl Microfacet {
    /// Chance to follow the reflection.
    #[inline]
    fn reflect_chance(&self, r: Rgb, t: Rgb) -> f32 {
        if !self.refracts {
            return 1.0;
        }
        let (r, t) = (r.element_sum(), t.element_sum());
        if r + t > 0.0 { r / (r + t) } else { 0.0 }
    }

    /// About what is reflected and let through of light from everywhere, for a viewer at cosine `cos`.
    pub fn albedo(&self, cos: f32) -> [Rgb; 2] {
        let roughness = (self.ggx.ax * self.ggx.ay).sqrt().sqrt();
        let (r, t, _) = self.fresnel.eval(cos);
        match self.fresnel {
            Fresnel::Dielectric { eta, f0, tint } if !self.refracts => {
                let mix = super::albedo::dielectric_mix(eta, roughness, cos);
                [(f0 + (Vec3::ONE - f0) * mix) * tint[0] * super::albedo::mirror(roughness, cos), Vec3::ZERO]
            }
            _ if self.refracts => {
                let kept = super::albedo::glass(self.fresnel.eta(), roughness, cos);
                [r * kept, t * kept]
            }
            _ => [r * super::albedo::mirror(roughness, cos), Vec3::ZERO],
        }
    }

    /// Whether facets that the viewer sees send anything to `l`: refraction is evaluated beyond that, see [`Microfacet::eval`].
    pub fn is_drawn(&self, v: Vec3, l: Vec3) -> bool {
        let h = v + l * self.fresnel.eta();
        let h = if h.z < 0.0 { -h } else { h };
        l.z > 0.0 || (v.dot(h) > 0.0 && l.dot(h) < 0.0)
    }

    /// Value times the light's cosine, and density.
    ///
    /// Refraction is Walter et al.'s formula in absolute values, with Fresnel's term of the absolute cosine, for every `l` behind the surface: also
    /// where the facet that would bend `l` to `v` faces away from the viewer or has both on one side. Such directions are never drawn
    /// ([`Microfacet::is_drawn`]), so the density exceeds the sampler's there, and lamps that are asked give more light through rough glass
    /// than the same lamps met by chance. Source: Cycles, measured (`tests/measured/cycles_refraction.txt`; suite `path/material/refraction_lamps`).
    pub fn eval(&self, v: Vec3, l: Vec3) -> (Rgb, f32) {
        let zero = (Vec3::ZERO, 0.0);
        if v.z <= 0.0 || self.ggx.is_singular() {
            return zero;
        }
        if l.z > 0.0 {
            let Some(h) = (v + l).try_normalize() else { return zero };
            let vh = v.dot(h);
            if vh <= 0.0 {
                return zero;
            }
            let (r, t, _) = self.fresnel.eval(vh);
            let d = self.ggx.d(h) / (4.0 * v.z);
            let (lv, ll) = (self.ggx.lambda(v), self.ggx.lambda(l));
            (r * (d / (1.0 + lv + ll)), d / (1.0 + lv) * self.reflect_chance(r, t))
        } else {
            let eta = self.fresnel.eta();
            if !self.refracts || l.z >= 0.0 || eta == 1.0 {
                return zero;
            }
            let Some(h) = (v + l * eta).try_normalize() else { return zero };
            let (vh, lh) = (v.dot(h), l.dot(h));
            let root = vh + eta * lh;
            let (vh, lh) = (vh.abs(), lh.abs());
            let (r, t, _) = self.fresnel.eval(vh);
            let jacobian = eta * eta * lh / (root * root);
            let d = self.ggx.d(h) * vh / v.z * jacobian;
            let (lv, ll) = (self.ggx.lambda(v), self.ggx.lambda(Vec3::new(l.x, l.y, -l.z)));
            (t * (d / (1.0 + lv + ll)), d / (1.0 + lv) * (1.0 - self.reflect_chance(r, t)))
        }
    }

    /// A direction with the density that [`Microfacet::eval`] gives; `pick` chooses between reflection and refraction.
    pub fn sample(&self, v: Vec3, u: f32, w: f32, pick: f32) -> Option<LocalSample> {
        if v.z <= 0.0 {
            return None;
        }
        let eta = self.fresnel.eta();
        let singular = self.ggx.is_singular();
        let h = if singular { Vec3::Z } else { self.ggx.sample_visible(v, u, w) };
        let vh = v.dot(h);
        let (r, t, cos_t) = self.fresnel.eval(vh);
        let chance = self.reflect_chance(r, t);
        let reflects = pick < chance;
        let l = if reflects { h * (2.0 * vh) - v } else { h * (vh / eta + cos_t) - v / eta };
        if reflects != (l.z > 0.0) || (!reflects && cos_t == 0.0) {
            return None;
        }
        // Facets that bend nothing, or none: a density cannot be evaluated.
        if singular || (!reflects && eta == 1.0) {
            let (value, pdf) = if reflects { (r, chance) } else { (t, 1.0 - chance) };
            return Some(LocalSample { l, value: value * SINGULAR_DENSITY, pdf: pdf * SINGULAR_DENSITY, singular: true, event: None });
        }
        let (value, pdf) = self.eval(v, l);
        (pdf > 0.0).then_some(LocalSample { l, value, pdf, singular: false, event: None })
    }
}
