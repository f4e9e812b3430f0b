//! Where a ray meets a surface, as closures look at it: normals on the viewer's side, texture coordinates, tangents, inputs with values.

use crate::compile::CompiledScene;
use crate::compile::geometry::{Prim, PrimKind, prim_flags};
use crate::compile::shape::{HairShape, MeshShape};
use crate::kernel::SurfaceHit;
use crate::kernel::material::{mesh_of, picture_uv, sample_picture, vertex_color};
use crate::kernel::traverse::motion_at;
use crate::math::{DVec2, DVec3, Rgb, Transform, Vec3};
use crate::scene::input::{Channel, Color, NormalInput, Picture, Scalar};
use crate::scene::shader::RaySort;

/// A hit made ready.
pub struct Surface<'s> {
    /// The scene.
    pub scene: &'s CompiledScene,
    /// The hit.
    pub hit: SurfaceHit,
    /// What was hit.
    pub prim: &'s Prim,
    /// To the viewer, unit.
    pub v: Vec3,
    /// Unit normal of the flat face, on the viewer's side.
    pub flat: DVec3,
    /// Unit smooth normal, turned with `flat`; may face away from the viewer at the rim.
    pub normal: DVec3,
    /// The viewer sees the back.
    pub backfacing: bool,
    /// By what sort of ray; [`RaySort::Light`] until it is told.
    pub seen_by: RaySort,
    mesh: Option<&'s MeshShape>,
    /// World from the shape's space, where the object rests.
    resting: &'s Transform,
    /// The same at the ray's time, of what moves.
    moved: Option<Transform>,
    time: f64,
    fibre: Option<Fibre>,
}

/// Where a hair was met.
#[derive(Clone, Copy)]
pub struct Fibre {
    /// Unit direction along it.
    pub tangent: Vec3,
    /// Unit, across it, towards the viewer: of the ribbon, where [`Surface::normal`] is of the round fibre.
    pub facing: Vec3,
    /// Offset across it in radii, -1..=1, positive along tangent x direction of the ray.
    pub offset: f32,
}

/// The hair of a primitive, if it is one.
fn hair_of<'s>(scene: &'s CompiledScene, prim: &Prim) -> Option<&'s HairShape> {
    (prim.kind == PrimKind::Hair).then(|| &scene.geometry.shapes.hairs[prim.shape_ix as usize])
}

impl<'s> Surface<'s> {
    /// Of a hit by a ray along `dir` (unit) at `time`.
    #[inline]
    pub fn new(scene: &'s CompiledScene, hit: SurfaceHit, dir: DVec3, time: f64) -> Self {
        let g = &scene.geometry;
        let prim = &g.prims[hit.prim_ix as usize];
        let mesh = mesh_of(g, &hit);
        let resting = &g.transforms[prim.transform_ix as usize];
        let moves = prim.flags & prim_flags::MOVING != 0;
        let moved = moves.then(|| resting.then(&motion_at(g, prim, time)));
        if let Some(hair) = hair_of(scene, prim) {
            let segment = &hair.segments[hit.face_ix as usize];
            let transform = moved.as_ref().unwrap_or(resting);
            let tangent = transform.vector(segment.tangent(hit.barycentric.x)).normalize_or(DVec3::X);
            let n = (tangent * tangent.dot(dir) - dir).try_normalize().unwrap_or(-dir);
            let offset = hit.barycentric.y;
            // The ribbon is shaded as if it were round.
            let round = tangent.cross(dir).normalize_or_zero() * offset + n * (1.0 - offset * offset).max(0.0).sqrt();
            let fibre = Some(Fibre { tangent: tangent.as_vec3(), facing: n.as_vec3(), offset: offset as f32 });
            return Self {
                scene,
                hit,
                prim,
                v: -dir.as_vec3(),
                flat: round,
                normal: round,
                backfacing: false,
                seen_by: RaySort::Light,
                mesh: None,
                resting,
                moved,
                time,
                fibre,
            };
        }
        let (front, smooth) = match mesh {
            Some(mesh) => {
                let is_smooth = mesh.is_smooth(hit.face_ix);
                let n = if is_smooth || moves || prim.flags & prim_flags::INVERTED != 0 {
                    let [a, b, c] = mesh.corners_at(hit.face_ix, time);
                    // Corners run counterclockwise seen from the front; a mirroring transform turns that round.
                    let transform = moved.as_ref().unwrap_or(resting);
                    transform.normal((b - a).cross(c - a)).try_normalize().unwrap_or(hit.normal)
                } else {
                    // A flat face's normal is that of its corners the other way round.
                    -hit.normal
                };
                (n, if is_smooth { hit.normal } else { n })
            }
            None => (hit.normal, hit.normal),
        };
        // A smooth normal belongs to the side of the face that it is nearer to.
        let front = if smooth.dot(front) < 0.0 { -front } else { front };
        let backfacing = front.dot(dir) > 0.0;
        let sign = if backfacing { -1.0 } else { 1.0 };
        let (v, flat, normal) = (-dir.as_vec3(), front * sign, smooth * sign);
        let seen_by = RaySort::Light;
        Self { scene, hit, prim, v, flat, normal, backfacing, seen_by, mesh, resting, moved, time, fibre: None }
    }

    /// World from the shape's space, at the ray's time.
    fn transform(&self) -> &Transform {
        self.moved.as_ref().unwrap_or(self.resting)
    }

    /// Of a mesh: the face's corners in its space, at that time.
    fn corners(&self) -> [DVec3; 3] {
        self.mesh.map_or([DVec3::ZERO; 3], |m| m.corners_at(self.hit.face_ix, self.time))
    }

    /// Seen by a sort of ray.
    #[inline(always)]
    #[must_use]
    pub fn seen_by(self, seen_by: RaySort) -> Self {
        Self { seen_by, ..self }
    }

    /// Where the point of the hit is at another time of the shutter.
    pub fn point_at(&self, time: f64) -> DVec3 {
        let g = &self.scene.geometry;
        let motion = |t: f64| motion_at(g, self.prim, t);
        let Some(mesh) = self.mesh.filter(|m| m.moving.is_some()) else {
            let moves = self.prim.flags & prim_flags::MOVING != 0;
            return if moves { motion(time).point(motion(self.time).inverse_point(self.hit.point)) } else { self.hit.point };
        };
        let [a, b, c] = mesh.corners_at(self.hit.face_ix, time);
        let w = self.hit.barycentric;
        g.transforms[self.prim.transform_ix as usize].then(&motion(time)).point((1.0 - w.x - w.y) * a + w.x * b + w.y * c)
    }

    /// Texture coordinates of a set.
    pub fn uv(&self, set: u32) -> DVec2 {
        let Some(mesh) = self.mesh else { return self.hit.uv };
        if set == 0 {
            return self.hit.uv;
        }
        let Some((uvs, ix)) = self.uv_corners(mesh, set) else { return DVec2::ZERO };
        let c = ix.map(|k| uvs.get(k as usize).map_or(DVec2::ZERO, |c| DVec2::new(c[0].into(), c[1].into())));
        let b = self.hit.barycentric;
        (1.0 - b.x - b.y) * c[0] + b.x * c[1] + b.y * c[2]
    }

    /// Whether there are texture coordinates of the set.
    pub fn has_uv(&self, set: u32) -> bool {
        self.mesh.is_none_or(|m| self.uv_corners(m, set).is_some())
    }

    fn uv_corners<'m>(&self, mesh: &'m MeshShape, set: u32) -> Option<(&'m [[f32; 2]], [u32; 3])> {
        let face = self.hit.face_ix as usize;
        if set == 0 {
            return Some((&mesh.mesh.uvs, *mesh.mesh.uv_indices.get(face)?));
        }
        let more = mesh.mesh.more_uvs.get(set as usize - 1)?;
        Some((&more.uvs, *more.indices.get(face)?))
    }

    fn look(&self, p: &Picture) -> [f32; 4] {
        sample_picture(p, self.uv(p.uv_set))
    }

    /// Value of a number.
    pub fn scalar(&self, s: &Scalar) -> f32 {
        let Some((picture, channel)) = &s.picture else { return s.factor + s.offset };
        let c = self.look(picture);
        let v = match channel {
            Channel::Red => c[0],
            Channel::Green => c[1],
            Channel::Blue => c[2],
            Channel::Alpha => c[3],
            Channel::Luminance => 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2],
        };
        s.factor * v + s.offset
    }

    /// Value of a colour.
    pub fn color(&self, c: &Color) -> Rgb {
        let mut value = c.factor;
        if let Some(p) = &c.picture {
            let [r, g, b, _] = self.look(p);
            value *= Vec3::new(r, g, b);
        }
        if c.vertex_color {
            let [r, g, b, _] = vertex_color(&self.scene.geometry, &self.hit);
            value *= Vec3::new(r, g, b);
        }
        value
    }

    /// The shading normal that an input gives, on the viewer's side as far as the surface is; and whether it is bent.
    pub fn bent_normal(&self, input: Option<&NormalInput>) -> (Vec3, bool) {
        let smooth = self.normal.as_vec3();
        match input {
            None => (smooth, false),
            Some(i) => match self.bend(i, smooth) {
                Some(n) => (n, true),
                None => (smooth, false),
            },
        }
    }

    fn bend(&self, input: &NormalInput, smooth: Vec3) -> Option<Vec3> {
        match input {
            NormalInput::Map { picture, strength, scale_xy } => {
                let c = self.look(picture);
                let mut m = Vec3::new(2.0 * c[0] - 1.0, 2.0 * c[1] - 1.0, 2.0 * c[2] - 1.0);
                let strength = self.scalar(strength);
                if *scale_xy {
                    m *= Vec3::new(strength, strength, 1.0);
                }
                // Maps are painted on the front.
                let outward = if self.backfacing { -smooth } else { smooth };
                let (t, b) = self.uv_axes(picture, outward)?;
                let n = (t * m.x + b * m.y + outward * m.z).try_normalize()?;
                let n = if self.backfacing { -n } else { n };
                if *scale_xy || strength == 1.0 { Some(n) } else { (smooth + (n - smooth) * strength.max(0.0)).try_normalize() }
            }
            NormalInput::Bump { height, strength, distance, invert, base } => {
                // What has no slope leaves the normal below it.
                let below = base.as_ref().and_then(|b| self.bend(b, smooth));
                let n = below.unwrap_or(smooth);
                let Some((picture, _)) = height.picture.as_ref() else { return below };
                // Differences over a texel, along the axes of the picture.
                let Some((t, b, du, dv)) = self.uv_gradients(picture) else { return below };
                let size = &picture.texture.image;
                let (eu, ev) = (1.0 / f64::from(size.width), 1.0 / f64::from(size.height));
                let at = |x: f64, y: f64| {
                    let mut moved = height.clone();
                    if let Some((p, _)) = &mut moved.picture {
                        p.texture.uv_transform[0][2] += x as f32;
                        p.texture.uv_transform[1][2] += y as f32;
                    }
                    self.scalar(&moved)
                };
                let h_u = (at(0.5 * eu, 0.0) - at(-0.5 * eu, 0.0)) / eu as f32;
                let h_v = (at(0.0, 0.5 * ev) - at(0.0, -0.5 * ev)) / ev as f32;
                let distance = self.scalar(distance) * if *invert { -1.0 } else { 1.0 };
                let _ = (t, b);
                let slope = (du * h_u + dv * h_v) * distance;
                let slope = slope - n * n.dot(slope);
                let bent = (n - slope).try_normalize()?;
                (n + (bent - n) * self.scalar(strength).max(0.0)).try_normalize()
            }
        }
    }

    /// Unit axes of a picture's right and top in the tangent plane of `n`.
    fn uv_axes(&self, picture: &Picture, n: Vec3) -> Option<(Vec3, Vec3)> {
        self.axes_in(self.uv_derivatives(picture.uv_set, |c| picture_uv(&picture.texture, c))?, n)
    }

    /// The same of a set of coordinates, about the smooth normal of the front.
    pub fn uv_frame(&self, set: u32) -> Option<(Vec3, Vec3)> {
        let outward = if self.backfacing { -self.normal } else { self.normal };
        self.axes_in(self.uv_derivatives(set, |c| c)?, outward.as_vec3())
    }

    fn axes_in(&self, (along_u, along_v): (DVec3, DVec3), n: Vec3) -> Option<(Vec3, Vec3)> {
        let n64 = n.as_dvec3();
        let t = (along_u - n64 * n64.dot(along_u)).try_normalize()?;
        let b = n64.cross(t);
        // The picture's v runs down, the map's green up.
        let b = if b.dot(along_v) > 0.0 { -b } else { b };
        Some((t.as_vec3(), b.as_vec3()))
    }

    /// World vectors along u and v of coordinates that `place` makes of a set's.
    fn uv_derivatives(&self, set: u32, place: impl Fn(DVec2) -> DVec2) -> Option<(DVec3, DVec3)> {
        let mesh = self.mesh?;
        let (uvs, ix) = self.uv_corners(mesh, set)?;
        let [p0, p1, p2] = self.corners();
        let uv = ix.map(|k| uvs.get(k as usize).map_or(DVec2::ZERO, |c| DVec2::new(c[0].into(), c[1].into())));
        let [c0, c1, c2] = uv.map(place);
        let (e1, e2, d1, d2) = (p1 - p0, p2 - p0, c1 - c0, c2 - c0);
        let det = d1.x * d2.y - d1.y * d2.x;
        if det == 0.0 {
            return None;
        }
        Some((self.transform().vector((e1 * d2.y - e2 * d1.y) / det), self.transform().vector((e2 * d1.x - e1 * d2.x) / det)))
    }

    /// [`Self::uv_axes`] of the flat face, and the gradients of u and v in world space.
    fn uv_gradients(&self, picture: &Picture) -> Option<(DVec3, DVec3, Vec3, Vec3)> {
        let (a, b) = self.uv_derivatives(picture.uv_set, |c| picture_uv(&picture.texture, c))?;
        let n = a.cross(b);
        let area_sq = n.length_squared();
        if area_sq == 0.0 {
            return None;
        }
        // Reciprocal basis in the plane of the face.
        Some((a, b, (b.cross(n) / area_sq).as_vec3(), (n.cross(a) / area_sq).as_vec3()))
    }

    /// Blender's default tangent: around the z axis of the object through the middle of its box.
    pub fn tangent(&self) -> Vec3 {
        let (local, center, size) = match self.mesh {
            Some(m) => (self.transform().inverse_point(self.hit.point), 0.5 * (m.bounds.min + m.bounds.max), m.bounds.max - m.bounds.min),
            None => {
                let b = &self.scene.geometry.bounds[self.hit.prim_ix as usize];
                (self.hit.point, 0.5 * (b.min + b.max), b.max - b.min)
            }
        };
        let g = (local - center) / size.max(DVec3::splat(1e-12));
        let around = DVec3::new(-g.y, g.x, 0.0);
        let around = if self.mesh.is_some() { self.transform().normal(around) } else { around };
        let n = self.normal;
        let along = around.cross(n);
        n.cross(along.try_normalize().unwrap_or_else(|| n.any_orthonormal_vector())).as_vec3()
    }

    /// Where shadow rays leave a smooth face that is cut into triangles: raised to the curved surface that the normals speak of.
    /// Source: Hanika 2021, "Hacking the shadow terminator".
    pub fn raised_point(&self, outward: DVec3) -> DVec3 {
        let Some(mesh) = self.mesh else { return self.hit.point };
        let Some(ix) = mesh.mesh.normal_indices.get(self.hit.face_ix as usize).filter(|n| n[0] != u32::MAX) else { return self.hit.point };
        let corners = self.corners();
        let b = self.hit.barycentric;
        let weights = [1.0 - b.x - b.y, b.x, b.y];
        let local = weights[0] * corners[0] + weights[1] * corners[1] + weights[2] * corners[2];
        let side =
            if self.transform().inverse_normal(outward).dot(self.transform().inverse_normal(self.normal)) < 0.0 { -1.0 } else { 1.0 };
        let side = if self.backfacing { -side } else { side };
        let mut lift = DVec3::ZERO;
        for k in 0..3 {
            let n = mesh.normal_at(ix[k], self.time) * side;
            let below = (local - corners[k]).dot(n).min(0.0);
            lift -= weights[k] * below * n;
        }
        self.hit.point + self.transform().vector(lift)
    }

    /// Whether the face has smooth normals.
    pub fn is_smooth(&self) -> bool {
        self.mesh.is_some_and(|m| m.is_smooth(self.hit.face_ix))
    }

    /// The same seen from the other side.
    pub fn turned(self) -> Self {
        Self { v: -self.v, flat: -self.flat, normal: -self.normal, backfacing: !self.backfacing, ..self }
    }

    /// Where a hair was met, if it was one.
    pub fn fibre(&self) -> Option<Fibre> {
        self.fibre
    }
}
