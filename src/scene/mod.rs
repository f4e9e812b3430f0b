//! The scene: what a front end promises to the rest.
//!
//! Promises (`validate.rs` checks them, `dump.rs` prints a scene for golden tests):
//! - every name is resolved, every inherited default is filled in, every length is in scene units, every angle says its unit;
//! - sharing is by `Arc`, so no id can dangle; a shared part is never changed in place;
//! - directions are unit unless their comment says otherwise; numbers are finite unless a comment says otherwise;
//! - an [`Object`]'s `transform` maps its shape, and everything inside it, to its parent's space;
//!   its own texture, interior and clip objects are already in the parent's space.

pub mod camera;
pub mod curves;
pub mod denoise;
pub mod dump;
pub mod environment;
pub mod function;
pub mod image;
pub mod input;
pub mod interior;
pub mod lamp;
pub mod light;
pub mod likeness;
pub mod material;
pub mod object;
pub mod pass;
pub mod path_settings;
pub mod pattern;
pub mod query;
pub mod settings;
pub mod shader;
pub mod shape;
pub mod spline;
pub mod texture;
pub mod visibility;
pub mod volume;

pub use camera::{Camera, Projection};
pub use curves::Curves;
pub use environment::Environment;
pub use function::{Function, FunctionBody};
pub use image::{Image, ImageMap};
pub use interior::{Fog, Interior, Media, Rainbow, SkySphere};
pub use lamp::Lamp;
pub use light::Light;
pub use material::Principled;
pub use object::{Object, ObjectFlags};
pub use pass::{Pass, PassSet};
pub use path_settings::PathSettings;
pub use pattern::{DensityGrid, Pattern, PatternKind, Warp};
pub use query::SceneQuery;
pub use settings::Settings;
pub use shader::Shader;
pub use shape::{Csg, Mesh, Shape};
pub use spline::Spline;
pub use texture::{BlendMap, Finish, Normal, NormalKind, Pigment, PigmentKind, Texture, TextureLayer};
pub use visibility::Visibility;
pub use volume::Volume;

use crate::math::Rgbft;

/// A whole scene at one moment. See the module's promises.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Global settings.
    pub settings: Settings,
    /// The one camera.
    pub camera: Camera,
    /// What a ray sees that hits nothing. Its filter and transmit count in output with alpha alone; black that lets through by default.
    pub background: Rgbft,
    /// Seen by direction, in front of the background.
    pub sky_sphere: Option<SkySphere>,
    /// What the path integrator sees in place of the background and the sky; `None`: those.
    pub environment: Option<Environment>,
    /// Fogs in the order of the file.
    pub fogs: Vec<Fog>,
    /// Rainbows in the order of the file.
    pub rainbows: Vec<Rainbow>,
    /// Media of the atmosphere.
    pub atmosphere: Vec<Media>,
    /// Lights in the order of the file; those inside unions and light groups stand in the objects.
    pub lights: Vec<Light>,
    /// Top-level objects in the order of the file.
    pub objects: Vec<Object>,
    /// Animations that the file has (imports), whether one was asked for or not.
    pub animations: Vec<AnimationInfo>,
    /// What its reader left out, for information.
    pub unread: Unread,
}

/// What a file says of one of its animations.
#[derive(Clone, Debug, PartialEq)]
pub struct AnimationInfo {
    /// Its name, else its number from 0.
    pub name: String,
    /// First and last key.
    pub seconds: [f64; 2],
    /// What it moves: properties of nodes.
    pub n_channels: usize,
}

/// What the reader of a scene file had no need of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Unread {
    /// Pictures that were not decoded, and all that the file has.
    pub pictures: [usize; 2],
}

impl Default for Scene {
    fn default() -> Self {
        Self {
            settings: Settings::default(),
            camera: Camera::default(),
            background: Rgbft { transmit: 1.0, ..Rgbft::BLACK },
            sky_sphere: None,
            environment: None,
            fogs: Vec::new(),
            rainbows: Vec::new(),
            atmosphere: Vec::new(),
            lights: Vec::new(),
            objects: Vec::new(),
            animations: Vec::new(),
            unread: Unread::default(),
        }
    }
}
