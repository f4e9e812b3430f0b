//! Blender's cameras: sensor, fit, shift, lens, panoramas.

use super::super::super::ImportError;
use super::super::Document;
use super::record::Record;
use super::{NAME, part};
use crate::diag::Sink;
use crate::math::{DAffine3, DVec3};
use crate::scene::camera::{CameraPose, Lens, Panorama};
use crate::scene::{Camera, Projection};
use std::f64::consts::PI;

/// Which side of the picture the sensor's size is along.
#[derive(Clone, Copy, PartialEq)]
enum Fit {
    Auto,
    Horizontal,
    Vertical,
}

/// Camera `ix` at a place, for a picture of `aspect`; `None` when the file has no record of the extension for it.
pub(in super::super) fn camera(
    doc: &Document,
    ix: usize,
    world: &DAffine3,
    aspect: f64,
    sink: &mut Sink,
) -> Result<Option<Camera>, ImportError> {
    let record = doc.root.cameras.get(ix).and_then(|c| part(c.extensions.as_ref().map(|e| &e.others)));
    let Some(value) = record else { return Ok(None) };
    let r = Record::new(doc, value, format!("cameras[{ix}].extensions.{NAME}"))?;
    let Some([x, y, z]) = axes(world) else { return Err(r.wrong("type", "its node has no extent")) };
    let kind = r.text("type")?.unwrap_or("perspective");
    let lens_mm = r.positive_or("lens", 50.0)?.max(1e-3);
    let (sensor_width, sensor_height) = (r.positive_or("sensorWidth", 36.0)?, r.positive_or("sensorHeight", 24.0)?);
    let fits = [("auto", Fit::Auto), ("horizontal", Fit::Horizontal), ("vertical", Fit::Vertical)];
    let fit = r.choice("sensorFit", Fit::Auto, &fits)?;
    let horizontal = fit == Fit::Horizontal || (fit == Fit::Auto && aspect >= 1.0);
    let sensor = if fit == Fit::Vertical { sensor_height } else { sensor_width };
    let scale = r.positive_or("orthoScale", 6.0)?;
    let shift = r.numbers::<2>("shift")?.unwrap_or_default();
    let clip = r.numbers::<2>("clip")?;
    let fitted = if kind == "orthographic" { scale } else { sensor / lens_mm };
    if fitted <= 0.0 {
        return Err(r.wrong("sensorWidth", "the picture has no width"));
    }
    let (width, height) = if horizontal { (fitted, fitted / aspect) } else { (fitted * aspect, fitted) };
    let moved = x * (shift[0] * fitted) + y * (shift[1] * fitted);
    let mut camera = Camera {
        projection: Projection::Perspective,
        location: world.translation,
        direction: -z + moved,
        right: x * width,
        up: y * height,
        ..Camera::default()
    };
    let mut opening = lens_mm * 1e-3;
    match kind {
        "perspective" => {}
        "orthographic" => {
            camera.projection = Projection::Orthographic;
            camera.location += moved;
            camera.direction = -z;
            opening = 1.0;
        }
        "panorama" => {
            let film = if horizontal { [sensor, sensor / aspect] } else { [sensor * aspect, sensor] };
            (camera.projection, camera.direction, camera.right, camera.up) = (panorama(&r, film, sink)?, -z, x, y);
        }
        other => return Err(r.wrong("type", format!("'{other}' is none of perspective, orthographic, panorama"))),
    }
    if kind != "panorama" {
        r.get("panorama");
    }
    if clip.is_some_and(|c| c[0] > 0.2) {
        sink.note_once("rayloom: clip", None, "the camera's near and far planes do not cut");
    }
    if let Some(d) = r.record("dof")? {
        let f_stop = d.positive_or("fStop", 2.8)?.max(1e-5);
        camera.lens = Some(Lens {
            radius: opening / (2.0 * f_stop),
            focus_distance: d.positive_or("focusDistance", 10.0)?.max(1e-5),
            blades: d.count_or("blades", 0)?,
            rotation_rad: d.number_or("rotation", 0.0)?,
            ratio: d.positive_or("ratio", 1.0)?.max(1e-3),
        });
        d.finish()?;
    }
    r.finish()?;
    Ok(Some(camera))
}

/// Unit axes of a node; `None` when one has no length.
fn axes(world: &DAffine3) -> Option<[DVec3; 3]> {
    let unit = |v: DVec3| world.transform_vector3(v).try_normalize();
    Some([unit(DVec3::X)?, unit(DVec3::Y)?, unit(DVec3::Z)?])
}

/// A panorama on a sensor of `width` x `height`, in millimetres.
fn panorama(r: &Record, [width, height]: [f64; 2], sink: &mut Sink) -> Result<Projection, ImportError> {
    let whole = |p: Option<&Record>| -> Result<Panorama, ImportError> {
        let range = |key: &str, default: [f64; 2]| p.map_or(Ok(None), |p| p.numbers::<2>(key)).map(|v| v.unwrap_or(default));
        Ok(Panorama::Equirectangular { longitude: range("longitude", [-PI, PI])?, latitude: range("latitude", [-PI / 2.0, PI / 2.0])? })
    };
    let Some(p) = r.record("panorama")? else { return Ok(Projection::Panorama(whole(None)?)) };
    let angle_rad = p.positive_or("fisheyeFov", PI)?;
    let lens = p.positive_or("fisheyeLens", 10.5)?.max(1e-3);
    let coefficients = p.numbers::<5>("polynomial")?.unwrap_or_default();
    let sensor = [width, height];
    let mut cylinder = Panorama::Cylinder { longitude: [-PI, PI], height: [-1.0, 1.0], radius: 1.0 };
    if let Some(c) = p.record("cylinder")? {
        let (longitude, height) = (c.numbers::<2>("longitude")?.unwrap_or([-PI, PI]), c.numbers::<2>("height")?.unwrap_or([-1.0, 1.0]));
        cylinder = Panorama::Cylinder { longitude, height, radius: c.positive_or("radius", 1.0)?.max(1e-6) };
        c.finish()?;
    }
    let all = whole(Some(&p))?;
    let panorama = match p.text("type")?.unwrap_or("equirectangular") {
        "equirectangular" => all,
        "fisheyeEquidistant" => {
            p.finish()?;
            return Ok(Projection::Fisheye { angle_rad });
        }
        "fisheyeEquisolid" => Panorama::Equisolid { lens, angle_rad, sensor },
        "fisheyePolynomial" => Panorama::Polynomial { coefficients, angle_rad, sensor },
        "mirrorBall" => Panorama::MirrorBall,
        "centralCylindrical" => cylinder,
        other => {
            sink.note_once("rayloom: panorama", None, format!("the panorama '{other}' is shown equirectangular"));
            all
        }
    };
    p.finish()?;
    Ok(Projection::Panorama(panorama))
}

/// The same camera at world matrices `keys`.
pub(in super::super) fn camera_motion(camera: &Camera, world: &DAffine3, keys: &[DAffine3]) -> Vec<CameraPose> {
    let Some(base) = axes(world) else { return Vec::new() };
    let in_camera = |v: DVec3| DVec3::new(v.dot(base[0]), v.dot(base[1]), v.dot(base[2]));
    let [direction, right, up, place] = [camera.direction, camera.right, camera.up, camera.location - world.translation].map(in_camera);
    let pose = |key: &DAffine3| -> Option<CameraPose> {
        let [x, y, z] = axes(key)?;
        let out = |v: DVec3| x * v.x + y * v.y + z * v.z;
        Some(CameraPose { location: key.translation + out(place), direction: out(direction), right: out(right), up: out(up) })
    };
    keys.iter().map(pose).collect::<Option<Vec<_>>>().unwrap_or_default()
}
