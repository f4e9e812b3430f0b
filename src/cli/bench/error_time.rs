//! `rayloom bench error-time`: how soon a picture is how good.

use crate::cli::console::{print_error, style};
use clap::Args;
use rayloom::backend::cpu::CpuBackend;
use rayloom::bench::error_time::{
    AGREEMENT, Mean, Ours, Peer, Point, Renderer, Setting, Supersampling, best, common_reference, means, run as measure, seconds_to,
};
use rayloom::bench::peer_scene::export;
use rayloom::bench::{Line, log_chart};
use rayloom::compare::{DEFAULT_MAX_PIXELS, Picture};
use rayloom::diag::{Severity, Sink, SourceMap, render};
use rayloom::job::{JobError, load_scene};
use rayloom::scene::path_settings::PixelFilter;
use std::fmt::Write;
use std::path::PathBuf;
use std::process::ExitCode;

/// Errors whose times are compared.
const TARGETS: [f64; 4] = [1e-1, 1e-2, 1e-3, 1e-4];
/// The finest that POV-Ray's options allow: 82 samples in every pixel.
const REFERENCE_ANTIALIAS: Setting = Setting::Antialias(Some(Supersampling { method: 1, threshold: 0.0, depth: 9 }));
/// Means that are apart by more than this are of other pictures, not of noise.
const GATE: f64 = 0.01;
const CYCLES: &str = include_str!("../../../benches/peers/cycles_timed.py");
const LUXCORE: &str = include_str!("../../../benches/peers/luxcore_timed.py");
const POVRAY: &str = include_str!("../../../benches/peers/povray_timed.py");
const MITSUBA: &str = include_str!("../../../benches/peers/mitsuba_timed.py");

/// Arguments of `rayloom bench error-time`.
#[derive(Debug, Args)]
pub(super) struct ErrorTimeArgs {
    /// Scene
    scene: PathBuf,
    /// Picture without noise, in linear light (EXR, HDR): its size is rendered
    #[arg(long, value_name = "FILE", required_unless_present_any = ["reference_spp", "antialias"])]
    reference: Option<PathBuf>,
    /// Make the reference: the mean of every renderer's picture with so many samples a pixel, which are held against each other first
    #[arg(long, value_name = "N", conflicts_with = "reference")]
    reference_spp: Option<u32>,
    /// POV-Ray's light transport, with its antialiasing in place of samples: off, or METHOD:THRESHOLD:DEPTH as 1:0.3:3. Without a
    /// reference every renderer's picture with 1:0:9 makes one
    #[arg(long, value_name = "LIST", value_delimiter = ',', conflicts_with_all = ["spp", "reference_spp", "box_filter"],
          num_args = 0..=1, default_missing_value = "off,1:0.3:2,1:0.1:3,1:0.03:4,1:0:4,2:0.3:2,2:0.1:3,2:0.03:4,2:0.01:5", value_parser = parse_antialias)]
    antialias: Vec<Setting>,
    /// Picture, where the reference is made
    #[arg(long, value_name = "WxH", default_value = "320x240", value_parser = crate::cli::render::parse_size)]
    size: (u32, u32),
    /// Every renderer filters with the pixel itself, not as the scene says
    #[arg(long)]
    box_filter: bool,
    /// Samples a pixel
    #[arg(long, value_name = "LIST", value_delimiter = ',', default_value = "1,4,16,64")]
    spp: Vec<u32>,
    /// Pictures with each count
    #[arg(long, value_name = "N", default_value = "3", value_parser = clap::value_parser!(u32).range(1..=1000))]
    seeds: u32,
    /// Threads of every renderer
    #[arg(long, value_name = "N", default_value = "1", value_parser = clap::value_parser!(u32).range(1..=1024))]
    threads: u32,
    /// Render it with others as well, in turn: `cycles`, `cycles=FILE.blend` for a scene as Blender saved it, `mitsuba`, `luxcore` (both imply --box-filter),
    /// `povray` (with --antialias)
    #[arg(long, value_name = "PROGRAM[=SCENE]", value_delimiter = ',')]
    against: Vec<String>,
    /// Python with bpy, for Cycles
    #[arg(long, value_name = "FILE", default_value = "python3")]
    python: PathBuf,
    /// Python with mitsuba
    #[arg(long, value_name = "FILE", default_value = "python3")]
    mitsuba_python: PathBuf,
    /// Python with pyluxcore
    #[arg(long, value_name = "FILE", default_value = "python3")]
    luxcore_python: PathBuf,
    /// Write every picture's figures as CSV
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Write a chart
    #[arg(long, value_name = "FILE")]
    svg: Option<PathBuf>,
}

fn parse_antialias(text: &str) -> Result<Setting, String> {
    if text == "off" { Ok(Setting::Antialias(None)) } else { text.parse().map(|a| Setting::Antialias(Some(a))) }
}

/// Runs it. Exit code 2 where renderers do not agree on the picture.
pub(super) fn run(args: &ErrorTimeArgs) -> Result<ExitCode, JobError> {
    let (mut map, mut sink) = (SourceMap::default(), Sink::default());
    let loaded = load_scene(&args.scene, &[], &mut map, &mut sink);
    for d in sink.drain().iter().filter(|d| d.severity == Severity::Error) {
        eprint!("{}", render(d, &map, style()));
    }
    let mut scene = loaded?;
    let failed = |message: String, code: u8| {
        print_error(&message);
        Ok(ExitCode::from(code))
    };
    let known = match args.reference.as_ref().map(|path| Picture::read(path, DEFAULT_MAX_PIXELS)) {
        Some(Ok(p)) => Some(p.into_linear()),
        Some(Err(e)) => return failed(e.to_string(), 4),
        None => None,
    };
    // These get the scene that we loaded, and filter with the pixel itself.
    let exports = args.against.iter().any(|a| a == "mitsuba" || a == "luxcore");
    let boxed = args.box_filter || exports;
    let settings: Vec<Setting> =
        if args.antialias.is_empty() { args.spp.iter().map(|n| Setting::Samples(*n)).collect() } else { args.antialias.clone() };
    if let Some(other) = args.against.iter().find(|a| args.antialias.is_empty() == (*a == "povray")) {
        return failed(format!("--against {other} goes {} --antialias", if other == "povray" { "with" } else { "without" }), 2);
    }
    if boxed {
        scene.settings.path.filter = PixelFilter::Box;
    }
    let (size, threads) = (known.as_ref().map_or(args.size, |p| (p.width, p.height)), args.threads as usize);
    let backend = CpuBackend::new(threads);
    let mut ours = Ours { backend: &backend, scene: &scene, size, threads };
    let folder = match tempfile::tempdir() {
        Ok(f) => f,
        Err(e) => return failed(format!("cannot make a temporary folder: {e}"), 4),
    };
    if exports && let Err(what) = export(&scene, folder.path()) {
        return failed(format!("Mitsuba and LuxCore cannot be asked for this scene: {what}"), 2);
    }
    let mut peers = Vec::new();
    for against in &args.against {
        let (program, file) = against.split_once('=').map_or((&against[..], args.scene.clone()), |(p, s)| (p, s.into()));
        let (name, text, python, file) = match program {
            "cycles" => ("Cycles", CYCLES, &args.python, file),
            "mitsuba" => ("Mitsuba", MITSUBA, &args.mitsuba_python, folder.path().to_owned()),
            "luxcore" => ("LuxCore", LUXCORE, &args.luxcore_python, folder.path().to_owned()),
            "povray" => ("POV-Ray", POVRAY, &args.python, file),
            _ => return failed(format!("--against knows 'cycles', 'mitsuba', 'luxcore' and 'povray', not '{program}'"), 2),
        };
        let script = folder.path().join(format!("{program}_timed.py"));
        if let Err(e) = std::fs::write(&script, text) {
            return failed(format!("cannot write '{}': {e}", script.display()), 4);
        }
        let (python, out) = (python.clone(), folder.path().join(format!("{program}.exr")));
        let more = if boxed && program == "cycles" { vec!["box".into()] } else { Vec::new() };
        peers.push(Peer { name: format!("{name}, {threads} threads"), python, script, scene: file, size, threads, out, more });
    }
    let mut renderers: Vec<&mut dyn Renderer> = vec![&mut ours];
    renderers.extend(peers.iter_mut().map(|p| p as &mut dyn Renderer));
    let names: Vec<String> = renderers.iter().map(|r| r.name()).collect();
    let reference = match known {
        Some(p) => p,
        None => match common_reference(&mut renderers, args.reference_spp.map_or(REFERENCE_ANTIALIAS, Setting::Samples)) {
            Ok((picture, apart)) => {
                for (name, apart) in names.iter().zip(&apart).filter(|(_, a)| !a.is_nan()) {
                    let verdict = if *apart <= AGREEMENT { "agrees" } else { "does not agree, or is not converged" };
                    println!("{name}: relMSE {apart:.2e} from the mean of the others' references: {verdict} (bar {AGREEMENT:.0e})");
                }
                picture
            }
            Err(e) => return failed(e, 1),
        },
    };
    println!(
        "{:<28} {:>8} {:>4} {:>9} {:>9} {:>10} {:>7} {:>7}",
        "renderer", "work", "seed", "wall s", "CPU s", "relMSE", "FLIP", "mean +-"
    );
    let points = match measure(&mut renderers, &reference, &settings, args.seeds, &mut |p| println!("{}", line(p))) {
        Ok(points) => points,
        Err(e) => return failed(e, 1),
    };
    let tables: Vec<Vec<Mean>> = names.iter().map(|n| means(&points, n, true)).collect();
    print!("{}{}", same_work(&names, &tables), summary(&names, &tables));
    let name = args.scene.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    for (path, text) in [(&args.csv, csv(&points)), (&args.svg, chart(&name, &names, &tables))] {
        let Some(path) = path else { continue };
        if let Err(e) = std::fs::write(path, text) {
            return failed(format!("cannot write '{}': {e}", path.display()), 4);
        }
    }
    Ok(agree(&points, &names, &settings))
}

/// Exit code 2, and a line, for a renderer whose mean is not the reference's.
fn agree(points: &[Point], names: &[String], settings: &[Setting]) -> ExitCode {
    // What costs most: the highest count, the last of the antialiasings.
    let counts = settings.iter().filter_map(|s| if let Setting::Samples(n) = s { Some(*n) } else { None });
    let most = counts.max().map_or(settings[settings.len() - 1], Setting::Samples);
    let mut code = ExitCode::SUCCESS;
    for name in names {
        let own: Vec<f64> = points.iter().filter(|p| p.renderer == *name && p.setting == most).map(|p| p.mean_error).collect();
        let mean = own.iter().sum::<f64>() / own.len() as f64;
        if !(mean <= GATE) {
            println!("{name}: its mean is off by {:.2} %: it renders another picture, and its times mean little", 100.0 * mean);
            code = ExitCode::from(2);
        }
    }
    code
}

fn line(p: &Point) -> String {
    format!(
        "{:<28} {:>8} {:>4} {:>9.3} {:>9.2} {:>10.3e} {:>7.4} {:>7.4}",
        p.renderer,
        p.setting.to_string(),
        p.seed,
        p.wall,
        p.cpu,
        p.rel_mse,
        p.flip,
        p.mean_error
    )
}

/// Where all do the same work, as with POV-Ray's antialiasing: how long each takes for it.
fn same_work(names: &[String], tables: &[Vec<Mean>]) -> String {
    let mut s = String::new();
    for ours in tables[0].iter().filter(|m| matches!(m.setting, Setting::Antialias(_))) {
        let _ = write!(s, "{:>8}: {:.3} CPU s, relMSE {:.2e}, FLIP {:.4}", ours.setting.to_string(), ours.seconds, ours.rel_mse, ours.flip);
        for (name, table) in names.iter().zip(tables).skip(1) {
            if let Some(m) = table.iter().find(|m| m.setting == ours.setting) {
                let _ = write!(s, "  {name} {:.3} CPU s ({:.2}), {:.2e}, {:.4}", m.seconds, m.seconds / ours.seconds, m.rel_mse, m.flip);
            }
        }
        s.push('\n');
    }
    s
}

/// CPU seconds to each error, and the first renderer's share of the others'.
fn summary(names: &[String], tables: &[Vec<Mean>]) -> String {
    let mut s = String::new();
    for target in TARGETS {
        let times: Vec<Option<f64>> = tables.iter().map(|t| seconds_to(t, target)).collect();
        if times.iter().all(Option::is_none) {
            continue;
        }
        let _ = write!(s, "relMSE {target:.0e}:");
        for (name, t) in names.iter().zip(&times) {
            let text = t.map_or("not within these counts".into(), |t| format!("{t:.3} CPU s"));
            let _ = write!(s, "  {name} {text}");
        }
        for (name, theirs) in names.iter().zip(&times).skip(1) {
            if let (Some(ours), Some(theirs)) = (times[0], theirs) {
                let _ = write!(s, "  ({:.2} times sooner than {name})", theirs / ours);
            }
        }
        s.push('\n');
    }
    s
}

fn csv(points: &[Point]) -> String {
    let mut s = String::from("renderer,work,seed,wall_s,cpu_s,rel_mse,flip,mean_error\n");
    for p in points {
        let _ = writeln!(
            s,
            "\"{}\",{},{},{:.6},{:.3},{:.6e},{:.6},{:.6}",
            p.renderer, p.setting, p.seed, p.wall, p.cpu, p.rel_mse, p.flip, p.mean_error
        );
    }
    s
}

fn chart(title: &str, names: &[String], tables: &[Vec<Mean>]) -> String {
    let of = |(name, t): (&String, &Vec<Mean>)| Line {
        name: name.clone(),
        points: best(t).iter().map(|m| [m.seconds, m.rel_mse, m.spread]).collect(),
    };
    let lines: Vec<Line> = names.iter().zip(tables).map(of).collect();
    log_chart(title, "CPU seconds", "relMSE", &lines)
}
