//! Probes: one shader function run over a buffer of inputs, so that a test compares it with its twin in `kernel/`, element by element.
//!
//! A probe is a module `shaders/probes/NAME.wesl` with an entry point `probe` that reads `@group(0) @binding(0)` (inputs, a storage
//! array of `vec4f`) and writes `@binding(1)` (outputs, the same); texture tables stand in group 1 as in every shader.

use super::device::{Gpu, binding_layout};
use super::shader::{ShaderError, ShaderOptions, assemble};
use crate::backend::BackendError;

impl From<ShaderError> for BackendError {
    fn from(e: ShaderError) -> Self {
        Self::Unsupported(e.to_string())
    }
}

/// Runs probe `name` over `inputs`, `per_input` outputs for each. Empty tables are allowed.
pub fn run_probe(
    gpu: &Gpu,
    name: &str,
    options: &ShaderOptions,
    texture_words: &[u32],
    image_words: &[u32],
    inputs: &[[f32; 4]],
    n_outputs: usize,
) -> Result<Vec<[f32; 4]>, BackendError> {
    let text = assemble(&format!("probes/{name}"), options)?;
    let data = gpu.group_layout(name, &[binding_layout(0, false), binding_layout(1, true)]);
    let tables = gpu.group_layout(name, &[binding_layout(0, false), binding_layout(1, false)]);
    let pipeline = gpu.compute_pipeline(name, &text, "probe", &[&data, &tables])?;
    let input = gpu.storage_buffer("probe inputs", bytemuck::cast_slice(inputs))?;
    let output = gpu.empty_buffer("probe outputs", (n_outputs * 16) as u64)?;
    let words = gpu.storage_buffer("texture words", bytemuck::cast_slice(texture_words))?;
    let images = gpu.storage_buffer("image words", bytemuck::cast_slice(image_words))?;
    let groups = [gpu.bind_group(&data, &[(0, &input), (1, &output)]), gpu.bind_group(&tables, &[(0, &words), (1, &images)])];
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some(name) });
    gpu.dispatch(&mut encoder, &pipeline, &[&groups[0], &groups[1]], inputs.len() as u32);
    let bytes = gpu.submit_and_read(encoder, &output, 0, (n_outputs * 16) as u64)?;
    Ok(bytemuck::pod_collect_to_vec(&bytes))
}
