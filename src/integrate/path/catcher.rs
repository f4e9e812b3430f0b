//! Shadow catchers and holes in the film: what a camera's path does where it first meets one.
//!
//! At a shadow catcher the path is followed twice: in the whole scene, and among the catchers alone. What the two bring, side by side in the film, tells
//! how much light the other objects take away or add (`film::catcher`). Both draw the same numbers, so that a catcher that nothing
//! shades is 1 without noise. Source: which sums those are, Cycles (measured).

use super::closure::Shading;
use super::lights::LightSource;
use super::plan::PathPlan;
use super::surface::Surface;
use super::trace::{Path, PathTracer};
use crate::compile::CompiledScene;
use crate::compile::geometry::prim_flags;
use crate::kernel::SurfaceHit;
use crate::kernel::bsdf::LobeSet;
use crate::math::{Rgb, Vec3};
use crate::scene::shader::Closure;
use crate::scene::{Pass, Shader};

/// Which part of a path it is, for catchers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    /// It has met no catcher.
    Before,
    /// After it met one, in the whole scene.
    After,
    /// After it met one, among catchers alone.
    Alone,
}

impl Part {
    /// Primitives that it does not see.
    pub fn skip_flags(self) -> u32 {
        if self == Self::Alone { prim_flags::NO_CATCHER } else { 0 }
    }
}

/// Whether pictures of the scene have holes: holdouts or shadow catchers.
pub fn makes_holes(scene: &CompiledScene) -> bool {
    let of_objects = scene.geometry.objects.iter().any(|o| o.traits.holdout || o.traits.shadow_catcher);
    of_objects || scene.textures.principled.iter().any(|p| p.shader.as_ref().is_some_and(|s| has_holdout(s)))
}

/// Whether the scene has shadow catchers.
pub fn has_catchers(scene: &CompiledScene) -> bool {
    scene.geometry.objects.iter().any(|o| o.traits.shadow_catcher)
}

fn has_holdout(shader: &Shader) -> bool {
    fn within(c: &Closure) -> bool {
        match c {
            Closure::Holdout => true,
            Closure::Mix { a, b, .. } | Closure::Add(a, b) => within(a) || within(b),
            _ => false,
        }
    }
    shader.surface.as_ref().is_some_and(within)
}

impl PathPlan<'_> {
    fn is_catcher(&self, surface: &Surface) -> bool {
        surface.prim.flags & prim_flags::NO_CATCHER == 0
    }

    /// Whether a light shines on what a part of a path sees.
    pub(super) fn shines_on(&self, source: LightSource, part: Part) -> bool {
        match source {
            LightSource::Triangle(k) if part == Part::Alone => {
                self.scene.geometry.prims[self.lights.emitters.list[k as usize].prim_ix as usize].flags & prim_flags::NO_CATCHER == 0
            }
            _ => true,
        }
    }
}

impl PathTracer<'_> {
    /// Where a camera's path meets its first catcher: follows it among the catchers alone, and marks it.
    pub(super) fn split_at_catcher(&mut self, path: &mut Path, surface: &Surface, hit: SurfaceHit, survival: f32) {
        let plan = self.plan;
        if !plan.has_catchers || path.part != Part::Before || path.bounces.total > 0 || !plan.is_catcher(surface) {
            return;
        }
        let Some(g) = &mut self.gather else { return };
        let env = &plan.lights.environment;
        let behind = if env.sees(path.bounces.kind.visibility()) { env.radiance(plan.scene, path.ray.dir) } else { Vec3::ZERO };
        let mean = path.throughput.element_sum() / 3.0;
        g.catcher_met(mean, path.throughput * behind * plan.settings.exposure);
        let mut alone = path.clone();
        alone.part = Part::Alone;
        path.part = Part::After;
        if self.meet_surface(&mut alone, hit, survival) {
            alone.step += 1;
            self.trace(&mut alone);
        }
    }
}

impl PathTracer<'_> {
    /// Holdouts: what the camera sees of them is a hole in the film; other rays see the object, or the black of the closure.
    pub(super) fn make_hole(&mut self, path: &mut Path, surface: &Surface, shading: &mut Shading) {
        let object = self.plan.scene.geometry.objects.get(surface.prim.object_ix as usize);
        let hole = if object.is_some_and(|o| o.traits.holdout) {
            shading.lobes = LobeSet::new(shading.lobes.normal, shading.lobes.flat);
            (shading.emission, shading.subsurface) = (Vec3::ZERO, None);
            (1.0 - mean(shading.transparent)).clamp(0.0, 1.0)
        } else {
            shading.holdout
        };
        if hole > 0.0 && path.part != Part::Alone {
            let share = mean(path.throughput) * hole;
            path.transmit += share;
            if let Some(g) = &mut self.gather {
                g.left_open(share, path.part);
            }
        }
    }

    /// Passes at what the camera sees.
    pub(super) fn first_hit(&mut self, path: &Path, surface: &Surface, shading: &Shading, shader: Option<&Shader>) {
        let plan = self.plan;
        let Some(g) = self.gather.as_mut().filter(|_| path.part != Part::Alone) else { return };
        let openness = if g.wants(Pass::AmbientOcclusion) { plan.openness(path, surface, shading, &mut self.blocker) } else { 0.0 };
        g.surface(plan, path, surface, shading, shader, openness);
    }
}

/// Share of a colour's channels together.
pub(super) fn mean(c: Rgb) -> f32 {
    c.element_sum() / 3.0
}
