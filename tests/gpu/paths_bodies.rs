//! Hair, volumes and walks below surfaces on the GPU against the CPU's.

use super::paths::{agrees, covered, diffuse, lamp, scene_of, square, wearing};
use rayloom::math::{DVec3, Transform, Vec3};
use rayloom::scene::input::{Color, Scalar};
use rayloom::scene::lamp::LampShape;
use rayloom::scene::shader::{Closure, HairClosure, HairColor, PrincipledClosure, Shader};
use rayloom::scene::volume::{Density, Grid};
use rayloom::scene::{Curves, Light, Object, Scene, Shape, Volume};
use std::sync::Arc;

fn light() -> Light {
    lamp(LampShape::Point { radius: 0.2, soft_falloff: false }, 150.0, DVec3::new(-1.0, -2.0, 4.0))
}

#[test]
fn hair_of_both_kinds_answers_the_same() {
    let mut curves = Curves::default();
    for k in 0..120u32 {
        curves.starts.push(curves.points.len() as u32);
        let (x, y) = ((k % 12) as f32 * 0.2 - 1.2, (k / 12) as f32 * 0.15 - 0.8);
        curves.points.extend((0..4).map(|j| Vec3::new(x + 0.05 * (j * j) as f32, y - 0.03 * (j * j) as f32, 0.4 * j as f32)));
        curves.radii.extend([0.03, 0.03, 0.02, 0.005]);
    }
    curves.starts.push(curves.points.len() as u32);
    let curves = Arc::new(curves);
    let melanin = HairColor::Melanin {
        melanin: 0.6.into(),
        redness: 0.4.into(),
        tint: Color::constant(Vec3::new(0.9, 0.8, 0.7)),
        random: 0.0.into(),
    };
    let fibre = Closure::Hair(Box::new(HairClosure { color: melanin, coat: 0.2.into(), ..HairClosure::default() }));
    let mut scene = scene_of(Vec::new(), vec![light()], 0.3);
    for (closure, x) in [(fibre, -1.3), (diffuse(0.6, 0.4, 0.2), 1.3)] {
        let mut o = wearing(Shape::Curves(curves.clone()), Shader { surface: Some(closure), ..Shader::default() });
        o.transform = Transform::translation(DVec3::new(x, 0.0, 0.0));
        scene.objects.push(o);
    }
    agrees("hair", &scene, 0.93);
}

/// A box from -1 to 1, its corners counterclockwise from outside.
fn cube() -> rayloom::scene::Mesh {
    let quads = [
        [[-1., -1., -1.], [-1., 1., -1.], [1., 1., -1.], [1., -1., -1.]],
        [[-1., -1., 1.], [1., -1., 1.], [1., 1., 1.], [-1., 1., 1.]],
        [[-1., -1., -1.], [1., -1., -1.], [1., -1., 1.], [-1., -1., 1.]],
        [[1., 1., -1.], [-1., 1., -1.], [-1., 1., 1.], [1., 1., 1.]],
        [[-1., 1., -1.], [-1., -1., -1.], [-1., -1., 1.], [-1., 1., 1.]],
        [[1., -1., -1.], [1., 1., -1.], [1., 1., 1.], [1., -1., 1.]],
    ];
    let mut all = rayloom::scene::Mesh::default();
    for q in quads {
        let m = square(q);
        let n = all.vertices.len() as u32;
        all.vertices.extend(m.vertices);
        all.faces.extend(m.faces.iter().map(|f| f.map(|v| v + n)));
    }
    all
}

fn fog(scattering: Vec3, density: Option<Density>) -> Volume {
    Volume { absorption: Vec3::new(0.1, 0.2, 0.3), scattering, emission: Vec3::new(0.02, 0.0, 0.01), anisotropy: 0.4, density }
}

fn filled(volume: Volume, at: DVec3) -> Object {
    let mut o = wearing(Shape::Mesh(Arc::new(cube())), Shader { volume: Some(volume), ..Shader::default() });
    o.transform = Transform::scaling(DVec3::splat(0.7)).then(&Transform::translation(at));
    o
}

fn foggy(volume: Volume) -> Scene {
    let mut scene = scene_of(vec![diffuse(0.7, 0.3, 0.2)], vec![light()], 0.2);
    scene.objects.push(filled(volume, DVec3::new(0.0, -0.4, 0.75)));
    scene
}

#[test]
fn volumes_that_are_even_answer_the_same() {
    let mut scene = foggy(fog(Vec3::new(0.8, 0.6, 0.4), None));
    scene.objects.push(filled(fog(Vec3::ZERO, None), DVec3::new(1.0, -0.2, 0.8)));
    scene.environment.as_mut().expect("a sky").volume = Some(Volume { scattering: Vec3::splat(0.02), ..fog(Vec3::ZERO, None) });
    agrees("even volumes", &scene, 0.9);
}

#[test]
fn volumes_with_a_grid_answer_the_same() {
    let cells = (0..4 * 3 * 5).map(|k| 3.0 * (0.7 * k as f32).sin().max(0.0)).collect();
    let grid = Arc::new(Grid { size: [4, 3, 5], cells });
    let transform = Transform::translation(DVec3::splat(-0.5)).then(&Transform::scaling(DVec3::splat(2.0)));
    agrees("grids", &foggy(fog(Vec3::new(1.5, 1.2, 0.9), Some(Density { grid, transform }))), 0.85);
}

#[test]
fn walks_below_the_surface_come_out_the_same() {
    let body = PrincipledClosure {
        base_color: Color::constant(Vec3::new(0.8, 0.4, 0.3)),
        subsurface_weight: 0.8.into(),
        subsurface_scale: Scalar::constant(0.3),
        subsurface_anisotropy: 0.3.into(),
        ..PrincipledClosure::default()
    };
    // A walk has dozens of turns: rounding sends many elsewhere.
    agrees("subsurface", &scene_of(vec![Closure::Principled(Box::new(body))], vec![light()], 0.2), 0.8);
}

#[test]
fn a_closure_of_light_below_the_surface_and_a_face_of_the_same_material_are_told_apart() {
    let wax = Closure::Subsurface {
        method: rayloom::scene::shader::SubsurfaceMethod::RandomWalk,
        color: Color::constant(Vec3::new(0.9, 0.8, 0.5)),
        radius: Color::constant(Vec3::new(1.0, 0.5, 0.2)),
        scale: 0.5.into(),
        ior: 1.4.into(),
        roughness: 1.0.into(),
        anisotropy: 0.0.into(),
        normal: None,
    };
    let mut scene = scene_of(vec![wax.clone(), wax.clone()], vec![light()], 0.2);
    // A wall inside of what another object is made of: walks do not see it.
    scene.objects.push(covered(square([[-1.0, 0.0, 0.2], [1.0, 0.0, 0.2], [1.0, 0.0, 0.9], [-1.0, 0.0, 0.9]]), wax));
    agrees("wax", &scene, 0.8);
}
