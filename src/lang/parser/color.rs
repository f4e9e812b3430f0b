//! Colour expressions. Source: spec/language.md, section 3.1.

use super::{PResult, Parser};
use crate::lang::keyword::Kw;
use crate::lang::token::TokenKind;
use crate::lang::value::Value;
use crate::math::{Rgb, Rgbft};
use crate::scene::settings::WorkingGamma;

impl Parser<'_> {
    /// A colour of five components; black when none is given.
    pub(super) fn parse_color(&mut self) -> PResult<Rgbft> {
        self.parse_color_of(5)
    }

    /// A colour where only red, green and blue count; a float is grey.
    pub(super) fn parse_rgb(&mut self) -> PResult<Rgb> {
        let c = self.parse_color_of(3)?;
        if c.filter != 0.0 || c.transmit != 0.0 {
            self.warn("Expected pure RGB color expression, unexpected filter and transmit components will have no effect.");
        }
        Ok(c.rgb)
    }

    fn parse_color_of(&mut self, target: u8) -> PResult<Rgbft> {
        self.accept_kw(Kw::Color)?;
        let mut c = [0.0f64; 5];
        let t = self.opened_start()?;
        match t.kind {
            TokenKind::Kw(k @ (Kw::Rgb | Kw::Srgb)) => {
                self.next()?;
                c = self.color_components(k, 3)?;
            }
            TokenKind::Kw(k @ (Kw::Rgbf | Kw::Srgbf)) => {
                self.next()?;
                c = self.color_components(k, 4)?;
            }
            TokenKind::Kw(k @ (Kw::Rgbt | Kw::Srgbt)) => {
                self.next()?;
                c = self.color_components(k, 4)?;
                (c[3], c[4]) = (0.0, c[3]);
            }
            TokenKind::Kw(k @ (Kw::Rgbft | Kw::Srgbft)) => {
                self.next()?;
                c = self.color_components(k, 5)?;
            }
            TokenKind::Kw(Kw::Red | Kw::Green | Kw::Blue | Kw::Filter | Kw::Transmit | Kw::Alpha) => {}
            _ if self.number_follows()? => {
                let n = self.parse_sum()?;
                c = n.promoted(target).v;
                if target == 3 && n.n < 5 {
                    c[3] = if n.n >= 4 { c[3] } else { 0.0 };
                    c[4] = 0.0;
                }
            }
            _ => {}
        }
        loop {
            let t = self.peek_op()?;
            let i = match t.kind {
                TokenKind::Kw(Kw::Red) => 0,
                TokenKind::Kw(Kw::Green) => 1,
                TokenKind::Kw(Kw::Blue) => 2,
                TokenKind::Kw(Kw::Filter) => 3,
                TokenKind::Kw(Kw::Alpha) => {
                    self.warn("Keyword ALPHA discontinued. Use FILTER instead.");
                    3
                }
                TokenKind::Kw(Kw::Transmit) => 4,
                _ => break,
            };
            self.next()?;
            c[i] = self.parse_float()?;
        }
        Ok(Rgbft::from_array(c.map(|x| x as f32)))
    }

    /// The operand of an rgb-form, promoted to `n` components; sRGB forms are decoded to the working space.
    fn color_components(&mut self, k: Kw, n: u8) -> PResult<[f64; 5]> {
        let a = self.parse_cond()?;
        if a.n > n && a.v[n as usize..a.n as usize].iter().any(|&x| x != 0.0) {
            self.warn(format!("Possible Parse Error: Suspicious expression after {}.", k.text()));
        }
        let mut v = a.promoted(n).v;
        if a.n <= n {
            v[n as usize..].fill(0.0);
        }
        if matches!(k, Kw::Srgb | Kw::Srgbf | Kw::Srgbt | Kw::Srgbft) {
            if !self.gamma_set {
                return Err(self.error("Cannot parse sRGB colors before assumed_gamma has been set."));
            }
            for x in &mut v[..3] {
                *x = self.decode_srgb(*x);
            }
        }
        Ok(v)
    }

    fn decode_srgb(&self, x: f64) -> f64 {
        let linear = if x <= 0.04045 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) };
        match self.scene.settings.gamma {
            WorkingGamma::Linear => linear,
            WorkingGamma::Power(g) => linear.powf(1.0 / g),
            WorkingGamma::Srgb | WorkingGamma::None => x,
        }
    }

    /// Whether a colour starts with a word or a colour's name here (map entries, list patterns).
    pub(super) fn color_follows(&mut self) -> PResult<bool> {
        let t = self.peek()?;
        Ok(match t.kind {
            TokenKind::Kw(k) => super::expr::word_class(k) == super::expr::WordClass::Color,
            _ => matches!(self.peek_value()?, Some(Value::Num(n)) if n.is_color),
        })
    }
}
