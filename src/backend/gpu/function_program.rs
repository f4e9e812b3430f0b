//! User functions as a program that shaders interpret: what would be too much written out (`texture_functions.rs`), since drivers put a function in wherever it is called and
//! take minutes over dozens of calls of noise. Here each operation stands in the shader once, whatever a scene asks for.
//! Twins: `run` and `call_function_all` in src/kernel/function.rs. Registers: shaders/shared/function_registers.wesl.
//!
//! Nothing calls itself in POV-Ray's functions, so each has registers of its own: those above all that it calls, directly or not.

use super::texture_encoder::TextureEncoder;
use super::texture_functions::{near, refused};
use crate::backend::BackendError;
use crate::compile::function::{CallSite, FunctionNode, Op, wide_index};
use crate::compile::texture::{FunctionIx, PatternCode, PatternIx, PigmentCode, PigmentIx};
use std::collections::{BTreeMap, HashMap};
use std::fmt::Write;

/// Operands from here on are numbers of the table (`function_registers.wesl`).
const NUMBERS_FROM: usize = 0x8000;
/// They live in each thread's own memory.
const MAX_REGISTERS: u16 = 2048;
/// Registers of a point with what 32 bits left off it, and of a colour with whether it is there.
const SIX: u16 = 6;

const MOVE: &str = "value = a;";
const COPY_SIX: &str = "copy_six(dst, group); continue;";
const CALL: &str = "returns[depth] = pc; depth++; pc = place; continue;";
const JUMP: &str = "pc = place; continue;";
const JUMP_ABOVE: &str = "if !(a <= b) { pc = place; } continue;";
const JUMP_OUTSIDE: &str = "if c < a || c >= b { pc = place; } continue;";
const POINT: &str = "keep_point(dst, real3(vec3f(a, b, c))); continue;";
const WARP: &str = "keep_point(dst, warp_point(place, held_point(group))); continue;";
const FREE_VALUE: &str = "value = free_value(place, held_point(group));";
const SHAPED: &str = "value = shaped(place, above_one(a));";
const GREY: &str = "value = shaped(place, grey_of(held_color(group)));";
const TRANSFORM: &str = "keep_vector(dst, matrix(place) * vec3f(a, b, c) + vector(place + 9u)); continue;";
const SOLID: &str = "keep_color(dst, PigmentColor(color_of_words(place), true)); continue;";
const PLAIN: &str = "keep_color(dst, plain_color(place, vec3f(held_point(group)), a)); continue;";
const CLEAR: &str = "keep_color(dst, PigmentColor(Rgbft(vec3f(0.0), 0.0, 0.0), true)); continue;";
const WANTED: &str = "let w = entries_of_map(place, a); keep_vector(dst, vec3f(f32(w.first), f32(w.end), w.share)); continue;";
const ADD_OF_MAP: &str = "let w = held_vector(operands & 0xFFFFu); \
     keep_color(dst, sum_with(held_color(dst), held_color(group), place, WantedEntries(u32(w.x), u32(w.y), w.z, true), u32(c))); continue;";
const ADD_OF_AVERAGE: &str =
    "keep_color(dst, sum_with(held_color(dst), held_color(group), place, WantedEntries(0u, 0u, 0.0, false), u32(c))); continue;";

/// Who is called.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Callee {
    Function(FunctionIx),
    Pigment(PigmentIx),
}

/// One that is written.
#[derive(Clone, Copy)]
struct Routine {
    /// First step.
    start: u32,
    /// First register, where the arguments go, and the one behind the last.
    frame: u16,
    end: u16,
    /// First register of the results.
    result: u16,
    /// Calls under way at once, its own too.
    depth: u32,
}

/// What a step works on: registers or numbers, a row of registers, a place in the texture words or among the steps.
#[derive(Clone, Copy, Default)]
struct On {
    a: u16,
    b: u16,
    c: u16,
    group: u16,
    place: u32,
}

/// A routine in the making.
struct Draft {
    /// The register behind the last.
    end: u16,
    steps: Vec<[u32; 4]>,
    /// Steps whose place counts from the routine's first one.
    jumps: Vec<usize>,
}

impl Draft {
    /// So many registers; gives the first one.
    fn take(&mut self, n: u16) -> u16 {
        self.end = self.end.saturating_add(n);
        self.end.saturating_sub(n)
    }

    /// Lets a jump lead to the next step.
    fn land(&mut self, jump: usize) {
        self.steps[jump][3] = self.steps.len() as u32;
        self.jumps.push(jump);
    }
}

/// The program so far.
#[derive(Default)]
pub(super) struct FunctionProgram {
    steps: Vec<[u32; 4]>,
    /// WGSL of each operation that is used, with its number.
    operations: HashMap<String, u32>,
    /// Bits.
    numbers: Vec<u32>,
    routines: BTreeMap<Callee, Routine>,
}

impl FunctionProgram {
    fn add(&mut self, d: &mut Draft, operation: &str, dst: u16, on: On) {
        // 0 is the return.
        let next = self.operations.len() as u32 + 1;
        let number = *self.operations.entry(operation.to_owned()).or_insert(next);
        let two = |low: u16, high: u16| u32::from(low) | u32::from(high) << 16;
        d.steps.push([number | u32::from(dst) << 16, two(on.a, on.b), two(on.c, on.group), on.place]);
    }

    /// The operand that is a number.
    fn number(&mut self, v: f64) -> Result<u16, BackendError> {
        if v.is_nan() {
            return Err(refused("a function with a constant that is no number"));
        }
        let bits = near(v).to_bits();
        let k = self.numbers.iter().position(|n| *n == bits).unwrap_or_else(|| {
            self.numbers.push(bits);
            self.numbers.len() - 1
        });
        u16::try_from(NUMBERS_FROM + k).map_err(|_| refused("functions of more than 32,768 numbers"))
    }
}

impl TextureEncoder<'_> {
    /// WGSL that runs the functions `called`, as `fn interpreted_function(function: u32, p: vec3f) -> f32`; their steps and numbers go to the words.
    pub fn interpreter(&mut self, called: &[FunctionIx]) -> Result<String, BackendError> {
        let mut entries = vec![0; 3 * self.tables.functions.len()];
        let (mut n_registers, mut depth) = (1, 1);
        for ix in called {
            let r = self.routine(Callee::Function(*ix))?;
            let fields = [r.start, u32::from(r.frame) | u32::from(r.result) << 16, self.n_params(*ix) as u32];
            entries[3 * *ix as usize..][..3].copy_from_slice(&fields);
            (n_registers, depth) = (n_registers.max(r.end), depth.max(r.depth));
        }
        if n_registers > MAX_REGISTERS {
            return Err(refused(format!("user functions of {n_registers} registers (at most {MAX_REGISTERS})")));
        }
        let program = std::mem::take(&mut self.functions.program);
        let entries_at = self.put(entries);
        let steps_at = self.put(program.steps.into_iter().flatten());
        let numbers_at = self.put(program.numbers);
        self.functions.places = [u32::from(n_registers), numbers_at];
        let mut operations: Vec<(u32, String)> = program.operations.into_iter().map(|(text, k)| (k, text)).collect();
        operations.sort_unstable();
        let mut cases = String::new();
        for (k, text) in operations {
            writeln!(cases, "            case {k}u: {{ {text} }}").expect("strings take text");
        }
        Ok(format!(
            "fn run_steps(start: u32) {{
    var returns: array<u32, {depth}>;
    var depth = 0u;
    var pc = start;
    loop {{
        let at = {steps_at}u + 4u * pc;
        let head = word(at);
        let operands = word(at + 1u);
        let more = word(at + 2u);
        let place = word(at + 3u);
        let a = operand(operands & 0xFFFFu);
        let b = operand(operands >> 16u);
        let c = operand(more & 0xFFFFu);
        let group = more >> 16u;
        let dst = head >> 16u;
        var value = 0.0;
        pc++;
        switch head & 0xFFFFu {{
            case 0u: {{
                if depth == 0u {{ return; }}
                depth--;
                pc = returns[depth];
                continue;
            }}
{cases}            default: {{ return; }}
        }}
        registers[dst] = value;
    }}
}}

fn interpreted_function(function: u32, p: vec3f) -> f32 {{
    let entry = {entries_at}u + 3u * function;
    let places = word(entry + 1u);
    let frame = places & 0xFFFFu;
    let n = word(entry + 2u);
    for (var k = 0u; k < n; k++) {{
        registers[frame + k] = select(0.0, p[min(k, 2u)], k < 3u);
    }}
    run_steps(word(entry));
    return registers[places >> 16u];
}}
"
        ))
    }

    fn step(&mut self, d: &mut Draft, operation: &str, dst: u16, on: On) {
        self.functions.program.add(d, operation, dst, on);
    }

    fn routine(&mut self, callee: Callee) -> Result<Routine, BackendError> {
        if let Some(known) = self.functions.program.routines.get(&callee) {
            return Ok(*known);
        }
        // Those that are called stand before their callers, in the program and in the registers.
        let (mut frame, mut depth) = (0, 0);
        for other in self.callees(callee) {
            let r = self.routine(other)?;
            (frame, depth) = (frame.max(r.end), depth.max(r.depth));
        }
        let mut d = Draft { end: frame, steps: Vec::new(), jumps: Vec::new() };
        let result = match callee {
            Callee::Function(ix) => self.function_steps(&mut d, ix)?,
            Callee::Pigment(ix) => self.pigment_steps(&mut d, ix)?,
        };
        let program = &mut self.functions.program;
        let start = program.steps.len() as u32;
        d.jumps.iter().for_each(|k| d.steps[*k][3] += start);
        program.steps.append(&mut d.steps);
        program.steps.push([0; 4]);
        let routine = Routine { start, frame, end: d.end, result, depth: depth + 1 };
        program.routines.insert(callee, routine);
        Ok(routine)
    }

    /// All that a routine calls.
    fn callees(&self, callee: Callee) -> Vec<Callee> {
        let t = self.tables;
        let of_pattern = |p: PatternIx| match t.patterns[p as usize].code {
            PatternCode::Function(ix) => Some(Callee::Function(ix)),
            PatternCode::Pigment(ix) => Some(Callee::Pigment(ix)),
            _ => None,
        };
        match callee {
            Callee::Function(ix) => match t.functions[ix as usize] {
                FunctionNode::Code { start, len, .. } => {
                    let calls = t.instrs[start as usize..][..len as usize].iter().filter(|i| matches!(i.op, Op::Call | Op::Sum | Op::Prod));
                    calls.map(|i| Callee::Function(t.call_sites[wide_index(i)].function)).collect()
                }
                FunctionNode::Pattern(p) => of_pattern(p).into_iter().collect(),
                FunctionNode::Pigment(p) => vec![Callee::Pigment(p)],
                FunctionNode::Internal(_) | FunctionNode::Transform(_) | FunctionNode::Spline(_) => Vec::new(),
            },
            Callee::Pigment(ix) => {
                let node = t.pigments[ix as usize];
                let pattern =
                    if matches!(node.code, PigmentCode::Colors(_) | PigmentCode::Map(_)) { of_pattern(node.pattern) } else { None };
                let entries = match node.code {
                    PigmentCode::Map(range) | PigmentCode::Average(range) => range.of(&t.pigment_entries),
                    _ => &[],
                };
                entries.iter().map(|e| Callee::Pigment(e.1)).chain(pattern).collect()
            }
        }
    }

    /// The steps of a function; gives where its results are.
    fn function_steps(&mut self, d: &mut Draft, ix: FunctionIx) -> Result<u16, BackendError> {
        if let FunctionNode::Code { .. } = self.tables.functions[ix as usize] {
            return self.code_steps(d, ix);
        }
        let params = d.take(self.n_params(ix) as u16);
        let args: Vec<u16> = (params..d.end).collect();
        match self.tables.functions[ix as usize] {
            FunctionNode::Internal(n) => {
                let result = d.take(1);
                self.internal_step(d, n, &args, result)?;
                Ok(result)
            }
            FunctionNode::Pattern(pattern) => {
                let (point, warped) = (d.take(SIX), d.take(SIX));
                self.step(d, POINT, point, On { a: args[0], b: args[1], c: args[2], ..On::default() });
                let place = self.pattern(pattern)?.at;
                self.step(d, WARP, warped, On { group: point, place, ..On::default() });
                self.pattern_steps(d, pattern, warped)
            }
            FunctionNode::Pigment(pigment) => {
                let called = self.routine(Callee::Pigment(pigment))?;
                self.step(d, POINT, called.frame, On { a: args[0], b: args[1], c: args[2], ..On::default() });
                self.step(d, CALL, 0, On { place: called.start, ..On::default() });
                Ok(called.result)
            }
            FunctionNode::Transform(t) => {
                let matrix = self.tables.function_transforms[t as usize].forward.to_cols_array();
                let place = self.put(matrix.map(|v| near(v).to_bits()));
                let result = d.take(3);
                self.step(d, TRANSFORM, result, On { a: args[0], b: args[1], c: args[2], place, ..On::default() });
                Ok(result)
            }
            FunctionNode::Code { .. } | FunctionNode::Spline(_) => Err(refused("a spline inside a function")),
        }
    }

    fn code_steps(&mut self, d: &mut Draft, ix: FunctionIx) -> Result<u16, BackendError> {
        let tables = self.tables;
        let code = self.code(ix);
        let first = d.take(code.n_held as u16);
        let mut held: Vec<u16> = (first..d.end).collect();
        for i in code.instrs {
            let (dst, own) = (usize::from(i.dst), first + i.dst);
            let args = |site: &CallSite, held: &[u16]| -> Vec<u16> {
                tables.call_args[site.args_start as usize..][..usize::from(site.n_args)].iter().map(|r| held[usize::from(*r)]).collect()
            };
            match i.op {
                Op::Const => {
                    held[dst] = self.functions.program.number(tables.constants[wide_index(i)])?;
                    continue;
                }
                Op::Internal => {
                    let site = tables.call_sites[wide_index(i)];
                    let args = args(&site, &held);
                    self.internal_step(d, site.function, &args, own)?;
                }
                Op::Call => {
                    let site = tables.call_sites[wide_index(i)];
                    let args = args(&site, &held);
                    let result = self.call_steps(d, site.function, &args)?;
                    for part in 0..self.n_results(site.function) as u16 {
                        self.step(d, MOVE, own + part, On { a: result + part, ..On::default() });
                        held[dst + usize::from(part)] = own + part;
                    }
                    continue;
                }
                Op::Sum | Op::Prod => {
                    let site = tables.call_sites[wide_index(i)];
                    let mut args = args(&site, &held);
                    let bounds: Vec<u16> = args.drain(..2).collect();
                    let (total, index) = (d.take(1), d.take(1));
                    args.push(index);
                    let (operation, start) = if i.op == Op::Sum { ("value = a + b;", 0.0) } else { ("value = a * b;", 1.0) };
                    let (start, one) = (self.functions.program.number(start)?, self.functions.program.number(1.0)?);
                    self.step(d, MOVE, total, On { a: start, ..On::default() });
                    self.step(d, MOVE, index, On { a: bounds[0], ..On::default() });
                    let test = d.steps.len();
                    self.step(d, JUMP_ABOVE, 0, On { a: index, b: bounds[1], ..On::default() });
                    let term = self.call_steps(d, site.function, &args)?;
                    self.step(d, operation, total, On { a: total, b: term, ..On::default() });
                    self.step(d, "value = a + b;", index, On { a: index, b: one, ..On::default() });
                    d.jumps.push(d.steps.len());
                    self.step(d, JUMP, 0, On { place: test as u32, ..On::default() });
                    d.land(test);
                    self.step(d, MOVE, own, On { a: total, ..On::default() });
                }
                op => {
                    let [a, b, c] = [i.a, i.b, i.c].map(|r| held.get(usize::from(r)).copied().unwrap_or(first));
                    let operation = self.operation(op, ["a", "b", "c"])?;
                    self.step(d, &format!("value = {operation};"), own, On { a, b, c, ..On::default() });
                }
            }
            held[dst] = own;
        }
        let result = held[code.result];
        if usize::from(result) < NUMBERS_FROM {
            return Ok(result);
        }
        let kept = d.take(1);
        self.step(d, MOVE, kept, On { a: result, ..On::default() });
        Ok(kept)
    }

    /// A built-in function: three arguments as operands, the others listed in the words.
    fn internal_step(&mut self, d: &mut Draft, n: u32, args: &[u16], dst: u16) -> Result<(), BackendError> {
        let text = |k: usize| match k {
            0..=2 => ["a", "b", "c"][k].to_owned(),
            _ => format!("operand(word(place + {}u))", k - 3),
        };
        let call = self.internal_call(n, &(0..args.len()).map(text).collect::<Vec<String>>())?;
        let arg = |k: usize| args.get(k).copied().unwrap_or_default();
        let place = self.put(args.iter().skip(3).map(|r| u32::from(*r)));
        self.step(d, &format!("value = {call};"), dst, On { a: arg(0), b: arg(1), c: arg(2), group: 0, place });
        Ok(())
    }

    /// Calls a function; gives where its results are, until it is called again.
    fn call_steps(&mut self, d: &mut Draft, function: FunctionIx, args: &[u16]) -> Result<u16, BackendError> {
        let called = self.routine(Callee::Function(function))?;
        let zero = self.functions.program.number(0.0)?;
        for k in 0..self.n_params(function) {
            let a = args.get(k).copied().unwrap_or(zero);
            self.step(d, MOVE, called.frame + k as u16, On { a, ..On::default() });
        }
        self.step(d, CALL, 0, On { place: called.start, ..On::default() });
        Ok(called.result)
    }

    /// The value of a pattern at the warped point in registers `point`; gives where it is.
    fn pattern_steps(&mut self, d: &mut Draft, pattern: PatternIx, point: u16) -> Result<u16, BackendError> {
        let value = d.take(1);
        let place = self.pattern(pattern)?.at;
        match self.tables.patterns[pattern as usize].code {
            PatternCode::Function(ix) => {
                let a = self.call_steps(d, ix, &[point, point + 1, point + 2])?;
                self.step(d, SHAPED, value, On { a, place, ..On::default() });
            }
            PatternCode::Pigment(ix) => {
                let group = self.pigment_call_steps(d, ix, point)?;
                self.step(d, GREY, value, On { group, place, ..On::default() });
            }
            _ => self.step(d, FREE_VALUE, value, On { group: point, place, ..On::default() }),
        }
        Ok(value)
    }

    /// Calls a pigment at the point in registers `point`; gives where its colour is.
    fn pigment_call_steps(&mut self, d: &mut Draft, pigment: PigmentIx, point: u16) -> Result<u16, BackendError> {
        let called = self.routine(Callee::Pigment(pigment))?;
        self.step(d, COPY_SIX, called.frame, On { group: point, ..On::default() });
        self.step(d, CALL, 0, On { place: called.start, ..On::default() });
        Ok(called.result)
    }

    fn pigment_steps(&mut self, d: &mut Draft, ix: PigmentIx) -> Result<u16, BackendError> {
        let (start, color) = (d.take(SIX), d.take(SIX));
        let node = self.tables.pigments[ix as usize];
        let at = self.pigment(ix)?;
        if matches!(node.code, PigmentCode::Solid(_)) {
            let place = at + super::texture_layout::PIGMENT.len();
            self.step(d, SOLID, color, On { place, ..On::default() });
            return Ok(color);
        }
        let (point, zero) = (d.take(SIX), self.functions.program.number(0.0)?);
        if node.uv_mapping {
            self.step(d, POINT, start, On { a: zero, b: zero, c: zero, ..On::default() });
        }
        let place = self.pattern(node.pattern)?.at;
        self.step(d, WARP, point, On { group: start, place, ..On::default() });
        match node.code {
            PigmentCode::Solid(_) => {}
            PigmentCode::Image(_) => self.step(d, PLAIN, color, On { a: zero, group: point, place: at, ..On::default() }),
            PigmentCode::Colors(_) => {
                let a = self.pattern_steps(d, node.pattern, point)?;
                self.step(d, PLAIN, color, On { a, group: point, place: at, ..On::default() });
            }
            PigmentCode::Map(range) | PigmentCode::Average(range) => {
                let is_map = matches!(node.code, PigmentCode::Map(_));
                let wanted = d.take(3);
                if is_map {
                    let a = self.pattern_steps(d, node.pattern, point)?;
                    self.step(d, WANTED, wanted, On { a, place: at, ..On::default() });
                }
                self.step(d, CLEAR, color, On::default());
                let entries: Vec<PigmentIx> = range.of(&self.tables.pigment_entries).iter().map(|e| e.1).collect();
                for (k, entry) in entries.into_iter().enumerate() {
                    let on = On { a: wanted, b: wanted + 1, c: self.functions.program.number(k as f64)?, place: at, group: 0 };
                    let jump = d.steps.len();
                    if is_map {
                        self.step(d, JUMP_OUTSIDE, 0, on);
                    }
                    let group = self.pigment_call_steps(d, entry, point)?;
                    self.step(d, if is_map { ADD_OF_MAP } else { ADD_OF_AVERAGE }, color, On { group, ..on });
                    if is_map {
                        d.land(jump);
                    }
                }
            }
        }
        Ok(color)
    }
}
