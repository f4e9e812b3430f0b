//! Pigments, normals, finishes, textures and their maps. Source: spec/language.md, section 8; spec/textures.md, sections 5 and 9.

use super::pattern::list_length;
use super::{PResult, Parser};
use crate::lang::keyword::Kw;
use crate::lang::token::Punct;
use crate::lang::value::{FinishExtras, Value};
use crate::math::{Rgbft, Vec3};
use crate::scene::{BlendMap, Finish, Normal, NormalKind, Pattern, PatternKind, Pigment, PigmentKind, Texture, TextureLayer};
use std::sync::Arc;

/// Most entries of a map.
const MAX_ENTRIES: usize = 256;

/// Colours of list patterns that are not given. Source: spec/textures.md, section 1.
fn default_list_colors(kind: &PatternKind) -> Vec<Rgbft> {
    let (red, green, blue) = (Rgbft::rgb(1.0, 0.0, 0.0), Rgbft::rgb(0.0, 1.0, 0.0), Rgbft::rgb(0.0, 0.0, 1.0));
    match kind {
        PatternKind::Checker | PatternKind::Object(_) => vec![blue, green],
        PatternKind::Hexagon => vec![blue, green, red],
        PatternKind::Brick { .. } => vec![Rgbft::rgb(0.5, 0.5, 0.5), Rgbft::rgb(0.6, 0.15, 0.15)],
        _ => vec![red, green, blue, Rgbft::rgb(1.0, 1.0, 0.0), Rgbft::rgb(0.0, 1.0, 1.0), Rgbft::rgb(1.0, 0.0, 1.0)],
    }
}

fn list_map<T>(entries: Vec<T>) -> BlendMap<T> {
    BlendMap { entries: entries.into_iter().enumerate().map(|(i, e)| (i as f32, e)).collect() }
}

impl Parser<'_> {
    /// `{ ... }` after `pigment`, from the default.
    pub(super) fn parse_pigment_block(&mut self) -> PResult<Arc<Pigment>> {
        let start = self.defaults.pigment.clone();
        self.pigment_block_from(start)
    }

    /// `{ ... }` after `pigment`, going on from `start`.
    pub(super) fn pigment_block_from(&mut self, start: Arc<Pigment>) -> PResult<Arc<Pigment>> {
        let mut pigment = start;
        self.block("pigment", |p| {
            p.pigment_contents(&mut pigment)?;
            Ok(())
        })?;
        Ok(pigment)
    }

    /// What stands between a pigment's braces, or in an entry of a pigment map.
    pub(super) fn pigment_contents(&mut self, pigment: &mut Arc<Pigment>) -> PResult<()> {
        if let Some(Value::Pigment(p) | Value::Density(p)) = self.peek_value()? {
            *pigment = p.clone();
            self.next()?;
        }
        let pigment = Arc::make_mut(pigment);
        if self.accept_kw(Kw::UvMapping)? {
            pigment.uv_mapping = true;
        }
        if self.accept_kw(Kw::ImageMap)? {
            let map = self.parse_image_map("image_map", Kw::ImageMap)?;
            pigment.kind = PigmentKind::ImageMap(map);
            pigment.pattern.kind = PatternKind::Plain;
            pigment.pattern.frequency = 0.0;
        } else if self.pattern_kind(&mut pigment.pattern)? {
            if !matches!(pigment.kind, PigmentKind::ColorMap(_) | PigmentKind::PigmentMap(_))
                || list_length(&pigment.pattern.kind).is_some()
            {
                pigment.kind = PigmentKind::DefaultMap;
            }
            if list_length(&pigment.pattern.kind).is_some() {
                pigment.kind = self.pigment_list(&pigment.pattern.kind)?;
            }
        } else if self.color_follows()? || (self.number_follows()? && !matches!(self.peek_value()?, Some(Value::Function(_)))) {
            let c = self.parse_color()?;
            pigment.kind = PigmentKind::Solid(c);
            pigment.pattern = Pattern::default();
        }
        self.pigment_modifiers(pigment)
    }

    fn pigment_modifiers(&mut self, pigment: &mut Pigment) -> PResult<()> {
        loop {
            self.comma()?;
            if let Some(k) = self.peek_kw()? {
                match k {
                    Kw::ColorMap => {
                        self.next()?;
                        pigment.kind = PigmentKind::ColorMap(self.parse_color_map()?);
                        continue;
                    }
                    Kw::PigmentMap | Kw::DensityMap => {
                        self.next()?;
                        let map = self.parse_pigment_map(k)?;
                        pigment.kind = if matches!(pigment.pattern.kind, PatternKind::Average) {
                            PigmentKind::Average(map)
                        } else {
                            PigmentKind::PigmentMap(map)
                        };
                        continue;
                    }
                    Kw::QuickColor => {
                        self.next()?;
                        pigment.quick_color = Some(self.parse_color()?);
                        continue;
                    }
                    Kw::UvMapping => {
                        self.next()?;
                        pigment.uv_mapping = true;
                        continue;
                    }
                    _ => {}
                }
            }
            if self.pattern_modifier(&mut pigment.pattern)? {
                continue;
            }
            // A colour after modifiers changes a plain pigment.
            if matches!(pigment.kind, PigmentKind::Solid(_)) && self.color_follows()? {
                pigment.kind = PigmentKind::Solid(self.parse_color()?);
                continue;
            }
            break;
        }
        if matches!(pigment.kind, PigmentKind::Solid(_)) {
            // A plain colour has no pattern to bend.
            pigment.pattern = Pattern::default();
        }
        Ok(())
    }

    fn end_of_object_list(&mut self, kind: &PatternKind) -> PResult<()> {
        if matches!(kind, PatternKind::Object(_)) { self.close_block("object") } else { Ok(()) }
    }

    fn pigment_list(&mut self, kind: &PatternKind) -> PResult<PigmentKind> {
        let n = list_length(kind).expect("a list pattern");
        self.comma()?;
        let word = if self.at_kw(Kw::Density)? { Kw::Density } else { Kw::Pigment };
        if self.at_kw(word)? {
            let mut entries = Vec::new();
            while entries.len() < n && self.accept_kw(word)? {
                entries.push((*self.parse_pigment_block()?).clone());
                self.comma()?;
            }
            entries.resize(n, (*self.defaults.pigment).clone());
            self.end_of_object_list(kind)?;
            return Ok(PigmentKind::PigmentMap(Arc::new(list_map(entries))));
        }
        let defaults = default_list_colors(kind);
        let mut colors = Vec::new();
        while colors.len() < n && (self.color_follows()? || self.number_follows()?) {
            colors.push(self.parse_color()?);
            self.comma()?;
        }
        for i in colors.len()..n {
            colors.push(defaults[i]);
        }
        self.end_of_object_list(kind)?;
        Ok(PigmentKind::ColorMap(Arc::new(list_map(colors))))
    }

    /// `{ [f entry] ... }` of any map.
    fn map_entries<T>(
        &mut self,
        what: &str,
        optional_value: bool,
        mut entry: impl FnMut(&mut Self, &mut Vec<(f32, T)>, f32) -> PResult<()>,
    ) -> PResult<Vec<(f32, T)>> {
        let mut entries = Vec::new();
        while self.accept(Punct::LBracket)? {
            let value = if !optional_value || self.number_follows()? { self.parse_float()? as f32 } else { 1.0 };
            self.comma()?;
            self.nested(|p| entry(p, &mut entries, value))?;
            self.expect(Punct::RBracket)?;
            self.comma()?;
            if entries.len() > MAX_ENTRIES {
                return Err(self.error(format!("{what} has more than {MAX_ENTRIES} entries.")));
            }
        }
        if entries.is_empty() {
            return self.expected(&format!("{what} entry"));
        }
        Ok(entries)
    }

    /// `{ ... }` after `color_map`.
    pub(super) fn parse_color_map(&mut self) -> PResult<Arc<BlendMap<Rgbft>>> {
        self.block("color_map", |p| {
            if let Some(Value::ColorMap(m)) = p.peek_value()? {
                let m = m.clone();
                p.next()?;
                return Ok(m);
            }
            let entries = p.map_entries("color_map", false, |p, entries, at| {
                if !p.color_follows()? && p.number_follows()? && !p.at_punct(Punct::Lt)? {
                    // The old form: two positions, two colours.
                    let to = p.parse_float()? as f32;
                    p.comma()?;
                    entries.push((at, p.parse_color()?));
                    p.comma()?;
                    entries.push((to, p.parse_color()?));
                    return Ok(());
                }
                entries.push((at, p.parse_color()?));
                Ok(())
            })?;
            Ok(Arc::new(BlendMap { entries }))
        })
    }

    /// `{ ... }` after `pigment_map` or `density_map`.
    pub(super) fn parse_pigment_map(&mut self, word: Kw) -> PResult<Arc<BlendMap<Pigment>>> {
        self.block(word.text(), |p| {
            if let Some(Value::PigmentMap(m) | Value::DensityMap(m)) = p.peek_value()? {
                let m = m.clone();
                p.next()?;
                return Ok(m);
            }
            let entries = p.map_entries(word.text(), true, |p, entries, at| {
                let mut pigment = p.defaults.pigment.clone();
                p.pigment_contents(&mut pigment)?;
                entries.push((at, Arc::unwrap_or_clone(pigment)));
                Ok(())
            })?;
            Ok(Arc::new(BlendMap { entries }))
        })
    }

    /// `{ ... }` after `slope_map`.
    pub(super) fn parse_slope_map(&mut self) -> PResult<Arc<BlendMap<[f32; 2]>>> {
        self.block("slope_map", |p| {
            if let Some(Value::SlopeMap(m)) = p.peek_value()? {
                let m = m.clone();
                p.next()?;
                return Ok(m);
            }
            let entries = p.map_entries("slope_map", false, |p, entries, at| {
                let v = p.parse_vector2()?;
                entries.push((at, [v.x as f32, v.y as f32]));
                Ok(())
            })?;
            Ok(Arc::new(BlendMap { entries }))
        })
    }

    /// `{ ... }` after `normal_map`.
    pub(super) fn parse_normal_map(&mut self) -> PResult<Arc<BlendMap<Normal>>> {
        self.block("normal_map", |p| {
            if let Some(Value::NormalMap(m)) = p.peek_value()? {
                let m = m.clone();
                p.next()?;
                return Ok(m);
            }
            let entries = p.map_entries("normal_map", true, |p, entries, at| {
                let mut normal = plain_normal();
                p.normal_contents(&mut normal)?;
                entries.push((at, normal));
                Ok(())
            })?;
            Ok(Arc::new(BlendMap { entries }))
        })
    }

    /// `{ ... }` after `texture_map`.
    pub(super) fn parse_texture_map(&mut self) -> PResult<Arc<BlendMap<Arc<Texture>>>> {
        self.block("texture_map", |p| {
            if let Some(Value::TextureMap(m)) = p.peek_value()? {
                let m = m.clone();
                p.next()?;
                return Ok(m);
            }
            let entries = p.map_entries("texture_map", true, |p, entries, at| {
                let mut texture = p.texture_contents()?;
                while p.accept_kw(Kw::Texture)? {
                    let layer = p.parse_texture_block()?;
                    texture = p.layer_texture(Some(texture), layer)?;
                }
                entries.push((at, texture));
                Ok(())
            })?;
            Ok(Arc::new(BlendMap { entries }))
        })
    }

    /// `{ ... }` after `normal`, from the default (or nothing).
    pub(super) fn parse_normal_block(&mut self) -> PResult<Arc<Normal>> {
        let start = self.defaults.normal.clone();
        self.normal_block_from(start)
    }

    /// `{ ... }` after `normal`, going on from `start`.
    pub(super) fn normal_block_from(&mut self, start: Option<Arc<Normal>>) -> PResult<Arc<Normal>> {
        let mut normal = start.map_or_else(plain_normal, Arc::unwrap_or_clone);
        self.block("normal", |p| p.normal_contents(&mut normal))?;
        Ok(Arc::new(normal))
    }

    fn normal_contents(&mut self, normal: &mut Normal) -> PResult<()> {
        if let Some(Value::Normal(n)) = self.peek_value()? {
            *normal = (**n).clone();
            self.next()?;
        }
        if self.accept_kw(Kw::UvMapping)? {
            normal.uv_mapping = true;
        }
        if self.accept_kw(Kw::BumpMap)? {
            let map = self.parse_image_map("bump_map", Kw::BumpMap)?;
            normal.kind = NormalKind::BumpMap(map);
            normal.pattern.kind = PatternKind::Plain;
            normal.pattern.frequency = 0.0;
            if let Some(size) = self.images.take_bump_size() {
                normal.amount = size;
            }
        } else if self.pattern_kind(&mut normal.pattern)? {
            if !matches!(normal.kind, NormalKind::NormalMap(_)) || list_length(&normal.pattern.kind).is_some() {
                normal.kind = NormalKind::Pattern { slope_map: None };
            }
            if let Some(n) = list_length(&normal.pattern.kind) {
                self.normal_list(normal, n)?;
            }
        }
        self.comma()?;
        if self.number_follows()? {
            normal.amount = self.parse_float()? as f32;
        }
        self.normal_modifiers(normal)
    }

    fn normal_list(&mut self, normal: &mut Normal, n: usize) -> PResult<()> {
        self.comma()?;
        if self.at_kw(Kw::Normal)? {
            let mut entries = Vec::new();
            while entries.len() < n && self.accept_kw(Kw::Normal)? {
                let mut child = plain_normal();
                self.block("normal", |p| p.normal_contents(&mut child))?;
                entries.push(child);
                self.comma()?;
            }
            entries.resize_with(n, plain_normal);
            normal.kind = NormalKind::NormalMap(Arc::new(list_map(entries)));
        }
        let kind = normal.pattern.kind.clone();
        self.end_of_object_list(&kind)
    }

    fn normal_modifiers(&mut self, normal: &mut Normal) -> PResult<()> {
        loop {
            self.comma()?;
            if let Some(k) = self.peek_kw()? {
                match k {
                    Kw::BumpSize => {
                        self.next()?;
                        normal.amount = self.parse_float()? as f32;
                        continue;
                    }
                    Kw::Accuracy => {
                        self.next()?;
                        normal.accuracy = self.parse_float()? as f32;
                        continue;
                    }
                    Kw::NoBumpScale => {
                        self.next()?;
                        normal.no_bump_scale = true;
                        continue;
                    }
                    Kw::UvMapping => {
                        self.next()?;
                        normal.uv_mapping = true;
                        continue;
                    }
                    Kw::SlopeMap => {
                        self.next()?;
                        normal.kind = NormalKind::Pattern { slope_map: Some(self.parse_slope_map()?) };
                        continue;
                    }
                    Kw::NormalMap => {
                        self.next()?;
                        let map = self.parse_normal_map()?;
                        normal.kind = if matches!(normal.pattern.kind, PatternKind::Average) {
                            NormalKind::Average(map)
                        } else {
                            NormalKind::NormalMap(map)
                        };
                        continue;
                    }
                    _ => {}
                }
            }
            if !self.pattern_modifier(&mut normal.pattern)? {
                return Ok(());
            }
        }
    }

    /// `{ ... }` after `finish`, going on from `start`.
    pub(super) fn finish_block_from(&mut self, start: Arc<Finish>) -> PResult<(Arc<Finish>, FinishExtras)> {
        self.block("finish", |p| {
            let (mut f, mut extras) = ((*start).clone(), FinishExtras::default());
            if let Some(Value::Finish(known, e)) = p.peek_value()? {
                (f, extras) = ((**known).clone(), **e);
                p.next()?;
            }
            p.finish_items(&mut f, &mut extras)?;
            Ok((Arc::new(f), extras))
        })
    }

    fn finish_items(&mut self, f: &mut Finish, extras: &mut FinishExtras) -> PResult<()> {
        let (mut diffuse_albedo, mut phong_albedo, mut specular_albedo) = (false, false, false);
        while let Some(k) = self.peek_kw()? {
            match k {
                Kw::Ambient => {
                    self.next()?;
                    f.ambient = self.parse_rgb()?;
                }
                Kw::Emission => {
                    self.next()?;
                    f.emission = self.parse_rgb()?;
                }
                Kw::Diffuse => {
                    self.next()?;
                    diffuse_albedo = self.accept_kw(Kw::Albedo)?;
                    f.diffuse = self.parse_float()? as f32;
                    self.comma()?;
                    if self.number_follows()? {
                        f.diffuse_back = self.parse_float()? as f32;
                    }
                    f.diffuse_raw = [f.diffuse, f.diffuse_back];
                }
                Kw::Brilliance => {
                    self.next()?;
                    f.brilliance = self.parse_float()? as f32;
                }
                Kw::Phong => {
                    self.next()?;
                    phong_albedo = self.accept_kw(Kw::Albedo)?;
                    f.phong = self.parse_float()? as f32;
                }
                Kw::PhongSize => {
                    self.next()?;
                    f.phong_size = self.parse_float()? as f32;
                }
                Kw::Specular => {
                    self.next()?;
                    specular_albedo = self.accept_kw(Kw::Albedo)?;
                    f.specular = self.parse_float()? as f32;
                }
                Kw::Roughness => {
                    self.next()?;
                    f.roughness = self.parse_float()? as f32;
                    if f.roughness == 0.0 {
                        self.warn("Parse Warning: Zero roughness used.");
                    }
                }
                Kw::Metallic => {
                    self.next()?;
                    f.metallic = if self.number_follows()? { self.parse_float()? as f32 } else { 1.0 };
                }
                Kw::Reflection => {
                    self.next()?;
                    self.reflection(f)?;
                }
                Kw::ReflectionExponent => {
                    self.next()?;
                    f.reflection.exponent = self.parse_float()? as f32;
                }
                Kw::ConserveEnergy => {
                    self.next()?;
                    f.conserve_energy = self.parse_switch()?;
                }
                Kw::Crand => {
                    self.next()?;
                    f.crand = self.parse_float()? as f32;
                }
                Kw::Irid => {
                    self.next()?;
                    f.irid = self.irid()?;
                }
                Kw::Subsurface => {
                    self.next()?;
                    f.subsurface = self.subsurface()?;
                }
                Kw::Ior => {
                    self.next()?;
                    extras.ior = Some(self.parse_float()?);
                    self.warn("Parse Warning: Index of refraction value should be specified in 'interior' statement.");
                }
                Kw::Caustics => {
                    self.next()?;
                    extras.caustics = Some(self.parse_float()?);
                    self.warn("Parse Warning: Caustics value should be specified in 'interior' statement.");
                }
                Kw::Refraction => {
                    self.next()?;
                    extras.refraction = Some(self.parse_float()?);
                    self.warn("Parse Warning: Refraction value unnecessary to turn on refraction.");
                }
                Kw::FadeDistance | Kw::FadePower => {
                    self.next()?;
                    self.parse_float()?;
                    self.warn("Parse Warning: Fade values should be specified in 'interior' statement.");
                }
                _ => break,
            }
            self.comma()?;
        }
        if diffuse_albedo {
            let scale = (f.brilliance + 1.0) / 2.0;
            f.diffuse *= scale;
            f.diffuse_back *= scale;
        }
        if phong_albedo {
            f.phong *= (f.phong_size + 1.0) / 2.0;
        }
        if specular_albedo {
            let r = 1.0 / f.roughness;
            f.specular *= (r + 2.0) / (4.0 * (2.0 - 2f32.powf(-r / 2.0)));
        }
        Ok(())
    }

    fn reflection(&mut self, f: &mut Finish) -> PResult<()> {
        if !self.accept(Punct::LBrace)? {
            let c = self.parse_rgb()?;
            (f.reflection.min, f.reflection.max) = (c, c);
            f.reflection.fresnel = false;
            return Ok(());
        }
        f.reflection.fresnel = false;
        let first = self.parse_rgb()?;
        self.comma()?;
        let two = self.color_follows()? || self.number_follows()?;
        let second = if two { self.parse_rgb()? } else { first };
        (f.reflection.min, f.reflection.max) = (first, second);
        loop {
            self.comma()?;
            let Some(k) = self.peek_kw()? else { break };
            match k {
                Kw::Fresnel => {
                    self.next()?;
                    f.reflection.fresnel = self.parse_switch()?;
                }
                Kw::Falloff => {
                    self.next()?;
                    f.reflection.falloff = self.parse_float()? as f32;
                }
                Kw::Exponent => {
                    self.next()?;
                    f.reflection.exponent = self.parse_float()? as f32;
                }
                Kw::Metallic => {
                    self.next()?;
                    f.reflection.metallic = if self.number_follows()? { self.parse_float()? as f32 } else { 1.0 };
                }
                _ => break,
            }
        }
        if f.reflection.fresnel && !two {
            f.reflection.min = Vec3::ZERO;
        }
        self.close_block("reflection")
    }

    fn irid(&mut self) -> PResult<[f32; 3]> {
        self.block("irid", |p| {
            let mut irid = [p.parse_float()? as f32, 0.0, 0.0];
            loop {
                p.comma()?;
                if p.accept_kw(Kw::Thickness)? {
                    irid[1] = p.parse_float()? as f32;
                } else if p.accept_kw(Kw::Turbulence)? {
                    irid[2] = p.parse_float()? as f32;
                } else {
                    return Ok(irid);
                }
            }
        })
    }

    fn subsurface(&mut self) -> PResult<Option<Vec3>> {
        self.block("subsurface", |p| {
            let mut translucency = None;
            loop {
                if p.accept_kw(Kw::Translucency)? {
                    translucency = Some(p.parse_rgb()?);
                } else if p.accept_kw(Kw::Anisotropy)? {
                    p.parse_rgb()?;
                } else {
                    return Ok(translucency);
                }
            }
        })
    }

    /// `{ ... }` after `texture`.
    pub(super) fn parse_texture_block(&mut self) -> PResult<Arc<Texture>> {
        self.block("texture", |p| p.texture_contents())
    }

    /// What stands between a texture's braces, or in an entry of a texture map.
    fn texture_contents(&mut self) -> PResult<Arc<Texture>> {
        if !self.accept_kw(Kw::UvMapping)? {
            return self.texture_in_space();
        }
        let inner = self.texture_in_space()?;
        Ok(on_uv(inner))
    }

    /// The same after `uv_mapping`.
    fn texture_in_space(&mut self) -> PResult<Arc<Texture>> {
        let mut texture = match self.peek_value()? {
            Some(Value::Texture(t)) => {
                let t = t.clone();
                self.next()?;
                Some(t)
            }
            _ => None,
        };
        let uv_mapping = self.accept_kw(Kw::UvMapping)?;
        let from_name = texture.is_some();
        if !from_name {
            if self.accept_kw(Kw::MaterialMap)? {
                return self.material_map();
            }
            if self.accept_kw(Kw::Tiles)? {
                return self.tiles();
            }
            let mut pattern = Pattern::default();
            if self.pattern_kind(&mut pattern)? {
                return self.patterned_texture(pattern);
            }
        }
        let mut texture = Arc::unwrap_or_clone(texture.take().unwrap_or_else(|| self.defaults.texture()));
        loop {
            if let Some(t) = self.parse_transform()? {
                texture.transform(&t);
                continue;
            }
            if let Texture::Layers(layers) = &mut texture {
                let layer = layers.last_mut().expect("a plain texture has a layer");
                match self.peek_value()? {
                    Some(Value::Pigment(p)) => {
                        layer.pigment = p.clone();
                        self.next()?;
                        continue;
                    }
                    Some(Value::Normal(n)) => {
                        layer.normal = Some(n.clone());
                        self.next()?;
                        continue;
                    }
                    Some(Value::Finish(f, _)) => {
                        layer.finish = f.clone();
                        self.next()?;
                        continue;
                    }
                    _ => {}
                }
                if self.plain_part(layer)? {
                    continue;
                }
            } else if let Texture::Map { pattern, .. } | Texture::Average { pattern, .. } | Texture::MaterialMap { pattern, .. } =
                &mut texture
                && self.pattern_modifier(pattern)?
            {
                continue;
            }
            break;
        }
        let texture = Arc::new(texture);
        Ok(if uv_mapping { on_uv(texture) } else { texture })
    }

    /// `pigment`, `normal`, `finish` or `no_bump_scale` of a plain texture, if one is next.
    fn plain_part(&mut self, layer: &mut TextureLayer) -> PResult<bool> {
        match self.peek_kw()? {
            Some(Kw::Pigment) => {
                self.next()?;
                layer.pigment = self.pigment_block_from(layer.pigment.clone())?;
            }
            Some(Kw::Normal) => {
                self.next()?;
                layer.normal = Some(self.normal_block_from(layer.normal.clone())?);
            }
            Some(Kw::Finish) => {
                self.next()?;
                layer.finish = self.finish_block_from(layer.finish.clone())?.0;
            }
            Some(Kw::NoBumpScale) => {
                self.next()?;
                if let Some(n) = &mut layer.normal {
                    Arc::make_mut(n).no_bump_scale = true;
                }
            }
            _ => return Ok(false),
        }
        Ok(true)
    }

    fn patterned_texture(&mut self, mut pattern: Pattern) -> PResult<Arc<Texture>> {
        let mut map = None;
        if let Some(n) = list_length(&pattern.kind) {
            self.comma()?;
            let mut entries = Vec::new();
            while entries.len() < n && self.accept_kw(Kw::Texture)? {
                entries.push(self.parse_texture_block()?);
                self.comma()?;
            }
            entries.resize(n, self.defaults.texture());
            let kind = pattern.kind.clone();
            self.end_of_object_list(&kind)?;
            map = Some(list_map(entries));
        }
        loop {
            self.comma()?;
            if self.accept_kw(Kw::TextureMap)? {
                map = Some(Arc::unwrap_or_clone(self.parse_texture_map()?));
            } else if !self.pattern_modifier(&mut pattern)? {
                break;
            }
        }
        let Some(map) = map else { return self.expected("texture_map") };
        Ok(Arc::new(if matches!(pattern.kind, PatternKind::Average) {
            Texture::Average { pattern, map, uv_mapping: false }
        } else {
            Texture::Map { pattern, map, uv_mapping: false }
        }))
    }

    fn material_map(&mut self) -> PResult<Arc<Texture>> {
        let (image, textures) = self.block("material_map", |p| {
            let image = p.image_map_contents(Kw::MaterialMap)?;
            let mut textures = Vec::new();
            while p.accept_kw(Kw::Texture)? {
                textures.push(p.parse_texture_block()?);
                p.comma()?;
            }
            if textures.is_empty() {
                return p.expected("texture");
            }
            Ok((image, textures))
        })?;
        let mut pattern = Pattern { frequency: 0.0, ..Pattern::default() };
        while self.pattern_modifier(&mut pattern)? {}
        Ok(Arc::new(Texture::MaterialMap { pattern, image, textures }))
    }

    fn tiles(&mut self) -> PResult<Arc<Texture>> {
        let (a, b) = self.block("tiles", |p| {
            let mut pair = [p.defaults.texture(), p.defaults.texture()];
            if p.accept_kw(Kw::Texture)? {
                pair[0] = p.parse_texture_block()?;
            }
            p.expect_kw(Kw::Tile2)?;
            if p.accept_kw(Kw::Texture)? {
                pair[1] = p.parse_texture_block()?;
            }
            let [a, b] = pair;
            Ok((a, b))
        })?;
        // The first is the odd cell of a checker.
        let mut pattern = Pattern { kind: PatternKind::Checker, frequency: 0.0, ..Pattern::default() };
        while self.pattern_modifier(&mut pattern)? {}
        Ok(Arc::new(Texture::Map { pattern, map: list_map(vec![b, a]), uv_mapping: false }))
    }

    /// Puts a texture over what an object has already.
    pub(super) fn layer_texture(&mut self, below: Option<Arc<Texture>>, above: Arc<Texture>) -> PResult<Arc<Texture>> {
        let Some(below) = below else { return Ok(above) };
        match (&*below, &*above) {
            (Texture::Layers(a), Texture::Layers(b)) => Ok(Arc::new(Texture::Layers(a.iter().chain(b).cloned().collect()))),
            _ => Err(self.error("Cannot layer over a patterned texture.")),
        }
    }
}

/// A normal that does nothing yet.
fn plain_normal() -> Normal {
    Normal {
        kind: NormalKind::Pattern { slope_map: None },
        pattern: Pattern::default(),
        amount: 0.5,
        accuracy: 0.02,
        no_bump_scale: false,
        uv_mapping: false,
    }
}

/// A texture that its children's points reach as (u, v, 0); later transforms turn normals only.
fn on_uv(inner: Arc<Texture>) -> Arc<Texture> {
    Arc::new(Texture::Map { pattern: Pattern::default(), map: BlendMap { entries: vec![(0.0, inner)] }, uv_mapping: true })
}
