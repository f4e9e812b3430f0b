//! Runs user functions: the register machine for `compile/function.rs`'s code, and everything that a function may call.
//! Nothing allocates unless a function needs more than 1024 registers. Source: spec/objects.md, section 16.

pub mod internal;

use super::PatternPoint;
use super::pattern::eval_pattern;
use super::pigment::eval_pigment;
use super::spline::eval_spline_node;
use crate::compile::CompiledScene;
use crate::compile::function::{FunctionNode, INTERNAL_NOISE3D, Instr, Op, eval_op, wide_index};
use crate::math::noise::noise;
use crate::math::{DVec2, DVec3, Rgbft};

/// Most arguments of a call; the language allows 56.
const MAX_ARGS: usize = 64;
/// Most runs of one sum or product; beyond it the value is NaN.
const MAX_TERMS: u64 = 100_000_000;

/// First (or only) result of a function; missing arguments are 0. Faults give infinities and NaN.
#[inline]
pub fn call_function(scene: &CompiledScene, function: u32, args: &[f64]) -> f64 {
    match scene.textures.functions[function as usize] {
        FunctionNode::Code { start, len, n_regs, result, n_params } => {
            let code = &scene.textures.instrs[start as usize..][..len as usize];
            let args = &args[..args.len().min(usize::from(n_params))];
            match n_regs {
                0..=32 => run::<32>(scene, code, args, result),
                33..=128 => run::<128>(scene, code, args, result),
                129..=1024 => run::<1024>(scene, code, args, result),
                _ => run_large(scene, code, args, n_regs, result),
            }
        }
        FunctionNode::Internal(n) => call_internal(scene, n, args),
        _ => call_function_all(scene, function, args).0[0],
    }
}

/// All results of a function and their number: 1, 3 (transforms), 5 (pigments), 2..=5 (splines).
pub fn call_function_all(scene: &CompiledScene, function: u32, args: &[f64]) -> ([f64; 5], usize) {
    let arg = |k: usize| args.get(k).copied().unwrap_or(0.0);
    let point = || DVec3::new(arg(0), arg(1), arg(2));
    let mut out = [0.0; 5];
    let n = match scene.textures.functions[function as usize] {
        FunctionNode::Code { .. } | FunctionNode::Internal(_) => {
            out[0] = call_function(scene, function, args);
            1
        }
        FunctionNode::Pigment(ix) => {
            let c = eval_pigment(scene, ix, &free_point(point())).unwrap_or(Rgbft::CLEAR);
            out = c.to_array().map(f64::from);
            5
        }
        FunctionNode::Pattern(ix) => {
            out[0] = eval_pattern(scene, ix, &free_point(point()));
            1
        }
        FunctionNode::Transform(ix) => {
            out[..3].copy_from_slice(&scene.textures.function_transforms[ix as usize].point(point()).to_array());
            3
        }
        FunctionNode::Spline(ix) => {
            let s = &scene.textures.splines[ix as usize];
            out = eval_spline_node(&scene.textures, s, arg(0));
            usize::from(s.n_components)
        }
    };
    (out, n)
}

/// A point with no surface around it.
pub fn free_point(p: DVec3) -> PatternPoint {
    PatternPoint { point: p, uv: DVec2::ZERO, world: p, normal: DVec3::ZERO, ray_dir: DVec3::ZERO }
}

fn call_internal(scene: &CompiledScene, n: u32, args: &[f64]) -> f64 {
    let arg = |k: usize| args.get(k).copied().unwrap_or(0.0);
    let p = DVec3::new(arg(0), arg(1), arg(2));
    if n == INTERNAL_NOISE3D {
        return noise(p, scene.textures.noise_generator);
    }
    internal::eval_internal(n, p, args.get(3..).unwrap_or(&[]))
}

/// Registers as an array whose size is a power of two: masked indices need no check.
fn run<const N: usize>(scene: &CompiledScene, code: &[Instr], args: &[f64], result: u16) -> f64 {
    let mut regs = [0.0f64; N];
    let n = args.len().min(N);
    regs[..n].copy_from_slice(&args[..n]);
    for i in code {
        let at = |r: u16| usize::from(r) & (N - 1);
        let (a, b, c) = (regs[at(i.a)], regs[at(i.b)], regs[at(i.c)]);
        let value = match i.op {
            Op::Const => scene.textures.constants[wide_index(i)],
            Op::Add => a + b,
            Op::Sub => a - b,
            Op::Mul => a * b,
            Op::Noise => noise(DVec3::new(a, b, c), scene.textures.noise_generator),
            Op::Internal | Op::Call | Op::Sum | Op::Prod => {
                let (out, n) = call(scene, i, &regs);
                for k in 1..n {
                    regs[at(i.dst + k as u16)] = out[k];
                }
                out[0]
            }
            op => eval_op(op, a, b, c),
        };
        regs[at(i.dst)] = value;
    }
    regs[usize::from(result) & (N - 1)]
}

/// The same for functions of uncommon size.
fn run_large(scene: &CompiledScene, code: &[Instr], args: &[f64], n_regs: u32, result: u16) -> f64 {
    let mut regs = vec![0.0f64; (n_regs as usize + 5).max(args.len())];
    regs[..args.len()].copy_from_slice(args);
    for i in code {
        let at = |r: u16| regs.get(usize::from(r)).copied().unwrap_or(0.0);
        let (a, b, c) = (at(i.a), at(i.b), at(i.c));
        let value = match i.op {
            Op::Const => scene.textures.constants[wide_index(i)],
            Op::Noise => noise(DVec3::new(a, b, c), scene.textures.noise_generator),
            Op::Internal | Op::Call | Op::Sum | Op::Prod => {
                let (out, n) = call(scene, i, &regs);
                regs[usize::from(i.dst)..][..n].copy_from_slice(&out[..n]);
                out[0]
            }
            op => eval_op(op, a, b, c),
        };
        regs[usize::from(i.dst)] = value;
    }
    regs[usize::from(result)]
}

fn call(scene: &CompiledScene, i: &Instr, regs: &[f64]) -> ([f64; 5], usize) {
    let site = &scene.textures.call_sites[wide_index(i)];
    let from = &scene.textures.call_args[site.args_start as usize..][..usize::from(site.n_args)];
    if i.op == Op::Internal && from.len() <= 16 {
        let mut args = [0.0; 16];
        for (arg, r) in args.iter_mut().zip(from) {
            *arg = regs[usize::from(*r)];
        }
        return ([call_internal(scene, site.function, &args[..from.len()]), 0.0, 0.0, 0.0, 0.0], 1);
    }
    let mut buffer = [0.0; MAX_ARGS + 8];
    let n = from.len().min(buffer.len() - 1);
    for (arg, r) in buffer.iter_mut().zip(from) {
        *arg = regs[usize::from(*r)];
    }
    match i.op {
        Op::Sum | Op::Prod => {
            let (lo, hi) = (buffer[0], buffer[1]);
            let (mut total, mut index, mut left) = (if i.op == Op::Sum { 0.0 } else { 1.0 }, lo, MAX_TERMS);
            // The bounds' places shift down: the body's arguments are what follows, then the index.
            let args = &mut buffer[2..=n.max(2)];
            let last = args.len() - 1;
            while index <= hi {
                args[last] = index;
                let term = call_function(scene, site.function, args);
                total = if i.op == Op::Sum { total + term } else { total * term };
                index += 1.0;
                left -= 1;
                if left == 0 || total.is_nan() {
                    total = f64::NAN;
                    break;
                }
            }
            ([total, 0.0, 0.0, 0.0, 0.0], 1)
        }
        Op::Internal => ([call_internal(scene, site.function, &buffer[..n]), 0.0, 0.0, 0.0, 0.0], 1),
        _ => call_function_all(scene, site.function, &buffer[..n]),
    }
}
