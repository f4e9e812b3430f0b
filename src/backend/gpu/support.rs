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
    if let Err(BackendError::Unsupported(what)) = encode_textures(&scene.textures, &roots(scene), false) {
        list.push(what);
    }
    Err(BackendError::Unsupported(list.join(", ")))
}

/// What the shaders evaluate of a scene's textures and functions.
pub(super) fn roots(scene: &CompiledScene) -> TextureRoots {
    let functions = scene.geometry.shapes.isosurfaces.iter().map(|s| s.function).collect();
    let mut all = TextureRoots { functions, ..TextureRoots::of_scene(scene) };
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
    let f = &scene.features;
    let listed = [
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
    ];
    let mut list = unknown_shapes(scene);
    if scene.geometry.shapes.julias.iter().any(|s| julia_kind(s).is_none()) {
        list.push("julia fractals of other functions than square, cube and reciprocal".into());
    }
    list.extend(listed.iter().filter(|(holds, _)| *holds).map(|(_, what)| (*what).to_owned()));
    list
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
