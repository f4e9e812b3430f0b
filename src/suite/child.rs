//! One run of a program: with an end in time, what it said, and how long and how large it was.

use super::command::CommandLine;
use super::error::SuiteError;
use std::fs::File;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// How a program ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// By itself, with this exit code.
    Code(i32),
    /// By a signal: a crash.
    Signal,
    /// It took too long and was stopped.
    Timeout,
}

/// What came of a program.
#[derive(Clone, Debug)]
pub struct Ended {
    /// How it ended.
    pub end: End,
    /// Wall clock seconds.
    pub seconds: f64,
    /// What it wrote to standard error.
    pub told: String,
}

/// Runs a program; standard output goes to `output`, else nowhere. What it says goes through the file `log`, so that no pipe fills up.
pub fn run(command: &CommandLine, log: &Path, output: Option<&Path>, timeout_s: f64) -> Result<Ended, SuiteError> {
    let create = |path: &Path| File::create(path).map_err(SuiteError::io("write", path));
    let stdout = output.map(create).transpose()?.map_or_else(Stdio::null, Stdio::from);
    let start = Instant::now();
    let mut child = Command::new(&command.program)
        .args(&command.args)
        .current_dir(&command.folder)
        .stdin(Stdio::null())
        .stdout(stdout)
        .stderr(Stdio::from(create(log)?))
        .spawn()
        .map_err(SuiteError::io("run", &command.program))?;
    let mut pause = Duration::from_millis(1);
    let end = loop {
        match child.try_wait().map_err(SuiteError::io("wait for", &command.program))? {
            Some(status) => break status.code().map_or(End::Signal, End::Code),
            None if start.elapsed().as_secs_f64() > timeout_s => {
                // It may have ended just now.
                let _ = child.kill();
                let _ = child.wait();
                break End::Timeout;
            }
            None => std::thread::sleep(pause),
        }
        pause = (pause * 3 / 2).min(Duration::from_millis(20));
    };
    let seconds = start.elapsed().as_secs_f64();
    let told = std::fs::read(log).map_err(SuiteError::io("read", log))?;
    Ok(Ended { end, seconds, told: String::from_utf8_lossy(&told).into_owned() })
}

/// Device and peak memory, from the statistics of either command.
pub fn device_and_peak(stats: &Path) -> (Option<String>, Option<u64>) {
    let Ok(text) = std::fs::read_to_string(stats) else { return (None, None) };
    if let Ok(json) = serde_json::from_str::<serde_json::Value>(&text) {
        return (json["device"].as_str().map(str::to_owned), json["peak_memory_bytes"].as_u64());
    }
    let device = text.split(" seconds on ").nth(1).and_then(|t| t.split("   Write Time").next());
    let peak = text.split("Peak Memory Used: ").nth(1).and_then(|t| t.split_whitespace().next()?.parse().ok());
    (device.map(str::to_owned), peak)
}
