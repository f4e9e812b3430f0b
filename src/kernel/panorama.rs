//! Directions of Blender's panoramic cameras: a place of the picture to a direction of the camera's own space.
//!
//! Sources: the projections are the textbooks'; which way they run was measured with Cycles 4.5 (tests/scenes/path/camera).

use crate::math::{DVec2, DVec3};
use crate::scene::camera::Panorama;

/// The direction (x right, y up, z forward; unit) at screen place `s` (-0.5..=0.5, y up); `None` where the projection shows nothing.
pub fn direction(panorama: &Panorama, s: DVec2) -> Option<DVec3> {
    let within = |[low, high]: [f64; 2], t: f64| low + (t + 0.5) * (high - low);
    match *panorama {
        Panorama::Equirectangular { longitude, latitude } => {
            let (along, up) = (within(longitude, s.x), within(latitude, s.y));
            Some(DVec3::new(along.sin() * up.cos(), up.sin(), along.cos() * up.cos()))
        }
        Panorama::Equisolid { lens, angle_rad, sensor } => {
            let p = s * DVec2::from_array(sensor);
            let sin = p.length() / (2.0 * lens);
            (sin <= (0.25 * angle_rad).sin()).then(|| from_axis(p, 2.0 * sin.clamp(0.0, 1.0).asin()))
        }
        Panorama::Polynomial { coefficients: [k0, k1, k2, k3, k4], angle_rad, sensor } => {
            let p = s * DVec2::from_array(sensor);
            let r = p.length();
            let angle = -(k0 + r * (k1 + r * (k2 + r * (k3 + r * k4))));
            (angle.abs() <= 0.5 * angle_rad).then(|| from_axis(p, angle))
        }
        Panorama::MirrorBall => {
            // Parallel rays, mirrored by the ball.
            let p = 2.0 * s;
            let towards = (1.0 - p.length_squared()).max(0.0).sqrt();
            (p.length_squared() <= 1.0).then(|| DVec3::new(2.0 * towards * p.x, 2.0 * towards * p.y, 2.0 * towards * towards - 1.0))
        }
        Panorama::Cylinder { longitude, height, radius } => {
            let (along, up) = (within(longitude, s.x), within(height, s.y));
            Some(DVec3::new(along.sin(), up / radius, along.cos()).normalize())
        }
    }
}

/// `angle` from the axis, towards `p`.
fn from_axis(p: DVec2, angle: f64) -> DVec3 {
    let side = p.normalize_or_zero() * angle.sin();
    DVec3::new(side.x, side.y, angle.cos())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_2, PI};

    fn near(a: Option<DVec3>, b: DVec3) {
        let a = a.expect("the place shows something");
        assert!((a - b).length() < 1e-12, "{a} is not {b}");
    }

    #[test]
    fn every_panorama_looks_forward_in_its_middle_and_gives_unit_directions() {
        let whole = Panorama::Equirectangular { longitude: [-PI, PI], latitude: [-FRAC_PI_2, FRAC_PI_2] };
        let polynomial = Panorama::Polynomial { coefficients: [0.0, -0.02, 0.0, 0.0, 0.0], angle_rad: PI, sensor: [36.0, 27.0] };
        let all = [
            whole,
            Panorama::Equisolid { lens: 10.5, angle_rad: PI, sensor: [36.0, 27.0] },
            polynomial,
            Panorama::MirrorBall,
            Panorama::Cylinder { longitude: [-PI, PI], height: [-1.0, 1.0], radius: 1.0 },
        ];
        for p in all {
            near(direction(&p, DVec2::ZERO), DVec3::Z);
            for k in 0..100 {
                let s = DVec2::new(f64::from(k % 10) / 10.0 - 0.45, f64::from(k / 10) / 10.0 - 0.45);
                if let Some(d) = direction(&p, s) {
                    assert!((d.length() - 1.0).abs() < 1e-12, "{p:?} at {s}");
                    // What is right of the middle looks right, and the same of above, while it looks forward.
                    assert!(d.z <= 0.0 || (d.x * s.x >= 0.0 && d.y * s.y >= 0.0), "{p:?} at {s}: {d}");
                }
            }
        }
    }

    #[test]
    fn the_borders_of_panoramas_are_where_they_should_be() {
        let part = Panorama::Equirectangular { longitude: [-0.3, FRAC_PI_2], latitude: [-0.2, 0.4] };
        near(direction(&part, DVec2::new(0.5, -0.5)), DVec3::new(0.2f64.cos(), -0.2f64.sin(), 0.0));
        // At half the sensor's width: 9 = 2 · 9 · sin(60° / 2).
        let fish = Panorama::Equisolid { lens: 9.0, angle_rad: PI, sensor: [18.0, 18.0] };
        near(direction(&fish, DVec2::new(0.5, 0.0)), DVec3::new(3f64.sqrt() / 2.0, 0.0, 0.5));
        assert!(direction(&Panorama::Equisolid { lens: 9.0, angle_rad: 1.0, sensor: [18.0, 18.0] }, DVec2::new(0.5, 0.0)).is_none());
        // A mirror ball shows what is beside it at 1 / sqrt(2) of its radius, what is behind it at its rim.
        near(direction(&Panorama::MirrorBall, DVec2::new(0.0, 0.125f64.sqrt())), DVec3::Y);
        near(direction(&Panorama::MirrorBall, DVec2::new(0.5, 0.0)), DVec3::NEG_Z);
        assert!(direction(&Panorama::MirrorBall, DVec2::new(0.4, 0.4)).is_none());
    }
}
