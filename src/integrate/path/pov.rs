//! POV-Ray's textures and finishes as lobes, so that `.pov` scenes path-trace. What is approximated stands in docs/path.md.
//!
//! Diffuse light is Lambert's; highlights are GGX lobes as wide as Phong's or Blinn's powers and as bright on the whole; `reflection` is a mirror;
//! filter and transmit let light through, bent where the interior has another index. Ambient light is left out: the light between surfaces
//! takes its place.

use super::closure::{Builder, Shading, View, mean};
use super::plan::PathPlan;
use super::surface::Surface;
use crate::compile::texture::TextureNode;
use crate::kernel::PatternPoint;
use crate::kernel::bsdf::LobeKind;
use crate::kernel::bsdf::frame::Frame;
use crate::kernel::bsdf::fresnel::{Fresnel, dielectric};
use crate::kernel::bsdf::ggx::Ggx;
use crate::kernel::bsdf::microfacet::Microfacet;
use crate::kernel::cover::{Cover, for_covers, pattern_point};
use crate::kernel::finish::reflectivity;
use crate::kernel::pigment::eval_pigment;
use crate::kernel::texture::for_texture_parts;
use crate::math::{Rgb, Rgbft, Vec3};
use crate::scene::{Finish, Shader};

/// A cover in POV-Ray's manner, if the hit has one.
pub(super) type PlainCover = Option<Cover>;

/// Patterned textures inside patterned textures at most.
const MAX_DEPTH: u32 = 16;

impl PathPlan<'_> {
    /// The shader of a hit, or its cover in POV-Ray's manner.
    pub(super) fn material(&self, surface: &Surface) -> (Option<&Shader>, PlainCover) {
        let mut first = None;
        for_covers(self.scene, &surface.hit, surface.backfacing, |c| {
            if first.is_none_or(|f: Cover| c.weight > f.weight) {
                first = Some(c);
            }
        });
        let shader = first.and_then(|c| match self.scene.textures.textures.get(c.texture as usize) {
            Some(TextureNode::Principled(ix)) => Some(&*self.shaders[*ix as usize]),
            _ => None,
        });
        (shader, first)
    }

    /// Material of a hit, into `TextureTables::principled`.
    pub(super) fn material_ix(&self, surface: &Surface) -> Option<u32> {
        match self.scene.textures.textures.get(self.cover_ix(surface)? as usize) {
            Some(TextureNode::Principled(ix)) => Some(*ix),
            _ => None,
        }
    }

    /// Cover of a hit, into `TextureTables::textures`.
    pub(super) fn cover_ix(&self, surface: &Surface) -> Option<u32> {
        Some(self.material(surface).1?.texture)
    }

    /// Lobes of a hit on a POV-Ray texture.
    pub(super) fn pov_shading(&self, surface: &Surface, cover: PlainCover, view: View, out: &mut Shading) {
        let Some(c) = cover else { return out.transparent = Vec3::ONE };
        let p = pattern_point(self.scene, &surface.hit, surface.prim, c.transform_ix, surface.normal, -surface.v.as_dvec3());
        Builder { surface, view, out }.texture(self, c.texture, &p, Vec3::ONE, 0);
    }

    /// What a shadow ray keeps at a POV-Ray texture: what goes straight on.
    pub(super) fn pov_transparency(&self, surface: &Surface, cover: PlainCover) -> Rgb {
        let mut out = Shading::new(surface);
        self.pov_shading(surface, cover, View::plain(false), &mut out);
        out.transparent
    }
}

impl Builder<'_, '_> {
    fn texture(&mut self, plan: &PathPlan, texture: u32, p: &PatternPoint, weight: Rgb, depth: u32) {
        let scene = plan.scene;
        match &scene.textures.textures[texture as usize] {
            TextureNode::Layers { start, len } => {
                let mut weight = weight;
                for k in (*start..*start + *len).rev() {
                    let layer = scene.textures.layers[k as usize];
                    let c = eval_pigment(scene, layer.pigment, p).unwrap_or(Rgbft::CLEAR);
                    let finish = &scene.textures.finishes[layer.finish as usize];
                    let last = k == *start;
                    weight = self.layer(plan, &c, finish, weight, last);
                }
            }
            // A material of an import inside a POV-Ray map cannot be; it would be drawn alone.
            TextureNode::Principled(_) => {}
            node if depth < MAX_DEPTH => {
                let mut parts: [(u32, f32); 8] = [(0, 0.0); 8];
                let mut n = 0;
                let inner = for_texture_parts(scene, node, p, |t, share| {
                    if n < parts.len() {
                        parts[n] = (t, share);
                        n += 1;
                    }
                });
                for (t, share) in &parts[..n] {
                    self.texture(plan, *t, &inner, weight * *share, depth + 1);
                }
            }
            _ => {}
        }
    }

    /// Adds a layer and gives what is left for those below.
    fn layer(&mut self, plan: &PathPlan, c: &Rgbft, finish: &Finish, weight: Rgb, last: bool) -> Rgb {
        let s = self.surface;
        let n = s.normal.as_vec3();
        let opacity = c.opacity().clamp(0.0, 1.0);
        let color = c.rgb.max(Vec3::ZERO);
        self.out.emission += weight * color * finish.emission * opacity;
        self.diffuse_about(weight * finish.diffuse * opacity, color, 0.0, n, false);
        if finish.diffuse_back > 0.0 {
            self.push(weight * finish.diffuse_back * opacity * color, 1.0, Frame::about(n), LobeKind::Translucent, false);
        }
        let cos = n.dot(s.v).clamp(0.0, 1.0);
        if self.view.reflective {
            let tint = Vec3::ONE + (color - Vec3::ONE) * finish.metallic.clamp(0.0, 1.0);
            for (strength, power) in [(finish.specular, 1.0 / finish.roughness.max(1e-4)), (finish.phong, 4.0 * finish.phong_size)] {
                if strength > 0.0 {
                    // Blinn's power is about GGX of this width; Phong's angle is twice Blinn's. A highlight gives back 8 s / (power + 1) on the whole.
                    let width = (2.0 / (power + 2.0)).sqrt();
                    let share = (8.0 * strength / (power + 1.0)).min(1.0);
                    let m = Microfacet { ggx: Ggx::isotropic(width), fresnel: Fresnel::Mirror, refracts: false };
                    self.push(weight * tint * share, 1.0, Frame::about(n), LobeKind::Microfacet(m), false);
                }
            }
        }
        let ior = plan.scene.interiors.get(s.prim.interior_ix as usize).map_or(1.0, |i| i.ior) as f32;
        let eta = if s.backfacing { 1.0 / ior.max(1e-3) } else { ior.max(1e-3) };
        let mirror = reflectivity(&finish.reflection, f64::from(cos), f64::from(eta), color);
        if mirror.max_element() > 0.0 && self.view.reflective {
            self.mirror(weight * mirror, n);
        }
        let mut through = weight * c.transmittance();
        if finish.conserve_energy {
            through *= (Vec3::ONE - mirror).max(Vec3::ZERO);
        }
        if !last || through.max_element() <= 0.0 {
            return through;
        }
        if eta == 1.0 {
            self.out.transparent += through;
        } else if dielectric(cos, eta).1 == 0.0 {
            self.mirror(through, n);
        } else if self.view.refractive {
            let m = Microfacet { ggx: Ggx::isotropic(0.0), fresnel: Fresnel::Clear { eta }, refracts: true };
            self.push(through, 1.0, Frame::about(n), LobeKind::Microfacet(m), false);
        }
        Vec3::ZERO
    }

    fn mirror(&mut self, weight: Rgb, n: Vec3) {
        debug_assert!(mean(weight).is_finite());
        let m = Microfacet { ggx: Ggx::isotropic(0.0), fresnel: Fresnel::Mirror, refracts: false };
        self.push(weight, 1.0, Frame::about(n), LobeKind::Microfacet(m), false);
    }
}

/// What of a scene the path integrator leaves out or approximates, for the user: a key and a sentence each.
pub fn left_out(scene: &crate::compile::CompiledScene) -> Vec<(&'static str, &'static str)> {
    let t = &scene.textures;
    let f = &scene.features;
    let mut list = Vec::new();
    let mut note = |used: bool, key, text| {
        if used {
            list.push((key, text));
        }
    };
    note(
        !t.layers.is_empty(),
        "path-pov",
        "path tracing: POV-Ray's ambient light is left out, highlights become glossy lobes of about their width",
    );
    note(f.normals && !t.layers.is_empty(), "path-bumps", "path tracing: bumps of POV-Ray's textures are left out");
    note(f.media || f.fog, "path-media", "path tracing: POV-Ray's media, fog and fading interiors are left out");
    note(f.photons, "path-photons", "path tracing: the photons block is left out; paths find caustics themselves");
    list
}
