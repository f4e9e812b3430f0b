//! Materials of the path integrator as words: a list of steps over the tree of closures, and a record for each closure.
//! Twins: `shaders/path/closures.wesl`, `shaders/path/shading.wesl`, `shaders/path/principled.wesl`.

use super::super::buffers::append;
use super::inputs::{Encoder, refused};
use super::tables::AlbedoTables;
use super::volumes::Volumes;
use crate::backend::BackendError;
use crate::integrate::path::plain_emission;
use crate::kernel::bsdf::albedo::dielectric_mean;
use crate::kernel::bsdf::fresnel::highlight_of;
use crate::math::Vec3;
use crate::scene::input::Scalar;
use crate::scene::shader::{Closure, Distribution, HairColor, MixFactor, PrincipledClosure, Shader, SubsurfaceMethod};

/// Words of the Principled closure: name and length.
const PRINCIPLED: &[(&str, u32)] = &[
    ("KIND", 1),
    ("BASE_COLOR", 4),
    ("METALLIC", 2),
    ("ROUGHNESS", 2),
    ("ALPHA", 2),
    ("NORMAL", 1),
    ("MULTI", 1),
    ("DIFFUSE_ROUGHNESS", 2),
    ("SPECULAR_TINT", 4),
    ("SPECULAR_ETA", 1),
    ("SPECULAR_F0", 1),
    ("SPECULAR_TABLE", 1),
    ("SPECULAR_MEAN", 1),
    ("ANISOTROPIC", 2),
    ("ANISOTROPIC_ROTATION", 2),
    ("TANGENT", 1),
    ("TRANSMISSION", 2),
    ("GLASS", 3),
    ("PANE", 1),
    ("COAT_WEIGHT", 2),
    ("COAT_ROUGHNESS", 2),
    ("COAT", 2),
    ("COAT_TINT", 4),
    ("COAT_NORMAL", 1),
    ("SHEEN_WEIGHT", 2),
    ("SHEEN_ROUGHNESS", 2),
    ("SHEEN_TINT", 4),
    ("SUBSURFACE_WEIGHT", 2),
    ("SUBSURFACE_RADIUS", 4),
    ("SUBSURFACE_SCALE", 2),
    ("SUBSURFACE_ANISOTROPY", 2),
    ("SUBSURFACE_IOR", 2),
    ("SUBSURFACE_SKIN", 1),
    ("EMISSION_COLOR", 4),
    ("EMISSION_STRENGTH", 2),
    ("FILM_THICKNESS", 2),
    ("FILM_IOR", 2),
];
const CLOSURES: [&str; 13] = [
    "PRINCIPLED",
    "EMISSION",
    "TRANSPARENT",
    "DIFFUSE",
    "TRANSLUCENT",
    "SHEEN",
    "GLOSSY",
    "GLASS",
    "REFRACTION",
    "HOLDOUT",
    "HAIR",
    "SUBSURFACE",
    "CONDUCTOR",
];
const HAIR_COLORS: [&str; 3] = ["ABSORPTION", "MELANIN", "REFLECTANCE"];
const MIXES: [&str; 4] = ["SCALAR", "FRESNEL", "FACING", "BACK"];
const STEPS: [&str; 4] = ["CLOSURE", "MIX", "ADD", "BACK"];
/// Words of a material before its steps: bits, emission of front and back, number of steps, place of its volume.
const STEPS_AT: u32 = 9;
const CLEAR_SHADOW: u32 = 1;
const PLAIN_EMISSION: u32 = 2;

/// Names and numbers for the shaders.
pub(super) fn material_constants() -> Vec<(String, u32)> {
    let mut at = 0;
    let places = PRINCIPLED.iter().map(|(name, len)| {
        at += len;
        (format!("P_{name}"), at - len)
    });
    let numbered = |prefix: &str, names: &[&str]| (0..).zip(names).map(|(k, n)| (format!("{prefix}_{n}"), k)).collect::<Vec<_>>();
    let others = [
        ("MATERIAL_EMISSION", 1),
        ("MATERIAL_N_STEPS", 7),
        ("MATERIAL_VOLUME", 8),
        ("MATERIAL_STEPS", STEPS_AT),
        ("MATERIAL_CLEAR_SHADOW", CLEAR_SHADOW),
        ("MATERIAL_PLAIN_EMISSION", PLAIN_EMISSION),
    ];
    places
        .chain(numbered("CLOSURE", &CLOSURES))
        .chain(numbered("HAIR", &HAIR_COLORS))
        .chain(numbered("MIX", &MIXES))
        .chain(numbered("STEP", &STEPS))
        .chain(others.map(|(n, v)| (n.to_owned(), v)))
        .collect()
}

/// What the shaders must have room for.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Room {
    /// Lobes of a hit.
    pub lobes: u32,
    /// Closures that wait for their weight.
    pub stack: u32,
    /// Closures of a material.
    pub closures: u32,
}

/// Materials in words.
pub(super) struct Materials {
    /// Place of the list of their places.
    pub at: u32,
    /// Whether shadow rays go on behind each.
    pub clear: Vec<bool>,
    /// Place of the volume of each, 0 for none.
    pub volumes: Vec<u32>,
}

/// Encodes materials.
pub(super) fn encode_materials(
    list: &[std::sync::Arc<Shader>],
    e: &mut Encoder,
    tables: &mut AlbedoTables,
    room: &mut Room,
    volumes: &mut Volumes,
) -> Result<Materials, BackendError> {
    let mut places = Vec::with_capacity(list.len());
    let mut of_volumes = Vec::with_capacity(list.len());
    let mut clear = Vec::with_capacity(list.len());
    for shader in list {
        let mut steps = Vec::new();
        let mut own = Room::default();
        if let Some(c) = &shader.surface {
            Steps { e, tables, room: &mut own, depth: 0, steps: &mut steps }.add(c)?;
        } else {
            e.features.insert("passes");
        }
        own.closures = steps.chunks(2).filter(|s| s[0] == 0).count() as u32;
        *room = Room { lobes: room.lobes.max(own.lobes), stack: room.stack.max(own.stack), closures: room.closures.max(own.closures) };
        let goes_on = shader.may_let_through() && (shader.transparent_shadow || shader.surface.is_none());
        let emission = shader.surface.as_ref().map_or(Some([Vec3::ZERO; 2]), plain_emission);
        if emission.is_none() {
            e.features.insert("varying_emission");
        }
        let flag = |holds: bool, bit: u32| if holds { bit } else { 0 };
        let mut w = vec![flag(goes_on, CLEAR_SHADOW) | flag(emission.is_some(), PLAIN_EMISSION)];
        w.extend(emission.unwrap_or_default().iter().flat_map(|c| c.to_array()).map(f32::to_bits));
        w.push(steps.len() as u32 / 2);
        let volume = shader.volume.as_ref().map_or(0, |v| volumes.encode(v, e));
        of_volumes.push(volume);
        w.push(volume);
        w.extend(steps);
        places.push(append(&mut e.words, w));
        clear.push(goes_on);
    }
    Ok(Materials { at: append(&mut e.words, places), clear, volumes: of_volumes })
}

/// The roughness that tables are asked for: with stretched lobes, whose widths end at 1, it may be any below the material's.
fn any_where<'s>(anisotropy: &'s Scalar, roughness: &'s Scalar) -> Option<&'s Scalar> {
    is_zero(anisotropy).then_some(roughness)
}

fn is_zero(s: &Scalar) -> bool {
    s.as_constant() == Some(0.0)
}

/// The steps of one material.
struct Steps<'s> {
    e: &'s mut Encoder,
    tables: &'s mut AlbedoTables,
    room: &'s mut Room,
    depth: u32,
    steps: &'s mut Vec<u32>,
}

impl Steps<'_> {
    fn need(&mut self, feature: &'static str) {
        self.e.features.insert(feature);
    }

    fn facets(&mut self, lobes: u32) {
        self.need("microfacets");
        self.room.lobes += lobes;
    }

    fn constant(&self, s: &Scalar, what: &str) -> Result<f32, BackendError> {
        s.as_constant().map_or_else(|| refused(what), Ok)
    }

    fn add(&mut self, c: &Closure) -> Result<(), BackendError> {
        match c {
            Closure::Mix { factor, a, b } => {
                self.need("mixes");
                let (kind, value) = match factor {
                    MixFactor::Scalar(s) => (0, s.clone()),
                    MixFactor::Fresnel(s) => {
                        self.need("microfacets");
                        (1, s.clone())
                    }
                    MixFactor::Facing(s) => (2, s.clone()),
                    MixFactor::Backfacing => (3, Scalar::constant(0.0)),
                    MixFactor::ByRay(_) => return refused("materials that depend on the kind of ray"),
                };
                let [x, y] = self.e.scalar(&value)?;
                let at = append(&mut self.e.words, [kind, x, y]);
                self.both(1, at, a, b)
            }
            Closure::Add(a, b) => {
                self.need("mixes");
                self.both(2, 0, a, b)
            }
            leaf => {
                let place = self.closure(leaf)?;
                self.steps.extend([0, place]);
                Ok(())
            }
        }
    }

    fn both(&mut self, step: u32, at: u32, a: &Closure, b: &Closure) -> Result<(), BackendError> {
        self.steps.extend([step, at]);
        self.depth += 1;
        self.room.stack = self.room.stack.max(self.depth);
        self.add(a)?;
        self.depth -= 1;
        self.steps.extend([3, 0]);
        self.add(b)
    }

    /// Place of a closure's words.
    fn closure(&mut self, c: &Closure) -> Result<u32, BackendError> {
        let kind = |name: &str| CLOSURES.iter().position(|n| *n == name).expect("a name of the list") as u32;
        let w = match c {
            Closure::Principled(p) => return self.principled(p),
            Closure::Emission { color, strength } => {
                self.need("plain_emission");
                [&[kind("EMISSION")][..], &self.e.color(color)?, &self.e.scalar(strength)?].concat()
            }
            Closure::Transparent { color } => {
                self.need("passes");
                [&[kind("TRANSPARENT")][..], &self.e.color(color)?].concat()
            }
            Closure::Diffuse { color, roughness, normal } => {
                self.room.lobes += 1;
                if !is_zero(roughness) {
                    self.need("oren_nayar");
                }
                let normal = self.e.normal(normal.as_deref())?;
                [&[kind("DIFFUSE")][..], &self.e.color(color)?, &[normal], &self.e.scalar(roughness)?].concat()
            }
            Closure::Translucent { color, normal } => {
                self.room.lobes += 1;
                self.need("translucent");
                let normal = self.e.normal(normal.as_deref())?;
                [&[kind("TRANSLUCENT")][..], &self.e.color(color)?, &[normal]].concat()
            }
            Closure::Sheen { color, roughness, normal } => {
                self.room.lobes += 1;
                self.need("sheen");
                self.need("plain_sheen");
                let normal = self.e.normal(normal.as_deref())?;
                [&[kind("SHEEN")][..], &self.e.color(color)?, &[normal], &self.e.scalar(roughness)?].concat()
            }
            Closure::Glossy { distribution, color, roughness, anisotropy, rotation, normal } => {
                self.facets(1);
                self.need("plain_glossy");
                if !is_zero(anisotropy) {
                    self.need("anisotropic");
                }
                let multi = *distribution == Distribution::MultiGgx;
                if multi {
                    self.tables.mirror(any_where(anisotropy, roughness));
                }
                let normal = self.e.normal(normal.as_deref())?;
                let (a, r) = (self.e.scalar(anisotropy)?, self.e.scalar(rotation)?);
                let head = [&[kind("GLOSSY")][..], &self.e.color(color)?, &[normal], &self.e.scalar(roughness)?].concat();
                [&head[..], &a, &r, &[u32::from(multi)]].concat()
            }
            Closure::Conductor(c) => {
                self.facets(1);
                self.need("conductor");
                if !is_zero(&c.anisotropy) {
                    self.need("anisotropic");
                }
                let multi = c.distribution == Distribution::MultiGgx;
                if multi {
                    self.tables.mirror(any_where(&c.anisotropy, &c.roughness));
                }
                let normal = self.e.normal(c.normal.as_deref())?;
                let (a, r) = (self.e.scalar(&c.anisotropy)?, self.e.scalar(&c.rotation)?);
                let head = [&[kind("CONDUCTOR")][..], &self.e.color(&c.ior)?, &[normal], &self.e.scalar(&c.roughness)?].concat();
                [&head[..], &a, &r, &[u32::from(multi)], &self.e.color(&c.extinction)?].concat()
            }
            Closure::Glass { distribution, color, roughness, ior, film_thickness, film_ior, normal } => {
                self.facets(1);
                if !is_zero(film_thickness) {
                    self.need("thin_film");
                }
                self.need("refraction");
                self.need("plain_glass");
                let normal = self.e.normal(normal.as_deref())?;
                let glass = self.glass_words(*distribution, ior, roughness)?;
                let (thickness, film_ior) = (self.e.scalar(film_thickness)?, self.e.scalar(film_ior)?);
                let head = [&[kind("GLASS")][..], &self.e.color(color)?, &[normal], &self.e.scalar(roughness)?, &glass].concat();
                [&head[..], &thickness, &film_ior].concat()
            }
            Closure::Refraction { color, roughness, ior, normal, .. } => {
                self.facets(1);
                self.need("refraction");
                self.need("plain_refraction");
                let ior = self.constant(ior, "pictures as indices of refraction")?.max(1e-5);
                let normal = self.e.normal(normal.as_deref())?;
                [&[kind("REFRACTION")][..], &self.e.color(color)?, &[normal], &self.e.scalar(roughness)?, &[ior.to_bits()]].concat()
            }
            Closure::Subsurface { method, color, radius, scale, ior, anisotropy, roughness, normal } => {
                self.room.lobes += 1;
                self.need("subsurface");
                self.need("plain_subsurface");
                let normal = self.e.normal(normal.as_deref())?;
                let (radius, scale, g) = (self.e.color(radius)?, self.e.scalar(scale)?, self.e.scalar(anisotropy)?);
                let (ior, rough) = (self.e.scalar(ior)?, self.e.scalar(roughness)?);
                let skin = u32::from(*method == SubsurfaceMethod::RandomWalkSkin);
                let head = [&[kind("SUBSURFACE")][..], &self.e.color(color)?, &[normal], &radius, &scale, &g].concat();
                [&head[..], &ior, &rough, &[skin]].concat()
            }
            Closure::Hair(h) => {
                self.room.lobes += 1;
                self.need("hair");
                let none = Scalar::constant(0.0);
                let (which, color, melanin, redness) = match &h.color {
                    HairColor::Absorption(c) => (0, c, &none, &none),
                    HairColor::Melanin { melanin, redness, tint, .. } => (1, tint, melanin, redness),
                    HairColor::Reflectance(c) => (2, c, &none, &none),
                };
                let mut w = vec![kind("HAIR"), which];
                w.extend(self.e.color(color)?);
                for s in [melanin, redness, &h.roughness, &h.radial_roughness, &h.coat, &h.ior, &h.offset_rad] {
                    w.extend(self.e.scalar(s)?);
                }
                w
            }
            Closure::Holdout => {
                self.need("holes");
                vec![kind("HOLDOUT")]
            }
            Closure::Mix { .. } | Closure::Add(..) => unreachable!("they are steps"),
        };
        Ok(append(&mut self.e.words, w))
    }

    /// Index, and tables of light from both sides.
    fn glass_words(&mut self, d: Distribution, ior: &Scalar, roughness: &Scalar) -> Result<[u32; 3], BackendError> {
        let ior = self.constant(ior, "pictures as indices of refraction")?.max(1e-5);
        let tables = match d {
            Distribution::Ggx => [0, 0],
            Distribution::MultiGgx => [ior, 1.0 / ior].map(|eta| self.tables.glass(eta, Some(roughness), &mut self.e.words)),
        };
        Ok([ior.to_bits(), tables[0], tables[1]])
    }

    fn principled(&mut self, p: &PrincipledClosure) -> Result<u32, BackendError> {
        self.need("principled");
        self.room.lobes += 1;
        let uses = [
            (&p.metallic, "metal", true),
            (&p.transmission_weight, if p.is_pane() { "panes" } else { "principled_glass" }, true),
            (&p.transmission_weight, if p.is_pane() { "passes" } else { "refraction" }, false),
            (&p.coat_weight, "coat", true),
            (&p.sheen_weight, "sheen", true),
            (&p.subsurface_weight, "principled_subsurface", true),
            (&p.subsurface_weight, "subsurface", false),
            (&p.emission_strength, "principled_emission", false),
            (&p.diffuse_roughness, "oren_nayar", false),
            (&p.anisotropic, "anisotropic", false),
            (&p.thin_film_thickness, "thin_film", false),
        ];
        for (input, feature, is_lobe) in uses {
            if !is_zero(input) {
                self.need(feature);
                self.room.lobes += u32::from(is_lobe);
            }
        }
        if p.alpha.as_constant() != Some(1.0) {
            self.need("passes");
        }
        let ior = self.constant(&p.ior, "pictures as indices of refraction")?.max(1e-5);
        let level = self.constant(&p.specular_ior_level, "pictures as specular levels")?.max(0.0);
        let (eta, f0) = highlight_of(ior, level);
        let has_highlight = f0 > 0.0 || eta != 1.0;
        if has_highlight {
            self.need("specular");
            self.room.lobes += 1;
        }
        let has_facets = has_highlight || [&p.metallic, &p.transmission_weight, &p.coat_weight].iter().any(|s| !is_zero(s));
        let mut table = 0;
        if has_facets {
            self.need("microfacets");
            let roughness = any_where(&p.anisotropic, &p.roughness);
            table = self.tables.dielectric(eta, roughness, &mut self.e.words);
            self.tables.mirror(roughness);
        }
        if !is_zero(&p.coat_weight) {
            self.tables.mirror(Some(&p.coat_roughness));
        }
        let coat_ior = self.constant(&p.coat_ior, "pictures as indices of refraction")?.max(1.0);
        let coat_table =
            if is_zero(&p.coat_weight) { 0 } else { self.tables.dielectric(coat_ior, Some(&p.coat_roughness), &mut self.e.words) };
        let glass = if is_zero(&p.transmission_weight) {
            [0; 3]
        } else if p.is_pane() {
            [ior.to_bits(), self.tables.dielectric(ior, Some(&p.roughness), &mut self.e.words), 0]
        } else {
            self.glass_words(p.distribution, &p.ior, &p.roughness)?
        };
        let multi = u32::from(p.distribution == Distribution::MultiGgx);
        let normal = self.e.normal(p.normal.as_deref())?;
        let coat_normal = self.e.normal(p.coat_normal.as_deref())?;
        let n = f32::to_bits;
        let e = &mut *self.e;
        let mut w = vec![0];
        w.extend(e.color(&p.base_color)?);
        w.extend(e.scalar(&p.metallic)?);
        w.extend(e.scalar(&p.roughness)?);
        w.extend(e.scalar(&p.alpha)?);
        w.extend([normal, multi]);
        w.extend(e.scalar(&p.diffuse_roughness)?);
        w.extend(e.color(&p.specular_tint)?);
        w.extend([n(eta), n(f0), table, n(dielectric_mean(eta))]);
        w.extend(e.scalar(&p.anisotropic)?);
        w.extend(e.scalar(&p.anisotropic_rotation)?);
        w.push(if is_zero(&p.anisotropic) { 0 } else { e.tangent(p.tangent) });
        w.extend(e.scalar(&p.transmission_weight)?);
        w.extend(glass);
        w.push(u32::from(p.is_pane()));
        w.extend(e.scalar(&p.coat_weight)?);
        w.extend(e.scalar(&p.coat_roughness)?);
        w.extend([n(coat_ior), coat_table]);
        w.extend(e.color(&p.coat_tint)?);
        w.push(coat_normal);
        w.extend(e.scalar(&p.sheen_weight)?);
        w.extend(e.scalar(&p.sheen_roughness)?);
        w.extend(e.color(&p.sheen_tint)?);
        w.extend(e.scalar(&p.subsurface_weight)?);
        w.extend(e.color(&p.subsurface_radius)?);
        w.extend(e.scalar(&p.subsurface_scale)?);
        w.extend(e.scalar(&p.subsurface_anisotropy)?);
        let skin = p.subsurface_method == SubsurfaceMethod::RandomWalkSkin;
        w.extend(if skin { e.scalar(&p.subsurface_ior)? } else { e.scalar(&Scalar::constant(eta))? });
        w.push(u32::from(skin));
        w.extend(e.color(&p.emission_color)?);
        w.extend(e.scalar(&p.emission_strength)?);
        w.extend(e.scalar(&p.thin_film_thickness)?);
        w.extend(e.scalar(&p.thin_film_ior)?);
        debug_assert_eq!(w.len() as u32, PRINCIPLED.iter().map(|f| f.1).sum::<u32>(), "as the shader reads it");
        Ok(append(&mut e.words, w))
    }
}
