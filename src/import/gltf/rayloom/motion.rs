//! What moves while the shutter is open. The scene wants keys evenly spaced over the shutter; so the exporter writes them.

use super::super::super::ImportError;
use super::super::Document;
use super::super::accessor::Accessor;
use super::record::Record;
use super::{Extension, NAME, part};
use crate::diag::Sink;
use crate::math::{DAffine3, DMat3, DVec3, Transform, Vec3};
use crate::scene::shape::MeshStep;
use ::gltf::json::mesh::Primitive;
use std::sync::Arc;

/// When the shutter is open, in frames from the frame.
#[derive(Clone, Copy, Debug, Default)]
pub(in super::super) struct Shutter {
    pub open: f64,
    pub close: f64,
}

impl Shutter {
    /// When steps `0..n` are, in frames from the frame; empty when it is open for no time.
    pub fn times(&self, n: usize) -> Vec<f64> {
        let at = |k: usize| self.open + (self.close - self.open) * k as f64 / (n - 1).max(1) as f64;
        if self.close > self.open { (0..n).map(at).collect() } else { Vec::new() }
    }

    /// Whether `times` are evenly spaced from open to close.
    fn fits(&self, times: &[f64]) -> bool {
        let n = times.len();
        let at = |k: usize| self.open + (self.close - self.open) * k as f64 / (n - 1) as f64;
        n >= 2 && times.iter().enumerate().all(|(k, t)| (t - at(k)).abs() < 1e-3)
    }
}

/// The times of a record `motion`; false when they are not the shutter's, which is told.
fn times(r: &Record, shutter: &Shutter, sink: &mut Sink) -> Result<Option<usize>, ImportError> {
    let times = r.list("times")?;
    if shutter.fits(&times) {
        return Ok(Some(times.len()));
    }
    if shutter.close > shutter.open {
        sink.note_once("rayloom: motion times", None, "motion whose times are not evenly spaced over the shutter is left out");
    }
    Ok(None)
}

/// World matrices of a node's `motion`, in Blender's axes: all times of its first place, then of the next.
pub(super) fn matrices(r: &Record, shutter: &Shutter, n_places: usize, sink: &mut Sink) -> Result<Vec<DAffine3>, ImportError> {
    let doc = r.document();
    let n = times(r, shutter, sink)?;
    let ix = r.needed("matrices", r.index("matrices", doc.root.accessors.len(), "accessor")?)?;
    r.finish()?;
    let Some(n) = n else { return Ok(Vec::new()) };
    let a = Accessor::new(doc, ix, &[16], || r.path().to_owned())?;
    if Some(a.count) != n.checked_mul(n_places) {
        let places = if n_places == 1 { String::new() } else { format!(" of {n_places} instances") };
        return Err(r.wrong("matrices", format!("there are {} matrices for {n} times{places}", a.count)));
    }
    let affine = |m: [f32; 16]| {
        let column = |k: usize| DVec3::new(f64::from(m[4 * k]), f64::from(m[4 * k + 1]), f64::from(m[4 * k + 2]));
        DAffine3 { matrix3: DMat3::from_cols(column(0), column(1), column(2)), translation: column(3) }
    };
    let out: Vec<DAffine3> = a.all_floats(0.0).into_iter().map(affine).collect();
    if out.iter().all(|m| m.is_finite()) { Ok(out) } else { Err(r.wrong("matrices", "one of them is not finite")) }
}

/// The keys of an object; empty when one of them squeezes it flat.
pub(in super::super) fn object_motion(matrices: &[DAffine3]) -> Arc<[Transform]> {
    if matrices.is_empty() {
        return Arc::default();
    }
    let keys: Option<Vec<Transform>> =
        matrices.iter().map(|m| Transform::from_affine(*m).filter(|_| m.matrix3.determinant() != 0.0)).collect();
    keys.unwrap_or_default().into()
}

/// Vertices of a primitive at the shutter's times, `used` in their order; empty: it stands still.
pub(in super::super) fn vertex_motion(
    e: &Extension,
    primitive: &Primitive,
    place: &dyn Fn() -> String,
    used: Option<&[u32]>,
    n_vertices: usize,
    sink: &mut Sink,
) -> Result<Vec<MeshStep>, ImportError> {
    let Some(value) = part(primitive.extensions.as_ref().map(|e| &e.others)) else { return Ok(Vec::new()) };
    let r = Record::new(e.doc, value, format!("{}: extensions.{NAME}", place()))?;
    let motion = r.record("motion")?;
    r.finish()?;
    let Some(m) = motion else { return Ok(Vec::new()) };
    let n = times(&m, &e.shutter, sink)?;
    let (positions, normals) = (indices(&m, "positions")?, indices(&m, "normals")?);
    m.finish()?;
    let Some(n) = n else { return Ok(Vec::new()) };
    for (key, list) in [("positions", &positions), ("normals", &normals)] {
        if list.len() != n && !(key == "normals" && list.is_empty()) {
            return Err(m.wrong(key, format!("there are {} accessors for {n} times", list.len())));
        }
    }
    let step = |k: usize| -> Result<MeshStep, ImportError> {
        let vertices = vectors(e.doc, positions[k], place, used, n_vertices)?;
        let normals = match normals.get(k) {
            Some(ix) => vectors(e.doc, *ix, place, used, n_vertices)?.into_iter().map(|n| n.normalize_or_zero()).collect(),
            None => Vec::new(),
        };
        Ok(MeshStep { vertices, normals })
    };
    (0..n).map(step).collect()
}

/// A list of accessors.
fn indices(r: &Record, key: &str) -> Result<Vec<usize>, ImportError> {
    let index = |v: f64| (v >= 0.0 && v.fract() == 0.0).then_some(v as usize);
    let list = r.list(key)?.into_iter().map(index).collect::<Option<Vec<_>>>();
    list.ok_or_else(|| r.wrong(key, "it must be a list of accessors"))
}

fn vectors(
    doc: &Document,
    ix: usize,
    place: &dyn Fn() -> String,
    used: Option<&[u32]>,
    n_vertices: usize,
) -> Result<Vec<Vec3>, ImportError> {
    let a = Accessor::new(doc, ix, &[3], place)?;
    let needed = used.map_or(n_vertices, |u| u.last().map_or(0, |l| *l as usize + 1));
    if a.count < needed {
        return Err(doc.invalid(place(), format!("accessor {ix} of its motion has {} elements, it needs {needed}", a.count)));
    }
    let all: Vec<Vec3> = match used {
        Some(list) => list.iter().map(|k| Vec3::from_array(a.floats(*k as usize, 0.0))).collect(),
        None => a.all_floats(0.0).into_iter().take(n_vertices).map(Vec3::from_array).collect(),
    };
    match all.iter().all(|v| v.is_finite()) {
        true => Ok(all),
        false => Err(doc.invalid(place(), format!("accessor {ix} of its motion holds numbers that are not finite"))),
    }
}
