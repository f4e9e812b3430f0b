//! Random walks below a surface: light is bent as it enters, scatters inside the object, and leaves where the walk meets its surface again.
//!
//! Source: Chiang, Kutz and Burley 2016; the bend at rough surfaces by Walter et al. 2007; the colour of a body from that of its parts
//! measured, see [`single_scattering`].

use super::closure::{Entry, Subsurface};
use super::passes::Shares;
use super::sampler::Set;
use super::shadow::NEAR;
use super::surface::Surface;
use super::trace::{Path, PathTracer};
use crate::kernel::bsdf::frame::{Frame, cosine_hemisphere};
use crate::kernel::bsdf::fresnel::dielectric;
use crate::kernel::bsdf::ggx::Ggx;
use crate::kernel::bsdf::{Event, Lobe, LobeKind, LobeSet};
use crate::math::sobol::Pcg;
use crate::math::{DVec3, Ray, Vec3};

/// Most steps of a walk. Source: Cycles.
const MAX_STEPS: u32 = 256;

/// Steps of a walk that know of the mean cosine: those after scatter evenly, see [`similar`]. Source: Cycles, by what slabs of eight
/// depths let through (`tests/measured/cycles_subsurface.py`): 9 and 11 are 4 standard errors off.
const ANISOTROPIC_STEPS: u32 = 10;

/// Extinction and single-scattering albedo of even scattering that is like that of mean cosine `g`: absorption and scattering times (1 - g) stay.
/// Source: Wyman, Patterson and Wilson 1989 (similarity relations).
fn similar(extinction: Vec3, albedo: Vec3, g: f32) -> (Vec3, Vec3) {
    let scattering = extinction * albedo;
    let even = extinction - scattering * g;
    (even, scattering * (1.0 - g) / even)
}

/// What a half space without absorption reflects of light from everywhere within [`MAX_STEPS`]: whiter there is none.
const WHITEST: f32 = 0.9185;
/// Coefficients of the logarithm of (1 - a) / (WHITEST - albedo), a: single-scattering albedo.
const ABSORPTION: [f32; 6] = [-3.285_523, 6.084_287, -9.058_01, 14.451_427, -12.053_876, 4.291_786];

/// What mean cosines add to (1 - a) / (1 - g a), the square of the similarity parameter, of even scattering: Chebyshev coefficients of the
/// albedo (2 albedo - 1, by row) and of the mean cosine (g / 0.45 - 1).
const ANISOTROPY: [[f32; 9]; 5] = [
    [-0.003_764, -0.004_743, -0.001_315, -0.000_96, 0.000_018, 0.001_367, 0.001_887, -0.000_337, -0.001_5],
    [-0.001_889, -0.006_184, -0.006_329, -0.003_646, -0.002_295, -0.001_472, -0.000_205, 0.000_867, 0.000_273],
    [-0.003_308, -0.003_339, -0.000_609, -0.000_365, -0.000_493, -0.000_342, -0.000_591, 0.000_398, 0.001_353],
    [0.000_656, 0.001_018, 0.001_306, 0.001_724, 0.001_774, 0.001_409, 0.001_143, 0.000_21, -0.000_516],
    [0.000_713, 0.001_173, 0.000_711, 0.000_207, -0.000_088, -0.000_105, -0.000_267, 0.000_035, 0.000_233],
];

/// Sum of `c` times Chebyshev's polynomials at `x`.
fn chebyshev(c: &[f32], x: f32) -> f32 {
    let (mut now, mut next, mut sum) = (1.0, x, 0.0);
    for c in c {
        sum += c * now;
        (now, next) = (next, 2.0 * x * next - now);
    }
    sum
}

/// Single-scattering albedo of a body that shall be seen with `albedo`, by channel, for mean cosine `g`, 0 to 0.9.
///
/// Source: Cycles, whose half spaces lit along the normal were measured at 14 albedos and 13 mean cosines (`tests/measured/cycles_subsurface.py`)
/// and turned into single-scattering albedos by counting walks (rms 0.0006 of the similarity parameter, fitted). Of even
/// scattering it is what makes a half space of no more than `MAX_STEPS` steps reflect 1.011 times `albedo` of light from everywhere. Of others it
/// is near what is similar, (1 - a) / (1 - g a) the same, but bodies of g 0.8 and 0.9 absorb nothing from albedos of 0.79 and 0.705 up.
fn single_scattering(albedo: f32, g: f32) -> f32 {
    let x = WHITEST - albedo.max(0.0);
    let mut s_sq = x * ABSORPTION.iter().rev().fold(0.0, |sum, c| sum * x + c).exp();
    if g > 0.0 {
        let rows = ANISOTROPY.map(|row| chebyshev(&row, g / 0.45 - 1.0));
        s_sq += chebyshev(&rows, 2.0 * albedo.clamp(0.0, 1.0) - 1.0);
    }
    let s_sq = s_sq.clamp(0.0, 1.0);
    ((1.0 - s_sq) / (1.0 - g * s_sq)).clamp(0.0, 0.999_999)
}

/// Mean free path of skin of a colour, in units of its radius, for index `eta`: the dipole's colour solved for the root of 3 (1 - a).
/// Source: Jensen, Marschner, Levoy and Hanrahan 2001, equation 15; that Cycles has it, measured by what slabs let through.
fn skin_step(albedo: f32, eta: f32) -> f32 {
    let inner = -1.44 / (eta * eta) + 0.71 / eta + 0.668 + 0.0636 * eta;
    let edge = 4.0 / 3.0 * (1.0 + inner) / (1.0 - inner);
    let (mut low, mut high) = (0.0f32, 3.0f32.sqrt());
    for _ in 0..16 {
        let s = 0.5 * (low + high);
        let color = 0.5 * (1.0 - s * s / 3.0) * (1.0 + (-edge * s).exp()) * (-s).exp();
        if color > albedo {
            low = s;
        } else {
            high = s;
        }
    }
    high
}

/// A direction into the body for light that goes against `v`, unit, above the surface; z is the normal. `None`: it does not enter.
/// Draws three numbers.
fn entry_direction(entry: &Entry, v: Vec3, rng: &mut Pcg) -> Option<Vec3> {
    let (u, w, pick) = (rng.draw(), rng.draw(), rng.draw());
    // Source: Blender's manual names a mix, Cycles' albedos are those of one half each (measured).
    if entry.skin && pick < 0.5 {
        return Some(-cosine_hemisphere(u, w));
    }
    let ggx = Ggx::isotropic(entry.width);
    let h = if ggx.is_singular() { Vec3::Z } else { ggx.sample_visible(v, u, w) };
    let vh = v.dot(h);
    let (_, t) = dielectric(vh, entry.eta);
    let l = h * (vh / entry.eta + t) - v / entry.eta;
    (l.z < 0.0).then_some(l)
}

impl PathTracer<'_> {
    /// Walks; true when the path left the body again.
    pub(super) fn walk_below(&mut self, path: &mut Path, surface: &Surface, s: &Subsurface) -> bool {
        let plan = self.plan;
        let mut rng = Pcg::new(path.sampler.stream(path.step) ^ 0x2545_f491);
        let mut g = s.anisotropy;
        let mut albedo = s.albedo.map(|a| single_scattering(a, g));
        // Mean free paths are those of isotropic scattering; channels that do not walk have weight 0. Source of the 4π, with which the method looks
        // like Blender's older profiles: Cycles (what slabs let through, measured).
        let steps = if s.entry.skin { s.albedo.map(|a| 1.0 / skin_step(a, s.entry.eta)) } else { Vec3::splat(4.0 * std::f32::consts::PI) };
        let mut extinction = steps / s.radius.max(Vec3::splat(1e-6)) / (1.0 - g);
        let mut throughput = Vec3::new(
            if s.albedo.x > 0.0 { s.weight.x / s.albedo.x } else { 0.0 },
            if s.albedo.y > 0.0 { s.weight.y / s.albedo.y } else { 0.0 },
            if s.albedo.z > 0.0 { s.weight.z / s.albedo.z } else { 0.0 },
        );
        let frame = Frame::about(s.normal);
        let v = frame.to_local(surface.v);
        if v.z <= 0.0 {
            return false;
        }
        let Some(l) = entry_direction(&s.entry, v, &mut rng) else { return false };
        let mut dir = frame.to_world(l).as_dvec3();
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
            if step + 1 == ANISOTROPIC_STEPS && g != 0.0 {
                (extinction, albedo) = similar(extinction, albedo, g);
                g = 0.0;
            }
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
    use super::super::tests::{compiled, covered, lamp, scene};
    use super::super::{PathPlan, PathTracer};
    use super::*;
    use crate::math::Transform;
    use crate::scene::Shape;
    use crate::scene::lamp::LampShape;
    use crate::scene::shader::{Closure, SubsurfaceMethod};

    const MEASURED: &str = include_str!("../../../tests/measured/cycles_subsurface.txt");

    /// What a slab reflects of a sun along the normal, or lets through to the other side, over `n` samples.
    fn walked(through: bool, albedo: f32, anisotropy: f32, depth: f64, n: u32) -> f32 {
        let closure = Closure::Subsurface {
            method: SubsurfaceMethod::RandomWalk,
            color: albedo.into(),
            radius: 1.0.into(),
            scale: 1.0.into(),
            ior: 1.01.into(),
            anisotropy: anisotropy.into(),
            roughness: 0.0.into(),
            normal: None,
        };
        let slab = Shape::Box { min: DVec3::new(-400.0, -400.0, -depth), max: DVec3::new(400.0, 400.0, 0.0) };
        let sun = LampShape::Sun { angle_rad: 0.0 };
        let turn = if through { Transform::rotation_deg(DVec3::new(180.0, 0.0, 0.0)) } else { Transform::default() };
        let c = compiled(&scene(vec![covered(slab, closure)], vec![lamp(sun, std::f32::consts::PI, turn)], Vec3::ZERO));
        let plan = PathPlan::new(&c, 1, 1, 7, false);
        PathTracer::new(&plan).pixel(0, 0, 0..n).color[0]
    }

    #[test]
    fn walks_of_every_mean_cosine_are_those_of_cycles() {
        const N: u32 = 1 << 14;
        let (mut wrong, mut sum_sq, mut count) = (Vec::new(), 0.0, 0.0);
        for line in MEASURED.lines().filter(|l| !l.starts_with('#')) {
            let words: Vec<&str> = line.split(' ').collect();
            let [albedo, g, depth, value, error] = std::array::from_fn(|k| words[k + 1].parse::<f32>().expect("a number"));
            // All slabs, and of half spaces those of three mean cosines.
            if depth > 1.0 && ![0.15, 0.6, 0.9].contains(&g) {
                continue;
            }
            let got = walked(words[0] == "through", albedo, g, f64::from(depth), N);
            let own = (value * (1.0 - value) / N as f32).sqrt();
            // 0.006: the largest error of the fit.
            if (got - value).abs() > 4.0 * own.hypot(error) + 6e-3 {
                wrong.push(format!("{line}: {got}"));
            }
            sum_sq += (got - value) * (got - value);
            count += 1.0;
        }
        assert!(wrong.is_empty(), "{} differ:\n{}", wrong.len(), wrong.join("\n"));
        let rms = (sum_sq / count).sqrt();
        assert!(count > 60.0 && rms < 4.5e-3, "rms {rms} of {count} values");
    }

    #[test]
    fn the_shader_has_the_same_coefficients() {
        let shader = include_str!("../../../shaders/path/walk.wesl");
        let numbers = |text: &str| -> Vec<f32> { text.split([',', ' ', '(', ')']).filter_map(|w| w.trim().parse().ok()).collect() };
        let rows: Vec<Vec<f32>> =
            shader.lines().filter(|l| l.trim().starts_with("vec4f(-") || l.trim().starts_with("vec4f(0.")).map(numbers).collect();
        let last = shader.lines().find(|l| l.contains("var last = array<f32, 9>")).map(numbers).expect("a row of 9");
        assert_eq!(rows.len(), 9);
        for (j, row) in rows.iter().enumerate() {
            assert_eq!(row[..], [0, 1, 2, 3].map(|i| ANISOTROPY[i][j]), "column {j}");
        }
        assert_eq!(last[last.len() - 9..], ANISOTROPY[4]);
    }

    #[test]
    fn a_half_space_has_the_albedo_that_was_asked_for() {
        let mut rng = Pcg::new(1);
        // Cycles' is 1.011 times that.
        for want in [0.2, 0.5, 0.8, 0.9] {
            let a = single_scattering(want, 0.0);
            let n = 100_000;
            let mut sum = 0.0;
            for _ in 0..n {
                // Depth below the surface, cosine of the way down, weight.
                let (mut z, mut cos, mut w) = (0.0f32, rng.draw().sqrt(), 1.0f32);
                for _ in 0..=MAX_STEPS {
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
            assert!((got - 1.011 * want).abs() < 5e-3, "{got}, not {want}");
        }
    }
}
