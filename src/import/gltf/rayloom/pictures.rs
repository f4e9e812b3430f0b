//! Pictures of the extension: glTF's own images and those in buffers that glTF has no type for, each decoded once and only if it is used.

use super::super::super::{ImportError, picture};
use super::super::{Document, material};
use super::record::Record;
use crate::diag::Sink;
use crate::math::Vec3;
use crate::scene::environment::FloatImage;
use crate::scene::material::{MaterialImage, Texels};
use std::sync::Arc;

/// Where a picture's bytes are.
#[derive(Clone, Copy)]
enum Source {
    Image(usize),
    View(usize),
}

struct Entry {
    name: String,
    source: Source,
    color_space: String,
    premultiplied: bool,
    ignores_alpha: bool,
    decoded: Option<Option<Arc<MaterialImage>>>,
}

/// A picture as a node gets it.
#[derive(Clone)]
pub(super) struct Decoded {
    pub image: Arc<MaterialImage>,
    /// Colours are sRGB-encoded.
    pub srgb: bool,
    /// Colours are multiplied by alpha.
    pub premultiplied: bool,
    /// Alpha is 1 everywhere, whatever the file says.
    pub ignores_alpha: bool,
}

/// All pictures of the file.
pub(super) struct Pictures<'a> {
    doc: &'a Document<'a>,
    entries: Vec<Entry>,
}

impl<'a> Pictures<'a> {
    /// Reads the records; decodes nothing yet.
    pub fn new(doc: &'a Document<'a>, records: Vec<Record>) -> Result<Self, ImportError> {
        let entry = |r: Record| -> Result<Entry, ImportError> {
            let image = r.index("source", doc.root.images.len(), "image")?;
            let view = r.index("bufferView", doc.root.buffer_views.len(), "buffer view")?;
            r.text("mimeType")?;
            let source = match (image, view) {
                (Some(ix), _) => Source::Image(ix),
                (None, Some(ix)) => Source::View(ix),
                (None, None) => return Err(r.wrong("source", "there is neither it nor a bufferView")),
            };
            let out = Entry {
                name: r.text("name")?.unwrap_or_default().to_owned(),
                source,
                color_space: r.text("colorSpace")?.unwrap_or("srgb").to_owned(),
                premultiplied: r.text("alpha")? == Some("premultiplied"),
                ignores_alpha: r.text("alpha")? == Some("none"),
                decoded: None,
            };
            r.finish()?;
            Ok(out)
        };
        Ok(Self { doc, entries: records.into_iter().map(entry).collect::<Result<_, _>>()? })
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.entries.len()
    }

    /// Picture `ix`; `None` where it cannot be read, which is told.
    pub fn decoded(&mut self, ix: usize, sink: &mut Sink) -> Option<Decoded> {
        let doc = self.doc;
        let e = &mut self.entries[ix];
        if e.decoded.is_none() {
            let bytes = match e.source {
                Source::Image(ix) => material::image_bytes(doc, ix),
                Source::View(ix) => {
                    doc.view(ix, || format!("picture '{}'", e.name)).map(<[u8]>::to_vec).map_err(|e: ImportError| e.to_string())
                }
            };
            let image = bytes.and_then(|b| picture::decode(&b)).map(Arc::new);
            if let Err(why) = &image {
                sink.note_once(&format!("rayloom: picture {ix}"), None, format!("the picture '{}' is left out: {why}", e.name));
            }
            e.decoded = Some(image.ok());
        }
        let image = e.decoded.clone().flatten()?;
        let is_float = matches!(image.texels, Texels::RgbaF32(_));
        let srgb = match e.color_space.as_str() {
            "srgb" => !is_float,
            "linear" | "nonColor" => false,
            other => {
                let taken = if is_float { "linear" } else { "sRGB" };
                let message = format!("the colour space '{other}' of the picture '{}' is taken as {taken}", e.name);
                sink.note_once(&format!("rayloom: colour space {other}"), None, message);
                !is_float
            }
        };
        Some(Decoded { image, srgb, premultiplied: e.premultiplied, ignores_alpha: e.ignores_alpha })
    }

    /// Picture `ix` as linear colours for an environment.
    pub fn linear(&mut self, ix: usize, sink: &mut Sink) -> Option<FloatImage> {
        let d = self.decoded(ix, sink)?;
        let decode = |c: [f32; 3]| Vec3::from_array(if d.srgb { c.map(picture::linear_from_srgb) } else { c });
        let finite = |c: Vec3| if c.is_finite() { c } else { Vec3::ZERO };
        let texels = match &d.image.texels {
            Texels::Rgba8(list) => list.iter().map(|c| decode([0, 1, 2].map(|k| f32::from(c[k]) / 255.0))).collect(),
            Texels::Rgba16(list) => list.iter().map(|c| decode([0, 1, 2].map(|k| f32::from(c[k]) / 65535.0))).collect(),
            Texels::RgbaF32(list) => list.iter().map(|c| finite(Vec3::new(c[0], c[1], c[2]))).collect(),
        };
        Some(FloatImage { width: d.image.width, height: d.image.height, texels })
    }
}
