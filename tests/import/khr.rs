//! KHR_materials_*: what the Khronos definitions say and what the path integrator's closures then hold.

use crate::files::{Data, Folder, SQUARE, material, mesh, png};
use rayloom::backend::{Backend, cpu::CpuBackend};
use rayloom::compile::{CompileOptions, compile_scene};
use rayloom::film::Film;
use rayloom::integrate::{IntegratorKind, RenderSettings};
use rayloom::math::Vec3;
use rayloom::scene::input::{Channel, NormalInput, TangentInput};
use rayloom::scene::lamp::LampShape;
use rayloom::scene::shader::{Closure, MixFactor, PrincipledClosure};
use rayloom::scene::{Scene, Shader};

/// A square that wears a material of these members; three textures over sets 0, 1 and 2.
fn dressed(material: &str, root: &str) -> Vec<u8> {
    let mut d = Data::default();
    let (p, uv, i) = (d.floats("VEC3", 3, &SQUARE), d.floats("VEC2", 2, &SQUARE[..8]), d.indices(&[0, 1, 2, 0, 2, 3]));
    let picture = png(2, 1, |x, _| if x == 0 { [255, 128, 0, 255] } else { [51, 255, 255, 102] });
    let view = d.add(&picture, 5121, "SCALAR", picture.len(), "");
    let json = d.json(
        &format!(r#"{{"byteLength":{}}}"#, d.bytes.len()),
        &format!(
            r#","meshes":[{{"primitives":[{{"attributes":{{"POSITION":{p},"TEXCOORD_0":{uv},"TEXCOORD_1":{uv},"TEXCOORD_2":{uv}}},"indices":{i},"material":0}}]}}],
            "nodes":[{{"mesh":0}}],"images":[{{"bufferView":{view},"mimeType":"image/png"}}],"textures":[{{"source":0}}],
            "materials":[{{"name":"M"{material}}}]{root}"#
        ),
    );
    crate::files::glb(&json, &d.bytes)
}

fn shader_of(scene: &Scene) -> &Shader {
    material(scene, 0).shader.as_ref().expect("a shader")
}

fn closure(extensions: &str, more: &str) -> Closure {
    let s = Folder::new().with("a.glb", dressed(&format!(r#"{more},"extensions":{{{extensions}}}"#), "")).scene("a.glb");
    shader_of(&s).surface.clone().expect("a surface")
}

fn principled(extensions: &str, more: &str) -> PrincipledClosure {
    match closure(extensions, more) {
        Closure::Principled(p) => *p,
        other => panic!("{other:?}"),
    }
}

fn constant(s: &rayloom::scene::input::Scalar) -> f32 {
    s.as_constant().unwrap_or_else(|| panic!("{s:?} varies"))
}

#[test]
fn coats_and_sheens_arrive_with_their_textures() {
    let p = principled(
        r#""KHR_materials_clearcoat":{"clearcoatFactor":0.5,"clearcoatTexture":{"index":0},"clearcoatRoughnessFactor":0.25,
           "clearcoatNormalTexture":{"index":0,"texCoord":1,"scale":0.5}},
           "KHR_materials_sheen":{"sheenColorFactor":[0.1,0.2,0.3],"sheenRoughnessFactor":0.4,
           "sheenRoughnessTexture":{"index":0,"extensions":{"KHR_texture_transform":{"offset":[0.5,0],"scale":[2,1],"texCoord":2}}}}"#,
        "",
    );
    assert_eq!((p.coat_weight.factor, p.coat_weight.picture.as_ref().expect("a picture").1), (0.5, Channel::Red));
    assert_eq!((constant(&p.coat_roughness), constant(&p.coat_ior)), (0.25, 1.5));
    let Some(NormalInput::Map { picture, strength, scale_xy: true }) = p.coat_normal.as_deref() else { panic!("{:?}", p.coat_normal) };
    assert_eq!((picture.uv_set, constant(strength)), (1, 0.5));
    assert!(p.normal.is_none());
    assert_eq!((constant(&p.sheen_weight), p.sheen_tint.as_constant()), (1.0, Some(Vec3::new(0.1, 0.2, 0.3))));
    let (picture, channel) = p.sheen_roughness.picture.as_ref().expect("a picture");
    assert_eq!((*channel, picture.uv_set, picture.texture.srgb), (Channel::Alpha, 2, false));
    assert_eq!(picture.texture.uv_transform, [[2.0, 0.0, 0.5], [0.0, 1.0, 0.0]]);
}

#[test]
fn every_picture_keeps_its_own_coordinates() {
    let textures = r#","pbrMetallicRoughness":{"baseColorTexture":{"index":0,"texCoord":1},"metallicRoughnessTexture":{"index":0}},
        "emissiveFactor":[1,1,1],"emissiveTexture":{"index":0,"texCoord":2}"#;
    let s = Folder::new().with("a.glb", dressed(textures, "")).scene("a.glb");
    assert_eq!(mesh(&s, 0).more_uvs.len(), 2, "the sets after the first picture's");
    let Some(Closure::Principled(p)) = &shader_of(&s).surface else { panic!() };
    let set = |s: &rayloom::scene::input::Scalar| s.picture.as_ref().map(|p| p.0.uv_set);
    // Set 1 comes first, then 0, then 2.
    assert_eq!(p.base_color.picture.as_ref().map(|p| p.uv_set), Some(0));
    assert_eq!((set(&p.metallic), set(&p.roughness)), (Some(1), Some(1)));
    assert_eq!(p.emission_color.picture.as_ref().map(|p| p.uv_set), Some(2));
}

#[test]
fn anisotropy_has_khronos_widths_along_u() {
    for (rough, strength) in [(0.6f32, 0.5f32), (0.8, 1.0)] {
        let p = principled(
            &format!(r#""KHR_materials_anisotropy":{{"anisotropyStrength":{strength},"anisotropyRotation":1.5707963267948966}}"#),
            &format!(r#","pbrMetallicRoughness":{{"roughnessFactor":{rough}}}"#),
        );
        let width = constant(&p.roughness).powi(2);
        let aspect = (1.0 - 0.9 * constant(&p.anisotropic)).sqrt();
        let (across, along) = (rough * rough, rough * rough + (1.0 - rough * rough) * strength * strength);
        assert!((width / aspect - along).abs() < 1e-4 && (width * aspect - across).abs() < 1e-4, "{} {}", width / aspect, width * aspect);
        assert!((constant(&p.anisotropic_rotation) - 0.25).abs() < 1e-6);
        assert_eq!(p.tangent, TangentInput::Uv(0));
    }
    // A texture says the direction in red and green, the strength in blue: (1, 0.004) turns by nothing, full and no strength.
    let p = principled(r#""KHR_materials_anisotropy":{"anisotropyStrength":1,"anisotropyTexture":{"index":0}}"#, "");
    let (picture, _) = p.anisotropic_rotation.picture.as_ref().expect("a picture");
    let rayloom::scene::material::Texels::Rgba16(texels) = &picture.texture.image.texels else { panic!() };
    assert_eq!(texels[0][0], 0, "no blue, no stretch");
    assert!(texels[0][1] < 100, "to the right: {}", texels[0][1]);
    assert!(!picture.texture.linear);
}

#[test]
fn specular_weight_mixes_and_its_colour_leaves_metals_alone() {
    let Closure::Mix { factor: MixFactor::Scalar(f), a, b } = closure(
        r#""KHR_materials_specular":{"specularFactor":0.25,"specularColorFactor":[1,0.5,0]}"#,
        r#","pbrMetallicRoughness":{"metallicFactor":0}"#,
    ) else {
        panic!("a mix of with and without highlight");
    };
    assert_eq!(constant(&f), 0.25);
    let (Closure::Principled(a), Closure::Principled(b)) = (*a, *b) else { panic!() };
    assert_eq!((constant(&a.specular_ior_level), constant(&b.specular_ior_level)), (0.0, 0.5));
    assert_eq!(b.specular_tint.as_constant(), Some(Vec3::new(1.0, 0.5, 0.0)));
    let metal = principled(r#""KHR_materials_specular":{"specularColorFactor":[1,0.5,0]}"#, "");
    assert_eq!(metal.specular_tint.as_constant(), Some(Vec3::ONE));
    // Blender means its level.
    let bytes = dressed(r#","extensions":{"KHR_materials_specular":{"specularFactor":0.5}}"#, "");
    let json = String::from_utf8_lossy(&bytes).contains(r#"{"version":"2.0"}"#);
    assert!(json);
    let text = r#"{"asset":{"version":"2.0","generator":"Khronos glTF Blender I/O v4.5"},"meshes":[],"materials":[]}"#;
    assert!(Folder::new().with("b.gltf", text).load("b.gltf").0.is_ok());
}

#[test]
fn glass_is_a_pane_without_thickness_and_absorbs_with_it() {
    let glass = r#""KHR_materials_transmission":{"transmissionFactor":1}"#;
    assert!(principled(glass, "").thin_walled);
    let volume = r#","KHR_materials_volume":{"thicknessFactor":1,"attenuationDistance":2,"attenuationColor":[0.25,0.5,1]}"#;
    let s = Folder::new().with("a.glb", dressed(&format!(r#","extensions":{{{glass}{volume}}}"#), "")).scene("a.glb");
    let Some(Closure::Principled(p)) = &shader_of(&s).surface else { panic!() };
    assert!(!p.thin_walled);
    let absorption = shader_of(&s).volume.as_ref().expect("a volume").absorption;
    assert!((absorption - Vec3::new(4f32.ln(), 2f32.ln(), 0.0) / 2.0).length() < 1e-6, "{absorption}");
    let clear = principled(&format!("{glass}{}", r#","KHR_materials_volume":{"thicknessFactor":1}"#), "");
    assert!(!clear.thin_walled);
}

#[test]
fn films_are_as_thick_as_their_texture_and_weigh_what_they_say() {
    let film = |weight: f32| {
        closure(
            &format!(
                r#""KHR_materials_iridescence":{{"iridescenceFactor":{weight},"iridescenceIor":1.8,"iridescenceThicknessMinimum":200,
                "iridescenceThicknessMaximum":600,"iridescenceThicknessTexture":{{"index":0}}}}"#
            ),
            r#","pbrMetallicRoughness":{"metallicFactor":0}"#,
        )
    };
    let Closure::Principled(p) = film(1.0) else { panic!() };
    let t = &p.thin_film_thickness;
    assert_eq!((t.factor, t.offset, t.picture.as_ref().expect("a picture").1), (400.0, 200.0, Channel::Green));
    assert_eq!(constant(&p.thin_film_ior), 1.8);
    let Closure::Mix { factor: MixFactor::Scalar(f), a, .. } = film(0.5) else { panic!() };
    assert_eq!(constant(&f), 0.5);
    assert!(matches!(*a, Closure::Principled(p) if constant(&p.thin_film_thickness) == 0.0));
    let Closure::Principled(p) = film(0.0) else { panic!() };
    assert_eq!(constant(&p.thin_film_thickness), 0.0);
}

#[test]
fn what_is_left_out_is_told_and_what_is_broken_names_its_place() {
    let said = |extensions: &str, root: &str| {
        Folder::new().with("a.glb", dressed(&format!(r#","extensions":{{{extensions}}}"#), root)).load("a.glb").1
    };
    let told = |list: Vec<String>, what: &str| assert!(list.iter().any(|m| m.contains(what)), "{list:?}");
    told(said(r#""KHR_materials_dispersion":{"dispersion":0.1}"#, ""), "dispersion of glass");
    told(
        said("", r#","extensionsUsed":["KHR_materials_variants"],"extensions":{"KHR_materials_variants":{"variants":[{"name":"A"}]}}"#),
        "variants",
    );
    told(said(r#""KHR_materials_iridescence":{"iridescenceFactor":1}"#, ""), "no metal");
    for (extensions, what) in [
        (
            r#""KHR_materials_clearcoat":{"clearcoatFactor":"much"}"#,
            "material 'M': KHR_materials_clearcoat.clearcoatFactor: it must be a number",
        ),
        (r#""KHR_materials_clearcoat":{"clearcoatTexture":{"index":7}}"#, "names texture 7, but there are 1"),
        (r#""KHR_materials_sheen":{"sheenColorFactor":[1,2]}"#, "a list of 3 numbers"),
        (r#""KHR_materials_sheen":[]"#, "it must be an object"),
        (r#""KHR_materials_volume":{"thicknessFactor":-1}"#, "below 0"),
    ] {
        let f = Folder::new().with("a.glb", dressed(&format!(r#","extensions":{{{extensions}}}"#), ""));
        assert!(f.error("a.glb").contains(what), "{}", f.error("a.glb"));
    }
    for name in ["KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_texture_basisu", "EXT_texture_webp"] {
        let f = Folder::new().with("a.glb", dressed("", &format!(r#","extensionsRequired":["{name}"]"#)));
        assert!(f.error("a.glb").contains(name), "{}", f.error("a.glb"));
    }
}

#[test]
fn punctual_lamps_are_candela_and_lux_for_the_path_integrator_too() {
    let lights = r#","extensions":{"KHR_lights_punctual":{"lights":[{"type":"point","intensity":10},{"type":"directional","intensity":3},
        {"type":"spot","intensity":5,"spot":{"innerConeAngle":0,"outerConeAngle":0.5}}]}},
        "nodes":[{"extensions":{"KHR_lights_punctual":{"light":0}}},{"extensions":{"KHR_lights_punctual":{"light":1}}},
        {"rotation":[0.70710678,0,0,0.70710678],"extensions":{"KHR_lights_punctual":{"light":2}}}]"#;
    let s = Folder::new().with("a.glb", Data::default().glb(lights)).scene("a.glb");
    let lamps: Vec<_> = s.lights.iter().map(|l| l.lamp.as_deref().expect("a lamp")).collect();
    let pi = std::f32::consts::PI;
    assert!((lamps[0].power.x - 40.0 * pi).abs() < 1e-3 && (lamps[1].power.x - 3.0).abs() < 1e-6);
    assert_eq!(lamps[2].shape, LampShape::Spot { radius: 0.0, soft_falloff: false, angle_rad: 1.0, blend: 1.0 });
    // Turned by 90 degrees about x: -z becomes +y.
    let along = lamps[2].transform.vector(rayloom::math::DVec3::NEG_Z);
    assert!((along - rayloom::math::DVec3::Y).length() < 1e-6, "{along}");
}

/// Mean of the middle of a small picture of the path integrator.
fn seen(nodes: &str) -> f32 {
    let mut d = Data::default();
    let wide: Vec<f32> = SQUARE.iter().enumerate().map(|(k, v)| if k % 3 < 2 { 20.0 * (v - 0.5) } else { 0.0 }).collect();
    let (p, i) = (d.floats("VEC3", 3, &wide), d.indices(&[0, 1, 2, 0, 2, 3]));
    let dull = r#"{"pbrMetallicRoughness":{"metallicFactor":0,"baseColorFactor":[0.05,0.05,0.05,1]},"extensions":{"KHR_materials_specular":{"specularFactor":0}}}"#;
    let pane = r#"{"pbrMetallicRoughness":{"metallicFactor":0,"roughnessFactor":0,"baseColorFactor":[0.5,0.5,0.5,1]},
        "extensions":{"KHR_materials_transmission":{"transmissionFactor":1}}}"#;
    let mesh = |m: u32| format!(r#"{{"primitives":[{{"attributes":{{"POSITION":{p}}},"indices":{i},"material":{m}}}]}}"#);
    let rest = format!(
        r#","meshes":[{},{}],"materials":[{dull},{pane}],"extensions":{{"KHR_lights_punctual":{{"lights":[{{"type":"point","intensity":100}}]}}}},
        "cameras":[{{"type":"orthographic","orthographic":{{"xmag":0.1,"ymag":0.05,"znear":0.1,"zfar":100}}}}],
        "nodes":[{{"camera":0,"translation":[0,0,0.5]}},{{"mesh":0}},{{"translation":[0,0,2],"extensions":{{"KHR_lights_punctual":{{"light":0}}}}}}{nodes}]"#,
        mesh(0),
        mesh(1)
    );
    let scene = Folder::new().with("x.glb", d.glb(&rest)).scene("x.glb");
    let plain = RenderSettings::plain(8, 4);
    let settings = RenderSettings { integrator: IntegratorKind::Path, samples: 0..64, ..plain };
    let compiled = compile_scene(&scene, &CompileOptions::default()).expect("a small scene");
    let mut film = Film::new(8, 4);
    CpuBackend::new(1).render(&compiled, &settings, &mut film, &(), &Default::default()).expect("renders");
    film.pixels.iter().map(|p| p[1]).sum::<f32>() / film.pixels.len() as f32
}

#[test]
fn a_pane_lets_a_lamp_through_straight_and_dims_it_by_both_faces() {
    let (without, with) = (seen(""), seen(r#",{"mesh":1,"translation":[0,0,1]}"#));
    // Intensity over distance squared times albedo over pi.
    assert!((without - 100.0 / 4.0 * 0.05 / std::f32::consts::PI).abs() < 1e-3, "{without}");
    // 4 % at the first face, and all that goes to and fro between the two.
    let through = 0.5 * (1.0 - 2.0 * 0.04 / 1.04);
    assert!((with / without - through).abs() < 0.005, "{}, not {through}", with / without);
}
