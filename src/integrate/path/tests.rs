//! Pictures with known answers.

use super::{PathPlan, PathTracer};
use crate::compile::{CompileOptions, CompiledScene, compile_scene};
use crate::math::{DVec3, Rgb, Transform, Vec3};
use crate::scene::lamp::LampShape;
use crate::scene::path_settings::PixelFilter;
use crate::scene::shader::{Closure, PrincipledClosure};
use crate::scene::{Environment, Lamp, Light, Object, Principled, Scene, Shader, Shape, Texture, Volume};
use std::sync::Arc;

pub(super) fn covered(shape: Shape, closure: Closure) -> Object {
    let shader = Shader { surface: Some(closure), transparent_shadow: true, ..Shader::default() };
    let p = Principled { shader: Some(Arc::new(shader)), ..Principled::default() };
    Object { texture: Some(Arc::new(Texture::Principled(Box::new(p)))), ..Object::new(shape) }
}

pub(super) fn lambert(albedo: f32) -> Closure {
    Closure::Diffuse { color: albedo.into(), roughness: 0.0.into(), normal: None }
}

pub(super) fn lamp(shape: LampShape, power: f32, transform: Transform) -> Light {
    Light { lamp: Some(Box::new(Lamp::new(shape, Vec3::splat(power), transform))), ..Light::point(DVec3::ZERO, Vec3::ONE) }
}

/// A camera at (0, 0, 4) that looks down.
pub(super) fn scene(objects: Vec<Object>, lights: Vec<Light>, environment: Rgb) -> Scene {
    let mut s = Scene { objects, lights, environment: Some(Environment::constant(environment)), ..Scene::default() };
    s.camera.location = DVec3::new(0.0, 0.0, 4.0);
    (s.camera.direction, s.camera.right, s.camera.up) = (DVec3::NEG_Z * 20.0, DVec3::X, DVec3::Y);
    s.settings.path.filter = PixelFilter::Box;
    s
}

pub(super) fn floor(albedo: f32) -> Object {
    covered(Shape::Plane { normal: DVec3::Z, distance: 0.0 }, lambert(albedo))
}

pub(super) fn compiled(s: &Scene) -> CompiledScene {
    compile_scene(s, &CompileOptions::default()).expect("a small scene")
}

/// Mean of the middle pixels over `range` samples.
fn mean_of(s: &Scene, range: std::ops::Range<u32>) -> Rgb {
    let c = compiled(s);
    let plan = PathPlan::new(&c, 4, 4, 1, false);
    let mut tracer = PathTracer::new(&plan);
    let n = range.len() as f32 * 16.0;
    let mut sum = Vec3::ZERO;
    for k in range {
        for i in 0..16 {
            let [r, g, b, _] = tracer.sample(i % 4, i / 4, k);
            sum += Vec3::new(r, g, b);
        }
    }
    sum / n
}

fn close(name: &str, got: Rgb, want: f32, tolerance: f32) {
    assert!((got / want - Vec3::ONE).abs().max_element() < tolerance, "{name}: {got}, not {want}");
}

#[test]
fn a_lambert_floor_under_a_constant_sky_has_its_albedo() {
    let s = scene(vec![floor(0.6)], vec![], Vec3::splat(2.0));
    close("floor", mean_of(&s, 0..16), 1.2, 1e-4);
}

#[test]
fn lamps_light_a_floor_as_cycles_measures_them() {
    let pi = std::f32::consts::PI;
    let above = |h: f64| Transform::translation(DVec3::new(0.0, 0.0, h));
    let (w, d, r) = (100.0f32, 3.0f32, 0.5f32);
    let i = w / (4.0 * pi);
    let point = |radius, soft_falloff| LampShape::Point { radius, soft_falloff };
    for (name, light, irradiance) in [
        ("point", lamp(point(0.0, true), w, above(3.0)), i / (d * d)),
        ("disc", lamp(point(0.5, true), w, above(3.0)), i / (d * d + r * r)),
        ("ball", lamp(point(0.5, false), w, above(3.0)), i / (d * d)),
        ("sun", lamp(LampShape::Sun { angle_rad: 0.1 }, 3.0, above(0.0)), 3.0),
    ] {
        close(name, mean_of(&scene(vec![floor(0.8)], vec![light], Vec3::ZERO), 0..256), 0.8 / pi * irradiance, 5e-3);
    }
}

#[test]
fn a_ball_of_any_material_that_takes_no_light_vanishes_in_a_white_room() {
    let plain = PrincipledClosure { base_color: 1.0.into(), ..PrincipledClosure::default() };
    let glass = PrincipledClosure { transmission_weight: 1.0.into(), ..plain.clone() };
    let metal = PrincipledClosure { metallic: 1.0.into(), ..plain.clone() };
    let mut wrong = Vec::new();
    for rough in [0.0f32, 0.1, 0.3, 0.6, 1.0] {
        for (name, p) in [("plain", &plain), ("glass", &glass), ("metal", &metal)] {
            let p = PrincipledClosure { roughness: rough.into(), ..p.clone() };
            let ball = covered(Shape::Sphere { center: DVec3::ZERO, radius: 0.5 }, Closure::Principled(Box::new(p)));
            let mut s = scene(vec![ball], vec![], Vec3::ONE);
            s.settings.path.max_bounces = 1000;
            s.settings.path.transmission_bounces = 1000;
            s.settings.path.glossy_bounces = 1000;
            // Rough glass puts energy back bounce by bounce, which makes few paths carry much: the mean is told with its error.
            let n = if name != "glass" || rough < 0.4 {
                1 << 11
            } else if rough < 0.8 {
                1 << 14
            } else {
                1 << 16
            };
            let parts: Vec<f32> = (0..16).map(|k| mean_of(&s, k * n / 16..(k + 1) * n / 16).x).collect();
            let mean = parts.iter().sum::<f32>() / 16.0;
            let error = (parts.iter().map(|p| (p - mean).powi(2)).sum::<f32>() / (16.0 * 15.0)).sqrt();
            if (mean - 1.0).abs() > 1e-3f32.max(3.0 * error) || error > 1e-3 {
                wrong.push(format!("{name} of roughness {rough}: {mean} with an error of {error}"));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn fog_takes_light_away_by_beers_law_and_gives_its_own() {
    let volume = Volume { absorption: Vec3::splat(0.7), scattering: Vec3::ZERO, emission: Vec3::ZERO, anisotropy: 0.0, density: None };
    let fog = |volume: Volume| {
        let shader = Shader { volume: Some(volume), transparent_shadow: true, ..Shader::default() };
        let p = Principled { shader: Some(Arc::new(shader)), ..Principled::default() };
        Object {
            texture: Some(Arc::new(Texture::Principled(Box::new(p)))),
            ..Object::new(Shape::Box { min: DVec3::splat(-1.0), max: DVec3::ONE })
        }
    };
    close("absorbed", mean_of(&scene(vec![fog(volume.clone())], vec![], Vec3::ONE), 0..4096), (-1.4f32).exp(), 1.5e-2);
    // White fog in a white room, all bounces followed.
    let white = Volume { absorption: Vec3::ZERO, scattering: Vec3::splat(0.7), ..volume };
    let mut s = scene(vec![fog(white)], vec![], Vec3::ONE);
    (s.settings.path.max_bounces, s.settings.path.volume_bounces) = (1000, 1000);
    close("scattered", mean_of(&s, 0..256), 1.0, 1e-3);
}

#[test]
fn ranges_of_samples_add_up_and_seeds_differ() {
    let s = scene(
        vec![floor(0.5)],
        vec![lamp(LampShape::Point { radius: 0.4, soft_falloff: true }, 50.0, Transform::translation(DVec3::Z))],
        Vec3::ONE,
    );
    let c = compiled(&s);
    let plan = PathPlan::new(&c, 4, 4, 1, false);
    let all: Vec<[f32; 4]> = {
        let mut t = PathTracer::new(&plan);
        (0..8).map(|k| t.sample(1, 2, k)).collect()
    };
    // Another tracer that begins in the middle, after other pixels.
    let mut t = PathTracer::new(&plan);
    t.sample(0, 0, 3);
    for k in 4..8 {
        assert_eq!(t.sample(1, 2, k), all[k as usize]);
    }
    let other = PathPlan::new(&c, 4, 4, 2, false);
    assert_ne!(PathTracer::new(&other).sample(1, 2, 0), all[0]);
}
