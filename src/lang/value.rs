//! Values that names hold, and the symbol tables that hold the names. Source: spec/language.md, sections 2 and 4.2.

use super::token::{Symbol, Token};
use crate::diag::Span;
use crate::math::{DVec3, Rgbft, Transform};
use crate::scene::{
    BlendMap, Camera, Finish, Fog, Function, Interior, Media, Normal, Object, Pigment, Rainbow, SkySphere, Spline, Texture,
};
use std::collections::{HashMap, HashSet};
use std::hash::{BuildHasherDefault, Hasher};
use std::sync::Arc;

/// A float (`n` = 1) or a vector of 2 to 5 components.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Num {
    /// Number of components, 1..=5.
    pub n: u8,
    /// Made by a colour identifier or a function of five components: 32-bit, and fit for a colour place as it is.
    pub is_color: bool,
    /// Components; those past `n` are 0, or what a member access left there (a quirk that `vstr` shows).
    pub v: [f64; 5],
}

impl Num {
    /// A float.
    pub const fn float(x: f64) -> Self {
        Self { n: 1, is_color: false, v: [x, 0.0, 0.0, 0.0, 0.0] }
    }

    /// A vector of `n` components.
    pub const fn vector(n: u8, v: [f64; 5]) -> Self {
        Self { n, is_color: false, v }
    }

    /// A 3-vector.
    pub fn vec3(v: DVec3) -> Self {
        Self::vector(3, [v.x, v.y, v.z, 0.0, 0.0])
    }

    /// A colour of five components.
    pub fn color(c: Rgbft) -> Self {
        Self { n: 5, is_color: true, v: c.to_array().map(f64::from) }
    }

    /// With `n` components: floats are replicated, shorter vectors padded with 0. Never shortens.
    pub fn promoted(self, n: u8) -> Self {
        if self.n >= n {
            return self;
        }
        let mut v = [0.0; 5];
        for (i, x) in v.iter_mut().enumerate().take(n as usize) {
            *x = if self.n == 1 {
                self.v[0]
            } else if i < self.n as usize {
                self.v[i]
            } else {
                0.0
            };
        }
        Self { n, is_color: self.is_color, v }
    }

    /// The five components as a colour, rounded to 32 bits.
    pub fn to_rgbft(self) -> Rgbft {
        Rgbft::from_array(self.v.map(|x| x as f32))
    }
}

/// `material{}`: a texture and an interior together.
#[derive(Clone, Debug, Default)]
pub struct Material {
    /// Cover.
    pub texture: Option<Arc<Texture>>,
    /// Cover of the inside.
    pub interior_texture: Option<Arc<Texture>>,
    /// Filling.
    pub interior: Option<Arc<Interior>>,
}

/// An array with its type fixed by the first element assigned.
#[derive(Clone, Debug)]
pub struct Array {
    /// Sizes by dimension, 1 to 5 of them.
    pub dims: Vec<usize>,
    /// Elements, last dimension fastest.
    pub items: Vec<Option<Value>>,
}

/// A macro: its parameters and the tokens of its body.
#[derive(Debug)]
pub struct Macro {
    /// Name.
    pub name: Symbol,
    /// Parameter names.
    pub params: Vec<Symbol>,
    /// The file's tokens.
    pub tokens: Arc<[Token]>,
    /// Body, without its `#end`.
    pub body: std::ops::Range<usize>,
    /// Place of the definition.
    pub span: Span,
}

/// What a name holds.
#[derive(Clone, Debug)]
#[expect(missing_docs, reason = "the names say it")]
pub enum Value {
    Num(Num),
    /// 16-bit units.
    Str(Arc<[u16]>),
    Array(Arc<Array>),
    Function(Arc<Function>),
    Spline(Arc<Spline>),
    Transform(Arc<Transform>),
    Pigment(Arc<Pigment>),
    Normal(Arc<Normal>),
    Finish(Arc<Finish>, Arc<FinishExtras>),
    Texture(Arc<Texture>),
    Material(Arc<Material>),
    Interior(Arc<Interior>),
    Media(Arc<Vec<Media>>),
    Density(Arc<Pigment>),
    ColorMap(Arc<BlendMap<Rgbft>>),
    PigmentMap(Arc<BlendMap<Pigment>>),
    DensityMap(Arc<BlendMap<Pigment>>),
    NormalMap(Arc<BlendMap<Normal>>),
    SlopeMap(Arc<BlendMap<[f32; 2]>>),
    TextureMap(Arc<BlendMap<Arc<Texture>>>),
    Object(Arc<Object>),
    Camera(Arc<Camera>),
    Fog(Arc<Fog>),
    Rainbow(Arc<Rainbow>),
    SkySphere(Arc<SkySphere>),
    File(usize),
    Macro(Arc<Macro>),
}

/// What a `finish{}` says that belongs to the interior.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FinishExtras {
    /// Old `ior`.
    pub ior: Option<f64>,
    /// Old `caustics`.
    pub caustics: Option<f64>,
    /// Old `refraction`.
    pub refraction: Option<f64>,
}

impl Value {
    /// As messages call it: "float identifier", "pigment identifier".
    pub fn kind_name(&self) -> &'static str {
        match self {
            Self::Num(n) if n.is_color => "color identifier",
            Self::Num(n) if n.n == 1 => "float identifier",
            Self::Num(n) if n.n == 2 => "uv vector identifier",
            Self::Num(n) if n.n == 3 => "vector identifier",
            Self::Num(_) => "4d vector identifier",
            Self::Str(_) => "string identifier",
            Self::Array(_) => "array identifier",
            Self::Function(_) => "function identifier",
            Self::Spline(_) => "spline identifier",
            Self::Transform(_) => "transform identifier",
            Self::Pigment(_) => "pigment identifier",
            Self::Normal(_) => "normal identifier",
            Self::Finish(..) => "finish identifier",
            Self::Texture(_) => "texture identifier",
            Self::Material(_) => "material identifier",
            Self::Interior(_) => "interior identifier",
            Self::Media(_) => "media identifier",
            Self::Density(_) => "density identifier",
            Self::ColorMap(_) => "color_map identifier",
            Self::PigmentMap(_) => "pigment_map identifier",
            Self::DensityMap(_) => "density_map identifier",
            Self::NormalMap(_) => "normal_map identifier",
            Self::SlopeMap(_) => "slope_map identifier",
            Self::TextureMap(_) => "texture_map identifier",
            Self::Object(_) => "object identifier",
            Self::Camera(_) => "camera identifier",
            Self::Fog(_) => "fog identifier",
            Self::Rainbow(_) => "rainbow identifier",
            Self::SkySphere(_) => "sky_sphere identifier",
            Self::File(_) => "file identifier",
            Self::Macro(_) => "macro identifier",
        }
    }

    /// Whether two values may share an array.
    pub fn same_kind(&self, other: &Value) -> bool {
        match (self, other) {
            (Self::Num(a), Self::Num(b)) => a.n == b.n && a.is_color == b.is_color,
            _ => std::mem::discriminant(self) == std::mem::discriminant(other),
        }
    }

    /// Passed to macros by value even when it is a lone name.
    pub fn is_passed_by_value(&self) -> bool {
        matches!(self, Self::Function(_) | Self::Spline(_))
    }
}

/// A place that a value can be read from and assigned to: a name in a scope, or an element of an array there.
#[derive(Clone, Debug, PartialEq)]
pub struct Place {
    /// Index of the scope.
    pub scope: usize,
    /// Name in the scope.
    pub name: Symbol,
    /// Flat indices, one a nesting of arrays; empty for the name itself.
    pub path: Vec<usize>,
}

/// What a scope knows of a name.
#[derive(Clone, Debug)]
pub enum Binding {
    /// A value.
    Value(Value),
    /// A macro parameter passed by reference.
    Alias(Place),
}

/// A name's entry.
#[derive(Clone, Debug)]
pub struct Entry {
    /// What it is.
    pub binding: Binding,
    /// A warning for each use, or the first alone.
    pub deprecated: Option<Arc<Deprecated>>,
    /// How deep blocks are nested in the value, those of the names that it was made of included; 0 for numbers and strings.
    pub nesting: u32,
}

/// `#declare deprecated`.
#[derive(Debug)]
pub struct Deprecated {
    /// Warn for the first use only.
    pub once: bool,
    /// What to say.
    pub message: String,
}

/// Hashes a symbol by multiplying: symbols are dense small numbers.
#[derive(Default)]
pub struct SymbolHasher(u64);

impl Hasher for SymbolHasher {
    fn finish(&self) -> u64 {
        self.0
    }
    fn write(&mut self, bytes: &[u8]) {
        for &b in bytes {
            self.write_u32(u32::from(b));
        }
    }
    fn write_u32(&mut self, n: u32) {
        // Fibonacci hashing: 2^64 / golden ratio.
        self.0 = (self.0 ^ u64::from(n)).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    }
}

/// One scope: global, an include file, a macro call.
pub type Scope = HashMap<Symbol, Entry, BuildHasherDefault<SymbolHasher>>;

/// The stack of scopes, global first.
#[derive(Debug)]
pub struct SymbolTable {
    /// Scopes, innermost last, never empty.
    pub scopes: Vec<Scope>,
    /// Names that `defined()` and `#ifdef` know although they have no value: `#read` hit the end of its file before it had one.
    pub valueless: HashSet<Symbol>,
}

impl Default for SymbolTable {
    fn default() -> Self {
        Self { scopes: vec![Scope::default()], valueless: HashSet::new() }
    }
}

impl SymbolTable {
    /// Scopes deeper than this are refused. Source: spec/language.md, section 4.4.
    pub const MAX_SCOPES: usize = 100;

    /// The innermost entry of a name, with its scope.
    #[inline]
    pub fn find(&self, name: Symbol) -> Option<(usize, &Entry)> {
        for (i, scope) in self.scopes.iter().enumerate().rev() {
            if let Some(e) = scope.get(&name) {
                return Some((i, e));
            }
        }
        None
    }

    /// The place that a name stands for, aliases followed.
    pub fn resolve(&self, name: Symbol) -> Option<Place> {
        let (scope, entry) = self.find(name)?;
        match &entry.binding {
            Binding::Value(_) => Some(Place { scope, name, path: Vec::new() }),
            Binding::Alias(p) => Some(p.clone()),
        }
    }

    /// The value at a place, if there is one.
    pub fn value_at(&self, place: &Place) -> Option<&Value> {
        let mut value = match &self.scopes.get(place.scope)?.get(&place.name)?.binding {
            Binding::Value(v) => v,
            Binding::Alias(p) => return self.value_at(p),
        };
        for &i in &place.path {
            let Value::Array(a) = value else { return None };
            value = a.items.get(i)?.as_ref()?;
        }
        Some(value)
    }

    /// The value of a name, aliases followed.
    pub fn value(&self, name: Symbol) -> Option<&Value> {
        let (_, entry) = self.find(name)?;
        match &entry.binding {
            Binding::Value(v) => Some(v),
            Binding::Alias(p) => self.value_at(p),
        }
    }

    /// Stores at a place whose name exists; `Err` gives the element's old value when an array's type forbids the new one.
    pub fn store(&mut self, place: &Place, value: Value) -> Result<(), Value> {
        let Some(entry) = self.scopes.get_mut(place.scope).and_then(|s| s.get_mut(&place.name)) else { return Ok(()) };
        if let Binding::Alias(p) = &entry.binding {
            let p = p.clone();
            return self.store(&p, value);
        }
        let Binding::Value(mut target) = std::mem::replace(&mut entry.binding, Binding::Value(Value::Num(Num::float(0.0)))) else {
            unreachable!("aliases were followed above")
        };
        let result = store_in(&mut target, &place.path, value);
        entry.binding = Binding::Value(target);
        result
    }

    /// [`Entry::nesting`] of what a name stands for.
    pub fn nesting(&self, name: Symbol) -> u32 {
        match self.find(name) {
            Some((_, Entry { binding: Binding::Alias(p), .. })) => {
                self.scopes.get(p.scope).and_then(|s| s.get(&p.name)).map_or(0, |e| e.nesting)
            }
            found => found.map_or(0, |(_, e)| e.nesting),
        }
    }

    /// Says how deep the value at a place is nested; what an array holds adds up to its deepest element.
    pub fn set_nesting(&mut self, place: &Place, nesting: u32) {
        if let Some(e) = self.scopes.get_mut(place.scope).and_then(|s| s.get_mut(&place.name)) {
            e.nesting = if place.path.is_empty() { nesting } else { e.nesting.max(nesting + 1) };
        }
    }

    /// Sets a name in one scope, new or not.
    pub fn set(&mut self, scope: usize, name: Symbol, value: Value) {
        self.scopes[scope].insert(name, Entry { binding: Binding::Value(value), deprecated: None, nesting: 0 });
    }
}

fn store_in(target: &mut Value, path: &[usize], value: Value) -> Result<(), Value> {
    let Some((&i, rest)) = path.split_first() else {
        *target = value;
        return Ok(());
    };
    let Value::Array(a) = target else { return Ok(()) };
    let a = Arc::make_mut(a);
    if rest.is_empty() {
        if let Some(known) = a.items.iter().flatten().next()
            && !known.same_kind(&value)
        {
            return Err(known.clone());
        }
        a.items[i] = Some(value);
        return Ok(());
    }
    match &mut a.items[i] {
        Some(inner) => store_in(inner, rest, value),
        None => Ok(()),
    }
}

impl SymbolTable {
    /// Empties an array element.
    pub fn clear_element(&mut self, place: &Place) {
        fn clear(target: &mut Value, path: &[usize]) {
            let (Value::Array(a), Some((&i, rest))) = (target, path.split_first()) else { return };
            let a = Arc::make_mut(a);
            if rest.is_empty() {
                a.items[i] = None;
            } else if let Some(inner) = &mut a.items[i] {
                clear(inner, rest);
            }
        }
        if let Some(Entry { binding: Binding::Value(v), .. }) = self.scopes.get_mut(place.scope).and_then(|s| s.get_mut(&place.name)) {
            clear(v, &place.path);
        }
    }
}
