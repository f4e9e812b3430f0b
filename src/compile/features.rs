//! What a compiled scene needs, read off its tables.

use super::geometry::{PrimKind, prim_flags};
use super::texture::texture_features;
use super::{CompiledScene, FeatureSet};

/// The features of a scene; texture features are read off the texture tables.
pub(super) fn find(scene: &CompiledScene) -> FeatureSet {
    let g = &scene.geometry;
    let mut f = FeatureSet::default();
    for p in &g.prims {
        f.prim_kinds |= 1 << p.kind as u32;
        f.clip_programs |= p.clip_len > 0;
        f.transparency |= p.flags & prim_flags::TRANSPARENT != 0;
        f.uv |= p.flags & (prim_flags::UV_MAPPING | prim_flags::NEEDS_UV) != 0;
    }
    debug_assert!(PrimKind::Hair as u32 <= 63, "kinds are bits of a u64");
    f.refraction = f.transparency && scene.interiors.iter().any(|i| i.ior != 1.0);
    f.dispersion = f.refraction && scene.interiors.iter().any(|i| i.dispersion != 1.0);
    f.media = !scene.atmosphere.is_empty() || scene.interiors.iter().any(|i| !i.media.is_empty());
    f.area_lights = scene.lights.iter().any(|l| l.light.area.is_some() || l.light.radius > 0.0);
    f.fog = !scene.fogs.is_empty();
    f.rainbow = !scene.rainbows.is_empty();
    f.sky = scene.sky.is_some();
    f.radiosity = scene.settings.radiosity.is_some();
    f.photons = scene.settings.photons.is_some() && scene.options.quality >= 9 && !g.photon_targets.is_empty();
    for t in &scene.textures.finishes {
        f.reflection |= t.reflection.max != crate::math::Vec3::ZERO || t.reflection.min != crate::math::Vec3::ZERO;
        f.highlights |= t.phong != 0.0 || t.specular != 0.0;
        f.irid |= t.irid[0] != 0.0;
        f.crand |= t.crand != 0.0;
        f.subsurface |= t.subsurface.is_some() && scene.settings.subsurface.is_some() && scene.options.quality >= 9;
    }
    texture_features(&scene.textures, &mut f);
    f.principled = !scene.textures.principled.is_empty();
    f
}
