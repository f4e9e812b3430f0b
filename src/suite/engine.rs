//! The whole suite: its cases in parallel, unchanged ones taken over on request, and what only all of them together show.

use super::case_run::{self, Context};
use super::child;
use super::command::CommandLine;
use super::discover::{Case, Suite};
use super::error::SuiteError;
use super::judge::WORST;
use super::results::{CaseResult, State, SuiteResults};
use super::spec::Machine;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::{Instant, SystemTime};

/// How a suite is run.
#[derive(Clone, Debug)]
pub struct SuiteOptions {
    /// Our program.
    pub program: PathBuf,
    /// What the user types for it, for commands in the report.
    pub shown_program: String,
    /// Folder of pictures, results and the report.
    pub out: PathBuf,
    /// Only these cases; none is all of them.
    pub names: Vec<String>,
    /// Machines, in the place of the suite's; one that is not here is an error then.
    pub machines: Option<Vec<Machine>>,
    /// Cases at a time.
    pub jobs: usize,
    /// Cases of which nothing changed since the last run are taken over from it.
    pub skip_unchanged: bool,
}

/// Fewer GPU pictures than this may all be the CPU's to the bit by chance.
const ENOUGH_TO_DIFFER: usize = 8;

/// Runs a suite. `heard` is told of each case when it is done, from any thread.
pub fn run(suite: &Suite, options: &SuiteOptions, heard: &(dyn Fn(&CaseResult) + Sync)) -> Result<SuiteResults, SuiteError> {
    let start = Instant::now();
    let started = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).map_or(0, |d| d.as_secs());
    let cases = suite.select(&options.names)?;
    std::fs::create_dir_all(&options.out).map_err(SuiteError::io("write", &options.out))?;
    let out = std::fs::canonicalize(&options.out).map_err(SuiteError::io("read", &options.out))?;
    let program = std::fs::canonicalize(&options.program).map_err(SuiteError::io("read", &options.program))?;
    let results_path = out.join("results.json");
    let last = read_results(&results_path).unwrap_or_default();
    let wants_gpu = |m: &[Machine]| m.contains(&Machine::Gpu);
    let asked = options.machines.clone().unwrap_or_else(|| vec![Machine::Cpu, Machine::Gpu]);
    let mut machines = asked.clone();
    let mut gpu = None;
    if wants_gpu(&asked) && cases.iter().any(|c| wants_gpu(suite.machines(c))) {
        gpu = find_gpu(&program, &out)?;
        if gpu.is_none() && options.machines.is_some() {
            return Err(SuiteError::Request("no GPU was found, not even one in software (rayloom info)".into()));
        }
    }
    if gpu.is_none() {
        machines.retain(|m| *m != Machine::Gpu);
    }
    // The program is known by its time: reading all of it takes longer than a case.
    let made = std::fs::metadata(&program).map_err(SuiteError::io("read", &program))?;
    let shared = checksum_of(&[suite.root.join("suite.toml")], &format!("{machines:?} {gpu:?} {} {:?}", made.len(), made.modified().ok()))?;
    let cx = Context { suite, program, out, machines, shown_program: options.shown_program.clone() };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(options.jobs.max(1)).build();
    let pool = pool.map_err(|e| SuiteError::Request(format!("no threads could be started: {e}")))?;
    let one = |case: &&Case| {
        let key = key(suite, case, &shared).unwrap_or_default();
        let before = last.get(&case.name);
        let mut result = match before.filter(|b| options.skip_unchanged && reusable(b, &key)) {
            Some(b) => CaseResult { reused: true, ..b.clone() },
            None => case_run::run(&cx, case, key),
        };
        for run in result.runs.iter_mut().filter(|_| !result.reused) {
            let same = before.and_then(|b| b.runs.iter().find(|r| r.machine == run.machine));
            run.last_seconds = same.map(|r| r.seconds);
            run.last_peak_bytes = same.and_then(|r| r.peak_bytes);
        }
        heard(&result);
        result
    };
    let mut results: Vec<CaseResult> = pool.install(|| cases.par_iter().with_max_len(1).map(one).collect());
    gpu_pictures_are_its_own(&mut results);
    let (mut faults, mut notes) = (Vec::new(), Vec::new());
    if options.names.is_empty() {
        faults.extend(suite.loose.iter().map(|s| format!("{s} has no test.toml beside it")));
        faults.extend(suite.unused_references()?.iter().map(|s| format!("no case asks for the reference {s}")));
    }
    if wants_gpu(&asked) && gpu.is_none() && cases.iter().any(|c| wants_gpu(suite.machines(c))) {
        notes.push("the GPU is left out: there is none, not even in software".into());
    }
    let results = SuiteResults {
        title: suite.file.title.clone(),
        program: format!("{} {}", options.shown_program, env!("CARGO_PKG_VERSION")),
        gpu,
        started,
        seconds: start.elapsed().as_secs_f64(),
        jobs: options.jobs,
        faults,
        notes,
        cases: results,
    };
    write_results(&results_path, &results, last)?;
    Ok(results)
}

/// A harness that hands the CPU's pictures in as the GPU's sees no difference, ever; and numbers of 32 bits do differ somewhere.
fn gpu_pictures_are_its_own(results: &mut [CaseResult]) {
    let of_gpu = |c: &CaseResult| c.pairs.iter().find(|p| p.pair == "gpu-cpu" && !c.reused).and_then(|p| Some(p.numbers.as_ref()?.largest));
    let largest: Vec<f64> = results.iter().filter_map(of_gpu).collect();
    if largest.len() < ENOUGH_TO_DIFFER || largest.iter().any(|d| *d > 0.0) {
        return;
    }
    for c in results {
        for p in c.pairs.iter_mut().filter(|p| p.pair == "gpu-cpu") {
            p.state = State::Broken;
            p.why.push("every GPU picture of this run is the CPU's to the bit: they cannot be the GPU's own".into());
            c.why.push(format!("gpu-cpu: {}", p.why[p.why.len() - 1]));
            (c.state, c.badness) = (State::Broken, WORST);
        }
    }
}

/// The GPU that the program would render on.
fn find_gpu(program: &Path, out: &Path) -> Result<Option<String>, SuiteError> {
    let command = CommandLine { program: program.to_owned(), args: vec!["info".into(), "--json".into()], folder: out.to_owned() };
    let answer = out.join("machines.json");
    child::run(&command, &out.join("machines.log"), Some(&answer), 60.0)?;
    let text = std::fs::read_to_string(&answer).map_err(SuiteError::io("read", &answer))?;
    let json: serde_json::Value = serde_json::from_str(&text).unwrap_or_default();
    Ok(json["gpus"].as_array().and_then(|g| g.first()?.as_str()).map(str::to_owned))
}

/// Results of an earlier run by name; none when there is no such file, or one of another version.
fn read_results(path: &Path) -> Option<BTreeMap<String, CaseResult>> {
    let results: SuiteResults = serde_json::from_slice(&std::fs::read(path).ok()?).ok()?;
    Some(results.cases.into_iter().map(|c| (c.name.clone(), c)).collect())
}

/// Writes the results; those of cases that were not asked for stay for the next run.
fn write_results(path: &Path, results: &SuiteResults, last: BTreeMap<String, CaseResult>) -> Result<(), SuiteError> {
    let mut all = results.clone();
    let names: std::collections::BTreeSet<String> = results.cases.iter().map(|c| c.name.clone()).collect();
    all.cases.extend(last.into_values().filter(|c| !names.contains(&c.name)));
    all.cases.sort_by(|a, b| a.name.cmp(&b.name));
    let text = serde_json::to_string_pretty(&all).map_err(|e| SuiteError::Request(e.to_string()))?;
    std::fs::write(path, text + "\n").map_err(SuiteError::io("write", path))
}

/// Whether an earlier result still holds and its pictures are still there.
fn reusable(before: &CaseResult, key: &str) -> bool {
    let pictures = before.pairs.iter().flat_map(|p| [&p.ours, &p.theirs]).chain(before.pictures.iter().map(|p| &p.1));
    !key.is_empty() && before.key == key && before.state < State::Failed && pictures.into_iter().all(|p| p.is_file())
}

/// All that a case's result depends on, as far as its folder and its references hold it.
fn key(suite: &Suite, case: &Case, shared: &str) -> Result<String, SuiteError> {
    let mut files = Vec::new();
    let entries = std::fs::read_dir(&case.folder).map_err(SuiteError::io("read", &case.folder))?;
    files.extend(entries.flatten().map(|e| e.path()).filter(|p| p.is_file()));
    for kind in case.file.references.iter().map(String::as_str).chain(["golden"]) {
        let stem = suite.reference_stem(kind, &case.name);
        let names = ["png", "exr", "diagnostics.txt", "scene.txt"].map(|e| stem.with_added_extension(e));
        files.extend(names.into_iter().filter(|p| p.is_file()));
    }
    for known in &case.file.known_failure {
        files.push(suite.known_failure_stem(&case.name, &known.pair).with_added_extension(case.picture_kind().extension()));
    }
    files.sort();
    files.dedup();
    checksum_of(&files.iter().filter(|p| p.is_file()).collect::<Vec<_>>(), shared)
}

fn checksum_of(files: &[impl AsRef<Path>], more: &str) -> Result<String, SuiteError> {
    let mut text = more.to_owned();
    for path in files.iter().map(AsRef::as_ref).filter(|p| p.is_file()) {
        let bytes = std::fs::read(path).map_err(SuiteError::io("read", path))?;
        text.push_str(&format!(" {} {:016x}", path.display(), crate::film::state::checksum(&bytes)));
    }
    Ok(format!("{:016x}", crate::film::state::checksum(text.as_bytes())))
}
