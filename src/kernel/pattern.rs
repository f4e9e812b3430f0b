//! Pattern values: from a point to the number that maps are looked up with. Formulas by family stand in `pattern/`.
//! Source: spec/textures.md, sections 1 and 2.

pub mod cells;
pub mod density;
pub mod fractal;
pub mod noisy;
pub mod pavement;
pub mod penrose;
pub mod simple;
pub mod tiling;

use super::PatternPoint;
use super::function::call_function;
use super::image::image_pattern_value;
use super::inside::inside_object;
use super::pigment::eval_pigment;
use super::warp::warp_by;
use crate::compile::CompiledScene;
use crate::compile::texture::{PatternCode, PatternIx, PatternNode};
use crate::math::color::grey;
use crate::math::noise::{noise, turbulence};
use crate::math::{DVec3, EPSILON};
use crate::scene::pattern::Wave;

/// The value of a pattern at a point, warps, frequency, phase and wave included.
#[inline]
pub fn eval_pattern(scene: &CompiledScene, pattern: PatternIx, at: &PatternPoint) -> f64 {
    let node = &scene.textures.patterns[pattern as usize];
    let p = warp_by(scene, node, at.point);
    value_at_warped(scene, node, p, at)
}

/// The same for a point that was warped before.
#[inline]
pub fn value_at_warped(scene: &CompiledScene, node: &PatternNode, p: DVec3, at: &PatternPoint) -> f64 {
    shaped(node, raw_value(scene, node, p, at))
}

/// `sin(2 pi v)` of the fraction of `v`; odd.
#[inline]
pub fn cycloidal(v: f64) -> f64 {
    if v >= 0.0 { ((v - v.floor()) * std::f64::consts::TAU).sin() } else { -((-v - (-v).floor()) * std::f64::consts::TAU).sin() }
}

/// 0 at integers, 1 half way.
#[inline]
pub fn triangle_wave(v: f64) -> f64 {
    let f = if v >= 0.0 { v - v.floor() } else { v + (-v).floor() + 1.0 };
    if f >= 0.5 { 2.0 * (1.0 - f) } else { 2.0 * f }
}

/// `v % m` up to rounding, without the library's loop.
#[inline]
fn remainder(v: f64, m: f64) -> f64 {
    if v.abs() < m {
        return v;
    }
    // Beyond this the quotient is no integer of 53 bits, and the library's answer is as good as noise.
    if !(v.abs() < 1e15) {
        return v % m;
    }
    let r = v - (v / m).trunc() * m;
    // The quotient may round up to the next integer.
    if r * v < 0.0 { r + m.copysign(v) } else { r }
}

/// The fraction of a number, with its sign: `v % 1.0`.
#[inline]
pub(super) fn fraction(v: f64) -> f64 {
    v - v.trunc()
}

/// Frequency, phase and wave.
#[inline]
fn shaped(node: &PatternNode, raw: f64) -> f64 {
    let mut v = raw;
    if node.frequency != 0.0 {
        v = remainder(v * node.frequency + node.phase, 1.000_01);
    }
    if v < 0.0 {
        v -= v.floor();
    }
    match node.wave {
        Wave::Ramp => v,
        Wave::Triangle => triangle_wave(v),
        Wave::Sine => (1.0 + cycloidal(v)) * 0.5,
        Wave::Scallop => cycloidal(v * 0.5).abs(),
        Wave::Cubic => v * v * (3.0 - 2.0 * v),
        Wave::Poly(e) => v.powf(f64::from(e)),
    }
}

/// The pattern's own number at a warped point.
fn raw_value(scene: &CompiledScene, node: &PatternNode, p: DVec3, at: &PatternPoint) -> f64 {
    let generator = node.noise_generator;
    let turb = || turbulence(p, node.turb.octaves, node.turb.omega, node.turb.lambda, generator);
    match node.code {
        PatternCode::Plain | PatternCode::Facets { .. } => 0.0,
        PatternCode::Agate { turb: amount } => {
            let t = if amount == 0.0 { 0.0 } else { amount * turb() };
            let v = 0.5 * (cycloidal(1.3 * t + 1.1 * p.z) + 1.0);
            if v < 0.0 { 0.0 } else { v.min(1.0).powf(0.77) }
        }
        PatternCode::Aoi => at.normal.dot(at.ray_dir).clamp(-1.0, 1.0).acos() / std::f64::consts::PI,
        PatternCode::Boxed => beyond(p.abs().max_element()),
        PatternCode::Noise | PatternCode::Bumps => noise(p, generator),
        PatternCode::Brick { size, mortar } => simple::brick(p, size, mortar),
        PatternCode::Cells => cells::cells(p),
        PatternCode::Checker => simple::checker(p),
        PatternCode::Crackle { form, metric, offset, solid } => cells::crackle(p, form, metric, offset, solid, generator),
        PatternCode::Cubic => simple::cubic(p),
        PatternCode::Cylindrical => beyond((p.x * p.x + p.z * p.z).sqrt()),
        PatternCode::Density { grid, interpolate } => density::density(&scene.textures.grids[grid as usize], interpolate, p),
        PatternCode::Dents => {
            let n = noise(p, generator);
            n * n * n
        }
        PatternCode::Fractal(ix) => fractal::fractal(&scene.textures.fractals[ix as usize], p),
        PatternCode::Function(ix) => above_one(call_function(scene, ix, &p.to_array())),
        PatternCode::Gradient(direction) => above_one(p.dot(direction)),
        PatternCode::Granite => noisy::granite(p, generator),
        PatternCode::Hexagon => simple::hexagon(p),
        PatternCode::Image(ix) => image_pattern_value(&scene.textures.images[ix as usize], p),
        PatternCode::Leopard => {
            let s = (p.x.sin() + p.y.sin() + p.z.sin()) / 3.0;
            s * s
        }
        PatternCode::Marble => {
            let tx = node.turb_amount.x;
            if tx == 0.0 { p.x } else { p.x + tx * turb() }
        }
        PatternCode::Object(slot) => {
            let object = scene.textures.pattern_objects[slot as usize];
            f64::from(u8::from(object != crate::compile::NONE && inside_object(scene, object, p)))
        }
        PatternCode::Onion => fraction(p.length()),
        PatternCode::Pavement(ref pavement) => pavement::pavement(p.x, p.z, pavement),
        PatternCode::Pigment(ix) => {
            let inner = PatternPoint { point: p, ..*at };
            eval_pigment(scene, ix, &inner).map_or(0.0, |c| f64::from(grey(c.rgb)))
        }
        PatternCode::Planar => beyond(p.y.abs()),
        PatternCode::Quilted { control0, control1 } => {
            let (q, s) = simple::quilt(p, control0, control1);
            s * (q.x.abs() + q.y.abs() + q.z.abs()) / 3.0
        }
        PatternCode::Radial => simple::radial(p),
        PatternCode::Ripples => noisy::ripples(&scene.textures.wave_sources, p, node.frequency, node.phase),
        PatternCode::Slope(ix) => simple::slope(&scene.textures.slopes[ix as usize], p, at),
        PatternCode::Spherical => beyond(p.length()),
        PatternCode::Spiral1 { arms } => spiral(node, p, arms, generator),
        PatternCode::Spiral2 { arms } => {
            let r = (p.x * p.x + p.y * p.y).sqrt();
            triangle_wave(r) + triangle_wave(spiral(node, p, arms, generator))
        }
        PatternCode::Square => simple::square(p),
        PatternCode::Tiling(n) => tiling::tiling(p, n),
        PatternCode::Triangular => simple::triangular(p),
        PatternCode::Waves => noisy::waves(&scene.textures.wave_sources, p, node.frequency, node.phase),
        PatternCode::Wood => noisy::wood(node, p),
        PatternCode::Wrinkles => noisy::wrinkles(p, generator),
    }
}

/// Patterns that fade out at distance 1.
#[inline]
fn beyond(a: f64) -> f64 {
    if a > 1.0 { 0.0 } else { 1.0 - a }
}

/// Values above one keep their fraction; the rest is as it is.
#[inline]
fn above_one(v: f64) -> f64 {
    if v > 1.0 { fraction(v) } else { v }
}

fn spiral(node: &PatternNode, p: DVec3, arms: f64, generator: u8) -> f64 {
    let r = (p.x * p.x + p.y * p.y).sqrt();
    let phi = if r == 0.0 {
        0.0
    } else {
        let a = (p.y / r).asin();
        std::f64::consts::FRAC_PI_2 + if p.x < 0.0 { std::f64::consts::PI - a } else { a }
    };
    let turb = match node.turb_amount.x {
        0.0 => 0.0,
        tx => tx * turbulence(p, node.turb.octaves, node.turb.omega, node.turb.lambda, generator),
    };
    p.z + r + arms * phi / std::f64::consts::TAU + turb
}

/// Keeps a wrapped value below 1.
#[inline]
fn below_one(v: f64) -> f64 {
    let v = if v < 0.0 { 1.0 + fraction(v) } else { fraction(v) };
    if (1.0..1.0 + EPSILON).contains(&v) { v - EPSILON } else { v }
}
