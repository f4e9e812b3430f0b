//! Textures: pigment, normal and finish, in layers or chosen by patterns; and the physically based material of imports.

use super::{ImageMap, Pattern, Principled};
use crate::math::{Rgb, Rgbft, Transform, Vec3};
use std::sync::Arc;

/// Entries chosen or blended by a value. Positions are 32-bit, neither sorted nor clamped, at least one entry.
#[derive(Clone, Debug, PartialEq)]
pub struct BlendMap<T> {
    /// `(position, entry)`; for averages the position is the weight.
    pub entries: Vec<(f32, T)>,
}

/// What a pigment's pattern value becomes.
#[derive(Clone, Debug)]
pub enum PigmentKind {
    /// One colour everywhere.
    Solid(Rgbft),
    /// The pattern's own default colours (resolved when the scene is compiled).
    DefaultMap,
    /// Colours, blended (lists have positions 0, 1, 2, ... that the values hit exactly).
    ColorMap(Arc<BlendMap<Rgbft>>),
    /// Pigments, blended, seen at the warped point.
    PigmentMap(Arc<BlendMap<Pigment>>),
    /// Weighted mean of pigments.
    Average(Arc<BlendMap<Pigment>>),
    /// Colours of an image.
    ImageMap(Arc<ImageMap>),
}

/// Colour at a point.
#[derive(Clone, Debug)]
pub struct Pigment {
    /// What the value becomes.
    pub kind: PigmentKind,
    /// What gives the value; its warps serve image maps and averages too.
    pub pattern: Pattern,
    /// Evaluate at (u, v, 0) in place of the point; the outer warps are ignored.
    pub uv_mapping: bool,
    /// Replaces the pigment at quality 5 and lower.
    pub quick_color: Option<Rgbft>,
}

impl Pigment {
    /// One colour.
    pub fn solid(c: Rgbft) -> Self {
        Self { kind: PigmentKind::Solid(c), pattern: Pattern::default(), uv_mapping: false, quick_color: None }
    }

    /// Moves the pattern. Plain colours have none to move; on (u, v) nothing moves.
    pub fn transform(&mut self, t: &Transform) {
        if !matches!(self.kind, PigmentKind::Solid(_)) && !self.uv_mapping {
            self.pattern.transform(t);
        }
    }
}

/// What a normal's pattern does.
#[derive(Clone, Debug)]
#[expect(missing_docs, reason = "the names of the fields say it")]
pub enum NormalKind {
    /// The pattern's own formula, or its slope by four samples; the map bends the value first.
    Pattern { slope_map: Option<Arc<BlendMap<[f32; 2]>>> },
    /// Normals, blended.
    NormalMap(Arc<BlendMap<Normal>>),
    /// Weighted mean of normals.
    Average(Arc<BlendMap<Normal>>),
    /// Heights of an image.
    BumpMap(Arc<ImageMap>),
}

/// Perturbation of the surface normal. Source: spec/textures.md, section 3.
#[derive(Clone, Debug)]
pub struct Normal {
    /// What the pattern does.
    pub kind: NormalKind,
    /// What gives the value.
    pub pattern: Pattern,
    /// Strength; may be negative.
    pub amount: f32,
    /// Distance of the four samples, in pattern space.
    pub accuracy: f32,
    /// Keep lengths: no normalisation inside.
    pub no_bump_scale: bool,
    /// Evaluate at (u, v, 0).
    pub uv_mapping: bool,
}

impl Normal {
    /// Moves the pattern; on (u, v) nothing moves.
    pub fn transform(&mut self, t: &Transform) {
        if !self.uv_mapping {
            self.pattern.transform(t);
        }
    }
}

/// Reflection of a finish.
#[derive(Clone, Debug, PartialEq)]
pub struct Reflection {
    /// Seen along the normal (or Fresnel's 0).
    pub min: Rgb,
    /// Seen at grazing angles (or Fresnel's 1).
    pub max: Rgb,
    /// Blend by Fresnel's law in place of the power.
    pub fresnel: bool,
    /// Power of (1 - cos).
    pub falloff: f32,
    /// The reflected colour is raised to 1/exponent.
    pub exponent: f32,
    /// Tint by the pigment, 0..1.
    pub metallic: f32,
}

/// How a surface answers light, POV-Ray's way. Source: FACTS.md section 2, spec/textures.md section 9.
#[derive(Clone, Debug, PartialEq)]
pub struct Finish {
    /// Light from everywhere, in proportion.
    pub ambient: Rgb,
    /// Own light.
    pub emission: Rgb,
    /// Lambert share of the front, albedo already applied.
    pub diffuse: f32,
    /// Lambert share of light from behind.
    pub diffuse_back: f32,
    /// The diffuse values as written (radiosity uses them).
    pub diffuse_raw: [f32; 2],
    /// Power of the cosine.
    pub brilliance: f32,
    /// Phong highlight, albedo already applied.
    pub phong: f32,
    /// Phong exponent.
    pub phong_size: f32,
    /// Blinn highlight, albedo already applied.
    pub specular: f32,
    /// 1 / exponent.
    pub roughness: f32,
    /// Highlights tinted by the pigment, 0..1.
    pub metallic: f32,
    /// Mirror.
    pub reflection: Reflection,
    /// What is reflected is not transmitted.
    pub conserve_energy: bool,
    /// Grain.
    pub crand: f32,
    /// Thin film: amount, thickness, turbulence.
    pub irid: [f32; 3],
    /// Subsurface translucency (mm, by channel).
    pub subsurface: Option<Rgb>,
}

impl Default for Finish {
    fn default() -> Self {
        Self {
            ambient: Vec3::splat(0.1),
            emission: Vec3::ZERO,
            diffuse: 0.6,
            diffuse_back: 0.0,
            diffuse_raw: [0.6, 0.0],
            brilliance: 1.0,
            phong: 0.0,
            phong_size: 40.0,
            specular: 0.0,
            roughness: 0.05,
            metallic: 0.0,
            reflection: Reflection { min: Vec3::ZERO, max: Vec3::ZERO, fresnel: false, falloff: 1.0, exponent: 1.0, metallic: 0.0 },
            conserve_energy: false,
            crand: 0.0,
            irid: [0.0; 3],
            subsurface: None,
        }
    }
}

/// One layer of a plain texture.
#[derive(Clone, Debug)]
pub struct TextureLayer {
    /// Colour.
    pub pigment: Arc<Pigment>,
    /// Bumps.
    pub normal: Option<Arc<Normal>>,
    /// Answer to light.
    pub finish: Arc<Finish>,
}

/// What covers a surface.
#[derive(Clone, Debug)]
#[expect(missing_docs, reason = "the names of the fields say it")]
pub enum Texture {
    /// Plain layers, bottom first, at least one.
    Layers(Vec<TextureLayer>),
    /// Textures blended by a pattern. With `uv_mapping` the children look at (u, v, 0) and the pattern's warps turn normals only.
    Map { pattern: Pattern, map: BlendMap<Arc<Texture>>, uv_mapping: bool },
    /// Weighted mean; the pattern bends the point. `uv_mapping` as above.
    Average { pattern: Pattern, map: BlendMap<Arc<Texture>>, uv_mapping: bool },
    /// Texture chosen by an image's index; the pattern bends the point.
    MaterialMap { pattern: Pattern, image: Arc<ImageMap>, textures: Vec<Arc<Texture>> },
    /// Physically based, of imports.
    Principled(Box<Principled>),
}

impl Texture {
    /// A layer of one colour with the default finish.
    pub fn solid(c: Rgbft) -> Self {
        Self::Layers(vec![TextureLayer { pigment: Arc::new(Pigment::solid(c)), normal: None, finish: Arc::new(Finish::default()) }])
    }

    /// Moves the texture: every layer of a plain one, the choosing pattern of the others (where the texture sits
    /// on (u, v) by its own word, that turns normals only, as measured).
    pub fn transform(&mut self, t: &Transform) {
        match self {
            Self::Layers(layers) => {
                for l in layers {
                    if !l.pigment.uv_mapping {
                        Arc::make_mut(&mut l.pigment).transform(t);
                    }
                    if let Some(n) = l.normal.as_mut().filter(|n| !n.uv_mapping) {
                        Arc::make_mut(n).transform(t);
                    }
                }
            }
            Self::Map { pattern, .. } | Self::Average { pattern, .. } | Self::MaterialMap { pattern, .. } => pattern.transform(t),
            Self::Principled(_) => {}
        }
    }
}
