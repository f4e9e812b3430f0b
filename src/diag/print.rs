//! A diagnostic as text for a terminal or a log.

use super::{Diagnostic, Severity, SourceMap};
use std::fmt::Write;

/// How to print.
#[derive(Clone, Copy, Debug, Default)]
pub struct Style {
    /// Use ANSI colours.
    pub color: bool,
}

/// The text of a diagnostic: severity and message, `file:line:column`, the source line with a caret, hints, the trace.
pub fn render(d: &Diagnostic, map: &SourceMap, style: Style) -> String {
    let (word, code) = match d.severity {
        Severity::Note => ("note", "36"),
        Severity::Warning => ("warning", "33"),
        Severity::Error => ("error", "31"),
    };
    let paint = |code: &str, text: &str| if style.color { format!("\x1b[1;{code}m{text}\x1b[0m") } else { text.to_owned() };
    let mut out = format!("{}: {}\n", paint(code, word), d.message);
    if let Some(span) = d.span {
        let file = map.file(span.file);
        let (line, col) = file.line_col(span.lo);
        let gutter = line.to_string().len();
        let _ = writeln!(out, "{:gutter$}--> {}:{line}:{col}", "", file.name);
        let text = file.line_text(line).replace('\t', " ");
        let shown: String = text.chars().take(160).collect();
        let width = (span.hi.saturating_sub(span.lo) as usize).clamp(1, shown.len().saturating_sub(col as usize - 1).max(1));
        let _ = writeln!(
            out,
            "{:gutter$} |\n{line} | {shown}\n{:gutter$} | {:pad$}{}",
            "",
            "",
            "",
            paint(code, &"^".repeat(width)),
            pad = col as usize - 1
        );
    }
    for t in &d.trace {
        let (name, line, col) = map.position(t.span);
        let _ = writeln!(out, "  {}, {name}:{line}:{col}", t.what);
    }
    for h in &d.hints {
        let _ = writeln!(out, "  {}: {h}", paint("36", "hint"));
    }
    out
}
