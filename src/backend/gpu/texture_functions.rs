//! User functions as WGSL: the bytecode of `compile/function.rs`, one function each, in the generated module `package::functions`.
//! What a function may call is emitted before it; what the GPU does not know is refused by name. What would be too much for a driver is interpreted
//! (`function_program.rs`).

use super::device::Gpu;
use super::function_builtins::{builtin, imports};
use super::function_program::FunctionProgram;
use super::texture_encoder::TextureEncoder;
use crate::backend::BackendError;
use crate::compile::function::{CallSite, FunctionNode, INTERNAL_NOISE3D, Instr, Op, wide_index};
use crate::compile::texture::{FunctionIx, PigmentIx};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

/// The imports of the generated module; what is not used is left out again.
const IMPORTS: &str = "\
import package::shared::angles::{arc_tangent2, sine};
import package::shared::function_math::{function_acos, function_asin, function_atan, function_cos, function_div, function_max,
    function_min, function_pow, function_tan, function_truth};
import package::constants;
import package::shared::function_registers::{copy_six, held_color, held_point, held_vector, keep_color, keep_point, keep_vector, operand, registers};
import package::shared::map_colors::{PigmentColor, color_of_words, plain_color};
import package::shared::noise::noise;
import package::shared::pattern::shaped;
import package::shared::pattern_function::{WantedEntries, entries_of_average, entries_of_map, free_value, grey_of, numbers_of, sum_with};
import package::shared::pattern_simple::above_one;
import package::shared::real::real3;
import package::shared::texture_point::Rgbft;
import package::shared::warp::warp_point;
import package::shared::words::{matrix, number, vector, word};
";

/// Most that user functions may weigh (`weight_of`) that are written out, which runs faster than a program and compiles longer; the environment may say another number.
/// Measured by benches/function_compile.sh on lavapipe, CPU seconds of a picture's compiling, interpreted and written out: 4 functions of one call 3.4 and 5.1, 8 of them 3.8
/// and 8.8, 16 of them 3.7 and over 16; a program's do not grow.
const MOST_WRITTEN: usize = 64;
const MOST_WRITTEN_SOFTWARE: usize = 24;
const MOST_WRITTEN_NAME: &str = "RAYLOOM_GPU_FUNCTIONS";

/// What the functions may weigh that are written out for a device.
pub(super) fn most_written(gpu: &Gpu) -> Result<usize, BackendError> {
    let is_software = gpu.info.device_type == wgpu::DeviceType::Cpu;
    match std::env::var(MOST_WRITTEN_NAME) {
        Err(_) => Ok(if is_software { MOST_WRITTEN_SOFTWARE } else { MOST_WRITTEN }),
        Ok(text) => text.parse().map_err(|_| BackendError::NoDevice(format!("{MOST_WRITTEN_NAME} is a number, not '{text}'"))),
    }
}

/// Functions written so far.
#[derive(Default)]
pub(super) struct FunctionText {
    written: Written,
    /// Those that are interpreted.
    pub program: FunctionProgram,
    /// Registers of the interpreter, and the place of its numbers.
    pub places: [u32; 2],
    pub interpreted: BTreeSet<FunctionIx>,
    /// Those that shaders call with a point.
    called: Vec<FunctionIx>,
}

/// What stands in the text.
#[derive(Clone, Default)]
struct Written {
    text: String,
    known: BTreeSet<FunctionIx>,
    known_pigments: BTreeSet<PigmentIx>,
}

impl FunctionText {
    /// Notes that a pigment is written; false when it was before.
    pub fn know_pigment(&mut self, ix: PigmentIx) -> bool {
        self.written.known_pigments.insert(ix)
    }

    /// Appends a function that is whole.
    pub fn add(&mut self, text: &str) {
        self.written.text += text;
    }
}

/// What drivers have to write out for a module of functions, in calls of noise: they put a function in wherever it is called. A pattern brings all kinds of
/// patterns with it.
fn weight_of(module: &str) -> usize {
    let n = |name: &str| module.matches(name).count();
    let sums = n("internal_hetero_mf(") + n("internal_ridge(") + n("internal_ridged_mf(");
    n("noise(") + 2 * sums + n("warp_point(") + 4 * n("free_value(") + n("\n") / 32
}

/// Functions that differ in numbers alone: written once, each finds its numbers in a table.
struct Alike {
    members: Vec<FunctionIx>,
    /// Of each, in the order of their uses.
    constants: Vec<Vec<f64>>,
}

/// The code of a function.
pub(super) struct Code<'t> {
    pub instrs: &'t [Instr],
    /// Registers that it names.
    pub n_held: usize,
    pub result: usize,
    n_params: usize,
}

/// What a register of a function holds where it is read.
enum Held {
    Name(String),
    Number(f64),
}

impl Held {
    fn text(&self, constant: &mut dyn FnMut(f64) -> String) -> String {
        match self {
            Self::Name(name) => name.clone(),
            Self::Number(v) => constant(*v),
        }
    }
}

/// Every function gives five numbers, of which the first ones count.
fn one_result(value: &str) -> String {
    format!("array<f32, 5>({value}, 0.0, 0.0, 0.0, 0.0)")
}

pub(super) fn refused(what: impl Into<String>) -> BackendError {
    BackendError::Unsupported(what.into())
}

pub(super) fn near(v: f64) -> f32 {
    (v as f32).clamp(f32::MIN, f32::MAX)
}

fn literal(v: f64) -> String {
    format!("({:?})", near(v))
}

impl<'t> TextureEncoder<'t> {
    /// Parameters of a function as it is written.
    pub fn n_params(&self, ix: FunctionIx) -> usize {
        match self.tables.functions[ix as usize] {
            FunctionNode::Code { n_params, .. } => usize::from(n_params),
            FunctionNode::Internal(n) => 3 + builtin(n).map_or(0, |b| b.2),
            FunctionNode::Spline(_) => 1,
            _ => 3,
        }
    }

    /// Makes a function callable by its number.
    pub fn function(&mut self, ix: FunctionIx) -> u32 {
        self.feature("user_functions");
        if !self.functions.called.contains(&ix) {
            self.functions.called.push(ix);
        }
        ix
    }

    /// The module of all functions that shaders call, after the last of them is known; empty without any. Loops in scenes declare functions by
    /// the hundred that differ in numbers at most, and drivers write out each that a `switch` names: such ones are one. Those that weigh more than `most`
    /// (`weight_of`) with those before them are interpreted, all of them where it is 0; the first to be asked for are the first to be written out.
    pub fn function_module(&mut self, most: usize) -> Result<String, BackendError> {
        if self.functions.called.is_empty() {
            return Ok(String::new());
        }
        let mut alike: BTreeMap<String, Alike> = BTreeMap::new();
        for ix in self.functions.called.clone() {
            let (text, constants) = self.outline(ix)?;
            let group = alike.entry(text).or_insert_with(|| Alike { members: Vec::new(), constants: Vec::new() });
            group.members.push(ix);
            group.constants.push(constants);
        }
        // Outlines wrote what they call; whether that stays is still to be decided.
        self.functions.written = Written::default();
        let mut groups: Vec<Alike> = alike.into_values().collect();
        groups.sort_by_key(|g| self.functions.called.iter().position(|ix| *ix == g.members[0]));
        let has_table = groups.iter().any(|g| g.members.len() > 1);
        // By function: whom to call in its place, and where its numbers are.
        let mut table: Vec<u32> =
            if has_table { (0..self.tables.functions.len() as u32).flat_map(|k| [k, 0]).collect() } else { Vec::new() };
        let (mut cases, mut interpreted) = (String::new(), Vec::new());
        for group in &groups {
            let first = group.members[0];
            let before = self.functions.written.clone();
            let places = self.write_alike(group)?;
            if most == 0 || weight_of(&self.functions.written.text) > most {
                self.functions.written = before;
                interpreted.extend(&group.members);
                continue;
            }
            for (ix, at) in group.members.iter().zip(&places) {
                if has_table {
                    (table[2 * *ix as usize], table[2 * *ix as usize + 1]) = (first, *at);
                }
            }
            let args = ["p.x", "p.y", "p.z", "0.0"].map(str::to_owned);
            let mut args: Vec<&str> = (0..self.n_params(first)).map(|k| args[k.min(3)].as_str()).collect();
            let is_shared = group.members.len() > 1;
            args.extend(is_shared.then_some("numbers_at"));
            let name = if is_shared { "alike" } else { "user" };
            writeln!(cases, "        case {first}u: {{ return {name}_function_{first}({})[0]; }}", args.join(", "))
                .expect("strings take text");
        }
        let called = if has_table {
            let at = self.put(table);
            format!("    let entry = {at}u + 2u * function;\n    let numbers_at = word(entry + 1u);\n    switch word(entry) {{\n")
        } else {
            "    switch function {\n".to_owned()
        };
        let (interpreter, other) = match interpreted.is_empty() {
            true => (String::new(), "0.0"),
            false => (self.interpreter(&interpreted)?, "interpreted_function(function, p)"),
        };
        self.functions.interpreted.extend(interpreted);
        let text = &self.functions.written.text;
        let imports = imports(&format!("{text}{interpreter}"));
        Ok(format!(
            "{IMPORTS}{imports}\n{text}\n{interpreter}\nfn call_user_function(function: u32, p: vec3f) -> f32 {{\n{called}{cases}        default: {{ return {other}; }}\n    }}\n}}\n"
        ))
    }

    /// The text of a function with its numbers left out, and the numbers.
    fn outline(&mut self, ix: FunctionIx) -> Result<(String, Vec<f64>), BackendError> {
        let FunctionNode::Code { .. } = self.tables.functions[ix as usize] else { return Ok((format!("{ix}"), Vec::new())) };
        let mut numbers = Vec::new();
        let mut leave_out = |v: f64| {
            numbers.push(v);
            "?".to_owned()
        };
        Ok((self.code_text(ix, &mut leave_out)?, numbers))
    }

    /// Writes functions that differ in numbers alone; gives the place of each one's numbers.
    fn write_alike(&mut self, group: &Alike) -> Result<Vec<u32>, BackendError> {
        let [first, _, ..] = group.members[..] else {
            self.write_function(group.members[0])?;
            return Ok(vec![0]);
        };
        let differs = |k: &usize| group.constants.iter().any(|c| c[*k].to_bits() != group.constants[0][*k].to_bits());
        let varying: Vec<usize> = (0..group.constants[0].len()).filter(differs).collect();
        let mut n_used = 0;
        let mut constant = |v: f64| {
            n_used += 1;
            match varying.iter().position(|k| *k == n_used - 1) {
                Some(n) => format!("number(numbers_at + {n}u)"),
                None => literal(v),
            }
        };
        let body = self.code_text(first, &mut constant)?;
        // Another function may call it with its own numbers.
        let params: String = (0..self.n_params(first)).map(|k| format!("a{k}: f32, ")).collect();
        self.functions.add(&format!("fn alike_function_{first}({params}numbers_at: u32) -> array<f32, 5> {{\n{body}}}\n\n"));
        Ok(group.constants.iter().map(|c| self.put(varying.iter().map(|k| near(c[*k]).to_bits()))).collect())
    }

    fn write_function(&mut self, ix: FunctionIx) -> Result<(), BackendError> {
        if self.functions.written.known.contains(&ix) {
            return Ok(());
        }
        let params: Vec<String> = (0..self.n_params(ix)).map(|k| format!("a{k}: f32")).collect();
        let body = match self.tables.functions[ix as usize] {
            FunctionNode::Code { .. } => self.code_text(ix, &mut literal)?,
            FunctionNode::Internal(n) => {
                let args: Vec<String> = (0..params.len()).map(|k| format!("a{k}")).collect();
                format!("    return {};\n", one_result(&self.internal_call(n, &args)?))
            }
            FunctionNode::Pattern(pattern) => self.pattern_function(pattern)?,
            FunctionNode::Pigment(pigment) => self.pigment_function(pigment)?,
            FunctionNode::Transform(t) => {
                let m = self.tables.function_transforms[t as usize].forward.to_cols_array().map(literal);
                format!(
                    "    let p = mat3x3f({}) * vec3f(a0, a1, a2) + vec3f({});\n    return array<f32, 5>(p.x, p.y, p.z, 0.0, 0.0);\n",
                    m[..9].join(", "),
                    m[9..].join(", ")
                )
            }
            FunctionNode::Spline(_) => return Err(refused("a spline inside a function")),
        };
        let text = format!("fn user_function_{ix}({}) -> array<f32, 5> {{\n{body}}}\n\n", params.join(", "));
        self.functions.add(&text);
        self.functions.written.known.insert(ix);
        Ok(())
    }

    pub fn internal_call(&mut self, n: u32, args: &[String]) -> Result<String, BackendError> {
        let arg = |k: usize| args.get(k).map_or("0.0", |a| a.as_str());
        let point = format!("vec3f({}, {}, {})", arg(0), arg(1), arg(2));
        if n == INTERNAL_NOISE3D {
            return Ok(self.noise_call(&point));
        }
        let (_, name, n_params) = builtin(n).ok_or_else(|| refused(format!("the built-in function {n}")))?;
        // Their generator may be any.
        if name.contains("noise") || name.contains("ridge") || name.contains("hetero") {
            self.feature("noise_generator_3");
        }
        let rest: String = (0..*n_params).map(|k| format!(", {}", arg(3 + k))).collect();
        Ok(format!("{name}({point}{rest})"))
    }

    fn noise_call(&mut self, point: &str) -> String {
        let generator = self.tables.noise_generator.clamp(1, 3);
        if generator == 3 {
            self.feature("noise_generator_3");
        }
        format!("noise({point}, {generator}u)")
    }

    /// The body of a function that is code. `constant` writes the numbers that it uses, in the order of their uses.
    fn code_text(&mut self, ix: FunctionIx, constant: &mut dyn FnMut(f64) -> String) -> Result<String, BackendError> {
        let tables = self.tables;
        let code = self.code(ix);
        // What each register holds now: the name of a value, or a number. Numbers are written where they are used, so that functions of one shape are one
        // text, whichever of their numbers are equal (a product that occurs twice is another shape: it is worked out once).
        let mut held: Vec<Held> = (0..code.n_held).map(|_| Held::Number(0.0)).collect();
        (0..code.n_params).for_each(|k| held[k] = Held::Name(format!("a{k}")));
        let mut text = String::new();
        // Values are counted without the numbers between them.
        let mut k = 0;
        for i in code.instrs {
            let dst = usize::from(i.dst);
            k += usize::from(i.op != Op::Const);
            let mut args = |site: &CallSite| -> Vec<String> {
                let list = &tables.call_args[site.args_start as usize..][..usize::from(site.n_args)];
                list.iter().map(|r| held[usize::from(*r)].text(constant)).collect()
            };
            let value = match i.op {
                Op::Const => {
                    let v = tables.constants[wide_index(i)];
                    if v.is_nan() {
                        return Err(refused("a function with a constant that is no number"));
                    }
                    held[dst] = Held::Number(v);
                    continue;
                }
                Op::Internal => {
                    let site = tables.call_sites[wide_index(i)];
                    self.internal_call(site.function, &args(&site))?
                }
                Op::Call => {
                    let site = tables.call_sites[wide_index(i)];
                    let call = self.user_call(site.function, args(&site))?;
                    writeln!(text, "    let v{k} = {call};").expect("strings take text");
                    (0..self.n_results(site.function)).for_each(|part| held[dst + part] = Held::Name(format!("v{k}[{part}]")));
                    continue;
                }
                Op::Sum | Op::Prod => {
                    let site = tables.call_sites[wide_index(i)];
                    let mut args = args(&site);
                    let bounds: Vec<String> = args.drain(..2).collect();
                    args.push("index".to_owned());
                    let call = self.user_call(site.function, args)?;
                    let (sign, start) = if i.op == Op::Sum { ("+", "0.0") } else { ("*", "1.0") };
                    writeln!(
                        text,
                        "    var v{k} = {start};\n    {{ var index = {}; while index <= {} {{ v{k} = v{k} {sign} {call}[0]; index += 1.0; }} }}",
                        bounds[0], bounds[1]
                    )
                    .expect("strings take text");
                    held[dst] = Held::Name(format!("v{k}"));
                    continue;
                }
                op => {
                    let [a, b, c] = [i.a, i.b, i.c].map(|r| held[usize::from(r)].text(constant));
                    self.operation(op, [&a, &b, &c])?
                }
            };
            writeln!(text, "    let v{k} = {value};").expect("strings take text");
            held[dst] = Held::Name(format!("v{k}"));
        }
        writeln!(text, "    return {};", one_result(&held[code.result].text(constant))).expect("strings take text");
        Ok(text)
    }

    /// The code of a function that is code.
    pub fn code(&self, ix: FunctionIx) -> Code<'t> {
        let FunctionNode::Code { start, len, n_regs, result, n_params } = self.tables.functions[ix as usize] else {
            unreachable!("the caller asked for the kind")
        };
        let instrs = &self.tables.instrs[start as usize..][..len as usize];
        // Calls may give up to five results.
        let calls = instrs.iter().filter(|i| matches!(i.op, Op::Call)).map(|i| usize::from(i.dst) + 5).max().unwrap_or(0);
        let n_held = (n_regs as usize).max(calls).max(usize::from(result) + 1);
        Code { instrs, n_held, result: usize::from(result), n_params: usize::from(n_params) }
    }

    /// WGSL of an operation on numbers.
    pub fn operation(&mut self, op: Op, [a, b, c]: [&str; 3]) -> Result<String, BackendError> {
        if op == Op::Noise { Ok(self.noise_call(&format!("vec3f({a}, {b}, {c})"))) } else { plain_operation(op, a, b, c) }
    }

    pub fn user_call(&mut self, function: FunctionIx, mut args: Vec<String>) -> Result<String, BackendError> {
        self.write_function(function)?;
        args.resize(self.n_params(function), "0.0".to_owned());
        Ok(format!("user_function_{function}({})", args.join(", ")))
    }

    pub fn n_results(&self, function: FunctionIx) -> usize {
        match self.tables.functions[function as usize] {
            FunctionNode::Pigment(_) => 5,
            FunctionNode::Transform(_) => 3,
            _ => 1,
        }
    }
}

fn plain_operation(op: Op, a: &str, b: &str, c: &str) -> Result<String, BackendError> {
    let truth = |condition: String| format!("function_truth({condition})");
    Ok(match op {
        Op::Neg => format!("-{a}"),
        Op::Add => format!("{a} + {b}"),
        Op::Sub => format!("{a} - {b}"),
        Op::Mul => format!("{a} * {b}"),
        Op::Div => format!("{a} / {b}"),
        Op::Eq => truth(format!("{a} == {b}")),
        Op::Ne => truth(format!("{a} != {b}")),
        Op::Lt => truth(format!("{a} < {b}")),
        Op::Le => truth(format!("{a} <= {b}")),
        Op::Gt => truth(format!("{a} > {b}")),
        Op::Ge => truth(format!("{a} >= {b}")),
        Op::And => truth(format!("{a} != 0.0 && {b} != 0.0")),
        Op::Or => truth(format!("{a} != 0.0 || {b} != 0.0")),
        Op::Abs => format!("abs({a})"),
        Op::Acos => format!("function_acos({a})"),
        Op::Acosh => format!("acosh({a})"),
        Op::Asin => format!("function_asin({a})"),
        Op::Asinh => format!("asinh({a})"),
        Op::Atan => format!("function_atan({a})"),
        Op::Atan2 => format!("arc_tangent2({a}, {b})"),
        Op::Atanh => format!("atanh({a})"),
        Op::Ceil => format!("ceil({a})"),
        Op::Cos => format!("function_cos({a})"),
        Op::Cosh => format!("cosh({a})"),
        Op::Degrees => format!("degrees({a})"),
        Op::DivInt => format!("function_div({a}, {b})"),
        Op::Exp => format!("exp({a})"),
        Op::Floor => format!("floor({a})"),
        Op::Int => format!("trunc({a})"),
        Op::Ln => format!("log({a})"),
        Op::Log => format!("log2({a}) * {}", literal(std::f64::consts::LOG10_2)),
        Op::Max => format!("function_max({a}, {b})"),
        Op::Min => format!("function_min({a}, {b})"),
        Op::Mod => format!("{a} % {b}"),
        Op::Pow => format!("function_pow({a}, {b})"),
        Op::Radians => format!("radians({a})"),
        Op::Sin => format!("sine({a})"),
        Op::Sinh => format!("sinh({a})"),
        Op::Sqrt => format!("sqrt({a})"),
        Op::Tan => format!("function_tan({a})"),
        Op::Tanh => format!("tanh({a})"),
        Op::SelectNegative => format!("select({c}, {b}, {a} < 0.0)"),
        Op::SelectZero => format!("select({c}, {b}, {a} == 0.0)"),
        Op::Const | Op::Noise | Op::Internal | Op::Call | Op::Sum | Op::Prod => return Err(refused("an operation of a function")),
    })
}

#[cfg(test)]
mod tests {
    use super::weight_of;

    #[test]
    fn what_a_driver_writes_out_weighs_in_calls_of_noise() {
        assert_eq!(weight_of("let v = noise(p, 2u);\nlet w = internal_ridge(p);\nlet q = free_value(7u, p);\n"), 7);
    }
}
