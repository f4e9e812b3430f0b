//! POV-Ray's built-in functions by their `internal(n)` number (the numbers stand in the installed functions.inc).
//! Source of every formula: spec/objects.md, section 16, "Internal function formulas".

use crate::math::DVec3;
use crate::math::noise::noise;
use std::f64::consts::{PI, TAU};

const SQRT2: f64 = std::f64::consts::SQRT_2;
const SQRT3: f64 = 1.732_050_807_568_877_2;

/// The value of built-in function `n` at `point` with the parameters that follow x, y, z; missing ones are 0. NaN for unknown numbers.
pub fn eval_internal(n: u32, point: DVec3, params: &[f64]) -> f64 {
    let p = |k: usize| params.get(k).copied().unwrap_or(0.0);
    let (x, y, z) = (point.x, point.y, point.z);
    let (x2, y2, z2) = (x * x, y * y, z * z);
    let q = x2 + y2 + z2;
    // Field strength, clamped: most algebraic surfaces end in it.
    let strength = p(0);
    let c = |e: f64| (strength * e).clamp(-10.0, 10.0);
    match n {
        0..=3 => {
            let [x, y] = revolved(point, p(2), p(3), p(4));
            let (x2, y2) = (x * x, y * y);
            let e = match n {
                0 => x2 * x.abs() - x2 + y2,
                1 => -(2.0 * x2 * x2 - 3.0 * x2 * y + y2 - 2.0 * y2 * y + y2 * y2),
                2 => -(x2 * x2 + x2 * y2 - 2.0 * x2 * y - x * y2 + y2),
                _ => -(x2 * x2 + y2 * y2 + 2.0 * x2 * y2 + 3.0 * x2 * y - y2 * y),
            };
            (strength * e).max(-p(1)).min(p(1))
        }
        4 => {
            let s = p(1);
            let a = x2 + z2 + 2.0 * s * y - s * s;
            c(y2 * (s * s - x2 - z2) - a * a)
        }
        5 => c(p(1) * (x2 + z2) * y - q * q),
        6 => {
            let part = |x: f64, inner: f64| {
                let r = 1.0 - (inner * inner * (x * x + y2 + z2)).min(1.0);
                r * r
            };
            -(p(1) * part(x + p(0) / 2.0, p(2)) + p(3) * part(x - p(0) / 2.0, p(4)))
        }
        7 => {
            let (sep, k) = (p(0), p(1));
            p(3) - p(2) * ((-k * q).exp() + (-k * ((x - sep) * (x - sep) + y2 + z2)).exp())
        }
        8 => {
            let (s, r, w) = (p(1), x2 + y2, 1.0 - z);
            let z4 = z2 * z2;
            c(s * (64.0 * w * w * w * z2 * z - 48.0 * w * w * z2 * (3.0 * r + 2.0 * z2)
                + 12.0 * w * z * (27.0 * r * r - 24.0 * z2 * r + 36.0 * SQRT2 * y * z * (y2 - 3.0 * x2) + 4.0 * z4)
                + (9.0 * r - 2.0 * z2) * (-81.0 * r * r - 72.0 * z2 * r + 108.0 * SQRT2 * x * z * (x2 - 3.0 * y2) + 4.0 * z4)))
        }
        9 => comma(point, p(0)),
        10 | 19 | 32 => {
            let (e, k) = (p(0), p(1));
            let [a, b, c] = ellipsoids(e, k, [x2, y2, z2]);
            let joined = match n {
                10 => a.max(b).max(c),
                19 => a + b + c,
                _ => a.min(b).min(c),
            };
            p(3) - p(2) * joined
        }
        11 => c(x2 * z2 - y),
        12 => c(-(x2 * x - y2 * y - z)),
        13 | 43 => {
            let a = x2 - z;
            c(x2 * z2 - z2 * z2 - 2.0 * z * x2 + 2.0 * z2 * z + x2 - z2 - a * a - y2 * y2 - 2.0 * x2 * y2 - y2 * z2 + 2.0 * y2 * z + y2)
        }
        14 => c(-(x2 * x2 + 2.0 * x2 * z2 - 0.36 * x2 - y2 * y2 + 0.25 * y2 + z2 * z2)),
        15 => {
            let [x, y] = revolved(point, p(3), p(4), p(5));
            let (a, b, x2, y2) = (p(1), p(2), x * x, y * y);
            c(-(x2 * (x2 - a * a) - y2 * (y2 - b * b)))
        }
        16 => {
            let (major, r, a, b, n) = (p(1), p(2), p(3), p(4), p(5));
            let p1 = r * r - b * b - (a + major) * (a + major);
            let p2 = r * r - b * b - (a - major) * (a - major);
            let n2 = n * n;
            let ab = a * x + b * y;
            c(-(p1 * p2 * q * q
                + 2.0 * n2 * ((r * r + major * major - a * a - b * b) * (2.0 * a * x + 2.0 * b * y - n2) - 4.0 * b * r * r * y) * q
                + 4.0 * n2 * n2 * ab * (ab - n2)
                + 4.0 * n2 * n2 * major * major * y2
                + n2 * n2 * n2 * n2))
        }
        17 => (p(0) * p(0) * x2 + p(1) * p(1) * y2 + p(2) * p(2) * z2).sqrt(),
        18 => {
            let w = if z.abs() < 0.2 { 0.2 } else { z };
            let a = (y2 - x2) / (2.0 * w) + 2.0 * z2 / 9.0;
            let b = (y2 - x2) / (4.0 * w);
            c(-(a * a * a - 6.0 * b * b))
        }
        20 => c((y2 + z2) * (1.0 + (p(2) - 4.0 * p(1)) * x) + x2 * (1.0 + p(2))),
        21 => {
            let [x, y] = revolved(point, p(3), p(4), p(5));
            c(-(y * y * (1.0 + (p(2) - 4.0 * p(1)) * x) + x * x * (1.0 + p(2))))
        }
        22 => c(0.5 * x2 * x2 * x + 0.5 * x2 * x2 - y2 - z2),
        23 => {
            let a = 2.0 * x2 + y2 + z2 - 1.0;
            c(-(a * a * a - 0.1 * x2 * z2 * z - y2 * z2 * z))
        }
        24 => helical_torus(point, &p),
        25 => helix1(point, &p),
        26 => helix2(point, &p),
        // The parameter is not used (measured).
        27 | 28 => hex(point, n == 28),
        29 => hetero_mf(point, &p),
        30 => {
            let a = q - 13.0;
            let b = 3.0 * x2 + y2 - 4.0 * z2 - 12.0;
            c(-(4.0 * a * a * a + 27.0 * b * b))
        }
        31 | 46 => {
            let (a, b) = (p(1) * p(1), p(2) * p(2));
            let d = (a - b) * (a - b);
            c(if n == 31 {
                -(x2 * x2 + 2.0 * x2 * y2 - 2.0 * x2 * z2 - 2.0 * (a + b) * x2 + y2 * y2 - 2.0 * y2 * z2
                    + 2.0 * (a - b) * y2
                    + z2 * z2
                    + 2.0 * (a + b) * z2
                    + d)
            } else {
                -(x2 * x2 + 2.0 * x2 * y2 - 2.0 * x2 * z - (a + b) * x2 + y2 * y2 - 2.0 * y2 * z + (a - b) * y2 + z2 + (a + b) * z + d)
            })
        }
        33 => {
            let (a2, c2) = (p(1) * p(1), p(2) * p(2));
            c(-(y2 + z2 - c2 * x2 * x2 + c2 * a2 * x2))
        }
        34 => {
            let [x, y] = revolved(point, p(3), p(4), p(5));
            let (a, k, x2) = (p(1), p(2), x * x);
            c(-(y * y - k * k * x2 * x2 + k * k * k * a * x2))
        }
        35 => {
            let (a, b) = (q + 2.0 * y - 1.0, q - 2.0 * y - 1.0);
            c(-(a * (b * b - 8.0 * z2) + 16.0 * x * z * b))
        }
        36 => c(-(x2 * x2 + y2 * y2 + z2 * z2 - q - x2 * y2 - x2 * z2 - y2 * z2 + 1.0)),
        37 => c(-(x2 * x2 + y2 * y2 + z2 * z2 + p(1) * q + p(2) * (x2 * y2 + x2 * z2 + y2 * z2) + p(3) * x * y * z - 1.0)),
        38 => c(-(x2 * x2 - x2 + y2 + z2)),
        39 => {
            let [x, y] = revolved(point, p(3), p(4), p(5));
            let (a2, b2, x2) = (p(1) * p(1), p(2) * p(2), x * x);
            c(-(y * y - a2 * b2 * x2 + b2 * x2 * x2))
        }
        40 => mesh1(point, &p),
        41 => c(-(4.0 * x2 * q - y2 * (1.0 - y2 - z2))),
        42 => c(-(y2 * y + z2 * z - 6.0 * y * z)),
        44 => {
            let a2 = p(1) * p(1);
            c(-((q + a2) * (q + a2) - p(3) * a2 * (x2 + z2) - p(2) * p(2)))
        }
        45 => c(-(x2 - y + z2)),
        47 => (x2 + z2).sqrt().atan2(y),
        48 => c(x2 * x2 + y2 * y2 + z2 * z2 - q),
        49 => c(x2 * x2 - x2 * x + y2 + z2),
        50 => {
            let [x, y] = revolved(point, p(4), p(5), p(6));
            let (a, b, k, x2) = (p(1), p(2), p(3), x * x);
            c(-(y * y - a * k * k * x2 * x - b * k * k * x2 * x2))
        }
        51 => (x2 + z2).sqrt() - poly4(y, &[p(0), p(1), p(2), p(3), p(4)]).max(-5.0),
        52 => {
            let r = poly4(y, &[p(1), p(2), p(3), p(4), p(5)]);
            let count = p(0).clamp(0.0, 1e6) as u32;
            (0..count)
                .map(|i| {
                    let (s, c) = (TAU * f64::from(i) / p(0)).sin_cos();
                    (x - r * s).hypot(z - r * c)
                })
                // Beyond this distance it stays the same (measured).
                .fold(10_000.0, f64::min)
        }
        53 => {
            let r = 2.0 * q.sqrt();
            let cos = (x2 + z2).sqrt().atan2(y).cos();
            let t = r * r * (-0.333_333_33 * r).exp() * (3.0 * cos * cos - 1.0);
            -0.1 * (t * t - 12.0)
        }
        54 => c(-(x2 * x2 + z2 * z2 - y)),
        55 => c(-(x2 * x2 - z2 * z2 - y)),
        56 => {
            let (d2, w2, r2) = (p(1) * p(1), p(2) * p(2), x2 + z2);
            c(-(r2 * y2 + w2 * r2 - w2 * d2))
        }
        57 => q.sqrt(),
        58 => ridge(point, &p),
        59 => ridged_mf(point, &p),
        60 => {
            let r = p(0);
            let out = point.abs() - DVec3::new(p(1) - r, p(2) - r, p(3) - r);
            out.max(DVec3::ZERO).length() - r - 1e-6
        }
        61 => q.sqrt() - p(0),
        62 => {
            let [e1, e2, e3] = ellipsoids(p(0), p(1), [x2, y2, z2]);
            -p(2) * (p(4) * (-p(3) * q).exp() - e1 - e2 - e3)
        }
        63 => y - p(0) * (p(1) * x).cos() * (p(2) * z).cos() * (-p(3) * (x2 + z2)).exp(),
        64 => {
            let (x, q) = if x == 0.0 && z == 0.0 { (1e-6, y2 + 1e-12) } else { (x, q) };
            let r = (x * x + z2).sqrt() + p(0) * z.atan2(x) / TAU;
            let d0 = r % p(0) - p(0) / 2.0;
            let d = cross_section(d0, y, p(5));
            let q = q.sqrt();
            -(p(2) - q).min(p(1) - d.min(q))
        }
        65 => c(-(x2 * y2 + x2 * z2 + y2 * z2 + x * y * z)),
        66 => {
            let (a, b, k) = (p(1), p(2), p(3));
            c(-((b - x) * (y2 + z2) - k * k * a * x2 - k * k * x2 * x))
        }
        67 => {
            let [x, y] = revolved(point, p(4), p(5), p(6));
            let (a, b, k, x2) = (p(1), p(2), p(3), x * x);
            c(-((b - x) * y * y - k * k * a * x2 - k * k * x2 * x))
        }
        68 => {
            let (e, n) = (p(0), p(1));
            let ring = (x.abs().powf(2.0 / e) + y.abs().powf(2.0 / e)).powf(e / n);
            1.0 - (ring + z.abs().powf(2.0 / n)).powf(n / 2.0)
        }
        69 => x.atan2(z),
        70 => ((x2 + z2).sqrt() - p(0)).hypot(y) - p(1),
        71 => {
            let (a, b) = (p(1) * p(1), p(2) * p(2));
            c(-(q * q - 2.0 * (a + b) * (x2 + z2) + 2.0 * (a - b) * y2 + (a - b) * (a - b)))
        }
        72 => {
            let r = y2 + z2;
            c(-(4.0 * (x2 * x2 + r * r) + 17.0 * x2 * r - 20.0 * q + 17.0))
        }
        73 => c(-(x2 - y * z2)),
        74 => c(-(p(1) * (y - 1.0) + (x2 + z2) * y)),
        75 => {
            let [x, y] = revolved(point, p(3), p(4), p(5));
            c(-(p(1) * p(1) * y + x * x * y - p(2)))
        }
        // f_noise3d is answered by the caller, which knows the scene's generator.
        76 => noise(point, 2),
        78 => noise(point, generator(p(0))),
        _ => f64::NAN,
    }
}

/// The generator that an extra parameter names: 0 acts like 1.
fn generator(n: f64) -> u8 {
    ((n as i64) & 3).max(1) as u8
}

/// Curves in x and y that may be turned about the y axis: `switch` > 0, then the radius is shifted and the plane turned.
fn revolved(p: DVec3, switch: f64, offset: f64, angle_deg: f64) -> [f64; 2] {
    if switch > 0.0 {
        let h = (p.x * p.x + p.z * p.z).sqrt() - offset;
        if angle_deg == 0.0 {
            return [h, p.y];
        }
        let (s, c) = (angle_deg * (PI / 180.0)).sin_cos();
        return [h * c - p.y * s, h * s + p.y * c];
    }
    [p.x, p.y]
}

/// Three crossed ellipsoidal fields of eccentricity `e`; squares of the coordinates are given.
fn ellipsoids(e: f64, k: f64, [x2, y2, z2]: [f64; 3]) -> [f64; 3] {
    [(-k * (e * (x2 + y2) + z2)).exp(), (-k * (e * (x2 + z2) + y2)).exp(), (-k * (x2 + e * (y2 + z2))).exp()]
}

fn poly4(y: f64, k: &[f64; 5]) -> f64 {
    k[0] + y * (k[1] + y * (k[2] + y * (k[3] + y * k[4])))
}

/// Size of (a, b) by a cross section's type: 1 round, 0 square, others superelliptic.
fn cross_section(a: f64, b: f64, kind: f64) -> f64 {
    if kind == 1.0 {
        (a * a + b * b).sqrt()
    } else if kind != 0.0 {
        (a.abs().powf(2.0 / kind) + b.abs().powf(2.0 / kind)).powf(kind / 2.0)
    } else {
        a.abs().max(b.abs())
    }
}

fn comma(p: DVec3, s: f64) -> f64 {
    let x = if p.x == 0.0 && p.z == 0.0 { 1e-4 } else { p.x };
    let r = ((x + s / 4.0) * (x + s / 4.0) + p.z * p.z).sqrt();
    let d = r - 0.75 * s;
    let a = p.z.min((s / 2.0) * (p.z.atan2(x) / 2.0).cos() - (d * d + p.y * p.y).sqrt());
    let h = x - s / 2.0;
    let b = s / 2.0 - (h * h + p.y * p.y + p.z * p.z).sqrt();
    -a.max(b)
}

/// 0..2pi.
fn turn(a: f64) -> f64 {
    let a = a % TAU;
    if a < 0.0 { a + TAU } else { a }
}

fn helical_torus(p: DVec3, a: &impl Fn(usize) -> f64) -> f64 {
    let radius = (p.x * p.x + p.z * p.z).sqrt();
    let x = if p.x == 0.0 && p.z == 0.0 { 1e-6 } else { p.x };
    let ph = x.atan2(p.z);
    let d = radius - a(0);
    let r = (d * d + p.y * p.y).sqrt();
    let th = turn(ph * a(1) + a(2) * d.atan2(p.y)) - PI;
    let g = a(4) + a(3) * (a(7) * (th * a(8)).atan2(r - a(5)) + ph * a(9)).cos();
    let e = r - a(5);
    let b = g - (e * e + a(6) * th * th).sqrt().min(r + a(5));
    -(a(4) + a(5) - a(0) - radius).max(b)
}

fn helix1(p: DVec3, a: &impl Fn(usize) -> f64) -> f64 {
    let (n, period, minor, major, shape, kind, angle) = (a(0), a(1), a(2), a(3), a(4), a(5), a(6));
    let r = (p.x * p.x + p.z * p.z).sqrt();
    let th = turn(n * p.z.atan2(p.x) + p.y * period * n);
    let z = (th - PI) / shape / (period * n);
    let x = r - major;
    let (mut u, mut v) = (x, z);
    if kind != 1.0 && angle != 0.0 {
        let (s, c) = (angle * (PI / 180.0)).sin_cos();
        (u, v) = (x * c - z * s, x * s + z * c);
    }
    (major + r).min(cross_section(u, v, kind)) - minor
}

fn helix2(p: DVec3, a: &impl Fn(usize) -> f64) -> f64 {
    let (period, minor, major, kind) = (a(1), a(2), a(3), a(5));
    let (s, c) = (p.y * period).sin_cos();
    let (x, z) = (p.x - major * c, p.z - major * s);
    cross_section(x * c + z * s, -x * s + z * c, kind) - minor
}

fn hex(p: DVec3, along_y: bool) -> f64 {
    let half = SQRT3 / 2.0;
    let mut x = (p.x.abs() % SQRT3 - half).abs();
    let mut y = (p.y.abs() % 3.0 - 1.5).abs();
    if x * x + y * y > (half - x) * (half - x) + (1.5 - y) * (1.5 - y) {
        (x, y) = (half - x, 1.5 - y);
    }
    // Of the two sides of a cell the nearer one counts.
    match (along_y, y.atan2(x) < PI / 6.0) {
        (false, true) => x,
        (true, true) => y,
        (false, false) => x / 2.0 + y * half,
        (true, false) => (-x * half + y / 2.0).abs(),
    }
}

fn mesh1(p: DVec3, a: &impl Fn(usize) -> f64) -> f64 {
    let (dx, dz, thread, amplitude, squash) = (a(0), a(1), a(2), a(3), a(4));
    let fold = |v: f64, d: f64| {
        let m = v % (2.0 * d);
        ((if m < 0.0 { m + 2.0 * d } else { m }) - d).abs()
    };
    let distance = |across: f64, height: f64| {
        let (u, v) = (across * thread, height * squash);
        (u * u + v * v).sqrt()
    };
    let (cz, cx) = (amplitude * (p.z * PI / dz).cos(), amplitude * (p.x * PI / dx).cos());
    distance(fold(p.x, dx), p.y - cz)
        .min(distance(fold(p.x + dx, dx), p.y + cz))
        .min(distance(fold(p.z, dz), p.y + cx))
        .min(distance(fold(p.z + dz, dz), p.y - cx))
}

fn ridge(p: DVec3, a: &impl Fn(usize) -> f64) -> f64 {
    let (lambda, octaves, omega, offset, ridge, generator) = (a(0), a(1), a(2), a(3), a(4), generator(a(5)));
    let ridge_scale = 1.0 / ridge.max(1.0 - ridge);
    let scale = 1.0 / offset.max(1.0 - offset);
    let octave = |l: f64| (noise(p * l, generator) - ridge).abs() * ridge_scale - offset;
    let (mut l, mut o, mut sum, mut weight) = (1.0, 1.0, 0.0, 0.0);
    let whole = octaves.clamp(0.0, 1000.0).trunc();
    for _ in 0..whole as u32 {
        sum += o * octave(l);
        weight += o;
        l *= lambda;
        o *= omega;
    }
    let rest = octaves - whole;
    if rest > 0.0 && octaves < 1000.0 {
        sum += rest * o * octave(l);
        weight += rest * o;
    }
    sum * scale / weight
}

fn ridged_mf(p: DVec3, a: &impl Fn(usize) -> f64) -> f64 {
    let (h, lacunarity, octaves, offset, gain, generator) = (a(0), a(1), a(2), a(3), a(4), generator(a(5)));
    let fold = |p: DVec3| {
        let s = offset - (2.0 * noise(p, generator) - 1.0).abs();
        s * s
    };
    let mut q = p;
    let mut signal = fold(q);
    let mut result = signal;
    let mut i = 1.0;
    while i < octaves.min(1000.0) {
        q *= lacunarity;
        let weight = (signal * gain).clamp(0.0, 1.0);
        signal = weight * fold(q);
        result += signal * lacunarity.powf(-h * i);
        i += 1.0;
    }
    result
}

fn hetero_mf(p: DVec3, a: &impl Fn(usize) -> f64) -> f64 {
    let (h, lacunarity, octaves, offset, power, generator) = (a(0), a(1), a(2).min(1000.0), a(3), a(4).trunc(), generator(a(5)));
    let octave = |p: DVec3| 2.0 * noise(p, generator) - 1.0 + offset;
    let raised = |v: f64| v.powi(power.clamp(-1000.0, 1000.0) as i32);
    let mut q = p;
    let mut value = octave(q);
    let mut i = 1.0;
    q *= lacunarity;
    while i < octaves {
        value += octave(q) * lacunarity.powf(-h * i) * raised(value);
        q *= lacunarity;
        i += 1.0;
    }
    let rest = octaves - octaves.floor();
    if rest != 0.0 {
        value += rest * octave(q) * lacunarity.powf(-h * i) * value;
    }
    value
}
