//! Focal blur for the GPU: the camera's lens as words. Twin: `shaders/lens_rays.wesl`.

use super::buffers::real;
use crate::kernel::camera::CameraModel;
use crate::math::DVec3;
use crate::math::random::jitter_table;

/// Words of the lens, in the shader's order; `None` for cameras whose rays the host makes.
pub(super) fn lens_words(camera: &CameraModel) -> Option<Vec<u32>> {
    let lens = camera.lens.as_ref()?;
    let [location, direction, right, up] = camera.flat_frame()?;
    let (places, jitter, half_aperture, [x, y]) = lens.geometry();
    let size = camera.resolution();
    let vectors = [location, direction, right, up, x, y].into_iter().flat_map(|v: DVec3| v.to_array());
    let numbers = [size.x, size.y, lens.focal_factor, jitter, half_aperture];
    let all = vectors.chain(numbers).chain(jitter_table().iter().copied()).chain(places.iter().flatten().copied());
    Some(all.flat_map(real).collect())
}
