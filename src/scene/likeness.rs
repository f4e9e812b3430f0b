//! A glTF-like material as Blender's Principled closure: what the path integrator simulates where the front end says no more.

use super::Principled;
use super::input::{Channel, Color, NormalInput, Picture, Scalar};
use super::material::{AlphaMode, MaterialTexture};
use super::shader::PrincipledClosure;
use crate::math::Vec3;

fn picture(t: &MaterialTexture) -> Picture {
    Picture { texture: t.clone(), uv_set: 0, filter_encoded: false, premultiplied: false }
}

fn scalar(factor: f32, t: &Option<MaterialTexture>, channel: Channel) -> Scalar {
    Scalar { factor, offset: 0.0, picture: t.as_ref().map(|t| (picture(t), channel)) }
}

/// glTF's metallic-roughness material as Blender's importer maps it. Source: glTF 2.0, appendix B; KHR extensions.
pub fn closure_of(p: &Principled) -> PrincipledClosure {
    // Masks need a threshold, which is no input: they are blended, which shows at soft edges alone.
    let alpha = match (p.alpha_mode, &p.alpha_texture) {
        (AlphaMode::Opaque, _) => Scalar::constant(1.0),
        (_, Some(t)) => scalar(p.alpha, &Some(t.clone()), Channel::Alpha),
        _ => scalar(p.alpha, &p.base_color_texture, Channel::Alpha),
    };
    let f0 = ((p.ior - 1.0) / (p.ior + 1.0)).powi(2);
    let color = |factor, t: &Option<MaterialTexture>, vertex_color| Color { factor, picture: t.as_ref().map(picture), vertex_color };
    PrincipledClosure {
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
    }
}
