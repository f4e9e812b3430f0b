//! What light meets below a surface: coefficients of scattering by channel, from a finish's translucency and the colour that it has from
//! afar, and the dipole that answers for light that scattered often. Numbers only, no rays.
//! Source: Jensen et al. 2001, "A Practical Model for Subsurface Light Transport"; spec/light.md, section 10.

use crate::kernel::finish::fresnel;
use crate::math::color::grey;
use crate::math::{Rgb, Vec3};
use std::f64::consts::PI;

/// Steps of the tables from diffuse reflectance to albedo.
const N_STEPS: usize = 100;

/// The reduced albedo by diffuse reflectance, for one index of refraction.
#[derive(Clone, Debug)]
pub struct AlbedoTable {
    /// Index of refraction.
    pub ior: f64,
    /// At reflectances 0, 0.01, ... 1, and what POV-Ray reads past the end (measured: pigments that are brighter than 1 turn black by 1.01).
    albedos: [f64; N_STEPS + 2],
}

impl AlbedoTable {
    /// The table for an index of refraction.
    pub fn new(ior: f64) -> Self {
        let boundary = boundary(ior);
        let mut albedos = [0.0; N_STEPS + 2];
        for (k, albedo) in albedos[..=N_STEPS].iter_mut().enumerate() {
            let wanted = k as f64 / N_STEPS as f64;
            let (mut low, mut high) = (0.0, 1.0);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                let side = if reflectance(middle, boundary) < wanted { &mut low } else { &mut high };
                *side = middle;
            }
            *albedo = 0.5 * (low + high);
        }
        Self { ior, albedos }
    }

    /// The reduced albedo of what looks as bright as this from afar; 0 for what no medium is.
    fn albedo(&self, reflectance: f64) -> f64 {
        let place = reflectance * N_STEPS as f64;
        if !(0.0..(N_STEPS + 1) as f64).contains(&place) {
            return 0.0;
        }
        let (k, t) = (place as usize, place.fract());
        self.albedos[k] * (1.0 - t) + self.albedos[k + 1] * t
    }
}

/// Diffuse reflectance of a half space of this reduced albedo.
fn reflectance(albedo: f64, boundary: f64) -> f64 {
    let q = (3.0 * (1.0 - albedo)).sqrt();
    0.5 * albedo * (1.0 + (-4.0 / 3.0 * boundary * q).exp()) * (-q).exp()
}

/// Mean of Fresnel's reflectance over diffuse light.
fn diffuse_fresnel(n: f64) -> f64 {
    if n < 1.0 {
        return n * n - n.powf(2.25);
    }
    let x = 1.0 - 1.0 / n;
    0.25 * (x + 3.0 * x.powf(4.5))
}

/// How much more a boundary holds back than none.
fn boundary(n: f64) -> f64 {
    let inner = diffuse_fresnel(n);
    (1.0 + inner) / (1.0 - inner)
}

/// Share of light that passes a boundary to a medium of relative index `n` at cosine `cos`; all of it where it is totally reflected
/// (measured).
pub(super) fn passing(n: f64, cos: f64) -> f64 {
    1.0 - fresnel(n, cos).unwrap_or(0.0)
}

/// Cosine beyond a boundary of relative index `n`; NaN where light is totally reflected.
pub(super) fn refracted_cos(n: f64, cos: f64) -> f64 {
    (1.0 - (1.0 - cos * cos) / (n * n)).sqrt()
}

/// One channel of a medium; lengths in mm.
#[derive(Clone, Copy, Debug)]
pub(super) struct Channel {
    /// Reduced scattering coefficient.
    pub scattering: f64,
    /// Reduced extinction coefficient.
    pub extinction: f64,
    /// Effective transport coefficient.
    transport: f64,
    albedo: f64,
    /// Depths of the light below the surface and of its mirror image above it.
    depths: [f64; 2],
}

impl Channel {
    fn new(table: &AlbedoTable, ior: f64, reflectance: f64, translucency: f64) -> Self {
        let albedo = table.albedo(reflectance);
        let scattering = 1.0 / translucency;
        let extinction = scattering / albedo;
        let absorption = extinction - scattering;
        let depth = 1.0 / extinction;
        Self {
            scattering,
            extinction,
            transport: (3.0 * absorption.max(0.0) * extinction).sqrt(),
            albedo,
            depths: [depth, depth * (1.0 + 4.0 / 3.0 * boundary(ior))],
        }
    }

    /// Whether light comes through it at all.
    fn is_clear(&self) -> bool {
        self.extinction > 0.0 && self.extinction < f64::INFINITY
    }

    /// Light that leaves, per area, by light that entered at a point `r` mm away.
    fn dipole(&self, r: f64) -> f64 {
        let part = |z: f64| {
            // A scene's lengths have squares; the library's hypot took 4 % of subsurface.pov.
            let d = (z * z + r * r).sqrt();
            z * (self.transport + 1.0 / d) * (-self.transport * d).exp() / (d * d)
        };
        self.albedo / (4.0 * PI) * (part(self.depths[0]) + part(self.depths[1]))
    }
}

/// What stands below a layer of a surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Medium {
    pub channels: [Channel; 3],
}

impl Medium {
    /// Of a layer whose diffuse colour is `color`; translucency in mm. The albedo is that against air, the mirror image that of the index
    /// `ior` relative to what lies around (measured: in glass).
    pub fn new(table: &AlbedoTable, ior: f64, color: Rgb, translucency: Rgb) -> Self {
        Self { channels: [0, 1, 2].map(|k| Channel::new(table, ior, f64::from(color[k]), f64::from(translucency[k]))) }
    }

    /// How far light comes before it scatters, in mm: the way at the grey mean of the extinctions.
    pub fn mean_free_path(&self) -> f64 {
        let [r, g, b] = self.channels.map(|c| c.extinction as f32);
        1.0 / f64::from(grey(Vec3::new(r, g, b)))
    }

    /// The dipole's answer by channel, and nothing where no light comes through.
    pub fn dipole(&self, r: f64) -> Rgb {
        self.by_channel(|c| c.dipole(r))
    }

    /// A number for each channel that light comes through.
    pub fn by_channel(&self, f: impl Fn(&Channel) -> f64) -> Rgb {
        Vec3::from(self.channels.map(|c| if c.is_clear() { f(&c) as f32 } else { 0.0 }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn albedos_give_back_the_reflectance_that_they_are_for() {
        for ior in [0.8, 1.0, 1.3, 2.0] {
            let table = AlbedoTable::new(ior);
            for k in 1..100 {
                let wanted = f64::from(k) / 100.0;
                let found = reflectance(table.albedo(wanted), boundary(ior));
                assert!((found - wanted).abs() < 1e-9, "ior {ior}: {found} for {wanted}");
            }
        }
    }

    #[test]
    fn the_dipole_over_a_plane_gives_back_the_reflectance() {
        let table = AlbedoTable::new(1.3);
        for wanted in [0.1, 0.5, 0.9] {
            let c = Channel::new(&table, 1.3, wanted, 1.0);
            // Rings in steps of a hundredth of a mean free path.
            let step = 0.01 / c.extinction;
            let sum: f64 = (0..100_000).map(|k| (f64::from(k) + 0.5) * step).map(|r| c.dipole(r) * 2.0 * PI * r * step).sum();
            assert!((sum - wanted).abs() < 2e-3, "{sum} for {wanted}");
        }
    }

    #[test]
    fn no_medium_is_brighter_than_white() {
        let table = AlbedoTable::new(1.3);
        assert!((table.albedo(1.001) - 0.9).abs() < 1e-3);
        assert_eq!([1.02, 5.0, -0.1, f64::NAN].map(|r| table.albedo(r)), [0.0; 4]);
        let m = Medium::new(&table, 1.3, Vec3::new(0.0, 2.0, 0.5), Vec3::new(1.0, 1.0, 0.0));
        assert_eq!(m.dipole(1.0), Vec3::ZERO);
    }
}
