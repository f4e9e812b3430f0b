//! POV-Ray's random sources, number for number: the Mersenne Twister table, the hash table of noise, the grain generator,
//! Halton points and the pixel jitter. Source: spec/light.md, sections 0, 11 and 12. Beside them a small stream of our own for
//! measurements and tests.
//!
//! Streams here are tied to an order of calls; counter-based random numbers for path tracing stand elsewhere.

use super::DVec3;
use std::sync::LazyLock;

/// Entries of the table of uniform numbers.
pub const UNIFORM_TABLE_LEN: usize = 32_768;

/// A small stream for measurements and tests, good from any seed.
///
/// Source: Steele, Lea and Flood 2014, "Fast splittable pseudorandom number generators".
#[derive(Clone, Debug)]
pub struct SplitMix64(pub u64);

impl SplitMix64 {
    /// 64 bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// In 0..1.
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// In `0..n`.
    pub fn below(&mut self, n: usize) -> usize {
        (self.bits() % n as u64) as usize
    }

    /// In -1..1 on every axis.
    pub fn cube(&mut self) -> DVec3 {
        DVec3::new(self.unit(), self.unit(), self.unit()) * 2.0 - 1.0
    }

    /// A unit vector, all directions alike.
    pub fn direction(&mut self) -> DVec3 {
        let (z, a) = (1.0 - 2.0 * self.unit(), std::f64::consts::TAU * self.unit());
        let r = (1.0 - z * z).max(0.0).sqrt();
        DVec3::new(r * a.cos(), r * a.sin(), z)
    }
}

/// The classic 32-bit Mersenne Twister.
///
/// Source: Matsumoto and Nishimura 1998, "Mersenne Twister", with the initialisation of 2002.
pub struct Mt19937 {
    state: [u32; 624],
    index: usize,
}

impl Mt19937 {
    /// The generator for a seed.
    pub fn new(seed: u32) -> Self {
        let mut state = [0u32; 624];
        state[0] = seed;
        for i in 1..624 {
            let last = state[i - 1];
            state[i] = 1_812_433_253u32.wrapping_mul(last ^ (last >> 30)).wrapping_add(i as u32);
        }
        Self { state, index: 624 }
    }

    /// The next 32 bits.
    pub fn next_u32(&mut self) -> u32 {
        if self.index == 624 {
            for i in 0..624 {
                let y = (self.state[i] & 0x8000_0000) | (self.state[(i + 1) % 624] & 0x7fff_ffff);
                self.state[i] = self.state[(i + 397) % 624] ^ (y >> 1) ^ if y & 1 == 1 { 0x9908_b0df } else { 0 };
            }
            self.index = 0;
        }
        let mut y = self.state[self.index];
        self.index += 1;
        y ^= y >> 11;
        y ^= (y << 7) & 0x9d2c_5680;
        y ^= (y << 15) & 0xefc6_0000;
        y ^ (y >> 18)
    }
}

static UNIFORM: LazyLock<Box<[f64]>> = LazyLock::new(|| {
    let mut mt = Mt19937::new(5489);
    (0..UNIFORM_TABLE_LEN).map(|_| f64::from(mt.next_u32()) / 4_294_967_296.0).collect()
});

/// The 32,768 uniform numbers in 0..1 that all of POV-Ray's table streams walk through; patterns index it too.
pub fn uniform_table() -> &'static [f64] {
    &UNIFORM
}

/// A cyclic walk through [`uniform_table`]; the first number delivered is entry 1.
#[derive(Clone, Copy, Debug, Default)]
pub struct UniformStream {
    index: u32,
}

impl UniformStream {
    /// A walk that starts anywhere in the table.
    pub fn seeded(seeds: &mut SplitMix64) -> Self {
        Self { index: seeds.below(UNIFORM_TABLE_LEN) as u32 }
    }

    /// The next number, 0..1.
    #[inline]
    pub fn draw(&mut self) -> f64 {
        self.index = (self.index + 1) % UNIFORM_TABLE_LEN as u32;
        UNIFORM[self.index as usize]
    }
}

/// POV-Ray's linear congruential step, used by `rand()` of the language, grain and the noise tables.
#[inline]
pub const fn lcg_step(state: u32) -> u32 {
    state.wrapping_mul(1_812_433_253).wrapping_add(12_345)
}

/// The generator of `crand` grain: starts at 0.
#[derive(Clone, Copy, Debug, Default)]
pub struct GrainStream {
    state: u32,
}

impl GrainStream {
    /// A generator in any state.
    pub fn seeded(seeds: &mut SplitMix64) -> Self {
        Self { state: seeds.bits() as u32 }
    }

    /// The next number, 0..=1.
    #[inline]
    pub fn draw(&mut self) -> f64 {
        self.state = lcg_step(self.state);
        f64::from(self.state) / 4_294_967_295.0
    }
}

/// Entries of [`HASH`].
pub const HASH_LEN: usize = 8192;

const fn make_hash() -> [u16; HASH_LEN] {
    let mut h = [0u16; HASH_LEN];
    let mut i = 0;
    while i < HASH_LEN / 2 {
        h[i] = i as u16;
        i += 1;
    }
    let mut r = 0u32;
    while i > 0 {
        i -= 1;
        r = lcg_step(r);
        let j = ((r >> 16) & 0x7fff) as usize % (HASH_LEN / 2);
        let t = h[i];
        h[i] = h[j];
        h[j] = t;
    }
    while i < HASH_LEN / 2 {
        h[i + HASH_LEN / 2] = h[i];
        i += 1;
    }
    h
}

/// The permutation of 0..4096 behind POV-Ray's noise, written twice in a row.
pub static HASH: [u16; HASH_LEN] = make_hash();

/// [`HASH`] as a slice.
pub fn hash_table() -> &'static [u16] {
    &HASH
}

/// The hash of three integers that cells, crackle and facets share: 0..4096.
#[inline]
pub fn hash3(i: i64, j: i64, k: i64) -> usize {
    let h = |n: usize| usize::from(HASH[n & (HASH_LEN - 1)]);
    h(h(h((i & 4095) as usize) ^ (j & 4095) as usize) ^ (k & 4095) as usize)
}

/// Element `i` (from 0) of the Halton sequence of a prime base: the radical inverse of `i + 1`.
pub fn halton(i: u32, base: u32) -> f64 {
    let (mut n, mut scale, mut sum) = (u64::from(i) + 1, 1.0, 0.0);
    while n > 0 {
        scale /= f64::from(base);
        sum += scale * (n % u64::from(base)) as f64;
        n /= u64::from(base);
    }
    sum
}

static JITTER: LazyLock<[f64; 256]> = LazyLock::new(|| {
    std::array::from_fn(|i| {
        let i = i as u32;
        let parity = |v: u32| f64::from(v.count_ones() & 1);
        let v = -0.5 + f64::from((i ^ (2 * i)) & 255) / 512.0 + parity(i & 127) / 2.0 + parity(i) / 32_768.0;
        (v * 1e6).round() / 1e6
    })
});

/// The numbers that [`pixel_jitter`] chooses from.
pub fn jitter_table() -> &'static [f64; 256] {
    &JITTER
}

/// The jitter pair that POV-Ray gives position (x, y), each in -0.5..0.5. A fixed function of position.
pub fn pixel_jitter(x: f64, y: f64) -> (f64, f64) {
    let h = |n: i64| i64::from(HASH[(n & 4095) as usize]);
    // `as` truncates toward zero; the mask then takes the two's complement.
    let at = |a: f64, b: f64| JITTER[(h(h((a * x) as i64) ^ (b * y) as i64) & 255) as usize];
    (at(1021.0, 1019.0), at(1019.0, 1021.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uniform_stream_skips_entry_zero() {
        assert!((uniform_table()[0] - 0.814_723_7).abs() < 1e-7);
        assert!((UniformStream::default().draw() - 0.135_477_0).abs() < 1e-7);
    }

    #[test]
    fn uniform_stream_comes_back_to_entry_zero_after_the_whole_table() {
        let mut s = UniformStream::default();
        let all: Vec<f64> = (0..UNIFORM_TABLE_LEN).map(|_| s.draw()).collect();
        assert_eq!(all[UNIFORM_TABLE_LEN - 1], uniform_table()[0]);
    }

    #[test]
    fn hash_table_is_a_permutation_twice() {
        let mut sorted = hash_table()[..4096].to_vec();
        sorted.sort_unstable();
        assert!(sorted.iter().enumerate().all(|(i, v)| i == *v as usize));
        assert_eq!(hash_table()[..4096], hash_table()[4096..]);
    }

    #[test]
    fn halton_is_the_radical_inverse_of_the_next_integer() {
        assert_eq!([0, 1, 2, 3].map(|i| halton(i, 2)), [0.5, 0.25, 0.75, 0.125]);
        assert!((halton(3, 3) - (1.0 / 9.0 + 1.0 / 3.0)).abs() < 1e-15);
    }

    #[test]
    fn jitter_stays_within_half_a_cell() {
        for k in 0..1000 {
            let (x, y) = pixel_jitter(f64::from(k) * 0.37 - 3.0, f64::from(k) * 0.11 - 2.0);
            assert!(x.abs() <= 0.5 && y.abs() <= 0.5);
        }
    }
}
