//! Materials and their pictures. Source: glTF 2.0, section 3.9, and the KHR extensions named beside the fields.

use super::super::files::{self, Target};
use super::super::{ImportError, picture, plain_material};
use super::Document;
use super::khr;
use super::rayloom::place_of_set;
use crate::diag::Sink;
use crate::math::Vec3;
use crate::savings::{Saving, Savings};
use crate::scene::input::{NormalInput, Picture};
use crate::scene::likeness::closure_of;
use crate::scene::material::{AlphaMode, MaterialImage, MaterialTexture, Wrap};
use crate::scene::{Interior, Principled, Shader, Texture};
use ::gltf::json;
use ::gltf::json::material::AlphaMode as JsonAlpha;
use ::gltf::json::texture::{MagFilter, WrappingMode};
use ::gltf::json::validation::Checked;
use rayon::prelude::*;
use serde_json::Value;
use std::collections::BTreeSet;
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

/// All materials of a file; the last is the one of primitives that name none. `wanted`: the pictures to decode.
pub(super) fn covers(doc: &Document, wanted: &[bool], sink: &mut Sink) -> Result<Vec<Cover>, ImportError> {
    let from_blender = doc.root.asset.generator.as_deref().is_some_and(|g| g.contains("Blender"));
    let images = images(doc, wanted, sink)?;
    let records = doc.root.materials.iter().enumerate();
    let read = records.map(|(ix, record)| {
        Reader { doc, images: &images, ix, from_blender, uv_set: None, more_uvs: false, sink: &mut *sink }.cover(record)
    });
    let mut covers = read.collect::<Result<Vec<_>, _>>()?;
    // glTF's own default is a rough white metal; without a material Blender and its users see plain grey.
    let plain = Texture::Principled(Box::new(plain_material()));
    covers.push(Cover { texture: Arc::new(plain), interior: None, uv_set: 0, all_uvs: false });
    Ok(covers)
}

/// By image: whether a material that faces wear shows it. None is `shown` where each material is going to be replaced.
pub(super) fn wanted_images(doc: &Document, shown: bool, savings: Savings) -> Vec<bool> {
    let root = doc.root;
    let mut wanted = vec![!savings.has(Saving::Textures); root.images.len()];
    if !shown {
        return wanted;
    }
    let worn = root.meshes.iter().flat_map(|m| &m.primitives).filter_map(|p| p.material);
    let worn: BTreeSet<usize> = worn.map(|m| m.value()).collect();
    let mut textures = Vec::new();
    for m in worn.iter().filter_map(|ix| root.materials.get(*ix)) {
        serde_json::to_value(m).iter().for_each(|v| named_textures(v, &mut textures));
    }
    for t in textures.iter().filter_map(|ix| root.textures.get(*ix)) {
        if let Some(w) = wanted.get_mut(t.source.value()) {
            *w = true;
        }
    }
    wanted
}

/// Textures that a material and its extensions name, but those of occlusion.
fn named_textures(v: &Value, out: &mut Vec<usize>) {
    let Some(fields) = v.as_object() else { return };
    for (name, field) in fields.iter().filter(|(name, _)| *name != "occlusionTexture") {
        let index = field.get("index").and_then(Value::as_u64).filter(|_| name.ends_with("Texture"));
        out.extend(index.map(|ix| ix as usize));
        named_textures(field, out);
    }
}

/// The decoded pictures that are wanted; those that cannot be had are `None`, with a note.
fn images(doc: &Document, wanted: &[bool], sink: &mut Sink) -> Result<Vec<Option<Arc<MaterialImage>>>, ImportError> {
    let n = doc.root.images.len();
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
pub(super) struct Reader<'a> {
    pub doc: &'a Document<'a>,
    images: &'a [Option<Arc<MaterialImage>>],
    ix: usize,
    /// The file is Blender's, whose exporter has its own reading of some extensions.
    pub from_blender: bool,
    /// The set of its first picture.
    uv_set: Option<u32>,
    /// Its pictures use several sets.
    more_uvs: bool,
    pub sink: &'a mut Sink,
}

impl<'a> Reader<'a> {
    pub fn place(&self) -> String {
        let name = self.doc.root.materials.get(self.ix).and_then(|m| m.name.as_deref());
        name.map_or_else(|| format!("material {}", self.ix), |n| format!("material '{n}'"))
    }

    fn cover(mut self, m: &'a json::Material) -> Result<Cover, ImportError> {
        let pbr = &m.pbr_metallic_roughness;
        let [r, g, b, alpha] = pbr.base_color_factor.0;
        let cutoff = m.alpha_cutoff.unwrap_or_default().0;
        let base_color = self.texture(pbr.base_color_texture.as_ref(), true)?;
        let metallic_roughness = self.texture(pbr.metallic_roughness_texture.as_ref(), false)?;
        let emission = self.texture(m.emissive_texture.as_ref(), true)?;
        let normal = match &m.normal_texture {
            Some(n) => {
                let transform = n.extensions.as_ref().and_then(|e| e.others.get("KHR_texture_transform"));
                let (set, transform) = khr::transform_of(self.doc, transform, n.tex_coord, || self.place())?;
                self.picture(n.index.value(), set, transform, false)?
            }
            None => None,
        };
        let texture = |p: &Option<Picture>| p.as_ref().map(|p| p.texture.clone());
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
            base_color_texture: texture(&base_color),
            metallic_roughness_texture: texture(&metallic_roughness),
            emission_texture: texture(&emission),
            normal_texture: texture(&normal),
            normal_scale: m.normal_texture.as_ref().map_or(1.0, |n| n.scale),
            ..Principled::default()
        };
        if m.occlusion_texture.is_some() {
            self.sink.note_once("gltf: occlusion", None, "occlusion textures are left out: shadows are computed");
        }
        let transmission = match &m.extensions {
            Some(e) => self.extensions(e, &mut p)?,
            None => None,
        };
        let numbers = [p.alpha, p.metallic, p.roughness, p.ior, p.specular, p.transmission, p.normal_scale];
        if !(p.base_color.is_finite() && p.emission.is_finite() && p.specular_color.is_finite() && numbers.iter().all(|v| v.is_finite())) {
            return Err(self.doc.invalid(self.place(), "one of its numbers is not finite"));
        }
        let mut interior = None;
        // What the path integrator simulates: each picture on its own coordinates, and what the likeness above has no word for.
        let mut closure = closure_of(&p);
        for (at, read) in [(&mut closure.base_color.picture, base_color), (&mut closure.emission_color.picture, emission)] {
            if at.is_some() && read.is_some() {
                *at = read;
            }
        }
        for (scalar, read) in [
            (&mut closure.metallic, &metallic_roughness),
            (&mut closure.roughness, &metallic_roughness),
            (&mut closure.transmission_weight, &transmission),
        ] {
            if let (Some((at, _)), Some(read)) = (&mut scalar.picture, read) {
                *at = read.clone();
            }
        }
        if let (Some((at, _)), Some(read)) = (&mut closure.alpha.picture, &closure.base_color.picture) {
            *at = read.clone();
        }
        if let (Some(NormalInput::Map { picture, .. }), Some(read)) = (closure.normal.as_deref_mut(), normal) {
            *picture = read;
        }
        let others = m.extensions.as_ref().map(|e| &e.others);
        let volume = khr::volume(&self, others)?;
        if p.transmission > 0.0 {
            let inside = Interior { ior: f64::from(p.ior), ..Interior::default() };
            interior = Some(volume.as_ref().map_or(inside.clone(), |v| v.interior(inside)));
        }
        let surface = khr::surface(&mut self, m, closure, volume.as_ref())?;
        p.shader = Some(Arc::new(Shader {
            surface: Some(surface),
            volume: volume.filter(|_| p.transmission > 0.0).and_then(|v| v.medium()),
            transparent_shadow: true,
            name: p.name.to_string(),
            ..Shader::default()
        }));
        let (uv_set, all_uvs) = (self.uv_set.unwrap_or(0), self.more_uvs);
        Ok(Cover { texture: Arc::new(Texture::Principled(Box::new(p))), interior: interior.map(Arc::new), uv_set, all_uvs })
    }

    /// What the likeness knows of the extensions; gives the picture of the transmission.
    fn extensions(&mut self, e: &json::extensions::material::Material, p: &mut Principled) -> Result<Option<Picture>, ImportError> {
        let mut transmission = None;
        if let Some(s) = &e.emissive_strength {
            p.emission *= s.emissive_strength.0;
        }
        if let Some(i) = &e.ior {
            // 0 stands for "reflects all", which no index gives; glTF's own reading of it.
            p.ior = if i.ior.0 == 0.0 { 1e6 } else { i.ior.0.max(1.0) };
        }
        if let Some(t) = &e.transmission {
            p.transmission = t.transmission_factor.0;
            transmission = self.texture(t.transmission_texture.as_ref(), false)?;
            p.transmission_texture = transmission.as_ref().map(|t| t.texture.clone());
        }
        if let Some(s) = &e.specular {
            p.specular = s.specular_factor.0;
            p.specular_color = Vec3::from_array(s.specular_color_factor.0);
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
        Ok(transmission)
    }

    /// The picture of one of the core's textures.
    pub fn texture(&mut self, info: Option<&json::texture::Info>, srgb: bool) -> Result<Option<Picture>, ImportError> {
        let Some(info) = info else { return Ok(None) };
        let transform = info.extensions.as_ref().and_then(|e| e.texture_transform.as_ref());
        let set = transform.and_then(|t| t.tex_coord).unwrap_or(info.tex_coord);
        let matrix = transform.map_or(khr::IDENTITY, |t| khr::affine(t.offset.0, t.rotation.0, t.scale.0));
        self.picture(info.index.value(), set, matrix, srgb)
    }

    /// Texture `texture_ix` over set `uv_set` of the file's coordinates.
    pub fn picture(
        &mut self,
        texture_ix: usize,
        uv_set: u32,
        uv_transform: [[f32; 3]; 2],
        srgb: bool,
    ) -> Result<Option<Picture>, ImportError> {
        let record = self.doc.get(&self.doc.root.textures, texture_ix, "texture", || self.place())?;
        let source = record.source.value();
        if source == u32::MAX as usize {
            let message = "a texture names no PNG or JPEG image and is left out";
            self.sink.note_once("gltf: no image", None, message);
            return Ok(None);
        }
        let Some(image) = self.doc.get(self.images, source, "image", || format!("texture {texture_ix}"))?.clone() else { return Ok(None) };
        let first = *self.uv_set.get_or_insert(uv_set);
        if first != uv_set {
            self.more_uvs = true;
            let message = format!(
                "{} uses two sets of texture coordinates; without --integrator path all its textures take set {first}",
                self.place()
            );
            self.sink.note_once("gltf: uv sets", None, message);
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
        let texture = MaterialTexture { image, srgb, wrap: [wrap(sampler.wrap_s), wrap(sampler.wrap_t)], linear, uv_transform };
        Ok(Some(Picture { texture, uv_set: place_of_set(uv_set, first), filter_encoded: false, premultiplied: false }))
    }
}
