//! Pigments and patterns that user functions ask about, as WGSL functions of their own: shaders may not recurse, so those of pigments and
//! functions cannot go through the loop that evaluates pigments, which calls functions itself. Twin: `call_function_all` in src/kernel/function.rs.

use super::texture_encoder::TextureEncoder;
use crate::backend::BackendError;
use crate::compile::texture::{PatternCode, PatternIx, PigmentCode, PigmentIx};
use std::fmt::Write;

impl TextureEncoder<'_> {
    /// An expression for the value of a pattern at the point `point` (WGSL, warped).
    fn value_in_function(&mut self, pattern: PatternIx, point: &str) -> Result<String, BackendError> {
        let code = self.tables.patterns[pattern as usize].code;
        let at = self.pattern(pattern)?.at;
        Ok(match code {
            PatternCode::Function(ix) => {
                let args = ["x", "y", "z"].map(|axis| format!("f32({point}.{axis})")).to_vec();
                format!("shaped({at}u, above_one({}[0]))", self.user_call(ix, args)?)
            }
            PatternCode::Pigment(ix) => format!("shaped({at}u, grey_of({}))", self.pigment_call(ix, point)?),
            _ => format!("free_value({at}u, {point})"),
        })
    }

    /// The body of a function that is a pattern, of the point `(a0, a1, a2)`.
    pub fn pattern_function(&mut self, pattern: PatternIx) -> Result<String, BackendError> {
        let value = self.value_in_function(pattern, "q")?;
        let at = self.pattern(pattern)?.at;
        Ok(format!("    let q = warp_point({at}u, real3(vec3f(a0, a1, a2)));\n    return array<f32, 5>({value}, 0.0, 0.0, 0.0, 0.0);\n"))
    }

    /// The body of a function that is a pigment.
    pub fn pigment_function(&mut self, pigment: PigmentIx) -> Result<String, BackendError> {
        Ok(format!("    return numbers_of({});\n", self.pigment_call(pigment, "real3(vec3f(a0, a1, a2))")?))
    }

    /// A call that gives a pigment's `PigmentColor` at `point`; what it calls is written before.
    fn pigment_call(&mut self, ix: PigmentIx, point: &str) -> Result<String, BackendError> {
        let call = format!("pigment_{ix}({point})");
        if !self.functions.know_pigment(ix) {
            return Ok(call);
        }
        let node = self.tables.pigments[ix as usize];
        let at = self.pigment(ix)?;
        let mut text = String::new();
        if matches!(node.code, PigmentCode::Solid(_)) {
            text += &format!("    return PigmentColor(color_of_words({at}u + constants::PIGMENT_LEN), true);\n");
        } else {
            let start = if node.uv_mapping { "real3(vec3f(0.0))" } else { "p" };
            text += &format!("    let q = warp_point({}u, {start});\n", self.pattern(node.pattern)?.at);
        }
        match node.code {
            PigmentCode::Solid(_) => {}
            PigmentCode::Image(_) => text += &format!("    return plain_color({at}u, vec3f(q), 0.0);\n"),
            PigmentCode::Colors(_) => {
                text += &format!("    return plain_color({at}u, vec3f(q), {});\n", self.value_in_function(node.pattern, "q")?);
            }
            PigmentCode::Map(range) | PigmentCode::Average(range) => {
                let is_map = matches!(node.code, PigmentCode::Map(_));
                let value = if is_map { self.value_in_function(node.pattern, "q")? } else { "0.0".to_owned() };
                // Each entry is called at one place; a map asks for one or two of them.
                let mut cases = String::new();
                let entries: Vec<PigmentIx> = range.of(&self.tables.pigment_entries).iter().map(|e| e.1).collect();
                for (k, entry) in entries.into_iter().enumerate() {
                    let call = self.pigment_call(entry, "q")?;
                    writeln!(cases, "            case {k}u: {{ found = {call}; }}").expect("strings take text");
                }
                let kind = if is_map { "entries_of_map" } else { "entries_of_average" };
                write!(
                    text,
                    "    let wanted = {kind}({at}u, {value});\n    var sum = PigmentColor(Rgbft(vec3f(0.0), 0.0, 0.0), true);\n    \
                     for (var k = wanted.first; k < wanted.end; k++) {{\n        var found = sum;\n        switch k {{\n{cases}            \
                     default: {{}}\n        }}\n        sum = sum_with(sum, found, {at}u, wanted, k);\n    }}\n    return sum;\n"
                )
                .expect("strings take text");
            }
        }
        self.functions.add(&format!("fn pigment_{ix}(p: real3) -> PigmentColor {{\n{text}}}\n\n"));
        Ok(call)
    }
}
