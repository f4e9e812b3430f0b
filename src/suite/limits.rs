//! Tolerances: what two pictures may differ by, as `suite.toml` and `test.toml` say it.

use serde::{Deserialize, Deserializer};
use std::collections::BTreeMap;

/// What two pictures may differ by. What is `None` is not judged; a case's own values take the place of the suite's one by one.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Limits {
    /// A pixel is off when a channel differs by more than this...
    #[serde(default, deserialize_with = "share")]
    pub fail: Option<f64>,
    /// ...and at most this percentage of the pixels may be.
    pub percent: Option<f64>,
    /// No pixel may differ by more than this...
    #[serde(default, deserialize_with = "share")]
    pub hard_fail: Option<f64>,
    /// ...or at most this percentage, where silhouettes may fall either way. 0 when `None`.
    pub hard_percent: Option<f64>,
    /// Largest mean FLIP.
    pub max_flip: Option<f64>,
    /// Smallest PSNR in dB.
    pub min_psnr: Option<f64>,
    /// Largest distance of the ratio of the two means from 1, of each channel.
    pub mean_ratio: Option<f64>,
    /// For noisy pictures: significance of the whole picture's z-test (0.01), corrected for the number of pixels.
    pub significance: Option<f64>,
    /// Percentage of pixels that may be beyond the corrected significance all the same. 0 when `None`.
    pub significant_percent: Option<f64>,
    /// What is compared are means, in light, over squares of so many pixels a side: of pictures drawn with different random numbers.
    pub means: Option<u32>,
    /// Why these values; a case must say it.
    pub reason: Option<String>,
}

/// The table of a suite that has none.
pub fn default_table() -> BTreeMap<String, Limits> {
    let limits = |fail: f64, percent: f64, hard: f64, hard_percent: f64| Limits {
        fail: Some(fail / 255.0),
        percent: Some(percent),
        hard_fail: Some(hard / 255.0),
        hard_percent: Some(hard_percent),
        ..Limits::default()
    };
    [
        ("cpu-golden", Limits { mean_ratio: Some(0.001), ..limits(1.0, 0.1, 24.0, 0.0) }),
        ("gpu-cpu", limits(2.0, 0.5, 64.0, 0.25)),
        ("cpu-povray", limits(2.0, 1.0, 128.0, 0.5)),
        ("cpu-cycles", Limits { significance: Some(0.01), mean_ratio: Some(0.01), ..Limits::default() }),
    ]
    .map(|(name, l)| (name.to_owned(), l))
    .into()
}

impl Limits {
    /// These, where given, in the place of `base`'s.
    pub fn over(&self, base: &Self) -> Self {
        Self {
            fail: self.fail.or(base.fail),
            percent: self.percent.or(base.percent),
            hard_fail: self.hard_fail.or(base.hard_fail),
            hard_percent: self.hard_percent.or(base.hard_percent),
            max_flip: self.max_flip.or(base.max_flip),
            min_psnr: self.min_psnr.or(base.min_psnr),
            mean_ratio: self.mean_ratio.or(base.mean_ratio),
            significance: self.significance.or(base.significance),
            significant_percent: self.significant_percent.or(base.significant_percent),
            means: self.means.or(base.means),
            reason: self.reason.clone().or_else(|| base.reason.clone()),
        }
    }

    /// What is impossible in them.
    pub(super) fn fault(&self) -> Option<String> {
        let percents = [self.percent, self.hard_percent, self.significant_percent];
        if percents.iter().flatten().any(|p| !(0.0..=100.0).contains(p)) {
            return Some("a percentage is between 0 and 100".into());
        }
        if self.significance.is_some_and(|s| !(s > 0.0 && s < 1.0)) {
            return Some("a significance is between 0 and 1".into());
        }
        if self.means == Some(0) {
            return Some("means are over squares of at least 1 pixel".into());
        }
        let limits = [self.fail, self.hard_fail, self.max_flip, self.mean_ratio];
        if limits.iter().flatten().any(|v| !(v.is_finite() && *v >= 0.0)) {
            return Some("a limit is a number of at least 0".into());
        }
        let judges = limits.iter().chain([&self.min_psnr, &self.significance]).any(Option::is_some);
        (!judges).then(|| "nothing is judged: give fail, hard_fail, max_flip, min_psnr, mean_ratio or significance".into())
    }
}

/// A share of a channel's range: 0.01, or "2/255".
fn share<'de, D: Deserializer<'de>>(d: D) -> Result<Option<f64>, D::Error> {
    #[derive(Deserialize)]
    #[serde(untagged)]
    enum Raw {
        Number(f64),
        Text(String),
    }
    let number = |t: &str| t.trim().parse::<f64>().ok();
    let value = match Raw::deserialize(d)? {
        Raw::Number(v) => Some(v),
        Raw::Text(t) => match t.split_once('/') {
            Some((a, b)) => number(a).zip(number(b)).map(|(a, b)| a / b),
            None => number(&t),
        },
    };
    value.map(Some).ok_or_else(|| serde::de::Error::custom("write a share of the range, such as 0.01 or \"2/255\""))
}
