//! All lights of a scene: drawing one for a point, its density, and lights met by chance.
//!
//! Lamps and shining triangles stand in a tree; suns, POV-Ray's lights and the environment beside it. Each share is drawn in proportion to
//! about the light that it gives at the point.

pub mod emitter;
pub mod environment;
pub mod lamp;
pub mod rectangle;
pub mod sky;
#[cfg(test)]
mod tests;
pub mod tree;
pub mod triangle;

use crate::compile::merged::MergedMeshes;
use crate::compile::{CompiledLight, CompiledScene};
use crate::kernel::SurfaceHit;
use crate::kernel::light::{area_axes, area_offset, attenuation, light_ray};
use crate::math::{Bounds, DVec3, Ray, Rgb, Vec3};
use crate::scene::light::{Fade, LightKind};
use crate::scene::{Shader, Visibility};
use emitter::Emitters;
use environment::ReadyEnvironment;
use lamp::{ReadyLamp, cone_sample};
use std::f64::consts::PI;
use std::sync::Arc;
use tree::{LightTree, TreeLight};

/// Where a light sample comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LightSource {
    /// What lies behind all.
    Environment,
    /// One of the lamps.
    Lamp(u32),
    /// One of the emitters.
    Triangle(u32),
    /// A light in POV-Ray's manner.
    Plain(u32),
    /// The sun of a sky.
    SkySun,
}

/// A direction in which light comes.
#[derive(Clone, Copy, Debug)]
pub struct LightSample {
    /// Unit, to the light.
    pub dir: DVec3,
    /// How far.
    pub distance: f64,
    /// Radiance; times 1 / density for lights without a size.
    pub radiance: Rgb,
    /// Per solid angle, choice of the light included.
    pub pdf: f32,
    /// No ray meets it by chance.
    pub is_delta: bool,
    /// Which light.
    pub source: LightSource,
    /// Things between block it.
    pub cast_shadow: bool,
    /// Ray kinds that it lights.
    pub visibility: Visibility,
}

impl LightSample {
    /// Nothing.
    pub const NONE: Self = Self {
        dir: DVec3::Z,
        distance: 0.0,
        radiance: Vec3::ZERO,
        pdf: 0.0,
        is_delta: false,
        source: LightSource::Environment,
        cast_shadow: true,
        visibility: Visibility::ALL,
    };
}

/// A light drawn for a place, with its chance.
#[derive(Clone, Copy, Debug)]
pub struct Chosen {
    /// Which.
    pub source: LightSource,
    /// How likely that was.
    pub chance: f32,
}

/// The sun's disc of a sky.
pub struct SkySun {
    /// In world space.
    pub disc: sky::Disc,
    /// Of half the disc's angle.
    pub cos_half: f64,
}

/// Lights of a scene.
pub struct LightSet {
    /// All lamps.
    pub lamps: Vec<ReadyLamp>,
    /// Lamps at infinity, into `lamps`.
    pub suns: Vec<u32>,
    /// Lamps and triangles of the tree: `tree_lamps[k]` for the first of them, then triangles.
    pub tree_lamps: Vec<u32>,
    /// Place in the tree of a lamp.
    pub tree_of_lamp: Vec<u32>,
    /// Shining triangles.
    pub emitters: Emitters,
    /// Over lamps and triangles.
    pub tree: LightTree,
    /// Into `CompiledScene::lights`.
    pub plain: Vec<u32>,
    /// What lies behind all.
    pub environment: ReadyEnvironment,
    /// Of a sky with a disc.
    pub sky_sun: Option<SkySun>,
    /// There is nothing to draw beside the tree, so nothing has to be weighed against it.
    only_tree: bool,
}

/// Chances of the kinds of lights at a point.
struct Shares {
    tree: f64,
    environment: f64,
    sky_sun: f64,
    /// Sum of all.
    total: f64,
}

/// Brightness of a light, as far as drawing it goes.
pub fn grey(c: Rgb) -> f64 {
    f64::from(c.max(Vec3::ZERO).element_sum() / 3.0)
}

impl LightSet {
    /// Of a scene, of whose meshes some stand in one tree.
    pub fn new(scene: &CompiledScene, shaders: &[Arc<Shader>], merged: Option<&MergedMeshes>) -> Self {
        let (mut lamps, mut plain) = (Vec::new(), Vec::new());
        for (k, CompiledLight { light, .. }) in scene.lights.iter().enumerate() {
            match &light.lamp {
                Some(lamp) => lamps.extend(ReadyLamp::new(lamp)),
                None if light.color.max_element() > 0.0 => plain.push(k as u32),
                None => {}
            }
        }
        let environment = ReadyEnvironment::new(scene);
        let (emitters, triangle_lights) = Emitters::new(scene, shaders, merged);
        let mut lights: Vec<TreeLight> = Vec::new();
        let (mut suns, mut tree_lamps, mut tree_of_lamp) = (Vec::new(), Vec::new(), vec![u32::MAX; lamps.len()]);
        for (k, lamp) in lamps.iter().enumerate() {
            if lamp.is_distant() {
                suns.push(k as u32);
                continue;
            }
            let cone = lamp.cone_cos();
            let is_area = matches!(lamp.lamp.shape, crate::scene::lamp::LampShape::Area { .. });
            tree_of_lamp[k] = lights.len() as u32;
            tree_lamps.push(k as u32);
            lights.push(TreeLight {
                bounds: Bounds { min: lamp.center - lamp.extent(), max: lamp.center + lamp.extent() },
                axis: lamp.axis,
                spread_rad: if is_area { 0.0 } else { cone.acos() },
                reach_rad: if is_area { cone.acos() } else { 0.5 * PI },
                energy: grey(lamp.intensity()),
            });
        }
        lights.extend(triangle_lights);
        let sky_sun = environment.sun().map(|disc| SkySun { cos_half: disc.half.cos(), disc });
        let tree = LightTree::new(&lights);
        let only_tree = !tree.is_empty() && suns.is_empty() && plain.is_empty() && environment.estimate() == 0.0 && sky_sun.is_none();
        Self { lamps, suns, tree_lamps, tree_of_lamp, emitters, tree, plain, environment, sky_sun, only_tree }
    }

    /// Whether there is nothing to draw from.
    pub fn is_empty(&self) -> bool {
        self.tree.is_empty() && self.suns.is_empty() && self.plain.is_empty() && !self.environment.is_sampled() && self.sky_sun.is_none()
    }

    fn sun_share(&self, lamp: &ReadyLamp, n: Option<DVec3>) -> f64 {
        grey(lamp.intensity()) * n.map_or(1.0, |n| (-lamp.axis).dot(n).max(0.05))
    }

    fn plain_share(&self, scene: &CompiledScene, k: u32, p: DVec3) -> f64 {
        let CompiledLight { light, beam, .. } = &scene.lights[k as usize];
        let way = light_ray(light, p, DVec3::ZERO);
        let fade = attenuation(light, beam, p, &way).max(if light.area.is_some() { 0.01 } else { 0.0 });
        grey(light.color) * fade * plain_scale(light)
    }

    #[inline]
    fn shares(&self, scene: &CompiledScene, p: DVec3, n: Option<DVec3>) -> Shares {
        if self.only_tree {
            return Shares { tree: 1.0, environment: 0.0, sky_sun: 0.0, total: 1.0 };
        }
        let tree = self.tree.estimate(p, n);
        let environment = self.environment.estimate();
        let sky_sun = self.sky_sun.as_ref().map_or(0.0, |s| {
            let solid = 2.0 * PI * (1.0 - s.cos_half);
            grey(s.disc.mean()) * solid * n.map_or(1.0, |n| s.disc.dir.dot(n).max(0.02))
        });
        let mut total = tree + environment + sky_sun;
        total += self.suns.iter().map(|k| self.sun_share(&self.lamps[*k as usize], n)).sum::<f64>();
        total += self.plain.iter().map(|k| self.plain_share(scene, *k, p)).sum::<f64>();
        Shares { tree, environment, sky_sun, total }
    }

    /// Draws a light for `p` with normal `n` (`None` in volumes).
    #[inline]
    pub fn choose(&self, scene: &CompiledScene, p: DVec3, n: Option<DVec3>, pick: f32) -> Option<Chosen> {
        let shares = self.shares(scene, p, n);
        if !(shares.total > 0.0) {
            return None;
        }
        let mut target = f64::from(pick) * shares.total;
        let chosen = |source, chance: f64| Some(Chosen { source, chance: chance as f32 });
        if target < shares.tree {
            let (light, chance) = self.tree.sample(p, n, target / shares.tree)?;
            let n_lamps = self.tree_lamps.len() as u32;
            let source = match light.checked_sub(n_lamps) {
                None => LightSource::Lamp(self.tree_lamps[light as usize]),
                Some(k) => LightSource::Triangle(k),
            };
            return chosen(source, chance * shares.tree / shares.total);
        }
        target -= shares.tree;
        if target < shares.environment {
            return chosen(LightSource::Environment, shares.environment / shares.total);
        }
        target -= shares.environment;
        if target < shares.sky_sun {
            return chosen(LightSource::SkySun, shares.sky_sun / shares.total);
        }
        target -= shares.sky_sun;
        for k in &self.suns {
            let share = self.sun_share(&self.lamps[*k as usize], n);
            if target < share {
                return chosen(LightSource::Lamp(*k), share / shares.total);
            }
            target -= share;
        }
        for k in &self.plain {
            let share = self.plain_share(scene, *k, p);
            if target < share {
                return chosen(LightSource::Plain(*k), share / shares.total);
            }
            target -= share;
        }
        None
    }

    /// A direction of the chosen light as seen from `p`.
    #[inline]
    pub fn sample_chosen(
        &self,
        scene: &CompiledScene,
        shaders: &[Arc<Shader>],
        c: &Chosen,
        p: DVec3,
        time: f64,
        u: [f32; 2],
    ) -> Option<LightSample> {
        let s = match c.source {
            LightSource::Lamp(k) => self.lamp_sample(k, p, u)?,
            LightSource::Triangle(k) => self.emitters.list[k as usize].sample(scene, shaders, p, time, u)?,
            LightSource::Plain(k) => plain_sample(&scene.lights[k as usize], p, u)?,
            LightSource::Environment => {
                let (dir, pdf) = self.environment.sample(u[0], u[1])?;
                LightSample { dir, distance: f64::INFINITY, radiance: self.environment.radiance(scene, dir), pdf, ..LightSample::NONE }
            }
            LightSource::SkySun => {
                let sun = self.sky_sun.as_ref()?;
                let dir = cone_sample(sun.disc.dir, sun.cos_half, u[0], u[1]);
                let pdf = (1.0 / (2.0 * PI * (1.0 - sun.cos_half))) as f32;
                LightSample { dir, distance: f64::INFINITY, radiance: sun.disc.toward(dir), pdf, ..LightSample::NONE }
            }
        };
        let pdf = s.pdf * c.chance;
        (pdf > 0.0).then_some(LightSample { pdf, source: c.source, ..s })
    }

    /// Draws a direction of light for `p` with normal `n` (`None` where light comes from all sides).
    #[inline]
    pub fn sample(
        &self,
        scene: &CompiledScene,
        shaders: &[Arc<Shader>],
        p: DVec3,
        n: Option<DVec3>,
        time: f64,
        u: [f32; 3],
    ) -> Option<LightSample> {
        let chosen = self.choose(scene, p, n, u[2])?;
        self.sample_chosen(scene, shaders, &chosen, p, time, [u[0], u[1]])
    }

    /// Where a light stands; none far away.
    pub fn center(&self, c: &Chosen) -> Option<DVec3> {
        match c.source {
            LightSource::Lamp(k) if !self.lamps[k as usize].is_distant() => Some(self.lamps[k as usize].center),
            LightSource::Triangle(k) => Some(self.emitters.list[k as usize].center()),
            _ => None,
        }
    }

    /// Depth on a segment of length `t` that stands for it when lights are chosen: its point nearest to the middle of all lamps.
    pub fn nearest_on(&self, ray: &Ray, t: f64) -> f64 {
        let Some(center) = self.tree.center() else { return if t.is_finite() { 0.5 * t } else { 0.0 } };
        (center - ray.origin).dot(ray.dir).clamp(0.0, t)
    }

    fn lamp_sample(&self, k: u32, p: DVec3, u: [f32; 2]) -> Option<LightSample> {
        let lamp = &self.lamps[k as usize];
        let s = lamp.sample(p, u)?;
        let never_met = s.is_delta || !lamp.lamp.multiple_importance;
        Some(LightSample { cast_shadow: lamp.lamp.cast_shadow, visibility: lamp.lamp.visibility, is_delta: never_met, ..s })
    }

    /// Deepest bounce that a light is there for.
    pub fn max_bounces(&self, source: LightSource) -> u32 {
        match source {
            LightSource::Lamp(k) => self.lamps[k as usize].lamp.max_bounces,
            _ => u32::MAX,
        }
    }

    /// Density with which the triangle of a hit, at depth `hit.t` from `p`, is drawn from there, where lights are chosen for `select` with
    /// normal `n`; 0 when it is not one that is sampled.
    pub fn triangle_density(
        &self,
        scene: &CompiledScene,
        hit: &SurfaceHit,
        (p, select, n): (DVec3, DVec3, Option<DVec3>),
        dir: DVec3,
        time: f64,
    ) -> f32 {
        let Some(k) = self.emitters.of_hit(hit) else { return 0.0 };
        let shares = self.shares(scene, select, n);
        let chance = self.tree.chance(self.tree_lamps.len() as u32 + k, select, n) * shares.tree / shares.total;
        self.emitters.list[k as usize].density(scene, p, dir, hit.t, time) * chance as f32
    }

    /// Density with which the environment's direction `dir` is drawn.
    pub fn environment_density(&self, scene: &CompiledScene, p: DVec3, n: Option<DVec3>, dir: DVec3) -> f32 {
        if !self.environment.is_sampled() {
            return 0.0;
        }
        let shares = self.shares(scene, p, n);
        self.environment.density(dir) * (shares.environment / shares.total) as f32
    }

    /// Radiance of the sun of a sky along `dir`, and the density with which it is drawn.
    pub fn sky_sun(&self, scene: &CompiledScene, p: DVec3, n: Option<DVec3>, dir: DVec3) -> Option<(Rgb, f32)> {
        let s = self.sky_sun.as_ref().filter(|s| dir.dot(s.disc.dir) >= s.cos_half)?;
        let shares = self.shares(scene, p, n);
        let pdf = shares.sky_sun / shares.total / (2.0 * PI * (1.0 - s.cos_half));
        Some((s.disc.toward(dir), pdf as f32))
    }

    /// Lamps that a ray of kind `kind` meets before `t_max`: calls `f` with radiance, the density with which each is drawn, and its depth.
    pub fn for_lamps_met(
        &self,
        scene: &CompiledScene,
        (p, select, n): (DVec3, DVec3, Option<DVec3>),
        dir: DVec3,
        t_max: f64,
        (kind, bounce): (Visibility, u32),
        mut f: impl FnMut(Rgb, f32, f64),
    ) {
        for (k, lamp) in self.lamps.iter().enumerate() {
            if !lamp.lamp.multiple_importance || !lamp.lamp.visibility.has(kind) || bounce > lamp.lamp.max_bounces {
                continue;
            }
            let Some((t, radiance, pdf)) = lamp.hit(p, dir, t_max) else { continue };
            let shares = self.shares(scene, select, n);
            let chance = match self.tree_of_lamp[k] {
                u32::MAX => self.sun_share(lamp, n) / shares.total,
                at => self.tree.chance(at, select, n) * shares.tree / shares.total,
            };
            f(radiance, pdf * chance as f32, t);
        }
    }
}

/// Irradiance of a plain light of colour 1 where nothing weakens it: POV-Ray's diffuse answer has no 1/π.
fn plain_scale(light: &crate::scene::Light) -> f64 {
    let physical = light.fade == Fade::InverseSquare || matches!(light.kind, LightKind::Sun { .. });
    if physical { 1.0 } else { PI }
}

/// A point of a light in POV-Ray's manner: the whole of an area light's parallelogram shines.
fn plain_sample(l: &CompiledLight, p: DVec3, [u, v]: [f32; 2]) -> Option<LightSample> {
    let CompiledLight { light, beam, .. } = l;
    let mut way = light_ray(light, p, DVec3::ZERO);
    if let Some(a) = &light.area {
        let axes = area_axes(a, way.dir);
        let place = |u: f32, n: u32| if n > 1 { f64::from(u) * f64::from(n - 1) } else { 0.0 };
        let offset = area_offset(a, axes, place(u, a.n1), place(v, a.n2));
        way = light_ray(light, p, offset);
    }
    let factor = attenuation(light, beam, p, &way) * plain_scale(light);
    if !(factor > 0.0) || way.distance <= 0.0 {
        return None;
    }
    Some(LightSample {
        dir: way.dir,
        distance: way.distance,
        radiance: light.color * factor as f32,
        pdf: 1.0,
        is_delta: true,
        cast_shadow: !light.shadowless,
        ..LightSample::NONE
    })
}
