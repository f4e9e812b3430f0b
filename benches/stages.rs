//! Each stage of the road from a scene's text to a picture's file by itself: `cargo bench`, or `cargo bench -- trees` for some.
//!
//! Everything is made here, from fixed seeds. `rayloom bench accel FILE` measures trees over a scene of your own, `--against embree` beside Embree.

use divan::counter::{BytesCount, ItemsCount};
use divan::{Bencher, black_box};
use rayloom::accel::AccelKind;
use rayloom::backend::Backend;
use rayloom::backend::cpu::CpuBackend;
use rayloom::bench::RaySets;
use rayloom::bench::embree::depth;
use rayloom::bench::stability::meshes::{Triangles, terrain};
use rayloom::compile::shape::MeshShape;
use rayloom::compile::{CompileOptions, CompiledScene, compile_scene};
use rayloom::diag::{Sink, SourceMap};
use rayloom::film::{Encoding, FileFormat, Film, Metadata, encode_picture};
use rayloom::integrate::{IntegratorKind, RenderSettings};
use rayloom::kernel::query::KernelQuery;
use rayloom::lang::{LangOptions, parse_scene};
use rayloom::math::DVec3;
use rayloom::math::noise::{noise, turbulence};
use rayloom::math::random::SplitMix64;
use rayloom::scene::{Mesh, Object, Scene, Shape};
use rayloom::world::DiskWorld;
use std::fmt::Write;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

fn read(text: &str) -> Scene {
    let (mut map, mut sink) = (SourceMap::default(), Sink::default());
    let parsed =
        parse_scene("s", text.as_bytes(), &DiskWorld::default(), &KernelQuery::new(), &LangOptions::default(), &mut map, &mut sink);
    parsed.scene.expect("a scene without faults")
}

fn compiled(scene: &Scene) -> CompiledScene {
    compile_scene(scene, &CompileOptions::default()).expect("a small scene")
}

/// Hills of 28,800 triangles.
fn hills() -> Arc<Mesh> {
    let Triangles { vertices, faces } = terrain(120);
    Arc::new(Mesh { vertices, faces, ..Mesh::default() })
}

fn main() {
    divan::main();
}

#[divan::bench_group(name = "1 reading", sample_count = 20)]
mod reading {
    use super::*;

    #[divan::bench]
    fn spheres_2000(b: Bencher) {
        let mut text = String::new();
        for k in 0..2000 {
            _ = writeln!(text, "sphere {{ <{k}, sin({k}), 2*{k}/3>, 0.5 pigment {{ rgb <0.2, {k}/2000, 1> }} finish {{ phong 0.3 }} }}");
        }
        b.counter(BytesCount::of_str(&text)).bench(|| read(black_box(&text)));
    }

    #[divan::bench]
    fn macro_calls_5000(b: Bencher) {
        let text = "#macro F(A) #local B = A*2; #if (B > 100) #declare S = S + B; #else #declare S = S - 1; #end #end\n\
                    #declare S = 0; #for (K, 1, 5000) F(mod(K, 90)) #end";
        b.counter(ItemsCount::new(5000usize)).bench(|| read(black_box(text)));
    }
}

/// Trees over meshes that are measured.
const KINDS: [AccelKind; 3] = [AccelKind::Bvh8, AccelKind::Bvh, AccelKind::Kd];

#[divan::bench(name = "2 trees", args = KINDS.map(AccelKind::name), sample_count = 20)]
fn trees(b: Bencher, name: &str) {
    let (mesh, kind) = (hills(), AccelKind::named(name).expect("one of KINDS"));
    let build = || MeshShape::new(mesh.clone(), Vec::new(), kind).map(|s| s.index().n_bytes());
    b.counter(ItemsCount::new(mesh.faces.len())).bench(build);
}

#[divan::bench(name = "3 traversal", args = KINDS.map(AccelKind::name), consts = [0, 1, 2, 3], sample_count = 20)]
fn traversal<const WHICH: usize>(b: Bencher, name: &str) {
    let mesh = hills();
    let mut scene = Scene { objects: vec![Object::new(Shape::Mesh(mesh.clone()))], ..Scene::default() };
    scene.camera.location = DVec3::new(-2.4, 0.9, -2.6);
    scene.camera.direction = DVec3::new(0.65, -0.3, 0.7);
    // As `rayloom::bench::RAY_KINDS`: primary, shadow, reflected, diffuse.
    let set = &RaySets::new(&compiled(&scene), 96, 96, false).sets[WHICH];
    let shape = MeshShape::new(mesh, Vec::new(), AccelKind::named(name).expect("one of KINDS")).expect("faces");
    b.counter(ItemsCount::new(set.len())).bench(|| set.iter().map(|r| depth(&shape, r, WHICH == 1)).filter(|t| t.is_finite()).count());
}

#[divan::bench_group(name = "4 patterns")]
mod patterns {
    use super::*;

    fn points() -> Vec<DVec3> {
        let mut numbers = SplitMix64(5);
        (0..1024).map(|_| 20.0 * numbers.direction()).collect()
    }

    #[divan::bench]
    fn noise(b: Bencher) {
        let points = points();
        b.counter(ItemsCount::new(points.len())).bench(|| points.iter().map(|p| super::noise(black_box(*p), 2)).sum::<f64>());
    }

    #[divan::bench]
    fn turbulence_of_6_octaves(b: Bencher) {
        let points = points();
        let sum = || points.iter().map(|p| turbulence(black_box(*p), 6, 0.5, 2.0, 2)).sum::<f64>();
        b.counter(ItemsCount::new(points.len())).bench(sum);
    }
}

/// A picture of one thread.
fn render(scene: &CompiledScene, integrator: IntegratorKind, size: u32, samples: u32) -> Film {
    let settings = RenderSettings { integrator, samples: 0..samples, ..RenderSettings::plain(size, size) };
    let mut film = Film::new(size, size);
    CpuBackend::new(1).render(scene, &settings, &mut film, &(), &AtomicBool::new(false)).expect("renders");
    film
}

const LIT: &str = "camera { location <0, 2, -6> look_at 0 } light_source { <4, 6, -8> rgb 1 } light_source { <-4, 8, -2> rgb 0.3 }\n\
    sphere { 0, 1 pigment { marble turbulence 0.5 color_map { [0 rgb 0.2] [1 rgb <1, 0.8, 0.6>] } } finish { phong 0.5 reflection 0.2 } }\n\
    sphere { <1.5, 0, -1>, 0.6 pigment { rgbf <0.9, 1, 0.9, 0.8> } finish { specular 0.6 } interior { ior 1.5 } }\n\
    plane { y, -1 pigment { checker rgb 1, rgb 0.3 } normal { bumps 0.3 scale 0.2 } }";

#[divan::bench_group(name = "5 shading", sample_count = 20)]
mod shading {
    use super::*;

    #[divan::bench]
    fn classic_by_pixel(b: Bencher) {
        let scene = compiled(&read(LIT));
        b.counter(ItemsCount::new(64 * 64usize)).bench(|| render(&scene, IntegratorKind::Classic, 64, 1));
    }

    #[divan::bench]
    fn path_by_sample(b: Bencher) {
        let scene = compiled(&read(LIT));
        b.counter(ItemsCount::new(32 * 32 * 4usize)).bench(|| render(&scene, IntegratorKind::Path, 32, 4));
    }
}

#[divan::bench(name = "6 writing", args = ["png", "exr"], sample_count = 20)]
fn writing(b: Bencher, name: &str) {
    let film = render(&compiled(&read(LIT)), IntegratorKind::Classic, 256, 1);
    let format = if name == "png" { FileFormat::Png { bits: 8, grayscale: false } } else { FileFormat::Exr };
    let encode = || encode_picture(&film, &format, &Encoding::default(), &Metadata::default()).expect("a picture").len();
    b.counter(ItemsCount::new(256 * 256usize)).bench(encode);
}
