//! Trees over meshes that outlive their scene: frames of an animation that hold the same mesh share one.

use super::{MeshIndex, MeshShape};
use crate::accel::AccelKind;
use crate::scene::Mesh;
use std::collections::HashMap;
use std::hash::{DefaultHasher, Hasher};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// The meshes of the last scene with their trees. Whether a mesh is the same is decided by its faces, one by one.
#[derive(Debug, Default)]
pub struct TreeStore(Mutex<HashMap<u64, Vec<Kept>>>);

#[derive(Debug)]
struct Kept {
    mesh: Arc<Mesh>,
    accel: AccelKind,
    index: Arc<OnceLock<MeshIndex>>,
    /// Asked for since the last frame ended.
    used: bool,
}

fn hash_of(m: &Mesh) -> u64 {
    let mut h = DefaultHasher::new();
    h.write(bytemuck::cast_slice(&m.vertices));
    h.write(bytemuck::cast_slice(&m.faces));
    h.finish()
}

impl TreeStore {
    /// The mesh with the tree that an equal one had in the frame before, if there was one; else its own tree is kept for the next.
    pub fn adopt(&self, mut shape: MeshShape) -> MeshShape {
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let like = kept.entry(hash_of(&shape.mesh)).or_default();
        let same = |k: &&mut Kept| k.accel == shape.accel && k.mesh.vertices == shape.mesh.vertices && k.mesh.faces == shape.mesh.faces;
        match like.iter_mut().find(same) {
            Some(k) => {
                shape.index = k.index.clone();
                // The older scene may go.
                (k.mesh, k.used) = (shape.mesh.clone(), true);
            }
            None => like.push(Kept { mesh: shape.mesh.clone(), accel: shape.accel, index: shape.index.clone(), used: true }),
        }
        shape
    }

    /// Forgets what the frame that ends now did not ask for.
    pub fn end_frame(&self) {
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        kept.retain(|_, like| {
            like.retain_mut(|k| std::mem::take(&mut k.used));
            !like.is_empty()
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;

    fn shape(x: f32) -> MeshShape {
        let mesh = Mesh { vertices: vec![Vec3::ZERO, Vec3::X * x, Vec3::Y], faces: vec![[0, 1, 2]], ..Mesh::default() };
        MeshShape::new(Arc::new(mesh), Vec::new(), AccelKind::Bvh).expect("a face")
    }

    #[test]
    fn equal_meshes_share_a_tree_and_others_do_not() {
        let store = TreeStore::default();
        let first = store.adopt(shape(1.0));
        _ = first.index();
        store.end_frame();
        assert!(store.adopt(shape(1.0)).is_built());
        assert!(!store.adopt(shape(2.0)).is_built());
        let other_kind = MeshShape::new(shape(1.0).mesh, Vec::new(), AccelKind::Kd).expect("a face");
        assert!(!store.adopt(other_kind).is_built());
        store.end_frame();
        store.end_frame();
        assert!(!store.adopt(shape(1.0)).is_built(), "a frame without it forgot it");
    }
}
