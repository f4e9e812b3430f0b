//! POV-Ray's options → a [`Job`] for one frame.

use super::{BackendChoice, Job, JobError, Moment, SceneFormat, Source, Target};
use crate::accel::AccelKind;
use crate::compile::CompileOptions;
use crate::film::{DitherMethod, FileFormat, FileGamma};
use crate::integrate::antialias::Block;
use crate::integrate::{Antialias, IntegratorKind, RenderSettings};
use crate::lang::LangOptions;
use crate::lang::options::{Frame, GammaOption, OutputName, OutputType, PovOptions};
use crate::memory::MemoryLimit;
use crate::scene::PassSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Largest side and largest number of pixels of a picture.
const MAX_SIDE: u32 = 131_072;
const MAX_PIXELS: u64 = 1 << 31;

/// The job of one frame.
pub fn job_for_frame(o: &PovOptions, input: &Path, frame: &Frame) -> Result<Job, JobError> {
    check_size(o.width, o.height)?;
    let crop = crop(o)?;
    let antialias = o.antialias.then_some(Antialias {
        method: o.sampling_method,
        threshold: o.antialias_threshold as f32,
        depth: o.antialias_depth,
        jitter: if o.jitter { o.jitter_amount } else { 0.0 },
        gamma: o.antialias_gamma as f32,
    });
    let threads = if o.threads == 0 { all_cores() } else { o.threads };
    let target = match (o.output_to_file && !o.real_time).then(|| o.output_for(input, frame)) {
        None => None,
        Some(OutputName::File(path)) => Some(Some(path)),
        Some(OutputName::Stdout) => Some(None),
        Some(OutputName::Stderr) => return Err(JobError::Options("pictures are not written to standard error, messages go there".into())),
    };
    let target = target.map(|path| Target {
        path,
        format: format(o),
        file_gamma: match o.file_gamma {
            GammaOption::Srgb => FileGamma::Srgb,
            GammaOption::Power(g) => FileGamma::Power(g),
        },
        alpha: o.output_alpha,
        dither: if o.dither { DitherMethod::named(&o.dither_method) } else { None },
    });
    let memory = o.max_memory.map_or_else(MemoryLimit::of_machine, |mib| MemoryLimit::bytes(mib << 20));
    let lang = LangOptions {
        width: o.width,
        height: o.height,
        clock: frame.clock,
        clock_on: frame.clock_on,
        frame: frame.variables,
        declares: o.declares.clone(),
        header: o.header.clone(),
        version: o.version,
        max_steps: o.max_steps.unwrap_or(LangOptions::default().max_steps),
        memory,
        ..LangOptions::default()
    };
    let scene_folder = input.parent().map_or_else(PathBuf::new, Path::to_path_buf);
    let mut io_folders = vec![PathBuf::new(), scene_folder, o.output_folder(input), std::env::temp_dir()];
    io_folders.extend(o.allow_io.iter().cloned());
    Ok(Job {
        source: Source {
            path: input.to_owned(),
            format: SceneFormat::of(input),
            lang,
            library_paths: o.library_paths.iter().map(PathBuf::from).collect(),
            io_folders,
            moment: Moment::default(),
        },
        target,
        render: RenderSettings {
            width: o.width,
            height: o.height,
            crop,
            antialias,
            samples: 0..1,
            integrator: IntegratorKind::Classic,
            threads,
            in_order: threads == 1 || o.high_reproducibility,
            seed: 0,
            output_alpha: o.output_alpha,
            block_size: o.block_size,
            passes: PassSet::NONE,
            noise: None,
            in_rounds: false,
            time_limit: None,
            features_only: false,
        },
        compile: CompileOptions { quality: o.quality, accel: accel_named(&o.accel), memory, ..CompileOptions::default() },
        worth_a_gpu: Arc::default(),
        gpu: String::new(),
        backend: match o.backend.as_str() {
            "cpu" => BackendChoice::Cpu,
            "gpu" => BackendChoice::Gpu,
            _ => BackendChoice::Auto,
        },
        resume: o.continue_trace,
        passes: Some(PassSet::NONE),
        noise: Some(None),
        time_limit: Some(0.0),
        denoise: Some(None),
        denoise_library: None,
    })
}

/// The tree of a name that the options accept.
fn accel_named(name: &str) -> AccelKind {
    AccelKind::named(name).unwrap_or_default()
}

/// Number of threads that run at once here.
pub fn all_cores() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// Refuses pictures without pixels, and those that no memory holds.
pub fn check_size(width: u32, height: u32) -> Result<(), JobError> {
    if width == 0 || height == 0 || width > MAX_SIDE || height > MAX_SIDE || u64::from(width) * u64::from(height) > MAX_PIXELS {
        let limits = format!("sides of 1 to {MAX_SIDE} and at most {MAX_PIXELS} pixels are possible");
        return Err(JobError::Options(format!("a picture of {width} by {height} pixels cannot be rendered: {limits}")));
    }
    Ok(())
}

/// The part to render: options are 1-based and inclusive, or shares of the picture below 1.
fn crop(o: &PovOptions) -> Result<Block, JobError> {
    let start = |v: Option<f64>, n: u32| match v {
        None => 0,
        Some(v) if v < 1.0 => (v.max(0.0) * f64::from(n)) as u32,
        Some(v) => (v as u32).saturating_sub(1),
    };
    let end = |v: Option<f64>, n: u32| match v {
        None => n,
        Some(v) if v <= 1.0 => (v.max(0.0) * f64::from(n)) as u32,
        Some(v) => v as u32,
    };
    let block = [start(o.start_column, o.width), start(o.start_row, o.height), end(o.end_column, o.width), end(o.end_row, o.height)];
    if block[0] >= block[2] || block[1] >= block[3] || block[2] > o.width || block[3] > o.height {
        return Err(JobError::Options(format!(
            "Invalid start column or row: columns {} to {} and rows {} to {} of a picture of {} by {}",
            block[0] + 1,
            block[2],
            block[1] + 1,
            block[3],
            o.width,
            o.height
        )));
    }
    Ok(block)
}

fn format(o: &PovOptions) -> FileFormat {
    match o.output_type {
        OutputType::Png => FileFormat::Png { bits: o.bits_per_color, grayscale: o.grayscale },
        OutputType::Targa => FileFormat::Targa { rle: false },
        OutputType::TargaRle => FileFormat::Targa { rle: true },
        OutputType::Ppm => FileFormat::Ppm { bits: o.bits_per_color, grayscale: o.grayscale },
        OutputType::Bmp => FileFormat::Bmp,
        OutputType::Jpeg => FileFormat::Jpeg { quality: o.compression.filter(|q| *q >= 2).unwrap_or(85).min(100) },
        OutputType::Hdr => FileFormat::Hdr,
        OutputType::Exr => FileFormat::Exr,
    }
}
