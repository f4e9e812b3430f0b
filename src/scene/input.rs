//! Inputs of closures: a number, colour or direction that is constant or comes from a picture or from the mesh. Blender calls them sockets.

use super::material::MaterialTexture;
use crate::math::{Rgb, Vec3};

/// Which number of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "the names say it")]
pub enum Channel {
    Red,
    Green,
    Blue,
    Alpha,
    /// 0.2126 r + 0.7152 g + 0.0722 b: what Blender makes of a colour that feeds a number.
    Luminance,
}

/// A picture as an input reads it.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Texels, colour space, edges, filter, coordinates.
    pub texture: MaterialTexture,
    /// 0: `Mesh::uvs`; `n`: `Mesh::more_uvs[n - 1]`. A mesh without that set gives (0, 0).
    pub uv_set: u32,
    /// sRGB is decoded after the mix of neighbouring texels, as Cycles does with 8-bit pictures; false: before, as glTF asks.
    pub filter_encoded: bool,
    /// Colours are multiplied by alpha in the file and divided by it here.
    pub premultiplied: bool,
}

/// A number: `factor`, times the picture's, plus `offset`, then clamped if asked.
#[derive(Clone, Debug, PartialEq)]
pub struct Scalar {
    /// The value without a picture.
    pub factor: f32,
    /// Added after the product (`1 - x` is factor -1, offset 1).
    pub offset: f32,
    /// Number of a picture that multiplies.
    pub picture: Option<(Picture, Channel)>,
}

impl Scalar {
    /// A constant.
    pub const fn constant(v: f32) -> Self {
        Self { factor: v, offset: 0.0, picture: None }
    }

    /// The constant, if it is one.
    pub fn as_constant(&self) -> Option<f32> {
        self.picture.is_none().then_some(self.factor + self.offset)
    }
}

impl From<f32> for Scalar {
    fn from(v: f32) -> Self {
        Self::constant(v)
    }
}

/// A colour in linear Rec.709: `factor`, times the picture's, times the mesh's corner colours if asked.
#[derive(Clone, Debug, PartialEq)]
pub struct Color {
    /// The value without a picture.
    pub factor: Rgb,
    /// Picture that multiplies.
    pub picture: Option<Picture>,
    /// `Mesh::colors` multiply.
    pub vertex_color: bool,
}

impl Color {
    /// A constant.
    pub const fn constant(v: Rgb) -> Self {
        Self { factor: v, picture: None, vertex_color: false }
    }

    /// The constant, if it is one.
    pub fn as_constant(&self) -> Option<Rgb> {
        (self.picture.is_none() && !self.vertex_color).then_some(self.factor)
    }
}

impl From<Rgb> for Color {
    fn from(v: Rgb) -> Self {
        Self::constant(v)
    }
}

impl From<f32> for Color {
    fn from(v: f32) -> Self {
        Self::constant(Vec3::splat(v))
    }
}

/// What bends a shading normal.
#[derive(Clone, Debug, PartialEq)]
pub enum NormalInput {
    /// Tangent-space normals: red to the picture's right, green to its top (OpenGL), blue outward; 0.5 is 0.
    Map {
        /// The picture; its colours are numbers.
        picture: Picture,
        /// Blender: mixes with the smooth normal; glTF: scales red and green. See `scale_xy`.
        strength: Scalar,
        /// `strength` scales red and green before the normal is made unit (glTF), in place of mixing (Blender).
        scale_xy: bool,
    },
    /// Heights.
    Bump {
        /// The height, in units of `distance`.
        height: Scalar,
        /// Mixes with the smooth normal.
        strength: Scalar,
        /// Scene units of height 1.
        distance: Scalar,
        /// Bumps are pits.
        invert: bool,
        /// Bends this one's result.
        base: Option<Box<NormalInput>>,
    },
}

/// Where stretched highlights lie along.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum TangentInput {
    /// Around the object's z axis (Blender's default).
    #[default]
    Object,
    /// Along u of a set of coordinates, turning towards the picture's top (glTF); as `Picture::uv_set`.
    Uv(u32),
}
