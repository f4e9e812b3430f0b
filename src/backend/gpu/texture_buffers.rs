//! Textures for the GPU: the parts of `TextureTables` that a scene shows, as words that `shaders/shared/` reads, with the names of what
//! the shaders must know. Records are named by the place of their first word; 0 is none.

use super::shader::ShaderOptions;
use super::texture_encoder::TextureEncoder;
use super::texture_layout::layout_constants;
use super::texture_noise::NoiseTables;
use crate::backend::BackendError;
use crate::compile::texture::{FunctionIx, NormalIx, PigmentIx, TextureIx, TextureTables};
use crate::compile::{CompiledScene, NONE};
use std::collections::BTreeSet;

/// What is asked for: everything that a ray may see, into the tables of `TextureTables`.
#[derive(Clone, Debug, Default)]
pub struct TextureRoots {
    /// Covers of surfaces.
    pub textures: BTreeSet<TextureIx>,
    /// Pigments that stand alone: the sky, densities of media.
    pub pigments: BTreeSet<PigmentIx>,
    /// Normals that stand alone: the camera's.
    pub normals: BTreeSet<NormalIx>,
    /// Functions that shaders call by their number: those of isosurfaces.
    pub functions: BTreeSet<FunctionIx>,
    /// By object of an object pattern: start and length of the program that tells its inside; no length for none.
    pub insides: Vec<[u32; 2]>,
    /// What the functions may weigh that are written out, in calls of noise; the others are interpreted. `None` for all.
    pub most_written: Option<usize>,
}

impl TextureRoots {
    /// Those of a scene; densities of media and functions of shapes are left to whoever renders them.
    pub fn of_scene(scene: &CompiledScene) -> Self {
        let g = &scene.geometry;
        let surfaces = g.surfaces.iter().flat_map(|s| [s.texture, s.interior_texture]);
        let parts = g.shapes.meshes.iter().flat_map(|m| m.textures.iter().copied());
        let parts = parts.chain(g.shapes.blobs.iter().flat_map(|b| b.textures.iter().copied()));
        let inside = |o: &u32| g.objects.get(*o as usize).map_or([0; 2], |o| [o.inside.start, o.inside.len]);
        Self {
            textures: surfaces.chain(parts).filter(|t| *t != NONE).collect(),
            pigments: scene.sky.iter().flat_map(|s| s.pigments.iter().copied()).collect(),
            normals: (scene.camera_normal != NONE).then_some(scene.camera_normal).into_iter().collect(),
            functions: BTreeSet::new(),
            insides: scene.textures.pattern_objects.iter().map(inside).collect(),
            most_written: None,
        }
    }
}

/// Texture tables as the shaders read them.
#[derive(Clone, Debug)]
pub struct TextureWords {
    /// `texture_words`.
    pub words: Vec<u32>,
    /// `image_words`: pixels and density grids.
    pub image_words: Vec<u32>,
    /// Record of each texture, 0 for those that were not asked for.
    pub textures: Vec<u32>,
    /// Record of each pigment, likewise.
    pub pigments: Vec<u32>,
    /// Record of each normal, likewise.
    pub normals: Vec<u32>,
    /// Functions that are interpreted.
    pub interpreted: BTreeSet<FunctionIx>,
    /// Features and constants of the shaders that read these words.
    pub shader: ShaderOptions,
}

/// Encodes what `roots` need. `quick_colors`: layers show their `quick_color` where they have one.
///
/// Fails with `BackendError::Unsupported` when something that is asked for cannot be evaluated on the GPU yet.
pub fn encode_textures(tables: &TextureTables, roots: &TextureRoots, quick_colors: bool) -> Result<TextureWords, BackendError> {
    let NoiseTables { words, places } = NoiseTables::default();
    let mut encoder = TextureEncoder::new(tables, &roots.insides, words, quick_colors);
    let mut out = TextureWords {
        words: Vec::new(),
        image_words: Vec::new(),
        textures: vec![0; tables.textures.len()],
        pigments: vec![0; tables.pigments.len()],
        normals: vec![0; tables.normals.len()],
        interpreted: BTreeSet::new(),
        shader: ShaderOptions::default(),
    };
    // Surfaces are searched with hundreds of calls: those are the first to be written out.
    for ix in &roots.functions {
        encoder.function(*ix);
    }
    for ix in &roots.textures {
        out.textures[*ix as usize] = encoder.cover(*ix)?;
    }
    for ix in &roots.pigments {
        out.pigments[*ix as usize] = encoder.pigment(*ix)?;
    }
    for ix in &roots.normals {
        out.normals[*ix as usize] = encoder.normal(*ix)?;
    }
    out.shader.functions = encoder.function_module(roots.most_written.unwrap_or(usize::MAX))?;
    out.interpreted = std::mem::take(&mut encoder.functions.interpreted);
    let [n_registers, numbers_at] = encoder.functions.places;
    out.shader.constant("FUNCTION_REGISTERS", n_registers);
    out.shader.constant("FUNCTION_NUMBERS_AT", numbers_at);
    for (name, value) in layout_constants() {
        out.shader.constant(&name, value);
    }
    for (name, place) in places {
        out.shader.constant(name, place);
    }
    for (name, depth) in encoder.stacks() {
        out.shader.constant(&format!("{name}_STACK"), depth);
    }
    out.words = encoder.words;
    out.image_words = encoder.images.words;
    out.shader.features.extend(encoder.features);
    Ok(out)
}
