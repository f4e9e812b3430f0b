//! Patterns with their modifiers: turbulence, waves, warps. Source: spec/language.md, section 8; spec/textures.md, sections 1, 2 and 4.

use super::{PResult, Parser};
use crate::lang::keyword::Kw;
use crate::lang::token::{Punct, TokenKind};
use crate::lang::value::Value;
use crate::math::DVec3;
use crate::scene::pattern::{FractalPattern, Turbulence, Wave};
use crate::scene::{Pattern, PatternKind, Warp};
use std::sync::Arc;

/// Patterns whose value chooses from a list: how many entries, and whether the choice is the pattern's only map.
pub(super) fn list_length(kind: &PatternKind) -> Option<usize> {
    Some(match kind {
        PatternKind::Checker | PatternKind::Object(_) | PatternKind::Brick { .. } => 2,
        PatternKind::Hexagon => 3,
        PatternKind::Square => 4,
        PatternKind::Triangular | PatternKind::Cubic => 6,
        _ => return None,
    })
}

/// How many patterns a pavement of so many sides has by the number of tiles joined. Source: spec/textures.md, section 2.
fn pavement_patterns(sides: u8, tiles: u8) -> i64 {
    let by_tiles: &[i64] = match sides {
        3 => &[1, 1, 1, 3, 4, 12],
        4 => &[1, 1, 2, 5, 12, 35],
        _ => &[1, 1, 3, 7, 22],
    };
    by_tiles.get(usize::from(tiles) - 1).copied().unwrap_or(1)
}

impl Parser<'_> {
    /// A pattern's word and its parameters, if one is next. The pattern's `kind`, and where the language says so its wave and
    /// frequency, are replaced; everything else stays.
    pub(super) fn pattern_kind(&mut self, pattern: &mut Pattern) -> PResult<bool> {
        let Some(k) = self.peek_kw()? else { return Ok(false) };
        let simple = match k {
            Kw::Agate => PatternKind::Agate { turb: 1.0 },
            Kw::Aoi => PatternKind::Aoi,
            Kw::Average => PatternKind::Average,
            Kw::Boxed => PatternKind::Boxed,
            Kw::Bozo => PatternKind::Bozo,
            Kw::Brick => match pattern.kind {
                PatternKind::Brick { size, mortar } => PatternKind::Brick { size, mortar },
                _ => PatternKind::Brick { size: DVec3::new(8.0, 3.0, 4.5), mortar: 0.5 },
            },
            Kw::Bumps => PatternKind::Bumps,
            Kw::Cells => PatternKind::Cells,
            Kw::Checker => PatternKind::Checker,
            Kw::Crackle => PatternKind::Crackle { form: DVec3::new(-1.0, 1.0, 0.0), metric: 2.0, offset: 0.0, solid: false },
            Kw::Cubic => PatternKind::Cubic,
            Kw::Cylindrical => PatternKind::Cylindrical,
            Kw::Dents => PatternKind::Dents,
            Kw::Facets => PatternKind::Facets { coords: None, size: 0.1, metric: 2.0 },
            Kw::Granite => PatternKind::Granite,
            Kw::Hexagon => PatternKind::Hexagon,
            Kw::Leopard => PatternKind::Leopard,
            Kw::Marble => PatternKind::Marble,
            Kw::Onion => PatternKind::Onion,
            Kw::Pavement => PatternKind::Pavement { sides: 3, tiles: 1, pattern: 0, interior: 0, exterior: 0, form: 0 },
            Kw::Planar => PatternKind::Planar,
            Kw::Quilted => PatternKind::Quilted { control0: 1.0, control1: 1.0 },
            Kw::Radial => PatternKind::Radial,
            Kw::Ripples => PatternKind::Ripples,
            Kw::Spherical => PatternKind::Spherical,
            Kw::Spotted => PatternKind::Spotted,
            Kw::Square => PatternKind::Square,
            Kw::Triangular => PatternKind::Triangular,
            Kw::Waves => PatternKind::Waves,
            Kw::Wood => PatternKind::Wood,
            Kw::Wrinkles => PatternKind::Wrinkles,
            _ => return self.pattern_with_parameters(k, pattern),
        };
        self.next()?;
        self.set_kind(pattern, simple);
        Ok(true)
    }

    fn set_kind(&mut self, pattern: &mut Pattern, kind: PatternKind) {
        match kind {
            PatternKind::Marble | PatternKind::Wood | PatternKind::Spiral1 { .. } | PatternKind::Spiral2 { .. } => {
                pattern.wave = Wave::Triangle
            }
            PatternKind::Quilted { .. } | PatternKind::Image(_) => pattern.frequency = 0.0,
            ref k if list_length(k).is_some() => pattern.frequency = 0.0,
            _ => {}
        }
        pattern.kind = kind;
    }

    fn pattern_with_parameters(&mut self, k: Kw, pattern: &mut Pattern) -> PResult<bool> {
        let kind = match k {
            Kw::DensityFile => {
                self.next()?;
                self.expect_kw(Kw::Df3)?;
                let name = self.parse_file_name()?;
                let grid = self.density_grid(&name)?;
                PatternKind::DensityFile { grid, interpolate: 0 }
            }
            Kw::Function => {
                self.next()?;
                PatternKind::Function(self.parse_function_block(3)?)
            }
            Kw::Gradient => {
                self.next()?;
                PatternKind::Gradient(self.parse_vector3()?)
            }
            Kw::ImagePattern => {
                self.next()?;
                PatternKind::Image(self.parse_image_map("image_pattern", Kw::ImagePattern)?)
            }
            Kw::Mandel => {
                self.next()?;
                PatternKind::Fractal(self.mandel(0)?)
            }
            Kw::Julia => {
                self.next()?;
                PatternKind::Fractal(self.julia(0)?)
            }
            Kw::Magnet => {
                self.next()?;
                let kind = self.parse_int()?;
                if kind != 1 && kind != 2 {
                    return Err(self.error("Illegal magnet type: 1 or 2."));
                }
                let t = self.next()?;
                match t.kind {
                    TokenKind::Kw(Kw::Mandel) => PatternKind::Fractal(self.mandel(kind as u8)?),
                    TokenKind::Kw(Kw::Julia) => PatternKind::Fractal(self.julia(kind as u8)?),
                    _ => return Err(self.expected_instead("mandel or julia", t)),
                }
            }
            Kw::Object => {
                self.next()?;
                self.open_block("object")?;
                // The list of colours follows in the same braces; the caller reads it and closes them.
                let mut object = self.need_object()?;
                while let Some(t) = self.parse_transform()? {
                    object.apply_transform(&t);
                }
                PatternKind::Object(Arc::new(object))
            }
            Kw::PigmentPattern => {
                self.next()?;
                PatternKind::Pigment(self.parse_pigment_block()?)
            }
            Kw::Slope => {
                self.next()?;
                self.slope()?
            }
            Kw::Spiral1 | Kw::Spiral2 => {
                self.next()?;
                let arms = self.parse_int()?.clamp(-32_768, 32_767) as i32;
                if k == Kw::Spiral1 { PatternKind::Spiral1 { arms } } else { PatternKind::Spiral2 { arms } }
            }
            Kw::Tiling => {
                self.next()?;
                let n = self.parse_int()?;
                if !(1..=27).contains(&n) {
                    return Err(self.error("Illegal tiling number: 1 to 27."));
                }
                PatternKind::Tiling(n as u8)
            }
            _ => return Ok(false),
        };
        self.set_kind(pattern, kind);
        Ok(true)
    }

    fn mandel(&mut self, magnet: u8) -> PResult<FractalPattern> {
        let iterations = self.iterations()?;
        Ok(FractalPattern { magnet, julia: None, iterations, exponent: 2, exterior: (1, 1.0), interior: (0, 1.0) })
    }

    fn iterations(&mut self) -> PResult<u32> {
        let n = self.parse_int()?.max(1);
        self.at_most(n, 1 << 20, "A number of iterations")
    }

    fn julia(&mut self, magnet: u8) -> PResult<FractalPattern> {
        let c = self.parse_vector2()?;
        self.comma()?;
        let iterations = self.iterations()?;
        Ok(FractalPattern { magnet, julia: Some((c.x, c.y)), iterations, exponent: 2, exterior: (1, 1.0), interior: (0, 1.0) })
    }

    fn slope(&mut self) -> PResult<PatternKind> {
        if !self.at_punct(Punct::LBrace)? {
            let direction = self.parse_vector3()?;
            if direction == DVec3::ZERO {
                return Err(self.error("Zero length for both slope and gradient."));
            }
            return Ok(PatternKind::Slope { direction, point_at: false, low: 0.0, high: 0.0, altitude: None });
        }
        self.block("slope", |p| {
            let point_at = p.accept_kw(Kw::PointAt)?;
            let direction = p.parse_vector3()?;
            let (low, high) = p.slope_range()?;
            let altitude = if p.accept_kw(Kw::Altitude)? {
                let a = p.parse_vector3()?;
                let (lo, hi) = p.slope_range()?;
                Some((a, lo, hi))
            } else {
                None
            };
            if direction == DVec3::ZERO && altitude.is_none_or(|(a, _, _)| a == DVec3::ZERO) {
                return Err(p.error("Zero length for both slope and gradient."));
            }
            Ok(PatternKind::Slope { direction, point_at, low, high, altitude })
        })
    }

    fn slope_range(&mut self) -> PResult<(f64, f64)> {
        self.comma()?;
        if !self.number_follows()? {
            return Ok((0.0, 0.0));
        }
        let low = self.parse_float()?;
        self.comma()?;
        Ok((low, if self.number_follows()? { self.parse_float()? } else { 0.0 }))
    }

    /// A modifier of a pattern (not a map), if one is next.
    pub(super) fn pattern_modifier(&mut self, pattern: &mut Pattern) -> PResult<bool> {
        if let Some(t) = self.parse_transform()? {
            pattern.transform(&t);
            return Ok(true);
        }
        let Some(k) = self.peek_kw()? else { return Ok(false) };
        match k {
            Kw::Turbulence | Kw::Octaves | Kw::Omega | Kw::Lambda => {
                let mut t = pattern.turbulence.unwrap_or_default();
                self.turbulence_item(k, &mut t)?;
                pattern.turbulence = Some(t);
            }
            Kw::Frequency => {
                self.next()?;
                pattern.frequency = self.parse_float()? as f32;
            }
            Kw::Phase => {
                self.next()?;
                pattern.phase = self.parse_float()? as f32;
            }
            Kw::RampWave => self.wave(pattern, Wave::Ramp)?,
            Kw::TriangleWave => self.wave(pattern, Wave::Triangle)?,
            Kw::SineWave => self.wave(pattern, Wave::Sine)?,
            Kw::ScallopWave => self.wave(pattern, Wave::Scallop)?,
            Kw::CubicWave => self.wave(pattern, Wave::Cubic)?,
            Kw::PolyWave => {
                self.next()?;
                let e = if self.number_follows()? { self.parse_float()? } else { 1.0 };
                pattern.wave = Wave::Poly(e as f32);
            }
            Kw::NoiseGenerator => {
                self.next()?;
                let n = self.parse_noise_generator()?;
                pattern.noise_generator = (n > 0).then_some(n);
            }
            Kw::Warp => {
                self.next()?;
                let warp = self.block("warp", |p| p.warp())?;
                pattern.warps.push(warp);
            }
            _ => return self.kind_modifier(k, &mut pattern.kind),
        }
        Ok(true)
    }

    fn wave(&mut self, pattern: &mut Pattern, wave: Wave) -> PResult<()> {
        self.next()?;
        pattern.wave = wave;
        Ok(())
    }

    fn wrong_modifier<T>(&mut self, k: Kw, kind: &str) -> PResult<T> {
        self.next()?;
        Err(self.error(format!("Keyword '{}' can only be used in a {kind} statement.", k.text())))
    }

    /// A word that belongs to one kind of pattern.
    fn kind_modifier(&mut self, k: Kw, kind: &mut PatternKind) -> PResult<bool> {
        match (k, kind) {
            (Kw::AgateTurb, PatternKind::Agate { turb }) => {
                self.next()?;
                *turb = self.parse_float()? as f32;
            }
            (Kw::AgateTurb, _) => return self.wrong_modifier(k, "agate"),
            (Kw::BrickSize, PatternKind::Brick { size, .. }) => {
                self.next()?;
                *size = self.parse_vector3()?;
            }
            (Kw::Mortar, PatternKind::Brick { mortar, .. }) => {
                self.next()?;
                *mortar = self.parse_float()? as f32;
            }
            (Kw::BrickSize | Kw::Mortar, _) => return self.wrong_modifier(k, "brick"),
            (Kw::Control0, PatternKind::Quilted { control0, .. }) => {
                self.next()?;
                *control0 = self.parse_float()? as f32;
            }
            (Kw::Control1, PatternKind::Quilted { control1, .. }) => {
                self.next()?;
                *control1 = self.parse_float()? as f32;
            }
            (Kw::Control0 | Kw::Control1, _) => return self.wrong_modifier(k, "quilted"),
            (Kw::Solid, PatternKind::Crackle { solid, .. }) => {
                self.next()?;
                *solid = true;
            }
            (Kw::Form, PatternKind::Crackle { form, .. }) => {
                self.next()?;
                *form = self.parse_vector3()?;
            }
            (Kw::Form, PatternKind::Pavement { form, .. }) => {
                self.next()?;
                *form = self.parse_int()?.clamp(0, 3) as u8;
            }
            (Kw::Metric, PatternKind::Crackle { metric, .. } | PatternKind::Facets { metric, .. }) => {
                self.next()?;
                *metric = self.parse_sum()?.v[0];
            }
            (Kw::Offset, PatternKind::Crackle { offset, .. }) => {
                self.next()?;
                *offset = self.parse_float()?;
            }
            (Kw::Coords, PatternKind::Facets { coords, .. }) => {
                self.next()?;
                *coords = Some(self.parse_float()?);
            }
            (Kw::Size, PatternKind::Facets { size, .. }) => {
                self.next()?;
                *size = self.parse_float()?;
            }
            (Kw::Interpolate, PatternKind::DensityFile { interpolate, .. }) => {
                self.next()?;
                *interpolate = match self.parse_int()? % 10 {
                    0 => 0,
                    1 => 1,
                    _ => 2,
                };
            }
            (Kw::Exponent, PatternKind::Fractal(f)) => {
                if f.magnet != 0 {
                    return self.wrong_modifier(k, "mandel or julia");
                }
                self.next()?;
                let e = self.parse_int()?;
                if !(2..=33).contains(&e) {
                    self.warn("Invalid fractal pattern exponent; 2 is used.");
                }
                f.exponent = if (2..=33).contains(&e) { e as u32 } else { 2 };
            }
            (Kw::Exterior, PatternKind::Fractal(f)) => {
                self.next()?;
                f.exterior = self.coloring(8, "exterior")?;
            }
            (Kw::Interior, PatternKind::Fractal(f)) => {
                self.next()?;
                f.interior = self.coloring(6, "interior")?;
            }
            (Kw::Exterior, PatternKind::Pavement { exterior, .. }) => {
                self.next()?;
                *exterior = self.parse_int()?.clamp(0, 2) as u8;
            }
            (Kw::Interior, PatternKind::Pavement { interior, .. }) => {
                self.next()?;
                *interior = self.parse_int()?.clamp(0, 2) as u8;
            }
            (Kw::NumberOfSides, PatternKind::Pavement { sides, .. }) => {
                self.next()?;
                let n = self.parse_int()?;
                if ![3, 4, 6].contains(&n) {
                    return Err(self.error("number_of_sides of pavement must be 3, 4 or 6."));
                }
                *sides = n as u8;
            }
            (Kw::NumberOfTiles, PatternKind::Pavement { sides, tiles, .. }) => {
                self.next()?;
                let n = self.parse_int()?;
                let most = if *sides == 6 { 5 } else { 6 };
                if !(1..=most).contains(&n) {
                    return Err(self.error(format!("number_of_tiles of pavement must be between 1 and {most}.")));
                }
                *tiles = n as u8;
            }
            (Kw::Pattern, PatternKind::Pavement { sides, tiles, pattern, .. }) => {
                self.next()?;
                let n = self.parse_int()?;
                if !(1..=pavement_patterns(*sides, *tiles)).contains(&n) {
                    return Err(self.error("pattern value for pavement is out of range."));
                }
                *pattern = n as u8;
            }
            _ => return Ok(false),
        }
        Ok(true)
    }

    fn coloring(&mut self, most: i64, what: &str) -> PResult<(u8, f64)> {
        let kind = self.parse_int()?;
        if !(0..=most).contains(&kind) {
            return Err(self.error(format!("Invalid fractal pattern {what} type.")));
        }
        self.comma()?;
        Ok((kind as u8, self.parse_float()?))
    }

    fn warp(&mut self) -> PResult<Warp> {
        let t = self.next()?;
        let TokenKind::Kw(k) = t.kind else { return Err(self.expected_instead("warp type", t)) };
        Ok(match k {
            Kw::Repeat => {
                let v = self.parse_vector3()?;
                let axes: Vec<usize> = (0..3).filter(|&i| v[i] != 0.0).collect();
                let [axis] = axes[..] else { return Err(self.error("Can only repeat along 1 axis.")) };
                let (mut offset, mut flip) = (DVec3::ZERO, [false; 3]);
                loop {
                    if self.accept_kw(Kw::Offset)? {
                        offset = self.parse_vector3()?;
                    } else if self.accept_kw(Kw::Flip)? {
                        flip = self.parse_vector3()?.to_array().map(|x| x != 0.0);
                    } else {
                        break;
                    }
                }
                Warp::Repeat { axis: axis as u8, width: v[axis], offset, flip }
            }
            Kw::BlackHole => {
                let mut center = self.parse_vector3()?;
                self.comma()?;
                let radius = self.parse_float()?;
                let (mut strength, mut falloff, mut inverse) = (1.0, 2.0, false);
                let (mut repeat, mut turbulence): (Option<DVec3>, _) = (None, DVec3::ZERO);
                while let Some(k) = self.peek_kw()? {
                    match k {
                        Kw::Strength => {
                            self.next()?;
                            strength = self.parse_float()?;
                        }
                        Kw::Falloff => {
                            self.next()?;
                            falloff = self.parse_float()?;
                        }
                        Kw::Inverse => {
                            self.next()?;
                            inverse = true;
                        }
                        Kw::Type => {
                            self.next()?;
                            self.parse_float()?;
                        }
                        Kw::Repeat => {
                            self.next()?;
                            repeat = Some(self.parse_vector3()?);
                        }
                        Kw::Turbulence => {
                            self.next()?;
                            turbulence = self.parse_vector3()?;
                        }
                        _ => break,
                    }
                    // Raised after either, so that neighbouring holes stay apart (measured: `repeat`, then `turbulence` raises twice).
                    if let (Some(v), Kw::Repeat | Kw::Turbulence) = (&mut repeat, k) {
                        for i in 0..3 {
                            if v[i] > 0.0 {
                                center[i] = f64::max(center[i], radius);
                                v[i] = f64::max(v[i], center[i] + radius + turbulence[i]);
                            }
                        }
                    }
                }
                Warp::BlackHole { center, radius, strength, falloff, inverse, repeat, turbulence }
            }
            Kw::Turbulence => {
                let mut t = Turbulence { amount: self.parse_vector3()?, ..Turbulence::default() };
                while let Some(k @ (Kw::Octaves | Kw::Omega | Kw::Lambda)) = self.peek_kw()? {
                    self.turbulence_item(k, &mut t)?;
                }
                Warp::Turbulence(t)
            }
            Kw::Cylindrical | Kw::Spherical | Kw::Toroidal => {
                let (mut orientation, mut dist_exp, mut major_radius) = (DVec3::Z, 0.0, 1.0);
                loop {
                    if self.accept_kw(Kw::Orientation)? {
                        orientation = self.parse_vector3()?.try_normalize().unwrap_or(DVec3::Z);
                    } else if self.accept_kw(Kw::DistExp)? {
                        dist_exp = self.parse_float()?;
                    } else if k == Kw::Toroidal && self.accept_kw(Kw::MajorRadius)? {
                        major_radius = self.parse_float()?;
                    } else {
                        break;
                    }
                }
                match k {
                    Kw::Cylindrical => Warp::Cylindrical { orientation, dist_exp },
                    Kw::Spherical => Warp::Spherical { orientation, dist_exp },
                    _ => Warp::Toroidal { orientation, dist_exp, major_radius },
                }
            }
            Kw::Planar => {
                let (mut orientation, mut distance) = (DVec3::Z, 0.0);
                if self.number_follows()? {
                    orientation = self.parse_vector3()?.try_normalize().unwrap_or(DVec3::Z);
                    self.comma()?;
                    distance = self.parse_float()?;
                }
                Warp::Planar { orientation, distance }
            }
            Kw::Cubic => Warp::Cubic,
            _ => return Err(self.expected_instead("warp type", t)),
        })
    }

    /// `{ ... }` after `pattern` in a function: a pattern and its modifiers.
    pub(super) fn parse_pattern_block(&mut self) -> PResult<Pattern> {
        self.block("pattern", |p| {
            let mut pattern = Pattern::default();
            if let Some(Value::Pigment(known)) = p.peek_value()? {
                pattern = known.pattern.clone();
                p.next()?;
            }
            if !p.pattern_kind(&mut pattern)? && matches!(pattern.kind, PatternKind::Plain) {
                return p.expected("pattern");
            }
            if matches!(pattern.kind, PatternKind::Object(_)) {
                p.close_block("object")?;
            }
            while p.pattern_modifier(&mut pattern)? {}
            Ok(pattern)
        })
    }
}
