//! What each option does to [`PovOptions`].

use super::table::OPTIONS;
use super::{GammaOption, OutputType, PovOptions, StreamKind};
use crate::accel::AccelKind;
use crate::lang::Declared;
use std::path::PathBuf;

impl PovOptions {
    /// Sets the option of a known lower-case `key`; the error says what is wrong with the value.
    pub(super) fn set(&mut self, key: &str, value: &str) -> Result<(), String> {
        self.given.insert(key.to_owned(), value.to_owned());
        match key {
            "width" => self.width = int(value)?,
            "height" => self.height = int(value)?,
            "start_column" => self.start_column = Some(float(value)?),
            "end_column" => self.end_column = Some(float(value)?),
            "start_row" => self.start_row = Some(float(value)?),
            "end_row" => self.end_row = Some(float(value)?),
            "antialias" => self.antialias = boolean(value),
            "antialias_threshold" => {
                self.antialias = true;
                self.antialias_threshold = float(value)?.clamp(0.0, 1.0);
            }
            "antialias_depth" => self.antialias_depth = int(value)?.clamp(1, 9) as u8,
            "antialias_gamma" => self.antialias_gamma = float(value)?,
            "sampling_method" => self.sampling_method = if int(value)? == 2 { 2 } else { 1 },
            "jitter" => self.jitter = boolean(value),
            "jitter_amount" => {
                self.jitter = true;
                self.jitter_amount = float(value)?.clamp(0.0, 1.0);
            }
            "quality" => self.quality = int(value)?.min(9) as u8,
            "input_file_name" => self.input = Some(value.to_owned()),
            "include_header" => self.header = Some(value.to_owned()),
            "library_path" => self.library_paths.push(value.to_owned()),
            "version" => self.version = Some((float(value)? * 100.0).round() as u32),
            "output_to_file" => self.output_to_file = boolean(value),
            "output_file_type" => self.output_file_type(value)?,
            "bits_per_color" => self.bits_per_color = int(value)?.clamp(5, 16) as u8,
            "grayscale_output" => self.grayscale = boolean(value),
            "output_file_name" => self.output_name = Some(value.to_owned()),
            "output_alpha" => self.output_alpha = boolean(value),
            "compression" => self.compression = Some(int(value)?.min(255) as u8),
            "file_gamma" => self.file_gamma = gamma(value)?,
            "dither" => self.dither = boolean(value),
            "dither_method" => {
                let known = ["B2", "B3", "B4", "D1", "D2", "FS"];
                let upper = value.to_ascii_uppercase();
                if !known.contains(&upper.as_str()) {
                    return Err(format!("'{value}' is no dither method; they are {}", known.join(", ")));
                }
                self.dither_method = upper;
                self.dither = true;
            }
            "continue_trace" => self.continue_trace = boolean(value),
            "clock" => {
                self.clock = float(value)?;
                self.clock_on = true;
            }
            "initial_frame" => self.initial_frame = signed(value)?,
            "final_frame" => self.final_frame = signed(value)?,
            "initial_clock" => self.initial_clock = float(value)?,
            "final_clock" => self.final_clock = float(value)?,
            "cyclic_animation" => self.cyclic = boolean(value),
            "real_time_raytracing" => self.real_time = boolean(value),
            "subset_start_frame" => self.subset_start = float(value)?,
            "subset_end_frame" => self.subset_end = float(value)?,
            "frame_step" => self.frame_step = signed(value)?.max(1),
            "verbose" => self.verbose = boolean(value),
            "append_file" => self.append_file = boolean(value),
            "high_reproducibility" => self.high_reproducibility = boolean(value),
            "work_threads" => self.threads = int(value)?.clamp(1, 512) as usize,
            "render_block_size" => self.block_size = int(value)?.max(4),
            "create_ini" => self.create_ini = Some(value.to_owned()),
            "declare" => self.declare(value)?,
            "backend" => self.backend = one_of(value, &["auto", "cpu", "gpu"])?,
            "accel" => self.accel = one_of(value, &AccelKind::names().collect::<Vec<_>>())?,
            "max_steps" => self.max_steps = Some(u64::from(int(value)?)),
            "max_memory" => self.max_memory = Some(u64::from(int(value)?)),
            "allow_io" => self.allow_io.push(PathBuf::from(value)),
            _ => return self.stream_or_ignored(key, value),
        }
        Ok(())
    }

    fn stream_or_ignored(&mut self, key: &str, value: &str) -> Result<(), String> {
        use StreamKind::{Debug, Fatal, Render, Statistic, Warning};
        const STREAMS: [(&str, &[StreamKind]); 6] = [
            ("all", &[Debug, Fatal, Render, Statistic, Warning]),
            ("debug", &[Debug]),
            ("fatal", &[Fatal]),
            ("render", &[Render]),
            ("statistic", &[Statistic]),
            ("warning", &[Warning]),
        ];
        if let Some((name, what)) = key.rsplit_once('_')
            && let Some((name, kinds)) = STREAMS.iter().find(|(n, _)| *n == name)
        {
            for kind in *kinds {
                let stream = &mut self.streams[*kind as usize];
                match what {
                    "console" => stream.console = boolean(value),
                    _ if is_off(value) => stream.file = None,
                    _ if value.contains('/') => return Err(format!("'{value}': text files land in the output folder; give a bare name")),
                    _ if is_on(value) => stream.file = Some(format!("{}.out", if *name == "all" { "alltext" } else { name })),
                    _ => stream.file = Some(value.to_owned()),
                }
            }
            return Ok(());
        }
        if let Some(spec) = OPTIONS.iter().find(|s| s.key == key && !s.ignored.is_empty()) {
            let asks_for_nothing = spec.ignored == super::table::WINDOW && !matches!(key, "display_gamma");
            if !asks_for_nothing && !self.ignored.iter().any(|(k, _)| k == key) {
                self.ignored.push((key.to_owned(), spec.ignored));
            }
        }
        Ok(())
    }

    /// `N16`, `Tg`, `J90`: a letter, bits per channel, `g` for grey.
    fn output_file_type(&mut self, value: &str) -> Result<(), String> {
        let mut chars = value.chars();
        self.output_type = match chars.next().map(|c| c.to_ascii_uppercase()) {
            Some('N' | 'S') => OutputType::Png,
            Some('T') => OutputType::Targa,
            Some('C') => OutputType::TargaRle,
            Some('P') => OutputType::Ppm,
            Some('B') => OutputType::Bmp,
            Some('J') => OutputType::Jpeg,
            Some('H') => OutputType::Hdr,
            Some('E') => OutputType::Exr,
            _ => return Err(format!("'{value}' is no output type; they are N T C P B J H E")),
        };
        self.output_to_file = true;
        let rest = chars.as_str();
        let digits = rest.trim_end_matches(['g', 'G']);
        self.grayscale |= digits.len() < rest.len();
        if !digits.is_empty() {
            self.bits_per_color = int(digits).map_err(|_| format!("'{value}' is no output type"))?.clamp(5, 16) as u8;
        }
        Ok(())
    }

    /// `NAME=1.5` or `NAME="text"`; the first value of a name wins.
    fn declare(&mut self, value: &str) -> Result<(), String> {
        let Some((name, value)) = value.split_once('=') else {
            return Err(format!("'{value}' is no declaration; write Declare=NAME=VALUE"));
        };
        let (name, value) = (name.trim(), value.trim());
        let is_name = |n: &str| {
            n.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_') && n.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
        };
        if !is_name(name) {
            return Err(format!("'{name}' cannot be declared: it is no identifier"));
        }
        let value = match value.strip_prefix('"').and_then(|v| v.strip_suffix('"')) {
            Some(text) => Declared::Text(text.to_owned()),
            None => Declared::Float(value.parse().unwrap_or(0.0)),
        };
        if !self.declares.iter().any(|(n, _)| n == name) {
            self.declares.push((name.to_owned(), value));
        }
        Ok(())
    }
}

/// POV-Ray's booleans: a prefix of on, true, yes or 1; all else is off.
fn boolean(value: &str) -> bool {
    is_on(value)
}

fn is_on(value: &str) -> bool {
    let v = value.to_ascii_lowercase();
    !v.is_empty() && ["on", "true", "yes", "1"].iter().any(|w| w.starts_with(&v))
}

fn is_off(value: &str) -> bool {
    ["off", "false", "no", "0"].contains(&value.to_ascii_lowercase().as_str())
}

fn int(value: &str) -> Result<u32, String> {
    value.trim().parse().map_err(|_| format!("'{value}' is no whole number of 0 or more"))
}

fn signed(value: &str) -> Result<i32, String> {
    value.trim().parse().map_err(|_| format!("'{value}' is no whole number"))
}

fn float(value: &str) -> Result<f64, String> {
    value.trim().parse().ok().filter(|v: &f64| v.is_finite()).ok_or_else(|| format!("'{value}' is no number"))
}

fn gamma(value: &str) -> Result<GammaOption, String> {
    if value.eq_ignore_ascii_case("srgb") {
        return Ok(GammaOption::Srgb);
    }
    match float(value)? {
        g if g > 0.0 => Ok(GammaOption::Power(g)),
        _ => Err(format!("'{value}' is no gamma: it must be above 0, or srgb")),
    }
}

fn one_of(value: &str, words: &[&str]) -> Result<String, String> {
    let v = value.to_ascii_lowercase();
    if words.contains(&v.as_str()) { Ok(v) } else { Err(format!("'{value}' is not one of {}", words.join(", "))) }
}
