//! Hair systems.

use super::super::super::ImportError;
use super::super::accessor::Accessor;
use super::motion::Shutter;
use super::record::Record;
use crate::diag::Sink;
use crate::math::Vec3;
use crate::scene::Curves;
use crate::scene::curves::CurveStyle;
use std::sync::Arc;

/// Most points of one hair system.
const MAX_POINTS: usize = 1 << 28;

/// Curves, and the index of their material.
pub(super) fn curves(
    r: &Record,
    style: CurveStyle,
    shutter: &Shutter,
    sink: &mut Sink,
) -> Result<(Arc<Curves>, Option<usize>), ImportError> {
    let doc = r.document();
    let accessor = |key: &str, width: usize| -> Result<Accessor, ImportError> {
        let ix = r.needed(key, r.index(key, doc.root.accessors.len(), "accessor")?)?;
        Accessor::new(doc, ix, &[width], || format!("{}.{key}", r.path()))
    };
    let points = accessor("points", 3)?;
    let radii = accessor("radii", 1)?;
    let offsets = accessor("offsets", 1)?;
    if points.count > MAX_POINTS {
        return Err(ImportError::TooMany { path: doc.path.to_owned(), what: "points of hair", limit: MAX_POINTS });
    }
    if radii.count != points.count {
        return Err(r.wrong("radii", format!("there are {} radii for {} points", radii.count, points.count)));
    }
    let starts = offsets.all_indices().ok_or_else(|| r.wrong("offsets", "they are no unsigned integers"))?;
    let ends = (starts.first().copied(), starts.last().map(|l| *l as usize));
    if ends != (Some(0), Some(points.count)) || starts.windows(2).any(|w| w[0] >= w[1]) {
        return Err(r.wrong("offsets", format!("they must rise from 0 to {}, the number of points", points.count)));
    }
    let points: Vec<Vec3> = points.all_floats(0.0).into_iter().map(Vec3::from_array).collect();
    let radii: Vec<f32> = radii.all_floats::<1>(0.0).into_iter().map(|v| v[0].max(0.0)).collect();
    if !points.iter().all(|p| p.is_finite()) || !radii.iter().all(|v| v.is_finite()) {
        return Err(r.wrong("points", "a point or a radius is not finite"));
    }
    let material = r.index("material", doc.root.materials.len(), "material")?;
    if r.record("motion")?.is_some() && shutter.close > shutter.open {
        sink.note_once("rayloom: hair motion", None, "the motion of hair is left out");
    }
    r.get("closeTip");
    r.get("surfaceUv");
    r.finish()?;
    let (points, radii, starts) = without_short(points, radii, starts);
    Ok((Arc::new(Curves { points, radii, starts, style, motion: Vec::new() }), material))
}

/// Without curves of a single point, which have no extent.
fn without_short(points: Vec<Vec3>, radii: Vec<f32>, starts: Vec<u32>) -> (Vec<Vec3>, Vec<f32>, Vec<u32>) {
    if starts.windows(2).all(|w| w[1] - w[0] >= 2) {
        return (points, radii, starts);
    }
    let (mut p, mut r, mut s) = (Vec::with_capacity(points.len()), Vec::with_capacity(radii.len()), vec![0]);
    for w in starts.windows(2).filter(|w| w[1] - w[0] >= 2) {
        let range = w[0] as usize..w[1] as usize;
        p.extend_from_slice(&points[range.clone()]);
        r.extend_from_slice(&radii[range]);
        s.push(p.len() as u32);
    }
    (p, r, s)
}
