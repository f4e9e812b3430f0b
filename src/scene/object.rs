//! Objects: a shape with its place, its cover and its switches.

use super::{Interior, Shape, Texture, Visibility};
use crate::diag::Span;
use crate::math::Transform;
use std::sync::Arc;

/// Switches of an object. `None` is "not said": the parent's holds, then POV-Ray's default (off).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct ObjectFlags {
    /// Casts no shadow.
    pub no_shadow: Option<bool>,
    /// Unseen by camera rays and their refractions.
    pub no_image: Option<bool>,
    /// Unseen by reflected rays.
    pub no_reflection: Option<bool>,
    /// Unseen by radiosity rays.
    pub no_radiosity: Option<bool>,
    /// Atmosphere and media go on inside.
    pub hollow: Option<bool>,
    /// Both sides are lit.
    pub double_illuminate: Option<bool>,
    /// The texture sits on (u, v).
    pub uv_mapping: Option<bool>,
    /// Cut surfaces show the textures of what they cut.
    pub cutaway_textures: Option<bool>,
    /// Inside and outside are swapped.
    pub inverse: bool,
    /// Slower, surer roots.
    pub sturm: bool,
    /// A union may be split at the top level (`Some(false)` forbids).
    pub split_union: Option<bool>,
}

/// Photon switches of an object.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct PhotonFlags {
    /// Photons are shot at it; the number multiplies the spacing.
    pub target: Option<f64>,
    /// Reflects photons.
    pub reflection: Option<bool>,
    /// Refracts photons.
    pub refraction: Option<bool>,
    /// Collects photons.
    pub collect: Option<bool>,
    /// Photons pass as if it were not there.
    pub pass_through: Option<bool>,
}

/// An object in its parent's space.
#[derive(Clone, Debug)]
pub struct Object {
    /// The shape in its own space.
    pub shape: Shape,
    /// Maps the shape, and everything inside it, to the parent's space.
    pub transform: Transform,
    /// Cover in the parent's space; `None` takes the parent's.
    pub texture: Option<Arc<Texture>>,
    /// Cover of the inside in the parent's space; `None` takes the parent's, then `texture`.
    pub interior_texture: Option<Arc<Texture>>,
    /// Filling in the parent's space; `None` takes the parent's, then the default.
    pub interior: Option<Arc<Interior>>,
    /// Hits count only inside all of these (in the parent's space).
    pub clipped_by: Vec<Object>,
    /// The object is missed where all of these are missed (in the parent's space).
    pub bounded_by: Vec<Object>,
    /// Switches.
    pub flags: ObjectFlags,
    /// Photon switches.
    pub photons: PhotonFlags,
    /// Share of radiosity rays, 0..=1.
    pub importance: Option<f64>,
    /// What the path integrator asks besides.
    pub traits: PathTraits,
    /// Place in the scene file.
    pub span: Option<Span>,
}

/// What the path integrator asks of an object besides; what stands inside an object has its own, not its parent's.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PathTraits {
    /// Ray kinds that see it.
    pub visibility: Visibility,
    /// A hole in the film's alpha where the camera sees it.
    pub holdout: bool,
    /// Seen only as the shadow and light that it catches.
    pub shadow_catcher: bool,
    /// Pass index.
    pub object_id: u32,
    /// Name, for Cryptomatte; empty for none.
    pub name: Arc<str>,
    /// Name of its topmost parent; empty for its own.
    pub asset: Arc<str>,
    /// `Object::transform` at evenly spaced times over the shutter, at least 2; empty: it stands still. `transform` is the middle's.
    pub motion: Arc<[Transform]>,
}

impl Object {
    /// A shape with nothing else said.
    pub fn new(shape: Shape) -> Self {
        Self {
            shape,
            transform: Transform::IDENTITY,
            texture: None,
            interior_texture: None,
            interior: None,
            clipped_by: Vec::new(),
            bounded_by: Vec::new(),
            flags: ObjectFlags::default(),
            photons: PhotonFlags::default(),
            importance: None,
            traits: PathTraits::default(),
            span: None,
        }
    }

    /// Moves the object with all that it has been given so far: what is inside follows through `transform`,
    /// the cover, the filling and the clip objects are moved here. A texture on (u, v) stays.
    pub fn apply_transform(&mut self, t: &Transform) {
        self.transform = self.transform.then(t);
        if self.flags.uv_mapping != Some(true) {
            for tex in [&mut self.texture, &mut self.interior_texture].into_iter().flatten() {
                Arc::make_mut(tex).transform(t);
            }
        }
        if let Some(i) = &mut self.interior {
            Arc::make_mut(i).transform(t);
        }
        for o in self.clipped_by.iter_mut().chain(&mut self.bounded_by) {
            o.apply_transform(t);
        }
    }
}
