//! The parser: recursive descent over a token stream that runs directives by itself.
//!
//! One file a subject: `stream` (tokens, directives' places, messages), `directives`, `macros`, `expr` and its functions, `color`, `string`,
//! `user_function`, `files`; then the scene's statements.

mod arrays;
mod camera;
mod color;
mod csg;
mod curves;
mod declare;
mod decode;
mod directives;
mod expr;
mod files;
mod float_functions;
mod images;
mod interior;
mod light;
mod macros;
mod mesh;
mod objects;
mod pattern;
mod settings;
mod statements;
mod stream;
mod string;
mod text;
mod texture;
mod transforms;
mod user_function;

use super::intern::Interner;
#[cfg(doc)]
use super::token::TokenKind;
use super::token::{Symbol, Token};
use super::value::{Num, SymbolTable, Value};
use super::{Declared, Fatal, LangOptions, Stream};
use crate::diag::{FileId, Sink, SourceMap, Span};
use crate::scene::{Camera, Finish, Normal, Pigment, Scene, SceneQuery, Texture, TextureLayer};
use crate::world::World;
use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;

/// What a parsing function gives; the error ends the scene.
pub type PResult<T> = Result<T, Fatal>;

/// Bytes and tokens of an include, kept for the next time.
type LexedFile = (Arc<[u8]>, Arc<[Token]>);

/// Where tokens come from, innermost last.
#[derive(Debug)]
struct Frame {
    kind: FrameKind,
    tokens: Arc<[Token]>,
    at: usize,
    end: usize,
    /// Conditionals that were open when the frame began.
    n_conds: usize,
    /// Place of the `#include` or the call.
    from: Option<Span>,
}

#[derive(Debug)]
enum FrameKind {
    Include,
    Macro(Symbol),
}

/// An open conditional.
#[derive(Debug)]
struct Cond {
    kind: CondKind,
    span: Span,
}

#[derive(Debug)]
enum CondKind {
    /// `#if` and its relatives; `true` once a branch was taken.
    If,
    /// Inside a taken `#else`.
    Else,
    /// Inside a taken branch of `#switch`.
    Switch,
    /// `#while`: frame depth and index of the condition.
    While { frame: usize, at: usize },
    /// `#for`: frame depth and index of the body, the variable and where it stands.
    For { frame: usize, at: usize, scope: usize, name: Symbol, end: f64, step: f64 },
}

/// The `#default` settings.
struct Defaults {
    pigment: Arc<Pigment>,
    normal: Option<Arc<Normal>>,
    finish: Arc<Finish>,
    camera: Camera,
    importance: f64,
}

impl Defaults {
    fn layer(&self) -> TextureLayer {
        TextureLayer { pigment: self.pigment.clone(), normal: self.normal.clone(), finish: self.finish.clone() }
    }

    fn texture(&self) -> Arc<Texture> {
        Arc::new(Texture::Layers(vec![self.layer()]))
    }
}

/// The state of a parse.
pub struct Parser<'a> {
    world: &'a dyn World,
    query: &'a dyn SceneQuery,
    options: &'a LangOptions,
    map: &'a mut SourceMap,
    sink: &'a mut Sink,
    interner: Interner,
    symbols: SymbolTable,
    frames: Vec<Frame>,
    conds: Vec<Cond>,
    /// A token read ahead, as it stands in the text.
    ahead: Option<Token>,
    /// Whether `ahead` was read where directives are open, so that it can be taken as it is.
    ahead_is_open: bool,
    /// Value of the [`TokenKind::Element`] in `ahead`.
    element: Option<Value>,
    /// Directives and macro calls are left alone.
    closed: bool,
    /// They are left alone where an operator may stand (values of declarations, conditions, macro arguments).
    closed_ops: bool,
    /// The last token taken.
    last_span: Span,
    /// Loop turns and macro calls so far.
    steps: u64,
    /// Nesting of blocks and parentheses.
    depth: usize,
    /// Nesting of what was read since the innermost block began, values of names included.
    reach: u32,
    /// Bytes taken since memory was looked at.
    charged: usize,
    /// Random streams of `seed()`.
    seeds: Vec<u32>,
    files: Vec<Option<files::UserFile>>,
    lexed: HashMap<PathBuf, LexedFile>,
    output: Vec<(Stream, String)>,
    debug_line: String,
    utf8: bool,
    /// Language version times 100.
    version: u32,
    version_set: bool,
    /// Something stood before the first `#version`.
    version_late: bool,
    gamma_set: bool,
    noise_set: bool,
    defaults: Defaults,
    camera_set: bool,
    n_objects: usize,
    scene: Scene,
    images: images::ImageCache,
    /// What finishes inside textures say of the interior, by the finish's address.
    finish_extras: std::collections::HashMap<usize, (Arc<Finish>, super::value::FinishExtras)>,
}

/// Values that are made of earlier values of the same kind, again and again, are refused beyond this: they are walked, and dropped,
/// by recursion.
const MAX_REACH: u32 = 20_000;
/// Memory is looked at each time this many bytes were taken.
const CHARGE: usize = 16 << 20;
/// Bytes of what stands between braces, parentheses or the brackets of a vector, besides what is charged where it is taken.
const NEST_COST: usize = 512;

/// Blocks and parentheses nested deeper than this are refused, before the stack is in danger.
const MAX_DEPTH: usize = 200;

impl<'a> Parser<'a> {
    /// A parser with the pre-declared names.
    pub fn new(
        world: &'a dyn World,
        query: &'a dyn SceneQuery,
        options: &'a LangOptions,
        map: &'a mut SourceMap,
        sink: &'a mut Sink,
    ) -> Self {
        let nowhere = Span { file: FileId(0), lo: 0, hi: 0 };
        let mut p = Self {
            world,
            query,
            options,
            map,
            sink,
            interner: Interner::default(),
            symbols: SymbolTable::default(),
            frames: Vec::new(),
            conds: Vec::new(),
            ahead: None,
            ahead_is_open: false,
            element: None,
            closed: false,
            closed_ops: false,
            last_span: nowhere,
            steps: 0,
            depth: 0,
            reach: 0,
            charged: 0,
            seeds: Vec::new(),
            files: Vec::new(),
            lexed: std::collections::HashMap::new(),
            output: Vec::new(),
            debug_line: String::new(),
            utf8: false,
            version: options.version.unwrap_or(370),
            version_set: options.version.is_some(),
            version_late: false,
            gamma_set: false,
            noise_set: false,
            defaults: Defaults {
                pigment: Arc::new(Pigment::solid(crate::math::Rgbft::BLACK)),
                normal: None,
                finish: Arc::new(Finish::default()),
                camera: Camera::default(),
                importance: 1.0,
            },
            camera_set: false,
            n_objects: 0,
            scene: Scene::default(),
            images: images::ImageCache::default(),
            finish_extras: std::collections::HashMap::new(),
        };
        let f = options.frame;
        for (name, value) in [
            ("image_width", f64::from(options.width)),
            ("image_height", f64::from(options.height)),
            ("frame_number", f[0]),
            ("initial_frame", f[1]),
            ("final_frame", f[2]),
            ("clock_delta", f[3]),
            ("initial_clock", f[4]),
            ("final_clock", f[5]),
        ] {
            p.predeclare(name, Value::Num(Num::float(six_digits(value))));
        }
        for (name, value) in &options.declares {
            let value = match value {
                Declared::Float(x) => Value::Num(Num::float(six_digits(*x))),
                Declared::Text(t) => Value::Str(t.encode_utf16().collect()),
            };
            p.predeclare(name, value);
        }
        p
    }

    fn predeclare(&mut self, name: &str, value: Value) {
        let name = self.interner.intern(name.as_bytes());
        if !self.symbols.scopes[0].contains_key(&name) {
            self.symbols.set(0, name, value);
        }
    }

    /// Reads the whole scene.
    pub fn run(&mut self, name: &str, bytes: &[u8]) -> PResult<Scene> {
        let main = self.map.add(name, std::path::PathBuf::from(name), bytes.into());
        self.last_span = Span { file: main, lo: 0, hi: 0 };
        self.charge(bytes.len().saturating_mul(4))?;
        let (tokens, utf8) = super::lexer::lex(main, bytes, true, &mut self.interner);
        self.utf8 = utf8;
        self.push_include(tokens.into(), None);
        if let Some(header) = self.options.header.clone() {
            self.include_file(&header, None)?;
        }
        self.parse_statements()?;
        self.finish_scene()
    }

    /// What the scene wrote.
    pub fn take_output(&mut self) -> Vec<(Stream, String)> {
        std::mem::take(&mut self.output)
    }
}

/// Numbers that travel as text keep six significant digits. Source: spec/language.md, section 9.
fn six_digits(x: f64) -> f64 {
    if x == 0.0 || !x.is_finite() { x } else { format!("{x:.5e}").parse().unwrap_or(x) }
}
