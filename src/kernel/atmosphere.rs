//! Fog and rainbows: what they do to a colour seen over a distance. Skies stand in `sky.rs`, media in `media.rs`.
//! Source: spec/light.md, section 5.

use crate::math::{DVec3, EPSILON, Ray, Rgb, Rgbft, Vec3};
use crate::scene::{Fog, Rainbow};

/// Depth that fog, media and rainbows see where a ray hits nothing.
pub const BACKGROUND_DEPTH: f64 = 2e10;

/// What fogs do over one piece of ray: `out = color + factor * behind`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FogEffect {
    /// Own light.
    pub color: Rgb,
    /// Transparency.
    pub factor: Rgb,
}

impl FogEffect {
    /// No fog.
    pub const NONE: FogEffect = FogEffect { color: Vec3::ZERO, factor: Vec3::ONE };
}

/// All fogs over `0..depth` of `ray`. `turbulence(fog, p)` gives scalar turbulence of the fog's octaves at `p`.
pub fn fog_effect(fogs: &[Fog], ray: &Ray, depth: f64, turbulence: impl Fn(&Fog, DVec3) -> f64) -> FogEffect {
    let mut out = FogEffect::NONE;
    for fog in fogs.iter().rev() {
        if fog.distance.abs() < EPSILON {
            continue;
        }
        let mut d = depth;
        if let Some((turb, turb_depth)) = &fog.turbulence {
            let k = (-depth / fog.distance).exp();
            let mid = ray.at(0.5 * depth) * turb.amount;
            d *= 1.0 - k * (turbulence(fog, mid) * turb_depth).min(1.0);
        }
        let density = fog.ground.map_or(1.0, |(offset, alt)| ground_density(fog, offset, alt, ray, depth));
        let att = ((-d * density / fog.distance).exp()).max(f64::from(fog.color.transmit)) as f32;
        let (filter, rgb) = (fog.color.filter, fog.color.rgb);
        out.factor *= att * (Vec3::splat(1.0 - filter) + filter * rgb);
        out.color += (1.0 - att) * rgb;
    }
    out
}

/// Mean density of a ground fog over the piece of ray.
fn ground_density(fog: &Fog, offset: f64, alt: f64, ray: &Ray, depth: f64) -> f64 {
    let height = |p: DVec3| (p.dot(fog.up) - offset) / alt;
    let (s, e) = (height(ray.origin), height(ray.at(depth)));
    if s <= 0.0 {
        if e <= 0.0 { 1.0 } else { (e.atan() - s) / (e - s) }
    } else if e <= 0.0 {
        (s.atan() - e) / (s - e)
    } else if (s - e).abs() < EPSILON {
        1.0 / (s * s + 1.0)
    } else {
        (s.atan() - e.atan()) / (s - e)
    }
}

/// All rainbows over a colour seen along unit `dir`; `None` when the ray meets none. Gives colour and the factor on its transmit.
///
/// `draw` gives the next random number (for jittered bows only), `color_map(bow, index)` the bow's colour.
pub fn rainbow_effect(
    bows: &[Rainbow],
    dir: DVec3,
    depth: f64,
    behind: Rgb,
    mut draw: impl FnMut() -> f64,
    color_map: impl Fn(&Rainbow, f64) -> Rgbft,
) -> Option<(Rgb, f32)> {
    let (mut sum, mut n, mut transmit) = (Vec3::ZERO, 0u32, 1.0f32);
    // The last declared comes first: it draws its jitter first.
    for bow in bows.iter().rev() {
        if bow.distance == 0.0 || bow.width_rad == 0.0 {
            continue;
        }
        let right = bow.up.cross(bow.direction).try_normalize().unwrap_or(DVec3::X);
        let (x, y) = (dir.dot(right), dir.dot(bow.up));
        let len = x.hypot(y);
        let angle = if len > EPSILON { (y / len).clamp(-1.0, 1.0).acos() } else { 0.0 };
        let half_arc = bow.arc_rad.map_or(f64::INFINITY, |a| 0.5 * a);
        let cos = dir.dot(bow.direction);
        if angle > half_arc || cos < 0.0 {
            continue;
        }
        let start = bow.angle_rad - 0.5 * bow.width_rad;
        let mut index = (cos.clamp(-1.0, 1.0).acos() - start) / bow.width_rad;
        if bow.jitter != 0.0 {
            index += (2.0 * draw() - 1.0) * bow.jitter;
        }
        if !(0.0..=1.0 - EPSILON).contains(&index) {
            continue;
        }
        let c = color_map(bow, index);
        let half_falloff = 0.5 * bow.falloff_rad;
        let fade = if half_arc - half_falloff > 0.0 && half_arc.is_finite() && angle > half_falloff {
            super::light::smoothstep(0.0, 1.0, (angle - half_falloff) / (half_arc - half_falloff))
        } else {
            0.0
        };
        let floor = fade * f64::from(1.0 - c.transmit) + f64::from(c.transmit);
        let k = (-depth / bow.distance).exp().max(floor) as f32;
        let f = c.filter * (1.0 - k);
        sum += k * behind * (Vec3::splat(1.0 - f) + f * c.rgb) + (1.0 - k) * c.rgb;
        transmit *= k * c.transmit;
        n += 1;
    }
    (n > 0).then(|| (sum / n as f32, transmit))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fog(distance: f64) -> Fog {
        Fog { color: Rgbft::rgb(0.5, 0.6, 0.7), distance, ground: None, up: DVec3::Y, turbulence: None }
    }

    #[test]
    fn constant_fog_weakens_by_e_at_its_distance() {
        let ray = Ray::new(DVec3::ZERO, DVec3::X);
        let e = fog_effect(&[fog(10.0)], &ray, 10.0, |_, _| 0.0);
        let t = (-1f32).exp();
        assert!((e.factor - Vec3::splat(t)).length() < 1e-6);
        assert!((e.color - (1.0 - t) * Vec3::new(0.5, 0.6, 0.7)).length() < 1e-6);
    }

    #[test]
    fn several_fogs_multiply_what_is_behind_and_add_their_own_light() {
        let ray = Ray::new(DVec3::ZERO, DVec3::X);
        let one = fog_effect(&[fog(10.0)], &ray, 10.0, |_, _| 0.0);
        let two = fog_effect(&[fog(10.0), fog(10.0)], &ray, 10.0, |_, _| 0.0);
        assert!((two.factor - one.factor * one.factor).length() < 1e-6);
        assert!((two.color - 2.0 * one.color).length() < 1e-6);
    }

    #[test]
    fn ground_fog_is_full_below_its_offset_and_an_arctangent_above() {
        let f = Fog { ground: Some((0.0, 2.0)), ..fog(10.0) };
        let below = fog_effect(std::slice::from_ref(&f), &Ray::new(DVec3::new(0.0, -1.0, 0.0), DVec3::X), 10.0, |_, _| 0.0);
        assert!((below.factor.x - (-1f32).exp()).abs() < 1e-6);
        // From height 0 straight up to 2 (one alt): mean density atan(1)/1.
        let up = fog_effect(&[f], &Ray::new(DVec3::ZERO, DVec3::Y), 2.0, |_, _| 0.0);
        let want = (-0.2 * std::f64::consts::FRAC_PI_4).exp() as f32;
        assert!((up.factor.x - want).abs() < 1e-6);
    }
}
