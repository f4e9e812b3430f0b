//! What came of two picture files: for people, for programs, and as an exit code.

use super::diff::DiffArgs;
use rayloom::compare::{CompareOptions, Flip, Metrics, Picture, Tolerance, Verdict, compare, difference_map, flip_map, read_layers};
use serde_json::{Value, json};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// What came of two files.
pub struct Outcome {
    paths: [PathBuf; 2],
    /// The worst of all layers.
    pub verdict: Verdict,
    /// Why the verdict is not "same".
    why: Vec<String>,
    /// Files that cannot be read.
    pub errors: Vec<String>,
    /// Size and depth of each file that was read.
    files: [Option<(u32, u32, String)>; 2],
    metrics: Option<Metrics>,
    n_beyond: u64,
    /// Of each layer, where layers were asked for.
    layers: Vec<Value>,
}

impl Outcome {
    pub fn of(args: &DiffArgs, a: &Path, b: &Path) -> Self {
        let mut outcome = Self {
            paths: [a.into(), b.into()],
            verdict: Verdict::Unreadable,
            why: vec![],
            errors: vec![],
            files: [None, None],
            metrics: None,
            n_beyond: 0,
            layers: vec![],
        };
        let read = |path: &Path| match &args.layer {
            None => Picture::read(path, args.max_pixels).map(|p| [(String::new(), p)].into()),
            Some(_) => read_layers(path, args.max_pixels),
        };
        let mut pictures: Vec<BTreeMap<String, Picture>> = Vec::new();
        let (first, second) = rayon::join(|| read(a), || read(b));
        for (i, read) in [first, second].into_iter().enumerate() {
            match read {
                Ok(layers) => {
                    outcome.files[i] = layers.values().next().map(|p| (p.width, p.height, p.depth.clone()));
                    pictures.push(layers);
                }
                Err(e) => outcome.errors.push(e.to_string()),
            }
        }
        let (Some(mut b), Some(mut a)) = (pictures.pop(), pictures.pop()) else { return outcome };
        let mut names: BTreeSet<String> = a.keys().chain(b.keys()).cloned().collect();
        if let Some(wanted) = args.layer.as_ref().filter(|l| *l != "all") {
            names.retain(|n| n == wanted);
            if names.is_empty() {
                outcome.errors.push(format!("neither picture has a layer '{wanted}'"));
                return outcome;
            }
        }
        outcome.verdict = Verdict::Same;
        for name in names {
            match (a.remove(&name), b.remove(&name)) {
                (Some(p), Some(q)) => outcome.add(args, &name, p, q),
                (p, _) => {
                    outcome.verdict = Verdict::Different;
                    let here = if p.is_some() { "A" } else { "B" };
                    outcome.why.push(format!("layer '{name}' is in {here} only"));
                }
            }
        }
        outcome
    }

    /// Compares a layer. The first one's numbers are those of the pictures.
    fn add(&mut self, args: &DiffArgs, name: &str, a: Picture, b: Picture) {
        let before = if name.is_empty() { String::new() } else { format!("layer '{name}': ") };
        let sizes = format!("{before}sizes differ: {} x {} and {} x {}", a.width, a.height, b.width, b.height);
        let mask = match mask(args, a.width, a.height) {
            Ok(mask) => mask,
            Err(e) => {
                self.verdict = Verdict::Unreadable;
                return self.errors.push(e);
            }
        };
        let options = CompareOptions {
            space: args.space.into(),
            exposure: args.exposure,
            flip: match (args.no_flip, args.hdr_flip) {
                (true, _) => Flip::None,
                (_, true) => Flip::Hdr,
                _ => Flip::Ldr,
            },
            ssim: args.ssim || args.min_ssim.is_some(),
            mask: mask.as_deref(),
        };
        let Some(metrics) = compare(a, b, &options) else {
            self.verdict = self.verdict.max(Verdict::Different);
            return self.why.push(sizes);
        };
        let tolerance = Tolerance {
            fail: args.fail,
            percent: args.percent,
            hard_fail: args.hard_fail,
            warn: args.warn,
            warn_percent: args.warn_percent,
            max_flip: args.max_flip,
            min_psnr: args.min_psnr,
            min_ssim: args.min_ssim,
        };
        let (verdict, why) = tolerance.judge(&metrics);
        self.verdict = self.verdict.max(verdict);
        self.why.extend(why.into_iter().map(|w| before.clone() + &w));
        if args.layer.is_some() {
            let psnr = metrics.psnr();
            self.layers.push(json!({
                "name": name, "verdict": verdict.word(), "rmse": metrics.rmse, "rel_mse": metrics.rel_mse,
                "largest": metrics.largest, "psnr_db": psnr.is_finite().then_some(psnr), "differing": metrics.n_different,
                "non_finite": metrics.non_finite, "flip": metrics.flip.as_ref().map(|f| f.1),
            }));
        }
        if self.metrics.is_none() {
            self.n_beyond = metrics.n_beyond(args.fail);
            self.metrics = Some(metrics);
        }
    }

    /// Where and how much they differ.
    pub fn heatmap(&self) -> Option<image::RgbImage> {
        let (width, height, _) = self.files[0].as_ref()?;
        Some(difference_map(self.metrics.as_ref()?, *width, *height))
    }

    /// FLIP as the reference tool paints it.
    pub fn flip_map(&self) -> Option<image::RgbImage> {
        flip_map(self.metrics.as_ref()?)
    }

    /// The numbers in a few words, for lists.
    pub fn line(&self) -> String {
        match &self.metrics {
            Some(m) => format!("  {}, largest difference {:.6}{}", decibels(m.psnr()), m.largest.value, self.flip_text(", FLIP ")),
            None => self.why.first().map_or(String::new(), |w| format!("  {w}")),
        }
    }

    fn flip_text(&self, before: &str) -> String {
        let flip = self.metrics.as_ref().and_then(|m| m.flip.as_ref());
        flip.map_or(String::new(), |(_, mean)| format!("{before}{mean:.6}"))
    }

    pub fn text(&self, args: &DiffArgs) -> String {
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
            lines.push(format!("mean absolute        {:.6}, relMSE {:.6}", m.mean_absolute, m.rel_mse));
            if let Some(ssim) = m.ssim {
                lines.push(format!("SSIM                 {ssim:.6}"));
            }
            if m.flip.is_some() {
                lines.push(self.flip_text(if args.hdr_flip { "HDR-FLIP             " } else { "FLIP                 " }));
            }
        }
        for l in self.layers.iter().skip(1) {
            let number = |key: &str| l[key].as_f64().map_or("-".into(), |v| format!("{v:.6}"));
            let name = l["name"].as_str().unwrap_or_default();
            lines.push(format!("layer {name:<14} RMSE {}, largest {}", number("rmse"), l["largest"]["value"].as_f64().unwrap_or(0.0)));
        }
        lines.extend(self.why.iter().cloned());
        if self.errors.is_empty() {
            lines.push(format!("verdict: {}", self.verdict.word()));
        }
        lines.iter().map(|l| format!("{l}\n")).collect()
    }

    pub fn json(&self) -> Value {
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
                "rel_mse": m.rel_mse,
                "mean_absolute": m.mean_absolute,
                "means": m.means,
                "ssim": m.ssim,
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
            "layers": self.layers,
        })
    }
}

fn decibels(psnr: f64) -> String {
    if psnr.is_infinite() { "PSNR infinite".into() } else { format!("PSNR {psnr:.2} dB") }
}

/// Pixels that count: in one of the regions, where there are any, and light in the mask, where there is one.
fn mask(args: &DiffArgs, width: u32, height: u32) -> Result<Option<Vec<bool>>, String> {
    if args.mask.is_none() && args.region.is_empty() {
        return Ok(None);
    }
    let mut mask = vec![args.region.is_empty(); width as usize * height as usize];
    for &[x0, y0, x1, y1] in &args.region {
        if x1 > width || y1 > height {
            return Err(format!("the region {x0},{y0},{x1},{y1} reaches beyond the picture of {width} x {height}"));
        }
        for y in y0..y1 {
            let row = y as usize * width as usize;
            mask[row + x0 as usize..row + x1 as usize].fill(true);
        }
    }
    if let Some(path) = &args.mask {
        let p = Picture::read(path, args.max_pixels).map_err(|e| e.to_string())?;
        if (p.width, p.height) != (width, height) {
            return Err(format!("the mask {} is {} x {}, the pictures are {width} x {height}", path.display(), p.width, p.height));
        }
        mask.iter_mut().zip(&p.pixels).for_each(|(m, p)| *m &= p[0].max(p[1]).max(p[2]) >= 0.5);
    }
    if !mask.contains(&true) {
        return Err("the mask and the regions leave no pixel".into());
    }
    Ok(Some(mask))
}
