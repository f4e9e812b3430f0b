//! All acceleration structures over one scene, on the CPU and on every GPU: build time, memory, work a ray and rays a second.
//! A speed is given only where the hits agree with the other structures'.

use super::rays::{RaySets, TestRay};
use crate::accel::{AccelKind, AccelStats, STRUCTURES};
use crate::compile::geometry::{GeometrySize, PrimKind, prim_flags};
use crate::compile::{CompileError, CompileOptions, CompiledScene, compile_scene};
use crate::kernel::traverse::{MIN_DEPTH, SHADOW_TOLERANCE, ShadowHit, intersect, intersect_shadow};
use crate::math::Ray;
use crate::scene::{Mesh, Object, Scene, Shape};
use rayon::prelude::*;
use std::sync::Arc;
use std::time::Instant;

/// Most rays of a set on the CPU: a part of what a GPU needs to be busy.
const CPU_RAYS: usize = 1 << 18;
/// Rays whose steps are counted, on GPUs.
#[cfg(feature = "gpu")]
const COUNTED_RAYS: usize = 1 << 18;
/// Primitive tests of brute force that a measurement may take: on CPUs (and GPUs in software), on cards.
const BRUTE_TESTS: [f64; 2] = [4e8, 2e11];
/// Rays are sampled in runs of this length, so that neighbours stay neighbours.
const RUN: usize = 64;
/// Share of rays whose depths may differ: those that meet a face edge on.
const MAY_DIFFER: f64 = 2e-6;

/// What to measure.
#[derive(Clone, Debug)]
pub struct AccelBench {
    /// Structures, in the order of the table.
    pub kinds: Vec<AccelKind>,
    /// Picture whose rays are traced.
    pub size: (u32, u32),
    /// Look from the middle of the scene instead of from its camera.
    pub inside: bool,
    /// Trace rays in the order of [`RaySets::sorted`].
    pub sorted: bool,
    /// Measure the CPU.
    pub cpu: bool,
    /// Measure GPUs; software ones are for checks.
    pub gpus: bool,
}

impl Default for AccelBench {
    fn default() -> Self {
        Self { kinds: STRUCTURES.iter().map(|s| s.kind).collect(), size: (512, 512), inside: false, sorted: false, cpu: true, gpus: true }
    }
}

impl AccelBench {
    fn rays(&self, scene: &CompiledScene) -> RaySets {
        let rays = RaySets::new(scene, self.size.0, self.size.1, self.inside);
        if self.sorted { rays.sorted() } else { rays }
    }
}

/// One kind of ray through one structure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    /// Millions of rays a second.
    pub mrays: f64,
    /// Nodes or cells, and primitives tested, a ray; not known on the CPU.
    pub work: Option<[f64; 2]>,
    /// Rays traced.
    pub n_rays: usize,
}

/// One structure on one device.
#[derive(Clone, Debug)]
pub struct Row {
    /// "CPU, 16 threads", "NVIDIA H100 (Vulkan)".
    pub device: String,
    /// As the driver has it; empty for the CPU.
    pub device_key: String,
    /// Which structure.
    pub kind: AccelKind,
    /// Sums over the scene's and the meshes' trees.
    pub stats: AccelStats,
    /// By kind of ray ([`super::RAY_KINDS`]); `None` when there were no such rays, or hits differ.
    pub cells: [Option<Cell>; 4],
    /// Why something is missing.
    pub note: Option<String>,
}

/// A scene ready to be measured.
pub struct Subject {
    scene: Scene,
    /// Faces and primitives.
    pub size: GeometrySize,
    /// All meshes were joined into one.
    pub is_merged: bool,
}

impl Subject {
    /// Meshes without clipping are joined into one in world space, so that one tree is measured and not a tree of trees.
    pub fn new(scene: Scene) -> Result<Self, CompileError> {
        let compiled = compiled(&scene, AccelKind::Bvh)?;
        let merged = merged(&compiled);
        let is_merged = merged.is_some();
        let scene = merged.unwrap_or(scene);
        // Instances of a mesh are faces of their own once joined.
        let size = if is_merged { joined_size(&scene) } else { compiled.geometry.size() };
        Ok(Self { scene, size, is_merged })
    }
}

impl Subject {
    /// The one mesh that all were joined into, and rays over it.
    pub fn mesh_and_rays(&self, options: &AccelBench) -> Result<Option<(Arc<Mesh>, RaySets)>, CompileError> {
        let [Object { shape: Shape::Mesh(mesh), .. }] = &self.scene.objects[..] else { return Ok(None) };
        let scene = compiled(&self.scene, AccelKind::Bvh)?;
        Ok(Some((mesh.clone(), options.rays(&scene))))
    }
}

fn joined_size(scene: &Scene) -> GeometrySize {
    let faces = scene.objects.iter().map(|o| if let Shape::Mesh(m) = &o.shape { m.faces.len() } else { 0 }).sum();
    GeometrySize { faces, others: 0 }
}

fn compiled(scene: &Scene, accel: AccelKind) -> Result<CompiledScene, CompileError> {
    compile_scene(scene, &CompileOptions { accel, ..CompileOptions::default() })
}

fn merged(scene: &CompiledScene) -> Option<Scene> {
    let g = &scene.geometry;
    let plain = |p: &crate::compile::geometry::Prim| {
        matches!(p.kind, PrimKind::Mesh | PrimKind::BicubicPatch)
            && p.clip_len == 0
            && p.flags & (prim_flags::BOUNDED | prim_flags::HIDDEN) == 0
    };
    if g.prims.is_empty() || !g.prims.iter().all(plain) {
        return None;
    }
    let mut all = Mesh::default();
    for p in &g.prims {
        let m = &g.shapes.meshes[p.shape_ix as usize].mesh;
        let t = &g.transforms[p.transform_ix as usize];
        let base = all.vertices.len() as u32;
        all.vertices.extend(m.vertices.iter().map(|v| t.point(v.as_dvec3()).as_vec3()));
        all.faces.extend(m.faces.iter().map(|f| f.map(|v| base + v)));
    }
    Some(Scene { objects: vec![Object::new(Shape::Mesh(Arc::new(all)))], camera: scene.camera.clone(), ..Scene::default() })
}

/// Measures; `told` hears of each row as soon as it is there.
pub fn run(subject: &Subject, options: &AccelBench, told: &mut dyn FnMut(&Row)) -> Result<Vec<Row>, CompileError> {
    let first = compiled(&subject.scene, AccelKind::Bvh)?;
    let rays = options.rays(&first);
    drop(first);
    let mut devices: Vec<Device> = Vec::new();
    if options.cpu {
        devices.push(Device::Cpu { name: format!("CPU, {} threads", rayon::current_num_threads()) });
    }
    #[cfg(feature = "gpu")]
    if options.gpus {
        devices.extend(crate::backend::gpu::open_all(true).into_iter().map(|g| Device::Gpu(Box::new(g))));
    }
    // What the others are held against: the first structure of each device.
    let mut truth: Vec<[Vec<f64>; 4]> = devices.iter().map(|_| Default::default()).collect();
    let mut rows = Vec::new();
    for kind in &options.kinds {
        let scene = compiled(&subject.scene, *kind)?;
        for (device, truth) in devices.iter().zip(&mut truth) {
            let row = measure(device, &scene, *kind, subject.size.total(), &rays, truth);
            told(&row);
            rows.push(row);
        }
    }
    Ok(rows)
}

enum Device {
    Cpu {
        name: String,
    },
    #[cfg(feature = "gpu")]
    Gpu(Box<crate::backend::gpu::Gpu>),
}

/// Rays of a set by their places in it.
struct Sample {
    places: Vec<usize>,
}

impl Sample {
    /// At most about `wanted` of `n`, in runs spread evenly.
    fn of(n: usize, wanted: usize) -> Self {
        let stride = n.div_ceil(wanted.max(RUN)).max(1);
        Self { places: (0..n).filter(|k| (k / RUN).is_multiple_of(stride)).collect() }
    }
}

fn is_brute(kind: AccelKind) -> bool {
    matches!(kind, AccelKind::Brute | AccelKind::BruteTiled | AccelKind::BruteGroup)
}

fn total_stats(scene: &CompiledScene) -> AccelStats {
    let mut sum = scene.geometry.tree.stats();
    for m in &scene.geometry.shapes.meshes {
        let s = m.index().tree.stats();
        sum.n_prims += s.n_prims;
        sum.n_nodes += s.n_nodes;
        sum.n_leaves += s.n_leaves;
        sum.n_refs += s.n_refs;
        sum.n_bytes += s.n_bytes;
        sum.build_seconds += s.build_seconds;
        sum.depth = sum.depth.max(s.depth);
        sum.sah_cost = sum.sah_cost.max(s.sah_cost);
    }
    sum
}

/// Depths of `rays` (infinite for a miss; 0 for what any-hit rays meet), seconds of a pass, work a ray.
type Measured = Result<(Vec<f64>, f64, Option<[f64; 2]>), String>;

fn measure(device: &Device, scene: &CompiledScene, kind: AccelKind, n_prims: u64, rays: &RaySets, truth: &mut [Vec<f64>; 4]) -> Row {
    let (name, key, is_card) = match device {
        Device::Cpu { name } => (name.clone(), String::new(), false),
        #[cfg(feature = "gpu")]
        Device::Gpu(g) => (g.name(), g.info.name.clone(), g.info.device_type != wgpu::DeviceType::Cpu),
    };
    let mut row = Row { device: name, device_key: key, kind, stats: total_stats(scene), cells: [None; 4], note: None };
    #[cfg(feature = "gpu")]
    let bench = match device {
        Device::Gpu(gpu) => match crate::backend::gpu::ray_bench::RayBench::new(gpu, scene, kind) {
            Ok(b) => Some(b),
            Err(e) => {
                row.note = Some(e.to_string());
                return row;
            }
        },
        Device::Cpu { .. } => None,
    };
    for (which, set) in rays.sets.iter().enumerate() {
        let any_hit = which == 1;
        let most = if is_card { usize::MAX } else { CPU_RAYS };
        let tests = BRUTE_TESTS[usize::from(is_card)];
        let most = if is_brute(kind) { most.min((tests / n_prims.max(1) as f64) as usize) } else { most };
        let sample = Sample::of(set.len(), most);
        if sample.places.is_empty() {
            continue;
        }
        let list: Vec<TestRay> = sample.places.iter().map(|k| set[*k]).collect();
        #[cfg(feature = "gpu")]
        let found = match &bench {
            Some(b) => on_gpu(b, &list, any_hit),
            None => Ok(on_cpu(scene, &list, any_hit)),
        };
        #[cfg(not(feature = "gpu"))]
        let found: Measured = Ok(on_cpu(scene, &list, any_hit));
        match found {
            Ok((depths, seconds, work)) => {
                let apart = differing(&mut truth[which], set.len(), &sample, &depths);
                if apart as f64 > MAY_DIFFER * list.len() as f64 {
                    row.note = Some(format!(
                        "{apart} of {} {} rays meet something else than with the first structure",
                        list.len(),
                        super::RAY_KINDS[which]
                    ));
                } else {
                    row.cells[which] = Some(Cell { mrays: list.len() as f64 / seconds / 1e6, work, n_rays: list.len() });
                }
            }
            Err(e) => row.note = Some(e),
        }
    }
    row
}

/// How many depths differ from those known; the first to come become known.
fn differing(truth: &mut Vec<f64>, n: usize, sample: &Sample, depths: &[f64]) -> usize {
    truth.resize(n, f64::NAN);
    let mut n_apart = 0;
    for (place, t) in sample.places.iter().zip(depths) {
        let known = &mut truth[*place];
        if known.is_nan() {
            *known = *t;
        } else {
            n_apart += usize::from(*known != *t);
        }
    }
    n_apart
}

fn on_cpu(scene: &CompiledScene, rays: &[TestRay], any_hit: bool) -> (Vec<f64>, f64, Option<[f64; 2]>) {
    let depth = |r: &TestRay| {
        if any_hit {
            let met = intersect_shadow(scene, &r.ray, SHADOW_TOLERANCE, r.t_max, u32::MAX);
            return if matches!(met, ShadowHit::None) { f64::INFINITY } else { 0.0 };
        }
        intersect(scene, &Ray::new(r.ray.origin, r.ray.dir), MIN_DEPTH, r.t_max, 0).map_or(f64::INFINITY, |h| h.t)
    };
    let mut out = Vec::new();
    let mut times: Vec<f64> = (0..3)
        .map(|_| {
            let start = Instant::now();
            out = rays.par_chunks(512).flat_map_iter(|c| c.iter().map(depth)).collect();
            start.elapsed().as_secs_f64()
        })
        .collect();
    times.sort_by(f64::total_cmp);
    (out, times[1], None)
}

#[cfg(feature = "gpu")]
fn on_gpu(bench: &crate::backend::gpu::ray_bench::RayBench, rays: &[TestRay], any_hit: bool) -> Measured {
    use crate::backend::gpu::ray_bench::BenchRay;
    let of = |r: &TestRay| BenchRay {
        origin: r.ray.origin.as_vec3().to_array(),
        t_max: r.t_max as f32,
        dir: r.ray.dir.as_vec3().to_array(),
        padding: 0.0,
    };
    let list: Vec<BenchRay> = rays.iter().map(of).collect();
    let traced = bench.trace(&list, any_hit).map_err(|e| e.to_string())?;
    let few: Vec<BenchRay> = Sample::of(list.len(), COUNTED_RAYS).places.iter().map(|k| list[*k]).collect();
    let work = bench.steps(&few, any_hit).map_err(|e| e.to_string())?;
    Ok((traced.depths.iter().map(|t| f64::from(*t)).collect(), traced.seconds, Some(work)))
}
