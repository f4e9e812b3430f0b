//! Skins: vertices follow the joints that they hang on. Source: glTF 2.0, sections 3.7.3 and 5.28.

use super::super::ImportError;
use super::Document;
use super::accessor::Accessor;
use super::pose::Pose;
use crate::math::{DAffine3, DMat3, DVec3, Vec3};
use ::gltf::json::mesh::{Primitive, Semantic};
use ::gltf::json::validation::Checked;

/// World from bind space, by joint, at a moment.
pub(super) fn joints(doc: &Document, skin_ix: usize, pose: &Pose, place: &dyn Fn() -> String) -> Result<Vec<DAffine3>, ImportError> {
    let skin = doc.get(&doc.root.skins, skin_ix, "skin", place)?;
    let here = || format!("skin {skin_ix}");
    let inverse_binds = match skin.inverse_bind_matrices {
        Some(ix) => {
            let a = Accessor::new(doc, ix.value(), &[16], here)?;
            if a.count < skin.joints.len() {
                return Err(doc.invalid(here(), format!("there are {} matrices for {} joints", a.count, skin.joints.len())));
            }
            Some(a)
        }
        None => None,
    };
    let joint = |(k, ix): (usize, &::gltf::json::Index<::gltf::json::Node>)| {
        doc.get(&doc.root.nodes, ix.value(), "node", here)?;
        let world = pose.world(ix.value());
        let world = world.ok_or_else(|| doc.invalid(here(), format!("its joint {k}, node {}, is no part of the scene", ix.value())))?;
        let bind = inverse_binds.as_ref().map_or(DAffine3::IDENTITY, |a| {
            let m = a.floats::<16>(k, 0.0);
            let column = |c: usize| DVec3::new(f64::from(m[4 * c]), f64::from(m[4 * c + 1]), f64::from(m[4 * c + 2]));
            DAffine3 { matrix3: DMat3::from_cols(column(0), column(1), column(2)), translation: column(3) }
        });
        let m = world * bind;
        if m.is_finite() { Ok(m) } else { Err(doc.invalid(here(), format!("the matrix of joint {k} is not finite"))) }
    };
    skin.joints.iter().enumerate().map(joint).collect()
}

/// Which joints the vertices of a primitive hang on, and how much: as many pairs for each vertex, weights adding up to 1.
pub(super) struct Bones {
    per_vertex: usize,
    list: Vec<(u32, f32)>,
}

impl Bones {
    /// Of a primitive of `n` vertices, `used` in their order; `None` when it says nothing of joints.
    pub fn new(
        doc: &Document,
        primitive: &Primitive,
        place: &dyn Fn() -> String,
        used: Option<&[u32]>,
        n: usize,
        n_joints: usize,
    ) -> Result<Option<Self>, ImportError> {
        let mut sets = Vec::new();
        for set in 0.. {
            let attribute = |s: Semantic| primitive.attributes.get(&Checked::Valid(s)).map(|ix| ix.value());
            let (Some(joints), Some(weights)) = (attribute(Semantic::Joints(set)), attribute(Semantic::Weights(set))) else { break };
            let (joints, weights) = (Accessor::new(doc, joints, &[4], place)?, Accessor::new(doc, weights, &[4], place)?);
            if joints.count != n || weights.count != n {
                let what = format!("there are {} joints and {} weights for {n} vertices", joints.count, weights.count);
                return Err(doc.invalid(place(), what));
            }
            sets.push((joints, weights));
        }
        if sets.is_empty() {
            return Ok(None);
        }
        let per_vertex = 4 * sets.len();
        let n_used = used.map_or(n, <[u32]>::len);
        let mut list = Vec::with_capacity(n_used * per_vertex);
        for k in 0..n_used {
            let vertex = used.map_or(k, |u| u[k] as usize);
            let first = list.len();
            for (joints, weights) in &sets {
                let (j, w) = (joints.floats::<4>(vertex, 0.0), weights.floats::<4>(vertex, 0.0));
                for (j, w) in j.into_iter().zip(w) {
                    if w != 0.0 && !(j >= 0.0 && j < n_joints as f32) {
                        return Err(doc.invalid(place(), format!("vertex {vertex} hangs on joint {j}, the skin has {n_joints}")));
                    }
                    if !(w.is_finite() && w >= 0.0) {
                        return Err(doc.invalid(place(), format!("vertex {vertex} hangs on a joint by the weight {w}")));
                    }
                    list.push((j as u32, w));
                }
            }
            let sum: f32 = list[first..].iter().map(|(_, w)| w).sum();
            if sum > 0.0 {
                list[first..].iter_mut().for_each(|(_, w)| *w /= sum);
            }
        }
        Ok(Some(Self { per_vertex, list }))
    }

    /// Takes vertices and normals from bind space to the world. Vertices that hang on nothing follow the first joint.
    pub fn bend(&self, joints: &[DAffine3], vertices: &mut [Vec3], normals: &mut [Vec3]) {
        for (k, pairs) in self.list.chunks_exact(self.per_vertex).enumerate().take(vertices.len()) {
            let mut m = DAffine3 { matrix3: DMat3::ZERO, translation: DVec3::ZERO };
            for (j, w) in pairs.iter().filter(|(_, w)| *w > 0.0) {
                let (joint, w) = (&joints[*j as usize], f64::from(*w));
                m.matrix3 += joint.matrix3 * w;
                m.translation += joint.translation * w;
            }
            if pairs.iter().all(|(_, w)| *w <= 0.0) {
                m = joints.first().copied().unwrap_or(DAffine3::IDENTITY);
            }
            vertices[k] = m.transform_point3(vertices[k].as_dvec3()).as_vec3();
            if let Some(n) = normals.get_mut(k) {
                // The cofactors: the inverse transposed, but for a factor, and also where there is no inverse.
                let c = m.matrix3;
                let cofactors = DMat3::from_cols(c.y_axis.cross(c.z_axis), c.z_axis.cross(c.x_axis), c.x_axis.cross(c.y_axis));
                let turned = cofactors * n.as_dvec3() * if c.determinant() < 0.0 { -1.0 } else { 1.0 };
                *n = turned.try_normalize().map_or(*n, DVec3::as_vec3);
            }
        }
    }
}
