//! `rayloom bench skip`: what each saving saves.

use crate::cli::console::{print_error, style};
use crate::cli::render::{RenderArgs, jobs};
use clap::Args;
use rayloom::bench::skip::{Row, run as measure};
use rayloom::diag::{Diagnostic, Severity, SourceMap, render};
use rayloom::job::{JobError, Listener, Stage};
use rayloom::lang::Stream;
use rayloom::savings::{Pixels, SAVINGS, Saving};
use std::fmt::Write;
use std::path::PathBuf;
use std::process::ExitCode;

/// Arguments of `rayloom bench skip`.
#[derive(Debug, Args)]
pub(super) struct SkipArgs {
    /// Only these: lights,trees
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = clap::builder::PossibleValuesParser::new(SAVINGS.map(|s| s.name)))]
    only: Vec<String>,
    /// Pictures with and without each
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u16).range(1..=1000))]
    rounds: u16,
    /// Write the table as CSV
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    #[command(flatten)]
    render: RenderArgs,
}

/// Says what is wrong with the scene, and nothing else.
pub(super) struct Errors;

impl Listener for Errors {
    fn stage(&self, _: &Stage) {}
    fn diagnostic(&self, d: &Diagnostic, map: &SourceMap) {
        if d.severity == Severity::Error {
            eprint!("{}", render(d, map, style()));
        }
    }
    fn text(&self, _: Stream, _: &str) {}
    fn pixels(&self, _: u64, _: u64) {}
}

/// Runs it. Exit code 1 where a saving changes the picture that must not.
pub(super) fn run(args: &SkipArgs) -> Result<ExitCode, JobError> {
    let job = jobs(&args.render)?.into_iter().next().ok_or_else(|| JobError::Options("there is no frame to render".into()))?;
    let only: Vec<Saving> = SAVINGS.iter().filter(|s| args.only.iter().any(|n| n == s.name)).map(|s| s.saving).collect();
    println!("CPU seconds of reading + compiling + rendering, medians of {} rounds\n{}", args.rounds, header());
    let rows = measure(&job, &only, usize::from(args.rounds), &Errors, &mut |row| println!("{}", line(row)))?;
    if let Some(path) = &args.csv
        && let Err(e) = std::fs::write(path, csv(&job.source.path.display().to_string(), &rows))
    {
        print_error(&format!("cannot write '{}': {e}", path.display()));
        return Ok(ExitCode::from(4));
    }
    Ok(ExitCode::from(u8::from(!rows.iter().all(Row::holds))))
}

fn header() -> String {
    format!("{:<11} {:>27} {:>27} {:>22}  pixels", "saving", "without", "with", "times faster")
}

fn line(row: &Row) -> String {
    let name = row.saving.info().name;
    if let Some(why) = &row.why_not {
        return format!("{name:<11} not measured: {why}");
    }
    let times = |s: &[f64; 3]| format!("{:.3} + {:.3} + {:.3}", s[0], s[1], s[2]);
    let ratio = format!("{:.2} ({:.2}..{:.2})", row.ratio, row.spread[0], row.spread[1]);
    format!("{name:<11} {:>27} {:>27} {ratio:>22}  {}", times(&row.seconds[0]), times(&row.seconds[1]), verdict(row))
}

fn verdict(row: &Row) -> String {
    let (n, most) = row.differing;
    match (row.saving.info().pixels, n) {
        (Pixels::Different, 0) => "equal, by chance: this saving is a threshold".into(),
        (Pixels::Different, _) => format!("{n} values differ by nature, by up to {most:.2e}"),
        (_, 0) => "equal".into(),
        (Pixels::Rounded, _) if row.holds() => format!("{n} values are rounded otherwise, by up to {most:.2e}"),
        _ => format!("WRONG: {n} values differ, by up to {most:.2e}"),
    }
}

fn csv(scene: &str, rows: &[Row]) -> String {
    let mut s = String::from(
        "scene,saving,device,read_without_s,compile_without_s,render_without_s,read_with_s,compile_with_s,render_with_s,ratio,ratio_least,ratio_most,values_differ,largest_difference,not_measured\n",
    );
    for r in rows {
        let _ = write!(s, "\"{scene}\",{},\"{}\"", r.saving.info().name, r.device);
        match &r.why_not {
            Some(why) => _ = writeln!(s, ",,,,,,,,,,,,\"{why}\""),
            None => {
                r.seconds.iter().flatten().for_each(|v| _ = write!(s, ",{v:.6}"));
                _ = writeln!(s, ",{:.4},{:.4},{:.4},{},{:e},", r.ratio, r.spread[0], r.spread[1], r.differing.0, r.differing.1);
            }
        }
    }
    s
}
