//! The Principled closure in a white room, held against what Cycles measures there (`tests/measured/cycles_furnace.py`), and lobes that
//! must give back all light.

use super::tests::{compiled, covered, scene};
use super::{PathPlan, PathTracer};
use crate::math::{DVec3, Rgb, Vec3};
use crate::scene::input::{NormalInput, Picture};
use crate::scene::material::{MaterialImage, MaterialTexture, Texels, Wrap};
use crate::scene::shader::{Closure, PrincipledClosure, SubsurfaceMethod};
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
        let ours = albedo(lobe(name, roughness), degrees, 1 << 15);
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

/// A sheet between z = 0 and z = -depth.
fn sheet(closure: Closure, depth: f32) -> crate::scene::Object {
    let corner = |k: usize, z: f32| Vec3::new([-100.0, 100.0, 100.0, -100.0][k], [-100.0, -100.0, 100.0, 100.0][k], z);
    let mesh = Mesh {
        vertices: (0..8).map(|k| corner(k % 4, if k < 4 { 0.0 } else { -depth })).collect(),
        faces: vec![[0, 1, 2], [0, 2, 3], [4, 6, 5], [4, 7, 6]],
        ..Mesh::default()
    };
    covered(Shape::Mesh(Arc::new(mesh)), closure)
}

fn subsurface(method: SubsurfaceMethod, albedo: f32, ior: f32, roughness: f32, scale: f32) -> Closure {
    Closure::Subsurface {
        method,
        color: albedo.into(),
        radius: 1.0.into(),
        scale: scale.into(),
        ior: ior.into(),
        anisotropy: 0.0.into(),
        roughness: roughness.into(),
        normal: None,
    }
}

#[test]
fn bodies_of_subsurface_give_back_what_cycles_measures() {
    use SubsurfaceMethod::{RandomWalk as Plain, RandomWalkSkin as Skin};
    // Source: Cycles 4.5.15, the Subsurface Scattering node on a plane of 4 m in a white room, 512 to 4,096 samples of 256 pixels. By method, colour,
    // index, roughness and radius: what a deep body gives back at 5, 60 and 85 degrees from the normal.
    let deep = [
        (Plain, 0.5, 1.0, 0.0, 0.1, [0.4418, 0.5316, 0.6293]),
        (Plain, 0.5, 1.4, 0.0, 0.1, [0.4416, 0.4765, 0.4921]),
        (Plain, 0.5, 1.4, 0.5, 0.1, [0.4451, 0.5026, 0.5773]),
        (Plain, 0.5, 1.4, 1.0, 0.1, [0.4497, 0.5229, 0.6077]),
        (Plain, 0.5, 2.0, 1.0, 0.1, [0.4613, 0.5226, 0.5869]),
        (Plain, 0.2, 1.0, 0.5, 0.1, [0.1616, 0.2180, 0.3141]),
        (Plain, 0.8, 1.0, 0.5, 0.1, [0.7706, 0.8280, 0.8853]),
        (Plain, 1.0, 1.0, 0.5, 0.1, [0.8977, 0.9281, 0.9546]),
        (Skin, 0.5, 1.4, 1.0, 0.01, [0.4773, 0.5142, 0.5562]),
    ];
    for (method, albedo, ior, roughness, scale, theirs) in deep {
        for (degrees, want) in [5.0, 60.0, 85.0].into_iter().zip(theirs) {
            let got = albedo_of(sheet(subsurface(method, albedo, ior, roughness, scale), 50.0), degrees, 1 << 15).x;
            assert!((got - want).abs() < 7e-3, "{method:?} {albedo} {ior} {roughness} at {degrees} degrees: {got}, not {want}");
        }
    }
    // Along the normal, what a sheet of 0.04 m gives back and lets through.
    let thin = [
        (Plain, 0.2, 1.0, 0.0, 0.2, 0.3007),
        (Plain, 0.5, 1.0, 0.0, 0.2, 0.6919),
        (Plain, 0.5, 1.0, 0.0, 1.0, 0.9424),
        (Skin, 0.2, 1.0, 1.0, 0.05, 0.5928),
        (Skin, 0.5, 1.0, 1.0, 0.05, 0.7403),
        (Skin, 0.5, 1.4, 1.0, 0.05, 0.6421),
    ];
    for (method, albedo, ior, roughness, scale, want) in thin {
        let got = albedo_of(sheet(subsurface(method, albedo, ior, roughness, scale), 0.04), 0.0, 1 << 15).x;
        assert!((got - want).abs() < 7e-3, "{method:?} {albedo} {ior} {roughness} in a sheet: {got}, not {want}");
    }
}
