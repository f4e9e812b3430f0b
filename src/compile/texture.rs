//! Textures as flat tables. Sharing in the scene (`Arc`) becomes sharing of indices. The kernel (`kernel/{texture,pigment,normal,
//! pattern,warp,image,function,spline}.rs`) evaluates what stands here.

mod builder;
mod default_maps;
mod features;
mod layouts;

pub use builder::TextureBuilder;
pub use features::{N_TILINGS, pattern_name, texture_features};
pub use layouts::{Layout, Pavement, layout_of};

use super::function::{CallSite, FunctionNode, Instr};
use crate::math::{DAffine3, DVec3, Rgbft, Transform};
use crate::scene::pattern::{FractalPattern, Wave};
use crate::scene::spline::SplineKind;
use crate::scene::{DensityGrid, ImageMap};
use std::sync::Arc;

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
/// Into [`TextureTables::functions`].
pub type FunctionIx = u32;
/// Into [`TextureTables::images`].
pub type ImageIx = u32;

/// A cover.
#[derive(Clone, Debug)]
#[expect(missing_docs, reason = "the names of the fields say it")]
pub enum TextureNode {
    /// Plain layers, bottom first: a range of [`TextureTables::layers`].
    Layers { start: u32, len: u32 },
    /// Blend by a pattern: a range of [`TextureTables::texture_entries`] (position, texture).
    Map { pattern: PatternIx, start: u32, len: u32, uv_mapping: bool },
    /// Weighted mean: a range of [`TextureTables::texture_entries`] (weight, texture).
    Average { pattern: PatternIx, start: u32, len: u32, uv_mapping: bool },
    /// Chosen by an image index: a range of [`TextureTables::texture_entries`].
    MaterialMap { pattern: PatternIx, image: ImageIx, start: u32, len: u32 },
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

/// A run of entries in one of the tables of entries.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Range {
    /// First.
    pub start: u32,
    /// How many.
    pub len: u32,
}

impl Range {
    /// The run's part of `table`.
    #[inline]
    pub fn of<T>(self, table: &[T]) -> &[T] {
        &table[self.start as usize..][..self.len as usize]
    }
}

/// What a pigment's value becomes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PigmentCode {
    /// One colour.
    Solid(Rgbft),
    /// Colours blended: [`TextureTables::color_entries`].
    Colors(Range),
    /// Pigments blended: [`TextureTables::pigment_entries`].
    Map(Range),
    /// Weighted mean: [`TextureTables::pigment_entries`].
    Average(Range),
    /// Colours of an image.
    Image(ImageIx),
}

/// Colour at a point.
#[derive(Clone, Copy, Debug)]
pub struct PigmentNode {
    /// What the value becomes.
    pub code: PigmentCode,
    /// What gives the value and bends the point; `NONE` for one colour.
    pub pattern: PatternIx,
    /// Evaluate at (u, v, 0).
    pub uv_mapping: bool,
    /// Replaces the pigment at low quality.
    pub quick_color: Option<Rgbft>,
}

/// What a normal does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NormalCode {
    /// The pattern's own formula, or four samples of its value; a slope map ([`TextureTables::slope_entries`]) of length 0 is none.
    Pattern(Range),
    /// Normals blended: [`TextureTables::normal_entries`].
    Map(Range),
    /// Weighted mean: [`TextureTables::normal_entries`].
    Average(Range),
    /// Heights of an image.
    Bump(ImageIx),
}

/// Perturbation of the surface normal.
#[derive(Clone, Copy, Debug)]
pub struct NormalNode {
    /// What it does.
    pub code: NormalCode,
    /// What gives the value and bends the point.
    pub pattern: PatternIx,
    /// Strength.
    pub amount: f64,
    /// Distance of the four samples.
    pub accuracy: f64,
    /// Keep lengths.
    pub no_bump_scale: bool,
    /// Evaluate at (u, v, 0).
    pub uv_mapping: bool,
}

/// One bend of a point, in the order of evaluation.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(missing_docs, reason = "as scene::Warp")]
pub enum WarpNode {
    /// Outer space to inner.
    Affine(DAffine3),
    Turbulence {
        amount: DVec3,
        noise: TurbulenceParams,
    },
    Repeat {
        axis: u8,
        width: f64,
        offset: DVec3,
        flip: [bool; 3],
    },
    /// `strength` is negative for inverse holes; `repeat` is 0 on axes that do not repeat.
    BlackHole {
        center: DVec3,
        radius: f64,
        strength: f64,
        inverse: bool,
        falloff: f64,
        repeat: DVec3,
        repeats: bool,
        turbulence: DVec3,
    },
    Cylindrical {
        orientation: DVec3,
        dist_exp: f64,
    },
    Spherical {
        orientation: DVec3,
        dist_exp: f64,
    },
    Toroidal {
        orientation: DVec3,
        dist_exp: f64,
        major_radius: f64,
    },
    Planar {
        orientation: DVec3,
        distance: f64,
    },
    Cubic,
}

/// Octaves of turbulence. `omega` and `lambda` were 32-bit numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TurbulenceParams {
    /// 1..=10.
    pub octaves: u32,
    /// Scale of amplitude an octave.
    pub omega: f32,
    /// Scale of frequency an octave.
    pub lambda: f32,
}

/// What gives the number. Lengths, units and formulas: spec/textures.md, section 2.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(missing_docs, reason = "the names are POV-Ray's keywords")]
pub enum PatternCode {
    /// 0 everywhere; only the warps matter (image maps, averages).
    Plain,
    Agate {
        turb: f64,
    },
    Aoi,
    Boxed,
    /// bozo, spotted, and bumps as a value.
    Noise,
    /// As a value the same as [`PatternCode::Noise`].
    Bumps,
    Brick {
        size: DVec3,
        mortar: f64,
    },
    Cells,
    Checker,
    Crackle {
        form: DVec3,
        metric: f64,
        offset: f64,
        solid: bool,
    },
    Cubic,
    Cylindrical,
    /// Into [`TextureTables::grids`].
    Density {
        grid: u32,
        interpolate: u8,
    },
    Dents,
    Facets {
        coords: Option<f64>,
        size: f64,
        metric: f64,
    },
    /// Into [`TextureTables::fractals`].
    Fractal(u32),
    Function(FunctionIx),
    /// Unit direction.
    Gradient(DVec3),
    Granite,
    Hexagon,
    Image(ImageIx),
    Leopard,
    Marble,
    /// Into [`TextureTables::pattern_objects`].
    Object(u32),
    Onion,
    Pavement(Pavement),
    Pigment(PigmentIx),
    Planar,
    Quilted {
        control0: f64,
        control1: f64,
    },
    Radial,
    Ripples,
    /// Into [`TextureTables::slopes`].
    Slope(u32),
    Spherical,
    Spiral1 {
        arms: f64,
    },
    Spiral2 {
        arms: f64,
    },
    Square,
    Tiling(u8),
    Triangular,
    Waves,
    Wood,
    Wrinkles,
}

/// A slope pattern's numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlopeParams {
    /// Unit direction, or the point that is looked at.
    pub direction: DVec3,
    /// Whether `direction` is a point.
    pub point_at: bool,
    /// Range of the slope that becomes 0..1; `high` 0 or equal to `low` for none.
    pub low: f64,
    /// See `low`.
    pub high: f64,
    /// Unit direction of the altitude, its range, and the slope's share of the value.
    pub altitude: Option<(DVec3, f64, f64, f64)>,
}

/// A pattern with its modifiers.
#[derive(Clone, Copy, Debug)]
pub struct PatternNode {
    /// What gives the number.
    pub code: PatternCode,
    /// [`TextureTables::warps`], in the order of evaluation, the classic turbulence last.
    pub warps: Range,
    /// All its transform steps as one, into [`TextureTables::transforms`]; `NONE` for none.
    pub transform_ix: u32,
    /// Multiplies the value; 0 leaves it alone.
    pub frequency: f64,
    /// Added to it.
    pub phase: f64,
    /// Shapes it.
    pub wave: Wave,
    /// 1..=3.
    pub noise_generator: u8,
    /// Amount of the classic turbulence (marble, wood and the spirals use it in their formulas).
    pub turb_amount: DVec3,
    /// Octaves of the classic turbulence.
    pub turb: TurbulenceParams,
}

/// A spline: its knots are a range of [`TextureTables::knots`].
#[derive(Clone, Copy, Debug)]
pub struct SplineNode {
    /// Shape.
    pub kind: SplineKind,
    /// 2..=5.
    pub n_components: u8,
    /// Knots.
    pub knots: Range,
}

/// A knot of a spline.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Knot {
    /// Parameter.
    pub t: f64,
    /// Value.
    pub value: [f64; 5],
    /// Second derivative by the parameter, natural splines only.
    pub second: [f64; 5],
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
    /// Colours.
    pub pigments: Vec<PigmentNode>,
    /// Bumps.
    pub normals: Vec<NormalNode>,
    /// Patterns.
    pub patterns: Vec<PatternNode>,
    /// Bends of points.
    pub warps: Vec<WarpNode>,
    /// Transforms of patterns, for normals.
    pub transforms: Vec<Transform>,
    /// Entries of colour maps.
    pub color_entries: Vec<(f32, Rgbft)>,
    /// Entries of pigment maps and averages.
    pub pigment_entries: Vec<(f32, PigmentIx)>,
    /// Entries of normal maps and averages.
    pub normal_entries: Vec<(f32, NormalIx)>,
    /// Entries of slope maps: position, (height, slope).
    pub slope_entries: Vec<(f32, [f32; 2])>,
    /// Pictures with their mapping.
    pub images: Vec<Arc<ImageMap>>,
    /// Density files.
    pub grids: Vec<Arc<DensityGrid>>,
    /// Fractal patterns.
    pub fractals: Vec<FractalPattern>,
    /// Slope patterns.
    pub slopes: Vec<SlopeParams>,
    /// Objects of object patterns, into `Geometry::objects`; the geometry fills it in.
    pub pattern_objects: Vec<u32>,
    /// User functions.
    pub functions: Vec<FunctionNode>,
    /// Instructions of functions.
    pub instrs: Vec<Instr>,
    /// Constants of functions.
    pub constants: Vec<f64>,
    /// Calls inside functions.
    pub call_sites: Vec<CallSite>,
    /// Argument registers of calls.
    pub call_args: Vec<u16>,
    /// Transforms of transform functions.
    pub function_transforms: Vec<Transform>,
    /// Splines.
    pub splines: Vec<SplineNode>,
    /// Knots of splines.
    pub knots: Vec<Knot>,
    /// Sources of waves and ripples: place (unit), frequency.
    pub wave_sources: Vec<(DVec3, f64)>,
    /// The scene's noise generator, 1..=3.
    pub noise_generator: u8,
}
