//! Patterns made of noise, and waves. Source: spec/textures.md, section 2 (measured).

use super::cycloidal;
use crate::compile::texture::PatternNode;
use crate::math::DVec3;
use crate::math::noise::{noise_doublings, turbulence_vector};

/// Six octaves of folded noise.
pub fn granite(p: DVec3, generator: u8) -> f64 {
    let (mut sum, mut scale) = (0.0, 1.0);
    for n in noise_doublings::<6>(p * 4.0, generator) {
        let folded = if generator > 1 { (1.0 - 2.0 * n).abs().min(0.5) } else { (0.5 - n).abs() };
        sum += folded / scale;
        scale *= 2.0;
    }
    sum
}

/// Ten octaves, each clamped.
pub fn wrinkles(p: DVec3, generator: u8) -> f64 {
    let (mut sum, mut scale) = (0.0, 1.0);
    for n in noise_doublings::<10>(p, generator) {
        sum += if generator > 1 { (2.0 * n - 0.5).clamp(0.0, 1.0) } else { n } / scale;
        scale *= 2.0;
    }
    sum / 2.0
}

/// Rings about z, displaced by turbulence in its own way.
pub fn wood(node: &PatternNode, p: DVec3) -> f64 {
    let t = node.turb_amount;
    if t == DVec3::ZERO {
        return (p.x * p.x + p.y * p.y).sqrt();
    }
    let d = turbulence_vector(p, node.turb.octaves, node.turb.omega, node.turb.lambda);
    let x = p.x + cycloidal((p.x + d.x) * t.x);
    let y = p.y + cycloidal((p.y + d.y) * t.y);
    (x * x + y * y).sqrt()
}

/// Mean of circular waves from the sources.
pub fn ripples(sources: &[(DVec3, f64)], p: DVec3, frequency: f64, phase: f64) -> f64 {
    let sum: f64 = sources.iter().map(|(s, _)| cycloidal(distance(p, *s) * frequency + phase)).sum();
    0.5 * (1.0 + sum / sources.len() as f64)
}

/// The same with a frequency and an amplitude of its own for every source.
pub fn waves(sources: &[(DVec3, f64)], p: DVec3, frequency: f64, phase: f64) -> f64 {
    let sum: f64 = sources.iter().map(|(s, f)| cycloidal(distance(p, *s) * frequency * f + phase) / f).sum();
    0.2 * (2.5 + sum / sources.len() as f64)
}

/// Distance to a source, 1 when there.
pub fn distance(p: DVec3, source: DVec3) -> f64 {
    let d = (p - source).length();
    if d == 0.0 { 1.0 } else { d }
}
