//! Lamps of all four kinds.

use super::super::super::ImportError;
use super::record::Record;
use crate::diag::Sink;
use crate::math::{DAffine3, DVec3, Transform, Vec3};
use crate::scene::lamp::LampShape;
use crate::scene::light::{Fade, LightKind};
use crate::scene::{Lamp, Light, Visibility};
use std::f64::consts::PI;

/// A lamp at a place; `None` for portals, which only guide sampling, and for lamps squeezed flat.
pub(super) fn light(r: &Record, world: &DAffine3, visibility: Visibility, sink: &mut Sink) -> Result<Option<Light>, ImportError> {
    r.text("name")?;
    let kind = r.needed("type", r.text("type")?)?;
    let color = r.numbers::<3>("color")?.unwrap_or([1.0; 3]);
    let mut power = Vec3::from(color.map(|c| c as f32)) * r.number_or("energy", 10.0)? as f32;
    if let Some(e) = r.record("emission")? {
        let tint = e.numbers::<3>("color")?.unwrap_or([1.0; 3]);
        power *= Vec3::from(tint.map(|c| c as f32)) * e.number_or("strength", 1.0)? as f32;
        e.finish()?;
    }
    let normalize = r.flag("normalize", true)?;
    // A disc of its radius, in square metres; points have none.
    let disc = |radius: f64| if radius > 0.0 { PI * radius * radius } else { 1.0 };
    let lengths = [world.matrix3.x_axis.length(), world.matrix3.y_axis.length()];
    let (shape, area) = match kind {
        "point" => {
            let radius = r.positive_or("radius", 0.0)?;
            (LampShape::Point { radius, soft_falloff: r.flag("softFalloff", true)? }, disc(radius))
        }
        "spot" => {
            let radius = r.positive_or("radius", 0.0)?;
            let angle_rad = r.positive_or("spotSize", PI / 4.0)?.clamp(1e-4, PI);
            let blend = r.positive_or("spotBlend", 0.15)?.min(1.0);
            (LampShape::Spot { radius, soft_falloff: r.flag("softFalloff", true)?, angle_rad, blend }, disc(radius))
        }
        "sun" => {
            let angle_rad = r.positive_or("angle", 0.0)?.min(PI);
            (LampShape::Sun { angle_rad }, disc((angle_rad / 2.0).tan()))
        }
        "area" => {
            let form = r.text("shape")?.unwrap_or("square");
            let ellipse = matches!(form, "disk" | "ellipse");
            if !ellipse && !matches!(form, "square" | "rectangle") {
                return Err(r.wrong("shape", format!("'{form}' is none of square, rectangle, disk, ellipse")));
            }
            let x = r.positive_or("size", 0.25)?;
            let y = if matches!(form, "rectangle" | "ellipse") { r.positive_or("sizeY", x)? } else { x };
            let spread_rad = r.positive_or("spread", PI)?.min(PI);
            let area = x * y * lengths[0] * lengths[1] * if ellipse { PI / 4.0 } else { 1.0 };
            (LampShape::Area { ellipse, size: [x, y], spread_rad }, area)
        }
        other => return Err(r.wrong("type", format!("'{other}' is none of point, sun, spot, area"))),
    };
    if !normalize {
        power *= area as f32;
    }
    let portal = r.flag("portal", false)?;
    let cast_shadow = r.flag("castShadow", true)?;
    let multiple_importance = r.flag("importance", true)?;
    let max_bounces = r.count_or("maxBounces", 1024)?;
    r.number("temperature")?;
    if r.text("ies")?.is_some() {
        sink.note_once("rayloom: ies", None, "IES profiles of lamps are left out");
    }
    r.finish()?;
    let transform = Transform::from_affine(*world).filter(|_| world.matrix3.determinant() != 0.0);
    let (Some(transform), false) = (transform, portal) else { return Ok(None) };
    let lamp = Lamp {
        visibility: visibility.without(Visibility::CAMERA),
        cast_shadow,
        multiple_importance,
        max_bounces,
        ..Lamp::new(shape, power, transform)
    };
    Ok(Some(likeness(lamp)))
}

/// The lamp as the classic integrator draws it: points of the same power, without size.
fn likeness(lamp: Lamp) -> Light {
    let location = lamp.transform.point(DVec3::ZERO);
    let direction = lamp.transform.vector(DVec3::NEG_Z).normalize();
    let candela = lamp.power / (4.0 * std::f32::consts::PI);
    let shining = Light { fade: Fade::InverseSquare, point_at: location + direction, ..Light::point(location, candela) };
    let light = match lamp.shape {
        LampShape::Point { radius, .. } => Light { radius, ..shining },
        LampShape::Spot { angle_rad, blend, .. } => {
            let outer = angle_rad / 2.0;
            let inner = (outer.cos() + (1.0 - outer.cos()) * blend).min(1.0).acos();
            let kind = LightKind::Spot { radius_rad: inner.clamp(1e-6, outer), falloff_rad: outer, tightness: 0.0 };
            Light { kind, ..shining }
        }
        LampShape::Sun { angle_rad } => {
            Light { kind: LightKind::Sun { direction, angle_rad }, fade: Fade::None, color: lamp.power, ..shining }
        }
        // Along its axis an area shines with power / π: a wide spot of that strength.
        LampShape::Area { .. } => {
            let falloff_rad = std::f64::consts::FRAC_PI_2;
            let kind = LightKind::Spot { radius_rad: 1e-6, falloff_rad, tightness: 0.0 };
            Light { kind, color: candela * 4.0, ..shining }
        }
    };
    Light { lamp: Some(Box::new(lamp)), ..light }
}
