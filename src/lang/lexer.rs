//! Bytes → tokens, once a file. Source: spec/language.md, section 1.
//!
//! Nothing here fails: what cannot be read becomes a [`TokenKind::Bad`] token, which is fatal only when the parser reaches it.

use super::intern::Interner;
use super::keyword;
use super::token::{Punct, Token, TokenKind};
use crate::diag::{FileId, Span};

/// Longest identifier and string literal, in bytes.
const MAX_TEXT: usize = 255;

/// The tokens of a file, ended by one [`TokenKind::Eof`]. `main_file` allows a byte-order mark at the start; the flag
/// returned says that there was one (strings are UTF-8 then).
pub fn lex(file: FileId, bytes: &[u8], main_file: bool, interner: &mut Interner) -> (Vec<Token>, bool) {
    let mut l = Lexer { file, b: bytes, at: 0, out: Vec::with_capacity(bytes.len() / 4 + 1), interner };
    let mut utf8 = false;
    if main_file {
        while l.b.get(l.at).is_some_and(|&c| c >= 0x80) {
            l.at += 1;
            utf8 = true;
        }
    }
    l.run();
    (l.out, utf8)
}

struct Lexer<'a> {
    file: FileId,
    b: &'a [u8],
    at: usize,
    out: Vec<Token>,
    interner: &'a mut Interner,
}

impl Lexer<'_> {
    fn push(&mut self, lo: usize, kind: TokenKind) {
        self.out.push(Token { kind, span: Span { file: self.file, lo: lo as u32, hi: self.at as u32 } });
    }

    fn bad(&mut self, lo: usize, message: &str) {
        let s = self.interner.intern(message.as_bytes());
        self.push(lo, TokenKind::Bad(s));
    }

    fn peek(&self, ahead: usize) -> u8 {
        self.b.get(self.at + ahead).copied().unwrap_or(0)
    }

    fn run(&mut self) {
        while self.at < self.b.len() {
            let lo = self.at;
            let c = self.b[lo];
            match c {
                b' ' | b'\t' | b'\n' | b'\r' | 0x0b | 0x0c | 0 | 0x1a => self.at += 1,
                b'a'..=b'z' | b'A'..=b'Z' | b'_' => self.word(),
                b'0'..=b'9' => self.number(),
                b'.' if self.peek(1).is_ascii_digit() => self.number(),
                b'"' => self.string(),
                b'/' if self.peek(1) == b'/' => {
                    while self.at < self.b.len() && !matches!(self.b[self.at], b'\n' | b'\r') {
                        self.at += 1;
                    }
                }
                b'/' if self.peek(1) == b'*' => self.block_comment(),
                _ => self.punctuation(c),
            }
        }
        self.push(self.at, TokenKind::Eof);
    }

    fn word(&mut self) {
        let lo = self.at;
        while self.at < self.b.len() && (self.b[self.at].is_ascii_alphanumeric() || self.b[self.at] == b'_') {
            self.at += 1;
        }
        let text = &self.b[lo..self.at];
        if let Some(kw) = keyword::lookup(text) {
            self.push(lo, TokenKind::Kw(kw));
        } else if text.len() > MAX_TEXT {
            self.bad(lo, "String too long.");
        } else {
            let s = self.interner.intern(text);
            self.push(lo, TokenKind::Ident(s));
        }
    }

    fn digits(&mut self) {
        while self.peek(0).is_ascii_digit() {
            self.at += 1;
        }
    }

    fn number(&mut self) {
        let lo = self.at;
        self.digits();
        if self.peek(0) == b'.' {
            self.at += 1;
            self.digits();
            if self.peek(0) == b'.' && self.peek(1).is_ascii_digit() {
                self.at += 1;
                self.digits();
                return self.bad(lo, "Unexpected additional '.' in floating-point number");
            }
        }
        let mantissa_end = self.at;
        if matches!(self.peek(0), b'e' | b'E') {
            self.at += 1;
            if matches!(self.peek(0), b'+' | b'-') {
                self.at += 1;
            }
            let exponent = self.at;
            self.digits();
            if exponent == self.at {
                // "1e" reads as 1: the letter and the sign are eaten with no effect.
                let value = parse_float(&self.b[lo..mantissa_end]);
                return self.push(lo, TokenKind::Float(value));
            }
        }
        let value = parse_float(&self.b[lo..self.at]);
        self.push(lo, TokenKind::Float(value));
    }

    fn string(&mut self) {
        let lo = self.at;
        self.at += 1;
        let start = self.at;
        loop {
            match self.b.get(self.at) {
                None => return self.bad(lo, "String literal not terminated."),
                Some(b'"') => break,
                Some(b'\\') if self.peek(1) == b'"' || self.peek(1) == b'\\' => self.at += 2,
                Some(_) => self.at += 1,
            }
        }
        let text = &self.b[start..self.at];
        self.at += 1;
        if text.len() > MAX_TEXT {
            return self.bad(lo, "String too long.");
        }
        let s = self.interner.intern(text);
        self.push(lo, TokenKind::Str(s));
    }

    fn block_comment(&mut self) {
        let lo = self.at;
        let mut depth = 0usize;
        while self.at < self.b.len() {
            match (self.b[self.at], self.peek(1)) {
                (b'/', b'*') => {
                    depth += 1;
                    self.at += 2;
                }
                (b'*', b'/') => {
                    depth -= 1;
                    self.at += 2;
                    if depth == 0 {
                        return;
                    }
                }
                _ => self.at += 1,
            }
        }
        self.bad(lo, "No */ closing comment found.");
    }

    fn punctuation(&mut self, c: u8) {
        let lo = self.at;
        self.at += 1;
        let two = self.peek(0) == b'=';
        let kind = match c {
            b'{' => Punct::LBrace,
            b'}' => Punct::RBrace,
            b'(' => Punct::LParen,
            b')' => Punct::RParen,
            b'[' => Punct::LBracket,
            b']' => Punct::RBracket,
            b'<' if two => Punct::Le,
            b'<' => Punct::Lt,
            b'>' if two => Punct::Ge,
            b'>' => Punct::Gt,
            b'!' if two => Punct::Ne,
            b'!' => Punct::Not,
            b'=' => Punct::Eq,
            b'+' => Punct::Plus,
            b'-' => Punct::Minus,
            b'*' => Punct::Star,
            b'/' => Punct::Slash,
            b',' => Punct::Comma,
            b';' => Punct::Semicolon,
            b':' => Punct::Colon,
            b'?' => Punct::Question,
            b'&' => Punct::And,
            b'|' => Punct::Or,
            b'.' => Punct::Dot,
            b'#' => Punct::Hash,
            b'@' | b'^' | b'$' | b'%' | b'~' | b'\'' | b'`' | b'\\' => Punct::Other(c),
            _ => return self.bad(lo, &format!("Illegal character in input file, value is {c:02x}.")),
        };
        if matches!(kind, Punct::Le | Punct::Ge | Punct::Ne) {
            self.at += 1;
        }
        self.push(lo, TokenKind::Punct(kind));
    }
}

fn parse_float(text: &[u8]) -> f64 {
    std::str::from_utf8(text).ok().and_then(|t| t.parse().ok()).unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lang::keyword::Kw;

    fn kinds(text: &str) -> Vec<TokenKind> {
        let mut i = Interner::default();
        lex(FileId(0), text.as_bytes(), true, &mut i).0.into_iter().map(|t| t.kind).collect()
    }

    #[test]
    fn numbers_are_read_as_povray_reads_them() {
        for (text, value) in [("1.", 1.0), (".5", 0.5), ("1e3", 1000.0), ("1.5e-2", 0.015), ("007", 7.0), ("1e", 1.0)] {
            assert_eq!(kinds(text), [TokenKind::Float(value), TokenKind::Eof], "{text}");
        }
        assert!(matches!(kinds("1.2.3")[0], TokenKind::Bad(_)));
        assert_eq!(kinds("5.x"), [TokenKind::Float(5.0), TokenKind::Kw(Kw::X), TokenKind::Eof]);
    }

    #[test]
    fn comments_nest() {
        assert_eq!(kinds("/* a /* b */ c */ 1 // end"), [TokenKind::Float(1.0), TokenKind::Eof]);
        assert!(matches!(kinds("/* open")[0], TokenKind::Bad(_)));
    }
}
