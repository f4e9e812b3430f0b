//! The machines: each renders a compiled scene to a film.

pub mod cpu;
#[cfg(feature = "gpu")]
pub mod gpu;
mod paths;
mod unfinished;

pub use unfinished::unfinished_blocks;

use crate::compile::CompiledScene;
use crate::film::Film;
use crate::integrate::RenderSettings;
use crate::integrate::classic::{PhotonError, PhotonStats};
use std::sync::atomic::AtomicBool;

/// Why a picture could not be finished.
#[derive(Debug, thiserror::Error)]
pub enum BackendError {
    /// No device of the kind asked for.
    #[error("no usable GPU: {0}")]
    NoDevice(String),
    /// The device went away while rendering; what was done is in the film.
    #[error("the device was lost: {0}")]
    DeviceLost(String),
    /// The scene needs more memory than the device gives.
    #[error("{what} needs {needed} bytes, the device gives {limit}")]
    TooLarge {
        /// "the triangle buffer".
        what: String,
        /// Bytes.
        needed: u64,
        /// Bytes.
        limit: u64,
    },
    /// Photons could not be shot.
    #[error(transparent)]
    Photons(#[from] PhotonError),
    /// The scene uses something that this machine cannot render; the caller falls back.
    #[error("not on this device: {0}")]
    Unsupported(String),
}

/// Told while rendering, from any thread.
pub trait Progress: Sync {
    /// `done` of `total` pixels (times passes) are finished.
    fn pixels(&self, done: u64, total: u64);
    /// `done` of about `total` photons are shot, before the first pixel.
    fn photons(&self, _done: u64, _total: u64) {}
    /// All photons are where they stay.
    fn photons_at_rest(&self, _stats: &PhotonStats) {}
    /// The picture so far, each time that something came to it. Who hears it holds up a thread: most calls must return at once.
    fn picture(&self, _film: &Film) {}
}

/// Nobody listens.
impl Progress for () {
    fn pixels(&self, _done: u64, _total: u64) {}
}

/// GPUs that could render, real ones first: "NVIDIA H100 (Vulkan)".
pub fn device_names() -> Vec<String> {
    #[cfg(feature = "gpu")]
    return gpu::list_devices();
    #[cfg(not(feature = "gpu"))]
    Vec::new()
}

/// Why [`device_names`] is empty.
pub fn why_no_device() -> &'static str {
    if cfg!(feature = "gpu") { "no graphics driver was found" } else { "this program was built without the GPU back end" }
}

/// A machine.
pub trait Backend {
    /// "CPU, 2 threads", "NVIDIA H100 (Vulkan)".
    fn name(&self) -> String;
    /// What it draws otherwise than the CPU would, though the scene is whole: told once.
    fn differs(&self, _scene: &CompiledScene, _settings: &RenderSettings) -> Option<&'static str> {
        None
    }
    /// Renders into `film` until finished or `cancel` is set; pixels outside the crop are left alone, and so are whole blocks that
    /// hold all their samples already. What cannot be continued is rendered anew.
    /// After an error or a cancel the film holds what was rendered, and `film.samples` says where.
    fn render(
        &self,
        scene: &CompiledScene,
        settings: &RenderSettings,
        film: &mut Film,
        progress: &dyn Progress,
        cancel: &AtomicBool,
    ) -> Result<(), BackendError>;
}
