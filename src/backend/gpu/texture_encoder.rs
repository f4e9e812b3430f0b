//! Textures and pigments into words, parts first, each once. Normals are `texture_normals.rs`'s, patterns `texture_patterns.rs`'s,
//! pictures `texture_images.rs`'s.

use super::texture_functions::FunctionText;
use super::texture_images::ImageWords;
use super::texture_layout::{PIGMENT, PIGMENT_KINDS, Record, TEXTURE, TEXTURE_KINDS, kind};
use crate::backend::BackendError;
use crate::compile::NONE;
use crate::compile::texture::{NormalIx, PatternIx, PigmentCode, PigmentIx, Range, TextureIx, TextureNode, TextureTables};
use crate::math::{DMat3, Rgbft};
use std::collections::{BTreeSet, HashMap};

/// Most records that may stand inside each other; the shaders' stacks are as long as the scene needs, up to this.
const MAX_DEPTH: u32 = 24;

/// A record's place and the length of the stack that evaluating it takes.
#[derive(Clone, Copy)]
pub(super) struct Placed {
    pub at: u32,
    pub stack: u32,
}

/// The space that the entries of a patterned texture stand in, seen from the cover's: how normals get in, and out again.
#[derive(Clone, Copy)]
struct Space {
    inward: DMat3,
    outward: DMat3,
    /// Place of the matrices; 0 for the cover's own space.
    at: u32,
}

pub(super) struct TextureEncoder<'t> {
    pub tables: &'t TextureTables,
    /// Programs of the objects of object patterns.
    pub insides: &'t [[u32; 2]],
    pub words: Vec<u32>,
    pub images: ImageWords,
    pub functions: FunctionText,
    pub features: BTreeSet<String>,
    pub known_patterns: HashMap<PatternIx, Placed>,
    /// Place of the wave sources.
    pub wave_sources_at: u32,
    quick_colors: bool,
    known_pigments: HashMap<PigmentIx, Placed>,
    pub known_normals: HashMap<NormalIx, Placed>,
    known_textures: HashMap<(TextureIx, usize), Placed>,
    known_colors: HashMap<u32, u32>,
    spaces: Vec<Space>,
    known_spaces: HashMap<(usize, u32), usize>,
    stacks: [(&'static str, u32); 3],
}

const PIGMENT_STACK: usize = 0;
pub(super) const NORMAL_STACK: usize = 1;
const TEXTURE_STACK: usize = 2;

/// A number as the shaders read it.
pub(super) fn bits(v: f64) -> u32 {
    (v as f32).to_bits()
}

impl<'t> TextureEncoder<'t> {
    /// `words`: what stands in front of all records.
    pub fn new(tables: &'t TextureTables, insides: &'t [[u32; 2]], words: Vec<u32>, quick_colors: bool) -> Self {
        Self {
            tables,
            insides,
            words,
            images: ImageWords::default(),
            functions: FunctionText::default(),
            features: BTreeSet::new(),
            known_patterns: HashMap::new(),
            wave_sources_at: 0,
            quick_colors,
            known_pigments: HashMap::new(),
            known_normals: HashMap::new(),
            known_textures: HashMap::new(),
            known_colors: HashMap::new(),
            spaces: vec![Space { inward: DMat3::IDENTITY, outward: DMat3::IDENTITY, at: 0 }],
            known_spaces: HashMap::new(),
            stacks: [("PIGMENT", 1), ("NORMAL", 1), ("TEXTURE", 1)],
        }
    }

    /// Lengths of the shaders' stacks by name.
    pub fn stacks(&self) -> [(&'static str, u32); 3] {
        self.stacks
    }

    pub fn feature(&mut self, name: impl Into<String>) {
        self.features.insert(name.into());
    }

    /// Appends words; gives their place.
    pub fn put(&mut self, words: impl IntoIterator<Item = u32>) -> u32 {
        let at = self.words.len() as u32;
        self.words.extend(words);
        at
    }

    /// Two matrices for normals, inward and outward.
    pub fn put_matrices(&mut self, inward: DMat3, outward: DMat3) -> u32 {
        self.put(inward.to_cols_array().into_iter().chain(outward.to_cols_array()).map(bits))
    }

    pub fn record(&mut self, record: &Record, values: &[(&str, u32)]) -> u32 {
        self.put(record.words(values))
    }

    pub fn placed(&mut self, stack: usize, at: u32, length: u32) -> Result<Placed, BackendError> {
        if length > MAX_DEPTH {
            return Err(BackendError::Unsupported(format!("textures nested more than {MAX_DEPTH} deep")));
        }
        self.stacks[stack].1 = self.stacks[stack].1.max(length);
        Ok(Placed { at, stack: length })
    }

    /// Makes room for a pattern that is a pigment: its own work below that of the pigment.
    pub fn room_for_pattern(&mut self, pigment: Placed) {
        self.stacks[PIGMENT_STACK].1 = self.stacks[PIGMENT_STACK].1.max(pigment.stack + 1);
    }

    /// The record of a cover.
    pub fn cover(&mut self, ix: TextureIx) -> Result<u32, BackendError> {
        Ok(self.texture(ix, 0)?.at)
    }

    /// The record of a pigment.
    pub fn pigment(&mut self, ix: PigmentIx) -> Result<u32, BackendError> {
        Ok(self.placed_pigment(ix)?.at)
    }

    fn texture(&mut self, ix: TextureIx, space: usize) -> Result<Placed, BackendError> {
        if let Some(known) = self.known_textures.get(&(ix, space)) {
            return Ok(*known);
        }
        let tables = self.tables;
        let transform_at = self.spaces[space].at;
        let of_kind = |name: &str| ("KIND", kind(TEXTURE_KINDS, name));
        let placed = match tables.textures[ix as usize] {
            TextureNode::Layers { start, len } => {
                let mut words = Vec::new();
                for layer in &tables.layers[start as usize..][..len as usize] {
                    let quick = if self.quick_colors { tables.pigments[layer.pigment as usize].quick_color } else { None };
                    let pigment = match quick {
                        Some(c) => self.solid(&c),
                        None => self.pigment(layer.pigment)?,
                    };
                    let normal = if layer.normal == NONE { 0 } else { self.normal(layer.normal)? };
                    words.extend([pigment, normal, layer.finish]);
                }
                let entries_at = self.put(words);
                let fields = [of_kind("layers"), ("ENTRIES_AT", entries_at), ("N_ENTRIES", len), ("TRANSFORM_AT", transform_at)];
                let at = self.record(&TEXTURE, &fields);
                self.placed(TEXTURE_STACK, at, 1)?
            }
            TextureNode::Principled(material) => {
                let fields = [of_kind("principled"), ("ENTRIES_AT", material), ("TRANSFORM_AT", transform_at)];
                let at = self.record(&TEXTURE, &fields);
                self.placed(TEXTURE_STACK, at, 1)?
            }
            TextureNode::Map { pattern, start, len, uv_mapping } => {
                self.patterned_texture("map", pattern, Range { start, len }, uv_mapping, 0, space)?
            }
            TextureNode::Average { pattern, start, len, uv_mapping } => {
                self.patterned_texture("average", pattern, Range { start, len }, uv_mapping, 0, space)?
            }
            TextureNode::MaterialMap { pattern, image, start, len } => {
                self.feature("material_maps");
                let image = self.image(image);
                self.patterned_texture("material_map", pattern, Range { start, len }, false, image, space)?
            }
        };
        self.known_textures.insert((ix, space), placed);
        Ok(placed)
    }

    fn patterned_texture(
        &mut self,
        name: &str,
        pattern_ix: PatternIx,
        range: Range,
        uv_mapping: bool,
        image_at: u32,
        space: usize,
    ) -> Result<Placed, BackendError> {
        self.feature("nested_textures");
        let pattern = self.pattern(pattern_ix)?;
        let inner = self.space_inside(space, pattern_ix);
        let entries = range.of(&self.tables.texture_entries);
        let (mut words, mut stack) = (Vec::new(), 0);
        for (at, texture) in entries {
            let placed = self.texture(*texture, inner)?;
            stack = stack.max(placed.stack);
            words.extend([at.to_bits(), placed.at]);
        }
        let weight: f32 = entries.iter().map(|e| e.0).sum();
        let entries_at = self.put(words);
        let fields = [
            ("KIND", kind(TEXTURE_KINDS, name)),
            ("PATTERN_AT", pattern.at),
            ("ENTRIES_AT", entries_at),
            ("N_ENTRIES", range.len),
            ("UV", u32::from(uv_mapping)),
            ("WEIGHT", weight.to_bits()),
            ("IMAGE_AT", image_at),
        ];
        let at = self.record(&TEXTURE, &fields);
        self.placed(TEXTURE_STACK, at, stack + 1)
    }

    /// The space of the entries of a texture with this pattern.
    fn space_inside(&mut self, outer: usize, pattern: PatternIx) -> usize {
        let transform_ix = self.tables.patterns[pattern as usize].transform_ix;
        if transform_ix == NONE {
            return outer;
        }
        if let Some(known) = self.known_spaces.get(&(outer, transform_ix)) {
            return *known;
        }
        let t = &self.tables.transforms[transform_ix as usize];
        let Space { inward, outward, .. } = self.spaces[outer];
        let (inward, outward) = (t.forward.matrix3.transpose() * inward, outward * t.inverse.matrix3.transpose());
        let at = self.put_matrices(inward, outward);
        self.spaces.push(Space { inward, outward, at });
        self.known_spaces.insert((outer, transform_ix), self.spaces.len() - 1);
        self.spaces.len() - 1
    }

    fn solid(&mut self, c: &Rgbft) -> u32 {
        let at = self.record(&PIGMENT, &[("KIND", kind(PIGMENT_KINDS, "solid"))]);
        self.put(c.to_array().map(f32::to_bits));
        at
    }

    /// The record of a pigment, with what evaluating it takes.
    pub fn placed_pigment(&mut self, ix: PigmentIx) -> Result<Placed, BackendError> {
        if let Some(known) = self.known_pigments.get(&ix) {
            return Ok(*known);
        }
        let node = self.tables.pigments[ix as usize];
        let of_kind = |name: &str| ("KIND", kind(PIGMENT_KINDS, name));
        let pattern = match node.code {
            PigmentCode::Solid(_) => Placed { at: 0, stack: 0 },
            _ => self.pattern(node.pattern)?,
        };
        // A pattern that is a pigment is evaluated above its own work.
        let mut stack = 1 + pattern.stack;
        let common = [("PATTERN_AT", pattern.at), ("UV", u32::from(node.uv_mapping))];
        let at = match node.code {
            PigmentCode::Solid(c) => self.solid(&c),
            PigmentCode::Colors(range) => {
                let entries_at = self.colors(range);
                let fields = [of_kind("colors"), ("ENTRIES_AT", entries_at), ("N_ENTRIES", range.len)];
                self.record(&PIGMENT, &[&fields[..], &common[..]].concat())
            }
            PigmentCode::Image(image) => {
                self.feature("pigment_image");
                let image_at = self.image(image);
                self.record(&PIGMENT, &[&[of_kind("image"), ("ENTRIES_AT", image_at)], &common[..]].concat())
            }
            PigmentCode::Map(range) | PigmentCode::Average(range) => {
                self.feature("nested_pigments");
                let entries = range.of(&self.tables.pigment_entries);
                let mut words = Vec::new();
                for (at, pigment) in entries {
                    let placed = self.placed_pigment(*pigment)?;
                    stack = stack.max(1 + placed.stack);
                    words.extend([at.to_bits(), placed.at]);
                }
                let weight: f32 = entries.iter().map(|e| e.0).sum();
                let entries_at = self.put(words);
                let name = if matches!(node.code, PigmentCode::Map(_)) { "map" } else { "average" };
                let fields = [of_kind(name), ("ENTRIES_AT", entries_at), ("N_ENTRIES", range.len), ("WEIGHT", weight.to_bits())];
                self.record(&PIGMENT, &[&fields[..], &common[..]].concat())
            }
        };
        let placed = self.placed(PIGMENT_STACK, at, stack)?;
        self.known_pigments.insert(ix, placed);
        Ok(placed)
    }

    fn colors(&mut self, range: Range) -> u32 {
        if let Some(at) = self.known_colors.get(&range.start) {
            return *at;
        }
        let entries = range.of(&self.tables.color_entries);
        let words = entries.iter().flat_map(|(at, c)| [*at].into_iter().chain(c.to_array())).map(f32::to_bits);
        let at = self.put(words.collect::<Vec<_>>());
        self.known_colors.insert(range.start, at);
        at
    }
}
