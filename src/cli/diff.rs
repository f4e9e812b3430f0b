//! `rayloom diff`: compares two pictures, or two folders of them.

use rayloom::compare::{CompareOptions, DEFAULT_MAX_PIXELS, Flip, Metrics, Picture, Tolerance, Verdict, compare, difference_map, flip_map};
use serde_json::{Value, json};
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
    a: PathBuf,
    /// Second picture, the reference where there is one, or a folder
    b: PathBuf,
    /// A pixel fails when a channel differs by more than T
    #[arg(long, value_name = "T", default_value = "0", value_parser = threshold)]
    fail: f64,
    /// The pictures differ when more than P percent of the pixels fail
    #[arg(long, value_name = "P", default_value_t = 0.0, value_parser = percentage)]
    percent: f64,
    /// The pictures differ when any pixel differs by more than T, whatever --percent allows
    #[arg(long, value_name = "T", value_parser = threshold)]
    hard_fail: Option<f64>,
    /// Warn (exit code 1) when pixels differ by more than T
    #[arg(long, value_name = "T", value_parser = threshold)]
    warn: Option<f64>,
    /// Warn only when more than P percent of the pixels are beyond --warn
    #[arg(long, value_name = "P", default_value_t = 0.0, value_parser = percentage, requires = "warn")]
    warn_percent: f64,
    /// The pictures differ when the mean FLIP is above F (0 equal, 1 as different as can be)
    #[arg(long, value_name = "F", value_parser = threshold, conflicts_with = "no_flip")]
    max_flip: Option<f64>,
    /// The pictures differ when the PSNR is below D dB
    #[arg(long, value_name = "D", value_parser = finite)]
    min_psnr: Option<f64>,
    /// Write where and how much they differ: magma colours on a logarithmic scale, green where a value is no number
    #[arg(long, value_name = "OUT.png")]
    heatmap: Option<PathBuf>,
    /// Write the map of FLIP in the colours of the reference tool
    #[arg(long, value_name = "OUT.png", conflicts_with = "no_flip")]
    flip_map: Option<PathBuf>,
    /// Leave FLIP out, which takes most of the time
    #[arg(long)]
    no_flip: bool,
    /// Refuse pictures of more pixels than N
    #[arg(long, value_name = "N", default_value_t = DEFAULT_MAX_PIXELS)]
    max_pixels: u64,
    /// Print one JSON object (for folders one that holds all of them) in place of text
    #[arg(long)]
    json: bool,
    /// Print nothing but errors
    #[arg(long, short, conflicts_with = "json")]
    quiet: bool,
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

fn pair(args: &DiffArgs) -> Verdict {
    let outcome = Outcome::of(args, &args.a, &args.b);
    let mut verdict = outcome.verdict;
    for (path, map) in [(&args.heatmap, outcome.heatmap(args)), (&args.flip_map, outcome.flip_map(args))] {
        if let (Some(path), Some(map)) = (path, map)
            && let Err(e) = map.save_with_format(path, image::ImageFormat::Png)
        {
            eprintln!("rayloom diff: cannot write {}: {e}", path.display());
            verdict = Verdict::Unreadable;
        }
    }
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

/// Files of the same name in two folders; one that is in one of them only is unreadable in the other.
fn folders(args: &DiffArgs) -> Verdict {
    if args.heatmap.is_some() || args.flip_map.is_some() {
        eprintln!("rayloom diff: --heatmap and --flip-map are for two pictures, not for folders");
        return Verdict::Unreadable;
    }
    let mut names = BTreeSet::new();
    for folder in [&args.a, &args.b] {
        match std::fs::read_dir(folder) {
            Ok(entries) => names.extend(entries.flatten().map(|e| e.file_name()).filter(|n| is_picture(Path::new(n)))),
            Err(e) => {
                eprintln!("rayloom diff: cannot read {}: {e}", folder.display());
                return Verdict::Unreadable;
            }
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
        worst = worst.max(outcome.verdict);
        counts[(outcome.verdict as usize).min(3)] += 1;
        if args.json {
            all.push(outcome.json());
            continue;
        }
        for error in &outcome.errors {
            eprintln!("rayloom diff: {error}");
        }
        if !args.quiet {
            println!("{:<10} {}{}", outcome.verdict.word(), name.display(), outcome.line());
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

/// What came of two files.
struct Outcome {
    paths: [PathBuf; 2],
    verdict: Verdict,
    /// Why the verdict is not "same".
    why: Vec<String>,
    /// Files that cannot be read.
    errors: Vec<String>,
    /// Size and depth of each file that was read.
    files: [Option<(u32, u32, String)>; 2],
    metrics: Option<Metrics>,
    n_beyond: u64,
}

impl Outcome {
    fn of(args: &DiffArgs, a: &Path, b: &Path) -> Self {
        let mut outcome = Self {
            paths: [a.into(), b.into()],
            verdict: Verdict::Unreadable,
            why: vec![],
            errors: vec![],
            files: [None, None],
            metrics: None,
            n_beyond: 0,
        };
        let mut pictures = Vec::new();
        let (first, second) = rayon::join(|| Picture::read(a, args.max_pixels), || Picture::read(b, args.max_pixels));
        for (i, read) in [first, second].into_iter().enumerate() {
            match read {
                Ok(p) => {
                    outcome.files[i] = Some((p.width, p.height, p.depth.clone()));
                    pictures.push(p);
                }
                Err(e) => outcome.errors.push(e.to_string()),
            }
        }
        let (Some(b), Some(a)) = (pictures.pop(), pictures.pop()) else { return outcome };
        let sizes = format!("sizes differ: {} x {} and {} x {}", a.width, a.height, b.width, b.height);
        let Some(metrics) =
            compare(a, b, &CompareOptions { flip: if args.no_flip { Flip::None } else { Flip::Ldr }, ..CompareOptions::default() })
        else {
            (outcome.verdict, outcome.why) = (Verdict::Different, vec![sizes]);
            return outcome;
        };
        let tolerance = Tolerance {
            fail: args.fail,
            percent: args.percent,
            hard_fail: args.hard_fail,
            warn: args.warn,
            warn_percent: args.warn_percent,
            max_flip: args.max_flip,
            min_psnr: args.min_psnr,
        };
        (outcome.verdict, outcome.why) = tolerance.judge(&metrics);
        outcome.n_beyond = metrics.n_beyond(args.fail);
        outcome.metrics = Some(metrics);
        outcome
    }

    fn heatmap(&self, args: &DiffArgs) -> Option<image::RgbImage> {
        args.heatmap.as_ref()?;
        let (width, height, _) = self.files[0].as_ref()?;
        Some(difference_map(self.metrics.as_ref()?, *width, *height))
    }

    fn flip_map(&self, args: &DiffArgs) -> Option<image::RgbImage> {
        args.flip_map.as_ref()?;
        flip_map(self.metrics.as_ref()?)
    }

    /// The numbers in a few words, for lists.
    fn line(&self) -> String {
        match &self.metrics {
            Some(m) => format!("  {}, largest difference {:.6}{}", decibels(m.psnr()), m.largest.value, self.flip_text(", FLIP ")),
            None => self.why.first().map_or(String::new(), |w| format!("  {w}")),
        }
    }

    fn flip_text(&self, before: &str) -> String {
        let flip = self.metrics.as_ref().and_then(|m| m.flip.as_ref());
        flip.map_or(String::new(), |(_, mean)| format!("{before}{mean:.6}"))
    }

    fn text(&self, args: &DiffArgs) -> String {
        let mut lines = Vec::new();
        for (name, (path, file)) in ["A", "B"].iter().zip(self.paths.iter().zip(&self.files)) {
            if let Some((w, h, depth)) = file {
                lines.push(format!("{name}  {} ({w} x {h}, {depth})", path.display()));
            }
        }
        if let Some(m) = &self.metrics {
            let share = |n: u64| format!("{n} of {} pixels ({:.4} %)", m.n_pixels, 100.0 * n as f64 / m.n_pixels as f64);
            lines.push(format!("differing            {}", share(m.n_different)));
            if args.fail > 0.0 {
                lines.push(format!("beyond {:<13} {}, {} % may", format!("{:.5}", args.fail), share(self.n_beyond), args.percent));
            }
            let l = &m.largest;
            if l.value > 0.0 {
                let channel = ["red", "green", "blue", "alpha"][l.channel];
                let steps = if m.linear { String::new() } else { format!(" ({:.2}/255)", 255.0 * l.value) };
                lines.push(format!("largest difference   {:.6}{steps} in {channel} at column {}, row {}", l.value, l.at[0], l.at[1]));
            }
            lines.push(format!(
                "RMSE                 {:.6}, {}{}",
                m.rmse,
                decibels(m.psnr()),
                if m.linear { " (linear light)" } else { "" }
            ));
            lines.push(format!("mean absolute        {:.6}", m.mean_absolute));
            if m.flip.is_some() {
                lines.push(self.flip_text("FLIP                 "));
            }
        }
        lines.extend(self.why.iter().cloned());
        if self.errors.is_empty() {
            lines.push(format!("verdict: {}", self.verdict.word()));
        }
        lines.iter().map(|l| format!("{l}\n")).collect()
    }

    fn json(&self) -> Value {
        let file = |i: usize| {
            let known = self.files[i].as_ref();
            json!({
                "path": self.paths[i].display().to_string(),
                "width": known.map(|f| f.0),
                "height": known.map(|f| f.1),
                "depth": known.map(|f| &f.2),
            })
        };
        let metrics = self.metrics.as_ref().map(|m| {
            let psnr = m.psnr();
            json!({
                "pixels": m.n_pixels,
                "linear_light": m.linear,
                "alpha_compared": m.alpha,
                "non_finite": m.non_finite,
                "differing": m.n_different,
                "beyond_fail": self.n_beyond,
                "percent_beyond_fail": 100.0 * self.n_beyond as f64 / m.n_pixels as f64,
                "largest": m.largest,
                "rmse": m.rmse,
                "rmse_of_channel": m.rmse_of_channel,
                "mean_absolute": m.mean_absolute,
                "psnr_db": psnr.is_finite().then_some(psnr),
                "flip": m.flip.as_ref().map(|f| f.1),
            })
        });
        json!({
            "verdict": self.verdict.word(),
            "why": self.why,
            "errors": self.errors,
            "a": file(0),
            "b": file(1),
            "metrics": metrics,
        })
    }
}

fn decibels(psnr: f64) -> String {
    if psnr.is_infinite() { "PSNR infinite".into() } else { format!("PSNR {psnr:.2} dB") }
}
