//! What lies behind everything: radiance by direction, and drawing directions by brightness.

use crate::compile::CompiledScene;
use crate::kernel::PatternPoint;
use crate::kernel::pigment::eval_pigment;
use crate::math::{DMat3, DVec2, DVec3, Rgb, Vec3};
use crate::scene::environment::{EnvironmentSource, FloatImage};
use crate::scene::{Environment, Visibility};
use std::f64::consts::{PI, TAU};

/// Size of the map in which directions of skies are drawn.
const BAKED: (u32, u32) = (512, 256);

/// An environment made ready.
pub struct ReadyEnvironment {
    /// Where colours come from.
    pub kind: Kind,
    /// Multiplies them.
    pub strength: Rgb,
    /// World direction to the source's.
    pub rotation: DMat3,
    /// Ray kinds that see it.
    pub visibility: Visibility,
    /// What the camera sees in its place.
    pub for_camera: Option<Box<ReadyEnvironment>>,
    /// For drawing directions; none where it is met by chance alone.
    pub sampling: Option<Sampling>,
}

/// Where an environment's colours come from.
pub enum Kind {
    /// White.
    Constant,
    /// By angles.
    Equirect {
        /// Picture.
        image: std::sync::Arc<FloatImage>,
        /// Mix of the four nearest texels.
        linear: bool,
    },
    /// A mirror ball.
    MirrorBall {
        /// Picture.
        image: std::sync::Arc<FloatImage>,
        /// Mix of the four nearest texels.
        linear: bool,
    },
    /// A clear sky.
    Sky(Box<super::sky::ReadySky>),
    /// POV-Ray's background and sky sphere.
    Pov,
}

/// Cells of an equirectangular map, drawn by brightness.
pub struct Sampling {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Sums along each row, `width + 1` a row.
    pub rows: Vec<f32>,
    /// Sums of rows, `height + 1`.
    pub column: Vec<f32>,
    /// Mean of brightness over all directions.
    pub mean: f32,
}

impl ReadyEnvironment {
    /// The scene's.
    pub fn new(scene: &CompiledScene) -> Self {
        let Some(e) = &scene.environment else {
            let plain = scene.sky.is_none();
            let mut ready = Self {
                kind: if plain { Kind::Constant } else { Kind::Pov },
                strength: if plain { scene.background.rgb * (1.0 - scene.background.transmit) } else { Vec3::ONE },
                rotation: DMat3::IDENTITY,
                visibility: Visibility::ALL,
                for_camera: None,
                sampling: None,
            };
            if !plain {
                ready.sampling = Some(ready.bake(scene, BAKED));
            }
            return ready;
        };
        Self::of(scene, e)
    }

    fn of(scene: &CompiledScene, e: &Environment) -> Self {
        let kind = match &e.source {
            EnvironmentSource::Constant => Kind::Constant,
            EnvironmentSource::Equirect { image, linear } => Kind::Equirect { image: image.clone(), linear: *linear },
            EnvironmentSource::MirrorBall { image, linear } => Kind::MirrorBall { image: image.clone(), linear: *linear },
            EnvironmentSource::Sky(sky) => Kind::Sky(Box::new(super::sky::ReadySky::new(sky))),
        };
        let size = match &kind {
            Kind::Equirect { image, .. } => (image.width, image.height),
            _ => BAKED,
        };
        let for_camera = e.for_camera.as_deref().map(|c| {
            // Met, never drawn.
            Box::new(Self::of(scene, &Environment { sampled: false, ..c.clone() }))
        });
        let mut ready = Self { kind, strength: e.strength, rotation: e.rotation, visibility: e.visibility, for_camera, sampling: None };
        if e.sampled && !matches!(ready.kind, Kind::Constant) && e.strength.max_element() > 0.0 {
            ready.sampling = Some(ready.bake(scene, size));
        }
        ready
    }

    /// The sun's disc of a sky, in world space.
    pub fn sun(&self) -> Option<super::sky::Disc> {
        let Kind::Sky(sky) = &self.kind else { return None };
        let d = sky.disc()?;
        let to_world = self.rotation.transpose();
        Some(super::sky::Disc { dir: to_world * d.dir, up: to_world * d.up, radiance: d.radiance.map(|c| c * self.strength), ..d })
    }

    /// Ray kinds that see it.
    pub fn sees(&self, kind: Visibility) -> bool {
        self.visibility.has(kind)
    }

    /// Whether directions are drawn from it.
    pub fn is_sampled(&self) -> bool {
        self.sampling.is_some()
    }

    /// About the irradiance that it gives.
    pub fn estimate(&self) -> f64 {
        self.sampling.as_ref().map_or(0.0, |s| f64::from(s.mean) * PI)
    }

    /// Radiance from world direction `dir`, without a sun's disc.
    pub fn radiance(&self, scene: &CompiledScene, dir: DVec3) -> Rgb {
        let d = self.rotation * dir;
        let c = match &self.kind {
            Kind::Constant => Vec3::ONE,
            Kind::Equirect { image, linear } => look(image, uv_of(d), *linear),
            Kind::MirrorBall { image, linear } => {
                // The normal halfway between the viewer (looking along +y) and the direction.
                let n = (d - DVec3::Y).try_normalize().unwrap_or(DVec3::X);
                look(image, DVec2::new(0.5 + 0.5 * n.x, 0.5 - 0.5 * n.z), *linear)
            }
            Kind::Sky(sky) => sky.radiance(d),
            Kind::Pov => pov_sky(scene, d),
        };
        c * self.strength
    }

    fn bake(&self, scene: &CompiledScene, (width, height): (u32, u32)) -> Sampling {
        let (w, h) = (width as usize, height as usize);
        let to_world = self.rotation.transpose();
        let mut rows = vec![0.0f32; (w + 1) * h];
        let mut column = vec![0.0f32; h + 1];
        let mut mean = 0.0f64;
        for y in 0..h {
            let sin = (PI * (y as f64 + 0.5) / h as f64).sin();
            let mut sum = 0.0f32;
            for x in 0..w {
                // The brightest of the middle and the corners: filtered pictures spill over the edges of texels.
                let at = |dx: f64, dy: f64| {
                    let uv = DVec2::new((x as f64 + dx) / w as f64, (y as f64 + dy) / h as f64);
                    self.radiance(scene, to_world * direction_of(uv)).max(Vec3::ZERO)
                };
                let middle = at(0.5, 0.5).element_sum() / 3.0;
                let corners = [at(0.02, 0.02), at(0.98, 0.02), at(0.02, 0.98), at(0.98, 0.98)];
                let corner = corners.iter().map(|c| c.element_sum() / 3.0).sum::<f32>() / 4.0;
                let value = 0.5 * (middle + corner) * sin as f32;
                sum += if value.is_finite() { value } else { 0.0 };
                rows[y * (w + 1) + x + 1] = sum;
            }
            mean += f64::from(sum);
            column[y + 1] = column[y] + sum;
        }
        Sampling { width: w, height: h, rows, column, mean: (mean * 0.5 * PI / (w * h) as f64) as f32 }
    }

    /// A world direction drawn by brightness, and its density.
    pub fn sample(&self, u: f32, v: f32) -> Option<(DVec3, f32)> {
        let s = self.sampling.as_ref()?;
        let (y, fy) = pick(&s.column, v)?;
        let row = &s.rows[y * (s.width + 1)..][..s.width + 1];
        let (x, fx) = pick(row, u)?;
        let uv = DVec2::new((x as f64 + f64::from(fx)) / s.width as f64, (y as f64 + f64::from(fy)) / s.height as f64);
        let dir = self.rotation.transpose() * direction_of(uv);
        Some((dir, s.density(x, y, uv.y)))
    }

    /// Density with which [`Self::sample`] draws a world direction.
    pub fn density(&self, dir: DVec3) -> f32 {
        let Some(s) = &self.sampling else { return 0.0 };
        let uv = uv_of(self.rotation * dir);
        let x = ((uv.x * s.width as f64) as usize).min(s.width - 1);
        let y = ((uv.y * s.height as f64) as usize).min(s.height - 1);
        s.density(x, y, uv.y)
    }
}

impl Sampling {
    fn density(&self, x: usize, y: usize, v: f64) -> f32 {
        let total = self.column[self.height];
        let row = &self.rows[y * (self.width + 1)..];
        let cell = row[x + 1] - row[x];
        let sin = (PI * v).sin();
        if !(total > 0.0 && sin > 0.0) {
            return 0.0;
        }
        (f64::from(cell / total) * (self.width * self.height) as f64 / (TAU * PI * sin)) as f32
    }
}

/// The cell of running sums in which `u` falls, and where in it.
fn pick(sums: &[f32], u: f32) -> Option<(usize, f32)> {
    let total = *sums.last()?;
    if !(total > 0.0) {
        return None;
    }
    let target = u * total;
    let k = sums.partition_point(|s| *s <= target).clamp(1, sums.len() - 1) - 1;
    let step = sums[k + 1] - sums[k];
    Some((k, if step > 0.0 { ((target - sums[k]) / step).clamp(0.0, 1.0) } else { 0.5 }))
}

/// Place in an equirectangular picture: (0, 0) is the upper left corner.
fn uv_of(d: DVec3) -> DVec2 {
    let u = 0.5 - d.y.atan2(d.x) / TAU;
    DVec2::new(u, d.z.clamp(-1.0, 1.0).acos() / PI)
}

/// The direction of a place.
fn direction_of(uv: DVec2) -> DVec3 {
    let (sp, cp) = (TAU * (0.5 - uv.x)).sin_cos();
    let (st, ct) = (PI * uv.y).sin_cos();
    DVec3::new(st * cp, st * sp, ct)
}

/// A picture's colour; it goes round along u and v: the rim of a mirror ball and the poles mix with the other end. Source: Cycles (suite
/// `path/world/hdri_mirror_ball`).
fn look(image: &FloatImage, uv: DVec2, linear: bool) -> Rgb {
    let (w, h) = (i64::from(image.width), i64::from(image.height));
    let at = |x: i64, y: i64| image.texels[(y.rem_euclid(h) * w + x.rem_euclid(w)) as usize];
    let (x, y) = (uv.x * w as f64, uv.y * h as f64);
    if !linear {
        return at(x.floor() as i64, y.floor() as i64);
    }
    let (x, y) = (x - 0.5, y - 0.5);
    let (fx, fy) = ((x - x.floor()) as f32, (y - y.floor()) as f32);
    let (x0, y0) = (x.floor() as i64, y.floor() as i64);
    at(x0, y0).lerp(at(x0 + 1, y0), fx).lerp(at(x0, y0 + 1).lerp(at(x0 + 1, y0 + 1), fx), fy)
}

/// POV-Ray's sky over its background, by the rules of language 3.7.
fn pov_sky(scene: &CompiledScene, dir: DVec3) -> Rgb {
    let Some(sky) = &scene.sky else { return scene.background.rgb };
    let t = &scene.geometry.transforms[sky.transform_ix as usize];
    let p = PatternPoint { point: t.inverse_point(dir), uv: DVec2::ZERO, world: dir, normal: DVec3::ZERO, ray_dir: dir };
    let (mut rgb, mut factor) = (Vec3::ZERO, Vec3::ONE);
    for ix in sky.pigments.iter().rev() {
        let Some(c) = eval_pigment(scene, *ix, &p) else { continue };
        rgb += c.rgb * c.opacity() * factor * sky.emission;
        factor *= c.transmittance();
    }
    rgb + factor * scene.background.rgb * (1.0 - scene.background.transmit)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_and_directions_are_each_others_inverse() {
        for (dir, uv) in [(DVec3::X, DVec2::new(0.5, 0.5)), (DVec3::Y, DVec2::new(0.25, 0.5)), (DVec3::NEG_Y, DVec2::new(0.75, 0.5))] {
            assert!((uv_of(dir) - uv).length() < 1e-12 && (direction_of(uv) - dir).length() < 1e-12);
        }
    }
}
