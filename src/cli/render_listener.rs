//! What `rayloom render` says while it works: progress, findings, the picture so far.

use super::interrupt::Interrupt;
use super::live::LivePicture;
use super::progress::ProgressView;
use rayloom::diag::{Diagnostic, SourceMap, Style, render};
use rayloom::film::Film;
use rayloom::job::{Listener, Stage};
use rayloom::lang::Stream;
use std::sync::atomic::Ordering;

/// Tells what a job does.
pub(super) struct RenderListener {
    pub view: ProgressView,
    pub style: Style,
    pub interrupt: Interrupt,
    pub live: Option<LivePicture>,
}

impl Listener for RenderListener {
    fn stage(&self, stage: &Stage) {
        match stage {
            Stage::Loading => self.view.event(&serde_json::json!({"event": "loading"})),
            Stage::Compiling => self.view.event(&serde_json::json!({"event": "compiling"})),
            Stage::Rendering { device, resumed_pixels } => {
                self.interrupt.rendering.store(true, Ordering::SeqCst);
                self.view.event(&serde_json::json!({"event": "rendering", "device": device, "resumed_pixels": resumed_pixels}));
            }
            Stage::Denoising => self.view.event(&serde_json::json!({"event": "denoising", "share": 0.0})),
            Stage::Writing => self.view.event(&serde_json::json!({"event": "writing"})),
        }
    }

    fn diagnostic(&self, d: &Diagnostic, map: &SourceMap) {
        let text = render(d, map, Style::default());
        let place = d.span.map(|s| map.position(s)).map(|(f, l, c)| serde_json::json!({"file": f, "line": l, "column": c}));
        self.view.event(&serde_json::json!({
            "event": "diagnostic", "severity": format!("{:?}", d.severity).to_lowercase(), "message": d.message, "place": place, "text": text,
        }));
        self.view.line(&render(d, map, self.style));
    }

    fn text(&self, _stream: Stream, text: &str) {
        self.view.line(text);
    }

    fn pixels(&self, done: u64, total: u64) {
        self.view.pixels(done, total);
    }

    fn photons(&self, done: u64, total: u64) {
        self.view.photons(done, total);
    }

    fn denoised(&self, share: f64) {
        self.view.denoised(share);
    }

    fn finished(&self, film: &Film) {
        if self.live.as_ref().is_some_and(|l| l.finish(film)) {
            self.view.event(&serde_json::json!({"event": "picture"}));
        }
    }

    fn picture(&self, film: &Film) {
        if self.live.as_ref().is_some_and(|l| l.show(film)) {
            self.view.event(&serde_json::json!({"event": "picture"}));
        }
    }
}
