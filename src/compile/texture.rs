//! Textures as flat tables. Sharing in the scene (`Arc`) becomes sharing of indices.

/// Into [`TextureTables::textures`].
pub type TextureIx = u32;
/// Into [`TextureTables::pigments`].
pub type PigmentIx = u32;
/// Into [`TextureTables::normals`].
pub type NormalIx = u32;
/// Into [`TextureTables::finishes`].
pub type FinishIx = u32;
/// Into [`TextureTables::patterns`].
pub type PatternIx = u32;

/// A cover.
#[derive(Clone, Debug)]
pub enum TextureNode {
    /// Plain layers, bottom first: a range of [`TextureTables::layers`].
    Layers { start: u32, len: u32 },
    /// Blend by a pattern: a range of [`TextureTables::texture_entries`] (position, texture).
    Map { pattern: PatternIx, start: u32, len: u32, uv_mapping: bool },
    /// Weighted mean: a range of [`TextureTables::texture_entries`] (weight, texture).
    Average { pattern: PatternIx, start: u32, len: u32, uv_mapping: bool },
    /// Chosen by an image index: a range of [`TextureTables::texture_entries`].
    MaterialMap { pattern: PatternIx, image: u32, start: u32, len: u32 },
    /// Into [`TextureTables::principled`].
    Principled(u32),
}

/// A layer of a plain texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Layer {
    /// Colour.
    pub pigment: PigmentIx,
    /// Bumps, or `NONE`.
    pub normal: NormalIx,
    /// Answer to light.
    pub finish: FinishIx,
}

/// All texture data of a scene. Pigments, normals, patterns, maps, images, functions stand here too, by kind.
#[derive(Debug, Default)]
pub struct TextureTables {
    /// Covers.
    pub textures: Vec<TextureNode>,
    /// Layers of plain textures.
    pub layers: Vec<Layer>,
    /// Entries of maps of textures.
    pub texture_entries: Vec<(f32, TextureIx)>,
    /// Answers to light.
    pub finishes: Vec<crate::scene::Finish>,
    /// Physically based materials.
    pub principled: Vec<crate::scene::Principled>,
}
