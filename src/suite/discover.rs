//! From a folder to its cases: every folder with a `test.toml` is one. What belongs to no case is told.

use super::error::SuiteError;
use super::spec::{CaseFile, Machine, PictureKind, SuiteFile, read_case_file, read_suite_file};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// A suite: its root, what its cases share, and the cases in order of their names.
#[derive(Clone, Debug)]
pub struct Suite {
    /// Folder of `suite.toml`.
    pub root: PathBuf,
    /// What all cases share.
    pub file: SuiteFile,
    /// All cases.
    pub cases: Vec<Case>,
    /// Scenes without a `test.toml`, by path from the root.
    pub loose: Vec<String>,
}

/// One case.
#[derive(Clone, Debug)]
pub struct Case {
    /// `area/case`.
    pub name: String,
    /// Its folder.
    pub folder: PathBuf,
    /// File name of its scene, in the folder.
    pub scene: PathBuf,
    /// What it shows.
    pub about: String,
    /// Its `test.toml`.
    pub file: CaseFile,
    /// Width and height.
    pub size: [u32; 2],
}

/// Extensions of files that can be a case's scene, the first the most likely.
const SCENES: [&str; 5] = ["pov", "ini", "glb", "gltf", "obj"];
/// Files of a reference folder that belong to no case by themselves.
const NOT_REFERENCES: [&str; 2] = ["md", "txt~"];

impl Suite {
    /// Reads the suite in `root`.
    ///
    /// # Errors
    /// Unreadable folders, wrong `suite.toml` or `test.toml` files, fewer cases than `cases_at_least`.
    pub fn open(root: &Path) -> Result<Self, SuiteError> {
        let file = read_suite_file(&root.join("suite.toml"))?;
        let mut suite = Self { root: root.to_owned(), file, cases: Vec::new(), loose: Vec::new() };
        let references = suite.references_root();
        let mut paths = Vec::new();
        walk(root, &references, &mut paths)?;
        paths.sort();
        let folders: BTreeSet<&Path> =
            paths.iter().filter(|p| p.file_name().is_some_and(|n| n == "test.toml")).filter_map(|p| p.parent()).collect();
        for folder in &folders {
            suite.cases.push(suite.read_case(folder)?);
        }
        for path in paths.iter().filter(|p| has_extension(p, &SCENES) && !p.ancestors().any(|a| folders.contains(a))) {
            suite.loose.push(relative(path, root));
        }
        if suite.cases.len() < suite.file.cases_at_least {
            let message = format!("{} cases are there, cases_at_least says {}", suite.cases.len(), suite.file.cases_at_least);
            return Err(SuiteError::spec(&root.join("suite.toml"), message));
        }
        Ok(suite)
    }

    /// Where all reference pictures are.
    pub fn references_root(&self) -> PathBuf {
        self.root.join(&self.file.references_root)
    }

    /// File of a reference, without its extension.
    pub fn reference_stem(&self, kind: &str, case: &str) -> PathBuf {
        let folder = self.file.references.get(kind).map_or(kind, String::as_str);
        self.references_root().join(folder).join(case)
    }

    /// The recorded wrong picture of a comparison that is known to fail.
    pub fn known_failure_stem(&self, case: &str, pair: &str) -> PathBuf {
        self.references_root().join("known_failures").join(format!("{case}.{pair}"))
    }

    /// Files below the reference folders that no case asks for, by path from the references' root.
    pub fn unused_references(&self) -> Result<Vec<String>, SuiteError> {
        let root = self.references_root();
        let mut used = BTreeSet::new();
        for case in &self.cases {
            for kind in &case.file.references {
                used.insert(self.reference_stem(kind, &case.name).with_added_extension(case.reference_kind(kind).extension()));
            }
            let golden = self.reference_stem("golden", &case.name);
            used.insert(golden.with_added_extension("diagnostics.txt"));
            if case.file.dump {
                used.insert(golden.with_added_extension("scene.txt"));
            }
            for known in &case.file.known_failure {
                used.insert(self.known_failure_stem(&case.name, &known.pair).with_added_extension(case.picture_kind().extension()));
            }
        }
        let mut found = Vec::new();
        let folders = self.file.references.values().map(String::as_str).chain(["known_failures"]);
        for folder in folders.map(|f| root.join(f)).filter(|f| f.is_dir()) {
            walk(&folder, &folder.join("no such folder"), &mut found)?;
        }
        found.retain(|p| !used.contains(p) && !has_extension(p, &NOT_REFERENCES));
        Ok(found.iter().map(|p| relative(p, &root)).collect())
    }

    /// What a case needs that is not here.
    pub fn missing_need<'c>(&self, case: &'c Case) -> Option<&'c str> {
        let missing = |n: &&String| !self.file.needs.get(*n).is_some_and(|p| self.root.join(p).exists());
        case.file.needs.iter().find(missing).map(String::as_str)
    }

    /// Machines that render a case.
    pub fn machines<'s>(&'s self, case: &'s Case) -> &'s [Machine] {
        case.file.backends.as_ref().unwrap_or(&self.file.backends)
    }

    /// Cases whose name is one of `wanted`, lies in one of these folders, or, when that finds none, contains one of them.
    ///
    /// # Errors
    /// A word that names no case.
    pub fn select(&self, wanted: &[String]) -> Result<Vec<&Case>, SuiteError> {
        let mut chosen = BTreeSet::new();
        for word in wanted {
            let word = word.trim_matches('/');
            let inside = |c: &Case| c.name == word || c.name.strip_prefix(word).is_some_and(|r| r.starts_with('/'));
            let pick = |f: &dyn Fn(&Case) -> bool| (0..self.cases.len()).filter(|&i| f(&self.cases[i])).collect::<Vec<_>>();
            let mut found = pick(&inside);
            if found.is_empty() {
                found = pick(&|c: &Case| c.name.contains(word));
            }
            if found.is_empty() {
                return Err(SuiteError::Request(format!("no case is called '{word}' (rayloom suite {} --list)", self.root.display())));
            }
            chosen.extend(found);
        }
        if wanted.is_empty() {
            return Ok(self.cases.iter().collect());
        }
        Ok(chosen.into_iter().map(|i| &self.cases[i]).collect())
    }

    fn read_case(&self, folder: &Path) -> Result<Case, SuiteError> {
        let path = folder.join("test.toml");
        let file = read_case_file(&path, &self.file)?;
        let scene = match &file.scene {
            Some(name) if folder.join(name).is_file() => name.clone(),
            Some(name) => return Err(SuiteError::spec(&path, format!("there is no scene '{}'", name.display()))),
            None => only_scene(folder).map_err(|message| SuiteError::spec(&path, message))?,
        };
        let about = file.about.clone().or_else(|| first_comment(&folder.join(&scene))).unwrap_or_default();
        let size = file.size.unwrap_or(self.file.size);
        Ok(Case { name: relative(folder, &self.root), folder: folder.to_owned(), scene, about, file, size })
    }
}

impl Case {
    /// `objects` of `objects/torus`.
    pub fn area(&self) -> &str {
        self.name.rsplit_once('/').map_or("", |(area, _)| area)
    }

    /// Whether the scene is in POV-Ray's language.
    pub fn is_povray(&self) -> bool {
        has_extension(&self.scene, &SCENES[..2])
    }

    /// Kind of our picture.
    pub fn picture_kind(&self) -> PictureKind {
        self.file.picture.unwrap_or(if self.file.seeds.is_empty() { PictureKind::Png } else { PictureKind::Exr })
    }

    /// Kind of a reference: POV-Ray's are PNG, Cycles' EXR, all others as ours.
    pub fn reference_kind(&self, reference: &str) -> PictureKind {
        match reference {
            "povray" => PictureKind::Png,
            "cycles" => PictureKind::Exr,
            _ => self.picture_kind(),
        }
    }
}

fn has_extension(path: &Path, extensions: &[&str]) -> bool {
    path.extension().is_some_and(|e| extensions.iter().any(|x| e.eq_ignore_ascii_case(x)))
}

/// The path below `root` with `/` between its parts.
fn relative(path: &Path, root: &Path) -> String {
    let parts = path.strip_prefix(root).unwrap_or(path).components();
    parts.map(|c| c.as_os_str().to_string_lossy().into_owned()).collect::<Vec<_>>().join("/")
}

/// All files below `folder`, without hidden ones and those below `skip`.
fn walk(folder: &Path, skip: &Path, out: &mut Vec<PathBuf>) -> Result<(), SuiteError> {
    for entry in std::fs::read_dir(folder).map_err(SuiteError::io("read", folder))? {
        let path = entry.map_err(SuiteError::io("read", folder))?.path();
        if path.file_name().is_some_and(|n| n.to_string_lossy().starts_with('.')) || path == skip {
            continue;
        }
        if path.is_dir() { walk(&path, skip, out)? } else { out.push(path) }
    }
    Ok(())
}

/// The one scene of a folder: `scene.*`, or the only file that can be one.
fn only_scene(folder: &Path) -> Result<PathBuf, String> {
    let named = SCENES.iter().map(|e| PathBuf::from(format!("scene.{e}"))).find(|p| folder.join(p).is_file());
    if let Some(path) = named {
        return Ok(path);
    }
    let entries = std::fs::read_dir(folder).map_err(|e| e.to_string())?;
    let mut scenes: Vec<PathBuf> = entries.flatten().map(|e| PathBuf::from(e.file_name())).filter(|p| has_extension(p, &SCENES)).collect();
    match (scenes.pop(), scenes.len()) {
        (Some(scene), 0) => Ok(scene),
        (None, _) => Err(format!("the folder has no scene (.{})", SCENES.join(", ."))),
        _ => Err("the folder has several scenes: call one of them scene.*, or say scene = \"NAME\"".into()),
    }
}

/// What the first line says, when it is a comment.
fn first_comment(scene: &Path) -> Option<String> {
    let bytes = std::fs::read(scene).ok()?;
    let line = String::from_utf8_lossy(bytes.split(|b| *b == b'\n').next()?).into_owned();
    Some(line.trim().strip_prefix("//")?.trim().to_owned())
}
