//! Keyframes → translation, rotation, scale and morph weights of nodes at a time. Source: glTF 2.0, section 3.11 and appendix C.

use super::super::{ImportError, ImportOptions};
use super::Document;
use super::accessor::Accessor;
use crate::diag::Sink;
use crate::math::DVec3;
use crate::scene::AnimationInfo;
use ::gltf::json;
use ::gltf::json::animation::{Interpolation, Property};
use ::gltf::json::validation::Checked;
use glam::DQuat;
use std::collections::BTreeMap;

/// Most numbers in the keys of an animation.
const MAX_KEYS: usize = 1 << 28;

/// What keys say of a node; `None` where they say nothing.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct NodeKeys {
    pub translation: Option<DVec3>,
    pub rotation: Option<DQuat>,
    pub scale: Option<DVec3>,
    pub weights: Option<Vec<f32>>,
}

struct Channel {
    node: usize,
    path: Property,
    interpolation: Interpolation,
    /// Seconds, rising.
    times: Vec<f32>,
    /// Numbers of a key.
    width: usize,
    /// Keys one by one; of splines each is in-tangent, value, out-tangent.
    values: Vec<f32>,
}

/// An animation made ready.
pub(super) struct Clip {
    channels: Vec<Channel>,
}

/// Names and spans of the file's animations.
pub(super) fn list(doc: &Document) -> Vec<AnimationInfo> {
    let span = |a: &json::Animation| {
        let ends = a.samplers.iter().filter_map(|s| {
            let times = Accessor::new(doc, s.input.value(), &[1], String::new).ok().filter(|a| a.count > 0)?;
            Some([0, times.count - 1].map(|k| f64::from(times.floats::<1>(k, 0.0)[0])))
        });
        ends.filter(|e| e[0] <= e[1]).reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]).unwrap_or_default()
    };
    let info = |(k, a): (usize, &json::Animation)| AnimationInfo {
        name: a.name.clone().unwrap_or_else(|| k.to_string()),
        seconds: span(a),
        n_channels: a.channels.len(),
    };
    doc.root.animations.iter().enumerate().map(info).collect()
}

/// The animation that the options name, else the first; `None` where none is asked for.
pub(super) fn chosen(doc: &Document, options: &ImportOptions, sink: &mut Sink) -> Result<Option<Clip>, ImportError> {
    let all = &doc.root.animations;
    if options.time.is_none() {
        if !all.is_empty() {
            sink.note_once("gltf: animation", None, "nodes stand as the file places them; --frame or --time shows its animation");
        }
        return Ok(None);
    }
    let label = |k: usize| all[k].name.clone().unwrap_or_else(|| k.to_string());
    let ix = match &options.animation {
        Some(name) => {
            let named = all.iter().position(|a| a.name.as_deref() == Some(name));
            let found = named.or_else(|| name.parse().ok().filter(|k| *k < all.len()));
            let list = || (0..all.len()).map(label).collect::<Vec<_>>().join(", ");
            found.ok_or_else(|| ImportError::NoAnimation { path: doc.path.to_owned(), name: name.clone(), list: list() })?
        }
        None if all.is_empty() => {
            sink.note_once("gltf: no animation", None, "the file has no animation: nothing moves");
            return Ok(None);
        }
        None => 0,
    };
    if options.animation.is_none() && all.len() > 1 {
        let message = format!("the file has {} animations; '{}' is shown (--animation NAME)", all.len(), label(ix));
        sink.note_once("gltf: animations", None, message);
    }
    Clip::new(doc, ix).map(Some)
}

impl Clip {
    fn new(doc: &Document, ix: usize) -> Result<Self, ImportError> {
        let record = &doc.root.animations[ix];
        let mut left = MAX_KEYS;
        let channels = record.channels.iter().enumerate().map(|(k, c)| channel(doc, record, ix, k, c, &mut left));
        Ok(Self { channels: channels.collect::<Result<_, _>>()? })
    }

    /// What the keys say at `seconds`, by node; before the first key that, after the last that.
    pub fn at(&self, seconds: f64) -> BTreeMap<usize, NodeKeys> {
        let mut out: BTreeMap<usize, NodeKeys> = BTreeMap::new();
        for c in &self.channels {
            let keys = out.entry(c.node).or_default();
            let v = c.at(seconds);
            let vector = || DVec3::new(v[0], v[1], v[2]);
            match c.path {
                Property::Translation => keys.translation = Some(vector()),
                Property::Scale => keys.scale = Some(vector()),
                Property::Rotation => {
                    let q = DQuat::from_xyzw(v[0], v[1], v[2], v[3]);
                    keys.rotation = Some(if q.length_squared() > 0.0 { q.normalize() } else { DQuat::IDENTITY });
                }
                Property::MorphTargetWeights => keys.weights = Some(v.iter().map(|w| *w as f32).collect()),
            }
        }
        out
    }
}

fn channel(
    doc: &Document,
    record: &json::Animation,
    ix: usize,
    k: usize,
    c: &json::animation::Channel,
    left: &mut usize,
) -> Result<Channel, ImportError> {
    let place = || match &record.name {
        Some(name) => format!("animation '{name}', channel {k}"),
        None => format!("animation {ix}, channel {k}"),
    };
    let node_ix = c.target.node.value();
    let node = doc.get(&doc.root.nodes, node_ix, "node", place)?;
    let Checked::Valid(path) = c.target.path else { return Err(doc.invalid(place(), "its path is unknown")) };
    let sampler = doc.get(&record.samplers, c.sampler.value(), "sampler", place)?;
    let Checked::Valid(interpolation) = sampler.interpolation else { return Err(doc.invalid(place(), "its interpolation is unknown")) };
    if node.matrix.is_some() && path != Property::MorphTargetWeights {
        return Err(doc.invalid(place(), format!("node {node_ix} has a matrix, which cannot be animated")));
    }
    let input = Accessor::new(doc, sampler.input.value(), &[1], place)?;
    let width_of_element = match path {
        Property::Translation | Property::Scale => 3,
        Property::Rotation => 4,
        Property::MorphTargetWeights => 1,
    };
    let output = Accessor::new(doc, sampler.output.value(), &[width_of_element], place)?;
    *left = (input.count.saturating_add(output.count.saturating_mul(width_of_element)) <= *left)
        .then(|| *left - input.count - output.count * width_of_element)
        .ok_or_else(|| ImportError::TooMany { path: doc.path.to_owned(), what: "numbers in the keys of an animation", limit: MAX_KEYS })?;
    let times: Vec<f32> = input.all_floats::<1>(0.0).into_iter().map(|[t]| t).collect();
    if times.is_empty() {
        return Err(doc.invalid(place(), "it has no keys"));
    }
    if !times.iter().all(|t| t.is_finite()) || times.windows(2).any(|w| w[0] >= w[1]) {
        return Err(doc.invalid(place(), "its times do not rise"));
    }
    let per_key = if interpolation == Interpolation::CubicSpline { 3 } else { 1 };
    let width = match path {
        Property::MorphTargetWeights => {
            let mesh = node.mesh.map_or_else(|| Err(doc.invalid(place(), format!("node {node_ix} has no mesh to morph"))), Ok)?;
            let mesh = doc.get(&doc.root.meshes, mesh.value(), "mesh", place)?;
            mesh.primitives.first().and_then(|p| p.targets.as_ref()).map_or(0, Vec::len)
        }
        _ => 1,
    };
    let wanted = times.len() * per_key * width;
    if output.count != wanted || width == 0 {
        let what = format!("there are {} values for {} keys of {width} in {interpolation:?}", output.count, times.len());
        return Err(doc.invalid(place(), what));
    }
    let values: Vec<f32> = match width_of_element {
        3 => output.all_floats::<3>(0.0).into_iter().flatten().collect(),
        4 => output.all_floats::<4>(0.0).into_iter().flatten().collect(),
        _ => output.all_floats::<1>(0.0).into_iter().flatten().collect(),
    };
    if !values.iter().all(|v| v.is_finite()) {
        return Err(doc.invalid(place(), "a value is not finite"));
    }
    Ok(Channel { node: node_ix, path, interpolation, times, width: width * width_of_element, values })
}

impl Channel {
    /// Part `part` of key `k` (0 but for splines).
    fn key(&self, k: usize, part: usize) -> &[f32] {
        let per_key = if self.interpolation == Interpolation::CubicSpline { 3 } else { 1 };
        let at = (k * per_key + part) * self.width;
        &self.values[at..at + self.width]
    }

    fn at(&self, seconds: f64) -> Vec<f64> {
        let value = usize::from(self.interpolation == Interpolation::CubicSpline);
        let whole = |k: usize| self.key(k, value).iter().map(|v| f64::from(*v)).collect::<Vec<_>>();
        let after = self.times.partition_point(|t| f64::from(*t) <= seconds);
        if after == 0 || after == self.times.len() {
            return whole(after.saturating_sub(1));
        }
        let (a, b) = (after - 1, after);
        let step = f64::from(self.times[b]) - f64::from(self.times[a]);
        let f = (seconds - f64::from(self.times[a])) / step;
        let (p, q) = (whole(a), whole(b));
        match self.interpolation {
            Interpolation::Step => p,
            Interpolation::Linear if self.path == Property::Rotation => {
                let quaternion = |v: &[f64]| {
                    let q = DQuat::from_xyzw(v[0], v[1], v[2], v[3]);
                    if q.length_squared() > 0.0 { q.normalize() } else { DQuat::IDENTITY }
                };
                // By the shorter way.
                quaternion(&p).slerp(quaternion(&q), f).to_array().to_vec()
            }
            Interpolation::Linear => p.iter().zip(&q).map(|(p, q)| p + (q - p) * f).collect(),
            Interpolation::CubicSpline => {
                let (out, into) = (self.key(a, 2), self.key(b, 0));
                let (f2, f3) = (f * f, f * f * f);
                let hermite = |i: usize| {
                    (2.0 * f3 - 3.0 * f2 + 1.0) * p[i]
                        + step * (f3 - 2.0 * f2 + f) * f64::from(out[i])
                        + (3.0 * f2 - 2.0 * f3) * q[i]
                        + step * (f3 - f2) * f64::from(into[i])
                };
                (0..self.width).map(hermite).collect()
            }
        }
    }
}
