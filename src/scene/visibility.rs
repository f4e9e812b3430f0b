//! Which kinds of rays see a thing. POV-Ray's switches (`no_image`, `no_shadow`, `no_reflection`) stand in `ObjectFlags`; these are Cycles'.

/// A set of ray kinds. Source: Cycles' ray visibility; a ray has the kind of the last event that made it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Visibility(pub u8);

impl Visibility {
    /// Rays from the camera, and those that went straight on through transparent surfaces since.
    pub const CAMERA: Self = Self(1);
    /// After a diffuse bounce.
    pub const DIFFUSE: Self = Self(1 << 1);
    /// After a glossy or mirror reflection.
    pub const GLOSSY: Self = Self(1 << 2);
    /// After a refraction.
    pub const TRANSMISSION: Self = Self(1 << 3);
    /// After scattering in a volume.
    pub const VOLUME: Self = Self(1 << 4);
    /// Rays that ask whether a light is in sight.
    pub const SHADOW: Self = Self(1 << 5);
    /// Every kind.
    pub const ALL: Self = Self(0x3f);

    /// Whether all kinds of `other` are in this set.
    pub fn has(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }

    /// Both sets together.
    #[must_use]
    pub fn with(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// This set without `other`.
    #[must_use]
    pub fn without(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }
}

impl Default for Visibility {
    fn default() -> Self {
        Self::ALL
    }
}
