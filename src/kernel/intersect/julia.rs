//! Julia fractals of quaternions and hypercomplex numbers: steps by an estimate of the distance, then bisection.
//! Source: spec/objects.md, section 11.

use super::{HitSink, LocalRay, Part};
use crate::compile::shape::implicit::JuliaShape;
use crate::math::complex::Complex;
use crate::math::{DVec3, DVec4, MAX_DISTANCE};
use crate::scene::shape::JuliaFunction;

/// Rays start this far on, and bisection ends at this width.
const TOLERANCE: f64 = 1e-7;
/// Hits nearer than this are not seen. Measured by the shadows of objects/fractal3.pov.
const NEAREST: f64 = 4e-7;
/// Most steps along a ray.
const MAX_STEPS: u32 = 2_000_000;

fn start(s: &JuliaShape, p: DVec3) -> DVec4 {
    p.extend(s.w0 + s.w_slope.dot(p))
}

/// The two complex numbers that a hypercomplex number acts as.
fn parts(q: DVec4) -> (Complex, Complex) {
    (Complex::new(q.x - q.w, q.y + q.z), Complex::new(q.x + q.w, q.y - q.z))
}

fn whole(a: Complex, b: Complex) -> DVec4 {
    DVec4::new(0.5 * (a.re + b.re), 0.5 * (a.im + b.im), 0.5 * (a.im - b.im), 0.5 * (b.re - a.re))
}

/// Half the sum of products of parts: what the dot product of the whole numbers is.
fn dot((a, b): (Complex, Complex), (c, d): (Complex, Complex)) -> f64 {
    0.5 * ((a.re * c.re + a.im * c.im) + (b.re * d.re + b.im * d.im))
}

/// A function of complex numbers and its derivative.
#[inline]
fn complex_step(f: &JuliaFunction, z: Complex) -> (Complex, Complex) {
    use JuliaFunction as J;
    let one = Complex::ONE;
    match f {
        J::Sqr => (z * z, z.scale(2.0)),
        J::Cube => (z * z * z, (z * z).scale(3.0)),
        J::Exp => (z.exp(), z.exp()),
        J::Reciprocal => (one / z, -(one / (z * z))),
        J::Sin => (z.sin(), z.cos()),
        J::Cos => (z.cos(), -z.sin()),
        J::Tan => {
            let (s, c) = (z.sin(), z.cos());
            (s / c, one / (c * c))
        }
        J::Sinh => (z.sinh(), z.cosh()),
        J::Cosh => (z.cosh(), z.sinh()),
        J::Tanh => {
            let (s, c) = (z.sinh(), z.cosh());
            (s / c, one / (c * c))
        }
        J::Asin => (z.asin(), one / (one - z * z).sqrt()),
        J::Acos => (z.acos(), -(one / (one - z * z).sqrt())),
        J::Atan => (z.atan(), one / (one + z * z)),
        J::Asinh => (z.asinh(), one / (one + z * z).sqrt()),
        J::Acosh => (z.acosh(), one / ((z - one).sqrt() * (z + one).sqrt())),
        J::Atanh => (z.atanh(), one / (one - z * z)),
        J::Ln => (z.ln(), one / z),
        J::Pwr(re, im) => {
            let p = Complex::new(*re, *im);
            (z.powc(p), p * z.powc(p - one))
        }
    }
}

/// One step of a quaternion without derivatives.
fn step(s: &JuliaShape, q: DVec4) -> DVec4 {
    let v = DVec3::new(q.y, q.z, q.w);
    let d = v.length_squared();
    let (x, k) = match s.function {
        JuliaFunction::Cube => (q.x * (q.x * q.x - 3.0 * d), 3.0 * q.x * q.x - d),
        _ => (q.x * q.x - d, 2.0 * q.x),
    };
    DVec4::new(x, k * q.y, k * q.z, k * q.w) + s.c
}

/// POV-Ray's slip: for most hypercomplex functions the inside test starts with z = y.
fn test_start(s: &JuliaShape, p: DVec3) -> DVec4 {
    let mut q = start(s, p);
    let exact = matches!(s.function, JuliaFunction::Sqr | JuliaFunction::Cube | JuliaFunction::Reciprocal);
    if s.hypercomplex && !exact {
        q.z = q.y;
    }
    q
}

/// Calls one of two copies of `$call`, made for the commonest function and for any.
macro_rules! for_function {
    ($s:expr, $step:ident => $call:expr) => {
        if $s.function == JuliaFunction::Sqr {
            let $step = |z: Complex| (z * z, z.scale(2.0));
            $call
        } else {
            let $step = |z: Complex| complex_step(&$s.function, z);
            $call
        }
    };
}

/// Whether the point does not escape.
pub fn inside_julia(s: &JuliaShape, p: DVec3) -> bool {
    let q = test_start(s, p);
    if !s.hypercomplex {
        return !escapes(s, q);
    }
    for_function!(s, step => !escapes_in_parts(s, q, step))
}

#[inline(always)]
fn escapes_in_parts(s: &JuliaShape, q: DVec4, step: impl Fn(Complex) -> (Complex, Complex)) -> bool {
    let ((mut a, mut b), (ca, cb)) = (parts(q), parts(s.c));
    for _ in 0..s.max_iteration {
        // NaN counts as escaped.
        if !(dot((a, b), (a, b)) <= s.escape_sq) {
            return true;
        }
        (a, b) = (step(a).0 + ca, step(b).0 + cb);
    }
    false
}

/// Of a quaternion.
fn escapes(s: &JuliaShape, mut q: DVec4) -> bool {
    for _ in 0..s.max_iteration {
        // NaN counts as escaped.
        if !(q.length_squared() <= s.escape_sq) {
            return true;
        }
        q = step(s, q);
    }
    false
}

/// As [`look`] for hypercomplex numbers: a Newton step of |z|² towards 0 along the ray, if it is neither too short nor too long.
#[inline(always)]
fn look_in_parts(s: &JuliaShape, p: DVec3, dir: DVec3, step: impl Fn(Complex) -> (Complex, Complex)) -> (bool, f64) {
    let least = 1.0 / s.precision;
    let ((mut a, mut b), (ca, cb)) = (parts(start(s, p)), parts(s.c));
    let (mut va, mut vb) = parts(dir.extend(s.w_slope.dot(dir)));
    for _ in 0..s.max_iteration {
        let n = dot((a, b), (a, b));
        if !(n <= s.escape_sq) {
            let step = -n / (2.0 * dot((a, b), (va, vb)));
            return (false, if step > least && step < 30.0 * least { step } else { least });
        }
        let ((fa, da), (fb, db)) = (step(a), step(b));
        (va, vb) = (va * da, vb * db);
        (a, b) = (fa + ca, fb + cb);
    }
    (true, least)
}

/// Whether the point is inside, and how far a ray along `dir` may go on. Quaternions: |z| ln |z|² / |z'|, the derivative taken of one
/// more step. Measured: every hit of 1500 random rays.
fn look(s: &JuliaShape, p: DVec3, dir: DVec3) -> (bool, f64) {
    if s.hypercomplex {
        return for_function!(s, step => look_in_parts(s, p, dir, step));
    }
    let least = 1.0 / s.precision;
    let mut q = start(s, p);
    let cube = s.function == JuliaFunction::Cube;
    let mut slope = 1.0f64;
    for _ in 0..s.max_iteration {
        let n = q.length_squared();
        slope *= if cube { 3.0 * n } else { 2.0 * n.sqrt() };
        if !(n <= s.escape_sq) {
            let d = n.sqrt() * n.ln() / slope.max(1e-13);
            return (false, if d.is_finite() { d.max(least) } else { least });
        }
        q = step(s, q);
    }
    (true, least)
}

/// Changes between inside and outside along the ray; only the first unless `all`.
pub fn intersect_julia(s: &JuliaShape, ray: &LocalRay, all: bool, sink: &mut impl HitSink) {
    let b = -ray.origin.dot(ray.dir);
    let d = b * b - ray.origin.length_squared() + s.radius * s.radius;
    if d < 0.0 {
        return;
    }
    let (mut t, end) = ((b - d.sqrt()).max(TOLERANCE), b + d.sqrt());
    if end < t {
        return;
    }
    let (mut was_inside, mut ahead) = look(s, ray.at(t), ray.dir);
    for _ in 0..MAX_STEPS {
        let before = t;
        t += ahead;
        if t > end || t > MAX_DISTANCE || t > sink.far() + ahead {
            return;
        }
        let (now_inside, next) = look(s, ray.at(t), ray.dir);
        if now_inside != was_inside {
            // Halve back to where it changed; the hit is on the far side.
            let (mut low, mut high) = (before, t);
            while high - low > TOLERANCE {
                let mid = 0.5 * (low + high);
                if inside_julia(s, ray.at(mid)) == was_inside { low = mid } else { high = mid }
            }
            let hit = high;
            if hit > NEAREST {
                sink.push(hit, Part::default());
                if !all {
                    return;
                }
            }
        }
        (was_inside, ahead) = (now_inside, next);
    }
}

/// What POV-Ray multiplies derivatives with at step `k` where the hypercomplex number's part is `z`, and the function's value there. Measured
/// at 400 hits of each function: the first factor is always the square's, later ones are derivatives for some functions alone, for others the
/// values of the function itself.
fn slope_in_parts(f: &JuliaFunction, k: u32, z: Complex) -> (Complex, Complex) {
    use JuliaFunction as J;
    let (value, derivative) = complex_step(f, z);
    match f {
        _ if k == 0 => (value, z.scale(2.0)),
        J::Sqr | J::Cube | J::Exp | J::Reciprocal => (value, derivative),
        _ => (value, value),
    }
}

/// Gradient of the squared length after the last iteration.
pub fn julia_normal(s: &JuliaShape, p: DVec3) -> DVec3 {
    let mut q = test_start(s, p);
    // Derivatives along x, y and z, carried forward. That w follows them in a slanted slice is left out, as in POV-Ray.
    let mut d = [DVec4::X, DVec4::Y, DVec4::Z];
    for k in 0..s.max_iteration {
        if s.hypercomplex {
            let (a, b) = parts(q);
            let ((fa, da), (fb, db)) = (slope_in_parts(&s.function, k, a), slope_in_parts(&s.function, k, b));
            d = d.map(|v| {
                let (va, vb) = parts(v);
                whole(va * da, vb * db)
            });
            q = whole(fa, fb) + s.c;
        } else {
            let v = DVec3::new(q.y, q.z, q.w);
            let n = v.length_squared();
            d = d.map(|e| {
                let ev = DVec3::new(e.y, e.z, e.w);
                let along = 2.0 * v.dot(ev);
                let (x, u) = match s.function {
                    JuliaFunction::Cube => {
                        (e.x * (3.0 * q.x * q.x - 3.0 * n) - 3.0 * q.x * along, ev * (3.0 * q.x * q.x - n) + v * (6.0 * q.x * e.x - along))
                    }
                    _ => (2.0 * q.x * e.x - along, 2.0 * (q.x * ev + e.x * v)),
                };
                DVec4::new(x, u.x, u.y, u.z)
            });
            q = step(s, q);
        }
        // Lengths may run away in a few steps; directions are all that counts.
        let scale = d.iter().map(|v| v.length()).fold(0.0, f64::max);
        if !(scale > 0.0 && scale.is_finite() && q.is_finite()) {
            break;
        }
        d = d.map(|v| v / scale);
        if q.length_squared() > 1e12 {
            break;
        }
    }
    let n = DVec3::new(q.dot(d[0]), q.dot(d[1]), q.dot(d[2]));
    n.try_normalize().unwrap_or(DVec3::X)
}
