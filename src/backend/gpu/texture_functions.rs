//! User functions as WGSL: the bytecode of `compile/function.rs`, one function each, in the generated module `package::functions`.
//! What a function may call is emitted before it; what the GPU does not know is refused by name.

use super::texture_encoder::TextureEncoder;
use crate::backend::BackendError;
use crate::compile::function::{CallSite, FunctionNode, INTERNAL_NOISE3D, Instr, Op, wide_index};
use crate::compile::texture::{FunctionIx, PigmentIx};
use std::collections::BTreeSet;
use std::fmt::Write;

/// Built-in functions of `shaders/shared/function_internal.wesl`: number, name, parameters after the point.
const INTERNALS: &[(u32, &str, usize)] = &[
    (17, "internal_ellipsoid", 3),
    (23, "internal_heart", 1),
    (25, "internal_helix1", 7),
    (29, "internal_hetero_mf", 6),
    (45, "internal_paraboloid", 1),
    (47, "internal_ph", 0),
    (57, "internal_r", 0),
    (58, "internal_ridge", 6),
    (59, "internal_ridged_mf", 6),
    (60, "internal_rounded_box", 4),
    (61, "internal_sphere", 1),
    (63, "internal_spikes_2d", 4),
    (68, "internal_superellipsoid", 2),
    (69, "internal_th", 0),
    (70, "internal_torus", 2),
    (78, "internal_noise", 1),
];

/// The imports of the generated module; what is not used is left out again.
const IMPORTS: &str = "\
import package::shared::angles::{arc_tangent2, sine};
import package::shared::function_internal::{internal_ellipsoid, internal_heart, internal_helix1, internal_hetero_mf, internal_noise,
    internal_paraboloid, internal_ph, internal_r, internal_ridge, internal_ridged_mf, internal_rounded_box, internal_sphere,
    internal_spikes_2d, internal_superellipsoid, internal_th, internal_torus};
import package::shared::function_math::{function_acos, function_asin, function_atan, function_cos, function_div, function_max,
    function_min, function_pow, function_tan, function_truth};
import package::constants;
import package::shared::map_colors::{PigmentColor, color_of_words, plain_color};
import package::shared::noise::noise;
import package::shared::pattern::shaped;
import package::shared::pattern_function::{entries_of_average, entries_of_map, free_value, grey_of, numbers_of, sum_with};
import package::shared::pattern_simple::above_one;
import package::shared::real::real3;
import package::shared::texture_point::Rgbft;
import package::shared::warp::warp_point;
";

/// Functions written so far.
#[derive(Default)]
pub(super) struct FunctionText {
    text: String,
    known: BTreeSet<FunctionIx>,
    known_pigments: BTreeSet<PigmentIx>,
    /// Those that shaders call with a point.
    called: BTreeSet<FunctionIx>,
}

impl FunctionText {
    /// Notes that a pigment is written; false when it was before.
    pub fn know_pigment(&mut self, ix: PigmentIx) -> bool {
        self.known_pigments.insert(ix)
    }

    /// Appends a function that is whole.
    pub fn add(&mut self, text: &str) {
        self.text += text;
    }

    /// The module; empty without functions.
    pub fn module(&self, n_params: impl Fn(FunctionIx) -> usize) -> String {
        if self.called.is_empty() {
            return String::new();
        }
        let mut text =
            format!("{IMPORTS}\n{}\nfn call_user_function(function: u32, p: vec3f) -> f32 {{\n    switch function {{\n", self.text);
        for ix in &self.called {
            let args = ["p.x", "p.y", "p.z", "0.0"].map(str::to_owned);
            let args: Vec<&str> = (0..n_params(*ix)).map(|k| args[k.min(3)].as_str()).collect();
            writeln!(text, "        case {ix}u: {{ return user_function_{ix}({})[0]; }}", args.join(", ")).expect("strings take text");
        }
        text + "        default: { return 0.0; }\n    }\n}\n"
    }
}

/// Every function gives five numbers, of which the first ones count.
fn one_result(value: &str) -> String {
    format!("array<f32, 5>({value}, 0.0, 0.0, 0.0, 0.0)")
}

fn refused(what: impl Into<String>) -> BackendError {
    BackendError::Unsupported(what.into())
}

fn literal(v: f64) -> String {
    format!("({:?})", (v as f32).clamp(f32::MIN, f32::MAX))
}

impl TextureEncoder<'_> {
    /// Parameters of a function as it is written.
    pub fn n_params(&self, ix: FunctionIx) -> usize {
        match self.tables.functions[ix as usize] {
            FunctionNode::Code { n_params, .. } => usize::from(n_params),
            FunctionNode::Internal(n) => 3 + INTERNALS.iter().find(|i| i.0 == n).map_or(0, |i| i.2),
            FunctionNode::Spline(_) => 1,
            _ => 3,
        }
    }

    /// Makes a function callable by its number.
    pub fn function(&mut self, ix: FunctionIx) -> Result<u32, BackendError> {
        self.feature("user_functions");
        self.write_function(ix)?;
        self.functions.called.insert(ix);
        Ok(ix)
    }

    fn write_function(&mut self, ix: FunctionIx) -> Result<(), BackendError> {
        if self.functions.known.contains(&ix) {
            return Ok(());
        }
        let params: Vec<String> = (0..self.n_params(ix)).map(|k| format!("a{k}: f32")).collect();
        let body = match self.tables.functions[ix as usize] {
            FunctionNode::Code { start, len, n_regs, result, n_params } => {
                let code = &self.tables.instrs[start as usize..][..len as usize];
                self.code_text(code, n_regs, result, n_params)?
            }
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
        self.functions.known.insert(ix);
        Ok(())
    }

    fn internal_call(&mut self, n: u32, args: &[String]) -> Result<String, BackendError> {
        let arg = |k: usize| args.get(k).map_or("0.0", |a| a.as_str());
        let point = format!("vec3f({}, {}, {})", arg(0), arg(1), arg(2));
        if n == INTERNAL_NOISE3D {
            return Ok(self.noise_call(&point));
        }
        let (_, name, n_params) = INTERNALS.iter().find(|i| i.0 == n).ok_or_else(|| refused(format!("the built-in function {n}")))?;
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

    fn code_text(&mut self, code: &[Instr], n_regs: u32, result: u16, n_params: u16) -> Result<String, BackendError> {
        let mut text = String::new();
        let mut line = |l: String| {
            text += "    ";
            text += &l;
            text += "\n";
        };
        let calls = code.iter().filter(|i| matches!(i.op, Op::Call)).map(|i| u32::from(i.dst) + 5).max().unwrap_or(0);
        for k in 0..n_regs.max(calls).max(u32::from(result) + 1) {
            line(if k < u32::from(n_params) { format!("var r{k} = a{k};") } else { format!("var r{k} = 0.0;") });
        }
        for i in code {
            let (a, b, c) = (format!("r{}", i.a), format!("r{}", i.b), format!("r{}", i.c));
            let value = match i.op {
                Op::Const => {
                    let v = self.tables.constants[wide_index(i)];
                    if v.is_nan() {
                        return Err(refused("a function with a constant that is no number"));
                    }
                    literal(v)
                }
                Op::Noise => self.noise_call(&format!("vec3f({a}, {b}, {c})")),
                Op::Internal => {
                    let site = self.tables.call_sites[wide_index(i)];
                    let args = self.site_args(&site);
                    self.internal_call(site.function, &args)?
                }
                Op::Call => {
                    let site = self.tables.call_sites[wide_index(i)];
                    let call = self.user_call(site.function, self.site_args(&site))?;
                    let n = self.n_results(site.function);
                    let parts: String = (0..n).map(|k| format!(" r{} = found[{k}];", usize::from(i.dst) + k)).collect();
                    line(format!("{{ let found = {call};{parts} }}"));
                    continue;
                }
                Op::Sum | Op::Prod => {
                    let site = self.tables.call_sites[wide_index(i)];
                    let mut args = self.site_args(&site);
                    let bounds: Vec<String> = args.drain(..2).collect();
                    args.push("index".to_owned());
                    let call = self.user_call(site.function, args)?;
                    let (sign, start) = if i.op == Op::Sum { ("+", "0.0") } else { ("*", "1.0") };
                    line(format!(
                        "{{ var total = {start}; var index = {}; while index <= {} {{ total = total {sign} {call}[0]; index += 1.0; }} r{} = total; }}",
                        bounds[0], bounds[1], i.dst
                    ));
                    continue;
                }
                op => plain_operation(op, &a, &b, &c)?,
            };
            line(format!("r{} = {value};", i.dst));
        }
        line(format!("return {};", one_result(&format!("r{result}"))));
        Ok(text)
    }

    fn site_args(&self, site: &CallSite) -> Vec<String> {
        self.tables.call_args[site.args_start as usize..][..usize::from(site.n_args)].iter().map(|r| format!("r{r}")).collect()
    }

    pub fn user_call(&mut self, function: FunctionIx, mut args: Vec<String>) -> Result<String, BackendError> {
        self.write_function(function)?;
        args.resize(self.n_params(function), "0.0".to_owned());
        Ok(format!("user_function_{function}({})", args.join(", ")))
    }

    fn n_results(&self, function: FunctionIx) -> usize {
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
