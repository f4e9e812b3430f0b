//! Cameras whose rays the device makes, as words. Twins: `shaders/shared/camera.wesl`, `shaders/lens_rays.wesl`, `shaders/lens_sums.wesl`.

use super::buffers::{append, real};
use super::camera::CameraRays;
use super::shader::ShaderOptions;
use crate::compile::CompiledScene;
use crate::integrate::classic::ScenePlan;
use crate::kernel::camera::CameraModel;
use crate::kernel::lens::Lens;
use crate::math::DVec3;
use crate::math::random::jitter_table;
use crate::scene::Projection;

/// Which rays of the camera the device makes, where it has numbers of 64 bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum DeviceCamera {
    /// None: the host does.
    None,
    /// One a place.
    Plain,
    /// Samples of its lens.
    Lens,
}

/// Appends the words of the camera and gives their places and what they are to the shaders.
pub(super) fn camera_words(scene: &CompiledScene, plan: &ScenePlan, words: &mut Vec<u32>, o: &mut ShaderOptions) -> DeviceCamera {
    let (camera, rays) = (&plan.camera, CameraRays::new(scene, plan));
    let (mut camera_at, mut lens_at, mut thresholds_at) = (0, 0, 0);
    let mut kind = DeviceCamera::None;
    if let (true, Some((feature, angles))) = (rays.is_unwatched() && camera.normal_ix.is_none(), projection(camera)) {
        let mut frame = camera.frame();
        if camera.lens.is_some() && feature == "camera_orthographic" {
            // Parallel rays.
            (frame[2], frame[3]) = (DVec3::ZERO, DVec3::ZERO);
        }
        let (size, resolution) = (camera.size(), camera.resolution());
        let of_box = rays.start_box().map_or([DVec3::ZERO; 2], |b| [b.min, b.max]);
        let numbers = [size.x, size.y, resolution.x, resolution.y, angles[0], angles[1]];
        let all = frame.into_iter().flat_map(|v| v.to_array()).chain(numbers).chain(of_box.into_iter().flat_map(|v| v.to_array()));
        camera_at = append(words, all.flat_map(real));
        o.feature(feature);
        o.feature_if("camera_angles", !FLAT.contains(&feature));
        o.feature_if("start_box", rays.start_box().is_some());
        kind = DeviceCamera::Plain;
        if let Some(lens) = &camera.lens {
            lens_at = append(words, lens_words(lens));
            thresholds_at = append(words, lens.thresholds().iter().copied().flat_map(real));
            kind = DeviceCamera::Lens;
        }
    }
    o.constant("CAMERA_AT", camera_at);
    o.constant("LENS_AT", lens_at);
    o.constant("LENS_THRESHOLDS_AT", thresholds_at);
    o.constant("LENS_SAMPLES", camera.lens.as_ref().map_or(1, Lens::max_samples));
    o.constant("LENS_MIN_SAMPLES", camera.lens.as_ref().map_or(0, |lens| lens.min_samples));
    kind
}

/// Projections without angles.
const FLAT: [&str; 2] = ["camera_perspective", "camera_orthographic"];

/// Name of the shader's feature for a projection, and its angles; `None` for those whose rays the host makes.
fn projection(camera: &CameraModel) -> Option<(&'static str, [f64; 2])> {
    let found = match *camera.projection() {
        Projection::Perspective => ("camera_perspective", [0.0; 2]),
        Projection::Orthographic => ("camera_orthographic", [0.0; 2]),
        Projection::Fisheye { angle_rad } => ("camera_fisheye", [angle_rad; 2]),
        Projection::UltraWideAngle { angle_rad } => ("camera_ultra_wide_angle", [angle_rad; 2]),
        Projection::Omnimax => ("camera_omnimax", [0.0; 2]),
        Projection::Panoramic => ("camera_panoramic", [0.0; 2]),
        Projection::Spherical { horizontal_rad, vertical_rad } => ("camera_spherical", [horizontal_rad, vertical_rad]),
        Projection::Cylinder { kind, angle_rad } => {
            let name = match kind {
                1 => "camera_cylinder1",
                2 => "camera_cylinder2",
                3 => "camera_cylinder3",
                _ => "camera_cylinder4",
            };
            (name, [angle_rad; 2])
        }
        Projection::Panorama(_) | Projection::Mesh { .. } => return None,
    };
    (camera.lens.is_none() || FLAT.contains(&found.0)).then_some(found)
}

/// Words of the lens, in the shader's order.
fn lens_words(lens: &Lens) -> Vec<u32> {
    let (places, jitter, half_aperture, [x, y]) = lens.geometry();
    let vectors = [x, y].into_iter().flat_map(|v: DVec3| v.to_array());
    let numbers = [lens.focal_factor, jitter, half_aperture];
    let all = vectors.chain(numbers).chain(jitter_table().iter().copied()).chain(places.iter().flatten().copied());
    all.flat_map(real).collect()
}
