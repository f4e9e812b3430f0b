//! Shader functions against their CPU twins, element by element (`shaders/probes/`). Pictures say that something broke; probes say what.

use crate::found;
use rayloom::backend::gpu::probe::run_probe;
use rayloom::backend::gpu::shader::ShaderOptions;
use rayloom::backend::gpu::{Gpu, GpuOptions};

fn gpu() -> Option<Gpu> {
    found(Gpu::new(&GpuOptions { accept_software: true, ..GpuOptions::default() }))
}

#[test]
fn a_probe_sees_its_inputs_constants_and_tables() {
    let Some(gpu) = gpu() else { return };
    let mut options = ShaderOptions::default();
    options.constant("FACTOR", 2.0f32);
    let inputs = [[1.0, 2.0, 3.0, 4.0], [-1.0, 0.5, 0.0, 8.0]];
    let out = run_probe(&gpu, "double", &options, &[10f32.to_bits()], &[], &inputs, 2).expect("runs");
    assert_eq!(out, [[12.0, 14.0, 16.0, 18.0], [8.0, 11.0, 10.0, 26.0]]);
}
