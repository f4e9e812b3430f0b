//! The GPU: the classic integrator as a wavefront of compute shaders in f32, through wgpu. The f64 CPU renderer is the gold that it follows.
//!
//! Shader text is put together for what the scene uses (`shader`); rays wait in queues (`wavefront`). What a scene uses beyond what
//! the shaders know gives [`BackendError::Unsupported`](super::BackendError), and the caller renders on the CPU.

mod buffers;
mod camera;
mod camera_buffers;
pub mod choice;
pub mod device;
mod function_builtins;
mod function_program;
pub mod layout;
mod light_buffers;
mod material_buffers;
mod media_buffers;
mod mesh_buffers;
mod modules;
mod path;
mod pipeline_files;
pub mod probe;
pub mod ray_bench;
pub mod shader;
mod shape_buffers;
mod stage_clock;
mod support;
pub mod texture_buffers;
mod texture_encoder;
mod texture_function_pigments;
mod texture_functions;
mod texture_images;
mod texture_layout;
mod texture_noise;
mod texture_normals;
mod texture_patterns;
mod tree_words;
mod wavefront;

pub use device::{Gpu, GpuOptions, list_devices, open_all};
pub use path::PathTimes;
pub use stage_clock::StageTime;
pub use support::check;

use super::unfinished::{add_blocks, add_rows, add_samples, unfinished_blocks};
use super::{Backend, BackendError, Progress};
use crate::accel::AccelKind;
use crate::compile::CompiledScene;
use crate::compile::shape::IsosurfaceShape;
use crate::film::Film;
use crate::integrate::Antialias;
use crate::integrate::antialias::{Block, Sample};
use crate::integrate::block_memo::BlockMemo;
use crate::integrate::classic::ScenePlan;
use crate::integrate::samples::sample_position;
use crate::integrate::{IntegratorKind, RenderSettings};
use crate::kernel::lens::Lens;
use crate::kernel::mesh_camera::MeshCamera;
use buffers::SceneBuffers;
use camera_buffers::DeviceCamera;
use rayon::prelude::*;
use stage_clock::StageClock;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};
use texture_functions::most_written;
use wavefront::{MakeStart, Places, Wavefront};

/// Where the time of a picture went on a device.
#[derive(Clone, Debug)]
pub struct StageTimes {
    /// Each kernel, longest first.
    pub stages: Vec<StageTime>,
    /// Uploading and making pipelines, which are compiled already.
    pub prepare_seconds: f64,
    /// From the first ray to the last pixel, with all that the host does between dispatches.
    pub render_seconds: f64,
}

/// A graphics card, or software that acts as one.
pub struct GpuBackend {
    gpu: Gpu,
}

impl GpuBackend {
    /// Opens the first device that will do.
    pub fn new(options: &GpuOptions) -> Result<Self, BackendError> {
        Ok(Self::on(Gpu::new(options)?))
    }

    /// On a device that is open.
    pub fn on(gpu: Gpu) -> Self {
        Self { gpu }
    }

    /// Its device.
    pub fn into_device(self) -> Gpu {
        self.gpu
    }

    /// Takes the device away, as a driver's reset does: every render that runs on it ends with an error. For tests of just that.
    pub fn destroy_device(&self) {
        self.gpu.device.destroy();
    }

    /// Path-traces the whole picture `n` times after a warm-up, and says how long it took.
    pub fn measure_paths(&self, scene: &CompiledScene, settings: &RenderSettings, n: u32) -> Result<PathTimes, BackendError> {
        path::measure(&self.gpu, scene, settings, self.accel_for(scene), n)
    }

    /// Renders the whole picture in POV-Ray's light transport twice, times the second, and says where the time went.
    ///
    /// # Errors
    /// Those of rendering, and `Unsupported` where the device has no timestamps.
    pub fn measure_stages(&self, scene: &CompiledScene, settings: &RenderSettings) -> Result<StageTimes, BackendError> {
        let Some(clock) = StageClock::new(&self.gpu) else {
            return Err(BackendError::Unsupported("timestamps, on this device".into()));
        };
        let film = || Film::new(settings.width, settings.height);
        let never = AtomicBool::new(false);
        self.render_classic(scene, settings, &mut film(), &(), &never, Some(&clock))?;
        clock.restart();
        let start = Instant::now();
        let prepare_seconds = self.render_classic(scene, settings, &mut film(), &(), &never, Some(&clock))?;
        let render_seconds = start.elapsed().as_secs_f64() - prepare_seconds;
        Ok(StageTimes { stages: clock.totals(), prepare_seconds, render_seconds })
    }

    /// One picture in POV-Ray's light transport; gives the seconds of uploading and making pipelines.
    fn render_classic(
        &self,
        scene: &CompiledScene,
        settings: &RenderSettings,
        film: &mut Film,
        progress: &dyn Progress,
        cancel: &AtomicBool,
        clock: Option<&StageClock>,
    ) -> Result<f64, BackendError> {
        support::check(scene)?;
        let start = Instant::now();
        let plan = ScenePlan::new(scene, settings.width, settings.height, settings.output_alpha);
        let buffers = SceneBuffers::new(scene, &plan, self.accel_for(scene), most_written(&self.gpu)?)?;
        // llvmpipe ends loops after 65,535 turns: a ray's search times the steps of a function.
        let is_searched = |s: &IsosurfaceShape| buffers.textures.interpreted.contains(&s.function);
        if self.gpu.info.device_type == wgpu::DeviceType::Cpu && scene.geometry.shapes.isosurfaces.iter().any(is_searched) {
            return Err(BackendError::Unsupported("isosurfaces of heavy functions, in software".into()));
        }
        let wavefront = Wavefront::new(&self.gpu, &buffers, clock)?;
        let prepared = start.elapsed().as_secs_f64();
        let camera = Arc::new(camera::CameraRays::new(scene, &plan));
        let (all, done) = unfinished_blocks(film, settings);
        let part = wavefront.max_samples;
        let (places, found) = (Vec::new(), Vec::new());
        let is_whole = done == 0;
        let mut picture = Picture { plan: &plan, wavefront, camera, settings, film, progress, cancel, done, part, places, found };
        match &settings.antialias {
            Some(aa) => picture.render_blocks(aa, &all),
            None if is_whole && settings.samples.len() <= 1 => picture.render_rows(),
            None => picture.render_pixels(&all),
        }?;
        Ok(prepared)
    }

    /// The structure that a scene asks for, or the one that is best here.
    fn accel_for(&self, scene: &CompiledScene) -> AccelKind {
        match scene.options.accel {
            AccelKind::Auto => choice::best_for(&self.gpu.info, scene),
            kind => kind,
        }
    }
}

impl Backend for GpuBackend {
    fn name(&self) -> String {
        self.gpu.name()
    }

    fn differs(&self, scene: &CompiledScene, settings: &RenderSettings) -> Option<&'static str> {
        let is_random = settings.integrator == IntegratorKind::Classic && ScenePlan::needs_ordered_rays(scene);
        is_random.then_some(
            "the GPU draws other random numbers than POV-Ray for crand and the jitter of area lights, media and rainbows: the same grain, not dot for dot",
        )
    }

    fn render(
        &self,
        scene: &CompiledScene,
        settings: &RenderSettings,
        film: &mut Film,
        progress: &dyn Progress,
        cancel: &AtomicBool,
    ) -> Result<(), BackendError> {
        if settings.integrator == IntegratorKind::Path {
            return path::render(&self.gpu, scene, settings, self.accel_for(scene), film, progress, cancel);
        }
        self.render_classic(scene, settings, film, progress, cancel, None).map(|_| ())
    }
}

/// A picture on its way from the wavefront into the film.
struct Picture<'p> {
    plan: &'p ScenePlan,
    wavefront: Wavefront<'p>,
    camera: Arc<camera::CameraRays<'p>>,
    settings: &'p RenderSettings,
    film: &'p mut Film,
    progress: &'p dyn Progress,
    cancel: &'p AtomicBool,
    done: u64,
    /// Samples of the next part of the picture: what is done is told, kept and saved part by part.
    part: u32,
    /// Places that were asked for last, and what is seen there.
    places: Vec<(f64, f64)>,
    found: Vec<Sample>,
}

/// A part that took less is followed by one of twice the size, so that the device is seldom half empty; after one that took more comes one of half the size.
const SHORT_PART: Duration = Duration::from_millis(700);
const LONG_PART: Duration = Duration::from_secs(4);

impl Picture<'_> {
    /// One sample for every pixel of the picture, row by row.
    fn render_rows(&mut self) -> Result<(), BackendError> {
        let [left, mut top, x1, y1] = self.settings.crop;
        let columns = x1 - left;
        while top < y1 && columns > 0 {
            let start = Instant::now();
            let rows = (self.part / columns).clamp(1, y1 - top);
            let places = Places::Pixels { left, top, columns, rows };
            if !self.trace(&places)? {
                return Ok(());
            }
            add_rows(self.film, [left, top, columns], &self.found);
            self.tell(places.len());
            self.settle_part(start.elapsed());
            top += rows;
        }
        Ok(())
    }

    /// The same samples for every pixel: as many pixels at a time as the wavefront takes.
    fn render_pixels(&mut self, all: &[Block]) -> Result<(), BackendError> {
        let of_block = |&[x0, y0, x1, y1]: &Block| (y0..y1).flat_map(move |y| (x0..x1).map(move |x| (x, y)));
        let pixels: Vec<(u32, u32)> = all.iter().flat_map(of_block).collect();
        let samples = self.settings.samples.clone();
        let n_samples = samples.len().max(1) as u32;
        // At most as many samples of a pixel at once as fit; the film joins the rest.
        let at_once = n_samples.min(self.wavefront.max_samples);
        let seed = self.settings.seed;
        let mut rest = pixels.as_slice();
        while let Some(part) = self.next_part(&mut rest, at_once) {
            let start = Instant::now();
            let mut first = samples.start;
            while first < samples.start + n_samples {
                let end = (first + at_once).min(samples.start + n_samples);
                let at: Vec<(f64, f64)> = if n_samples == 1 {
                    part.par_iter().map(|(x, y)| (f64::from(*x), f64::from(*y))).collect()
                } else {
                    part.par_iter().flat_map_iter(|p| sample_places(*p, first..end, seed)).collect()
                };
                if !self.trace(&Places::List(&at))? {
                    return Ok(());
                }
                let n = end - first;
                let means: Vec<Sample> =
                    self.found.par_chunks(n as usize).map(|list| sum_of(list).map(|v| v / list.len() as f32)).collect();
                for ((x, y), mean) in part.iter().zip(means) {
                    add_samples(self.film, self.film.index(*x, *y), mean, n);
                }
                first = end;
            }
            self.tell(part.len());
            self.settle_part(start.elapsed());
        }
        Ok(())
    }

    /// Blocks that decide their samples by what the first ones show.
    fn render_blocks(&mut self, aa: &Antialias, all: &[Block]) -> Result<(), BackendError> {
        let side = self.settings.block_size.max(4) as usize + 1;
        let mut rest = all;
        while let Some(part) = self.next_part(&mut rest, (side * side) as u32) {
            let start = Instant::now();
            let mut memos: Vec<BlockMemo> = part.par_iter().map(|b| BlockMemo::new(aa, *b)).collect();
            loop {
                // What each block still wants to see.
                let wanted: Vec<&[(f64, f64)]> = memos.par_iter_mut().map(|m| m.advance()).collect();
                join_lists(&wanted, &mut self.places);
                if self.places.is_empty() {
                    break;
                }
                let counts: Vec<usize> = wanted.iter().map(|list| list.len()).collect();
                let places = std::mem::take(&mut self.places);
                let is_done = self.trace(&Places::List(&places))?;
                self.places = places;
                if !is_done {
                    return Ok(());
                }
                let mut rest = self.found.as_slice();
                let own: Vec<&[Sample]> = counts.iter().map(|n| rest.split_off(..*n).expect("a sample a place")).collect();
                memos.par_iter_mut().zip(own).filter(|(_, own)| !own.is_empty()).for_each(|(memo, own)| memo.learn(own));
            }
            add_blocks(self.film, self.settings.block_size, part, &memos);
            self.tell(part.iter().map(|[x0, y0, x1, y1]| (x1 - x0) as usize * (y1 - y0) as usize).sum());
            self.settle_part(start.elapsed());
        }
        Ok(())
    }

    /// Takes the next part off `rest`, whose items bring so many samples each.
    fn next_part<'r, T>(&self, rest: &mut &'r [T], of_each: u32) -> Option<&'r [T]> {
        let n = ((self.part / of_each).max(1) as usize).min(rest.len());
        let (part, others) = rest.split_at(n);
        *rest = others;
        (n > 0).then_some(part)
    }

    /// Chooses the size of the next part by what the last one took.
    fn settle_part(&mut self, took: Duration) {
        if took < SHORT_PART {
            self.part = (2 * self.part).min(self.wavefront.max_slots);
        } else if took > LONG_PART {
            self.part = (self.part / 2).max(self.wavefront.max_samples / 4);
        }
    }

    /// Finds what is seen at each place; false when cancelled.
    fn trace(&mut self, places: &Places) -> Result<bool, BackendError> {
        self.found.clear();
        let (camera, most) = (&self.plan.camera, self.wavefront.max_slots as usize);
        if let Some(mesh) = &camera.mesh {
            return self.trace_mesh(mesh, places);
        }
        if self.wavefront.camera() == DeviceCamera::None {
            let rays = self.camera.clone();
            return match &camera.lens {
                Some(lens) => self.trace_lens(lens, places),
                None => self.trace_made(places.len(), &|k| rays.single_start(places.at(k))),
            };
        }
        let lens = camera.lens.as_ref();
        match places {
            Places::Pixels { .. } if places.len() <= most => self.wavefront.trace(places, lens, self.cancel, &mut self.found),
            Places::Pixels { .. } => {
                let list: Vec<(f64, f64)> = (0..places.len()).into_par_iter().map(|k| places.at(k)).collect();
                self.trace(&Places::List(&list))
            }
            Places::List(list) => {
                for part in list.chunks(most) {
                    if !self.wavefront.trace(&Places::List(part), lens, self.cancel, &mut self.found)? {
                        return Ok(false);
                    }
                }
                Ok(true)
            }
        }
    }

    /// Finds what the host's rays see, however many there are; false when cancelled.
    fn trace_made(&mut self, n: usize, make: MakeStart) -> Result<bool, BackendError> {
        let most = self.wavefront.max_slots as usize;
        for first in (0..n).step_by(most) {
            let of_part = |k: usize| make(first + k);
            if !self.wavefront.trace_made(most.min(n - first) as u32, &of_part, self.cancel, &mut self.found)? {
                return Ok(false);
            }
            self.camera.check()?;
        }
        Ok(true)
    }

    /// What a projection shows beyond its rim.
    fn nothing(&self) -> Sample {
        [0.0, 0.0, 0.0, if self.settings.output_alpha { 1.0 } else { 0.0 }]
    }

    /// Finds means over the rays of a mesh camera.
    fn trace_mesh(&mut self, mesh: &MeshCamera, places: &Places) -> Result<bool, BackendError> {
        let (starts, counts) = self.camera.mesh_starts(mesh, places);
        if !self.trace_made(starts.len(), &|k| starts[k])? {
            return Ok(false);
        }
        let (nothing, all) = (self.nothing(), std::mem::take(&mut self.found));
        let mut rest = all.as_slice();
        self.found.extend(counts.iter().map(|n| {
            let (own, others) = rest.split_at(*n as usize);
            rest = others;
            if own.is_empty() { nothing } else { sum_of(own).map(|v| v / *n as f32) }
        }));
        Ok(true)
    }

    /// Finds means over the lens, of as many samples as each place wants, from rays of the host. Twins: `blurred` in src/integrate/classic/pixel.rs,
    /// `Wavefront::trace`.
    fn trace_lens(&mut self, lens: &Lens, places: &Places) -> Result<bool, BackendError> {
        let mut sums = vec![([0.0f32; 4], [0.0f32; 4]); places.len()];
        let mut means = vec![[0.0f32; 4]; places.len()];
        let mut open: Vec<usize> = (0..places.len()).collect();
        let (mut n, mut group) = (0, 0);
        while n < lens.max_samples() && !open.is_empty() {
            let more = lens.group(group).min(lens.max_samples() - n);
            // Few places at a time, so that memory is bounded.
            for part in open.chunks((self.wavefront.max_slots / more).max(1) as usize) {
                self.found.clear();
                let rays = self.camera.clone();
                let of_part = |k: usize| rays.lens_start(lens, places.at(part[k / more as usize]), n + k as u32 % more);
                let mut found = std::mem::take(&mut self.found);
                let is_done = self.wavefront.trace_made(part.len() as u32 * more, &of_part, self.cancel, &mut found)?;
                self.found = found;
                if !is_done {
                    return Ok(false);
                }
                let with_own = |(k, own): (&usize, &[Sample])| {
                    let (mut sum, mut sum_sq) = sums[*k];
                    for s in own {
                        (0..4).for_each(|c| sum[c] += s[c]);
                        (0..4).for_each(|c| sum_sq[c] += s[c] * s[c]);
                    }
                    (sum, sum_sq)
                };
                let grown: Vec<_> = part.par_iter().zip(self.found.par_chunks(more as usize)).map(with_own).collect();
                part.iter().zip(grown).for_each(|(k, new)| sums[*k] = new);
            }
            self.camera.check()?;
            n += more;
            group += 1;
            open.retain(|k| {
                let (sum, sum_sq) = sums[*k];
                means[*k] = sum.map(|v| v / n as f32);
                !lens.is_settled(n, sum, sum_sq)
            });
        }
        self.found = means;
        Ok(true)
    }

    fn tell(&mut self, n: usize) {
        let [x0, y0, x1, y1] = self.settings.crop.map(u64::from);
        self.done += n as u64;
        self.progress.pixels(self.done, (x1 - x0) * (y1 - y0));
    }
}

/// All lists one behind the other, on all cores.
fn join_lists<T: Copy + Default + Send + Sync>(lists: &[&[T]], out: &mut Vec<T>) {
    out.resize(lists.iter().map(|list| list.len()).sum(), T::default());
    let mut rest = out.as_mut_slice();
    let pieces: Vec<&mut [T]> = lists.iter().map(|list| rest.split_off_mut(..list.len()).expect("the sum of all lengths")).collect();
    pieces.into_par_iter().zip(lists).for_each(|(to, from)| to.copy_from_slice(from));
}

/// Sums of the channels.
fn sum_of(samples: &[Sample]) -> Sample {
    samples.iter().fold([0.0; 4], |sum, s| std::array::from_fn(|c| sum[c] + s[c]))
}

/// Picture positions of a range of a pixel's samples.
fn sample_places((x, y): (u32, u32), range: std::ops::Range<u32>, seed: u32) -> impl Iterator<Item = (f64, f64)> {
    range.map(move |k| {
        let (dx, dy) = sample_position(x, y, k, seed);
        (f64::from(x) + dx, f64::from(y) + dy)
    })
}
