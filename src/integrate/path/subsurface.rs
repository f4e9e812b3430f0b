//! Random walks below a surface: light goes straight in, scatters inside the object, and leaves where the walk meets its surface again.
//!
//! Source: Chiang, Kutz and Burley 2016; the colour of a body from that of its parts by van de Hulst's formula for a half space lit from
//! all sides (van de Hulst 1980, vol. 2), solved for the single-scattering albedo.

use super::closure::Subsurface;
use super::passes::Shares;
use super::sampler::Set;
use super::shadow::NEAR;
use super::surface::Surface;
use super::trace::{Path, PathTracer};
use crate::kernel::bsdf::frame::Frame;
use crate::kernel::bsdf::{Event, Lobe, LobeKind, LobeSet};
use crate::math::sobol::Pcg;
use crate::math::{DVec3, Ray, Vec3};

/// Most steps of a walk. Source: Cycles.
const MAX_STEPS: u32 = 256;

/// Single-scattering albedo of a body whose surface reflects `albedo` of light from everywhere, by channel, for mean cosine `g`.
fn single_scattering(albedo: f32, g: f32) -> f32 {
    let r = albedo.clamp(0.0, 0.9999);
    // R = (1 - s)(1 - 0.139 s) / (1 + 1.17 s), s² = (1 - a) / (1 - a g).
    let b = 1.139 + 1.17 * r;
    let s = (b - (b * b - 4.0 * 0.139 * (1.0 - r)).max(0.0).sqrt()) / (2.0 * 0.139);
    let s_sq = s * s;
    ((1.0 - s_sq) / (1.0 - g * s_sq)).clamp(0.0, 0.999_999)
}

impl PathTracer<'_> {
    /// Walks; true when the path left the body again.
    pub(super) fn walk_below(&mut self, path: &mut Path, surface: &Surface, s: &Subsurface) -> bool {
        let plan = self.plan;
        let mut rng = Pcg::new(path.sampler.stream(path.step) ^ 0x2545_f491);
        let g = s.anisotropy;
        let albedo = s.albedo.map(|a| single_scattering(a, g));
        // Mean free paths are those of isotropic scattering; channels that do not walk have weight 0. Source: Cycles divides the radius of
        // this method by 4π so that it looks like its older profiles.
        let extinction = s.radius.map(|r| 4.0 * std::f32::consts::PI / r.max(1e-6)) / (1.0 - g);
        let mut throughput = Vec3::new(
            if s.albedo.x > 0.0 { s.weight.x / s.albedo.x } else { 0.0 },
            if s.albedo.y > 0.0 { s.weight.y / s.albedo.y } else { 0.0 },
            if s.albedo.z > 0.0 { s.weight.z / s.albedo.z } else { 0.0 },
        );
        // Light of the viewer's direction goes straight in. Source: Cycles' walk in a half space gives more the flatter the view, whatever the
        // roughness and the index (measured); drawn by the cosine it would give the same to all.
        let mut dir = -surface.v.as_dvec3();
        if dir.dot(surface.flat) >= 0.0 {
            return false;
        }
        let mut at = surface.hit.point;
        for step in 0..MAX_STEPS {
            // The channel that the distance is drawn for, by what it still carries.
            let carries = throughput * albedo;
            let sum = carries.element_sum();
            if !(sum > 0.0) {
                return false;
            }
            let chances = carries / sum;
            let pick = rng.draw();
            let sigma = if pick < chances.x {
                extinction.x
            } else if pick < chances.x + chances.y {
                extinction.y
            } else {
                extinction.z
            };
            let t = f64::from(-(1.0 - rng.draw()).ln() / sigma);
            let ray = Ray::new(at, dir.normalize());
            let hit = plan.intersect_object(surface.prim.object_ix, &ray, path.time, NEAR, t);
            if step == 0 && hit.is_none() && t.is_infinite() {
                return false;
            }
            let reached = hit.as_ref().map_or(t, |h| h.t);
            let left = (-extinction * reached as f32).map(f32::exp);
            if let Some(hit) = hit {
                throughput *= left / left.dot(chances).max(1e-30);
                path.throughput *= throughput;
                return self.leave_body(path, Surface::new(plan.scene, hit, ray.dir, path.time));
            }
            let pdf = (left * extinction).dot(chances);
            throughput *= left * extinction * albedo / pdf.max(1e-30);
            at = ray.at(t);
            let (u, v) = (rng.draw(), rng.draw());
            dir = scatter(g, ray.dir, u, v);
            // Unbiased end of walks that carry little.
            let most = throughput.max_element();
            if step > 16 && most < 0.2 {
                if rng.draw() * 0.2 >= most {
                    return false;
                }
                throughput *= 0.2 / most;
            }
        }
        false
    }

    /// Light where a walk leaves, and a diffuse bounce from there.
    fn leave_body(&mut self, path: &mut Path, inside: Surface) -> bool {
        let surface = inside.turned();
        let n = surface.normal.as_vec3();
        let mut lobes = LobeSet::new(n, surface.flat.as_vec3());
        lobes.push(Lobe { weight: Vec3::ONE, chance: 1.0, frame: Frame::about(n), kind: LobeKind::Lambert, is_bent: false });
        path.step += 1;
        let light = path.sampler.at(path.step, Set::Light);
        self.add_direct(path, &surface, &lobes, light);
        let Some(b) = lobes.sample(n, path.sampler.at(path.step, Set::Bsdf)) else { return false };
        path.throughput *= b.value / b.pdf;
        if !(path.throughput.max_element() > 0.0) {
            return false;
        }
        if path.bounces.total == 0 {
            path.first = Shares::DIFFUSE;
        }
        self.leave(path, &surface, &Some(surface.normal), b.l, b.pdf, false, Event::Diffuse);
        true
    }
}

/// A new direction by Henyey and Greenstein.
fn scatter(g: f32, dir: DVec3, u: f32, v: f32) -> DVec3 {
    super::volume::sample_phase(g, dir, u, v).0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_half_space_has_the_albedo_that_was_asked_for() {
        let mut rng = Pcg::new(1);
        for want in [0.2, 0.5, 0.8] {
            let a = single_scattering(want, 0.0);
            let n = 40_000;
            let mut sum = 0.0;
            for _ in 0..n {
                // Depth below the surface, cosine of the way down, weight.
                let (mut z, mut cos, mut w) = (0.0f32, rng.draw().sqrt(), 1.0f32);
                loop {
                    z += -(1.0 - rng.draw()).ln() * cos;
                    if z <= 0.0 {
                        sum += w;
                        break;
                    }
                    w *= a;
                    if w < 1e-4 {
                        break;
                    }
                    cos = 2.0 * rng.draw() - 1.0;
                }
            }
            let got = sum / n as f32;
            assert!((got - want).abs() < 0.012, "{got}, not {want}");
        }
    }
}
