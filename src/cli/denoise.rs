//! `rayloom denoise`: denoises a picture that is there already.

use super::console::print_error;
use super::denoise_args::{GuidesArg, PrefilterArg, QualityArg, denoise_settings};
use rayloom::compare::DEFAULT_MAX_PIXELS;
use rayloom::denoise::{Denoiser, guide_passes};
use rayloom::film::{DENOISED, Encoding, FileFormat, check_writable, read_exr, write_picture};
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::atomic::AtomicBool;

/// Denoises a picture that is there already.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
The picture is an EXR file of linear light: one with the passes `albedo` and `denoisingNormal` (rayloom render --passes albedo,denoisingNormal, or
Blender's file with Denoising Data) has its guides in it; others are denoised by their colours alone, which is told. A file with passes keeps the noisy
colours beside the denoised ones, as the pass `Noisy Image`.

Exit codes: 0 done, 2 usage, 4 the picture cannot be read or written, 5 the denoiser is missing or failed.

Example:
  rayloom render scene.glb -o a.exr --integrator path --passes albedo,denoisingNormal --samples 0..64
  rayloom render scene.glb -o b.exr --integrator path --passes albedo,denoisingNormal --samples 64..128
  rayloom merge a.exr b.exr -o scene.exr
  rayloom denoise scene.exr -o clean.exr")]
pub struct DenoiseArgs {
    /// The noisy picture
    #[arg(value_name = "IN.exr")]
    input: PathBuf,
    /// Where the denoised one goes: EXR, or any other format for looking at
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    /// What guides the denoiser besides the colours
    #[arg(long, value_enum, value_name = "WHAT", default_value_t = GuidesArg::AlbedoNormal)]
    guides: GuidesArg,
    /// What is done about noise in the guides: nothing, little, denoise them first
    #[arg(long, value_enum, value_name = "HOW", default_value_t = PrefilterArg::Accurate)]
    prefilter: PrefilterArg,
    /// Quality against time
    #[arg(long, value_enum, value_name = "Q", default_value_t = QualityArg::High)]
    quality: QualityArg,
    /// The library libOpenImageDenoise, or the folder that it is in [default: $RAYLOOM_OIDN, beside the program, the system's]
    #[arg(long, value_name = "PATH")]
    library: Option<PathBuf>,
    /// Threads of the CPU [default: all cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=512))]
    threads: Option<u16>,
}

/// Denoises; prints what came of it.
pub fn run(args: &DenoiseArgs) -> ExitCode {
    let Some(format) = FileFormat::from_path(&args.output) else {
        print_error(&format!("{}: pictures are written as png, exr, tga, ppm, pgm, bmp, jpg or hdr", args.output.display()));
        return ExitCode::from(2);
    };
    let read = check_writable(&args.output).and_then(|()| read_exr(&args.input, DEFAULT_MAX_PIXELS));
    let mut part = match read {
        Ok(part) => part,
        Err(e) => {
            print_error(&e.to_string());
            return ExitCode::from(4);
        }
    };
    let settings = denoise_settings(args.guides, args.prefilter, args.quality);
    let film = &mut part.film;
    let missing: Vec<&str> = guide_passes(&settings).iter().filter(|p| film.layer(*p).is_none()).map(|p| p.name()).collect();
    if !missing.is_empty() {
        eprintln!("note: the picture has no pass {}: it is denoised without", missing.join(" and "));
    }
    let threads = args.threads.map_or_else(rayloom::job::all_cores, usize::from);
    let whole = [0, 0, film.width, film.height];
    let done = Denoiser::load(args.library.as_deref()).and_then(|denoiser| {
        denoiser.film(film, whole, &settings, threads, &|_| {}, &AtomicBool::new(false))?;
        Ok(denoiser.name())
    });
    let name = match done {
        Ok(name) => name,
        Err(e) => {
            print_error(&e.to_string());
            return ExitCode::from(5);
        }
    };
    part.metadata.entries.retain(|(name, _)| name != DENOISED);
    let version = name.split(' ').next().unwrap_or_default();
    part.metadata.entries.push((DENOISED.into(), format!("Open Image Denoise {version}, {settings:?}")));
    let encoding = Encoding { alpha: part.alpha, ..Encoding::default() };
    if let Err(e) = write_picture(&args.output, &part.film, &format, &encoding, &part.metadata) {
        print_error(&e.to_string());
        return ExitCode::from(4);
    }
    println!("{}: denoised with Open Image Denoise {name}", args.output.display());
    ExitCode::SUCCESS
}
