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
/// Most layers of a texture.
const MAX_LAYERS: usize = 256;

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
        self.pigment_or_density(start, Kw::Pigment)
    }

    /// `{ ... }` after `density`.
    pub(super) fn parse_density_block(&mut self) -> PResult<Arc<Pigment>> {
        let start = self.defaults.pigment.clone();
        self.pigment_or_density(start, Kw::Density)
    }

    fn pigment_or_density(&mut self, start: Arc<Pigment>, word: Kw) -> PResult<Arc<Pigment>> {
        let mut pigment = start;
        self.block(word.text(), |p| {
            p.pigment_contents(&mut pigment, word)?;
            Ok(())
        })?;
        Ok(pigment)
    }

    /// What stands between a pigment's braces, or in an entry of a pigment map.
    pub(super) fn pigment_contents(&mut self, pigment: &mut Arc<Pigment>, word: Kw) -> PResult<()> {
        let (mut known, mut untyped) = (false, false);
        if let Some(Value::Pigment(p) | Value::Density(p)) = self.peek_value()? {
            *pigment = p.clone();
            self.next()?;
            known = true;
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
                pigment.kind = self.pigment_list(&pigment.pattern.kind, word)?;
            } else if matches!(pigment.pattern.kind, PatternKind::Facets { .. }) {
                return Err(self.error("Keyword 'facets' can only be used in a normal statement."));
            }
        } else if self.color_follows()? {
            let c = self.parse_color()?;
            pigment.kind = PigmentKind::Solid(c);
            pigment.pattern = Pattern::default();
        } else if !known {
            self.warn("Pigment type unspecified or not 1st item.");
            untyped = true;
        }
        self.pigment_modifiers(pigment, word, untyped)?;
        if matches!(pigment.pattern.kind, PatternKind::Average) && !matches!(pigment.kind, PigmentKind::Average(_)) {
            return Err(self.error("Average must have map."));
        }
        Ok(())
    }

    fn pigment_modifiers(&mut self, pigment: &mut Pigment, word: Kw, untyped: bool) -> PResult<()> {
        loop {
            match self.peek_kw()? {
                Some(k @ (Kw::ColorMap | Kw::PigmentMap | Kw::DensityMap)) => {
                    self.next()?;
                    self.check_map(&pigment.pattern.kind, matches!(pigment.kind, PigmentKind::ImageMap(_)), k, untyped)?;
                    if k == Kw::ColorMap {
                        let map = self.parse_color_map()?;
                        if !untyped {
                            pigment.kind = PigmentKind::ColorMap(map);
                        }
                        continue;
                    }
                    if k == Kw::PigmentMap && word == Kw::Density || k == Kw::DensityMap && word == Kw::Pigment {
                        let other = if k == Kw::PigmentMap { "pigment" } else { "density" };
                        return Err(self.error(format!("Keyword '{}' can only be used in a {other} statement.", k.text())));
                    }
                    let average = matches!(pigment.pattern.kind, PatternKind::Average);
                    let map = self.parse_pigment_map(k, average)?;
                    if !untyped {
                        pigment.kind = if average { PigmentKind::Average(map) } else { PigmentKind::PigmentMap(map) };
                    }
                }
                Some(Kw::QuickColor) => {
                    self.next()?;
                    pigment.quick_color = Some(self.parse_color()?);
                }
                _ if self.pattern_modifier(&mut pigment.pattern)? => {}
                _ => break,
            }
        }
        if matches!(pigment.kind, PigmentKind::Solid(_)) {
            // A plain colour has no pattern to bend.
            pigment.pattern = Pattern::default();
        }
        Ok(())
    }

    /// Refuses maps for patterns that have none.
    fn check_map(&mut self, kind: &PatternKind, is_image: bool, map: Kw, untyped: bool) -> PResult<()> {
        let plain = matches!(kind, PatternKind::Plain) && !untyped;
        let average = matches!(kind, PatternKind::Average) && map == Kw::ColorMap;
        if plain || average || is_image || list_length(kind).is_some() {
            return Err(self.error(format!("Cannot use {} with this pattern type.", map.text())));
        }
        Ok(())
    }

    fn end_of_object_list(&mut self, kind: &PatternKind) -> PResult<()> {
        if matches!(kind, PatternKind::Object(_)) { self.close_block("object") } else { Ok(()) }
    }

    fn pigment_list(&mut self, kind: &PatternKind, word: Kw) -> PResult<PigmentKind> {
        let n = list_length(kind).expect("a list pattern");
        self.comma()?;
        if self.at_kw(word)? {
            let mut entries = Vec::new();
            while entries.len() < n && self.accept_kw(word)? {
                let start = self.defaults.pigment.clone();
                entries.push(Arc::unwrap_or_clone(self.pigment_or_density(start, word)?));
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
            let given = !optional_value || self.number_follows()? || self.color_follows()?;
            let value = if given { self.parse_float()? as f32 } else { 1.0 };
            self.comma()?;
            self.nested(|p| entry(p, &mut entries, value))?;
            self.expect(Punct::RBracket)?;
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
                if p.color_follows()? {
                    entries.push((at, p.parse_color()?));
                    return Ok(());
                }
                if !p.number_follows()? || p.at_punct(Punct::Lt)? {
                    return p.expected("color");
                }
                // The old form: two positions, two colours.
                let to = p.parse_float()? as f32;
                p.comma()?;
                for at in [at, to] {
                    if !p.at_kw(Kw::Color)? {
                        return p.expected("color");
                    }
                    entries.push((at, p.parse_color()?));
                }
                Ok(())
            })?;
            Ok(Arc::new(BlendMap { entries }))
        })
    }

    /// `{ ... }` after `pigment_map` or `density_map`.
    pub(super) fn parse_pigment_map(&mut self, word: Kw, average: bool) -> PResult<Arc<BlendMap<Pigment>>> {
        self.block(word.text(), |p| {
            if let Some(Value::PigmentMap(m) | Value::DensityMap(m)) = p.peek_value()? {
                let m = m.clone();
                p.next()?;
                return Ok(m);
            }
            let entries = p.map_entries(word.text(), average, |p, entries, at| {
                let mut pigment = p.defaults.pigment.clone();
                let word = if word == Kw::DensityMap { Kw::Density } else { Kw::Pigment };
                p.pigment_contents(&mut pigment, word)?;
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
    pub(super) fn parse_normal_map(&mut self, average: bool) -> PResult<Arc<BlendMap<Normal>>> {
        self.block("normal_map", |p| {
            if let Some(Value::NormalMap(m)) = p.peek_value()? {
                let m = m.clone();
                p.next()?;
                return Ok(m);
            }
            let entries = p.map_entries("normal_map", average, |p, entries, at| {
                let mut normal = p.default_normal();
                p.normal_contents(&mut normal)?;
                entries.push((at, normal));
                Ok(())
            })?;
            Ok(Arc::new(BlendMap { entries }))
        })
    }

    /// `{ ... }` after `texture_map`.
    pub(super) fn parse_texture_map(&mut self, average: bool) -> PResult<Arc<BlendMap<Arc<Texture>>>> {
        self.block("texture_map", |p| {
            if let Some(Value::TextureMap(m)) = p.peek_value()? {
                let m = m.clone();
                p.next()?;
                return Ok(m);
            }
            let entries = p.map_entries("texture_map", average, |p, entries, at| {
                entries.push((at, p.texture_contents()?));
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
        if matches!(normal.pattern.kind, PatternKind::Plain) && matches!(normal.kind, NormalKind::Pattern { .. }) {
            return Err(self.error("No normal type given."));
        }
        Ok(Arc::new(normal))
    }

    /// What entries of maps and lists start from.
    fn default_normal(&self) -> Normal {
        self.defaults.normal.as_deref().cloned().unwrap_or_else(plain_normal)
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
            let keeps_map = matches!(normal.kind, NormalKind::NormalMap(_) | NormalKind::Pattern { .. });
            let average = matches!(normal.pattern.kind, PatternKind::Average);
            if !keeps_map || average || list_length(&normal.pattern.kind).is_some() {
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
                let mut child = self.default_normal();
                self.block("normal", |p| p.normal_contents(&mut child))?;
                entries.push(child);
                self.comma()?;
            }
            entries.resize(n, self.default_normal());
            normal.kind = NormalKind::NormalMap(Arc::new(list_map(entries)));
        }
        let kind = normal.pattern.kind.clone();
        self.end_of_object_list(&kind)
    }

    fn normal_modifiers(&mut self, normal: &mut Normal) -> PResult<()> {
        while let Some(k) = self.peek_kw()? {
            match k {
                Kw::BumpSize => {
                    self.next()?;
                    normal.amount = self.parse_float()? as f32;
                }
                Kw::Accuracy => {
                    self.next()?;
                    normal.accuracy = self.parse_float()? as f32;
                }
                Kw::NoBumpScale => {
                    self.next()?;
                    normal.no_bump_scale = true;
                }
                Kw::SlopeMap => {
                    self.next()?;
                    let p = &normal.pattern.kind;
                    let own = matches!(p, PatternKind::Plain | PatternKind::Average);
                    if own || matches!(normal.kind, NormalKind::BumpMap(_)) || list_length(p).is_some() {
                        return Err(self.error("Keyword 'slope_map' cannot be used with this normal type."));
                    }
                    normal.kind = NormalKind::Pattern { slope_map: Some(self.parse_slope_map()?) };
                }
                Kw::NormalMap => {
                    self.next()?;
                    let is_image = matches!(normal.kind, NormalKind::BumpMap(_));
                    self.check_map(&normal.pattern.kind, is_image, k, false)?;
                    let average = matches!(normal.pattern.kind, PatternKind::Average);
                    let map = self.parse_normal_map(average)?;
                    normal.kind = if average { NormalKind::Average(map) } else { NormalKind::NormalMap(map) };
                }
                _ if self.pattern_modifier(&mut normal.pattern)? => {}
                _ => break,
            }
        }
        if matches!(normal.pattern.kind, PatternKind::Average) && !matches!(normal.kind, NormalKind::Average(_)) {
            return Err(self.error("Average must have map."));
        }
        Ok(())
    }

    /// `{ ... }` after `finish`, going on from `start`.
    pub(super) fn finish_block_from(&mut self, start: Arc<Finish>) -> PResult<(Arc<Finish>, FinishExtras)> {
        self.block("finish", |p| {
            let known = p.finish_extras.get(&(Arc::as_ptr(&start) as usize)).map(|e| e.1);
            let (mut f, mut extras) = ((*start).clone(), known.unwrap_or_default());
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
                        self.warn("Zero roughness used.");
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
                    f.conserve_energy = true;
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
                    self.warn("Index of refraction value should be specified in 'interior' statement.");
                }
                Kw::Caustics => {
                    self.next()?;
                    extras.caustics = Some(self.parse_float()?);
                    self.warn("Caustics value should be specified in 'interior' statement.");
                }
                Kw::Refraction => {
                    self.next()?;
                    extras.refraction = Some(self.parse_float()?);
                    self.warn("Refraction value unnecessary to turn on refraction.");
                }
                _ => break,
            }
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
        f.reflection.fresnel = false;
        if !self.accept(Punct::LBrace)? {
            let c = self.parse_rgb()?;
            (f.reflection.min, f.reflection.max) = (c, c);
            return Ok(());
        }
        let mut colors = [Vec3::ZERO; 2];
        let mut n = 0;
        while n < 2 && (self.color_follows()? || self.number_follows()?) {
            colors[n] = self.parse_rgb()?;
            self.comma()?;
            n += 1;
        }
        if n == 1 {
            colors[1] = colors[0];
        }
        (f.reflection.min, f.reflection.max) = (colors[0], colors[1]);
        while let Some(k) = self.peek_kw()? {
            match k {
                Kw::Fresnel => {
                    self.next()?;
                    let x = if self.number_follows()? { self.parse_float()? } else { 1.0 };
                    if x != 0.0 && x != 1.0 {
                        return Err(self.error("fresnel must be true or false"));
                    }
                    f.reflection.fresnel = x != 0.0;
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
        if f.reflection.fresnel && n < 2 {
            f.reflection.min = Vec3::ZERO;
        }
        self.close_block("reflection")
    }

    fn irid(&mut self) -> PResult<[f32; 3]> {
        self.block("irid", |p| {
            let mut irid = [p.parse_float()? as f32, 0.0, 0.0];
            loop {
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
        self.bare_parts(&mut texture)?;
        loop {
            if let Some(t) = self.parse_transform()? {
                texture.transform(&t);
                continue;
            }
            if let Texture::Layers(layers) = &mut texture {
                let layer = layers.last_mut().expect("a plain texture has a layer");
                if self.plain_part(layer)? {
                    continue;
                }
            }
            break;
        }
        let texture = Arc::new(texture);
        Ok(if uv_mapping { on_uv(texture) } else { texture })
    }

    /// Names of pigments, normals and finishes right behind a texture's brace or its name.
    fn bare_parts(&mut self, texture: &mut Texture) -> PResult<()> {
        let Texture::Layers(layers) = texture else { return Ok(()) };
        let layer = layers.last_mut().expect("a plain texture has a layer");
        loop {
            match self.peek_value()? {
                Some(Value::Pigment(p)) => layer.pigment = p.clone(),
                Some(Value::Normal(n)) => layer.normal = Some(n.clone()),
                Some(Value::Finish(f, extras)) => {
                    layer.finish = f.clone();
                    let (f, extras) = (f.clone(), **extras);
                    self.keep_extras(&f, extras);
                }
                _ => return Ok(()),
            }
            self.next()?;
        }
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
                let extras;
                (layer.finish, extras) = self.finish_block_from(layer.finish.clone())?;
                self.keep_extras(&layer.finish, extras);
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
            if self.accept_kw(Kw::TextureMap)? {
                self.check_map(&pattern.kind, false, Kw::TextureMap, false)?;
                let average = matches!(pattern.kind, PatternKind::Average);
                map = Some(Arc::unwrap_or_clone(self.parse_texture_map(average)?));
            } else if !self.pattern_modifier(&mut pattern)? {
                break;
            }
        }
        let Some(map) = map else { return Err(self.error("Patterned texture must have texture_map.")) };
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
            let a = p.texture_layers()?;
            p.expect_kw(Kw::Tile2)?;
            let b = p.texture_layers()?;
            Ok((a, b))
        })?;
        // The first is the odd cell of a checker.
        let mut pattern = Pattern { kind: PatternKind::Checker, frequency: 0.0, ..Pattern::default() };
        while self.pattern_modifier(&mut pattern)? {}
        Ok(Arc::new(Texture::Map { pattern, map: list_map(vec![b, a]), uv_mapping: false }))
    }

    /// `texture{}` blocks, each over the one before; the default when there is none.
    fn texture_layers(&mut self) -> PResult<Arc<Texture>> {
        let mut all = None;
        while self.accept_kw(Kw::Texture)? {
            let layer = self.parse_texture_block()?;
            all = Some(self.layer_texture(all, layer)?);
        }
        Ok(all.unwrap_or_else(|| self.defaults.texture()))
    }

    /// Remembers what a finish inside a texture says of the interior, until an object takes the texture.
    pub(super) fn keep_extras(&mut self, finish: &Arc<Finish>, extras: FinishExtras) {
        if extras != FinishExtras::default() {
            self.finish_extras.insert(Arc::as_ptr(finish) as usize, (finish.clone(), extras));
        }
    }

    /// What the finishes of a texture say of the interior.
    pub(super) fn texture_extras(&self, texture: &Texture) -> FinishExtras {
        let mut all = FinishExtras::default();
        let Texture::Layers(layers) = texture else { return all };
        for l in layers {
            if let Some((_, e)) = self.finish_extras.get(&(Arc::as_ptr(&l.finish) as usize)) {
                all = FinishExtras {
                    ior: e.ior.or(all.ior),
                    caustics: e.caustics.or(all.caustics),
                    refraction: e.refraction.or(all.refraction),
                };
            }
        }
        all
    }

    /// Puts a texture over what an object has already.
    pub(super) fn layer_texture(&mut self, below: Option<Arc<Texture>>, above: Arc<Texture>) -> PResult<Arc<Texture>> {
        let Some(below) = below else { return Ok(above) };
        match (&*below, &*above) {
            (Texture::Layers(a), Texture::Layers(b)) if a.len() + b.len() > MAX_LAYERS => {
                Err(self.error(format!("Too many layers of a texture (more than {MAX_LAYERS}).")))
            }
            (Texture::Layers(a), Texture::Layers(b)) => {
                let mut layers = a.clone();
                layers.extend(b.iter().cloned().map(|mut layer| {
                    if self.version < 320 {
                        filter_as_transmit(Arc::make_mut(&mut layer.pigment));
                    }
                    layer
                }));
                Ok(Arc::new(Texture::Layers(layers)))
            }
            _ => Err(self.error("Cannot layer over a patterned texture.")),
        }
    }
}

/// Language 3.1 and older: what upper layers would filter they let through unfiltered (measured).
fn filter_as_transmit(p: &mut Pigment) {
    let change = |c: &mut Rgbft| (c.filter, c.transmit) = (0.0, c.filter + c.transmit);
    match &mut p.kind {
        PigmentKind::Solid(c) => change(c),
        PigmentKind::ColorMap(map) => Arc::make_mut(map).entries.iter_mut().for_each(|(_, c)| change(c)),
        PigmentKind::PigmentMap(map) | PigmentKind::Average(map) => {
            Arc::make_mut(map).entries.iter_mut().for_each(|(_, p)| filter_as_transmit(p));
        }
        PigmentKind::DefaultMap | PigmentKind::ImageMap(_) => {}
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
