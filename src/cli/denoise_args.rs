//! Words of the command line for denoising, of `rayloom render` and `rayloom denoise`.

use clap::{Args, ValueEnum};
use rayloom::denoise::{DenoiseQuality, DenoiseSettings, Guides, Prefilter};
use std::path::PathBuf;

/// Options of `rayloom render`.
#[derive(Debug, Args)]
pub(super) struct DenoiseOptions {
    /// Denoise the finished picture with Intel Open Image Denoise (docs/denoise.md) [default: what the scene asks for]
    #[arg(long, conflicts_with = "no_denoise")]
    denoise: bool,
    /// Leave the picture noisy, whatever the scene asks for
    #[arg(long)]
    no_denoise: bool,
    /// What guides the denoiser besides the colours
    #[arg(long, value_enum, value_name = "WHAT", default_value_t = GuidesArg::AlbedoNormal, requires = "denoise")]
    denoise_guides: GuidesArg,
    /// What is done about noise in the guides: nothing, little, denoise them first
    #[arg(long, value_enum, value_name = "HOW", default_value_t = PrefilterArg::Accurate, requires = "denoise")]
    denoise_prefilter: PrefilterArg,
    /// The denoiser's quality against its time
    #[arg(long, value_enum, value_name = "Q", default_value_t = QualityArg::High, requires = "denoise")]
    denoise_quality: QualityArg,
    /// The library libOpenImageDenoise, or the folder that it is in [default: $RAYLOOM_OIDN, beside the program, the system's]
    #[arg(long, value_name = "PATH")]
    pub(super) denoise_library: Option<PathBuf>,
}

impl DenoiseOptions {
    /// What they ask for; `None` leaves it to the scene.
    pub fn wanted(&self) -> Option<Option<DenoiseSettings>> {
        let settings = denoise_settings(self.denoise_guides, self.denoise_prefilter, self.denoise_quality);
        if self.no_denoise { Some(None) } else { self.denoise.then_some(Some(settings)) }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum GuidesArg {
    None,
    Albedo,
    AlbedoNormal,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum PrefilterArg {
    None,
    Fast,
    Accurate,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum QualityArg {
    High,
    Balanced,
    Fast,
}

/// The settings of these words.
pub(super) fn denoise_settings(guides: GuidesArg, prefilter: PrefilterArg, quality: QualityArg) -> DenoiseSettings {
    DenoiseSettings {
        guides: match guides {
            GuidesArg::None => Guides::None,
            GuidesArg::Albedo => Guides::Albedo,
            GuidesArg::AlbedoNormal => Guides::AlbedoNormal,
        },
        prefilter: match prefilter {
            PrefilterArg::None => Prefilter::None,
            PrefilterArg::Fast => Prefilter::Fast,
            PrefilterArg::Accurate => Prefilter::Accurate,
        },
        quality: match quality {
            QualityArg::High => DenoiseQuality::High,
            QualityArg::Balanced => DenoiseQuality::Balanced,
            QualityArg::Fast => DenoiseQuality::Fast,
        },
    }
}
