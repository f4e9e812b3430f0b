//! What a node of an object's tree hands down to those below it.

use super::super::NONE;
use super::super::geometry::prim_flags;
use crate::math::Transform;
use crate::scene::object::PhotonFlags;
use crate::scene::{Object, Texture, Visibility};
use std::sync::Arc;

/// What a node hands down to those below it.
#[derive(Clone)]
pub(super) struct Inherited {
    pub to_world: Transform,
    pub texture: Option<(Arc<Texture>, Transform)>,
    pub interior_texture: Option<(Arc<Texture>, Transform)>,
    pub interior_ix: u32,
    pub hollow: Option<bool>,
    /// `prim_flags` that are on.
    pub flags: u32,
    pub group_ix: u32,
    /// Share of radiosity's rays that look at it, where it is said.
    pub importance: Option<f64>,
    /// Photons are shot at this very object as a whole; their spacing.
    pub aimed_at: Option<f64>,
    pub depth: usize,
}

impl Inherited {
    /// The same with `object`'s own settings over those from above, still in its parent's space.
    pub fn entered(&self, object: &Object) -> Self {
        let mut i = self.clone();
        i.depth += 1;
        if let Some(t) = &object.texture {
            i.texture = Some((t.clone(), i.to_world));
        }
        if let Some(t) = &object.interior_texture {
            i.interior_texture = Some((t.clone(), i.to_world));
        }
        let f = &object.flags;
        for (value, bit) in [
            (f.no_shadow, prim_flags::NO_SHADOW),
            (f.no_image, prim_flags::NO_IMAGE),
            (f.no_reflection, prim_flags::NO_REFLECTION),
            (f.no_radiosity, prim_flags::NO_RADIOSITY),
            (f.double_illuminate, prim_flags::DOUBLE_ILLUMINATE),
            (f.uv_mapping, prim_flags::UV_MAPPING),
            (f.cutaway_textures, prim_flags::CUTAWAY),
        ] {
            match value {
                Some(true) => i.flags |= bit,
                Some(false) => i.flags &= !bit,
                None => {}
            }
        }
        for (kind, bit) in [
            (Visibility::CAMERA, prim_flags::NO_IMAGE),
            (Visibility::SHADOW, prim_flags::NO_SHADOW),
            (Visibility::DIFFUSE, prim_flags::NO_DIFFUSE),
            (Visibility::GLOSSY, prim_flags::NO_GLOSSY),
            (Visibility::TRANSMISSION, prim_flags::NO_TRANSMISSION),
            (Visibility::VOLUME, prim_flags::NO_VOLUME),
        ] {
            i.flags |= if object.traits.visibility.has(kind) { 0 } else { bit };
        }
        i.flags |= if object.traits.shadow_catcher { 0 } else { prim_flags::NO_CATCHER };
        i.flags |= if object.traits.motion.len() > 1 { prim_flags::MOVING } else { 0 };
        i.enter_photons(&object.photons);
        i.hollow = f.hollow.or(i.hollow);
        i.importance = object.importance.or(i.importance);
        i
    }

    /// What the object says counts where nothing above it says otherwise.
    fn enter_photons(&mut self, p: &PhotonFlags) {
        for (value, on, off) in [
            (p.reflection, prim_flags::PHOTON_REFLECTION, prim_flags::PHOTON_NO_REFLECTION),
            (p.refraction, prim_flags::PHOTON_REFRACTION, prim_flags::PHOTON_NO_REFRACTION),
            (p.collect, 0, prim_flags::PHOTON_NO_COLLECT),
            (p.pass_through, prim_flags::PHOTON_PASS_THROUGH, 0),
        ] {
            if self.flags & (on | off) == 0 {
                self.flags |= match value {
                    Some(true) => on,
                    Some(false) => off,
                    None => 0,
                };
            }
        }
        // Within a target all is one target; a dissolved one has handed itself down.
        if self.flags & prim_flags::PHOTON_TARGET == 0 {
            self.aimed_at = p.target;
            self.flags |= if p.target.is_some() { prim_flags::PHOTON_TARGET } else { 0 };
        }
        // Photons cannot go on straight and be bent at once.
        let both = prim_flags::PHOTON_TARGET | prim_flags::PHOTON_PASS_THROUGH;
        if self.flags & both == both && self.flags & prim_flags::PHOTON_NO_REFRACTION == 0 {
            if self.flags & prim_flags::PHOTON_REFRACTION == 0 {
                self.flags |= prim_flags::PHOTON_NO_REFRACTION;
            } else {
                self.flags &= !prim_flags::PHOTON_PASS_THROUGH;
            }
        }
    }

    /// What holds at the top of a scene.
    pub fn top() -> Self {
        Self {
            to_world: Transform::IDENTITY,
            texture: None,
            interior_texture: None,
            interior_ix: NONE,
            hollow: None,
            flags: 0,
            group_ix: NONE,
            importance: None,
            aimed_at: None,
            depth: 0,
        }
    }

    /// The same for what `object` is dissolved into: where it is a photon target, each part is one.
    pub fn dissolve(&self, object: &Object) -> Self {
        Self { aimed_at: self.aimed_at, ..self.descend(object) }
    }

    /// The same for what stands inside `object`'s shape.
    pub fn descend(&self, object: &Object) -> Self {
        Self { to_world: object.transform.then(&self.to_world), aimed_at: None, ..self.clone() }
    }
}
