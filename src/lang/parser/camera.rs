//! `camera{}`: modifiers in any order, applied in a fixed one. Source: spec/textures.md, section 8.

use super::{PResult, Parser};
use crate::lang::keyword::Kw;
use crate::lang::value::Value;
use crate::math::{DVec3, EPSILON, Transform};
use crate::scene::camera::{Blur, Projection};
use crate::scene::{Camera, Object};

/// What the items of a camera say.
#[derive(Default)]
struct Items {
    angle: Option<(f64, Option<f64>)>,
    location: Option<DVec3>,
    direction: Option<DVec3>,
    up: Option<DVec3>,
    right: Option<DVec3>,
    sky: Option<DVec3>,
    look_at: Option<DVec3>,
    focal_point: Option<DVec3>,
    aperture: f64,
    samples: (u32, u32),
    confidence: f64,
    variance: f64,
    transform: Option<Transform>,
    /// `right` or `up` was given, `angle` was given, and what `look_at` named: kept where the items themselves are used up.
    sized: bool,
    angled: bool,
    target: Option<DVec3>,
}

impl Parser<'_> {
    /// `{ ... }` after `camera`.
    pub(super) fn parse_camera(&mut self) -> PResult<Camera> {
        self.block("camera", |p| {
            if let Some(Value::Camera(c)) = p.peek_value()? {
                let mut camera = (**c).clone();
                p.next()?;
                while let Some(t) = p.parse_transform()? {
                    camera.transform(&t);
                }
                p.warn_of_slant(&camera);
                return Ok(camera);
            }
            let mut camera = p.defaults.camera.clone();
            while let Some(projection) = p.camera_type()? {
                camera.projection = projection;
            }
            let mut items = Items { confidence: 0.9, variance: 1e-4, ..Items::default() };
            p.camera_items(&mut camera, &mut items)?;
            let camera = p.resolve_camera(camera, items)?;
            p.warn_of_slant(&camera);
            Ok(camera)
        })
    }

    /// A camera whose vectors do not stand upright on each other slants its picture.
    fn warn_of_slant(&mut self, c: &Camera) {
        let pairs = [(c.right, c.up), (c.up, c.direction), (c.direction, c.right)];
        if pairs.iter().any(|(a, b)| a.dot(*b).abs() > EPSILON * a.length() * b.length()) {
            self.warn("Camera vectors are not perpendicular. Making look_at the last statement may help.");
        }
    }

    fn camera_type(&mut self) -> PResult<Option<Projection>> {
        let right_angle = std::f64::consts::FRAC_PI_2;
        let Some(k) = self.peek_kw()? else { return Ok(None) };
        let projection = match k {
            Kw::Perspective => Projection::Perspective,
            Kw::Orthographic => Projection::Orthographic,
            Kw::Fisheye => Projection::Fisheye { angle_rad: right_angle },
            Kw::UltraWideAngle => Projection::UltraWideAngle { angle_rad: right_angle },
            Kw::Omnimax => Projection::Omnimax,
            Kw::Panoramic => Projection::Panoramic,
            Kw::Spherical => Projection::Spherical { horizontal_rad: 4.0 * right_angle, vertical_rad: 2.0 * right_angle },
            Kw::Cylinder => {
                self.next()?;
                let kind = self.parse_int()?;
                if !(1..=4).contains(&kind) {
                    return Err(self.error("Cylinder camera type must be 1, 2, 3 or 4."));
                }
                return Ok(Some(Projection::Cylinder { kind: kind as u8, angle_rad: right_angle }));
            }
            Kw::MeshCamera => {
                self.next()?;
                return self.mesh_camera().map(Some);
            }
            _ => return Ok(None),
        };
        self.next()?;
        Ok(Some(projection))
    }

    fn mesh_camera(&mut self) -> PResult<Projection> {
        self.block("mesh_camera", |p| {
            let n_rays = p.parse_int()?;
            if n_rays < 1 {
                return Err(p.error("Rays per pixel may not be 0"));
            }
            let n_rays = p.at_most(n_rays, 1 << 20, "A number of rays")?;
            let distribution = p.parse_int()?;
            if !(0..=3).contains(&distribution) {
                return Err(p.error("Mesh camera distribution type must be 0, 1, 2 or 3."));
            }
            let max_distance = if p.number_follows()? { p.parse_float()? } else { 0.0 };
            let (mut meshes, mut smooth) = (Vec::<Object>::new(), false);
            loop {
                if p.accept_kw(Kw::Smooth)? {
                    smooth = true;
                } else if let Some(o) = p.mesh_object()? {
                    meshes.push(o);
                } else {
                    break;
                }
            }
            if meshes.is_empty() {
                return p.expected("mesh object");
            }
            Ok(Projection::Mesh { n_rays, distribution: distribution as u8, max_distance, meshes, smooth })
        })
    }

    /// A mesh, if one is next.
    fn mesh_object(&mut self) -> PResult<Option<Object>> {
        let named = matches!(self.peek_value()?, Some(Value::Object(_)));
        if !named && !matches!(self.peek_kw()?, Some(Kw::Mesh | Kw::Mesh2 | Kw::Object)) {
            return Ok(None);
        }
        self.parse_object()
    }

    fn camera_items(&mut self, camera: &mut Camera, items: &mut Items) -> PResult<()> {
        loop {
            if self.version < 350 {
                self.use_up(camera, items)?;
            }
            if let Some(t) = self.parse_transform()? {
                items.transform = Some(items.transform.unwrap_or_default().then(&t));
                continue;
            }
            let Some(k) = self.peek_kw()? else { return Ok(()) };
            match k {
                Kw::Angle => {
                    self.next()?;
                    let orthographic = matches!(camera.projection, Projection::Orthographic);
                    let first = if orthographic && !self.number_follows()? { 45.0 } else { self.parse_float()? };
                    let mut second = None;
                    if matches!(camera.projection, Projection::Spherical { .. }) {
                        self.comma()?;
                        if self.number_follows()? {
                            second = Some(self.parse_float()?);
                        }
                    }
                    if first < 0.0 {
                        return Err(self.error("Negative viewing angle."));
                    }
                    if first >= 180.0 && matches!(camera.projection, Projection::Perspective | Projection::Orthographic) {
                        return Err(self.error("Viewing angle has to be smaller than 180 degrees."));
                    }
                    items.angle = Some((first, second));
                    items.angled = true;
                }
                Kw::Location => {
                    self.next()?;
                    items.location = Some(self.parse_vector3()?);
                }
                Kw::Direction => {
                    self.next()?;
                    items.direction = Some(self.parse_vector3()?);
                }
                Kw::Up => {
                    self.next()?;
                    items.up = Some(self.parse_vector3()?);
                    items.sized = true;
                }
                Kw::Right => {
                    self.next()?;
                    items.right = Some(self.parse_vector3()?);
                    items.sized = true;
                }
                Kw::Sky => {
                    self.next()?;
                    items.sky = Some(self.parse_vector3()?);
                }
                Kw::LookAt => {
                    self.next()?;
                    items.look_at = Some(self.parse_vector3()?);
                    items.target = items.look_at;
                }
                Kw::FocalPoint => {
                    self.next()?;
                    items.focal_point = Some(self.parse_vector3()?);
                }
                Kw::Aperture => {
                    self.next()?;
                    items.aperture = self.parse_float()?;
                }
                Kw::BlurSamples => {
                    self.next()?;
                    let first = self.parse_int()?;
                    self.comma()?;
                    let second = if self.number_follows()? { Some(self.parse_int()?) } else { None };
                    let (low, high) = second.map_or((0, first), |s| (first, s));
                    if high < 1 {
                        return Err(self.error("Illegal number of focal blur samples."));
                    }
                    if low > high {
                        return Err(self.error("Focal blur samples minimum must not be larger than maximum."));
                    }
                    items.samples = (low.max(0) as u32, self.at_most(high, 1 << 20, "A number of focal blur samples")?);
                }
                Kw::Confidence => {
                    self.next()?;
                    items.confidence = self.parse_float()?;
                    if !(items.confidence > 0.0 && items.confidence < 1.0) {
                        self.warn("Illegal confidence value. Default is used.");
                        items.confidence = 0.9;
                    }
                }
                Kw::Variance => {
                    self.next()?;
                    items.variance = self.parse_float()?;
                    if !(0.0..=1.0).contains(&items.variance) {
                        self.warn("Illegal variance value. Default is used.");
                        items.variance = 1e-4;
                    }
                }
                Kw::Bokeh => {
                    self.next()?;
                    let pigment = self.block("bokeh", |p| {
                        p.expect_kw(Kw::Pigment)?;
                        p.parse_pigment_block()
                    })?;
                    camera.blur = Some(Blur {
                        aperture: 0.0,
                        focal_distance: 0.0,
                        min_samples: 0,
                        max_samples: 0,
                        confidence: 0.0,
                        variance: 0.0,
                        bokeh: Some(pigment),
                    });
                }
                Kw::Normal => {
                    self.next()?;
                    camera.normal = Some(self.parse_normal_block()?);
                }
                Kw::Perspective | Kw::Orthographic | Kw::Fisheye | Kw::UltraWideAngle | Kw::Omnimax | Kw::Panoramic | Kw::Spherical => {
                    return self.expected("perspective camera modifier");
                }
                _ => return Ok(()),
            }
        }
    }

    /// Before language 3.5 each item acts where it is written (measured): `sky` and `direction` after `look_at` are too late for it.
    fn use_up(&mut self, c: &mut Camera, items: &mut Items) -> PResult<()> {
        c.right = items.right.take().unwrap_or(c.right);
        c.up = items.up.take().unwrap_or(c.up);
        c.direction = items.direction.take().unwrap_or(c.direction);
        c.location = items.location.take().unwrap_or(c.location);
        if let Some(angle) = items.angle.take() {
            self.apply_angle(c, angle)?;
        }
        if let Some(target) = items.look_at.take() {
            self.look_at(c, target, items.sky.unwrap_or(DVec3::Y))?;
        }
        if let Some(t) = items.transform.take() {
            c.transform(&t);
        }
        Ok(())
    }

    /// Sets the viewing angle: the direction's length, or the projection's own.
    fn apply_angle(&mut self, c: &mut Camera, (degrees, second): (f64, Option<f64>)) -> PResult<()> {
        let angle = degrees.to_radians();
        match &mut c.projection {
            Projection::Perspective | Projection::Orthographic if degrees > 0.0 => {
                if c.direction.length() < EPSILON {
                    return Err(self.error("Camera direction vector must not be zero-length."));
                }
                c.direction = c.direction.normalize() * c.right.length() / (2.0 * (angle / 2.0).tan());
            }
            Projection::Fisheye { angle_rad } | Projection::UltraWideAngle { angle_rad } | Projection::Cylinder { angle_rad, .. } => {
                *angle_rad = angle;
            }
            Projection::Spherical { horizontal_rad, vertical_rad } => {
                *horizontal_rad = angle;
                *vertical_rad = second.map_or(angle / 2.0, f64::to_radians);
            }
            _ => {}
        }
        Ok(())
    }

    fn resolve_camera(&mut self, mut c: Camera, items: Items) -> PResult<Camera> {
        c.right = items.right.unwrap_or(c.right);
        c.direction = items.direction.unwrap_or(c.direction);
        if let Some(angle) = items.angle {
            self.apply_angle(&mut c, angle)?;
        }
        c.up = items.up.unwrap_or(c.up);
        let sky = items.sky.unwrap_or(DVec3::Y);
        c.location = items.location.unwrap_or(c.location);
        if let Some(target) = items.look_at {
            self.look_at(&mut c, target, sky)?;
        }
        if !(c.direction.is_finite() && c.right.is_finite() && c.up.is_finite() && c.location.is_finite()) {
            return Err(self.error("Camera vectors must be finite."));
        }
        if matches!(c.projection, Projection::Orthographic) && (!items.sized || items.angled) {
            let factor = (items.target.unwrap_or(DVec3::Z) - c.location).length() / c.direction.length();
            if factor > EPSILON {
                c.right *= factor;
                c.up *= factor;
            }
        }
        let is_flat = matches!(c.projection, Projection::Perspective | Projection::Orthographic);
        let bokeh = c.blur.take().and_then(|b| b.bokeh);
        if items.aperture != 0.0 && items.samples.1 > 0 {
            let distance = match items.focal_point {
                Some(p) => (p - c.location).length(),
                // The length that an angle or look_at left, and 1 where nothing touched the direction.
                None if items.angled && is_flat || items.target.is_some() => c.direction.length(),
                None => 1.0,
            };
            c.blur = Some(Blur {
                aperture: items.aperture,
                focal_distance: distance,
                min_samples: items.samples.0,
                max_samples: items.samples.1,
                confidence: items.confidence,
                variance: items.variance,
                bokeh,
            });
        }
        if let Some(t) = items.transform {
            c.transform(&t);
        }
        Ok(c)
    }

    fn look_at(&mut self, c: &mut Camera, target: DVec3, sky: DVec3) -> PResult<()> {
        let handedness = c.up.cross(c.direction).dot(c.right);
        let (d, r, u) = (c.direction.length(), c.right.length(), c.up.length());
        let to = target - c.location;
        if to.length() < EPSILON {
            return Err(self.error("Camera location and look_at point must be different."));
        }
        let direction = to.normalize();
        let mut right = sky.cross(direction);
        if right.length() < EPSILON {
            self.warn("Camera direction and sky are parallel: the given right vector is used.");
            right = c.right;
        }
        let right = right.normalize();
        c.direction = direction * d;
        c.up = direction.cross(right) * u;
        c.right = if handedness > 0.0 { right * r } else { right * -r };
        Ok(())
    }
}
