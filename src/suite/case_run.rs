//! One case from its scene to its result: rendered on each machine, held against each reference.

use super::child::{self, End};
use super::command;
use super::discover::{Case, Suite};
use super::error::SuiteError;
use super::estimate;
use super::judge::{Pair, WORST, judge};
use super::limits::Limits;
use super::results::{CaseResult, PairResult, RunResult, State};
use super::spec::{Expect, Machine};
use super::texts;
use crate::compare::Estimate;
use std::path::{Path, PathBuf};

/// What all cases of a run share.
pub struct Context<'s> {
    /// The suite.
    pub suite: &'s Suite,
    /// Our program.
    pub program: PathBuf,
    /// Absolute folder of all that is written.
    pub out: PathBuf,
    /// Machines that are asked for and there.
    pub machines: Vec<Machine>,
    /// What the user types for our program.
    pub shown_program: String,
}

/// A picture that was made, or why there is none.
struct Made {
    machine: Machine,
    path: PathBuf,
    estimate: Option<Estimate>,
    told: String,
    fault: Option<String>,
    /// It ran on the CPU though the GPU was asked for: its reason.
    declined: Option<String>,
}

/// Runs and judges a case. What goes wrong with its files is its own state, not an error.
pub fn run(cx: &Context, case: &Case, key: String) -> CaseResult {
    let mut r = CaseResult {
        name: case.name.clone(),
        area: case.area().into(),
        about: case.about.clone(),
        state: State::Passed,
        why: vec![],
        badness: 0.0,
        size: case.size,
        runs: vec![],
        pairs: vec![],
        texts: vec![],
        pictures: vec![],
        key,
        reused: false,
    };
    if let Some(need) = cx.suite.missing_need(case) {
        (r.state, r.why) = (State::LeftOut, vec![format!("{need} is not here")]);
        return r;
    }
    if let Err(e) = fill(cx, case, &mut r) {
        (r.state, r.badness) = (State::Broken, WORST);
        r.why.push(e.to_string());
    }
    for p in &r.pairs {
        r.state = r.state.max(p.state);
        r.badness = r.badness.max(p.badness);
        r.why.extend(p.why.iter().map(|w| format!("{}: {w}", p.pair)));
    }
    for t in r.texts.iter().filter(|t| t.state != State::Passed) {
        r.state = r.state.max(t.state);
        r.badness = r.badness.max(10.0);
        r.why.push(format!("the {} text differs from its golden one", t.kind));
    }
    r
}

fn fill(cx: &Context, case: &Case, r: &mut CaseResult) -> Result<(), SuiteError> {
    let folder = cx.out.join("pictures").join(case.area());
    std::fs::create_dir_all(&folder).map_err(SuiteError::io("write", &folder))?;
    let mut made: Vec<Made> = Vec::new();
    for &machine in cx.suite.machines(case).iter().filter(|m| cx.machines.contains(m)) {
        let m = render(cx, case, machine, r)?;
        if let Some(fault) = &m.fault {
            r.state = State::Broken;
            r.badness = WORST;
            r.why.push(format!("{}: {fault}", machine.name()));
        } else if machine == Machine::Gpu {
            gpu_note(case, &m, r);
        }
        if m.fault.is_none() && m.declined.is_none() {
            if case.file.expect == Expect::Picture {
                r.pictures.push((machine.name().into(), m.path.clone()));
            }
            made.push(m);
        }
    }
    let Some(first) = made.first() else { return Ok(()) };
    let golden = cx.suite.reference_stem("golden", &case.name);
    if first.machine == Machine::Cpu {
        let ours = file(cx, case, "diagnostics.txt");
        r.texts.push(texts::judge("diagnostics", &first.told, &golden.with_added_extension("diagnostics.txt"), &ours)?);
        if case.file.dump {
            r.texts.push(dump(cx, case, &golden.with_added_extension("scene.txt"))?);
        }
    }
    if case.file.expect == Expect::Error {
        return Ok(());
    }
    for m in &made {
        for (name, limits) in pairs(cx.suite, case, m.machine) {
            let theirs = match name.rsplit_once('-').expect("a pair has two sides").1 {
                "cpu" => match made.iter().find(|o| o.machine == Machine::Cpu) {
                    Some(cpu) => cpu.path.clone(),
                    None => continue,
                },
                other => cx.suite.reference_stem(other, &case.name).with_added_extension(case.reference_kind(other).extension()),
            };
            let pair = Pair { name: &name, ours: &m.path, theirs: &theirs, estimate: m.estimate.as_ref() };
            let result = judge(&pair, &limits);
            r.pairs.push(known_failure(cx.suite, case, &pair, result));
        }
    }
    Ok(())
}

/// A file of this case in the output folder.
fn file(cx: &Context, case: &Case, what: &str) -> PathBuf {
    cx.out.join("pictures").join(format!("{}.{what}", case.name))
}

/// The comparisons of a machine's picture, with their tolerance.
pub fn pairs(suite: &Suite, case: &Case, machine: Machine) -> Vec<(String, Limits)> {
    let others = case.file.references.iter().map(String::as_str).chain((machine == Machine::Gpu).then_some("cpu"));
    others
        .filter_map(|other| {
            let name = format!("{}-{other}", machine.name());
            let own = case.file.tolerance.get(&name);
            match (own, suite.file.tolerance.get(&name)) {
                (None, None) => None,
                (Some(own), base) => Some((name, own.over(base.unwrap_or(&Limits::default())))),
                (None, Some(base)) => Some((name, base.clone())),
            }
        })
        .collect()
}

/// Turns a failure that is known into a known failure, when it fails as recorded; and one that passes into a failure.
fn known_failure(suite: &Suite, case: &Case, pair: &Pair, mut result: PairResult) -> PairResult {
    let Some(known) = case.file.known_failure.iter().find(|k| k.pair == pair.name) else { return result };
    match result.state {
        State::Passed => {
            result.state = State::Failed;
            result.why = vec![format!("agrees now: take its known_failure out of test.toml (it said: {})", known.reason)];
        }
        State::Failed => {
            let recorded = suite.known_failure_stem(&case.name, pair.name).with_added_extension(case.picture_kind().extension());
            let same = suite.file.tolerance.get("cpu-golden").cloned().unwrap_or_else(|| Limits { fail: Some(0.0), ..Limits::default() });
            let again = judge(&Pair { name: "recorded", theirs: &recorded, ..*pair }, &same);
            if again.state == State::Passed {
                result.state = State::KnownFailure;
                result.why = vec![format!("known: {}", known.reason)];
            } else {
                let what =
                    if recorded.is_file() { "it fails otherwise than recorded" } else { "its wrong picture is not recorded (--update)" };
                result.state = if recorded.is_file() { State::Failed } else { State::Broken };
                result.why.insert(0, format!("a known failure ({}), but {what}", known.reason));
                result.why.extend(again.why);
            }
        }
        _ => {}
    }
    result
}

/// What the GPU did with a case, against what its `test.toml` says.
fn gpu_note(case: &Case, m: &Made, r: &mut CaseResult) {
    let foreseen = case.file.gpu.as_ref().map(|g| g.declines.as_str());
    let fault = match (&m.declined, foreseen) {
        (None, None) => return,
        (Some(what), Some(part)) if what.contains(part) => return,
        (Some(what), Some(part)) => format!("gpu: declined for \"{what}\", its test.toml says \"{part}\""),
        (Some(what), None) => format!("gpu: declined for \"{what}\", which its test.toml does not say"),
        (None, Some(_)) => "gpu: rendered now; take [gpu] declines out of its test.toml".into(),
    };
    r.state = r.state.max(State::Failed);
    r.badness = r.badness.max(10.0);
    r.why.push(fault);
}

/// Renders a case on one machine, with all of its seeds.
fn render(cx: &Context, case: &Case, machine: Machine, r: &mut CaseResult) -> Result<Made, SuiteError> {
    let kind = case.picture_kind().extension();
    let path = file(cx, case, &format!("{}.{kind}", machine.name()));
    let mut made = Made { machine, path: path.clone(), estimate: None, told: String::new(), fault: None, declined: None };
    let seeds: Vec<Option<u32>> = if case.file.seeds.is_empty() { vec![None] } else { case.file.seeds.iter().copied().map(Some).collect() };
    let mut run = RunResult {
        machine,
        device: None,
        seconds: 0.0,
        peak_bytes: None,
        last_seconds: None,
        last_peak_bytes: None,
        command: String::new(),
    };
    let mut parts = Vec::new();
    for seed in &seeds {
        let out = seed.map_or_else(|| path.clone(), |s| file(cx, case, &format!("{}.seed{s}.{kind}", machine.name())));
        let stats = out.with_added_extension("stats");
        // What an earlier run left must not be taken for this one's.
        [&out, &stats].into_iter().try_for_each(|f| remove(f))?;
        let command = command::ours(cx.suite, case, &cx.program, machine, *seed, &out, &stats);
        if run.command.is_empty() {
            run.command = command::CommandLine { program: cx.shown_program.clone().into(), ..command.clone() }.to_string();
        }
        let ended = child::run(&command, &out.with_added_extension("log"), None, cx.suite.file.timeout_s)?;
        let (device, peak) = child::device_and_peak(&stats);
        run.seconds += ended.seconds;
        run.peak_bytes = run.peak_bytes.max(peak);
        made.told = texts::told(&ended.told, &case.folder, &out);
        made.fault = fault(case, ended.end, &ended.told, &out, cx.suite.file.timeout_s);
        let on_cpu = device.as_deref().is_some_and(|d| d.starts_with("CPU"));
        if made.fault.is_none() && case.file.expect == Expect::Picture && device.is_none() {
            made.fault = Some("it does not say which machine rendered".into());
        }
        if machine == Machine::Gpu && on_cpu {
            let why = ended.told.split("the GPU back end does not do ").nth(1).and_then(|t| t.lines().next()?.strip_suffix(" yet"));
            made.declined = Some(why.unwrap_or("no reason").to_owned());
        }
        if machine == Machine::Cpu && !on_cpu && device.is_some() {
            made.fault = Some(format!("the CPU was asked for, {} rendered", device.as_deref().unwrap_or_default()));
        }
        run.device = device;
        if made.fault.is_some() || made.declined.is_some() {
            break;
        }
        parts.push(out);
    }
    if parts.len() == seeds.len() && seeds.len() > 1 {
        match estimate::of_files(&parts) {
            Ok(e) => {
                estimate::write(&path, &e)?;
                made.estimate = Some(e);
            }
            Err(e) => made.fault = Some(e.to_string()),
        }
    }
    r.runs.push(run);
    Ok(made)
}

fn remove(path: &Path) -> Result<(), SuiteError> {
    match std::fs::remove_file(path) {
        Err(e) if e.kind() != std::io::ErrorKind::NotFound => Err(SuiteError::io("write", path)(e)),
        _ => Ok(()),
    }
}

/// Why a run gave nothing to judge.
fn fault(case: &Case, end: End, told: &str, out: &Path, timeout_s: f64) -> Option<String> {
    // `rayloom povray` keeps POV-Ray's exit code for an error.
    let scene_error = if case.is_povray() { 1 } else { 3 };
    let last = || told.lines().find(|l| l.to_lowercase().contains("error")).map_or(String::new(), |l| format!(": {l}"));
    match end {
        End::Timeout => Some(format!("stopped after {timeout_s} s")),
        End::Signal => Some("crashed".into()),
        _ if told.contains("panicked at") => {
            Some(format!("crashed: {}", told.lines().find(|l| l.contains("panicked at")).unwrap_or_default()))
        }
        End::Code(0) if case.file.expect == Expect::Error => Some("rendered, though an error is expected".into()),
        End::Code(0) if !out.is_file() => Some("it says that all is well, but there is no picture".into()),
        End::Code(0) => None,
        End::Code(c) if case.file.expect == Expect::Error && c == scene_error => None,
        End::Code(c) => Some(format!("exit code {c}{}", last())),
    }
}

fn dump(cx: &Context, case: &Case, golden: &Path) -> Result<super::results::TextResult, SuiteError> {
    let raw = file(cx, case, "scene.raw");
    let command = command::dump(cx.suite, case, &cx.program);
    let ended = child::run(&command, &file(cx, case, "scene.log"), Some(&raw), cx.suite.file.timeout_s)?;
    let text = std::fs::read(&raw).map_err(SuiteError::io("read", &raw))?;
    let text = match ended.end {
        End::Code(0) => String::from_utf8_lossy(&text).into_owned(),
        end => format!("no scene: {end:?}\n"),
    };
    remove(&raw)?;
    texts::judge("scene", &text, golden, &file(cx, case, "scene.txt"))
}
