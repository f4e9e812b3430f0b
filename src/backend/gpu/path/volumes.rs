//! Volumes as words: what fills each material's bodies and the world, grids, bodies around the camera. Twin: `shaders/path/volume.wesl`.

use super::super::buffers::{append, bits, inverse_rows};
use super::inputs::Encoder;
use crate::compile::CompiledScene;
use crate::integrate::path::{MAX_BODIES, PathPlan, WORLD_BODY, grid_summary};
use crate::math::{Rgb, Transform};
use crate::scene::Volume;
use crate::scene::volume::{Density, Grid};
use std::collections::{HashMap, HashSet};
use std::sync::Arc;

/// Words of a volume: name and length.
const VOLUME: &[(&str, u32)] =
    &[("ABSORPTION", 3), ("SCATTERING", 3), ("EMISSION", 3), ("ANISOTROPY", 1), ("GRID", 1), ("MOST", 1), ("AVERAGE", 1)];

/// Names and numbers for the shaders.
pub(super) fn volume_constants() -> Vec<(String, u32)> {
    let mut at = 0;
    let place = |(name, len): &(&str, u32)| {
        at += len;
        (format!("VOLUME_{name}"), at - len)
    };
    VOLUME.iter().map(place).collect()
}

/// Volumes on their way into words.
#[derive(Default)]
pub(super) struct Volumes {
    /// By cells of a grid: they are written once.
    cells: HashMap<*const Grid, u32>,
}

impl Volumes {
    /// Place of a volume's words.
    pub fn encode(&mut self, v: &Volume, e: &mut Encoder) -> u32 {
        e.features.insert("volumes");
        let (most, average) = grid_summary(v);
        let grid = v.density.as_ref().map_or(0, |d| self.grid(d, e));
        let mut w = Vec::new();
        w.extend([v.absorption, v.scattering, v.emission].iter().flat_map(|c: &Rgb| bits(c.to_array())));
        w.extend([v.anisotropy.to_bits(), grid, most.to_bits(), average.to_bits()]);
        debug_assert_eq!(w.len() as u32, VOLUME.iter().map(|f| f.1).sum::<u32>(), "as the shader reads it");
        append(&mut e.words, w)
    }

    /// Place of a grid: rows of the map into its unit cube, place of its cells.
    fn grid(&mut self, d: &Density, e: &mut Encoder) -> u32 {
        e.features.insert("grids");
        let words = &mut e.words;
        let cells = *self
            .cells
            .entry(Arc::as_ptr(&d.grid))
            .or_insert_with(|| append(words, d.grid.size.into_iter().chain(d.grid.cells.iter().map(|v| v.to_bits()))));
        append(words, inverse_rows(&d.transform).chain([cells]))
    }
}

/// The world's volume and the bodies around the camera: their number, then words of the object and of the volume of each.
/// `objects`: place of each primitive's words; `of_material`: place of each material's volume.
pub(super) fn camera_bodies(
    scene: &CompiledScene,
    plan: &PathPlan,
    objects: &HashMap<u32, u32>,
    of_material: &[u32],
    volumes: &mut Volumes,
    e: &mut Encoder,
) -> u32 {
    let world = scene.environment.as_ref().and_then(|w| w.volume.as_ref()).map(|v| {
        let nowhere = std::iter::once(WORLD_BODY).chain(inverse_rows(&Transform::IDENTITY));
        (append(&mut e.words, nowhere), volumes.encode(v, e))
    });
    let body = |(object, material): &(u32, u32)| {
        if *object == WORLD_BODY {
            return world;
        }
        let first = scene.geometry.objects.get(*object as usize)?.prims.start;
        Some((*objects.get(&first)?, *of_material.get(*material as usize)?))
    };
    let bodies: Vec<(u32, u32)> = plan.camera_bodies().iter().filter_map(body).collect();
    append(&mut e.words, std::iter::once(bodies.len() as u32).chain(bodies.iter().flat_map(|b| [b.0, b.1])))
}

/// How many bodies a ray can be inside at once.
pub(super) fn most_bodies(scene: &CompiledScene) -> u32 {
    // As many as there are objects, and the world.
    let objects: HashSet<u32> = scene.geometry.prims.iter().map(|p| p.object_ix).collect();
    (objects.len() + 1).min(MAX_BODIES) as u32
}
