//! Cameras. glTF's look along -z with +x to the right and +y up. Source: glTF 2.0, section 3.10.

use super::super::ImportError;
use super::Document;
use crate::math::{DAffine3, DVec3};
use crate::scene::{Camera, Projection};
use ::gltf::json;

/// The camera of a node, for a picture of `aspect`: what the file's own picture shows stays in view. A picture that is wider than
/// the file's keeps its height, one that is narrower keeps its width.
pub(super) fn camera(doc: &Document, ix: usize, world: &DAffine3, aspect: f64) -> Result<Camera, ImportError> {
    let place = || format!("camera {ix}");
    let record: &json::Camera = doc.get(&doc.root.cameras, ix, "camera", place)?;
    let unit = |v: DVec3| world.transform_vector3(v).try_normalize().ok_or_else(|| doc.invalid(place(), "its node has no extent"));
    let (right, up, view) = (unit(DVec3::X)?, unit(DVec3::Y)?, unit(DVec3::NEG_Z)?);
    let positive = |v: f32, what: &str| {
        let v = f64::from(v.abs());
        if v.is_finite() && v > 0.0 { Ok(v) } else { Err(doc.invalid(place(), format!("its {what} is not positive"))) }
    };
    let (projection, width, height) = match (&record.perspective, &record.orthographic) {
        (Some(p), _) => {
            let angle = positive(p.yfov, "yfov")?;
            if angle >= std::f64::consts::PI {
                return Err(doc.invalid(place(), "its yfov is 180 degrees or more"));
            }
            let height = 2.0 * (0.5 * angle).tan();
            let own = match p.aspect_ratio {
                Some(a) => positive(a, "aspectRatio")?,
                None => aspect,
            };
            let (w, h) = fitted(height * own, height, aspect);
            (Projection::Perspective, w, h)
        }
        (None, Some(o)) => {
            let (w, h) = fitted(2.0 * positive(o.xmag, "xmag")?, 2.0 * positive(o.ymag, "ymag")?, aspect);
            (Projection::Orthographic, w, h)
        }
        (None, None) => return Err(doc.invalid(place(), "it is neither perspective nor orthographic")),
    };
    Ok(Camera { projection, location: world.translation, direction: view, right: right * width, up: up * height, ..Camera::default() })
}

/// Width and height of the smallest window of `aspect` that holds `width` x `height`.
fn fitted(width: f64, height: f64, aspect: f64) -> (f64, f64) {
    if aspect >= width / height { (height * aspect, height) } else { (width, width / aspect) }
}
