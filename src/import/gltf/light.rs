//! KHR_lights_punctual. Lamps shine along -z of their node; its scale does not matter.

use super::super::ImportError;
use super::Document;
use crate::diag::Sink;
use crate::math::{DAffine3, DVec3, Transform, Vec3};
use crate::scene::lamp::LampShape;
use crate::scene::light::{Fade, LightKind};
use crate::scene::{Lamp, Light};
use ::gltf::json;
use ::gltf::json::extensions::scene::khr_lights_punctual::Type;
use ::gltf::json::validation::Checked;
use glam::DQuat;

/// Luminous efficacy that Blender multiplies the radiant power of lamps by (measured: 60 W leave as 60 * 683 / 4 pi cd).
const BLENDER_LUMENS_PER_WATT: f64 = 683.0;

/// How the numbers of a file's lamps are meant.
#[derive(Clone, Copy, Debug)]
pub(super) struct Units {
    /// Intensities are divided by this.
    per_unit: f64,
    /// Cones blend as Blender's do.
    blender_cones: bool,
}

impl Units {
    /// Of a file that `generator` wrote.
    pub fn of(generator: Option<&str>, lumens_per_watt: Option<f64>, sink: &mut Sink) -> Self {
        let blender = generator.is_some_and(|g| g.contains("Blender"));
        let per_unit = lumens_per_watt.unwrap_or(if blender { BLENDER_LUMENS_PER_WATT } else { 1.0 });
        if blender && lumens_per_watt.is_none() {
            let message = "Blender wrote this file: its lamps are taken as candela and lux of 683 lm/W, its emission as watts";
            sink.note_once("gltf: Blender's lamps", None, message);
        }
        Self { per_unit, blender_cones: blender }
    }
}

/// The lamp of a node.
pub(super) fn light(doc: &Document, ix: usize, world: &DAffine3, units: Units) -> Result<Light, ImportError> {
    let place = || format!("light {ix}");
    let table: &[_] = doc.root.extensions.as_ref().and_then(|e| e.khr_lights_punctual.as_ref()).map_or(&[], |l| &l.lights);
    let record: &json::extensions::scene::khr_lights_punctual::Light = doc.get(table, ix, "light", place)?;
    let Checked::Valid(kind) = record.type_ else { return Err(doc.invalid(place(), "its type is unknown")) };
    let color = Vec3::from_array(record.color) * (f64::from(record.intensity) / units.per_unit) as f32;
    if !color.is_finite() {
        return Err(doc.invalid(place(), "its colour or intensity is not finite"));
    }
    let location = world.translation;
    let direction = world.transform_vector3(DVec3::NEG_Z).try_normalize().unwrap_or(DVec3::NEG_Z);
    let shining = Light { fade: Fade::InverseSquare, point_at: location + direction, ..Light::point(location, color) };
    // The path integrator's: without size, looking along -z of a place of its own.
    let turn = DQuat::from_rotation_arc(DVec3::NEG_Z, direction);
    let place = Transform::from_affine(DAffine3::from_rotation_translation(turn, location));
    let lamp = |shape, power: Vec3| place.map(|place| Box::new(Lamp::new(shape, power, place)));
    let watts = color * (4.0 * std::f32::consts::PI);
    Ok(match kind {
        Type::Point => Light { lamp: lamp(LampShape::Point { radius: 0.0, soft_falloff: false }, watts), ..shining },
        Type::Directional => {
            let lamp = lamp(LampShape::Sun { angle_rad: 0.0 }, color);
            Light { kind: LightKind::Sun { direction, angle_rad: 0.0 }, fade: Fade::None, lamp, ..shining }
        }
        Type::Spot => {
            let (inner, outer) =
                record.spot.as_ref().map_or((0.0, std::f32::consts::FRAC_PI_4), |s| (s.inner_cone_angle, s.outer_cone_angle));
            let outer = f64::from(outer).clamp(1e-4, std::f64::consts::FRAC_PI_2);
            let inner = f64::from(inner).clamp(0.0, outer);
            // Blender writes inner = outer * (1 - blend); Cycles' edge reaches over that share of 1 - cos(outer).
            let blend_cos = outer.cos() + (1.0 - outer.cos()) * (1.0 - inner / outer);
            let blend = if units.blender_cones { 1.0 - inner / outer } else { (inner.cos() - outer.cos()) / (1.0 - outer.cos()) };
            let shape = LampShape::Spot { radius: 0.0, soft_falloff: false, angle_rad: 2.0 * outer, blend: blend.clamp(0.0, 1.0) };
            let inner = if units.blender_cones { blend_cos.min(1.0).acos() } else { inner };
            // 0 would mean "no soft edge".
            let kind = LightKind::Spot { radius_rad: inner.clamp(1e-6, outer), falloff_rad: outer, tightness: 0.0 };
            Light { kind, lamp: lamp(shape, watts), ..shining }
        }
    })
}
