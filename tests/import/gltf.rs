//! What glTF says and what the scene then holds.

use crate::files::{Data, Folder, SQUARE, material, mesh, png};
use rayloom::diag::Sink;
use rayloom::import::{ImportOptions, load};
use rayloom::math::{DVec3, Vec3};
use rayloom::memory::MemoryLimit;
use rayloom::scene::material::{AlphaMode, Texels, Wrap};
use rayloom::scene::{Projection, light::Fade, light::LightKind};
use std::sync::Arc;

fn near(a: DVec3, b: DVec3) {
    assert!((a - b).length() < 1e-6, "{a}, not {b}");
}

/// A square shown by these nodes.
fn square(nodes: &str, more: &str) -> Vec<u8> {
    let mut d = Data::default();
    let (p, i) = (d.floats("VEC3", 3, &SQUARE), d.indices(&[0, 1, 2, 0, 2, 3]));
    d.glb(&format!(r#","meshes":[{{"primitives":[{{"attributes":{{"POSITION":{p}}},"indices":{i}}}]}}],"nodes":[{nodes}]{more}"#))
}

#[test]
fn nodes_nest_by_matrix_and_by_trs_and_share_their_mesh() {
    let nodes = r#"{"mesh":0,"children":[1]},
        {"translation":[0,0,5],"rotation":[0,0,0.70710678,0.70710678],"scale":[2,1,1],"children":[2]},
        {"mesh":0,"matrix":[1,0,0,0, 0,1,0,0, 0,0,1,0, 3,0,0,1]}"#;
    let f = Folder::new().with("a.glb", square(nodes, ""));
    let s = f.scene("a.glb");
    assert_eq!(s.objects.len(), 2);
    assert!(Arc::ptr_eq(mesh(&s, 0), mesh(&s, 1)), "instances share their mesh");
    assert!(s.objects[0].transform.is_identity());
    // (1, 0, 0): +3 along x, doubled, turned to y, moved along z.
    near(s.objects[1].transform.point(DVec3::X), DVec3::new(0.0, 8.0, 5.0));
}

#[test]
fn only_the_default_scene_is_shown_and_without_scenes_every_root() {
    let nodes = r#"{"mesh":0},{"mesh":0,"children":[2]},{"mesh":0}"#;
    let f = Folder::new()
        .with("all.glb", square(nodes, ""))
        .with("one.glb", square(nodes, r#","scenes":[{"nodes":[1]},{"nodes":[0]}],"scene":1"#));
    assert_eq!(f.scene("all.glb").objects.len(), 3);
    assert_eq!(f.scene("one.glb").objects.len(), 1);
}

#[test]
fn strips_and_fans_keep_their_winding_and_points_are_told_once() {
    let mut d = Data::default();
    let p = d.floats("VEC3", 3, &[0., 0., 0., 1., 0., 0., 0., 1., 0., 1., 1., 0.]);
    let fan = d.floats("VEC3", 3, &SQUARE);
    let primitives = format!(
        r#"{{"attributes":{{"POSITION":{p}}},"mode":5}},{{"attributes":{{"POSITION":{fan}}},"mode":6}},
           {{"attributes":{{"POSITION":{p}}},"mode":0}},{{"attributes":{{"POSITION":{p}}},"mode":1}}"#
    );
    let f = Folder::new().with("a.glb", d.glb(&format!(r#","meshes":[{{"primitives":[{primitives}]}}],"nodes":[{{"mesh":0}}]"#)));
    let (scene, said) = f.load("a.glb");
    let scene = scene.expect("loads");
    assert_eq!(said.iter().filter(|m| m.contains("points and lines")).count(), 1, "{said:?}");
    assert_eq!(scene.objects.len(), 2);
    for k in 0..2 {
        let m = mesh(&scene, k);
        assert_eq!(m.faces.len(), 2);
        for f in &m.faces {
            let [a, b, c] = f.map(|k| m.vertices[k as usize]);
            assert!((b - a).cross(c - a).z > 0.0, "{f:?} is turned over");
        }
    }
}

#[test]
fn integers_strides_and_sparse_values_are_decoded() {
    let mut d = Data::default();
    // Interleaved positions: 12 bytes of floats, 4 of nothing.
    let mut bytes = Vec::new();
    for v in SQUARE.chunks(3) {
        v.iter().for_each(|c| bytes.extend(c.to_le_bytes()));
        bytes.extend([0xFF; 4]);
    }
    let base = d.add(&bytes, 5126, "VEC3", 4, "");
    let ix = d.add(&[2, 0, 0, 0], 5121, "SCALAR", 1, "");
    let value = d.floats("VEC3", 3, &[7., 8., 9.]);
    assert_eq!((base, ix, value), (0, 1, 2));
    let sparse = d.add_bare(
        r#"{"bufferView":0,"componentType":5126,"type":"VEC3","count":4,
            "sparse":{"count":1,"indices":{"bufferView":1,"componentType":5121},"values":{"bufferView":2}}}"#,
    );
    let normals = d.add(&[0, 0, 127, 0, 0, 0, 127, 0, 0, 0, 127, 0, 0, 0, 127], 5120, "VEC3", 4, r#","normalized":true"#);
    let uvs = d.add(&[0, 255, 255, 255, 255, 0, 0, 0], 5121, "VEC2", 4, r#","normalized":true"#);
    let colors = d.add(&[255, 0, 51, 0].repeat(4), 5121, "VEC3", 4, r#","normalized":true"#);
    let json = d.json(
        &format!(r#"{{"byteLength":{}}}"#, d.bytes.len()),
        &format!(
            r#","meshes":[{{"primitives":[{{"attributes":{{"POSITION":{sparse},"TEXCOORD_0":{uvs},"COLOR_0":{colors}}},"mode":6}}]}}],
               "nodes":[{{"mesh":0}}]"#
        ),
    );
    let strided = json.replacen(r#""byteOffset":0,"#, r#""byteOffset":0,"byteStride":16,"#, 1);
    let with_normals = strided.replace(r#""COLOR_0""#, &format!(r#""NORMAL":{normals},"COLOR_0""#));
    let f = Folder::new().with("a.glb", crate::files::glb(&strided, &d.bytes)).with("n.glb", crate::files::glb(&with_normals, &d.bytes));
    let s = f.scene("a.glb");
    let m = mesh(&s, 0);
    assert_eq!(m.vertices[..3], [Vec3::ZERO, Vec3::X, Vec3::new(7.0, 8.0, 9.0)]);
    assert_eq!(m.uvs, [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]]);
    assert_eq!(m.colors[0], [1.0, 0.0, 0.2, 1.0]);
    assert!(m.normal_indices.is_empty(), "no normals: flat");
    // Four normals of three bytes each, tightly packed.
    assert_eq!(mesh(&f.scene("n.glb"), 0).normals[0], Vec3::Z);
}

#[test]
fn a_primitive_takes_only_its_part_of_a_shared_accessor() {
    let mut d = Data::default();
    let many: Vec<f32> = (0..300).flat_map(|k| [k as f32, (k % 2) as f32, 0.0]).collect();
    let (p, i) = (d.floats("VEC3", 3, &many), d.indices(&[7, 200, 9]));
    let f = Folder::new().with(
        "a.glb",
        d.glb(&format!(r#","meshes":[{{"primitives":[{{"attributes":{{"POSITION":{p}}},"indices":{i}}}]}}],"nodes":[{{"mesh":0}}]"#)),
    );
    let s = f.scene("a.glb");
    assert_eq!(mesh(&s, 0).vertices, [Vec3::new(7.0, 1.0, 0.0), Vec3::new(9.0, 1.0, 0.0), Vec3::new(200.0, 0.0, 0.0)]);
    assert_eq!(mesh(&s, 0).faces, [[0, 2, 1]]);
}

#[test]
fn materials_and_their_extensions_reach_the_scene() {
    let more = r#","extensionsUsed":["KHR_animation_pointer"],"materials":[{
        "pbrMetallicRoughness":{"baseColorFactor":[0.1,0.2,0.3,0.4],"metallicFactor":0.5,"roughnessFactor":0.25},
        "emissiveFactor":[1,0.5,0],"alphaMode":"MASK","alphaCutoff":0.3,"doubleSided":true,
        "extensions":{"KHR_materials_emissive_strength":{"emissiveStrength":4},"KHR_materials_ior":{"ior":1.33},
            "KHR_materials_transmission":{"transmissionFactor":0.75},
            "KHR_materials_specular":{"specularFactor":0.5,"specularColorFactor":[1,0,0]},
            "KHR_materials_volume":{"attenuationDistance":2,"attenuationColor":[0.5,1,1]}}}]"#;
    let mut d = Data::default();
    let (p, i) = (d.floats("VEC3", 3, &SQUARE), d.indices(&[0, 1, 2, 0, 2, 3]));
    let mesh =
        format!(r#","meshes":[{{"primitives":[{{"attributes":{{"POSITION":{p}}},"indices":{i},"material":0}}]}}],"nodes":[{{"mesh":0}}]"#);
    let f = Folder::new().with("a.glb", d.glb(&(mesh + more)));
    let (scene, said) = f.load("a.glb");
    let scene = scene.expect("loads");
    let m = material(&scene, 0);
    assert_eq!((m.base_color, m.alpha, m.alpha_mode), (Vec3::new(0.1, 0.2, 0.3), 0.4, AlphaMode::Mask(0.3)));
    assert_eq!((m.metallic, m.roughness, m.ior, m.transmission), (0.5, 0.25, 1.33, 0.75));
    assert_eq!((m.emission, m.specular, m.specular_color), (Vec3::new(4.0, 2.0, 0.0), 0.5, Vec3::X));
    assert!(said.iter().any(|s| s.contains("KHR_animation_pointer")), "{said:?}");
    let interior = scene.objects[0].interior.as_ref().expect("glass has an inside");
    assert!((interior.ior - 1.33).abs() < 1e-6);
    // Half of the red is left after the attenuation distance.
    assert!((f64::from(1.0 - interior.fade_color.x) - 2f64.ln()).abs() < 1e-6 && interior.fade_distance == 2.0);
}

#[test]
fn textures_come_with_sampler_transform_and_encoding() {
    let picture = png(2, 2, |x, y| [255 * x as u8, 255 * y as u8, 0, 255]);
    let mut d = Data::default();
    let (p, uv) = (d.floats("VEC3", 3, &SQUARE), d.floats("VEC2", 2, &[0., 0., 1., 0., 1., 1., 0., 1.]));
    let embedded = d.add(&picture, 5121, "SCALAR", picture.len(), "");
    let rest = format!(
        r#","meshes":[{{"primitives":[{{"attributes":{{"POSITION":{p},"TEXCOORD_0":{uv}}},"mode":6,"material":0}}]}}],"nodes":[{{"mesh":0}}],
        "images":[{{"bufferView":{embedded},"mimeType":"image/png"}},{{"uri":"my%20normal.png"}},{{"uri":"gone.png"}}],
        "samplers":[{{"wrapS":33071,"wrapT":33648,"magFilter":9728}}],
        "textures":[{{"source":0,"sampler":0}},{{"source":1}},{{"source":2}}],
        "materials":[{{"pbrMetallicRoughness":{{"baseColorTexture":{{"index":0,
            "extensions":{{"KHR_texture_transform":{{"offset":[0.5,0.25],"rotation":1.5707964,"scale":[2,3]}}}}}}}},
            "normalTexture":{{"index":1,"scale":0.5}},"emissiveTexture":{{"index":2}}}}]"#
    );
    let f = Folder::new().with("a.glb", d.glb(&rest)).with("my normal.png", &picture);
    let (scene, said) = f.load("a.glb");
    let scene = scene.expect("loads");
    let m = material(&scene, 0);
    let base = m.base_color_texture.as_ref().expect("a texture");
    assert_eq!((base.wrap, base.linear, base.srgb), ([Wrap::Clamp, Wrap::Mirror], false, true));
    assert_eq!(base.image.texels, Texels::Rgba8(vec![[0, 0, 0, 255], [255, 0, 0, 255], [0, 255, 0, 255], [255, 255, 0, 255]]));
    // Counterclockwise on the picture, whose v runs down: (1, 0) turns to the top.
    let t = base.uv_transform;
    assert!((t[0][0]).abs() < 1e-6 && (t[1][0] + 2.0).abs() < 1e-6 && (t[0][1] - 3.0).abs() < 1e-6, "{t:?}");
    assert_eq!([t[0][2], t[1][2]], [0.5, 0.25]);
    let normal = m.normal_texture.as_ref().expect("a picture from a file with a space in its name");
    assert_eq!((normal.srgb, normal.wrap, m.normal_scale), (false, [Wrap::Repeat; 2], 0.5));
    assert!(m.emission_texture.is_none() && said.iter().any(|s| s.contains("gone.png")), "{said:?}");
}

#[test]
fn buffers_are_read_from_data_uris_and_from_files() {
    let mut d = Data::default();
    let p = d.floats("VEC3", 3, &SQUARE[..9]);
    let rest = format!(r#","meshes":[{{"primitives":[{{"attributes":{{"POSITION":{p}}}}}]}}],"nodes":[{{"mesh":0}}]"#);
    let code = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let base64: String = d
        .bytes
        .chunks(3)
        .flat_map(|c| {
            let n = c.iter().fold(0u32, |n, b| (n << 8) | u32::from(*b));
            [18, 12, 6, 0].map(|s| code[(n >> s) as usize & 63] as char)
        })
        .collect();
    let f = Folder::new()
        .with("data.gltf", d.json(&format!(r#"{{"byteLength":36,"uri":"data:application/octet-stream;base64,{base64}"}}"#), &rest))
        .with("file.gltf", d.json(r#"{"byteLength":36,"uri":"b.bin"}"#, &rest))
        .with("b.bin", &d.bytes);
    for name in ["data.gltf", "file.gltf"] {
        assert_eq!(mesh(&f.scene(name), 0).vertices, [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0)]);
    }
}

#[test]
fn cameras_look_along_minus_z_unmirrored_and_keep_what_the_file_frames() {
    let cameras = r#","cameras":[{"type":"perspective","perspective":{"yfov":1.5707963,"aspectRatio":4,"znear":0.1}},
        {"type":"orthographic","orthographic":{"xmag":3,"ymag":2,"znear":0.1,"zfar":9}}]"#;
    let f = Folder::new()
        .with("p.glb", square(r#"{"mesh":0},{"camera":0,"translation":[1,2,3],"scale":[5,5,5]}"#, cameras))
        .with("o.glb", square(r#"{"mesh":0},{"camera":1,"rotation":[0,0.70710678,0,0.70710678]}"#, cameras));
    let c = f.scene("p.glb").camera;
    near(c.location, DVec3::new(1.0, 2.0, 3.0));
    near(c.direction, DVec3::NEG_Z);
    // The file's picture is 4 : 1, ours 2 : 1: the width stays.
    near(c.right, 8.0 * DVec3::X);
    near(c.up, 4.0 * DVec3::Y);
    let c = f.scene("o.glb").camera;
    assert!(matches!(c.projection, Projection::Orthographic));
    near(c.direction, DVec3::NEG_X);
    // The file's is 3 : 2, ours 2 : 1: the height stays.
    near(c.right, 8.0 * DVec3::NEG_Z);
    near(c.up, 4.0 * DVec3::Y);
}

#[test]
fn lamps_of_blender_come_back_as_watts_and_others_stay_candela() {
    let lamps = r#","extensions":{"KHR_lights_punctual":{"lights":[
        {"type":"point","color":[1,0.5,0],"intensity":3261.0848},
        {"type":"spot","intensity":683,"spot":{"innerConeAngle":0.2,"outerConeAngle":0.4}},
        {"type":"directional","intensity":1366}]}}"#;
    let node = |k: usize| format!(r#"{{"translation":[0,{k},0],"extensions":{{"KHR_lights_punctual":{{"light":{k}}}}}}}"#);
    let bytes = |generator: &str| {
        let text = square(&format!(r#"{{"mesh":0}},{},{},{}"#, node(0), node(1), node(2)), lamps);
        let json_end = 20 + u32::from_le_bytes([text[12], text[13], text[14], text[15]]) as usize;
        let json = String::from_utf8_lossy(&text[20..json_end]).replacen(
            r#""version":"2.0""#,
            &format!(r#""version":"2.0","generator":"{generator}""#),
            1,
        );
        crate::files::glb(&json, &text[json_end + 8..])
    };
    let f = Folder::new().with("b.glb", bytes("Khronos glTF Blender I/O v4.5.51")).with("o.glb", bytes("by hand"));
    let s = f.scene("b.glb");
    let [point, spot, sun] = &s.lights[..] else { panic!("three lamps") };
    // 60 W: 60 / 4 pi watts into a steradian.
    assert!((f64::from(point.color.x) - 60.0 / (4.0 * std::f64::consts::PI)).abs() < 1e-4, "{}", point.color);
    assert!((point.color.y / point.color.x - 0.5).abs() < 1e-6 && point.fade == Fade::InverseSquare);
    let LightKind::Spot { radius_rad, falloff_rad, .. } = spot.kind else { panic!("a spot") };
    // blend 0.5 reaches over half of 1 - cos.
    assert!((radius_rad.cos() - 0.5 * (1.0 + 0.4f32.cos() as f64)).abs() < 1e-6 && (falloff_rad - 0.4).abs() < 1e-6);
    near(spot.point_at, DVec3::new(0.0, 1.0, -1.0));
    assert_eq!(sun.kind, LightKind::Sun { direction: DVec3::NEG_Z, angle_rad: 0.0 });
    assert!((sun.color.x - 2.0).abs() < 1e-6 && sun.fade == Fade::None);
    let s = f.scene("o.glb");
    assert!((s.lights[1].color.x - 683.0).abs() < 1e-3);
    let LightKind::Spot { radius_rad, .. } = s.lights[1].kind else { panic!("a spot") };
    assert!((radius_rad - 0.2).abs() < 1e-6);
}

#[test]
fn a_file_without_camera_and_light_gets_both_and_says_so() {
    let f = Folder::new().with("a.glb", square(r#"{"mesh":0}"#, ""));
    let (scene, said) = f.load("a.glb");
    let scene = scene.expect("loads");
    assert!(said.iter().any(|s| s.contains("no camera")) && said.iter().any(|s| s.contains("lit from")), "{said:?}");
    assert!(!scene.lights.is_empty() && scene.background.rgb.x > 0.0);
    assert!(said.iter().any(|s| s.contains("plain grey")) && material(&scene, 0).base_color == Vec3::splat(0.8), "{said:?}");
}

#[test]
fn morph_weights_move_vertices() {
    let mut d = Data::default();
    let (p, t) = (d.floats("VEC3", 3, &SQUARE[..9]), d.floats("VEC3", 3, &[0., 0., 4., 0., 0., 4., 0., 0., 4.]));
    let rest = format!(
        r#","meshes":[{{"weights":[0.5],"primitives":[{{"attributes":{{"POSITION":{p}}},"targets":[{{"POSITION":{t}}}]}}]}}],
        "nodes":[{{"mesh":0}},{{"mesh":0,"weights":[0]}}]"#
    );
    let f = Folder::new().with("a.glb", d.glb(&rest));
    let s = f.scene("a.glb");
    assert_eq!(mesh(&s, 0).vertices[0], Vec3::new(0.0, 0.0, 2.0));
    assert_eq!(mesh(&s, 1).vertices[0], Vec3::ZERO);
}

/// A file whose node 0 shows a square as the attributes say.
fn instanced(d: &mut Data, attributes: &str) -> Vec<u8> {
    let (p, i) = (d.floats("VEC3", 3, &SQUARE), d.indices(&[0, 1, 2, 0, 2, 3]));
    d.glb(&format!(
        r#","meshes":[{{"primitives":[{{"attributes":{{"POSITION":{p}}},"indices":{i}}}]}}],"extensionsRequired":["EXT_mesh_gpu_instancing"],
        "nodes":[{{"mesh":0,"translation":[0,0,5],"extensions":{{"EXT_mesh_gpu_instancing":{{"attributes":{{{attributes}}}}}}}}}]"#
    ))
}

#[test]
fn gpu_instances_stand_inside_their_node_and_share_its_mesh() {
    let mut d = Data::default();
    let places = d.floats("VEC3", 3, &[1., 0., 0., 0., 2., 0.]);
    let scales = d.floats("VEC3", 3, &[1., 1., 1., 3., 3., 3.]);
    let one = d.floats("VEC3", 3, &[1., 1., 1.]);
    let wild = d.floats("VEC3", 3, &[1., 0., 0., f32::NAN, 2., 0.]);
    // A quarter turn about z in 16 and in 8 bits; zeros are no turn.
    let half = (0.5f64.sqrt() * 32767.0).round() as i16;
    let shorts: Vec<u8> = [0, 0, half, half, 0, 0, 0, 0].iter().flat_map(|v: &i16| v.to_le_bytes()).collect();
    let shorts = d.add(&shorts, 5122, "VEC4", 2, r#","normalized":true"#);
    let bytes = d.add(&[0, 0, 90, 90, 0, 0, 0, 127], 5120, "VEC4", 2, r#","normalized":true"#);
    let huge = d.add_bare(r#"{"componentType":5126,"type":"VEC3","count":4000000000}"#);
    let mut file = |attributes: &str| instanced(&mut d, attributes);
    let f = Folder::new()
        .with("a.glb", file(&format!(r#""TRANSLATION":{places},"SCALE":{scales},"_ID":{places}"#)))
        .with("shorts.glb", file(&format!(r#""ROTATION":{shorts},"TRANSLATION":{places}"#)))
        .with("bytes.glb", file(&format!(r#""ROTATION":{bytes}"#)))
        .with("odd.glb", file(&format!(r#""TRANSLATION":{places},"SCALE":{one}"#)))
        .with("wild.glb", file(&format!(r#""TRANSLATION":{wild}"#)))
        .with("huge.glb", file(&format!(r#""TRANSLATION":{huge}"#)))
        .with("beyond.glb", file(r#""TRANSLATION":999"#))
        .with("flat.glb", file(&format!(r#""ROTATION":{places}"#)))
        .with("none.glb", file(""));
    let (s, said) = f.load("a.glb");
    let s = s.expect("loads");
    assert_eq!(said.iter().filter(|m| m.contains("_ID")).count(), 1, "{said:?}");
    assert_eq!(s.objects.len(), 2);
    assert!(Arc::ptr_eq(mesh(&s, 0), mesh(&s, 1)));
    near(s.objects[0].transform.point(DVec3::X), DVec3::new(2.0, 0.0, 5.0));
    near(s.objects[1].transform.point(DVec3::X), DVec3::new(3.0, 2.0, 5.0));
    let s = f.scene("shorts.glb");
    near(s.objects[0].transform.point(DVec3::X), DVec3::new(1.0, 1.0, 5.0));
    near(s.objects[1].transform.point(DVec3::X), DVec3::new(1.0, 2.0, 5.0));
    near(f.scene("bytes.glb").objects[0].transform.point(DVec3::X), DVec3::new(0.0, 1.0, 5.0));
    for (name, what) in [
        ("odd.glb", "[2, 1]"),
        ("wild.glb", "instance 1 is not finite"),
        ("huge.glb", "without bytes behind them"),
        ("beyond.glb", "accessor 999"),
        ("flat.glb", "ROTATION needs [4] numbers"),
        ("none.glb", "neither TRANSLATION"),
    ] {
        assert!(f.error(name).contains(what), "{name}: {}", f.error(name));
    }
}

#[test]
fn instances_without_bytes_behind_them_do_not_take_all_memory() {
    let mut d = Data::default();
    let many = d.add_bare(r#"{"componentType":5126,"type":"VEC3","count":16000000}"#);
    let f = Folder::new().with("a.glb", instanced(&mut d, &format!(r#""TRANSLATION":{many}"#)));
    let options = ImportOptions { memory: MemoryLimit::bytes(1 << 30), ..ImportOptions::default() };
    let error = load(&f.path("a.glb"), &options, &mut Sink::default()).expect_err("16 million objects").to_string();
    assert!(error.contains("out of memory"), "{error}");
}

#[test]
fn pictures_that_nothing_shows_are_not_decoded() {
    use rayloom::import::{ImportOptions, load};
    use rayloom::savings::{Saving, Savings};
    let picture = png(1, 1, |_, _| [9, 9, 9, 255]);
    let mut d = Data::default();
    let p = d.floats("VEC3", 3, &SQUARE);
    let shown = d.add(&picture, 5121, "SCALAR", picture.len(), "");
    let broken = d.add(b"no picture at all", 5121, "SCALAR", 17, "");
    // The second is for occlusion alone, the third belongs to a material that nothing wears.
    let rest = format!(
        r#","meshes":[{{"primitives":[{{"attributes":{{"POSITION":{p}}},"mode":6,"material":0}}]}}],"nodes":[{{"mesh":0}}],
        "images":[{{"bufferView":{shown},"mimeType":"image/png"}},{{"bufferView":{broken},"mimeType":"image/png"}},{{"bufferView":{broken},"mimeType":"image/png"}}],
        "textures":[{{"source":0}},{{"source":1}},{{"source":2}}],
        "materials":[{{"emissiveTexture":{{"index":0}},"occlusionTexture":{{"index":1}}}},{{"normalTexture":{{"index":2}}}}]"#
    );
    let f = Folder::new().with("a.glb", d.glb(&rest));
    let read = |savings: Savings| {
        let mut sink = rayloom::diag::Sink::default();
        let scene = load(&f.path("a.glb"), &ImportOptions { savings, ..ImportOptions::default() }, &mut sink).expect("loads");
        (scene, sink.items().iter().filter(|d| d.message.contains("is left out")).count())
    };
    let (scene, n_notes) = read(Savings::ALL);
    assert_eq!((scene.unread.pictures, n_notes), ([2, 3], 0));
    assert!(material(&scene, 0).emission_texture.is_some());
    let (scene, n_notes) = read(Savings::ALL.without(Saving::Textures));
    assert_eq!((scene.unread.pictures, n_notes), ([0, 3], 2));
}
