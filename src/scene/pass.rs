//! Passes: what a picture may hold besides its colours, under the names of `--passes` and `RAYLOOM_scene`, and those that Blender reads.

use std::fmt;

/// One pass. The order is that of the film's layers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(u8)]
pub enum Pass {
    /// Depth along the camera's axis (distance for panoramas) at the first sample; [`NO_DEPTH`] where nothing is met.
    Depth,
    /// World position at the first sample.
    Position,
    /// World shading normal.
    Normal,
    /// First set of texture coordinates, v up; third channel: share of the samples that met a surface with such.
    Uv,
    /// Pass index of the object at the first sample.
    ObjectId,
    /// Pass index of the material at the first sample.
    MaterialId,
    /// Colour of what the camera sees, through mirrors and smooth glass, with the light that shines there: a guide for denoisers.
    Albedo,
    /// Normal of the same place in the camera's axes (x right, y up, z into the picture).
    DenoisingNormal,
    /// Light from lamps straight to a diffuse surface, as radiance. Files hold it divided by the colour.
    DiffuseDirect,
    /// Light between surfaces, the last being diffuse.
    DiffuseIndirect,
    /// Colour of diffuse lobes.
    DiffuseColor,
    /// As the diffuse ones, of reflection.
    GlossyDirect,
    /// The same.
    GlossyIndirect,
    /// The same.
    GlossyColor,
    /// As the diffuse ones, of what goes through.
    TransmissionDirect,
    /// The same.
    TransmissionIndirect,
    /// The same.
    TransmissionColor,
    /// Light from lamps scattered once in a volume.
    VolumeDirect,
    /// Other light that a volume scatters to the camera.
    VolumeIndirect,
    /// What shines towards the camera.
    Emission,
    /// The world behind all.
    Environment,
    /// Distance in the mist's terms, 0 near, 1 far; 1 where nothing is.
    Mist,
    /// Motion in pixels, y up, from the frame before and to the next. A fifth value is the share of samples that met something.
    Vector,
    /// Share of the directions about the normal that nothing near by blocks.
    AmbientOcclusion,
    /// What shadow catchers do to the light behind them. Ten values while it is rendered (`film::catcher`).
    ShadowCatcher,
    /// Shares of objects by name. Source: Friedman and Jones 2015, Cryptomatte specification 1.2.0.
    CryptoObject,
    /// The same of materials.
    CryptoMaterial,
    /// The same of the topmost parents of objects.
    CryptoAsset,
    /// Samples of each pixel.
    SampleCount,
    /// Variance of one sample, per channel, unbiased.
    Variance,
}

/// Depth where a ray meets nothing. Source: Cycles (measured).
pub const NO_DEPTH: f32 = 1e10;

/// Ranks of names that a pixel keeps in Cryptomatte. Source: Blender's default.
pub const CRYPTO_RANKS: usize = 6;

/// How values of several samples come together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Join {
    /// Their mean.
    Mean,
    /// That of the first sample.
    First,
    /// Pairs of a name's hash (as bits of a float) and its share, largest first.
    Crypto,
    /// Sample variances, with the means of the pixels.
    Variance,
    /// The film has it anyway.
    Count,
}

/// Pass, name of `--passes`, Blender's name, names of its channels, how samples come together.
type Row = (Pass, &'static str, &'static str, &'static str, Join);

#[rustfmt::skip]
const TABLE: [Row; 30] = [
    (Pass::Depth, "depth", "Depth", "Z", Join::First),
    (Pass::Position, "position", "Position", "XYZ", Join::First),
    (Pass::Normal, "normal", "Normal", "XYZ", Join::Mean),
    (Pass::Uv, "uv", "UV", "UVA", Join::Mean),
    (Pass::ObjectId, "objectId", "IndexOB", "X", Join::First),
    (Pass::MaterialId, "materialId", "IndexMA", "X", Join::First),
    (Pass::Albedo, "albedo", "Denoising Albedo", "RGB", Join::Mean),
    (Pass::DenoisingNormal, "denoisingNormal", "Denoising Normal", "XYZ", Join::Mean),
    (Pass::DiffuseDirect, "diffuseDirect", "DiffDir", "RGB", Join::Mean),
    (Pass::DiffuseIndirect, "diffuseIndirect", "DiffInd", "RGB", Join::Mean),
    (Pass::DiffuseColor, "diffuseColor", "DiffCol", "RGB", Join::Mean),
    (Pass::GlossyDirect, "glossyDirect", "GlossDir", "RGB", Join::Mean),
    (Pass::GlossyIndirect, "glossyIndirect", "GlossInd", "RGB", Join::Mean),
    (Pass::GlossyColor, "glossyColor", "GlossCol", "RGB", Join::Mean),
    (Pass::TransmissionDirect, "transmissionDirect", "TransDir", "RGB", Join::Mean),
    (Pass::TransmissionIndirect, "transmissionIndirect", "TransInd", "RGB", Join::Mean),
    (Pass::TransmissionColor, "transmissionColor", "TransCol", "RGB", Join::Mean),
    (Pass::VolumeDirect, "volumeDirect", "VolumeDir", "RGB", Join::Mean),
    (Pass::VolumeIndirect, "volumeIndirect", "VolumeInd", "RGB", Join::Mean),
    (Pass::Emission, "emission", "Emit", "RGB", Join::Mean),
    (Pass::Environment, "environment", "Env", "RGB", Join::Mean),
    (Pass::Mist, "mist", "Mist", "Z", Join::Mean),
    (Pass::Vector, "vector", "Vector", "XYZW", Join::Mean),
    (Pass::AmbientOcclusion, "ambientOcclusion", "AO", "RGB", Join::Mean),
    (Pass::ShadowCatcher, "shadowCatcher", "Shadow Catcher", "RGB", Join::Mean),
    (Pass::CryptoObject, "cryptoObject", "CryptoObject", "", Join::Crypto),
    (Pass::CryptoMaterial, "cryptoMaterial", "CryptoMaterial", "", Join::Crypto),
    (Pass::CryptoAsset, "cryptoAsset", "CryptoAsset", "", Join::Crypto),
    (Pass::SampleCount, "sampleCount", "Debug Sample Count", "X", Join::Count),
    (Pass::Variance, "variance", "Variance", "RGB", Join::Variance),
];

impl Pass {
    /// All of them, in order.
    pub fn all() -> impl Iterator<Item = Self> {
        TABLE.iter().map(|r| r.0)
    }

    fn row(self) -> &'static Row {
        &TABLE[self as usize]
    }

    /// Name of `--passes` and of the extension.
    pub fn name(self) -> &'static str {
        self.row().1
    }

    /// Blender's name; Cryptomatte puts a number of two digits behind it.
    pub fn layer(self) -> &'static str {
        self.row().2
    }

    /// Names of its channels, one letter each; none for Cryptomatte, whose layers have `rgba`.
    pub fn channels(self) -> &'static str {
        self.row().3
    }

    /// How samples come together.
    pub fn join(self) -> Join {
        self.row().4
    }

    /// Numbers a pixel in the film; files hold as many of them as there are names of channels.
    pub fn width(self) -> usize {
        match self.join() {
            _ if self == Self::Vector => 5,
            _ if self == Self::ShadowCatcher => 10,
            Join::Crypto => 2 * CRYPTO_RANKS,
            Join::Count => 0,
            _ => self.channels().len(),
        }
    }

    /// The colour that files divide this light by.
    pub fn divisor(self) -> Option<Self> {
        match self {
            Self::DiffuseDirect | Self::DiffuseIndirect => Some(Self::DiffuseColor),
            Self::GlossyDirect | Self::GlossyIndirect => Some(Self::GlossyColor),
            Self::TransmissionDirect | Self::TransmissionIndirect => Some(Self::TransmissionColor),
            _ => None,
        }
    }

    /// Of a name of `--passes`.
    pub fn named(name: &str) -> Option<Self> {
        TABLE.iter().find(|r| r.1 == name).map(|r| r.0)
    }
}

/// A set of passes.
#[derive(Clone, Copy, PartialEq, Eq, Default)]
pub struct PassSet(u32);

impl PassSet {
    /// None.
    pub const NONE: Self = Self(0);

    /// All.
    pub fn all() -> Self {
        Pass::all().collect()
    }

    /// Whether it holds one.
    pub fn has(self, p: Pass) -> bool {
        self.0 & 1 << p as u8 != 0
    }

    /// Whether it holds none.
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// With `p`, and the colour that its light is divided by.
    pub fn with(self, p: Pass) -> Self {
        let own = Self(self.0 | 1 << p as u8);
        p.divisor().map_or(own, |d| own.with(d))
    }

    /// In order.
    pub fn iter(self) -> impl Iterator<Item = Pass> {
        Pass::all().filter(move |p| self.has(*p))
    }

    /// Whether it holds any of `list`.
    pub fn has_any(self, list: &[Pass]) -> bool {
        list.iter().any(|p| self.has(*p))
    }
}

impl FromIterator<Pass> for PassSet {
    fn from_iter<I: IntoIterator<Item = Pass>>(list: I) -> Self {
        list.into_iter().fold(Self::NONE, Self::with)
    }
}

impl fmt::Debug for PassSet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.iter().map(Pass::name)).finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_in_order_and_names_are_found() {
        for (k, p) in Pass::all().enumerate() {
            assert_eq!(p as usize, k);
            assert_eq!(Pass::named(p.name()), Some(p));
        }
    }

    #[test]
    fn light_brings_the_colour_that_it_is_divided_by() {
        let set = PassSet::NONE.with(Pass::GlossyIndirect);
        assert_eq!(set.iter().collect::<Vec<_>>(), [Pass::GlossyIndirect, Pass::GlossyColor]);
    }
}
