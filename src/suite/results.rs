//! What came of a suite: for the report, for JSON, and for the next run to compare with.

use super::spec::Machine;
use crate::compare::ZTest;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// How a case, or one comparison of it, stands. In order from good to bad.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum State {
    /// Within the tolerance.
    Passed,
    /// Something that it needs is not here.
    LeftOut,
    /// It fails as it is known to.
    KnownFailure,
    /// Outside the tolerance, or a known failure that fails no more.
    Failed,
    /// There is nothing to judge: a crash, a missing reference, a picture that cannot be read.
    Broken,
}

impl State {
    /// For people.
    pub fn word(self) -> &'static str {
        match self {
            Self::Passed => "passed",
            Self::LeftOut => "left out",
            Self::KnownFailure => "known failure",
            Self::Failed => "failed",
            Self::Broken => "broken",
        }
    }
}

/// The numbers of a comparison.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Numbers {
    /// Percentage of pixels that differ by more than `fail`.
    pub percent_beyond: f64,
    /// Percentage of pixels that differ by more than `hard_fail`.
    pub percent_far: f64,
    /// The largest difference of a channel, and its column and row.
    pub largest: f64,
    /// Where.
    pub at: [u32; 2],
    /// Over all channels.
    pub rmse: f64,
    /// `None` is infinite: equal pictures.
    pub psnr_db: Option<f64>,
    /// Distance of the ratio of the means from 1.
    pub mean_ratio: f64,
    /// Mean FLIP.
    pub flip: Option<f64>,
    /// The test of noisy pictures: values beyond chance, the largest |z|, the root mean square of z, |z| of the mean.
    pub z: Option<[f64; 4]>,
}

impl Numbers {
    pub(super) fn with_z(mut self, t: &ZTest) -> Self {
        self.z = Some([t.n_beyond as f64, t.largest, t.rms, t.mean_z]);
        self
    }
}

/// One comparison of two pictures.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct PairResult {
    /// "cpu-povray".
    pub pair: String,
    /// How it stands.
    pub state: State,
    /// Why it does not pass.
    pub why: Vec<String>,
    /// How far beyond the tolerance: 1 is just within, 0 equal. For the order in the report.
    pub badness: f64,
    /// The tolerance in words, with its reason where the case has its own.
    pub limits: String,
    /// The numbers, when both pictures could be read and have one size.
    pub numbers: Option<Numbers>,
    /// Our picture.
    pub ours: PathBuf,
    /// The other.
    pub theirs: PathBuf,
}

/// One comparison of a text with its golden one.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct TextResult {
    /// "diagnostics" or "scene".
    pub kind: String,
    /// How it stands.
    pub state: State,
    /// What is different: lines with `-` (golden) and `+` (now) before them.
    pub difference: String,
    /// File of the golden text.
    pub golden: PathBuf,
    /// File of ours.
    pub ours: PathBuf,
}

/// One run of our program.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct RunResult {
    /// Asked for.
    pub machine: Machine,
    /// The machine that rendered, by its own word.
    pub device: Option<String>,
    /// Wall clock seconds of all seeds together.
    pub seconds: f64,
    /// The most memory that it held.
    pub peak_bytes: Option<u64>,
    /// The same of the run before.
    pub last_seconds: Option<f64>,
    /// The same of the run before.
    pub last_peak_bytes: Option<u64>,
    /// To do it again.
    pub command: String,
}

/// One case.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct CaseResult {
    /// `area/case`.
    pub name: String,
    /// `area`.
    pub area: String,
    /// What it shows.
    pub about: String,
    /// The worst of all that follows.
    pub state: State,
    /// Why it does not pass; also reasons of known failures and of what is left out.
    pub why: Vec<String>,
    /// For the order: the worst of its comparisons.
    pub badness: f64,
    /// Width and height.
    pub size: [u32; 2],
    /// Our runs.
    pub runs: Vec<RunResult>,
    /// Pictures.
    pub pairs: Vec<PairResult>,
    /// Texts.
    pub texts: Vec<TextResult>,
    /// Files of pictures that stand in no comparison, by machine's name.
    pub pictures: Vec<(String, PathBuf)>,
    /// Of all that it depends on; equal keys have equal results.
    pub key: String,
    /// Taken over from the run before.
    pub reused: bool,
}

/// All of it.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct SuiteResults {
    /// Heading.
    pub title: String,
    /// Which program, with its version.
    pub program: String,
    /// The GPU that rendered, where one did.
    pub gpu: Option<String>,
    /// Seconds since 1970 at the start.
    pub started: u64,
    /// Wall clock seconds.
    pub seconds: f64,
    /// Cases at a time.
    pub jobs: usize,
    /// What is wrong with the suite itself: references that no case asks for, scenes without a `test.toml`.
    pub faults: Vec<String>,
    /// What was left out as a whole.
    pub notes: Vec<String>,
    /// All cases that were asked for, in order of their names.
    pub cases: Vec<CaseResult>,
}

impl SuiteResults {
    /// Number of cases in a state.
    pub fn count(&self, state: State) -> usize {
        self.cases.iter().filter(|c| c.state == state).count()
    }

    /// As `rayloom diff`: 0 all well, 2 different, 4 something cannot be judged.
    pub fn exit_code(&self) -> u8 {
        let worst = self.cases.iter().map(|c| c.state).max().unwrap_or(State::Passed);
        match worst {
            State::Broken => 4,
            State::Failed => 2,
            _ if !self.faults.is_empty() => 2,
            _ => 0,
        }
    }
}
