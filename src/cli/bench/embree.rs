//! `rayloom bench accel --against embree`.

use super::accel::AccelArgs;
use crate::cli::console::print_error;
use rayloom::bench::RAY_KINDS;
use rayloom::bench::accel::{AccelBench, Subject};
use rayloom::bench::embree::{PeerRow, run as measure};
use rayloom::job::JobError;
use std::fmt::Write;
use std::process::ExitCode;

/// Runs it. Exit code 1 where hits are not Embree's.
pub(super) fn run(args: &AccelArgs, subject: &Subject, options: &AccelBench, name: &str) -> Result<ExitCode, JobError> {
    let Some((mesh, rays)) = subject.mesh_and_rays(options)? else {
        print_error("Embree is asked about meshes alone, without clipping");
        return Ok(ExitCode::from(2));
    };
    let rows = match measure(&mesh, &rays, &options.kinds, usize::from(args.rounds), &args.python, &mut |k| {
        eprintln!("round {k} of {}", args.rounds);
    }) {
        Ok(rows) => rows,
        Err(e) => {
            print_error(&e);
            return Ok(ExitCode::from(1));
        }
    };
    println!("Mrays a CPU second, one thread, medians of {} rounds; in brackets the median ratio to Embree's single rays", args.rounds);
    print!("{}", table(&rows));
    if let Some(path) = &args.csv
        && let Err(e) = std::fs::write(path, csv(name, &rows))
    {
        print_error(&format!("cannot write '{}': {e}", path.display()));
        return Ok(ExitCode::from(4));
    }
    Ok(ExitCode::from(u8::from(!rows.iter().all(|r| (0..RAY_KINDS.len()).all(|k| r.agrees(k))))))
}

/// Rows of ours come first; Embree's single rays are the next.
fn table(rows: &[PeerRow]) -> String {
    let single = rows.iter().find(|r| !r.is_ours).unwrap_or(&rows[0]);
    let mut s = format!("{:<22} {:>8} {:>8}", "contestant", "build s", "MB");
    RAY_KINDS.iter().for_each(|k| _ = write!(s, " {k:>15}"));
    s.push('\n');
    for r in rows {
        let _ = write!(s, "{:<22} {:>8.3} {:>8.1}", r.name, r.build_seconds, r.n_bytes as f64 / 1e6);
        for k in 0..RAY_KINDS.len() {
            let text = match (r.n_rays[k], r.agrees(k)) {
                (0, _) => "-".into(),
                (_, true) => format!("{:.2} ({:.2})", r.speed(k), r.over(single, k)),
                (_, false) => format!("{} differ", r.apart[k]),
            };
            let _ = write!(s, " {text:>15}");
        }
        let apart: usize = r.apart.iter().sum();
        let note = if apart > 0 { format!("  {apart} hits differ") } else { String::new() };
        let _ = writeln!(s, "{note}");
    }
    s
}

fn csv(name: &str, rows: &[PeerRow]) -> String {
    let mut s = String::from("scene,contestant,build_cpu_s,bytes,rays,n_rays,hits_differ,round,mrays_per_cpu_s\n");
    for r in rows {
        for (k, kind) in RAY_KINDS.iter().enumerate() {
            for (round, speed) in r.mrays[k].iter().enumerate() {
                let (build, bytes, n, apart) = (r.build_seconds, r.n_bytes, r.n_rays[k], r.apart[k]);
                let _ = writeln!(s, "{name},\"{}\",{build:.6},{bytes},{kind},{n},{apart},{},{speed:.4}", r.name, round + 1);
            }
        }
    }
    s
}
