//! The statements of an OBJ file. Indices are resolved and checked as they come; polygons are still whole.

use super::super::ImportError;
use crate::diag::Sink;
use crate::math::Vec3;
use std::collections::HashMap;
use std::path::Path;

/// "No normal", "no coordinates" at a corner.
pub(super) const NONE: u32 = u32::MAX;

/// Most corners of one face: cutting a polygon may take time with their square.
const MAX_CORNERS: usize = 1 << 14;

/// Most kinds of unknown statements that are told one by one.
const MAX_UNKNOWN: usize = 12;

/// One corner of a face, from 0; `NONE` where it has none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Corner {
    pub vertex: u32,
    pub uv: u32,
    pub normal: u32,
}

/// Consecutive faces that share material and smoothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Run {
    /// First face.
    pub first: usize,
    /// Into `materials`.
    pub material: u32,
    /// Smoothing group; 0 for none.
    pub smoothing: u32,
}

/// All that an OBJ file holds.
#[derive(Debug, Default)]
pub(super) struct Geometry {
    pub vertices: Vec<Vec3>,
    /// By vertex, as written; shorter than `vertices` when the last ones have none.
    pub colors: Vec<[f32; 3]>,
    pub normals: Vec<Vec3>,
    pub uvs: Vec<[f32; 2]>,
    pub corners: Vec<Corner>,
    /// End of each face in `corners`.
    pub face_ends: Vec<u32>,
    pub runs: Vec<Run>,
    /// Names of materials in the order of first use; the first is "none".
    pub materials: Vec<String>,
    /// Arguments of every `mtllib`.
    pub libraries: Vec<String>,
    /// The file has statements of the format.
    pub has_statements: bool,
}

struct Parser<'a> {
    path: &'a Path,
    out: Geometry,
    material_ix: HashMap<String, u32>,
    material: u32,
    smoothing: u32,
    object: String,
    line: usize,
    unknown: Vec<String>,
}

impl Geometry {
    /// Reads a whole file.
    pub fn parse(path: &Path, bytes: &[u8], sink: &mut Sink) -> Result<Self, ImportError> {
        let mut p = Parser {
            path,
            out: Geometry { materials: vec![String::new()], ..Geometry::default() },
            material_ix: HashMap::from([(String::new(), 0)]),
            material: 0,
            smoothing: 0,
            object: String::new(),
            line: 0,
            unknown: Vec::new(),
        };
        let mut joined: Vec<u8> = Vec::new();
        for line in bytes.split(|b| *b == b'\n') {
            p.line += 1;
            let line = line.strip_suffix(b"\r").unwrap_or(line);
            if let Some(head) = line.strip_suffix(b"\\") {
                joined.extend_from_slice(head);
                joined.push(b' ');
            } else if joined.is_empty() {
                p.statement(line, sink)?;
            } else {
                joined.extend_from_slice(line);
                p.statement(&joined, sink)?;
                joined.clear();
            }
        }
        p.statement(&joined, sink)?;
        Ok(p.out)
    }

    /// Corners of face `k`.
    pub fn face(&self, k: usize) -> &[Corner] {
        let start = if k == 0 { 0 } else { self.face_ends[k - 1] as usize };
        &self.corners[start..self.face_ends[k] as usize]
    }
}

/// Text of a name or message; bytes that are no UTF-8 are replaced.
fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).trim().to_owned()
}

fn words(bytes: &[u8]) -> impl Iterator<Item = &[u8]> {
    bytes.split(|b| b.is_ascii_whitespace()).filter(|w| !w.is_empty())
}

impl Parser<'_> {
    fn place(&self) -> String {
        if self.object.is_empty() { format!("line {}", self.line) } else { format!("line {} (object '{}')", self.line, self.object) }
    }

    fn invalid(&self, what: impl Into<String>) -> ImportError {
        ImportError::Invalid { path: self.path.to_owned(), place: self.place(), what: what.into() }
    }

    fn statement(&mut self, line: &[u8], sink: &mut Sink) -> Result<(), ImportError> {
        let line = line.trim_ascii();
        if line.is_empty() || line[0] == b'#' {
            return Ok(());
        }
        let end = line.iter().position(u8::is_ascii_whitespace).unwrap_or(line.len());
        let (key, rest) = (&line[..end], line[end..].trim_ascii());
        match key {
            b"v" => self.vertex(rest)?,
            b"vn" => {
                let n: [f32; 3] = self.numbers(rest, 3)?.0;
                self.out.normals.push(Vec3::from_array(n).try_normalize().unwrap_or(Vec3::ZERO));
            }
            b"vt" => {
                let c: [f32; 2] = self.numbers(rest, 1)?.0;
                self.out.uvs.push(if c.iter().all(|v| v.is_finite()) { c } else { [0.0; 2] });
            }
            b"f" | b"fo" => self.face(rest)?,
            b"usemtl" => self.use_material(text(rest)),
            b"s" => {
                let group = words(rest).next().unwrap_or(b"off");
                // Any word but "off" and 0 is a group.
                self.smoothing = match group {
                    b"off" | b"0" => 0,
                    g => std::str::from_utf8(g).ok().and_then(|g| g.parse().ok()).unwrap_or(1),
                };
                self.start_run();
            }
            b"o" | b"g" => self.object = text(rest),
            b"mtllib" => self.out.libraries.push(text(rest)),
            b"p" | b"l" => sink.note_once("obj: points and lines", None, "points and lines are left out"),
            b"vp" | b"cstype" | b"deg" | b"bmat" | b"step" | b"curv" | b"curv2" | b"surf" | b"parm" | b"trim" | b"hole" | b"scrv"
            | b"sp" | b"end" | b"con" => sink.note_once("obj: free-form", None, "free-form curves and surfaces are left out"),
            b"mg" | b"bevel" | b"c_interp" | b"d_interp" | b"lod" | b"maplib" | b"usemap" | b"shadow_obj" | b"trace_obj" | b"ctech"
            | b"stech" => sink.note_once("obj: display", None, format!("'{}' and its like are left out", text(key))),
            _ => {
                self.unknown_statement(text(key), sink);
                return Ok(());
            }
        }
        self.out.has_statements = true;
        Ok(())
    }

    fn unknown_statement(&mut self, key: String, sink: &mut Sink) {
        if self.unknown.len() < MAX_UNKNOWN && !self.unknown.contains(&key) {
            let shown: String = key.chars().take(40).collect();
            sink.note_once(&format!("obj: {shown}"), None, format!("line {}: the statement '{shown}' is unknown and left out", self.line));
            self.unknown.push(key);
        }
    }

    /// Up to `N` numbers, at least `least`, and how many there were.
    fn numbers<const N: usize>(&self, rest: &[u8], least: usize) -> Result<([f32; N], usize), ImportError> {
        let (mut out, mut n) = ([0.0; N], 0);
        for word in words(rest).take(N) {
            let number = std::str::from_utf8(word).ok().and_then(|w| w.parse::<f32>().ok());
            out[n] = number.ok_or_else(|| self.invalid(format!("'{}' is no number", text(&word[..word.len().min(40)]))))?;
            n += 1;
        }
        if n < least { Err(self.invalid(format!("{least} numbers are needed, there are {n}"))) } else { Ok((out, n)) }
    }

    /// `x y z`, `x y z w` or `x y z r g b`.
    fn vertex(&mut self, rest: &[u8]) -> Result<(), ImportError> {
        let (n, count): ([f32; 6], usize) = self.numbers(rest, 3)?;
        let v = Vec3::new(n[0], n[1], n[2]);
        let vertex = self.out.vertices.len() + 1;
        if !v.is_finite() {
            return Err(ImportError::NotFinite { path: self.path.to_owned(), place: self.place(), vertex, x: v.x, y: v.y, z: v.z });
        }
        if count == 6 {
            self.out.colors.resize(vertex - 1, [1.0; 3]);
            let c = [n[3], n[4], n[5]];
            self.out.colors.push(if c.iter().all(|v| v.is_finite()) { c } else { [1.0; 3] });
        }
        self.out.vertices.push(v);
        Ok(())
    }

    fn use_material(&mut self, name: String) {
        let next = self.out.materials.len() as u32;
        self.material = *self.material_ix.entry(name.clone()).or_insert(next);
        if self.material == next {
            self.out.materials.push(name);
        }
        self.start_run();
    }

    /// The faces that follow have the current material and smoothing.
    fn start_run(&mut self) {
        let run = Run { first: self.out.face_ends.len(), material: self.material, smoothing: self.smoothing };
        match self.out.runs.last_mut() {
            Some(last) if last.first == run.first => *last = run,
            _ => self.out.runs.push(run),
        }
    }

    fn face(&mut self, rest: &[u8]) -> Result<(), ImportError> {
        if self.out.runs.is_empty() {
            self.start_run();
        }
        let start = self.out.corners.len();
        for word in words(rest) {
            let mut parts = word.split(|b| *b == b'/');
            let vertex = parts.next().unwrap_or(b"");
            let corner = Corner {
                vertex: self.index(vertex, self.out.vertices.len(), "vertices")?,
                uv: self.optional_index(parts.next(), self.out.uvs.len(), "texture coordinates")?,
                normal: self.optional_index(parts.next(), self.out.normals.len(), "normals")?,
            };
            self.out.corners.push(corner);
        }
        if self.out.corners.len() - start < 3 {
            return Err(self.invalid("a face needs 3 corners"));
        }
        if self.out.corners.len() - start > MAX_CORNERS {
            return Err(self.invalid(format!("a face of more than {MAX_CORNERS} corners")));
        }
        if self.out.corners.len() >= NONE as usize {
            return Err(ImportError::TooMany { path: self.path.to_owned(), what: "corners of faces", limit: NONE as usize });
        }
        self.out.face_ends.push(self.out.corners.len() as u32);
        Ok(())
    }

    fn optional_index(&self, word: Option<&[u8]>, count: usize, what: &'static str) -> Result<u32, ImportError> {
        word.filter(|w| !w.is_empty()).map_or(Ok(NONE), |w| self.index(w, count, what))
    }

    /// An index from 1, or from the end when negative, as one from 0.
    fn index(&self, word: &[u8], count: usize, what: &'static str) -> Result<u32, ImportError> {
        let (negative, digits) = word.strip_prefix(b"-").map_or((false, word), |d| (true, d));
        if digits.is_empty() || digits.len() > 18 || !digits.iter().all(u8::is_ascii_digit) {
            return Err(self.invalid(format!("'{}' is no index", text(&word[..word.len().min(40)]))));
        }
        let value = digits.iter().fold(0i64, |n, d| 10 * n + i64::from(d - b'0'));
        let from_zero = if negative { count as i64 - value } else { value - 1 };
        if value == 0 || from_zero < 0 || from_zero >= count as i64 {
            let index = if negative { -value } else { value };
            return Err(ImportError::IndexOutOfRange { path: self.path.to_owned(), place: self.place(), index, count, what });
        }
        Ok(from_zero as u32)
    }
}
