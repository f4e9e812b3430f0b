//! Closures: what a shader node does to light.

use super::super::super::ImportError;
use super::input::Inputs;
use crate::math::Vec3;
use crate::scene::Volume;
use crate::scene::input::{Color, Scalar};
use crate::scene::shader::{
    Closure, ConductorClosure, Distribution, HairClosure, HairColor, MixFactor, PrincipledClosure, RaySort, SubsurfaceMethod,
};

/// Most closures of one material, shared ones counted as often as they are used.
pub(super) const MAX_CLOSURES: usize = 4096;

const GGX: &[(&str, Distribution)] = &[
    ("multiGgx", Distribution::MultiGgx),
    ("ggx", Distribution::Ggx),
    // Both have no likeness here that is nearer.
    ("beckmann", Distribution::Ggx),
    ("ashikhminShirley", Distribution::Ggx),
];
const METHODS: &[(&str, SubsurfaceMethod)] = &[
    ("randomWalk", SubsurfaceMethod::RandomWalk),
    ("randomWalkSkin", SubsurfaceMethod::RandomWalkSkin),
    ("burley", SubsurfaceMethod::RandomWalk),
];

impl Inputs<'_, '_, '_> {
    /// Tells once what the owner cannot have.
    pub fn told(&mut self, what: &str) {
        let message = format!("{}: {what}", self.owner);
        self.sink.note_once(&format!("rayloom: {message}"), None, message.clone());
    }

    fn spend(&self, ix: usize, budget: &mut usize) -> Result<(), ImportError> {
        match budget.checked_sub(1) {
            Some(left) => *budget = left,
            None => return Err(self.nodes[ix].wrong("type", format!("the material has more than {MAX_CLOSURES} closures"))),
        }
        Ok(())
    }

    /// Surface closure `ix`; black for kinds that are not known.
    pub fn closure(&mut self, ix: usize, budget: &mut usize) -> Result<Closure, ImportError> {
        self.spend(ix, budget)?;
        let white = Vec3::splat(0.8);
        Ok(match self.kind(ix)? {
            "principled" => Closure::Principled(Box::new(self.principled(ix)?)),
            "diffuse" => Closure::Diffuse {
                color: self.color(ix, "color", white)?,
                roughness: self.scalar(ix, "roughness", 0.0)?,
                normal: self.normal(ix, "normal")?,
            },
            "translucent" => Closure::Translucent { color: self.color(ix, "color", white)?, normal: self.normal(ix, "normal")? },
            "transparent" => Closure::Transparent { color: self.color(ix, "color", Vec3::ONE)? },
            "glossy" => Closure::Glossy {
                distribution: self.distribution(ix)?,
                color: self.color(ix, "color", white)?,
                roughness: self.scalar(ix, "roughness", 0.5)?,
                anisotropy: self.scalar(ix, "anisotropy", 0.0)?,
                rotation: self.scalar(ix, "rotation", 0.0)?,
                normal: self.normal(ix, "normal")?,
            },
            "glass" => Closure::Glass {
                distribution: self.distribution(ix)?,
                color: self.color(ix, "color", Vec3::ONE)?,
                roughness: self.scalar(ix, "roughness", 0.0)?,
                ior: self.scalar(ix, "ior", 1.5)?,
                film_thickness: self.scalar(ix, "thinFilmThickness", 0.0)?,
                film_ior: self.scalar(ix, "thinFilmIor", 1.33)?,
                normal: self.normal(ix, "normal")?,
            },
            "refraction" => Closure::Refraction {
                distribution: self.distribution(ix)?,
                color: self.color(ix, "color", Vec3::ONE)?,
                roughness: self.scalar(ix, "roughness", 0.0)?,
                ior: self.scalar(ix, "ior", 1.5)?,
                normal: self.normal(ix, "normal")?,
            },
            "sheen" => Closure::Sheen {
                color: self.color(ix, "color", white)?,
                roughness: self.scalar(ix, "roughness", 0.5)?,
                normal: self.normal(ix, "normal")?,
            },
            "subsurface" => Closure::Subsurface {
                method: self.nodes[ix].choice("method", SubsurfaceMethod::RandomWalk, METHODS)?,
                color: self.color(ix, "color", white)?,
                radius: self.color(ix, "radius", Vec3::new(1.0, 0.2, 0.1))?,
                scale: self.scalar(ix, "scale", 0.05)?,
                ior: self.scalar(ix, "ior", 1.4)?,
                anisotropy: self.scalar(ix, "anisotropy", 0.0)?,
                roughness: self.scalar(ix, "roughness", 1.0)?,
                normal: self.normal(ix, "normal")?,
            },
            "metallicBsdf" if self.nodes[ix].text("fresnel")? == Some("conductor") => Closure::Conductor(Box::new(ConductorClosure {
                distribution: self.distribution(ix)?,
                ior: self.color(ix, "ior", Vec3::splat(3.0))?,
                extinction: self.color(ix, "extinction", Vec3::splat(3.0))?,
                roughness: self.scalar(ix, "roughness", 0.5)?,
                anisotropy: self.scalar(ix, "anisotropy", 0.0)?,
                rotation: self.scalar(ix, "rotation", 0.0)?,
                normal: self.normal(ix, "normal")?,
            })),
            "metallicBsdf" => Closure::Principled(Box::new(PrincipledClosure {
                base_color: self.color(ix, "baseColor", Vec3::new(0.617, 0.577, 0.540))?,
                specular_tint: self.color(ix, "edgeTint", Vec3::new(0.695, 0.726, 0.770))?,
                metallic: 1.0.into(),
                roughness: self.scalar(ix, "roughness", 0.5)?,
                anisotropic: self.scalar(ix, "anisotropy", 0.0)?,
                anisotropic_rotation: self.scalar(ix, "rotation", 0.0)?,
                normal: self.normal(ix, "normal")?,
                distribution: self.distribution(ix)?,
                ..PrincipledClosure::default()
            })),
            "emission" => Closure::Emission { color: self.color(ix, "color", Vec3::ONE)?, strength: self.scalar(ix, "strength", 1.0)? },
            "holdout" => Closure::Holdout,
            "principledHair" => Closure::Hair(Box::new(self.hair(ix)?)),
            "add" => {
                let (a, b) = (self.child(ix, "a")?, self.child(ix, "b")?);
                let a = self.child_closure(a, budget)?;
                Closure::Add(Box::new(a), Box::new(self.child_closure(b, budget)?))
            }
            "mix" => {
                let (a, b) = (self.child(ix, "a")?, self.child(ix, "b")?);
                let factor = self.mix_factor(ix)?;
                let a = self.child_closure(a, budget)?;
                Closure::Mix { factor, a: Box::new(a), b: Box::new(self.child_closure(b, budget)?) }
            }
            other => {
                let what = format!("the closure '{other}' is left out: it is black");
                self.told(&what);
                black()
            }
        })
    }

    /// The closure that a key of a mix names, which stands before it.
    fn child(&self, ix: usize, key: &str) -> Result<Option<usize>, ImportError> {
        let child = self.nodes[ix].index(key, self.nodes.len(), "closure")?;
        match child {
            Some(k) if k >= ix => Err(self.nodes[ix].wrong(key, format!("closure {k} does not stand before node {ix}"))),
            other => Ok(other),
        }
    }

    fn child_closure(&mut self, ix: Option<usize>, budget: &mut usize) -> Result<Closure, ImportError> {
        ix.map_or_else(|| Ok(black()), |k| self.closure(k, budget))
    }

    fn distribution(&mut self, ix: usize) -> Result<Distribution, ImportError> {
        if let Some(word @ ("beckmann" | "ashikhminShirley")) = self.nodes[ix].text("distribution")? {
            let what = format!("the distribution '{word}' is taken as GGX");
            self.told(&what);
        }
        self.nodes[ix].choice("distribution", Distribution::MultiGgx, GGX)
    }

    fn mix_factor(&mut self, ix: usize) -> Result<MixFactor, ImportError> {
        let Some(node) = self.source(ix, "factor")? else { return Ok(MixFactor::Scalar(self.scalar(ix, "factor", 0.5)?)) };
        let output = self.nodes[ix].record("factor")?.map_or(Ok(None), |l| l.text("output"))?;
        Ok(match (self.kind(node)?, output) {
            ("fresnel", _) => MixFactor::Fresnel(self.scalar(node, "ior", 1.5)?),
            ("layerWeight", Some("facing")) => MixFactor::Facing(self.scalar(node, "blend", 0.5)?),
            ("geometry", Some("backfacing")) => MixFactor::Backfacing,
            ("lightPath", _) => {
                let mut values = [0.0; RaySort::KEYS.len()];
                for (value, key) in values.iter_mut().zip(RaySort::KEYS) {
                    *value = self.nodes[node].number_or(key, 0.0)? as f32;
                }
                MixFactor::ByRay(values)
            }
            _ => MixFactor::Scalar(self.scalar(ix, "factor", 0.5)?),
        })
    }

    fn principled(&mut self, ix: usize) -> Result<PrincipledClosure, ImportError> {
        let d = PrincipledClosure::default();
        let constant = |s: &Scalar| s.as_constant().expect("defaults are constants");
        let plain = |c: &Color| c.as_constant().expect("defaults are constants");
        if self.source(ix, "tangent")?.is_some() {
            self.told("a tangent of its own is left out");
        }
        if self.nodes[ix].text("subsurfaceMethod")? == Some("burley") {
            self.told("subsurface scattering by Burley's profile is a random walk");
        }
        Ok(PrincipledClosure {
            base_color: self.color(ix, "baseColor", plain(&d.base_color))?,
            metallic: self.scalar(ix, "metallic", constant(&d.metallic))?,
            roughness: self.scalar(ix, "roughness", constant(&d.roughness))?,
            ior: self.scalar(ix, "ior", constant(&d.ior))?,
            alpha: self.scalar(ix, "alpha", constant(&d.alpha))?,
            normal: self.normal(ix, "normal")?,
            distribution: self.distribution(ix)?,
            diffuse_roughness: self.scalar(ix, "diffuseRoughness", constant(&d.diffuse_roughness))?,
            subsurface_method: self.nodes[ix].choice("subsurfaceMethod", SubsurfaceMethod::RandomWalk, METHODS)?,
            subsurface_weight: self.scalar(ix, "subsurfaceWeight", constant(&d.subsurface_weight))?,
            subsurface_radius: self.color(ix, "subsurfaceRadius", plain(&d.subsurface_radius))?,
            subsurface_scale: self.scalar(ix, "subsurfaceScale", constant(&d.subsurface_scale))?,
            subsurface_ior: self.scalar(ix, "subsurfaceIor", constant(&d.subsurface_ior))?,
            subsurface_anisotropy: self.scalar(ix, "subsurfaceAnisotropy", constant(&d.subsurface_anisotropy))?,
            specular_ior_level: self.scalar(ix, "specularIorLevel", constant(&d.specular_ior_level))?,
            specular_tint: self.color(ix, "specularTint", Vec3::ONE)?,
            anisotropic: self.scalar(ix, "anisotropic", constant(&d.anisotropic))?,
            anisotropic_rotation: self.scalar(ix, "anisotropicRotation", constant(&d.anisotropic_rotation))?,
            transmission_weight: self.scalar(ix, "transmissionWeight", constant(&d.transmission_weight))?,
            coat_weight: self.scalar(ix, "coatWeight", constant(&d.coat_weight))?,
            coat_roughness: self.scalar(ix, "coatRoughness", constant(&d.coat_roughness))?,
            coat_ior: self.scalar(ix, "coatIor", constant(&d.coat_ior))?,
            coat_tint: self.color(ix, "coatTint", Vec3::ONE)?,
            coat_normal: self.normal(ix, "coatNormal")?,
            sheen_weight: self.scalar(ix, "sheenWeight", constant(&d.sheen_weight))?,
            sheen_roughness: self.scalar(ix, "sheenRoughness", constant(&d.sheen_roughness))?,
            sheen_tint: self.color(ix, "sheenTint", Vec3::ONE)?,
            emission_color: self.color(ix, "emissionColor", Vec3::ONE)?,
            emission_strength: self.scalar(ix, "emissionStrength", constant(&d.emission_strength))?,
            thin_film_thickness: self.scalar(ix, "thinFilmThickness", constant(&d.thin_film_thickness))?,
            thin_film_ior: self.scalar(ix, "thinFilmIor", constant(&d.thin_film_ior))?,
            ..d
        })
    }

    fn hair(&mut self, ix: usize) -> Result<HairClosure, ImportError> {
        let d = HairClosure::default();
        let constant = |s: &Scalar| s.as_constant().expect("defaults are constants");
        if self.nodes[ix].text("model")? == Some("huang") {
            self.told("hair of Huang's model is of Chiang's");
        }
        let color = match self.nodes[ix].text("parametrization")? {
            Some("absorption") => HairColor::Absorption(self.color(ix, "absorption", Vec3::new(0.245_531, 0.52, 1.365))?),
            Some("melanin") => HairColor::Melanin {
                melanin: self.scalar(ix, "melanin", 0.8)?,
                redness: self.scalar(ix, "melaninRedness", 1.0)?,
                tint: self.color(ix, "tint", Vec3::ONE)?,
                random: self.scalar(ix, "randomColor", 0.0)?,
            },
            _ => HairColor::Reflectance(self.color(ix, "color", Vec3::new(0.017_513, 0.005_763, 0.002_059))?),
        };
        Ok(HairClosure {
            color,
            roughness: self.scalar(ix, "roughness", constant(&d.roughness))?,
            radial_roughness: self.scalar(ix, "radialRoughness", constant(&d.radial_roughness))?,
            coat: self.scalar(ix, "coat", constant(&d.coat))?,
            ior: self.scalar(ix, "ior", constant(&d.ior))?,
            offset_rad: self.scalar(ix, "offset", constant(&d.offset_rad))?,
            random_roughness: self.scalar(ix, "randomRoughness", constant(&d.random_roughness))?,
        })
    }

    /// Volume closure `ix`; `None` for kinds that are not known.
    pub fn volume(&mut self, ix: usize, budget: &mut usize) -> Result<Option<Volume>, ImportError> {
        self.spend(ix, budget)?;
        let kind = self.kind(ix)?;
        let gray = if kind == "principledVolume" { Vec3::splat(0.5) } else { Vec3::splat(0.8) };
        let color = self.constant_color(ix, "color", gray)?;
        let (density, grid) = self.density(ix, "density", 1.0)?;
        let density = density.max(0.0);
        let anisotropy = self.constant(ix, "anisotropy", 0.0)?.clamp(-0.999, 0.999);
        let volume = match kind {
            "principledVolume" => {
                let absorption = self.constant_color(ix, "absorptionColor", Vec3::ZERO)?;
                let strength = self.constant(ix, "emissionStrength", 0.0)?;
                let emission = self.constant_color(ix, "emissionColor", Vec3::ONE)? * strength;
                if self.constant(ix, "blackbodyIntensity", 0.0)? > 0.0 {
                    self.told("the blackbody of a volume is left out");
                }
                Volume::principled(color, absorption, density, anisotropy, emission)
            }
            "volumeScatter" => {
                if !matches!(self.nodes[ix].text("phase")?, None | Some("henyeyGreenstein")) {
                    self.told("the phase function of a volume is Henyey-Greenstein's");
                }
                let (absorption, emission) = (Vec3::ZERO, Vec3::ZERO);
                Volume { absorption, scattering: color * density, emission, anisotropy, density: None }
            }
            "volumeAbsorption" => Volume {
                absorption: (Vec3::ONE - color).max(Vec3::ZERO) * density,
                scattering: Vec3::ZERO,
                emission: Vec3::ZERO,
                anisotropy: 0.0,
                density: None,
            },
            "emission" => {
                let emission = self.constant_color(ix, "color", Vec3::ONE)? * self.constant(ix, "strength", 1.0)?;
                Volume { absorption: Vec3::ZERO, scattering: Vec3::ZERO, emission, anisotropy: 0.0, density: None }
            }
            "add" => {
                let sides = [self.child(ix, "a")?, self.child(ix, "b")?];
                let mut sum: Option<Volume> = None;
                for k in sides.into_iter().flatten() {
                    let Some(v) = self.volume(k, budget)? else { continue };
                    sum = Some(match sum {
                        None => v,
                        Some(s) if s.density.is_none() && v.density.is_none() => added(s, v),
                        Some(s) => {
                            self.told("one of two volumes with grids is left out");
                            s
                        }
                    });
                }
                return Ok(sum);
            }
            other => {
                let what = format!("the volume closure '{other}' is left out");
                self.told(&what);
                return Ok(None);
            }
        };
        Ok(Some(Volume { density: grid, ..volume }))
    }

    fn constant(&mut self, ix: usize, key: &str, default: f32) -> Result<f32, ImportError> {
        let s = self.scalar(ix, key, default)?;
        Ok(s.as_constant().unwrap_or_else(|| {
            self.told(&format!("the picture of a volume's {key} is left out"));
            default
        }))
    }

    fn constant_color(&mut self, ix: usize, key: &str, default: Vec3) -> Result<Vec3, ImportError> {
        let c = self.color(ix, key, default)?;
        Ok(c.as_constant().unwrap_or_else(|| {
            self.told(&format!("the picture of a volume's {key} is left out"));
            default
        }))
    }
}

/// Takes all light.
pub(super) fn black() -> Closure {
    Closure::Diffuse { color: 0.0.into(), roughness: 0.0.into(), normal: None }
}

/// Two homogeneous volumes in one place; anisotropy by the mean of what scatters.
fn added(a: Volume, b: Volume) -> Volume {
    let (wa, wb) = (a.scattering.element_sum(), b.scattering.element_sum());
    let g = if wa + wb > 0.0 { (a.anisotropy * wa + b.anisotropy * wb) / (wa + wb) } else { 0.0 };
    Volume {
        absorption: a.absorption + b.absorption,
        scattering: a.scattering + b.scattering,
        emission: a.emission + b.emission,
        anisotropy: g,
        density: None,
    }
}
