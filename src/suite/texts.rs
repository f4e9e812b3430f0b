//! Golden texts: what the program says about a scene, and the parsed scene.

use super::error::SuiteError;
use super::results::{State, TextResult};
use std::path::Path;

/// Lines of a difference that are shown at most.
const MAX_LINES: usize = 200;

/// Holds a text against its golden file. An empty text needs no file, and a file that holds one is not missing.
///
/// `ours` gets the text, so that the report can point to it.
pub fn judge(kind: &str, text: &str, golden: &Path, ours: &Path) -> Result<TextResult, SuiteError> {
    std::fs::write(ours, text).map_err(SuiteError::io("write", ours))?;
    let expected = match std::fs::read(golden) {
        Ok(bytes) => String::from_utf8_lossy(&bytes).into_owned(),
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => String::new(),
        Err(e) => return Err(SuiteError::io("read", golden)(e)),
    };
    let state = if expected == text { State::Passed } else { State::Failed };
    let difference = if state == State::Passed { String::new() } else { difference(&expected, text) };
    Ok(TextResult { kind: kind.into(), state, difference, golden: golden.to_owned(), ours: ours.to_owned() })
}

/// Lines that are in one of them only, around what both begin and end with.
fn difference(expected: &str, actual: &str) -> String {
    let (a, b): (Vec<&str>, Vec<&str>) = (expected.lines().collect(), actual.lines().collect());
    let same = |n: usize, f: &dyn Fn(usize) -> bool| (0..n).take_while(|&i| f(i)).count();
    let shorter = a.len().min(b.len());
    let head = same(shorter, &|i| a[i] == b[i]);
    let tail = same(shorter - head, &|i| a[a.len() - 1 - i] == b[b.len() - 1 - i]);
    let lines = |mark: char, all: &[&str]| all[head..all.len() - tail].iter().map(|l| format!("{mark} {l}\n")).collect::<Vec<_>>();
    let mut out = vec![format!("@ line {}\n", head + 1)];
    out.extend(lines('-', &a));
    out.extend(lines('+', &b));
    if out.len() > MAX_LINES {
        let n = out.len() - MAX_LINES;
        out.truncate(MAX_LINES);
        out.push(format!("... {n} more lines\n"));
    }
    out.concat()
}

/// What the program said, without what does not come from the scene: lines of the machine's libraries, the one that tells of the finished
/// picture `out`, and where this checkout stands.
pub fn told(text: &str, folder: &Path, out: &Path) -> String {
    let here = std::path::absolute(folder).unwrap_or_else(|_| folder.to_owned());
    let here = format!("{}/", here.display());
    let done = out.to_string_lossy().into_owned();
    let ours = |l: &&str| !l.starts_with("error: XDG_RUNTIME_DIR") && !l.starts_with(&done);
    text.lines().filter(ours).map(|l| l.trim_end().replace(&here, "") + "\n").collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_difference_shows_what_is_between_the_equal_ends() {
        assert_eq!(difference("a\nb\nc\n", "a\nx\ny\nc\n"), "@ line 2\n- b\n+ x\n+ y\n");
        assert_eq!(difference("", "a\n"), "@ line 1\n+ a\n");
        assert_eq!(difference("a\na\n", "a\n"), "@ line 2\n- a\n");
    }
}
