//! Shaders of materials: those that a front end gave, and those made from glTF's likeness.

use crate::math::Vec3;
use crate::scene::Principled;
use crate::scene::Shader;
use crate::scene::input::{Channel, Color, NormalInput, Picture, Scalar};
use crate::scene::material::{AlphaMode, MaterialTexture};
use crate::scene::shader::{Closure, PrincipledClosure};
use std::sync::Arc;

/// The shader of a material.
pub fn shader_of(p: &Principled) -> Arc<Shader> {
    p.shader.clone().unwrap_or_else(|| Arc::new(from_likeness(p)))
}

fn picture(t: &MaterialTexture) -> Picture {
    Picture { texture: t.clone(), uv_set: 0, filter_encoded: false, premultiplied: false }
}

fn scalar(factor: f32, t: &Option<MaterialTexture>, channel: Channel) -> Scalar {
    Scalar { factor, offset: 0.0, picture: t.as_ref().map(|t| (picture(t), channel)) }
}

/// glTF's metallic-roughness material as Blender's importer maps it. Source: glTF 2.0, appendix B; KHR extensions.
fn from_likeness(p: &Principled) -> Shader {
    // Masks need a threshold, which is no input: they are blended, which shows at soft edges alone.
    let alpha = match (p.alpha_mode, &p.alpha_texture) {
        (AlphaMode::Opaque, _) => Scalar::constant(1.0),
        (_, Some(t)) => scalar(p.alpha, &Some(t.clone()), Channel::Alpha),
        _ => scalar(p.alpha, &p.base_color_texture, Channel::Alpha),
    };
    let f0 = ((p.ior - 1.0) / (p.ior + 1.0)).powi(2);
    let color = |factor, t: &Option<MaterialTexture>, vertex_color| Color { factor, picture: t.as_ref().map(picture), vertex_color };
    let closure = PrincipledClosure {
        base_color: color(p.base_color, &p.base_color_texture, true),
        metallic: scalar(p.metallic, &p.metallic_roughness_texture, Channel::Blue),
        roughness: scalar(p.roughness, &p.metallic_roughness_texture, Channel::Green),
        ior: p.ior.into(),
        alpha,
        normal: p
            .normal_texture
            .as_ref()
            .map(|t| Box::new(NormalInput::Map { picture: picture(t), strength: p.normal_scale.into(), scale_xy: true })),
        specular_ior_level: (0.5 * p.specular).into(),
        specular_tint: Color::constant(if f0 > 0.0 { p.specular_color } else { Vec3::ONE }),
        transmission_weight: scalar(p.transmission, &p.transmission_texture, Channel::Red),
        emission_color: color(p.emission, &p.emission_texture, false),
        emission_strength: 1.0.into(),
        ..PrincipledClosure::default()
    };
    Shader { surface: Some(Closure::Principled(Box::new(closure))), transparent_shadow: true, ..Shader::default() }
}
