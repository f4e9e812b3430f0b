//! Collects diagnostics; tells repeated ones once.

use super::{Diagnostic, Severity, Span};
use std::collections::HashSet;

/// Where every stage of a job puts what it has to say.
#[derive(Debug, Default)]
pub struct Sink {
    items: Vec<Diagnostic>,
    said_once: HashSet<String>,
    n_errors: usize,
    n_told: usize,
}

/// Warnings and notes beyond this many are not kept: a loop can make any number of them.
const MAX_FINDINGS: usize = 10_000;

impl Sink {
    /// Adds a diagnostic.
    pub fn push(&mut self, d: Diagnostic) {
        if d.severity == Severity::Error {
            self.n_errors += 1;
        } else {
            self.n_told += 1;
            if self.n_told > MAX_FINDINGS {
                if self.n_told == MAX_FINDINGS + 1 {
                    let message = format!("more than {MAX_FINDINGS} warnings and notes; further ones are not told");
                    self.items.push(Diagnostic::new(Severity::Note, None, message));
                }
                return;
            }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn findings_without_end_are_cut_off_and_errors_never() {
        let mut sink = Sink::default();
        (0..3 * MAX_FINDINGS).for_each(|_| sink.push(Diagnostic::new(Severity::Warning, None, "again")));
        sink.push(Diagnostic::new(Severity::Error, None, "at last"));
        assert_eq!(sink.items().len(), MAX_FINDINGS + 2);
        assert!(sink.has_errors());
        assert_eq!(sink.items().last().map(|d| d.severity), Some(Severity::Error));
    }
}
