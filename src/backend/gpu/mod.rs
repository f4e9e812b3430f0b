//! The GPU: the classic integrator as a wavefront of compute shaders in f32, through wgpu. The f64 CPU renderer is the gold that it follows.
//!
//! Shader text is put together for what the scene uses (`shader`); rays wait in queues (`wavefront`). What a scene uses beyond what
//! the shaders know gives [`BackendError::Unsupported`](super::BackendError), and the caller renders on the CPU.

pub mod device;
mod modules;
pub mod probe;
pub mod shader;
pub mod texture_buffers;
mod texture_encoder;
mod texture_functions;
mod texture_images;
mod texture_layout;
mod texture_noise;
mod texture_patterns;

pub use device::{Gpu, GpuOptions, list_devices};
