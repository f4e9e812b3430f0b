//! Error against time: the same picture with more and more samples (or POV-Ray's antialiasing, finer and finer), several seeds each, by every
//! renderer in turn. Errors are measured against a reference picture in linear light; times leave loading and writing out.

use crate::backend::Backend;
use crate::compare::{CompareOptions, Flip, Picture, Space, compare};
use crate::compile::{CompileOptions, compile_scene};
use crate::cpu_time::process_seconds;
use crate::film::Film;
use crate::integrate::{Antialias, IntegratorKind, RenderSettings};
use crate::lang::options::PovOptions;
use crate::scene::Scene;
use std::path::PathBuf;
use std::process::Command;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// A picture and what it took.
pub struct Timed {
    /// In linear light.
    pub picture: Picture,
    /// Wall clock seconds.
    pub wall: f64,
    /// Seconds of all processor cores together; NaN where they cannot be told.
    pub cpu: f64,
}

/// How much work goes into a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Setting {
    /// Path traced, with so many samples a pixel.
    Samples(u32),
    /// POV-Ray's light transport and antialiasing; none for one sample in the middle of each pixel.
    Antialias(Option<Supersampling>),
}

/// What of POV-Ray's antialiasing decides its work: `+AM +A +R`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Supersampling {
    /// 1 or 2.
    pub method: u8,
    /// Difference that asks for more samples, 0 to 1.
    pub threshold: f32,
    /// 1 to 9.
    pub depth: u8,
}

impl std::fmt::Display for Setting {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        match self {
            Self::Samples(n) => write!(f, "{n}"),
            Self::Antialias(None) => write!(f, "off"),
            Self::Antialias(Some(a)) => write!(f, "{}:{}:{}", a.method, a.threshold, a.depth),
        }
    }
}

impl std::str::FromStr for Supersampling {
    type Err = String;

    /// `METHOD:THRESHOLD:DEPTH`.
    fn from_str(text: &str) -> Result<Self, String> {
        let words: Vec<&str> = text.split(':').collect();
        let [method, threshold, depth] = words[..] else { return Err("METHOD:THRESHOLD:DEPTH is expected, as 1:0.3:3".into()) };
        match (method.parse(), threshold.parse(), depth.parse()) {
            (Ok(method @ 1..=2), Ok(threshold), Ok(depth @ 1..=9)) if (0.0..=1.0).contains(&threshold) => {
                Ok(Self { method, threshold, depth })
            }
            _ => Err("method 1 or 2, threshold 0 to 1, depth 1 to 9".into()),
        }
    }
}

impl Supersampling {
    /// The rest as POV-Ray has it where nothing is said.
    fn with_defaults(self) -> Antialias {
        let (Self { method, threshold, depth }, o) = (self, PovOptions::default());
        Antialias { method, threshold, depth, jitter: if o.jitter { o.jitter_amount } else { 0.0 }, gamma: o.antialias_gamma as f32 }
    }
}

/// Something that renders the picture.
pub trait Renderer {
    /// For tables.
    fn name(&self) -> String;
    /// The picture.
    ///
    /// # Errors
    /// What the renderer said.
    fn render(&mut self, setting: Setting, seed: u32) -> Result<Timed, String>;
}

/// This renderer on a device.
pub struct Ours<'a> {
    /// Where.
    pub backend: &'a dyn Backend,
    /// What.
    pub scene: &'a Scene,
    /// Columns and rows.
    pub size: (u32, u32),
    /// Threads.
    pub threads: usize,
}

impl Renderer for Ours<'_> {
    fn name(&self) -> String {
        format!("rayloom, {}", self.backend.name())
    }

    fn render(&mut self, setting: Setting, seed: u32) -> Result<Timed, String> {
        let (width, height) = self.size;
        let plain = RenderSettings { threads: self.threads, in_order: self.threads == 1, seed, ..RenderSettings::plain(width, height) };
        let settings = match setting {
            Setting::Samples(n) => RenderSettings { samples: 0..n, integrator: IntegratorKind::Path, ..plain },
            Setting::Antialias(a) => RenderSettings { antialias: a.map(Supersampling::with_defaults), ..plain },
        };
        let mut film = Film::new(width, height);
        let (start, before) = (Instant::now(), process_seconds());
        let scene = compile_scene(self.scene, &CompileOptions::default()).map_err(|e| e.to_string())?;
        self.backend.render(&scene, &settings, &mut film, &(), &AtomicBool::new(false)).map_err(|e| e.to_string())?;
        let (wall, cpu) = (start.elapsed().as_secs_f64(), process_seconds() - before);
        let depth = "32-bit float".into();
        Ok(Timed { picture: Picture { width, height, pixels: film.pixels, has_alpha: false, linear: true, depth }, wall, cpu })
    }
}

/// Another program, through a script of ours for Python that takes SCENE WIDTH HEIGHT SETTING SEED THREADS OUT.exr and prints "seconds WALL CPU".
pub struct Peer {
    /// For tables.
    pub name: String,
    /// The interpreter.
    pub python: PathBuf,
    /// The script.
    pub script: PathBuf,
    /// What it renders.
    pub scene: PathBuf,
    /// Columns and rows.
    pub size: (u32, u32),
    /// Threads.
    pub threads: usize,
    /// Where the picture goes.
    pub out: PathBuf,
    /// More arguments of the script.
    pub more: Vec<String>,
}

impl Renderer for Peer {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn render(&mut self, setting: Setting, seed: u32) -> Result<Timed, String> {
        let numbers = [&self.size.0 as &dyn std::fmt::Display, &self.size.1, &setting, &seed, &self.threads].map(|n| n.to_string());
        let mut command = Command::new(&self.python);
        command.arg(&self.script).arg(&self.scene).args(numbers).arg(&self.out).args(&self.more);
        let ended = command.output().map_err(|e| format!("cannot run '{}': {e}", self.python.display()))?;
        let told = String::from_utf8_lossy(&ended.stdout);
        let seconds = told.lines().rev().find_map(|l| l.strip_prefix("seconds ")).and_then(|l| {
            let (wall, cpu) = l.split_once(' ')?;
            Some((wall.parse().ok()?, cpu.parse().ok()?))
        });
        let Some((wall, cpu)) = seconds else {
            let error = String::from_utf8_lossy(&ended.stderr);
            return Err(format!("{} gave no picture: {}", self.name, error.lines().last().unwrap_or("it said nothing")));
        };
        let picture = Picture::read(&self.out, u64::MAX).map_err(|e| e.to_string())?;
        Ok(Timed { picture: picture.into_linear(), wall, cpu })
    }
}

/// One picture, judged.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// Which renderer.
    pub renderer: String,
    /// With what work.
    pub setting: Setting,
    /// Seed.
    pub seed: u32,
    /// Wall clock seconds.
    pub wall: f64,
    /// Seconds of all cores.
    pub cpu: f64,
    /// Squared differences over the squared reference plus 0.01, values clamped to 1.
    pub rel_mse: f64,
    /// Mean FLIP of the pictures as shown.
    pub flip: f64,
    /// How far the mean is from the reference's, as a share of it, in the channel where that is most; values clamped to 1.
    pub mean_error: f64,
}

/// Renders and judges: seed after seed, all settings, the renderers in turn, so that a busy machine slows all alike.
///
/// # Errors
/// The first renderer that fails, or a picture of another size.
pub fn run(
    renderers: &mut [&mut dyn Renderer],
    reference: &Picture,
    settings: &[Setting],
    seeds: u32,
    told: &mut dyn FnMut(&Point),
) -> Result<Vec<Point>, String> {
    let mut points = Vec::new();
    let reference = clamped(reference.clone());
    for seed in 0..seeds {
        for setting in settings {
            for r in renderers.iter_mut() {
                let timed = r.render(*setting, seed)?;
                let options = CompareOptions { space: Space::Linear, flip: Flip::Ldr, ..CompareOptions::default() };
                let m = compare(clamped(timed.picture), reference.clone(), &options)
                    .ok_or_else(|| format!("{} gave a picture of another size than the reference", r.name()))?;
                let point = Point {
                    renderer: r.name(),
                    setting: *setting,
                    seed,
                    wall: timed.wall,
                    cpu: timed.cpu,
                    rel_mse: m.rel_mse,
                    flip: m.flip.as_ref().map_or(f64::NAN, |f| f.1),
                    mean_error: m.mean_ratio(),
                };
                told(&point);
                points.push(point);
            }
        }
    }
    Ok(points)
}

/// Seed of the pictures that make a reference: not one of those that are judged.
const REFERENCE_SEED: u32 = 1_000_000;
/// Converged pictures of one scene differ by less: ANCHORS' gate.
pub const AGREEMENT: f64 = 1e-4;

/// A reference that favours nobody: the mean of every renderer's picture of this setting. With it, by renderer, how far (relMSE) its own
/// is from the mean of the others.
///
/// # Errors
/// As [`run`].
pub fn common_reference(renderers: &mut [&mut dyn Renderer], setting: Setting) -> Result<(Picture, Vec<f64>), String> {
    let mut pictures = Vec::new();
    for r in renderers.iter_mut() {
        pictures.push(r.render(setting, REFERENCE_SEED)?.picture);
    }
    let mean_of = |list: &[&Picture]| {
        let mut sum = list[0].clone();
        for (k, v) in sum.pixels.iter_mut().enumerate() {
            for c in 0..4 {
                v[c] = list.iter().map(|p| p.pixels[k][c]).sum::<f32>() / list.len() as f32;
            }
        }
        sum
    };
    if pictures.iter().any(|p| (p.width, p.height) != (pictures[0].width, pictures[0].height)) {
        return Err("the renderers gave pictures of different sizes".into());
    }
    let all: Vec<&Picture> = pictures.iter().collect();
    let options = CompareOptions { space: Space::Linear, ..CompareOptions::default() };
    let apart = |k: usize| {
        let others: Vec<&Picture> = all.iter().enumerate().filter(|(j, _)| *j != k).map(|(_, p)| *p).collect();
        if others.is_empty() {
            return f64::NAN;
        }
        compare(clamped(all[k].clone()), clamped(mean_of(&others)), &options).map_or(f64::NAN, |m| m.rel_mse)
    };
    let apart = (0..all.len()).map(apart).collect();
    Ok((mean_of(&all), apart))
}

/// Fireflies are not what is measured: values above 1 count as 1.
fn clamped(mut p: Picture) -> Picture {
    p.pixels.iter_mut().flatten().for_each(|v| *v = v.min(1.0));
    p.has_alpha = false;
    p
}

/// Mean over the seeds of a renderer's pictures with as much work.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mean {
    /// With what work.
    pub setting: Setting,
    /// Seconds (cores or wall clock).
    pub seconds: f64,
    /// Mean error.
    pub rel_mse: f64,
    /// Half of the width of the 95 % interval of the error.
    pub spread: f64,
    /// Mean FLIP.
    pub flip: f64,
}

/// Means of one renderer, in the order measured. `by_cpu` takes the cores' seconds instead of the clock's.
pub fn means(points: &[Point], renderer: &str, by_cpu: bool) -> Vec<Mean> {
    let mut settings: Vec<Setting> = Vec::new();
    for p in points.iter().filter(|p| p.renderer == renderer) {
        if !settings.contains(&p.setting) {
            settings.push(p.setting);
        }
    }
    let of = |setting: Setting| {
        let own: Vec<&Point> = points.iter().filter(|p| p.renderer == renderer && p.setting == setting).collect();
        let n = own.len() as f64;
        let mean = |f: &dyn Fn(&Point) -> f64| own.iter().map(|p| f(p)).sum::<f64>() / n;
        let rel_mse = mean(&|p| p.rel_mse);
        let variance = own.iter().map(|p| (p.rel_mse - rel_mse).powi(2)).sum::<f64>() / (n - 1.0).max(1.0);
        let seconds = mean(&|p| if by_cpu && p.cpu.is_finite() { p.cpu } else { p.wall });
        Mean { setting, seconds, rel_mse, spread: 1.96 * (variance / n).sqrt(), flip: mean(&|p| p.flip) }
    };
    settings.into_iter().map(of).filter(|m| m.rel_mse.is_finite()).collect()
}

/// Those that nothing quicker is as good as, the quickest first.
pub fn best(means: &[Mean]) -> Vec<Mean> {
    let mut sorted = means.to_vec();
    sorted.sort_by(|a, b| a.seconds.total_cmp(&b.seconds));
    let mut least = f64::INFINITY;
    sorted.retain(|m| {
        let better = m.rel_mse < least;
        least = least.min(m.rel_mse);
        better
    });
    sorted
}

/// Seconds until the error is `target`, between the best measured on a double logarithmic line; `None` outside of them.
pub fn seconds_to(means: &[Mean], target: f64) -> Option<f64> {
    best(means).windows(2).find(|w| w[0].rel_mse >= target && w[1].rel_mse <= target).map(|w| {
        let [a, b] = [&w[0], &w[1]].map(|m| (m.seconds.ln(), m.rel_mse.ln()));
        let along = if a.1 == b.1 { 0.0 } else { (a.1 - target.ln()) / (a.1 - b.1) };
        (a.0 + along * (b.0 - a.0)).exp()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(samples: u32, wall: f64, rel_mse: f64) -> Point {
        Point {
            renderer: "r".into(),
            setting: Setting::Samples(samples),
            seed: 0,
            wall,
            cpu: f64::NAN,
            rel_mse,
            flip: 0.0,
            mean_error: 1.0,
        }
    }

    #[test]
    fn times_between_two_counts_lie_on_the_line() {
        let m = means(&[point(1, 1.0, 1.0), point(16, 16.0, 0.0625), point(16, 16.0, 0.0625)], "r", true);
        assert_eq!(m.len(), 2);
        assert!((seconds_to(&m, 0.25).expect("between") - 4.0).abs() < 1e-9);
        assert_eq!(seconds_to(&m, 2.0), None);
        assert_eq!(seconds_to(&m, 0.01), None);
    }

    #[test]
    fn what_is_slower_and_no_better_is_passed_over() {
        let m = means(&[point(1, 1.0, 1.0), point(2, 8.0, 2.0), point(4, 4.0, 0.25), point(8, 5.0, 0.25)], "r", false);
        assert_eq!(best(&m).iter().map(|m| m.seconds).collect::<Vec<_>>(), [1.0, 4.0]);
        assert!((seconds_to(&m, 0.5).expect("between") - 2.0).abs() < 1e-9);
    }

    #[test]
    fn antialiasing_is_read_as_it_is_told() {
        for text in ["1:0.3:3", "2:0:9"] {
            let a: Supersampling = text.parse().expect("well formed");
            assert_eq!(Setting::Antialias(Some(a)).to_string(), text);
        }
        for text in ["", "1:0.3", "3:0.3:3", "1:2:3", "1:0.3:0", "1:0.3:3:4", "1:NaN:3"] {
            assert!(text.parse::<Supersampling>().is_err(), "{text}");
        }
    }
}
