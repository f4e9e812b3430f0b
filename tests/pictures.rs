//! POV-Ray's own pictures of `tests/scenes/`, against ours, rendered through the command line as a user would.
//!
//! One scene, one issue. A scene agrees when at least [`SHARE_WITHIN`] of its pixels differ by at most [`NEAR`] in every channel
//! (silhouettes may fall either way); a wrong size or an unreadable picture always fails. Failures leave the picture and a
//! difference image in `target/pictures/`.

use image::RgbImage;
use rayon::prelude::*;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Share of pixels that must be near.
const SHARE_WITHIN: f64 = 0.99;
/// Largest difference of a near pixel, of 255.
const NEAR: u8 = 2;
/// Scenes that are known not to agree yet, with the reason; one that agrees must leave this list.
const KNOWN_FAILURES: &[(&str, &str)] = &[];

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// POV-Ray's fonts, which text wants: Debian's povray-includes.
const INCLUDES: &str = "/usr/share/povray-3.7/include";

/// Whether a scene needs what is not installed here; `test.sh` installs it where it may.
fn is_left_out(name: &str) -> bool {
    name.starts_with("objects/text") && !Path::new(INCLUDES).is_dir()
}

fn scene_names() -> Vec<String> {
    let dir = root().join("tests/scenes");
    let mut names = Vec::new();
    for area in std::fs::read_dir(&dir).expect("tests/scenes") {
        let area = area.expect("a readable folder").path();
        for scene in std::fs::read_dir(&area).expect("a folder of scenes") {
            let path = scene.expect("a readable folder").path();
            if path.extension().is_some_and(|e| e == "pov") {
                names.push(path.strip_prefix(&dir).expect("inside").with_extension("").display().to_string());
            }
        }
    }
    names.sort();
    names
}

/// Share of near pixels, or why the pictures cannot be compared.
fn share_within(a: &RgbImage, b: &RgbImage) -> Result<f64, String> {
    if a.dimensions() != b.dimensions() {
        return Err(format!("sizes differ: {:?} and {:?}", a.dimensions(), b.dimensions()));
    }
    let near = a.pixels().zip(b.pixels()).filter(|(p, q)| p.0.iter().zip(q.0).all(|(&x, y)| x.abs_diff(y) <= NEAR)).count();
    Ok(near as f64 / (a.width() * a.height()) as f64)
}

fn difference(a: &RgbImage, b: &RgbImage) -> RgbImage {
    RgbImage::from_fn(a.width(), a.height(), |x, y| {
        let (p, q) = (a.get_pixel(x, y), b.get_pixel(x, y));
        image::Rgb(std::array::from_fn(|c| p.0[c].abs_diff(q.0[c]).saturating_mul(8)))
    })
}

fn load(path: &Path) -> Result<RgbImage, String> {
    image::open(path).map(|i| i.to_rgb8()).map_err(|e| format!("{}: {e}", path.display()))
}

fn check(name: &str, out_dir: &Path) -> Result<f64, String> {
    let scenes = root().join("tests/scenes");
    let text = std::fs::read_to_string(scenes.join(format!("{name}.pov"))).map_err(|e| e.to_string())?;
    let options = text.lines().find_map(|l| l.strip_prefix("// options: ")).unwrap_or("");
    let flat = name.replace('/', "-");
    let out = out_dir.join(format!("{flat}.png"));
    let run = Command::new(env!("CARGO_BIN_EXE_rayloom"))
        .args([
            "povray",
            &format!("+I{name}.pov"),
            &format!("+O{}", out.display()),
            "+W128",
            "+H96",
            "+FN",
            "-D",
            "-P",
            "+WT1",
            "-A",
            "Backend=cpu",
        ])
        .arg(format!("+L{INCLUDES}"))
        .args(options.split_whitespace())
        .current_dir(&scenes)
        .output()
        .map_err(|e| e.to_string())?;
    if !run.status.success() {
        let err = String::from_utf8_lossy(&run.stderr);
        let told = err.lines().find(|l| l.to_lowercase().contains("error")).unwrap_or("no message").to_owned();
        return Err(format!("{}: {told}", run.status));
    }
    let (ours, theirs) = (load(&out)?, load(&root().join(format!("references/povray-3.7.0.10/{name}.png")))?);
    let share = share_within(&ours, &theirs)?;
    if share < SHARE_WITHIN {
        let _ = difference(&ours, &theirs).save(out_dir.join(format!("{flat}.difference.png")));
        return Err(format!("{:.2} % of the pixels are within {NEAR}/255", 100.0 * share));
    }
    Ok(share)
}

#[test]
fn our_pictures_agree_with_povrays() {
    let out_dir = root().join("target/pictures");
    std::fs::create_dir_all(&out_dir).expect("a writable target folder");
    let (left_out, names): (Vec<String>, Vec<String>) = scene_names().into_iter().partition(|n| is_left_out(n));
    assert!(names.len() > 100, "only {} scenes found", names.len());
    left_out.iter().for_each(|n| println!("left out: {n} (no {INCLUDES})"));
    let bad: Vec<String> = names
        .par_iter()
        .filter_map(|name| {
            let known = KNOWN_FAILURES.iter().find(|(n, _)| n == name);
            match (check(name, &out_dir), known) {
                (Ok(_), None) | (Err(_), Some(_)) => None,
                (Ok(_), Some(_)) => Some(format!("{name}: agrees now; take it off KNOWN_FAILURES")),
                (Err(e), None) => Some(format!("{name}: {e}")),
            }
        })
        .collect();
    assert!(bad.is_empty(), "{} of {} scenes differ (see {}):\n{}", bad.len(), names.len(), out_dir.display(), bad.join("\n"));
}

#[test]
fn the_comparison_tells_different_pictures_apart() {
    let grey = RgbImage::from_pixel(20, 10, image::Rgb([100, 100, 100]));
    let mut changed = grey.clone();
    for x in 0..3 {
        changed.put_pixel(x, 0, image::Rgb([100, 103, 100]));
    }
    assert_eq!(share_within(&grey, &grey), Ok(1.0));
    assert_eq!(share_within(&grey, &changed), Ok(197.0 / 200.0));
    assert!(share_within(&grey, &changed).is_ok_and(|s| s < SHARE_WITHIN));
    assert!(share_within(&grey, &RgbImage::new(10, 20)).is_err());
}
