//! Hostile input: whatever bytes a front end is given, it answers with a scene or with findings, never with a panic, an endless
//! loop or all of the machine's memory.
//!
//! `recorded_inputs_are_survived` replays `tests/corpus/KIND/*`, inputs that once did harm. The search for more is
//! `RAYLOOM_FUZZ_SECONDS=600 cargo test --test fuzz -- --ignored --exact search --nocapture`: a worker process mutates the seeds
//! (`tests/scenes`, `seeds.txt`, small files made here), keeps inputs that draw answers not seen before, and is started anew after
//! a crash; what it finds is left in `target/fuzz/`.

mod files;
mod mutate;
mod search;
mod targets;

use std::path::PathBuf;
use std::time::Duration;
use targets::{Answer, Ending, Kind, run_watched};

/// An input of the corpus must be answered within this time, on a busy machine too.
const PATIENCE: Duration = Duration::from_secs(20);

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

#[test]
fn recorded_inputs_are_survived() {
    targets::hush_panics();
    let (mut harmful, mut n) = (Vec::new(), 0);
    for kind in Kind::ALL {
        let Ok(folder) = std::fs::read_dir(root().join("tests/corpus").join(kind.name())) else { continue };
        for path in folder.map(|e| e.expect("a readable folder").path()) {
            n += 1;
            let bytes = std::fs::read(&path).expect("a readable input");
            match run_watched(kind, &bytes, PATIENCE) {
                Ending::Answered(_) => {}
                Ending::Panicked(place) => harmful.push(format!("{}: panic at {place}", path.display())),
                Ending::Hung => harmful.push(format!("{}: no answer in {PATIENCE:?}", path.display())),
            }
        }
    }
    assert!(n > 0, "the corpus is gone");
    assert!(harmful.is_empty(), "{}", harmful.join("\n"));
}

#[test]
fn a_panic_and_a_hang_are_noticed() {
    targets::hush_panics();
    assert!(matches!(targets::watch(PATIENCE, || panic!("on purpose")), Ending::Panicked(place) if place.contains("tests/fuzz")));
    let long = || {
        std::thread::sleep(Duration::from_secs(5));
        Answer { digest: 0, whole: true }
    };
    assert!(matches!(targets::watch(Duration::from_millis(50), long), Ending::Hung));
}

#[test]
fn the_search_starts_from_whole_files() {
    targets::hush_panics();
    let mut broken = Vec::new();
    for kind in Kind::ALL.into_iter().filter(|k| *k != Kind::Scene) {
        for (n, bytes) in files::whole(kind).iter().enumerate() {
            match run_watched(kind, bytes, PATIENCE) {
                Ending::Answered(a) if a.whole => {}
                other => broken.push(format!("{} {n}: {other:?}", kind.name())),
            }
        }
    }
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}

#[test]
#[ignore = "a search that runs as long as RAYLOOM_FUZZ_SECONDS says"]
fn search() {
    search::search();
}

#[test]
#[ignore = "the process that `search` starts"]
fn search_worker() {
    search::worker();
}
