//! The physically based material of imports, and its pictures. What it does to light: `kernel/material.rs` and the integrators.

use super::Shader;
use crate::math::{Rgb, Vec3};
use std::sync::Arc;

/// What alpha does. Source: glTF 2.0, section 3.9.4.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AlphaMode {
    /// Nothing.
    Opaque,
    /// Surface from this alpha on, hole below.
    Mask(f32),
    /// Share of surface over what lies behind.
    Blend,
}

/// Colours or numbers of a picture, as in its file: `[height][width]`, row-major, top row first, red green blue alpha.
#[derive(Clone, Debug, PartialEq)]
pub enum Texels {
    /// 8 bits a channel.
    Rgba8(Vec<[u8; 4]>),
    /// 16 bits a channel.
    Rgba16(Vec<[u16; 4]>),
    /// Floats, linear whatever the texture says; may exceed 1.
    RgbaF32(Vec<[f32; 4]>),
}

/// A picture of a material.
#[derive(Clone, Debug, PartialEq)]
pub struct MaterialImage {
    /// Columns, at least 1.
    pub width: u32,
    /// Rows, at least 1.
    pub height: u32,
    /// `width * height` texels.
    pub texels: Texels,
}

/// What lies beyond the edge of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wrap {
    /// The picture again.
    Repeat,
    /// The picture mirrored.
    Mirror,
    /// Its edge.
    Clamp,
    /// Nothing: black that lets through (Blender's Clip).
    Clip,
}

/// A picture as a material uses it.
#[derive(Clone, Debug, PartialEq)]
pub struct MaterialTexture {
    /// The picture, shared by all that use it.
    pub image: Arc<MaterialImage>,
    /// Colours are sRGB-encoded; false for numbers (roughness, normals). Alpha is linear always.
    pub srgb: bool,
    /// Along u, along v.
    pub wrap: [Wrap; 2],
    /// Mix of the four nearest texels; false: the nearest.
    pub linear: bool,
    /// Picture coordinates from the mesh's: `[a, b, c]` gives `a u + b v + c`, first for u, then for v. (0, 0) is the upper left
    /// corner of the picture, v runs down.
    pub uv_transform: [[f32; 3]; 2],
}

/// A glTF/Blender material. Textures multiply their factors; colours are linear. Source: glTF 2.0, section 3.9 and the KHR extensions
/// that the fields are named after.
#[derive(Clone, Debug)]
#[expect(missing_docs, reason = "the names are glTF's")]
pub struct Principled {
    pub base_color: Rgb,
    pub alpha: f32,
    pub alpha_mode: AlphaMode,
    pub metallic: f32,
    pub roughness: f32,
    pub ior: f32,
    pub specular: f32,
    pub specular_color: Rgb,
    pub transmission: f32,
    /// Radiance, strength included.
    pub emission: Rgb,
    /// Colour, and alpha.
    pub base_color_texture: Option<MaterialTexture>,
    /// More alpha, in its alpha channel (OBJ's `map_d`).
    pub alpha_texture: Option<MaterialTexture>,
    /// Roughness in green, metallic in blue.
    pub metallic_roughness_texture: Option<MaterialTexture>,
    /// In red.
    pub transmission_texture: Option<MaterialTexture>,
    pub emission_texture: Option<MaterialTexture>,
    /// Tangent-space normals: red to the right of the picture, green to its top.
    pub normal_texture: Option<MaterialTexture>,
    pub normal_scale: f32,
    /// Said by glTF; both sides are shown anyway, as Cycles does.
    pub double_sided: bool,
    /// What the path integrator simulates; `None`: what the fields above say. These stay its likeness for the classic integrator.
    pub shader: Option<Arc<Shader>>,
    /// Name, for Cryptomatte; may be empty.
    pub name: Arc<str>,
}

impl Default for Principled {
    fn default() -> Self {
        Self {
            base_color: Vec3::ONE,
            alpha: 1.0,
            alpha_mode: AlphaMode::Opaque,
            metallic: 0.0,
            roughness: 1.0,
            ior: 1.5,
            specular: 1.0,
            specular_color: Vec3::ONE,
            transmission: 0.0,
            emission: Vec3::ZERO,
            base_color_texture: None,
            alpha_texture: None,
            metallic_roughness_texture: None,
            transmission_texture: None,
            emission_texture: None,
            normal_texture: None,
            normal_scale: 1.0,
            double_sided: true,
            shader: None,
            name: "".into(),
        }
    }
}

impl Principled {
    /// Whether some of it may let shadow rays pass.
    pub fn lets_light_through(&self) -> bool {
        self.transmission > 0.0 || self.alpha_mode != AlphaMode::Opaque || self.shader.as_ref().is_some_and(|s| s.may_let_through())
    }

    /// Whether it shines by itself.
    pub fn is_emitter(&self) -> bool {
        self.emission.max_element() > 0.0
    }
}
