//! What is said to people: places in files, diagnostics with their trace, and the sink that collects them.
//! Printing to a terminal stands in `diag/print.rs`; nothing here ends a program.

mod print;
mod sink;
mod span;

pub use print::{Style, render};
pub use sink::Sink;
pub use span::{FileId, SourceFile, SourceMap, Span};

/// How bad it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// Told once, changes nothing: what was left out, approximated or moved to another device.
    Note,
    /// The scene does something that its author may not mean.
    Warning,
    /// The scene cannot be rendered.
    Error,
}

/// One finding, with everything a terminal, a log or the Blender panel needs to show it.
#[derive(Clone, Debug, PartialEq)]
pub struct Diagnostic {
    /// How bad it is.
    pub severity: Severity,
    /// Where, if it has a place.
    pub span: Option<Span>,
    /// What, in one sentence without a final line break.
    pub message: String,
    /// What to do about it.
    pub hints: Vec<String>,
    /// How the reader got there, innermost first: "while calling macro Tree", with the place of the call.
    pub trace: Vec<TraceEntry>,
}

/// One step of the way to a diagnostic's place.
#[derive(Clone, Debug, PartialEq)]
pub struct TraceEntry {
    /// "included from", "while calling macro Tree", "in loop".
    pub what: String,
    /// Place of the `#include`, the call, the loop.
    pub span: Span,
}

impl Diagnostic {
    /// A diagnostic without hints or trace.
    pub fn new(severity: Severity, span: Option<Span>, message: impl Into<String>) -> Self {
        Self { severity, span, message: message.into(), hints: Vec::new(), trace: Vec::new() }
    }

    /// An error at a place.
    pub fn error(span: Span, message: impl Into<String>) -> Self {
        Self::new(Severity::Error, Some(span), message)
    }

    /// A warning at a place.
    pub fn warning(span: Span, message: impl Into<String>) -> Self {
        Self::new(Severity::Warning, Some(span), message)
    }

    /// With one more hint.
    #[must_use]
    pub fn with_hint(mut self, hint: impl Into<String>) -> Self {
        self.hints.push(hint.into());
        self
    }
}
