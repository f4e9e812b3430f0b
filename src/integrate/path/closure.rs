//! A shader at a hit: its tree of closures becomes lobes, light that goes straight on, light of its own, and walks below the surface.
//!
//! Weights, layering and the order of the Principled closure follow Cycles 4.5 (docs/path.md).

use super::surface::Surface;
use crate::kernel::bsdf::diffuse::OrenNayar;
use crate::kernel::bsdf::frame::Frame;
use crate::kernel::bsdf::fresnel::{Fresnel, dielectric, f0_of};
use crate::kernel::bsdf::ggx::Ggx;
use crate::kernel::bsdf::microfacet::Microfacet;
use crate::kernel::bsdf::sheen::Sheen;
use crate::kernel::bsdf::thin_film::ThinFilm;
use crate::kernel::bsdf::{Lobe, LobeKind, LobeSet, albedo};
use crate::math::{Rgb, Vec3};
use crate::scene::input::{NormalInput, Scalar, TangentInput};
use crate::scene::shader::{Closure, Distribution, MixFactor, SubsurfaceMethod};

/// Weights below this are nothing.
pub(super) const CUTOFF: f32 = 1e-5;

/// A walk that may begin below a surface.
#[derive(Clone, Copy, Debug)]
pub struct Subsurface {
    /// Multiplies what comes out.
    pub weight: Rgb,
    /// Colour that the body shall have.
    pub albedo: Rgb,
    /// Mean free paths, scene units.
    pub radius: Rgb,
    /// Of the walk's scattering.
    pub anisotropy: f32,
    /// Of the surface that light is bent by where it enters.
    pub entry: Entry,
    /// Where it enters and how it leaves.
    pub normal: Vec3,
}

/// How light enters a body: bent about the normals of facets.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    /// Index of the body, 1.01 at least. Source: Cycles (measured).
    pub eta: f32,
    /// Width of the facets.
    pub width: f32,
    /// Skin: half of the light enters from all sides, and the radius is how far light comes on the whole rather than between two steps.
    pub skin: bool,
}

impl Entry {
    /// Of a body of index `ior` and a surface of facets of a width.
    pub fn new(method: SubsurfaceMethod, ior: f32, width: f32) -> Self {
        Self { eta: ior.max(1.01), width: width.clamp(0.0, 1.0), skin: method == SubsurfaceMethod::RandomWalkSkin }
    }
}

/// What a shader does at a hit.
pub struct Shading {
    /// Reflection and refraction.
    pub lobes: LobeSet,
    /// Share that goes straight on.
    pub transparent: Rgb,
    /// Radiance to the viewer.
    pub emission: Rgb,
    /// A walk below the surface.
    pub subsurface: Option<Subsurface>,
    /// Share of a hole in the film.
    pub holdout: f32,
}

impl Shading {
    /// Nothing yet.
    #[inline]
    pub fn new(surface: &Surface) -> Self {
        let lobes = LobeSet::new(surface.normal.as_vec3(), surface.flat.as_vec3());
        Self { lobes, transparent: Vec3::ZERO, emission: Vec3::ZERO, subsurface: None, holdout: 0.0 }
    }

    /// Mean normal of all that the surface does, by weight.
    pub fn mean_normal(&self, surface: &Surface) -> Vec3 {
        let lobes: Vec3 = self.lobes.lobes().map(|l| l.frame.n * mean(l.weight)).sum();
        let below = self.subsurface.as_ref().map_or(Vec3::ZERO, |s| s.normal * mean(s.weight));
        (lobes + below).try_normalize().unwrap_or(surface.normal.as_vec3())
    }
}

/// What a shader may depend on besides the hit.
#[derive(Clone, Copy, Debug)]
pub struct View {
    /// Mirrors count.
    pub reflective: bool,
    /// Refraction counts.
    pub refractive: bool,
    /// Light goes ways below the surface; else it is diffuse there.
    pub below: bool,
}

impl View {
    /// With everything that the closures have, for `mirrors`, none of them otherwise.
    pub const fn plain(mirrors: bool) -> Self {
        Self { reflective: mirrors, refractive: mirrors, below: true }
    }
}

/// Builds the lobes of one hit.
pub(super) struct Builder<'b, 's> {
    pub(super) surface: &'b Surface<'s>,
    pub(super) view: View,
    /// In place: a [`Shading`] has room for many lobes, which copies of it would carry along.
    pub(super) out: &'b mut Shading,
}

/// Adds what a hit does to light to `out`. Without a surface light goes straight on.
pub fn shade(closure: Option<&Closure>, surface: &Surface, view: View, out: &mut Shading) {
    match closure {
        Some(c) => Builder { surface, view, out }.add(c, Vec3::ONE),
        None => out.transparent = Vec3::ONE,
    }
}

/// The same by itself.
fn shaded(c: &Closure, surface: &Surface) -> Shading {
    let mut out = Shading::new(surface);
    shade(Some(c), surface, View::plain(true), &mut out);
    out
}

/// Share that goes straight on, for shadow rays.
pub fn transparency(closure: Option<&Closure>, surface: &Surface) -> Rgb {
    match closure {
        None => Vec3::ONE,
        Some(c) if !c.may_let_through() => Vec3::ZERO,
        Some(c) => straight_on(c, surface),
    }
}

fn straight_on(c: &Closure, s: &Surface) -> Rgb {
    match c {
        // Its layers dim what goes through a pane, which the lobes know.
        Closure::Principled(p) if p.is_pane() => shaded(c, s).transparent,
        Closure::Principled(p) => Vec3::splat(1.0 - s.scalar(&p.alpha).clamp(0.0, 1.0)),
        Closure::Transparent { color } => s.color(color).max(Vec3::ZERO),
        Closure::Mix { factor, a, b } => {
            let f = mix_factor(factor, s);
            straight_on(a, s) * (1.0 - f) + straight_on(b, s) * f
        }
        Closure::Add(a, b) => straight_on(a, s) + straight_on(b, s),
        _ => Vec3::ZERO,
    }
}

/// Light of its own alone.
pub fn emission(c: &Closure, s: &Surface) -> Rgb {
    match c {
        Closure::Emission { color, strength } => s.color(color) * s.scalar(strength),
        Closure::Mix { factor, a, b } => {
            let f = mix_factor(factor, s);
            emission(a, s) * (1.0 - f) + emission(b, s) * f
        }
        Closure::Add(a, b) => emission(a, s) + emission(b, s),
        // Coat and sheen dim it, which the lobes know.
        Closure::Principled(_) => shaded(c, s).emission,
        _ => Vec3::ZERO,
    }
}

/// The light of a closure, of front and back, where it is the same everywhere.
pub fn plain_emission(c: &Closure) -> Option<[Rgb; 2]> {
    let never = |s: &crate::scene::input::Scalar| s.as_constant().is_some_and(|v| v <= 0.0);
    let both = |a: [Rgb; 2], b: [Rgb; 2], wa: [f32; 2], wb: [f32; 2]| [a[0] * wa[0] + b[0] * wb[0], a[1] * wa[1] + b[1] * wb[1]];
    match c {
        Closure::Emission { color, strength } => Some([color.as_constant()? * strength.as_constant()?; 2]),
        Closure::Principled(p) if never(&p.emission_strength) => Some([Vec3::ZERO; 2]),
        Closure::Principled(p) if never(&p.sheen_weight) && never(&p.coat_weight) && p.alpha.as_constant() == Some(1.0) => {
            Some([p.emission_color.as_constant()? * p.emission_strength.as_constant()?; 2])
        }
        Closure::Principled(_) => None,
        Closure::Add(a, b) => Some(both(plain_emission(a)?, plain_emission(b)?, [1.0; 2], [1.0; 2])),
        Closure::Mix { factor, a, b } => {
            let (a, b) = (plain_emission(a)?, plain_emission(b)?);
            match factor {
                MixFactor::Backfacing => Some([a[0], b[1]]),
                MixFactor::Scalar(f) if f.as_constant().is_some() => {
                    let f = f.as_constant()?.clamp(0.0, 1.0);
                    Some(both(a, b, [1.0 - f; 2], [f; 2]))
                }
                _ => (a == [Vec3::ZERO; 2] && b == a).then_some(a),
            }
        }
        _ => Some([Vec3::ZERO; 2]),
    }
}

fn mix_factor(f: &MixFactor, s: &Surface) -> f32 {
    let cos = s.v.dot(s.normal.as_vec3()).abs().clamp(0.0, 1.0);
    let value = match f {
        MixFactor::Scalar(v) => s.scalar(v),
        MixFactor::Fresnel(ior) => {
            let eta = s.scalar(ior).max(1e-5);
            dielectric(cos, if s.backfacing { 1.0 / eta } else { eta }).0
        }
        MixFactor::Facing(blend) => {
            let blend = s.scalar(blend).clamp(0.0, 1.0 - 1e-5);
            let power = if blend < 0.5 { 2.0 * blend } else { 0.5 / (1.0 - blend) };
            1.0 - cos.powf(power)
        }
        MixFactor::Backfacing => f32::from(s.backfacing),
        MixFactor::ByRay(values) => values[s.seen_by as usize],
    };
    value.clamp(0.0, 1.0)
}

pub(super) fn mean(c: Rgb) -> f32 {
    c.element_sum() / 3.0
}

/// A normal about which a mirror does not send the viewer's light below the flat face. Source: Cycles' rule in words; the tilt is ours:
/// the mirrored direction is raised to just above the face.
fn valid_for_mirrors(n: Vec3, flat: Vec3, v: Vec3) -> Vec3 {
    let mirrored = n * (2.0 * n.dot(v)) - v;
    let least = (0.9 * flat.dot(v)).clamp(0.0, 0.01);
    if mirrored.dot(flat) >= least {
        return n;
    }
    let Some(along) = (mirrored - flat * mirrored.dot(flat)).try_normalize() else { return n };
    (v + along * (1.0 - least * least).sqrt() + flat * least).try_normalize().unwrap_or(n)
}

impl Builder<'_, '_> {
    fn add(&mut self, c: &Closure, weight: Rgb) {
        let s = self.surface;
        match c {
            Closure::Principled(p) => self.principled(p, weight),
            Closure::Mix { factor, a, b } => {
                let f = mix_factor(factor, s);
                if f < 1.0 {
                    self.add(a, weight * (1.0 - f));
                }
                if f > 0.0 {
                    self.add(b, weight * f);
                }
            }
            Closure::Add(a, b) => {
                self.add(a, weight);
                self.add(b, weight);
            }
            Closure::Emission { color, strength } => self.out.emission += weight * s.color(color) * s.scalar(strength),
            Closure::Transparent { color } => self.out.transparent += weight * s.color(color).max(Vec3::ZERO),
            Closure::Holdout => self.out.holdout += mean(weight),
            Closure::Diffuse { color, roughness, normal } => {
                self.diffuse(weight, s.color(color).max(Vec3::ZERO), s.scalar(roughness), normal.as_deref());
            }
            Closure::Translucent { color, normal } => {
                let (n, is_bent) = self.surface.bent_normal(normal.as_deref());
                self.push(weight * s.color(color).max(Vec3::ZERO), 1.0, Frame::about(n), LobeKind::Translucent, is_bent);
            }
            Closure::Sheen { color, roughness, normal } => {
                let (n, is_bent) = s.bent_normal(normal.as_deref());
                self.sheen(weight * s.color(color).max(Vec3::ZERO), s.scalar(roughness), n, is_bent);
            }
            Closure::Glossy { distribution, color, roughness, anisotropy, rotation, normal } => {
                if !self.view.reflective {
                    return;
                }
                let color = s.color(color).clamp(Vec3::ZERO, Vec3::ONE);
                let rough = s.scalar(roughness).clamp(0.0, 1.0);
                let (n, is_bent) = self.mirror_normal(normal.as_deref());
                let a = s.scalar(anisotropy).clamp(-0.99, 0.99);
                let width = rough * rough;
                let ggx = if a < 0.0 {
                    Ggx { ax: (width / (1.0 + a)).min(1.0), ay: width * (1.0 + a) }
                } else {
                    Ggx { ax: width * (1.0 - a), ay: (width / (1.0 - a)).min(1.0) }
                };
                let rough = (ggx.ax * ggx.ay).sqrt().sqrt();
                let frame = if a == 0.0 { Frame::about(n) } else { self.turned_frame(n, TangentInput::Object, s.scalar(rotation)) };
                let gain = self.compensation(*distribution, rough, n, color);
                let kind = LobeKind::Microfacet(Microfacet { ggx, fresnel: Fresnel::Mirror, refracts: false });
                self.push(weight * color * gain, 1.0, frame, kind, is_bent);
            }
            Closure::Conductor(c) => self.conductor(c, weight),
            Closure::Glass { distribution, color, roughness, ior, film_thickness, film_ior, normal } => {
                let color = s.color(color).max(Vec3::ZERO);
                let tint = [if self.view.reflective { color } else { Vec3::ZERO }, if self.view.refractive { color } else { Vec3::ZERO }];
                let ior = s.scalar(ior).max(1e-5);
                let film = self.film(film_thickness, film_ior, ior);
                self.glass(*distribution, weight, tint, Vec3::ONE, s.scalar(roughness), ior, film, normal.as_deref());
            }
            Closure::Refraction { color, roughness, ior, normal, .. } => {
                if !self.view.refractive {
                    return;
                }
                let rough = s.scalar(roughness).clamp(0.0, 1.0);
                let (n, is_bent) = self.mirror_normal(normal.as_deref());
                let ior = s.scalar(ior).max(1e-5);
                let eta = if s.backfacing { 1.0 / ior } else { ior };
                let m = Microfacet { ggx: Ggx::isotropic(rough * rough), fresnel: Fresnel::Clear { eta }, refracts: true };
                self.push(weight * s.color(color).max(Vec3::ZERO), 1.0, Frame::about(n), LobeKind::Microfacet(m), is_bent);
            }
            Closure::Subsurface { method, color, radius, scale, ior, anisotropy, roughness, normal } => {
                let (n, _) = s.bent_normal(normal.as_deref());
                let color = s.color(color).max(Vec3::ZERO);
                let radius = s.color(radius) * s.scalar(scale);
                // The roughness of this node is the width itself. Source: Cycles (measured).
                let entry = Entry::new(*method, s.scalar(ior), s.scalar(roughness));
                self.subsurface(weight * color, color, radius, s.scalar(anisotropy), entry, n);
            }
            Closure::Hair(h) => self.hair(h, weight),
        }
    }

    /// Adds a lobe; `albedo` weighs its chance.
    pub(super) fn push(&mut self, weight: Rgb, albedo: f32, frame: Frame, kind: LobeKind, is_bent: bool) {
        self.out.lobes.push(Lobe { weight, chance: mean(weight).abs() * albedo, frame, kind, is_bent });
    }

    /// A normal for mirrors.
    pub(super) fn mirror_normal(&self, input: Option<&NormalInput>) -> (Vec3, bool) {
        let (n, is_bent) = self.surface.bent_normal(input);
        (valid_for_mirrors(n, self.surface.flat.as_vec3(), self.surface.v), is_bent)
    }

    /// About `n`, x along the tangent turned by `turns`.
    pub(super) fn turned_frame(&self, n: Vec3, tangent: TangentInput, turns: f32) -> Frame {
        let (sin, cos) = (std::f32::consts::TAU * turns).sin_cos();
        if let TangentInput::Uv(set) = tangent
            && let Some((right, top)) = self.surface.uv_frame(set)
        {
            return Frame::with_tangent(n, right * cos + top * sin);
        }
        let f = Frame::with_tangent(n, self.surface.tangent());
        let t = f.t * cos + f.b * sin;
        Frame { t, b: n.cross(t), n }
    }

    /// Factor that puts back the light of many bounces between facets of mean reflectance `mean_f`. Source: Turquin 2019; Kulla and Conty 2017.
    pub(super) fn compensation(&self, distribution: Distribution, roughness: f32, n: Vec3, mean_f: Rgb) -> Rgb {
        if distribution == Distribution::Ggx {
            return Vec3::ONE;
        }
        let e = albedo::mirror(roughness, n.dot(self.surface.v).max(0.0)).max(1e-3);
        let missing = (1.0 - e) / e;
        let e_mean = albedo::mirror_mean(roughness);
        let many = mean_f * e_mean / (Vec3::ONE - mean_f * (1.0 - e_mean));
        Vec3::ONE + many * missing
    }

    pub(super) fn diffuse(&mut self, weight: Rgb, color: Rgb, roughness: f32, normal: Option<&NormalInput>) {
        let (n, is_bent) = self.surface.bent_normal(normal);
        self.diffuse_about(weight, color, roughness, n, is_bent);
    }

    pub(super) fn diffuse_about(&mut self, weight: Rgb, color: Rgb, roughness: f32, n: Vec3, is_bent: bool) {
        let kind = if roughness < 1e-5 {
            LobeKind::Lambert
        } else {
            LobeKind::OrenNayar(OrenNayar::new(roughness.min(1.0), color, n.dot(self.surface.v).clamp(0.0, 1.0)))
        };
        self.push(weight * color, 1.0, Frame::about(n), kind, is_bent);
    }

    /// Adds sheen and gives its albedo.
    pub(super) fn sheen(&mut self, weight: Rgb, roughness: f32, n: Vec3, is_bent: bool) -> f32 {
        let frame = Frame::about(n);
        let v = frame.to_local(self.surface.v);
        if v.z <= 0.0 {
            return 0.0;
        }
        let sheen = Sheen::new(roughness, v);
        self.push(weight, sheen.albedo, frame, LobeKind::Sheen(sheen), is_bent);
        sheen.albedo
    }

    /// The film on a body of index `ior`, as seen from the viewer's side.
    pub(super) fn film(&self, thickness: &Scalar, film_ior: &Scalar, ior: f32) -> Option<ThinFilm> {
        let nanometres = self.surface.scalar(thickness);
        let outside = if self.surface.backfacing { ior } else { 1.0 };
        (nanometres > 0.1).then(|| ThinFilm { nanometres, ior: self.surface.scalar(film_ior).max(1e-5) / outside })
    }

    /// Reflection and refraction; `tint` of the two, `f0_tint` of the reflectance along the normal.
    #[expect(clippy::too_many_arguments, reason = "the sockets of two nodes")]
    pub(super) fn glass(
        &mut self,
        d: Distribution,
        weight: Rgb,
        tint: [Rgb; 2],
        f0_tint: Rgb,
        roughness: f32,
        ior: f32,
        film: Option<ThinFilm>,
        n: Option<&NormalInput>,
    ) {
        if tint[0].max_element() <= 0.0 && tint[1].max_element() <= 0.0 {
            return;
        }
        let rough = roughness.clamp(0.0, 1.0);
        let eta = if self.surface.backfacing { 1.0 / ior } else { ior };
        let (n, is_bent) = self.mirror_normal(n);
        let cos = n.dot(self.surface.v).max(0.0);
        let f0 = f0_tint * f0_of(eta);
        let fresnel = film.map_or(Fresnel::Dielectric { eta, f0, tint }, |film| Fresnel::Film { film, eta, f0, tint });
        let gain = if d == Distribution::MultiGgx { 1.0 / albedo::glass(eta, rough, cos).max(0.05) } else { 1.0 };
        let (r, t, _) = fresnel.eval(cos);
        let m = Microfacet { ggx: Ggx::isotropic(rough * rough), fresnel, refracts: true };
        self.push(weight * gain, mean(r + t), Frame::about(n), LobeKind::Microfacet(m), is_bent);
    }

    pub(super) fn subsurface(&mut self, weight: Rgb, albedo: Rgb, radius: Rgb, anisotropy: f32, entry: Entry, normal: Vec3) {
        // Source: Cycles' least radius, 1e-8.
        let walks = radius.map(|r| f32::from(self.view.below && r >= 1e-8));
        let flat = weight * (Vec3::ONE - walks);
        if flat.max_element() > CUTOFF {
            self.push(flat, 1.0, Frame::about(normal), LobeKind::Lambert, false);
        }
        let weight = weight * walks;
        if weight.max_element() > CUTOFF {
            self.out.subsurface = Some(Subsurface { weight, albedo, radius, anisotropy: anisotropy.clamp(0.0, 0.9), entry, normal });
        }
    }
}
