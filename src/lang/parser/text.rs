//! `text{}`: TrueType outlines laid out as POV-Ray lays them. Source: spec/objects.md, section 8.

use super::{PResult, Parser};
use crate::lang::keyword::Kw;
use crate::math::{DVec2, DVec3, Transform};
use crate::scene::shape::Glyph;
use crate::scene::{Object, Shape};
use std::sync::Arc;
use ttf_parser::{Face, GlyphId, OutlineBuilder, PlatformId, kern};

impl Parser<'_> {
    pub(super) fn parse_text_object(&mut self) -> PResult<Object> {
        let name = if self.accept_kw(Kw::Internal)? {
            let n = self.parse_int()?;
            match n {
                1 => "timrom.ttf",
                2 => "cyrvetic.ttf",
                3 => "crystal.ttf",
                _ => "povlogo.ttf",
            }
            .to_owned()
        } else {
            self.expect_kw(Kw::Ttf)?;
            self.parse_file_name()?
        };
        self.comma()?;
        let text = self.parse_string_units()?;
        self.comma()?;
        let depth = self.parse_float()?;
        self.comma()?;
        let offset = self.parse_vector3()?;
        let bytes = self.font(&name)?;
        let face = Face::parse(&bytes, 0).map_err(|e| self.error(format!("Cannot read font '{name}': {e}.")))?;
        let (glyphs, n_missing) = lay_out(&face, &text, offset, !self.utf8);
        if n_missing > 0 {
            self.warn(format!("{n_missing} characters of the text are not in font '{name}'."));
        }
        let mut o = Object::new(Shape::Text { glyphs, depth });
        o.apply_transform(&Transform::rotation_deg(DVec3::splat(0.001)));
        Ok(o)
    }

    fn font(&mut self, name: &str) -> PResult<Arc<[u8]>> {
        let Some(path) = self.world.find(name, &[".ttf", ".TTF"]) else {
            let mut e = self.error(format!("Cannot open font file '{name}'."));
            e.hints.push("POV-Ray's own fonts come with its include files: add their folder to the library path".into());
            return Err(e);
        };
        self.world.read(&path).map_err(|e| self.error(e.to_string()))
    }
}

/// The glyph of a 16-bit character; ASCII text prefers the Macintosh table, Unicode text the Unicode one.
fn glyph_of(face: &Face, c: u16, ascii: bool) -> Option<GlyphId> {
    let order: [PlatformId; 3] = if ascii {
        [PlatformId::Macintosh, PlatformId::Windows, PlatformId::Unicode]
    } else {
        [PlatformId::Unicode, PlatformId::Windows, PlatformId::Macintosh]
    };
    let tables = face.tables().cmap?.subtables;
    for platform in order {
        for t in tables {
            if t.platform_id == platform {
                // The first table of the best platform decides, whether it has the character or not.
                return t.glyph_index(u32::from(c));
            }
        }
    }
    None
}

/// Outlines of a text in units of the em, each at its place, and how many characters the font lacks.
fn lay_out(face: &Face, text: &[u16], offset: DVec3, ascii: bool) -> (Vec<Glyph>, usize) {
    let scale = 1.0 / f64::from(face.units_per_em());
    let (mut pen, mut out, mut n_missing) = (DVec3::ZERO, Vec::new(), 0);
    let mut last: Option<GlyphId> = None;
    for &c in text {
        let found = glyph_of(face, c, ascii);
        n_missing += usize::from(found.is_none());
        let id = found.unwrap_or(GlyphId(0));
        let x_min = face.glyph_bounding_box(id).map_or(0.0, |b| f64::from(b.x_min));
        let bearing = f64::from(face.glyph_hor_side_bearing(id).unwrap_or(0));
        let advance = f64::from(face.glyph_hor_advance(id).unwrap_or(0));
        let kern = last.map_or(0.0, |l| f64::from(kerning(face, l, id)));
        let mut glyph = Glyph { offset: pen, contours: outline(face, id, scale) };
        match last {
            // The first glyph loses its left bearing.
            None => {
                glyph.offset.x -= x_min * scale;
                pen.x += (advance - bearing) * scale;
            }
            Some(_) => {
                glyph.offset.x += (bearing - x_min + kern) * scale;
                pen.x += (advance + kern) * scale;
            }
        }
        out.push(glyph);
        pen += offset;
        last = Some(id);
    }
    (out, n_missing)
}

fn kerning(face: &Face, left: GlyphId, right: GlyphId) -> i16 {
    let Some(table) = face.tables().kern else { return 0 };
    // Fonts that POV-Ray brings have unsorted pairs, which a binary search would miss.
    let pair = |table: kern::Subtable| match table.format {
        kern::Format::Format0(pairs) => pairs.pairs.into_iter().find(|p| p.left() == left && p.right() == right).map(|p| p.value),
        _ => table.glyphs_kerning(left, right),
    };
    table.subtables.into_iter().filter(|t| t.horizontal).find_map(pair).unwrap_or(0)
}

fn outline(face: &Face, id: GlyphId, scale: f64) -> Vec<Vec<[DVec2; 3]>> {
    struct Pen {
        scale: f64,
        at: DVec2,
        start: DVec2,
        contour: Vec<[DVec2; 3]>,
        contours: Vec<Vec<[DVec2; 3]>>,
    }
    impl Pen {
        fn point(&self, x: f32, y: f32) -> DVec2 {
            DVec2::new(f64::from(x), f64::from(y)) * self.scale
        }
        fn finish(&mut self) {
            if self.at != self.start && !self.contour.is_empty() {
                self.contour.push([self.at, self.at, self.start]);
            }
            if !self.contour.is_empty() {
                self.contours.push(std::mem::take(&mut self.contour));
            }
        }
    }
    impl OutlineBuilder for Pen {
        fn move_to(&mut self, x: f32, y: f32) {
            self.finish();
            self.at = self.point(x, y);
            self.start = self.at;
        }
        fn line_to(&mut self, x: f32, y: f32) {
            let p = self.point(x, y);
            self.contour.push([self.at, self.at, p]);
            self.at = p;
        }
        fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
            let (c, p) = (self.point(x1, y1), self.point(x, y));
            self.contour.push([self.at, c, p]);
            self.at = p;
        }
        fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
            // Cubic outlines (OpenType CFF) become two quadratics; POV-Ray has TrueType alone.
            let (a, b, c, d) = (self.at, self.point(x1, y1), self.point(x2, y2), self.point(x, y));
            let middle = (a + 3.0 * b + 3.0 * c + d) / 8.0;
            self.contour.push([a, (a + 3.0 * b) / 4.0, middle]);
            self.contour.push([middle, (d + 3.0 * c) / 4.0, d]);
            self.at = d;
        }
        fn close(&mut self) {
            self.finish();
        }
    }
    let mut pen = Pen { scale, at: DVec2::ZERO, start: DVec2::ZERO, contour: Vec::new(), contours: Vec::new() };
    face.outline_glyph(id, &mut pen);
    pen.finish();
    pen.contours
}
