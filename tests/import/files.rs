//! Files in a folder of their own, and what `load` says of them.

use rayloom::diag::Sink;
use rayloom::import::{ImportError, ImportOptions, load};
use rayloom::scene::{Mesh, Principled, Scene, Shape, Texture};
use std::sync::Arc;

/// A folder that goes away with its files.
pub struct Folder(tempfile::TempDir);

impl Folder {
    pub fn new() -> Self {
        Self(tempfile::tempdir().expect("a temporary folder"))
    }

    /// With one more file.
    pub fn with(self, name: &str, bytes: impl AsRef<[u8]>) -> Self {
        std::fs::write(self.0.path().join(name), bytes).expect("a writable folder");
        self
    }

    pub fn path(&self, name: &str) -> std::path::PathBuf {
        self.0.path().join(name)
    }

    /// The scene of a file, and what was said.
    pub fn load(&self, name: &str) -> (Result<Scene, ImportError>, Vec<String>) {
        let mut sink = Sink::default();
        let scene = load(&self.path(name), &ImportOptions { aspect: 2.0, ..ImportOptions::default() }, &mut sink);
        (scene, sink.items().iter().map(|d| d.message.clone()).collect())
    }

    pub fn scene(&self, name: &str) -> Scene {
        self.load(name).0.unwrap_or_else(|e| panic!("{e}"))
    }

    pub fn error(&self, name: &str) -> String {
        match self.load(name).0 {
            Ok(_) => panic!("{name} loads"),
            Err(e) => e.to_string(),
        }
    }
}

/// The mesh of object `k`.
pub fn mesh(scene: &Scene, k: usize) -> &Arc<Mesh> {
    match &scene.objects[k].shape {
        Shape::Mesh(m) => m,
        other => panic!("object {k} is {other:?}"),
    }
}

/// The material of object `k`.
pub fn material(scene: &Scene, k: usize) -> &Principled {
    match scene.objects[k].texture.as_deref() {
        Some(Texture::Principled(p)) => p,
        other => panic!("object {k} wears {other:?}"),
    }
}

/// A PNG of 8-bit RGBA.
pub fn png(width: u32, height: u32, pixel: impl Fn(u32, u32) -> [u8; 4]) -> Vec<u8> {
    let mut out = std::io::Cursor::new(Vec::new());
    image::RgbaImage::from_fn(width, height, |x, y| image::Rgba(pixel(x, y))).write_to(&mut out, image::ImageFormat::Png).expect("a PNG");
    out.into_inner()
}

/// A .glb of JSON and binary data.
pub fn glb(json: &str, bin: &[u8]) -> Vec<u8> {
    let padded = |data: &[u8], fill: u8| {
        let mut data = data.to_vec();
        data.resize(data.len().next_multiple_of(4), fill);
        data
    };
    let (json, bin) = (padded(json.as_bytes(), b' '), padded(bin, 0));
    let mut out = b"glTF".to_vec();
    for word in [2, 12 + 8 + json.len() + 8 + bin.len(), json.len()] {
        out.extend((word as u32).to_le_bytes());
    }
    out.extend(b"JSON");
    out.extend(&json);
    out.extend((bin.len() as u32).to_le_bytes());
    out.extend(b"BIN\0");
    out.extend(&bin);
    out
}

/// Binary data, and the buffer views and accessors over it as JSON, one of each a call.
#[derive(Default)]
pub struct Data {
    pub bytes: Vec<u8>,
    views: Vec<String>,
    accessors: Vec<String>,
}

impl Data {
    /// An accessor over `bytes`: glTF's component code, kind, count; gives its index.
    pub fn add(&mut self, bytes: &[u8], component: u32, kind: &str, count: usize, more: &str) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.views.push(format!(r#"{{"buffer":0,"byteOffset":{},"byteLength":{}}}"#, self.bytes.len(), bytes.len()));
        self.bytes.extend(bytes);
        let view = self.views.len() - 1;
        self.accessors.push(format!(r#"{{"bufferView":{view},"componentType":{component},"type":"{kind}","count":{count}{more}}}"#));
        self.accessors.len() - 1
    }

    /// An accessor without bytes.
    pub fn add_bare(&mut self, json: impl Into<String>) -> usize {
        self.accessors.push(json.into());
        self.accessors.len() - 1
    }

    /// Floats.
    pub fn floats(&mut self, kind: &str, width: usize, values: &[f32]) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.add(&bytes, 5126, kind, values.len() / width, "")
    }

    /// 16-bit indices.
    pub fn indices(&mut self, values: &[u16]) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.add(&bytes, 5123, "SCALAR", values.len(), "")
    }

    /// A whole .glb; `rest` are further members of the root, each with a comma before it.
    pub fn glb(&self, rest: &str) -> Vec<u8> {
        glb(&self.json(&format!(r#"{{"byteLength":{}}}"#, self.bytes.len()), rest), &self.bytes)
    }

    /// The JSON with this buffer record.
    pub fn json(&self, buffer: &str, rest: &str) -> String {
        let (views, accessors) = (self.views.join(","), self.accessors.join(","));
        format!(r#"{{"asset":{{"version":"2.0"}},"buffers":[{buffer}],"bufferViews":[{views}],"accessors":[{accessors}]{rest}}}"#)
    }
}

/// Corners of a unit square in z = 0, counterclockwise seen from +z.
pub const SQUARE: [f32; 12] = [0., 0., 0., 1., 0., 0., 1., 1., 0., 0., 1., 0.];
