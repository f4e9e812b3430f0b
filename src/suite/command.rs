//! The command lines of a case: ours on each machine, and those of the programs that its references come from.

use super::discover::{Case, Suite};
use super::spec::Machine;
use std::fmt;
use std::path::{Path, PathBuf};

/// A program with its arguments and the folder it runs in.
#[derive(Clone, Debug, PartialEq)]
pub struct CommandLine {
    /// The program.
    pub program: PathBuf,
    /// Its arguments.
    pub args: Vec<String>,
    /// Where it runs: the case's folder.
    pub folder: PathBuf,
}

impl fmt::Display for CommandLine {
    /// As one types it into a shell.
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "(cd {} && {}", quoted(&self.folder.to_string_lossy()), quoted(&self.program.to_string_lossy()))?;
        self.args.iter().try_for_each(|a| write!(f, " {}", quoted(a)))?;
        f.write_str(")")
    }
}

/// A word as a shell takes it.
pub fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || "+-_./=,:@%".contains(c);
    if !word.is_empty() && word.chars().all(plain) { word.to_owned() } else { format!("'{}'", word.replace('\'', "'\\''")) }
}

/// Ours, for one picture. `stats` gets times and memory.
pub fn ours(suite: &Suite, case: &Case, program: &Path, machine: Machine, seed: Option<u32>, out: &Path, stats: &Path) -> CommandLine {
    let [w, h] = case.size;
    let mut args: Vec<String>;
    if case.is_povray() && seed.is_none() {
        args = vec!["povray".into()];
        args.extend(povray_words(suite, case, out));
        args.push(format!("Backend={}", machine.name()));
        args.extend(["-GR".into(), "-GS".into(), format!("Statistic_File={}", file_name(stats))]);
    } else {
        let scene = case.scene.to_string_lossy().into_owned();
        args = vec!["render".into(), scene, "-o".into(), path(out), "--size".into(), format!("{w}x{h}")];
        args.extend(["--backend", machine.name(), "--threads", "1", "--progress", "none", "--stats"].map(str::to_owned));
        args.push(path(stats));
        args.extend(suite.file.library.iter().flat_map(|l| ["-L".to_owned(), path(&suite.root.join(l))]));
        args.extend(seed.map(|s| format!("--seed={s}")));
        args.extend(case.file.options.split_whitespace().map(str::to_owned));
    }
    CommandLine { program: program.to_owned(), args, folder: case.folder.clone() }
}

/// POV-Ray's own picture of a case.
pub fn povray(suite: &Suite, case: &Case, program: &Path, out: &Path) -> CommandLine {
    CommandLine { program: program.to_owned(), args: povray_words(suite, case, out), folder: case.folder.clone() }
}

/// What both programs are told.
fn povray_words(suite: &Suite, case: &Case, out: &Path) -> Vec<String> {
    let [w, h] = case.size;
    let kind = if out.extension().is_some_and(|e| e == "exr") { "+FE" } else { "+FN" };
    let mut words = vec![format!("+I{}", case.scene.display()), format!("+O{}", out.display()), format!("+W{w}"), format!("+H{h}")];
    words.extend([kind, "-D", "-P", "+WT1", "-A"].map(str::to_owned));
    words.extend(suite.file.library.iter().map(|l| format!("+L{}", suite.root.join(l).display())));
    words.extend(case.file.options.split_whitespace().map(str::to_owned));
    words
}

/// The parsed scene as text.
pub fn dump(suite: &Suite, case: &Case, program: &Path) -> CommandLine {
    let mut args = vec!["info".to_owned(), case.scene.to_string_lossy().into_owned(), "--dump".into()];
    args.extend(suite.file.library.iter().flat_map(|l| ["-L".to_owned(), path(&suite.root.join(l))]));
    CommandLine { program: program.to_owned(), args, folder: case.folder.clone() }
}

fn path(p: &Path) -> String {
    p.to_string_lossy().into_owned()
}

fn file_name(p: &Path) -> String {
    p.file_name().unwrap_or_default().to_string_lossy().into_owned()
}
