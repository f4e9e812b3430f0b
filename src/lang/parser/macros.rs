//! Macros: definition and calls. Source: spec/language.md, section 4.4.

use super::{Frame, FrameKind, PResult, Parser};
use crate::diag::Span;
use crate::lang::token::{Punct, TokenKind};
use crate::lang::value::{Binding, Entry, Macro, Place, Scope, Value};
use std::sync::Arc;

/// Most parameters of a macro or function.
pub(super) const MAX_PARAMS: usize = 56;

impl Parser<'_> {
    pub(super) fn define_macro(&mut self) -> PResult<()> {
        let (name, span, params) = self.closed_place(|p| {
            let t = p.next()?;
            let TokenKind::Ident(name) = t.kind else { return Err(p.expected_instead("identifier", t)) };
            p.expect(Punct::LParen)?;
            let mut params = Vec::new();
            while !p.at_punct(Punct::RParen)? {
                let q = p.next()?;
                let TokenKind::Ident(param) = q.kind else { return Err(p.expected_instead("identifier", q)) };
                params.push(param);
                p.comma()?;
            }
            p.expect(Punct::RParen)?;
            Ok((name, t.span, params))
        })?;
        if params.len() > MAX_PARAMS {
            return Err(self.error(format!("Too many parameters (more than {MAX_PARAMS}).")));
        }
        let (start, tokens) = {
            let f = self.frames.last().expect("a frame");
            (f.at, f.tokens.clone())
        };
        let end = self.skip_macro_body()?;
        let value = Value::Macro(Arc::new(Macro { name, params, tokens, body: start..end, span }));
        // A macro lives where #declare would put a new name; a second definition replaces the first.
        let scope = match self.symbols.find(name) {
            Some((scope, entry)) if matches!(entry.binding, Binding::Value(Value::Macro(_))) => scope,
            Some(_) => return Err(self.error(format!("Attempted to redefine identifier '{}' as macro.", self.interner.text(name)))),
            None => 0,
        };
        self.symbols.set(scope, name, value);
        Ok(())
    }

    /// Reads the arguments of a call whose name was taken, and enters the macro's body.
    pub(super) fn call_macro(&mut self, m: &Arc<Macro>, call: Span) -> PResult<()> {
        self.step()?;
        let name = self.interner.text(m.name);
        let t = self.closed_place(|p| p.next())?;
        if t.kind != TokenKind::Punct(Punct::LParen) {
            return Err(self.expected_instead("( after macro name", t));
        }
        let mut bindings = Vec::with_capacity(m.params.len());
        let was = std::mem::replace(&mut self.closed_ops, true);
        let result = self.macro_arguments(m, &name, &mut bindings);
        self.closed_ops = was;
        result?;
        self.expect_closing()?;
        self.check_scopes()?;
        let mut scope = Scope::default();
        for (&param, (binding, nesting)) in m.params.iter().zip(bindings) {
            scope.insert(param, Entry { binding, deprecated: None, nesting });
        }
        self.symbols.scopes.push(scope);
        let n_conds = self.conds.len();
        self.frames.push(Frame {
            kind: FrameKind::Macro(m.name),
            tokens: m.tokens.clone(),
            at: m.body.start,
            end: m.body.end,
            n_conds,
            from: Some(call),
        });
        Ok(())
    }

    fn macro_arguments(&mut self, m: &Macro, name: &str, bindings: &mut Vec<(Binding, u32)>) -> PResult<()> {
        while bindings.len() < m.params.len() {
            if self.closed_place(|p| p.at_punct(Punct::RParen))? {
                return Err(self.error(format!(
                    "Expected {} parameters but only {} found in call of macro '{name}'.",
                    m.params.len(),
                    bindings.len()
                )));
            }
            bindings.push(self.macro_argument()?);
            self.closed_place(|p| p.comma())?;
        }
        Ok(())
    }

    /// One argument: a lone name is passed by reference, anything else by value.
    fn macro_argument(&mut self) -> PResult<(Binding, u32)> {
        let n_conds = self.conds.len();
        let t = self.opened_start()?;
        if let TokenKind::Ident(name) = t.kind {
            let ends = self.after_reference();
            if let Some(mut place) = self.symbols.resolve(name) {
                let by_value = self.symbols.value_at(&place).is_some_and(Value::is_passed_by_value);
                if ends.is_some() && !by_value {
                    self.next()?;
                    while self.closed_place(|p| p.at_punct(Punct::LBracket))? {
                        self.opened(|p| p.subscripts(&mut place))?;
                    }
                    if self.symbols.value_at(&place).is_none() {
                        return Err(self.error("Cannot pass uninitialized array element as macro parameter."));
                    }
                    return Ok((Binding::Alias(place), 0));
                }
            } else if ends.is_some() {
                self.next()?;
                let text = self.interner.text(name);
                return Err(self.error(format!("Cannot pass uninitialized identifier '{text}' as macro parameter to macro.")));
            }
        }
        let (value, nesting) = self.measured(|p| p.parse_rvalue())?;
        match value {
            Some(value) => {
                if !matches!(value, Value::Num(_)) {
                    self.end_value_conditionals(n_conds)?;
                }
                Ok((Binding::Value(value), nesting))
            }
            None => self.expected("macro parameter"),
        }
    }

    /// Looks past a name just peeked, and its subscripts, in the text: `Some` when an argument ends there.
    fn after_reference(&self) -> Option<()> {
        let f = self.frames.last()?;
        let mut at = f.at;
        loop {
            let t = f.tokens.get(at).filter(|_| at < f.end)?;
            match t.kind {
                TokenKind::Punct(Punct::Comma | Punct::RParen) => return Some(()),
                TokenKind::Punct(Punct::LBracket) => {
                    let mut depth = 0usize;
                    loop {
                        match f.tokens.get(at).filter(|_| at < f.end)?.kind {
                            TokenKind::Punct(Punct::LBracket) => depth += 1,
                            TokenKind::Punct(Punct::RBracket) => depth -= 1,
                            _ => {}
                        }
                        at += 1;
                        if depth == 0 {
                            break;
                        }
                    }
                }
                _ => return None,
            }
        }
    }

    /// The place and value of a name that was taken, with the subscripts that follow.
    pub(super) fn take_place(&mut self, name: crate::lang::token::Symbol) -> PResult<Option<Place>> {
        let Some(mut place) = self.symbols.resolve(name) else { return Ok(None) };
        while matches!(self.symbols.value_at(&place), Some(Value::Array(_))) && self.peek_op()?.kind == TokenKind::Punct(Punct::LBracket) {
            self.opened(|p| p.subscripts(&mut place))?;
        }
        Ok(Some(place))
    }
}
