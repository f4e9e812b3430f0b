//! Shader text for one scene: WESL modules from `shaders/`, embedded in the program, put together with the scene's features (`@if`)
//! and with the constants that both languages share (`package::constants`). What no entry point needs is left out.

use super::modules::MODULES;
use std::borrow::Cow;
use std::collections::BTreeSet;
use std::fmt::Write;
use wesl::{CompileOptions, Feature, ManglerKind, VirtualResolver, Wesl};

/// What decides the text of a shader besides its modules.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ShaderOptions {
    /// Names of `@if` that hold; all others do not.
    pub features: BTreeSet<String>,
    /// Lines of `package::constants`.
    constants: String,
    /// The module `package::functions`: user functions, generated; empty for none.
    pub functions: String,
    /// The module of `shaders/accel/` that walks scene and meshes; empty for shaders that trace no rays.
    pub accel: &'static str,
}

/// A number that a shader knows by name.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ConstValue {
    /// `i32`.
    I32(i32),
    /// `u32`.
    U32(u32),
    /// `f32`.
    F32(f32),
}

impl From<i32> for ConstValue {
    fn from(v: i32) -> Self {
        Self::I32(v)
    }
}

impl From<u32> for ConstValue {
    fn from(v: u32) -> Self {
        Self::U32(v)
    }
}

impl From<f32> for ConstValue {
    fn from(v: f32) -> Self {
        Self::F32(v)
    }
}

impl ShaderOptions {
    /// Turns a feature on.
    pub fn feature(&mut self, name: &str) {
        self.features.insert(name.to_owned());
    }

    /// Turns a feature on if `holds`.
    pub fn feature_if(&mut self, name: &str, holds: bool) {
        if holds {
            self.feature(name);
        }
    }

    /// Gives a number a name: `constants::NAME` in shaders.
    pub fn constant(&mut self, name: &str, value: impl Into<ConstValue>) {
        let line = match value.into() {
            ConstValue::I32(v) => writeln!(self.constants, "const {name}: i32 = {v};"),
            ConstValue::U32(v) => writeln!(self.constants, "const {name}: u32 = {v}u;"),
            // Debug prints the shortest text that reads back as the same number.
            ConstValue::F32(v) => writeln!(self.constants, "const {name}: f32 = {v:?};"),
        };
        line.expect("writing to a string cannot fail");
    }

    /// Everything that `other` turns on or names, too.
    pub fn extend(&mut self, other: &ShaderOptions) {
        self.features.extend(other.features.iter().cloned());
        self.constants.push_str(&other.constants);
        self.functions.push_str(&other.functions);
    }
}

/// A shader could not be put together: a fault of this program, told with the compiler's own words.
#[derive(Debug, thiserror::Error)]
#[error("shader '{module}': {message}")]
pub struct ShaderError {
    /// Which root module.
    pub module: String,
    /// What the compiler said.
    pub message: String,
}

/// A module's text: the built-in one, or in debug builds the file in `RAYLOOM_SHADERS`, so that work on shaders needs no build.
fn text_of(name: &str, built_in: &'static str) -> Cow<'static, str> {
    let folder = if cfg!(debug_assertions) { std::env::var_os("RAYLOOM_SHADERS") } else { None };
    let file = folder.and_then(|f| std::fs::read_to_string(std::path::Path::new(&f).join(format!("{name}.wesl"))).ok());
    file.map_or(Cow::Borrowed(built_in), Cow::Owned)
}

/// The WGSL text of the entry points of `module` (`trace_closest`, `probes/noise`).
pub fn assemble(module: &str, options: &ShaderOptions) -> Result<String, ShaderError> {
    let fail = |message: String| ShaderError { module: module.to_owned(), message };
    let mut resolver = VirtualResolver::new();
    let path = |name: &str| format!("package::{}", name.replace('/', "::")).parse();
    for (name, text) in MODULES {
        let text = text_of(name, text);
        if name.strip_prefix("accel/") == Some(options.accel) {
            // One text, twice: over the scene's primitives and over a mesh's faces.
            for level in ["scene", "mesh"] {
                let at = path(&format!("accel/walk_{level}")).map_err(|_| fail(level.into()))?;
                resolver.add_module(at, text.replace("LEVEL", level).into());
            }
        }
        resolver.add_module(path(name).map_err(|_| fail(format!("bad module name '{name}'")))?, text);
    }
    resolver.add_module(path("constants").map_err(|_| fail("constants".into()))?, options.constants.as_str().into());
    resolver.add_module(path("functions").map_err(|_| fail("functions".into()))?, options.functions.as_str().into());
    let mut compiler = Wesl::new_barebones().set_custom_resolver(resolver);
    let mut wanted = CompileOptions { lower: false, validate: false, ..CompileOptions::default() };
    wanted.features.flags.extend(options.features.iter().map(|f| (f.clone(), Feature::Enable)));
    compiler.set_mangler(ManglerKind::None).set_options(wanted);
    let root = path(module).map_err(|_| fail("bad module name".into()))?;
    compiler.compile(&root).map(|r| r.to_string()).map_err(|e| fail(e.to_string()))
}
