//! What the GPU declines. Everything here gives one line that names the feature; the caller renders on the CPU instead.
//! UNSUPPORTED.md has the same list, under "GPU".

use super::shape_buffers::julia_kind;
use super::texture_buffers::{TextureRoots, encode_textures};
use crate::backend::BackendError;
use crate::compile::geometry::{PrimKind, prim_flags};
use crate::compile::texture::TextureNode;
use crate::compile::{CompiledScene, NONE};
use crate::math::Vec3;

/// Kinds of primitives that the shaders know, with the name of their feature.
pub(super) const KINDS: &[(PrimKind, &str)] = &[
    (PrimKind::Sphere, "sphere"),
    (PrimKind::Box, "box"),
    (PrimKind::Cylinder, "cylinder"),
    (PrimKind::Cone, "cone"),
    (PrimKind::Plane, "plane"),
    (PrimKind::Disc, "disc"),
    (PrimKind::Torus, "torus"),
    (PrimKind::Triangle, "triangle"),
    (PrimKind::Mesh, "mesh"),
    (PrimKind::BicubicPatch, "mesh"),
    (PrimKind::Glyph, "glyph"),
    (PrimKind::Polygon, "polygon"),
    (PrimKind::Quadric, "quadric"),
    (PrimKind::Poly, "poly"),
    (PrimKind::Blob, "blob"),
    (PrimKind::Lathe, "lathe"),
    (PrimKind::Sor, "sor"),
    (PrimKind::Prism, "prism"),
    (PrimKind::Superellipsoid, "superellipsoid"),
    (PrimKind::HeightField, "height_field"),
    (PrimKind::Isosurface, "isosurface"),
    (PrimKind::JuliaFractal, "julia_fractal"),
];
/// Kinds whose hits say where on a side they are.
pub(super) const PLACED: &[PrimKind] = &[PrimKind::Lathe, PrimKind::Prism];

/// Of polynomial surfaces (`unit_roots.wesl`).
const MOST_POLY_ORDER: u32 = 10;
/// Of media: each level doubles the places that samples may have.
const MOST_AA_LEVEL: u32 = 8;

/// Refuses what the classic integrator cannot render here, with all of the reasons.
pub fn check(scene: &CompiledScene) -> Result<(), BackendError> {
    let mut list = obstacles(scene);
    if list.is_empty() {
        return Ok(());
    }
    // What textures ask for is found when they are encoded: once here so that the list is whole.
    if let Err(BackendError::Unsupported(what)) = encode_textures(&scene.textures, &roots(scene, None), false) {
        list.push(what);
    }
    Err(BackendError::Unsupported(list.join(", ")))
}

/// What the shaders evaluate of a scene's textures and functions, those that weigh up to `most_written` written out.
pub(super) fn roots(scene: &CompiledScene, most_written: Option<usize>) -> TextureRoots {
    let functions = scene.geometry.shapes.isosurfaces.iter().map(|s| s.function).collect();
    let mut all = TextureRoots { functions, most_written, ..TextureRoots::of_scene(scene) };
    all.pigments.extend(scene.media.iter().flat_map(|m| &m.densities));
    all
}

/// Refuses shapes that cannot be traced here, whatever covers and lights them.
pub(super) fn check_geometry(scene: &CompiledScene) -> Result<(), BackendError> {
    if scene.geometry.prims.iter().any(|p| p.kind == PrimKind::Isosurface) {
        // Its function reads tables that are not there.
        return Err(BackendError::Unsupported("isosurface objects without their scene".into()));
    }
    match unknown_shapes(scene) {
        list if list.is_empty() => Ok(()),
        list => Err(BackendError::Unsupported(list.join(", "))),
    }
}

fn unknown_shapes(scene: &CompiledScene) -> Vec<String> {
    let mut list: Vec<String> = Vec::new();
    for p in scene.geometry.prims.iter().filter(|p| !KINDS.iter().any(|(k, _)| *k == p.kind)) {
        let name = format!("{} objects", object_name(p.kind));
        if !list.contains(&name) {
            list.push(name);
        }
    }
    list
}

fn obstacles(scene: &CompiledScene) -> Vec<String> {
    let mut list = unknown_shapes(scene);
    list.extend(listed(scene).iter().filter(|(holds, _)| *holds).map(|(_, what)| (*what).to_owned()));
    list
}

/// Whether the scene uses each of what is named.
fn listed(scene: &CompiledScene) -> [(bool, &'static str); 16] {
    let f = &scene.features;
    [
        (scene.options.quality < 9, "quality levels below 9"),
        (scene.media.iter().any(|m| m.params.method != 3), "media of methods 1 and 2"),
        (scene.media.iter().any(|m| m.params.aa_level > MOST_AA_LEVEL), "media of an aa_level above 8"),
        (f.media && !scene.fogs.is_empty(), "fog with media"),
        (area_in_media(scene), "area lights in media"),
        (media_of_giants(scene), "media of a body a thousand times as large as the camera's distance from it"),
        (f.rainbow && f.media, "rainbows with media"),
        (f.radiosity, "radiosity"),
        (f.photons, "photons"),
        (f.subsurface, "subsurface light"),
        (f.dispersion, "dispersion"),
        (scene.lights.iter().any(|l| l.light.radius > 0.0), "lights with a radius"),
        (scene.textures.finishes.iter().any(|f| f.reflection.exponent != 1.0), "reflection_exponent"),
        (nested_bounds(scene), "bounded_by inside bounded_by"),
        (scene.geometry.shapes.polys.iter().any(|s| s.order > MOST_POLY_ORDER), "polynomials of an order above 10"),
        (
            scene.geometry.shapes.julias.iter().any(|s| julia_kind(s).is_none()),
            "julia fractals of other functions than square, cube and reciprocal",
        ),
    ]
}

/// Whether media scatter the light of area lights.
fn area_in_media(scene: &CompiledScene) -> bool {
    scatters(scene) && scene.lights.iter().any(|l| l.light.area.is_some() && l.light.media_interaction && !l.light.shadowless)
}

/// Whether the camera is so close to the surface of a round body with media that single precision loses where they begin: planets with
/// air (measured: a radius of 50,000, seen from 1 above, is wrong in most pixels).
fn media_of_giants(scene: &CompiledScene) -> bool {
    let eye = scene.camera.location;
    scene.geometry.objects.iter().any(|o| {
        let has_media = o.interior_ix != NONE && !scene.interiors[o.interior_ix as usize].media.is_empty();
        let (centre, half) = (0.5 * (o.bounds.min + o.bounds.max), 0.5 * (o.bounds.max - o.bounds.min));
        has_media && (((eye - centre) / half).length() - 1.0).abs() < 1e-3
    })
}

/// Whether media ask for lamps.
pub(super) fn scatters(scene: &CompiledScene) -> bool {
    scene.media.iter().any(|m| m.params.scattering != Vec3::ZERO) && !scene.lights.is_empty()
}

/// Whether the objects that bound others are bounded themselves.
fn nested_bounds(scene: &CompiledScene) -> bool {
    let g = &scene.geometry;
    g.bounding_objects.iter().any(|o| g.objects[*o as usize].prims.clone().any(|p| g.prims[p as usize].flags & prim_flags::BOUNDED != 0))
}

pub(super) fn object_name(kind: PrimKind) -> &'static str {
    match kind {
        PrimKind::Sphere => "sphere",
        PrimKind::Box => "box",
        PrimKind::Cylinder => "cylinder",
        PrimKind::Cone => "cone",
        PrimKind::Plane => "plane",
        PrimKind::Disc => "disc",
        PrimKind::Torus => "torus",
        PrimKind::Triangle => "triangle",
        PrimKind::Glyph => "text",
        PrimKind::Polygon => "polygon",
        PrimKind::Quadric => "quadric",
        PrimKind::Poly => "poly",
        PrimKind::Blob => "blob",
        PrimKind::Lathe => "lathe",
        PrimKind::Sor => "sor",
        PrimKind::Prism => "prism",
        PrimKind::SphereSweep => "sphere_sweep",
        PrimKind::Superellipsoid => "superellipsoid",
        PrimKind::Ovus => "ovus",
        PrimKind::JuliaFractal => "julia_fractal",
        PrimKind::HeightField => "height_field",
        PrimKind::Isosurface => "isosurface",
        PrimKind::Parametric => "parametric",
        PrimKind::Hair => "hair",
        _ => "unknown",
    }
}

/// How much a hit may ask for, over all covers and layers of it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct FanOut {
    /// Plain textures.
    pub leaves: u32,
    /// Layers of them all.
    pub layers: u32,
    /// Most layers of one.
    pub deepest: u32,
}

/// The most that texture `ix` asks for at a point.
pub(super) fn fan_out(scene: &CompiledScene, ix: u32) -> FanOut {
    let t = &scene.textures;
    let entries = |start: u32, len: u32| t.texture_entries[start as usize..][..len as usize].iter().map(|e| fan_out(scene, e.1));
    let most = |list: &mut dyn Iterator<Item = FanOut>, times: u32| {
        list.fold(FanOut::default(), |a, b| FanOut {
            leaves: a.leaves.max(b.leaves * times),
            layers: a.layers.max(b.layers * times),
            deepest: a.deepest.max(b.deepest),
        })
    };
    match t.textures[ix as usize] {
        TextureNode::Layers { len, .. } => FanOut { leaves: 1, layers: len, deepest: len },
        TextureNode::Principled(_) => FanOut { leaves: 1, layers: 1, deepest: 1 },
        TextureNode::Map { start, len, .. } => most(&mut entries(start, len), 2),
        TextureNode::MaterialMap { start, len, .. } => most(&mut entries(start, len), 1),
        TextureNode::Average { start, len, .. } => entries(start, len).fold(FanOut::default(), |a, b| FanOut {
            leaves: a.leaves + b.leaves,
            layers: a.layers + b.layers,
            deepest: a.deepest.max(b.deepest),
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::{KINDS, listed, object_name};
    use crate::compile::geometry::PrimKind;
    use crate::compile::{CompileOptions, compile_scene};
    use crate::scene::Scene;
    use std::collections::BTreeSet;

    /// Faults of this program and of its tools, no features of scenes.
    const FAULTS: [&str; 9] = [
        "more rays in flight than the queue holds",
        "hits that send on more rays than was foreseen",
        "isosurface objects without their scene",
        "loops of more than 65,535 turns, which llvmpipe cuts short",
        "timestamps, on this device",
        "shader 'N': N",
        "the pattern 'N'",
        "an operation of a function",
        "the built-in function N",
    ];

    /// The text in quotes after each place where a refusal begins; what is filled in is N.
    fn refusals(source: &str) -> Vec<String> {
        let starts = ["Unsupported(\"", "Unsupported(format!(\"", "refused(\"", "refused(format!(\""];
        let mut found = Vec::new();
        for (start, at) in starts.iter().flat_map(|s| source.match_indices(s).map(|(k, _)| (s.len(), k))) {
            let text = source[at + start..].split('"').next().unwrap_or_default();
            let plain = text.split(" (at most").next().unwrap_or_default().split('{');
            found.push(plain.map(|part| part.split_once('}').map_or(part.to_owned(), |(_, rest)| format!("N{rest}"))).collect());
        }
        found
    }

    /// What docs/gpu.md says of machines, and what is refused, are the same.
    #[test]
    fn the_table_of_what_runs_where_has_every_refusal_and_no_other() {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
        let page = std::fs::read_to_string(folder.join("docs/gpu.md")).expect("the page is there");
        let section = page.split("## What runs where").nth(1).and_then(|s| s.split("\n## ").next()).expect("the section is there");
        let cells = section.lines().filter(|l| l.starts_with("| ")).filter_map(|l| l.trim_end_matches('|').rsplit('|').next());
        let told: BTreeSet<String> = cells.flat_map(|c| c.split('`').skip(1).step_by(2)).map(str::to_owned).collect();
        let scene = compile_scene(&Scene::default(), &CompileOptions::default()).expect("nothing compiles");
        let mut refused: BTreeSet<String> = listed(&scene).iter().map(|(_, what)| (*what).to_owned()).collect();
        let all = [PrimKind::SphereSweep, PrimKind::Ovus, PrimKind::Parametric, PrimKind::Hair];
        refused.extend(all.iter().filter(|k| !KINDS.iter().any(|(known, _)| known == *k)).map(|k| format!("{} objects", object_name(*k))));
        refused.insert("passes".into());
        let files = std::fs::read_dir(folder.join("src/backend/gpu")).expect("the sources are there");
        for path in files.filter_map(|f| Some(f.ok()?.path())).filter(|p| p.extension().is_some_and(|e| e == "rs")) {
            let source = std::fs::read_to_string(&path).expect("it can be read");
            let source = source.split("#[cfg(test)]").next().unwrap_or_default();
            refused.extend(refusals(source).into_iter().filter(|r| !FAULTS.contains(&r.as_str())));
        }
        assert!(refused.len() > 25, "{refused:?}");
        assert_eq!(refused.difference(&told).collect::<Vec<_>>(), Vec::<&String>::new(), "refused, but not in docs/gpu.md");
        assert_eq!(told.difference(&refused).collect::<Vec<_>>(), Vec::<&String>::new(), "in docs/gpu.md, but not refused");
    }
}
