//! INI files: lines of `Key = Value` or switches, sections, comments.

use super::args::unquoted;
use super::table::OLD_KEYS;
use super::{OptionError, PovOptions};
use crate::world::World;
use std::path::PathBuf;

/// Most INI files inside each other.
const MAX_DEPTH: usize = 16;
/// Most INI files of a run, the same one each time it is read.
const MAX_FILES: usize = 1000;

impl PovOptions {
    /// Takes the settings of `name`, which may end in `[section]`.
    pub(super) fn read_ini(&mut self, name: &str, world: &dyn World, depth: usize) -> Result<(), OptionError> {
        if depth > MAX_DEPTH {
            return Err(OptionError::TooDeep(MAX_DEPTH));
        }
        self.n_ini_files += 1;
        if self.n_ini_files > MAX_FILES {
            return Err(OptionError::TooMany(MAX_FILES));
        }
        let (file, section) = match name.strip_suffix(']').and_then(|n| n.rsplit_once('[')) {
            Some((file, section)) => (file, Some(section.to_ascii_lowercase())),
            None => (name, None),
        };
        let path = world
            .find(file, &[".ini"])
            .or_else(|| self.library_paths.iter().find_map(|l| world.find(&PathBuf::from(l).join(file).to_string_lossy(), &[".ini"])))
            .ok_or_else(|| OptionError::Ini { name: file.to_owned(), why: ": no such file (scene files end in .pov)".into() })?;
        let bytes = world.read(&path).map_err(|e| OptionError::Ini { name: file.to_owned(), why: format!(": {e}") })?;
        let text = String::from_utf8_lossy(&bytes);
        let mut active = true;
        for (n, line) in text.lines().enumerate() {
            let line = without_comment(line);
            let line = line.trim();
            if let Some(title) = line.strip_prefix('[').and_then(|l| l.split_once(']')) {
                active = section.as_deref() == Some(title.0.trim().to_ascii_lowercase().as_str());
                continue;
            }
            if !line.is_empty() && active {
                self.line(line, &format!("{file}:{}", n + 1), world, depth)?;
            }
        }
        Ok(())
    }

    /// One line: a key with its value to the end of the line, or words.
    fn line(&mut self, line: &str, place: &str, world: &dyn World, depth: usize) -> Result<(), OptionError> {
        let key: &str = line.split('=').next().unwrap_or("").trim();
        let is_pair = line.contains('=') && !key.is_empty() && key.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'_');
        if !is_pair {
            return words(line).iter().try_for_each(|w| self.word(w, place, world, depth));
        }
        let value = line[line.find('=').map_or(0, |k| k + 1)..].trim();
        let lower = key.to_ascii_lowercase();
        if OLD_KEYS.contains(&lower.as_str()) {
            self.ignored.push((lower, "an option of earlier versions"));
            return Ok(());
        }
        if lower == "library_path" || lower == "declare" {
            return list(value).iter().try_for_each(|part| self.word(&format!("{lower}={part}"), place, world, depth));
        }
        // Quoted values end at their quote; plain ones before what looks like the next setting.
        let value = match value.chars().next() {
            Some(q @ ('"' | '\'')) => value[1..].split_once(q).map_or(value, |(v, _)| v),
            _ => plain_value(value),
        };
        self.word(&format!("{lower}={value}"), place, world, depth)
    }
}

/// The line up to a `;` or `#` outside quotes.
fn without_comment(line: &str) -> &str {
    let mut quote = None;
    for (k, c) in line.char_indices() {
        match (quote, c) {
            (None, ';' | '#') => return &line[..k],
            (None, '"' | '\'') => quote = Some(c),
            (Some(q), c) if q == c => quote = None,
            _ => {}
        }
    }
    line
}

/// An unquoted value: up to a word that looks like a switch or another setting.
fn plain_value(text: &str) -> &str {
    let mut at = 0;
    for word in text.split_inclusive(char::is_whitespace) {
        let w = word.trim();
        let is_switch = w.len() > 1 && w.starts_with(['+', '-']) && w.as_bytes()[1].is_ascii_alphabetic();
        let is_pair = w.contains('=') && !w.to_ascii_lowercase().starts_with("declare");
        if at > 0 && (is_switch || is_pair) {
            return text[..at].trim();
        }
        at += word.len();
    }
    text.trim()
}

/// Values separated by commas outside quotes.
fn list(value: &str) -> Vec<&str> {
    let (mut parts, mut start, mut quote) = (Vec::new(), 0, None);
    for (k, c) in value.char_indices() {
        match (quote, c) {
            (None, ',') => {
                parts.push(&value[start..k]);
                start = k + 1;
            }
            (None, '"' | '\'') => quote = Some(c),
            (Some(q), c) if q == c => quote = None,
            _ => {}
        }
    }
    parts.push(&value[start..]);
    parts.into_iter().map(unquoted_if_whole).filter(|p| !p.is_empty()).collect()
}

/// Paths lose their quotes; `NAME="text"` keeps them, they say that it is a string.
fn unquoted_if_whole(part: &str) -> &str {
    if part.contains('=') { part.trim() } else { unquoted(part) }
}

/// Words separated by blanks outside quotes.
fn words(line: &str) -> Vec<String> {
    let (mut out, mut word, mut quote) = (Vec::new(), String::new(), None);
    for c in line.chars() {
        match (quote, c) {
            (None, c) if c.is_whitespace() => {
                if !word.is_empty() {
                    out.push(std::mem::take(&mut word));
                }
                continue;
            }
            (None, '"' | '\'') => quote = Some(c),
            (Some(q), c) if q == c => quote = None,
            _ => {}
        }
        word.push(c);
    }
    if !word.is_empty() {
        out.push(word);
    }
    out
}
