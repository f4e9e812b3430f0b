//! `rayloom render`: any scene to a picture.

use super::console::{print_error, style};
use super::denoise_args::DenoiseOptions;
use super::interrupt::Interrupt;
use super::live::LivePicture;
use super::progress::{ProgressKind, ProgressView};
use super::render_listener::RenderListener;
use clap::{Args, ValueEnum};
use rayloom::accel::AccelKind;
use rayloom::compile::shape::TreeStore;
use rayloom::film::{FileFormat, FileGamma};
use rayloom::integrate::{Antialias, IntegratorKind, NoiseLimit};
use rayloom::job::{Job, JobError, Moment, Outcome, SceneFormat, Target, include_folders, job_for_frame};
use rayloom::lang::options::{Environment, Frame, PovOptions, frames};
use rayloom::savings::{Saving, Savings};
use rayloom::scene::{Pass, PassSet};
use rayloom::world::DiskWorld;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;

/// Arguments of `rayloom render`.
#[derive(Debug, Args)]
pub struct RenderArgs {
    /// Scene: .pov, .glb, .gltf, .obj, or a POV-Ray .ini (file.ini[section])
    scene: String,
    /// Picture to write: .png, .exr, .hdr, .jpg, .tga, .ppm or .bmp [default: the scene's name with .png]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Width and height in pixels [default: 800x600, or what the .ini says]
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    size: Option<(u32, u32)>,
    /// Machine: auto takes the GPU where there is one that can render the scene and the CPU would need seconds [default: auto, or what the .ini says]
    #[arg(long, value_parser = ["auto", "cpu", "gpu"])]
    backend: Option<String>,
    /// A GPU by a part of its name as `rayloom info` lists it; implies `--backend gpu`
    #[arg(long, value_name = "NAME", conflicts_with = "backend")]
    device: Option<String>,
    /// Structure over the geometry (docs/gpu.md) [default: auto, or what the .ini says]
    #[arg(long, value_parser = clap::builder::PossibleValuesParser::new(AccelKind::names()))]
    accel: Option<String>,
    /// Light transport: POV-Ray's own, or unbiased path tracing
    #[arg(long, value_enum, default_value_t = IntegratorArg::Auto)]
    integrator: IntegratorArg,
    /// Samples a pixel, instead of POV-Ray's antialiasing [default: 16 for models, 64 with the path integrator]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    spp: Option<u32>,
    /// Render samples A to B-1 of each pixel; ranges rendered apart are joined by `rayloom merge`
    #[arg(long, value_name = "A..B", value_parser = parse_range, conflicts_with = "spp")]
    samples: Option<(u32, u32)>,
    /// Passes to write besides the colours, with commas between, as layers of an .exr: depth, position, normal, uv, objectId, materialId,
    /// albedo, denoisingNormal, diffuse|glossy|transmission + Direct|Indirect|Color, volumeDirect, volumeIndirect, emission, environment, mist, vector, ambientOcclusion, shadowCatcher, cryptoObject,
    /// cryptoMaterial, cryptoAsset, sampleCount, variance; or all, or none [default: what the scene asks for]
    #[arg(long, value_name = "NAMES", value_parser = parse_passes)]
    passes: Option<PassSet>,
    /// Noise that pixels may keep with the path integrator: those below it get no more samples; 0 for all samples everywhere
    /// [default: what the scene asks for]
    #[arg(long, value_name = "T", value_parser = parse_threshold)]
    noise_threshold: Option<f32>,
    /// Fewest samples of a pixel with a noise threshold [default: by the threshold, 64 at 0.01]
    #[arg(long, value_name = "N", requires = "noise_threshold", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    min_spp: Option<u32>,
    #[command(flatten)]
    denoising: DenoiseOptions,
    /// Seconds of rendering at most, with the path integrator; the picture has the samples that there are then, one a pixel at least; 0 for no limit
    /// [default: what the scene asks for]
    #[arg(long, value_name = "SECONDS", value_parser = parse_seconds)]
    time_limit: Option<f64>,
    /// All pixels get few samples, then more, instead of one block after the other (path integrator on the CPU)
    #[arg(long)]
    in_rounds: bool,
    /// POV-Ray's antialiasing of scenes: off, or a threshold from 0 to 1
    #[arg(long, value_name = "T", default_value = "0.3", value_parser = parse_antialias)]
    antialias: AntialiasArg,
    /// Its method
    #[arg(long, value_name = "1|2", default_value_t = 2, value_parser = clap::value_parser!(u8).range(1..=2))]
    antialias_method: u8,
    /// Its depth
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u8).range(1..=9))]
    antialias_depth: u8,
    /// Threads of the CPU [default: all cores, or what the .ini says]; the picture does not depend on it
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=512))]
    threads: Option<u16>,
    /// Seed of random numbers
    #[arg(long, default_value_t = 0)]
    seed: u32,
    /// Render a part: left, top, right, bottom in pixels, right and bottom exclusive
    #[arg(long, value_name = "X0,Y0,X1,Y1", value_parser = parse_crop)]
    crop: Option<[u32; 4]>,
    /// Animation frames A to B of a scene that uses the clock, or of a glTF file; numbers are put before the picture's extension
    #[arg(long, value_name = "A..B", value_parser = parse_range)]
    frames: Option<(u32, u32)>,
    /// Value of the scene's clock
    #[arg(long, value_name = "T", allow_negative_numbers = true)]
    clock: Option<f64>,
    /// Moment of a glTF file's animation in seconds [default: nodes stand as the file places them]
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true, value_parser = parse_finite, conflicts_with_all = ["frame", "frames"])]
    time: Option<f64>,
    /// The same as a frame, counted from 0 at `--fps`; `--frames A..B` renders several
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = parse_finite, conflicts_with = "frames")]
    frame: Option<f64>,
    /// Frames in a second of a glTF file's animation
    #[arg(long, value_name = "N", default_value = "24", value_parser = parse_fps)]
    fps: f64,
    /// Which animation of a glTF file, by name or by number from 0 [default: its first]
    #[arg(long, value_name = "NAME")]
    animation: Option<String>,
    /// Folder to search for includes, images and fonts; may be given again
    #[arg(short = 'L', long = "library", value_name = "DIR")]
    library: Vec<PathBuf>,
    /// Transparent background: the picture gets an alpha channel
    #[arg(long)]
    alpha: bool,
    /// POV-Ray's quality level [default: 9, or what the .ini says]
    #[arg(long, value_name = "0..9", value_parser = clap::value_parser!(u8).range(0..=11))]
    quality: Option<u8>,
    /// Bits per channel of PNG and PPM
    #[arg(long, value_name = "8|16", default_value_t = 8, value_parser = clap::value_parser!(u8).range(8..=16))]
    bits: u8,
    /// How to show progress
    #[arg(long, value_enum, default_value_t = ProgressKind::Auto)]
    progress: ProgressKind,
    /// Stop, as by Ctrl-C, when standard input closes: a program that starts this one is then not outlived by it
    #[arg(long)]
    stop_with_stdin: bool,
    /// While rendering on the CPU, write the picture so far to FILE now and then: a pixel is red, green, blue, alpha in 32-bit floats, top row first;
    /// `--progress json` tells each time
    #[arg(long, value_name = "FILE")]
    live: Option<PathBuf>,
    /// Milliseconds between two of them
    #[arg(long, value_name = "MS", requires = "live", default_value_t = 400, value_parser = clap::value_parser!(u64).range(20..=60_000))]
    live_interval: u64,
    /// Write no picture: `--live` shows it, or it is rendered for its times alone
    #[arg(long, conflicts_with = "output")]
    no_output: bool,
    /// Write times and counts as JSON
    #[arg(long, value_name = "FILE")]
    stats: Option<PathBuf>,
    /// Do all the work, also what the scene does not need; the pixels are the same. With a list, do what these savings leave out:
    /// `rayloom info SCENE` names them
    #[arg(long, value_name = "LIST", num_args = 0..=1, require_equals = true, default_missing_value = "all", value_parser = Savings::parse_without)]
    no_skip: Option<Savings>,
    /// Go on where an interrupted run of the same command ended
    #[arg(long)]
    resume: bool,
    /// Folder that the scene may write files to, besides its own, the picture's and the temporary one; may be given again
    #[arg(long, value_name = "DIR")]
    allow_io: Vec<PathBuf>,
    /// Loop turns, macro calls and includes after which a scene is called endless [default: 100 million]
    #[arg(long, value_name = "N")]
    max_steps: Option<u64>,
    /// Memory to use at most [default: most of what is free]
    #[arg(long, value_name = "MIB", value_parser = clap::value_parser!(u64).range(1..1 << 40))]
    max_memory: Option<u64>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum IntegratorArg {
    Auto,
    Classic,
    Path,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum AntialiasArg {
    Off,
    Threshold(f32),
}

pub(super) fn parse_size(text: &str) -> Result<(u32, u32), String> {
    let parts = text.split_once(['x', 'X']).and_then(|(w, h)| Some((w.parse().ok()?, h.parse().ok()?)));
    parts.ok_or_else(|| "write WIDTHxHEIGHT, as in 640x480".into())
}

fn parse_range(text: &str) -> Result<(u32, u32), String> {
    let parts = text.split_once("..").and_then(|(a, b)| Some((a.parse().ok()?, b.parse().ok()?)));
    parts.filter(|(a, b)| a <= b).ok_or_else(|| "write A..B with A not above B, as in 0..16".into())
}

pub(super) fn parse_crop(text: &str) -> Result<[u32; 4], String> {
    let parts: Option<Vec<u32>> = text.split(',').map(|p| p.trim().parse().ok()).collect();
    match parts.as_deref() {
        Some(&[x0, y0, x1, y1]) if x0 < x1 && y0 < y1 => Ok([x0, y0, x1, y1]),
        _ => Err("write X0,Y0,X1,Y1 with X0 below X1 and Y0 below Y1".into()),
    }
}

fn parse_antialias(text: &str) -> Result<AntialiasArg, String> {
    if text == "off" {
        return Ok(AntialiasArg::Off);
    }
    match text.parse::<f32>() {
        Ok(t) if (0.0..=1.0).contains(&t) => Ok(AntialiasArg::Threshold(t)),
        _ => Err("write off, or a threshold from 0 to 1".into()),
    }
}

fn parse_finite(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|t: &f64| t.is_finite()).ok_or_else(|| "write a number, as in 1.5".into())
}

fn parse_fps(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|t: &f64| *t > 0.0 && t.is_finite()).ok_or_else(|| "write a number above 0, as in 24".into())
}

fn parse_passes(text: &str) -> Result<PassSet, String> {
    let mut set = PassSet::NONE;
    for name in text.split(',').map(str::trim) {
        match (name, Pass::named(name)) {
            ("none", _) => {}
            ("all", _) => set = PassSet::all(),
            (_, Some(pass)) => set = set.with(pass),
            _ => {
                let names: Vec<&str> = Pass::all().map(Pass::name).collect();
                return Err(format!("there is no pass '{name}'; there are {}", names.join(", ")));
            }
        }
    }
    Ok(set)
}

fn parse_seconds(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|t: &f64| (0.0..=1e9).contains(t)).ok_or_else(|| "write seconds from 0 on, as in 60".into())
}

fn parse_threshold(text: &str) -> Result<f32, String> {
    text.parse().ok().filter(|t: &f32| (0.0..=1e6).contains(t)).ok_or_else(|| "write a number from 0 on, as in 0.01".into())
}

/// Runs it.
pub fn run(args: &RenderArgs) -> ExitCode {
    let interrupt = Interrupt::listen(130);
    if args.stop_with_stdin {
        interrupt.follow_stdin(130);
    }
    let jobs = match jobs(args) {
        Ok(jobs) => jobs,
        Err(e) => {
            print_error(&e.to_string());
            return ExitCode::from(e.exit_code());
        }
    };
    let n = jobs.len();
    for (k, job) in jobs.iter().enumerate() {
        let view = ProgressView::new(args.progress);
        if n > 1 {
            view.line(&format!("frame {} of {n}\n", k + 1));
        }
        let live = args.live.as_deref().map(|path| LivePicture::new(path, Duration::from_millis(args.live_interval)));
        let listener = RenderListener { view, style: style(), interrupt: interrupt.clone(), live };
        let result = rayloom::job::run(job, &listener, &interrupt.cancel);
        listener.view.finish();
        interrupt.rendering.store(false, Ordering::SeqCst);
        let told = match result {
            Ok(outcome) => report(args, job, &outcome, &listener.view),
            Err(e) => {
                listener.view.event(&serde_json::json!({"event": "failed", "message": e.to_string(), "exit_code": e.exit_code()}));
                // What is wrong with a scene was said where it was found.
                if !matches!(e, JobError::Scene) {
                    print_error(&e.to_string());
                }
                Err(e.exit_code())
            }
        };
        if let Err(code) = told {
            return ExitCode::from(code);
        }
    }
    ExitCode::SUCCESS
}

/// Says what was done; the error is an exit code.
fn report(args: &RenderArgs, job: &Job, o: &Outcome, view: &ProgressView) -> Result<(), u8> {
    let [load, compile, trace, write] = o.seconds;
    let (least, mean, most) = o.samples;
    if let Some(path) = &o.written {
        view.line(&format!(
            "{} ({}x{}) on {} in {:.2} s{}\n",
            path.display(),
            job.render.width,
            job.render.height,
            o.device,
            load + compile + trace + write,
            if o.limited { format!(", {:.1} samples a pixel ({least} to {most}) in the time limit", mean) } else { String::new() }
        ));
    }
    let stats = serde_json::json!({
        "scene": job.source.path, "output": o.written, "device": o.device,
        "width": job.render.width, "height": job.render.height,
        "photons": o.photons.map(|p| serde_json::json!({
            "shot": p.shot, "on_surfaces": p.on_surfaces, "in_media": p.in_media, "radius": p.radius, "media_radius": p.media_radius,
        })),
        "denoised": o.denoised.as_ref().map(|d| &d.0), "denoise_seconds": o.denoised.as_ref().map(|d| d.1),
        "samples": {"least": least, "mean": mean, "most": most, "time_limit_reached": o.limited},
        "objects": o.counts[0], "primitives": o.counts[1], "lights": o.counts[2],
        "seconds": {"load": load, "compile": compile, "render": trace, "write": write},
        "peak_memory_bytes": rayloom::memory::peak(), "version": env!("CARGO_PKG_VERSION"),
    });
    view.event(&serde_json::json!({"event": "finished", "stats": stats}));
    if let Some(path) = &args.stats
        && let Err(e) = std::fs::write(path, format!("{stats:#}\n"))
    {
        print_error(&format!("cannot write '{}': {e}", path.display()));
        return Err(4);
    }
    Ok(())
}

/// The jobs of all frames.
pub(super) fn jobs(args: &RenderArgs) -> Result<Vec<Job>, JobError> {
    let is_ini = args.scene.to_ascii_lowercase().split('[').next().is_some_and(|f| f.ends_with(".ini"));
    let env = Environment::default();
    let usage = |e: &dyn std::fmt::Display| JobError::Options(e.to_string());
    let words: Vec<String> = if is_ini { vec![args.scene.clone()] } else { Vec::new() };
    let mut o = PovOptions::from_command_line(&words, &env, &DiskWorld::default()).map_err(|e| usage(&e))?;
    if !is_ini {
        (o.width, o.height) = (800, 600);
        o.antialias = args.antialias != AntialiasArg::Off;
        o.input = Some(args.scene.clone());
        o.antialias_depth = args.antialias_depth;
        o.sampling_method = args.antialias_method;
        o.jitter = false;
        if let AntialiasArg::Threshold(t) = args.antialias {
            o.antialias_threshold = f64::from(t);
        }
    }
    if let Some((w, h)) = args.size {
        (o.width, o.height) = (w, h);
    }
    if let Some((first, last)) = args.frames {
        o.initial_frame = i32::try_from(first).map_err(|e| usage(&e))?;
        o.final_frame = i32::try_from(last).map_err(|e| usage(&e))?;
    }
    if let Some(t) = args.clock {
        (o.clock, o.clock_on) = (t, true);
    }
    o.library_paths.splice(0..0, args.library.iter().map(|p| p.display().to_string()));
    o.library_paths.extend(include_folders().map(|p| p.display().to_string()));
    o.max_steps = args.max_steps.or(o.max_steps);
    o.max_memory = args.max_memory.or(o.max_memory);
    o.allow_io.extend(args.allow_io.iter().cloned());
    o.quality = args.quality.map_or(o.quality, |q| q.min(9));
    o.threads = args.threads.map_or(o.threads, usize::from);
    o.backend = args.backend.clone().or(args.device.is_some().then(|| "gpu".into())).unwrap_or(o.backend);
    o.accel = args.accel.clone().unwrap_or(o.accel);
    o.continue_trace |= args.resume;
    let Some(input) = o.input.clone().map(PathBuf::from) else {
        return Err(JobError::Options(format!("'{}' names no scene (Input_File_Name)", args.scene)));
    };
    let all = frames(&o).map_err(|e| usage(&e))?;
    let trees = (all.len() > 1 && args.no_skip.unwrap_or_default().has(Saving::Frames)).then(Arc::<TreeStore>::default);
    let worth_a_gpu = Arc::default();
    let job = |frame: &Frame| {
        let mut job = finish(args, &o, job_for_frame(&o, &input, frame)?, &input, frame.digits, frame.number)?;
        job.compile.trees = trees.clone();
        job.worth_a_gpu = Arc::clone(&worth_a_gpu);
        Ok(job)
    };
    all.iter().map(job).collect()
}

/// What `render` says beyond POV-Ray's options.
fn finish(args: &RenderArgs, o: &PovOptions, mut job: Job, input: &Path, digits: usize, number: i32) -> Result<Job, JobError> {
    if let Some(path) = &args.output {
        let Some(mut format) = FileFormat::from_path(path) else {
            return Err(JobError::Options(format!(
                "'{}': the picture's name must end in .png, .exr, .hdr, .jpg, .tga, .ppm or .bmp",
                path.display()
            )));
        };
        if let FileFormat::Png { bits, .. } | FileFormat::Ppm { bits, .. } = &mut format {
            *bits = args.bits;
        }
        let path = if digits > 0 {
            let stem = path.file_stem().unwrap_or_default().to_string_lossy();
            let extension = path.extension().unwrap_or_default().to_string_lossy();
            path.with_file_name(format!("{stem}{number:0digits$}.{extension}"))
        } else {
            path.clone()
        };
        job.target =
            Some(Target { path: Some(path), format, file_gamma: FileGamma::Srgb, alpha: args.alpha || o.output_alpha, dither: None });
        job.source
            .io_folders
            .push(job.target.as_ref().and_then(|t| t.path.as_ref()?.parent()).map_or_else(PathBuf::new, Path::to_path_buf));
    }
    if args.no_output {
        job.target = None;
    }
    let r = &mut job.render;
    r.output_alpha |= args.alpha;
    r.seed = args.seed;
    if let Some(crop) = args.crop {
        if crop[2] > r.width || crop[3] > r.height {
            return Err(JobError::Options(format!("the crop reaches beyond the picture of {} by {}", r.width, r.height)));
        }
        r.crop = crop;
    }
    let is_model = SceneFormat::of(input) == SceneFormat::Model;
    if !is_model && (args.time.is_some() || args.frame.is_some() || args.animation.is_some()) {
        let message = "--time, --frame and --animation are for glTF files; scenes have --clock and --frames";
        return Err(JobError::Options(message.into()));
    }
    let frame = args.frame.or(args.frames.map(|_| f64::from(number)));
    // Naming an animation asks for its start.
    let time = args.time.or(frame.map(|n| n / args.fps)).or(args.animation.as_ref().map(|_| 0.0));
    job.source.moment = Moment { time, fps: args.fps, animation: args.animation.clone() };
    r.integrator = match args.integrator {
        IntegratorArg::Path => IntegratorKind::Path,
        IntegratorArg::Auto | IntegratorArg::Classic => IntegratorKind::Classic,
    };
    let asked = args.samples.map(|(a, b)| a..b).or(args.spp.map(|n| 0..n));
    let samples = asked.or((r.integrator == IntegratorKind::Path).then_some(0..64)).or(is_model.then_some(0..16));
    if let Some(range) = samples {
        if range.is_empty() {
            return Err(JobError::Options("the range of samples is empty".into()));
        }
        r.samples = range;
        r.antialias = None::<Antialias>;
    }
    job.gpu = args.device.clone().unwrap_or_default();
    job.compile.savings = args.no_skip.unwrap_or_default();
    job.passes = args.passes;
    let limit = |threshold| (threshold > 0.0).then_some(NoiseLimit { threshold, min_samples: args.min_spp.unwrap_or(0) });
    job.noise = args.noise_threshold.map(limit);
    job.denoise = args.denoising.wanted();
    job.time_limit = args.time_limit;
    job.render.in_rounds = args.in_rounds;
    job.denoise_library = args.denoising.denoise_library.clone();
    Ok(job)
}
