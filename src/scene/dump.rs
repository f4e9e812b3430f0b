//! A scene as text, for golden tests and for people who ask what was understood.
//!
//! It is the types' own `Debug` text, laid out anew: what fits stands on one line; nothing, no and empty lists are left out; of long lists
//! the beginning and a checksum of the rest are shown; settings of the path tracer only where a scene has its own.

use super::Scene;
use std::fmt::Write;

/// A node that is no longer than this stands on one line.
const WIDTH: usize = 140;
/// Lists of more entries than this are shortened to half of it.
const LONG: usize = 16;
/// More text than this is not laid out: shared parts are written out wherever they are used.
const MAX_BYTES: usize = 256 << 20;

/// The text of a scene; `None` where it would be larger than 256 MiB.
pub fn dump(scene: &Scene) -> Option<String> {
    let mut raw = Limited(String::new());
    write!(raw, "{scene:?}").ok()?;
    // What a front end says nothing of would only make noise: these settings are for another integrator.
    let unsaid = format!(", path: {:?}", super::path_settings::PathSettings::default());
    let mut out = String::new();
    lay_out(&raw.0.replacen(&unsaid, "", 1), 0, &mut out);
    out.push('\n');
    Some(out)
}

struct Limited(String);

impl Write for Limited {
    fn write_str(&mut self, s: &str) -> std::fmt::Result {
        if self.0.len() + s.len() > MAX_BYTES {
            return Err(std::fmt::Error);
        }
        self.0.push_str(s);
        Ok(())
    }
}

/// Where the first bracket opens that is in no string, its closing one, and the commas directly inside.
fn parts(node: &str) -> Option<(usize, Vec<usize>)> {
    let (mut depth, mut open, mut commas) = (0usize, None, Vec::new());
    let (mut quote, mut escaped) = (false, false);
    for (i, c) in node.bytes().enumerate() {
        if quote {
            (quote, escaped) = (escaped || c != b'"', !escaped && c == b'\\');
            continue;
        }
        match c {
            b'"' => quote = true,
            b'{' | b'(' | b'[' => {
                depth += 1;
                open = open.or(Some(i));
            }
            b'}' | b')' | b']' => depth = depth.saturating_sub(1),
            b',' if depth == 1 => commas.push(i),
            _ => {}
        }
    }
    open.map(|o| (o, commas))
}

fn lay_out(node: &str, indent: usize, out: &mut String) {
    let Some((open, commas)) = parts(node) else { return out.push_str(node) };
    let close = node.trim_end().len() - 1;
    let mut starts = vec![open + 1];
    starts.extend(commas.iter().map(|c| c + 1));
    let mut ends = commas;
    ends.push(close);
    let entries: Vec<&str> = starts.iter().zip(&ends).map(|(&a, &b)| node[a..b].trim()).filter(|e| !e.is_empty()).collect();
    let is_list = node.as_bytes()[open] == b'[';
    let entries: Vec<&str> = if is_list { entries } else { entries.into_iter().filter(|e| !is_nothing(e)).collect() };
    let shown = if is_list && entries.len() > LONG { LONG / 2 } else { entries.len() };
    let mut texts: Vec<String> = Vec::new();
    for e in &entries[..shown] {
        let mut text = String::new();
        lay_out(e, indent + 2, &mut text);
        texts.push(text);
    }
    if shown < entries.len() {
        let rest = entries[shown..].concat();
        texts.push(format!("... {} more, checksum {:016x}", entries.len() - shown, checksum(rest.as_bytes())));
    }
    let head = node[..open].trim_start();
    let (opening, closing) = (&node[open..=open], &node[close..=close]);
    let length = head.len() + texts.iter().map(|t| t.len() + 2).sum::<usize>() + 2;
    out.push_str(head);
    out.push_str(opening);
    if length <= WIDTH && texts.iter().all(|t| !t.contains('\n')) {
        let space = if opening == "{" && !texts.is_empty() { " " } else { "" };
        out.push_str(&format!("{space}{}{space}{closing}", texts.join(", ")));
    } else {
        for text in texts {
            out.push_str(&format!("\n{:1$}{text}", "", indent + 2));
        }
        out.push_str(&format!("\n{:1$}{closing}", "", indent));
    }
}

/// A field that says nothing.
fn is_nothing(field: &str) -> bool {
    [": None", ": []", ": false", ": {}"].iter().any(|n| field.ends_with(n))
}

/// FNV-1a.
fn checksum(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |h, b| (h ^ u64::from(*b)).wrapping_mul(0x0000_0100_0000_01b3))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_fits_is_on_a_line_and_nothing_is_left_out() {
        let mut out = String::new();
        lay_out("A { x: 1.0, y: None, s: \"a, {b\\\"\", z: [], t: B(1, 2) }", 0, &mut out);
        assert_eq!(out, "A { x: 1.0, s: \"a, {b\\\"\", t: B(1, 2) }");
    }

    #[test]
    fn long_lists_show_that_their_end_changed() {
        let text = |last: usize| {
            let mut out = String::new();
            lay_out(&format!("{:?}", (0..40).chain([last]).collect::<Vec<_>>()), 0, &mut out);
            out
        };
        assert!(text(1).starts_with("[0, 1, 2, 3, 4, 5, 6, 7, ... 33 more"), "{}", text(1));
        assert_ne!(text(1), text(2));
    }

    #[test]
    fn a_scene_is_dumped_as_a_tree() {
        let text = dump(&Scene::default()).expect("small");
        assert!(text.starts_with("Scene {\n  settings: ") && text.contains("camera: Camera") && !text.contains(": None"), "{text}");
    }
}
