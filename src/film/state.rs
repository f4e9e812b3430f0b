//! The finished pixels of an unfinished picture, so that another run can go on from them.
//!
//! A file is `MAGIC`, the fingerprint (length and bytes), width and height, runs of finished pixels (first, count, then samples and
//! four floats of each, then the values of its passes), and a checksum over all of it; numbers are little-endian.

use super::replace_file;
use super::{Film, FilmError};
use crate::scene::{Pass, PassSet};
use std::path::{Path, PathBuf};

const MAGIC: &[u8; 16] = b"rayloom state 2\n";
/// Bytes of a pixel.
const PIXEL: usize = 20;

/// Where the state of the picture at `path` is kept: `<name>.rayloom-state` beside it.
pub fn path_for(path: &Path) -> PathBuf {
    path.with_extension("rayloom-state")
}

/// Writes the finished pixels of `film`. `fingerprint` stands for scene and settings: only the same job takes them up again.
pub fn save(path: &Path, film: &Film, fingerprint: &str) -> Result<(), FilmError> {
    let mut out = MAGIC.to_vec();
    out.extend((fingerprint.len() as u32).to_le_bytes());
    out.extend(fingerprint.bytes());
    out.extend(film.width.to_le_bytes());
    out.extend(film.height.to_le_bytes());
    out.extend((film.layers.len() as u32).to_le_bytes());
    out.extend(film.layers.iter().flat_map(|l| (l.pass as u32).to_le_bytes()));
    let mut first = 0;
    while first < film.samples.len() {
        let finished = film.samples[first] > 0;
        let len = film.samples[first..].iter().take_while(|n| (**n > 0) == finished).count();
        if finished {
            out.extend((first as u64).to_le_bytes());
            out.extend((len as u64).to_le_bytes());
            for i in first..first + len {
                out.extend(film.samples[i].to_le_bytes());
                out.extend(film.pixels[i].iter().flat_map(|v| v.to_le_bytes()));
                out.extend(film.layers.iter().flat_map(|l| l.at(i)).flat_map(|v| v.to_le_bytes()));
            }
        }
        first += len;
    }
    out.extend(checksum(&out).to_le_bytes());
    replace_file(path, &out)
}

/// The film that [`save`] wrote for the same job.
pub fn load(path: &Path, fingerprint: &str) -> Result<Film, FilmError> {
    let bytes = std::fs::read(path).map_err(|e| FilmError::io("read", path, e))?;
    decode(&bytes, fingerprint).map_err(|reason| FilmError::Foreign { path: path.to_owned(), reason: reason.into() })
}

fn decode(bytes: &[u8], fingerprint: &str) -> Result<Film, &'static str> {
    const CUT: &str = "the saved state is damaged or cut off; delete it to render from the start";
    if !bytes.starts_with(MAGIC) {
        return Err("this is no saved state of rayloom");
    }
    let (body, sum) = bytes.split_last_chunk::<8>().ok_or(CUT)?;
    if checksum(body) != u64::from_le_bytes(*sum) {
        return Err(CUT);
    }
    let mut rest = &body[MAGIC.len()..];
    let mut take = |n: usize| {
        let (head, tail) = rest.split_at_checked(n)?;
        rest = tail;
        Some(head)
    };
    let word = |b: &[u8]| b.iter().rev().fold(0u64, |v, b| v << 8 | u64::from(*b));
    let len = take(4).map(word).ok_or(CUT)? as usize;
    if take(len).ok_or(CUT)? != fingerprint.as_bytes() {
        return Err("the saved state belongs to another scene or other settings; delete it to render from the start");
    }
    let (width, height) = (take(4).map(word).ok_or(CUT)? as u32, take(4).map(word).ok_or(CUT)? as u32);
    let n_layers = take(4).map(word).ok_or(CUT)?;
    let mut passes = PassSet::NONE;
    for _ in 0..n_layers {
        let ix = take(4).map(word).ok_or(CUT)?;
        passes = passes.with(Pass::all().find(|p| *p as u64 == ix).ok_or(CUT)?);
    }
    let mut film = Film::with_passes(width, height, passes);
    while let Some(first) = take(8).map(word) {
        let n = take(8).map(word).ok_or(CUT)?;
        let range = first as usize..first.checked_add(n).ok_or(CUT)? as usize;
        if range.end > film.samples.len() {
            return Err(CUT);
        }
        for i in range {
            let pixel = take(PIXEL).ok_or(CUT)?;
            film.samples[i] = word(&pixel[..4]) as u32;
            film.pixels[i] = std::array::from_fn(|c| f32::from_bits(word(&pixel[4 + 4 * c..8 + 4 * c]) as u32));
            for l in &mut film.layers {
                let w = l.pass.width();
                let bytes = take(4 * w).ok_or(CUT)?;
                l.values[i * w..(i + 1) * w].iter_mut().zip(bytes.chunks(4)).for_each(|(v, b)| *v = f32::from_bits(word(b) as u32));
            }
        }
    }
    Ok(film)
}

/// FNV-1a over words of eight bytes: finds what a full disk or a killed program leaves behind.
pub fn checksum(bytes: &[u8]) -> u64 {
    bytes.chunks(8).fold(0xcbf2_9ce4_8422_2325, |h, word| {
        let word = word.iter().rev().fold(0u64, |v, b| v << 8 | u64::from(*b));
        (h ^ word).wrapping_mul(0x0000_0100_0000_01b3).rotate_left(29)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn film() -> Film {
        let mut film = Film::with_passes(5, 3, [Pass::Depth, Pass::CryptoObject].into_iter().collect());
        for i in [0, 1, 4, 5, 6, 14] {
            film.samples[i] = i as u32 + 1;
            film.pixels[i] = [i as f32, -0.5, f32::MAX, 1.0];
            film.layers[0].values[i] = 3.5;
            film.layers[1].values[12 * i + 11] = i as f32;
        }
        film
    }

    #[test]
    fn finished_pixels_come_back_and_others_have_no_samples() {
        let dir = tempfile::tempdir().expect("a folder");
        let path = path_for(&dir.path().join("a.png"));
        save(&path, &film(), "scene 1").expect("written");
        assert_eq!(load(&path, "scene 1").expect("read"), film());
    }

    #[test]
    fn foreign_cut_or_changed_states_are_errors() {
        let dir = tempfile::tempdir().expect("a folder");
        let path = dir.path().join("a.rayloom-state");
        save(&path, &film(), "scene 1").expect("written");
        let message = |r: Result<Film, FilmError>| r.expect_err("an error").to_string();
        assert!(message(load(&path, "scene 2")).contains("another scene"));
        let whole = std::fs::read(&path).expect("bytes");
        for n in 0..whole.len() {
            std::fs::write(&path, &whole[..n]).expect("written");
            assert!(load(&path, "scene 1").is_err(), "cut to {n} bytes");
        }
        for i in 0..whole.len() {
            let mut changed = whole.clone();
            changed[i] ^= 4;
            std::fs::write(&path, &changed).expect("written");
            assert!(load(&path, "scene 1").is_err(), "byte {i}");
        }
        std::fs::write(&path, "hello").expect("written");
        assert!(message(load(&path, "scene 1")).contains("no saved state"));
    }
}
