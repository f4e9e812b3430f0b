//! The Principled closure of Blender 4.5 as lobes: alpha, sheen, coat, emission, metal, transmission, specular, subsurface, diffuse; each
//! layer takes its share of the light and hands the rest on. And hair.

use super::closure::{Builder, CUTOFF, Entry, mean};
use crate::kernel::bsdf::frame::Frame;
use crate::kernel::bsdf::fresnel::{Fresnel, conductor_mean, f0_of, f82_dip, f82_mean, highlight_of};
use crate::kernel::bsdf::ggx::Ggx;
use crate::kernel::bsdf::hair::{Hair, HairParams, sigma_of_melanin, sigma_of_reflectance};
use crate::kernel::bsdf::microfacet::Microfacet;
use crate::kernel::bsdf::thin_film::ThinFilm;
use crate::kernel::bsdf::{LobeKind, albedo};
use crate::math::{Rgb, Vec3};
use crate::scene::input::{Scalar, TangentInput};
use crate::scene::shader::{ConductorClosure, HairClosure, HairColor, PrincipledClosure, SubsurfaceMethod};

/// What a layer of albedo `layer` (relative to light of weight `weight`) leaves for those below.
fn below(weight: Rgb, layer: Rgb) -> Rgb {
    let share = Vec3::new(
        if weight.x > 0.0 { layer.x / weight.x } else { 0.0 },
        if weight.y > 0.0 { layer.y / weight.y } else { 0.0 },
        if weight.z > 0.0 { layer.z / weight.z } else { 0.0 },
    );
    weight * (1.0 - share.max_element()).clamp(0.0, 1.0)
}

impl Builder<'_, '_> {
    pub(super) fn principled(&mut self, p: &PrincipledClosure, weight: Rgb) {
        let s = self.surface;
        let unit = |v: f32| v.clamp(0.0, 1.0);
        let mut weight = weight;
        let alpha = unit(s.scalar(&p.alpha));
        if alpha < 1.0 {
            self.out.transparent += weight * (1.0 - alpha);
            weight *= alpha;
        }
        let (n, is_bent) = s.bent_normal(p.normal.as_deref());
        let coat = unit(s.scalar(&p.coat_weight));

        let sheen = unit(s.scalar(&p.sheen_weight));
        // Most surfaces have neither.
        let (coat_n, coat_bent) = if sheen > CUTOFF || coat > CUTOFF { self.mirror_normal(p.coat_normal.as_deref()) } else { (n, is_bent) };
        if sheen > CUTOFF {
            let about = (n + (coat_n - n) * coat).normalize_or(n);
            let layer = weight * s.color(&p.sheen_tint).max(Vec3::ZERO) * sheen;
            let albedo = self.sheen(layer, s.scalar(&p.sheen_roughness), about, is_bent);
            weight = below(weight, layer * albedo);
        }
        if coat > CUTOFF {
            weight = self.coat(p, weight, coat, coat_n, coat_bent);
        }
        let strength = s.scalar(&p.emission_strength);
        if strength > 0.0 {
            self.out.emission += weight * s.color(&p.emission_color) * strength;
        }
        let base = s.color(&p.base_color).max(Vec3::ZERO);
        let roughness = s.scalar(&p.roughness);
        let tint = s.color(&p.specular_tint).max(Vec3::ZERO);
        let metallic = unit(s.scalar(&p.metallic));
        if metallic > CUTOFF {
            if self.view.reflective {
                let (mirror_n, _) = self.mirror_normal(p.normal.as_deref());
                self.metal(p, weight * metallic, base.min(Vec3::ONE), tint.min(Vec3::ONE), roughness, mirror_n, is_bent);
            }
            weight *= 1.0 - metallic;
        }
        let ior = s.scalar(&p.ior).max(1e-5);
        let transmission = unit(s.scalar(&p.transmission_weight));
        if transmission > CUTOFF {
            let reflect = if self.view.reflective { Vec3::ONE } else { Vec3::ZERO };
            if p.thin_walled {
                let (mirror_n, _) = self.mirror_normal(p.normal.as_deref());
                self.thin_wall(p, weight * transmission, base, roughness, ior, mirror_n);
            } else {
                let through = if self.view.refractive { base.map(f32::sqrt) } else { Vec3::ZERO };
                let film = self.film(&p.thin_film_thickness, &p.thin_film_ior, ior);
                self.glass(p.distribution, weight * transmission, [reflect, through], tint, roughness, ior, film, p.normal.as_deref());
            }
            weight *= 1.0 - transmission;
        }
        if weight.max_element() <= CUTOFF {
            return;
        }
        if self.view.reflective {
            weight = self.specular(p, weight, tint, roughness, ior, is_bent);
        }
        let subsurface = unit(s.scalar(&p.subsurface_weight));
        if subsurface > CUTOFF {
            let radius = s.color(&p.subsurface_radius).max(Vec3::ZERO) * s.scalar(&p.subsurface_scale);
            // The index is that of the highlight, which its level moves; skin has one of its own, and is rough. Source: Cycles (measured).
            let skin = p.subsurface_method == SubsurfaceMethod::RandomWalkSkin;
            let index = if skin { s.scalar(&p.subsurface_ior) } else { highlight_of(ior, s.scalar(&p.specular_ior_level).max(0.0)).0 };
            let entry = Entry::new(p.subsurface_method, index, if skin { 1.0 } else { roughness.clamp(0.0, 1.0).powi(2) });
            self.subsurface(weight * base * subsurface, base, radius, s.scalar(&p.subsurface_anisotropy), entry, n);
            weight *= 1.0 - subsurface;
        }
        self.diffuse_about(weight, base, s.scalar(&p.diffuse_roughness), n, is_bent);
    }

    /// Adds the coat and gives what is left for what lies below.
    fn coat(&mut self, p: &PrincipledClosure, weight: Rgb, coat: f32, n: Vec3, is_bent: bool) -> Rgb {
        let s = self.surface;
        let mut weight = weight;
        let ior = s.scalar(&p.coat_ior).max(1.0);
        let cos = n.dot(s.v).clamp(0.0, 1.0);
        if self.view.reflective {
            let rough = s.scalar(&p.coat_roughness).clamp(0.0, 1.0);
            let f0 = f0_of(ior);
            let fresnel = Fresnel::Dielectric { eta: ior, f0: Vec3::splat(f0), tint: [Vec3::ONE, Vec3::ZERO] };
            let f = f0 + (1.0 - f0) * albedo::dielectric_mix(ior, rough, cos);
            let m = Microfacet { ggx: Ggx::isotropic(rough * rough), fresnel, refracts: false };
            self.push(weight * coat, f, Frame::about(n), LobeKind::Microfacet(m), is_bent);
            weight = below(weight, weight * coat * f * albedo::mirror(rough, cos));
        }
        let tint = s.color(&p.coat_tint).clamp(Vec3::ZERO, Vec3::ONE);
        if tint != Vec3::ONE {
            // The way through the coat, in units of its depth.
            let depth = 1.0 / (1.0 - (1.0 - cos * cos) / (ior * ior)).max(1e-6).sqrt();
            let through = tint.map(|t| t.powf(depth));
            weight *= Vec3::ONE + (through - Vec3::ONE) * coat;
        }
        weight
    }

    /// Facets of a Principled lobe, the frame they stand in, and their roughness on the whole.
    fn widths(&self, p: &PrincipledClosure, roughness: f32, n: Vec3) -> (Ggx, Frame, f32) {
        self.stretched(roughness, self.surface.scalar(&p.anisotropic), p.tangent, &p.anisotropic_rotation, n)
    }

    /// The same along a tangent turned by `rotation`.
    fn stretched(&self, roughness: f32, anisotropic: f32, tangent: TangentInput, rotation: &Scalar, n: Vec3) -> (Ggx, Frame, f32) {
        let rough = roughness.clamp(0.0, 1.0);
        let width = rough * rough;
        if anisotropic <= 0.0 {
            return (Ggx::isotropic(width), Frame::about(n), rough);
        }
        let aspect = (1.0 - 0.9 * anisotropic.min(1.0)).sqrt();
        // Widths end at 1. Source: Cycles (measured).
        let ggx = Ggx { ax: (width / aspect).min(1.0), ay: width * aspect };
        (ggx, self.turned_frame(n, tangent, self.surface.scalar(rotation)), (ggx.ax * ggx.ay).sqrt().sqrt())
    }

    fn metal(&mut self, p: &PrincipledClosure, weight: Rgb, f0: Rgb, tint: Rgb, roughness: f32, n: Vec3, is_bent: bool) {
        let (ggx, frame, rough) = self.widths(p, roughness, n);
        let dip = f82_dip(f0, tint);
        let fresnel = Fresnel::F82 { f0, dip };
        let gain = self.compensation(p.distribution, rough, n, f82_mean(f0, dip));
        let (f, ..) = fresnel.eval(n.dot(self.surface.v).clamp(0.0, 1.0));
        self.push(weight * gain, mean(f), frame, LobeKind::Microfacet(Microfacet { ggx, fresnel, refracts: false }), is_bent);
    }

    /// A metal by index and extinction.
    pub(super) fn conductor(&mut self, c: &ConductorClosure, weight: Rgb) {
        let s = self.surface;
        if !self.view.reflective {
            return;
        }
        let (index, extinction) = (s.color(&c.ior).max(Vec3::ZERO), s.color(&c.extinction).max(Vec3::ZERO));
        let (n, is_bent) = self.mirror_normal(c.normal.as_deref());
        let (ggx, frame, rough) = self.stretched(s.scalar(&c.roughness), s.scalar(&c.anisotropy), TangentInput::Object, &c.rotation, n);
        let fresnel = Fresnel::Conductor { n: index, k: extinction };
        let gain = self.compensation(c.distribution, rough, n, conductor_mean(index, extinction));
        let (f, ..) = fresnel.eval(n.dot(s.v).clamp(0.0, 1.0));
        self.push(weight * gain, mean(f), frame, LobeKind::Microfacet(Microfacet { ggx, fresnel, refracts: false }), is_bent);
    }

    /// Adds the dielectric highlight and gives what is left.
    fn specular(&mut self, p: &PrincipledClosure, weight: Rgb, tint: Rgb, roughness: f32, ior: f32, is_bent: bool) -> Rgb {
        let s = self.surface;
        let level = s.scalar(&p.specular_ior_level).max(0.0);
        let (eta, f0) = highlight_of(ior, level);
        if f0 <= 0.0 && eta == 1.0 {
            return weight;
        }
        let (n, _) = self.mirror_normal(p.normal.as_deref());
        let f0_tinted = (tint * f0).min(Vec3::ONE);
        let (ggx, frame, rough) = self.widths(p, roughness, n);
        let cos = n.dot(s.v).clamp(0.0, 1.0);
        let tints = [Vec3::ONE, Vec3::ZERO];
        let thickness = s.scalar(&p.thin_film_thickness);
        // Of films too: their mean is not known, and Cycles measures so.
        let mean_f = f0_tinted + (Vec3::ONE - f0_tinted) * albedo::dielectric_mean(eta);
        let (fresnel, f) = if thickness > 0.1 {
            let film = ThinFilm { nanometres: thickness, ior: s.scalar(&p.thin_film_ior).max(1e-5) };
            let fresnel = Fresnel::Film { film, eta, f0: f0_tinted, tint: tints };
            let f = fresnel.eval(cos).0;
            (fresnel, f)
        } else {
            let fresnel = Fresnel::Dielectric { eta, f0: f0_tinted, tint: tints };
            let f = f0_tinted + (Vec3::ONE - f0_tinted) * albedo::dielectric_mix(eta, rough, cos);
            (fresnel, f)
        };
        let gain = self.compensation(p.distribution, rough, n, mean_f);
        let layer = weight * gain * f * albedo::mirror(rough, cos);
        self.push(weight * gain, mean(f), frame, LobeKind::Microfacet(Microfacet { ggx, fresnel, refracts: false }), is_bent);
        below(weight, layer)
    }

    /// A pane: reflection at the front, light straight through, spread by the roughness not at all.
    fn thin_wall(&mut self, p: &PrincipledClosure, weight: Rgb, base: Rgb, roughness: f32, ior: f32, n: Vec3) {
        let rough = roughness.clamp(0.0, 1.0);
        let cos = n.dot(self.surface.v).clamp(0.0, 1.0);
        let f0 = f0_of(ior);
        let f = f0 + (1.0 - f0) * albedo::dielectric_mix(ior, rough, cos);
        // Both faces, and all bounces between them.
        let both = 2.0 * f / (1.0 + f);
        if self.view.reflective {
            let (ggx, frame, _) = self.widths(p, roughness, n);
            let m = Microfacet { ggx, fresnel: Fresnel::Mirror, refracts: false };
            self.push(weight * both, 1.0, frame, LobeKind::Microfacet(m), false);
        }
        self.out.transparent += weight * base * (1.0 - both);
    }

    pub(super) fn hair(&mut self, h: &HairClosure, weight: Rgb) {
        let s = self.surface;
        let radial = s.scalar(&h.radial_roughness).clamp(0.001, 1.0);
        let sigma = match &h.color {
            HairColor::Absorption(c) => s.color(c).max(Vec3::ZERO),
            HairColor::Melanin { melanin, redness, tint, .. } => {
                let tint = s.color(tint).max(Vec3::ZERO);
                let dye = if tint == Vec3::ONE { Vec3::ZERO } else { sigma_of_reflectance(tint, radial) };
                sigma_of_melanin(s.scalar(melanin), s.scalar(redness).clamp(0.0, 1.0)) + dye
            }
            HairColor::Reflectance(c) => sigma_of_reflectance(s.color(c).clamp(Vec3::ZERO, Vec3::ONE), radial),
        };
        let params = HairParams {
            sigma,
            roughness: s.scalar(&h.roughness).clamp(0.001, 1.0),
            radial_roughness: radial,
            coat: s.scalar(&h.coat).clamp(0.0, 1.0),
            ior: s.scalar(&h.ior).max(1.0001),
            offset_rad: s.scalar(&h.offset_rad),
        };
        let Some(f) = s.fibre() else { return self.diffuse(weight, Vec3::splat(0.5), 0.0, None) };
        let frame = Frame { t: f.tangent, b: f.facing.cross(f.tangent), n: f.facing };
        let hair = Hair::new(&params, f.offset, frame.to_local(s.v));
        self.push(weight, 1.0, frame, LobeKind::Hair(hair), false);
    }
}
