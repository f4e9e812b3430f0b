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
    // What a scene says may not steer the terminal.
    let message: String = d.message.chars().map(|c| if c.is_control() && c != '\n' { ' ' } else { c }).collect();
    let mut out = format!("{}: {message}\n", paint(code, word));
    if let Some(span) = d.span {
        let file = map.file(span.file);
        let (line, col) = file.line_col(span.lo);
        let gutter = line.to_string().len();
        let _ = writeln!(out, "{:gutter$}--> {}:{line}:{col}", "", file.name);
        let (shown, pad) = excerpt(file.line_bytes(line), col as usize - 1);
        let width = (span.hi.saturating_sub(span.lo) as usize).clamp(1, shown.chars().count().saturating_sub(pad).max(1));
        let _ = writeln!(out, "{:gutter$} |\n{line} | {shown}\n{:gutter$} | {:pad$}{}", "", "", "", paint(code, &"^".repeat(width)),);
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

/// Most characters of a source line that are shown.
const SHOWN: usize = 160;
/// A place further to the right than this has the line's start cut off, up to half of that before it.
const MARGIN: usize = 120;

/// The part of a line around byte `at`, and how many characters of it stand before that byte.
fn excerpt(line: &[u8], at: usize) -> (String, usize) {
    let at = at.min(line.len());
    let start = if at > MARGIN { at - MARGIN / 2 } else { 0 };
    let end = line.len().min(start + 4 * SHOWN);
    let before = String::from_utf8_lossy(&line[start..at]).into_owned();
    let cut = if start > 0 { "..." } else { "" };
    let text = format!("{cut}{before}{}", String::from_utf8_lossy(&line[at..end]));
    // Control characters would move the caret, or the terminal's cursor.
    let shown = text.chars().take(SHOWN).map(|c| if c.is_control() { ' ' } else { c }).collect();
    (shown, cut.len() + before.chars().count())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diag::{Diagnostic, Span};
    use std::path::PathBuf;

    fn printed(text: &[u8], lo: usize) -> Vec<String> {
        let mut map = SourceMap::default();
        let file = map.add("a.pov", PathBuf::from("a.pov"), text.into());
        let d = Diagnostic::error(Span { file, lo: lo as u32, hi: lo as u32 + 1 }, "wrong");
        render(&d, &map, Style::default()).lines().map(str::to_owned).collect()
    }

    #[test]
    fn the_caret_stands_under_its_place() {
        for (text, lo) in [("abc X def".to_owned(), 4), (format!("{} X end", "y".repeat(1_000_000)), 1_000_001), ("äöü\tX".to_owned(), 7)]
        {
            let lines = printed(text.as_bytes(), lo);
            let column = lines[4].chars().position(|c| c == '^').expect("a caret");
            assert_eq!(lines[3].chars().nth(column), Some('X'), "{lines:#?}");
            assert!(lines[3].chars().count() < 200);
        }
    }

    #[test]
    fn bytes_that_are_no_text_are_shown_without_control_characters() {
        let lines = printed(b"\x1b[2J\xff\xfe X", 9);
        assert!(lines.iter().all(|l| !l.chars().any(char::is_control)), "{lines:?}");
    }
}
