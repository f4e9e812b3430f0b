//! Collects diagnostics; tells repeated ones once.

use super::{Diagnostic, Severity, Span};
use std::collections::HashSet;

/// Where every stage of a job puts what it has to say.
#[derive(Debug, Default)]
pub struct Sink {
    items: Vec<Diagnostic>,
    said_once: HashSet<String>,
    n_errors: usize,
}

impl Sink {
    /// Adds a diagnostic.
    pub fn push(&mut self, d: Diagnostic) {
        if d.severity == Severity::Error {
            self.n_errors += 1;
        }
        self.items.push(d);
    }

    /// Adds a diagnostic unless one with the same `key` was added before ("photons are not rendered", told for the first place).
    pub fn push_once(&mut self, key: &str, d: Diagnostic) {
        if self.said_once.insert(key.to_owned()) {
            self.push(d);
        }
    }

    /// Adds a note without a place unless `key` was said.
    pub fn note_once(&mut self, key: &str, span: Option<Span>, message: impl Into<String>) {
        self.push_once(key, Diagnostic::new(Severity::Note, span, message));
    }

    /// What was added, in order.
    pub fn items(&self) -> &[Diagnostic] {
        &self.items
    }

    /// Takes what was added since the last call; keys said once stay said.
    pub fn drain(&mut self) -> Vec<Diagnostic> {
        std::mem::take(&mut self.items)
    }

    /// Whether any error was added.
    pub fn has_errors(&self) -> bool {
        self.n_errors > 0
    }
}
