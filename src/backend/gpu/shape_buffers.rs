//! Shapes other than meshes as words. Twins: `shaders/shared/intersect.wesl` and the modules of single kinds beside it.

use super::buffers::{append, bits, bits3, inverse_reals, outward, real};
use super::mesh_buffers::MeshWords;
use crate::compile::geometry::{Prim, PrimKind};
use crate::compile::shape::blob::{BlobElementKind, BlobShape, GROUP};
use crate::compile::shape::curve::CurveSegment;
use crate::compile::shape::{HeightFieldShape, IsosurfaceShape, JuliaShape, LatheShape, PolyShape, PrismShape, SorShape};
use crate::compile::{CompiledScene, NONE};
use crate::math::{Bounds, DVec3};
use crate::scene::shape::{Container, JuliaFunction};

/// A number in 32 bits.
fn n(v: f64) -> u32 {
    (v as f32).to_bits()
}

fn reals(list: impl IntoIterator<Item = f64>) -> impl Iterator<Item = u32> {
    list.into_iter().flat_map(real)
}

/// The reals of vectors.
fn vectors<const N: usize>(list: [DVec3; N]) -> Vec<u32> {
    reals(list.into_iter().flat_map(|v| v.to_array())).collect()
}

/// Words of one shape; meshes stand already. `textures`: records of the covers.
pub(super) fn encode_shape(scene: &CompiledScene, p: &Prim, meshes: &MeshWords, textures: &[u32], words: &mut Vec<u32>) -> u32 {
    let (s, ix) = (&scene.geometry.shapes, p.shape_ix as usize);
    let new = match p.kind {
        PrimKind::Sphere => {
            let s = &s.spheres[ix];
            [&vectors([s.center])[..], &real(s.radius), &[s.uv_transform_ix], &bits3(s.uv_center)].concat()
        }
        PrimKind::Box => vectors([s.boxes[ix].min, s.boxes[ix].max]),
        PrimKind::Cylinder => vec![u32::from(s.cylinders[ix].open)],
        PrimKind::Cone => [&real(s.cones[ix].low)[..], &[u32::from(s.cones[ix].open)]].concat(),
        PrimKind::Plane => [&vectors([s.planes[ix].normal])[..], &real(s.planes[ix].distance)].concat(),
        PrimKind::Disc => reals([s.discs[ix].radius_sq, s.discs[ix].hole_sq]).collect(),
        PrimKind::Torus => reals([s.tori[ix].major, s.tori[ix].minor]).collect(),
        PrimKind::Triangle => {
            let t = &s.triangles[ix];
            let head = [&vectors(t.vertices)[..], &vectors([t.normal]), &real(t.distance), &[u32::from(t.smooth)]].concat();
            [head, vectors(t.normals)].concat()
        }
        PrimKind::Mesh | PrimKind::BicubicPatch => return meshes.places[ix],
        PrimKind::Glyph => {
            let g = &s.glyphs[ix];
            let head = reals([g.depth, g.min.x, g.min.y, g.max.x, g.max.y]);
            head.chain(outline(&g.segments)).collect()
        }
        PrimKind::Polygon => {
            let p = &s.polygons[ix];
            [vectors([p.origin, p.u, p.v, p.normal]), outline(&p.segments)].concat()
        }
        PrimKind::Quadric => reals(s.quadrics[ix].c).collect(),
        PrimKind::Poly => poly(&s.polys[ix]),
        PrimKind::Blob => blob(&s.blobs[ix], textures, words),
        PrimKind::Lathe => lathe(&s.lathes[ix]),
        PrimKind::Sor => sor(&s.sors[ix]),
        PrimKind::Prism => prism(&s.prisms[ix]),
        PrimKind::Superellipsoid => vec![n(s.superellipsoids[ix].xy_power), n(s.superellipsoids[ix].z_power)],
        PrimKind::HeightField => height_field(&s.height_fields[ix], words),
        PrimKind::Isosurface => isosurface(&s.isosurfaces[ix]),
        PrimKind::JuliaFractal => julia(&s.julias[ix], !p.wants_all_hits()),
        _ => Vec::new(),
    };
    append(words, new)
}

/// Number of pieces, and of each start, end, factors of w² and w; lines and parabolas only, as letters and polygons have them.
fn outline(segments: &[CurveSegment]) -> Vec<u32> {
    let piece = |s: &CurveSegment| reals([s.c[3], s.at(1.0), s.c[1], s.c[2]].into_iter().flat_map(|v| v.to_array())).collect::<Vec<u32>>();
    std::iter::once(segments.len() as u32).chain(segments.iter().flat_map(piece)).collect()
}

/// Pieces as `curve.wesl` reads them.
fn pieces(segments: &[CurveSegment]) -> impl Iterator<Item = u32> {
    segments.iter().flat_map(|s| {
        let head = [u32::from(s.degree), n(s.min.x), n(s.min.y), n(s.max.x), n(s.max.y)];
        head.into_iter().chain(s.c.into_iter().rev().flat_map(|c| reals([c.x, c.y])))
    })
}

fn poly(s: &PolyShape) -> Vec<u32> {
    let mut w = vec![s.order, s.terms.len() as u32];
    w.extend(reals(s.coefficients.iter().copied()));
    for t in &s.terms {
        let [x, y, z] = t.powers.map(u32::from);
        w.extend(real(t.factor));
        w.push(x | y << 8 | z << 16);
    }
    w
}

fn lathe(s: &LatheShape) -> Vec<u32> {
    let head = [s.segments.len() as u32, n(s.inner_radius), n(s.radius), n(s.low), n(s.high)];
    head.into_iter().chain(pieces(&s.segments)).collect()
}

fn sor(s: &SorShape) -> Vec<u32> {
    let mut w = vec![s.segments.len() as u32];
    w.extend(reals([s.base_sq, s.cap_sq]));
    for p in &s.segments {
        w.extend(reals([p.low, p.high]));
        w.extend(reals(p.c));
    }
    w
}

fn prism(s: &PrismShape) -> Vec<u32> {
    let head = [s.segments.len() as u32, u32::from(s.conic), u32::from(s.open)];
    head.into_iter().chain(reals([s.low, s.high])).chain(pieces(&s.segments)).collect()
}

fn corners(b: &Bounds) -> [u32; 6] {
    let (low, high) = outward(b);
    let ([a, b, c], [d, e, f]) = (bits(low), bits(high));
    [a, b, c, d, e, f]
}

fn blob(s: &BlobShape, textures: &[u32], words: &mut Vec<u32>) -> Vec<u32> {
    let rows: Vec<u32> = s.transforms.iter().map(|t| append(words, inverse_reals(t))).collect();
    let own = |k: &u32| if *k == NONE { 0 } else { textures[*k as usize] };
    let n_textured = s.textures.iter().filter(|t| **t != NONE).count() as u32;
    let mut w = vec![s.elements.len() as u32];
    w.extend(real(s.threshold));
    w.push(n_textured);
    debug_assert_eq!(s.groups.len(), s.elements.len().div_ceil(GROUP), "as the shader counts them");
    w.extend(s.groups.iter().flat_map(corners));
    for e in &s.elements {
        let (kind, length) = match e.kind {
            BlobElementKind::Sphere => (0, 0.0),
            BlobElementKind::HemisphereBelow => (1, 0.0),
            BlobElementKind::Cylinder { length } => (2, length),
        };
        w.push(kind);
        w.extend(vectors([e.center, e.axis]));
        w.extend(reals([length, e.radius_sq, e.f0]));
        w.push(rows.get(e.transform_ix as usize).copied().unwrap_or(0));
        w.push(s.textures.get(e.component as usize).map_or(0, own));
    }
    w
}

fn height_field(s: &HeightFieldShape, words: &mut Vec<u32>) -> Vec<u32> {
    let blocks_at = append(words, s.blocks.iter().map(|(low, high)| u32::from(*low) | u32::from(*high) << 16));
    let pair = |h: &[u16]| u32::from(h[0]) | h.get(1).map_or(0, |v| u32::from(*v) << 16);
    let heights_at = append(words, s.grid.heights.chunks(2).map(pair));
    vec![s.grid.width, s.grid.height, u32::from(s.smooth), n(s.low), n(s.high), n(s.water), s.blocks_x, blocks_at, heights_at]
}

fn isosurface(s: &IsosurfaceShape) -> Vec<u32> {
    let evaluate = s.evaluate.unwrap_or_default();
    let mut w = vec![s.function, n(s.threshold), n(s.accuracy), n(s.max_gradient), u32::from(s.evaluate.is_some())];
    w.extend(evaluate.map(n));
    w.extend([u32::from(s.open), s.max_trace]);
    match s.container {
        Container::Box { min, max } => {
            w.push(0);
            w.extend([bits3(min), bits3(max)].concat());
        }
        Container::Sphere { center, radius } => {
            w.push(1);
            w.extend(bits3(center));
            w.extend([n(radius), 0, 0]);
        }
    }
    w
}

/// Number and function as `julia.wesl` knows them; `None` for functions that it does not.
pub(super) fn julia_kind(s: &JuliaShape) -> Option<u32> {
    match (s.hypercomplex, s.function) {
        (false, JuliaFunction::Sqr) => Some(0),
        (false, JuliaFunction::Cube) => Some(1),
        (true, JuliaFunction::Sqr) => Some(2),
        (true, JuliaFunction::Reciprocal) => Some(3),
        _ => None,
    }
}

/// `is_whole`: no CSG asks for hits behind the first.
fn julia(s: &JuliaShape, is_whole: bool) -> Vec<u32> {
    let mut w: Vec<u32> = reals(s.c.to_array()).collect();
    w.extend([julia_kind(s).unwrap_or(0), s.max_iteration, u32::from(is_whole)]);
    w.extend(reals([s.precision, s.w0]));
    w.extend(reals(s.w_slope.to_array()));
    w.extend(reals([s.escape_sq, s.radius]));
    w
}
