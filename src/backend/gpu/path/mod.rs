//! The path integrator on the GPU: whole paths, a thread a slot of the film (`shaders/path/trace_paths.wesl`). The CPU's integrator
//! (`integrate/path`) is the gold; both draw the same numbers, so that pictures differ by rounding alone.

mod adaptive;
mod buffers;
mod camera;
mod geometry;
mod inputs;
mod lights;
mod materials;
mod motion;
mod support;
mod tables;
mod volumes;

use super::device::{Gpu, WORKGROUP, binding_layout, uniform_layout};
use super::layout::{PathBatch, PathParams};
use super::shader::assemble;
use crate::accel::AccelKind;
use crate::backend::unfinished::{add_samples, unfinished_blocks};
use crate::backend::{BackendError, Progress};
use crate::compile::CompiledScene;
use crate::film::Film;
use crate::integrate::RenderSettings;
use crate::integrate::antialias::blocks;
use crate::integrate::path::PathPlan;
use buffers::PathBuffers;
use bytemuck::{bytes_of, cast_slice};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Pixels that are on the device at once.
const MAX_SLOTS: usize = 1 << 21;
/// A dispatch that takes longer is followed by smaller ones, since drivers end what runs for two seconds and desktops stand still meanwhile;
/// one that takes less by larger ones.
const LONG: Duration = Duration::from_millis(500);
const SHORT: Duration = Duration::from_millis(120);
/// Workgroups along one axis of a dispatch.
const MAX_GROUPS: u32 = 65535;
/// llvmpipe ends a thread's loops after 65,535 turns in all (measured): so many samples a dispatch stay far below.
const SOFTWARE_SAMPLES: u32 = 2;

/// A scene on a device, ready to trace paths.
pub struct PathScene<'g> {
    gpu: &'g Gpu,
    pipeline: wgpu::ComputePipeline,
    scene_group: wgpu::BindGroup,
    path_layout: wgpu::BindGroupLayout,
    fixed: Vec<wgpu::Buffer>,
    params: PathParams,
    /// Sums of every second sample are kept beside.
    halves: bool,
    is_software: bool,
}

/// Slots on their way: which pixels, their sums.
struct Slots {
    group: wgpu::BindGroup,
    film: wgpu::Buffer,
    /// Sums of the samples of odd number, where they are asked for.
    odd: wgpu::Buffer,
    n: u32,
}

/// What one dispatch may do, learnt from the last ones.
#[derive(Clone, Copy, Debug)]
struct Pace {
    slots: u32,
    samples: u32,
}

impl<'g> PathScene<'g> {
    /// Uploads a scene and makes its pipeline, for a picture of `size`.
    pub fn new(
        gpu: &'g Gpu,
        scene: &CompiledScene,
        plan: &PathPlan,
        kind: AccelKind,
        size: [u32; 2],
        halves: bool,
    ) -> Result<Self, BackendError> {
        if let Some(what) = support::first_obstacle(scene, plan) {
            return Err(BackendError::Unsupported(what));
        }
        let b = PathBuffers::new(scene, plan, kind, size)?;
        let storage = |what: &str, bytes: &[u8]| gpu.storage_buffer(what, bytes);
        let scene_bindings = [5, 6, 7, 8];
        let of_scene = [
            storage("tree nodes", cast_slice(&b.faces.tree.nodes))?,
            storage("tree references", cast_slice(&b.faces.tree.refs))?,
            storage("triangles", cast_slice(&b.faces.corners))?,
            storage("triangle attributes", cast_slice(&b.faces.hung))?,
        ];
        let entries: Vec<_> = scene_bindings.iter().map(|k| binding_layout(*k, false)).collect();
        let scene_layout = gpu.group_layout("scene", &entries);
        let numbered: Vec<(u32, &wgpu::Buffer)> = scene_bindings.into_iter().zip(&of_scene).collect();
        let scene_group = gpu.bind_group(&scene_layout, &numbered);
        let mut entries = vec![uniform_layout(0), uniform_layout(1)];
        entries.extend((2..7).map(|k| binding_layout(k, false)));
        entries.extend([binding_layout(7, true), binding_layout(8, true)]);
        let path_layout = gpu.group_layout("paths", &entries);
        let mut options = b.options;
        options.feature_if("halves", halves);
        let text = assemble("path/trace_paths", &options)?;
        let pipeline = gpu.compute_pipeline("trace_paths", &text, "trace_paths", &[&scene_layout, &path_layout])?;
        let fixed = vec![
            gpu.uniform_buffer("path parameters", bytes_of(&b.params)),
            gpu.uniform_buffer("batch", bytes_of(&PathBatch::default())),
            storage("path words", cast_slice(&b.words))?,
            storage("faces", cast_slice(&b.faces.faces))?,
            storage("sampler and light tree", cast_slice(&b.quads))?,
            storage("texels", cast_slice(&b.texels))?,
        ];
        gpu.check()?;
        let is_software = gpu.info.device_type == wgpu::DeviceType::Cpu;
        Ok(Self { gpu, pipeline, scene_group, path_layout, fixed, params: b.params, halves, is_software })
    }

    /// Other random numbers from now on.
    fn reseed(&mut self, seed: u32) {
        self.params.seed = seed;
        self.gpu.queue.write_buffer(&self.fixed[0], 0, bytes_of(&self.params));
    }

    /// Empty sums for pixels (column and row).
    fn slots(&self, pixels: &[(u32, u32)]) -> Result<Slots, BackendError> {
        let packed: Vec<u32> = pixels.iter().map(|(x, y)| x | y << 16).collect();
        let list = self.gpu.storage_buffer("pixels", cast_slice(&packed))?;
        let film = self.gpu.empty_buffer("sums of pixels", 16 * packed.len() as u64)?;
        let odd = self.gpu.empty_buffer("sums of odd samples", if self.halves { 16 * packed.len() as u64 } else { 0 })?;
        let all: Vec<(u32, &wgpu::Buffer)> = (0..).zip(self.fixed.iter().chain([&list, &film, &odd])).collect();
        Ok(Slots { group: self.gpu.bind_group(&self.path_layout, &all), film, odd, n: packed.len() as u32 })
    }

    /// Runs samples `first..end` of `n` slots from `at` on, and waits for them.
    fn run(&self, slots: &Slots, at: u32, n: u32, first: u32, end: u32) -> Result<(), BackendError> {
        self.gpu.queue.write_buffer(&self.fixed[1], 0, bytes_of(&PathBatch { first: at, n, first_sample: first, end_sample: end }));
        let mut encoder = self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(0, &self.scene_group, &[]);
            pass.set_bind_group(1, &slots.group, &[]);
            let n_groups = n.div_ceil(WORKGROUP);
            let x = n_groups.clamp(1, MAX_GROUPS);
            pass.dispatch_workgroups(x, n_groups.div_ceil(x), 1);
        }
        self.gpu.queue.submit([encoder.finish()]);
        self.gpu.device.poll(wgpu::PollType::wait_indefinitely()).map_err(|e| BackendError::DeviceLost(e.to_string()))?;
        self.gpu.check()
    }

    /// Samples of a range for all slots, at a pace that is learnt; `told` hears how many samples were traced and says whether to go on. Gives
    /// how many samples each slot has got: one that is begun is finished for all.
    fn run_all(
        &self,
        slots: &Slots,
        samples: std::ops::Range<u32>,
        pace: &mut Pace,
        told: &mut dyn FnMut(u64) -> bool,
    ) -> Result<u32, BackendError> {
        let (mut sample, mut goes_on) = (samples.start, true);
        while sample < samples.end && goes_on {
            let end = (sample + pace.samples).min(samples.end);
            let mut at = 0;
            while at < slots.n {
                let n = pace.slots.min(slots.n - at);
                let start = Instant::now();
                self.run(slots, at, n, sample, end)?;
                at += n;
                goes_on = told(u64::from(n) * u64::from(end - sample));
                *pace = self.next_pace(*pace, start.elapsed(), n < slots.n);
            }
            sample = end;
        }
        Ok(sample - samples.start)
    }

    /// What a buffer of `n` slots holds: red, green, blue, transmit of each, summed over its samples.
    fn sums(&self, film: &wgpu::Buffer, n: u32) -> Result<Vec<[f32; 4]>, BackendError> {
        let encoder = self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let bytes = self.gpu.submit_and_read(encoder, film, 0, 16 * u64::from(n))?;
        Ok(bytemuck::pod_collect_to_vec(&bytes))
    }

    fn first_pace(&self) -> Pace {
        if self.is_software { Pace { slots: 1 << 12, samples: 1 } } else { Pace { slots: 1 << 18, samples: 1 } }
    }

    fn next_pace(&self, now: Pace, took: Duration, was_full: bool) -> Pace {
        let most_samples = if self.is_software { SOFTWARE_SAMPLES } else { 1 << 16 };
        match took {
            t if t > LONG && now.samples > 1 => Pace { samples: now.samples / 2, ..now },
            t if t > LONG => Pace { slots: (now.slots / 2).max(256), ..now },
            t if t < SHORT && was_full && (now.slots as usize) < MAX_SLOTS => Pace { slots: now.slots * 2, ..now },
            t if t < SHORT && now.samples < most_samples => Pace { samples: now.samples * 2, ..now },
            _ => now,
        }
    }
}

/// Renders with the path integrator.
pub(super) fn render(
    gpu: &Gpu,
    scene: &CompiledScene,
    settings: &RenderSettings,
    kind: AccelKind,
    film: &mut Film,
    progress: &dyn Progress,
    cancel: &AtomicBool,
) -> Result<(), BackendError> {
    let plan = PathPlan::without_tree(scene, settings.width, settings.height, settings.seed, settings.output_alpha);
    let on_device = PathScene::new(gpu, scene, &plan, kind, [settings.width, settings.height], settings.noise.is_some())?;
    if let Some(limit) = &settings.noise {
        return adaptive::until_quiet(&on_device, settings, limit, film, progress, cancel);
    }
    let (blocks, finished) = unfinished_blocks(film, settings);
    let pixels: Vec<(u32, u32)> = blocks.iter().flat_map(|b| tiles_of(*b)).collect();
    let [x0, y0, x1, y1] = settings.crop.map(u64::from);
    let (total, n_samples) = ((x1 - x0) * (y1 - y0), settings.samples.len().max(1) as u64);
    let mut done = finished * n_samples;
    let mut pace = on_device.first_pace();
    for part in pixels.chunks(MAX_SLOTS) {
        let slots = on_device.slots(part)?;
        let n = on_device.run_all(&slots, settings.samples.clone(), &mut pace, &mut |n| {
            done += n;
            progress.pixels(done / n_samples, total);
            !cancel.load(Ordering::Relaxed)
        })?;
        if n == 0 {
            return Ok(());
        }
        for ((x, y), s) in part.iter().zip(on_device.sums(&slots.film, slots.n)?) {
            let at = film.index(*x, *y);
            add_samples(film, at, s.map(|v| v / n as f32), n);
        }
    }
    Ok(())
}

/// The card runs at its low clock until it has worked for so long. Source: measured on an H100 (benches/results/accel_h100.md).
const WARM_UP: Duration = Duration::from_millis(300);

/// How long pictures took, for `rayloom bench path`.
pub struct PathTimes {
    /// Building the tree, uploading, compiling the shader.
    pub prepare_seconds: f64,
    /// Each picture, from the first dispatch to the last's end; in ascending order.
    pub seconds: Vec<f64>,
    /// Mean of red, green and blue over all pixels of all pictures.
    pub mean: f64,
}

/// Renders the whole picture `n` times with other random numbers, after a warm-up, and throws it away.
pub(super) fn measure(
    gpu: &Gpu,
    scene: &CompiledScene,
    settings: &RenderSettings,
    kind: AccelKind,
    n: u32,
) -> Result<PathTimes, BackendError> {
    let start = Instant::now();
    let plan = PathPlan::without_tree(scene, settings.width, settings.height, settings.seed, settings.output_alpha);
    let mut on_device = PathScene::new(gpu, scene, &plan, kind, [settings.width, settings.height], false)?;
    let pixels: Vec<(u32, u32)> = blocks(settings.crop, settings.block_size).iter().flat_map(|b| tiles_of(*b)).collect();
    let parts = pixels.chunks(MAX_SLOTS).map(|part| on_device.slots(part)).collect::<Result<Vec<Slots>, _>>()?;
    let prepare_seconds = start.elapsed().as_secs_f64();
    let mut pace = on_device.first_pace();
    let picture = |on_device: &PathScene, pace: &mut Pace| -> Result<f64, BackendError> {
        let start = Instant::now();
        for slots in &parts {
            on_device.run_all(slots, settings.samples.clone(), pace, &mut |_| true)?;
        }
        Ok(start.elapsed().as_secs_f64())
    };
    // Sums of a film run on over all pictures.
    let sum = |on_device: &PathScene| -> Result<f64, BackendError> {
        let mut total = 0.0;
        for slots in &parts {
            total += on_device.sums(&slots.film, slots.n)?.iter().flat_map(|s| &s[..3]).map(|v| f64::from(*v)).sum::<f64>();
        }
        Ok(total)
    };
    let warm = Instant::now();
    while warm.elapsed() < WARM_UP {
        picture(&on_device, &mut pace)?;
    }
    let before = sum(&on_device)?;
    let mut seconds = Vec::new();
    for k in 0..n {
        on_device.reseed(plan.seed ^ (k + 1));
        seconds.push(picture(&on_device, &mut pace)?);
    }
    seconds.sort_by(f64::total_cmp);
    let n_values = (3 * pixels.len() * settings.samples.len() * n.max(1) as usize) as f64;
    let mean = (sum(&on_device)? - before) / n_values;
    Ok(PathTimes { prepare_seconds, seconds, mean })
}

/// Pixels of a block in tiles of 8 by 8, so that the threads of a workgroup look at one spot.
fn tiles_of([x0, y0, x1, y1]: [u32; 4]) -> impl Iterator<Item = (u32, u32)> {
    let tile = move |tx: u32, ty: u32| (ty..(ty + 8).min(y1)).flat_map(move |y| (tx..(tx + 8).min(x1)).map(move |x| (x, y)));
    (y0..y1).step_by(8).flat_map(move |ty| (x0..x1).step_by(8).flat_map(move |tx| tile(tx, ty)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_hold_every_pixel_once() {
        let mut all: Vec<(u32, u32)> = tiles_of([3, 5, 30, 22]).collect();
        assert_eq!(all[..9], [(3, 5), (4, 5), (5, 5), (6, 5), (7, 5), (8, 5), (9, 5), (10, 5), (3, 6)]);
        all.sort_unstable();
        all.dedup();
        assert_eq!(all.len(), 27 * 17);
    }
}
