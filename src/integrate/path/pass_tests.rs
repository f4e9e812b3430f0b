//! Passes with known answers.

use super::tests::{compiled, covered, floor, lambert, lamp, scene};
use super::{PathPlan, PathTracer};
use crate::film::{CatcherView, Film, PixelSamples};
use crate::math::{DVec3, Transform, Vec3};
use crate::scene::lamp::LampShape;
use crate::scene::pass::NO_DEPTH;
use crate::scene::path_settings::Mist;
use crate::scene::shader::{Closure, PrincipledClosure};
use crate::scene::shape::MeshStep;
use crate::scene::{Mesh, Pass, PassSet, Scene, Shape};
use std::sync::Arc;

const SIDE: u32 = 4;

/// The picture of a scene with all passes.
fn render(s: &Scene, n: u32) -> Film {
    let c = compiled(s);
    let passes = PassSet::all();
    let plan = PathPlan::new(&c, SIDE, SIDE, 1, false).with_passes(passes);
    let mut tracer = PathTracer::new(&plan);
    let mut film = Film::with_passes(SIDE, SIDE, passes);
    for at in 0..(SIDE * SIDE) as usize {
        let r = tracer.pixel(at as u32 % SIDE, at as u32 / SIDE, 0..n);
        film.join(at, PixelSamples { color: r.color, layers: &r.layers, n, earlier: false });
    }
    film
}

fn rgb(film: &Film, p: Pass, at: usize) -> Vec3 {
    Vec3::from_slice(film.layer(p).expect("all passes are there").at(at))
}

/// A ball that does everything, over a floor with a lamp above and a grey world, half transparent.
fn mixed_scene() -> Scene {
    let p = PrincipledClosure {
        base_color: 0.7.into(),
        transmission_weight: 0.4.into(),
        coat_weight: 0.5.into(),
        alpha: 0.7.into(),
        emission_strength: 0.2.into(),
        ..PrincipledClosure::default()
    };
    let ball = covered(Shape::Sphere { center: DVec3::new(0.0, 0.0, 0.5), radius: 0.08 }, Closure::Principled(Box::new(p)));
    let light = lamp(LampShape::Point { radius: 0.3, soft_falloff: false }, 60.0, Transform::translation(DVec3::new(1.0, 0.0, 2.0)));
    scene(vec![ball, floor(0.6)], vec![light], Vec3::splat(0.3))
}

#[test]
fn light_by_kind_adds_up_to_the_picture() {
    let film = render(&mixed_scene(), 64);
    let light: Vec<Pass> = Pass::all()
        .filter(|p| (Pass::DiffuseDirect..=Pass::Environment).contains(p) && p.join() == crate::scene::pass::Join::Mean)
        .filter(|p| !matches!(p, Pass::DiffuseColor | Pass::GlossyColor | Pass::TransmissionColor))
        .collect();
    assert_eq!(light.len(), 10);
    for at in 0..(SIDE * SIDE) as usize {
        let sum: Vec3 = light.iter().map(|p| rgb(&film, *p, at)).sum();
        let whole = Vec3::new(film.pixels[at][0], film.pixels[at][1], film.pixels[at][2]);
        assert!((sum - whole).abs().max_element() < 1e-4 * whole.max_element(), "pixel {at}: {sum}, not {whole}");
    }
    let total = |p: Pass| (0..16).map(|at| rgb(&film, p, at).x).sum::<f32>();
    for p in
        [Pass::DiffuseDirect, Pass::DiffuseIndirect, Pass::GlossyDirect, Pass::GlossyIndirect, Pass::TransmissionIndirect, Pass::Emission]
    {
        assert!(total(p) > 0.0, "{} is there", p.name());
    }
}

#[test]
fn a_floor_has_its_depth_place_normal_and_colour() {
    let s = scene(vec![floor(0.6)], vec![], Vec3::ONE);
    let film = render(&s, 8);
    for at in 0..16 {
        assert!((film.layer(Pass::Depth).expect("there").at(at)[0] - 4.0).abs() < 1e-5, "along the axis");
        assert!(rgb(&film, Pass::Position, at).z.abs() < 1e-5);
        assert_eq!(rgb(&film, Pass::Normal, at), Vec3::Z);
        assert!((rgb(&film, Pass::DiffuseColor, at) - Vec3::splat(0.6)).abs().max_element() < 1e-6);
        // Light of the world that bounced once is direct.
        assert!((rgb(&film, Pass::DiffuseDirect, at) - Vec3::splat(0.6)).abs().max_element() < 1e-4);
        assert_eq!(rgb(&film, Pass::DiffuseIndirect, at), Vec3::ZERO);
        let crypto = film.layer(Pass::CryptoObject).expect("there").at(at);
        assert_eq!((crypto[0].to_bits(), crypto[1]), (crate::film::cryptomatte::name_bits("object 0"), 1.0));
    }
}

#[test]
fn an_empty_picture_has_the_world_and_no_depth() {
    let film = render(&scene(vec![], vec![], Vec3::splat(0.25)), 4);
    assert_eq!(film.layer(Pass::Depth).expect("there").at(5), [NO_DEPTH]);
    assert_eq!(rgb(&film, Pass::Environment, 5), Vec3::splat(0.25));
    assert_eq!(rgb(&film, Pass::Variance, 5), Vec3::ZERO);
}

#[test]
fn a_half_transparent_ball_shares_its_pixel_with_what_lies_behind() {
    let mut s = scene(vec![floor(0.5)], vec![], Vec3::ONE);
    let glassy = Closure::Mix {
        factor: crate::scene::shader::MixFactor::Scalar(0.25.into()),
        a: Box::new(lambert(0.5)),
        b: Box::new(Closure::Transparent { color: 1.0.into() }),
    };
    let mut sheet = covered(Shape::Box { min: DVec3::new(-9.0, -9.0, 0.4), max: DVec3::new(9.0, 9.0, 0.5) }, glassy);
    sheet.traits.name = "sheet".into();
    s.objects.push(sheet);
    let film = render(&s, 512);
    let crypto = film.layer(Pass::CryptoObject).expect("there").at(6);
    let share = |name: &str| crypto.chunks(2).find(|p| p[0].to_bits() == crate::film::cryptomatte::name_bits(name)).map_or(0.0, |p| p[1]);
    // The sheet has two faces: 0.75 of the first, 0.75 of the quarter that comes through.
    assert!((share("sheet") - 0.9375).abs() < 0.01 && (share("object 0") - 0.0625).abs() < 0.01, "{crypto:?}");
}

#[test]
fn variance_is_that_of_the_samples() {
    let s = mixed_scene();
    let c = compiled(&s);
    let plan = PathPlan::new(&c, SIDE, SIDE, 1, false).with_passes(PassSet::NONE.with(Pass::Variance));
    let mut tracer = PathTracer::new(&plan);
    let r = tracer.pixel(1, 2, 0..50);
    let samples: Vec<f64> = (0..50).map(|k| f64::from(tracer.sample(1, 2, k)[0])).collect();
    let mean = samples.iter().sum::<f64>() / 50.0;
    let want = samples.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / 49.0;
    assert!((f64::from(r.layers[0]) / want - 1.0).abs() < 1e-4, "{} not {want}", r.layers[0]);
}

#[test]
fn mist_grows_with_the_distance_and_is_all_where_nothing_is() {
    let mut s = scene(vec![floor(0.6)], vec![], Vec3::ONE);
    s.settings.path.mist = Mist { start: 2.0, depth: 8.0, exponent: 2.0 };
    let value = |s: &Scene| render(s, 4).layer(Pass::Mist).expect("there").at(5)[0];
    // Distance 4: a quarter of the way.
    assert!((value(&s) - 0.0625).abs() < 1e-4, "{}", value(&s));
    s.objects.clear();
    assert_eq!(value(&s), 1.0);
}

#[test]
fn a_ceiling_shuts_half_of_the_sky_or_all_within_reach() {
    let mut s = scene(vec![floor(0.2)], vec![], Vec3::ONE);
    let value = |s: &Scene| (0..16).map(|at| rgb(&render(s, 256), Pass::AmbientOcclusion, at).x).sum::<f32>() / 16.0;
    assert_eq!(value(&s), 1.0);
    // Half of the cosine-weighted directions go to x > 0.
    let mut lid = covered(Shape::Box { min: DVec3::new(0.0, -1e5, 5.0), max: DVec3::new(1e5, 1e5, 5.1) }, lambert(0.5));
    lid.traits.name = "lid".into();
    s.objects.push(lid);
    s.settings.path.occlusion_distance = 1e9;
    assert!((value(&s) - 0.5).abs() < 0.03, "{}", value(&s));
    s.settings.path.occlusion_distance = 4.9;
    assert_eq!(value(&s), 1.0, "too far away to count");
}

#[test]
fn motion_is_told_in_pixels_and_the_picture_stands_still() {
    let mut s = scene(vec![floor(0.6)], vec![], Vec3::ONE);
    s.settings.path.still = true;
    // The picture plane is 1 by 1 at 20: a step of 0.05 at distance 4 is a quarter of the picture's 4 pixels.
    let keys = [-0.05, 0.0, 0.1].map(|x| Transform::translation(DVec3::new(x, 0.0, 0.0)));
    s.objects[0].traits.motion = keys.to_vec().into();
    let film = render(&s, 16);
    let v = film.layer(Pass::Vector).expect("there").at(6);
    for (got, want) in v.iter().zip([-1.0, 0.0, -2.0, 0.0, 1.0]) {
        assert!((got - want).abs() < 1e-3, "{v:?}");
    }
}

#[test]
fn motion_of_vertices_is_told_as_that_of_objects() {
    let steps = [-0.05, 0.0, 0.1];
    let mut moved = scene(vec![floor(0.6)], vec![], Vec3::ONE);
    moved.settings.path.still = true;
    let square = [[-9.0f32, -9.0, 0.0], [9.0, -9.0, 0.0], [9.0, 9.0, 0.0], [-9.0, 9.0, 0.0]].map(Vec3::from_array).to_vec();
    let by = |x: f32| MeshStep { vertices: square.iter().map(|v| *v + Vec3::X * x).collect(), normals: Vec::new() };
    let mesh = Mesh { vertices: square.clone(), faces: vec![[0, 1, 2], [0, 2, 3]], ..Mesh::default() };
    let mesh = Mesh { motion: steps.map(by).to_vec(), ..mesh };
    moved.objects[0] = covered(Shape::Mesh(Arc::new(mesh)), lambert(0.6));
    let film = render(&moved, 16);
    let v = film.layer(Pass::Vector).expect("there").at(6);
    for (got, want) in v.iter().zip([-1.0, 0.0, -2.0, 0.0, 1.0]) {
        assert!((got - want).abs() < 1e-3, "{v:?}");
    }
}

#[test]
fn a_holdout_is_a_hole_for_the_camera_alone() {
    let wall = |x: f64| covered(Shape::Box { min: DVec3::new(x, -9.0, 1.0), max: DVec3::new(x + 9.0, 9.0, 1.1) }, lambert(0.5));
    let mut s = scene(vec![floor(0.6), wall(-9.0)], vec![], Vec3::ONE);
    s.objects[1].traits.holdout = true;
    let film = render(&s, 64);
    let [hole, open] = [film.pixels[4], film.pixels[7]];
    assert_eq!(hole, [0.0, 0.0, 0.0, 1.0]);
    assert!(open[3] == 0.0 && open[0] > 0.3 && open[0] < 0.595, "the wall still takes light from the floor: {open:?}");
}

#[test]
fn an_unshaded_catcher_is_white_and_a_shaded_one_is_what_comes_through() {
    let mut s = scene(vec![floor(0.6)], vec![], Vec3::ONE);
    s.objects[0].traits.shadow_catcher = true;
    s.settings.path.film_transparent = true;
    let view = CatcherView { apart: true, transparent: true };
    let shown = |s: &Scene| {
        let mut film = render(s, 256);
        film.resolve_catchers(view);
        let mean = (0..16).map(|at| rgb(&film, Pass::ShadowCatcher, at).x).sum::<f32>() / 16.0;
        (mean, film.pixels[5])
    };
    assert_eq!(shown(&s), (1.0, [0.0, 0.0, 0.0, 1.0]));
    // A black lid over x > 0 that the camera does not see keeps half of the sky away.
    let mut lid = covered(Shape::Box { min: DVec3::new(0.0, -1e5, 5.0), max: DVec3::new(1e5, 1e5, 5.1) }, lambert(0.0));
    lid.traits.name = "lid".into();
    s.objects.push(lid);
    let (half, _) = shown(&s);
    assert!((half - 0.5).abs() < 0.03, "{half}");
}

#[test]
fn a_shader_knows_which_sort_of_ray_meets_it_and_the_camera_sees_its_own_world() {
    use crate::scene::shader::{MixFactor, RaySort};
    let seen_as = |sort: RaySort| {
        let mut values = [0.0; RaySort::KEYS.len()];
        values[sort as usize] = 1.0;
        Closure::Mix {
            factor: MixFactor::ByRay(values),
            a: Box::new(Closure::Emission { color: 0.0.into(), strength: 1.0.into() }),
            b: Box::new(Closure::Emission { color: 0.5.into(), strength: 1.0.into() }),
        }
    };
    let sheet = |c: Closure| covered(Shape::Box { min: DVec3::new(-9.0, -9.0, 0.4), max: DVec3::new(9.0, 9.0, 0.5) }, c);
    let shown = |c: Closure| rgb(&render(&scene(vec![sheet(c)], vec![], Vec3::ZERO), 4), Pass::Emission, 5);
    assert_eq!(shown(seen_as(RaySort::Camera)), Vec3::splat(0.5));
    assert_eq!(shown(seen_as(RaySort::Diffuse)), Vec3::ZERO);
    let mut s = scene(vec![], vec![], Vec3::ONE);
    let mut world = crate::scene::Environment::constant(Vec3::ONE);
    world.for_camera = Some(Box::new(crate::scene::Environment::constant(Vec3::splat(0.25))));
    s.environment = Some(world.clone());
    assert_eq!(rgb(&render(&s, 4), Pass::Environment, 5), Vec3::splat(0.25));
    let mut floored = scene(vec![floor(0.5)], vec![], Vec3::ONE);
    floored.environment = Some(world);
    let lit = rgb(&render(&floored, 64), Pass::DiffuseDirect, 5);
    // Albedo times the light of the other world.
    assert!((lit - Vec3::splat(0.5)).abs().max_element() < 0.03, "{lit}: the floor is lit by the other");
}
