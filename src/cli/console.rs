//! What both renderers' command lines print: findings, streams of the scene, files of streams.

use rayloom::diag::{Diagnostic, Severity, SourceMap, Style, render};
use rayloom::lang::options::{PovOptions, StreamKind};
use std::collections::HashMap;
use std::io::{IsTerminal, Write};
use std::path::Path;
use std::sync::Mutex;

/// Terminal style: colours where standard error is a terminal and NO_COLOR is not set.
pub fn style() -> Style {
    Style { color: std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|v| v.is_empty()) }
}

/// An error without a place in a scene, as all of them are printed.
pub fn print_error(message: &str) {
    let d = Diagnostic::new(Severity::Error, None, message);
    eprint!("{}", render(&d, &SourceMap::default(), style()));
}

/// POV-Ray's five text streams: each to the terminal, to a file in the output folder, or both.
pub struct Streams {
    console: [bool; 5],
    names: [Option<String>; 5],
    /// Several streams may share a file.
    files: Mutex<HashMap<String, std::fs::File>>,
}

impl Streams {
    /// Opens the files that the options name; `append` goes on where earlier frames ended.
    pub fn open(o: &PovOptions, folder: &Path, append: bool) -> Result<Self, String> {
        let mut files = HashMap::new();
        for name in o.streams.iter().filter_map(|s| s.file.as_ref()) {
            let path = folder.join(name);
            let append = append || o.append_file;
            let open = std::fs::OpenOptions::new().create(true).write(true).append(append).truncate(!append).open(&path);
            files.insert(name.clone(), open.map_err(|e| format!("cannot write '{}': {e}", path.display()))?);
        }
        Ok(Self {
            console: std::array::from_fn(|k| o.streams[k].console),
            names: std::array::from_fn(|k| o.streams[k].file.clone()),
            files: Mutex::new(files),
        })
    }

    /// Writes to a stream.
    pub fn write(&self, kind: StreamKind, text: &str) {
        if self.console[kind as usize] {
            eprint!("{text}");
        }
        if let (Some(name), Ok(mut files)) = (&self.names[kind as usize], self.files.lock())
            && let Some(file) = files.get_mut(name)
            && file.write_all(text.as_bytes()).is_err()
        {
            eprintln!("warning: '{name}' cannot be written any further");
            files.remove(name);
        }
    }
}
