//! Meshes against Embree on the same rays: both programs in turn, one thread each, hits compared before a speed is told.

use super::rays::{RAY_KINDS, RaySets, TestRay};
use crate::accel::{AccelKind, PACKET, Packet};
use crate::compile::shape::MeshShape;
use crate::cpu_time::thread_seconds;
use crate::kernel::intersect::mesh::intersect_mesh;
use crate::kernel::intersect::mesh_packet::{PacketHits, intersect_mesh_packet};
use crate::kernel::intersect::{HitSink, LocalRay, Part};
use crate::math::{DVec3, Ray, Vec3};
use crate::scene::Mesh;
use std::io::{BufRead, BufReader, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::sync::Arc;

const SCRIPT: &str = include_str!("../../benches/peers/embree.py");
const PROGRAM: &str = include_str!("../../benches/peers/embree.c");
/// Share of rays whose hits may differ: Embree's edges leak, and its depths are of single precision.
const MAY_DIFFER: f64 = 1e-4;
/// Depths that are apart by more, relative to themselves, are of other faces.
const SAME_DEPTH: f64 = 1e-3;
/// Seconds of one measurement.
const LEAST_SECONDS: f64 = 0.2;

/// Rays that are traced together by Embree, and whether its robust mode is on.
const PEERS: [(&str, u32, bool); 4] =
    [("Embree, single rays", 1, false), ("Embree, 8 rays", 8, false), ("Embree, 16 rays", 16, false), ("Embree robust, single", 1, true)];

/// Rays that are traced together by ours.
const WIDTHS: [usize; 4] = [1, 8, 16, 64];

/// One contestant.
#[derive(Clone, Debug)]
pub struct PeerRow {
    /// A structure of ours, or how Embree was asked.
    pub name: String,
    /// One of ours.
    pub is_ours: bool,
    /// CPU seconds of the build, one thread.
    pub build_seconds: f64,
    /// Bytes of the tree with its copy of the faces.
    pub n_bytes: u64,
    /// By kind of ray, by round: millions of rays a CPU second.
    pub mrays: [Vec<f64>; 4],
    /// By kind of ray: those that meet something else than with the first contestant.
    pub apart: [usize; 4],
    /// By kind of ray: how many.
    pub n_rays: [usize; 4],
}

impl PeerRow {
    /// Whether the hits are the first contestant's, so that a speed means something.
    pub fn agrees(&self, kind: usize) -> bool {
        self.apart[kind] as f64 <= (MAY_DIFFER * self.n_rays[kind] as f64).max(1.0)
    }

    /// Median speed.
    pub fn speed(&self, kind: usize) -> f64 {
        super::median(self.mrays[kind].iter().copied())
    }

    /// Median over the rounds of this one's speed over `other`'s.
    pub fn over(&self, other: &PeerRow, kind: usize) -> f64 {
        super::median(self.mrays[kind].iter().zip(&other.mrays[kind]).map(|(a, b)| a / b))
    }
}

/// The nearest hit, or any.
struct Nearest {
    far: f64,
    any: bool,
    t: f64,
}

impl HitSink for Nearest {
    fn push(&mut self, t: f64, _: Part) {
        if t < self.far {
            (self.far, self.t) = (t, t);
        }
    }

    fn far(&self) -> f64 {
        if self.any && self.t < f64::INFINITY { f64::NEG_INFINITY } else { self.far }
    }
}

/// Depth of what a ray meets; infinite for nothing, 0 where any hit does.
pub fn depth(mesh: &MeshShape, r: &TestRay, any: bool) -> f64 {
    let mut sink = Nearest { far: r.t_max, any, t: f64::INFINITY };
    intersect_mesh(mesh, &LocalRay { origin: r.ray.origin, dir: r.ray.dir, scale: 1.0 }, &mut sink);
    if any && sink.t < f64::INFINITY { 0.0 } else { sink.t }
}

/// A ray as Embree's file has it: origin, direction, far end.
type FileRay = [f32; 7];

fn file_ray(r: &TestRay) -> FileRay {
    let (o, d) = (r.ray.origin.as_vec3(), r.ray.dir.as_vec3());
    [o.x, o.y, o.z, d.x, d.y, d.z, r.t_max as f32]
}

/// Tells the depths, as [`depth`], of rays of which `width` (at most [`PACKET`]) are traced together.
fn packet_depths<const ANY: bool>(mesh: &MeshShape, rays: &[FileRay], width: usize, mut told: impl FnMut(f64)) {
    let (mut packet, mut hits) = (Packet::default(), PacketHits::default());
    let vector = |v: &[f32]| DVec3::new(v[0].into(), v[1].into(), v[2].into());
    for some in rays.chunks(width.clamp(1, PACKET)) {
        packet.set(some.len(), |k| Ray::new(vector(&some[k][..3]), vector(&some[k][3..6])));
        hits.set(some.len(), |k| some[k][6].into());
        intersect_mesh_packet::<ANY>(mesh, &packet, &mut hits);
        (0..some.len()).for_each(|k| told(hits.hit(k).map_or(f64::INFINITY, |t| if ANY { 0.0 } else { t })));
    }
}

/// A contestant of ours: a structure, and the rays that it traces together.
struct Ours {
    shape: Arc<MeshShape>,
    width: usize,
}

impl Ours {
    fn tell(&self, rays: &[TestRay], packed: &[FileRay], any: bool, mut told: impl FnMut(f64)) {
        match (self.width, any) {
            (1, _) => rays.iter().for_each(|r| told(depth(&self.shape, r, any))),
            (width, true) => packet_depths::<true>(&self.shape, packed, width, told),
            (width, false) => packet_depths::<false>(&self.shape, packed, width, told),
        }
    }

    /// Millions of rays a second of this thread.
    fn speed(&self, rays: &[TestRay], packed: &[FileRay], any: bool, least_seconds: f64) -> f64 {
        speed_of(rays.len(), least_seconds, || self.tell(rays, packed, any, |t| _ = std::hint::black_box(t)))
    }
}

/// Millions of rays a second of this thread; `trace` traces `n`.
fn speed_of(n: usize, least_seconds: f64, mut trace: impl FnMut()) -> f64 {
    let (start, mut done, mut took) = (thread_seconds(), 0, 0.0);
    while took < least_seconds {
        trace();
        done += n;
        took = thread_seconds() - start;
    }
    done as f64 / took / 1e6
}

/// Millions of single rays a second of this thread.
pub fn trace_speed(mesh: &MeshShape, rays: &[TestRay], any: bool, least_seconds: f64) -> f64 {
    speed_of(rays.len(), least_seconds, || rays.iter().for_each(|r| _ = std::hint::black_box(depth(mesh, r, any))))
}

/// Millions of rays a second of this thread, `width` traced together; the same rays as for [`trace_speed`].
pub fn packet_speed(mesh: &Arc<MeshShape>, rays: &[TestRay], any: bool, width: usize, least_seconds: f64) -> f64 {
    Ours { shape: mesh.clone(), width }.speed(rays, &rays.iter().map(file_ray).collect::<Vec<_>>(), any, least_seconds)
}

/// Embree in a process of its own.
struct Peer {
    child: Child,
    to: ChildStdin,
    from: BufReader<ChildStdout>,
}

impl Peer {
    fn start(python: &Path, folder: &Path, robust: bool) -> Result<Self, String> {
        let mut command = Command::new(python);
        command.arg(folder.join("embree.py")).arg(folder).args(robust.then_some("robust"));
        let mut child = command
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .map_err(|e| format!("cannot run '{}': {e}", python.display()))?;
        let (to, from) = (child.stdin.take().expect("piped"), BufReader::new(child.stdout.take().expect("piped")));
        Ok(Self { child, to, from })
    }

    /// Numbers of the answer to a command.
    fn ask(&mut self, command: &str) -> Result<[f64; 2], String> {
        let sent = writeln!(self.to, "{command}").and_then(|()| self.to.flush());
        let mut line = String::new();
        let read = sent.and_then(|()| self.from.read_line(&mut line));
        let mut numbers = line.split_whitespace().skip(1).map(|w| w.parse::<f64>().unwrap_or(f64::NAN));
        match (read, numbers.next()) {
            (Ok(_), Some(a)) => Ok([a, numbers.next().unwrap_or(f64::NAN)]),
            _ => {
                let mut said = String::new();
                if let Some(e) = self.child.stderr.take() {
                    _ = BufReader::new(e).read_to_string(&mut said);
                }
                Err(format!("Embree gave no answer: {}", said.lines().last().unwrap_or("it said nothing")))
            }
        }
    }
}

impl Peer {
    /// Depths of the rays of a kind, `width` traced together.
    fn depths(&mut self, folder: &Path, kind: &str, width: u32) -> Result<Vec<f32>, String> {
        self.ask(&format!("depths {kind} {width}"))?;
        let bytes = std::fs::read(folder.join(format!("{kind}.depths"))).map_err(|e| e.to_string())?;
        Ok(bytes.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect())
    }
}

impl Drop for Peer {
    fn drop(&mut self) {
        _ = self.child.kill();
        _ = self.child.wait();
    }
}

/// A file of 32-bit numbers.
fn write_numbers(path: PathBuf, numbers: impl Iterator<Item = f32>) -> std::io::Result<()> {
    std::fs::write(path, numbers.flat_map(f32::to_le_bytes).collect::<Vec<u8>>())
}

/// Corners of faces as a file, and the peer's source, in `folder`.
fn write_faces(folder: &Path, corners: impl Iterator<Item = Vec3>) -> std::io::Result<()> {
    write_numbers(folder.join("faces"), corners.flat_map(|v| v.to_array()))?;
    std::fs::write(folder.join("embree.py"), SCRIPT)?;
    std::fs::write(folder.join("embree.c"), PROGRAM)
}

fn write_files(folder: &Path, mesh: &Mesh, rays: &RaySets) -> std::io::Result<()> {
    write_faces(folder, mesh.faces.iter().flatten().map(|v| mesh.vertices[*v as usize]))?;
    RAY_KINDS.iter().zip(&rays.sets).try_for_each(|(kind, set)| write_numbers(folder.join(kind), set.iter().flat_map(file_ray)))
}

/// Depths of what Embree meets on single rays (without a far end) among faces, infinite for nothing; all in 32 bits.
///
/// # Errors
/// What the peer lacks.
pub fn depths(python: &Path, faces: &[[DVec3; 3]], rays: &[Ray], robust: bool) -> Result<Vec<f32>, String> {
    /// Any kind whose rays ask for the nearest hit.
    const KIND: &str = RAY_KINDS[3];
    let folder = tempfile::tempdir().map_err(|e| format!("cannot make a temporary folder: {e}"))?;
    let rays = rays.iter().map(|ray| TestRay { ray: *ray, t_max: f64::INFINITY });
    write_faces(folder.path(), faces.iter().flatten().map(|v| v.as_vec3()))
        .and_then(|()| write_numbers(folder.path().join(KIND), rays.flat_map(|r| file_ray(&r))))
        .map_err(|e| format!("cannot write to '{}': {e}", folder.path().display()))?;
    let mut peer = Peer::start(python, folder.path(), robust)?;
    peer.ask("build")?;
    peer.depths(folder.path(), KIND, 1)
}

/// Measures `kinds` and Embree over `mesh`; `told` hears of each round.
///
/// # Errors
/// What the peer lacks.
pub fn run(
    mesh: &Arc<Mesh>,
    rays: &RaySets,
    kinds: &[AccelKind],
    rounds: usize,
    python: &Path,
    told: &mut dyn FnMut(usize),
) -> Result<Vec<PeerRow>, String> {
    let folder = tempfile::tempdir().map_err(|e| format!("cannot make a temporary folder: {e}"))?;
    write_files(folder.path(), mesh, rays).map_err(|e| format!("cannot write to '{}': {e}", folder.path().display()))?;
    let n_rays = rays.sets.each_ref().map(Vec::len);
    let row = |name: String, is_ours: bool, build_seconds: f64, n_bytes: f64| PeerRow {
        name,
        is_ours,
        build_seconds,
        n_bytes: n_bytes as u64,
        mrays: Default::default(),
        apart: [0; 4],
        n_rays,
    };
    let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build().map_err(|e| e.to_string())?;
    let (mut rows, mut ours) = (Vec::new(), Vec::new());
    for kind in kinds {
        let shape = MeshShape::new(mesh.clone(), Vec::new(), *kind).ok_or("the mesh has no faces")?;
        // On the pool's own thread, from which `index` would go to another.
        let start = crate::cpu_time::process_seconds();
        let n_bytes = one_thread.install(|| shape.index().n_bytes());
        let seconds = crate::cpu_time::process_seconds() - start;
        let shape = Arc::new(shape);
        for width in WIDTHS.into_iter().take(if *kind == AccelKind::Bvh8 { WIDTHS.len() } else { 1 }) {
            let name = if width == 1 { kind.name().into() } else { format!("{}, {width} rays", kind.name()) };
            rows.push(row(name, true, seconds, n_bytes as f64));
            ours.push(Ours { shape: shape.clone(), width });
        }
    }
    let mut peers = [Peer::start(python, folder.path(), false)?, Peer::start(python, folder.path(), true)?];
    let built = [peers[0].ask("build")?, peers[1].ask("build")?];
    rows.extend(PEERS.iter().map(|(name, _, robust)| {
        let [seconds, bytes] = built[usize::from(*robust)];
        row((*name).into(), false, seconds, bytes)
    }));
    let packed = rays.sets.each_ref().map(|set| set.iter().map(file_ray).collect::<Vec<FileRay>>());
    // What is met, before any speed.
    for (which, set) in rays.sets.iter().enumerate().filter(|(_, s)| !s.is_empty()) {
        let any = which == 1;
        let depths = |ours: &Ours| {
            let mut depths = Vec::with_capacity(set.len());
            ours.tell(set, &packed[which], any, |t| depths.push(t));
            depths
        };
        let truth = depths(&ours[0]);
        for (row, ours) in rows.iter_mut().zip(&ours) {
            row.apart[which] = depths(ours).iter().zip(&truth).filter(|(a, b)| a != b).count();
        }
        for (k, (_, width, robust)) in PEERS.iter().enumerate() {
            let theirs = peers[usize::from(*robust)].depths(folder.path(), RAY_KINDS[which], *width)?;
            rows[ours.len() + k].apart[which] = theirs.into_iter().map(f64::from).zip(&truth).filter(|(a, b)| !same_depth(*a, **b)).count();
        }
    }
    for round in 0..rounds {
        for (which, set) in rays.sets.iter().enumerate().filter(|(_, s)| !s.is_empty()) {
            for (row, ours) in rows.iter_mut().zip(&ours) {
                row.mrays[which].push(ours.speed(set, &packed[which], which == 1, LEAST_SECONDS));
            }
            for (row, (_, width, robust)) in rows[ours.len()..].iter_mut().zip(PEERS) {
                let [n, seconds] = peers[usize::from(robust)].ask(&format!("trace {} {width}", RAY_KINDS[which]))?;
                row.mrays[which].push(n / seconds / 1e6);
            }
        }
        told(round + 1);
    }
    Ok(rows)
}

fn same_depth(a: f64, b: f64) -> bool {
    a == b || a.is_finite() && b.is_finite() && (a - b).abs() <= SAME_DEPTH * a.abs().max(b.abs())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn contestants_that_meet_something_else_do_not_agree() {
        assert!(same_depth(f64::INFINITY, f64::INFINITY) && same_depth(1.0, 1.0 + 1e-4) && same_depth(0.0, 0.0));
        assert!(!same_depth(f64::INFINITY, 3.0) && !same_depth(1.0, 1.01) && !same_depth(0.0, f64::INFINITY));
        let mut row = PeerRow {
            name: String::new(),
            is_ours: true,
            build_seconds: 0.0,
            n_bytes: 0,
            mrays: [vec![2.0, 6.0, 3.0], vec![], vec![], vec![]],
            apart: [30, 0, 0, 0],
            n_rays: [1_000_000; 4],
        };
        assert!(row.agrees(0) && row.speed(0) == 3.0);
        let other = PeerRow { mrays: [vec![1.0, 2.0, 3.0], vec![], vec![], vec![]], ..row.clone() };
        assert_eq!(row.over(&other, 0), 2.0);
        row.apart[0] = 200;
        assert!(!row.agrees(0));
    }
}
