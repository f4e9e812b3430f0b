//! POV-Ray's scene language → [`Scene`]. Source: spec/language.md.
//!
//! Text is lexed once a file (`lexer`), then read by a recursive-descent parser (`parser/`) whose token stream runs directives and
//! expands macros as it goes (`parser/stream.rs`, `parser/directives.rs`).

pub mod intern;
pub mod keyword;
pub mod lexer;
pub mod options;
pub mod parser;
pub mod token;
pub mod value;

use crate::diag::{Diagnostic, Sink, SourceMap};
use crate::memory::MemoryLimit;
use crate::scene::{Scene, SceneQuery};
use crate::world::World;

/// A constant given from outside (`Declare=`).
#[derive(Clone, Debug, PartialEq)]
pub enum Declared {
    /// A number.
    Float(f64),
    /// A string.
    Text(String),
}

/// What decides the reading of a scene besides its text.
#[derive(Clone, Debug)]
pub struct LangOptions {
    /// Columns of the picture (`image_width`).
    pub width: u32,
    /// Rows of the picture (`image_height`).
    pub height: u32,
    /// Value of `clock`, kept in single precision as POV-Ray does.
    pub clock: f64,
    /// Whether `clock` was given.
    pub clock_on: bool,
    /// `frame_number`, `initial_frame`, `final_frame`, `clock_delta`, `initial_clock`, `final_clock`; zeros without animation.
    pub frame: [f64; 6],
    /// Constants; the first value of a name wins.
    pub declares: Vec<(String, Declared)>,
    /// Parsed before the scene (`+HI`).
    pub header: Option<String>,
    /// Initial language version times 100, when given (`+MV`).
    pub version: Option<u32>,
    /// Steps of loops and macro calls after which a scene is called endless.
    pub max_steps: u64,
    /// Most objects that a scene may place.
    pub max_objects: usize,
    /// Memory that the process may use.
    pub memory: MemoryLimit,
}

impl Default for LangOptions {
    fn default() -> Self {
        Self {
            width: 160,
            height: 120,
            clock: 0.0,
            clock_on: false,
            frame: [0.0; 6],
            declares: Vec::new(),
            header: None,
            version: None,
            max_steps: 100_000_000,
            max_objects: 10_000_000,
            memory: MemoryLimit::default(),
        }
    }
}

/// Streams that a scene writes to while it is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stream {
    /// `#debug`.
    Debug,
    /// `#render`.
    Render,
    /// `#statistics`.
    Statistics,
}

/// A scene that was read, or as much of it as can be told.
#[derive(Debug)]
pub struct Parsed {
    /// The scene, absent after an error.
    pub scene: Option<Scene>,
    /// What the scene wrote, in order, lines broken as POV-Ray breaks them.
    pub output: Vec<(Stream, String)>,
}

/// Reads a scene. Findings go to `sink`; after an error there is no scene, and `sink.has_errors()`.
pub fn parse_scene(
    name: &str,
    bytes: &[u8],
    world: &dyn World,
    query: &dyn SceneQuery,
    options: &LangOptions,
    map: &mut SourceMap,
    sink: &mut Sink,
) -> Parsed {
    let mut p = parser::Parser::new(world, query, options, map, sink);
    let result = p.run(name, bytes);
    let output = p.take_output();
    let scene = match result {
        Ok(scene) => Some(scene),
        Err(fatal) => {
            sink.push(*fatal);
            None
        }
    };
    Parsed { scene, output }
}

/// A fatal finding.
pub type Fatal = Box<Diagnostic>;
