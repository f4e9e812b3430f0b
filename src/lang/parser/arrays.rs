//! Arrays: initialisers and subscripts. Source: spec/language.md, section 4.5.

use super::{PResult, Parser};
use crate::lang::token::Punct;
use crate::lang::value::{Array, Place, Value};
use std::sync::Arc;

/// Most elements of one array.
const MAX_ITEMS: usize = 1 << 26;

impl Parser<'_> {
    /// `array[n]... {...}` after the word.
    pub(super) fn parse_array(&mut self) -> PResult<Value> {
        let mut dims = Vec::new();
        self.closed_place(|p| {
            while p.at_punct(Punct::LBracket)? {
                p.next()?;
                let n = p.opened(|p| p.parse_float())? + 1e-10;
                if n < 1.0 {
                    return Err(p.error("Invalid dimension size for an array."));
                }
                dims.push(n as usize);
                p.expect(Punct::RBracket)?;
            }
            Ok(())
        })?;
        if dims.is_empty() || dims.len() > 5 {
            return Err(self.error(if dims.is_empty() { "Expected '[', array size missing." } else { "Too many dimensions for array." }));
        }
        let n = dims.iter().try_fold(1usize, |n, &d| n.checked_mul(d)).filter(|&n| n <= MAX_ITEMS);
        let Some(n) = n else { return Err(self.error("Dimension size for an array is too large.")) };
        self.charge(n.saturating_mul(size_of::<Option<Value>>()))?;
        let mut array = Array { dims, items: vec![None; n] };
        let has_items = self.closed_place(|p| p.at_punct(Punct::LBrace))?;
        if has_items {
            self.array_items(&mut array, 0, 0)?;
        }
        Ok(Value::Array(Arc::new(array)))
    }

    fn array_items(&mut self, array: &mut Array, dim: usize, base: usize) -> PResult<()> {
        self.closed_place(|p| p.open_block("{"))?;
        let stride: usize = array.dims[dim + 1..].iter().product();
        for i in 0..array.dims[dim] {
            let at = base + i * stride;
            if dim + 1 < array.dims.len() {
                self.nested(|p| p.array_items(array, dim + 1, at))?;
            } else {
                let value = self.array_item()?;
                if let Some(known) = array.items.iter().flatten().next()
                    && !known.same_kind(&value)
                {
                    let (a, b) = (known.kind_name(), value.kind_name());
                    return Err(self.error(format!("Attempted to redefine {a} as {b}.")));
                }
                array.items[at] = Some(value);
            }
            self.closed_place(|p| p.comma())?;
        }
        self.closed_place(|p| p.close_block("{"))
    }

    /// An element: its first token is taken where macros and directives are not seen.
    fn array_item(&mut self) -> PResult<Value> {
        self.closed_place(|p| {
            p.peek()?;
            Ok(())
        })?;
        if let Some(t) = self.ahead
            && self.is_special(t)
        {
            self.next_raw();
            self.last_span = t.span;
            let what = self.describe(t);
            return Err(self.error(format!("Expected 'array element', {what} found instead")));
        }
        let was = std::mem::replace(&mut self.closed_ops, true);
        let value = self.parse_rvalue();
        self.closed_ops = was;
        match value? {
            Some(v) => Ok(v),
            None => {
                let t = self.closed_place(|p| p.next())?;
                Err(self.expected_instead("array element", t))
            }
        }
    }

    /// `[i]...` as many as the array at `place` has dimensions (or fewer, for a whole row: refused); extends the place.
    pub(super) fn subscripts(&mut self, place: &mut Place) -> PResult<()> {
        let Some(Value::Array(a)) = self.symbols.value_at(place) else {
            return Err(self.error("Attempt to use subscripts on something that is no array."));
        };
        let dims = a.dims.clone();
        let mut flat = 0;
        for &d in &dims {
            self.expect(Punct::LBracket)?;
            let x = self.opened(|p| p.parse_float())?;
            let i = x + 1e-10;
            if i < 0.0 {
                return Err(self.error("Negative subscript"));
            }
            if !(i < d as f64) {
                return Err(self.error("Array subscript out of range"));
            }
            flat = flat * d + i as usize;
            self.closed_place(|p| p.expect(Punct::RBracket))?;
        }
        place.path.push(flat);
        Ok(())
    }
}
