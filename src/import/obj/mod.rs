//! OBJ + MTL → scene. The readers are our own: the `obj-rs` crate stops at what Blender and others write (vertex colours, `g a b`, an
//! empty `usemtl`, names with spaces, unknown statements) and panics at free-form curves.
//!
//! `geometry.rs` reads statements, `polygon.rs` cuts polygons into triangles, `meshes.rs` makes one mesh a material,
//! `mtl.rs` reads material libraries, `material.rs` turns their records into materials.

mod geometry;
mod material;
mod meshes;
mod mtl;
mod polygon;

use super::{ImportError, Imported, files};
use crate::diag::Sink;
use crate::scene::{Object, Scene, Shape};
use geometry::Geometry;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Reads an .obj and the material libraries that it names.
pub(super) fn load(path: &Path, bytes: &[u8], sink: &mut Sink) -> Result<Imported, ImportError> {
    let geometry = Geometry::parse(path, bytes, sink)?;
    if !geometry.has_statements {
        return Err(ImportError::UnknownFormat(path.to_owned()));
    }
    let mut records = Vec::new();
    for library in &geometry.libraries {
        for file in library_files(path, library) {
            match files::read(&file) {
                Ok(bytes) => records.append(&mut mtl::parse(&file, &bytes, sink)),
                Err(e) => sink.note_once(&format!("obj: {library}"), None, format!("a material library is left out: {e}")),
            }
        }
    }
    let mut materials = material::Materials::new(records);
    let mut scene = Scene::default();
    for (name, mesh) in meshes::by_material(path, &geometry)? {
        let cover = materials.cover(name, sink);
        let object = Object::new(Shape::Mesh(Arc::new(mesh)));
        scene.objects.push(Object { texture: Some(cover.texture), interior: cover.interior, ..object });
    }
    Ok(Imported { scene, has_camera: false })
}

/// The files of a `mtllib`: the whole rest of the line as one name, as Blender writes it; else names between spaces, as the format has it.
fn library_files(model: &Path, names: &str) -> Vec<PathBuf> {
    let whole = file_beside(model, names);
    let parts: Vec<PathBuf> = names.split_whitespace().map(|n| file_beside(model, n)).collect();
    if whole.exists() || parts.len() < 2 || !parts.iter().any(|p| p.exists()) { vec![whole] } else { parts }
}

/// A file named in `model`; names from Windows have backslashes.
fn file_beside(model: &Path, name: &str) -> PathBuf {
    let as_written = files::beside(model, name);
    if name.contains('\\') && !as_written.exists() { files::beside(model, &name.replace('\\', "/")) } else { as_written }
}
