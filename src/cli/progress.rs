//! How far a picture is: a bar with the time left, lines of JSON, or nothing.

use clap::ValueEnum;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::{IsTerminal, Write};
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// How to show progress.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ProgressKind {
    /// A bar on a terminal, else nothing
    Auto,
    /// A bar on standard error
    Bar,
    /// One JSON object a line on standard output: {"event":"progress","done":N,"total":N,"seconds":S,"seconds_left":S,"memory":BYTES,...}
    Json,
    /// Nothing
    None,
}

/// Shows progress. Told from any thread.
pub struct ProgressView {
    bar: Option<ProgressBar>,
    json: Option<Mutex<Instant>>,
    start: Instant,
}

/// JSON lines come no more often than this.
const JSON_PAUSE: Duration = Duration::from_millis(100);

impl ProgressView {
    /// A view that shows nothing until told.
    pub fn new(kind: ProgressKind) -> Self {
        let bar = match kind {
            ProgressKind::Bar => true,
            ProgressKind::Auto => std::io::stderr().is_terminal(),
            ProgressKind::Json | ProgressKind::None => false,
        };
        let bar = bar.then(|| {
            let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr());
            let style =
                ProgressStyle::with_template("{bar:32} {percent:>3} %  {elapsed} elapsed, {eta} left").expect("the template is right");
            bar.set_style(style);
            bar
        });
        let json = (kind == ProgressKind::Json).then(|| Mutex::new(Instant::now() - JSON_PAUSE));
        Self { bar, json, start: Instant::now() }
    }

    /// `done` of `total` pixels are finished.
    pub fn pixels(&self, done: u64, total: u64) {
        if let Some(bar) = &self.bar {
            bar.set_length(total);
            bar.set_position(done);
        }
        if let Some(last) = &self.json
            && let Ok(mut last) = last.lock()
            && (last.elapsed() >= JSON_PAUSE || done >= total)
        {
            *last = Instant::now();
            let seconds = self.start.elapsed().as_secs_f64();
            let left = if done > 0 { seconds * (total.saturating_sub(done)) as f64 / done as f64 } else { 0.0 };
            self.event(&serde_json::json!({
                "event": "progress", "done": done, "total": total,
                "seconds": (seconds * 1e3).round() / 1e3, "seconds_left": (left * 1e3).round() / 1e3,
                "memory": rayloom::memory::in_use(), "memory_peak": rayloom::memory::peak(),
            }));
        }
    }

    /// `done` of about `total` photons are shot.
    pub fn photons(&self, done: u64, total: u64) {
        if let Some(bar) = &self.bar {
            bar.set_length(total);
            bar.set_position(done);
        }
        if let Some(last) = &self.json
            && let Ok(mut last) = last.lock()
            && last.elapsed() >= JSON_PAUSE
        {
            *last = Instant::now();
            self.event(&serde_json::json!({"event": "photons", "done": done, "total": total}));
        }
    }

    /// So much of the denoising is done, 0..1.
    pub fn denoised(&self, share: f64) {
        if let Some(last) = &self.json
            && let Ok(mut last) = last.lock()
            && last.elapsed() >= JSON_PAUSE
        {
            *last = Instant::now();
            self.event(&serde_json::json!({"event": "denoising", "share": (share * 1e3).round() / 1e3}));
        }
    }

    /// One JSON line, when JSON was asked for.
    pub fn event(&self, event: &serde_json::Value) {
        if self.json.is_some() {
            let mut out = std::io::stdout().lock();
            // A reader that went away is not our concern: the picture still gets written.
            let _ = writeln!(out, "{event}");
            let _ = out.flush();
        }
    }

    /// Prints a line above the bar.
    pub fn line(&self, text: &str) {
        match &self.bar {
            Some(bar) => bar.suspend(|| eprint!("{text}")),
            None => eprint!("{text}"),
        }
    }

    /// Takes the bar away.
    pub fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}
