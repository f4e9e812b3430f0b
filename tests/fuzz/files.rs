//! The inputs that the search starts from: scenes, and files of every other kind made here.

use super::root;
use super::targets::Kind;
use image::{DynamicImage, ImageFormat};
use std::io::Cursor;
use std::path::Path;

/// Uses an image in each way there is.
pub const IMAGE_SCENE: &str = r#"
#version 3.7; global_settings { assumed_gamma 1 }
camera { location <0.5, 0.5, -2> look_at <0.5, 0.5, 0> } light_source { -5, 1 }
plane { z, 0 pigment { image_map { "a.png" interpolate 2 map_type 0 } } normal { bump_map { "a.png" bump_size 2 } } }
height_field { "a.png" smooth } sphere { 1, 1 pigment { image_pattern { "a.png" use_alpha } } }
box { 0, 1 texture { material_map { "a.png" texture { } texture { pigment { rgb 1 } } } } }
"#;

/// Sets a text.
pub const FONT_SCENE: &str =
    "camera { location <1, 1, -5> look_at 1 } text { ttf \"a.ttf\" \"AB CA\" 0.2, <0.1, 0, 0> pigment { rgb 1 } }\n";

/// Uses a density file.
pub const DENSITY_SCENE: &str = "camera { location <0.5, 0.5, -3> look_at 0.5 }
box { 0, 1 pigment { density_file df3 \"a.df3\" interpolate 1 } finish { ambient 1 } }
box { <0, 0, 1>, 2 pigment { density_file df3 \"a.df3\" interpolate 2 } }\n";

const GLTF: &str = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0,1,2]}],
"nodes":[{"mesh":0,"rotation":[0,0,0,1],"scale":[1,1,1],"children":[3]},{"camera":0,"translation":[0,0,3]},
{"extensions":{"KHR_lights_punctual":{"light":0}},"translation":[1,2,3]},{"mesh":0,"matrix":[1,0,0,0,0,1,0,0,0,0,1,0,1,0,0,1]}],
"cameras":[{"type":"perspective","perspective":{"yfov":0.8,"znear":0.1,"aspectRatio":1.3}}],
"extensionsUsed":["KHR_lights_punctual","KHR_texture_transform"],"extensions":{"KHR_lights_punctual":{"lights":[{"type":"spot","intensity":40,"color":[1,1,1],"spot":{"innerConeAngle":0.1,"outerConeAngle":0.5}}]}},
"materials":[{"pbrMetallicRoughness":{"baseColorFactor":[1,0.5,0.2,1],"metallicFactor":0.1,"roughnessFactor":0.5,"baseColorTexture":{"index":0,"extensions":{"KHR_texture_transform":{"offset":[0.1,0],"scale":[2,2]}}}},"alphaMode":"MASK","doubleSided":true,"emissiveFactor":[0,0,0.1]}],
"textures":[{"source":0,"sampler":0}],"samplers":[{"wrapS":10497,"magFilter":9729}],"images":[{IMAGE}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0,"NORMAL":1,"TEXCOORD_0":2},"indices":3,"material":0,"mode":4}]}],
"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]},{"bufferView":1,"componentType":5126,"count":3,"type":"VEC3"},
{"bufferView":2,"componentType":5126,"count":3,"type":"VEC2"},{"bufferView":3,"componentType":5123,"count":3,"type":"SCALAR"}],
"bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":36},{"buffer":0,"byteOffset":72,"byteLength":24},{"buffer":0,"byteOffset":96,"byteLength":6},{"buffer":0,"byteOffset":104,"byteLength":PNG}],
"buffers":[{"byteLength":TOTAL URI}]}"#;

const OBJ: &str = "mtllib x.mtl\no thing\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0 1\nvt 0 0\nvt 1 0\nvt 1 1\nvn 0 0 1\ng a b\ns 1\nusemtl red
f 1/1/1 2/2/1 3/3/1\nf -4//1 -3//1 -1//1\nusemtl glass\nf 1 2 3 4\nl 1 2\np 1\n
%%mtl\nnewmtl red\nKd 1 0 0\nKs 0.5 0.5 0.5\nNs 50\nd 1\nillum 2\nmap_Kd -s 2 2 2 missing.png\nnewmtl glass\nTf 1 1 1\nNi 1.5\nd 0.2\nPr 0.1\nPm 0.2\nKe 0 0 1\n";

const INI: &str = "; a comment\nWidth=8\nHeight = 6 # more\n+A0.3 -J\nLibrary_Path=\"/tmp\", '/usr'\nDeclare=A=1,B=\"x\"\n[low]\nWidth=4 Height=3\n[high]\n\
Initial_Frame=1\nFinal_Frame=20\nSubset_Start_Frame=0.5\nFrame_Step=3\nCyclic_Animation=on\nClock=0.5\nInclude_INI=x.ini\nOutput_File_Type=N16g\nAll_File=on\n";

const WORDS: &str = "+Iscene.pov\n+Oout.png\n+W8\n+H6\n+A0.3\n+AM2\n+R3\n+J0.5\n+SC1\n+EC4\n+SR0.25\n+ER6\n+FN16\n+UA\n+Q9\n+L/tmp\n+K0.5\n+KFI1\n+KFF12\n+KI0\n+KF1\n\
+KC\n+SF2\n+EF0.5\n+WT2\n+C\n+GDx\nDeclare=A=2\nFile_Gamma=srgb\nVersion=3.6\n+BS8\nBackend=cpu\nscene.ini[low]\n-D\n+THFS\n+MV3.7\n";

/// A small PNG of random-looking colours.
pub fn png(width: u32, height: u32) -> Vec<u8> {
    encoded(&picture(width, height), ImageFormat::Png)
}

fn picture(width: u32, height: u32) -> DynamicImage {
    DynamicImage::ImageRgba8(image::RgbaImage::from_fn(width, height, |x, y| image::Rgba([x, y, x + y, x * y + 1].map(|v| (v * 67) as u8))))
}

fn encoded(image: &DynamicImage, format: ImageFormat) -> Vec<u8> {
    let mut out = Cursor::new(Vec::new());
    image.write_to(&mut out, format).expect("a small picture");
    out.into_inner()
}

/// A df3 file of 2 by 3 by 2 cells.
pub fn density() -> Vec<u8> {
    [&[0, 2, 0, 3, 0, 2][..], &[0, 50, 100, 150, 200, 250, 255, 1, 2, 3, 4, 5]].concat()
}

fn indexed_images() -> Vec<Vec<u8>> {
    let palette: Vec<u8> = (0..12).map(|v| v * 20).collect();
    let mut png_bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut png_bytes, 4, 2);
    encoder.set_color(png::ColorType::Indexed);
    encoder.set_depth(png::BitDepth::Two);
    encoder.set_palette(palette.clone());
    encoder.set_trns(vec![255, 100]);
    let mut writer = encoder.write_header().expect("a small picture");
    writer.write_image_data(&[0b00_01_10_11, 0b11_00_01_10]).expect("a small picture");
    drop(writer);
    let mut gif_bytes = Vec::new();
    let mut encoder = gif::Encoder::new(&mut gif_bytes, 4, 2, &palette).expect("a small picture");
    encoder.write_frame(&gif::Frame::from_indexed_pixels(4, 2, vec![0, 1, 2, 3, 3, 2, 1, 0], Some(1))).expect("a small picture");
    drop(encoder);
    // A TGA with a colour map, run-length coded.
    let mut tga = vec![0, 1, 9, 0, 0, 3, 0, 24, 0, 0, 0, 0, 3, 0, 1, 0, 8, 0];
    tga.extend([0, 0, 255, 0, 255, 0, 255, 0, 0, 0x81, 2, 0, 1]);
    vec![png_bytes, gif_bytes, tga]
}

fn images() -> Vec<Vec<u8>> {
    use ImageFormat::{Bmp, Gif, Hdr, Jpeg, Png, Pnm, Tga, Tiff};
    let p = picture(5, 3);
    let rgb = DynamicImage::ImageRgb8(p.to_rgb8());
    let mut all: Vec<Vec<u8>> = [Png, Bmp, Gif, Tga, Tiff, Pnm].map(|f| encoded(if f == Pnm || f == Bmp { &rgb } else { &p }, f)).into();
    all.extend([Png, Bmp, Tga, Tiff, Jpeg, Pnm].map(|f| encoded(&DynamicImage::ImageLuma8(p.to_luma8()), f)));
    all.extend([Png, Tiff].map(|f| encoded(&DynamicImage::ImageLuma16(p.to_luma16()), f)));
    all.push(encoded(&DynamicImage::ImageRgba16(p.to_rgba16()), Png));
    all.push(encoded(&rgb, Jpeg));
    all.push(encoded(&DynamicImage::ImageRgb32F(p.to_rgb32f()), Hdr));
    all.push(b"P3\n2 1\n255\n1 2 3 4 5 6\n".to_vec());
    all.push(b"P2\n# c\n2 1\n65535\n1 60000\n".to_vec());
    let mut exr = Cursor::new(Vec::new());
    let channels = exr::prelude::SpecificChannels::rgba(|at: exr::prelude::Vec2<usize>| (at.x() as f32, at.y() as f32, 0.5f32, 1.0f32));
    exr::prelude::WritableImage::write(&exr::prelude::Image::from_channels((3, 2), channels))
        .to_buffered(&mut exr)
        .expect("a small picture");
    all.push(exr.into_inner());
    all.extend(indexed_images());
    all
}

/// A TrueType font with the glyphs none, A, B (quadratic, composed) and a blank.
pub fn font() -> Vec<u8> {
    let be = |v: &[i32]| v.iter().flat_map(|&x| (x as i16).to_be_bytes()).collect::<Vec<u8>>();
    let triangle = [be(&[1, 0, 0, 500, 700, 2, 0]), vec![1, 1, 1], be(&[0, 250, 250, 0, 700, -700]), vec![0]].concat();
    let curved = [be(&[1, 10, 0, 400, 600, 3, 0]), vec![1, 0, 1, 0], be(&[10, 390, -200, -190, 0, 300, 300, -600])].concat();
    let composed = be(&[-1, 0, 0, 500, 700, 0x23, 1, 0, 0, 0x03, 2, 100, 50]);
    let glyphs = [triangle.clone(), triangle, curved, composed];
    let mut glyf = Vec::new();
    let mut loca = vec![0];
    for g in glyphs {
        glyf.extend(g);
        glyf.resize(glyf.len().next_multiple_of(2), 0);
        loca.push(glyf.len() as i32 / 2);
    }
    let map: Vec<u8> = (0..256).map(|c| if (65..68).contains(&c) { (c - 64) as u8 } else { 0 }).collect();
    let tables: Vec<(&[u8; 4], Vec<u8>)> = vec![
        (b"cmap", [be(&[0, 1, 1, 0, 0, 12, 0, 262, 0]), map].concat()),
        (b"glyf", glyf),
        (b"head", be(&[1, 0, 1, 0, 0, 0, 0x5F0F, 0x3CF5, 0, 1000, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 500, 700, 0, 8, 2, 0, 0])),
        (b"hhea", be(&[1, 0, 800, -200, 0, 600, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 4])),
        (b"hmtx", be(&[600, 0, 600, 10, 500, 0, 300, 0])),
        (b"kern", be(&[0, 1, 0, 20, 1, 1, 6, 0, 0, 1, 2, -50])),
        (b"loca", be(&loca)),
        (b"maxp", be(&[1, 0, 4])),
    ];
    let mut out = be(&[1, 0, tables.len() as i32, 128, 3, 0]);
    let mut at = 12 + 16 * tables.len();
    for (name, data) in &tables {
        out.extend(*name);
        out.extend([0, at as u32, data.len() as u32].iter().flat_map(|x| x.to_be_bytes()));
        at += data.len().next_multiple_of(4);
    }
    for (_, mut data) in tables {
        data.resize(data.len().next_multiple_of(4), 0);
        out.extend(data);
    }
    out
}

fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let group = |c: &[u8]| {
        let n = c.iter().fold(0u32, |n, &b| n << 8 | u32::from(b)) << (8 * (3 - c.len()));
        (0..4).map(|k| if k > c.len() { '=' } else { char::from(DIGITS[(n >> (18 - 6 * k)) as usize & 63]) }).collect::<String>()
    };
    bytes.chunks(3).map(group).collect()
}

/// A scene of one triangle twice, as JSON with its buffer inside and as GLB.
fn gltf() -> Vec<Vec<u8>> {
    let floats = [0., 0., 0., 1., 0., 0., 0., 1., 0., 0., 0., 1., 0., 0., 1., 0., 0., 1., 0., 0., 1., 0., 0., 1f32];
    let picture = png(2, 2);
    let buffer = [floats.iter().flat_map(|f| f.to_le_bytes()).collect(), vec![0, 0, 1, 0, 2, 0, 0, 0], picture.clone()].concat();
    let json = |uri: &str, image: &str| {
        let text = GLTF.replace("{IMAGE}", &format!("{{{image}}}")).replace("PNG", &picture.len().to_string());
        text.replace("TOTAL URI", &format!("{}{uri}", buffer.len()))
    };
    let embedded = json(
        &format!(",\"uri\":\"data:application/octet-stream;base64,{}\"", base64(&buffer)),
        &format!("\"uri\":\"data:image/png;base64,{}\"", base64(&picture)),
    );
    let mut head = json("", "\"bufferView\":4,\"mimeType\":\"image/png\"").into_bytes();
    head.resize(head.len().next_multiple_of(4), b' ');
    let mut body = buffer;
    body.resize(body.len().next_multiple_of(4), 0);
    let word = |n: usize| (n as u32).to_le_bytes();
    let glb = [
        &b"glTF"[..],
        &word(2),
        &word(28 + head.len() + body.len()),
        &word(head.len()),
        b"JSON",
        &head,
        &word(body.len()),
        b"BIN\0",
        &body,
    ];
    vec![embedded.into_bytes(), glb.concat()]
}

/// A saved state as the program writes it.
fn states() -> Vec<Vec<u8>> {
    let path = std::env::temp_dir().join(format!("rayloom-seed-{}.rayloom-state", std::process::id()));
    let mut film = rayloom::film::Film::new(3, 2);
    film.samples[0] = 1;
    rayloom::film::state::save(&path, &film, "fuzz").expect("a small state");
    let bytes = std::fs::read(&path).expect("a small state");
    let _ = std::fs::remove_file(path);
    vec![bytes]
}

fn files_in(folder: &Path, out: &mut Vec<Vec<u8>>) {
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        if path.is_dir() {
            files_in(&path, out);
        } else if let Ok(bytes) = std::fs::read(&path)
            && bytes.len() < 20_000
        {
            out.push(bytes);
        }
    }
}

/// Whole inputs of a kind, made here.
pub fn whole(kind: Kind) -> Vec<Vec<u8>> {
    match kind {
        Kind::Scene => include_str!("seeds.txt").split("\n====\n").map(|s| s.as_bytes().to_vec()).collect(),
        Kind::Image => images(),
        Kind::Font => vec![font()],
        Kind::Density => vec![density()],
        Kind::Gltf => gltf(),
        Kind::Obj => vec![OBJ.into()],
        Kind::Ini => vec![INI.into()],
        Kind::Words => vec![WORDS.into()],
        Kind::State => states(),
    }
}

/// What the search for a kind starts from: whole inputs, the corpus, the scenes of the tests.
pub fn seeds(kind: Kind) -> Vec<Vec<u8>> {
    let mut all = whole(kind);
    files_in(&root().join("tests/corpus").join(kind.name()), &mut all);
    if kind == Kind::Scene {
        files_in(&root().join("tests/scenes"), &mut all);
    }
    all
}
