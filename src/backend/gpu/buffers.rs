//! A compiled scene as the arrays that the shaders read: structs (`layout`), and words for what differs in length.
//! Twin of the bindings: `shaders/shared/bindings.wesl`.

use super::camera::{crowded, start_interiors};
use super::camera_buffers::{DeviceCamera, camera_words};
use super::layout::{Finish, Interior, Light, Prim, SceneParams, Transform};
use super::light_buffers::{LIGHT_CONSTANTS, emitter, light};
use super::material_buffers::{encode_materials, material_constants};
use super::media_buffers::{encode_media, media_options};
use super::mesh_buffers::{Boxes, MeshWords, encode_meshes};
use super::shader::ShaderOptions;
use super::shape_buffers::encode_shape;
use super::support::{FanOut, KINDS, PLACED, fan_out, roots};
use super::texture_buffers::{TextureWords, encode_textures};
use super::tree_words::{choose_walk, has_lists, structure_of, words_per_element};
use crate::accel::AccelKind;
use crate::backend::BackendError;
use crate::compile::geometry::{InsideStep, PrimKind, prim_flags};
use crate::compile::{CompiledScene, NONE};
use crate::integrate::classic::{SHARP_MIRROR, ScenePlan};
use crate::kernel::light::SUN_DISTANCE;
use crate::kernel::traverse::{MIN_DEPTH, SHADOW_TOLERANCE};
use crate::math::{Bounds, DVec3, MAX_DISTANCE, Rgbft, Vec3};
use crate::savings::Saving;
use std::collections::BTreeSet;

/// Everything of a scene, encoded.
pub(super) struct SceneBuffers {
    pub params: SceneParams,
    pub prims: Vec<Prim>,
    pub transforms: Vec<Transform>,
    pub words: Vec<u32>,
    pub meshes: MeshWords,
    pub finishes: Vec<Finish>,
    pub lights: Vec<Light>,
    pub interiors: Vec<Interior>,
    pub textures: TextureWords,
    pub options: ShaderOptions,
    /// Most rays that one hit sends on.
    pub max_children: u32,
    /// Most shadow rays of one hit.
    pub max_shadows: u32,
    /// Most area lights that one hit asks.
    pub max_areas: u32,
    /// Points of them all.
    pub max_area_points: u32,
    /// Points that the samples of a ray's media have.
    pub media_points: u32,
    /// Some medium is there.
    pub media: bool,
    /// What the device makes of the camera's rays.
    pub camera: DeviceCamera,
    /// Some shadow rays go on behind what they meet.
    pub transparency: bool,
}

/// Lit layers of a hit that a shader holds at once.
const MAX_LIT: u32 = 64;
/// Share of a coordinate within which a ray does not see the surface that it starts on. Measured: scenes of 1e4 units, 32-bit numbers.
const MIN_DEPTH_SHARE: f32 = 3e-6;

pub(super) fn v3(v: DVec3) -> [f32; 3] {
    v.as_vec3().to_array()
}

/// Appends words and gives their place. Place 0 is never given: it means "none".
pub(super) fn append(words: &mut Vec<u32>, new: impl IntoIterator<Item = u32>) -> u32 {
    if words.is_empty() {
        words.push(0);
    }
    let at = words.len() as u32;
    words.extend(new);
    at
}

/// Bits of 32-bit numbers.
pub(super) fn bits<const N: usize>(v: [f32; N]) -> [u32; N] {
    v.map(f32::to_bits)
}

pub(super) fn bits3(v: DVec3) -> [u32; 3] {
    bits(v3(v))
}

/// A number in 32 bits, and what they left off: the two words of a real (`real.wesl`).
pub(super) fn real(v: f64) -> [u32; 2] {
    let near = v as f32;
    [near.to_bits(), low_part(v).to_bits()]
}

/// What 32 bits leave off a number.
pub(super) fn low_part(v: f64) -> f32 {
    let near = v as f32;
    if near.is_finite() { (v - f64::from(near)) as f32 } else { 0.0 }
}

/// What 32 bits leave off a vector.
pub(super) fn low_part3(v: DVec3) -> [f32; 3] {
    v.to_array().map(low_part)
}

/// Rows of the way back from a space, in 32 bits.
pub(super) fn inverse_rows(t: &crate::math::Transform) -> impl Iterator<Item = u32> + use<> {
    rows_of(&t.inverse).into_iter().flatten().map(|v| (v as f32).to_bits())
}

/// Rows of the way back from a space, as reals.
pub(super) fn inverse_reals(t: &crate::math::Transform) -> impl Iterator<Item = u32> + use<> {
    rows_of(&t.inverse).into_iter().flatten().flat_map(real)
}

/// Rows of an affine map.
fn rows_of(a: &crate::math::DAffine3) -> [[f64; 4]; 3] {
    let (m, d) = (a.matrix3, a.translation);
    std::array::from_fn(|k| [m.x_axis[k], m.y_axis[k], m.z_axis[k], d[k]])
}

/// A box rounded and padded outward.
pub(super) fn outward(b: &Bounds) -> ([f32; 3], [f32; 3]) {
    let limit = |v: DVec3| v.clamp(DVec3::splat(-1e18), DVec3::splat(1e18)).as_vec3();
    let pad = |v: Vec3| v.abs() * 1e-6 + Vec3::splat(1e-30);
    let (low, high) = (limit(b.min), limit(b.max));
    ((low - pad(low)).to_array(), (high + pad(high)).to_array())
}

/// Corners of a box, rounded outward.
fn box_words(b: &Bounds) -> Vec<u32> {
    let (low, high) = outward(b);
    [bits(low), bits(high)].concat()
}

/// Features that a shader may hold for scenes that do not use them.
const SPARE: [&str; 11] = [
    "reflection",
    "highlights",
    "irid",
    "normals",
    "uv",
    "solid_mesh",
    "cutaway",
    "bounded_by",
    "bounding_objects",
    "programs",
    "unbounded",
];

impl SceneBuffers {
    /// Encodes `scene`, with structures of kind `kind`, for a picture that `plan` was made for; functions that weigh up to `most_written` are written out.
    pub fn new(scene: &CompiledScene, plan: &ScenePlan, kind: AccelKind, most_written: usize) -> Result<Self, BackendError> {
        let g = &scene.geometry;
        let mut textures = encode_textures(&scene.textures, &roots(scene, Some(most_written)), !plan.quality.normals)?;
        // Functions that ask patterns that ask objects whose insides are functions would call themselves.
        let asks_patterns = textures.shader.functions.contains("free_value(");
        if asks_patterns && textures.shader.features.contains("pattern_object") && g.prims.iter().any(|p| p.kind == PrimKind::Isosurface) {
            return Err(BackendError::Unsupported("object patterns beside isosurfaces and functions of patterns".into()));
        }
        let mut words = vec![0];
        let meshes = encode_meshes(scene, kind, &textures, &mut words)?;
        let mut params = scene_params(scene);
        params.materials_at = encode_materials(&scene.textures.principled, &mut words, &mut textures.image_words);
        let emitters: Vec<u32> = plan.emitters.iter().flat_map(emitter).collect();
        params.n_emitters = plan.emitters.len() as u32;
        params.emitters_at = append(&mut words, emitters);
        let transparency = g.prims.iter().any(|p| p.flags & prim_flags::TRANSPARENT != 0);
        let around: Vec<u32> = start_interiors(scene, plan).iter().collect();
        if around.len() > params.camera_interiors.len() {
            return Err(crowded());
        }
        params.camera_interiors[..around.len()].copy_from_slice(&around);
        params.n_camera_interiors = around.len() as u32;
        params.clip_steps_at = append(&mut words, g.clip_steps.iter().flat_map(clip_step));
        params.clip_boxes_at = append(&mut words, g.clip_boxes.iter().flat_map(box_words));
        params.fogs_at = encode_fogs(scene, &mut words);
        params.rainbows_at = encode_rainbows(scene, &mut words, &mut textures.words);
        if let Some(sky) = &scene.sky {
            let pigments = sky.pigments.iter().map(|p| textures.pigments[*p as usize]);
            params.sky_at = append(&mut words, std::iter::once(sky.pigments.len() as u32).chain(pigments));
            params.sky_emission = sky.emission.to_array();
            params.sky_transform_ix = sky.transform_ix;
        }
        let mut tree = structure_of(kind, &g.tree, &Boxes(&g.bounds, &g.bounded));
        if kind == AccelKind::BruteGroup {
            let is_mesh = |k: &u32| matches!(g.prims[g.bounded[*k as usize] as usize].kind, PrimKind::Mesh | PrimKind::BicubicPatch);
            tree.order.sort_by_key(|k| !is_mesh(k));
            params.n_meshes = tree.order.iter().filter(|k| is_mesh(k)).count() as u32;
        }
        let scene_depth = tree.depth;
        let mut tree_nodes = std::mem::take(&mut tree.nodes);
        tree_nodes.resize(tree_nodes.len().next_multiple_of(words_per_element(kind) as usize), 0);
        // Leaves name places in the order, which name primitives; a kd-tree's name primitives at once. A grid's lists stand behind.
        let prim_at = |k: &u32| g.bounded[tree.order[*k as usize] as usize];
        let is_direct = has_lists(kind) || tree.refs.is_empty();
        params.n_bounded = tree.order.len() as u32;
        let mut tree_refs: Vec<u32> =
            if is_direct { (0..params.n_bounded).map(|k| prim_at(&k)).collect() } else { tree.refs.iter().map(prim_at).collect() };
        let lists_at = if has_lists(kind) { tree_refs.len() as u32 } else { 0 };
        if has_lists(kind) {
            tree_refs.extend(&tree.refs);
        }
        params.lists_at = lists_at;
        params.unbounded_at = tree_refs.len() as u32;
        params.n_unbounded = g.unbounded.len() as u32;
        tree_refs.extend_from_slice(&g.unbounded);
        let all = g.bounded.iter().fold(Bounds::EMPTY, |b, k| b.union(g.bounds[*k as usize]));
        (params.tree_low, params.tree_high) = outward(&all);
        params.tree_extent = Vec3::from(params.tree_low).abs().max(Vec3::from(params.tree_high).abs()).max_element();
        let meshes = meshes.behind(&mut tree_nodes, &mut tree_refs, &mut words);
        let prims = encode_prims(scene, plan, &textures, &meshes, &mut words);
        let mut interiors: Vec<Interior> = scene.interiors.iter().map(interior).collect();
        encode_media(scene, plan, &textures, &mut words, &mut params, &mut interiors);
        let lights = scene.lights.iter().map(|l| light(scene, l, &mut words)).collect();
        let mut options = textures.shader.clone();
        let camera = camera_words(scene, plan, &mut words, &mut options);
        let mut buffers = Self {
            params,
            prims,
            transforms: g.transforms.iter().map(transform).collect(),
            words,
            meshes,
            finishes: scene.textures.finishes.iter().map(finish).collect(),
            lights,
            interiors,
            textures,
            options,
            max_children: 0,
            max_shadows: 0,
            max_areas: 0,
            max_area_points: 0,
            media_points: 0,
            media: scene.features.media,
            camera,
            transparency,
        };
        buffers.meshes.nodes = tree_nodes;
        buffers.meshes.refs = tree_refs;
        buffers.options = buffers.shader_options(scene, plan, kind, scene_depth)?;
        Ok(buffers)
    }

    /// Features and constants of the shaders; works out the sizes of the queues, too.
    fn shader_options(
        &mut self,
        scene: &CompiledScene,
        plan: &ScenePlan,
        kind: AccelKind,
        scene_depth: u32,
    ) -> Result<ShaderOptions, BackendError> {
        let (g, f) = (&scene.geometry, &scene.features);
        let mut o = std::mem::take(&mut self.options);
        let all = !scene.options.savings.has(Saving::Shaders);
        for (kind, name) in KINDS {
            // Without functions there is nothing that an isosurface could call.
            let may_be = *kind != PrimKind::Isosurface;
            o.feature_if(name, all && may_be || f.prim_kinds & (1 << *kind as u32) != 0);
        }
        let face_covers = g.shapes.meshes.iter().any(|m| !m.mesh.face_textures.is_empty());
        // Components of a blob that go without texture show the object's.
        let of_blob = |b: &crate::compile::shape::BlobShape| b.textures.iter().collect::<BTreeSet<_>>().len() as u32;
        let blob_covers = g.shapes.blobs.iter().map(of_blob).max().unwrap_or(0);
        let cutaway = g.objects.iter().map(|o| o.cutaway.len()).max().unwrap_or(0) as u32;
        let solid_mesh = f.prim_kinds & (1 << PrimKind::Mesh as u32) != 0 && g.shapes.meshes.iter().any(|m| m.mesh.inside_vector.is_some());
        let bounding_objects = !g.bounding_objects.is_empty();
        let areas = || scene.lights.iter().filter_map(|l| l.light.area.as_ref());
        let features = [
            ("transparency", self.transparency),
            ("reflection", f.reflection),
            ("highlights", f.highlights),
            ("irid", f.irid),
            ("area_lights", areas().next().is_some()),
            ("area_illumination", areas().any(|a| a.area_illumination)),
            ("crand", f.crand),
            ("projected_through", scene.lights.iter().any(|l| l.projected_through != NONE)),
            ("random", ScenePlan::needs_ordered_rays(scene)),
            ("normals", f.normals),
            ("fog", !scene.fogs.is_empty()),
            ("rainbow", f.rainbow),
            ("fog_turbulence", scene.fogs.iter().any(|f| f.turbulence.is_some())),
            ("sky", scene.sky.is_some()),
            ("modern", plan.modern),
            ("output_alpha", plan.output_alpha),
            ("uv", f.uv),
            ("solid_mesh", solid_mesh),
            ("face_covers", face_covers),
            ("blob_covers", blob_covers > 1),
            ("places", PLACED.iter().any(|k| all || f.prim_kinds & (1 << *k as u32) != 0)),
            ("cutaway", cutaway > 0),
            ("unbounded", !g.unbounded.is_empty()),
            ("programs", f.clip_programs || cutaway > 0 || self.textures.shader.features.contains("pattern_object") || bounding_objects),
            ("bounded_by", g.prims.iter().any(|p| p.flags & prim_flags::BOUNDED != 0)),
            ("bounding_objects", bounding_objects),
            ("principled", f.principled),
            ("image_words", !self.textures.image_words.is_empty()),
        ];
        features.iter().for_each(|(name, holds)| o.feature_if(name, *holds || all && SPARE.contains(name)));
        let covers = cutaway.max(if face_covers { 3 } else { 1 }).max(blob_covers);
        let fan = self.textures.textures.iter().enumerate().filter(|(_, at)| **at != 0).map(|(ix, _)| fan_out(scene, ix as u32));
        let fan = fan.fold(FanOut::default(), |a, b| FanOut {
            leaves: a.leaves.max(b.leaves),
            layers: a.layers.max(b.layers),
            deepest: a.deepest.max(b.deepest),
        });
        let max_lit = (fan.layers * covers).max(1);
        if max_lit > MAX_LIT {
            return Err(BackendError::Unsupported(format!("points that show {max_lit} layers of texture at once (at most {MAX_LIT})")));
        }
        let mirrors = if f.reflection { fan.deepest.max(1) } else { 0 };
        let of_material = if f.principled { 3 } else { 0 };
        self.max_children = fan.leaves.max(1) * covers * (mirrors + u32::from(self.transparency)).max(of_material);
        // Layers share one ray a lamp, materials ask for their own.
        let of_materials = if f.principled { fan.leaves * covers * (scene.lights.len() + plan.emitters.len()) as u32 } else { 0 };
        self.max_shadows = scene.lights.len() as u32 + of_materials;
        let askers = 1 + if f.principled { fan.leaves * covers } else { 0 };
        self.max_areas = areas().count() as u32 * askers;
        let n_points = areas().map(|a| u64::from(a.n1) * u64::from(a.n2)).sum::<u64>() * u64::from(askers);
        self.max_area_points =
            u32::try_from(n_points).map_err(|_| BackendError::Unsupported("area lights of billions of points".into()))?;
        let longest = areas().map(|a| a.n1.max(a.n2)).max().unwrap_or(1);
        let constants = [
            ("WORKGROUP", super::device::WORKGROUP),
            ("MAX_COVERS", covers),
            ("MAX_LIT", max_lit),
            ("MAX_MIRRORS", mirrors.max(1)),
            ("N_LIGHTS", scene.lights.len() as u32),
            ("FOG_LEN", FOG_LEN),
            ("RAINBOW_LEN", RAINBOW_LEN),
            ("MAX_RECURSION", 1200),
            ("RAY_REFLECTED", RAY_REFLECTED),
            ("FAULT_INTERIORS", FAULT_INTERIORS),
            ("FAULT_CHILDREN", FAULT_QUEUE),
            ("FAULT_SHADOWS", FAULT_QUEUE),
            ("FLAG_NO_SHADOW", prim_flags::NO_SHADOW),
            ("FLAG_NO_GLOBAL_LIGHTS", prim_flags::NO_GLOBAL_LIGHTS),
            ("FLAG_NO_IMAGE", prim_flags::NO_IMAGE),
            ("FLAG_NO_REFLECTION", prim_flags::NO_REFLECTION),
            ("FLAG_DOUBLE_ILLUMINATE", prim_flags::DOUBLE_ILLUMINATE),
            ("FLAG_INVERTED", prim_flags::INVERTED),
            ("FLAG_UV_MAPPING", prim_flags::UV_MAPPING),
            ("FLAG_TRANSPARENT", prim_flags::TRANSPARENT),
            ("FLAG_INSIDE_ONLY", prim_flags::INSIDE_ONLY),
            ("AREA_DONE", u32::MAX),
            // Each level takes a part away and brings four, and halves their sides.
            ("AREA_STACK", 3 * (longest.max(1).ilog2() + 1) + 4),
        ];
        constants.iter().chain(LIGHT_CONSTANTS).for_each(|(name, v)| o.constant(name, *v));
        choose_walk(&mut o, kind, scene_depth, self.meshes.depth);
        for (code, name) in STEP_NAMES.iter().enumerate() {
            o.constant(name, code as u32);
        }
        // Patches are meshes here.
        for (kind, name) in KINDS.iter().filter(|(kind, _)| *kind != PrimKind::BicubicPatch) {
            o.constant(&format!("KIND_{}", name.to_uppercase()), *kind as u32);
        }
        material_constants().into_iter().for_each(|(name, v)| o.constant(&name, v));
        self.media_points = media_options(scene, &mut o)?;
        let irid = scene.settings.irid_wavelength;
        let numbers = [
            ("MIN_DEPTH", MIN_DEPTH as f32),
            ("SHADOW_TOLERANCE", SHADOW_TOLERANCE as f32),
            ("MIN_DEPTH_SHARE", MIN_DEPTH_SHARE),
            ("MAX_DISTANCE", MAX_DISTANCE as f32),
            ("SUN_DISTANCE", SUN_DISTANCE as f32),
            ("CAMERA_DEPTH", plan.camera.mesh.as_ref().map_or(f32::MAX, |m| m.max_depth().min(3e38) as f32)),
            ("BACKGROUND_DEPTH", crate::kernel::atmosphere::BACKGROUND_DEPTH as f32),
            ("SHARP_MIRROR", SHARP_MIRROR.0),
            ("SHARP_MIRROR_END", SHARP_MIRROR.1),
            ("IRID_RED", irid.x),
            ("IRID_GREEN", irid.y),
            ("IRID_BLUE", irid.z),
        ];
        numbers.iter().for_each(|(name, v)| o.constant(name, *v));
        Ok(o)
    }
}

/// Bit of a ray's state: it was reflected.
const RAY_REFLECTED: u32 = 1;
/// More interiors around a ray than fit.
pub(super) const FAULT_INTERIORS: u32 = 1;
/// A queue was too short: a fault of this program.
pub(super) const FAULT_QUEUE: u32 = 2;
const FOG_LEN: u32 = 20;
const RAINBOW_LEN: u32 = 17;
/// Codes of steps are their places here.
const STEP_NAMES: [&str; 9] = [
    "STEP_PRIM",
    "STEP_AND",
    "STEP_OR",
    "STEP_NOT",
    "STEP_REQUIRE",
    "STEP_REQUIRE_IN",
    "STEP_REQUIRE_OUT",
    "STEP_SKIP_OWN",
    "STEP_SKIP_OUTSIDE",
];

fn clip_step(s: &InsideStep) -> [u32; 4] {
    match *s {
        InsideStep::Prim(p) => [0, p, 0, 0],
        InsideStep::And => [1, 0, 0, 0],
        InsideStep::Or => [2, 0, 0, 0],
        InsideStep::Not => [3, 0, 0, 0],
        InsideStep::Require => [4, 0, 0, 0],
        InsideStep::RequireIn(p) => [5, p, 0, 0],
        InsideStep::RequireOut(p) => [6, p, 0, 0],
        InsideStep::SkipOwn { first, count, skip } => [7, first, count, skip],
        InsideStep::SkipOutside { box_ix, skip } => [8, box_ix, 0, skip],
        // A hint that the shaders leave out: nothing is skipped for hits on none of no primitives.
        InsideStep::FalseOutside { .. } => [7, 0, 0, 0],
    }
}

fn scene_params(scene: &CompiledScene) -> SceneParams {
    let (s, b) = (&scene.settings, &scene.background);
    SceneParams {
        adc_bailout: s.adc_bailout as f32,
        max_level: s.max_trace_level.clamp(1, 256),
        n_lights: scene.lights.len() as u32,
        background: b.rgb.to_array(),
        background_filter: b.filter,
        background_transmit: b.transmit,
        ambient_light: s.ambient_light.to_array(),
        generator: u32::from(s.noise_generator),
        ..SceneParams::default()
    }
}

fn encode_fogs(scene: &CompiledScene, words: &mut Vec<u32>) -> u32 {
    let fog = |f: &crate::scene::Fog| {
        let ground = f.ground.map_or([0.0; 2], |g| [g.0 as f32, g.1 as f32]);
        let mut w = Vec::from(bits(f.color.to_array()));
        w.extend([(f.distance as f32).to_bits(), u32::from(f.ground.is_some())]);
        w.extend(bits(ground));
        w.extend(bits3(f.up));
        w.push(u32::from(f.turbulence.is_some()));
        match &f.turbulence {
            Some((t, depth)) => {
                w.extend(bits3(t.amount));
                w.extend([t.octaves, t.omega.to_bits(), t.lambda.to_bits(), (*depth as f32).to_bits()]);
            }
            None => w.extend([0; 7]),
        }
        debug_assert_eq!(w.len() as u32, FOG_LEN, "as the shader reads it");
        w
    };
    let fogs: Vec<u32> = scene.fogs.iter().flat_map(fog).collect();
    append(words, std::iter::once(scene.fogs.len() as u32).chain(fogs))
}

/// The last declared first, as their jitter is drawn; their colours go to the texture words.
fn encode_rainbows(scene: &CompiledScene, words: &mut Vec<u32>, texture_words: &mut Vec<u32>) -> u32 {
    let bow = |b: &crate::scene::Rainbow| {
        let n = |v: f64| (v as f32).to_bits();
        let entry = |(at, c): &(f32, Rgbft)| {
            [at.to_bits(), c.rgb.x.to_bits(), c.rgb.y.to_bits(), c.rgb.z.to_bits(), c.filter.to_bits(), c.transmit.to_bits()]
        };
        let entries = &b.color_map.entries;
        let colors = append(texture_words, entries.iter().flat_map(entry));
        let right = b.up.cross(b.direction).try_normalize().unwrap_or(DVec3::X);
        let mut w = [bits3(b.direction), bits3(b.up), bits3(right)].concat();
        let half_arc = b.arc_rad.map_or(f64::from(f32::MAX), |a| 0.5 * a);
        w.extend([n(b.angle_rad - 0.5 * b.width_rad), n(b.width_rad), n(half_arc), n(0.5 * b.falloff_rad), n(b.distance), n(b.jitter)]);
        w.extend([colors, entries.len() as u32]);
        debug_assert_eq!(w.len() as u32, RAINBOW_LEN, "as the shader reads it");
        w
    };
    let seen: Vec<Vec<u32>> = scene.rainbows.iter().rev().filter(|b| b.distance != 0.0 && b.width_rad != 0.0).map(bow).collect();
    append(words, std::iter::once(seen.len() as u32).chain(seen.concat()))
}

fn encode_prims(scene: &CompiledScene, plan: &ScenePlan, textures: &TextureWords, meshes: &MeshWords, words: &mut Vec<u32>) -> Vec<Prim> {
    let g = &scene.geometry;
    let texture = |ix: u32| if ix == NONE { 0 } else { textures.textures[ix as usize] };
    let surfaces: Vec<u32> =
        g.surfaces.iter().map(|s| append(words, [texture(s.texture), texture(s.interior_texture), s.transform_ix])).collect();
    let list = |words: &mut Vec<u32>, lights: Vec<u32>| append(words, std::iter::once(lights.len() as u32).chain(lights));
    // By light group (the last is "none"), without and with the global lights.
    let groups: Vec<[u32; 2]> = (0..=plan.group_lights.len())
        .map(|k| {
            let own = plan.group_lights.get(k).cloned().unwrap_or_default();
            let all = plan.global_lights.iter().chain(&own).copied().collect();
            [list(words, own), list(words, all)]
        })
        .collect();
    let bounded: Vec<[u32; 2]> = g.objects.iter().map(|o| encode_object(scene, o, &texture, words)).collect();
    let mut out = Vec::with_capacity(g.prims.len());
    for (p, b) in g.prims.iter().zip(&g.bounds) {
        let (low, high) = outward(b);
        let group = (p.group_ix as usize).min(groups.len() - 1);
        let [bounded_by_at, cutaway_at] = bounded[p.object_ix as usize];
        let kind = if p.kind == PrimKind::BicubicPatch { PrimKind::Mesh } else { p.kind };
        out.push(Prim {
            kind: kind as u32,
            shape_at: encode_shape(scene, p, meshes, &textures.textures, words),
            transform_ix: p.transform_ix,
            surface_at: surfaces[p.surface_ix as usize],
            interior_ix: if p.interior_ix == NONE { 0 } else { p.interior_ix },
            object_ix: p.object_ix,
            clip_start: p.clip_start,
            clip_len: p.clip_len,
            flags: p.flags,
            lights_at: groups[group][usize::from(p.flags & prim_flags::NO_GLOBAL_LIGHTS == 0)],
            bounded_by_at: if p.flags & prim_flags::BOUNDED != 0 { bounded_by_at } else { 0 },
            cutaway_at,
            low,
            high,
            ..Prim::default()
        });
    }
    out
}

/// Bounding objects and cut parts of an object, as `bounded_by.wesl` and `covers.wesl` read them.
fn encode_object(
    scene: &CompiledScene,
    o: &crate::compile::geometry::ObjectRecord,
    texture: &impl Fn(u32) -> u32,
    words: &mut Vec<u32>,
) -> [u32; 2] {
    let g = &scene.geometry;
    let mut w = match &o.cull_box {
        Some(b) => {
            let (low, high) = outward(b);
            [vec![1], bits(low).to_vec(), bits(high).to_vec()].concat()
        }
        None => vec![0; 7],
    };
    w.push(o.bounded_by.len() as u32);
    for k in &g.bounding_objects[o.bounded_by.start as usize..o.bounded_by.end as usize] {
        let b = &g.objects[*k as usize];
        w.extend([b.prims.start, b.prims.len() as u32, b.inside.start, b.inside.len]);
    }
    let bounded_at = append(words, w);
    let parts = &g.cutaway_parts[o.cutaway.start as usize..o.cutaway.end as usize];
    let parts: Vec<u32> = parts
        .iter()
        .flat_map(|(program, surface)| {
            let s = &g.surfaces[*surface as usize];
            [program.start, program.len, texture(s.texture), s.transform_ix]
        })
        .collect();
    [bounded_at, append(words, std::iter::once(parts.len() as u32 / 4).chain(parts))]
}

fn transform(t: &crate::math::Transform) -> Transform {
    let (forward, inverse) = (rows_of(&t.forward), rows_of(&t.inverse));
    let near = |rows: [[f64; 4]; 3]| rows.map(|r| r.map(|v| v as f32));
    let low = |rows: [[f64; 4]; 3]| rows.map(|r| r.map(low_part));
    Transform { forward: near(forward), inverse: near(inverse), forward_low: low(forward), inverse_low: low(inverse) }
}

fn interior(i: &crate::compile::Interior) -> Interior {
    Interior {
        fade_color: i.fade_color.to_array(),
        fade_distance: i.fade_distance as f32,
        ior: i.ior as f32,
        ior_low: low_part(i.ior),
        fade_power: i.fade_power as f32,
        old_refraction: i.old_refraction as f32,
        caustics: i.caustics as f32,
        hollow: u32::from(i.hollow),
        ..Interior::default()
    }
}

fn finish(f: &crate::scene::Finish) -> Finish {
    let r = &f.reflection;
    Finish {
        ambient: f.ambient.to_array(),
        diffuse: f.diffuse,
        emission: f.emission.to_array(),
        diffuse_back: f.diffuse_back,
        reflection_min: r.min.to_array(),
        brilliance: f.brilliance,
        reflection_max: r.max.to_array(),
        phong: f.phong,
        phong_size: f.phong_size,
        specular: f.specular,
        roughness: f.roughness,
        metallic: f.metallic,
        reflection_fresnel: u32::from(r.fresnel),
        reflection_falloff: r.falloff,
        reflection_exponent: r.exponent,
        reflection_metallic: r.metallic,
        conserve_energy: u32::from(f.conserve_energy),
        irid_amount: f.irid[0],
        irid_thickness: f.irid[1],
        irid_turbulence: f.irid[2],
        crand: f.crand,
        ..Finish::default()
    }
}
