//! `rayloom diff`: compares two pictures, or two folders of them.

use super::diff_outcome::Outcome;
use clap::ValueEnum;
use rayloom::compare::{DEFAULT_MAX_PIXELS, Space, Verdict};
use serde_json::json;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Compares two pictures, or two folders of them.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Thresholds are shares of the whole range of a channel: 0.01, or 2/255. Without any, the pictures must be equal.
Pictures of linear light (EXR, HDR) are compared in it; with another on either side, both are compared as shown (sRGB, 0 to 1).
Colours are compared as seen over black; alpha is compared as a fourth channel when both pictures have it.
Different sizes, NaN and infinities are always a difference.

Exit codes: 0 the same within the tolerance, 1 beyond --warn only, 2 different, 4 unreadable.

Examples:
  rayloom diff ours.png theirs.png
  rayloom diff ours.png theirs.png --fail 2/255 --percent 1 --heatmap where.png
  rayloom diff renders/ references/ --fail 2/255 --percent 1 --json")]
pub struct DiffArgs {
    /// First picture (PNG, EXR, HDR, TGA, JPEG, BMP, PPM, TIFF, GIF), or a folder
    pub a: PathBuf,
    /// Second picture, the reference where there is one, or a folder
    pub b: PathBuf,
    /// A pixel fails when a channel differs by more than T
    #[arg(long, value_name = "T", default_value = "0", value_parser = threshold)]
    pub fail: f64,
    /// The pictures differ when more than P percent of the pixels fail
    #[arg(long, value_name = "P", default_value_t = 0.0, value_parser = percentage)]
    pub percent: f64,
    /// The pictures differ when any pixel differs by more than T, whatever --percent allows
    #[arg(long, value_name = "T", value_parser = threshold)]
    pub hard_fail: Option<f64>,
    /// Warn (exit code 1) when pixels differ by more than T
    #[arg(long, value_name = "T", value_parser = threshold)]
    pub warn: Option<f64>,
    /// Warn only when more than P percent of the pixels are beyond --warn
    #[arg(long, value_name = "P", default_value_t = 0.0, value_parser = percentage, requires = "warn")]
    pub warn_percent: f64,
    /// The pictures differ when the mean FLIP is above F (0 equal, 1 as different as can be)
    #[arg(long, value_name = "F", value_parser = threshold, conflicts_with = "no_flip")]
    pub max_flip: Option<f64>,
    /// The pictures differ when the PSNR is below D dB
    #[arg(long, value_name = "D", value_parser = finite)]
    pub min_psnr: Option<f64>,
    /// The pictures differ when SSIM is below S (1 for equal pictures)
    #[arg(long, value_name = "S", value_parser = finite)]
    pub min_ssim: Option<f64>,
    /// Compare as seen on a screen (sRGB, 0 to 1) or in linear light [auto: linear when both files hold it]
    #[arg(long, value_enum, default_value_t = SpaceArg::Auto)]
    pub space: SpaceArg,
    /// Brighten light by N stops before it is compared or shown
    #[arg(long, value_name = "N", default_value_t = 0.0, allow_negative_numbers = true)]
    pub exposure: f32,
    /// Compare this layer of two EXR files, or "all" of them
    #[arg(long, value_name = "NAME|all")]
    pub layer: Option<String>,
    /// Compare only pixels that are light in this picture
    #[arg(long, value_name = "PICTURE")]
    pub mask: Option<PathBuf>,
    /// Compare only this part: left, top, right, bottom in pixels, right and bottom exclusive; may be given again
    #[arg(long, value_name = "X0,Y0,X1,Y1", value_parser = super::render::parse_crop)]
    pub region: Vec<[u32; 4]>,
    /// Compute SSIM
    #[arg(long)]
    pub ssim: bool,
    /// Compute FLIP of linear light over all exposures, in the place of FLIP of what is shown
    #[arg(long, conflicts_with = "no_flip")]
    pub hdr_flip: bool,
    /// Write where and how much they differ: magma colours on a logarithmic scale, green where a value is no number
    /// (two folders: into this folder)
    #[arg(long, value_name = "OUT.png")]
    pub heatmap: Option<PathBuf>,
    /// Write the map of FLIP in the colours of the reference tool
    #[arg(long, value_name = "OUT.png", conflicts_with = "no_flip")]
    pub flip_map: Option<PathBuf>,
    /// Leave FLIP out, which takes most of the time
    #[arg(long)]
    pub no_flip: bool,
    /// Refuse pictures of more pixels than N
    #[arg(long, value_name = "N", default_value_t = DEFAULT_MAX_PIXELS)]
    pub max_pixels: u64,
    /// Print one JSON object (for folders one that holds all of them) in place of text
    #[arg(long)]
    json: bool,
    /// Print nothing but errors
    #[arg(long, short, conflicts_with = "json")]
    quiet: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum SpaceArg {
    Auto,
    Linear,
    Display,
}

impl From<SpaceArg> for Space {
    fn from(s: SpaceArg) -> Self {
        match s {
            SpaceArg::Auto => Self::Auto,
            SpaceArg::Linear => Self::Linear,
            SpaceArg::Display => Self::Display,
        }
    }
}

/// "0.01" or "2/255".
fn threshold(text: &str) -> Result<f64, String> {
    let v = match text.split_once('/') {
        Some((a, b)) => finite(a)? / finite(b)?,
        None => finite(text)?,
    };
    if v.is_finite() && v >= 0.0 { Ok(v) } else { Err("a threshold is a number of at least 0, such as 0.01 or 2/255".into()) }
}

fn percentage(text: &str) -> Result<f64, String> {
    let v = finite(text)?;
    if (0.0..=100.0).contains(&v) { Ok(v) } else { Err("a percentage is between 0 and 100".into()) }
}

fn finite(text: &str) -> Result<f64, String> {
    text.trim().parse::<f64>().ok().filter(|v| v.is_finite()).ok_or_else(|| format!("{text:?} is not a number"))
}

/// Compares and prints; the exit code is the [`Verdict`].
pub fn run(args: DiffArgs) -> ExitCode {
    let verdict = if args.a.is_dir() && args.b.is_dir() { folders(&args) } else { pair(&args) };
    ExitCode::from(verdict as u8)
}

/// Writes the maps that are asked for; a failure is told and is "unreadable".
fn write_maps(outcome: &Outcome, heatmap: Option<&Path>, flip_map: Option<&Path>) -> Verdict {
    let mut verdict = outcome.verdict;
    for (path, map) in [(heatmap, outcome.heatmap()), (flip_map, outcome.flip_map())] {
        let (Some(path), Some(map)) = (path, map) else { continue };
        if let Err(e) = map.save_with_format(path, image::ImageFormat::Png) {
            eprintln!("rayloom diff: cannot write {}: {e}", path.display());
            verdict = Verdict::Unreadable;
        }
    }
    verdict
}

fn pair(args: &DiffArgs) -> Verdict {
    let outcome = Outcome::of(args, &args.a, &args.b);
    let verdict = write_maps(&outcome, args.heatmap.as_deref(), args.flip_map.as_deref());
    if args.json {
        println!("{:#}", outcome.json());
    } else if !args.quiet {
        print!("{}", outcome.text(args));
    }
    for error in &outcome.errors {
        eprintln!("rayloom diff: {error}");
    }
    verdict
}

/// Paths of all pictures below a folder, from it.
fn pictures_below(root: &Path, folder: &Path, out: &mut BTreeSet<PathBuf>) -> std::io::Result<()> {
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            pictures_below(root, &path, out)?;
        } else if is_picture(&path) {
            out.insert(path.strip_prefix(root).unwrap_or(&path).to_owned());
        }
    }
    Ok(())
}

/// Files of the same name in two folders; one that is in one of them only is unreadable in the other.
fn folders(args: &DiffArgs) -> Verdict {
    let mut names = BTreeSet::new();
    for folder in [&args.a, &args.b] {
        if let Err(e) = pictures_below(folder, folder, &mut names) {
            eprintln!("rayloom diff: cannot read {}: {e}", folder.display());
            return Verdict::Unreadable;
        }
    }
    if names.is_empty() {
        eprintln!("rayloom diff: there are no pictures in {} or {}", args.a.display(), args.b.display());
        return Verdict::Unreadable;
    }
    let mut worst = Verdict::Same;
    let mut all = Vec::new();
    let mut counts = [0; 4];
    for name in &names {
        let outcome = Outcome::of(args, &args.a.join(name), &args.b.join(name));
        let map = |folder: &Option<PathBuf>| folder.as_ref().map(|f| f.join(name).with_added_extension("png"));
        let maps = [map(&args.heatmap), map(&args.flip_map)];
        for folder in maps.iter().flatten().filter_map(|p| p.parent()) {
            // What cannot be made is told when the map is written.
            let _ = std::fs::create_dir_all(folder);
        }
        let verdict = write_maps(&outcome, maps[0].as_deref(), maps[1].as_deref());
        worst = worst.max(verdict);
        counts[(verdict as usize).min(3)] += 1;
        if args.json {
            all.push(outcome.json());
            continue;
        }
        for error in &outcome.errors {
            eprintln!("rayloom diff: {error}");
        }
        if !args.quiet {
            println!("{:<10} {}{}", verdict.word(), name.display(), outcome.line());
        }
    }
    if args.json {
        println!("{:#}", json!({ "verdict": worst.word(), "pictures": all }));
    } else if !args.quiet {
        println!("{} pictures: {} same, {} warn, {} different, {} unreadable", names.len(), counts[0], counts[1], counts[2], counts[3]);
    }
    worst
}

fn is_picture(name: &Path) -> bool {
    let known = ["png", "exr", "hdr", "tga", "jpg", "jpeg", "bmp", "ppm", "pgm", "tif", "tiff", "gif"];
    name.extension().is_some_and(|e| known.contains(&e.to_string_lossy().to_ascii_lowercase().as_str()))
}
