//! Media along rays. Source: spec/light.md, section 7.

use super::ray::{InteriorList, TraceRay};
use super::trace::Tracer;
use crate::kernel::SurfaceHit;
use crate::math::{Ray, Rgb};
use crate::scene::Light;

impl Tracer<'_> {
    /// What the media of the interiors around a ray make of what it sees.
    pub(super) fn inside_media(&mut self, _r: &TraceRay, _hit: &SurfaceHit, rgb: Rgb, transmit: f32) -> (Rgb, f32) {
        (rgb, transmit)
    }

    /// What media on `0..depth` of a shadow ray leave of `color`.
    pub(super) fn shadow_media(
        &mut self,
        _light: &Light,
        _ray: &Ray,
        _depth: f64,
        _around: &InteriorList,
        color: Rgb,
        _ends_at_surface: bool,
    ) -> Rgb {
        color
    }
}
