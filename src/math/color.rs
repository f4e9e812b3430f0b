//! Colours: 32-bit floats, as POV-Ray keeps them, in the linear working space unless a name says otherwise.

use super::Vec3;

/// Red, green, blue.
pub type Rgb = Vec3;

/// POV-Ray's five-part colour. `filter` lets light through coloured by `rgb`, `transmit` lets it through unchanged.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Rgbft {
    /// Red, green, blue.
    pub rgb: Rgb,
    /// Share of light let through and coloured.
    pub filter: f32,
    /// Share of light let through as it is.
    pub transmit: f32,
}

/// The part of a colour that POV-Ray calls grey: 0.297 r + 0.589 g + 0.114 b.
pub fn grey(c: Rgb) -> f32 {
    0.297 * c.x + 0.589 * c.y + 0.114 * c.z
}

impl Rgbft {
    /// Opaque black.
    pub const BLACK: Rgbft = Rgbft::rgb(0.0, 0.0, 0.0);
    /// Fully transparent: what an image map gives outside `once`.
    pub const CLEAR: Rgbft = Rgbft { rgb: Vec3::ONE, filter: 0.0, transmit: 1.0 };

    /// An opaque colour.
    pub const fn rgb(r: f32, g: f32, b: f32) -> Self {
        Self { rgb: Vec3::new(r, g, b), filter: 0.0, transmit: 0.0 }
    }

    /// From `[red, green, blue, filter, transmit]`.
    pub fn from_array(c: [f32; 5]) -> Self {
        Self { rgb: Vec3::new(c[0], c[1], c[2]), filter: c[3], transmit: c[4] }
    }

    /// As `[red, green, blue, filter, transmit]`.
    pub fn to_array(self) -> [f32; 5] {
        [self.rgb.x, self.rgb.y, self.rgb.z, self.filter, self.transmit]
    }

    /// What a surface of this colour does to light behind it: `rgb * filter + transmit`.
    pub fn transmittance(self) -> Rgb {
        self.rgb * self.filter + Vec3::splat(self.transmit)
    }

    /// `1 - filter - transmit`.
    pub fn opacity(self) -> f32 {
        1.0 - self.filter - self.transmit
    }

    /// Linear mix of all five channels: `a` at 0, `b` at 1.
    pub fn lerp(a: Self, b: Self, t: f32) -> Self {
        Self {
            rgb: a.rgb * (1.0 - t) + b.rgb * t,
            filter: a.filter * (1.0 - t) + b.filter * t,
            transmit: a.transmit * (1.0 - t) + b.transmit * t,
        }
    }
}
