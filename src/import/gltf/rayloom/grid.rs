//! Density grids.

use super::super::super::ImportError;
use super::record::Record;
use crate::math::{DAffine3, DMat3, DVec3, Transform};
use crate::scene::volume::{Density, Grid};
use std::sync::Arc;

/// Most cells of a grid.
const MAX_CELLS: u64 = 1 << 30;

/// A grid with its place in the object.
pub(super) fn density(r: &Record) -> Result<Density, ImportError> {
    let doc = r.document();
    let size = r.needed("resolution", r.numbers::<3>("resolution")?)?;
    if size.iter().any(|n| n.fract() != 0.0 || !(1.0..=65536.0).contains(n)) {
        return Err(r.wrong("resolution", "cells must be whole numbers from 1 to 65536"));
    }
    let size = size.map(|n| n as u32);
    let n = size.iter().map(|n| u64::from(*n)).product::<u64>();
    if n > MAX_CELLS {
        return Err(r.wrong("resolution", format!("{n} cells are more than the limit of {MAX_CELLS}")));
    }
    if r.count_or("components", 1)? != 1 {
        return Err(r.wrong("components", "densities have one component"));
    }
    let view = r.needed("bufferView", r.index("bufferView", doc.root.buffer_views.len(), "buffer view")?)?;
    let bytes = doc.view(view, || r.path().to_owned())?;
    if (bytes.len() as u64) < 4 * n {
        return Err(r.wrong("bufferView", format!("{} bytes are too few for {n} cells", bytes.len())));
    }
    let cell = |b: &[u8]| f32::from_le_bytes([b[0], b[1], b[2], b[3]]);
    let finite = |v: f32| if v.is_finite() { v.max(0.0) } else { 0.0 };
    let cells = bytes.chunks_exact(4).take(n as usize).map(|b| finite(cell(b))).collect();
    let a = r.needed("affine", r.numbers::<12>("affine")?)?;
    let row = |k: usize| DVec3::new(a[4 * k], a[4 * k + 1], a[4 * k + 2]);
    let matrix3 = DMat3::from_cols(row(0), row(1), row(2)).transpose();
    let translation = DVec3::new(a[3], a[7], a[11]);
    let transform = Transform::from_affine(DAffine3 { matrix3, translation })
        .filter(|_| matrix3.determinant() != 0.0)
        .ok_or_else(|| r.wrong("affine", "it cannot be inverted"))?;
    r.finish()?;
    Ok(Density { grid: Arc::new(Grid { size, cells }), transform })
}
