//! Words of a command line or of an INI file's line: switches, `Key=Value`, file names.

use super::table::{OPTIONS, OptionSpec, Takes};
use super::{OptionError, PovOptions};
use crate::world::World;

impl PovOptions {
    /// Takes one word; `place` is for messages.
    pub(super) fn word(&mut self, word: &str, place: &str, world: &dyn World, depth: usize) -> Result<(), OptionError> {
        let bad = |message: String| OptionError::Bad { place: place.to_owned(), message };
        match word.to_ascii_lowercase().as_str() {
            "-h" | "-?" | "-help" | "--help" => self.help = true,
            "-version" | "--version" | "--v" => self.show_version = true,
            _ if word.starts_with(['+', '-']) && word.len() > 1 => self.switch(word, &bad)?,
            _ => match word.split_once('=') {
                Some((key, value)) if is_key(key) => {
                    let key = key.trim().to_ascii_lowercase();
                    if key == "include_ini" {
                        return self.read_ini(unquoted(value), world, depth + 1);
                    }
                    let known = OPTIONS.iter().any(|s| s.key == key);
                    if !known {
                        return Err(bad(format!("unknown option '{key}'{}", meant(&key))));
                    }
                    self.set(&key, unquoted(value)).map_err(&bad)?;
                }
                _ => self.file_argument(unquoted(word), world, depth)?,
            },
        }
        Ok(())
    }

    fn file_argument(&mut self, word: &str, world: &dyn World, depth: usize) -> Result<(), OptionError> {
        if word.to_ascii_lowercase().ends_with(".pov") {
            self.input = Some(word.to_owned());
            Ok(())
        } else if word.ends_with('/') {
            self.library_paths.push(word.to_owned());
            Ok(())
        } else {
            self.read_ini(word, world, depth + 1)
        }
    }

    fn switch(&mut self, word: &str, bad: &impl Fn(String) -> OptionError) -> Result<(), OptionError> {
        let on = word.starts_with('+');
        let body = &word[1..];
        let Some((spec, value)) = find_switch(body, on) else {
            return Err(bad(format!("cannot read the switch '{word}'")));
        };
        let value = match (spec.takes, value) {
            // The switch is "A0", the value starts at its zero.
            _ if spec.switch == "A0" => format!("0{value}"),
            (Takes::Flag, _) | (Takes::Either, "") => if on { "on" } else { "off" }.to_owned(),
            (_, v) => unquoted(v).to_owned(),
        };
        self.set(spec.key, &value).map_err(|e| bad(format!("{word}: {e}")))
    }
}

/// The option of a switch without its sign: the longest letters that fit, with what follows them.
fn find_switch(body: &str, on: bool) -> Option<(&'static OptionSpec, &str)> {
    let fits = |s: &&OptionSpec| {
        let Some(head) = body.get(..s.switch.len()) else { return false };
        if s.switch.is_empty() || !head.eq_ignore_ascii_case(s.switch) {
            return false;
        }
        let rest = &body[s.switch.len()..];
        match s.takes {
            Takes::Flag => rest.is_empty(),
            Takes::Value if s.switch == "A0" => on && rest.starts_with('.') && rest.len() > 1,
            Takes::Value => !rest.is_empty() && is_plausible(s.key, rest),
            Takes::Either => true,
        }
    };
    OPTIONS.iter().filter(fits).max_by_key(|s| s.switch.len()).map(|s| (s, &body[s.switch.len()..]))
}

/// Whether a glued value can belong to the option: keeps `+RF3` and the like from being taken by a longer or shorter switch.
fn is_plausible(key: &str, value: &str) -> bool {
    let numeric = ["width", "height", "antialias_depth", "jitter_amount", "quality", "clock", "work_threads", "final_frame", "final_clock"];
    !numeric.contains(&key) || value.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c))
}

/// Whether the left side of a `=` is a key and not a part of a file name.
fn is_key(text: &str) -> bool {
    let t = text.trim();
    !t.is_empty() && t.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
}

/// Without one pair of outer quotes.
pub(super) fn unquoted(text: &str) -> &str {
    let t = text.trim();
    ['"', '\''].iter().find_map(|&q| t.strip_prefix(q).and_then(|t| t.strip_suffix(q))).unwrap_or(t)
}

/// " (did you mean 'width'?)" for a key one slip away from a known one.
fn meant(key: &str) -> String {
    let near = |s: &&OptionSpec| {
        let (a, b) = (s.key, key);
        a.starts_with(b) || b.starts_with(a) || a.len() == b.len() && a.bytes().zip(b.bytes()).filter(|(x, y)| x != y).count() <= 2
    };
    OPTIONS.iter().find(near).map_or(String::new(), |s| format!(" (did you mean '{}'?)", s.key))
}
