//! Places of samples inside a pixel, for imports: low-discrepancy points, moved by a different amount in every pixel.

/// Where sample `index` of the pixel at (x, y) lies: an offset from the pixel's centre, each coordinate within ±0.5 (box filter).
///
/// The first n samples of a pixel are well spread for every n, so ranges of samples may be rendered apart and joined.
/// Source: Roberts 2018, the R2 sequence; shifts are hashed (Cranley and Patterson 1976).
pub fn sample_position(x: u32, y: u32, index: u32, seed: u32) -> (f64, f64) {
    const PLASTIC: f64 = 1.324_717_957_244_746;
    let shift = |salt: u32| f64::from(hash(x ^ hash(y ^ hash(seed ^ salt)))) / 4_294_967_296.0;
    let n = f64::from(index);
    let at = |step: f64, salt: u32| (shift(salt) + n * step).fract() - 0.5;
    (at(1.0 / PLASTIC, 0x68bc_21eb), at(1.0 / (PLASTIC * PLASTIC), 0x02e5_be93))
}

/// A 32-bit mix. Source: Wellons 2018, lowbias32.
pub fn hash(mut v: u32) -> u32 {
    v ^= v >> 16;
    v = v.wrapping_mul(0x7feb_352d);
    v ^= v >> 15;
    v = v.wrapping_mul(0x846c_a68b);
    v ^ (v >> 16)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_fill_the_pixel_evenly() {
        let mut cells = [0u32; 16];
        for k in 0..64 {
            let (dx, dy) = sample_position(3, 7, k, 1);
            cells[((dx + 0.5) * 4.0) as usize * 4 + ((dy + 0.5) * 4.0) as usize] += 1;
        }
        assert!(cells.iter().all(|n| (2..=6).contains(n)), "{cells:?}");
    }
}
