//! Records of material libraries → materials. The numbers are read as Blender writes them (colours linear, `Ks` 0.5 is a common surface).

use super::super::{files, picture, plain_material};
use super::mtl::{MapRecord, MtlRecord};
use crate::diag::Sink;
use crate::math::Vec3;
use crate::scene::material::{AlphaMode, MaterialImage, MaterialTexture, Texels, Wrap};
use crate::scene::{Interior, Principled, Texture};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A material, shared by all that wear it.
#[derive(Clone)]
pub(super) struct Cover {
    pub texture: Arc<Texture>,
    pub interior: Option<Arc<Interior>>,
}

/// Roughness of materials that say nothing about it: Blender's default.
const DEFAULT_ROUGHNESS: f32 = 0.5;

/// The materials of a file; pictures are read once.
pub(super) struct Materials {
    records: HashMap<String, MtlRecord>,
    pictures: HashMap<PathBuf, Option<Arc<MaterialImage>>>,
}

impl Materials {
    /// Of these records; of those with one name the last counts.
    pub fn new(records: Vec<MtlRecord>) -> Self {
        Self { records: records.into_iter().map(|r| (r.name.clone(), r)).collect(), pictures: HashMap::new() }
    }

    /// The material of a name; a plain one for names that no library has.
    pub fn cover(&mut self, name: &str, sink: &mut Sink) -> Cover {
        let record = self.records.get(name).cloned().unwrap_or_else(|| {
            if !name.is_empty() {
                sink.note_once(&format!("obj: material {name}"), None, format!("no library has the material '{name}'; it is plain grey"));
            }
            MtlRecord::default()
        });
        let (mut p, interior) = self.principled(&record, sink);
        p.name = name.into();
        Cover { texture: Arc::new(Texture::Principled(Box::new(p))), interior: interior.map(Arc::new) }
    }

    fn principled(&mut self, m: &MtlRecord, sink: &mut Sink) -> (Principled, Option<Interior>) {
        let default_color = if m.map_diffuse.is_some() { 1.0 } else { 0.8 };
        let mean = |c: [f32; 3]| (c[0] + c[1] + c[2]) / 3.0;
        let mut p = Principled {
            base_color: Vec3::from_array(m.diffuse.unwrap_or([default_color; 3])).max(Vec3::ZERO),
            // Blender's own way from exponents to roughness.
            roughness: m
                .roughness
                .unwrap_or_else(|| m.exponent.map_or(DEFAULT_ROUGHNESS, |n| 1.0 - (n.clamp(0.0, 1000.0) / 1000.0).sqrt())),
            metallic: m.metallic.unwrap_or(0.0).clamp(0.0, 1.0),
            specular: m.specular.map_or(1.0, |c| (2.0 * mean(c)).clamp(0.0, 2.0)),
            // Many writers give 0 or 1 where they mean nothing.
            ior: m.ior.filter(|n| *n > 1.0).unwrap_or(1.5),
            emission: Vec3::from_array(m.emission.unwrap_or([0.0; 3])).max(Vec3::ZERO),
            ..plain_material()
        };
        p.roughness = p.roughness.clamp(0.0, 1.0);
        let alpha = m.alpha.unwrap_or(1.0).clamp(0.0, 1.0);
        // Illumination models 4, 6, 7 and 9 are glass: what is clear there refracts.
        if matches!(m.illum, Some(4 | 6 | 7 | 9)) {
            p.transmission = if alpha < 1.0 { 1.0 - alpha } else { m.filter.map_or(0.0, mean).clamp(0.0, 1.0) };
        } else if alpha < 1.0 {
            (p.alpha, p.alpha_mode) = (alpha, AlphaMode::Blend);
        }
        p.base_color_texture = self.texture(m.map_diffuse.as_ref(), true, sink);
        p.emission_texture = self.texture(m.map_emission.as_ref(), true, sink);
        if p.emission_texture.is_some() && m.emission.is_none() {
            p.emission = Vec3::ONE;
        }
        self.alpha_map(m, &mut p, sink);
        self.numbers_maps(m, &mut p, sink);
        if let Some(map) = &m.map_bump
            && let Some(mut t) = self.texture(Some(map), false, sink)
        {
            p.normal_scale = map.bump;
            if is_grey(&t.image) {
                t.image = Arc::new(normals_of_heights(&t.image));
            }
            p.normal_texture = Some(t);
        }
        let interior = (p.transmission > 0.0).then(|| Interior { ior: f64::from(p.ior), ..Interior::default() });
        (p, interior)
    }

    /// `map_d`: the alpha of the colour picture itself, or a picture of its own, whose alpha counts if it has any, else its grey.
    fn alpha_map(&mut self, m: &MtlRecord, p: &mut Principled, sink: &mut Sink) {
        let Some(map) = &m.map_alpha else { return };
        p.alpha_mode = AlphaMode::Blend;
        if m.map_diffuse.as_ref().is_some_and(|d| d.file == map.file) {
            return;
        }
        if let Some(mut t) = self.texture(Some(map), false, sink) {
            let has_alpha = texels(&t.image).any(|c| c[3] < 1.0);
            let alpha = |c: [f32; 4]| byte(if has_alpha { c[3] } else { (c[0] + c[1] + c[2]) / 3.0 });
            let list = texels(&t.image).map(|c| [255, 255, 255, alpha(c)]).collect();
            t.image = Arc::new(MaterialImage { texels: Texels::Rgba8(list), ..*t.image });
            p.alpha_texture = Some(t);
        }
    }

    /// `map_Pr` and `map_Pm` become one picture, roughness in green, metallic in blue.
    fn numbers_maps(&mut self, m: &MtlRecord, p: &mut Principled, sink: &mut Sink) {
        let rough = self.texture(m.map_roughness.as_ref(), false, sink);
        let metal = self.texture(m.map_metallic.as_ref(), false, sink);
        // A picture replaces the number; Blender writes 1 or nothing beside it.
        if rough.is_some() {
            p.roughness = 1.0;
        }
        if metal.is_some() {
            p.metallic = 1.0;
        }
        let Some(first) = rough.as_ref().or(metal.as_ref()) else { return };
        let size = |t: &MaterialTexture| (t.image.width, t.image.height);
        let (w, h) = [&rough, &metal].into_iter().flatten().map(size).max_by_key(|s| u64::from(s.0) * u64::from(s.1)).unwrap_or((1, 1));
        let at = |t: &Option<MaterialTexture>, x: u32, y: u32| {
            let Some(i) = t.as_ref().map(|t| &t.image) else { return 255 };
            let scaled = |k: u32, n: u32, of: u32| (u64::from(k) * u64::from(of) / u64::from(n)) as usize;
            byte(texel(i, scaled(y, h, i.height) * i.width as usize + scaled(x, w, i.width))[0])
        };
        let list = (0..h).flat_map(|y| (0..w).map(move |x| (x, y))).map(|(x, y)| [255, at(&rough, x, y), at(&metal, x, y), 255]).collect();
        let image = Arc::new(MaterialImage { width: w, height: h, texels: Texels::Rgba8(list) });
        p.metallic_roughness_texture = Some(MaterialTexture { image, ..first.clone() });
    }

    fn texture(&mut self, map: Option<&MapRecord>, srgb: bool, sink: &mut Sink) -> Option<MaterialTexture> {
        let map = map?;
        let image = self.pictures.entry(map.file.clone()).or_insert_with(|| read_picture(&map.file, sink)).clone()?;
        let wrap = if map.clamp { Wrap::Clamp } else { Wrap::Repeat };
        // OBJ's v runs up; the picture's runs down.
        let ([su, sv], [ou, ov]) = (map.scale, map.offset);
        Some(MaterialTexture { image, srgb, wrap: [wrap; 2], linear: true, uv_transform: [[su, 0.0, ou], [0.0, -sv, 1.0 - ov]] })
    }
}

fn read_picture(file: &Path, sink: &mut Sink) -> Option<Arc<MaterialImage>> {
    let decoded = files::read(file).map_err(|e| e.to_string()).and_then(|b| picture::decode(&b));
    match decoded {
        Ok(image) => Some(Arc::new(image)),
        Err(why) => {
            let key = format!("obj: picture {}", file.display());
            sink.note_once(&key, None, format!("the picture '{}' is left out: {why}", file.display()));
            None
        }
    }
}

fn byte(v: f32) -> u8 {
    (v.clamp(0.0, 1.0) * 255.0).round() as u8
}

/// A texel as it is in the file, 0..=1.
fn texel(i: &MaterialImage, k: usize) -> [f32; 4] {
    match &i.texels {
        Texels::Rgba8(list) => list[k].map(|v| f32::from(v) / 255.0),
        Texels::Rgba16(list) => list[k].map(|v| f32::from(v) / 65535.0),
        Texels::RgbaF32(list) => list[k],
    }
}

fn texels(i: &MaterialImage) -> impl Iterator<Item = [f32; 4]> {
    (0..i.width as usize * i.height as usize).map(move |k| texel(i, k))
}

/// Heights rather than normals: no texel has a colour.
fn is_grey(i: &MaterialImage) -> bool {
    texels(i).all(|c| (c[0] - c[1]).abs() < 0.02 && (c[1] - c[2]).abs() < 0.02)
}

/// Tangent-space normals of heights by central differences; black to white over one texel is a slope of 1.
fn normals_of_heights(i: &MaterialImage) -> MaterialImage {
    let (w, h) = (i.width as usize, i.height as usize);
    let height = |x: usize, y: usize| texel(i, (y % h) * w + x % w)[0];
    let normal = |k: usize| {
        let (x, y) = (k % w, k / w);
        let along_x = 0.5 * (height(x + 1, y) - height(x + w - 1, y));
        let along_up = 0.5 * (height(x, y + h - 1) - height(x, y + 1));
        let n = Vec3::new(-along_x, -along_up, 1.0).normalize();
        let code = |v: f32| (65535.0 * (0.5 * v + 0.5)).round() as u16;
        [code(n.x), code(n.y), code(n.z), u16::MAX]
    };
    MaterialImage { width: i.width, height: i.height, texels: Texels::Rgba16((0..w * h).map(normal).collect()) }
}
