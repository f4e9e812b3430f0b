//! What people write: `suite.toml` at a suite's root and `test.toml` in each case's folder. Strict: an unknown key is an error.

use super::error::SuiteError;
use super::limits::{Limits, default_table};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// A machine that renders a case.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Deserialize, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Machine {
    /// The CPU back end, the gold.
    Cpu,
    /// The GPU back end, real or in software.
    Gpu,
}

impl Machine {
    /// As written in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Cpu => "cpu",
            Self::Gpu => "gpu",
        }
    }
}

/// A comparison that is known to fail. It must go on failing, and in the same way.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KnownFailure {
    /// Which comparison: "cpu-povray".
    pub pair: String,
    /// Why it fails.
    pub reason: String,
}

/// What the GPU says to a case that it does not render.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GpuSpec {
    /// A part of its reason.
    pub declines: String,
}

/// What a case wants to see.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Expect {
    /// A picture.
    #[default]
    Picture,
    /// An error of the scene (exit code 3), told as the golden text has it.
    Error,
}

/// Kind of file a case renders to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum PictureKind {
    /// 8 bits, sRGB.
    Png,
    /// Linear light.
    Exr,
}

impl PictureKind {
    /// Extension of its files.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Png => "png",
            Self::Exr => "exr",
        }
    }
}

/// `test.toml`: one case.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CaseFile {
    /// What the case shows; for a scene in POV-Ray's language its first comment where this is left out.
    pub about: Option<String>,
    /// The scene, where the folder has more than one file that could be it.
    pub scene: Option<PathBuf>,
    /// Width and height; the suite's where left out.
    pub size: Option<[u32; 2]>,
    /// Further options of the renderer: POV-Ray's for `.pov` and `.ini`, those of `rayloom render` for models.
    #[serde(default)]
    pub options: String,
    /// Kind of picture; PNG unless `seeds` are given.
    pub picture: Option<PictureKind>,
    /// Machines that render it; the suite's where left out.
    pub backends: Option<Vec<Machine>>,
    /// Reference pictures that ours is held against.
    #[serde(default)]
    pub references: Vec<String>,
    /// What must be installed, by the names in `suite.toml`.
    #[serde(default)]
    pub needs: Vec<String>,
    /// A picture, or an error.
    #[serde(default)]
    pub expect: Expect,
    /// The parsed scene is held against a golden text.
    #[serde(default)]
    pub dump: bool,
    /// Seeds of a noisy picture: it is rendered once with each, which gives mean and variance.
    #[serde(default)]
    pub seeds: Vec<u32>,
    /// By comparison ("cpu-povray"), what differs from the suite's table, with a reason.
    #[serde(default)]
    pub tolerance: BTreeMap<String, Limits>,
    /// Comparisons that are known to fail.
    #[serde(default)]
    pub known_failure: Vec<KnownFailure>,
    /// What the GPU does with it.
    pub gpu: Option<GpuSpec>,
}

/// `suite.toml`: what all cases share.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SuiteFile {
    /// Heading of the report.
    pub title: String,
    /// Folder of all reference pictures, from the suite's root.
    pub references_root: PathBuf,
    /// Reference pictures by name, with their folder in `references_root`.
    pub references: BTreeMap<String, String>,
    /// Machines that render.
    pub backends: Vec<Machine>,
    /// Width and height.
    pub size: [u32; 2],
    /// Folders searched for includes, fonts and images.
    pub library: Vec<PathBuf>,
    /// What may be missing on a machine, by name, with a path that shows that it is there.
    pub needs: BTreeMap<String, PathBuf>,
    /// Seconds after which a render is stopped.
    pub timeout_s: f64,
    /// Fewer cases than this are an error: none gets lost unseen.
    pub cases_at_least: usize,
    /// The tolerance table, by comparison.
    pub tolerance: BTreeMap<String, Limits>,
}

impl Default for SuiteFile {
    fn default() -> Self {
        let name = |n: &str| (n.to_owned(), n.to_owned());
        Self {
            title: "Picture suite".into(),
            references_root: "references".into(),
            references: [name("golden"), name("povray"), name("cycles")].into(),
            backends: vec![Machine::Cpu],
            size: [160, 120],
            library: Vec::new(),
            needs: BTreeMap::new(),
            timeout_s: 300.0,
            cases_at_least: 1,
            tolerance: default_table(),
        }
    }
}

fn read<T: for<'de> Deserialize<'de>>(path: &Path) -> Result<T, SuiteError> {
    let text = std::fs::read_to_string(path).map_err(SuiteError::io("read", path))?;
    toml::from_str(&text).map_err(|e| SuiteError::spec(path, e.to_string().trim_end()))
}

/// Reads `suite.toml`; a folder without one has the defaults.
pub fn read_suite_file(path: &Path) -> Result<SuiteFile, SuiteError> {
    let suite = if path.is_file() { read(path)? } else { SuiteFile::default() };
    let bad = |message: String| Err(SuiteError::spec(path, message));
    for (pair, limits) in &suite.tolerance {
        if let Some(fault) = pair_fault(pair, &suite).or(limits.fault()) {
            return bad(format!("tolerance.{pair}: {fault}"));
        }
    }
    if suite.size.contains(&0) || suite.backends.is_empty() || !(suite.timeout_s > 0.0) {
        return bad("size and timeout_s must be above 0, and there must be a backend".into());
    }
    Ok(suite)
}

/// What is wrong with the name of a comparison.
fn pair_fault(pair: &str, suite: &SuiteFile) -> Option<String> {
    let known = |other: &str| suite.references.contains_key(other);
    match pair.split_once('-') {
        Some(("gpu", "cpu")) => None,
        Some(("cpu" | "gpu", other)) if known(other) => None,
        _ => Some(format!("'{pair}' is no comparison: write gpu-cpu, or cpu- or gpu- before one of the references")),
    }
}

/// Reads a case's `test.toml` and checks it against the suite.
pub fn read_case_file(path: &Path, suite: &SuiteFile) -> Result<CaseFile, SuiteError> {
    let case: CaseFile = read(path)?;
    let bad = |message: String| Err(SuiteError::spec(path, message));
    for (pair, limits) in &case.tolerance {
        if let Some(fault) = pair_fault(pair, suite).or(limits.fault()) {
            return bad(format!("tolerance.{pair}: {fault}"));
        }
        if limits.reason.as_ref().is_none_or(|r| r.trim().is_empty()) {
            return bad(format!("tolerance.{pair}: a case's own tolerance wants a reason"));
        }
    }
    for known in &case.known_failure {
        if let Some(fault) = pair_fault(&known.pair, suite) {
            return bad(format!("known_failure: {fault}"));
        }
        if known.reason.trim().is_empty() {
            return bad(format!("known_failure of {}: wants a reason", known.pair));
        }
    }
    if let Some(name) = case.references.iter().find(|r| !suite.references.contains_key(*r)) {
        return bad(format!("no reference is called '{name}' in suite.toml"));
    }
    if let Some(name) = case.needs.iter().find(|n| !suite.needs.contains_key(*n)) {
        return bad(format!("no need is called '{name}' in suite.toml"));
    }
    if case.expect == Expect::Error && !(case.references.is_empty() && case.seeds.is_empty()) {
        return bad("a case that expects an error has no pictures".into());
    }
    if case.seeds.len() == 1 {
        return bad("one seed gives no variance: give several, or the option --seed".into());
    }
    if !case.seeds.is_empty() && case.picture == Some(PictureKind::Png) {
        return bad("seeds want EXR pictures".into());
    }
    if case.size.is_some_and(|s| s.contains(&0)) || case.backends.as_ref().is_some_and(Vec::is_empty) {
        return bad("size must be above 0, and there must be a backend".into());
    }
    Ok(case)
}
