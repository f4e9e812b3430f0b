//! What a film holds besides its colours: a layer a pass, and how the values of more samples come to those that are there.

use super::Film;
use crate::scene::pass::{CRYPTO_RANKS, Join, Pass, PassSet};

/// The values of one pass.
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    /// Which.
    pub pass: Pass,
    /// `[height][width][Pass::width]`. Light is radiance, not divided by its colour.
    pub values: Vec<f32>,
}

/// The samples of one pixel, to be joined to a film.
#[derive(Clone, Copy, Debug)]
pub struct PixelSamples<'a> {
    /// Mean of red, green, blue, transmit.
    pub color: [f32; 4],
    /// Values of all layers of the film, one after the other.
    pub layers: &'a [f32],
    /// How many samples.
    pub n: u32,
    /// They come before those that the film has (for values of the first sample).
    pub earlier: bool,
}

impl Film {
    /// A black film with no samples and a layer for each of `passes`.
    pub fn with_passes(width: u32, height: u32, passes: PassSet) -> Self {
        let mut film = Self::new(width, height);
        let layer = |pass: Pass| Layer { pass, values: vec![0.0; film.pixels.len() * pass.width()] };
        film.layers = passes.iter().map(layer).collect();
        film
    }

    /// Numbers a pixel of all layers.
    pub fn layer_width(&self) -> usize {
        self.layers.iter().map(|l| l.pass.width()).sum()
    }

    /// A layer's values.
    pub fn layer(&self, pass: Pass) -> Option<&Layer> {
        self.layers.iter().find(|l| l.pass == pass)
    }

    /// Values of all layers at pixel `at`, one after the other.
    pub fn layers_at(&self, at: usize) -> Vec<f32> {
        self.layers.iter().flat_map(|l| l.at(at).iter().copied()).collect()
    }

    /// Takes all samples out of pixels `first..end` of the arrays.
    pub fn clear(&mut self, range: std::ops::Range<usize>) {
        self.samples[range.clone()].fill(0);
        self.pixels[range.clone()].fill([0.0; 4]);
        for l in &mut self.layers {
            let w = l.pass.width();
            l.values[range.start * w..range.end * w].fill(0.0);
        }
    }

    /// Joins samples to those of pixel `at`.
    pub fn join(&mut self, at: usize, new: PixelSamples) {
        let n_old = self.samples[at];
        let (a, b) = (f64::from(n_old), f64::from(new.n));
        if new.n == 0 {
            return;
        }
        let means = [self.pixels[at], new.color];
        let mut rest = new.layers;
        for l in &mut self.layers {
            let (own, others) = rest.split_at(l.pass.width().min(rest.len()));
            rest = others;
            l.join(at, own, n_old, new.n, means, new.earlier);
        }
        if n_old == 0 {
            self.pixels[at] = new.color;
        } else {
            self.pixels[at] = std::array::from_fn(|c| mean(means[0][c], means[1][c], a, b));
        }
        self.samples[at] = n_old + new.n;
    }
}

/// The mean of `a` values of mean `x` and `b` of mean `y`.
fn mean(x: f32, y: f32, a: f64, b: f64) -> f32 {
    ((f64::from(x) * a + f64::from(y) * b) / (a + b)) as f32
}

impl Layer {
    /// Values of a pixel.
    pub fn at(&self, pixel: usize) -> &[f32] {
        let w = self.pass.width();
        &self.values[pixel * w..(pixel + 1) * w]
    }

    fn join(&mut self, pixel: usize, new: &[f32], n_old: u32, n_new: u32, means: [[f32; 4]; 2], earlier: bool) {
        let w = self.pass.width();
        let own = &mut self.values[pixel * w..(pixel + 1) * w];
        if n_old == 0 {
            own.copy_from_slice(new);
            return;
        }
        let (a, b) = (f64::from(n_old), f64::from(n_new));
        match self.pass.join() {
            Join::Count => {}
            Join::First if earlier => own.copy_from_slice(new),
            Join::First => {}
            Join::Mean => own.iter_mut().zip(new).for_each(|(x, y)| *x = mean(*x, *y, a, b)),
            Join::Variance => {
                // Source: Chan, Golub and LeVeque 1979.
                for (c, (x, y)) in own.iter_mut().zip(new).enumerate() {
                    let apart = f64::from(means[1][c]) - f64::from(means[0][c]);
                    let squares = (a - 1.0) * f64::from(*x) + (b - 1.0) * f64::from(*y) + apart * apart * a * b / (a + b);
                    *x = (squares / (a + b - 1.0)) as f32;
                }
            }
            Join::Crypto => {
                let mut all: Vec<(u32, f64)> = Vec::with_capacity(2 * CRYPTO_RANKS);
                for (values, n) in [(&*own, a), (new, b)] {
                    for pair in values.chunks(2).filter(|p| p[1] > 0.0) {
                        add_share(&mut all, pair[0].to_bits(), f64::from(pair[1]) * n / (a + b));
                    }
                }
                write_ranks(&mut all, own);
            }
        }
    }
}

/// Adds to the share of a name.
pub fn add_share(shares: &mut Vec<(u32, f64)>, id: u32, share: f64) {
    match shares.iter_mut().find(|s| s.0 == id) {
        Some(s) => s.1 += share,
        None => shares.push((id, share)),
    }
}

/// Writes the largest shares as pairs of hash and share; of equal ones the smaller hash first.
pub fn write_ranks(shares: &mut [(u32, f64)], out: &mut [f32]) {
    shares.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    out.fill(0.0);
    for (pair, (id, share)) in out.chunks_mut(2).zip(shares.iter()) {
        pair.copy_from_slice(&[f32::from_bits(*id), *share as f32]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn joined(pass: Pass, parts: &[(&[f32], [f32; 4], u32)]) -> Vec<f32> {
        let mut film = Film::with_passes(1, 1, PassSet::NONE.with(pass));
        for (layers, color, n) in parts {
            film.join(0, PixelSamples { color: *color, layers, n: *n, earlier: false });
        }
        film.layers_at(0)
    }

    #[test]
    fn means_are_weighed_and_first_values_stay() {
        let c = [0.0; 4];
        assert_eq!(joined(Pass::Normal, &[(&[0.0, 0.0, 1.0], c, 1), (&[1.0, 0.0, 0.0], c, 3)]), [0.75, 0.0, 0.25]);
        assert_eq!(joined(Pass::Depth, &[(&[5.0], c, 1), (&[9.0], c, 3)]), [5.0]);
    }

    #[test]
    fn variances_join_to_that_of_all_samples() {
        let samples = [1.0f32, 4.0, 2.0, 8.0, 5.0, 7.0, 3.0];
        let part = |s: &[f32]| {
            let n = s.len() as f32;
            let m = s.iter().sum::<f32>() / n;
            (s.iter().map(|x| (x - m) * (x - m)).sum::<f32>() / (n - 1.0), m)
        };
        let (whole, _) = part(&samples);
        let ((v0, m0), (v1, m1)) = (part(&samples[..3]), part(&samples[3..]));
        let got = joined(Pass::Variance, &[(&[v0; 3], [m0, m0, m0, 0.0], 3), (&[v1; 3], [m1, m1, m1, 0.0], 4)]);
        assert!((got[0] - whole).abs() < 1e-5, "{got:?}, not {whole}");
    }

    #[test]
    fn shares_of_names_add_up_and_are_ranked() {
        let pairs = |p: &[(u32, f32)]| -> Vec<f32> {
            let mut v: Vec<f32> = p.iter().flat_map(|(id, s)| [f32::from_bits(*id), *s]).collect();
            v.resize(2 * CRYPTO_RANKS, 0.0);
            v
        };
        let (x, y) = (pairs(&[(7, 0.75), (9, 0.25)]), pairs(&[(9, 1.0)]));
        assert_eq!(joined(Pass::CryptoObject, &[(&x, [0.0; 4], 4), (&y, [0.0; 4], 4)]), pairs(&[(9, 0.625), (7, 0.375)]));
    }
}
