//! POV-Ray's command line and INI files → [`PovOptions`]. Source: spec/language.md, sections 10 and 11.
//!
//! `table` lists the options, `args` reads words as they stand on a command line, `ini` reads files, `frames` turns the animation
//! options into clocks, `output` names pictures. Nothing here opens a scene.

mod args;
mod frames;
mod ini;
mod output;
mod set;
mod table;
#[cfg(test)]
mod tests;

pub use frames::{Frame, frames};
pub use output::OutputName;

use super::Declared;
use crate::world::World;
use std::collections::BTreeMap;
use std::path::PathBuf;

/// A setting that could not be made.
#[derive(Debug, thiserror::Error, PartialEq)]
pub enum OptionError {
    /// No such switch, key or kind of value.
    #[error("{place}: {message}")]
    Bad {
        /// "command line" or `file.ini:12`.
        place: String,
        /// What is wrong with which word.
        message: String,
    },
    /// An INI file could not be read.
    #[error("cannot read INI file '{name}'{why}")]
    Ini {
        /// As it was asked for.
        name: String,
        /// ": reason", or empty when there is no such file.
        why: String,
    },
    /// INI files that include each other, or too many.
    #[error("INI files are nested more than {0} deep")]
    TooDeep(usize),
    /// An animation without end.
    #[error("an animation of more than {0} frames is asked for")]
    TooManyFrames(usize),
    /// INI files that are read again and again.
    #[error("more than {0} INI files are read")]
    TooMany(usize),
}

/// Format letter of `Output_File_Type`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "the names say it")]
pub enum OutputType {
    Png,
    Targa,
    TargaRle,
    Ppm,
    Bmp,
    Jpeg,
    Hdr,
    Exr,
}

/// `File_Gamma`, `Display_Gamma`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GammaOption {
    /// The sRGB curve.
    Srgb,
    /// A power.
    Power(f64),
}

/// One text stream's way out.
#[derive(Clone, Debug, PartialEq)]
pub struct StreamOptions {
    /// Printed.
    pub console: bool,
    /// Written to this file in the output folder.
    pub file: Option<String>,
}

impl Default for StreamOptions {
    fn default() -> Self {
        Self { console: true, file: None }
    }
}

/// Text streams, as places of [`PovOptions::streams`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "the names are POV-Ray's")]
pub enum StreamKind {
    Debug,
    Fatal,
    Render,
    Statistic,
    Warning,
}

/// Everything that can be set, with POV-Ray's defaults. Later settings replace earlier ones; lists grow.
#[derive(Clone, Debug)]
#[expect(missing_docs, reason = "the names are POV-Ray's keys, where nothing else is said")]
pub struct PovOptions {
    pub width: u32,
    pub height: u32,
    /// First and last column and row as written: 1-based and inclusive, or below 1 as shares; `None` for the edge.
    pub start_column: Option<f64>,
    pub end_column: Option<f64>,
    pub start_row: Option<f64>,
    pub end_row: Option<f64>,
    pub antialias: bool,
    pub antialias_threshold: f64,
    pub antialias_depth: u8,
    pub antialias_gamma: f64,
    pub sampling_method: u8,
    pub jitter: bool,
    pub jitter_amount: f64,
    pub quality: u8,
    pub input: Option<String>,
    pub header: Option<String>,
    pub library_paths: Vec<String>,
    /// Times 100.
    pub version: Option<u32>,
    pub output_to_file: bool,
    pub output_type: OutputType,
    pub bits_per_color: u8,
    pub grayscale: bool,
    pub output_name: Option<String>,
    pub output_alpha: bool,
    pub compression: Option<u8>,
    pub file_gamma: GammaOption,
    pub dither: bool,
    pub dither_method: String,
    pub continue_trace: bool,
    pub clock: f64,
    pub clock_on: bool,
    pub initial_frame: i32,
    pub final_frame: i32,
    pub initial_clock: f64,
    pub final_clock: f64,
    pub subset_start: f64,
    pub subset_end: f64,
    pub frame_step: i32,
    pub cyclic: bool,
    pub real_time: bool,
    pub verbose: bool,
    pub streams: [StreamOptions; 5],
    pub append_file: bool,
    /// 0: all cores.
    pub threads: usize,
    /// Pictures that depend on the order of rays are made in that of one thread.
    pub high_reproducibility: bool,
    pub block_size: u32,
    pub declares: Vec<(String, Declared)>,
    pub create_ini: Option<String>,
    /// `--help`, `--version` were asked for.
    pub help: bool,
    pub show_version: bool,
    /// Our own: which machine, which tree, folders a scene may write to besides its own.
    pub backend: String,
    pub accel: String,
    pub allow_io: Vec<PathBuf>,
    /// Loop turns, macro calls and includes of a scene, and MiB of memory, beyond which it is given up; `None` for the defaults.
    pub max_steps: Option<u64>,
    pub max_memory: Option<u64>,
    /// Every option that was set, by key, with its last value.
    pub given: BTreeMap<String, String>,
    /// INI files read so far.
    pub n_ini_files: usize,
    /// Options that were taken and change nothing here, each once, with its reason.
    pub ignored: Vec<(String, &'static str)>,
}

impl Default for PovOptions {
    fn default() -> Self {
        Self {
            width: 160,
            height: 120,
            start_column: None,
            end_column: None,
            start_row: None,
            end_row: None,
            antialias: false,
            antialias_threshold: 0.3,
            antialias_depth: 3,
            antialias_gamma: 2.5,
            sampling_method: 1,
            jitter: true,
            jitter_amount: 1.0,
            quality: 9,
            input: None,
            header: None,
            library_paths: Vec::new(),
            version: None,
            output_to_file: true,
            output_type: OutputType::Png,
            bits_per_color: 8,
            grayscale: false,
            output_name: None,
            output_alpha: false,
            compression: None,
            file_gamma: GammaOption::Srgb,
            dither: false,
            dither_method: "FS".into(),
            continue_trace: false,
            clock: 0.0,
            clock_on: false,
            initial_frame: 1,
            final_frame: 0,
            initial_clock: 0.0,
            final_clock: 1.0,
            subset_start: 0.0,
            subset_end: 0.0,
            frame_step: 1,
            cyclic: false,
            real_time: false,
            verbose: true,
            streams: Default::default(),
            append_file: false,
            threads: 0,
            high_reproducibility: false,
            block_size: 32,
            declares: Vec::new(),
            create_ini: None,
            help: false,
            show_version: false,
            backend: "auto".into(),
            accel: "auto".into(),
            allow_io: Vec::new(),
            max_steps: None,
            max_memory: None,
            given: BTreeMap::new(),
            n_ini_files: 0,
            ignored: Vec::new(),
        }
    }
}

/// Environment that decides which settings come first.
#[derive(Clone, Debug, Default)]
pub struct Environment {
    /// `$POVINI`.
    pub pov_ini: Option<PathBuf>,
    /// `$POVINC`.
    pub pov_inc: Option<String>,
    /// `$HOME`.
    pub home: Option<PathBuf>,
}

impl PovOptions {
    /// Settings of the first `povray.ini` there is, then of `words` from left to right.
    pub fn from_command_line(words: &[String], env: &Environment, world: &dyn World) -> Result<Self, OptionError> {
        let mut options = Self::default();
        if let Some(path) = default_ini(env) {
            options.read_ini(&path.to_string_lossy(), world, 0)?;
            // Nobody asked for what stands there.
            options.ignored.clear();
        }
        options.library_paths.extend(env.pov_inc.clone());
        for word in words {
            options.word(word, "command line", world, 0)?;
        }
        Ok(options)
    }

    /// All options that were set as the text of an INI file, in the order of their keys.
    pub fn as_ini(&self) -> String {
        self.given.iter().map(|(k, v)| format!("{k}={v}\n")).collect()
    }

    /// Whether several frames are asked for.
    pub fn is_animation(&self) -> bool {
        self.final_frame > 0
    }
}

/// The first of POV-Ray's places for `povray.ini` that exists.
fn default_ini(env: &Environment) -> Option<PathBuf> {
    let home = |p: &str| env.home.as_ref().map(|h| h.join(p));
    let places = [
        env.pov_ini.clone(),
        Some(PathBuf::from("povray.ini")),
        home(".povray/3.7/povray.ini"),
        home(".povrayrc"),
        Some(PathBuf::from("/etc/povray/3.7/povray.ini")),
    ];
    places.into_iter().flatten().find(|p| p.is_file())
}
