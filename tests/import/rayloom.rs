//! `RAYLOOM_scene`: what Blender's exporter says and what the scene then holds, in Blender's axes; broken records and their paths.

use crate::files::{Data, Folder, SQUARE, material, mesh, png};
use rayloom::math::{DVec3, Vec3};
use rayloom::scene::environment::{EnvironmentSource, SkyModel};
use rayloom::scene::input::{Channel, NormalInput};
use rayloom::scene::lamp::LampShape;
use rayloom::scene::shader::{Closure, MixFactor, PrincipledClosure};
use rayloom::scene::{Pass, Scene, Shape, Visibility};
use std::f64::consts::PI;

/// The node that turns Blender's axes to glTF's, as the exporter writes it.
const ROOT: &str = r#""rotation":[-0.7071067811865476,0,0,0.7071067811865476]"#;

/// A file whose first node is the root of the others; `extension` are more members of the file's record.
fn file(d: &Data, nodes: &[String], extension: &str, rest: &str) -> Vec<u8> {
    let children: Vec<String> = (1..=nodes.len()).map(|k| k.to_string()).collect();
    let list: String = nodes.iter().map(|n| format!(",{n}")).collect();
    let children = if nodes.is_empty() { String::new() } else { format!(r#","children":[{}]"#, children.join(",")) };
    d.glb(&format!(
        r#","scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{{{ROOT}{children}}}{list}],"extensionsUsed":["RAYLOOM_scene"],
        "extensions":{{"RAYLOOM_scene":{{"version":1,"root":0{extension}}}}}{rest}"#
    ))
}

fn scene(bytes: Vec<u8>) -> Scene {
    Folder::new().with("a.glb", bytes).scene("a.glb")
}

/// A square that wears a material of these nodes.
fn dressed(d: &mut Data, nodes: &str, more: &str, extension: &str, rest: &str) -> Vec<u8> {
    let (p, uv, i) = (d.floats("VEC3", 3, &SQUARE), d.floats("VEC2", 2, &SQUARE[..8]), d.indices(&[0, 1, 2, 0, 2, 3]));
    let mesh = format!(
        r#","meshes":[{{"primitives":[{{"attributes":{{"POSITION":{p},"TEXCOORD_0":{uv},"TEXCOORD_1":{uv}}},"indices":{i},"material":0}}]}}],
        "materials":[{{"name":"M","extensions":{{"RAYLOOM_scene":{{"nodes":[{nodes}]{more}}}}}}}]{rest}"#
    );
    file(d, &[r#"{"mesh":0}"#.into()], extension, &mesh)
}

fn surface(scene: &Scene) -> &Closure {
    material(scene, 0).shader.as_ref().expect("a shader").surface.as_ref().expect("a surface")
}

fn lamp_node(ix: usize) -> String {
    format!(r#"{{"matrix":[2,0,0,0, 0,3,0,0, 0,0,1,0, 1,2,5,1],"extensions":{{"RAYLOOM_scene":{{"light":{ix}}}}}}}"#)
}

#[test]
fn lamps_of_all_kinds_keep_their_watts_and_blenders_axes() {
    let lights = r#","lights":[
        {"type":"point","color":[1,0.5,0],"energy":60,"radius":0.3,"softFalloff":false},
        {"type":"spot","energy":500,"spotSize":1,"spotBlend":0.4,"radius":0.1},
        {"type":"sun","energy":3,"angle":0.02},
        {"type":"area","energy":100,"shape":"rectangle","size":2,"sizeY":0.5,"spread":1,"castShadow":false,"importance":false,"maxBounces":3},
        {"type":"area","energy":100,"shape":"disk","size":2,"normalize":false},
        {"type":"area","energy":100,"portal":true},
        {"type":"point","energy":1,"emission":{"color":[1,0,2],"strength":3}}]"#;
    let s = scene(file(&Data::default(), &(0..7).map(lamp_node).collect::<Vec<_>>(), lights, ""));
    assert_eq!(s.lights.len(), 6, "portals are no lamps");
    let lamps: Vec<_> = s.lights.iter().map(|l| l.lamp.as_deref().expect("a lamp")).collect();
    assert_eq!(lamps[0].power, Vec3::new(60.0, 30.0, 0.0));
    assert_eq!(lamps[0].shape, LampShape::Point { radius: 0.3, soft_falloff: false });
    assert_eq!(lamps[1].shape, LampShape::Spot { radius: 0.1, soft_falloff: true, angle_rad: 1.0, blend: 0.4 });
    assert_eq!(lamps[2].shape, LampShape::Sun { angle_rad: 0.02 });
    assert_eq!(lamps[3].shape, LampShape::Area { ellipse: false, size: [2.0, 0.5], spread_rad: 1.0 });
    assert_eq!((lamps[3].cast_shadow, lamps[3].multiple_importance, lamps[3].max_bounces), (false, false, 3));
    // Not normalised: watts are per square metre of a disc of diameters 4 and 6.
    assert!((f64::from(lamps[4].power.x) - 100.0 * PI / 4.0 * 4.0 * 6.0).abs() < 1e-2, "{}", lamps[4].power.x);
    assert_eq!(lamps[5].power, Vec3::new(3.0, 0.0, 6.0));
    // z up: the root's turn is left out.
    assert_eq!(lamps[0].transform.point(DVec3::ZERO), DVec3::new(1.0, 2.0, 5.0));
    assert!(!lamps[0].visibility.has(Visibility::CAMERA) && lamps[0].visibility.has(Visibility::GLOSSY));
    // The likeness of a point lamp: candela.
    assert!((f64::from(s.lights[0].color.x) - 60.0 / (4.0 * PI)).abs() < 1e-5);
}

fn camera(record: &str) -> rayloom::scene::Camera {
    let node = r#"{"camera":0,"matrix":[1,0,0,0, 0,0,1,0, 0,-1,0,0, 0,-4,1,1]}"#;
    let cameras = format!(
        r#","cameras":[{{"type":"perspective","perspective":{{"yfov":1,"znear":0.1}},"extensions":{{"RAYLOOM_scene":{record}}}}}]"#
    );
    scene(file(&Data::default(), &[node.into()], r#","camera":1"#, &cameras)).camera
}

#[test]
fn cameras_fit_shift_and_focus_as_blenders() {
    // The pictures of these tests are twice as wide as high.
    let c = camera(r#"{"lens":50,"sensorWidth":36,"shift":[0.25,0.5],"dof":{"focusDistance":6.1,"fStop":0.4,"blades":6}}"#);
    let near = |a: DVec3, b: DVec3| assert!((a - b).length() < 1e-9, "{a} is not {b}");
    near(c.right, DVec3::X * 0.72);
    near(c.up, DVec3::Z * 0.36);
    // Looks along +y; the shift is in widths.
    near(c.direction, DVec3::new(0.25 * 0.72, 1.0, 0.5 * 0.72));
    let lens = c.lens.expect("a lens");
    assert!((lens.radius - 0.05 / 0.8).abs() < 1e-12 && lens.focus_distance == 6.1 && lens.blades == 6);
    near(camera(r#"{"lens":50,"sensorHeight":24,"sensorFit":"vertical"}"#).up, DVec3::Z * 0.48);
    near(camera(r#"{"lens":50,"sensorFit":"horizontal"}"#).right, DVec3::X * 0.72);
    let o = camera(r#"{"type":"orthographic","orthoScale":8,"shift":[0.5,0]}"#);
    near(o.right, DVec3::X * 8.0);
    near(o.location, DVec3::new(4.0, -4.0, 1.0));
}

#[test]
fn principled_sockets_arrive_and_absent_ones_are_blenders() {
    let s = scene(dressed(
        &mut Data::default(),
        r#"{"type":"principled","baseColor":[0.1,0.2,0.3],"roughness":0.25,"coatWeight":0.5,"thinFilmThickness":400,"subsurfaceRadius":[1,2,3]}"#,
        r#","surface":0,"passIndex":7,"emissionSampling":"front""#,
        "",
        "",
    ));
    let Closure::Principled(p) = surface(&s) else { panic!("{:?}", surface(&s)) };
    let wanted = PrincipledClosure {
        base_color: Vec3::new(0.1, 0.2, 0.3).into(),
        roughness: 0.25.into(),
        coat_weight: 0.5.into(),
        thin_film_thickness: 400.0.into(),
        subsurface_radius: Vec3::new(1.0, 2.0, 3.0).into(),
        ..PrincipledClosure::default()
    };
    assert_eq!(**p, wanted);
    let shader = material(&s, 0).shader.as_ref().expect("a shader");
    assert_eq!((shader.material_id, shader.name.as_str(), shader.transparent_shadow), (7, "M", true));
    // The likeness for the classic integrator.
    assert_eq!((material(&s, 0).base_color, material(&s, 0).roughness), (Vec3::new(0.1, 0.2, 0.3), 0.25));
    assert_eq!(mesh(&s, 0).more_uvs.len(), 1);
}

#[test]
fn pictures_give_colours_channels_lines_and_normals() {
    let mut d = Data::default();
    let picture = d.add(&png(2, 2, |x, y| [x as u8 * 255, y as u8 * 255, 0, 128]), 5121, "SCALAR", 1, "");
    let nodes = r#"{"type":"image","image":0,"coordinates":{"source":"uv","uvSet":1,"affine":[2,0,0,0.5, 0,3,0,0, 0,0,1,0]},"extension":"clip"},
        {"type":"image","image":1,"interpolation":"closest"},
        {"type":"separate","color":{"node":1,"output":"color"}},
        {"type":"math","operation":"subtract","a":1,"b":{"node":2,"output":"z"}},
        {"type":"math","operation":"multiply_add","a":{"node":3},"b":0.5,"c":0.25},
        {"type":"normalMap","color":{"node":1,"output":"color"},"strength":0.7},
        {"type":"mixColor","blend":"multiply","factor":1,"a":[0.5,1,1],"b":{"node":0,"output":"color"}},
        {"type":"principled","baseColor":{"node":6},"alpha":{"node":0,"output":"alpha"},"roughness":{"node":4},"metallic":{"node":2,"output":"y"},
         "normal":{"node":5}},
        {"type":"transparent","color":1},
        {"type":"fresnel","ior":1.4},
        {"type":"mix","factor":{"node":9,"output":"value"},"a":7,"b":8}"#;
    let images = r#","images":[{"source":0,"colorSpace":"srgb"},{"source":0,"colorSpace":"nonColor"}]"#;
    let rest = format!(r#","images":[{{"bufferView":{picture},"mimeType":"image/png"}}]"#);
    let s = scene(dressed(&mut d, nodes, r#","surface":10"#, images, &rest));
    let Closure::Mix { factor: MixFactor::Fresnel(ior), a, b } = surface(&s) else { panic!("{:?}", surface(&s)) };
    assert_eq!(ior.as_constant(), Some(1.4));
    assert!(matches!(**b, Closure::Transparent { .. }));
    let Closure::Principled(p) = &**a else { panic!("{a:?}") };
    let base = p.base_color.picture.as_ref().expect("a picture");
    // Two sets are used: each keeps its number.
    assert_eq!((p.base_color.factor, base.uv_set, base.texture.srgb, base.filter_encoded), (Vec3::new(0.5, 1.0, 1.0), 1, true, true));
    // v runs up there and down here.
    assert_eq!(base.texture.uv_transform, [[2.0, 0.0, 0.5], [0.0, 3.0, -2.0]]);
    // 0.5 (1 - blue) + 0.25.
    assert_eq!((p.roughness.factor, p.roughness.offset), (-0.5, 0.75));
    let channel = |s: &rayloom::scene::input::Scalar| s.picture.as_ref().map(|(p, c)| (p.texture.srgb, *c));
    assert_eq!(channel(&p.roughness), Some((false, Channel::Blue)));
    assert_eq!(channel(&p.metallic), Some((false, Channel::Green)));
    assert_eq!(channel(&p.alpha), Some((true, Channel::Alpha)));
    let Some(NormalInput::Map { picture, strength, scale_xy: false }) = p.normal.as_deref() else { panic!("{:?}", p.normal) };
    assert!(!picture.texture.linear && strength.as_constant() == Some(0.7));
}

#[test]
fn worlds_are_colours_pictures_and_skies() {
    let world = |nodes: &str, k: usize| {
        let mut d = Data::default();
        let picture = d.add(&png(2, 1, |x, _| [x as u8 * 255, 0, 0, 255]), 5121, "SCALAR", 1, "");
        let rest = format!(r#","images":[{{"bufferView":{picture},"mimeType":"image/png"}}]"#);
        let images = r#","images":[{"source":0,"colorSpace":"srgb"}]"#;
        let extension = format!(r#"{images},"world":{{"nodes":[{nodes}],"surface":{k},"visibility":{{"camera":false}}}}"#);
        scene(file(&d, &[], &extension, &rest)).environment.expect("an environment")
    };
    let plain = world(r#"{"type":"background","color":[0.5,1,2],"strength":0.5}"#, 0);
    assert_eq!((plain.source, plain.strength), (EnvironmentSource::Constant, Vec3::new(0.25, 0.5, 1.0)));
    assert_eq!(plain.visibility, Visibility::ALL.without(Visibility::CAMERA));
    // A quarter turn about z: +x of the world is +y of the picture.
    let turned = r#"{"type":"environment","image":0,"coordinates":{"source":"position","affine":[0,-1,0,0, 1,0,0,0, 0,0,1,0]}},
        {"type":"background","color":{"node":0,"output":"color"},"strength":2}"#;
    let picture = world(turned, 1);
    let EnvironmentSource::Equirect { image, linear: true } = &picture.source else { panic!("{:?}", picture.source) };
    assert_eq!(image.texels, [Vec3::ZERO, Vec3::X]);
    assert!((picture.rotation * DVec3::X - DVec3::Y).length() < 1e-9, "{}", picture.rotation);
    let sky = world(
        r#"{"type":"sky","model":"nishita","sunElevation":0.5,"sunDisc":false},{"type":"background","color":{"node":0},"strength":1}"#,
        1,
    );
    let EnvironmentSource::Sky(sky) = &sky.source else { panic!("{:?}", sky.source) };
    assert!(sky.sun_elevation_rad == 0.5 && !sky.sun_disc && sky.model == SkyModel::Nishita);
    for (model, want) in [("singleScattering", SkyModel::Single), ("multipleScattering", SkyModel::Multiple)] {
        let nodes = format!(r#"{{"type":"sky","model":"{model}"}},{{"type":"background","color":{{"node":0}},"strength":1}}"#);
        let EnvironmentSource::Sky(sky) = world(&nodes, 1).source else { panic!("no sky") };
        assert_eq!(sky.model, want);
    }
    // Without a world it is black, and no lamp is added.
    let none = scene(file(&Data::default(), &[], "", ""));
    assert_eq!(none.environment.expect("an environment").strength, Vec3::ZERO);
    assert!(none.lights.is_empty());
}

#[test]
fn hair_grids_motion_and_switches_arrive() {
    let mut d = Data::default();
    let points = d.floats("VEC3", 3, &[0., 0., 0., 0., 0., 1., 0., 0., 2., 1., 0., 0., 1., 1., 0.]);
    let radii = d.floats("SCALAR", 1, &[0.1, 0.05, 0.0, 0.2, 0.1]);
    let offsets = d.indices(&[0, 3, 5]);
    let at = |x: f32| [1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., x, 0., 0., 1.];
    let keys = d.floats("MAT4", 16, &[at(-1.0), at(0.0), at(1.0)].concat());
    let cells: Vec<u8> = (0..8).flat_map(|v| (v as f32).to_le_bytes()).collect();
    let grid = d.add(&cells, 5126, "SCALAR", 8, "");
    let square = d.floats("VEC3", 3, &SQUARE);
    let moved = d.floats("VEC3", 3, &SQUARE.map(|v| v + 1.0));
    let nodes = [
        r#"{"name":"Fur","extensions":{"RAYLOOM_scene":{"curves":0}}}"#.into(),
        format!(
            r#"{{"name":"Box","mesh":0,"extensions":{{"RAYLOOM_scene":{{"visibility":{{"shadow":false}},"holdout":true,"passIndex":3,"objectName":"Box","assetName":"Shelf",
            "motion":{{"times":[-0.25,0,0.25],"matrices":{keys}}}}}}}}}"#
        ),
    ];
    let extension = format!(
        r#","render":{{"resolution":[8,4],"samples":7,"passes":["depth","glossyDirect","glint"],"seed":3,"clampIndirect":0,"motionBlur":{{"shutter":0.5}},"hair":{{"shape":"thick"}},
        "bounces":{{"total":5,"diffuse":1}},"filter":{{"type":"gaussian","width":2}}}},
        "curves":[{{"points":{points},"radii":{radii},"offsets":{offsets},"material":0}}],
        "grids":[{{"bufferView":{grid},"resolution":[2,2,2],"affine":[4,0,0,-2, 0,4,0,-2, 0,0,4,-2]}}]"#
    );
    let rest = format!(
        r#","meshes":[{{"primitives":[{{"attributes":{{"POSITION":{square}}},"mode":6,"material":0,
        "extensions":{{"RAYLOOM_scene":{{"motion":{{"times":[-0.25,0,0.25],"positions":[{square},{square},{moved}]}}}}}}}}]}}],
        "materials":[{{"extensions":{{"RAYLOOM_scene":{{"nodes":[{{"type":"grid","grid":0}},
        {{"type":"principledVolume","density":{{"node":0}},"anisotropy":0.3}}],"volume":1}}}}}}]"#
    );
    let s = scene(file(&d, &nodes, &extension, &rest));
    let Shape::Curves(c) = &s.objects[0].shape else { panic!("{:?}", s.objects[0].shape) };
    assert_eq!((c.starts.as_slice(), c.radii[3], c.points[2]), (&[0, 3, 5][..], 0.2, Vec3::new(0.0, 0.0, 2.0)));
    let traits = &s.objects[1].traits;
    assert_eq!((traits.visibility, traits.holdout, traits.object_id), (Visibility::ALL.without(Visibility::SHADOW), true, 3));
    assert_eq!((&*traits.name, &*traits.asset, traits.motion.len()), ("Box", "Shelf", 3));
    assert_eq!(traits.motion[2].point(DVec3::ZERO), DVec3::X);
    let passes: Vec<Pass> = s.settings.path.passes.iter().collect();
    assert_eq!(passes, [Pass::Depth, Pass::GlossyDirect, Pass::GlossyColor], "unknown passes are left out");
    assert_eq!(mesh(&s, 1).motion[2].vertices[0], Vec3::from_slice(&SQUARE[..3]) + 1.0);
    let shader = material(&s, 1).shader.as_ref().expect("a shader");
    assert!(shader.surface.is_none(), "a hull of a volume has no surface");
    let density = shader.volume.as_ref().expect("a volume").density.as_ref().expect("a grid");
    assert_eq!((density.grid.size, density.grid.cells[7]), ([2; 3], 7.0));
    assert_eq!(density.transform.point(DVec3::ONE), DVec3::splat(2.0));
    let p = &s.settings.path;
    assert_eq!((p.samples, p.seed, p.max_bounces, p.diffuse_bounces, p.glossy_bounces, p.clamp_indirect), (7, 3, 5, 1, 4, 0.0));
}

/// Parts of the error of a file whose record has these members.
fn refused(extension: &str, nodes: &[String], rest: &str, parts: &[&str]) {
    let error = Folder::new().with("x.glb", file(&Data::default(), nodes, extension, rest)).error("x.glb");
    assert!(parts.iter().all(|p| error.contains(p)), "'{error}' does not say {parts:?}");
}

#[test]
fn broken_records_are_told_with_their_path() {
    let at = "extensions.RAYLOOM_scene";
    refused(r#","render":{"samples":"many"}"#, &[], "", &[at, "render.samples", "'many'"]);
    refused(r#","render":{"sample":3}"#, &[], "", &["render.sample:", "unknown"]);
    refused(r#","render":{"bounces":{"total":-1}}"#, &[], "", &["render.bounces.total", "-1"]);
    refused(r#","render":{"filter":{"type":"tent"}}"#, &[], "", &["render.filter.type", "tent", "gaussian"]);
    refused(r#","world":{"surface":0}"#, &[], "", &["world.surface", "shader node 0", "there are 0"]);
    refused(r#","camera":9"#, &[], "", &["camera", "node 9"]);
    refused(r#","lights":{}"#, &[], "", &["lights", "list"]);
    refused(r#","lights":[{"type":"lava"}]"#, &[lamp_node(0)], "", &["lights[0].type", "lava"]);
    refused(r#","lights":[{"type":"area","size":[1]}]"#, &[lamp_node(0)], "", &["lights[0].size", "a list of 1"]);
    refused("", &[lamp_node(4)], "", &["nodes[1].extensions.RAYLOOM_scene.light", "light 4"]);
    let material = |nodes: &str| format!(r#","materials":[{{"extensions":{{"RAYLOOM_scene":{{"nodes":[{nodes}],"surface":0}}}}}}]"#);
    let m = "materials[0].extensions.RAYLOOM_scene.nodes[0]";
    refused("", &[], &material(r#"{"type":"diffuse","color":[1,2]}"#), &[m, "color", "a list of 2"]);
    refused("", &[], &material(r#"{"type":"diffuse","color":[1,"x",2]}"#), &["color[1]", "'x'"]);
    refused("", &[], &material(r#"{"type":"diffuse","color":{"node":0}}"#), &[m, "color", "does not stand before"]);
    refused("", &[], &material(r#"{"color":1}"#), &[m, "type", "missing"]);
    refused(
        r#","curves":[{"points":0}]"#,
        &[r#"{"extensions":{"RAYLOOM_scene":{"curves":0}}}"#.into()],
        "",
        &["curves[0].points", "accessor 0"],
    );
    let version = Folder::new().with("x.glb", Data::default().glb(r#","extensions":{"RAYLOOM_scene":{"version":2,"root":0}}"#));
    assert!(version.error("x.glb").contains("version 1 is read"));
}

#[test]
fn closures_that_multiply_end_with_an_error() {
    let mut nodes = r#"{"type":"diffuse"}"#.to_owned();
    for k in 0..60 {
        nodes += &format!(r#",{{"type":"add","a":{k},"b":{k}}}"#);
    }
    let rest = format!(r#","materials":[{{"extensions":{{"RAYLOOM_scene":{{"nodes":[{nodes}],"surface":60}}}}}}]"#);
    refused("", &[], &rest, &["materials[0]", "more than 4096 closures"]);
}

#[test]
fn the_extension_may_be_required_and_others_may_not() {
    let with = |name: &str| Data::default().glb(&format!(r#","nodes":[{{}}],"extensionsRequired":["{name}"]"#));
    assert!(Folder::new().with("a.glb", with("RAYLOOM_scene")).load("a.glb").0.is_ok());
    assert!(Folder::new().with("a.glb", with("KHR_draco_mesh_compression")).error("a.glb").contains("KHR_draco_mesh_compression"));
}

#[test]
fn instances_share_what_their_node_says_and_move_each_for_itself() {
    let mut d = Data::default();
    let (p, i) = (d.floats("VEC3", 3, &SQUARE), d.indices(&[0, 1, 2, 0, 2, 3]));
    let places = d.floats("VEC3", 3, &[1., 0., 0., 0., 2., 0.]);
    let moved = |x: f32, y: f32| [1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., x, y, 0., 1.];
    let keys: Vec<f32> = [moved(0.5, 0.0), moved(1.5, 0.0), moved(0.0, 2.0), moved(0.0, 2.5)].concat();
    let (all, few) = (d.floats("MAT4", 16, &keys), d.floats("MAT4", 16, &keys[..32]));
    let of = |matrices: usize| {
        let node = format!(
            r#"{{"mesh":0,"name":"Leaf","extensions":{{"EXT_mesh_gpu_instancing":{{"attributes":{{"TRANSLATION":{places},"_RANDOM":{p}}}}},
            "RAYLOOM_scene":{{"passIndex":7,"visibility":{{"camera":false}},"motion":{{"times":[-0.25,0.25],"matrices":{matrices}}}}}}}}}"#
        );
        let meshes = format!(r#","meshes":[{{"primitives":[{{"attributes":{{"POSITION":{p}}},"indices":{i}}}]}}]"#);
        file(&d, &[node], r#","render":{"resolution":[4,2],"motionBlur":{"shutter":0.5}}"#, &meshes)
    };
    let f = Folder::new().with("a.glb", of(all)).with("few.glb", of(few));
    let (s, said) = f.load("a.glb");
    let s = s.expect("loads");
    assert!(!said.iter().any(|m| m.contains("_RANDOM")), "the exporter's own attribute is not told: {said:?}");
    assert_eq!(s.objects.len(), 2);
    for o in &s.objects {
        assert_eq!((o.traits.object_id, &*o.traits.name, o.traits.motion.len()), (7, "Leaf", 2));
        assert!(!o.traits.visibility.has(Visibility::CAMERA));
    }
    assert_eq!(s.objects[0].traits.motion[1].point(DVec3::ZERO), DVec3::new(1.5, 0.0, 0.0));
    assert_eq!(s.objects[1].traits.motion[1].point(DVec3::ZERO), DVec3::new(0.0, 2.5, 0.0));
    assert!(f.error("few.glb").contains("2 matrices for 2 times of 2 instances"), "{}", f.error("few.glb"));
}
