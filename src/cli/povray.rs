//! `rayloom povray`: POV-Ray's command line, INI files, text streams and exit codes (0 done, 1 error, 2 interrupted).

use super::console::{Streams, print_error, style};
use super::interrupt::Interrupt;
use clap::Args;
use rayloom::compile::shape::TreeStore;
use rayloom::diag::{Diagnostic, Severity, SourceMap, Style, render};
use rayloom::job::{Job, JobError, Listener, Outcome, Stage, job_for_frame};
use rayloom::lang::Stream;
use rayloom::lang::options::{Environment, Frame, PovOptions, StreamKind, frames};
use rayloom::world::DiskWorld;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// Arguments of `rayloom povray`.
#[derive(Debug, Args)]
pub struct PovrayArgs {
    /// POV-Ray's switches, KEY=VALUE settings, INI files, the scene
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, value_name = "OPTIONS")]
    words: Vec<String>,
}

const HELP: &str = "\
Usage: rayloom povray [+Iscene.pov] [+Oout.png] [options] [file.ini[section]] [KEY=VALUE]

POV-Ray 3.7's own options, unchanged. The ones used most:
  +Iname +Oname            scene, picture (- is standard output)
  +Wn +Hn                  size
  +SCn +ECn +SRn +ERn      part of the picture, pixels from 1 or shares below 1
  +A0.3 -A +AM1 +AM2 +Rn   antialiasing: threshold, method, depth
  +J0.5 -J                 its jitter
  +FN +FN16 +FNg +FT +FC +FP +FB +FJ +FH +FE -F   kind of file, or none
  +UA                      transparent background
  +Qn                      quality 0..9
  +Lfolder                 searched for includes, images and fonts
  +Kn                      clock
  +KFIn +KFFn +KIn +KFn +KC +SFn +EFn   animation: frames, clocks, cyclic, part
  +WTn                     threads; 1: noise and radiosity to the pixel as POV-Ray's +WT1
  +HR                      the same on many: one core renders a picture that depends on the order of rays
  +C                       go on where an interrupted run ended
  +GDfile +GWfile ...      text streams to files in the output folder
  Declare=NAME=VALUE       a constant for the scene
Settings of rayloom's own: Backend=auto|cpu|gpu, Accel=auto|kd|bvh|brute, Allow_IO=FOLDER (a scene writes to its own folder, the
output folder and the temporary folder only), Max_Steps=N (loop turns of a scene), Max_Memory=MIB.
povray.ini is read first: $POVINI, ./povray.ini, ~/.povray/3.7/povray.ini, /etc/povray/3.7/povray.ini; then $POVINC, then the arguments.
Exit codes: 0 done, 1 error, 2 interrupted.
";

/// Runs it.
pub fn run(args: &PovrayArgs) -> ExitCode {
    let env = Environment {
        pov_ini: std::env::var_os("POVINI").map(PathBuf::from),
        pov_inc: std::env::var("POVINC").ok(),
        home: std::env::var_os("HOME").map(PathBuf::from),
    };
    let options = match PovOptions::from_command_line(&args.words, &env, &DiskWorld::default()) {
        Ok(o) => o,
        Err(e) => {
            print_error(&format!("Problem with option setting\n  povray {}\n  {e}", args.words.join(" ")));
            return ExitCode::from(1);
        }
    };
    if options.help || options.show_version || args.words.is_empty() {
        eprint!("rayloom {}, in place of POV-Ray 3.7\n\n{}", env!("CARGO_PKG_VERSION"), if options.show_version { "" } else { HELP });
        return ExitCode::from(u8::from(args.words.is_empty()));
    }
    let Some(input) = &options.input else {
        print_error("No input file provided: give +Iscene.pov, or Input_File_Name in an INI file");
        return ExitCode::from(1);
    };
    if let Some(name) = &options.create_ini
        && let Err(e) = std::fs::write(name, options.as_ini())
    {
        print_error(&format!("cannot write '{name}': {e}"));
        return ExitCode::from(1);
    }
    animate(&options, Path::new(input))
}

/// Renders every frame that is asked for; stops at the first that fails.
fn animate(options: &PovOptions, input: &Path) -> ExitCode {
    let interrupt = Interrupt::listen(2);
    let all = match frames(options) {
        Ok(all) => all,
        Err(e) => {
            print_error(&e.to_string());
            return ExitCode::from(1);
        }
    };
    if all.is_empty() {
        print_error("no frame lies between the first and the last that are asked for");
        return ExitCode::from(1);
    }
    let trees = (all.len() > 1).then(Arc::<TreeStore>::default);
    let worth_a_gpu = Arc::default();
    for (k, frame) in all.iter().enumerate() {
        let streams = match Streams::open(options, &options.output_folder(input), k > 0) {
            Ok(s) => s,
            Err(e) => {
                print_error(&e);
                return ExitCode::from(1);
            }
        };
        if k == 0 {
            for (key, why) in &options.ignored {
                streams.write(StreamKind::Warning, &format!("note: {key} has no effect: {why}\n"));
            }
        }
        if options.is_animation() && options.verbose {
            streams.write(StreamKind::Render, &format!("Rendering frame {} of {} (#{})\n", k + 1, all.len(), frame.number));
        }
        let listener = PovListener { streams, options, style: style(), last: Mutex::new(None), interrupt: interrupt.clone() };
        let result = job_for_frame(options, input, frame).and_then(|mut job| {
            job.compile.trees = trees.clone();
            job.worth_a_gpu = Arc::clone(&worth_a_gpu);
            picture(&job, frame, &listener)
        });
        interrupt.rendering.store(false, Ordering::SeqCst);
        match result {
            Ok(()) => {}
            Err(e) => {
                let interrupted = matches!(e, JobError::Interrupted { .. });
                let head = if interrupted { "Render cancelled by user" } else { "Render failed" };
                if !matches!(e, JobError::Scene) {
                    listener.streams.write(StreamKind::Fatal, &render(&error(&e), &SourceMap::default(), listener.style));
                }
                listener.streams.write(StreamKind::Fatal, &format!("{head}\n"));
                return ExitCode::from(if interrupted { 2 } else { 1 });
            }
        }
    }
    ExitCode::SUCCESS
}

fn error(e: &JobError) -> Diagnostic {
    Diagnostic::new(Severity::Error, None, e.to_string())
}

/// One frame, with what POV-Ray prints around it.
fn picture(job: &Job, frame: &Frame, listener: &PovListener) -> Result<(), JobError> {
    if listener.options.continue_trace
        && let Some(path) = job.target.as_ref().and_then(|t| t.path.as_ref())
        && path.exists()
        && !rayloom::film::state::path_for(path).exists()
    {
        listener.streams.write(StreamKind::Render, &format!("'{}' is there already; skipped\n", path.display()));
        return Ok(());
    }
    listener.streams.write(StreamKind::Render, &listener.heading(job, frame));
    let outcome = rayloom::job::run(job, listener, &listener.interrupt.cancel)?;
    listener.streams.write(StreamKind::Statistic, &statistics(job, &outcome));
    listener.streams.write(StreamKind::Render, "POV-Ray finished\n");
    Ok(())
}

/// `File 'scene.pov' line 12: Parse Error: message`, for findings of the scene language. Source: spec/language.md, section 5.
fn povray_line(d: &Diagnostic, map: &SourceMap) -> Option<String> {
    let span = d.span.filter(|_| d.severity != Severity::Note)?;
    let file = map.file(span.file);
    let bytes = &file.bytes;
    // An error at the end of the file is named at the last token.
    let end = (span.hi as usize).min(bytes.len());
    let at_end = bytes[end..].iter().all(u8::is_ascii_whitespace);
    let last = bytes[..end].iter().rposition(|b| !b.is_ascii_whitespace()).unwrap_or(0);
    let line = file.line_col(if at_end { last as u32 } else { span.lo }).0;
    // POV-Ray counts one line too few where a word or number ends the file without a line break.
    let cut_short = at_end && last + 1 == bytes.len() && (bytes[last].is_ascii_alphanumeric() || bytes[last] == b'_');
    let line = line - u32::from(cut_short && line > 1);
    let word = if d.severity == Severity::Error { "Parse Error" } else { "Parse Warning" };
    let message = if d.message.starts_with("Possible") { d.message.clone() } else { format!("{word}: {}", d.message) };
    Some(format!("File '{}' line {line}: {message}", file.name))
}

fn rule(title: &str) -> String {
    let head = format!("==== [{title}] ");
    format!("{head}{}\n", "=".repeat(76usize.saturating_sub(head.len())))
}

fn statistics(job: &Job, o: &Outcome) -> String {
    let dashes = "-".repeat(76);
    let [objects, prims, lights] = o.counts;
    let [load, compile, trace, write] = o.seconds;
    let r = &job.render;
    let photons = o.photons.map_or(String::new(), |p| {
        let media = if p.in_media > 0 { format!("Media photons stored:       {:>12}\n", p.in_media) } else { String::new() };
        format!("Number of photons shot:     {:>12}\nSurface photons stored:     {:>12}\n{media}{dashes}\n", p.shot, p.on_surfaces)
    });
    format!(
        "{dashes}\nRender Statistics\nImage Resolution {} x {}\n{dashes}\n\
         Objects: {objects}   Primitives: {prims}   Light Sources: {lights}\n{dashes}\n{photons}\
         Parse Time: {load:.3} seconds   Bounding Time: {compile:.3} seconds\n\
         Trace Time: {trace:.3} seconds on {}   Write Time: {write:.3} seconds\n{}",
        r.width,
        r.height,
        o.device,
        rayloom::memory::peak().map_or(String::new(), |n| format!("Peak Memory Used: {n} bytes\n")),
    )
}

struct PovListener<'o> {
    streams: Streams,
    options: &'o PovOptions,
    style: Style,
    /// When progress was printed last.
    last: Mutex<Option<Instant>>,
    interrupt: Interrupt,
}

/// Progress comes no more often than this.
const PAUSE: Duration = Duration::from_millis(500);

impl PovListener<'_> {
    fn progress(&self, what: &str, done: u64, total: u64, of: &str) {
        if !self.options.verbose {
            return;
        }
        let Ok(mut last) = self.last.try_lock() else { return };
        if done < total && last.is_some_and(|l| l.elapsed() < PAUSE) {
            return;
        }
        *last = Some(Instant::now());
        let end = if done >= total { "\n" } else { "\r" };
        self.streams.write(StreamKind::Render, &format!("{what} {done} of {total} {of} ({}%){end}", 100 * done / total.max(1)));
    }

    fn heading(&self, job: &Job, frame: &Frame) -> String {
        let [x0, y0, x1, y1] = job.render.crop;
        let paths: String = job.source.library_paths.iter().map(|p| format!("    {}\n", p.display())).collect();
        let output = match job.target.as_ref().map(|t| &t.path) {
            None => "(none)".to_owned(),
            Some(None) => "standard output".to_owned(),
            Some(Some(p)) => p.display().to_string(),
        };
        let animation = if frame.digits > 0 { "(Animation on)" } else { "(Animation off)" };
        format!(
            "Parser Options\n  Input file: {}\n  Library paths:\n{paths}  Clock value: {:8.3}  {animation}\n\
             Image Output Options\n  Image resolution.....{} by {} (rows {} to {y1}, columns {} to {x1}).\n  Output file..........{output}\n",
            job.source.path.display(),
            frame.clock,
            job.render.width,
            job.render.height,
            y0 + 1,
            x0 + 1,
        )
    }
}

impl Listener for PovListener<'_> {
    fn stage(&self, stage: &Stage) {
        match stage {
            Stage::Loading => self.streams.write(StreamKind::Render, &rule("Parsing...")),
            Stage::Rendering { device, resumed_pixels } => {
                self.interrupt.rendering.store(true, Ordering::SeqCst);
                let resumed = if *resumed_pixels > 0 { format!(", {resumed_pixels} pixels from an earlier run") } else { String::new() };
                self.streams.write(StreamKind::Render, &format!("{}  {device}{resumed}\n", rule("Rendering...")));
            }
            Stage::Compiling | Stage::Denoising | Stage::Writing => {}
        }
    }

    fn diagnostic(&self, d: &Diagnostic, map: &SourceMap) {
        let kind = if d.severity == Severity::Error { StreamKind::Fatal } else { StreamKind::Warning };
        let ours = render(d, map, self.style);
        match povray_line(d, map) {
            // POV-Ray's own first line, which editors and scripts read; then the place as we show it.
            Some(line) => self.streams.write(kind, &format!("{line}\n{}", ours.split_once('\n').map_or("", |(_, rest)| rest))),
            None => self.streams.write(kind, &ours),
        }
    }

    fn text(&self, _stream: Stream, text: &str) {
        self.streams.write(StreamKind::Debug, text);
    }

    fn pixels(&self, done: u64, total: u64) {
        self.progress("Rendered", done, total, "pixels");
    }

    fn photons(&self, done: u64, total: u64) {
        self.progress("Shot", done, total, "photons");
    }
}
