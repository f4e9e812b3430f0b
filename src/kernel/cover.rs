//! Which textures a hit shows, and how much of each. Each is fully shaded and the results are averaged.
//! Source: spec/light.md, section 3; spec/objects.md, sections 4, 6 and 13.

use super::inside::run_program;
use super::intersect::blob::blob_weights;
use super::{PatternPoint, SurfaceHit};
use crate::compile::geometry::{Prim, PrimKind, Surface, prim_flags};
use crate::compile::{CompiledScene, NONE};
use crate::math::DVec3;

/// A texture that a hit shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cover {
    /// Into `TextureTables::textures`.
    pub texture: u32,
    /// World from the texture's space, into `Geometry::transforms`.
    pub transform_ix: u32,
    /// Share; those of a hit add up to 1.
    pub weight: f32,
}

/// Where the patterns of a cover in space `transform_ix` are looked up.
pub fn pattern_point(
    scene: &CompiledScene,
    hit: &SurfaceHit,
    prim: &Prim,
    transform_ix: u32,
    normal: DVec3,
    ray_dir: DVec3,
) -> PatternPoint {
    let point = if prim.flags & prim_flags::UV_MAPPING != 0 {
        DVec3::new(hit.uv.x, hit.uv.y, 0.0)
    } else if transform_ix == 0 {
        hit.point
    } else {
        scene.geometry.transforms[transform_ix as usize].inverse_point(hit.point)
    };
    PatternPoint { point, uv: hit.uv, world: hit.point, normal, ray_dir }
}

/// Calls `f` with every texture of a hit; with none where nothing is drawn. `from_inside`: the normal, inversion applied, runs with the ray.
pub fn for_covers(scene: &CompiledScene, hit: &SurfaceHit, from_inside: bool, mut f: impl FnMut(Cover)) {
    let g = &scene.geometry;
    let prim = &g.prims[hit.prim_ix as usize];
    let surface = &g.surfaces[prim.surface_ix as usize];
    let own_space = if prim.flags & prim_flags::UV_MAPPING != 0 { 0 } else { prim.transform_ix };
    match prim.kind {
        PrimKind::Mesh => {
            let mesh = &g.shapes.meshes[prim.shape_ix as usize];
            if let Some(corners) = mesh.mesh.face_textures.get(hit.face_ix as usize) {
                let cover = |k: u32, weight: f64| match mesh.textures.get(k as usize) {
                    Some(t) => Cover { texture: *t, transform_ix: own_space, weight: weight as f32 },
                    None => Cover { texture: surface.texture, transform_ix: surface.transform_ix, weight: weight as f32 },
                };
                if corners[0] == corners[1] && corners[0] == corners[2] {
                    if corners[0] != u32::MAX {
                        return f(cover(corners[0], 1.0));
                    }
                } else {
                    let b = hit.barycentric;
                    let w = [1.0 - b.x - b.y, b.x, b.y].map(|w| w.max(0.0));
                    let sum: f64 = w.iter().sum();
                    return (0..3).filter(|k| w[*k] > 0.0).for_each(|k| f(cover(corners[k], w[k] / sum)));
                }
            }
        }
        PrimKind::Blob => {
            let blob = &g.shapes.blobs[prim.shape_ix as usize];
            if blob.textures.iter().any(|t| *t != NONE) {
                let local = g.transforms[prim.transform_ix as usize].inverse_point(hit.point);
                let mut sum = 0.0;
                blob_weights(blob, local, |_, w| sum += w);
                if sum > 0.0 {
                    blob_weights(blob, local, |component, w| {
                        let (texture, transform_ix) = match blob.textures[component as usize] {
                            NONE => (surface.texture, surface.transform_ix),
                            t => (t, own_space),
                        };
                        f(Cover { texture, transform_ix, weight: (w / sum) as f32 });
                    });
                    return;
                }
            }
        }
        _ => {}
    }
    match whole_cover(surface, from_inside) {
        Some(cover) => f(cover),
        None => cutaway(scene, hit, prim.object_ix, f),
    }
}

/// The one texture that a hit shows, told at once for what is neither a mesh nor a blob nor cut away: what [`for_covers`] would be called with.
#[inline]
pub fn sole_cover(scene: &CompiledScene, hit: &SurfaceHit, from_inside: bool) -> Option<Cover> {
    let g = &scene.geometry;
    let prim = &g.prims[hit.prim_ix as usize];
    if matches!(prim.kind, PrimKind::Mesh | PrimKind::Blob) {
        return None;
    }
    whole_cover(&g.surfaces[prim.surface_ix as usize], from_inside)
}

/// The texture of a whole surface on the side that is seen, if there is one.
#[inline]
fn whole_cover(surface: &Surface, from_inside: bool) -> Option<Cover> {
    let texture = if from_inside && surface.interior_texture != NONE { surface.interior_texture } else { surface.texture };
    (texture != NONE).then_some(Cover { texture, transform_ix: surface.transform_ix, weight: 1.0 })
}

/// The textures of the cut parts that the point is inside, in equal shares.
fn cutaway(scene: &CompiledScene, hit: &SurfaceHit, object_ix: u32, mut f: impl FnMut(Cover)) {
    let g = &scene.geometry;
    let range = &g.objects[object_ix as usize].cutaway;
    let parts = &g.cutaway_parts[range.start as usize..range.end as usize];
    let shown = |p: &&(crate::compile::geometry::InsideProgram, u32)| {
        g.surfaces[p.1 as usize].texture != NONE && run_program(scene, p.0, u32::MAX, hit.point)
    };
    let n = parts.iter().filter(shown).count();
    for (_, surface_ix) in parts.iter().filter(shown) {
        let Surface { texture, transform_ix, .. } = g.surfaces[*surface_ix as usize];
        f(Cover { texture, transform_ix, weight: 1.0 / n as f32 });
    }
}
