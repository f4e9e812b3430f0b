//! User functions → bytecode for a register machine: expressions in static single assignment with equal parts computed once,
//! small callees inlined, then registers reused. `kernel/function.rs` runs it.

use super::texture::{FunctionIx, PatternIx, PigmentIx, TextureBuilder};
use crate::scene::function::{FnBinary, FnBuiltin, FnExpr};
use crate::scene::{Function, FunctionBody};
use std::collections::HashMap;
use std::sync::Arc;

/// Operations; `a`, `b`, `c` are registers unless said otherwise.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
#[expect(missing_docs, reason = "the names say it")]
pub enum Op {
    /// `constants[a | b << 16]`.
    Const,
    Neg,
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
    DivInt,
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
    Sin,
    Sinh,
    Sqrt,
    Tan,
    Tanh,
    /// `a < 0 ? b : c`.
    SelectNegative,
    /// `a == 0 ? b : c`.
    SelectZero,
    /// The scene's noise at (a, b, c).
    Noise,
    /// Built-in number `call_sites[a | b << 16].function`.
    Internal,
    /// User function of `call_sites[a | b << 16]`; results go to `dst` and the registers after it.
    Call,
    /// `call_sites[a | b << 16]`: its first two arguments are the bounds, the rest go to the body, followed by the index.
    Sum,
    /// As `Sum`.
    Prod,
}

/// One step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Instr {
    /// What to do.
    pub op: Op,
    /// Register of the result.
    pub dst: u16,
    /// First operand.
    pub a: u16,
    /// Second operand.
    pub b: u16,
    /// Third operand.
    pub c: u16,
}

/// A call: whom, with which registers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CallSite {
    /// Into `TextureTables::functions`, or the number of a built-in function.
    pub function: u32,
    /// First argument in `TextureTables::call_args`.
    pub args_start: u32,
    /// Number of arguments.
    pub n_args: u16,
}

/// A function as the kernel sees it.
#[derive(Clone, Copy, Debug)]
pub enum FunctionNode {
    /// Bytecode: a range of `TextureTables::instrs`. Arguments stand in the first registers.
    Code {
        /// First step.
        start: u32,
        /// Steps.
        len: u32,
        /// Registers used.
        n_regs: u32,
        /// Register of the result.
        result: u16,
        /// Arguments.
        n_params: u16,
    },
    /// Built-in by number.
    Internal(u32),
    /// Colour: five results.
    Pigment(PigmentIx),
    /// One result.
    Pattern(PatternIx),
    /// Into `TextureTables::function_transforms`: three results.
    Transform(u32),
    /// Into `TextureTables::splines`: two to five results.
    Spline(u32),
}

/// Number of `f_noise3d` among the built-in functions (functions.inc).
pub const INTERNAL_NOISE3D: u32 = 76;

/// Most steps of a function before its callees are no longer inlined.
const MAX_INLINED: usize = 4000;

/// A value in static single assignment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Value {
    Param(u16),
    /// Bits of the number.
    Const(u64),
    Unary(Op, u32),
    Binary(Op, u32, u32),
    Ternary(Op, u32, u32, u32),
    /// A call that gives several results; index into `Ssa::calls`.
    Call(u32),
    /// One result of a call.
    Result(u32, u8),
}

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct Call {
    op: Op,
    function: u32,
    args: Vec<u32>,
    n_results: u8,
}

#[derive(Default)]
struct Ssa {
    values: Vec<Value>,
    index: HashMap<Value, u32>,
    calls: Vec<Call>,
    call_index: HashMap<Call, u32>,
}

/// All that a function does.
#[derive(PartialEq, Eq, Hash)]
pub(crate) struct FunctionKey {
    values: Vec<Value>,
    calls: Vec<Call>,
    result: u32,
    n_params: usize,
}

/// Compiles an expression over `n_params` parameters. Equal functions, which loops in scenes declare by the hundred, are one.
pub(super) fn compile_expr(builder: &mut TextureBuilder, e: &FnExpr, n_params: usize) -> FunctionIx {
    let mut ssa = Ssa::default();
    let env: Vec<u32> = (0..n_params).map(|k| ssa.add(Value::Param(k as u16))).collect();
    let result = ssa.expr(builder, e, &env);
    let key = FunctionKey { values: ssa.values, calls: ssa.calls, result, n_params };
    if let Some(ix) = builder.compiled(&key) {
        return ix;
    }
    let node = key.emit(builder);
    builder.add_compiled(key, node)
}

impl Ssa {
    fn add(&mut self, v: Value) -> u32 {
        if let Some(id) = self.index.get(&v) {
            return *id;
        }
        let id = self.values.len() as u32;
        self.values.push(v);
        self.index.insert(v, id);
        id
    }

    fn constant(&mut self, x: f64) -> u32 {
        self.add(Value::Const(x.to_bits()))
    }

    fn known(&self, id: u32) -> Option<f64> {
        if let Value::Const(bits) = self.values[id as usize] { Some(f64::from_bits(bits)) } else { None }
    }

    fn unary(&mut self, op: Op, a: u32) -> u32 {
        match self.known(a) {
            Some(x) => self.constant(eval_op(op, x, 0.0, 0.0)),
            None => self.add(Value::Unary(op, a)),
        }
    }

    fn binary(&mut self, op: Op, a: u32, b: u32) -> u32 {
        match (self.known(a), self.known(b)) {
            (Some(x), Some(y)) => self.constant(eval_op(op, x, y, 0.0)),
            // Powers that scenes write need no logarithm.
            (None, Some(e)) if op == Op::Pow && e == 1.0 => a,
            (None, Some(e)) if op == Op::Pow && e == 2.0 => self.add(Value::Binary(Op::Mul, a, a)),
            (None, Some(e)) if op == Op::Pow && e == 3.0 => {
                let square = self.add(Value::Binary(Op::Mul, a, a));
                self.add(Value::Binary(Op::Mul, square, a))
            }
            _ => self.add(Value::Binary(op, a, b)),
        }
    }

    fn call(&mut self, call: Call) -> u32 {
        if let Some(id) = self.call_index.get(&call) {
            return *id;
        }
        let id = self.add(Value::Call(self.calls.len() as u32));
        self.calls.push(call.clone());
        self.call_index.insert(call, id);
        id
    }

    fn expr(&mut self, builder: &mut TextureBuilder, e: &FnExpr, env: &[u32]) -> u32 {
        match e {
            FnExpr::Const(x) => self.constant(*x),
            FnExpr::Var(k) => env.get(usize::from(*k)).copied().unwrap_or_else(|| self.constant(0.0)),
            FnExpr::Neg(a) => {
                let a = self.expr(builder, a, env);
                self.unary(Op::Neg, a)
            }
            FnExpr::Binary(op, a, b) => {
                let (a, b) = (self.expr(builder, a, env), self.expr(builder, b, env));
                self.binary(binary_op(*op), a, b)
            }
            FnExpr::Call(f, args) => {
                let args: Vec<u32> = args.iter().map(|a| self.expr(builder, a, env)).collect();
                self.builtin(*f, &args)
            }
            FnExpr::User { function, args, member } => {
                let args: Vec<u32> = args.iter().map(|a| self.expr(builder, a, env)).collect();
                self.user(builder, function, args, *member)
            }
            FnExpr::Sum { var, from, to, body } => self.series(builder, Op::Sum, *var, [from, to, body], env),
            FnExpr::Prod { var, from, to, body } => self.series(builder, Op::Prod, *var, [from, to, body], env),
        }
    }

    fn builtin(&mut self, f: FnBuiltin, args: &[u32]) -> u32 {
        match (f, args) {
            (FnBuiltin::Min | FnBuiltin::Max, [first, rest @ ..]) => {
                let op = if f == FnBuiltin::Min { Op::Min } else { Op::Max };
                rest.iter().fold(*first, |sum, a| self.binary(op, sum, *a))
            }
            (FnBuiltin::Select, [a, b, c]) => self.ternary(Op::SelectNegative, *a, *b, *c),
            (FnBuiltin::Select, [a, b, c, d]) => {
                let rest = self.ternary(Op::SelectZero, *a, *c, *d);
                self.ternary(Op::SelectNegative, *a, *b, rest)
            }
            (_, [a]) => self.unary(builtin_op(f), *a),
            (_, [a, b, ..]) => self.binary(builtin_op(f), *a, *b),
            (_, []) => self.constant(f64::NAN),
        }
    }

    fn ternary(&mut self, op: Op, a: u32, b: u32, c: u32) -> u32 {
        match self.known(a) {
            Some(x) => {
                let first = if op == Op::SelectNegative { x < 0.0 } else { x == 0.0 };
                if first { b } else { c }
            }
            None => self.add(Value::Ternary(op, a, b, c)),
        }
    }

    fn user(&mut self, builder: &mut TextureBuilder, f: &Arc<Function>, mut args: Vec<u32>, member: u8) -> u32 {
        match &f.body {
            FunctionBody::Expr(e) if self.values.len() < MAX_INLINED => {
                while args.len() < f.n_params {
                    args.push(self.constant(0.0));
                }
                return self.expr(builder, e, &args);
            }
            FunctionBody::Internal(n) => {
                if *n == INTERNAL_NOISE3D && args.len() >= 3 {
                    return self.add(Value::Ternary(Op::Noise, args[0], args[1], args[2]));
                }
                return self.call(Call { op: Op::Internal, function: *n, args, n_results: 1 });
            }
            _ => {}
        }
        let n_results = match &f.body {
            FunctionBody::Pigment(_) => 5,
            FunctionBody::Transform(_) => 3,
            FunctionBody::Spline(s) => s.n_components as u8,
            _ => 1,
        };
        let function = builder.function(f);
        let call = self.call(Call { op: Op::Call, function, args, n_results });
        if n_results == 1 {
            return call;
        }
        if member == 5 {
            // Grey.
            let terms = [(0, 0.297), (1, 0.589), (2, 0.114)].map(|(k, share)| {
                let (part, share) = (self.result(call, k, n_results), self.constant(share));
                self.binary(Op::Mul, share, part)
            });
            let sum = self.binary(Op::Add, terms[0], terms[1]);
            return self.binary(Op::Add, sum, terms[2]);
        }
        self.result(call, member, n_results)
    }

    fn result(&mut self, call: u32, member: u8, n_results: u8) -> u32 {
        if member < n_results { self.add(Value::Result(call, member)) } else { self.constant(0.0) }
    }

    fn series(&mut self, builder: &mut TextureBuilder, op: Op, var: u16, parts: [&FnExpr; 3], env: &[u32]) -> u32 {
        let [from, to, body] = parts;
        let (from, to) = (self.expr(builder, from, env), self.expr(builder, to, env));
        // The body is a function of everything in sight, then the index.
        let mut outer: Vec<u32> = env[..env.len().min(usize::from(var))].to_vec();
        while outer.len() < usize::from(var) {
            outer.push(self.constant(0.0));
        }
        let function = compile_expr(builder, body, usize::from(var) + 1);
        let args = [from, to].into_iter().chain(outer).collect();
        self.call(Call { op, function, args, n_results: 1 })
    }
}

impl FunctionKey {
    /// Values that `v` reads.
    fn operands(&self, v: Value, mut f: impl FnMut(u32)) {
        match v {
            Value::Param(_) | Value::Const(_) => {}
            Value::Unary(_, a) => f(a),
            Value::Binary(_, a, b) => [a, b].into_iter().for_each(f),
            Value::Ternary(_, a, b, c) => [a, b, c].into_iter().for_each(f),
            Value::Call(k) => self.calls[k as usize].args.iter().copied().for_each(f),
            Value::Result(call, _) => f(call),
        }
    }

    /// Gives live values registers and writes the steps.
    fn emit(&self, builder: &mut TextureBuilder) -> FunctionNode {
        const UNUSED: usize = usize::MAX;
        let (result, n_params) = (self.result, self.n_params);
        let n = self.values.len();
        // Last reader of every value, walking back from the result; unused values keep UNUSED.
        let mut last = vec![UNUSED; n];
        last[result as usize] = n;
        for k in (0..n).rev() {
            if last[k] != UNUSED {
                self.operands(self.values[k], |o| {
                    if last[o as usize] == UNUSED {
                        last[o as usize] = k;
                    }
                });
            }
        }
        let mut reg = vec![0u32; n];
        let mut next = n_params as u32;
        let mut free: Vec<u32> = Vec::new();
        let t = builder.tables();
        let start = t.instrs.len() as u32;
        for k in 0..n {
            let v = self.values[k];
            if last[k] == UNUSED {
                if let Value::Param(p) = v {
                    reg[k] = u32::from(p);
                }
                continue;
            }
            // A register whose last reader is this step may take its result: operands are read first.
            let mut ended = Vec::new();
            self.operands(v, |o| {
                let reusable = !matches!(self.values[o as usize], Value::Param(_) | Value::Call(_) | Value::Result(..));
                if last[o as usize] == k && reusable && !ended.contains(&reg[o as usize]) {
                    ended.push(reg[o as usize]);
                }
            });
            free.extend(ended);
            let many = if let Value::Call(c) = v { self.calls[c as usize].n_results } else { 1 };
            let mut take = || {
                if many > 1 {
                    next += u32::from(many);
                    return next - u32::from(many);
                }
                free.pop().unwrap_or_else(|| {
                    next += 1;
                    next - 1
                })
            };
            let instr = |op, dst: u32, [a, b, c]: [u32; 3]| Instr { op, dst: dst as u16, a: a as u16, b: b as u16, c: c as u16 };
            match v {
                Value::Param(p) => reg[k] = u32::from(p),
                Value::Result(call, part) => reg[k] = reg[call as usize] + u32::from(part),
                Value::Const(bits) => {
                    reg[k] = take();
                    let at = t.constants.len() as u32;
                    t.constants.push(f64::from_bits(bits));
                    t.instrs.push(instr(Op::Const, reg[k], [at & 0xFFFF, at >> 16, 0]));
                }
                Value::Unary(op, a) => {
                    reg[k] = take();
                    t.instrs.push(instr(op, reg[k], [reg[a as usize], 0, 0]));
                }
                Value::Binary(op, a, b) => {
                    reg[k] = take();
                    t.instrs.push(instr(op, reg[k], [reg[a as usize], reg[b as usize], 0]));
                }
                Value::Ternary(op, a, b, c) => {
                    reg[k] = take();
                    t.instrs.push(instr(op, reg[k], [reg[a as usize], reg[b as usize], reg[c as usize]]));
                }
                Value::Call(c) => {
                    reg[k] = take();
                    let call = &self.calls[c as usize];
                    let site = CallSite { function: call.function, args_start: t.call_args.len() as u32, n_args: call.args.len() as u16 };
                    t.call_args.extend(call.args.iter().map(|a| reg[*a as usize] as u16));
                    let at = t.call_sites.len() as u32;
                    t.call_sites.push(site);
                    t.instrs.push(instr(call.op, reg[k], [at & 0xFFFF, at >> 16, 0]));
                }
            }
        }
        if next > u32::from(u16::MAX) {
            // A function this large cannot be written by hand; it has no value.
            t.instrs.truncate(start as usize);
            t.constants.push(f64::NAN);
            let at = t.constants.len() as u32 - 1;
            t.instrs.push(Instr { op: Op::Const, dst: n_params as u16, a: at as u16, b: (at >> 16) as u16, c: 0 });
            return FunctionNode::Code { start, len: 1, n_regs: n_params as u32 + 1, result: n_params as u16, n_params: n_params as u16 };
        }
        FunctionNode::Code {
            start,
            len: t.instrs.len() as u32 - start,
            n_regs: next.max(1),
            result: reg[result as usize] as u16,
            n_params: n_params as u16,
        }
    }
}

fn binary_op(op: FnBinary) -> Op {
    match op {
        FnBinary::Add => Op::Add,
        FnBinary::Sub => Op::Sub,
        FnBinary::Mul => Op::Mul,
        FnBinary::Div => Op::Div,
        FnBinary::Eq => Op::Eq,
        FnBinary::Ne => Op::Ne,
        FnBinary::Lt => Op::Lt,
        FnBinary::Le => Op::Le,
        FnBinary::Gt => Op::Gt,
        FnBinary::Ge => Op::Ge,
        FnBinary::And => Op::And,
        FnBinary::Or => Op::Or,
    }
}

fn builtin_op(f: FnBuiltin) -> Op {
    match f {
        FnBuiltin::Abs => Op::Abs,
        FnBuiltin::Acos => Op::Acos,
        FnBuiltin::Acosh => Op::Acosh,
        FnBuiltin::Asin => Op::Asin,
        FnBuiltin::Asinh => Op::Asinh,
        FnBuiltin::Atan => Op::Atan,
        FnBuiltin::Atan2 => Op::Atan2,
        FnBuiltin::Atanh => Op::Atanh,
        FnBuiltin::Ceil => Op::Ceil,
        FnBuiltin::Cos => Op::Cos,
        FnBuiltin::Cosh => Op::Cosh,
        FnBuiltin::Degrees => Op::Degrees,
        FnBuiltin::Div => Op::DivInt,
        FnBuiltin::Exp => Op::Exp,
        FnBuiltin::Floor => Op::Floor,
        FnBuiltin::Int => Op::Int,
        FnBuiltin::Ln => Op::Ln,
        FnBuiltin::Log => Op::Log,
        FnBuiltin::Max => Op::Max,
        FnBuiltin::Min => Op::Min,
        FnBuiltin::Mod => Op::Mod,
        FnBuiltin::Pow => Op::Pow,
        FnBuiltin::Radians => Op::Radians,
        FnBuiltin::Select => Op::SelectNegative,
        FnBuiltin::Sin => Op::Sin,
        FnBuiltin::Sinh => Op::Sinh,
        FnBuiltin::Sqrt => Op::Sqrt,
        FnBuiltin::Tan => Op::Tan,
        FnBuiltin::Tanh => Op::Tanh,
    }
}

/// The value of an operation on numbers; NaN for those that are more than arithmetic. Faults are silent, as in POV-Ray.
#[inline(always)]
pub fn eval_op(op: Op, a: f64, b: f64, c: f64) -> f64 {
    let truth = |t: bool| f64::from(u8::from(t));
    match op {
        Op::Neg => -a,
        Op::Add => a + b,
        Op::Sub => a - b,
        Op::Mul => a * b,
        Op::Div => a / b,
        Op::Eq => truth(a == b),
        Op::Ne => truth(a != b),
        Op::Lt => truth(a < b),
        Op::Le => truth(a <= b),
        Op::Gt => truth(a > b),
        Op::Ge => truth(a >= b),
        Op::And => truth(a != 0.0 && b != 0.0),
        Op::Or => truth(a != 0.0 || b != 0.0),
        Op::Abs => a.abs(),
        Op::Acos => a.acos(),
        Op::Acosh => a.acosh(),
        Op::Asin => a.asin(),
        Op::Asinh => a.asinh(),
        Op::Atan => a.atan(),
        Op::Atan2 => a.atan2(b),
        Op::Atanh => a.atanh(),
        Op::Ceil => a.ceil(),
        Op::Cos => a.cos(),
        Op::Cosh => a.cosh(),
        Op::Degrees => a * (180.0 / std::f64::consts::PI),
        Op::DivInt => {
            // The quotient as a 32-bit integer; what does not fit is the smallest one (measured: div(1,0) = -2147483648).
            let q = a / b;
            if (-2_147_483_649.0..2_147_483_648.0).contains(&q) { q.trunc() } else { -2_147_483_648.0 }
        }
        Op::Exp => a.exp(),
        Op::Floor => a.floor(),
        Op::Int => a.trunc(),
        Op::Ln => a.ln(),
        Op::Log => a.log10(),
        Op::Max => {
            if a > b {
                a
            } else {
                b
            }
        }
        Op::Min => {
            if a < b {
                a
            } else {
                b
            }
        }
        Op::Mod => a % b,
        Op::Pow => a.powf(b),
        Op::Radians => a * (std::f64::consts::PI / 180.0),
        Op::Sin => a.sin(),
        Op::Sinh => a.sinh(),
        Op::Sqrt => a.sqrt(),
        Op::Tan => a.tan(),
        Op::Tanh => a.tanh(),
        Op::SelectNegative => {
            if a < 0.0 {
                b
            } else {
                c
            }
        }
        Op::SelectZero => {
            if a == 0.0 {
                b
            } else {
                c
            }
        }
        Op::Const | Op::Noise | Op::Internal | Op::Call | Op::Sum | Op::Prod => f64::NAN,
    }
}

/// The index in a function's tables that an instruction's `a` and `b` hold.
#[inline(always)]
pub fn wide_index(i: &Instr) -> usize {
    usize::from(i.a) | usize::from(i.b) << 16
}
