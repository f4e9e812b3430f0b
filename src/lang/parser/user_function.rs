//! `function { ... }` and `spline { ... }`. Source: spec/language.md, section 3.5; spec/objects.md, sections 16 and 17.

use super::{PResult, Parser};
use crate::lang::keyword::Kw;
use crate::lang::token::{Punct, Symbol, TokenKind};
use crate::lang::value::Value;
use crate::scene::function::{FnBinary, FnBuiltin, FnExpr, internal_args};
use crate::scene::spline::SplineKind;
use crate::scene::{Function, FunctionBody, Spline};
use std::sync::Arc;

/// Names that an expression may use: parameters, then the indices of sums and products.
struct Names {
    names: Vec<Variable>,
    /// Operands so far.
    n_nodes: usize,
    /// [`Function::cost`] so far.
    cost: u64,
}

/// Most operands of one function: they form a tree that is walked by recursion.
const MAX_NODES: usize = 20_000;
/// Most [`Function::cost`]: two calls in each of thirty functions, one inside the other, are a billion.
const MAX_COST: u64 = 100_000_000;

#[derive(Clone, Copy, PartialEq)]
enum Variable {
    /// x, y or z; u and v are other words for x and y.
    Coordinate(Kw),
    Name(Symbol),
}

impl Variable {
    fn of(token: TokenKind) -> Option<Self> {
        Some(match token {
            TokenKind::Ident(s) => Self::Name(s),
            TokenKind::Kw(Kw::X | Kw::U) => Self::Coordinate(Kw::X),
            TokenKind::Kw(Kw::Y | Kw::V) => Self::Coordinate(Kw::Y),
            TokenKind::Kw(Kw::Z) => Self::Coordinate(Kw::Z),
            _ => return None,
        })
    }
}

impl Parser<'_> {
    /// `[(names)] { ... }` after `function` in a declaration.
    pub(super) fn parse_function(&mut self) -> PResult<Arc<Function>> {
        let mut names = Vec::new();
        let mut listed = false;
        if self.accept(Punct::LParen)? {
            listed = true;
            while !self.at_punct(Punct::RParen)? {
                let t = self.closed_place(|p| p.next())?;
                let Some(name) = Variable::of(t.kind) else { return Err(self.expected_instead("parameter identifier", t)) };
                names.push(name);
                self.comma()?;
            }
            self.expect(Punct::RParen)?;
        }
        if names.len() > super::macros::MAX_PARAMS {
            return Err(self.error("Function has too many parameters."));
        }
        if names.is_empty() {
            names = Self::coordinates(3);
        }
        self.block("function", |p| p.function_body(Names { names, n_nodes: 0, cost: 0 }, listed))
    }

    /// `{ ... }` after `function` anywhere else: of the first `n_params` of x, y and z.
    pub(super) fn parse_function_block(&mut self, n_params: usize) -> PResult<Arc<Function>> {
        let names = Self::coordinates(n_params);
        self.block("function", |p| p.function_body(Names { names, n_nodes: 0, cost: 0 }, false))
    }

    fn coordinates(n: usize) -> Vec<Variable> {
        [Kw::X, Kw::Y, Kw::Z][..n].iter().map(|&k| Variable::Coordinate(k)).collect()
    }

    /// `function {...}` of `n_params` coordinates or a function's name, where an object wants one.
    pub(super) fn parse_function_item(&mut self, n_params: usize) -> PResult<Arc<Function>> {
        if self.accept_kw(Kw::Function)? {
            // `function { Name }` is the named function itself.
            return self.parse_function_block(n_params);
        }
        if let Some(Value::Function(f)) = self.peek_value()? {
            let f = f.clone();
            self.next()?;
            return Ok(f);
        }
        self.expected("function")
    }

    fn function_body(&mut self, mut names: Names, listed: bool) -> PResult<Arc<Function>> {
        let n_params = names.names.len();
        let make = |n_params, body| Ok(Arc::new(Function { name: String::new(), n_params, body, cost: 1 }));
        match self.peek_kw()? {
            Some(Kw::Internal) => {
                self.next()?;
                self.expect(Punct::LParen)?;
                let t = self.next()?;
                let TokenKind::Float(n) = t.kind else { return Err(self.expected_instead("internal function identifier", t)) };
                let n = n as u32;
                self.expect(Punct::RParen)?;
                let Some(n_args) = internal_args(n) else { return Err(self.error(format!("Function 'internal({n})' does not exist."))) };
                return make(n_args, FunctionBody::Internal(n));
            }
            Some(Kw::Pigment) if !listed => {
                self.next()?;
                let pigment = self.parse_pigment_block()?;
                return make(3, FunctionBody::Pigment(pigment));
            }
            Some(Kw::Pattern) if !listed => {
                self.next()?;
                let pattern = self.parse_pattern_block()?;
                return make(3, FunctionBody::Pattern(Arc::new(pattern)));
            }
            Some(Kw::Transform) if !listed => {
                self.next()?;
                let t = self.parse_transform_block()?;
                return make(3, FunctionBody::Transform(t));
            }
            Some(Kw::Spline) if !listed => {
                self.next()?;
                let s = self.parse_spline()?;
                return make(1, FunctionBody::Spline(Arc::new(s)));
            }
            _ => {}
        }
        let expr = self.fn_or(&mut names)?;
        Ok(Arc::new(Function { name: String::new(), n_params, body: FunctionBody::Expr(expr), cost: names.cost }))
    }

    fn fn_binary(
        &mut self,
        names: &mut Names,
        operand: fn(&mut Self, &mut Names) -> PResult<FnExpr>,
        op_of: fn(Punct) -> Option<FnBinary>,
    ) -> PResult<FnExpr> {
        let mut a = operand(self, names)?;
        while let TokenKind::Punct(p) = self.peek()?.kind
            && let Some(op) = op_of(p)
        {
            self.next()?;
            let b = operand(self, names)?;
            a = FnExpr::Binary(op, Box::new(a), Box::new(b));
        }
        Ok(a)
    }

    fn fn_or(&mut self, names: &mut Names) -> PResult<FnExpr> {
        self.nested(|p| p.fn_binary(names, Self::fn_and, |q| (q == Punct::Or).then_some(FnBinary::Or)))
    }

    fn fn_and(&mut self, names: &mut Names) -> PResult<FnExpr> {
        self.fn_binary(names, Self::fn_relation, |q| (q == Punct::And).then_some(FnBinary::And))
    }

    fn fn_relation(&mut self, names: &mut Names) -> PResult<FnExpr> {
        self.fn_binary(names, Self::fn_sum, |q| {
            Some(match q {
                Punct::Eq => FnBinary::Eq,
                Punct::Ne => FnBinary::Ne,
                Punct::Lt => FnBinary::Lt,
                Punct::Le => FnBinary::Le,
                Punct::Gt => FnBinary::Gt,
                Punct::Ge => FnBinary::Ge,
                _ => return None,
            })
        })
    }

    fn fn_sum(&mut self, names: &mut Names) -> PResult<FnExpr> {
        self.fn_binary(names, Self::fn_product, |q| match q {
            Punct::Plus => Some(FnBinary::Add),
            Punct::Minus => Some(FnBinary::Sub),
            _ => None,
        })
    }

    fn fn_product(&mut self, names: &mut Names) -> PResult<FnExpr> {
        self.fn_binary(names, Self::fn_unary, |q| match q {
            Punct::Star => Some(FnBinary::Mul),
            Punct::Slash => Some(FnBinary::Div),
            _ => None,
        })
    }

    fn fn_unary(&mut self, names: &mut Names) -> PResult<FnExpr> {
        if self.accept(Punct::Plus)? {
            return self.nested(|p| p.fn_unary(names));
        }
        if self.accept(Punct::Minus)? {
            let e = self.nested(|p| p.fn_unary(names))?;
            return Ok(FnExpr::Neg(Box::new(e)));
        }
        self.fn_primary(names)
    }

    fn fn_primary(&mut self, names: &mut Names) -> PResult<FnExpr> {
        let t = self.next()?;
        names.n_nodes += 1;
        names.cost += 1;
        if names.n_nodes > MAX_NODES {
            return Err(self.error(format!("Function too long (more than {MAX_NODES} operands).")));
        }
        match t.kind {
            TokenKind::Float(x) => Ok(FnExpr::Const(x)),
            TokenKind::Punct(Punct::LParen) => {
                let e = self.fn_or(names)?;
                self.expect(Punct::RParen)?;
                Ok(e)
            }
            TokenKind::Ident(s) => {
                if let Some(i) = names.names.iter().rposition(|&n| n == Variable::Name(s)) {
                    return Ok(FnExpr::Var(i as u16));
                }
                match self.symbols.value(s) {
                    Some(Value::Num(n)) if n.n == 1 => Ok(FnExpr::Const(n.v[0])),
                    Some(Value::Function(f)) => {
                        let f = f.clone();
                        self.note_reach(s);
                        self.fn_user_call(f, names)
                    }
                    _ => {
                        let name = self.interner.text(s);
                        self.warn(format!("Possible Parse Error: Suspicious identifier '{name}' found in function!"));
                        Err(self.expected_instead("operand", t))
                    }
                }
            }
            TokenKind::Kw(k) => {
                if let Some(name) = Variable::of(t.kind) {
                    // A coordinate that is no parameter is 0.
                    let place = names.names.iter().rposition(|&n| n == name);
                    return Ok(place.map_or(FnExpr::Const(0.0), |i| FnExpr::Var(i as u16)));
                }
                match k {
                    Kw::Pi => Ok(FnExpr::Const(std::f64::consts::PI)),
                    Kw::Clock => Ok(FnExpr::Const(f64::from(self.options.clock as f32))),
                    Kw::Yes | Kw::On => Ok(FnExpr::Const(1.0)),
                    Kw::No | Kw::Off => Ok(FnExpr::Const(0.0)),
                    Kw::Sum | Kw::Prod => self.fn_series(k, names),
                    _ => match builtin(k) {
                        Some((f, min, max)) => {
                            let args = self.fn_args(names)?;
                            if args.len() < min || args.len() > max {
                                return Err(self.error(format!("Wrong number of arguments for '{}' in a function.", k.text())));
                            }
                            Ok(FnExpr::Call(f, args))
                        }
                        None => Err(self.expected_instead("operand", t)),
                    },
                }
            }
            _ => Err(self.expected_instead("operand", t)),
        }
    }

    fn fn_args(&mut self, names: &mut Names) -> PResult<Vec<FnExpr>> {
        self.expect(Punct::LParen)?;
        let mut args = Vec::new();
        loop {
            args.push(self.fn_or(names)?);
            if !self.accept(Punct::Comma)? {
                break;
            }
        }
        self.expect(Punct::RParen)?;
        Ok(args)
    }

    fn fn_user_call(&mut self, function: Arc<Function>, names: &mut Names) -> PResult<FnExpr> {
        let args = self.fn_args(names)?;
        if args.len() != function.n_params {
            return Err(self.error(format!(
                "Invalid number of parameters in call of function '{}': {} given, {} wanted.",
                function.name,
                args.len(),
                function.n_params
            )));
        }
        names.cost = names.cost.saturating_add(function.cost);
        self.check_cost(names)?;
        let mut member = 0;
        // What is no number needs a member, and numbers have none.
        if !matches!(function.body, FunctionBody::Expr(_) | FunctionBody::Internal(_) | FunctionBody::Pattern(_)) {
            let t = self.next()?;
            if t.kind != TokenKind::Punct(Punct::Dot) {
                return Err(self.expected_instead(".", t));
            }
            let t = self.next()?;
            let index = if let TokenKind::Kw(k) = t.kind { super::expr::member_index(k) } else { None };
            let Some(i) = index else { return Err(self.expected_instead("color or vector component", t)) };
            member = i as u8;
        }
        Ok(FnExpr::User { function, args, member })
    }

    fn check_cost(&self, names: &Names) -> PResult<()> {
        if names.cost <= MAX_COST {
            return Ok(());
        }
        Err(self.error(format!(
            "Function takes too long (a call of it has more than {MAX_COST} operands, with those of the functions inside)."
        )))
    }

    fn fn_series(&mut self, k: Kw, names: &mut Names) -> PResult<FnExpr> {
        self.expect(Punct::LParen)?;
        let t = self.closed_place(|p| p.next())?;
        let Some(variable) = Variable::of(t.kind) else { return Err(self.expected_instead("local variable", t)) };
        self.expect(Punct::Comma)?;
        let from = Box::new(self.fn_or(names)?);
        self.expect(Punct::Comma)?;
        let to = Box::new(self.fn_or(names)?);
        self.expect(Punct::Comma)?;
        let var = names.names.len() as u16;
        names.names.push(variable);
        let before = names.cost;
        let body = self.fn_or(names);
        names.names.pop();
        let body = Box::new(body?);
        if let (FnExpr::Const(a), FnExpr::Const(b)) = (&*from, &*to) {
            let n_terms = (b - a + 1.0).max(1.0) as u64;
            names.cost = before.saturating_add((names.cost - before).saturating_mul(n_terms));
            self.check_cost(names)?;
        }
        self.expect(Punct::RParen)?;
        Ok(if k == Kw::Sum { FnExpr::Sum { var, from, to, body } } else { FnExpr::Prod { var, from, to, body } })
    }

    /// `spline { ... }` after the word.
    pub(super) fn parse_spline(&mut self) -> PResult<Spline> {
        self.block("spline", |p| {
            let mut spline = match p.peek_value()? {
                Some(Value::Spline(s)) => {
                    let s = (**s).clone();
                    p.next()?;
                    p.comma()?;
                    s
                }
                _ => Spline { kind: SplineKind::Linear, n_components: 2, knots: Vec::new() },
            };
            let kind = match p.peek_kw()? {
                Some(Kw::LinearSpline) => Some(SplineKind::Linear),
                Some(Kw::QuadraticSpline) => Some(SplineKind::Quadratic),
                Some(Kw::CubicSpline) => Some(SplineKind::Cubic),
                Some(Kw::NaturalSpline) => Some(SplineKind::Natural),
                _ => None,
            };
            if let Some(k) = kind {
                p.next()?;
                spline.kind = k;
            }
            while p.number_follows()? {
                let t = p.parse_float()?;
                p.comma()?;
                let v = p.parse_sum()?;
                p.comma()?;
                let n = (v.n as usize).max(2);
                let v = v.promoted(n as u8);
                spline.n_components = spline.n_components.max(n);
                let at = spline.knots.partition_point(|k| k.0 < t);
                if spline.knots.get(at).is_some_and(|k| k.0 == t) {
                    spline.knots[at].1 = v.v;
                } else {
                    spline.knots.insert(at, (t, v.v));
                }
            }
            if spline.knots.is_empty() {
                return p.expected("spline entry");
            }
            Ok(spline)
        })
    }
}

fn builtin(k: Kw) -> Option<(FnBuiltin, usize, usize)> {
    use FnBuiltin as F;
    let many = super::macros::MAX_PARAMS;
    Some(match k {
        Kw::Abs => (F::Abs, 1, 1),
        Kw::Acos => (F::Acos, 1, 1),
        Kw::Acosh => (F::Acosh, 1, 1),
        Kw::Asin => (F::Asin, 1, 1),
        Kw::Asinh => (F::Asinh, 1, 1),
        Kw::Atan => (F::Atan, 1, 1),
        Kw::Atan2 => (F::Atan2, 2, 2),
        Kw::Atanh => (F::Atanh, 1, 1),
        Kw::Ceil => (F::Ceil, 1, 1),
        Kw::Cos => (F::Cos, 1, 1),
        Kw::Cosh => (F::Cosh, 1, 1),
        Kw::Degrees => (F::Degrees, 1, 1),
        Kw::Div => (F::Div, 2, 2),
        Kw::Exp => (F::Exp, 1, 1),
        Kw::Floor => (F::Floor, 1, 1),
        Kw::Int => (F::Int, 1, 1),
        Kw::Ln => (F::Ln, 1, 1),
        Kw::Log => (F::Log, 1, 1),
        Kw::Max => (F::Max, 1, many),
        Kw::Min => (F::Min, 1, many),
        Kw::Mod => (F::Mod, 2, 2),
        Kw::Pow => (F::Pow, 2, 2),
        Kw::Radians => (F::Radians, 1, 1),
        Kw::Select => (F::Select, 3, 4),
        Kw::Sin => (F::Sin, 1, 1),
        Kw::Sinh => (F::Sinh, 1, 1),
        Kw::Sqrt => (F::Sqrt, 1, 1),
        Kw::Tan => (F::Tan, 1, 1),
        Kw::Tanh => (F::Tanh, 1, 1),
        _ => return None,
    })
}
