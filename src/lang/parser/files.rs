//! Files that a scene opens, reads and writes. Source: spec/language.md, section 4.6.

use super::{PResult, Parser};
use crate::lang::keyword::Kw;
use crate::lang::token::{Punct, Token, TokenKind};
use crate::lang::value::{Num, Place, Value};
use std::path::PathBuf;
use std::sync::Arc;

/// An open file.
pub(super) struct UserFile {
    path: PathBuf,
    mode: Mode,
}

enum Mode {
    Read { tokens: Arc<[Token]>, at: usize },
    Write,
}

/// C's `%g`: six significant digits, shortest form.
pub(super) fn format_g(x: f64) -> String {
    if !x.is_finite() {
        let sign = if x.is_sign_negative() { "-" } else { "" };
        return format!("{sign}{}", if x.is_nan() { "nan" } else { "inf" });
    }
    if x == 0.0 {
        return if x.is_sign_negative() { "-0".into() } else { "0".into() };
    }
    let scientific = format!("{x:.5e}");
    let (mantissa, exponent) = scientific.split_once('e').expect("the format has an exponent");
    let exponent: i32 = exponent.parse().expect("the format has a number");
    let trim = |s: &str| if s.contains('.') { s.trim_end_matches('0').trim_end_matches('.').to_owned() } else { s.to_owned() };
    if (-4..6).contains(&exponent) {
        trim(&format!("{x:.*}", (5 - exponent).max(0) as usize))
    } else {
        format!("{}e{}{:02}", trim(mantissa), if exponent < 0 { '-' } else { '+' }, exponent.abs())
    }
}

impl Parser<'_> {
    fn handle_name(&mut self) -> PResult<Token> {
        self.closed_place(|p| p.next())
    }

    fn open_handle(&mut self, t: Token) -> PResult<usize> {
        if let TokenKind::Ident(s) = t.kind
            && let Some(Value::File(i)) = self.symbols.value(s)
        {
            return Ok(*i);
        }
        Err(self.expected_instead("file handle identifier", t))
    }

    pub(super) fn fopen(&mut self) -> PResult<()> {
        let t = self.handle_name()?;
        let name = match t.kind {
            TokenKind::Ident(s) if self.symbols.value(s).is_none() => s,
            _ => return Err(self.expected_instead("undeclared identifier", t)),
        };
        let file_name = self.parse_file_name()?;
        let mode = match self.closed_place(|p| p.next())?.kind {
            TokenKind::Kw(k @ (Kw::Read | Kw::Write | Kw::Append)) => k,
            _ => return Err(self.expected_instead("read or write", Token { kind: t.kind, span: self.last_span })),
        };
        let (path, mode) = if mode == Kw::Read {
            let Some(path) = self.world.find(&file_name, &[]) else {
                return Err(self.error(format!("Cannot open user file {file_name} (read).")));
            };
            let bytes = self.world.read_user_file(&path).map_err(|e| self.error(e.to_string()))?;
            self.charge(bytes.len().saturating_mul(4))?;
            let file = self.map.add(file_name.as_str(), path.clone(), bytes.clone());
            let tokens = crate::lang::lexer::lex(file, &bytes, false, &mut self.interner).0;
            (path, Mode::Read { tokens: tokens.into(), at: 0 })
        } else {
            let path = PathBuf::from(&file_name);
            let verb = if mode == Kw::Append { "append" } else { "write" };
            self.world
                .write(&path, b"", mode == Kw::Append)
                .map_err(|e| self.error(format!("Cannot open user file {file_name} ({verb}): {e}")))?;
            (path, Mode::Write)
        };
        self.files.push(Some(UserFile { path, mode }));
        self.symbols.set(0, name, Value::File(self.files.len() - 1));
        Ok(())
    }

    pub(super) fn fclose(&mut self) -> PResult<()> {
        let t = self.handle_name()?;
        if let TokenKind::Ident(s) = t.kind
            && let Some(Value::File(i)) = self.symbols.value(s)
        {
            let i = *i;
            self.files[i] = None;
            if let Some((scope, _)) = self.symbols.find(s) {
                self.symbols.scopes[scope].remove(&s);
            }
        }
        Ok(())
    }

    pub(super) fn write_file(&mut self) -> PResult<()> {
        self.closed_place(|p| p.expect(Punct::LParen))?;
        let t = self.handle_name()?;
        let handle = self.open_handle(t)?;
        let mut out = Vec::new();
        self.opened(|p| {
            p.comma()?;
            while !p.at_punct(Punct::RParen)? {
                p.write_item(&mut out)?;
                p.comma()?;
            }
            Ok(())
        })?;
        self.expect_closing()?;
        match &self.files[handle] {
            Some(UserFile { path, mode: Mode::Write }) => self.world.write(path, &out, true).map_err(|e| self.error(e.to_string())),
            _ => Err(self.error("Cannot write to the file: it is not open for writing.")),
        }
    }

    fn write_item(&mut self, out: &mut Vec<u8>) -> PResult<()> {
        let t = self.peek()?;
        if let TokenKind::Kw(
            k @ (Kw::Sint8 | Kw::Uint8 | Kw::Sint16be | Kw::Sint16le | Kw::Uint16be | Kw::Uint16le | Kw::Sint32be | Kw::Sint32le),
        ) = t.kind
        {
            self.next()?;
            while self.number_follows()? {
                let x = self.parse_float()?;
                write_binary(k, x, out);
                self.comma()?;
            }
            return Ok(());
        }
        if self.string_follows()? {
            let text = self.parse_text()?;
            out.extend(text.chars().map(|c| if c.is_ascii() { c as u8 } else { b' ' }));
            return Ok(());
        }
        if self.color_follows()? || !self.number_follows()? {
            return self.expected("string, float, or vector expression");
        }
        let n = self.parse_sum()?;
        if n.n == 1 {
            out.extend(format_g(n.v[0]).into_bytes());
        } else {
            let parts: Vec<String> = n.v[..n.n as usize].iter().map(|&x| format_g(x)).collect();
            out.extend(format!("<{}> ", parts.join(",")).into_bytes());
        }
        Ok(())
    }

    pub(super) fn read_file(&mut self) -> PResult<()> {
        self.closed_place(|p| p.expect(Punct::LParen))?;
        let t = self.handle_name()?;
        let handle = self.open_handle(t)?;
        let TokenKind::Ident(handle_name) = t.kind else { unreachable!("a handle is a name") };
        if let Some(UserFile { path, mode: Mode::Write }) = &self.files[handle] {
            return Err(self.error(format!("Cannot read from file {} because the file is open for writing only.", path.display())));
        }
        self.closed_place(|p| p.comma())?;
        let mut ended = false;
        while !self.closed_place(|p| p.at_punct(Punct::RParen))? {
            let v = self.closed_place(|p| p.next())?;
            let TokenKind::Ident(name) = v.kind else { return Err(self.expected_instead("identifier", v)) };
            let mut place = self.symbols.resolve(name).unwrap_or(Place { scope: 0, name, path: Vec::new() });
            while self.closed_place(|p| p.at_punct(Punct::LBracket))? {
                self.closed_place(|p| p.subscripts(&mut place))?;
            }
            if !ended {
                match self.read_item(handle)? {
                    Some((value, was_last)) => {
                        self.assign(&place, name, value)?;
                        ended = was_last;
                    }
                    None => {
                        ended = true;
                        self.symbols.valueless.insert(name);
                    }
                }
            }
            self.closed_place(|p| p.comma())?;
        }
        self.expect_closing()?;
        if ended {
            self.files[handle] = None;
            if let Some((scope, _)) = self.symbols.find(handle_name) {
                self.symbols.scopes[scope].remove(&handle_name);
            }
        }
        Ok(())
    }

    fn file_token(&mut self, handle: usize) -> Option<TokenKind> {
        let Some(UserFile { mode: Mode::Read { tokens, at }, .. }) = &mut self.files[handle] else { return None };
        let kind = tokens[*at].kind;
        if kind == TokenKind::Eof {
            return None;
        }
        *at += 1;
        Some(kind)
    }

    /// The next value of a file, and whether nothing follows it.
    fn read_item(&mut self, handle: usize) -> PResult<Option<(Value, bool)>> {
        let Some(first) = self.file_token(handle) else { return Ok(None) };
        let value = match first {
            TokenKind::Str(s) => {
                let bytes = self.interner.bytes(s).clone();
                Value::Str(bytes.iter().map(|&b| u16::from(b)).collect())
            }
            TokenKind::Punct(Punct::Lt) => {
                let mut v = [0.0; 5];
                let mut n = 0;
                loop {
                    let kind = self.file_token(handle);
                    match kind {
                        Some(TokenKind::Punct(Punct::Gt)) => break,
                        Some(TokenKind::Punct(Punct::Comma)) => {}
                        _ if n < 5 => {
                            v[n] = self.read_number(handle, kind)?;
                            n += 1;
                        }
                        _ => return Err(self.error("Expected '>' in the vector of a file that is read.")),
                    }
                }
                if n < 2 {
                    return Err(self.error("A vector in a file that is read has fewer than 2 components."));
                }
                Value::Num(Num { n: n as u8, is_color: n == 5, v })
            }
            other => Value::Num(Num::float(self.read_number(handle, Some(other))?)),
        };
        // One more token is eaten, a comma or not.
        let was_last = self.file_token(handle).is_none();
        Ok(Some((value, was_last)))
    }

    fn read_number(&mut self, handle: usize, kind: Option<TokenKind>) -> PResult<f64> {
        match kind {
            Some(TokenKind::Float(x)) => Ok(x),
            Some(TokenKind::Punct(Punct::Minus)) => {
                let next = self.file_token(handle);
                Ok(-self.read_number(handle, next)?)
            }
            Some(TokenKind::Punct(Punct::Plus)) => {
                let next = self.file_token(handle);
                self.read_number(handle, next)
            }
            _ => Err(self.error("Expected a number, string or vector in the file that is read.")),
        }
    }
}

fn write_binary(k: Kw, x: f64, out: &mut Vec<u8>) {
    let round = |low: f64, high: f64| (x.clamp(low, high) + 0.5).floor() as i64;
    match k {
        Kw::Sint8 => out.push(round(-128.0, 127.0) as i8 as u8),
        Kw::Uint8 => out.push(round(0.0, 255.0) as u8),
        Kw::Sint16be => out.extend((round(-32_768.0, 32_767.0) as i16).to_be_bytes()),
        Kw::Sint16le => out.extend((round(-32_768.0, 32_767.0) as i16).to_le_bytes()),
        Kw::Uint16be => out.extend((round(0.0, 65_535.0) as u16).to_be_bytes()),
        Kw::Uint16le => out.extend((round(0.0, 65_535.0) as u16).to_le_bytes()),
        Kw::Sint32be => out.extend((round(-2_147_483_648.0, 2_147_483_647.0) as i32).to_be_bytes()),
        _ => out.extend((round(-2_147_483_648.0, 2_147_483_647.0) as i32).to_le_bytes()),
    }
}

#[cfg(test)]
mod tests {
    use super::format_g;

    #[test]
    fn g_is_written_as_c_writes_it() {
        for (x, text) in
            [(1.234567, "1.23457"), (1e10, "1e+10"), (1.23e-5, "1.23e-05"), (100000.0, "100000"), (1e6, "1e+06"), (-0.5, "-0.5")]
        {
            assert_eq!(format_g(x), text);
        }
    }
}
