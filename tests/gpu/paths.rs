//! The path integrator on the GPU against the CPU's: both draw the same numbers, so few samples tell.

use crate::found;
use rayloom::accel::AccelKind;
use rayloom::backend::cpu::CpuBackend;
use rayloom::backend::gpu::{GpuBackend, GpuOptions};
use rayloom::backend::{Backend, BackendError};
use rayloom::compile::{CompileOptions, CompiledScene, compile_scene};
use rayloom::diag::Sink;
use rayloom::film::Film;
use rayloom::import::ImportOptions;
use rayloom::integrate::{IntegratorKind, NoiseLimit, RenderSettings};
use rayloom::math::{DVec3, Transform, Vec3};
use rayloom::scene::input::{Channel, Color, NormalInput, Picture, Scalar};
use rayloom::scene::lamp::LampShape;
use rayloom::scene::material::{MaterialImage, MaterialTexture, Texels, Wrap};
use rayloom::scene::shader::{Closure, Distribution, MixFactor, PrincipledClosure, Shader};
use rayloom::scene::shape::MeshStep;
use rayloom::scene::{Environment, Lamp, Light, Mesh, Object, Principled, Scene, Shape, Texture};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

const SIZE: [u32; 2] = [48, 36];
/// A channel is the same when it differs by no more than this share, or by so little.
const SAME: (f32, f32) = (2e-3, 1e-4);

fn gpu() -> Option<GpuBackend> {
    found(GpuBackend::new(&GpuOptions { accept_software: true, ..GpuOptions::default() }))
}

pub(crate) fn covered(mesh: Mesh, surface: Closure) -> Object {
    wearing(Shape::Mesh(Arc::new(mesh)), Shader { surface: Some(surface), transparent_shadow: true, ..Shader::default() })
}

pub(crate) fn wearing(shape: Shape, shader: Shader) -> Object {
    let mut o = Object::new(shape);
    o.texture = Some(Arc::new(Texture::Principled(Box::new(Principled { shader: Some(Arc::new(shader)), ..Principled::default() }))));
    o
}

pub(crate) fn square(corners: [[f32; 3]; 4]) -> Mesh {
    Mesh { vertices: corners.map(Vec3::from_array).to_vec(), faces: vec![[0, 1, 2], [0, 2, 3]], ..Mesh::default() }
}

/// A ball of 12 x 8 pieces with smooth normals.
fn ball(middle: Vec3, radius: f32) -> Mesh {
    let (n, m) = (12u32, 8u32);
    let mut mesh = Mesh::default();
    for j in 0..=m {
        for i in 0..n {
            let (t, p) = (std::f32::consts::PI * j as f32 / m as f32, std::f32::consts::TAU * i as f32 / n as f32);
            let d = Vec3::new(t.sin() * p.cos(), t.sin() * p.sin(), t.cos());
            mesh.vertices.push(middle + radius * d);
            mesh.normals.push(d);
        }
    }
    for (j, i) in (0..m).flat_map(|j| (0..n).map(move |i| (j, i))) {
        let at = |j: u32, i: u32| j * n + i % n;
        if j > 0 {
            mesh.faces.push([at(j, i), at(j + 1, i), at(j, i + 1)]);
        }
        if j + 1 < m {
            mesh.faces.push([at(j, i + 1), at(j + 1, i), at(j + 1, i + 1)]);
        }
    }
    mesh.normal_indices = mesh.faces.clone();
    mesh
}

pub(crate) fn diffuse(r: f32, g: f32, b: f32) -> Closure {
    Closure::Diffuse { color: Color::constant(Vec3::new(r, g, b)), roughness: 0.0.into(), normal: None }
}

pub(crate) fn lamp(shape: LampShape, power: f32, at: DVec3) -> Light {
    // Lamps look along -z.
    let lamp = Lamp::new(shape, Vec3::splat(power), Transform::translation(at));
    Light { lamp: Some(Box::new(lamp)), ..Light::point(at, Vec3::ONE) }
}

/// A floor with balls of `closures` on it, seen from the front and above; +z is up.
pub(crate) fn scene_of(closures: Vec<Closure>, lights: Vec<Light>, sky: f32) -> Scene {
    let floor = square([[-4.0, -3.0, 0.0], [4.0, -3.0, 0.0], [4.0, 4.0, 0.0], [-4.0, 4.0, 0.0]]);
    let mut scene = Scene { objects: vec![covered(floor, diffuse(0.7, 0.6, 0.5))], lights, ..Scene::default() };
    let n = closures.len() as f32;
    for (k, c) in closures.into_iter().enumerate() {
        let x = 1.3 * (k as f32 - 0.5 * (n - 1.0));
        scene.objects.push(covered(ball(Vec3::new(x, 0.0, 0.62), 0.6), c));
    }
    scene.environment = Some(Environment::constant(Vec3::new(sky, sky, 1.2 * sky)));
    scene.camera.location = DVec3::new(0.0, -6.0, 2.5);
    scene.camera.direction = DVec3::new(0.0, 1.0, -0.32);
    scene.camera.right = DVec3::new(0.9, 0.0, 0.0);
    scene.camera.up = DVec3::new(0.0, 0.2, 0.65);
    scene
}

/// Both machines have the faces in the same places: the CPU's one tree over still meshes, which only the usual tree has, rounds corners in the world.
fn compiled(scene: &Scene) -> CompiledScene {
    compile_scene(scene, &CompileOptions { accel: AccelKind::Bvh, ..CompileOptions::default() }).expect("compiles")
}

fn render(backend: &dyn Backend, scene: &CompiledScene, samples: std::ops::Range<u32>) -> Result<Film, BackendError> {
    let settings = RenderSettings { integrator: IntegratorKind::Path, samples, threads: 2, ..RenderSettings::plain(SIZE[0], SIZE[1]) };
    let mut film = Film::new(settings.width, settings.height);
    backend.render(scene, &settings, &mut film, &(), &AtomicBool::new(false))?;
    Ok(film)
}

/// Share of pixels that are the same, and the means of both.
fn compare(a: &Film, b: &Film) -> (f64, f64, f64) {
    let near = |x: f32, y: f32| (x - y).abs() <= SAME.0 * x.abs().max(y.abs()) + SAME.1;
    let same = a.pixels.iter().zip(&b.pixels).filter(|(p, q)| (0..4).all(|k| near(p[k], q[k]))).count();
    let mean = |f: &Film| f.pixels.iter().map(|p| f64::from(p[0] + p[1] + p[2])).sum::<f64>() / (3 * f.pixels.len()) as f64;
    (same as f64 / a.pixels.len() as f64, mean(a), mean(b))
}

/// Both machines give the same picture but for paths that rounding sends elsewhere.
pub(crate) fn agrees(name: &str, scene: &Scene, least_same: f64) {
    let Some(gpu) = gpu() else { return };
    let scene = compiled(scene);
    let ours = render(&gpu, &scene, 0..4).expect("renders");
    let gold = render(&CpuBackend::new(2), &scene, 0..4).expect("renders");
    assert!(ours.samples.iter().all(|n| *n == 4));
    let (same, mean, want) = compare(&ours, &gold);
    println!("{name}: {:.2} % of pixels are the same, means {mean:.5} and {want:.5}", 100.0 * same);
    assert!(want > 0.01, "{name}: there is something to see");
    assert!(same >= least_same && (mean / want - 1.0).abs() < 5e-3, "{name}: {same} {mean} {want}");
}

#[test]
fn lamps_of_all_kinds_light_the_same() {
    use std::f64::consts::PI;
    let lights = vec![
        lamp(LampShape::Point { radius: 0.0, soft_falloff: true }, 60.0, DVec3::new(-2.0, -2.0, 3.0)),
        lamp(LampShape::Point { radius: 0.3, soft_falloff: false }, 60.0, DVec3::new(2.5, -1.0, 2.0)),
        lamp(LampShape::Spot { radius: 0.1, soft_falloff: true, angle_rad: 0.9, blend: 0.3 }, 200.0, DVec3::new(0.0, 0.5, 4.0)),
        lamp(LampShape::Area { ellipse: false, size: [1.0, 2.0], spread_rad: PI }, 80.0, DVec3::new(-1.0, 1.0, 3.0)),
        lamp(LampShape::Area { ellipse: true, size: [1.0, 1.0], spread_rad: 2.0 }, 80.0, DVec3::new(1.5, 2.0, 3.0)),
        lamp(LampShape::Sun { angle_rad: 0.1 }, 0.5, DVec3::new(0.0, 0.0, 5.0)),
    ];
    agrees("lamps", &scene_of(vec![diffuse(0.8, 0.3, 0.2), diffuse(0.3, 0.8, 0.2)], lights, 0.1), 0.97);
}

#[test]
fn principled_materials_answer_the_same() {
    let p = |f: &dyn Fn(&mut PrincipledClosure)| {
        let mut c = PrincipledClosure { base_color: Color::constant(Vec3::new(0.8, 0.5, 0.3)), ..PrincipledClosure::default() };
        f(&mut c);
        Closure::Principled(Box::new(c))
    };
    let closures = vec![
        p(&|c| (c.metallic, c.roughness) = (1.0.into(), 0.3.into())),
        p(&|c| (c.transmission_weight, c.roughness) = (1.0.into(), 0.1.into())),
        p(&|c| (c.coat_weight, c.sheen_weight, c.diffuse_roughness) = (0.7.into(), 0.5.into(), 0.6.into())),
        p(&|c| (c.alpha, c.emission_strength) = (0.6.into(), 0.4.into())),
    ];
    let light =
        lamp(LampShape::Area { ellipse: false, size: [2.0, 2.0], spread_rad: std::f64::consts::PI }, 150.0, DVec3::new(-1.0, -1.0, 4.0));
    agrees("principled", &scene_of(closures, vec![light], 0.3), 0.93);
}

#[test]
fn what_gltf_says_answers_the_same() {
    let file = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/scenes/path/gltf/scene.glb");
    let options = ImportOptions { time: Some(0.5), ..ImportOptions::default() };
    let scene = rayloom::import::load(&file, &options, &mut Sink::default()).expect("it loads");
    agrees("glTF", &scene, 0.97);
}

#[test]
fn trees_of_plain_closures_answer_the_same() {
    let c = |v: f32| Color::constant(Vec3::new(v, 0.8 * v, 0.6 * v));
    let glossy = Closure::Glossy {
        distribution: Distribution::MultiGgx,
        color: c(0.9),
        roughness: 0.2.into(),
        anisotropy: 0.0.into(),
        rotation: 0.0.into(),
        normal: None,
    };
    let glass = Closure::Glass {
        distribution: Distribution::Ggx,
        color: c(1.0),
        roughness: 0.0.into(),
        ior: 1.4.into(),
        film_thickness: 400.0.into(),
        film_ior: 1.8.into(),
        normal: None,
    };
    let mix = |factor, a, b| Closure::Mix { factor, a: Box::new(a), b: Box::new(b) };
    let shining = Closure::Emission { color: c(1.0), strength: 2.0.into() };
    let sheen = Closure::Sheen { color: c(0.8), roughness: 0.4.into(), normal: None };
    let closures = vec![
        mix(MixFactor::Fresnel(Scalar::constant(1.5)), diffuse(0.2, 0.3, 0.8), glossy),
        mix(MixFactor::Facing(Scalar::constant(0.4)), glass, Closure::Transparent { color: c(0.9) }),
        mix(MixFactor::Backfacing, shining, diffuse(0.5, 0.5, 0.5)),
        Closure::Add(Box::new(Closure::Translucent { color: c(0.5), normal: None }), Box::new(sheen)),
    ];
    agrees("closures", &scene_of(closures, Vec::new(), 0.4), 0.93);
}

#[test]
fn bumps_on_bumps_answer_the_same() {
    let texel = |x: u32, y: u32| {
        let v = 128.0 + 100.0 * (0.9 * x as f32).sin() * (0.7 * y as f32).cos();
        [v as u8, v as u8, v as u8, 255]
    };
    let texels = Texels::Rgba8((0..64).map(|k| texel(k % 8, k / 8)).collect());
    let image = MaterialImage { width: 8, height: 8, texels };
    let texture = MaterialTexture {
        image: Arc::new(image),
        srgb: false,
        wrap: [Wrap::Repeat; 2],
        linear: true,
        uv_transform: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
    };
    let picture = Picture { texture, uv_set: 0, filter_encoded: false, premultiplied: false };
    let height = Scalar { picture: Some((picture, Channel::Red)), factor: 1.0, offset: 0.0 };
    let bump = |strength: f32, base: Option<Box<NormalInput>>| NormalInput::Bump {
        height: height.clone(),
        strength: strength.into(),
        distance: 0.3.into(),
        invert: false,
        base,
    };
    let on_bump = Some(Box::new(bump(1.0, Some(Box::new(bump(0.5, Some(Box::new(bump(0.8, None)))))))));
    let bumped = Closure::Diffuse { color: Color::constant(Vec3::splat(0.7)), roughness: 0.0.into(), normal: on_bump };
    let light = lamp(LampShape::Point { radius: 0.2, soft_falloff: false }, 150.0, DVec3::new(-1.0, -2.0, 4.0));
    let mut scene = scene_of(vec![bumped], vec![light], 0.3);
    for o in &mut scene.objects {
        let Shape::Mesh(mesh) = &mut o.shape else { continue };
        let mesh = Arc::make_mut(mesh);
        mesh.uvs = mesh.vertices.iter().map(|v| [v.x + 0.3 * v.z, v.y - 0.4 * v.z]).collect();
        mesh.uv_indices = mesh.faces.clone();
    }
    agrees("bumps on bumps", &scene, 0.95);
}

#[test]
fn panes_and_holdouts_answer_the_same() {
    let pane = Closure::Principled(Box::new(PrincipledClosure {
        base_color: Color::constant(Vec3::new(0.9, 0.6, 0.5)),
        roughness: 0.2.into(),
        transmission_weight: 0.8.into(),
        coat_weight: 0.3.into(),
        thin_walled: true,
        ..PrincipledClosure::default()
    }));
    let part_hole = Closure::Add(Box::new(Closure::Holdout), Box::new(diffuse(0.2, 0.3, 0.4)));
    let light = lamp(LampShape::Point { radius: 0.2, soft_falloff: false }, 150.0, DVec3::new(-1.0, -2.0, 4.0));
    let mut scene = scene_of(vec![pane, part_hole, diffuse(0.5, 0.4, 0.3)], vec![light], 0.3);
    scene.objects[3].traits.holdout = true;
    agrees("panes and holes", &scene, 0.95);
}

#[test]
fn what_moves_is_where_it_is() {
    let light = lamp(LampShape::Point { radius: 0.2, soft_falloff: false }, 150.0, DVec3::new(-1.0, -2.0, 4.0));
    let shining = Closure::Emission { color: Color::constant(Vec3::ONE), strength: 2.0.into() };
    let anisotropic = PrincipledClosure { metallic: 1.0.into(), roughness: 0.4.into(), anisotropic: 0.7.into(), ..Default::default() };
    let mut scene = scene_of(vec![diffuse(0.8, 0.3, 0.2), Closure::Principled(Box::new(anisotropic)), shining], vec![light], 0.3);
    let turned =
        |deg: f64| Transform::rotation_deg(DVec3::new(10.0, 0.0, deg)).then(&Transform::translation(DVec3::new(0.0, -0.01 * deg, 0.0)));
    scene.objects[2].traits.motion = vec![turned(0.0), turned(40.0), turned(20.0)].into();
    scene.objects[3].traits.motion = vec![Transform::IDENTITY, Transform::translation(DVec3::new(0.4, 0.0, 0.2))].into();
    let Shape::Mesh(mesh) = &mut scene.objects[1].shape else { panic!("a mesh") };
    let mesh = Arc::make_mut(mesh);
    let step = |f: f32| MeshStep {
        vertices: mesh.vertices.iter().map(|v| *v + Vec3::Z * f * v.x.sin()).collect(),
        normals: mesh.normals.iter().map(|n| (*n + Vec3::X * f).normalize()).collect(),
    };
    mesh.motion = vec![step(0.0), step(0.4), step(-0.2)];
    agrees("motion", &scene, 0.95);
}

#[test]
fn ranges_of_samples_add_up_and_other_structures_see_the_same() {
    let Some(gpu) = gpu() else { return };
    let mut scene = compiled(&scene_of(vec![diffuse(0.8, 0.3, 0.2)], Vec::new(), 0.5));
    let whole = render(&gpu, &scene, 0..3).expect("renders");
    let parts = [render(&gpu, &scene, 0..1).expect("renders"), render(&gpu, &scene, 1..3).expect("renders")];
    for (k, p) in whole.pixels.iter().enumerate() {
        let joined: [f32; 4] = std::array::from_fn(|c| (parts[0].pixels[k][c] + 2.0 * parts[1].pixels[k][c]) / 3.0);
        assert!((0..4).all(|c| (p[c] - joined[c]).abs() < 1e-5), "pixel {k}: {p:?} {joined:?}");
    }
    assert_ne!(parts[0].pixels, parts[1].pixels, "other samples are other numbers");
    scene.options.accel = rayloom::accel::AccelKind::KdShort;
    let (same, ..) = compare(&render(&gpu, &scene, 0..3).expect("renders"), &whole);
    assert!(same > 0.99, "{same}");
}

#[test]
fn quiet_pixels_get_no_more_samples_on_both_machines() {
    let Some(gpu) = gpu() else { return };
    let ball = lamp(LampShape::Point { radius: 0.5, soft_falloff: false }, 60.0, DVec3::new(2.5, -1.0, 2.0));
    let scene = compiled(&scene_of(vec![diffuse(0.8, 0.3, 0.2)], vec![ball], 0.3));
    let noise = Some(NoiseLimit { threshold: 0.12, min_samples: 4 });
    let settings =
        RenderSettings { integrator: IntegratorKind::Path, samples: 0..40, threads: 2, noise, ..RenderSettings::plain(SIZE[0], SIZE[1]) };
    let counts = [&gpu as &dyn Backend, &CpuBackend::new(2)].map(|machine| {
        let mut film = Film::new(SIZE[0], SIZE[1]);
        machine.render(&scene, &settings, &mut film, &(), &AtomicBool::new(false)).expect("renders");
        film.samples
    });
    let of = |n: u32| counts[0].iter().filter(|c| **c == n).count();
    assert!(of(4) > 50 && counts[0].len() - of(4) > 50, "{} pixels of {} are done at once", of(4), counts[0].len());
    let same = counts[0].iter().zip(&counts[1]).filter(|(a, b)| a == b).count();
    println!("{same} of {} pixels have the same number of samples", counts[0].len());
    assert!(same as f64 >= 0.97 * counts[0].len() as f64, "{same}");
}

#[test]
fn what_is_not_done_is_named() {
    let Some(gpu) = gpu() else { return };
    let mut scene = scene_of(vec![diffuse(0.5, 0.5, 0.5)], Vec::new(), 0.5);
    scene.objects[0].traits.shadow_catcher = true;
    let error = render(&gpu, &compiled(&scene), 0..1).expect_err("the CPU's matter");
    assert!(matches!(&error, BackendError::Unsupported(what) if what.contains("shadow catchers")), "{error}");
    let mut scene = scene_of(Vec::new(), Vec::new(), 0.5);
    scene.objects.push(Object::new(Shape::Sphere { center: DVec3::Z, radius: 1.0 }));
    let error = render(&gpu, &compiled(&scene), 0..1).expect_err("the CPU's matter");
    assert!(matches!(&error, BackendError::Unsupported(what) if what.contains("sphere")), "{error}");
}
