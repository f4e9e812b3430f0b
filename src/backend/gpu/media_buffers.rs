//! Media as words that `shaders/shared/media.wesl` reads, and what the shaders must know of them.

use super::buffers::{append, bits};
use super::layout::{Interior, MAX_INTERIORS, SceneParams};
use super::shader::ShaderOptions;
use super::support::scatters;
use super::texture_buffers::TextureWords;
use crate::backend::BackendError;
use crate::compile::{CompiledScene, Media};
use crate::integrate::classic::ScenePlan;
use crate::kernel::media::{MAX_INTERVAL_SAMPLES, extinction};
use crate::math::Vec3;

/// Words of a medium: name and length. The places of its densities follow.
const MEDIUM: &[(&str, u32)] = &[
    ("INTERVALS", 1),
    ("SAMPLES", 1),
    ("AA_LEVEL", 1),
    ("AA_THRESHOLD", 1),
    ("JITTER", 1),
    ("RATIO", 1),
    ("EXTINCTION", 3),
    ("EMISSION", 3),
    ("SCATTERING", 3),
    ("TYPE", 1),
    ("ECCENTRICITY", 1),
    ("TRANSFORM", 1),
    ("N_DENSITIES", 1),
];
/// Most places for samples of one ray, times lamps.
const MAX_POINTS: u64 = 1 << 22;

fn encode_medium(m: &Media, textures: &TextureWords, words: &mut Vec<u32>) -> u32 {
    let p = &m.params;
    let n = |v: f64| (v as f32).to_bits();
    let mut w =
        vec![p.intervals.max(1), p.samples.0.clamp(1, MAX_INTERVAL_SAMPLES), p.aa_level, n(p.aa_threshold), n(p.jitter), n(p.ratio)];
    for color in [extinction(p), p.emission, p.scattering] {
        w.extend(bits(color.to_array()));
    }
    w.extend([u32::from(p.scattering_type), n(p.eccentricity), m.transform_ix, m.densities.len() as u32]);
    debug_assert_eq!(w.len() as u32, MEDIUM.iter().map(|f| f.1).sum::<u32>(), "as the shader reads it");
    w.extend(m.densities.iter().map(|d| textures.pigments[*d as usize]));
    append(words, w)
}

/// Encodes all media and their lists: the air's, and those of the interiors.
pub(super) fn encode_media(
    scene: &CompiledScene,
    plan: &ScenePlan,
    textures: &TextureWords,
    words: &mut Vec<u32>,
    params: &mut SceneParams,
    interiors: &mut [Interior],
) {
    let places: Vec<u32> = scene.media.iter().map(|m| encode_medium(m, textures, words)).collect();
    let mut list = |media: &[u32]| match media {
        [] => 0,
        _ => append(words, std::iter::once(media.len() as u32).chain(media.iter().map(|m| places[*m as usize]))),
    };
    params.air_media_at = list(&scene.atmosphere);
    for (out, interior) in interiors.iter_mut().zip(&scene.interiors) {
        out.media_at = list(&interior.media);
    }
    params.global_lights_at = append(words, std::iter::once(plan.global_lights.len() as u32).chain(plan.global_lights.iter().copied()));
}

/// Features and constants. Gives the points that a ray's samples need in the table.
pub(super) fn media_options(scene: &CompiledScene, o: &mut ShaderOptions) -> Result<u32, BackendError> {
    let mut at = 0;
    for (name, len) in MEDIUM {
        o.constant(&format!("MEDIUM_{name}"), at);
        at += len;
    }
    o.constant("MEDIUM_LEN", at);
    let most = |of: fn(&Media) -> u32| scene.media.iter().map(of).max().unwrap_or(0);
    let of_interiors = scene.interiors.iter().map(|i| i.media.len()).max().unwrap_or(0) * MAX_INTERIORS;
    let levels = most(|m| m.params.aa_level).max(1);
    o.constant("MAX_MEDIA", of_interiors.min(scene.media.len() * MAX_INTERIORS).max(scene.atmosphere.len()).max(1) as u32);
    // As the shader tells them apart.
    let n_lights = scene.lights.iter().filter(|l| l.light.media_interaction && !l.light.shadowless).count();
    o.constant("MAX_MEDIA_LIGHTS", n_lights.max(1) as u32);
    o.constant("MEDIA_STACK", levels + 2);
    let is_lit = scatters(scene);
    let features = [
        ("media_light", is_lit),
        ("media_density", scene.media.iter().any(|m| !m.densities.is_empty())),
        ("media_shadows", scene.media.iter().any(|m| extinction(&m.params) != Vec3::ZERO)),
    ];
    features.iter().for_each(|(name, holds)| o.feature_if(name, *holds));
    let n_lights = n_lights as u64;
    let intervals = u64::from(most(|m| m.params.intervals)).max(2 * n_lights + 1);
    let places = u64::from(most(|m| m.params.samples.0.clamp(1, MAX_INTERVAL_SAMPLES)) / 2 + 1).max(2) * (1u64 << levels.min(32)) + 1;
    // A ray's piece goes through the air's media, then through those of what it is in.
    let n_calls = [!scene.atmosphere.is_empty(), of_interiors > 0].map(u64::from).iter().sum::<u64>();
    let of_call = intervals * places * n_lights;
    let points = if is_lit { n_calls * of_call } else { 0 };
    if points > MAX_POINTS {
        return Err(BackendError::Unsupported("media of millions of samples a ray".into()));
    }
    o.constant("MEDIA_POINTS", points as u32);
    o.constant("MEDIA_SECOND_AT", if n_calls > 1 { of_call as u32 } else { 0 });
    Ok(points as u32)
}
