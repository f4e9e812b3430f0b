//! Normals into words.

use super::texture_encoder::{NORMAL_STACK, Placed, TextureEncoder, bits};
use super::texture_layout::{NORMAL, NORMAL_KINDS, kind};
use crate::backend::BackendError;
use crate::compile::texture::{NormalCode, NormalIx, PatternCode};

impl TextureEncoder<'_> {
    /// The record of a normal.
    pub fn normal(&mut self, ix: NormalIx) -> Result<u32, BackendError> {
        Ok(self.placed_normal(ix)?.at)
    }

    fn placed_normal(&mut self, ix: NormalIx) -> Result<Placed, BackendError> {
        if let Some(known) = self.known_normals.get(&ix) {
            return Ok(*known);
        }
        let node = self.tables.normals[ix as usize];
        let code = self.tables.patterns[node.pattern as usize].code;
        let pattern = self.pattern(node.pattern)?;
        let mut stack = 0;
        let (name, entries) = match node.code {
            NormalCode::Pattern(range) => {
                if range.len > 0 {
                    self.feature("slope_maps");
                }
                let slopes = range.of(&self.tables.slope_entries);
                let words: Vec<u32> = slopes.iter().flat_map(|(at, [h, s])| [*at, *h, *s]).map(f32::to_bits).collect();
                (self.bump_kind(&code), [("ENTRIES_AT", self.put(words)), ("N_ENTRIES", range.len), ("WEIGHT", 0)])
            }
            NormalCode::Bump(image) => {
                self.feature("normal_bump");
                ("bump", [("ENTRIES_AT", self.image(image)), ("N_ENTRIES", 0), ("WEIGHT", 0)])
            }
            NormalCode::Map(range) | NormalCode::Average(range) => {
                self.feature("nested_normals");
                let entries = range.of(&self.tables.normal_entries);
                let mut words = Vec::new();
                for (at, normal) in entries {
                    let placed = self.placed_normal(*normal)?;
                    stack = stack.max(1 + placed.stack);
                    words.extend([at.to_bits(), placed.at]);
                }
                let weight: f32 = entries.iter().map(|e| e.0).sum();
                let name = if matches!(node.code, NormalCode::Map(_)) { "map" } else { "average" };
                (name, [("ENTRIES_AT", self.put(words)), ("N_ENTRIES", range.len), ("WEIGHT", weight.to_bits())])
            }
        };
        let own = [
            ("KIND", kind(NORMAL_KINDS, name)),
            ("PATTERN_AT", pattern.at),
            ("UV", u32::from(node.uv_mapping)),
            ("AMOUNT", bits(node.amount)),
            ("ACCURACY", bits(node.accuracy)),
            ("NO_BUMP_SCALE", u32::from(node.no_bump_scale)),
        ];
        let at = self.record(&NORMAL, &[&own[..], &entries[..]].concat());
        let placed = self.placed(NORMAL_STACK, at, stack)?;
        self.known_normals.insert(ix, placed);
        Ok(placed)
    }

    /// Whether a pattern bends normals by its own formula, or by samples of its value.
    fn bump_kind(&mut self, code: &PatternCode) -> &'static str {
        match code {
            PatternCode::Bumps | PatternCode::Dents | PatternCode::Wrinkles | PatternCode::Facets { .. } => {
                self.feature("vector_noise_normals");
                "own"
            }
            PatternCode::Quilted { .. } | PatternCode::Ripples | PatternCode::Waves => "own",
            _ => "slope",
        }
    }
}
