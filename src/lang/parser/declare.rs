//! `#declare`, `#local`, `#undef` and the values that they take. Source: spec/language.md, section 4.2.

use super::{PResult, Parser};
use crate::lang::keyword::Kw;
use crate::lang::token::{Punct, Symbol, TokenKind};
use crate::lang::value::{Binding, Deprecated, Entry, Place, Value};
use std::sync::Arc;

impl Parser<'_> {
    pub(super) fn declare(&mut self, local: bool) -> PResult<()> {
        let (name, span, deprecated) = self.closed_place(|p| {
            let mut deprecated = None;
            if p.at_kw(Kw::Deprecated)? {
                p.next()?;
                let once = p.accept_kw(Kw::Once)?;
                let message = if matches!(p.peek()?.kind, TokenKind::Str(_)) { Some(p.opened(|p| p.parse_text())?) } else { None };
                deprecated = Some((once, message));
            }
            let t = p.next()?;
            match t.kind {
                TokenKind::Ident(name) => Ok((name, t.span, deprecated)),
                _ => Err(p.expected_instead("undeclared identifier", t)),
            }
        })?;
        if matches!(self.symbols.value(name), Some(Value::Macro(_))) && !local {
            return Err(self.error("Expected 'undeclared identifier', macro identifier found instead"));
        }
        // #local of a name in the innermost scope (a parameter too) writes through it; #declare finds the innermost visible one.
        let innermost = self.symbols.scopes.len() - 1;
        let known = if local {
            self.symbols.scopes[innermost].contains_key(&name).then(|| self.symbols.resolve(name)).flatten()
        } else {
            self.symbols.resolve(name)
        };
        let mut place = known.clone().unwrap_or(Place { scope: if local { innermost } else { 0 }, name, path: Vec::new() });
        self.closed_place(|p| {
            while p.at_punct(Punct::LBracket)? {
                if known.is_none() {
                    // The name is read from outer scopes for its element, as #local A[0] = ... does.
                    match p.symbols.resolve(name) {
                        Some(outer) if place.path.is_empty() => place = outer,
                        _ => {
                            return Err(
                                p.expected_instead("array identifier", crate::lang::token::Token { kind: TokenKind::Ident(name), span })
                            );
                        }
                    }
                }
                p.subscripts(&mut place)?;
            }
            p.expect(Punct::Eq)
        })?;
        if place.path.is_empty() && matches!(self.symbols.value_at(&place), Some(Value::Function(_))) {
            return Err(self.error("Redeclaring functions is not allowed - #undef the function first!"));
        }
        let was = std::mem::replace(&mut self.closed_ops, true);
        let value = self.measured(|p| p.parse_rvalue());
        self.closed_ops = was;
        let (value, nesting) = value?;
        let Some(mut value) = value else { return self.bad_rvalue() };
        if let Value::Function(f) = &mut value {
            Arc::make_mut(f).name = self.interner.text(name);
        }
        let needs_semicolon = matches!(value, Value::Num(_));
        self.charge_copy(&place)?;
        self.assign(&place, name, value)?;
        self.symbols.set_nesting(&place, nesting);
        if let Some((once, message)) = deprecated
            && let Some(entry) = self.symbols.scopes[place.scope].get_mut(&place.name)
        {
            let message = message.unwrap_or_else(|| format!("Identifier '{}' was declared deprecated.", self.interner.text(name)));
            entry.deprecated = Some(Arc::new(Deprecated { once, message }));
        }
        self.end_of_declaration(needs_semicolon)
    }

    /// Reads a value, and tells how deep it is nested: 0 for numbers and strings.
    pub(super) fn measured(&mut self, f: impl FnOnce(&mut Self) -> PResult<Option<Value>>) -> PResult<(Option<Value>, u32)> {
        let outer = std::mem::take(&mut self.reach);
        let value = f(self)?;
        let nesting = std::mem::replace(&mut self.reach, outer);
        if nesting > super::MAX_REACH {
            return Err(self.error(format!("Values are made of each other too often (more than {} times).", super::MAX_REACH)));
        }
        let is_flat = matches!(value, Some(Value::Num(_) | Value::Str(_)));
        Ok((value, if is_flat { 0 } else { nesting }))
    }

    /// An array that others hold as well is copied when an element is assigned.
    fn charge_copy(&mut self, place: &Place) -> PResult<()> {
        if let Some((_, parents)) = place.path.split_last()
            && let Some(Value::Array(a)) = self.symbols.value_at(&Place { path: parents.to_vec(), ..place.clone() })
            && Arc::strong_count(a) > 1
        {
            let bytes = a.items.len() * size_of::<Option<Value>>();
            return self.charge(bytes);
        }
        Ok(())
    }

    fn bad_rvalue<T>(&mut self) -> PResult<T> {
        let t = self.closed_place(|p| p.next())?;
        if let TokenKind::Ident(s) = t.kind
            && self.symbols.value(s).is_none()
        {
            return Err(self.error(format!("Cannot assign uninitialized identifier '{}'.", self.interner.text(s))));
        }
        Err(self.expected_instead("RValue to declare", t))
    }

    fn end_of_declaration(&mut self, needed: bool) -> PResult<()> {
        let found = self.closed_place(|p| {
            let yes = p.at_punct(Punct::Semicolon)?;
            if yes {
                p.next()?;
                // One more is swallowed.
                p.accept(Punct::Semicolon)?;
            }
            Ok(yes)
        })?;
        if !found && needed && self.version >= 350 {
            self.closed_place(|p| p.next())?;
            return Err(self.error("All #declares of float, vector, and color require semi-colon ';' at end."));
        }
        Ok(())
    }

    pub(super) fn assign(&mut self, place: &Place, name: Symbol, value: Value) -> PResult<()> {
        if place.scope >= self.symbols.scopes.len() {
            // The macro or file that declares the name ended before the value: POV-Ray takes it (measured), and nobody can see it.
            return Ok(());
        }
        if place.path.is_empty() && !self.symbols.scopes[place.scope].contains_key(&place.name) {
            self.symbols.scopes[place.scope].insert(name, Entry { binding: Binding::Value(value), deprecated: None, nesting: 0 });
            return Ok(());
        }
        let kind = value.kind_name();
        self.symbols.store(place, value).map_err(|known| self.error(format!("Attempted to redefine {} as {kind}.", known.kind_name())))
    }

    pub(super) fn undef(&mut self) -> PResult<()> {
        self.closed_place(|p| {
            let t = p.next()?;
            let TokenKind::Ident(name) = t.kind else { return Err(p.expected_instead("identifier", t)) };
            if p.at_punct(Punct::LBracket)? {
                if let Some(mut place) = p.symbols.resolve(name) {
                    p.subscripts(&mut place)?;
                    p.symbols.clear_element(&place);
                }
            } else if let Some((scope, _)) = p.symbols.find(name) {
                p.symbols.scopes[scope].remove(&name);
            } else {
                let text = p.interner.text(name);
                p.warn(format!("Attempt to undef unknown identifier '{text}'."));
            }
            p.accept(Punct::Semicolon)?;
            Ok(())
        })
    }

    /// A value of any kind; `None` when the next token starts none.
    pub(super) fn parse_rvalue(&mut self) -> PResult<Option<Value>> {
        let t = self.opened_start()?;
        match t.kind {
            TokenKind::Ident(name) => {
                self.note_reach(name);
                let Some(value) = self.symbols.value(name) else { return Ok(None) };
                match value {
                    Value::Num(_) | Value::Macro(_) => {}
                    Value::Array(_) => return self.array_rvalue(name),
                    Value::Function(_) | Value::Spline(_) => {
                        let f = value.clone();
                        if self.call_follows() {
                            return self.parse_number_value().map(Some);
                        }
                        self.next()?;
                        return Ok(Some(f));
                    }
                    Value::Str(_) => return Ok(Some(Value::Str(self.parse_string_units()?))),
                    Value::Texture(_) => return self.opened(|p| p.parse_declared_textures()).map(Some),
                    Value::File(_) => return Ok(None),
                    _ => {
                        let value = value.clone();
                        self.note_use(name);
                        self.next()?;
                        return Ok(Some(value));
                    }
                }
                self.parse_number_value().map(Some)
            }
            TokenKind::Str(_) => Ok(Some(Value::Str(self.parse_string_units()?))),
            TokenKind::Float(_) => self.parse_number_value().map(Some),
            TokenKind::Punct(Punct::Lt | Punct::LParen | Punct::Plus | Punct::Minus | Punct::Not) => self.parse_number_value().map(Some),
            TokenKind::Kw(k) => {
                if super::string::is_string_word(k) {
                    return Ok(Some(Value::Str(self.parse_string_units()?)));
                }
                match super::expr::word_class(k) {
                    super::expr::WordClass::Float | super::expr::WordClass::Vector => self.parse_number_value().map(Some),
                    super::expr::WordClass::Color => {
                        let c = self.parse_color()?;
                        Ok(Some(Value::Num(crate::lang::value::Num::color(c))))
                    }
                    super::expr::WordClass::Other if k == Kw::Array => {
                        self.next()?;
                        self.parse_array().map(Some)
                    }
                    super::expr::WordClass::Other => self.opened(|p| p.parse_declared(k)),
                }
            }
            _ => Ok(None),
        }
    }

    /// The next token where a value may start: directives and macros are seen.
    pub(super) fn opened_start(&mut self) -> PResult<crate::lang::token::Token> {
        let was = std::mem::replace(&mut self.closed, false);
        let t = self.peek();
        self.closed = was;
        t
    }

    fn array_rvalue(&mut self, name: Symbol) -> PResult<Option<Value>> {
        // An element may be a number that an expression goes on with.
        let place = self.symbols.resolve(name).expect("the name has a value");
        self.next()?;
        let mut place = place;
        while matches!(self.symbols.value_at(&place), Some(Value::Array(_))) && self.peek_op()?.kind == TokenKind::Punct(Punct::LBracket) {
            self.opened(|p| p.subscripts(&mut place))?;
        }
        match self.symbols.value_at(&place) {
            None => Err(self.error("Attempt to access uninitialized array element.")),
            Some(Value::Num(n)) => {
                let n = *n;
                self.parse_sum_after(n).map(|n| Some(Value::Num(n)))
            }
            Some(Value::Function(f)) if self.call_follows_now() => {
                let f = f.clone();
                let n = self.call_function(&f)?;
                self.parse_sum_after(n).map(|n| Some(Value::Num(n)))
            }
            Some(Value::Spline(s)) if self.call_follows_now() => {
                let s = s.clone();
                let n = self.call_spline(&s)?;
                self.parse_sum_after(n).map(|n| Some(Value::Num(n)))
            }
            Some(v) => Ok(Some(v.clone())),
        }
    }

    fn parse_number_value(&mut self) -> PResult<Value> {
        self.parse_sum().map(Value::Num)
    }

    /// Whether `(` follows the name that was peeked.
    fn call_follows(&self) -> bool {
        let f = self.frames.last().expect("a frame");
        f.at < f.end && f.tokens[f.at].kind == TokenKind::Punct(Punct::LParen)
    }

    /// Whether `(` is next.
    fn call_follows_now(&self) -> bool {
        match self.ahead {
            Some(t) => t.kind == TokenKind::Punct(Punct::LParen),
            None => self.call_follows(),
        }
    }

    /// Warns of the use of a deprecated name.
    pub(super) fn note_use(&mut self, name: Symbol) {
        let Some((_, entry)) = self.symbols.find(name) else { return };
        let Some(d) = entry.deprecated.clone() else { return };
        if d.once {
            let key = format!("deprecated {}", self.interner.text(name));
            self.warn_once(&key, d.message.clone());
        } else {
            self.warn(d.message.clone());
        }
    }
}
