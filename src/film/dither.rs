//! Dithering: rounding errors spread over neighbours, so that slow gradients show no steps. Source: measured against POV-Ray's
//! `+TH` files, tests/measured/film.txt.

/// POV-Ray's dither methods, by its names.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum DitherMethod {
    /// `B2`, `B3`, `B4`: thresholds in squares of this side, 2 to 4. Black becomes 1 in one pixel of each square, as POV-Ray has it.
    Ordered(u8),
    /// `D1`: the whole error to the next pixel, on into the next row.
    ToTheRight,
    /// `D2`: half to the right, a quarter below, a quarter below to the right.
    Triangle,
    /// `FS`: Floyd and Steinberg's 7, 3, 5, 1 sixteenths.
    #[default]
    FloydSteinberg,
}

impl DitherMethod {
    /// The method of a `Dither_Method` or `+TH`.
    pub fn named(name: &str) -> Option<Self> {
        Some(match name.to_ascii_uppercase().as_str() {
            "B2" => Self::Ordered(2),
            "B3" => Self::Ordered(3),
            "B4" => Self::Ordered(4),
            "D1" => Self::ToTheRight,
            "D2" => Self::Triangle,
            "FS" => Self::FloydSteinberg,
            _ => return None,
        })
    }

    /// Shares of the error for the pixels right, below to the left, below, below to the right.
    fn shares(self) -> [f32; 4] {
        match self {
            Self::Ordered(_) => [0.0; 4],
            Self::ToTheRight => [1.0, 0.0, 0.0, 0.0],
            Self::Triangle => [0.5, 0.0, 0.25, 0.25],
            Self::FloydSteinberg => [7.0 / 16.0, 3.0 / 16.0, 5.0 / 16.0, 1.0 / 16.0],
        }
    }
}

/// Steps of each threshold from the least, `[row][column]`.
const ORDERED_2: [u8; 4] = [3, 0, 1, 2];
const ORDERED_3: [u8; 9] = [6, 3, 7, 2, 8, 1, 5, 0, 4];
const ORDERED_4: [u8; 16] = [15, 3, 12, 0, 7, 11, 4, 8, 13, 1, 14, 2, 5, 9, 6, 10];

/// Rounds the pixels of a picture in raster order.
pub(super) struct Dither {
    method: DitherMethod,
    channels: usize,
    row: usize,
    /// What reaches each pixel of this row, `[width][channels]`; one pixel of margin at either end.
    here: Vec<f32>,
    /// The same for the row below.
    below: Vec<f32>,
    /// What reaches the first pixel of the row below: in POV-Ray's files errors come there one row late.
    late: Vec<f32>,
}

impl Dither {
    pub fn new(method: DitherMethod, width: usize, channels: usize) -> Self {
        let zeros = vec![0.0; (width + 2) * channels];
        Self { method, channels, row: 0, here: zeros.clone(), below: zeros, late: vec![0.0; channels] }
    }

    /// Rounds the channels of pixel `x`. `number` is a channel's file value for a working-space value and a bias, `back` the way back;
    /// errors are those of the working space, and none comes from values that are outside 0..=1.
    pub fn quantize(
        &mut self,
        x: usize,
        values: &[f32],
        out: &mut [u16],
        number: &impl Fn(f32, usize, f32) -> u16,
        back: &impl Fn(u16, usize) -> f32,
    ) {
        let at = |x: usize, c: usize| x * self.channels + c;
        let bias = self.bias(x);
        let [right, below_left, below, below_right] = self.method.shares();
        for (c, (v, out)) in values.iter().zip(out).enumerate() {
            let wanted = v + self.here[at(x + 1, c)];
            *out = number(wanted, c, bias);
            if right == 0.0 || !wanted.is_finite() {
                continue;
            }
            let error = wanted.clamp(0.0, 1.0) - back(*out, c);
            self.here[at(x + 2, c)] += error * right;
            self.below[at(x, c)] += error * below_left;
            self.below[at(x + 1, c)] += error * below;
            self.below[at(x + 2, c)] += error * below_right;
        }
    }

    /// What is added before a value is cut off: a half, or the threshold of the place.
    fn bias(&self, x: usize) -> f32 {
        let (side, table): (usize, &[u8]) = match self.method {
            DitherMethod::Ordered(2) => (2, &ORDERED_2),
            DitherMethod::Ordered(3) => (3, &ORDERED_3),
            DitherMethod::Ordered(_) => (4, &ORDERED_4),
            _ => return 0.5,
        };
        1.0 - f32::from(table[self.row % side * side + x % side]) / (side * side) as f32
    }

    pub fn next_row(&mut self) {
        self.row += 1;
        let first = self.channels..2 * self.channels;
        if self.method == DitherMethod::ToTheRight {
            let end = self.here.len() - self.channels;
            self.below[first].copy_from_slice(&self.here[end..]);
        } else {
            self.late.swap_with_slice(&mut self.below[first]);
        }
        std::mem::swap(&mut self.here, &mut self.below);
        self.below.fill(0.0);
    }
}
