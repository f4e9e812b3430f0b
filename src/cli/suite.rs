//! `rayloom suite`: scenes in folders, rendered and held against their reference pictures.

use super::console::print_error;
use clap::{Args, ValueEnum};
use rayloom::suite::{
    CaseResult, Machine, ReportOptions, State, Suite, SuiteError, SuiteOptions, SuiteResults, junit, make_references, new_case, quoted,
    update, write_report,
};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Mutex;

/// Renders the cases of a suite and holds them against their references.
#[derive(Debug, Args)]
#[command(after_help = "\
A case is a folder with a scene and a test.toml; its name is its path in the suite. Names may be given as AREA/CASE, as AREA, or as a part.
The report (OUT/report.html) shows every picture with its reference and difference, the worst first.

Exit codes: 0 all well (known failures too), 2 something differs, was updated, or is misused, 4 something cannot be judged.

Examples:
  rayloom suite my-suite --new glass/goblet --scene goblet.pov   # a folder with the scene and a test.toml
  rayloom suite my-suite --update goblet                         # its picture as it is now becomes the golden one
  rayloom suite my-suite                                         # all cases, and the report
  rayloom suite tests/scenes objects csg --backend cpu --skip-unchanged
  rayloom suite tests/scenes --make-references povray objects/torus")]
pub struct SuiteArgs {
    /// Folder of the suite; its suite.toml says what all cases share
    dir: PathBuf,
    /// Cases to run [default: all]
    names: Vec<String>,
    /// Folder for pictures, results.json and the report
    #[arg(long, value_name = "DIR", default_value = "suite-out")]
    out: PathBuf,
    /// File of the report [default: report.html in --out]
    #[arg(long, value_name = "OUT.html")]
    report: Option<PathBuf>,
    /// Put the report's pictures in a folder beside it
    #[arg(long)]
    sidecar: bool,
    /// Write JUnit XML, for CI systems
    #[arg(long, value_name = "OUT.xml")]
    junit: Option<PathBuf>,
    /// Print the results as JSON (OUT/results.json always holds those of all cases)
    #[arg(long)]
    json: bool,
    /// Machine to render on; may be given again [default: what suite.toml says, the GPU where there is one]
    #[arg(long, value_enum)]
    backend: Vec<MachineArg>,
    /// Cases at a time [default: all cores]
    #[arg(long, short, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=512))]
    jobs: Option<u16>,
    /// Take over results of cases of which nothing changed: neither the program, nor their folder, nor their references
    #[arg(long)]
    skip_unchanged: bool,
    /// Take the pictures and texts of the named cases as golden, and their known failures as recorded; ends with exit code 2
    #[arg(long)]
    update: bool,
    /// With --update: all cases
    #[arg(long, requires = "update")]
    all: bool,
    /// Render references again with the program that they come from
    #[arg(long, value_name = "povray|cycles", conflicts_with = "update")]
    make_references: Option<String>,
    /// That program [default: povray, or python3 with bpy]
    #[arg(long, value_name = "PROGRAM", requires = "make_references")]
    reference_program: Option<PathBuf>,
    /// Make a new case of --scene
    #[arg(long, value_name = "AREA/CASE", requires = "scene", conflicts_with_all = ["update", "make_references"])]
    new: Option<String>,
    /// Scene of the new case
    #[arg(long, value_name = "FILE", requires = "new")]
    scene: Option<PathBuf>,
    /// List the cases and what they show
    #[arg(long)]
    list: bool,
    /// Print failures and the sum only
    #[arg(long, short)]
    quiet: bool,
    /// The program that renders [default: this one]
    #[arg(long, value_name = "PROGRAM")]
    program: Option<PathBuf>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum MachineArg {
    Cpu,
    Gpu,
}

/// Runs it.
pub fn run(args: &SuiteArgs) -> ExitCode {
    match suite(args) {
        Ok(code) => ExitCode::from(code),
        Err(e) => {
            print_error(&e.to_string());
            ExitCode::from(if matches!(e, SuiteError::Request(_)) { 2 } else { 4 })
        }
    }
}

fn suite(args: &SuiteArgs) -> Result<u8, SuiteError> {
    if let (Some(name), Some(scene)) = (&args.new, &args.scene) {
        let folder = new_case(&args.dir, name, scene)?;
        println!("{} is a case now; its golden picture: rayloom suite {} --update {name}", folder.display(), args.dir.display());
        return Ok(0);
    }
    if !args.dir.is_dir() {
        return Err(SuiteError::Request(format!("'{}' is no folder", args.dir.display())));
    }
    let suite = Suite::open(&args.dir)?;
    if args.list {
        suite.select(&args.names)?.iter().for_each(|c| println!("{:<36} {}", c.name, c.about));
        return Ok(0);
    }
    if let Some(kind) = &args.make_references {
        return references(args, &suite, kind);
    }
    if args.update && args.names.is_empty() && !args.all {
        return Err(SuiteError::Request("--update wants the names of cases, or --all".into()));
    }
    let program = args.program.clone().map_or_else(std::env::current_exe, Ok);
    let program = program.map_err(|e| SuiteError::Request(format!("this program does not find itself: {e}")))?;
    let shown_program = args.program.as_ref().map_or_else(|| "rayloom".into(), |p| p.display().to_string());
    let machine = |m: &MachineArg| if *m == MachineArg::Cpu { Machine::Cpu } else { Machine::Gpu };
    let options = SuiteOptions {
        program,
        shown_program,
        out: args.out.clone(),
        names: args.names.clone(),
        machines: (!args.backend.is_empty()).then(|| args.backend.iter().map(machine).collect()),
        jobs: args.jobs.map_or_else(rayloom::job::all_cores, usize::from),
        skip_unchanged: args.skip_unchanged,
    };
    let printing = Mutex::new(());
    let results = rayloom::suite::run(&suite, &options, &|c| {
        let _guard = printing.lock();
        tell(args, c);
    })?;
    if args.update {
        let changed = update(&suite, &results.cases)?;
        changed.iter().for_each(|p| println!("updated {}", p.display()));
        println!("{} files updated: look at them before they are committed, and run the suite again", changed.len());
        return Ok(2);
    }
    let report = args.report.clone().unwrap_or_else(|| args.out.join("report.html"));
    let command = format!("rayloom suite {}", quoted(&args.dir.to_string_lossy()));
    write_report(&results, &ReportOptions { path: &report, sidecar: args.sidecar, command })?;
    if let Some(path) = &args.junit {
        std::fs::write(path, junit(&results)).map_err(|source| SuiteError::Io { verb: "write", path: path.clone(), source })?;
    }
    if args.json {
        println!("{}", serde_json::to_string_pretty(&results).map_err(|e| SuiteError::Request(e.to_string()))?);
    } else {
        sum(&results, &report);
    }
    Ok(results.exit_code())
}

/// One line a case, and what is wrong with it.
fn tell(args: &SuiteArgs, c: &CaseResult) {
    let bad = c.state >= State::Failed;
    if args.json || (args.quiet && !bad) {
        return;
    }
    let seconds: f64 = c.runs.iter().map(|r| r.seconds).sum();
    let time = if c.reused { "unchanged".into() } else { format!("{seconds:.2} s") };
    println!("{:<13} {:<36} {time}", c.state.word(), c.name);
    if c.state != State::Passed {
        c.why.iter().for_each(|w| println!("              {w}"));
    }
}

fn sum(results: &SuiteResults, report: &Path) {
    results.notes.iter().for_each(|n| println!("{n}"));
    results.faults.iter().for_each(|f| println!("failed        {f}"));
    let count = |s: State| format!("{} {}", results.count(s), s.word());
    let states = [State::Passed, State::KnownFailure, State::LeftOut, State::Failed, State::Broken];
    let parts: Vec<String> = states.into_iter().filter(|s| *s == State::Passed || results.count(*s) > 0).map(count).collect();
    println!("{} cases in {:.1} s: {}", results.cases.len(), results.seconds, parts.join(", "));
    println!("report: {}", report.display());
}

fn references(args: &SuiteArgs, suite: &Suite, kind: &str) -> Result<u8, SuiteError> {
    let default = if kind == "cycles" { "python3" } else { "povray" };
    let program = args.reference_program.clone().unwrap_or_else(|| default.into());
    let heard = |c: &rayloom::suite::Case, command: &dyn std::fmt::Display| {
        if args.quiet { println!("{}", c.name) } else { println!("{}: {command}", c.name) }
    };
    let changed = make_references(suite, kind, &program, &args.names, &args.out, &|c, l| heard(c, l))?;
    changed.iter().for_each(|p| println!("updated {}", p.display()));
    println!("{} files updated: look at them before they are committed", changed.len());
    Ok(0)
}
