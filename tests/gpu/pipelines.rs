//! Compiled pipelines on disk: made by the first run, taken by the second, made again where they are broken.

use std::path::{Path, PathBuf};
use std::process::Command;

/// The pixels of a small scene on the GPU, by a run of the program that keeps its pipelines in `folder`; `None` without a device.
fn rendered(work: &Path, folder: &Path) -> Option<Vec<u8>> {
    std::fs::write(work.join("a.pov"), "camera { location -3*z } light_source { -9*z, 1 } sphere { 0, 1 pigment { rgb 1 } }")
        .expect("written");
    let run = Command::new(env!("CARGO_BIN_EXE_rayloom"))
        .current_dir(work)
        .env("RAYLOOM_PIPELINES", folder)
        .args(["render", "a.pov", "-o", "a.png", "--size", "32x24", "--backend", "gpu"])
        .output()
        .expect("it runs");
    let said = String::from_utf8_lossy(&run.stderr).into_owned();
    if run.status.code() == Some(5) {
        return crate::found(Err(said));
    }
    assert!(run.status.success() && !said.contains("rendered on the CPU"), "{said}");
    Some(std::fs::read(work.join("a.png")).expect("a picture"))
}

fn files(folder: &Path) -> Vec<PathBuf> {
    let of_device: Vec<PathBuf> = std::fs::read_dir(folder).expect("a folder").map(|e| e.expect("an entry").path()).collect();
    let [device] = &of_device[..] else { panic!("one device: {of_device:?}") };
    let mut list: Vec<PathBuf> = std::fs::read_dir(device).expect("a folder").map(|e| e.expect("an entry").path()).collect();
    list.sort();
    list
}

#[test]
fn compiled_pipelines_are_kept_and_broken_ones_made_again() {
    let work = tempfile::tempdir().expect("a folder");
    let folder = work.path().join("pipelines");
    let Some(first) = rendered(work.path(), &folder) else { return };
    if !folder.exists() {
        println!("skipped: this device does not give its pipelines out");
        return;
    }
    let made = files(&folder);
    assert!(made.len() >= 4, "{made:?}");
    assert_eq!(rendered(work.path(), &folder), Some(first.clone()));
    assert_eq!(files(&folder), made, "nothing new is made");
    let whole: Vec<Vec<u8>> = made.iter().map(|f| std::fs::read(f).expect("there")).collect();
    made.iter().for_each(|f| std::fs::write(f, b"broken").expect("written"));
    assert_eq!(rendered(work.path(), &folder), Some(first));
    for (file, whole) in made.iter().zip(&whole) {
        assert!(std::fs::read(file).expect("there").len() >= whole.len().min(8), "{} is mended", file.display());
        assert_ne!(std::fs::read(file).expect("there"), b"broken");
    }
}

#[test]
fn a_folder_that_cannot_be_written_costs_nothing_but_time() {
    let work = tempfile::tempdir().expect("a folder");
    let taken = work.path().join("a_file");
    std::fs::write(&taken, "no folder").expect("written");
    if rendered(work.path(), &taken).is_some() {
        assert_eq!(std::fs::read(&taken).expect("there"), b"no folder");
    }
}
