//! Architecture invariants that the compiler does not check: ranks of rooms, file headers, leftovers,
//! references without scenes and scenes without references.

use std::path::{Path, PathBuf};

/// Rooms by rank, as ARCHITECTURE.md lists them: a room imports lower ranks, and itself, only.
const RANKS: &[(&str, u8)] = &[
    ("math", 0),
    ("memory", 0),
    ("cpu_time", 0),
    ("savings", 0),
    ("user_folders", 0),
    ("accel", 1),
    ("diag", 1),
    ("world", 2),
    ("scene", 3),
    ("lang", 4),
    ("import", 4),
    ("compile", 6),
    ("kernel", 7),
    ("film", 7),
    ("denoise", 8),
    ("integrate", 8),
    ("backend", 9),
    ("compare", 10),
    ("bench", 12),
    ("job", 11),
    ("suite", 11),
];

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

fn files_under(dir: &Path, extension: &str, out: &mut Vec<PathBuf>) {
    let Ok(entries) = std::fs::read_dir(dir) else { return };
    for e in entries {
        let path = e.expect("a readable tree").path();
        if path.is_dir() {
            files_under(&path, extension, out);
        } else if path.extension().is_some_and(|x| x == extension) {
            out.push(path);
        }
    }
}

fn sources(dir: &str, extension: &str) -> Vec<(String, String)> {
    let mut paths = Vec::new();
    files_under(&root().join(dir), extension, &mut paths);
    paths.sort();
    paths
        .into_iter()
        .map(|p| {
            let text = std::fs::read_to_string(&p).expect("a readable source file");
            (p.strip_prefix(root()).expect("inside the tree").display().to_string(), text)
        })
        .collect()
}

fn rank_of(room: &str) -> Option<u8> {
    RANKS.iter().find(|(name, _)| *name == room).map(|&(_, rank)| rank)
}

/// The room of a path like `src/lang/lexer.rs` or `src/world.rs`.
fn room_of(path: &str) -> &str {
    path.trim_start_matches("src/").split(['/', '.']).next().unwrap_or("")
}

/// Every `crate::room` that a file outside its tests names above its own rank.
fn rank_violations(path: &str, text: &str) -> Vec<String> {
    let Some(own) = rank_of(room_of(path)) else { return Vec::new() };
    let mut found = Vec::new();
    for (n, line) in text.lines().enumerate() {
        if line.trim_start().starts_with("#[cfg(test)]") {
            break;
        }
        let code = line.split("//").next().unwrap_or("");
        for part in code.split("crate::").skip(1) {
            let names: Vec<&str> = match part.strip_prefix('{') {
                Some(list) => {
                    list.split(['}', ';']).next().unwrap_or("").split(',').map(|s| s.trim().split("::").next().unwrap_or("")).collect()
                }
                None => vec![part.split(|c: char| !c.is_alphanumeric() && c != '_').next().unwrap_or("")],
            };
            for name in names {
                if rank_of(name).is_some_and(|r| r > own || (r == own && name != room_of(path))) {
                    found.push(format!("{path}:{}: rank {own} imports {name}", n + 1));
                }
            }
        }
    }
    found
}

#[test]
fn rooms_import_lower_ranks_only() {
    let bad: Vec<String> = sources("src", "rs").iter().flat_map(|(p, t)| rank_violations(p, t)).collect();
    assert!(bad.is_empty(), "{}", bad.join("\n"));
}

#[test]
fn a_rank_violation_is_caught() {
    assert_eq!(rank_violations("src/math/noise.rs", "use crate::scene::Scene;\n").len(), 1);
    assert_eq!(rank_violations("src/lang/lexer.rs", "use crate::{math::Ray, kernel::intersect};\n").len(), 1);
    assert!(rank_violations("src/kernel/finish.rs", "use crate::compile::Layer;\n").is_empty());
}

#[test]
fn every_module_is_ranked() {
    let lib = std::fs::read_to_string(root().join("src/lib.rs")).expect("src/lib.rs");
    for line in lib.lines().filter_map(|l| l.strip_prefix("pub mod ")) {
        let name = line.split(';').next().unwrap_or("");
        assert!(rank_of(name).is_some(), "src/lib.rs declares {name}, which has no rank here");
    }
}

#[test]
fn every_source_file_says_what_it_is_for() {
    let headless: Vec<String> = sources("src", "rs").into_iter().filter(|(_, t)| !t.starts_with("//!")).map(|(p, _)| p).collect();
    assert!(headless.is_empty(), "no //! on line 1: {headless:?}");
    let silent: Vec<String> = sources("shaders", "wgsl")
        .into_iter()
        .chain(sources("shaders", "wesl"))
        .filter(|(_, t)| !t.starts_with("//"))
        .map(|(p, _)| p)
        .collect();
    assert!(silent.is_empty(), "no comment on line 1: {silent:?}");
}

#[test]
fn nothing_is_left_unfinished_in_the_code() {
    let words = ["todo!(", "unimplemented!(", concat!("FIX", "ME"), concat!("TO", "DO"), "dbg!("];
    let mut bad = Vec::new();
    for (path, text) in sources("src", "rs").iter().chain(&sources("shaders", "wgsl")).chain(&sources("shaders", "wesl")) {
        for (n, line) in text.lines().enumerate() {
            if words.iter().any(|w| line.contains(w)) {
                bad.push(format!("{path}:{}: {}", n + 1, line.trim()));
            }
        }
    }
    assert!(bad.is_empty(), "{}", bad.join("\n"));
}

#[test]
fn every_reference_has_its_case_and_every_scene_is_one() {
    let suite = rayloom::suite::Suite::open(&root().join("tests/scenes")).expect("a suite");
    assert_eq!(suite.loose, Vec::<String>::new(), "scenes without a test.toml");
    assert_eq!(suite.unused_references().expect("readable references"), Vec::<String>::new(), "references that no case asks for");
}
