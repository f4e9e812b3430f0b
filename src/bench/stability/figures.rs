//! Figures of the stability bench, and what all cases share: scenes from text, rays in parallel, GPUs.

use crate::compile::{CompileOptions, CompiledScene, compile_scene};
use crate::diag::{Sink, SourceMap};
use crate::kernel::query::KernelQuery;
use crate::lang::{LangOptions, parse_scene};
use crate::math::random::SplitMix64;
use crate::scene::{Mesh, Object, Scene, Shape};
use crate::world::DiskWorld;
use rayon::prelude::*;
use std::sync::Arc;

use super::meshes::Triangles;
use super::peers::Peers;
use crate::accel::AccelKind;

/// How much is measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Effort {
    /// Rays of the cases that are cheap a ray.
    pub rays: u64,
    /// Measure GPUs as well; software ones too.
    pub gpus: bool,
    /// Of cases 1 to 3 only meshes whose names hold this.
    pub meshes: String,
}

/// What a case measured. All bars are upper ones.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// Number of the case.
    pub case: u32,
    /// What was counted or measured.
    pub what: String,
    /// Where: "CPU", a GPU's name, or another program's.
    pub machine: String,
    /// Another program's: held to no bar.
    pub is_peer: bool,
    /// The figure.
    pub value: f64,
    /// Most that it may be.
    pub bar: f64,
    /// Of how many rays, pixels or tries.
    pub of: u64,
    /// Why a bar that is missed stays so for now.
    pub known: Option<&'static str>,
}

/// Bars that are missed for a reason: case, part of what is measured, on GPUs alone, the reason.
const KNOWN: &[(u32, &str, bool, &str)] = &[
    (
        3,
        "at (148376, 1234, -223423)",
        true,
        "slack of 2e-6 of the coordinates is half a ball; llvmpipe cuts the long loops that come of it",
    ),
    (5, "share of rays that differ", true, "32 bits: faces that meet at the ray's depth, and grazing ones"),
    (9, "growth of build time", false, "a grid puts a large face into every cell that it crosses"),
    (12, "mean FLIP", true, "the GPU has world coordinates in 32 bits: 1/16 of a unit there"),
    (10, "outside of a torus", false, "POV-Ray's closed-form quartic: a far root comes out near; `sturm` does better"),
    (15, "roots lost", false, "POV-Ray's closed-form quartic loses grazing roots; `sturm` does not"),
    (16, "closed form", false, "POV-Ray's solver and its rules for double roots, kept because they decide pixels; `sturm` does better"),
    (16, "spread over 1e12, Sturm", false, "chains of 64-bit numbers lose count among roots below 1e-4, nearer than any ray looks"),
    (22, "time of the scene of 1, bvh8", false, "its boxes are denormal numbers of 32 bits, which processors take slowly"),
    (18, "minority winner of a face that two boxes share, merge", false, "as POV-Ray: rounding decides which box holds the point"),
];

impl Figure {
    /// Whether it keeps its bar, misses it for a known reason, or is another program's.
    pub fn passes(&self) -> bool {
        self.holds() || self.known.is_some() || self.is_peer
    }

    /// Whether it keeps its bar; NaN does not.
    pub fn holds(&self) -> bool {
        self.value <= self.bar
    }
}

/// The CPU's name in figures.
pub(super) const CPU: &str = "CPU";

/// Takes the figures of the cases.
pub struct Report<'t> {
    /// How much to do.
    pub effort: Effort,
    /// Case that runs.
    pub(super) case: u32,
    /// Devices to measure besides the CPU.
    #[cfg(feature = "gpu")]
    pub(super) gpus: Vec<crate::backend::gpu::Gpu>,
    /// Other programs to ask.
    pub(super) peers: Peers,
    /// What is known so far.
    pub figures: Vec<Figure>,
    told: &'t mut dyn FnMut(&Figure),
}

/// Rays of one task.
const CHUNK: u64 = 1 << 14;

impl<'t> Report<'t> {
    pub(super) fn new(effort: Effort, peers: Peers, told: &'t mut dyn FnMut(&Figure)) -> Self {
        Self {
            case: 0,
            #[cfg(feature = "gpu")]
            gpus: if effort.gpus { crate::backend::gpu::open_all(true) } else { Vec::new() },
            effort,
            peers,
            figures: Vec::new(),
            told,
        }
    }

    /// A figure of the CPU's.
    pub(super) fn cpu(&mut self, what: impl Into<String>, value: f64, bar: f64, of: u64) {
        self.add(CPU.into(), what.into(), value, bar, of);
    }

    pub(super) fn add(&mut self, machine: String, what: String, value: f64, bar: f64, of: u64) {
        let on_gpu = machine != CPU;
        let is_known = |k: &&(u32, &str, bool, &str)| k.0 == self.case && what.contains(k.1) && k.2 == on_gpu;
        let known = KNOWN.iter().find(is_known).map(|k| k.3);
        self.push(Figure { case: self.case, what, machine, is_peer: false, value, bar, of, known });
    }

    /// A figure of another program's.
    pub(super) fn peer(&mut self, name: &str, what: String, value: f64, of: u64) {
        self.push(Figure { case: self.case, what, machine: name.into(), is_peer: true, value, bar: f64::NAN, of, known: None });
    }

    fn push(&mut self, figure: Figure) {
        (self.told)(&figure);
        self.figures.push(figure);
    }

    /// `1 / share` of the rays asked for, at least a thousand.
    pub(super) fn rays(&self, share: u64) -> u64 {
        (self.effort.rays / share).max(1000)
    }
}

/// Sum of what `count` gives for `n` tries, each with numbers of its own stream.
pub(super) fn total(n: u64, seed: u64, count: impl Fn(&mut SplitMix64) -> u64 + Sync) -> u64 {
    let chunks = n.div_ceil(CHUNK);
    let of_chunk = |k: u64| {
        let mut numbers = SplitMix64(SplitMix64(seed ^ (k << 20)).bits());
        (0..CHUNK.min(n - k * CHUNK)).map(|_| count(&mut numbers)).sum::<u64>()
    };
    (0..chunks).into_par_iter().map(of_chunk).sum()
}

/// The largest; NaN counts as infinite.
pub(super) fn worst_of(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(f64::NEG_INFINITY, |m, v| if v.is_nan() { f64::INFINITY } else { m.max(v) })
}

/// Largest of what `measure` gives for `n` tries; NaN counts as infinite.
pub(super) fn largest(n: u64, seed: u64, measure: impl Fn(&mut SplitMix64) -> f64 + Sync) -> f64 {
    let chunks = n.div_ceil(CHUNK);
    let of_chunk = |k: u64| {
        let mut numbers = SplitMix64(SplitMix64(seed ^ (k << 20)).bits());
        worst_of((0..CHUNK.min(n - k * CHUNK)).map(|_| measure(&mut numbers)))
    };
    (0..chunks).into_par_iter().map(of_chunk).reduce(|| f64::NEG_INFINITY, f64::max)
}

/// A scene in POV-Ray's language. Panics where it does not parse: the text stands in this program.
pub(super) fn scene(text: &str) -> CompiledScene {
    let (mut map, mut sink) = (SourceMap::default(), Sink::default());
    let options = LangOptions::default();
    let parsed = parse_scene("stability.pov", text.as_bytes(), &DiskWorld::default(), &KernelQuery::new(), &options, &mut map, &mut sink);
    compiled(&parsed.scene.unwrap_or_else(|| panic!("{:?} in {text}", sink.items())), AccelKind::Auto)
}

/// A scene that holds one mesh.
pub(super) fn mesh_scene(mesh: &Triangles, kind: AccelKind) -> CompiledScene {
    let mesh = Mesh { vertices: mesh.vertices.clone(), faces: mesh.faces.clone(), ..Mesh::default() };
    compiled(&Scene { objects: vec![Object::new(Shape::Mesh(Arc::new(mesh)))], ..Scene::default() }, kind)
}

pub(super) fn compiled(scene: &Scene, accel: AccelKind) -> CompiledScene {
    compile_scene(scene, &CompileOptions { accel, ..CompileOptions::default() }).expect("a scene of the program's own")
}
