//! `rayloom diff` and `rayloom merge` as a user runs them: exit codes, reports, maps.

use image::RgbImage;
use std::path::Path;
use std::process::{Command, Output};

fn rayloom(folder: &Path, args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_rayloom")).args(args).current_dir(folder).output().expect("rayloom runs")
}

fn code(output: &Output) -> i32 {
    output.status.code().expect("it ended by itself")
}

fn stdout(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// a.png, b.png with 5 of 1200 pixels a little off, and small.png.
fn folder() -> tempfile::TempDir {
    let dir = tempfile::tempdir().expect("a folder");
    let a = RgbImage::from_fn(40, 30, |x, y| image::Rgb([(x * 6) as u8, (y * 8) as u8, 77]));
    let mut b = a.clone();
    for x in 0..5 {
        b.get_pixel_mut(x, 3).0[1] += 2;
    }
    b.get_pixel_mut(4, 3).0[2] += 3;
    a.save(dir.path().join("a.png")).expect("saved");
    b.save(dir.path().join("b.png")).expect("saved");
    RgbImage::new(39, 30).save(dir.path().join("small.png")).expect("saved");
    dir
}

#[test]
fn exit_codes_say_same_warn_different_and_unreadable() {
    let dir = folder();
    let run = |args: &[&str]| code(&rayloom(dir.path(), &[&["diff"], args].concat()));
    assert_eq!(run(&["a.png", "a.png"]), 0);
    assert_eq!(run(&["a.png", "b.png"]), 2);
    assert_eq!(run(&["a.png", "b.png", "--fail", "3/255"]), 0);
    assert_eq!(run(&["a.png", "b.png", "--fail", "2/255"]), 2);
    assert_eq!(run(&["a.png", "b.png", "--fail", "0.005", "--percent", "0.5"]), 0);
    assert_eq!(run(&["a.png", "b.png", "--fail", "0.005", "--percent", "0.4"]), 2);
    assert_eq!(run(&["a.png", "b.png", "--fail", "0.005", "--percent", "1", "--hard-fail", "2/255"]), 2);
    assert_eq!(run(&["a.png", "b.png", "--fail", "1", "--warn", "1/255"]), 1);
    assert_eq!(run(&["a.png", "b.png", "--fail", "1", "--max-flip", "0"]), 2);
    assert_eq!(run(&["a.png", "small.png", "--fail", "1", "--percent", "100"]), 2);
    assert_eq!(run(&["a.png", "missing.png"]), 4);
    assert_eq!(run(&["a.png", "a.png", "--max-pixels", "1199"]), 4);
    assert_eq!(run(&["a.png", "a.png", "--heatmap", "missing/where.png"]), 4);
    assert_eq!(run(&["a.png", "b.png", "--fail", "much"]), 2, "usage");
}

#[test]
fn the_report_and_its_json_have_the_numbers() {
    let dir = folder();
    let text = stdout(&rayloom(dir.path(), &["diff", "a.png", "b.png", "--heatmap", "where.png"]));
    for part in ["differing            5 of 1200 pixels (0.4167 %)", "(3.00/255) in blue at column 4, row 3", "verdict: different"] {
        assert!(text.contains(part), "no {part:?} in\n{text}");
    }
    let map = image::open(dir.path().join("where.png")).expect("a heat map").to_rgb8();
    assert_eq!(map.enumerate_pixels().filter(|(_, _, p)| p.0 != [0, 0, 4]).map(|(x, y, _)| (x, y)).max(), Some((4, 3)));
    let json: serde_json::Value = serde_json::from_slice(&rayloom(dir.path(), &["diff", "a.png", "b.png", "--json"]).stdout).expect("JSON");
    assert_eq!((&json["verdict"], &json["metrics"]["differing"]), (&"different".into(), &5.into()));
    // Five squares of 2 and one of 3, of 3600 values.
    let rmse = (29.0f64 / 3600.0).sqrt() / 255.0;
    assert!((json["metrics"]["rmse"].as_f64().expect("a number") - rmse).abs() < 1e-9);
    assert!((json["metrics"]["psnr_db"].as_f64().expect("a number") + 20.0 * rmse.log10()).abs() < 1e-5);
    assert!(json["metrics"]["flip"].as_f64().expect("a number") > 0.0);
    assert!(rayloom(dir.path(), &["diff", "a.png", "b.png", "--quiet"]).stdout.is_empty());
}

#[test]
fn folders_are_compared_file_by_file() {
    let dir = folder();
    for sub in ["x", "y"] {
        std::fs::create_dir(dir.path().join(sub)).expect("a folder");
        std::fs::copy(dir.path().join("a.png"), dir.path().join(sub).join("one.png")).expect("copied");
    }
    let run = || rayloom(dir.path(), &["diff", "x", "y"]);
    assert_eq!(code(&run()), 0);
    std::fs::copy(dir.path().join("b.png"), dir.path().join("y/one.png")).expect("copied");
    std::fs::copy(dir.path().join("b.png"), dir.path().join("y/two.png")).expect("copied");
    let output = run();
    assert_eq!(code(&output), 4, "two.png is missing in x");
    assert!(stdout(&output).contains("2 pictures: 0 same, 0 warn, 1 different, 1 unreadable"));
    std::fs::remove_file(dir.path().join("y/two.png")).expect("removed");
    assert_eq!(code(&run()), 2);
}

#[test]
fn merge_refuses_what_is_no_part_and_writes_what_is_asked_for() {
    let dir = folder();
    let run = |args: &[&str]| code(&rayloom(dir.path(), &[&["merge"], args].concat()));
    assert_eq!(run(&["a.png", "-o", "out.exr"]), 4);
    assert_eq!(run(&["a.exr", "-o", "out.what"]), 2);
    assert!(!dir.path().join("out.exr").exists());
    let scene = "camera { location -3*z } sphere { 0, 1 pigment { rgb 1 } finish { ambient 0.5 } }";
    std::fs::write(dir.path().join("s.pov"), scene).expect("written");
    for (name, crop) in [("l.exr", "0,0,20,30"), ("r.exr", "20,0,40,30"), ("all.exr", "0,0,40,30")] {
        let output = rayloom(dir.path(), &["render", "s.pov", "-o", name, "--size", "40x30", "--backend", "cpu", "--crop", crop]);
        assert_eq!(code(&output), 0, "{}", String::from_utf8_lossy(&output.stderr));
    }
    assert_eq!(run(&["l.exr", "r.exr", "-o", "out.exr"]), 0);
    assert_eq!(code(&rayloom(dir.path(), &["diff", "out.exr", "all.exr"])), 0, "two halves are the whole");
    assert_eq!(code(&rayloom(dir.path(), &["diff", "l.exr", "all.exr"])), 2);
}

#[test]
fn regions_and_masks_leave_pixels_out() {
    let dir = folder();
    let run = |args: &[&str]| code(&rayloom(dir.path(), &[&["diff", "a.png", "b.png"], args].concat()));
    assert_eq!(run(&["--region", "0,0,40,3"]), 0, "above the row that differs");
    assert_eq!(run(&["--region", "0,3,40,4"]), 2);
    assert_eq!(run(&["--region", "0,0,40,3", "--region", "0,4,40,30"]), 0);
    assert_eq!(run(&["--region", "0,0,41,3"]), 4, "beyond the picture");
    RgbImage::from_fn(40, 30, |_, y| image::Rgb([if y == 3 { 0 } else { 255 }; 3])).save(dir.path().join("mask.png")).expect("saved");
    assert_eq!(run(&["--mask", "mask.png"]), 0);
    assert_eq!(run(&["--mask", "mask.png", "--region", "0,3,40,4"]), 4, "no pixel is left");
    assert_eq!(run(&["--mask", "small.png"]), 4, "a mask of another size");
    let out = rayloom(dir.path(), &["diff", "a.png", "b.png", "--region", "0,3,10,4", "--json"]);
    let json: serde_json::Value = serde_json::from_slice(&out.stdout).expect("JSON");
    assert_eq!((json["metrics"]["pixels"].as_u64(), json["metrics"]["differing"].as_u64()), (Some(10), Some(5)));
}

#[test]
fn space_exposure_and_similarity() {
    let dir = folder();
    let largest = |args: &[&str]| {
        let out = rayloom(dir.path(), &[&["diff", "a.png", "b.png", "--json"], args].concat());
        let json: serde_json::Value = serde_json::from_slice(&out.stdout).expect("JSON");
        json["metrics"]["largest"]["value"].as_f64().expect("a number")
    };
    let linear = largest(&["--space", "linear"]);
    assert!((largest(&["--space", "linear", "--exposure", "1"]) / linear - 2.0).abs() < 1e-5, "a stop is twice the light");
    assert!(linear < largest(&[]), "dark values are nearer in light");
    let run = |args: &[&str]| rayloom(dir.path(), &[&["diff", "a.png", "b.png", "--fail", "1"], args].concat());
    assert_eq!((code(&run(&["--min-ssim", "0.99"])), code(&run(&["--min-ssim", "1"]))), (0, 2));
    assert!(stdout(&run(&["--ssim"])).contains("SSIM                 0.99"));
    assert!(stdout(&run(&["--hdr-flip"])).contains("HDR-FLIP"));
}

#[test]
fn layers_of_exr_files_are_compared_by_name() {
    let dir = tempfile::tempdir().expect("a folder");
    let pairs = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/metrics/pairs");
    let [a, b] = ["10_a.exr", "10_b.exr"].map(|n| pairs.join(n).display().to_string());
    let run = |args: &[&str]| rayloom(dir.path(), &[&["diff"], args].concat());
    assert_eq!(code(&run(&[&a, &a, "--layer", "all"])), 0);
    assert_eq!(code(&run(&[&a, &b, "--layer", "all"])), 2);
    assert_eq!(code(&run(&[&a, &b, "--layer", "depth"])), 4, "no such layer");
    // What is rendered has a layer that counts samples.
    std::fs::write(dir.path().join("t.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").expect("written");
    for n in ["1", "2"] {
        let ran = rayloom(dir.path(), &["render", "t.obj", "-o", &format!("{n}.exr"), "--size", "8x6", "--spp", n, "--backend", "cpu"]);
        assert_eq!(code(&ran), 0);
    }
    let out = run(&["1.exr", "2.exr", "--layer", "samples", "--json"]);
    let json: serde_json::Value = serde_json::from_slice(&out.stdout).expect("JSON");
    assert_eq!((code(&out), json["layers"][0]["largest"]["value"].as_f64()), (2, Some(1.0)));
    let ran = run(&["1.exr", &a, "--layer", "all"]);
    assert!(code(&ran) == 2 && stdout(&ran).contains("layer 'samples' is in A only"), "{}", stdout(&ran));
}

#[test]
fn folders_are_compared_with_all_below_them() {
    let dir = folder();
    for (folder, picture) in [("one/deep", "a.png"), ("two/deep", "b.png")] {
        std::fs::create_dir_all(dir.path().join(folder)).expect("made");
        std::fs::copy(dir.path().join(picture), dir.path().join(folder).join("x.png")).expect("copied");
    }
    let ran = rayloom(dir.path(), &["diff", "one", "two", "--heatmap", "maps"]);
    assert!(code(&ran) == 2 && stdout(&ran).contains("deep/x.png"), "{}", stdout(&ran));
    assert_eq!(image::open(dir.path().join("maps/deep/x.png.png")).expect("a map").to_rgb8().dimensions(), (40, 30));
}
