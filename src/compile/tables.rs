//! Tables that hold each thing once.

use super::geometry::Surface;
use crate::math::Transform;
use std::collections::HashMap;

/// Distinct transforms by their bits; entry 0 is the identity.
#[derive(Debug)]
pub(super) struct TransformTable {
    pub items: Vec<Transform>,
    index: HashMap<[u64; 12], u32>,
}

impl TransformTable {
    pub fn new() -> Self {
        let mut t = Self { items: Vec::new(), index: HashMap::new() };
        t.add(&Transform::IDENTITY);
        t
    }

    pub fn add(&mut self, t: &Transform) -> u32 {
        // Adding zero makes -0 and 0 one.
        let key = t.forward.to_cols_array().map(|v| (v + 0.0).to_bits());
        *self.index.entry(key).or_insert_with(|| {
            self.items.push(*t);
            self.items.len() as u32 - 1
        })
    }
}

/// Distinct covers.
#[derive(Debug, Default)]
pub(super) struct SurfaceTable {
    pub items: Vec<Surface>,
    index: HashMap<Surface, u32>,
}

impl SurfaceTable {
    pub fn add(&mut self, s: Surface) -> u32 {
        *self.index.entry(s).or_insert_with(|| {
            self.items.push(s);
            self.items.len() as u32 - 1
        })
    }
}
