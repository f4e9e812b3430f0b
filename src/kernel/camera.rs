//! Camera rays: picture positions to origins and directions, for every projection but the mesh camera (`mesh_camera.rs`).
//! The lens of focal blur stands in `lens.rs`. Source: spec/textures.md, section 8; spec/light.md, section 12.
//!
//! Positions (x, y) are pixels with integers at pixel centres, y downwards. Twin: `shaders/shared/camera.wesl`.

use super::function::free_point;
use super::lens::Lens;
use super::mesh_camera::MeshCamera;
use super::panorama;
use super::pigment::eval_pigment;
use crate::compile::CompiledScene;
use crate::math::color::grey;
use crate::math::{Bounds, DVec2, DVec3, Ray};
use crate::scene::Projection;
use std::f64::consts::PI;

/// A camera made ready for one picture size.
pub struct CameraModel {
    projection: Projection,
    location: DVec3,
    direction: DVec3,
    right: DVec3,
    up: DVec3,
    /// Unit vectors of the three.
    unit: [DVec3; 3],
    /// |right|, |up|.
    size: DVec2,
    /// Columns and rows of the whole picture.
    resolution: DVec2,
    /// Focal blur, if any.
    pub lens: Option<Lens>,
    /// Rays start on meshes, if they do.
    pub mesh: Option<MeshCamera>,
    /// Perturbation of directions, into `TextureTables::normals`.
    pub normal_ix: Option<u32>,
}

/// What a projection gives: a ray before normalisation, and the point at which the camera's normal is looked up.
struct Projected {
    origin: DVec3,
    dir: DVec3,
    normal_point: DVec3,
}

impl CameraModel {
    /// The scene's camera for a picture of `width` x `height` pixels.
    pub fn new(scene: &CompiledScene, width: u32, height: u32) -> Self {
        let c = &scene.camera;
        let unit = |v: DVec3| v.try_normalize().unwrap_or(DVec3::Z);
        let mesh = match &c.projection {
            Projection::Mesh { n_rays, distribution, max_distance, meshes, smooth } => {
                Some(MeshCamera::new(*n_rays, *distribution, *max_distance, meshes, *smooth, c.location, c.direction))
            }
            _ => None,
        };
        Self {
            projection: c.projection.clone(),
            location: c.location,
            direction: c.direction,
            right: c.right,
            up: c.up,
            unit: [unit(c.right), unit(c.up), unit(c.direction)],
            size: DVec2::new(c.right.length(), c.up.length()),
            resolution: DVec2::new(f64::from(width), f64::from(height)),
            lens: c.blur.as_ref().filter(|b| b.aperture != 0.0 && b.max_samples > 0).map(|b| {
                let bokeh = |p: DVec2| {
                    let at = free_point(DVec3::new(p.x, p.y, 0.0));
                    eval_pigment(scene, scene.camera_bokeh, &at).map_or(0.0, |c| f64::from(grey(c.rgb)))
                };
                Lens::new(b, c.direction, c.up, (scene.camera_bokeh != crate::compile::NONE).then_some(&bokeh))
            }),
            mesh,
            normal_ix: (scene.camera_normal != crate::compile::NONE).then_some(scene.camera_normal),
        }
    }

    /// Whether every ray starts in the same point (the interiors around it are then looked up once).
    pub fn has_fixed_origin(&self) -> bool {
        match self.projection {
            Projection::Perspective => self.lens.is_none(),
            Projection::Orthographic | Projection::Cylinder { kind: 3 | 4, .. } | Projection::Mesh { .. } => false,
            _ => true,
        }
    }

    /// A box around the places that rays start from, where it is known; the picture and a frame of a pixel around it count.
    pub fn origins(&self) -> Option<Bounds> {
        let around = |reach: DVec3| Bounds { min: self.location - reach, max: self.location + reach };
        match (&self.projection, &self.lens) {
            (Projection::Perspective, Some(lens)) => Some(around(lens.reach())),
            (Projection::Orthographic, None) => {
                let part = DVec2::splat(0.5) + 1.5 / self.resolution;
                Some(around(part.x * self.right.abs() + part.y * self.up.abs()))
            }
            _ => None,
        }
    }

    /// The ray through a picture position, its direction unit; `None` where the projection shows nothing.
    pub fn ray(&self, x: f64, y: f64) -> Option<(Ray, DVec3)> {
        let p = self.project(self.screen(x, y))?;
        Some((Ray::new(p.origin, p.dir.try_normalize()?), p.normal_point))
    }

    /// The ray of lens sample `sample` of the pixel at (x, y), and the camera normal's point.
    #[inline]
    pub fn lens_ray(&self, lens: &Lens, x: f64, y: f64, sample: u32) -> Option<(Ray, DVec3)> {
        let (x, y) = lens.pixel_position(x, y, sample);
        let s = self.screen(x, y);
        // Of the projection that nearly all lenses have, without a copy.
        let (dir, at) = match self.projection {
            Projection::Perspective => (self.through(s), DVec3::new(s.x, s.y, 0.0)),
            _ => self.project(s).map(|p| (p.dir, p.normal_point))?,
        };
        let offset = lens.offset(x, y, sample);
        let dir = dir * lens.focal_factor - offset;
        Some((Ray::new(self.location + offset, dir.try_normalize()?), at))
    }

    /// Location, direction, right, up, and right, up and direction in length 1.
    pub fn frame(&self) -> [DVec3; 7] {
        let [r, u, d] = self.unit;
        [self.location, self.direction, self.right, self.up, r, u, d]
    }

    /// How positions become directions.
    pub fn projection(&self) -> &Projection {
        &self.projection
    }

    /// Lengths of right and up.
    pub fn size(&self) -> DVec2 {
        self.size
    }

    /// Screen coordinates, -0.5..0.5, y upwards.
    fn screen(&self, x: f64, y: f64) -> DVec2 {
        DVec2::new((x + 0.5) / self.resolution.x - 0.5, ((self.resolution.y - 1.0) - (y - 0.5)) / self.resolution.y - 0.5)
    }

    /// Direction of a perspective ray, not unit.
    #[inline]
    fn through(&self, s: DVec2) -> DVec3 {
        self.direction + s.x * self.right + s.y * self.up
    }

    fn project(&self, s: DVec2) -> Option<Projected> {
        let [r, u, d] = self.unit;
        let (DVec2 { x: a, y: b }, size) = (s, self.size);
        let from = |dir: DVec3, at: DVec2| Projected { origin: self.location, dir, normal_point: DVec3::new(at.x, at.y, 0.0) };
        Some(match self.projection {
            Projection::Perspective => from(self.through(s), s),
            Projection::Orthographic => Projected { origin: self.location + a * self.right + b * self.up, ..from(self.direction, s) },
            Projection::Fisheye { angle_rad } => {
                let p = 2.0 * s * size;
                let rho = p.length();
                if rho > 1.0 {
                    return None;
                }
                let phi = polar_angle(p, rho);
                let theta = rho * angle_rad * 0.5;
                from(dome(self.unit, phi, theta), DVec2::new(phi, theta))
            }
            Projection::UltraWideAngle { angle_rad } => {
                let at = DVec2::new(a * angle_rad, b * angle_rad * size.y / size.x);
                from(at.x.sin() * r + at.y.sin() * u + at.x.cos() * at.y.cos() * d, at)
            }
            Projection::Omnimax => {
                let (phi, theta) = omnimax_angles(s, size.x / size.y)?;
                from(dome(self.unit, phi, theta), DVec2::new(phi, theta))
            }
            Projection::Panoramic => {
                let at = DVec2::new(PI * (1.0 - (a + 0.5)), PI * b);
                from(at.x.cos() * self.right + at.y.tan() * self.up + at.x.sin() * self.direction, at)
            }
            Projection::Spherical { horizontal_rad, vertical_rad } => {
                let about = |v: DVec3, axis: DVec3, angle: f64| glam::DQuat::from_axis_angle(axis, angle) * v;
                let at = DVec2::new(a * horizontal_rad, b * vertical_rad);
                from(about(about(self.direction, r, -at.y), u, at.x), at)
            }
            Projection::Cylinder { kind, angle_rad } => {
                let (along_a, along_b) = (a * angle_rad, b * angle_rad);
                match kind {
                    1 => from(along_a.sin() * r + b * size.y * u + along_a.cos() * d, DVec2::new(along_a, b * size.y)),
                    2 => from(a * size.x * r + along_b.sin() * u + along_b.cos() * d, DVec2::new(a * size.x, along_b)),
                    3 => Projected {
                        origin: self.location + b * size.y * u,
                        ..from(along_a.sin() * r + along_a.cos() * d, DVec2::new(along_a, b * size.y))
                    },
                    _ => Projected {
                        origin: self.location + a * size.x * r,
                        ..from(along_b.sin() * u + along_b.cos() * d, DVec2::new(a * size.x, along_b))
                    },
                }
            }
            Projection::Panorama(ref panorama) => {
                let v = panorama::direction(panorama, s)?;
                from(v.x * r + v.y * u + v.z * d, s)
            }
            Projection::Mesh { .. } => return None,
        })
    }

    /// Columns and rows.
    pub fn resolution(&self) -> DVec2 {
        self.resolution
    }

    /// The eye point.
    pub fn location(&self) -> DVec3 {
        self.location
    }
}

/// From -90° at the bottom to 270°: where the range ends shows in the camera's normal (measured).
fn polar_angle(p: DVec2, rho: f64) -> f64 {
    if rho == 0.0 {
        return 0.0;
    }
    let phi = p.y.atan2(p.x);
    if p.x < 0.0 && phi < 0.0 { phi + 2.0 * PI } else { phi }
}

/// The direction at angle `theta` from the axis and angle `phi` about it.
fn dome([r, u, d]: [DVec3; 3], phi: f64, theta: f64) -> DVec3 {
    theta.sin() * (phi.cos() * r + phi.sin() * u) + theta.cos() * d
}

/// Angles of an omnimax projector; `None` off the dome or below the seats.
fn omnimax_angles(s: DVec2, aspect: f64) -> Option<(f64, f64)> {
    const FULL: f64 = 1.283_458;
    let mut p = 2.0 * s;
    if aspect > FULL {
        p.x *= aspect / FULL;
        p.y = (p.y - 1.0) / FULL + 1.0;
    } else if aspect > 1.0 {
        p.y = (p.y - 1.0) / aspect + 1.0;
    } else {
        p.y /= aspect;
    }
    let rho = p.length();
    if rho > 1.0 {
        return None;
    }
    let (phi, sq) = (polar_angle(p, rho), rho * rho);
    let theta = rho * (1.411_269 + sq * (-0.094_39 + sq * 0.256_74));
    (phi.sin() * theta.sin() >= -theta.cos()).then_some((phi, theta))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn model(projection: Projection) -> CameraModel {
        let lens = None;
        CameraModel {
            projection,
            location: DVec3::new(1.0, 2.0, 3.0),
            direction: DVec3::Z,
            right: DVec3::new(1.33, 0.0, 0.0),
            up: DVec3::Y,
            unit: [DVec3::X, DVec3::Y, DVec3::Z],
            size: DVec2::new(1.33, 1.0),
            resolution: DVec2::new(4.0, 3.0),
            lens,
            mesh: None,
            normal_ix: None,
        }
    }

    #[test]
    fn perspective_pixel_centres_are_half_a_pixel_from_the_edge() {
        let (ray, _) = model(Projection::Perspective).ray(0.0, 0.0).expect("a ray");
        let want = DVec3::new(1.33 * (0.125 - 0.5), 0.5 - 0.5 / 3.0, 1.0).normalize();
        assert!((ray.dir - want).length() < 1e-15, "{ray:?}");
    }

    #[test]
    fn orthographic_rays_are_parallel_and_start_on_the_picture_plane() {
        let m = model(Projection::Orthographic);
        let (ray, _) = m.ray(3.0, 1.0).expect("a ray");
        assert_eq!(ray.dir, DVec3::Z);
        assert!((ray.origin - DVec3::new(1.0 + 1.33 * 0.375, 2.0, 3.0)).length() < 1e-14);
        assert!(!m.has_fixed_origin());
    }

    #[test]
    fn fisheye_shows_a_disc_whose_rim_is_half_the_angle_off_axis() {
        let m = model(Projection::Fisheye { angle_rad: PI });
        assert!(m.ray(-0.5, -0.5).is_none(), "the corner is off the disc");
        let (ray, _) = m.ray(1.5, 2.5).expect("bottom of the disc");
        assert!((ray.dir - DVec3::NEG_Y).length() < 1e-12, "{ray:?}");
    }

    #[test]
    fn spherical_camera_turns_right_for_positive_columns_and_up_for_upper_rows() {
        let m = model(Projection::Spherical { horizontal_rad: 2.0 * PI, vertical_rad: PI });
        let (right, _) = m.ray(2.5, 1.0).expect("a ray");
        assert!((right.dir - DVec3::X).length() < 1e-12, "{right:?}");
        let (top, _) = m.ray(1.5, -0.5).expect("a ray");
        assert!((top.dir - DVec3::Y).length() < 1e-12, "{top:?}");
    }
}
