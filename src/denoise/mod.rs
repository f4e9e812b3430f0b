//! Denoising with Intel Open Image Denoise (openimagedenoise.org), whose library is loaded at run time: a build needs nothing of it.
//!
//! `find` knows where the library may be, `oidn` calls it. How it is used (high dynamic range, prefiltered guides, alpha untouched) is what
//! Cycles does, measured by the same input giving the same picture (docs/denoise.md).

#[cfg_attr(not(feature = "denoise"), allow(dead_code, reason = "nothing looks for the library"))]
mod find;
#[cfg(feature = "denoise")]
mod oidn;

pub use crate::scene::denoise::{DenoiseQuality, DenoiseSettings, Guides, Prefilter};
pub use find::{ENVIRONMENT, HOW_TO_GET};

use crate::film::Film;
use crate::scene::{Pass, PassSet};
use std::path::Path;
use std::sync::atomic::AtomicBool;

/// Why a picture was not denoised.
#[derive(Debug, thiserror::Error)]
pub enum DenoiseError {
    /// The library is nowhere.
    #[error("Intel Open Image Denoise was not found{looked}: {}", HOW_TO_GET)]
    Missing {
        /// "; looked in …", or empty.
        looked: String,
    },
    /// It is there but does not load, or is not what it should be.
    #[error("Open Image Denoise at '{path}' cannot be used: {reason}")]
    Unusable {
        /// The file.
        path: String,
        /// Why.
        reason: String,
    },
    /// It failed.
    #[error("Open Image Denoise failed: {0}")]
    Failed(String),
    /// The program has no denoiser.
    #[error("this program was built without denoising (cargo feature `denoise`)")]
    NotBuilt,
    /// Stopped by the user.
    #[error("denoising was interrupted")]
    Interrupted,
}

/// Red, green, blue (or x, y, z) of each pixel, row by row from the bottom: as Blender keeps pictures. The denoiser's network sees up and down as different
/// things, so that only then the same noise gives Cycles' picture to the last bit.
#[derive(Clone, Debug, PartialEq)]
pub struct Plane {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// `[height][width][3]`.
    pub values: Vec<f32>,
}

impl Plane {
    /// A plane of the values that `pixel` gives for each place of a film in the rectangle.
    fn of(film: &Film, [x0, y0, x1, y1]: [u32; 4], pixel: impl Fn(usize) -> [f32; 3]) -> Self {
        let places = (y0..y1).rev().flat_map(|y| (x0..x1).map(move |x| film.index(x, y)));
        Self { width: (x1 - x0) as usize, height: (y1 - y0) as usize, values: places.flat_map(pixel).collect() }
    }
}

/// The library, ready for use.
pub struct Denoiser {
    #[cfg(feature = "denoise")]
    library: oidn::Library,
}

/// The passes that `settings` wants for guides.
pub fn guide_passes(settings: &DenoiseSettings) -> PassSet {
    match settings.guides {
        Guides::None => PassSet::NONE,
        Guides::Albedo => PassSet::NONE.with(Pass::Albedo),
        Guides::AlbedoNormal => PassSet::NONE.with(Pass::Albedo).with(Pass::DenoisingNormal),
    }
}

impl Denoiser {
    /// Loads the library: `chosen` (a file, or a folder that it is in), else what `RAYLOOM_OIDN` names, else from beside the program, else the
    /// system's.
    #[cfg(feature = "denoise")]
    pub fn load(chosen: Option<&Path>) -> Result<Self, DenoiseError> {
        Ok(Self { library: oidn::Library::load(&find::candidates(chosen)?)? })
    }

    /// There is none in this program.
    #[cfg(not(feature = "denoise"))]
    pub fn load(_chosen: Option<&Path>) -> Result<Self, DenoiseError> {
        Err(DenoiseError::NotBuilt)
    }

    /// "2.3.3 from '/usr/lib/libOpenImageDenoise.so.2'".
    pub fn name(&self) -> String {
        #[cfg(feature = "denoise")]
        return self.library.name();
        #[cfg(not(feature = "denoise"))]
        String::new()
    }

    /// Denoises the colours of a film in the rectangle left, top, right, bottom (ends exclusive) on `threads` threads; `on_progress` hears the share that is
    /// done. Guides are the layers that the film has, of those that the settings want. The noisy colours stay in `film.pixels`.
    pub fn film(
        &self,
        film: &mut Film,
        crop: [u32; 4],
        settings: &DenoiseSettings,
        threads: usize,
        on_progress: &(dyn Fn(f64) + Sync),
        cancel: &AtomicBool,
    ) -> Result<(), DenoiseError> {
        let guide = |pass: Pass| {
            let layer = film.layer(pass).filter(|_| guide_passes(settings).has(pass))?;
            Some(Plane::of(film, crop, |at| layer.at(at).try_into().unwrap_or([0.0; 3])))
        };
        let color = Plane::of(film, crop, |at| [0, 1, 2].map(|c| film.pixels[at][c]));
        let (albedo, normal) = (guide(Pass::Albedo), guide(Pass::DenoisingNormal));
        let clean = self.planes(color, albedo, normal, settings, threads, on_progress, cancel)?;
        let mut out: Vec<[f32; 3]> = film.pixels.iter().map(|p| [p[0], p[1], p[2]]).collect();
        let [x0, y0, x1, y1] = crop;
        let places = (y0..y1).rev().flat_map(|y| (x0..x1).map(move |x| (x, y)));
        for ((x, y), rgb) in places.zip(clean.values.chunks_exact(3)) {
            out[film.index(x, y)].copy_from_slice(rgb);
        }
        film.denoised = Some(out);
        Ok(())
    }

    /// Denoises a picture: the guides, where there are any, first. An albedo is needed for a normal to count.
    pub fn planes(
        &self,
        color: Plane,
        albedo: Option<Plane>,
        normal: Option<Plane>,
        settings: &DenoiseSettings,
        threads: usize,
        on_progress: &(dyn Fn(f64) + Sync),
        cancel: &AtomicBool,
    ) -> Result<Plane, DenoiseError> {
        #[cfg(feature = "denoise")]
        return oidn::denoise(&self.library, color, albedo, normal, settings, threads, on_progress, cancel);
        #[cfg(not(feature = "denoise"))]
        {
            let _ = (color, albedo, normal, settings, threads, on_progress, cancel);
            Err(DenoiseError::NotBuilt)
        }
    }
}

#[cfg(all(test, feature = "denoise"))]
mod tests;
