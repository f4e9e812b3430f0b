//! The token stream: frames of includes and macro calls, directives between tokens, and messages with their place.
//!
//! [`Parser::peek`] and [`Parser::next`] run directives and expand macros, except where `closed` says that the language leaves them
//! alone (spec/language.md, section 4.1).

use super::{Frame, FrameKind, PResult, Parser};
use crate::diag::{Diagnostic, Severity, Span, TraceEntry};
use crate::lang::keyword::Kw;
use crate::lang::token::{Punct, Symbol, Token, TokenKind};
use crate::lang::value::Value;
use std::sync::Arc;

impl Parser<'_> {
    /// The next token as it stands in the text; frames that end are left on the way.
    #[inline]
    pub(super) fn next_raw(&mut self) -> Token {
        if let Some(t) = self.ahead.take() {
            return t;
        }
        let frame = self.frames.last_mut().expect("the main file's frame stays");
        match frame.tokens[..frame.end].get(frame.at) {
            Some(t) if t.kind != TokenKind::Eof => {
                frame.at += 1;
                *t
            }
            _ => self.next_frame(),
        }
    }

    /// As [`Parser::next_raw`], where the innermost frame may have ended.
    fn next_frame(&mut self) -> Token {
        loop {
            let frame = self.frames.last_mut().expect("the main file's frame stays");
            if frame.at < frame.end {
                let t = frame.tokens[frame.at];
                if t.kind != TokenKind::Eof {
                    frame.at += 1;
                    return t;
                }
            }
            if self.frames.len() == 1 {
                let f = &self.frames[0];
                return f.tokens[f.tokens.len() - 1];
            }
            let frame = self.frames.pop().expect("more than one");
            self.leave_frame(&frame);
        }
    }

    fn leave_frame(&mut self, frame: &Frame) {
        self.symbols.scopes.pop();
        if matches!(frame.kind, FrameKind::Macro(_)) {
            // Conditionals opened in a macro's body end with it.
            self.conds.truncate(frame.n_conds.min(self.conds.len()));
        }
    }

    pub(super) fn push_include(&mut self, tokens: Arc<[Token]>, from: Option<Span>) {
        if !self.frames.is_empty() {
            self.symbols.scopes.push(Default::default());
        }
        let end = tokens.len();
        self.frames.push(Frame { kind: FrameKind::Include, tokens, at: 0, end, n_conds: self.conds.len(), from });
    }

    /// Puts a raw token back; it is read again as if it had not been looked at.
    pub(super) fn unread(&mut self, t: Token) {
        self.ahead = Some(t);
        self.ahead_is_open = false;
    }

    /// The next token, directives run and macros expanded, without taking it.
    #[inline]
    pub(super) fn peek(&mut self) -> PResult<Token> {
        if let Some(t) = self.ahead
            && (self.ahead_is_open || self.closed)
        {
            return Ok(t);
        }
        self.read_ahead()
    }

    fn read_ahead(&mut self) -> PResult<Token> {
        let t = self.read()?;
        self.ahead = Some(t);
        self.ahead_is_open = !self.closed || !self.is_special(t);
        Ok(t)
    }

    pub(super) fn is_special(&self, t: Token) -> bool {
        match t.kind {
            TokenKind::Punct(Punct::Hash) => true,
            TokenKind::Ident(s) => matches!(self.symbols.value(s), Some(Value::Macro(_))),
            _ => false,
        }
    }

    /// Takes the next token.
    #[inline]
    pub(super) fn next(&mut self) -> PResult<Token> {
        let t = self.peek()?;
        self.ahead = None;
        self.last_span = t.span;
        if let TokenKind::Bad(message) = t.kind {
            let text = self.interner.text(message);
            return Err(self.error(text));
        }
        Ok(t)
    }

    fn read(&mut self) -> PResult<Token> {
        loop {
            let t = self.next_raw();
            if self.closed {
                return Ok(t);
            }
            match t.kind {
                TokenKind::Punct(Punct::Hash) => {
                    self.last_span = t.span;
                    self.directive(t)?;
                }
                TokenKind::Ident(name) => {
                    let Some(Value::Macro(m)) = self.symbols.value(name) else { return Ok(t) };
                    let m = m.clone();
                    self.last_span = t.span;
                    self.call_macro(&m, t.span)?;
                }
                _ => return Ok(t),
            }
        }
    }

    /// Runs `f` where directives are seen again, inside parentheses or brackets of a closed place.
    pub(super) fn opened<T>(&mut self, f: impl FnOnce(&mut Self) -> PResult<T>) -> PResult<T> {
        let was = (std::mem::replace(&mut self.closed, false), std::mem::replace(&mut self.closed_ops, false));
        let result = f(self);
        (self.closed, self.closed_ops) = was;
        result
    }

    /// Runs `f` where directives and macro names are ordinary tokens.
    pub(super) fn closed_place<T>(&mut self, f: impl FnOnce(&mut Self) -> PResult<T>) -> PResult<T> {
        let was = std::mem::replace(&mut self.closed, true);
        let result = f(self);
        self.closed = was;
        result
    }

    /// Refuses blocks nested too deep for the stack.
    pub(super) fn nested<T>(&mut self, f: impl FnOnce(&mut Self) -> PResult<T>) -> PResult<T> {
        if self.depth >= super::MAX_DEPTH {
            return Err(self.error(format!("Too many nested braces or parentheses (more than {}).", super::MAX_DEPTH)));
        }
        self.charge(super::NEST_COST)?;
        self.depth += 1;
        let outer = std::mem::take(&mut self.reach);
        let result = f(self);
        self.reach = outer.max(self.reach + 1);
        self.depth -= 1;
        result
    }

    /// Counts bytes that are about to be taken; looks now and then whether there are so many.
    pub(super) fn charge(&mut self, bytes: usize) -> PResult<()> {
        self.charged = self.charged.saturating_add(bytes);
        if self.charged < super::CHARGE {
            return Ok(());
        }
        let more = std::mem::take(&mut self.charged) as u64;
        self.options.memory.allows(more).map_err(|e| self.error(format!("The scene does not fit: {e}.")))
    }

    /// Whether the next token is this word.
    pub(super) fn at_kw(&mut self, kw: Kw) -> PResult<bool> {
        Ok(self.peek()?.kind == TokenKind::Kw(kw))
    }

    /// Whether the next token is this punctuation.
    pub(super) fn at_punct(&mut self, p: Punct) -> PResult<bool> {
        Ok(self.peek()?.kind == TokenKind::Punct(p))
    }

    /// The next token if it is a reserved word.
    pub(super) fn peek_kw(&mut self) -> PResult<Option<Kw>> {
        Ok(if let TokenKind::Kw(k) = self.peek()?.kind { Some(k) } else { None })
    }

    /// Takes this word if it is next.
    pub(super) fn accept_kw(&mut self, kw: Kw) -> PResult<bool> {
        let yes = self.at_kw(kw)?;
        if yes {
            self.next()?;
        }
        Ok(yes)
    }

    /// Takes this punctuation if it is next.
    pub(super) fn accept(&mut self, p: Punct) -> PResult<bool> {
        let yes = self.at_punct(p)?;
        if yes {
            self.next()?;
        }
        Ok(yes)
    }

    /// Takes this punctuation, or complains.
    pub(super) fn expect(&mut self, p: Punct) -> PResult<()> {
        let t = self.next()?;
        if t.kind == TokenKind::Punct(p) { Ok(()) } else { Err(self.expected_instead(&p.text(), t)) }
    }

    /// Takes a comma if there is one.
    pub(super) fn comma(&mut self) -> PResult<()> {
        self.accept(Punct::Comma).map(|_| ())
    }

    /// Takes this word, or complains.
    pub(super) fn expect_kw(&mut self, kw: Kw) -> PResult<()> {
        let t = self.next()?;
        if t.kind == TokenKind::Kw(kw) { Ok(()) } else { Err(self.expected_instead(kw.text(), t)) }
    }

    /// `{ ... }` after the word `what`: runs `f` inside.
    pub(super) fn block<T>(&mut self, what: &str, f: impl FnOnce(&mut Self) -> PResult<T>) -> PResult<T> {
        self.open_block(what)?;
        let value = self.nested(f)?;
        self.close_block(what)?;
        Ok(value)
    }

    /// Takes `{`.
    pub(super) fn open_block(&mut self, what: &str) -> PResult<()> {
        let t = self.next()?;
        if t.kind == TokenKind::Punct(Punct::LBrace) {
            return Ok(());
        }
        let found = self.describe(t);
        Err(self.error(format!("Missing {{ after '{what}', {found} found instead")))
    }

    /// Takes `}`.
    pub(super) fn close_block(&mut self, what: &str) -> PResult<()> {
        let t = self.next()?;
        if t.kind == TokenKind::Punct(Punct::RBrace) {
            return Ok(());
        }
        let found = self.describe(t);
        Err(self.error(format!("No matching }} in '{what}', {found} found instead")))
    }

    /// The value that the next token names, if it is a name with a value (not taken). The subscripts of an array are read here:
    /// name and subscripts become one [`TokenKind::Element`].
    pub(super) fn peek_value(&mut self) -> PResult<Option<&Value>> {
        let t = self.peek()?;
        match t.kind {
            TokenKind::Element => Ok(self.element.as_ref()),
            TokenKind::Ident(s) if matches!(self.symbols.value(s), Some(Value::Array(_))) && self.bracket_follows() => {
                self.note_reach(s);
                let mut place = self.symbols.resolve(s).expect("the name has a value");
                self.next()?;
                while matches!(self.symbols.value_at(&place), Some(Value::Array(_))) && self.bracket_follows() {
                    self.opened(|p| p.subscripts(&mut place))?;
                }
                let Some(value) = self.symbols.value_at(&place) else {
                    return Err(self.error("Attempt to access uninitialized array element."));
                };
                self.element = Some(value.clone());
                self.ahead = Some(Token { kind: TokenKind::Element, span: t.span.to(self.last_span) });
                self.ahead_is_open = true;
                Ok(self.element.as_ref())
            }
            TokenKind::Ident(s) => {
                self.note_reach(s);
                Ok(self.symbols.value(s))
            }
            _ => Ok(None),
        }
    }

    /// What is being read holds the value of a name: it is nested at least as deep.
    #[inline]
    pub(super) fn note_reach(&mut self, name: Symbol) {
        if !matches!(self.symbols.value(name), None | Some(Value::Num(_) | Value::Str(_) | Value::Macro(_))) {
            self.reach = self.reach.max(self.symbols.nesting(name));
        }
    }

    /// Whether `[` stands behind the last token read.
    fn bracket_follows(&self) -> bool {
        let f = self.frames.last().expect("a frame");
        f.at < f.end && f.tokens[f.at].kind == TokenKind::Punct(Punct::LBracket)
    }

    /// A token in words.
    pub(super) fn describe(&self, t: Token) -> String {
        match t.kind {
            TokenKind::Float(_) => "float function 'float constant'".into(),
            TokenKind::Str(_) => "string literal".into(),
            TokenKind::Eof => "End of File".into(),
            TokenKind::Punct(p) => p.text(),
            TokenKind::Bad(s) => self.interner.text(s),
            TokenKind::Element => self.element.as_ref().map_or("array element", Value::kind_name).into(),
            TokenKind::Ident(s) => match self.symbols.value(s) {
                None => format!("undeclared identifier '{}'", self.interner.text(s)),
                Some(Value::Num(n)) if n.n == 1 => "float function 'float identifier'".into(),
                Some(Value::Num(n)) if n.is_color => "color identifier".into(),
                Some(Value::Num(n)) => format!("vector function '{} identifier'", if n.n == 3 { "vector" } else { "n-vector" }),
                Some(v) => v.kind_name().into(),
            },
            TokenKind::Kw(k) => {
                let text = k.text();
                match super::expr::word_class(k) {
                    super::expr::WordClass::Float => format!("float function '{text}'"),
                    super::expr::WordClass::Vector => format!("vector function '{text}'"),
                    super::expr::WordClass::Color => format!("color keyword '{text}'"),
                    super::expr::WordClass::Other => text.to_owned(),
                }
            }
        }
    }

    /// "Expected 'what', ... found instead", for a token that was taken.
    pub(super) fn expected_instead(&self, what: &str, t: Token) -> crate::lang::Fatal {
        let found = self.describe(t);
        let mut e = self.error(format!("Expected '{what}', {found} found instead"));
        if let TokenKind::Ident(s) = t.kind
            && self.symbols.value(s).is_none()
            && let Some(hint) = self.similar_name(s)
        {
            e.hints.push(format!("did you mean '{hint}'?"));
        }
        e
    }

    /// "Expected 'what', ... found instead", for the next token.
    pub(super) fn expected<T>(&mut self, what: &str) -> PResult<T> {
        let t = self.next()?;
        Err(self.expected_instead(what, t))
    }

    /// A declared name or reserved word that differs by case or one letter.
    fn similar_name(&self, s: Symbol) -> Option<String> {
        let name = self.interner.text(s);
        let declared = self.symbols.scopes.iter().flat_map(|s| s.keys()).map(|&k| self.interner.text(k));
        let words = crate::lang::keyword::all().map(str::to_owned);
        declared.chain(words).find(|known| *known != name && one_edit_apart(known, &name))
    }

    /// An error at the last token, with the way there.
    pub(super) fn error(&self, message: impl Into<String>) -> crate::lang::Fatal {
        self.error_at(self.last_span, message)
    }

    /// An error at a place, with the way there.
    pub(super) fn error_at(&self, span: Span, message: impl Into<String>) -> crate::lang::Fatal {
        let mut d = Diagnostic::error(span, message);
        d.trace = self.trace();
        Box::new(d)
    }

    fn trace(&self) -> Vec<TraceEntry> {
        let entries = self.frames.iter().rev().filter_map(|f| {
            let span = f.from?;
            let what = match f.kind {
                FrameKind::Include => "included from".to_owned(),
                FrameKind::Macro(name) => format!("while calling macro {}", self.interner.text(name)),
            };
            Some(TraceEntry { what, span })
        });
        entries.collect()
    }

    /// A warning at the last token.
    pub(super) fn warn(&mut self, message: impl Into<String>) {
        let mut d = Diagnostic::new(Severity::Warning, Some(self.last_span), message);
        d.trace = self.trace();
        self.sink.push(d);
    }

    /// A warning about the scene as a whole, without a place.
    pub(super) fn warn_of_scene(&mut self, message: impl Into<String>) {
        self.sink.push(Diagnostic::new(Severity::Warning, None, message));
    }

    /// A warning told once for `key`.
    pub(super) fn warn_once(&mut self, key: &str, message: impl Into<String>) {
        let mut d = Diagnostic::new(Severity::Warning, Some(self.last_span), message);
        d.trace = self.trace();
        self.sink.push_once(key, d);
    }

    /// Counts a loop turn or a macro call.
    pub(super) fn step(&mut self) -> PResult<()> {
        self.steps += 1;
        if self.steps > self.options.max_steps {
            let limit = self.options.max_steps;
            let mut e = self.error(format!("The scene does not end: more than {limit} loop turns and macro calls."));
            e.hints.push("an endless #while? check that its condition can become false".into());
            return Err(e);
        }
        Ok(())
    }
}

/// Whether two names differ by letter case alone, or by one letter changed, left out or added.
fn one_edit_apart(a: &str, b: &str) -> bool {
    if a.eq_ignore_ascii_case(b) {
        return true;
    }
    let (a, b) = (a.as_bytes(), b.as_bytes());
    if a.len().abs_diff(b.len()) > 1 || a.len() < 4 || b.len() < 4 {
        return false;
    }
    let front = a.iter().zip(b).take_while(|(x, y)| x == y).count();
    let back = a.iter().rev().zip(b.iter().rev()).take_while(|(x, y)| x == y).count();
    front + back + 1 >= a.len().max(b.len())
}
