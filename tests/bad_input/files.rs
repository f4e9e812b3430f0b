//! Files that are missing, cut off, garbage or enormous; pictures that cannot be written.

use super::run::{Ended, Folder, finish};
use super::{Case, judge};

/// Bytes without sense, always the same.
fn garbage(n: usize) -> Vec<u8> {
    let mut state = 1u32;
    let mut next = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 24) as u8
    };
    (0..n).map(|_| next()).collect()
}

/// A PNG of `side` by `side` black pixels: a few hundred KiB as a file, GiB when it is decoded.
fn png_bomb(side: u32) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, side, side);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::One);
    encoder.set_compression(png::Compression::High);
    let mut writer = encoder.write_header().expect("a header");
    let mut stream = writer.stream_writer().expect("a stream");
    let row = vec![0; side as usize / 8];
    (0..side).for_each(|_| std::io::Write::write_all(&mut stream, &row).expect("a row"));
    stream.finish().expect("an end");
    drop(writer);
    bytes
}

#[test]
fn scene_files_that_are_none_are_refused() {
    let folder = Folder::new();
    std::fs::create_dir(folder.path("folder.pov")).expect("a folder");
    folder
        .write("empty.pov", "")
        .write("garbage.pov", garbage(100_000))
        .write("zeros.pov", [0; 100_000])
        .write("latin.pov", b"camera { \xe4\xf6 }");
    folder.write("unclosed.pov", "sphere { 0, 1").write("open.pov", "#include \"open").write("cr.pov", "sphere { 0, 1 }\r\rfoo");
    judge(&[
        Case("no such scene", folder.render("none.pov", &[]), &[4], "none.pov"),
        Case("a folder", folder.render("folder.pov", &[]), &[4], "folder.pov"),
        Case("no such scene (povray)", folder.run(&["povray", "+Inone.pov"]), &[1], "none.pov"),
        Case("an empty scene", folder.render("empty.pov", &[]), &[0], ""),
        Case("garbage", folder.render("garbage.pov", &[]), &[3], ""),
        Case("garbage (povray)", folder.run(&["povray", "+Igarbage.pov"]), &[1], ""),
        Case("zeros", folder.render("zeros.pov", &[]), &[0], ""),
        Case("Latin-1", folder.render("latin.pov", &[]), &[3], ""),
        Case("an open brace", folder.render("unclosed.pov", &[]), &[3], "End of File"),
        Case("an open string", folder.render("open.pov", &[]), &[3], "not terminated"),
        Case("lone carriage returns", folder.render("cr.pov", &[]), &[3], "foo"),
        Case("no include", folder.write("a.pov", "#include \"none.inc\"").render("a.pov", &[]), &[3], "none.inc"),
        Case("an include that is a folder", folder.write("b.pov", "#include \"folder.pov\"").render("b.pov", &[]), &[3], "folder.pov"),
        Case("an include of garbage", folder.write("c.pov", "#include \"garbage.pov\"").render("c.pov", &[]), &[3], ""),
    ]);
}

#[test]
fn images_fonts_and_grids_that_are_none_are_refused() {
    let folder = Folder::new();
    folder
        .write("garbage.png", garbage(5000))
        .write("empty.png", "")
        .write("cut.png", &png_bomb(64)[..60])
        .write("bomb.png", png_bomb(16_000));
    folder.write("huge.png", b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\x7f\xff\xff\xff\x7f\xff\xff\xff\x08\x02\0\0\0\0\0\0\0");
    folder.write("garbage.ttf", garbage(5000)).write("empty.ttf", "").write("short.df3", [0, 9, 0, 9, 0, 9, 1, 2]).write("cut.df3", [0]);
    folder.write("huge.df3", [0xff; 6]).write("zero.df3", [0, 0, 0, 1, 0, 1, 5]);
    let image = |name: &str| scene(&folder, &format!("sphere {{ 0, 1 pigment {{ image_map {{ \"{name}\" }} }} }}"));
    let font = |name: &str| scene(&folder, &format!("text {{ ttf \"{name}\" \"text\" 1, 0 }}"));
    let grid = |name: &str| scene(&folder, &format!("box {{ 0, 1 pigment {{ density_file df3 \"{name}\" }} }}"));
    judge(&[
        Case("no image", image("none.png"), &[3], "none.png"),
        Case("an image of garbage", image("garbage.png"), &[3], "garbage.png"),
        Case("an empty image", image("empty.png"), &[3], "empty.png"),
        Case("an image cut off", image("cut.png"), &[3], "cut.png"),
        Case("an image of 2^62 pixels", image("huge.png"), &[3], "huge.png"),
        Case("an image that grows when it is decoded", image("bomb.png"), &[3], "bomb.png"),
        Case("a height field cut off", scene(&folder, "height_field { png \"cut.png\" }"), &[3], "cut.png"),
        Case("no font", font("none.ttf"), &[3], "none.ttf"),
        Case("a font of garbage", font("garbage.ttf"), &[3], "garbage.ttf"),
        Case("an empty font", font("empty.ttf"), &[3], "empty.ttf"),
        Case("no density file", grid("none.df3"), &[3], "none.df3"),
        Case("a density file too short", grid("short.df3"), &[3], "short.df3"),
        Case("a density file of a byte", grid("cut.df3"), &[3], "cut.df3"),
        Case("a density file of 2^48 cells", grid("huge.df3"), &[3], "huge.df3"),
        Case("a density file without cells", grid("zero.df3"), &[0, 3], "zero.df3"),
        Case("#read of garbage", scene(&folder, "#fopen F \"garbage.png\" read #read (F, A, B, C)"), &[0, 3], ""),
        Case("#fopen outside", scene(&folder, "#fopen F \"/etc/rayloom-test\" write"), &[3], "rayloom-test"),
    ]);
}

fn scene(folder: &Folder, body: &str) -> Ended {
    let text = format!("#version 3.7; global_settings {{ assumed_gamma 1 }} camera {{ location -3*z }} {body}");
    folder.write("scene.pov", text).render("scene.pov", &["--max-memory", "1000"])
}

#[test]
fn models_that_are_none_are_refused() {
    let folder = Folder::new();
    let json = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"children":[0]}]}"#;
    let head = |length: u32| [&b"glTF"[..], &2u32.to_le_bytes(), &length.to_le_bytes()].concat();
    folder.write("cut.glb", head(5000)).write("cut2.glb", &head(12)[..7]).write("garbage.glb", garbage(5000)).write("empty.glb", "");
    folder.write("chunk.glb", [head(20), vec![0xff, 0xff, 0xff, 0xff], b"JSON".to_vec()].concat());
    folder
        .write("cycle.gltf", json)
        .write("deep.gltf", "[".repeat(100_000))
        .write("no.gltf", "{}")
        .write("garbage.obj", garbage(20_000))
        .write("empty.obj", "");
    folder
        .write("index.obj", "v 0 0 0\nf 1 2 3\n")
        .write("negative.obj", "v 0 0 0\nf -5 -6 -7\n")
        .write("huge.obj", "v 1e999 nan inf\nv 0 1 0\nv 1 0 0\nf 1 2 3\n");
    folder.write("number.obj", "v 0 0 0\nf 99999999999999999999 1 1\n");
    let buffer = r#"{"asset":{"version":"2.0"},"buffers":[{"byteLength":4000000000000}],"bufferViews":[{"buffer":0,"byteLength":4000000000000}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":300000000000,"type":"VEC3","min":[0,0,0],"max":[1,1,1]}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"nodes":[{"mesh":0}],"scenes":[{"nodes":[0]}],"scene":0}"#;
    folder.write("buffer.gltf", buffer);
    let model = |name: &str| folder.render(name, &["--spp", "1", "--max-memory", "1000"]);
    let drop_antialias = |name: &str| model(name);
    judge(&[
        Case("no model", drop_antialias("none.glb"), &[3, 4], "none.glb"),
        Case("a model cut off", model("cut.glb"), &[3, 4], "cut.glb"),
        Case("a model cut off in its head", model("cut2.glb"), &[3, 4], "cut2.glb"),
        Case("a chunk that is too long", model("chunk.glb"), &[3, 4], "chunk.glb"),
        Case("a model of garbage", model("garbage.glb"), &[3, 4], "garbage.glb"),
        Case("an empty model", model("empty.glb"), &[3, 4], "empty.glb"),
        Case("a node that is its own child", model("cycle.gltf"), &[3], "cycle.gltf"),
        Case("JSON nested 100,000 deep", model("deep.gltf"), &[3], "deep.gltf"),
        Case("JSON without an asset", model("no.gltf"), &[3], "no.gltf"),
        Case("a buffer of 4 TB", model("buffer.gltf"), &[3, 4], "buffer.gltf"),
        Case("an OBJ of garbage", model("garbage.obj"), &[0, 3], ""),
        Case("an empty OBJ", model("empty.obj"), &[0, 3], ""),
        Case("an OBJ with an index too far", model("index.obj"), &[3], "index.obj"),
        Case("an OBJ with a negative index too far", model("negative.obj"), &[3], "negative.obj"),
        Case("an OBJ of infinite points", model("huge.obj"), &[0, 3], ""),
        Case("an OBJ with an enormous index", model("number.obj"), &[3], "number.obj"),
    ]);
}

const OLD: &[u8] = b"the old picture";

#[test]
fn pictures_that_cannot_be_written_leave_the_old_ones() {
    let folder = Folder::new();
    folder.write("a.pov", "#version 3.7; camera { location -3*z } sphere { 0, 1 }").write("old.png", OLD).write("bad.pov", "sphere {");
    folder.write("read-only.png", OLD);
    std::fs::create_dir(folder.path("folder.png")).expect("a folder");
    let mut mode = folder.path("read-only.png").metadata().expect("a file").permissions();
    mode.set_readonly(true);
    std::fs::set_permissions(folder.path("read-only.png"), mode).expect("a mode");
    let to = |out: &str| folder.run(&["render", "a.pov", "-o", out, "--size", "8x6", "--progress", "none"]);
    // Files may hold 512 bytes; the signal that says so is ignored, so that writing fails as on a full disk.
    let full = || {
        finish(folder.start("trap '' XFSZ; ulimit -f 1;", &["render", "a.pov", "-o", "old.png", "--size", "400x300", "--progress", "none"]))
    };
    judge(&[
        Case("a folder that is not there", to("none/out.png"), &[4], "none/out.png"),
        Case("a folder in the picture's place", to("folder.png"), &[4], "folder.png"),
        Case("a read-only picture", to("read-only.png"), &[4], "read-only.png"),
        Case("a file as a folder", to("a.pov/out.png"), &[4], "a.pov/out.png"),
        Case("a full disk", full(), &[4], "old.png"),
        Case("a wrong scene", folder.run(&["render", "bad.pov", "-o", "old.png"]), &[3], ""),
        Case("a folder that is not there (povray)", folder.run(&["povray", "+Ia.pov", "+Onone/out.png"]), &[1], "none/out.png"),
        Case(
            "statistics that cannot be written",
            folder.run(&["render", "a.pov", "-o", "new.png", "--size", "8x6", "--progress", "none", "--stats", "none/s.json"]),
            &[4],
            "none/s.json",
        ),
    ]);
    for name in ["old.png", "read-only.png"] {
        assert_eq!(std::fs::read(folder.path(name)).expect("the old picture"), OLD, "{name}");
    }
    let left: Vec<_> = std::fs::read_dir(folder.path("."))
        .expect("a folder")
        .filter_map(|e| e.ok()?.file_name().into_string().ok())
        .filter(|n| n.ends_with(".part"))
        .collect();
    assert!(left.is_empty(), "left behind: {left:?}");
}
