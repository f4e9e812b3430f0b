//! Build times and rays per second over meshes, kd-tree against BVH, one thread for rays and all for builds.
//!
//! `cargo bench --bench traverse -- [--inside] [--only=TREE] [FILE.glb ...]`: without files, a generated terrain and ball.
//! `--dump=FOLDER` writes faces and rays as `f32` for peers (`benches/peers/embree.py`). `--inside` puts the camera in the middle of the mesh instead of in front of it. Hits and the sum of their depths are printed so that trees can be compared.

use rayloom::accel::AccelKind;
use rayloom::compile::shape::MeshShape;
use rayloom::kernel::intersect::mesh::intersect_mesh;
use rayloom::kernel::intersect::{HitSink, LocalRay, Part};
use rayloom::math::{DVec3, Vec3};
use rayloom::scene::Mesh;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

/// Rays a side of the picture; 8x8 tiles as a renderer has them.
const SIZE: u32 = 512;
const ROUNDS: usize = 3;

/// The nearest hit, or any.
struct Sink {
    far: f64,
    hit: Option<(f64, u32)>,
    any: bool,
}

impl HitSink for Sink {
    fn push(&mut self, t: f64, part: Part) {
        if t < self.far {
            (self.far, self.hit) = (t, Some((t, part.face)));
        }
    }

    fn far(&self) -> f64 {
        if self.any && self.hit.is_some() { f64::NEG_INFINITY } else { self.far }
    }
}

fn cast(mesh: &MeshShape, origin: DVec3, dir: DVec3, far: f64, any: bool) -> Option<(f64, u32)> {
    let mut sink = Sink { far, hit: None, any };
    intersect_mesh(mesh, &LocalRay { origin, dir, scale: 1.0 }, &mut sink);
    sink.hit
}

/// A counter-based stream of numbers in 0..1.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
}

type Rays = Vec<(DVec3, DVec3, f64)>;

fn primary(mesh: &MeshShape, inside: bool) -> Rays {
    let (center, size) = (mesh.bounds.center(), mesh.bounds.size());
    let eye = if inside { center } else { center + DVec3::new(-0.7, 0.5, -0.8) * size.length() };
    let ahead = if inside { DVec3::new(0.8, -0.1, 0.6).normalize() } else { (center - eye).normalize() };
    let right = DVec3::Y.cross(ahead).normalize();
    let up = ahead.cross(right);
    let mut rays = Rays::new();
    for tile in 0..(SIZE / 8) * (SIZE / 8) {
        for k in 0..64 {
            let (x, y) = (tile % (SIZE / 8) * 8 + k % 8, tile / (SIZE / 8) * 8 + k / 8);
            let (a, b) = ((f64::from(x) + 0.5) / f64::from(SIZE) - 0.5, 0.5 - (f64::from(y) + 0.5) / f64::from(SIZE));
            rays.push((eye, (ahead + a * right + b * up).normalize(), f64::INFINITY));
        }
    }
    rays
}

/// Shadow rays to a lamp above, and cosine bounces, from where `rays` end.
fn secondary(mesh: &MeshShape, rays: &Rays) -> (Rays, Rays) {
    let (mut shadow, mut diffuse) = (Rays::new(), Rays::new());
    let (center, size) = (mesh.bounds.center(), mesh.bounds.size());
    let mut numbers = Numbers(7);
    for (origin, dir, _) in rays {
        let Some((t, face)) = cast(mesh, *origin, *dir, f64::INFINITY, false) else { continue };
        let [p1, p2, p3] = mesh.corners(face);
        let n = (p3 - p1).cross(p2 - p1).normalize_or(DVec3::Y);
        let n = if n.dot(*dir) > 0.0 { -n } else { n };
        let p = *origin + t * *dir + 1e-5 * size.length() * n;
        let lamp = center + size * DVec3::new(numbers.next() * 0.2, 0.45, numbers.next() * 0.2);
        shadow.push((p, (lamp - p).normalize(), (lamp - p).length()));
        let (z, a) = (1.0 - 2.0 * numbers.next(), std::f64::consts::TAU * numbers.next());
        let r = (1.0 - z * z).max(0.0).sqrt();
        diffuse.push((p, (n + DVec3::new(r * a.cos(), r * a.sin(), z)).normalize_or(n), f64::INFINITY));
    }
    (shadow, diffuse)
}

/// Seconds that this thread has run (Linux), else wall clock: other programs' load does not count.
fn thread_seconds(start: Instant) -> f64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    text.split(' ').next().and_then(|ns| ns.parse::<f64>().ok()).map_or_else(|| start.elapsed().as_secs_f64(), |ns| ns * 1e-9)
}

/// Mrays/s of the best round, hits, sum of depths.
fn time(mesh: &MeshShape, rays: &Rays, any: bool) -> (f64, usize, f64) {
    let mut best = (0.0f64, 0, 0.0);
    for _ in 0..ROUNDS {
        let start = Instant::now();
        let before = thread_seconds(start);
        // The clock of threads moves in steps of 4 ms.
        let mut repeats = 0;
        while thread_seconds(start) - before < 0.25 {
            let (mut n, mut sum) = (0, 0.0);
            for (origin, dir, far) in rays {
                if let Some((t, _)) = cast(mesh, *origin, *dir, *far, any) {
                    n += 1;
                    sum += t;
                }
            }
            (best.1, best.2) = (n, sum);
            repeats += 1;
        }
        let rate = (repeats * rays.len()) as f64 / (thread_seconds(start) - before) / 1e6;
        best.0 = best.0.max(rate);
    }
    best
}

/// Faces (nine numbers each) and rays (origin, direction, far end) for other programs, little-endian.
fn dump(folder: &str, name: &str, mesh: &Mesh, rays: [(&str, &Rays); 3]) -> std::io::Result<()> {
    let write = |kind: &str, numbers: &mut dyn Iterator<Item = f32>| {
        std::fs::write(format!("{folder}/{name}.{kind}"), numbers.flat_map(f32::to_le_bytes).collect::<Vec<u8>>())
    };
    write("faces", &mut mesh.faces.iter().flatten().flat_map(|v| mesh.vertices[*v as usize].to_array()))?;
    for (kind, list) in rays {
        write(
            kind,
            &mut list.iter().flat_map(|(o, d, far)| o.as_vec3().to_array().into_iter().chain(d.as_vec3().to_array()).chain([*far as f32])),
        )?;
    }
    Ok(())
}

fn load(path: &Path) -> Mesh {
    let (document, buffers, _) = gltf::import(path).expect("a readable glTF file");
    let mut mesh = Mesh::default();
    for node in document.nodes() {
        let Some(shape) = node.mesh() else { continue };
        let m = glam::Mat4::from_cols_array_2d(&node.transform().matrix());
        for part in shape.primitives() {
            let reader = part.reader(|b| buffers.get(b.index()).map(|d| &d.0[..]));
            let base = mesh.vertices.len() as u32;
            let Some(points) = reader.read_positions() else { continue };
            mesh.vertices.extend(points.map(|p| m.transform_point3(Vec3::from(p))));
            let indices: Vec<u32> = match reader.read_indices() {
                Some(list) => list.into_u32().collect(),
                None => (0..mesh.vertices.len() as u32 - base).collect(),
            };
            mesh.faces.extend(indices.chunks_exact(3).map(|f| [base + f[0], base + f[1], base + f[2]]));
        }
    }
    mesh
}

fn grid(n: u32, at: impl Fn(f64, f64) -> DVec3) -> Mesh {
    let mut mesh = Mesh::default();
    let u = |i: u32| f64::from(i) / f64::from(n);
    mesh.vertices = (0..=n).flat_map(|j| (0..=n).map(move |i| (u(i), u(j)))).map(|(a, b)| at(a, b).as_vec3()).collect();
    for (j, i) in (0..n).flat_map(|j| (0..n).map(move |i| (j, i))) {
        let [a, b, c, d] = [j * (n + 1) + i, j * (n + 1) + i + 1, (j + 1) * (n + 1) + i, (j + 1) * (n + 1) + i + 1];
        mesh.faces.extend([[a, b, c], [b, d, c]]);
    }
    mesh
}

fn main() {
    let args: Vec<String> = std::env::args().skip(1).filter(|a| a != "--bench").collect();
    let inside = args.iter().any(|a| a == "--inside");
    let dump_to = args.iter().find_map(|a| a.strip_prefix("--dump="));
    let only = args.iter().find_map(|a| a.strip_prefix("--only="));
    let mut meshes: Vec<(String, Arc<Mesh>)> = Vec::new();
    for path in args.iter().filter(|a| !a.starts_with("--")) {
        let name = Path::new(path).file_stem().map_or(path.clone(), |n| n.to_string_lossy().into_owned());
        meshes.push((name, Arc::new(load(Path::new(path)))));
    }
    if meshes.is_empty() {
        let hill = |a: f64, b: f64| DVec3::new(10.0 * a, (7.0 * a).sin() * (9.0 * b).cos() + 0.1 * (90.0 * a * b).sin(), 10.0 * b);
        let ball = |a: f64, b: f64| {
            let (a, b) = (a * std::f64::consts::TAU, b * std::f64::consts::PI);
            DVec3::new(b.sin() * a.cos(), b.cos(), b.sin() * a.sin())
        };
        meshes.push(("terrain".into(), Arc::new(grid(374, hill))));
        meshes.push(("ball".into(), Arc::new(grid(200, ball))));
    }
    println!("mesh                 faces tree build s  MB depth  SAH | Mrays/s primary shadow diffuse | hits, mean depth");
    for (name, mesh) in &meshes {
        let mut rays: Option<(Rays, Rays, Rays)> = None;
        for kind in [AccelKind::Kd, AccelKind::Bvh, AccelKind::Bvh8].into_iter().filter(|k| only.is_none_or(|name| name == k.name())) {
            let Some(shape) = MeshShape::new(mesh.clone(), Vec::new(), kind) else { continue };
            let (p, s, d) = rays.get_or_insert_with(|| {
                let p = primary(&shape, inside);
                let (s, d) = secondary(&shape, &p);
                (p, s, d)
            });
            if let Some(folder) = dump_to {
                dump(folder, name, mesh, [("primary", p), ("shadow", s), ("diffuse", d)]).expect("a folder to write to");
            }
            let (p, s, d) = (time(&shape, p, false), time(&shape, s, true), time(&shape, d, false));
            let stats = shape.tree.stats();
            println!(
                "{name:16} {:9} {:4} {:7.2} {:3} {:5} {:4.0} |         {:7.2} {:6.2} {:7.2} | {} {:.6}, {}, {} {:.6}",
                stats.n_prims,
                kind.name(),
                stats.build_seconds,
                stats.n_bytes >> 20,
                stats.depth,
                stats.sah_cost,
                p.0,
                s.0,
                d.0,
                p.1,
                p.2 / p.1 as f64,
                s.1,
                d.1,
                d.2 / d.1 as f64
            );
        }
    }
}
