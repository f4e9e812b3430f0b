//! From two pictures and a tolerance to a verdict with its reasons.

use super::estimate;
use super::limits::Limits;
use super::results::{Numbers, PairResult, State};
use crate::compare::{CompareOptions, DEFAULT_MAX_PIXELS, Estimate, Flip, Metrics, Picture, compare, z_test};
use std::path::Path;

/// |z| of a whole picture's mean that chance does not reach.
const MEAN_Z: f64 = 5.0;
/// Badness of what cannot be judged.
pub const WORST: f64 = 1e9;

/// What is held against what.
pub struct Pair<'p> {
    /// "cpu-povray".
    pub name: &'p str,
    /// Our picture.
    pub ours: &'p Path,
    /// The other.
    pub theirs: &'p Path,
    /// Mean and variance of ours, where it was made with several seeds.
    pub estimate: Option<&'p Estimate>,
}

/// Compares the two files.
pub fn judge(pair: &Pair, limits: &Limits) -> PairResult {
    let mut result = PairResult {
        pair: pair.name.into(),
        state: State::Broken,
        why: vec![],
        badness: WORST,
        limits: in_words(limits),
        numbers: None,
        ours: pair.ours.to_owned(),
        theirs: pair.theirs.to_owned(),
    };
    let (a, b) = rayon::join(|| Picture::read(pair.ours, DEFAULT_MAX_PIXELS), || Picture::read(pair.theirs, DEFAULT_MAX_PIXELS));
    let (a, b) = match (a, b) {
        (Ok(a), Ok(b)) => (a, b),
        (a, b) => {
            result.why = [a.err(), b.err()].into_iter().flatten().map(|e| e.to_string()).collect();
            return result;
        }
    };
    let means = |p: Picture| match limits.means {
        Some(side) => p.into_means(side),
        None => p,
    };
    let sizes = format!("sizes differ: {} x {} and {} x {}", a.width, a.height, b.width, b.height);
    let options = CompareOptions { flip: Flip::Ldr, ..CompareOptions::default() };
    let sized = (a.width, a.height) == (b.width, b.height);
    let Some(m) = sized.then(|| compare(means(a), means(b), &options)).flatten() else {
        (result.state, result.why) = (State::Failed, vec![sizes]);
        return result;
    };
    let mut found = Findings::default();
    if m.non_finite != [0; 2] {
        found.fails(format!("{} pixels of ours and {} of the other are NaN or infinite", m.non_finite[0], m.non_finite[1]), WORST);
    }
    let mut numbers = exact(&m, limits, pair.estimate.is_none(), &mut found);
    if let (Some(ours), Some(significance)) = (pair.estimate, limits.significance) {
        match estimate::read(pair.theirs) {
            Err(e) => found.fails(e.to_string(), WORST),
            Ok(theirs) => {
                if let Some(t) = z_test(ours, &theirs, significance) {
                    noisy(&t, &m, limits, &mut found);
                    numbers = numbers.with_z(&t);
                }
            }
        }
    }
    result.numbers = Some(numbers);
    result.state = if found.why.is_empty() { State::Passed } else { State::Failed };
    (result.why, result.badness) = (found.why, found.badness.min(WORST));
    result
}

#[derive(Default)]
struct Findings {
    why: Vec<String>,
    badness: f64,
}

impl Findings {
    fn fails(&mut self, why: String, badness: f64) {
        self.why.push(why);
        self.badness = self.badness.max(badness);
    }

    /// `value` may be up to `limit`; `least` stands for a limit of 0 in the badness.
    fn at_most(&mut self, value: f64, limit: f64, least: f64, why: impl Fn() -> String) {
        self.badness = self.badness.max(value / limit.max(least));
        if !(value <= limit) {
            self.why.push(why());
        }
    }
}

/// What is judged of exact pictures. The ratio of the means is left to the test of noisy ones there.
fn exact(m: &Metrics, limits: &Limits, judge_means: bool, found: &mut Findings) -> Numbers {
    let percent = |t: Option<f64>| t.map_or(0.0, |t| 100.0 * m.n_beyond(t) as f64 / m.n_pixels.max(1) as f64);
    let psnr = m.psnr();
    let n = Numbers {
        percent_beyond: percent(limits.fail),
        percent_far: percent(limits.hard_fail),
        largest: m.largest.value,
        at: m.largest.at,
        rmse: m.rmse,
        psnr_db: psnr.is_finite().then_some(psnr),
        mean_ratio: m.mean_ratio(),
        flip: m.flip.as_ref().map(|f| f.1),
        z: None,
    };
    if let Some(fail) = limits.fail {
        let may = limits.percent.unwrap_or(0.0);
        let why = || format!("{:.3} % of the pixels differ by more than {}, {may} % may", n.percent_beyond, shown(fail));
        found.at_most(n.percent_beyond, may, 0.01, why);
    }
    if let Some(hard) = limits.hard_fail {
        let may = limits.hard_percent.unwrap_or(0.0);
        let at = format!("the largest by {} at column {}, row {}", shown(n.largest), n.at[0], n.at[1]);
        let why = || format!("{:.3} % of the pixels are far off, by more than {} ({at}); {may} % may", n.percent_far, shown(hard));
        found.at_most(n.percent_far, may, 0.01, why);
    }
    if let Some(limit) = limits.max_flip {
        match n.flip {
            Some(flip) => found.at_most(flip, limit, 1e-4, || format!("FLIP is {flip:.5}, {limit} may be")),
            None => found.fails("FLIP could not be computed".into(), WORST),
        }
    }
    if let Some(limit) = limits.min_psnr {
        found.at_most(-psnr, -limit, 1e-4, || format!("PSNR is {psnr:.2} dB, at least {limit} is asked for"));
    }
    if let (Some(limit), true) = (limits.mean_ratio, judge_means) {
        let why = || format!("the means differ by {:.3} %, {} % may be", 100.0 * n.mean_ratio, 100.0 * limit);
        found.at_most(n.mean_ratio, limit, 1e-5, why);
    }
    n
}

fn noisy(t: &crate::compare::ZTest, m: &Metrics, limits: &Limits, found: &mut Findings) {
    if t.n_non_finite > 0 {
        found.fails(format!("{} values are NaN or infinite", t.n_non_finite), WORST);
    }
    let beyond = 100.0 * t.n_beyond as f64 / t.n_values as f64;
    let may = limits.significant_percent.unwrap_or(0.0);
    let place = format!("|z| up to {:.1} at column {}, row {}", t.largest, t.at[0], t.at[1]);
    let why = || format!("{} values ({beyond:.3} %) are beyond chance ({place}); {may} % may", t.n_beyond);
    found.at_most(beyond, may, 0.01, why);
    let ratio = m.mean_ratio();
    if let Some(limit) = limits.mean_ratio
        && t.mean_z > MEAN_Z
    {
        let why =
            || format!("the means differ by {:.3} %, {} % may be, and it is no chance (z = {:.1})", 100.0 * ratio, 100.0 * limit, t.mean_z);
        found.at_most(ratio, limit, 1e-5, why);
    }
}

/// A difference in 255ths where it is one.
fn shown(v: f64) -> String {
    let steps = 255.0 * v;
    if (steps - steps.round()).abs() < 1e-6 { format!("{}/255", steps.round()) } else { format!("{v:.5}") }
}

fn in_words(l: &Limits) -> String {
    let mut parts = Vec::new();
    if let Some(v) = l.fail {
        parts.push(format!("{} % beyond {}", l.percent.unwrap_or(0.0), shown(v)));
    }
    if let Some(v) = l.hard_fail {
        parts.push(format!("{} % beyond {}", l.hard_percent.unwrap_or(0.0), shown(v)));
    }
    parts.extend(l.max_flip.map(|v| format!("FLIP up to {v}")));
    parts.extend(l.min_psnr.map(|v| format!("PSNR from {v} dB")));
    parts.extend(l.mean_ratio.map(|v| format!("means within {} %", 100.0 * v)));
    parts.extend(l.means.map(|n| format!("over means of {n} by {n} pixels")));
    parts.extend(l.significance.map(|v| format!("z-test at {v}")));
    let reason = l.reason.as_ref().map_or(String::new(), |r| format!(" ({r})"));
    format!("{}{reason}", parts.join(", "))
}
