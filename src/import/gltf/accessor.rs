//! Accessors: typed numbers in buffers, with strides, integer normalisation and sparse replacements. Source: glTF 2.0, section 3.6.2.

use super::super::ImportError;
use super::Document;
use ::gltf::json::accessor::{ComponentType, Type};
use ::gltf::json::validation::Checked;

/// Most elements of an accessor that has no bytes behind it (all zero, but for sparse ones).
const MAX_VIRTUAL: u64 = 1 << 24;

/// An accessor whose bytes are known to be there.
pub(super) struct Accessor<'a> {
    /// Its index, for messages.
    pub ix: usize,
    /// Elements.
    pub count: usize,
    bytes: Option<&'a [u8]>,
    stride: usize,
    component: ComponentType,
    n_components: usize,
    normalized: bool,
    /// Replaced elements, sorted, and their packed bytes.
    sparse: Option<(Vec<u32>, &'a [u8])>,
}

fn component_size(c: ComponentType) -> usize {
    match c {
        ComponentType::I8 | ComponentType::U8 => 1,
        ComponentType::I16 | ComponentType::U16 => 2,
        ComponentType::U32 | ComponentType::F32 => 4,
    }
}

fn component_count(t: Type) -> usize {
    match t {
        Type::Scalar => 1,
        Type::Vec2 => 2,
        Type::Vec3 => 3,
        Type::Vec4 | Type::Mat2 => 4,
        Type::Mat3 => 9,
        Type::Mat4 => 16,
    }
}

impl<'a> Accessor<'a> {
    /// Accessor `ix`, whose elements must have one of the numbers of components in `wanted`.
    pub fn new(doc: &'a Document, ix: usize, wanted: &[usize], place: impl Fn() -> String) -> Result<Self, ImportError> {
        let a = doc.get(&doc.root.accessors, ix, "accessor", &place)?;
        let here = || format!("accessor {ix}");
        let (Checked::Valid(component), Checked::Valid(kind)) = (a.component_type, a.type_) else {
            return Err(doc.invalid(here(), "its type is unknown"));
        };
        let (component, n_components) = (component.0, component_count(kind));
        if !wanted.contains(&n_components) {
            return Err(doc.invalid(here(), format!("{} needs {wanted:?} numbers an element, it has {n_components}", place())));
        }
        let element = component_size(component) * n_components;
        let count = a.count.0;
        let (mut bytes, mut stride) = (None, element);
        if let Some(view_ix) = a.buffer_view {
            let view = doc.view(view_ix.value(), here)?;
            let given = doc.root.buffer_views[view_ix.value()].byte_stride.map_or(0, |s| s.0);
            if given != 0 && given < element {
                return Err(doc.invalid(here(), format!("the stride of {given} bytes is shorter than an element of {element}")));
            }
            stride = given.max(element);
            bytes = Some(span(doc, here, view, a.byte_offset.map_or(0, |o| o.0), count, stride, element)?);
        } else if count > MAX_VIRTUAL {
            return Err(doc.invalid(here(), format!("it claims {count} elements without bytes behind them")));
        }
        let mut sparse = None;
        if let Some(s) = &a.sparse {
            let Checked::Valid(index_type) = s.indices.component_type else {
                return Err(doc.invalid(here(), "the type of its sparse indices is unknown"));
            };
            let size = component_size(index_type.0);
            let (n, there) = (s.count.0, doc.view(s.indices.buffer_view.value(), here)?);
            let ix_bytes = span(doc, here, there, s.indices.byte_offset.0, n, size, size)?;
            let values = span(doc, here, doc.view(s.values.buffer_view.value(), here)?, s.values.byte_offset.0, n, element, element)?;
            let indices: Vec<u32> = ix_bytes.chunks_exact(size).map(|b| unsigned(index_type.0, b)).collect();
            if indices.windows(2).any(|w| w[0] >= w[1]) || indices.last().is_some_and(|l| u64::from(*l) >= count) {
                return Err(doc.invalid(here(), "its sparse indices do not rise, or run beyond its elements"));
            }
            sparse = Some((indices, values));
        }
        Ok(Self { ix, count: count as usize, bytes, stride, component, n_components, normalized: a.normalized, sparse })
    }

    /// Packed bytes of element `k`, below `count`; `None` for a zero.
    #[inline]
    fn element(&self, k: usize) -> Option<&'a [u8]> {
        let size = component_size(self.component) * self.n_components;
        if let Some((indices, values)) = &self.sparse
            && let Ok(at) = indices.binary_search(&(k as u32))
        {
            return values.get(at * size..(at + 1) * size);
        }
        self.bytes.and_then(|b| b.get(k * self.stride..k * self.stride + size))
    }

    /// Element `k` as numbers; components that it lacks are `rest`.
    #[inline]
    pub fn floats<const N: usize>(&self, k: usize, rest: f32) -> [f32; N] {
        let mut out = [rest; N];
        let n = self.n_components.min(N);
        let Some(bytes) = self.element(k) else {
            out[..n].fill(0.0);
            return out;
        };
        for (v, b) in out.iter_mut().zip(bytes.chunks_exact(component_size(self.component))).take(n) {
            *v = float(self.component, self.normalized, b);
        }
        out
    }

    /// All elements.
    pub fn all_floats<const N: usize>(&self, rest: f32) -> Vec<[f32; N]> {
        match (self.bytes, self.component) {
            (Some(bytes), ComponentType::F32) if self.sparse.is_none() && self.n_components == N => {
                let of = |e: &[u8]| std::array::from_fn(|k| f32::from_le_bytes([e[4 * k], e[4 * k + 1], e[4 * k + 2], e[4 * k + 3]]));
                if self.stride == 4 * N {
                    bytes.chunks_exact(4 * N).take(self.count).map(of).collect()
                } else {
                    bytes.chunks(self.stride).take(self.count).map(|e| of(&e[..4 * N])).collect()
                }
            }
            _ => (0..self.count).map(|k| self.floats(k, rest)).collect(),
        }
    }

    /// All elements as indices; `None` when they are no unsigned integers.
    pub fn all_indices(&self) -> Option<Vec<u32>> {
        match self.component {
            ComponentType::U8 | ComponentType::U16 | ComponentType::U32 => {}
            _ => return None,
        }
        let c = self.component;
        match self.bytes {
            Some(bytes) if self.sparse.is_none() && self.stride == component_size(c) => {
                Some(bytes.chunks_exact(self.stride).take(self.count).map(|b| unsigned(c, b)).collect())
            }
            _ => Some((0..self.count).map(|k| self.element(k).map_or(0, |b| unsigned(c, b))).collect()),
        }
    }
}

/// The bytes of `count` elements of `element` bytes, `stride` apart from `offset` on; they end with the last element.
fn span<'a>(
    doc: &Document,
    here: impl Fn() -> String,
    view: &'a [u8],
    offset: u64,
    count: u64,
    stride: usize,
    element: usize,
) -> Result<&'a [u8], ImportError> {
    let length = if count == 0 { Some(0) } else { (count - 1).checked_mul(stride as u64).and_then(|n| n.checked_add(element as u64)) };
    length
        .and_then(|l| l.checked_add(offset))
        .filter(|end| *end <= view.len() as u64)
        .map(|end| &view[offset.min(end) as usize..end as usize])
        .ok_or_else(|| {
            let what = format!("{count} elements from byte {offset} on do not fit into the {} bytes of its buffer view", view.len());
            doc.invalid(here(), what)
        })
}

#[inline]
fn unsigned(c: ComponentType, b: &[u8]) -> u32 {
    match c {
        ComponentType::U8 | ComponentType::I8 => u32::from(b[0]),
        ComponentType::U16 | ComponentType::I16 => u32::from(u16::from_le_bytes([b[0], b[1]])),
        ComponentType::U32 | ComponentType::F32 => u32::from_le_bytes([b[0], b[1], b[2], b[3]]),
    }
}

#[inline]
fn float(c: ComponentType, normalized: bool, b: &[u8]) -> f32 {
    let (value, scale) = match c {
        ComponentType::F32 => return f32::from_le_bytes([b[0], b[1], b[2], b[3]]),
        ComponentType::U32 => return u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as f32,
        ComponentType::U8 => (f32::from(b[0]), 255.0),
        ComponentType::I8 => (f32::from(b[0] as i8), 127.0),
        ComponentType::U16 => (f32::from(u16::from_le_bytes([b[0], b[1]])), 65535.0),
        ComponentType::I16 => (f32::from(i16::from_le_bytes([b[0], b[1]])), 32767.0),
    };
    if normalized { (value / scale).max(-1.0) } else { value }
}
