//! The .glb container: header, JSON chunk, binary chunk. Source: glTF 2.0, section 4.

use super::super::ImportError;
use std::path::Path;

const MAGIC: &[u8] = b"glTF";
const JSON: &[u8] = b"JSON";
const BIN: &[u8] = b"BIN\0";

/// JSON text and binary chunk of a .glb; a .gltf is all JSON.
pub(super) fn split<'a>(path: &Path, bytes: &'a [u8]) -> Result<(&'a [u8], Option<&'a [u8]>), ImportError> {
    let damaged = |what: String| ImportError::Damaged { path: path.to_owned(), what };
    if !bytes.starts_with(MAGIC) {
        let text = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
        return if text.trim_ascii_start().starts_with(b"{") { Ok((text, None)) } else { Err(damaged("it does not start as glTF".into())) };
    }
    let word = |at: usize| bytes.get(at..at + 4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    let (Some(version), Some(length)) = (word(4), word(8)) else { return Err(damaged("it ends inside its header".into())) };
    if version != 2 {
        return Err(damaged(format!("it is a .glb of version {version}; version 2 is read")));
    }
    let length = length as usize;
    if length > bytes.len() {
        return Err(damaged(format!("it is cut off: {} of {length} bytes are there", bytes.len())));
    }
    let (mut json, mut bin) = (None, None);
    let mut at = 12;
    while at + 8 <= length {
        let size = word(at).expect("eight bytes are left") as usize;
        let kind = &bytes[at + 4..at + 8];
        let Some(chunk) = bytes[..length].get(at + 8..at + 8 + size) else {
            let kind = String::from_utf8_lossy(kind);
            return Err(damaged(format!("its {} chunk claims {size} bytes, {} are left", kind.trim_end_matches('\0'), length - at - 8)));
        };
        match kind {
            JSON if json.is_none() => json = Some(chunk),
            BIN if bin.is_none() => bin = Some(chunk),
            // Unknown chunks are to be ignored.
            _ => {}
        }
        at += 8 + size;
    }
    Ok((json.ok_or_else(|| damaged("it has no JSON chunk".into()))?, bin))
}
