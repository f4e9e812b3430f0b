//! Owen-scrambled Sobol points, keyed by (seed, sample, dimension): any range of samples can be drawn by itself, any prefix is well spread.
//!
//! Points come in sets of four dimensions. Sets are made independent by shuffling the sample's index and scrambling the values by hashes.
//! Source: Sobol 1967; direction numbers by Joe and Kuo 2008; Burley 2020, "Practical Hash-based Owen Scrambling".

use std::sync::LazyLock;

/// Degree, inner coefficients and first direction numbers of the second to fourth dimension; the first is van der Corput's.
const POLYNOMIALS: [(usize, u32, [u32; 3]); 3] = [(1, 0, [1, 0, 0]), (2, 1, [1, 3, 0]), (3, 1, [1, 3, 1])];

/// Values of the four dimensions, bits reversed, by byte of the index: `TABLE[byte][value]`.
static TABLE: LazyLock<Box<[[[u32; 4]; 256]; 4]>> = LazyLock::new(|| {
    let v = directions();
    let mut table = Box::new([[[0u32; 4]; 256]; 4]);
    for byte in 0..4 {
        for value in 0..256 {
            for bit in (0..8).filter(|b| value >> b & 1 == 1) {
                (0..4).for_each(|d| table[byte][value][d] ^= v[d][8 * byte + bit]);
            }
        }
    }
    table
});

/// Direction numbers by dimension and bit of the index, bits reversed (first digit lowest).
fn directions() -> [[u32; 32]; 4] {
    let mut all = [[0u32; 32]; 4];
    all[0] = std::array::from_fn(|k| 1 << k);
    for (d, (degree, inner, first)) in POLYNOMIALS.iter().enumerate() {
        let mut m = [0u64; 32];
        for k in 0..32 {
            m[k] = if k < *degree {
                u64::from(first[k])
            } else {
                let mut v = m[k - degree] ^ (m[k - degree] << degree);
                for i in 1..*degree {
                    v ^= u64::from(inner >> (degree - 1 - i) & 1) * (m[k - i] << i);
                }
                v
            };
            // m[k] / 2^(k+1) as a fraction of 32 bits.
            all[d + 1][k] = ((m[k] << (31 - k)) as u32).reverse_bits();
        }
    }
    all
}

/// What [`sobol4`] looks up, for other machines: values of the four dimensions, bits reversed, `[byte of the index][value]`.
pub fn direction_table() -> &'static [[[u32; 4]; 256]; 4] {
    &TABLE
}

/// A permutation of reversed bits in which a bit depends on lower ones alone. Source: Laine and Karras 2011; constants of Burley 2020.
#[inline]
fn scramble(mut v: u32, seed: u32) -> u32 {
    v ^= v.wrapping_mul(0x3d20_adea);
    v = v.wrapping_add(seed);
    v = v.wrapping_mul((seed >> 16) | 1);
    v ^= v.wrapping_mul(0x0552_6c56);
    v ^ v.wrapping_mul(0x53a2_2864)
}

/// A 32-bit mix. Source: Wellons 2018, lowbias32.
#[inline]
pub fn hash(mut v: u32) -> u32 {
    v ^= v >> 16;
    v = v.wrapping_mul(0x7feb_352d);
    v ^= v >> 15;
    v = v.wrapping_mul(0x846c_a68b);
    v ^ (v >> 16)
}

/// Two mixed into one.
#[inline]
pub fn hash2(a: u32, b: u32) -> u32 {
    hash(a ^ hash(b).wrapping_add(0x9e37_79b9))
}

/// A number in 0..1 of 32 random bits; never 1.
#[inline]
pub fn unit_f32(bits: u32) -> f32 {
    (bits >> 8) as f32 * (1.0 / 16_777_216.0)
}

/// Set `set` of sample `index` of the sequence that `seed` picks: four numbers in 0..1.
#[inline]
pub fn sobol4(seed: u32, index: u32, set: u32) -> [f32; 4] {
    let seed = hash2(seed, set);
    // Bits of the index are reversed for the shuffle and back.
    let index = scramble(index.reverse_bits(), seed).reverse_bits();
    let t = &*TABLE;
    let [a, b, c, d] = index.to_le_bytes().map(usize::from);
    let (a, b, c, d) = (&t[0][a], &t[1][b], &t[2][c], &t[3][d]);
    // Loops over all four, step by step: compilers make vectors of them.
    let mut seeds = [0u32; 4];
    let mut v = [0u32; 4];
    for k in 0..4 {
        seeds[k] = hash(seed ^ (k as u32 + 1).wrapping_mul(0x85eb_ca6b));
    }
    for k in 0..4 {
        v[k] = scramble(a[k] ^ b[k] ^ c[k] ^ d[k], seeds[k]);
    }
    let mut out = [0.0; 4];
    for k in 0..4 {
        out[k] = unit_f32(v[k].reverse_bits());
    }
    out
}

/// Plain random numbers for chains without a bounded number of draws (walks in volumes). Source: O'Neill 2014, PCG-RXS-M-XS-32.
#[derive(Clone, Copy, Debug)]
pub struct Pcg(u32);

impl Pcg {
    /// A stream.
    pub fn new(seed: u32) -> Self {
        Self(hash(seed))
    }

    /// 0..1.
    #[inline]
    pub fn draw(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        let w = ((self.0 >> ((self.0 >> 28) + 4)) ^ self.0).wrapping_mul(277_803_737);
        unit_f32((w >> 22) ^ w)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_power_of_two_prefix_is_stratified_in_each_dimension_and_pair() {
        for set in 0..8 {
            let points: Vec<[f32; 4]> = (0..256).map(|k| sobol4(17, k, set)).collect();
            for d in 0..4 {
                let mut seen = [false; 256];
                points.iter().for_each(|p| seen[(p[d] * 256.0) as usize] = true);
                assert!(seen.iter().all(|s| *s), "set {set}, dimension {d}");
            }
            // The first two dimensions are a (0, 2)-sequence: one point in each cell of 16 x 16.
            let mut seen = [false; 256];
            points.iter().for_each(|p| seen[(p[0] * 16.0) as usize * 16 + (p[1] * 16.0) as usize] = true);
            assert!(seen.iter().all(|s| *s), "set {set}");
        }
    }

    #[test]
    fn sets_and_seeds_are_uncorrelated() {
        let n = 4096;
        for (a, b) in [((1, 0), (1, 1)), ((1, 0), (2, 0)), ((5, 3), (6, 3))] {
            let mut sum = 0.0;
            for k in 0..n {
                sum += (sobol4(a.0, k, a.1)[0] - 0.5) * (sobol4(b.0, k, b.1)[0] - 0.5);
            }
            let correlation = sum / n as f32 * 12.0;
            assert!(correlation.abs() < 0.06, "{correlation}");
        }
    }
}
