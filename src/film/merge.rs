//! Parts of one picture, rendered apart (crops, ranges of samples), into the whole: the mean of each pixel's samples.

use super::exr_file::{Part, read_exr};
use super::{DENOISED, Film, FilmError, Metadata, PixelSamples};
use crate::scene::PassSet;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// What must be equal in parts of one picture: these entries, and all whose name starts with `camera`.
const SAME: &[&str] = &["integrator", "antialiasing"];
/// The entry that names the range of samples, "0..16".
const SAMPLES: &str = "samples";

/// Reads the parts and merges them.
///
/// # Errors
/// Parts of other sizes, scenes, cameras, integrators or passes, a pixel whose same samples are in two parts, files that are unreadable
/// or larger than `max_pixels`.
pub fn merge(paths: &[PathBuf], max_pixels: u64) -> Result<Part, FilmError> {
    let mut whole: Option<Whole> = None;
    for path in paths {
        let part = read_exr(path, max_pixels)?;
        if part.film.denoised.is_none() && part.metadata.entries.iter().any(|(name, _)| name == DENOISED) {
            let reason = "it is denoised and does not hold the noisy colours; render the parts without --denoise, merge them, and run `rayloom denoise`";
            return Err(FilmError::Foreign { path: path.clone(), reason: reason.into() });
        }
        match &mut whole {
            None => whole = Some(Whole::new(part)),
            Some(whole) => whole.add(part).map_err(|reason| FilmError::Foreign { path: path.clone(), reason })?,
        }
    }
    match whole {
        Some(whole) => Ok(whole.finish()),
        None => Err(FilmError::Foreign { path: Path::new("").into(), reason: "there is nothing to merge".into() }),
    }
}

/// Sums over the parts so far.
struct Whole {
    width: u32,
    height: u32,
    /// Sums of samples.
    sums: Vec<[f64; 4]>,
    samples: Vec<u64>,
    /// Joins the passes; its colours are rounded and not used.
    layers: Film,
    /// First sample of what stands in each pixel of `layers`.
    first: Vec<u64>,
    alpha: bool,
    metadata: Metadata,
    /// What each part brought: range of samples, seed, which pixels.
    parts: Vec<(Option<Range<u64>>, String, Vec<bool>)>,
}

impl Whole {
    fn new(part: Part) -> Self {
        let n = part.film.pixels.len();
        let mut whole = Self {
            width: part.film.width,
            height: part.film.height,
            sums: vec![[0.0; 4]; n],
            samples: vec![0; n],
            layers: Film::with_passes(part.film.width, part.film.height, passes_of(&part.film)),
            first: vec![u64::MAX; n],
            alpha: part.alpha,
            metadata: part.metadata.clone(),
            parts: Vec::new(),
        };
        whole.sum(&part);
        whole
    }

    fn add(&mut self, part: Part) -> Result<(), String> {
        if (part.film.width, part.film.height) != (self.width, self.height) {
            let size = |w: u32, h: u32| format!("{w} by {h}");
            let (a, b) = (size(part.film.width, part.film.height), size(self.width, self.height));
            return Err(format!("this part belongs to a picture of {a} pixels, those before it to one of {b}"));
        }
        if part.alpha != self.alpha {
            return Err("some parts have alpha, others have none".into());
        }
        if passes_of(&part.film) != passes_of(&self.layers) {
            return Err(format!("this part has the passes {:?}, those before it {:?}", passes_of(&part.film), passes_of(&self.layers)));
        }
        if part.metadata.attributes != self.metadata.attributes {
            return Err("this part's Cryptomatte manifest names other things than that of those before it".into());
        }
        if part.metadata.scene != self.metadata.scene {
            return Err(format!("this part shows {:?}, those before it {:?}", part.metadata.scene, self.metadata.scene));
        }
        let names = |m: &Metadata| -> Vec<String> {
            let judged = |name: &&(String, String)| SAME.contains(&name.0.as_str()) || name.0.starts_with("camera");
            m.entries.iter().filter(judged).map(|(name, value)| format!("{name} {value}")).collect()
        };
        let (mine, theirs) = (names(&self.metadata), names(&part.metadata));
        if let Some(other) = theirs.iter().find(|e| !mine.contains(e)).or(mine.iter().find(|e| !theirs.contains(e))) {
            return Err(format!("this part was rendered with other settings: {other:?} is not in all parts"));
        }
        self.sum(&part);
        self.refuse_samples_twice()
    }

    fn sum(&mut self, part: &Part) {
        let entry = |name: &str| part.metadata.entries.iter().find(|(n, _)| n == name).map(|(_, v)| v.clone());
        let range = entry(SAMPLES).and_then(|v| parse_range(&v));
        let covered = part.film.samples.iter().map(|n| *n > 0).collect();
        let start = range.as_ref().map_or(0, |r| r.start);
        self.parts.push((range, entry("seed").unwrap_or_default(), covered));
        for (i, (pixel, n)) in part.film.pixels.iter().zip(&part.film.samples).enumerate() {
            if *n > 0 {
                let earlier = start < self.first[i];
                self.first[i] = self.first[i].min(start);
                self.layers.join(i, PixelSamples { color: *pixel, layers: &part.film.layers_at(i), n: *n, earlier });
                self.samples[i] += u64::from(*n);
                for c in 0..4 {
                    self.sums[i][c] += f64::from(pixel[c]) * f64::from(*n);
                }
            }
        }
    }

    /// Samples that were drawn from the same numbers are not two samples.
    fn refuse_samples_twice(&self) -> Result<(), String> {
        let Some(((Some(new), seed, pixels), earlier)) = self.parts.split_last() else { return Ok(()) };
        for (range, other_seed, other_pixels) in earlier {
            let Some(range) = range else { continue };
            let overlap = range.start < new.end && new.start < range.end && seed == other_seed;
            if overlap && pixels.iter().zip(other_pixels).any(|(a, b)| *a && *b) {
                let (a, b) = (format!("{}..{}", new.start, new.end), format!("{}..{}", range.start, range.end));
                return Err(format!("samples {a} of seed {seed} overlap samples {b} of an earlier part in the same pixels"));
            }
        }
        Ok(())
    }

    fn finish(self) -> Part {
        let mut film = Film { layers: self.layers.layers, ..Film::new(self.width, self.height) };
        for (i, n) in self.samples.iter().enumerate() {
            film.samples[i] = u32::try_from(*n).unwrap_or(u32::MAX);
            if *n > 0 {
                film.pixels[i] = self.sums[i].map(|v| (v / *n as f64) as f32);
            }
        }
        let mut metadata = self.metadata;
        metadata.entries.retain(|(name, _)| SAME.contains(&name.as_str()) || name.starts_with("camera") || name == "seed");
        let mut ranges: Vec<Range<u64>> = self.parts.into_iter().filter_map(|(range, ..)| range).collect();
        ranges.sort_by_key(|r| r.start);
        ranges.dedup();
        if let [first, .., last] | [first @ last] = ranges.as_slice()
            && ranges.windows(2).all(|w| w[0].end == w[1].start)
        {
            metadata.entries.push((SAMPLES.into(), format!("{}..{}", first.start, last.end)));
        }
        Part { film, alpha: self.alpha, metadata }
    }
}

fn passes_of(film: &Film) -> PassSet {
    film.layers.iter().map(|l| l.pass).collect()
}

fn parse_range(text: &str) -> Option<Range<u64>> {
    let (start, end) = text.split_once("..")?;
    Some(start.parse().ok()?..end.parse().ok()?)
}
