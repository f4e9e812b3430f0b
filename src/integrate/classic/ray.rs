//! What a ray of the classic integrator carries: the interiors that it is in, its history, its colour band.

use super::inline_vec::InlineVec;
use crate::compile::CompiledScene;
use crate::math::{DVec3, Ray, Rgb, Vec3};

/// Interiors around a point in the order of entering, into `CompiledScene::interiors`.
#[derive(Clone, Debug, Default)]
pub struct InteriorList {
    items: InlineVec<u32, 10>,
    /// Some of them are not hollow.
    solid: u32,
}

impl InteriorList {
    /// Nothing but air.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.items.is_empty()
    }

    /// Number of interiors.
    #[inline]
    pub fn len(&self) -> usize {
        self.items.len()
    }

    /// Whether fog, atmosphere and media act here: every interior is hollow.
    #[inline]
    pub fn is_hollow(&self) -> bool {
        self.solid == 0
    }

    /// The interior entered last.
    #[inline]
    pub fn last(&self) -> Option<u32> {
        self.items.last()
    }

    /// Place of an interior.
    #[inline]
    pub fn position(&self, interior_ix: u32) -> Option<usize> {
        (0..self.items.len()).find(|k| self.items.get(*k) == interior_ix)
    }

    /// Enters an interior.
    pub fn push(&mut self, scene: &CompiledScene, interior_ix: u32) {
        self.solid += u32::from(!scene.interiors[interior_ix as usize].hollow);
        self.items.push(interior_ix);
    }

    /// Leaves the interior at a place.
    pub fn remove(&mut self, scene: &CompiledScene, position: usize) {
        self.solid -= u32::from(!scene.interiors[self.items.get(position) as usize].hollow);
        self.items.remove(position);
    }

    /// Leaves the interior if inside, else enters it.
    pub fn toggle(&mut self, scene: &CompiledScene, interior_ix: u32) {
        match self.position(interior_ix) {
            Some(k) => self.remove(scene, k),
            None => self.push(scene, interior_ix),
        }
    }

    /// All interiors.
    pub fn iter(&self) -> impl Iterator<Item = u32> + '_ {
        self.items.iter()
    }
}

/// A ray on its way.
#[derive(Clone, Debug)]
pub struct TraceRay {
    /// Start and unit direction (refraction may leave it a rounding off unit).
    pub ray: Ray,
    /// Depth beyond which it sees nothing.
    pub max_depth: f64,
    /// Where it runs.
    pub interiors: InteriorList,
    /// Reflected at least once.
    pub reflected: bool,
    /// Gathers for radiosity, or descends from such a ray.
    pub gathers: bool,
    /// Wavelength in nm once split by dispersion, else 0.
    pub wavelength: f64,
}

impl TraceRay {
    /// A camera ray inside `interiors`.
    pub fn primary(ray: Ray, interiors: InteriorList) -> Self {
        Self { ray, max_depth: f64::INFINITY, interiors, reflected: false, gathers: false, wavelength: 0.0 }
    }

    /// The ray with the same history that goes on from `point` along `dir` in `interiors`.
    pub fn onward(&self, point: DVec3, dir: DVec3, interiors: &InteriorList) -> Self {
        Self { ray: Ray::new(point, dir), max_depth: f64::INFINITY, interiors: interiors.clone(), ..*self }
    }
}

/// What a ray sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// Colour in the working space.
    pub rgb: Rgb,
    /// Transparency to the background (with output alpha).
    pub transmit: f32,
    /// Depth of the first hit; infinite when there is none.
    pub depth: f64,
}

impl Seen {
    /// Black and opaque: what cut-off rays see.
    pub const BLACK: Seen = Seen { rgb: Vec3::ZERO, transmit: 0.0, depth: f64::INFINITY };
}
