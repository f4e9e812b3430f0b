//! What is fed with bytes, and what came of it.

use super::files;
use rayloom::backend::Backend;
use rayloom::backend::cpu::CpuBackend;
use rayloom::compile::{CompileOptions, compile_scene};
use rayloom::diag::{Sink, SourceMap, Style, render};
use rayloom::film::Film;
use rayloom::import::ImportOptions;
use rayloom::integrate::RenderSettings;
use rayloom::kernel::query::KernelQuery;
use rayloom::lang::options::{Environment, PovOptions, frames};
use rayloom::lang::{LangOptions, parse_scene};
use rayloom::memory::MemoryLimit;
use rayloom::scene::Scene;
use rayloom::world::{World, WorldError};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, mpsc};
use std::time::{Duration, Instant};

/// Stack of the thread that reads and compiles, as the program gives it.
const STACK_BYTES: usize = 1 << 30;
/// Rendering is cancelled after this: a picture may be slow, cancelling may not.
const RENDER_TIME: Duration = Duration::from_millis(400);

/// A kind of input, and a folder of the corpus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A scene in POV-Ray's language: read, compiled, rendered.
    Scene,
    /// An image that a scene uses.
    Image,
    /// A font that a scene uses.
    Font,
    /// A df3 file that a scene uses.
    Density,
    /// A glTF file: loaded, compiled, rendered.
    Gltf,
    /// An OBJ file, its MTL after a line `%%mtl`.
    Obj,
    /// An INI file.
    Ini,
    /// Words of a command line, one a line.
    Words,
    /// The state of an unfinished picture.
    State,
}

impl Kind {
    /// All of them.
    pub const ALL: [Self; 9] =
        [Self::Scene, Self::Image, Self::Font, Self::Density, Self::Gltf, Self::Obj, Self::Ini, Self::Words, Self::State];

    /// Its folder.
    pub fn name(self) -> &'static str {
        match self {
            Self::Scene => "scene",
            Self::Image => "image",
            Self::Font => "font",
            Self::Density => "density",
            Self::Gltf => "gltf",
            Self::Obj => "obj",
            Self::Ini => "ini",
            Self::Words => "words",
            Self::State => "state",
        }
    }
}

/// What came of an input.
#[derive(Debug)]
pub enum Ending {
    /// An answer.
    Answered(Answer),
    /// A panic at a place in the source.
    Panicked(String),
    /// None within the time given.
    Hung,
}

/// What a target says of its input.
#[derive(Clone, Copy, Debug)]
pub struct Answer {
    /// Equal answers have equal numbers.
    pub digest: u64,
    /// The input was taken to its end: a picture, options, a film.
    pub whole: bool,
}

/// Place of the last panic.
static LAST_PANIC: Mutex<String> = Mutex::new(String::new());

/// Panics are kept, not printed.
pub fn hush_panics() {
    let loud = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |info| {
        // Tests and workers have names, the threads of `watch` and what they start have not.
        if std::thread::current().name().is_some() {
            return loud(info);
        }
        let place = info.location().map_or(String::new(), |l| format!("{}:{}", l.file(), l.line()));
        *LAST_PANIC.lock().unwrap_or_else(|e| e.into_inner()) = format!("{place}: {}", info.payload_as_str().unwrap_or(""));
    }));
}

/// Runs `f` on a thread of its own for at most `patience`; a thread that hangs is left behind.
pub fn watch(patience: Duration, f: impl FnOnce() -> Answer + Send + 'static) -> Ending {
    let (tell, hear) = mpsc::channel();
    let body = move || {
        let result = std::panic::catch_unwind(std::panic::AssertUnwindSafe(f));
        let _ = tell.send(result.map_err(|_| LAST_PANIC.lock().unwrap_or_else(|e| e.into_inner()).clone()));
    };
    let thread = std::thread::Builder::new().stack_size(STACK_BYTES).spawn(body).expect("a thread");
    let Ok(result) = hear.recv_timeout(patience) else { return Ending::Hung };
    // Its stack must be gone before the next one's is taken.
    let _ = thread.join();
    result.map_or_else(Ending::Panicked, Ending::Answered)
}

/// Feeds `bytes` to its target.
pub fn run_watched(kind: Kind, bytes: &[u8], patience: Duration) -> Ending {
    let bytes = bytes.to_vec();
    watch(patience, move || run(kind, &bytes))
}

fn run(kind: Kind, bytes: &[u8]) -> Answer {
    match kind {
        Kind::Scene => scene(bytes, FuzzWorld::default()),
        Kind::Image => scene(files::IMAGE_SCENE.as_bytes(), FuzzWorld { image: Some(bytes.into()), ..FuzzWorld::default() }),
        Kind::Font => scene(files::FONT_SCENE.as_bytes(), FuzzWorld { font: Some(bytes.into()), ..FuzzWorld::default() }),
        Kind::Density => scene(files::DENSITY_SCENE.as_bytes(), FuzzWorld { density: Some(bytes.into()), ..FuzzWorld::default() }),
        Kind::Gltf => model(bytes, None),
        Kind::Obj => model(bytes, Some(b"\n%%mtl\n")),
        Kind::Ini => options(&["x.ini".to_owned()], FuzzWorld { ini: Some(bytes.into()), ..FuzzWorld::default() }),
        Kind::Words => {
            let words: Vec<String> = String::from_utf8_lossy(bytes).lines().map(str::to_owned).collect();
            options(&words, FuzzWorld { ini: Some(b"Width=4\n"[..].into()), ..FuzzWorld::default() })
        }
        Kind::State => state(bytes),
    }
}

/// What the files of a scene are; those that are `None` are small and whole.
#[derive(Default)]
struct FuzzWorld {
    image: Option<Arc<[u8]>>,
    font: Option<Arc<[u8]>>,
    density: Option<Arc<[u8]>>,
    ini: Option<Arc<[u8]>>,
    own: Arc<[u8]>,
}

impl World for FuzzWorld {
    fn find(&self, name: &str, _: &[&str]) -> Option<PathBuf> {
        if name.is_empty() || name.contains("missing") { None } else { Some(PathBuf::from(name)) }
    }

    fn read(&self, path: &Path) -> Result<Arc<[u8]>, WorldError> {
        let extension = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
        let or = |given: &Option<Arc<[u8]>>, own: &dyn Fn() -> Vec<u8>| given.clone().unwrap_or_else(|| own().into());
        Ok(match extension.as_deref() {
            Some("inc") => self.own.clone(),
            Some("txt") => b"1, 2.5, \"text\", <1, 2, 3>, -4"[..].into(),
            Some("ttf") => or(&self.font, &files::font),
            Some("df3") => or(&self.density, &files::density),
            Some("ini") => or(&self.ini, &Vec::new),
            _ => or(&self.image, &|| files::png(3, 2)),
        })
    }

    fn write(&self, _: &Path, _: &[u8], _: bool) -> Result<(), WorldError> {
        Ok(())
    }

    fn now_seconds(&self) -> f64 {
        0.0
    }
}

/// A number for what was said, without the places and numbers in it.
fn digest(sink: &Sink, map: &SourceMap, extra: impl Hash) -> u64 {
    let mut h = DefaultHasher::new();
    for d in sink.items().iter().take(20) {
        // Printing is a target as well.
        let _ = render(d, map, Style::default());
        let mut quoted = false;
        let words = d.message.chars().filter(|&c| {
            quoted ^= c == '\'';
            !quoted && !c.is_ascii_digit()
        });
        words.take(60).collect::<String>().hash(&mut h);
    }
    extra.hash(&mut h);
    h.finish()
}

fn scene(bytes: &[u8], world: FuzzWorld) -> Answer {
    let (mut map, mut sink) = (SourceMap::default(), Sink::default());
    let world = FuzzWorld { own: bytes.into(), ..world };
    let options = LangOptions { width: 4, height: 3, max_steps: 20_000, max_objects: 2000, memory: memory(), ..LangOptions::default() };
    let parsed = parse_scene("fuzz.pov", bytes, &world, &KernelQuery::new(), &options, &mut map, &mut sink);
    assert!(parsed.scene.is_some() != sink.has_errors(), "either a scene or an error");
    let drawn = parsed.scene.map(|s| draw(&s));
    Answer { digest: digest(&sink, &map, drawn), whole: drawn.flatten().is_some_and(|(_, whole)| whole) }
}

/// What a target may use: enough for any scene that is taken to its end here.
fn memory() -> MemoryLimit {
    MemoryLimit::bytes(1 << 30)
}

/// Compiles and renders 4 by 3 pixels; whether it compiled and how much of it came.
fn draw(scene: &Scene) -> Option<(usize, bool)> {
    let compiled = compile_scene(scene, &CompileOptions { memory: memory(), ..CompileOptions::default() }).ok()?;
    let settings = RenderSettings { block_size: 1, ..RenderSettings::plain(4, 3) };
    let mut film = Film::new(4, 3);
    let cancel = AtomicBool::new(false);
    let finished = AtomicBool::new(false);
    std::thread::scope(|s| {
        let clock = s.spawn(|| {
            let begin = Instant::now();
            while !finished.load(Ordering::Relaxed) && begin.elapsed() < RENDER_TIME {
                std::thread::park_timeout(RENDER_TIME - begin.elapsed().min(RENDER_TIME));
            }
            cancel.store(true, Ordering::Relaxed);
        });
        let result = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
            CpuBackend::new(1).render(&compiled, &settings, &mut film, &(), &cancel)
        }));
        finished.store(true, Ordering::Relaxed);
        clock.thread().unpark();
        if let Err(panic) = result {
            std::panic::resume_unwind(panic);
        }
    });
    Some((scene.objects.len().min(8), film.samples.iter().all(|n| *n > 0)))
}

/// A folder for files of this process.
fn folder() -> PathBuf {
    let dir = std::env::temp_dir().join(format!("rayloom-fuzz-{}", std::process::id()));
    std::fs::create_dir_all(&dir).expect("a temporary folder");
    dir
}

fn model(bytes: &[u8], split: Option<&[u8]>) -> Answer {
    let mut sink = Sink::default();
    let dir = folder();
    let path = match split {
        None => dir.join(if bytes.starts_with(b"glTF") { "x.glb" } else { "x.gltf" }),
        Some(mark) => {
            let at = bytes.windows(mark.len()).position(|w| w == mark);
            if let Some(at) = at {
                std::fs::write(dir.join("x.mtl"), &bytes[at + mark.len()..]).expect("a file in the temporary folder");
            }
            dir.join("x.obj")
        }
    };
    let end = split.and_then(|m| bytes.windows(m.len()).position(|w| w == m)).unwrap_or(bytes.len());
    std::fs::write(&path, &bytes[..end]).expect("a file in the temporary folder");
    let (error, drawn) = match rayloom::import::load(&path, &ImportOptions::default(), &mut sink) {
        Ok(scene) => (String::new(), draw(&scene)),
        Err(e) => (e.to_string().chars().filter(|c| !c.is_ascii_digit()).take(80).collect(), None),
    };
    Answer { digest: digest(&sink, &SourceMap::default(), (error, drawn)), whole: drawn.is_some_and(|(_, whole)| whole) }
}

fn options(words: &[String], world: FuzzWorld) -> Answer {
    let env = Environment { pov_ini: Some("/nowhere".into()), ..Environment::default() };
    let (said, whole) = match PovOptions::from_command_line(words, &env, &world) {
        Ok(o) => {
            let all = frames(&o).unwrap_or_default();
            let job = all.first().map(|f| rayloom::job::job_for_frame(&o, Path::new("x.pov"), f).map(drop).map_err(|e| e.to_string()));
            (format!("{:?} {job:?} {:?}", all.len().min(9), o.given.keys().collect::<Vec<_>>()), matches!(job, Some(Ok(()))))
        }
        Err(e) => (e.to_string(), false),
    };
    said_by(&said, whole)
}

/// The answer of a target that says one thing.
fn said_by(said: &str, whole: bool) -> Answer {
    let words: String = said.chars().filter(|c| !c.is_ascii_digit()).take(100).collect();
    Answer { digest: digest(&Sink::default(), &SourceMap::default(), words), whole }
}

fn state(bytes: &[u8]) -> Answer {
    let path = folder().join("x.rayloom-state");
    std::fs::write(&path, bytes).expect("a file in the temporary folder");
    let film = rayloom::film::state::load(&path, "fuzz");
    said_by(&film.as_ref().map_or_else(|e| e.to_string(), |f| f.pixels.len().to_string()), film.is_ok())
}
