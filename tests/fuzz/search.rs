//! The search: a worker process that mutates and runs, and its parent, which starts it again when it dies.

use super::mutate::{self, Random};
use super::targets::{Ending, Kind, hush_panics, run_watched};
use super::{files, root};
use std::collections::{BTreeMap, HashSet};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

/// An input without an answer after this long hangs.
const PATIENCE: Duration = Duration::from_secs(15);
/// Address space of a worker, in KiB: its stacks and 3 GiB more.
const MEMORY_KIB: u64 = 5 << 20;
/// Inputs of a kind that are kept for their new answers.
const POOL: usize = 3000;

fn setting(name: &str, default: u64) -> u64 {
    std::env::var(name).ok().and_then(|v| v.parse().ok()).unwrap_or(default)
}

fn folder() -> PathBuf {
    root().join("target/fuzz")
}

/// Runs workers until the time is up; fails if they found anything.
pub fn search() {
    let budget = Duration::from_secs(setting("RAYLOOM_FUZZ_SECONDS", 60));
    let _ = std::fs::create_dir_all(folder());
    let begin = Instant::now();
    let mut seed = setting("RAYLOOM_FUZZ_SEED", 1);
    while begin.elapsed() + Duration::from_secs(1) < budget {
        let left = (budget - begin.elapsed()).as_secs();
        let program = std::env::current_exe().expect("this test");
        let status = Command::new("sh")
            .args(["-c", &format!("ulimit -c 0; ulimit -v {MEMORY_KIB}; exec \"$0\" --ignored --exact search_worker --nocapture")])
            .arg(program)
            .envs([("RAYLOOM_FUZZ_SECONDS", left.to_string()), ("RAYLOOM_FUZZ_SEED", seed.to_string())])
            .status()
            .expect("a shell");
        if !status.success() {
            let current = folder().join("current");
            let kind = std::fs::read_to_string(folder().join("current-kind")).unwrap_or_default();
            let _ = std::fs::copy(current, folder().join(format!("died-{kind}-{seed}")));
            eprintln!("the worker died ({status}) at {kind}, seed {seed}");
        }
        seed += 1;
    }
    let found: Vec<String> = std::fs::read_dir(folder())
        .expect("target/fuzz")
        .filter_map(|e| Some(e.ok()?.file_name().to_string_lossy().into_owned()))
        .filter(|n| ["died-", "panic-", "hang-"].iter().any(|p| n.starts_with(p)))
        .collect();
    assert!(found.is_empty(), "in target/fuzz: {found:?}");
}

struct Pool {
    kind: Kind,
    inputs: Vec<Vec<u8>>,
    answers: HashSet<u64>,
    n_runs: u64,
}

/// Mutates and runs until the time is up or an input hangs.
pub fn worker() {
    hush_panics();
    let _ = std::fs::create_dir_all(folder());
    let end = Instant::now() + Duration::from_secs(setting("RAYLOOM_FUZZ_SECONDS", 60));
    let mut r = Random::new(setting("RAYLOOM_FUZZ_SEED", 1));
    let words: Vec<&str> = rayloom::lang::keyword::all().collect();
    let only = std::env::var("RAYLOOM_FUZZ_KIND").ok();
    let kinds = Kind::ALL.into_iter().filter(|k| only.as_ref().is_none_or(|o| o == k.name()));
    let mut pools: Vec<Pool> = kinds
        .map(|kind| Pool { kind, inputs: files::seeds(kind), answers: HashSet::new(), n_runs: 0 })
        .filter(|p| !p.inputs.is_empty())
        .collect();
    let mut known: BTreeMap<String, u64> = BTreeMap::new();
    while Instant::now() < end {
        // Half of the time goes to the scene language.
        let which = if r.below(2) == 0 { 0 } else { r.below(pools.len()) };
        let pool = &mut pools[which];
        let (a, b) = (&pool.inputs[r.below(pool.inputs.len())], &pool.inputs[r.below(pool.inputs.len())]);
        let is_text =
            matches!(pool.kind, Kind::Scene | Kind::Ini | Kind::Words | Kind::Obj) || (pool.kind == Kind::Gltf && !a.starts_with(b"glTF"));
        let input = if is_text { mutate::text(a, b, &words, &mut r) } else { mutate::bytes(a, b, &mut r) };
        let kind = pool.kind;
        let _ = std::fs::write(folder().join("current"), &input).and_then(|()| std::fs::write(folder().join("current-kind"), kind.name()));
        pool.n_runs += 1;
        match run_watched(kind, &input, PATIENCE) {
            Ending::Answered(answer) => {
                if pool.inputs.len() < POOL && pool.answers.insert(answer.digest) {
                    pool.inputs.push(input);
                }
            }
            Ending::Panicked(place) => {
                let place = place.chars().take(100).collect::<String>();
                let times = known.entry(place.clone()).or_default();
                *times += 1;
                if *times == 1 {
                    report(kind, &place, &input);
                }
            }
            Ending::Hung => {
                let name = format!("hang-{}-{:x}", kind.name(), Random::new(input.len() as u64).below(1 << 30));
                let _ = std::fs::write(folder().join(&name), &input);
                eprintln!("no answer: target/fuzz/{name}");
                std::process::exit(3);
            }
        }
    }
    for p in &pools {
        eprintln!("{}: {} runs, {} kinds of answers", p.kind.name(), p.n_runs, p.answers.len());
    }
}

/// Keeps the shortest input that panics at the same place.
fn report(kind: Kind, place: &str, input: &[u8]) {
    let at = |p: &str| p.split(": ").next().unwrap_or("").to_owned();
    let short = mutate::minimise(input, 400, |i| matches!(run_watched(kind, i, PATIENCE), Ending::Panicked(p) if at(&p) == at(place)));
    let file: String =
        at(place).rsplit("registry/src/").next().unwrap_or("").chars().map(|c| if c.is_alphanumeric() { c } else { '_' }).collect();
    let name = format!("panic-{}-{file}", kind.name());
    let path = folder().join(&name);
    if !Path::new(&path).exists() {
        let _ = std::fs::write(&path, short);
        eprintln!("panic at {place}: target/fuzz/{name}");
    }
}
