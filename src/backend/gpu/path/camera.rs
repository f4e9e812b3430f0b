//! The camera as numbers and words. Twins: `shaders/path/camera.wesl`, `shaders/path/panorama.wesl`.

use super::super::buffers::{append, bits, v3};
use super::super::layout::PathParams;
use super::inputs::Encoder;
use crate::compile::CompiledScene;
use crate::integrate::path::PathPlan;
use crate::math::DVec3;
use crate::scene::Projection;
use crate::scene::camera::Panorama;

const PANORAMAS: [&str; 6] = ["EQUIRECTANGULAR", "EQUISOLID", "POLYNOMIAL", "BALL", "CYLINDER", "FISHEYE"];

/// Names and numbers for the shaders.
pub(super) fn panorama_constants() -> Vec<(String, u32)> {
    (0..).zip(PANORAMAS).map(|(k, n)| (format!("PANORAMA_IS_{n}"), k)).collect()
}

/// Numbers of the camera, and limits.
pub(super) fn camera_params(scene: &CompiledScene, plan: &PathPlan, [width, height]: [u32; 2]) -> PathParams {
    let (c, s) = (&scene.camera, &plan.settings);
    let mut p = PathParams {
        location: v3(c.location),
        direction: v3(c.direction),
        right: v3(c.right),
        up: v3(c.up),
        width: width as f32,
        height: height as f32,
        seed: plan.seed,
        max_bounces: s.max_bounces,
        diffuse_bounces: s.diffuse_bounces,
        glossy_bounces: s.glossy_bounces,
        transmission_bounces: s.transmission_bounces,
        volume_bounces: s.volume_bounces,
        transparent_bounces: s.transparent_bounces,
        min_light_bounces: s.min_light_bounces,
        min_transparent_bounces: s.min_transparent_bounces,
        clamp_direct: s.clamp_direct,
        clamp_indirect: s.clamp_indirect,
        filter_glossy: s.filter_glossy,
        exposure: s.exposure,
        ..PathParams::default()
    };
    if let Some(l) = plan.camera.lens() {
        p.lens_radius = l.radius as f32;
        p.focus_distance = l.focus_distance as f32;
        p.lens_blades = l.blades;
        p.lens_rotation = l.rotation_rad as f32;
        p.lens_ratio = l.ratio as f32;
    }
    p
}

/// What a camera has beyond those: a projection of its own, places at other times.
pub(super) fn camera_words(scene: &CompiledScene, e: &mut Encoder, p: &mut PathParams) {
    let c = &scene.camera;
    let panorama = match c.projection {
        Projection::Panorama(panorama) => Some(match panorama {
            Panorama::Equirectangular { longitude, latitude } => (0, [longitude, latitude].concat()),
            Panorama::Equisolid { lens, angle_rad, sensor } => (1, [&[lens, angle_rad][..], &sensor].concat()),
            Panorama::Polynomial { coefficients, angle_rad, sensor } => (2, [&coefficients[..], &[angle_rad], &sensor].concat()),
            Panorama::MirrorBall => (3, Vec::new()),
            Panorama::Cylinder { longitude, height, radius } => (4, [&longitude[..], &height, &[radius]].concat()),
        }),
        Projection::Fisheye { angle_rad } => Some((5, vec![c.right.length(), c.up.length(), angle_rad])),
        _ => None,
    };
    if let Some((kind, numbers)) = panorama {
        e.features.insert("panorama");
        p.camera_at = append(&mut e.words, std::iter::once(kind).chain(numbers.iter().map(|v| (*v as f32).to_bits())));
        let unit = |v: DVec3| v3(v.try_normalize().unwrap_or(DVec3::Z));
        (p.direction, p.right, p.up) = (unit(c.direction), unit(c.right), unit(c.up));
    } else if c.motion.len() > 1 {
        e.features.insert("camera_motion");
        let poses = c.motion.iter().flat_map(|m| [m.location, m.direction, m.right, m.up]).flat_map(|v| bits(v3(v)));
        let n = c.motion.len() as u32 - 1;
        p.poses_at = append(&mut e.words, std::iter::once(n).chain(poses));
    }
}
