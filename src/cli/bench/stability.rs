//! `rayloom bench stability`: the stress table.

use crate::cli::console::print_error;
use clap::Args;
use rayloom::bench::stability::{CASES, Effort, Figure, Peers, run as measure};
use rayloom::job::JobError;
use std::fmt::Write;
use std::path::PathBuf;
use std::process::ExitCode;

/// Arguments of `rayloom bench stability`.
#[derive(Debug, Args)]
pub(super) struct StabilityArgs {
    /// Only these cases: 1,2,15
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = clap::value_parser!(u32).range(1..=CASES.len() as i64))]
    only: Vec<u32>,
    /// Rays of the cheapest cases; the others take their share. 1e9 for the whole, a million takes minutes
    #[arg(long, value_name = "N", default_value = "1e6", value_parser = parse_rays)]
    rays: u64,
    /// Of cases 1 to 3 only meshes whose names hold this: "ball of 2e6"
    #[arg(long, value_name = "TEXT", default_value = "", hide_default_value = true)]
    meshes: String,
    /// Which machines
    #[arg(long, default_value = "all", value_parser = ["all", "cpu"])]
    devices: String,
    /// Ask others as well where they can answer: `embree` (cases 1 to 3), `povray` (13 to 15, 18)
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = ["embree", "povray"])]
    against: Vec<String>,
    /// Python with embreex
    #[arg(long, value_name = "FILE", default_value = "python3")]
    python: PathBuf,
    /// Write the figures as CSV
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
}

fn parse_rays(text: &str) -> Result<u64, String> {
    match text.parse::<f64>() {
        Ok(n) if (1.0..=1e12).contains(&n) => Ok(n as u64),
        _ => Err("a number of rays from 1 to 1e12 is expected".into()),
    }
}

/// Runs it. Exit code 1 where a figure misses its bar for no known reason.
pub(super) fn run(args: &StabilityArgs) -> Result<ExitCode, JobError> {
    let effort = Effort { rays: args.rays, gpus: args.devices == "all", meshes: args.meshes.clone() };
    let asked = |name: &str| args.against.iter().any(|a| a == name);
    let peers = Peers { embree: asked("embree").then(|| args.python.clone()), povray: asked("povray") };
    let mut last = 0;
    let figures = measure(&args.only, effort, peers, &mut |f| {
        if f.case != last {
            last = f.case;
            let case = CASES.iter().find(|c| c.number == f.case).expect("figures belong to cases");
            println!("{:>2} {}", case.number, case.name);
        }
        println!("{}", line(f));
    });
    let missed = figures.iter().filter(|f| !f.passes()).count();
    let known = figures.iter().filter(|f| f.known.is_some() && !f.holds()).count();
    let own = figures.iter().filter(|f| !f.is_peer).count();
    println!("{own} figures, {missed} beyond their bar, {known} more for known reasons");
    if let Some(path) = &args.csv
        && let Err(e) = std::fs::write(path, csv(&figures))
    {
        print_error(&format!("cannot write '{}': {e}", path.display()));
        return Ok(ExitCode::from(4));
    }
    Ok(ExitCode::from(u8::from(missed > 0)))
}

fn line(f: &Figure) -> String {
    if f.is_peer {
        return format!("         {:>10}               of {:<11} {}: {}", number(f.value), f.of, f.machine, f.what);
    }
    let verdict = match (f.holds(), f.known) {
        (true, _) => "ok   ",
        (false, Some(_)) => "known",
        (false, None) => "MISS ",
    };
    format!("   {verdict} {:>10} (bar {:>7}) of {:<11} {}: {}", number(f.value), number(f.bar), f.of, f.machine, f.what)
}

/// Whole numbers as such, others with three digits that count.
fn number(v: f64) -> String {
    if v == v.trunc() && v.abs() < 1e9 { format!("{v}") } else { format!("{v:.2e}") }
}

fn csv(figures: &[Figure]) -> String {
    let mut s = String::from("case,machine,what,value,bar,of,holds,known\n");
    for f in figures {
        let _ = writeln!(
            s,
            "{},\"{}\",\"{}\",{:e},{:e},{},{},\"{}\"",
            f.case,
            f.machine,
            f.what,
            f.value,
            f.bar,
            f.of,
            f.holds(),
            f.known.unwrap_or("")
        );
    }
    s
}
