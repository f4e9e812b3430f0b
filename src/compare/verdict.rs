//! From distances to a yes or no.

use super::Metrics;

/// What still counts as the same picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// A pixel fails when a channel differs by more than this (1 is the whole range)...
    pub fail: f64,
    /// ...and the picture does when more than this percentage of its pixels fails.
    pub percent: f64,
    /// No pixel may differ by more than this.
    pub hard_fail: Option<f64>,
    /// Pixels that differ by more than this are worth a warning.
    pub warn: Option<f64>,
    /// Percentage of pixels beyond `warn` that is not.
    pub warn_percent: f64,
    /// Largest mean FLIP.
    pub max_flip: Option<f64>,
    /// Smallest PSNR in dB.
    pub min_psnr: Option<f64>,
    /// Smallest SSIM.
    pub min_ssim: Option<f64>,
}

impl Default for Tolerance {
    /// Not a bit may differ.
    fn default() -> Self {
        Self { fail: 0.0, percent: 0.0, hard_fail: None, warn: None, warn_percent: 0.0, max_flip: None, min_psnr: None, min_ssim: None }
    }
}

/// What two pictures are to each other. Also the exit code of `rayloom diff`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Verdict {
    /// Within the tolerance.
    Same = 0,
    /// Within the tolerance, but not within what was to be warned of.
    Warn = 1,
    /// Outside the tolerance, of different sizes, or with values that are no numbers.
    Different = 2,
    /// At least one of them could not be read.
    Unreadable = 4,
}

impl Verdict {
    /// For people and JSON.
    pub fn word(self) -> &'static str {
        match self {
            Self::Same => "same",
            Self::Warn => "warn",
            Self::Different => "different",
            Self::Unreadable => "unreadable",
        }
    }
}

impl Tolerance {
    /// The verdict, and why when it is not [`Verdict::Same`].
    pub fn judge(&self, m: &Metrics) -> (Verdict, Vec<String>) {
        let mut why = Vec::new();
        let percent = |n: u64| 100.0 * n as f64 / m.n_pixels as f64;
        if m.non_finite != [0; 2] {
            why.push(format!("{} pixels of A and {} of B are NaN or infinite", m.non_finite[0], m.non_finite[1]));
        }
        let beyond = percent(m.n_beyond(self.fail));
        if beyond > self.percent {
            why.push(format!("{beyond:.4} % of the pixels differ by more than {}, {} % may", self.fail, self.percent));
        }
        if let Some(limit) = self.hard_fail
            && m.n_beyond(limit) > 0
        {
            why.push(format!("a pixel differs by {:.6}, none may by more than {limit}", m.largest.value));
        }
        if let Some(limit) = self.min_psnr
            && !(m.psnr() >= limit)
        {
            why.push(format!("PSNR is {:.2} dB, at least {limit} is asked for", m.psnr()));
        }
        if let Some(limit) = self.min_ssim
            && !m.ssim.is_some_and(|s| s >= limit)
        {
            why.push(format!("SSIM is {}, at least {limit} is asked for", m.ssim.map_or("not defined".into(), |s| format!("{s:.6}"))));
        }
        if let Some(limit) = self.max_flip {
            match &m.flip {
                Some((_, mean)) if *mean <= limit => {}
                Some((_, mean)) => why.push(format!("FLIP is {mean:.6}, at most {limit} is asked for")),
                None => why.push("FLIP could not be computed".into()),
            }
        }
        if !why.is_empty() {
            return (Verdict::Different, why);
        }
        if let Some(limit) = self.warn {
            let beyond = percent(m.n_beyond(limit));
            if beyond > self.warn_percent {
                why.push(format!("{beyond:.4} % of the pixels differ by more than {limit}"));
                return (Verdict::Warn, why);
            }
        }
        (Verdict::Same, why)
    }
}
