//! Tokens of the scene language.

use super::keyword::Kw;
use crate::diag::Span;

/// An interned name or string; see [`super::intern::Interner`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Symbol(pub u32);

/// What a token is. Errors of the lexer are tokens too: they matter only when the parser reaches them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TokenKind {
    /// A reserved word.
    Kw(Kw),
    /// A name.
    Ident(Symbol),
    /// A number.
    Float(f64),
    /// A string literal between quotes, raw.
    Str(Symbol),
    /// Punctuation.
    Punct(Punct),
    /// An array's element, subscripts read and value looked up; the parser holds the value until the token is taken.
    Element,
    /// Something that cannot be read; the symbol is the message.
    Bad(Symbol),
    /// The end of the text.
    Eof,
}

/// Punctuation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "the names say it")]
pub enum Punct {
    LBrace,
    RBrace,
    LParen,
    RParen,
    LBracket,
    RBracket,
    Lt,
    Le,
    Gt,
    Ge,
    Eq,
    Ne,
    Plus,
    Minus,
    Star,
    Slash,
    Comma,
    Semicolon,
    Colon,
    Question,
    Not,
    And,
    Or,
    Dot,
    Hash,
    /// A character with no use (`@ ^ $ % ~ ' \``).
    Other(u8),
}

impl Punct {
    /// As POV-Ray writes it in messages.
    pub fn text(self) -> String {
        use Punct::*;
        match self {
            LBrace => "{",
            RBrace => "}",
            LParen => "(",
            RParen => ")",
            LBracket => "[",
            RBracket => "]",
            Lt => "<",
            Le => "<=",
            Gt => ">",
            Ge => ">=",
            Eq => "=",
            Ne => "!=",
            Plus => "+",
            Minus => "-",
            Star => "*",
            Slash => "/",
            Comma => ",",
            Semicolon => ";",
            Colon => ":",
            Question => "?",
            Not => "!",
            And => "&",
            Or => "|",
            Dot => ". (period)",
            Hash => "#",
            Other(c) => return (c as char).to_string(),
        }
        .to_owned()
    }
}

/// A token with its place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Token {
    /// What it is.
    pub kind: TokenKind,
    /// Where it stands.
    pub span: Span,
}
