//! Distances between pictures: answers worked out by hand, FLIP against its reference tool, and faults that must be caught.

use rayloom::compare::{
    CompareOptions, Flip, Metrics, Picture, PictureError, Space, Tolerance, Verdict, compare, difference_map, flip_map,
};
use rayloom::film::{Encoding, FileFormat, Film, Metadata, write_picture};

const NO_FLIP: CompareOptions = CompareOptions { space: Space::Auto, exposure: 0.0, flip: Flip::None, ssim: false, mask: None };

fn picture(width: u32, height: u32, pixel: impl Fn(u32, u32) -> [f32; 3]) -> Picture {
    let pixels = (0..width * height).map(|i| pixel(i % width, i / width)).map(|[r, g, b]| [r, g, b, 1.0]).collect();
    Picture { width, height, pixels, has_alpha: false, linear: false, depth: "8-bit sRGB".into() }
}

fn metrics(a: &Picture, b: &Picture) -> Metrics {
    compare(a.clone(), b.clone(), &NO_FLIP).expect("one size")
}

fn bytes(v: [u32; 3]) -> [f32; 3] {
    v.map(|c| (c % 256) as f32 / 255.0)
}

/// A busy picture without repeats.
fn busy() -> Picture {
    picture(64, 48, |x, y| bytes([x * 4, y * 5, x * y]))
}

#[test]
fn equal_pictures_are_no_distance_apart() {
    let m = compare(busy(), busy(), &CompareOptions::default()).expect("one size");
    assert_eq!((m.rmse, m.psnr(), m.mean_absolute, m.n_different, m.largest.value), (0.0, f64::INFINITY, 0.0, 0, 0.0));
    assert_eq!(m.flip.as_ref().map(|f| f.1), Some(0.0));
    assert_eq!(Tolerance::default().judge(&m), (Verdict::Same, vec![]));
}

#[test]
fn rmse_and_psnr_are_those_of_the_formula() {
    // Two of eight pixels differ: one by 0.5 in red, one by 0.25 in green. Sum of squares 0.3125 over 24 values.
    let a = picture(4, 2, |_, _| [0.25; 3]);
    let b = picture(4, 2, |x, y| match (x, y) {
        (1, 0) => [0.75, 0.25, 0.25],
        (3, 1) => [0.25, 0.5, 0.25],
        _ => [0.25; 3],
    });
    let m = metrics(&a, &b);
    assert!((m.rmse - (0.3125f64 / 24.0).sqrt()).abs() < 1e-12);
    assert!((m.psnr() - 10.0 * (24.0f64 / 0.3125).log10()).abs() < 1e-9);
    assert!((m.mean_absolute - 0.75 / 24.0).abs() < 1e-12);
    assert!((m.rmse_of_channel[0] - (0.25f64 / 8.0).sqrt()).abs() < 1e-12);
    assert_eq!((m.largest.value, m.largest.at, m.largest.channel), (0.5, [1, 0], 0));
    assert_eq!((m.n_different, m.n_beyond(0.25), m.n_beyond(0.24)), (2, 1, 2));
}

#[test]
fn flip_gives_the_reference_tools_values() {
    // Means of flip_evaluator 1.7 (its maps summed in double precision), at its default 67.02 pixels per degree.
    let flip = |a: Picture, b: Picture| compare(a, b, &CompareOptions::default()).expect("one size").flip.expect("defined").1;
    let other = picture(64, 48, |x, y| bytes([x * 4 + y / 2, y * 5 + if x % 16 < 8 { 8 } else { 0 }, x * y + 3 * x]));
    let shifted = picture(64, 48, |x, y| bytes([(x + 63) % 64 * 4, y * 5, (x + 63) % 64 * y]));
    let flat = |v: f32| picture(64, 48, move |_, _| [v; 3]);
    for (ours, theirs) in
        [(flip(busy(), other), 0.298_515_795_67), (flip(busy(), shifted), 0.149_774_489_46), (flip(flat(0.0), flat(1.0)), 0.967_388_331_89)]
    {
        assert!((ours - theirs).abs() < 2e-6, "{ours}, the reference tool gives {theirs}");
    }
}

#[test]
fn every_small_fault_is_caught() {
    let caught = |b: &Picture| Tolerance::default().judge(&metrics(&busy(), b)).0 == Verdict::Different;
    assert!(!caught(&busy()));
    let mut one = busy();
    one.pixels[777][2] += 1.0 / 65535.0;
    assert!(caught(&one), "one step of 16 bits in one channel of one pixel");
    let mut swapped = busy();
    swapped.pixels.iter_mut().for_each(|p| p.swap(0, 2));
    assert!(caught(&swapped), "red and blue");
    let mut shifted = busy();
    shifted.pixels.rotate_right(1);
    assert!(caught(&shifted), "by a pixel");
    for value in [f32::NAN, f32::INFINITY] {
        let mut bad = busy();
        bad.pixels[5][1] = value;
        let anything = Tolerance { fail: 1.0, percent: 100.0, ..Tolerance::default() };
        assert_eq!(anything.judge(&metrics(&busy(), &bad)).0, Verdict::Different, "{value}");
        assert_eq!(anything.judge(&metrics(&bad, &bad)).0, Verdict::Different, "{value} in both");
        assert_eq!(metrics(&busy(), &bad).non_finite, [0, 1]);
    }
    assert!(compare(busy(), picture(48, 64, |_, _| [0.0; 3]), &NO_FLIP).is_none(), "sizes");
}

#[test]
fn tolerances_allow_what_they_say_and_no_more() {
    let mut other = busy();
    for p in &mut other.pixels[..31] {
        p[0] += 2.0 / 255.0;
    }
    let m = metrics(&busy(), &other);
    let judge = |t: Tolerance| t.judge(&m).0;
    let plain = Tolerance::default();
    // 31 of 3072 pixels are 1.009 %.
    assert_eq!(judge(Tolerance { fail: 2.0 / 255.0, ..plain }), Verdict::Same, "2/255 is not more than 2/255");
    assert_eq!(judge(Tolerance { fail: 1.9 / 255.0, percent: 1.0, ..plain }), Verdict::Different);
    assert_eq!(judge(Tolerance { fail: 1.9 / 255.0, percent: 1.1, ..plain }), Verdict::Same);
    assert_eq!(judge(Tolerance { fail: 1.0, warn: Some(0.001), ..plain }), Verdict::Warn);
    assert_eq!(judge(Tolerance { fail: 1.0, warn: Some(0.001), warn_percent: 2.0, ..plain }), Verdict::Same);
    assert_eq!(judge(Tolerance { fail: 1.0, hard_fail: Some(0.005), ..plain }), Verdict::Different);
    assert_eq!(judge(Tolerance { fail: 1.0, min_psnr: Some(m.psnr() + 0.1), ..plain }), Verdict::Different);
    assert_eq!(judge(Tolerance { fail: 1.0, min_psnr: Some(m.psnr() - 0.1), ..plain }), Verdict::Same);
    assert_eq!(judge(Tolerance { fail: 1.0, max_flip: Some(1.0), ..plain }), Verdict::Different, "FLIP asked for and not there");
}

#[test]
fn alpha_counts_when_both_have_it() {
    let with_alpha = |a: f32| Picture { has_alpha: true, pixels: vec![[0.0, 0.0, 0.0, a]; 4], ..picture(2, 2, |_, _| [0.0; 3]) };
    let m = metrics(&with_alpha(0.5), &with_alpha(0.75));
    assert_eq!((m.largest.value, m.largest.channel), (0.25, 3));
    assert!((m.rmse - 0.125).abs() < 1e-12, "a fourth of the values is 0.25 apart");
    assert_eq!(metrics(&with_alpha(0.5), &picture(2, 2, |_, _| [0.0; 3])).largest.value, 0.0);
}

#[test]
fn heat_maps_are_black_where_pictures_agree_and_green_where_there_is_no_number() {
    let mut other = busy();
    other.pixels[1] = [1.0 - busy().pixels[1][0], 1.0, 0.0, 1.0];
    other.pixels[2][0] = f32::NAN;
    let map = difference_map(&metrics(&busy(), &other), 64, 48);
    assert_eq!((map.get_pixel(0, 0).0, map.get_pixel(2, 0).0), ([0, 0, 4], [0, 255, 0]));
    assert!(map.get_pixel(1, 0).0[0] > 200);
    let m = compare(busy(), busy(), &CompareOptions::default()).expect("one size");
    assert!(flip_map(&m).expect("a map").pixels().all(|p| p.0 == [0, 0, 4]));
    assert!(flip_map(&metrics(&busy(), &busy())).is_none());
}

#[test]
fn one_film_is_the_same_picture_in_every_format() {
    let dir = tempfile::tempdir().expect("a folder");
    let mut film = Film::new(40, 30);
    for (i, p) in film.pixels.iter_mut().enumerate() {
        let opacity = 1.0 - (i % 5) as f32 / 5.0;
        *p = [(i % 40) as f32 / 39.0 * opacity, (i / 40) as f32 / 29.0 * opacity, 0.2 * opacity, 1.0 - opacity];
    }
    film.samples.fill(1);
    let read = |name: &str, bits: u8, alpha: bool| {
        let path = dir.path().join(name);
        let format = match FileFormat::from_path(&path).expect("a format") {
            FileFormat::Png { .. } => FileFormat::Png { bits, grayscale: false },
            other => other,
        };
        let encoding = Encoding { alpha, ..Encoding::default() };
        write_picture(&path, &film, &format, &encoding, &Metadata::default()).expect("written");
        Picture::read(&path, 10_000).expect("read")
    };
    let exr = read("a.exr", 8, true);
    assert!(exr.linear && exr.has_alpha);
    // Straight 8-bit colours over black lose up to half a step, and alpha half a step of its own.
    for (name, bits, alpha, slack) in [
        ("deep.png", 16, true, 2e-5),
        ("deep.png", 16, false, 1e-5),
        ("a.png", 8, true, 4.5e-3),
        ("a.png", 8, false, 2e-3),
        ("a.tga", 8, true, 4.5e-3),
        ("a.bmp", 8, false, 2e-3),
        ("a.ppm", 8, false, 2e-3),
    ] {
        let m = metrics(&exr, &read(name, bits, alpha));
        assert!(m.largest.value < slack && !m.linear, "{name}, alpha {alpha}: {:?}", m.largest);
        assert_eq!(m.alpha, alpha, "{name}");
    }
    let hdr = metrics(&exr, &read("a.hdr", 8, false));
    assert!(hdr.linear && hdr.largest.value < 1.0 / 128.0, "{:?}", hdr.largest);
}

#[test]
fn unreadable_and_oversized_files_are_named() {
    let dir = tempfile::tempdir().expect("a folder");
    let path = |name: &str| dir.path().join(name);
    let film = Film { samples: vec![1; 100], ..Film::new(10, 10) };
    for name in ["a.png", "a.exr", "a.tga", "a.hdr", "a.jpg", "a.bmp", "a.ppm"] {
        let format = FileFormat::from_path(&path(name)).expect("a format");
        write_picture(&path(name), &film, &format, &Encoding::default(), &Metadata::default()).expect("written");
        let error = Picture::read(&path(name), 99).expect_err("100 pixels").to_string();
        assert!(error.contains(name) && error.contains("limit of 99"), "{error}");
        let whole = std::fs::read(path(name)).expect("bytes");
        std::fs::write(path(name), &whole[..20]).expect("written");
        let error = Picture::read(&path(name), 1000).expect_err("cut off").to_string();
        assert!(error.contains(name), "{error}");
    }
    assert!(matches!(Picture::read(&path("none.png"), 99), Err(PictureError::Io { .. })));
    assert!(matches!(Picture::read(dir.path(), 99), Err(PictureError::Io { .. })));
    std::fs::write(path("text.png"), "no picture").expect("written");
    assert!(matches!(Picture::read(&path("text.png"), 99), Err(PictureError::Decode { .. })));
}

/// NVIDIA's flip-evaluator, OpenImageIO and scikit-image say the same of twenty pairs, to four digits. `tests/metrics/make.py` asked them;
/// `expected.json` says which versions.
#[test]
fn other_programs_measure_the_same() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/metrics");
    let text = std::fs::read_to_string(folder.join("expected.json")).expect("readable");
    let expected: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let pairs = expected["pairs"].as_array().expect("a list");
    assert_eq!(pairs.len(), 20);
    let (mut n, mut wrong) = (0, Vec::new());
    for pair in pairs {
        let read = |side: &str| {
            let path = folder.join("pairs").join(pair[side].as_str().expect("a name"));
            Picture::read(&path, 1 << 20).expect("a picture")
        };
        let of = |flip: Flip| {
            compare(read("a"), read("b"), &CompareOptions { flip, ssim: true, ..CompareOptions::default() }).expect("one size")
        };
        let (m, hdr) = (of(Flip::Ldr), of(Flip::Hdr));
        let mean = |m: &Metrics| m.flip.as_ref().map(|f| f.1);
        let ours = [
            ("mean_absolute", Some(m.mean_absolute)),
            ("rmse", Some(m.rmse)),
            ("largest", Some(m.largest.value)),
            ("psnr_db", Some(m.psnr())),
            ("ssim", m.ssim),
            ("flip", mean(&m)),
            ("flip_hdr", mean(&hdr)),
        ];
        for (name, ours) in ours {
            let Some(theirs) = pair[name].as_f64() else { continue };
            n += 1;
            // Four digits: of the number, or behind the point where it is nearly nothing.
            if !ours.is_some_and(|v| (v - theirs).abs() <= 5e-5 * theirs.abs().max(0.1)) {
                wrong.push(format!("{} ({}): {name} is {ours:?}, {theirs} there", pair["a"], pair["change"]));
            }
        }
    }
    assert!(wrong.is_empty() && n == 109, "{n} numbers, {} wrong:\n{}", wrong.len(), wrong.join("\n"));
}
