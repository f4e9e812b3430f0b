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
/// A round body with fewer points than this is one ball: so few faces of it would shine one way.
const FEWEST_OF_ROUND: usize = 8;

/// A piece of a shining surface.
#[derive(Clone, Copy, Debug)]
pub struct EmitterPoint {
    /// Its middle.
    pub point: DVec3,
    /// What it stands for.
    pub shape: Piece,
    /// Of either side.
    pub radiance: Rgb,
    /// Whose it is.
    pub prim_ix: u32,
}

impl EmitterPoint {
    /// Irradiance at right angles, at `distance` against `dir` (unit, towards the piece).
    pub fn irradiance(&self, dir: DVec3, distance: f64) -> Rgb {
        let solid_angle = match self.shape {
            // Near a piece, a disc of its area: the point alone would be infinitely bright.
            Piece::Flat { normal, area } => area * normal.dot(dir).abs() / (distance * distance + area / PI),
            Piece::Ball { radius } => PI * (radius / distance.max(radius)).powi(2),
        };
        self.radiance * solid_angle as f32
    }

    /// How far a shadow ray towards it must be free, of `distance`.
    pub fn free_way(&self, distance: f64) -> f64 {
        match self.shape {
            Piece::Flat { .. } => distance,
            Piece::Ball { radius } => distance - 1.05 * radius,
        }
    }
}

/// What a point stands for.
#[derive(Clone, Copy, Debug)]
pub enum Piece {
    /// A small flat piece with a unit normal; both sides shine.
    Flat {
        /// Unit.
        normal: DVec3,
        /// In the world.
        area: f64,
    },
    /// A whole round body: a quarter of its surface is what is seen of it (Cauchy).
    Ball {
        /// Of a ball with its surface.
        radius: f64,
    },
}

struct Emitter {
    prim_ix: u32,
    radiance: Rgb,
    area: f64,
    /// Mean place of its surface.
    center: DVec3,
    /// Its faces look all ways.
    is_round: bool,
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
        let (mut area, mut center, mut facing) = (0.0, DVec3::ZERO, DVec3::ZERO);
        for corners in (0..n_faces(g, prim)).map(|f| world_corners(g, prim, f)) {
            let face = face_area(&corners);
            area += face.length();
            facing += face;
            center += face.length() / 3.0 * (corners[0] + corners[1] + corners[2]);
        }
        if area > 0.0 && radiance.max_element() > 0.0 {
            list.push(Emitter { prim_ix: ix as u32, radiance, area, center: center / area, is_round: facing.length() < 0.5 * area });
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
    if e.is_round && n < FEWEST_OF_ROUND {
        let shape = Piece::Ball { radius: (e.area / (4.0 * PI)).sqrt() };
        return vec![EmitterPoint { point: e.center, shape, radiance: e.radiance, prim_ix: e.prim_ix }];
    }
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
            out.push(EmitterPoint { point, shape: Piece::Flat { normal, area: share }, radiance: e.radiance, prim_ix: e.prim_ix });
        }
    }
    out
}
