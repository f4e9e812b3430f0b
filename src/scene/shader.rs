//! What a surface does to light, as a small tree of closures: what the path integrator simulates, in Blender's terms and units.
//!
//! [`super::Principled`] (with glTF's names) is the likeness of it that the classic integrator and the GPU draw; it carries a [`Shader`] when
//! the front end knows more. Without one the path integrator makes a shader from the likeness.
//! Source of the terms: Blender 4.5 manual, Shader Nodes; Cycles' conventions were measured (docs/path.md).

use super::input::{Color, NormalInput, Scalar, TangentInput};
use super::volume::Volume;
use crate::math::Vec3;

/// A whole material.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Shader {
    /// The surface; `None` lets light through as if nothing were there (a mere hull of a volume).
    pub surface: Option<Closure>,
    /// What fills the body.
    pub volume: Option<Volume>,
    /// Which faces of a shining mesh are sampled as lamps.
    pub emission_sampling: EmissionSampling,
    /// Pass index of the material.
    pub material_id: u32,
    /// Name, for Cryptomatte and messages; may be empty.
    pub name: String,
    /// Shadow rays pass through transparent parts; false: these cast full shadows.
    pub transparent_shadow: bool,
}

impl Shader {
    /// Whether shadow rays may pass some of it.
    pub fn may_let_through(&self) -> bool {
        self.surface.as_ref().is_none_or(Closure::may_let_through)
    }
}

impl Closure {
    /// Whether shadow rays may pass some of it.
    pub fn may_let_through(&self) -> bool {
        match self {
            Self::Principled(p) => p.alpha.as_constant() != Some(1.0) || p.is_pane(),
            Self::Transparent { .. } => true,
            Self::Mix { a, b, .. } | Self::Add(a, b) => a.may_let_through() || b.may_let_through(),
            _ => false,
        }
    }
}

/// Which sides of shining faces next-event estimation samples; the picture's mean is the same with each.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[expect(missing_docs, reason = "the names are Blender's")]
pub enum EmissionSampling {
    None,
    #[default]
    Auto,
    Front,
    Back,
    FrontBack,
}

/// Microfacet distribution.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Distribution {
    /// GGX with the energy of light that meets several facets put back.
    #[default]
    MultiGgx,
    /// GGX, one facet.
    Ggx,
}

/// How light goes on below a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum SubsurfaceMethod {
    /// Random walk, entered by refraction (Blender's default).
    #[default]
    RandomWalk,
    /// The same, half of it entered diffusely, with a radius that fits the colour ("Random Walk (Skin)").
    RandomWalkSkin,
}

/// A node. Radiance of all closures adds up; weights are 0..=1.
#[derive(Clone, Debug, PartialEq)]
#[expect(missing_docs, reason = "the names are Blender's sockets; units stand at the variants")]
pub enum Closure {
    Principled(Box<PrincipledClosure>),
    /// Lambert at roughness 0, Oren-Nayar above.
    Diffuse {
        color: Color,
        roughness: Scalar,
        normal: Option<Box<NormalInput>>,
    },
    /// Lambert on the other side.
    Translucent {
        color: Color,
        normal: Option<Box<NormalInput>>,
    },
    /// Straight through.
    Transparent {
        color: Color,
    },
    /// Reflection without a Fresnel term.
    Glossy {
        distribution: Distribution,
        color: Color,
        roughness: Scalar,
        anisotropy: Scalar,
        rotation: Scalar,
        normal: Option<Box<NormalInput>>,
    },
    /// Reflection of a metal by the Fresnel equations, with an index and an extinction for each channel.
    Conductor(Box<ConductorClosure>),
    /// Reflection and refraction by the Fresnel equations.
    Glass {
        distribution: Distribution,
        color: Color,
        roughness: Scalar,
        ior: Scalar,
        /// Nanometres; 0 for none.
        film_thickness: Scalar,
        film_ior: Scalar,
        normal: Option<Box<NormalInput>>,
    },
    /// Refraction without a Fresnel term.
    Refraction {
        distribution: Distribution,
        color: Color,
        roughness: Scalar,
        ior: Scalar,
        normal: Option<Box<NormalInput>>,
    },
    /// Microfibres.
    Sheen {
        color: Color,
        roughness: Scalar,
        normal: Option<Box<NormalInput>>,
    },
    /// Below the surface; `radius` times `scale` are mean free paths in scene units.
    Subsurface {
        method: SubsurfaceMethod,
        color: Color,
        radius: Color,
        scale: Scalar,
        ior: Scalar,
        anisotropy: Scalar,
        roughness: Scalar,
        normal: Option<Box<NormalInput>>,
    },
    /// Radiance colour times strength, from both sides.
    Emission {
        color: Color,
        strength: Scalar,
    },
    /// A hole in the film's alpha.
    Holdout,
    Hair(Box<HairClosure>),
    /// `a` at factor 0, `b` at 1.
    Mix {
        factor: MixFactor,
        a: Box<Closure>,
        b: Box<Closure>,
    },
    Add(Box<Closure>, Box<Closure>),
}

/// What mixes two closures.
#[derive(Clone, Debug, PartialEq)]
pub enum MixFactor {
    /// A number, clamped to 0..=1.
    Scalar(Scalar),
    /// Blender's Fresnel node at an index of refraction.
    Fresnel(Scalar),
    /// Blender's Layer Weight node, "Facing", with its blend.
    Facing(Scalar),
    /// 1 on the back of a face.
    Backfacing,
    /// A number for each sort of ray that comes, in the order of [`RaySort`]: Blender's Light Path node.
    ByRay([f32; RaySort::KEYS.len()]),
}

/// How the ray that meets a surface came about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RaySort {
    /// From the camera, also through transparent surfaces.
    Camera,
    /// Off a matt surface.
    Diffuse,
    /// Off a rough mirror.
    Glossy,
    /// Through a rough surface.
    Transmission,
    /// Off a sharp mirror.
    SharpGlossy,
    /// Through clear glass.
    SharpTransmission,
    /// Scattered in a volume.
    Volume,
    /// Towards a light.
    Shadow,
    /// From a light that was drawn: how bright it is.
    Light,
}

impl RaySort {
    /// Keys of the file's `lightPath` records.
    pub const KEYS: [&str; 9] =
        ["camera", "diffuse", "glossy", "transmission", "sharpGlossy", "sharpTransmission", "volumeScatter", "shadow", "light"];
}

/// Blender's Metallic BSDF, "Physical Conductor".
#[derive(Clone, Debug, PartialEq)]
pub struct ConductorClosure {
    /// Of the facets.
    pub distribution: Distribution,
    /// Index of refraction, by channel.
    pub ior: Color,
    /// Extinction, by channel.
    pub extinction: Color,
    /// Of the facets.
    pub roughness: Scalar,
    /// Stretch of the facets, 0..=1.
    pub anisotropy: Scalar,
    /// Of the tangent, turns.
    pub rotation: Scalar,
    /// Instead of the surface's.
    pub normal: Option<Box<NormalInput>>,
}

/// Principled BSDF of Blender 4.5, socket by socket. Colours are linear; angles in turns where Blender has turns.
#[derive(Clone, Debug, PartialEq)]
#[expect(missing_docs, reason = "the names are Blender's sockets")]
pub struct PrincipledClosure {
    pub base_color: Color,
    pub metallic: Scalar,
    pub roughness: Scalar,
    pub ior: Scalar,
    pub alpha: Scalar,
    pub normal: Option<Box<NormalInput>>,
    pub distribution: Distribution,
    /// Oren-Nayar roughness of the diffuse base.
    pub diffuse_roughness: Scalar,
    pub subsurface_method: SubsurfaceMethod,
    pub subsurface_weight: Scalar,
    /// Mean free paths by channel, in units of `subsurface_scale`.
    pub subsurface_radius: Color,
    /// Scene units.
    pub subsurface_scale: Scalar,
    /// Index inside, of the skin method only.
    pub subsurface_ior: Scalar,
    pub subsurface_anisotropy: Scalar,
    /// 0.5 leaves the index's reflectance as it is.
    pub specular_ior_level: Scalar,
    /// Of dielectrics a factor of F0; of metals the colour at 82 degrees (F82).
    pub specular_tint: Color,
    pub anisotropic: Scalar,
    /// Turns.
    pub anisotropic_rotation: Scalar,
    /// What the turns count from.
    pub tangent: TangentInput,
    pub transmission_weight: Scalar,
    pub coat_weight: Scalar,
    pub coat_roughness: Scalar,
    pub coat_ior: Scalar,
    pub coat_tint: Color,
    pub coat_normal: Option<Box<NormalInput>>,
    pub sheen_weight: Scalar,
    pub sheen_roughness: Scalar,
    pub sheen_tint: Color,
    pub emission_color: Color,
    /// Radiance of emission colour 1.
    pub emission_strength: Scalar,
    /// Nanometres; 0 for none.
    pub thin_film_thickness: Scalar,
    pub thin_film_ior: Scalar,
    /// Thin wall: transmission does not bend (glTF's transmission without a volume).
    pub thin_walled: bool,
}

impl PrincipledClosure {
    /// Some light goes straight through it as through a pane.
    pub fn is_pane(&self) -> bool {
        self.thin_walled && self.transmission_weight.as_constant() != Some(0.0)
    }
}

impl Default for PrincipledClosure {
    /// Blender 4.5's defaults.
    fn default() -> Self {
        Self {
            base_color: Color::constant(Vec3::splat(0.8)),
            metallic: 0.0.into(),
            roughness: 0.5.into(),
            ior: 1.5.into(),
            alpha: 1.0.into(),
            normal: None,
            distribution: Distribution::MultiGgx,
            diffuse_roughness: 0.0.into(),
            subsurface_method: SubsurfaceMethod::RandomWalk,
            subsurface_weight: 0.0.into(),
            subsurface_radius: Color::constant(Vec3::new(1.0, 0.2, 0.1)),
            subsurface_scale: 0.05.into(),
            subsurface_ior: 1.4.into(),
            subsurface_anisotropy: 0.0.into(),
            specular_ior_level: 0.5.into(),
            specular_tint: 1.0.into(),
            anisotropic: 0.0.into(),
            anisotropic_rotation: 0.0.into(),
            tangent: TangentInput::Object,
            transmission_weight: 0.0.into(),
            coat_weight: 0.0.into(),
            coat_roughness: 0.03.into(),
            coat_ior: 1.5.into(),
            coat_tint: 1.0.into(),
            coat_normal: None,
            sheen_weight: 0.0.into(),
            sheen_roughness: 0.5.into(),
            sheen_tint: 1.0.into(),
            emission_color: 1.0.into(),
            emission_strength: 0.0.into(),
            thin_film_thickness: 0.0.into(),
            thin_film_ior: 1.33.into(),
            thin_walled: false,
        }
    }
}

/// How a hair gets its colour.
#[derive(Clone, Debug, PartialEq)]
#[expect(missing_docs, reason = "the names are Blender's sockets")]
pub enum HairColor {
    /// Absorption per hair radius.
    Absorption(Color),
    /// Melanin 0..=1, redness 0..=1, a dye's tint, and their random spread.
    Melanin { melanin: Scalar, redness: Scalar, tint: Color, random: Scalar },
    /// The colour that the hair shall have.
    Reflectance(Color),
}

/// Principled Hair BSDF, Chiang's model, of Blender 4.5. Source: Chiang et al. 2016.
#[derive(Clone, Debug, PartialEq)]
#[expect(missing_docs, reason = "the names are Blender's sockets")]
pub struct HairClosure {
    pub color: HairColor,
    pub roughness: Scalar,
    pub radial_roughness: Scalar,
    pub coat: Scalar,
    pub ior: Scalar,
    /// Tilt of the scales, radians.
    pub offset_rad: Scalar,
    /// Random spread of the roughnesses from hair to hair.
    pub random_roughness: Scalar,
}

impl Default for HairClosure {
    /// Blender 4.5's defaults.
    fn default() -> Self {
        Self {
            color: HairColor::Reflectance(Color::constant(Vec3::new(0.017_513, 0.005_763, 0.002_059))),
            roughness: 0.3.into(),
            radial_roughness: 0.3.into(),
            coat: 0.0.into(),
            ior: 1.55.into(),
            offset_rad: 2.0f32.to_radians().into(),
            random_roughness: 0.0.into(),
        }
    }
}
