//! Stands in for the texture builder until the texture room lands its own: indices without contents.

use super::texture::{PigmentIx, TextureIx, TextureTables};
use crate::scene::{Function, Object, Pigment, Texture};
use std::collections::HashMap;
use std::sync::Arc;

#[derive(Default)]
pub(super) struct TextureBuilder {
    textures: HashMap<*const Texture, TextureIx>,
    transparent: Vec<bool>,
    pigments: HashMap<*const Pigment, PigmentIx>,
    keep: Vec<Arc<Texture>>,
}

fn lets_light_through(t: &Texture) -> bool {
    use crate::scene::PigmentKind;
    match t {
        Texture::Layers(layers) => layers.iter().all(|l| match &l.pigment.kind {
            PigmentKind::Solid(c) => c.filter != 0.0 || c.transmit != 0.0,
            _ => true,
        }),
        Texture::Principled(p) => p.transmission > 0.0 || p.alpha < 1.0,
        _ => true,
    }
}

impl TextureBuilder {
    pub fn texture(&mut self, t: &Arc<Texture>) -> TextureIx {
        let n = self.transparent.len() as TextureIx;
        *self.textures.entry(Arc::as_ptr(t)).or_insert_with(|| {
            self.transparent.push(lets_light_through(t));
            self.keep.push(t.clone());
            n
        })
    }

    pub fn pigment(&mut self, p: &Arc<Pigment>) -> PigmentIx {
        let n = self.pigments.len() as PigmentIx;
        *self.pigments.entry(Arc::as_ptr(p)).or_insert(n)
    }

    pub fn is_transparent(&self, t: TextureIx) -> bool {
        self.transparent[t as usize]
    }

    pub fn function(&mut self, _f: &Arc<Function>) -> Option<u32> {
        None
    }

    pub fn finish(self) -> TextureTables {
        TextureTables::default()
    }

    pub fn take_objects(&mut self) -> Vec<Arc<Object>> {
        Vec::new()
    }
}
