//! Floyd and Steinberg's error diffusion. Source: measured, tests/film.rs.

/// Rounding errors on their way to the pixels right of and below the current one.
pub(super) struct Dither {
    channels: usize,
    /// What reaches each pixel of this row, `[width][channels]`, in units of the file's values; one pixel of margin at either end.
    here: Vec<f32>,
    /// The same for the row below.
    below: Vec<f32>,
}

impl Dither {
    pub fn new(width: usize, channels: usize) -> Self {
        let zeros = vec![0.0; (width + 2) * channels];
        Self { channels, here: zeros.clone(), below: zeros }
    }

    /// Rounds the values (0..=1) of pixel `x` to 0..=`scale`, its share of earlier errors added.
    pub fn quantize(&mut self, x: usize, values: &[f32], scale: f32, out: &mut [u16]) {
        let at = |x: usize, c: usize| x * self.channels + c;
        for (c, (v, out)) in values.iter().zip(out).enumerate() {
            let wanted = v * scale + self.here[at(x + 1, c)];
            let got = (wanted + 0.5).floor().clamp(0.0, scale);
            *out = got as u16;
            let error = wanted - got;
            self.here[at(x + 2, c)] += error * (7.0 / 16.0);
            self.below[at(x, c)] += error * (3.0 / 16.0);
            self.below[at(x + 1, c)] += error * (5.0 / 16.0);
            self.below[at(x + 2, c)] += error * (1.0 / 16.0);
        }
    }

    pub fn next_row(&mut self) {
        std::mem::swap(&mut self.here, &mut self.below);
        self.below.fill(0.0);
    }
}
