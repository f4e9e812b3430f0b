//! Rays against one structure on a device, timed apart from everything else: what `rayloom bench accel` runs.
//! Twin: `shaders/bench/trace_rays.wesl`.

use super::buffers::SceneBuffers;
use super::device::{Gpu, WORKGROUP, binding_layout, uniform_layout};
use super::shader::assemble;
use crate::accel::AccelKind;
use crate::backend::BackendError;
use crate::compile::CompiledScene;
use crate::compile::geometry::PrimKind;
use crate::integrate::classic::ScenePlan;
use bytemuck::{Pod, Zeroable, bytes_of, cast_slice};
use std::time::Instant;

/// A ray of a measurement.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct BenchRay {
    /// Start.
    pub origin: [f32; 3],
    /// Hits beyond do not count.
    pub t_max: f32,
    /// Unit direction.
    pub dir: [f32; 3],
    /// Nothing.
    pub padding: f32,
}

/// The card runs at its low clock until it has worked for so long. Source: ANCHORS, measured on an H100.
const WARM_UP_SECONDS: f64 = 0.25;
/// A measurement lasts about this long.
const MEASURE_SECONDS: f64 = 0.1;
const MAX_REPEATS: f64 = 64.0;
/// llvmpipe ends every loop, with those inside it, after 65,535 turns. Measured: tetra_8.glb, brute force, 65,536 faces: the last was lost.
const LLVMPIPE_TURNS: u64 = 60_000;
/// Workgroups along one axis of a dispatch.
const MAX_GROUPS: u32 = 65535;

/// A scene with one structure, on a device.
pub struct RayBench<'g> {
    gpu: &'g Gpu,
    kind: AccelKind,
    buffers: SceneBuffers,
    scene_group: wgpu::BindGroup,
    layouts: [wgpu::BindGroupLayout; 2],
    only_mesh: bool,
    /// Seconds of building (if it was not built before) and uploading.
    pub upload_seconds: f64,
}

/// What came of tracing rays.
pub struct Traced {
    /// Depth of the hit, infinite for a miss; for any-hit rays 0 for a hit.
    pub depths: Vec<f32>,
    /// Seconds of one pass over the rays.
    pub seconds: f64,
}

impl<'g> RayBench<'g> {
    /// Uploads `scene` with a structure of kind `kind`.
    pub fn new(gpu: &'g Gpu, scene: &CompiledScene, kind: AccelKind) -> Result<Self, BackendError> {
        let start = Instant::now();
        super::support::check_geometry(scene)?;
        let brute = matches!(kind, AccelKind::Brute | AccelKind::BruteTiled);
        if brute && gpu.info.driver.contains("llvmpipe") && scene.geometry.size().total() > LLVMPIPE_TURNS {
            return Err(BackendError::Unsupported("loops of more than 65,535 turns, which llvmpipe cuts short".into()));
        }
        let plan = ScenePlan::new(scene, 64, 64, false);
        let buffers = SceneBuffers::new(scene, &plan, kind, usize::MAX)?;
        let g = &scene.geometry;
        let only_mesh = matches!(&g.prims[..], [p] if p.kind == PrimKind::Mesh && p.transform_ix == 0 && p.clip_len == 0);
        let bound = [0, 2, 3, 4, 5, 6, 7];
        let entries: Vec<_> = bound.map(|k| if k == 0 { uniform_layout(0) } else { binding_layout(k, false) }).to_vec();
        let scene_layout = gpu.group_layout("bench scene", &entries);
        let storage = |what: &str, bytes: &[u8]| gpu.storage_buffer(what, bytes);
        let params = gpu.uniform_buffer("scene parameters", bytes_of(&buffers.params));
        let list = [
            storage("primitives", cast_slice(&buffers.prims))?,
            storage("transforms", cast_slice(&buffers.transforms))?,
            storage("scene words", cast_slice(&buffers.words))?,
            storage("tree nodes", cast_slice(&buffers.meshes.nodes))?,
            storage("tree references", cast_slice(&buffers.meshes.refs))?,
            storage("triangles", cast_slice(&buffers.meshes.corners))?,
        ];
        let numbered: Vec<(u32, &wgpu::Buffer)> = bound.into_iter().zip(std::iter::once(&params).chain(&list)).collect();
        let scene_group = gpu.bind_group(&scene_layout, &numbered);
        let ray_layout = gpu.group_layout("bench rays", &[binding_layout(0, false), binding_layout(1, true), uniform_layout(2)]);
        gpu.check()?;
        let upload_seconds = start.elapsed().as_secs_f64();
        Ok(Self { gpu, kind, buffers, scene_group, layouts: [scene_layout, ray_layout], only_mesh, upload_seconds })
    }

    /// Nearest hits (or any, for `any_hit`) of `rays`.
    pub fn trace(&self, rays: &[BenchRay], any_hit: bool) -> Result<Traced, BackendError> {
        let pass = self.pass(rays, any_hit, false)?;
        let mut seconds = pass.run(1)?;
        if seconds < WARM_UP_SECONDS {
            let warm = Instant::now();
            while warm.elapsed().as_secs_f64() < WARM_UP_SECONDS {
                pass.run(4)?;
            }
            let once = pass.run(1)?;
            let n = (MEASURE_SECONDS / once.max(1e-6)).clamp(1.0, MAX_REPEATS) as u32;
            let mut list = [pass.run(n)?, pass.run(n)?, pass.run(n)?];
            list.sort_by(f64::total_cmp);
            seconds = list[1];
        }
        Ok(Traced { depths: pass.depths(any_hit)?, seconds })
    }

    /// The same hits, not timed.
    pub fn trace_once(&self, rays: &[BenchRay], any_hit: bool) -> Result<Vec<f32>, BackendError> {
        let pass = self.pass(rays, any_hit, false)?;
        pass.run(1)?;
        pass.depths(any_hit)
    }

    /// Nodes (or cells) visited and primitives tested, a ray.
    pub fn steps(&self, rays: &[BenchRay], any_hit: bool) -> Result<[f64; 2], BackendError> {
        let pass = self.pass(rays, any_hit, true)?;
        pass.run(1)?;
        let sums = pass.read()?.iter().fold([0u64; 2], |s, [a, b]| [s[0] + u64::from(*a), s[1] + u64::from(*b)]);
        Ok(sums.map(|s| s as f64 / rays.len().max(1) as f64))
    }

    fn pass(&self, rays: &[BenchRay], any_hit: bool, count: bool) -> Result<Pass<'g>, BackendError> {
        let mut options = self.buffers.options.clone();
        options.feature_if("only_mesh", self.only_mesh);
        options.feature_if("shadow_rays", any_hit);
        options.feature_if("count_steps", count);
        options.feature_if("double", self.gpu.has_double());
        let text = assemble("bench/trace_rays", &options)?;
        let pipeline = self.gpu.compute_pipeline("trace_rays", &text, "trace_rays", &[&self.layouts[0], &self.layouts[1]])?;
        let input = self.gpu.storage_buffer("bench rays", cast_slice(rays))?;
        let output = self.gpu.empty_buffer("bench hits", rays.len() as u64 * 8)?;
        let params = self.gpu.uniform_buffer("bench parameters", bytes_of(&[rays.len() as u32, 0, 0, 0]));
        let group = self.gpu.bind_group(&self.layouts[1], &[(0, &input), (1, &output), (2, &params)]);
        let n_groups = if self.kind == AccelKind::BruteGroup { rays.len() as u32 } else { (rays.len() as u32).div_ceil(WORKGROUP) };
        Ok(Pass { gpu: self.gpu, pipeline, groups: [self.scene_group.clone(), group], output, n_groups, n_rays: rays.len() })
    }
}

struct Pass<'g> {
    gpu: &'g Gpu,
    pipeline: wgpu::ComputePipeline,
    groups: [wgpu::BindGroup; 2],
    output: wgpu::Buffer,
    n_groups: u32,
    n_rays: usize,
}

impl Pass<'_> {
    /// Seconds of one of `n` passes, by the clock: drivers' time stamps are not to be had everywhere.
    fn run(&self, n: u32) -> Result<f64, BackendError> {
        let start = Instant::now();
        let mut encoder = self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        for _ in 0..n {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            pass.set_pipeline(&self.pipeline);
            self.groups.iter().enumerate().for_each(|(k, g)| pass.set_bind_group(k as u32, g, &[]));
            let x = self.n_groups.clamp(1, MAX_GROUPS);
            pass.dispatch_workgroups(x, self.n_groups.div_ceil(x).max(1), 1);
        }
        self.gpu.queue.submit([encoder.finish()]);
        self.gpu.device.poll(wgpu::PollType::wait_indefinitely()).map_err(|e| BackendError::DeviceLost(e.to_string()))?;
        self.gpu.check()?;
        Ok(start.elapsed().as_secs_f64() / f64::from(n))
    }

    fn depths(&self, any_hit: bool) -> Result<Vec<f32>, BackendError> {
        let depth = |[t, hit]: &[u32; 2]| match (any_hit, *hit != 0) {
            (_, false) => f32::INFINITY,
            (true, true) => 0.0,
            (false, true) => f32::from_bits(*t),
        };
        Ok(self.read()?.iter().map(depth).collect())
    }

    fn read(&self) -> Result<Vec<[u32; 2]>, BackendError> {
        let encoder = self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let bytes = self.gpu.submit_and_read(encoder, &self.output, 0, self.n_rays as u64 * 8)?;
        Ok(bytemuck::pod_collect_to_vec(&bytes))
    }
}
