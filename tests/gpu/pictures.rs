//! The GPU against the f64 CPU renderer where no scene file says it: 99.5 % of the pixels within 2/255. Scene files are the suite's
//! (`rayloom suite tests/scenes`).
//! Skipped with a line where no adapter exists, unless `RAYLOOM_REQUIRE_GPU=1`.

use crate::found;
use rayloom::backend::cpu::CpuBackend;
use rayloom::backend::gpu::{GpuBackend, GpuOptions};
use rayloom::backend::{Backend, BackendError};
use rayloom::compile::{CompileOptions, CompiledScene, compile_scene};
use rayloom::diag::{Sink, SourceMap};
use rayloom::film::Film;
use rayloom::integrate::RenderSettings;
use rayloom::kernel::query::KernelQuery;
use rayloom::lang::{LangOptions, parse_scene};
use rayloom::math::{DVec3, Rgbft, Vec3};
use rayloom::scene::camera::{Panorama, Projection};
use rayloom::scene::light::{Fade, LightKind};
use rayloom::scene::material::{AlphaMode, MaterialImage, MaterialTexture, Texels, Wrap};
use rayloom::scene::{Interior, Light, Mesh, Object, Principled, Scene, Shape, Texture};
use rayloom::world::DiskWorld;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Share of pixels that must be near.
const SHARE_WITHIN: f64 = 0.995;
/// Largest difference of a near pixel, of 255.
const NEAR: f32 = 2.0;
const SIZE: [u32; 2] = [128, 96];

fn gpu() -> Option<GpuBackend> {
    found(GpuBackend::new(&GpuOptions { accept_software: true, ..GpuOptions::default() }))
}

fn compile(name: &str, text: &str) -> CompiledScene {
    let world = DiskWorld::default();
    let (mut map, mut sink) = (SourceMap::default(), Sink::default());
    let options = LangOptions { width: SIZE[0], height: SIZE[1], ..LangOptions::default() };
    let parsed = parse_scene(&format!("{name}.pov"), text.as_bytes(), &world, &KernelQuery::new(), &options, &mut map, &mut sink);
    assert!(!sink.has_errors(), "{name}: {:?}", sink.items());
    compile_scene(parsed.scene.as_ref().expect("a scene"), &CompileOptions::default()).expect("compiles")
}

fn settings() -> RenderSettings {
    RenderSettings { threads: 2, ..RenderSettings::plain(SIZE[0], SIZE[1]) }
}

fn render(backend: &dyn Backend, scene: &CompiledScene, settings: &RenderSettings) -> Result<Film, BackendError> {
    let mut film = Film::new(settings.width, settings.height);
    backend.render(scene, settings, &mut film, &(), &AtomicBool::new(false))?;
    assert!(film.samples.iter().all(|n| *n > 0), "every pixel is rendered");
    Ok(film)
}

/// As a picture file would have it: sRGB, 0..255, not rounded.
fn encoded(v: f32) -> f32 {
    let v = v.clamp(0.0, 1.0);
    255.0 * if v <= 0.003_130_8 { 12.92 * v } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 }
}

/// Share of near pixels; 0 when sizes differ.
fn share_within(a: &Film, b: &Film) -> f64 {
    if (a.width, a.height) != (b.width, b.height) {
        return 0.0;
    }
    let near = |p: &[f32; 4], q: &[f32; 4]| (0..3).all(|k| (encoded(p[k]) - encoded(q[k])).abs() <= NEAR);
    a.pixels.iter().zip(&b.pixels).filter(|(p, q)| near(p, q)).count() as f64 / a.pixels.len() as f64
}

fn save(film: &Film, name: &str) {
    let dir = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("target/gpu");
    let _ = std::fs::create_dir_all(&dir);
    let picture = image::RgbImage::from_fn(film.width, film.height, |x, y| {
        let p = film.pixels[film.index(x, y)];
        image::Rgb([0, 1, 2].map(|k| encoded(p[k]).round() as u8))
    });
    let _ = picture.save(dir.join(format!("{}.png", name.replace('/', "-"))));
}

#[test]
fn the_comparison_tells_different_pictures_apart() {
    let mut grey = Film::new(20, 10);
    grey.pixels.fill([0.5, 0.5, 0.5, 0.0]);
    let mut changed = grey.clone();
    (0..2).for_each(|k| changed.pixels[k][1] += 0.02);
    assert_eq!(share_within(&grey, &grey), 1.0);
    assert_eq!(share_within(&grey, &changed), 0.99);
    assert!(share_within(&grey, &changed) < SHARE_WITHIN);
    assert_eq!(share_within(&grey, &Film::new(10, 20)), 0.0);
}

/// A square in z = 0 with corner colours and coordinates beyond its picture, and balls of glass, metal and half-clear stuff before it.
fn imported_scene() -> CompiledScene {
    let picture = MaterialImage {
        width: 2,
        height: 2,
        texels: Texels::Rgba8(vec![[255, 40, 40, 255], [40, 255, 40, 255], [40, 40, 255, 255], [250, 250, 250, 255]]),
    };
    let texture = MaterialTexture {
        image: Arc::new(picture),
        srgb: true,
        wrap: [Wrap::Repeat, Wrap::Mirror],
        linear: true,
        uv_transform: [[2.0, 0.0, 0.1], [0.0, 3.0, 0.0]],
    };
    let mesh = Mesh {
        vertices: vec![Vec3::new(-3.0, -2.0, 1.0), Vec3::new(3.0, -2.0, 1.0), Vec3::new(3.0, 2.0, 1.5), Vec3::new(-3.0, 2.0, 1.5)],
        uvs: vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]],
        faces: vec![[0, 1, 2], [0, 2, 3]],
        uv_indices: vec![[0, 1, 2], [0, 2, 3]],
        colors: vec![[1.0; 4], [1.0, 0.6, 0.6, 1.0], [0.6, 1.0, 0.6, 1.0], [0.6, 0.6, 1.0, 1.0]],
        ..Mesh::default()
    };
    let covered = |shape: Shape, m: Principled| {
        let mut o = Object::new(shape);
        o.texture = Some(Arc::new(Texture::Principled(Box::new(m))));
        o
    };
    let ball = |x: f64, m: Principled| covered(Shape::Sphere { center: DVec3::new(x, 0.2 * x, -1.0), radius: 0.55 }, m);
    let plain = Principled { roughness: 0.6, ..Principled::default() };
    let mut glass = ball(-1.4, Principled { transmission: 1.0, roughness: 0.0, base_color: Vec3::new(0.9, 1.0, 0.9), ..plain.clone() });
    glass.interior = Some(Arc::new(Interior { ior: 1.5, ..Interior::default() }));
    let objects = vec![
        covered(Shape::Mesh(Arc::new(mesh)), Principled { base_color_texture: Some(texture), ..plain.clone() }),
        glass,
        ball(0.0, Principled { metallic: 1.0, roughness: 0.25, base_color: Vec3::new(0.9, 0.7, 0.3), ..plain.clone() }),
        ball(1.4, Principled { alpha: 0.4, alpha_mode: AlphaMode::Blend, emission: Vec3::new(0.05, 0.0, 0.1), ..plain }),
    ];
    let lamp = Light { fade: Fade::InverseSquare, ..Light::point(DVec3::new(2.0, 4.0, -4.0), Vec3::splat(60.0)) };
    let sun = LightKind::Sun { direction: DVec3::new(0.5, -1.0, 0.8).normalize(), angle_rad: 0.0 };
    let sun = Light { kind: sun, ..Light::point(DVec3::ZERO, Vec3::splat(0.8)) };
    let mut scene = Scene { objects, lights: vec![lamp, sun], background: Rgbft::rgb(0.2, 0.25, 0.3), ..Scene::default() };
    scene.camera.location = DVec3::new(0.0, 0.3, -6.0);
    compile_scene(&scene, &CompileOptions::default()).expect("compiles")
}

#[test]
fn imported_materials_agree_with_the_cpus() {
    let Some(gpu) = gpu() else { return };
    let scene = imported_scene();
    // Several samples a pixel, as imports are rendered.
    let settings = RenderSettings { samples: 0..4, ..settings() };
    let ours = render(&gpu, &scene, &settings).expect("renders");
    let gold = render(&CpuBackend::new(2), &scene, &settings).expect("renders");
    let share = share_within(&ours, &gold);
    println!("imported materials: {:.2} % within {NEAR}/255", 100.0 * share);
    save(&ours, "imported.gpu");
    save(&gold, "imported.cpu");
    assert!(share >= SHARE_WITHIN, "{:.2} % (see target/gpu)", 100.0 * share);
}

#[test]
fn panoramas_of_blender_agree_with_the_cpus() {
    let Some(gpu) = gpu() else { return };
    let mut scene = imported_scene();
    let all = [
        Panorama::Equirectangular { longitude: [-2.0, 2.0], latitude: [-1.0, 1.2] },
        Panorama::MirrorBall,
        Panorama::Cylinder { longitude: [-1.5, 1.0], height: [-0.8, 0.8], radius: 1.0 },
    ];
    for panorama in all {
        scene.camera.projection = Projection::Panorama(panorama);
        let ours = render(&gpu, &scene, &settings()).expect("renders");
        let gold = render(&CpuBackend::new(2), &scene, &settings()).expect("renders");
        let share = share_within(&ours, &gold);
        assert!(share >= SHARE_WITHIN, "{panorama:?}: {:.2} %", 100.0 * share);
    }
}

#[test]
fn the_gpus_picture_is_its_own() {
    let Some(gpu) = gpu() else { return };
    let text = "#version 3.7; global_settings { assumed_gamma 1 } camera { location -5*z } light_source { <3, 4, -5> rgb 1 }
        sphere { 0, 1 pigment { rgb <0.9, 0.4, 0.2> } finish { phong 0.6 } }";
    let scene = compile("own", text);
    let (ours, gold) = (render(&gpu, &scene, &settings()), render(&CpuBackend::new(2), &scene, &settings()));
    let (ours, gold) = (ours.expect("renders"), gold.expect("renders"));
    assert!(share_within(&ours, &gold) >= SHARE_WITHIN);
    // Numbers of 32 bits do not come out as those of 64 bits do.
    let same = ours.pixels.iter().zip(&gold.pixels).filter(|(a, b)| a == b && a[..3] != [0.0; 3]).count();
    let lit = gold.pixels.iter().filter(|p| p[..3] != [0.0; 3]).count();
    assert!(lit > 500 && same < lit / 2, "{same} of {lit} lit pixels are the same to the bit");
    assert!(!gpu.name().starts_with("CPU"), "{}", gpu.name());
}
