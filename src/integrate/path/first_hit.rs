//! Values of passes at what the camera sees: distance for mist, openness, motion.

use super::closure::Shading;
use super::plan::PathPlan;
use super::shadow::ShadowRay;
use super::surface::Surface;
use super::trace::{Path, shadow_start};
use crate::kernel::bsdf::frame::Frame;
use crate::math::{DVec3, Vec3};

impl PathPlan<'_> {
    /// Mist at a point, 0 none, 1 all. Source: which distance and curve, Cycles (measured).
    pub(super) fn mist(&self, point: DVec3, time: f64) -> f32 {
        let m = &self.settings.mist;
        let share = ((self.camera.distance(point, time) - f64::from(m.start)) / f64::from(m.depth).max(1e-12)).clamp(0.0, 1.0);
        share.powf(f64::from(m.exponent)) as f32
    }

    /// Motion in pixels, y up: from the frame before to this one, from this one to the next, both with the sign that points to the earlier.
    /// Source: Blender's vector pass (measured). Nothing moves without keys for the three frames (`PathSettings::still`).
    pub(super) fn motion_vector(&self, surface: &Surface, time: f64) -> [f32; 4] {
        if !self.settings.still {
            return [0.0; 4];
        }
        let at = |t: f64| self.camera.project(surface.point_at(t), t);
        let (Some(a), Some(b), Some(c)) = (at(0.0), at(time), at(1.0)) else { return [0.0; 4] };
        [a.x - b.x, a.y - b.y, b.x - c.x, b.y - c.y].map(|v| v as f32)
    }

    /// Whether the way from a surface in a direction about its normal is open as far as ambient occlusion looks; what lets light through counts by its share.
    pub(super) fn openness(&self, path: &Path, surface: &Surface, shading: &Shading, last: &mut u32) -> f32 {
        let [_, u, v, _] = path.sampler.time();
        let (x, y) = crate::kernel::bsdf::frame::disc(u, v);
        let z = (1.0 - x * x - y * y).max(0.0).sqrt();
        let dir = Frame::about(shading.mean_normal(surface)).to_world(Vec3::new(x, y, z)).as_dvec3().normalize();
        if dir.dot(surface.flat) <= 0.0 {
            return 0.0;
        }
        let to_sky = ShadowRay {
            from: shadow_start(surface, dir),
            dir,
            distance: f64::from(self.settings.occlusion_distance),
            time: path.time,
            volumes: &Default::default(),
            passed: path.bounces.transparent,
            stream: 0,
            part: path.part,
        };
        super::catcher::mean(self.transmittance(&to_sky, last))
    }
}
