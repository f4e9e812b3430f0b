//! Shining surfaces of imports as light sources of the classic integrator: a few fixed points each. No noise, but their shadows are
//! made of as many hard ones. The path integrator samples the surfaces themselves.

use crate::compile::CompiledScene;
use crate::compile::geometry::{Geometry, Prim, PrimKind, prim_flags};
use crate::compile::texture::TextureNode;
use crate::kernel::material::mean_color;
use crate::math::{DVec3, Rgb, Vec3};
use std::f64::consts::PI;

/// Points of all emitters together, and of one; each costs a shadow ray a hit. Picked by feel.
const MAX_POINTS: usize = 64;
const MAX_POINTS_EACH: usize = 16;

/// A piece of a shining surface.
#[derive(Clone, Copy, Debug)]
pub struct EmitterPoint {
    /// Its middle.
    pub point: DVec3,
    /// Unit; both sides shine.
    normal: DVec3,
    area: f64,
    radiance: Rgb,
    /// Whose it is.
    pub prim_ix: u32,
}

impl EmitterPoint {
    /// Irradiance at right angles, at `distance` against `dir` (unit, towards the piece).
    pub fn irradiance(&self, dir: DVec3, distance: f64) -> Rgb {
        // Near a piece, a disc of its area: the point alone would be infinitely bright.
        let solid_angle = self.area * self.normal.dot(dir).abs() / (distance * distance + self.area / PI);
        self.radiance * solid_angle as f32
    }
}

struct Emitter {
    prim_ix: u32,
    radiance: Rgb,
    area: f64,
}

/// Corners of a face in the world.
fn world_corners(g: &Geometry, prim: &Prim, face: u32) -> [DVec3; 3] {
    let t = &g.transforms[prim.transform_ix as usize];
    g.shapes.meshes[prim.shape_ix as usize].corners(face).map(|p| t.point(p))
}

fn n_faces(g: &Geometry, prim: &Prim) -> u32 {
    g.shapes.meshes[prim.shape_ix as usize].mesh.faces.len() as u32
}

/// The points that stand for a scene's shining meshes.
pub fn emitter_points(scene: &CompiledScene) -> Vec<EmitterPoint> {
    let g = &scene.geometry;
    let mut list: Vec<Emitter> = Vec::new();
    for (ix, prim) in g.prims.iter().enumerate().filter(|(_, p)| p.kind == PrimKind::Mesh && p.flags & prim_flags::HIDDEN == 0) {
        let texture = scene.textures.textures.get(g.surfaces[prim.surface_ix as usize].texture as usize);
        let Some(TextureNode::Principled(k)) = texture else { continue };
        let m = &scene.textures.principled[*k as usize];
        if !m.is_emitter() {
            continue;
        }
        let radiance = m.emission * m.emission_texture.as_ref().map_or(Vec3::ONE, mean_color);
        let area: f64 = (0..n_faces(g, prim)).map(|f| face_area(&world_corners(g, prim, f)).length()).sum();
        if area > 0.0 && radiance.max_element() > 0.0 {
            list.push(Emitter { prim_ix: ix as u32, radiance, area });
        }
    }
    let power = |e: &Emitter| e.area * f64::from(e.radiance.max_element());
    list.sort_by(|a, b| power(b).total_cmp(&power(a)));
    list.truncate(MAX_POINTS);
    let each = (MAX_POINTS / list.len().max(1)).clamp(1, MAX_POINTS_EACH);
    list.iter().flat_map(|e| points_of(g, e, each)).collect()
}

/// Half the cross product: normal times area.
fn face_area([a, b, c]: &[DVec3; 3]) -> DVec3 {
    0.5 * (*b - *a).cross(*c - *a)
}

/// `n` points, each in the middle of its share of the area, spread over the faces in their order.
fn points_of(g: &Geometry, e: &Emitter, n: usize) -> Vec<EmitterPoint> {
    let prim = &g.prims[e.prim_ix as usize];
    let share = e.area / n as f64;
    let (mut out, mut passed) = (Vec::with_capacity(n), 0.0);
    for face in 0..n_faces(g, prim) {
        let corners = world_corners(g, prim, face);
        let area = face_area(&corners);
        passed += area.length();
        while out.len() < n && (out.len() as f64 + 0.5) * share <= passed {
            // Two low-discrepancy numbers a point, folded into the triangle. Source: Roberts 2018 (R2 sequence).
            let k = out.len() as f64 + 0.5;
            let (mut u, mut v) = ((k * 0.754_877_666_246_692_7).fract(), (k * 0.569_840_290_998_053_2).fract());
            if u + v > 1.0 {
                (u, v) = (1.0 - u, 1.0 - v);
            }
            let point = corners[0] + u * (corners[1] - corners[0]) + v * (corners[2] - corners[0]);
            let normal = area.try_normalize().unwrap_or(DVec3::Y);
            out.push(EmitterPoint { point, normal, area: share, radiance: e.radiance, prim_ix: e.prim_ix });
        }
    }
    out
}
