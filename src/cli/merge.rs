//! `rayloom merge`: joins parts of a picture that were rendered apart.

use rayloom::compare::DEFAULT_MAX_PIXELS;
use rayloom::film::{Encoding, FileFormat, Part, check_writable, merge, write_picture};
use std::path::PathBuf;
use std::process::ExitCode;

/// Joins parts of a picture that were rendered apart.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Parts are EXR files that `rayloom render` wrote with --crop or --samples. Each pixel becomes the mean of its samples in all parts.
Parts of other sizes, scenes, cameras or integrators are refused, and so are the same samples twice.
Pixels that no part has stay black; how many there are is told.

Exit codes: 0 done, 2 usage, 4 a part cannot be read or does not fit, or the output cannot be written.

Example:
  rayloom render scene.glb -o a.exr --samples 0..64
  rayloom render scene.glb -o b.exr --samples 64..128
  rayloom merge a.exr b.exr -o scene.exr")]
pub struct MergeArgs {
    /// The parts
    #[arg(required = true, value_name = "PART.exr")]
    parts: Vec<PathBuf>,
    /// Where the whole goes: EXR, which can be merged again, or any other format for looking at
    #[arg(short, long, value_name = "OUT.exr")]
    output: PathBuf,
    /// Refuse parts of more pixels than N
    #[arg(long, value_name = "N", default_value_t = DEFAULT_MAX_PIXELS)]
    max_pixels: u64,
}

/// Merges; prints what came of it.
pub fn run(args: MergeArgs) -> ExitCode {
    let Some(format) = FileFormat::from_path(&args.output) else {
        eprintln!("rayloom merge: {}: pictures are written as png, exr, tga, ppm, pgm, bmp, jpg or hdr", args.output.display());
        return ExitCode::from(2);
    };
    let merged = check_writable(&args.output).and_then(|()| merge(&args.parts, args.max_pixels)).and_then(|whole| {
        let Part { film, alpha, metadata } = &whole;
        let encoding = Encoding { alpha: *alpha, ..Encoding::default() };
        write_picture(&args.output, film, &format, &encoding, metadata)?;
        Ok(whole)
    });
    match merged {
        Ok(Part { film, .. }) => {
            let missing = film.samples.iter().filter(|n| **n == 0).count();
            let most = film.samples.iter().max().copied().unwrap_or(0);
            println!("{}: {} x {}, up to {most} samples a pixel", args.output.display(), film.width, film.height);
            if missing > 0 {
                println!("{missing} of {} pixels are in no part and stay black", film.samples.len());
            }
            ExitCode::SUCCESS
        }
        Err(e) => {
            eprintln!("rayloom merge: {e}");
            ExitCode::from(4)
        }
    }
}
