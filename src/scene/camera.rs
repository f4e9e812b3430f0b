//! The camera, with its vectors resolved.

use super::{Normal, Object, Pigment};
use crate::math::{DVec3, Transform};
use std::sync::Arc;

/// How picture points become rays. Source: spec/textures.md, section 8.
#[derive(Clone, Debug)]
#[expect(missing_docs, reason = "the fields say their unit")]
pub enum Projection {
    /// Through a point.
    Perspective,
    /// Parallel rays from the picture plane.
    Orthographic,
    /// Full angle in radians.
    Fisheye { angle_rad: f64 },
    /// Full angle in radians.
    UltraWideAngle { angle_rad: f64 },
    /// Dome projection; the angle is fixed.
    Omnimax,
    /// Cylinder with a tangent height.
    Panoramic,
    /// Equirectangular; full angles in radians.
    Spherical { horizontal_rad: f64, vertical_rad: f64 },
    /// POV-Ray's four cylinder cameras.
    Cylinder { kind: u8, angle_rad: f64 },
    /// Blender's panoramas.
    Panorama(Panorama),
    /// Rays start on the faces of meshes.
    Mesh { n_rays: u32, distribution: u8, max_distance: f64, meshes: Vec<Object>, smooth: bool },
}

/// Blender's panoramic cameras, along `direction`; longitudes grow to the right, latitudes upwards, both from the middle.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(missing_docs, reason = "the fields say their unit")]
pub enum Panorama {
    /// Angles from left to right and from bottom to top, in radians.
    Equirectangular { longitude: [f64; 2], latitude: [f64; 2] },
    /// A fisheye of equal areas. Lens and sensor (width, height) in one unit, the full angle that it sees.
    Equisolid { lens: f64, angle_rad: f64, sensor: [f64; 2] },
    /// A fisheye whose angle is minus a polynomial in the distance from the middle of the sensor (width, height), in its unit.
    Polynomial { coefficients: [f64; 5], angle_rad: f64, sensor: [f64; 2] },
    /// A mirror ball seen from far away.
    MirrorBall,
    /// A cylinder around the camera: angles from left to right, heights from bottom to top.
    Cylinder { longitude: [f64; 2], height: [f64; 2], radius: f64 },
}

/// Depth of field.
#[derive(Clone, Debug)]
pub struct Blur {
    /// Diameter of the lens in scene units; not 0.
    pub aperture: f64,
    /// Distance of the plane in focus from the location, in scene units.
    pub focal_distance: f64,
    /// Fewest samples a pixel.
    pub min_samples: u32,
    /// Most samples a pixel.
    pub max_samples: u32,
    /// 0..1.
    pub confidence: f64,
    /// Of encoded colour, squared.
    pub variance: f64,
    /// Weight over the lens, if not a plain disc.
    pub bokeh: Option<Arc<Pigment>>,
}

/// A thin lens, for the path integrator: depth of field as Cycles has it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lens {
    /// Radius of the opening in scene units (Blender: focal length in metres / (2 f-stop)).
    pub radius: f64,
    /// Distance of the plane in focus along the camera's axis, in scene units.
    pub focus_distance: f64,
    /// Straight blades; below 3 the opening is round.
    pub blades: u32,
    /// Turn of the blades.
    pub rotation_rad: f64,
    /// Width of the opening over its height is 1 / ratio (an anamorphic lens); 1 for none.
    pub ratio: f64,
}

/// Where the camera is at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(missing_docs, reason = "as the camera's own")]
pub struct CameraPose {
    pub location: DVec3,
    pub direction: DVec3,
    pub right: DVec3,
    pub up: DVec3,
}

/// A camera. Left-handed when it comes from POV-Ray: x right, y up, z away from the viewer.
#[derive(Clone, Debug)]
pub struct Camera {
    /// Kind of projection.
    pub projection: Projection,
    /// Eye point.
    pub location: DVec3,
    /// To the middle of the picture plane (perspective). A lens shift is in it: then it is not perpendicular to `right` and `up`, and the
    /// axis of the camera is their cross product.
    pub direction: DVec3,
    /// Picture's right; its length is the picture's width on the plane.
    pub right: DVec3,
    /// Picture's up; its length is the picture's height on the plane.
    pub up: DVec3,
    /// Depth of field, POV-Ray's.
    pub blur: Option<Blur>,
    /// Depth of field, Cycles'; of the path integrator alone.
    pub lens: Option<Lens>,
    /// Poses at evenly spaced times over the shutter, at least 2; empty: it stands still. `location` and the rest are the pose in the middle.
    pub motion: Vec<CameraPose>,
    /// Perturbs ray directions.
    pub normal: Option<Arc<Normal>>,
}

impl Default for Camera {
    /// POV-Ray's default: at the origin, looking along +z, width 1.33.
    fn default() -> Self {
        Self {
            projection: Projection::Perspective,
            location: DVec3::ZERO,
            direction: DVec3::Z,
            right: DVec3::new(1.33, 0.0, 0.0),
            up: DVec3::Y,
            blur: None,
            lens: None,
            motion: Vec::new(),
            normal: None,
        }
    }
}

impl Camera {
    /// Moves the camera: the location as a point, the vectors as directions (a scale changes their lengths).
    pub fn transform(&mut self, t: &Transform) {
        self.location = t.point(self.location);
        for v in [&mut self.direction, &mut self.right, &mut self.up] {
            *v = t.vector(*v);
        }
        for pose in &mut self.motion {
            pose.location = t.point(pose.location);
            for v in [&mut pose.direction, &mut pose.right, &mut pose.up] {
                *v = t.vector(*v);
            }
        }
    }
}
