//! What a ray to a light keeps on its way.

use super::catcher::Part;
use super::closure::transparency;
use super::plan::PathPlan;
use super::surface::Surface;
use super::volume::VolumeStack;
use crate::compile::geometry::prim_flags;
use crate::kernel::traverse::ShadowHit;
use crate::math::{DVec3, Ray, Rgb, Vec3};
use crate::scene::shader::RaySort;

/// Rays do not see what is nearer than this to where they start. Meshes are tested in double precision on exact vertices.
pub const NEAR: f64 = 1e-6;

/// A ray to a light.
pub(super) struct ShadowRay<'a> {
    pub from: DVec3,
    /// Unit.
    pub dir: DVec3,
    /// To the light; may be infinite.
    pub distance: f64,
    /// In the shutter, 0..1.
    pub time: f64,
    /// Around `from`.
    pub volumes: &'a VolumeStack,
    /// Transparent surfaces that the path has gone through so far: they count towards the same limit. Source: Cycles (suite
    /// `path/transport/transparent_limit`).
    pub passed: u32,
    /// Of random numbers for volumes.
    pub stream: u32,
    /// Whose light it asks for.
    pub part: Part,
}

impl PathPlan<'_> {
    /// What a ray to a light meets first of the catchers.
    fn among_catchers(&self, ray: &Ray, time: f64, left: f64) -> ShadowHit {
        let skip = prim_flags::NO_CATCHER | prim_flags::NO_SHADOW;
        self.intersect(ray, time, NEAR, left, skip).map_or(ShadowHit::None, ShadowHit::Transparent)
    }

    /// Share of light that comes through. `last` remembers what blocked a ray before.
    pub(super) fn transmittance(&self, to_light: &ShadowRay, last: &mut u32) -> Rgb {
        let &ShadowRay { from, dir, distance, time, volumes, passed, stream, part } = to_light;
        let mut throughput = Vec3::ONE;
        let mut volumes = *volumes;
        let mut ray = Ray::new(from, dir);
        // The light's own surface does not block it.
        let mut left = if distance.is_finite() { distance * (1.0 - 1e-7) - NEAR } else { f64::MAX };
        for passed in passed..=self.settings.transparent_bounces {
            if left <= NEAR {
                return throughput;
            }
            let met = match part {
                Part::Alone => self.among_catchers(&ray, time, left),
                _ => self.intersect_shadow(&ray, time, NEAR, left, *last),
            };
            match met {
                ShadowHit::None => {
                    if self.has_volumes {
                        throughput *= self.volume_transmittance(&volumes, &ray, left.min(distance), stream ^ passed);
                    }
                    return throughput;
                }
                ShadowHit::Opaque { prim_ix } => {
                    *last = prim_ix;
                    return Vec3::ZERO;
                }
                ShadowHit::Transparent(hit) => {
                    let surface = Surface::new(self.scene, hit, dir, time).seen_by(RaySort::Shadow);
                    let (shader, plain) = self.material(&surface);
                    let through = match shader {
                        Some(s) if !s.transparent_shadow && s.surface.is_some() => Vec3::ZERO,
                        Some(s) => transparency(s.surface.as_ref(), &surface),
                        None => self.pov_transparency(&surface, plain),
                    };
                    throughput *= through;
                    if throughput.max_element() <= 0.0 {
                        return Vec3::ZERO;
                    }
                    if self.has_volumes {
                        throughput *= self.volume_transmittance(&volumes, &ray, hit.t, stream ^ passed);
                        volumes.cross(self, &surface, shader);
                    }
                    left -= hit.t;
                    ray.origin = hit.point;
                }
            }
        }
        Vec3::ZERO
    }
}
