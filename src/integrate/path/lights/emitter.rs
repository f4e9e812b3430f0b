//! Shining triangles of meshes as lights; two that make up a rectangle and shine alike are one.

use super::rectangle::Rectangle;
use super::tree::TreeLight;
use super::{LightSample, triangle};
use crate::compile::CompiledScene;
use crate::compile::geometry::{PrimKind, prim_flags};
use crate::compile::merged::{MergedMeshes, world_corner};
use crate::compile::shape::MeshShape;
use crate::compile::texture::TextureNode;
use crate::integrate::path::closure::{emission, plain_emission};
use crate::integrate::path::surface::Surface;
use crate::kernel::SurfaceHit;
use crate::kernel::traverse::motion_at;
use crate::math::{Bounds, DVec2, DVec3, Rgb, Vec3};
use crate::scene::input::Color;
use crate::scene::shader::{Closure, EmissionSampling, Shader};
use std::collections::HashMap;
use std::f64::consts::PI;
use std::sync::Arc;

/// A shining triangle at rest, in world space.
#[derive(Clone, Debug)]
pub struct Emitter {
    /// Its primitive and face.
    pub prim_ix: u32,
    /// Face of the mesh.
    pub face_ix: u32,
    shader: u32,
    corners: [DVec3; 3],
    /// Unit front.
    normal: DVec3,
    area: f64,
    /// Only its front is sampled: the back cannot be seen.
    pub front_only: bool,
    moves: bool,
    /// What it shines with, where that is the same everywhere and in all directions.
    even: Option<Rgb>,
    /// It is a rectangle, of this face and the next.
    pub rectangle: Option<Rectangle>,
}

/// All of them.
pub struct Emitters {
    /// In the order of primitives and faces.
    pub list: Vec<Emitter>,
    /// First emitter of a primitive, and of which of its faces they are (`None`: all).
    first: HashMap<u32, (u32, Option<HashMap<u32, u32>>)>,
}

/// A colour's mean over its picture.
fn mean_of(c: &Color) -> Rgb {
    let picture = c.picture.as_ref().map_or(Vec3::ONE, |p| crate::kernel::material::mean_color(&p.texture));
    c.factor * picture
}

/// About the radiance of a closure.
fn mean_emission(c: &Closure) -> Rgb {
    match c {
        Closure::Emission { color, strength } => {
            mean_of(color) * strength.as_constant().unwrap_or(strength.factor.max(strength.offset)).max(0.0)
        }
        Closure::Principled(p) => {
            let s = &p.emission_strength;
            mean_of(&p.emission_color) * s.as_constant().unwrap_or(s.factor.max(s.offset)).max(0.0)
        }
        Closure::Mix { a, b, .. } => 0.5 * (mean_emission(a) + mean_emission(b)),
        Closure::Add(a, b) => mean_emission(a) + mean_emission(b),
        _ => Vec3::ZERO,
    }
}

/// Whether every edge has two faces that run along it in opposite ways.
fn is_closed(faces: &[[u32; 3]], vertices: &[Vec3]) -> bool {
    // Vertices that lie in one place are one: exporters split them at seams.
    let mut places: HashMap<[u32; 3], u32> = HashMap::new();
    let ids: Vec<u32> = vertices
        .iter()
        .map(|v| {
            let n = places.len() as u32;
            *places.entry(v.to_array().map(|c| (c + 0.0).to_bits())).or_insert(n)
        })
        .collect();
    let mut edges: HashMap<(u32, u32), i32> = HashMap::new();
    for f in faces {
        let f = f.map(|v| ids[v as usize]);
        for k in 0..3 {
            let (a, b) = (f[k], f[(k + 1) % 3]);
            if a != b {
                *edges.entry((a.min(b), a.max(b))).or_insert(0) += if a < b { 1 } else { 65_537 };
            }
        }
    }
    !edges.is_empty() && edges.values().all(|n| *n == 65_538)
}

/// Six times the volume inside faces that run counterclockwise seen from outside.
fn volume(faces: &[[u32; 3]], vertices: &[Vec3]) -> f64 {
    let at = |k: u32| vertices[k as usize].as_dvec3();
    faces.iter().map(|f| at(f[0]).dot(at(f[1]).cross(at(f[2])))).sum()
}

impl Emitters {
    /// Of a scene whose materials have `shaders`. Faces stand where the rays meet them: those in `merged` have rounded corners.
    pub fn new(scene: &CompiledScene, shaders: &[Arc<Shader>], merged: Option<&MergedMeshes>) -> (Self, Vec<TreeLight>) {
        let g = &scene.geometry;
        let mut all = Self { list: Vec::new(), first: HashMap::new() };
        let mut lights = Vec::new();
        let mut closed: HashMap<u32, bool> = HashMap::new();
        let radiances: Vec<f64> = shaders
            .iter()
            .map(|s| s.surface.as_ref().map_or(0.0, |c| f64::from(mean_emission(c).max(Vec3::ZERO).element_sum() / 3.0)))
            .collect();
        for (prim_ix, prim) in g.prims.iter().enumerate() {
            if prim.kind != PrimKind::Mesh || prim.flags & prim_flags::HIDDEN != 0 {
                continue;
            }
            let shape = &g.shapes.meshes[prim.shape_ix as usize];
            let mesh = &shape.mesh;
            let node = |t: u32| match scene.textures.textures.get(t as usize) {
                Some(TextureNode::Principled(ix)) => Some(*ix),
                _ => None,
            };
            let own = node(g.surfaces[prim.surface_ix as usize].texture);
            let shader_of = |face: usize| match mesh.face_textures.get(face) {
                Some([k, ..]) if *k != u32::MAX => shape.textures.get(*k as usize).and_then(|t| node(*t)),
                _ => own,
            };
            let shines = |s: Option<u32>| {
                s.filter(|s| radiances[*s as usize] > 0.0 && shaders[*s as usize].emission_sampling != EmissionSampling::None)
            };
            if mesh.face_textures.is_empty() && shines(own).is_none() {
                continue;
            }
            let transform = g.transforms[prim.transform_ix as usize];
            let first = all.list.len() as u32;
            let is_merged = merged.is_some_and(|m| m.member(prim_ix as u32).is_some());
            let in_world = |c: DVec3| match is_merged {
                true => world_corner(g, prim_ix as u32, c.as_vec3()).as_dvec3(),
                false => transform.point(c),
            };
            let mut by_face = HashMap::new();
            let is_solid = || {
                is_closed(&mesh.faces, &mesh.vertices)
                    && volume(&mesh.faces, &mesh.vertices) * transform.forward.matrix3.determinant().signum() > 0.0
            };
            for face in 0..mesh.faces.len() {
                let Some(shader) = shines(shader_of(face)) else { continue };
                let corners = shape.corners(face as u32).map(in_world);
                let cross = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
                let area = 0.5 * cross.length();
                if !(area > 0.0) {
                    continue;
                }
                let front_only = *closed.entry(prim.shape_ix).or_insert_with(is_solid);
                // The front of a mirrored mesh is where its own front goes.
                let sign = if transform.forward.matrix3.determinant() < 0.0 { -1.0 } else { 1.0 };
                let normal = sign * cross.normalize();
                let moves = prim.flags & prim_flags::MOVING != 0 || shape.moving.is_some();
                let mut bounds = Bounds::from_points(corners);
                if moves {
                    bounds = g.bounds[prim_ix];
                }
                let even = shaders[shader as usize].surface.as_ref().and_then(plain_emission).filter(|e| e[0] == e[1]).map(|e| e[0]);
                let (prim_ix, face_ix) = (prim_ix as u32, face as u32);
                let light = TreeLight {
                    bounds,
                    axis: normal,
                    spread_rad: if front_only && !moves { 0.0 } else { PI },
                    reach_rad: 0.5 * PI,
                    energy: radiances[shader as usize] * area,
                };
                let emitter = Emitter { prim_ix, face_ix, shader, corners, normal, area, front_only, moves, even, rectangle: None };
                // Neighbours only: exporters cut quads into faces that follow each other.
                let half = all.list.get_mut(first as usize..).and_then(|own| own.last_mut());
                match half.and_then(|half| half.joined(&emitter).map(|r| (half, r))) {
                    Some((half, rectangle)) => {
                        half.rectangle = Some(rectangle);
                        let whole: &mut TreeLight = lights.last_mut().expect("an emitter has a light");
                        (whole.bounds, whole.energy) = (whole.bounds.union(light.bounds), whole.energy + light.energy);
                    }
                    None => {
                        all.list.push(emitter);
                        lights.push(light);
                    }
                }
                by_face.insert(face as u32, all.list.len() as u32 - 1);
            }
            if !by_face.is_empty() {
                let all_faces = all.list.len() - first as usize == mesh.faces.len();
                all.first.insert(prim_ix as u32, (first, (!all_faces).then_some(by_face)));
            }
        }
        (all, lights)
    }

    /// The emitter of a hit.
    pub fn of_hit(&self, hit: &SurfaceHit) -> Option<u32> {
        let (first, faces) = self.first.get(&hit.prim_ix)?;
        match faces {
            None => Some(first + hit.face_ix),
            Some(map) => map.get(&hit.face_ix).copied(),
        }
    }
}

impl Emitter {
    /// The rectangle that it makes up with the next triangle.
    fn joined(&self, next: &Self) -> Option<Rectangle> {
        let alike = self.rectangle.is_none()
            && self.face_ix + 1 == next.face_ix
            && self.shader == next.shader
            && self.even.is_some()
            && !(self.moves || next.moves);
        if alike { Rectangle::of(&self.corners, &next.corners) } else { None }
    }

    fn corners_at(&self, scene: &CompiledScene, time: f64) -> ([DVec3; 3], DVec3, f64) {
        if !self.moves {
            return (self.corners, self.normal, self.area);
        }
        let g = &scene.geometry;
        let prim = &g.prims[self.prim_ix as usize];
        let place = g.transforms[prim.transform_ix as usize].then(&motion_at(g, prim, time));
        let c = g.shapes.meshes[prim.shape_ix as usize].corners_at(self.face_ix, time).map(|p| place.point(p));
        let cross = (c[1] - c[0]).cross(c[2] - c[0]);
        // The front of a mirrored mesh is where its own front goes.
        let sign = if place.forward.matrix3.determinant() < 0.0 { -1.0 } else { 1.0 };
        (c, (sign * cross).normalize_or(self.normal), 0.5 * cross.length())
    }

    /// The faces that it is of.
    pub fn faces(&self) -> std::ops::RangeInclusive<u32> {
        self.face_ix..=self.face_ix + u32::from(self.rectangle.is_some())
    }

    /// Its middle, at rest.
    pub fn center(&self) -> DVec3 {
        self.rectangle.map_or_else(|| (self.corners[0] + self.corners[1] + self.corners[2]) / 3.0, |r| r.center)
    }

    /// A point of it as seen from `from`.
    #[inline]
    pub fn sample(&self, scene: &CompiledScene, shaders: &[Arc<Shader>], from: DVec3, time: f64, [u, v]: [f32; 2]) -> Option<LightSample> {
        if let (Some(rectangle), Some(radiance)) = (&self.rectangle, self.even) {
            let (to, density) = rectangle.sample(from, [u.into(), v.into()]);
            let d_sq = to.length_squared();
            let distance = d_sq.sqrt();
            let dir = to / distance;
            let cos = self.lit_cos(self.normal, dir, distance)?;
            let pdf = density.unwrap_or_else(|| triangle::density_by_area(rectangle.area, d_sq, cos)) as f32;
            return Some(LightSample { dir, distance, radiance, pdf, ..LightSample::NONE });
        }
        let (c, normal, area) = self.corners_at(scene, time);
        let drawn = triangle::sample(c, from, [u.into(), v.into()]);
        let [b1, b2] = drawn.weights;
        let point = c[0] + b1 * (c[1] - c[0]) + b2 * (c[2] - c[0]);
        let to = point - from;
        let d_sq = to.length_squared();
        let distance = d_sq.sqrt();
        let dir = to / distance;
        let cos = self.lit_cos(normal, dir, distance)?;
        let radiance = self.even.unwrap_or_else(|| {
            let hit = SurfaceHit {
                t: distance,
                prim_ix: self.prim_ix,
                face_ix: self.face_ix,
                point,
                // As rays have it that meet flat faces.
                normal: if self.shape(scene).is_smooth(self.face_ix) { normal } else { -normal },
                uv: self.uv(scene, b1, b2),
                barycentric: DVec2::new(b1, b2),
            };
            let surface = Surface::new(scene, hit, dir, time);
            shaders[self.shader as usize].surface.as_ref().map_or(Vec3::ZERO, |c| emission(c, &surface))
        });
        let pdf = drawn.density.unwrap_or_else(|| triangle::density_by_area(area, d_sq, cos)) as f32;
        Some(LightSample { dir, distance, radiance, pdf, ..LightSample::NONE })
    }

    /// Cosine at which light leaves towards where `dir` comes from, if any does; `normal` is the front's.
    #[inline]
    fn lit_cos(&self, normal: DVec3, dir: DVec3, distance: f64) -> Option<f64> {
        let cos = -dir.dot(normal);
        (cos != 0.0 && distance > 0.0 && !(self.front_only && cos < 0.0)).then_some(cos)
    }

    /// Density with which [`Self::sample`] draws a hit by a ray from `from` along `dir` of length `t`.
    #[inline]
    pub fn density(&self, scene: &CompiledScene, from: DVec3, dir: DVec3, t: f64, time: f64) -> f32 {
        if let Some(rectangle) = &self.rectangle {
            return self.lit_cos(self.normal, dir, t).map_or(0.0, |cos| rectangle.density(from, t * t, cos) as f32);
        }
        let (corners, normal, area) = self.corners_at(scene, time);
        self.lit_cos(normal, dir, t).map_or(0.0, |cos| triangle::density(corners, from, area, t * t, cos) as f32)
    }

    fn shape<'s>(&self, scene: &'s CompiledScene) -> &'s MeshShape {
        let g = &scene.geometry;
        &g.shapes.meshes[g.prims[self.prim_ix as usize].shape_ix as usize]
    }

    fn uv(&self, scene: &CompiledScene, b1: f64, b2: f64) -> DVec2 {
        let mesh = &self.shape(scene).mesh;
        let Some(ix) = mesh.uv_indices.get(self.face_ix as usize) else { return DVec2::ZERO };
        let c = ix.map(|k| mesh.uvs.get(k as usize).map_or(DVec2::ZERO, |c| DVec2::new(c[0].into(), c[1].into())));
        (1.0 - b1 - b2) * c[0] + b1 * c[1] + b2 * c[2]
    }
}
