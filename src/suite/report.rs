//! The report: one HTML page without network. Pictures are in the page as text that is decoded when it is looked at, or, on request, in a
//! folder beside it; equal pictures are there once.

use super::error::SuiteError;
use super::results::{CaseResult, SuiteResults};
use crate::compare::{DEFAULT_MAX_PIXELS, Picture};
use base64::Engine;
use rayon::prelude::*;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

const PAGE: &str = include_str!("report/page.html");
const STYLE: &str = include_str!("report/style.css");
const SCRIPTS: [&str; 4] =
    [include_str!("report/pictures.js"), include_str!("report/list.js"), include_str!("report/detail.js"), include_str!("report/main.js")];

/// What the page needs to know besides the results.
pub struct ReportOptions<'o> {
    /// File of the page.
    pub path: &'o Path,
    /// Pictures stand in a folder beside the page, as scripts: pages of files may not read pictures, but may run those.
    pub sidecar: bool,
    /// What the user types to run the suite: "rayloom suite tests/scenes".
    pub command: String,
}

/// Writes the page.
pub fn write(results: &SuiteResults, options: &ReportOptions) -> Result<(), SuiteError> {
    let mut paths: Vec<&Path> = results.cases.iter().flat_map(pictures).collect();
    paths.sort();
    paths.dedup();
    // By file its name in the page; a file that cannot be read has none.
    let encoded: Vec<(PathBuf, String, Vec<u8>)> = paths
        .par_iter()
        .filter_map(|p| {
            let bytes = as_png(p)?;
            Some((p.to_path_buf(), format!("{:016x}", crate::film::state::checksum(&bytes)), bytes))
        })
        .collect();
    let names: BTreeMap<&Path, &str> = encoded.iter().map(|(p, n, _)| (p.as_path(), n.as_str())).collect();
    let unique: BTreeMap<&str, &[u8]> = encoded.iter().map(|(_, n, b)| (n.as_str(), b.as_slice())).collect();
    let stem = options.path.file_stem().unwrap_or_default().to_string_lossy();
    let folder = format!("{stem}_pictures");
    let data = json!({
        "title": results.title, "program": results.program, "gpu": results.gpu, "started": results.started, "seconds": results.seconds,
        "jobs": results.jobs, "faults": results.faults, "notes": results.notes, "command": options.command,
        "sidecar": options.sidecar.then_some(&folder),
        "cases": results.cases.iter().map(|c| case_data(c, &names)).collect::<Vec<_>>(),
    });
    let base64 = |bytes: &[u8]| base64::engine::general_purpose::STANDARD.encode(bytes);
    let mut stored = String::new();
    if options.sidecar {
        let folder = options.path.with_file_name(&folder);
        std::fs::create_dir_all(&folder).map_err(SuiteError::io("write", &folder))?;
        unique.par_iter().try_for_each(|(name, bytes)| {
            let path = folder.join(format!("{name}.js"));
            std::fs::write(&path, format!("pictureArrived(\"{name}\",\"{}\")", base64(bytes))).map_err(SuiteError::io("write", &path))
        })?;
    } else {
        for (name, bytes) in &unique {
            stored.push_str(&format!("<script type=\"text/plain\" id=\"p{name}\">{}</script>\n", base64(bytes)));
        }
    }
    let page = fill(
        PAGE,
        &[
            ("TITLE", &html(&results.title)),
            ("STYLE", STYLE),
            ("PICTURES", &stored),
            // A script ends at the first "</script", whatever it is inside of.
            ("DATA", &data.to_string().replace("</", "<\\/")),
            ("SCRIPTS", &SCRIPTS.concat()),
        ],
    );
    if let Some(folder) = options.path.parent() {
        std::fs::create_dir_all(folder).map_err(SuiteError::io("write", folder))?;
    }
    std::fs::write(options.path, page).map_err(SuiteError::io("write", options.path))
}

/// Replaces each `@NAME@` once; what is put in is not searched again.
fn fill(page: &str, values: &[(&str, &str)]) -> String {
    let mut out = String::new();
    let mut rest = page;
    for (name, value) in values {
        let (before, after) = rest.split_once(&format!("@{name}@")).expect("the page has each place, in this order");
        out.push_str(before);
        out.push_str(value);
        rest = after;
    }
    out + rest
}

/// All pictures of a case.
fn pictures(c: &CaseResult) -> impl Iterator<Item = &Path> {
    c.pairs.iter().flat_map(|p| [p.ours.as_path(), &p.theirs]).chain(c.pictures.iter().map(|(_, p)| p.as_path())).filter(|p| p.is_file())
}

fn case_data(c: &CaseResult, names: &BTreeMap<&Path, &str>) -> Value {
    let mut value = serde_json::to_value(c).unwrap_or_default();
    let name = |p: &Path| names.get(p).copied();
    for (v, p) in value["pairs"].as_array_mut().into_iter().flatten().zip(&c.pairs) {
        v["ours"] = json!(name(&p.ours));
        v["theirs"] = json!(name(&p.theirs));
        v["file"] = json!(p.theirs);
    }
    value["pictures"] = json!(c.pictures.iter().map(|(m, p)| json!([m, name(p)])).collect::<Vec<_>>());
    if let Some(map) = value.as_object_mut() {
        map.remove("key");
    }
    value
}

/// The bytes of an 8-bit PNG of a picture as it is shown; a file that is one is taken as it is.
fn as_png(path: &Path) -> Option<Vec<u8>> {
    let bytes = std::fs::read(path).ok()?;
    // Depth of samples: byte 24 of a PNG.
    if bytes.starts_with(b"\x89PNG") && bytes.get(24).is_some_and(|d| *d <= 8) {
        return Some(bytes);
    }
    let p = Picture::read(path, DEFAULT_MAX_PIXELS).ok()?.into_display();
    let byte = |v: f32| (v.clamp(0.0, 1.0) * 255.0).round() as u8;
    let image = image::RgbImage::from_fn(p.width, p.height, |x, y| {
        let v = p.pixels[y as usize * p.width as usize + x as usize];
        image::Rgb([byte(v[0]), byte(v[1]), byte(v[2])])
    });
    let mut out = std::io::Cursor::new(Vec::new());
    image.write_to(&mut out, image::ImageFormat::Png).ok()?;
    Some(out.into_inner())
}

fn html(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}
