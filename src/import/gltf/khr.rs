//! Materials beyond the core → Blender's Principled closure: coat, sheen, anisotropy, film, specular, panes and solid glass.
//!
//! Each function names where the Khronos definition and Blender's socket differ. Source: the extensions' pages in the glTF registry.

use super::super::ImportError;
use super::Document;
use super::bake;
use super::material::Reader;
use super::rayloom::Record;
use crate::math::{Rgb, Vec3};
use crate::scene::input::{Channel, Color, NormalInput, Picture, Scalar, TangentInput};
use crate::scene::shader::{Closure, MixFactor, PrincipledClosure};
use crate::scene::{Interior, Volume};
use ::gltf::json;
use serde_json::{Map, Value};
use std::f64::consts::TAU;

/// Coordinates as they are.
pub(super) const IDENTITY: [[f32; 3]; 2] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

/// Translation times rotation times scale, as KHR_texture_transform writes it.
pub(super) fn affine(offset: [f32; 2], rotation: f32, scale: [f32; 2]) -> [[f32; 3]; 2] {
    let (sin, cos) = rotation.sin_cos();
    [[cos * scale[0], sin * scale[1], offset[0]], [-sin * scale[0], cos * scale[1], offset[1]]]
}

/// Set and map of coordinates of a texture over set `set`, from a KHR_texture_transform that the JSON crate has no record for.
pub(super) fn transform_of(
    doc: &Document,
    value: Option<&Value>,
    set: u32,
    place: impl Fn() -> String,
) -> Result<(u32, [[f32; 3]; 2]), ImportError> {
    let Some(value) = value else { return Ok((set, IDENTITY)) };
    let r = Record::new(doc, value, format!("{}: KHR_texture_transform", place()))?;
    let pair = |key: &str, rest: f64| r.numbers::<2>(key).map(|v| v.unwrap_or([rest; 2]).map(|v| v as f32));
    let map = affine(pair("offset", 0.0)?, r.number_or("rotation", 0.0)? as f32, pair("scale", 1.0)?);
    Ok((r.count_or("texCoord", set)?, map))
}

type Others = Map<String, Value>;

impl<'a> Reader<'a> {
    /// The record of an extension of the material.
    fn record(&self, others: Option<&'a Others>, name: &str) -> Result<Option<Record<'a>>, ImportError> {
        let Some(value) = others.and_then(|o| o.get(name)) else { return Ok(None) };
        Record::new(self.doc, value, format!("{}: {name}", self.place())).map(Some)
    }

    /// The picture of a textureInfo, and its scale (of normal textures).
    fn info(&mut self, r: &Record<'a>, key: &str, srgb: bool) -> Result<Option<(Picture, f32)>, ImportError> {
        let Some(t) = r.record(key)? else { return Ok(None) };
        let texture = t.needed("index", t.index("index", self.doc.root.textures.len(), "texture")?)?;
        let extensions = t.record("extensions")?;
        let transform = extensions.as_ref().and_then(|e| e.get("KHR_texture_transform"));
        let (set, map) = transform_of(self.doc, transform, t.count_or("texCoord", 0)?, || t.path().to_owned())?;
        let scale = t.number_or("scale", 1.0)? as f32;
        Ok(self.picture(texture, set, map, srgb)?.map(|p| (p, scale)))
    }

    /// A factor from 0 to 1 and the channel of a texture that multiplies it.
    fn factor(&mut self, r: &Record<'a>, key: &str, default: f64, texture: &str, channel: Channel) -> Result<Scalar, ImportError> {
        let factor = r.positive_or(key, default)? as f32;
        let picture = self.info(r, texture, false)?.map(|(p, _)| (p, channel));
        Ok(Scalar { factor, offset: 0.0, picture })
    }

    /// A colour and the texture that multiplies it.
    fn tint(&mut self, r: &Record<'a>, key: &str, default: f64, texture: &str) -> Result<Color, ImportError> {
        let factor = Vec3::from(r.numbers::<3>(key)?.unwrap_or([default; 3]).map(|c| c.max(0.0) as f32));
        let picture = self.info(r, texture, true)?.map(|(p, _)| p);
        Ok(Color { factor, picture, vertex_color: false })
    }
}

/// What KHR_materials_volume says.
pub(super) struct Body {
    /// Light passes into a body; else the surface is a pane.
    solid: bool,
    color: Rgb,
    /// Depth at which that colour is left, scene units; 0 for a clear body.
    distance: f64,
}

impl Body {
    /// For the classic integrator: colour^(depth / distance) of the light is left.
    pub fn interior(&self, inside: Interior) -> Interior {
        if self.distance <= 0.0 {
            return inside;
        }
        // The exponential fade keeps exp(-(1 - fade_color) depth / distance).
        Interior { fade_color: Vec3::ONE + self.color.map(f32::ln), fade_distance: self.distance, fade_power: 1000.0, ..inside }
    }

    /// For the path integrator.
    pub fn medium(&self) -> Option<Volume> {
        let absorption = self.color.map(|c| -c.ln()) / self.distance as f32;
        let absorbs = self.solid && self.distance > 0.0 && absorption.max_element() > 0.0 && absorption.is_finite();
        absorbs.then_some(Volume { absorption, scattering: Vec3::ZERO, emission: Vec3::ZERO, anisotropy: 0.0, density: None })
    }
}

/// KHR_materials_volume. Its thickness counts as much as "none" or "some": where light enters and leaves is traced.
pub(super) fn volume(reader: &Reader, others: Option<&Others>) -> Result<Option<Body>, ImportError> {
    let Some(r) = reader.record(others, "KHR_materials_volume")? else { return Ok(None) };
    let solid = r.positive_or("thicknessFactor", 0.0)? > 0.0;
    let color = r.numbers::<3>("attenuationColor")?.unwrap_or([1.0; 3]).map(|c| c.clamp(1e-6, 1.0) as f32);
    Ok(Some(Body { solid, color: Vec3::from(color), distance: r.positive_or("attenuationDistance", 0.0)? }))
}

/// The surface that a material's extensions make of its closure.
pub(super) fn surface<'a>(
    reader: &mut Reader<'a>,
    m: &'a json::Material,
    mut c: PrincipledClosure,
    body: Option<&Body>,
) -> Result<Closure, ImportError> {
    let Some(e) = &m.extensions else { return Ok(principled(c)) };
    let others = Some(&e.others);
    if e.others.contains_key("KHR_materials_unlit") {
        // Its corner colours shine too; nothing else of it answers to light.
        c.emission_color.vertex_color = true;
        return Ok(principled(c));
    }
    if let Some(r) = reader.record(others, "KHR_materials_clearcoat")? {
        clearcoat(reader, &r, &mut c)?;
    }
    if let Some(r) = reader.record(others, "KHR_materials_sheen")? {
        // Khronos: Charlie's distribution; Blender: linearly transformed cosines. Both dim what lies below by their largest channel.
        c.sheen_tint = reader.tint(&r, "sheenColorFactor", 0.0, "sheenColorTexture")?;
        c.sheen_roughness = reader.factor(&r, "sheenRoughnessFactor", 0.0, "sheenRoughnessTexture", Channel::Alpha)?;
        c.sheen_weight = f32::from(c.sheen_tint.factor != Vec3::ZERO).into();
    }
    if let Some(r) = reader.record(others, "KHR_materials_anisotropy")? {
        anisotropy(reader, &r, &mut c)?;
    }
    if let Some(r) = reader.record(others, "KHR_materials_dispersion")?
        && r.positive_or("dispersion", 0.0)? > 0.0
    {
        reader.sink.note_once("gltf: dispersion", None, "dispersion of glass is left out: all colours are bent alike");
    }
    let refracts = c.transmission_weight.as_constant() != Some(0.0);
    // Blender writes no volume, and means a body all the same.
    c.thin_walled = refracts && !reader.from_blender && !body.is_some_and(|b| b.solid);
    let has_film = film(reader, reader.record(others, "KHR_materials_iridescence")?, &mut c)?;
    let specular = specular(reader, m, refracts || has_film.is_some(), &mut c)?;
    Ok(match (has_film, specular) {
        (Some(weight), _) => mix(weight, principled(PrincipledClosure { thin_film_thickness: 0.0.into(), ..c.clone() }), metal_apart(c)),
        (None, Some(weight)) => mix(weight, principled(PrincipledClosure { specular_ior_level: 0.0.into(), ..c.clone() }), metal_apart(c)),
        (None, None) => metal_apart(c),
    })
}

fn principled(c: PrincipledClosure) -> Closure {
    Closure::Principled(Box::new(c))
}

fn mix(factor: Scalar, a: Closure, b: Closure) -> Closure {
    Closure::Mix { factor: MixFactor::Scalar(factor), a: Box::new(a), b: Box::new(b) }
}

/// Blender's specular tint colours the rims of metals too, Khronos's specular colour leaves metals alone.
fn metal_apart(c: PrincipledClosure) -> Closure {
    if c.specular_tint.as_constant() == Some(Vec3::ONE) {
        return principled(c);
    }
    let metal = PrincipledClosure { specular_tint: 1.0.into(), ..c.clone() };
    match c.metallic.as_constant() {
        Some(v) if v <= 0.0 => principled(c),
        Some(v) if v >= 1.0 => principled(metal),
        _ => {
            let factor = c.metallic.clone();
            mix(
                factor,
                principled(PrincipledClosure { metallic: 0.0.into(), ..c }),
                principled(PrincipledClosure { metallic: 1.0.into(), ..metal }),
            )
        }
    }
}

/// Both have a layer of index 1.5 of its own roughness and normals; without a normal texture it is smooth, whatever lies below.
fn clearcoat<'a>(reader: &mut Reader<'a>, r: &Record<'a>, c: &mut PrincipledClosure) -> Result<(), ImportError> {
    c.coat_weight = reader.factor(r, "clearcoatFactor", 0.0, "clearcoatTexture", Channel::Red)?;
    c.coat_roughness = reader.factor(r, "clearcoatRoughnessFactor", 0.0, "clearcoatRoughnessTexture", Channel::Green)?;
    if let Some((picture, scale)) = reader.info(r, "clearcoatNormalTexture", false)? {
        c.coat_normal = Some(Box::new(NormalInput::Map { picture, strength: scale.into(), scale_xy: true }));
    }
    Ok(())
}

/// Khronos: widths mix(α, 1, strength²) along the direction and α across. Blender: α/a and α a with a² = 1 - 0.9 anisotropic, so that widths
/// ten times each other are the most.
fn anisotropy<'a>(reader: &mut Reader<'a>, r: &Record<'a>, c: &mut PrincipledClosure) -> Result<(), ImportError> {
    let strength = r.positive_or("anisotropyStrength", 0.0)?.min(1.0) as f32;
    let rotation = r.number_or("anisotropyRotation", 0.0)?;
    let texture = reader.info(r, "anisotropyTexture", false)?;
    if strength == 0.0 {
        return Ok(());
    }
    let turns = (rotation / TAU) as f32;
    let set = c.normal.as_deref().map_or(0, |n| match n {
        NormalInput::Map { picture, .. } => picture.uv_set,
        NormalInput::Bump { .. } => 0,
    });
    c.tangent = TangentInput::Uv(texture.as_ref().map_or(set, |(p, _)| p.uv_set));
    let Some((picture, _)) = texture else {
        let Some(rough) = c.roughness.as_constant() else {
            reader.sink.note_once(
                "gltf: anisotropy",
                None,
                "anisotropy over a texture of roughness stretches it as if it were rough all over alike",
            );
            (c.anisotropic, _) = stretched(0.5 * c.roughness.factor, strength);
            c.anisotropic_rotation = turns.into();
            return Ok(());
        };
        (c.anisotropic, c.roughness) = stretched(rough, strength);
        c.anisotropic_rotation = turns.into();
        return Ok(());
    };
    if c.roughness.picture.is_some() {
        reader.sink.note_once(
            "gltf: anisotropy",
            None,
            "anisotropy over a texture of roughness stretches it as if it were rough all over alike",
        );
    }
    let rough = c.roughness.as_constant();
    let mean = rough.unwrap_or(0.5 * c.roughness.factor);
    // Red: anisotropic; green: turns; blue: roughness.
    let baked = bake::texels(&picture.texture, |[x, y, b, _]| {
        let (a, r) = stretched(mean, strength * b);
        let turn = (2.0 * y - 1.0).atan2(2.0 * x - 1.0) / TAU as f32;
        [a.factor, (turn + turns).rem_euclid(1.0), r.factor, 1.0]
    });
    // Angles do not mix.
    let nearest = Picture { texture: crate::scene::material::MaterialTexture { linear: false, ..baked }, ..picture };
    let channel = |c| Scalar { factor: 1.0, offset: 0.0, picture: Some((nearest.clone(), c)) };
    c.anisotropic = channel(Channel::Red);
    c.anisotropic_rotation = channel(Channel::Green);
    if rough.is_some() {
        c.roughness = channel(Channel::Blue);
    }
    Ok(())
}

/// Blender's anisotropy and roughness for Khronos's strength over a roughness.
fn stretched(roughness: f32, strength: f32) -> (Scalar, Scalar) {
    let across = (roughness * roughness).clamp(1e-4, 1.0);
    let along = across + (1.0 - across) * strength * strength;
    let anisotropic = ((1.0 - across / along) / 0.9).min(1.0);
    // Where Blender's reach ends the area of the highlight is kept.
    (anisotropic.into(), (along * across).sqrt().sqrt().into())
}

/// The film, and its weight where it is neither all nor nothing. Khronos: over all of the material; here, as in Cycles 4.5, over dielectrics.
fn film<'a>(reader: &mut Reader<'a>, r: Option<Record<'a>>, c: &mut PrincipledClosure) -> Result<Option<Scalar>, ImportError> {
    let Some(r) = r else { return Ok(None) };
    let weight = reader.factor(&r, "iridescenceFactor", 0.0, "iridescenceTexture", Channel::Red)?;
    let (least, most) =
        (r.positive_or("iridescenceThicknessMinimum", 100.0)? as f32, r.positive_or("iridescenceThicknessMaximum", 400.0)? as f32);
    let picture = reader.info(&r, "iridescenceThicknessTexture", false)?.map(|(p, _)| (p, Channel::Green));
    let ior = r.positive_or("iridescenceIor", 1.3)?.max(1.0) as f32;
    if weight.as_constant() == Some(0.0) {
        return Ok(None);
    }
    if c.metallic.as_constant() != Some(0.0) {
        reader.sink.note_once("gltf: films on metals", None, "iridescence is shown where a material is no metal, as in Cycles 4.5");
    }
    c.thin_film_ior = ior.into();
    c.thin_film_thickness = match picture {
        Some(p) => Scalar { factor: most - least, offset: least, picture: Some(p) },
        None => most.into(),
    };
    Ok((weight.as_constant() != Some(1.0)).then_some(weight))
}

/// The tint, and the weight of the highlight where it is not 1.
///
/// Khronos: the weight scales the whole curve, the colour its foot. Blender's exporter writes twice its specular level for the weight, which
/// scales the foot of the curve alone; its files are read so, and glass and films, whose weight has no closure of its own.
fn specular(reader: &mut Reader, m: &json::Material, by_level: bool, c: &mut PrincipledClosure) -> Result<Option<Scalar>, ImportError> {
    let Some(s) = m.extensions.as_ref().and_then(|e| e.specular.as_ref()) else { return Ok(None) };
    c.specular_tint.picture = reader.texture(s.specular_color_texture.as_ref(), true)?;
    let picture = reader.texture(s.specular_texture.as_ref(), false)?.map(|p| (p, Channel::Alpha));
    let weight = Scalar { factor: s.specular_factor.0.clamp(0.0, 1.0), offset: 0.0, picture };
    if by_level || reader.from_blender {
        c.specular_ior_level = Scalar { factor: 0.5 * weight.factor, ..weight };
        return Ok(None);
    }
    c.specular_ior_level = 0.5.into();
    Ok((weight.as_constant() != Some(1.0)).then_some(weight))
}
