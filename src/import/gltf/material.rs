//! Materials and their pictures. Source: glTF 2.0, section 3.9, and the KHR extensions named beside the fields.

use super::super::files::{self, Target};
use super::super::{ImportError, picture, plain_material};
use super::Document;
use crate::diag::Sink;
use crate::math::Vec3;
use crate::scene::material::{AlphaMode, MaterialImage, MaterialTexture, Wrap};
use crate::scene::{Interior, Principled, Texture};
use ::gltf::json;
use ::gltf::json::material::AlphaMode as JsonAlpha;
use ::gltf::json::texture::{MagFilter, WrappingMode};
use ::gltf::json::validation::Checked;
use rayon::prelude::*;
use serde_json::Value;
use std::sync::Arc;

/// A material, shared by all that wear it.
#[derive(Clone)]
pub(super) struct Cover {
    pub texture: Arc<Texture>,
    /// What fills bodies of it, if light passes through them.
    pub interior: Option<Arc<Interior>>,
    /// Set of texture coordinates that its pictures use.
    pub uv_set: u32,
    /// Its pictures say their sets themselves: the mesh keeps all of them.
    pub all_uvs: bool,
}

/// All materials of a file; the last is the one of primitives that name none. `decode`: their pictures are wanted; else each material is
/// going to be replaced.
pub(super) fn covers(doc: &Document, decode: bool, sink: &mut Sink) -> Result<Vec<Cover>, ImportError> {
    let images = if decode { images(doc, sink)? } else { vec![None; doc.root.images.len()] };
    let records = doc.root.materials.iter().enumerate();
    let read = records.map(|(ix, record)| Reader { doc, images: &images, ix, uv_set: None, sink: &mut *sink }.cover(record));
    let mut covers = read.collect::<Result<Vec<_>, _>>()?;
    // glTF's own default is a rough white metal; without a material Blender and its users see plain grey.
    let plain = Texture::Principled(Box::new(plain_material()));
    covers.push(Cover { texture: Arc::new(plain), interior: None, uv_set: 0, all_uvs: false });
    Ok(covers)
}

/// The decoded pictures that textures name; those that cannot be had are `None`, with a note.
fn images(doc: &Document, sink: &mut Sink) -> Result<Vec<Option<Arc<MaterialImage>>>, ImportError> {
    let n = doc.root.images.len();
    let mut wanted = vec![false; n];
    for t in &doc.root.textures {
        if let Some(w) = wanted.get_mut(t.source.value()) {
            *w = true;
        }
    }
    let decoded: Vec<Result<Option<MaterialImage>, String>> = (0..n)
        .into_par_iter()
        .map(|ix| if wanted[ix] { image_bytes(doc, ix).and_then(|b| picture::decode(&b)).map(Some) } else { Ok(None) })
        .collect();
    let mut out = Vec::with_capacity(n);
    for (ix, result) in decoded.into_iter().enumerate() {
        out.push(result.unwrap_or_else(|why| {
            sink.note_once(&format!("gltf: image {ix}"), None, format!("image {} is left out: {why}", label(doc, ix)));
            None
        }));
    }
    Ok(out.into_iter().map(|i| i.map(Arc::new)).collect())
}

fn label(doc: &Document, ix: usize) -> String {
    let image = &doc.root.images[ix];
    let uri = image.uri.as_deref().filter(|u| !u.starts_with("data:"));
    image.name.as_deref().or(uri).map_or(ix.to_string(), |n| format!("'{n}'"))
}

/// Bytes of an image's file.
pub(super) fn image_bytes(doc: &Document, ix: usize) -> Result<Vec<u8>, String> {
    let image = &doc.root.images[ix];
    match (&image.uri, &image.buffer_view) {
        (Some(uri), _) => match files::resolve(doc.path, uri)? {
            Target::Data(data) => Ok(data),
            Target::File(path) => files::read(&path).map_err(|e| e.to_string()),
        },
        (None, Some(view)) => doc.view(view.value(), || format!("image {ix}")).map(<[u8]>::to_vec).map_err(|e| e.to_string()),
        (None, None) => Err("it has neither an address nor a buffer view".into()),
    }
}

/// Turns one record into a material.
struct Reader<'a> {
    doc: &'a Document<'a>,
    images: &'a [Option<Arc<MaterialImage>>],
    ix: usize,
    uv_set: Option<u32>,
    sink: &'a mut Sink,
}

impl Reader<'_> {
    fn place(&self) -> String {
        let name = self.doc.root.materials.get(self.ix).and_then(|m| m.name.as_deref());
        name.map_or_else(|| format!("material {}", self.ix), |n| format!("material '{n}'"))
    }

    fn cover(mut self, m: &json::Material) -> Result<Cover, ImportError> {
        let pbr = &m.pbr_metallic_roughness;
        let [r, g, b, alpha] = pbr.base_color_factor.0;
        let cutoff = m.alpha_cutoff.unwrap_or_default().0;
        let mut p = Principled {
            base_color: Vec3::new(r, g, b),
            alpha,
            alpha_mode: match m.alpha_mode {
                Checked::Valid(JsonAlpha::Mask) => AlphaMode::Mask(cutoff),
                Checked::Valid(JsonAlpha::Blend) => AlphaMode::Blend,
                _ => AlphaMode::Opaque,
            },
            metallic: pbr.metallic_factor.0,
            roughness: pbr.roughness_factor.0,
            emission: Vec3::from_array(m.emissive_factor.0),
            double_sided: m.double_sided,
            name: m.name.as_deref().unwrap_or_default().into(),
            base_color_texture: self.texture(pbr.base_color_texture.as_ref(), true)?,
            metallic_roughness_texture: self.texture(pbr.metallic_roughness_texture.as_ref(), false)?,
            emission_texture: self.texture(m.emissive_texture.as_ref(), true)?,
            ..Principled::default()
        };
        if let Some(n) = &m.normal_texture {
            let transform = n.extensions.as_ref().and_then(|e| e.others.get("KHR_texture_transform"));
            p.normal_texture = self.picture(n.index.value(), n.tex_coord, transform_of(transform), false)?;
            p.normal_scale = n.scale;
        }
        if m.occlusion_texture.is_some() {
            self.sink.note_once("gltf: occlusion", None, "occlusion textures are left out: shadows are computed");
        }
        let mut interior = None;
        if let Some(e) = &m.extensions {
            self.extensions(e, &mut p)?;
            interior = e.others.get("KHR_materials_volume").map(|v| volume(v, p.ior));
        }
        let numbers = [p.alpha, p.metallic, p.roughness, p.ior, p.specular, p.transmission, p.normal_scale];
        if !(p.base_color.is_finite() && p.emission.is_finite() && p.specular_color.is_finite() && numbers.iter().all(|v| v.is_finite())) {
            return Err(self.doc.invalid(self.place(), "one of its numbers is not finite"));
        }
        if p.transmission > 0.0 {
            interior.get_or_insert_with(|| Interior { ior: f64::from(p.ior), ..Interior::default() });
        } else {
            interior = None;
        }
        let uv_set = self.uv_set.unwrap_or(0);
        Ok(Cover { texture: Arc::new(Texture::Principled(Box::new(p))), interior: interior.map(Arc::new), uv_set, all_uvs: false })
    }

    fn extensions(&mut self, e: &json::extensions::material::Material, p: &mut Principled) -> Result<(), ImportError> {
        if let Some(s) = &e.emissive_strength {
            p.emission *= s.emissive_strength.0;
        }
        if let Some(i) = &e.ior {
            // 0 stands for "reflects all", which no index gives; glTF's own reading of it.
            p.ior = if i.ior.0 == 0.0 { 1e6 } else { i.ior.0.max(1.0) };
        }
        if let Some(t) = &e.transmission {
            p.transmission = t.transmission_factor.0;
            p.transmission_texture = self.texture(t.transmission_texture.as_ref(), false)?;
        }
        if let Some(s) = &e.specular {
            p.specular = s.specular_factor.0;
            p.specular_color = Vec3::from_array(s.specular_color_factor.0);
            if s.specular_texture.is_some() || s.specular_color_texture.is_some() {
                self.sink.note_once("gltf: specular textures", None, "textures of KHR_materials_specular are left out");
            }
        }
        if e.others.contains_key("KHR_materials_unlit") {
            // Seen as it is: it shines with its colour, and light does nothing to it.
            self.sink.note_once("gltf: unlit", None, "unlit materials shine with their colour");
            p.emission = p.base_color;
            p.emission_texture = p.base_color_texture.clone();
            p.base_color = Vec3::ZERO;
            p.metallic = 0.0;
            p.specular = 0.0;
        }
        Ok(())
    }

    fn texture(&mut self, info: Option<&json::texture::Info>, srgb: bool) -> Result<Option<MaterialTexture>, ImportError> {
        let Some(info) = info else { return Ok(None) };
        let transform = info.extensions.as_ref().and_then(|e| e.texture_transform.as_ref());
        let set = transform.and_then(|t| t.tex_coord).unwrap_or(info.tex_coord);
        let matrix = transform.map_or(IDENTITY, |t| affine(t.offset.0, t.rotation.0, t.scale.0));
        self.picture(info.index.value(), set, matrix, srgb)
    }

    fn picture(
        &mut self,
        texture_ix: usize,
        uv_set: u32,
        uv_transform: [[f32; 3]; 2],
        srgb: bool,
    ) -> Result<Option<MaterialTexture>, ImportError> {
        let record = self.doc.get(&self.doc.root.textures, texture_ix, "texture", || self.place())?;
        let source = record.source.value();
        if source == u32::MAX as usize {
            let message = "a texture names no PNG or JPEG image and is left out";
            self.sink.note_once("gltf: no image", None, message);
            return Ok(None);
        }
        let Some(image) = self.doc.get(self.images, source, "image", || format!("texture {texture_ix}"))?.clone() else { return Ok(None) };
        match self.uv_set {
            None => self.uv_set = Some(uv_set),
            Some(known) if known != uv_set => {
                let message = format!("{} uses two sets of texture coordinates; all its textures take set {known}", self.place());
                self.sink.note_once("gltf: uv sets", None, message);
            }
            Some(_) => {}
        }
        let sampler = match record.sampler {
            Some(ix) => self.doc.get(&self.doc.root.samplers, ix.value(), "sampler", || format!("texture {texture_ix}"))?.clone(),
            None => json::texture::Sampler::default(),
        };
        let wrap = |w: Checked<WrappingMode>| match w {
            Checked::Valid(WrappingMode::ClampToEdge) => Wrap::Clamp,
            Checked::Valid(WrappingMode::MirroredRepeat) => Wrap::Mirror,
            _ => Wrap::Repeat,
        };
        let linear = sampler.mag_filter != Some(Checked::Valid(MagFilter::Nearest));
        Ok(Some(MaterialTexture { image, srgb, wrap: [wrap(sampler.wrap_s), wrap(sampler.wrap_t)], linear, uv_transform }))
    }
}

const IDENTITY: [[f32; 3]; 2] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

/// Translation times rotation times scale, as KHR_texture_transform writes it.
fn affine(offset: [f32; 2], rotation: f32, scale: [f32; 2]) -> [[f32; 3]; 2] {
    let (sin, cos) = rotation.sin_cos();
    [[cos * scale[0], sin * scale[1], offset[0]], [-sin * scale[0], cos * scale[1], offset[1]]]
}

/// The same from an extension that the JSON crate has no record for (normal textures).
fn transform_of(value: Option<&Value>) -> [[f32; 3]; 2] {
    let Some(v) = value else { return IDENTITY };
    let number = |v: &Value| v.as_f64().map(|n| n as f32);
    let pair = |key: &str, default: f32| {
        let at = |k: usize| v.get(key).and_then(|p| p.get(k)).and_then(number).unwrap_or(default);
        [at(0), at(1)]
    };
    affine(pair("offset", 0.0), v.get("rotation").and_then(number).unwrap_or(0.0), pair("scale", 1.0))
}

/// KHR_materials_volume: colour^(depth / distance) of the light is left.
fn volume(v: &Value, ior: f32) -> Interior {
    let interior = Interior { ior: f64::from(ior), ..Interior::default() };
    let Some(distance) = v.get("attenuationDistance").and_then(Value::as_f64).filter(|d| *d > 0.0) else { return interior };
    let channel = |k: usize| v.get("attenuationColor").and_then(|c| c.get(k)).and_then(Value::as_f64).unwrap_or(1.0);
    // The exponential fade keeps exp(-(1 - fade_color) depth / distance).
    let fade_color = Vec3::from([0, 1, 2].map(|k| (1.0 + channel(k).clamp(1e-6, 1.0).ln()) as f32));
    Interior { fade_color, fade_distance: distance, fade_power: 1000.0, ..interior }
}
