//! Where photons start: every light shoots rings of them at every target. Source: spec/light.md, section 9; the numbers of photons
//! that POV-Ray reports are met exactly.

use crate::compile::geometry::{PhotonTarget, prim_flags};
use crate::compile::{CompiledLight, CompiledScene, NONE};
use crate::kernel::light::{LightRay, beam_share};
use crate::kernel::traverse::{SHADOW_TOLERANCE, intersect_object};
use crate::math::random::UniformStream;
use crate::math::{DVec3, EPSILON, Ray, Rgb};
use crate::scene::light::LightKind;
use std::f64::consts::{PI, TAU};

/// Photons dimmer than this share of their light are not shot.
const DIMMEST: f64 = 1e-5;
/// Most surfaces of a projector.
const MAX_PROJECTOR_HITS: usize = 10_000;

/// A light and what it shoots at.
#[derive(Clone, Copy, Debug)]
pub struct Pair<'a> {
    pub light: &'a CompiledLight,
    pub target: &'a PhotonTarget,
}

/// A photon that leaves its light.
#[derive(Clone, Debug)]
pub struct Shot {
    pub ray: Ray,
    /// Its share of the light's colour.
    pub power: Rgb,
    /// Length of its way before `ray` begins.
    pub path: f64,
}

/// One ring of photons about the way to the target.
#[derive(Clone, Debug, Default)]
pub struct Ring {
    /// Angle from the way to the target's middle; distance for parallel lights.
    pub theta: f64,
    pub shots: Vec<Shot>,
    /// Photons of the ring, those among them that were too dim to be shot.
    pub n_counted: u64,
    /// The random stream after it.
    pub stream: UniformStream,
}

/// Whether photons may be reflected, and refracted, by what has `flags` where the light comes from `light`.
pub fn allows(flags: u32, light: &CompiledLight) -> (bool, bool) {
    let allowed = |on: u32, off: u32, light: Option<bool>| {
        let (on, off) = (flags & on != 0, flags & off != 0);
        !off && light != Some(false) && (on || light == Some(true))
    };
    let (reflection, refraction, _) = light.light.photons;
    (
        allowed(prim_flags::PHOTON_REFLECTION, prim_flags::PHOTON_NO_REFLECTION, reflection),
        allowed(prim_flags::PHOTON_REFRACTION, prim_flags::PHOTON_NO_REFRACTION, refraction),
    )
}

/// Whether photons bring the light that comes through what has `flags`, so that no shadow ray may bring it too.
pub fn take_over(flags: u32, light: &CompiledLight) -> bool {
    flags & prim_flags::PHOTON_TARGET != 0 && light.group_ix == NONE && allows(flags, light).1
}

/// The pairs that shoot photons, in POV-Ray's order.
pub fn pairs(scene: &CompiledScene) -> Vec<Pair<'_>> {
    let lights = scene.lights.iter().filter(|l| l.group_ix == NONE && !l.light.shadowless);
    lights
        .flat_map(|light| scene.geometry.photon_targets.iter().map(move |target| Pair { light, target }))
        .filter(|p| {
            let (reflects, refracts) = allows(p.target.flags, p.light);
            reflects || refracts
        })
        .collect()
}

/// The distance between photons that makes about `count` of them.
pub fn spacing_for(pairs: &[Pair], count: u32) -> f64 {
    let wanted = |p: &Pair| {
        let radius = 0.5 * p.target.bounds.size().length();
        let mut n = PI * (radius / p.target.spacing) * (radius / p.target.spacing);
        let both = allows(p.target.flags, p.light) == (true, true);
        n *= if both { 1.5 } else { 1.0 };
        if p.target.flags & prim_flags::PHOTON_NO_COLLECT == 0 {
            n *= match allows(p.target.flags, p.light) {
                (true, true) => 3.0,
                (false, true) => 2.0,
                _ => 1.0,
            };
        }
        0.5 * n
    };
    (pairs.iter().map(wanted).sum::<f64>() / f64::from(count.max(1))).sqrt()
}

/// How a pair's photons are spread.
#[derive(Clone, Debug)]
pub struct Emission<'a> {
    pub pair: Pair<'a>,
    /// The target's middle.
    middle: DVec3,
    /// From the light to it, or the light's direction when parallel.
    axis: DVec3,
    pub parallel: bool,
    /// Step between rings.
    step: f64,
    /// No ring at or beyond this.
    end: f64,
    /// Distance between photons at distance 1 (any distance for parallel light): its square is what each stands for.
    pub spread: f64,
    jitter: f64,
    /// Points of the area, 1 for one light.
    grid: [u32; 2],
}

impl<'a> Emission<'a> {
    /// Of a pair, for photons `spacing` apart where the target is.
    pub fn new(pair: Pair<'a>, spacing: f64, jitter: f64) -> Self {
        let light = &pair.light.light;
        let (target, bounds) = (pair.target, pair.target.bounds);
        let middle = bounds.center();
        let radius = 0.5 * bounds.size().length();
        let parallel = light.parallel || matches!(light.kind, LightKind::Cylinder { .. } | LightKind::Sun { .. });
        let to = middle - light.location;
        let distance = to.length();
        let axis = if parallel { pair.light.beam.axis } else { to.try_normalize().unwrap_or(DVec3::Z) };
        let grid = light.area.as_ref().filter(|_| light.photons.2).map_or([1, 1], |a| [a.n1, a.n2]);
        let mut spread = spacing * target.spacing * f64::from(grid[0] * grid[1]).sqrt();
        let (step, end) = if parallel {
            (spread, radius)
        } else {
            spread /= distance;
            (spread.atan(), if distance > radius { (radius / distance).asin() } else { PI })
        };
        Self { pair, middle, axis, parallel, step, end, spread, jitter, grid }
    }

    /// Whether there is a distance between photons at all.
    pub fn is_sound(&self) -> bool {
        self.step > 0.0 && self.end > 0.0 && self.spread.is_finite()
    }

    /// Whether photons start all over an area.
    pub fn has_grid(&self) -> bool {
        self.parallel || self.grid != [1, 1]
    }

    /// About how many photons there will be, all rings counted.
    pub fn expected(&self) -> f64 {
        let n = if self.parallel { PI * (self.end / self.step).powi(2) } else { TAU * (1.0 - self.end.cos()) / (self.step * self.step) };
        (n + 1.0) * f64::from(self.grid[0] * self.grid[1])
    }

    /// Angle (distance for parallel light) of ring `k`, unless it lies beyond the target.
    pub fn theta(&self, k: u64) -> Option<f64> {
        Some(k as f64 * self.step).filter(|t| *t < self.end)
    }

    /// Whether a ring without hits at `theta` ends the pair, after one with hits.
    pub fn may_stop(&self, theta: f64, autostop: f64) -> bool {
        theta > autostop * self.end
    }

    /// The photons of the ring at `theta`, drawn from `stream`.
    pub fn ring(&self, scene: &CompiledScene, theta: f64, mut stream: UniformStream) -> Ring {
        let mut out = Ring { theta, ..Ring::default() };
        let about = if theta < EPSILON {
            TAU
        } else if self.parallel {
            self.step / theta
        } else {
            self.step / theta.sin()
        };
        let shift = 0.5 * about * stream.draw();
        let (mut phi, last) = (shift - PI, PI - 0.5 * about + shift);
        while phi < last {
            let p = phi + about * (stream.draw() - 0.5) * self.jitter;
            let t = theta + self.step * (stream.draw() - 0.5) * self.jitter;
            for u in 0..self.grid[0] {
                for v in 0..self.grid[1] {
                    out.n_counted += 1;
                    out.shots.extend(self.shot(scene, p, t, [u, v]));
                }
            }
            phi += about;
        }
        out.stream = stream;
        out
    }

    /// The photon at angles `phi` and `theta` about the way to the target, if there is light there.
    fn shot(&self, scene: &CompiledScene, phi: f64, theta: f64, [u, v]: [u32; 2]) -> Option<Shot> {
        let light = &self.pair.light.light;
        // Neither jittered, nor round, nor turned (measured).
        let place = |k: u32, n: u32| if n > 1 { f64::from(k) / f64::from(n - 1) - 0.5 } else { 0.0 };
        let offset = match &light.area {
            Some(a) if light.photons.2 => place(u, a.n1) * a.axis1 + place(v, a.n2) * a.axis2,
            _ => DVec3::ZERO,
        };
        let from = light.location + offset;
        let to = self.middle - from;
        // Every point of an area aims at the target for itself.
        let axis = if self.parallel { self.axis } else { to.try_normalize().unwrap_or(self.axis) };
        let up = if (axis.z.abs() - 1.0).abs() < 0.1 { DVec3::Y } else { DVec3::Z };
        // From the axis towards `left`, then about the axis; parallel light begins on the other side (measured).
        let left = if self.parallel { axis.cross(up) } else { up.cross(axis) }.normalize();
        let aside = phi.cos() * left + phi.sin() * axis.cross(left);
        let (origin, dir) = if self.parallel {
            // A disc through the projection of the target's middle on the light's plane.
            (from + to - to.dot(axis) * axis + theta * aside, axis)
        } else {
            (from, (theta.cos() * axis + theta.sin() * aside).normalize())
        };
        // As the target's side sees it, at distance 1; fading follows with the photon's whole way.
        let point = origin + dir;
        let way = LightRay { dir: -dir, distance: 1.0 };
        let n_points = f64::from(self.grid[0] * self.grid[1]);
        let share = beam_share(light, &self.pair.light.beam, point - offset, &way) / n_points;
        if share < DIMMEST {
            return None;
        }
        let mut ray = Ray::new(origin, dir);
        let mut path = 0.0;
        if self.pair.light.projected_through != NONE {
            // Photons begin behind the last surface of what they must pass.
            let projector = self.pair.light.projected_through;
            for _ in 0..MAX_PROJECTOR_HITS {
                let Some(hit) = intersect_object(scene, projector, &ray, SHADOW_TOLERANCE, f64::INFINITY) else { break };
                path += hit.t;
                ray.origin = hit.point;
            }
            if path == 0.0 {
                return None;
            }
        }
        Some(Shot { ray, power: light.color * share as f32, path })
    }
}
