//! Files of pictures: POV-Ray's own values in every format (`tests/measured/film.txt`, written by `film.py` there), and what
//! happens to the old file when a new one cannot be written.

use rayloom::film::cryptomatte::{attributes, name_bits};
use rayloom::film::{
    DitherMethod, Encoding, FileFormat, FileGamma, Film, FilmError, Metadata, PixelSamples, check_writable, encode_picture, merge,
    read_exr, write_picture,
};
use rayloom::scene::settings::WorkingGamma;
use rayloom::scene::{Pass, PassSet};
use std::path::{Path, PathBuf};

const WIDTH: u32 = 8;
const HEIGHT: u32 = 5;

/// A film of opaque surfaces over a black background that lets through.
fn film_of(colours: &[[f32; 4]], width: u32, height: u32) -> Film {
    let mut film = Film::new(width, height);
    for (pixel, [r, g, b, t]) in film.pixels.iter_mut().zip(colours) {
        let opacity = 1.0 - t;
        *pixel = [r * opacity, g * opacity, b * opacity, *t];
    }
    film.samples.fill(1);
    film
}

fn working_gamma(version: &str, gamma: &str) -> WorkingGamma {
    match (version, gamma) {
        ("3.7", "none") | (_, "1.0") => WorkingGamma::Linear,
        (_, "none") => WorkingGamma::None,
        (_, "srgb") => WorkingGamma::Srgb,
        (_, power) => WorkingGamma::Power(power.parse().expect("a number")),
    }
}

fn job(version: &str, gamma: &str, options: &[&str]) -> (FileFormat, Encoding) {
    let mut encoding = Encoding { working: working_gamma(version, gamma), ..Encoding::default() };
    let mut format = None;
    for option in options {
        if let Some(kind) = option.strip_prefix("+F") {
            let (letter, rest) = kind.split_at(1);
            let (grayscale, bits) = (rest == "g", rest.parse().unwrap_or(8));
            format = Some(match letter {
                "N" => FileFormat::Png { bits, grayscale },
                "T" => FileFormat::Targa { rle: false },
                "B" => FileFormat::Bmp,
                "P" => FileFormat::Ppm { bits, grayscale },
                "H" => FileFormat::Hdr,
                "E" => FileFormat::Exr,
                other => panic!("no format {other}"),
            });
        } else if let Some(gamma) = option.strip_prefix("File_Gamma=") {
            encoding.file_gamma = gamma.parse().map_or(FileGamma::Srgb, FileGamma::Power);
        } else {
            match option.split_at(3) {
                ("+UA", _) => encoding.alpha = true,
                ("+TH", method) => encoding.dither = Some(DitherMethod::named(method).unwrap_or_default()),
                _ => panic!("no option {option}"),
            }
        }
    }
    (format.expect("a format"), encoding)
}

/// The values of a file in the order that `film.py` gives them.
fn values(bytes: &[u8], format: FileFormat) -> Vec<f64> {
    let (w, h) = (WIDTH as usize, HEIGHT as usize);
    let widened = |b: &[u8]| b.iter().map(|v| f64::from(*v)).collect::<Vec<_>>();
    let words = |b: &[u8]| b.chunks(2).map(|v| f64::from(u16::from_be_bytes([v[0], v[1]]))).collect::<Vec<_>>();
    let rgb = |b: &[u8], n: usize| -> Vec<f64> {
        b.chunks(n).flat_map(|p| [p[2], p[1], p[0]].into_iter().chain(p.get(3).copied())).map(f64::from).collect()
    };
    match format {
        FileFormat::Png { .. } => {
            let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().expect("a PNG");
            let mut out = vec![0; reader.output_buffer_size().expect("a size")];
            let info = reader.next_frame(&mut out).expect("pixels");
            out.truncate(info.buffer_size());
            if info.bit_depth == png::BitDepth::Sixteen { words(&out) } else { widened(&out) }
        }
        FileFormat::Targa { .. } => {
            let n = usize::from(bytes[16] / 8);
            rgb(&bytes[18..18 + w * h * n], n)
        }
        FileFormat::Bmp => {
            let n = usize::from(bytes[28] / 8);
            bytes[54..].chunks(w * n).rev().flat_map(|row| rgb(row, n)).collect()
        }
        FileFormat::Ppm { bits, .. } => {
            let n = w * h * 3;
            if bits > 8 { words(&bytes[bytes.len() - 2 * n..]) } else { widened(&bytes[bytes.len() - n..]) }
        }
        FileFormat::Hdr => {
            let image = image::load_from_memory_with_format(bytes, image::ImageFormat::Hdr).expect("a Radiance file");
            image.to_rgb32f().into_raw().into_iter().map(f64::from).collect()
        }
        FileFormat::Exr => {
            let dir = tempfile::tempdir().expect("a folder");
            let path = dir.path().join("a.exr");
            std::fs::write(&path, bytes).expect("written");
            let part = read_exr(&path, 1000).expect("an EXR");
            let n = if part.alpha { 4 } else { 3 };
            part.film.pixels.iter().flat_map(|p| [p[0], p[1], p[2], 1.0 - p[3]].into_iter().take(n)).map(f64::from).collect()
        }
        FileFormat::Jpeg { .. } => unreachable!("JPEG is lossy and has no exact values"),
    }
}

#[test]
fn every_format_holds_povrays_values() {
    let text = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/measured/film.txt")).expect("measured values");
    let lines = || text.lines().filter(|l| !l.starts_with('#')).map(|l| l.split_once(": ").expect("key: values"));
    let numbers = |s: &str| s.split_whitespace().map(|v| v.parse::<f64>().expect("a number")).collect::<Vec<_>>();
    let colours: Vec<[f32; 4]> =
        lines().filter(|(key, _)| *key == "colour").map(|(_, v)| std::array::from_fn(|c| numbers(v)[c] as f32)).collect();
    let film = film_of(&colours, WIDTH, HEIGHT);
    let (mut n_cases, mut wrong) = (0, Vec::new());
    for (key, theirs) in lines().filter(|(key, _)| *key != "colour") {
        let words: Vec<&str> = key.split(' ').collect();
        let (format, encoding) = job(words[0], words[1], &words[2..]);
        let ours = values(&encode_picture(&film, &format, &encoding, &Metadata::default()).expect("encoded"), format);
        let theirs = numbers(theirs);
        assert_eq!(ours.len(), theirs.len(), "{key}: number of values");
        // POV-Ray's EXR has half floats, ours single ones.
        let near = |a: f64, b: f64| if format == FileFormat::Exr { (a - b).abs() <= b.abs() / 2048.0 + 3e-8 } else { a == b };
        for (i, (a, b)) in ours.iter().zip(&theirs).enumerate() {
            if !near(*a, *b) {
                wrong.push(format!("{key}: value {i} is {a}, POV-Ray's {b}"));
            }
        }
        n_cases += 1;
    }
    assert!(n_cases > 70, "{n_cases} cases");
    assert!(wrong.is_empty(), "{} values:\n{}", wrong.len(), wrong[..wrong.len().min(40)].join("\n"));
}

#[test]
fn a_ramp_follows_the_exact_srgb_formula() {
    let colours: Vec<[f32; 4]> = (0..64).map(|i| [i as f32 / 63.0; 3]).map(|[r, g, b]| [r, g, b, 0.0]).collect();
    let film = film_of(&colours, 64, 1);
    let bytes = encode_picture(&film, &FileFormat::Ppm { bits: 16, grayscale: false }, &Encoding::default(), &Metadata::default());
    let bytes = bytes.expect("encoded");
    for (i, pixel) in bytes[bytes.len() - 64 * 6..].chunks(6).enumerate() {
        let light = i as f64 / 63.0;
        let srgb = if light <= 0.0031308 { 12.92 * light } else { 1.055 * light.powf(1.0 / 2.4) - 0.055 };
        let ours = f64::from(u16::from_be_bytes([pixel[0], pixel[1]]));
        assert!((ours - 65535.0 * srgb).abs() <= 0.51, "step {i}: {ours}, {}", 65535.0 * srgb);
    }
}

#[test]
fn pngs_say_which_gamma_and_how_many_bits_they_hold() {
    let film = film_of(&[[0.5, 0.5, 0.5, 0.0]], 1, 1);
    let metadata = Metadata {
        software: "rayloom".into(),
        scene: "naïve 木.pov".into(),
        entries: vec![("seed".into(), "7".into())],
        ..Metadata::default()
    };
    let chunks = |encoding: &Encoding, bits: u8| {
        let bytes = encode_picture(&film, &FileFormat::Png { bits, grayscale: false }, encoding, &metadata).expect("encoded");
        let reader = png::Decoder::new(std::io::Cursor::new(&bytes)).read_info().expect("a PNG");
        let info = reader.info();
        let texts = info.uncompressed_latin1_text.len() + info.utf8_text.len();
        assert_eq!(texts, 3, "software, scene and seed");
        let at = bytes.windows(4).position(|w| w == b"gAMA").expect("a gAMA chunk") + 4;
        let gamma = bytes[at..at + 4].iter().fold(0u32, |v, b| v << 8 | u32::from(*b));
        (gamma, info.srgb.is_some(), info.sbit.as_ref().map(|s| s.to_vec()))
    };
    let encoding = |working, file_gamma| Encoding { working, file_gamma, ..Encoding::default() };
    assert_eq!(chunks(&encoding(WorkingGamma::Linear, FileGamma::Srgb), 8), (45455, true, Some(vec![8; 3])));
    assert_eq!(chunks(&encoding(WorkingGamma::Linear, FileGamma::Power(1.0)), 16), (100_000, false, Some(vec![16; 3])));
    assert_eq!(chunks(&encoding(WorkingGamma::Linear, FileGamma::Power(2.5)), 5), (40_000, false, Some(vec![5; 3])));
    assert_eq!(chunks(&encoding(WorkingGamma::None, FileGamma::Power(2.5)), 8), (45455, true, Some(vec![8; 3])), "told as sRGB");
}

#[test]
fn every_format_is_read_back_by_an_independent_decoder() {
    let colours: Vec<[f32; 4]> =
        (0..600).map(|i| [(i % 30) as f32 / 29.0, (i / 30) as f32 / 19.0, ((i / 7) % 3) as f32 / 2.0, 0.0]).collect();
    let film = film_of(&colours, 30, 20);
    let decode = |format: FileFormat, kind: image::ImageFormat| {
        let bytes = encode_picture(&film, &format, &Encoding::default(), &Metadata::default()).expect("encoded");
        image::load_from_memory_with_format(&bytes, kind).expect("decoded").to_rgb8()
    };
    let png = decode(FileFormat::Png { bits: 8, grayscale: false }, image::ImageFormat::Png);
    assert_eq!(png.get_pixel(29, 0).0, [255, 0, 127 + 61], "row-major, top row first, sRGB");
    assert_eq!(decode(FileFormat::Targa { rle: false }, image::ImageFormat::Tga), png);
    assert_eq!(decode(FileFormat::Targa { rle: true }, image::ImageFormat::Tga), png);
    assert_eq!(decode(FileFormat::Bmp, image::ImageFormat::Bmp), png);
    assert_eq!(decode(FileFormat::Ppm { bits: 8, grayscale: false }, image::ImageFormat::Pnm), png);
    let jpeg = decode(FileFormat::Jpeg { quality: 100 }, image::ImageFormat::Jpeg);
    let worst = png.as_raw().iter().zip(jpeg.as_raw()).map(|(a, b)| a.abs_diff(*b)).max();
    assert!(worst <= Some(6), "JPEG of best quality is off by {worst:?}");
    let grey = FileFormat::Ppm { bits: 8, grayscale: true };
    let bytes = encode_picture(&film, &grey, &Encoding::default(), &Metadata::default()).expect("encoded");
    let grey = image::load_from_memory_with_format(&bytes, image::ImageFormat::Pnm).expect("a PGM").to_luma8();
    // 0.297 r + 0.589 g + 0.114 b of the light, then sRGB: row 0, column 29 is (1, 0, 0.5).
    assert_eq!(grey.get_pixel(29, 0).0, [(255.0 * (1.055 * f64::powf(0.354, 1.0 / 2.4) - 0.055) + 0.5) as u8]);
}

/// A film whose pixels of columns `from..to` hold `value` with `samples`.
fn part(from: u32, to: u32, value: f32, samples: u32) -> Film {
    let mut film = Film::new(6, 4);
    for y in 1..4 {
        for x in from..to {
            let i = film.index(x, y);
            film.pixels[i] = [value, 2.0 * value, 4.0, 0.5];
            film.samples[i] = samples;
        }
    }
    film
}

fn write_exr(path: &Path, film: &Film, range: &str, scene: &str) {
    let entries = [("samples", range), ("seed", "0"), ("camera.location", "1 2 3")].map(|(k, v)| (k.to_owned(), v.to_owned())).to_vec();
    let metadata = Metadata { software: "rayloom".into(), scene: scene.into(), entries, ..Metadata::default() };
    write_picture(path, film, &FileFormat::Exr, &Encoding { alpha: true, ..Encoding::default() }, &metadata).expect("written");
}

#[test]
fn merge_weights_by_samples_and_keeps_crops_in_place() {
    let dir = tempfile::tempdir().expect("a folder");
    let path = |name: &str| dir.path().join(name);
    write_exr(&path("a.exr"), &part(0, 4, 1.0, 3), "0..3", "s.pov");
    write_exr(&path("b.exr"), &part(2, 6, 5.0, 1), "3..4", "s.pov");
    let whole = merge(&[path("a.exr"), path("b.exr")], 1000).expect("merged");
    let at = |x: u32, y: u32| (whole.film.pixels[whole.film.index(x, y)], whole.film.samples[whole.film.index(x, y)]);
    assert_eq!(at(0, 1), ([1.0, 2.0, 4.0, 0.5], 3));
    assert_eq!(at(2, 1), ([2.0, 4.0, 4.0, 0.5], 4), "(3 x 1 + 1 x 5) / 4");
    assert_eq!(at(5, 3), ([5.0, 10.0, 4.0, 0.5], 1));
    assert_eq!(at(3, 0).1, 0, "in no part");
    assert!(whole.metadata.entries.contains(&("samples".into(), "0..4".into())));
}

#[test]
fn passes_are_written_under_blenders_names_and_merge() {
    let dir = tempfile::tempdir().expect("a folder");
    let path = |name: &str| dir.path().join(name);
    let passes: PassSet = [Pass::Depth, Pass::DiffuseDirect, Pass::CryptoObject, Pass::Variance].into_iter().collect();
    let part = |depth: f32, color: f32, light: f32, n: u32| {
        let mut film = Film::with_passes(6, 4, passes);
        let crypto = [f32::from_bits(name_bits("A")), 0.75, f32::from_bits(name_bits("B")), 0.25];
        let layers: Vec<f32> =
            [depth, light, light, light, color, color, color].into_iter().chain(crypto).chain([0.0; 8]).chain([1.0; 3]).collect();
        film.join(7, PixelSamples { color: [light, light, light, 0.0], layers: &layers, n, earlier: false });
        film
    };
    let manifest = attributes("ViewLayer.CryptoObject", ["A", "B"]);
    let write = |name: &str, film: &Film, range: &str| {
        let metadata = Metadata { entries: vec![("samples".into(), range.into())], attributes: manifest.clone(), ..Metadata::default() };
        write_picture(&path(name), film, &FileFormat::Exr, &Encoding::default(), &metadata).expect("written");
    };
    let (a, b) = (part(3.0, 0.5, 0.2, 1), part(9.0, 0.3, 0.6, 3));
    write("a.exr", &a, "0..1");
    write("b.exr", &b, "1..4");
    let raw = exr::prelude::read_first_flat_layer_from_file(path("a.exr")).expect("an EXR").layer_data;
    let channel =
        |name: &str| raw.channel_data.list.iter().find(|c| c.name.eq(name)).map(|c| c.sample_data.value_by_flat_index(0).to_f32());
    assert_eq!(channel("ViewLayer.DiffDir.G"), Some(0.4), "divided by the colour");
    assert_eq!(channel("ViewLayer.Combined.A"), Some(1.0));
    assert_eq!(channel("ViewLayer.Depth.Z"), Some(3.0));
    assert_eq!(channel("ViewLayer.CryptoObject00.r").map(f32::to_bits), Some(name_bits("A")));
    let back = read_exr(&path("a.exr"), 1000).expect("read");
    assert_eq!((back.film.layers, back.alpha, back.metadata.attributes), (a.layers, false, manifest.clone()));
    // The later part first: values of the first sample are those of the earlier one all the same.
    let whole = merge(&[path("b.exr"), path("a.exr")], 1000).expect("merged").film;
    let at = |p: Pass| whole.layer(p).expect("it is there").at(7).to_vec();
    assert_eq!(whole.samples[7], 4);
    assert_eq!(at(Pass::Depth), [3.0]);
    assert!((at(Pass::DiffuseDirect)[0] - 0.5).abs() < 1e-6 && (at(Pass::DiffuseColor)[0] - 0.35).abs() < 1e-6);
    assert_eq!(at(Pass::CryptoObject)[..4], [f32::from_bits(name_bits("A")), 0.75, f32::from_bits(name_bits("B")), 0.25]);
    // One sample of 0.2 and three of mean 0.6 and variance 1: (0 + 2 + 0.16 * 3 / 4) / 3.
    assert!((at(Pass::Variance)[0] - 2.12 / 3.0).abs() < 1e-5, "{:?}", at(Pass::Variance));
    write_exr(&path("plain.exr"), &Film { samples: vec![1; 24], ..Film::new(6, 4) }, "9..10", "");
    let error = merge(&[path("a.exr"), path("plain.exr")], 1000).expect_err("refused").to_string();
    assert!(error.contains("alpha") || error.contains("passes"), "{error}");
}

#[test]
fn parts_that_do_not_belong_together_are_refused() {
    let dir = tempfile::tempdir().expect("a folder");
    let path = |name: &str| dir.path().join(name);
    let refused = |name: &str| {
        let error = merge(&[path("a.exr"), path(name)], 1000).expect_err("refused");
        assert!(matches!(error, FilmError::Foreign { .. }), "{error}");
        error.to_string()
    };
    write_exr(&path("a.exr"), &part(0, 4, 1.0, 3), "0..3", "s.pov");
    write_exr(&path("twice.exr"), &part(3, 6, 1.0, 3), "2..5", "s.pov");
    write_exr(&path("scene.exr"), &part(4, 6, 1.0, 3), "0..3", "other.pov");
    write_exr(&path("size.exr"), &Film { width: 4, height: 6, ..part(0, 4, 1.0, 3) }, "3..6", "s.pov");
    assert!(refused("twice.exr").contains("overlap"));
    assert!(refused("scene.exr").contains("other.pov"));
    assert!(refused("size.exr").contains("4 by 6"));
    std::fs::write(path("cut.exr"), &std::fs::read(path("a.exr")).expect("bytes")[..200]).expect("written");
    refused("cut.exr");
    assert!(merge(&[path("a.exr")], 23).expect_err("24 pixels").to_string().contains("limit"));
    // Crops side by side may hold the same range.
    write_exr(&path("right.exr"), &part(4, 6, 1.0, 3), "0..3", "s.pov");
    assert!(merge(&[path("a.exr"), path("right.exr")], 1000).is_ok());
}

#[test]
fn a_failed_write_leaves_the_old_file() {
    let dir = tempfile::tempdir().expect("a folder");
    let path = dir.path().join("old.tga");
    std::fs::write(&path, "old").expect("written");
    let too_wide = Film::new(70_000, 1);
    let format = FileFormat::Targa { rle: false };
    assert!(matches!(write_picture(&path, &too_wide, &format, &Encoding::default(), &Metadata::default()), Err(FilmError::Unfit { .. })));
    assert_eq!(std::fs::read(&path).expect("there"), b"old");
    write_picture(&path, &Film::new(2, 1), &format, &Encoding::default(), &Metadata::default()).expect("written");
    assert_ne!(std::fs::read(&path).expect("there"), b"old");
    let left: Vec<PathBuf> = std::fs::read_dir(dir.path()).expect("a folder").map(|e| e.expect("an entry").path()).collect();
    assert_eq!(left, [path], "nothing is left beside it");
}

/// Every byte of `/dev/full` is refused as on a full disk.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_an_error() {
    let error = write_picture(Path::new("/dev/full"), &Film::new(2, 1), &FileFormat::Bmp, &Encoding::default(), &Metadata::default());
    assert!(matches!(error, Err(FilmError::Io { verb: "write", .. })), "{error:?}");
}

#[cfg(unix)]
#[test]
fn a_link_stays_a_link_and_what_it_points_to_is_replaced() {
    let dir = tempfile::tempdir().expect("a folder");
    let (file, link) = (dir.path().join("a.bmp"), dir.path().join("b.bmp"));
    std::fs::write(&file, "old").expect("written");
    std::os::unix::fs::symlink(&file, &link).expect("a link");
    write_picture(&link, &Film::new(2, 1), &FileFormat::Bmp, &Encoding::default(), &Metadata::default()).expect("written");
    assert!(link.is_symlink());
    assert!(std::fs::read(&file).expect("there").starts_with(b"BM"));
}

#[test]
fn unwritable_places_are_found_before_the_first_ray() {
    let dir = tempfile::tempdir().expect("a folder");
    assert!(check_writable(&dir.path().join("new.png")).is_ok());
    assert!(check_writable(Path::new("new.png")).is_ok(), "the current folder");
    let message = |p: &Path| check_writable(p).expect_err("refused").to_string();
    assert!(message(dir.path()).contains("folder"));
    assert!(message(&dir.path().join("missing/new.png")).contains("missing/new.png"));
    let file = dir.path().join("file.png");
    std::fs::write(&file, "").expect("written");
    assert!(check_writable(&file.join("new.png")).is_err(), "a file is no folder");
    let mut permissions = file.metadata().expect("there").permissions();
    permissions.set_readonly(true);
    std::fs::set_permissions(&file, permissions).expect("set");
    assert!(message(&file).contains("read-only"));
    assert_eq!(std::fs::read_dir(dir.path()).expect("a folder").count(), 1, "asking leaves nothing behind");
}
