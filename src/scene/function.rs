//! User functions: numbers from numbers. Source: spec/objects.md, section 16; spec/language.md, section 3.5.

use super::{Pattern, Pigment, Spline};
use crate::math::Transform;
use std::sync::Arc;

/// A declared or anonymous function.
#[derive(Clone, Debug)]
pub struct Function {
    /// Declared name, empty when anonymous; for messages only.
    pub name: String,
    /// Number of parameters; `x y z` when no list was given.
    pub n_params: usize,
    /// What it computes.
    pub body: FunctionBody,
    /// Operands of one call, those inside the functions that it calls included; a sum or product whose bounds are numbers counts its terms.
    pub cost: u64,
}

/// What a function computes.
#[derive(Clone, Debug)]
pub enum FunctionBody {
    /// An expression over the parameters: a number.
    Expr(FnExpr),
    /// One of POV-Ray's built-in ones, by its number in `internal(n)`: a number.
    Internal(u32),
    /// Colour at a point: five components.
    Pigment(Arc<Pigment>),
    /// Pattern value at a point: a number.
    Pattern(Arc<Pattern>),
    /// The transformed point: three components.
    Transform(Transform),
    /// A spline of one parameter: its components.
    Spline(Arc<Spline>),
}

/// Arguments of the built-in functions by number, x, y, z included; 0 for numbers that are none. Measured: the installed functions.inc.
#[rustfmt::skip]
const INTERNAL_ARGS: [u8; 79] = [
    8, 8, 8, 8, 5, 5, 8, 7, 5, 4, 7, 4, 4, 4, 4, 9, 9, 6, 4, 7, 6, 9, 4, 4, 13, 10, 10, 4, 4, 9, 4, 6, 7, 6, 9, 4, 4, 7, 4, 9,
    8, 4, 4, 4, 7, 4, 6, 3, 4, 4, 10, 8, 9, 4, 4, 4, 6, 3, 9, 9, 7, 4, 8, 7, 9, 4, 7, 10, 5, 3, 5, 6, 4, 4, 5, 9, 3, 0, 4,
];

/// How many arguments built-in function `n` takes; `None` when there is none of that number.
pub fn internal_args(n: u32) -> Option<usize> {
    INTERNAL_ARGS.get(n as usize).filter(|k| **k > 0).map(|k| usize::from(*k))
}

/// Two-argument operators; comparisons give 0 or 1 and are exact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "the names say it")]
pub enum FnBinary {
    Add,
    Sub,
    Mul,
    Div,
    Eq,
    Ne,
    Lt,
    Le,
    Gt,
    Ge,
    And,
    Or,
}

/// Functions that expressions may call.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "the names are POV-Ray's")]
pub enum FnBuiltin {
    Abs,
    Acos,
    Acosh,
    Asin,
    Asinh,
    Atan,
    Atan2,
    Atanh,
    Ceil,
    Cos,
    Cosh,
    Degrees,
    Div,
    Exp,
    Floor,
    Int,
    Ln,
    Log,
    Max,
    Min,
    Mod,
    Pow,
    Radians,
    Select,
    Sin,
    Sinh,
    Sqrt,
    Tan,
    Tanh,
}

/// A function's expression. Run-time faults are silent: infinities and NaN.
#[derive(Clone, Debug)]
#[expect(missing_docs, reason = "the variants say what their parts are")]
pub enum FnExpr {
    /// A number.
    Const(f64),
    /// A parameter, or the index of an enclosing sum or product (numbered after the parameters, outermost first).
    Var(u16),
    /// Minus.
    Neg(Box<FnExpr>),
    /// An operator.
    Binary(FnBinary, Box<FnExpr>, Box<FnExpr>),
    /// A built-in function.
    Call(FnBuiltin, Vec<FnExpr>),
    /// Another function; `member` picks a component, 0 for those that give a number. Member 5 is grey.
    User { function: Arc<Function>, args: Vec<FnExpr>, member: u8 },
    /// `sum(i, from, to, body)`; the index runs in steps of one while it is at most `to`.
    Sum { var: u16, from: Box<FnExpr>, to: Box<FnExpr>, body: Box<FnExpr> },
    /// `prod(i, from, to, body)`.
    Prod { var: u16, from: Box<FnExpr>, to: Box<FnExpr>, body: Box<FnExpr> },
}
