//! A scene as `benches/peers/mitsuba_timed.py` and `luxcore_timed.py` read it: a JSON text and raw faces, for other programs to render the same
//! picture.
//!
//! Meshes, Lambert, GGX metal, glass, Principled (Mitsuba's own, which is another closure: where it shows, the means differ and
//! `error-time` says so; LuxCore refuses it), shining surfaces, area and point lamps, constant environments. Everything else is an error, with its name.

use crate::math::{Bounds, DVec3, Rgb, Transform};
use crate::scene::camera::Projection;
use crate::scene::lamp::LampShape;
use crate::scene::shader::{Closure, PrincipledClosure};
use crate::scene::{Mesh, Object, Principled, Scene, Shape, Texture};
use serde_json::{Value, json};
use std::path::Path;

/// Writes `scene` to `folder`.
///
/// # Errors
/// What of the scene cannot be said, or the file that cannot be written.
pub fn export(scene: &Scene, folder: &Path) -> Result<(), String> {
    let mut shapes = Vec::new();
    for (k, o) in scene.objects.iter().enumerate() {
        shapes.extend(object(o, k, folder).map_err(|what| format!("object {k}: {what}"))?);
    }
    let mut emitters = Vec::new();
    for (k, l) in scene.lights.iter().enumerate() {
        let lamp = l.lamp.as_ref().ok_or_else(|| format!("light {k} is not one of Cycles'"))?;
        match lamp.shape {
            LampShape::Area { size, spread_rad, ellipse: false } if spread_rad >= std::f64::consts::PI - 1e-6 => {
                let radiance = lamp.power / (std::f32::consts::PI * (size[0] * size[1]) as f32);
                emitters.push(json!({"kind": "area", "size": size, "to_world": matrix(&lamp.transform), "radiance": rgb(radiance)}));
            }
            LampShape::Point { radius: 0.0, .. } => {
                let position = lamp.transform.point(DVec3::ZERO).to_array();
                emitters.push(json!({"kind": "point", "position": position, "intensity": rgb(lamp.power / (4.0 * std::f32::consts::PI))}));
            }
            _ => return Err(format!("light {k}: {:?}", lamp.shape)),
        }
    }
    let sky = match &scene.environment {
        None => scene.background.rgb,
        Some(e) => match e.source {
            crate::scene::environment::EnvironmentSource::Constant => e.strength,
            _ => return Err("an environment that is not constant".into()),
        },
    };
    let text = json!({"camera": camera(scene)?, "max_depth": max_depth(scene), "sky": rgb(sky), "shapes": shapes, "emitters": emitters});
    std::fs::write(folder.join("scene.json"), text.to_string()).map_err(|e| format!("cannot write to '{}': {e}", folder.display()))
}

fn rgb(c: Rgb) -> [f32; 3] {
    c.to_array()
}

/// Rows.
fn matrix(t: &Transform) -> [[f64; 4]; 3] {
    let [x, y, z, o] = [t.vector(DVec3::X), t.vector(DVec3::Y), t.vector(DVec3::Z), t.point(DVec3::ZERO)];
    std::array::from_fn(|k| [x[k], y[k], z[k], o[k]])
}

fn camera(scene: &Scene) -> Result<Value, String> {
    let c = &scene.camera;
    if !matches!(c.projection, Projection::Perspective) || c.lens.is_some() || c.blur.is_some() || !c.motion.is_empty() {
        return Err("a camera that is not a plain perspective one".into());
    }
    if c.direction.cross(c.up).dot(c.right) < 0.0 {
        return Err("a camera that mirrors".into());
    }
    let fov = 2.0 * (0.5 * c.right.length() / c.direction.length()).atan().to_degrees();
    Ok(json!({"origin": c.location.to_array(), "target": (c.location + c.direction).to_array(), "up": c.up.to_array(), "fov_x": fov}))
}

/// Surfaces on the way, lamp and camera. Where all is Lambert its own limit is the one that counts.
fn max_depth(scene: &Scene) -> u32 {
    let s = &scene.settings.path;
    let lambert = |o: &Object| {
        let Some(Texture::Principled(p)) = o.texture.as_deref() else { return false };
        bsdf(p).is_ok_and(|b| b["type"] == "diffuse")
    };
    2 + if scene.objects.iter().all(lambert) { s.diffuse_bounces.min(s.max_bounces) } else { s.max_bounces }
}

/// The shapes of an object: one, or two where it shines. Ours shines on both sides, that of the others on its front: a second mesh, a little
/// apart, is the back.
fn object(o: &Object, number: usize, folder: &Path) -> Result<Vec<Value>, String> {
    if !o.clipped_by.is_empty() || !o.bounded_by.is_empty() {
        return Err("it is clipped".into());
    }
    let Some(Texture::Principled(p)) = o.texture.as_deref() else { return Err("its texture is the scene language's".into()) };
    let (material, radiance) = (bsdf(p)?, radiance(p)?);
    let Shape::Mesh(mesh) = &o.shape else {
        return Err(format!("a shape that is no mesh ({})", format!("{:?}", o.shape).split([' ', '(', '{']).next().unwrap_or("")));
    };
    let sides = if radiance.max_element() > 0.0 { &[Side::Front, Side::Back][..] } else { &[Side::Both] };
    let shape = |side: &Side| {
        let name = format!("mesh{number}{}.bin", if *side == Side::Back { "b" } else { "" });
        let smooth = write_mesh(mesh, &o.transform, *side, &folder.join(&name))?;
        Ok(json!({"file": name, "smooth": smooth, "bsdf": material, "radiance": rgb(radiance)}))
    };
    sides.iter().map(shape).collect()
}

/// What of a mesh is written.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Side {
    /// As it is.
    Both,
    /// Moved along its normals.
    Front,
    /// Moved against them, and turned.
    Back,
}

/// How far the sides of a shining mesh are moved, as a share of its size.
const APART: f64 = 1e-5;

/// Corners face by face in world space, then their normals, as 32-bit floats; whether there are normals.
fn write_mesh(mesh: &Mesh, t: &Transform, side: Side, path: &Path) -> Result<bool, String> {
    if !mesh.face_textures.is_empty() || !mesh.motion.is_empty() {
        return Err("a mesh of several materials, or one that moves".into());
    }
    let smooth = side == Side::Both && !mesh.normal_indices.is_empty() && mesh.normal_indices.iter().all(|n| n[0] != u32::MAX);
    let place = |v: u32| t.point(mesh.vertices[v as usize].as_dvec3());
    let apart = APART * Bounds::from_points(mesh.faces.iter().flatten().map(|v| place(*v))).size().length();
    let mut bytes = Vec::with_capacity(mesh.faces.len() * if smooth { 72 } else { 36 });
    for face in &mesh.faces {
        let mut corners = face.map(place);
        let out = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize_or_zero() * apart;
        match side {
            Side::Both => {}
            Side::Front => corners = corners.map(|c| c + out),
            Side::Back => {
                corners = corners.map(|c| c - out);
                corners.swap(1, 2);
            }
        }
        bytes.extend(corners.iter().flat_map(|c| c.as_vec3().to_array()).flat_map(f32::to_le_bytes));
    }
    if smooth {
        for n in mesh.normal_indices.iter().flatten() {
            let n = t.normal(mesh.normals[*n as usize].as_dvec3()).normalize_or_zero().as_vec3();
            bytes.extend(n.to_array().iter().flat_map(|v| v.to_le_bytes()));
        }
    }
    std::fs::write(path, bytes).map_err(|e| format!("cannot write '{}': {e}", path.display()))?;
    Ok(smooth)
}

/// The others' closure of a material.
fn bsdf(p: &Principled) -> Result<Value, String> {
    let pictures = || Err("a material with pictures".to_owned());
    let Some(shader) = &p.shader else {
        if p.base_color_texture.is_some() || p.metallic_roughness_texture.is_some() || p.normal_texture.is_some() {
            return pictures();
        }
        return Ok(principled(p.base_color, p.metallic, p.roughness, p.ior, p.specular, p.transmission));
    };
    match &shader.surface {
        None => Ok(json!({"type": "diffuse", "color": [0.0, 0.0, 0.0]})),
        Some(Closure::Emission { .. }) => Ok(json!({"type": "diffuse", "color": [0.0, 0.0, 0.0]})),
        Some(Closure::Diffuse { color, roughness, normal: None }) if roughness.as_constant() == Some(0.0) => {
            color.as_constant().map_or_else(pictures, |c| Ok(json!({"type": "diffuse", "color": rgb(c)})))
        }
        Some(Closure::Glossy { color, roughness, anisotropy, normal: None, .. }) if anisotropy.as_constant() == Some(0.0) => {
            match (color.as_constant(), roughness.as_constant()) {
                (Some(c), Some(r)) => Ok(json!({"type": "metal", "color": rgb(c), "alpha": r * r})),
                _ => pictures(),
            }
        }
        Some(Closure::Glass { color, roughness, ior, film_thickness, normal: None, .. }) if film_thickness.as_constant() == Some(0.0) => {
            match (color.as_constant(), roughness.as_constant(), ior.as_constant()) {
                (Some(c), Some(r), Some(ior)) => Ok(json!({"type": "glass", "color": rgb(c), "alpha": r * r, "ior": ior})),
                _ => pictures(),
            }
        }
        Some(Closure::Principled(c)) => from_principled(c),
        Some(_) => Err("a material that the others have no closure for".into()),
    }
}

fn from_principled(c: &PrincipledClosure) -> Result<Value, String> {
    let zero = |s: &crate::scene::input::Scalar| s.as_constant() == Some(0.0);
    if !(zero(&c.subsurface_weight) && zero(&c.coat_weight) && zero(&c.sheen_weight) && zero(&c.anisotropic) && zero(&c.diffuse_roughness))
    {
        return Err("a Principled material with coat, sheen, subsurface or stretched lobes".into());
    }
    let numbers = [&c.metallic, &c.roughness, &c.ior, &c.specular_ior_level, &c.transmission_weight].map(|s| s.as_constant());
    match (c.base_color.as_constant(), numbers, &c.normal) {
        (Some(base), [Some(metallic), Some(roughness), Some(ior), Some(level), Some(transmission)], None) => {
            Ok(principled(base, metallic, roughness, ior, 2.0 * level, transmission))
        }
        _ => Err("a material with pictures".into()),
    }
}

/// `specular` scales the reflection at right angles.
fn principled(base: Rgb, metallic: f32, roughness: f32, ior: f32, specular: f32, transmission: f32) -> Value {
    if metallic == 0.0 && transmission == 0.0 && specular == 0.0 {
        return json!({"type": "diffuse", "color": rgb(base)});
    }
    let f0 = specular * ((ior - 1.0) / (ior + 1.0)).powi(2);
    json!({"type": "principled", "color": rgb(base), "metallic": metallic, "roughness": roughness, "f0": f0, "transmission": transmission})
}

/// What a material shines with, from both sides.
fn radiance(p: &Principled) -> Result<Rgb, String> {
    let constant =
        |color: &crate::scene::input::Color, strength: &crate::scene::input::Scalar| match (color.as_constant(), strength.as_constant()) {
            (Some(c), Some(s)) => Ok(c * s),
            (_, Some(0.0)) => Ok(Rgb::ZERO),
            _ => Err("a shining material with pictures".to_owned()),
        };
    match p.shader.as_ref().map(|s| &s.surface) {
        None if p.emission_texture.is_some() => Err("a shining material with pictures".into()),
        None => Ok(p.emission),
        Some(Some(Closure::Emission { color, strength })) => constant(color, strength),
        Some(Some(Closure::Principled(c))) => constant(&c.emission_color, &c.emission_strength),
        Some(_) => Ok(Rgb::ZERO),
    }
}
