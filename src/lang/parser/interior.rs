//! Interiors, media, fog, rainbows, the sky sphere, materials. Source: spec/language.md, section 6.4.

use super::{PResult, Parser};
use crate::lang::keyword::Kw;
use crate::lang::value::{Material, Value};
use crate::math::{DVec3, EPSILON, Rgbft, Transform, Vec3};
use crate::scene::pattern::Turbulence;
use crate::scene::{BlendMap, Fog, Interior, Media, Rainbow, SkySphere};
use std::sync::Arc;

impl Parser<'_> {
    /// `{ ... }` after `interior`; `before` is what the object has already.
    pub(super) fn parse_interior(&mut self, before: Option<Arc<Interior>>) -> PResult<Interior> {
        self.block("interior", |p| {
            let mut i = before.map_or_else(Interior::default, |i| (*i).clone());
            if let Some(Value::Interior(known)) = p.peek_value()? {
                i = (**known).clone();
                p.next()?;
            }
            while let Some(k) = p.peek_kw()? {
                match k {
                    Kw::Ior => {
                        p.next()?;
                        i.ior = p.parse_float()?;
                    }
                    Kw::Dispersion => {
                        p.next()?;
                        i.dispersion = p.parse_float()?;
                    }
                    Kw::DispersionSamples => {
                        p.next()?;
                        let n = p.parse_int()?;
                        if n < 2 {
                            return Err(p.error("Dispersion samples minimum is 2."));
                        }
                        i.dispersion_samples = p.at_most(n, 1024, "dispersion_samples")?;
                    }
                    Kw::Caustics => {
                        p.next()?;
                        // The keyword gives strength; the exponent is 45 times that (measured).
                        i.caustics = 45.0 * p.parse_float()?;
                    }
                    Kw::FadeColor => {
                        p.next()?;
                        i.fade_color = p.parse_rgb()?;
                    }
                    Kw::FadeDistance => {
                        p.next()?;
                        i.fade_distance = p.parse_float()?;
                    }
                    Kw::FadePower => {
                        p.next()?;
                        i.fade_power = p.parse_float()?;
                    }
                    Kw::Refraction => {
                        p.next()?;
                        i.old_refraction = p.parse_float()?;
                    }
                    Kw::Media => {
                        p.next()?;
                        let m = p.parse_media()?;
                        i.media.extend(m);
                    }
                    _ => break,
                }
            }
            Ok(i)
        })
    }

    /// `{ ... }` after `media`.
    pub(super) fn parse_media(&mut self) -> PResult<Vec<Media>> {
        self.block("media", |p| {
            let mut all = match p.peek_value()? {
                Some(Value::Media(m)) => {
                    let m = (**m).clone();
                    p.next()?;
                    m
                }
                _ => {
                    let mut m = Media::default();
                    if p.version < 350 {
                        (m.method, m.intervals, m.samples) = (1, 10, (1, 1));
                    }
                    vec![m]
                }
            };
            let m = all.last_mut().expect("a media has a part");
            p.media_items(m)?;
            Ok(all)
        })
    }

    fn media_items(&mut self, m: &mut Media) -> PResult<()> {
        /// Samples of one ray in all intervals.
        const MAX_SAMPLES: i64 = 1 << 20;
        loop {
            if let Some(t) = self.parse_transform()? {
                m.transform(&t);
                continue;
            }
            let Some(k) = self.peek_kw()? else { return Ok(()) };
            match k {
                Kw::Intervals => {
                    self.next()?;
                    let n = self.parse_int()?;
                    if n < 1 {
                        return Err(self.error("At least one interval is needed in media."));
                    }
                    m.intervals =
                        self.at_most(n, MAX_SAMPLES / i64::from(m.samples.1.max(1)), "A number of media intervals (with their samples)")?;
                }
                Kw::Samples => {
                    self.next()?;
                    let low = self.parse_int()?;
                    self.comma()?;
                    let high = if self.number_follows()? { self.parse_int()? } else { low };
                    if low < 1 {
                        return Err(self.error("At least one sample per interval is needed in media."));
                    }
                    if high < low {
                        return Err(self.error("Maximum number of samples per interval smaller than minimum number."));
                    }
                    let most = MAX_SAMPLES / i64::from(m.intervals.max(1));
                    m.samples = (low as u32, self.at_most(high, most, "A number of media samples (in their intervals)")?);
                }
                Kw::Method => {
                    self.next()?;
                    let n = self.parse_int()?;
                    if !(1..=3).contains(&n) {
                        return Err(self.error("Illegal value for media method: 1, 2 or 3."));
                    }
                    m.method = n as u8;
                }
                Kw::Jitter => {
                    self.next()?;
                    m.jitter = self.parse_float()?;
                }
                Kw::AaThreshold => {
                    self.next()?;
                    m.aa_threshold = self.parse_float()?;
                }
                Kw::AaLevel => {
                    self.next()?;
                    let n = self.parse_int()?;
                    if n < 1 {
                        return Err(self.error("aa_level in media must be at least one."));
                    }
                    m.aa_level = self.at_most(n, 30, "aa_level")?;
                }
                Kw::Collect => {
                    self.next()?;
                    m.collect = self.parse_switch()?;
                }
                Kw::Absorption => {
                    self.next()?;
                    m.absorption = self.parse_rgb()?;
                }
                Kw::Emission => {
                    self.next()?;
                    m.emission = self.parse_rgb()?;
                }
                Kw::Confidence => {
                    self.next()?;
                    m.confidence = self.parse_float()?;
                    if !(m.confidence > 0.0 && m.confidence < 1.0) {
                        return Err(self.error("Illegal confidence value in media."));
                    }
                }
                Kw::Variance => {
                    self.next()?;
                    m.variance = self.parse_float()?;
                }
                Kw::Ratio => {
                    self.next()?;
                    m.ratio = self.parse_float()?;
                }
                Kw::Scattering => {
                    self.next()?;
                    self.media_scattering(m)?;
                }
                Kw::Density => {
                    self.next()?;
                    let d = self.parse_density_block()?;
                    m.densities.push(d);
                }
                _ => return Ok(()),
            }
        }
    }

    fn media_scattering(&mut self, m: &mut Media) -> PResult<()> {
        self.block("scattering", |p| {
            let kind = p.parse_int()?;
            p.comma()?;
            m.scattering = p.parse_rgb()?;
            if (1..=5).contains(&kind) {
                m.scattering_type = kind as u8;
            } else {
                p.warn("Unknown atmospheric scattering type: it is taken as isotropic.");
                m.scattering_type = 1;
            }
            loop {
                if p.accept_kw(Kw::Eccentricity)? {
                    if kind != 5 {
                        return Err(p.error("Eccentricity cannot be used with this scattering type."));
                    }
                    m.eccentricity = p.parse_float()?;
                } else if p.accept_kw(Kw::Extinction)? {
                    m.extinction = p.parse_float()?;
                } else {
                    return Ok(());
                }
            }
        })
    }

    /// `{ ... }` after `material`.
    pub(super) fn parse_material(&mut self) -> PResult<Material> {
        self.block("material", |p| {
            let mut m = match p.peek_value()? {
                Some(Value::Material(m)) => {
                    let m = (**m).clone();
                    p.next()?;
                    m
                }
                _ => Material::default(),
            };
            loop {
                if let Some(t) = p.parse_transform()? {
                    for tex in [&mut m.texture, &mut m.interior_texture].into_iter().flatten() {
                        Arc::make_mut(tex).transform(&t);
                    }
                    if let Some(i) = &mut m.interior {
                        Arc::make_mut(i).transform(&t);
                    }
                } else if p.accept_kw(Kw::Texture)? {
                    let t = p.parse_texture_block()?;
                    m.texture = Some(p.layer_texture(m.texture.take(), t)?);
                } else if p.accept_kw(Kw::InteriorTexture)? {
                    let t = p.parse_texture_block()?;
                    m.interior_texture = Some(p.layer_texture(m.interior_texture.take(), t)?);
                } else if p.accept_kw(Kw::Interior)? {
                    m.interior = Some(Arc::new(p.parse_interior(m.interior.clone())?));
                } else {
                    break;
                }
            }
            if m.interior_texture.is_some() && m.texture.is_none() {
                return Err(p.error("Interior texture requires an exterior texture."));
            }
            Ok(m)
        })
    }

    /// `{ ... }` after `fog`.
    pub(super) fn parse_fog(&mut self) -> PResult<Fog> {
        self.block("fog", |p| {
            let mut f = Fog { color: Rgbft::BLACK, distance: 0.0, ground: None, up: DVec3::Y, turbulence: None };
            let (mut kind, mut offset, mut alt, mut depth) = (1, 0.0, 0.0, 0.5);
            let mut turbulence: Option<Turbulence> = None;
            if let Some(Value::Fog(known)) = p.peek_value()? {
                f = (**known).clone();
                p.next()?;
                if let Some((o, a)) = f.ground {
                    (kind, offset, alt) = (2, o, a);
                }
                if let Some((t, d)) = f.turbulence {
                    (turbulence, depth) = (Some(t), d);
                }
            }
            loop {
                if p.color_follows()? {
                    f.color = p.parse_color()?;
                    continue;
                }
                if !matches!(p.peek_kw()?, Some(Kw::X | Kw::Y | Kw::Z | Kw::U | Kw::V | Kw::T)) && p.number_follows()? {
                    p.warn("Should use distance keyword.");
                    f.distance = p.parse_float()?;
                    continue;
                }
                let Some(k) = p.peek_kw()? else { break };
                match k {
                    Kw::Distance => {
                        p.next()?;
                        f.distance = p.parse_float()?;
                    }
                    Kw::FogType => {
                        p.next()?;
                        kind = p.parse_int()?;
                    }
                    Kw::FogOffset => {
                        p.next()?;
                        offset = p.parse_float()?;
                    }
                    Kw::FogAlt => {
                        p.next()?;
                        alt = p.parse_float()?;
                    }
                    Kw::TurbDepth => {
                        p.next()?;
                        depth = p.parse_float()?;
                    }
                    Kw::Turbulence | Kw::Octaves | Kw::Omega | Kw::Lambda => {
                        let mut t = turbulence.unwrap_or_default();
                        p.turbulence_item(k, &mut t)?;
                        turbulence = Some(t);
                    }
                    Kw::Up => {
                        p.next()?;
                        f.up = p.parse_vector3()?;
                    }
                    Kw::Translate => {
                        p.parse_transform()?;
                        p.warn("A fog's up vector can't be translated.");
                    }
                    _ => match p.parse_transform()? {
                        Some(t) => f.up = t.vector(f.up),
                        None => break,
                    },
                }
            }
            f.up = f.up.try_normalize().unwrap_or(DVec3::Y);
            f.ground = (kind == 2).then_some((offset, alt));
            f.turbulence = turbulence.filter(|t| t.amount != DVec3::ZERO).map(|t| (t, depth));
            Ok(f)
        })
    }

    /// A word of turbulence that is next, and its value.
    pub(super) fn turbulence_item(&mut self, k: Kw, t: &mut Turbulence) -> PResult<()> {
        self.next()?;
        match k {
            Kw::Turbulence => t.amount = self.parse_vector3()?,
            Kw::Octaves => t.octaves = self.parse_int()?.clamp(1, 10) as u32,
            Kw::Omega => t.omega = self.parse_float()? as f32,
            _ => t.lambda = self.parse_float()? as f32,
        }
        Ok(())
    }

    /// `{ ... }` after `rainbow`.
    pub(super) fn parse_rainbow(&mut self) -> PResult<Rainbow> {
        self.block("rainbow", |p| {
            let mut r = Rainbow {
                direction: DVec3::ZERO,
                up: DVec3::Y,
                angle_rad: 0.0,
                width_rad: 0.0,
                arc_rad: None,
                falloff_rad: 0.0,
                distance: crate::math::MAX_DISTANCE,
                jitter: 0.0,
                color_map: Arc::new(BlendMap { entries: Vec::new() }),
            };
            let mut falloff = None;
            if let Some(Value::Rainbow(known)) = p.peek_value()? {
                r = (**known).clone();
                p.next()?;
            }
            while let Some(k) = p.peek_kw()? {
                match k {
                    Kw::Angle => {
                        p.next()?;
                        r.angle_rad = p.parse_float()?.to_radians();
                    }
                    Kw::Width => {
                        p.next()?;
                        r.width_rad = p.parse_float()?.to_radians();
                    }
                    Kw::ArcAngle => {
                        p.next()?;
                        r.arc_rad = Some(p.parse_float()?.to_radians());
                    }
                    Kw::FalloffAngle => {
                        p.next()?;
                        falloff = Some(p.parse_float()?.to_radians());
                    }
                    Kw::Distance => {
                        p.next()?;
                        r.distance = p.parse_float()?;
                    }
                    Kw::Jitter => {
                        p.next()?;
                        r.jitter = p.parse_float()?;
                    }
                    Kw::Direction => {
                        p.next()?;
                        r.direction = p.parse_vector3()?;
                    }
                    Kw::Up => {
                        p.next()?;
                        r.up = p.parse_vector3()?;
                    }
                    Kw::ColorMap => {
                        p.next()?;
                        r.color_map = p.parse_color_map()?;
                    }
                    _ => break,
                }
            }
            if r.direction.length() < EPSILON || r.up.length() < EPSILON {
                return Err(p.error("Rainbow's direction and up vectors must not be zero."));
            }
            let direction = r.direction.normalize();
            let right = r.up.cross(direction);
            if right.length() < EPSILON {
                return Err(p.error("Rainbow's direction and up vectors are co-linear."));
            }
            r.direction = direction;
            r.up = direction.cross(right.normalize()).normalize();
            if let Some(f) = falloff {
                if r.arc_rad.is_some_and(|a| a < f) {
                    return Err(p.error("Arc angle is smaller than falloff angle in rainbow."));
                }
                r.falloff_rad = f;
            } else if let Some(a) = r.arc_rad {
                r.falloff_rad = a;
            }
            Ok(r)
        })
    }

    /// `{ ... }` after `sky_sphere`.
    pub(super) fn parse_sky_sphere(&mut self) -> PResult<SkySphere> {
        self.block("sky_sphere", |p| {
            let mut s = SkySphere { pigments: Vec::new(), emission: Vec3::ONE, transform: Transform::IDENTITY };
            if let Some(Value::SkySphere(known)) = p.peek_value()? {
                s = (**known).clone();
                p.next()?;
            }
            loop {
                if p.accept_kw(Kw::Pigment)? {
                    let pigment = p.parse_pigment_block()?;
                    s.pigments.push(pigment);
                } else if p.accept_kw(Kw::Emission)? {
                    s.emission = p.parse_rgb()?;
                } else if let Some(t) = p.parse_transform()? {
                    s.transform = s.transform.then(&t);
                } else {
                    break;
                }
            }
            if s.pigments.is_empty() {
                return Err(p.error("Empty sky_sphere statement."));
            }
            Ok(s)
        })
    }
}
