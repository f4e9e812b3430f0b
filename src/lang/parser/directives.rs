//! `#` directives: conditionals, loops, includes, versions, messages. Source: spec/language.md, section 4.

use super::{Cond, CondKind, FrameKind, PResult, Parser};
use crate::lang::Stream;
use crate::lang::keyword::Kw;
use crate::lang::token::{Punct, Symbol, Token, TokenKind};
use crate::lang::value::{Num, Value};
use std::sync::Arc;

/// Values closer than this match in `#case`, and end `#for`.
const TOLERANCE: f64 = 1e-10;
/// Includes nested deeper than this are refused.
const MAX_INCLUDES: usize = 32;
/// Open conditionals beyond this are refused.
const MAX_CONDS: usize = 200;

/// What ended a stretch of skipped text.
#[derive(PartialEq)]
enum Stop {
    End,
    Else,
    Elseif,
    Case(Kw),
}

impl Parser<'_> {
    /// Runs the directive whose `#` was just taken.
    pub(super) fn directive(&mut self, hash: Token) -> PResult<()> {
        let word = self.next_raw();
        self.last_span = hash.span.to(word.span);
        let TokenKind::Kw(kw) = word.kind else {
            // A stray # is skipped, whatever follows.
            self.unread(word);
            return Ok(());
        };
        // Directives inside a value that is itself in a closed place start afresh.
        let was_closed_ops = std::mem::replace(&mut self.closed_ops, false);
        let result = self.run_directive(kw, word);
        self.closed_ops = was_closed_ops;
        result
    }

    fn run_directive(&mut self, kw: Kw, word: Token) -> PResult<()> {
        match kw {
            Kw::Declare => self.declare(false),
            Kw::Local => self.declare(true),
            Kw::Undef => self.undef(),
            Kw::If => {
                let c = self.condition()?;
                self.enter_if(c, word)
            }
            Kw::Ifdef => {
                let c = self.defined_condition()?;
                self.enter_if(c, word)
            }
            Kw::Ifndef => {
                let c = !self.defined_condition()?;
                self.enter_if(c, word)
            }
            // A taken branch ends here: what follows up to #end is for others.
            Kw::Elseif => self.leave_branch("elseif"),
            Kw::Else => match self.conds.last().map(|c| &c.kind) {
                Some(CondKind::Switch) => Ok(()),
                _ => self.leave_branch("else"),
            },
            Kw::End => self.end(),
            Kw::Switch => self.switch(word),
            Kw::Case | Kw::Range => self.fall_through(kw),
            Kw::While => {
                let at = self.frames.last().expect("a frame").at;
                self.while_turn(self.frames.len() - 1, at, word)
            }
            Kw::For => self.for_start(word),
            Kw::Break => self.break_out(),
            Kw::Macro => self.define_macro(),
            Kw::Include => {
                let name = self.parse_file_name()?;
                let span = self.last_span;
                self.include_file(&name, Some(span))
            }
            Kw::Version => {
                // The main file's first two tokens were the # and this word.
                self.version_late |= !self.version_set && (self.frames.len() > 1 || self.frames[0].at > 2);
                self.version_directive()
            }
            Kw::Default => self.default_directive(),
            Kw::Debug => self.message(Stream::Debug),
            Kw::Render => self.message(Stream::Render),
            Kw::Statistics => self.message(Stream::Statistics),
            Kw::Warning => {
                let text = self.parse_text()?;
                self.warn(clip(&text, 160, 124).replace('\n', " "));
                Ok(())
            }
            Kw::Error => {
                let text = self.parse_text()?;
                Err(self.error(format!("Parse halted by #error directive: {}", clip(&text, 160, 124))))
            }
            Kw::Fopen => self.fopen(),
            Kw::Fclose => self.fclose(),
            Kw::Read => self.read_file(),
            Kw::Write => self.write_file(),
            _ => {
                self.unread(word);
                Ok(())
            }
        }
    }

    /// Runs `#else`, `#elseif` and `#end` of conditionals opened since there were `n_conds`, where a value that they chose has just ended.
    pub(super) fn end_value_conditionals(&mut self, n_conds: usize) -> PResult<()> {
        while self.conds.len() > n_conds {
            let hash = self.next_raw();
            let f = self.frames.last().expect("a frame");
            let ends = hash.kind == TokenKind::Punct(Punct::Hash)
                && f.at < f.end
                && matches!(f.tokens[f.at].kind, TokenKind::Kw(Kw::Else | Kw::Elseif | Kw::End));
            if !ends {
                self.unread(hash);
                break;
            }
            self.directive(hash)?;
        }
        Ok(())
    }

    /// `( Cond )` of `#if`, `#while`, `#switch`, `#case`: a number.
    fn condition_value(&mut self) -> PResult<f64> {
        self.expect(Punct::LParen)?;
        let was = std::mem::replace(&mut self.closed_ops, true);
        let value = self.parse_cond();
        self.closed_ops = was;
        let value = value?;
        self.expect_closing()?;
        self.as_float(value)
    }

    /// The `)` of a condition, taken without looking beyond it.
    pub(super) fn expect_closing(&mut self) -> PResult<()> {
        self.closed_place(|p| p.expect(Punct::RParen))
    }

    fn condition(&mut self) -> PResult<bool> {
        Ok(self.condition_value()?.abs() > TOLERANCE)
    }

    /// `( Name[i]... )`: whether it is defined.
    pub(super) fn defined_condition(&mut self) -> PResult<bool> {
        self.closed_place(|p| {
            p.expect(Punct::LParen)?;
            let t = p.next()?;
            let yes = match t.kind {
                TokenKind::Ident(name) => p.is_defined(name)?,
                _ => false,
            };
            p.expect(Punct::RParen)?;
            Ok(yes)
        })
    }

    /// Whether a name, or the element of it that follows, has a value.
    fn is_defined(&mut self, name: Symbol) -> PResult<bool> {
        let Some(mut place) = self.symbols.resolve(name) else { return Ok(self.symbols.valueless.contains(&name)) };
        while self.at_punct(Punct::LBracket)? {
            match self.symbols.value_at(&place) {
                Some(Value::Array(_)) => self.subscripts(&mut place)?,
                _ => return Ok(false),
            }
        }
        Ok(self.symbols.value_at(&place).is_some())
    }

    fn push_cond(&mut self, kind: CondKind, word: Token) -> PResult<()> {
        if self.conds.len() >= MAX_CONDS {
            return Err(self.error("Too many nested conditionals or macros."));
        }
        self.conds.push(Cond { kind, span: word.span });
        Ok(())
    }

    fn enter_if(&mut self, mut taken: bool, word: Token) -> PResult<()> {
        loop {
            if taken {
                return self.push_cond(CondKind::If, word);
            }
            match self.skip(true, false)? {
                Stop::End => return Ok(()),
                Stop::Else => return self.push_cond(CondKind::Else, word),
                Stop::Elseif => taken = self.condition()?,
                Stop::Case(_) => unreachable!("not asked for"),
            }
        }
    }

    fn leave_branch(&mut self, word: &str) -> PResult<()> {
        match self.conds.last().map(|c| &c.kind) {
            Some(CondKind::If) => {
                self.conds.pop();
                while self.skip(true, false)? != Stop::End {}
                Ok(())
            }
            _ => Err(self.error(format!("Mis-matched '#{word}'."))),
        }
    }

    /// Skips text up to the directive that ends it at this level.
    fn skip(&mut self, stop_at_else: bool, stop_at_case: bool) -> PResult<Stop> {
        let mut depth = 0usize;
        loop {
            let t = self.next_raw();
            match t.kind {
                TokenKind::Punct(Punct::Hash) => {}
                TokenKind::Eof => {
                    self.last_span = t.span;
                    return Err(self.error("End of file reached but #end expected."));
                }
                TokenKind::Bad(message) => {
                    self.last_span = t.span;
                    let text = self.interner.text(message);
                    return Err(self.error(text));
                }
                _ => continue,
            }
            let w = self.next_raw();
            match w.kind {
                TokenKind::Kw(Kw::If | Kw::Ifdef | Kw::Ifndef | Kw::While | Kw::For | Kw::Switch | Kw::Macro) => depth += 1,
                TokenKind::Kw(Kw::End) if depth > 0 => depth -= 1,
                TokenKind::Kw(Kw::End) => {
                    self.last_span = w.span;
                    return Ok(Stop::End);
                }
                TokenKind::Kw(Kw::Else) if depth == 0 && stop_at_else => return Ok(Stop::Else),
                TokenKind::Kw(Kw::Elseif) if depth == 0 && stop_at_else => return Ok(Stop::Elseif),
                TokenKind::Kw(k @ (Kw::Case | Kw::Range)) if depth == 0 && stop_at_case => return Ok(Stop::Case(k)),
                TokenKind::Kw(_) | TokenKind::Ident(_) => {}
                _ => self.unread(w),
            }
        }
    }

    fn end(&mut self) -> PResult<()> {
        let Some(cond) = self.conds.pop() else { return Err(self.error("Mis-matched '#end'.")) };
        match cond.kind {
            CondKind::If | CondKind::Else | CondKind::Switch => Ok(()),
            CondKind::While { frame, at } => {
                self.check_loop_file("#while", frame)?;
                let word = Token { kind: TokenKind::Kw(Kw::While), span: cond.span };
                self.frames[frame].at = at;
                self.while_turn(frame, at, word)
            }
            CondKind::For { frame, at, scope, name, end, step } => {
                self.check_loop_file("#for", frame)?;
                let value = match self.symbols.scopes[scope].get(&name).map(|e| &e.binding) {
                    Some(crate::lang::value::Binding::Value(Value::Num(n))) if n.n == 1 => n.v[0] + step,
                    _ => return Err(self.error("#for loop variable must remain defined and numerical during loop.")),
                };
                self.step()?;
                self.symbols.set(scope, name, Value::Num(Num::float(value)));
                if for_goes_on(value, end, step) {
                    self.frames[frame].at = at;
                    self.conds.push(Cond { kind: CondKind::For { frame, at, scope, name, end, step }, span: cond.span });
                }
                Ok(())
            }
        }
    }

    fn check_loop_file(&self, what: &str, frame: usize) -> PResult<()> {
        if self.frames.len() - 1 == frame {
            return Ok(());
        }
        Err(self.error(format!("{what} loop did not end in file where it started.")))
    }

    fn while_turn(&mut self, frame: usize, at: usize, word: Token) -> PResult<()> {
        self.step()?;
        if self.condition()? {
            self.push_cond(CondKind::While { frame, at }, word)
        } else {
            while self.skip(false, false)? != Stop::End {}
            Ok(())
        }
    }

    fn for_start(&mut self, word: Token) -> PResult<()> {
        let name = self.closed_place(|p| {
            p.expect(Punct::LParen)?;
            let t = p.next()?;
            let TokenKind::Ident(name) = t.kind else { return Err(p.expected_instead("undeclared identifier", t)) };
            if p.at_punct(Punct::LBracket)? {
                return Err(p.error("#for loop variable must not be an array element."));
            }
            Ok(name)
        })?;
        let was = std::mem::replace(&mut self.closed_ops, true);
        let bounds = self.for_bounds();
        self.closed_ops = was;
        let (start, end, step) = bounds?;
        self.expect_closing()?;
        if step.abs() < TOLERANCE {
            return Err(self.error("#for loop increment must be non-zero."));
        }
        let scope = self.symbols.scopes.len() - 1;
        self.symbols.set(scope, name, Value::Num(Num::float(start)));
        if for_goes_on(start, end, step) {
            let frame = self.frames.len() - 1;
            let at = self.frames[frame].at;
            self.push_cond(CondKind::For { frame, at, scope, name, end, step }, word)
        } else {
            while self.skip(false, false)? != Stop::End {}
            Ok(())
        }
    }

    fn for_bounds(&mut self) -> PResult<(f64, f64, f64)> {
        self.closed_place(|p| p.comma())?;
        let start = self.parse_float()?;
        self.closed_place(|p| p.comma())?;
        let end = self.parse_float()?;
        self.closed_place(|p| p.comma())?;
        let step = if self.closed_place(|p| p.at_punct(Punct::RParen))? { 1.0 } else { self.parse_float()? };
        Ok((start, end, step))
    }

    fn switch(&mut self, word: Token) -> PResult<()> {
        let value = self.condition_value()?;
        // Other directives may stand before the first #case.
        let mut stop = loop {
            let t = self.next_raw();
            if t.kind != TokenKind::Punct(Punct::Hash) {
                self.last_span = t.span;
                return Err(self.error("#switch not followed by #case or #range."));
            }
            let w = self.next_raw();
            self.last_span = w.span;
            match w.kind {
                TokenKind::Kw(k @ (Kw::Case | Kw::Range)) => break Stop::Case(k),
                TokenKind::Kw(Kw::Else) => return Err(self.error("Mis-matched '#else'.")),
                TokenKind::Kw(Kw::End) => return Err(self.error("Mis-matched '#end'.")),
                _ => {
                    self.unread(w);
                    self.directive(t)?;
                }
            }
        };
        loop {
            match stop {
                Stop::Case(kw) => {
                    if self.case_matches(kw, value)? {
                        return self.push_cond(CondKind::Switch, word);
                    }
                }
                Stop::Else => return self.push_cond(CondKind::Switch, word),
                Stop::End | Stop::Elseif => return Ok(()),
            }
            stop = self.skip(true, true)?;
        }
    }

    fn case_matches(&mut self, kw: Kw, value: f64) -> PResult<bool> {
        if kw == Kw::Case {
            let x = self.condition_value()?;
            return Ok((x - value).abs() < TOLERANCE);
        }
        self.expect(Punct::LParen)?;
        let was = std::mem::replace(&mut self.closed_ops, true);
        let range = self.case_range();
        self.closed_ops = was;
        let (low, high) = range?;
        self.expect_closing()?;
        Ok(value >= low && value <= high)
    }

    fn case_range(&mut self) -> PResult<(f64, f64)> {
        let low = self.parse_float()?;
        self.closed_place(|p| p.comma())?;
        Ok((low, self.parse_float()?))
    }

    fn fall_through(&mut self, kw: Kw) -> PResult<()> {
        match self.conds.last().map(|c| &c.kind) {
            Some(CondKind::Switch) => self.case_matches(kw, 0.0).map(|_| ()),
            _ => Err(self.error(format!("Mis-matched '#{}'.", kw.text()))),
        }
    }

    fn break_out(&mut self) -> PResult<()> {
        let frame = self.frames.last().expect("a frame");
        let is_macro = matches!(frame.kind, FrameKind::Macro(_));
        let base = if is_macro { frame.n_conds } else { 0 };
        let inner = self.conds[base.min(self.conds.len())..]
            .iter()
            .rposition(|c| matches!(c.kind, CondKind::Switch | CondKind::While { .. } | CondKind::For { .. }));
        match inner {
            Some(i) => {
                // The open #ifs inside the loop each have an #end to pass, then the loop's own.
                let n_ends = self.conds.len() - (base + i);
                self.conds.truncate(base + i);
                for _ in 0..n_ends {
                    while self.skip(false, false)? != Stop::End {}
                }
                Ok(())
            }
            None if is_macro => {
                let frame = self.frames.last_mut().expect("a frame");
                frame.at = frame.end;
                self.conds.truncate(base);
                Ok(())
            }
            None => Err(self.error("Invalid context for #break")),
        }
    }

    /// Skips the body of a macro up to its `#end`; the token index of that `#` in the current frame.
    pub(super) fn skip_macro_body(&mut self) -> PResult<usize> {
        let depth = self.frames.len();
        while self.skip(false, false)? != Stop::End {}
        if self.frames.len() != depth {
            return Err(self.error("#macro did not end in file where it started."));
        }
        Ok(self.frames[depth - 1].at - 2)
    }

    /// Opens an include file.
    pub(super) fn include_file(&mut self, name: &str, from: Option<crate::diag::Span>) -> PResult<()> {
        let n_open = self.frames.iter().filter(|f| matches!(f.kind, FrameKind::Include)).count();
        if n_open >= MAX_INCLUDES {
            let mut e = self.error("Too many nested include files.");
            e.hints.push("does a file include itself?".into());
            return Err(e);
        }
        self.check_scopes()?;
        self.step()?;
        let Some(path) = self.world.find(name, &[".inc", ".INC"]) else {
            let mut e = self.error(format!("Cannot open include file {name}."));
            e.hints.push("the current folder and the library paths (+L, Library_Path, -L) are searched, not the scene's folder".into());
            return Err(e);
        };
        let bytes = self.world.read(&path).map_err(|e| self.error(e.to_string()))?;
        let tokens = match self.lexed.get(&path) {
            // Lexed before, and not rewritten since.
            Some((known, tokens)) if *known == bytes => tokens.clone(),
            _ => {
                self.charge(bytes.len().saturating_mul(4))?;
                let file = self.map.add(name, path.clone(), bytes.clone());
                let tokens: Arc<[Token]> = crate::lang::lexer::lex(file, &bytes, false, &mut self.interner).0.into();
                self.lexed.insert(path, (bytes, tokens.clone()));
                tokens
            }
        };
        self.push_include(tokens, from);
        Ok(())
    }

    /// Refuses a scope too many.
    pub(super) fn check_scopes(&self) -> PResult<()> {
        if self.symbols.scopes.len() >= crate::lang::value::SymbolTable::MAX_SCOPES - 1 {
            return Err(self.error("Too many nested symbol tables"));
        }
        Ok(())
    }

    fn version_directive(&mut self) -> PResult<()> {
        let value = self.closed_place(|p| {
            if let TokenKind::Ident(s) = p.peek()?.kind
                && p.interner.text(s) == "unofficial"
            {
                p.next()?;
            }
            p.closed_ops = true;
            let value = p.parse_float_in_closed_place();
            p.closed_ops = false;
            let value = value?;
            if p.at_punct(Punct::Semicolon)? {
                p.next()?;
            } else {
                p.warn("Possible Parse Error: All #version and #declares of float, vector, and color require semi-colon ';' at end.");
            }
            Ok(value)
        })?;
        let version = (value * 100.0 + 0.5).floor();
        if version > 370.0 {
            return Err(self.error(format!("Your scene file requires POV-Ray version {value} or later!")));
        }
        self.version = version.max(0.0) as u32;
        self.noise_changed();
        self.version_set = true;
        Ok(())
    }

    fn message(&mut self, stream: Stream) -> PResult<()> {
        let text = self.parse_text()?;
        self.charge(size_of::<(Stream, String)>() + text.len())?;
        self.write_text(stream, &clip(&text, 200, 156));
        Ok(())
    }

    /// Adds to a text stream: what a line break completes is written, broken at 80 columns; a tail without one is lost.
    fn write_text(&mut self, stream: Stream, text: &str) {
        for c in text.chars() {
            if c == '\n' {
                let line = std::mem::take(&mut self.debug_line);
                self.output.push((stream, line + "\n"));
            } else {
                self.debug_line.push(c);
                if self.debug_line.len() >= 80 {
                    // A line too long is broken at its last blank, or where it is.
                    let line = std::mem::take(&mut self.debug_line);
                    let at = line.rfind(' ').filter(|&i| i > 0).unwrap_or_else(|| line.floor_char_boundary(79));
                    let (head, tail) = line.split_at(at);
                    self.output.push((stream, format!("{head}\n")));
                    self.debug_line = format!(" {}", tail.trim_start());
                }
            }
        }
    }
}

fn for_goes_on(value: f64, end: f64, step: f64) -> bool {
    if step > 0.0 { value <= end + TOLERANCE } else { value >= end - TOLERANCE }
}

/// Text longer than `limit` is cut to `keep` characters and marked.
fn clip(text: &str, limit: usize, keep: usize) -> String {
    if text.chars().count() <= limit { text.to_owned() } else { format!("{}...", text.chars().take(keep).collect::<String>()) }
}
