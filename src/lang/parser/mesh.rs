//! Meshes, polygons and patches. Source: spec/language.md, section 7; spec/objects.md, section 6.

use super::{PResult, Parser};
use crate::lang::keyword::Kw;
use crate::lang::token::{Punct, TokenKind};
use crate::lang::value::Value;
use crate::math::{DVec2, DVec3, EPSILON, Vec3};
use crate::scene::{Mesh, Shape, Texture};
use std::collections::HashMap;
use std::sync::Arc;

const FLAT: [u32; 3] = [u32::MAX; 3];

/// Meshes are kept small enough for 32-bit indices and memory.
const MAX_ITEMS: i64 = 1 << 28;

/// A mesh being made of single triangles: equal vertices become one.
#[derive(Default)]
struct Builder {
    mesh: Mesh,
    vertex_ix: HashMap<[u32; 3], u32>,
    normal_ix: HashMap<[u32; 3], u32>,
    uv_ix: HashMap<[u32; 2], u32>,
    texture_ix: HashMap<*const Texture, u32>,
}

impl Builder {
    fn vertex(&mut self, v: DVec3) -> u32 {
        let v = v.as_vec3();
        *self.vertex_ix.entry(v.to_array().map(f32::to_bits)).or_insert_with(|| {
            self.mesh.vertices.push(v);
            self.mesh.vertices.len() as u32 - 1
        })
    }

    fn normal(&mut self, n: DVec3) -> u32 {
        let n = unit_normal(n);
        *self.normal_ix.entry(n.to_array().map(f32::to_bits)).or_insert_with(|| {
            self.mesh.normals.push(n);
            self.mesh.normals.len() as u32 - 1
        })
    }

    fn uv(&mut self, uv: DVec2) -> u32 {
        let uv = [uv.x as f32, uv.y as f32];
        *self.uv_ix.entry(uv.map(f32::to_bits)).or_insert_with(|| {
            self.mesh.uvs.push(uv);
            self.mesh.uvs.len() as u32 - 1
        })
    }

    fn texture(&mut self, t: Arc<Texture>) -> u32 {
        let textures = &mut self.mesh.textures;
        *self.texture_ix.entry(Arc::as_ptr(&t)).or_insert_with(|| {
            textures.push(t);
            textures.len() as u32 - 1
        })
    }
}

fn unit_normal(n: DVec3) -> Vec3 {
    n.try_normalize().unwrap_or(DVec3::X).as_vec3()
}

fn is_degenerate(v: [DVec3; 3]) -> bool {
    let n = (v[2] - v[0]).cross(v[1] - v[0]);
    !(n.length() > 0.0) || !n.is_finite()
}

impl Parser<'_> {
    pub(super) fn parse_mesh(&mut self) -> PResult<Shape> {
        let mut b = Builder::default();
        let (mut any_texture, mut any_normal) = (false, false);
        loop {
            let smooth = match self.peek_kw()? {
                Some(Kw::Triangle) => false,
                Some(Kw::SmoothTriangle) => true,
                _ => break,
            };
            self.next()?;
            let word = if smooth { "smooth_triangle" } else { "triangle" };
            let (vertices, normals, uvs, textures) = self.block(word, |p| p.mesh_triangle(smooth))?;
            if is_degenerate(vertices) {
                continue;
            }
            let face = vertices.map(|v| b.vertex(v));
            b.mesh.faces.push(face);
            // Three equal normals make a flat face.
            let normal_ix = match normals {
                Some(n) if n[0] != n[1] || n[0] != n[2] => {
                    any_normal = true;
                    n.map(|n| b.normal(n))
                }
                _ => FLAT,
            };
            b.mesh.normal_indices.push(normal_ix);
            let uv_ix = uvs.unwrap_or([DVec2::ZERO; 3]).map(|uv| b.uv(uv));
            b.mesh.uv_indices.push(uv_ix);
            any_texture |= textures.is_some();
            let texture_ix = textures.map_or(FLAT, |t| t.map(|t| b.texture(t)));
            b.mesh.face_textures.push(texture_ix);
            if b.mesh.faces.len() as i64 > MAX_ITEMS {
                return Err(self.error("Too many triangles in a mesh."));
            }
        }
        if b.mesh.faces.is_empty() {
            return Err(self.error("No triangles in mesh."));
        }
        if !any_normal {
            b.mesh.normal_indices.clear();
        }
        if !any_texture {
            b.mesh.face_textures.clear();
        }
        b.mesh.inside_vector = self.inside_vector()?;
        Ok(Shape::Mesh(Arc::new(b.mesh)))
    }

    fn inside_vector(&mut self) -> PResult<Option<DVec3>> {
        if !self.accept_kw(Kw::InsideVector)? {
            return Ok(None);
        }
        let v = self.parse_vector3()?;
        Ok(v.try_normalize())
    }

    #[expect(clippy::type_complexity, reason = "the parts of one triangle")]
    fn mesh_triangle(&mut self, smooth: bool) -> PResult<([DVec3; 3], Option<[DVec3; 3]>, Option<[DVec2; 3]>, Option<[Arc<Texture>; 3]>)> {
        let (mut v, mut n) = ([DVec3::ZERO; 3], [DVec3::ZERO; 3]);
        for i in 0..3 {
            if i > 0 {
                self.comma()?;
            }
            v[i] = self.parse_vector3()?;
            if smooth {
                self.comma()?;
                n[i] = self.parse_vector3()?;
            }
        }
        let (mut uvs, mut textures) = (None, None);
        loop {
            if self.accept_kw(Kw::UvVectors)? {
                let mut uv = [DVec2::ZERO; 3];
                for uv in &mut uv {
                    *uv = self.parse_vector2()?;
                    self.comma()?;
                }
                uvs = Some(uv);
            } else if self.accept_kw(Kw::Texture)? {
                let t = self.block("texture", |p| p.texture_name())?;
                textures = Some([t.clone(), t.clone(), t]);
            } else if self.accept_kw(Kw::TextureList)? {
                textures = Some(self.block("texture_list", |p| {
                    let a = p.texture_name()?;
                    p.comma()?;
                    let b = p.texture_name()?;
                    p.comma()?;
                    Ok([a, b, p.texture_name()?])
                })?);
            } else {
                return Ok((v, smooth.then_some(n), uvs, textures));
            }
        }
    }

    fn texture_name(&mut self) -> PResult<Arc<Texture>> {
        if let Some(Value::Texture(t)) = self.peek_value()? {
            let t = t.clone();
            self.next()?;
            return Ok(t);
        }
        self.expected("texture identifier")
    }

    fn count(&mut self) -> PResult<usize> {
        let n = self.parse_int()?;
        self.comma()?;
        if !(0..=MAX_ITEMS).contains(&n) {
            return Err(self.error("Illegal number of items in mesh2."));
        }
        Ok(n as usize)
    }

    pub(super) fn parse_mesh2(&mut self) -> PResult<Shape> {
        let mut m = Mesh::default();
        while let Some(k) = self.peek_kw()? {
            match k {
                Kw::VertexVectors => {
                    self.next()?;
                    self.block("vertex_vectors", |p| {
                        for _ in 0..p.count()? {
                            m.vertices.push(p.parse_vector3()?.as_vec3());
                            p.comma()?;
                        }
                        Ok(())
                    })?;
                }
                Kw::NormalVectors => {
                    self.next()?;
                    self.block("normal_vectors", |p| {
                        for _ in 0..p.count()? {
                            m.normals.push(unit_normal(p.parse_vector3()?));
                            p.comma()?;
                        }
                        Ok(())
                    })?;
                }
                Kw::UvVectors => {
                    self.next()?;
                    self.block("uv_vectors", |p| {
                        for _ in 0..p.count()? {
                            let uv = p.parse_vector2()?;
                            m.uvs.push([uv.x as f32, uv.y as f32]);
                            p.comma()?;
                        }
                        Ok(())
                    })?;
                }
                Kw::TextureList => {
                    self.next()?;
                    self.block("texture_list", |p| {
                        for _ in 0..p.count()? {
                            let t = if p.accept_kw(Kw::Texture)? { p.parse_texture_block()? } else { p.texture_name()? };
                            m.textures.push(t);
                            p.comma()?;
                        }
                        Ok(())
                    })?;
                }
                _ => break,
            }
        }
        if m.vertices.is_empty() {
            return Err(self.error("No vertices in triangle mesh."));
        }
        self.expect_kw(Kw::FaceIndices)?;
        self.block("face_indices", |p| p.faces(&mut m))?;
        if m.faces.is_empty() {
            return Err(self.error("No triangles in triangle mesh."));
        }
        loop {
            if self.accept_kw(Kw::UvIndices)? {
                m.uv_indices = self.block("uv_indices", |p| p.index_triples(m.uvs.len(), "uv"))?;
            } else if self.accept_kw(Kw::NormalIndices)? {
                m.normal_indices = self.block("normal_indices", |p| p.index_triples(m.normals.len(), "normal"))?;
            } else {
                break;
            }
        }
        self.complete_indices(&mut m)?;
        m.inside_vector = self.inside_vector()?;
        drop_degenerate(&mut m);
        Ok(Shape::Mesh(Arc::new(m)))
    }

    fn index_triple(&mut self, limit: usize, what: &str) -> PResult<[u32; 3]> {
        let v = self.parse_vector3()?;
        for x in v.to_array() {
            if !(x >= 0.0 && x < limit as f64) {
                return Err(self.error(format!("Mesh {what} index out of range.")));
            }
        }
        Ok(v.to_array().map(|x| x as u32))
    }

    fn index_triples(&mut self, limit: usize, what: &str) -> PResult<Vec<[u32; 3]>> {
        let n = self.count()?;
        let mut out = Vec::new();
        for _ in 0..n {
            out.push(self.index_triple(limit, what)?);
            self.comma()?;
        }
        Ok(out)
    }

    fn faces(&mut self, m: &mut Mesh) -> PResult<()> {
        let n = self.count()?;
        let mut any_texture = false;
        for _ in 0..n {
            m.faces.push(self.index_triple(m.vertices.len(), "face")?);
            self.comma()?;
            let mut t = FLAT;
            if !m.textures.is_empty() && self.number_is_scalar()? {
                t = [self.texture_index(m)?; 3];
                any_texture = true;
                self.comma()?;
                if self.number_is_scalar()? {
                    t[1] = self.texture_index(m)?;
                    self.comma()?;
                    t[2] = self.texture_index(m)?;
                    self.comma()?;
                }
            }
            m.face_textures.push(t);
        }
        if !any_texture {
            m.face_textures.clear();
        }
        Ok(())
    }

    /// Whether a number, not a vector, is next.
    fn number_is_scalar(&mut self) -> PResult<bool> {
        Ok(!self.at_punct(Punct::Lt)? && self.number_follows()?)
    }

    fn texture_index(&mut self, m: &Mesh) -> PResult<u32> {
        let x = self.parse_float()?;
        if !(x >= 0.0 && x < m.textures.len() as f64) {
            return Err(self.error("Texture index out of range."));
        }
        Ok(x as u32)
    }

    /// Indices that were left out.
    fn complete_indices(&mut self, m: &mut Mesh) -> PResult<()> {
        if m.normal_indices.is_empty() && !m.normals.is_empty() {
            if m.normals.len() != m.vertices.len() {
                return Err(self.error("Missing normal_indices section in mesh2."));
            }
            m.normal_indices = m.faces.clone();
        }
        if m.normal_indices.len() > m.faces.len() {
            return Err(self.error("Number of normal indices cannot be more than number of faces."));
        }
        if !m.normal_indices.is_empty() {
            m.normal_indices.resize(m.faces.len(), FLAT);
        }
        if m.uv_indices.is_empty() && !m.uvs.is_empty() {
            m.uv_indices = if m.uvs.len() == m.vertices.len() {
                m.faces.clone()
            } else if m.uvs.len() == 1 {
                vec![[0; 3]; m.faces.len()]
            } else {
                return Err(self.error("Missing uv_indices section in mesh2."));
            };
        }
        if !m.uv_indices.is_empty() && m.uv_indices.len() != m.faces.len() {
            return Err(self.error("Number of uv indices must equal the number of faces."));
        }
        Ok(())
    }

    pub(super) fn parse_polygon(&mut self) -> PResult<Shape> {
        let n = self.parse_int()?;
        if !(3..=MAX_ITEMS).contains(&n) {
            return Err(self.error("Polygon needs at least three points."));
        }
        let mut points = Vec::new();
        for _ in 0..n {
            self.comma()?;
            points.push(self.parse_vector3()?);
        }
        // Loops close where their first point returns; the last may be left open.
        let mut first = points[0];
        let mut closed = false;
        let mut i = 1;
        while i < points.len() {
            closed = (points[i] - first).abs().max_element() < EPSILON;
            if closed {
                if let Some(&next) = points.get(i + 1) {
                    first = next;
                }
                i += 1;
            }
            i += 1;
        }
        if !closed {
            self.warn("Polygon not closed. Closing it.");
            points.push(first);
        }
        Ok(Shape::Polygon { points })
    }

    pub(super) fn parse_bicubic_patch(&mut self) -> PResult<Shape> {
        let (mut flatness, mut accuracy) = (0.0, 0.01);
        let (mut u_steps, mut v_steps) = (0, 0);
        loop {
            if matches!(self.peek()?.kind, TokenKind::Float(_)) {
                // The oldest syntax: type, flatness, steps, without commas.
                self.warn("Should use keywords for bicubic parameters.");
                self.parse_int()?;
                flatness = self.parse_float()?;
                u_steps = self.parse_int()?;
                v_steps = self.parse_int()?;
                break;
            }
            let Some(k) = self.peek_kw()? else { break };
            match k {
                Kw::Type => {
                    self.next()?;
                    self.parse_int()?;
                }
                Kw::Flatness => {
                    self.next()?;
                    flatness = self.parse_float()?;
                }
                Kw::USteps => {
                    self.next()?;
                    u_steps = self.parse_int()?;
                }
                Kw::VSteps => {
                    self.next()?;
                    v_steps = self.parse_int()?;
                }
                Kw::Accuracy => {
                    self.next()?;
                    accuracy = self.parse_float()?;
                }
                _ => break,
            }
            self.comma()?;
        }
        let mut uvs = [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y];
        if self.accept_kw(Kw::UvVectors)? {
            for uv in &mut uvs {
                *uv = self.parse_vector2()?;
                self.comma()?;
            }
        }
        let mut points = Box::new([[DVec3::ZERO; 4]; 4]);
        for p in points.as_flattened_mut() {
            self.comma()?;
            *p = self.parse_vector3()?;
        }
        let steps = |n: i64| n.clamp(0, 10) as u32;
        Ok(Shape::BicubicPatch { points, uvs, flatness, u_steps: steps(u_steps), v_steps: steps(v_steps), accuracy })
    }
}

/// Faces without area go, with what belongs to them.
fn drop_degenerate(m: &mut Mesh) {
    let keep: Vec<bool> = m.faces.iter().map(|f| !is_degenerate(f.map(|i| m.vertices[i as usize].as_dvec3()))).collect();
    if keep.iter().all(|&k| k) {
        return;
    }
    for list in [&mut m.faces, &mut m.normal_indices, &mut m.uv_indices, &mut m.face_textures] {
        let mut at = 0;
        list.retain(|_| {
            at += 1;
            keep[at - 1]
        });
    }
}
