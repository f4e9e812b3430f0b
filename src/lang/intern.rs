//! Names and string literals as small numbers.

use super::token::Symbol;
use std::collections::HashMap;
use std::sync::Arc;

/// All names and literals of one parse.
#[derive(Debug, Default)]
pub struct Interner {
    by_text: HashMap<Arc<[u8]>, Symbol>,
    texts: Vec<Arc<[u8]>>,
}

impl Interner {
    /// The number of a text.
    pub fn intern(&mut self, text: &[u8]) -> Symbol {
        if let Some(&s) = self.by_text.get(text) {
            return s;
        }
        let s = Symbol(self.texts.len() as u32);
        let text: Arc<[u8]> = text.into();
        self.texts.push(text.clone());
        self.by_text.insert(text, s);
        s
    }

    /// The bytes of a number that this interner gave out.
    pub fn bytes(&self, s: Symbol) -> &Arc<[u8]> {
        &self.texts[s.0 as usize]
    }

    /// The text of a name, for messages.
    pub fn text(&self, s: Symbol) -> String {
        String::from_utf8_lossy(self.bytes(s)).into_owned()
    }
}
