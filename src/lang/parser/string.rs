//! String expressions. Source: spec/language.md, sections 1 and 3.4.

use super::{PResult, Parser};
use crate::lang::keyword::Kw;
use crate::lang::token::{Punct, TokenKind};
use crate::lang::value::Value;
use std::sync::Arc;

/// Longest string, in 16-bit units.
const MAX_UNITS: usize = 1 << 24;

/// Whether a word starts a string.
pub(super) fn is_string_word(k: Kw) -> bool {
    matches!(k, Kw::Str | Kw::Vstr | Kw::Concat | Kw::Chr | Kw::Substr | Kw::Strupr | Kw::Strlwr | Kw::Datetime)
}

impl Parser<'_> {
    /// Whether a string starts here.
    pub(super) fn string_follows(&mut self) -> PResult<bool> {
        let t = self.opened_start()?;
        Ok(match t.kind {
            TokenKind::Str(_) => true,
            TokenKind::Kw(k) => is_string_word(k),
            TokenKind::Element => matches!(self.element, Some(Value::Str(_))),
            TokenKind::Ident(s) => match self.symbols.value(s) {
                Some(Value::Str(_)) => true,
                Some(Value::Array(a)) => matches!(a.items.iter().flatten().next(), Some(Value::Str(_))),
                _ => false,
            },
            _ => false,
        })
    }

    /// A string as text: units past ASCII are kept.
    pub(super) fn parse_text(&mut self) -> PResult<String> {
        Ok(String::from_utf16_lossy(&self.parse_string_units()?))
    }

    /// A file's name: backslashes of a literal are not decoded, units past 127 become blanks.
    pub(super) fn parse_file_name(&mut self) -> PResult<String> {
        let t = self.opened_start()?;
        let text = if let TokenKind::Str(s) = t.kind {
            self.next()?;
            self.interner.text(s)
        } else {
            self.parse_text()?
        };
        Ok(text.chars().map(|c| if c.is_ascii() { c } else { ' ' }).collect())
    }

    /// A string as 16-bit units.
    pub(super) fn parse_string_units(&mut self) -> PResult<Arc<[u16]>> {
        let t = self.opened_start()?;
        match t.kind {
            TokenKind::Str(s) => {
                self.next()?;
                let bytes = self.interner.bytes(s).clone();
                self.decode(&bytes)
            }
            TokenKind::Ident(name) => {
                self.next()?;
                if let Some(place) = self.take_place(name)?
                    && let Some(Value::Str(s)) = self.symbols.value_at(&place)
                {
                    return Ok(s.clone());
                }
                Err(self.expected_instead("string expression", t))
            }
            TokenKind::Element => {
                let value = self.element.clone();
                self.next()?;
                if let Some(Value::Str(s)) = value { Ok(s) } else { Err(self.expected_instead("string expression", t)) }
            }
            TokenKind::Kw(k) if is_string_word(k) => {
                self.next()?;
                self.opened(|p| p.expect(Punct::LParen))?;
                let text = self.opened(|p| p.nested(|p| p.string_function(k)))?;
                self.close_paren()?;
                Ok(text)
            }
            _ => self.expected("string expression"),
        }
    }

    /// A literal's escapes and encoding.
    fn decode(&mut self, bytes: &[u8]) -> PResult<Arc<[u16]>> {
        let mut out = Vec::with_capacity(bytes.len());
        let mut i = 0;
        while i < bytes.len() {
            let c = bytes[i];
            i += 1;
            if c >= 0x80 {
                i = self.decode_high(bytes, i - 1, &mut out);
                continue;
            }
            if c != b'\\' {
                out.push(u16::from(c));
                continue;
            }
            let e = bytes.get(i).copied().unwrap_or(0);
            i += 1;
            out.push(match e {
                b'a' => 7,
                b'b' => 8,
                b'f' => 12,
                b'n' => 10,
                b'r' => 13,
                b't' => 9,
                b'v' => 11,
                b'\\' | b'\'' | b'"' => u16::from(e),
                b'u' => {
                    let hex = bytes.get(i..i + 4).and_then(|h| std::str::from_utf8(h).ok()).and_then(|h| u16::from_str_radix(h, 16).ok());
                    i += 4;
                    hex.ok_or_else(|| self.error("Illegal escape sequence in string."))?
                }
                _ => return Err(self.error("Illegal escape sequence in string.")),
            });
        }
        Ok(out.into())
    }

    /// A character past ASCII at `i`; the index after it.
    fn decode_high(&mut self, bytes: &[u8], i: usize, out: &mut Vec<u16>) -> usize {
        if !self.utf8 {
            self.warn_once("non-ascii", "Possible Parse Error: Non-ASCII character has been replaced by space character.");
            out.push(32);
            return i + 1;
        }
        for n in 2..=4 {
            if let Some(Ok(s)) = bytes.get(i..i + n).map(std::str::from_utf8) {
                let mut units = [0; 2];
                let c = s.chars().next().unwrap_or(' ');
                out.push(if c.len_utf16() == 1 { c.encode_utf16(&mut units)[0] } else { 0xFFFD });
                return i + n;
            }
        }
        out.push(0xFFFD);
        i + 1
    }

    fn string_function(&mut self, k: Kw) -> PResult<Arc<[u16]>> {
        match k {
            Kw::Str => {
                let x = self.parse_float()?;
                self.comma()?;
                let length = self.parse_int()?;
                self.comma()?;
                let precision = self.parse_int()?;
                Ok(format_float(x, length, precision).encode_utf16().collect())
            }
            Kw::Vstr => {
                let n = self.parse_int()?.clamp(2, 5) as usize;
                self.comma()?;
                let v = self.parse_sum()?;
                self.comma()?;
                let separator = self.parse_string_units()?;
                self.comma()?;
                let length = self.parse_int()?;
                self.comma()?;
                let precision = self.parse_int()?;
                let mut out = Vec::new();
                for i in 0..n {
                    if i > 0 {
                        out.extend_from_slice(&separator);
                    }
                    out.extend(format_float(v.v[i], length, precision).encode_utf16());
                }
                Ok(out.into())
            }
            Kw::Concat => {
                let mut out = self.parse_string_units()?.to_vec();
                loop {
                    self.comma()?;
                    if self.at_punct(Punct::RParen)? {
                        self.charge(out.len() * size_of::<u16>())?;
                        return Ok(out.into());
                    }
                    out.extend_from_slice(&self.parse_string_units()?);
                    if out.len() > MAX_UNITS {
                        return Err(self.error(format!("String too long (more than {MAX_UNITS} characters).")));
                    }
                }
            }
            Kw::Chr => {
                let x = self.parse_float()? as i64;
                if !(0..=65_535).contains(&x) {
                    return Err(self.error(format!("Value {x} cannot be used in chr(...).")));
                }
                Ok(if x == 0 { Arc::from([]) } else { Arc::from([x as u16]) })
            }
            Kw::Substr => {
                let s = self.parse_string_units()?;
                self.comma()?;
                let start = self.parse_int()?;
                self.comma()?;
                let length = self.parse_int()?;
                if start < 0 || length < 0 || (start - 1).saturating_add(length) > s.len() as i64 {
                    return Err(self.error("Illegal parameters in substr."));
                }
                // From place 0 nothing comes.
                let Some(lo) = (start as usize).checked_sub(1) else { return Ok([].into()) };
                Ok(s[lo..lo + length as usize].into())
            }
            Kw::Strupr | Kw::Strlwr => {
                let s = self.parse_string_units()?;
                let map = |c: u16| match u8::try_from(c) {
                    Ok(b) if k == Kw::Strupr => u16::from(b.to_ascii_uppercase()),
                    Ok(b) => u16::from(b.to_ascii_lowercase()),
                    Err(_) => c,
                };
                Ok(s.iter().map(|&c| map(c)).collect())
            }
            _ => self.datetime(),
        }
    }

    fn datetime(&mut self) -> PResult<Arc<[u16]>> {
        let days = self.parse_float()?;
        self.comma()?;
        let format = if self.at_punct(Punct::RParen)? { "%Y-%m-%d %H:%M:%SZ".to_owned() } else { self.parse_text()? };
        if format.is_empty() {
            return Err(self.error("Empty format string."));
        }
        if !days.is_finite() || days.abs() > 1e8 {
            return Err(self.error("Invalid date in datetime."));
        }
        Ok(format_date((days * 86_400.0).floor() as i64, &format).chars().take(200).collect::<String>().encode_utf16().collect())
    }
}

/// C's `printf("%[0][L][.P]f")`; `%g` when that would be longer than 254 characters.
pub(super) fn format_float(x: f64, length: i64, precision: i64) -> String {
    let decimals = if precision < 0 { 6 } else { precision.min(300) as usize };
    let width = length.unsigned_abs().min(1000) as usize;
    let sign = if x.is_sign_negative() { "-" } else { "" };
    if !x.is_finite() {
        let word = if x.is_nan() { "nan" } else { "inf" };
        return format!("{:>width$}", format!("{sign}{word}"));
    }
    let mut digits = format!("{:.decimals$}", x.abs());
    if digits.len() + sign.len() > 254 || width > 254 {
        digits = super::files::format_g(x.abs());
    }
    let width = width.min(254);
    if length < 0 {
        format!("{sign}{digits:0>w$}", w = width.saturating_sub(sign.len()))
    } else {
        format!("{:>width$}", format!("{sign}{digits}"))
    }
}

/// `strftime` in UTC for seconds since 2000-01-01.
fn format_date(seconds: i64, format: &str) -> String {
    const MONTHS: [&str; 12] =
        ["January", "February", "March", "April", "May", "June", "July", "August", "September", "October", "November", "December"];
    const DAYS: [&str; 7] = ["Sunday", "Monday", "Tuesday", "Wednesday", "Thursday", "Friday", "Saturday"];
    let (days, rest) = (seconds.div_euclid(86_400), seconds.rem_euclid(86_400));
    let (h, m, s) = (rest / 3600, rest / 60 % 60, rest % 60);
    // Days to a civil date, in eras of 400 years that start on 1 March (Howard Hinnant, "chrono-compatible low-level date algorithms").
    let z = days + 730_425;
    let era = z.div_euclid(146_097);
    let doe = z.rem_euclid(146_097);
    let yoe = (doe - doe / 1460 + doe / 36_524 - doe / 146_096) / 365;
    let doy_march = doe - (365 * yoe + yoe / 4 - yoe / 100);
    let mp = (5 * doy_march + 2) / 153;
    let day = doy_march - (153 * mp + 2) / 5 + 1;
    let month = if mp < 10 { mp + 3 } else { mp - 9 };
    let year = yoe + era * 400 + i64::from(month <= 2);
    let leap = year % 4 == 0 && (year % 100 != 0 || year % 400 == 0);
    let before = [0, 31, 59, 90, 120, 151, 181, 212, 243, 273, 304, 334][month as usize - 1];
    let yday = before + day + i64::from(leap && month > 2);
    let weekday = (days + 6).rem_euclid(7);
    let mut out = String::new();
    let mut chars = format.chars();
    while let Some(c) = chars.next() {
        if c != '%' {
            out.push(c);
            continue;
        }
        match chars.next() {
            Some('Y') => out += &year.to_string(),
            Some('y') => out += &format!("{:02}", year.rem_euclid(100)),
            Some('C') => out += &format!("{:02}", year.div_euclid(100)),
            Some('m') => out += &format!("{month:02}"),
            Some('d') => out += &format!("{day:02}"),
            Some('e') => out += &format!("{day:2}"),
            Some('H') => out += &format!("{h:02}"),
            Some('I') => out += &format!("{:02}", (h + 11) % 12 + 1),
            Some('M') => out += &format!("{m:02}"),
            Some('S') => out += &format!("{s:02}"),
            Some('p') => out += if h < 12 { "AM" } else { "PM" },
            Some('j') => out += &format!("{yday:03}"),
            Some('u') => out += &(if weekday == 0 { 7 } else { weekday }).to_string(),
            Some('w') => out += &weekday.to_string(),
            Some('a') => out += &DAYS[weekday as usize][..3],
            Some('A') => out += DAYS[weekday as usize],
            Some('b' | 'h') => out += &MONTHS[month as usize - 1][..3],
            Some('B') => out += MONTHS[month as usize - 1],
            Some('F') => out += &format!("{year}-{month:02}-{day:02}"),
            Some('D' | 'x') => out += &format!("{month:02}/{day:02}/{:02}", year.rem_euclid(100)),
            Some('T' | 'X') => out += &format!("{h:02}:{m:02}:{s:02}"),
            Some('R') => out += &format!("{h:02}:{m:02}"),
            Some('c') => {
                out +=
                    &format!("{} {} {day:2} {h:02}:{m:02}:{s:02} {year}", &DAYS[weekday as usize][..3], &MONTHS[month as usize - 1][..3]);
            }
            Some('U') => out += &format!("{:02}", (yday - 1 + 7 - weekday) / 7),
            Some('W') => out += &format!("{:02}", (yday - 1 + 7 - (weekday + 6) % 7) / 7),
            Some('Z') => out += "GMT",
            Some('z') => out += "+0000",
            Some('n') => out.push('\n'),
            Some('t') => out.push('\t'),
            Some('%') => out.push('%'),
            Some(other) => {
                out.push('%');
                out.push(other);
            }
            None => out.push('%'),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_written_as_c_writes_them() {
        for (args, text) in [
            ((2.5, 0, 0), "2"),
            ((3.5, 0, 0), "4"),
            ((1.5, 8, 3), "   1.500"),
            ((1.5, -8, 3), "0001.500"),
            ((-1.5, -8, 3), "-001.500"),
            ((-0.1, 0, 0), "-0"),
            ((1.0, 0, -1), "1.000000"),
            ((f64::INFINITY, 0, 3), "inf"),
        ] {
            assert_eq!(format_float(args.0, args.1, args.2), text, "{args:?}");
        }
    }

    #[test]
    fn dates_follow_the_calendar() {
        assert_eq!(format_date(0, "%Y-%m-%d %H:%M:%SZ %A %j"), "2000-01-01 00:00:00Z Saturday 001");
        assert_eq!(format_date(60 * 86_400 - 1, "%F %T"), "2000-02-29 23:59:59");
        assert_eq!(format_date(-86_400, "%F"), "1999-12-31");
    }
}
