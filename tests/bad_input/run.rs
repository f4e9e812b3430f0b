//! Runs the program inside bounds of memory and time, and looks at how it ended.

use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Address space of the program in KiB: 1 GiB of stack that is hardly touched, the rest for the scene.
const ADDRESS_KIB: u64 = 4 << 20;
/// No case may take longer, however busy the machine is.
pub const PATIENCE: Duration = Duration::from_secs(90);

/// How a run ended.
#[derive(Debug)]
pub struct Ended {
    /// Exit code; `None` for a signal.
    pub code: Option<i32>,
    /// What it said.
    pub said: String,
    /// Most resident memory seen, in MiB.
    pub peak_mib: u64,
    /// Wall clock.
    pub seconds: f64,
}

impl Ended {
    /// Lines that start an error: as rayloom says them, or as POV-Ray does ("File 'a.pov' line 1: Parse Error: ...").
    pub fn errors(&self) -> Vec<&str> {
        let starts = |l: &&str| l.starts_with("error: ") || l.starts_with("File ") && l.contains(": Parse Error: ");
        self.said.split(['\n', '\r']).filter(starts).collect()
    }

    /// What is wrong with the run, apart from its exit code.
    pub fn faults(&self) -> Option<String> {
        let shown: String = self.said.chars().take(1000).collect();
        if self.said.contains("panicked") || self.said.contains("memory allocation") || self.code.is_none() {
            return Some(format!("it broke down: {shown}"));
        }
        if self.said.chars().any(|c| c.is_control() && !matches!(c, '\n' | '\r' | '\t')) {
            return Some(format!("control characters reach the terminal: {shown:?}"));
        }
        let wanted = usize::from(self.code != Some(0));
        let n = self.errors().len();
        (n != wanted).then(|| format!("{n} errors with exit code {:?}: {shown}", self.code))
    }
}

/// A folder of its own, gone with the value.
pub struct Folder(tempfile::TempDir);

impl Folder {
    pub fn new() -> Self {
        Self(tempfile::tempdir().expect("a temporary folder"))
    }

    /// Path of a name in it.
    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Writes a file.
    pub fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> &Self {
        std::fs::write(self.path(name), bytes).expect("a file in the temporary folder");
        self
    }

    /// The program in this folder with bounded memory; `before` are commands of the shell.
    pub fn start(&self, before: &str, args: &[&str]) -> Child {
        Command::new("sh")
            .args(["-c", &format!("ulimit -c 0; ulimit -v {ADDRESS_KIB}; {before} exec \"$@\""), "sh", env!("CARGO_BIN_EXE_rayloom")])
            .args(args)
            .current_dir(self.0.path())
            .env_remove("RUST_BACKTRACE")
            .env("HOME", self.0.path())
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("a shell")
    }

    /// Runs it to its end.
    pub fn run(&self, args: &[&str]) -> Ended {
        finish(self.start("", args))
    }

    /// `rayloom render` of a small picture into `out.png`.
    pub fn render(&self, scene: &str, more: &[&str]) -> Ended {
        let args = [
            "render",
            scene,
            "-o",
            "out.png",
            "--size",
            "8x6",
            "--antialias",
            "off",
            "--progress",
            "none",
            "--threads",
            "2",
            "--backend",
            "cpu",
        ];
        self.run(&[&args, more].concat())
    }
}

/// Waits for a run, watching its memory; one that takes too long is killed, and so ends by a signal.
pub fn finish(mut child: Child) -> Ended {
    let begin = Instant::now();
    let (out, err) = (child.stdout.take().expect("piped"), child.stderr.take().expect("piped"));
    let readers = [read_all(out), read_all(err)];
    let mut peak_mib = 0;
    let code = loop {
        peak_mib = peak_mib.max(resident_mib(child.id()));
        if let Some(status) = child.try_wait().expect("a child") {
            break status.code();
        }
        if begin.elapsed() > PATIENCE {
            let _ = child.kill();
        }
        std::thread::sleep(Duration::from_millis(5));
    };
    let seconds = begin.elapsed().as_secs_f64();
    let said = readers.map(|r| r.join().expect("a reader")).concat();
    Ended { code, said, peak_mib, seconds }
}

fn read_all(mut from: impl Read + Send + 'static) -> std::thread::JoinHandle<String> {
    std::thread::spawn(move || {
        let mut bytes = Vec::new();
        let _ = from.read_to_end(&mut bytes);
        String::from_utf8_lossy(&bytes).into_owned()
    })
}

fn resident_mib(pid: u32) -> u64 {
    let text = std::fs::read_to_string(format!("/proc/{pid}/status")).unwrap_or_default();
    let kib = text.lines().find_map(|l| l.strip_prefix("VmHWM:")).and_then(|l| l.split_whitespace().next()?.parse::<u64>().ok());
    kib.unwrap_or(0) >> 10
}

/// Sends a signal, "INT" or "KILL".
pub fn signal(child: &Child, name: &str) {
    let status = Command::new("kill").args([&format!("-{name}"), &child.id().to_string()]).status();
    assert!(status.is_ok_and(|s| s.success()), "a signal could be sent");
}

/// Waits until a file is there and not empty.
pub fn wait_for(path: &Path) {
    let begin = Instant::now();
    while path.metadata().map_or(0, |m| m.len()) == 0 {
        assert!(begin.elapsed() < PATIENCE, "{} never came", path.display());
        std::thread::sleep(Duration::from_millis(5));
    }
}
