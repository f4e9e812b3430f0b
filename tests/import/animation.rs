//! Animations, skins and morph targets at a time, against answers by hand; broken ones and what is said of them.

use crate::files::{Data, Folder, SQUARE, mesh};
use rayloom::backend::{Backend, cpu::CpuBackend};
use rayloom::compile::{CompileOptions, compile_scene};
use rayloom::diag::Sink;
use rayloom::film::Film;
use rayloom::import::{ImportError, ImportOptions, load};
use rayloom::integrate::{IntegratorKind, RenderSettings};
use rayloom::math::{DVec3, Vec3};
use rayloom::scene::Scene;

fn load_at(bytes: &[u8], time: Option<f64>, animation: Option<&str>) -> (Result<Scene, ImportError>, Vec<String>) {
    let f = Folder::new().with("a.glb", bytes);
    let mut sink = Sink::default();
    let options = ImportOptions { time, animation: animation.map(str::to_owned), ..ImportOptions::default() };
    let scene = load(&f.path("a.glb"), &options, &mut sink);
    (scene, sink.items().iter().map(|d| d.message.clone()).collect())
}

fn at(bytes: &[u8], time: f64) -> Scene {
    load_at(bytes, Some(time), None).0.unwrap_or_else(|e| panic!("{e}"))
}

fn error(bytes: &[u8]) -> String {
    match load_at(bytes, Some(0.5), None).0 {
        Ok(_) => panic!("it loads"),
        Err(e) => e.to_string(),
    }
}

fn near(a: DVec3, b: DVec3) {
    assert!((a - b).length() < 1e-6, "{a}, not {b}");
}

/// A square whose node one channel animates: path, interpolation, times, kind and numbers of the values.
fn animated(path: &str, interpolation: &str, times: &[f32], kind: (&str, usize), values: &[f32]) -> Vec<u8> {
    let mut d = Data::default();
    let (p, i) = (d.floats("VEC3", 3, &SQUARE), d.indices(&[0, 1, 2, 0, 2, 3]));
    let moved = d.floats("VEC3", 3, &[[0.0, 0.0, 1.0]; 4].concat());
    let (input, output) = (d.floats("SCALAR", 1, times), d.floats(kind.0, kind.1, values));
    d.glb(&format!(
        r#","meshes":[{{"primitives":[{{"attributes":{{"POSITION":{p}}},"indices":{i},"targets":[{{"POSITION":{moved}}}]}}]}}],
        "nodes":[{{"mesh":0,"translation":[0,0,5]}}],"animations":[{{"name":"Walk","channels":[{{"sampler":0,"target":{{"node":0,"path":"{path}"}}}}],
        "samplers":[{{"input":{input},"output":{output},"interpolation":"{interpolation}"}}]}}]"#
    ))
}

#[test]
fn keys_are_held_joined_and_smoothed_as_they_ask() {
    let place = |bytes: &[u8], t: f64| at(bytes, t).objects[0].transform.point(DVec3::ZERO);
    let ends = [1., 0., 0., 3., 0., 8.];
    let linear = animated("translation", "LINEAR", &[1., 3.], ("VEC3", 3), &ends);
    for (t, x, z) in [(0.0, 1.0, 0.0), (1.0, 1.0, 0.0), (1.5, 1.5, 2.0), (3.0, 3.0, 8.0), (9.0, 3.0, 8.0)] {
        near(place(&linear, t), DVec3::new(x, 0.0, z));
    }
    let step = animated("translation", "STEP", &[1., 3.], ("VEC3", 3), &ends);
    near(place(&step, 2.999), DVec3::X);
    near(place(&step, 3.0), DVec3::new(3.0, 0.0, 8.0));
    // From 0 to 1 in 2 s, leaving with slope 3 a second, arriving with slope -1: h10 and h11 at a quarter are 9/64 and -3/64.
    let keys = [[0.; 3], [0.; 3], [3., 0., 0.], [-1., 0., 0.], [1., 0., 0.], [0.; 3]].concat();
    let spline = animated("translation", "CUBICSPLINE", &[0., 2.], ("VEC3", 3), &keys);
    let want = 2.0 * 3.0 * 9.0 / 64.0 + 10.0 / 64.0 + 2.0 * 3.0 / 64.0;
    near(place(&spline, 0.5), DVec3::new(want, 0.0, 0.0));
    near(place(&spline, 2.0), DVec3::X);
    let scale = animated("scale", "LINEAR", &[0., 1.], ("VEC3", 3), &[1., 1., 1., 3., 1., 1.]);
    near(at(&scale, 0.25).objects[0].transform.vector(DVec3::X), DVec3::X * 1.5);
}

#[test]
fn rotations_turn_evenly_by_the_shorter_way() {
    let (half, flipped) = (0.5f32.sqrt(), -(0.5f32.sqrt()));
    for end in [half, flipped] {
        let turn = animated("rotation", "LINEAR", &[0., 3.], ("VEC4", 4), &[0., 0., 0., 1., 0., 0., end, end]);
        for (t, degrees) in [(0.0, 0.0f64), (1.0, 30.0), (2.0, 60.0), (3.0, 90.0)] {
            let x = at(&turn, t).objects[0].transform.vector(DVec3::X);
            near(x, DVec3::new(degrees.to_radians().cos(), degrees.to_radians().sin(), 0.0));
        }
    }
}

#[test]
fn weights_morph_and_without_a_time_nothing_moves() {
    let bytes = animated("weights", "LINEAR", &[0., 2.], ("SCALAR", 1), &[0., 1.]);
    assert_eq!(mesh(&at(&bytes, 0.5), 0).vertices[1], Vec3::new(1.0, 0.0, 0.25));
    let (scene, said) = load_at(&bytes, None, None);
    let scene = scene.expect("loads");
    assert_eq!(mesh(&scene, 0).vertices[1], Vec3::X);
    assert!(said.iter().any(|m| m.contains("--frame or --time")), "{said:?}");
    let info = &scene.animations[0];
    assert_eq!((info.name.as_str(), info.seconds, info.n_channels), ("Walk", [0.0, 2.0], 1));
}

#[test]
fn animations_are_chosen_by_name_or_number() {
    let bytes = animated("weights", "LINEAR", &[0., 2.], ("SCALAR", 1), &[0., 1.]);
    for name in ["Walk", "0"] {
        assert!(load_at(&bytes, Some(1.0), Some(name)).0.is_ok());
    }
    let said = load_at(&bytes, Some(1.0), Some("Run")).0.expect_err("there is none").to_string();
    assert!(said.contains("no animation 'Run'; it has Walk"), "{said}");
    let still = Data::default().glb(r#","nodes":[{}]"#);
    let (scene, said) = load_at(&still, Some(1.0), None);
    assert!(scene.is_ok() && said.iter().any(|m| m.contains("no animation")), "{said:?}");
}

#[test]
fn broken_animations_name_their_channel() {
    let vec3 = ("VEC3", 3);
    let one = animated("translation", "LINEAR", &[0., 1.], vec3, &[0.; 6]);
    let text = |from: &str, to: &str| {
        // Same length, so that the container still holds.
        assert_eq!(from.len(), to.len());
        let at = one.windows(from.len()).position(|w| w == from.as_bytes()).expect("it is there");
        let mut bytes = one.clone();
        bytes[at..at + to.len()].copy_from_slice(to.as_bytes());
        bytes
    };
    for (bytes, what) in [
        (animated("translation", "LINEAR", &[0., 0.], vec3, &[0.; 6]), "animation 'Walk', channel 0: its times do not rise"),
        (animated("translation", "LINEAR", &[0., f32::NAN], vec3, &[0.; 6]), "its times do not rise"),
        (animated("translation", "LINEAR", &[0., 1.], vec3, &[0., 0., 0., f32::INFINITY, 0., 0.]), "a value is not finite"),
        (animated("translation", "CUBICSPLINE", &[0., 1.], vec3, &[0.; 6]), "2 values for 2 keys"),
        (animated("translation", "LINEAR", &[0., 1.], ("VEC4", 4), &[0.; 8]), "needs [3] numbers"),
        (animated("weights", "LINEAR", &[0., 1.], ("SCALAR", 1), &[0.; 4]), "4 values for 2 keys of 1"),
        (animated("colour", "LINEAR", &[0., 1.], vec3, &[0.; 6]), "its path is unknown"),
        (text(r#""sampler":0"#, r#""sampler":7"#), "sampler 7, but the file has 1"),
        (text(r#"{"node":0"#, r#"{"node":9"#), "node 9, but the file has 1"),
    ] {
        assert!(error(&bytes).contains(what), "{}, not {what}", error(&bytes));
    }
}

/// A bar of two joints: joint 0 at the origin, joint 1 one along x from it, turned by a quarter about z. `weights` of the four vertices
/// on the two joints.
fn skinned(skin: &str, joints: &[u8; 16], weights: &[f32; 16]) -> Vec<u8> {
    let mut d = Data::default();
    let p = d.floats("VEC3", 3, &[2., 0., 0., 2., 1., 0., 0., 1., 0., 0., 0., 1.]);
    let n = d.floats("VEC3", 3, &[[1.0, 0.0, 0.0]; 4].concat());
    let i = d.indices(&[0, 1, 2, 0, 2, 3]);
    let (j, w) = (d.add(joints, 5121, "VEC4", 4, ""), d.floats("VEC4", 4, weights));
    let bind = |x: f32| [1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., -x, 0., 0., 1.];
    let binds = d.floats("MAT4", 16, &[bind(0.0), bind(1.0)].concat());
    let skin = skin.replace("BINDS", &binds.to_string());
    d.glb(&format!(
        r#","meshes":[{{"primitives":[{{"attributes":{{"POSITION":{p},"NORMAL":{n},"JOINTS_0":{j},"WEIGHTS_0":{w}}},"indices":{i}}}]}}],
        "nodes":[{{"mesh":0,"skin":0,"translation":[0,0,77]}},{{"children":[2],"translation":[0,0,3]}},
        {{"translation":[1,0,0],"rotation":[0,0,0.70710678,0.70710678]}},{{}}],"scenes":[{{"nodes":[0,1]}}],"skins":[{{{skin}}}]"#
    ))
}

const JOINTS: [u8; 16] = [0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0];
const WEIGHTS: [f32; 16] = [0., 1., 0., 0., 0.5, 0.5, 0., 0., 1., 0., 0., 0., 2., 2., 0., 0.];

#[test]
fn skins_take_vertices_and_normals_along_with_their_joints() {
    let s = load_at(&skinned(r#""joints":[1,2],"inverseBindMatrices":BINDS"#, &JOINTS, &WEIGHTS), None, None).0.expect("loads");
    assert!(s.objects[0].transform.is_identity(), "the node of the mesh does not matter");
    let m = mesh(&s, 0);
    let want = [
        // All on joint 1: (1, 0, 0) from it, turned.
        Vec3::new(1.0, 1.0, 3.0),
        // Half (2, 1), half (1, 1) + (-1, 0) from joint 1.
        Vec3::new(1.0, 1.0, 3.0),
        Vec3::new(0.0, 1.0, 3.0),
        // Weights that add up to 4 count as halves: (0, 0) and (1, -1).
        Vec3::new(0.5, -0.5, 4.0),
    ];
    for (v, want) in m.vertices.iter().zip(want) {
        assert!((*v - want).length() < 1e-6, "{v}, not {want}");
    }
    assert!((m.normals[0] - Vec3::Y).length() < 1e-6 && (m.normals[2] - Vec3::X).length() < 1e-6);
    // Without inverse bind matrices joints are matrices as they stand.
    let plain = load_at(&skinned(r#""joints":[1,2]"#, &JOINTS, &WEIGHTS), None, None).0.expect("loads");
    assert!((mesh(&plain, 0).vertices[0] - Vec3::new(1.0, 2.0, 3.0)).length() < 1e-6);
}

#[test]
fn broken_skins_name_what_is_wrong() {
    let good = r#""joints":[1,2],"inverseBindMatrices":BINDS"#;
    let (mut joints, mut weights, mut below) = (JOINTS, WEIGHTS, WEIGHTS);
    (joints[5], weights[1], below[1]) = (9, f32::NAN, -1.0);
    for (bytes, what) in [
        (skinned(good, &joints, &WEIGHTS), "vertex 1 hangs on joint 9, the skin has 2"),
        (skinned(good, &JOINTS, &weights), "by the weight NaN"),
        (skinned(good, &JOINTS, &below), "by the weight -1"),
        (skinned(r#""joints":[1,99]"#, &JOINTS, &WEIGHTS), "node 99, but the file has 4"),
        (skinned(r#""joints":[1,3]"#, &JOINTS, &WEIGHTS), "its joint 1, node 3, is no part of the scene"),
        (skinned(r#""joints":[1,2,1],"inverseBindMatrices":BINDS"#, &JOINTS, &WEIGHTS), "2 matrices for 3 joints"),
    ] {
        assert!(error(&bytes).contains(what), "{}, not {what}", error(&bytes));
    }
}

#[test]
fn a_shutter_follows_an_animation() {
    let mut d = Data::default();
    let (p, i) = (d.floats("VEC3", 3, &SQUARE), d.indices(&[0, 1, 2, 0, 2, 3]));
    let up = d.floats("VEC3", 3, &[[0.0, 0.0, 1.0]; 4].concat());
    let (input, output) = (d.floats("SCALAR", 1, &[0., 10.]), d.floats("VEC3", 3, &[0., 0., 0., 240., 0., 0.]));
    let weights = d.floats("SCALAR", 1, &[0., 240.]);
    let bytes = d.glb(&format!(
        r#","meshes":[{{"primitives":[{{"attributes":{{"POSITION":{p}}},"indices":{i},"targets":[{{"POSITION":{up}}}]}}]}}],"scene":0,"scenes":[{{"nodes":[0]}}],
        "nodes":[{{"children":[1,2]}},{{"mesh":0}},{{"mesh":0}}],"extensionsUsed":["RAYLOOM_scene"],"extensions":{{"RAYLOOM_scene":{{"version":1,"root":0,
        "render":{{"resolution":[4,2],"motionBlur":{{"shutter":0.5,"position":"start"}}}}}}}},
        "animations":[{{"channels":[{{"sampler":0,"target":{{"node":1,"path":"translation"}}}},{{"sampler":1,"target":{{"node":2,"path":"weights"}}}}],
        "samplers":[{{"input":{input},"output":{output}}},{{"input":{input},"output":{weights}}}]}}]"#
    ));
    // 24 units a second are one a frame: half a unit while the shutter is open.
    let s = at(&bytes, 1.0);
    let moved: Vec<f64> = s.objects[0].traits.motion.iter().map(|t| t.point(DVec3::ZERO).x).collect();
    assert!(moved.iter().zip([24.0, 24.125, 24.25, 24.375, 24.5]).all(|(a, b)| (a - b).abs() < 1e-5), "{moved:?}");
    assert!(mesh(&s, 0).motion.is_empty() && s.objects[1].traits.motion.is_empty());
    let steps = &mesh(&s, 1).motion;
    assert!(steps.len() == 5 && (steps[4].vertices[0].z - 24.5).abs() < 1e-4, "{steps:?}");
    assert!((mesh(&s, 1).vertices[0].z - 24.0).abs() < 1e-4);
    assert!(load_at(&bytes, None, None).0.expect("loads").objects[0].traits.motion.is_empty(), "no time, no motion");
}

/// A shining and a plain square over a floor, moved by the node or by the vertices from the first to the last of three places.
fn blurred(by_vertices: bool) -> Film {
    let mut d = Data::default();
    let places = [[-1.0f32, 0.0, 0.0], [0.5, 0.25, 0.0], [1.0, 0.0, 0.5]];
    let (i, normals) = (d.indices(&[0, 1, 2, 0, 2, 3]), d.floats("VEC3", 3, &[[0.0, 0.0, 1.0]; 4].concat()));
    let p = d.floats("VEC3", 3, &SQUARE);
    let keys: Vec<f32> = places.iter().flat_map(|[x, y, z]| [1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., *x, *y, *z, 1.]).collect();
    let keys = d.floats("MAT4", 16, &keys);
    let moved = places.map(|by| d.floats("VEC3", 3, &SQUARE.iter().enumerate().map(|(k, v)| v + by[k % 3]).collect::<Vec<_>>()));
    let times = r#""times":[0,0.25,0.5]"#;
    let (node, vertices) = if by_vertices {
        let motion = format!(r#"{times},"positions":[{},{},{}],"normals":[{normals},{normals},{normals}]"#, moved[0], moved[1], moved[2]);
        (String::new(), format!(r#","extensions":{{"RAYLOOM_scene":{{"motion":{{{motion}}}}}}}"#))
    } else {
        (format!(r#","extensions":{{"RAYLOOM_scene":{{"motion":{{{times},"matrices":{keys}}}}}}}"#), String::new())
    };
    let mesh = |m: u32, more: &str| {
        format!(r#"{{"primitives":[{{"attributes":{{"POSITION":{p},"NORMAL":{normals}}},"indices":{i},"material":{m}{more}}}]}}"#)
    };
    let shader = |nodes: &str| format!(r#"{{"extensions":{{"RAYLOOM_scene":{{"nodes":[{nodes}],"surface":0}}}}}}"#);
    // The nodes' own matrices, in the middle of the shutter, are those of the middle key.
    let middle = if by_vertices { "" } else { r#","matrix":[1,0,0,0, 0,1,0,0, 0,0,1,0, 0.5,0.25,0,1]"# };
    let bytes = d.glb(&format!(
        r#","scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{{"children":[1,2,3,4]}},
        {{"camera":0,"matrix":[1,0,0,0, 0,1,0,0, 0,0,1,0, 0.5,0.5,6,1]}},{{"mesh":0,"matrix":[8,0,0,0, 0,8,0,0, 0,0,1,0, -4,-4,-1,1]}},
        {{"mesh":1{middle}{node}}},{{"mesh":2{middle}{node}}}],"meshes":[{},{},{}],"materials":[{},{}],
        "cameras":[{{"type":"orthographic","orthographic":{{"xmag":2,"ymag":1,"znear":0.1,"zfar":100}}}}],"extensionsUsed":["RAYLOOM_scene"],
        "extensions":{{"RAYLOOM_scene":{{"version":1,"root":0,"camera":1,"render":{{"resolution":[4,2],"motionBlur":{{"shutter":0.5,"position":"start"}}}},
        "world":{{"nodes":[{{"type":"background","strength":0.1}}],"surface":0}}}}}}"#,
        mesh(0, ""),
        mesh(1, &vertices),
        mesh(0, &vertices),
        shader(r#"{"type":"diffuse"}"#),
        shader(r#"{"type":"emission","strength":3}"#),
    ));
    let scene = Folder::new().with("x.glb", bytes).scene("x.glb");
    let n_steps = |k: usize| if by_vertices { mesh_steps(&scene, k) } else { scene.objects[k].traits.motion.len() };
    assert_eq!((n_steps(1), n_steps(2)), (3, 3));
    let settings = RenderSettings { integrator: IntegratorKind::Path, samples: 0..64, ..RenderSettings::plain(32, 16) };
    let compiled = compile_scene(&scene, &CompileOptions::default()).expect("a small scene");
    let mut film = Film::new(32, 16);
    CpuBackend::new(1).render(&compiled, &settings, &mut film, &(), &Default::default()).expect("renders");
    film
}

fn mesh_steps(scene: &Scene, k: usize) -> usize {
    mesh(scene, k).motion.len()
}

#[test]
fn moving_vertices_blur_and_shine_as_a_moving_object_does() {
    let (objects, vertices) = (blurred(false), blurred(true));
    let mut sum = 0.0;
    for (a, b) in objects.pixels.iter().zip(&vertices.pixels) {
        for k in 0..3 {
            // The same numbers are drawn; a ray in thousands passes an edge by the last bit on the other side.
            assert!((a[k] - b[k]).abs() <= 0.06 * a[k].max(0.5), "{a:?} {b:?}");
        }
        sum += f64::from((a[0] - b[0]).abs());
    }
    assert!(sum / (32.0 * 16.0) < 2e-3, "mean difference {}", sum / 512.0);
    // It does move: the shining square, in front of the other at the end only, is seen in part over more than its own width.
    let row: Vec<f32> = (0..32).map(|x| vertices.pixels[vertices.index(x, 8)][0]).collect();
    assert!(row.iter().filter(|v| **v > 0.35 && **v < 2.9).count() > 8, "{row:?}");
}
