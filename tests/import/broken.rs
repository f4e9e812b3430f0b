//! Damaged and hostile files: one clear error each, no panic, no waiting.

use crate::files::{Data, Folder, SQUARE, glb};

/// One triangle with these nodes, accessors replaced by `tamper`.
fn triangle(tamper: impl Fn(String) -> String) -> Vec<u8> {
    let mut d = Data::default();
    let (p, i) = (d.floats("VEC3", 3, &SQUARE[..9]), d.indices(&[0, 1, 2]));
    let mesh =
        format!(r#","meshes":[{{"name":"Cube","primitives":[{{"attributes":{{"POSITION":{p}}},"indices":{i}}}]}}],"nodes":[{{"mesh":0}}]"#);
    glb(&tamper(d.json(&format!(r#"{{"byteLength":{}}}"#, d.bytes.len()), &mesh)), &d.bytes)
}

fn error_of(bytes: impl AsRef<[u8]>) -> String {
    Folder::new().with("x.glb", bytes).error("x.glb")
}

/// Tampers with the JSON of a triangle; the text must have been there.
fn tampered(from: &str, to: &str) -> String {
    error_of(triangle(|json| {
        assert!(json.contains(from), "{json}");
        json.replacen(from, to, 1)
    }))
}

fn says(error: &str, parts: &[&str]) {
    assert!(error.contains("x.") && parts.iter().all(|p| error.contains(p)), "'{error}' does not say {parts:?}");
}

#[test]
fn the_untampered_triangle_loads() {
    let f = Folder::new().with("x.glb", triangle(|j| j));
    assert_eq!(f.scene("x.glb").objects.len(), 1);
}

#[test]
fn every_cut_of_a_glb_is_an_error() {
    let whole = triangle(|j| j);
    for n in 1..whole.len() {
        let error = error_of(&whole[..n]);
        assert!(error.contains("damaged"), "{n} bytes: {error}");
    }
}

#[test]
fn every_changed_byte_of_a_glb_is_read_or_refused() {
    let whole = triangle(|j| j);
    for k in 0..whole.len() {
        for bits in [0x01u8, 0x10, 0x80, 0xFF] {
            let mut bytes = whole.clone();
            bytes[k] ^= bits;
            let _ = Folder::new().with("x.glb", bytes).load("x.glb");
        }
    }
}

#[test]
fn files_that_are_none_say_so() {
    let f = Folder::new().with("x.glb", "").with("x.bin", [7u8; 5000]).with("x.obj", [0u8, 200, 3, 10, 250, 0, 10]).with("x.gltf", "hello");
    says(&f.error("x.glb"), &["empty"]);
    says(&f.error("x.bin"), &["neither glTF 2.0 nor OBJ"]);
    says(&f.error("x.obj"), &["neither glTF 2.0 nor OBJ"]);
    says(&f.error("x.gltf"), &["damaged"]);
    says(&f.error("x.nothing"), &["cannot read"]);
    std::fs::create_dir(f.path("x.dir.glb")).expect("a folder");
    says(&f.error("x.dir.glb"), &["is not a file"]);
}

#[test]
fn glb_headers_that_lie_are_damaged() {
    let whole = triangle(|j| j);
    let with_word = |at: usize, word: u32| {
        let mut b = whole.clone();
        b[at..at + 4].copy_from_slice(&word.to_le_bytes());
        error_of(b)
    };
    says(&with_word(4, 1), &["version 1"]);
    says(&with_word(8, u32::MAX), &["cut off"]);
    says(&with_word(8, 0), &["no JSON chunk"]);
    says(&with_word(12, u32::MAX), &["JSON chunk claims"]);
}

#[test]
fn indices_and_vertices_out_of_order_name_the_mesh() {
    let mut d = Data::default();
    let (p, i) = (d.floats("VEC3", 3, &[0., 0., 0., 1., f32::NAN, 0., 1., 1., 0.]), d.indices(&[0, 1, 3]));
    let mesh = |indices: &str| {
        d.glb(&format!(
            r#","meshes":[{{"name":"Cube","primitives":[{{"attributes":{{"POSITION":{p}}}{indices}}}]}}],"nodes":[{{"mesh":0}}]"#
        ))
    };
    says(&error_of(mesh("")), &["mesh 'Cube', primitive 0", "vertex 1", "NaN"]);
    says(&error_of(mesh(&format!(r#","indices":{i}"#))), &["mesh 'Cube', primitive 0", "index 3", "3 vertices"]);
    says(&error_of(mesh(&format!(r#","indices":{p}"#))), &["accessor 0", "[1] numbers"]);
    says(&error_of(mesh(r#","material":5"#)), &["material 5"]);
}

#[test]
fn claims_of_accessors_views_and_buffers_are_checked() {
    says(&tampered(r#""count":3"#, r#""count":4000000000"#), &["accessor 0", "4000000000 elements"]);
    says(&tampered(r#""count":3"#, r#""count":18446744073709551615"#), &["accessor 0"]);
    says(&tampered(r#""byteLength":36"#, r#""byteLength":4294967295"#), &["buffer view 0"]);
    says(&tampered(r#""byteOffset":0"#, r#""byteOffset":18446744073709551615"#), &["buffer view 0"]);
    says(&tampered(r#""byteLength":42"#, r#""byteLength":4000000000"#), &["buffer 0", "4000000000"]);
    says(&tampered(r#""buffer":0"#, r#""buffer":9"#), &["buffer 9"]);
    says(&tampered(r#""bufferView":0"#, r#""bufferView":9"#), &["accessor 0", "buffer view 9"]);
    says(&tampered(r#""componentType":5126"#, r#""componentType":5"#), &["accessor 0"]);
    says(&tampered(r#""POSITION":0"#, r#""POSITION":9"#), &["Cube", "accessor 9"]);
}

#[test]
fn virtual_accessors_are_limited() {
    let error = tampered(
        r#""bufferView":0,"componentType":5126,"type":"VEC3","count":3"#,
        r#""componentType":5126,"type":"VEC3","count":4000000000"#,
    );
    says(&error, &["without bytes behind them"]);
}

#[test]
fn buffers_that_are_missing_name_their_file() {
    let f = Folder::new().with("x.gltf", r#"{"asset":{"version":"2.0"},"buffers":[{"byteLength":4,"uri":"gone.bin"}]}"#);
    assert!(f.error("x.gltf").contains("gone.bin"));
    let f = Folder::new().with("x.gltf", r#"{"asset":{"version":"2.0"},"buffers":[{"byteLength":4}]}"#);
    says(&f.error("x.gltf"), &["buffer 0", "neither an address nor a binary chunk"]);
    let f = Folder::new().with("x.gltf", r#"{"asset":{"version":"2.0"},"buffers":[{"byteLength":4,"uri":"https://a/b.bin"}]}"#);
    says(&f.error("x.gltf"), &["https addresses are not read"]);
}

#[test]
fn required_extensions_that_are_unknown_are_named_and_used_ones_told() {
    let required = r#"{"asset":{"version":"2.0"},"extensionsRequired":["KHR_draco_mesh_compression"]}"#;
    let used = r#"{"asset":{"version":"2.0"},"extensionsUsed":["KHR_draco_mesh_compression"]}"#;
    let f = Folder::new().with("x.gltf", required).with("y.gltf", used);
    says(&f.error("x.gltf"), &["KHR_draco_mesh_compression"]);
    let (scene, said) = f.load("y.gltf");
    assert!(scene.is_ok() && said.iter().any(|s| s.contains("KHR_draco_mesh_compression")), "{said:?}");
}

#[test]
fn cycles_shared_children_and_deep_nesting_are_named_errors() {
    let gltf = |nodes: &str| {
        Folder::new().with("x.gltf", format!(r#"{{"asset":{{"version":"2.0"}},"scenes":[{{"nodes":[0]}}],"nodes":[{nodes}]}}"#))
    };
    says(&gltf(r#"{"children":[1]},{"children":[0]}"#).error("x.gltf"), &["node 0", "reached twice"]);
    says(&gltf(r#"{"children":[1,1]},{}"#).error("x.gltf"), &["node 1", "reached twice"]);
    says(&gltf(r#"{"children":[7]}"#).error("x.gltf"), &["node 7"]);
    let chain = |n: usize| (1..n).map(|k| format!(r#"{{"children":[{k}]}}"#)).chain(["{}".into()]).collect::<Vec<_>>().join(",");
    assert!(gltf(&chain(1000)).load("x.gltf").0.is_ok());
    says(&gltf(&chain(100_000)).error("x.gltf"), &["deeper than 1000"]);
    says(&gltf(r#"{"translation":[1e39,0,0]}"#).error("x.gltf"), &["x.gltf"]);
}

#[test]
fn nested_json_does_not_run_over_the_stack() {
    let f = Folder::new().with("x.gltf", format!(r#"{{"asset":{{"version":"2.0"}},"extras":{}"#, "[".repeat(1_000_000)));
    says(&f.error("x.gltf"), &["damaged"]);
}

#[test]
fn obj_errors_name_line_object_and_index() {
    let error = |text: &str| Folder::new().with("x.obj", text).error("x.obj");
    says(&error("o Cube\nv 0 0 0\nv 1 nan 0"), &["line 3 (object 'Cube')", "vertex 2", "NaN"]);
    says(&error("v 0 0 1e99"), &["line 1", "vertex 1", "inf"]);
    says(&error("v 0 0 0\nf 1 2 3"), &["line 2", "index 2", "1 vertices"]);
    says(&error("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1//1 2//1 3//1"), &["index 1", "0 normals"]);
    says(&error("v 0 0 0\nf -2 -1 -1"), &["index -2"]);
    says(&error("v 0 0 0\nf 0 1 1"), &["index 0"]);
    says(&error("v 0 0 0\nf 1 99999999999999999999 1"), &["no index"]);
    says(&error("v 0 0"), &["3 numbers are needed"]);
    says(&error("v 0 0 zero"), &["'zero' is no number"]);
    says(&error("v 0 0 0\nf 1 1"), &["3 corners"]);
    says(&error(&format!("v 0 0 0\nf {}", "1 ".repeat(20_000))), &["line 2", "more than 16384 corners"]);
}
