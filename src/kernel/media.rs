//! Media without rays: phase functions, the pieces of a ray that beams light, sample intervals, stop thresholds.
//! The sampling itself, which asks for densities and shadows, stands in `integrate/classic/media`. Source: spec/light.md, section 7.

use crate::compile::LightBeam;
use crate::math::statistics::chi_square_point;
use crate::math::{Ray, Rgb};
use crate::scene::light::LightKind;
use crate::scene::{Light, Media};

/// How much a medium scatters from a light to the eye. `cos` is ray·light: 1 when looking towards the light.
pub fn phase_value(kind: u8, eccentricity: f64, cos: f64) -> f64 {
    match kind {
        2 => 0.576_655_375 * (1.0 + 9.0 * (0.5 * (1.0 + cos)).powi(8)),
        3 => 0.495_714_547 * (1.0 + 50.0 * (0.5 * (1.0 + cos)).powi(32)),
        4 => 0.799_372_013 * (1.0 + cos * cos),
        5 => {
            let g = eccentricity;
            let d = 1.0 + g * g - 2.0 * g * cos;
            (1.0 - g * g) / (d * d.sqrt())
        }
        _ => 1.0,
    }
}

/// Extinction of a medium at density 1.
pub fn extinction(m: &Media) -> Rgb {
    m.absorption + m.extinction as f32 * m.scattering
}

/// The piece of `0..depth` that a light's beam reaches, if any.
pub fn beam_piece(light: &Light, beam: &LightBeam, ray: &Ray, depth: f64) -> Option<(f64, f64)> {
    let v = ray.origin - light.location;
    let axis = beam.axis;
    let (along, per_t) = (v.dot(axis), ray.dir.dot(axis));
    // Inside is where `sign` times a t² + 2 b t + c is not negative, in front of the light.
    let (a, b, c, sign) = match light.kind {
        LightKind::Spot { falloff_rad, .. } if falloff_rad < std::f64::consts::FRAC_PI_2 && !light.parallel => {
            let cos_sq = beam.cos_falloff * beam.cos_falloff;
            let c = along * along - cos_sq * v.length_squared();
            (per_t * per_t - cos_sq, along * per_t - cos_sq * v.dot(ray.dir), c, 1.0)
        }
        LightKind::Cylinder { falloff, .. } => {
            let c = v.length_squared() - along * along - falloff * falloff;
            (1.0 - per_t * per_t, v.dot(ray.dir) - along * per_t, c, -1.0)
        }
        _ => return Some((0.0, depth)),
    };
    let inside = |t: f64| along + t * per_t > 0.0 && sign * ((a * t + 2.0 * b) * t + c) >= 0.0;
    let roots = quadratic(a, b, c);
    // Beams are convex: between the surfaces' roots and the plane of the light the ray is in or out.
    let far = depth.min(1e7);
    let mut cuts = [0.0, roots[0], roots[1], -along / per_t, far];
    for c in &mut cuts {
        *c = if c.is_finite() { c.clamp(0.0, far) } else { 0.0 };
    }
    cuts.sort_unstable_by(f64::total_cmp);
    let mut piece: Option<(f64, f64)> = None;
    for w in cuts.windows(2) {
        if w[1] > w[0] && inside(0.5 * (w[0] + w[1])) {
            piece = Some((piece.map_or(w[0], |p| p.0), w[1]));
        }
    }
    piece.filter(|p| p.1 > 1e-3)
}

/// Roots of a t² + 2 b t + c; NaN where there are none.
fn quadratic(a: f64, b: f64, c: f64) -> [f64; 2] {
    if a.abs() < 1e-12 {
        return [-0.5 * c / b, f64::NAN];
    }
    let s = (b * b - a * c).sqrt();
    [(-b - s) / a, (-b + s) / a]
}

/// One interval of a ray in which a medium is sampled.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct SampleInterval {
    /// Some beam may reach it.
    pub lit: bool,
    /// Depth of its start.
    pub start: f64,
    /// Length.
    pub length: f64,
}

/// Cuts `0..depth` at the ends of the lit pieces and those into sample intervals.
///
/// `starts` and `ends` are those of the lights' pieces in any order; both are sorted apart from each other, as the program does. `pieces` is scratch memory.
pub fn sample_intervals(
    rule: &Media,
    has_density: bool,
    depth: f64,
    starts: &mut [f64],
    ends: &mut [f64],
    pieces: &mut Vec<SampleInterval>,
    out: &mut Vec<SampleInterval>,
) {
    out.clear();
    pieces.clear();
    starts.sort_unstable_by(f64::total_cmp);
    ends.sort_unstable_by(f64::total_cmp);
    // Lit pieces, overlapping ones joined, with unlit gaps between and at both ends.
    let mut at = 0.0;
    let add = |lit: bool, a: f64, b: f64, pieces: &mut Vec<SampleInterval>| {
        if b > a {
            pieces.push(SampleInterval { lit, start: a, length: b - a });
        }
    };
    for (s, e) in starts.iter().zip(ends.iter()) {
        match pieces.last_mut() {
            Some(last) if last.lit && *s <= last.start + last.length => {
                last.length = last.length.max(e - last.start);
            }
            _ => {
                add(false, at, *s, pieces);
                add(true, *s, *e, pieces);
            }
        }
        at = pieces.last().map_or(at, |l| l.start + l.length);
    }
    add(false, at, depth, pieces);
    let n_pieces = pieces.len();
    if n_pieces == 0 {
        return;
    }
    let wanted = (rule.intervals.max(1) as usize).max(n_pieces);
    if n_pieces == 1 {
        let n = if !pieces[0].lit && !has_density { 1 } else { wanted };
        cut(pieces[0], n, out);
        return;
    }
    let weight = |p: &SampleInterval| if p.lit { rule.ratio } else { 1.0 - rule.ratio };
    let sum: f64 = pieces.iter().map(weight).sum();
    let mut left = wanted;
    for (i, p) in pieces.iter().enumerate() {
        let share = (weight(p) / sum * wanted as f64).floor() as usize + 1;
        let n = share.min((left + i + 1).saturating_sub(n_pieces)).max(1);
        left = left.saturating_sub(n);
        cut(*p, n, out);
    }
}

/// An interval for what rounding leaves at the end : next to nothing in length, but it draws random numbers (measured).
pub fn add_missing_end(depth: f64, out: &mut Vec<SampleInterval>) {
    let Some(last) = out.last() else { return };
    let n = out.iter().rev().take_while(|i| i.length == last.length && i.lit == last.lit).count();
    let first = out[out.len() - n];
    let end = first.start + n as f64 * first.length;
    if end < depth {
        out.push(SampleInterval { lit: false, start: end, length: depth - end });
    }
}

fn cut(p: SampleInterval, n: usize, out: &mut Vec<SampleInterval>) {
    let length = p.length / n as f64;
    out.extend((0..n).map(|k| SampleInterval { lit: p.lit, start: p.start + k as f64 * length, length }));
}

/// Most samples that one interval may take, whatever the scene asks for.
pub const MAX_INTERVAL_SAMPLES: u32 = 1 << 16;

/// By number of samples less 1: the variance from which another sample is taken (methods 1 and 2).
pub fn stop_thresholds(m: &Media) -> Vec<f64> {
    let max = m.samples.1.min(MAX_INTERVAL_SAMPLES);
    if m.method == 3 || max <= m.samples.0 {
        return Vec::new();
    }
    if max <= 1 {
        return vec![0.0];
    }
    let t = m.variance / chi_square_point(m.confidence, max - 1);
    (1..=max).map(|i| t * chi_square_point(m.confidence, i)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{DVec3, Vec3};

    #[test]
    fn phase_functions_are_normalised_or_isotropic() {
        // Mean over the sphere: 1 for POV-Ray's scaling of all but the constants' last digits.
        for kind in [1, 4, 5] {
            let n = 20_000;
            let mean: f64 =
                (0..n).map(|k| phase_value(kind, 0.4, 2.0 * (f64::from(k) + 0.5) / f64::from(n) - 1.0)).sum::<f64>() / f64::from(n);
            assert!((mean - 1.0).abs() < 0.07, "kind {kind}: {mean}");
        }
    }

    #[test]
    fn spot_lights_the_part_of_a_ray_inside_its_cone() {
        let kind = LightKind::Spot { radius_rad: 0.3, falloff_rad: 45f64.to_radians(), tightness: 0.0 };
        let light = Light { kind, point_at: DVec3::NEG_Y, ..Light::point(DVec3::ZERO, Vec3::ONE) };
        let (a, b) =
            beam_piece(&light, &LightBeam::new(&light), &Ray::new(DVec3::new(-5.0, -2.0, 0.0), DVec3::X), 100.0).expect("crosses the cone");
        assert!((a - 3.0).abs() < 1e-9 && (b - 7.0).abs() < 1e-9, "{a} {b}");
        assert!(
            beam_piece(&light, &LightBeam::new(&light), &Ray::new(DVec3::new(-5.0, 2.0, 0.0), DVec3::X), 100.0).is_none(),
            "behind the light"
        );
        let (a, b) = beam_piece(&light, &LightBeam::new(&light), &Ray::new(DVec3::new(0.0, -1.0, 0.0), DVec3::NEG_Y), 100.0)
            .expect("along the axis");
        assert_eq!((a, b), (0.0, 100.0));
    }

    #[test]
    fn cylinder_lights_the_part_of_a_ray_inside_it() {
        let kind = LightKind::Cylinder { radius: 1.0, falloff: 2.0, tightness: 0.0 };
        let light = Light { kind, point_at: DVec3::NEG_Y, ..Light::point(DVec3::ZERO, Vec3::ONE) };
        let (a, b) =
            beam_piece(&light, &LightBeam::new(&light), &Ray::new(DVec3::new(-5.0, -2.0, 0.0), DVec3::X), 6.0).expect("crosses the beam");
        assert!((a - 3.0).abs() < 1e-9 && (b - 6.0).abs() < 1e-9);
    }

    #[test]
    fn intervals_cover_the_ray_and_lit_pieces_get_most_of_them() {
        let rule = Media { intervals: 12, ..Media::default() };
        let (mut pieces, mut out) = (Vec::new(), Vec::new());
        sample_intervals(&rule, true, 10.0, &mut [4.0], &mut [6.0], &mut pieces, &mut out);
        assert!((out.iter().map(|i| i.length).sum::<f64>() - 10.0).abs() < 1e-12);
        assert_eq!((out.len(), out.iter().filter(|i| i.lit).count()), (12, 9));
        sample_intervals(&rule, false, 10.0, &mut [], &mut [], &mut pieces, &mut out);
        assert_eq!(out, [SampleInterval { lit: false, start: 0.0, length: 10.0 }]);
        sample_intervals(&rule, false, 10.0, &mut [0.0, 0.0], &mut [10.0, 10.0], &mut pieces, &mut out);
        assert_eq!(out.len(), 12);
    }
}
