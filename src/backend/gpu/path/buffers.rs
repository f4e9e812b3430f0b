//! A scene made ready for the path integrator on the GPU: numbers, words and the shader's text. Twin: `shaders/path/bindings.wesl`.

use super::super::buffers::{append, outward};
use super::super::layout::PathParams;
use super::super::shader::ShaderOptions;
use super::super::tree_words::choose_walk;
use super::camera::{camera_params, camera_words, panorama_constants};
use super::geometry::{FaceTables, OBJECT_INVERSE, OBJECT_TANGENTS, OBJECT_WORDS, encode_faces, face_bits, object_words};
use super::inputs::{Encoder, input_constants};
use super::lights::{encode_emitters, encode_lights, light_constants, tree_quads};
use super::materials::{Room, encode_materials, material_constants};
use super::tables::AlbedoTables;
use super::volumes::{Volumes, camera_bodies, most_bodies, volume_constants};
use crate::accel::AccelKind;
use crate::backend::BackendError;
use crate::compile::CompiledScene;
use crate::integrate::path::PathPlan;
use crate::integrate::path::lights::triangle;
use crate::kernel::bsdf::frame::Frame;
use crate::kernel::bsdf::{MAX_LOBES, sheen};
use crate::math::Bounds;
use crate::math::sobol::direction_table;
use crate::scene::Projection;
use std::collections::HashMap;

/// Rectangles seen smaller than that are drawn by area: the sum of their angles has few digits at 32 bits.
const LEAST_SOLID_ANGLE: f32 = triangle::LEAST_SOLID_ANGLE as f32;
const LOBES: [&str; 6] = ["LAMBERT", "OREN_NAYAR", "TRANSLUCENT", "MICROFACET", "SHEEN", "HAIR"];
const FRESNELS: [&str; 6] = ["MIRROR", "CLEAR", "DIELECTRIC", "F82", "FILM", "CONDUCTOR"];

/// Everything of a scene, encoded.
pub(super) struct PathBuffers {
    pub params: PathParams,
    pub faces: FaceTables,
    pub words: Vec<u32>,
    pub quads: Vec<[u32; 4]>,
    pub texels: Vec<u32>,
    pub options: ShaderOptions,
}

impl PathBuffers {
    /// Encodes `scene` for a picture of the plan's size, with a structure of kind `kind`.
    pub fn new(scene: &CompiledScene, plan: &PathPlan, kind: AccelKind, size: [u32; 2]) -> Result<Self, BackendError> {
        let mut e = Encoder::default();
        let mut tables = AlbedoTables::default();
        let mut room = Room::default();
        let mut p = camera_params(scene, plan, size);
        camera_words(scene, &mut e, &mut p);
        let mut volumes = Volumes::default();
        let materials = encode_materials(&plan.shaders, &mut e, &mut tables, &mut room, &mut volumes)?;
        p.materials_at = materials.at;
        p.mirror_at = tables.fill(&mut e.words);
        encode_lights(plan, &mut e, &mut p);
        p.filter_at = append(&mut e.words, plan.filter.offsets().iter().map(|v| v.to_bits()));
        let mut objects = HashMap::new();
        if plan.has_volumes || ["anisotropic", "subsurface"].iter().any(|f| e.features.contains(f)) {
            for k in 0..scene.geometry.prims.len() as u32 {
                objects.insert(k, append(&mut e.words, object_words(scene, k)));
            }
        }
        if plan.has_volumes {
            e.features.insert("volumes");
            p.volumes_at = camera_bodies(scene, plan, &objects, &materials.volumes, &mut volumes, &mut e);
        }
        let faces = encode_faces(scene, plan, kind, &materials.clear, &objects, e.more_uvs)?;
        p.emitters_at = encode_emitters(&plan.lights.emitters.list, &faces.emitters, &mut e);
        p.n_faces = faces.faces.len() as u32;
        p.hair_at = faces.hair_at;
        // A grid's lists have no references before them: leaves name faces.
        p.lists_at = 0;
        (p.tree_low, p.tree_high) = outward(&Bounds { min: faces.low.as_dvec3(), max: faces.high.as_dvec3() });
        p.extent = faces.low.abs().max(faces.high.abs()).max_element();
        let mut quads: Vec<[u32; 4]> = direction_table().as_flattened().to_vec();
        let sheen_at = quads.len() as u32;
        if e.features.contains("sheen") {
            quads.extend(sheen::table().iter().map(|v| [v.x.to_bits(), v.y.to_bits(), v.z.to_bits(), 0]));
        }
        let places = [sheen_at, quads.len() as u32];
        quads.extend(tree_quads(&plan.lights.tree));
        let options = shader_options(scene, plan, kind, &e, room, &faces, places);
        Ok(Self { params: p, faces, words: e.words, quads, texels: e.texels, options })
    }
}

fn shader_options(
    scene: &CompiledScene,
    plan: &PathPlan,
    kind: AccelKind,
    e: &Encoder,
    room: Room,
    faces: &FaceTables,
    places: [u32; 2],
) -> ShaderOptions {
    let mut o = ShaderOptions::default();
    let s = &plan.settings;
    e.features.iter().for_each(|f| o.feature(f));
    let seen_by_all = (face_bits::UNSEEN * 15) | face_bits::NO_SHADOW;
    let has_clear = faces.bits & face_bits::CLEAR != 0;
    let features = [
        ("lens", plan.camera.lens().is_some()),
        ("orthographic", matches!(scene.camera.projection, Projection::Orthographic)),
        ("open_shutter", plan.has_motion),
        ("still", s.still),
        ("motion", faces.has_motion),
        ("hair", faces.bits & face_bits::HAIR != 0),
        ("holes", faces.bits & face_bits::HOLDOUT != 0),
        ("smooth_faces", faces.bits & face_bits::SMOOTH != 0),
        ("face_flags", faces.bits & seen_by_all != 0 || has_clear),
        ("clear_faces", has_clear),
        ("film_alpha", plan.output_alpha),
        ("film_transparent", s.film_transparent),
        ("clamps", s.clamp_direct > 0.0 || s.clamp_indirect > 0.0),
        ("filter_glossy", s.filter_glossy > 0.0),
        ("caustics_reflective", s.caustics_reflective),
        ("caustics_refractive", s.caustics_refractive),
        ("mesh", true),
        ("path_rays", true),
    ];
    features.iter().for_each(|(name, holds)| o.feature_if(name, *holds));
    name_constants(&mut o, room, places);
    o.constant("UV_SETS", 1 + e.more_uvs);
    o.constant("MAX_BODIES", most_bodies(scene));
    choose_walk(&mut o, kind, 1, faces.tree.depth);
    o
}

/// Names of numbers that both languages share; places among the quads of the sheen's table and of the light tree's nodes.
fn name_constants(o: &mut ShaderOptions, room: Room, [sheen_at, nodes_at]: [u32; 2]) {
    let constants = [
        ("WORKGROUP", super::super::device::WORKGROUP),
        ("MAX_LOBES", room.lobes.clamp(1, MAX_LOBES as u32)),
        ("CLOSURE_STACK", room.stack.max(1)),
        ("MAX_CLOSURES", room.closures.max(1)),
        ("SHEEN_AT", sheen_at),
        ("NODES_AT", nodes_at),
        ("SEES_ALL", 255),
        ("FACE_MATERIAL", face_bits::MATERIAL),
        ("FACE_SMOOTH", face_bits::SMOOTH),
        ("FACE_UV", face_bits::UV),
        ("FACE_COLORS", face_bits::COLORS),
        ("FACE_FRONT_ONLY", face_bits::FRONT_ONLY),
        ("FACE_UNSEEN", face_bits::UNSEEN),
        ("FACE_NO_SHADOW", face_bits::NO_SHADOW),
        ("FACE_CLEAR", face_bits::CLEAR),
        ("FACE_HOLDOUT", face_bits::HOLDOUT),
        ("FACE_HAIR", face_bits::HAIR),
        ("OBJECT_INVERSE", OBJECT_INVERSE),
        ("OBJECT_TANGENTS", OBJECT_TANGENTS),
        ("OBJECT_WORDS", OBJECT_WORDS),
    ];
    constants.iter().for_each(|(name, v)| o.constant(name, *v));
    o.constant("LEAST_SOLID_ANGLE", LEAST_SOLID_ANGLE);
    o.constant("FRAME_TURNS_AT", Frame::TURNS_AT);
    o.constant("MOST_SOLID_ANGLE", triangle::MOST_SOLID_ANGLE as f32);
    for (prefix, names) in [("LOBE", &LOBES[..]), ("FRESNEL", &FRESNELS[..])] {
        (0u32..).zip(names).for_each(|(k, n)| o.constant(&format!("{prefix}_{n}"), k));
    }
    for (name, v) in input_constants()
        .into_iter()
        .chain(material_constants())
        .chain(light_constants())
        .chain(panorama_constants())
        .chain(volume_constants())
    {
        o.constant(&name, v);
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::shader::assemble;
    use super::*;

    /// The shader with these features is WGSL that validates.
    fn validates(features: &[&str]) -> Result<(), String> {
        let mut o = ShaderOptions::default();
        name_constants(&mut o, Room { lobes: 3, stack: 2, closures: 3 }, [1024, 2048]);
        o.constant("UV_SETS", 2u32);
        o.constant("MAX_BODIES", 3u32);
        choose_walk(&mut o, AccelKind::Bvh, 1, 20);
        ["mesh", "path_rays"].iter().chain(features).for_each(|f| o.feature(f));
        let text = assemble("path/trace_paths", &o).map_err(|e| e.to_string())?;
        let module = naga::front::wgsl::parse_str(&text).map_err(|e| e.emit_to_string(&text))?;
        let mut validator = naga::valid::Validator::new(naga::valid::ValidationFlags::all(), naga::valid::Capabilities::default());
        validator.validate(&module).map(|_| ()).map_err(|e| format!("{e:?}"))
    }

    #[test]
    fn every_feature_makes_a_shader_that_validates() {
        // A feature with those that it comes with.
        let sets: &[&[&str]] = &[
            &[],
            &["lens"],
            &["halves"],
            &["orthographic"],
            &["smooth_faces"],
            &["face_flags"],
            &["face_flags", "clear_faces", "passes", "any_light", "light_tree", "emitters"],
            &["film_alpha", "film_transparent", "environment"],
            &["clamps", "filter_glossy", "caustics_reflective", "caustics_refractive"],
            &["any_light", "light_tree", "emitters", "plain_emission"],
            &["any_light", "light_tree", "emitters", "plain_emission", "rectangles", "volumes"],
            &["any_light", "light_tree", "emitters", "varying_emission", "plain_emission", "texels", "uv"],
            &["any_light", "light_tree", "tree_lamps", "lamps", "areas", "met_lamps", "shadowless", "light_visibility"],
            &["any_light", "light_tree", "tree_lamps", "lamps", "balls", "met_lamps", "smooth_faces"],
            &["any_light", "lamps", "balls", "suns", "many_kinds", "met_lamps"],
            &["any_light", "env_sampled", "environment", "env_picture", "many_kinds", "light_tree", "emitters"],
            &["any_light", "env_sampled", "environment", "env_picture", "mirror_ball"],
            &["any_light", "env_sampled", "environment", "sky", "sky_sun", "many_kinds"],
            &["any_light", "env_sampled", "environment", "sky", "sky_below", "sky_sun", "many_kinds"],
            &["texels", "uv", "corner_colors", "bent", "bumps"],
            &["panorama"],
            &["open_shutter", "camera_motion", "lens"],
            &["open_shutter", "still", "motion", "smooth_faces", "face_flags", "any_light", "light_tree", "emitters", "plain_emission"],
            &["open_shutter", "motion", "texels", "uv", "bent", "uv_tangents", "anisotropic", "microfacets", "metal", "principled"],
            &["holes"],
            &["volumes"],
            &["volumes", "grids", "any_light", "light_tree", "emitters", "plain_emission", "face_flags", "clear_faces", "passes"],
            &["volumes", "any_light", "light_tree", "tree_lamps", "lamps", "balls", "met_lamps", "suns", "many_kinds", "shadowless"],
            &["subsurface", "plain_subsurface"],
            &[
                "principled",
                "principled_subsurface",
                "subsurface",
                "passes",
                "any_light",
                "lamps",
                "balls",
                "light_tree",
                "tree_lamps",
                "met_lamps",
            ],
            &["subsurface", "plain_subsurface", "volumes", "face_flags", "clear_faces", "passes", "holes", "any_light", "env_sampled"],
            &["hair"],
            &["hair", "filter_glossy", "any_light", "lamps", "balls", "light_visibility", "motion", "open_shutter"],
            &["principled", "microfacets", "panes", "passes", "coat", "face_flags", "clear_faces", "any_light", "lamps", "balls"],
            &["texels", "uv", "more_uvs", "bent"],
            &["texels", "uv", "bent", "uv_tangents", "anisotropic", "microfacets", "metal", "principled"],
            &["principled"],
            &["principled", "sheen"],
            &["principled", "microfacets", "specular"],
            &["principled", "microfacets", "metal", "anisotropic"],
            &["microfacets", "conductor"],
            &["microfacets", "conductor", "anisotropic", "filter_glossy"],
            &["principled", "microfacets", "coat", "sheen", "oren_nayar", "principled_emission", "passes"],
            &["principled", "microfacets", "specular", "principled_glass", "refraction", "thin_film"],
            &[
                "mixes",
                "microfacets",
                "plain_glossy",
                "plain_glass",
                "plain_refraction",
                "refraction",
                "translucent",
                "sheen",
                "plain_sheen",
            ],
        ];
        for set in sets {
            validates(set).unwrap_or_else(|e| panic!("{set:?}: {e}"));
        }
        let mut all: Vec<&str> = sets.concat();
        all.retain(|f| !["orthographic", "panorama", "sky", "sky_below", "mirror_ball"].contains(f));
        validates(&all).expect("all at once");
        // What cannot be: closures that call what is not there.
        assert!(validates(&["plain_glass"]).is_err());
    }
}
