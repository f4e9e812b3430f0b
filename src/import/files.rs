//! Files of a model: the file itself and those that it names, and data inside names (`data:` URIs).

use super::ImportError;
use std::path::{Path, PathBuf};

/// Largest file that is read, in bytes: indices of larger ones would not fit in 32 bits.
const MAX_FILE_SIZE: u64 = 4 << 30;

/// A whole file that is not empty.
pub(super) fn read(path: &Path) -> Result<Vec<u8>, ImportError> {
    let failed = |source| ImportError::Read { path: path.to_owned(), source };
    let meta = std::fs::metadata(path).map_err(failed)?;
    if !meta.is_file() {
        return Err(ImportError::NotAFile(path.to_owned()));
    }
    if meta.len() > MAX_FILE_SIZE {
        return Err(ImportError::TooLarge { path: path.to_owned(), size: meta.len(), limit: MAX_FILE_SIZE });
    }
    let bytes = std::fs::read(path).map_err(failed)?;
    if bytes.is_empty() { Err(ImportError::Empty(path.to_owned())) } else { Ok(bytes) }
}

/// Where a URI of a glTF file leads.
#[derive(Debug, PartialEq)]
pub(super) enum Target {
    /// The bytes stand in the URI.
    Data(Vec<u8>),
    /// A file beside the model.
    File(PathBuf),
}

/// Resolves a URI relative to the folder of `model`; the reason when it leads nowhere.
pub(super) fn resolve(model: &Path, uri: &str) -> Result<Target, String> {
    if let Some(rest) = uri.strip_prefix("data:") {
        let (kind, data) = rest.split_once(',').ok_or("a data URI without a comma")?;
        if !kind.ends_with(";base64") {
            return Ok(Target::Data(percent_decoded(data)));
        }
        return decode_base64(data.as_bytes()).map(Target::Data).ok_or_else(|| "broken base64 data".into());
    }
    // "C:/x.bin" is a path, "http://" is not.
    if let Some((scheme, _)) = uri.split_once("://") {
        return Err(format!("{scheme} addresses are not read"));
    }
    let name = String::from_utf8(percent_decoded(uri)).map_err(|_| "a name that is not UTF-8")?;
    if name.is_empty() || name.contains('\0') {
        return Err("an empty or impossible file name".into());
    }
    Ok(Target::File(beside(model, &name)))
}

/// `name` relative to the folder of `model`.
pub(super) fn beside(model: &Path, name: &str) -> PathBuf {
    model.parent().unwrap_or(Path::new("")).join(name)
}

fn percent_decoded(s: &str) -> Vec<u8> {
    let b = s.as_bytes();
    let hex = |k: usize| b.get(k).and_then(|c| (*c as char).to_digit(16)).map(|d| d as u8);
    let (mut out, mut k) = (Vec::with_capacity(b.len()), 0);
    while k < b.len() {
        match (b[k], hex(k + 1), hex(k + 2)) {
            (b'%', Some(high), Some(low)) => {
                out.push(16 * high + low);
                k += 3;
            }
            (c, ..) => {
                out.push(c);
                k += 1;
            }
        }
    }
    out
}

/// Standard or URL alphabet, padding and white space optional. Source: RFC 4648.
fn decode_base64(text: &[u8]) -> Option<Vec<u8>> {
    let mut out = Vec::with_capacity(text.len() / 4 * 3);
    let (mut bits, mut n_bits) = (0u32, 0);
    for c in text.iter().filter(|c| !c.is_ascii_whitespace() && **c != b'=') {
        let value = match c {
            b'A'..=b'Z' => c - b'A',
            b'a'..=b'z' => c - b'a' + 26,
            b'0'..=b'9' => c - b'0' + 52,
            b'+' | b'-' => 62,
            b'/' | b'_' => 63,
            _ => return None,
        };
        bits = (bits << 6) | u32::from(value);
        n_bits += 6;
        if n_bits >= 8 {
            n_bits -= 8;
            out.push((bits >> n_bits) as u8);
            bits &= (1 << n_bits) - 1;
        }
    }
    Some(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn data_uris_are_decoded_and_broken_ones_refused() {
        let model = Path::new("models/x.gltf");
        let data = |uri| resolve(model, uri);
        assert_eq!(data("data:application/octet-stream;base64,SGVsbG8="), Ok(Target::Data(b"Hello".to_vec())));
        assert_eq!(data("data:;base64,SGVsbG8"), Ok(Target::Data(b"Hello".to_vec())));
        assert_eq!(data("data:text/plain,a%20b"), Ok(Target::Data(b"a b".to_vec())));
        assert!(data("data:;base64,SG?s").is_err());
        assert!(data("data:nothing").is_err());
    }

    #[test]
    fn names_are_percent_decoded_beside_the_model_and_addresses_refused() {
        let model = Path::new("models/x.gltf");
        assert_eq!(resolve(model, "my%20tex.png"), Ok(Target::File(PathBuf::from("models/my tex.png"))));
        assert_eq!(resolve(model, "100%.png"), Ok(Target::File(PathBuf::from("models/100%.png"))));
        assert!(resolve(model, "https://example.com/a.bin").is_err());
        assert!(resolve(model, "").is_err());
    }
}
