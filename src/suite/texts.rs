//! Golden texts: what the program says about a scene, and the parsed scene.

use super::error::SuiteError;
use super::results::{State, TextResult};
use std::path::Path;

/// Lines of a difference that are shown at most.
const MAX_LINES: usize = 200;
/// Lines deleted and inserted at most in a difference that is looked for.
const MAX_EDITS: isize = 1000;

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

/// What changed, in runs of lines that are in one of them only, each with its place in the expected text.
fn difference(expected: &str, actual: &str) -> String {
    let (a, b): (Vec<&str>, Vec<&str>) = (expected.lines().collect(), actual.lines().collect());
    let mut out = Vec::new();
    let (mut i, mut j) = (0, 0);
    for (next_i, next_j) in kept_lines(&a, &b).into_iter().chain([(a.len(), b.len())]) {
        if next_i > i || next_j > j {
            out.push(format!("@ line {}\n", i + 1));
            out.extend(a[i..next_i].iter().map(|l| format!("- {l}\n")));
            out.extend(b[j..next_j].iter().map(|l| format!("+ {l}\n")));
        }
        (i, j) = (next_i + 1, next_j + 1);
    }
    if out.len() > MAX_LINES {
        let n = out.len() - MAX_LINES;
        out.truncate(MAX_LINES);
        out.push(format!("... {n} more lines\n"));
    }
    out.concat()
}

/// Places of the lines that both have, the most that keep their order; only their equal ends where more than [`MAX_EDITS`] changed.
///
/// Source: Myers 1986, "An O(ND) Difference Algorithm and Its Variations".
fn kept_lines(a: &[&str], b: &[&str]) -> Vec<(usize, usize)> {
    let shorter = a.len().min(b.len());
    let head = (0..shorter).take_while(|&i| a[i] == b[i]).count();
    let tail = (0..shorter - head).take_while(|&i| a[a.len() - 1 - i] == b[b.len() - 1 - i]).count();
    let (mid_a, mid_b) = (&a[head..a.len() - tail], &b[head..b.len() - tail]);
    let mut kept: Vec<_> = (0..head).map(|i| (i, i)).collect();
    kept.extend(shortest_edit(mid_a, mid_b).unwrap_or_default().into_iter().map(|(i, j)| (i + head, j + head)));
    kept.extend((0..tail).rev().map(|i| (a.len() - 1 - i, b.len() - 1 - i)));
    kept
}

/// The same by the shortest way of deleting and inserting lines; `None` when it is longer than [`MAX_EDITS`].
fn shortest_edit(a: &[&str], b: &[&str]) -> Option<Vec<(usize, usize)>> {
    let (n, m) = (a.len() as isize, b.len() as isize);
    let most = (n + m).min(MAX_EDITS);
    let at = |k: isize| (k + most + 1) as usize;
    // Furthest place in `a` on each diagonal i - j, after each number of edits.
    let mut furthest = vec![0isize; 2 * most as usize + 3];
    let mut history = Vec::new();
    for d in 0..=most {
        history.push(furthest.clone());
        for k in (-d..=d).step_by(2) {
            let down = k == -d || (k != d && furthest[at(k - 1)] < furthest[at(k + 1)]);
            let mut i = if down { furthest[at(k + 1)] } else { furthest[at(k - 1)] + 1 };
            while i < n && i - k < m && i - k >= 0 && a[i as usize] == b[(i - k) as usize] {
                i += 1;
            }
            furthest[at(k)] = i;
            if i >= n && i - k >= m {
                return Some(walk_back(&history, at, n, m));
            }
        }
    }
    None
}

/// The lines kept on the way that ends at (n, m).
fn walk_back(history: &[Vec<isize>], at: impl Fn(isize) -> usize, n: isize, m: isize) -> Vec<(usize, usize)> {
    let mut kept = Vec::new();
    let (mut i, mut j) = (n, m);
    for (d, furthest) in history.iter().enumerate().rev() {
        let (d, k) = (d as isize, i - j);
        let down = k == -d || (k != d && furthest[at(k - 1)] < furthest[at(k + 1)]);
        let before = if down { k + 1 } else { k - 1 };
        let start = if d == 0 { 0 } else { furthest[at(before)] };
        let (from_i, from_j) = (start, start - before);
        while i > from_i.max(0) && j > from_j.max(0) && (d == 0 || (i, j) != if down { (from_i, from_j + 1) } else { (from_i + 1, from_j) })
        {
            (i, j) = (i - 1, j - 1);
            kept.push((i as usize, j as usize));
        }
        (i, j) = (from_i, from_j);
    }
    kept.reverse();
    kept
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

    #[test]
    fn a_difference_shows_each_change_alone() {
        let expected = "a\nb\nc\nd\ne\nf\n";
        assert_eq!(difference(expected, "a\nB\nc\nd\ne\nnew\nf\n"), "@ line 2\n- b\n+ B\n@ line 6\n+ new\n");
        assert_eq!(difference(expected, "b\nc\ne\nf\ng\n"), "@ line 1\n- a\n@ line 4\n- d\n@ line 7\n+ g\n");
    }

    #[test]
    fn what_a_difference_keeps_is_equal_in_order_and_the_most_there_is() {
        let mut state = 9u32;
        for _ in 0..300 {
            let mut text = |n: u32| -> Vec<&str> {
                let mut draw = |n: u32| {
                    state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                    (state >> 16) % n
                };
                let n = draw(n);
                (0..n).map(|_| ["a", "b", "c"][draw(3) as usize]).collect()
            };
            let (a, b) = (text(12), text(12));
            let kept = kept_lines(&a, &b);
            assert!(kept.iter().all(|(i, j)| a[*i] == b[*j]), "{a:?} {b:?} {kept:?}");
            assert!(kept.windows(2).all(|w| w[0].0 < w[1].0 && w[0].1 < w[1].1), "{a:?} {b:?} {kept:?}");
            // The longest common subsequence by the table.
            let mut table = vec![vec![0; b.len() + 1]; a.len() + 1];
            for i in 0..a.len() {
                for j in 0..b.len() {
                    table[i + 1][j + 1] = if a[i] == b[j] { table[i][j] + 1 } else { table[i][j + 1].max(table[i + 1][j]) };
                }
            }
            assert_eq!(kept.len(), table[a.len()][b.len()], "{a:?} {b:?} {kept:?}");
        }
    }
}
