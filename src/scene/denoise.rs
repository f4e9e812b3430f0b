//! Denoising: what a scene or the command line asks of the denoiser. Names and defaults as Cycles'.

/// What guides the denoiser besides the colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Guides {
    /// Nothing.
    None,
    /// The albedo.
    Albedo,
    /// Albedo and normal.
    #[default]
    AlbedoNormal,
}

/// What is done about noise in the guides.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Prefilter {
    /// Nothing: they are taken for clean.
    None,
    /// The colours' filter is told that they are noisy.
    Fast,
    /// They are denoised first.
    #[default]
    Accurate,
}

/// Time against quality.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum DenoiseQuality {
    /// The best.
    #[default]
    High,
    /// Between the two.
    Balanced,
    /// The fastest.
    Fast,
}

/// How to denoise.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct DenoiseSettings {
    /// What helps.
    pub guides: Guides,
    /// What is done about noise in it.
    pub prefilter: Prefilter,
    /// Time against quality.
    pub quality: DenoiseQuality,
}
