//! What rays see that hit nothing, and the air that every ray passes: sky, rainbows, atmospheric media, fog.
//! Source: spec/light.md, section 5.

use super::ray::{Seen, TraceRay};
use super::texturing as cover;
use super::trace::Tracer;
use crate::compile::CompiledSky;
use crate::kernel::atmosphere::{fog_effect, rainbow_effect};
use crate::kernel::{PatternPoint, SurfaceHit};
use crate::math::color::grey;
use crate::math::{DVec2, DVec3, Rgbft, Vec3};

impl Tracer<'_> {
    /// The sky in the direction of `r`.
    pub(super) fn sky(&self, r: &TraceRay) -> Seen {
        let background = self.background();
        let see_through = self.plan.output_alpha && !r.reflected && !r.gathers;
        let (rgb, transmit) = match &self.scene.sky {
            None => {
                let layers = Layers { rgb: Vec3::ZERO, factor: Vec3::ONE, see_through };
                layers.over_background(background)
            }
            Some(sky) if self.plan.modern => self.modern_sky(sky, r, see_through),
            Some(sky) => self.old_sky(sky, r, see_through),
        };
        Seen { rgb, transmit, depth: f64::INFINITY }
    }

    /// The background as rays see it: language 3.7 darkens a transparent one when the picture has no alpha channel (measured).
    fn background(&self) -> Rgbft {
        let b = self.scene.background;
        if self.plan.modern && !self.plan.output_alpha { Rgbft { rgb: b.rgb * (1.0 - b.transmit), ..b } } else { b }
    }

    /// Pigments of the sky from the top to the bottom.
    fn sky_colors<'s>(&'s self, sky: &'s CompiledSky, r: &TraceRay) -> impl Iterator<Item = Rgbft> + 's {
        let t = &self.scene.geometry.transforms[sky.transform_ix as usize];
        let p =
            PatternPoint { point: t.inverse_point(r.ray.dir), uv: DVec2::ZERO, world: r.ray.dir, normal: DVec3::ZERO, ray_dir: r.ray.dir };
        sky.pigments.iter().rev().map(move |ix| cover::pigment(self.scene, *ix, &p).unwrap_or(Rgbft::CLEAR))
    }

    /// Language 3.7: the sky is a layered surface over the background.
    fn modern_sky(&self, sky: &CompiledSky, r: &TraceRay, see_through: bool) -> (Vec3, f32) {
        let mut layers = Layers { rgb: Vec3::ZERO, factor: Vec3::ONE, see_through };
        for c in self.sky_colors(sky, r) {
            layers.rgb += c.rgb * c.opacity() * layers.factor * sky.emission;
            layers.factor *= c.transmittance();
        }
        layers.over_background(self.background())
    }

    /// Before 3.7: filter and transmit run through the layers apart from each other.
    fn old_sky(&self, sky: &CompiledSky, r: &TraceRay, see_through: bool) -> (Vec3, f32) {
        let (mut rgb, mut trans) = (Vec3::ZERO, 1.0f32);
        let mut product = Rgbft { rgb: Vec3::ONE, filter: 1.0, transmit: 1.0 };
        for c in self.sky_colors(sky, r) {
            rgb += c.rgb * trans * c.opacity();
            product = Rgbft { rgb: product.rgb * c.rgb, filter: product.filter * c.filter, transmit: product.transmit * c.transmit };
            trans = product.filter.abs() + product.transmit.abs();
        }
        let b = self.scene.background;
        let out = rgb * sky.emission + b.rgb * (product.rgb * product.filter + Vec3::splat(product.transmit));
        (out, if see_through { trans.min(1.0) } else { 0.0 })
    }

    /// What the air over `0..depth` does to what is seen.
    pub(super) fn air(&mut self, r: &TraceRay, depth: f64, hit: Option<&SurfaceHit>, seen: &mut Seen) {
        let scene = self.scene;
        if !scene.rainbows.is_empty() {
            let random = &mut self.random;
            let bow = |bow: &crate::scene::Rainbow, index: f64| cover::color_map(&bow.color_map, index);
            if let Some((rgb, factor)) = rainbow_effect(&scene.rainbows, r.ray.dir, depth, seen.rgb, || random.draw(), bow) {
                seen.rgb = rgb;
                seen.transmit *= factor;
            }
        }
        if !scene.atmosphere.is_empty() {
            self.atmosphere(r, depth, hit, seen);
        }
        if !scene.fogs.is_empty() {
            let fog = fog_effect(&scene.fogs, &r.ray, depth, |fog, p| cover::fog_turbulence(scene, fog, p));
            seen.rgb = fog.color + fog.factor * seen.rgb;
            seen.transmit *= grey(fog.factor);
        }
    }
}

/// Layers of sky so far.
struct Layers {
    rgb: Vec3,
    factor: Vec3,
    see_through: bool,
}

impl Layers {
    /// Colour and transmit with the background behind; its transparency shows only with output alpha.
    fn over_background(mut self, background: Rgbft) -> (Vec3, f32) {
        if !self.see_through {
            return (self.rgb + background.rgb * self.factor, 0.0);
        }
        self.rgb += background.rgb * background.opacity() * self.factor;
        self.factor *= background.transmittance();
        (self.rgb, grey(self.factor).abs().min(1.0))
    }
}
