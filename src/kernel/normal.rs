//! Bumps: perturbation of normals. Source: spec/textures.md, section 3 (measured).

use super::PatternPoint;
use super::image::bump_normal;
use super::pattern::noisy::distance;
use super::pattern::{cells, cycloidal, simple, value_at_warped};
use super::pigment::neighbours;
use super::warp::warp_by;
use crate::compile::texture::{NormalCode, NormalIx, NormalNode, PatternCode, PatternIx, PatternNode, Range};
use crate::compile::{CompiledScene, NONE};
use crate::math::DVec3;
use crate::math::noise::{noise, noise_vector};

/// Directions of the four samples.
const TETRAHEDRON: [DVec3; 4] = [
    DVec3::new(0.942_809_041, -0.333_333_333, 0.0),
    DVec3::new(-0.471_404_521, -0.333_333_333, 0.816_496_581),
    DVec3::new(-0.471_404_521, -0.333_333_333, -0.816_496_581),
    DVec3::new(0.0, 1.0, 0.0),
];

/// A normal bent by `normal`, in the space that `at.point` stands in. Unit, unless the normal says `no_bump_scale`.
pub fn perturb_normal(scene: &CompiledScene, normal: NormalIx, n: DVec3, at: &PatternPoint) -> DVec3 {
    let node = &scene.textures.normals[normal as usize];
    let pattern = &scene.textures.patterns[node.pattern as usize];
    let start = if node.uv_mapping { DVec3::new(at.uv.x, at.uv.y, 0.0) } else { at.point };
    let p = warp_by(scene, pattern, start);
    let unit = |v: DVec3| if node.no_bump_scale { v } else { v.try_normalize().unwrap_or(v) };
    let transform = (pattern.transform_ix != NONE).then(|| &scene.textures.transforms[pattern.transform_ix as usize]);
    let mut n = unit(n);
    if let Some(t) = transform {
        n = unit(t.inverse_normal(n));
    }
    let inner = PatternPoint { point: p, ..*at };
    n = match node.code {
        NormalCode::Map(range) => match neighbours(range.of(&scene.textures.normal_entries), value_at_warped(scene, pattern, p, &inner)) {
            (a, None) => perturb_normal(scene, a, n, &inner),
            (a, Some((b, share))) => {
                let (a, b) = (perturb_normal(scene, a, n, &inner), perturb_normal(scene, b, n, &inner));
                a * (1.0 - share) + b * share
            }
        },
        NormalCode::Average(range) => {
            let (mut sum, mut weight) = (DVec3::ZERO, 0.0);
            for (w, child) in range.of(&scene.textures.normal_entries) {
                sum += f64::from(*w) * perturb_normal(scene, *child, n, &inner);
                weight += f64::from(*w);
            }
            sum / weight
        }
        NormalCode::Bump(image) => bump_normal(&scene.textures.images[image as usize], node.amount, n, p),
        NormalCode::Pattern(slopes) => by_pattern(scene, node, pattern, slopes, n, p, &inner),
    };
    n = unit(n);
    if let Some(t) = transform {
        n = unit(t.normal(n));
    }
    n
}

/// A normal taken into a pattern's space, as patterned textures do for their children; not normalised.
pub fn normal_into_pattern(scene: &CompiledScene, pattern: PatternIx, n: DVec3) -> DVec3 {
    match scene.textures.patterns[pattern as usize].transform_ix {
        NONE => n,
        ix => scene.textures.transforms[ix as usize].inverse_normal(n),
    }
}

/// The way back from [`normal_into_pattern`].
pub fn normal_out_of_pattern(scene: &CompiledScene, pattern: PatternIx, n: DVec3) -> DVec3 {
    match scene.textures.patterns[pattern as usize].transform_ix {
        NONE => n,
        ix => scene.textures.transforms[ix as usize].normal(n),
    }
}

fn by_pattern(
    scene: &CompiledScene,
    node: &NormalNode,
    pattern: &PatternNode,
    slopes: Range,
    n: DVec3,
    p: DVec3,
    at: &PatternPoint,
) -> DVec3 {
    let (amount, generator) = (node.amount, pattern.noise_generator);
    let sources = &scene.textures.wave_sources;
    let waves = |wave: &dyn Fn(f64, f64) -> f64| {
        sources.iter().fold(n, |n, (source, f)| {
            let len = distance(p, *source);
            n + amount * wave(len, *f) / (len * sources.len() as f64) * (p - *source)
        })
    };
    match pattern.code {
        PatternCode::Bumps => n + amount * noise_vector(p),
        PatternCode::Dents => {
            let v = noise(p, generator);
            n + amount * v * v * v * noise_vector(p)
        }
        PatternCode::Wrinkles => {
            let (mut sum, mut scale) = (DVec3::ZERO, 1.0);
            for _ in 0..10 {
                sum += noise_vector(p * scale).abs() / scale;
                scale *= 2.0;
            }
            n + amount * sum
        }
        PatternCode::Ripples => waves(&|len, _| cycloidal(len * pattern.frequency + pattern.phase)),
        PatternCode::Waves => waves(&|len, f| cycloidal(len * pattern.frequency * f + pattern.phase) / f),
        PatternCode::Quilted { control0, control1 } => {
            let (q, s) = simple::quilt(p, control0, control1);
            n + amount * s * q
        }
        PatternCode::Facets { coords, size, metric } => {
            let size = size.max(1e-6);
            match coords {
                None => cells::nearest_facet(n / size, metric),
                Some(c) => {
                    let e = noise_vector(cells::nearest_facet(p / size, metric));
                    // A normal that `no_bump_scale` left long is made unit here all the same (measured).
                    let n = n.try_normalize().unwrap_or(n);
                    n + c * (e - n * e.dot(n))
                }
            }
        }
        _ => {
            let delta = node.accuracy;
            let slope_map = slopes.of(&scene.textures.slope_entries);
            let strength = amount * -5.0 * (0.02 / delta);
            TETRAHEDRON.iter().fold(n, |n, dir| {
                let mut v = value_at_warped(scene, pattern, p + delta * *dir, at);
                if !slope_map.is_empty() {
                    v = slope_height(slope_map, v);
                }
                n + v * strength * *dir
            })
        }
    }
}

/// Height of a slope map: Hermite between entries, the end's height outside.
fn slope_height(entries: &[(f32, [f32; 2])], value: f64) -> f64 {
    let wide = |e: [f32; 2]| e.map(f64::from);
    match neighbours(entries, value) {
        (a, None) => f64::from(a[0]),
        (a, Some((b, u))) => {
            let ([h0, s0], [h1, s1]) = (wide(a), wide(b));
            let (u2, u3) = (u * u, u * u * u);
            h0 * (2.0 * u3 - 3.0 * u2 + 1.0) + h1 * (3.0 * u2 - 2.0 * u3) + s0 * (u3 - 2.0 * u2 + u) + s1 * (u3 - u2)
        }
    }
}
