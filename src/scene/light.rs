//! Light sources.

use super::{Lamp, Object};
use crate::math::{DVec3, Rgb, Transform};

/// Shape of a light's beam. Angles are half angles in radians, lengths in scene units. Source: spec/light.md, section 6.
#[derive(Clone, Debug, PartialEq)]
#[expect(missing_docs, reason = "the names of the fields say it")]
pub enum LightKind {
    /// Shines everywhere from its location.
    Point,
    /// A cone towards `point_at`.
    Spot { radius_rad: f64, falloff_rad: f64, tightness: f64 },
    /// A beam towards `point_at`.
    Cylinder { radius: f64, falloff: f64, tightness: f64 },
    /// Parallel light from infinity, along `direction` (unit, the way the light travels). Imports only.
    Sun { direction: DVec3, angle_rad: f64 },
}

/// How light weakens with distance `d`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(missing_docs, reason = "the names of the fields say it")]
pub enum Fade {
    /// Not at all.
    None,
    /// POV-Ray: 2 / (1 + (d/distance)^power).
    Pov { distance: f64, power: f64 },
    /// Physical: 1 / d². Imports only.
    InverseSquare,
}

/// A grid of points in place of one.
#[derive(Clone, Debug, PartialEq)]
pub struct AreaLight {
    /// First axis, whole length.
    pub axis1: DVec3,
    /// Second axis, whole length.
    pub axis2: DVec3,
    /// Points along the first axis.
    pub n1: u32,
    /// Points along the second axis.
    pub n2: u32,
    /// Forced subdivision depth; 100 when not given.
    pub adaptive: u32,
    /// Random shift by half a cell.
    pub jitter: bool,
    /// A disc in place of a rectangle.
    pub circular: bool,
    /// Faces the lit point.
    pub orient: bool,
    /// Shade from every point, not only shadow.
    pub area_illumination: bool,
}

/// A light source in its parent's space.
#[derive(Clone, Debug)]
pub struct Light {
    /// Beam.
    pub kind: LightKind,
    /// Centre.
    pub location: DVec3,
    /// Target of spot, cylinder and parallel lights.
    pub point_at: DVec3,
    /// Colour: radiance units of the working space (POV-Ray), or candela (imports, point and spot), or irradiance (sun).
    pub color: Rgb,
    /// Rays are parallel to `point_at - location`.
    pub parallel: bool,
    /// Soft shadow grid.
    pub area: Option<AreaLight>,
    /// Weakening with distance.
    pub fade: Fade,
    /// Casts no shadows and gives no highlights.
    pub shadowless: bool,
    /// Atmospheric media and fog weaken it.
    pub media_attenuation: bool,
    /// Lights media.
    pub media_interaction: bool,
    /// Light passes only through this object.
    pub projected_through: Option<Box<Object>>,
    /// Seen at the light's place; already moved there, casts no shadow.
    pub looks_like: Option<Box<Object>>,
    /// Photon switches: reflection, refraction (`None` when not said), from the whole area.
    pub photons: (Option<bool>, Option<bool>, bool),
    /// Radius of the emitting sphere (imports), 0 for a point.
    pub radius: f64,
    /// What the path integrator makes of it; `None`: what the fields above say.
    pub lamp: Option<Box<Lamp>>,
}

impl Light {
    /// A white point light.
    pub fn point(location: DVec3, color: Rgb) -> Self {
        Self {
            kind: LightKind::Point,
            location,
            point_at: DVec3::Z,
            color,
            parallel: false,
            area: None,
            fade: Fade::None,
            shadowless: false,
            media_attenuation: false,
            media_interaction: true,
            projected_through: None,
            looks_like: None,
            photons: (None, None, false),
            radius: 0.0,
            lamp: None,
        }
    }

    /// Moves the light and what belongs to it. Beam widths and fade distances stay as written, as in POV-Ray.
    pub fn transform(&mut self, t: &Transform) {
        self.location = t.point(self.location);
        self.point_at = t.point(self.point_at);
        if let LightKind::Sun { direction, .. } = &mut self.kind {
            *direction = t.vector(*direction).normalize();
        }
        if let Some(lamp) = &mut self.lamp {
            lamp.transform = lamp.transform.then(t);
        }
        if let Some(a) = &mut self.area {
            a.axis1 = t.vector(a.axis1);
            a.axis2 = t.vector(a.axis2);
        }
        for o in [&mut self.projected_through, &mut self.looks_like].into_iter().flatten() {
            o.apply_transform(t);
        }
    }
}
