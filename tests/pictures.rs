//! POV-Ray's own pictures of `tests/scenes/`, against ours, rendered through the command line as a user would.
//!
//! One scene, one issue. A scene agrees when at least [`SHARE_WITHIN`] of its pixels differ by at most [`NEAR`] in every channel
//! (silhouettes may fall either way); a wrong size or an unreadable picture always fails. Failures leave the picture and a
//! difference image in `target/pictures/`.

use image::RgbImage;
use rayloom::suite::{Case, Suite};
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

fn check(case: &Case, out_dir: &Path) -> Result<f64, String> {
    let name = &case.name;
    let flat = name.replace('/', "-");
    let out = out_dir.join(format!("{flat}.png"));
    let run = Command::new(env!("CARGO_BIN_EXE_rayloom"))
        .args([
            "povray",
            &format!("+I{}", case.scene.display()),
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
        .args(case.file.options.split_whitespace())
        .current_dir(&case.folder)
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
    let suite = Suite::open(&root().join("tests/scenes")).expect("a suite");
    let asked = |c: &&Case| c.file.references.iter().any(|r| r == "povray");
    let (left_out, cases): (Vec<&Case>, Vec<&Case>) = suite.cases.iter().filter(asked).partition(|c| suite.missing_need(c).is_some());
    left_out.iter().for_each(|c| println!("left out: {}", c.name));
    let bad: Vec<String> = cases
        .par_iter()
        .filter_map(|case| {
            let name = &case.name;
            let known = KNOWN_FAILURES.iter().find(|(n, _)| n == name);
            match (check(case, &out_dir), known) {
                (Ok(_), None) | (Err(_), Some(_)) => None,
                (Ok(_), Some(_)) => Some(format!("{name}: agrees now; take it off KNOWN_FAILURES")),
                (Err(e), None) => Some(format!("{name}: {e}")),
            }
        })
        .collect();
    assert!(bad.is_empty(), "{} of {} scenes differ (see {}):\n{}", bad.len(), cases.len(), out_dir.display(), bad.join("\n"));
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
