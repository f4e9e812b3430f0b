//! What a file may lack: a camera that sees everything, light to see it by.

use super::{ImportOptions, Imported};
use crate::diag::Sink;
use crate::math::{Bounds, DVec3, Rgbft, Vec3};
use crate::scene::light::LightKind;
use crate::scene::{Camera, Light, Mesh, Object, Projection, Scene, Shape, Texture};
use std::collections::HashMap;
use std::sync::Arc;

/// Where the stand-in camera looks from: a little from the right and from above, in front of glTF's front (+z). Picked by feel.
const VIEW_FROM: DVec3 = DVec3::new(0.55, 0.4, 1.0);
/// Its vertical angle in radians (40°).
const VIEW_ANGLE: f64 = 0.698;
/// Room around the model, as a factor.
const MARGIN: f64 = 1.06;

/// Adds camera and light where the file has none, and says so.
pub(super) fn complete(imported: &mut Imported, options: &ImportOptions, sink: &mut Sink) {
    let Imported { scene, has_camera } = imported;
    if scene.objects.is_empty() {
        sink.note_once("import: nothing to see", None, "the file has no surfaces; the picture will be empty");
    }
    if !*has_camera {
        scene.camera = framing_camera(&outline(scene), options.aspect);
        sink.note_once("import: no camera", None, "the file has no camera; the view frames all that it holds");
    }
    // A file that says what lies behind everything means the dark where it says black.
    if scene.environment.is_none() && scene.lights.is_empty() && !scene.objects.iter().any(shines) {
        add_default_light(scene);
        let message = "the file has neither lamps nor shining surfaces; it is lit from over the viewer's shoulder under a grey sky";
        sink.note_once("import: no light", None, message);
    }
}

fn shines(object: &Object) -> bool {
    matches!(object.texture.as_deref(), Some(Texture::Principled(p)) if p.is_emitter())
}

/// Most vertices that are looked at one by one; beyond, the corners of the objects' boxes stand for them.
const MAX_POINTS: usize = 1 << 23;

/// Points whose hull holds all that is to be seen.
fn outline(scene: &Scene) -> Vec<DVec3> {
    let meshes = || scene.objects.iter().filter_map(|o| if let Shape::Mesh(m) = &o.shape { Some((m, &o.transform)) } else { None });
    if meshes().map(|(m, _)| m.vertices.len()).sum::<usize>() <= MAX_POINTS {
        return meshes().flat_map(|(m, t)| m.vertices.iter().map(|v| t.point(v.as_dvec3()))).collect();
    }
    let mut boxes: HashMap<*const Mesh, Bounds> = HashMap::new();
    let mut points = Vec::new();
    for (m, t) in meshes() {
        let b = boxes.entry(Arc::as_ptr(m)).or_insert_with(|| Bounds::from_points(m.vertices.iter().map(|v| v.as_dvec3())));
        points.extend(b.corners().map(|p| t.point(p)));
    }
    points
}

/// A camera that sees all of `points` in a picture of `aspect`.
fn framing_camera(points: &[DVec3], aspect: f64) -> Camera {
    let back = VIEW_FROM.normalize();
    let right = DVec3::Y.cross(back).normalize();
    let up = back.cross(right);
    let half_height = (VIEW_ANGLE / 2.0).tan();
    let half_width = half_height * aspect;
    let in_view = |p: &DVec3| DVec3::new(p.dot(right), p.dot(up), p.dot(back));
    let bounds = Bounds::from_points(points.iter().map(in_view));
    let bounds = if bounds.is_empty() { Bounds { min: DVec3::NEG_ONE, max: DVec3::ONE } } else { bounds };
    let center = bounds.center();
    // The nearest place from which every point lies inside the four sides of the view.
    let distance = points.iter().fold(0.0f64, |d, p| {
        let p = in_view(p) - center;
        d.max((p.x.abs() / half_width).max(p.y.abs() / half_height) * MARGIN + p.z)
    });
    let distance = if distance > 0.0 { distance } else { 1.0 };
    Camera {
        projection: Projection::Perspective,
        location: center.x * right + center.y * up + (center.z + distance) * back,
        direction: -back,
        right: right * (2.0 * half_width),
        up: up * (2.0 * half_height),
        ..Camera::default()
    }
}

/// A white surface that faces the viewer's shoulder comes out at about 0.9. Picked by feel.
fn add_default_light(scene: &mut Scene) {
    let unit = |v: DVec3| v.try_normalize().unwrap_or(DVec3::Z);
    let (view, right, up) = (unit(scene.camera.direction), unit(scene.camera.right), unit(scene.camera.up));
    let mut sun = |from: DVec3, irradiance: f32| {
        let kind = LightKind::Sun { direction: -unit(from), angle_rad: 0.0 };
        scene.lights.push(Light { kind, ..Light::point(DVec3::ZERO, Vec3::splat(irradiance)) });
    };
    sun(up - 0.8 * right - 0.7 * view, 2.6);
    sun(0.2 * up + right - 0.5 * view, 0.35);
    scene.background = Rgbft::rgb(0.1, 0.1, 0.1);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn framing_camera_sees_every_corner_and_wastes_little() {
        let boxes = [
            (Bounds { min: DVec3::new(-1.0, 0.0, -9.0), max: DVec3::new(2.0, 0.5, 4.0) }, 1.5),
            (Bounds { min: DVec3::splat(1000.0), max: DVec3::splat(1000.001) }, 0.4),
            (Bounds { min: DVec3::new(0.0, -50.0, 0.0), max: DVec3::new(0.1, 50.0, 0.1) }, 2.0),
        ];
        for (b, aspect) in boxes {
            let c = framing_camera(&b.corners(), aspect);
            let mut most = 0.0f64;
            for p in b.corners() {
                let d = p - c.location;
                let depth = d.dot(c.direction);
                assert!(depth > 0.0);
                let x = d.dot(c.right.normalize()) / depth / (0.5 * c.right.length());
                let y = d.dot(c.up.normalize()) / depth / (0.5 * c.up.length());
                most = most.max(x.abs()).max(y.abs());
            }
            assert!((0.85..1.0).contains(&most), "{b:?}: {most}");
        }
    }

    #[test]
    fn framing_camera_is_right_handed() {
        let c = framing_camera(&[DVec3::NEG_ONE, DVec3::ONE], 1.0);
        // Seen along -z, right is +x: right x up points back to the viewer.
        assert!(c.right.cross(c.up).dot(c.direction) < 0.0);
        assert!(c.right.x > 0.0 && c.up.y > 0.0);
    }
}
