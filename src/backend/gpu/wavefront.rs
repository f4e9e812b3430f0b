//! The wavefront: rays wait in a queue, each step takes a batch off its end through trace, shade and shadow, and puts the rays that the
//! hits sent on in its place. Last in, first out: the queue grows by a few rays a level, not by the whole picture. Camera rays come in when
//! fewer wait than a step takes, and shadow rays that go on behind clear surfaces wait for those of the next step, so that the device is full
//! until the last rays of all.
//!
//! Stages: `camera_rays` (of focal blur `lens_rays`, of the host's own rays `generate_rays`), then until the queue is empty `trace_closest`, where there are media `media_round`, `shade`,
//! `trace_shadow`, `filter_shadow`. Where light is asked for in rounds (area lights, lit media) the shadow rays of a step are followed to their ends
//! before `area_round` and `media_round` look at what arrived and ask again. `project_light` comes before `trace_shadow` where lights are projected
//! through objects.

use super::buffers::{FAULT_INTERIORS, SceneBuffers, low_part};
use super::camera_buffers::DeviceCamera;
use super::device::{Gpu, binding_layout, uniform_layout};
use super::layout::{AreaTask, Batch, Counters, Hit, Ray, ShadowRay, Start};
use super::shader::assemble;
use super::stage_clock::StageClock;
use crate::backend::BackendError;
use crate::integrate::antialias::Sample;
use crate::kernel::lens::Lens;
use bytemuck::{Pod, bytes_of, cast_slice};
use rayon::prelude::*;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Most rays of a step. 64 bytes a ray and more: a few hundred megabytes of queues.
const MAX_SAMPLES: u32 = 1 << 18;
/// A software device has its cores busy with far fewer, and smaller steps can be cancelled sooner.
const MAX_SAMPLES_SOFTWARE: u32 = 1 << 15;
/// Camera rays that one call may bring, in steps: 16 bytes each, and as many for the place that they look through.
const SLOTS_PER_SAMPLE: u32 = 8;
/// Points of area lights that are kept at once: 16 bytes each.
const MAX_AREA_POINTS: u32 = 1 << 23;
const MAX_AREA_POINTS_SOFTWARE: u32 = 1 << 20;
/// Rays in the queue for every sample.
const QUEUE_DEPTH: u32 = 4;
/// Steps that take longer are made smaller, since drivers end what runs for two seconds and desktops stand still meanwhile; those that take
/// less are made larger.
const LONG_STEP: Duration = Duration::from_millis(400);
const SHORT_STEP: Duration = Duration::from_millis(80);
/// Places that one core carries over at a time.
const CHUNK: usize = 1 << 8;
/// The first step, of which nothing is known.
const FIRST_BATCH: u32 = 1 << 14;

/// A kernel.
struct Stage {
    name: &'static str,
    pipeline: wgpu::ComputePipeline,
}

/// All kernels that a scene wants.
struct Stages {
    /// The one of the three that makes camera rays.
    first_rays: Stage,
    lens_sums: Option<Stage>,
    trace_closest: Stage,
    shade: Stage,
    trace_shadow: Stage,
    filter_shadow: Option<Stage>,
    area_round: Option<Stage>,
    project_light: Option<Stage>,
    media_round: Option<Stage>,
}

/// A scene on a device, ready to trace samples.
pub(super) struct Wavefront<'g> {
    gpu: &'g Gpu,
    stages: Stages,
    clock: Option<&'g StageClock>,
    /// Group 0 with the shadow queues as they are, and with the two of them swapped.
    groups: [wgpu::BindGroup; 2],
    tables: wgpu::BindGroup,
    batch: wgpu::Buffer,
    rays: wgpu::Buffer,
    children: wgpu::Buffer,
    counters: wgpu::Buffer,
    radiance: wgpu::Buffer,
    hits: wgpu::Buffer,
    /// The hits, while the buffer serves shadow rays of media.
    kept_hits: wgpu::Buffer,
    media_points: u32,
    starts: wgpu::Buffer,
    positions: wgpu::Buffer,
    lens_totals: wgpu::Buffer,
    lens_open: wgpu::Buffer,
    /// Which rays of the camera are made here.
    camera: DeviceCamera,
    /// Colours on their way to the host.
    colors_copy: wgpu::Buffer,
    /// The counters on their way to the host.
    counters_copy: wgpu::Buffer,
    /// Samples that the device has room for in a step.
    pub max_samples: u32,
    /// Samples of one call at most.
    pub max_slots: u32,
    max_children: u32,
    /// Shadow rays of a hit, and the queue's room for them.
    hit_shadows: u32,
    max_shadows: u32,
    /// Light is asked for in rounds: the shadow rays of a step must end within it.
    asks_in_rounds: bool,
    queue_len: u32,
    /// What a step may take, and what it takes by what the last ones needed.
    max_batch: u32,
    batch_now: u32,
}

/// Rays of the next step, after one of `n` rays that took so long.
fn next_batch(n: u32, now: u32, most: u32, took: Duration) -> u32 {
    if took > LONG_STEP {
        return (n / 2).max(1024).min(most);
    }
    // A step of fewer rays than it may have says nothing about larger ones.
    if took < SHORT_STEP && n == now { now.saturating_mul(2).min(most) } else { now }
}

/// Picture positions, integers at pixel centres.
#[derive(Clone, Copy)]
pub(super) enum Places<'a> {
    /// Pixels row by row.
    Pixels {
        left: u32,
        top: u32,
        columns: u32,
        rows: u32,
    },
    List(&'a [(f64, f64)]),
}

impl Places<'_> {
    /// How many.
    pub fn len(&self) -> usize {
        match self {
            Self::Pixels { columns, rows, .. } => *columns as usize * *rows as usize,
            Self::List(list) => list.len(),
        }
    }

    /// Place number `k`.
    pub fn at(&self, k: usize) -> (f64, f64) {
        match *self {
            Self::Pixels { left, top, columns, .. } => {
                let (x, y) = (left + k as u32 % columns, top + k as u32 / columns);
                (f64::from(x), f64::from(y))
            }
            Self::List(list) => list[k],
        }
    }
}

/// Makes ray number so-and-so on the host.
pub(super) type MakeStart<'a> = &'a (dyn Fn(usize) -> Start + Sync);

/// Where camera rays come from.
#[derive(Clone, Copy)]
enum Source<'a> {
    /// The host.
    Made(MakeStart<'a>),
    /// The device: of places that it has. Those of the lens: first of the open ones and the list that they stand in, first sample and how many of each.
    Places { raster: [u32; 4], lens: Option<LensPart> },
}

/// Samples of the lens at some of the places that are not settled.
#[derive(Clone, Copy)]
struct LensPart {
    open_first: u32,
    open_side: u32,
    first: u32,
    samples: u32,
}

/// Camera rays on their way into the queue.
struct Supply<'a> {
    source: Source<'a>,
    /// How many in all, and how many of them are in the queue.
    n: u32,
    sent: u32,
    /// Those of the host that come next, made while the device was busy.
    next: Vec<Start>,
}

impl<'a> Supply<'a> {
    fn new(source: Source<'a>, n: u32) -> Self {
        Self { source, n, sent: 0, next: Vec::new() }
    }

    /// The host's rays that are wanted next, `room` at most, and who makes them; `None` where nothing is to be done.
    fn missing(&self, room: u32) -> Option<(MakeStart<'a>, Range<usize>)> {
        let Source::Made(make) = self.source else { return None };
        let n = room.min(self.n - self.sent) as usize;
        let first = self.sent as usize;
        (self.next.is_empty() && n > 0).then_some((make, first..first + n))
    }
}

/// Rays of the host, on all cores.
fn made((make, range): (MakeStart, Range<usize>)) -> Vec<Start> {
    range.into_par_iter().map(make).collect()
}

/// What waits in the queues.
#[derive(Clone, Copy)]
struct Waiting {
    rays: u32,
    shadows: u32,
    /// Which of the two shadow queues they stand in.
    side: usize,
}

/// Bytes of `n` structs.
fn bytes<T: Pod>(n: u32) -> u64 {
    u64::from(n) * size_of::<T>() as u64
}

impl<'g> Wavefront<'g> {
    /// Uploads a scene and makes its pipelines; `clock` hears what each dispatch takes.
    pub fn new(gpu: &'g Gpu, scene: &SceneBuffers, clock: Option<&'g StageClock>) -> Result<Self, BackendError> {
        // Places want all their bits: another hash would choose other points of a lens.
        let camera = if gpu.has_double() { scene.camera } else { DeviceCamera::None };
        let is_software = gpu.info.device_type == wgpu::DeviceType::Cpu;
        let most = if is_software { MAX_SAMPLES_SOFTWARE } else { MAX_SAMPLES };
        let fitting = gpu.max_binding() / (u64::from(QUEUE_DEPTH) * size_of::<Ray>() as u64);
        let max_samples = most.min(fitting.min(u64::from(u32::MAX)) as u32).max(1024);
        let queue_len = max_samples * QUEUE_DEPTH;
        let max_slots = max_samples * SLOTS_PER_SAMPLE;
        let max_shadows = (2 * max_samples).max(scene.max_shadows);
        let n_children = (2 * max_samples).max(scene.max_children);
        let max_areas = if scene.max_areas > 0 { (2 * max_samples).max(scene.max_areas) } else { 0 };
        let most = if most == MAX_SAMPLES { MAX_AREA_POINTS } else { MAX_AREA_POINTS_SOFTWARE };
        let needed = scene.max_area_points.max(scene.media_points);
        let max_area_points = if needed > 0 { most.max(needed) } else { 0 };
        let storage = |what: &str, bytes: &[u8]| gpu.storage_buffer(what, bytes);
        let params = gpu.uniform_buffer("scene parameters", bytes_of(&scene.params));
        let batch = gpu.uniform_buffer("batch", bytes_of(&Batch::default()));
        let fixed = [
            storage("primitives", cast_slice(&scene.prims))?,
            storage("transforms", cast_slice(&scene.transforms))?,
            storage("scene words", cast_slice(&scene.words))?,
            storage("tree nodes", cast_slice(&scene.meshes.nodes))?,
            storage("tree references", cast_slice(&scene.meshes.refs))?,
            storage("triangles", cast_slice(&scene.meshes.corners))?,
            storage("triangle attributes", cast_slice(&scene.meshes.face_words))?,
            storage("finishes", cast_slice(&scene.finishes))?,
            storage("lights", cast_slice(&scene.lights))?,
            storage("interiors", cast_slice(&scene.interiors))?,
        ];
        let rays = gpu.empty_buffer("rays", bytes::<Ray>(queue_len))?;
        let hits = gpu.empty_buffer("hits", bytes::<Hit>(max_samples.max(max_shadows)))?;
        let kept_hits = gpu.empty_buffer("kept hits", bytes::<Hit>(if scene.media_points > 0 { max_samples } else { 0 }))?;
        let children = gpu.empty_buffer("new rays", bytes::<Ray>(n_children))?;
        let shadows = [0, 1].map(|_| gpu.empty_buffer("shadow rays", bytes::<ShadowRay>(max_shadows)));
        let [a, b] = shadows;
        let (a, b) = (a?, b?);
        let counters = gpu.empty_buffer("counters", bytes::<Counters>(1))?;
        let radiance = gpu.empty_buffer("radiance", bytes::<[f32; 4]>(max_slots) + bytes::<[f32; 4]>(max_area_points))?;
        let areas = gpu.empty_buffer("area lights at hits", bytes::<AreaTask>(max_areas))?;
        let counters_copy = gpu.read_buffer(size_of::<Counters>() as u64);
        let room_if = |holds: bool, size: u64| if holds { size } else { 0 };
        let starts = gpu.empty_buffer("camera rays", room_if(camera == DeviceCamera::None, bytes::<Start>(max_samples)))?;
        let positions = gpu.empty_buffer("picture places", room_if(camera != DeviceCamera::None, bytes::<[f32; 4]>(max_slots)))?;
        let has_lens = camera == DeviceCamera::Lens;
        let lens_totals = gpu.empty_buffer("sums over the lens", room_if(has_lens, 2 * bytes::<[f32; 4]>(max_slots)))?;
        let lens_open = gpu.empty_buffer("open places", room_if(has_lens, bytes::<u32>(2 * max_slots + 1)))?;
        let colors_copy = gpu.read_buffer(bytes::<[f32; 4]>(max_slots));

        let mut entries = vec![uniform_layout(0), uniform_layout(1)];
        entries.extend((2..12).map(|k| binding_layout(k, false)));
        entries.extend((12..19).map(|k| binding_layout(k, true)));
        entries.push(binding_layout(19, false));
        entries.push(binding_layout(20, true));
        entries.push(binding_layout(21, false));
        entries.extend((22..24).map(|k| binding_layout(k, true)));
        let scene_layout = gpu.group_layout("scene", &entries);
        let table_layout = gpu.group_layout("tables", &[binding_layout(0, false), binding_layout(1, false)]);
        let group = |a: &wgpu::Buffer, b: &wgpu::Buffer| {
            let mut list: Vec<&wgpu::Buffer> = vec![&params, &batch];
            list.extend(&fixed);
            list.extend([&rays, &hits, &children, a, b, &counters, &radiance, &starts, &areas, &positions, &lens_totals, &lens_open]);
            let numbered: Vec<(u32, &wgpu::Buffer)> = (0..).zip(list).collect();
            gpu.bind_group(&scene_layout, &numbered)
        };
        let groups = [group(&a, &b), group(&b, &a)];
        let words = storage("texture words", cast_slice(&scene.textures.words))?;
        let images = storage("image words", cast_slice(&scene.textures.image_words))?;
        let tables = gpu.bind_group(&table_layout, &[(0, &words), (1, &images)]);
        let stage = |name: &'static str| -> Result<Stage, BackendError> {
            let mut options = scene.options.clone();
            options.feature_if("shadow_rays", name == "trace_shadow");
            options.feature_if("double", gpu.has_double());
            options.constant("AREA_POINTS_AT", max_slots);
            options.constant("MAX_PLACES", max_slots);
            options.constant("MAX_AREA_POINTS", max_area_points);
            let start = Instant::now();
            let pipeline = gpu.compute_pipeline(name, &assemble(name, &options)?, name, &[&scene_layout, &table_layout])?;
            clock.inspect(|c| c.compiled(name, start.elapsed().as_secs_f64()));
            Ok(Stage { name, pipeline })
        };
        // Drivers compile one pipeline on one core: all at once take as long as the longest.
        let first_rays = match camera {
            DeviceCamera::None => "generate_rays",
            DeviceCamera::Plain => "camera_rays",
            DeviceCamera::Lens => "lens_rays",
        };
        let wanted = [
            (first_rays, true),
            ("trace_closest", true),
            ("shade", true),
            ("trace_shadow", true),
            ("lens_sums", has_lens),
            ("area_round", scene.max_areas > 0),
            ("media_round", scene.media),
            ("project_light", scene.lights.iter().any(|l| l.projected_at != 0)),
            ("filter_shadow", scene.transparency),
        ];
        let made = wanted.par_iter().map(|(name, needed)| needed.then(|| stage(name)).transpose()).collect::<Result<Vec<_>, _>>()?;
        let Ok(
            [
                Some(first_rays),
                Some(trace_closest),
                Some(shade),
                Some(trace_shadow),
                lens_sums,
                area_round,
                media_round,
                project_light,
                filter_shadow,
            ],
        ) = <[_; 9]>::try_from(made)
        else {
            unreachable!("the first four are always wanted")
        };
        let stages =
            Stages { first_rays, lens_sums, trace_closest, shade, trace_shadow, area_round, media_round, project_light, filter_shadow };
        // No batch may send on more than the queues hold.
        let fitting = [
            n_children / scene.max_children.max(1),
            max_shadows / scene.max_shadows.max(1),
            max_areas.checked_div(scene.max_areas).unwrap_or(u32::MAX),
            max_area_points.checked_div(needed).unwrap_or(u32::MAX),
        ];
        let max_batch = fitting.into_iter().fold(max_samples, u32::min).max(1);
        let max_children = scene.max_children;
        let asks_in_rounds = needed > 0 || stages.area_round.is_some() || stages.project_light.is_some();
        Ok(Self {
            gpu,
            stages,
            clock,
            groups,
            tables,
            batch,
            rays,
            children,
            counters,
            radiance,
            hits,
            kept_hits,
            media_points: scene.media_points,
            starts,
            positions,
            lens_totals,
            lens_open,
            camera,
            colors_copy,
            counters_copy,
            max_samples,
            max_slots,
            max_children,
            hit_shadows: scene.max_shadows,
            max_shadows,
            asks_in_rounds,
            queue_len,
            max_batch,
            batch_now: max_batch.min(FIRST_BATCH),
        })
    }

    /// Which rays of the camera are made here, of places alone.
    pub fn camera(&self) -> DeviceCamera {
        self.camera
    }

    /// Appends to `found` the red, green, blue and transmit seen by `n` rays of the host, up to `max_slots`; false when cancelled.
    pub fn trace_made(&mut self, n: u32, make: MakeStart, cancel: &AtomicBool, found: &mut Vec<Sample>) -> Result<bool, BackendError> {
        let supply = Supply::new(Source::Made(make), n);
        Ok(self.follow(supply, cancel)? && self.take(&self.radiance, n, found).map(|()| true)?)
    }

    /// Appends what is seen at up to `max_slots` places, whose rays are made here, through the whole of a lens if there is one; false when cancelled.
    pub fn trace(
        &mut self,
        places: &Places,
        lens: Option<&Lens>,
        cancel: &AtomicBool,
        found: &mut Vec<Sample>,
    ) -> Result<bool, BackendError> {
        let n = places.len() as u32;
        assert!(n <= self.max_slots, "the caller cuts its places into parts");
        let raster = match *places {
            Places::Pixels { left, top, columns, rows } => [left, top, columns, rows],
            Places::List(list) => {
                self.send_places(list);
                [0; 4]
            }
        };
        let Some(lens) = lens else {
            let supply = Supply::new(Source::Places { raster, lens: None }, n);
            return Ok(self.follow(supply, cancel)? && self.take(&self.radiance, n, found).map(|()| true)?);
        };
        let (mut first, mut group, mut n_open, mut side) = (0, 0, n, 0);
        while first < lens.max_samples() && n_open > 0 {
            let samples = lens.group(group).min(lens.max_samples() - first);
            self.gpu.queue.write_buffer(&self.lens_open, 0, bytes_of(&0u32));
            // As many places at a time as have slots for their samples.
            let at_once = (self.max_slots / samples).max(1);
            for open_first in (0..n_open).step_by(at_once as usize) {
                let n_places = at_once.min(n_open - open_first);
                let part = LensPart { open_first, open_side: side, first, samples };
                if !self.follow(Supply::new(Source::Places { raster, lens: Some(part) }, n_places * samples), cancel)? {
                    return Ok(false);
                }
                self.set_batch(Batch { n: n_places, ..camera_batch(raster, Some(part)) });
                let mut encoder = self.encoder();
                self.run(&mut encoder, self.stages.lens_sums.as_ref().expect("the scene has a lens"), 0, n_places);
                self.gpu.queue.submit([encoder.finish()]);
            }
            let bytes = self.gpu.submit_and_read_into(self.encoder(), &self.lens_open, 0, 4, &self.counters_copy)?;
            n_open = bytemuck::pod_read_unaligned(&bytes[..4]);
            (first, group, side) = (first + samples, group + 1, 1 - side);
        }
        self.take(&self.lens_totals, n, found).map(|()| true)
    }

    /// Carries places over: two numbers and what 32 bits leave off them.
    fn send_places(&self, list: &[(f64, f64)]) {
        let Some(size) = wgpu::BufferSize::new(bytes::<[f32; 4]>(list.len() as u32)) else { return };
        let mut view = self.gpu.queue.write_buffer_with(&self.positions, 0, size).expect("the caller cuts its places into parts");
        let words = |(x, y): &(f64, f64)| [*x as f32, *y as f32, low_part(*x), low_part(*y)];
        let whole = list.len() / CHUNK * CHUNK;
        let (chunks, mut rest) = view.slice(..).into_chunks::<{ 16 * CHUNK }>();
        rest.copy_from_slice(cast_slice(&list[whole..].iter().map(words).collect::<Vec<[f32; 4]>>()));
        let chunks: Vec<wgpu::WriteOnly<'_, [u8; 16 * CHUNK]>> = chunks.into_iter().collect();
        chunks.into_par_iter().zip(list.par_chunks_exact(CHUNK)).for_each(|(to, from)| {
            let numbers: [[f32; 4]; CHUNK] = std::array::from_fn(|k| words(&from[k]));
            wgpu::WriteOnly::<[u8]>::from(to).copy_from_slice(cast_slice(&numbers));
        });
    }

    /// Appends the first `n` colours of a buffer to `found`.
    fn take(&self, buffer: &wgpu::Buffer, n: u32, found: &mut Vec<Sample>) -> Result<(), BackendError> {
        self.clock.map_or(Ok(()), |c| c.read(self.gpu))?;
        let start = found.len();
        found.resize(start + n as usize, [0.0; 4]);
        let size = bytes::<[f32; 4]>(n);
        self.gpu.submit_and_map(self.encoder(), buffer, 0, size, &self.colors_copy, |bytes| {
            found[start..].par_chunks_mut(1 << 12).zip(bytes.par_chunks(16 << 12)).for_each(|(to, from)| {
                bytemuck::cast_slice_mut(to).copy_from_slice(from);
                // As the CPU has it: what is not a number is black.
                for s in to.iter_mut().filter(|s| !s[..3].iter().all(|v| v.is_finite())) {
                    s[..3].fill(0.0);
                }
            });
        })
    }

    /// Makes the camera rays and follows them to their ends; false when cancelled.
    fn follow(&mut self, mut supply: Supply, cancel: &AtomicBool) -> Result<bool, BackendError> {
        assert!(supply.n <= self.max_slots, "the caller cuts its samples into parts");
        if supply.n == 0 {
            return Ok(true);
        }
        let mut encoder = self.encoder();
        encoder.clear_buffer(&self.radiance, 0, Some(bytes::<[f32; 4]>(supply.n)));
        self.gpu.queue.submit([encoder.finish()]);
        let mut waiting = Waiting { rays: 0, shadows: 0, side: 0 };
        loop {
            if cancel.load(Ordering::Relaxed) {
                return Ok(false);
            }
            while supply.sent < supply.n && waiting.rays < self.batch_now {
                waiting.rays += self.generate(&mut supply, waiting.rays);
            }
            if waiting.rays == 0 {
                break;
            }
            // The host makes the next rays while the device works.
            waiting = match supply.missing(self.max_samples) {
                Some(work) => {
                    let (after, next) = rayon::join(|| self.step(waiting), || made(work));
                    supply.next = next;
                    after?
                }
                None => self.step(waiting)?,
            };
        }
        self.shadow_steps(waiting.shadows, waiting.side)?;
        Ok(true)
    }

    /// Puts the next camera rays in the queue behind the `waiting` ones; gives how many.
    fn generate(&self, supply: &mut Supply, waiting: u32) -> u32 {
        let room = self.max_samples.min(self.queue_len - waiting);
        let mut n = room.min(supply.n - supply.sent);
        let batch = match supply.source {
            Source::Made(_) => {
                if let Some(work) = supply.missing(room) {
                    supply.next = made(work);
                }
                let rest = supply.next.split_off((n as usize).min(supply.next.len()));
                let starts = std::mem::replace(&mut supply.next, rest);
                n = starts.len() as u32;
                self.gpu.queue.write_buffer(&self.starts, 0, cast_slice(&starts));
                Batch::default()
            }
            Source::Places { raster, lens } => camera_batch(raster, lens),
        };
        self.set_batch(Batch { first: waiting, n, slot: supply.sent, ..batch });
        let mut encoder = self.encoder();
        self.run(&mut encoder, &self.stages.first_rays, 0, n);
        self.gpu.queue.submit([encoder.finish()]);
        supply.sent += n;
        n
    }

    /// Takes a batch off the end of the rays that wait; gives what waits afterwards.
    fn step(&mut self, waiting: Waiting) -> Result<Waiting, BackendError> {
        let start = Instant::now();
        // A batch of n takes n rays away and may bring max_children * n, and hit_shadows * n shadow rays.
        let room = (self.queue_len - waiting.rays) / self.max_children.saturating_sub(1).max(1);
        let shadow_room = (self.max_shadows - waiting.shadows) / self.hit_shadows.max(1);
        let n = waiting.rays.min(self.batch_now).min(room.max(1)).min(shadow_room.max(1));
        let first = waiting.rays - n;
        self.set_batch(Batch { first, n, ..Batch::default() });
        self.count_from(waiting.shadows);
        let mut encoder = self.encoder();
        self.run(&mut encoder, &self.stages.trace_closest, 0, n);
        if let Some(stage) = &self.stages.media_round {
            encoder = self.media_rounds(stage, encoder, first, n)?;
        }
        self.run(&mut encoder, &self.stages.shade, waiting.side, n);
        let (counters, shadows, side) = if self.asks_in_rounds {
            let counters = self.read_counters(encoder)?;
            self.shadow_steps(counters.n_shadows, 0)?;
            self.area_rounds(&counters)?;
            (counters, 0, 0)
        } else {
            // How many there are is known on the device alone: threads too many end at once.
            let most = (waiting.shadows + self.hit_shadows * n).min(self.max_shadows);
            self.shadow_pass(&mut encoder, waiting.side, most);
            let counters = self.read_counters(encoder)?;
            // Those that go on wait for the next step, unless they leave it no room.
            let enough = (self.max_shadows / 4).min(self.max_shadows - self.hit_shadows);
            let (left, side) = self.shadow_steps_down_to(counters.n_shadows_out, 1 - waiting.side, enough)?;
            (counters, left, side)
        };
        let n_children = counters.n_children;
        if u64::from(first) + u64::from(n_children) > u64::from(self.queue_len) {
            return Err(BackendError::Unsupported("more rays in flight than the queue holds".into()));
        }
        if n_children > 0 {
            let mut encoder = self.encoder();
            encoder.copy_buffer_to_buffer(&self.children, 0, &self.rays, bytes::<Ray>(first), bytes::<Ray>(n_children));
            self.gpu.queue.submit([encoder.finish()]);
        }
        self.batch_now = next_batch(n, self.batch_now, self.max_batch, start.elapsed());
        self.clock.map_or(Ok(()), |c| c.read_when_filling(self.gpu))?;
        Ok(Waiting { rays: first + n_children, shadows, side })
    }

    /// Traces the shadow rays of one queue, at most `most`; those that go on stand in the other one.
    fn shadow_pass(&self, encoder: &mut wgpu::CommandEncoder, side: usize, most: u32) {
        self.run(encoder, &self.stages.trace_shadow, side, most);
        if let Some(filter) = &self.stages.filter_shadow {
            self.run(encoder, filter, side, most);
        }
    }

    /// Follows the `n` shadow rays of a queue, and those that go on behind clear surfaces, to their ends.
    fn shadow_steps(&self, n: u32, side: usize) -> Result<(), BackendError> {
        self.shadow_steps_down_to(n, side, 0).map(|_| ())
    }

    /// The same until no more than `enough` are left; gives how many, and which queue they stand in.
    fn shadow_steps_down_to(&self, mut n: u32, mut side: usize, enough: u32) -> Result<(u32, usize), BackendError> {
        let mut is_first = true;
        while n > enough {
            self.count_from(n);
            let mut encoder = self.encoder();
            if let (Some(project), true) = (&self.stages.project_light, is_first) {
                self.run(&mut encoder, project, side, n);
            }
            is_first = false;
            self.shadow_pass(&mut encoder, side, n);
            n = self.read_counters(encoder)?.n_shadows_out;
            side = 1 - side;
        }
        Ok((n, side))
    }

    /// What media do to a batch of rays whose hits are known, after what was recorded so far; gives a new encoder. Samples ask for lamps round by round.
    fn media_rounds(
        &self,
        stage: &Stage,
        mut encoder: wgpu::CommandEncoder,
        first: u32,
        n: u32,
    ) -> Result<wgpu::CommandEncoder, BackendError> {
        if self.media_points > 0 {
            let room = bytes::<[f32; 4]>(n) * u64::from(self.media_points);
            encoder.clear_buffer(&self.radiance, bytes::<[f32; 4]>(self.max_slots), Some(room));
            encoder.copy_buffer_to_buffer(&self.hits, 0, &self.kept_hits, 0, bytes::<Hit>(n));
        }
        for round in 0.. {
            self.run(&mut encoder, stage, 0, n);
            if self.media_points == 0 {
                break;
            }
            let asked = self.read_counters(encoder)?.n_shadows.min(self.max_shadows);
            encoder = self.encoder();
            self.count_from(0);
            if asked == 0 {
                break;
            }
            self.shadow_steps(asked, 0)?;
            encoder.copy_buffer_to_buffer(&self.kept_hits, 0, &self.hits, 0, bytes::<Hit>(n));
            self.count_from(0);
            self.set_batch(Batch { first, n, round: round + 1, ..Batch::default() });
        }
        Ok(encoder)
    }

    /// Follows the area lights that the hits asked, round by round: each asks for the points of its grid that the answers of the last one call for.
    fn area_rounds(&self, asked: &Counters) -> Result<(), BackendError> {
        let Some(stage) = &self.stages.area_round else { return Ok(()) };
        if asked.n_areas == 0 {
            return Ok(());
        }
        let mut encoder = self.encoder();
        encoder.clear_buffer(&self.radiance, bytes::<[f32; 4]>(self.max_slots), Some(bytes::<[f32; 4]>(asked.n_area_points)));
        self.gpu.queue.submit([encoder.finish()]);
        for round in 0.. {
            self.set_batch(Batch { n_areas: asked.n_areas, round, ..Batch::default() });
            self.count_from(0);
            let mut encoder = self.encoder();
            self.run(&mut encoder, stage, 0, asked.n_areas);
            // The queue may be full: what is left asks again.
            let n = self.read_counters(encoder)?.n_shadows.min(self.max_shadows);
            if n == 0 {
                break;
            }
            self.shadow_steps(n, 0)?;
        }
        Ok(())
    }

    fn encoder(&self) -> wgpu::CommandEncoder {
        self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default())
    }

    fn run(&self, encoder: &mut wgpu::CommandEncoder, stage: &Stage, side: usize, n: u32) {
        // Nothing writes the times of what is not started.
        let timed = self.clock.filter(|_| n > 0).and_then(|c| c.begin(stage.name, n));
        self.gpu.dispatch_timed(encoder, &stage.pipeline, &[&self.groups[side], &self.tables], n, timed);
    }

    /// What the next submission works on.
    fn set_batch(&self, batch: Batch) {
        self.gpu.queue.write_buffer(&self.batch, 0, bytes_of(&batch));
    }

    /// Clears the counters; so many shadow rays are in the queue already.
    fn count_from(&self, n_shadows: u32) {
        self.gpu.queue.write_buffer(&self.counters, 0, bytes_of(&Counters { n_shadows, ..Counters::default() }));
    }

    fn read_counters(&self, encoder: wgpu::CommandEncoder) -> Result<Counters, BackendError> {
        let bytes = self.gpu.submit_and_read_into(encoder, &self.counters, 0, size_of::<Counters>() as u64, &self.counters_copy)?;
        let counters: Counters = bytemuck::pod_read_unaligned(&bytes);
        match counters.fault {
            0 => Ok(counters),
            FAULT_INTERIORS => Err(BackendError::Unsupported("rays inside more than eight objects".into())),
            _ => Err(BackendError::Unsupported("hits that send on more rays than was foreseen".into())),
        }
    }
}

/// What the stages that make rays are told of their places.
fn camera_batch([left, top, columns, rows]: [u32; 4], lens: Option<LensPart>) -> Batch {
    let of_places = Batch { left, top, columns, rows, ..Batch::default() };
    lens.map_or(of_places, |l| Batch {
        lens_first: l.first,
        lens_samples: l.samples,
        open_first: l.open_first,
        open_side: l.open_side,
        ..of_places
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_grow_while_they_are_short_and_shrink_when_they_are_long() {
        let ms = Duration::from_millis;
        assert_eq!(next_batch(1 << 14, 1 << 14, 1 << 18, ms(5)), 1 << 15);
        assert_eq!(next_batch(100, 1 << 14, 1 << 18, ms(5)), 1 << 14);
        assert_eq!(next_batch(1 << 18, 1 << 18, 1 << 18, ms(5)), 1 << 18);
        assert_eq!(next_batch(1 << 16, 1 << 16, 1 << 18, ms(100)), 1 << 16);
        assert_eq!(next_batch(1 << 16, 1 << 16, 1 << 18, ms(1900)), 1 << 15);
        assert_eq!(next_batch(512, 512, 512, ms(1900)), 512);
    }
}
