//! What is seen through a surface: the list of interiors, relative indices, refraction, total reflection, dispersion, fading.
//! Source: spec/light.md, sections 3 and 4.

use super::ray::{InteriorList, Seen, TraceRay};
use super::shade::HitContext;
use super::trace::Tracer;
use crate::compile::Interior;
use crate::kernel::finish::{reflect, refract};
use crate::math::{DVec3, EPSILON, Rgb, Vec3};
use std::sync::LazyLock;

/// What became of a ray that was to pass a surface.
pub(super) enum Through {
    /// It saw this.
    Transmitted(Seen),
    /// It was turned back and saw this.
    TotallyReflected(Seen),
}

/// A passage from one interior to another.
pub(super) struct Passage {
    interiors: InteriorList,
    /// Near index over far index.
    n: f64,
    /// The same for the dispersion values.
    dispersion: f64,
    bands: u32,
}

/// How light goes on in a passage.
pub(super) enum Onward {
    /// As if there were nothing.
    Straight,
    /// By this ratio of indices.
    Bent(f64),
    /// In bands of colour.
    Split,
}

/// A part of the spectrum that goes its own way.
pub(super) struct Band {
    /// Near index over far index.
    pub n: f64,
    /// Its middle, in nm.
    pub wavelength: f64,
    /// Its share of white.
    pub hue: Rgb,
}

impl Passage {
    /// Where a ray runs beyond.
    pub fn beyond(&self) -> &InteriorList {
        &self.interiors
    }

    /// The direction beyond a surface of this normal for light of all colours; `None` where it is totally reflected.
    pub fn bend(&self, dir: DVec3, normal: DVec3) -> Option<DVec3> {
        if (self.n - 1.0).abs() < EPSILON { Some(dir) } else { refract(dir, normal, self.n) }
    }

    fn disperses(&self) -> bool {
        (self.dispersion - 1.0).abs() >= EPSILON
    }

    fn index(&self, wavelength: f64) -> f64 {
        self.n * self.dispersion.powf(-(wavelength - 555.0) / 350.0)
    }

    /// What light of a wavelength (0: white) does.
    pub fn onward(&self, wavelength: f64) -> Onward {
        match self.disperses() {
            false if (self.n - 1.0).abs() < EPSILON => Onward::Straight,
            false => Onward::Bent(self.n),
            true if wavelength != 0.0 => Onward::Bent(self.index(wavelength)),
            true => Onward::Split,
        }
    }

    /// The bands that white light splits into.
    pub fn bands(&self) -> impl Iterator<Item = Band> + '_ {
        let width = 350.0 / f64::from(self.bands);
        (0..self.bands).map(move |k| {
            let wavelength = 380.0 + width * (f64::from(k) + 0.5);
            let hue = hue_sum(wavelength + 0.5 * width) - hue_sum(wavelength - 0.5 * width);
            Band { n: self.index(wavelength), wavelength, hue }
        })
    }
}

/// A ray that met a surface which bends it.
pub(super) enum Bent {
    /// It goes through.
    Through(TraceRay),
    /// It is totally reflected.
    Back(TraceRay),
}

/// Colour that light keeps after `depth` inside an interior. Source: spec/light.md, section 3.
pub fn fade_factor(i: &Interior, depth: f64) -> Rgb {
    if i.fade_distance == 0.0 {
        return Vec3::ONE;
    }
    let x = depth / i.fade_distance;
    if i.fade_power >= 1000.0 {
        let c = Vec3::ONE - i.fade_color;
        return (-c * x as f32).exp();
    }
    let k = (1.0 / (1.0 + x.powf(i.fade_power))) as f32;
    i.fade_color + (Vec3::ONE - i.fade_color) * k
}

impl Tracer<'_> {
    fn interior(&self, ix: u32) -> &Interior {
        &self.scene.interiors[ix as usize]
    }

    /// Index of refraction beyond a surface over the one before it, as fresnel sees it.
    pub(super) fn relative_ior(&self, interiors: &InteriorList, interior_ix: u32) -> f64 {
        let own = self.interior(interior_ix).ior;
        match interiors.last() {
            None => own,
            // Leaving the only interior; with more than one the program divides the last by itself.
            Some(last) if last == interior_ix => {
                if interiors.len() == 1 {
                    1.0 / own
                } else {
                    1.0
                }
            }
            Some(last) => own / self.interior(last).ior,
        }
    }

    /// What the way inside the object that the ray leaves keeps of light.
    pub(super) fn interior_attenuation(&self, ctx: &HitContext) -> Rgb {
        let interior = self.interior(ctx.prim.interior_ix);
        if ctx.ray.interiors.position(ctx.prim.interior_ix).is_none() {
            return Vec3::ONE;
        }
        fade_factor(interior, ctx.hit.t) * interior.old_refraction as f32
    }

    /// From where a ray of `interiors` runs to the other side of a surface of an object.
    pub(super) fn passage(&self, interiors: &InteriorList, interior_ix: u32) -> Passage {
        let scene = self.scene;
        let own = self.interior(interior_ix);
        let mut next = interiors.clone();
        let (n, dispersion, bands) = match (interiors.last(), interiors.position(interior_ix)) {
            (None, _) => {
                next.push(scene, interior_ix);
                (1.0 / own.ior, 1.0 / own.dispersion, own.dispersion_samples)
            }
            // Parts of a union may have entered it several times: the first entry goes.
            (Some(last), Some(position)) if last == interior_ix => {
                next.remove(scene, position);
                match next.last().map(|ix| self.interior(ix)) {
                    None => (own.ior, own.dispersion, own.dispersion_samples),
                    Some(o) => (own.ior / o.ior, own.dispersion / o.dispersion, own.dispersion_samples.max(o.dispersion_samples)),
                }
            }
            (_, Some(position)) => {
                next.remove(scene, position);
                (1.0, 1.0, own.dispersion_samples)
            }
            (Some(last), None) => {
                let o = self.interior(last);
                next.push(scene, interior_ix);
                (o.ior / own.ior, o.dispersion / own.dispersion, own.dispersion_samples.max(o.dispersion_samples))
            }
        };
        Passage { interiors: next, n, dispersion, bands: bands.max(2) }
    }

    /// Traces what lies behind a surface whose top layer has this normal and this finish.
    pub(super) fn through(&mut self, ctx: &HitContext, (top, finish): (DVec3, u32), weight: f64) -> Through {
        let p = self.passage(&ctx.ray.interiors, ctx.prim.interior_ix);
        match p.onward(ctx.ray.wavelength) {
            Onward::Straight => Through::Transmitted(self.trace(&straight(ctx, &p), weight, true)),
            Onward::Bent(n) => match bent(ctx, &p, top, n, ctx.ray.wavelength) {
                Bent::Through(ray) => Through::Transmitted(self.trace(&ray, weight, false)),
                Bent::Back(ray) => Through::TotallyReflected(self.turned_back(ctx, (top, finish), &ray, weight)),
            },
            Onward::Split => {
                let (mut sum, mut transmit) = (Vec3::ZERO, 0.0);
                for band in p.bands() {
                    let seen = match bent(ctx, &p, top, band.n, band.wavelength) {
                        Bent::Through(ray) => self.trace(&ray, weight, false),
                        Bent::Back(ray) => self.turned_back(ctx, (top, finish), &ray, weight),
                    };
                    sum += seen.rgb * band.hue;
                    transmit += seen.transmit / p.bands as f32;
                }
                Through::Transmitted(Seen { rgb: sum, transmit, depth: f64::INFINITY })
            }
        }
    }
}

impl Tracer<'_> {
    /// Traces a totally reflected ray, which the film of the top layer tints as it does a mirror's (measured).
    fn turned_back(&mut self, ctx: &HitContext, (top, finish): (DVec3, u32), ray: &TraceRay, weight: f64) -> Seen {
        let seen = self.trace(ray, weight, false);
        Seen { rgb: seen.rgb * self.film(ctx, finish, top, ray.ray.dir), ..seen }
    }
}

/// The ray beyond a surface that does not bend it.
pub(super) fn straight(ctx: &HitContext, p: &Passage) -> TraceRay {
    ctx.ray.onward(ctx.hit.point, ctx.ray.ray.dir, &p.interiors)
}

/// The ray that leaves a surface of normal `top` by a ratio of indices `n`.
pub(super) fn bent(ctx: &HitContext, p: &Passage, top: DVec3, n: f64, wavelength: f64) -> Bent {
    match refract(ctx.ray.ray.dir, top, n) {
        Some(dir) => Bent::Through(TraceRay { wavelength, ..ctx.ray.onward(ctx.hit.point, dir, &p.interiors) }),
        None => Bent::Back(mirrored(ctx, reflect(ctx.ray.ray.dir, top, ctx.normal))),
    }
}

/// The ray that leaves a hit along `dir` on the side it came from.
pub(super) fn mirrored(ctx: &HitContext, dir: DVec3) -> TraceRay {
    TraceRay { reflected: true, ..ctx.ray.onward(ctx.hit.point, dir, &ctx.ray.interiors) }
}

/// Colours of the spectrum summed up from 375 nm in steps of 5 nm.
static HUES: LazyLock<[Vec3; 74]> = LazyLock::new(|| {
    let hue = |i: usize| {
        let x = 0.03 + 0.934 * i as f64 / 73.0;
        let bump = |k: f64, c: f64| (k * (x - c)) * (k * (x - c));
        let blue = (0.98 * (1.0 - bump(4.0, 0.28))).max(0.0);
        let green = (0.97 * (1.1 - bump(4.5, 0.57))).max(0.0);
        let mut red = 1.15 - bump(5.0, 0.75);
        if red < 0.0 {
            red = (0.12 - bump(4.0, 0.12)).max(0.0);
        }
        [red, green, blue]
    };
    let mut sums = [[0.0f64; 3]; 74];
    let mut total = [0.0f64; 3];
    for (i, s) in sums.iter_mut().enumerate() {
        let h = hue(i);
        for k in 0..3 {
            total[k] += if i == 0 { 0.0 } else { h[k] };
        }
        *s = total;
    }
    // The program's table has 4 decimals, which shows.
    sums.map(|s| Vec3::from([0, 1, 2].map(|k| ((s[k] / total[k] * 1e4).round() / 1e4) as f32)))
});

/// The summed hues up to a wavelength in nm.
fn hue_sum(wavelength: f64) -> Vec3 {
    let x = ((wavelength - 375.0) / 5.0).clamp(0.0, 73.0);
    let i = (x as usize).min(72);
    HUES[i].lerp(HUES[i + 1], (x - i as f64) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn white_through_a_dispersing_surface_is_the_published_near_white() {
        let white = hue_sum(730.0) - hue_sum(380.0);
        assert!((white - Vec3::new(0.9938, 1.0, 0.9962)).abs().max_element() < 2e-4, "{white}");
    }

    #[test]
    fn fading_halves_at_the_fade_distance_and_is_exponential_from_1000() {
        let mut i = Interior {
            ior: 1.0,
            dispersion: 1.0,
            dispersion_samples: 7,
            caustics: 0.0,
            fade_color: Vec3::new(0.2, 0.0, 1.0),
            fade_distance: 4.0,
            fade_power: 2.0,
            old_refraction: 1.0,
            media: Vec::new(),
            hollow: false,
        };
        assert!((fade_factor(&i, 4.0) - Vec3::new(0.6, 0.5, 1.0)).length() < 1e-6);
        i.fade_power = 1001.0;
        assert!((fade_factor(&i, 4.0) - Vec3::new((-0.8f32).exp(), (-1f32).exp(), 1.0)).length() < 1e-6);
        i.fade_power = 0.0;
        assert!((fade_factor(&i, 9.0).y - 0.5).abs() < 1e-6, "power 0 still halves");
    }
}
