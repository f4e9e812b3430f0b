//! Photons against answers that can be worked out by hand.

use super::*;
use crate::compile::{CompileOptions, compile_scene};
use crate::math::{DVec3, Rgb, Rgbft, Vec3};
use crate::scene::shape::Shape;
use crate::scene::{Interior, Light, Object, Scene, Texture};
use std::sync::Arc;

const LIGHT: DVec3 = DVec3::new(1.0, 8.0, -1.0);

fn block(min: DVec3, max: DVec3, color: Rgbft) -> Object {
    let mut o = Object::new(Shape::Box { min, max });
    o.texture = Some(Arc::new(Texture::solid(color)));
    o
}

/// A white floor at y = 0 below a light, and photons `spacing` apart.
fn floor(spacing: f64) -> Scene {
    let mut plane = Object::new(Shape::Plane { normal: DVec3::Y, distance: 0.0 });
    plane.texture = Some(Arc::new(Texture::solid(Rgbft::rgb(1.0, 1.0, 1.0))));
    let mut scene = Scene { lights: vec![Light::point(LIGHT, Vec3::ONE)], objects: vec![plane], ..Scene::default() };
    scene.settings.photons = Some(Photons { spacing, ..Photons::default() });
    scene
}

/// The floor below a clear pane that is a photon target.
fn paned(spacing: f64) -> Scene {
    let mut scene = floor(spacing);
    let mut pane = block(DVec3::new(-2.0, 2.0, -2.0), DVec3::new(2.0, 2.1, 2.0), Rgbft::CLEAR);
    pane.interior = Some(Arc::new(Interior::default()));
    (pane.photons.target, pane.photons.refraction) = (Some(1.0), Some(true));
    scene.objects.push(pane);
    scene
}

fn shoot_in(scene: &Scene, in_order: bool, options: &CompileOptions) -> Result<PhotonMaps, PhotonError> {
    let compiled = compile_scene(scene, options).expect("a small scene");
    let plan = ScenePlan::new(&compiled, 8, 8, false);
    assert!(PhotonMaps::are_asked_for(&compiled, &plan));
    PhotonMaps::shoot(&compiled, &plan, in_order, &|_, _| (), &AtomicBool::new(false))
}

fn shoot(scene: &Scene) -> PhotonMaps {
    shoot_in(scene, true, &CompileOptions::default()).expect("there is room")
}

/// Light on the floor at `p` that photons bring, by their density.
fn irradiance(maps: &PhotonMaps, p: DVec3) -> f64 {
    let mut found = maps.room();
    maps.gather_surface(p, DVec3::Y, &mut found);
    let sum: Rgb = found.places().fold(Vec3::ZERO, |sum, k| sum + maps.surface.photons()[k].power());
    f64::from(sum.x) / (std::f64::consts::PI * found.radius_sq())
}

#[test]
fn light_through_a_flat_pane_arrives_as_if_there_were_none() {
    let maps = shoot(&paned(0.02));
    for p in [DVec3::ZERO, DVec3::new(-0.9, 0.0, 0.7), DVec3::new(0.6, 0.0, -1.0)] {
        let cos = (LIGHT - p).normalize().y;
        let got = irradiance(&maps, p);
        assert!((got / cos - 1.0).abs() < 0.03, "{p}: {got}, not {cos}");
    }
}

#[test]
fn fading_light_fades_over_the_whole_way_of_its_photons() {
    let mut scene = paned(0.02);
    scene.lights[0].fade = crate::scene::light::Fade::Pov { distance: 4.0, power: 2.0 };
    let (maps, d) = (shoot(&scene), LIGHT.length());
    let want = LIGHT.y / d * 2.0 / (1.0 + d * d / 16.0);
    let got = irradiance(&maps, DVec3::ZERO);
    assert!((got / want - 1.0).abs() < 0.03, "{got}, not {want}");
}

#[test]
fn a_flat_mirror_adds_the_light_of_its_mirror_image() {
    let mut scene = floor(0.02);
    let mut mirror = block(DVec3::new(-2.2, 0.0, -3.0), DVec3::new(-2.0, 6.0, 3.0), Rgbft::BLACK);
    let texture = Arc::make_mut(mirror.texture.as_mut().expect("it was given one"));
    let Texture::Layers(layers) = texture else { panic!("a plain texture") };
    let reflection = &mut Arc::make_mut(&mut layers[0].finish).reflection;
    (reflection.min, reflection.max) = (Vec3::splat(0.5), Vec3::splat(0.5));
    (mirror.photons.target, mirror.photons.reflection) = (Some(1.0), Some(true));
    scene.objects.push(mirror);
    let maps = shoot(&scene);
    // The mirror's face is x = -2.
    let image = DVec3::new(-4.0 - LIGHT.x, LIGHT.y, LIGHT.z);
    for p in [DVec3::new(-1.2, 0.0, -0.5), DVec3::new(-0.8, 0.0, 0.4)] {
        let want = 0.5 * (image - p).normalize().y;
        let got = irradiance(&maps, p);
        assert!((got / want - 1.0).abs() < 0.03, "{p}: {got}, not {want}");
    }
}

#[test]
fn the_map_does_not_depend_on_the_number_of_threads() {
    let mut scene = paned(0.05);
    let mut ball = Object::new(Shape::Sphere { center: DVec3::new(0.0, 1.0, 0.0), radius: 0.5 });
    ball.texture = Some(Arc::new(Texture::solid(Rgbft::CLEAR)));
    (ball.photons.target, ball.photons.refraction) = (Some(1.0), Some(true));
    scene.objects.push(ball);
    let on = |threads, in_order| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        let maps = pool.install(|| shoot_in(&scene, in_order, &CompileOptions::default())).expect("there is room");
        (maps.stats, maps.surface.photons().to_vec())
    };
    for in_order in [true, false] {
        assert!(on(1, in_order) == on(3, in_order), "in order: {in_order}");
    }
    assert!(on(1, true).1 != on(1, false).1, "pairs out of order have streams of their own");
}

#[test]
fn a_given_radius_is_multiplied_and_an_automatic_one_holds_the_most_photons() {
    let mut scene = paned(0.03);
    scene.settings.photons.as_mut().expect("set").radius = [0.25, 2.0, -1.0, 1.0];
    assert_eq!(shoot(&scene).stats.radius, 0.5);
    scene.settings.photons.as_mut().expect("set").radius = [-1.0, 1.0, -1.0, 1.0];
    let maps = shoot(&scene);
    // The pane and the floor hold sheets of one density each. Most photons are far from rims: the radius is that of their density, a
    // few times larger for those at the rims.
    let mut found = maps.room();
    maps.surface.nearest(DVec3::new(0.3, 0.0, 0.2), None, f64::INFINITY, &mut found);
    let wanted = found.radius_sq().sqrt();
    assert!((0.9..8.0).contains(&(maps.stats.radius / wanted)), "{} for {wanted}", maps.stats.radius);
    // The rims weigh less the larger the sheet is for its photons.
    scene.settings.photons.as_mut().expect("set").spacing = 0.01;
    let finer = shoot(&scene).stats.radius;
    assert!(finer < maps.stats.radius / 3.0, "{finer} after {}", maps.stats.radius);
}

#[test]
fn a_count_makes_about_so_many_photons() {
    let mut scene = paned(1.0);
    scene.settings.photons.as_mut().expect("set").count = 20_000;
    let stats = shoot(&scene).stats;
    assert!((10_000..40_000).contains(&stats.on_surfaces), "{stats:?}");
}

#[test]
fn photons_without_end_and_without_room_are_refused() {
    let refused = shoot_in(&paned(1e-9), true, &CompileOptions::default());
    assert!(matches!(refused, Err(PhotonError::TooMany { .. })));
    let memory = MemoryLimit::bytes(1 << 20);
    let compiled = compile_scene(&paned(0.02), &CompileOptions::default()).expect("a small scene");
    let tight = CompiledScene { options: CompileOptions { memory, ..CompileOptions::default() }, ..compiled };
    let plan = ScenePlan::new(&tight, 8, 8, false);
    let refused = PhotonMaps::shoot(&tight, &plan, true, &|_, _| (), &AtomicBool::new(false));
    if cfg!(target_os = "linux") {
        assert!(matches!(refused, Err(PhotonError::Memory { .. })), "{:?}", refused.map(|m| m.stats));
    }
}

#[test]
fn what_takes_no_photons_gets_none() {
    let asked = |change: &dyn Fn(&mut Scene)| {
        let mut scene = paned(0.1);
        change(&mut scene);
        let compiled = compile_scene(&scene, &CompileOptions::default()).expect("a small scene");
        PhotonMaps::are_asked_for(&compiled, &ScenePlan::new(&compiled, 8, 8, false))
    };
    assert!(asked(&|_| ()));
    assert!(!asked(&|s| s.lights[0].shadowless = true));
    assert!(!asked(&|s| s.lights[0].photons = (None, Some(false), false)));
    assert!(!asked(&|s| s.objects[1].photons.target = None));
    assert!(!asked(&|s| s.objects[1].photons.refraction = None));
    assert!(asked(&|s| {
        s.objects[1].photons.refraction = None;
        s.lights[0].photons = (None, Some(true), false);
    }));
}
