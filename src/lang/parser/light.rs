//! `light_source` and `light_group`. Source: spec/language.md, section 6.3.

use super::{PResult, Parser};
use crate::lang::keyword::Kw;
use crate::lang::token::Punct;
use crate::lang::value::Value;
use crate::math::{DVec3, Transform, Vec3};
use crate::scene::light::{AreaLight, Fade, LightKind};
use crate::scene::{Light, Object, Shape};

/// What the items of a light say besides the light itself.
struct Beam {
    kind: Option<Kw>,
    radius: f64,
    falloff: f64,
    tightness: f64,
    fade_distance: f64,
    fade_power: f64,
    area: AreaLight,
    is_area: bool,
}

impl Default for Beam {
    fn default() -> Self {
        Self {
            kind: None,
            radius: 0.0,
            falloff: 0.0,
            tightness: 0.0,
            fade_distance: 0.0,
            fade_power: 0.0,
            area: AreaLight {
                axis1: DVec3::ZERO,
                axis2: DVec3::ZERO,
                n1: 0,
                n2: 0,
                adaptive: 100,
                jitter: false,
                circular: false,
                orient: false,
                area_illumination: false,
            },
            is_area: false,
        }
    }
}

/// Most elements of an area light, in both directions together.
const MAX_ELEMENTS: i64 = 1 << 20;

impl Parser<'_> {
    /// `{ ... }` after `light_source`.
    pub(super) fn parse_light(&mut self) -> PResult<Light> {
        self.block("light_source", |p| {
            if let Some(Value::Object(o)) = p.peek_value()?
                && let Shape::Light(light) = &o.shape
            {
                let mut light = (**light).clone();
                light.transform(&o.transform);
                p.next()?;
                while let Some(t) = p.parse_transform()? {
                    light.transform(&t);
                }
                return Ok(light);
            }
            let location = p.parse_vector3()?;
            p.comma()?;
            let color = if p.color_follows()? || p.number_follows()? { p.parse_rgb()? } else { Vec3::ZERO };
            let mut light = Light::point(location, color);
            let mut beam = Beam::default();
            p.light_items(&mut light, &mut beam)?;
            light.kind = match beam.kind {
                Some(Kw::Spotlight) => LightKind::Spot {
                    radius_rad: beam.radius.to_radians(),
                    falloff_rad: beam.falloff.to_radians(),
                    tightness: beam.tightness,
                },
                Some(Kw::Cylinder) => LightKind::Cylinder { radius: beam.radius, falloff: beam.falloff, tightness: beam.tightness },
                _ => LightKind::Point,
            };
            light.area = beam.is_area.then_some(beam.area);
            if beam.fade_power > 0.0 && beam.fade_distance != 0.0 {
                light.fade = Fade::Pov { distance: beam.fade_distance, power: beam.fade_power };
            }
            Ok(light)
        })
    }

    fn light_items(&mut self, light: &mut Light, beam: &mut Beam) -> PResult<()> {
        loop {
            if let Some(t) = self.parse_transform()? {
                light.transform(&t);
                if beam.is_area {
                    (beam.area.axis1, beam.area.axis2) = (t.vector(beam.area.axis1), t.vector(beam.area.axis2));
                }
                continue;
            }
            let Some(k) = self.peek_kw()? else { return Ok(()) };
            match k {
                Kw::Shadowless => {
                    // A light is of one kind, and this is one: the last word holds, so a cone before it is gone (measured).
                    self.next()?;
                    light.shadowless = true;
                    beam.kind = None;
                }
                Kw::Parallel => {
                    self.next()?;
                    light.parallel = true;
                }
                Kw::Spotlight => {
                    self.next()?;
                    (beam.kind, beam.radius, beam.falloff, beam.tightness) = (Some(k), 30.0, 45.0, 0.0);
                    light.shadowless = false;
                }
                Kw::Cylinder => {
                    self.next()?;
                    (beam.kind, beam.radius, beam.falloff, beam.tightness) = (Some(k), 0.75, 1.0, 0.0);
                    light.shadowless = false;
                    light.parallel = true;
                }
                Kw::PointAt => {
                    self.next()?;
                    if beam.kind.is_none() && !light.parallel {
                        return Err(self.error("Keyword 'point_at' cannot be used with standard light source."));
                    }
                    light.point_at = self.parse_vector3()?;
                }
                Kw::Radius | Kw::Falloff | Kw::Tightness => {
                    self.next()?;
                    if beam.kind.is_none() {
                        return Err(self.error(format!("Keyword '{}' cannot be used with standard light source.", k.text())));
                    }
                    let x = self.parse_float()?;
                    match k {
                        Kw::Radius => beam.radius = x,
                        Kw::Falloff => beam.falloff = x,
                        _ => beam.tightness = x,
                    }
                }
                Kw::AreaLight => {
                    self.next()?;
                    beam.area = self.area_light(beam.area.clone())?;
                    beam.is_area = true;
                }
                Kw::Adaptive | Kw::Jitter | Kw::Circular | Kw::Orient | Kw::AreaIllumination => {
                    let mut a = beam.area.clone();
                    self.area_item(&mut a, beam.is_area, k)?;
                    beam.area = a;
                }
                Kw::FadeDistance => {
                    self.next()?;
                    beam.fade_distance = self.parse_float()?;
                }
                Kw::FadePower => {
                    self.next()?;
                    beam.fade_power = self.parse_float()?;
                }
                Kw::MediaAttenuation => {
                    self.next()?;
                    light.media_attenuation = self.parse_switch()?;
                }
                Kw::MediaInteraction => {
                    self.next()?;
                    light.media_interaction = self.parse_switch()?;
                }
                Kw::LooksLike => {
                    self.next()?;
                    if light.looks_like.is_some() {
                        return Err(self.error("Only one looks_like allowed per light_source."));
                    }
                    // The block's own modifiers act on the object where the light is.
                    let location = light.location;
                    let mut object = self.block("looks_like", |p| {
                        let mut object = p.need_object()?;
                        object.apply_transform(&Transform::translation(location));
                        p.object_modifiers(&mut object)?;
                        Ok(object)
                    })?;
                    if object.texture.is_none() {
                        object.texture = Some(self.defaults.texture());
                    }
                    object.flags.no_shadow = Some(true);
                    light.looks_like = Some(Box::new(object));
                }
                Kw::ProjectedThrough => {
                    self.next()?;
                    if light.projected_through.is_some() {
                        return Err(self.error("Only one projected through allowed per light_source."));
                    }
                    let object = self.object_and_modifiers("projected_through")?;
                    light.projected_through = Some(Box::new(object));
                }
                Kw::Photons => {
                    self.next()?;
                    self.light_photons(light)?;
                }
                Kw::ColorMap => {
                    self.next()?;
                    // The colours, each times its position, are the light's colour.
                    let map = self.parse_color_map()?;
                    light.color = map.entries.iter().map(|(at, c)| c.rgb * *at).sum();
                }
                _ => return Ok(()),
            }
        }
    }

    fn object_and_modifiers(&mut self, word: &str) -> PResult<Object> {
        self.block(word, |p| {
            let mut object = p.need_object()?;
            p.object_modifiers(&mut object)?;
            Ok(object)
        })
    }

    /// An area light's axes and size; `before` is what its switches say already.
    fn area_light(&mut self, before: AreaLight) -> PResult<AreaLight> {
        let axis1 = self.parse_vector3()?;
        self.comma()?;
        let axis2 = self.parse_vector3()?;
        self.comma()?;
        let n1 = self.parse_int()?;
        self.comma()?;
        let n2 = self.parse_int()?;
        if n1 < 1 || n2 < 1 {
            return Err(self.error("Area light must have at least one element on each axis."));
        }
        let what = "A number of area light elements";
        self.at_most(n1.saturating_mul(n2), MAX_ELEMENTS, what)?;
        Ok(AreaLight { axis1, axis2, n1: n1 as u32, n2: n2 as u32, ..before })
    }

    fn area_item(&mut self, a: &mut AreaLight, is_area: bool, k: Kw) -> PResult<()> {
        self.next()?;
        match k {
            Kw::Adaptive => a.adaptive = self.parse_int()?.clamp(0, 100) as u32,
            Kw::Jitter => a.jitter = true,
            Kw::Circular => a.circular = true,
            Kw::Orient => (a.orient, a.circular) = (true, true),
            _ => a.area_illumination = self.parse_switch()?,
        }
        if !is_area && matches!(k, Kw::Circular | Kw::Orient | Kw::AreaIllumination) {
            self.warn(format!("'{}' should stand after area_light.", k.text()));
        }
        if is_area && k == Kw::Circular && (a.n1 < 2 || a.n2 < 2) {
            return Err(self.error("Circular area lights must have more than one point on each axis."));
        }
        if is_area && k == Kw::Orient && a.n1 != a.n2 {
            self.warn("When using orient, the two sample sizes for an area light should be equal.");
        }
        Ok(())
    }

    fn light_photons(&mut self, light: &mut Light) -> PResult<()> {
        self.block("photons", |p| {
            while let Some(k) = p.peek_kw()? {
                match k {
                    Kw::Reflection => {
                        p.next()?;
                        light.photons.0 = Some(p.parse_switch()?);
                    }
                    Kw::Refraction => {
                        p.next()?;
                        light.photons.1 = Some(p.parse_switch()?);
                    }
                    Kw::AreaLight => {
                        p.next()?;
                        light.photons.2 = true;
                    }
                    _ => break,
                }
            }
            Ok(())
        })
    }

    /// `{ ... }` after `light_group`.
    pub(super) fn parse_light_group(&mut self) -> PResult<Object> {
        self.block("light_group", |p| {
            let (mut children, mut lights, mut global_lights) = (Vec::new(), Vec::new(), None);
            let mut photons = crate::scene::object::PhotonFlags::default();
            loop {
                if p.accept_kw(Kw::LightSource)? {
                    lights.push(p.parse_light()?);
                } else if let Some(o) = p.parse_object()? {
                    match o.shape {
                        Shape::Light(mut l) => {
                            l.transform(&o.transform);
                            lights.push(*l);
                        }
                        _ => children.push(o),
                    }
                } else {
                    break;
                }
            }
            for c in &mut children {
                if c.texture.is_none() {
                    c.texture = Some(p.defaults.texture());
                }
            }
            let mut transforms = Transform::IDENTITY;
            loop {
                if let Some(t) = p.parse_transform()? {
                    transforms = transforms.then(&t);
                } else if p.accept_kw(Kw::GlobalLights)? {
                    global_lights = Some(p.parse_switch()?);
                } else if p.at_kw(Kw::Photons)? {
                    p.next()?;
                    p.object_photons(&mut photons)?;
                } else {
                    break;
                }
                p.accept(Punct::Comma)?;
            }
            let mut o = Object::new(Shape::LightGroup { children, lights, global_lights });
            o.photons = photons;
            o.apply_transform(&transforms);
            Ok(o)
        })
    }
}
