//! `rayloom bench accel`: structures side by side.

use crate::cli::console::{print_error, style};
use clap::Args;
use rayloom::accel::{AccelKind, STRUCTURES};
use rayloom::bench::accel::{AccelBench, Row, Subject, run as measure};
use rayloom::bench::{RAY_KINDS, bar_chart};
use rayloom::diag::{Severity, Sink, SourceMap, render};
use rayloom::job::{JobError, load_scene};
use std::fmt::Write;
use std::path::PathBuf;
use std::process::ExitCode;

/// Arguments of `rayloom bench accel`.
#[derive(Debug, Args)]
pub(super) struct AccelArgs {
    /// Scene or model; meshes are joined into one
    pub(super) scene: PathBuf,
    /// Only these structures, the first of which the others are held against: bvh,kd,wide. With `embree`, one thread of the CPU's in turn with
    /// Embree 4 over the same rays, by CPU time; alone it stands against bvh8. Needs Python with embreex, and a C compiler
    #[arg(long, value_name = "LIST", value_delimiter = ',',
        value_parser = clap::builder::PossibleValuesParser::new(STRUCTURES.iter().map(|s| s.name).chain(["embree"])))]
    pub(super) against: Vec<String>,
    /// Picture whose rays are traced; a large GPU wants 2048x2048
    #[arg(long, value_name = "WxH", default_value = "512x512", value_parser = crate::cli::render::parse_size)]
    size: (u32, u32),
    /// Look from the middle of the scene instead of from its camera: for rooms
    #[arg(long)]
    inside: bool,
    /// Rays in the order of their octants and places: what sorting them would gain, its own time not counted
    #[arg(long)]
    sorted: bool,
    /// Which machines
    #[arg(long, default_value = "all", value_parser = ["all", "cpu", "gpu"])]
    devices: String,
    /// Remember the fastest structure of each GPU for scenes like this one: `--accel auto` takes it from then on
    #[arg(long)]
    calibrate: bool,
    /// Rounds against Embree
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u16).range(1..=1000))]
    pub(super) rounds: u16,
    /// Python with embreex
    #[arg(long, value_name = "FILE", default_value = "python3")]
    pub(super) python: PathBuf,
    /// Write the table as CSV
    #[arg(long, value_name = "FILE")]
    pub(super) csv: Option<PathBuf>,
    /// Write a chart
    #[arg(long, value_name = "FILE")]
    svg: Option<PathBuf>,
    /// Folder to search for includes, images and fonts; may be given again
    #[arg(short = 'L', long = "library", value_name = "DIR")]
    library: Vec<PathBuf>,
}

/// Runs it.
pub(super) fn run(args: &AccelArgs) -> Result<ExitCode, JobError> {
    let (mut map, mut sink) = (SourceMap::default(), Sink::default());
    let loaded = load_scene(&args.scene, &args.library, &mut map, &mut sink);
    for d in sink.drain().iter().filter(|d| d.severity == Severity::Error) {
        eprint!("{}", render(d, &map, style()));
    }
    let subject = Subject::new(loaded?)?;
    let kinds = match &args.against[..] {
        [] => ordered_kinds(),
        [only] if only == "embree" => vec![AccelKind::Bvh8],
        list => list.iter().filter_map(|n| AccelKind::named(n)).collect(),
    };
    let options = AccelBench {
        kinds,
        size: args.size,
        inside: args.inside,
        sorted: args.sorted,
        cpu: args.devices != "gpu",
        gpus: args.devices != "cpu",
    };
    let name = args.scene.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let joined = if subject.is_merged { ", meshes joined into one" } else { "" };
    println!(
        "{name}: {} {}{joined}, {}x{} pixels",
        subject.size.total(),
        if subject.size.is_triangles() { "triangles" } else { "primitives" },
        args.size.0,
        args.size.1
    );
    if args.against.iter().any(|n| n == "embree") {
        return super::embree::run(args, &subject, &options, &name);
    }
    println!("Mrays/s, and in brackets nodes + primitives a ray\n{}", header());
    let rows = measure(&subject, &options, &mut |row| println!("{}", line(row)))?;
    for (path, text) in [(&args.csv, csv(&name, &rows)), (&args.svg, chart(&name, &rows))] {
        let Some(path) = path else { continue };
        if let Err(e) = std::fs::write(path, text) {
            print_error(&format!("cannot write '{}': {e}", path.display()));
            return Ok(ExitCode::from(4));
        }
    }
    if args.calibrate && !calibrate(&subject, &rows) {
        return Ok(ExitCode::from(4));
    }
    let differs = rows.iter().any(|r| r.note.as_ref().is_some_and(|n| n.contains("something else")));
    Ok(ExitCode::from(u8::from(differs)))
}

/// All structures; the BVH first, since it measures all rays, where brute force takes a sample.
fn ordered_kinds() -> Vec<AccelKind> {
    let mut kinds: Vec<AccelKind> = STRUCTURES.iter().map(|s| s.kind).collect();
    kinds.sort_by_key(|k| *k != AccelKind::Bvh);
    kinds
}

fn header() -> String {
    let mut s = format!("{:<12} {:>8} {:>9}", "structure", "build s", "MB");
    RAY_KINDS.iter().for_each(|k| {
        let _ = write!(s, " {k:>22}");
    });
    s + "  device"
}

fn line(row: &Row) -> String {
    let mut s = format!("{:<12} {:>8.3} {:>9.2}", row.kind.name(), row.stats.build_seconds, row.stats.n_bytes as f64 / 1e6);
    for c in &row.cells {
        let text = c.map_or("-".into(), |c| {
            let work = c.work.map_or(String::new(), |[a, b]| format!(" ({a:.1}+{b:.1})"));
            format!("{}{work}", Significant(c.mrays))
        });
        let _ = write!(s, " {text:>22}");
    }
    let _ = write!(s, "  {}", row.device);
    if let Some(note) = &row.note {
        let _ = write!(s, ": {note}");
    }
    s
}

/// A number with four digits that count.
struct Significant(f64);

impl std::fmt::Display for Significant {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let digits = (3 - self.0.abs().max(1e-9).log10().floor() as i32).clamp(0, 6) as usize;
        write!(f, "{:.digits$}", self.0)
    }
}

fn csv(name: &str, rows: &[Row]) -> String {
    let mut s =
        String::from("scene,device,structure,build_s,bytes,nodes,refs,depth,rays,mrays_per_s,nodes_per_ray,prims_per_ray,n_rays,note\n");
    for r in rows {
        for (kind, cell) in RAY_KINDS.iter().zip(&r.cells) {
            let number = |v: Option<f64>| v.map_or(String::new(), |v| format!("{v:.4}"));
            let work = |k: usize| number(cell.and_then(|c| c.work).map(|w| w[k]));
            let _ = writeln!(
                s,
                "{name},\"{}\",{},{:.6},{},{},{},{},{kind},{},{},{},{},\"{}\"",
                r.device,
                r.kind.name(),
                r.stats.build_seconds,
                r.stats.n_bytes,
                r.stats.n_nodes,
                r.stats.n_refs,
                r.stats.depth,
                number(cell.map(|c| c.mrays)),
                work(0),
                work(1),
                cell.map_or(0, |c| c.n_rays),
                r.note.as_deref().unwrap_or("")
            );
        }
    }
    s
}

/// Devices one after another, each with its structures.
fn chart(name: &str, rows: &[Row]) -> String {
    let mut sorted: Vec<&Row> = rows.iter().collect();
    sorted.sort_by(|a, b| a.device.cmp(&b.device));
    let one_device = sorted.windows(2).all(|w| w[0].device == w[1].device);
    let label = |r: &&Row| {
        if one_device || r.device_key.is_empty() { r.kind.name().to_owned() } else { format!("{} on {}", r.kind.name(), r.device_key) }
    };
    let groups: Vec<String> = sorted.iter().map(label).collect();
    let values: Vec<Vec<Option<f64>>> = sorted.iter().map(|r| r.cells.iter().map(|c| c.map(|c| c.mrays)).collect()).collect();
    let title = if one_device { format!("{name} on {}", sorted.first().map_or("", |r| &r.device)) } else { name.to_owned() };
    bar_chart(&title, "Mrays/s", &groups, &RAY_KINDS, &values)
}

#[cfg(feature = "gpu")]
fn calibrate(subject: &Subject, rows: &[Row]) -> bool {
    use rayloom::backend::gpu::choice::{Choice, save_choice};
    let devices: std::collections::BTreeSet<&str> = rows.iter().map(|r| r.device_key.as_str()).filter(|d| !d.is_empty()).collect();
    for device in devices {
        // The least time for one ray of each kind.
        let time = |r: &&Row| r.cells.iter().map(|c| c.map_or(f64::INFINITY, |c| 1.0 / c.mrays)).sum::<f64>();
        let of_device = rows.iter().filter(|r| r.device_key == device && time(r).is_finite());
        let Some(best) = of_device.min_by(|a, b| time(a).total_cmp(&time(b))) else { continue };
        let choice = Choice {
            device: device.into(),
            triangles: subject.size.is_triangles(),
            n_prims: subject.size.total(),
            accel: best.kind.name().into(),
        };
        match save_choice(choice) {
            Ok(path) => println!("{device}: {} is the fastest; kept in {}", best.kind.name(), path.display()),
            Err(e) => {
                print_error(&format!("cannot keep the choice: {e}"));
                return false;
            }
        }
    }
    true
}

#[cfg(not(feature = "gpu"))]
fn calibrate(_: &Subject, _: &[Row]) -> bool {
    print_error("this program was built without the GPU back end");
    false
}
