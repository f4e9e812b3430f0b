//! POV-Ray's textures and finishes as lobes (to be filled).

use super::plan::PathPlan;
use super::surface::Surface;
use crate::compile::texture::TextureNode;
use crate::kernel::cover::{Cover, for_covers};
use crate::math::{Rgb, Vec3};
use crate::scene::Shader;

/// A cover in POV-Ray's manner, if the hit has one.
pub(super) type PlainCover = Option<Cover>;

impl PathPlan<'_> {
    /// The shader of a hit, or its cover in POV-Ray's manner.
    pub(super) fn material(&self, surface: &Surface) -> (Option<&Shader>, PlainCover) {
        let mut first = None;
        for_covers(self.scene, &surface.hit, surface.backfacing, |c| {
            if first.is_none_or(|f: Cover| c.weight > f.weight) {
                first = Some(c);
            }
        });
        let shader = first.and_then(|c| match self.scene.textures.textures.get(c.texture as usize) {
            Some(TextureNode::Principled(ix)) => Some(&*self.shaders[*ix as usize]),
            _ => None,
        });
        (shader, first)
    }

    /// Material of a hit, into `TextureTables::principled`.
    pub(super) fn material_ix(&self, surface: &Surface) -> Option<u32> {
        let (_, cover) = self.material(surface);
        match self.scene.textures.textures.get(cover?.texture as usize) {
            Some(TextureNode::Principled(ix)) => Some(*ix),
            _ => None,
        }
    }

    pub(super) fn pov_transparency(&self, _surface: &Surface, _cover: PlainCover) -> Rgb {
        Vec3::ZERO
    }
}

impl PathPlan<'_> {
    pub(super) fn pov_shading(&self, surface: &Surface, _cover: PlainCover, view: super::closure::View) -> super::closure::Shading {
        let grey = crate::scene::shader::Closure::Diffuse { color: 0.5.into(), roughness: 0.0.into(), normal: None };
        super::closure::shade(Some(&grey), surface, view)
    }
}
