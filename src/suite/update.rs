//! References that are made again on request only: our golden ones from what was just rendered, POV-Ray's and Cycles' by their programs.

use super::child::{self, End};
use super::command::{self, CommandLine};
use super::discover::{Case, Suite};
use super::error::SuiteError;
use super::estimate;
use super::results::{CaseResult, State};
use super::spec::{Expect, PictureKind};
use std::path::{Path, PathBuf};

/// Largest reference file in bytes: one issue a picture, and small.
const MAX_REFERENCE: u64 = 2 << 20;
/// Seeds that make the variance of a reference of Cycles.
const CYCLES_SEEDS: u32 = 8;
/// Samples of each for one of ours: the noise of the reference is below that of what is held against it.
const CYCLES_SAMPLES_PER_OURS: u32 = 4;
/// Our script for Blender.
const CYCLES_SCRIPT: &str = include_str!("render_with_cycles.py");

/// Takes what a run made as the golden pictures and texts of its cases, and as recorded wrong pictures. Gives the files that changed.
pub fn update(suite: &Suite, results: &[CaseResult]) -> Result<Vec<PathBuf>, SuiteError> {
    let mut changed = Vec::new();
    for r in results.iter().filter(|r| r.state != State::LeftOut) {
        let Some(case) = suite.cases.iter().find(|c| c.name == r.name) else { continue };
        let golden = suite.reference_stem("golden", &case.name);
        if case.file.references.iter().any(|k| k == "golden")
            && let Some((_, ours)) = r.pictures.iter().find(|(m, _)| m == "cpu")
        {
            replace(ours, &golden.with_added_extension(case.picture_kind().extension()), &mut changed)?;
        }
        for t in &r.texts {
            if std::fs::metadata(&t.ours).is_ok_and(|m| m.len() == 0) {
                if t.golden.is_file() {
                    std::fs::remove_file(&t.golden).map_err(SuiteError::io("write", &t.golden))?;
                    changed.push(t.golden.clone());
                }
            } else {
                replace(&t.ours, &t.golden, &mut changed)?;
            }
        }
        for known in &case.file.known_failure {
            if let Some(p) = r.pairs.iter().find(|p| p.pair == known.pair && p.ours.is_file()) {
                let to = suite.known_failure_stem(&case.name, &known.pair).with_added_extension(case.picture_kind().extension());
                replace(&p.ours, &to, &mut changed)?;
            }
        }
    }
    Ok(changed)
}

fn replace(from: &Path, to: &Path, changed: &mut Vec<PathBuf>) -> Result<(), SuiteError> {
    let bytes = std::fs::read(from).map_err(SuiteError::io("read", from))?;
    if std::fs::read(to).is_ok_and(|old| old == bytes) {
        return Ok(());
    }
    if bytes.len() as u64 > MAX_REFERENCE {
        let message =
            format!("{} is {} bytes large, a reference may be {MAX_REFERENCE}: make the case smaller", from.display(), bytes.len());
        return Err(SuiteError::Request(message));
    }
    make_folder_of(to)?;
    std::fs::write(to, bytes).map_err(SuiteError::io("write", to))?;
    changed.push(to.to_owned());
    Ok(())
}

fn make_folder_of(path: &Path) -> Result<(), SuiteError> {
    let folder = path.parent().unwrap_or(Path::new(""));
    std::fs::create_dir_all(folder).map_err(SuiteError::io("write", folder))
}

/// Renders the references of a kind again with the program that they come from. `heard` gets each command before it runs.
///
/// # Errors
/// A kind that no program makes, a program that is not here or fails, a reference that would be too large.
pub fn make_references(
    suite: &Suite,
    kind: &str,
    program: &Path,
    names: &[String],
    out: &Path,
    heard: &dyn Fn(&Case, &CommandLine),
) -> Result<Vec<PathBuf>, SuiteError> {
    if !["povray", "cycles"].contains(&kind) {
        return Err(SuiteError::Request(format!("'{kind}' is made by no program that is known here: povray and cycles are")));
    }
    let mut changed = Vec::new();
    std::fs::create_dir_all(out).map_err(SuiteError::io("write", out))?;
    let out = std::fs::canonicalize(out).map_err(SuiteError::io("read", out))?;
    let asked = |c: &&Case| c.file.references.iter().any(|r| r == kind) && c.file.expect == Expect::Picture;
    for case in suite.select(names)?.into_iter().filter(asked) {
        let to = suite.reference_stem(kind, &case.name).with_added_extension(case.reference_kind(kind).extension());
        let made = if kind == "povray" { povray(suite, case, program, &out, heard)? } else { cycles(suite, case, program, &out, heard)? };
        replace(&made, &to, &mut changed)?;
    }
    Ok(changed)
}

fn povray(suite: &Suite, case: &Case, program: &Path, out: &Path, heard: &dyn Fn(&Case, &CommandLine)) -> Result<PathBuf, SuiteError> {
    let picture = out.join("reference.png");
    let command = command::povray(suite, case, program, &picture);
    made(case, &command, std::slice::from_ref(&picture), out, suite.file.timeout_s, heard)?;
    Ok(picture)
}

fn cycles(suite: &Suite, case: &Case, python: &Path, out: &Path, heard: &dyn Fn(&Case, &CommandLine)) -> Result<PathBuf, SuiteError> {
    let script = out.join("render_with_cycles.py");
    std::fs::write(&script, CYCLES_SCRIPT).map_err(SuiteError::io("write", &script))?;
    // A scene as Blender saved it says more than its export.
    let blend = case.scene.with_extension("blend");
    let scene = if case.folder.join(&blend).is_file() { blend } else { case.scene.clone() };
    let ours = case.file.options.split_whitespace().skip_while(|w| *w != "--spp").nth(1).and_then(|n| n.parse().ok()).unwrap_or(64_u32);
    let samples = ours.saturating_mul(CYCLES_SAMPLES_PER_OURS);
    let [w, h] = case.size;
    let parts: Vec<PathBuf> = (0..CYCLES_SEEDS).map(|seed| out.join(format!("reference{seed}.exr"))).collect();
    let mut args = vec![script.to_string_lossy().into_owned(), scene.to_string_lossy().into_owned()];
    args.extend([w, h, samples].map(|n| n.to_string()));
    args.extend(parts.iter().map(|p| p.to_string_lossy().into_owned()));
    let command = CommandLine { program: python.to_owned(), args, folder: case.folder.clone() };
    made(case, &command, &parts, out, suite.file.timeout_s.max(600.0), heard)?;
    let unreadable = |e: crate::compare::PictureError| SuiteError::Request(e.to_string());
    let to = out.join(format!("reference.{}", PictureKind::Exr.extension()));
    estimate::write(&to, &estimate::of_files(&parts).map_err(unreadable)?)?;
    Ok(to)
}

/// Runs a command that has to leave pictures.
fn made(
    case: &Case,
    command: &CommandLine,
    pictures: &[PathBuf],
    out: &Path,
    timeout_s: f64,
    heard: &dyn Fn(&Case, &CommandLine),
) -> Result<(), SuiteError> {
    heard(case, command);
    // An old one must not be taken for the new one.
    for picture in pictures {
        let _ = std::fs::remove_file(picture);
    }
    let log = out.join("reference.log");
    let ended = child::run(command, &log, None, timeout_s)?;
    if ended.end != End::Code(0) || !pictures.iter().all(|p| p.is_file()) {
        let last: Vec<&str> = ended.told.lines().rev().take(8).collect();
        let told = last.into_iter().rev().collect::<Vec<_>>().join("\n  ");
        return Err(SuiteError::Request(format!("{}: {command}\n  gave no picture ({:?}):\n  {told}", case.name, ended.end)));
    }
    Ok(())
}

/// Makes a new case of a scene: its folder, the scene and its `test.toml`. Gives the folder.
///
/// # Errors
/// A name that is taken or no path, a scene that cannot be copied.
pub fn new_case(root: &Path, name: &str, scene: &Path) -> Result<PathBuf, SuiteError> {
    let plain = |c: char| c.is_ascii_alphanumeric() || "_-/".contains(c);
    if name.is_empty() || name.starts_with('/') || name.ends_with('/') || name.contains("//") || !name.chars().all(plain) {
        return Err(SuiteError::Request(format!("'{name}' is no name for a case: write AREA/CASE in letters, digits, - and _")));
    }
    let folder = root.join(name);
    if folder.join("test.toml").exists() {
        return Err(SuiteError::Request(format!("there is a case '{name}' already")));
    }
    std::fs::create_dir_all(&folder).map_err(SuiteError::io("write", &folder))?;
    let extension = scene.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    let to = folder.join(format!("scene.{extension}"));
    std::fs::copy(scene, &to).map_err(SuiteError::io("read", scene))?;
    let path = folder.join("test.toml");
    let text = "# What the scene shows: say it in its first comment, or here: about = \"...\"\nreferences = [\"golden\"]\n";
    std::fs::write(&path, text).map_err(SuiteError::io("write", &path))?;
    Ok(folder)
}
