//! Inputs of closures as words: numbers, colours, pictures, normals. Twin: `shaders/path/inputs.wesl`.

use super::super::buffers::{append, bits};
use crate::backend::BackendError;
use crate::scene::input::{Channel, Color, NormalInput, Picture, Scalar, TangentInput};
use crate::scene::material::{MaterialImage, Texels, Wrap};
use std::collections::{BTreeSet, HashMap};
use std::sync::Arc;

/// Words of a picture as an input reads it: name and length.
const LOOK: &[(&str, u32)] = &[
    ("TEXELS_AT", 1),
    ("WIDTH", 1),
    ("HEIGHT", 1),
    ("FORMAT", 1),
    ("FLAGS", 1),
    ("WRAP_U", 1),
    ("WRAP_V", 1),
    ("UV_TRANSFORM", 6),
    ("UV_SET", 1),
];
const LOOK_SRGB: u32 = 1;
const LOOK_LINEAR: u32 = 2;
const LOOK_LATE: u32 = 4;
const LOOK_PREMULTIPLIED: u32 = 8;
const EDGES: [&str; 4] = ["EDGE_REPEAT", "EDGE_MIRROR", "EDGE_CLAMP", "EDGE_CLIP"];
/// Words of a bump: height, strength, distance, inverted.
const BUMP_WORDS: u32 = 7;
/// The corners' colours multiply.
const CORNER_COLORS: u32 = 1 << 31;

/// Names and numbers for the shaders.
pub(super) fn input_constants() -> Vec<(String, u32)> {
    let mut at = 0;
    let places = LOOK.iter().map(|(name, len)| {
        at += len;
        (format!("LOOK_{name}"), at - len)
    });
    let flags = [
        ("BUMP_WORDS", BUMP_WORDS),
        ("LOOK_SRGB", LOOK_SRGB),
        ("LOOK_LINEAR", LOOK_LINEAR),
        ("LOOK_LATE", LOOK_LATE),
        ("LOOK_PREMULTIPLIED", LOOK_PREMULTIPLIED),
    ];
    let edges = (0..).zip(EDGES).map(|(k, n)| (n.to_owned(), k));
    places.chain(flags.map(|(n, v)| (n.to_owned(), v))).chain(edges).collect()
}

/// Words of materials and texels, growing.
#[derive(Default)]
pub(super) struct Encoder {
    pub words: Vec<u32>,
    pub texels: Vec<u32>,
    /// Features that shaders need.
    pub features: BTreeSet<&'static str>,
    /// Sets of texture coordinates beyond the first that are looked at.
    pub more_uvs: u32,
    known: HashMap<*const MaterialImage, u32>,
}

/// What is not done, by name.
pub(super) fn refused<T>(what: &str) -> Result<T, BackendError> {
    Err(BackendError::Unsupported(format!("path tracing of {what}")))
}

impl Encoder {
    /// Two words: the number, and what multiplies it.
    pub fn scalar(&mut self, s: &Scalar) -> Result<[u32; 2], BackendError> {
        let Some((picture, channel)) = &s.picture else { return Ok([(s.factor + s.offset).to_bits(), 0]) };
        let picture = self.picture(picture)?;
        let channel = match channel {
            Channel::Red => 0,
            Channel::Green => 1,
            Channel::Blue => 2,
            Channel::Alpha => 3,
            Channel::Luminance => 4,
        };
        Ok([s.factor.to_bits(), append(&mut self.words, [s.offset.to_bits(), picture, channel])])
    }

    /// Four words: the colour, and what multiplies it.
    pub fn color(&mut self, c: &Color) -> Result<[u32; 4], BackendError> {
        let [r, g, b] = bits(c.factor.to_array());
        let mut more = match &c.picture {
            Some(p) => self.picture(p)?,
            None => 0,
        };
        if c.vertex_color {
            self.features.insert("corner_colors");
            more |= CORNER_COLORS;
        }
        Ok([r, g, b, more])
    }

    /// Place of a normal's words, 0 for none.
    pub fn normal(&mut self, n: Option<&NormalInput>) -> Result<u32, BackendError> {
        let Some(n) = n else { return Ok(0) };
        self.features.insert("bent");
        let w = match n {
            NormalInput::Map { picture, strength, scale_xy } => {
                let picture = self.picture(picture)?;
                let [a, b] = self.scalar(strength)?;
                vec![0, picture, a, b, u32::from(*scale_xy)]
            }
            NormalInput::Bump { .. } => {
                self.features.extend(["bumps", "texels"]);
                // From the top down, the map below them all last.
                let (mut bumps, mut below) = (Vec::new(), Some(n));
                while let Some(NormalInput::Bump { height, strength, distance, invert, base }) = below {
                    let (h, s, d) = (self.scalar(height)?, self.scalar(strength)?, self.scalar(distance)?);
                    bumps.push([h[0], h[1], s[0], s[1], d[0], d[1], u32::from(*invert)]);
                    below = base.as_deref();
                }
                let map = self.normal(below)?;
                [1, map, bumps.len() as u32].into_iter().chain(bumps.iter().rev().flatten().copied()).collect()
            }
        };
        Ok(append(&mut self.words, w))
    }

    /// Place of a tangent's words, those of a look at plain coordinates; 0 for the object's.
    pub fn tangent(&mut self, t: TangentInput) -> u32 {
        let TangentInput::Uv(set) = t else { return 0 };
        self.looks_at(set);
        self.features.extend(["bent", "uv_tangents"]);
        let mut w = vec![0; 7];
        w.extend([1.0f32, 0.0, 0.0, 0.0, 1.0, 0.0].map(f32::to_bits));
        w.push(set);
        append(&mut self.words, w)
    }

    fn looks_at(&mut self, uv_set: u32) {
        if uv_set > 0 {
            self.features.insert("more_uvs");
            self.more_uvs = self.more_uvs.max(uv_set);
        }
        self.features.extend(["texels", "uv"]);
    }

    fn picture(&mut self, p: &Picture) -> Result<u32, BackendError> {
        self.looks_at(p.uv_set);
        let t = &p.texture;
        let texels = &mut self.texels;
        let texels_at = *self.known.entry(Arc::as_ptr(&t.image)).or_insert_with(|| {
            let at = texels.len() as u32;
            let pair = |a: u16, b: u16| u32::from(a) | u32::from(b) << 16;
            match &t.image.texels {
                Texels::Rgba8(list) => texels.extend(list.iter().map(|c| u32::from_le_bytes(*c))),
                Texels::Rgba16(list) => texels.extend(list.iter().flat_map(|c| [pair(c[0], c[1]), pair(c[2], c[3])])),
                Texels::RgbaF32(list) => texels.extend(list.iter().flatten().map(|v| v.to_bits())),
            }
            at
        });
        let is_float = matches!(t.image.texels, Texels::RgbaF32(_));
        let format = match &t.image.texels {
            Texels::Rgba8(_) => 0,
            Texels::Rgba16(_) => 1,
            Texels::RgbaF32(_) => 2,
        };
        let flag = |holds: bool, bit: u32| if holds { bit } else { 0 };
        let srgb = t.srgb && !is_float;
        let flags = flag(srgb, LOOK_SRGB)
            | flag(t.linear, LOOK_LINEAR)
            | flag(srgb && p.filter_encoded, LOOK_LATE)
            | flag(p.premultiplied, LOOK_PREMULTIPLIED);
        let edge = |w: Wrap| match w {
            Wrap::Repeat => 0,
            Wrap::Mirror => 1,
            Wrap::Clamp => 2,
            Wrap::Clip => 3,
        };
        let mut w = vec![texels_at, t.image.width, t.image.height, format, flags];
        w.extend(t.wrap.map(edge));
        w.extend(t.uv_transform.as_flattened().iter().map(|v| v.to_bits()));
        w.push(p.uv_set);
        Ok(append(&mut self.words, w))
    }
}
