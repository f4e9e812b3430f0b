//! A shader → the nearest glTF-like material, for the classic integrator and the GPU.

use crate::math::Vec3;
use crate::scene::input::{Channel, Color, NormalInput, Scalar};
use crate::scene::material::{AlphaMode, MaterialTexture};
use crate::scene::shader::{Closure, MixFactor, PrincipledClosure, RaySort};
use crate::scene::{Principled, Shader};

/// The likeness of a whole material.
pub(super) fn likeness(shader: &Shader) -> Principled {
    match &shader.surface {
        Some(closure) => of_closure(closure),
        // The hull of a volume.
        None => Principled { alpha: 0.0, alpha_mode: AlphaMode::Blend, ..Principled::default() },
    }
}

fn number(s: &Scalar) -> f32 {
    s.as_constant().unwrap_or(s.factor * 0.5 + s.offset)
}

fn texture(c: &Color) -> Option<MaterialTexture> {
    c.picture.as_ref().map(|p| p.texture.clone())
}

fn matte(color: &Color) -> Principled {
    Principled { base_color: color.factor, base_color_texture: texture(color), specular: 0.0, ..Principled::default() }
}

fn of_closure(closure: &Closure) -> Principled {
    match closure {
        Closure::Principled(p) => of_principled(p),
        Closure::Diffuse { color, .. } | Closure::Translucent { color, .. } | Closure::Subsurface { color, .. } => matte(color),
        Closure::Sheen { color, .. } => matte(color),
        Closure::Transparent { .. } | Closure::Holdout => Principled { alpha: 0.0, alpha_mode: AlphaMode::Blend, ..Principled::default() },
        Closure::Glossy { color, roughness, .. } => Principled { metallic: 1.0, roughness: number(roughness), ..matte(color) },
        Closure::Conductor(c) => {
            let (n, k) = (c.ior.factor, c.extinction.factor);
            let base = ((n - 1.0) * (n - 1.0) + k * k) / ((n + 1.0) * (n + 1.0) + k * k);
            Principled { base_color: base, metallic: 1.0, roughness: number(&c.roughness), ..Principled::default() }
        }
        Closure::Glass { color, roughness, ior, .. } | Closure::Refraction { color, roughness, ior, .. } => {
            Principled { transmission: 1.0, roughness: number(roughness), ior: number(ior).max(1.0), specular: 1.0, ..matte(color) }
        }
        Closure::Emission { color, strength } => Principled {
            base_color: Vec3::ZERO,
            specular: 0.0,
            emission: color.factor * number(strength),
            emission_texture: texture(color),
            ..Principled::default()
        },
        Closure::Hair(_) => Principled { base_color: Vec3::new(0.1, 0.06, 0.04), roughness: 0.4, ..Principled::default() },
        Closure::Mix { factor, a, b } => {
            let second = match factor {
                MixFactor::Scalar(s) => number(s) > 0.5,
                MixFactor::ByRay(values) => values[RaySort::Camera as usize] > 0.5,
                _ => false,
            };
            of_closure(if second { b } else { a })
        }
        Closure::Add(a, b) => {
            let (a, b) = (of_closure(a), of_closure(b));
            let emission = a.emission + b.emission;
            let shown = if a.base_color == Vec3::ZERO { b } else { a };
            Principled { emission, ..shown }
        }
    }
}

fn of_principled(p: &PrincipledClosure) -> Principled {
    let alpha = p.alpha.as_constant();
    let mut out = Principled {
        base_color: p.base_color.factor,
        base_color_texture: texture(&p.base_color),
        metallic: number(&p.metallic),
        roughness: number(&p.roughness),
        ior: number(&p.ior).max(1.0),
        specular: (2.0 * number(&p.specular_ior_level)).min(1.0),
        specular_color: p.specular_tint.factor,
        transmission: number(&p.transmission_weight),
        emission: p.emission_color.factor * number(&p.emission_strength),
        emission_texture: texture(&p.emission_color),
        alpha: alpha.unwrap_or(1.0),
        alpha_mode: if alpha == Some(1.0) { AlphaMode::Opaque } else { AlphaMode::Blend },
        ..Principled::default()
    };
    let base = out.base_color_texture.as_ref();
    if let (Some((picture, Channel::Alpha)), true) =
        (&p.alpha.picture, base.is_none_or(|b| Some(b) != p.alpha.picture.as_ref().map(|a| &a.0.texture)))
    {
        out.alpha_texture = Some(picture.texture.clone());
    }
    // glTF's packing alone: roughness in green, metallic in blue of one picture.
    let packed = |s: &Scalar, channel| s.picture.as_ref().filter(|(_, c)| *c == channel).map(|(p, _)| p.texture.clone());
    let (rough, metal) = (packed(&p.roughness, Channel::Green), packed(&p.metallic, Channel::Blue));
    if rough.is_some() && (rough == metal || metal.is_none() && p.metallic.as_constant() == Some(0.0)) {
        out.roughness = p.roughness.factor;
        out.metallic = p.metallic.factor;
        out.metallic_roughness_texture = rough;
    }
    if let Some(NormalInput::Map { picture, strength, .. }) = p.normal.as_deref() {
        out.normal_texture = Some(picture.texture.clone());
        out.normal_scale = number(strength);
    }
    out
}
