//! Numeric expressions: floats and vectors. Source: spec/language.md, section 3.

use super::{PResult, Parser};
use crate::lang::keyword::Kw;
use crate::lang::token::{Punct, Token, TokenKind};
use crate::lang::value::{Binding, Entry, Num, Value};
use crate::math::{DVec2, DVec3, DVec4};

/// Values closer than this are equal, and numbers this small are false.
const TOLERANCE: f64 = 1e-10;

/// What a reserved word does in an expression.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum WordClass {
    Float,
    Vector,
    Color,
    Other,
}

pub(super) fn word_class(k: Kw) -> WordClass {
    match k {
        Kw::Abs
        | Kw::Acos
        | Kw::Acosh
        | Kw::Asc
        | Kw::Asin
        | Kw::Asinh
        | Kw::Atan
        | Kw::Atan2
        | Kw::Atanh
        | Kw::BitwiseAnd
        | Kw::BitwiseOr
        | Kw::BitwiseXor
        | Kw::Ceil
        | Kw::Clock
        | Kw::ClockOn
        | Kw::Cos
        | Kw::Cosh
        | Kw::Defined
        | Kw::Degrees
        | Kw::DimensionSize
        | Kw::Dimensions
        | Kw::Div
        | Kw::Exp
        | Kw::FileExists
        | Kw::Floor
        | Kw::Inside
        | Kw::Int
        | Kw::Ln
        | Kw::Log
        | Kw::Max
        | Kw::Min
        | Kw::Mod
        | Kw::No
        | Kw::Now
        | Kw::Off
        | Kw::On
        | Kw::Pi
        | Kw::Pow
        | Kw::Radians
        | Kw::Rand
        | Kw::Seed
        | Kw::Select
        | Kw::Sin
        | Kw::Sinh
        | Kw::Sqrt
        | Kw::Strcmp
        | Kw::Strlen
        | Kw::Tan
        | Kw::Tanh
        | Kw::Val
        | Kw::Vdot
        | Kw::Version
        | Kw::Vlength
        | Kw::Yes => WordClass::Float,
        Kw::X
        | Kw::Y
        | Kw::Z
        | Kw::U
        | Kw::V
        | Kw::T
        | Kw::VaxisRotate
        | Kw::Vcross
        | Kw::Vnormalize
        | Kw::Vrotate
        | Kw::Vturbulence
        | Kw::MinExtent
        | Kw::MaxExtent
        | Kw::Trace => WordClass::Vector,
        Kw::Color
        | Kw::Rgb
        | Kw::Rgbf
        | Kw::Rgbt
        | Kw::Rgbft
        | Kw::Srgb
        | Kw::Srgbf
        | Kw::Srgbt
        | Kw::Srgbft
        | Kw::Red
        | Kw::Green
        | Kw::Blue
        | Kw::Filter
        | Kw::Transmit
        | Kw::Alpha => WordClass::Color,
        _ => WordClass::Other,
    }
}

/// Component that a member name means; 5 is grey.
pub(super) fn member_index(k: Kw) -> Option<usize> {
    Some(match k {
        Kw::X | Kw::U | Kw::Red => 0,
        Kw::Y | Kw::V | Kw::Green => 1,
        Kw::Z | Kw::Blue => 2,
        Kw::T | Kw::Filter => 3,
        Kw::Transmit => 4,
        Kw::Gray => 5,
        _ => return None,
    })
}

impl Parser<'_> {
    /// The next token where an operator may stand.
    pub(super) fn peek_op(&mut self) -> PResult<Token> {
        if self.closed_ops { self.closed_place(|p| p.peek()) } else { self.peek() }
    }

    #[inline]
    fn op(&mut self) -> PResult<Option<Punct>> {
        // Each level of an expression asks for the same token: most find it here.
        if let Some(t) = &self.ahead
            && (self.ahead_is_open || self.closed || self.closed_ops)
        {
            return Ok(if let TokenKind::Punct(p) = t.kind { Some(p) } else { None });
        }
        Ok(if let TokenKind::Punct(p) = self.peek_op()?.kind { Some(p) } else { None })
    }

    fn take_op(&mut self) -> PResult<Token> {
        if self.closed_ops { self.closed_place(|p| p.next()) } else { self.next() }
    }

    /// Cond: the whole of what stands in parentheses.
    pub(super) fn parse_cond(&mut self) -> PResult<Num> {
        let c = self.parse_logic()?;
        if self.op()? != Some(Punct::Question) {
            return Ok(c);
        }
        self.take_op()?;
        if c.n != 1 {
            return Err(self.error("Conditional must evaluate to a float."));
        }
        // Both branches are read and evaluated.
        let a = self.nested(|p| p.parse_cond())?;
        let t = self.take_op()?;
        if t.kind != TokenKind::Punct(Punct::Colon) {
            return Err(self.expected_instead(":", t));
        }
        let b = self.nested(|p| p.parse_cond())?;
        Ok(if c.v[0].abs() > TOLERANCE { a } else { b })
    }

    fn parse_logic(&mut self) -> PResult<Num> {
        let mut a = self.parse_relation()?;
        while let Some(op @ (Punct::And | Punct::Or)) = self.op()? {
            self.take_op()?;
            let b = self.parse_relation()?;
            a = combine(a, b, |x, y| {
                let (x, y) = (x.abs() > TOLERANCE, y.abs() > TOLERANCE);
                f64::from(if op == Punct::And { x && y } else { x || y })
            });
        }
        Ok(a)
    }

    fn parse_relation(&mut self) -> PResult<Num> {
        if self.string_follows()? {
            return self.parse_string_relation();
        }
        let mut a = self.parse_sum()?;
        while let Some(op) = self.op()? {
            let test: fn(f64, f64) -> bool = match op {
                Punct::Lt => |x, y| x < y,
                Punct::Le => |x, y| x <= y + TOLERANCE,
                Punct::Eq => |x, y| (x - y).abs() < TOLERANCE,
                Punct::Ne => |x, y| (x - y).abs() >= TOLERANCE,
                Punct::Ge => |x, y| x + TOLERANCE >= y,
                Punct::Gt => |x, y| x > y,
                _ => break,
            };
            self.take_op()?;
            let b = self.parse_sum()?;
            a = combine(a, b, |x, y| f64::from(test(x, y)));
        }
        Ok(a)
    }

    fn parse_string_relation(&mut self) -> PResult<Num> {
        let a = self.parse_string_units()?;
        let t = self.take_op()?;
        let TokenKind::Punct(op) = t.kind else { return Err(self.expected_instead("comparison operator", t)) };
        let b = self.parse_string_units()?;
        let order = a.cmp(&b);
        let yes = match op {
            Punct::Lt => order.is_lt(),
            Punct::Le => order.is_le(),
            Punct::Eq => order.is_eq(),
            Punct::Ne => order.is_ne(),
            Punct::Ge => order.is_ge(),
            Punct::Gt => order.is_gt(),
            _ => return Err(self.expected_instead("comparison operator", t)),
        };
        Ok(Num::float(f64::from(yes)))
    }

    /// Sum: what statement items, arguments and declarations read.
    pub(super) fn parse_sum(&mut self) -> PResult<Num> {
        let a = self.parse_product()?;
        self.sum_after(a)
    }

    /// The rest of a sum whose first operand was taken already.
    pub(super) fn parse_sum_after(&mut self, first: Num) -> PResult<Num> {
        let a = self.member(first)?;
        let a = self.product_after(a)?;
        self.sum_after(a)
    }

    fn sum_after(&mut self, mut a: Num) -> PResult<Num> {
        while let Some(op @ (Punct::Plus | Punct::Minus)) = self.op()? {
            self.take_op()?;
            let b = self.parse_product()?;
            a = if op == Punct::Plus { combine(a, b, |x, y| x + y) } else { combine(a, b, |x, y| x - y) };
        }
        Ok(a)
    }

    fn parse_product(&mut self) -> PResult<Num> {
        let a = self.parse_factor()?;
        self.product_after(a)
    }

    fn product_after(&mut self, mut a: Num) -> PResult<Num> {
        while let Some(op @ (Punct::Star | Punct::Slash)) = self.op()? {
            self.take_op()?;
            let b = self.parse_factor()?;
            if op == Punct::Star {
                a = combine(a, b, |x, y| x * y);
                continue;
            }
            let n = a.n.max(b.n);
            if b.promoted(n).v[..n as usize].contains(&0.0) {
                self.warn("Divide by zero.");
            }
            a = combine(a, b, |x, y| if y == 0.0 { f64::INFINITY } else { x / y });
        }
        Ok(a)
    }

    fn parse_factor(&mut self) -> PResult<Num> {
        let mut t = self.opened_start()?;
        while t.kind == TokenKind::Punct(Punct::Plus) {
            self.next()?;
            t = self.opened_start()?;
        }
        let a = match t.kind {
            TokenKind::Punct(Punct::Minus) => {
                self.next()?;
                let mut a = self.nested(|p| p.parse_factor())?;
                a.v.iter_mut().take(a.n as usize).for_each(|x| *x = -*x);
                a
            }
            TokenKind::Punct(Punct::Not) => {
                self.next()?;
                let mut a = self.nested(|p| p.parse_factor())?;
                a.v.iter_mut().take(a.n as usize).for_each(|x| *x = f64::from(x.abs() <= TOLERANCE));
                a
            }
            _ => self.parse_primary(t)?,
        };
        self.member(a)
    }

    fn member(&mut self, mut a: Num) -> PResult<Num> {
        if self.op()? != Some(Punct::Dot) {
            return Ok(a);
        }
        self.take_op()?;
        let t = self.take_op()?;
        let index = if let TokenKind::Kw(k) = t.kind { member_index(k) } else { None };
        let Some(i) = index else { return Err(self.expected_instead("x, y, z, or t or color component", t)) };
        if i == 5 {
            a.v[0] = 0.297 * a.v[0] + 0.589 * a.v[1] + 0.114 * a.v[2];
        } else {
            if i >= a.n as usize && (i != 0) {
                return Err(self.error("Bad operands for period operator."));
            }
            a.v[0] = a.v[i];
        }
        a.n = 1;
        a.is_color = false;
        Ok(a)
    }

    fn parse_primary(&mut self, t: Token) -> PResult<Num> {
        match t.kind {
            TokenKind::Float(x) => {
                self.next()?;
                Ok(Num::float(x))
            }
            TokenKind::Punct(Punct::LParen) => {
                self.next()?;
                let value = self.opened(|p| p.nested(|p| p.parse_cond()))?;
                self.close_paren()?;
                Ok(value)
            }
            TokenKind::Punct(Punct::Lt) => {
                self.next()?;
                let value = self.opened(|p| p.nested(|p| p.parse_components()))?;
                let t = self.take_op()?;
                if t.kind != TokenKind::Punct(Punct::Gt) {
                    return Err(self.expected_instead(">", t));
                }
                Ok(value)
            }
            TokenKind::Ident(name) => {
                let found = self.symbols.find(name).map(|(_, entry)| entry);
                if let Some(Entry { binding: Binding::Value(Value::Num(n)), deprecated: None, .. }) = found {
                    let n = *n;
                    self.next()?;
                    return Ok(n);
                }
                self.next()?;
                let Some(place) = self.take_place(name)? else { return Err(self.expected_instead("numeric expression", t)) };
                match self.symbols.value_at(&place) {
                    Some(Value::Num(n)) => {
                        let n = *n;
                        if self.symbols.find(name).is_some_and(|(_, e)| e.deprecated.is_some()) {
                            self.note_use(name);
                        }
                        Ok(n)
                    }
                    Some(Value::Function(f)) => {
                        let f = f.clone();
                        self.call_function(&f)
                    }
                    Some(Value::Spline(s)) => {
                        let s = s.clone();
                        self.call_spline(&s)
                    }
                    None if !place.path.is_empty() => Err(self.error("Attempt to access uninitialized array element.")),
                    _ => Err(self.expected_instead("numeric expression", t)),
                }
            }
            TokenKind::Element => {
                let value = self.element.clone();
                self.next()?;
                match value {
                    Some(Value::Num(n)) => Ok(n),
                    Some(Value::Function(f)) => self.call_function(&f),
                    Some(Value::Spline(s)) => self.call_spline(&s),
                    _ => Err(self.expected_instead("numeric expression", t)),
                }
            }
            TokenKind::Kw(k) => match word_class(k) {
                WordClass::Float | WordClass::Vector => {
                    self.next()?;
                    self.parse_word(k)
                }
                _ => self.expected("numeric expression"),
            },
            _ => self.expected("numeric expression"),
        }
    }

    /// The `)` of a closed operand: what follows is not looked at here.
    pub(super) fn close_paren(&mut self) -> PResult<()> {
        let t = self.take_op()?;
        if t.kind == TokenKind::Punct(Punct::RParen) { Ok(()) } else { Err(self.expected_instead(")", t)) }
    }

    /// Two to five components between `<` and `>`.
    fn parse_components(&mut self) -> PResult<Num> {
        let mut v = [0.0; 5];
        let mut n = 0;
        loop {
            v[n] = self.parse_float()?;
            n += 1;
            if n == 5 {
                break;
            }
            if n >= 2 {
                self.comma()?;
                if self.at_punct(Punct::Gt)? {
                    break;
                }
            } else {
                self.comma()?;
            }
        }
        Ok(Num::vector(n as u8, v))
    }

    pub(super) fn as_float(&self, a: Num) -> PResult<f64> {
        if a.n == 1 { Ok(a.v[0]) } else { Err(self.error("Float expected but vector or color expression found.")) }
    }

    /// A number.
    pub(super) fn parse_float(&mut self) -> PResult<f64> {
        let a = self.parse_sum()?;
        self.as_float(a)
    }

    /// A number where directives and macros are not even seen at its start (`#version`).
    pub(super) fn parse_float_in_closed_place(&mut self) -> PResult<f64> {
        self.parse_float()
    }

    /// A whole number, truncated.
    pub(super) fn parse_int(&mut self) -> PResult<i64> {
        Ok(self.parse_float()? as i64)
    }

    /// A count of work that a scene asks for, refused beyond a limit (docs/limits.md) which no real scene comes near.
    pub(super) fn at_most(&self, n: i64, limit: i64, what: &str) -> PResult<u32> {
        if n > limit {
            return Err(self.error(format!("{what} of {n} is more than the limit of {limit}.")));
        }
        Ok(n.max(0) as u32)
    }

    /// An optional number, on when absent.
    pub(super) fn parse_switch(&mut self) -> PResult<bool> {
        Ok(if self.number_follows()? { self.parse_float()? > 0.0 } else { true })
    }

    /// Whether a numeric expression starts here.
    pub(super) fn number_follows(&mut self) -> PResult<bool> {
        let t = self.peek()?;
        Ok(match t.kind {
            TokenKind::Float(_) => true,
            TokenKind::Punct(Punct::Lt | Punct::LParen | Punct::Plus | Punct::Minus | Punct::Not) => true,
            TokenKind::Kw(k) => matches!(word_class(k), WordClass::Float | WordClass::Vector),
            TokenKind::Ident(_) | TokenKind::Element => {
                matches!(self.peek_value()?, Some(Value::Num(_) | Value::Function(_) | Value::Spline(_)))
            }
            _ => false,
        })
    }

    /// A 3-vector; floats are replicated, 2-vectors get z = 0.
    pub(super) fn parse_vector3(&mut self) -> PResult<DVec3> {
        let a = self.parse_sum()?;
        if a.n > 3 {
            return Err(self.error("Vector expected but color expression found."));
        }
        let v = a.promoted(3).v;
        Ok(DVec3::new(v[0], v[1], v[2]))
    }

    /// A 2-vector; floats are replicated.
    pub(super) fn parse_vector2(&mut self) -> PResult<DVec2> {
        let a = self.parse_sum()?;
        if a.n > 2 {
            return Err(self.error("UV_Vector expected but vector or color expression found."));
        }
        let v = a.promoted(2).v;
        Ok(DVec2::new(v[0], v[1]))
    }

    /// A 4-vector.
    pub(super) fn parse_vector4(&mut self) -> PResult<DVec4> {
        let v = self.parse_sum()?.promoted(4).v;
        Ok(DVec4::new(v[0], v[1], v[2], v[3]))
    }
}

/// By component, after promotion to the longer operand.
fn combine(a: Num, b: Num, f: impl Fn(f64, f64) -> f64) -> Num {
    if a.n == 1 && b.n == 1 {
        return Num::float(f(a.v[0], b.v[0]));
    }
    let n = a.n.max(b.n);
    let (a, b) = (a.promoted(n), b.promoted(n));
    let mut v = [0.0; 5];
    for i in 0..n as usize {
        v[i] = f(a.v[i], b.v[i]);
    }
    Num { n, is_color: a.is_color || b.is_color, v }
}
