//! Camera rays of the path integrator: any projection of the kernel's camera, a thin lens with blades, and a camera that moves.

use crate::compile::CompiledScene;
use crate::kernel::camera::CameraModel;
use crate::math::{DMat3, DVec2, DVec3, Ray, Vec3};
use crate::scene::camera::{CameraPose, Lens};
use crate::scene::{Camera, Projection};
use std::f64::consts::TAU;

/// A camera made ready for one picture size.
pub struct PathCamera {
    model: CameraModel,
    camera: Camera,
    size: (f64, f64),
    lens: Option<Lens>,
}

impl PathCamera {
    /// The scene's camera.
    pub fn new(scene: &CompiledScene, width: u32, height: u32) -> Self {
        let mut camera = scene.camera.clone();
        let lens = camera.lens.or_else(|| {
            // POV-Ray's blur: a lens of diameter `aperture` about the location.
            let blur = camera.blur.as_ref().filter(|b| b.aperture != 0.0)?;
            Some(Lens { radius: 0.5 * blur.aperture.abs(), focus_distance: blur.focal_distance, blades: 0, rotation_rad: 0.0, ratio: 1.0 })
        });
        camera.blur = None;
        Self { model: CameraModel::new(scene, width, height), size: (f64::from(width), f64::from(height)), lens, camera }
    }

    /// The lens, if the camera has one.
    pub fn lens(&self) -> Option<&Lens> {
        self.lens.as_ref()
    }

    /// The ray through picture position (x, y) (integers are pixel centres, y runs down) at `time` of the shutter, through the point of the
    /// lens that `u` picks. `None` where the projection shows nothing.
    pub fn ray(&self, x: f64, y: f64, u: [f32; 2], time: f64) -> Option<Ray> {
        let pose = self.pose(time);
        let (a, b) = ((x + 0.5) / self.size.0 - 0.5, 0.5 - (y + 0.5) / self.size.1);
        let (origin, dir) = match self.camera.projection {
            Projection::Perspective => (pose.location, pose.direction + a * pose.right + b * pose.up),
            Projection::Orthographic => (pose.location + a * pose.right + b * pose.up, pose.direction),
            _ => return self.model.ray(x, y).map(|(ray, _)| ray),
        };
        let Some(lens) = &self.lens else { return Some(Ray::new(origin, dir.try_normalize()?)) };
        let axis = pose.right.cross(pose.up).try_normalize()?;
        let axis = if axis.dot(pose.direction) < 0.0 { -axis } else { axis };
        let focus = origin + dir * (lens.focus_distance / dir.dot(axis));
        let (lx, ly) = lens_point(lens, u);
        let from = origin + lens.radius * (lx * pose.right.normalize() + ly * pose.up.normalize());
        Some(Ray::new(from, (focus - from).try_normalize()?))
    }

    /// Depth of a point: along the axis where there is a picture plane, else its distance.
    pub fn depth(&self, point: DVec3, time: f64) -> f64 {
        let pose = self.pose(time.max(0.0));
        let to = point - pose.location;
        let axis = pose.right.cross(pose.up).try_normalize();
        match (&self.camera.projection, axis) {
            (Projection::Perspective | Projection::Orthographic, Some(axis)) => to.dot(axis).abs(),
            _ => to.length(),
        }
    }

    /// Distance of a point from the camera; along its axis where its rays are parallel.
    pub fn distance(&self, point: DVec3, time: f64) -> f64 {
        match self.camera.projection {
            Projection::Orthographic => self.depth(point, time),
            _ => (point - self.pose(time.max(0.0)).location).length(),
        }
    }

    /// Where a point is in the picture, in pixels from the lower left, y up; `None` behind the camera and where there is no picture plane.
    pub fn project(&self, point: DVec3, time: f64) -> Option<DVec2> {
        let pose = self.pose(time.max(0.0));
        let axes = DMat3::from_cols(pose.direction, pose.right, pose.up);
        if axes.determinant() == 0.0 {
            return None;
        }
        let [along, x, y] = (axes.inverse() * (point - pose.location)).to_array();
        let (a, b) = match self.camera.projection {
            Projection::Perspective if along > 0.0 => (x / along, y / along),
            Projection::Orthographic => (x, y),
            _ => return None,
        };
        Some(DVec2::new((a + 0.5) * self.size.0, (b + 0.5) * self.size.1))
    }

    /// A direction in the camera's axes: x right, y up, z into the picture.
    pub fn to_view(&self, dir: Vec3, time: f64) -> Vec3 {
        let pose = self.pose(time.max(0.0));
        let right = pose.right.normalize_or(DVec3::X);
        let up = (pose.up - right * right.dot(pose.up)).normalize_or(DVec3::Y);
        let axis = right.cross(up);
        let axis = if axis.dot(pose.direction) < 0.0 { -axis } else { axis };
        let d = dir.as_dvec3();
        Vec3::new(d.dot(right) as f32, d.dot(up) as f32, d.dot(axis) as f32)
    }

    fn pose(&self, time: f64) -> CameraPose {
        let c = &self.camera;
        if c.motion.len() < 2 {
            return CameraPose { location: c.location, direction: c.direction, right: c.right, up: c.up };
        }
        let x = time.clamp(0.0, 1.0) * (c.motion.len() - 1) as f64;
        let i = (x as usize).min(c.motion.len() - 2);
        let (p, q, f) = (&c.motion[i], &c.motion[i + 1], x - i as f64);
        // Turned vectors keep their lengths.
        let turned = |a: DVec3, b: DVec3| a.lerp(b, f).normalize_or_zero() * (a.length() * (1.0 - f) + b.length() * f);
        CameraPose {
            location: p.location.lerp(q.location, f),
            direction: turned(p.direction, q.direction),
            right: turned(p.right, q.right),
            up: turned(p.up, q.up),
        }
    }
}

/// A point of the unit lens: a disc, or a regular polygon with blades.
fn lens_point(lens: &Lens, [u, v]: [f32; 2]) -> (f64, f64) {
    let (x, y) = if lens.blades < 3 {
        let (x, y) = crate::kernel::bsdf::frame::disc(u, v);
        (f64::from(x), f64::from(y))
    } else {
        // One of the triangles around the middle, then a point of it. Source: Turk 1990.
        let n = f64::from(lens.blades);
        let scaled = f64::from(u) * n;
        let (corner, u, v) = (scaled.floor(), scaled.fract().sqrt(), f64::from(v));
        let (p, q) = ((1.0 - v) * u, v * u);
        let half = std::f64::consts::PI / n;
        let (along, across) = ((p + q) * half.cos(), (p - q) * half.sin());
        let turn = corner * TAU / n + lens.rotation_rad;
        (along * turn.cos() - across * turn.sin(), along * turn.sin() + across * turn.cos())
    };
    (x / lens.ratio.max(1e-6), y)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lens_points_fill_the_polygon_evenly() {
        let lens = Lens { radius: 1.0, focus_distance: 1.0, blades: 6, rotation_rad: 0.3, ratio: 1.0 };
        let (mut n, mut sum, mut within) = (0, 0.0, 0);
        for k in 0..10_000 {
            let [u, v, ..] = crate::math::sobol::sobol4(1, k, 0);
            let (x, y) = lens_point(&lens, [u, v]);
            let r = x.hypot(y);
            assert!(r <= 1.0 + 1e-9);
            n += 1;
            sum += x + y;
            within += i32::from(r < 0.5);
        }
        // Area of the hexagon: 3 sqrt(3) / 2.
        let want = std::f64::consts::PI * 0.25 / (1.5 * 3f64.sqrt());
        assert!((f64::from(within) / f64::from(n) - want).abs() < 0.01 && sum.abs() < 100.0);
    }
}
