//! Lamps with a size, in Cycles' units: drawing a point of one as seen from a place, its density, and rays that meet one by chance.
//!
//! Source of the units: measured (docs/path.md).

use super::LightSample;
use super::rectangle::{SeenRectangle, Sides};
use crate::kernel::bsdf::frame::disc;
use crate::kernel::light::smoothstep;
use crate::math::{DVec3, Rgb};
use crate::scene::Lamp;
use crate::scene::lamp::LampShape;
use std::f64::consts::PI;

/// Area lamps seen smaller than that (sr) are drawn by area.
const LEAST_SOLID_ANGLE: f64 = 1e-4;

/// A lamp in world space.
#[derive(Clone, Debug)]
pub struct ReadyLamp {
    /// As the scene gives it.
    pub lamp: Lamp,
    /// Centre.
    pub center: DVec3,
    /// Unit; shines along it.
    pub axis: DVec3,
    /// Half axes of an area.
    pub half: [DVec3; 2],
    /// Of an area lamp.
    pub area: f64,
    /// Radiance; of a point without size the intensity, of a sun without size the irradiance.
    pub radiance: Rgb,
    /// Cone of a spot, half angle of a sun, half of an area's spread.
    pub cos_half: f64,
    /// (1 - cos_half) * blend of a spot; 1 / (tan - angle) of a spread.
    pub soft: f64,
    /// Half of an area's spread.
    pub half_spread: f64,
    /// Cosine of the widest part of a spot's cone, which a scale may make elliptic.
    widest: f64,
    /// Of a rectangle.
    sides: Option<Sides>,
}

impl ReadyLamp {
    /// Made ready; `None` for a lamp that gives no light.
    pub fn new(lamp: &Lamp) -> Option<Self> {
        if !(lamp.power.max_element() > 0.0) {
            return None;
        }
        let t = &lamp.transform;
        let axis = t.vector(DVec3::NEG_Z).try_normalize().unwrap_or(DVec3::NEG_Z);
        let mut ready = Self {
            lamp: lamp.clone(),
            center: t.point(DVec3::ZERO),
            axis,
            half: [DVec3::ZERO; 2],
            area: 0.0,
            radiance: lamp.power,
            cos_half: -1.0,
            soft: 0.0,
            half_spread: 0.5 * PI,
            widest: -1.0,
            sides: None,
        };
        match lamp.shape {
            LampShape::Point { radius, .. } | LampShape::Spot { radius, .. } => {
                let r = radius.max(0.0);
                // L = W / 4π² r²; I = W / 4π.
                let scale = if r > 0.0 { 1.0 / (4.0 * PI * PI * r * r) } else { 0.25 / PI };
                ready.radiance = lamp.power * scale as f32;
                if let LampShape::Spot { angle_rad, blend, .. } = lamp.shape {
                    ready.cos_half = (0.5 * angle_rad).cos();
                    ready.soft = (1.0 - ready.cos_half) * blend.clamp(0.0, 1.0);
                    let [x, y, z] = [DVec3::X, DVec3::Y, DVec3::Z].map(|v| t.vector(v).length());
                    // 1 / sqrt(1 + tan²) of the wider half axis.
                    let tan = (0.5 * angle_rad).tan() * x.max(y) / z;
                    ready.widest = if ready.cos_half > 0.0 { 1.0 / tan.hypot(1.0) } else { ready.cos_half.min(0.0) };
                }
            }
            LampShape::Sun { angle_rad } => {
                let half = (0.5 * angle_rad).clamp(0.0, 0.5 * PI);
                ready.cos_half = half.cos();
                // Irradiance at right angles is L π sin².
                let s = half.sin();
                if s > 0.0 {
                    ready.radiance = lamp.power * (1.0 / (PI * s * s)) as f32;
                }
            }
            LampShape::Area { ellipse, size, spread_rad } => {
                ready.half = [t.vector(DVec3::X) * (0.5 * size[0]), t.vector(DVec3::Y) * (0.5 * size[1])];
                let rectangle = 4.0 * ready.half[0].cross(ready.half[1]).length();
                ready.area = if ellipse { rectangle * 0.25 * PI } else { rectangle };
                if !(ready.area > 0.0) {
                    return None;
                }
                ready.sides = if ellipse { None } else { Sides::new(ready.half) };
                ready.radiance = lamp.power * (1.0 / (PI * ready.area)) as f32;
                ready.half_spread = (0.5 * spread_rad).clamp(1e-3, 0.5 * PI);
                if ready.half_spread < 0.5 * PI - 1e-6 {
                    ready.soft = 1.0 / (ready.half_spread.tan() - ready.half_spread);
                }
            }
        }
        Some(ready)
    }

    /// Whether it stands at infinity.
    pub fn is_distant(&self) -> bool {
        matches!(self.lamp.shape, LampShape::Sun { .. })
    }

    /// Radius of a point or spot.
    pub fn radius(&self) -> f64 {
        match self.lamp.shape {
            LampShape::Point { radius, .. } | LampShape::Spot { radius, .. } => radius.max(0.0),
            _ => 0.0,
        }
    }

    /// Intensity along its axis, by channel.
    pub fn intensity(&self) -> Rgb {
        match self.lamp.shape {
            LampShape::Point { .. } | LampShape::Spot { .. } => self.lamp.power * (0.25 / PI) as f32,
            LampShape::Sun { .. } => self.lamp.power,
            LampShape::Area { .. } => self.radiance * (self.area * self.spread_factor(1.0)) as f32,
        }
    }

    /// Half size of the box around it.
    pub fn extent(&self) -> DVec3 {
        self.half[0].abs() + self.half[1].abs() + DVec3::splat(self.radius())
    }

    /// Cosine of the cone in which it shines.
    pub fn cone_cos(&self) -> f64 {
        match self.lamp.shape {
            LampShape::Spot { .. } => self.widest,
            LampShape::Area { .. } => self.half_spread.cos(),
            _ => -1.0,
        }
    }

    /// Factor of a spread at a cosine with the axis, relative to a lamp without.
    fn spread_factor(&self, cos: f64) -> f64 {
        if self.soft == 0.0 {
            return 1.0;
        }
        let tan = (1.0 - cos * cos).max(0.0).sqrt() / cos.max(1e-12);
        (self.soft * (self.half_spread.tan() - tan)).max(0.0)
    }

    /// Factor of the beam for light that leaves along `dir`.
    fn beam(&self, dir: DVec3) -> f64 {
        match self.lamp.shape {
            LampShape::Spot { .. } => {
                // In the lamp's own space: its scale makes the cone elliptic.
                let cos = -self.lamp.transform.inverse_vector(dir).normalize_or_zero().z;
                if self.soft > 0.0 { smoothstep(0.0, 1.0, (cos - self.cos_half) / self.soft) } else { f64::from(cos > self.cos_half) }
            }
            LampShape::Area { .. } => self.spread_factor(dir.dot(self.axis)),
            _ => 1.0,
        }
    }

    /// A rectangle that stands at `to` from the viewer, where it is drawn by solid angle.
    fn seen_rectangle(&self, to: DVec3) -> Option<SeenRectangle<'_>> {
        SeenRectangle::new(to, self.sides.as_ref()?, LEAST_SOLID_ANGLE)
    }

    /// A point of it as seen from `from`.
    pub fn sample(&self, from: DVec3, [u, v]: [f32; 2]) -> Option<LightSample> {
        let made = |dir: DVec3, distance: f64, factor: f64, pdf: f64, is_delta: bool| {
            (factor > 0.0 && pdf > 0.0).then_some(LightSample {
                dir,
                distance,
                radiance: self.radiance * factor as f32,
                pdf: pdf as f32,
                is_delta,
                ..LightSample::NONE
            })
        };
        match self.lamp.shape {
            LampShape::Sun { .. } => {
                if self.cos_half >= 1.0 {
                    return made(-self.axis, f64::INFINITY, 1.0, 1.0, true);
                }
                let dir = cone_sample(-self.axis, self.cos_half, u, v);
                made(dir, f64::INFINITY, 1.0, cone_density(self.cos_half), false)
            }
            LampShape::Point { soft_falloff, .. } | LampShape::Spot { soft_falloff, .. } => {
                let to = self.center - from;
                let d_sq = to.length_squared();
                let r = self.radius();
                if d_sq <= 0.0 {
                    return None;
                }
                let d = d_sq.sqrt();
                let n = to / d;
                if r == 0.0 {
                    return made(n, d, self.beam(-n) / d_sq, 1.0, true);
                }
                if soft_falloff {
                    let (x, y) = disc(u, v);
                    let (t, b) = n.any_orthonormal_pair();
                    let point = to + r * (f64::from(x) * t + f64::from(y) * b);
                    let len_sq = point.length_squared();
                    let len = len_sq.sqrt();
                    let dir = point / len;
                    return made(dir, len, self.beam(-dir), len_sq / (dir.dot(n) * PI * r * r), false);
                }
                if d <= r {
                    return None;
                }
                let cos = (1.0 - r * r / d_sq).max(0.0).sqrt();
                let dir = cone_sample(n, cos, u, v);
                let along = dir.dot(to);
                let distance = along - (r * r - (d_sq - along * along)).max(0.0).sqrt();
                made(dir, distance, self.beam(-dir), cone_density(cos), false)
            }
            LampShape::Area { ellipse, .. } => {
                if (from - self.center).dot(self.axis) <= 0.0 {
                    return None;
                }
                let to = self.center - from;
                if let Some(rectangle) = self.seen_rectangle(to) {
                    let point = rectangle.sample(f64::from(u), f64::from(v));
                    let distance = point.length();
                    let dir = point / distance;
                    return made(dir, distance, self.beam(-dir), 1.0 / rectangle.solid_angle, false);
                }
                let (x, y) = if ellipse { disc(u, v) } else { (2.0 * u - 1.0, 2.0 * v - 1.0) };
                let point = to + self.half[0] * f64::from(x) + self.half[1] * f64::from(y);
                let len_sq = point.length_squared();
                let len = len_sq.sqrt();
                let dir = point / len;
                let cos = -dir.dot(self.axis);
                made(dir, len, self.beam(-dir), len_sq / (cos * self.area), false)
            }
        }
    }

    /// Where a ray from `from` meets it before `t_max`: depth, radiance, density with which [`Self::sample`] draws that direction.
    pub fn hit(&self, from: DVec3, dir: DVec3, t_max: f64) -> Option<(f64, Rgb, f32)> {
        let found = |t: f64, factor: f64, pdf: f64| (factor > 0.0).then_some((t, self.radiance * factor as f32, pdf as f32));
        match self.lamp.shape {
            LampShape::Sun { .. } => {
                let inside = self.cos_half < 1.0 && t_max == f64::INFINITY && -dir.dot(self.axis) >= self.cos_half;
                if inside { found(f64::INFINITY, 1.0, cone_density(self.cos_half)) } else { None }
            }
            LampShape::Point { soft_falloff, .. } | LampShape::Spot { soft_falloff, .. } => {
                let (to, r) = (self.center - from, self.radius());
                let d_sq = to.length_squared();
                if r == 0.0 || d_sq <= 0.0 {
                    return None;
                }
                let d = d_sq.sqrt();
                let along = dir.dot(to);
                if soft_falloff {
                    let cos = along / d;
                    if cos <= 0.0 {
                        return None;
                    }
                    let t = d / cos;
                    if t >= t_max || (dir * t - to).length_squared() > r * r {
                        return None;
                    }
                    return found(t, self.beam(-dir), t * t / (cos * PI * r * r));
                }
                let miss_sq = d_sq - along * along;
                if along <= 0.0 || d <= r || miss_sq > r * r {
                    return None;
                }
                let t = along - (r * r - miss_sq).sqrt();
                if t >= t_max {
                    return None;
                }
                found(t, self.beam(-dir), cone_density((1.0 - r * r / d_sq).max(0.0).sqrt()))
            }
            LampShape::Area { ellipse, .. } => {
                let cos = -dir.dot(self.axis);
                let to = self.center - from;
                if cos <= 0.0 {
                    return None;
                }
                let t = -to.dot(self.axis) / cos;
                if !(t > 0.0 && t < t_max) {
                    return None;
                }
                let at = dir * t - to;
                let x = at.dot(self.half[0]) / self.half[0].length_squared();
                let y = at.dot(self.half[1]) / self.half[1].length_squared();
                let outside = if ellipse { x * x + y * y > 1.0 } else { x.abs() > 1.0 || y.abs() > 1.0 };
                if outside {
                    return None;
                }
                let pdf = self.seen_rectangle(to).map_or_else(|| t * t / (cos * self.area), |r| 1.0 / r.solid_angle);
                found(t, self.beam(-dir), pdf)
            }
        }
    }
}

/// Density of a cone's directions.
fn cone_density(cos_half: f64) -> f64 {
    1.0 / (2.0 * PI * (1.0 - cos_half)).max(1e-30)
}

/// A direction of the cone about `axis`, all alike.
pub fn cone_sample(axis: DVec3, cos_half: f64, u: f32, v: f32) -> DVec3 {
    let (x, y) = disc(u, v);
    let (x, y) = (f64::from(x), f64::from(y));
    let r_sq = x * x + y * y;
    let cos = 1.0 - r_sq * (1.0 - cos_half);
    let sin = (1.0 - cos * cos).max(0.0).sqrt();
    let (t, b) = axis.any_orthonormal_pair();
    let k = if r_sq > 0.0 { sin / r_sq.sqrt() } else { 0.0 };
    (axis * cos + t * (k * x) + b * (k * y)).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::sobol::sobol4;
    use crate::math::{Transform, Vec3};

    /// Irradiance at the origin on a plane facing +z, by sampling the lamp; and by rays over the hemisphere that meet it.
    fn irradiance(lamp: &Lamp) -> (f64, f64) {
        let ready = ReadyLamp::new(lamp).expect("a lamp that shines");
        let n = 1 << 16;
        let (mut sampled, mut met) = (0.0, 0.0);
        for k in 0..n {
            let u = sobol4(7, k, 0);
            if let Some(s) = ready.sample(DVec3::ZERO, [u[0], u[1]]) {
                sampled += f64::from(s.radiance.x / s.pdf) * s.dir.z.max(0.0);
            }
            let d = crate::kernel::bsdf::frame::cosine_hemisphere(u[2], u[3]).as_dvec3();
            if let Some((_, radiance, pdf)) = ready.hit(DVec3::ZERO, d, f64::INFINITY) {
                assert!(pdf > 0.0);
                met += f64::from(radiance.x) * PI;
            }
        }
        (sampled / f64::from(n), met / f64::from(n))
    }

    fn above(shape: LampShape, watts: f32, height: f64) -> Lamp {
        Lamp::new(shape, Vec3::splat(watts), Transform::translation(DVec3::new(0.0, 0.0, height)))
    }

    #[test]
    fn lamps_give_the_irradiance_that_cycles_gives() {
        let close = |name: &str, got: f64, want: f64, tolerance: f64| {
            assert!((got / want - 1.0).abs() < tolerance, "{name}: {got}, not {want}");
        };
        let (w, d, r) = (100.0f32, 2.0, 0.5);
        let i = f64::from(w) / (4.0 * PI);
        let point = |radius, soft_falloff| above(LampShape::Point { radius, soft_falloff }, w, d);
        close("point", irradiance(&point(0.0, true)).0, i / (d * d), 1e-5);
        for (name, lamp, want) in [
            ("disc that faces", point(r, true), i / (d * d + r * r)),
            ("ball", point(r, false), i / (d * d)),
            ("sun", above(LampShape::Sun { angle_rad: 0.3 }, 3.0, 0.0), 3.0),
            // A disc of diameter 1: L = W / πA, E = π L sin².
            ("disc", above(LampShape::Area { ellipse: true, size: [1.0, 1.0], spread_rad: PI }, w, d), {
                let l = f64::from(w) / (PI * PI * 0.25);
                PI * l * 0.25 / (d * d + 0.25)
            }),
        ] {
            let (sampled, met) = irradiance(&lamp);
            close(name, sampled, want, 2e-3);
            close(name, met, want, 3e-2);
        }
        let square = above(LampShape::Area { ellipse: false, size: [1.0, 1.0], spread_rad: PI }, w, d);
        let (sampled, met) = irradiance(&square);
        // Form factor of a square from a point below its middle. Source: Howell, C-11, four times the quarter.
        let a = 0.5 / d;
        let f = 4.0 * (a / (1.0 + a * a).sqrt() * (a / (1.0 + a * a).sqrt()).atan()) / PI;
        close("square", sampled, f * PI * f64::from(w) / PI, 1e-3);
        close("square met", met, f * f64::from(w), 3e-2);
        let spot = above(LampShape::Spot { radius: 0.0, soft_falloff: true, angle_rad: 0.7, blend: 0.2 }, w, d);
        close("spot", irradiance(&spot).0, i / (d * d), 1e-5);
        let narrow = LampShape::Area { ellipse: false, size: [1e-3, 1e-3], spread_rad: 60f64.to_radians() };
        let (sampled, _) = irradiance(&above(narrow, w, d));
        // Measured of Cycles: 10.7 times as bright on the axis at 60 degrees.
        let h = 30f64.to_radians();
        close("spread", sampled, f64::from(w) / PI / (d * d) * h.tan() / (h.tan() - h), 2e-3);
    }
}
