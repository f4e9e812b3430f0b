//! Light sources as seen from a point: direction, distance, brightness by beam and by distance, points of area lights.
//! Nothing here tests for shadow. Source: spec/light.md, section 6; spec/textures.md, section 12. Twin: `shaders/shared/light`.

use crate::compile::LightBeam;
use crate::math::simd::{self, Kernel, Simd};
use crate::math::{DVec3, EPSILON, to_power};
use crate::scene::Light;
use crate::scene::light::{AreaLight, Fade, LightKind};

/// Distance given to light from infinity.
pub const SUN_DISTANCE: f64 = 1e9;

/// The way from a point to a light.
#[derive(Clone, Copy, Debug)]
pub struct LightRay {
    /// Unit, towards the light.
    pub dir: DVec3,
    /// To the light along `dir`; negative behind the plane of a parallel light.
    pub distance: f64,
}

/// From `point` to the light's centre shifted by `offset`.
#[inline]
pub fn light_ray(light: &Light, point: DVec3, offset: DVec3) -> LightRay {
    if let LightKind::Sun { direction, .. } = light.kind {
        let dir = (SUN_DISTANCE * -direction + offset).normalize();
        return LightRay { dir, distance: SUN_DISTANCE };
    }
    let to = light.location + offset - point;
    if light.parallel || matches!(light.kind, LightKind::Cylinder { .. }) {
        let dir = (light.location + offset - light.point_at).try_normalize().unwrap_or(DVec3::NEG_Z);
        return LightRay { dir, distance: to.dot(dir) };
    }
    let distance = to.length();
    LightRay { dir: if distance > 0.0 { to / distance } else { DVec3::Y }, distance }
}

/// How much of the light's colour arrives at `point` without obstacles.
#[inline]
pub fn attenuation(light: &Light, shape: &LightBeam, point: DVec3, ray: &LightRay) -> f64 {
    beam_share(light, shape, point, ray) * fade(light.fade, ray.distance)
}

/// How much of the light's colour its beam sends towards `point`; distance does not count.
#[inline]
pub fn beam_share(light: &Light, shape: &LightBeam, point: DVec3, ray: &LightRay) -> f64 {
    match light.kind {
        LightKind::Point | LightKind::Sun { .. } => 1.0,
        LightKind::Spot { tightness, .. } => {
            let cos = -ray.dir.dot(shape.axis);
            if cos <= 0.0 || (light.parallel && ray.distance <= 0.0) {
                return 0.0;
            }
            // The edge is soft between the two cosines, whichever is larger; a radius of 90° and more has none.
            let is_edge = shape.cos_radius > 0.0 && cos < shape.cos_radius;
            let soft = if is_edge { smoothstep(shape.cos_falloff, shape.cos_radius, cos) } else { 1.0 };
            if tightness == 0.0 || soft == 0.0 { soft } else { to_power(cos, tightness) * soft }
        }
        LightKind::Cylinder { radius, falloff, tightness } => {
            let from_light = point - light.location;
            let along = from_light.dot(shape.axis);
            if along <= 0.0 {
                return 0.0;
            }
            let r = (from_light.length_squared() - along * along).max(0.0).sqrt();
            if r >= falloff {
                return 0.0;
            }
            let x = 1.0 - r / falloff;
            let k = if tightness == 0.0 { 1.0 } else { to_power(x, tightness) };
            if radius > 0.0 && r > radius { k * smoothstep(0.0, 1.0 - radius / falloff, x) } else { k }
        }
    }
}

/// Weakening with distance.
#[inline]
pub fn fade(fade: Fade, distance: f64) -> f64 {
    match fade {
        Fade::Pov { distance: d, power } if power > 0.0 && d != 0.0 => {
            let x = distance / d;
            // The powers that scenes use need no logarithm.
            2.0 / (1.0
                + if power == 2.0 {
                    x * x
                } else if power == 1.0 {
                    x
                } else {
                    x.powf(power)
                })
        }
        Fade::InverseSquare => 1.0 / (distance * distance).max(1e-8),
        _ => 1.0,
    }
}

/// 0 below `low`, 1 from `high` on, smooth between; the lower rule first when they cross.
#[inline]
pub fn smoothstep(low: f64, high: f64, x: f64) -> f64 {
    if x < low {
        0.0
    } else if x >= high {
        1.0
    } else {
        let t = (x - low) / (high - low);
        t * t * (3.0 - 2.0 * t)
    }
}

/// The axes of an area light for a point that sees its centre in direction `to_light`.
pub fn area_axes(area: &AreaLight, to_light: DVec3) -> (DVec3, DVec3) {
    if !area.orient {
        return (area.axis1, area.axis2);
    }
    let e = if (to_light.z.abs() - 1.0).abs() < 0.01 { DVec3::Y } else { DVec3::Z };
    let len = area.axis1.length();
    let a = len * to_light.cross(e).normalize_or_zero();
    (a, len * to_light.cross(a).normalize_or_zero())
}

/// Makes `n` ways to points unit, if `v` holds the ways by axis; gives their lengths. As [`light_ray`] does for one, to the last bit.
pub fn unit_ways<const N: usize>(v: &mut [[f64; N]; 3], length: &mut [f64; N], n: usize) {
    simd::run(UnitWays { v, length, n });
}

struct UnitWays<'v, const N: usize> {
    v: &'v mut [[f64; N]; 3],
    length: &'v mut [f64; N],
    n: usize,
}

impl<const N: usize> Kernel for UnitWays<'_, N> {
    type Output = ();

    /// Plain loops: compiled for wide registers they run side by side.
    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        let [x, y, z] = self.v;
        let n = self.n.min(N);
        for k in 0..n {
            self.length[k] = (x[k] * x[k] + y[k] * y[k] + z[k] * z[k]).sqrt();
        }
        for (axis, none) in [(x, 0.0), (y, 1.0), (z, 0.0)] {
            for k in 0..n {
                let d = axis[k] / self.length[k];
                axis[k] = if self.length[k] > 0.0 { d } else { none };
            }
        }
    }
}

/// Shift of grid point (u, v) (already jittered) from the centre.
#[inline]
pub fn area_offset(area: &AreaLight, axes: (DVec3, DVec3), u: f64, v: f64) -> DVec3 {
    let place = |u: f64, n: u32| if n > 1 { u / f64::from(n - 1) - 0.5 } else { 0.0 };
    let (mut a, mut b) = (place(u, area.n1), place(v, area.n2));
    if area.circular {
        // The program keeps off the exact centre by a thousandth.
        (a, b) = (a + 0.001, b + 0.001);
        let len = (a * a + b * b).sqrt();
        if len > EPSILON {
            let s = a.abs().max(b.abs()) / len;
            (a, b) = (a * s, b * s);
        }
    }
    axes.0 * a + axes.1 * b
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;

    fn spot() -> Light {
        let kind = LightKind::Spot { radius_rad: 30f64.to_radians(), falloff_rad: 45f64.to_radians(), tightness: 2.0 };
        Light { kind, point_at: DVec3::NEG_Y, ..Light::point(DVec3::ZERO, Vec3::ONE) }
    }

    #[test]
    fn spot_is_cosine_power_inside_smooth_at_the_edge_and_dark_outside() {
        let at = |deg: f64| {
            let (s, c) = deg.to_radians().sin_cos();
            let p = DVec3::new(s, -c, 0.0) * 3.0;
            attenuation(&spot(), &LightBeam::new(&spot()), p, &light_ray(&spot(), p, DVec3::ZERO))
        };
        assert!((at(20.0) - 20f64.to_radians().cos().powi(2)).abs() < 1e-12);
        let (cos, lo, hi) = (40f64.to_radians().cos(), 45f64.to_radians().cos(), 30f64.to_radians().cos());
        let t = (cos - lo) / (hi - lo);
        assert!((at(40.0) - cos * cos * t * t * (3.0 - 2.0 * t)).abs() < 1e-12);
        assert_eq!(at(46.0), 0.0);
        assert_eq!(at(120.0), 0.0);
    }

    #[test]
    fn fade_is_one_at_the_fade_distance_and_inverse_square_is_physical() {
        assert_eq!(fade(Fade::Pov { distance: 5.0, power: 2.0 }, 5.0), 1.0);
        assert!((fade(Fade::Pov { distance: 5.0, power: 2.0 }, 15.0) - 0.2).abs() < 1e-15);
        assert_eq!(fade(Fade::Pov { distance: 0.0, power: 2.0 }, 15.0), 1.0);
        assert!((fade(Fade::InverseSquare, 2.0) - 0.25).abs() < 1e-15);
    }

    #[test]
    fn cylinder_light_is_flat_inside_its_radius_and_dark_behind() {
        let kind = LightKind::Cylinder { radius: 1.0, falloff: 2.0, tightness: 0.0 };
        let light = Light { kind, parallel: true, point_at: DVec3::NEG_Y, ..Light::point(DVec3::ZERO, Vec3::ONE) };
        let at = |p: DVec3| attenuation(&light, &LightBeam::new(&light), p, &light_ray(&light, p, DVec3::ZERO));
        assert_eq!(at(DVec3::new(0.9, -4.0, 0.0)), 1.0);
        assert_eq!(at(DVec3::new(0.0, 4.0, 0.0)), 0.0);
        assert!((at(DVec3::new(1.5, -4.0, 0.0)) - 0.5).abs() < 1e-12, "halfway of a smoothstep");
        assert_eq!(at(DVec3::new(2.1, -4.0, 0.0)), 0.0);
    }

    #[test]
    fn parallel_light_behind_its_plane_has_negative_distance() {
        let light = Light { parallel: true, point_at: DVec3::NEG_Y, ..Light::point(DVec3::ZERO, Vec3::ONE) };
        let r = light_ray(&light, DVec3::new(3.0, 2.0, 0.0), DVec3::ZERO);
        assert_eq!((r.dir, r.distance), (DVec3::Y, -2.0));
    }

    #[test]
    fn ways_together_are_those_one_by_one() {
        let light = Light::point(DVec3::new(3.0, 40.0, -7.0), Vec3::ONE);
        let at = |k: usize| DVec3::new(0.37 * k as f64, -1.1, (k * k) as f64 * 0.013);
        let (mut v, mut length) = ([[0.0; 16]; 3], [0.0; 16]);
        for k in 0..15 {
            let to = light.location - at(k);
            (v[0][k], v[1][k], v[2][k]) = if k == 7 { (0.0, 0.0, 0.0) } else { to.into() };
        }
        unit_ways(&mut v, &mut length, 15);
        for k in 0..15 {
            let way = light_ray(&light, if k == 7 { light.location } else { at(k) }, DVec3::ZERO);
            assert_eq!((DVec3::new(v[0][k], v[1][k], v[2][k]), length[k]), (way.dir, way.distance));
        }
    }

    #[test]
    fn corner_of_a_circular_grid_lies_on_the_disc() {
        let area = AreaLight {
            axis1: DVec3::X * 4.0,
            axis2: DVec3::Z * 4.0,
            n1: 5,
            n2: 5,
            adaptive: 100,
            jitter: false,
            circular: true,
            orient: false,
            area_illumination: false,
        };
        let corner = area_offset(&area, area_axes(&area, DVec3::Y), 4.0, 4.0);
        assert!((corner.length() - 2.0).abs() < 0.01, "{corner}");
    }
}
