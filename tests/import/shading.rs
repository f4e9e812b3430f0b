//! Pictures of imports on the CPU, held against analytic answers.

use crate::files::{Data, Folder, SQUARE, png};
use rayloom::backend::{Backend, cpu::CpuBackend};
use rayloom::compile::{CompileOptions, compile_scene};
use rayloom::film::Film;
use rayloom::integrate::RenderSettings;
use rayloom::scene::Scene;
use std::f64::consts::PI;

const WIDTH: u32 = 32;
const HEIGHT: u32 = 16;

fn render(scene: &Scene) -> Film {
    let settings = RenderSettings::plain(WIDTH, HEIGHT);
    let compiled = compile_scene(scene, &CompileOptions::default()).expect("a small scene");
    let mut film = Film::new(WIDTH, HEIGHT);
    CpuBackend::new(1).render(&compiled, &settings, &mut film, &(), &Default::default()).expect("renders");
    film
}

fn pixel(film: &Film, x: u32, y: u32) -> [f32; 3] {
    let p = film.pixels[film.index(x, y)];
    [p[0], p[1], p[2]]
}

fn near(got: [f32; 3], want: [f64; 3], tolerance: f64) {
    for k in 0..3 {
        assert!((f64::from(got[k]) - want[k]).abs() <= tolerance * want[k].max(0.1), "{got:?}, not {want:?}");
    }
}

/// A dull white square of side 1, then whatever `materials` says; node 0 is the camera above the square's middle looking down -z,
/// its picture 1 high and 2 wide at the square.
fn scene(materials: &str, nodes: &str, more: &str, pictures: &[Vec<u8>]) -> Scene {
    let mut d = Data::default();
    let (p, i) = (d.floats("VEC3", 3, &SQUARE), d.indices(&[0, 1, 2, 0, 2, 3]));
    let uv = d.floats("VEC2", 2, &[0., 1., 1., 1., 1., 0., 0., 0.]);
    let images: Vec<String> = pictures.iter().map(|b| format!(r#"{{"bufferView":{}}}"#, d.add(b, 5121, "SCALAR", b.len(), ""))).collect();
    let textures: Vec<String> = (0..images.len()).map(|k| format!(r#"{{"source":{k},"sampler":0}}"#)).collect();
    let n_materials = materials.matches("pbrMetallicRoughness").count();
    let meshes: Vec<String> = (0..n_materials)
        .map(|k| format!(r#"{{"primitives":[{{"attributes":{{"POSITION":{p},"TEXCOORD_0":{uv}}},"indices":{i},"material":{k}}}]}}"#))
        .collect();
    let rest = format!(
        r#","meshes":[{}],"materials":[{materials}],"images":[{}],"textures":[{}],"samplers":[{{"wrapS":33071,"wrapT":33071,"magFilter":9728}}],
        "cameras":[{{"type":"orthographic","orthographic":{{"xmag":1,"ymag":0.5,"znear":0.1,"zfar":100}}}}],
        "nodes":[{{"camera":0,"translation":[0.5,0.5,10]}},{nodes}]{more}"#,
        meshes.join(","),
        images.join(","),
        textures.join(",")
    );
    Folder::new().with("x.glb", d.glb(&rest)).scene("x.glb")
}

const DULL: &str = r#"{"pbrMetallicRoughness":{"metallicFactor":0},"extensions":{"KHR_materials_specular":{"specularFactor":0}}}"#;
const DARK_GLOW: &str = r#"{"pbrMetallicRoughness":{"baseColorFactor":[0,0,0,1],"metallicFactor":0},"emissiveFactor":[0.25,0.5,1],
    "extensions":{"KHR_materials_specular":{"specularFactor":0}}}"#;

fn lamp(json: &str) -> String {
    format!(r#","extensions":{{"KHR_lights_punctual":{{"lights":[{json}]}}}}"#)
}
const LAMP_NODE: &str = r#""extensions":{"KHR_lights_punctual":{"light":0}}"#;

#[test]
fn a_white_plane_under_a_point_lamp_is_intensity_over_pi_and_distance_squared() {
    let nodes = format!(r#"{{"mesh":0}},{{"translation":[0.5,0.5,2],{LAMP_NODE}}}"#);
    let film = render(&scene(DULL, &nodes, &lamp(r#"{"type":"point","intensity":6,"color":[1,0.5,0]}"#), &[]));
    for (x, y) in [(16u32, 8u32), (9, 2), (22, 14)] {
        let (px, py) = ((f64::from(x) + 0.5) / 16.0 - 0.5, 1.0 - (f64::from(y) + 0.5) / 16.0);
        let d_sq = (px - 0.5f64).powi(2) + (py - 0.5f64).powi(2) + 4.0;
        // Schlick's law leaves a trace of light at the rim even without specular: none along the way to the lamp here.
        let want = 6.0 / d_sq * (2.0 / d_sq.sqrt()) / PI;
        near(pixel(&film, x, y), [want, 0.5 * want, 0.0], 0.01);
    }
    near(pixel(&film, 0, 0), [0.0; 3], 0.0);
}

#[test]
fn a_sun_gives_irradiance_over_pi_from_either_side_and_casts_shadows() {
    let sun = lamp(r#"{"type":"directional","intensity":2}"#);
    let lit = |nodes: &str| pixel(&render(&scene(DULL, nodes, &sun, &[])), 16, 8);
    near(lit(&format!(r#"{{"mesh":0}},{{{LAMP_NODE}}}"#)), [2.0 / PI; 3], 0.01);
    // Turned over: its back is seen and lit.
    near(lit(&format!(r#"{{"mesh":0,"rotation":[1,0,0,0],"translation":[0,1,0]}},{{{LAMP_NODE}}}"#)), [2.0 / PI; 3], 0.01);
    // Lit from behind.
    near(lit(&format!(r#"{{"mesh":0}},{{"rotation":[1,0,0,0],{LAMP_NODE}}}"#)), [0.0; 3], 0.0);
    // A second square above, beside the camera's way: the sun comes aslant.
    let aslant = r#""rotation":[0,0.38268343,0,0.92387953]"#;
    near(lit(&format!(r#"{{"mesh":0}},{{{aslant},{LAMP_NODE}}}"#)), [2.0 / PI * 0.5f64.sqrt(); 3], 0.01);
    near(lit(&format!(r#"{{"mesh":0}},{{"mesh":0,"translation":[2,0,2]}},{{{aslant},{LAMP_NODE}}}"#)), [0.0; 3], 0.0);
}

#[test]
fn emission_is_seen_as_it_is_and_lights_what_faces_it() {
    let film = render(&scene(DARK_GLOW, r#"{"mesh":0}"#, "", &[]));
    near(pixel(&film, 16, 8), [0.25, 0.5, 1.0], 1e-5);
    // A shining square of side 1 standing on the floor's edge, at right angles. Form factor from the middle of the floor to it:
    // (1 / 2 pi) (atan(1/2c..)) by the formula for a patch and a perpendicular rectangle at its foot, both halves alike.
    let materials = format!("{DULL},{DARK_GLOW}");
    let film = render(&scene(&materials, r#"{"mesh":0},{"mesh":1,"rotation":[0.70710678,0,0,0.70710678],"translation":[0,1,0]}"#, "", &[]));
    let (a, b, c) = (0.5f64, 1.0f64, 0.53125f64);
    let (x, y) = (b / a, c / a);
    let half = ((1.0 / y).atan() - y / (x * x + y * y).sqrt() * (1.0 / (x * x + y * y).sqrt()).atan()) / (2.0 * PI);
    let form = 2.0 * half;
    near(pixel(&film, 16, 8), [0.25 * form, 0.5 * form, form], 0.06);
}

#[test]
fn alpha_blends_masks_and_is_ignored_when_opaque() {
    let veil = |mode: &str| {
        format!(
            r#"{DARK_GLOW},{{"pbrMetallicRoughness":{{"baseColorFactor":[0,0,0,0.25],"metallicFactor":0}},{mode}
            "extensions":{{"KHR_materials_specular":{{"specularFactor":0}}}}}}"#
        )
    };
    let nodes = r#"{"mesh":0},{"mesh":1,"translation":[0,0,1]}"#;
    let seen = |mode: &str| pixel(&render(&scene(&veil(mode), nodes, "", &[])), 16, 8);
    near(seen(r#""alphaMode":"BLEND","#), [0.1875, 0.375, 0.75], 1e-4);
    near(seen(r#""alphaMode":"MASK","#), [0.25, 0.5, 1.0], 1e-4);
    near(seen(r#""alphaMode":"MASK","alphaCutoff":0.2,"#), [0.0; 3], 1e-4);
    near(seen(""), [0.0; 3], 1e-4);
}

#[test]
fn pictures_lie_upright_and_unmirrored_and_are_decoded_from_srgb() {
    let picture = png(2, 2, |x, y| [if x == 1 { 255 } else { 0 }, if y == 0 { 188 } else { 0 }, 0, 255]);
    let m = r#"{"pbrMetallicRoughness":{"baseColorFactor":[0,0,0,1],"metallicFactor":0},"emissiveFactor":[1,1,1],"emissiveTexture":{"index":0},
        "extensions":{"KHR_materials_specular":{"specularFactor":0}}}"#;
    let film = render(&scene(m, r#"{"mesh":0}"#, "", &[picture]));
    near(pixel(&film, 12, 4), [0.0, 0.5029, 0.0], 0.01);
    near(pixel(&film, 19, 4), [1.0, 0.5029, 0.0], 0.01);
    near(pixel(&film, 12, 11), [0.0, 0.0, 0.0], 0.01);
    near(pixel(&film, 19, 11), [1.0, 0.0, 0.0], 0.01);
}

#[test]
fn normal_maps_lean_red_to_the_right_and_green_to_the_top_on_both_sides() {
    // Normals of 45 degrees to the right and to the top of the picture.
    let c = |v: f64| (127.5 * (v + 1.0)).round() as u8;
    let s = 0.5f64.sqrt();
    let right = png(1, 1, |_, _| [c(s), c(0.0), c(s), 255]);
    let top = png(1, 1, |_, _| [c(0.0), c(s), c(s), 255]);
    let m = r#"{"pbrMetallicRoughness":{"metallicFactor":0},"normalTexture":{"index":0},"extensions":{"KHR_materials_specular":{"specularFactor":0}}}"#;
    let sun = lamp(r#"{"type":"directional","intensity":3.14159265}"#);
    // Suns from the right and from the top, 45 degrees high.
    let from_right = format!(r#"{{"rotation":[0,0.38268343,0,0.92387953],{LAMP_NODE}}}"#);
    let from_top = format!(r#"{{"rotation":[-0.38268343,0,0,0.92387953],{LAMP_NODE}}}"#);
    let lit = |picture: &[u8], node: &str, sun_node: &str| {
        f64::from(pixel(&render(&scene(m, &format!("{node},{sun_node}"), &sun, &[picture.to_vec()])), 16, 8)[0])
    };
    let plain = r#"{"mesh":0}"#;
    assert!((lit(&right, plain, &from_right) - 1.0).abs() < 0.02);
    assert!((lit(&top, plain, &from_top) - 1.0).abs() < 0.02);
    assert!((lit(&right, plain, &from_top) - 0.5).abs() < 0.02);
    // A mirrored node mirrors the bumps with it.
    let mirrored = r#"{"mesh":0,"scale":[-1,1,1],"translation":[1,0,0]}"#;
    assert!(lit(&right, mirrored, &from_right) < 0.02, "the bump leans away from the sun");
}

#[test]
fn smooth_normals_are_interpolated_and_follow_scaled_nodes() {
    let mut d = Data::default();
    let s = 0.5f32.sqrt();
    let p = d.floats("VEC3", 3, &SQUARE);
    // A ridge: normals lean left on the left and right on the right.
    let n = d.floats("VEC3", 3, &[-s, 0., s, s, 0., s, s, 0., s, -s, 0., s]);
    let i = d.indices(&[0, 1, 2, 0, 2, 3]);
    let file = |node: &str| {
        d.glb(&format!(
            r#","materials":[{DULL}],"meshes":[{{"primitives":[{{"attributes":{{"POSITION":{p},"NORMAL":{n}}},"indices":{i},"material":0}}]}}],
            "cameras":[{{"type":"orthographic","orthographic":{{"xmag":1,"ymag":0.5,"znear":0.1,"zfar":100}}}}],
            "nodes":[{{"camera":0,"translation":[0.5,0.5,10]}},{{"mesh":0{node}}},{{{LAMP_NODE}}}]{}"#,
            lamp(r#"{"type":"directional","intensity":3.14159265}"#)
        ))
    };
    let f = Folder::new().with("a.glb", file("")).with("b.glb", file(r#","scale":[1,1,2]"#));
    let film = render(&f.scene("a.glb"));
    let cos = |u: f64, slope: f64| 1.0 / (1.0 + (slope * (2.0 * u - 1.0)).powi(2)).sqrt();
    for x in [9u32, 16, 20] {
        let u = (f64::from(x) + 0.5) / 16.0 - 0.5;
        near(pixel(&film, x, 8), [cos(u, 1.0); 3], 0.01);
    }
    // Stretched along z, normals (s, 0, s) become (s, 0, s / 2).
    near(pixel(&render(&f.scene("b.glb")), 20, 8), [cos(20.5 / 16.0 - 0.5, 2.0); 3], 0.01);
}

#[test]
fn vertex_colours_tint_the_surface() {
    let mut d = Data::default();
    let (p, i) = (d.floats("VEC3", 3, &SQUARE), d.indices(&[0, 1, 2, 0, 2, 3]));
    let c = d.floats("VEC3", 3, &[0., 0., 0., 1., 0., 0., 1., 1., 0., 0., 1., 0.]);
    let f = Folder::new().with(
        "a.glb",
        d.glb(&format!(
            r#","materials":[{DULL}],"meshes":[{{"primitives":[{{"attributes":{{"POSITION":{p},"COLOR_0":{c}}},"indices":{i},"material":0}}]}}],
            "cameras":[{{"type":"orthographic","orthographic":{{"xmag":1,"ymag":0.5,"znear":0.1,"zfar":100}}}}],
            "nodes":[{{"camera":0,"translation":[0.5,0.5,10]}},{{"mesh":0}},{{{LAMP_NODE}}}]{}"#,
            lamp(r#"{"type":"directional","intensity":3.14159265}"#)
        )),
    );
    let film = render(&f.scene("a.glb"));
    near(pixel(&film, 11, 4), [3.5 / 16.0, 11.5 / 16.0, 0.0], 0.01);
}

#[test]
fn many_shining_balls_light_a_plane_as_balls_do() {
    // 40 octahedra of "radius" 0.1 along a line, all at one place by symmetry of the test: their light adds up.
    let mut d = Data::default();
    let (p, i) = (d.floats("VEC3", 3, &SQUARE), d.indices(&[0, 1, 2, 0, 2, 3]));
    let ball = d.floats("VEC3", 3, &[1., 0., 0., -1., 0., 0., 0., 1., 0., 0., -1., 0., 0., 0., 1., 0., 0., -1.]);
    let faces = d.indices(&[0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4, 2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5]);
    let n = 40;
    let balls: Vec<String> = (0..n)
        .map(|k| {
            let angle = 2.0 * PI * f64::from(k) / f64::from(n);
            let (y, x) = angle.sin_cos();
            format!(r#"{{"mesh":1,"scale":[0.1,0.1,0.1],"translation":[{},{},3]}}"#, 0.53125 + 4.0 * x, 0.46875 + 4.0 * y)
        })
        .collect();
    let bytes = d.glb(&format!(
        r#","materials":[{DULL},{{"pbrMetallicRoughness":{{"baseColorFactor":[0,0,0,1]}},"emissiveFactor":[1,1,1]}}],"meshes":[
        {{"primitives":[{{"attributes":{{"POSITION":{p}}},"indices":{i},"material":0}}]}},
        {{"primitives":[{{"attributes":{{"POSITION":{ball}}},"indices":{faces},"material":1}}]}}],
        "cameras":[{{"type":"orthographic","orthographic":{{"xmag":1,"ymag":0.5,"znear":0.1,"zfar":100}}}}],
        "nodes":[{{"camera":0,"translation":[0.5,0.5,10]}},{{"mesh":0}},{}]"#,
        balls.join(",")
    ));
    let film = render(&Folder::new().with("x.glb", bytes).scene("x.glb"));
    // A convex body shows a quarter of its surface on the mean: 4 sqrt(3) r^2 / 4 of an octahedron, 5 away, cosine 3 / 5.
    let want = f64::from(n) * (3f64.sqrt() * 0.01) * (3.0 / 5.0) / 25.0 / PI;
    let got = pixel(&film, 16, 8);
    assert!((f64::from(got[0]) / want - 1.0).abs() < 0.02, "{got:?}, not {want}");
}
