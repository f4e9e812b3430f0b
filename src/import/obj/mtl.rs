//! Material libraries: a tolerant reader. Every key that is known is kept, every other is told once, nothing is an error.

use crate::diag::Sink;
use std::path::{Path, PathBuf};

/// A picture with its options.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct MapRecord {
    /// Where it should be.
    pub file: PathBuf,
    /// `-bm`.
    pub bump: f32,
    /// `-s` and `-o`, u and v.
    pub scale: [f32; 2],
    pub offset: [f32; 2],
    /// `-clamp on`.
    pub clamp: bool,
}

/// A material as its library writes it; what is not written is `None`.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct MtlRecord {
    pub name: String,
    /// Kd.
    pub diffuse: Option<[f32; 3]>,
    /// Ks.
    pub specular: Option<[f32; 3]>,
    /// Ke.
    pub emission: Option<[f32; 3]>,
    /// Tf.
    pub filter: Option<[f32; 3]>,
    /// Ns.
    pub exponent: Option<f32>,
    /// Ni.
    pub ior: Option<f32>,
    /// d, or 1 - Tr.
    pub alpha: Option<f32>,
    pub illum: Option<u32>,
    /// Pr.
    pub roughness: Option<f32>,
    /// Pm.
    pub metallic: Option<f32>,
    pub map_diffuse: Option<MapRecord>,
    pub map_emission: Option<MapRecord>,
    pub map_alpha: Option<MapRecord>,
    pub map_roughness: Option<MapRecord>,
    pub map_metallic: Option<MapRecord>,
    /// norm, map_Bump, bump: normals or heights, as the picture tells.
    pub map_bump: Option<MapRecord>,
}

/// The materials of a library.
pub(super) fn parse(path: &Path, bytes: &[u8], sink: &mut Sink) -> Vec<MtlRecord> {
    let mut out: Vec<MtlRecord> = Vec::new();
    for line in String::from_utf8_lossy(bytes).lines() {
        let line = line.trim();
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let (key, rest) = line.split_once(char::is_whitespace).map_or((line, ""), |(k, r)| (k, r.trim()));
        if key.eq_ignore_ascii_case("newmtl") {
            out.push(MtlRecord { name: rest.to_owned(), ..MtlRecord::default() });
        } else if let Some(record) = out.last_mut() {
            statement(path, record, key, rest, sink);
        }
    }
    out
}

fn statement(path: &Path, m: &mut MtlRecord, key: &str, rest: &str, sink: &mut Sink) {
    let number = || rest.split_whitespace().next().and_then(|w| w.parse::<f32>().ok()).filter(|v| v.is_finite());
    let lower = key.to_ascii_lowercase();
    let left_out = |sink: &mut Sink| {
        sink.note_once(
            &format!("mtl: {lower}"),
            None,
            format!("'{key}' of material libraries is left out (first in material '{}')", m.name),
        );
    };
    match lower.as_str() {
        "kd" => m.diffuse = color(rest).or(m.diffuse),
        "ks" => m.specular = color(rest).or(m.specular),
        "ke" => m.emission = color(rest).or(m.emission),
        "tf" => m.filter = color(rest).or(m.filter),
        "ns" => m.exponent = number(),
        "ni" => m.ior = number(),
        // "d -halo 0.5" has its number last.
        "d" => m.alpha = rest.split_whitespace().last().and_then(|w| w.parse().ok()).filter(|v: &f32| v.is_finite()).or(m.alpha),
        "tr" => m.alpha = m.alpha.or(number().map(|v| 1.0 - v)),
        "illum" => m.illum = number().map(|v| v.max(0.0) as u32),
        "pr" => m.roughness = number(),
        "pm" => m.metallic = number(),
        // Light from everywhere: computed, not painted on.
        "ka" | "map_ka" => {}
        "map_kd" => m.map_diffuse = map(path, rest),
        "map_ke" => m.map_emission = map(path, rest),
        "map_d" => m.map_alpha = map(path, rest),
        "map_pr" => m.map_roughness = map(path, rest),
        "map_pm" => m.map_metallic = map(path, rest),
        "norm" | "map_bump" | "bump" | "map_norm" | "map_kn" => m.map_bump = map(path, rest),
        // Zero is "none of it": nothing is lost.
        "ps" | "pc" | "aniso" if number().unwrap_or(0.0) == 0.0 => {}
        // They only matter beside Pc and aniso, which are told.
        "pcr" | "anisor" => {}
        _ => left_out(sink),
    }
}

/// Three numbers, or one for all.
fn color(rest: &str) -> Option<[f32; 3]> {
    let list: Vec<f32> = rest.split_whitespace().map_while(|w| w.parse().ok()).collect();
    match list[..] {
        [r, g, b, ..] => Some([r, g, b]),
        [v] => Some([v; 3]),
        _ => None,
    }
    .filter(|c| c.iter().all(|v| v.is_finite()))
}

/// Options, then a file name that may hold spaces.
fn map(library: &Path, mut rest: &str) -> Option<MapRecord> {
    let mut m = MapRecord { file: PathBuf::new(), bump: 1.0, scale: [1.0; 2], offset: [0.0; 2], clamp: false };
    while let Some((option, after)) = rest.strip_prefix('-').map(|r| r.split_once(char::is_whitespace).unwrap_or((r, ""))) {
        rest = after.trim_start();
        match option {
            "bm" => m.bump = word(&mut rest).and_then(|w| w.parse().ok()).unwrap_or(1.0),
            "s" => m.scale = numbers(&mut rest, 1.0),
            "o" => m.offset = numbers(&mut rest, 0.0),
            "t" => {
                numbers(&mut rest, 0.0);
            }
            "mm" => {
                word(&mut rest);
                word(&mut rest);
            }
            "clamp" => m.clamp = word(&mut rest) == Some("on"),
            // -blendu, -blendv, -boost, -cc, -imfchan, -texres, -type and unknown ones: one argument.
            _ => {
                word(&mut rest);
            }
        }
    }
    let name = rest.trim().trim_matches('"');
    if name.is_empty() {
        return None;
    }
    m.file = super::file_beside(library, name);
    Some(m)
}

/// Takes the next word.
fn word<'t>(rest: &mut &'t str) -> Option<&'t str> {
    let (w, after) = rest.split_once(char::is_whitespace).unwrap_or((rest, ""));
    *rest = after.trim_start();
    (!w.is_empty()).then_some(w)
}

/// Takes one to three numbers; the first two count.
fn numbers(rest: &mut &str, default: f32) -> [f32; 2] {
    let mut out = [default; 2];
    for k in 0..3 {
        let mut after = *rest;
        // The last word is the file's name, even "2".
        let Some(v) = word(&mut after).and_then(|w| w.parse::<f32>().ok()).filter(|v| v.is_finite() && !after.is_empty()) else { break };
        if k < 2 {
            out[k] = v;
        }
        *rest = after;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn one(text: &str) -> (MtlRecord, Sink) {
        let mut sink = Sink::default();
        let list = parse(Path::new("a/b.mtl"), format!("newmtl Some name\n{text}").as_bytes(), &mut sink);
        assert_eq!(list[0].name, "Some name");
        (list[0].clone(), sink)
    }

    #[test]
    fn map_options_end_where_a_file_name_with_spaces_begins() {
        let (m, _) = one("map_Bump -bm 0.5 -s 2 3 1 -o 0.25 0 0 -clamp on brick wall 2.png");
        let want = MapRecord { file: "a/brick wall 2.png".into(), bump: 0.5, scale: [2.0, 3.0], offset: [0.25, 0.0], clamp: true };
        assert_eq!(m.map_bump, Some(want));
        let (m, _) = one("map_Kd -s 4 -mm 0 1 -imfchan r 7.png\nmap_Ke");
        assert_eq!(m.map_diffuse.map(|m| (m.file, m.scale)), Some(("a/7.png".into(), [4.0, 1.0])));
        assert_eq!(m.map_emission, None);
    }

    #[test]
    fn known_keys_are_kept_and_unknown_ones_told_once() {
        let (m, sink) =
            one("Kd 0.1 0.2 0.3\nKs 0.5\nPr 0.25\nPm 1\nTr 0.25\nillum 7\nNi 1.33\nmap_refl sky.hdr\nPc 0\nPc 0.5\nWhat 1\nWhat 2\nKd x");
        assert_eq!((m.diffuse, m.specular), (Some([0.1, 0.2, 0.3]), Some([0.5; 3])));
        assert_eq!((m.roughness, m.metallic, m.alpha, m.illum, m.ior), (Some(0.25), Some(1.0), Some(0.75), Some(7), Some(1.33)));
        let said: Vec<&str> = sink.items().iter().map(|d| d.message.as_str()).collect();
        assert_eq!(said.len(), 3, "{said:?}");
        assert!(said[0].contains("map_refl") && said[1].contains("Pc") && said[2].contains("What"));
    }

    #[test]
    fn d_rules_over_tr_whatever_their_order() {
        assert_eq!(one("d 0.5\nTr 0.9").0.alpha, Some(0.5));
        assert_eq!(one("Tr 0.9\nd 0.5").0.alpha, Some(0.5));
        assert_eq!(one("d -halo 0.25").0.alpha, Some(0.25));
    }
}
