//! glTF and OBJ files, small and written here, through `import::load` as `rayloom render` calls it.

mod animation;
mod broken;
mod files;
mod gltf;
mod khr;
mod obj;
mod rayloom;
mod shading;
