//! The Principled closure in a white room, held against what Cycles measures there (`tests/measured/cycles_furnace.py`), and lobes that
//! must give back all light.

use super::tests::{compiled, covered, scene};
use super::{PathPlan, PathTracer};
use crate::math::{DVec3, Rgb, Vec3};
use crate::scene::input::{NormalInput, Picture};
use crate::scene::material::{MaterialImage, MaterialTexture, Texels, Wrap};
use crate::scene::shader::{Closure, PrincipledClosure};
use crate::scene::{Mesh, Projection, Shape};
use std::sync::Arc;

const BENT: &str = include_str!("../../../tests/measured/cycles_bent.txt");
const MEASURED: &str = include_str!("../../../tests/measured/cycles_furnace.txt");

/// The lobes of the script.
fn lobe(name: &str, roughness: f32) -> PrincipledClosure {
    let p = PrincipledClosure { base_color: 1.0.into(), roughness: 0.5.into(), ..PrincipledClosure::default() };
    let r = || roughness.into();
    let rgb = |r, g, b| crate::scene::input::Color::constant(Vec3::new(r, g, b));
    let black = || PrincipledClosure { base_color: 0.0.into(), ..p.clone() };
    match name {
        "plain" => PrincipledClosure { roughness: r(), ..p },
        "specular" => PrincipledClosure { roughness: r(), ..black() },
        "specular_tinted" => {
            PrincipledClosure { roughness: r(), specular_tint: rgb(1.0, 0.5, 0.1), specular_ior_level: 0.8.into(), ..black() }
        }
        "metal" => PrincipledClosure { roughness: r(), metallic: 1.0.into(), ..p },
        "metal_f82" => PrincipledClosure {
            roughness: r(),
            metallic: 1.0.into(),
            base_color: rgb(0.9, 0.6, 0.3),
            specular_tint: rgb(0.4, 0.8, 1.0),
            ..p
        },
        "coat" => PrincipledClosure { coat_roughness: r(), coat_weight: 1.0.into(), ..p },
        "coat_black" => PrincipledClosure { coat_roughness: r(), coat_weight: 1.0.into(), specular_ior_level: 0.0.into(), ..black() },
        "sheen" => PrincipledClosure { sheen_roughness: r(), sheen_weight: 1.0.into(), specular_ior_level: 0.0.into(), ..black() },
        "sheen_white" => PrincipledClosure { sheen_roughness: r(), sheen_weight: 1.0.into(), ..p },
        "glass" => PrincipledClosure { roughness: r(), transmission_weight: 1.0.into(), ..p },
        "film" => PrincipledClosure { roughness: r(), thin_film_thickness: 400.0.into(), ..black() },
        "film_white" => PrincipledClosure { roughness: r(), thin_film_thickness: 400.0.into(), ..p },
        "rough_diffuse" => PrincipledClosure { diffuse_roughness: r(), specular_ior_level: 0.0.into(), ..p },
        "rough_diffuse_grey" => {
            PrincipledClosure { diffuse_roughness: r(), specular_ior_level: 0.0.into(), base_color: rgb(0.5, 0.2, 0.8), ..p }
        }
        "aniso" => PrincipledClosure { roughness: r(), metallic: 1.0.into(), anisotropic: 0.8.into(), ..p },
        other => panic!("no lobe {other}"),
    }
}

/// What a plane in a white room sends to a viewer at an angle from its normal.
fn albedo(p: PrincipledClosure, degrees: f64, n: u32) -> Rgb {
    albedo_of(covered(Shape::Plane { normal: DVec3::Z, distance: 0.0 }, Closure::Principled(Box::new(p))), degrees, n)
}

fn albedo_of(floor: crate::scene::Object, degrees: f64, n: u32) -> Rgb {
    let mut s = scene(vec![floor], vec![], Vec3::ONE);
    let (sin, cos) = degrees.to_radians().sin_cos();
    s.camera.projection = Projection::Orthographic;
    s.camera.location = DVec3::new(sin, 0.0, cos) * 10.0;
    (s.camera.direction, s.camera.right, s.camera.up) = (DVec3::new(-sin, 0.0, -cos), DVec3::Y * 1e-3, DVec3::new(-cos, 0.0, sin) * 1e-3);
    let c = compiled(&s);
    let plan = PathPlan::new(&c, 1, 1, 7, false);
    let [r, g, b, _] = PathTracer::new(&plan).pixel(0, 0, 0..n).color;
    Vec3::new(r, g, b)
}

#[test]
fn the_principled_closure_gives_back_what_cycles_does() {
    let mut wrong = Vec::new();
    for line in MEASURED.lines().filter(|l| !l.starts_with('#')) {
        let words: Vec<&str> = line.split(' ').collect();
        let number = |k: usize| words[k].parse::<f64>().expect("a number");
        let (name, roughness, degrees) = (words[0], number(1) as f32, number(2));
        let theirs = Vec3::new(number(3) as f32, number(4) as f32, number(5) as f32);
        let ours = albedo(lobe(name, roughness), degrees, 1 << 14);
        let off = (ours - theirs).abs().max_element();
        if off > tolerance(name, theirs) {
            wrong.push(format!("{line}: {ours}, off by {off:.4}"));
        }
    }
    assert!(wrong.is_empty(), "{} differ:\n{}", wrong.len(), wrong.join("\n"));
}

/// How far ours may be from Cycles'. Its own tables of 16 to 32 steps lose up to 1.5 % of what must stay white at grazing angles; the
/// published fits of the sheen's table are off by up to 0.009.
fn tolerance(name: &str, theirs: Rgb) -> f32 {
    match name {
        "plain" | "coat" | "sheen_white" | "glass" => 1.5e-2 * f32::from(theirs.x < 0.998) + 3e-3,
        "sheen" => 1e-2,
        "film_white" => 6e-3,
        _ => 3e-3,
    }
}

#[test]
fn white_materials_stay_white_in_a_white_room() {
    let mut wrong = Vec::new();
    for name in ["plain", "metal", "coat", "sheen_white", "glass", "rough_diffuse"] {
        for roughness in [0.0f32, 0.05, 0.1, 0.2, 0.35, 0.5, 0.65, 0.8, 0.9, 1.0] {
            for degrees in [0.0, 30.0, 60.0, 75.0, 85.0] {
                let got = albedo(lobe(name, roughness), degrees, 1 << 14).x;
                if (got - 1.0).abs() > 1e-3 {
                    wrong.push(format!("{name}, roughness {roughness}, {degrees} degrees: {got}"));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{} differ:\n{}", wrong.len(), wrong.join("\n"));
}

/// A quad under a map whose normal leans by `tilt` degrees to `azimuth`.
fn bent_quad(p: PrincipledClosure, tilt: f32, azimuth: f32) -> crate::scene::Object {
    let (sin, cos) = tilt.to_radians().sin_cos();
    let (y, x) = azimuth.to_radians().sin_cos();
    let texel = [0.5 + 0.5 * sin * x, 0.5 + 0.5 * sin * y, 0.5 + 0.5 * cos, 1.0];
    let image = MaterialImage { width: 1, height: 1, texels: Texels::RgbaF32(vec![texel]) };
    let texture = MaterialTexture {
        image: Arc::new(image),
        srgb: false,
        wrap: [Wrap::Repeat; 2],
        linear: false,
        uv_transform: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
    };
    let picture = Picture { texture, uv_set: 0, filter_encoded: false, premultiplied: false };
    let normal = NormalInput::Map { picture, strength: 1.0.into(), scale_xy: false };
    let p = PrincipledClosure { normal: Some(Box::new(normal)), ..p };
    let corner = |x: f32, y: f32| Vec3::new(x, y, 0.0) * 100.0;
    let mesh = Mesh {
        vertices: vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)],
        uvs: vec![[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]],
        faces: vec![[0, 1, 2], [0, 2, 3]],
        uv_indices: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    };
    covered(Shape::Mesh(Arc::new(mesh)), Closure::Principled(Box::new(p)))
}

#[test]
fn bent_normals_lose_the_light_that_they_lose_in_cycles() {
    let mut wrong = Vec::new();
    for line in BENT.lines().filter(|l| !l.starts_with('#')) {
        let words: Vec<&str> = line.split(' ').collect();
        let number = |k: usize| words[k].parse::<f64>().expect("a number");
        let p = match words[0] {
            "diffuse" => lobe("rough_diffuse", 0.0),
            name => lobe(name, number(1) as f32),
        };
        let got = albedo_of(bent_quad(p, number(3) as f32, number(4) as f32), number(2), 1 << 14).x;
        let off = (got - number(5) as f32).abs();
        // Cycles' reflection gains up to 2.5 % more under bent normals at roughness 0.6 than the model here, and loses 10 % in one case at 1.
        let known: f32 = if words[0] != "metal" { 0.0 } else { 3.5e-2 + if line.starts_with("metal 1.0 60 45 90") { 0.1 } else { 0.0 } };
        if off > known.max(6e-3) {
            wrong.push(format!("{line}: {got:.4}, off by {off:.4}"));
        }
    }
    assert!(wrong.is_empty(), "{} differ:\n{}", wrong.len(), wrong.join("\n"));
}

#[test]
fn half_spaces_of_subsurface_give_back_what_cycles_measures() {
    // Source: Cycles 4.5.15 as in cycles_furnace.py, base colour (0.8, 0.5, 0.2), radius 0.1, no specular light.
    for (degrees, theirs) in [(5.0, [0.7713, 0.4425, 0.1645]), (60.0, [0.8280, 0.5319, 0.2186]), (80.0, [0.8714, 0.6162, 0.2846])] {
        let p = PrincipledClosure {
            base_color: crate::scene::input::Color::constant(Vec3::new(0.8, 0.5, 0.2)),
            specular_ior_level: 0.0.into(),
            subsurface_weight: 1.0.into(),
            subsurface_radius: 1.0.into(),
            subsurface_scale: 0.1.into(),
            ..PrincipledClosure::default()
        };
        let got = albedo_of(bent_quad(p, 0.0, 0.0), degrees, 1 << 15);
        assert!((got - Vec3::from_array(theirs)).abs().max_element() < 1.3e-2, "{degrees} degrees: {got}, not {theirs:?}");
    }
}
