//! Records of the extension's JSON: every key is read once, with its kind and range checked; what nobody read is an error with its path.

use super::super::super::ImportError;
use super::super::Document;
use serde_json::{Map, Value};
use std::cell::RefCell;
use std::collections::HashSet;

/// An object of the extension.
pub(in super::super) struct Record<'a> {
    doc: &'a Document<'a>,
    map: &'a Map<String, Value>,
    path: String,
    read: RefCell<HashSet<&'a str>>,
}

impl<'a> Record<'a> {
    /// The record at `path`.
    pub fn new(doc: &'a Document<'a>, value: &'a Value, path: impl Into<String>) -> Result<Self, ImportError> {
        let path = path.into();
        match value {
            Value::Object(map) => Ok(Self { doc, map, path, read: RefCell::default() }),
            other => Err(doc.invalid(path, format!("it must be an object, not {}", kind(other)))),
        }
    }

    /// The file.
    pub fn document(&self) -> &'a Document<'a> {
        self.doc
    }

    /// Where it stands: `extensions.RAYLOOM_scene.lights[2]`.
    pub fn path(&self) -> &str {
        &self.path
    }

    /// An error at a key.
    pub fn wrong(&self, key: &str, what: impl Into<String>) -> ImportError {
        self.doc.invalid(format!("{}.{key}", self.path), what)
    }

    fn expected(&self, key: &str, what: &str, found: &Value) -> ImportError {
        self.wrong(key, format!("it must be {what}, not {}", kind(found)))
    }

    /// The value of a key; null is the same as none.
    pub fn get(&self, key: &str) -> Option<&'a Value> {
        let (key, value) = self.map.get_key_value(key)?;
        self.read.borrow_mut().insert(key);
        (!value.is_null()).then_some(value)
    }

    /// Every key has been read, or the first that was not is an error.
    pub fn finish(&self) -> Result<(), ImportError> {
        let read = self.read.borrow();
        match self.map.keys().find(|k| !read.contains(k.as_str())) {
            Some(key) => Err(self.wrong(key, "this key is unknown in version 1 of the extension")),
            None => Ok(()),
        }
    }

    /// A number.
    pub fn number(&self, key: &str) -> Result<Option<f64>, ImportError> {
        let Some(v) = self.get(key) else { return Ok(None) };
        v.as_f64().filter(|n| (*n as f32).is_finite()).map(Some).ok_or_else(|| self.expected(key, "a number", v))
    }

    /// A number, or what stands for it.
    pub fn number_or(&self, key: &str, default: f64) -> Result<f64, ImportError> {
        Ok(self.number(key)?.unwrap_or(default))
    }

    /// A number that is not below 0.
    pub fn positive_or(&self, key: &str, default: f64) -> Result<f64, ImportError> {
        let v = self.number_or(key, default)?;
        if v >= 0.0 { Ok(v) } else { Err(self.wrong(key, format!("{v} is below 0"))) }
    }

    /// A count.
    pub fn count(&self, key: &str) -> Result<Option<u32>, ImportError> {
        let Some(v) = self.get(key) else { return Ok(None) };
        let n = v.as_u64().and_then(|n| u32::try_from(n).ok());
        n.map(Some).ok_or_else(|| self.expected(key, "a whole number from 0 to 4294967295", v))
    }

    /// A count, or what stands for it.
    pub fn count_or(&self, key: &str, default: u32) -> Result<u32, ImportError> {
        Ok(self.count(key)?.unwrap_or(default))
    }

    /// True or false.
    pub fn flag(&self, key: &str, default: bool) -> Result<bool, ImportError> {
        let Some(v) = self.get(key) else { return Ok(default) };
        v.as_bool().ok_or_else(|| self.expected(key, "true or false", v))
    }

    /// A text.
    pub fn text(&self, key: &str) -> Result<Option<&'a str>, ImportError> {
        let Some(v) = self.get(key) else { return Ok(None) };
        v.as_str().map(Some).ok_or_else(|| self.expected(key, "a text", v))
    }

    /// One of a few words.
    pub fn choice<T: Copy>(&self, key: &str, default: T, words: &[(&str, T)]) -> Result<T, ImportError> {
        let Some(word) = self.text(key)? else { return Ok(default) };
        match words.iter().find(|(w, _)| *w == word) {
            Some((_, v)) => Ok(*v),
            None => {
                let known: Vec<&str> = words.iter().map(|(w, _)| *w).collect();
                Err(self.wrong(key, format!("'{word}' is none of {}", known.join(", "))))
            }
        }
    }

    /// An index into a table of `len` rows.
    pub fn index(&self, key: &str, len: usize, what: &str) -> Result<Option<usize>, ImportError> {
        let Some(k) = self.count(key)? else { return Ok(None) };
        if (k as usize) < len { Ok(Some(k as usize)) } else { Err(self.wrong(key, format!("it names {what} {k}, but there are {len}"))) }
    }

    /// What must be there.
    pub fn needed<T>(&self, key: &str, value: Option<T>) -> Result<T, ImportError> {
        value.ok_or_else(|| self.wrong(key, "it is missing"))
    }

    /// `N` numbers.
    pub fn numbers<const N: usize>(&self, key: &str) -> Result<Option<[f64; N]>, ImportError> {
        let Some(v) = self.get(key) else { return Ok(None) };
        let list = v.as_array().filter(|l| l.len() == N).ok_or_else(|| self.expected(key, &format!("a list of {N} numbers"), v))?;
        let mut out = [0.0; N];
        for (k, (o, v)) in out.iter_mut().zip(list).enumerate() {
            *o = v
                .as_f64()
                .filter(|n| (*n as f32).is_finite())
                .ok_or_else(|| self.wrong(&format!("{key}[{k}]"), format!("it must be a number, not {}", kind(v))))?;
        }
        Ok(Some(out))
    }

    /// Any number of numbers.
    pub fn list(&self, key: &str) -> Result<Vec<f64>, ImportError> {
        let Some(v) = self.get(key) else { return Ok(Vec::new()) };
        let list = v.as_array().ok_or_else(|| self.expected(key, "a list of numbers", v))?;
        let number = |(k, v): (usize, &Value)| v.as_f64().ok_or_else(|| self.expected(&format!("{key}[{k}]"), "a number", v));
        list.iter().enumerate().map(number).collect()
    }

    /// Any number of words.
    pub fn words(&self, key: &str) -> Result<Vec<&'a str>, ImportError> {
        let Some(v) = self.get(key) else { return Ok(Vec::new()) };
        let list = v.as_array().ok_or_else(|| self.expected(key, "a list of words", v))?;
        let word = |(k, v): (usize, &'a Value)| v.as_str().ok_or_else(|| self.expected(&format!("{key}[{k}]"), "a word", v));
        list.iter().enumerate().map(word).collect()
    }

    /// A record inside.
    pub fn record(&self, key: &str) -> Result<Option<Record<'a>>, ImportError> {
        self.get(key).map(|v| Record::new(self.doc, v, format!("{}.{key}", self.path))).transpose()
    }

    /// A list of records inside.
    pub fn records(&self, key: &str) -> Result<Vec<Record<'a>>, ImportError> {
        let Some(v) = self.get(key) else { return Ok(Vec::new()) };
        let list = v.as_array().ok_or_else(|| self.expected(key, "a list", v))?;
        list.iter().enumerate().map(|(k, v)| Record::new(self.doc, v, format!("{}.{key}[{k}]", self.path))).collect()
    }
}

/// A value in words, short.
fn kind(v: &Value) -> String {
    match v {
        Value::Null => "nothing".into(),
        Value::Bool(b) => b.to_string(),
        Value::Number(n) => n.to_string(),
        Value::String(s) => format!("'{}'", s.chars().take(40).collect::<String>()),
        Value::Array(a) => format!("a list of {}", a.len()),
        Value::Object(_) => "an object".into(),
    }
}
