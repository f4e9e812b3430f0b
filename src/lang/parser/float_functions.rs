//! Functions and constants of numeric expressions. Source: spec/language.md, sections 3.2 and 3.3.

use super::{PResult, Parser};
use crate::lang::keyword::Kw;
use crate::lang::token::{Punct, TokenKind};
use crate::lang::value::{Num, Value};
use crate::math::{DVec3, Ray, noise};
use crate::scene::{Function, PigmentKind, Spline, spline::SplineKind};
use std::sync::Arc;

/// To a 32-bit integer as C does; out of range gives the smallest.
fn to_int(x: f64) -> i32 {
    let t = x.trunc();
    if (-2_147_483_648.0..=2_147_483_647.0).contains(&t) { t as i32 } else { i32::MIN }
}

impl Parser<'_> {
    /// Reads `( f )` where everything is open.
    fn in_parens<T>(&mut self, f: impl FnOnce(&mut Self) -> PResult<T>) -> PResult<T> {
        self.opened(|p| p.expect(Punct::LParen))?;
        let value = self.opened(|p| p.nested(f))?;
        self.close_paren()?;
        Ok(value)
    }

    /// `( Cond )` of a one-argument function.
    fn one(&mut self) -> PResult<f64> {
        self.in_parens(|p| {
            let a = p.parse_cond()?;
            p.as_float(a)
        })
    }

    fn two(&mut self) -> PResult<(f64, f64)> {
        self.in_parens(|p| {
            let a = p.parse_float()?;
            p.comma()?;
            Ok((a, p.parse_float()?))
        })
    }

    fn vectors<const N: usize>(&mut self) -> PResult<[DVec3; N]> {
        self.in_parens(|p| {
            let mut v = [DVec3::ZERO; N];
            for (i, v) in v.iter_mut().enumerate() {
                if i > 0 {
                    p.comma()?;
                }
                *v = p.parse_vector3()?;
            }
            Ok(v)
        })
    }

    /// First value, then the rest, each after a required comma.
    fn fold(&mut self, f: impl Fn(f64, f64) -> f64) -> PResult<f64> {
        self.in_parens(|p| {
            let mut a = p.parse_float()?;
            while !p.at_punct(Punct::RParen)? {
                p.expect(Punct::Comma)?;
                a = f(a, p.parse_float()?);
            }
            Ok(a)
        })
    }

    /// The value of a word whose class is float or vector; the word was taken.
    pub(super) fn parse_word(&mut self, k: Kw) -> PResult<Num> {
        let x = match k {
            Kw::X => return Ok(Num::vec3(DVec3::X)),
            Kw::Y => return Ok(Num::vec3(DVec3::Y)),
            Kw::Z => return Ok(Num::vec3(DVec3::Z)),
            Kw::U => return Ok(Num::vector(2, [1.0, 0.0, 0.0, 0.0, 0.0])),
            Kw::V => return Ok(Num::vector(2, [0.0, 1.0, 0.0, 0.0, 0.0])),
            Kw::T => return Ok(Num::vector(4, [0.0, 0.0, 0.0, 1.0, 0.0])),
            Kw::VaxisRotate | Kw::Vcross | Kw::Vnormalize | Kw::Vrotate | Kw::Vturbulence | Kw::MinExtent | Kw::MaxExtent | Kw::Trace => {
                return self.parse_vector_function(k);
            }
            Kw::Pi => std::f64::consts::PI,
            Kw::Yes | Kw::On => 1.0,
            Kw::No | Kw::Off => 0.0,
            Kw::Version => f64::from(self.version) / 100.0,
            Kw::Clock => f64::from(self.options.clock as f32),
            Kw::ClockOn => f64::from(self.options.clock_on),
            Kw::Now => self.world.now_seconds() / 86_400.0,
            Kw::Abs => self.one()?.abs(),
            Kw::Acos | Kw::Asin => {
                let a = self.one()?;
                if a.abs() > 1.0 {
                    self.warn(format!("Domain error in {}.", k.text()));
                }
                let a = a.clamp(-1.0, 1.0);
                if k == Kw::Acos { a.acos() } else { a.asin() }
            }
            // C's formulas differ from Rust's in the last digits of nothing that a scene prints.
            Kw::Acosh => match self.one()? {
                // C's acosh of less than 1 is a NaN that prints its sign.
                a if a < 1.0 => -f64::NAN,
                a => a.acosh(),
            },
            Kw::Asinh => self.one()?.asinh(),
            Kw::Atan => self.one()?.atan(),
            Kw::Atanh => self.one()?.atanh(),
            Kw::Ceil => self.one()?.ceil(),
            Kw::Cos => self.one()?.cos(),
            Kw::Cosh => self.one()?.cosh(),
            Kw::Degrees => self.one()? * (180.0 / std::f64::consts::PI),
            Kw::Exp => self.one()?.exp(),
            Kw::Floor => self.one()?.floor(),
            Kw::Int => f64::from(to_int(self.one()?)),
            Kw::Radians => self.one()? * (std::f64::consts::PI / 180.0),
            Kw::Sin => self.one()?.sin(),
            Kw::Sinh => self.one()?.sinh(),
            Kw::Tan => self.one()?.tan(),
            Kw::Tanh => self.one()?.tanh(),
            Kw::Ln | Kw::Log => {
                let a = self.one()?;
                if a <= 0.0 {
                    return Err(self.error(format!("{} of negative number {a:.6}", k.text())));
                }
                if k == Kw::Ln { a.ln() } else { a.log10() }
            }
            Kw::Sqrt => {
                let a = self.one()?;
                if a < 0.0 {
                    return Err(self.error(format!("sqrt of negative number {a:.6}")));
                }
                a.sqrt()
            }
            Kw::Atan2 => {
                let (y, x) = self.two()?;
                if x == 0.0 && y == 0.0 {
                    return Err(self.error("Domain error in atan2!"));
                }
                y.atan2(x)
            }
            Kw::Pow => {
                let (a, b) = self.two()?;
                if a == 0.0 && b == 0.0 {
                    return Err(self.error("Domain error."));
                }
                a.powf(b)
            }
            Kw::Mod => {
                let (a, b) = self.two()?;
                a % b
            }
            Kw::Div => {
                let (a, b) = self.two()?;
                f64::from(to_int(a / b))
            }
            Kw::Max => self.fold(|a, b| if b > a { b } else { a })?,
            Kw::Min => self.fold(|a, b| if b < a { b } else { a })?,
            Kw::BitwiseAnd => self.fold(|a, b| f64::from(to_int(a) & to_int(b)))?,
            Kw::BitwiseOr => self.fold(|a, b| f64::from(to_int(a) | to_int(b)))?,
            Kw::BitwiseXor => self.fold(|a, b| f64::from(to_int(a) ^ to_int(b)))?,
            Kw::Select => self.select()?,
            Kw::Vdot => {
                let [a, b] = self.vectors()?;
                a.dot(b)
            }
            Kw::Vlength => {
                let [a] = self.vectors()?;
                a.length()
            }
            Kw::Asc => self.in_parens(|p| p.parse_string_units())?.first().map_or(0.0, |&c| f64::from(c)),
            Kw::Strlen => self.in_parens(|p| p.parse_string_units())?.len() as f64,
            Kw::Strcmp => {
                let (a, b) = self.in_parens(|p| {
                    let a = p.parse_string_units()?;
                    p.comma()?;
                    Ok((a, p.parse_string_units()?))
                })?;
                let at = a.iter().zip(b.iter()).take_while(|(x, y)| x == y).count();
                let unit = |s: &[u16]| f64::from(s.get(at).copied().unwrap_or(0));
                unit(&a) - unit(&b)
            }
            Kw::Val => {
                let text = self.in_parens(|p| p.parse_text())?;
                c_atof(&text)
            }
            Kw::FileExists => {
                let name = self.in_parens(|p| p.parse_file_name())?;
                f64::from(self.world.find(&name, &[]).is_some())
            }
            Kw::Defined => f64::from(self.opened(|p| p.defined_condition())?),
            Kw::Dimensions | Kw::DimensionSize => self.dimension_function(k)?,
            Kw::Seed => {
                let n = self.one()?;
                self.seeds.push(n.trunc() as i64 as u32);
                (self.seeds.len() - 1) as f64
            }
            Kw::Rand => {
                let n = self.one()?;
                let Some(s) = (n >= 0.0).then(|| self.seeds.get_mut(n as usize)).flatten() else {
                    return Err(self.error("Illegal random number generator."));
                };
                *s = s.wrapping_mul(1_812_433_253).wrapping_add(12_345);
                f64::from(*s) / 4_294_967_295.0
            }
            Kw::Inside => {
                let (object, point) = self.in_parens(|p| {
                    let object = p.object_argument()?;
                    p.comma()?;
                    Ok((object, p.parse_vector3()?))
                })?;
                match self.query.inside(&object, point) {
                    Some(yes) => f64::from(yes),
                    None => return Err(self.error("Solid object identifier expected.")),
                }
            }
            _ => return self.expected("numeric expression"),
        };
        Ok(Num::float(x))
    }

    fn select(&mut self) -> PResult<f64> {
        self.in_parens(|p| {
            let a = p.parse_float()?;
            p.comma()?;
            let b = p.parse_float()?;
            p.comma()?;
            let c = p.parse_float()?;
            if p.at_punct(Punct::RParen)? {
                return Ok(if a < 0.0 { b } else { c });
            }
            p.expect(Punct::Comma)?;
            let d = p.parse_float()?;
            Ok(if a < 0.0 {
                b
            } else if a == 0.0 {
                c
            } else {
                d
            })
        })
    }

    fn dimension_function(&mut self, k: Kw) -> PResult<f64> {
        self.in_parens(|p| {
            let t = p.closed_place(|p| p.next())?;
            let TokenKind::Ident(name) = t.kind else { return Err(p.expected_instead("array identifier", t)) };
            let Some(mut place) = p.symbols.resolve(name) else { return Err(p.expected_instead("array identifier", t)) };
            while p.at_punct(Punct::LBracket)? {
                p.subscripts(&mut place)?;
            }
            let Some(Value::Array(a)) = p.symbols.value_at(&place) else { return Err(p.expected_instead("array identifier", t)) };
            let dims = a.dims.clone();
            if k == Kw::Dimensions {
                return Ok(dims.len() as f64);
            }
            p.comma()?;
            let i = p.parse_float()?;
            Ok(if i >= 1.0 { dims.get(i as usize - 1).map_or(0.0, |&d| d as f64) } else { 0.0 })
        })
    }

    /// An object's name.
    fn object_argument(&mut self) -> PResult<Arc<crate::scene::Object>> {
        let t = self.next()?;
        if let TokenKind::Ident(name) = t.kind
            && let Some(place) = self.take_place(name)?
            && let Some(Value::Object(o)) = self.symbols.value_at(&place)
        {
            return Ok(o.clone());
        }
        Err(self.expected_instead("object identifier", t))
    }

    fn parse_vector_function(&mut self, k: Kw) -> PResult<Num> {
        let v = match k {
            Kw::Vcross => {
                let [a, b] = self.vectors()?;
                a.cross(b)
            }
            Kw::Vnormalize => {
                let [a] = self.vectors()?;
                let length = a.length();
                if length == 0.0 {
                    if self.version >= 350 {
                        self.warn("Possible Parse Error: Normalizing zero-length vector.");
                    }
                    DVec3::ZERO
                } else {
                    a / length
                }
            }
            Kw::Vrotate => {
                let [a, r] = self.vectors()?;
                crate::math::Transform::rotation_deg(r).vector(a)
            }
            Kw::VaxisRotate => {
                let (v, axis, degrees) = self.in_parens(|p| {
                    let v = p.parse_vector3()?;
                    p.comma()?;
                    let axis = p.parse_vector3()?;
                    p.comma()?;
                    Ok((v, axis, p.parse_float()?))
                })?;
                let a = axis / axis.length();
                let (s, c) = degrees.to_radians().sin_cos();
                v * c + a.cross(v) * s + a * (a.dot(v) * (1.0 - c))
            }
            Kw::Vturbulence => {
                let (lambda, omega, octaves, p) = self.in_parens(|p| {
                    let lambda = p.parse_float()?;
                    p.comma()?;
                    let omega = p.parse_float()?;
                    p.comma()?;
                    let octaves = p.parse_float()?;
                    p.comma()?;
                    Ok((lambda, omega, octaves, p.parse_vector3()?))
                })?;
                noise::turbulence_vector(p, (octaves as i64).clamp(1, 10) as u32, omega as f32, lambda as f32)
            }
            Kw::Trace => return self.trace_function(),
            _ => {
                let (low, high) = self.in_parens(|p| {
                    let t = p.peek()?;
                    if let Some(Value::Pigment(pigment)) = p.peek_value()? {
                        let pigment = pigment.clone();
                        p.next()?;
                        return match &pigment.kind {
                            PigmentKind::ImageMap(m) => {
                                let size = DVec3::new(f64::from(m.image.width), f64::from(m.image.height), 0.0);
                                Ok((DVec3::ZERO, size))
                            }
                            _ => Err(p.expected_instead("image map or object identifier", t)),
                        };
                    }
                    let object = p.object_argument()?;
                    let b = p.query.extent(&object);
                    Ok((b.min, b.max))
                })?;
                if k == Kw::MinExtent { low } else { high }
            }
        };
        Ok(Num::vec3(v))
    }

    fn trace_function(&mut self) -> PResult<Num> {
        let (object, origin, dir, target) = self.in_parens(|p| {
            let object = p.object_argument()?;
            p.comma()?;
            let origin = p.parse_vector3()?;
            p.comma()?;
            let dir = p.parse_vector3()?;
            p.comma()?;
            if p.at_punct(Punct::RParen)? {
                return Ok((object, origin, dir, None));
            }
            let t = p.next()?;
            let place = if let TokenKind::Ident(name) = t.kind { p.take_place(name)? } else { None };
            match place {
                Some(place) if matches!(p.symbols.value_at(&place), Some(Value::Num(n)) if n.n == 3) => {
                    Ok((object, origin, dir, Some(place)))
                }
                _ => Err(p.expected_instead("vector identifier", t)),
            }
        })?;
        let length = dir.length();
        let hit = if length > 0.0 { self.query.trace(&object, &Ray::new(origin, dir / length)) } else { None };
        let (point, normal) = hit.unwrap_or((DVec3::ZERO, DVec3::ZERO));
        if let Some(place) = target {
            let name = place.name;
            self.assign(&place, name, Value::Num(Num::vec3(normal)))?;
        }
        Ok(Num::vec3(point))
    }

    /// `( ... )` after a function's name.
    pub(super) fn call_function(&mut self, f: &Arc<Function>) -> PResult<Num> {
        let n = f.n_params;
        let mut args = [0.0; super::macros::MAX_PARAMS];
        self.in_parens(|p| {
            for (i, a) in args.iter_mut().enumerate().take(n) {
                if i > 0 {
                    p.comma()?;
                }
                *a = p.parse_float()?;
            }
            Ok(())
        })?;
        let (v, count) = self.query.call(f, &args[..n]);
        Ok(Num { n: count as u8, is_color: count == 5, v })
    }

    /// `(t)` or `(t, kind)` after a spline's name.
    pub(super) fn call_spline(&mut self, s: &Arc<Spline>) -> PResult<Num> {
        let (t, kind) = self.in_parens(|p| {
            let t = p.parse_float()?;
            p.comma()?;
            let kind = match p.peek_kw()? {
                Some(Kw::LinearSpline) => Some(SplineKind::Linear),
                Some(Kw::QuadraticSpline) => Some(SplineKind::Quadratic),
                Some(Kw::CubicSpline) => Some(SplineKind::Cubic),
                Some(Kw::NaturalSpline) => Some(SplineKind::Natural),
                _ => None,
            };
            if kind.is_some() {
                p.next()?;
            }
            Ok((t, kind))
        })?;
        Ok(Num::vector(s.n_components as u8, self.query.spline(s, t, kind)))
    }
}

/// C's `atof`: leading blanks, a sign, decimal or hexadecimal digits; anything else ends it.
fn c_atof(text: &str) -> f64 {
    let t = text.trim_start();
    let (sign, t) = match t.as_bytes().first() {
        Some(b'-') => (-1.0, &t[1..]),
        Some(b'+') => (1.0, &t[1..]),
        _ => (1.0, t),
    };
    if let Some(hex) = t.strip_prefix("0x").or_else(|| t.strip_prefix("0X")) {
        return sign * hex.chars().map_while(|c| c.to_digit(16)).fold(0.0, |x, d| x * 16.0 + f64::from(d));
    }
    let b = t.as_bytes();
    let digits = |mut i: usize| {
        while b.get(i).is_some_and(u8::is_ascii_digit) {
            i += 1;
        }
        i
    };
    let mut end = digits(0);
    if b.get(end) == Some(&b'.') {
        end = digits(end + 1);
    }
    if matches!(b.get(end), Some(b'e' | b'E')) {
        let sign_len = usize::from(matches!(b.get(end + 1), Some(b'+' | b'-')));
        let past = digits(end + 1 + sign_len);
        if past > end + 1 + sign_len {
            end = past;
        }
    }
    sign * t[..end].parse().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn val_reads_as_c_does() {
        for (text, x) in [("12.5e1x", 125.0), ("  -3", -3.0), ("-0x10", -16.0), ("abc", 0.0), (".5", 0.5), ("1e", 1.0)] {
            assert_eq!(c_atof(text), x, "{text}");
        }
    }

    #[test]
    fn ints_wrap_like_c() {
        assert_eq!(to_int(3e9), i32::MIN);
        assert_eq!(to_int(-2.9), -2);
    }
}
