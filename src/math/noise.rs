//! POV-Ray's noise: three scalar generators, the vector noise, and turbulence.
//!
//! Source: FACTS.md section 2 and spec/textures.md section 0; the 267 lattice numbers were measured (`NOISE_TABLE`).

use super::random::{HASH, HASH_LEN, lcg_step};
use super::{DVec3, EPSILON};
use std::sync::LazyLock;

/// Numbers at the lattice points, recovered by measurement of the installed program's `f_noise_generator` and `vturbulence`.
#[rustfmt::skip]
pub const NOISE_TABLE: [f64; 267] = [
    -1.0, 0.604974, -0.937102, 0.414115, 0.576226, -0.0161593, 0.432334, 0.103685, 0.590539, 0.0286412, 0.46981, -0.84622,
    -0.0734112, -0.304097, -0.40206, -0.210132, -0.919127, 0.652033, -0.83151, -0.183948, -0.671107, 0.852476, 0.043595, -0.404532,
    0.75494, -0.335653, 0.618433, 0.605707, 0.708583, -0.477195, 0.899474, 0.490623, 0.221729, -0.400381, -0.853727, -0.932586,
    0.659113, 0.961303, 0.325948, -0.750851, 0.842466, 0.734401, -0.649866, 0.394491, -0.466056, -0.434073, 0.109026, 0.0847028,
    -0.738857, 0.241505, 0.16228, -0.71426, -0.883665, -0.150408, -0.90396, -0.686549, -0.785214, 0.488548, 0.0246433, 0.142473,
    -0.602136, 0.375845, -0.00779736, 0.498955, -0.268147, 0.856382, -0.386007, -0.596094, -0.867735, -0.570977, -0.914366, 0.28896,
    0.672206, -0.233783, 0.94815, 0.895262, 0.343252, -0.173388, -0.767971, -0.314748, 0.824308, -0.342092, 0.721431, -0.24004,
    -0.63653, 0.553277, 0.376272, 0.158984, -0.452659, 0.396323, -0.420676, -0.454154, 0.122179, 0.295857, 0.0664225, -0.202075,
    -0.724788, 0.453513, 0.224567, -0.908812, 0.176349, -0.320516, -0.697139, 0.742702, -0.900786, 0.471489, -0.133532, 0.119127,
    -0.889769, -0.23183, -0.669673, -0.046891, -0.803433, -0.966735, 0.475578, -0.652644, 0.0112459, -0.730007, 0.128283, 0.145647,
    -0.619318, 0.272023, 0.392966, 0.646418, -0.0207675, -0.315908, 0.480797, 0.535668, -0.250172, -0.83093, -0.653773, -0.443809,
    0.119982, -0.897642, 0.89453, 0.165789, 0.633875, -0.886839, 0.930877, -0.537194, 0.587732, 0.722011, -0.209461, -0.0424659,
    -0.814267, -0.919432, 0.280262, -0.66302, -0.558099, -0.537469, -0.598779, 0.929656, -0.170794, -0.537163, 0.312581, 0.959442,
    0.722652, 0.499931, 0.175616, -0.534874, -0.685115, 0.444999, 0.17171, 0.108202, -0.768704, -0.463828, 0.254231, 0.546014,
    0.869474, 0.875212, -0.944427, 0.130724, -0.110185, 0.312184, -0.33138, -0.629206, 0.0606546, 0.722866, -0.0979477, 0.821561,
    0.0931258, -0.972808, 0.0318151, -0.867033, -0.387228, 0.280995, -0.218189, -0.539178, -0.427359, -0.602075, 0.311971, 0.277974,
    0.773159, 0.592493, -0.0331884, -0.630854, -0.269947, 0.339132, 0.581079, 0.209461, -0.317433, -0.284993, 0.181323, 0.341634,
    0.804959, -0.229572, -0.758907, -0.336721, 0.605463, -0.991272, -0.0188754, -0.300191, 0.368307, -0.176135, -0.3832, -0.749569,
    0.62356, -0.573938, 0.278309, -0.971313, 0.839994, -0.830686, 0.439078, 0.66128, 0.694514, 0.0565042, 0.54342, -0.438804,
    -0.0228428, -0.687068, 0.857267, 0.301991, -0.494255, -0.941039, 0.775509, 0.410575, -0.362081, -0.671534, -0.348379, 0.932433,
    0.886442, 0.868681, -0.225666, -0.062211, -0.0976425, -0.641444, -0.848112, 0.724697, 0.473503, 0.998749, 0.174701, 0.559625,
    -0.029099, -0.337392, -0.958129, -0.659785, 0.236042, -0.246937, 0.659449, -0.027512, 0.821897, -0.226215, 0.0181735, 0.500481,
    -0.420127, -0.427878, 0.566186,
];

/// The lattice cell of a point on one axis, and the place inside it.
#[inline(always)]
fn cell(x: f64) -> (i32, f64) {
    let i = (if x >= 0.0 { x } else { x - (1.0 - EPSILON) }) as i32;
    (i, x - f64::from(i))
}

#[inline(always)]
fn s_curve(t: f64) -> f64 {
    t * t * (3.0 - 2.0 * t)
}

/// The eight corners of a point's cell: row of the table (before masking); then the place inside the cell and its s-curve.
struct Corners {
    key: [usize; 8],
    place: [f64; 3],
    share: [f64; 3],
}

#[inline(always)]
fn corners(p: DVec3) -> Corners {
    let ((ix, dx), (iy, dy), (iz, dz)) = (cell(p.x), cell(p.y), cell(p.z));
    let wrap = |i: i32| (i.wrapping_add(10_000) & 0xFFF) as usize;
    let (ix, iy, iz) = (wrap(ix), wrap(iy), wrap(iz));
    // Two neighbours an axis; the table is doubled, so +1 needs no wrap.
    let at = |i: usize| usize::from(HASH[i & (HASH_LEN - 1)]);
    let (x0, x1) = (at(ix), at(ix + 1));
    let (y00, y10, y01, y11) = (at(x0 ^ iy), at(x1 ^ iy), at(x0 ^ (iy + 1)), at(x1 ^ (iy + 1)));
    let up = iz + 1;
    let key = [at(y00 ^ iz), at(y10 ^ iz), at(y01 ^ iz), at(y11 ^ iz), at(y00 ^ up), at(y10 ^ up), at(y01 ^ up), at(y11 ^ up)];
    Corners { key, place: [dx, dy, dz], share: [s_curve(dx), s_curve(dy), s_curve(dz)] }
}

/// Rows of four neighbours of [`NOISE_TABLE`], the first halved: one load a corner.
static LATTICE: [[f64; 4]; 264] = {
    let mut rows = [[0.0; 4]; 264];
    let mut k = 0;
    while k < 264 {
        rows[k] = [0.5 * NOISE_TABLE[k], NOISE_TABLE[k + 1], NOISE_TABLE[k + 2], NOISE_TABLE[k + 3]];
        k += 1;
    }
    rows
};

/// `OFFSET` is a constant so that every index is seen to be inside the table.
///
/// Seven plain mixes, not eight weights: the compiler makes vectors of sums of weights, which takes twice as long (measured, opt-level 3).
#[inline(always)]
fn lattice_sum<const OFFSET: usize>(c: &Corners) -> f64 {
    let ([x, y, z], [sx, sy, sz]) = (c.place, c.share);
    let (x1, y1, z1) = (x - 1.0, y - 1.0, z - 1.0);
    let at = |i: usize, x: f64, y: f64, z: f64| {
        let row = &LATTICE[(c.key[i] & 255) + OFFSET];
        row[0] + row[1] * x + row[2] * y + row[3] * z
    };
    let mix = |t: f64, a: f64, b: f64| a + t * (b - a);
    let low = mix(sy, mix(sx, at(0, x, y, z), at(1, x1, y, z)), mix(sx, at(2, x, y1, z), at(3, x1, y1, z)));
    let high = mix(sy, mix(sx, at(4, x, y, z1), at(5, x1, y, z1)), mix(sx, at(6, x, y1, z1), at(7, x1, y1, z1)));
    mix(sz, low, high)
}

/// Noise in 0..=1 by generator 1 (original), 2 (range corrected) or 3 (Perlin).
pub fn noise(p: DVec3, generator: u8) -> f64 {
    match generator {
        0 | 1 => (lattice_sum::<0>(&corners(p)) + 0.5).clamp(0.0, 1.0),
        2 => ((lattice_sum::<0>(&corners(p)) + 1.052_42) * 0.489_855_82).clamp(0.0, 1.0),
        _ => perlin(p),
    }
}

/// Vector noise; the same for every generator, neither clamped nor biased.
pub fn noise_vector(p: DVec3) -> DVec3 {
    let c = corners(p);
    DVec3::new(lattice_sum::<0>(&c), lattice_sum::<4>(&c), lattice_sum::<8>(&c))
}

/// Scalar turbulence. `omega` and `lambda` are 32-bit, as POV-Ray keeps them.
pub fn turbulence(p: DVec3, octaves: u32, omega: f32, lambda: f32, generator: u8) -> f64 {
    let one = |p| if generator > 1 { 2.0 * noise(p, generator) - 0.5 } else { noise(p, generator) };
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
pub fn turbulence_vector(p: DVec3, octaves: u32, omega: f32, lambda: f32) -> DVec3 {
    let (omega, lambda) = (f64::from(omega), f64::from(lambda));
    let mut sum = noise_vector(p);
    let (mut l, mut o) = (lambda, omega);
    for _ in 1..octaves {
        sum += o * noise_vector(p * l);
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
    let f = p.floor();
    let r = p - f;
    let wrap = |x: f64| (x as i64 & (PERLIN_SIZE as i64 - 1)) as usize;
    let (bx, by, bz) = (wrap(f.x), wrap(f.y), wrap(f.z));
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
