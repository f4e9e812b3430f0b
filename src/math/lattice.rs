//! Gradient noise on POV-Ray's lattice of random numbers: where a point lies, and the sums over the corners of its cell.
//!
//! Two twins give the same numbers to the last bit: plain code here, AVX2 and AVX-512 in `math/simd`. Both fuse the same products and sums;
//! where the processor cannot, the library does, slowly. Generators, clamping and octaves: `math/noise`.
//! Source: FACTS.md section 2 and spec/textures.md section 0; the 267 lattice numbers were measured ([`NOISE_TABLE`]).

use super::random::HASH;
use super::{DVec3, EPSILON};

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

/// The least share of a cell that a negative point is moved by before its cell is cut off; below [`EPSILON`] it counts as the cell above.
pub(super) const DOWN: f64 = 1.0 - EPSILON;
/// Added to cell numbers, which then count from 0 to [`CELL_MASK`].
pub(super) const CELL_BIAS: i32 = 10_000;
/// The lattice repeats after so many cells, less one.
pub(super) const CELL_MASK: i32 = 0xFFF;

/// [`HASH`] for any 16-bit index: no index needs a check or a mask.
static HASH_16: [u16; 1 << 16] = {
    let mut t = [0u16; 1 << 16];
    let mut i = 0;
    while i < t.len() {
        t[i] = HASH[i % HASH.len()];
        i += 1;
    }
    t
};

/// Rows of the lattice by 16-bit index: [`HASH`] modulo 256.
static ROW_16: [u8; 1 << 16] = {
    let mut t = [0u8; 1 << 16];
    let mut i = 0;
    while i < t.len() {
        t[i] = HASH[i % HASH.len()] as u8;
        i += 1;
    }
    t
};

/// Rows of the eight corners of cell (x, y, z), each 0..=[`CELL_MASK`]; x changes first, z last.
#[inline(always)]
pub(super) fn corner_rows(cell: [u16; 3]) -> [usize; 8] {
    // Masked, so that the compiler sees that no sum or difference leaves 16 bits.
    let [x, y, z] = cell.map(|i| usize::from(i) & CELL_MASK as usize);
    let hash = |i: usize| usize::from(HASH_16[i]);
    let row = |i: usize| usize::from(ROW_16[i]);
    let (x0, x1) = (hash(x), hash(x + 1));
    let (y1, z1) = (y + 1, z + 1);
    let (a, b, c, d) = (hash(x0 ^ y), hash(x1 ^ y), hash(x0 ^ y1), hash(x1 ^ y1));
    [row(a ^ z), row(b ^ z), row(c ^ z), row(d ^ z), row(a ^ z1), row(b ^ z1), row(c ^ z1), row(d ^ z1)]
}

/// Value and gradient at a corner, the value halved: one aligned load.
#[derive(Clone, Copy)]
#[repr(align(32))]
pub(super) struct Row(pub [f64; 4]);

/// Rows of scalar noise: four neighbours of [`NOISE_TABLE`].
pub(super) static ROWS: [Row; 256] = {
    let mut rows = [Row([0.0; 4]); 256];
    let mut k = 0;
    while k < 256 {
        rows[k].0 = row_at(k);
        k += 1;
    }
    rows
};

/// Two rows of four numbers side by side.
#[derive(Clone, Copy)]
#[repr(align(64))]
pub(super) struct WideRow(pub [f64; 8]);

/// Rows of vector noise, three scalar rows that lie four apart, each number for three components: values and slopes along x, then slopes
/// along y and z.
pub(super) static VECTOR_ROWS: [[WideRow; 2]; 256] = {
    let mut rows = [[WideRow([0.0; 8]); 2]; 256];
    let mut k = 0;
    while k < 256 {
        let mut component = 0;
        while component < 3 {
            let row = row_at(k + 4 * component);
            let mut part = 0;
            while part < 4 {
                rows[k][part / 2].0[part % 2 * 4 + component] = row[part];
                part += 1;
            }
            component += 1;
        }
        k += 1;
    }
    rows
};

const fn row_at(k: usize) -> [f64; 4] {
    [0.5 * NOISE_TABLE[k], NOISE_TABLE[k + 1], NOISE_TABLE[k + 2], NOISE_TABLE[k + 3]]
}

/// The lattice cell of a point on one axis, and the place inside it. Beyond 32 bits the cell is the processor's: the least number.
#[inline(always)]
fn cell(x: f64) -> (u16, f64) {
    let moved = if x >= 0.0 { x } else { x - DOWN };
    let i = if moved.abs() < 2_147_483_648.0 { moved as i32 } else { i32::MIN };
    ((i.wrapping_add(CELL_BIAS) & CELL_MASK) as u16, x - f64::from(i))
}

#[inline(always)]
pub(super) fn s_curve(t: f64) -> f64 {
    t * t * (3.0 - 2.0 * t)
}

/// The eight corners of a point's cell; then the place inside the cell and its s-curve.
struct Corners {
    rows: [usize; 8],
    place: [f64; 3],
    share: [f64; 3],
}

#[inline(always)]
fn corners(p: DVec3) -> Corners {
    let ((ix, x), (iy, y), (iz, z)) = (cell(p.x), cell(p.y), cell(p.z));
    Corners { rows: corner_rows([ix, iy, iz]), place: [x, y, z], share: [s_curve(x), s_curve(y), s_curve(z)] }
}

/// A mix as the processor's fused instruction has it.
#[inline(always)]
fn mix(t: f64, a: f64, b: f64) -> f64 {
    t.mul_add(b - a, a)
}

/// The corners' numbers mixed along x, y and z; x changes first.
#[inline(always)]
fn mixed([sx, sy, sz]: [f64; 3], at: impl Fn(usize) -> f64) -> f64 {
    let low = mix(sy, mix(sx, at(0), at(1)), mix(sx, at(2), at(3)));
    let high = mix(sy, mix(sx, at(4), at(5)), mix(sx, at(6), at(7)));
    mix(sz, low, high)
}

/// The way from corner `k` to the place inside the cell.
#[inline(always)]
fn from_corner([x, y, z]: [f64; 3], k: usize) -> [f64; 3] {
    let [x1, y1, z1] = [x - 1.0, y - 1.0, z - 1.0];
    [if k & 1 == 0 { x } else { x1 }, if k & 2 == 0 { y } else { y1 }, if k & 4 == 0 { z } else { z1 }]
}

/// The lattice's value at a point, neither clamped nor biased: the four numbers of the corners' planes are mixed by themselves, then
/// added. Twin: `math/simd`.
#[inline]
pub(super) fn scalar(p: DVec3) -> f64 {
    let c = corners(p);
    let part = |j: usize| {
        mixed(c.share, |k| {
            let v = ROWS[c.rows[k] & 255].0[j];
            if j == 0 { v } else { v * from_corner(c.place, k)[j - 1] }
        })
    };
    (part(0) + part(2)) + (part(1) + part(3))
}

/// Three values of the lattice at a point, by halves: value and slope along y, slopes along x and z. Twin: `math/simd`.
#[inline]
pub(super) fn vector(p: DVec3) -> DVec3 {
    let c = corners(p);
    let component = |j: usize| {
        let half = |h: usize| {
            mixed(c.share, |k| {
                let ([va, bc], [x, y, z]) = (&VECTOR_ROWS[c.rows[k] & 255], from_corner(c.place, k));
                let at = 4 * h + j;
                if h == 0 { bc.0[at].mul_add(y, va.0[at]) } else { bc.0[at].mul_add(z, va.0[at] * x) }
            })
        };
        half(0) + half(1)
    };
    DVec3::new(component(0), component(1), component(2))
}
