//! Primitives of a mesh → triangles with normals, coordinates and colours. Source: glTF 2.0, section 3.7.2.

use super::super::ImportError;
use super::Document;
use super::accessor::Accessor;
use super::rayloom::{Extension, vertex_motion};
use super::skin::Bones;
use crate::diag::Sink;
use crate::math::{DAffine3, Vec3};
use crate::scene::Mesh;
use crate::scene::shape::{MeshStep, UvSet};
use ::gltf::json::mesh::{Mode, Primitive, Semantic};
use ::gltf::json::validation::Checked;

/// Most vertices, and most faces, of all meshes of a file: what fits in memory many times over is a claim, not a model.
pub(super) const MAX_VERTICES: usize = 1 << 28;

/// Triangles and vertices that may still come.
pub(super) struct Budget {
    pub left: usize,
}

impl Budget {
    fn take(&mut self, doc: &Document, n: usize) -> Result<(), ImportError> {
        match self.left.checked_sub(n) {
            Some(left) => self.left = left,
            None => return Err(ImportError::TooMany { path: doc.path.to_owned(), what: "vertices and faces", limit: MAX_VERTICES }),
        }
        Ok(())
    }
}

/// What of a primitive is wanted.
pub(super) struct Wanted<'a, 'd> {
    /// The material's set of coordinates.
    pub uv_set: u32,
    /// The sets after the first, too.
    pub all_uvs: bool,
    /// How it is bent.
    pub form: Form<'a>,
    /// How it is bent at evenly spaced times over the shutter, or empty.
    pub steps: &'a [Form<'a>],
    /// Knows of motion.
    pub extension: Option<&'a Extension<'d>>,
}

/// What bends a primitive.
#[derive(Clone, Copy, Debug)]
pub(super) struct Form<'a> {
    /// Of morph targets.
    pub weights: &'a [f32],
    /// World from bind space by joint, of a skin.
    pub joints: Option<&'a [DAffine3]>,
}

/// The triangles of a primitive; `None` for points, lines and what has no faces left.
pub(super) fn triangles(
    doc: &Document,
    primitive: &Primitive,
    place: &dyn Fn() -> String,
    wanted: &Wanted,
    budget: &mut Budget,
    sink: &mut Sink,
) -> Result<Option<Mesh>, ImportError> {
    let Checked::Valid(mode) = primitive.mode else { return Err(doc.invalid(place(), "its mode is unknown")) };
    if matches!(mode, Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip) {
        sink.note_once("gltf: points and lines", None, "points and lines are left out");
        return Ok(None);
    }
    let attribute = |s: Semantic| primitive.attributes.get(&Checked::Valid(s)).map(|ix| ix.value());
    let Some(positions) = attribute(Semantic::Positions) else {
        sink.note_once("gltf: no positions", None, format!("{} has no positions and is left out", place()));
        return Ok(None);
    };
    let positions = Accessor::new(doc, positions, &[3], place)?;
    let indices = match &primitive.indices {
        Some(ix) => {
            let a = Accessor::new(doc, ix.value(), &[1], place)?;
            budget.take(doc, a.count)?;
            Some(a.all_indices().ok_or_else(|| doc.invalid(place(), "its indices are no unsigned integers"))?)
        }
        None => None,
    };
    let n = positions.count;
    if let Some(bad) = indices.iter().flatten().find(|i| **i as usize >= n) {
        let (path, place) = (doc.path.to_owned(), place());
        return Err(ImportError::IndexOutOfRange { path, place, index: i64::from(*bad), count: n, what: "vertices" });
    }
    // Exporters that put everything into one accessor: take the vertices that this primitive uses, no more.
    let (used, corners) = match indices {
        Some(list) if n / 2 > list.len() => {
            let mut used = list.clone();
            used.sort_unstable();
            used.dedup();
            let place_of = |i: &u32| used.binary_search(i).expect("it came from the list") as u32;
            let corners = list.iter().map(place_of).collect();
            (Some(used), corners)
        }
        Some(list) => (None, list),
        None => {
            budget.take(doc, n)?;
            if n > u32::MAX as usize {
                return Err(doc.invalid(place(), format!("{n} vertices are more than 32-bit indices count")));
            }
            (None, (0..n as u32).collect())
        }
    };
    let used = used.as_deref();
    let n_used = used.map_or(n, <[u32]>::len);
    budget.take(doc, n_used)?;
    let vertices: Vec<Vec3> = gathered(&positions, used, 0.0).into_iter().map(Vec3::from_array).collect();
    let same_count = |s: Semantic, kinds: &[usize]| -> Result<Option<Accessor>, ImportError> {
        let Some(ix) = attribute(s) else { return Ok(None) };
        let a = Accessor::new(doc, ix, kinds, place)?;
        if a.count == n {
            Ok(Some(a))
        } else {
            Err(doc.invalid(place(), format!("accessor {ix} has {} elements, the positions {n}", a.count)))
        }
    };
    let normals: Vec<Vec3> = match same_count(Semantic::Normals, &[3])? {
        Some(a) => gathered(&a, used, 0.0).into_iter().map(|n| Vec3::from_array(n).try_normalize().unwrap_or(Vec3::ZERO)).collect(),
        None => Vec::new(),
    };
    let bones = match wanted.form.joints {
        Some(joints) => Some(
            Bones::new(doc, primitive, place, used, n, joints.len())?
                .ok_or_else(|| doc.invalid(place(), "a node shows it with a skin, but its vertices hang on no joints"))?,
        ),
        None => None,
    };
    let bent = |form: &Form| -> Result<MeshStep, ImportError> {
        let (mut vertices, mut normals) = (vertices.clone(), normals.clone());
        morph(doc, primitive, place, form.weights, used, &mut vertices, &mut normals)?;
        if let (Some(bones), Some(joints)) = (&bones, form.joints) {
            bones.bend(joints, &mut vertices, &mut normals);
        }
        Ok(MeshStep { vertices, normals })
    };
    budget.take(doc, n_used.saturating_mul(wanted.steps.len()))?;
    let mut motion = wanted.steps.iter().map(&bent).collect::<Result<Vec<_>, _>>()?;
    if motion.windows(2).all(|w| w[0] == w[1]) {
        motion.clear();
    }
    let rest = if bones.is_some() || primitive.targets.is_some() { Some(bent(&wanted.form)?) } else { None };
    let MeshStep { vertices, normals } = rest.unwrap_or(MeshStep { vertices, normals });
    if let Some(bad) = vertices.iter().position(|v| !v.is_finite()) {
        let v = vertices[bad];
        let vertex = used.map_or(bad, |u| u[bad] as usize);
        return Err(ImportError::NotFinite { path: doc.path.to_owned(), place: place(), vertex, x: v.x, y: v.y, z: v.z });
    }
    let finite = |c: [f32; 2]| if c.iter().all(|v| v.is_finite()) { c } else { [0.0; 2] };
    let uv_set = |set: u32| -> Result<Option<Vec<[f32; 2]>>, ImportError> {
        Ok(same_count(Semantic::TexCoords(set), &[2])?.map(|a| gathered(&a, used, 0.0).into_iter().map(finite).collect()))
    };
    let uvs = uv_set(wanted.uv_set)?.unwrap_or_default();
    let mut more_uvs = Vec::new();
    let mut set = 0;
    while wanted.all_uvs
        && let Some(list) = uv_set(set)?
    {
        if set != wanted.uv_set {
            more_uvs.push(list);
        }
        set += 1;
    }
    if let Some(e) = wanted.extension {
        let own = vertex_motion(e, primitive, place, used, vertices.len(), sink)?;
        motion = if own.is_empty() { motion } else { own };
    }
    if motion.iter().flat_map(|s| &s.vertices).any(|v| !v.is_finite()) {
        return Err(doc.invalid(place(), "its motion takes a vertex beyond all numbers"));
    }
    let colors = match same_count(Semantic::Colors(0), &[3, 4])? {
        Some(a) => gathered(&a, used, 1.0),
        None => Vec::new(),
    };
    let faces = faces(mode, &corners, &vertices);
    if faces.is_empty() {
        return Ok(None);
    }
    Ok(Some(Mesh {
        normal_indices: if normals.is_empty() { Vec::new() } else { smooth_faces(&faces, &vertices, &normals, motion.is_empty()) },
        uv_indices: if uvs.is_empty() { Vec::new() } else { faces.clone() },
        more_uvs: more_uvs.into_iter().map(|uvs| UvSet { uvs, indices: faces.clone() }).collect(),
        motion,
        vertices,
        normals,
        uvs,
        faces,
        colors,
        ..Mesh::default()
    }))
}

/// Whose corners have which normals: no normals for flat faces at rest, whose corners have the face's own; what is left to work out at each hit is
/// less, and no point is raised where light grazes. Empty where all are flat.
fn smooth_faces(faces: &[[u32; 3]], vertices: &[Vec3], normals: &[Vec3], at_rest: bool) -> Vec<[u32; 3]> {
    let is_flat = |f: &[u32; 3]| {
        let [a, b, c] = f.map(|k| vertices[k as usize]);
        let n = f.map(|k| normals[k as usize]);
        // As near as 32 bits tell: a hundredth of a degree.
        let (own, n0) = ((b - a).cross(c - a), n[0]);
        n0 == n[1] && n0 == n[2] && own.dot(n0) > 0.0 && own.cross(n0).length_squared() < 4e-8 * own.length_squared()
    };
    if !at_rest || !faces.iter().any(is_flat) {
        return faces.to_vec();
    }
    let of: Vec<[u32; 3]> = faces.iter().map(|f| if is_flat(f) { [u32::MAX; 3] } else { *f }).collect();
    if of.iter().all(|f| f[0] == u32::MAX) { Vec::new() } else { of }
}

fn gathered<const N: usize>(a: &Accessor, used: Option<&[u32]>, rest: f32) -> Vec<[f32; N]> {
    match used {
        Some(list) => list.iter().map(|k| a.floats(*k as usize, rest)).collect(),
        None => a.all_floats(rest),
    }
}

/// Moves vertices and normals by the morph targets.
fn morph(
    doc: &Document,
    primitive: &Primitive,
    place: &dyn Fn() -> String,
    weights: &[f32],
    used: Option<&[u32]>,
    vertices: &mut [Vec3],
    normals: &mut [Vec3],
) -> Result<(), ImportError> {
    let targets = primitive.targets.iter().flatten().zip(weights).filter(|(_, w)| **w != 0.0);
    let mut moved = false;
    for (target, weight) in targets {
        for (ix, list) in [(&target.positions, &mut *vertices), (&target.normals, &mut *normals)] {
            let Some(ix) = ix else { continue };
            let a = Accessor::new(doc, ix.value(), &[3], place)?;
            if !list.is_empty() && a.count < used.map_or(list.len(), |u| u.last().map_or(0, |l| *l as usize + 1)) {
                return Err(doc.invalid(place(), format!("morph target accessor {} has only {} elements", a.ix, a.count)));
            }
            moved = true;
            for (k, v) in list.iter_mut().enumerate() {
                *v += *weight * Vec3::from_array(a.floats(used.map_or(k, |u| u[k] as usize), 0.0));
            }
        }
    }
    if moved {
        normals.iter_mut().for_each(|n| *n = n.try_normalize().unwrap_or(Vec3::ZERO));
    }
    Ok(())
}

/// Triangles of a list of corners, without those that have no area.
fn faces(mode: Mode, corners: &[u32], vertices: &[Vec3]) -> Vec<[u32; 3]> {
    let solid = |f: &[u32; 3]| {
        let [a, b, c] = f.map(|k| vertices[k as usize]);
        f[0] != f[1] && f[1] != f[2] && f[2] != f[0] && (b - a).as_dvec3().cross((c - a).as_dvec3()) != crate::math::DVec3::ZERO
    };
    match mode {
        Mode::TriangleStrip => {
            // Every second triangle is turned, so that all face the same way.
            let turned = |(k, w): (usize, &[u32])| if k % 2 == 0 { [w[0], w[1], w[2]] } else { [w[0], w[2], w[1]] };
            corners.windows(3).enumerate().map(turned).filter(solid).collect()
        }
        Mode::TriangleFan => match corners.split_first() {
            Some((hub, rim)) => rim.windows(2).map(|w| [w[0], w[1], *hub]).filter(solid).collect(),
            None => Vec::new(),
        },
        _ => corners.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).filter(solid).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faces_whose_corners_have_the_faces_normal_are_flat() {
        let vertices = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::new(1.0, 1.0, 0.5)];
        let faces = [[0, 1, 2], [2, 1, 3]];
        let (up, bent) = (Vec3::Z, Vec3::new(-0.3, -0.3, 0.9).normalize());
        let none = [u32::MAX; 3];
        assert_eq!(smooth_faces(&faces, &vertices, &[up, up, up, bent], true), [none, faces[1]]);
        assert_eq!(smooth_faces(&faces, &vertices, &[up, up, up, bent], false), faces);
        assert_eq!(smooth_faces(&faces[..1], &vertices, &[up; 4], true), Vec::<[u32; 3]>::new());
        // Turned round, or all alike but not the face's.
        assert_eq!(smooth_faces(&faces[..1], &vertices, &[-up; 4], true), faces[..1]);
        assert_eq!(smooth_faces(&faces[..1], &vertices, &[bent; 4], true), faces[..1]);
    }
}
