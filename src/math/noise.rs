//! POV-Ray's noise: three scalar generators, the vector noise, and turbulence.
//!
//! Source: FACTS.md section 2 and spec/textures.md section 0. The lattice behind generators 1 and 2 and the vector noise: `math/lattice`.

use super::DVec3;
pub use super::lattice::NOISE_TABLE;
use super::lattice::s_curve;
use super::random::lcg_step;
use super::simd::noise as simd;
use std::sync::LazyLock;

/// Noise in 0..=1 by generator 1 (original), 2 (range corrected) or 3 (Perlin).
pub fn noise(p: DVec3, generator: u8) -> f64 {
    if generator > 2 { perlin(p) } else { ranged(simd::lattice_scalar(p), generator) }
}

/// A sum of the lattice in 0..=1, for generators 1 and 2.
#[inline(always)]
pub(super) fn ranged(sum: f64, generator: u8) -> f64 {
    if generator == 2 { (sum + 1.052_42) * 0.489_855_82 } else { sum + 0.5 }.clamp(0.0, 1.0)
}

/// Noise at a point times 1, 2, 4, ...
#[inline]
pub fn noise_doublings<const N: usize>(p: DVec3, generator: u8) -> [f64; N] {
    if generator > 2 {
        let mut p = p;
        return std::array::from_fn(|_| {
            let v = perlin(p);
            p += p;
            v
        });
    }
    simd::lattice_doublings(p).map(|v| ranged(v, generator))
}

/// Vector noise; the same for every generator, neither clamped nor biased.
#[inline]
pub fn noise_vector(p: DVec3) -> DVec3 {
    simd::lattice_vector(p)
}

/// Scalar turbulence. `omega` and `lambda` are 32-bit, as POV-Ray keeps them.
pub fn turbulence(p: DVec3, octaves: u32, omega: f32, lambda: f32, generator: u8) -> f64 {
    if generator > 2 {
        octave_sum(p, octaves, omega, lambda, generator, perlin)
    } else {
        simd::turbulence(p, octaves, omega, lambda, generator)
    }
}

/// The octaves of [`turbulence`] over a noise in 0..=1.
#[inline(always)]
pub(super) fn octave_sum(p: DVec3, octaves: u32, omega: f32, lambda: f32, generator: u8, noise: impl Fn(DVec3) -> f64) -> f64 {
    let one = |p| if generator > 1 { 2.0 * noise(p) - 0.5 } else { noise(p) };
    let (omega, lambda) = (f64::from(omega), f64::from(lambda));
    let mut sum = one(p);
    if generator > 1 {
        sum = sum.clamp(0.0, 1.0);
    }
    let (mut l, mut o) = (lambda, omega);
    for _ in 1..octaves {
        sum += o * one(p * l);
        l *= lambda;
        o *= omega;
    }
    sum
}

/// Vector turbulence: the displacement of a point.
#[inline]
pub fn turbulence_vector(p: DVec3, octaves: u32, omega: f32, lambda: f32) -> DVec3 {
    simd::turbulence_vector(p, octaves, omega, lambda)
}

/// The octaves of [`turbulence_vector`] over a vector noise.
#[inline(always)]
pub(super) fn octave_sum_vector(p: DVec3, octaves: u32, omega: f32, lambda: f32, noise: impl Fn(DVec3) -> DVec3) -> DVec3 {
    let (omega, lambda) = (f64::from(omega), f64::from(lambda));
    let mut sum = noise(p);
    let (mut l, mut o) = (lambda, omega);
    for _ in 1..octaves {
        sum += o * noise(p * l);
        l *= lambda;
        o *= omega;
    }
    sum
}

/// Gradients and permutation of generator 3.
struct Perlin {
    gradients: Vec<DVec3>,
    permutation: Vec<usize>,
}

const PERLIN_SIZE: usize = 2048;

static PERLIN: LazyLock<Perlin> = LazyLock::new(|| {
    let mut seed = 1u32;
    let mut draw = || {
        seed = lcg_step(seed);
        ((seed >> 16) & 0x7FFF) as usize
    };
    let mut gradients = Vec::with_capacity(PERLIN_SIZE);
    while gradients.len() < PERLIN_SIZE {
        let mut component = || ((draw() % (2 * PERLIN_SIZE)) as f64 - PERLIN_SIZE as f64) / PERLIN_SIZE as f64;
        let v = DVec3::new(component(), component(), component());
        if (1e-5..=1.0).contains(&v.length_squared()) {
            gradients.push(v.normalize());
        }
    }
    let mut permutation: Vec<usize> = (0..PERLIN_SIZE).chain(std::iter::repeat_n(0, PERLIN_SIZE + 2)).collect();
    for i in (2..=PERLIN_SIZE).rev().step_by(2) {
        let j = draw() % PERLIN_SIZE;
        permutation.swap(i, j);
    }
    for i in 0..PERLIN_SIZE + 2 {
        permutation[PERLIN_SIZE + i] = permutation[i % PERLIN_SIZE];
    }
    permutation.truncate(2 * PERLIN_SIZE + 2);
    Perlin { gradients, permutation }
});

/// Gradients of generator 3, and the permutation that finds them (its first 2048 entries; it repeats).
pub fn perlin_tables() -> (&'static [DVec3], &'static [usize]) {
    (&PERLIN.gradients, &PERLIN.permutation)
}

fn perlin(p: DVec3) -> f64 {
    let table = &*PERLIN;
    let p = p + DVec3::splat(10_000_000.023_157_213);
    // Not f64::floor, a call into the library without SSE4.1.
    let cell = |x: f64| {
        let i = x as i64;
        if (i as f64) > x { i - 1 } else { i }
    };
    let (ix, iy, iz) = (cell(p.x), cell(p.y), cell(p.z));
    let r = p - DVec3::new(ix as f64, iy as f64, iz as f64);
    let wrap = |i: i64| (i & (PERLIN_SIZE as i64 - 1)) as usize;
    let (bx, by, bz) = (wrap(ix), wrap(iy), wrap(iz));
    let wrap1 = |i: usize| (i + 1) & (PERLIN_SIZE - 1);
    let pm = |i: usize| table.permutation[i];
    let at = |cx: usize, cy: usize, cz: usize, d: DVec3| table.gradients[(pm(pm(cx) + cy) + cz) & (PERLIN_SIZE - 1)].dot(d);
    let (x1, y1, z1) = (wrap1(bx), wrap1(by), wrap1(bz));
    let (sx, sy, sz) = (s_curve(r.x), s_curve(r.y), s_curve(r.z));
    let lerp = |t: f64, a: f64, b: f64| a + t * (b - a);
    let row = |cy: usize, cz: usize, dy: f64, dz: f64| {
        lerp(sx, at(bx, cy, cz, DVec3::new(r.x, r.y - dy, r.z - dz)), at(x1, cy, cz, DVec3::new(r.x - 1.0, r.y - dy, r.z - dz)))
    };
    let low = lerp(sy, row(by, bz, 0.0, 0.0), row(y1, bz, 1.0, 0.0));
    let high = lerp(sy, row(by, z1, 0.0, 1.0), row(y1, z1, 1.0, 1.0));
    (0.5 * (1.59 * lerp(sz, low, high) + 0.985)).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vector_turbulence_is_povrays() {
        // Measured: vturbulence(2, .5, 6, <1.5, 2.5, 3.5>), spec/language.md section 3.3.
        let v = turbulence_vector(DVec3::new(1.5, 2.5, 3.5), 6, 0.5, 2.0);
        assert!((v - DVec3::new(0.069_575_83, -0.038_919_14, 0.025_032_82)).abs().max_element() < 1e-5, "{v}");
    }

    #[test]
    fn noise_stays_in_its_range() {
        for i in 0..2000 {
            let p = DVec3::new(f64::from(i) * 0.371 - 300.0, f64::from(i) * -0.173, f64::from(i * i % 97) * 0.11);
            for generator in 1..=3 {
                let n = noise(p, generator);
                assert!((0.0..=1.0).contains(&n));
            }
        }
    }
}
